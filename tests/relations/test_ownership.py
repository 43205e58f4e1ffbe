# SPDX-License-Identifier: MIT OR Apache-2.0
"""Public objects own what they keep: changes of the caller's arrays do not reach them."""

from __future__ import annotations

import copy
import dataclasses
import pickle
from collections.abc import Callable, Iterator, Mapping
from typing import Any

import numpy as np
import pytest

import mtb_rs as mtb
from mtb_rs.base.fingerprint import fingerprint
from mtb_rs.bodies.mesh import block_mesh

LINE = np.linspace(-1.0, 1.0, 9)
BOWL = 1e-5 * np.add.outer(LINE**2, LINE**2)
STEEL = {"lower": mtb.steel, "upper": mtb.steel}
BLOCK = block_mesh([-0.05, 0.0, 0.05], [-0.05, 0.0, 0.05], 0.1)
HELD = mtb.Support("top", x=0, y=0, z=0)


def normal(gap: Any = BOWL) -> mtb.NormalResult:
    return mtb.solve_normal(gap, 1e-4, force=50.0, **STEEL)


def rolled(friction: Any = 0.3, creepage: Any = (1e-3, 0.0, 0.0)) -> mtb.TangentialResult:
    return mtb.solve_tangential(normal(), mtb.Rolling(creepage), mtb.Coulomb(friction))


def table(**arrays: Any) -> mtb.CreepForceTable:
    small = mtb.CreepForceTable.build((1.0,), nodes=4, cells=6)
    return dataclasses.replace(small, **arrays)


def stepped(pose: Any = (0.0, 0.0, float("nan"), 0.0, 0.0, 0.0)) -> mtb.StepResult:
    contact = mtb.scenes.block_on_plane(spacing=0.025).prepare("half-space")
    return contact.step(pose=pose, velocity=(1.0, 0.0))


def wheels(pose: Any = (0.0, 0.0, float("nan"), 0.0, 0.0, 0.0)) -> mtb.WheelStep:
    ready = mtb.scenes.wheel_on_rail(spacing=1e-3, lateral=0.0).prepare()
    return ready.step(pose=pose, velocity=(20.0, 0.0, 0.0, 0.0, 20.1 / 0.46, 0.0))


def tangential_state(shape: tuple[int, int] = (2, 3)) -> dict[str, Any]:
    return {"traction": np.zeros((2, *shape)), "pressure": np.ones(shape), "coefficient": np.ones(shape)}


#: What makes an object of arrays (or lists), each by name.
MAKERS: dict[str, tuple[Callable[..., Any], Callable[[], dict[str, Any]]]] = {
    "Coulomb": (mtb.Coulomb, lambda: {"coefficient": np.full((2, 3), 0.3)}),
    "Coulomb of lists": (mtb.Coulomb, lambda: {"coefficient": [[0.1, 0.2], [0.3, 0.4]]}),
    "TemperatureFriction": (
        mtb.TemperatureFriction,
        lambda: {"temperature": np.array([0.0, 400.0]), "coefficient": [0.4, 0.2]},
    ),
    "TabulatedFriction": (
        mtb.TabulatedFriction,
        lambda: {"slip_speed": np.array([0.0, 1.0]), "coefficient": [0.4, 0.2]},
    ),
    "RailFriction": (
        mtb.RailFriction,
        lambda: {
            "rail_position": np.array([0.0, 0.01]),
            "coefficient": np.full((2, 2), 0.3),
            "x": [0.0, 1.0],
        },
    ),
    "VelocityTable": (
        mtb.VelocityTable,
        lambda: {"velocity": np.array([0.0, 1.0]), "value": [np.full((2, 2), 0.1), [0.2, 0.1]]},
    ),
    "FieldTable": (
        mtb.FieldTable,
        lambda: {"x": np.array([0.0, 1.0]), "y": np.array([0.0, 1.0]), "value": np.ones((2, 2))},
    ),
    "GaussianPressure": (
        lambda **a: mtb.GaussianPressure(1e6, **a),
        lambda: {"center": np.zeros(2), "sigma": np.ones(2)},
    ),
    "PressureField": (
        lambda **a: mtb.PressureField(**a, **STEEL),
        lambda: {"pressure": np.ones((2, 3)), "spacing": np.array([1.0, 1.0]), "origin": np.zeros(2)},
    ),
    "TangentialState": (mtb.TangentialState, tangential_state),
    "Rolling": (mtb.Rolling, lambda: {"creepage": np.full(3, 1e-3), "force": [1.0, None]}),
    "Shift": (mtb.Shift, lambda: {"displacement": np.full(2, 1e-6), "force": np.array([1.0, 2.0])}),
    "Support": (lambda **a: mtb.Support(**a, x=0), lambda: {"where": np.array([[0.0, 0.0, 0.1]])}),
    "TetraMesh": (
        mtb.TetraMesh,
        lambda: {
            "nodes": np.array(BLOCK.nodes),
            "cells": np.array(BLOCK.cells),
            "node_sets": {"contact": np.array(BLOCK.node_sets["contact"])},
        },
    ),
    "ElasticBody": (
        lambda nodes, cells, contact, supports: mtb.ElasticBody(
            mtb.TetraMesh(nodes, cells, BLOCK.node_sets), mtb.steel, contact, supports
        ),
        lambda: {
            "nodes": np.array(BLOCK.nodes),
            "cells": np.array(BLOCK.cells),
            "contact": np.array(BLOCK.nodes[BLOCK.node_sets["contact"]]),
            "supports": [HELD],
        },
    ),
    "Profile": (mtb.Profile.from_points, lambda: {"y": np.linspace(-0.04, 0.04, 9), "z": -(LINE**2)}),
    "PoleShoe": (
        lambda y, z: mtb.PoleShoe(rail=mtb.Profile.from_points(y, z)),
        lambda: {"y": np.linspace(-0.04, 0.04, 9), "z": -5e-3 * LINE**2},
    ),
    "Scene": (
        lambda **a: mtb.Scene(**STEEL, force=50.0, spacing=np.array([1e-4, 1e-4]), **a),
        lambda: {
            "gap": np.array(BOWL),
            "friction": np.full(BOWL.shape, 0.2),
            "sliding_direction": np.array([1.0, 0.0]),
            "moments": np.zeros(2),
        },
    ),
    "ready scene": (
        mtb.scenes.block_on_plane,
        lambda: {
            "friction": np.full((4, 4), 0.1),
            "magnetic_pressure": np.full((4, 4), 1e6),
            "spacing": np.array([0.025, 0.025]),
            "sliding_direction": [1.0, 0.0],
            "supports": [HELD],
        },
    ),
    "shoe with one entry per pole": (
        lambda **a: mtb.scenes.pole_shoe_on_rail(spacing=6e-3, **a),
        lambda: {"friction": [0.1, 0.2], "magnetic_pressure": np.array([2e6, 1e6])},
    ),
    "NormalResult": (normal, lambda: {"gap": np.array(BOWL)}),
    "NormalResult on its own grid": (
        lambda **a: mtb.solve_normal(**a, force=50.0, **STEEL),
        lambda: {"gap": np.array(BOWL), "spacing": np.array([1e-4, 1e-4]), "moments_about_axes": [0.0, 0.0]},
    ),
    "TangentialResult": (rolled, lambda: {"friction": np.full((9, 9), 0.3), "creepage": np.full(3, 1e-4)}),
    "FoundationResult": (
        lambda **a: mtb.fastsim(normal(), friction=mtb.Coulomb(0.3), **a),
        lambda: {"creepage": np.array([1e-3, 0.0, 0.0])},
    ),
    "CreepForceTable": (table, lambda: {"ratios": np.array([1.0])}),
    "Result": (
        lambda **a: mtb.Scene(**STEEL, force=50.0, spacing=1e-4, friction=0.1, **a).solve(),
        lambda: {"gap": np.array(BOWL)},
    ),
    "Result of finite elements": (
        lambda **a: mtb.scenes.block_on_plane(spacing=0.025, **a).solve("elastic-upper"),
        lambda: {"friction": np.full((4, 4), 0.1), "magnetic_pressure": np.full((4, 4), 1e6)},
    ),
    "StepResult": (stepped, lambda: {"pose": np.array([0.0, 0.0, np.nan, 0.0, 0.0, 0.0])}),
    "WheelStep": (wheels, lambda: {"pose": np.array([0.0, 0.0, np.nan, 0.0, 0.0, 0.0])}),
    "StartOfSliding": (
        lambda **a: mtb.scenes.block_on_plane(spacing=0.025, friction=0.1).start_of_sliding(
            **a, model="half-space"
        ),
        lambda: {"displacements": np.array([[1e-7, 0.0], [2e-7, 0.0]])},
    ),
    "AreaLoadCurve": (
        lambda **a: mtb.area_load_curve(BOWL, 1e-4, lower=mtb.steel, upper=mtb.steel, **a),
        lambda: {"forces": np.array([10.0, 50.0])},
    ),
    "BodySurface": (
        lambda **a: mtb.BodySurface.height_field(**a, spacing=1e-4),
        lambda: {"heights": np.array(BOWL)},
    ),
    "SweepTable": (
        lambda **a: mtb.sweep(mtb.scenes.paraboloid_on_plane(points=6), {"friction": a["friction"]}),
        lambda: {"friction": [0.1, 0.2]},
    ),
}


def arrays(value: Any, seen: set[int]) -> Iterator[np.ndarray]:
    """All arrays that a public object keeps, but for the caches of bodies."""
    if id(value) in seen:
        return
    seen.add(id(value))
    if isinstance(value, np.ndarray):
        yield value
    elif dataclasses.is_dataclass(value):
        for f in dataclasses.fields(value):
            if not f.name.startswith("_") and f.name != "parts":
                yield from arrays(getattr(value, f.name), seen)
    elif isinstance(value, Mapping):
        for entry in value.values():
            yield from arrays(entry, seen)
    elif isinstance(value, (list, tuple)):
        for entry in value:
            yield from arrays(entry, seen)


def words(value: Any) -> str:
    """All that the object holds, as text; of a table of times without them."""
    if isinstance(value, mtb.BodySurface):
        return repr(value.top(LINE * 1e-4, LINE * 1e-4).tolist())
    if isinstance(value, mtb.SweepTable):
        return repr((value.parameters, [c.tolist() for c in value.columns.values()], value.status.tolist()))
    if isinstance(value, (mtb.StepResult, mtb.AreaLoadCurve)):
        return repr([a.tolist() for a in arrays(value, set())])
    return fingerprint(value)


def spoil(value: Any) -> None:
    """Changes all that can be changed of an argument."""
    if isinstance(value, np.ndarray):
        value *= 3.0 if value.dtype.kind == "f" else 0
        value += 1
    elif isinstance(value, list):
        for entry in value:
            spoil(entry)
        value.clear()
    elif isinstance(value, dict):
        for entry in value.values():
            spoil(entry)
        value.clear()


@pytest.mark.coarse
@pytest.mark.parametrize("name", MAKERS)
def test_objects_own_what_they_keep(name: str) -> None:
    make, given = MAKERS[name]
    arguments = given()
    made = make(**arguments)
    before = words(made)
    for value in arguments.values():
        spoil(value)
    assert words(made) == before
    for kept in arrays(made, set()):
        assert not kept.flags.writeable
        if kept.size and not kept.dtype.hasobject:
            with pytest.raises(ValueError, match="WRITEABLE"):
                kept.flags.writeable = True


@pytest.mark.coarse
@pytest.mark.parametrize(
    "name", ["Coulomb", "TangentialState", "NormalResult", "Result", "StepResult", "WheelStep"]
)
def test_copies_own_what_they_keep(name: str) -> None:
    make, given = MAKERS[name]
    made = make(**given())
    for again in (pickle.loads(pickle.dumps(made)), copy.deepcopy(made)):
        assert words(again) == words(made)
        assert not any(kept.flags.writeable for kept in arrays(again, set()))


def test_what_is_built_on_a_result_does_not_move_with_the_gap() -> None:
    gap = np.array(BOWL)
    bodies = {"lower": mtb.steel, "upper": mtb.Material(2e10, 0.1)}
    found = mtb.solve_normal(gap, 1e-4, force=50.0, **bodies)
    slide = mtb.Shift((1e-6, 0.0))
    first = mtb.solve_tangential(found, slide, mtb.Coulomb(0.3), coupling="full")
    gap *= 3.0
    second = mtb.solve_tangential(found, slide, mtb.Coulomb(0.3), coupling="full")
    np.testing.assert_array_equal(first.traction, second.traction)
