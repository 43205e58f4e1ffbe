# SPDX-License-Identifier: MIT OR Apache-2.0
"""A sphere pushed sideways: stick, slip and stiffness against Cattaneo and Mindlin [Johnson1985, ch. 7.2].

What to see: along the middle (top) the tractions of four forces lie on the closed form. Bottom left, the area
that sticks is the circle of Cattaneo; bottom right, the force over the shift follows Mindlin.
"""

import argparse

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
from matplotlib.colors import ListedColormap

import mtb_rs as mtb
from mtb_rs.base.files import output_folder
from mtb_rs.half_space import reference
from mtb_rs.pictures.quantities import STATUS_COLOURS

plt.style.use("mtb_rs.pictures")
parser = argparse.ArgumentParser(description=__doc__)
parser.add_argument("-o", "--output", type=output_folder, default=".", help="directory of the picture")
output = parser.parse_args().output

a, load, friction, n = 3.2e-3, 1e4, 0.3, 99  # m, N
law = mtb.Coulomb(friction)
body = mtb.Material.from_shear_modulus(82e9, 0.28)
peak = 1.5 * load / np.pi / a**2
patch = reference.elliptic_pressure(load, (a, a), (n, n), body, body)

figure = plt.figure(figsize=(7.4, 6.8))
places = figure.subplot_mosaic([["left", "left"], ["middle", "right"]])
left, middle, right = places["left"], places["middle"], places["right"]
shares = np.array([0.2, 0.5, 0.8, 0.95])
shift, error = [], []
for share in shares:
    found = mtb.solve_tangential(patch, mtb.Shift(force=(share * friction * load, None)), law)
    x = found.points[0, n // 2]
    exact = reference.cattaneo_traction(np.hypot(*found.points), a, peak, friction, share)
    left.plot(x / a, found.traction[0, n // 2] / (friction * peak), label=rf"$F = {share} \mu F_n$")
    left.plot(x / a, exact[n // 2] / (friction * peak), ":k", lw=1.5)
    shift.append(found.creepage[0])
    error.append(float(np.linalg.norm(found.traction[0] - exact) / np.linalg.norm(exact)))
    if share == 0.5:
        areas = ListedColormap(list(STATUS_COLOURS[:3]))
        middle.imshow(found.status, extent=(-1, 1, -1, 1), origin="lower", cmap=areas, vmin=0, vmax=2)
        circle = reference.cattaneo_stick_radius(share)
        middle.add_patch(plt.Circle((0, 0), circle, fill=False, color="black", lw=1.5))
        middle.grid(visible=False)
        middle.set(title="stick (blue), slip; circle: closed form", xlabel="x / a", ylabel="y / a")
left.set(xlabel="x / a", title=r"traction / $\mu p_0$ along the middle; dotted: closed form")
left.legend()
fine = np.linspace(0.0, 0.999, 200)
closed = [reference.cattaneo_displacement(load, a, friction, s, (body, body)) for s in fine]
right.plot(1e6 * np.array(closed), fine, "k:", label="closed form")
right.plot(1e6 * np.array(shift), shares, "o", label="found")
right.set(xlabel="shift [µm]", title=r"force / $\mu F_n$ over the shift")
right.legend()
figure.savefig(output / "cattaneo_mindlin.png")
expected = np.array([reference.cattaneo_displacement(load, a, friction, s, (body, body)) for s in shares])
shift_error = np.abs(np.array(shift) / expected - 1.0)
for share, e, d in zip(shares, error, shift_error, strict=True):
    print(
        f"F = {share:.2f} mu F_n: traction {100 * e:.2f} % (L2), shift {100 * d:.3f} % from the closed form"
    )
