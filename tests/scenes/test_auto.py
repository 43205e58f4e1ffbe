# SPDX-License-Identifier: MIT OR Apache-2.0
"""``model="auto"``: an honest estimate, a thrifty choice, a spacing that meets the tolerance."""

from __future__ import annotations

import importlib
import sys
from collections.abc import Iterator
from itertools import pairwise
from pathlib import Path
from types import ModuleType, SimpleNamespace
from typing import Any

import numpy as np
import pytest

import mtb_rs as mtb
from mtb_rs.base import cache
from mtb_rs.scenes import auto, direct
from mtb_rs.scenes.auto import Level
from mtb_rs.studies.chart_scene import closed_form, fields_of

STUDIES = Path(__file__).parents[2] / "studies"
steel = mtb.steel
carbide = mtb.Material(young_modulus=600e9, poisson_ratio=0.2)


@pytest.fixture(scope="module")
def honesty() -> Iterator[ModuleType]:
    """The study whose whole family is in docs/maps/honesty.csv."""
    with pytest.MonkeyPatch.context() as patch:
        patch.syspath_prepend(str(STUDIES))
        sys.modules.pop("honesty", None)
        yield importlib.import_module("honesty")


@pytest.mark.coarse
@pytest.mark.parametrize(
    ("kind", "arguments"),
    [
        ("block", {"friction": 0.5, "cells": 6, "tolerance": 0.1}),
        ("block", {"friction": 0.4, "lower": mtb.Rigid(), "cells": 6, "height": 0.05}),
        ("block", {"friction": 0.5, "upper": mtb.Rigid(), "cells": 12}),
        ("shoe", {"friction": 0.3, "lower": carbide, "tolerance": 0.2, "finer": 2}),
        ("paraboloid", {"points": 20, "friction": 0.5, "lower": carbide, "finer": 2}),
        ("wheel", {"spacing": 3e-4, "lateral": 3e-3}),
    ],
)
@pytest.mark.slow
def test_the_estimate_is_honest_and_the_choice_thrifty(
    honesty: ModuleType, kind: str, arguments: dict[str, Any]
) -> None:
    found = honesty.examine(getattr(honesty, kind)(**arguments))
    assert found.is_honest, found
    assert found.keeps_its_word, found
    assert found.is_thrifty, found
    # nor does it cry wolf
    assert found.estimate < 10.0 * found.truth


def test_the_chosen_spacing_of_a_paraboloid_meets_the_tolerance_against_hertz() -> None:
    points = []
    for tolerance in (0.1, 0.02):
        scene = mtb.scenes.paraboloid_on_plane(points=None)
        result = scene.solve(tolerance=tolerance)
        exact = closed_form(scene)
        assert exact is not None
        assert result.report.spacing is not None
        own = fields_of(scene, result, result.report.spacing)
        error = own.errors(exact, skip_border=False)["pressure"]
        assert error <= result.error_estimate <= tolerance
        points.append(result.pressure.size)
    assert points[1] > 2 * points[0]


@pytest.mark.parametrize(
    ("name", "arguments", "tolerance"),
    [
        ("block_on_plane", {"friction": 0.4}, 0.02),
        ("block_on_plane", {"friction": 0.5}, 0.05),
        ("block_on_plane", {"upper": mtb.Rigid(), "friction": 0.2}, 0.1),
        ("pole_shoe_on_rail", {"friction": 0.3}, 0.1),
        ("wheel_on_rail", {}, 0.05),
    ],
)
@pytest.mark.slow
def test_the_chosen_spacing_meets_the_tolerance_against_a_finer_solve(
    name: str, arguments: dict[str, Any], tolerance: float
) -> None:
    scene = getattr(mtb.scenes, name)(spacing=None, **arguments)
    result = scene.solve(tolerance=tolerance)
    spacing = result.report.spacing
    assert result.error_estimate <= tolerance
    halved = (spacing[0] / 2, spacing[1] / 2)
    fine = scene.with_(spacing=halved)
    truth = fields_of(fine, fine.solve(result.model), halved)
    error = fields_of(scene, result, spacing).errors(truth, scene.geometry.is_body_edge)["pressure"]
    assert error <= tolerance


def test_a_free_spacing_is_for_solving_directly_only() -> None:
    scene = mtb.scenes.block_on_plane(spacing=None)
    for call in (
        lambda: scene.solve("half-space", method="incremental"),
        lambda: scene.prepare("elastic-upper"),
        lambda: scene.with_(friction=np.full((8, 8), 0.5)).solve("half-space", method="incremental"),
    ):
        with pytest.raises(ValueError, match="spacing is None"):
            call()
    with pytest.raises(ValueError, match="spacing is None"):
        mtb.Scene(upper=steel, lower=steel, gap=np.zeros((8, 8)), spacing=None, force=1.0)


@pytest.fixture
def solved(monkeypatch: pytest.MonkeyPatch) -> list[Level]:
    """Everything that gets solved."""
    levels: list[Level] = []
    solve = direct.level_at

    def noted(*arguments: Any, **options: Any) -> Level:
        levels.append(solve(*arguments, **options))
        return levels[-1]

    monkeypatch.setattr(direct, "level_at", noted)
    return levels


@pytest.mark.parametrize(
    ("name", "solves"),
    [("block_on_plane", 4), ("pole_shoe_on_rail", 5), ("wheel_on_rail", 2), ("paraboloid_on_plane", 2)],
)
@pytest.mark.slow
def test_choice_and_estimate_cost_a_third_of_the_solve_and_are_reused(
    name: str, solves: int, solved: list[Level]
) -> None:
    # operations are those of bodies made here, not of what other tests kept
    cache.forget()
    result = getattr(mtb.scenes, name)().solve()
    # each model once on wide cells, and the answer: what chose the model also tells the error; elastic bodies
    # once more, so that the error of their layers of elements is seen beside that of the cells
    assert len(solved) == solves
    spent = result.report.operations
    besides = sum(level.operations for level in solved) - spent["condensation"] - spent["solution"]
    # copies that differ by the layers of the upper body share their rail
    rails = [level.problem.lower.operations for level in solved[:-2]]
    besides -= rails[-1] if result.model == "elastic-both" else 0.0
    assert spent["choice and estimate"] == pytest.approx(besides, rel=1e-12)
    assert 0.0 < 3.0 * spent["choice and estimate"] < spent["condensation"] + spent["solution"]


def test_levels_of_a_free_spacing_are_reused(solved: list[Level]) -> None:
    result = mtb.scenes.paraboloid_on_plane(points=None).solve(tolerance=0.02)
    spacings = [level.spacing[0] for level in solved]
    # wide copies are made of the first one only: then every solve is the wide copy of the next
    wide = [s for s in spacings if s > spacings[0]]
    levels = [s for s in spacings if s <= spacings[0]]
    assert 1 <= len(wide) <= 2
    assert len(levels) >= 2
    assert all(later < 0.75 * before for before, later in pairwise(levels))
    assert result.pressure.size == solved[-1].problem.n


@pytest.mark.coarse
def test_a_tolerance_out_of_reach_is_approached_and_not_claimed(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(auto, "MOST_OPERATIONS", 2e10)
    # all of the foot stays in contact: at friction 0.5 an edge that opens makes single estimates jump
    scene = mtb.scenes.block_on_plane(spacing=None, friction=0.2)
    coarse, fine = (scene.solve(tolerance=t) for t in (0.3, 1e-3))
    assert fine.pressure.size > 1.5 * coarse.pressure.size
    assert 1e-3 < fine.error_estimate < coarse.error_estimate
    assert fine.report.operations["condensation"] < 4e10


def test_what_is_asked_for_decides_the_model() -> None:
    scene = mtb.scenes.pole_shoe_on_rail(spacing=6e-3, friction=0.3)
    full = scene.solve("elastic-both")
    found = {q: scene.solve(quantity=q, tolerance=0.2) for q in ("force", "pressure", "displacement")}
    # the load arrives whatever the bodies; pressure needs the shoe, sinking the rail
    assert [r.model for r in found.values()] == ["half-space", "elastic-upper", "elastic-both"]
    apart = np.linalg.norm(found["force"].force - full.force) / np.linalg.norm(full.force)
    assert apart < 2.0 * found["force"].report.error_estimates["force"] < 0.4
    for quantity, result in found.items():
        assert result.report.aim == (quantity, 0.2)
        assert result.report.error_estimates[quantity] <= 0.2
        assert result.error_estimate == result.report.error_estimates["pressure"]


def test_the_result_says_what_was_modelled_what_not_and_how_good_it_is() -> None:
    scene = mtb.scenes.pole_shoe_on_rail(spacing=6e-3, friction=0.3)
    result = scene.solve(tolerance=0.2)
    lines = str(result).splitlines()
    assert len(lines) == 5
    assert lines[1].startswith("modelled: elastic-upper on cells of 6 x 5.")
    assert lines[2].startswith("left out: elasticity of the rail beyond the half-space (about ")
    assert lines[2].endswith(" % of the pressure)")
    assert lines[3].startswith("estimated total error: ")
    assert " % of the pressure (20 % aimed at), " in lines[3]
    (size,) = result.report.omitted.values()
    both, upper = scene.solve("elastic-both"), scene.solve("elastic-upper")
    inner = np.concatenate([p.view(np.arange(both.pressure.size))[1:-1, 1:-1].ravel() for p in both.patches])
    apart = np.linalg.norm((upper.pressure - both.pressure)[inner]) / np.linalg.norm(both.pressure[inner])
    assert 0.5 * apart < size < 2.0 * apart


@pytest.mark.coarse
@pytest.mark.parametrize(
    ("scene", "model"),
    [
        (mtb.scenes.pole_shoe_on_rail(spacing=6e-3), "elastic-both"),
        (mtb.scenes.block_on_plane(spacing=0.02), "elastic-upper"),
        (mtb.scenes.paraboloid_on_plane(points=12), "half-space"),
    ],
)
def test_a_given_model_knows_its_error_if_it_leaves_nothing_out(scene: mtb.Scene, model: str) -> None:
    given, chosen = scene.solve(model), scene.solve()
    assert chosen.model == model
    assert given.error_estimate == pytest.approx(chosen.error_estimate, rel=1e-9)


def test_a_given_model_that_leaves_something_out_says_so() -> None:
    result = mtb.scenes.pole_shoe_on_rail(spacing=6e-3).solve("elastic-upper")
    assert result.error_estimate is None
    assert "left out: elasticity of the rail beyond the half-space (not estimated" in str(result)


@pytest.mark.coarse
def test_a_large_grid_leaves_out_the_coupling_where_it_does_not_matter() -> None:
    scene = mtb.scenes.paraboloid_on_plane(points=48, friction=0.3, lower=carbide)
    loose, tight = scene.solve(tolerance=0.1), scene.solve(tolerance=1e-3)
    assert "friction in turn" not in loose.report.solver
    assert "friction in turn" in tight.report.solver
    ((effect, size),) = loose.report.omitted.items()
    assert "friction" in effect
    apart = np.linalg.norm(loose.pressure - tight.pressure) / np.linalg.norm(tight.pressure)
    assert 0.5 * size < apart < 2.0 * size
    assert np.allclose(loose.traction[0], 0.3 * loose.pressure)
    assert tight.report.omitted == {}


@pytest.mark.slow
def test_a_spacing_found_is_as_good_as_the_same_one_given() -> None:
    asked: dict[str, Any] = {"tolerance": 0.01, "quantity": "force"}
    found = mtb.scenes.block_on_plane(height=0.25, spacing=None).solve(**asked)
    given = mtb.scenes.block_on_plane(height=0.25, spacing=found.report.spacing).solve(**asked)
    assert found.normal_force == pytest.approx(given.normal_force, rel=1e-12)
    # levels on the way that hardly differ from each other tell noise
    assert found.report.error_estimates["force"] == pytest.approx(
        given.report.error_estimates["force"], rel=0.5
    )
    assert not found.report.missed


def test_a_fuller_model_that_is_refused_leaves_the_answer_of_the_other(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    scene = mtb.scenes.pole_shoe_on_rail(spacing=6e-3, friction=0.3)
    whole, level_at = scene.solve(quantity="displacement", tolerance=0.5), direct.level_at
    monkeypatch.setattr(auto.Ladder, "cheapest", lambda ladder, allowed: ladder.rung(1))

    def without_room(scene: Any, model: str, *args: Any, **kwargs: Any) -> Level:
        if model == "elastic-both" and not kwargs.get("is_rough"):
            raise ValueError("128 contact points take too much")
        return level_at(scene, model, *args, **kwargs)

    monkeypatch.setattr(direct, "level_at", without_room)
    with pytest.warns(
        mtb.ToleranceWarning, match="'elastic-both' would be needed, and is refused: 128"
    ) as told:
        result = scene.solve(quantity="displacement", tolerance=0.3)
    assert whole.model == "elastic-both"
    assert result.model == "elastic-upper"
    assert result.report.missed == str(told[0].message)
    assert result.report.error_estimates["displacement"] > 0.3


@pytest.mark.parametrize("of_supports", [0.2, 0.01])
def test_narrower_cells_are_no_remedy_for_supports_at_points(of_supports: float) -> None:
    solved: list[float] = []

    def solve(spacing: tuple[float, float], before: Any) -> tuple[Any, auto.Errors]:
        solved.append(spacing[0])
        known = {"pressure": 60.0 * spacing[0]}
        level = SimpleNamespace(is_solved=True, operations=spacing[0] ** -3, spacing=spacing)
        return level, auto.Errors(known, {}, supports={"pressure": of_supports})

    level, errors, _, refused = auto.resolved(solve, (1e-3, 1e-3), 0.05, "pressure", lambda *_: True)
    assert not refused
    assert errors is not None
    # they stop where the cells may, or at once
    assert (len(solved) > 1) == (of_supports < 0.05)
    assert level.spacing[0] == solved[-1]
    assert (errors.total("pressure") <= 0.05) == (of_supports < 0.05)
