# SPDX-License-Identifier: MIT OR Apache-2.0
"""Which shape does the sole of a magnetic track brake wear in to? The assumed one, and soles that wore in.

A model of a pole shoe needs the profile of its sole. The usual assumption is a worn one: 60 % of the width
conform to the rail, and the rest rises from it with a slight slope, so that it carries nothing. Here a new,
flat sole is worn in by `mtb.wear`: on a new rail (60E1), and on a rail that other shoes have worn by 0.3 mm
in the middle of their width. Both bodies are half-spaces; the sole is worn as deep as the new rail falls off
at the end of the width that is assumed to bear.

The number to compare with is the pressure of the assumed sole if it were even on this width. All soles are
then put on the new rail, to see what it means that a sole conforms to one rail only.

What to see: above, how far each sole lies above the new rail. The assumed one (dashed) and the one worn in
on the new rail lie on it up to 21.6 mm; beyond, the worn one rises more, because nothing has worn there.
Below, the pressure, the mean along x: each worn-in sole bears evenly on its own rail, without the edges that
the assumed one has. Put on the new rail, the sole from the worn one (dotted) bears on one row of cells, at
forty times the pressure at least: until it has worn in again.

Usage: worn_soles.py [-o DIRECTORY].
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

CONFORMING, WIDE, WEAR = 21.6e-3, 26e-3, 1e-13
#: Points along and across the one pole, whose sole conforms all over before anything is taken off it.
shoe = mtb.scenes.pole_shoe_on_rail(poles=1, conforming_to=WIDE, spacing=(9e-3, 0.4e-3), friction=0.0)
grid = shoe.geometry.grid(shoe.known_spacing)
rows, columns = grid.patches[0].ny, grid.patches[0].nx
place, rail = (grid.points[k].reshape(rows, columns)[:, 0] for k in (1, 2))
# gaps and depths are along the normals of the rail, heights are not
upright = grid.cells.normal[2].reshape(rows, columns)[:, 0]
# other shoes have worn the middle of their width
worn_off = 0.3e-3 * np.exp(-(((place - 14e-3) / 4e-3) ** 2))
crown = rail.max()


def wide(row: np.ndarray) -> np.ndarray:
    """Values (rows,) at all points."""
    return np.repeat(row[:, None], columns, axis=1)


def across(field: np.ndarray) -> np.ndarray:
    """Mean of a field along x (rows,)."""
    return field.reshape(rows, columns).mean(axis=1)


def bearing(pressure: np.ndarray) -> float:
    """Share of the strip that bears more than a tenth of the assumed pressure."""
    return float((pressure > 0.1 * even).mean())


load = 3e6 * grid.area.sum()
even = load / grid.area.reshape(rows, columns)[place < CONFORMING].sum()
lowest = {"new rail": rail, "worn rail": rail - worn_off}
soles, pressures = {"assumed": np.maximum(place - CONFORMING, 0.0) * 0.02 + rail}, {}
for name, height in lowest.items():
    # a flat sole is worn as deep as the rail falls off at the end of the width that is to bear
    limit = crown - float(np.interp(CONFORMING, place, rail))
    found = mtb.wear(shoe, 1e6, WEAR, gap=wide(upright * (crown - height)), limit=limit, model="half-space")
    deep = across(found.depths[0, -1]) / upright
    soles[f"worn in on the {name}"] = crown + deep
    pressures[f"worn in on the {name}"] = across(found.pressure)
    print(
        f"{name}: worn in after {found.distance[-1] / 1e3:.1f} km in {len(found.steps) - 1} steps, "
        f"{1e3 * deep.max():.2f} mm deep; {100 * bearing(across(found.pressure)):.0f} % of the strip bear"
    )
peaks = {}
for name, sole in soles.items():
    # solved by a wear of nothing
    rise = sole - rail
    gap = wide(upright * (rise - rise.min()))
    found = mtb.wear(shoe, 1.0, 0.0, gap=gap, model="half-space")
    pressures[f"{name}, on the new rail"] = across(found.pressure)
    peaks[name] = float(across(found.pressure).max()) / even
    print(
        f"{name}, on the new rail: {100 * bearing(across(found.pressure)):.0f} % of the strip bear, peak "
        f"over assumed {peaks[name]:.2f}"
    )

figure, axes = plt.subplots(2, 1, figsize=(7.4, 6.2), sharex=True, layout="constrained")
for (name, sole), style in zip(soles.items(), ("--", "-", "-"), strict=True):
    rise = sole - rail
    axes[0].plot(1e3 * place, 1e3 * (rise - rise.min()), style, label=name)
axes[0].set(ylabel="sole above the new rail [mm]", ylim=(-0.05, 1.2))
axes[0].legend(frameon=False, fontsize=9)
for name, style in (
    ("assumed, on the new rail", "--"),
    ("worn in on the new rail", "-"),
    ("worn in on the worn rail", "-"),
    ("worn in on the worn rail, on the new rail", ":"),
):
    axes[1].plot(1e3 * place, pressures[name] / 1e6, style, label=name)
axes[1].set(xlabel="y [mm]", ylabel="pressure, mean along x [MPa]", yscale="log", ylim=(0.5, 300.0))
axes[1].legend(frameon=False, fontsize=9)
for ax in axes:
    ax.grid(True, color="#DDDDDD", linewidth=0.6)
path = output / "worn_soles.png"
figure.savefig(path)
print(path)
