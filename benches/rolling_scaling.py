# SPDX-License-Identifier: MIT OR Apache-2.0
"""Cost of rolling and shifts over the number of cells: iterations, products, seconds (CSV and PNG)."""

import argparse
import time
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
import records

import mtb_rs as mtb
from mtb_rs.base.files import output_folder
from mtb_rs.half_space import reference

parser = argparse.ArgumentParser(description=__doc__)
parser.add_argument("-o", "--output", type=output_folder, default="docs/charts")
parser.add_argument("--sizes", type=int, nargs="+", default=[25, 50, 100, 200])
parser.add_argument("--repeats", type=int, default=5, help="the least time of these is taken")
parser.add_argument("--draw", action="store_true", help="only draw the table again that is there")
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


def run() -> list[dict[str, object]]:
    """Every case on every grid."""
    rows: list[dict[str, object]] = []
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
    return rows


def draw(rows: list[dict[str, str]], path: Path) -> None:
    """Seconds and Newton steps over the cells a side."""
    figure, (seconds, steps) = plt.subplots(2, 1, figsize=(7.4, 7.4), height_ratios=(2, 1))
    sizes = np.unique([int(row["cells_per_axis"]) for row in rows])
    rolling = [name for name in cases if name != "shift"]
    found = {name: [row for row in rows if row["case"] == name] for name in cases}
    taken = np.array([[float(row["least_cpu_s"]) for row in found[name]] for name in rolling])
    seconds.fill_between(sizes, taken.min(axis=0), taken.max(axis=0), alpha=0.3, lw=0)
    seconds.loglog(sizes, np.median(taken, axis=0), "o-", label=f"steady rolling, {len(rolling)} cases")
    seconds.loglog(sizes, [float(row["least_cpu_s"]) for row in found["shift"]], "^-", label="shift")
    for place, name in enumerate(cases):
        at = np.arange(sizes.size) + (place - 0.5 * (len(cases) - 1)) * 0.8 / len(cases)
        count = [int(row["newton_steps_finest"]) for row in found[name]]
        steps.bar(at, count, width=0.7 / len(cases), label=name)
    scale = 0.1 / (100.0**2 * np.log(100.0))
    seconds.loglog(sizes, scale * sizes**2 * np.log(sizes), "--", color="#777777", lw=1, label="n² log n")
    # own runs of CONTACT (its default solvers), see tests/data/contact
    paler = {"ls": ":", "color": "#777777"}
    seconds.loglog([25, 50, 100], [0.041, 0.93, 24.7], "s", **paler, label="CONTACT, steady rolling")
    seconds.loglog([25, 50, 100, 200], [0.0065, 0.030, 0.58, 4.1], "d", **paler, label="CONTACT, shift")
    seconds.set(title="processor time [s]", xlabel="cells a side")
    seconds.set_xticks(sizes, [str(n) for n in sizes])
    seconds.minorticks_off()
    seconds.legend()
    steps.set(xlabel="cells a side", title="Newton steps on the finest grid")
    steps.set_xticks(range(sizes.size), [str(n) for n in sizes])
    steps.grid(visible=False, axis="x")
    figure.legend(*steps.get_legend_handles_labels(), loc="outside lower center", ncols=3)
    figure.savefig(path)


if __name__ == "__main__":
    table = arguments.output / "rolling_scaling.csv"
    if not arguments.draw:
        records.write(table, run())
    draw(records.read(table), table.with_suffix(".png"))
