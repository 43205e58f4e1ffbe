# SPDX-License-Identifier: MIT OR Apache-2.0
"""The sources' tables are in the pages, from committed files that keep their bars."""

from __future__ import annotations

import csv
from pathlib import Path

import pytest

DOCS = Path(__file__).parents[2] / "docs"
THESIS = ("3.1", "3.2", "3.4", "3.7", "4.1", "4.2", "C.1", "C.2", "C.3")


def rows(name: str) -> list[dict[str, str]]:
    with (DOCS / name).open(encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file))


@pytest.mark.parametrize("number", THESIS)
def test_thesis_table(number: str) -> None:
    page = (DOCS / "thesis.md").read_text(encoding="utf-8")
    section = page.split(f"## Table {number}\n")[1].split("\n## ")[0]
    assert "thesis" in section
    assert "{records}" in section or "|---|" in section


def test_paper_table_is_complete() -> None:
    found = {(r["profiles"], r["prescribed"], r["spacing_mm"]) for r in rows("charts/paper_table_1.csv")}
    spacings = ("0.1", "0.05", "0.025")
    assert found == {
        (p, k, s) for p in ("smooth", "measured") for k in ("force", "approach") for s in spacings
    }


def test_paper_table_keeps_its_bars() -> None:
    for row in rows("charts/paper_table_1.csv"):
        # products and preconditionings do not grow with the grid, nor with irregularities of the profile
        assert float(row["convolutions"]) <= 20.0
        assert float(row["preconditionings"]) <= 20.0
        if row["peak_difference_percent"]:
            for name in ("peak", "area", "approach", "force"):
                assert abs(float(row[f"{name}_difference_percent"])) < 0.2
        if row["contact_2025_s"]:
            assert float(row["seconds"]) < float(row["contact_2025_s"])


@pytest.mark.parametrize("case", ["sphere", "rough bowl"])
@pytest.mark.parametrize("cells", ["32", "128", "512"])
def test_default_tolerance_stops_where_the_error_is_the_cells(case: str, cells: str) -> None:
    mine = [r for r in rows("charts/tolerance.csv") if (r["case"], r["cells_a_side"]) == (case, cells)]
    (default,) = (r for r in mine if not r["tolerance"])
    sharpest = min((r for r in mine if r["tolerance"]), key=lambda r: float(r["tolerance"]))
    assert float(default["error"]) == pytest.approx(float(sharpest["error"]), rel=0.02)
    assert float(default["convolutions"]) < 0.85 * float(sharpest["convolutions"])


def test_what_the_pages_say_of_bodies_that_creep() -> None:
    found = rows("maps/creeping.csv")
    told = [row for row in found if row["tolerance"] != "nan"]
    failed = [row for row in told if row["convolutions"] == "nan"]
    assert (len(told), len(failed)) == (90, 3)
    assert {(row["creep"], row["cells"]) for row in failed} == {("100", "320")}
    peaks = {
        creep: max(_number(row, "error_peak") for row in found if row["creep"] == creep)
        for creep in ("10", "100")
    }
    assert 0.1 < peaks["10"] < 0.15
    assert peaks["100"] > 0.5
    for row in found:
        # cells over a third of the way in a creep time over 1 + creep
        wide = 3.0 * (1.0 + float(row["creep"])) / (float(row["cells"]) * float(row["number"]))
        if wide < 1.01:
            assert _number(row, "error_peak") < 0.02


def _number(row: dict[str, str], name: str) -> float:
    return 0.0 if row[name] == "nan" else float(row[name])
