# SPDX-License-Identifier: MIT OR Apache-2.0
"""Wear of wheel and rail profiles: closed forms, volumes, orders, relations, and what is refused."""

import pickle
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import mtb_rs as mtb

LAW = 1e-13
MU = mtb.Coulomb(0.3)
RADIUS, FORCE = 0.46, 60e3


def plain(spacing: float = 6e-4, lateral: float = 0.0) -> mtb.WheelScene:
    """Cylindrical wheels on rails with round heads: a contact that stays in the middle of the rail."""
    y = np.linspace(-0.06, 0.06, 241)
    rail = mtb.Profile.from_points(y, np.sqrt(0.2**2 - y**2) - 0.2)
    wheel = mtb.Profile.from_points([-0.06, 0.06], [0.0, 0.0], "linear")
    return mtb.scenes.wheel_on_rail(
        wheel,
        rail,
        RADIUS,
        force=FORCE,
        lateral=lateral,
        spacing=spacing,
        rail_inclination=0.0,
        gauge_depth=3e-3,
        tape_circle=0.7175 - 0.68 + np.sqrt(0.2**2 - 0.197**2),
    )


def measured(**changes: Any) -> mtb.WheelWear:
    scene = mtb.scenes.wheel_on_rail("S1002", "60E1", force=FORCE, lateral=0.0, spacing=1e-3)
    given: dict[str, Any] = {
        "scene": scene,
        "distance": 2e7,
        "law": LAW,
        "shifts": np.linspace(-2e-3, 2e-3, 17),
        "friction": MU,
    }
    return mtb.wear_of_wheels(**{**given, **changes})


def test_a_wheel_that_slides_across_wears_evenly() -> None:
    # at 0.03 rad all of the contact slides: each place is passed by the whole load times that slip
    slip, shifts, distance = 0.03, np.linspace(-0.01, 0.01, 41), 2e3
    worn = mtb.wear_of_wheels(
        plain(), distance, LAW, shifts=shifts, yaw=np.arctan(slip), depth=1.0, friction=MU, velocity=20.0
    )
    band = shifts[-1] - shifts[0] + (shifts[1] - shifts[0])
    y = worn.wheel_points[0, 0]
    middle = y[worn.wheel_depths[-1].argmax()]
    inside = worn.wheel_depths[-1][np.abs(y - middle) < 3e-3].mean()
    # the balance holds the vertical force with friction in it, and sin(yaw) is 4e-4 from its tangent
    assert inside == pytest.approx(LAW * FORCE * slip * distance / (2.0 * np.pi * RADIUS * band), rel=3e-3)


def test_the_volume_is_that_of_the_patches_and_of_their_heat() -> None:
    worn = measured(distance=1e5, lower_law=2.0 * LAW, passages=1e4)
    scene = mtb.scenes.wheel_on_rail("S1002", "60E1", force=FORCE, lateral=0.0, spacing=1e-3)
    contact = scene.prepare(side="both", friction=MU)
    patches = [
        patch for y in worn.shifts for patch in contact.step([0, y, np.nan, np.nan, 0, 0], 20.0).patches
    ]
    # no material is lost between the lines of a patch and the points of a profile; both wheels' mean
    each = sum(p.wear_depth(LAW).sum() * (p.y[1] - p.y[0]) for p in patches) / (2 * worn.shifts.size)
    assert worn.wheel_volumes[-1] == pytest.approx(each * 1e5, rel=1e-9, abs=0.0)
    assert worn.rail_areas[-1] == pytest.approx(2.0 * each * 1e4, rel=1e-9, abs=0.0)
    # heat over friction is pressure times slip
    heat = sum(p.dissipation.sum() * p.area for p in patches) / (2 * worn.shifts.size)
    assert each == pytest.approx(LAW * heat / 0.3 / 20.0, rel=1e-3, abs=0.0)


def test_the_error_is_of_first_order_in_the_depth_of_an_update() -> None:
    # a way for which half of the depth takes about twice the updates, which are whole
    deepest = [
        mtb.wear_of_wheels(plain(), 1.2e4, LAW, shifts=[0.0], yaw=0.03, depth=d, friction=MU)
        for d in (2e-5, 1e-5, 5e-6, 2.5e-6)
    ]
    volumes = [worn.wheel_volumes[-1] for worn in deepest]
    depths = [worn.wheel_depths[-1].max() for worn in deepest]
    for found in (volumes, depths):
        falls = np.abs(np.diff(found))
        assert (np.log2(falls[:-1] / falls[1:]) > 0.7).all()


@pytest.mark.parametrize("share", [1.45, 2.45, 0.99, 2.0])
def test_no_update_wears_off_more_than_the_depth(share: float) -> None:
    given = {"scene": plain(), "law": LAW, "shifts": [0.0], "yaw": 0.03, "friction": MU}
    most = 2e-6
    rate = mtb.wear_of_wheels(distance=1.0, **given).wheel_depths[-1].max()
    worn = mtb.wear_of_wheels(distance=share * most / rate, depth=most, **given)
    assert np.diff(worn.wheel_depths, axis=0).max() <= most * (1.0 + 1e-9)


@pytest.mark.slow
def test_relations() -> None:
    worn = measured(distance=1e7)
    # left and right change places
    other = measured(distance=1e7, shifts=-worn.shifts)
    np.testing.assert_allclose(other.wheel_depths[-1], worn.wheel_depths[-1], rtol=0, atol=1e-10)
    # only ratios of the shares count, and a share of nothing is no position
    more = measured(
        distance=1e7, shifts=np.append(worn.shifts, 5e-3), shares=np.append(np.full(17, 3.0), 0.0)
    )
    np.testing.assert_allclose(more.wheel_depths[-1], worn.wheel_depths[-1], rtol=0, atol=1e-15)
    # half of the law over twice the way is the same wear at the same depths
    slow = measured(distance=2e7, law=LAW / 2.0)
    np.testing.assert_allclose(slow.wheel_depths[-1], worn.wheel_depths[-1], rtol=1e-9, atol=1e-12)
    # a rail that does not wear stays
    assert not worn.rail_depths.any()
    assert np.array_equal(worn.rail_points[0], worn.rail_points[-1])
    # averaging keeps the area
    wide = measured(distance=1e5, wavelength=1e-2)
    narrow = measured(distance=1e5, wavelength=1e-3)
    assert wide.wheel_volumes[-1] == pytest.approx(narrow.wheel_volumes[-1], rel=1e-12)
    assert wide.smoothed.max() > narrow.smoothed.max()


def test_sides_that_wear_apart() -> None:
    """One curve wears the sides unlike, the other one the other way, and both together alike."""
    curve: dict[str, Any] = {
        "distance": 1e6, "shifts": np.linspace(1e-3, 3e-3, 9), "yaw": 2e-3, "lower_law": LAW, "passages": 1e3,
    }  # fmt: skip
    apart = measured(**curve, apart=True)
    assert apart.right is not None
    assert apart.right.right is None
    names = ("wheel_depths", "rail_depths", "wheel_volumes", "rail_areas", "wheel_points", "smoothed")
    assert apart.wheel_volumes[-1] > 1.1 * apart.right.wheel_volumes[-1]
    # the other way round
    other = measured(**curve | {"shifts": -curve["shifts"], "yaw": -curve["yaw"]}, apart=True)
    assert other.right is not None
    for name in names:
        for one, mirrored in ((apart, other.right), (apart.right, other)):
            np.testing.assert_allclose(getattr(mirrored, name), getattr(one, name), rtol=1e-7, atol=1e-12)
    # the first update: alike is the mean of both
    alike = measured(**curve)
    assert alike.right is None
    for volume in ("wheel_volumes", "rail_areas"):
        mean = 0.5 * (getattr(apart, volume) + getattr(apart.right, volume))[1] / apart.distances[1]
        assert getattr(alike, volume)[1] / alike.distances[1] == pytest.approx(mean, rel=1e-9, abs=0.0)
    # both curves in turn: the sides are alike to what steps are
    shifts = np.concatenate([curve["shifts"], -curve["shifts"]])
    both = measured(**curve | {"shifts": shifts, "yaw": np.sign(shifts) * 2e-3}, apart=True)
    assert both.right is not None
    np.testing.assert_allclose(both.right.wheel_depths, both.wheel_depths, rtol=1e-7, atol=1e-12)


def test_a_right_side_of_its_own_wears_as_a_left_one_would(tmp_path: Path) -> None:
    y = np.linspace(-0.06, 0.06, 601)
    hollow = mtb.Profile.from_points(
        y, np.clip(mtb.Profile.standard("S1002").height(y), -1.0, 1.0) + 2e-4 * np.exp(-((y / 0.01) ** 2))
    )
    curve: dict[str, Any] = {"distance": 1e6, "shifts": np.linspace(-2e-3, 1e-3, 7), "yaw": 1e-3}
    right: dict[str, Any] = {"right_wheel": hollow, "right_wheel_radius": 0.4602, "right_friction": 0.2}
    worn = measured(**curve, **right)
    scene = mtb.scenes.wheel_on_rail(hollow, "60E1", 0.4602, force=FORCE, lateral=0.0, spacing=1e-3)
    mirrored = mtb.wear_of_wheels(
        scene, 1e6, LAW, shifts=-curve["shifts"], yaw=-1e-3, friction=mtb.Coulomb(0.2), right_wheel="S1002",
        right_wheel_radius=RADIUS, right_friction=MU,
    )  # fmt: skip
    assert worn.right is not None
    assert mirrored.right is not None
    for one, other in ((worn, mirrored.right), (worn.right, mirrored)):
        # heights count from where the left wheel touches, which moves no contact
        assert other.wheel_volumes[-1] == pytest.approx(one.wheel_volumes[-1], rel=1e-5)
        scale = one.wheel_depths.max()
        np.testing.assert_allclose(other.wheel_depths[-1], one.wheel_depths[-1], atol=1e-3 * scale)
    assert worn.right.wheel(0).height(0.0) == pytest.approx(2e-4, abs=1e-6)
    worn.save(tmp_path)
    again = mtb.load(tmp_path)
    assert isinstance(again, mtb.WheelWear)
    assert again == worn == pickle.loads(pickle.dumps(worn))
    rows = (tmp_path / "wheel_wear.csv").read_text().splitlines()
    assert {row.split(",")[0] for row in rows[1:]} == {
        "left wheel", "right wheel", "left rail", "right rail",
    }  # fmt: skip
    told = dict(worn.told())
    assert {"largest depth of the left wheel", "worn off the right wheel"} <= set(told)
    assert "the right one by up to" in repr(worn)
    assert worn.right.plot().axes


def test_wear_makes_the_pressure_even() -> None:
    # all of the contact slides, so that it wears where it presses
    worn = mtb.wear_of_wheels(plain(), 4e3, LAW, shifts=[0.0], yaw=0.03, depth=2.5e-6, friction=MU)
    assert worn.distances.size > 10
    assert (np.diff(worn.peak_pressures[:, 0]) < 0.0).all()


def test_deep_updates_make_waves_grow() -> None:
    # the limit for 4 mm, 0.9 GPa and steel is about 20 um
    last = []
    for depth in (5e-6, 1e-4):
        worn = mtb.wear_of_wheels(plain(), 2e4, LAW, shifts=[0.0], yaw=0.03, depth=depth, friction=MU)
        last.append(worn.peak_pressures[-1, 0] / worn.peak_pressures[0, 0])
    assert last[0] < 0.85 < 1.0 < last[1]


def test_it_is_kept_and_shown(tmp_path: Path) -> None:
    worn = measured(distance=1e7, lower_law=LAW, passages=1e4)
    files = worn.save(tmp_path)
    assert {path.suffix for path in files} == {".json", ".npz", ".png", ".csv"}
    for again in (mtb.load(tmp_path / "wheel_wear.json"), pickle.loads(pickle.dumps(worn))):
        assert again == worn
    rows = (tmp_path / "wheel_wear.csv").read_text().splitlines()
    n, m, k = worn.wheel_points.shape[2], worn.rail_points.shape[2], worn.distances.size
    assert len(rows) == 1 + k * (n + m)
    worn.wheel().to_file(tmp_path / "worn.prw")
    again = mtb.Profile.from_file(tmp_path / "worn.prw")
    np.testing.assert_allclose(again.height(worn.wheel_points[-1, 0]), worn.wheel_points[-1, 1], atol=1e-8)
    assert "updates" in repr(worn)


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"scene": mtb.scenes.block_on_plane()}, "wheel_on_rail is needed"),
        ({"distance": 0.0}, "distance is 0"),
        ({"depth": -1e-5}, "depth is -1e-05"),
        ({"shifts": []}, "at least one lateral position"),
        ({"shifts": [0.0, 1e-3], "shares": [1.0]}, "2 numbers of at least 0"),
        ({"shifts": [0.0, 1e-3], "shares": [1.0, -1.0]}, "2 numbers of at least 0"),
        ({"yaw": [0.0, 1e-3, 0.0]}, "a number, or 17 of them"),
        ({"lower_law": LAW}, "passages"),
        ({"passages": 10.0}, "lower_law"),
        ({"law": 1.0}, "larger depth|wear"),
        ({"friction": "low"}, "friction is 'low'"),
        ({"apart": 2}, "apart is 2"),
        ({"right_wheel_radius": -0.4}, "right_wheel_radius is -0.4"),
    ],
)
def test_what_is_refused(changes: dict[str, Any], words: str) -> None:
    with pytest.raises(ValueError, match=words):
        measured(**changes)


def test_positions_without_an_answer_are_left_out_or_told() -> None:
    # far to the side the wheel is off its rail
    shifts = np.append(np.linspace(-1e-3, 1e-3, 5), 0.08)
    shares = np.append(np.ones(5), 0.2)
    worn = measured(distance=1e5, shifts=shifts, shares=shares)
    assert worn.left_out == pytest.approx(0.2 / 5.2)
    assert worn.peak_pressures[0, -1] == 0.0
    without = measured(distance=1e5, shifts=shifts[:-1])
    np.testing.assert_allclose(worn.wheel_depths[-1], without.wheel_depths[-1], rtol=1e-12)
    with pytest.raises(mtb.ConvergenceError, match=r"after 0 m, at the shift 0.08 m: "):
        measured(distance=1e5, shifts=shifts)
