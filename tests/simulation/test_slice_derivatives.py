# SPDX-License-Identifier: MIT OR Apache-2.0
"""Derivatives of steps of wheels and rails with slices: differences of steps, and the turn of a wheel."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import mtb_rs as mtb
from mtb_rs.simulation.wheel_stepping import PreparedWheels

pytestmark = pytest.mark.filterwarnings("ignore:the peak pressure is")

PLACES = np.linspace(0.0, 0.6, 13)
ANGLES = np.arange(24) * 2.0 * np.pi / 24
VELOCITY = np.array([20.0, 0.05, 0.0, 0.0, 20.1 / 0.46, 0.01])


def varying_rail() -> mtb.RailSlices:
    """Sinks, shifts and widens along the track."""
    nominal, y = mtb.Profile.standard("60E1"), np.linspace(-0.03, 0.03, 601)
    sections = [
        mtb.Profile.from_points(
            y, nominal.height(y + 5e-4 * np.cos(6.0 * s)) - 2e-4 * np.sin(8.0 * s) - 0.3 * s * y * y
        )
        for s in PLACES
    ]
    return mtb.RailSlices(PLACES, sections, nominal="60E1")


def varying_wheel() -> mtb.WheelSlices:
    return mtb.WheelSlices.out_of_round("S1002", ANGLES, 3e-4 * np.sin(3.0 * ANGLES))


KINDS: dict[str, dict[str, Any]] = {
    "rail": {"wheel": "S1002", "rail": varying_rail()},
    "wheel": {"wheel": varying_wheel(), "rail": "60E1"},
    "both": {"wheel": varying_wheel(), "rail": varying_rail()},
    "roller": {"wheel": varying_wheel(), "rail": "60E1", "roller_radius": 0.8},
}


def prepared(kind: str, side: str, friction: Any = 0.3) -> PreparedWheels:
    scene = mtb.scenes.wheel_on_rail(**KINDS[kind], force=6e4, lateral=0.0, spacing=1e-3)
    return scene.prepare(side=side, friction=friction)


def place_of(kind: str, side: str) -> tuple[np.ndarray, np.ndarray]:
    """Pose whose height, and roll of both wheels, is found; and velocity."""
    x, roll = (0.0 if kind == "roller" else 0.21), (np.nan if side == "both" else 2e-4)
    velocity = VELOCITY.copy()
    velocity[0] *= kind != "roller"
    return np.array([x, 1e-3, np.nan, roll, 0.3, 2e-3]), velocity


def rolled(kind: str, side: str, is_transient: bool, by: np.ndarray, friction: Any = 0.3) -> mtb.WheelStep:
    wheels, (pose, velocity) = prepared(kind, side, friction), place_of(kind, side)
    if not is_transient:
        return wheels.step(pose + by, velocity)
    before = np.array([2e-3 * (kind != "roller"), 1e-5, 0.0, 0.0, 2e-3 / 0.46, 0.0])
    wheels.step(pose - before, velocity)
    return wheels.step(pose + by, velocity, transient=True, dt=1e-4)


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("side", ["left", "both"])
@pytest.mark.parametrize("is_transient", [False, True])
def test_derivatives_by_the_pose_are_differences(kind: str, side: str, is_transient: bool) -> None:
    step = rolled(kind, side, is_transient, np.zeros(6))
    by_pose = step.gradient("friction_power")["pose"]
    forward = step.derivative("force", "pose")
    # steps in which hardly any place along the track comes to a footprint or leaves it
    for k, size, tolerance in ((0, 1e-6, 5e-3), (1, 1e-7, 5e-3), (4, 1e-6, 5e-3), (5, 1e-6, 5e-3)):
        by = size * np.eye(6)[k]
        ahead, behind = rolled(kind, side, is_transient, by), rolled(kind, side, is_transient, -by)
        power = (ahead.friction_power - behind.friction_power) / (2.0 * size)
        assert by_pose[k] == pytest.approx(power, rel=tolerance, abs=2.0)
        force = (np.array(ahead.force) - behind.force) / (2.0 * size)
        assert forward[:2, k] == pytest.approx(force[:2], rel=1e-2, abs=5e-3 * np.abs(force).max() + 1.0)


def test_a_wheel_that_has_turned_is_another_place_on_it() -> None:
    # a wheel turned on by a third of a turn of three waves looks as before
    wheels, (pose, velocity) = prepared("wheel", "left"), place_of("wheel", "left")
    step = wheels.copy().step(pose, velocity)
    turned = pose + np.array([0.0, 0.0, 0.0, 0.0, 2.0 * np.pi / 3.0, 0.0])
    again = wheels.copy().step(turned, velocity)
    for of in (step.derivative, again.derivative):
        assert abs(of("force", "pose")[1, 4]) > 10.0
    np.testing.assert_allclose(
        again.derivative("force", "pose"), step.derivative("force", "pose"), rtol=1e-6, atol=1e-2
    )
    # a round wheel has no derivative by the turn, and a rail that stays as it is none by x
    for side in ("left", "both"):
        pose, velocity = place_of("rail", side)
        still = prepared("rail", side).step(pose, velocity)
        assert still.derivative("force", "pose")[:, 4] == pytest.approx(0.0, abs=1e-6)
        pose, velocity = place_of("wheel", side)
        still = prepared("wheel", side).step(pose, velocity)
        assert still.derivative("force", "pose")[:, 0] == pytest.approx(0.0, abs=1e-3)


@pytest.mark.parametrize("kind", KINDS)
def test_what_a_force_that_is_held_follows(kind: str) -> None:
    """The height follows the friction and the load; derivatives by these were refused with it."""
    pose, velocity = place_of(kind, "left")
    step = prepared(kind, "left").step(pose, velocity)
    size = 1e-4
    ahead, behind = (prepared(kind, "left", 0.3 + by).step(pose, velocity) for by in (size, -size))
    by_friction = step.derivative("force", "friction")
    expected = (np.array(ahead.force) - behind.force) / (2.0 * size)
    assert by_friction == pytest.approx(expected, rel=1e-3, abs=1.0)
    held = step.derivative("force", "vertical_force")
    assert held[2] == pytest.approx(-1.0, abs=1e-6)
