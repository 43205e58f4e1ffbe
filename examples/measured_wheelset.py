# SPDX-License-Identifier: MIT OR Apache-2.0
"""How does a measured wheelset run? From a file with noise to contact points, conicity and pressure.

A wheel is measured every 0.1 mm with 2 um of noise and written as MiniProf writes it, in a .whl file, here
from the new S1002, so that the truth is known. It is read, smoothed and set on 60E1 rails inclined 1:40.
Smoothing takes SciPy (extra `smooth`).

Numbers to compare with: the conicity on the exact profile, and its pressure under 60 kN. The noise hardly
changes the rolling radii. It multiplies the pressure, because a contact stands on the tips of the noise, and
its patch is in pieces.

What to see: the left wheel is raised over its rail, and lines join the points that touch each other at each
shift of 0.1 mm, every millimetre in red. New profiles leave out parts of the head, where the wheel touches
twice. The conicity falls with the amplitude, because the radii jump in the middle, and rises again where the
root of the flange touches.
"""

import argparse
import warnings
from pathlib import Path

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

exact, rail = mtb.Profile.standard("S1002"), mtb.Profile.standard("60E1")
s = np.arange(*exact.arc_length([-0.06, 0.058]), 1e-4)
y = exact.position(s)
noise = 2e-6 * np.random.default_rng(4).standard_normal(y.size)
points = 1e3 * (np.array([y, exact.height(y)]) + noise * exact.normal(y))
header = f"ProgramName=MiniProf Windows\nXYPoints={y.size}\nColumnDef=X,Y\n\n"
file = Path(output) / "wheel.whl"
file.write_text(header + "".join(f"{across:.5f}\t{up:.5f}\n" for across, up in points.T), encoding="utf-8")

measured = mtb.Profile.from_file(file)
smooth = measured.smoothed(wavelength=4e-3)
residual = smooth.smoothing
print(f"smoothed: largest {1e6 * residual.largest:.1f} um, rms {1e6 * residual.rms:.2f} um, no kinks")

print("wheel      conicity at 3 mm  harmonic  wavelength [m]  peak pressure [MPa]")
conicity, peak = {}, {}
for name, wheel in {"exact": exact, "measured": measured, "smoothed": smooth}.items():
    running = mtb.wheelset_geometry(wheel, rail)
    conicity[name] = float(running.equivalent_conicity(3e-3))
    scene = mtb.scenes.wheel_on_rail(wheel, rail, lateral=3e-3, force=60e3, spacing=0.25e-3)
    with warnings.catch_warnings():
        # that cells and steel do not bear what stands on tips
        warnings.simplefilter("ignore" if name == "measured" else "default")
        peak[name] = float(scene.solve(tolerance=0.1).pressure.max())
    print(
        f"{name:10s} {conicity[name]:16.4f} {float(running.equivalent_conicity(3e-3, 'harmonic')):9.4f}"
        f" {float(running.wavelength(3e-3)):15.2f} {1e-6 * peak[name]:20.0f}"
    )

figure, (above, below) = plt.subplots(2, 1, figsize=(7.2, 7.0), height_ratios=(1.2, 1.0))
running.plot(ax=above, side="left")
running.plot("equivalent_conicity", ax=below)
figure.savefig(output / "measured_wheelset.png")
