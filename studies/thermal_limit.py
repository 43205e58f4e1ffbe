# SPDX-License-Identifier: MIT OR Apache-2.0
"""Thermal limit over speed and friction: heat of a pole shoe over that at which uneven pressure grows.

Usage: python studies/thermal_limit.py. Takes about a minute. Beside it the table has the same ratio of a
steel half-plane on a rigid insulator, for waves as long as the shoe: V = 2 m K (1 - nu) / (mu alpha E)
(docs/theory.md).
"""

import warnings

import matplotlib.pyplot as plt
import numpy as np
from atlas import panels, write
from matplotlib.colors import LogNorm

import mtb_rs as mtb

SPEEDS = np.array([0.01, 0.03, 0.1, 0.3, 1.0, 3.0, 10.0, 44.0])
FRICTIONS = np.array([0.05, 0.1, 0.2, 0.3, 0.5])
DURATIONS = (0.1, 30.0)
#: Steps of a run, and a coefficient of wear [1/Pa] that keeps the pressure even. The margin needs neither.
STEPS, WEAR = 40, 1e-12

warnings.simplefilter("ignore")  # the steps serve the margin alone
shoe = mtb.scenes.pole_shoe_on_rail(magnetic_pressure=2.5e6, spacing=8e-3)
#: Speed times friction at the limit of a steel half-plane on a rigid insulator, for waves of 0.1 m.
LIMIT = 4 * np.pi / 0.1 * mtb.conducting_steel.conductivity * (1 - mtb.steel.poisson_ratio)
LIMIT /= mtb.conducting_steel.expansion * mtb.steel.young_modulus
rows = []
figure, axes = panels(2, height=3.0)
for place, duration in zip(axes, DURATIONS, strict=True):
    margins = np.full((len(FRICTIONS), len(SPEEDS)), np.nan)
    for (j, i), _ in np.ndenumerate(margins):
        scene = shoe.with_(friction=float(FRICTIONS[j]))
        try:
            found = scene.sliding_heat(
                duration, STEPS, float(SPEEDS[i]), expansion=True, wear=WEAR, model="elastic-upper"
            )
            margins[j, i] = found.thermal_margin or np.nan
        except mtb.ConvergenceError as error:
            print(f"{duration} s, {SPEEDS[i]} m/s, friction {FRICTIONS[j]}: {error}")
        rows.append(
            {
                "duration_s": duration,
                "velocity_m_s": SPEEDS[i],
                "friction": FRICTIONS[j],
                "thermal_margin": margins[j, i],
                "closed_form": SPEEDS[i] * FRICTIONS[j] / LIMIT,
            }
        )
    drawn = place.imshow(margins, norm=LogNorm(1e-2, 1e2), cmap="viridis", origin="lower", aspect="auto")
    for (j, i), value in np.ndenumerate(margins):
        ink = "black" if value > 3.0 else "white"
        weight = "bold" if value > 1.0 else "normal"
        text = f"{value:.0f}" if value >= 10.0 else f"{value:.2g}"
        place.text(i, j, text, ha="center", va="center", fontsize=7, color=ink, weight=weight)
    place.set_xticks(range(len(SPEEDS)), [f"{v:g}" for v in SPEEDS])
    place.set_yticks(range(len(FRICTIONS)), [f"{v:g}" for v in FRICTIONS])
    place.set(xlabel="sliding velocity [m/s]", ylabel="friction coefficient")
    place.set_title(f"over {duration:g} s")
    place.grid(visible=False)
bar = plt.colorbar(drawn, ax=axes)
bar.set_label("heat over its thermal limit")
write("thermal_limit", figure, rows)
