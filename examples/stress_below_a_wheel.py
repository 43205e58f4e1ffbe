# SPDX-License-Identifier: MIT OR Apache-2.0
"""Where in a rail is the stress largest, and how does friction move it?

A wheel rolls with a creepage at which all of the contact slides, at several coefficients of friction. The
bodies are half-spaces.

The numbers to compare with are those of a line contact [Johnson1985, ch. 4.2 and 7.1]: without friction the
largest shear stress is 0.30 of the peak pressure at a depth of 0.79 half widths, and on the surface it is the
coefficient of friction times the peak pressure, so that from about 0.3 on the surface bears more than the
depth. The contact here is an ellipse, twice as wide as long.

What to see: without friction the stress has its peak below the surface. Friction moves it sideways and up,
and above 0.3 the surface itself bears most, near the edge that friction pulls at: cracks then begin there and
not inside.
"""

import argparse

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

import mtb_rs as mtb
from mtb_rs.base.files import output_folder

plt.style.use("mtb_rs.pictures")
parser = argparse.ArgumentParser(description=__doc__)
parser.add_argument("-o", "--output", type=output_folder, default=".", help="directory of the picture")
output = parser.parse_args().output

wheel = mtb.hertz(80e3, semi_axes=(4e-3, 8e-3), lower=mtb.steel, upper=mtb.steel)
pressed = wheel.on_grid((40, 64), (10e-3 / 64, 18e-3 / 40))
depths = 4e-3 * np.linspace(0.0, 2.0, 41)

figure, axes = plt.subplots(1, 3, figsize=(10.2, 3.4), layout="constrained")
print("friction  largest shear stress / peak pressure  depth / a  along x / a")
for mu in (0.0, 0.1, 0.2, 0.3, 0.4, 0.5):
    result = pressed
    if mu > 0.0:
        result = mtb.solve_tangential(pressed, mtb.Rolling((0.1, 0.0, 0.0), velocity=30.0), mtb.Coulomb(mu))
    inside = result.stress(depths=depths)
    value, place = inside.maximum("largest_shear")
    share, deep, along = value / wheel.peak_pressure, abs(place[2]) / 4e-3, place[0] / 4e-3
    print(f"{mu:8.1f}  {share:36.3f}  {deep:9.2f}  {along:11.2f}")
    if mu in (0.0, 0.3, 0.5):
        ax = axes[(0.0, 0.3, 0.5).index(mu)]
        inside.plot("von_mises", y=0.0, limits=(0.0, 1.2e9), ax=ax)
        ax.set_title(f"friction {mu:g}", fontsize=10)
figure.savefig(output / "stress_below_a_wheel.png")
