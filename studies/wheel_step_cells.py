# SPDX-License-Identifier: MIT OR Apache-2.0
"""What the cells of steps of wheels cost and give: errors of forces, peak pressure and heat over their size.

Usage: python studies/wheel_step_cells.py. Takes a minute. S1002 on 60E1 under 60 kN at 20 m/s, on the tread
and at the root of the flange, with both orders of rolling; the errors are the largest of some poses, against
second order on the finest cells, those of `wheel_on_rail` without a spacing. Times are those of a step that
follows another one, over that of first order on these cells.
"""

import time
import warnings

import numpy as np
from atlas import panels, write

import mtb_rs as mtb

SIZES = (1e-4, 2e-4, 3e-4, 5e-4, 7e-4, 1e-3)
FORCE, FRICTION, SPEED = 60e3, 0.3, 20.0
#: Lateral shift of the scene [m]; y [m] and yaw [rad] of the poses; colour.
PLACES = {
    "tread": (0.0, ((0.0, 1e-3), (1e-3, 2e-3), (2e-3, -1e-3), (4e-3, 3e-3)), "#0072B2"),
    "flange root": (6.2e-3, ((0.0, 1e-3), (0.0, 5e-3), (2e-4, -2e-3)), "#D55E00"),
}

warnings.simplefilter("ignore", UserWarning)
rows = []
figure, (left, right) = panels(2)
for name, (lateral, poses, colour) in PLACES.items():
    found, points, spent = {}, {}, {}
    for order in (2, 1):
        for size in SIZES:
            wheels = mtb.scenes.wheel_on_rail(lateral=lateral, force=FORCE, spacing=size).prepare(
                friction=mtb.Coulomb(FRICTION), order=order
            )
            own, count, times = [], [], []
            for y, yaw in poses:
                pose = np.array([0.0, y, np.nan, 0.0, 0.0, yaw])
                wheels.step(pose, SPEED)
                began = time.process_time()
                step = wheels.step(pose + 1e-6 * np.eye(6)[1], SPEED)
                times.append(time.process_time() - began)
                peak = max(float(patch.pressure.max()) for patch in step.patches)
                own.append([*step.force[:2] / (FRICTION * FORCE), peak, step.friction_power])
                count.append(sum(patch.pressure.size for patch in step.patches))
            found[order, size] = np.array(own)
            points[order, size], spent[order, size] = int(np.median(count)), float(np.median(times))
    truth, longest = found[2, SIZES[0]], spent[1, SIZES[0]]
    for order, size in found:
        own = found[order, size]
        peak, heat = (float(np.abs(own / truth - 1.0)[:, k].max()) for k in (2, 3))
        rows.append(
            {
                "place": name,
                "order": order,
                "spacing_mm": 1e3 * size,
                "points": points[order, size],
                # over that of the finest cells, as times by themselves are those of one machine
                "time": spent[order, size] / longest,
                "forces": float(np.abs(own - truth)[:, :2].max()),
                "peak": peak,
                "heat": heat,
            }
        )
    for order, line in ((1, "o-"), (2, "s--")):
        own_rows = [row for row in rows if (row["place"], row["order"]) == (name, order)]
        label = f"{name}, order {order}"
        # the finest cells of second order are the truth
        coarse = own_rows[order - 1 :]
        errors = [100 * row["forces"] for row in coarse]
        left.loglog([row["spacing_mm"] for row in coarse], errors, line, color=colour, label=label)
        right.loglog([row["time"] for row in coarse], errors, line, color=colour, label=label)
left.set(xlabel="cells [mm]", ylabel="error of forces [%]")
right.set(xlabel="time of a step, over that at 0.1 mm")
left.set_xticks([1e3 * size for size in SIZES], [f"{1e3 * size:g}" for size in SIZES])
left.set_xticks([], minor=True)
right.legend()
write("wheel_step_cells", figure, rows)
for row in rows:
    print(row)
