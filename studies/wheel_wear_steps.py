# SPDX-License-Identifier: MIT OR Apache-2.0
"""What the depth of an update means for the wear of wheel profiles: error over depth and solves.

Usage: python studies/wheel_wear_steps.py. Takes some minutes. Errors are those of the volume worn off after
20 000 km, against a depth that is a quarter of the finest one shown.
"""

import warnings

import numpy as np
from atlas import panels, write

import mtb_rs as mtb

DEPTHS = (8e-5, 4e-5, 2e-5, 1e-5)
DISTANCE, YAW = 2e7, 3e-4
SPREADS = ((2.5e-3, 41, "#0072B2"), (1.5e-3, 25, "#D55E00"))

warnings.simplefilter("ignore")
scene = mtb.scenes.wheel_on_rail("S1002", "60E1", lateral=0.0, force=60e3, spacing=1e-3)
rows = []
figure, (left, right) = panels(2)
for spread, count, colour in SPREADS:
    shifts = np.linspace(-2.0, 2.0, count) * spread
    shares = np.exp(-0.5 * (shifts / spread) ** 2)

    def worn(depth, shifts=shifts, shares=shares):
        return mtb.wear_of_wheels(
            scene,
            DISTANCE,
            mtb.Archard.of_hardness(1e-4, 2.7e9),
            shifts=shifts,
            shares=shares,
            yaw=YAW * (-1.0) ** np.arange(shifts.size),
            depth=depth,
            friction=mtb.Coulomb(0.3),
        )

    fine = worn(DEPTHS[-1] / 4.0)
    for depth in DEPTHS:
        rough = worn(depth)
        rows.append(
            {
                "spread_mm": 1e3 * spread,
                "depth_mm": 1e3 * depth,
                "updates": rough.distances.size - 1,
                "steps": (rough.distances.size - 1) * count,
                "volume_cm3": 1e6 * float(rough.wheel_volumes[-1]),
                "error": float(abs(rough.wheel_volumes[-1] / fine.wheel_volumes[-1] - 1.0)),
                "left_out": float(rough.left_out.max()),
            }
        )
    own = [row for row in rows if row["spread_mm"] == 1e3 * spread]
    errors = [100 * row["error"] for row in own]
    label = f"shifts spread by {1e3 * spread:g} mm"
    left.loglog([row["depth_mm"] for row in own], errors, "o-", color=colour, label=label)
    right.loglog([row["steps"] for row in own], errors, "o-", color=colour, label=label)
first = np.array(DEPTHS) * 1e3
left.loglog(first, 50.0 * first, "k:", lw=1, label="first order")
left.set(xlabel="depth of an update [mm]", ylabel="error of the worn volume [%]")
left.set_xticks([0.01, 0.02, 0.04, 0.08], ["0.01", "0.02", "0.04", "0.08"])
right.set(xlabel="steps of wheels solved", ylabel="error of the worn volume [%]")
right.set_xticks([100, 200, 400, 800], ["100", "200", "400", "800"])
for axes in (left, right):
    axes.set_ylim(0.08, 8.0)
    axes.set_yticks([0.1, 0.2, 0.5, 1.0, 2.0, 5.0], ["0.1", "0.2", "0.5", "1", "2", "5"])
    axes.minorticks_off()
    axes.legend(loc="upper left" if axes is left else "upper right")
write("wheel_wear_steps", figure, rows)
