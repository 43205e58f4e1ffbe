# SPDX-License-Identifier: MIT OR Apache-2.0
"""Where a sliding equilibrium exists: clamped block on a half-space, over friction and slenderness.

Drawn in: mu_sym, below which the solution is certain to exist and to be unique, and 1.6 b / h, near
which the limits of slender blocks lie: the force at the leading edge bends the block so far that the edge
digs itself in.
"""

import numpy as np
from atlas import draw_verdicts, panels, write

import mtb_rs as mtb

names = (
    "slides",
    "slides, beyond mu_sym",
    "slides, unstable, and the library says so",
    "wedges, and the library says so",
)
colours = ("#56B4E9", "#009E73", "#CC79A7", "#E69F00")
slenderness = [0.5, 0.75, 1.0, 1.5, 2.0, 3.0, 4.0, 5.0]
frictions = [0.1, 0.15, 0.2, 0.25, 0.3, 0.4, 0.5, 0.7, 1.0, 1.4, 2.0, 2.8]
codes = np.zeros((len(frictions), len(slenderness)), dtype=int)
texts = np.full(codes.shape, "", dtype=object)
limits, rows = [], []
for i, ratio in enumerate(slenderness):
    scene = mtb.scenes.block_on_plane(height=0.1 * ratio, friction=0.05, spacing=0.0125)
    smooth = scene.with_(friction=0.0).solve("elastic-upper").normal_force
    limits.append(0.05 / scene.solve("elastic-upper").report.wedging_margin)
    for j, mu in enumerate(frictions):
        try:
            result = scene.with_(friction=mu).solve("elastic-upper")
            unstable = "unstable" in result.report.status
            codes[j, i] = 2 if unstable else int(mu > limits[-1])
            texts[j, i] = f"{result.normal_force / smooth:.3g}"
            force, said = result.normal_force / smooth, result.report.status
        except mtb.ConvergenceError as refusal:
            codes[j, i], force, said = 3, np.nan, str(refusal)
        rows.append(
            {
                "height_over_width": ratio,
                "friction": mu,
                "mu_sym": limits[-1],
                "slender_limit": 1.6 / ratio,
                "verdict": names[codes[j, i]],
                "force_over_frictionless": force,
                "said": said,
            }
        )
figure, (ax,) = panels(1, height=5.2)
draw_verdicts(ax, slenderness, frictions, codes, names=names, colours=colours, texts=texts)
for values, style, label in (
    (limits, "-", "mu_sym, computed"),
    (1.6 / np.array(slenderness), "--", "1.6 b / h, near the limits of slender blocks"),
):
    places = np.interp(np.log(values), np.log(frictions), np.arange(len(frictions)))
    ax.plot(range(len(slenderness)), places, style, color="black", lw=2, alpha=0.55, label=label)
ax.legend(frameon=True)
ax.set(
    title="clamped block; numbers: normal force over that without friction",
    xlabel="height / width",
    ylabel="friction coefficient",
)
write("existence", figure, rows)
