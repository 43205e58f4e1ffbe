# SPDX-License-Identifier: MIT OR Apache-2.0
"""Ready scenes, larger or stiffer, with their bodies exchanged, or with a body held at the height it took."""

from __future__ import annotations

import inspect
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import mtb_rs as mtb
from mtb_rs.base.units import ARGUMENT_UNITS

pytestmark = pytest.mark.coarse
HARD, SOFT = mtb.Material(2.1e11, 0.3), mtb.Material(7e10, 0.33)
Y = np.linspace(-36e-3, 36e-3, 241)
#: A head of a rail that is its own mirror image, and one worn on one side.
ROUND = -(Y**2) / 0.3
WORN = ROUND - np.where(Y > 0.01, 1e-4 * ((Y - 0.01) / 0.01) ** 2, 0.0)
#: Ready scenes with all their lengths in numbers and profiles, and the models that are asked of them.
SCENES: dict[str, tuple[Callable[..., mtb.Scene], dict[str, Any], tuple[Any, ...]]] = {
    "paraboloid": (mtb.scenes.paraboloid_on_plane, {"points": 20, "friction": 0.2}, ("half-space",)),
    "block": (
        mtb.scenes.block_on_plane,
        {"spacing": 0.025, "friction": 0.2},
        ("half-space", "elastic-upper"),
    ),
    "shoe": (
        mtb.scenes.pole_shoe_on_rail,
        {"spacing": 8e-3, "friction": 0.2, "rail": ROUND},
        ("half-space", "elastic-upper", "elastic-both"),
    ),
    "shoe aside of a worn rail": (
        mtb.scenes.pole_shoe_on_rail,
        {"spacing": 8e-3, "friction": 0.2, "rail": WORN, "lateral": 1e-3, "yaw": 0.01},
        ("half-space", "elastic-upper"),
    ),
    "wheel": (mtb.scenes.wheel_on_rail, {"spacing": 1e-3, "lateral": 1e-3}, ("half-space",)),
}
CASES = [(name, model) for name, (_, _, models) in SCENES.items() for model in models]


def made(name: str, *, size: float = 1.0, stiff: float = 1.0, **other: Any) -> mtb.Scene:
    """A scene `size` times as large, of materials `stiff` times as stiff, under the same strains."""
    build, given, _ = SCENES[name]
    known = inspect.signature(build).parameters
    arguments = {k: p.default for k, p in known.items() if p.default is not inspect.Parameter.empty} | given
    arguments |= {"upper": HARD, "lower": SOFT} | other
    power = {"m": size, "N": stiff * size**2, "Pa": stiff}
    for key, value in arguments.items():
        if isinstance(value, mtb.Material):
            arguments[key] = mtb.Material(stiff * value.young_modulus, value.poisson_ratio)
        elif isinstance(value, np.ndarray):
            arguments[key] = mtb.Profile.from_points(size * Y, size * value)
        elif isinstance(value, float) and key in ARGUMENT_UNITS:
            arguments[key] = power.get(ARGUMENT_UNITS[key], 1.0) * value
    if "wheel" in known:
        profile, whole = mtb.Profile.standard("S1002"), mtb.Profile.standard("60E1")
        for key, shape in (("wheel", profile), ("rail", whole)):
            y = np.linspace(*shape.range, 401)
            arguments[key] = mtb.Profile.from_points(size * y, size * shape.height(y))
    return build(**arguments)


@pytest.mark.parametrize(("name", "model"), CASES)
@pytest.mark.parametrize(("size", "stiff"), [(1.25, 1.0), (0.8, 1.0), (1.0, 0.5)])
def test_a_scene_larger_or_stiffer_has_the_same_strains(
    name: str, model: Any, size: float, stiff: float
) -> None:
    if model == "elastic-both" and size != 1.0:
        pytest.skip("below the head the section of the rail is that of the 60E1, whatever the profile")
    one, other = made(name).solve(model), made(name, size=size, stiff=stiff).solve(model)
    peak = one.pressure.max()
    # the place where a wheel touches is found to some 1e-9 m of its height, whatever the size
    near = 5e-4 if name == "wheel" else 1e-8
    np.testing.assert_allclose(other.pressure / stiff, one.pressure, atol=near * peak)
    np.testing.assert_allclose(other.force / (stiff * size**2), one.force, atol=near * one.normal_force)
    np.testing.assert_allclose(np.asarray(other.approach) / size, one.approach, rtol=near, atol=1e-15)
    moved = np.abs(one.displacement.lower).max()
    np.testing.assert_allclose(
        other.displacement.lower / size, one.displacement.lower, atol=10.0 * near * moved
    )
    for quantity, estimate in one.report.error_estimates.items():
        assert other.report.error_estimates[quantity] == pytest.approx(
            estimate, rel=0.5 if name == "wheel" else 1e-3
        )


@pytest.mark.parametrize(("name", "friction"), [("paraboloid", 0.0), ("paraboloid", 0.3)])
def test_half_spaces_that_change_places_feel_the_other_direction(name: str, friction: float) -> None:
    one = made(name, friction=friction).solve()
    other = made(name, friction=friction, upper=SOFT, lower=HARD).solve()
    np.testing.assert_allclose(other.pressure, one.pressure[:, ::-1], atol=1e-8 * one.pressure.max())
    assert (np.ptp(one.pressure - one.pressure[:, ::-1]) > 1e-3 * one.pressure.max()) == (friction > 0.0)


@pytest.mark.parametrize(
    ("name", "model"), [(n, m) for n, m in CASES if n in ("block", "shoe") and m != "elastic-both"]
)
def test_a_ready_body_held_at_the_height_it_took_stays_as_it_was(name: str, model: Any) -> None:
    contact = made(name, supports="driven-top").prepare(model)
    free = contact.step()
    heights = [h for n, h in zip(contact.motions, free.state.motion, strict=True) if n.endswith(" z")]
    assert heights
    np.testing.assert_allclose(heights, heights[0], rtol=1e-9)
    held = contact.step(pose=[0.0, 0.0, heights[0], np.nan, np.nan, 0.0])
    np.testing.assert_allclose(held.pressure, free.pressure, atol=1e-6 * free.pressure.max())
    np.testing.assert_allclose(held.force, free.force, atol=1e-7 * np.abs(free.force).max())
