# SPDX-License-Identifier: MIT OR Apache-2.0
"""Bodies, geometries, friction, loads, motions and results answer for themselves: only doors, where input is
checked, ask for their kind."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from pathlib import Path

import pytest

from mtb_rs.friction.fields import Coefficients, Form
from mtb_rs.friction.laws import WheelFriction
from mtb_rs.friction.wear_laws import WearLaw
from mtb_rs.geometry.geometries import Geometry
from mtb_rs.half_space.motions import Motion
from mtb_rs.results.savable import Savable

PACKAGE = Path(__file__).parents[2] / "python" / "mtb_rs"


def family(made: type) -> set[str]:
    """A class and all that are made from it, by name."""
    below: type
    names = {made.__name__}
    for below in made.__subclasses__():
        names |= family(below)
    return names


#: Classes of which only doors ask.
KINDS = {
    "bodies": {"HalfSpace", "Layered", "Prism", "Rigid", "Simple", "Viscoelastic", "ElasticBody"},
    "geometries": family(Geometry),
    "friction and loads": family(Form) | family(WheelFriction) | family(Coefficients),
    "motions": family(Motion),
    "laws of wear": family(WearLaw),
    "supports": {"Guide"},
    "results": family(Savable),
}
#: Functions that take what a user gives.
DOORS = {
    "bodies": {
        "bodies/simple.py": {
            "__post_init__",
            "are_layered",
            "are_prisms",
            "are_unlike",
            "as_body",
            "do_creep",
            "medium_of",
            "not_prism",
            "prism_of",
            "without_layers",
        },
        "case/values.py": {"_body"},
        "contact/standing.py": {"cells_of", "hats_of"},
        "half_space/pressure_field.py": {"__post_init__", "_half_space", "pair_modulus"},
        "scenes/posed.py": {"__post_init__", "_check_layers", "_surface", "check_model", "solids"},
        "simulation/vibration.py": {"vibration"},
    },
    "geometries": {"scenes/posed.py": {"__post_init__"}},
    "friction and loads": {
        "case/values.py": {"_field"},
        "friction/fields.py": {"as_form"},
        "friction/laws.py": {"as_law", "as_wheel_friction", "coefficient_from_rest"},
        "half_space/temperature_friction.py": {"of_temperature"},
        "scenes/moving.py": {"law", "pressed"},
    },
    "laws of wear": {"friction/wear_laws.py": {"as_wear_law"}},
    "motions": {
        "half_space/normal.py": {"_rolling_over"},
        "half_space/tangential.py": {"_check_problem"},
        "studies/sweeps.py": {"sweep"},
    },
    "supports": {"bodies/supports.py": {"__post_init__", "guides", "prescribed"}},
    "results": {
        "half_space/tangential.py": {"_alternate", "_check_velocity"},
        "half_space/tangential_result.py": {"follows"},
        "simulation/stepping.py": {"follows"},
        "pictures/quantities.py": {"as_drawn"},
        "results/saved.py": {"_made"},
        "results/wheel_result.py": {"follows"},
        "studies/sweep_studies.py": {"studied_numbers"},
    },
}
#: Functions outside `base`, which compares and stores values of all kinds, that ask for an attribute: of
#: what a user gives, or of other libraries.
PROBES = {
    "bodies/mesh_files.py": {"_node_sets"},
    "bodies/mesh_objects.py": {"_of_pyvista", "as_trimesh", "cells_of"},
    "bodies/supports.py": {"_told"},
    "half_space/normal.py": {"resistance_of"},
    "half_space/pressure_field.py": {"_half_space", "pressure_field"},
    "moved.py": {"_is_held"},
    "results/with_jax.py": {"value_of"},
    "simulation/stepping.py": {"_check_state"},
    "studies/sweep_cases.py": {"_label", "cases_of"},
    "studies/sweeps.py": {"_end_processes", "_pool", "_solved"},
}


def questions(tree: ast.AST, inside: str = "") -> Iterator[tuple[str, str]]:
    """Function and name of each class that is asked for: by `isinstance`, `issubclass`, `type(...) is`."""
    for node in ast.iter_child_nodes(tree):
        if isinstance(node, ast.FunctionDef):
            yield from questions(node, node.name)
            continue
        asked: list[ast.expr] = []
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Name):
            if node.func.id in ("isinstance", "issubclass"):
                asked = node.args[1:]
        elif isinstance(node, ast.Compare) and "type" in called(node):
            asked = [node.left, *node.comparators]
        elif isinstance(node, ast.MatchClass):
            asked = [node.cls]
        names = [n for part in asked for n in ast.walk(part)]
        yield from ((inside, n.id) for n in names if isinstance(n, ast.Name))
        yield from ((inside, n.attr) for n in names if isinstance(n, ast.Attribute))
        yield from questions(node, inside)


def probes(tree: ast.AST, inside: str = "") -> Iterator[str]:
    """Functions that ask whether an object has an attribute: by `hasattr`, or `getattr` with a default."""
    for node in ast.iter_child_nodes(tree):
        if isinstance(node, ast.FunctionDef):
            yield from probes(node, node.name)
            continue
        by = node.func.id if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) else ""
        if by == "hasattr" or (by == "getattr" and isinstance(node, ast.Call) and len(node.args) == 3):
            yield inside
        yield from probes(node, inside)


def called(node: ast.AST) -> set[str]:
    """Names of the functions called in an expression."""
    calls = (n.func for n in ast.walk(node) if isinstance(n, ast.Call))
    return {n.id for n in calls if isinstance(n, ast.Name)}


def all_questions() -> set[tuple[str, str, str]]:
    """File, function and name of each class asked for in the package."""
    return {
        (path.relative_to(PACKAGE).as_posix(), function, kind)
        for path in PACKAGE.rglob("*.py")
        for function, kind in questions(ast.parse(path.read_text(encoding="utf-8")))
    }


@pytest.mark.parametrize("kind", KINDS)
def test_only_doors_ask_for_a_kind(kind: str) -> None:
    found = {place for place in all_questions() if place[2] in KINDS[kind]}
    asked = {(file, function) for file, function, _ in found}
    doors = {(file, function) for file, functions in DOORS[kind].items() for function in functions}
    # a door that asks no more is a door no more
    assert sorted(asked ^ doors) == []


def test_only_doors_ask_for_an_attribute() -> None:
    found = {
        (path.relative_to(PACKAGE).as_posix(), function)
        for path in PACKAGE.rglob("*.py")
        for function in probes(ast.parse(path.read_text(encoding="utf-8")))
        if path.parent.name != "base"
    }
    assert found == {(file, function) for file, functions in PROBES.items() for function in functions}


def test_the_search_finds_every_way_to_ask() -> None:
    lines = [
        "def a(x): isinstance(x, (int, laws.Coulomb))",
        "def b(x): return type(x) is Coulomb",
        "def c(x): return issubclass(type(x), Coulomb)",
        "def d(x):\n    match x:\n        case Coulomb(): pass",
    ]
    found = [function for line in lines for function, name in questions(ast.parse(line)) if name == "Coulomb"]
    assert found == ["a", "b", "c", "d"]
