# SPDX-License-Identifier: MIT OR Apache-2.0
"""What the tolerance of the steps of wear means: error of the depths of a pole shoe over tolerance and steps.

Usage: python studies/wear_steps.py. Takes some minutes. Errors are root mean squares over the sole, against a
tolerance that is ten times finer than the finest one shown.
"""

import warnings

import numpy as np
from atlas import panels, write

import mtb_rs as mtb

TOLERANCES = (0.2, 0.1, 0.05, 0.02, 0.01, 0.005)
#: Tolerance of the reference; coefficient of wear [1/Pa].
FINE, WEAR = 5e-4, 1e-13
DISTANCES = ((0.05, "#0072B2"), (5.0, "#D55E00"))

warnings.simplefilter("ignore", mtb.ToleranceWarning)
shoe = mtb.scenes.pole_shoe_on_rail(spacing=4e-3)
rows = []
figure, (left, right) = panels(2)
for distance, colour in DISTANCES:
    fine = mtb.wear(shoe, distance, WEAR, model="elastic-both", tolerance=FINE)
    size = fine.area @ fine.depths[0, -1] ** 2
    for tolerance in TOLERANCES:
        rough = mtb.wear(shoe, distance, WEAR, model="elastic-both", tolerance=tolerance)
        error = np.sqrt(fine.area @ (rough.depths[0, -1] - fine.depths[0, -1]) ** 2 / size)
        rows.append(
            {
                "distance_m": distance,
                "tolerance": tolerance,
                "steps": len(rough.steps) - 1,
                "solves": int(rough.solves.sum()),
                "error": float(error),
            }
        )
    own = [row for row in rows if row["distance_m"] == distance]
    errors = [100 * row["error"] for row in own]
    label = f"worn over {distance:g} m"
    left.loglog([row["tolerance"] for row in own], errors, "o-", color=colour, label=label)
    right.loglog([row["solves"] for row in own], errors, "o-", color=colour, label=label)
left.loglog(TOLERANCES, 100 * np.array(TOLERANCES), "k:", lw=1, label="error = tolerance")
left.set(xlabel="tolerance", ylabel="error of the worn depth [%]")
right.set(xlabel="contact problems solved", ylabel="error of the worn depth [%]")
right.set_xticks([10, 20, 50], ["10", "20", "50"])
right.set_xticks([], minor=True)
right.set_yticks([0.2, 0.5, 1.0, 2.0], ["0.2", "0.5", "1", "2"])
right.set_yticks([], minor=True)
for axes in (left, right):
    axes.legend()
write("wear_steps", figure, rows)
