# SPDX-License-Identifier: MIT OR Apache-2.0
"""What the tolerance of the steps of wear means: steps, and error of the depths of a pole shoe.

Usage: python studies/wear_steps.py. Takes some seconds. The figures are in the table of docs/failures.md.
"""

import warnings

import numpy as np

import mtb_rs as mtb

#: Tolerance of the reference, m/m per Pa.
FINE, WEAR = 5e-4, 1e-13

warnings.simplefilter("ignore", mtb.ToleranceWarning)
shoe = mtb.scenes.pole_shoe_on_rail(spacing=4e-3)
for distance in (0.05, 5.0):
    fine = mtb.wear(shoe, distance, WEAR, model="elastic-both", tolerance=FINE)
    size = fine.area @ fine.depths[0, -1] ** 2
    for tolerance in (0.05, 0.02, 0.01):
        rough = mtb.wear(shoe, distance, WEAR, model="elastic-both", tolerance=tolerance)
        error = np.sqrt(fine.area @ (rough.depths[0, -1] - fine.depths[0, -1]) ** 2 / size)
        print(f"{distance} m, tolerance {tolerance}: {len(rough.steps) - 1} steps, {100 * error:.2f} % off")
