# SPDX-License-Identifier: MIT OR Apache-2.0
"""Patches of wheels that follow the rail: relations that hold, other ways to ask for them, and refusals."""

from __future__ import annotations

import functools
import json
import pickle
from pathlib import Path

import jsonschema
import numpy as np
import pytest

import mtb_rs as mtb
from mtb_rs.case.summary_schema import summary_schema

FREE = np.nan


@pytest.fixture(scope="module")
def scene() -> mtb.WheelScene:
    return mtb.scenes.wheel_on_rail(lateral=0.0, spacing=1e-3, force=60e3)


def peak(step: mtb.WheelStep) -> float:
    return max(float(patch.pressure.max()) for patch in step.patches)


@pytest.mark.parametrize("y", [0.0, 3e-3, 6.7e-3])
def test_a_right_wheel_is_a_left_one_in_a_mirror(scene: mtb.WheelScene, y: float) -> None:
    left, right = (scene.prepare(side=side, conformal=True) for side in ("left", "right"))
    turned = [20.0, 0.01, 0.0, 0.02, 43.5, 0.03]
    mirrored = [20.0, -0.01, 0.0, -0.02, 43.5, -0.03]
    one = left.step([0.0, y, FREE, 1e-4, 0.0, 2e-3], turned)
    other = right.step([0.0, -y, FREE, -1e-4, 0.0, -2e-3], mirrored)
    assert np.allclose(one.force * [1.0, -1.0, 1.0], other.force, rtol=1e-9, atol=1e-5)
    assert np.allclose(one.moment * [-1.0, 1.0, -1.0], other.moment, rtol=1e-9, atol=1e-4)
    for a, b in zip(one.patches, other.patches, strict=True):
        assert a.inclination is not None
        assert b.inclination is not None
        assert np.allclose(a.inclination, -b.inclination[::-1], atol=1e-12)
        assert np.allclose(a.y, -b.y[::-1], atol=1e-12)
        assert np.allclose(a.pressure, b.pressure[::-1], atol=1e-6 * a.pressure.max())
        assert np.allclose(a.points[1], -b.points[1, ::-1], atol=1e-12)
        assert np.allclose(a.traction[1], -b.traction[1, ::-1], atol=1e-5 * a.pressure.max())


def test_wheels_that_roll_backwards_see_the_same_contact(scene: mtb.WheelScene) -> None:
    # without spin and yaw, rolling back under the opposite creepage along turns the traction round
    wheels = scene.prepare(conformal=True)
    ahead = wheels.step([0.0, 3e-3, FREE, 0.0, 0.0, 0.0], [20.0, 0.0, 0.0, 0.0, 43.5, 0.0])
    back = wheels.step([0.0, 3e-3, FREE, 0.0, 0.0, 0.0], [-20.0, 0.0, 0.0, 0.0, -43.5, 0.0])
    assert np.allclose(ahead.force * [-1.0, 1.0, 1.0], back.force, rtol=1e-6, atol=1.0)
    assert ahead.friction_power == pytest.approx(back.friction_power, rel=1e-6)


def test_less_curved_rails_leave_a_plane() -> None:
    """Forces differ by less and less as the rail gets flat: by the square of the turn of the contact."""
    apart, turns = [], []
    for radius in (0.1, 0.2, 0.4):
        y = np.linspace(-0.045, 0.045, 1801)
        crown = mtb.Profile.from_points(y, np.sqrt(radius**2 - y**2) - radius)
        tread = mtb.Profile.from_points(np.linspace(-0.06, 0.06, 81), np.zeros(81))
        scene = mtb.scenes.wheel_on_rail(
            tread, crown, rail_inclination=0.0, lateral=0.0, spacing=2.5e-4, gauge=1.44, gauge_depth=2e-3
        )
        pose, slip = [0.0, 0.0, -0.05e-3, 0.0, 0.0, 3e-3], 20.0
        plane, rows = (scene.prepare(conformal=conformal).step(pose, slip) for conformal in (False, True))
        apart.append(np.abs(rows.force / plane.force - 1.0)[1:].max())
        (patch,) = rows.patches
        turns.append(np.ptp(patch.inclination[patch.pressure.max(axis=1) > 0.0]))
    assert np.all(np.array(apart) < np.array(turns) ** 2)
    assert apart[0] > 1.3 * apart[1] > 1.3**2 * apart[2]


def test_forces_and_heights_change_evenly_from_tread_to_flange(scene: mtb.WheelScene) -> None:
    """Where the plane of a contact turns between tread and flange its forces jump; those on rows do not."""
    shifts = np.linspace(6.5e-3, 6.75e-3, 26)
    largest = {}
    for conformal in (False, True):
        wheels = scene.prepare(conformal=conformal)
        found = [wheels.step([0.0, y, FREE, 0.0, 0.0, 0.0], 20.0) for y in shifts]
        peaks = np.array([peak(step) for step in found])
        bends = np.abs(np.diff(peaks, 2))
        largest[conformal] = bends.max() / peaks.mean()
        carried = np.array([step.vertical_force["left"] for step in found])
        assert np.ptp(carried) < 2e-3 * carried.mean()
        if conformal:
            assert all(step.balance_error is not None and abs(step.balance_error) < 1e-8 for step in found)
            assert all(patch.neglected == 0.0 for step in found for patch in step.patches)
    assert largest[True] < largest[False]


def test_a_transient_roll_settles_at_steady_rolling(scene: mtb.WheelScene) -> None:
    wheels = scene.prepare(conformal=True)
    pose = [0.0, 6.6e-3, FREE, 0.0, 0.0, 2e-3]
    steady = wheels.step(pose, 20.0)
    fresh = scene.prepare(conformal=True)
    dt = 1e-3 / 20.0
    for k in range(60):
        pose[0] = 1e-3 * (k + 1)
        rolled = fresh.step(pose, 20.0, dt=dt, transient=True)
    assert np.allclose(rolled.force, steady.force, rtol=2e-4, atol=2.0)


def test_friction_that_follows_the_temperature_has_derivatives_on_rows(scene: mtb.WheelScene) -> None:
    wheels = scene.prepare(conformal=True, friction=mtb.TemperatureFriction([0.0, 400.0], [0.33, 0.14]))
    velocity = [20.0, 0.0, 0.0, 0.0, 43.6, 0.0]

    def at(change: float) -> float:
        pose = [0.0, 6.55e-3, 0.8e-3, change, 0.0, 2e-3]
        return wheels.copy().step(pose, velocity).friction_power

    step = wheels.step([0.0, 6.55e-3, 0.8e-3, 0.0, 0.0, 2e-3], velocity)
    wide, near = ((at(h) - at(-h)) / (2.0 * h) for h in (2e-7, 1e-7))
    assert step.derivative("friction_power", "pose")[3] == pytest.approx((4.0 * near - wide) / 3.0, rel=1e-5)


def test_t_gamma_is_the_heat_where_surfaces_hardly_turn(scene: mtb.WheelScene) -> None:
    """Creepages of each row count, not those of the origin alone."""
    for y in (0.0, 5e-3):
        step = scene.prepare(conformal=True).step([0.0, y, FREE, 0.0, 0.0, 0.0], 20.0)
        (patch,) = step.patches
        assert patch.row_creepage is not None
        work = patch.t_gamma(with_spin=True) * abs(patch.rolling_speed)
        assert work == pytest.approx(patch.friction_power, rel=0.03)
        # at the origin a row creeps as the plane of the patch does, but for its slope
        own = [np.interp(0.0, patch.y, creepage) for creepage in patch.row_creepage]
        assert own[:2] == pytest.approx(list(patch.creepage[:2]), abs=2e-5)


def test_rows_stay_where_they_are_as_the_contact_moves(scene: mtb.WheelScene) -> None:
    wheels = scene.prepare(conformal=True)
    places: set[tuple[float, ...]] = set()
    for y in (5.0e-3, 5.3e-3):
        for patch in wheels.step([0.0, y, FREE, 0.0, 0.0, 0.0], 20.0).patches:
            places.add(tuple(np.round(patch.row_position[0] * 1e9)))
    one, other = (set(rows) for rows in places)
    assert len(one & other) > 0.7 * min(len(one), len(other))


def test_saved_copied_and_pickled_wheels_give_the_same_step(scene: mtb.WheelScene, tmp_path: Path) -> None:
    wheels = scene.prepare(conformal=True)
    pose = [0.0, 6.6e-3, FREE, 0.0, 0.0, 2e-3]
    truth = wheels.step(pose, 20.0)
    wheels.save(tmp_path / "wheels.mtbw")
    for other in (
        mtb.PreparedWheels.load(tmp_path / "wheels.mtbw"),
        pickle.loads(pickle.dumps(wheels)),
        wheels.copy(),
        scene.prepare(conformal=True),
    ):
        found = other.step(pose, 20.0)
        assert np.allclose(found.force, truth.force, rtol=1e-7)
        assert found.patches[0].inclination is not None
    again = pickle.loads(pickle.dumps(truth))
    assert np.array_equal(again.patches[0].row_position, truth.patches[0].row_position)
    truth.save(tmp_path / "step.npz")
    loaded = mtb.load(tmp_path / "step.npz")
    assert np.array_equal(loaded.patches[0].inclination, truth.patches[0].inclination)
    assert np.allclose(loaded.patches[0].points, truth.patches[0].points)


def test_files_of_a_patch_tell_how_its_rows_lie(scene: mtb.WheelScene, tmp_path: Path) -> None:
    (patch,) = scene.prepare(conformal=True).step([0.0, 5e-3, FREE, 0.0, 0.0, 2e-3], 20.0).patches
    patch.save(tmp_path / "patch")
    told = json.loads((tmp_path / "patch" / "summary.json").read_text())
    jsonschema.validate(told, summary_schema())
    _, height = told["row_position"]
    assert np.ptp(height) > 1e-4
    with np.load(tmp_path / "patch" / "fields.npz") as fields:
        normal, (along, across) = fields["normal"], fields["traction"]
        aside = np.stack([0.0 * along, normal[2], -normal[1]])
        forward = np.array([1.0, 0.0, 0.0])[:, None, None]
        load = along * forward + across * aside - fields["pressure"] * normal
        assert np.allclose((load * fields["area"]).sum(axis=(1, 2)), patch.force, rtol=1e-12)
    assert patch.to_xarray()["normal"].dims == ("component", "y", "x")
    plane = scene.prepare().step([0.0, 5e-3, FREE, 0.0, 0.0, 2e-3], 20.0).patches[0]
    assert "normal" not in plane.fields()


def test_case_files_and_sweeps_ask_for_it(scene: mtb.WheelScene, tmp_path: Path) -> None:
    truth = mtb.step_wheels(scene, 20.0, y=6.6e-3, conformal=True)
    plane = mtb.step_wheels(scene, 20.0, y=6.6e-3)
    assert abs(truth.force[1] / plane.force[1] - 1.0) > 1e-3
    case = tmp_path / "case.toml"
    case.write_text(
        "scene = 'wheel_on_rail'\nlateral = 0.0\nspacing = 0.001\nforce = 60000.0\n"
        "[step_wheels]\nvelocity = 20.0\ny = 0.0066\nconformal = true\n",
        encoding="utf-8",
    )
    found = mtb.load_case(case).solve()
    assert np.allclose(found.force, truth.force, rtol=1e-8)
    with case.open("a", encoding="utf-8") as file:
        file.write("[stress]\ndepths = [0.001]\n")
    with pytest.raises(mtb.CaseError, match="stress: the patch follows the rail"):
        mtb.load_case(case).expected_cost()
    study = functools.partial(mtb.step_wheels, velocity=20.0, y=6.6e-3)
    table = mtb.sweep(scene, {"step_wheels.conformal": [False, True]}, study=study)
    assert table.failures == []
    assert np.allclose(table["force_y"], [plane.force[1], truth.force[1]], rtol=1e-8)


def test_states_of_planes_and_of_rows_are_not_taken_for_each_other(scene: mtb.WheelScene) -> None:
    plane, rows = scene.prepare(), scene.prepare(conformal=True)
    pose = [0.0, 3e-3, FREE, 0.0, 0.0, 2e-3]
    for one, other, word in ((plane, rows, "on planes"), (rows, plane, "that follow the rail")):
        left = one.step(pose, 20.0).state
        with pytest.raises(ValueError, match=word):
            other.step(pose, 20.0, dt=1e-4, transient=True, state=left)


def test_what_is_not_known_is_refused_by_name(scene: mtb.WheelScene) -> None:
    step = scene.prepare(conformal=True).step([0.0, 6.6e-3, FREE, 0.0, 0.0, 2e-3], 20.0)
    for asked in (step.patches[0], step):
        with pytest.raises(ValueError, match="known below planes only"):
            asked.stress(depths=[1e-3])
    with pytest.raises(ValueError, match="known between like ones"):
        step.derivative("force", "lower.young_modulus")
    assert not [name for name in step.gradient("friction_power") if "modulus" in name]
    with pytest.raises(ValueError, match="spin_moment of conformal patches"):
        step.derivative("spin_moment", "pose")
    unlike = mtb.scenes.wheel_on_rail(lower=mtb.Material(2.0e11, 0.28), spacing=1e-3)
    with pytest.raises(ValueError, match="conformal patches are known between like bodies alone"):
        unlike.prepare(conformal=True)
    roller = mtb.scenes.wheel_on_rail(roller_radius=1.0, lateral=0.0, spacing=1e-3)
    with pytest.raises(ValueError, match="slices, or the rail is a roller"):
        roller.prepare(conformal=True)
    with pytest.raises(ValueError, match="conformal is 1"):
        scene.prepare(conformal=1)  # type: ignore[arg-type]
    with pytest.raises(ValueError, match="conformal is for wheels on rails"):
        mtb.scenes.pole_shoe_on_rail().prepare(conformal=True)
