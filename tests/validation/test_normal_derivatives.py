# SPDX-License-Identifier: MIT OR Apache-2.0
"""Derivatives of frictionless contacts, against Hertz and against differences of solves."""

import pickle
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import mtb_rs as mtb
from mtb_rs.half_space.normal import NormalResult

Array = NDArray[np.float64]

RADIUS, SPACING = 0.5, 0.02e-3
X = (np.arange(96) - 47.5) * SPACING
BOWL = (X[None, :] ** 2 + X[:, None] ** 2) / (2.0 * RADIUS)
BODIES: dict[str, Any] = {"lower": mtb.steel, "upper": mtb.Material(70e9, 0.33)}


def solved(gap: Array = BOWL, **given: Any) -> NormalResult:
    return mtb.solve_normal(gap, SPACING, **BODIES | {"tolerance": 1e-12} | given)


def richardson(value: Any, step: float) -> Array:
    """Derivative of value(h) at 0, its error of fourth order in the step."""
    slopes = [(value(h) - value(-h)) / (2.0 * h) for h in (step, 0.5 * step)]
    return np.asarray((4.0 * slopes[1] - slopes[0]) / 3.0)


def test_stiffness_of_a_sphere_is_that_of_hertz() -> None:
    result = solved(approach=0.9e-6)
    found = result.gradient("normal_force")["approach"]
    modulus = 1.0 / sum(1.0 / body.plane_strain_modulus for body in BODIES.values())
    # dF/dd = 2 a E*; the border of the contact is as coarse as the cells, of which a has 33
    assert found == pytest.approx(2.0 * np.sqrt(RADIUS * 0.9e-6) * modulus, rel=2e-3)
    # and so much per unit of force is what the bodies give way under one
    pressed = solved(force=result.normal_force)
    assert pressed.derivative("approach", "force") == pytest.approx(1.0 / found, rel=1e-9)


@pytest.mark.parametrize("side", ["lower", "upper"])
@pytest.mark.parametrize("constant", ["young_modulus", "poisson_ratio"])
@pytest.mark.parametrize("load", [{"force": 60.0}, {"approach": 0.9e-6}])
def test_moduli(side: str, constant: str, load: dict[str, float]) -> None:
    def at(change: float) -> Array:
        value = getattr(BODIES[side], constant)
        moved = solved(**load, **{side: replace(BODIES[side], **{constant: value * (1.0 + change)})})
        return np.array([moved.normal_force, moved.approach, moved.pressure[48, 48]])

    result = solved(**load)
    value, by = getattr(BODIES[side], constant), f"{side}.{constant}"
    pressure = value * result.derivative("pressure", by)
    found = [(pressure * result.area).sum(), value * result.derivative("approach", by), pressure[48, 48]]
    expected = richardson(at, 2e-5)
    sizes = np.array([result.normal_force, result.approach, result.pressure.max()])
    assert np.abs((found - expected) / sizes).max() < 1e-6


def test_moments_turn_about_the_axes_of_a_scene() -> None:
    # the bowl is left and below of the middle, where a force with moments holds it
    given = {"force": 60.0, "moments_about_axes": (-2e-3, 1e-3)}

    def at(change: float) -> Array:
        moved = solved(**given | {"moments_about_axes": (-2e-3 + change, 1e-3 - 2.0 * change)})
        return np.array([*moved.tilts])

    change = solved(**given).derivative("tilts", "moments_about_axes") @ [1.0, -2.0]
    assert change == pytest.approx(richardson(at, 2e-8), rel=1e-6)


def test_a_pickled_result_keeps_its_derivatives_and_one_put_together_says_that_it_has_none() -> None:
    result = solved(force=60.0)
    again = pickle.loads(pickle.dumps(result))
    assert again.derivative("approach", "force") == result.derivative("approach", "force")
    with pytest.raises(ValueError, match="solve_normal"):
        replace(result).derivative("approach", "force")


def test_a_locked_tilt_takes_whatever_moment_there_is() -> None:
    result = solved(force=60.0, moments_about_axes=(0.0, None))
    for by in ("moments_about_axes", "gap"):
        weights = {"pressure": np.sin(np.arange(result.pressure.size)).reshape(result.pressure.shape)}
        assert result.derivative("approach", by) == pytest.approx(result.gradient("approach")[by], rel=1e-9)
        assert result.derivative(weights, by) == pytest.approx(result.gradient(weights)[by], rel=1e-9)
    forward = result.derivative("pressure", "moments_about_axes")
    assert not forward[..., 1].any()
    assert forward[..., 0].any()


def test_at_a_kink_the_two_sides_differ_and_the_margin_says_so() -> None:
    # a pit in the middle of the bowl that just touches at this load: its cell carries nothing yet
    approach = 0.9e-6
    at_rest = solved(approach=approach)
    dug = BOWL.copy()
    dug[48, 48] += 0.05e-6
    open_here = solved(dug, approach=approach)
    dug[48, 48] -= open_here.gap[48, 48] * (1.0 - 1e-9)
    kink = solved(dug, approach=approach)
    margin = kink.margin()
    assert min(margin.parting, margin.touching) < 1e-8 < 1e-4 < at_rest.margin().parting
    weights, side = {"pressure": kink.area}, np.zeros(BOWL.shape)
    side[48, 48] = 1e-10
    opened, closed = solved(dug + side, approach=approach), solved(dug - side, approach=approach)
    # opened, the point carries nothing: the derivative at the kink is that of the open side, where it stands
    assert kink.status[48, 48] == 0
    assert kink.derivative(weights, "gap")[48, 48] == 0.0
    by_opening = (opened.normal_force - kink.normal_force) / 1e-10
    by_closing = (kink.normal_force - closed.normal_force) / 1e-10
    assert abs(by_opening) < 1e-4 * abs(by_closing)
    assert closed.derivative(weights, "gap")[48, 48] == pytest.approx(by_closing, rel=1e-3)


HARDNESS = 45e6
#: Between the bodies.
LAYERED: dict[str, dict[str, Any]] = {
    "layer": {"normal_layer": 2e-15},
    "hardness": {"hardness": HARDNESS},
    "both": {"normal_layer": 2e-15, "hardness": 0.9 * HARDNESS},
}


@pytest.mark.parametrize("load", [{"force": 60.0}, {"approach": 1.1e-6}])
@pytest.mark.parametrize(
    ("between", "by"),
    [(name, by) for name, own in LAYERED.items() for by in (*own, "load", "lower.young_modulus")],
)
def test_layer_and_hardness(between: str, load: dict[str, float], by: str) -> None:
    given = LAYERED[between] | load
    name = next(iter(load)) if by == "load" else by

    def moved(change: float) -> NormalResult:
        if by == "lower.young_modulus":
            return solved(
                **given, lower=replace(mtb.steel, young_modulus=mtb.steel.young_modulus * (1 + change))
            )
        return solved(**given | {name: given[name] * (1.0 + change)})

    weight = np.random.default_rng(3).uniform(-1.0, 1.0, BOWL.shape)

    def numbers(result: NormalResult) -> Array:
        plastic = result.plastic_indentation
        depth = 0.0 if plastic is None else (weight * plastic).sum()
        sums = [(weight * result.pressure).sum(), (weight * result.gap).sum(), depth]
        return np.array([result.normal_force, result.approach, *sums])

    result = solved(**given)
    if "hardness" in given:
        assert result.plastic_indentation is not None
        assert (result.plastic_indentation > 0.0).sum() > 50
    step = 2e-6
    for share in (step, -step):
        assert np.array_equal(moved(share).status, result.status)
        if "hardness" in given:
            assert np.array_equal(moved(share)._flows(), result._flows())
    of = ["normal_force", "approach", {"pressure": weight}, {"gap": weight}]
    if "hardness" in given:
        of.append({"plastic_indentation": weight})
    size = mtb.steel.young_modulus if by == "lower.young_modulus" else given[name]
    forward = [size * np.asarray(result.derivative(o, name)) for o in of]
    adjoint = size * result.gradient(of)[name]
    assert forward == pytest.approx(adjoint, rel=1e-9, abs=1e-12)
    expected = richardson(lambda h: numbers(moved(h)), step)[: len(of)]
    scale = np.abs(numbers(result))[: len(of)]
    assert (np.abs(adjoint - expected) <= 2e-6 * np.maximum(np.abs(expected), 0.02 * scale)).all()


def test_cells_that_flow_keep_their_pressure_and_the_margin_tells_of_the_nearest() -> None:
    result = solved(force=60.0, hardness=HARDNESS)
    flows = result._flows()
    assert flows is not None
    by_force = result.derivative("pressure", "force")
    assert np.all(by_force[flows] == 0.0)
    assert np.all(result.derivative("pressure", "hardness")[flows] == 1.0)
    margin = result.margin()
    below = result.pressure[~flows].max()
    assert margin.yielding == pytest.approx(1.0 - below / HARDNESS)
    assert margin.yielding is not None
    assert margin.unloading is not None
    assert margin.unloading > 0.0
    assert margin.smallest <= min(margin.yielding, margin.unloading)
    # nothing flows yet
    elastic = solved(force=60.0, hardness=1e9)
    assert elastic.margin().unloading == np.inf
    assert elastic.derivative("normal_force", "hardness") == 0.0
    assert elastic.derivative("approach", "force") == pytest.approx(
        solved(force=60.0).derivative("approach", "force"), rel=1e-9
    )


def test_a_layer_in_full_contact_of_waves_has_its_closed_form() -> None:
    """A wave k of the gap has the pressure amplitude h / (layer + 2 (1 - nu^2) / (E k))."""
    cells, length, height, layer = 32, 1e-3, 1e-7, 2e-14
    x = (np.arange(cells) + 0.5) * length / cells
    wave = np.cos(4.0 * np.pi * x / length)
    gap = np.broadcast_to(-height * wave, (cells, cells))
    result = mtb.solve_normal(
        gap, length / cells, lower=mtb.steel, upper=mtb.Rigid(), force=4e9 * length**2, periodic=True,
        normal_layer=layer, tolerance=1e-12,
    )  # fmt: skip
    assert result.status.all()
    amplitude = {"pressure": np.broadcast_to(2.0 * wave / cells**2, gap.shape)}
    compliance = 2.0 / (mtb.steel.plane_strain_modulus * 4.0 * np.pi / length)
    expected = -height / (layer + compliance) ** 2
    assert result.derivative(amplitude, "normal_layer") == pytest.approx(expected, rel=1e-9)
    by_each = result.gradient(amplitude)["normal_layer_field"]
    assert by_each.sum() == pytest.approx(expected, rel=1e-9)
