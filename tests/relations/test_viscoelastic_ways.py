# SPDX-License-Identifier: MIT OR Apache-2.0
"""A body that creeps in each way of asking: solved by what rolls steadily, refused by name by the others."""

from __future__ import annotations

import json
import pickle
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import mtb_rs as mtb
from mtb_rs.bodies.mesh import block_mesh
from mtb_rs.case import case_from_words
from mtb_rs.commands import main
from mtb_rs.scenes.moving import Moving

RUBBER = mtb.Material(10e6, 0.49)
TREAD = mtb.Viscoelastic(RUBBER, 0.8, 2e-3)
#: A wheel of this one keeps to small deformations.
HARD = replace(TREAD, material=mtb.steel)
STEP = 0.5e-3
X = (np.arange(20) - 9.5) * STEP
GAP = (X[None, :] ** 2 + X[:, None] ** 2) / 0.2
ROLLING = mtb.Rolling(creepage=(3e-3, 2e-3, 0.3), velocity=2.0)
LAW = mtb.Coulomb(0.4)

pytestmark = pytest.mark.coarse


def normal(lower: Any = TREAD, **given: Any) -> mtb.NormalResult:
    asked = {"upper": mtb.Rigid(), "force": 1.0, "rolling": ROLLING} | given
    return mtb.solve_normal(GAP, STEP, lower=lower, **asked)


def rolled(**given: Any) -> mtb.TangentialResult:
    asked = {"normal": normal(), "motion": ROLLING, "friction": LAW} | given
    return mtb.solve_tangential(**asked)


SCENE = mtb.Scene(mtb.Rigid(), TREAD, gap=GAP, spacing=STEP, friction=0.4, force=1.0)


def swept(*columns: str, motion: Any = ROLLING, **changes: Any) -> list[float]:
    """Columns of a scene that rolls, one case of a sweep."""
    friction = [SCENE.friction]
    table = mtb.sweep(SCENE.with_(**changes), {"friction": friction}, motion=motion, tolerance=0.9)
    assert list(table.status) == ["solved"], table.status
    return [float(table[name][0]) for name in columns]


def of_case(body: mtb.Viscoelastic) -> mtb.TangentialResult:
    """A ball on a plane that rolls, by the words of a case file."""
    material = {"young_modulus": body.material.young_modulus, "poisson_ratio": body.material.poisson_ratio}
    words = {
        "scene": "paraboloid_on_plane",
        "force": 1.0,
        "radius": 0.1,
        "points": 24,
        "friction": 0.4,
        "upper": "rigid",
        "lower": {"material": material, "creep": body.creep, "creep_time": body.creep_time},
        "rolling": {"velocity": 2.0, "creepage": [3e-3, 2e-3, 0.3]},
        "solve": {"tolerance": 0.9},
    }
    return case_from_words(words).solve()  # type: ignore[return-value]


# --- what takes it ----------------------------------------------------------------------------------------

WAYS: dict[str, Callable[[Any], Any]] = {
    "force": lambda body: normal(body).pressure,
    "approach": lambda body: normal(body, force=None, approach=1e-4).pressure,
    "dense": lambda body: normal(body, method="dense").pressure,
    "fft": lambda body: normal(body, method="fft").pressure,
    "tilted": lambda body: normal(body, moments_about_axes=(0.0, 2e-4)).pressure,
    "layer": lambda body: normal(body, normal_layer=1e-12).pressure,
    "rough layer": lambda body: normal(body, normal_layer=mtb.RoughLayer.exponential(1e5, 1e-6)).pressure,
    "above": lambda body: normal(mtb.Rigid(), upper=body).pressure,
    "beside another": lambda body: normal(body, upper=replace(TREAD, creep_time=1e-4)).pressure,
    "beside a layer": lambda body: normal(body, upper=mtb.Layered(RUBBER, 1e-3, mtb.Rigid())).pressure,
    "another way": lambda body: normal(body, rolling=replace(ROLLING, angle=2.0)).pressure,
    "rolls": lambda body: rolled(normal=normal(body)).traction,
    "rolls by a force": lambda body: rolled(
        normal=normal(body), motion=replace(ROLLING, force=(0.1, None))
    ).creepage[:1],
    "rolls another way": lambda body: (
        rolled(
            normal=normal(body, rolling=replace(ROLLING, angle=2.0)), motion=replace(ROLLING, angle=2.0)
        ).traction
    ),
    "full coupling": lambda body: rolled(normal=normal(body), coupling="full").pressure,
    "a scene": lambda body: swept("peak_pressure", lower=body),
    "a scene's force": lambda body: swept("force_x", "force_y", lower=body),
    "a scene above": lambda body: swept("peak_pressure", lower=mtb.Rigid(), upper=body),
    "a scene of both": lambda body: swept("approach", upper=body, lower=body),
    "a scene with an approach": lambda body: swept("normal_force", lower=body, force=None, approach=1e-4),
    "a scene with moments": lambda body: swept("peak_pressure", lower=body, moments=(0.0, 2e-4)),
    "a scene with a layer": lambda body: swept("peak_pressure", lower=body, normal_layer=1e-12),
    "case file": lambda body: of_case(body).traction,
    "creep curve": lambda body: mtb.creep_curve(normal(body), [[1e-3, 0, 0]], LAW, velocity=2.0),
}


@pytest.mark.parametrize("way", WAYS.values(), ids=WAYS.keys())
def test_each_way_takes_it(way: Callable[[Any], Any]) -> None:
    soft, still, creeping, stiff = (
        np.asarray(way(body), dtype=float)
        for body in (replace(TREAD, creep_time=0.0), replace(TREAD, creep_time=1e-13), TREAD,
                     replace(TREAD, creep=0.0))
    )  # fmt: skip
    size = np.abs(stiff).max()
    # alike but for the solver's tolerance
    assert np.abs(soft - still).max() < 2e-5 * size
    assert np.abs(creeping - soft).max() > 1e-2 * size
    assert np.abs(creeping - stiff).max() > 1e-2 * size


def test_a_scene_that_rolls_is_its_two_contacts() -> None:
    for angle, layer, moments in ((0.0, 0.0, None), (0.7, 1e-12, None), (0.7, 0.0, (1e-4, 2e-4))):
        motion = replace(ROLLING, angle=angle)
        pressed = normal(
            rolling=motion, tolerance=1e-9, normal_layer=layer, moments_about_axes=moments or (None, None)
        )
        moved = mtb.solve_tangential(pressed, motion, LAW)
        found = swept(
            "peak_pressure", "approach", "rolling_resistance", "force_x", "force_y", "spin_moment",
            motion=motion, normal_layer=layer or None, moments=moments,
        )  # fmt: skip
        expected = [
            pressed.report.peak_pressure, pressed.approach, pressed.rolling_resistance,
            *moved.force[:2], moved.spin_moment,
        ]  # fmt: skip
        np.testing.assert_allclose(found, expected, rtol=2e-6)


def test_a_scene_that_rolls_follows_the_numbers_of_what_creeps() -> None:
    scene = Moving(SCENE, ROLLING).pressed()
    result = scene.solve(model="half-space")
    gradient = result.gradient("approach")
    for name in ("young_modulus", "poisson_ratio", "creep", "creep_time"):
        of_material = name in ("young_modulus", "poisson_ratio")
        own = getattr(RUBBER if of_material else TREAD, name)

        def approach(value: float, name: str = name, of_material: bool = of_material) -> float:
            changed = {"material": replace(RUBBER, **{name: value})} if of_material else {name: value}
            body: Any = replace(scene.lower, **changed)
            found = scene.with_(lower=body).solve(model="half-space").approach
            return float(found)

        wide, narrow = ((approach(own + h) - approach(own - h)) / (2.0 * h) for h in (2e-3 * own, 1e-3 * own))
        expected = (4.0 * narrow - wide) / 3.0
        assert result.derivative("approach", f"lower.{name}") == pytest.approx(expected, rel=1e-7), name
        assert gradient[f"lower.{name}"] == pytest.approx(expected, rel=1e-7), name
    at_once = Moving(SCENE.with_(lower=replace(TREAD, creep_time=0.0)), ROLLING).pressed().solve()
    with pytest.raises(ValueError, match="the creep time is 0 and can only grow"):
        at_once.derivative("approach", "lower.creep_time")


@pytest.mark.parametrize("angle", [0.39, 0.403, -2.0])
def test_directions_beside_corners_of_cells_are_derived(angle: float) -> None:
    """Ways that pass close by corners of cells, at atan(3 / 7) = 0.4049 among others."""
    pressed = normal()

    def traction(angle: float) -> Any:
        motion = replace(ROLLING, angle=angle, step=0.8 * STEP)
        return mtb.solve_tangential(
            mtb.PressureField(pressed.pressure, (STEP, STEP), lower=TREAD, upper=mtb.steel),
            motion, LAW, tolerance=1e-12,
        )  # fmt: skip

    found = traction(angle).derivative("traction", "angle")
    h = 1e-5
    wide, narrow = (
        (traction(angle + s * h).traction - traction(angle - s * h).traction) / (2.0 * s * h)
        for s in (1.0, 0.5)
    )
    off = np.abs((4.0 * narrow - wide) / 3.0 - found).max()
    assert off < 1e-6 * np.abs(found).max()


@pytest.mark.parametrize("angle", [0.0, 0.7])
def test_the_resistance_is_derived(angle: float) -> None:
    rolling = replace(ROLLING, angle=angle)
    given: dict[str, Any] = {"lower": TREAD, "rolling": rolling, "force": 1.0, "tolerance": 1e-13}
    rough = 1e-7 * np.random.default_rng(5).random(GAP.shape)

    def resistance(**changed: Any) -> float:
        asked = given | changed
        gap, lower = GAP + asked.pop("more", 0.0), asked.pop("lower")
        return mtb.solve_normal(gap, STEP, lower=lower, upper=mtb.Rigid(), **asked).rolling_resistance

    moved: dict[str, tuple[float, Callable[[float], dict[str, Any]]]] = {
        "force": (1e-3, lambda e: {"force": 1.0 + e}),
        "gap": (1e-3, lambda e: {"more": e * rough}),
        "lower.creep": (1e-3, lambda e: {"lower": replace(TREAD, creep=TREAD.creep + e)}),
        "rolling.velocity": (1e-3, lambda e: {"rolling": replace(rolling, velocity=rolling.velocity + e)}),
        "rolling.angle": (1e-4, lambda e: {"rolling": replace(rolling, angle=angle + e)}),
    }
    gradient = normal(rolling=rolling, tolerance=1e-13).gradient("rolling_resistance")
    for by, (h, change) in moved.items():
        wide, narrow = (
            (resistance(**change(s * h)) - resistance(**change(-s * h))) / (2.0 * s * h) for s in (1.0, 0.5)
        )
        along = rough if by == "gap" else np.ones(())
        found = float((gradient[by] * along).sum())
        assert found == pytest.approx((4.0 * narrow - wide) / 3.0, rel=1e-6, abs=1e-9), by


def test_where_the_resistance_is_not_known_it_has_no_derivatives() -> None:
    with pytest.raises(ValueError, match="no body is Viscoelastic"):
        normal(RUBBER, rolling=None).gradient("rolling_resistance")
    with pytest.raises(ValueError, match="that pressed has its derivatives"):
        rolled().derivative("rolling_resistance", "creepage")
    # a cylinder as long as the grid, rolled across its axis
    long = np.broadcast_to(X[None, :] ** 2 / 0.2, GAP.shape)
    result = mtb.solve_normal(
        long, STEP, lower=TREAD, upper=mtb.Rigid(), force=1.0, rolling=ROLLING, edge="sharp"
    )
    gradient = result.gradient("rolling_resistance")
    assert gradient["force"] > 0.0
    with pytest.raises(ValueError, match="reaches the edge of the grid across the way"):
        gradient["rolling.angle"]


def test_at_half_of_poisson_s_ratio_the_derivative_is_that_from_below() -> None:
    def approach(ratio: float) -> float:
        body = replace(TREAD, material=replace(RUBBER, poisson_ratio=ratio))
        return float(normal(body, tolerance=1e-13).approach)

    soft = replace(TREAD, material=replace(RUBBER, poisson_ratio=0.5))
    found = normal(soft, tolerance=1e-13).derivative("approach", "lower.poisson_ratio")
    weights = (25.0 / 12.0, -4.0, 3.0, -4.0 / 3.0, 0.25)
    expected = sum(w * approach(0.5 - 3e-3 * k) for k, w in enumerate(weights)) / 3e-3
    assert found == pytest.approx(expected, rel=1e-6)


def test_a_sweep_over_speeds_and_bodies() -> None:
    speeds = [1e-6, 2.0, 1e6]
    table = mtb.sweep(
        SCENE, {"rolling.velocity": speeds, "lower": [TREAD, RUBBER, TREAD.relaxed]}, motion=ROLLING,
        tolerance=0.9,
    )  # fmt: skip
    peaks = table["peak_pressure"]
    # an elastic body does not know how fast it is; slow and fast rolling are those of elastic bodies
    np.testing.assert_allclose(peaks[:, 1], peaks[0, 1], rtol=1e-9)
    assert peaks[0, 0] == pytest.approx(peaks[0, 2], rel=1e-4)
    assert peaks[2, 0] == pytest.approx(peaks[0, 1], rel=1e-4)
    assert 1.05 * peaks[0, 0] < peaks[1, 0] < 0.95 * peaks[2, 0]
    resistance = table["rolling_resistance"]
    assert np.isnan(resistance[:, 1:]).all()
    assert resistance[1, 0] > 20.0 * np.abs(resistance[[0, 2], 0]).max() > 0.0


def test_a_wheel_of_a_polymer_rolls_between_its_limits() -> None:
    polymer = mtb.Viscoelastic(mtb.Material(3e9, 0.4), 1.0, 1e-3)
    wheel = mtb.scenes.wheel_on_rail(upper=polymer, force=2e3, spacing=1e-3, lateral=0.0, friction=0.3)
    motion = mtb.Rolling(creepage=(1e-3, 0.0, 0.0))

    def peak(upper: Any, velocity: float) -> float:
        pressed, _ = Moving(wheel.with_(upper=upper), replace(motion, velocity=velocity)).solve(tolerance=0.9)
        return float(pressed.report.peak_pressure)

    slow, hard = peak(polymer.relaxed, 5.0), peak(polymer.material, 5.0)
    assert peak(polymer, 1e-5) == pytest.approx(slow, rel=1e-5)
    # the plane of the contact is placed for the overlap that the relaxed wheel needs
    assert peak(polymer, 1e6) == pytest.approx(hard, rel=1e-2)
    assert 1.1 * slow < peak(polymer, 5.0) < 0.95 * hard


def test_what_rolled_by_a_case_is_kept_and_drawn(tmp_path: Path) -> None:
    result = of_case(TREAD)
    assert result.lower == TREAD
    assert type(result.lower) is mtb.Viscoelastic
    assert pickle.loads(pickle.dumps(result)) == result
    result.save(tmp_path)
    assert mtb.load(tmp_path) == result
    assert result.stress(depths=[1e-3]).von_mises.max() > 0.0
    result.plot("pressure")
    # a body that is stiffer by as much as it is pressed more is sheared by as much more
    by = result.gradient("force")
    scaled = np.tensordot(by["pressure"], result.pressure, 2) + 10e6 * by["lower.young_modulus"]
    np.testing.assert_allclose(scaled, result.force, rtol=0.0, atol=1e-8)


def test_case_files_say_it(tmp_path: Path) -> None:
    file = tmp_path / "case.toml"
    file.write_text(
        'scene = "paraboloid_on_plane"\nforce = 1.0\nradius = 0.1\nfriction = 0.4\nupper = "rigid"\n'
        "[lower]\nmaterial = { young_modulus = 10e6, poisson_ratio = 0.49 }\n"
        "creep = 0.8\ncreep_time = 2e-3\n[rolling]\nvelocity = 2.0\n"
    )
    case = mtb.load_case(file)
    assert case.scene().lower == TREAD
    assert case.expected_cost().costs
    text = file.read_text()
    for old, new, words in (
        ("creep_time", "creep_tim", r"lower\.creep_tim = 0.002: unknown key; did you mean 'creep_time'"),
        ("creep = 0.8\n", "", r"lower\.creep: is missing"),
        ("creep = 0.8", "creep = -0.8", "creep is -0.8: a number of at least 0"),
    ):
        file.write_text(text.replace(old, new))
        with pytest.raises(mtb.CaseError, match=words):
            mtb.load_case(file)
    file.write_text(text.replace("[rolling]\nvelocity = 2.0\n", ""))
    for ask in (lambda case: case.solve(), lambda case: case.expected_cost()):
        with pytest.raises(mtb.CaseError, match=r"lower is Viscoelastic.*case files with \[rolling\]"):
            ask(mtb.load_case(file))
    file.write_text(text.replace("[rolling]\nvelocity = 2.0\n", "[shift]\ndisplacement = [1e-6, 0.0]\n"))
    for ask in (lambda case: case.solve(), lambda case: case.expected_cost()):
        with pytest.raises(mtb.CaseError, match="has felt before is not known"):
            ask(mtb.load_case(file))


def test_the_pressure_leans_ahead_and_resists() -> None:
    for angle in (0.0, 0.7, np.pi):
        result = normal(rolling=replace(ROLLING, angle=angle))
        x, y, _ = result.points
        ahead = np.cos(angle) * x + np.sin(angle) * y
        moment = float((result.pressure * ahead * result.area).sum())
        # the gap rises by the place over the radius; the contact is some ten cells wide
        assert result.rolling_resistance == pytest.approx(moment / 0.1, rel=4e-2)
        assert moment > 0.02 * 1.0 * 3e-3
    assert abs(normal(replace(TREAD, creep=0.0)).rolling_resistance) < 1e-6


def work_of(result: mtb.NormalResult, middle: float) -> float:
    """Moment [N m] of the pressure about the axis of a ball above x = `middle`, over its radius of 0.1 m."""
    return float((result.pressure * (result.points[0] - middle) * result.area).sum()) / 0.1


def test_the_resistance_is_the_same_however_the_upper_body_tilts() -> None:
    errors = np.zeros((3, 3))
    for i, cells in enumerate((20, 40, 80)):
        for j, moment in enumerate((0.0, 1e-4, -1e-4)):
            x = (np.arange(cells) - 0.5 * (cells - 1)) * (10e-3 / cells)
            given = {
                "lower": TREAD,
                "upper": mtb.Rigid(),
                "force": 1.0,
                "rolling": ROLLING,
                "tolerance": 1e-8,
            }
            free = mtb.solve_normal(
                (x[None] ** 2 + x[:, None] ** 2) / 0.2,
                x[1] - x[0],
                moments_about_axes=(None, moment),
                **given,
            )
            # a paraboloid that tilts is one that is shifted
            middle = 0.1 * free.tilts[0]
            shifted = mtb.solve_normal(
                ((x[None] - middle) ** 2 + x[:, None] ** 2) / 0.2, x[1] - x[0], **given
            )
            assert free.rolling_resistance == pytest.approx(shifted.rolling_resistance, rel=1e-5)
            errors[i, j] = free.rolling_resistance / work_of(shifted, middle) - 1.0
    size = np.sqrt((errors**2).mean(axis=1))
    assert size[2] < 2e-3, size
    assert size[0] > 6.0 * size[2], size


@pytest.mark.parametrize("rows", [1, 8])
def test_a_cylinder_that_is_rolled_along_its_axis_has_ends_which_are_not_known(rows: int) -> None:
    def rolled(angle: float) -> mtb.NormalResult:
        return mtb.solve_normal(
            np.tile(X**2 / 0.2, (rows, 1)),
            (STEP, 1e-3),
            lower=TREAD,
            upper=mtb.Rigid(),
            force=float(rows),
            edge="sharp",
            rolling=mtb.Rolling(velocity=1.0, angle=angle),
        )

    ahead = rolled(0.0).rolling_resistance
    # backwards, the sine of the angle is not quite 0
    assert rolled(np.pi).rolling_resistance == pytest.approx(ahead, rel=1e-9)
    for angle in (0.5, 0.5 * np.pi):
        with pytest.raises(ValueError, match="the pressure reaches the edge of the grid"):
            _ = rolled(angle).rolling_resistance


def test_the_resistance_below_sharp_edges_is_that_below_edges_that_are_nearly_sharp() -> None:
    cell = 0.125e-3
    x = np.abs(np.arange(48) - 23.5) * cell
    far = np.maximum(x[None], x[:, None])
    given = {"lower": TREAD, "upper": mtb.Rigid(), "force": 1.0, "rolling": ROLLING}

    def punch(gap: Any) -> mtb.NormalResult:
        return mtb.solve_normal(gap, cell, **given)

    sharp = [punch(np.where(far < 1.5e-3, 0.0, out)).rolling_resistance for out in (1e-3, 1e-2, 1.0)]
    # the gap beyond the edge carries nothing
    assert sharp == pytest.approx([sharp[0]] * 3, rel=1e-5)
    rounded = [
        punch(np.maximum(far - (1.5e-3 - radius), 0.0) ** 2 / (2.0 * radius)).rolling_resistance
        for radius in (0.5e-3, 0.25e-3)
    ]
    assert 0.0 < sharp[0] < rounded[1] < rounded[0]
    assert rounded[1] < 2.0 * sharp[0]
    # elastic bodies give back what they take, at a sharp edge as well
    elastic = mtb.solve_normal(
        np.where(far < 1.5e-3, 0.0, 1e-2), cell, **given | {"lower": replace(TREAD, creep=0.0)}
    )
    assert abs(elastic.rolling_resistance) < 1e-4 * sharp[0]

    ends = mtb.solve_normal(np.zeros((24, 24)), cell, edge="sharp", **given)
    with pytest.raises(ValueError, match="the pressure reaches the edge of the grid"):
        _ = ends.rolling_resistance
    assert "rolling_resistance" not in ends.totals()
    assert "rolling resistance" not in dict(ends.told())
    assert mtb.solve_tangential(ends, ROLLING, LAW).rolling_resistance is None


def test_what_rolls_tells_the_resistance(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    pressed = normal()
    full = rolled(coupling="full")
    assert rolled().rolling_resistance == pytest.approx(pressed.rolling_resistance, rel=1e-12)
    for result in (rolled(), full):
        # the pressure works on the slope of the gap, whatever pressed it
        expected = float((result.pressure * result.points[0]).sum()) * STEP**2 / 0.1
        assert result.rolling_resistance == pytest.approx(expected, rel=3e-2)
        assert result.totals()["rolling_resistance"].unit == "N"
        assert "rolling resistance" in dict(result.told())
    assert full.rolling_resistance != pytest.approx(pressed.rolling_resistance, rel=1e-4)
    for silent in (
        rolled(normal=normal(RUBBER, rolling=None)),
        rolled(normal=mtb.PressureField(pressed.pressure, (STEP, STEP), TREAD, None)),
    ):
        assert silent.rolling_resistance is None
        assert "rolling_resistance" not in silent.totals()

    file = tmp_path / "ball.toml"
    file.write_text(
        'scene = "paraboloid_on_plane"\nforce = 1.0\nradius = 0.1\npoints = 24\nfriction = 0.4\n'
        'upper = "rigid"\n'
        "[lower]\ncreep = 0.8\ncreep_time = 2e-3\nmaterial = { young_modulus = 10e6, poisson_ratio = 0.49 }\n"
        "[rolling]\nvelocity = 2.0\n[solve]\ntolerance = 0.9\n"
    )
    assert main(["run", str(file), "-o", str(tmp_path / "out")]) == 0
    assert "rolling resistance" in capsys.readouterr().out
    summary = json.loads((tmp_path / "out" / "summary.json").read_text())
    assert summary["rolling_resistance"] == pytest.approx(of_case(TREAD).rolling_resistance, rel=1e-6)


def test_it_is_kept_and_comes_back(tmp_path: Path) -> None:
    assert pickle.loads(pickle.dumps(TREAD)) == TREAD
    assert replace(TREAD, creep=0.9) != TREAD
    assert TREAD.relaxed == mtb.Material(10e6 / 1.8, 0.49)
    for number, result in enumerate((normal(), rolled())):
        assert pickle.loads(pickle.dumps(result)) == result
        result.save(tmp_path / str(number))
        loaded = mtb.load(tmp_path / str(number))
        assert loaded == result
        assert loaded.lower == TREAD
    assert "rolling resistance" in dict(normal().told())


# --- what refuses it ----------------------------------------------------------------------------------------


def pad() -> mtb.ElasticBody:
    mesh = block_mesh(np.linspace(-0.04, 0.04, 3), np.linspace(-0.02, 0.02, 3), 0.03)
    return mtb.ElasticBody(mesh, mtb.steel, "contact", [mtb.Support("top", x=0, y=0)], "pad")


FIELD = mtb.PressureField(np.array([[1e6, 2e6, 1e6]]), (STEP, STEP), TREAD, None)
REFUSED: dict[str, tuple[Callable[[], Any], str]] = {
    "at rest": (lambda: normal(rolling=None), "rolling is None: a Viscoelastic body is known in steady"),
    "elastic bodies": (lambda: normal(RUBBER), "no body is Viscoelastic"),
    "no motion": (lambda: normal(rolling=2.0), r"rolling is 2\.0: a Rolling is needed"),
    "a shift": (lambda: normal(rolling=mtb.Shift((1e-3, 0.0))), "has felt before is not known"),
    "a step": (lambda: normal(rolling=mtb.Rolling(transient=True)), "has felt before is not known"),
    "periodic": (lambda: normal(periodic=True), "periodic is for elastic bodies"),
    "hardness": (lambda: normal(hardness=1e7), "hardness is for elastic bodies"),
    "KPEC": (lambda: normal(method="kpec"), 'method="kpec" is for elastic bodies'),
    "another velocity": (
        lambda: rolled(motion=replace(ROLLING, velocity=1.0)),
        r"velocity of \(1, 0\) m/s, and the normal contact .* for \(2, 0\)",
    ),
    "another velocity of a curve": (
        lambda: mtb.creep_curve(normal(), [[1e-3, 0, 0]], LAW, velocity=1.0),
        r"velocity of \(1, 0\) m/s",
    ),
    "a tangential shift": (lambda: rolled(motion=mtb.Shift((1e-6, 0.0))), "has felt before is not known"),
    "a transient step": (lambda: rolled(motion=replace(ROLLING, transient=True)), "has felt before"),
    "line contact": (lambda: replace(FIELD, reference=1.0), "lower is a Viscoelastic: in a line contact"),
    "FASTSIM": (lambda: mtb.fastsim(normal(), (1e-3, 0, 0), LAW), "those of elastic half-spaces"),
    "Polach": (lambda: mtb.polach(normal(), (1e-3, 0, 0), LAW), "those of elastic half-spaces"),
    "Hertz": (lambda: mtb.hertz(50.0, 1.0, lower=TREAD, upper=RUBBER), "Hertz' contact does not take it"),
    "a scene at rest": (lambda: SCENE.solve(), "lower is Viscoelastic.*steady rolling only"),
    "its steps": (lambda: SCENE.prepare(), "lower is Viscoelastic"),
    "its chart": (lambda: SCENE.chart(), "lower is Viscoelastic"),
    "its cost": (lambda: SCENE.expected_cost(), "lower is Viscoelastic"),
    "its wear": (lambda: mtb.wear(SCENE, distance=1.0, law=1e-13), "lower is Viscoelastic"),
    "its start of sliding": (lambda: SCENE.start_of_sliding([[1e-6, 0.0]]), "lower is Viscoelastic"),
    "load increments": (lambda: SCENE.solve(method="incremental"), "lower is Viscoelastic"),
    "a ready scene": (
        lambda: mtb.scenes.paraboloid_on_plane(lower=TREAD, force=1.0, radius=0.1).solve(),
        "lower is Viscoelastic",
    ),
    "an elastic model": (
        lambda: mtb.scenes.block_on_plane(lower=TREAD, spacing=0.02).solve("elastic-upper"),
        "model is 'elastic-upper', and lower is Viscoelastic",
    ),
    "an elastic model above": (
        lambda: mtb.scenes.block_on_plane(upper=TREAD, spacing=0.02).solve("elastic-upper"),
        "model is 'elastic-upper', and upper is Viscoelastic",
    ),
    "heat of sliding": (
        lambda: mtb.scenes.block_on_plane(lower=TREAD, spacing=0.02).sliding_heat(1.0, 4, 1.0),
        "lower is Viscoelastic",
    ),
    "a stop": (
        lambda: mtb.brake(mtb.scenes.pole_shoe_on_rail(lower=TREAD), speed=10.0, mass=1e3),
        "lower is Viscoelastic",
    ),
    "a wheel": (lambda: mtb.scenes.wheel_on_rail(upper=HARD).solve(), "upper is Viscoelastic"),
    "a wheel in steps": (lambda: mtb.scenes.wheel_on_rail(upper=HARD).prepare(), "does not take it"),
    "a scene in a shift": (
        lambda: Moving(SCENE, mtb.Shift((1e-6, 0.0))).solve(),
        "has felt before is not known",
    ),
    "a scene in a step": (
        lambda: Moving(SCENE, replace(ROLLING, transient=True)).solve(),
        "has felt before is not known",
    ),
    "an elastic body": (
        lambda: mtb.Scene(pad(), TREAD, spacing=2e-2, friction=0.2, magnetic_pressure=1e6),
        "lower is Viscoelastic.* beside an ElasticBody",
    ),
    "loads": (lambda: mtb.area_load_curve(GAP, STEP, [1.0], lower=TREAD, upper=RUBBER), "rolling is None"),
    "rough layer": (
        lambda: mtb.RoughLayer.from_surface(1e-6 * np.cos(GAP / STEP**2), STEP, lower=TREAD, upper=RUBBER),
        "does not take it",
    ),
    "resistance": (lambda: normal(RUBBER, rolling=None).rolling_resistance, "no resistance to rolling"),
    "creep": (lambda: mtb.Viscoelastic(RUBBER, -1.0, 1.0), "creep is -1: a number of at least 0"),
    "creep time": (lambda: mtb.Viscoelastic(RUBBER, 1.0, -1.0), "creep_time is -1: a number of at least 0"),
    "material": (lambda: mtb.Viscoelastic(mtb.Rigid(), 1.0, 1.0), "a Material is needed"),  # type: ignore[arg-type]
}


@pytest.mark.parametrize(("ask", "words"), REFUSED.values(), ids=REFUSED.keys())
def test_each_refusal_has_a_name(ask: Callable[[], Any], words: str) -> None:
    with pytest.raises(ValueError, match=words):
        ask()
