# SPDX-License-Identifier: MIT OR Apache-2.0
"""Cost of rolling and shifts over the number of cells: iterations, products, seconds (CSV and PNG)."""

import argparse
import csv
import time
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

import mtb_rs as mtb
from mtb_rs import reference

parser = argparse.ArgumentParser(description=__doc__)
parser.add_argument("-o", "--output", type=Path, default=Path("docs/charts"))
parser.add_argument("--sizes", type=int, nargs="+", default=[25, 50, 100, 200])
parser.add_argument("--repeats", type=int, default=5, help="the least time of these is taken")
arguments = parser.parse_args()

body = mtb.Material.from_shear_modulus(82e9, 0.28)
law = mtb.Coulomb(0.3)
cases = {
    "rolling, longitudinal": mtb.Rolling(creepage=(5e-4, 0.0, 0.0)),
    "rolling, lateral": mtb.Rolling(creepage=(0.0, 5e-4, 0.0)),
    "rolling, spin": mtb.Rolling(creepage=(0.0, 0.0, 0.3)),
    "rolling, combined": mtb.Rolling(creepage=(4e-4, 3e-4, 0.2)),
    "shift": mtb.Shift(displacement=(3e-6, 0.0)),
    "rolling, force 0.9 of the limit": mtb.Rolling(force=(2700.0, None)),
}
rows = []
for n in arguments.sizes:
    patch = reference.elliptic_pressure(1e4, (3.205e-3, 3.205e-3), (n, n), body, body)
    for name, motion in cases.items():
        wall, processor = [], []
        for _ in range(1 + (arguments.repeats if n <= 100 else 1)):
            started, used = time.perf_counter(), time.process_time()
            found = mtb.solve_tangential(patch, motion, law)
            wall.append(time.perf_counter() - started)
            processor.append(time.process_time() - used)
        report = found.report
        rows.append(
            {
                "cells_per_axis": n,
                "case": name,
                "newton_steps_finest": report.iterations,
                "products": round(report.convolutions, 1),
                "preconditionings": round(report.preconditionings, 1),
                # the first run also makes the operators
                "first_wall_s": round(wall[0], 5),
                "least_wall_s": round(min(wall[1:]), 5),
                "least_cpu_s": round(min(processor[1:]), 5),
                "force_x_n": round(float(found.force[0]), 4),
                "force_y_n": round(float(found.force[1]), 4),
            }
        )
        print(rows[-1])
arguments.output.mkdir(parents=True, exist_ok=True)
with open(arguments.output / "rolling_scaling.csv", "w", newline="", encoding="utf-8") as file:
    writer = csv.DictWriter(file, fieldnames=list(rows[0]))
    writer.writeheader()
    writer.writerows(rows)

figure, (left, right) = plt.subplots(1, 2, figsize=(12, 4.6), constrained_layout=True)
for name in cases:
    own = [row for row in rows if row["case"] == name]
    sizes = np.array([row["cells_per_axis"] for row in own])
    left.plot(sizes, [row["newton_steps_finest"] for row in own], "o-", label=name)
    right.loglog(sizes, [row["least_cpu_s"] for row in own], "o-", label=name)
sizes = np.array(arguments.sizes, dtype=float)
scale = 0.1 / (100.0**2 * np.log(100.0))
right.loglog(sizes, scale * sizes**2 * np.log(sizes), "k--", lw=1, label="N log N")
#: own runs of CONTACT (its default solvers), see tests/data/contact
right.loglog([25, 50, 100], [0.041, 0.93, 24.7], "s:", color="grey", label="CONTACT, steady rolling")
right.loglog([25, 50, 100, 200], [0.0065, 0.030, 0.58, 4.1], "d:", color="silver", label="CONTACT, shift")
left.set(xlabel="cells per axis", ylabel="Newton steps on the finest grid", ylim=(0, 12), xscale="log")
right.set(xlabel="cells per axis", ylabel="processor time [s]")
right.legend(fontsize=7)
figure.savefig(arguments.output / "rolling_scaling.png", dpi=130)
