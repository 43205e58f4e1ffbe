# SPDX-License-Identifier: MIT OR Apache-2.0
"""A cylinder that rolls on what creeps, against Hunter's closed form, over the whole range of speeds.

Closed form in :class:`mtb_rs.half_space.reference.CreepingCylinder` [Hunter1961], itself tested here: by its
limits, and by the motion of the surface under its pressure.
"""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

import mtb_rs as mtb
from mtb_rs.half_space.reference import CreepingCylinder

Array = NDArray[np.float64]

RUBBER = mtb.Material(20e6, 0.49)
#: Of the cylinder: radius [m] and load [N/m].
RADIUS, LOAD = 50e-3, 500.0
NUMBERS = [0.03, 0.3, 1.0, 3.0, 30.0]

pytestmark = pytest.mark.filterwarnings("ignore:the (upper|lower) body deforms")


def cylinder(number: float, creep: float = 1.5) -> CreepingCylinder:
    """That of a Deborah number, with the length of the relaxed contact."""
    exact = CreepingCylinder(RADIUS, LOAD, RUBBER, creep, 1.0)
    return CreepingCylinder(RADIUS, LOAD, RUBBER, creep, number * 2.0 * exact.extent_of(exact.relaxed))


def rolled(exact: CreepingCylinder, cells: int, shift: float = 0.0, angle: float = 0.0) -> mtb.NormalResult:
    """On a row of cells of which `cells` are in the relaxed contact, shifted by a part of a cell."""
    cell = 2.0 * exact.extent_of(exact.relaxed) / cells
    x = (np.arange(round(1.4 * cells)) - 0.5 * (round(1.4 * cells) - 1) + shift) * cell
    # so long that what is missing beyond its ends is far away, also from the way ahead
    long = 1e3 * max(exact.way, cells * cell)
    body = mtb.Viscoelastic(exact.material, exact.creep, exact.way)
    motion = mtb.Rolling(velocity=1.0, angle=angle)
    return mtb.solve_normal(
        (x**2 / (2.0 * RADIUS))[None],
        (cell, long),
        lower=body,
        upper=mtb.Rigid(),
        force=LOAD * long,
        edge="sharp",
        rolling=motion,
        tolerance=1e-10,
    )


# --- the closed form ---------------------------------------------------------------------------------------


@pytest.mark.parametrize("creep", [0.2, 1.5, 10.0])
def test_its_limits_are_those_of_hertz(creep: float) -> None:
    for number, which in ((1e-4, "relaxed"), (1e5, "material")):
        exact = cylinder(number, creep)
        half = exact.extent_of(getattr(exact, which))
        assert exact.half_width == pytest.approx(half, rel=2e-3)
        assert exact.peak_pressure == pytest.approx(2.0 * LOAD / (np.pi * half), rel=1e-5)
        assert 0.0 < exact.offset < 1e-3 * half


@pytest.mark.parametrize("number", NUMBERS)
def test_it_meets_the_equation_of_its_contact(number: float) -> None:
    exact = cylinder(number)
    ends = exact.middle + exact.half_width * np.array([-1.0, 1.0])
    # strips that are narrower towards the ends, each with its mean by the midpoint
    angles = np.linspace(np.pi, 0.0, 1201)
    edges = exact.middle + exact.half_width * np.cos(angles)
    pressure = exact.pressure(exact.middle + exact.half_width * np.cos(0.5 * (angles[1:] + angles[:-1])))
    assert (pressure > 0.0).all()
    forces = pressure * np.diff(edges)
    assert forces.sum() == pytest.approx(LOAD, rel=1e-5)
    assert forces @ (0.5 * (edges[1:] + edges[:-1])) == pytest.approx(LOAD * exact.offset, rel=1e-3)

    def moved(x: Array) -> Array:
        """Elastic displacement into the body, but for a constant, by strips of uniform pressure."""
        off = np.asarray(x)[:, None] - edges[None]
        part = off * np.log(np.abs(off) / exact.half_width) - off
        return -2.0 / (np.pi * RUBBER.plane_strain_modulus) * (part[:, :-1] - part[:, 1:]) @ pressure

    x = np.linspace(*ends, 13)[1:-1] + 1e-7 * exact.half_width
    pieces = np.concatenate([[0.0], np.geomspace(1e-4, 40.0, 600)])
    inner, shares = np.polynomial.legendre.leggauss(6)
    t = (0.5 * (pieces[1:] + pieces[:-1])[:, None] + 0.5 * np.diff(pieces)[:, None] * inner).ravel()
    w = (0.5 * np.diff(pieces)[:, None] * shares).ravel() * np.exp(-t)
    mean = np.array([w @ moved(place + exact.way * t) for place in x])
    surface = moved(x) + exact.creep * mean + x**2 / (2.0 * RADIUS)
    # it is the same approach everywhere
    assert np.ptp(surface) < 1e-4 * exact.half_width**2 / RADIUS


# --- the solver --------------------------------------------------------------------------------------------


def test_the_solver_converges_to_it_at_every_speed() -> None:
    shifts, grids = (0.0, 0.23, 0.41), (40, 80, 160)
    errors = np.zeros((len(grids), len(NUMBERS), len(shifts), 4))
    for j, number in enumerate(NUMBERS):
        exact = cylinder(number)
        for i, cells in enumerate(grids):
            for k, shift in enumerate(shifts):
                found = rolled(exact, cells, shift)
                cell = found.spacing[0]
                x = np.sqrt(2.0 * RADIUS * found.initial_gap[0]) * np.sign(found.points[0, 0] + shift * cell)
                p = found.pressure[0]
                # by means over cells, in which the ends are rounded off
                fine = exact.pressure(x[:, None] + cell * (np.arange(40) - 19.5) / 40).mean(axis=1)
                errors[i, j, k] = (
                    p.max() / exact.peak_pressure - 1.0,
                    (p @ x * cell / LOAD - exact.offset) / exact.half_width,
                    found.rolling_resistance / (found.spacing[1] * exact.load) * RADIUS / exact.half_width
                    - exact.offset / exact.half_width,
                    np.linalg.norm(p - fine) / np.linalg.norm(fine),
                )
    size = np.sqrt((errors**2).mean(axis=2)).max(axis=1)
    orders = np.log2(size[:-1] / size[1:]).mean(axis=0)
    # peak, offset and resistance at second order, the field with its steep ends at first
    assert (orders > [1.7, 1.7, 1.7, 0.8]).all(), orders
    assert (size[-1] < [1e-4, 1e-4, 1e-4, 5e-3]).all(), size


def test_rolling_back_is_its_mirror_image() -> None:
    exact = cylinder(0.3)
    ahead, back = rolled(exact, 60), rolled(exact, 60, angle=np.pi)
    np.testing.assert_allclose(
        back.pressure[0], ahead.pressure[0, ::-1], atol=1e-8 * ahead.report.peak_pressure
    )
    assert back.rolling_resistance == pytest.approx(ahead.rolling_resistance, rel=1e-8)


@pytest.mark.parametrize("which", ["relaxed", "material"])
def test_the_limits_are_approached_as_the_closed_form_says(which: str) -> None:
    # far out the departure from the elastic limit is small, and it alone is compared
    for number in (1e-3, 3e-3) if which == "relaxed" else (300.0, 1000.0):
        exact = cylinder(number)
        found = rolled(exact, 120)
        body = getattr(mtb.Viscoelastic(RUBBER, exact.creep, 0.0), which)
        still = mtb.solve_normal(
            found.initial_gap,
            found.spacing,
            lower=body,
            upper=mtb.Rigid(),
            force=found.normal_force,
            edge="sharp",
            tolerance=1e-10,
        )
        x = found.points[0, 0]
        offset = float((found.pressure - still.pressure)[0] @ x) * found.spacing[0] / LOAD
        assert offset == pytest.approx(exact.offset, rel=0.03)


# --- whether it matters ------------------------------------------------------------------------------------


@pytest.mark.parametrize("creep", [0.2, 1.5, 10.0])
def test_estimates_bound_the_errors_of_elastic_bodies(creep: float) -> None:
    for number in (1e-3, 1e-2, 0.1, 1.0, 10.0, 100.0, 1000.0):
        exact = cylinder(number, creep)
        body = mtb.Viscoelastic(RUBBER, creep, exact.way)
        x = exact.middle + 2.5 * exact.extent_of(exact.relaxed) * np.linspace(-1.0, 1.0, 4001)
        own = exact.pressure(x)
        estimates = body.elastic_errors(1.0, 2.0 * exact.half_width)
        assert body.deborah_number(1.0, 2.0 * exact.half_width) == exact.way / (2.0 * exact.half_width)
        for estimate, elastic in zip(estimates, (exact.relaxed, exact.material), strict=True):
            half = exact.extent_of(elastic)
            hertz = 2.0 * LOAD / (np.pi * half) * np.sqrt(np.maximum(1.0 - (x / half) ** 2, 0.0))
            error = np.linalg.norm(hertz - own) / np.linalg.norm(own)
            if estimate < 0.3:
                assert 0.3 * estimate < error < estimate
            else:
                assert error > 0.03


@pytest.mark.parametrize("creep", [0.5, 4.0])
def test_they_bound_those_of_balls(creep: float) -> None:
    cell = 0.1e-3
    x = (np.arange(46) - 22.5) * cell
    gap = (x[None] ** 2 + x[:, None] ** 2) / (2.0 * RADIUS)
    given = {"spacing": cell, "upper": mtb.Rigid(), "force": 1.0, "tolerance": 1e-9}
    for way in (2e-5, 1e-4, 0.05, 0.3):
        body = mtb.Viscoelastic(RUBBER, creep, way)
        found = mtb.solve_normal(gap, lower=body, rolling=mtb.Rolling(velocity=1.0), **given)
        length = cell * np.count_nonzero(found.pressure.any(axis=0))
        for estimate, elastic in zip(body.elastic_errors(1.0, length), (body.relaxed, RUBBER), strict=True):
            if estimate < 0.3:
                still = mtb.solve_normal(gap, lower=elastic, **given)
                error = np.linalg.norm(still.pressure - found.pressure) / np.linalg.norm(found.pressure)
                # in fast rolling the way ahead of a ball has no logarithm
                assert estimate / 7.0 < error < estimate
