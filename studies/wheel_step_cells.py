# SPDX-License-Identifier: MIT OR Apache-2.0
"""What the cells of steps of wheels cost and give: errors of forces, peak pressure and heat over their size.

Usage: python studies/wheel_step_cells.py. Takes a minute. S1002 on 60E1 under 60 kN at 20 m/s, on the tread
and at the root of the flange; the errors are the largest of some poses, against the finest cells, those of
`wheel_on_rail` without a spacing. Times are those of a step that follows another one, over that on these
cells.
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
    fine = None
    for size in SIZES:
        wheels = mtb.scenes.wheel_on_rail(lateral=lateral, force=FORCE, spacing=size).prepare(
            friction=mtb.Coulomb(FRICTION)
        )
        found, points, spent = [], [], []
        for y, yaw in poses:
            pose = np.array([0.0, y, np.nan, 0.0, 0.0, yaw])
            wheels.step(pose, SPEED)
            began = time.process_time()
            step = wheels.step(pose + 1e-6 * np.eye(6)[1], SPEED)
            spent.append(time.process_time() - began)
            peak = max(float(patch.pressure.max()) for patch in step.patches)
            found.append([*step.force[:2] / (FRICTION * FORCE), peak, step.friction_power])
            points.append(sum(patch.pressure.size for patch in step.patches))
        own = np.array(found)
        fine = own if fine is None else fine
        forces = float(np.abs(own - fine)[:, :2].max())
        peak, heat = (float(np.abs(own / fine - 1.0)[:, k].max()) for k in (2, 3))
        rows.append(
            {
                "place": name,
                "spacing_mm": 1e3 * size,
                "points": int(np.median(points)),
                "time": float(np.median(spent)),
                "forces": forces,
                "peak": peak,
                "heat": heat,
            }
        )
    own_rows = [row for row in rows if row["place"] == name]
    # over that of the finest cells, as times by themselves are those of one machine
    longest = own_rows[0]["time"]
    for row in own_rows:
        row["time"] /= longest
    coarse = own_rows[1:]
    sizes = [row["spacing_mm"] for row in coarse]
    left.loglog(sizes, [100 * row["forces"] for row in coarse], "o-", color=colour, label=f"{name}: forces")
    left.loglog(sizes, [100 * row["peak"] for row in coarse], "s--", color=colour, label=f"{name}: peak")
    right.loglog(
        [row["spacing_mm"] for row in own_rows],
        [row["time"] for row in own_rows],
        "o-",
        color=colour,
        label=name,
    )
left.set(xlabel="cells [mm]", ylabel="error [%]")
right.set(xlabel="cells [mm]", ylabel="time of a step, over that at 0.1 mm")
for axes in (left, right):
    axes.set_xticks([1e3 * size for size in SIZES], [f"{1e3 * size:g}" for size in SIZES])
    axes.set_xticks([], minor=True)
    axes.legend()
write("wheel_step_cells", figure, rows)
