# SPDX-License-Identifier: MIT OR Apache-2.0
"""The first minute: a demo without a file, case files to start from, and the schema that editors check by."""

from __future__ import annotations

import json
import tomllib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import jsonschema
import numpy as np
import pytest

import mtb_rs as mtb
from mtb_rs.case import SCENES, case_from_words
from mtb_rs.case.schema import schema
from mtb_rs.commands import main
from mtb_rs.commands.exits import BAD_INPUT
from mtb_rs.commands.start import CASES, SCHEMA, case_file


@pytest.fixture(scope="module")
def checker() -> Any:
    words = schema()
    kind = jsonschema.validators.validator_for(words)
    kind.check_schema(words)
    return kind(words)


def commented_lines(kind: str) -> Iterator[str]:
    """The case file with one after another of its commented keys switched on."""
    lines = case_file(kind).splitlines()
    for k, line in enumerate(lines):
        if line.startswith("# ") and " = " in line.partition("#")[2].partition("#")[0]:
            yield "\n".join([*lines[:k], line[2:], *lines[k + 1 :]])


@pytest.mark.parametrize("kind", CASES)
def test_a_case_file_to_start_from_runs_and_is_not_replaced(
    kind: str, tmp_path: Path, checker: Any, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "case.toml"
    assert main(["init", kind, "-o", str(path)]) == 0
    assert path.read_text(encoding="utf-8") == case_file(kind)
    checker.validate(tomllib.loads(case_file(kind)))
    assert json.loads((tmp_path / SCHEMA).read_text(encoding="utf-8")) == schema()
    assert main(["run", str(path), "-o", str(tmp_path / "out")]) == 0
    assert mtb.load(tmp_path / "out").check() is None
    capsys.readouterr()
    assert main(["init", kind]) == 0
    assert capsys.readouterr().out == case_file(kind)
    assert main(["init", kind, "-o", str(path)]) == BAD_INPUT
    assert "is there already" in capsys.readouterr().err


@pytest.mark.parametrize("kind", CASES)
def test_every_commented_key_may_be_switched_on(kind: str, checker: Any) -> None:
    for text in commented_lines(kind):
        words = tomllib.loads(text)
        case_from_words(words).scene()
        checker.validate(words)


def test_the_demo_needs_no_file(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out = tmp_path / "demo"
    assert main(["demo", "-o", str(out)]) == 0
    assert str(out / "pressure.png") in capsys.readouterr().out.replace("\n", "")
    assert (out / "pressure.png").stat().st_size > 10_000


@pytest.mark.parametrize("scene", SCENES)
def test_defaults_of_the_schema_are_those_of_the_scene(scene: str, checker: Any) -> None:
    checker.validate({"scene": scene})
    branch = next(part for part in schema()["oneOf"] if part["title"] == scene)
    case = case_from_words({"scene": scene})
    for name in case.arguments():
        told = branch["properties"][name]
        assert told["description"], name
        if isinstance(told.get("default"), (int, float, str)):
            assert told["default"] == getattr(case, name)


@pytest.mark.parametrize(
    "wrong",
    [
        {"scene": "pole_shoe"},
        {"scene": "block_on_plane", "heigth": 0.1},
        {"scene": "block_on_plane", "height": "tall"},
        {"scene": "block_on_plane", "attraction": "none"},
        {"scene": "pole_shoe_on_rail", "supports": "glued"},
        {"scene": "pole_shoe_on_rail", "upper": {"young": 208e9, "poisson_ratio": 0.3}},
        {"scene": "wheel_on_rail", "rolling": {"creepage": [1e-3, 0.0]}},
        {"scene": "wheel_on_rail", "solve": {"model": "elastic"}},
    ],
)
def test_schema_and_reader_refuse_the_same(wrong: dict[str, Any], checker: Any) -> None:
    assert not checker.is_valid(wrong)
    with pytest.raises(mtb.CaseError):
        case_from_words(wrong).scene()


def test_a_case_that_rolls_is_the_same_as_in_python(tmp_path: Path) -> None:
    path = tmp_path / "rolling.toml"
    path.write_text(
        'scene = "paraboloid_on_plane"\nradius = 0.4\nforce = 1e4\npoints = 24\nfriction = 0.3\n'
        '[rolling]\nforce = [1000, "free"]\ncreepage = [0, 0, 0.2]\n',
        encoding="utf-8",
    )
    rolled = mtb.load_case(path).solve()
    assert isinstance(rolled, mtb.TangentialResult)
    scene = mtb.scenes.paraboloid_on_plane(0.4, 1e4, 0.3, 24, sliding_direction=None)
    motion = mtb.Rolling(creepage=(0.0, 0.0, 0.2), force=(1000.0, None))
    assert np.array_equal(
        rolled.traction, mtb.solve_tangential(scene.solve(), motion, mtb.Coulomb(0.3)).traction
    )
    shifted = case_from_words(
        {"scene": "paraboloid_on_plane", "force": 1e4, "shift": {"displacement": [1e-6, 0]}}
    )
    assert isinstance(shifted.motion, mtb.Shift)


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ({"rolling": {"creepage": [1e-3, 0, 0]}, "shift": {"spin": 1e-3}}, "give one of the two"),
        ({"rolling": {"creep": [1e-3, 0, 0]}}, "a table of creepage, force"),
        ({"rolling": {"creepage": [1e-3, 0]}}, "creepage"),
        ({"rolling": 1e-3}, "a table of creepage, force"),
    ],
)
def test_wrong_motions_are_told(words: dict[str, Any], said: str) -> None:
    with pytest.raises(mtb.CaseError, match=said):
        case_from_words({"scene": "wheel_on_rail", **words})


def test_what_cannot_roll_is_told() -> None:
    case = case_from_words(
        {"scene": "pole_shoe_on_rail", "spacing": 6e-3, "rolling": {}, "solve": {"model": "half-space"}}
    )
    with pytest.raises(mtb.CaseError, match="one regular patch"):
        case.solve()
