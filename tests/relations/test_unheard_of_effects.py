# SPDX-License-Identifier: MIT OR Apache-2.0
"""What a scene states and a way of solving does not take is refused, or goes another way: never ignored."""

from __future__ import annotations

from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any, get_type_hints

import numpy as np
import pytest

import mtb_rs as mtb
from mtb_rs.base.units import ARGUMENT_UNITS
from mtb_rs.contact.problem import ContactProblem
from mtb_rs.scenes.scene import Scene, WheelScene
from mtb_rs.scenes.taken import TAKEN
from mtb_rs.studies.chart_scene import chart, closed_form

X = np.arange(-25, 26) * 0.6e-3
BALL = mtb.Scene(
    mtb.steel,
    mtb.steel,
    gap=(X[None, :] ** 2 + X[:, None] ** 2) / 20.0,
    spacing=0.6e-3,
    friction=0.3,
    force=2000.0,
)
WHEEL = mtb.scenes.wheel_on_rail(spacing=1e-3)


@dataclass(frozen=True)
class Unheard(Scene):
    """A scene with an effect that nothing in the library knows of."""

    effect: float | None = None


@dataclass(frozen=True)
class UnheardWheel(WheelScene):
    effect: float | None = None


def unheard(scene: Scene, kind: type[Any] = Unheard) -> Any:
    given = {f.name: getattr(scene, f.name) for f in fields(scene)} | {"recipe": None}
    return kind(**given, effect=1.0)


def test_ways_take_what_scenes_have() -> None:
    known = {f.name for f in fields(Scene)}
    for way, taken in TAKEN.items():
        assert taken <= known, way


@pytest.mark.coarse  # some points of contact
def test_large_grids_with_another_effect_are_not_solved_by_convolutions_of_the_bodies() -> None:
    with_effect, without = unheard(BALL).solve(), BALL.solve()
    assert "FFT" in without.report.solver
    assert "FFT" not in with_effect.report.solver
    assert with_effect.pressure == pytest.approx(without.pressure, abs=1e-6 * without.pressure.max())


@pytest.mark.parametrize(("model", "method"), [("half-space", "incremental"), ("elastic-upper", "staggered")])
def test_the_methods_of_the_thesis_refuse_another_effect(model: Any, method: Any) -> None:
    shoe = unheard(mtb.scenes.pole_shoe_on_rail(spacing=6e-3))
    with pytest.raises(ValueError, match=r"effect is 1\.0: .* cannot take it, only None"):
        shoe.solve(model, method)


@pytest.mark.parametrize(
    ("scene", "name"),
    [
        (unheard(WHEEL, UnheardWheel), "effect"),
        (WHEEL.with_(moments=(1.0, 0.0)), "moments"),
        (WHEEL.with_(velocity=20.0), "velocity"),
        (WHEEL.with_(attraction="both"), "attraction"),
    ],
)
def test_wheels_in_steps_refuse_what_they_do_not_take(scene: Scene, name: str) -> None:
    with pytest.raises(ValueError, match=f"{name} is .*: wheels in steps cannot take it"):
        scene.prepare()


def test_wheels_in_steps_have_the_layer_of_their_scene() -> None:
    layer = mtb.InterfaceLayer(thickness=20e-6, shear_modulus=50e6)
    creeping = (10.0, 0.0, 0.0, 0.0, 0.998 * 10.0 / 0.46, 0.0)
    of_scene = WHEEL.with_(layer=layer).prepare().step(velocity=creeping).force
    assert of_scene == pytest.approx(WHEEL.prepare(layer=layer).step(velocity=creeping).force, rel=1e-12)
    # it softens the creep force
    assert abs(of_scene[0]) < 0.8 * abs(WHEEL.prepare().step(velocity=creeping).force[0])


def test_charts_judge_another_effect_by_no_closed_form() -> None:
    ready = mtb.scenes.paraboloid_on_plane(points=12)
    assert closed_form(ready) is not None
    assert closed_form(unheard(ready)) is None


def errors(scene: Scene) -> dict[str, list[float]]:
    """Errors of the force by series, of what a chart has in a short time."""
    made = chart(scene, quantity="force", budget=2.0, repeats=1, progress=None)
    found: dict[str, list[float]] = {}
    for point in made.points:
        found.setdefault(point.series, []).extend(e for q, e in point.errors.items() if q == "force")
    return found


@pytest.mark.parametrize(
    "friction",
    [np.full((51, 51), 0.3), lambda x, y: 0.3 + 0.0 * x, mtb.VelocityTable((0.0, 1.0), (0.3, 0.3))],
)
def test_charts_do_not_solve_friction_that_varies_without_friction(friction: Any) -> None:
    found = errors(BALL.with_(friction=friction, velocity=0.5))
    assert "half-space, FFT" not in found
    # a ball's friction force is the coefficient times its load, on any grid
    assert found["half-space, direct"]
    assert max(found["half-space, direct"]) < 1e-6


def test_charts_do_not_solve_an_attracted_rail_as_if_it_were_not() -> None:
    block = mtb.scenes.block_on_plane(friction=0.0, spacing=0.02, attraction="both")
    assert "half-space, FFT" not in errors(block)


@pytest.mark.coarse
def test_results_tell_what_their_scene_states(tmp_path: Path) -> None:
    leaning = mtb.scenes.block_on_plane(spacing=0.02, friction=0.1).with_(moments=(0.0, 5.0))
    leaning.solve("half-space").save(tmp_path)
    told = mtb.load(tmp_path).summary
    assert list(told["moments"]) == [0.0, 5.0]
    assert told["friction"] == 0.1
    own = unheard(BALL.with_(gap=BALL.gap[16:35, 16:35])).solve().summary  # type: ignore[index]
    assert (own["force"], own["friction"], own["effect"]) == (2000.0, 0.3, 1.0)


def test_every_number_of_a_scene_has_a_unit_in_sweeps_and_animations() -> None:
    ready = [getattr(mtb.scenes, name) for name in ("block_on_plane", "paraboloid_on_plane")]
    ready += [mtb.scenes.pole_shoe_on_rail, mtb.scenes.wheel_on_rail]
    for made in (mtb.Scene, *ready):
        hints = get_type_hints(made)
        numbers = [name for name in hints if hints[name] in (float, float | None, int, int | None)]
        assert set(numbers) <= set(ARGUMENT_UNITS), made
        assert numbers


def test_the_pair_of_a_problem_is_its_two_bodies() -> None:
    problem: ContactProblem = BALL.with_(gap=BALL.gap[:9, :9]).problem("half-space")  # type: ignore[index]
    pressed = np.zeros((3, problem.n))
    pressed[2] = 1e6
    both = [side.compliance.displacement(pressed)[2] for side in (problem.upper, problem.lower)]
    assert problem.core.pair.displacement(pressed)[2] == pytest.approx(sum(both), rel=1e-12)
