# SPDX-License-Identifier: MIT OR Apache-2.0
"""Wheels between tread and flange: patches on planes, patches that follow the rail, and prisms.

Usage: python studies/conformal_wheels.py. Takes some minutes. S1002 on 60E1 and a rail whose gauge corner is
worn, under a vertical force, rolling freely without yaw. At the height of the patches that follow the rail,
prisms of both sections are pressed together by the same gap and roll with the same rigid slip: the rail is a
wedge of 45 degrees below its head, the wheel one above its tyre, both of them a metre large, so that neither
its web nor the wheel's disc is bent. Pressure and friction act on each other there. Writes the map
docs/maps/conformal_wheels.
"""

import time
import warnings

import numpy as np
from atlas import panels, write
from scipy.optimize import brentq
from wheel_poses import profiles

import mtb_rs as mtb

FORCE, SPEED, FRICTION, CELL, LARGE = 80e3, 20.0, 0.3, 0.5e-3, 1.0
RADIUS = 0.46
#: Shift [mm] beyond which the flange of the prism bends away.
BENDS = 6.6
NAMES = ("normal force", "lateral force", "force along", "peak")

warnings.simplefilter("ignore")


def scene(wheel, rail):
    return mtb.scenes.wheel_on_rail(
        wheel, rail, lateral=0.0, force=FORCE, spacing=CELL, friction=FRICTION, rail_inclination=0.0
    )


def told(step):
    """Normal force, force of the pressures and tractions on the rail across and along it, peak."""
    patch = max(step.patches, key=lambda patch: patch.normal_force)
    return np.array([patch.normal_force, patch.force[1], patch.force[0], patch.pressure.max()])


def wedge(profile, *, upwards):
    """The running surface of a profile, and a wedge of 45 degrees behind it."""
    y = np.linspace(*profile.range, 1201)
    points = np.stack([y, profile.height(y)], axis=1)
    away = LARGE * np.array([[-1.0, 1.0 if upwards else -1.0], [1.0, 1.0 if upwards else -1.0]])
    return np.concatenate([points[:1] + away[:1], points, points[-1:] + away[1:]])


def both_ways(wheel, rail, step):
    """The same contact of prisms, and of turned half-spaces whose traction moves the gap.

    Nothing of two patches, and where rows would go around a corner of the wedges.
    """
    if len(step.patches) != 1:
        return []
    (patch,) = step.patches
    rows = np.flatnonzero(patch.pressure.max(axis=1) > 0.0)
    middle, half = (rows[0] + rows[-1]) // 2, (rows[-1] - rows[0]) // 2 + 6
    way, ends = float(rail.arc_length(patch.rail_position)) + patch.y[middle], rail.arc_length(rail.range)
    half = min(half, int((way - ends[0]) / CELL), int((ends[1] - way) / CELL))
    ways = way + CELL * np.arange(-half, half + 1)
    feet = rail.position(ways)
    angle, x = np.arctan(rail.slope(feet)), patch.x
    points = np.stack([feet, rail.height(feet)])
    across, up = points + (patch.row_position[:, middle] - points[:, half])[:, None]
    # the wheel's own frame: y from its tape circle, z up from there
    tape, axle = 0.5 * 1.360 + 70e-3 + step.pose[1], step.reference_point[2]
    out = np.stack([-np.sin(angle), np.cos(angle)])

    def above(h, j, ahead):
        y, z = across[j] + h * out[0, j], up[j] + h * out[1, j]
        own = np.clip(y - tape, *wheel.range)
        return RADIUS - float(wheel.height(own)) - float(np.hypot(ahead, axle - z))

    def distance(j, ahead):
        try:
            return brentq(above, -1e-3, 3e-3, args=(j, ahead), xtol=1e-13)
        except ValueError:
            return 3e-3

    gap = np.array([[distance(j, ahead) for ahead in x] for j in range(angle.size)])
    depth = np.array([distance(j, 0.0) for j in range(angle.size)])
    y, z = across + depth * out[0], up + depth * out[1]
    along = SPEED + SPEED / RADIUS * (z - axle)
    slip = np.stack([
        np.repeat(along[:, None], x.size, axis=1), SPEED / RADIUS * np.outer(out[0], x + CELL / 6.0)
    ]) / patch.rolling_speed  # fmt: skip
    facing = float(y[half] - tape)
    lower = mtb.Prism(wedge(rail, upwards=False), origin=tuple(points[:, half]))
    upper = mtb.Prism(wedge(wheel, upwards=True), origin=(facing, float(wheel.height(facing))))
    found = []
    for bodies, inclination in (((lower, upper), None), ((mtb.steel, mtb.steel), angle)):
        try:
            normal = mtb.solve_normal(
                gap - gap.min(),
                CELL,
                lower=bodies[0],
                upper=bodies[1],
                approach=-gap.min(),
                inclination=inclination,
            )
        except ValueError as error:
            if "around no corner" not in str(error):
                raise
            return []
        rolled = mtb.solve_tangential(
            normal, mtb.Rolling(rigid_slip=slip), mtb.Coulomb(FRICTION), coupling="full"
        )
        pressure, (force_x, force_y) = rolled.pressure, rolled.traction[:2]
        lateral = force_y * np.cos(angle)[:, None] + pressure * np.sin(angle)[:, None]
        sums = [float(field.sum()) * CELL**2 for field in (pressure, lateral, force_x)]
        found.append(np.array([*sums, pressure.max()]))
    return found


def main():
    rows = []
    figure, (left, right) = panels(2)
    for (name, (wheel, rail)), colour in zip(profiles().items(), ("C0", None, "C3", None), strict=True):
        if colour is None:
            continue
        made, curves = scene(wheel, rail), {}
        for shift in np.round(np.arange(5.0, 7.41, 0.1), 1):
            found = {}
            for way, conformal in (("planes", False), ("rows", True)):
                wheels = made.prepare(conformal=conformal)
                wheels.step([0.0, 1e-3 * shift - 1e-5, np.nan, 0.0, 0.0, 0.0], SPEED)
                started = time.process_time()
                step = wheels.step([0.0, 1e-3 * shift, np.nan, 0.0, 0.0, 0.0], SPEED)
                found[way] = told(step), time.process_time() - started
            if round(10 * shift) % 2 == 0:
                for way, values in zip(
                    ("prisms", "rows, both ways"), both_ways(wheel, rail, step), strict=False
                ):
                    found[way] = values, np.nan
            for way, (values, seconds) in found.items():
                curves.setdefault(way, []).append((shift, *values))
                rows.append(
                    {"profiles": name, "shift_mm": float(shift), "way": way}
                    | {
                        f"{part} [{'Pa' if part == 'peak' else 'N'}]": float(v)
                        for part, v in zip(NAMES, values, strict=True)
                    }
                    | {"ms": 1e3 * seconds}
                )
        label = {"new": "new rail", "corner": "worn corner"}[name]
        for way, style in (("planes", ":"), ("rows", "-"), ("prisms", "o")):
            curve = np.array(curves[way])
            left.plot(curve[:, 0], 1e-3 * curve[:, 2], style, color=colour, label=f"{way}, {label}")
            right.plot(curve[:, 0], 1e-9 * curve[:, 4], style, color=colour)
    for axes, quantity in ((left, "lateral force [kN]"), (right, "peak pressure [GPa]")):
        axes.set(xlabel="shift of the wheelset [mm]", ylabel=quantity)
    left.legend()
    write("conformal_wheels", figure, rows)
    table = {(row["profiles"], row["shift_mm"], row["way"]): row for row in rows}
    for way in ("planes", "rows"):
        off = [
            abs(row["lateral force [N]"] / table[name, shift, "prisms"]["lateral force [N]"] - 1.0)
            for (name, shift, own), row in table.items()
            if own == way and shift <= BENDS and (name, shift, "prisms") in table
        ]
        print(
            f"{way}, up to {BENDS} mm: lateral force off prisms by {100 * np.median(off):.2g} % (median), "
            f"{100 * max(off):.2g} % (most)"
        )
    ratio = [
        row["ms"] / table[name, shift, "planes"]["ms"]
        for (name, shift, own), row in table.items()
        if own == "rows"
    ]
    print(f"a step on rows takes {np.median(ratio):.2g} times as long (median)")


if __name__ == "__main__":
    main()
