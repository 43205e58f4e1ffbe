# SPDX-License-Identifier: MIT OR Apache-2.0
"""How many stops does the sole of a track brake last, and what shape does it take?

Six pole shoes stop a vehicle from 160 km/h, a thousand times. A few of the stops are computed in full, with
the speed that follows from the forces; the stops between them wear the soles by the mean pressure, with an
error that the next full stop tells. Heat is left out: `a_stop_with_heat_and_wear.py` shows it. Masses,
tables and the wear coefficient are assumed, of plausible size.

The number to compare with: the volume that Archard's law takes off, the coefficient times the load times the
way of all stops, and the life that follows if the whole sole wore evenly.

What to see: above left, the deepest wear grows in proportion to the stops, because a single stop wears the
soles in; every dot is a stop that was computed. Above right, the mean pressure of a stop along the pole: the
new sole presses with its edges, and the worn one with a straight rise to the front, by which friction tilts
the shoe. Below, the sole before and after, which is deepest at its front.

Usage: a_year_of_stops.py [-o DIRECTORY].
"""

import argparse

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt

import mtb_rs as mtb
from mtb_rs.base.files import output_folder

plt.style.use("mtb_rs.pictures")
parser = argparse.ArgumentParser(description=__doc__)
parser.add_argument("-o", "--output", type=output_folder, default=".", help="directory of the picture")
output = parser.parse_args().output

SPEED, WEAR, COUNT, LIMIT = 160.0 / 3.6, 1e-15, 1000, 5e-3
friction = mtb.VelocityTable((0.0, 5.0, 15.0, 30.0, 50.0), (0.35, 0.24, 0.16, 0.12, 0.10))
pull = mtb.VelocityTable((0.0, 20.0, 50.0), (3.0e6, 2.6e6, 2.0e6))
shoe = mtb.scenes.pole_shoe_on_rail(
    friction=friction, magnetic_pressure=pull, poles=1, spacing=(9e-3, 5.2e-3)
)
# one pole is half of a shoe, so that the masses and forces are those of one side
shares = (0.85, 1.0, 1.0, 1.0, 1.0, 0.85)
worn = mtb.wear_of_stops(
    shoe, SPEED, 5e3, COUNT, 3.5e3, shares=shares, tolerance=0.05, stop_tolerance=0.2, wear=WEAR
)
outer, inner = worn[0], worn[1]
way = inner.distance[-1] / COUNT
stops = inner.distance / way
life = [one.life(LIMIT) / way for one in (outer, inner)]
load = -inner.forces[1:, 2] @ inner.steps[1:]
volume = inner.worn_volume[0, -1]
even = LIMIT / (volume / COUNT / inner.area.sum())

print(f"{COUNT} stops of {way:.0f} m, of which {inner.solves.sum()} were computed")
print("stops  deepest wear [um]  uniformity of the pressure  error of the stops left out [%]")
for k in range(len(stops)):
    print(
        f"{stops[k]:5.0f}  {1e6 * inner.depth[0, k]:17.2f}  {inner.uniformity[k]:26.3f}  "
        f"{100.0 * inner.errors[k]:31.2f}"
    )
print(f"volume over that of Archard's law for the vertical load: {volume / (WEAR * load):.3f}")
print(f"{1e3 * LIMIT:.0f} mm last {life[1]:.0f} stops, an outer shoe {life[0]:.0f}; worn evenly {even:.0f}")

figure, axes = plt.subplot_mosaic([["depth", "pressure"], ["sole", "sole"]], figsize=(7.4, 5.8))
for one, name in ((inner, "pulled in full"), (outer, "outer shoe, 85 %")):
    axes["depth"].plot(one.distance / way, 1e3 * one.depth[0], "o-", label=name)
axes["depth"].set(xlabel="stops", title="deepest wear [mm]", ylim=(0.0, None))
axes["depth"].legend()
grid = inner.patches[0]
x = 1e3 * grid.view(inner.points[0])[0]
for k, name in ((0, "new, from full speed"), (1, "first stop"), (len(stops) - 1, "last stop")):
    row = grid.view(inner.pressures[k]).mean(axis=0)
    axes["pressure"].plot(x, 1e-6 * row, "--" if k == 0 else "-", label=name)
axes["pressure"].set(xlabel="x [mm], sliding to the right", title="pressure [MPa]", ylim=(0.0, None))
axes["pressure"].legend()
axes["sole"].plot(x, 0.0 * x, "--", label="new")
for k in range(3, len(stops)):
    axes["sole"].plot(x, -1e3 * grid.view(inner.depths[0, k]).mean(axis=0), label=f"after {stops[k]:.0f}")
axes["sole"].set(xlabel="x [mm], sliding to the right", title="sole [mm]")
axes["sole"].legend(ncols=2, loc="lower left")
figure.savefig(output / "a_year_of_stops.png")
