# SPDX-License-Identifier: MIT OR Apache-2.0
"""Rolling over bodies that creep: what accuracy costs, and where it is lost.

A rigid cylinder rolls on a standard linear solid; Hunter's closed form is the truth at every speed. Speeds
are Deborah numbers D, with the length of the relaxed contact, and grids are cells in that length. First
picture: errors over processor time and convolutions. Second one: errors of the resistance to rolling and of
the peak pressure over speed and grid, and what the solver of convolutions takes to 1e-6, over speed and
creep.

Usage: python studies/creeping.py. Takes about a minute.
"""

import time
import warnings

import numpy as np
from atlas import draw_verdicts, panels, write

import mtb_rs as mtb
from mtb_rs.half_space.reference import CreepingCylinder

warnings.simplefilter("ignore")  # rubber under a cylinder deforms by more than linear elasticity carries
RUBBER, RADIUS, LOAD = mtb.Material(20e6, 0.49), 50e-3, 500.0
NUMBERS = [1e-3, 1e-2, 0.03, 0.1, 0.3, 1.0, 3.0, 10.0, 100.0]
GRIDS = [10, 20, 40, 80, 160, 320]
CREEPS = [0.2, 1.0, 3.0, 10.0, 100.0]
COLOURS = ("#56B4E9", "#E69F00", "#CC79A7", "#000000")
SHIFTS = (0.0, 0.23, 0.41)


def cylinder(number: float, creep: float) -> CreepingCylinder:
    exact = CreepingCylinder(RADIUS, LOAD, RUBBER, creep, 1.0)
    return CreepingCylinder(RADIUS, LOAD, RUBBER, creep, number * 2.0 * exact.extent_of(exact.relaxed))


def rolled(exact: CreepingCylinder, cells: int, shift: float, **options: object) -> dict[str, float]:
    """Errors and costs on a row of cells that is shifted by a part of a cell."""
    cell = 2.0 * exact.extent_of(exact.relaxed) / cells
    count = round(1.4 * cells)
    x = (np.arange(count) - 0.5 * (count - 1) + shift) * cell
    long = 1e3 * max(exact.way, cells * cell)
    body = mtb.Viscoelastic(exact.material, exact.creep, exact.way)
    clock = time.process_time()
    found = mtb.solve_normal(
        (x**2 / (2.0 * RADIUS))[None],
        (cell, long),
        lower=body,
        upper=mtb.Rigid(),
        force=LOAD * long,
        edge="sharp",
        rolling=mtb.Rolling(velocity=1.0),
        **options,
    )
    taken = time.process_time() - clock
    pressure = found.pressure[0]
    fine = exact.pressure(x[:, None] + cell * (np.arange(40) - 19.5) / 40).mean(axis=1)
    return {
        "error_pressure": float(np.linalg.norm(pressure - fine) / np.linalg.norm(fine)),
        "error_peak": abs(pressure.max() / exact.peak_pressure - 1.0),
        "error_resistance": abs(found.rolling_resistance / (long * exact.resistance) - 1.0),
        "convolutions": float(found.report.convolutions + found.report.preconditionings),
        "iterations": float(found.report.iterations),
        "residual": found.report.residual,
        "seconds": taken,
    }


def judged(exact: CreepingCylinder, cells: int, **options: object) -> dict[str, float]:
    """Root mean squares of the errors, and means of the costs, over shifts of the grid; NaN if one failed."""
    try:
        runs = [rolled(exact, cells, shift, **options) for shift in SHIFTS]
    except mtb.ConvergenceError:
        return {}
    means = {name: float(np.mean([run[name] for run in runs])) for name in runs[0]}
    squares = {
        name: float(np.sqrt(np.mean([run[name] ** 2 for run in runs]))) for name in runs[0] if "error" in name
    }
    return means | squares


def charted() -> None:
    """Errors over processor time and over convolutions."""
    figure, (times, counts) = panels(2)
    rows = []
    for number, colour in ((0.03, "#0072B2"), (0.3, "#D55E00"), (30.0, "#009E73")):
        for creep, method, line, most in (
            (1.0, "dense", "o--", 214),
            (1.0, "fft", "s-", 10**6),
            (10.0, "fft", "^:", 10**6),
        ):
            exact, own = cylinder(number, creep), []
            for cells in (*GRIDS, 640, 1280):
                if 1.4 * cells <= most:
                    judged(exact, cells, method=method)  # so that nothing is made for the first time
                    about = {"creep": creep, "number": number, "method": method, "cells": cells}
                    own.append(about | judged(exact, cells, method=method))
            rows += own
            shown = [row for row in own if "seconds" in row]
            errors = [100.0 * row["error_resistance"] for row in shown]
            drawn = {"color": colour, "markersize": 3.5, "linewidth": 1}
            if creep == 1.0:
                name = "dense" if method == "dense" else "FFT"
                times.loglog(
                    [1e3 * row["seconds"] for row in shown],
                    errors,
                    line,
                    label=f"D = {number:g}, {name}",
                    **drawn,
                )
            if method == "fft":
                label = f"D = {number:g}, creep {creep:g}"
                counts.loglog([row["convolutions"] for row in shown], errors, line, label=label, **drawn)
    times.set(xlabel="processor time [ms]", ylabel="error of the resistance [%]", title="creep 1")
    counts.set(xlabel="convolutions", ylabel="error of the resistance [%]", title="FFT")
    counts.set_xticks([30, 50, 100, 200, 500, 1000], ["30", "50", "100", "200", "500", "1000"])
    counts.set_xticks([], minor=True)
    for place in (times, counts):
        place.legend(fontsize=7)
    keys = list(dict.fromkeys(key for row in rows for key in row))
    write("creeping_times", figure, [{key: row.get(key, float("nan")) for key in keys} for row in rows])


def percent(error: float) -> str:
    """An error as a cell of the map shows it."""
    if np.isnan(error):
        return "–"
    return "<0.1" if error < 1e-3 else f"{100 * error:.0f}" if error > 0.1 else f"{100 * error:.1f}"


def mapped() -> None:
    """Where accuracy is lost, and what speeds and creeps cost."""
    figure, axes = panels(4, height=3.6)
    rows = []
    names = ("within 1 %; 100 convolutions", "within 10 %; 300", "more", "fails, and says so")
    judgements = ((1.0, "resistance"), (10.0, "peak"))
    for place, (creep, what) in zip(axes, judgements, strict=False):
        errors = np.full((len(GRIDS), len(NUMBERS)), np.nan)
        for (j, i), _ in np.ndenumerate(errors):
            found = judged(cylinder(NUMBERS[i], creep), GRIDS[j])
            errors[j, i] = found.get(f"error_{what}", np.nan)
            rows.append({"creep": creep, "number": NUMBERS[i], "cells": GRIDS[j]} | found)
        codes = np.where(np.isnan(errors), 3, np.where(errors <= 0.01, 0, np.where(errors <= 0.1, 1, 2)))
        texts = np.array([[percent(error) for error in line] for line in errors])
        draw_verdicts(place, NUMBERS, GRIDS, codes, names=names, colours=COLOURS, texts=texts)
        place.set(xlabel="Deborah number", ylabel="cells in the relaxed contact")
        name = "resistance" if what == "resistance" else "peak pressure"
        place.set_title(f"error of the {name} [%], creep {creep:g}")
    for place, cells in zip(axes[2:], (40, 320), strict=True):
        counts = np.full((len(CREEPS), len(NUMBERS)), np.nan)
        for (j, i), _ in np.ndenumerate(counts):
            found = judged(cylinder(NUMBERS[i], CREEPS[j]), cells, method="fft", tolerance=1e-6)
            counts[j, i] = found.get("convolutions", np.nan)
            rows.append({"creep": CREEPS[j], "number": NUMBERS[i], "cells": cells, "tolerance": 1e-6} | found)
        codes = np.where(np.isnan(counts), 3, np.where(counts <= 100, 0, np.where(counts <= 300, 1, 2)))
        texts = np.array([["–" if np.isnan(n) else f"{n:.0f}" for n in line] for line in counts])
        draw_verdicts(place, NUMBERS, CREEPS, codes, names=names, colours=COLOURS, texts=texts)
        place.set(xlabel="Deborah number", ylabel="creep", title=f"convolutions of the FFT, {cells} cells")
    keys = list(dict.fromkeys(key for row in rows for key in row))
    write("creeping", figure, [{key: row.get(key, float("nan")) for key in keys} for row in rows])


if __name__ == "__main__":
    charted()
    mapped()
