# SPDX-License-Identifier: MIT OR Apache-2.0
"""Derivatives where something follows the state: the pull of a magnet the gap, a rough layer the pressure."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import mtb_rs as mtb

Array = NDArray[np.float64]

pytestmark = [
    pytest.mark.coarse,
    pytest.mark.filterwarnings("ignore:.*(deforms|displaces|away from).*:UserWarning"),
]

#: Few corners in the curve, so that no point of the contact is at one.
IRON = ((0.0, 1e2, 1e4, 1e5), (0.0, 1.2, 1.9, 2.0 + 4e-7 * np.pi * 1e5))
MAGNET = mtb.Magnet(
    3e3, 1e-3, iron=IRON, iron_share=1.9, pole_length=30e-3, yoke=(0.15, 3e-3), armature=(60e-3, 3e-3),
    leakage=1e-7, speed_factor=mtb.VelocityTable((0.0, 50.0), (1.0, 0.5)),
)  # fmt: skip
NUMBERS = ("ampere_turns", "non_magnetic_gap", "iron_share", "pole_length", "leakage", "yoke", "armature")


def slope(of: Callable[[float], Any]) -> Array:
    """Derivative at 0 by central differences with Richardson's extrapolation."""
    wide, near = ((np.asarray(of(h)) - np.asarray(of(-h))) / (2.0 * h) for h in (1.0, 0.5))
    return np.asarray((4.0 * near - wide) / 3.0)


def compared(made: Any, by: str, direction: Any, solve: Callable[[float], Any], of: dict[str, Any]) -> None:
    """Each number of a result by one input along a direction, against differences."""
    for how, value in of.values():
        exact = np.asarray(made.derivative(how, by))
        if np.ndim(direction):
            exact = np.tensordot(exact, direction, np.ndim(direction))
        else:
            exact = exact * direction
        wanted = slope(lambda s, value=value: value(solve(s)))
        # what hardly follows is rounding in differences
        least = 1e-7 * float(np.abs(value(made)).max())
        np.testing.assert_allclose(
            exact, wanted, rtol=1e-6, atol=1e-6 * max(float(np.abs(wanted).max()), least), err_msg=by
        )


def numbers_of(made: Any, seed: int = 5) -> dict[str, Any]:
    w = np.random.default_rng(seed).standard_normal(made.gap.shape)
    return {
        "force": ("force", lambda r: r.force),
        "pull": ({"magnetic_pressure": made.area}, lambda r: (r.magnetic_pressure * made.area).sum()),
        "gap": ({"gap": w}, lambda r: (w * r.gap).sum()),
    }


@pytest.mark.parametrize("model", ["half-space", "elastic-upper"])
def test_a_scene_under_a_magnet(model: Any) -> None:
    scene = mtb.scenes.pole_shoe_on_rail(
        friction=0.3, magnetic_pressure=MAGNET, spacing=1.2e-2, velocity=10.0, lateral=1e-3
    )
    made = scene.solve(model=model)
    of = numbers_of(made)
    for by in NUMBERS:
        value = np.array(getattr(MAGNET, by))
        direction = 1e-3 * value * (np.array([1.0, -0.7]) if value.ndim else 1.0)

        def solve(s: float, by: str = by, value: Array = value, direction: Array = direction) -> Any:
            moved = value + s * direction
            given = {by: tuple(moved) if moved.ndim else float(moved)}
            return scene.with_(magnetic_pressure=replace(MAGNET, **given)).solve(model=model)

        compared(made, f"magnetic_pressure.{by}", direction, solve, of)
    factors = np.array([1e-3, -2e-3])
    table = MAGNET.speed_factor
    assert table is not None

    def at_factors(s: float) -> Any:
        moved = replace(table, value=tuple(np.array(table.value) + s * factors))
        return scene.with_(magnetic_pressure=replace(MAGNET, speed_factor=moved)).solve(model=model)

    compared(made, "magnetic_pressure.speed_factor", factors, at_factors, of)
    compared(made, "velocity", 0.5, lambda s: scene.with_(velocity=10.0 + 0.5 * s).solve(model=model), of)
    # no gap is open, and the pull over a closed one hardly follows friction: differences are rounding there
    others = {"force": of["force"]}
    compared(
        made, "friction", 0.01, lambda s: scene.with_(friction=0.3 + 0.01 * s).solve(model=model), others
    )
    for by in ("magnetic_pressure", "magnetic_pressure_field"):
        with pytest.raises(ValueError, match=r"by the numbers of the magnet"):
            made.derivative("force", by)


def test_a_step_under_a_magnet_whose_gap_is_open() -> None:
    """A shoe that touches with one edge: where the gap is open the pull follows it."""
    scene = mtb.scenes.pole_shoe_on_rail(
        friction=0.3, magnetic_pressure=MAGNET, spacing=1.2e-2, velocity=10.0
    )
    contact = scene.prepare(model="elastic-upper")
    n = contact.area.size
    added = 1e-5 * np.random.default_rng(2).random(n)
    pose = np.array([0.0, 0.0, np.nan, 0.0, 2e-3, 0.0])

    def step(dp: Any = 0.0, dg: Any = 0.0, v: float = 10.0, magnet: Any = None, mu: float = 0.3) -> Any:
        return contact.copy().step(
            pose + dp, v, gap=added + dg, friction=np.full(n, mu), magnetic_pressure=magnet
        )

    made = step()
    assert 0 < (made.state.pressure > 0.0).sum() < n
    assert made.magnetic_pressure.max() > 1.05 * made.magnetic_pressure.min()
    of = numbers_of(made)
    tilt = np.array([0.0, 0.0, 0.0, 1e-7, 2e-7, 0.0])
    shape = 1e-9 * np.random.default_rng(3).standard_normal(n)
    compared(made, "pose", tilt, lambda s: step(dp=s * tilt), of)
    compared(made, "gap", shape, lambda s: step(dg=s * shape), of)
    compared(made, "velocity", np.array([0.5, 0.0]), lambda s: step(v=10.0 + 0.5 * s), of)
    compared(made, "friction", 1e-3, lambda s: step(mu=0.3 + 1e-3 * s), of)
    compared(
        made, "magnetic_pressure.ampere_turns", 1.0,
        lambda s: step(magnet=replace(MAGNET, ampere_turns=3e3 + s)), of,
    )  # fmt: skip
    # a magnet that holds its pull is another contact: the pull gives back what the gap takes
    held = contact.copy().step(
        pose, 10.0, gap=added, friction=np.full(n, 0.3), magnetic_pressure=made.magnetic_pressure
    )
    np.testing.assert_allclose(held.force, made.force, rtol=1e-8)
    ours, other = (r.derivative("force", "pose")[2, 3:5] for r in (made, held))
    assert not np.allclose(ours, other, rtol=1e-3)


def test_a_step_that_sticks_and_slips_under_a_magnet() -> None:
    """The pull moves the faces along each other, from step to step: against differences of rides."""
    scene = mtb.scenes.pole_shoe_on_rail(
        friction=0.3, magnetic_pressure=MAGNET, spacing=1.2e-2, velocity=10.0, attraction="both"
    )
    contact = scene.prepare(model="elastic-both")
    n, nan = contact.area.size, np.nan
    added = 2e-6 * np.random.default_rng(2).random(n)
    pose = np.array([nan, nan, nan, 0.0, 1e-5, nan])

    def ride(
        dp: Any = 0.0, dg: Any = 0.0, shift: float = 0.0, magnet: Any = None, v: float = 10.0
    ) -> list[Any]:
        own, steps = contact.copy(), []
        for k, along in enumerate((0.0, 3e-7, 2e-7 + shift)):
            last = {"magnetic_pressure": magnet} if k == 2 else {}
            steps.append(
                own.step(
                    pose + dp * (k == 2), v if k == 2 else 10.0, shift=(along, 0.0),
                    gap=added + dg * (k == 1), friction=np.full(n, 0.3), **last,
                )
            )  # fmt: skip
        return steps

    *_, before, made = ride()
    assert {1, 2} <= set(made.status.tolist())
    assert (made.status == 0).any()
    w = np.random.default_rng(5).standard_normal((3, n))
    of = numbers_of(made) | {
        "slip": ({"slip": w}, lambda r: (w * r.slip).sum()),
        "work": ("friction_work", lambda r: r.friction_work),
        "attraction": ("attraction", lambda r: r.report.magnet["attraction"]),
    }
    tilt = 1e-9 * np.array([0.0, 0.0, 0.0, 0.3, 1.0, 0.0])
    compared(made, "pose", tilt, lambda s: ride(dp=np.where(np.isnan(pose), 0.0, s * tilt))[-1], of)
    compared(made, "shift", np.array([1e-9, 0.0]), lambda s: ride(shift=1e-9 * s)[-1], of)
    compared(made, "velocity", np.array([0.5, 0.0]), lambda s: ride(v=10.0 + 0.5 * s)[-1], of)
    turns = "magnetic_pressure.ampere_turns"
    compared(made, turns, 1.0, lambda s: ride(magnet=replace(MAGNET, ampere_turns=3e3 + s))[-1], of)
    # through the step before, whose pull had answered too
    shape = 1e-10 * np.random.default_rng(3).standard_normal(n)
    by = mtb.gradient_of_steps([before, made], [{}, "friction_work"])[0]["gap"]
    assert by @ shape == pytest.approx(float(slope(lambda s: ride(dg=s * shape)[-1].friction_work)), rel=1e-5)


def test_bodies_with_inertia_of_their_own_take_a_pull_that_stays() -> None:
    contact = mtb.scenes.pole_shoe_on_rail(
        friction=0.3, magnetic_pressure=MAGNET, spacing=1.2e-2, velocity=10.0
    ).prepare(model="elastic-upper")
    with pytest.raises(ValueError, match="bodies that vibrate take a pull that the gap does not change"):
        contact.stability(100.0, density=7850.0)


CELLS = 12
X = (np.arange(CELLS) - 0.5 * (CELLS - 1)) * 1e-3
GAP = X[None, :] ** 2 / 0.6 + X[:, None] ** 2 / 0.8 + 2e-7 * np.random.default_rng(3).random((CELLS, CELLS))
SOFT, HARD = mtb.Material(80e9, 0.1), mtb.Material(200e9, 0.3)
LAYERS = {
    "exponential": mtb.RoughLayer.exponential(5e9, 0.5e-6),
    "table": mtb.RoughLayer([3e-6, 2e-6, 1.2e-6, 5e-7, 1e-7, 1e-8], [0.0, 1e6, 2e7, 2e8, 2e9, 9e9]),
}


@pytest.mark.parametrize("law", LAYERS)
@pytest.mark.parametrize(
    "load", [{"force": 1500.0}, {"approach": 8e-6}, {"force": 1500.0, "moments_about_axes": (0.2, -0.1)}]
)
def test_rough_layers_of_half_spaces(law: str, load: dict[str, Any]) -> None:
    layer = LAYERS[law]
    random = np.random.default_rng(4)

    def solved(**changed: Any) -> Any:
        given = {"lower": SOFT, "upper": HARD, "normal_layer": layer, "gap": GAP} | load | changed
        return mtb.solve_normal(given.pop("gap"), 1e-3, **given, edge="sharp", tolerance=1e-13, method="fft")

    made = solved()
    w = random.standard_normal(GAP.shape)
    of = {
        "pressure": ({"pressure": w}, lambda r: (w * r.pressure).sum()),
        "gap": ({"gap": w}, lambda r: (w * r.gap).sum()),
        "approach": ("approach", lambda r: r.approach),
    }
    if "approach" in load:
        of.pop("approach")
    field = 1e-10 * random.standard_normal(GAP.shape)
    known = {name: np.array(getattr(layer, name)) for name in ("gap", "pressure")}
    nodes = {"gap": 1e-10 * random.standard_normal(known["gap"].size)}
    nodes["pressure"] = 1e-4 * known["pressure"] * random.standard_normal(known["pressure"].size)
    compared(made, "gap", field, lambda s: solved(gap=GAP + s * field), of)
    for name, direction in nodes.items():

        def moved(s: float, name: str = name, direction: Array = direction) -> Any:
            return solved(normal_layer=replace(layer, **{name: list(known[name] + s * direction)}))

        compared(made, f"normal_layer.{name}", direction, moved, of)
    compared(made, "lower.young_modulus", 8e6, lambda s: solved(lower=mtb.Material(80e9 + 8e6 * s, 0.1)), of)
    for name, value in load.items():
        size = 1e-4 * np.array(value)

        def loaded(s: float, name: str = name, value: Any = value, size: Array = size) -> Any:
            there = np.array(value) + s * size
            return solved(**{name: tuple(there) if there.ndim else float(there)})

        compared(made, name, size, loaded, of)
    with pytest.raises(ValueError, match="derivatives are by the numbers of its law"):
        made.derivative("pressure", "normal_layer")


def test_a_rough_layer_of_a_scene() -> None:
    layer = LAYERS["exponential"]
    scene = mtb.Scene(
        HARD, SOFT, gap=GAP, spacing=1e-3, force=1500.0, friction=0.3, velocity=4.0,
        sliding_direction=(1.0, 0.5), normal_layer=layer,
    )  # fmt: skip
    made, contact = scene.solve(), scene.prepare()
    step = contact.step(velocity=tuple(4.0 * np.array([1.0, 0.5]) / np.hypot(1.0, 0.5)))
    w = np.random.default_rng(5).standard_normal(GAP.shape)
    of = {"pressure": ({"pressure": w}, lambda r: (w * r.pressure).sum())}
    for name in ("gap", "pressure"):
        known = np.array(getattr(layer, name))
        direction = 1e-4 * known * np.array([1.0, -0.5])

        def moved(s: float, name: str = name, known: Array = known, direction: Array = direction) -> Any:
            changed = replace(layer, **{name: list(known + s * direction)})
            return replace(scene, normal_layer=changed).solve()

        compared(made, f"normal_layer.{name}", direction, moved, of)
        own = step.derivative({"pressure": w.ravel()}, f"normal_layer.{name}")
        np.testing.assert_allclose(own, made.derivative({"pressure": w}, f"normal_layer.{name}"), rtol=1e-6)


@pytest.mark.parametrize("load", [{"force": 1500.0}, {"approach": 8e-6}])
@pytest.mark.parametrize("layer", [0.0, 1e-14, LAYERS["exponential"]])
def test_inclined_contacts(load: dict[str, float], layer: Any) -> None:
    angles = 0.3 * np.linspace(-1.0, 1.0, CELLS)
    random = np.random.default_rng(6)

    def solved(**changed: Any) -> Any:
        given = {"material": HARD, "gap": GAP, "normal_layer": layer} | load | changed
        bodies = dict.fromkeys(("lower", "upper"), given.pop("material"))
        return mtb.solve_normal(
            given.pop("gap"), 1e-3, **given, **bodies, inclination=angles, tolerance=1e-13, edge="sharp"
        )

    made = solved()
    w = random.standard_normal(GAP.shape)
    of = {
        "pressure": ({"pressure": w}, lambda r: (w * r.pressure).sum()),
        "gap": ({"gap": w}, lambda r: (w * r.gap).sum()),
    }
    field = 1e-10 * random.standard_normal(GAP.shape)
    compared(made, "gap", field, lambda s: solved(gap=GAP + s * field), of)
    (name, value), *_ = load.items()
    size = 1e-4 * value
    compared(made, name, size, lambda s: solved(**{name: value + s * size}), of)
