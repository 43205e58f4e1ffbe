# SPDX-License-Identifier: MIT OR Apache-2.0
"""Steps of wheels by a function, a case file, its schema, the command line and a sweep: one and the same."""

from __future__ import annotations

import copy
import functools
import json
from pathlib import Path
from typing import Any

import jsonschema
import numpy as np
import pytest

import mtb_rs as mtb
from mtb_rs.case import case_from_words
from mtb_rs.case.schema import schema
from mtb_rs.commands import main
from mtb_rs.commands.exits import BAD_INPUT

# one wheel alone is pushed towards its gauge corner, which is pressed harder than rail steel bears
pytestmark = [
    pytest.mark.coarse,
    pytest.mark.filterwarnings("ignore:the peak pressure is"),
    pytest.mark.filterwarnings("ignore:on the flange"),
]

WHEEL: dict[str, Any] = {"scene": "wheel_on_rail", "lateral": 0.0, "force": 60e3, "spacing": 2e-3}
FORCES: dict[str, Any] = {"velocity": 20.0, "yaw": 1e-3, "lateral_force": 9e3, "longitudinal_force": 3e3}
TEXT = """
scene = "wheel_on_rail"
lateral = 0.0
force = 60e3
spacing = 2e-3

[step_wheels]
velocity = 20.0
yaw = 1e-3
lateral_force = 9e3
longitudinal_force = 3e3
"""


def scene() -> Any:
    return mtb.scenes.wheel_on_rail(lateral=0.0, force=60e3, spacing=2e-3)


def test_forces_are_met_and_the_step_is_that_of_prepared_wheels() -> None:
    step = mtb.step_wheels(scene(), **FORCES)
    assert step.force == pytest.approx([3e3, 9e3, -60e3], abs=1e-3)
    pose = [0.0, np.nan, np.nan, 0.0, 0.0, 1e-3]
    own = scene().prepare().step(pose, 20.0, lateral_force=9e3, longitudinal_force=3e3)
    assert np.array_equal(step.force, own.force)
    # by pose, with what is beside its place, on springs, for both wheels
    beside: dict[str, Any] = {
        "curvature": 1e-3,
        "rails": {"left": [1e-4, 0.0, 0.0]},
        "wheels": {"right": [0.0, 1e-4, 0.0, 0.0, 0.0, 0.0]},
    }
    springs: dict[str, Any] = {"rail_stiffness": [np.inf, 5e7], "rail_force": [0.0, 1e3]}
    step = mtb.step_wheels(scene(), 20.0, side="both", y=1e-3, x=0.1, pitch=0.2, **beside, **springs)
    pose = [0.1, 1e-3, np.nan, np.nan, 0.2, 0.0]
    own = scene().prepare(side="both", **springs).step(pose, 20.0, **beside)
    assert np.array_equal(step.force, own.force)
    given = mtb.step_wheels(scene(), 20.0, side="both", y=step.pose[1], z=step.pose[2], roll=step.pose[3])
    assert given.balance_error is None


def test_the_table_is_the_function(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    words = {**WHEEL, "step_wheels": FORCES}
    found = case_from_words(words).solve()
    assert isinstance(found, mtb.WheelStep)
    assert np.array_equal(found.force, mtb.step_wheels(scene(), **FORCES).force)
    file, out = tmp_path / "case.toml", tmp_path / "out"
    file.write_text(TEXT)
    assert main(["check", str(file)]) == 0
    assert "a step of wheels: velocity 20.0" in " ".join(capsys.readouterr().out.split())
    assert main(["run", str(file), "-o", str(out)]) == 0
    printed = capsys.readouterr().out
    assert printed.startswith("outcome ")
    rows = {name: words for line in printed.splitlines() for name, _, words in [line.strip().partition("  ")]}
    assert rows["force on the rails"].strip() == "x 3000, y 9000, z -60000 N"
    assert {"pose", "velocity", "vertical force", "left wheel", "creep force", "creepage"} <= set(rows)
    told = json.loads((out / "summary.json").read_text())
    assert told["force"] == pytest.approx(list(found.force), rel=1e-12)
    # stress below one of its patches
    stressed = case_from_words({**words, "stress": {"patch": "patches[0]", "depths": [1e-3, 3e-3]}})
    assert stressed.stressed(found).von_mises.max() > 1e8
    assert stressed.expected_cost().costs


def test_forces_are_swept(tmp_path: Path) -> None:
    forces = [0.0, 9e3]
    study = functools.partial(mtb.step_wheels, velocity=20.0, yaw=1e-3)
    table = mtb.sweep(scene(), {"step_wheels.lateral_force": forces}, study=study)
    assert table.failures == []
    assert table["force_y"] == pytest.approx(forces, abs=1e-3)
    assert table.units["y"] == "m"
    assert table["vertical_force_left"] == pytest.approx(60e3)
    alone = [mtb.step_wheels(scene(), 20.0, yaw=1e-3, lateral_force=force).pose[1] for force in forces]
    assert table["y"] == pytest.approx(alone, rel=1e-12)
    file, out = tmp_path / "case.toml", tmp_path / "out"
    file.write_text(TEXT.replace("longitudinal_force = 3e3\n", ""))
    vary = "step_wheels.lateral_force=0,9e3"
    assert main(["sweep", str(file), "--vary", vary, "-o", str(out)]) == 0
    assert mtb.load(out)["y"] == pytest.approx(alone, rel=1e-12)


@pytest.mark.parametrize(
    ("wrong", "said"),
    [
        ({"lateral_force": 1e3}, "velocity is missing"),
        ({"velocity": 20.0, "lateral_forc": 1e3}, "did you mean 'lateral_force'"),
        ({"velocity": "fast"}, "velocity is 'fast'"),
        ({"velocity": [1.0, 2.0]}, "velocity is"),
        ({"velocity": 20.0, "side": "middle"}, "side is 'middle'"),
        ({"velocity": 20.0, "yaw": "left"}, "yaw is 'left'"),
        ({"velocity": 20.0, "rails": [0.0]}, "a table of left and right is needed"),
        (3, "a table with velocity"),
    ],
)
def test_wrong_words_are_named(wrong: Any, said: str) -> None:
    with pytest.raises(mtb.CaseError, match=said):
        case_from_words({**WHEEL, "step_wheels": wrong})


@pytest.mark.slow
def test_what_does_not_go_together_is_named(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(mtb.CaseError, match="step_wheels and rolling are given"):
        case_from_words({**WHEEL, "step_wheels": FORCES, "rolling": {"creepage": [1e-3, 0.0, 0.0]}})
    both = copy.deepcopy(FORCES) | {"y": 1e-3}
    with pytest.raises(mtb.CaseError, match="y and z are found for it"):
        case_from_words({**WHEEL, "step_wheels": both}).solve()
    shoe = {"scene": "block_on_plane", "friction": 0.1, "step_wheels": {"velocity": 20.0}}
    with pytest.raises(mtb.CaseError, match="for a wheel on a rail"):
        case_from_words(shoe).expected_cost()
    with pytest.raises(mtb.CaseError, match=r"only solve\.model"):
        case_from_words({**WHEEL, "step_wheels": FORCES, "solve": {"tolerance": 0.1}}).solve()
    file = tmp_path / "case.toml"
    file.write_text(TEXT)
    assert main(["chart", str(file)]) == BAD_INPUT
    assert "[step_wheels] is given" in " ".join(capsys.readouterr().err.split())
    look = schema()
    jsonschema.validate({**WHEEL, "step_wheels": FORCES}, look)
    for bad in ({"velocity": "fast"}, {"yaw": 1.0}, {"velocity": 1.0, "rails": 3}):
        with pytest.raises(jsonschema.ValidationError):
            jsonschema.validate({**WHEEL, "step_wheels": bad}, look)


@pytest.mark.parametrize(
    ("line", "wrong"),
    [
        ("roller_radius = 0.5\n[step_wheels]\nvelocity = 20.0\ncurvature = 1e-3", "curvature is 0.001 / m"),
        ("[step_wheels]\nvelocity = 20.0\nside = 'right'\nrails = {left = [0, 0, 0]}", "rails is"),
        ("[step_wheels]\nvelocity = 0.0", "the left wheel does not roll"),
        ("[step_wheels]\nvelocity = 0.0\naxle_moment = 0.0", "velocity along x is 0: a speed"),
        ("[step_wheels]\nvelocity = 20.0\nlongitudinal_force = 1.0\naxle_moment = 1.0", "axle_moment is 1.0"),
    ],
)
def test_check_refuses_what_a_step_refuses_by_its_words(
    line: str, wrong: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "case.toml"
    file.write_text(TEXT[: TEXT.index("[step_wheels]")] + line)
    assert main(["check", str(file)]) == BAD_INPUT
    assert wrong in capsys.readouterr().err
    assert main(["run", str(file), "-o", str(tmp_path / "out")]) == BAD_INPUT
    assert wrong in capsys.readouterr().err
