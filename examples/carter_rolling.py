# SPDX-License-Identifier: MIT OR Apache-2.0
"""Rolling cylinders: Carter's traction and creepage, and free rolling of unlike ones [Johnson1985, ch. 8].

What to see: top left, the computed traction lies on Carter's, with stick where the line leaves the bound. Top
right, the error of the creepage falls at first order in the cells. Below, free rolling of an elastic cylinder
on a rigid one, without any force: the less friction there is, the wider are the zones that slip.
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

a, load, friction = 3e-3, 1e6, 0.3  # m, N/m
body = mtb.Material.from_shear_modulus(82e9, 0.28)
peak = 2.0 * load / np.pi / a
law = mtb.Coulomb(friction)

patch = reference.line_pressure(load, a, 200, body, body)
x = patch.coordinates()[0]
figure = plt.figure(figsize=(7.4, 6.6))
places = figure.subplot_mosaic([["left", "middle"], ["right", "right"]])
left, middle, right = places["left"], places["middle"], places["right"]
left.plot(x / a, friction * patch.pressure[0] / peak, "k--", lw=1, label=r"bound $\mu p$")
for share in (0.3, 0.6, 0.9):
    roll = mtb.solve_tangential(patch, mtb.Rolling(force=(share * friction * load, None)), law)
    (line,) = left.plot(x / a, roll.traction[0, 0] / peak, label=rf"$F = {share} \mu F_n$")
    left.plot(x / a, reference.carter_traction(x, a, peak, friction, share) / peak, ":", color="k", lw=1.5)
left.set(xlabel="x / a, rolling to the right", title="traction / peak pressure; dotted: Carter")
left.set_xticks([-1, -0.5, 0, 0.5, 1])
left.legend()

errors = {}
for share in (0.3, 0.6, 0.9):
    exact = reference.carter_creepage(a, peak, friction, share, (body, body))
    errors[share] = []
    for n in (25, 50, 100, 200, 400, 800):
        fine = reference.line_pressure(load, a, n, body, body)
        roll = mtb.solve_tangential(fine, mtb.Rolling(force=(share * friction * load, None)), law)
        errors[share].append(abs(roll.creepage[0] / exact - 1.0))
    middle.loglog((25, 50, 100, 200, 400, 800), errors[share], "o-", label=rf"$F = {share} \mu F_n$")
middle.loglog((25, 800), (0.02, 0.02 / 32), "k--", lw=1, label="first order")
middle.set_xticks([25, 50, 100, 200, 400, 800], ["25", "50", "100", "200", "400", "800"])
middle.minorticks_off()
middle.set(xlabel="cells over the width", title="relative error of the creepage")
middle.legend()

# unlike cylinders rolling freely: the pressure alone brings traction and a creepage
soft, hard = mtb.Material.from_shear_modulus(1e9, 0.25), mtb.Material(1e15, 0.3)
free_load, free_peak = 1e5, 2.0 * 1e5 / np.pi / a
unlike = reference.line_pressure(free_load, a, 200, soft, hard)
for coefficient in (0.05, 0.1, 0.2, 1.0):
    roll = mtb.solve_tangential(unlike, mtb.Rolling(force=(0.0, None)), mtb.Coulomb(coefficient))
    label = rf"$\mu = {coefficient}$, creepage {roll.creepage[0]:.1e}"
    right.plot(x / a, roll.traction[0, 0] / free_peak, label=label)
right.set(
    xlabel="x / a", title="traction / peak pressure, free rolling on a rigid cylinder (Bentall and Johnson)"
)
right.legend()
figure.savefig(output / "carter_rolling.png")
print("relative error of the creepage at 25 to 800 cells:")
for share, values in errors.items():
    print(f"  F = {share} mu F_n: " + "  ".join(f"{value:.1e}" for value in values))
