# SPDX-License-Identifier: MIT OR Apache-2.0
"""Wheels out of round and with flats, rails that dip: closed forms, and runs of CONTACT."""

from __future__ import annotations

import json
import pickle
import warnings
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import mtb_rs as mtb

#: Printed by CONTACT, revision 2707 (tests/data/contact/README.md).
CASES: list[dict[str, Any]] = json.loads(
    (Path(__file__).parents[1] / "data" / "contact" / "varying_profiles.json").read_text()
)
R, R_RAIL = 0.45, 0.3
#: y of the crown from the gauge face 3 mm below it.
FACE = float(np.sqrt(R_RAIL**2 - (R_RAIL - 3e-3) ** 2))


def cylinder() -> mtb.Profile:
    y = np.linspace(-0.06, 0.06, 1201)
    return mtb.Profile.from_points(y, np.sqrt(R_RAIL**2 - y**2) - R_RAIL)


def flat() -> mtb.Profile:
    return mtb.Profile.from_points([-0.05, 0.05], [0.0, 0.0], "linear")


def scene(wheel: Any, rail: Any, force: float = 20e3, spacing: float = 3e-4, **more: Any) -> mtb.WheelScene:
    steel = mtb.Material.from_shear_modulus(82e9, 0.28)
    track: dict[str, Any] = {
        "gauge_depth": 3e-3,
        "rail_inclination": 0.0,
        "lateral": 0.0,
        "tape_circle": 1.435 / 2 + FACE - 0.68,
    }
    return mtb.scenes.wheel_on_rail(
        wheel, rail, R, force=force, spacing=spacing, upper=steel, lower=steel, **track | more
    )


def flat_wheel(depth: float, half: float, at: float = 0.0) -> mtb.WheelSlices:
    angle = np.radians(np.arange(-180.0, 180.01, 0.5))
    off = angle - at
    off = np.where(np.abs(off) < half, depth * np.cos(0.5 * np.pi * off / half) ** 2, 0.0)
    return mtb.WheelSlices.out_of_round(flat(), angle, -off)


@pytest.mark.parametrize("case", CASES, ids=lambda case: case["name"])
def test_flats_and_dips_as_contact(case: dict[str, Any]) -> None:
    given, printed = case["inputs"], case["results"]
    wheel: Any = flat()
    rail: Any = cylinder()
    pose = [0.0, 0.0, np.nan, 0.0, 0.0, 0.0]
    if "depth" in given:
        wheel = flat_wheel(
            1e-3 * given["depth"], np.radians(given["half_deg"]), np.radians(given["theta0_deg"])
        )
        # CONTACT's pitch is about an axis to the right
        pose[4] = -np.radians(given["pitch_deg"])
    else:
        length = 1e-3 * given["length"]
        s = 1e-3 * np.arange(-60.0, given["length"] + 60.1, 2.0)
        inside = (s > 0.0) & (s < length)
        dip = np.where(inside, 1e-3 * given["dip"] * np.sin(np.pi * s / length) ** 2, 0.0)
        rail = mtb.RailSlices.uneven(rail, s, -dip)
        pose[0] = 1e-3 * given["s_ws"]
    wheels = scene(wheel, rail, given["FZ"]).prepare()
    step = wheels.step(pose, (2.0, 0.0, 0.0, 0.0, -given["omega"], 0.0))
    (patch,) = step.patches
    assert patch.normal_force == pytest.approx(given["FZ"], rel=1e-6)
    # over what friction carries; the height at which it carries the force has four digits
    assert step.force[0] == pytest.approx(printed["FX"], abs=0.01 * 0.3 * given["FZ"])
    assert patch.pressure.max() == pytest.approx(1e6 * printed["PMAX"], rel=0.01)
    assert patch.approach == pytest.approx(1e-3 * printed["APPROACH"], rel=0.01)
    assert patch.creepage[0] == pytest.approx(-printed["CKSI"], abs=5e-6)
    # a tenth of a cell
    assert 1e3 * (patch.position[0] - pose[0]) == pytest.approx(printed["XCP(TR)"], abs=0.03)


@pytest.mark.parametrize("pitch", [0.0, 0.4, 1.9, -2.8])
def test_an_eccentric_wheel_is_a_shifted_circle(pitch: float) -> None:
    off, force = 0.8e-3, 50e3
    angle = np.linspace(-np.pi, np.pi, 181)
    # the circle about a centre that lies off the axle towards the angle 0.3
    about = angle - 0.3
    radius = off * np.cos(about) + np.sqrt(R**2 - (off * np.sin(about)) ** 2)
    eccentric = scene(mtb.WheelSlices.out_of_round(flat(), angle, radius - R), cylinder(), force).prepare()
    round_ = scene(flat(), cylinder(), force).prepare()
    # the angle 0.3 points down at that pitch, and forwards before it
    ahead, down = off * np.sin(0.3 - pitch), off * np.cos(0.3 - pitch)
    speed, spin = 20.0, 20.0 / R
    found = eccentric.step((0.0, 0.0, np.nan, 0.0, pitch, 0.0), (speed, 0, 0, 0, spin, 0))
    # the middle of the circle moves as the wheel turns about its axle
    moves = (speed - spin * down, 0.0, -spin * ahead, 0.0, spin, 0.0)
    exact = round_.step((ahead, 0.0, np.nan, 0.0, 0.0, 0.0), moves)
    assert found.pose[2] == pytest.approx(exact.pose[2] + down, abs=2e-9)
    (patch,), (reference,) = found.patches, exact.patches
    assert patch.position[0] == pytest.approx(reference.position[0], abs=2e-6)
    assert patch.pressure.max() == pytest.approx(reference.pressure.max(), rel=1e-3)
    # speeds, as creepages are over that of the reference point: of the axle, or of the middle of the circle
    slips = [np.array(p.creepage) * p.rolling_speed for p in (patch, reference)]
    np.testing.assert_allclose(*slips, atol=2e-6 * speed)
    assert found.force[0] == pytest.approx(exact.force[0], abs=2e-3 * force)


def test_both_wheels_stand_on_the_same_angle() -> None:
    wheels = scene(flat_wheel(0.3e-3, 0.06, at=0.5), cylinder()).prepare(side="both")
    step = wheels.step((0.0, 0.0, np.nan, np.nan, 0.5, 0.0), 10.0)
    left, right = step.patches
    assert {left.side, right.side} == {"left", "right"}
    np.testing.assert_allclose(left.pressure, right.pressure[::-1], rtol=1e-6, atol=1.0)
    assert step.pose[3] == pytest.approx(0.0, abs=1e-9)
    on_flat = left.pressure.max()
    beside = wheels.step((0.0, 0.0, np.nan, np.nan, 0.0, 0.0), 10.0)
    assert beside.patches[0].pressure.max() > 1.1 * on_flat


def test_a_deep_flat_is_stood_on_with_both_its_edges() -> None:
    # a chord: the wheel stands on its ends, with nothing in the middle
    half, force = 0.05, 60e3
    angle = np.radians(np.arange(-180.0, 180.01, 0.25))
    hollow = np.where(np.abs(angle) < half, 2e-3 * np.cos(0.5 * np.pi * angle / half) ** 2, 0.0)
    wheels = scene(mtb.WheelSlices.out_of_round(flat(), angle, -hollow), cylinder(), force).prepare()
    (patch,) = wheels.step((0.0, 0.0, np.nan, 0.0, 0.0, 0.0), 10.0).patches
    along = patch.pressure.sum(0)
    middle = along.size // 2
    assert patch.normal_force == pytest.approx(force, rel=1e-6)
    assert along[middle] == 0.0
    assert along[:middle].sum() == pytest.approx(along[middle:].sum(), rel=1e-2)


def test_a_rail_that_rises_between_its_sections_is_a_smaller_wheel() -> None:
    """The spline goes beyond the sections: on its top the bend of the rail adds to that of the wheel."""
    places = [-1.0, -0.5, -0.2, 0.0, 0.2, 0.5, 1.0]
    rail = mtb.RailSlices.uneven("60E1", places, [0.0, 0.0, 0.0, -3e-4, 0.0, 0.0, 0.0])
    x = np.linspace(-0.5, -0.2, 3001)
    rises = np.array([float(rail.departure(at, 0.0)) for at in x])
    top = int(rises.argmax())
    assert rises[top] > 5e-5
    bent = -(rises[top + 50] - 2.0 * rises[top] + rises[top - 50]) / (x[50] - x[0]) ** 2
    # upright, so that what rises does so straight up
    given: dict[str, Any] = {"lateral": 0.0, "force": 20e3, "spacing": 1e-3, "rail_inclination": 0.0}
    wheels = mtb.scenes.wheel_on_rail(rail=rail, **given).prepare()
    smaller = mtb.scenes.wheel_on_rail(wheel_radius=1.0 / (1.0 / 0.46 + bent), **given).prepare()
    for depth in (2e-5, 5e-5, 1e-4):
        (found,) = wheels.step([x[top], 0.0, rises[top] - depth, 0.0, 0.0, 0.0], 20.0).patches
        (wanted,) = smaller.step([0.0, 0.0, -depth, 0.0, 0.0, 0.0], 20.0).patches
        assert found.normal_force == pytest.approx(wanted.normal_force, rel=1e-5)
        assert found.pressure.max() == pytest.approx(wanted.pressure.max(), rel=1e-5)
    # a height is found at all places, on the way up and down as well
    for at in np.linspace(-0.6, 0.6, 25):
        assert wheels.step([at, 0.0, np.nan, 0.0, 0.0, 0.0], 20.0).force[2] == pytest.approx(-20e3, rel=1e-6)


def test_sections_that_are_the_nominal_profile_change_nothing() -> None:
    angles = np.linspace(-np.pi, np.pi, 25)[:-1]
    sliced = mtb.WheelSlices(angles, ["S1002"] * 24)
    rail = mtb.RailSlices([-1.0, 0.0, 1.0], ["60E1"] * 3)
    pose = (0.002, 0.001, np.nan, 0.0, 0.7, 0.003)
    made = [
        mtb.scenes.wheel_on_rail(wheel, on, lateral=0.0, force=80e3, spacing=5e-4).prepare()
        for wheel, on in (("S1002", "60E1"), (sliced, rail))
    ]
    exact, found = (wheels.step(pose, 20.0) for wheels in made)
    assert found.pose[2] == pytest.approx(exact.pose[2], abs=2e-8)
    np.testing.assert_allclose(found.force, exact.force, atol=80.0)
    (patch,), (reference,) = found.patches, exact.patches
    assert patch.pressure.max() == pytest.approx(reference.pressure.max(), rel=2e-3)
    assert patch.rail_position == pytest.approx(reference.rail_position, abs=2e-5)


def test_wheels_with_slices_are_kept_and_taken_again(tmp_path: Path) -> None:
    wheels = scene(flat_wheel(0.25e-3, 0.07), mtb.RailSlices.uneven(cylinder(), [0, 0.1], [0, 0])).prepare()
    pose = (0.0, 0.0, np.nan, 0.0, 0.02, 0.0)
    first = wheels.copy().step(pose, 2.0)
    wheels.save(tmp_path / "wheels.mtb")
    for other in (mtb.PreparedWheels.load(tmp_path / "wheels.mtb"), pickle.loads(pickle.dumps(wheels))):
        again = other.step(pose, 2.0)
        np.testing.assert_array_equal(again.patches[0].pressure, first.patches[0].pressure)
    # by what they are, as scenes are
    same = pickle.loads(pickle.dumps(flat_wheel(0.25e-3, 0.07)))
    assert same == flat_wheel(0.25e-3, 0.07) != flat_wheel(0.26e-3, 0.07)


def test_what_slices_do_not_have_is_refused_by_name() -> None:
    wheel = flat_wheel(0.25e-3, 0.07)
    of = scene(wheel, cylinder())
    with pytest.raises(ValueError, match="solved in steps"):
        of.solve()
    for refused in (
        lambda: mtb.wheel_on_rail_gap(wheel, "60E1"),
        lambda: mtb.wheelset_geometry(wheel),
        lambda: mtb.scenes.wheel_on_rail("S1002", wheel),
        lambda: mtb.scenes.pole_shoe_on_rail(rail=mtb.RailSlices.uneven("60E1", [0, 1], [0, 0])),
    ):
        with pytest.raises(ValueError, match=r"WheelSlices|RailSlices"):
            refused()


def test_lists_of_sections_are_read(tmp_path: Path) -> None:
    y = np.linspace(-0.03, 0.03, 301)
    for k, depth in enumerate((0.0, 0.4e-3, 0.1e-3, 0.0)):
        profile = mtb.Profile.from_points(y, mtb.Profile.standard("60E1").height(y) - depth)
        profile.to_file(tmp_path / f"s{k}.prr", y)
    rows = "\n".join(f"{10.0 * k} 's{k}.prr'  % section {k}" for k in range(4))
    header = "5.0 1.0 S_OFFSET, S_SCALE\n4 NSLC\n0 0 0 NFEAT, NKINK, NACCEL\n1 S_METHOD\n"
    path = tmp_path / "dip.slcs"
    path.write_text(f"% a dip\n{header}\n{rows}\n")
    rail = mtb.RailSlices.from_file(path, unit="mm")
    np.testing.assert_allclose(rail.positions, [0.005, 0.015, 0.025, 0.035])
    np.testing.assert_allclose(rail.departure([0.015, 0.025], 0.01), [-0.4e-3, -0.1e-3], atol=1e-9)
    # features by their length along the sections
    lengths = "\n".join(f"{10.0 * k} 0.0 30.0 1000.0" for k in range(4))
    path.write_text(f"{header.replace('0 0 0', '3 0 0')}{rows}\n{lengths}\n")
    again = mtb.RailSlices.from_file(path, unit="mm")
    np.testing.assert_allclose(again.departure(0.015, [0.0, 0.01]), -0.4e-3, atol=2e-6)
    for wrong, message in (
        (f"{header}{rows[:20]}", "names 1 sections and states 4"),
        (f"{header}{rows.replace(chr(39), '')}", "in quotes"),
        (
            f"{header.replace('0 0 0', '3 0 0')}{rows}\n{lengths.replace(' 30.0 ', ' -1 ')}",
            "leaves out a feature",
        ),
        ("1 2\n", "before its header"),
    ):
        path.write_text(wrong)
        with pytest.raises(ValueError, match=message):
            mtb.RailSlices.from_file(path, unit="mm")


def test_what_a_list_of_sections_states_is_taken_or_told(tmp_path: Path) -> None:
    y = np.linspace(-0.03, 0.03, 301)
    (tmp_path / "own").mkdir()
    for k, depth in enumerate((0.0, 0.4e-3, 0.1e-3, 0.0)):
        profile = mtb.Profile.from_points(y, mtb.Profile.standard("60E1").height(y) - depth)
        profile.to_file(tmp_path / "own" / f"s{k}.prr", y)
    rows = "\n".join(f"{10.0 * k} 'own\\s{k}.prr'  ! section {k}" for k in range(4))
    lengths = "\n".join(f"{10.0 * k} 0.0 20.0 30.0 1000.0" for k in range(4))
    path = tmp_path / "dip.slcs"

    def read(counts: str, method: str, between: str = "") -> tuple[mtb.RailSlices, str]:
        path.write_text(f"! a dip\n5.0 1.0 ! offset\n4\n{counts}\n{method}\n{rows}\n{between}{lengths}\n")
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            found = mtb.RailSlices.from_file(path, unit="mm")
        return found, " ".join(str(one.message) for one in caught)

    plain, told = read("4 0 0 NFEAT, NKINK, NACCEL", "1 S_METHOD")
    assert not told
    assert plain.departure(0.015, 0.01) == pytest.approx(-0.4e-3, abs=2e-6)
    for counts, method, between, words in (
        ("4 1 0", "1", "1 % P_KINK\n", "kinks or bends between its parts (1 and 0)"),
        ("4 1 2", "1", "1\n1 2\n", "(1 and 2)"),
        ("4 0 1", "1", "2\n", "(0 and 1)"),
        ("4", "2", "", "approximated by a spline"),
    ):
        found, told = read(counts, method, between)
        assert words in told
        places = np.linspace(0.005, 0.035, 7)
        np.testing.assert_array_equal(found.departure(places, 0.01), plain.departure(places, 0.01))
    for counts, method, words in (
        ("4", "3 S_METHOD", "line 5 is '3 S_METHOD': how the sections are joined"),
        ("-1 0", "1", "line 4 is '-1 0': a count"),
    ):
        with pytest.raises(ValueError, match=words):
            read(counts, method)


def test_slices_are_drawn() -> None:
    figure = flat_wheel(0.25e-3, 0.07).plot()
    assert "721 sections" in figure.axes[0].get_title(loc="left") or figure.axes[0].get_title(loc="left")


def test_features_carry_shapes_aside() -> None:
    # a corner that moves aside by 4 mm over the length
    def corner(at: float) -> mtb.Profile:
        return mtb.Profile.from_points([-0.03, at, 0.03], [0.0, 0.0, -0.5 * (0.03 - at)], "linear")

    s = np.linspace(0.0, 0.4, 5)
    rail = mtb.RailSlices(s, [corner(0.01 * at) for at in s], features=0.01 * s[:, None])
    found = rail.height(0.13, [0.0012, 0.0014, 0.02])
    np.testing.assert_allclose(found, -0.5 * np.clip([-1e-4, 1e-4, 0.0187], 0.0, None), atol=1e-9)


def test_gaps_of_numbers_are_refused() -> None:
    for message, refused in (
        ("at least 4", lambda: mtb.WheelSlices([0.0, 1.0, 2.0], ["S1002"] * 3)),
        ("must rise", lambda: mtb.RailSlices([0.0, 0.0], ["60E1"] * 2)),
        ("once", lambda: mtb.WheelSlices([0.0, 2.0, 4.0, 8.0], ["S1002"] * 4)),
        ("one for each", lambda: mtb.RailSlices([0.0, 1.0], ["60E1"] * 3)),
        ("features", lambda: mtb.RailSlices([0.0, 1.0], ["60E1"] * 2, features=[0.0, 1.0])),
        ("sequence", lambda: mtb.RailSlices([0.0, 1.0], "60E1")),  # type: ignore[arg-type]
    ):
        with pytest.raises(ValueError, match=message):
            refused()


def test_wrong_slices_are_told(tmp_path: Path) -> None:
    angles = np.linspace(-np.pi, np.pi, 9)
    with pytest.raises(ValueError, match=r"departure\[0\] is -0.46 m"):
        mtb.WheelSlices.out_of_round("S1002", angles, np.full(9, -0.46))
    with pytest.raises(ValueError, match=r"angles has shape \(3, 3\)"):
        mtb.WheelSlices(angles.reshape(3, 3), ["S1002"] * 9)
    with pytest.raises(ValueError, match="profiles is 5: a sequence"):
        mtb.WheelSlices(angles, 5)  # type: ignore[arg-type]
    rows = "".join(f"{100 * k} 'rail.prr'\n" for k in range(5))
    for count, said in (("2.7", "a whole number"), ("-1", "a whole number"), ("4", "names a further one")):
        (tmp_path / "list.slcs").write_text(f"0 1\n{count}\n0\n1\n{rows}")
        with pytest.raises(ValueError, match=f"list.slcs.*{said}"):
            mtb.RailSlices.from_file(tmp_path / "list.slcs")


def test_a_turn_that_closes_but_for_the_digits_of_its_scale_keeps_all_sections(tmp_path):
    """One turn in degrees whose last section is the first again, and a list that repeats sections beyond."""
    profile = mtb.Profile.standard("S1002")
    y = np.linspace(*profile.range, 300)
    flat = mtb.Profile.from_points(y, profile.height(y) + 5e-4)
    for name, of in (("round", profile), ("flat", flat)):
        of.to_file(tmp_path / f"{name}.csv")

    def read(degrees, scale):
        rows = [f"{d} '{'flat' if d % 360 == 270 else 'round'}.csv'" for d in degrees]
        head = [f"0.0 {scale}", f"{len(rows)} 0", "0", "1"]
        path = tmp_path / "wheel.slcw"
        path.write_text("\n".join([*head, *rows, ""]))
        return mtb.WheelSlices.from_file(path)

    for degrees, scale in (
        (range(0, 361, 5), "0.0174533"),
        (range(0, 361, 5), repr(np.pi / 180.0)),
        (range(0, 360, 5), "0.0174533"),
        (range(-200, 205, 5), repr(np.pi / 180.0)),
    ):
        wheel = read(degrees, scale)
        assert 72 <= wheel.positions.size <= 73
        assert wheel.departure(-0.5 * np.pi, 0.0) == pytest.approx(-5e-4, rel=1e-3)


def test_a_list_around_a_wheel_goes_around_it_once(tmp_path: Path) -> None:
    """Degrees without their scale, short last gaps, repeated sections that are others: kept, or refused."""
    profile = mtb.Profile.standard("S1002")
    y = np.linspace(*profile.range, 300)
    for name, off in (("round", 0.0), ("flat", 5e-4)):
        mtb.Profile.from_points(y, profile.height(y) + off).to_file(tmp_path / f"{name}.csv")
    path = tmp_path / "wheel.slcw"

    def read(angles: Any, flats: Any = (), scale: float = 1.0) -> tuple[mtb.WheelSlices, list[str]]:
        rows = [f"{a!r} '{'flat' if k in flats else 'round'}.csv'" for k, a in enumerate(angles)]
        path.write_text("\n".join([f"0.0 {scale!r}", f"{len(rows)} 0", "0", "1", *rows, ""]))
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            found = mtb.WheelSlices.from_file(path)
        return found, [str(one.message) for one in caught]

    # a gap before the turn is closed that is shorter than the others stays as it is
    short = [0.0, 1.2, 2.4, 3.6, 4.8, 6.0]
    wheel, told = read(short, flats=[5])
    np.testing.assert_array_equal(wheel.positions, short)
    assert not told
    assert wheel.departure(6.0, 0.0) == pytest.approx(-5e-4, abs=1e-9)
    for degrees in (range(360), range(-180, 181, 2), [0, 90, 180, 270], range(0, 360, 2)):
        with pytest.raises(ValueError, match=r"wheel.slcw.*its angles go from .*in degrees the scale"):
            read([float(d) for d in degrees])
        kept, told = read([float(d) for d in degrees], scale=0.01745329252)
        assert not told
        assert kept.positions.size == len(degrees)
    turned = np.radians(np.arange(-200.0, 201.0, 10.0))
    kept, told = read(turned.tolist(), flats=[38, 2])  # 180 and -180 degrees, one place
    assert not told
    # departures are those from the first section, which is flat
    assert kept.departure(np.radians([180.0, 0.0]), 0.0) == pytest.approx([0.0, 5e-4], abs=1e-9)
    with pytest.raises(ValueError, match="a turn away"):
        read(turned.tolist(), flats=[38])
    _, told = read([-3.3, -2.0, -1.0, 0.0, 1.0, 2.0, 3.1, 3.2])
    assert any("beyond one turn" in words for words in told)
    for scale in (0.0, -1.0):
        with pytest.raises(ValueError, match=r"line 1 is .*the scale"):
            read(short, scale=scale)
    path.write_text("0 1\n2\n0\n1\n0 'round.csv'\n1 'none.csv'\n")
    with pytest.raises(ValueError, match=r"wheel.slcw.*the section 'none.csv'"):
        mtb.WheelSlices.from_file(path)


def test_stretches_of_track_in_other_units_are_asked_about() -> None:
    for places, is_asked in (([0.0, 1e-4], True), ([0.0, 1e6], True), ([0.0, 0.1], False)):
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            mtb.RailSlices.uneven("60E1", places, [0.0, 0.0])
            mtb.RailSlices(places, ["60E1"] * 2)
        assert any("are they in metres" in str(one.message) for one in caught) == is_asked


@pytest.mark.parametrize("is_near", [False, True])
def test_a_spline_that_swings_beside_a_step_is_asked_about(is_near: bool) -> None:
    """A step of 0.2 mm between sections 2 mm apart, with the others at 100 mm or as near."""
    rail = mtb.Profile.standard("60E1")
    far = np.array([3.0, 5.0, 7.0]) * 1e-3 if is_near else np.array([0.1, 0.2, 0.3])
    places = np.concatenate([-far[::-1], [-1e-3, 1e-3], far])
    heights = -0.2e-3 * (places > 0.0)
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        slices = mtb.RailSlices.uneven(rail, places, heights)
    along = np.linspace(places[0], places[-1], 2001)
    swing = float(
        np.abs(slices.height(along, 0.0) - np.clip(slices.height(along, 0.0), heights.min(), 0.0)).max()
    )
    assert bool(told) == (swing > 0.2e-3)
    assert bool(told) != is_near
