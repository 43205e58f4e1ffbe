# SPDX-License-Identifier: MIT OR Apache-2.0
"""A shoe off its symmetry plane keeps its load, whatever the gap below it."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

import mtb_rs as mtb


@pytest.mark.parametrize(("lateral", "yaw"), [(0.0, 0.0), (2e-3, 0.0), (-2e-3, 0.0), (0.2e-3, 1e-3)])
def test_all_of_the_load_arrives(lateral: float, yaw: float) -> None:
    scene = mtb.scenes.pole_shoe_on_rail(height=20e-3, spacing=(6e-3, 5.2e-3), lateral=lateral, yaw=yaw)
    result = scene.solve(model="elastic-upper")
    strip = 2 * 0.09 * (21.6e-3 - 6e-3)
    assert -result.force[2] == pytest.approx(3e6 * strip, rel=2e-3)
    # each pole carries its own share
    vertical = result.pressure * result.area * result.normal[2]
    left, right = (float(patch.view(vertical).sum()) for patch in result.patches)
    assert left == pytest.approx(right, rel=0.01)


def test_mirrored_offsets_give_mirrored_poles() -> None:
    left, right = (
        mtb.scenes.pole_shoe_on_rail(height=20e-3, spacing=(6e-3, 5.2e-3), lateral=lateral).solve(
            model="elastic-upper"
        )
        for lateral in (1e-3, -1e-3)
    )
    # so are their meshes
    for own, twin in zip(left.patches, reversed(right.patches), strict=True):
        p, q = own.view(left.pressure), twin.view(right.pressure)[::-1]
        assert np.linalg.norm(p - q) < 1e-4 * np.linalg.norm(p)


def test_a_shoe_hardly_aside_is_a_centred_one() -> None:
    centred, aside = (
        mtb.scenes.pole_shoe_on_rail(height=20e-3, spacing=(6e-3, 5.2e-3), lateral=lateral).solve(
            model="elastic-upper"
        )
        for lateral in (0.0, 1e-9)
    )
    # the right pole is then condensed on its own, and not the image of the left one
    assert np.linalg.norm(centred.pressure - aside.pressure) < 1e-2 * np.linalg.norm(centred.pressure)


@pytest.mark.parametrize("scene", [mtb.scenes.pole_shoe_on_rail, mtb.scenes.block_on_plane])
@pytest.mark.slow
def test_a_reversed_slide_gives_the_mirror_image(scene: Callable[..., mtb.Scene]) -> None:
    # an odd and an even number of cells along x
    for spacing in (6e-3, 90e-3 / 14):
        ahead, back = (
            scene(spacing=spacing, sliding_direction=direction).solve(model="elastic-upper")
            for direction in ((1, 0), (-1, 0))
        )
        patch = ahead.patches[0]
        p, q = (patch.view(r.pressure.reshape(-1)) for r in (ahead, back))
        np.testing.assert_allclose(p, q[:, ::-1], rtol=0, atol=1e-9 * p.max())


@pytest.mark.coarse
def test_a_reversed_slide_on_an_elastic_rail_gives_the_mirror_image() -> None:
    ahead, back = (
        mtb.scenes.pole_shoe_on_rail(spacing=(6e-3, 5.2e-3), sliding_direction=direction).solve(
            model="elastic-both"
        )
        for direction in ((1, 0), (-1, 0))
    )
    p, q = (r.patches[0].view(r.pressure) for r in (ahead, back))
    np.testing.assert_allclose(p, q[:, ::-1], rtol=0, atol=1e-9 * p.max())
