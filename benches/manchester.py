# SPDX-License-Identifier: MIT OR Apache-2.0
"""The Manchester benchmark A-2.2 [Shackleton2008]: 42 positions of a new S1002 wheelset on new UIC60 rails.

    python benches/manchester.py [--out docs/charts]

The wheelset is shifted to the right by 0 to 10 mm in steps of 0.5 mm and yawed by 2.4 mrad a millimetre.
Height and roll are those at which each wheel carries 10 kN, friction included; it rolls freely at 2 m/s, so
that the creep forces have no moment about its axle. Prints the whole table, and beside it what CONTACT prints
where `tests/data/contact/whole_wheels.csv` has it; writes both as CSV and draws them. Signs and track frame
are CONTACT's: x forwards, y to the right, z down, forces on the rail, cksi of the rail over the wheel; places
of contacts are distances from the middle of the track.
"""

from __future__ import annotations

import argparse
import csv
from pathlib import Path
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
import records
from numpy.typing import NDArray
from scipy.optimize import brentq

import mtb_rs as mtb

Array = NDArray[np.float64]

DATA = Path(__file__).parents[1] / "tests" / "data" / "contact"
MM, MRAD, MPA = 1e-3, 1e-3, 1e6
STEEL = mtb.Material.from_shear_modulus(82e9, 0.28)
FORCE, SPEED, FRICTION, SPACING = 10e3, 2.0, 0.3, 0.2 * MM
YAW = 2.4 * MRAD / MM  #: of the shift
RADIUS, GAUGE, GAUGE_DEPTH, FLANGE_BACK, TAPE_CIRCLE = 0.46, 1.435, 14 * MM, 1.360, 70 * MM
SHIFTS = 0.5 * np.arange(21)
#: CONTACT's height of the centred wheelset that just touches [mm], down.
TOUCHING = 0.1821
#: Numbers of a contact and the columns of CONTACT's with them.
PRINTED = {
    "y_contact_mm": "y_contact_mm",
    "angle_rad": "angle_rad",
    "cksi": "cksi",
    "ceta": "ceta",
    "cphi_1_m": "cphi_1_m",
    "Fn_N": "FN_N",
    "Fx_N": "FX_track_N",
    "Fy_N": "FY_track_N",
    "pmax_MPa": "pmax_MPa",
}


def points(name: str, sign: float) -> tuple[Array, Array]:
    """Points of a profile of the benchmark [m], y rising, z up."""
    y, z = np.loadtxt(DATA / name, delimiter=",", unpack=True)
    y = sign * y
    # the foot of the rail's face stands upright: a place that comes twice counts once
    forward = np.concatenate([[True], np.diff(np.maximum.accumulate(y)) > 0.0])
    return y[forward] * MM, -z[forward] * MM


WHEEL, RAIL = points("manchester_s1002.csv.gz", -1.0), points("manchester_uic60.csv.gz", 1.0)


def prepared() -> mtb.PreparedWheels:
    scene = mtb.scenes.wheel_on_rail(
        wheel=mtb.Profile.from_points(*WHEEL),
        rail=mtb.Profile.from_points(*RAIL),
        rail_inclination=0.0,  # the profile has it in
        lateral=0.0,
        force=FORCE,
        spacing=SPACING,
        wheel_radius=RADIUS,
        gauge=GAUGE,
        gauge_depth=GAUGE_DEPTH,
        flange_back=FLANGE_BACK,
        tape_circle=TAPE_CIRCLE,
        upper=STEEL,
        lower=STEEL,
    )
    return scene.prepare(side="both", friction=mtb.Coulomb(FRICTION))


def rolling(wheels: mtb.PreparedWheels, shift: float) -> tuple[mtb.WheelStep, float]:
    """The step at a shift to the right [mm], rolling freely, and the speed of rotation [rad/s]."""
    yaw = -YAW * shift * MM
    pose = [0.0, -shift * MM, np.nan, np.nan, 0.0, yaw]
    last = [wheels.step(pose, SPEED)]

    def step(roll: float, omega: float) -> mtb.WheelStep:
        axle = np.array([-np.sin(yaw) * np.cos(roll), np.cos(yaw) * np.cos(roll), np.sin(roll)])
        velocity = [SPEED, 0.0, 0.0, *(omega * axle)]
        found = wheels.step(pose, velocity)
        last[:] = [found]
        return found

    def drive(omega: float) -> float:
        """Moment about the axle [N m]; the axle lies as in the step before, and the next one corrects it."""
        found = step(last[0].pose[3], omega)
        for _ in range(2):
            found = step(found.pose[3], omega)
        roll = found.pose[3]
        axle = np.array([-np.sin(yaw) * np.cos(roll), np.cos(yaw) * np.cos(roll), np.sin(roll)])
        return float(found.moment @ axle)

    omega = brentq(drive, 0.96 * SPEED / RADIUS, 1.005 * SPEED / RADIUS, xtol=1e-9)
    drive(omega)
    return last[0], omega


def table() -> list[dict[str, Any]]:
    """One row a contact: that of the left wheel, then that of the right one, at each shift."""
    wheels, rows = prepared(), []
    for shift in SHIFTS:
        step, omega = rolling(wheels, float(shift))
        for patch in sorted(step.patches, key=lambda patch: (patch.side, patch.contact_angle)):
            xi, eta, phi = patch.creepage
            rows.append(
                {
                    "side": patch.side,
                    "y_mm": float(shift),
                    "z_mm": TOUCHING - step.pose[2] / MM,
                    "roll_mrad": step.pose[3] / MRAD,
                    "omega_rad_s": -omega,
                    "y_contact_mm": abs(patch.position[1]) / MM,
                    "angle_rad": patch.contact_angle,
                    "cksi": -xi,
                    "ceta": eta,
                    "cphi_1_m": phi,
                    "Fn_N": patch.normal_force,
                    "Fx_N": patch.force[0],
                    "Fy_N": -patch.force[1],
                    "Fz_N": -patch.force[2],
                    "pmax_MPa": patch.pressure.max() / MPA,
                }
            )
    return rows


def printed() -> dict[tuple[str, float], dict[str, float]]:
    """What CONTACT prints of the poses at hand that are the benchmark's, by side and shift [mm]."""
    known = {}
    with (DATA / "whole_wheels.csv").open(encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    for row in rows:
        given = [float(row[name] or "nan") for name in ("yaw_rad", "FZ_N", "cant_rad")]
        if not np.allclose(given, [YAW * float(row["y_mm"]) * MM, FORCE, 0.0], rtol=1e-9, atol=1e-12):
            continue
        found = {name: float(row[column]) for name, column in PRINTED.items()}
        found |= {"roll_mrad": float(row["roll_rad"]) / MRAD, "omega_rad_s": float(row["omega_rad_s"])}
        known[row["side"], float(row["y_mm"])] = found | {"y_contact_mm": abs(found["y_contact_mm"])}
    return known


def draw(rows: list[dict[str, Any]], path: Path) -> None:
    """Places, angles, creepages and forces over the shift; CONTACT's as open circles."""
    known = printed()
    panels = {
        "y_contact_mm": "place of the contact [mm]",
        "angle_rad": "contact angle [rad]",
        "cksi": "longitudinal creepage [-]",
        "ceta": "lateral creepage [-]",
        "cphi_1_m": "spin [1/m]",
        "Fn_N": "normal force [N]",
        "Fx_N": "force along the rail [N]",
        "Fy_N": "force across the track [N]",
    }
    figure, axes = plt.subplots(2, 4, figsize=(13.0, 6.0), sharex=True, layout="constrained")
    for axis, (name, label) in zip(axes.flat, panels.items(), strict=True):
        for side, colour in (("left", "C0"), ("right", "C1")):
            mine = [row for row in rows if row["side"] == side]
            shifts = [float(row["y_mm"]) for row in mine]
            axis.plot(shifts, [float(row[name]) for row in mine], ".-", color=colour, label=f"{side} wheel")
            theirs = [(shift, found[name]) for (on, shift), found in known.items() if on == side]
            axis.plot(*zip(*theirs, strict=True), "o", mfc="none", ms=10, color=colour, label="CONTACT")
        axis.set_title(label, loc="left")
    for axis in axes[1]:
        axis.set_xlabel("shift to the right [mm]")
    axes[0, 0].legend()
    figure.savefig(path / "manchester.png", dpi=110)
    plt.close(figure)


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--out", type=Path, default=Path("docs/charts"), help="where table and picture go")
    parser.add_argument("--draw", action="store_true", help="only draw the table again that is there")
    given = parser.parse_args()
    if given.draw:
        draw(records.read(given.out / "manchester.csv"), given.out)
        return
    rows, known = table(), printed()
    print(" ".join(f"{name:>12}" for name in rows[0]))
    for row in rows:
        print(
            " ".join(f"{value:>12}" if isinstance(value, str) else f"{value:12.5g}" for value in row.values())
        )
        if (there := known.get((row["side"], row["y_mm"]))) is not None:
            texts = (f"{there[name]:12.5g}" if name in there else " " * 12 for name in list(row)[1:])
            print(f"{'CONTACT':>12}", *texts)
    compared = [
        {
            "side": row["side"],
            "y_mm": row["y_mm"],
            "quantity": name,
            "ours": row[name],
            "contact": there[name],
        }
        for row in rows
        if (there := known.get((row["side"], row["y_mm"]))) is not None
        for name in ("roll_mrad", "omega_rad_s", *PRINTED)
    ]
    records.write(given.out / "manchester.csv", rows)
    records.write(given.out / "manchester_compared.csv", compared)
    draw(rows, given.out)


if __name__ == "__main__":
    main()
