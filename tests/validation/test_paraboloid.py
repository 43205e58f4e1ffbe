# SPDX-License-Identifier: MIT OR Apache-2.0
"""A paraboloid sliding on a plane, thesis Tables 3.1 and 3.2, against the closed form (Hertz, Cerruti)."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

import mtb_rs as mtb
from mtb_rs import _mtb_rs
from mtb_rs.half_space import reference

EXACT = reference.SlidingParaboloid(1000.0, 5e6, 0.5, mtb.steel, mtb.steel)
GRIDS = (10, 34, 66)


@cache
def solved(points: int, method: str = "direct") -> mtb.Result:
    scene = mtb.scenes.paraboloid_on_plane(points=points)
    options = {"force_tolerance": 1e3, "distance_tolerance": 1e-5} if method == "incremental" else {}
    return scene.solve(model="half-space", method=method, **options)


def errors(result: mtb.Result) -> dict[str, float]:
    """Errors relative to the exact norm or maximum: pressure (L2), approach, u_z, u_x, contact radius."""
    x, y = result.points[:2]
    pressure = EXACT.pressure(x, y)
    u = EXACT.displacement(x, y)
    moment = (result.pressure * (x**2 + y**2)).sum() / result.pressure.sum()
    return {
        "pressure": float(np.linalg.norm(result.pressure - pressure) / np.linalg.norm(pressure)),
        "traction": float(
            np.linalg.norm(result.traction[0] - 0.5 * pressure) / np.linalg.norm(0.5 * pressure)
        ),
        "approach": abs(float(result.approach) / EXACT.approach - 1.0),
        "u_z": float(np.abs(result.displacement.lower[2] - u[2]).max() / np.abs(u[2]).max()),
        "u_x": float(np.abs(result.displacement.lower[0] - u[0]).max() / np.abs(u[0]).max()),
        # the second moment of Hertz' pressure is 2/5 a^2
        "radius": abs(float(np.sqrt(2.5 * moment)) / EXACT.contact_radius - 1.0),
    }


@pytest.mark.coarse
def test_direct_method_converges() -> None:
    table = [errors(solved(n)) for n in GRIDS]
    for name, bound, rate in [
        ("pressure", 0.015, 0.9),
        ("traction", 0.015, 0.9),
        ("approach", 3e-4, 0.9),
        ("u_z", 2e-3, 1.0),
        ("u_x", 3e-3, 1.0),
        ("radius", 2e-3, 0.9),
    ]:
        values = [row[name] for row in table]
        assert values[1] < bound, f"{name} at 34 x 34: {values[1]:.2e}"
        # over two refinements: on a single one the patch may fall well or badly into the cells
        observed = np.log(values[0] / values[-1]) / np.log((GRIDS[-1] - 1) / (GRIDS[0] - 1))
        assert observed > rate, f"{name}: {values}, rate {observed:.2f}"


def test_direct_method_is_symmetric_and_balanced() -> None:
    result = solved(34)
    scale = result.pressure.max()
    for image in (result.pressure[:, ::-1], result.pressure[::-1], result.pressure.T):
        assert np.abs(result.pressure - image).max() < 1e-10 * scale
    assert result.normal_force == pytest.approx(5e6, rel=1e-12)
    assert result.force == pytest.approx([2.5e6, 0.0, -5e6], rel=1e-12, abs=1e-3)
    upper, lower = result.displacement
    closed = result.initial_gap + (upper - lower)[2] - result.approach
    contact = result.pressure > 0.0
    # the solver stops well below the error of the grid, 1.6e-4 in the approach
    assert np.abs(closed[contact]).max() < 2e-5 * float(result.approach)


@pytest.mark.coarse
def test_incremental_method_agrees_but_leans() -> None:
    for n in (10, 18, 34):
        direct, incremental = solved(n), solved(n, "incremental")
        assert incremental.report.converged
        assert incremental.report.method == "incremental"
        assert incremental.summary["incremental"]["increments"] >= 20
        difference = np.linalg.norm(incremental.pressure - direct.pressure) / np.linalg.norm(direct.pressure)
        assert difference < 1e-3
        assert incremental.summary["incremental"]["force"] == pytest.approx(5e6, abs=1e3)
        # thesis Fig. 3.2: a slight asymmetry along the sliding direction, none across it
        along = (
            np.abs(incremental.pressure - incremental.pressure[:, ::-1]).max() / incremental.pressure.max()
        )
        across = np.abs(incremental.pressure - incremental.pressure[::-1]).max() / incremental.pressure.max()
        assert 1e-5 < along < 5e-3
        assert across < 1e-6
        for name, value in errors(incremental).items():
            assert value < errors(direct)[name] + 1e-3, name


def test_incremental_method_says_what_it_cannot_do() -> None:
    scene = mtb.scenes.paraboloid_on_plane(points=10)
    with pytest.raises(ValueError, match="estimated_steps is 0"):
        scene.solve(model="half-space", method="incremental", estimated_steps=0)
    with pytest.raises(ValueError, match="force_tolerance is -1"):
        scene.solve(model="half-space", method="incremental", force_tolerance=-1.0)
    with pytest.raises(ValueError, match="unknown option 'steps'"):
        scene.solve(model="half-space", method="incremental", steps=3)
    with pytest.raises(mtb.ConvergenceError) as caught:
        scene.solve(model="half-space", method="incremental", max_increments=5)
    state = caught.value.result
    assert not state.report.converged
    assert 0.0 < state.normal_force < 4e6


def on_scattered_points(points: int, share: float) -> float:
    """Pressure error (L2) with Gaussians of standard deviation `share` of the spacing."""
    h = 1.0 / (points - 1)
    line = (np.arange(points) - 0.5 * (points - 1)) * h
    x, y = (v.ravel().copy() for v in np.meshgrid(line, line))
    n, edge = x.size, line[-1] + 0.5 * h
    domain = (-edge, edge, -edge, edge)
    (body,), weights = _mtb_rs.half_space_gaussians([(80e9, 0.3)], x, y, share * h, domain)
    direction = np.stack([np.ones(n), np.zeros(n)])
    level = _mtb_rs.ContactGeometry(np.stack([x, y, 0.0 * x]), weights)
    up = np.stack([np.zeros(n), np.zeros(n), np.ones(n)])[None]
    problem = _mtb_rs.Problem(body, body, level, up, [True])
    loading = problem.loading((x**2 + y**2) / 2000.0, np.array([-5e6]))
    out = problem.slide(loading, direction, np.full(n, 0.5))
    assert out.status == "solved"
    exact = EXACT.pressure(x, y)
    return float(np.linalg.norm(out.pressure - exact) / np.linalg.norm(exact))


@pytest.mark.coarse
def test_gaussians_are_no_better_than_rectangles() -> None:
    rectangles = errors(solved(10))["pressure"]
    narrow, medium, wide = (on_scattered_points(10, share) for share in (0.25, 0.35, 0.5))
    assert narrow == pytest.approx(rectangles, rel=0.1)
    assert medium == pytest.approx(rectangles, rel=0.2)
    assert wide > 1.3 * rectangles
