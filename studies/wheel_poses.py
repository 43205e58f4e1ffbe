# SPDX-License-Identifier: MIT OR Apache-2.0
"""Random poses of wheels and wheelsets, new and worn: how many have a height, and what stops the others.

Run `python studies/wheel_poses.py COUNT SEED`, with `conformal` after it for patches that follow the rail.
Lateral shifts reach from the tread to the flange, with yaw, random vertical force, creepage and friction;
height (and roll) are found from the vertical force. A pose without a height must be refused with its cause.
"""

from __future__ import annotations

import sys
import time
import warnings
from collections import Counter

import numpy as np
from wheel_forces import worn

import mtb_rs as mtb

#: What a message says of a pose that no program could solve, and that is not a failure of the search.
CAUSES = {
    "reaches the end of": "a contact reaches the end of a profile",
    "jumps": "the vertical force jumps over the one asked for",
    "friction": "friction and contact angle carry no such force",
}


#: Departure from the vertical force, over it, up to which it is carried; it jumps where more is left.
CARRIED = 1e-8


def profiles() -> dict[str, tuple[mtb.Profile, mtb.Profile]]:
    """Wheel and rail, new, with a hollow wheel, with a worn gauge corner, and with both."""
    wheel, rail = mtb.Profile.standard("S1002"), mtb.Profile.standard("60E1")
    hollow, rounded = worn(wheel, 1.5e-3, -0.005, 0.02), worn(rail, 0.8e-3, -0.022, 0.012)
    return {
        "new": (wheel, rail),
        "hollow": (hollow, rail),
        "corner": (wheel, rounded),
        "both": (hollow, rounded),
    }


def main(count: int, seed: int, *, conformal: bool) -> None:
    """Prints a line for each pose without a height, and the shares."""
    random = np.random.default_rng(seed)
    pairs = list(profiles().items())
    outcomes: Counter[str] = Counter()
    departures, solves = [], []
    start = time.process_time()
    for k in range(count):
        kind, (wheel, rail) = pairs[k % len(pairs)]
        force, side = random.uniform(2e4, 1.2e5), ("left", "both")[random.integers(2)]
        y, yaw = random.uniform(-8e-3, 8e-3), random.uniform(-1.5e-2, 1.5e-2)
        mu = random.uniform(0.1, 0.5)
        velocity = np.array([20.0, *0.05 * random.uniform(-1.0, 1.0, 2), 0.0, 0.0, 0.0])
        velocity[4] = 20.0 / 0.46 * (1.0 + 5e-3 * random.uniform(-1.0, 1.0))
        scene = mtb.scenes.wheel_on_rail(wheel=wheel, rail=rail, lateral=0.0, force=force, spacing=1e-3)
        contact = scene.prepare(side=side, friction=mtb.Coulomb(mu), conformal=conformal)
        roll = np.nan if side == "both" else random.uniform(-2e-3, 2e-3)
        pose = [0.0, y, np.nan, roll, 0.0, yaw]
        try:
            step = contact.step(pose, velocity)
        except (mtb.ConvergenceError, ValueError) as error:
            cause = next((name for word, name in CAUSES.items() if word in str(error)), "no cause named")
            outcomes[cause] += 1
            print(
                f"{k} {kind} {side} {force:.0f} N, y {1e3 * y:.3f} mm, yaw {1e3 * yaw:.2f} mrad, "
                f"mu {mu:.3f}: {error}",
                flush=True,
            )
            continue
        outcomes["found"] += 1
        solves.append(step.report.normal_solves)
        departures.append(abs(step.balance_error or 0.0))
    far = np.array([departure for departure in departures if departure > CARRIED])
    print(
        dict(outcomes), f"of {count}; {far.size} off the vertical force by {far.max(initial=0.0):.1e} at most"
    )
    print(f"normal problems a first step: {np.median(solves):.0f} (median), {max(solves)} (most)")
    print(f"{time.process_time() - start:.0f} s of processor time")


if __name__ == "__main__":
    warnings.simplefilter("ignore")
    main(*(int(argument) for argument in sys.argv[1:3]), conformal="conformal" in sys.argv[3:])
