# SPDX-License-Identifier: MIT OR Apache-2.0
"""Every way of asking, of scenes whose contact points are too many to condense bodies onto all of them.

What makes them too many is set so low that small scenes are; the answers are compared with those of direct
condensation, of which the errors of both are a few per cent on such wide cells.
"""

from __future__ import annotations

import pickle
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import mtb_rs as mtb
from mtb_rs import _mtb_rs
from mtb_rs.base import cache
from mtb_rs.bodies.elastic_body import ElasticBody
from mtb_rs.commands import main
from mtb_rs.contact import refined
from mtb_rs.contact.solve import BY_PRODUCTS
from mtb_rs.scenes import cost

pytestmark = pytest.mark.coarse


@pytest.fixture
def many(monkeypatch: pytest.MonkeyPatch) -> Iterator[Callable[..., None]]:
    """Makes all contacts ones of many points, or of few."""

    def make(many: bool = True) -> None:
        monkeypatch.setattr(refined, "DIRECT_POINTS", 0 if many else 10**9)
        monkeypatch.setattr(refined, "PRODUCTS_FROM", 0 if many else 10**9)
        monkeypatch.setattr(refined, "CELLS", 60)
        cache.forget()

    with cache.memory_only():
        yield make
    cache.forget()


def shoe(**given: Any) -> mtb.Scene:
    return mtb.scenes.pole_shoe_on_rail(**{"spacing": (4.5e-3, 2e-3), "friction": 0.3, **given})


def block(**given: Any) -> mtb.Scene:
    return mtb.scenes.block_on_plane(**{"spacing": 7e-3, "friction": 0.3, **given})


LAW = mtb.PressureDependentFriction(lambda p: 0.3 / (1.0 + p / 1e8))
SCENES: dict[str, tuple[mtb.Scene, Any]] = {
    "shoe": (shoe(), "elastic-upper"),
    "one pole": (shoe(poles=1), "elastic-upper"),
    "on five points": (shoe(supports="points"), "elastic-upper"),
    "unlike pulls": (shoe(magnetic_pressure=(3e6, 2e6)), "elastic-upper"),
    "attracted on both sides": (shoe(attraction="both"), "elastic-both"),
    "turned": (shoe(yaw=0.01), "elastic-upper"),
    "shifted": (shoe(lateral=1e-3), "elastic-upper"),
    "unlike friction": (shoe(friction=(0.1, 0.3)), "elastic-upper"),
    "field of friction": (shoe(friction=lambda x, y: 0.2 + 50.0 * x**2), "elastic-upper"),
    "friction of the pressure": (shoe(friction=LAW), "elastic-upper"),
    "sliding aslant": (shoe(sliding_direction=(1.0, 0.5)), "elastic-upper"),
    "at rest": (shoe(sliding_direction=None), "elastic-upper"),
    "block that may tilt": (block(supports="driven-top", friction=0.1), "elastic-upper"),
    "clamped block": (block(), "elastic-upper"),
    "hard": (shoe(hardness=7e6), "elastic-upper"),
    "rough": (shoe(normal_layer=mtb.RoughLayer.exponential(1e10, 1e-6)), "elastic-upper"),
    "block on a rigid plane": (block(lower=mtb.Rigid()), "elastic-upper"),
}


@pytest.mark.parametrize("name", SCENES)
@pytest.mark.filterwarnings("ignore:The estimated error")
def test_scenes_of_all_kinds_are_solved_by_products(name: str, many: Callable[..., None]) -> None:
    scene, model = SCENES[name]
    many(False)
    expected = scene.solve(model)
    assert not expected.report.notes
    many()
    found = scene.solve(model)
    assert found.report.converged
    assert found.report.solver.startswith(BY_PRODUCTS)
    assert found.report.force_balance["relative_error"] < 1e-8
    assert found.force == pytest.approx(expected.force, rel=1e-2, abs=1e-2 * expected.normal_force)
    error = np.linalg.norm(found.pressure - expected.pressure) / np.linalg.norm(expected.pressure)
    assert error < 0.06


@pytest.mark.filterwarnings("ignore:The estimated error")
def test_what_is_not_computed_is_said(many: Callable[..., None], tmp_path: Path) -> None:
    many()
    result = shoe().solve("elastic-upper")
    assert result.report.wedging_margin is None
    (note,) = result.report.notes
    assert "margin to wedging" in note
    assert "stability" in note
    assert note in str(result)
    # and it is kept
    result.save(tmp_path / "out")
    for kept in (mtb.load(tmp_path / "out"), pickle.loads(pickle.dumps(result))):
        assert kept.report.notes == result.report.notes
        assert (kept.pressure == result.pressure).all()
    # without friction there is no margin, and nothing is missing
    assert not shoe(sliding_direction=None).solve("elastic-upper").report.notes


@pytest.mark.filterwarnings("ignore:The estimated error")
@pytest.mark.slow
def test_an_auto_model_and_its_estimate(many: Callable[..., None]) -> None:
    many(False)
    expected = shoe().solve()
    many()
    found = shoe().solve()
    assert found.model == expected.model
    assert found.error_estimate is not None
    assert expected.error_estimate is not None
    error = np.abs(found.pressure - expected.pressure).max() / expected.pressure.max()
    # no better than it is
    assert error < found.error_estimate + expected.error_estimate


def test_steps_and_the_start_of_sliding_take_the_same_bodies(many: Callable[..., None]) -> None:
    many()
    scene = block()
    solved = scene.solve("elastic-upper")
    stepped = scene.prepare("elastic-upper").step(velocity=1.0)
    assert stepped.pressure == pytest.approx(solved.pressure.ravel(), abs=1e-6 * solved.pressure.max())
    start = scene.start_of_sliding([[1e-4, 0.0]], "elastic-upper")
    assert start.force[-1] == pytest.approx(solved.force[:2], rel=1e-3, abs=1.0)


@pytest.mark.filterwarnings("ignore:The estimated error")
def test_the_half_of_a_shoe_and_its_rail_is_their_whole(many: Callable[..., None]) -> None:
    many()
    scene = shoe(spacing=(6e-3, 4e-3))
    half, whole = (
        scene.problem("elastic-both", carrier=(12e-3, 6e-3), may_halve=may_halve)
        for may_halve in (True, False)
    )
    assert half.lower.state[0].is_half
    assert not whole.lower.state[0].is_half
    rng = np.random.default_rng(3)
    one = rng.standard_normal((3, half.n // 2))
    (left, right), n = half.patches, half.n // 2
    assert (left.nx, left.ny) == (right.nx, right.ny)
    # the image of a load: rows the other way round, what is across to the other side
    image = one.reshape(3, left.ny, left.nx)[:, ::-1].reshape(3, n) * [[1.0], [-1.0], [1.0]]
    load = np.concatenate([one, image], axis=1)
    moved = [p.lower.compliance.displacement(load) for p in (half, whole) if p.lower.compliance is not None]
    assert moved[0] == pytest.approx(moved[1], abs=1e-9 * np.abs(moved[1]).max())
    solved = scene.solve("elastic-both")
    assert "mirror half" in solved.report.solver
    stepped = scene.prepare("elastic-both").step(velocity=1.0)
    assert stepped.pressure == pytest.approx(solved.pressure.ravel(), abs=1e-7 * solved.pressure.max())


@pytest.mark.filterwarnings("ignore:The estimated error")
def test_sweeps_and_the_command_line(many: Callable[..., None], tmp_path: Path) -> None:
    many()
    scene = block()
    table = mtb.sweep(scene, {"friction": [0.1, 0.3]}, model="elastic-upper")
    one = scene.solve("elastic-upper")
    assert table["normal_force"][-1] == pytest.approx(one.normal_force, rel=1e-6)
    assert np.isnan(table["wedging_margin"]).all()
    case = tmp_path / "case.toml"
    case.write_text(
        'scene = "block_on_plane"\nspacing = 7e-3\nfriction = 0.3\n[solve]\nmodel = "elastic-upper"\n'
    )
    assert main(["run", str(case), "-o", str(tmp_path / "out")]) == 0
    assert mtb.load(tmp_path / "out").normal_force == pytest.approx(one.normal_force, rel=1e-6)


def test_a_body_that_is_refused_is_condensed_directly_and_said(
    many: Callable[..., None], monkeypatch: pytest.MonkeyPatch
) -> None:
    many(False)
    expected = block().solve("elastic-upper")
    many()

    def refuse(*args: Any) -> None:
        raise ValueError("the body is too stiff")

    monkeypatch.setattr(_mtb_rs, "refined", refuse)
    found = block().solve("elastic-upper")
    assert found.pressure == pytest.approx(expected.pressure, rel=1e-6)
    (note,) = found.report.notes
    assert "condensed onto all of its contact points" in note
    assert "too stiff" in note
    assert found.report.wedging_margin == expected.report.wedging_margin


def test_a_body_that_wedges_is_not_answered(many: Callable[..., None]) -> None:
    many()
    with pytest.raises(mtb.ConvergenceError) as caught:
        block(friction=2.0).solve("elastic-upper")
    assert "Solve on wider cells" in str(caught.value)


def test_the_cost_is_that_of_the_solve(many: Callable[..., None]) -> None:
    many()
    cost = shoe().expected_cost("elastic-upper").costs[-1]
    problem = shoe().problem("elastic-upper")
    assert cost.points == problem.n
    parts = {part.body.name: part.body.unknowns for part in problem.parts}
    assert all(parts[name] == count for name, count in cost.unknowns.items())


@pytest.fixture
def small_factors(monkeypatch: pytest.MonkeyPatch) -> Iterator[Callable[[int], None]]:
    """Refuses meshes of more unknowns, as those are refused whose factor takes too much memory."""
    condense = ElasticBody.condense

    def make(most: int) -> None:
        def refusing(self: ElasticBody, *given: Any) -> Any:
            if self.unknowns > most:
                raise mtb.TooLargeError(f"{self.unknowns} unknowns are too many")
            return condense(self, *given)

        monkeypatch.setattr(ElasticBody, "condense", refusing)
        cache.forget()

    monkeypatch.setattr(refined, "CELLS", 40)
    with cache.memory_only():
        cache.forget()
        yield make
    cache.forget()


@pytest.mark.parametrize(
    ("scene", "model", "body"),
    [
        (block(width=0.1, length=0.06, height=0.08, spacing=5e-3), "elastic-upper", "upper"),
        (shoe(spacing=(3e-3, 1.2e-3)), "elastic-upper", "upper"),
        (shoe(spacing=(4e-3, 1.8e-3)), "elastic-both", "lower"),
        (shoe(spacing=(5e-3, 1.8e-3), friction=(0.1, 0.3)), "elastic-both", "lower"),
    ],
)
@pytest.mark.filterwarnings("ignore:The estimated error")
def test_bodies_too_large_on_all_points_are_condensed_onto_fewer(
    scene: mtb.Scene, model: Any, body: str, small_factors: Callable[[int], None], tmp_path: Path
) -> None:
    small_factors(10**9)
    expected = scene.solve(model)
    assert not expected.report.notes
    largest = max(scene.expected_cost(model).costs[-1].unknowns.values())
    small_factors(largest - 1)
    found = scene.solve(model)
    (note,) = found.report.notes
    assert f"The {body} body was condensed onto fewer points than touch" in note
    assert f"{largest} unknowns are too many" in note
    assert found.pressure.size == expected.pressure.size
    assert found.normal_force == pytest.approx(expected.normal_force, rel=1e-3)
    error = np.linalg.norm(found.pressure - expected.pressure) / np.linalg.norm(expected.pressure)
    assert 0.0 < error < 0.06
    if model == "elastic-upper":
        # steps take whole rails
        stepped = scene.prepare(model).step(velocity=1.0)
        assert stepped.force[2] == pytest.approx(found.force[2], rel=1e-6)
    found.save(tmp_path / "out")
    assert mtb.load(tmp_path / "out").report.notes == (note,)


def test_what_is_too_large_on_fewer_points_too_is_refused_for_its_own_size(
    small_factors: Callable[[int], None],
) -> None:
    scene = block()
    largest = scene.expected_cost("elastic-upper").costs[-1].unknowns["block"]
    small_factors(0)
    with pytest.raises(mtb.TooLargeError, match=f"^{largest} unknowns"):
        scene.solve("elastic-upper")


def test_the_expected_cost_of_bodies_too_large_is_that_on_fewer_points(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    scene = block(width=0.1, length=0.06, height=0.08, spacing=4e-3)
    before = scene.expected_cost("elastic-upper").costs[-1]
    monkeypatch.setattr(cost, "FACTOR_MEMORY", 0.0)
    after = scene.expected_cost("elastic-upper").costs[-1]
    assert after.points == before.points
    assert after.unknowns["block"] < before.unknowns["block"]
    assert after.operations < before.operations


def test_meshes_with_too_many_tetrahedra_are_too_large() -> None:
    with pytest.raises(mtb.TooLargeError, match="element_size") as refused:
        block().with_(element_size=1e-5).solve("elastic-upper")
    assert isinstance(refused.value, ValueError)
    assert isinstance(pickle.loads(pickle.dumps(refused.value)), mtb.TooLargeError)
