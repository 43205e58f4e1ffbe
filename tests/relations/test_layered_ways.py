# SPDX-License-Identifier: MIT OR Apache-2.0
"""A layered body in each way of asking: solved alike by all that take it, refused by name by the others."""

from __future__ import annotations

import pickle
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import mtb_rs as mtb
from mtb_rs.bodies.mesh import block_mesh

STEEL = mtb.steel
SOFT = mtb.Material(4e9, 0.38)
COATED = mtb.Layered(SOFT, 1e-3, STEEL)
LOOSE = replace(COATED, bonded=False)
ON_RIGID = mtb.Layered(SOFT, 1e-3, mtb.Rigid())
#: As a half-space of steel.
SAME = mtb.Layered(STEEL, 0.7e-3, STEEL)

STEP = 0.25e-3
X = (np.arange(24) - 11.5) * STEP
GAP = (X[None, :] ** 2 + X[:, None] ** 2) / 2.0
SCENE = mtb.Scene(STEEL, COATED, gap=GAP, spacing=STEP, friction=0.3, force=50.0)
LINE = np.array([[1e6, 2e6, 1e6]])


def normal(lower: Any = COATED, **given: Any) -> mtb.NormalResult:
    asked = {"upper": STEEL, "force": 50.0, "tolerance": 1e-11} | given
    return mtb.solve_normal(GAP, STEP, lower=lower, **asked)


# --- what takes it ----------------------------------------------------------------------------------------

MOTIONS = [
    mtb.Shift(displacement=(3e-7, 1e-7)),
    mtb.Rolling(creepage=(2e-4, 1e-4, 0.05)),
    mtb.Rolling(creepage=(2e-4, 0.0, 0.0), transient=True),
]


def ways() -> dict[str, Callable[[Any], Any]]:
    """Numbers that each way gives for a lower body."""

    def scene(lower: Any, **changes: Any) -> mtb.Scene:
        return SCENE.with_(lower=lower, **changes)

    found: dict[str, Callable[[Any], Any]] = {
        "force": lambda lower: normal(lower).pressure,
        "approach": lambda lower: normal(lower, force=None, approach=2e-6).pressure,
        "dense": lambda lower: normal(lower, method="dense").pressure,
        "periodic": lambda lower: normal(lower, periodic=True).pressure,
        "tilted": lambda lower: normal(lower, moments_about_axes=(0.0, 5e-3)).pressure,
        "hardness": lambda lower: normal(lower, hardness=5e6).pressure,
        "layer": lambda lower: normal(lower, normal_layer=1e-14).pressure,
        "above": lambda body: normal(STEEL, upper=body).pressure,
        "both": lambda body: normal(body, upper=body).pressure,
        "loads": lambda lower: (
            mtb.area_load_curve(GAP, STEP, [20.0, 50.0], lower=lower, upper=STEEL).approach
        ),
        "scene": lambda lower: scene(lower).solve().pressure,
        "no friction": lambda lower: scene(lower, sliding_direction=None).solve().pressure,
        "upper body of a scene": lambda body: scene(STEEL, upper=body).solve().traction,
        "displacement": lambda lower: scene(lower).solve().displacement.lower,
        "step": lambda lower: scene(lower).prepare().step().pressure,
        "sweep": lambda lower: mtb.sweep(scene(lower), {"friction": [0.1, 0.2]})["approach"],
        "increments": lambda lower: scene(lower).solve(method="incremental").pressure,
        "wear": lambda lower: mtb.wear(scene(lower), distance=1.0, law=1e-13).depth[:, -1],
        "full coupling": lambda lower: (
            mtb.solve_tangential(normal(lower), MOTIONS[1], mtb.Coulomb(0.3), coupling="full").traction
        ),
        "sensitivity": lambda lower: normal(lower).derivative("peak_pressure", "force"),
        "sensitivity to the gap": lambda lower: normal(lower).derivative("approach", "gap"),
        "sensitivity of a scene": lambda lower: scene(lower).solve().derivative("peak_pressure", "force"),
    }
    for motion in MOTIONS:
        found[repr(motion)] = lambda lower, motion=motion: (
            mtb.solve_tangential(normal(lower), motion, mtb.Coulomb(0.3)).traction
        )
    return found


@pytest.mark.coarse
@pytest.mark.parametrize("way", ways().values(), ids=ways().keys())
def test_each_way_takes_a_layer(way: Callable[[Any], Any]) -> None:
    plain, same, coated = (np.asarray(way(body), dtype=float) for body in (STEEL, SAME, COATED))
    size = np.abs(plain).max()
    # alike but for the solver's tolerance
    assert np.abs(same - plain).max() < 2e-6 * size
    assert np.abs(coated - plain).max() > 1e-2 * size


def test_a_contact_without_friction_takes_a_loose_layer() -> None:
    pressed = SCENE.with_(lower=LOOSE, sliding_direction=None).solve()
    alone = normal(LOOSE)
    np.testing.assert_allclose(
        pressed.pressure.reshape(24, 24), alone.pressure, atol=1e-6 * alone.pressure.max()
    )
    assert np.isfinite(pressed.displacement.lower).all()
    # it gives way more than one that is held at its base
    assert alone.approach > 1.05 * normal(COATED).approach


@pytest.mark.coarse
def test_sensitivities_are_differences() -> None:
    result = SCENE.solve()
    more = SCENE.with_(force=50.0 * (1.0 + 1e-4)).solve()
    slope = (more.report.peak_pressure - result.report.peak_pressure) / 50e-4
    assert result.derivative("peak_pressure", "force") == pytest.approx(slope, rel=2e-3)


def test_it_is_kept_and_comes_back(tmp_path: Path) -> None:
    for body in (COATED, LOOSE, ON_RIGID):
        assert pickle.loads(pickle.dumps(body)) == body
        result = normal(body)
        assert pickle.loads(pickle.dumps(result)) == result
        result.save(tmp_path / str(hash(body)))
        loaded = mtb.load(tmp_path / str(hash(body)))
        assert loaded == result
        assert loaded.lower == body
    assert COATED != LOOSE
    assert mtb.Layered(SOFT, 1e-3, mtb.HalfSpace(STEEL)) == COATED


@pytest.mark.parametrize(
    ("base", "more", "body"),
    [
        ("{ young_modulus = 208e9, poisson_ratio = 0.3 }", "", COATED),
        ('"rigid"', "", ON_RIGID),
        ('"rigid"', "bonded = false", replace(ON_RIGID, bonded=False)),
    ],
)
def test_case_files_say_it(tmp_path: Path, base: str, more: str, body: mtb.Layered) -> None:
    file = tmp_path / "case.toml"
    file.write_text(
        'scene = "paraboloid_on_plane"\nforce = 50.0\nradius = 1.0\nfriction = 0.0\n'
        "[lower]\nthickness = 1e-3\n"
        f"layer = {{ young_modulus = 4e9, poisson_ratio = 0.38 }}\nbase = {base}\n{more}\n"
    )
    assert mtb.load_case(file).scene().lower == body
    file.write_text(file.read_text().replace("thickness", "thicknes"))
    with pytest.raises(
        mtb.CaseError, match=r"lower\.thicknes = 0.001: unknown key; did you mean 'thickness'"
    ):
        mtb.load_case(file)


# --- what refuses it ----------------------------------------------------------------------------------------


def pad() -> mtb.ElasticBody:
    mesh = block_mesh(np.linspace(-0.04, 0.04, 3), np.linspace(-0.02, 0.02, 3), 0.03)
    return mtb.ElasticBody(mesh, STEEL, "contact", [mtb.Support("top", x=0, y=0)], "pad")


def field(body: mtb.Layered, **given: Any) -> mtb.PressureField:
    return mtb.PressureField(LINE, (STEP, STEP), body, STEEL, **given)


REFUSED: dict[str, tuple[Callable[[], Any], str]] = {
    "elastic model": (
        lambda: mtb.scenes.block_on_plane(spacing=0.02, lower=COATED).solve("elastic-upper"),
        "model is 'elastic-upper', and lower is Layered",
    ),
    "elastic body": (
        lambda: mtb.Scene(pad(), COATED, spacing=2e-2, friction=0.2, magnetic_pressure=1e6),
        "lower is a Layered beside an ElasticBody",
    ),
    "loose layer that rubs": (lambda: SCENE.with_(lower=LOOSE), r"not bonded, and friction is 0\.3"),
    "loose layer that rolls": (
        lambda: mtb.solve_tangential(normal(LOOSE), MOTIONS[1], mtb.Coulomb(0.3)),
        "lower is a Layered that is not bonded",
    ),
    "line contact": (lambda: field(COATED, reference=1.0), "lower is a Layered: in a line contact"),
    "Hertz": (lambda: mtb.hertz(50.0, 1.0, lower=COATED, upper=STEEL), "Hertz' contact takes"),
    "FASTSIM": (
        lambda: mtb.fastsim(normal(), (1e-3, 0, 0), mtb.Coulomb(0.3)),
        "solve_tangential takes layers",
    ),
    "Polach": (lambda: mtb.polach(normal(), (1e-3, 0, 0), mtb.Coulomb(0.3)), "solve_tangential takes layers"),
    "rough layer": (
        lambda: mtb.RoughLayer.from_surface(1e-6 * np.cos(GAP / STEP**2), STEP, lower=COATED, upper=STEEL),
        "the layer of a rough surface takes",
    ),
    "wheels in steps": (lambda: mtb.scenes.wheel_on_rail(lower=COATED).prepare(), "a wheel in steps takes"),
    "modulus of a rigid base": (
        lambda: normal(mtb.Layered(SOFT, 1e-3, mtb.Rigid())).derivative(
            "approach", "lower.base.young_modulus"
        ),
        "the base of this layer is rigid",
    ),
    "thickness": (lambda: mtb.Layered(SOFT, 0.0, STEEL), r"thickness is 0\.0: a positive number \[m\]"),
    "base": (lambda: mtb.Layered(SOFT, 1.0, "steel"), "base of a layer is 'steel'"),  # type: ignore[arg-type]
    "layer": (lambda: mtb.Layered(STEEL.young_modulus, 1.0, STEEL), "layer is 208"),  # type: ignore[arg-type]
}


def approach_of(solve: Callable[[Any], Any], body: mtb.Layered, name: str) -> float:
    """Richardson's difference of the approach by a constant of a layered body."""
    place, own = {
        "young_modulus": ("layer", body.layer.young_modulus),
        "poisson_ratio": ("layer", body.layer.poisson_ratio),
        "thickness": ("", body.thickness),
        "base.young_modulus": ("base", getattr(body.base, "young_modulus", 0.0)),
        "base.poisson_ratio": ("base", getattr(body.base, "poisson_ratio", 0.0)),
    }[name]

    def at(value: float) -> float:
        key = name.removeprefix("base.")
        changed = {key: value} if not place else {place: replace(getattr(body, place), **{key: value})}
        return float(solve(replace(body, **changed)).approach)

    width = 2e-3 * own
    wide, narrow = ((at(own + h) - at(own - h)) / (2.0 * h) for h in (width, 0.5 * width))
    return (4.0 * narrow - wide) / 3.0


@pytest.mark.coarse
@pytest.mark.parametrize("bonded", [True, False])
@pytest.mark.parametrize("base", [mtb.Rigid(), STEEL], ids=["rigid", "elastic"])
@pytest.mark.parametrize("way", ["free", "periodic", "scene"])
def test_constants_of_a_layer_are_derived(way: str, base: Any, bonded: bool) -> None:
    body = mtb.Layered(replace(SOFT, poisson_ratio=0.31), 1.3e-3, base, bonded)
    ways: dict[str, Callable[[Any], Any]] = {
        "free": lambda lower: normal(lower, tolerance=1e-13),
        "periodic": lambda lower: normal(lower, periodic=True, tolerance=1e-13),
        "scene": lambda lower: SCENE.with_(lower=lower, friction=0.3 if bonded else 0.0).solve(),
    }
    solve = ways[way]
    result = solve(body)
    gradient = result.gradient("approach")
    names = ["young_modulus", "poisson_ratio", "thickness"]
    names += [] if base is not STEEL else ["base.young_modulus", "base.poisson_ratio"]
    for name in names:
        expected = approach_of(solve, body, name)
        assert result.derivative("approach", f"lower.{name}") == pytest.approx(expected, rel=1e-7), name
        assert gradient[f"lower.{name}"] == pytest.approx(expected, rel=1e-7), name


@pytest.mark.coarse
def test_at_half_of_poisson_s_ratio_the_derivative_is_that_from_below() -> None:
    body = mtb.Layered(replace(SOFT, poisson_ratio=0.5), 1.3e-3, STEEL)
    found = normal(body, tolerance=1e-13).derivative("approach", "lower.poisson_ratio")
    places, weights = (0, -1, -2, -3, -4), (25.0 / 12.0, -4.0, 3.0, -4.0 / 3.0, 0.25)

    def approach(ratio: float) -> float:
        return normal(replace(body, layer=replace(SOFT, poisson_ratio=ratio)), tolerance=1e-13).approach

    expected = sum(w * approach(0.5 + 3e-3 * k) for k, w in zip(places, weights, strict=True)) / 3e-3
    assert found == pytest.approx(expected, rel=1e-6)


@pytest.mark.coarse
@pytest.mark.parametrize(("ask", "words"), REFUSED.values(), ids=REFUSED.keys())
def test_each_refusal_has_a_name(ask: Callable[[], Any], words: str) -> None:
    with pytest.raises(ValueError, match=words):
        ask()
