# SPDX-License-Identifier: MIT OR Apache-2.0
"""Friction that follows the temperature in steady rolling: CONTACT, a line computed apart, and limits."""

from __future__ import annotations

import json
import math
import pickle
import warnings
from pathlib import Path
from typing import Any

import numpy as np
import pint
import pytest
from numpy.typing import NDArray

import mtb_rs as mtb
from mtb_rs.case import case_from_words

Array = NDArray[np.float64]
DATA = Path(__file__).parents[1] / "data" / "contact"
CASES = {case["name"]: case for case in json.loads((DATA / "rolling_heat.json").read_text())["cases"]}
FIELDS = np.load(DATA / "rolling_heat.npz")
SPEED = 30.0
WHEEL = mtb.Material(82e9 * 2.0 * 1.28, 0.28)
BETA = mtb.conducting_steel.effusivity
LAWS: dict[str, dict[str, Any]] = {
    "law_falling": {"temperature": [0.0, 400.0], "coefficient": [0.33, 0.14]},
    # CONTACT compares the slip per distance rolled with the slip speed of the memory, in mm/s, so that the
    # latter always counts: 1 mm/s over 0.01 mm are 100 per second
    "law_falling_partial": {
        "temperature": [0.0, 400.0],
        "coefficient": [0.33, 0.14],
        "memory": 0.1,
        "memory_min_slip": 10.0,
    },
    "law_rising": {"temperature": [50.0, 650.0], "coefficient": [0.2, 0.35]},
}
CREEPAGES = {"law_falling": 1e-2, "law_falling_partial": 2e-3, "law_rising": 2e-2}
FALLING = mtb.TemperatureFriction([0.0, 400.0], [0.33, 0.14])


def pressed(name: str) -> mtb.NormalResult:
    """The normal contact of a case of CONTACT."""
    grid = CASES[name]["grid"]
    x = 1e-3 * (grid["x0"] + grid["dx"] * np.arange(grid["nx"]))
    y = 1e-3 * (grid["y0"] + grid["dy"] * np.arange(grid["ny"]))
    gap = 1.015 * x**2 + 0.4215 * y[:, None] ** 2
    spacing = 1e-3 * grid["dx"], 1e-3 * grid["dy"]
    return mtb.solve_normal(gap, spacing, force=1e5, lower=WHEEL, upper=WHEEL)


def patch(cells: tuple[int, int] = (35, 30)) -> mtb.NormalResult:
    contact = mtb.hertz(1e5, semi_axes=(5.88e-3, 10.54e-3), lower=mtb.steel, upper=mtb.steel)
    return contact.on_grid(cells, (14e-3 / cells[0], 24e-3 / cells[1]))


def roll(law: Any, creepage: tuple[float, float, float] = (1e-2, 0.0, 0.0), **more: Any) -> Any:
    return mtb.solve_tangential(patch(), mtb.Rolling(creepage, **{"velocity": SPEED, **more}), law)


@pytest.mark.parametrize("name", LAWS)
def test_contact_has_the_same_coefficients_at_the_same_temperatures(name: str) -> None:
    law, normal = mtb.TemperatureFriction(**LAWS[name]), pressed(name)
    steady = np.asarray(law.at(FIELDS[f"{name}/T1"]))
    slipping = FIELDS[f"{name}/status"] > 1
    theirs = np.hypot(FIELDS[f"{name}/px"], FIELDS[f"{name}/py"]) * 1e6
    pressure = np.asarray(normal.pressure)
    if law.memory is not None:
        # particles run along +x, and the scheme is implicit
        own = np.maximum(FIELDS[f"{name}/slip"] * SPEED, law.memory_min_slip)
        rate = own * 1e-3 * CASES[name]["grid"]["dx"] / SPEED / law.memory
        for mu, c, p in zip(steady, rate, pressure, strict=True):
            before = law.at_rest()
            for k in np.flatnonzero(p > 0.0):
                before = mu[k] = (before + c[k] * mu[k]) / (1.0 + c[k])
    # six digits are printed, and T1 is of the iteration before
    assert np.abs(steady * pressure - theirs)[slipping].max() < 1e-4 * theirs.max()


def along_a_line(
    pressure: Array, slip: Array, step: float, law: mtb.TemperatureFriction, own: float
) -> Array:
    """Coefficients along a line in full sliding, upstream first: each cell from the heat of those before it.

    `own` is how often the heat of a cell counts in this very cell, once or, as in CONTACT, twice.
    """
    coefficient = np.zeros(len(pressure))
    scale = 1.0 / (2.0 * BETA * math.sqrt(math.pi * SPEED))
    for k in range(len(pressure)):
        ahead = np.arange(k, 0, -1) * step
        weights = 2.0 * (np.sqrt(ahead + 0.5 * step) - np.sqrt(ahead - 0.5 * step))
        heat = coefficient[:k] * pressure[:k] * slip[:k] * SPEED
        before = scale * float(weights @ heat)
        each = scale * own * 2.0 * math.sqrt(0.5 * step) * pressure[k] * slip[k] * SPEED
        # the coefficient and its own heat in this cell, by halving
        low, high = 0.0, 1.0
        for _ in range(60):
            middle = 0.5 * (low + high)
            low, high = (middle, high) if law.at(before + middle * each) > middle else (low, middle)
        coefficient[k] = low
    return coefficient


@pytest.mark.parametrize("name", ["law_falling", "law_rising"])
def test_the_force_is_that_of_contact_but_for_its_doubled_heat(name: str) -> None:
    law, normal, grid = mtb.TemperatureFriction(**LAWS[name]), pressed(name), CASES[name]["grid"]
    found = mtb.solve_tangential(normal, mtb.Rolling((CREEPAGES[name], 0.0, 0.0), velocity=SPEED), law)
    # their pressure, by which their traction is that of their temperature
    slip = FIELDS[f"{name}/slip"]
    pressure = 1e6 * FIELDS[f"{name}/px"] / np.asarray(law.at(FIELDS[f"{name}/T1"]))
    cell = 1e-6 * grid["dx"] * grid["dy"]

    def force(own: float) -> float:
        # in their case particles run along +x
        mu = [along_a_line(p, s, 1e-3 * grid["dx"], law, own) for p, s in zip(pressure, slip, strict=True)]
        return float((np.array(mu) * pressure).sum() * cell)

    theirs = float(FIELDS[f"{name}/px"].sum()) * 1e6 * cell
    assert force(2.0) == pytest.approx(theirs, rel=1e-4)
    # with heat counted once: ours is the work of the mean traction of a particle, theirs traction times slip
    assert found.force[0] == pytest.approx(force(1.0), rel=1.5e-3)
    assert abs(force(1.0) / theirs - 1.0) > 2e-3


def test_full_sliding_converges_to_a_fine_line() -> None:
    # at a high creepage the slip is the rigid one, and a line of a parabola across a band is all there is
    law, creepage, half = mtb.TemperatureFriction([0.0, 200.0], [0.4, 0.1]), 0.05, 5e-3

    def profile(x: Array) -> Array:
        return np.asarray(8e8 * np.maximum(1.0 - (x / half) ** 2, 0.0))

    def mean(cells: int) -> float:
        step = 2.0 * half / cells
        x = (np.arange(cells) + 0.5) * step - half
        field = mtb.PressureField(
            np.tile(profile(x), (1, 1)), (step, 5.0 * half), lower=mtb.steel, upper=mtb.steel
        )
        motion = mtb.Rolling((creepage, 0.0, 0.0), velocity=SPEED)
        result = mtb.solve_tangential(field, motion, law)
        assert np.all(result.status == 2)
        return float(result.force[0] / (profile(x).sum() * step * 5.0 * half))

    fine, step = 4000, 2.0 * half / 4000
    x = (np.arange(fine) + 0.5) * step - half
    line = along_a_line(profile(x), np.full(fine, creepage), step, law, 1.0)
    exact = float((line * profile(x)).sum() / profile(x).sum())
    errors = [abs(mean(cells) / exact - 1.0) for cells in (20, 40, 80)]
    # elastic shear adds to the slip by about the coefficient times the strain of the pressure
    assert errors[-1] < 1e-2
    assert exact < 0.35


@pytest.mark.parametrize("direction", [0.0, math.pi / 2.0, 0.4])
@pytest.mark.parametrize("bulk", [(0.0, 0.0), (20.0, 180.0)])
def test_friction_and_temperature_of_a_result_fit(direction: float, bulk: tuple[float, float]) -> None:
    brass = mtb.Conductor(110.0, 8500.0, 380.0)
    law = mtb.TemperatureFriction([0.0, 5.0, 60.0], [0.35, 0.34, 0.1], upper=brass, bulk=bulk)
    result = roll(law, (4e-3, 1e-3, 0.3), angle=direction)
    heated = result.temperature(upper=brass, bulk=bulk)
    touches = result.status > 0
    assert result.report.converged
    expected = np.asarray(law.at(heated.temperature_lower))[touches]
    assert result.friction_coefficient[touches] == pytest.approx(expected, abs=1e-7)
    assert result.friction_coefficient[touches].min() < 0.32


def test_a_temperature_draws_itself() -> None:
    figure = roll(FALLING).temperature().plot()
    assert "temperature [K]" in [ax.get_ylabel() for ax in figure.axes]


def test_limits_are_coulombs() -> None:
    same = roll(mtb.TemperatureFriction([0.0, 100.0], [0.3, 0.3]))
    coulomb = roll(mtb.Coulomb(0.3))
    assert same.traction == pytest.approx(coulomb.traction, abs=1e-6 * coulomb.traction.max())
    falling = roll(FALLING)
    slow = roll(mtb.TemperatureFriction([0.0, 400.0], [0.33, 0.14], memory=1e3))
    quick = roll(mtb.TemperatureFriction([0.0, 400.0], [0.33, 0.14], memory=1e-12))
    assert slow.force[0] == pytest.approx(roll(mtb.Coulomb(0.33)).force[0], rel=1e-6)
    assert quick.force[0] == pytest.approx(falling.force[0], rel=1e-6)
    assert quick.force[0] < 0.99 * slow.force[0]


@pytest.mark.parametrize("creepage", [2e-3, 1e-2, 0.1])
@pytest.mark.parametrize("memory", [None, 1e-5])
@pytest.mark.parametrize("table", [([0.0, 5.0, 20.0], [0.5, 0.5, 0.1]), ([97.0, 100.0], [0.4, 0.1])])
@pytest.mark.parametrize("angle", [0.0, 0.7])
def test_a_steep_law_settles(creepage: float, memory: float | None, table: Any, angle: float) -> None:
    law = mtb.TemperatureFriction(*table, memory=memory)
    result = roll(law, (creepage * math.cos(angle), creepage * math.sin(angle), 0.0), angle=angle)
    assert result.report.converged
    assert result.report.residual < 1e-6
    if memory is None:
        # the temperature is that within which the law falls, and as good as the coefficient is
        slips = result.status == 2
        warm = result.temperature(**law.surfaces).temperature_lower[slips]
        own = np.interp(result.friction_coefficient[slips], law.coefficient[::-1], law.temperature[::-1])
        within = (warm > law.temperature[-2]) & (warm < law.temperature[-1])
        assert warm[within] == pytest.approx(own[within], abs=1e-3)


def test_slow_rolling_whose_heat_flows_along_the_surface_is_told() -> None:
    # 5.88 mm from middle to edge, steel: below 0.044 m/s
    for speed, is_slow in ((0.05, False), (0.04, True)):
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            roll(FALLING, (1e-3, 0.0, 0.0), velocity=speed)
            mtb.creep_curve(patch(), [(1e-3, 0.0, 0.0)], FALLING, velocity=speed)
            roll(mtb.Coulomb(0.3), (1e-3, 0.0, 0.0), velocity=speed)
        told = [str(one.message) for one in caught if "Peclet number" in str(one.message)]
        assert len(told) == 2 * is_slow
        _, step = moved(FALLING, "both", speed)
        assert ("heat also flows along the surface" in step.report.status) == is_slow


def test_a_law_that_is_too_steep_is_named() -> None:
    law = mtb.TemperatureFriction([0.0, 30.0, 30.001], [0.6, 0.5, 0.1])
    with pytest.raises(mtb.ConvergenceError, match=r"do not settle.*by 0.4 from 30 to 30.001 K") as caught:
        roll(law, (1e-2, 5e-3, 1.0))
    assert not caught.value.result.report.converged


def test_a_force_finds_its_creepage_and_a_curve_is_its_solves() -> None:
    given = roll(FALLING, (2e-3, 5e-4, 0.1))
    force = (float(given.force[0]), float(given.force[1]))
    found = roll(FALLING, (0.0, 0.0, 0.1), force=force)
    assert found.creepage[:2] == pytest.approx(given.creepage[:2], rel=1e-4)
    rows = np.array([[1e-3, 0.0, 0.0], [2e-3, 5e-4, 0.1], [2e-2, 0.0, 0.0]])
    curve = mtb.creep_curve(patch(), rows, FALLING, velocity=SPEED, tolerance=1e-8)
    for row, forces in zip(rows, curve, strict=True):
        alone = roll(FALLING, tuple(row))
        assert forces[:2] == pytest.approx(alone.force[:2], abs=1e-6 * 3e4)


@pytest.mark.coarse
def test_a_scene_and_a_case_file_roll_with_it() -> None:
    law = mtb.TemperatureFriction([0.0, 400.0], [0.33, 0.14], bulk=(0.0, 50.0), memory=1e-5)
    scene = mtb.scenes.paraboloid_on_plane(radius=0.4, force=5e4, points=24, friction=0.3)
    motion = mtb.Rolling(creepage=(5e-3, 0.0, 0.0), velocity=30.0)
    words = {
        "scene": "paraboloid_on_plane", "radius": 0.4, "force": 5e4, "points": 24,
        "friction": {
            "temperature": [0.0, 400.0], "coefficient": [0.33, 0.14], "bulk": [0.0, 50.0], "memory": 1e-5,
        },
        "rolling": {"velocity": 30.0, "creepage": [5e-3, 0.0, 0.0]},
        "solve": {"tolerance": 0.9},
    }  # fmt: skip
    expected = mtb.solve_tangential(scene.solve(model="half-space", tolerance=0.9), motion, law)
    from_case = case_from_words(words).solve()
    table = mtb.sweep(scene.with_(friction=law), {"rolling.velocity": [30.0]}, motion=motion, tolerance=0.9)
    assert from_case.force[0] == pytest.approx(expected.force[0], rel=1e-6)
    assert float(table["force_x"][0]) == pytest.approx(expected.force[0], rel=1e-6)
    assert expected.force[0] < 0.32 * 5e4
    for wrong, message in (
        ({"temperature": [0.0]}, "coefficient is missing"),
        (
            {"temperature": [0.0], "coefficient": [0.3], "slip": 1.0},
            "slip: no words of friction over the temp",
        ),
        ({"temperature": [1.0, 0.0], "coefficient": [0.3, 0.2]}, "strictly rising"),
    ):
        with pytest.raises(mtb.CaseError, match=message):
            case_from_words(words | {"friction": wrong}).scene()
    still = {name: word for name, word in words.items() if name != "rolling"}
    with pytest.raises(mtb.CaseError, match="Laws of friction are for wheels, rolling and shifts"):
        case_from_words(still).solve()
    with pytest.raises(mtb.CaseError, match="steady rolling"):
        case_from_words(still | {"shift": {"displacement": [1e-6, 0.0]}}).solve()


def test_what_knows_no_temperature_refuses_the_law() -> None:
    field = patch()
    for motion in (
        mtb.Shift((1e-6, 0.0)),
        mtb.Rolling((1e-3, 0.0, 0.0), velocity=SPEED, transient=True),
    ):
        with pytest.raises(ValueError, match=r"temperature of steady rolling, so Rolling\("):
            mtb.solve_tangential(field, motion, FALLING)
    wheels = mtb.scenes.wheel_on_rail(spacing=1e-3, lateral=0.0).prepare(friction=FALLING)
    with pytest.raises(ValueError, match="friction follows the temperature, which is known"):
        wheels.step([0.0, 0.0, np.nan, 0.0, 0.0, 0.0], SPEED, dt=2e-5, transient=True)
    with pytest.raises(ValueError, match="in steady rolling by solve_tangential, creep_curve and steps"):
        mtb.fastsim(field, (1e-3, 0.0, 0.0), FALLING, velocity=SPEED)


@pytest.mark.parametrize("creepage", [(2e-3, 1e-3, 0.3), (2e-2, 0.0, 0.0)])
def test_derivatives_know_the_scales_of_temperature(creepage: tuple[float, float, float]) -> None:
    """Heat that comes faster warms with the root of the speed, and so do bodies that conduct less, or a
    table and bulk temperatures of smaller numbers."""
    brass = mtb.Conductor(110.0, 8500.0, 380.0)
    law = mtb.TemperatureFriction([10.0, 150.0, 400.0], [0.33, 0.28, 0.14], upper=brass, bulk=(20.0, 60.0))
    by = roll(law, creepage, angle=0.3).gradient(["force", "spin_moment"])
    faster = 2.0 * SPEED * by["velocity"]
    smaller = -by["friction.temperature"] @ law.temperature - by["friction.bulk"] @ law.bulk
    worse = [
        -2.0
        * sum(
            by[f"friction.{side}.{name}"] * getattr(getattr(law, side), name) for side in ("lower", "upper")
        )
        for name in ("conductivity", "density", "specific_heat")
    ]
    for other in (smaller, *worse):
        np.testing.assert_allclose(other[[0, 1, 3]], faster[[0, 1, 3]], rtol=0.0, atol=1e-8 * abs(faster[0]))
    assert abs(faster[0]) > 50.0


def moved(law: Any, side: str, speed: float, across: float = 1.0) -> tuple[Any, mtb.WheelStep]:
    """Wheels that slide along and across in a curve; `across` -1 is the mirrored motion."""
    contact = mtb.scenes.wheel_on_rail(force=6e4, spacing=1.5e-3, lateral=0.0).prepare(
        side=side, friction=law
    )
    velocity = [speed, 0.0, 0.0, 0.0, 1.02 * speed / 0.46, across * 0.02]
    roll = np.nan if side == "both" else 0.0
    return contact, contact.step([0.0, across * 4e-3, np.nan, roll, 0.0, across * 4e-3], velocity)


@pytest.mark.parametrize("side", ["left", "right", "both"])
@pytest.mark.parametrize("speed", [20.0, -20.0])
def test_friction_and_temperature_of_steps_of_wheels_fit(side: str, speed: float) -> None:
    brass = mtb.Conductor(110.0, 8500.0, 380.0)
    law = mtb.TemperatureFriction([0.0, 120.0], [0.35, 0.1], upper=brass, bulk=(10.0, 30.0))
    _, step = moved(law, side, speed)
    assert len(step.patches) == (2 if side == "both" else 1)
    for patch in step.patches:
        heated = patch.temperature(upper=brass, bulk=(10.0, 30.0))
        slips = patch.status == 2
        expected = law.at(heated.temperature_lower) * patch.pressure
        error = np.abs(np.hypot(*patch.traction[:2]) - expected)[slips]
        assert slips.sum() > 20
        assert error.max() < 1e-5 * expected.max()
        assert heated.peak > 60.0


def test_steps_of_wheels_are_mirrored_and_those_of_files() -> None:
    law = mtb.TemperatureFriction([0.0, 120.0], [0.35, 0.1], memory=1e-4)
    contact, step = moved(law, "left", 20.0)
    other = moved(law, "right", 20.0, -1.0)[1]
    assert np.array(other.force) == pytest.approx(np.array(step.force) * [1.0, -1.0, 1.0], rel=1e-6)
    again = pickle.loads(pickle.dumps(contact.copy()))
    velocity = list(step.velocity)
    pose = [0.0, 4e-3, np.nan, 0.0, 0.0, 4e-3]
    assert again.step(pose, velocity).force == pytest.approx(contact.step(pose, velocity).force, rel=1e-9)
    # the same at all temperatures is Coulomb's friction, and one that falls carries less
    cold = moved(mtb.TemperatureFriction([0.0, 120.0], [0.35, 0.35]), "left", 20.0)[1]
    assert cold.force == pytest.approx(moved(mtb.Coulomb(0.35), "left", 20.0)[1].force, rel=1e-9)
    assert abs(step.force[0]) < 0.97 * abs(cold.force[0])


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"temperature": [0.0, 0.0]}, "strictly rising numbers"),
        ({"temperature": [0.0]}, "coefficient has 2 entries, temperature has 1"),
        ({"coefficient": [0.3, -0.1]}, r"coefficient\[1\] is -0.1"),
        ({"memory": 0.0}, "memory is 0"),
        ({"memory_min_slip": -1.0}, "memory_min_slip is -1"),
        ({"bulk": (1.0,)}, "bulk is"),
        ({"lower": mtb.steel}, "lower is"),
    ],
)
def test_a_law_that_makes_no_sense_is_refused(given: dict[str, Any], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        mtb.TemperatureFriction(**{"temperature": [0.0, 400.0], "coefficient": [0.33, 0.14], **given})


@pytest.mark.parametrize("bulk", [(0.0, 0.0), (20.0, 20.0)])
def test_temperatures_from_two_levels_are_asked_about(bulk: tuple[float, float]) -> None:
    """As a table in degrees Celsius beside plain numbers."""
    celsius: Any = pint.UnitRegistry().Quantity([0.0, 400.0], "degC")
    with pytest.warns(UserWarning, match="temperature goes from 273.15 to 673.15 K, and bulk is .*one level"):
        mtb.TemperatureFriction(celsius, [0.33, 0.14], bulk=bulk)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        mtb.TemperatureFriction([0.0, 400.0], [0.33, 0.14], bulk=bulk)
        mtb.TemperatureFriction([600.0], [0.33], bulk=bulk)
