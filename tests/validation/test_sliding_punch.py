# SPDX-License-Identifier: MIT OR Apache-2.0
"""A long flat sliding on a plane, plane strain: friction and pressure couple where the materials differ.

Closed form in :class:`mtb_rs.half_space.reference.SlidingFlatPunch` [Johnson1985, ch. 2.8], itself tested
against its integral equation in test_closed_forms.py.
"""

from __future__ import annotations

import numpy as np
import pytest

import mtb_rs as mtb
from mtb_rs import _mtb_rs
from mtb_rs.half_space import reference

HALF_WIDTH = 10e-3
LENGTH = 1e3 * HALF_WIDTH
LOAD = 1e6  # N/m
SOFT = mtb.Material(young_modulus=10e9, poisson_ratio=0.1)


def cell_pressures(cells: int, friction: float, lower: mtb.Material, upper: mtb.Material) -> tuple:
    """Middles [m] and pressures [Pa] of `cells` strips across the punch, a thousand half-widths long."""
    dx = 2.0 * HALF_WIDTH / cells
    below, above = (
        _mtb_rs.half_space((m.shear_modulus, m.poisson_ratio), [(0.0, 0.0, cells, 1)], (dx, LENGTH), True)
        for m in (lower, upper)
    )
    direction = np.stack([np.ones(cells), np.zeros(cells)])
    middles = (np.arange(cells) + 0.5) * dx - HALF_WIDTH
    zero = np.zeros(cells)
    level = _mtb_rs.ContactGeometry(np.stack([middles, zero, zero]), np.full(cells, dx * LENGTH))
    up = np.stack([zero, zero, np.ones(cells)])[None]
    problem = _mtb_rs.Problem(below, above, level, up, [True])
    loading = problem.loading(zero, np.array([-LOAD * LENGTH]))
    out = problem.slide(loading, direction, np.full(cells, friction))
    assert out.status == "solved"
    assert problem.prepare(direction, friction > 0.0) == (friction > 0.0 and lower != upper)
    return middles, out.pressure


@pytest.mark.parametrize(
    ("friction", "lower", "upper"),
    [
        (0.5, SOFT, mtb.steel),
        (0.5, mtb.steel, SOFT),
        (0.9, SOFT, mtb.Material(1e15, 0.3)),
        (0.0, SOFT, mtb.steel),
    ],
)
def test_pressure_leans_as_the_closed_form(friction: float, lower: mtb.Material, upper: mtb.Material) -> None:
    punch = reference.SlidingFlatPunch(HALF_WIDTH, LOAD, friction, lower, upper)
    errors, leans = [], []
    for cells in (40, 80, 160):
        x, pressure = cell_pressures(cells, friction, lower, upper)
        exact = punch.pressure(x)
        inner = np.abs(x) < 0.8 * HALF_WIDTH
        errors.append(np.linalg.norm((pressure - exact)[inner]) / np.linalg.norm(exact[inner]))
        rear = pressure[x < 0.0].sum() / pressure.sum()
        leans.append(abs(rear - punch.load_share(0.0)))
    rates = np.log2(np.array(errors[:-1]) / errors[1:])
    assert errors[-1] < 5e-3
    assert rates.min() > 0.9, f"errors {errors}, rates {rates}"
    assert leans[-1] < 1e-3
    if friction > 0.0:
        # the coupling is no small effect here: tens of per cent between front and rear
        assert abs(punch.load_share(0.0) - 0.5) > 0.04


def test_like_materials_decouple_exactly() -> None:
    _, rough = cell_pressures(40, 0.7, SOFT, SOFT)
    _, smooth = cell_pressures(40, 0.0, SOFT, SOFT)
    assert np.array_equal(rough, smooth)
    slides = mtb.scenes.paraboloid_on_plane(friction=0.5, points=18).solve(model="half-space")
    rests = mtb.scenes.paraboloid_on_plane(friction=0.0, points=18).solve(model="half-space")
    assert np.array_equal(slides.pressure, rests.pressure)
    assert np.abs(slides.traction[0] - 0.5 * slides.pressure).max() < 1e-9 * slides.pressure.max()


@pytest.mark.coarse
def test_unlike_materials_lean_the_paraboloid_and_the_mirror_image_leans_back() -> None:
    def pressure(direction: tuple[float, float]) -> np.ndarray:
        scene = mtb.scenes.paraboloid_on_plane(
            friction=0.5, points=18, lower=SOFT, upper=mtb.steel, sliding_direction=direction
        )
        return scene.solve(model="half-space").pressure

    forth, back, across = pressure((1.0, 0.0)), pressure((-1.0, 0.0)), pressure((0.0, 1.0))
    scale = forth.max()
    assert np.abs(forth - back[:, ::-1]).max() < 1e-11 * scale
    assert np.abs(forth - across.T).max() < 1e-11 * scale
    assert np.abs(forth - forth[::-1]).max() < 1e-11 * scale
    assert np.abs(forth - forth[:, ::-1]).max() > 0.05 * scale
    x = np.arange(18) - 8.5
    assert (forth @ x).sum() < 0.0  # to the rear: the softer body is below
