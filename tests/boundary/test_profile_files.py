# SPDX-License-Identifier: MIT OR Apache-2.0
"""Profiles as people have them: what is recognised and said, and files that are none."""

from __future__ import annotations

import pickle
import warnings
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

import mtb_rs as mtb

Array = NDArray[np.float64]
RAIL, WHEEL = mtb.Profile.standard("60E1"), mtb.Profile.standard("S1002")


def points(profile: mtb.Profile, low: float, high: float, n: int = 240) -> tuple[Array, Array]:
    """Points of a profile in millimetres."""
    y = np.linspace(low, high, n)
    return y, 1e3 * profile.height(1e-3 * y)


def rows(y: Array, z: Array, sign: str = " ") -> str:
    return "".join(f"{a:.6f}{sign}{b:.6f}\n" for a, b in zip(y, z, strict=True))


def check(profile: mtb.Profile, exact: mtb.Profile, y: tuple[float, float] = (-25.0, 25.0)) -> None:
    places = 1e-3 * np.linspace(*y, 60)
    assert np.abs(profile.height(places) - exact.height(places)).max() < 2e-6


Write = Callable[[str, str], Path]


@pytest.fixture
def write(tmp_path: Path) -> Write:
    def written(name: str, text: str) -> Path:
        path = tmp_path / name
        path.write_text(text, encoding="utf-8")
        return path

    return written


@pytest.fixture(autouse=True)
def _no_other_warning() -> None:
    warnings.simplefilter("error")


def test_miniprof_files_of_rails_and_wheels_are_read(write: Write) -> None:
    for name, exact, (low, high) in (("a.ban", RAIL, (-35.5, 35.5)), ("b.whl", WHEEL, (-60.0, 55.0))):
        y, z = points(exact, low, high)
        header = f"ProgramName=MiniProf Windows\nProgramVer=2.4\nXYPoints={y.size}\nColumnDef=X,Y,A\n\n"
        text = header + "".join(f"{a:.6f}\t{b:.6f}\t0.1\n" for a, b in zip(y, z, strict=True))
        profile = mtb.Profile.from_file(write(name, text))
        check(profile, exact)
        assert pickle.loads(pickle.dumps(profile)) == profile
        # z down and y falling are recognised as well
        turned = header + "".join(f"{a:.6f}\t{-b:.6f}\t0.1\n" for a, b in zip(y[::-1], z[::-1], strict=True))
        check(mtb.Profile.from_file(write(name, turned)), exact)


@pytest.mark.parametrize("end", ["\r\n", "\r"])
def test_lines_may_end_as_on_other_systems(tmp_path: Path, end: str) -> None:
    y, z = points(RAIL, -35.5, 35.5)
    (tmp_path / "rail.prr").write_bytes(rows(y, z).replace("\n", end).encode())
    check(mtb.Profile.from_file(tmp_path / "rail.prr"), RAIL)


def test_a_hole_and_a_single_point_that_stands_out_are_asked_about(write: Write) -> None:
    y, z = points(RAIL, -35.5, 35.5)
    kept = (y < 4.0) | (y > 12.0)
    with pytest.warns(UserWarning, match=r"no point lies between y = [34]\S* and 12\S* mm"):
        mtb.Profile.from_file(write("hole.prr", rows(y[kept], z[kept])))
    dirty = z.copy()
    dirty[140] += 2.0
    with pytest.warns(UserWarning, match=rf"the point at y = {y[140]:.4g} mm stands out .* by 1.99 mm"):
        mtb.Profile.from_file(write("dirt.prr", rows(y, dirty)))


def test_own_files_come_back(tmp_path: Path) -> None:
    WHEEL.to_file(tmp_path / "wheel.prw", 1e-3 * np.linspace(-60, 55, 800))
    check(mtb.Profile.from_file(tmp_path / "wheel.prw"), WHEEL)


def test_a_wavy_profile_comes_back_as_it_was(tmp_path: Path) -> None:
    y = np.linspace(-0.03, 0.03, 601)
    wavy = mtb.Profile.from_points(y, 0.02 * y + 3e-3 * np.cos(y / 8e-3))
    wavy.to_file(tmp_path / "wavy.prr")
    again = mtb.Profile.from_file(tmp_path / "wavy.prr", mirror=False)
    assert np.abs(again.height(y) - wavy.height(y)).max() < 1e-8


def test_a_width_in_metres_or_micrometres_is_recognised_and_said(write: Write) -> None:
    y, z = points(RAIL, -35.5, 35.5)
    for scale, name in ((1e-3, "m"), (1e3, "um")):
        text = "".join(f"{scale * a:.9g},{scale * b:.9g}\n" for a, b in zip(y, z, strict=True))
        path = write("rail.csv", text)
        with pytest.warns(UserWarning, match=f"without a unit, taken as {name}"):
            profile = mtb.Profile.from_file(path)
        check(profile, RAIL)
        check(mtb.Profile.from_file(path, unit=name), RAIL)  # type: ignore[arg-type]


def test_a_flange_on_the_other_side_is_mirrored_and_said(write: Write) -> None:
    y, z = points(WHEEL, -60.0, 55.0)
    path = write("wheel.txt", rows(-y, z))
    with pytest.warns(UserWarning, match="it is mirrored.*state mirror"):
        profile = mtb.Profile.from_file(path)
    check(profile, WHEEL)
    check(mtb.Profile.from_file(path, mirror=True), WHEEL)
    kept = mtb.Profile.from_file(path, mirror=False)
    assert kept.height(0.05) == pytest.approx(WHEEL.height(-0.05), abs=2e-6)
    with pytest.raises(ValueError, match="mirror is 1"):
        mtb.Profile.from_file(path, mirror=1)  # type: ignore[arg-type]


@pytest.mark.parametrize("per_unit", [10.0, 25.4])
def test_centimetres_and_inches_without_a_unit_are_asked_about(write: Write, per_unit: float) -> None:
    for profile, ends in ((RAIL, (-35.5, 35.5)), (WHEEL, (-60.0, 55.0))):
        y, z = points(profile, *ends)
        if np.ptp(y) / per_unit > 5.0:
            with pytest.warns(UserWarning, match="taken as mm, which is a toy's"):
                mtb.Profile.from_file(write("profile.txt", rows(y / per_unit, z / per_unit)))


def test_a_groove_on_the_other_side_is_asked_about(write: Write) -> None:
    y = np.linspace(-28.0, 40.0, 200)
    z = -np.where(y < 0.0, 9.3 * (y / 28.0) ** 2, 21.0 * np.sin(np.clip(y - 10.0, 0.0, 30.0) / 19.0) ** 2)
    path = write("grooved.txt", rows(y, z))
    with pytest.warns(UserWarning, match="is not guessed; state mirror"):
        mtb.Profile.from_file(path, z_axis="up")
    mtb.Profile.from_file(path, z_axis="up", mirror=True)


def test_columns_that_look_swapped_are_swapped_and_said(write: Write) -> None:
    y, z = points(RAIL, -35.5, 35.5)
    with pytest.warns(UserWarning, match="taken for z and y"):
        check(mtb.Profile.from_file(write("rail.txt", rows(z, y))), RAIL)
    # with a heading nothing is guessed
    check(mtb.Profile.from_file(write("rail.txt", "z y\n" + rows(z, y))), RAIL)
    with pytest.raises(ValueError, match="row"):
        mtb.Profile.from_file(write("rail.txt", "y z\n" + rows(z, y)))


def test_repeated_points_and_undercut_ends_are_left_out_and_said(write: Write) -> None:
    y, z = points(WHEEL, -60.0, 55.0)
    path = write("wheel.txt", rows(np.repeat(y, 2), np.repeat(z, 2)))
    with pytest.warns(UserWarning, match="240 of its points repeat"):
        check(mtb.Profile.from_file(path), WHEEL)
    # round the tip of the flange and up its back
    back = np.linspace(-59.9, -58.0, 12), np.linspace(-20.0, -5.0, 12)
    path = write("wheel.txt", rows(np.append(back[0][::-1], y), np.append(back[1][::-1], z)))
    with pytest.warns(UserWarning, match="undercut: the 12 points beyond are left out"):
        check(mtb.Profile.from_file(path), WHEEL)


def test_a_doubtful_direction_of_z_is_said(write: Write) -> None:
    y = np.linspace(-30.0, 30.0, 61)
    path = write("wave.txt", rows(y, np.sin(y / 5.0) + 0.05 * np.cos(y / 7.0)))
    with pytest.warns(UserWarning, match="is a guess; state z_axis"):
        mtb.Profile.from_file(path)
    mtb.Profile.from_file(path, z_axis="up")


def test_an_origin_beside_the_crown_is_said(write: Write) -> None:
    y, z = points(RAIL, -35.5, 35.5)
    with pytest.warns(UserWarning, match="is not between its ends"):
        mtb.Profile.from_file(write("rail.txt", rows(y + 40.0, z)))
    with pytest.warns(UserWarning, match="z slopes by"):
        mtb.Profile.from_file(write("rail.txt", rows(y + 33.0, z)))


HOSTILE = {
    "": "at least 2 points",
    "\n\n# nothing\n": "at least 2 points",
    "0 0\n": "at least 2 points",
    "1 1\n1 1\n1 1\n": "at least 2 points",
    "0 0\n1 nan\n2 0\n": "line 2",
    "0 0\n1 inf\n2 0\n": "line 2",
    "0 0 0\n1 1 1\n": "two are needed",
    "0 0\n1 0\n0.5 1\n2 0\n1 1\n3 2\n": "row",
    "0 0\n0 1\n0 2\n": "row 2",
    "ProgramName=MiniProf\nXYPoints=5\n\n0 0\n1 1\n": "XYPoints=5, and 2 rows",
    "ProgramName=MiniProf\n": "at least 2 points",
    "ProgramName=MiniProf\nXYPoints=many\n\n0 0\n1 1\n": "XYPoints=many",
    "point.begin\n0 0\n": "point.end",
    "3\n0.0 'a.prr'\n100.0 'b.prr'\n200 'c.prr'\n": "one of 3 sections along the track",
    '{"y": [0, 1]}': "at least 2 points",
    "1e400 0\n1 0\n2 0\n": "line 1",
    "1e200 0\n1 0\n2 0\n": "at most",
}


@pytest.mark.parametrize(("text", "words"), HOSTILE.items(), ids=range(len(HOSTILE)))
def test_files_that_are_no_profile_end_in_clear_words(write: Write, text: str, words: str) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        with pytest.raises(ValueError, match=words) as caught:
            mtb.Profile.from_file(write("file.prr", text))
    assert "file.prr" in str(caught.value)


def test_two_profiles_in_one_file_are_refused(write: Write) -> None:
    y, z = points(RAIL, -35.5, 35.5)
    for text in (rows(np.append(y, y), np.append(z, z)), rows(np.append(y, y[::-1]), np.append(z, z + 1.0))):
        with pytest.raises(ValueError, match="look like two profiles"):
            mtb.Profile.from_file(write("two.txt", text))
    part = f"XYPoints={y.size}\n{rows(y, z)}"
    with pytest.raises(ValueError, match="another header"):
        mtb.Profile.from_file(write("two.ban", part + part))


def test_binary_files_are_refused(tmp_path: Path) -> None:
    path = tmp_path / "binary.ban"
    path.write_bytes(bytes(range(256)) * 8)
    with pytest.raises(ValueError, match="cannot be read"):
        mtb.Profile.from_file(path)


def test_a_case_reads_profiles_with_the_same_words(write: Write, tmp_path: Path) -> None:
    y, z = points(WHEEL, -60.0, 55.0)
    text = "".join(f"{-1e-3 * a:.9f} {1e-3 * b:.9f}\n" for a, b in zip(y, z, strict=True))
    write("wheel.txt", text)
    case = write(
        "case.toml",
        'scene = "wheel_on_rail"\nspacing = 2e-4\n'
        'wheel = { file = "wheel.txt", unit = "m", mirror = true, wavelength = 4e-3 }\n',
    )
    wheel = dict(mtb.load_case(case).scene().geometry.arguments)["wheel"]  # type: ignore[attr-defined]
    check(wheel, WHEEL)
    assert wheel.smoothing.wavelength == 4e-3
