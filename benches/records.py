# SPDX-License-Identifier: MIT OR Apache-2.0
"""What a bench measured, as CSV: written after a run, read to draw its picture again without one."""

from __future__ import annotations

import argparse
import csv
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import matplotlib
import matplotlib.style

from mtb_rs.base.files import output_folder

matplotlib.use("Agg")
matplotlib.style.use("mtb_rs.pictures")

Record = Mapping[str, Any]


def write(path: Path, rows: Sequence[Record]) -> None:
    """Rows that share their columns."""
    path.parent.mkdir(parents=True, exist_ok=True)
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, list(rows[0]), lineterminator="\n")
        writer.writeheader()
        writer.writerows(rows)


def read(path: Path) -> list[dict[str, str]]:
    """The rows of a table, all values as text."""
    with path.open(encoding="utf-8") as file:
        return list(csv.DictReader(file))


def main(
    description: str | None,
    name: str,
    run: Callable[[], Sequence[Record]],
    chart: Callable[[list[dict[str, str]], Path], None],
) -> None:
    """Runs a bench, unless it is only drawn again, and draws the chart of its table."""
    parser = argparse.ArgumentParser(description=(description or "").splitlines()[0])
    parser.add_argument("--out", type=output_folder, default="docs/charts", help="where CSV and chart go")
    parser.add_argument("--draw", action="store_true", help="only draw the table again that is there")
    arguments = parser.parse_args()
    table = arguments.out / f"{name}.csv"
    if not arguments.draw:
        write(table, run())
    chart(read(table), table.with_suffix(".png"))
