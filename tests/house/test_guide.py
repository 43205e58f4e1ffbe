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
EFFECT = GUIDE.split("## An effect, worked out")[1]
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
    here = {name for path in files for name in names_in(path)}
    for word in quoted:
        if word not in places:
            # functions are where the hop is; of classes it may tell what they become
            known = here | everything() if word[0].isupper() else here
            assert word in known, f"hop {number} names {word}"
    # what follows a file up to the next one or the end of the list is in it
    for file, listed in re.findall(r"`([\w/]+\.(?:py|rs))`((?:(?:,| or| and) `[^`/]+`)+)", hop):
        path = ROOT / file if file.startswith("rust/") else ROOT / "python" / "mtb_rs" / file
        assert set(re.findall(r"`([^`]+)`", listed)) <= names_in(path), f"hop {number}: {file}"


@pytest.mark.parametrize(
    ("path", "words"),
    [
        ("python/mtb_rs/contact/standing.py", ["class Standing", "def side("]),
        ("python/mtb_rs/contact/problem.py", ["def core(", "made_from = (", "_mtb_rs.Problem(*made_from)"]),
        ("python/mtb_rs/contact/symmetry.py", ["def mirror_symmetry("]),
        (
            "python/mtb_rs/scenes/posed.py",
            ["    layer: InterfaceLayer | PlasticLayer | None = None", "        problem = ContactProblem("],
        ),
        ("python/mtb_rs/scenes/taken.py", ["TAKEN = {", "def beyond("]),
        ("python/mtb_rs/scenes/ready.py", ["_those_of(Scene, given)"]),
        ("python/mtb_rs/case/values.py", ["_BY_NAME: "]),
        ("python/mtb_rs/base/units.py", ["ARGUMENT_UNITS: dict"]),
        ("python/mtb_rs/_mtb_rs.pyi", ["class Problem:"]),
        ("rust/operator/src/relative.rs", ["pub struct Relative", "fn add_influence(", "points: usize"]),
        ("rust/operator/tests/arrangements.rs", ["Relative::new("]),
        (
            "rust/python/src/problem.rs",
            [
                "let mut pair = Relative::new(",
                "#[pyo3(signature = (",
                "products_from=PRODUCTS_FROM, layer=None",
            ],
        ),
        ("tests/relations/test_every_statement_counts.py", ["CHANGES: dict"]),
        ("tests/relations/test_ready_scenes.py", ["OTHERS: dict"]),
    ],
)
def test_the_worked_effect_finds_its_places(path: str, words: list[str]) -> None:
    named = path.removeprefix("python/mtb_rs/")
    assert f"`{named}`" in EFFECT or f"`{path}`" in EFFECT
    text = (ROOT / path).read_text(encoding="utf-8")
    for word in words:
        assert word in text, word


def test_the_worked_effect_names_what_is_there() -> None:
    prose = re.sub(r"^ *```.*?^ *```", "", EFFECT, flags=re.MULTILINE | re.DOTALL)
    known = everything()
    for path in (ROOT / "rust").rglob("*.rs"):
        known |= names_in(path)
    of_classes = re.findall(r"`([A-Z]+[a-z]\w+(?:\.|::)\w+)`", prose)
    assert len(of_classes) > 10
    assert set(of_classes) <= known


def test_files_and_commands_of_the_guide_are_there() -> None:
    for path in re.findall(r"`((?:docs|tests|rust|studies)/[\w/.]+\.(?:md|py|rs|toml))`", GUIDE):
        assert (ROOT / path).exists(), path
    for link in re.findall(r"\]\(((?!http)[^)#]+)", GUIDE):
        assert (ROOT / link).exists(), link
