# SPDX-License-Identifier: MIT OR Apache-2.0
"""What do derivatives cost beside what they are derivatives of?

Steps: six gradients (force and moment) by every gap, friction and load against the warm step itself: of a
shoe with fixed friction and with friction that changes from step to step, which turns so that points come
into contact and leave it at nearly every step, and of one that does not turn, whose points stay in contact.
Times are of the processor, the ratios of one run. Steady rolling: the products of one gradient against those
of a Newton step of the solve, in the mean and where it is solved to the same residual.
Writes docs/charts/derivatives_steps.csv, derivatives_rolling.csv and derivatives.png; `--draw` only draws the
picture again.
"""

from __future__ import annotations

import sys
import time
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
import records

import mtb_rs as mtb
from mtb_rs.half_space import reference

OUT = Path(__file__).parents[1] / "docs" / "charts"
TABLE = mtb.VelocityTable((0.0, 5.0, 15.0, 30.0, 45.0), (0.35, 0.24, 0.16, 0.12, 0.10))
#: Friction, and how far the shoe turns [rad].
FRICTION = {
    "fixed friction": (0.2, 2e-5),
    "changing friction": (TABLE, 2e-5),
    "fixed friction, same points": (0.2, 0.0),
}
#: Rows of the shoe along the track, for about 100 to 1000 contact points.
ROWS = (11, 16, 24, 32, 38)
STEPS = 80
CELLS = (25, 50, 100)
NUMBERS = ("spin_moment", "friction_power")


def steps() -> list[records.Record]:
    """Milliseconds of a warm step and of its gradients: medians over a ride, for each friction and size."""
    rows: list[records.Record] = []
    for along in ROWS:
        for name, (friction, turn) in FRICTION.items():
            scene = mtb.scenes.pole_shoe_on_rail(
                friction=friction, magnetic_pressure=2.5e6, spacing=(90e-3 / along, 55e-3 / along)
            )
            contact = scene.prepare("elastic-upper")
            taken, derived = [], []
            for k, velocity in enumerate(np.linspace(40.0, 2.0, STEPS)):
                pose = np.full(6, np.nan)
                pose[3:5] = turn * np.sin(k / 20.0), turn * np.cos(k / 30.0)
                pull = 2.5e6 * (1.0 + 0.1 * np.sin(k / 10.0))
                clock = time.process_time()
                step = contact.step(pose, velocity, magnetic_pressure=pull)
                between = time.process_time()
                by = step.gradient(["force", "moment"])
                for given in ("gap", "friction_field", "work"):
                    assert np.isfinite(by[given]).all()
                taken.append(between - clock)
                derived.append(time.process_time() - between)
            # the first steps make the factors
            step_ms, six_ms = (1e3 * float(np.median(times[5:])) for times in (taken, derived))
            rows.append(
                {
                    "points": contact.area.size,
                    "friction": name,
                    "step_ms": f"{step_ms:.3f}",
                    "six_gradients_ms": f"{six_ms:.3f}",
                    "ratio": f"{six_ms / step_ms:.2f}",
                }
            )
            print(rows[-1])
    return rows


def rolling() -> list[records.Record]:
    """Products of one gradient and of one Newton step on each grid."""
    body = mtb.Material.from_shear_modulus(82e9, 0.28)
    rows: list[records.Record] = []
    for n in CELLS:
        patch = reference.elliptic_pressure(1e4, (3.205e-3, 3.205e-3), (n, n), body, body)
        motion = mtb.Rolling(creepage=(4e-4, 3e-4, 0.2))
        result = mtb.solve_tangential(patch, motion, mtb.Coulomb(0.3))
        row: dict[str, object] = {
            "cells_per_axis": n,
            "products_a_newton_step": f"{result.report.convolutions / result.report.iterations:.1f}",
        }
        # the same matrix, solved as far as a gradient is: what a change of the friction does
        tangent = result._tangent()
        tangent.forward({"friction": np.ones(1)})
        row["newton_step_to_1e-11"] = tangent.products
        for of in NUMBERS:
            tangent = result._tangent()
            tangent.adjoint(result._functional(of, tangent).weights)
            row[of] = tangent.products
        rows.append(row)
        print(row)
    return rows


def draw() -> None:
    """The chart of both tables."""
    figure, (left, right) = plt.subplots(1, 2, figsize=(7.4, 3.4))
    of_steps, of_rolling = (records.read(OUT / f"derivatives_{name}.csv") for name in ("steps", "rolling"))
    for color, name in zip(("C0", "C1", "C2"), FRICTION, strict=True):
        found = [row for row in of_steps if row["friction"] == name]
        points = [int(row["points"]) for row in found]
        for key, line, label in (("step_ms", "o:", "step"), ("six_gradients_ms", "s-", "six gradients")):
            times = [float(row[key]) for row in found]
            left.loglog(points, times, line, color=color, label=f"{label}, {name}")
    left.set(xlabel="contact points", title="steps: processor time [ms]")
    left.set_xticks(points, [str(n) for n in points])
    left.set_yticks([0.2, 0.5, 1, 2, 5, 10, 20], ["0.2", "0.5", "1", "2", "5", "10", "20"])
    left.minorticks_off()
    place = np.arange(len(of_rolling))
    bars = {
        "products_a_newton_step": "one Newton step, inexact",
        "newton_step_to_1e-11": "one Newton step to 1e-11",
    }
    bars |= {name: "gradient of the " + name.replace("_", " ") for name in NUMBERS}
    for k, (key, label) in enumerate(bars.items()):
        values = [float(row[key]) for row in of_rolling]
        right.bar(place + 0.21 * (k - 1.5), values, 0.2, color=f"C{k + 3}", label=label)
    right.set_xticks(place, [row["cells_per_axis"] for row in of_rolling])
    right.set(xlabel="cells a side", title="steady rolling: products")
    right.grid(visible=False, axis="x")
    figure.legend(loc="outside lower center", ncols=2)
    figure.savefig(OUT / "derivatives.png")


if __name__ == "__main__":
    if sys.argv[1:] != ["--draw"]:
        records.write(OUT / "derivatives_steps.csv", steps())
        records.write(OUT / "derivatives_rolling.csv", rolling())
    draw()
