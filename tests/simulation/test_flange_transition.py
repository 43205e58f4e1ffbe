# SPDX-License-Identifier: MIT OR Apache-2.0
"""Wheels between tread and flange: the grid follows the contact, and no edge of it cuts the contact off."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import mtb_rs as mtb

Array = NDArray[np.float64]
SPACING = 4e-4
TAPE = 0.75
#: Of the rail towards the middle of the track.
CANT = 1.0 / 40.0


def prepared(force: float, spacing: float = SPACING, **given: Any) -> mtb.PreparedWheels:
    scene = mtb.scenes.wheel_on_rail(force=force, lateral=0.0, spacing=spacing, friction=0.0, **given)
    return scene.prepare(side="left")


def stepped(wheels: mtb.PreparedWheels, lateral: float, yaw: float = 0.0) -> mtb.WheelStep:
    return wheels.step(pose=(0.0, lateral, np.nan, 0.0, 0.0, yaw), velocity=20.0)


def loaded_on_edge(pressure: Array) -> int:
    on = pressure > 0.0
    on[1:-1, 1:-1] = False
    return int(on.sum())


def gap_on(patch: mtb.WheelPatch, height: float, lateral: float, x: Array, y: Array) -> Array:
    """Gap (ny, nx) along the normal of a patch's plane, of finely tabulated profiles; < 0 where they overlap.

    `height`: of the axle over the top of the rail.
    """
    rail, wheel = mtb.Profile.standard("60E1"), mtb.Profile.standard("S1002")
    turn, origin = patch.rotation[1:, 1:], patch.position[1:]
    cant = np.array([[np.cos(CANT), -np.sin(CANT)], [np.sin(CANT), np.cos(CANT)]])

    def fine(profile: mtb.Profile) -> Array:
        start, end = profile.range
        return np.linspace(start, end, 40001)

    def over(curve: Array) -> Array:
        along, up = turn.T @ (curve - origin[:, None])
        # the part that faces the plane
        ahead = np.flatnonzero(np.diff(along) > 1e-8)
        near = ahead[np.argmin(np.abs(along[ahead]))]
        first = last = near
        steps = np.diff(along) > 1e-8
        while first > 0 and steps[first - 1]:
            first -= 1
        while last < steps.size - 1 and steps[last + 1]:
            last += 1
        cut = slice(first, last + 2)
        return np.interp(y, along[cut], up[cut], left=np.nan, right=np.nan)

    own = fine(rail)
    here = np.array([patch.rail_position, float(rail.height(patch.rail_position))])
    below = over(cant @ np.array([own, rail.height(own)]) + (origin - cant @ here)[:, None])
    place = fine(wheel)
    radius = 0.46 - wheel.height(place)
    columns = [
        over(np.array([TAPE + lateral + place, height - np.sqrt(radius**2 - at**2)])) - below for at in x
    ]
    return np.nan_to_num(np.array(columns).T, nan=1e-2)


@pytest.mark.parametrize(
    ("lateral", "force"), [(6.6e-3, 60e3), (6.65e-3, 60e3), (6.7e-3, 60e3), (6.75e-3, 1e5)]
)
def test_a_step_is_the_solution_on_a_larger_grid(lateral: float, force: float) -> None:
    wheels = prepared(force)
    step = stepped(wheels, lateral)
    (patch,) = step.patches
    assert loaded_on_edge(patch.pressure) == 0
    count = [round(float(line[-1] - line[0]) / SPACING) for line in (patch.x, patch.y)]
    x, y = (
        line[0] + SPACING * np.arange(-n // 2, n + n // 2 + 1)
        for line, n in zip((patch.x, patch.y), count, strict=True)
    )
    height = float(wheels.reference_point[2] + step.pose[2])
    gap = gap_on(patch, height, lateral, x, y)
    truth = mtb.solve_normal(
        gap - gap.min(), SPACING, upper=mtb.steel, lower=mtb.steel, approach=-float(gap.min()), edge="sharp"
    )
    assert loaded_on_edge(truth.pressure) == 0
    # tables of steps of 3 um follow the profiles to 0.1 nm, of an overlap of 0.1 mm
    assert patch.normal_force == pytest.approx(truth.normal_force, rel=1e-4)
    assert patch.pressure.max() == pytest.approx(truth.pressure.max(), rel=1e-3)
    assert step.vertical_force["left"] == pytest.approx(force, rel=1e-6)


def test_the_peak_does_not_grow_as_the_cells_shrink() -> None:
    peaks = [stepped(prepared(60e3, h), 6.65e-3).patches[0].pressure.max() for h in (4e-4, 2e-4)]
    assert peaks[1] == pytest.approx(peaks[0], rel=0.05)


def test_a_step_finds_its_height_at_every_shift() -> None:
    for spacing in (2e-4, 4e-4):
        wheels = prepared(60e3, spacing)
        for lateral in (6.57e-3, 6.6e-3, 6.62e-3, 6.63e-3, 6.64e-3):
            step = stepped(wheels, lateral)
            assert step.vertical_force["left"] == pytest.approx(60e3, rel=1.1e-3)
            assert all(loaded_on_edge(patch.pressure) == 0 for patch in step.patches)


def test_patches_that_have_grown_together_are_one() -> None:
    wheels = prepared(39051.80804675897, 0.0007905325265268272)
    step = stepped(wheels, 0.006581496709614315, -0.011316327836480518)
    (patch,) = step.patches
    assert loaded_on_edge(patch.pressure) == 0


def test_a_force_that_no_height_carries_says_between_which_it_jumps() -> None:
    wheels = prepared(4150.0, 0.0008924038515783139, rail_inclination=0.05, wheel_radius=0.5415409990533073)
    with pytest.raises(mtb.ConvergenceError, match=r"the force jumps from 4\S+ N to 4\S+ N.*give z"):
        stepped(wheels, 0.0061554564963168055)


@pytest.mark.parametrize("force", [36e3, 60e3, 1e5])
@pytest.mark.filterwarnings("ignore:the peak pressure")
def test_a_scene_is_solved_at_every_shift(force: float) -> None:
    for lateral in np.arange(6.5e-3, 6.95e-3, 0.05e-3):
        scene = mtb.scenes.wheel_on_rail(lateral=float(lateral), force=force, spacing=SPACING)
        result = scene.solve(tolerance=0.9)
        angle = scene.geometry.placement.contact_angle
        field = mtb.wheel_on_rail_gap(lateral=float(lateral), force=force, spacing=SPACING, scale=3.0)
        truth = mtb.solve_normal(
            field.gap, SPACING, upper=mtb.steel, lower=mtb.steel, force=force / np.cos(angle), edge="error"
        )
        assert result.report.peak_pressure == pytest.approx(truth.pressure.max(), rel=1e-4)
        # but for a few cells at its border
        assert result.report.contact_area == pytest.approx(truth.contact_area, abs=4.01 * SPACING**2)


@pytest.mark.filterwarnings("ignore:the peak pressure", "ignore:the .* body deforms")
def test_an_edge_that_is_reached_says_what_a_wheel_can_be_given() -> None:
    scene = mtb.scenes.wheel_on_rail(spacing=1e-3, lateral=0.0).with_(force=None, approach=1e-3)
    with pytest.raises(ValueError, match=r"wheel_on_rail_gap with a larger approach") as refused:
        scene.solve()
    assert "edge=" not in str(refused.value)


@pytest.mark.filterwarnings("ignore:the peak pressure")
def test_small_jumps_leave_height_and_roll_of_a_wheelset() -> None:
    """Where the plane of a flange contact turns, height and roll at a small jump of the force are found."""
    scene = mtb.scenes.wheel_on_rail(lateral=0.0, force=60e3, spacing=1e-3)
    wheels = scene.prepare(side="both", friction=mtb.Coulomb(0.3))
    heights = []
    for beside in (-1e-7, 0.0, 1e-9, 1e-7):
        step = wheels.copy().step((0.0, -6.532e-3 + beside, np.nan, np.nan, 0.0, -1.5e-3), 20.0)
        # without a root in between: 1e-9 m beside it the wheels carry what is asked for
        assert abs(step.balance_error) < 1e-4
        assert list(step.vertical_force.values()) == pytest.approx([60e3, 60e3], rel=1e-4)
        heights.append(step.pose[2])
    assert heights[1] == pytest.approx(0.5 * (heights[0] + heights[3]), abs=1e-7)
