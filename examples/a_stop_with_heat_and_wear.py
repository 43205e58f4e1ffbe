# SPDX-License-Identifier: MIT OR Apache-2.0
"""What do heat and wear do to six pole shoes in a stop from 160 km/h?

Friction and pull follow the speed, the speed follows from all forces, and each step is one contact problem of
each shoe: its heat opens and closes the gap, and wear takes off its sole. The outer shoes are pulled less.
Masses, tables and the wear coefficient are assumed, of plausible size.

The numbers to compare with: the energy closes, and the same stop of shoes that stay cold and do not wear has
the same way, because the pull and not its distribution makes the force.

What to see: the sole warms at once and then hardly any more, as the rail takes nearly all of the heat. It
bows then, and its pressure moves from the edges to the middle; within seconds wear makes it even, but for
the rise towards the front by which friction tilts the shoe. In the last seconds friction grows and the rail
cools the hot sole. The sole is worn most at its front.
"""

import argparse
import time

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

speed = 160.0 / 3.6
friction = mtb.VelocityTable((0.0, 5.0, 15.0, 30.0, 50.0), (0.35, 0.24, 0.16, 0.12, 0.10))
pull = mtb.VelocityTable((0.0, 20.0, 50.0), (3.0e6, 2.6e6, 2.0e6))
shoe = mtb.scenes.pole_shoe_on_rail(friction=friction, magnetic_pressure=pull, velocity=speed, spacing=8e-3)
shares = (0.85, 1.0, 1.0, 1.0, 1.0, 0.85)
clock = time.perf_counter()
stop = mtb.brake(
    shoe, speed, 10e3, 7e3, shares=shares, tolerance=0.2, expansion=True,
    wear=1e-13, lower_wear=1e-15, resistance=1e-5, share=0.0,
)  # fmt: skip
elapsed = time.perf_counter() - clock
cold = mtb.brake(shoe, speed, 10e3, 7e3, shares=shares, tolerance=0.2)
one = stop.shoes[1]
upper, lower = stop.worn_volume

print(f"stop in {stop.time[-1]:.1f} s and {stop.way[-1]:.0f} m; cold shoes: {cold.way[-1]:.0f} m")
print(f"energy left open: {stop.open_energy:.1e} of that of the vehicle")
print(f"heat of friction over its thermal limit at the beginning: {one.thermal_margin:.1f}")
print(f"hottest contact {one.peaks.max():.0f} K, worn off {1e9 * upper:.0f} mm3 of the shoes")
print("time [s]  speed [m/s]  force [kN]  hottest [K]  sole [K]  peak pressure [MPa]  deepest wear [um]")
for k in np.unique(
    np.searchsorted(one.time, (0.01, 0.1, 1.0, 5.0, 15.0, 25.0, 32.0)).clip(max=one.time.size - 1)
):
    print(
        f"{one.time[k]:8.2f}  {stop.speed[k + 1]:11.1f}  {1e-3 * stop.forces[k].sum():10.2f}  "
        f"{one.peaks[k]:11.1f}  {one.means[k]:8.1f}  {1e-6 * one.pressures[k].max():19.2f}  "
        f"{1e6 * one.depths[k].max():17.1f}"
    )

figure, axes = plt.subplots(4, 1, figsize=(7.4, 8.6))
axes[0].plot(stop.time, stop.speed, label="speed [m/s]")
axes[0].plot(one.time, 1e-3 * stop.forces.sum(axis=1), label="force of six shoes [kN]")
axes[0].set(xlabel="time [s]", ylim=(0.0, None))
axes[0].legend()
axes[1].plot(one.time, one.peaks, label="hottest point of the contact [K]")
axes[1].plot(one.time, one.means, label="mean of the sole [K]")
axes[1].set(xlabel="time [s]", ylim=(0.0, None))
axes[1].legend()
grid = one.patches[0]
x = 1e3 * grid.view(one.points[0])[0]
for wanted in (0.0, 0.1, 5.0, 30.0):
    k = int(np.searchsorted(one.time, wanted).clip(max=one.time.size - 1))
    row = 1e-6 * grid.view(one.pressures[k]).mean(axis=0)
    axes[2].plot(x, row, label=f"{one.time[k]:.3g} s")
axes[2].set(title="pressure along a pole, mean over its width [MPa]", ylim=(0.0, None))
axes[2].legend(ncols=4)
axes[3].plot(x, 0.0 * x, "--", label="before")
axes[3].plot(x, -1e6 * grid.view(one.depth).mean(axis=0), label="after")
axes[3].set(title="sole [um]", xlabel="x [mm], sliding to the right")
axes[3].legend()
figure.savefig(output / "a_stop_with_heat_and_wear.png")
