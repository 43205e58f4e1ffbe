# SPDX-License-Identifier: MIT OR Apache-2.0
"""``mtb-rs check``: what a case would solve and take, and all that is wrong with it, without solving."""

from __future__ import annotations

import shlex
from pathlib import Path

import numpy as np
import pytest

import mtb_rs as mtb
from mtb_rs.case import SCENES
from mtb_rs.commands import main
from mtb_rs.commands.exits import BAD_INPUT
from mtb_rs.commands.start import CASES, case_file
from mtb_rs.scenes import direct

ROOT = Path(__file__).parents[2]
FILES = {kind: case_file(kind) for kind in CASES}
FILES |= {path.stem: path.read_text(encoding="utf-8") for path in (ROOT / "examples").rglob("*.toml")}
FILES |= {name: f'scene = "{name}"\n' for name in SCENES}
FILES["shift"] = (
    'scene = "paraboloid_on_plane"\nsliding_direction = [0, 1]\n[shift]\ndisplacement = [1e-6, 0]\n'
)
FILES["thesis"] = 'scene = "block_on_plane"\nspacing = 1e-2\n[solve]\nmethod = "incremental"\n'


def written(text: str, tmp_path: Path) -> Path:
    path = tmp_path / "case.toml"
    path.write_text(text, encoding="utf-8")
    return path


@pytest.mark.parametrize("name", FILES)
def test_every_kind_of_case_is_counted_and_not_solved(
    name: str, tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(direct, "level_at", lambda *_, **__: pytest.fail("something is solved"))
    monkeypatch.setattr(mtb.ElasticBody, "condense", lambda *_, **__: pytest.fail("a body is condensed"))
    path = written(FILES[name], tmp_path)
    case = mtb.load_case(path)
    cost = case.expected_cost()
    assert main(["check", str(path)]) == 0
    said = " ".join(capsys.readouterr().out.split())
    assert case.scene_name in said
    assert f"friction {dict(case.scene().told())['friction']}" in said
    for part in cost.costs:
        assert f"{part.name} {part.points} contact points" in said
        assert all(f"{count} unknowns of the {body}" in said for body, count in part.unknowns.items())
    if case.motion is not None:
        assert f"then {type(case.motion).__name__}" in said
        assert cost.costs[-1].name in ("shift", "steady rolling")
    assert "No fault" in said
    assert [entry.name for entry in tmp_path.iterdir()] == ["case.toml"]


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ('scene = "pole_shoe"\n', ["'pole_shoe'"]),
        ("scene = \n", ["is not TOML"]),
        # a rail that the default sole does not suit, and what is wrong besides
        (
            'scene = "pole_shoe_on_rail"\nouter_edge = 20e-3\nconforming_to = 15e-3\nfriction = -0.5\n'
            'rail = "narrow.txt"\n',
            ["friction is -0.5"],
        ),
        (
            'scene = "pole_shoe_on_rail"\nouter_edge = 20e-3\nconforming_to = 15e-3\nfriction = -0.5\n'
            'length = -1.0\nrail = {file = "narrow.txt", z_axis = "up"}\n',
            ["friction is -0.5", "length is -1"],
        ),
        (
            'scene = "pole_shoe_on_rail"\nheigth = 0.03\nlength = "long"\nfriction = -0.1\n'
            '[solve]\nmodel = "elastic"\nquantity = "heat"\n',
            ["heigth", "length", "friction", "model is 'elastic'", "quantity is 'heat'"],
        ),
        ('scene = "pole_shoe_on_rail"\nmagnetic_pressure = [3e6, -3e6]\n', ["does not press"]),
        ('scene = "wheel_on_rail"\nlower = "rigid"\n[solve]\nmodel = "elastic-upper"\n', ["elastic-upper"]),
        (
            'scene = "pole_shoe_on_rail"\n[friction]\nvelocity = [0.0, 1.0]\nvalue = [0.3, 0.2]\n'
            '[rolling]\n[solve]\nmethod = "staggered"\nmodel = "half-space"\n',
            ["staggered", "a law of friction, is needed to roll", "one regular patch"],
        ),
    ],
)
def test_all_that_is_wrong_is_said_at_once(
    text: str, told: list[str], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = written(text, tmp_path)
    across = np.linspace(-25.0, 25.0, 51)
    np.savetxt(tmp_path / "narrow.txt", np.c_[across, -(across**2) / 4000.0])
    assert main(["check", str(path)]) == BAD_INPUT
    printed = capsys.readouterr()
    lines = printed.err.splitlines()
    assert len(lines) == len(told)
    assert all(line.startswith(f"mtb-rs: {path}") for line in lines)
    for words in told:
        assert sum(words in line for line in lines) == 1, (words, lines)
    assert "No fault" not in printed.out
    # and nothing of it is left to the solve
    assert main(["run", str(path), "-o", str(tmp_path / "out")]) == BAD_INPUT
    assert not (tmp_path / "out").exists()


def test_commands_to_paste_are_quoted(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "my shoe's case.toml"
    assert main(["init", "shoe", "-o", str(path)]) == 0
    words = shlex.split(capsys.readouterr().out.partition("next: ")[2].replace(", then", " then"))
    assert words == ["mtb-rs", "check", str(path), "then", "mtb-rs", "run", str(path)]


def test_doubts_are_told_once_and_are_not_called_faultless(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    text = 'scene = "pole_shoe_on_rail"\nspacing = 9e-3\nfriction = 5.0\n[solve]\nmodel = "half-space"\n'
    path = written(text, tmp_path)
    assert main(["check", str(path)]) == 0
    printed = capsys.readouterr()
    assert printed.err.count("friction reaches 5") == 1
    assert "No fault is found" not in printed.out
    assert "Nothing is refused, but the warnings above are doubts" in printed.out


def test_wear_is_counted_by_one_contact(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    shoe = 'scene = "pole_shoe_on_rail"\npoles = 1\nspacing = 12e-3\nsolve.model = "half-space"\n'
    table = "friction = { velocity = [0.0, 30.0], value = [0.3, 0.1] }\n"
    wear = "[wear]\nlaw = 1e-13\n"
    alone = mtb.load_case(written(shoe + "friction = 0.2\n", tmp_path)).expected_cost()
    passages = "passages = [{ distance = 10.0, count = 3, velocity = 20.0 }]\n"
    for friction, duty in (("friction = 0.2\n", "distance = 30.0\n"), (table, passages)):
        path = written(shoe + friction + wear + duty, tmp_path)
        assert mtb.load_case(path).expected_cost() == alone
        assert main(["check", str(path)]) == 0
        told = " ".join(capsys.readouterr().out.split())
        assert "wear over 30 m of sliding" in told
        assert "What one contact of it would take" in told
    # what wear refuses is told before anything is solved
    for text, message in (
        ("friction = 0.2\n" + wear + "distance = 30.0\ntolerance = 2.0\n", "tolerance is 2"),
        (table + wear + "distance = 30.0\n", "friction is a table over velocity: give velocity"),
    ):
        assert main(["check", str(written(shoe + text, tmp_path))]) == BAD_INPUT
        assert message in " ".join(capsys.readouterr().err.split())
