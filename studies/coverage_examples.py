# SPDX-License-Identifier: MIT OR Apache-2.0
"""The published example inputs of CONTACT and the verdicts on them, for `coverage.py`; not run by itself."""

from __future__ import annotations

from typing import NamedTuple

REPRODUCED, IN_PART, NOT, NOT_RUN = "reproduced", "in part", "not expressible", "not run"


class Example(NamedTuple):
    """One input: how many cases it has, what they compute, the call that does it, and what is missing."""

    name: str
    cases: int
    computes: str
    call: str
    verdict: str
    remark: str = ""


EXAMPLES = (
    Example(
        "bentall",
        6,
        "rolling of unlike cylinders (aluminium on steel), force given; pressure and friction coupled",
        "solve_tangential with Rolling(force=..., angle=pi), coupling='full'",
        REPRODUCED,
    ),
    Example("carter2d", 1, "steady rolling of a cylinder", "solve_tangential with Rolling", REPRODUCED),
    Example(
        "catt_to_cart",
        171,
        "a shift, then transient rolling under a given force; the same by shifts on a fixed grid",
        "solve_tangential with Shift, then Rolling(transient=True), each with the state before",
        REPRODUCED,
        "the second half of the fixed grid and the grid that moves along, which repeat it, are not compared",
    ),
    Example(
        "cattaneo",
        2,
        "a ball pressed and then shifted by a given force",
        "solve_normal; solve_tangential with Shift(force=...)",
        REPRODUCED,
    ),
    Example(
        "conformal",
        5,
        "a wheel in a groove of the rail: parabolic and true distance, rigid slip that varies, "
        "influence of conformal bodies",
        "solve_normal on the given distance, of half-spaces or prisms; solve_tangential with Rolling",
        IN_PART,
        "the influences of cases 3 and 5 come from a file that is not public; prisms take its place, with "
        "arcs of a turn that is chosen to meet them (45 degrees)",
    ),
    Example(
        "ertz_temperature",
        4,
        "rolling with sliding; surface temperatures, also of a hot wheel",
        "solve_tangential with Rolling; temperature(bulk=...) of the result",
        IN_PART,
        "the contact agrees; temperatures of sliding are lower, because CONTACT counts the heat of a cell "
        "in this cell twice; counted so, 0.2 % are left",
    ),
    Example(
        "fastsim",
        6,
        "steady rolling with spin: full, then FASTSIM with both bounds on two grids, and turned round",
        "solve_tangential; fastsim(bound=..., flexibilities='blended')",
        REPRODUCED,
        "the full solution agrees in all digits; how FASTSIM blends its flexibilities has changed between "
        "revisions. Cases 5 and 6 are not compared",
    ),
    Example(
        "mbench_a22_kpec",
        9,
        "three positions of the Manchester benchmark with KPEC, with ANALYN, and in full",
        "WheelScene.prepare and step; solve_normal(method='kpec' or 'analyn') on wheel_on_rail_gap",
        IN_PART,
        "the full cases agree. Wheels in steps have no quick method. The bodies meet in two places beside "
        "each other, where KPEC is refused (1), and where ANALYN has the peak and another force (4). "
        "Cases 2, 3, 5, 6 and 9 are not compared",
    ),
    Example(
        "mbench_a22_left",
        21,
        "Manchester benchmark, left wheel: 21 lateral positions with yaw and roll, vertical force given",
        "scenes.wheel_on_rail, prepare, step",
        REPRODUCED,
        "5 positions are compared",
    ),
    Example(
        "mbench_a22_right",
        21,
        "Manchester benchmark, right wheel, up to its flange",
        "scenes.wheel_on_rail, prepare, step",
        REPRODUCED,
        "8 positions are compared",
    ),
    Example(
        "mbench_a22_varfric",
        5,
        "Manchester benchmark with friction by the inclination of the rail, and stresses below the contact",
        "prepare(friction=RailFriction(...)), step, stress of a patch",
        IN_PART,
        "friction varies over the contact as in CONTACT's curved contact (5); its plane contacts (3, 4) "
        "have one coefficient each, and in case 3 we have one contact where it has two",
    ),
    Example(
        "plastic_3bl",
        57,
        "one cell shifted step by step over layers that yield, harden and soften",
        "solve_tangential with Shift and PlasticLayer",
        REPRODUCED,
        "26 of 57 steps are compared, of all four materials",
    ),
    Example(
        "spence35",
        35,
        "a punch of unlike material pressed in 35 steps, pressure and friction coupled; stress below it",
        "solve_tangential with Shift and the state before, coupling='full'; stress of the result",
        REPRODUCED,
        "11 steps are compared",
    ),
    Example(
        "subsurf",
        2,
        "stress below a square under pressure, and under pressure and friction",
        "PressureField, solve_tangential, stress(points=...)",
        REPRODUCED,
    ),
    Example(
        "tractcurv",
        120,
        "traction curves: Coulomb; layer and falling friction with memory; FASTSIM; modified FASTSIM",
        "solve_tangential with Rolling, FallingFriction and InterfaceLayer; fastsim(slope_reduction=...)",
        IN_PART,
        "the first three curves agree; modified FASTSIM with falling friction does not: CONTACT prints "
        "slopes of 0.326, 0.296 and 0.271, ours are 0.377, 0.351 and 0.328. Why is open; with its slopes "
        "given 1.0 to 1.4 % are left. 15 points are compared",
    ),
    Example(
        "veldep_fric",
        104,
        "rolling with friction that falls with the slip speed, without memory: two answers to one step",
        "solve_tangential with Rolling and FallingFriction, transient=True",
        IN_PART,
        "the steady state and the steps with slip from above (1, 4, 5, 6) are; which answer a step takes "
        "cannot be chosen, so that case 2 is not met",
    ),
    Example(
        "visc_cylindr",
        6,
        "rolling of cylinders of a polymer, viscoelastic (4) and elastic (2), force given",
        "solve_normal with Viscoelastic and rolling, solve_tangential with Rolling(force=...)",
        IN_PART,
        "the elastic cases and that without relaxation (1, 5, 6) are compared here; viscoelastic bodies (2 "
        "to 4) are expressible, and are compared in the tests with own runs of CONTACT at two creep times",
    ),
    Example(
        "wheelflat",
        26,
        "a wheel with a flat at 26 angles of its rotation, vertical force given",
        "wheel_on_rail with WheelSlices, a given force",
        NOT_RUN,
        "WheelSlices takes wheels that vary around them; the sections of this wheel are files of the "
        "example, and have not been run",
    ),
)
