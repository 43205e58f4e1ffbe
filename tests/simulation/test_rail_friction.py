# SPDX-License-Identifier: MIT OR Apache-2.0
"""Wheels in steps over friction that varies over the rail: general solver, closed forms, mirrors, files."""

import pickle
from functools import lru_cache

import numpy as np
import pytest

import mtb_rs as mtb

V, RADIUS, HEAD = 20.0, 0.46, 0.3
#: gauge corner and running band unlike each other, dry rail before x = 0.5 mm, wet behind
ACROSS, ALONG = np.array([-20e-3, -2e-3, 5e-3, 20e-3]), np.array([-4e-3, 0.5e-3, 1.1e-3])
PATCHY = np.array([[0.1, 0.45, 0.2, 0.35], [0.15, 0.5, 0.25, 0.3], [0.1, 0.2, 0.05, 0.1]])
FREE = float("nan")


@lru_cache
def pair(rail=None):
    """A wheel on a rail, upright; a conical one on a round head, where a name asks for it."""
    if rail is None:
        return mtb.scenes.wheel_on_rail(lateral=0.0, force=60e3, spacing=5e-4)
    angle = np.linspace(-0.12, 0.12, 4001)
    y, z = HEAD * np.sin(angle), HEAD * (np.cos(angle) - 1.0)
    return mtb.scenes.wheel_on_rail(
        wheel=mtb.Profile.from_points([-0.05, 0.05], [-2.5e-3, 2.5e-3], "linear"),
        # a flank, for the gauge to be measured at
        rail=mtb.Profile.from_points(np.r_[y[0] - 2e-3, y], np.r_[z[0] - 30e-3, z], "linear"),
        rail_inclination=0.0,
        wheel_radius=RADIUS,
        force=60e3,
        spacing=5e-4,
    )


def patchy(x=ALONG):
    return mtb.RailFriction(ACROSS, PATCHY, x)


def on_round_head(patch):
    """y of the rail profile (ny, nx) along the normal of each cell of a round head, in closed form."""
    slope = patch.contact_angle
    normal, along = np.array([-np.sin(slope), np.cos(slope)]), np.array([np.cos(slope), np.sin(slope)])
    # from the middle of the head's circle; a right rail is a left one in a mirror
    sign = 1.0 if patch.side == "left" else -1.0
    at = np.array([patch.rail_position, np.sqrt(HEAD**2 - patch.rail_position**2)])
    y = (at[:, None] + sign * along[:, None] * patch.y)[:, :, None] + 0.0 * patch.x
    out = np.einsum("i,ijk->jk", normal, y)
    distance = -out + np.sqrt(out**2 - (y**2).sum(axis=0) + HEAD**2)
    return y[0] + normal[0] * distance


def bilinear(x, y):
    """The coefficient of the map at x in the track and y on the rail."""
    rows = np.array([np.interp(y, ACROSS, row) for row in PATCHY])
    share = np.array([np.interp(x, ALONG, unit) for unit in np.eye(len(ALONG))])
    return (share * rows).sum(axis=0)


@pytest.mark.parametrize("side", ["left", "right"])
@pytest.mark.parametrize("sense", [1.0, -1.0])
def test_a_step_solves_what_the_general_solver_does_under_the_same_field(side, sense):
    wheels = pair("round").prepare(side=side, friction=patchy())
    mirror = 1.0 if side == "left" else -1.0
    pose = [1.5e-3, mirror * 1e-3, FREE, 0.0, 0.0, mirror * 1e-3]
    velocity = sense * np.array([V, mirror * 0.03, 0.0, 0.0, 0.9983 * V / RADIUS, mirror * 0.01])
    (patch,) = wheels.step(pose, velocity).patches
    mu = bilinear(patch.points[0], on_round_head(patch))
    assert np.ptp(mu[patch.pressure > 0.0]) > 0.2
    spacing = (patch.x[1] - patch.x[0], patch.y[1] - patch.y[0])
    field = mtb.PressureField(patch.pressure, spacing, mtb.steel, mtb.steel, (patch.x[0], patch.y[0]))
    motion = mtb.Rolling(
        creepage=tuple(patch.creepage),
        angle=0.0 if sense > 0.0 else np.pi,
        velocity=abs(patch.rolling_speed),
    )
    truth = mtb.solve_tangential(field, motion, mtb.Coulomb(mu))
    assert {1, 2} <= set(np.unique(truth.status))
    size = np.abs(truth.traction).max()
    np.testing.assert_allclose(patch.traction, truth.traction[:2], rtol=0, atol=1e-5 * size)
    assert (np.hypot(*patch.traction) <= mu * patch.pressure * (1.0 + 1e-4) + 1.0).all()


def test_a_map_of_one_coefficient_is_that_coefficient():
    law = mtb.Coulomb(0.25)
    one, two = (
        pair().prepare(side="both", friction=friction)
        for friction in (law, mtb.RailFriction([0.0, 1e-3], np.full((2, 2), 0.25), x=[0.0, 1.0]))
    )
    motion = [V, 0.05, 0.0, 0.0, V / RADIUS, 0.1]
    pose = [0.5, 2e-3, FREE, FREE, 0.0, 1e-3]
    np.testing.assert_allclose(two.step(pose, motion).force, one.step(pose, motion).force, rtol=1e-12)


@pytest.mark.parametrize("sense", [1.0, -1.0])
def test_a_wheel_runs_from_dry_rail_on_to_wet(sense):
    """Along the rail friction falls at x = 1 m: locked, each cell carries what friction there lets it."""
    dry, wet, end = 0.4, 0.1, 1.0
    wheels = pair().prepare(friction=mtb.RailFriction([0.0], [[dry], [wet]], x=[end, end + 1e-9]))
    locked = sense * np.array([V, 0.0, 0.0, 0.0, 0.0, 0.0])
    rolling = sense * np.array([V, 0.0, 0.0, 0.0, 1.004 * V / RADIUS, 0.0])
    reference = {mu: pair().prepare(friction=mtb.Coulomb(mu)).step(velocity=rolling) for mu in (dry, wet)}
    drawn = []
    for x in end + np.linspace(-12.1e-3, 12.1e-3, 9):
        pose = [x, 0.0, FREE, 0.0, 0.0, 0.0]
        (patch,) = wheels.step(pose, locked).patches
        mu = np.where(patch.points[0] <= end, dry, wet)
        carried = (mu * patch.pressure).sum() * patch.area
        assert np.hypot(*patch.traction.sum(axis=(1, 2))) * patch.area == pytest.approx(carried, rel=1e-6)
        drawn.append(np.abs(wheels.step(pose, rolling).force[0]))
    assert (np.diff(drawn) <= 1e-6 * drawn[0]).all()
    assert drawn[0] == pytest.approx(abs(reference[dry].force[0]), rel=1e-6)
    assert drawn[-1] == pytest.approx(abs(reference[wet].force[0]), rel=1e-6)
    assert 1.2 * drawn[-1] < drawn[4] < drawn[0] / 1.2


@pytest.mark.parametrize(("before", "behind", "most"), [(0.4, 0.1, 0.09), (0.1, 0.4, 0.17)])
def test_steady_rolling_over_a_step_is_as_far_from_transient_as_the_docs_say(before, behind, most):
    wheels = pair().prepare(friction=mtb.RailFriction([0.0], [[before], [behind]], x=[0.0, 1e-9]))
    motion = [V, 0.0, 0.0, 0.0, 1.001 * V / RADIUS, 0.0]
    steady, passing, state = [], [], None
    for x in np.arange(-8.8e-3, 24e-3, 5e-4):
        (patch,) = wheels.step([x, 0.0, FREE, 0.0, 0.0, 0.0], motion).patches
        field = mtb.PressureField(
            patch.pressure, (5e-4, 5e-4), mtb.steel, mtb.steel, (patch.x[0], patch.y[0])
        )
        law = mtb.Coulomb(np.where(patch.points[0] <= 0.0, before, behind))
        roll = mtb.Rolling(creepage=tuple(patch.creepage), velocity=V, transient=state is not None)
        solved = mtb.solve_tangential(field, roll, law, state=state, tolerance=1e-5)
        state = solved.state
        steady.append(patch.traction[0].sum())
        passing.append(solved.traction[0].sum())
    off = np.abs(np.subtract(passing, steady)) / np.abs(steady).max()
    assert off.max() == pytest.approx(most, abs=0.01)
    # before the step, and a patch's length behind it
    assert off[:3].max() < 1e-3
    assert off[-1] < 0.015


def test_both_rails_have_it_in_a_mirror():
    wheels = pair().prepare(side="both", friction=patchy())
    flip = np.array([1.0, -1.0, 1.0, -1.0, 1.0, -1.0])
    pose = np.array([1e-3, 2e-3, -1.5e-4, 2e-5, 0.0, 4e-3])
    velocity = np.array([V, 0.05, 0.0, 0.0, V / RADIUS, 0.2])
    here, there = wheels.step(pose, velocity), wheels.copy().step(flip * pose, flip * velocity)
    np.testing.assert_allclose(there.force, flip[:3] * here.force, atol=1e-6 * abs(here.force[2]))
    np.testing.assert_allclose(there.moment, -flip[:3] * here.moment, atol=1e-6 * abs(here.force[2]))
    for patch in here.patches:
        (other,) = [p for p in there.patches if p.side != patch.side]
        np.testing.assert_allclose(other.rail_position, patch.rail_position, atol=1e-9)
        np.testing.assert_allclose(
            other.traction[0], patch.traction[0][::-1], atol=1e-4 * np.abs(patch.traction).max()
        )


def test_it_stays_on_its_place_across_the_rail():
    """A greased gauge corner: only a wheelset that has run out to it feels it."""
    greased = mtb.RailFriction([-14e-3, -13e-3], [0.02, 0.4])
    wheels, dry = pair().prepare(friction=greased), pair().prepare(friction=mtb.Coulomb(0.4))
    motion = [V, 0.0, 0.0, 0.0, 1.02 * V / RADIUS, 0.0]
    for y, is_greased in ((0.0, False), (6.2e-3, True)):
        pose = [0.0, y, 0.0, 0.0, 0.0, 0.0]
        pose[2] = dry.step([0.0, y, FREE, 0.0, 0.0, 0.0], motion).pose[2]
        (here,), (there,) = wheels.step(pose, motion).patches, dry.step(pose, motion).patches
        assert (here.rail_position < -14e-3) == is_greased
        share = np.abs(here.traction).sum() / np.abs(there.traction).sum()
        assert share < 0.5 if is_greased else share == pytest.approx(1.0, rel=1e-6)


def test_it_comes_back_from_a_file_and_keeps_its_own_numbers(tmp_path):
    position, coefficient = ACROSS.copy(), PATCHY.copy()
    friction = mtb.RailFriction(position, coefficient, ALONG)
    given = pair().prepare(side="both", friction=friction)
    position += 1.0
    coefficient *= 0.0
    assert friction == patchy()
    with pytest.raises(ValueError, match="read-only"):
        friction.coefficient[0, 0] = 1.0
    given.save(tmp_path / "wheelset.mtbw")
    motion, pose = [V, 0.05, 0.0, 0.0, V / RADIUS, 0.1], [1e-3, 1e-3, FREE, 0.0, 0.0, 1e-3]
    here = given.step(pose, motion)
    for other in (
        mtb.PreparedWheels.load(tmp_path / "wheelset.mtbw"),
        pickle.loads(pickle.dumps(given)).copy(),
        pair().prepare(side="both", friction=pickle.loads(pickle.dumps(friction))),
    ):
        np.testing.assert_array_equal(other.step(pose, motion).force, here.force)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (([0.0, 0.0], [0.1, 0.1]), "rail_position is .*: places .* that rise strictly"),
        (([], []), "rail_position is"),
        (([[0.0]], [0.1]), "rail_position is .*: places"),
        (([0.0, FREE], [0.1, 0.1]), r"rail_position\[1\] is nan"),
        (([0.0, 1.0], [0.1]), r"coefficient has shape \(1,\): \(2,\) is needed, one for each rail_position"),
        (
            ([0.0, 1.0], [0.1, 0.1], [0.0]),
            r"coefficient has shape \(2,\): \(1, 2\) is needed, a row for each x",
        ),
        (([0.0], [[0.1], [0.2]], [1.0, 0.0]), "x is .*: places .* that rise strictly"),
        (([0.0], [-0.1]), "coefficient is -0.1: numbers of at least 0"),
        ((None, [0.1]), "rail_position is None"),
        (([0.0], lambda y: y), "coefficient is .*: real numbers are needed"),
    ],
)
def test_what_is_no_map_is_named(arguments, message):
    with pytest.raises(ValueError, match=message):
        mtb.RailFriction(*arguments)


def test_it_is_for_wheels_in_steps():
    field = mtb.PressureField(np.ones((3, 3)), (1e-3, 1e-3), mtb.steel, mtb.steel)
    with pytest.raises(ValueError, match=r"friction is RailFriction.*: a friction law"):
        mtb.solve_tangential(field, mtb.Rolling(), patchy())
