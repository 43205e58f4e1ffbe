# SPDX-License-Identifier: MIT OR Apache-2.0
"""The published examples of CONTACT beside mtb_rs: what is expressible, and how far the numbers are apart.

Usage: python studies/coverage.py [NAME ...]. Takes about a minute. The settings are those of the example
inputs of the open program CONTACT (eve70a/CONTACT, folder `examples`), and the printed figures are those of
the reference outputs stored beside them, in its units and signs (mm, N, MPa; forces on the upper body, in
whole wheels on the rail). Writes `coverage_numbers.csv` (each number), `coverage_differences.csv` (those that
are apart) and `coverage.csv` (a row an example) into docs/maps; with names it only prints these examples.
"""

from __future__ import annotations

import csv
import math
import sys
import warnings
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import coverage_wheels
import numpy as np
from coverage_examples import EXAMPLES, REPRODUCED
from numpy.typing import NDArray

import mtb_rs as mtb

Array = NDArray[np.float64]
#: Case, quantity, what is printed, our number, and what the difference is measured in (else what is printed).
Row = tuple[str, str, str, float] | tuple[str, str, str, float, float]

FOLDER = Path(__file__).parents[1] / "docs" / "maps"
MM, MPA = 1e-3, 1e6
#: Largest relative difference with which an example counts as reproduced.
ALLOWED = 0.02
#: Difference from which the page lists a number by itself.
TOLD = 0.005


def material(modulus: float, poisson_ratio: float) -> mtb.Material:
    """From a shear modulus in MPa."""
    return mtb.Material.from_shear_modulus(modulus * MPA, poisson_ratio)


STEEL = material(82000.0, 0.28)


def centres(count: int, first: float, step: float) -> Array:
    """Of cells [mm]."""
    return np.asarray(first + step * np.arange(count), dtype=float)


def symmetric(count: int, step: float) -> Array:
    return centres(count, -0.5 * step * (count - 1), step)


def pressed(x: Array, y: Array, curvatures: tuple[float, float], width: float = 0.0, **given: Any) -> Any:
    """Contact over the gap b1 x^2 + b3 y^2 [mm], on rows of cells; `width` of the cells of a single row."""
    gap = (curvatures[0] * x[None, :] ** 2 + curvatures[1] * y[:, None] ** 2) * MM
    return pressed_gap(gap, (x[1] - x[0], width or y[1] - y[0]), **given)


def pressed_gap(gap: Array, cells: tuple[float, float], body: Any = STEEL, **given: Any) -> Any:
    bodies = {"lower": body, "upper": body} | given
    return mtb.solve_normal(gap, (cells[0] * MM, cells[1] * MM), edge="sharp", tolerance=1e-9, **bodies)


def rolled(normal: Any, creepage: tuple[float, float, float], mu: float, **given: Any) -> Any:
    """Steady rolling, the spin in rad/mm as CONTACT has it."""
    motion = mtb.Rolling((creepage[0], creepage[1], creepage[2] / MM), **given)
    return mtb.solve_tangential(normal, motion, mtb.Coulomb(mu))


def sticking(found: Any) -> float:
    return float(np.count_nonzero(found.status == 1))


def touching(found: Any) -> float:
    return float(np.count_nonzero(np.asarray(found.pressure) > 0.0))


def of_normal(case: str, normal: Any, approach: str, peak: str, cells: str) -> Iterator[Row]:
    yield case, "approach [mm]", approach, normal.approach / MM
    yield case, "peak pressure [MPa]", peak, normal.pressure.max() / MPA
    yield case, "cells in contact", cells, touching(normal)


def cattaneo() -> Iterator[Row]:
    body, force, cells = material(200.0, 0.42), 9.1954, symmetric(19, 2.0 * 1.26667 / 19)
    hertz = mtb.hertz(force, semi_axes=(1.0 * MM, 1.0 * MM), lower=body, upper=body)
    half = 0.5 * hertz.curvatures[0] * MM
    yield from of_normal(
        "1", pressed(cells, cells, (half, half), body=body, force=force), "1.998E-02", "4.393", "177"
    )
    cells = symmetric(19, 0.13333)
    normal = pressed(cells, cells, (0.01, 0.01), body=body, force=force)
    yield from of_normal("2", normal, "1.998E-02", "4.393", "177")
    shift = mtb.Shift(force=(0.875 * 0.4 * force, 0.0))
    found = mtb.solve_tangential(normal, shift, mtb.Coulomb(0.4))
    yield "2", "shift along x [mm]", "8.155E-03", found.creepage[0] / MM
    yield "2", "cells that stick", "45", sticking(found)


def carter2d() -> Iterator[Row]:
    normal = pressed(centres(55, -1.05, 0.04), np.zeros(1), (0.001, 0.0), 200.0, force=35780.0)
    yield from of_normal("1", normal, "6.492E-03", "113.9", "50")
    found = rolled(normal, (-0.00024, 0.0, 0.0), 0.3)
    yield "1", "force along x [N]", "6955.", -found.force[0]
    yield "1", "cells that stick", "30", sticking(found)
    for cell, traction in ((10, "28.0786"), (21, "24.7333"), (35, "10.6012"), (49, "2.0861")):
        yield "1", f"traction of cell {cell + 3} [MPa]", traction, -found.traction[0, 0, cell + 2] / MPA


def bentall() -> Iterator[Row]:
    aluminium, force = material(23000.0, 0.31), 16201.9
    normal = pressed(symmetric(216, 0.001), np.zeros(1), (0.02, 0.0), 1000.0, upper=aluminium, force=force)
    # friction, share of it that is transmitted, creepage, peak, cells that stick, approach
    cases = {
        "2": (1e-4, 0.0, "5.260E-04", "103.1", "1", "one-way"),
        "3": (10.0, 0.0, "3.591E-04", "103.8", "200", "full"),
        "4": (0.05, 0.0, "4.294E-04", "103.6", "125", "full"),
        "5": (0.05, 0.75, "2.108E-04", "103.2", "36", "full"),
        "6": (0.05, -0.75, "5.392E-04", "103.3", "106", "full"),
    }
    yield "2", "approach [mm]", "2.081E-03", normal.approach / MM
    for case, (mu, share, creepage, peak, stick, coupling) in cases.items():
        motion = mtb.Rolling(force=(-share * mu * force, None), angle=math.pi)
        law: Any = mtb.Coulomb(mu)
        found = mtb.solve_tangential(normal, motion, law, coupling=coupling)  # type: ignore[arg-type]
        yield case, "creepage", creepage, found.creepage[0]
        yield case, "peak pressure [MPa]", peak, found.pressure.max() / MPA
        yield case, "cells that stick", stick, sticking(found)


#: Creepages of the steps 1 to 29 and 49 to 56 of transient rolling under a prescribed force.
FROM_CATTANEO_TO_CARTER = (
    "1.824E-03 1.882E-03 1.955E-03 2.050E-03 2.140E-03 2.221E-03 2.334E-03 2.428E-03 2.551E-03 2.676E-03 "
    "2.801E-03 2.968E-03 3.184E-03 3.403E-03 3.402E-03 3.334E-03 3.241E-03 3.192E-03 3.123E-03 3.112E-03 "
    "3.088E-03 3.072E-03 3.064E-03 3.062E-03 3.064E-03 3.070E-03 3.077E-03 3.085E-03"
)
#: Shifts of the first 15 steps in coordinates fixed to the ground [mm].
FIXED_TO_THE_GROUND = (
    "4.548E-04 4.705E-04 4.886E-04 5.125E-04 5.349E-04 5.552E-04 5.835E-04 6.069E-04 6.377E-04 6.690E-04 "
    "7.003E-04 7.419E-04 7.960E-04 8.508E-04 8.505E-04"
)


def catt_to_cart() -> Iterator[Row]:
    body, force, law = material(1.0, 0.28), 0.4705, mtb.Coulomb(0.4013)
    share = 0.657 * 0.4013
    driven = (share * force, None)
    x, y, half = symmetric(34, 0.25) + 0.125, symmetric(33, 0.25), 0.002963
    normal = pressed(x, y, (half, half), body=body, force=force)
    yield from of_normal("1", normal, "7.258E-02", "1.834E-02", "621")
    found = mtb.solve_tangential(normal, mtb.Shift(force=driven), law)
    yield "1", "shift along x [mm]", "1.774E-02", found.creepage[0] / MM
    yield "1", "cells that stick", "305", sticking(found)
    step = mtb.Rolling(force=driven, transient=True, step=0.25 * MM)
    creepages = FROM_CATTANEO_TO_CARTER.split()
    for k in range(56):
        found = mtb.solve_tangential(normal, step, law, state=found.state)
        if k < len(creepages):
            yield f"{k + 2}", "creepage", creepages[k], found.creepage[0]
    yield "57", "creepage", "3.101E-03", found.creepage[0]
    yield "57", "cells that stick", "346", sticking(found)
    # the same in coordinates fixed to the ground: the wheel rolls over the grid, by shifts
    x = centres(90, -4.0, 0.25)
    normal = pressed(x, y, (half, half), body=body, force=force)
    found = mtb.solve_tangential(normal, mtb.Shift(force=driven), law)
    yield "58", "shift along x [mm]", "1.774E-02", found.creepage[0] / MM
    for k, printed in enumerate(FIXED_TO_THE_GROUND.split()):
        normal = pressed(x - 0.25 * (k + 1), y, (half, half), body=body, approach=0.07258 * MM)
        # the approach is given, and the force as a share of what it presses with
        driven = (share * normal.normal_force, None)
        found = mtb.solve_tangential(normal, mtb.Shift(force=driven), law, state=found.state)
        yield f"{k + 59}", "shift along x [mm]", printed, found.creepage[0] / MM


#: Undeformed distance at x = 0 of the rows y = -7.6 to 0 mm of a wheel in a groove of the rail [mm].
GROOVE = (
    "-.01060019 -.01864015 -.02628477 -.03352765 -.04036271 -.04678420 -.05278672 -.05836522 -.06351499 "
    "-.06823168 -.07251131 -.07635024 -.07974523 -.08269341 -.08519227 -.08723969 -.08883393 -.08997365 "
    "-.09065786 -.09088600"
)


def leaning(x: Array, s: Array) -> Array:
    """Rigid slip (2, ny, nx) of a wheel with a yaw on an arc (s) of the mean curvature of both surfaces."""
    bend = 0.5 * (1.0 / 10.0 + 1.0 / 10.2)
    lean = 0.25 * math.pi - bend * s
    along = -0.004 + (np.cos(lean) - math.cos(0.25 * math.pi)) / (bend * 460.0)
    across = -0.014 * np.cos(lean)[:, None] - np.outer(np.sin(lean), x) / 460.0
    return np.stack([np.repeat(along[:, None], x.size, axis=1), across])


def corner_and_root() -> list[mtb.Prism]:
    """Arcs of 10 mm that turn by 45 degrees between flat faces, held at a distance: the outline of CONTACT's
    finite elements is not printed, and this one has their contact cell by cell (studies/conformal.py)."""
    angle = 0.75 * math.pi + np.linspace(0.5, -0.5, 2001) * 0.25 * math.pi
    arc = 10.0 * MM * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    ahead = np.stack([np.sin(angle), -np.cos(angle)], axis=1)
    free = np.concatenate([[arc[0] - ahead[0]], arc, [arc[-1] + ahead[-1]]])
    bases = ([[1.0, -1.0]], [[1.0, 1.0], [-1.0, 1.0], [-1.0, -1.0]])
    return [mtb.Prism(free, material=STEEL, base=base, origin=tuple(arc[1000])) for base in bases]


def conformal() -> Iterator[Row]:
    x, y, creepage = symmetric(51, 0.4), symmetric(39, 0.4), (-0.004, -0.0098995, -0.0015372)
    half = np.array([float(value) for value in GROOVE.split()])
    across = np.concatenate([half, half[-2::-1]])
    gap = (0.00076859436 * x[None, :] ** 2 + across[:, None]) * MM
    normals = {
        "1": (pressed(x, y, (0.00076859, 0.00098039), approach=0.09089 * MM), "1.000E+05", "912.8", "1027"),
        "2": (pressed_gap(gap, (0.4, 0.4), approach=0.0), "9.184E+04", "1012.", "871"),
    }
    normals["4"] = normals["2"]
    forces = {
        "1": ("9144.", "2.592E+04", "3.860E+04"),
        "2": ("8959.", "2.417E+04", "2.676E+04"),
        "4": ("1.050E+04", "2.251E+04", "3.227E+04"),
    }
    for case, (normal, force, peak, cells) in normals.items():
        yield case, "normal force [N]", force, normal.normal_force
        yield case, "peak pressure [MPa]", peak, normal.pressure.max() / MPA
        yield case, "cells in contact", cells, touching(normal)
        if case == "4":
            found = mtb.solve_tangential(normal, mtb.Rolling(rigid_slip=leaning(x, y)), mtb.Coulomb(0.3))
        else:
            found = rolled(normal, creepage, 0.3)
        along, sideways, moment = forces[case]
        yield case, "force along x [N]", along, -found.force[0]
        yield case, "force along y [N]", sideways, -found.force[1]
        yield case, "moment about z [N mm]", moment, -found.spin_moment / MM
    corner, root = corner_and_root()
    side = 0.4 * MM
    normal = mtb.solve_normal(gap, side, lower=corner, upper=root, approach=0.0, edge="sharp")
    full = {
        "3": (
            mtb.Rolling((creepage[0], creepage[1], creepage[2] / MM)),
            "9.932E+04 1.086E+04 2.578E+04 3.292E+04 1034. 901",
        ),
        "5": (mtb.Rolling(rigid_slip=leaning(x, y)), "9.983E+04 1.270E+04 2.383E+04 4.039E+04 1040. 905"),
    }
    for case, (motion, printed) in full.items():
        found = mtb.solve_tangential(normal, motion, mtb.Coulomb(0.3), coupling="full")
        force, along, sideways, moment, peak, cells = printed.split()
        yield case, "normal force [N]", force, -found.force[2]
        yield case, "force along x [N]", along, -found.force[0]
        yield case, "force along y [N]", sideways, -found.force[1]
        yield case, "moment about z [N mm]", moment, -found.spin_moment / MM
        yield case, "peak pressure [MPa]", peak, found.pressure.max() / MPA
        yield case, "cells in contact", cells, touching(found)


def ertz_temperature() -> Iterator[Row]:
    # CONTACT's grid goes on behind the contact, where nothing is hotter; the spin turns about its origin
    normal = pressed(symmetric(79, 0.2), symmetric(45, 0.5), (0.001015, 0.0004215), force=100e3)
    yield from of_normal("1", normal, "8.190E-02", "770.6", "1969")
    steel = mtb.Conductor(50.0, 7850.0, 450.0)
    cases: dict[str, tuple[tuple[float, float, float], float, str]] = {
        "1": ((-0.03333, 0.0, 0.0), 0.0, "166.8"),
        "2": ((0.0, 0.0, 0.0), 150.0, "150.0"),
        "3": ((-0.03333, 0.0, 0.0), 150.0, "241.8"),
        "4": ((-0.002, 0.001, 0.0002), 150.0, "150.0"),
    }
    for case, (creepage, bulk, printed) in cases.items():
        found = rolled(normal, creepage, 0.3, angle=math.pi, velocity=30.0)
        heat = found.temperature(steel, steel, bulk=(bulk, 0.0))
        surfaces = np.stack([heat.temperature_lower, heat.temperature_upper])
        yield case, "highest temperature [K]", printed, surfaces.max()
        if case in "13":
            # CONTACT counts the heat of a cell in this very cell twice
            power = found.dissipation * 30.0
            twice = math.sqrt(0.5 * 0.2 * MM) * power / (steel.effusivity * math.sqrt(math.pi * 30.0))
            yield case, "the same, heat of its own cell twice [K]", printed, (surfaces + twice).max()
        if case == "4":
            yield case, "force along x [N]", "2.182E+04", -found.force[0]
            yield case, "force along y [N]", "-4476.", -found.force[1]
            yield case, "moment about z [N mm]", "-4.626E+04", -found.spin_moment / MM
            yield case, "cells that stick", "770", sticking(found)


def fastsim() -> Iterator[Row]:
    hertz = mtb.hertz(82e3, semi_axes=(8.0 * MM, 4.0 * MM), lower=STEEL, upper=STEEL)
    b1, b3 = (0.5 * k * MM for k in hertz.curvatures)
    yield "1", "curvature A1 [1/mm]", "0.8464E-03", b1
    yield "1", "curvature B1 [1/mm]", "0.2406E-02", b3
    normal = pressed(symmetric(44, 0.4), symmetric(44, 0.2), (b1, b3), force=82e3)
    yield from of_normal("1", normal, "9.266E-02", "1223.", "1276")
    found = rolled(normal, (0.0, -0.000625, 0.000625), 0.3)
    yield "1", "force along y [N]", "-1.494E+04", -found.force[1]
    yield "1", "moment about z [N mm]", "-4.821E+04", -found.spin_moment / MM
    yield "1", "cells that stick", "356", sticking(found)
    cases: dict[str, tuple[int, Any, str, str, str]] = {
        "2": (44, "parabolic", "-1.500E+04", "-3.904E+04", "742"),
        "3": (44, "elliptic", "-1.478E+04", "-4.828E+04", "622"),
        "4": (220, "elliptic", "-1.463E+04", "-4.529E+04", "16632"),
    }
    for case, (cells, bound, force, moment, stick) in cases.items():
        patch = hertz.on_grid((cells, cells), (17.6 * MM / cells, 8.8 * MM / cells))
        quick = mtb.fastsim(
            patch,
            (0.0, -0.000625, 0.625),
            mtb.Coulomb(0.3),
            bound,
            semi_axes=hertz.semi_axes,
            flexibilities="blended",
        )
        yield case, "force along y [N]", force, -quick.force[1]
        yield case, "moment about z [N mm]", moment, -quick.spin_moment / MM
        yield case, "cells that stick", stick, sticking(quick)


#: G3, tau_c0, k_tau [MPa, MPa, MPa/mm], shifts [mm], and forces at the cases of these numbers [N].
LAYERS: dict[str, tuple[tuple[float, float, float], list[float], int, dict[int, str]]] = {
    "magnetite": (
        (176.63, 560.0, 0.0),
        [0.035, 0.035, 0.03, *[0.05] * 10],
        2,
        {2: "280.0", 3: "560.0", 4: "560.0", 5: "560.0", 6: "560.0"},
    ),
    "clay": (
        (106.25, 200.0, 435.0),
        [*[0.04] * 4, 0.036, 0.0, -0.036, 0.0, 0.046, 0.044, *[0.05] * 7],
        15,
        {
            15: "200.0",
            16: "216.0",
            17: "232.0",
            18: "248.0",
            19: "262.4",
            20: "262.4",
            21: "82.43",
            23: "266.4",
        },
    ),
    "sand": (
        (176.63, 400.0, -195.0),
        [0.025, 0.025, *[0.05] * 11],
        32,
        {35: "380.0", 36: "370.0", 37: "360.0", 38: "350.0", 39: "340.0", 40: "330.0"},
    ),
    "molybdenum sulphide": (
        (20.238, 20.0, 20.4),
        [0.02, 0.04, 0.04, *[0.05] * 10],
        45,
        {50: "24.60", 51: "25.60", 52: "26.60", 53: "27.60", 54: "28.60", 55: "29.60"},
    ),
}


def plastic_3bl() -> Iterator[Row]:
    cell = mtb.PressureField(np.full((1, 1), 900.0 * MPA), (1.0 * MM, 1.0 * MM), STEEL, STEEL)
    bare = mtb.solve_tangential(cell, mtb.Shift((-0.001 * MM, 0.0)), mtb.Coulomb(0.7))
    yield "1", "force along x [N]", "84.97", -bare.force[0]
    for (modulus, first, hardening), shifts, case, printed in LAYERS.values():
        layer = mtb.PlasticLayer(0.02 * MM, modulus * MPA, first * MPA, hardening * MPA / MM)
        state = None
        for k, shift in enumerate(shifts):
            found = mtb.solve_tangential(
                cell, mtb.Shift((-shift * MM, 0.0)), mtb.Coulomb(0.7), layer, state=state
            )
            state = found.state
            if case + k in printed:
                yield f"{case + k}", "force along x [N]", printed[case + k], -found.force[0]


def spence35() -> Iterator[Row]:
    upper, lower, x = material(0.5, 0.0), material(1e5, 0.0), symmetric(45, 0.2)
    # approach, peak
    printed = {
        1: ("6.172E-05", "2.750E-04"),
        2: ("3.274E-04", "1.208E-03"),
        3: ("7.025E-04", "1.809E-03"),
        5: ("1.985E-03", "3.188E-03"),
        7: ("3.927E-03", "4.608E-03"),
        10: ("8.064E-03", "6.707E-03"),
        12: ("1.160E-02", "8.075E-03"),
        27: ("5.875E-02", "1.840E-02"),
        30: ("7.253E-02", "2.047E-02"),
        33: ("8.778E-02", "2.254E-02"),
        35: ("9.874E-02", "2.392E-02"),
    }
    state = None
    for k in range(1, 36):
        force = round((k / 45.0) ** 3, 6)
        # the grid lies 0.1 um off the middle, which decides about cells at the border
        normal = pressed(x + 1e-4, x + 1e-4, (0.004116, 0.004116), upper=upper, lower=lower, force=force)
        found = mtb.solve_tangential(normal, mtb.Shift(), mtb.Coulomb(0.2986), state=state, coupling="full")
        state = found.state
        if k in printed:
            yield f"{k}", "peak pressure [MPa]", printed[k][1], found.pressure.max() / MPA
    yield "35", "cells in contact", "921", touching(found)
    yield "35", "cells that stick", "225", sticking(found)
    middle = found.stress("upper", points=np.array([[0.0], [0.0], [1e-6 * MM]]))
    yield "35", "stress zz in the middle [MPa]", "-0.2392E-01", float(middle.zz[0]) / MPA
    yield "35", "stress xx in the middle [MPa]", "-0.1025E-02", float(middle.xx[0]) / MPA


def subsurf() -> Iterator[Row]:
    body = material(1.0, 0.28)
    cell = mtb.PressureField(np.full((1, 1), 1.0 * MPA), (1.0 * MM, 1.0 * MM), body, body)
    sides = [5.0, 3.0, 2.0, 1.0, 0.8, 0.6, 0.4, 0.3, 0.2, 0.1]
    across = np.array([*[-side for side in sides], 0.0, *sides[::-1]])
    deep = np.array([0.0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1.0, 1.25, 1.667, 2.5, 5.0])
    # the square lies a little off the middle, as in the example
    grid = np.stack(np.meshgrid(across - 1e-4, across - 2e-4, deep, indexing="ij")).reshape(3, -1)
    line = np.stack(np.meshgrid([1e-5 - 1e-4], [1e-5 - 2e-4], deep, indexing="ij")).reshape(3, -1)
    push = mtb.solve_tangential(cell, mtb.Shift(force=(-0.999, 0.0)), mtb.Coulomb(1.0))
    free = mtb.solve_tangential(cell, mtb.Shift(), mtb.Coulomb(1.0))
    printed = {
        ("1", "line"): ("-0.853", "0.665", "0.665", "0.008", "-1.000"),
        ("1", "block"): ("-0.853", "0.665", "0.696", "0.152", "-1.000"),
        ("2", "line"): ("-0.853", "1.744", "2.010", "0.115", "-1.895"),
        ("2", "block"): ("-1.337", "2.179", "2.494", "1.424", "-2.649"),
    }
    for (case, where), texts in printed.items():
        inside = (free if case == "1" else push).stress(
            "upper", points=(line if where == "line" else grid) * MM
        )
        principal = inside.principal()
        hydrostatic = (inside.xx + inside.yy + inside.zz) / 3.0
        values = (
            hydrostatic[np.abs(hydrostatic).argmax()],
            inside.von_mises.max(),
            (principal[0] - principal[2]).max(),
            principal[0].max(),
            principal[2].min(),
        )
        names = ("mean stress", "von Mises stress", "Tresca stress", "largest principal", "least principal")
        for name, text, value in zip(names, texts, values, strict=True):
            yield case, f"{name}, {where} [MPa]", text, float(value) / MPA


def tractcurv() -> Iterator[Row]:
    force = 106.7e3
    # the ellipse of the ratio 1 : 2 whose curvature along x is given
    guess = mtb.hertz(force, semi_axes=(6.0 * MM, 12.0 * MM), lower=STEEL, upper=STEEL)
    a = 6.0 * (0.5 * guess.curvatures[0] * MM / 0.0008) ** (1.0 / 3.0)
    hertz = mtb.hertz(force, semi_axes=(a * MM, 2.0 * a * MM), lower=STEEL, upper=STEEL)
    b1, b3 = (0.5 * k * MM for k in hertz.curvatures)
    cells = 2.2 * a / 48, 4.4 * a / 44
    yield "1", "semi-axis along x [mm]", "6.304", a
    normal = pressed(symmetric(48, cells[0]), symmetric(44, cells[1]), (b1, b3), force=force)
    yield from of_normal("1", normal, "7.651E-02", "640.7", "1384")
    for case, creepage, printed, stick in (
        ("1", 1e-5, "-247.0", "1382"),
        ("2", 4e-4, "-9112.", "1182"),
        ("3", 8e-4, "-1.670E+04", "976"),
        ("8", 2.8e-3, "-3.462E+04", "132"),
        ("9", 3.2e-3, "-3.513E+04", "32"),
        ("10", 3.6e-3, "-3.518E+04", "0"),
    ):
        found = rolled(normal, (creepage, 0.0, 0.0), 0.33)
        yield case, "force along x [N]", printed, -found.force[0]
        yield case, "cells that stick", stick, sticking(found)
    falling = mtb.FallingFriction(0.33, 0.14, 1.25, memory=0.003 * MM, memory_min_slip=1.0 * MM)
    layer = mtb.InterfaceLayer(1.25 * MM, 8200.0 * MPA)
    for case, creepage, printed, stick in (
        ("33", 2e-3, "-1.231E+04", "1250"),
        ("34", 3e-3, "-1.735E+04", "1124"),
        ("35", 4e-3, "-2.148E+04", "998"),
    ):
        found = mtb.solve_tangential(normal, mtb.Rolling((creepage, 0.0, 0.0), velocity=10.0), falling, layer)
        yield case, "force along x [N]", printed, -found.force[0]
        yield case, "cells that stick", stick, sticking(found)
    patch = hertz.on_grid((48, 44), (cells[0] * MM, cells[1] * MM))
    given: dict[str, Any] = {"semi_axes": hertz.semi_axes, "flexibilities": "blended", "velocity": 10.0}
    for case, creepage, printed in (
        ("64", 1.2e-3, "-2.211E+04"),
        ("65", 1.6e-3, "-2.648E+04"),
        ("66", 2e-3, "-2.969E+04"),
    ):
        quick = mtb.fastsim(patch, (creepage, 0.0, 0.0), mtb.Coulomb(0.33), "parabolic", **given)
        yield case, "force along x [N]", printed, -quick.force[0]
    slippery = mtb.FallingFriction(0.36, 0.1368, 0.99)
    for case, creepage, printed in (
        ("95", 4e-3, "-2.391E+04"),
        ("96", 5e-3, "-2.596E+04"),
        ("97", 6e-3, "-2.746E+04"),
    ):
        quick = mtb.fastsim(
            patch, (creepage, 0.0, 0.0), slippery, "parabolic", slope_reduction=(0.54, 0.02, 0.62), **given
        )
        yield case, "force along x [N]", printed, -quick.force[0]
    for case, creepage, slope, printed in (
        ("95", 4e-3, 0.3256, "-2.391E+04"),
        ("96", 5e-3, 0.2961, "-2.596E+04"),
        ("97", 6e-3, 0.2714, "-2.746E+04"),
    ):
        quick = mtb.fastsim(
            patch, (creepage, 0.0, 0.0), slippery, "parabolic", slope_reduction=(slope, 1.0, 1.0), **given
        )
        yield case, "the same, printed slope [N]", printed, -quick.force[0]


def veldep_fric() -> Iterator[Row]:
    x = centres(92, -4.6, 0.1)
    gap = (460.0 - np.sqrt(460.0**2 - x[None, :] ** 2)) * MM
    normal = pressed_gap(gap, (0.1, 200.0), force=622216.0)
    yield from of_normal("1", normal, "8.879E-02", "495.3", "81")
    law = mtb.FallingFriction(0.3, 0.18, 0.1)
    found = mtb.solve_tangential(normal, mtb.Rolling((-0.0009999, 0.0, 0.0), velocity=45.0), law)
    yield "1", "force along x [N]", "1.109E+05", -found.force[0]
    yield "1", "cells that stick", "45", sticking(found)
    step = mtb.Rolling((-0.001, 0.0, 0.0), velocity=45.0, transient=True, step=0.1 * MM)
    found = mtb.solve_tangential(normal, step, law, state=found.state)
    # one step from the steady state, to which CONTACT has two answers, with slip from below and from above
    yield "2", "force along x [N]", "1.116E+05", -found.force[0]
    yield "4", "force along x [N]", "1.064E+05", -found.force[0]
    yield "4", "cells that stick", "34", sticking(found)
    for case, printed, stick in (("5", "1.071E+05", "79"), ("6", "1.078E+05", "77")):
        found = mtb.solve_tangential(normal, step, law, state=found.state)
        yield case, "force along x [N]", printed, -found.force[0]
        yield case, "cells that stick", stick, sticking(found)


def visc_cylindr() -> Iterator[Row]:
    for case, modulus, creepage, approach, peak, cells, stick in (
        ("1", 571.5, "1.378E-02", "2.508", "60.32", "80", "51"),
        ("5", 571.5, "1.378E-02", "2.508", "60.32", "80", "51"),
        ("6", 1143.0, "9.792E-03", "1.324", "85.29", "56", "36"),
    ):
        normal = pressed(
            centres(99, -7.92, 0.16),
            np.zeros(1),
            (0.01, 0.0),
            1000.0,
            body=material(modulus, 0.4),
            force=600e3,
        )
        yield from of_normal(case, normal, approach, peak, cells)
        motion = mtb.Rolling(force=(0.6 * 0.3 * 600e3, 0.0), velocity=1.0)
        found = mtb.solve_tangential(normal, motion, mtb.Coulomb(0.3))
        yield case, "creepage", creepage, found.creepage[0]
        yield case, "cells that stick", stick, sticking(found)


COMPARED: dict[str, Callable[[], Iterator[Row]]] = {
    f.__name__: f
    for f in (
        bentall,
        carter2d,
        catt_to_cart,
        cattaneo,
        conformal,
        ertz_temperature,
        fastsim,
        plastic_3bl,
        spence35,
        subsurf,
        tractcurv,
        veldep_fric,
        visc_cylindr,
    )
} | coverage_wheels.COMPARED


def half_digit(printed: str) -> float:
    """Half of the last digit that is printed."""
    mantissa, _, power = printed.upper().partition("E")
    return float(0.5 * 10.0 ** (int(power or 0) - len(mantissa.partition(".")[2])))


def numbers(name: str) -> list[dict[str, Any]]:
    """Each number beside what is printed; `difference` is 0 within half of the last digit that is printed."""
    rows = []
    for case, quantity, printed, own, *scale in COMPARED[name]():
        there = float(printed)
        size = scale[0] if scale else abs(there)
        off = abs(own - there)
        whole = "." not in printed and off == 0.0
        within = whole or ("." in printed and off <= 1.0001 * half_digit(printed))
        rows.append(
            {
                "example": name,
                "case": case,
                "quantity": quantity,
                "printed": printed,
                "own": f"{own:.6g}",
                "difference": 0.0 if within else off / size if size else math.nan,
            }
        )
        print(
            f"{name:18} {case:>4} {quantity:42} {printed:>12} {own:13.6g} {rows[-1]['difference']:9.2e}",
            flush=True,
        )
    return rows


def summary(rows: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """A row an example: the verdict, with the largest difference and its quantity."""
    found = []
    for example in EXAMPLES:
        mine = [row for row in rows if row["example"] == example.name]
        outside = sorted((row for row in mine if row["difference"]), key=lambda row: -row["difference"])
        worst = outside[0] if outside else None
        if example.verdict == REPRODUCED and worst and worst["difference"] > ALLOWED:
            raise SystemExit(f"{example.name} is not reproduced: {worst}")
        answer = example.verdict
        if mine:
            answer += f": {len(mine) - len(outside)} of {len(mine)} numbers to all digits"
        if worst:
            what = worst["quantity"].partition(" [")[0]
            answer += f", others within {100.0 * worst['difference']:.2g} % ({what}, case {worst['case']})"
        found.append(
            {
                "example": example.name,
                "cases": example.cases,
                "computes": example.computes,
                "call": example.call,
                "verdict": example.verdict,
                "answer": answer,
                "remarked": "yes" if example.remark else "no",
                "remark": example.remark,
            }
        )
    return found


def write(name: str, rows: list[dict[str, Any]]) -> None:
    with (FOLDER / f"{name}.csv").open("w", encoding="utf-8", newline="") as file:
        writer = csv.DictWriter(file, list(rows[0]), lineterminator="\n")
        writer.writeheader()
        writer.writerows(rows)


def main(names: list[str]) -> None:
    warnings.simplefilter("ignore")  # moduli of a polymer and cells as wide as the contact are asked about
    rows = [row for name in names or COMPARED for row in numbers(name)]
    if not names:
        write("coverage_numbers", rows)
        write("coverage_differences", [row for row in rows if row["difference"] > TOLD])
        write("coverage", summary(rows))


if __name__ == "__main__":
    main(sys.argv[1:])
