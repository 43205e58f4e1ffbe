# SPDX-License-Identifier: MIT OR Apache-2.0
"""Wheels whose position and rotation are found from forces, rails on springs, and bodies beside their places.

Identities of mechanics judge them: the same step with the position given, statics of the springs, the same
motion told in another way, and frames that turn.
"""

from __future__ import annotations

import pickle
from functools import lru_cache
from typing import Any

import numpy as np
import pytest

import mtb_rs as mtb

pytestmark = [
    pytest.mark.filterwarnings("ignore:the peak pressure is"),
    pytest.mark.filterwarnings("ignore:on the flange"),
]

V, FORCE = 20.0, 60e3
NAN = np.nan


@lru_cache
def made(side="left", spacing=1.5e-3, **changes):
    scene = mtb.scenes.wheel_on_rail(lateral=0.0, force=FORCE, spacing=spacing)
    return scene.prepare(side=side, friction=mtb.Coulomb(0.3), **changes)


def wheels(side="left", **changes):
    return made(side, **changes).copy()


def six(step):
    """Velocity as it was found."""
    return step.velocity


@pytest.mark.parametrize("share", [-0.1, 0.2, 0.45, 0.75, 1.0, 1.3])
def test_a_lateral_force_is_met_from_tread_to_flange(share):
    """Between tread and flange too, where the contact turns by 30 degrees within 30 micrometres."""
    step = wheels().step([0, NAN, NAN, 0, 0, 3e-3], V, lateral_force=share * FORCE)
    assert step.force[1] == pytest.approx(share * FORCE, abs=1e-8 * FORCE)
    assert -step.force[2] == pytest.approx(FORCE, rel=1e-8)
    assert abs(step.balance_error) < 1e-8
    # the position, given, makes the forces: found without the search for y
    given = wheels().step([0, step.pose[1], step.pose[2], 0, 0, 3e-3], V)
    assert given.force == pytest.approx(step.force, abs=1e-6 * FORCE)
    assert ("further up the flange" in step.report.status) == any(p.on_flange for p in step.patches)


@pytest.mark.parametrize("share", [-0.4, 0.0, 0.3])
def test_both_wheels_find_y_height_and_roll(share):
    contact = wheels("both")
    step = contact.step([0, NAN, NAN, NAN, 0, 1e-3], V, lateral_force=share * FORCE)
    assert step.force[1] == pytest.approx(share * FORCE, abs=2e-8 * FORCE)
    for carried in step.vertical_force.values():
        assert carried == pytest.approx(FORCE, rel=1e-8)
    # the next step starts there
    again = contact.step([0, NAN, NAN, NAN, 0, 1e-3], V, lateral_force=(share + 0.005) * FORCE)
    assert abs(again.pose[1] - step.pose[1]) < 1e-3
    assert again.report.normal_solves < step.report.normal_solves
    kept = pickle.loads(pickle.dumps(step.state))
    assert wheels("both").step(
        [0, NAN, NAN, NAN, 0, 1e-3], V, state=kept, lateral_force=(share + 0.005) * FORCE
    ).pose == pytest.approx(again.pose, abs=1e-9)


@pytest.mark.parametrize(("side", "share", "most"), [("left", 0.45, 90), ("both", 0.3, 270)])
def test_a_first_step_goes_straight_on_a_straight_curve(side, share, most):
    """Normal problems to a position 6 mm from where the search begins, 64 and 194 of them, and of the next.

    With steps of half a millimetre, and Newton's method tried from afar, they are 141 and 580.
    """
    contact = wheels(side)
    pose = [0, NAN, NAN, NAN if side == "both" else 0, 0, 3e-3]
    first = contact.step(pose, V, lateral_force=share * FORCE)
    assert abs(first.pose[1]) > 5e-3
    assert first.report.normal_solves <= most
    again = contact.step(pose, V, lateral_force=(share + 0.002) * FORCE)
    assert again.report.normal_solves <= 8 * len(contact.sides)


def test_a_force_that_no_position_gives_says_why():
    with pytest.raises(mtb.ConvergenceError, match="gets no nearer than"):
        wheels().step([0, NAN, NAN, 0, 0, 3e-3], V, lateral_force=-2.0 * FORCE)


def test_free_rolling_has_no_moment_about_the_axle():
    yaw, roll = 4e-3, 0.0
    step = wheels("both").step([0, 3e-3, NAN, NAN, 0, yaw], V, axle_moment=0.0)
    roll = step.pose[3]
    axle = np.array([-np.sin(yaw) * np.cos(roll), np.cos(yaw) * np.cos(roll), np.sin(roll)])
    assert abs(axle @ step.moment) < 1e-7 * FORCE
    # another rotation has one
    turned = six(step) + np.array([0, 0, 0, *(0.01 * axle)])
    other = wheels("both").step([0, 3e-3, NAN, NAN, 0, yaw], turned)
    assert abs(axle @ other.moment) > 10.0


@pytest.mark.parametrize("force", [-9e3, 0.0, 4e3])
def test_braking_by_force_finds_the_rotation(force):
    step = wheels().step([0, 1e-3, NAN, 0, 0, 1e-3], V, longitudinal_force=force)
    assert step.force[0] == pytest.approx(force, abs=1e-8 * FORCE)
    given = wheels().step([0, 1e-3, NAN, 0, 0, 1e-3], six(step))
    assert given.force == pytest.approx(step.force, abs=1e-6 * FORCE)
    # a wheel that is held back pushes its rail forwards, and turns slower than it would roll
    free = wheels().step([0, 1e-3, NAN, 0, 0, 1e-3], V, longitudinal_force=0.0)
    assert np.sign(six(free)[4] - six(step)[4]) == np.sign(force)
    with pytest.raises(mtb.ConvergenceError, match="coefficient of friction"):
        wheels().step([0, 1e-3, NAN, 0, 0, 1e-3], V, longitudinal_force=0.31 * FORCE)


def test_lateral_and_longitudinal_force_together():
    step = wheels().step([0, NAN, NAN, 0, 0, 2e-3], V, lateral_force=6e3, longitudinal_force=3e3)
    assert step.force == pytest.approx([3e3, 6e3, -FORCE], abs=1e-8 * FORCE)


def test_springs_give_way_by_force_over_stiffness():
    stiffness, acting = (2e7, 5e7), (1e3, -2e3)
    contact = wheels("both", rail_stiffness=stiffness, rail_force=acting)
    pose = [0, NAN, NAN, NAN, 0, 2e-3]
    step = contact.step(pose, V, lateral_force=0.2 * FORCE)
    for side, out in (("left", 1.0), ("right", -1.0)):
        force = sum(p.force for p in step.patches if p.side == side)
        y, z = step.rail_displacement[side]
        assert y == pytest.approx((force[1] + out * acting[0]) / stiffness[0], abs=1e-10)
        assert z == pytest.approx((force[2] + acting[1]) / stiffness[1], abs=1e-10)
    # the same with rails that are moved so from the start
    rails = {side: (*moved, 0.0) for side, moved in step.rail_displacement.items()}
    rigid = wheels("both").step([0, step.pose[1], step.pose[2], step.pose[3], 0, 2e-3], V, rails=rails)
    assert rigid.force == pytest.approx(step.force, abs=1e-6 * FORCE)
    # and from a file
    assert pickle.loads(pickle.dumps(contact)).step(pose, V, lateral_force=0.2 * FORCE).pose == pytest.approx(
        step.pose, abs=1e-9
    )


@pytest.mark.parametrize("y", [6.5e-3, 7.2e-3, -7.8e-3])
@pytest.mark.parametrize("across", [5e6, 4e7])
def test_a_rail_on_soft_springs_gives_way_to_a_flange(y, across):
    """From nothing; the rails held where the step has put them are pressed by their springs' force."""
    stiffness = (across, 1e8)
    step = wheels("both", rail_stiffness=stiffness).step([0, y, NAN, NAN, 0, 0], V)
    side = "left" if y > 0.0 else "right"
    moved = step.rail_displacement
    assert abs(moved[side][0]) > 2e-4
    rails = {name: (*moved[name], 0.0) for name in ("left", "right")}
    held = wheels("both").step([0, y, NAN, NAN, 0, 0], V, rails=rails)
    for name in ("left", "right"):
        force = sum(p.force[1] for p in held.patches if p.side == name)
        assert force == pytest.approx(across * moved[name][0], abs=1e-5 * FORCE)
    assert held.pose == pytest.approx(step.pose, abs=1e-9)
    # a ride that comes there by and by stands at the same place
    ride = wheels("both", rail_stiffness=stiffness)
    for share in np.linspace(0.0, 1.0, 14):
        last = ride.step([0, share * y, NAN, NAN, 0, 0], V)
    assert last.pose == pytest.approx(step.pose, abs=1e-8)


def test_a_lateral_force_is_looked_for_from_a_y_that_was_given():
    """Three places on a small roller give the force: that next to the last step is taken."""
    scene = mtb.scenes.wheel_on_rail(lateral=0.0, force=FORCE, spacing=1e-3, roller_radius=0.3)
    own = scene.prepare(side="both", friction=mtb.Coulomb(0.3))
    yaw = 1.64e-3
    places = []
    for given in (True, False):
        ride = own.copy()
        near = ride.step([0, -4.9e-3, NAN, NAN, 0, yaw], V, axle_moment=0.0)
        if not given:
            ride.step([0, NAN, NAN, NAN, 0, yaw], V, lateral_force=near.force[1], axle_moment=0.0)
        wanted = near.force[1] + 600.0
        places.append(ride.step([0, NAN, NAN, NAN, 0, yaw], V, lateral_force=wanted, axle_moment=0.0).pose[1])
    assert places[0] == pytest.approx(places[1], abs=1e-8)
    assert abs(places[0] + 4.9e-3) < 2e-4


def test_springs_without_other_unknowns():
    """A given height, and one that is found: the wheel sinks by what its rail does."""
    stiff = np.inf
    soft = wheels(rail_stiffness=(stiff, 5e7)).step([0, 1e-3, NAN, 0, 0, 1e-3], V)
    hard = wheels().step([0, 1e-3, NAN, 0, 0, 1e-3], V)
    assert soft.force == pytest.approx(hard.force, abs=1e-6 * FORCE)
    assert soft.pose[2] - hard.pose[2] == pytest.approx(-FORCE / 5e7, rel=1e-6)
    given = wheels(rail_stiffness=(stiff, 5e7)).step(soft.pose, V)
    assert given.force == pytest.approx(soft.force, abs=1e-5 * FORCE)


@pytest.mark.parametrize("y", [1e-3, 6.3e-3])
def test_a_rail_that_moves_is_a_wheel_that_moves_back(y):
    moved = np.array([4e-4, -3e-5])
    here = wheels().step([0, y, -6e-5 if y < 2e-3 else 6.5e-4, 0, 0, 2e-3], V)
    there = wheels().step(here.pose + np.array([0, *moved, 0, 0, 0]), V, rails={"left": (*moved, 0.0)})
    assert there.force == pytest.approx(here.force, abs=1e-7 * FORCE)
    assert there.patches[0].position - here.patches[0].position == pytest.approx([0, *moved], abs=1e-9)


def test_a_turned_rail_with_a_turned_wheelset_turns_the_forces():
    """Rail and wheelset rolled together about the origin of the rail profile are the same contact."""
    angle = 0.02
    here = wheels().step([0, 1e-3, -6e-5, 0, 0, 0], (V, 0.03, 0.0, 0.0, V / 0.46, 0.0))
    patch = here.patches[0]
    turn = np.array([[1, 0, 0], [0, np.cos(angle), -np.sin(angle)], [0, np.sin(angle), np.cos(angle)]])
    point = wheels().reference_point
    origin = rail_origin()
    centre = point + here.pose[:3]
    shift = origin + turn @ (centre - origin) - point
    velocity = np.concatenate([turn @ six(here)[:3], turn @ six(here)[3:]])
    there = wheels().step([*shift, angle, 0, 0], velocity, rails={"left": (0, 0, angle)})
    assert there.force == pytest.approx(turn @ here.force, abs=1e-6 * FORCE)
    assert there.patches[0].contact_angle - patch.contact_angle == pytest.approx(angle, abs=1e-9)
    assert there.patches[0].creepage == pytest.approx(patch.creepage, abs=1e-12)


def rail_origin():
    """Origin of the left rail's profile in the track, from a contact: the rail is inclined by 1/40."""
    patch = wheels().step([0, 1e-3, -6e-5, 0, 0, 0], V).patches[0]
    own = np.array([patch.rail_position, float(mtb.Profile.standard("60E1").height(patch.rail_position))])
    lean = 1.0 / 40.0
    turned = np.array([[np.cos(lean), -np.sin(lean)], [np.sin(lean), np.cos(lean)]]) @ own
    return np.array([0.0, *(patch.position[1:] - turned)])


def test_motions_of_rail_and_wheel_are_relative():
    pose = [0, 1e-3, -6e-5, 0, 0, 2e-3]
    velocity = np.array([V, 0, 0, 0, V / 0.46, 0])
    shifted = velocity + np.array([0, 0.05, -0.02, 0, 0, 0])
    one = wheels().step(pose, shifted)
    rail = wheels().step(pose, velocity, rails={"left": (0, 0, 0, -0.05, 0.02, 0)})
    # the wheel's rates are in directions of the wheelset, which is yawed
    yaw = 2e-3
    own = np.array([[np.cos(yaw), np.sin(yaw), 0], [-np.sin(yaw), np.cos(yaw), 0], [0, 0, 1]]) @ [
        0,
        0.05,
        -0.02,
    ]
    wheel = wheels().step(pose, velocity, wheels={"left": (*np.zeros(6), *own, 0, 0, 0)})
    for other in (rail, wheel):
        assert other.force == pytest.approx(one.force, abs=1e-7 * FORCE)
        assert other.patches[0].creepage == pytest.approx(one.patches[0].creepage, abs=1e-13)


def test_a_wheel_beside_its_place_is_a_wheelset_there():
    """One wheel alone: yaw, roll and displacement of the wheel are those of an axle that has them."""
    angle = 3e-3
    point = wheels().reference_point
    hub = np.array([0, 0.75, point[2]])
    turn = np.array([[np.cos(angle), -np.sin(angle), 0], [np.sin(angle), np.cos(angle), 0], [0, 0, 1]])
    moved = np.array([1e-4, 5e-4, 0])
    low = np.array([0, 0, -6e-5])
    bent = wheels().step([*low, 0, 0, 0], (V, 0, 0, 0, V / 0.46, 0), wheels={"left": (*moved, 0, 0, angle)})
    shift = hub + moved + turn @ (point - hub) - point
    # the same velocity of the hub, and the same rotation
    spin = np.array([0, V / 0.46, 0])
    reference = np.array([V, 0, 0]) + np.cross(spin, shift)
    stiff = wheels().step([*(shift + low), 0, 0, angle], [*reference, *spin])
    assert bent.force == pytest.approx(stiff.force, abs=1e-6 * FORCE)
    assert bent.patches[0].creepage == pytest.approx(stiff.patches[0].creepage, abs=1e-9)


def test_a_wheel_on_a_bent_axle_turns_about_its_own():
    """However far it has rolled, it is a straight wheelset there that rolls on about its own axle."""
    x, y, z, roll, yaw = 2e-4, 5e-4, 3e-4, 1e-3, 2e-3
    omega = V / 0.46
    point = wheels().reference_point
    hub = np.array([0, 0.75, point[2]])
    about_x = np.array([[1, 0, 0], [0, np.cos(roll), -np.sin(roll)], [0, np.sin(roll), np.cos(roll)]])
    about_z = np.array([[np.cos(yaw), -np.sin(yaw), 0], [np.sin(yaw), np.cos(yaw), 0], [0, 0, 1]])
    turn = about_z @ about_x
    low = np.array([0, 0, -3.7e-4])
    shift = hub + [x, y, z] + turn @ (point - hub) - point
    axle = omega * turn[:, 1]
    velocity = np.array([V, 0, 0]) + np.cross(axle, turn @ (point - hub))
    straight = wheels().step([*(shift + low), roll, 0, yaw], [*velocity, *axle])
    rates = (-omega * z, 0, omega * x, *(axle - [0, omega, 0]))
    assert rates[3:] == pytest.approx((-omega * yaw, 0, omega * roll), abs=3e-6 * omega)
    for pitch in (0.0, 0.7, 40.0):
        bent = wheels().step(
            [*low, 0, pitch, 0], (V, 0, 0, 0, omega, 0), wheels={"left": (x, y, z, roll, 0, yaw, *rates)}
        )
        assert bent.force == pytest.approx(straight.force, abs=1e-6 * FORCE)
        assert bent.patches[0].creepage == pytest.approx(straight.patches[0].creepage, abs=1e-9)


@pytest.mark.parametrize("curvature", [1 / 300, -1 / 300])
def test_a_curve_is_longer_outside(curvature):
    pose = [0, 1e-3, -6e-5, 0, 0, 0]
    velocity = np.array([V, 0, 0, 0, V / 0.46, 0])
    straight = wheels("both").step(pose, velocity)
    curve = wheels("both").step(pose, velocity, curvature=curvature)
    for a, b in zip(straight.patches, curve.patches, strict=True):
        y = a.position[1]
        slip = [patch.creepage * patch.rolling_speed for patch in (a, b)]
        assert slip[1][0] - slip[0][0] == pytest.approx(-V * curvature * y, rel=1e-4)
        assert slip[1][2] - slip[0][2] == pytest.approx(V * curvature * np.cos(a.contact_angle), rel=1e-9)
        assert b.rolling_speed == pytest.approx(V * (1 - curvature * y) - 0.5 * slip[1][0], rel=1e-6)


def test_derivatives_follow_a_lateral_force():
    contact, pose = wheels("both"), [0, NAN, NAN, NAN, 0, 2e-3]
    step = contact.step(pose, V, lateral_force=9e3)
    by_yaw = np.asarray(step.derivative("pose", "pose"))[:, 5]
    around = [
        wheels("both").step([0, NAN, NAN, NAN, 0, 2e-3 + by], V, lateral_force=9e3, state=step.state).pose
        for by in (-2e-6, 2e-6)
    ]
    difference = (around[1] - around[0]) / 4e-6
    assert by_yaw == pytest.approx(difference, abs=2e-3 * np.abs(difference[:5]).max())
    assert np.asarray(step.derivative("force", "pose"))[1, 5] == pytest.approx(0.0, abs=1e-3)
    # by the force itself, of which y takes what the wheelset needs to carry it
    by_force = np.asarray(step.derivative("pose", "lateral_force"))
    around = [
        wheels("both").step(pose, V, lateral_force=9e3 + by, state=step.state).pose for by in (-5.0, 5.0)
    ]
    difference = (around[1] - around[0]) / 10.0
    assert by_force == pytest.approx(difference, abs=2e-3 * np.abs(difference).max())
    assert np.asarray(step.derivative("force", "lateral_force"))[1:] == pytest.approx([1.0, 0.0], abs=1e-6)
    with pytest.raises(ValueError, match="y was given"):
        wheels().step([0, 1e-3, NAN, 0, 0, 0], V).derivative("force", "lateral_force")


#: Numbers of a step that are derived, with the size of each kind.
DERIVED = ("force", "moment", "vertical_force", "pose", "velocity", "rail_displacement", "friction_power")


def numbers_of(step, of):
    value = getattr(step, of)
    return np.ravel(list(value.values()) if isinstance(value, dict) else value)


#: What each case is prepared with and given.
GIVEN: dict[str, tuple[dict[str, Any], dict[str, Any]]] = {
    "pushed and turned in a curve, on springs": (
        {"side": "left", "rail_stiffness": (2e7, 6e7), "rail_force": (1e3, -2e3)},
        {
            "pose": [0, NAN, NAN, 0, 0, 2e-3],
            "lateral_force": 9e3,
            "axle_moment": 500.0,
            "curvature": 2e-3,
            "rails": {"left": (1e-4, -1e-4, 1e-3, 1e-3, 0, 1e-3)},
            "wheels": {"left": (0, 1e-4, 0, 1e-3, 0, 1e-3, 0, 1e-3, 0, 0, 1e-3, 0)},
        },
    ),
    "braked beside its place": (
        {"side": "both", "rail_stiffness": (np.inf, 6e7)},
        {
            "pose": [0, -1.1e-3, NAN, NAN, 0, -2e-3],
            "longitudinal_force": 2e3,
            "rails": {"right": (1e-4, 0, 1e-3, 0, 1e-3, 0)},
        },
    ),
    "at a given height": (
        {"side": "left"},
        {
            # no station of the profiles passes another one within the differences
            "pose": [0, 1.03e-3, -6e-5, 0, 0, 1e-3],
            "velocity": (V, 0.01, 0, 0, 1.001 * V / 0.46, 0.02),
            "curvature": -1e-3,
            "wheels": {"left": (1e-4, 0, 1e-5, 0, 1e-4, 1e-3)},
        },
    ),
}


@pytest.mark.parametrize("case", list(GIVEN))
def test_derivatives_under_forces_are_differences(case):
    """By each number that such steps are given, in one direction an input: Richardson's extrapolation."""
    changes, given = GIVEN[case]
    side, springs = changes["side"], {k: v for k, v in changes.items() if k != "side"}
    given = {"velocity": V} | given
    exact = (1e-13, 1e-11, 1e-10)

    def solved(by, change, state=None):
        now, soft = dict(given), dict(springs)
        name, _, part = by.partition(".")
        if name in soft:
            soft[name] = tuple(np.add(soft[name], change))
        elif part:
            whole = np.zeros(change.size)
            known = np.ravel(now.get(name, {}).get(part, ()))
            whole[: known.size] = known
            now[name] = now.get(name, {}) | {part: tuple(whole + change)}
        else:
            now[name] = np.add(now.get(name, 0.0), change)
        core = made(side, 3e-3, **soft)._core.to_accuracy(*exact)
        return mtb.PreparedWheels(core).step(**now, state=state)

    step = solved("curvature", 0.0)
    derived = step._tangent()
    random = np.random.default_rng(5)
    widths = {"velocity": 1e-5, "curvature": 1e-6, "rail_stiffness": 50.0, "rail_force": 1.0, "pose": 1e-7}
    widths |= dict.fromkeys(("lateral_force", "longitudinal_force", "axle_moment"), 1.0)
    compared = set()
    for by, shape in derived.inputs.items():
        name = by.partition(".")[0]
        if name not in widths and name not in ("rails", "wheels"):
            continue
        if name in ("rail_stiffness", "rail_force") and name not in springs:
            continue
        direction = random.uniform(0.5, 1.0, shape) * random.choice([-1, 1], shape)
        if name == "pose":
            direction = np.where(np.isfinite(given["pose"]), direction, 0.0)
        width = widths.get(name, 5e-8)
        found = [solved(by, share * width * direction, step.state) for share in (-1.0, -0.5, 0.5, 1.0)]
        if any(
            not np.array_equal(a.status, b.status)
            for other in found
            for a, b in zip(other.patches, step.patches, strict=True)
        ):
            continue  # a point changed its state: derivatives are one-sided
        compared.add(by)
        for of in DERIVED:
            values = [numbers_of(other, of) for other in found]
            wide, near = (values[3] - values[0]) / (2 * width), (values[2] - values[1]) / width
            wanted = (4 * near - wide) / 3
            rows = np.reshape(step.derivative(of, by), (wanted.size, -1)) @ direction.ravel()
            # the equilibrium is met to 1e-10 of the force
            noise = 20 * exact[2] * np.abs(values[0]).max() / width
            accepted = 1e-6 * np.abs(wanted).max() + noise
            assert rows == pytest.approx(wanted, rel=1e-6, abs=accepted), (by, of)
    assert len(compared) >= len(derived.inputs) - 8, compared
    assert {"curvature", "velocity", *(k for k in given if k.endswith(("_force", "_moment")))} <= compared


def test_a_rail_on_springs_follows_its_forces():
    """Statics: the rail goes by the force over the stiffness, and the wheels carry what they carry."""
    contact = wheels("left", rail_stiffness=(2e7, 5e7), rail_force=(0.0, 0.0))
    step = contact.step([0, 1e-3, NAN, 0, 0, 0], V)
    by = np.asarray(step.derivative("rail_displacement", "rail_force"))[0]
    force = np.asarray(step.derivative("force", "rail_force"))
    # y outwards is to the left of the left rail
    assert by[:, 0] == pytest.approx((force[1:, 0] + [1.0, 0.0]) / [2e7, 5e7], rel=1e-6, abs=1e-15)
    assert by[:, 1] == pytest.approx((force[1:, 1] + [0.0, 1.0]) / [2e7, 5e7], rel=1e-6, abs=1e-15)
    assert step.derivative("vertical_force", "rail_stiffness") == pytest.approx(0.0, abs=1e-9)


def test_derivatives_by_what_was_not_given_are_refused():
    step = wheels().step([0, 1e-3, NAN, 0, 0, 0], V, axle_moment=0.0)
    for by, why in (
        ("lateral_force", "y was given, and not found for it"),
        ("longitudinal_force", "the rotation about the axle was not found for it"),
        ("rail_stiffness", "the rails have no springs"),
        ("rail_force", "the rails have no springs"),
        ("rails.right", "rails.left"),
    ):
        with pytest.raises(ValueError, match=why):
            step.derivative("force", by)
    # free rolling: the moment stays what it is, and the rotation follows
    assert step.derivative("velocity", "axle_moment")[4] != 0.0


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"pose": [0, NAN, NAN, 0, 0, 0]}, "lateral force, which is missing"),
        ({"pose": [0, 0, NAN, 0, 0, 0], "lateral_force": 1e3}, "y and z must be NaN"),
        ({"lateral_force": np.inf}, "lateral_force"),
        ({"longitudinal_force": 0.0, "axle_moment": 0.0}, "one of them"),
        ({"rails": {"right": (0, 0, 0)}}, "rails is"),
        ({"rails": {"left": (0, 0)}}, r"rails\['left'\] has shape"),
        ({"wheels": {"left": (0, 0, 0)}}, r"wheels\['left'\] has shape"),
        ({"wheels": {"left": (1.0, 0, 0, 0, 0, 0)}}, "wheel deviation is 1"),
        ({"curvature": 1.0}, "curvature is 1"),
        ({"velocity": 0.0, "axle_moment": 0.0}, "velocity along x is 0"),
    ],
)
def test_what_is_no_load_is_named(given, message):
    with pytest.raises(ValueError, match=message):
        wheels().step(**{"velocity": V, **given})


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"rail_stiffness": (1e8,)}, "rail_stiffness is"),
        ({"rail_stiffness": (1e8, -1.0)}, "rail_stiffness is"),
        ({"rail_force": (0, 0)}, "rail_stiffness is missing"),
    ],
)
def test_what_is_no_spring_is_named(given, message):
    with pytest.raises(ValueError, match=message):
        mtb.scenes.wheel_on_rail(lateral=0.0, force=FORCE).prepare(**given)


@lru_cache
def about(dz, side="left", roller=None, dy=0.0):
    """Wheels whose reference point is so far above the middle of the axle and beside it."""
    scene = mtb.scenes.wheel_on_rail(lateral=0.0, force=FORCE, spacing=1.5e-3, roller_radius=roller)
    middle = scene.prepare(side=side, friction=mtb.Coulomb(0.3)).reference_point
    point = np.add(middle, [0.0, dy, dz])
    found = scene.prepare(side=side, friction=mtb.Coulomb(0.3), reference_point=point)
    return mtb.PreparedWheels(found._core.to_accuracy(1e-12, 1e-10, 1e-10))


@pytest.mark.parametrize("roller", [None, 0.3])
@pytest.mark.parametrize("dz", [-0.3, -0.09, 0.09, 0.5])
def test_a_motion_is_the_same_about_any_point(dz, roller):
    """Velocity, pose and moment of a rigid body go over to another point, in steady and transient steps."""
    middle, beside = (about(z, "both", roller).copy() for z in (0.0, dz))
    arm, spin = np.array([0.0, 0.0, dz]), np.array([0.01, 1.001 * V / 0.46, 0.02])
    for k, turn in enumerate(([0.0, 0.3, 0.0], [0.0, 0.303, 2e-3])):
        roll, pitch, yaw = turn
        c, s = np.cos([roll, pitch, yaw]), np.sin([roll, pitch, yaw])
        about_y = np.array([[c[1], 0, s[1]], [0, 1, 0], [-s[1], 0, c[1]]])
        about_z = np.array([[c[2], -s[2], 0], [s[2], c[2], 0], [0, 0, 1]])
        turned = about_z @ about_y @ arm
        velocity = np.array([V, 0.03, 0.0]) + np.cross(spin, turned)
        place = np.array([0.0, 1e-3, -6e-5]) + turned - arm
        if roller is not None:
            # that of the roller's surface; the axle stays
            velocity[0] = V
        more = {"dt": 3e-3 / V, "transient": True} if k else {}
        here = middle.step([0, 1e-3, -6e-5, *turn], [V, 0.03, 0, *spin], **more)
        there = beside.step([*place, *turn], [*velocity, *spin], **more)
        assert there.force == pytest.approx(here.force, abs=1e-8 * FORCE)
        moved = there.moment + np.cross(there.reference_point - here.reference_point, here.force)
        assert moved == pytest.approx(here.moment, abs=1e-8 * FORCE)
        for a, b in zip(here.patches, there.patches, strict=True):
            assert b.creepage == pytest.approx(a.creepage, abs=1e-9)
            assert b.rolling_speed == pytest.approx(a.rolling_speed, rel=1e-9)


@pytest.mark.parametrize("roller", [None, 0.3, 0.1])
@pytest.mark.parametrize("y", [-4e-3, 0.0, 3e-3])
@pytest.mark.parametrize("dz", [-0.3, -0.12, 0.09, 0.5])
def test_the_rotation_is_found_about_any_point(dz, y, roller):
    pose = [0, y, NAN, 0, 0, 0]
    here = about(0.0, roller=roller).copy().step(pose, V, axle_moment=300.0)
    spin = here.velocity[3:]
    velocity = here.velocity[:3] + np.cross(spin, [0.0, 0.0, dz])
    if roller is not None:
        velocity[0] = V
    # only the rotation about the axle is found
    there = about(dz, roller=roller).copy().step(pose, [*velocity, 0, 0, 0], axle_moment=300.0)
    assert there.velocity[4] == pytest.approx(spin[1], rel=1e-8)
    assert there.force == pytest.approx(here.force, abs=1e-6 * FORCE)


@pytest.mark.parametrize("roller", [None, 0.3])
@pytest.mark.parametrize("transient", [False, True])
def test_derivatives_about_a_point_beside_the_axle_are_differences(transient, roller):
    contact = about(0.2, roller=roller, dy=0.1)
    pose, velocity = (
        np.array([0, 1e-3, -6e-5, 1e-4, 0.2, 2e-3]),
        np.array([24.0, 0.02, 0.0, 0.01, 36.4, 0.03]),
    )
    if roller is not None:
        velocity[[0, 4]] = V, 1.001 * V / 0.46
    state = contact.copy().step(pose.tolist(), velocity.tolist()).state
    on = np.add(pose, [0.0, 1e-4, 1e-6, 0.0, 2e-3, 1e-4])

    def at(pose, velocity):
        more = {"curvature": 2e-3 if roller is None else 0.0}
        more |= {"dt": 1.33e-3 / V, "transient": True} if transient else {}
        return contact.copy().step(pose.tolist(), velocity.tolist(), state=state, **more)

    step = at(on, velocity)
    for k in range(6):
        for by in ("pose", "velocity"):
            small = (2e-8 if k < 3 else 1e-7) if by == "pose" else 1e-5
            change = small * np.eye(6)[k]
            ends = [
                at(on + sign * change, velocity) if by == "pose" else at(on, velocity + sign * change)
                for sign in (-1.0, 1.0)
            ]
            found = step.derivative("force", by)[:, k]
            truth = (ends[1].force - ends[0].force) / (2.0 * small)
            noise = 1e-9 * FORCE / small
            assert found == pytest.approx(truth, abs=2e-4 * np.abs(truth).max() + noise), (by, k)


@pytest.mark.parametrize("yaw", [0.0, 2e-3])
def test_wheels_of_revolution_do_not_feel_how_far_they_have_rolled(yaw):
    """The pitch turns them about their axle, whatever the roll that they are found at."""
    pose = [0.0, 6e-3, NAN, NAN, 0.0, yaw]
    here = wheels("both").step(pose, V)
    assert abs(here.pose[3]) > 4e-4
    for pitch in (0.5, 0.5 * np.pi, 2.5, 20.0):
        there = wheels("both").step([*pose[:4], pitch, yaw], V)
        assert there.force == pytest.approx(here.force, abs=1e-6 * FORCE)
        assert there.pose[:4] == pytest.approx(here.pose[:4], abs=1e-11)
    given = wheels("both").step([*here.pose[:4], 1.0, yaw], V)
    assert given.force == pytest.approx(here.force, abs=1e-6 * FORCE)


@pytest.mark.parametrize("pitch", [0.7, 2.0])
def test_derivatives_of_a_wheelset_that_has_rolled_and_rolls_over(pitch):
    """With a pitch that is no small angle and beside the axle, where all turns of the pose count."""
    pose = np.array([0.0, 2e-3, -8e-5, 1e-4, pitch, 2e-3])
    both = about(0.2, "both")
    velocity = [V, 0.0, 0.0, 0.0, V / 0.46, 0.0]
    arm = 0.2 * np.array([np.sin(pitch), 0.0, np.cos(pitch) - 1.0])
    pose[:3] += arm
    step = both.copy().step(pose, velocity)
    assert np.abs(step.force[2]) > 0.1 * FORCE
    slopes = step.derivative("force", "pose")
    for k in range(6):
        h = 1e-8

        def at(shift, k=k):
            there = pose.copy()
            there[k] += shift
            return both.copy().step(there, velocity).force

        difference = (8.0 * (at(h) - at(-h)) - (at(2 * h) - at(-2 * h))) / (12.0 * h)
        assert slopes[:, k] == pytest.approx(difference, rel=2e-5, abs=2e-6 * np.abs(slopes).max())


@pytest.mark.parametrize(("scale", "y"), [(0.2, 6.3e-3), (0.3, 6.6e-3), (2.0, 6.3e-3)])
def test_a_rig_of_other_size_stands_on_its_flange_as_the_wheelset_does(scale, y):
    """All lengths times a number, forces times its square: the same stresses."""

    def force(size):
        wheel, rail = mtb.Profile.standard("S1002"), mtb.Profile.standard("60E1")
        of_wheel, of_rail = np.linspace(-69e-3, 59e-3, 4001), np.linspace(-35.9e-3, 35.9e-3, 4001)
        scene = mtb.scenes.wheel_on_rail(
            mtb.Profile.from_points(size * of_wheel, size * wheel.height(of_wheel)),
            mtb.Profile.from_points(size * of_rail, size * rail.height(of_rail)),
            lateral=0.0,
            force=FORCE * size**2,
            spacing=1e-3 * size,
            wheel_radius=0.46 * size,
            gauge=1.435 * size,
            gauge_depth=14e-3 * size,
            flange_back=1.36 * size,
            tape_circle=70e-3 * size,
        )
        step = scene.prepare(side="both").step([0.0, y * size, NAN, NAN, 0.0, 4e-3], V * size)
        return step.force / size**2

    assert force(scale) == pytest.approx(force(1.0), rel=2e-3)


@lru_cache
def worn(name, depth, at, width):
    """A profile with a hollow."""
    profile = mtb.Profile.standard(name)
    y = np.linspace(*profile.range, 1500)
    return mtb.Profile.from_points(y, profile.height(y) + depth * np.exp(-(((y - at) / width) ** 2)))


@lru_cache
def hollow(rail="60E1", **changes):
    """Both wheels, the left one hollow, with a ground gauge corner on one rail or both."""
    ground = worn("60E1", -5e-4, -1e-2, 1.2e-2)
    scene = mtb.scenes.wheel_on_rail(
        worn("S1002", 1e-3, 5e-3, 2e-2),
        ground if rail == "ground" else rail,
        lateral=0.0,
        force=FORCE,
        spacing=1e-3,
    )
    return scene.prepare(side="both", friction=mtb.Coulomb(0.3), right_rail=ground, **changes)


SOFT = {"rail_stiffness": (2e7, 5e7), "rail_force": (100.0, -2000.0)}


@pytest.mark.parametrize("force", [3000.0, 3500.0, 4000.0, 4500.0])
def test_a_narrow_contact_breaks_the_curve_at_many_places_and_forces_between_are_found(force):
    """Cells as wide as half of a contact; the truth is the step with the position given."""
    contact = hollow(right_wheel="S1002", right_wheel_radius=0.4585, **SOFT)
    step = contact.copy().step([0, NAN, NAN, 0, 0.02, -1e-3], V, lateral_force=force, axle_moment=10.0)
    assert step.force[1] == pytest.approx(force, abs=1e-3 * 2 * FORCE)
    assert ("lateral force jumps" in step.report.status) == (abs(step.force[1] - force) > 1e-6 * FORCE)
    given = contact.copy().step([0, step.pose[1], NAN, 0, 0.02, -1e-3], V, axle_moment=10.0, state=step.state)
    assert given.force == pytest.approx(step.force, abs=1e-6 * FORCE)


def rests_on_springs(step, stiffness, given=None):
    """Springs hold what wheels press on the rails, and the same motion, all given, has the same forces."""
    for side, moved in step.rail_displacement.items():
        force = np.sum([patch.force[1:] for patch in step.patches if patch.side == side], axis=0)
        assert moved * np.array(stiffness) == pytest.approx(force, abs=1e-5 * FORCE)
    rails = {side: [*moved, 0.0] for side, moved in step.rail_displacement.items()}
    rigid = given or hollow("ground", right_wheel_radius=0.45926).copy()
    given = rigid.step(step.pose, step.velocity, rails=rails)
    assert given.force == pytest.approx(step.force, abs=1e-5 * FORCE)
    assert given.moment == pytest.approx(step.moment, abs=1e-5 * FORCE)


def test_the_curve_is_followed_over_a_jump_to_another_contact():
    """A rail on a spring moves by 0.1 mm where the contact goes over to its gauge corner."""
    stiffness = (7.7e6, 3e7)
    contact = hollow("ground", rail_stiffness=stiffness, right_wheel_radius=0.45926)
    step = contact.copy().step([0, NAN, NAN, NAN, 0.02, -5e-4], V, lateral_force=-4950.0, axle_moment=-4.4)
    assert step.force[1] == pytest.approx(-4950.0, abs=1e-3 * 2 * FORCE)
    rests_on_springs(step, stiffness)


@pytest.mark.parametrize(
    ("stiffness", "mu", "first", "then"),
    [
        ((6.57e6, 3.04e7), 0.15, (-37545.0, -3.4e-3), (8612.0, 0.9e-3)),
        ((2.7e7, 9.37e8), 0.43, (-48790.0, -0.3e-3), (-31729.0, 7.5e-3)),
    ],
)
def test_a_force_is_found_after_a_flange_has_moved_its_rail(stiffness, mu, first, then):
    """What fresh wheels find is found after a step that leaves a rail millimetres aside too."""
    scene = mtb.scenes.wheel_on_rail(lateral=0.0, force=FORCE, spacing=1.5e-3)
    fresh = scene.prepare(side="both", friction=mtb.Coulomb(mu), rail_stiffness=stiffness)
    ridden, rigid = fresh.copy(), scene.prepare(side="both", friction=mtb.Coulomb(mu))
    for contact, (force, yaw) in ((ridden, first), (ridden, then), (fresh, then)):
        step = contact.step([0, NAN, NAN, NAN, 0, yaw], V, lateral_force=force)
        assert step.force[1] == pytest.approx(force, abs=1e-8 * 2 * FORCE)
        rests_on_springs(step, stiffness, rigid)


@pytest.mark.parametrize("y", [6e-3])
def test_a_rotation_is_found_on_soft_rails_from_a_fresh_start(y):
    stiffness = (7.7e6, 3e7)
    contact = hollow("ground", rail_stiffness=stiffness, right_wheel_radius=0.45926)
    step = contact.copy().step([0, y, NAN, NAN, 0.02, -5e-4], V, axle_moment=-4.4)
    assert abs(step.balance_error) < 1e-8
    rests_on_springs(step, stiffness)
