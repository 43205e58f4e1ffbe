# SPDX-License-Identifier: MIT OR Apache-2.0
"""What the steps of heat and of thermoelastic contact mean: error of temperature and pressure over their
number.

Usage: python studies/heat_steps.py. Takes some minutes. A pole shoe slides for four seconds at 10 m/s, with
wear where it expands; errors are root mean squares over the contact, against 2048 equal steps.
"""

import warnings

import numpy as np
from atlas import panels, write

import mtb_rs as mtb

COUNTS = (8, 16, 32, 64, 128, 256)
FINE = 2048
TOLERANCES = (0.4, 0.2, 0.1, 0.05)
DURATION, VELOCITY, WEAR = 4.0, 10.0, 1e-12

warnings.simplefilter("ignore")  # that steps are too long is what is measured
shoe = mtb.scenes.pole_shoe_on_rail(friction=0.12, magnetic_pressure=2.5e6, spacing=6e-3)


def heated(steps: int, *, expansion: bool, tolerance: float | None = None) -> mtb.SlidingHeat:
    """With `expansion` the sole wears as well; without either the pressure does not change."""
    wear = WEAR if expansion else None
    return shoe.sliding_heat(
        DURATION, steps, VELOCITY, expansion=expansion, wear=wear, tolerance=tolerance, model="elastic-upper"
    )


def apart(one: np.ndarray, other: np.ndarray) -> float:
    return float(np.linalg.norm(one - other) / np.linalg.norm(other))


rows = []
figure, axes = panels(2)
for place, expansion in zip(axes, (False, True), strict=True):
    fine = heated(FINE, expansion=expansion)
    runs = [("equal steps", heated(n, expansion=expansion)) for n in COUNTS]
    runs += [("tolerance", heated(4, expansion=expansion, tolerance=t)) for t in TOLERANCES]
    for kind, found in runs:
        row = {"expansion": expansion, "steps_by": kind, "steps": len(found.time)}
        row["error_temperature"] = apart(found.temperatures[-1], fine.temperatures[-1])
        # without expansion it is the same in all
        row["error_pressure"] = apart(found.pressures[-1], fine.pressures[-1]) if expansion else np.nan
        rows.append(row)
    for kind, line in (("equal steps", "-"), ("tolerance", "--")):
        own = [row for row in rows if row["expansion"] == expansion and row["steps_by"] == kind]
        for quantity, colour in (("temperature", "#D55E00"), ("pressure", "#0072B2")):
            if expansion or quantity == "temperature":
                shown = [100 * row[f"error_{quantity}"] for row in own]
                steps = [row["steps"] for row in own]
                label = f"{quantity}, " + ("equal steps" if kind == "equal steps" else "steps by tolerance")
                place.loglog(steps, shown, "o" + line, color=colour, label=label)
    place.loglog(COUNTS, 0.2 * COUNTS[0] / np.array(COUNTS), "k:", lw=1, label="first order")
    place.set(xlabel="steps", ylabel="error after 4 s [%]")
    place.set_title("heat, expansion and wear" if expansion else "heat alone")
    place.set_ylim(5e-4, 5.0)
    place.legend(fontsize=7, loc="upper right")
for place in axes:
    place.set_xticks([10, 20, 50, 100, 200], ["10", "20", "50", "100", "200"])
    place.set_xticks([], minor=True)
write("heat_steps", figure, rows)
