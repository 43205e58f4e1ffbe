# SPDX-License-Identifier: MIT OR Apache-2.0
"""The traction curve of the Europrinter 127001, and its stick areas [Vollebregt2012, fig. 1 and 6].

The layer printed in the paper, 0.125 mm of 82000 N/mm2, lowers the initial slope by a few per cent only;
the factor of 3.62 it states takes a layer a hundred times as flexible. Both are shown.

What to see in europrinter_traction_curve.png: the layer as printed hardly changes the initial slope, the
softer one gives the slow rise. Falling friction makes the maximum and the decrease after it; Polach's curve
of the same slope has a wider transition.

What to see in europrinter_stick_areas.png: stick (blue) and slip (orange) at three forces; the contact
rolls to the right. At the same force less of it slips with the soft layer (bottom row).
"""

import argparse

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
from matplotlib.colors import ListedColormap
from matplotlib.patches import Patch

import mtb_rs as mtb
from mtb_rs.base.files import output_folder
from mtb_rs.half_space import reference
from mtb_rs.pictures.quantities import STATUS_COLOURS

plt.style.use("mtb_rs.pictures")
parser = argparse.ArgumentParser(description=__doc__)
parser.add_argument("-o", "--output", type=output_folder, default=".", help="directory of the pictures")
output = parser.parse_args().output

load, axes, speed = 106.7e3, (6.3e-3, 12.6e-3), 10.0  # N, m, m/s
body = mtb.Material.from_shear_modulus(82e9, 0.28)
patch = reference.elliptic_pressure(load, axes, (42, 42), body, body)
coulomb = mtb.Coulomb(0.33)
falling = mtb.FallingFriction(static=0.33, kinetic=0.14, half_slip=1.25, memory=3e-6, memory_min_slip=1e-3)
printed = mtb.InterfaceLayer(thickness=0.125e-3, shear_modulus=82e9)
soft = mtb.InterfaceLayer(thickness=12.5e-3, shear_modulus=82e9)

creepage = np.concatenate([[1e-5], np.linspace(5e-4, 0.02, 30), np.linspace(0.025, 0.1, 12)])
rows = np.stack([creepage, 0 * creepage, 0 * creepage], axis=1)


def curve(friction: mtb.FallingFriction | mtb.Coulomb, layer: mtb.InterfaceLayer | None) -> np.ndarray:
    return mtb.creep_curve(patch, rows, friction, layer=layer, velocity=speed)[:, 0] / load


curves = {
    "original, Coulomb": curve(coulomb, None),
    "layer as printed, falling friction": curve(falling, printed),
    "layer 100 times softer, Coulomb": curve(coulomb, soft),
    "layer 100 times softer, falling friction": curve(falling, soft),
}
# Polach's initial slope is the mean of its two reductions: that of the layer, 1 / 3.6
polach = mtb.polach(patch, rows, falling, (0.37, 0.18), speed, axes)
curves["Polach, same friction and initial slope"] = polach[:, 0] / load

reduction = {
    "as printed": curves["original, Coulomb"][0] / curves["layer as printed, falling friction"][0],
    "100 times softer": curves["original, Coulomb"][0] / curves["layer 100 times softer, Coulomb"][0],
}
figure, axis = plt.subplots()
for label, values in curves.items():
    axis.plot(100 * creepage, values, "--" if label.startswith("Polach") else "-", label=label)
axis.set(xlabel="longitudinal creepage [%]", title=r"$F_x / F_n$", xlim=(0, 10), ylim=(0, 0.36))
axis.legend()
figure.savefig(output / "europrinter_traction_curve.png")

# stick areas at equal force: with the layer the slip area is smaller, and turns convex
figure, axes_ = plt.subplots(2, 3, figsize=(7.4, 6.4), sharex=True, sharey=True)
slip_share = {}
areas = ListedColormap(list(STATUS_COLOURS[1:3]))
for column, share in enumerate((0.3, 0.6, 0.85)):
    force = (share * 0.33 * load, None)
    for row, (name, layer) in enumerate({"original": None, "with the soft layer": soft}.items()):
        roll = mtb.solve_tangential(patch, mtb.Rolling(force=force, velocity=speed), coulomb, layer=layer)
        slips = np.count_nonzero(roll.status == 2) / np.count_nonzero(roll.status)
        slip_share[name, share] = slips
        axis = axes_[row, column]
        x, y = roll.points * 1e3
        axis.pcolormesh(x, y, np.where(roll.status == 0, np.nan, roll.status), cmap=areas, vmin=1, vmax=2)
        axis.set_aspect("equal")
        axis.grid(visible=False)
        axis.set_title(
            f"{name}\n$F = {share}\\,\\mu F_n$, slip {100 * slips:.0f} %\n"
            f"creepage {100 * roll.creepage[0]:.2f} %"
        )
for axis in axes_[-1]:
    axis.set_xlabel("x [mm], rolling to the right")
for axis in axes_[:, 0]:
    axis.set_ylabel("y [mm]")
swatches = [Patch(color=c, label=n) for c, n in zip(STATUS_COLOURS[1:3], ("stick", "slip"), strict=True)]
figure.legend(handles=swatches, loc="outside lower center", ncols=2)
figure.savefig(output / "europrinter_stick_areas.png")
for name, value in reduction.items():
    print(f"initial slope, layer {name}: {value:.2f} times lower")
for (name, share), value in slip_share.items():
    print(f"slip area at {share} mu F_n, {name}: {100 * value:.0f} %")
