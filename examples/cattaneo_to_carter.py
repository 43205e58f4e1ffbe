# SPDX-License-Identifier: MIT OR Apache-2.0
"""From rest to rolling: a ball is pushed, then rolls at constant tangential force until nothing changes.

What to see: the traction is symmetric after the push (dark) and moves to the trailing, left side as the ball
rolls (towards yellow). The creepage, which keeps the force constant, overshoots once and settles at Carter's
value.
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

a, load, friction, n = 3.205e-3, 1e4, 0.3, 41  # m, N
body = mtb.Material.from_shear_modulus(82e9, 0.28)
law = mtb.Coulomb(friction)
patch = reference.elliptic_pressure(load, (a, a), (n, n), body, body)
force = (0.657 * friction * load, None)

step = mtb.solve_tangential(patch, mtb.Shift(force=force), law)
steps = [step]
for _ in range(80):
    step = mtb.solve_tangential(patch, mtb.Rolling(force=force, transient=True), law, state=step.state)
    steps.append(step)
steady = mtb.solve_tangential(patch, mtb.Rolling(force=force), law)
creepage = np.array([s.creepage[0] for s in steps[1:]])
distance = patch.spacing[0] / a * np.arange(1, len(steps))

figure, (left, right) = plt.subplots(2, 1, figsize=(7.4, 6.6), height_ratios=(1.5, 1))
x = step.points[0, n // 2] / a
left.plot(x, friction * patch.pressure[n // 2] * 1e-6, "k--", lw=1, label="bound")
for k in (0, 2, 5, 10, 20, 40, 80):
    label = "pushed (Cattaneo)" if k == 0 else f"rolled {k * patch.spacing[0] / a:.1f} a"
    color = plt.cm.viridis(k**0.5 / 80**0.5)
    left.plot(x, steps[k].traction[0, n // 2] * 1e-6, color=color, label=label)
left.set(xlabel="x / a, rolling to the right", title="traction along the middle [MPa]", xlim=(-1.05, 1.7))
left.legend(loc="upper right")
right.plot(distance, 1e3 * creepage, label="transient")
right.axhline(1e3 * steady.creepage[0], color="k", ls=":", label="steady rolling (Carter)")
right.set(xlabel="distance rolled / a", title="creepage at constant force [1/1000]")
right.legend()
figure.savefig(output / "cattaneo_to_carter.png")
print(f"creepage: first step {creepage[0]:.4e}, last {creepage[-1]:.4e}, steady {steady.creepage[0]:.4e}")
