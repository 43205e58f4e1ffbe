# SPDX-License-Identifier: MIT OR Apache-2.0
"""A ball on a layer of finite thickness by ContactMechanics, for `tests/validation/test_layered.py`.

Needs the extra `bench`. ContactMechanics has a layer on a rigid flat [CarboneMangialardi2008], to which it is
bonded, under pressures that repeat themselves. Its numbers are in any units; mm, N and MPa are taken.

    python benches/finite_thickness.py > tests/data/layer/finite_thickness.json
"""

from __future__ import annotations

import json
from importlib.metadata import version
from typing import Any

import numpy as np

SIDE, CELLS, RADIUS, FORCE, YOUNG_MODULUS = 1.0, 64, 5.0, 0.05, 5.0
TOLERANCE = 1e-12


def pressed(thickness: float, poisson_ratio: float) -> dict[str, Any]:
    """One contact: pressures [MPa] on the line through the middle, and how far the ball came down [mm]."""
    from ContactMechanics import PeriodicFFTElasticHalfSpace
    from ContactMechanics.Systems import NonSmoothContactSystem
    from SurfaceTopography import Topography

    x = (np.arange(CELLS) - CELLS // 2) * SIDE / CELLS
    height = -(x[:, None] ** 2 + x[None] ** 2) / (2.0 * RADIUS)
    substrate = PeriodicFFTElasticHalfSpace(
        (CELLS, CELLS), YOUNG_MODULUS, (SIDE, SIDE), thickness=thickness, poisson=poisson_ratio
    )
    system = NonSmoothContactSystem(substrate, Topography(height, (SIDE, SIDE)))
    found = system.minimize_proxy(external_force=FORCE, pentol=TOLERANCE, maxiter=3000)
    if not found.success:
        raise SystemExit(f"a thickness of {thickness}: {found.message}")
    pressure = np.asarray(found.jac) / (SIDE / CELLS) ** 2
    return {
        "thickness": thickness,
        "poisson_ratio": poisson_ratio,
        "approach": float(system.offset),
        "share_in_contact": float((pressure > 0.0).mean()),
        "pressure": pressure[CELLS // 2].tolist(),
    }


if __name__ == "__main__":
    cases = [pressed(h, nu) for nu in (0.3, 0.45) for h in (0.05, 0.25, 2.0)]
    print(
        json.dumps(
            {
                "program": f"ContactMechanics {version('ContactMechanics')}",
                "script": "benches/finite_thickness.py",
                "units": "mm, N, MPa",
                "side": SIDE,
                "cells": CELLS,
                "radius": RADIUS,
                "force": FORCE,
                "young_modulus": YOUNG_MODULUS,
                "tolerance": TOLERANCE,
                "cases": cases,
            },
            indent=1,
        )
    )
