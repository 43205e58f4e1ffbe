# SPDX-License-Identifier: MIT OR Apache-2.0
"""A flange root on a gauge corner: half-spaces, turned ones and prisms, over curvature, size, turn, elements.

Usage: python studies/conformal.py. Takes some minutes. The corner is a quarter of the plane with a round
edge, the root the other three quarters, or an arc that turns less between flat faces; both end at a distance,
where they are held. The numbers of CONTACT's example are those of examples/conformal in its public repository
(cases 3 and 5, whose influences come from a file that is not public; its printed output shows the contact
cell by cell). Times are the least of two, sections included.
"""

import time
import warnings

import numpy as np
from atlas import panels, write

import mtb_rs as mtb
from mtb_rs.bodies import prism
from mtb_rs.half_space import prisms

BODY = mtb.Material.from_shear_modulus(82e9, 0.28)
#: Difference of the curvatures of corner and root [1/m], and the radius of the wheel [m].
APART, WHEEL, FRICTION = 1.0 / 10e-3 - 1.0 / 10.2e-3, 0.46, 0.3
NAMES = ("normal_force", "force_x", "force_y", "moment", "peak")
CONTACT = {
    "constant": (99_320, 10_860, 25_780, 32.92, 1034e6),
    "varying": (99_830, 12_700, 23_830, 40.39, 1040e6),
}
LABELS = ("normal force", "creep force along", "across", "moment", "peak pressure")
#: The first cell that touches, of 51, and how many do, in rows 6 to 33 of 39 of case 3.
FIRST = "23 18 15 13 11 10 9 8 8 7 7 6 6 6 6 6 7 7 7 8 9 9 10 11 13 14 17 20"
TOUCHING = "7 17 23 27 31 33 35 37 38 39 39 41 41 41 41 41 39 39 39 37 35 35 33 30 27 24 19 13"
TURNS = (30, 40, 45, 50, 60, 75, 90)

warnings.simplefilter("ignore")


def bodies(radius, size, turn):
    """Corner and root, whose arcs turn by so many degrees and meet where they are at 45."""
    half = np.radians(0.5 * turn)
    angle = np.linspace(0.75 * np.pi + half, 0.75 * np.pi - half, 2001)
    arc = radius * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    ahead = size * np.stack([np.sin(angle), -np.cos(angle)], axis=1)
    free = np.concatenate([[arc[0] - ahead[0]], arc, [arc[-1] + ahead[-1]]])
    given = {"material": BODY, "origin": tuple(arc[1000])}
    root = [[size, size], [-size, size], [-size, -size]]
    return mtb.Prism(free, base=[[size, -size]], **given), mtb.Prism(free, base=root, **given)


def rolled(radius, model, size=1.0, slip="constant", turn=90):
    """CONTACT's example with another radius."""
    side, approach = 0.4e-3, 0.09089e-3
    x, s = ((np.arange(n) - 0.5 * (n - 1)) * side for n in (51, 39))
    root = 1.0 / (1.0 / radius - APART)
    angle, apart = s / radius, root - radius
    across = np.sqrt(root**2 - (apart * np.sin(angle)) ** 2) - apart * np.cos(angle) - radius
    gap = (across + approach * (1.0 - np.cos(angle)))[:, None] + x**2 * np.cos(0.25 * np.pi) / (2.0 * WHEEL)
    lower, upper = bodies(radius, size, turn) if model == "prism" else (BODY, BODY)
    normal = mtb.solve_normal(
        gap,
        side,
        lower=lower,
        upper=upper,
        approach=approach,
        edge="sharp",
        inclination=-angle if model == "turned" else None,
    )
    motion = mtb.Rolling((-4e-3, -9.8995e-3, -1.5372))
    if slip == "varying":
        bend = 0.5 * (1.0 / radius + 1.0 / root)
        lean = 0.25 * np.pi - bend * s
        along = -4e-3 + (np.cos(lean) - np.cos(0.25 * np.pi)) / (bend * WHEEL)
        aside = -0.014 * np.cos(lean)[:, None] - np.outer(np.sin(lean), x) / WHEEL
        motion = mtb.Rolling(rigid_slip=np.stack([np.repeat(along[:, None], x.size, axis=1), aside]))
    return mtb.solve_tangential(
        normal, motion, mtb.Coulomb(FRICTION), coupling="one-way" if model == "plane" else "full"
    )


def solved(*given, **more):
    """Forces on the wheel, moment and peak."""
    found = rolled(*given, **more)
    return np.array([-found.force[2], *-found.force[:2], -found.spin_moment, found.pressure.max()])


def apart(values, reference):
    return {name: 100.0 * value for name, value in zip(NAMES, values / reference - 1.0, strict=True)}


rows = []
sizes = {}
figure, (left, right, lower_left, lower_right) = panels(4)
# CONTACT's example, over the size of the sections
for size in (0.05, 0.1, 0.2, 0.5, 1.0):
    for slip, printed in CONTACT.items():
        found = sizes[size, slip] = solved(10e-3, "prism", size, slip=slip)
        rows.append({"what": "size", "case": slip, "size_m": size} | dict(zip(NAMES, found, strict=True)))
        rows.append(
            {"what": "less than CONTACT, %", "case": slip, "size_m": size} | apart(found, np.array(printed))
        )
for model in ("plane", "turned"):
    for slip, printed in CONTACT.items():
        found = solved(10e-3, model, slip=slip)
        rows.append({"what": model, "case": slip} | dict(zip(NAMES, found, strict=True)))
        rows.append({"what": f"{model} less than CONTACT, %", "case": slip} | apart(found, np.array(printed)))
# the same sum of curvatures, ever less curved
radii = 1e-3 * np.array([10.0, 14.0, 20.0, 40.0, 80.0])
errors = {"plane": [], "turned": []}
for radius in radii:
    reference = solved(radius, "prism")
    for model, found in errors.items():
        found.append(solved(radius, model) / reference - 1.0)
        rows.append(
            {"what": f"{model} less than prisms, %", "radius_m": radius} | apart(1.0 + found[-1], 1.0)
        )
for model, marker in (("plane", "o"), ("turned", "s")):
    for k, label, style in ((0, "normal force", "-"), (1, "creep force along", "--")):
        values = [100.0 * abs(error[k]) for error in errors[model]]
        name = {"plane": "half-spaces", "turned": "half-spaces, turned"}[model]
        left.loglog(1e3 * radii, values, marker + style, label=f"{label}, {name}")
left.set(xlabel="radius of the corner [mm]", ylabel="difference from prisms [%]")
left.set_xticks([10, 20, 40, 80], ["10", "20", "40", "80"])
left.minorticks_off()
left.set_ylim(0.1, 3e2)
left.legend(loc="upper right")
for k, label, style in (
    (0, "normal force", "o-"),
    (1, "creep force along", "s-"),
    (4, "peak pressure", "^-"),
):
    ends = sizes[1.0, "constant"][k]
    values = [100.0 * (sizes[size, "constant"][k] / ends - 1.0) for size in (0.05, 0.1, 0.2, 0.5)]
    right.loglog([50, 100, 200, 500], values, style, label=label)
right.set(xlabel="size of the sections [mm]", ylabel="difference from sections of 1 m [%]")
right.set_xticks([50, 100, 200, 500], ["50", "100", "200", "500"])
right.minorticks_off()
right.legend()
# arcs that turn less, between flat faces
for slip, printed in CONTACT.items():
    found = [solved(10e-3, "prism", slip=slip, turn=turn) for turn in TURNS]
    for turn, values in zip(TURNS, found, strict=True):
        rows.append({"what": "turn", "case": slip, "turn_deg": turn} | dict(zip(NAMES, values, strict=True)))
        rows.append(
            {"what": "less than CONTACT, %", "case": slip, "turn_deg": turn}
            | apart(values, np.array(printed))
        )
    if slip == "constant":
        beside = 100.0 * (np.array(found) / np.array(printed) - 1.0)
        for column, label, style in zip(beside.T, LABELS, "os^vD", strict=True):
            lower_left.plot(TURNS, column, f"{style}-", label=label)
lower_left.axhspan(-2.0, 2.0, color="0.9", zorder=0)
lower_left.set(xlabel="turn of the arcs [°]", ylabel="difference from CONTACT, case 3 [%]", ylim=(-20, 18))
lower_left.legend(loc="lower right")
first = np.array(FIRST.split(), dtype=int)
printed_rows = first, first + np.array(TOUCHING.split(), dtype=int) - 1
lower_right.plot(
    np.concatenate(printed_rows), [*range(6, 34)] * 2, "s", color="0.75", label="CONTACT, case 3"
)
for turn, style in ((45, "-"), (90, "--")):
    touching = rolled(10e-3, "prism", turn=turn).pressure > 0.0
    own = np.flatnonzero(touching.any(axis=1))
    ends = [np.flatnonzero(touching[row])[[0, -1]] + 1 for row in own]
    around = [*(start for start, _ in ends), *(end for _, end in ends[::-1]), ends[0][0]]
    lower_right.plot(around, [*(own + 1), *(own[::-1] + 1), own[0] + 1], style, label=f"prisms, {turn}°")
    cells = {"touching": int(touching.sum()), "first_row": own[0] + 1, "last_row": own[-1] + 1}
    rows.append({"what": "cells", "case": "constant", "turn_deg": turn} | cells)
lower_right.set(xlabel="cell along x", ylabel="row across")
lower_right.legend(loc="center")
# elements under a row
finest = {}
for parts in (1, 2, 4, 8):
    prism.FINE_PARTS = parts
    seconds = []
    for _ in range(2):
        prisms._prisms.cache_clear()
        started = time.perf_counter()
        found = solved(10e-3, "prism", 0.2)
        seconds.append(time.perf_counter() - started)
    finest[parts] = (min(seconds), found)
for parts, (taken, found) in finest.items():
    rows.append(
        {"what": "elements under a row", "parts": parts, "seconds": taken} | apart(found, finest[8][1])
    )
keys = list(dict.fromkeys(key for row in rows for key in row))
write("conformal", figure, [{key: row.get(key, "") for key in keys} for row in rows])
