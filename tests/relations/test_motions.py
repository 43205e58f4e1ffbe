# SPDX-License-Identifier: MIT OR Apache-2.0
"""What rolls or shifts was pressed before: by the same force, on half-spaces, whatever asks for it."""

from __future__ import annotations

import csv
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import mtb_rs as mtb
from mtb_rs.bodies.mesh import block_mesh
from mtb_rs.commands import main
from mtb_rs.commands.exits import BAD_INPUT

FRICTION = mtb.Coulomb(0.3)
pytestmark = pytest.mark.coarse


def block(**given: Any) -> mtb.Scene:
    return mtb.scenes.block_on_plane(spacing=2e-2, friction=0.3, **given).with_(sliding_direction=None)


def pad() -> mtb.Scene:
    mesh = block_mesh(np.linspace(-0.04, 0.04, 11), np.linspace(-0.016, 0.016, 5), 0.025)
    guide = mtb.Support("top", x=0.0, y=0.0, z=mtb.Guide(-20e3))
    body = mtb.ElasticBody(mesh, mtb.steel, "bottom", [guide])
    return mtb.Scene(body, mtb.steel, spacing=8e-3, friction=0.3, sliding_direction=None)


def hertz() -> Any:
    return mtb.hertz(10e3, semi_axes=(4e-3, 3e-3), lower=mtb.steel, upper=mtb.steel)


def loaded(made: mtb.Result, folder: Path) -> Any:
    made.save(folder)
    return mtb.load(folder)


@cache
def wheel() -> mtb.Result:
    scene = mtb.scenes.wheel_on_rail(lateral=6e-3, force=60e3, spacing=1.2e-3, friction=0.3)
    return scene.with_(sliding_direction=None).solve()


#: What is pressed by half-spaces, in every kind of result.
PRESSED: dict[str, Callable[[], Any]] = {
    "hertz": hertz,
    "on a grid": lambda: hertz().on_grid((13, 11), (8e-4, 1e-3)),
    "solve_normal": lambda: mtb.solve_normal(
        hertz().gap(*np.meshgrid(*[np.linspace(-6e-3, 6e-3, 13)] * 2)),
        1e-3,
        lower=mtb.steel,
        upper=mtb.Rigid(),
        force=10e3,
    ),
    "paraboloid": lambda: mtb.scenes.paraboloid_on_plane(points=15).solve(),
    "block": lambda: block().solve("half-space"),
    "unlike block": lambda: block(upper=mtb.Material(7e10, 0.33)).solve("half-space"),
    "wheel": wheel,
}
#: What is pressed by elastic bodies.
ELASTIC: dict[str, Callable[[], Any]] = {
    "auto": lambda: block().solve(),
    "elastic-upper": lambda: block().solve("elastic-upper"),
    "body of one's own": lambda: pad().solve(),
}
CREEPAGE = (1e-3, 5e-4, 0.1)
#: What rolls or shifts it; of fields it returns the force it acts on [N], else what gross sliding would say.
MOVES: dict[str, Callable[[Any], float]] = {
    "shift": lambda p: _carried(mtb.solve_tangential(p, mtb.Shift((1e-6, 0.0)), FRICTION)),
    "rolling": lambda p: _carried(mtb.solve_tangential(p, mtb.Rolling(CREEPAGE), FRICTION)),
    "transient": lambda p: _carried(mtb.solve_tangential(p, mtb.Rolling(CREEPAGE, transient=True), FRICTION)),
    "creep_curve": lambda p: _sliding(mtb.creep_curve(p, [(1.0, 0.0, 0.0)], FRICTION)[0]),
    "fastsim": lambda p: _carried(mtb.fastsim(p, CREEPAGE, FRICTION)),
    "fastrip": lambda p: _carried(mtb.fastrip(p, CREEPAGE, FRICTION)),
    "polach": lambda p: _sliding(mtb.polach(p, (100.0, 0.0, 0.0), FRICTION)),
}


def _carried(moved: Any) -> float:
    assert float((moved.pressure * moved.area).sum()) == pytest.approx(-moved.force[2], rel=1e-9)
    return -float(moved.force[2])


def _sliding(force: Any) -> float:
    """The normal force that full sliding tells."""
    return float(np.hypot(*force[:2])) / FRICTION.at_rest()


@pytest.mark.filterwarnings("ignore:the bodies are unlike")
@pytest.mark.parametrize("kind", PRESSED)
@pytest.mark.parametrize("move", MOVES)
def test_what_moves_carries_the_force_it_was_pressed_with(kind: str, move: str) -> None:
    pressed = PRESSED[kind]()
    if move in ("fastsim", "fastrip") and kind == "block":
        pytest.skip("FASTSIM is for ellipses")
    force = pressed.force if kind == "hertz" else pressed.normal_force
    # a curve ends where Polach's arctangent is a thousandth short of full sliding
    assert MOVES[move](pressed) == pytest.approx(
        force, rel=1e-9 if move not in ("creep_curve", "polach") else 2e-3
    )


@pytest.mark.parametrize("kind", ELASTIC)
@pytest.mark.parametrize("move", MOVES)
def test_elastic_bodies_are_refused_with_what_to_do(kind: str, move: str) -> None:
    with pytest.raises(ValueError, match=r'model="half-space".*ElasticBody'):
        MOVES[move](ELASTIC[kind]())


def test_results_from_files_are_taken_as_before_they_were_saved(tmp_path: Path) -> None:
    half = PRESSED["unlike block"]()
    assert MOVES["rolling"](loaded(half, tmp_path / "half")) == pytest.approx(half.normal_force, rel=1e-9)
    with pytest.raises(ValueError, match="half-space"):
        MOVES["rolling"](loaded(ELASTIC["body of one's own"](), tmp_path / "own"))


def test_points_of_unequal_areas_are_no_cells() -> None:
    whole = PRESSED["block"]()
    area = whole.area.copy()
    area[0] /= 2.0
    changed = type("Pressed", (), {**vars(whole), "area": area})()
    with pytest.raises(ValueError, match="equal cells"):
        MOVES["shift"](changed)


# --- case files -----------------------------------------------------------------------------------------

BLOCK = 'scene = "block_on_plane"\nspacing = 2e-2\nfriction = 0.3\n'
WHEEL = 'scene = "wheel_on_rail"\nforce = 60e3\nlateral = 0.0\nspacing = 1.2e-3\nfriction = 0.3\n'
ROLLING = "[rolling]\ncreepage = [1e-3, 0.0, 0.1]\n"
SHIFT = "[shift]\ndisplacement = [1e-6, 0.0]\n"


def written(folder: Path, text: str) -> Path:
    path = folder / "case.toml"
    path.write_text(text, encoding="utf-8")
    return path


@pytest.mark.parametrize("motion", [ROLLING, SHIFT])
def test_a_block_of_a_case_moves_as_the_half_space_it_is_counted_as(tmp_path: Path, motion: str) -> None:
    case = mtb.load_case(written(tmp_path, BLOCK + motion))
    moved = case.solve()
    assert moved.normal_force == pytest.approx(block().solve("half-space").normal_force, rel=1e-12)
    assert [cost.points for cost in case.expected_cost().costs] == [moved.pressure.size] * 2


@pytest.mark.parametrize(
    ("text", "told"),
    [
        (BLOCK + SHIFT + '[solve]\nmodel = "elastic-upper"\n', "elastic-upper"),
        (BLOCK + SHIFT + '[solve]\nmethod = "staggered"\n', "staggered"),
        (WHEEL + '[rolling]\nforce = [1e6, "free"]\n', r"\(1e\+06, free\) N: friction carries less than 180"),
        (WHEEL + '[rolling]\nforce = ["free", -2e4]\n', "friction carries less"),
        (BLOCK + "[shift]\nforce = [7e3, 7e3]\n", "friction carries less than 9000 N"),
        (WHEEL + "[rolling]\nstep = 1e-6\n", "step is 1e-06 m"),
        (
            WHEEL.replace("0.3", "{velocity = [0.0, 9.0], value = [0.4, 0.3]}") + ROLLING,
            "a law of friction, is needed",
        ),
    ],
)
def test_check_refuses_what_run_would(
    tmp_path: Path, text: str, told: str, capsys: pytest.CaptureFixture[str]
) -> None:
    path = written(tmp_path, text)
    case = mtb.load_case(path)
    with pytest.raises(mtb.CaseError, match=told):
        case.expected_cost()
    with pytest.raises(mtb.CaseError, match=told):
        case.solve()
    assert main(["check", str(path)]) == BAD_INPUT
    assert "No fault" not in capsys.readouterr().out


def test_a_force_that_friction_just_carries_is_solved(tmp_path: Path) -> None:
    case = mtb.load_case(written(tmp_path, WHEEL + '[rolling]\nforce = [1.7e4, "free"]\n'))
    case.expected_cost()
    assert case.solve().force[0] == pytest.approx(1.7e4, rel=1e-6)


# --- sweeps and charts ----------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("text", "vary", "changed"),
    [
        (WHEEL + ROLLING, "friction=0.2,0.4", lambda text, v: text.replace("0.3\n", f"{v}\n")),
        (
            WHEEL + ROLLING,
            "rolling.creepage=[1e-3, 0, 0],[2e-3, 0, 0.2]",
            lambda text, v: WHEEL + f"[rolling]\ncreepage = {v}\n",
        ),
        (BLOCK + SHIFT, "shift.spin=0.0,1e-5", lambda text, v: text + f"spin = {v}\n"),
        (BLOCK + SHIFT, "magnetic_pressure=1e6,2e6", lambda text, v: f"magnetic_pressure = {v}\n" + text),
    ],
)
def test_a_sweep_finds_what_run_finds(
    tmp_path: Path, text: str, vary: str, changed: Callable[[str, str], str]
) -> None:
    path = written(tmp_path, text)
    assert main(["sweep", str(path), "--vary", vary, "-o", str(tmp_path / "swept")]) == 0
    rows = list(csv.DictReader((tmp_path / "swept" / "sweep.csv").read_text(encoding="utf-8").splitlines()))
    assert len(rows) == 2
    for row in rows:
        label = row[next(iter(row))]
        moved = mtb.load_case(written(tmp_path, changed(text, label))).solve()
        found = [float(row[f"force_{c} [N]"]) for c in "xyz"]
        assert found == pytest.approx(moved.force.tolist(), rel=1e-9, abs=1e-6)
        assert float(row["spin_moment [N m]"]) == pytest.approx(moved.spin_moment, rel=1e-9, abs=1e-9)
        assert abs(found[0]) > 0.0


def test_a_sweep_measures_the_motion_and_names_its_arguments(tmp_path: Path) -> None:
    scene, motion = wheel_scene(), mtb.Rolling((1e-3, 0.0, 0.0))
    table = mtb.sweep(
        scene,
        {"rolling.angle": [0.0, np.pi]},
        motion=motion,
        measure=lambda r: {"stick": (r.status == 1).sum()},
    )
    assert table.units["rolling.angle"] == "rad"
    assert (table["stick"] > 0).all()
    assert (table["force_x"] > 0).all()
    for wrong, told in (("rolling.creepages", "rolling.creepage"), ("shift.spin", "no argument")):
        with pytest.raises(ValueError, match=told):
            mtb.sweep(scene, {wrong: [0.0]}, motion=motion)
    with pytest.raises(ValueError, match="a Rolling or a Shift"):
        mtb.sweep(scene, {"friction": [0.3]}, motion="rolling")  # type: ignore[arg-type]
    # another motion is another sweep
    at = tmp_path / "sweep.jsonl"
    mtb.sweep(scene, {"friction": [0.3]}, motion=motion, checkpoint=at)
    with pytest.raises(ValueError, match="another sweep"):
        mtb.sweep(scene, {"friction": [0.3]}, checkpoint=at)


def wheel_scene() -> mtb.Scene:
    return mtb.scenes.wheel_on_rail(lateral=0.0, force=60e3, spacing=1.2e-3, friction=0.3)


def test_a_chart_of_a_motion_is_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = written(tmp_path, WHEEL + ROLLING)
    assert main(["chart", str(path), "-o", str(tmp_path / "out")]) == BAD_INPUT
    assert "[rolling] is given" in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize("wrong", ["rolling.creepage=[1e-3, 0", "rolling.creepage=[1e-3],2", "friction=[]]"])
def test_lists_that_are_none_are_named(
    tmp_path: Path, wrong: str, capsys: pytest.CaptureFixture[str]
) -> None:
    path = written(tmp_path, WHEEL + ROLLING)
    with pytest.raises(SystemExit):
        main(["sweep", str(path), "--vary", wrong, "-o", str(tmp_path / "out")])
    assert "lists between commas" in capsys.readouterr().err
