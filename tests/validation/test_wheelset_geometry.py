# SPDX-License-Identifier: MIT OR Apache-2.0
"""Wheelsets on rails: cones, circles, a brute-force search, and the reference results of EN 15302."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

import mtb_rs as mtb

Array = NDArray[np.float64]
DATA = Path(__file__).parents[1] / "data" / "conicity"
#: Half the distance of the tape circles and radius of the wheels [m].
HALF, RADIUS = 0.75, 0.46


def symmetric(values: Array) -> Array:
    """Values over shifts from 0 continued to negative shifts."""
    return np.concatenate([-values[:0:-1], values])


@pytest.mark.parametrize("case", ["e1", "e2"])
def test_conicities_of_en_15302_follow_from_its_differences_of_radii(case: str) -> None:
    difference = symmetric(1e-3 * np.loadtxt(DATA / f"{case}.txt"))
    half = difference.size // 2
    shift = 1e-4 * np.arange(-half, half + 1)
    amplitude, printed = np.loadtxt(DATA / f"{case}_conicity.txt").T
    found = mtb.equivalent_conicity(shift, difference, 1e-3 * amplitude)
    # both are printed to 0.001, and the standard allows 0.012 to 0.05
    assert np.abs(found - printed).max() < 6e-4
    if case == "e2":
        # the two methods differ where the difference jumps, so that the comparison tells them apart
        other = mtb.equivalent_conicity(shift, difference, 1e-3 * amplitude, "harmonic")
        assert np.abs(other - printed).max() > 0.02


def test_reference_profiles_have_the_differences_and_conicities_of_en_15302() -> None:
    """From the coordinates of wheel A and rail A to case E1 of annex E."""
    wheel, rail = (
        mtb.Profile.from_points(*(1e-3 * np.loadtxt(DATA / f"{name}_a.txt").T)) for name in ("wheel", "rail")
    )
    shifts = 1e-4 * np.arange(-65, 66)
    found = mtb.wheelset_geometry(wheel, rail, gauge=1.43516, rail_inclination=0.0, shifts=shifts)
    printed = 1e-3 * np.loadtxt(DATA / "e1.txt")
    # coordinates are printed to 0.001 mm, and on nearly conforming arcs the place of contact moves by far
    # more
    assert np.abs(found.radius_difference[65:] - printed[:66])[:60].max() < 0.2e-3
    amplitude, conicity = np.loadtxt(DATA / "e1_conicity.txt").T
    inner = amplitude < 6.5
    ours = found.equivalent_conicity(1e-3 * amplitude[inner])
    # the standard allows 0.05
    assert np.abs(ours - conicity[inner]).max() < 0.006
    # of 0.16 mm of gauge it would be ten times that
    wrong = mtb.wheelset_geometry(wheel, rail, gauge=1.435, rail_inclination=0.0, shifts=shifts)
    assert np.abs(wrong.equivalent_conicity(1e-3 * amplitude[inner]) - conicity[inner]).max() > 0.009


def cone(slope: float) -> mtb.Profile:
    return mtb.Profile.from_points([-0.06, 0.06], [-0.06 * slope, 0.06 * slope], "linear", "cone")


def arc(radius: float, centre: float = 0.0, half_width: float = 0.036) -> mtb.Profile:
    """An arc, convex upwards about y = centre, of height 0 at y = 0: a dense table of its exact heights."""
    y = np.linspace(-half_width, half_width, 1441)
    return mtb.Profile.from_points(y, np.sqrt(radius**2 - (y - centre) ** 2) - np.sqrt(radius**2 - centre**2))


def with_crown_at(rail: mtb.Profile, place: float) -> dict[str, float]:
    """A gauge at which the crown of a rail stands at a place of the track."""
    depth = 2e-3
    y = np.linspace(rail.range[0], 0.0, 100001)
    face = float(np.interp(-depth, rail.height(y), y))
    return {"gauge": 2.0 * (place + face), "gauge_depth": depth, "rail_inclination": 0.0}


@pytest.mark.parametrize("method", ["integration", "harmonic"])
@pytest.mark.parametrize("slope", [1 / 40, 1 / 20, 0.1])
def test_the_conicity_of_cones_is_their_angle(slope: float, method: str) -> None:
    rail = arc(0.3)
    shifts = np.linspace(-6e-3, 6e-3, 25)
    found = mtb.wheelset_geometry(cone(slope), rail, shifts=shifts, **with_crown_at(rail, HALF))
    assert np.allclose(found.radius_difference, 2.0 * slope * shifts, atol=1e-9)
    conicity = found.equivalent_conicity([1e-3, 3e-3, 5e-3], method)  # type: ignore[arg-type]
    assert np.allclose(conicity, slope, rtol=1e-5)
    assert np.allclose(np.tan(found.left.contact_angle), slope, atol=1e-6)
    # Klingel's wavelength
    assert found.wavelength(3e-3) == pytest.approx(2 * np.pi * np.sqrt(RADIUS * HALF / slope), rel=1e-5)


@pytest.mark.parametrize("axle", ["level", "free"])
def test_circles_on_circles_have_the_conicity_of_wickens(axle: str) -> None:
    """Wheels hollow by arcs on rails of arcs: [Wickens2003], with and without the roll of the axle."""
    wheel_radius, rail_radius, slope = 0.5, 0.3, 0.05
    sine = slope / np.hypot(1.0, slope)
    # the wheel slopes by `slope` at its tape circle, and the rail where it stands below that
    wheel, rail = arc(wheel_radius, centre=wheel_radius * sine), arc(rail_radius)
    shifts = np.linspace(-1e-4, 1e-4, 21)
    place = with_crown_at(rail, HALF + rail_radius * sine)
    found = mtb.wheelset_geometry(wheel, rail, shifts=shifts, axle=axle, **place)  # type: ignore[arg-type]
    wanted = slope * wheel_radius / (wheel_radius - rail_radius)
    if axle == "free":
        wanted *= (HALF + rail_radius * slope) / (HALF - RADIUS * slope)
    conicity = np.polyfit(shifts, found.radius_difference, 1)[0] / 2.0
    # the formula is linear in the slope
    assert conicity == pytest.approx(wanted, rel=3.0 * slope**2)


def lowest(profile: mtb.Profile, turn: float, n: int = 40001) -> Array:
    start, end = profile.range
    y = np.linspace(start, end, n)
    z = profile.height(y)
    return np.array([np.cos(turn) * y - np.sin(turn) * z, np.sin(turn) * y + np.cos(turn) * z])


@pytest.mark.parametrize("shift", [-7e-3, -6e-3, -1e-3, 0.0, 3.3e-3, 6.2e-3])
def test_a_free_wheelset_touches_both_rails_and_overlaps_neither(shift: float) -> None:
    """Against a search over dense points of both sections, which shares nothing with the finder."""
    found = mtb.wheelset_geometry(shifts=[shift], axle="free")
    rail = lowest(mtb.Profile.standard("60E1"), 1 / 40)
    rail[1] -= rail[1].max()
    crown = int(rail[1].argmax())
    inner = rail[:, : crown + 1]
    face = min(float(np.interp(-14e-3, inner[1], inner[0])), inner[0][inner[1] >= -14e-3].min())
    rail[0] += 1.435 / 2 - face
    wheel = mtb.Profile.standard("S1002")
    y = np.linspace(-0.06, 0.06, 200001)
    below = np.array([HALF + y, wheel.height(y) - RADIUS])
    roll, height = float(found.roll[0]), float(found.height[0])
    for side, sign in (("left", 1.0), ("right", -1.0)):
        turn = sign * roll
        across = np.cos(turn) * below[0] - np.sin(turn) * below[1] + sign * shift
        up = np.sin(turn) * below[0] + np.cos(turn) * below[1] + height
        gap = up - np.interp(across, *rail, left=-1.0, right=-1.0)
        own = getattr(found, side)
        assert gap.min() == pytest.approx(0.0, abs=1e-7)
        assert sign * own.y[0] == pytest.approx(across[gap.argmin()], abs=5e-5)
        assert own.rolling_radius[0] == pytest.approx(-below[1][gap.argmin()], abs=2e-5)
    assert abs(roll) < 1e-2


@pytest.mark.parametrize("shift", [-5e-3, 0.0, 4e-3, 6.2e-3])
def test_scenes_of_wheels_touch_where_a_level_wheelset_does(shift: float) -> None:
    found = mtb.wheelset_geometry(shifts=[shift])
    gap = mtb.wheel_on_rail_gap(lateral=shift, force=1e3)
    assert found.left.rail_position[0] == pytest.approx(gap.first_rail_position, abs=1e-7)
    wheels = mtb.scenes.wheel_on_rail(lateral=0.0, force=1e3, spacing=2e-4).prepare(side="left")
    # lowered by 1 um from where the wheelset first touches
    low = found.left.z[0] - float(mtb.Profile.standard("S1002").height(found.left.wheel_position[0]))
    first = mtb.wheel_on_rail_gap(lateral=0.0, force=1e3).undeformed_height
    step = wheels.step(pose=[0.0, shift, low - first - 1e-6, 0.0, 0.0, 0.0], velocity=10.0)
    patch = max(step.patches, key=lambda p: p.normal_force)
    assert patch.rail_position == pytest.approx(found.left.rail_position[0], abs=1.5e-4)


def test_a_cubic_difference_has_its_closed_forms_and_their_order() -> None:
    """k y^3: 3 k A^2 / 8 by the first harmonic, and by the wavelength (pi / (2 L))^2 k A^2, L the lemniscate
    constant 2.622057..."""
    stiffness, amplitude = 2e3, 4e-3
    lemniscate = 2.622057554292119
    wanted = {
        "harmonic": 3.0 * stiffness * amplitude**2 / 8.0,
        "integration": (np.pi / (2.0 * lemniscate)) ** 2 * stiffness * amplitude**2,
    }
    for method, exact in wanted.items():
        errors = []
        for count in (41, 81, 161):
            y = np.linspace(-5e-3, 5e-3, count)
            found = mtb.equivalent_conicity(y, stiffness * y**3, amplitude, method)  # type: ignore[arg-type]
            errors.append(abs(float(found) / exact - 1.0))
        rates = np.log2(np.array(errors[:-1]) / errors[1:])
        assert (rates > 1.8).all(), (method, errors)
        assert errors[-1] < 1e-3


@pytest.mark.parametrize("aside", [0.0, 1.3e-3])
def test_a_play_between_flanges_slows_the_motion(aside: float) -> None:
    """Straight across the play and half a wave about each of its ends, in closed form; the first harmonic."""
    y, slope, play = np.linspace(-8e-3, 8e-3, 161), 1.0, 5e-3
    difference = slope * (np.maximum(y - play, 0.0) + np.minimum(y + play, 0.0))
    amplitude = np.array([5.5e-3, 6e-3, 7.9e-3])
    found = {
        m: mtb.equivalent_conicity(y + aside, difference, amplitude, m)  # type: ignore[arg-type]
        for m in ("integration", "harmonic")
    }
    root = np.sqrt(slope)
    quarter = 0.5 * np.pi / root + play / ((amplitude - play) * root)
    np.testing.assert_allclose(found["integration"], 0.5 * (0.5 * np.pi / quarter) ** 2, rtol=1e-6)
    turn = (np.arange(200_000) + 0.5) * 2.0 * np.pi / 200_000
    first = [(np.interp(a * np.sin(turn), y, difference) * np.sin(turn)).mean() / a for a in amplitude]
    np.testing.assert_allclose(found["harmonic"], first, rtol=1e-5)
    # nothing turns the wheelset within the play
    for method in ("integration", "harmonic"):
        inside = mtb.equivalent_conicity(y + aside, difference, 3e-3, method)  # type: ignore[arg-type]
        assert inside == pytest.approx(0.0, abs=1e-12)
    # a difference that only touches zero from one side has no middle
    with pytest.raises(ValueError, match="never passes zero rising"):
        mtb.equivalent_conicity(y, np.maximum(np.abs(y) - play, 0.0))


def test_wheels_of_different_radii_run_beside_the_middle() -> None:
    shifts = 1e-4 * np.arange(-70, 71)
    slope = 0.1
    rail = arc(0.3)
    both = mtb.wheelset_geometry(cone(slope), rail, shifts=shifts, **with_crown_at(rail, HALF))
    uneven = mtb.wheelset_geometry(
        (cone(slope), cone(slope)), (rail, rail), wheel_radius=(0.4602, 0.4598), shifts=shifts,
        **with_crown_at(rail, HALF),
    )  # fmt: skip
    # the larger wheel runs on its smaller part: 2 slope y = -0.4 mm
    middle = np.interp(0.0, uneven.radius_difference, shifts)
    assert middle == pytest.approx(-2e-3, abs=1e-8)
    assert uneven.equivalent_conicity(3e-3) == pytest.approx(both.equivalent_conicity(3e-3), rel=1e-6)
    mirrored = mtb.wheelset_geometry(
        cone(slope), rail, wheel_radius=(0.4598, 0.4602), shifts=shifts, **with_crown_at(rail, HALF)
    )
    assert np.allclose(mirrored.radius_difference, -uneven.radius_difference[::-1], atol=1e-12)


def test_what_cannot_be_is_named() -> None:
    y = np.linspace(-5e-3, 5e-3, 11)
    with pytest.raises(ValueError, match=r"amplitude is 0\.006 m: shift leaves 0\.005 m"):
        mtb.equivalent_conicity(y, 0.1 * y, 6e-3)
    with pytest.raises(ValueError, match="never passes zero rising"):
        mtb.equivalent_conicity(y, -0.1 * y)
    with pytest.raises(ValueError, match="one row each"):
        mtb.equivalent_conicity(y, y[1:])
    with pytest.raises(ValueError, match="does not rise"):
        mtb.equivalent_conicity(y[::-1], y)
    with pytest.raises(ValueError, match="positive numbers"):
        mtb.equivalent_conicity(y, y, 0.0)
    with pytest.raises(ValueError, match="positive numbers"):
        mtb.klingel_wavelength(-0.1)
    with pytest.raises(ValueError, match=r"at a lateral shift of 0\.09 m: .*(end of the|nowhere)"):
        mtb.wheelset_geometry(shifts=[0.0, 0.09])
    with pytest.raises(ValueError, match="rising lateral shifts"):
        mtb.wheelset_geometry(shifts=[0.0, 0.0])
    with pytest.raises(ValueError, match="one each of left and right"):
        mtb.wheelset_geometry(wheel=("S1002", "S1002", "S1002"))
    with pytest.raises(ValueError, match="axle is 'rolling'"):
        mtb.wheelset_geometry(axle="rolling")  # type: ignore[arg-type]
    # negative conicity inside: no motion about one place, but a first harmonic
    cone_inside = 1e4 * y**3 - 0.05 * y
    with pytest.raises(ValueError, match="leaves"):
        mtb.equivalent_conicity(y, cone_inside, 3e-3)


def test_it_is_kept_drawn_and_exported(tmp_path: Path) -> None:
    found = mtb.wheelset_geometry(shifts=1e-3 * np.arange(-6, 7))
    found.save(tmp_path)
    again = mtb.load(tmp_path)
    assert again == found
    frame = found.to_pandas()
    assert frame.shape == (13, 16)
    assert frame.attrs["units"]["left_contact_angle"] == "rad"
    assert np.array_equal(frame["radius_difference"], found.radius_difference)
    data = found.to_xarray()
    assert data.sizes == {"shift": 13}
    assert (tmp_path / "wheelset_geometry.csv").read_text(encoding="utf-8").startswith("shift [m],height [m]")
    for quantity in (
        "contact_points",
        "radius_difference",
        "contact_angle",
        "rail_position",
        "wheel_position",
        "equivalent_conicity",
        "wavelength",
    ):
        assert found.plot(quantity).axes  # type: ignore[arg-type]
    assert found.plot(side="left").axes
    with pytest.raises(ValueError, match="without ax"):
        found.plot(ax=found.plot("contact_angle").axes[0])


@pytest.mark.parametrize("rail", ["60E1", "arc"])
@pytest.mark.parametrize("wheel", ["S1002", "broken line"])
def test_names_of_lines_touch_neither_the_wheel_nor_each_other(wheel: str, rail: str) -> None:
    made: dict[str, str | mtb.Profile] = {
        "S1002": "S1002",
        "60E1": "60E1",
        "broken line": mtb.Profile.from_points(
            [-0.055, -0.042, -0.036, 0.06], [-28e-3, -18e-3, -1.8e-3, 3e-3], "linear"
        ),
    }
    angle = np.radians(np.linspace(-80.0, 80.0, 801))
    made["arc"] = mtb.Profile.from_points(0.03 * np.sin(angle), 0.03 * (np.cos(angle) - 1.0))
    figure = mtb.wheelset_geometry(made[wheel], made[rail], rail_inclination=1 / 40).plot()
    figure.draw_without_rendering()
    for ax in figure.axes:
        boxes = [text.get_window_extent() for text in ax.texts]
        assert len(boxes) >= 3
        assert not any(a.overlaps(b) for k, a in enumerate(boxes) for b in boxes[:k])
        # drawn second, after the rail
        (x, y), inside = ax.transData.transform(ax.lines[1].get_xydata()).T, ax.get_window_extent()
        for box in boxes:
            assert not ((box.x0 < x) & (x < box.x1) & (box.y0 < y) & (y < box.y1)).any()
        # the figure is no higher than the profiles need
        blank = figure.bbox.height - ax.get_tightbbox().height
        assert inside.width > 0.4 * figure.bbox.width
        assert blank < 0.4 * figure.dpi
