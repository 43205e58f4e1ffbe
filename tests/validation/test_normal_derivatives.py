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


def test_a_locked_tilt_has_no_moment_to_change() -> None:
    tangent = solved(force=60.0, moments_about_axes=(0.0, None))._tangent()
    with pytest.raises(ValueError, match="locked"):
        tangent.forward({"moments_about_axes": np.array([[0.0, 1.0]])})


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
