# SPDX-License-Identifier: MIT OR Apache-2.0
"""Scenes with an elastic body of one's own say how good they are: samples of studies/honesty_bodies.py and
studies/honesty_shapes.py."""

from __future__ import annotations

import sys
from importlib import import_module
from pathlib import Path

import pytest

SAMPLE = (0, 8, 11, 19)


@pytest.mark.parametrize("number", SAMPLE)
def test_estimates_of_own_bodies_are_honest(number: int, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend(str(Path(__file__).parents[2] / "studies"))
    study = import_module("honesty_bodies")
    monkeypatch.delitem(sys.modules, "honesty_bodies")
    for estimate, truth in study.examine(study.CASES[number]).values():
        assert truth <= 2.0 * estimate
        assert estimate < 0.2


def test_the_estimate_costs_less_than_the_solve(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend(str(Path(__file__).parents[2] / "studies"))
    study = import_module("honesty_bodies")
    monkeypatch.delitem(sys.modules, "honesty_bodies")
    result = study.CASES[1].solve()
    assert result.error_estimate == result.report.error_estimates["pressure"]
    spent = result.report.operations
    assert 0.0 < spent["choice and estimate"] < spent["condensation"] + spent["solution"]


#: A wedge, a sloping surface of triangles, and a round pin under a given gap.
SHAPES = (9, 15, 22)


@pytest.mark.parametrize("number", SHAPES)
@pytest.mark.slow
def test_estimates_of_other_shapes_are_honest(number: int, monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("gmsh", exc_type=ImportError)
    monkeypatch.syspath_prepend(str(Path(__file__).parents[2] / "studies"))
    study = import_module("honesty_shapes")
    for name in ("honesty_shapes", "other_meshes"):
        monkeypatch.delitem(sys.modules, name)
    said = study.examine(study.CASES[number])
    assert set(said) == {"pressure", "force", "displacement"}
    assert study.is_honest(said), said
