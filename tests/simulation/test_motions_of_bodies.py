# SPDX-License-Identifier: MIT OR Apache-2.0
"""Motions of prepared bodies, given or free: their names, and what they hold."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

import mtb_rs as mtb
from mtb_rs.bodies.mesh import block_mesh

nan = float("nan")
#: Above the rail head, where a shoe is hung.
HUNG = (0.0, 0.0, 28.2e-3)
NAMES = [f"{pole} {motion}" for pole in ("left", "right") for motion in ("z", "roll", "pitch")]
MILLIMETRE = 1e-3
STEEL = mtb.Material(2.1e11, 0.3)

pytestmark = [pytest.mark.coarse, pytest.mark.filterwarnings("ignore:.*deform")]


def shoe(spacing: Any, **given: Any) -> mtb.Scene:
    return mtb.scenes.pole_shoe_on_rail(
        spacing=spacing, **{"friction": 0.3, "magnetic_pressure": 3e6} | given
    )


def test_motions_have_the_names_of_the_body_and_not_of_its_cells() -> None:
    """On few wide cells of a curved face the mean displacements look like no motion of the body."""
    for mm in (7, 10, 15, (12, 6), (6, 12)):
        spacing = (mm[0] * MILLIMETRE, mm[1] * MILLIMETRE) if isinstance(mm, tuple) else mm * MILLIMETRE
        assert shoe(spacing).prepare("elastic-upper").motions == NAMES, mm
    assert shoe(12e-3).prepare("elastic-both").motions == NAMES
    assert shoe(12e-3).prepare("half-space").motions == ["left z", "right z"]
    body = mtb.ElasticBody(
        block_mesh(np.linspace(-0.02, 0.02, 5), np.linspace(-0.01, 0.01, 3), 0.02),
        STEEL,
        supports=[mtb.Support("top", x=0, y=0)],
    )
    for spacing in (5e-3, 1e-2):
        own = mtb.Scene(body, STEEL, spacing=spacing, magnetic_pressure=1e6).prepare()
        assert [name.split()[-1] for name in own.motions] == ["z", "roll", "pitch"]


@pytest.mark.parametrize(
    ("model", "spacing"),
    [
        ("elastic-upper", 6e-3),
        ("elastic-upper", 9e-3),
        ("elastic-upper", (6e-3, 12e-3)),
        ("elastic-both", 12e-3),
    ],
)
def test_a_motion_that_is_given_is_the_one_that_is_held(model: Any, spacing: Any) -> None:
    scene = shoe(spacing)
    contact = scene.prepare(model, reference_point=HUNG)
    solved, step = scene.solve(model), contact.step(velocity=20.0)
    np.testing.assert_allclose(step.force, solved.force, rtol=1e-9, atol=1e-6)
    # both poles come down as far as they do by themselves
    height = float(step.state.motion[0])
    np.testing.assert_allclose(solved.approach, -height, rtol=1e-9)
    given = contact.copy().step(pose=(nan, nan, height, nan, nan, nan), velocity=20.0)
    np.testing.assert_allclose(given.force, step.force, rtol=1e-7, atol=1e-5)
    pressed = contact.copy().step(pose=(nan, nan, height - 1e-5, nan, nan, nan), velocity=20.0)
    assert pressed.force[2] < 1.2 * step.force[2]
    # a free height carries the pull, level or not
    level = contact.copy().step(pose=(nan, nan, nan, 0.0, 0.0, nan), velocity=20.0)
    assert level.force[2] == pytest.approx(step.force[2], rel=1e-2)


@pytest.mark.parametrize("spacing", [6e-3, (6e-3, 12e-3)])
def test_a_given_height_is_an_approach(spacing: Any) -> None:
    scene, down = shoe(spacing), 2e-5
    given = scene.prepare("half-space").step(pose=(nan, nan, -down, nan, nan, nan))
    direct = scene.with_(magnetic_pressure=None, approach=down).solve("half-space")
    np.testing.assert_allclose(given.force, direct.force, rtol=1e-9, atol=1e-6)


def held_block(spacing: float, **given: Any) -> mtb.Scene:
    """As wide as long, held along x and y by its top, so that z, roll and pitch are found from balance."""
    return mtb.scenes.block_on_plane(friction=0.0, spacing=spacing, supports="driven-top", **given)


def test_what_holds_a_given_motion_is_as_symmetric_as_the_body() -> None:
    step = held_block(20e-3).prepare("elastic-upper").step(pose=(nan, nan, -2e-6, 0.0, 0.0, nan))
    side = round(step.pressure.size**0.5)
    pressure = step.pressure.reshape(side, side)
    for image in (pressure[::-1], pressure[:, ::-1], pressure.T):
        np.testing.assert_allclose(image, pressure, rtol=1e-6)
    # inertia holds it, within the body: the corners carry no more of what is added than of the pull
    free = held_block(20e-3).prepare("elastic-upper").step()
    np.testing.assert_allclose(
        step.pressure / step.force[2],
        free.pressure / free.force[2],
        atol=2e-2 * np.abs(free.pressure).max() / abs(free.force[2]),
    )


def test_a_given_pitch_is_that_of_its_moment() -> None:
    """A given moment is spread over the body as inertia is, and so is that of a given pitch."""
    scene = held_block(20e-3)
    given = scene.prepare("elastic-upper").step(pose=(nan, nan, nan, nan, 5e-6, nan))
    moved = replace(scene, moments=(0.0, float(given.moment[1]))).prepare("elastic-upper").step()
    # a body that turns about its top swings forwards and backwards as well, and its inertia with it
    np.testing.assert_allclose(given.pressure, moved.pressure, atol=1e-3 * moved.pressure.max())
    np.testing.assert_allclose(given.moment, moved.moment, rtol=1e-9, atol=1e-9)


def test_a_height_is_that_of_the_mean_of_a_bar() -> None:
    """A bar that inertia pushes onto a rigid plane comes down by F L / (3 E A) in the mean."""
    even = mtb.Material(STEEL.young_modulus, 0.0)
    contact = held_block(25e-3, height=0.15, upper=even, lower=mtb.Rigid()).prepare("elastic-upper")
    low, high = (contact.step(pose=(nan, nan, z, nan, nan, nan)).force[2] for z in (-2e-6, -1e-6))
    assert (high - low) / 1e-6 == pytest.approx(3.0 * STEEL.young_modulus * 0.1**2 / 0.15, rel=1e-3)


#: Sides of a block of one's own [m].
LENGTH, HEIGHT = 0.04, 0.03


def own_block(*supports: mtb.Support) -> mtb.Scene:
    x = np.linspace(-0.5, 0.5, 5) * LENGTH
    body = mtb.ElasticBody(block_mesh(x, x, HEIGHT), STEEL, supports=list(supports))
    return mtb.Scene(body, STEEL, spacing=LENGTH / 4, magnetic_pressure=1e6, friction=0.2)


@pytest.mark.parametrize(
    "pose",
    [None, (nan, nan, -3e-7, nan, nan, nan), (nan, nan, -3e-7, 1e-6, 2e-6, nan)],
    ids=["free", "height", "all"],
)
def test_a_body_that_its_supports_move_along_presses_as_before(pose: Any) -> None:
    """On a plane nothing depends on where the body slides, and being moved along is no turn."""
    still, moved = (own_block(mtb.Support("top", x=x, y=0)) for x in (0.0, 1e-5))
    here, there = (scene.prepare().step(pose=pose) for scene in (still, moved))
    np.testing.assert_allclose(there.pressure, here.pressure, atol=1e-9 * here.pressure.max())
    if pose is None:
        np.testing.assert_allclose(there.state.motion, here.state.motion, atol=1e-14)
        inside = [next(iter(scene.solve().states().values())) for scene in (still, moved)]
        way = inside[1].displacement - inside[0].displacement
        np.testing.assert_allclose(way, np.array([[1e-5], [0.0], [0.0]]) + 0.0 * way, atol=1e-14)


def test_a_turn_about_an_edge_is_told_as_its_angle() -> None:
    contact = own_block(mtb.Support("top", x=0, y=0), mtb.Support("rear", z=0)).prepare()
    free = contact.step()
    assert contact.motions == ["contact pitch"]
    (angle,) = free.state.motion
    # about the upper edge of the rear, on which both supports hold it
    turned = (-HEIGHT * angle, 0.0, -0.5 * LENGTH * angle, 0.0, angle, 0.0)
    again = contact.copy().step(pose=turned)
    np.testing.assert_allclose(again.pressure, free.pressure, atol=1e-9 * free.pressure.max())


def test_poles_that_are_mirror_images_roll_against_each_other() -> None:
    """Their amplitudes have the signs that those of poles have which are no images, but for a hair."""
    alike, other = (
        shoe(12e-3, magnetic_pressure=(3e6, right)).prepare("elastic-upper") for right in (3e6, 2.9999e6)
    )
    turned = (shoe(12e-3, yaw=1e-9).prepare("elastic-upper")).step().state.motion
    found = alike.step().state.motion.reshape(2, 3)
    signs = np.array([1.0, -1.0, 1.0])
    size = np.abs(found).max(axis=0)
    np.testing.assert_allclose(found[1], signs * found[0], atol=1e-9 * size.max())
    for near in (other.step().state.motion, turned):
        np.testing.assert_allclose(near.reshape(2, 3), found, atol=1e-2 * size.max())
    solved = shoe(12e-3).solve("elastic-upper")
    np.testing.assert_allclose(np.reshape(solved.motion, (2, 3)), found, atol=1e-9 * size.max())


def test_the_stiffness_against_a_given_motion_is_that_of_the_body_and_not_of_its_elements() -> None:
    moments = [
        shoe(mm * MILLIMETRE, friction=0.0)
        .prepare("elastic-upper")
        .step(pose=(nan, nan, nan, nan, 2e-6, nan))
        .moment[1]
        for mm in (12, 8)
    ]
    assert moments[0] == pytest.approx(moments[1], rel=1e-2)


def test_a_negative_pressure_is_named() -> None:
    contact = shoe(12e-3).prepare("elastic-upper")
    with pytest.raises(mtb.ResultantError, match=r"magnetic_pressure is -1e\+06 Pa, and a negative"):
        contact.step(velocity=20.0, magnetic_pressure=-1e6)
