# SPDX-License-Identifier: MIT OR Apache-2.0
"""Why `solve_normal` stops where the cells' error begins: error and work over the solver's tolerance.

    python benches/tolerance.py [--out docs/charts]

A sphere on a plane against Hertz, and a rough bowl against itself on cells a third as wide, averaged.
The error is that of the pressure, relative, L2 over the grid; the work is counted in convolutions on the
finest grid. The default's own point is in the table with an empty tolerance.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
import records
from numpy.typing import NDArray

import mtb_rs as mtb
from mtb_rs.pictures.quantities import LINE_COLOURS

Array = NDArray[np.float64]

ELASTIC, RIGID = mtb.Material(1.0, 0.0), mtb.Rigid()  # E* = 1 on the unit square
TOLERANCES = (*(10.0**-k for k in range(1, 11)), None)


def centres(n: int) -> Array:
    x = (np.arange(n) + 0.5) / n - 0.5
    return np.asarray(x)


def sphere(n: int) -> tuple[Array, float]:
    x = centres(n)
    return 0.5 * (x[None, :] ** 2 + x[:, None] ** 2), 4.0 / 3.0 * 0.375**3


def rough(n: int) -> tuple[Array, float]:
    heights = mtb.roughness(n, 1.0 / n, rms_height=2e-3, hurst=0.8, roll_off=0.25, shortest=1.0 / 8.0, seed=1)
    return sphere(n)[0] - heights, 0.03


def every_third(fine: Array) -> Array:
    """The same surface at the centres of cells three times as wide."""
    return np.ascontiguousarray(fine[1::3, 1::3])


def solve(gap: Array, force: float, tolerance: float | None) -> mtb.NormalResult:
    return mtb.solve_normal(
        gap, 1.0 / len(gap), lower=ELASTIC, upper=RIGID, force=force, tolerance=tolerance, method="fft"
    )


def hertz_pressure(n: int) -> Array:
    x = centres(3 * n)  # means over each cell, by 3 x 3 points
    square = 1.0 - (x[None, :] ** 2 + x[:, None] ** 2) / 0.375**2
    return averaged(2.0 * 0.375 / np.pi * np.sqrt(np.maximum(square, 0.0)), n)


def averaged(field: Array, n: int) -> Array:
    k = len(field) // n
    return np.asarray(field.reshape(n, k, n, k).mean(axis=(1, 3)))


def run() -> list[dict[str, Any]]:
    """Both cases on every grid, at every tolerance."""
    rows: list[dict[str, Any]] = []
    for name, case in (("sphere", sphere), ("rough bowl", rough)):
        for n in (32, 128, 512):
            fine, force = case(3 * n)
            gap = every_third(fine)
            exact = hertz_pressure(n) if name == "sphere" else averaged(solve(fine, force, 1e-6).pressure, n)
            for tolerance in TOLERANCES:
                found = solve(gap, force, tolerance)
                error = float(np.linalg.norm(found.pressure - exact) / np.linalg.norm(exact))
                row = {"case": name, "cells_a_side": n, "tolerance": f"{tolerance:.0e}" if tolerance else ""}
                row |= {"residual": f"{found.report.residual:.2e}", "error": f"{error:.4e}"}
                row |= {"iterations": found.report.iterations}
                row["convolutions"] = f"{found.report.convolutions:.2f}"
                rows.append(row)
                print(*row.values())
    return rows


def chart(rows: list[dict[str, str]], path: Path) -> None:
    """Error and work over the tolerance."""
    figure, axes = plt.subplots(2, 2, figsize=(7.4, 5.6), sharex=True)
    for column, case in zip(axes.T, ("sphere", "rough bowl"), strict=True):
        for colour, n in zip(LINE_COLOURS, ("32", "128", "512"), strict=False):
            mine = [row for row in rows if row["case"] == case and row["cells_a_side"] == n]
            asked = [row for row in mine if row["tolerance"]]
            (default,) = (row for row in mine if not row["tolerance"])
            x = [float(row["tolerance"]) for row in asked]
            for ax, key, unit in ((column[0], "error", 100.0), (column[1], "convolutions", 1.0)):
                y = [unit * float(row[key]) for row in asked]
                ax.plot(x, y, color=colour, marker=".", label=f"{n} cells a side")
                # where the default stops: at its own residual
                place = (float(default["residual"]), unit * float(default[key]))
                ax.plot(*place, "o", ms=10, mfc="none", mew=2, color=colour)
        column[0].set(title=f"{case}: error of the pressure [%]", xscale="log", yscale="log")
        column[1].set(title=f"{case}: convolutions", xlabel="tolerance (residual)", ylim=(0, None))
    axes[0, 0].legend(title="ring: the default")
    figure.savefig(path)


if __name__ == "__main__":
    records.main(__doc__, "tolerance", run, chart)
