# SPDX-License-Identifier: MIT OR Apache-2.0
"""A result whose estimated error exceeds what was aimed at says so, and what would do."""

from __future__ import annotations

import re
import warnings
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import mtb_rs as mtb
from mtb_rs.bodies.mesh import block_mesh
from mtb_rs.commands import main


def paraboloid(points: int = 16) -> mtb.Scene:
    return mtb.scenes.paraboloid_on_plane(points=points)


def own_block(elements: int, spacing: float, tolerance: float) -> mtb.Result:
    line = np.linspace(-0.05, 0.05, elements + 1)
    held = mtb.Support("top", x=0, y=0, z=0)
    body = mtb.ElasticBody(block_mesh(line, line, 0.05), mtb.steel, "contact", [held])
    scene = mtb.Scene(body, mtb.steel, spacing=spacing, friction=0.2, magnetic_pressure=3e6)
    return scene.solve(tolerance=tolerance)


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("name", mtb.scenes.__all__)
@pytest.mark.slow
def test_ready_scenes_as_they_are_say_nothing(name: str) -> None:
    result = getattr(mtb.scenes, name)().solve()
    assert not result.report.missed
    assert result.error_estimate <= 0.075


@pytest.mark.parametrize("quantity", ["pressure", "force", "displacement"])
def test_a_missed_tolerance_is_told_where_the_caller_stands(quantity: str) -> None:
    with pytest.warns(mtb.ToleranceWarning) as caught:
        result = mtb.scenes.block_on_plane(spacing=25e-3).solve(tolerance=1e-3, quantity=quantity)
    (warning,) = caught
    assert warning.filename == __file__
    said = str(warning.message)
    assert said.startswith(f"The estimated error of the {quantity} is ")
    assert "where 0.1 % is asked for" in said
    assert (
        'cells of 10 mm or finer; spacing=None finds what is needed (in a case file spacing = "auto")' in said
    )
    assert result.report.missed == said
    assert said in str(result)
    assert "above the tolerance" in result.report.status
    assert result.report.converged


def test_no_tolerance_leaves_room_that_a_given_one_does_not() -> None:
    scene = paraboloid(24)
    result = scene.solve()
    assert 0.05 < result.error_estimate < 0.075
    assert result.report.aim == ("pressure", 0.05)
    assert not result.report.missed
    with pytest.warns(mtb.ToleranceWarning, match=r"where 5 % is asked for"):
        assert scene.solve(tolerance=0.05).error_estimate == result.error_estimate
    with pytest.warns(mtb.ToleranceWarning, match=r"where 5 % is asked for"):
        assert paraboloid(12).solve().error_estimate > 0.075


@pytest.mark.parametrize("kind", ["paraboloid", "block", "wheel"])
def test_what_is_said_to_do_does(kind: str) -> None:
    make, key, value, tolerance = {
        "paraboloid": (mtb.scenes.paraboloid_on_plane, "points", 16, 0.05),
        "block": (mtb.scenes.block_on_plane, "spacing", 12.5e-3, 0.03),
        "wheel": (mtb.scenes.wheel_on_rail, "spacing", 5e-4, 0.05),
    }[kind]
    settled = False
    for _ in range(4):
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            result = make(**{key: value}).solve(tolerance=tolerance)
        if not caught:
            break
        assert not settled or result.error_estimate <= 1.25 * tolerance
        (warning,) = caught
        found = re.search(r"needs (?:cells of )?(about )?([\d.]+) (mm|µm|points)", str(warning.message))
        assert found is not None
        finer = float(found[2]) * {"mm": 1e-3, "µm": 1e-6, "points": 1}[found[3]]
        assert (value < finer <= 3 * value) if key == "points" else (0.3 * value < finer < value)
        value = int(finer) if key == "points" else finer
        settled = found[1] is not None
    assert result.error_estimate <= tolerance


def test_own_bodies_are_told_of_their_mesh() -> None:
    with pytest.warns(mtb.ToleranceWarning, match=r"a finer mesh of the elastic body\."):
        result = own_block(4, 0.1 / 6, 0.02)
    assert "spacing=None" not in result.report.missed
    assert not own_block(4, 0.1 / 6, 0.9).report.missed


def test_an_element_size_is_told_as_well() -> None:
    scene = mtb.scenes.block_on_plane(spacing=25e-3, friction=0.2).with_(element_size=25e-3)
    with pytest.warns(mtb.ToleranceWarning, match=r"cells of 10 mm or finer and an element_size of 10 mm\."):
        scene.solve(tolerance=1e-3)


def test_named_models_and_methods_without_an_estimate_say_nothing() -> None:
    block = mtb.scenes.block_on_plane(spacing=25e-3, friction=0.1)
    assert not block.solve("half-space", tolerance=1e-3).report.missed
    assert not block.solve(method="incremental", tolerance=1e-3).report.missed


def test_a_sweep_says_it_once_with_the_count(tmp_path: Path) -> None:
    kept = tmp_path / "sweep.jsonl"
    values = {"points": [10, 12, 34, 40]}
    for executor in (None, ThreadPoolExecutor(2)):
        with pytest.warns(
            mtb.ToleranceWarning, match=r"^2 of 4 cases miss the tolerance\. The first"
        ) as caught:
            table = mtb.sweep(paraboloid(), values, executor=executor, checkpoint=kept)
        assert len(caught) == 1
        assert caught[0].filename == __file__
        assert (table.status == "solved").all()
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        mtb.sweep(paraboloid(), {"points": [34, 40]})


def test_the_command_line_says_it_in_a_line(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    case = tmp_path / "case.toml"
    case.write_text('scene = "paraboloid_on_plane"\npoints = 12\n')
    assert main(["run", str(case), "-o", str(tmp_path / "out")]) == 0
    shown = capsys.readouterr()
    assert shown.err.startswith("mtb-rs: The estimated error of the pressure is ")
    assert shown.err.count("\n") == 1
    assert "points=None" in shown.out
    assert main(["sweep", str(case), "--vary", "points=10,12", "-o", str(tmp_path / "sweep")]) == 0
    assert "mtb-rs: 2 of 2 cases miss the tolerance." in capsys.readouterr().err
    case.write_text('scene = "paraboloid_on_plane"\npoints = 12\n[solve]\ntolerance = 0.5\n')
    assert main(["run", str(case), "-o", str(tmp_path / "out")]) == 0
    assert capsys.readouterr().err == ""


BOX = block_mesh(np.linspace(-0.05, 0.05, 11), np.linspace(-0.05, 0.05, 11), 0.09)


def tilting(friction: float) -> mtb.Scene:
    """A block of one's own, driven at its top and free to tilt."""
    held = [
        mtb.Support(((0.0, 0.0), (0.0, 0.0), (0.09, 0.09)), x=0, y=0),
        mtb.Support(((0.01, 0.01), (0.0, 0.0), (0.09, 0.09)), y=0),
    ]
    body = mtb.ElasticBody.from_mesh(BOX, mtb.steel, contact="bottom", supports=held)
    return mtb.Scene(upper=body, lower=mtb.steel, spacing=1e-2, friction=friction, force=3e4)


def driven(height: float, spacing: float | None) -> mtb.Scene:
    return mtb.scenes.block_on_plane(height=height, friction=0.5, supports="driven-top", spacing=spacing)


@pytest.mark.parametrize("tolerance", [None, 0.02])
@pytest.mark.parametrize(
    ("make", "model"),
    [
        (lambda: driven(0.087, 10e-3), "auto"),
        (lambda: driven(0.09, 10e-3), "auto"),
        (lambda: driven(0.092, 10e-3), "elastic-upper"),
        (lambda: tilting(0.49), "auto"),
        (lambda: mtb.scenes.block_on_plane(spacing=0.033), "auto"),
    ],
    ids=["tall", "taller", "fullest model", "own body", "three cells a side"],
)
def test_where_no_error_can_be_estimated_the_result_says_so(
    make: Callable[[], mtb.Scene], model: Any, tolerance: float | None
) -> None:
    with pytest.warns(mtb.ToleranceWarning, match=r"^No error can be estimated: it needs cells of ") as told:
        result = make().solve(model, tolerance=tolerance)
    assert not result.report.error_estimates
    assert str(told[0].message) == result.report.missed
    assert result.report.status == "solved, not resolved"
    assert result.report.converged


@pytest.mark.slow
def test_a_free_spacing_goes_on_until_an_error_can_be_estimated() -> None:
    result = driven(0.09, None).solve(tolerance=0.3)
    assert result.error_estimate <= 0.3
    assert not result.report.missed
