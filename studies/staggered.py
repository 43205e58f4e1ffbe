# SPDX-License-Identifier: MIT OR Apache-2.0
"""Staggered coupling of a block (thesis 2.3): where the loop converges, over f_FE, friction and height.

The predicted limit, max |1 + l|^2 / (2 Re(1 + l)) over the eigenvalues l of S^-1 T, is drawn in; Anderson's
acceleration (depth 8) at f_FE = 1 stands in the row "A". The reference is Anderson's fixed point, checked
to be the plain loop's where that converges. The loop counts the block's local compliance twice, so all of
them differ from the direct solution: by how much, the CSV says.
"""

import numpy as np
from atlas import GOOD, TOLD, WRONG, draw_verdicts, panels, write

import mtb_rs as mtb

factors = [1.0, 1.25, 1.6, 2.0, 2.5, 3.2, 4.0, 6.0]
frictions = [0.05, 0.1, 0.2, 0.3, 0.4, 0.5]
heights = [0.05, 0.1, 0.25]
figure, axes = panels(len(heights), columns=3, height=3.9)
rows = []
for ax, height in zip(axes, heights, strict=True):
    codes = np.full((len(factors) + 1, len(frictions)), TOLD)
    texts = np.full(codes.shape, "", dtype=object)
    limits = np.full(len(frictions), np.nan)
    for i, mu in enumerate(frictions):
        scene = mtb.scenes.block_on_plane(height=height, friction=mu, spacing=0.0125)
        direct = scene.solve("elastic-upper")
        for j, factor in enumerate([None, *factors]):
            options = {"factor": 1.0, "anderson_depth": 8} if factor is None else {"factor": factor}
            try:
                result = scene.solve(
                    "elastic-upper",
                    method="staggered",
                    max_iterations=120,
                    displacement_tolerance=1e-6,
                    **options,
                )
                if factor is None:
                    fixed = result.pressure
                error = float(np.linalg.norm(result.pressure - fixed) / np.linalg.norm(fixed))
                codes[j, i] = GOOD if error < 1e-3 else WRONG
                texts[j, i] = f"{result.report.iterations}"
                solver, said, bias = result.report.solver, "", float(
                    np.linalg.norm(result.pressure - direct.pressure) / np.linalg.norm(direct.pressure)
                )  # fmt: skip
            except mtb.ConvergenceError as refusal:
                error, bias, said, solver = np.nan, np.nan, str(refusal), refusal.result.report.solver
            limits[i] = float(solver.rsplit("below ", 1)[-1])
            rows.append(
                {
                    "height_m": height,
                    "friction": mu,
                    "f_fe": factor or "Anderson",
                    "predicted_limit": limits[i],
                    "verdict": int(codes[j, i]),
                    "error": error,
                    "bias_against_direct": bias,
                    "said": said,
                }
            )
    draw_verdicts(ax, frictions, [0.0, *factors], codes, texts=texts)
    ax.set_yticks(range(len(factors) + 1), ["A", *(f"{f:g}" for f in factors)])
    places = 1.0 + np.interp(np.log(limits), np.log(factors), np.arange(len(factors)))
    ax.plot(range(len(frictions)), places, "-", color="black", lw=2, alpha=0.55)
    ax.set(title=f"block {1e3 * height:g} mm high", xlabel="friction coefficient")
axes[0].set_ylabel("relaxation factor f_FE; A: Anderson")
write("staggered", figure, rows)
