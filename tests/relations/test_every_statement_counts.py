# SPDX-License-Identifier: MIT OR Apache-2.0
"""Each field of a scene changes the answer of each way of asking, is refused by name, or is known as idle.

A field that is new fails here until it has a line in `CHANGES`; where it is ignored, until it is taken.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable
from dataclasses import fields, replace
from typing import Any

import numpy as np
import pytest

import mtb_rs as mtb
from mtb_rs.bodies.mesh import block_mesh
from mtb_rs.scenes.posed import PosedScene

Array = np.ndarray[Any, np.dtype[np.float64]]
aluminium = mtb.Material(70e9, 0.33)


def ball(cells: int) -> mtb.Scene:
    x = (np.arange(cells) - cells // 2) * 30e-3 / cells
    gap = (x[None, :] ** 2 + x[:, None] ** 2) / 20.0
    return mtb.Scene(aluminium, mtb.steel, gap=gap, spacing=30e-3 / cells, friction=0.3, force=2000.0)


def pad() -> mtb.Scene:
    mesh = block_mesh(np.linspace(-0.04, 0.04, 5), np.linspace(-0.02, 0.02, 3), 0.03)
    body = mtb.ElasticBody(mesh, aluminium, "contact", [mtb.Support("top", x=0, y=0)], "pad")
    return mtb.Scene(body, mtb.steel, spacing=2e-2, friction=0.2, magnetic_pressure=1e6)


BLOCK = mtb.scenes.block_on_plane(spacing=0.02, friction=0.2, lower=aluminium)
SHOE = mtb.scenes.pole_shoe_on_rail(spacing=9e-3, poles=1, friction=0.2)
WHEEL = mtb.scenes.wheel_on_rail(spacing=1e-3)
CREEPING = (10.0, 0.0, 0.0, 0.0, 0.998 * 10.0 / 0.46, 0.0)


def solved(model: Any = "auto", method: Any = "direct") -> Callable[[mtb.Scene], Array]:
    return lambda scene: answer(scene.solve(model, method))


def stepped(model: Any, **pressed: Any) -> Callable[[mtb.Scene], Array]:
    return lambda scene: answer(scene.prepare(model).step(**pressed))


def answer(result: Any) -> Array:
    return np.concatenate([np.ravel(result.pressure), np.ravel(result.force)])


#: What is asked of which scene.
WAYS: dict[str, tuple[mtb.Scene, Callable[[mtb.Scene], Array]]] = {
    "half-spaces": (BLOCK, solved("half-space")),
    "elastic-upper": (BLOCK, solved("elastic-upper")),
    "elastic-both": (SHOE, solved("elastic-both")),
    "own body": (pad(), solved()),
    "small field": (ball(20), solved()),
    "large field": (ball(46), solved()),
    "steps of half-spaces": (BLOCK, stepped("half-space")),
    "steps": (BLOCK, stepped("elastic-upper")),
    "start of sliding": (BLOCK, lambda scene: answer(scene.start_of_sliding([[1e-7, 5e-8], [1e-4, 5e-5]]))),
    "load increments": (ball(20).with_(upper=mtb.steel, friction=0.05), solved("half-space", "incremental")),
    "staggered loop": (BLOCK, solved("elastic-upper", "staggered")),
    "wheel": (WHEEL, solved()),
    "wheels in steps": (WHEEL, lambda scene: scene.prepare().step(velocity=CREEPING).force),
}

TABLE = {"friction": mtb.VelocityTable((0.0, 10.0), (0.1, 0.4))}
#: By field: the arguments of a scene before, and those with the field changed.
CHANGES: dict[str, tuple[dict[str, Any], dict[str, Any]]] = {
    "upper": ({}, {"upper": mtb.Material(100e9, 0.1)}),
    "lower": ({}, {"lower": mtb.Material(100e9, 0.1)}),
    "gap": ({}, {"gap": np.add.outer(np.linspace(-1, 1, 46) ** 2, np.linspace(-1, 1, 46) ** 2) * 4e-5}),
    "spacing": ({}, {"spacing": 0.8}),
    "friction": ({}, {"friction": 0.1}),
    "sliding_direction": ({}, {"sliding_direction": (0.0, 1.0)}),
    "force": ({}, {"force": 2500.0}),
    "approach": ({}, {"approach": 2e-5}),
    "moments": ({}, {"moments": (0.0, 1.0)}),
    "magnetic_pressure": ({}, {"magnetic_pressure": 2e6}),
    "attraction": ({}, {"attraction": "both"}),
    "velocity": (TABLE | {"velocity": 2.0}, TABLE | {"velocity": 5.0}),
    "layer": ({}, {"layer": mtb.InterfaceLayer(thickness=20e-6, shear_modulus=50e6)}),
    # a thinner one changes too little for model="auto" to keep it
    "normal_layer": ({}, {"normal_layer": 1e-12}),
    # any pressure reaches it
    "hardness": ({}, {"hardness": 4e5}),
    "supports": ({}, {"supports": "points"}),
    "element_size": ({}, {"element_size": 0.01}),
}
HALF_SPACES = {"half-spaces", "steps of half-spaces"}
FIELDS = {"small field", "large field", "load increments"}
#: Ways in which a field has nothing to act on.
IDLE: dict[str, set[str]] = {
    # nothing is pulled
    "attraction": FIELDS | {"wheel"},
    # everything slides, or nothing does
    "layer": set(WAYS) - {"start of sliding", "wheels in steps"},
    # of finite elements
    "supports": HALF_SPACES,
    "element_size": HALF_SPACES,
    # pressed down without rolling, and without friction
    "friction": {"wheel"},
    "velocity": {"wheel"},
    # both bodies are pressed at rest, the displacements give the direction
    "sliding_direction": {"start of sliding", "wheels in steps"},
}


def test_every_field_has_a_change() -> None:
    made_by = {"geometry", "name", "inputs", "recipe"}
    assert {f.name for f in fields(PosedScene)} - made_by == set(CHANGES)


@pytest.mark.filterwarnings("ignore")  # some of it is coarse, or unlikely
@pytest.mark.parametrize(("way", "field"), list(itertools.product(WAYS, CHANGES)))
def test_it_counts(way: str, field: str) -> None:
    scene, ask = WAYS[way]
    before, after = CHANGES[field]
    if way == "own body" and field == "upper":
        after = {"upper": replace(scene.upper, material=mtb.steel)}  # type: ignore[type-var]
    if way == "wheel" and field == "normal_layer":
        # under a thicker one it reaches the edge of its grid
        after = {"normal_layer": 1e-14}
    if field == "spacing":
        after = {"spacing": 0.8 * scene.known_spacing[0]}
    refused = None
    try:
        other = ask(scene.with_(**after))
    except ValueError as error:
        refused = str(error).replace(" ", "_")
    if refused is not None:
        assert field in refused
        return
    one = ask(scene.with_(**before))
    same = one.shape == other.shape and np.abs(one - other).max() <= 1e-9 * np.abs(one).max()
    is_idle = way in IDLE.get(field, ())
    assert same == is_idle, f"{field} {'changes the answer' if is_idle else 'is ignored'}"
