# SPDX-License-Identifier: MIT OR Apache-2.0
"""Wheels on rollers: Hertz, exchanged bodies, material points of bodies that turn, meshes, mechanics."""

from __future__ import annotations

import pickle
from functools import lru_cache
from typing import Any

import numpy as np
import pytest

import mtb_rs as mtb

pytestmark = [
    pytest.mark.filterwarnings("ignore:the peak pressure is"),
    pytest.mark.filterwarnings("ignore:roller_radius is"),
    pytest.mark.filterwarnings("ignore:on the flange"),
]

R_WHEEL, V, NAN = 0.46, 20.0, np.nan


def round_head(radius: float) -> mtb.Profile:
    angle = np.linspace(-0.12, 0.12, 12001)
    y, z = radius * np.sin(angle), radius * (np.cos(angle) - 1.0)
    # a flank, for the gauge to be measured at
    return mtb.Profile.from_points(
        np.concatenate([[y[0] - 2e-3], y]), np.concatenate([[z[0] - 30e-3], z]), "linear"
    )


def round_wheel(radius: float) -> mtb.Profile:
    """A tread that is an arc, up at both sides."""
    y = radius * np.sin(np.linspace(-0.12, 0.12, 2001))
    return mtb.Profile.from_points(y, radius - np.sqrt(radius**2 - y**2))


def cylinder() -> mtb.Profile:
    return mtb.Profile.from_points([-0.05, 0.05], [0.0, 0.0], "linear")


def scene(**changes: Any) -> mtb.WheelScene:
    given: dict[str, Any] = dict(lateral=0.0, force=60e3, spacing=1e-3, wheel_radius=R_WHEEL)
    return mtb.scenes.wheel_on_rail(**given | changes)


def on_top(head: mtb.Profile, **changes: Any) -> mtb.WheelScene:
    """The tape circle stands above the crown of a round head."""
    crown = scene(wheel=cylinder(), rail=head, rail_inclination=0.0).geometry.placement.position[1]
    return scene(rail=head, rail_inclination=0.0, flange_back=1.36, tape_circle=crown - 0.68, **changes)


@lru_cache
def pair(
    roller: float | None = 0.35, side: str = "both", friction: float = 0.3, spacing: float = 1e-3
) -> Any:
    return scene(roller_radius=roller, spacing=spacing).prepare(side=side, friction=mtb.Coulomb(friction))


@pytest.mark.parametrize("roller", [0.46, 0.09])
def test_scene_and_step_are_hertz(roller: float) -> None:
    """Crossed radii of curvature: 1/R = 1/R_wheel + 1/R_roller along the track, that of the head across."""
    here = scene(
        wheel=cylinder(), rail=round_head(0.3), rail_inclination=0.0, roller_radius=roller, spacing=3e-4
    )
    closed = mtb.hertz(
        60e3, radii=(1.0 / (1.0 / R_WHEEL + 1.0 / roller), 0.3), lower=mtb.steel, upper=mtb.steel
    )
    solved = here.solve()
    assert solved.pressure.max() == pytest.approx(closed.peak_pressure, rel=2e-3)
    assert solved.approach == pytest.approx(closed.approach, rel=2e-3)
    step = here.prepare(friction=mtb.Coulomb(0.0)).step(velocity=V)
    (patch,) = step.patches
    assert patch.pressure.max() == pytest.approx(closed.peak_pressure, rel=2e-3)
    assert -step.pose[2] == pytest.approx(closed.approach, rel=2e-3)
    assert patch.normal_force == pytest.approx(60e3, rel=1e-8)


def test_exchanged_bodies_bear_the_opposite() -> None:
    """The wheel as the roller and the roller as the wheel, turned by half a turn about the track."""
    (a, across), (b, head) = (0.46, 0.5), (0.3, 0.25)
    ahead, off = 1.002, 3e-3

    def found(wheel: float, roller: float, arcs: tuple[float, float], speed: float, spin: float) -> Any:
        here = on_top(
            round_head(arcs[1]),
            wheel=round_wheel(arcs[0]),
            wheel_radius=wheel,
            roller_radius=roller,
            spacing=5e-4,
        )
        step = here.prepare().step((0.0, off, NAN, 0.0, 0.0, 0.0), (speed, 0.0, 0.0, 0.0, spin, 0.0))
        (patch,) = step.patches
        return step, patch

    # the rim of the one runs as fast as the surface of the other did
    one, first = found(a, b, (across, head), V, ahead * V / a)
    other, second = found(b, a, (head, across), ahead * V, V / b)
    peak = first.pressure.max()
    assert other.pose[2] == pytest.approx(one.pose[2], abs=1e-9)
    # the head is a polygon, whose sides turn by as much
    assert first.contact_angle == pytest.approx(second.contact_angle, abs=2e-5)
    assert abs(first.contact_angle) > 3e-3
    xi, _, phi = first.creepage
    assert second.creepage[0] == pytest.approx(-xi, rel=2e-3)
    assert second.creepage[2] == pytest.approx(phi, rel=5e-3)
    assert second.rolling_speed == pytest.approx(first.rolling_speed, rel=1e-6)
    # forces on the lower body, seen from the other side
    assert other.force[0] == pytest.approx(-one.force[0], rel=2e-3)
    assert second.pressure.max() == pytest.approx(peak, rel=1e-3)
    assert np.abs(one.force[0]) > 3e3


def test_a_wheel_on_a_roller_like_it_does_not_slip() -> None:
    here = on_top(round_head(0.3), wheel=round_wheel(0.3), roller_radius=R_WHEEL, spacing=5e-4)
    step = here.prepare().step((0.0, 0.0, NAN, 0.0, 0.0, 0.0), V)
    (patch,) = step.patches
    # but for the sides of a polygon
    assert abs(step.force[0]) < 1e-4 * 0.3 * 60e3
    assert patch.position[0] == pytest.approx(0.0, abs=1e-12)
    assert np.abs(patch.creepage[:2]).max() < 1e-6


def test_a_large_roller_is_a_rail() -> None:
    pose = (0.0, 5e-3, NAN, NAN, 0.0, 0.01)

    def loads(roller: float | None) -> Any:
        step = pair(roller).copy().step(pose, V)
        return np.concatenate([step.force / 1e3, step.moment / 1e3, *(p.position for p in step.patches)])

    rail = loads(None)
    near, far = (loads(radius) - rail for radius in (20.0, 200.0))
    # of the first order in the curvature
    size = np.abs(far)
    moved = size > 1e-2 * size.max()
    assert moved.sum() >= 4
    np.testing.assert_allclose(near[moved] / far[moved], 10.0, rtol=0.05)
    assert size.max() < 0.02


def turned(axis: Any, angle: float) -> Any:
    x, y, z = np.asarray(axis) / np.linalg.norm(axis)
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    return np.eye(3) + np.sin(angle) * cross + (1.0 - np.cos(angle)) * cross @ cross


@pytest.mark.parametrize("which", ["tread", "flange", "moved"])
def test_creepages_are_those_of_material_points(which: str) -> None:
    """Both bodies turn a little, as rigid ones, and their material points move apart."""
    roller = 0.35
    contact = pair(roller, "left").copy()
    pose = {
        "tread": (0.0, 1e-3, NAN, 1e-3, 0.0, 8e-3),
        "flange": (4e-3, 6.3e-3, NAN, -1e-3, 0.0, 0.02),
        "moved": (-3e-3, 3e-3, NAN, 0.0, 0.0, -6e-3),
    }[which]
    motion = np.array([V, 0.03, 0.01, 0.02, 1.001 * V / R_WHEEL, 0.05])
    rail = np.array([1e-3, -2e-4, 2e-3, 0.02, -0.01, 0.04] if which == "moved" else np.zeros(6))
    step = contact.step(pose, motion.tolist(), rails={"left": rail})
    place = scene(roller_radius=roller).geometry.placement
    # origin of the rail profile: where the rail was put
    cos, sin = np.cos(1 / 40), np.sin(1 / 40)
    on_rail = place.rail_position, float(mtb.Profile.standard("60E1").height(place.rail_position))
    origin = place.position - [0.0, cos * on_rail[0] - sin * on_rail[1], sin * on_rail[0] + cos * on_rail[1]]
    tilt = turned((1.0, 0.0, 0.0), rail[2])
    about = origin + np.array([0.0, *rail[:2]])
    middle = about + tilt @ (np.array([0.0, origin[1], -roller]) - origin)
    axis = tilt[:, 1]
    h = 1e-7

    def of_wheel(at: Any) -> Any:
        spin = motion[3:]
        ends = [
            step.reference_point
            + t * np.array([0.0, *motion[1:3]])
            + turned(spin, t * np.linalg.norm(spin)) @ (at - step.reference_point)
            for t in (-h, h)
        ]
        return (ends[1] - ends[0]) / (2.0 * h)

    def of_roller(at: Any) -> Any:
        # the roller turns, and its bearings move with the rail
        def moved(t: float) -> Any:
            own = middle + turned(axis, -V / roller * t) @ (at - middle)
            return (
                about + t * np.array([0.0, *rail[3:5]]) + turned((1.0, 0.0, 0.0), rail[5] * t) @ (own - about)
            )

        return (moved(h) - moved(-h)) / (2.0 * h)

    for patch in step.patches:
        frame = patch.rotation
        lift = patch.approach * frame[:, 2]
        at = patch.position - lift
        # the frame lies on the roller, and its normal meets the axis of it
        out = patch.position - middle
        assert np.dot(np.cross(axis, out), frame[:, 2]) == pytest.approx(0.0, abs=1e-9)
        assert np.dot(frame[:, 0], axis) == pytest.approx(0.0, abs=1e-12)

        def slip(x: float, y: float, at: Any = at, frame: Any = frame, lift: Any = lift) -> Any:
            place = at + frame @ [x, y, 0.0]
            # each on its own undeformed surface
            return frame.T @ (of_wheel(place) - of_roller(place + lift))

        here, side, front = slip(0.0, 0.0), slip(0.0, 1e-3), slip(1e-3, 0.0)
        passing = -(frame.T @ of_roller(at + lift))[0] - 0.5 * here[0]
        assert patch.rolling_speed == pytest.approx(passing, rel=1e-6)
        xi, eta, phi = patch.creepage * passing
        assert [xi, eta] == pytest.approx(here[:2], abs=1e-6 * V)
        assert phi == pytest.approx((front[1] - here[1]) / 1e-3, abs=1e-5 * V)
        assert phi == pytest.approx(-(side[0] - here[0]) / 1e-3, abs=1e-5 * V)
        # the contact lies where the axle is ahead or yawed to
        assert patch.position[0] != 0.0


def test_friction_takes_what_both_drives_give() -> None:
    """Of a wheelset and of the two rollers that turn under it."""
    roller = 0.35
    contact = pair(roller).copy()
    spin = 1.002 * V / R_WHEEL
    # about the axle, so that no wheel is lifted
    pose = contact.step((0.0, 2e-3, NAN, NAN, 0.0, 5e-3), V).pose
    axle = turned((0.0, 0.0, 1.0), pose[5]) @ turned((1.0, 0.0, 0.0), pose[3]) @ [0.0, 1.0, 0.0]
    step = contact.step(pose, (V, 0.0, 0.0, *(spin * axle)))
    motion = np.array(step.velocity)
    middle = np.array([0.0, 0.0, -roller])
    tangential = normal = 0.0
    for patch in step.patches:
        # each body is loaded on its own undeformed surface
        force, on_roller = patch.load().reshape(3, -1).T, patch.points.reshape(3, -1).T
        up = patch.rotation[:, 2]
        on_wheel = on_roller - patch.approach * up
        wheel = np.array([0.0, *motion[1:3]]) + np.cross(motion[3:], on_wheel - step.reference_point)
        over = wheel - np.cross([0.0, -V / roller, 0.0], on_roller - middle)
        pressing = np.outer(force @ up, up)
        tangential += ((force - pressing) * over).sum()
        normal += (pressing * over).sum()
    assert step.friction_power == pytest.approx(tangential, rel=1e-9)
    # where the bodies touch they do not part, but the middle of the pressure is that of cells
    assert abs(normal) < 3e-3 * tangential
    assert tangential > 1e3


def test_a_yawed_wheelset_wants_to_turn_off_its_rollers() -> None:
    """Cylinders without friction: each wheel stands behind or ahead of the top, and is pushed further."""
    roller, yaw = 0.3, 4e-3
    here = scene(wheel=cylinder(), rail=round_head(0.3), rail_inclination=0.0, roller_radius=roller)
    wheels = here.prepare(side="both", friction=mtb.Coulomb(0.0))
    step = wheels.step((0.0, 0.0, NAN, NAN, 0.0, yaw), V)
    base = step.patches[0].position[1]
    # the moment on the rollers is against that on the wheelset
    closed = -2.0 * 60e3 * base**2 * yaw / (R_WHEEL + roller)
    assert step.moment[2] == pytest.approx(closed, rel=1e-3)
    # and its derivative is the stiffness
    still = wheels.step((0.0, 0.0, NAN, NAN, 0.0, 0.0), V)
    assert still.derivative("moment", "pose")[2, 5] == pytest.approx(closed / yaw, rel=1e-3)
    # a rail has none
    on_rail = scene(wheel=cylinder(), rail=round_head(0.3), rail_inclination=0.0)
    rail = on_rail.prepare(side="both", friction=mtb.Coulomb(0.0)).step((0.0, 0.0, NAN, NAN, 0.0, yaw), V)
    assert abs(rail.moment[2]) < 1e-3 * abs(closed)
    # an axle ahead of that of the rollers is pushed along
    ahead = wheels.step((2e-3, 0.0, NAN, NAN, 0.0, 0.0), V)
    assert ahead.force[0] == pytest.approx(-120e3 * 2e-3 / (R_WHEEL + roller), rel=1e-3)


def test_a_mesh_of_the_roller_has_the_gap() -> None:
    """A revolved polygon as a body of its own, found vertically, and solved as a field."""
    trimesh = pytest.importorskip("trimesh")
    roller = 0.3
    here = scene(roller_radius=roller, spacing=8e-4)
    place = here.geometry.placement
    rail, wheel = mtb.Profile.standard("60E1"), mtb.Profile.standard("S1002")
    cos, sin = np.cos(1 / 40), np.sin(1 / 40)
    own = np.linspace(place.rail_position - 0.015, place.rail_position + 0.015, 201)
    z = rail.height(own)
    at = place.rail_position, float(rail.height(place.rail_position))
    across = place.position[1] + cos * (own - at[0]) - sin * (z - at[1])
    up = place.position[2] + sin * (own - at[0]) + cos * (z - at[1])
    angle = np.linspace(-0.04, 0.04, 81)

    def revolved(across: Any, radius: Any, centre: float, flip: bool) -> Any:
        n, m = angle.size, across.size
        grid = np.stack(
            [
                np.outer(np.sin(angle), radius),
                np.tile(across, (n, 1)),
                centre + (-1.0 if flip else 1.0) * np.outer(np.cos(angle), radius),
            ],
            axis=-1,
        )
        i, j = np.meshgrid(np.arange(n - 1), np.arange(m - 1), indexing="ij")
        k = (i * m + j).ravel()
        faces = np.concatenate([np.stack([k, k + m, k + 1], 1), np.stack([k + 1, k + m, k + m + 1], 1)])
        # outwards: the roller up, the wheel down
        return trimesh.Trimesh(grid.reshape(-1, 3), faces[:, ::-1] if flip else faces, process=False)

    lower = revolved(across, roller + up, -roller, False)
    on_wheel = np.linspace(place.wheel_position - 0.015, place.wheel_position + 0.015, 201)
    tape = 0.75
    upper = revolved(
        tape + on_wheel, R_WHEEL - wheel.height(on_wheel), R_WHEEL + place.undeformed_height, True
    )
    # in the frame of the contact plane
    shape = np.eye(4)
    shape[:3, :3], shape[:3, 3] = place.rotation.T, -place.rotation.T @ place.position
    for mesh in (lower, upper):
        mesh.apply_transform(shape)
    x, y = (line[[0, -1]] + [-4e-4, 4e-4] for line in (place.x, place.y))
    found = mtb.surface_gap(mtb.Rigid(lower).surface, mtb.Rigid(upper).surface, x=x, y=y, spacing=8e-4)
    gap = found.grid.gap.reshape(place.gap.shape)
    gap = gap - gap.min()
    # chords of 0.1 and 0.15 mm on these radii
    assert np.abs(gap - place.gap).max() < 0.02 * place.gap.max()
    exact = mtb.solve_normal(place.gap, 8e-4, lower=mtb.steel, upper=mtb.steel, force=60e3)
    meshed = mtb.solve_normal(gap, 8e-4, lower=mtb.steel, upper=mtb.steel, force=60e3)
    assert meshed.pressure.max() == pytest.approx(exact.pressure.max(), rel=0.02)


def test_pictured_bodies_have_their_radii() -> None:
    here = scene(roller_radius=0.2)
    place = here.geometry.placement
    lower, upper = (
        place.rotation @ body.vertices + place.position[:, None] for body in here.geometry.surfaces()
    )
    for bodies, middle, at in (
        (lower, -0.2, 0.2 + place.position[2]),
        (upper, R_WHEEL + place.undeformed_height, R_WHEEL + place.undeformed_height - place.position[2]),
    ):
        out = np.hypot(bodies[0], bodies[2] - middle)
        # the ring through the contact, where the bodies nearly touch, and the one inside of it
        ring = out[(np.abs(bodies[1] - place.position[1]) < 1e-9) & (out > at - 1e-3)]
        assert ring.size > 20
        assert ring == pytest.approx(at, abs=5e-6)


def test_an_eccentric_wheel_on_a_roller_is_a_shifted_circle() -> None:
    off, roller = 0.8e-3, 0.3
    angle = np.linspace(-np.pi, np.pi, 181)
    about = angle - 0.3
    radius = off * np.cos(about) + np.sqrt(R_WHEEL**2 - (off * np.sin(about)) ** 2)
    uneven = mtb.WheelSlices.out_of_round(cylinder(), angle, radius - R_WHEEL)
    eccentric, round_ = (
        scene(
            wheel=wheel, rail=round_head(0.3), rail_inclination=0.0, roller_radius=roller, spacing=5e-4
        ).prepare()
        for wheel in (uneven, cylinder())
    )
    pitch, spin = 0.4, V / R_WHEEL
    ahead, down = off * np.sin(0.3 - pitch), off * np.cos(0.3 - pitch)
    found = eccentric.step((0.0, 0.0, NAN, 0.0, pitch, 0.0), (V, 0, 0, 0, spin, 0))
    # the middle of the circle moves as the wheel turns about its axle
    moves = {"left": (0, 0, 0, 0, 0, 0, -spin * down, 0, -spin * ahead, 0, 0, 0)}
    exact = round_.step((ahead, 0.0, NAN, 0.0, 0.0, 0.0), (V, 0, 0, 0, spin, 0), wheels=moves)
    assert found.pose[2] == pytest.approx(exact.pose[2] + down, abs=1e-8)
    (patch,), (reference,) = found.patches, exact.patches
    assert patch.position[0] == pytest.approx(reference.position[0], abs=2e-6)
    assert patch.pressure.max() == pytest.approx(reference.pressure.max(), rel=2e-3)
    slips = [np.array(p.creepage) * p.rolling_speed for p in (patch, reference)]
    assert slips[0][:2] == pytest.approx(slips[1][:2], abs=1e-5 * V)
    # the planes are as exact as the sides of the polygon
    assert slips[0][2] == pytest.approx(slips[1][2], abs=2e-5 * V * (1.0 / R_WHEEL + 1.0 / roller))


def test_transient_steps_go_on_where_steady_ones_were_and_end_there() -> None:
    pose = np.array((0.0, 2e-3, NAN, NAN, 0.0, 5e-3))
    contact = pair(0.2, spacing=1.5e-3).copy()
    steady = contact.step(pose, V)
    for duration in (1e-6, 1e-7):
        on = contact.copy()
        on.step(pose, V)
        on = on.step(pose, V, dt=duration, transient=True)
        # no jump, but for what the step itself does
        np.testing.assert_allclose(on.force, steady.force, atol=1e7 * duration)
    # from rest, over more than a length of a patch
    fresh = pair(0.2, spacing=1.5e-3).copy()
    for _ in range(12):
        step = fresh.step(pose, V, dt=1.5e-3 / V, transient=True)
    np.testing.assert_allclose(step.force, steady.force, atol=5e-3 * 0.3 * 120e3)


def test_rotation_lateral_force_and_springs_are_found_on_rollers() -> None:
    free = pair().copy().step((0.0, NAN, NAN, NAN, 0.0, 2e-3), V, lateral_force=3e3, axle_moment=0.0)
    assert free.force[1] == pytest.approx(3e3, abs=2e-3)
    assert free.vertical_force["left"] == pytest.approx(60e3, rel=1e-8)
    springs = scene(roller_radius=0.35).prepare(side="both", rail_stiffness=(2e7, 6e7))
    sprung = springs.step((0.0, 1e-3, NAN, NAN, 0.0, 1e-3), V)
    for side in ("left", "right"):
        force = sum(p.force for p in sprung.patches if p.side == side)
        np.testing.assert_allclose(sprung.rail_displacement[side], force[1:] / [2e7, 6e7], atol=1e-12)


def test_prepared_files_keep_the_roller(tmp_path: Any) -> None:
    contact = pair().copy()
    pose = (1e-3, 2e-3, NAN, NAN, 0.0, 5e-3)
    step = contact.step(pose, V)
    contact.save(tmp_path / "wheels.mtb")
    for again in (mtb.PreparedWheels.load(tmp_path / "wheels.mtb"), pickle.loads(pickle.dumps(pair()))):
        np.testing.assert_allclose(again.step(pose, V).force, step.force, rtol=1e-9)


def test_what_has_no_sense_on_rollers_is_named() -> None:
    with pytest.raises(ValueError, match=r"curvature is 0\.001 / m: wheels on rollers stay"):
        pair().copy().step(velocity=V, curvature=1e-3)
    with pytest.raises(ValueError, match=r"the axle stands 2\.5 m ahead of that of the roller"):
        pair().copy().step((2.5, 0.0, NAN, 0.0, 0.0, 0.0), V)
    dip = mtb.RailSlices.uneven("60E1", [0.0, 1.0], [0.0, 1e-3])
    with pytest.raises(ValueError, match=r"roller_radius is 0.3 and rail is .*: a roller has one profile"):
        scene(rail=dip, roller_radius=0.3)
    along = mtb.friction.RailFriction([-0.04, 0.02], [[0.2, 0.3], [0.25, 0.3]], x=[-1.0, 1.0])
    with pytest.raises(ValueError, match=r"friction varies along the track: on a roller"):
        scene(roller_radius=0.3).prepare(friction=along)
    with pytest.raises(ValueError, match=r"roller_radius is -0\.3"):
        scene(roller_radius=-0.3)
    with pytest.warns(UserWarning, match=r"roller_radius is 300 m: 0\.02 to 3 m is usual"):
        mtb.wheel_on_rail_gap(roller_radius=300, spacing=5e-3)


#: Rollers of CONTACT, revision 2707, as its own output prints them (testbank/examples_conformal/test-rollers2
#: in its public repository, cases 6, 7, 10, 12): lengths in mm, forces in N, MPa. Its wheel is a right one,
#: seen here in a mirror as a left one, and its creepages are those of the roller over the wheel.
CONTACT: dict[str, dict[str, Any]] = {
    "cylinder on an ellipsoid": dict(
        rail="round", z=-0.16, turns=0.25, force=(0.1411, 0.0, 97190.0), normal=97190.0, peak=2901.0,
        speed=100.0, creepage=(2.5e-8, 0.0, 0.0),
    ),
    "yawed by 0.3 rad": dict(
        rail="round", z=-0.16, yaw=0.3, turns=0.2388340, force=(-2.862, 0.0, 98820.0), normal=98820.0,
        peak=2899.0, speed=95.53, creepage=(-4.870e-7, 0.0, 0.0),
    ),
    "ellipsoid on a cone": dict(
        rail="cone", z=1.87, turns=0.24381, force=(-18.05, -5588.0, 98910.0), normal=98050.0, peak=2898.0,
        speed=98.50, creepage=(3.364e-5, 0.0, 2.004),
    ),
    "rolled by 0.27 rad": dict(
        rail="cone", z=56.60956, roll=-0.266667, turns=0.2451499, force=(1.806, -19460.0, 95490.0),
        normal=97460.0, peak=2894.0, speed=99.83, creepage=(1.595e-7, 0.0, -0.01262),
    ),
}  # fmt: skip


@pytest.mark.filterwarnings("ignore:the flange has climbed", "ignore:.*it looks upside down")
@pytest.mark.parametrize("which", CONTACT)
def test_rollers_are_those_of_contact(which: str) -> None:
    given = CONTACT[which]
    yaw, roll = given.get("yaw", 0.0), given.get("roll", 0.0)
    arc = 0.1 * np.sin(np.linspace(-0.5, 0.5, 4001))
    across = 0.1 - np.sqrt(0.01 - arc**2)
    # a flank of 30 mm within 2 mm, for the gauge to be measured at 10 mm
    if given["rail"] == "round":
        y, z = arc, -across
        face = -np.sqrt(0.1**2 - 0.09**2)
        wheel, middle = cylinder(), 0.2
    else:
        y = np.linspace(-0.06, 0.04, 41)
        z = -np.tan(0.2) * y
        face = y[0] - 2e-3 / 3.0
        wheel, middle = mtb.Profile.from_points(arc, across), 0.2
    rail = mtb.Profile.from_points(
        np.concatenate([[y[0] - 2e-3], y]), np.concatenate([[z[0] - 30e-3], z]), "linear"
    )
    material = mtb.Material.from_shear_modulus(82e9, 0.28)
    # 400 mm at the origin of the profile, which lies below its top
    top, radius = float(z.max()), 0.4 / 3.0
    here = scene(
        wheel=wheel, rail=rail, wheel_radius=radius, roller_radius=0.4 + top, gauge=2.0 * (middle + face),
        gauge_depth=10e-3, rail_inclination=0.0, flange_back=0.2, tape_circle=middle - 0.1, force=97e3,
        spacing=2e-4, upper=material, lower=material,
    )  # fmt: skip
    # its yaw is about the vertical through the contact
    wheels = here.prepare()
    zero = wheels.reference_point[2]
    if yaw:
        wheels = here.prepare(reference_point=(0.0, middle, zero))
    height = radius + 1e-3 * given["z"] - top - zero
    axle = turned((0, 0, 1), yaw) @ turned((1, 0, 0), roll) @ [0.0, 1.0, 0.0]
    speed = given["turns"] * (0.4 + top)
    along = 0.1 * np.sin(yaw)
    step = wheels.step((0.0, 0.0, height, roll, 0.0, yaw), (speed, along, 0.0, *(0.75 * axle)))
    (patch,) = step.patches
    # its numbers have four digits, and its cells lie otherwise
    assert patch.normal_force == pytest.approx(given["normal"], rel=5e-4)
    assert step.force == pytest.approx(np.multiply(given["force"], [1, 1, -1]), rel=5e-4, abs=3.0)
    assert 1e-6 * patch.pressure.max() == pytest.approx(given["peak"], rel=6e-3 if yaw else 1e-3)
    assert 1e3 * patch.rolling_speed == pytest.approx(given["speed"], rel=1e-4)
    assert patch.creepage[:2] == pytest.approx(given["creepage"][:2], abs=3e-7)
    # the polygon of the crown is level to the eighth of a milliradian
    assert patch.creepage[2] == pytest.approx(given["creepage"][2], abs=2e-3, rel=1e-3)
