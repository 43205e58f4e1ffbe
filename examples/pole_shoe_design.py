# SPDX-License-Identifier: MIT OR Apache-2.0
"""Which pole shoe brakes with the least pressure? Height, gap and friction by a sweep.

Each design is pulled as hard as 4 kN of brake force need. With little friction the pull is large, and so is
the pressure; with much friction the moment of friction about the sole presses the front and lifts the rear.
In between lies a best friction, the smaller the taller the shoe. The gap is that of a shoe which runs some
micrometres beside the place where it has worn in: the radii of its sole and of the rail then lie beside
each other, and it stands on strips. Compared is the mean pressure of the most loaded tenth of the sole:
peaks at sharp edges are infinite and say more about the cells than about the shoe.

Three numbers to compare with. A shoe that fits and does not bend presses linearly along x, with its
resultant at e = µ h ahead of the middle (h is the height of the top over the contact), and lifts off beyond
e = L / 6; its largest pressure is least at µ = L / (4 h). Its most loaded tenth is the dashed line. The
resultant stands at µ h whatever bends and gapes. And the best design must brake with 4 kN under the pull
that friction times area asks for.

How sure is the choice? The designs within 5 % of the best one are solved again on cells of 2.25 mm. The
pressure changes by a per cent, by nearly the same for all of them, so their differences are known better
than the pressures. The error falls with the size of the cells, so three times its change is left in a
difference; a design that differs by less than that cannot be told from the best one. The rail is a half-
space here, which costs some 7 % of the pressure: to choose between designs that differ by so little, solve
with an elastic rail.

What to see in 1_pole_shoe_design.png: the star is the best design, and the ring is one that cannot be told
from it. Elastic shoes that fit (left) are worse than rigid ones (dashed), because their edges carry more
than their middle, and their best friction is a little larger, because the front gives way. A gap of 3 µm
costs more than 10 mm of height. A lower shoe is always better here: what speaks for height is material to
wear.

What to see in 2_best_and_gap.png: the best design above the same shoe with the widest gap, on one scale.
With the gap the poles touch along narrow strips, and most of the sole is open (grey).
"""

import argparse
from itertools import product

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

import mtb_rs as mtb
from mtb_rs.base.files import output_folder
from mtb_rs.pictures.quantities import LINE_COLOURS

plt.style.use("mtb_rs.pictures")
parser = argparse.ArgumentParser(description=__doc__)
parser.add_argument("-o", "--output", type=output_folder, default=".", help="directory of the pictures")
output = parser.parse_args().output

needed, length, sole = 4e3, 90e-3, (6e-3, 21.6e-3)  # N of brake force, m, m
heights, aside, frictions = (40e-3, 50e-3, 60e-3), (0.0, 5e-6, 20e-6), np.linspace(0.2, 0.8, 7)
area = 2.0 * length * (sole[1] - sole[0])
TENTH, WIDE, NARROW = 0.1, 3e-3, 2.25e-3


def most_loaded(result: mtb.Result, share: float = TENTH) -> float:
    """The mean pressure [Pa] of the most loaded cells that make up this share of the sole."""
    order = np.argsort(result.pressure)[::-1]
    areas = result.area[order]
    taken = np.clip(share * areas.sum() - (np.cumsum(areas) - areas), 0.0, areas)
    return float((taken * result.pressure[order]).sum() / taken.sum())


def measured(result: mtb.Result) -> dict[str, float]:
    """What the sweep keeps of a result beside forces."""
    load = result.pressure * result.area
    carried = load * result.normal[2]
    return {
        # at 4 kN: the force is a little larger than that, as pressure stands aslant on a curved rail
        "most_loaded": most_loaded(result) * needed / float(result.force[0]),
        "ahead": float((result.points[0] * carried).sum() / carried.sum()),
        "contact_height": float((result.points[2] * load).sum() / load.sum()),
        "slant": float(load.sum() / carried.sum()),
        "lifted": float((result.pressure == 0.0).mean()),
        "gap": float(result.initial_gap.max()),
    }


def rigid(friction: float, lever: float) -> float:
    """The pressure [Pa] of the most loaded tenth of a shoe that presses linearly along x, at 4 kN."""
    ahead, mean = friction * lever, needed / friction / area
    if ahead <= length / 6.0:
        return mean * (1.0 + 6.0 * ahead / length * (1.0 - TENTH))
    pressed = 3.0 * (0.5 * length - ahead)
    if pressed <= TENTH * length:
        return float("nan")
    return 2.0 * mean * length / pressed * (1.0 - 0.5 * TENTH * length / pressed)


def design(shift: float, height: float, friction: float) -> dict[str, float]:
    """The arguments of a design, pulled as 4 kN need."""
    pull = needed / friction / area
    return {"lateral": shift, "height": height, "friction": friction, "magnetic_pressure": pull}


options = {"model": "elastic-upper", "tolerance": 0.5, "measure": measured}
scene = mtb.scenes.pole_shoe_on_rail(length=length, inner_edge=sole[0], conforming_to=sole[1], spacing=WIDE)
every = list(product(aside, heights, frictions))
table = mtb.sweep(scene, [design(*one) for one in every], **options)
shape = len(aside), len(heights), len(frictions)
names = ("most_loaded", "ahead", "contact_height", "slant", "lifted", "gap")
found = {name: np.asarray(table[name], dtype=float).reshape(shape) for name in names}
pressure, lever = (
    found["most_loaded"],
    (np.array(heights)[:, None] - found["contact_height"]) * found["slant"],
)
worst = float(np.nanmax(np.abs(found["ahead"] / (frictions * lever) - 1.0)))
gaps = [float(np.nanmax(found["gap"][i])) for i in range(len(aside))]

print("   gap  height  best friction:  most loaded tenth   lifted   pull    resultant ahead [mm]")
print("  [um]    [mm]  elastic  rigid       [MPa]    rigid     [%]  [MPa]        solved     µ h")
fine = np.linspace(0.2, 0.8, 121)
best, best_rigid = {}, {}
for i, j in np.ndindex(shape[:2]):
    k = int(np.nanargmin(pressure[i, j]))
    best[aside[i], heights[j]] = float(pressure[i, j, k]), float(frictions[k])
    line = [rigid(mu, float(lever[i, j, k])) for mu in fine]
    best_rigid[heights[j]] = float(np.nanmin(line)), float(fine[int(np.nanargmin(line))])
    print(
        f"{1e6 * gaps[i]:6.1f} {1e3 * heights[j]:7.1f} {frictions[k]:8.1f} {best_rigid[heights[j]][1]:6.2f}"
        f" {1e-6 * pressure[i, j, k]:11.2f} {1e-6 * best_rigid[heights[j]][0]:8.2f}"
        f" {100.0 * found['lifted'][i, j, k]:7.0f} {1e-6 * needed / frictions[k] / area:6.2f}"
        f" {1e3 * found['ahead'][i, j, k]:13.3f} {1e3 * frictions[k] * lever[i, j, k]:7.3f}"
    )
print(
    f"resultant of {np.isfinite(pressure).sum()} of {len(every)} designs, the others tip over:"
    f" within {worst:.0e} of µ h"
)

# the designs that could be the best, on narrower cells
first = int(np.nanargmin(pressure))
near = [k for k in range(len(every)) if pressure.flat[k] < 1.05 * pressure.flat[first]]
again = mtb.sweep(scene.with_(spacing=NARROW), [design(*every[k]) for k in near], **options)
narrow = dict(zip(near, np.asarray(again["most_loaded"], dtype=float), strict=True))
chosen = min(near, key=lambda k: narrow[k])
# the error is of first order in the cells
left = NARROW / (WIDE - NARROW)
even = []
print("\n   gap  height  friction  most loaded tenth [MPa] on cells of   above the best  known within")
print(
    f"  [um]    [mm]             {1e3 * WIDE:8.2f} mm   {1e3 * NARROW:8.2f} mm"
    "             [MPa]         [MPa]"
)
for k in sorted(near, key=lambda k: narrow[k]):
    shift, height, mu = every[k]
    above = narrow[k] - narrow[chosen]
    known = left * abs(above - (pressure.flat[k] - pressure.flat[chosen]))
    if k != chosen and above <= known:
        even.append(k)
    print(
        f"{1e6 * gaps[aside.index(shift)]:6.1f} {1e3 * height:7.1f} {mu:9.1f} {1e-6 * pressure.flat[k]:14.2f}"
        f" {1e-6 * narrow[k]:13.2f} {1e-6 * above:17.3f} {1e-6 * known:13.3f}"
        f"{'  best' if k == chosen else '  cannot be told from it' if k in even else ''}"
    )
shift, height, friction = every[chosen]
shown = scene.with_(**design(shift, height, friction), spacing=NARROW)
result = shown.solve("elastic-upper", tolerance=0.5)
brake_force = float(result.force[0])
print(
    f"pulled by force / (friction x area) the best brakes with {brake_force:.1f} N,"
    f" {100.0 * (brake_force / needed - 1.0):.2f} % more:\npressure stands aslant on a curved rail"
)

figure, axes = plt.subplots(1, len(aside), figsize=(7.4, 3.9), sharey=True)
for i, (ax, gap) in enumerate(zip(axes, gaps, strict=True)):
    for j, tall in enumerate(heights):
        name = f"{1e3 * tall:g} mm high"
        ax.plot(frictions, 1e-6 * pressure[i, j], "o-", ms=3.5, color=LINE_COLOURS[j], label=name)
        if aside[i] == 0.0:
            arm = float(np.nanmean(lever[i, j]))
            ax.plot(fine, [1e-6 * rigid(mu, arm) for mu in fine], "--", lw=1.0, color=LINE_COLOURS[j])
    ax.set(
        xlabel="friction", title=f"gap up to {1e6 * gap:.1f} µm" if gap > 1e-9 else "no gap", ylim=(0.0, 25.0)
    )
ax = axes[aside.index(shift)]
ax.plot([], [], "--", lw=1.0, color=LINE_COLOURS[-1], label="rigid")
ax.plot(friction, 1e-6 * pressure.flat[chosen], "*", ms=14, color=LINE_COLOURS[-1], label="best")
for k in even:
    ring = {"ms": 11, "mfc": "none", "color": LINE_COLOURS[-1]}
    axes[aside.index(every[k][0])].plot(every[k][2], 1e-6 * pressure.flat[k], "o", **ring)
ax.plot([], [], "o", ms=11, mfc="none", color=LINE_COLOURS[-1], label="as good")
axes[0].set_ylabel("pressure of the most loaded tenth [MPa]")
figure.legend(*ax.get_legend_handles_labels(), loc="outside lower center", ncols=6, columnspacing=1.0)
figure.savefig(output / "1_pole_shoe_design.png")

figure, axes = plt.subplots(2, 1, figsize=(7.4, 7.6))
gaping = shown.with_(lateral=aside[-1]).solve("elastic-upper", tolerance=0.5)
for ax, name, drawn in zip(
    axes, ("best", f"gap up to {1e6 * gaps[-1]:.1f} µm"), (result, gaping), strict=True
):
    drawn.plot("pressure", ax=ax, limits=(0.0, 20e6))
    # the whole sole, also where it lifts off
    ax.set(
        xlim=(-5e2 * length, 5e2 * length),
        title=f"{name}: pressure at {needed / 1e3:g} kN of brake force",
    )
figure.savefig(output / "2_best_and_gap.png")
