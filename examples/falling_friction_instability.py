# SPDX-License-Identifier: MIT OR Apache-2.0
"""Friction that falls with slip breaks up transient rolling; a memory of it heals [Vollebregt2012, fig. 5].

A cylinder starts to roll at a fixed creepage. Where friction falls fast and without a memory the traction
collapses again and again, on any grid; where it falls slowly, it does not; where no state is found the
solver says so. In steady rolling the half-space alone is at rest, while with a soft layer there are
creepages for which no state is found, and in FASTSIM cells stick again behind cells that slip.

What to see: top, with a fast fall and no memory the force collapses again and again (saw teeth). Middle, the
traction during one collapse, in consecutive steps. Bottom, steady rolling: the line with a layer has a hole
at the creepages for which no state is found.
"""

import argparse

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

import mtb_rs as mtb
from mtb_rs.base.files import output_folder
from mtb_rs.half_space import reference

plt.style.use("mtb_rs.pictures")
parser = argparse.ArgumentParser(description=__doc__)
parser.add_argument("-o", "--output", type=output_folder, default=".", help="directory of the picture")
output = parser.parse_args().output

a, peak, speed, creepage = 3e-3, 0.6e9, 10.0, 2.5e-3  # m, Pa, m/s
load = 0.5 * np.pi * a * peak
body = mtb.Material.from_shear_modulus(82e9, 0.28)


def start_rolling(n: int, half_slip: float, memory: float | None) -> tuple[np.ndarray, list, int | None]:
    """Force over load by step, the steps, and the step at which no state was found."""
    patch = reference.line_pressure(load, a, n, body, body)
    law = mtb.FallingFriction(static=0.33, kinetic=0.14, half_slip=half_slip, memory=memory)
    motion = mtb.Rolling(creepage=(creepage, 0.0, 0.0), transient=True, velocity=speed)
    steps: list = []
    for k in range(3 * n):
        try:
            steps.append(mtb.solve_tangential(patch, motion, law, state=steps[-1].state if steps else None))
        except mtb.ConvergenceError:
            return np.array([s.force[0] / load for s in steps]), steps, k
    return np.array([s.force[0] / load for s in steps]), steps, None


def largest_fall(force: np.ndarray) -> float:
    """Largest fall of the force over load within one step."""
    return float(max(0.0, -np.diff(force).min()))


cases = {
    "coarse grid, slow fall, no memory": (20, 1.25, None),
    "fine grid, slow fall, no memory": (50, 1.25, None),
    "coarse grid, fast fall, no memory": (20, 0.02, None),
    "fine grid, fast fall, no memory": (50, 0.02, None),
    "fine grid, fast fall, memory 100 µm": (50, 0.02, 1e-4),
}
collapse, stopped = {}, {}
#: the stable ones lie on one another
dashes = {1.25: "-", 0.02: "--"}
figure, plots = plt.subplots(3, 1, figsize=(7.4, 10.5), height_ratios=(1.25, 1, 1))
for label, (n, half_slip, memory) in cases.items():
    force, steps, stop = start_rolling(n, half_slip, memory)
    collapse[label], stopped[label] = largest_fall(force), stop
    distance = np.arange(1, len(force) + 1) * 2.0 / n
    style = ":" if memory else dashes[half_slip]
    (line,) = plots[0].plot(distance, force, style, lw=3.0 if memory else 1.5, label=label)
    if stop is not None:
        plots[0].plot(distance[-1:], force[-1:], "x", color=line.get_color(), ms=9)
    if label == "coarse grid, fast fall, no memory":
        x = steps[0].points[0, 0] / a
        plots[1].plot(x, steps[0].pressure[0] * 0.33e-6, "k--", lw=1, label="bound at rest")
        worst = int(np.argmin(np.diff(force))) + 1
        for k in range(worst - 1, min(worst + 3, len(steps))):
            plots[1].plot(x, steps[k].traction[0, 0] * 1e-6, ".-", label=f"step {k + 1}")
plots[0].set(
    xlabel="distance rolled / a",
    title=r"$F_x / F_n$, rolling from rest at a creepage of 0.25 %; x: no state found",
    ylim=(None, 0.52),
)
plots[0].legend(loc="upper left", ncols=2)
plots[1].set(xlabel="x / a", title="traction [MPa]: a collapse, and the peak that travels after it")
plots[1].legend()

# steady rolling: neighbouring creepages must have neighbouring forces
sphere = reference.elliptic_pressure(106.7e3, (6.3e-3, 12.6e-3), (24, 24), body, body)
law = mtb.FallingFriction(static=0.33, kinetic=0.14, half_slip=0.1)
creepages = np.linspace(0.002, 0.04, 20)
rows = np.stack([creepages, 0 * creepages, 0 * creepages], axis=1)


def steady(layer: mtb.InterfaceLayer | None) -> np.ndarray:
    forces = []
    for row in rows:
        try:
            roll = mtb.solve_tangential(
                sphere, mtb.Rolling(creepage=tuple(row), velocity=speed), law, layer=layer
            )
            forces.append(roll.force[0] / 106.7e3)
        except mtb.ConvergenceError:
            forces.append(np.nan)
    return np.array(forces)


half_space, layered = steady(None), steady(mtb.InterfaceLayer(12.5e-3, 82e9))
simplified = mtb.fastsim_curve(sphere, rows, law, bound="elliptic", velocity=speed)[:, 0] / 106.7e3
# cells of FASTSIM that stick behind one that slips: traction that chatters along its strip
chatter = 0
for row in rows:
    status = mtb.fastsim(sphere, tuple(row), law, bound="elliptic", velocity=speed).status
    chatter += int(np.count_nonzero((status[:, 1:] == 2) & (status[:, :-1] == 1)))
not_found = {"half-space": int(np.isnan(half_space).sum()), "layer": int(np.isnan(layered).sum())}
for label, forces in {"half-space": half_space, "with a layer": layered, "FASTSIM": simplified}.items():
    plots[2].plot(100 * creepages, forces, ".-", ms=4, label=f"{label}, {np.isnan(forces).sum()} not found")
plots[2].set(xlabel="creepage [%]", title=r"$F_x / F_n$, steady rolling, fast fall, no memory")
plots[2].legend()
figure.savefig(output / "falling_friction_instability.png")
print(f"steady rolling without a state: {not_found}; FASTSIM sticks again in {chatter} cells")
for label in cases:
    stop = "" if stopped[label] is None else f", no state found at step {stopped[label] + 1}"
    print(f"{label}: largest fall within a step {collapse[label]:.3f} F_n{stop}")
