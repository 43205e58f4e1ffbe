# SPDX-License-Identifier: MIT OR Apache-2.0
"""Traction in a curve with some spin: half-space, layer and Polach [Vollebregt2012, fig. 7].

What to see: spin alone makes a lateral force (right, at zero creepage), which the layer reduces to a quarter.
With growing longitudinal creepage the lateral force dies out.
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

load, axes, speed, spin = 106.7e3, (8.9e-3, 4.45e-3), 10.0, 0.55  # N, m, m/s, 1/m
body = mtb.Material.from_shear_modulus(82e9, 0.28)
patch = reference.elliptic_pressure(load, axes, (42, 42), body, body)
falling = mtb.FallingFriction(static=0.33, kinetic=0.14, half_slip=1.25, memory=3e-6, memory_min_slip=1e-3)
soft = mtb.InterfaceLayer(thickness=12.5e-3, shear_modulus=82e9)

creepage = np.concatenate([[0.0], np.geomspace(2e-4, 0.1, 35)])
rows = np.stack([creepage, 0 * creepage, spin + 0 * creepage], axis=1)
# Polach's stiffness is the mean of its two reductions: the slope of the layer, 1 / 3.6
reduction = (0.37, 0.18)
curves = {
    "original, Coulomb": mtb.creep_curve(patch, rows, mtb.Coulomb(0.33)),
    "layer, falling friction": mtb.creep_curve(patch, rows, falling, layer=soft, velocity=speed),
    "Polach": mtb.polach(patch, rows, falling, reduction, speed, axes),
}
figure, plots = plt.subplots(1, 2, figsize=(7.4, 4.2))
for column, name in enumerate(("F_x", "F_y")):
    for label, forces in curves.items():
        plots[column].plot(
            100 * creepage, forces[:, column] / load, "--" if label == "Polach" else "-", label=label
        )
    plots[column].set(xlabel="longitudinal creepage [%]", title=f"${name} / F_n$", xlim=(0, 10))
figure.legend(*plots[0].get_legend_handles_labels(), loc="outside lower center", ncols=3)
figure.savefig(output / "creep_forces_with_spin.png")
lateral = {label: float(forces[0, 1] / load) for label, forces in curves.items()}
for label, value in lateral.items():
    print(f"lateral force by spin alone, {label}: {value:.3f} F_n")
