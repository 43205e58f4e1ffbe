# SPDX-License-Identifier: MIT OR Apache-2.0
"""Steps of wheels whose patches follow the rail, against an own geometry and a contact on inclined rows."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from scipy.optimize import brentq

import mtb_rs as mtb

BODY = mtb.Material.from_shear_modulus(82e9, 0.28)
#: Radius of a rail's corner and of the wheel, the speed and the rotation of the axle.
CORNER, WHEEL, SPEED, ROTATION = 10e-3, 0.46, 20.0, 20.0 / 0.46 * 1.001
CELL, FRICTION = 0.4e-3, 0.3
SINK = 0.05e-3


def arc(radius: float, half: float) -> mtb.Profile:
    angle = np.radians(np.linspace(-half, half, 2401))
    return mtb.Profile.from_points(radius * np.sin(angle), radius * np.cos(angle) - radius)


def grooved(groove: float, **given: Any) -> mtb.WheelScene:
    """A wheel with a groove on a rail that is a cylinder along the track."""
    edge = np.sqrt(CORNER**2 - (CORNER - 8e-3) ** 2)
    return mtb.scenes.wheel_on_rail(
        arc(groove, 77.0),
        arc(CORNER, 80.0),
        wheel_radius=WHEEL,
        rail_inclination=0.0,
        lateral=0.0,
        force=60e3,
        spacing=CELL,
        friction=FRICTION,
        upper=BODY,
        lower=BODY,
        gauge=1.5 - 2.0 * edge,
        gauge_depth=8e-3,
        **given,
    )


def torus(groove: float, x: np.ndarray, angle: np.ndarray, aside: float = 0.0) -> np.ndarray:
    """Distance (ny, nx) of the groove of a wheel, lowered and moved aside, along normals of the corner."""
    gap = np.empty((angle.size, x.size))
    for j, turn in enumerate(angle):
        out = np.array([-np.sin(turn), np.cos(turn)])
        foot = CORNER * out - [aside, CORNER - SINK]
        for i, ahead in enumerate(x):

            def inside(h: float, foot=foot, out=out, ahead=ahead) -> float:
                y, z = foot + h * out
                section = WHEEL - (np.sqrt(groove**2 - y**2) - groove)
                return section - float(np.hypot(ahead, WHEEL - z))

            gap[j, i] = brentq(inside, -2e-3, 2e-3, xtol=1e-15)
    return gap


@pytest.mark.parametrize(("groove", "aside"), [(10.2e-3, 0.0), (10.1e-3, 0.0), (10.2e-3, 8e-6)])
def test_a_groove_on_a_corner_is_a_contact_on_inclined_rows(groove: float, aside: float) -> None:
    wheels = grooved(groove).prepare(conformal=True)
    step = wheels.step([0.0, aside, -SINK, 0.0, 0.0, 0.0], [SPEED, 0.0, 0.0, 0.0, ROTATION, 0.0])
    (patch,) = step.patches
    assert patch.row_position is not None
    middle = 0.5 * 1.360 + 70e-3
    angle = -np.arcsin((patch.row_position[0] - middle) / CORNER)
    assert np.ptp(angle[patch.pressure.max(axis=1) > 0.0]) > 0.8
    gap = torus(groove, patch.x, angle, aside)
    normal = mtb.solve_normal(
        gap - gap.min(),
        CELL,
        lower=BODY,
        upper=BODY,
        approach=-gap.min(),
        inclination=angle,
        edge="sharp",
        tolerance=1e-10,
    )
    peak = normal.pressure.max()
    assert patch.approach == pytest.approx(-gap.min(), rel=1e-5)
    # profiles are splines, and the rail is placed by its gauge: within some nanometres
    assert np.abs(patch.pressure - normal.pressure).max() < 5e-4 * peak
    assert patch.normal_force == pytest.approx(normal.normal_force, rel=3e-6)
    # the velocity of the wheel's own undeformed surface, at the middle of each row
    out = np.stack([-np.sin(angle), np.cos(angle)])
    depth = np.array([np.interp(0.0, patch.x, row) for row in gap])
    place = CORNER * out - [[0.0], [CORNER]] + depth * out
    along = SPEED + ROTATION * (place[1] - (WHEEL - SINK))
    # pressures and tractions act on the surface between the two circles
    between = 0.5 * (angle - np.arcsin((place[0] - aside) / groove))
    assert patch.inclination is not None
    assert np.abs(patch.inclination - between).max() < 2e-6
    angle = between
    out = np.stack([-np.sin(angle), np.cos(angle)])
    rolling = patch.rolling_speed
    assert rolling == pytest.approx(SPEED - 0.5 * np.interp(0.0, patch.y, along), rel=1e-6)
    ahead = patch.x + CELL / 6.0
    slip = np.stack([np.repeat(along[:, None], ahead.size, axis=1), ROTATION * np.outer(out[0], ahead)])
    rolled = mtb.solve_tangential(
        normal, mtb.Rolling(rigid_slip=slip / rolling), mtb.Coulomb(FRICTION), coupling="one-way"
    )
    bound = FRICTION * peak
    assert np.abs(patch.traction - rolled.traction[:2]).max() < 2e-3 * bound
    assert np.abs(patch.status - rolled.status).max(initial=0) <= 1
    # force and moment about the axle, by sums over rows
    area = CELL**2
    across, normal_force = patch.traction[1] * area, patch.pressure * area
    force = np.array([
        patch.traction[0].sum() * area,
        (across * np.cos(angle)[:, None] + normal_force * np.sin(angle)[:, None]).sum(),
        (across * np.sin(angle)[:, None] - normal_force * np.cos(angle)[:, None]).sum(),
    ])  # fmt: skip
    assert np.allclose(step.force, force, rtol=1e-8, atol=2e-3)
    assert step.force[0] == pytest.approx(rolled.force[0], rel=2e-5)
    braking = (patch.traction[0].sum(axis=1) * area) @ (place[1] - (WHEEL - SINK))
    upwards = across * np.sin(angle)[:, None] - normal_force * np.cos(angle)[:, None]
    assert step.moment[1] == pytest.approx(braking - upwards.sum(axis=0) @ patch.x, rel=1e-6)


def test_places_directions_and_loads_of_rows_belong_together() -> None:
    wheels = mtb.scenes.wheel_on_rail(lateral=0.0, spacing=1e-3, force=60e3).prepare(
        side="both", conformal=True
    )
    step = wheels.step([0.0, 0.7e-3, np.nan, np.nan, 0.0, 2e-3], SPEED)
    for patch in step.patches:
        points, frames = patch.points, patch.frames
        assert np.allclose(np.einsum("ijk,imk->jmk", frames, frames), np.eye(3)[..., None])
        # rows lie a cell apart along the rail, which is inclined as the surface between it and the wheel
        # but for half of what the two differ by
        ways = np.diff(points[:, :, 0], axis=1)
        assert np.allclose(np.linalg.norm(ways, axis=0), 1e-3, rtol=1e-3)
        mean = frames[:, 1, 1:] + frames[:, 1, :-1]
        assert np.abs(np.cross(ways, mean, axis=0)).max() < 5e-5
        assert np.allclose(np.diff(patch.y), 1e-3)
        assert np.allclose(patch.load().sum(axis=(1, 2)), patch.force)
        near = np.argmin(np.abs(patch.y))
        assert np.linalg.norm(points[:, near, np.argmin(np.abs(patch.x))] - patch.position) < 0.8e-3
    assert np.allclose(sum(patch.force for patch in step.patches), step.force)
