# SPDX-License-Identifier: MIT OR Apache-2.0
"""What noise of measured profiles makes of the peak pressure, raw and smoothed: a table of docs/profiles.md.

Usage: python studies/noisy_profiles.py [CELL]. Takes a minute; CELL [mm] is 0.25 if not given.
"""

import sys
import warnings

import numpy as np

import mtb_rs as mtb

NOISE, APART, WAVELENGTH, FORCE = 2e-6, 1e-4, 4e-3, 36e3
SHIFTS = (1e-3, 3e-3, 0.0, 6.2e-3)
CELL = 1e-3 * float(sys.argv[1]) if len(sys.argv) > 1 else 2.5e-4
EXACT = mtb.Profile.standard("S1002"), mtb.Profile.standard("60E1")

warnings.simplefilter("ignore")


def measured(profile, noise):
    """Points of a profile with noise of that size [m], as a function makes it."""
    low, high = profile.range
    y = np.arange(low + APART, high - APART, APART)
    return mtb.Profile.from_points(y, profile.height(y) + noise(y.size))


def peaks(wheel, rail):
    """Peak pressures [Pa] over the lateral shift."""
    found = []
    for shift in SHIFTS:
        scene = mtb.scenes.wheel_on_rail(wheel, rail, lateral=0.0, force=FORCE, spacing=CELL)
        step = scene.prepare().step([0.0, shift, np.nan, 0.0, 0.0, 0.0], 20.0)
        found.append(max(patch.pressure.max() for patch in step.patches))
    return np.array(found)


exact = peaks(*EXACT)
clean = peaks(*(measured(p, np.zeros).smoothed(WAVELENGTH) for p in EXACT)) / exact
raw, smooth = [], []
for seed in range(8):
    rng = np.random.default_rng(seed)
    pair = [measured(p, lambda n, rng=rng: NOISE * rng.standard_normal(n)) for p in EXACT]
    raw.append(peaks(*pair) / exact)
    smooth.append(peaks(*(p.smoothed(WAVELENGTH) for p in pair)) / exact)
print("shift [mm]  raw            smoothed       smoothed, without noise")
for k, shift in enumerate(SHIFTS):
    ends = [(np.min(found, axis=0)[k], np.max(found, axis=0)[k]) for found in (raw, smooth)]
    print(f"{1e3 * shift:10.1f}", *(f" {low:.2f} to {high:.2f}  " for low, high in ends), f" {clean[k]:.2f}")
