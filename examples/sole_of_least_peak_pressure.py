# SPDX-License-Identifier: MIT OR Apache-2.0
"""Which profile gives a pole shoe the least peak pressure? A gap at each point, by gradients.

A flat sole that slides is pressed hardest at its front edge. Material may be taken off anywhere; how much, at
each contact point, is the unknown. The gradient of a number by all gaps costs one transposed solve with the
factors of the step, so that SciPy's `minimize` (L-BFGS-B) needs as many solves as it takes iterations; by
differences each iteration would need one solve a point. The peak itself has kinks; what is minimised is the
norm of the pressure to a power that rises to 32, which is close to it and smooth.

The number to compare with is the mean pressure over the sole: no profile can have a smaller peak.

What to see: the left pole. Above, the flat sole, whose front (right) carries the peak; in the middle, the
best sole: three quarters of it are pressed evenly, and the rear, from which friction lifts it, carries
nothing; below, what was taken off, a micrometre or so.

Usage: sole_of_least_peak_pressure.py [-o DIRECTORY]. Needs SciPy (extra `mesh`).
"""

import argparse

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
from scipy.optimize import minimize

import mtb_rs as mtb
from mtb_rs.base.files import output_folder

plt.style.use("mtb_rs.pictures")
parser = argparse.ArgumentParser(description=__doc__)
parser.add_argument("-o", "--output", type=output_folder, default=".", help="directory of the picture")
output = parser.parse_args().output

#: Of the norm: the peak itself has kinks, on which a search by gradients gets stuck.
POWERS = (4, 8, 16, 32)
scene = mtb.scenes.pole_shoe_on_rail(spacing=2.8e-3, friction=0.25, magnetic_pressure=3e6)
contact = scene.prepare("elastic-upper")
area, count = contact.area, contact.area.size
solves = 0


def norm(micrometres: np.ndarray, power: int) -> tuple[float, np.ndarray]:
    """Norm of the pressure [MPa] under a sole with these gaps (n,) [um], and its gradient."""
    global solves
    solves += 1
    step = contact.step(gap=1e-6 * micrometres)
    share = area / area.sum()
    top = step.pressure.max()
    mean = float((share * (step.pressure / top) ** power).sum())
    value = top * mean ** (1.0 / power)
    weights = value / mean * share * (step.pressure / top) ** (power - 1) / top
    return value / 1e6, 1e-6 * step.derivative({"pressure": weights}, "gap") / 1e6


flat = contact.step()
taken_off = np.zeros(count)
for power in POWERS:
    found = minimize(
        norm,
        taken_off,
        args=(power,),
        jac=True,
        method="L-BFGS-B",
        bounds=[(0.0, 20.0)] * count,
        options={"maxiter": 150, "ftol": 1e-10},
    )
    taken_off = found.x
best = contact.step(gap=1e-6 * taken_off)
carried = {name: float(step.pressure @ area) for name, step in (("flat", flat), ("best", best))}
mean = {name: force / float(area.sum()) for name, force in carried.items()}
peak = {"flat": float(flat.pressure.max()), "best": float(best.pressure.max())}
print(
    f"{count} gaps, {solves} solves and gradients; by differences they would be {solves * (count + 1)} solves"
)
for name in ("flat", "best"):
    print(
        f"{name} sole: peak {peak[name] / 1e6:.2f} MPa, mean {mean[name] / 1e6:.2f} MPa, "
        f"peak over mean {peak[name] / mean[name]:.2f}"
    )
print(f"taken off: up to {taken_off.max():.1f} um, {taken_off.mean():.2f} um on average")

patch = flat.patches[0]
along, across = (1e3 * patch.view(contact.points[k]) for k in (0, 1))
figure, axes = plt.subplots(3, 1, figsize=(7.4, 6.4), sharex=True, layout="constrained")
top = 2.5 * mean["flat"] / 1e6
pictures = (
    ("flat sole: pressure [MPa]", flat.pressure / 1e6, top),
    ("best sole: pressure [MPa]", best.pressure / 1e6, top),
    ("taken off [um]", taken_off, None),
)
for axis, (title, values, largest) in zip(axes, pictures, strict=True):
    image = axis.pcolormesh(along, across, patch.view(values), vmin=0.0, vmax=largest, shading="nearest")
    axis.set(title=title, ylabel="y [mm]")
    figure.colorbar(image, ax=axis, extend="max" if largest else "neither")
axes[-1].set_xlabel("x [mm]")
figure.savefig(f"{output}/sole_of_least_peak_pressure.png")
