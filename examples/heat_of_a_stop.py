# SPDX-License-Identifier: MIT OR Apache-2.0
"""How hot does a pole shoe get in a stop from 160 km/h?

A pole shoe presses on the rail with its magnetic pressure and slides over it until the vehicle stands. The
deceleration is constant, and friction grows as the speed falls.

The number to compare with is the temperature of the rail at the end of the shoe by the closed form for heat
that flows into the depth alone: 2 q sqrt(t / pi) / (effusivity) with all of the mean heat q of the shoe, for
the time t in which the rail passes it. The pressure is not uniform, so that the hottest point is above it.

What to see: the temperature of the contact rises at once, because it is that of the rail, which is heated
within the milliseconds of its passage and comes back cold. The shoe's share of the heat is large at first and
one or two per cent soon; nearly all heat goes into the rail. Friction power falls with the speed, and in the
last seconds the rail cools the shoe. At 5 m/s the table of the friction has a kink.
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

first, duration = 160.0 / 3.6, 34.0
friction = mtb.VelocityTable([0.0, 5.0, 50.0], [0.35, 0.2, 0.1])
shoe = mtb.scenes.pole_shoe_on_rail(friction=friction, magnetic_pressure=2.5e6, velocity=first, spacing=6e-3)
heat = shoe.sliding_heat(duration, 68, lambda t: first * (1.0 - t / duration), film=(20.0, 0.0))

print("time [s]  speed [m/s]  friction [kW]  into the shoe [%]  hottest [K]  face of the shoe [K]")
for k in (0, 1, 3, 7, 15, 31, 47, 63):
    print(
        f"{heat.time[k]:8.1f}  {heat.velocity[k]:11.1f}  {1e-3 * heat.friction_powers[k]:13.2f}  "
        f"{100 * heat.heats_upper[k] / heat.friction_powers[k]:17.1f}  {heat.peaks[k]:11.1f}  "
        f"{heat.means[k]:20.1f}"
    )
#: Mean heat [W/m2] of the first step, and the time [s] of a passage.
flux = heat.friction_powers[0] / heat.area.sum()
passage = np.ptp(heat.points[0]) / heat.velocity[0]
closed_form = 2.0 * flux * np.sqrt(passage / np.pi) / mtb.conducting_steel.effusivity
print(f"rail behind the shoe, by heat into its depth alone: {closed_form:.1f} K at the beginning")
balance = (heat.heats_upper - heat.losses).sum() * heat.time[0] / heat.stored[-1]
print(f"heat in the shoe at the end: {1e-3 * heat.stored[-1]:.2f} kJ, balance {balance:.12f}")

figure, (above, middle, below) = plt.subplots(3, 1, figsize=(7.4, 7.2), sharex=True)
above.plot(heat.time, heat.peaks, label="hottest point of the contact")
above.plot(heat.time, heat.means, label="face of the shoe, mean")
above.set(title="temperature above that of the surroundings [K]", ylim=(0.0, None))
above.legend()
middle.plot(heat.time, 1e-3 * heat.friction_powers)
middle.set(title="heat of friction [kW]", ylim=(0.0, None))
below.plot(heat.time[:-1], 100.0 * heat.heats_upper[:-1] / heat.friction_powers[:-1])
below.set(title="share of the heat that enters the shoe [%]", xlabel="time [s]")
below.axhline(0.0, color="#333333", lw=0.8)
figure.savefig(output / "heat_of_a_stop.png")
