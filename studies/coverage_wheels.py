# SPDX-License-Identifier: MIT OR Apache-2.0
"""The examples of CONTACT with whole wheels, for `coverage.py`: the Manchester benchmark A-2.2.

A module of `coverage.py`, not run by itself. Settings and printed figures are those of the program's example
inputs and of the reference outputs stored beside them: track frame, y to the right, z down, forces on the
rail, creepages of the rail over the wheel, mm, N, MPa and rad/mm.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

import mtb_rs as mtb

Row = tuple[str, str, str, float] | tuple[str, str, str, float, float]

DATA = Path(__file__).parents[1] / "tests" / "data" / "contact"
MM, MPA = 1e-3, 1e6
STEEL = mtb.Material.from_shear_modulus(82e9, 0.28)
YAW = 2.4e-3  #: of a millimetre of shift
#: CONTACT's height of the centred wheelset that just touches [mm].
TOUCHING = 0.1821

#: Roll and rotation over the shift [mm], which the examples give.
MOTION = {
    0.0: (0.0, -4.34811810),
    0.5: (-0.00002304, -4.34741340),
    5.0: (-0.00035540, -4.33536370),
    5.5: (-0.00047770, -4.33188640),
    6.0: (-0.00062720, -4.32937180),
    6.5: (-0.00437600, -4.27488340),
    9.0: (-0.01010113, -4.24775610),
    9.5: (-0.01071386, -4.24556650),
    10.0: (-0.01126431, -4.24363750),
}
QUANTITIES = (
    "height of the wheelset [mm]",
    "force along [N]",
    "force across [N]",
    "normal force [N]",
    "peak pressure [MPa]",
    "longitudinal creepage",
    "lateral creepage",
    "spin [1/mm]",
    "contact angle [rad]",
)
#: Case, shift, and what is printed of the quantities above.
RIGHT = (
    ("1", 0.0, "0.1981 0.2774 36.24 9997. 338.3 -5.665E-05 0.000 6.302E-05 -0.0290"),
    ("2", 0.5, "0.1938 -880.0 -2015. 9870. 632.5 4.948E-04 1.202E-03 1.233E-04 -0.0568"),
    ("12", 5.5, "-0.0866 -850.2 572.9 9629. 1486. 4.379E-03 1.401E-02 7.122E-04 -0.3363"),
    ("13", 6.0, "-0.1961 -880.0 1401. 9709. 1149. 5.077E-03 1.580E-02 8.744E-04 -0.4176"),
    ("14", 6.5, "-3.0468 -1987. 1.248E+04 1.544E+04 2603. 1.828E-02 3.905E-02 1.937E-03 -1.1591"),
    ("19", 9.0, "-7.3919 -2014. 7213. 1.197E+04 2640. 2.266E-02 3.341E-02 1.588E-03 -0.8676"),
    ("20", 9.5, "-7.8534 -1981. 6697. 1.168E+04 2641. 2.325E-02 3.388E-02 1.536E-03 -0.8321"),
    ("21", 10.0, "-8.2668 -1947. 6235. 1.144E+04 2643. 2.378E-02 3.445E-02 1.486E-03 -0.7992"),
)
LEFT = (
    ("1", 0.0, "0.1981 0.2774 -36.24 9997. 338.3 -5.665E-05 0.000 -6.302E-05 0.0290"),
    ("2", 0.5, "0.1945 887.1 -2582. 1.005E+04 395.3 -3.708E-04 1.200E-03 -4.592E-05 0.0211"),
    ("19", 9.0, "-7.3913 2257. -2080. 1.002E+04 725.3 -2.425E-02 2.135E-02 -4.210E-05 0.0095"),
    ("20", 9.5, "-7.8528 2227. -2125. 1.002E+04 735.2 -2.482E-02 2.253E-02 -4.549E-05 0.0105"),
    ("21", 10.0, "-8.2662 2196. -2169. 1.002E+04 744.0 -2.532E-02 2.371E-02 -4.883E-05 0.0115"),
)


def profile(name: str, sign: float) -> mtb.Profile:
    """A profile of the benchmark, in our frame."""
    y, z = np.loadtxt(DATA / name, delimiter=",", unpack=True)
    y = sign * y
    # the foot of the rail's face stands upright: a place that comes twice counts once
    forward = np.concatenate([[True], np.diff(np.maximum.accumulate(y)) > 0.0])
    return mtb.Profile.from_points(y[forward] * MM, -z[forward] * MM)


WHEEL, RAIL = profile("manchester_s1002.csv.gz", -1.0), profile("manchester_uic60.csv.gz", 1.0)


@cache
def prepared(side: Any, *, inclined: bool = False, conformal: bool = False) -> mtb.PreparedWheels:
    """`inclined`: friction that falls with the inclination of the rail's surface."""
    friction: Any = mtb.Coulomb(0.3)
    if inclined:
        y = np.linspace(-43.0, 30.0, 1461) * MM
        height = RAIL.height(y)
        inclination = np.degrees(np.abs(np.arctan(np.gradient(height, y))))
        falls = np.where(y < 0.0, inclination, 0.0)
        friction = mtb.RailFriction(y, np.interp(falls, [10.0, 20.0], [0.3, 0.2]))
    scene = mtb.scenes.wheel_on_rail(
        wheel=WHEEL,
        rail=RAIL,
        rail_inclination=0.0,
        lateral=0.0,
        force=10e3,
        spacing=0.2 * MM,
        upper=STEEL,
        lower=STEEL,
    )
    return scene.prepare(side=side, friction=friction, conformal=conformal)


def step(side: str, shift: float, *, inclined: bool = False, conformal: bool = False) -> mtb.WheelStep:
    """Under 10 kN, friction in the balance, at the roll and the rotation that the examples give."""
    roll, omega = MOTION[shift]
    yaw = -YAW * shift
    axle = np.array([-np.sin(yaw) * np.cos(roll), np.cos(yaw) * np.cos(roll), np.sin(roll)])
    velocity = [2.0, 0.0, 0.0, *(-omega * axle)]
    wheels = prepared(side, inclined=inclined, conformal=conformal)
    return wheels.step([0.0, -shift * MM, np.nan, roll, 0.0, yaw], velocity)


def of_wheel(case: str, quantity: str, printed: str, own: float) -> Row:
    """Friction forces differ by shares of what friction carries, and heights by shares of a millimetre."""
    if quantity.startswith("force"):
        return case, quantity, printed, own, 3e3
    if quantity.startswith("height"):
        return case, quantity, printed, own, 1.0
    return case, quantity, printed, own


def positions(side: str, rows: Any) -> Iterator[Row]:
    for case, shift, printed in rows:
        found = step(side, shift)
        (patch,) = found.patches
        xi, eta, phi = patch.creepage
        angle = patch.contact_angle * (-1.0 if side == "right" else 1.0)
        values = (
            TOUCHING - found.pose[2] / MM,
            found.force[0],
            -found.force[1],
            patch.normal_force,
            patch.pressure.max() / MPA,
            -xi,
            eta,
            phi * MM,
            angle,
        )
        for quantity, text, value in zip(QUANTITIES, printed.split(), values, strict=True):
            yield of_wheel(case, quantity, text, float(value))


def mbench_a22_right() -> Iterator[Row]:
    yield from positions("right", RIGHT)


def mbench_a22_left() -> Iterator[Row]:
    yield from positions("left", LEFT)


def mbench_a22_kpec() -> Iterator[Row]:
    """ANALYN at the printed approach; the full solution as for the right wheel. KPEC refuses the gap."""
    found = mtb.wheel_on_rail_gap(
        WHEEL, RAIL, rail_inclination=0.0, lateral=0.0, force=10e3, spacing=0.2 * MM, scale=1.3
    )
    normal = mtb.solve_normal(
        found.gap, 0.2 * MM, lower=STEEL, upper=STEEL, approach=1.646e-2 * MM, method="analyn"
    )
    yield "4", "normal force of ANALYN [N]", "9997.", normal.normal_force
    yield "4", "peak pressure of ANALYN [MPa]", "352.1", normal.pressure.max() / MPA
    for case, row in (("7", RIGHT[0]), ("8", RIGHT[1])):
        yield from positions("right", [(case, *row[1:])])


def mbench_a22_varfric() -> Iterator[Row]:
    yield from positions("right", RIGHT[:2])
    (patch,) = step("right", 0.0).patches
    inside = patch.stress(depths=[(1e-6 + 0.5 * k) * MM for k in range(11)])
    yield "1", "von Mises stress [MPa]", "210.509", inside.von_mises.max() / MPA
    # in case 3 CONTACT has two contacts, with planes of their own, where we have one; plane contacts have one
    # coefficient each; the contact of case 5 is curved
    for case, shift, printed, force, peak in (
        ("3", 5.0, "0.0013 -637.5 646.3", "", "1579."),
        ("4", 5.5, "-0.0860 -608.6 1417.", "9907.", "1500."),
        ("5", 5.5, "-0.0860 -613.9 1387.", "", ""),
    ):
        found = step("right", shift, inclined=True, conformal=case == "5")
        values = (TOUCHING - found.pose[2] / MM, found.force[0], -found.force[1])
        for quantity, text, value in zip(QUANTITIES, printed.split(), values, strict=False):
            yield of_wheel(case, quantity, text, float(value))
        largest = max(found.patches, key=lambda patch: patch.pressure.max())
        if peak:
            yield case, "peak pressure [MPa]", peak, largest.pressure.max() / MPA
        if force:
            yield case, "normal force [N]", force, largest.normal_force


COMPARED: dict[str, Callable[[], Iterator[Row]]] = {
    f.__name__: f for f in (mbench_a22_kpec, mbench_a22_left, mbench_a22_right, mbench_a22_varfric)
}
