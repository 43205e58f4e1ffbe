# SPDX-License-Identifier: MIT OR Apache-2.0
"""What is asked of wheels on rails: lengths that no railway has, flanges, files that are no profiles."""

import inspect
from pathlib import Path

import numpy as np
import pytest

import mtb_rs as mtb
from mtb_rs.case import load_case

COARSE = {"spacing": 1e-3}


@pytest.mark.parametrize(
    ("name", "value", "message"),
    [
        ("wheel_radius", 4.6, r"wheel_radius is 4\.6 m: 0\.02 to 1\.5 m is usual, and lengths are in metres"),
        ("gauge_depth", 1e-3, r"gauge_depth is 0\.001 m"),
        ("flange_back", 1.44, r"flange_back is 1\.44 m and gauge 1\.435 m"),
    ],
)
def test_lengths_that_no_railway_has_are_questioned(name, value, message):
    given = {"lateral": 0.0, "spacing": 5e-3, name: value}
    if name == "flange_back":
        given["lateral"] = -0.04
    for ask in (mtb.wheel_on_rail_gap, mtb.scenes.wheel_on_rail):
        with pytest.warns(UserWarning, match=message) as caught:
            ask(**given)
        # once, and in the name of the caller
        assert [warning.filename for warning in caught] == [__file__]


def test_a_wheel_of_millimetres_is_questioned():
    with pytest.warns(UserWarning, match="wheel_radius is 460 m"):
        mtb.wheel_on_rail_gap(wheel_radius=460, spacing=5e-3)


def test_a_scene_takes_what_the_gap_takes():
    of_gap = inspect.signature(mtb.wheel_on_rail_gap).parameters
    of_scene = inspect.signature(mtb.scenes.wheel_on_rail).parameters
    assert set(of_gap) - set(of_scene) == {"approach", "contact_modulus", "scale"}
    for name in set(of_gap) & set(of_scene):
        assert of_gap[name].default == of_scene[name].default


def test_lengths_of_the_track_move_the_wheel(tmp_path):
    """Half of what the backs stand apart, or the whole distance of the tape circle, is a lateral shift."""
    shifted = mtb.scenes.wheel_on_rail(lateral=1e-3, **COARSE).geometry.placement
    case = tmp_path / "case.toml"
    for name, value in (("flange_back", 1.362), ("tape_circle", 71e-3), ("gauge", 1.433)):
        given = {name: value, "lateral": 0.0, **COARSE}
        placed = mtb.scenes.wheel_on_rail(**given).geometry.placement
        assert placed.contact_angle == pytest.approx(shifted.contact_angle, abs=1e-6)
        words = "\n".join(f"{key} = {number}" for key, number in given.items())
        case.write_text(f'scene = "wheel_on_rail"\n{words}\n')
        read = load_case(case).scene()
        assert isinstance(read, mtb.WheelScene)
        assert read.geometry.placement.contact_angle == placed.contact_angle
    # a gauge measured higher up on the face meets the rounding, so the rail comes nearer
    higher = mtb.scenes.wheel_on_rail(lateral=1e-3, gauge_depth=8e-3, **COARSE).geometry.placement
    assert abs(higher.rail_position - shifted.rail_position) > 1e-5
    # the wheels of steps stand on the same track
    step = mtb.scenes.wheel_on_rail(lateral=0.0, flange_back=1.362, **COARSE).prepare().step(velocity=10.0)
    other = mtb.scenes.wheel_on_rail(lateral=1e-3, **COARSE).prepare().step(velocity=10.0)
    assert step.patches[0].contact_angle == pytest.approx(other.patches[0].contact_angle, abs=1e-6)


@pytest.mark.coarse
@pytest.mark.filterwarnings("ignore:the peak pressure is")
def test_a_flange_in_contact_is_told():
    flange = mtb.scenes.wheel_on_rail(lateral=7e-3, force=75e3, spacing=5e-4)
    message = r"inclined by \d\d°, the normal force is \d{3}\.?\d? kN where the vertical one is 75 kN"
    with pytest.warns(UserWarning, match=message):
        flange.prepare()
    result = flange.solve()
    assert any("the flange is in contact" in words for words in result.left_out())
    assert "the flange is in contact" in str(result)
    tread = mtb.scenes.wheel_on_rail(lateral=0.0, force=75e3, spacing=2e-3)
    assert not tread.solve().report.omitted


@pytest.mark.parametrize("between", [";", "\t", " ; "])
def test_decimal_commas_between_semicolons_or_tabs_are_read(tmp_path: Path, between: str) -> None:
    y, z = np.linspace(-35.5, 35.0, 12), np.linspace(-35.5, 35.0, 12) ** 2 / 100.0
    found = []
    for name, comma in (("points.txt", "."), ("commas.txt", ",")):
        rows = [f"y [mm]{between}z [mm]"]
        rows += [f"{a:.2f}{between}{b:.3f}".replace(".", comma) for a, b in zip(y, z, strict=True)]
        (tmp_path / name).write_text("\n".join(rows))
        found.append(mtb.Profile.from_file(tmp_path / name, z_axis="up"))
    at = np.linspace(*found[0].range, 50)
    np.testing.assert_array_equal(found[1].height(at), found[0].height(at))


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (
            "0 -30 -20\n1 -29 -10\n2 -28 -5\n",
            r"line 1 of .* has 3 columns: two are needed, y and z, or",
        ),
        (
            "-30,5 -20,1\n-29,5 -10,2\n",
            "line 1 of .* has decimal commas: write decimal points",
        ),
        (
            "-30,5;-20.1\n-29,5;-10,2\n",
            "line 1 of .* has decimal commas: write decimal points",
        ),
        (
            "[FileInfo]\nProgramName=MiniProf\n-30.5 -20.1\n",
            "at least 2 points are needed",
        ),
        (
            "approx.smooth = 0.5\npoint.begin\n0 1\n1 2\npoint.end",
            "a file is read without smoothing; set it to 0",
        ),
    ],
)
def test_a_file_that_is_no_profile_says_what_to_do(text, message, tmp_path):
    path = tmp_path / "rail.txt"
    path.write_text(text)
    with pytest.raises(ValueError, match=message):
        mtb.Profile.from_file(path)


@pytest.mark.filterwarnings("ignore:profile file .* the width")
def test_columns_are_taken_by_name(tmp_path):
    path = tmp_path / "rail.csv"
    path.write_text("s_mm,y_mm,z_mm\n0,-30,-20\n10,-29,-10\n20,-28,-5\n")
    profile = mtb.Profile.from_file(path, "linear")
    assert profile.range == pytest.approx((-0.030, -0.028))
    assert profile.height(-0.029) == pytest.approx(-0.010)
