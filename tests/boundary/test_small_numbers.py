# SPDX-License-Identifier: MIT OR Apache-2.0
"""Small numbers that would make huge arrays, and files that hold too much, are refused before work starts."""

from __future__ import annotations

import struct
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import mtb_rs as mtb
from mtb_rs.bodies import mesh_files, surfaces
from mtb_rs.contact import estimate

SIDES = [1e-7, (1e-9, 1e-4), (1e-4, 1e-9)]
MAKE: dict[str, Callable[[Any], Any]] = {
    "block": lambda s: mtb.scenes.block_on_plane(spacing=s).solve("half-space"),
    "shoe": lambda s: mtb.scenes.pole_shoe_on_rail(spacing=s).solve("half-space"),
    "paraboloid": lambda s: mtb.scenes.paraboloid_on_plane().with_(spacing=s).solve(),
    "wheel": lambda s: mtb.scenes.wheel_on_rail(spacing=s).solve(),
    "wheel's gap": lambda s: mtb.wheel_on_rail_gap(spacing=s),
    "surfaces": lambda s: mtb.surface_gap(
        mtb.BodySurface.plane(), mtb.BodySurface.paraboloid(0.1), (-0.01, 0.01), (-0.01, 0.01), s
    ),
}


@pytest.mark.parametrize("spacing", SIDES, ids=str)
@pytest.mark.parametrize("name", MAKE)
def test_a_spacing_far_too_small_is_refused_with_its_value(name: str, spacing: Any) -> None:
    with pytest.raises(ValueError, match="spacing") as refused:
        MAKE[name](spacing)
    assert "cells" in str(refused.value) or "points" in str(refused.value)


def test_a_wheel_s_gap_says_how_many_points_it_would_take() -> None:
    with pytest.raises(ValueError, match=r"takes 17\d+ x 54\d+ points .* at most 10000000 .* larger spacing"):
        mtb.wheel_on_rail_gap(spacing=1e-6)


def stl(path: Path, count: int) -> Path:
    """A binary file of so many triangles, all of them nothing: only its size is true."""
    with path.open("wb") as stream:
        stream.write(bytes(80) + struct.pack("<I", count))
        stream.truncate(84 + 50 * count)
    return path


def test_too_many_triangles_are_refused_before_they_are_read(tmp_path: Path) -> None:
    path = stl(tmp_path / "scan.stl", 1_200_000)
    for most, read in (
        (mesh_files.MOST_GIVEN, lambda: mtb.ElasticBody.from_mesh(path, mtb.steel)),
        (surfaces.MOST_TRIANGLES, lambda: mtb.BodySurface.from_file(path, unit="mm")),
    ):
        with pytest.raises(ValueError, match=f"has 1200000 triangles: at most {most} are taken; thin it out"):
            read()
    text = path.with_suffix(".obj")
    with text.open("wb") as stream:
        stream.truncate(400_000_000)
    with pytest.raises(ValueError, match="enough for 1000000 triangles; thin it out first"):
        mtb.BodySurface.from_file(text, unit="mm")


def test_so_are_those_of_surfaces_that_are_given() -> None:
    many = np.zeros((surfaces.MOST_TRIANGLES + 1, 3), dtype=int)
    with pytest.raises(ValueError, match="at most 1000000 are taken"):
        mtb.BodySurface.mesh(np.eye(3), many)
    with pytest.raises(ValueError, match="at most 300000 are taken"):
        mesh_files.filled(np.eye(3), many)


@pytest.mark.parametrize("are_cells", [(True, True), (True, False), (False, True), (False, False)])
def test_averages_over_coarse_points_are_integrals(are_cells: tuple[bool, bool]) -> None:
    coarse, fine = np.linspace(-1.0, 1.3, 6), np.linspace(-0.9, 1.2, 17)
    found = estimate._averaging(coarse, fine, are_cells)

    def functions(points: np.ndarray, at: np.ndarray, are_cells: bool) -> np.ndarray:
        step, apart = points[1] - points[0], np.abs(at - points[:, None])
        return (apart < 0.5 * step).astype(float) if are_cells else np.maximum(1.0 - apart / step, 0.0)

    ends = [
        p + np.array([[-0.5], [0.5]]) * (p[1] - p[0]) * c
        for p, c in zip((coarse, fine), are_cells, strict=True)
    ]
    low, high = max(e.min() for e in ends), min(e.max() for e in ends)
    at = low + (high - low) * (np.arange(40_000) + 0.5) / 40_000
    tested = functions(coarse, at, are_cells[0])
    wanted = tested @ functions(fine, at, are_cells[1]).T / tested.sum(axis=1, keepdims=True)
    np.testing.assert_allclose(found, wanted, atol=2e-3)
