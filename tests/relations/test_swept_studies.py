# SPDX-License-Identifier: MIT OR Apache-2.0
"""A sweep wears, heats and brakes each case as one by one, from Python, in processes and from a case file."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import mtb_rs as mtb
from mtb_rs.commands import main
from mtb_rs.commands.exits import BAD_INPUT

pytestmark = pytest.mark.coarse


def shoe(**given: Any) -> mtb.Scene:
    return mtb.scenes.pole_shoe_on_rail(
        **{"friction": 0.12, "magnetic_pressure": 2e6, "velocity": 20.0, "spacing": 0.012, **given}
    )


#: A study, an argument of its own with values, the column that tells the end, and the same without a sweep.
STUDIES: dict[str, tuple[Any, str, list[Any], str, Callable[[Any], float]]] = {
    "wear": (
        partial(mtb.wear, distance=1e4, law=1e-14),
        "wear.law",
        [1e-14, 1e-13],
        "depth_upper",
        lambda found: found.depth[0, -1],
    ),
    "brake": (
        partial(mtb.brake, speed=10.0, mass=2e3, wear=1e-13),
        "brake.speed",
        [5.0, 8.0],
        "way",
        lambda found: found.way[-1],
    ),
    "start": (
        partial(mtb.Scene.start_of_sliding, displacements=[1e-6, 2e-6]),
        "start_of_sliding.pressure",
        ["held", "follows"],
        "force_x",
        lambda found: found.force[-1, 0],
    ),
    "heat": (
        partial(mtb.Scene.sliding_heat, duration=2.0, steps=4),
        "sliding_heat.resistance",
        [0.0, 1e-4],
        "peak_temperature",
        lambda found: found.peaks.max(),
    ),
}


@pytest.mark.parametrize("word", STUDIES)
def test_a_swept_study_is_that_of_each_case(word: str, tmp_path: Path) -> None:
    study, name, values, column, told = STUDIES[word]
    frictions = [0.1, 0.2]
    file = tmp_path / "sweep.jsonl"
    table = mtb.sweep(shoe(), {"friction": frictions, name: values}, study=study, checkpoint=file)
    assert table.failures == []
    argument = name.partition(".")[2]
    alone = [[told(study(shoe(friction=mu), **{argument: v})) for v in values] for mu in frictions]
    assert table[column] == pytest.approx(np.array(alone), rel=1e-12)
    assert table.units[column] in ("m", "K", "N")
    # nothing is solved again
    again = mtb.sweep(shoe(), {"friction": frictions, name: values}, study=study, checkpoint=file)
    assert np.array_equal(again["time"], table["time"])
    # of another study it is another sweep
    other = partial(study.func, **{**study.keywords, "tolerance": 0.2})
    with pytest.raises(ValueError, match="another"):
        mtb.sweep(shoe(), {"friction": frictions, name: values}, study=other, checkpoint=file)


def test_processes_and_measures_take_studies() -> None:
    study = STUDIES["wear"][0]
    table = mtb.sweep(
        shoe(),
        [{"friction": 0.1, "wear.distance": 1e3}, {"friction": 0.2}],
        study=study,
        executor=2,
        measure=deepest,
    )
    assert table.failures == []
    assert table["deepest"] == pytest.approx(table["depth_upper"])


def deepest(found: mtb.WearResult) -> dict[str, float]:
    return {"deepest": float(found.depths[0, -1].max())}


@pytest.mark.parametrize(
    ("study", "options", "said"),
    [
        (partial(mtb.brake, speed=10.0, mas=3.0), {}, "missing a required argument: 'mass'"),
        (partial(mtb.wear, distance=1.0, **{"lav": 1.0}), {}, "'lav', which is no argument"),  # type: ignore[arg-type]
        (partial(mtb.wear, 1.0), {}, "without a name"),
        (partial(mtb.wear, distance=1.0, law=1e-13, progress=True), {}, "give it to the sweep"),
        (partial(mtb.wear, distance=1.0, law=1e-13), {"tolerance": 0.1}, "only model"),
        (3.0, {}, "a function of a scene"),
    ],
)
def test_what_no_sweep_can_study_is_told(study: Any, options: dict[str, Any], said: str) -> None:
    with pytest.raises(ValueError, match=said):
        mtb.sweep(shoe(), {"friction": [0.1]}, study=study, **options)
    good = partial(mtb.wear, distance=1.0, law=1e-13)
    with pytest.raises(ValueError, match="give one of the two"):
        mtb.sweep(shoe(), {"friction": [0.1]}, study=good, motion=mtb.Rolling((1e-3, 0.0, 0.0)))
    with pytest.raises(ValueError, match=r"did you mean 'wear.distance'"):
        mtb.sweep(shoe(), {"wear.distence": [0.1]}, study=good)


CASE = """
scene = "pole_shoe_on_rail"
friction = 0.12
magnetic_pressure = 2e6
velocity = 20.0
spacing = 0.012

"""


def test_cases_that_wear_or_brake_are_swept(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    case = tmp_path / "case.toml"
    tables = {
        "wear": ("distance = 1e4\nlaw = 1e-14", "wear.law=1e-14,1e-13", STUDIES["wear"]),
        "brake": ("speed = 10.0\nmass = 2e3\nwear = 1e-13", "brake.speed=5,8", STUDIES["brake"]),
    }
    for word, (lines, vary, (study, name, values, column, told)) in tables.items():
        case.write_text(f"{CASE}[{word}]\n{lines}\n")
        out = tmp_path / word
        assert main(["sweep", str(case), "--vary", vary, "-o", str(out)]) == 0
        found = mtb.load(out)
        argument = name.partition(".")[2]
        alone = [told(study(shoe(), **{argument: v})) for v in values]
        assert found[column] == pytest.approx(np.array(alone), rel=1e-12)
    case.write_text(f"{CASE}[brake]\nspeed = 10.0\nmass = 2e3\n[solve]\ntolerance = 0.1\n")
    assert main(["sweep", str(case), "--vary", "brake.speed=5,8", "-o", str(tmp_path / "no")]) == BAD_INPUT
    assert "only solve.model has a meaning" in " ".join(capsys.readouterr().err.split())
