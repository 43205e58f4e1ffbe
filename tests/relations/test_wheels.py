# SPDX-License-Identifier: MIT OR Apache-2.0
"""What must hold of wheels in any pose: mirrors, shifts, and one answer whatever the way to it."""

from functools import lru_cache

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import mtb_rs as mtb

V, RADIUS = 20.0, 0.46
pytestmark = pytest.mark.filterwarnings("ignore:the peak pressure is")

#: y [m], roll and yaw [rad]; whether the height is given; drift, slip of the rim, rate of yaw
POSES = st.tuples(st.floats(-5.5e-3, 5.5e-3), st.floats(-2e-4, 2e-4), st.floats(-8e-3, 8e-3), st.booleans())
MOTIONS = st.tuples(st.floats(-0.1, 0.1), st.floats(-3e-3, 3e-3), st.floats(-0.1, 0.1))
FEW = settings(max_examples=8, deadline=None)


@lru_cache
def wheels(lateral=0.0):
    scene = mtb.scenes.wheel_on_rail(lateral=lateral, force=60e3, spacing=1e-3)
    return scene.prepare(side="both", friction=mtb.Coulomb(0.3))


def posed(place, motion):
    """Pose and velocity; the wheelset turns about its axle wherever that points."""
    (y, roll, yaw, is_given), (drift, slip, rate) = place, motion
    spin = (1.0 + slip) * V / RADIUS
    pose = np.array([0.0, y, -1.2e-4 if is_given else np.nan, roll, 0.0, yaw])
    axle = np.array([-np.sin(yaw) * np.cos(roll), np.cos(yaw) * np.cos(roll), np.sin(roll)])
    return pose, np.array([V, drift, 0.0, *(spin * axle + [0.0, 0.0, rate])])


def check(step, other, force=(1, 1, 1), moment=(1, 1, 1), tolerance=1e-6):
    """`other` is `step` with the signs of its components turned."""
    size = max(np.abs(step.force).max(), 1e3)
    np.testing.assert_allclose(other.force, force * step.force, rtol=0.0, atol=tolerance * size)
    np.testing.assert_allclose(other.moment, moment * step.moment, rtol=0.0, atol=tolerance * size)
    assert other.friction_power == pytest.approx(step.friction_power, rel=10 * tolerance, abs=1e-3)
    assert len(other.patches) == len(step.patches)


@given(POSES, MOTIONS)
@FEW
def test_left_is_right_in_a_mirror(place, motion):
    pose, velocity = posed(place, motion)
    flip = np.array([1, -1, 1, -1, 1, -1])
    here, there = wheels().copy().step(pose, velocity), wheels().copy().step(flip * pose, flip * velocity)
    check(here, there, (1, -1, 1), (-1, 1, -1))
    assert here.vertical_force["left"] == pytest.approx(there.vertical_force["right"], rel=1e-6, abs=1e-2)
    for patch, image in zip(here.patches, there.patches[::-1], strict=True):
        assert image.creepage == pytest.approx([1, -1, -1] * patch.creepage, rel=1e-6, abs=1e-9)
        assert image.approach == pytest.approx(patch.approach, rel=1e-6)


@given(POSES, MOTIONS)
@FEW
def test_backwards_is_forwards_in_a_mirror(place, motion):
    pose, velocity = posed(place, motion)
    back = np.array([1, 1, 1, 1, 1, -1]) * pose, np.array([-1, 1, 1, 1, -1, -1]) * velocity
    here, there = wheels().copy().step(pose, velocity), wheels().copy().step(*back)
    check(here, there, (-1, 1, 1), (1, -1, -1), tolerance=2e-6)


@given(POSES, MOTIONS, st.floats(-100.0, 100.0), st.floats(-3.0, 3.0), st.floats(-4e-3, 4e-3))
@FEW
def test_where_it_stands_and_what_is_its_origin_change_nothing(place, motion, way, pitch, lateral):
    """The rail is a prism, the wheel is round, and what the scene shifts the pose shifts back."""
    pose, velocity = posed(place, motion)
    here = wheels().copy().step(pose, velocity)
    check(here, wheels().copy().step(pose + np.array([way, 0.0, 0.0, 0.0, 0.0, 0.0]), velocity))
    # pitch comes after roll, so without roll it is about the axle
    pose[3] = 0.0
    here = wheels().copy().step(pose, velocity)
    check(here, wheels().copy().step(pose + np.array([0.0, 0.0, 0.0, 0.0, pitch, 0.0]), velocity))
    # z = 0 is where the wheel of the scene touches, here and there
    lower = 0.0
    if not np.isnan(pose[2]):
        heights = [mtb.wheel_on_rail_gap(lateral=y, spacing=1e-3).undeformed_height for y in (0.0, lateral)]
        lower = heights[0] - heights[1]
    shifted = wheels(lateral).copy().step(pose + np.array([0.0, -lateral, lower, 0.0, 0.0, 0.0]), velocity)
    check(here, shifted)


@given(POSES, MOTIONS)
@FEW
def test_one_answer_whatever_the_way(place, motion):
    pose, velocity = posed(place, motion)
    step = wheels().copy().step(pose, velocity)
    # at the height that was found
    if not np.isnan(step.pose).any():
        check(step, wheels().copy().step(step.pose, velocity))
    # from the memory of another pose, and of itself
    warm = wheels().copy()
    warm.step([0.0, 0.0, np.nan, 0.0, 0.0, 0.0], V)
    check(step, warm.step(pose, velocity), tolerance=1e-5)
    check(step, warm.step(pose, velocity, state=step.state), tolerance=1e-5)


def test_one_answer_from_a_file(tmp_path):
    wheels().save(tmp_path / "wheels.mtbw")
    read = mtb.PreparedWheels.load(tmp_path / "wheels.mtbw")
    pose, velocity = posed((2e-3, 1e-4, 5e-3, False), (0.05, 1e-3, 0.02))
    check(wheels().copy().step(pose, velocity), read.step(pose, velocity), tolerance=1e-12)


def test_more_force_goes_deeper_and_all_is_in_proportion():
    """All lengths times two, the stiffness as it was: forces times four, creepages as they were."""
    step = wheels().copy().step([0.0, 1e-3, np.nan, 0.0, 0.0, 2e-3], V)

    def profile(name):
        own = mtb.Profile.standard(name)
        y = np.linspace(*own.range, 4001)
        return y, own.height(y)

    def scene(size):
        wheel, rail = (
            mtb.Profile.from_points(size * y, size * z) for y, z in map(profile, ("S1002", "60E1"))
        )
        lengths = {"wheel_radius": RADIUS, "gauge": 1.435, "gauge_depth": 14e-3, "flange_back": 1.36}
        lengths |= {"tape_circle": 70e-3, "spacing": 1e-3}
        lengths = {name: size * length for name, length in lengths.items()}
        return mtb.scenes.wheel_on_rail(wheel, rail, lateral=0.0, force=size**2 * 60e3, **lengths)

    small, large = (
        scene(size).prepare(side="both").step([0.0, size * 1e-3, np.nan, 0.0, 0.0, 2e-3], size * V)
        for size in (1.0, 2.0)
    )
    assert small.force == pytest.approx(step.force, rel=1e-2)
    # stations at which contact is looked for are 0.05 mm apart, whatever the size
    assert large.force / 4.0 == pytest.approx(small.force, rel=1e-4, abs=0.1)
    assert large.moment / 8.0 == pytest.approx(small.moment, rel=1e-4, abs=0.1)
    for one, other in zip(small.patches, large.patches, strict=True):
        assert other.creepage * [1, 1, 2] == pytest.approx(one.creepage, rel=1e-4, abs=1e-9)
        assert other.approach == pytest.approx(2.0 * one.approach, rel=1e-4)
