# SPDX-License-Identifier: MIT OR Apache-2.0
"""What does an elastic pole shoe cost: once to condense, and then each frictional solve?

Poles of 100 x 30 x 70 mm of quadratic tetrahedra, 3 mm at the contact: one, and two of different loads that
share nothing; then one contact problem at 400 and at 1600 points, and the friction sweep of the thesis' Table
4.1. Counts do not depend on the machine. Processor seconds are of all threads together; beside the rate of
the condensation stands that of a dense product measured just before.
Writes docs/charts/condensation.csv, condensation_solves.csv and condensation.png; `--draw` only draws the
table again that is there.
"""

from __future__ import annotations

import csv
import os
import resource
import subprocess
import sys
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
import records

import mtb_rs as mtb
from mtb_rs.base import cache
from mtb_rs.contact.solve import solve_direct

OUT = Path(__file__).parents[1] / "docs" / "charts"
STAGES = ("ordering", "assembly", "symbolic", "numeric", "forward", "product")
SWEEP = (0.5, 0.4, 0.3, 0.2, 0.1, 0.05)
#: Seconds of the thesis for the six solves of Table 4.1.
THESIS_SWEEP = 4953.0
POLE = {"height": 70e-3, "length": 0.1, "supports": "points"}


def shoe(poles: int, spacing: float | tuple[float, float] = 3e-3) -> mtb.Scene:
    """Poles that are condensed one by one: off the symmetry plane none is the image of another."""
    return mtb.scenes.pole_shoe_on_rail(
        poles=poles, spacing=spacing, lateral=1e-9 if poles == 2 else 0.0, **POLE
    )


def dense_rate() -> float:
    """Operations per processor second of a dense product."""
    a = np.random.default_rng(0).random((1500, 1500))
    return 2 * 1500**3 / min(_processor_seconds(lambda: a @ a) for _ in range(5))


def _processor_seconds(call: Callable[[], object]) -> float:
    clock = time.process_time()
    call()
    return time.process_time() - clock


def condense(poles: int) -> dict[str, object]:
    """One condensation in this process: counts, breakdown, memory."""
    rate = dense_rate()
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024
    with cache.memory_only():
        shoe(1, 6e-3).problem("elastic-upper")  # threads and libraries are up
        clock, processor = time.perf_counter(), time.process_time()
        problem = shoe(poles).problem("elastic-upper")
        total, processor = time.perf_counter() - clock, time.process_time() - processor
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024
    costs = []
    for part in problem.upper.state:
        costs.append(part.body.condense(part.sampling()).cost)
    added = {k: sum(cost[k] for cost in costs) for k in costs[0]}
    flops = added["factor_flops"] + added["forward_flops"] + added["product_flops"]
    return {
        "case": f"{poles} pole{'s' if poles > 1 else ''}",
        "contact_points": problem.n,
        "unknowns": int(added["unknowns"]),
        "factor_nonzeros": int(added["factor_entries"]),
        "factor_gflop": f"{1e-9 * added['factor_flops']:.1f}",
        "forward_gflop": f"{1e-9 * added['forward_flops']:.1f}",
        "product_gflop": f"{1e-9 * added['product_flops']:.1f}",
        **{f"{stage}_s": f"{added[f'{stage}_s']:.2f}" for stage in STAGES},
        "total_s": f"{total:.2f}",
        "processor_s": f"{processor:.2f}",
        "gflop_per_s": f"{1e-9 * flops / processor:.1f}",
        "dense_gflop_per_s": f"{1e-9 * rate:.1f}",
        "factor_mb": f"{8e-6 * added['factor_entries']:.0f}",
        "peak_memory_mb": f"{1e-6 * (peak - before):.0f}",
    }


def solves() -> list[dict[str, object]]:
    """Frictional solves on kept condensations."""
    rows: list[dict[str, object]] = []
    for wanted, spacing in ((400, (0.1 / 49, 15.6e-3 / 7)), (1600, (0.1 / 99, 15.6e-3 / 15))):
        scene = shoe(1, spacing).with_(element_size=4e-3, supports="driven-top")
        problem = scene.problem("elastic-upper")
        seconds = min(_processor_seconds(partial(solve_direct, problem)) for _ in range(5))
        rows.append(
            {"case": f"solve, {wanted} points", "contact_points": problem.n, "processor_s": f"{seconds:.3f}"}
        )
    scenes = [shoe(2).with_(friction=friction) for friction in SWEEP]
    points = scenes[0].solve(model="elastic-upper").pressure.size
    sweep = min(_processor_seconds(partial(_solve_all, scenes)) for _ in range(3))
    rows.append({"case": "sweep of Table 4.1", "contact_points": points, "processor_s": f"{sweep:.3f}"})
    rows[-1]["times_the_thesis"] = f"{THESIS_SWEEP / sweep:.0f}"
    return rows


def _solve_all(scenes: list[mtb.Scene]) -> None:
    for scene in scenes:
        scene.solve(model="elastic-upper")


def main() -> None:
    """Runs every case in a process of its own; writes the table and the chart."""
    if sys.argv[1:] == ["--draw"]:
        draw(records.read(OUT / "condensation.csv"))
        return
    if len(sys.argv) > 1:
        row = condense(int(sys.argv[1]))
        writer = csv.DictWriter(sys.stdout, row)
        writer.writeheader()
        writer.writerow(row)
        return
    rows: list[dict[str, object]] = []
    for poles in (1, 2):
        run = subprocess.run(
            [sys.executable, __file__, str(poles)],
            capture_output=True,
            text=True,
            check=True,
            env=os.environ | {cache.VARIABLE: "off"},
        )
        rows.extend(csv.DictReader(run.stdout.splitlines()))
        print(rows[-1])
    with cache.memory_only():
        others = solves()
    for row in others:
        row.setdefault("times_the_thesis", "")
        print(row)
    records.write(OUT / "condensation.csv", rows)
    records.write(OUT / "condensation_solves.csv", others)
    draw(records.read(OUT / "condensation.csv"))


def draw(rows: list[dict[str, str]]) -> None:
    """Where the time of a condensation goes."""
    figure, axes = plt.subplots(figsize=(7.4, 2.4))
    left = np.zeros(len(rows))
    for stage in STAGES:
        seconds = np.array([float(row[f"{stage}_s"]) for row in rows])
        axes.barh([row["case"] for row in rows], seconds, left=left, label=stage)
        left += seconds
    axes.set(xlabel="elapsed time of a condensation [s]")
    axes.grid(visible=False, axis="y")
    axes.invert_yaxis()
    figure.legend(ncols=6, loc="outside upper center", columnspacing=1.0, handlelength=1.2)
    figure.savefig(OUT / "condensation.png")


if __name__ == "__main__":
    main()
