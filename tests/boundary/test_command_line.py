# SPDX-License-Identifier: MIT OR Apache-2.0
"""Hostile input on the command line: one line, exit code 2, nothing written; any terminal."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

import mtb_rs as mtb
from mtb_rs.base import threads
from mtb_rs.commands import main

SCENE = 'scene = "pole_shoe_on_rail"\nspacing = 6e-3\n'
BIG = "9" * 400
HUGE = "9" * 5000

HOSTILE = {
    "arrays nested 5000 deep": (SCENE + "friction = " + "[" * 5000 + "]" * 5000, "nested too deeply"),
    "arrays nested 50 deep": (SCENE + "friction = " + "[" * 50 + "]" * 50, "nested too deeply"),
    "inline tables 2000 deep": (SCENE + "friction = " + "{a=" * 2000 + "1" + "}" * 2000, "nested too deeply"),
    "a key of 20 000 parts": (SCENE + ".".join("a" * 20_000) + " = 1", "nested too deeply"),
    "an inline key of 20 000 parts": (
        SCENE + "friction = { " + ".".join("a" * 20_000) + " = 1 }",
        "nested too deeply",
    ),
    "tables 3000 deep": (SCENE + "[" + ".".join("a" * 3000) + "]\nb = 1", "nested too deeply"),
    "friction": (SCENE + f"friction = {BIG}", "friction: is a whole number of 1329 bits"),
    "friction of thousands of digits": (SCENE + f"friction = {HUGE}", "is not TOML"),
    "spacing": (SCENE.replace("6e-3", BIG), "spacing: is a whole number of 1329 bits"),
    "magnetic pressure": (SCENE + f"magnetic_pressure = [1.0, -{BIG}]", "magnetic_pressure.1: is a whole"),
    "points": (f'scene = "paraboloid_on_plane"\npoints = {BIG}', "points: is a whole number"),
    "layer": (SCENE + f"layer = {{ thickness = {BIG}, shear_modulus = 1.0 }}", "layer.thickness: is a whole"),
    "velocities": (
        SCENE + f"friction = {{ velocity = [0, {BIG}], value = [0.1, 0.2] }}",
        "friction.velocity.1: is a whole number",
    ),
    "a scene of a megabyte": ('scene = "' + "a" * 900_000 + '"', "scene is 'aaa"),
    "a million keys": ("".join(f"k{k} = 1\n" for k in range(200_000)), "bytes: at most 1e+06 are read"),
    "typos everywhere": (
        SCENE + "frictoin = 0.5\n[solve]\ntolerence = 0.1\n",
        "solve.tolerence = 0.1: unknown option of the direct method; did you mean 'tolerance'?",
    ),
}


@pytest.mark.parametrize("kind", HOSTILE)
def test_hostile_cases_are_refused_in_lines(
    kind: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    text, message = HOSTILE[kind]
    case = tmp_path / "case.toml"
    case.write_text(text)
    assert main(["run", str(case), "-o", str(tmp_path / "out")]) == 2
    errors = capsys.readouterr().err
    assert message in errors
    assert errors.count("\n") == (2 if kind == "typos everywhere" else 1)
    assert len(errors) < 1000
    assert sorted(p.name for p in tmp_path.iterdir()) == ["case.toml"]


@pytest.mark.parametrize("jobs", ["9" * 20, "100000", "0", "1e3", "\u00b2"])
def test_processes_beyond_the_machine_are_a_usage_error(
    jobs: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(SystemExit) as left:
        main(["sweep", str(tmp_path / "case.toml"), "--vary", "friction=0.1", "-j", jobs])
    assert left.value.code == 2
    assert f"argument -j/--jobs: {jobs!r}: " in capsys.readouterr().err


def test_a_deep_summary_is_nobody_s(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "case.toml").write_text(SCENE)
    (tmp_path / "summary.json").write_text("[" * 100_000 + "]" * 100_000)
    assert main(["run", str(tmp_path / "case.toml"), "-o", str(tmp_path)]) == 2
    assert "summary.json is there already and was not written by mtb_rs" in capsys.readouterr().err


def test_an_ascii_terminal_gets_the_report(tmp_path: Path) -> None:
    (tmp_path / "case.toml").write_text(
        'scene = "block_on_plane"\nspacing = 2e-2\nfriction = 0.1\n[solve]\nmodel = "half-space"\n'
    )
    environment = os.environ | {
        "PYTHONIOENCODING": "ascii",
        "PYTHONUTF8": "0",
        "LC_ALL": "C",
        "TERM": "vt100",
    }
    command = [sys.executable, "-m", "mtb_rs", "run", "case.toml", "-o", "out"]
    done = subprocess.run(
        command, capture_output=True, cwd=tmp_path, env=environment, check=False, timeout=300
    )
    assert done.returncode == 0, done.stderr
    assert b" um" in done.stdout
    assert json.loads((tmp_path / "out" / "summary.json").read_text())["report"]["converged"]


def test_what_is_printed_to_a_full_disk_is_one_line() -> None:
    if not Path("/dev/full").exists():
        pytest.skip("no /dev/full")
    for command in (["--version"], ["run", "none.toml", "-o", "/proc/none/out"]):
        # at once, or at the end
        for unbuffered in ("", "1"):
            with open("/dev/full", "w") as full:
                done = subprocess.run(
                    [sys.executable, "-m", "mtb_rs", *command], stdout=full, stderr=subprocess.PIPE,
                    text=True, check=False, timeout=300, env=os.environ | {"PYTHONUNBUFFERED": unbuffered},
                )  # fmt: skip
            assert "Traceback" not in done.stderr


def test_more_threads_than_a_machine_can_start_are_not_tried() -> None:
    program = (
        "import numpy as np, mtb_rs as mtb\n"
        "x = np.linspace(-1, 1, 50)\n"
        "gap = 1e-3 * (x[:, None] ** 2 + x**2)\n"
        "print(mtb.solve_normal(gap, 0.04, lower=mtb.steel, upper=mtb.steel, force=1e3).report.converged)\n"
    )
    environment = os.environ | {"RAYON_NUM_THREADS": "5000"}
    done = subprocess.run(
        [sys.executable, "-c", program],
        capture_output=True,
        text=True,
        env=environment,
        check=False,
        timeout=300,
    )
    assert done.stdout == "True\n", done.stderr
    assert "RAYON_NUM_THREADS is 5000" in done.stderr


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["chart", "--repeats", "9999999999999999999"], "a whole number from 1 to 1000 is needed"),
        (["chart", "--repeats", "0"], "a whole number from 1 to 1000 is needed"),
        (["chart", "--budget", "9999999999999999999999"], "seconds up to 604800"),
        (["chart", "--budget", "nan"], "seconds up to 604800"),
    ],
)
def test_numbers_that_would_never_end_are_refused(
    arguments: list[str], message: str, capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(SystemExit) as caught:
        main([arguments[0], "case.toml", *arguments[1:]])
    assert caught.value.code == 2
    assert message in capsys.readouterr().err


def test_a_misspelt_argument_of_a_sweep_is_told_what_was_meant() -> None:
    scene = mtb.scenes.pole_shoe_on_rail(spacing=12e-3)
    with pytest.raises(ValueError, match=r"no argument of the scene: did you mean 'friction'\?$"):
        mtb.sweep(scene, {"frction": [0.1]})
    with pytest.raises(ValueError, match="it has attraction, conforming_to") as caught:
        mtb.sweep(scene, {"qqqqq": [0.1]})
    assert "approach" not in str(caught.value)


@pytest.mark.parametrize("asked", ["-1", "abc", "1.5"])
def test_numbers_of_threads_that_are_none_are_told(asked: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("RAYON_NUM_THREADS", asked)
    with pytest.warns(UserWarning, match="RAYON_NUM_THREADS is .* a whole number from 1 on is needed"):
        threads.limit()
