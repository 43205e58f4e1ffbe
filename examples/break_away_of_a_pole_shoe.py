# SPDX-License-Identifier: MIT OR Apache-2.0
"""How a pole shoe that stands breaks away, and what it remembers when the way turns.

A shoe is pulled onto the rail, pushed forward by a twentieth of a micrometre a step until it slides, then
back and forward again. Steps with a shift carry the tractions from one to the next: points stick until their
friction is used up, pressure and friction are found together, and the work of the friction on the slip is
the heat.

What to see: top, the friction force over the way of the shoe. It rises steeply while all of the sole
sticks, bends as the edges give way, and is level once everything slides; back and forward it runs round
a loop, whose area is the heat. Bottom, the sole at four places of the first way: slip (orange) begins at the
rear and at the outer edge, where the pressure is least, and what sticks (blue) shrinks towards the front.
"""

import argparse

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
from matplotlib.colors import ListedColormap

import mtb_rs as mtb
from mtb_rs.base.files import output_folder
from mtb_rs.pictures.quantities import LINE_COLOURS

plt.style.use("mtb_rs.pictures")
parser = argparse.ArgumentParser(description=__doc__)
parser.add_argument("-o", "--output", type=output_folder, default=".", help="directory of the picture")
output = parser.parse_args().output

scene = mtb.scenes.pole_shoe_on_rail(friction=0.3, magnetic_pressure=3e6, spacing=4e-3, poles=1)
contact = scene.prepare("elastic-upper")

reach, count = 3e-6, 60  # m, steps of a way
ways = {"forward": 1.0, "back": -1.0, "forward again": 1.0}
place, heat = 0.0, 0.0
last = (0.0, float(contact.step(shift=0.0).force[0]))  # pressed, and not moved yet
history: dict[str, list[tuple[float, float]]] = {}
soles: list[tuple[float, np.ndarray]] = []
for name, sign in ways.items():
    history[name] = [last]
    for _ in range(count):
        step = contact.step(shift=sign * reach / count)
        place += sign * reach / count
        heat += step.friction_work or 0.0
        last = (place, float(step.force[0]))
        history[name].append(last)
        if name == "forward":
            soles.append((place, step.status))
gross = scene.solve(model="elastic-upper").force[0]

figure = plt.figure(figsize=(7.4, 7.0))
places = figure.subplot_mosaic([["loop"] * 4, ["a", "b", "c", "d"]], height_ratios=[1.6, 1.0])
for (name, way), colour in zip(history.items(), LINE_COLOURS, strict=False):
    x, force = np.array(way).T
    style = "--" if name == "forward again" else "-"
    places["loop"].plot(1e6 * x, force / 1e3, style, color=colour, label=name)
places["loop"].axhline(gross / 1e3, color="k", ls=":", lw=1, label="gross sliding")
places["loop"].set(xlabel="way of the shoe [µm]", title="friction force [kN]")
places["loop"].legend(loc="lower right")

share = np.array([(status == 1).sum() / max((status > 0).sum(), 1) for _, status in soles])
x, y = 1e3 * contact.points[:2]
for panel, wanted in zip("abcd", (0.9, 0.6, 0.3, 0.02), strict=True):
    k = int(np.abs(share - wanted).argmin())
    ax = places[panel]
    ax.scatter(
        y,
        x,
        c=soles[k][1],
        s=9,
        marker="s",
        vmin=0,
        vmax=2,
        cmap=ListedColormap(["#d9d9d9", LINE_COLOURS[0], LINE_COLOURS[1]]),
    )
    ax.set(title=f"at {1e6 * soles[k][0]:.2f} µm", xlabel="y [mm]", aspect="equal", xlim=(0.0, 26.0))
    if panel == "a":
        ax.set(ylabel="x [mm], sliding upwards")
for status, colour in (("open", "#d9d9d9"), ("stick", LINE_COLOURS[0]), ("slip", LINE_COLOURS[1])):
    places["d"].scatter([], [], c=colour, s=16, marker="s", label=status)
places["d"].legend(loc="upper left", bbox_to_anchor=(1.02, 1.0))
figure.savefig(output / "break_away_of_a_pole_shoe.png")

forward = np.array(history["forward"])
begin = float(np.interp(0.99 * gross, forward[:, 1], forward[:, 0]))
loop = np.array(history["back"] + history["forward again"])
area = float(np.trapezoid(loop[:, 1], loop[:, 0]))
print(f"99 % of the {gross:.0f} N of gross sliding are reached after {1e6 * begin:.1f} µm")
print(f"a loop costs {1e3 * area:.2f} mJ, and all ways turned {1e3 * heat:.2f} mJ into heat")
