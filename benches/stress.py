# SPDX-License-Identifier: MIT OR Apache-2.0
"""Stress below a contact: its error over the cells, and its time over cells and depths.

    python benches/stress.py [--out docs/charts]

A Hertzian contact with friction everywhere; the error is that of the largest component at points below it,
over the peak pressure, against cells a third as wide as the finest. Times are medians of processor seconds.
"""

from __future__ import annotations

import time
from pathlib import Path
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
import records
from numpy.typing import NDArray

from mtb_rs import _mtb_rs
from mtb_rs.pictures.quantities import LINE_COLOURS

Array = NDArray[np.float64]

STEEL = (80e9, 0.3)
FRICTION, FINE = 0.3, 8
CELLS, DEPTHS = (10, 20, 40, 80, 160), (1, 10, 30)
FINEST = 480


def tractions(n: int) -> Array:
    """Tractions (3, n, n) over the square around the contact circle, means over each cell."""
    x = (np.arange(FINE * n) + 0.5) * 2.0 / (FINE * n) - 1.0
    whole = np.sqrt(np.maximum(1.0 - x[None] ** 2 - x[:, None] ** 2, 0.0))
    pressure = whole.reshape(n, FINE, n, FINE).mean(axis=(1, 3))
    return np.stack([FRICTION * pressure, 0.0 * pressure, pressure])


def at_points(n: int, points: Array) -> Array:
    x = (np.arange(n) + 0.5) * 2.0 / n - 1.0
    places = np.stack(np.meshgrid(x, x), axis=-1).reshape(-1, 2)
    cells = np.concatenate([places, np.full_like(places, 2.0 / n)], axis=1)
    rows = np.ascontiguousarray(tractions(n).reshape(3, -1))
    return np.asarray(_mtb_rs.stress_at(STEEL, cells, rows, points))


def seconds(n: int, depths: int) -> float:
    """Processor time of the stress at depths below all cells."""
    loads, deep = tractions(n), np.linspace(0.0, 2.0, depths).tolist()
    taken = []
    for _ in range(5):
        start = time.process_time()
        _mtb_rs.stress_below(STEEL, (2.0 / n, 2.0 / n), loads, deep, False)
        taken.append(time.process_time() - start)
    return float(np.median(taken))


def run() -> list[dict[str, Any]]:
    """Errors and times on all grids, and the time that is asked for: 100 x 100 x 30 points."""
    points = np.random.default_rng(1).uniform(-1.2, 1.2, (30, 3))
    points[:, 2] = np.linspace(0.25, 2.0, 30)
    exact = at_points(FINEST, points)
    rows = []
    for n in (*CELLS, 100):
        error = float(np.abs(at_points(n, points) - exact).max())
        row: dict[str, Any] = {"cells_a_side": n, "error": f"{error:.3e}"}
        rows.append(row | {f"time_{depths}_s": f"{seconds(n, depths):.3e}" for depths in DEPTHS})
        print(*rows[-1].values())
    return rows


def chart(rows: list[dict[str, str]], path: Path) -> None:
    """Error and time over the cells."""
    figure, (left, right) = plt.subplots(1, 2, figsize=(7.4, 3.2), layout="constrained")
    rows = sorted(rows, key=lambda row: int(row["cells_a_side"]))
    cells = np.array([int(row["cells_a_side"]) for row in rows], dtype=float)
    errors = np.array([100.0 * float(row["error"]) for row in rows])
    left.plot(cells, errors, marker=".", color=LINE_COLOURS[0], label="error")
    left.plot(
        cells, errors[0] * (cells[0] / cells) ** 2, color="#9A9A9A", linestyle=":", label="second order"
    )
    left.set(title="error of the stress [%]", xlabel="cells across the contact", xscale="log", yscale="log")
    left.legend()
    for colour, depths in zip(LINE_COLOURS, DEPTHS, strict=False):
        times = [float(row[f"time_{depths}_s"]) for row in rows]
        right.plot(cells, times, marker=".", color=colour, label=f"{depths} depth{'s' if depths > 1 else ''}")
    right.set(title="processor time [s]", xlabel="cells a side", xscale="log", yscale="log")
    right.legend()
    figure.savefig(path)


if __name__ == "__main__":
    records.main(__doc__, "stress", run, chart)
