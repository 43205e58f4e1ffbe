# SPDX-License-Identifier: MIT OR Apache-2.0
"""Bodies and geometries answer for themselves: only doors, where input is checked, ask for their kind."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from pathlib import Path

from mtb_rs.geometry.geometries import Placed

PACKAGE = Path(__file__).parents[2] / "python" / "mtb_rs"
GEOMETRIES = {made.__name__ for made in Placed.__subclasses__()}
KINDS = {"HalfSpace", "Rigid", "Simple", "ElasticBody"} | GEOMETRIES
#: Functions that take what a user gives.
DOORS = {
    "bodies/simple.py": {"as_body"},
    "case/values.py": {"_body"},
    "half_space/pressure_field.py": {"pressure_field"},
    "scenes/posed.py": {"__post_init__", "_surface", "solids"},
    "scenes/ready.py": {"_elastic"},
}


def questions(tree: ast.AST, inside: str = "") -> Iterator[tuple[str, str]]:
    """Function and kind of each `isinstance` that asks for a body or a geometry."""
    for node in ast.iter_child_nodes(tree):
        if isinstance(node, ast.FunctionDef):
            yield from questions(node, node.name)
            continue
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id == "isinstance":
            names = [n.id for n in ast.walk(node.args[1]) if isinstance(n, ast.Name)]
            yield from ((inside, name) for name in names if name in KINDS)
        yield from questions(node, inside)


def test_only_doors_ask_what_a_body_or_a_geometry_is() -> None:
    found = {
        (path.relative_to(PACKAGE).as_posix(), function, kind)
        for path in PACKAGE.rglob("*.py")
        for function, kind in questions(ast.parse(path.read_text(encoding="utf-8")))
    }
    # the search itself works
    assert ("bodies/simple.py", "as_body", "HalfSpace") in found
    assert ("scenes/posed.py", "__post_init__", "GapField") in found
    asked = sorted(place for place in found if place[1] not in DOORS.get(place[0], set()))
    assert asked == []
