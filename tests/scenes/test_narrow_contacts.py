# SPDX-License-Identifier: MIT OR Apache-2.0
"""Contacts narrower than the cells: what they carry is known, their pressure is not."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import mtb_rs as mtb
from mtb_rs.bodies.mesh import block_mesh

STEEL = mtb.steel
#: Of two like half-spaces, of which each gives way as much [Pa].
MODULUS = 0.5 * STEEL.plane_strain_modulus
BLOCK = block_mesh(np.linspace(-0.04, 0.04, 9), np.linspace(-0.02, 0.02, 9), 0.02, halved=False, clamped=True)


def ball(cell: float, force: float, radius: float, shift: float) -> tuple[mtb.Scene, float]:
    """Half-spaces, a sphere's gap; and Hertz' largest pressure."""
    x = cell * (np.arange(12) - 6 + shift)
    scene = mtb.Scene(
        upper=STEEL,
        lower=STEEL,
        gap=(x[None] ** 2 + x[:, None] ** 2) / 2.0 / radius,
        spacing=cell,
        friction=0.2,
        force=force,
    )
    half = np.cbrt(0.75 * force * radius / MODULUS)
    return scene, 1.5 * force / (np.pi * half**2)


def cylinder(cell: float, force: float, radius: float, shift: float) -> tuple[mtb.Scene, float]:
    """A block of one's own on a cylinder along x; and Hertz' largest pressure."""
    body = mtb.ElasticBody(BLOCK, STEEL, "contact", [mtb.Support("top", 0, 0, mtb.Guide(-force))])
    scene = mtb.Scene(
        upper=body,
        lower=mtb.HalfSpace(STEEL),
        gap=lambda x, y: (y - shift * cell) ** 2 / 2.0 / radius,
        spacing=cell,
        friction=0.0,
    )
    return scene, float(np.sqrt(force / 0.08 * MODULUS / (np.pi * radius)))


@pytest.mark.filterwarnings("ignore")
@pytest.mark.parametrize("made", [ball, cylinder])
@pytest.mark.parametrize("shift", [0.0, 0.3, 0.5])
@pytest.mark.parametrize(("cell", "force", "radius"), [(4e-3, 5e3, 0.02), (5e-3, 1e2, 0.1), (6e-3, 1e4, 0.3)])
def test_an_unresolved_contact_is_not_said_to_be_good(
    made: Any, cell: float, force: float, radius: float, shift: float
) -> None:
    scene, peak = made(cell, force, radius, shift)
    result = scene.solve(tolerance=0.9)
    assert result.pressure.max() < 0.5 * peak
    estimates = result.report.error_estimates
    assert not estimates or estimates["pressure"] >= 1.0
    assert "points wide along" in result.report.missed
    assert " mm" not in result.report.missed  # which cells would do cannot be known
    if made is ball:
        # what is carried is given
        assert estimates["force"] < 1e-9


@pytest.mark.filterwarnings("ignore::mtb_rs.ToleranceWarning")
def test_a_grid_too_small_for_an_estimate_says_why() -> None:
    scene, _ = ball(4e-3, 1e3, 0.1, 0.0)
    gap = np.asarray(scene.gap)[5:8, 5:8]
    result = scene.with_(gap=gap).solve()
    assert not result.report.error_estimates
    assert "No error can be estimated" in result.report.missed


@pytest.mark.filterwarnings("ignore::mtb_rs.ToleranceWarning")
@pytest.mark.parametrize("across", [3.0, 4.0, 6.0])
def test_a_contact_of_a_few_points_is_as_good_as_it_says(across: float) -> None:
    force, radius = 1e4, 0.3
    cell = 2.0 * np.cbrt(0.75 * force * radius / MODULUS) / across
    for shift in (0.0, 0.25, 0.5):
        scene, peak = ball(cell, force, radius, shift)
        result = scene.solve()
        # against Hertz, as means over the cells
        x = cell * ((np.arange(12) - 6 + shift)[:, None] + (np.arange(20) + 0.5) / 20.0 - 0.5).ravel()
        half = 0.5 * across * cell
        exact = peak * np.sqrt(np.maximum(1.0 - (x[None] ** 2 + x[:, None] ** 2) / half**2, 0.0))
        exact = exact.reshape(12, 20, 12, 20).mean(axis=(1, 3))
        error = np.linalg.norm(result.pressure - exact) / np.linalg.norm(exact)
        assert error < result.report.error_estimates["pressure"]
