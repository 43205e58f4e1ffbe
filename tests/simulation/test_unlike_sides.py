# SPDX-License-Identifier: MIT OR Apache-2.0
"""Wheels of one axle on profiles of their own: like ones, mirrors, each by itself, cones, slices."""

from __future__ import annotations

import pickle
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import mtb_rs as mtb
from mtb_rs.case import case_from_words

pytestmark = [
    pytest.mark.coarse,
    pytest.mark.filterwarnings("ignore:the peak pressure is"),
    pytest.mark.filterwarnings("ignore:on the flange"),
]

NAN, V = np.nan, 20.0


def changed(name: str, depth: float, middle: float) -> mtb.Profile:
    """A standard profile that has lost a bell of material."""
    profile = mtb.Profile.standard(name)
    y = np.linspace(*profile.range, 400)
    bell = depth * np.exp(-(((y - middle) / 15e-3) ** 2))
    return mtb.Profile.from_points(y, profile.height(y) + bell, name="changed")


WORN, GROUND = changed("S1002", 1e-4, 5e-3), changed("60E1", -2e-4, -8e-3)
RADIUS = 0.4596
UNLIKE: dict[str, Any] = {"right_wheel": WORN, "right_rail": GROUND, "right_wheel_radius": RADIUS}


def scene(**changes: Any) -> Any:
    return mtb.scenes.wheel_on_rail(**{"lateral": 0.0, "force": 60e3, "spacing": 1.5e-3} | changes)


def mirrored_scene() -> Any:
    """The right wheel as a left one."""
    return scene(wheel=WORN, rail=GROUND, wheel_radius=RADIUS)


MIRRORED: dict[str, Any] = {"right_wheel": "S1002", "right_rail": "60E1", "right_wheel_radius": 0.46}
#: How a mirror turns x, y, z, roll, pitch, yaw.
MIRROR = np.array([1.0, -1.0, 1.0, -1.0, 1.0, -1.0])


def exchanged(step: mtb.WheelStep) -> dict[str, float]:
    """Vertical forces, those of the left wheel for the right one."""
    return {"left": step.vertical_force["right"], "right": step.vertical_force["left"]}


@pytest.mark.parametrize("more", [{}, {"conformal": True}, {"rail_stiffness": (1e8, 2e8)}])
def test_a_right_wheel_told_to_be_as_the_left_one_is(more: dict[str, Any]) -> None:
    pose = [0, 1e-3, NAN, NAN, 0, 2e-3]
    alike = scene().prepare(side="both", **more)
    told = scene().prepare(side="both", **MIRRORED, **more)
    for _ in range(2):
        assert np.array_equal(alike.step(pose, V).force, told.step(pose, V).force)
        own, other = (wheels.step(pose, V, 1e-4, transient=True) for wheels in (alike, told))
        assert np.array_equal(own.force, other.force)


@pytest.mark.parametrize("more", [{}, {"conformal": True}, {"rail_stiffness": (1e8, 2e8)}])
def test_the_mirror_image_has_the_wheels_changed_over(more: dict[str, Any]) -> None:
    pose = np.array([0, 2e-3, NAN, NAN, 0, 2e-3])
    own = scene().prepare(side="both", **UNLIKE, **more)
    image = mirrored_scene().prepare(side="both", **MIRRORED, **more)
    # the zero pose has the left wheel touch: heights differ
    for transient in (False, True):
        left = own.step(pose, V, 5e-4, transient=transient)
        right = image.step(MIRROR * pose, V, 5e-4, transient=transient)
        assert right.force == pytest.approx(MIRROR[:3] * left.force, abs=1e-3)
        assert exchanged(right) == pytest.approx(left.vertical_force, rel=1e-7)
        assert right.pose[3] == pytest.approx(-left.pose[3], abs=1e-9)
        assert right.friction_power == pytest.approx(left.friction_power, rel=1e-6)
        sides = [[patch.side for patch in step.patches] for step in (left, right)]
        assert sorted(sides[0]) == sorted({"left": "right", "right": "left"}[side] for side in sides[1])


def test_both_wheels_are_each_by_itself() -> None:
    """Where they stand, the left one is that of its scene, and the right one the mirror of its own."""
    both = scene().prepare(side="both", **UNLIKE, reference_point=(0, 0, 0.46))
    step = both.step([0, 1e-3, NAN, NAN, 0, 1e-3], V)
    velocity = np.array([V, 0.0, 0.0, 0.0, V / 0.46, 0.0])
    step = both.step(step.pose, velocity)
    left = scene().prepare(reference_point=(0, 0, 0.46)).step(step.pose, velocity)
    # as a left wheel its height is over its own first contact
    alone = mirrored_scene()
    first = [s.geometry.placement.undeformed_height for s in (scene(), alone)]
    lower = 0.46 + first[0] - (RADIUS + first[1])
    pose = MIRROR * step.pose + [0, 0, lower, 0, 0, 0]
    right = alone.prepare(reference_point=(0, 0, 0.46 - lower)).step(pose, MIRROR * velocity)
    assert left.force + MIRROR[:3] * right.force == pytest.approx(step.force, abs=1e-4)
    assert left.moment + MIRROR[3:] * right.moment == pytest.approx(step.moment, abs=1e-3)
    right_alone = scene().prepare(side="right", **UNLIKE, reference_point=(0, 0, 0.46))
    assert right_alone.step(step.pose, velocity).force == pytest.approx(MIRROR[:3] * right.force, abs=1e-4)


def test_cones_of_unlike_radii_creep_apart() -> None:
    """Contact circles turn with the axle: creepages differ by their radii."""
    cone = mtb.Profile.from_points([-0.06, 0.06], [-0.006, 0.006], "linear", "cone")
    y = np.linspace(-0.06, 0.06, 121)
    rail = mtb.Profile.from_points(y, np.sqrt(0.3**2 - y**2) - 0.3, name="arc")
    given: dict[str, Any] = {"wheel": cone, "rail": rail, "rail_inclination": 0.0, "gauge_depth": 3e-3}
    contact = scene(**given, wheel_radius=0.4602, spacing=2e-4, force=2e3).prepare(
        side="both", right_wheel_radius=0.4598, friction=mtb.Coulomb(0.3)
    )
    places = np.array([-3e-3, 0.0, 3e-3])
    standing = mtb.wheelset_geometry(**given, wheel_radius=(0.4602, 0.4598), shifts=places, axle="free")
    for k, at in enumerate(places):
        step = contact.step([0, at, NAN, NAN, 0, 0], V)
        for patch in step.patches:
            # the surface of the wheel goes by its radius there over the mean one, that of the rail by one
            faster = getattr(standing, patch.side).rolling_radius[k] / 0.46
            wanted = (1.0 - faster) / (0.5 * (1.0 + faster))
            # an overlap of micrometres moves the points by as much
            assert patch.creepage[0] == pytest.approx(wanted, abs=2e-5)
        along = {patch.side: patch.creepage[0] for patch in step.patches}
        apart = standing.radius_difference[k] / 0.46 / (0.5 * (1.0 + faster))
        assert along["right"] - along["left"] == pytest.approx(
            apart / (0.5 * (1.0 + faster)), rel=2e-3, abs=1e-7
        )


def test_without_a_pose_each_wheel_carries_its_load() -> None:
    """As `step_wheels` and mock-up units have it: 0.1 mm of radius would lift a level wheel."""
    given: dict[str, Any] = {"side": "both", "right_wheel_radius": 0.4599}
    by_default = scene().prepare(**given).step(velocity=V)
    assert by_default.vertical_force == pytest.approx({"left": 60e3, "right": 60e3}, rel=1e-8)
    assert np.array_equal(by_default.force, mtb.step_wheels(scene(), V, **given).force)
    with pytest.warns(UserWarning, match="wheels of one axle differ by tenths"):
        scene().prepare(side="both", right_wheel_radius=0.3)


def test_reports_advise_what_can_be_done() -> None:
    """No patches that follow the rail where slices lie."""
    dips = mtb.RailSlices.uneven("60E1", [-9.6, -9.3, -9.0, -8.7, -8.4], [0.0, 0.0, -2e-4, 0.0, 0.0])
    said = {}
    for name, rail in (("plain", "60E1"), ("sliced", dips)):
        contact = scene(rail=rail, force=80e3, spacing=5e-4).prepare()
        steps = (contact.step([0, y, NAN, 0, 0, 3e-3], V) for y in np.arange(6.0e-3, 6.8e-3, 1e-4))
        said[name] = [words for step in steps if "more than 20" in (words := step.report.status)]
        assert said[name]
    assert all("conformal=True" in words for words in said["plain"])
    assert not any("conformal" in words for words in said["sliced"])


def test_a_dip_on_one_side_is_felt_there() -> None:
    dip = mtb.RailSlices.uneven("60E1", [-0.6, -0.3, 0.0, 0.3, 0.6], [0.0, 0.0, -2e-4, 0.0, 0.0])
    dips = scene().prepare(side="both", right_rail=dip)
    sound = scene().prepare(side="both")
    pose = np.array([0.0, 0.0, sound.step([0, 0, NAN, NAN, 0, 0], V).pose[2], 0.0, 0.0, 0.0])
    pose[2] -= 1e-4
    plain, felt = (wheels.step(pose, V).vertical_force for wheels in (sound, dips))
    assert felt["left"] == pytest.approx(plain["left"], rel=1e-9)
    assert felt["right"] < 0.5 * plain["right"]
    # far from the dip both are as new
    pose[0] = -5.0
    assert dips.step(pose, V).vertical_force == pytest.approx(plain, rel=1e-5)
    # with the wheels changed over, the dip is on the left
    other = scene(rail=dip).prepare(side="both", right_rail="60E1")
    pose[0] = 0.0
    pose[2] += (
        scene().geometry.placement.undeformed_height - scene(rail=dip).geometry.placement.undeformed_height
    )
    assert exchanged(other.step(pose, V)) == pytest.approx(felt, rel=1e-6)


def test_derivatives_are_differences() -> None:
    core = scene(spacing=3e-3).prepare(side="both", **UNLIKE)._core
    contact = mtb.PreparedWheels(core.to_accuracy(1e-13, 1e-11, 1e-10))
    pose = np.array([0, 1e-3, NAN, NAN, 0, 1e-3])
    step = contact.step(pose, V)
    for k in (1, 5):
        width = 1e-7 * np.eye(6)[k]
        near, wide = (
            (contact.step(pose + s * width, V, state=step.state).force
             - contact.step(pose - s * width, V, state=step.state).force) / (2 * s * 1e-7)
            for s in (1.0, 2.0)
        )  # fmt: skip
        wanted = (4 * near - wide) / 3
        found = np.asarray(step.derivative("force", "pose"))[:, k]
        assert found == pytest.approx(wanted, rel=1e-6, abs=1e-6 * np.abs(wanted).max())
    faster = [contact.step(pose, V * (1 + s), state=step.state).force for s in (-1e-6, 1e-6)]
    by_speed = (faster[1] - faster[0]) / (2e-6 * V)
    assert np.asarray(step.derivative("force", "velocity")).ravel() == pytest.approx(by_speed, abs=1e-2)


def test_files_pickles_and_cases_have_them(tmp_path: Path) -> None:
    contact = scene().prepare(side="both", **UNLIKE)
    pose = [0, 1e-3, NAN, NAN, 0, 2e-3]
    force = contact.step(pose, V).force
    contact.save(tmp_path / "wheels.mtbw")
    assert np.array_equal(mtb.PreparedWheels.load(tmp_path / "wheels.mtbw").step(pose, V).force, force)
    fresh = scene().prepare(side="both", **UNLIKE)
    assert np.array_equal(pickle.loads(pickle.dumps(fresh)).step(pose, V).force, force)
    called = mtb.step_wheels(scene(), V, side="both", y=1e-3, yaw=2e-3, **UNLIKE)
    assert np.array_equal(called.force, force)
    for name, profile in (("wheel", WORN), ("rail", GROUND)):
        profile.to_file(tmp_path / f"{name}.csv")
    words = {"velocity": V, "side": "both", "y": 1e-3, "yaw": 2e-3, **UNLIKE}
    words |= {f"right_{name}": str(tmp_path / f"{name}.csv") for name in ("wheel", "rail")}
    case = case_from_words(
        {"scene": "wheel_on_rail", "lateral": 0.0, "force": 60e3, "spacing": 1.5e-3, "step_wheels": words}
    )
    found = case.solve()
    assert isinstance(found, mtb.WheelStep)
    # a file of profiles has so many digits
    assert found.force == pytest.approx(force, abs=1e-6 * 60e3)


def test_what_makes_no_right_wheel_is_named() -> None:
    for given, words in (
        ({"right_wheel": "S1002"}, 'right_wheel is .*side is "left"'),
        ({"right_wheel_radius": 0.46, "side": "left"}, "right_wheel_radius is 0.46"),
        ({"right_wheel_radius": -1.0, "side": "both"}, "right_wheel_radius is -1"),
        ({"right_wheel": "60E2", "side": "both"}, "60E2"),
        ({"right_rail": "no such", "side": "right"}, "no such"),
        (
            {
                "right_rail": mtb.WheelSlices.out_of_round("S1002", [0, 1, 3, 5], [0, 0, 0, 1e-5]),
                "side": "both",
            },
            "right_rail is WheelSlices.*RailSlices",
        ),
    ):
        with pytest.raises((ValueError, UserWarning), match=words):
            scene().prepare(**given)
    block = mtb.scenes.block_on_plane()
    with pytest.raises(ValueError, match="right_rail is for wheels on rails"):
        block.prepare(right_rail="60E1")


def test_a_worn_tape_circle_rolls_on_its_own_radius() -> None:
    """A profile that lies a millimetre higher is a wheel of a smaller radius: a speed turns it faster."""
    new = mtb.Profile.standard("S1002")
    y = np.linspace(*new.range, 600)

    def rolled(raised: float, radius: float) -> mtb.WheelStep:
        wheel = mtb.Profile.from_points(y, new.height(y) + raised, name="raised")
        return scene(wheel=wheel, wheel_radius=radius).prepare(side="both").step(None, V)

    assert rolled(1e-3, 0.46).force == pytest.approx(rolled(0.0, 0.459).force, abs=1e-2)
    assert abs(rolled(1e-3, 0.46).force[0]) < 600.0
    with pytest.warns(UserWarning, match=r"z = 8 mm at y = 0"):
        scene(wheel=mtb.Profile.from_points(y, new.height(y) + 8e-3))
    with pytest.raises(ValueError, match=r"z of the wheel profile at y = 0 is 0\.47"):
        scene(wheel=mtb.Profile.from_points(y, new.height(y) + 0.47))
