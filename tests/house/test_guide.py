# SPDX-License-Identifier: MIT OR Apache-2.0
"""What the contributors' guide names is there: files, and functions in them."""

from __future__ import annotations

import ast
import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
GUIDE = (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8")
WALK = GUIDE.split("## From the case file to the picture")[1].split("\n## ")[0]
HOPS = re.findall(r"^(\d+)\. (.+)$", WALK, re.MULTILINE)


def names_in(path: Path) -> set[str]:
    """Functions, classes, and `Class.member` of a source file."""
    text = path.read_text(encoding="utf-8")
    if path.suffix == ".rs":
        owners = re.findall(r"^impl(?:<[^>]*>)? (\w+)", text, re.MULTILINE)
        functions = re.findall(r"\bfn (\w+)", text)
        return {*owners, *functions, *(f"{owner}::{name}" for owner in owners for name in functions)}
    found = set()
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, (ast.FunctionDef, ast.ClassDef)):
            found.add(node.name)
        if isinstance(node, ast.ClassDef):
            members = [n for n in node.body if isinstance(n, (ast.FunctionDef, ast.AnnAssign))]
            found |= {
                f"{node.name}.{n.name if isinstance(n, ast.FunctionDef) else n.target.id}" for n in members
            }
    return found


def everything() -> set[str]:
    return {name for path in (ROOT / "python" / "mtb_rs").rglob("*.py") for name in names_in(path)}


def test_walks_have_at_most_nine_hops() -> None:
    numbers = [int(number) for number, _ in HOPS]
    assert numbers.count(1) == 2
    assert max(numbers) <= 9


@pytest.mark.parametrize(("number", "hop"), HOPS)
def test_what_a_hop_names_is_there(number: str, hop: str) -> None:
    quoted = re.findall(r"`([^`]+)`", hop)
    places = [word for word in quoted if word.endswith((".py", ".rs"))]
    files = [
        ROOT / word if word.startswith("rust/") else ROOT / "python" / "mtb_rs" / word for word in places
    ]
    assert files, hop
    here = {name for path in files for name in names_in(path)} | everything()
    for word in quoted:
        if word not in places:
            assert word in here, f"hop {number} names {word}"


@pytest.mark.parametrize(
    ("path", "names"),
    [
        ("scenes/posed.py", ["PosedScene.__post_init__", "PosedScene._under_load"]),
        ("scenes/direct.py", ["_is_plain"]),
        ("bodies/sides.py", ["Side", "Side.compliance"]),
        ("contact/standing.py", ["Foundation.side", "Contact.load_of"]),
        ("scenes/scene.py", ["Scene"]),
    ],
)
def test_the_worked_effect_finds_its_places(path: str, names: list[str]) -> None:
    assert f"`{path}`" in GUIDE
    assert set(names) <= names_in(ROOT / "python" / "mtb_rs" / path)
    assert {"PyCompliance"} <= names_in(ROOT / "rust/python/src/operator.rs")
    assert "contact.lower.side(" in (ROOT / "python/mtb_rs/scenes/posed.py").read_text(encoding="utf-8")


def test_files_and_commands_of_the_guide_are_there() -> None:
    for path in re.findall(r"`((?:docs|tests|rust|studies)/[\w/.]+\.(?:md|py|rs|toml))`", GUIDE):
        # what the worked effect would add is not there
        assert (ROOT / path).exists() or "layer" in path, path
    for link in re.findall(r"\]\(((?!http)[^)#]+)", GUIDE):
        assert (ROOT / link).exists(), link
