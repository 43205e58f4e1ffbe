# SPDX-License-Identifier: MIT OR Apache-2.0
"""What slices cost: milliseconds of a step of wheels on plain profiles, and times as long with slices.

Rides of 60 steps under the load of a scene, S1002 on 60E1, cells of 1 mm, with swaying wheels; the rail sinks
and widens along the track, the wheel is out of round. Medians, of one thread with RAYON_NUM_THREADS=1.
"""

import time
import warnings

import numpy as np

import mtb_rs as mtb

warnings.simplefilter("ignore")
places, y = np.linspace(0.0, 0.6, 13), np.linspace(-0.034, 0.034, 681)
nominal = mtb.Profile.standard("60E1")
sections = [
    mtb.Profile.from_points(
        y, nominal.height(y + 5e-4 * np.cos(6.0 * s)) - 2e-4 * np.sin(8.0 * s) - 0.3 * s * y * y
    )
    for s in places
]
rail = mtb.RailSlices(places, sections, nominal="60E1")
angles = 2.0 * np.pi * np.arange(24) / 24
wheel = mtb.WheelSlices.out_of_round("S1002", angles, 3e-4 * np.sin(3.0 * angles))
for side in ("left", "both"):
    plain = 0.0
    for name, (upper, lower) in (
        ("plain profiles", ("S1002", "60E1")),
        ("a rail with slices", ("S1002", rail)),
        ("a wheel with slices", (wheel, "60E1")),
        ("both with slices", (wheel, rail)),
    ):
        scene = mtb.scenes.wheel_on_rail(upper, lower, force=6e4, lateral=0.0, spacing=1e-3)
        wheels, roll, times = scene.prepare(side=side, friction=0.3), np.nan if side == "both" else 0.0, []
        for k in range(60):
            x = 0.1 + 4e-3 * k
            pose = (x, 1e-3 * np.sin(20.0 * x), np.nan, roll, x / 0.46, 1e-3 * np.cos(20.0 * x))
            started = time.perf_counter()
            wheels.step(pose, 20.0)
            times.append(time.perf_counter() - started)
        median = 1e3 * float(np.median(times[5:]))
        plain = plain or median
        print(f"{side}, {name}: {median:.1f} ms, {median / plain:.1f} times")
