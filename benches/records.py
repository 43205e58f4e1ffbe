# SPDX-License-Identifier: MIT OR Apache-2.0
"""What a bench measured, as CSV: written after a run, read to draw its picture again without one."""

from __future__ import annotations

import csv
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import matplotlib
import matplotlib.style

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
