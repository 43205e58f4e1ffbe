# SPDX-License-Identifier: MIT OR Apache-2.0
"""What does a step of a shoe that slides, heats, expands and wears cost, and where does the time go?

A pole shoe of 3 mm wide elements, one pole and two, in equal steps, and in steps whose lengths a tolerance
chooses, above the thermal limit, where hot spots grow: a step accepted then pays for those refused. Times
are of the processor, all threads together: medians over the steps without the first ones, which condense
the matrices of their length, the least of three rides, as other programs may run. Beside them stands that
of a sliding step of the same prepared contact. The parts are those of a profile, which is slower by its own
work: the contact problem with its thermal terms (one factorisation in each change of the contact area), the
heat of the bodies (a forward and a backward substitution in the sparse factors of each), and the dense
products by which heat opens the gap. Writes docs/charts/heated_steps.csv.
"""

from __future__ import annotations

import cProfile
import pstats
import time
import warnings
from pathlib import Path
from typing import Any

import numpy as np
import records

import mtb_rs as mtb

OUT = Path(__file__).parents[1] / "docs" / "charts" / "heated_steps.csv"
ALL = {"expansion": True, "wear": 1e-13, "resistance": 1e-5, "share": 0.0}
EFFECTS: dict[str, dict[str, Any]] = {
    "heat": {},
    "heat and wear": {"wear": 1e-13},
    "and expansion": ALL,
    "and expansion, by tolerance": ALL | {"resistance": 0.0, "share": 0.5, "tolerance": 0.1},
}
#: Of the profile: names of functions by what they do.
PARTS = {
    "contact_ms": ("slide_heated",),
    "conduction_ms": ("coast", "observe_coasted", "end", "advance", "observe"),
    "products_ms": ("seen_coasted",),
}
STEPS, DURATION, SKIPPED = 96, 3.0, 8

warnings.simplefilter("ignore")  # that steps are too long is no matter here


def step_times(shoe: mtb.Scene, given: dict[str, Any]) -> np.ndarray:
    """Processor times [ms] of the steps."""
    at: list[float] = []
    shoe.sliding_heat(DURATION, STEPS, progress=lambda _: at.append(time.process_time()), **given)
    return 1e3 * np.diff(at)[SKIPPED:]


def parts(shoe: mtb.Scene, given: dict[str, Any]) -> dict[str, float]:
    """Time [ms] of the parts of a step."""
    profile = cProfile.Profile()
    profile.enable()
    steps = len(shoe.sliding_heat(DURATION, STEPS, **given).time)
    profile.disable()
    stats: Any = pstats.Stats(profile)
    own: dict[str, float] = dict.fromkeys(PARTS, 0.0)
    for (_, _, name), (_, _, spent, _, _) in stats.stats.items():
        for part, names in PARTS.items():
            if any(name == known or f"'{known}'" in name for known in names):
                own[part] += 1e3 * spent / steps
    return own


rows = []
for poles in (1, 2):
    shoe = mtb.scenes.pole_shoe_on_rail(
        friction=0.12, magnetic_pressure=2.5e6, velocity=20.0, spacing=3e-3, poles=poles
    )
    contact = shoe.prepare("elastic-upper")
    contact.step(velocity=20.0)
    clock = time.process_time()
    for k in range(200):
        contact.step(velocity=20.0, magnetic_pressure=2.5e6 * (1.0 + 1e-3 * np.sin(k)))
    sliding = 1e3 * (time.process_time() - clock) / 200
    for effects, given in EFFECTS.items():
        least = min(float(np.median(step_times(shoe, given))) for _ in range(3))
        found = {"step_ms": least, **parts(shoe, given), "sliding_ms": sliding}
        rows.append(
            {
                "poles": poles,
                "points": contact.area.size,
                "nodes": sum(body.size for body in shoe.sliding_heat(1e-3, 1).bodies),
                "effects": effects,
                **{name: f"{value:.3g}" for name, value in found.items()},
            }
        )
records.write(OUT, rows)
