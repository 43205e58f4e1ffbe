# SPDX-License-Identifier: MIT OR Apache-2.0
"""When a contact on a curved surface needs its inclination: change of forces over the angle, error over time.

Usage: python studies/inclination.py. Takes half a minute. A wheel of 460 mm rolls in a groove whose curvature
exceeds its own by 2 per cent; approach and creepage are given. Errors of the grid are against twice as many
cells as on the finest one, times are the least of five.
"""

import time
import warnings

import numpy as np
from atlas import panels, write

import mtb_rs as mtb

STEEL = mtb.Material.from_shear_modulus(82e9, 0.28)
RATIO, WHEEL, CREEPAGE, FRICTION = 0.98, 0.46, 1e-3, 0.3

warnings.simplefilter("ignore")


def groove(radius, approach, n):
    """Undeformed gap, cell sides and angles of n x n cells over the contact in a groove."""
    wide = 1.15 * np.sqrt(2.0 * approach * radius / (1.0 - RATIO))
    long = 1.15 * np.sqrt(2.0 * approach * WHEEL)
    places = (np.arange(n) + 0.5) / n * 2.0 - 1.0
    x, s = long * places, wide * places
    # from one circle to the other along the normals of the first, which is the inner one
    angles, apart = s / radius, radius / RATIO - radius
    across = -apart * np.cos(angles) + np.sqrt((radius + apart) ** 2 - (apart * np.sin(angles)) ** 2) - radius
    gap = x**2 / (2.0 * WHEEL) + across[:, None]
    return gap, (2.0 * long / n, 2.0 * wide / n), -angles


def solved(radius, approach, n, turned, coupling="one-way"):
    gap, spacing, angles = groove(radius, approach, n)
    normal = mtb.solve_normal(
        gap,
        spacing,
        lower=STEEL,
        upper=STEEL,
        approach=approach,
        edge="sharp",
        inclination=angles if turned else None,
    )
    found = mtb.solve_tangential(
        normal, mtb.Rolling((CREEPAGE, 0.0, 0.0)), mtb.Coulomb(FRICTION), coupling=coupling
    )
    return normal, found, float(np.abs(angles[np.any(normal.pressure > 0.0, axis=1)]).max())


rows = []
figure, (left, right) = panels(2)
approach = 5e-5
for radius in 1e-3 * np.array([1000.0, 300.0, 100.0, 60.0, 40.0, 30.0, 22.0, 17.0, 13.0, 10.0]):
    plane, _, _ = [*solved(radius, approach, 48, False)]
    flat = solved(radius, approach, 48, False)[1]
    one, alone, angle = solved(radius, approach, 48, True)
    _, both, _ = solved(radius, approach, 48, True, "full")
    rows.append(
        {
            "angle_deg": np.degrees(angle),
            "pressure_force": 100.0 * (plane.normal_force / one.normal_force - 1.0),
            "creep_force": 100.0 * (flat.force[0] / both.force[0] - 1.0),
            "one_way_creep_force": 100.0 * (alone.force[0] / both.force[0] - 1.0),
            "one_way_pressure_force": 100.0 * (alone.force[2] / both.force[2] - 1.0),
        }
    )
angles = [row["angle_deg"] for row in rows]
for name, label, style in (
    ("pressure_force", "normal force on a plane surface", "o-"),
    ("creep_force", "creep force on a plane surface", "s-"),
    ("one_way_creep_force", "creep force, inclined, coupling one-way", "^--"),
):
    left.loglog(angles, [max(abs(row[name]), 1e-4) for row in rows], style, label=label)
left.set(xlabel="half the angle over which the contact turns [°]", ylabel="error against inclined, full [%]")
left.set_xticks([4, 6, 10, 20, 30], ["4", "6", "10", "20", "30"])
left.minorticks_off()
left.set_ylim(1e-3, 3e2)
left.legend(loc="upper left")
finest = solved(0.013, approach, 384, True, "full")[1]
for turned, coupling, label, style in (
    (False, "one-way", "plane", "o-"),
    (True, "one-way", "inclined", "s-"),
    (True, "full", "inclined, full", "^-"),
):
    reference = finest if coupling == "full" else solved(0.013, approach, 384, turned, coupling)[1]
    errors, seconds = [], []
    for n in (12, 24, 48, 96, 192):
        times = []
        for _ in range(5):
            started = time.perf_counter()
            _, found, _ = solved(0.013, approach, n, turned, coupling)
            times.append(time.perf_counter() - started)
        seconds.append(1e3 * min(times))
        errors.append(100.0 * abs(found.force[0] / reference.force[0] - 1.0))
        rows.append({"grid": n, "kind": label, "error_percent": errors[-1], "ms": seconds[-1]})
    right.loglog(seconds, errors, style, label=label)
right.set(xlabel="time [ms]", ylabel="error of the creep force by the grid [%]")
right.legend()
keys = list(dict.fromkeys(key for row in rows for key in row))
write("inclination", figure, [{key: row.get(key, "") for key in keys} for row in rows])
