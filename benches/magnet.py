# SPDX-License-Identifier: MIT OR Apache-2.0
"""What does a magnet whose pull follows the gap cost beside a number?

A pole shoe is held at heights above the rail, pitched by a milliradian, so that the gap below it changes
from end to end. Steps of the prepared contact with a number, the pull of the same magnet at rest on the rail,
and with the magnet itself, on meshes of several sizes. Errors are those of the pull against the magnet on the
finest mesh, times those of the processor: medians over the steps at a height that changes a little from step
to step. Writes docs/charts/magnet.csv and .png; `--draw` only draws the picture again.
"""

from __future__ import annotations

import sys
import time
from pathlib import Path
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
import records

import mtb_rs as mtb

OUT = Path(__file__).parents[1] / "docs" / "charts"
MAGNET = mtb.Magnet(3000.0, 1e-3, iron_share=30 / 15.6, yoke=(0.15, 3e-3), armature=(60e-3, 3e-3))
SPACINGS = (12e-3, 9e-3, 6e-3, 4.5e-3, 3e-3)
#: Heights of the middle of the shoe [m], and its pitch.
HEIGHTS, PITCH = (0.1e-3, 0.3e-3, 1e-3, 3e-3), 1e-3
STEPS = 60


def rows() -> list[dict[str, Any]]:
    found = []
    for spacing in SPACINGS:
        scene = mtb.scenes.pole_shoe_on_rail(friction=0.2, magnetic_pressure=MAGNET, spacing=spacing)
        contact = scene.prepare(model="elastic-upper")
        at_rest = contact.step()
        number = at_rest.report.magnet["attraction"] / float(contact.area.sum())
        fixed = scene.with_(magnetic_pressure=number).prepare(model="elastic-upper")
        for height in HEIGHTS:
            for pull, prepared in (("number", fixed), ("magnet", contact)):
                times, states = [], []
                for k in range(STEPS):
                    pose = [0.0, 0.0, height * (1.0 + 1e-3 * np.sin(k)), 0.0, PITCH, 0.0]
                    clock = time.process_time()
                    step = prepared.step(pose=pose)
                    times.append(time.process_time() - clock)
                    states.append(step.report.magnet["solves"] if pull == "magnet" else 1)
                last = prepared.step(pose=[0.0, 0.0, height, 0.0, PITCH, 0.0])
                attraction = (
                    last.report.magnet["attraction"]
                    if pull == "magnet"
                    else number * float(contact.area.sum())
                )
                found.append(
                    {
                        "spacing_mm": 1e3 * spacing,
                        "points": contact.area.size,
                        "height_mm": 1e3 * height,
                        "pull": pull,
                        "step_ms": round(1e3 * float(np.median(times[5:])), 4),
                        "states": round(float(np.mean(states[5:])), 2),
                        "attraction_N": round(attraction, 3),
                    }
                )
    for row in found:
        (truth,) = (
            r["attraction_N"]
            for r in found
            if r["pull"] == "magnet"
            and r["spacing_mm"] == 1e3 * SPACINGS[-1]
            and r["height_mm"] == row["height_mm"]
        )
        row["error"] = f"{abs(row['attraction_N'] / truth - 1.0):.3g}"
    return found


def draw(table: list[dict[str, str]]) -> None:
    figure, (accuracy, cost) = plt.subplots(1, 2, figsize=(7.4, 3.8))
    for height, colour in zip(HEIGHTS, ("#0072B2", "#D55E00", "#009E73", "#CC79A7"), strict=True):
        for pull, line in (("number", "s:"), ("magnet", "o-")):
            own = [
                row
                for row in table
                if row["pull"] == pull and np.isclose(float(row["height_mm"]), 1e3 * height)
            ]
            shown = [row for row in own if float(row["error"]) > 0.0]
            label = f"at {1e3 * height:g} mm" if pull == "magnet" else None
            accuracy.loglog(
                [float(row["step_ms"]) for row in shown],
                [100.0 * float(row["error"]) for row in shown],
                line, color=colour, label=label,
            )  # fmt: skip
            points = [float(row["points"]) for row in own]
            cost.loglog(points, [float(row["step_ms"]) for row in own], line, color=colour)
    accuracy.plot([], [], "s:", color="#777777", label="a number in its place")
    accuracy.set_xticks([0.3, 1.0, 3.0], ["0.3", "1", "3"])
    accuracy.set_yticks([0.01, 0.1, 1.0, 10.0, 100.0, 1000.0], ["0.01", "0.1", "1", "10", "100", "1000"])
    cost.set_xticks([40, 100, 200, 400], ["40", "100", "200", "400"])
    cost.set_yticks([0.3, 1.0, 3.0, 10.0], ["0.3", "1", "3", "10"])
    for axes in (accuracy, cost):
        axes.minorticks_off()
    accuracy.set(xlabel="processor time of a step [ms]", ylabel="error of the pull [%]")
    cost.set(xlabel="contact points", ylabel="processor time of a step [ms]")
    figure.legend(*accuracy.get_legend_handles_labels(), loc="outside lower center", ncols=5)
    figure.savefig(OUT / "magnet.png")


if __name__ == "__main__":
    if "--draw" not in sys.argv:
        records.write(OUT / "magnet.csv", rows())
    draw(records.read(OUT / "magnet.csv"))
