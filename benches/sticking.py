# SPDX-License-Identifier: MIT OR Apache-2.0
"""How long does a step take in which points stick and slip?

Rides of a shoe with 400 contact points that is pushed to and fro: by a little, so that most points stick;
until it slides, and back; round a circle, so that the slip turns; by shifts of random length and direction,
under a load that stays and one that changes; and in steady sliding, beside the step without a shift. Times
are of the processor, so that other programs do not count; beside them stand the Newton steps and how many
points stick and slip. Writes docs/charts/sticking.csv.
"""

from __future__ import annotations

import argparse
import time
from pathlib import Path

import numpy as np
import records

import mtb_rs as mtb

OUT = Path(__file__).parents[1] / "docs" / "charts"
STEPS = 200


def rides() -> dict[str, list[dict[str, object]]]:
    """Arguments of each step."""
    turn = 2.0 * np.pi * np.arange(STEPS) / 50.0
    circle = 1e-7 * np.array([-np.sin(turn), np.cos(turn)]).T
    random = np.random.default_rng(7)
    length = random.uniform(0.05e-6, 0.3e-6, STEPS)
    angle = random.uniform(0.0, 2.0 * np.pi, STEPS)
    walk = (length * np.array([np.cos(angle), np.sin(angle)])).T
    pull = 3e6 * (1.0 + 0.4 * np.sin(2.0 * np.pi * np.arange(STEPS) / 37.0))
    return {
        "to and fro by 0.2 µm": [{"shift": 0.025e-6 * np.cos(t)} for t in turn],
        "to and fro by 1.5 µm": [{"shift": 0.19e-6 * np.cos(t)} for t in turn],
        "round a circle of 0.8 µm": [{"shift": tuple(shift)} for shift in circle],
        "random walk": [{"shift": tuple(shift)} for shift in walk],
        "random walk, load ± 40 %": [
            {"shift": tuple(shift), "magnetic_pressure": float(p)}
            for shift, p in zip(walk, pull, strict=True)
        ],
        "steady sliding": [{"shift": 20e-6}] * STEPS,
        "steady sliding, no shift": [{}] * STEPS,
    }


def main() -> None:
    """Times the rides, and writes the table."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("-o", "--output", type=Path, default=OUT / "sticking.csv")
    chosen = parser.parse_args()
    contact = mtb.scenes.pole_shoe_on_rail(
        friction=0.3, magnetic_pressure=3e6, spacing=(90e-3 / 24, 2.3e-3)
    ).prepare("elastic-upper")
    contact.step(shift=0.0)
    rows = []
    for name, ride in rides().items():
        own = contact.copy()
        times, newton, stuck, slipping = [], [], [], []
        for given in ride:
            clock = time.process_time()
            out = own.step(**given)
            times.append(time.process_time() - clock)
            newton.append(out.report.iterations)
            stuck.append(np.count_nonzero(out.status == 1))
            slipping.append(np.count_nonzero(out.status == 2))
        ms = 1e3 * np.array(times)
        rows.append(
            {"ride": name, "points": contact.area.size, "steps": len(ms)}
            | {f"p{q}_ms": f"{np.percentile(ms, q):.2f}" for q in (50, 90, 99)}
            | {"newton_steps": f"{np.mean(newton):.2f}"}
            | {"stick": f"{np.mean(stuck):.0f}", "slip": f"{np.mean(slipping):.0f}"}
        )
        print(rows[-1])
    records.write(chosen.output, rows)


if __name__ == "__main__":
    main()
