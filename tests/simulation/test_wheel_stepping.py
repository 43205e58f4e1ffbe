# SPDX-License-Identifier: MIT OR Apache-2.0
"""Wheels in steps: the scene's own solution, Hertz, Klingel, mirrors; memory changes nothing but time."""

import contextlib
import json
import pickle
import re
import signal
import threading
import warnings
from functools import lru_cache

import numpy as np
import pytest

import mtb_rs as mtb
from mtb_rs.results.wheel_result import WheelState

# a flange under these forces is loaded above the hardness, which one test is about
pytestmark = pytest.mark.filterwarnings("ignore:the peak pressure is")

V = 20.0


def scene(lateral=0.0, force=60e3, spacing=5e-4, **changes):
    return mtb.scenes.wheel_on_rail(lateral=lateral, force=force, spacing=spacing, **changes)


@lru_cache
def wheels(lateral=0.0, side="both", friction=0.3, spacing=5e-4, **changes):
    return scene(lateral, spacing=spacing, **changes).prepare(side=side, friction=mtb.Coulomb(friction))


def cone(slope):
    """A wheel with one slope: its radius falls to the field side."""
    return mtb.Profile.from_points([-0.05, 0.05], [-0.05 * slope, 0.05 * slope], "linear")


def round_head(radius=0.3):
    angle = np.linspace(-0.12, 0.12, 1601)
    y, z = radius * np.sin(angle), radius * (np.cos(angle) - 1.0)
    # a flank, for the gauge to be measured at
    return mtb.Profile.from_points(
        np.concatenate([[y[0] - 2e-3], y]), np.concatenate([[z[0] - 30e-3], z]), "linear"
    )


@lru_cache
def conical(slope=0.05, side="both", friction=0.3, force=60e3):
    pair = scene(
        wheel=cone(slope),
        rail=round_head(),
        rail_inclination=0.0,
        force=force,
        spacing=5e-4,
        wheel_radius=0.46,
    )
    return pair.prepare(side=side, friction=mtb.Coulomb(friction))


def test_the_ready_scene_steps_without_a_warning_and_two_level_wheels_on_it_do_not():
    """Warnings are errors here. Level, the left wheel carries all, on its steep plane."""
    (still,) = mtb.scenes.wheel_on_rail().prepare().step(velocity=V).patches
    assert still.side == "left"
    both = scene(6.2e-3, 36e3).prepare(side="both")
    level = both.step([0.0, 0.0, np.nan, 0.0, 0.0, 0.0], V)
    assert level.vertical_force["left"] == pytest.approx(2 * 36e3, rel=1e-8)
    assert level.vertical_force["right"] == 0.0
    assert "the right wheel is lifted" in level.report.status
    # without a pose both carry
    assert both.step(velocity=V).vertical_force == pytest.approx({"left": 36e3, "right": 36e3}, rel=1e-8)


@pytest.mark.coarse
@pytest.mark.parametrize(("lateral", "spacing"), [(0.0, 5e-4), (6.2e-3, 2e-4)])
def test_a_step_solves_the_scene(lateral, spacing):
    still = scene(lateral, 36e3, spacing)
    solved = still.solve()
    step = still.prepare(friction=mtb.Coulomb(0.0)).step(velocity=V)
    (patch,) = step.patches
    place = still.geometry.placement
    assert -step.force[2] == pytest.approx(36e3, rel=1e-6)
    assert patch.contact_angle == pytest.approx(place.contact_angle, abs=2e-3)
    # the scene lowers the wheel by an estimate of the approach, the step by what carries the force
    assert patch.normal_force == pytest.approx(solved.normal_force, rel=2e-3)
    assert patch.pressure.max() == pytest.approx(solved.pressure.max(), rel=1e-2)
    assert -step.pose[2] * np.cos(patch.contact_angle) == pytest.approx(solved.approach, rel=1e-2)


def test_a_prescribed_height_gives_the_force_found_for_it():
    contact = wheels(side="left").copy()
    free = contact.step(velocity=V)
    held = contact.step(free.pose, V)
    np.testing.assert_allclose(held.force, free.force, rtol=1e-9, atol=1e-6)
    assert held.report.normal_solves == 1
    deeper = free.pose.copy()
    deeper[2] -= 1e-5
    assert contact.step(deeper, V).force[2] < 1.1 * free.force[2]
    lifted = free.pose.copy()
    lifted[2] = 1e-3
    off = contact.step(lifted, V)
    assert off.patches == ()
    assert not off.force.any()


def test_approach_and_pressure_as_hertz():
    contact = conical(slope=0.0, side="left", friction=0.0)
    (patch,) = (step := contact.step(velocity=V)).patches
    closed = mtb.hertz(60e3, radii=(0.46, 0.3), lower=mtb.steel, upper=mtb.steel)
    assert -step.pose[2] == pytest.approx(closed.approach, rel=3e-3)
    assert patch.pressure.max() == pytest.approx(closed.peak_pressure, rel=1e-2)


def test_a_cylinder_on_its_own_surface_does_not_creep():
    """It turns about its undeformed surface, which its load has pressed below the rail's."""
    contact = conical(slope=0.0, side="left")
    pose = contact.step(velocity=V).pose
    for share in (1.0, 0.1):
        placed = pose * share
        (patch,) = contact.step(placed, [V, 0.0, 0.0, 0.0, V / 0.46, 0.0]).patches
        assert patch.approach == pytest.approx(-placed[2], rel=1e-4)
        # taken on the rail's surface it would be the approach over the radius, 1.6e-4 and 1.6e-5
        assert patch.creepage[:2] == pytest.approx([0.0, 0.0], abs=1e-3 * patch.approach / 0.46)


def carried_by(step, side):
    """Vertical force [N] of the pressures and of the tractions of a wheel."""
    mine = [p for p in step.patches if p.side == side]
    pressures = sum(p.normal_force * np.cos(p.contact_angle) for p in mine)
    tractions = -sum(
        (p.area * np.einsum("ij,jkl->ikl", p.rotation[:, :2], p.traction)).sum(axis=(1, 2))[2] for p in mine
    )
    return pressures, tractions


def test_the_wheel_on_its_flange_carries_its_force_with_friction():
    with pytest.warns(
        UserWarning, match=r"the flange is in contact: .* inclined by 6\d°, the normal force is 1"
    ):
        contact = scene(7e-3).prepare(friction=mtb.Coulomb(0.3))
    pose, moving = [0.0, 0.0, np.nan, 0.0, 0.0, 0.01], [V, 0.0, 0.0, -0.01 * V / 0.46, V / 0.46, 0.0]
    step = contact.step(pose, moving)
    pressures, tractions = carried_by(step, "left")
    # more than a quarter of it is friction
    assert tractions > 0.25 * 60e3
    assert pressures + tractions == pytest.approx(60e3, rel=1e-8)
    assert step.vertical_force == {"left": pytest.approx(60e3, rel=1e-8)}
    assert step.vertical_force["left"] == pytest.approx(-step.force[2], rel=1e-12)
    assert abs(step.balance_error) < 1e-8
    # a height that is given asks for no force
    held = contact.step(step.pose, moving)
    assert held.balance_error is None
    assert held.vertical_force["left"] == pytest.approx(60e3, rel=1e-7)


@pytest.mark.parametrize("velocity", [V, -V, [V, 0.1, 0.0, 0.02, 1.003 * V / 0.46, 0.05]])
def test_what_is_carried_is_of_each_wheel_or_of_all(velocity):
    contact = wheels().copy()
    for y in (2e-3, 6.4e-3):
        pose = np.array([0.0, y, np.nan, np.nan, 0.0, 2e-3])
        each = contact.step(pose, velocity)
        for side, force in each.vertical_force.items():
            assert force == pytest.approx(60e3, rel=1e-8)
            assert sum(carried_by(each, side)) == pytest.approx(force, rel=1e-9)
        pose[3] = 0.0
        both = contact.step(pose, velocity)
        assert sum(both.vertical_force.values()) == pytest.approx(120e3, rel=1e-8)
        assert sum(both.vertical_force.values()) == pytest.approx(-both.force[2], rel=1e-12)
        assert max(abs(each.balance_error), abs(both.balance_error)) < 1e-8


def test_without_friction_the_pressures_alone_carry_the_force():
    """The height is then that at which the normal problem carries it, whatever the wheels do."""
    contact = wheels(friction=0.0).copy()
    pose = [0.0, 6.4e-3, np.nan, np.nan, 0.0, 2e-3]
    step = contact.step(pose, V)
    for side in ("left", "right"):
        pressures, tractions = carried_by(step, side)
        assert tractions == 0.0
        assert pressures == pytest.approx(60e3, rel=1e-8)
    other = contact.copy().step(pose, [V, 0.3, 0.0, 0.0, 1.01 * V / 0.46, 0.1])
    assert other.pose == pytest.approx(step.pose, rel=1e-7, abs=1e-12)


def test_yaw_moves_the_contact_of_a_cone_ahead():
    contact = conical(slope=0.05, side="left", friction=0.0)
    yaw = 0.01
    (patch,) = contact.step([0.0, 0.0, np.nan, 0.0, 0.0, yaw], V).patches
    (straight,) = contact.step([0.0, 0.0, np.nan, 0.0, 0.0, 0.0], V).patches
    # the middle of the axle turns the wheel back by yaw times its distance; the radius falls outwards, so the
    # lowest points lie ahead by radius x slope x yaw
    seat = straight.position[1]
    assert straight.position[0] == pytest.approx(0.0, abs=1e-6)
    assert patch.position[0] == pytest.approx(-yaw * seat + 0.46 * 0.05 * yaw, rel=2e-2)


def test_right_is_the_mirror_image_of_left():
    contact = wheels()
    pose = np.array([0.0, 2e-3, -1.5e-4, 2e-5, 0.0, 4e-3])
    velocity = np.array([V, 0.05, 0.0, 0.0, V / 0.46, 0.2])
    flip = np.array([1.0, -1.0, 1.0, -1.0, 1.0, -1.0])
    here, there = contact.copy().step(pose, velocity), contact.copy().step(flip * pose, flip * velocity)
    np.testing.assert_allclose(there.force, [1, -1, 1] * here.force, rtol=1e-9, atol=1e-6)
    np.testing.assert_allclose(there.moment, [-1, 1, -1] * here.moment, rtol=1e-9, atol=1e-6)
    assert here.friction_power == pytest.approx(there.friction_power, rel=1e-9)
    left, right = here.patches[0], there.patches[-1]
    assert (left.side, right.side) == ("left", "right")
    np.testing.assert_allclose(right.pressure[::-1], left.pressure, rtol=1e-9, atol=1.0)
    np.testing.assert_allclose(right.points[1, ::-1], -left.points[1], atol=1e-12)
    for patch in here.patches:
        assert np.linalg.det(patch.rotation) == pytest.approx(1.0)


def test_backwards_is_forwards_from_the_other_side():
    contact = wheels(side="left")
    pose = np.array([0.0, 1e-3, np.nan, 0.0, 0.0, 0.0])
    forwards = contact.copy().step(pose, [V, 0.02, 0.0, 0.0, 1.001 * V / 0.46, 0.1])
    backwards = contact.copy().step(pose, [-V, 0.02, 0.0, 0.0, -1.001 * V / 0.46, -0.1])
    np.testing.assert_allclose(
        backwards.force, [-1, 1, 1] * forwards.force, rtol=1e-6, atol=1e-6 * abs(forwards.force[2])
    )
    assert forwards.friction_power == pytest.approx(backwards.friction_power, rel=1e-5)
    assert forwards.friction_power > 0.0


def test_creepages_are_those_of_the_kinematics():
    """[Kalker1990, ch. 1]: yaw and drift slip sideways, the cone and the yaw rate spin."""
    contact = conical()
    radius, slope = 0.46, 0.05
    pose = np.array([0.0, 0.0, np.nan, 0.0, 0.0, 0.0])
    yawed = pose.copy()
    yawed[5] = 2e-3
    # the axle carries its rotation along when it yaws
    spin = V / radius
    turning = np.array([V, 0.0, 0.0, -spin * np.sin(2e-3), spin * np.cos(2e-3), 0.0])
    for velocity in (turning, V):
        for patch in contact.step(yawed, velocity).patches:
            assert patch.creepage[1] == pytest.approx(-2e-3, rel=5e-3)
    drifting = contact.step(pose, [V, 0.03, 0.0, 0.0, spin, 0.0])
    for patch in drifting.patches:
        assert patch.creepage[1] == pytest.approx(0.03 / V, rel=5e-3)
        sign = 1.0 if patch.side == "left" else -1.0
        assert patch.creepage[2] == pytest.approx(-sign * np.sin(slope) / radius, rel=2e-2)
    # friction acts on the rail along the slip
    assert drifting.force[1] > 0.0
    for patch in contact.step(pose, [V, 0.0, 0.0, 0.0, spin, 0.5]).patches:
        sign = 1.0 if patch.side == "left" else -1.0
        assert patch.creepage[2] == pytest.approx((0.5 - sign * np.sin(slope) * spin) / V, rel=2e-2)


def test_a_free_wheelset_rolls_as_klingel_says():
    """Without creep forces y'' + slope / (seat radius) y = 0 along the rail."""
    contact = conical(force=60e3)
    slope, radius = 0.05, 0.46
    # each wheel carries its force, so the lateral forces of spin cancel
    pose = np.array([0.0, 0.0, np.nan, np.nan, 0.0, 0.0])
    middle = contact.step(pose, V)
    seat = middle.patches[0].position[1]
    rolling = V / (radius - slope * middle.patches[0].wheel_position)

    def resultant(pose, roll, unknown):
        drift, turn, spin = unknown
        # the rotation about the axle lies along the axle, wherever yaw and roll have put it
        axle = np.array([-np.sin(pose[5]), np.cos(pose[5]), roll])
        step = contact.step(pose, [V, drift, 0.0, *(spin * axle + [0.0, 0.0, turn])])
        # friction alone, without the lateral part of the pressures
        return np.array(
            [
                sum((p.area * p.traction[1]).sum() * np.cos(p.contact_angle) for p in step.patches),
                sum((p.area * p.traction[0]).sum() * p.position[1] for p in step.patches),
                sum((p.area * p.traction[0]).sum() for p in step.patches),
            ]
        )

    for y, yaw in ((1e-3, 0.0), (0.0, 1e-3), (-1e-3, 5e-4)):
        pose[1], pose[5] = y, yaw
        roll = contact.step(pose, V).pose[3]
        unknown, steps = np.array([0.0, 0.0, rolling]), np.array([1e-3, 1e-3, 1e-4])
        for _ in range(3):
            base = resultant(pose, roll, unknown)
            columns = [(resultant(pose, roll, unknown + d) - base) / d.sum() for d in np.diag(steps)]
            unknown = unknown - np.linalg.solve(np.stack(columns, axis=1), base)
        drift, turn, _ = unknown
        # drift = V yaw, and yaw' = -slope y V / (seat radius); where the wheelset rolls as well, the contact
        # wanders on the wheel by that much times the radii of wheel and head
        assert drift == pytest.approx(V * yaw, abs=0.01 * V * 1e-3)
        on_wheel = y + (radius + 0.3) * roll
        assert abs(on_wheel - y) < 0.06 * 1e-3
        expected = -slope * on_wheel / (seat * radius) * V
        assert turn == pytest.approx(expected, abs=0.01 * slope * 1e-3 / (seat * radius) * V)


def test_each_wheel_carries_its_force():
    contact = wheels()
    pose = np.array([0.0, 3e-3, np.nan, np.nan, 0.0, 0.0])
    step = contact.step(pose, V)
    for side in ("left", "right"):
        assert sum(carried_by(step, side)) == pytest.approx(60e3, rel=1e-8)
    assert np.isfinite(step.pose).all()
    level = pose.copy()
    level[3] = 0.0
    both = contact.step(level, V)
    carried = sum(sum(carried_by(both, side)) for side in ("left", "right"))
    assert carried == pytest.approx(120e3, rel=1e-8)


@pytest.mark.parametrize("y", [5.5e-3, 6e-3, 6.4e-3, 6.6e-3, -6.4e-3])
def test_a_free_wheelset_on_its_flange_is_in_balance(y):
    """There a roll moves the flange into the rail: height and roll are coupled."""
    step = wheels().copy().step([0.0, y, np.nan, np.nan, 0.0, 0.0], V)
    flange = step.patches[0 if y > 0.0 else -1]
    assert flange.contact_angle > 0.3
    held = wheels().copy().step(step.pose, V)
    for side in ("left", "right"):
        assert sum(carried_by(held, side)) == pytest.approx(60e3, rel=1e-7)


def test_the_wheelset_as_the_scene_shifts_it_is_in_balance():
    step = wheels(6.2e-3).copy().step([0.0, 0.0, np.nan, np.nan, 0.0, 0.0], V)
    shifted = wheels().copy().step([0.0, 6.2e-3, np.nan, np.nan, 0.0, 0.0], V)
    assert step.pose[3] == pytest.approx(shifted.pose[3], rel=1e-6)


def test_tread_and_flange_carry_together():
    y = np.array([-0.052, -0.036, 0.06])
    wheel = mtb.Profile.from_points(y, [-1.8e-3 - 16e-3 * np.tan(np.radians(60)), -1.8e-3, 3e-3], "linear")
    contact = scene(wheel=wheel, spacing=3e-4).prepare(friction=mtb.Coulomb(0.3))
    # shifted until both bear: the flange takes over within some tenths of a millimetre
    low, high = 0.0, 12e-3
    for _ in range(20):
        lateral = 0.5 * (low + high)
        step = contact.step([0.0, lateral, np.nan, 0.0, 0.0, 0.0], V)
        assert sum(carried_by(step, "left")) == pytest.approx(60e3, rel=1e-8)
        if len(step.patches) == 2:
            break
        if step.patches[0].contact_angle < 0.2:
            low = lateral
        else:
            high = lateral
    flange, tread = step.patches
    assert flange.contact_angle == pytest.approx(np.radians(60), abs=0.1)
    assert tread.contact_angle == pytest.approx(0.05, abs=0.02)
    # the flange runs on a larger radius: it drives the rail forwards against the tread
    assert flange.creepage[0] < tread.creepage[0]


def hollow(depth=1.5e-4):
    """A cone worn hollow where it rolls: two places on nearly one plane touch, 11 mm apart."""
    y = np.linspace(-0.05, 0.05, 2001)
    return mtb.Profile.from_points(y, 0.025 * y + depth * np.exp(-(((y + 4e-3) / 4e-3) ** 2)))


@pytest.mark.coarse
def test_places_on_one_plane_are_solved_together():
    still = scene(wheel=hollow(), rail=round_head(), rail_inclination=0.0)
    contact = still.prepare(friction=mtb.Coulomb(0.3))
    solved = still.solve()
    step = contact.step(velocity=V)
    # both press the bodies apart at both
    assert -step.pose[2] == pytest.approx(solved.approach, rel=1e-3)
    (patch,) = step.patches
    loaded = (patch.pressure > 0.0).any(axis=1)
    assert np.abs(np.diff(loaded.astype(int))).sum() == 4
    forces = [-contact.step([0.0, 0.0, -z, 0.0, 0.0, 0.0], V).force[2] for z in np.arange(3e-5, 2e-4, 1e-5)]
    assert (np.diff(forces, n=2) > 0.0).all()


def test_heat_of_unlike_bodies_is_that_of_their_slip():
    heats = []
    for spacing in (1e-3, 5e-4):
        unlike = scene(spacing=spacing, upper=mtb.Material(2e9, 0.3)).prepare(friction=mtb.Coulomb(0.3))
        for velocity in (V, [V, 0.0, 0.0, 0.0, 0.999 * V / 0.46, 0.0]):
            step = unlike.step(velocity=velocity)
            (patch,) = step.patches
            by_cells = (patch.traction * patch.slip_velocity).sum() * patch.area
            heats.append((by_cells, step.friction_power))
    assert all(0.0 < by_cells < heat for by_cells, heat in heats)
    coarse, fine = ([heat / by_cells - 1.0 for by_cells, heat in heats[k : k + 2]] for k in (0, 2))
    assert all(b < 0.7 * a for a, b in zip(coarse, fine, strict=True))


def test_a_start_from_other_wheels_changes_nothing():
    contact = wheels(side="left").copy()
    step = contact.step(velocity=V)
    for depth in (1e-9, 5e-3, 1.0):
        again = contact.step(velocity=V, state=WheelState((depth,), step.state.ratio))
        np.testing.assert_allclose(again.force, step.force, rtol=1e-6, atol=0.1)


def test_memory_changes_nothing_but_time():
    contact = wheels().copy()
    poses = [np.array([0.0, 1e-3 * np.sin(k / 3), np.nan, 0.0, 0.0, 1e-3 * np.cos(k / 3)]) for k in range(6)]
    warm = [contact.step(pose, V, dt=1e-3) for pose in poses]
    cold = [contact.copy().step(pose, V, dt=1e-3) for pose in poses]
    for a, b in zip(warm, cold, strict=True):
        np.testing.assert_allclose(a.force, b.force, rtol=1e-6, atol=1e-5 * abs(b.force[2]))
        assert a.friction_work == pytest.approx(1e-3 * a.friction_power)
    # within a step the trials of the height help each other, with memory or without
    assert sum(s.report.iterations for s in warm[1:]) < 0.8 * sum(s.report.iterations for s in cold[1:])
    assert sum(s.report.normal_solves for s in warm[1:]) < sum(s.report.normal_solves for s in cold[1:])
    again = pickle.loads(pickle.dumps(contact))
    resumed = again.step(poses[-1], V, state=pickle.loads(pickle.dumps(warm[-2].state)))
    np.testing.assert_allclose(resumed.force, warm[-1].force, rtol=1e-9, atol=1e-6)


@pytest.mark.parametrize("spacing", [1e-3, 5e-4])
def test_heat_is_the_work_of_the_creep_forces(spacing):
    contact = wheels(spacing=spacing).copy()
    velocity = np.array([V, 0.1, 0.0, 0.02, 1.003 * V / 0.46, 0.05])
    for sense in (1.0, -1.0):
        step = contact.step([0.0, 5.5e-3, np.nan, np.nan, 0.0, 2e-3], sense * velocity)
        work = of_loads = 0.0
        for patch in step.patches:
            # the wheel's undeformed surface, whose velocity counts, lies deeper than the plane
            on_wheel = patch.points - patch.approach * patch.rotation[:, 2, None, None]
            arm = on_wheel - step.reference_point[:, None, None]
            moving = sense * (velocity[:3, None, None] + np.cross(velocity[3:], arm, axis=0))
            friction = np.einsum("ij,jkl->ikl", patch.rotation[:, :2], patch.traction) * patch.area
            work += (friction * moving).sum()
            of_loads += (patch.load() * moving).sum()
            # what the slip of the cells dissipates is less, the more so the larger they are
            by_cells = (patch.traction * patch.slip_velocity).sum() * patch.area
            assert -1e-9 * work < by_cells < patch.friction_power
        assert step.friction_power == pytest.approx(work, rel=1e-9)
        power = sense * (step.force @ velocity[:3] + step.moment @ velocity[3:])
        assert power == pytest.approx(of_loads, abs=1e-9 * abs(step.force[2]) * V)


def test_tractions_keep_to_friction():
    (patch,) = wheels(side="left").step(velocity=[V, 0.1, 0.0, 0.0, 1.01 * V / 0.46, 0.0]).patches
    bound = 0.3 * patch.pressure
    size = np.hypot(*patch.traction)
    assert (size <= bound * (1 + 1e-6) + 1.0).all()
    assert (patch.status == 2).any()
    assert (patch.slip_velocity[:, patch.status == 1] == 0.0).all()


def test_patches_draw_themselves():
    (patch,) = wheels(side="left").step(velocity=[V, 0.02, 0.0, 0.0, V / 0.46, 0.0]).patches
    for quantity in ("pressure", "traction", "slip", "status"):
        assert patch.plot(quantity).axes
    assert "m/s" in patch.plot("slip").axes[-1].get_ylabel()


def test_a_step_draws_its_patches_side_by_side():
    contact = wheels().copy()
    step = contact.step([0.0, 6.4e-3, np.nan, np.nan, 0.0, 0.0], V)
    for quantity in ("pressure", "traction", "slip", "status"):
        assert len(step.plot(quantity).axes) >= len(step.patches) == 2
    maps = [ax.collections[1].norm for ax in step.plot("pressure").axes[:2]]
    assert maps[0].vmax == maps[1].vmax
    ends = [ax.get_ylim() for ax in step.plot("pressure", "line").axes]
    assert ends[0] == ends[1]
    assert step._repr_png_().startswith(b"\x89PNG")
    with pytest.raises(ValueError, match="maps or lines"):
        step.plot("pressure", ax=step.plot().axes[0])
    if len({patch.side for patch in step.patches}) > 1:
        with pytest.raises(ValueError, match="too far apart for one picture"):
            step.plot("pressure", "3d")
    with pytest.raises(ValueError, match="quantity is 'gap'"):
        step.plot("gap")
    lifted = contact.step([0.0, 0.0, 1e-3, 0.0, 0.0, 0.0], V)
    assert lifted._repr_png_() is None
    with pytest.raises(ValueError, match="no patch to draw"):
        lifted.plot()


def test_a_patch_saves_itself(tmp_path):
    (patch,) = wheels(side="left").step(velocity=[V, 0.02, 0.0, 0.0, V / 0.46, 0.0]).patches
    patch.save(tmp_path / "patch")
    summary = json.loads((tmp_path / "patch" / "summary.json").read_text())
    assert summary["normal_force"] == pytest.approx(patch.normal_force)
    assert summary["creepage"] == pytest.approx(patch.creepage.tolist())
    with np.load(tmp_path / "patch" / "fields.npz") as fields:
        np.testing.assert_array_equal(fields["slip"], patch.slip_velocity)


@pytest.mark.filterwarnings("ignore:StaticKinetic depends on the grid")
def test_wheels_come_back_from_their_file(tmp_path):
    path = tmp_path / "wheelset.mtbw"
    laws = (mtb.StaticKinetic(0.4, 0.3), mtb.TabulatedFriction([0.0, 1.0], [0.4, 0.2], 1e-3))
    for side, law in zip(("right", "both"), laws, strict=True):
        given = scene(2e-3, upper=mtb.Material(7e10, 0.33)).prepare(
            side=side,
            friction=law,
            layer=mtb.InterfaceLayer(1e-5, 1e9),
            reference_point=(0.1, 0.0, 0.4),
            standstill_speed=0.1,
        )
        given.save(path)
        read = mtb.PreparedWheels.load(path)
        assert read.sides == given.sides
        assert repr(read) == repr(given)
        np.testing.assert_array_equal(read.reference_point, given.reference_point)
        pose, velocity = [0.0, 1e-3, np.nan, 0.0, 0.0, 1e-3], [V, 0.05, 0.0, 0.0, V / 0.46, 0.1]
        here, there = given.step(pose, velocity), read.step(pose, velocity)
        np.testing.assert_array_equal(there.force, here.force)
        np.testing.assert_array_equal(there.moment, here.moment)
    assert [p.name for p in tmp_path.iterdir()] == ["wheelset.mtbw"]
    data = path.read_bytes()
    for bad, why in ((data[:-8], "cut short"), (b"MTBC" + data[4:], "does not begin"), (b"", "does not")):
        path.write_bytes(bad)
        with pytest.raises(ValueError, match=rf"wheelset.mtbw: no prepared wheels: .*{why}"):
            mtb.PreparedWheels.load(path)
    with pytest.raises(ValueError, match="it is a directory"):
        given.save(tmp_path)
    with pytest.raises(FileNotFoundError):
        mtb.PreparedWheels.load(tmp_path / "none.mtbw")


def test_ctrl_c_stops_a_step():
    # takes seconds if nobody stops it
    fine = scene(spacing=2.5e-5).prepare(friction=mtb.Coulomb(0.3))
    timer = threading.Timer(0.2, signal.raise_signal, (signal.SIGINT,))
    # a shell starts what runs in its background without Ctrl-C
    kept = signal.signal(signal.SIGINT, signal.default_int_handler)
    timer.start()
    try:
        with pytest.raises(KeyboardInterrupt):
            fine.step(velocity=[V, 0.02, 0.0, 0.0, V / 0.46, 0.0])
    finally:
        timer.cancel()
        signal.signal(signal.SIGINT, kept)
    # inside: a step that was solved leaves its state
    assert fine._core.state == ([], [], [], None)


def test_moments_are_about_the_point_named():
    pose, velocity = [0.0, 1e-3, np.nan, 0.0, 0.0, 0.0], V
    point = (0.1, 0.2, 0.3)
    here = wheels(friction=0.0).copy().step(pose, velocity)
    there = scene().prepare(side="both", friction=mtb.Coulomb(0.0), reference_point=point)
    there = there.step(pose, [V, 0.0, 0.0, 0.0, V / 0.46, 0.0])
    np.testing.assert_allclose(there.reference_point, np.array(point) + there.pose[:3])
    # the velocity given is that of the other point: only the pressures compare
    arm = here.reference_point - there.reference_point
    sums = []
    for step in (here, there):
        force, moment = np.zeros(3), np.zeros(3)
        for p in step.patches:
            load = -p.area * p.pressure * p.rotation[:, 2, None, None]
            force += load.sum(axis=(1, 2))
            moment += np.cross(p.points - step.reference_point[:, None, None], load, axis=0).sum(axis=(1, 2))
        sums.append((force, moment))
    np.testing.assert_allclose(sums[1][1], sums[0][1] + np.cross(arm, sums[0][0]), rtol=1e-6, atol=1e-3)


def test_standstill():
    contact = scene().prepare(standstill_speed=0.5)
    assert np.abs(contact.step(velocity=0.0).force[:2]).max() < 0.05 * 60e3
    with pytest.raises(ValueError, match="does not roll"):
        wheels(side="left").step(velocity=0.0)
    locked = wheels(side="left").step(velocity=[V, 0.0, 0.0, 0.0, 0.0, 0.0])
    # a locked wheel slides: friction on the rail along its motion
    assert locked.force[0] == pytest.approx(0.3 * locked.patches[0].normal_force, rel=1e-3)


def cut(contact):
    """A state whose field has lost a component."""
    state = contact.step(velocity=V).state
    ((side, first, ratio),) = state.ratio
    return WheelState(state.depth, ((side, first, ratio[:1]),))


def at(column):
    """A state whose field begins at a column."""
    return WheelState((1e-4,), (("left", (column, 0), np.zeros((2, 1, 1))),))


BAD = [
    (lambda c: c.step(), "velocity is missing"),
    (lambda c: c.step([0.0] * 5, V), "pose is"),
    (lambda c: c.step([np.inf] * 6, V), "pose, x, is inf"),
    (lambda c: c.step([0.0, np.nan, 0.0, 0.0, 0.0, 0.0], V), "z alone, or z and roll"),
    (lambda c: c.step([0.0] * 5 + [1j], V), "pose is"),
    (lambda c: c.step([0.0, 0.0, -1e300, 0.0, 0.0, 0.0], V), r"pose, z, is -1e\+300"),
    (lambda c: c.step([1e30, 0.0, np.nan, 0.0, 0.0, 0.0], V), r"pose, x, is 1e\+30 m"),
    (lambda c: c.step([0.0] * 5 + [np.pi / 2], V), "yaw is 1.57"),
    (lambda c: c.step(velocity=[1.0, 2.0]), "velocity is"),
    (lambda c: c.step(velocity=[1e300] + 5 * [0.0]), r"velocity\[0\] is"),
    (lambda c: c.step(velocity=V, state=5), "state is 5: a WheelState"),
    (lambda c: c.step(velocity=V, state=WheelState((np.nan,), ())), "state.depth is"),
    (lambda c: c.step(velocity=V, state=WheelState(None, ())), "state.depth is None"),
    (lambda c: c.step(velocity=V, state=WheelState((), None)), "state.ratio is None"),
    (lambda c: c.step(velocity=V, state=at(2**70)), r"state.ratio\[0\] is not"),
    (lambda c: c.step(velocity=V, state=at("a")), r"state.ratio\[0\] is not"),
    (lambda c: mtb.PreparedWheels.load(None), "path is None"),
    (lambda c: c.step(velocity=V, state=WheelState((), (("left", (0, 0)),))), r"state.ratio\[0\] is not"),
    (lambda c: c.step(velocity=V, state=cut(c)), r"state.ratio\[0\] is not"),
    (lambda c: c.step(velocity=V, dt=0.0), "dt is 0"),
    (lambda c: c.step([0.0, 0.5, 0.0, 0.0, 0.0, 0.0], V), "nowhere above the head of the rail"),
    (lambda c: c.step([0.0, 0.0, -2e-2, 0.0, 0.0, 0.0], V), "contact"),
]


@pytest.mark.parametrize(("call", "message"), BAD, ids=[message[:24] for _, message in BAD])
def test_bad_input_is_named(call, message):
    with pytest.raises(ValueError, match=message):
        call(wheels(side="left").copy())


def test_what_cannot_be_prepared_is_named():
    with pytest.raises(ValueError, match="side is 'middle'"):
        scene().prepare(side="middle")
    with pytest.raises(ValueError, match="friction varies over the patch"):
        scene().prepare(friction=mtb.Coulomb(np.full((3, 3), 0.3)))
    with pytest.raises(ValueError, match=r"friction is 'wet'"):
        scene().prepare(friction="wet")
    by_number, by_law = (scene().prepare(friction=f).step(velocity=V) for f in (0.2, mtb.Coulomb(0.2)))
    assert np.array_equal(by_number.force, by_law.force)
    with pytest.raises(ValueError, match="layer is 3: wheels in steps take an InterfaceLayer"):
        scene().prepare(layer=3)
    with pytest.raises(ValueError, match="side is for wheels on rails"):
        mtb.scenes.pole_shoe_on_rail(spacing=6e-3).prepare("half-space", side="left")
    with pytest.raises(ValueError, match="no geometry for its elastic bodies"):
        scene().prepare("elastic-upper")


def test_a_flange_that_a_step_reaches_is_told_by_field_and_in_words():
    contact = mtb.scenes.wheel_on_rail(spacing=1e-3).prepare(friction=mtb.Coulomb(0.3))
    tread = contact.step([0.0, -1.5e-3, np.nan, 0.0, 0.0, 0.0], 10.0)
    assert [patch.on_flange for patch in tread.patches] == [False]
    assert tread.report.status == "solved"
    step = contact.step([0.0, 1.5e-3, np.nan, 0.0, 0.0, 0.0], 10.0)
    (patch,) = step.patches
    assert patch.on_flange
    angle = f"{np.degrees(patch.contact_angle):.0f}°"
    assert f"the flange of the left wheel is in contact, where the contact plane is inclined by {angle}" in (
        step.report.status
    )
    assert "flange" in step.plot().axes[0].get_title(loc="left")


@pytest.mark.parametrize("side", ["left", "right"])
def test_a_wheel_that_has_climbed_its_rail_is_told(side):
    contact = mtb.scenes.wheel_on_rail(lateral=0.0, force=60e3, spacing=1e-3).prepare(side=side)
    outwards = 1.0 if side == "left" else -1.0
    for aside in (-40e-3, -20e-3, 0.0, 5e-3, 7e-3):
        assert "climbed" not in contact.step([0, outwards * aside, np.nan, 0, 0, 0], 10.0).report.status
    for aside in (30e-3, 50e-3, 75e-3):
        status = contact.step([0, outwards * aside, np.nan, 0, 0, 0], 10.0).report.status
        assert f"the {side} wheel stands on the tip of its flange" in status


def test_a_flange_that_no_height_holds_is_told():
    """On a plane steeper than the angle of friction it outweighs the pressure where it drags the rail up."""
    contact = scene(spacing=1e-3).prepare(friction=mtb.Coulomb(0.7), side="left")

    def step(yaw):
        return contact.copy().step(
            [0.0, 7.4e-3, np.nan, 0.0, 0.0, yaw], [V, 0.0, 0.0, -yaw * V / 0.46, V / 0.46, 0.0]
        )

    with pytest.raises(mtb.ConvergenceError, match=r"friction lifts the rail there .*angle of friction"):
        step(-0.03)
    # with the other yaw it presses the rail down
    climbing = step(0.03)
    assert climbing.vertical_force["left"] == pytest.approx(60e3, rel=1e-8)
    pressures, tractions = carried_by(climbing, "left")
    assert tractions > pressures


def test_a_patch_that_lifts_its_rail_beside_one_that_carries_is_told():
    """The root of a stepped wheel bears on the tread, and its flange is dragged up the face of the rail."""
    y = np.array([-0.052, -0.036, 0.06])
    wheel = mtb.Profile.from_points(y, [-1.8e-3 - 16e-3 * np.tan(np.radians(60)), -1.8e-3, 3e-3], "linear")
    contact = scene(wheel=wheel, spacing=5e-4).prepare(friction=mtb.Coulomb(0.7))
    yaw, told = -0.02, []
    for shift in np.arange(2e-3, 11e-3, 0.25e-3):
        # not every pose has a height
        with contextlib.suppress(mtb.ConvergenceError):
            step = contact.copy().step(
                [0.0, shift, np.nan, 0.0, 0.0, yaw], [V, 0.0, 0.0, -yaw * V / 0.46, V / 0.46, 0.0]
            )
            lifts = [p for p in step.patches if p.force[2] > 0.0]
            assert ("another height may carry" in step.report.status) == bool(lifts)
            told += lifts
    assert told


def test_a_tolerance_given_to_prepare_is_held_to():
    with pytest.warns(mtb.ToleranceWarning, match="estimated error of the pressure") as caught:
        scene(spacing=2e-3).prepare(tolerance=0.01, quantity="pressure")
    assert caught[0].filename == __file__


def test_a_patch_has_its_force_and_a_step_tells_creepages_with_units():
    step = wheels(5e-3).step(velocity=20.0)
    assert sum(patch.force for patch in step.patches) == pytest.approx(
        step.force, abs=1e-9 * abs(step.force[2])
    )
    names, words = zip(*step.told(), strict=True)
    left = names.index("left wheel")
    creepage = words[names.index("  creepage", left)]
    found = re.fullmatch(r"(\S+) along, (\S+) across, spin (-\S+) 1/m", creepage)
    assert np.array(found.groups(), float) == pytest.approx(step.patches[0].creepage, rel=1e-4, abs=1e-12)
    assert names.count("  creepage") == len(step.patches)


@pytest.mark.parametrize("is_loaded", [False, True], ids=["made", "from bytes"])
def test_a_pressure_above_the_hardness_is_asked_about_once(is_loaded, tmp_path):
    contact = wheels(0.0, side="left", friction=0.0, force=60e3)
    if is_loaded:
        contact.save(tmp_path / "wheels.mtbw")
        contact = mtb.PreparedWheels.load(tmp_path / "wheels.mtbw")
    flange = [0.0, 7e-3, np.nan, 0.0, 0.0, 0.0]
    contact.step(velocity=20.0)
    with pytest.warns(UserWarning, match="more than the hardness of rail steel"):
        contact.step(flange, 20.0)
    soft = mtb.Material(100e9, 0.3)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        contact.step(flange, 20.0)
        assert wheels(side="left", friction=0.0, upper=soft, lower=soft).step(flange, 20.0).patches


@pytest.mark.parametrize("lateral", [0.0, -6e-3])
def test_a_patch_rolls_alone_as_in_its_step(lateral: float) -> None:
    """Its cells are equal in its own plane, whatever the plane's inclination in the track."""
    scene = mtb.scenes.wheel_on_rail(lateral=0.0, force=60e3, spacing=5e-4)
    step = scene.prepare(friction=mtb.Coulomb(0.3)).step([0, lateral, np.nan, 0, 0, 2e-3], 20.0)
    for patch in step.patches:
        area = (patch.x[1] - patch.x[0]) * (patch.y[1] - patch.y[0])
        (force,) = mtb.creep_curve(patch, [patch.creepage], mtb.Coulomb(0.3))
        assert force[:2] == pytest.approx(area * patch.traction.sum(axis=(1, 2)), abs=1e-5 * 0.3 * 60e3)
        quick = mtb.fastsim(patch, [patch.creepage], mtb.Coulomb(0.3)).force
        assert quick[:2] == pytest.approx(force[:2], abs=0.15 * 0.3 * 60e3)


def test_a_narrow_contact_of_worn_profiles_has_its_height_and_roll() -> None:
    """Three cells across: the force over the height is continuous, but its derivatives lead nowhere."""
    wheel, rail = (mtb.Profile.standard(name) for name in ("S1002", "60E1"))
    y = np.linspace(*wheel.range, 1500)
    worn = mtb.Profile.from_points(y, wheel.height(y) + 1.5e-3 * np.exp(-((y / 0.02) ** 2)))
    y = np.linspace(*rail.range, 1200)
    gone = 1e-3 * np.exp(-(((y + 0.02) / 0.01) ** 2)) + 0.5e-3 * np.exp(-((y / 0.012) ** 2))
    track = mtb.Profile.from_points(y, rail.height(y) - gone)
    scene = mtb.scenes.wheel_on_rail(worn, track, lateral=0.0, force=60e3, spacing=1e-3)
    wheels = scene.prepare(side="both")
    pose = (0.0, -2.72394e-3, np.nan, np.nan, 0.0, 5e-3)
    step = wheels.step(pose, 20.0)
    assert step.balance_error is not None
    assert abs(step.balance_error) < 1e-8
    # and it is one: given, the same place carries the same
    given = wheels.copy().step(step.pose, 20.0)
    for side in ("left", "right"):
        assert given.vertical_force[side] == pytest.approx(60e3, rel=1e-6)


def test_a_rotation_about_a_level_axle_is_asked_about():
    """1 mrad of roll that is found is 1 mrad of the rotation along z; a number has it."""
    made, pose = wheels(side="both"), (0.0, 4e-3, np.nan, np.nan, 0.0, 0.0)
    rolling = made.step(pose, V)
    for more, words in (({}, "as wz, or a number as velocity"), ({"axle_moment": 0.0}, "give wy = 0")):
        with pytest.warns(UserWarning, match="is about a level axle") as said:
            level = made.copy().step(pose, [V, 0.0, 0.0, 0.0, V / 0.46, 0.0], **more)
        assert words in str(said[0].message)
        assert abs(level.moment[2]) < 0.95 * abs(rolling.moment[2])
    turned = made.step(pose, [V, 0.0, 0.0, 0.0, V / 0.46, V / 0.46 * rolling.pose[3]])
    assert turned.moment[2] == pytest.approx(rolling.moment[2], rel=3e-3)
    free = [
        made.copy().step(pose, velocity, axle_moment=0.0)
        for velocity in (V, [V, 0.0, 0.0, 0.0, 0.0, 0.0], [V, 0.0, 0.0, 0.0, *turned.velocity[4:]])
    ]
    for step in free[1:]:
        assert step.moment == pytest.approx(free[0].moment, abs=2.0)
