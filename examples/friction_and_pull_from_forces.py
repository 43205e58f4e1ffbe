# SPDX-License-Identifier: MIT OR Apache-2.0
"""Which friction and which magnetic pull belong to measured brake forces? A fit with exact derivatives.

A shoe slides at 60 velocities; force and moment on the rail are measured, with noise. Wanted are the 20
values of a friction table over the velocity, and the magnetic pressure: the mean of each pole, and the slope
along the rail, which both share (from force and moment nobody can tell two slopes). Every step of the contact
gives the derivatives of its load by its friction and by the pull at each point, so that SciPy's
`least_squares` never takes a difference. The measurements are synthetic: the same model makes them, with
other numbers.

The number to compare with is the truth that made them. Without noise the fit finds it to rounding; with noise
the bounds that the fit gives (95 %) hold it in about 19 of 20 cases.

What to see: above, the friction table that was found (dots) on the one that made the measurements (line);
below, by how much each of its values is off, with its bounds. The first value, which few measurements see, is
known least.

Usage: friction_and_pull_from_forces.py [-o DIRECTORY]. Needs SciPy (extra `mesh`).
"""

import argparse

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
from scipy.optimize import least_squares

import mtb_rs as mtb
from mtb_rs.base.files import output_folder

plt.style.use("mtb_rs.pictures")
parser = argparse.ArgumentParser(description=__doc__)
parser.add_argument("-o", "--output", type=output_folder, default=".", help="directory of the picture")
output = parser.parse_args().output

scene = mtb.scenes.pole_shoe_on_rail(friction=0.2, magnetic_pressure=3e6, spacing=6e-3)
contact = scene.prepare("elastic-upper", reference_point=(0.0, 0.0, 28.2e-3))
x, y, _ = contact.points
along = x / np.abs(x).max()
#: What a unit of each parameter of the pull adds at each point: means of the left and the right pole, slope.
MODES = np.array([(y > 0.0), (y < 0.0), along], dtype=float)

knots = np.linspace(0.0, 50.0, 20)
true_friction = 0.11 + 0.24 * np.exp(-knots / 7.0) + 0.01 * np.sin(0.35 * knots)
true_pull = np.array([3.1e6, 2.7e6, 2.5e5])
TRUTH = np.concatenate([true_friction, true_pull])
#: Sizes by which the parameters are scaled, so that all are alike.
SIZE = np.concatenate([np.full(20, 0.1), np.full(3, 1e6)])
random = np.random.default_rng(1)
speeds = np.sort(random.uniform(0.5, 49.5, 60))
#: How much each measured number weighs: a thousandth of a typical brake force [N] and moment [N m].
NOISE = 1e-3 * np.array([2e3, 1e4, 2e2, 2e2])


def load(values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Force along x and z, moment about x and y at all speeds (60, 4), and their derivatives (60, 4, 23)."""
    friction, pull = values[:20], values[20:] @ MODES
    found, slopes = [], []
    for speed in speeds:
        share = np.maximum(0.0, 1.0 - np.abs(knots - speed) / (knots[1] - knots[0]))  # of each knot
        step = contact.step(velocity=speed, magnetic_pressure=pull, friction=share @ friction)
        force, moment = step.gradient("force"), step.gradient("moment")
        by = [
            np.concatenate([np.outer(g["friction"], share), g["magnetic_pressure_field"] @ MODES.T], axis=1)
            for g in (force, moment)
        ]
        found.append([step.force[0], step.force[2], step.moment[0], step.moment[1]])
        slopes.append(np.stack([by[0][0], by[0][2], by[1][0], by[1][1]]))
    return np.array(found), np.array(slopes)


def fit(measured: np.ndarray) -> tuple[np.ndarray, np.ndarray, int]:
    """The parameters, their 95 % bounds, and how often the loads were computed."""
    known: dict[bytes, tuple[np.ndarray, np.ndarray]] = {}

    def at(scaled: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        if scaled.tobytes() not in known:
            known[scaled.tobytes()] = load(scaled * SIZE)
        return known[scaled.tobytes()]

    found = least_squares(
        lambda s: ((at(s)[0] - measured) / NOISE).ravel(),
        np.concatenate([np.full(20, 2.0), [3.0, 3.0, 0.0]]),
        jac=lambda s: (at(s)[1] * SIZE / NOISE[:, None]).reshape(-1, 23),
        # within these the shoe neither lifts off nor wedges
        bounds=np.repeat([[0.1, 1.0, -1.0], [8.0, 6.0, 1.0]], [20, 2, 1], axis=1),
        xtol=1e-12,
        ftol=1e-12,
    )
    spread = np.sqrt(np.diag(np.linalg.inv(found.jac.T @ found.jac)))
    return found.x * SIZE, 1.96 * spread * SIZE, len(known)


exact, _ = load(TRUTH)
clean, _, evaluations = fit(exact)
clean_error = float(np.abs(clean / TRUTH - 1.0).max())
print(f"without noise: the largest relative error is {clean_error:.1e} after {evaluations} evaluations")
noisy, bounds, noisy_evaluations = fit(exact + NOISE * random.standard_normal(exact.shape))
inside = int((np.abs(noisy - TRUTH) <= bounds).sum())
print(f"with noise of 0.1 %: {inside} of {TRUTH.size} parameters within their 95 % bounds")
print("v [m/s]   true   found   bound")
for k in range(0, 20, 4):
    print(f"{knots[k]:7.1f}  {TRUTH[k]:.4f}  {noisy[k]:.4f}  {bounds[k]:.4f}")
for k, name in enumerate(("left", "right", "slope"), 20):
    print(f"pull, {name:5}: {TRUTH[k] / 1e6:.4f}, found {noisy[k] / 1e6:.4f} +- {bounds[k] / 1e6:.4f} MPa")

figure, (above, below) = plt.subplots(2, 1, figsize=(7.4, 5.6), sharex=True, layout="constrained")
above.plot(knots, true_friction, "-", label="truth")
above.plot(knots, noisy[:20], "o", ms=4, label="found")
above.set_ylabel("friction coefficient [-]")
above.legend()
below.axhline(0.0, color="black", lw=0.8)
below.errorbar(knots, 1e3 * (noisy - TRUTH)[:20], 1e3 * bounds[:20], fmt="o", ms=4, capsize=3, color="C1")
below.set(xlabel="velocity [m/s]", ylabel="found minus truth [0.001]")
figure.savefig(f"{output}/friction_and_pull_from_forces.png")
