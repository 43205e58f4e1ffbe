# SPDX-License-Identifier: MIT OR Apache-2.0
"""Derivatives of shifts and of rolling, against differences of solves, Kalker, Cattaneo and Mindlin."""

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import mtb_rs as mtb
from mtb_rs.half_space.pressure_field import PressureField
from mtb_rs.half_space.tangential_result import TangentialResult
from mtb_rs.half_space.tangential_state import TangentialState

Array = NDArray[np.float64]

#: Semi-axes [m], largest pressure [Pa], cells along a side.
A, B, PEAK = 3e-3, 2.5e-3, 8e8
BRASS = mtb.Material(100e9, 0.34)
GLASS = mtb.Material(70e9, 0.05)


def field(nx: int, ny: int, upper: mtb.Material | None = mtb.steel) -> PressureField:
    """The pressure of Hertz on an ellipse."""
    dx, dy = 2.2 * A / nx, 2.2 * B / ny
    x = (np.arange(nx) - 0.5 * (nx - 1)) * dx
    y = (np.arange(ny) - 0.5 * (ny - 1)) * dy
    inside = 1.0 - (x[None, :] / A) ** 2 - (y[:, None] / B) ** 2
    return PressureField(PEAK * np.sqrt(np.maximum(inside, 0.0)), (dx, dy), mtb.steel, upper)


CONTACT = field(16, 14, BRASS)
SHAPE = CONTACT.pressure.shape
LAYER = mtb.InterfaceLayer(2e-5, 1e9)
FALLING = mtb.FallingFriction(0.34, 0.3, 1.0, memory=1e-4, memory_min_slip=1e-3)
SWIFT = mtb.FallingFriction(0.34, 0.3, 5.0)
TABLE = mtb.TabulatedFriction([0.0, 0.5, 2.0], [0.33, 0.32, 0.3], memory=1e-4)
SEEDED = np.random.default_rng(5)
SPOTTED = mtb.Coulomb(0.3 + 0.03 * SEEDED.random(SHAPE))

X = (np.arange(14) - 6.5) * 0.42e-3
GAP = X[None, :] ** 2 / 0.7 + X[:, None] ** 2 / 0.45
PRESSED_BY = 1e3

Given = dict[str, Any]
#: Arguments of normal contacts that are not in all of them.
BETWEEN = ("normal_layer", "hardness", "inclination")
#: Yields from about the stress that friction has on a quarter of the contact.
PLASTIC = mtb.PlasticLayer(2e-6, 1e9, yield_stress=7e7, hardening=6e13)
#: Rows turn by half a radian over the contact.
ANGLES = 0.25 * np.linspace(-1.0, 1.0, 14)
CURVED = replace(CONTACT, upper=mtb.steel, inclination=ANGLES)


def solved(given: Given) -> TangentialResult:
    if "gap" in given:
        bodies = {"lower": given["lower"], "upper": given["upper"]}
        between = {name: given[name] for name in BETWEEN if name in given}
        pressed = mtb.solve_normal(
            given["gap"], 0.42e-3, force=given["normal_force"], tolerance=1e-13, **bodies, **between
        )
    else:
        pressed = given["field"]
    return mtb.solve_tangential(
        pressed,
        given["motion"],
        given["friction"],
        layer=given.get("layer"),
        state=given.get("state"),
        tolerance=1e-12,
        coupling=given.get("coupling", "one-way"),
    )


STATE = solved({"field": CONTACT, "motion": mtb.Shift((1.5e-6, -1e-6)), "friction": FALLING}).state

PLASTIC_STATE = solved(
    {"field": CONTACT, "motion": mtb.Shift((2.5e-6, -1e-6)), "friction": mtb.Coulomb(0.3), "layer": PLASTIC}
).state
CURVED_STATE = solved(
    {"field": CURVED, "motion": mtb.Shift((2.5e-6, -1e-6)), "friction": mtb.Coulomb(0.3), "layer": PLASTIC}
).state

CASES: dict[str, Given] = {
    "yielding, steady": {
        "motion": mtb.Rolling((3e-3, -1e-3, 0.3), step=3.3e-4, angle=0.1), "friction": SPOTTED,
        "layer": PLASTIC,
    },
    "yielding, transient": {
        "motion": mtb.Rolling((3e-3, 1e-3, 0.2), transient=True, step=3.3e-4, angle=-0.7),
        "friction": mtb.Coulomb(0.3), "layer": PLASTIC, "state": PLASTIC_STATE,
    },
    "yielding, by force": {
        "motion": mtb.Shift((0.0, 1e-6), force=(1000.0, None), spin=1e-4), "friction": mtb.Coulomb(0.3),
        "layer": replace(PLASTIC, hardening=0.0), "state": PLASTIC_STATE,
    },
    "inclined, steady": {
        "field": CURVED, "motion": mtb.Rolling((1e-3, -8e-4, 0.3), step=4.5e-4),
        "friction": SPOTTED, "layer": LAYER,
    },
    "inclined, steady by cells": {
        "field": CURVED, "motion": mtb.Rolling((1e-3, -8e-4, 0.3)), "friction": FALLING,
    },
    "inclined, transient": {
        "field": CURVED, "motion": mtb.Rolling((1e-3, 1e-3, 0.2), transient=True, step=3.3e-4),
        "friction": mtb.Coulomb(0.3), "layer": LAYER, "state": CURVED_STATE,
    },
    "inclined, by force": {
        "field": CURVED, "motion": mtb.Shift((0.0, 1e-6), force=(1200.0, None)),
        "friction": mtb.Coulomb(0.3), "layer": PLASTIC, "state": CURVED_STATE,
    },
    # with a layer a whole number of cells is a kink for step and angle
    "steady": {
        "motion": mtb.Rolling((1e-3, -8e-4, 0.3), step=3.3e-4, angle=0.1), "friction": SPOTTED,
        "layer": LAYER,
    },
    "backwards": {
        "motion": mtb.Rolling((2e-3, -8e-4, 0.3), step=5e-4, angle=3.0), "friction": SWIFT,
    },
    "transient without memory": {
        "motion": mtb.Rolling((1e-3, 1e-3, 0.2), transient=True, step=3.3e-4, angle=-0.7), "friction": SWIFT,
        "state": STATE, "layer": LAYER,
    },
    "steady by force": {
        "motion": mtb.Rolling((0.0, 5e-4, 0.1), force=(2000.0, None), angle=0.4),
        "friction": mtb.Coulomb(0.3),
        "layer": LAYER,
    },
    "steady falling": {"motion": mtb.Rolling((2e-3, 1e-3, 0.1)), "friction": FALLING},
    "transient": {
        "motion": mtb.Rolling((1e-3, 1e-3, 0.2), transient=True),
        "friction": TABLE,
        "state": STATE,
        "layer": LAYER,
    },
    "shift": {
        "motion": mtb.Shift((2e-6, 1e-6), spin=1e-4, duration=1e-5), "friction": FALLING, "state": STATE,
    },
    "shift by force": {
        "motion": mtb.Shift((0.0, 1e-6), force=(2000.0, None)), "friction": mtb.Coulomb(0.3), "state": STATE,
    },
}  # fmt: skip
PRESSED: Given = {
    "coupling": "full", "gap": GAP, "normal_force": PRESSED_BY, "lower": mtb.steel, "upper": GLASS,
}  # fmt: skip
PRESSED_STATE = solved(PRESSED | {"motion": mtb.Shift((1e-6, -1e-6)), "friction": mtb.Coulomb(0.3)}).state
#: Pressure and traction follow from each other.
COUPLED: dict[str, Given] = {
    "coupled steady": {
        "motion": mtb.Rolling((1e-3, -8e-4, 0.3), step=3e-4, angle=0.3), "friction": mtb.Coulomb(0.3),
        "layer": LAYER,
    },
    "coupled shift by force": {
        "motion": mtb.Shift((0.0, 1e-6), force=(300.0, None), spin=1e-4), "friction": mtb.Coulomb(0.4),
    },
    "coupled like bodies": {
        "motion": mtb.Shift((1e-6, 1e-6), spin=1e-4), "friction": mtb.Coulomb(0.3), "upper": mtb.steel,
    },
    "coupled transient": {
        "motion": mtb.Rolling((1e-3, 1e-3, 0.2), transient=True), "friction": FALLING, "state": PRESSED_STATE,
    },
    "coupled on a rigid plane": {
        "motion": mtb.Shift((3e-6, 1e-6), spin=1e-4), "friction": mtb.Coulomb(0.3), "upper": mtb.Rigid(),
    },
    "coupled through a layer": {
        "motion": mtb.Rolling((1e-3, -8e-4, 0.3), angle=0.3), "friction": mtb.Coulomb(0.3),
        "normal_layer": 2e-15,
    },
    "coupled and inclined": {
        "motion": mtb.Rolling((1e-3, -8e-4, 0.3)), "friction": mtb.Coulomb(0.3), "upper": mtb.steel,
        "inclination": ANGLES,
    },
    "coupled and yielding": {
        "motion": mtb.Shift((2e-6, 1e-6), spin=1e-4), "friction": mtb.Coulomb(0.3),
        "layer": mtb.PlasticLayer(2e-6, 1e9, yield_stress=3e7, hardening=6e13),
    },
    "coupled and flowing": {
        "motion": mtb.Shift((1e-6, 1e-6), spin=1e-4), "friction": mtb.Coulomb(0.3), "hardness": 1.4e8,
        "normal_layer": 1e-15,
    },
}  # fmt: skip
CASES |= {name: PRESSED | case for name, case in COUPLED.items()}


def spacing_of(given: Given) -> tuple[float, float]:
    return (0.42e-3, 0.42e-3) if "gap" in given else given["field"].spacing


def changed(given: Given, by: str, change: Array) -> Given:
    """What is given, with one input changed, written without the code that it tests."""
    motion, friction, contact = given["motion"], given["friction"], given["field"]
    if by in ("gap", "normal_force", "normal_layer", "hardness"):
        return given | {by: given[by] + change}
    if by == "normal_layer_field":
        # the same at each cell
        return given | {"normal_layer": given["normal_layer"] + change.flat[0]}
    if by == "pressure":
        return given | {"field": replace(contact, pressure=contact.pressure + change)}
    if by == "force":
        force = tuple(None if f is None else f + d for f, d in zip(motion.force, change, strict=True))
        return given | {"motion": replace(motion, force=force)}
    if by in ("creepage", "displacement"):
        return given | {"motion": replace(motion, **{by: tuple(np.array(getattr(motion, by)) + change)})}
    if by == "step":
        step = motion.step or np.hypot(*motion.step_vector(spacing_of(given)))
        return given | {"motion": replace(motion, step=step + float(change))}
    if by in ("spin", "velocity", "duration", "angle"):
        return given | {"motion": replace(motion, **{by: getattr(motion, by) + float(change)})}
    if by in ("friction", "friction_field"):
        return given | {"friction": mtb.Coulomb(friction.coefficient + change)}
    owner, name = by.split(".")
    if owner == "friction":
        value = np.asarray(getattr(friction, name)) + change
        return given | {"friction": replace(friction, **{name: value.tolist()})}
    if owner == "layer":
        layer = given["layer"]
        return given | {"layer": replace(layer, **{name: getattr(layer, name) + float(change)})}
    if owner == "state":
        state = given["state"]
        parts = {n: getattr(state, n) for n in ("traction", "pressure", "coefficient")}
        parts["accumulated_plastic_slip"] = state.accumulated_plastic_slip
        parts[name] = parts[name] + change
        return given | {"state": TangentialState(**parts, origin=state.origin, spacing=state.spacing)}
    if given.get("inclination", contact.inclination) is not None:
        # like bodies only: half of the change of each
        body = given.get("lower", contact.lower)
        both = dict.fromkeys(
            ("lower", "upper"), replace(body, **{name: getattr(body, name) + 0.5 * float(change)})
        )
        return given | (both if "lower" in given else {"field": replace(contact, **both)})
    body = given[owner] if owner in given else getattr(contact, owner)
    body = replace(body, **{name: getattr(body, name) + float(change)})
    if owner in given:
        return given | {owner: body}
    return given | {"field": replace(contact, **{owner: body})}


def value_of(given: Given, by: str) -> Any:
    """An input, or what it is of the size of."""
    motion, friction, contact = given["motion"], given["friction"], given["field"]
    if by == "pressure":
        return 1e-2 * contact.pressure
    if by in ("normal_force", "normal_layer", "hardness"):
        return 0.1 * given[by]
    if by in ("gap", "normal_layer_field"):
        return (1e-7 if by == "gap" else 0.1 * given["normal_layer"]) * np.ones(GAP.shape)
    if by == "force":
        return np.array([0.0 if f is None else f for f in motion.force])
    if by == "step":
        return np.array(0.1 * np.hypot(*motion.step_vector(spacing_of(given))))
    if by == "angle":
        return np.array(0.1)
    if by in ("creepage", "displacement", "spin", "velocity", "duration"):
        forced = motion.force or (None, None)
        value = np.array(getattr(motion, by))
        if value.ndim:
            value[:2][[f is not None for f in forced]] = 0.0
        return value
    if by in ("friction", "friction_field"):
        return friction.coefficient * (
            0.1 if by == "friction" else 0.1 * np.ones(given.get("gap", CONTACT.pressure).shape)
        )
    owner, name = by.split(".")
    if owner == "layer" and name == "hardening":
        # a layer that does not harden may not soften
        return np.array(0.1 * given["layer"].hardening)
    if owner == "state":
        # what has no traction or pressure has none
        return 0.1 * getattr(given["state"], name)
    body = {"friction": friction, "layer": given.get("layer"), **given}.get(owner) or getattr(contact, owner)
    return 0.1 * np.asarray(getattr(body, name))


NUMBERS = ("force", "spin_moment", "friction_power", "creepage")


def listed(result: TangentialResult) -> Array:
    power = float((result.dissipation * result.area).sum()) * result.motion.slip_speed
    return np.array([*result.force, result.spin_moment, power, *result.creepage])


SLOW = ("coupled and inclined", "coupled and yielding")


@pytest.mark.parametrize(
    "case", [pytest.param(name, marks=pytest.mark.slow) if name in SLOW else name for name in CASES]
)
def test_each_number_by_each_input(case: str) -> None:
    given = {"field": CONTACT} | CASES[case]
    result = solved(given)
    gradients = {of: result.gradient(of) for of in NUMBERS}
    random = np.random.default_rng(3)
    tried = 0
    for by in gradients["force"]:
        size = np.asarray(value_of(given, by))
        change = size * (0.5 + random.random(() if by == "normal_layer_field" else size.shape))

        def at(h: float, by: str = by, change: Array = change) -> Array | None:
            moved = solved(changed(given, by, h * change))
            return listed(moved) if np.array_equal(moved.status, result.status) else None

        steps = [at(s * h) for h in (2e-4, 1e-4) for s in (1.0, -1.0)]
        if any(step is None for step in steps):
            continue
        tried += 1
        far, near = ((a - b) / (2 * h) for a, b, h in ((*steps[:2], 2e-4), (*steps[2:], 1e-4)))  # type: ignore[operator]
        expected = (4.0 * near - far) / 3.0
        parts = [np.tensordot(gradients[of][by], change, change.ndim) for of in NUMBERS]
        found = np.concatenate([np.atleast_1d(part) for part in parts])
        sizes = np.abs(listed(result)) + 1e-3 * np.abs(expected)
        sizes[:3], sizes[-3:-1] = sizes[:3].max(), sizes[-3:-1].max() + 1e-12
        wrong = np.abs(found - expected) / np.maximum(sizes, 1e-12)
        assert wrong.max() < 2e-6, (by, found, expected)
    assert tried > 0.7 * len(gradients["force"])


@pytest.mark.parametrize("case", [name for name in CASES if name.startswith("yielding")])
def test_plastic_slip_and_its_heat(case: str) -> None:
    given = {"field": CONTACT} | CASES[case]
    result, random = solved(given), np.random.default_rng(4)
    names = ("slip", "plastic_slip", "accumulated_plastic_slip", "dissipation", "plastic_dissipation")
    # all ways to yield: not, for all of the slip, for a part of it
    share = np.hypot(*result.plastic_slip)[result.status > 1]
    assert share.any()
    weights = [{name: random.random(np.shape(getattr(result, name)))} for name in names]

    def sums(of: TangentialResult) -> Array:
        return np.array([(w[n] * getattr(of, n)).sum() for w, n in zip(weights, names, strict=True)])

    gradient = result.gradient(weights)
    inputs = [n for n in gradient if n.startswith(("layer", "state", "friction"))]
    tried = 0
    inputs += [name for name in ("creepage", "displacement", "pressure", "gap") if name in gradient]
    for by in inputs:
        size = np.asarray(value_of(given, by))
        change = 0.1 * size * (0.5 + random.random(size.shape))
        states: list[bool] = []

        def at(h: float, by: str = by, change: Array = change, states: list[bool] = states) -> Array:
            moved = solved(changed(given, by, h * change))
            states.append(np.array_equal(moved.status, result.status))
            return sums(moved)

        far, near = ((at(h) - at(-h)) / (2 * h) for h in (2e-3, 1e-3))
        expected = (4.0 * near - far) / 3.0
        found = np.tensordot(gradient[by], change, change.ndim)
        sizes = np.maximum(np.abs(sums(result)), np.abs(expected))
        if all(states):
            tried += 1
            assert (np.abs(found - expected) < 2e-6 * sizes).all(), (by, found, expected)
        forward = result.derivative("accumulated_plastic_slip", by) if size.ndim == 0 else None
        if forward is not None:
            own = (weights[2]["accumulated_plastic_slip"] * forward).sum()
            assert own == pytest.approx(gradient[by][2], rel=1e-8)
    assert tried > 0.7 * len(inputs)


def test_rolling_at_rest_has_the_coefficients_of_kalker() -> None:
    contact = field(60, 60)
    result = mtb.solve_tangential(contact, mtb.Rolling((0.0, 0.0, 0.0)), mtb.Coulomb(0.3), tolerance=1e-10)
    c11, c22, c23, _ = mtb._mtb_rs.kalker_coefficients(A / B, mtb.steel.poisson_ratio)
    scale = mtb.steel.shear_modulus * A * B
    found = result.derivative("force", "creepage")
    # the upper body drags the lower one along
    assert found[0, 0] == pytest.approx(c11 * scale, rel=0.03)
    assert found[1, 1] == pytest.approx(c22 * scale, rel=0.03)
    assert abs(found[1, 2]) == pytest.approx(c23 * scale * np.sqrt(A * B), rel=0.03)
    assert abs(found[0, 1]) < 1e-9 * found[0, 0]
    assert result.margin().sticking == np.inf


def test_a_shift_of_a_sphere_is_as_stiff_as_cattaneo_and_mindlin_found() -> None:
    radius, cells = 2e-3, 60
    dx = 2.1 * radius / cells
    x = (np.arange(cells) - 0.5 * (cells - 1)) * dx
    pressure = PEAK * np.sqrt(np.maximum(1.0 - (x[None, :] ** 2 + x[:, None] ** 2) / radius**2, 0.0))
    ball = PressureField(pressure, (dx, dx), mtb.steel, mtb.steel)
    force, friction = 0.5, 0.3
    limit = friction * ball.normal_force
    result = mtb.solve_tangential(
        ball, mtb.Shift(force=(force * limit, None)), mtb.Coulomb(friction), tolerance=1e-10
    )
    # dd/dF = (2 - nu) / (8 a G) (1 - F / (mu N))^(-1/3) for each of two like bodies
    one = (2.0 - 0.3) / (8.0 * radius * mtb.steel.shear_modulus) * (1.0 - force) ** (-1.0 / 3.0)
    assert result.derivative("creepage", "force")[0, 0] == pytest.approx(2.0 * one, rel=0.02)


@pytest.mark.parametrize("kind", ["shift", "steady"])
def test_both_sides_of_a_cell_about_to_slip(kind: str) -> None:
    """Where a cell only just sticks, each side has its own derivative, and the margin says so."""

    def at(along: float) -> TangentialResult:
        motion: Any = mtb.Shift((along, 3e-7), spin=1e-4)
        if kind == "steady":
            motion = mtb.Rolling((1e3 * along, 3e-4, 0.1))
        return solved({"field": CONTACT, "motion": motion, "friction": mtb.Coulomb(0.3)})

    by, unit = ("displacement", 1.0) if kind == "shift" else ("creepage", 1e3)
    low, high = 1e-6, 1.2e-6
    while high - low > 1e-16:
        middle = 0.5 * (low + high)
        if np.array_equal(at(middle).status, at(low).status):
            low = middle
        else:
            high = middle
    sides = [at(low), at(high)]
    assert (sides[0].status != sides[1].status).sum() == 1
    margins = [side.margin() for side in sides]
    # the one sticks on its bound, the other slips by nothing
    assert min(m for m in (margins[0].slipping, margins[0].sticking) if m is not None) < 1e-5
    assert min(m for m in (margins[1].slipping, margins[1].sticking) if m is not None) < 1e-5
    slopes = [unit * side.derivative("force", by)[0, 0] for side in sides]
    assert abs(slopes[0] / slopes[1] - 1.0) > 1e-4
    for side, place, sign, slope in zip(sides, (low, high), (-1.0, 1.0), slopes, strict=True):
        h = 1e-10
        near, far = ((at(place + sign * k * h).force[0] - side.force[0]) / (sign * k * h) for k in (1, 2))
        assert 2.0 * near - far == pytest.approx(slope, rel=1e-5)


def test_steps_of_a_chain() -> None:
    motion = mtb.Rolling((1e-3, 5e-4, 0.1), transient=True)

    def chain(static: float, pressure: float) -> list[TangentialResult]:
        friction, results = replace(FALLING, static=static), []
        state = None
        contact = replace(CONTACT, pressure=pressure * CONTACT.pressure)
        for _ in range(3):
            results.append(mtb.solve_tangential(contact, motion, friction, state=state, tolerance=1e-12))
            state = results[-1].state
        return results

    results = chain(0.34, 1.0)
    found = mtb.gradient_of_steps(results, [{}, {"traction": results[1].area}, "spin_moment"])

    def number(results: list[TangentialResult]) -> float:
        return float((results[1].traction * results[1].area).sum() + results[2].spin_moment)

    def slope(at: Callable[[float], float], h: float) -> float:
        near, far = ((at(s) - at(-s)) / (2.0 * s) for s in (0.5 * h, h))
        return (4.0 * near - far) / 3.0

    by_static = slope(lambda h: number(chain(0.34 + h, 1.0)), 2e-5)
    assert sum(by["friction.static"] for by in found) == pytest.approx(by_static, rel=1e-6)
    by_pressure = slope(lambda h: number(chain(0.34, 1.0 + h)), 1e-5)
    total = sum(float((by["pressure"] * CONTACT.pressure).sum()) for by in found)
    assert total == pytest.approx(by_pressure, rel=1e-6)


def test_a_chain_of_steps_carries_plastic_slip() -> None:
    # to and fro: the second step starts without plastic slip of its own before it
    motions = [mtb.Shift((1e-6, 5e-7)), mtb.Shift((2e-6, -1e-6)), mtb.Shift((-3e-6, 1e-6))]
    layers = [None, PLASTIC, PLASTIC]

    def ride(change: float) -> list[TangentialResult]:
        state, results = None, []
        for k, (motion, layer) in enumerate(zip(motions, layers, strict=True)):
            x, y = motion.displacement
            moved = mtb.Shift((x + change * (k < 2), y))
            results.append(
                solved({"field": CONTACT, "motion": moved, "friction": mtb.Coulomb(0.3), "layer": layer}
                | {"state": state})
            )  # fmt: skip
            state = results[-1].state
        return results

    results = ride(0.0)
    weight = np.random.default_rng(2).random(SHAPE)
    of = [{}, {}, {"accumulated_plastic_slip": weight}]
    found = sum(by["displacement"][0] for by in mtb.gradient_of_steps(results, of)[:2])

    def value(change: float) -> float:
        return float((weight * ride(change)[-1].accumulated_plastic_slip).sum())

    far, near = ((value(h) - value(-h)) / (2 * h) for h in (2e-11, 1e-11))
    assert found == pytest.approx((4.0 * near - far) / 3.0, rel=2e-6)


def test_steps_of_a_chain_whose_pressure_follows_the_traction() -> None:
    motion, friction = mtb.Rolling((1e-3, 5e-4, 0.1), transient=True), mtb.Coulomb(0.3)

    def chain(force: float) -> list[TangentialResult]:
        results: list[TangentialResult] = []
        for _ in range(2):
            state = results[-1].state if results else None
            given = {"motion": motion, "friction": friction, "state": state, "normal_force": force}
            results.append(solved(PRESSED | given))
        return results

    results = chain(PRESSED_BY)
    by_first, by_second = mtb.gradient_of_steps(results, [{"pressure": 1e-3 * GAP}, "spin_moment"])

    def number(force: float) -> float:
        one, two = chain(force)
        return float((1e-3 * GAP * one.pressure).sum() + two.spin_moment)

    near, far = ((number(PRESSED_BY + h) - number(PRESSED_BY - h)) / (2 * h) for h in (0.05, 0.1))
    found = by_first["normal_force"] + by_second["normal_force"]
    assert found == pytest.approx((4.0 * near - far) / 3.0, rel=1e-6)


def test_both_ways_where_the_pressure_follows_the_traction() -> None:
    result = solved(PRESSED | COUPLED["coupled steady"])
    by = result.gradient("force")
    for name in ("creepage", "normal_force", "friction", "lower.poisson_ratio", "upper.young_modulus"):
        forward = result.derivative("traction", name)
        summed = np.tensordot(result.area, forward[0], 2)
        np.testing.assert_allclose(summed, by[name][0], rtol=1e-8, atol=1e-8 * np.abs(by[name]).max())
        pressed = np.tensordot(result.area, result.derivative("pressure", name), 2)
        np.testing.assert_allclose(pressed, -by[name][2], atol=1e-8 * np.abs(by[name]).max())
    # without the way back from traction to pressure they are others
    one_way = solved(PRESSED | COUPLED["coupled steady"] | {"coupling": "one-way"})
    assert np.abs(one_way.derivative("force", "creepage")[0] / by["creepage"][0] - 1.0).max() > 1e-4
    margin = result.margin()
    assert 0.0 < margin.parting < 1.0
    assert margin.slipping is not None
    assert 0.0 < margin.slipping < 1.0


def test_a_gradient_at_100_cells_a_side_takes_few_products() -> None:
    contact = field(110, 110)
    result = mtb.solve_tangential(contact, mtb.Rolling((1e-3, 5e-4, 0.1)), mtb.Coulomb(0.3), tolerance=1e-8)
    tangent = result._tangent()
    tangent.adjoint({"traction": np.stack([np.stack([result.area] * 3)])})
    assert result.report.convolutions is not None
    assert tangent.products < result.report.convolutions


def test_what_has_no_derivatives_says_why() -> None:
    given = {"field": CONTACT, **CASES["steady"]}
    with pytest.raises(ValueError, match="read from a file or put together"):
        replace(solved(given)).derivative("force", "creepage")
    with pytest.raises(ValueError, match="creepage"):
        solved(given).derivative("force", "creepages")
    with pytest.raises(ValueError, match=r"by is 'gap': the pressure is given.*coupling='full'"):
        solved(given).derivative("force", "gap")
    with pytest.raises(KeyError, match=r"'gap' has no entry: the pressure is given.*coupling='full'"):
        solved(given).gradient("force")["gap"]
    with pytest.raises(ValueError, match="by is 'angle': the surface is inclined"):
        solved({"field": CURVED, **CASES["inclined, steady"]}).derivative("force", "angle")
    with pytest.raises(ValueError, match="by is 'step': the memory of the friction is carried along"):
        solved({"field": CONTACT, **CASES["steady falling"]}).derivative("force", "step")
    with pytest.raises(ValueError, match="by is 'pressure': the pressure is found"):
        solved(CASES["coupled like bodies"]).derivative("force", "pressure")


def test_a_step_of_one_cell_with_a_layer_has_the_derivative_of_a_longer_one() -> None:
    cell = CONTACT.spacing[0]

    def rolled(step: float) -> Array:
        motion = mtb.Rolling((1e-3, -8e-4, 0.3), step=step)
        return listed(solved({"field": CONTACT, "motion": motion, "friction": SPOTTED, "layer": LAYER}))

    motion = mtb.Rolling((1e-3, -8e-4, 0.3))
    here = solved({"field": CONTACT, "motion": motion, "friction": SPOTTED, "layer": LAYER})
    found = np.array([*here.derivative("force", "step")[:2], here.derivative("friction_power", "step")])
    ahead, behind = (
        (4.0 * (rolled(cell + s * h) - rolled(cell)) - (rolled(cell + 2 * s * h) - rolled(cell)))
        / (2 * s * h)
        for s, h in ((1.0, 2e-8), (-1.0, 2e-8))
    )
    np.testing.assert_allclose(found, ahead[[0, 1, 4]], rtol=1e-5)
    assert abs(behind[0] / found[0] - 1.0) > 1e-2


@pytest.mark.parametrize("beside", [3e-4, -3e-4, 5e-3])
def test_derivatives_of_steps_that_end_beside_a_border_of_a_cell(beside: float) -> None:
    """The slope of the influence is that of a logarithm there."""
    dx, dy = CONTACT.spacing
    angle = float(np.arctan2(0.8 * dy, (0.5 + beside) * dx))
    length = float(np.hypot(0.8 * dy, (0.5 + beside) * dx))

    def rolled(step: float, angle: float) -> TangentialResult:
        motion = mtb.Rolling((1e-3, -8e-4, 0.3), step=step, angle=angle)
        return solved({"field": CONTACT, "motion": motion, "friction": mtb.Coulomb(0.3)})

    here = rolled(length, angle)
    h = 1e-2 * abs(beside)
    for by, size, at in (
        ("step", length, lambda e: rolled(length + e, angle)),
        ("angle", 1.0, lambda e: rolled(length, angle + e)),
    ):
        near, far = ((at(k * h * size).force - at(-k * h * size).force) / (2 * k * h * size) for k in (1, 2))
        expected = (4.0 * near - far)[:2] / 3.0
        # of solves with twelve digits, over such a width
        assert here.derivative("force", by)[:2] == pytest.approx(expected, rel=1e-5), by


def test_heat_by_step_and_angle_at_each_cell() -> None:
    weights = np.random.default_rng(2).random(SHAPE)
    given = {"field": CONTACT, "friction": mtb.Coulomb(0.3)}

    def heat(step: float, angle: float) -> float:
        motion = mtb.Rolling((1e-3, -8e-4, 0.3), step=step, angle=angle)
        return float((solved(given | {"motion": motion}).dissipation * weights).sum())

    here = solved(given | {"motion": mtb.Rolling((1e-3, -8e-4, 0.3), step=3.3e-4, angle=0.2)})
    for by, h, at in (
        ("step", 3e-8, lambda e: heat(3.3e-4 + e, 0.2)),
        ("angle", 1e-4, lambda e: heat(3.3e-4, 0.2 + e)),
    ):
        near, far = ((at(k * h) - at(-k * h)) / (2 * k * h) for k in (1, 2))
        expected = (4.0 * near - far) / 3.0
        assert here.derivative({"dissipation": weights}, by) == pytest.approx(expected, rel=1e-6)
        summed = float((here.derivative("dissipation", by) * weights).sum())
        assert summed == pytest.approx(expected, rel=1e-6)


@pytest.mark.filterwarnings("ignore:StaticKinetic depends on the grid")
def test_fields_out_of_contact_have_the_derivatives_of_what_they_show() -> None:
    x = (np.arange(16) - 7.5) * 0.3e-3
    gap = (x[None, :] ** 2 + x[:, None] ** 2) / 0.6
    pressed = mtb.solve_normal(gap, 0.3e-3, lower=mtb.steel, upper=mtb.Material(80e9, 0.1), force=1e3)

    def rolled(along: float, friction: Any) -> mtb.TangentialResult:
        return mtb.solve_tangential(pressed, mtb.Rolling((along, 2e-4, 0.1)), friction, tolerance=1e-12)

    here = rolled(1e-3, mtb.Coulomb(0.3))
    ahead, behind = (rolled(1e-3 + e, mtb.Coulomb(0.3)) for e in (1e-7, -1e-7))
    weights = np.zeros((2, 16, 16))
    weights[0] = 1.0
    found = here.derivative({"slip": weights}, "creepage")[0]
    assert found == pytest.approx((ahead.slip[0].sum() - behind.slip[0].sum()) / 2e-7, rel=1e-5)
    assert not here.derivative("slip", "creepage")[:, here.status == 0].any()
    ones = {"friction_coefficient": np.ones((16, 16))}
    assert here.derivative(ones, "friction") == pytest.approx(256.0)
    np.testing.assert_allclose(here.derivative(ones, "friction_field"), 1.0)
    both = rolled(1e-3, mtb.StaticKinetic(0.4, 0.3))
    slips = int((both.status == 2).sum())
    assert both.derivative(ones, "friction.kinetic") == pytest.approx(slips)
    assert both.derivative(ones, "friction.static") == pytest.approx(256 - slips)


def test_a_chain_is_told_from_steps_that_are_none() -> None:
    x = (np.arange(16) - 7.5) * 0.3e-3
    gap = (x[None, :] ** 2 + x[:, None] ** 2) / 0.6
    pressed = mtb.solve_normal(gap, 0.3e-3, lower=mtb.steel, upper=mtb.steel, force=1e3)
    steps: list[mtb.TangentialResult] = []
    for _ in range(3):
        state = steps[-1].state if steps else None
        steps.append(mtb.solve_tangential(pressed, mtb.Shift((1e-7, 0.0)), mtb.Coulomb(0.3), state=state))
    of = {"traction": np.stack([steps[0].area, *np.zeros((2, 16, 16))])}
    assert len(mtb.gradient_of_steps(iter(steps), [{}, {}, of])) == 3
    for wrong in ([steps[0], steps[2]], steps[::-1], [steps[1], steps[1]]):
        with pytest.raises(ValueError, match=r"results\[1\] does not start from the state of results\[0\]"):
            mtb.gradient_of_steps(wrong, [{}] * len(wrong))
    with pytest.raises(
        ValueError, match=r"results\[0\] is .*: results of solve_tangential, steps of .* are needed"
    ):
        mtb.gradient_of_steps([pressed], [{}])  # type: ignore[list-item]


def test_open_cells_have_their_own_coefficient() -> None:
    result = mtb.solve_tangential(CONTACT, mtb.Shift((1e-6, 0.0)), SPOTTED)
    assert (result.status == 0).any()
    np.testing.assert_array_equal(result.friction_coefficient, SPOTTED.coefficient)
    by = result.gradient({"friction_coefficient": np.ones(SHAPE)})["friction_field"]
    np.testing.assert_allclose(by, 1.0)


@pytest.mark.parametrize(
    ("motion", "by", "power"),
    [
        (mtb.Rolling((2e-3, 1e-3, 0.3), velocity=12.0), "velocity", 1),
        (mtb.Shift((8e-6, 0.0), duration=0.02), "duration", -1),
    ],
)
def test_heat_of_fixed_friction_follows_the_speed(motion: Any, by: str, power: int) -> None:
    # power is heat of a unit of way or time, times the speed or over the duration
    result = mtb.solve_tangential(CONTACT, motion, mtb.Coulomb(0.3))
    heat = motion.slip_speed * (result.dissipation * result.area).sum()
    wanted = power * heat / getattr(motion, by)
    assert result.derivative("friction_power", by) == pytest.approx(wanted, rel=1e-12)
    assert result.gradient("friction_power")[by] == pytest.approx(wanted, rel=1e-12)
    assert not np.any(result.derivative("force", by))


@pytest.mark.parametrize("wrong", [None, "steps", 3.0, {"a": 1}])
def test_a_chain_that_is_no_sequence_is_refused_in_words(wrong: Any) -> None:
    result = mtb.solve_tangential(CONTACT, mtb.Shift((1e-6, 0.0)), mtb.Coulomb(0.3))
    with pytest.raises(
        ValueError,
        match=r"^results is .*: results of solve_tangential, steps of a contact or of wheels, one a step",
    ):
        mtb.gradient_of_steps(wrong, [{}])
    with pytest.raises(
        ValueError, match=r"^of is .*: names or weights of fields, one entry a step, are needed"
    ):
        mtb.gradient_of_steps([result], wrong)
    assert mtb.gradient_of_steps([], []) == []


@pytest.mark.parametrize("wrong", [None, [], "", 3.0, {"pressure": None}, {"pressure": "large"}, [None]])
def test_what_cannot_be_derived_is_refused_in_words(wrong: Any) -> None:
    result = mtb.solve_tangential(CONTACT, mtb.Shift((1e-6, 0.0)), mtb.Coulomb(0.3))
    for ask in (lambda: result.derivative(wrong, "pressure"), lambda: result.gradient(wrong)):
        with pytest.raises(ValueError, match=r"^of"):
            ask()
    bad: list[Any] = [None, [], "", 3.0, ["pressure"], {}]
    for by in bad:
        with pytest.raises(ValueError, match=r"^by is"):
            result.derivative("force", by)
