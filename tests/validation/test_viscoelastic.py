# SPDX-License-Identifier: MIT OR Apache-2.0
"""Rolling over bodies that creep, against CONTACT, against elastic limits, and against a march in time."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

import mtb_rs as mtb

Array = NDArray[np.float64]

#: Before it creeps: CONTACT's example of rubber, G = 1143 MPa and nu = 0.4.
RUBBER = mtb.Material.from_shear_modulus(1143e6, 0.4)
LAW = mtb.Coulomb(0.3)


def body(creep: float, time: float, material: mtb.Material = RUBBER) -> mtb.Viscoelastic:
    return mtb.Viscoelastic(material, creep, time)


def line(cells: int, cell: float) -> tuple[Array, tuple[float, float]]:
    """Gap (1, n) of a cylinder of 50 mm on a plane, one metre across."""
    x = (np.arange(cells) - 0.5 * (cells - 1)) * cell
    return np.asarray(10.0 * x[None] ** 2, dtype=float), (cell, 1.0)


def ball(cells: int, cell: float) -> Array:
    x = (np.arange(cells) - 0.5 * (cells - 1)) * cell
    return 10.0 * (x[None] ** 2 + x[:, None] ** 2)


#: Pressures and tractions (ny, nx) [MPa] of the runs of CONTACT below, on the upper body.
FIELDS = np.load(Path(__file__).parents[1] / "data" / "contact" / "viscoelastic.npz")


def check_fields(name: str, rolled: mtb.TangentialResult, sign: float) -> None:
    """Whether pressure and traction are those of CONTACT, cell by cell, within 0.1 % of the largest."""
    fields = {"pn": rolled.pressure, "px": sign * rolled.traction[0], "py": sign * rolled.traction[1]}
    known = {key: 1e6 * FIELDS[f"{name}/{key}"] for key in fields if f"{name}/{key}" in FIELDS}
    friction = max(np.abs(known[key]).max() for key in known if key != "pn")
    for key, field in known.items():
        # its file ends a cell or two around the contact, in the middle of the grid across
        ny, nx = field.shape
        rows = (len(rolled.pressure) - ny) // 2
        columns = np.argmax(np.correlate(fields["pn"].max(axis=0), known["pn"].max(axis=0), "valid"))
        own = fields[key][rows : rows + ny, columns : columns + nx]
        assert np.abs(own - field).max() < 1e-3 * (field.max() if key == "pn" else friction), key


#: Own runs of CONTACT, revision 2707: creep, creep time [s]; peak pressure [Pa], approach [m], creepage for
#: a force of 0.6 of the friction, power of friction [W], cells in contact, in stick. 600 kN, 0.16 mm, 1 m/s.
CYLINDERS = [
    (1.0, 0.009, 78.74e6, 2.36736e-3, 0.01365, 913.7, 62, 37),
    (1.0, 0.045, 84.72e6, 2.06321e-3, 0.01152, 952.0, 57, 36),
    (0.0, 0.0, 85.29e6, 1.3237e-3, 0.009792, 1007.0, 56, 36),
]


@pytest.mark.filterwarnings("ignore:the (upper|lower) body deforms")
@pytest.mark.parametrize(
    ("creep", "time", "peak", "approach", "creepage", "power", "cells", "stick"), CYLINDERS
)
@pytest.mark.parametrize("method", ["dense", "fft"])
def test_cylinders_are_those_of_contact(
    method: str,
    creep: float,
    time: float,
    peak: float,
    approach: float,
    creepage: float,
    power: float,
    cells: int,
    stick: int,
) -> None:
    gap, spacing = line(100, 0.16e-3)
    tread = body(creep, time)
    motion = mtb.Rolling(force=(0.6 * 0.3 * 600e3, None), velocity=1.0)
    normal = mtb.solve_normal(
        gap, spacing, lower=tread, upper=tread, force=600e3, rolling=motion, edge="sharp", method=method
    )
    assert normal.report.peak_pressure == pytest.approx(peak, rel=2e-4)
    assert normal.approach == pytest.approx(approach, rel=2e-5)
    assert np.count_nonzero(normal.status) == cells
    rolled = mtb.solve_tangential(normal, motion, LAW)
    # four digits are printed
    assert rolled.creepage[0] == pytest.approx(creepage, rel=3e-4)
    assert np.count_nonzero(rolled.status == 1) == stick
    check_fields(f"cyl_tc{time:g}" if creep else "cyl_elastic", rolled, -1.0)
    # CONTACT's power is that of traction times slip in each cell
    own = (rolled.traction[:2] * rolled.slip).sum(axis=0) * rolled.area
    assert float(own.sum()) == pytest.approx(power, rel=5e-4)


#: Balls of 50 mm on planes, 2 kN, cells of 0.4 mm, 1 m/s: creep time, creepages in the signs of this library;
#: peak pressure, approach, Fx, Fy, cells in contact, in stick.
BALLS = [
    (0.01, (0.005, 0.0, 0.0), 73.51e6, 0.302717e-3, 235.0, 0.0, 259, 196),
    (0.001, (0.0, 0.004, -0.5), 52.73e6, 0.364102e-3, 0.0, 116.3, 340, 290),
]


@pytest.mark.parametrize("method", ["dense", "fft"])
@pytest.mark.parametrize(("time", "creepage", "peak", "approach", "fx", "fy", "cells", "stick"), BALLS)
def test_balls_are_those_of_contact(
    method: str,
    time: float,
    creepage: tuple[float, float, float],
    peak: float,
    approach: float,
    fx: float,
    fy: float,
    cells: int,
    stick: int,
) -> None:
    tread = body(1.0, time)
    motion = mtb.Rolling(creepage=creepage, velocity=1.0)
    normal = mtb.solve_normal(
        ball(31, 0.4e-3), 0.4e-3, lower=tread, upper=tread, force=2e3, rolling=motion, method=method
    )
    assert normal.report.peak_pressure == pytest.approx(peak, rel=2e-4)
    assert normal.approach == pytest.approx(approach, rel=2e-5)
    assert np.count_nonzero(normal.status) == cells
    rolled = mtb.solve_tangential(normal, motion, LAW)
    assert rolled.force[0] == pytest.approx(fx, rel=5e-4, abs=1e-3)
    assert rolled.force[1] == pytest.approx(fy, rel=5e-4, abs=1e-3)
    # the creepages of its runs have the other sign
    check_fields("sphere_tc0.01" if time == 0.01 else "sphere_tc0.001_spin", rolled, 1.0)
    assert np.count_nonzero(rolled.status == 1) == stick


# --- limits -----------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("creep", "time", "same"),
    [
        (0.0, 0.3, RUBBER),
        (0.8, 0.0, body(0.8, 0.0).relaxed),
        (0.8, 1e-13, body(0.8, 0.0).relaxed),
        (0.8, 1e9, RUBBER),
    ],
    ids=["no creep", "at once", "nearly at once", "never"],
)
@pytest.mark.parametrize("method", ["dense", "fft"])
@pytest.mark.parametrize("angle", [0.0, 2.1])
@pytest.mark.coarse
def test_limits_are_elastic(creep: float, time: float, same: mtb.Material, method: str, angle: float) -> None:
    motion = mtb.Rolling(creepage=(3e-3, 1e-3, 0.2), velocity=1.0, angle=angle)
    given = {"force": 500.0, "method": method, "tolerance": 1e-11}
    gap, tread = ball(20, 0.5e-3), body(creep, time)
    creeping = mtb.solve_normal(gap, 0.5e-3, lower=tread, upper=tread, rolling=motion, **given)
    elastic = mtb.solve_normal(gap, 0.5e-3, lower=same, upper=same, **given)
    assert np.abs(creeping.pressure - elastic.pressure).max() < 1e-8 * elastic.pressure.max()
    assert creeping.approach == pytest.approx(elastic.approach, rel=1e-8)
    rolled = [mtb.solve_tangential(one, motion, LAW, tolerance=1e-11) for one in (creeping, elastic)]
    assert np.abs(rolled[0].traction - rolled[1].traction).max() < 1e-8 * rolled[1].traction.max()
    # heat takes the slip behind the contact, by kernels of its own
    heats = [one.dissipation for one in rolled]
    assert np.abs(heats[0] - heats[1]).max() < 1e-7 * heats[1].max()


# --- a cylinder that rolls in time --------------------------------------------------------------------------


def marched(creep: float, time: float, speed: float, cell: float) -> tuple[Array, Array]:
    """Places (n,) and pressure (n,) of a cylinder that has rolled, step by step, until it is steady.

    Particles of both surfaces carry an inner displacement z that follows the elastic one u by
    dz/dt = (creep u - z) / time; those far ahead of the contact have come to rest.
    """
    way, force, long = speed * time, 600e3, 1.0
    x = cell * np.arange(-round(7e-3 / cell), round((7e-3 + 20.0 * way) / cell))
    gap = 10.0 * x**2
    near = np.flatnonzero(np.abs(x) < 7e-3)

    def primitive(a: Array) -> Array:
        b = 0.5 * long
        return a * np.arcsinh(b / np.abs(a)) + b * np.arcsinh(a / b)

    off = x[:, None] - x[None, near]
    # two halves of the cell across, two bodies
    matrix = 4.0 * (primitive(off + 0.5 * cell) - primitive(off - 0.5 * cell))
    matrix *= (1.0 - RUBBER.poisson_ratio) / (2.0 * math.pi * RUBBER.shear_modulus)
    left = math.exp(-cell / way)
    # exact for an elastic displacement that changes linearly over a step
    mean = way / cell * (1.0 - left)
    touching = np.abs(x[near]) < 4e-3
    inner, elastic = np.zeros(x.size), np.zeros(x.size)
    pressure = np.zeros(near.size)
    for _ in range(x.size + near.size):
        # what comes in has been at rest
        came = np.append(inner[1:], creep * elastic[-1])
        known = left * came + creep * (mean - left) * np.append(elastic[1:], elastic[-1])
        factor = 1.0 + creep * (1.0 - mean)
        for _ in range(30):
            own = np.flatnonzero(touching)
            block = np.zeros((own.size + 1, own.size + 1))
            block[:-1, :-1] = factor * matrix[np.ix_(near[own], own)]
            block[:-1, -1], block[-1, :-1] = -1.0, cell * long
            found = np.linalg.solve(block, np.append(-gap[near[own]] - known[near[own]], force))
            pressure[:] = 0.0
            pressure[own] = found[:-1]
            opened = gap[near] + factor * matrix[near] @ pressure + known[near] - found[-1]
            now = np.where(touching, pressure > 0.0, opened < 0.0)
            if (now == touching).all():
                break
            touching = now
        elastic = matrix @ pressure
        inner = known + creep * (1.0 - mean) * elastic
    return np.asarray(x[near], dtype=float), pressure


@pytest.mark.filterwarnings("ignore:the (upper|lower) body deforms")
def test_a_march_in_time_becomes_the_steady_state() -> None:
    creep, time, speed = 1.0, 2e-3, 1.0
    errors = []
    for cell in (0.4e-3, 0.2e-3):
        x, pressure = marched(creep, time, speed, cell)
        gap = 10.0 * x[None] ** 2
        tread = body(creep, time)
        normal = mtb.solve_normal(
            gap,
            (cell, 1.0),
            lower=tread,
            upper=tread,
            force=600e3,
            edge="sharp",
            rolling=mtb.Rolling(velocity=speed),
        )
        errors.append(np.abs(normal.pressure[0] - pressure).max() / pressure.max())
        moment = float(pressure @ x) * cell
        # the slope of the gap is x / R
        assert normal.rolling_resistance * 0.05 == pytest.approx(moment, rel=2e-2)
        assert moment > 0.01 * 600e3 * 5e-3
    # the march interpolates over a step
    assert errors[1] < 3e-3
    assert errors[0] > 2.0 * errors[1]


@pytest.mark.parametrize("coupling", ["one-way", "full"])
def test_derivatives_know_the_scales_of_creep(coupling: str) -> None:
    """What counts is the way in a creep time: more speed does what a longer time does. And at one gap
    pressures and tractions go with moduli and force alike."""
    motion = mtb.Rolling((2e-3, 1e-3, 0.1), velocity=2.0, angle=0.4, step=0.7e-3)
    lower, upper, cell = body(1.2, 1e-3), body(0.5, 5e-4, mtb.Material(4e9, 0.3)), 0.5e-3
    gap = ball(16, cell)
    pressed = mtb.solve_normal(
        gap, cell, lower=lower, upper=upper, force=20.0, rolling=motion, tolerance=1e-12, edge="sharp"
    )
    by = pressed.gradient(["peak_pressure", {"pressure": gap * 1e3}])
    later = 1e-3 * by["lower.creep_time"] + 5e-4 * by["upper.creep_time"]
    faster = 2.0 * by["rolling.velocity"]
    np.testing.assert_allclose(later, faster, rtol=1e-7)
    assert np.all(np.abs(faster) > 1e-3 * np.abs(20.0 * by["force"]))
    moduli = [
        (f"{side}.young_modulus", b.material.young_modulus)
        for side, b in (("lower", lower), ("upper", upper))
    ]
    stiffer = 20.0 * by["force"] + sum(size * by[name] for name, size in moduli)
    np.testing.assert_allclose(
        stiffer, [pressed.pressure.max(), 1e3 * (gap * pressed.pressure).sum()], rtol=1e-8
    )
    rolled = mtb.solve_tangential(pressed, motion, LAW, coupling=coupling, tolerance=1e-12)
    by = rolled.gradient("force")
    later = 1e-3 * by["lower.creep_time"] + 5e-4 * by["upper.creep_time"]
    np.testing.assert_allclose(2.0 * by["velocity"], later, rtol=0.0, atol=1e-7)
    load = (
        20.0 * by["normal_force"] if coupling == "full" else np.tensordot(by["pressure"], rolled.pressure, 2)
    )
    stiffer = load + sum(size * by[name] for name, size in moduli)
    np.testing.assert_allclose(stiffer, rolled.force, rtol=0.0, atol=1e-7)
