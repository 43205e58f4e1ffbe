# SPDX-License-Identifier: MIT OR Apache-2.0
"""Profiles against their drawings, against quadrature, and through files."""

from __future__ import annotations

import pickle
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.interpolate import CubicSpline

from mtb_rs.geometry.profiles import Profile

RAIL = Profile.standard("60E1")
WHEEL = Profile.standard("S1002")
#: depths of S1002 [mm] at y [mm]: tip of the flange, tape circle, two points of the cone of EN 13715
TREAD = {-55.0: 28.0, 0.0: 0.0, 40.0: 1.364323640 - 0.066666667 * 40, 60.0: 1.364323640 - 0.066666667 * 60}


def test_rail_has_the_width_and_depth_of_its_drawing() -> None:
    start, end = RAIL.range
    assert end == pytest.approx(36.000e-3, abs=5e-7)
    assert start == -end
    assert RAIL.height(end) == pytest.approx(-14.300e-3, abs=5e-7)
    assert RAIL.slope(end) == pytest.approx(-20.0, abs=1e-6)


@pytest.mark.parametrize(("y", "down"), TREAD.items())
def test_wheel_tread(y: float, down: float) -> None:
    assert WHEEL.height(y * 1e-3) == pytest.approx(-down * 1e-3, abs=1e-12)


@pytest.mark.parametrize("profile", [RAIL, WHEEL], ids=["rail", "wheel"])
def test_arc_length_is_the_integral(profile: Profile) -> None:
    for y in (-0.033, -0.02, 0.004, 0.03):
        inner = [b for b in profile.breaks if min(y, 0.0) < b < max(y, 0.0)]
        exact, _ = quad(lambda v: np.hypot(1.0, profile.slope(v)), 0.0, y, points=inner or None, epsabs=1e-13)
        assert profile.arc_length(y) == pytest.approx(exact, abs=1e-12)
        assert profile.position(profile.arc_length(y)) == pytest.approx(y, abs=1e-14)


def test_normals_and_curvatures() -> None:
    y = np.linspace(-0.035, 0.035, 71)
    normal, slope = RAIL.normal(y), RAIL.slope(y)
    assert np.allclose(np.hypot(*normal), 1.0, atol=1e-15)
    assert np.allclose(normal[0] + slope * normal[1], 0.0, atol=1e-15)
    radii = np.unique(np.round(-1.0 / RAIL.curvature(y), 9))
    assert radii.tolist() == [0.013, 0.08, 0.3]


def test_smooth_table_is_the_not_a_knot_spline() -> None:
    y = np.sort(np.random.default_rng(1).uniform(-0.03, 0.03, 40))
    z = RAIL.height(y)
    points = np.linspace(y[0], y[-1], 500)
    assert np.allclose(Profile.from_points(y, z).height(points), CubicSpline(y, z)(points), atol=1e-15)
    lines = Profile.from_points(y[::-1], z[::-1], "linear")
    assert np.allclose(lines.height(points), np.interp(points, y, z), atol=1e-17)


def test_shapes_are_kept() -> None:
    assert RAIL.height(0.01).shape == ()
    assert RAIL.height(np.zeros((2, 3))).shape == (2, 3)
    assert RAIL.normal(np.zeros((2, 3))).shape == (2, 2, 3)
    assert RAIL.height([]).shape == (0,)


def test_files_and_pickles(tmp_path: Path) -> None:
    y = np.linspace(-30.0, 30.0, 121)
    inner = y[1:-1] * 1e-3
    z = RAIL.height(y * 1e-3) * 1e3
    plain = tmp_path / "rail.csv"
    np.savetxt(plain, np.column_stack([y, -z]), delimiter=",", header="y, z down")
    framed = tmp_path / "rail.prr"
    rows = "\n".join(f"{a:.9e} {b:.9e} 1.0" for a, b in zip(y / 25.4, z / 25.4, strict=True))
    framed.write_text(
        "header.begin\nversion = 1\nheader.end\nspline.begin\nunits.len.f = 39.37007874015748\n"
        f"bound.y.min = 1\nbound.y.max = 0\npoint.begin\n{rows}\npoint.end\nspline.end\n"
    )
    for path in (plain, framed):
        profile = Profile.from_file(path)
        assert np.allclose(profile.height(inner), RAIL.height(inner), atol=2e-9)
        again = pickle.loads(pickle.dumps(profile))
        assert np.array_equal(again.height(inner), profile.height(inner))
    for profile in (RAIL, Profile.from_points([0, 1], [0, 1], "linear")):
        again = pickle.loads(pickle.dumps(profile))
        assert again.height(0.01) == profile.height(0.01)


def test_bad_profiles_are_named(tmp_path: Path) -> None:
    def message(*arguments: object, **options: object) -> str:
        with pytest.raises(ValueError) as caught:  # noqa: PT011
            Profile.from_points(*arguments, **options)  # type: ignore[arg-type]
        return str(caught.value)

    assert "at least 2 points" in message([0.0], [0.0])
    assert "z[1] is inf" in message([0.0, 1.0], [0.0, np.inf])
    assert "row 3" in message([0.0, 1.0, 0.5], [0.0, 0.0, 0.0])
    assert "cubic" in message([0.0, 1.0], [0.0, 0.0], "cubic")
    assert "y and z have shapes" in message([[0.0, 1.0]], [[0.0, 0.0]])
    assert "real numbers" in message(["a", "b"], [0.0, 0.0])
    with pytest.raises(ValueError, match="60E1, S1002"):
        Profile.standard("54E1")
    with pytest.raises(ValueError, match=r"y\[1\] is 0.05 m: the profile reaches from -0.036"):
        RAIL.height([0.0, 0.05])
    with pytest.raises(ValueError, match=r"missing\.prr"):
        Profile.from_file(tmp_path / "missing.prr")
    binary = tmp_path / "binary.prw"
    binary.write_bytes(b"\xff\xfe\x00\x01")
    with pytest.raises(ValueError, match="cannot be read"):
        Profile.from_file(binary)
    words = tmp_path / "words.txt"
    words.write_text("y z\n0 0\nup down\n")
    with pytest.raises(ValueError, match=r"words.txt.*line 3"):
        Profile.from_file(words)
    with pytest.raises(ValueError, match="unit is 'cm'"):
        Profile.from_file(words, unit="cm")


def test_the_heading_of_a_file_counts(tmp_path: Path) -> None:
    path = tmp_path / "rail.csv"
    y = np.linspace(-30.0, 30.0, 121)
    inner = y[1:-1] * 1e-3
    z = RAIL.height(y * 1e-3) * 1e3
    for heading, columns in (
        ("y [m],z [m]", (y * 1e-3, z * 1e-3)),
        ("z_um,y (mm)", (z * 1e3, y)),
        ("station;z/mm;y/mm", (np.arange(y.size), z, y)),
        ("y,z\nm,m", (y * 1e-3, z * 1e-3)),
    ):
        sign = ";" if ";" in heading else ","
        np.savetxt(path, np.column_stack(columns), delimiter=sign, header=heading, comments="")
        # the heading says more than the argument
        profile = Profile.from_file(path, unit="in")
        assert np.allclose(profile.height(inner), RAIL.height(inner), atol=2e-9), heading
    for heading, words in (("y [mm],z", "state both"), ("y [furlong],z", "known are m"), ("a,b", "name")):
        path.write_text(f"{heading}\n0,0\n1,1\n", encoding="utf-8")
        with pytest.raises(ValueError, match=words):
            Profile.from_file(path)


@pytest.mark.parametrize(("scale", "unit"), [(1e-3, "mm"), (1.0, "m"), (1e3, "mm")])
def test_a_width_that_no_rail_has_is_questioned_at_its_file(tmp_path: Path, scale: float, unit: str) -> None:
    path = tmp_path / "rail.txt"
    y = np.linspace(-36.0, 36.0, 41)
    np.savetxt(path, scale * np.column_stack([y, -(y**2) / 600.0]))
    with pytest.warns(UserWarning, match=r"rail\.txt.*the width of the profile is .* is usual") as caught:
        profile = Profile.from_file(path, unit=unit)
    assert caught[0].filename == __file__
    assert np.ptp(profile.range) == pytest.approx(72.0 * scale * {"m": 1.0, "mm": 1e-3}[unit])
    pickle.loads(pickle.dumps(profile))
