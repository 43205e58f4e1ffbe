# SPDX-License-Identifier: MIT OR Apache-2.0
"""Random lateral and vertical forces on new and worn wheels: how many are found, and how exactly.

Run `python studies/wheel_forces.py COUNT SEED`. Forces reach from sliding inwards on the tread to a flange
of 60 degrees. Some of them are beyond what friction and the contact angle carry; their message must say so.
"""

from __future__ import annotations

import sys
import time
import warnings
from collections import Counter

import numpy as np

import mtb_rs as mtb


def worn(profile: mtb.Profile, depth: float, at: float, width: float) -> mtb.Profile:
    """A profile from which a smooth hollow is worn off."""
    y = np.linspace(*profile.range, 900)
    z = profile.height(y)
    return mtb.Profile.from_points(y, z - depth * np.exp(-(((y - at) / width) ** 2)))


def main(count: int, seed: int) -> None:
    """Prints a line for each failure, and the shares."""
    random = np.random.default_rng(seed)
    wheel, rail = mtb.Profile.standard("S1002"), mtb.Profile.standard("60E1")
    wheels = {"new": wheel, "worn": worn(wheel, 1.5e-3, -0.005, 0.02)}
    found: Counter[str] = Counter()
    worst, solves, again = 0.0, [], []
    start = time.process_time()
    for k in range(count):
        kind = ("new", "worn")[k % 2]
        force, share = random.uniform(2e4, 1e5), random.uniform(-1.2, 1.2)
        yaw = random.uniform(-8e-3, 8e-3)
        side = ("left", "both")[random.integers(2)]
        if side == "left":
            # one wheel alone is pressed against its flange
            share, yaw = abs(share), abs(yaw)
        pair = mtb.scenes.wheel_on_rail(
            wheel=wheels[kind], rail=rail, lateral=0.0, force=force, spacing=1.5e-3
        )
        contact = pair.prepare(side=side, friction=mtb.Coulomb(0.3))
        pose = [0.0, np.nan, np.nan, np.nan if side == "both" else 0.0, 0.0, yaw]
        try:
            step = contact.step(pose, 20.0, lateral_force=share * force)
        except mtb.ConvergenceError as error:
            found["refused, no force so large" if "gets no nearer" in str(error) else "failed"] += 1
            print(f"{k} {kind} {side} {force:.0f} N, {share:.3f}, yaw {1e3 * yaw:.1f} mrad: {error}")
            continue
        found["found"] += 1
        worst = max(worst, abs(step.balance_error or 0.0))
        solves.append(step.report.normal_solves)
        try:
            again.append(contact.step(pose, 20.0, lateral_force=(share + 0.002) * force).report.normal_solves)
        except mtb.ConvergenceError as error:
            print(f"{k} {kind} {side}, the next step: {error}")
    print(dict(found), f"of {count}; largest departure {worst:.1e} of the vertical force")
    print(f"normal problems: first step {np.median(solves):.0f}, next step {np.median(again):.0f} (medians)")
    print(f"{time.process_time() - start:.0f} s of processor time")


if __name__ == "__main__":
    warnings.simplefilter("ignore")
    main(*(int(argument) for argument in sys.argv[1:3]))
