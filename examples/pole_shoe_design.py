# SPDX-License-Identifier: MIT OR Apache-2.0
"""Which pole shoe brakes with the least pressure? Height, width of the sole and friction by a sweep.

Each design is pulled as hard as 4 kN of brake force need. With little friction the pull is large, and so is
the pressure; with much friction the moment of friction about the sole presses the front and lifts the rear.
In between lies a best friction, the smaller the taller the shoe. Compared is the pressure that a twentieth
of the sole exceeds: peaks at sharp edges are infinite and say more about the cells than about the shoe.

Three numbers to compare with. A shoe that does not bend presses linearly along x, with its resultant at e =
µ h ahead of the middle (h is the height of the top over the contact), and lifts off beyond e = L / 6; its
largest pressure is least at µ = L / (4 h). What it exceeds is the dashed line. The resultant stands at µ h
whatever bends. And the best design, solved anew with the pull that friction times area asks for, must brake
with 4 kN.

What to see in 1_pole_shoe_design.png: the star is the best design. The elastic shoe is worse than the rigid
one, because its edges carry more than its middle, and its best friction is a little larger, because the
front gives way. A wider sole and a lower shoe are always better here: what speaks for height is material to
wear.

What to see in 2_best_and_taller.png: the best design above a shoe 10 mm taller at the same brake force, on
one scale. The taller shoe leans more on its front, and more of its rear lifts off (grey).
"""

import argparse

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

needed, pull, length = 4e3, 3e6, 90e-3  # N of brake force, Pa in the sweep, m
heights, soles, frictions = (40e-3, 50e-3, 60e-3), (17.6e-3, 21.6e-3), np.linspace(0.1, 0.8, 8)
TWENTIETH = 0.05


def exceeded(result: mtb.Result, share: float = TWENTIETH) -> float:
    """The pressure [Pa] that this share of the sole exceeds."""
    order = np.argsort(result.pressure)[::-1]
    covered = np.cumsum(result.area[order]) - 0.5 * result.area[order]
    return float(np.interp(share * result.area.sum(), covered, result.pressure[order]))


def measured(result: mtb.Result) -> dict[str, float]:
    """What the sweep keeps of a result beside forces."""
    load = result.pressure * result.area
    carried = load * result.normal[2]
    return {
        "exceeded": exceeded(result),
        "ahead": float((result.points[0] * carried).sum() / carried.sum()),
        "contact_height": float((result.points[2] * load).sum() / load.sum()),
        "slant": float(load.sum() / carried.sum()),
        "lifted": float((result.pressure == 0.0).mean()),
    }


def rigid(friction: float, lever: float, area: float) -> float:
    """The exceeded pressure [Pa] of a shoe that presses linearly along x, at the brake force needed."""
    ahead, mean = friction * lever, needed / friction / area
    if ahead <= length / 6.0:
        return mean * (1.0 + 12.0 * ahead / length * (0.5 - TWENTIETH))
    pressed = 3.0 * (0.5 * length - ahead)
    if pressed <= 2.0 * TWENTIETH * length:
        return float("nan")
    return 2.0 * mean * length / pressed * (1.0 - TWENTIETH * length / pressed)


scene = mtb.scenes.pole_shoe_on_rail(magnetic_pressure=pull, length=length, spacing=4.5e-3)
table = mtb.sweep(
    scene,
    {"conforming_to": soles, "height": heights, "friction": frictions},
    model="elastic-upper",
    tolerance=0.5,
    measure=measured,
)
# pressures and forces are proportional to the pull: a sole that conforms closes no gap
scale = needed / table["force_x"]
pressure = scale * table["exceeded"]
print("sole to  height  best friction:  exceeded by 1/20   lifted   pull    resultant ahead [mm]")
print("   [mm]    [mm]  elastic  rigid       [MPa]    rigid     [%]  [MPa]        solved     µ h")
fine = np.linspace(0.1, 0.8, 141)
best, best_rigid, lever_error = {}, {}, []
for i, sole in enumerate(soles):
    area = 2.0 * length * (sole - 6e-3)
    for j, height in enumerate(heights):
        lever = (height - table["contact_height"][i, j]) * table["slant"][i, j]
        solved = table.status[i, j] == "solved"
        lever_error += list((table["ahead"][i, j] / (frictions * lever) - 1.0)[solved])
        k = int(np.nanargmin(pressure[i, j]))
        best[sole, height] = (float(pressure[i, j, k]), float(frictions[k]))
        by_line = np.array([rigid(mu, float(lever[k]), area) for mu in fine])
        best_rigid[sole, height] = (float(np.nanmin(by_line)), float(fine[int(np.nanargmin(by_line))]))
        print(
            f"{1e3 * sole:7.1f} {1e3 * height:7.1f} {frictions[k]:8.1f} {best_rigid[sole, height][1]:6.2f}"
            f" {1e-6 * pressure[i, j, k]:11.2f} {1e-6 * best_rigid[sole, height][0]:8.2f}"
            f" {100.0 * table['lifted'][i, j, k]:7.0f} {1e-6 * pull * scale[i, j, k]:6.2f}"
            f" {1e3 * table['ahead'][i, j, k]:13.3f} {1e3 * frictions[k] * lever[k]:7.3f}"
        )
worst = float(np.abs(lever_error).max())
print(
    f"resultant of {len(lever_error)} of {len(table)} designs, the others tip over: within {worst:.0e} of µ h"
)
sole, height = min(best, key=lambda design: best[design][0])
design = scene.with_(conforming_to=sole, height=height, friction=best[sole, height][1])
area = 2.0 * length * (sole - 6e-3)
design = design.with_(magnetic_pressure=needed / design.friction / area)
chosen = design.solve("elastic-upper", tolerance=0.5)
narrower = exceeded(design.with_(spacing=3e-3).solve("elastic-upper", tolerance=0.5))
brake_force = float(chosen.force[0])
print(
    f"best: {1e3 * height:g} mm high, sole to {1e3 * sole:g} mm, friction {design.friction:g}\n"
    f"pulled by force / (friction x area) it brakes with {brake_force:.1f} N,"
    f" {100.0 * (brake_force / needed - 1.0):.2f} % more:\npressure stands aslant on a curved rail\n"
    f"on cells of 3 mm a twentieth of its sole exceeds {1e-6 * narrower:.2f} MPa,"
    f" on those of 4.5 mm {1e-6 * exceeded(chosen):.2f} MPa"
)

figure, axes = plt.subplots(1, 2, figsize=(7.4, 3.9), sharey=True)
for i, (ax, to) in enumerate(zip(axes, soles, strict=True)):
    for j, tall in enumerate(heights):
        ax.plot(
            frictions,
            1e-6 * pressure[i, j],
            "o-",
            color=LINE_COLOURS[j],
            label=f"{1e3 * tall:g} mm high",
        )
        lever = float(tall - np.nanmean(table["contact_height"][i, j]))
        line = [1e-6 * rigid(mu, lever, 2.0 * length * (to - 6e-3)) for mu in fine]
        ax.plot(fine, line, "--", lw=1.0, color=LINE_COLOURS[j])
    ax.plot([], [], "--", lw=1.0, color=LINE_COLOURS[-1], label="without bending")
    ax.set(xlabel="friction", title=f"sole from 6 to {1e3 * to:g} mm", ylim=(0.0, 30.0))
axes[soles.index(sole)].plot(
    design.friction, 1e-6 * best[sole, height][0], "*", ms=15, color=LINE_COLOURS[-1], label="best"
)
axes[0].set(ylabel="pressure that a twentieth of the sole exceeds [MPa]")
figure.legend(*axes[soles.index(sole)].get_legend_handles_labels(), loc="outside lower center", ncols=5)
figure.savefig(output / "1_pole_shoe_design.png")

taller = design.with_(height=height + 10e-3)
figure, axes = plt.subplots(2, 1, figsize=(7.4, 7.6))
shown = {"best": chosen, "10 mm taller": taller.solve("elastic-upper", tolerance=0.5)}
for ax, (name, result) in zip(axes, shown.items(), strict=True):
    result.plot("pressure", ax=ax, limits=(0.0, 20e6))
    # the whole sole, also where it lifts off
    ax.set(
        xlim=(-5e2 * length, 5e2 * length),
        title=f"{name}: pressure at {needed / 1e3:g} kN of brake force",
    )
figure.savefig(output / "2_best_and_taller.png")
