# SPDX-License-Identifier: MIT OR Apache-2.0
"""Case files that brake: the same stop as in Python, every error at its place, files that come back."""

from __future__ import annotations

import copy
import csv
import json
import pickle
from itertools import combinations
from pathlib import Path
from typing import Any

import jsonschema
import numpy as np
import pytest

import mtb_rs as mtb
from mtb_rs.case import case_from_words
from mtb_rs.case.schema import schema
from mtb_rs.case.summary_schema import summary_schema
from mtb_rs.commands import main
from mtb_rs.commands.exits import BAD_INPUT, STOPPED
from mtb_rs.pictures.files import MAPS
from mtb_rs.studies.brake import Ride

SHOE = {"scene": "pole_shoe_on_rail", "spacing": 0.012, "friction": 0.1, "magnetic_pressure": 1e6}
BRAKE = {
    "speed": 10.0,
    "mass": 2e3,
    "other_force": {"velocity": [0.0, 20.0], "value": [500.0, 700.0]},
    "shares": [1.0, 0.5, 1.0],
    "tolerance": 0.5,
    "lower": {"conductivity": 40.0, "density": 7800.0, "specific_heat": 500.0, "expansion": 1e-5},
    "bulk": [5.0, 10.0],
    "film": [20.0, 5.0],
    "resistance": 1e-5,
    "share": 0.2,
    "expansion": True,
    "wear": 1e-12,
    "lower_wear": {"k": 1e-4, "hardness": 3e9},
    "fading": [[0.0, 200.0], [1.0, 0.8]],
}
TEXT = (
    'scene = "pole_shoe_on_rail"\nspacing = 0.012\nfriction = 0.1\nmagnetic_pressure = 1e6\n'
    "[brake]\nspeed = 10.0\nmass = 2e3\nshares = [1.0, 0.5]\ntolerance = 0.5\nwear = 1e-12\n"
)


@pytest.fixture(scope="module")
def stop() -> mtb.Braking:
    found = case_from_words({**SHOE, "brake": BRAKE}).solve()
    assert isinstance(found, mtb.Braking)
    return found


def test_a_case_brakes_as_python_does(stop: mtb.Braking) -> None:
    own = mtb.brake(
        mtb.scenes.pole_shoe_on_rail(spacing=0.012, friction=0.1, magnetic_pressure=1e6),
        10.0, 2e3, lambda v: 500.0 + 10.0 * v, shares=(1.0, 0.5, 1.0), tolerance=0.5,
        lower=mtb.Conductor(40.0, 7800.0, 500.0, 1e-5), bulk=(5.0, 10.0), film=(20.0, 5.0), resistance=1e-5,
        share=0.2, expansion=True, wear=1e-12, lower_wear=mtb.Archard.of_hardness(1e-4, 3e9),
        fading=([0.0, 200.0], [1.0, 0.8]),
    )  # fmt: skip
    assert stop.speed[-1] == own.speed[-1] == 0.0
    assert stop.way == pytest.approx(own.way, rel=1e-9)
    assert stop.shoes[1].pressure == pytest.approx(own.shoes[1].pressure, rel=1e-6)
    assert stop.other_force[0] == pytest.approx(600.0, rel=1e-12)


@pytest.mark.slow
def test_what_was_saved_comes_back(stop: mtb.Braking, tmp_path: Path) -> None:
    written = {path.name for path in stop.save(tmp_path)}
    assert {f"{name}.png" for name in (*stop.curves, "wear", "pressure")} <= written
    again = mtb.load(tmp_path)
    assert isinstance(again, mtb.Braking)
    for name in ("time", "speed", "way", "forces", "other_force", "errors"):
        np.testing.assert_array_equal(getattr(again, name), getattr(stop, name))
    for one, other in zip(again.shoes, stop.shoes, strict=True):
        np.testing.assert_array_equal(one.pressures, other.pressures)
        np.testing.assert_array_equal(one.depths, other.depths)
    assert again == stop._kept() == pickle.loads(pickle.dumps(again)) == copy.deepcopy(again)
    assert again != mtb.load(tmp_path).shoes[0]
    # shoes that are the same are kept once
    with np.load(tmp_path / "result.npz") as arrays:
        assert not any(name.startswith("shoes.2") for name in arrays.files)
    told = json.loads((tmp_path / "summary.json").read_text())
    jsonschema.validate(told, summary_schema())
    assert told["inputs"]["scene"] == "pole_shoe_on_rail"
    assert told["open_energy"] == stop.open_energy
    for name in stop.curves:
        assert again.plot(name).axes[0].lines
    assert again.plot("wear", body="upper").axes
    assert "wear" not in MAPS  # of the upper body alone, so that it has a picture of its own
    # the shoe that is pulled most
    assert again.shoe.forces[0] == pytest.approx(stop.shoes[0].forces[0])
    stop.save(tmp_path)


def test_a_damaged_stop_is_refused(stop: mtb.Braking, tmp_path: Path) -> None:
    stop.save(tmp_path)
    record = tmp_path / "result.json"
    held = json.loads(record.read_text())
    del held["sha256"]["result"]
    held["result"]["of"]["shoes"]["tuple"].pop()
    record.write_text(json.dumps(held))
    with pytest.raises(ValueError, match="beside 2 shoes"):
        mtb.load(tmp_path)


def test_every_error_is_told_at_its_place() -> None:
    wrong = {
        "speed": -3.0,
        "mass": "heavy",
        "shares": [1.0, -1.0],
        "other_force": {"velocity": [0.0, 1.0], "value": [1.0, -2.0]},
        "tolerance": 2,
        "lower": {"conductivity": 50},
        "upper": 3,
        "bulk": 3,
        "film": [-1.0, 0.0],
        "resistance": -1.0,
        "share": 2,
        "expansion": "yes",
        "wear": {"k": 1},
        "lower_wear": True,
        "fading": [[1.0, 0.0], [1.0, 1.0]],
        "restistance": 1e-5,
    }
    with pytest.raises(mtb.CaseError) as caught:
        case_from_words({**SHOE, "brake": wrong})
    lines = str(caught.value).splitlines()
    assert [line for line in lines if not line.startswith("case: brake.")] == []
    assert {line.split(" ")[1].removeprefix("brake.") for line in lines} == set(wrong)
    assert "did you mean 'resistance'" in str(caught.value)
    with pytest.raises(mtb.CaseError, match=r"brake\.speed: is missing\n.*brake\.mass: is missing"):
        case_from_words({**SHOE, "brake": {}})
    above = {"velocity": [5.0, 50.0], "value": [1.0, 2.0]}
    with pytest.raises(mtb.CaseError, match=r"brake\.other_force.*velocity\[0\] is 5 m/s: a stop goes down"):
        case_from_words({**SHOE, "brake": {"speed": 1.0, "mass": 1.0, "other_force": above}})
    with pytest.raises(mtb.CaseError, match="brake = 3: a table is needed"):
        case_from_words({**SHOE, "brake": 3})
    few = {"speed": 1.0, "mass": 1.0}
    others: tuple[dict[str, Any], ...] = (
        {"wear": {"distance": 1.0, "law": 1e-13}},
        {"rolling": {}},
        {"shift": {}},
    )
    for other in others:
        with pytest.raises(mtb.CaseError, match=f"brake and {next(iter(other))} are given"):
            case_from_words({**SHOE, "brake": few, **other})
    for more, words in (
        ({"solve": {"tolerance": 0.1}}, "beside .brake. only solve.model"),
        ({"solve": {"model": "half-space"}}, "heat needs an elastic upper body"),
    ):
        with pytest.raises(mtb.CaseError, match=words):
            case_from_words({**SHOE, "brake": few, **more}).expected_cost()
    with pytest.raises(mtb.CaseError, match="magnetic_pressure is None"):
        case_from_words({"scene": "paraboloid_on_plane", "friction": 0.1, "brake": few}).expected_cost()
    hot = {**few, "expansion": True, "lower": {"conductivity": 1.0, "density": 1.0, "specific_heat": 1.0}}
    with pytest.raises(mtb.CaseError, match="a Conductor with a coefficient of expansion"):
        case_from_words({**SHOE, "brake": hot | {"upper": hot["lower"]}}).expected_cost()


@pytest.mark.slow
def test_the_schema_takes_what_a_case_takes() -> None:
    look = schema()
    jsonschema.validate({**SHOE, "brake": BRAKE}, look)
    tables = {"wear": {"distance": 1.0, "law": 1e-13}, "brake": BRAKE, "rolling": {}, "shift": {}}
    for pair in combinations(tables, 2):
        with pytest.raises(jsonschema.ValidationError):
            jsonschema.validate({**SHOE, **{name: tables[name] for name in pair}}, look)
    wrong: tuple[dict[str, Any], ...] = (
        {"speed": 0.0},
        {"share": 2.0},
        {"wear": "much"},
        {"lower": {}},
        {"sped": 1.0},
    )
    for bad in wrong:
        with pytest.raises(jsonschema.ValidationError):
            jsonschema.validate({**SHOE, "brake": BRAKE | bad}, look)


@pytest.mark.filterwarnings("ignore::mtb_rs.PictureWarning")
def test_the_command_brakes(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file, out = tmp_path / "case.toml", tmp_path / "out"
    file.write_text(TEXT)
    assert main(["check", str(file)]) == 0
    told = capsys.readouterr().out
    assert "brake 2000 kg from 10 m/s by 2 such shoes" in told
    assert "one contact" in told
    assert main(["brake", str(file), "-o", str(out)]) == 0
    assert "heat of the shoes" in capsys.readouterr().out
    stop = mtb.load(out)
    assert isinstance(stop, mtb.Braking)
    rows = list(csv.DictReader((out / "brake.csv").read_text().splitlines()))
    np.testing.assert_array_equal([float(row["time [s]"]) for row in rows], stop.time[1:])
    np.testing.assert_array_equal([float(row["way [m]"]) for row in rows], stop.way[1:])
    assert float(rows[-1]["volume_upper [m^3]"]) == pytest.approx(stop.worn_volume[0], rel=1e-12)
    picture = tmp_path / "forces.svg"
    assert main(["show", str(out), "-o", str(picture), "--quantity", "forces"]) == 0
    assert picture.exists()
    assert main(["chart", str(file), "-o", str(tmp_path / "other")]) == BAD_INPUT
    assert "[brake] is given" in capsys.readouterr().err
    file.write_text(TEXT.partition("[brake]")[0])
    assert main(["brake", str(file), "-o", str(out)]) == BAD_INPUT
    assert "has no table [brake]" in capsys.readouterr().err


def test_a_stop_goes_on_where_it_was_interrupted(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    file, out = tmp_path / "case.toml", tmp_path / "out"
    file.write_text(TEXT)
    settled = Ride._settled
    count = 0

    def stopped(*given: Any) -> Any:
        nonlocal count
        count += 1
        if count == 7:
            raise KeyboardInterrupt
        return settled(*given)

    monkeypatch.setattr("mtb_rs.studies.brake.Ride._settled", stopped)
    assert main(["brake", str(file), "-o", str(out)]) == STOPPED
    assert "stopped" in capsys.readouterr().err
    assert [path.name for path in out.iterdir()] == ["brake.jsonl"]
    kept = (out / "brake.jsonl").read_bytes()
    assert main(["brake", str(file), "-o", str(out)]) == 0
    again, whole = mtb.load(out), mtb.load_case(file).solve()
    assert isinstance(again, mtb.Braking)
    assert isinstance(whole, mtb.Braking)
    # what was done is not done again
    assert (out / "brake.jsonl").read_bytes().startswith(kept)
    tried = count
    mtb.load_case(file).braked(checkpoint=out / "brake.jsonl")
    assert count == tried
    for name in ("time", "speed", "way", "forces", "errors"):
        np.testing.assert_allclose(getattr(again, name), getattr(whole, name), rtol=1e-12, atol=1e-12)
    np.testing.assert_allclose(again.shoe.depths, whole.shoe.depths, rtol=1e-9)
    capsys.readouterr()
    file.write_text(TEXT.replace("mass = 2e3", "mass = 3e3"))
    assert main(["brake", str(file), "-o", str(out)]) == BAD_INPUT
    assert "brake.jsonl is the checkpoint of another stop" in " ".join(capsys.readouterr().err.split())
