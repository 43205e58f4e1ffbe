# SPDX-License-Identifier: MIT OR Apache-2.0
"""How a brake shoe starts to slide, what a layer changes of it, and what happens beyond the wedging limit.

Pushed from rest, pressure and friction solved together. The pole shoe gives way from its edges and ends in
gross sliding, with and without a layer at the same force. A tall block whose top is held at its height
does so below the wedging limit. Above it no sliding state exists: friction tips the block into the
plane, which presses back, so the friction bound grows faster than the friction, and the block jams.

What to see: top, friction of the shoe and the share of the sole that slips; with the layer both come later,
and the force at last is the same. Bottom, a tall block: with µ = 0.2 friction reaches its bound (dashed) and
stays there, with µ = 0.5 the bound runs away from it.
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
parser.add_argument("-o", "--output", type=output_folder, default=".", help="directory of the picture")
output = parser.parse_args().output
figure = plt.figure(figsize=(7.4, 7.2))
places = figure.subplot_mosaic([["force", "slip"], ["block", "block"]])
plots = [places["force"], places["slip"], places["block"]]


def along_x(distances: np.ndarray) -> np.ndarray:
    return np.outer(distances, [1.0, 0.0])


shoe = mtb.scenes.pole_shoe_on_rail(friction=0.5, spacing=6e-3)
soft = shoe.with_(layer=mtb.InterfaceLayer(thickness=0.2e-3, shear_modulus=0.2e9))
pushes = along_x(np.concatenate([np.linspace(0.2e-6, 8e-6, 25), np.linspace(9e-6, 25e-6, 17)]))
gross, last = {}, {}
for name, scene in {"steel on steel": shoe, "with a soft layer": soft}.items():
    start = scene.start_of_sliding(pushes, model="elastic-upper")
    gross[name] = scene.solve(model="elastic-upper").force[0]
    last[name] = start.force[-1, 0]
    plots[0].plot(1e6 * pushes[:, 0], start.force[:, 0] / 1e3, ".-", ms=4, label=name)
    plots[1].plot(1e6 * pushes[:, 0], 100 * start.slip_share, ".-", ms=4, label=name)
plots[0].axhline(gross["steel on steel"] / 1e3, color="k", ls="--", lw=1, label="gross sliding, both")
plots[0].set(xlabel="displacement of the shoe [µm]", title="pole shoe: friction force [kN]")
plots[1].set(xlabel="displacement of the shoe [µm]", title="pole shoe: share that slips [%]")

friction_force, normal_force, margin = {}, {}, {}
pushes = along_x(np.linspace(5e-6, 150e-6, 30))
for mu, color in ((0.2, LINE_COLOURS[0]), (0.5, LINE_COLOURS[1])):
    block = mtb.scenes.block_on_plane(
        width=0.1, height=0.5, friction=mu, magnetic_pressure=3e6, spacing=10e-3
    )
    start = block.start_of_sliding(pushes, model="elastic-upper")
    friction_force[mu], normal_force[mu] = start.force[:, 0], start.normal_force
    try:
        # the margin is what is asked for; pressures would need finer cells
        solved = block.solve(model="elastic-upper", tolerance=0.9)
        margin[mu] = solved.report.wedging_margin
        end = "slides"
    except mtb.ConvergenceError as error:
        margin[mu] = error.result.report.wedging_margin
        end = "jams"
    way = 1e6 * pushes[:, 0]
    plots[2].plot(way, start.force[:, 0] / 1e3, "-", color=color, label=f"µ = {mu}, {end}: friction")
    bound = mu * start.normal_force / 1e3
    plots[2].plot(way, bound, "--", color=color, label=f"µ = {mu}: µ times normal force")
plots[2].set(xlabel="displacement of the top [µm]", title="block 0.1 m wide, 0.5 m tall: force [kN]")
for ax in plots:
    ax.set(xlim=(0.0, None), ylim=(0.0, None))
    ax.legend()
figure.savefig(output / "start_of_sliding.png")
for name in gross:
    print(f"pole shoe, {name}: {last[name]:.1f} N at last, {gross[name]:.1f} N in gross sliding")
for mu, forces in friction_force.items():
    print(
        f"block, friction {mu}: {margin[mu]:.2f} of what certainly slides; "
        f"at last friction {forces[-1] / 1e3:.1f} kN, normal force {normal_force[mu][-1] / 1e3:.1f} kN"
    )
