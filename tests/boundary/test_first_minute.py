# SPDX-License-Identifier: MIT OR Apache-2.0
"""The first minute: a demo without a file, case files to start from, and the schema that editors check by."""

from __future__ import annotations

import itertools
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
        {"scene": "block_on_plane", "solve": {"modle": "auto"}},
        {"scene": "block_on_plane", "solve": {"tolerance": 5}},
        {"scene": "block_on_plane", "solve": {"factor": 0.1}},
        {"scene": "block_on_plane", "solve": {"method": "incremental", "factor": 0.1}},
        {"scene": "block_on_plane", "upper": {}},
        {"scene": "block_on_plane", "friction": {}},
        {"scene": "block_on_plane", "friction": ["a"]},
        {"scene": "pole_shoe_on_rail", "layer": {}},
        {"scene": "wheel_on_rail", "force": -1},
        {"scene": "wheel_on_rail", "rolling": {}, "shift": {}},
        {"scene": "wheel_on_rail", "rail": {"unit": "mm"}},
    ],
)
def test_schema_and_reader_refuse_the_same(wrong: dict[str, Any], checker: Any) -> None:
    assert not checker.is_valid(wrong)
    with pytest.raises(mtb.CaseError):
        case_from_words(wrong).scene()


#: Values of every kind, right in some place and wrong in the others.
ANY: tuple[Any, ...] = (
    *(
        0.3,
        1e-3,
        2,
        0,
        -0.2,
        1.5,
        True,
        "a",
        "rigid",
        "clamped-top",
        "60E1",
        "free",
        [],
        {},
        ["a"],
        [0.3, 0.2],
    ),
    *([1.0, 0.0], [1e-3, 0.0, 0.1], [0.3, "free"], {"poisson_ratio": 0.3}, {"velocity": [0.0, 9.0]}),
    {"poisson_ratio": 0.3, "young_modulus": 2e11},
    {"poisson_ratio": 0.3, "shear_modulus": 8e10},
    {"poisson_ratio": 0.7, "shear_modulus": 8e10},
    {"poisson_ratio": 0.3, "young_modulus": 2e11, "shear_modulus": 8e10},
    {"velocity": [0.0, 9.0], "value": [0.4, 0.3]},
    {"velocity": [0.0, 9.0], "value": [0.4, "b"]},
    {"peak": 0.3, "center": [0.0, 0.0], "sigma": [0.01, 0.01]},
    {"peak": 0.3, "center": [0.0], "sigma": [0.01, 0.01]},
    {"thickness": 1e-4, "shear_modulus": 1e9},
    {"thickness": 1e-4},
    {"file": 1},
    {"spin": 1e-3},
    {"creepage": [1e-3, 0.0, 0.1], "velocity": 5},
    {"force": [100.0, "free"]},
    {"method": "incremental", "max_releases": 4},
    {"method": "staggered", "factor": 0.1},
    {"max_releases": 4},
    {"quantity": "force", "tolerance": 0.2},
)


#: Keys whose values must fit others, or the bodies: more than a schema says.
FITTING = (
    *("length", "rail_length", "inner_edge", "outer_edge", "conforming_to", "lateral", "rail", "wheel"),
    *("gauge", "gauge_depth", "flange_back", "tape_circle", "rail_inclination", "wheel_radius"),
    *("force", "spacing"),
)


@pytest.mark.filterwarnings("ignore::UserWarning")
@pytest.mark.parametrize("scene", SCENES)
def test_schema_and_reader_agree_on_every_value_of_every_key(scene: str, checker: Any) -> None:
    case = case_from_words({"scene": scene})
    keys = [*case.arguments(), "solve", "rolling", "shift", "hight"]
    refused = 0
    for key, value in itertools.product(keys, ANY):
        words = {"scene": scene, key: value}
        try:
            case_from_words(words).scene()
            is_taken = True
        except mtb.CaseError:
            is_taken = False
        is_valid = checker.is_valid(words)
        refused += not is_valid
        if is_valid and not is_taken:
            # numbers that do not go together with others, and names of files that are not there
            assert key in FITTING, words
        else:
            assert is_valid == is_taken, words
    assert refused > len(keys) * len(ANY) / 3


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
