# SPDX-License-Identifier: MIT OR Apache-2.0
"""How large is the real contact of rough surfaces? Its area against two theories of it.

A self-affine surface of steel (Hurst exponent 0.8, root mean square slope h' = 0.02) is pressed on a plane.
At light load the area is a share κ p / (E* h') of the whole: Bush, Gibson and Thomas [BGT1975] have κ =
√(2π), 2.51, Persson [Persson2001] √(8/π), 1.60, and over all loads erf(√2 p / (E* h')). Computed surfaces
lie between the two, here at 2.1 to 2.2.

What to see: a cell counts as touching as a whole, so the area of a grid is too large along its border,
which at light load is nearly everywhere. The same surface, refined by its Fourier series, on two grids
shows it; the extrapolation to cells of no size is the number to compare. It bends away from the straight
line of BGT, as Persson's curve does, and stays above that.
"""

import argparse
import math

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

cells, size, slope = 256, 1e-6, 0.02  # along each side, m, -
heights = mtb.roughness(
    cells, size, rms_slope=slope, hurst=0.8, roll_off=64 * size, shortest=8 * size, seed=1
)


def refined(field: np.ndarray, factor: int) -> np.ndarray:
    """The same periodic surface on cells smaller by `factor`: its Fourier series, evaluated there."""
    n, m = len(field), factor * len(field)
    waves = np.fft.fftshift(np.fft.fft2(field))
    padded = np.pad(waves, (m - n) // 2)
    return np.fft.ifft2(np.fft.ifftshift(padded)).real * factor**2


contact_modulus = 0.5 * mtb.steel.plane_strain_modulus
loads = np.geomspace(0.005, 1.0, 10)  # p / (E* h')
forces = loads * contact_modulus * slope * (cells * size) ** 2
share = {}
for factor in (1, 2):
    surface = refined(heights, factor)
    curve = mtb.area_load_curve(
        surface.max() - surface, size / factor, forces, lower=mtb.steel, upper=mtb.steel, tolerance=1e-4
    )
    share[factor] = curve.contact_area / (cells * size) ** 2
# the cells along the border count half too much: an error of first order
limit = 2.0 * share[2] - share[1]
persson = np.array([math.erf(math.sqrt(2.0) * load) for load in loads])
bgt = math.sqrt(2.0 * math.pi) * loads
kappa = limit / loads

print("p / (E* h')  area [%]: 1 µm  0.5 µm  limit  Persson    BGT  kappa")
for k, load in enumerate(loads):
    row = (share[1][k], share[2][k], limit[k], persson[k], bgt[k])
    print(f"{load:11.4f} " + " ".join(f"{100.0 * value:8.2f}" for value in row) + f" {kappa[k]:6.2f}")

figure, (left, right) = plt.subplots(1, 2, figsize=(7.4, 3.7))
left.loglog(loads, bgt, "--", label="Bush, Gibson, Thomas")
left.loglog(loads, persson, label="Persson")
left.loglog(loads, share[1], "x", label="cells of 1 µm")
left.loglog(loads, limit, "o", label="extrapolated")
left.set(xlabel="p / (E* h')", title="share of the area in contact", ylim=(None, 1.3))
left.legend()
middle = mtb.solve_normal(
    surface.max() - surface,
    0.5 * size,
    lower=mtb.steel,
    upper=mtb.steel,
    force=forces[4],
    periodic=True,
    tolerance=1e-4,
)
middle.plot("pressure", ax=right)
right.set(title=f"pressure, {100.0 * share[2][4]:.0f} % in contact")
figure.savefig(output / "rough_contact_area.png")
