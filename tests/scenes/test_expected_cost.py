# SPDX-License-Identifier: MIT OR Apache-2.0
"""What a scene says that it would take is what its solve takes: points, unknowns, operations."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import mtb_rs as mtb
from mtb_rs.bodies.mesh import block_mesh

pytestmark = pytest.mark.coarse


def shoe(**given: Any) -> mtb.Scene:
    return mtb.scenes.pole_shoe_on_rail(**{"spacing": 8e-3, **given})


def block(**given: Any) -> mtb.Scene:
    return mtb.scenes.block_on_plane(**{"spacing": 12.5e-3, **given})


def own(z: Any, **given: Any) -> mtb.Scene:
    """A block of its own mesh on a half-space."""
    lines = np.linspace(-0.05, 0.05, 6)
    body = mtb.ElasticBody(block_mesh(lines, lines, 0.05), mtb.steel, supports=[mtb.Support("top", 0, 0, z)])
    return mtb.Scene(**{"upper": body, "lower": mtb.steel, "spacing": 1e-2, **given})


SPHERE = mtb.scenes.paraboloid_on_plane
SCENES: dict[str, tuple[mtb.Scene, Any]] = {
    "symmetric shoe": (shoe(), "auto"),
    "shoe of half-spaces": (shoe(), "half-space"),
    "elastic shoe": (shoe(), "elastic-upper"),
    "shoe on five points": (shoe(supports="points"), "elastic-upper"),
    "shifted shoe": (shoe(lateral=2e-3), "elastic-upper"),
    "other friction on the right": (shoe(friction=[0.1, 0.3]), "elastic-both"),
    "other pull on the right": (shoe(magnetic_pressure=[3e6, 2e6]), "elastic-both"),
    "one pole on a rigid rail": (shoe(poles=1, lower=mtb.Rigid()), "auto"),
    "block": (block(), "auto"),
    "long block, fine elements": (block(length=0.2).with_(element_size=8e-3), "elastic-upper"),
    "half-spaces by convolutions": (block(spacing=1e-3), "half-space"),
    "sphere": (SPHERE(), "auto"),
    "large grid": (SPHERE(points=80), "auto"),
    "unlike bodies": (SPHERE(points=80, lower=mtb.Rigid()), "auto"),
    "wheel": (mtb.scenes.wheel_on_rail(spacing=4e-4), "auto"),
    "own body": (own(None, force=1e4), "auto"),
    "own body on a guide": (own(mtb.Guide(-1e4)), "auto"),
    "own body under half a gap": (
        own(None, force=1e4, gap=lambda x, y: np.where(x < 0.011, 1e-6 + 0.0 * y, np.inf)),
        "auto",
    ),
}


@pytest.mark.parametrize("name", SCENES)
def test_what_is_counted_is_what_is_solved(name: str) -> None:
    scene, model = SCENES[name]
    expected = scene.expected_cost(model)
    solved = scene.solve(model)
    assert solved.coefficients is not None
    cost = {cost.name: cost for cost in expected.costs}[solved.report.model]
    assert cost.points == solved.coefficients.shape[1]
    # a pole that is the image of the other one is not condensed
    condensed = {
        id(c.flexibility): (p, c) for p, c in ((p, p.body.condense(p.sampling())) for p in solved.parts)
    }
    unknowns = {p.body.name: int(c.cost["unknowns"]) for p, c in condensed.values()}
    if "right pole" not in cost.unknowns:
        unknowns.pop("right pole", None)
    assert cost.unknowns == unknowns
    taken = sum(solved.report.operations.values())
    assert 0.5 * taken < cost.operations < 2.0 * taken


def test_a_chosen_model_is_counted_for_each_that_may_be_chosen() -> None:
    said = shoe().expected_cost()
    assert [cost.name for cost in said.costs] == ["half-space", "elastic-upper", "elastic-both"]
    assert "half-space, elastic-upper and elastic-both" in said.choice
    assert shoe().expected_cost("elastic-upper").choice == ""
    sizes = [(cost.memory, cost.operations, cost.time) for cost in said.costs]
    assert sizes == sorted(sizes)
    assert "rough" in dict(said.told())["how sure"]
    assert str(said.costs[-1].unknowns["rail"]) in dict(said.told())["elastic-both"]


def test_cells_that_the_tolerance_chooses_are_counted_from_the_first_ones() -> None:
    said = SPHERE(points=None).expected_cost()
    assert "until the tolerance is met" in said.choice
    assert said.costs[0].points < SPHERE(points=None).solve(tolerance=0.02).pressure.size


@pytest.mark.parametrize(
    "asked",
    [
        {"model": "elastic"},
        {"method": "fast"},
        {"tolerance": 2.0},
        {"steps": 3},
        {"method": "staggered", "model": "half-space"},
        {"method": "staggered", "model": "elastic-both"},
    ],
)
def test_what_solve_refuses_is_refused(asked: dict[str, Any]) -> None:
    with pytest.raises(ValueError, match=r"\w") as solving:
        shoe().solve(**asked)
    with pytest.raises(ValueError, match=r"\w") as counting:
        shoe().expected_cost(**asked)
    assert str(counting.value) == str(solving.value)


def test_loads_that_solve_refuses_are_refused() -> None:
    scene = shoe(magnetic_pressure=[3e6, 0.0])
    with pytest.raises(ValueError, match="does not press"):
        scene.expected_cost()
    with pytest.raises(ValueError, match="fewer, larger cells"):
        shoe(spacing=2e-5).expected_cost()
