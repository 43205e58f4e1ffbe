# SPDX-License-Identifier: MIT OR Apache-2.0
"""Derivatives of contacts of cells on prisms against differences of solves."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import mtb_rs as mtb

Array = NDArray[np.float64]

STEEL = mtb.Material.from_shear_modulus(82e9, 0.28)
SOFT = mtb.Material.from_shear_modulus(40e9, 0.35)
RADIUS, SIDE, NX, NY = 0.01, 1.2e-3, 12, 9
ROLLING = mtb.Rolling((6e-4, -4e-4, 0.3), step=0.9 * SIDE, velocity=30.0)
BACKWARDS = mtb.Rolling((5e-4, 3e-4, -0.2), step=1.3 * SIDE, velocity=20.0, angle=np.pi)
SHIFT = mtb.Shift((2e-6, -1e-6), duration=1e-3)


def corner(material: mtb.Material, **given: Any) -> mtb.Prism:
    """A rail of a round corner on a column that falls to one side."""
    turn = np.linspace(np.pi, 0.4 * np.pi, 201)
    arc = RADIUS * np.stack([np.cos(turn), np.sin(turn)], axis=1)
    free = [[-RADIUS, -0.03], *arc.tolist(), [0.03, 0.006], [0.03, -0.03]]
    return mtb.Prism(free, material=material, origin=tuple(arc[100]), **given)


def root(material: mtb.Material) -> mtb.Prism:
    """What lies above the same arc."""
    turn = np.linspace(np.pi, 0.4 * np.pi, 201)
    arc = RADIUS * np.stack([np.cos(turn), np.sin(turn)], axis=1)
    free = [[-RADIUS, -0.01], *arc.tolist(), [0.03, 0.006]]
    base = [[0.03, 0.03], [-0.03, 0.03], [-0.03, -0.01]]
    return mtb.Prism(free, base=base, material=material, origin=tuple(arc[100]))


PAIRS: dict[str, dict[str, Any]] = {
    "corner": {"lower": corner(STEEL), "upper": SOFT},
    "corner on springs": {"lower": corner(STEEL, foundation=(3e9, 1e9)), "upper": STEEL},
    "both": {"lower": corner(STEEL), "upper": root(SOFT)},
}


def gap() -> Array:
    x, y = (SIDE * (np.arange(n) - 0.5 * (n - 1)) for n in (NX, NY))
    rough = 2e-7 * np.random.default_rng(3).random((NY, NX))
    return np.asarray(x**2 / 1.1 + y[:, None] ** 2 * 1.5 + 0.001 * y[:, None] + rough)


def pressed(**given: Any) -> mtb.NormalResult:
    load = {} if "approach" in given else {"force": 9e3}
    options: dict[str, Any] = {"gap": gap(), "edge": "sharp", "tolerance": 1e-12} | load | given
    return mtb.solve_normal(options.pop("gap"), SIDE, **options)


def material(given: dict[str, Any], by: str, e: float) -> dict[str, Any]:
    """The same with a constant of a body changed by e."""
    side, _, name = by.partition(".")
    body = given[side]
    own = body.material if isinstance(body, mtb.Prism) else body
    own = replace(own, **{name: getattr(own, name) + e})
    return given | {side: replace(body, material=own) if isinstance(body, mtb.Prism) else own}


def richardson(of: Callable[[float], Array], by: float) -> Array:
    wide, narrow = ((of(h) - of(-h)) / (2.0 * h) for h in (by, 0.5 * by))
    return np.asarray((4.0 * narrow - wide) / 3.0)


def agree(by: str, found: Array, of: Callable[[float], Array], width: float) -> None:
    """Derivatives along a direction equal differences to 1e-6, or to a fiftieth of that of the numbers."""
    wanted = richardson(of, width)
    allowed = 1e-6 * np.maximum(np.abs(wanted), np.abs(of(0.0)) / 50.0)
    assert np.all(np.abs(found - wanted) <= allowed), (by, found, wanted, allowed)


def waves(*shape: int) -> Array:
    """Weights of either sign."""
    return np.cos(np.arange(np.prod(shape)).reshape(shape) ** 1.1)


#: What is asked for, and the fields that it weighs.
OF: dict[str, dict[str, Any]] = {
    "normal": {
        "approach": "approach",
        "mean_pressure": "mean_pressure",
        "pressure": {"pressure": waves(NY, NX)},
        "gap": {"gap": waves(NY, NX)},
    },
    "tangential": {
        "friction_power": "friction_power",
        "traction": {"traction": waves(3, NY, NX)},
        "slip": {"slip": waves(2, NY, NX)},
        "dissipation": {"dissipation": waves(NY, NX)},
    },
}


def values(result: Any, of: dict[str, Any]) -> Array:
    return np.array(
        [
            np.sum(weights[name] * getattr(result, name))
            if isinstance(weights, dict)
            else _number(result, weights)
            for name, weights in of.items()
        ]
    )


def _number(result: Any, name: str) -> float:
    if name == "mean_pressure":
        return float(result.pressure.sum() / (result.status > 0).sum())
    return float(getattr(result, name))


def check(
    result: Any,
    of: dict[str, Any],
    by: str,
    change: Any,
    moved: Callable[[float], Any],
    width: float,
) -> None:
    """Adjoint and forward derivatives along a change of an input, against differences of solves."""
    back = np.array([np.sum(np.asarray(result.gradient(asked)[by]) * change) for asked in of.values()])
    agree(by, back, lambda e: values(moved(e) if e else result, of), width)
    for asked, found in zip(of.values(), back, strict=True):
        if np.ndim(change) == 0:  # a field by a number is one forward solve
            there = result.derivative(asked, by) * change
            assert float(there) == pytest.approx(found, rel=1e-8, abs=1e-12 * abs(back).max())


PRESSED: dict[str, dict[str, Any]] = {
    "force": {**PAIRS["both"], "force": 9e3},
    "approach": {**PAIRS["corner on springs"], "approach": 3e-5},
    "layer": {**PAIRS["corner"], "force": 9e3, "normal_layer": 4e-15},
    "hardness": {**PAIRS["corner"], "force": 9e3, "hardness": 1.3e9},
}


@pytest.mark.parametrize("kind", PRESSED)
def test_pressures_on_prisms(kind: str) -> None:
    given = PRESSED[kind]
    result = pressed(**given)
    along = 1e-6 * waves(NY, NX)
    check(result, OF["normal"], "gap", along, lambda e: pressed(**given, gap=gap() + e * along), 1e-3)
    for name in ("force", "approach", "normal_layer", "hardness"):
        if name in given:
            size = given[name]
            check(
                result,
                OF["normal"],
                name,
                size,
                lambda e, name=name, size=size: pressed(**given | {name: size * (1.0 + e)}),
                1e-4,
            )


@pytest.mark.parametrize("kind", ["approach", "layer"])
def test_pressures_by_moduli(kind: str) -> None:
    given = PRESSED[kind]
    result = pressed(**given)
    for by, size in (
        ("lower.young_modulus", 2e11),
        ("lower.poisson_ratio", 0.3),
        ("upper.young_modulus", 1e11),
    ):
        check(
            result,
            OF["normal"],
            by,
            size,
            lambda e, by=by, size=size: pressed(**material(given, by, e * size)),
            1e-4,
        )


#: Bodies, motion, and coupling.
SHEARED: dict[str, tuple[str, Any, str]] = {
    "shift": ("both", SHIFT, "one-way"),
    "transient": ("corner", replace(ROLLING, transient=True), "one-way"),
    "steady": ("both", ROLLING, "one-way"),
    "steady backwards": ("corner on springs", BACKWARDS, "one-way"),
    "coupled": ("corner", ROLLING, "full"),
}


def under(pressure: Array, bodies: dict[str, Any]) -> mtb.PressureField:
    return mtb.PressureField(pressure, (SIDE, SIDE), **bodies)


class Sheared:
    """A contact that shifts or rolls."""

    def __init__(self, kind: str) -> None:
        self.bodies, self.motion, self.coupling = SHEARED[kind]
        self.state = None
        if kind in ("shift", "transient"):
            before = self.solved(motion=mtb.Shift((1e-6, -1e-6)))
            self.state = before.state
        self.result = self.solved()

    def solved(self, **given: Any) -> mtb.TangentialResult:
        options: dict[str, Any] = {
            "motion": self.motion,
            "friction": mtb.Coulomb(0.3),
            "layer": mtb.InterfaceLayer(2e-5, 1e9),
            "state": self.state,
            "normal": PAIRS[self.bodies],
            "gap": gap(),
            "pressure": None,
        }
        options |= given
        normal = pressed(**options.pop("normal"), gap=options.pop("gap"))
        pressure = options.pop("pressure")
        field: Any = normal
        if self.coupling == "one-way":
            field = under(
                normal.pressure if pressure is None else normal.pressure * pressure, PAIRS[self.bodies]
            )
        return mtb.solve_tangential(
            field,
            options["motion"],
            options["friction"],
            layer=options["layer"],
            state=options["state"],
            tolerance=1e-12,
            coupling=self.coupling,
        )

    def check(self, by: str, change: Any, moved: Callable[[float], dict[str, Any]], width: float) -> None:
        check(self.result, OF["tangential"], by, change, lambda e: self.solved(**moved(e)), width)


@pytest.mark.parametrize("kind", SHEARED)
def test_tractions_on_prisms(kind: str) -> None:
    own = Sheared(kind)
    motion, state = own.motion, own.state
    own.check("friction", 0.3, lambda e: {"friction": mtb.Coulomb(0.3 * (1.0 + e))}, 1e-4)
    own.check("layer.thickness", 2e-5, lambda e: {"layer": mtb.InterfaceLayer(2e-5 * (1.0 + e), 1e9)}, 1e-3)
    if own.coupling == "full":
        along = 1e-6 * waves(NY, NX)
        own.check("gap", along, lambda e: {"gap": gap() + e * along}, 1e-3)
    else:
        along = 0.1 * own.result.pressure * waves(NY, NX)
        own.check("pressure", along, lambda e: {"pressure": 1.0 + 0.1 * e * waves(NY, NX)}, 1e-3)
    if isinstance(motion, mtb.Rolling):
        change = np.array([1e-4, -2e-4, 0.1])
        own.check(
            "creepage",
            change,
            lambda e: {"motion": replace(motion, creepage=tuple(motion.creepage + e * change))},
            1e-3,
        )
        size = 0.1 * SIDE
        own.check("step", size, lambda e: {"motion": replace(motion, step=motion.step + e * size)}, 1e-3)
        assert "angle" in own.result._tangent().refused
    if state is not None:
        pushed = 1e6 * waves(2, NY, NX) * (state.pressure > 0.0)
        own.check(
            "state.traction",
            pushed,
            lambda e: {"state": replace(state, traction=state.traction + e * pushed)},
            1e-3,
        )
        pulled = 0.1 * state.pressure * waves(NY, NX)
        own.check(
            "state.pressure",
            pulled,
            lambda e: {"state": replace(state, pressure=state.pressure + e * pulled)},
            1e-3,
        )


@pytest.mark.parametrize("kind", ["transient", "coupled"])
def test_tractions_by_moduli(kind: str) -> None:
    own = Sheared(kind)
    for by, size in (
        ("lower.young_modulus", 2e11),
        ("lower.poisson_ratio", 0.3),
        ("upper.poisson_ratio", 0.3),
    ):

        def moved(e: float, by: str = by, size: float = size) -> dict[str, Any]:
            return {"normal": material(PAIRS[own.bodies], by, e * size)}

        if own.coupling == "one-way":

            def solved(e: float, bodies: Callable[[float], dict[str, Any]] = moved) -> Any:
                return mtb.solve_tangential(
                    under(own.result.pressure, bodies(e)["normal"]),
                    own.motion,
                    mtb.Coulomb(0.3),
                    layer=mtb.InterfaceLayer(2e-5, 1e9),
                    state=own.state,
                    tolerance=1e-12,
                )

            check(own.result, OF["tangential"], by, size, solved, 1e-3)
        else:
            own.check(by, size, moved, 1e-3)
