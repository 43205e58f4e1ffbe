# SPDX-License-Identifier: MIT OR Apache-2.0
"""The Fourier solver over contact fraction, grid and roughness: iterations, and the error against dense
LU.

Self-affine periodic surfaces (Hurst 0.3 and 0.8, waves down to two cells: the roughest a grid can hold) and
a tolerance of 1e-10. Dense solutions exist up to 32 x 32 cells; on finer grids the residual, taken from a
convolution made here, is the judge.
"""

import numpy as np
from atlas import GOOD, TOLD, WRONG, draw_verdicts, panels, write

import mtb_rs as mtb

sides = [16, 32, 64, 128, 256]
loads = [1e-4, 1e-3, 1e-2, 0.1, 0.3, 1.0, 3.0]
rows = []
figure, axes = panels(2, height=3.8)
for ax, hurst in zip(axes, (0.3, 0.8), strict=True):
    codes = np.zeros((len(loads), len(sides)), dtype=int)
    texts = np.full(codes.shape, "", dtype=object)
    shares = np.zeros(len(loads))
    for i, n in enumerate(sides):
        step, slope = 1e-6, 0.1
        heights = mtb.roughness(n, step, hurst=hurst, rms_slope=slope, seed=n)
        gap = heights.max() - heights
        for j, load in enumerate(loads):
            pair = {"lower": mtb.steel, "upper": mtb.Rigid(), "periodic": True}
            force = load * 0.5 * mtb.steel.plane_strain_modulus * slope * (n * step) ** 2
            try:
                found = mtb.solve_normal(gap, step, force=force, tolerance=1e-10, method="fft", **pair)
            except mtb.ConvergenceError as refusal:
                codes[j, i], found, said = TOLD, refusal.result, str(refusal)
            else:
                said = ""
            fraction = found.contact_area / (n * step) ** 2
            touching = found.pressure > 0.0
            # the conditions of contact, from the fields alone
            scale = heights.std()
            wrong = max(
                float(np.abs(found.gap[touching]).max(initial=0.0)) / scale,
                float(-found.gap.min()) / scale,
                float(-found.pressure.min() / found.pressure.max()),
            )
            if n <= 32:
                exact = mtb.solve_normal(gap, step, force=force, method="dense", **pair)
                wrong = max(
                    wrong,
                    float(np.linalg.norm(found.pressure - exact.pressure) / np.linalg.norm(exact.pressure)),
                )
            if not said:
                codes[j, i] = GOOD if wrong < 1e-6 else WRONG
            texts[j, i] = f"{found.report.iterations}"
            shares[j] = fraction
            rows.append(
                {
                    "hurst": hurst,
                    "cells_a_side": n,
                    "load_over_modulus_and_slope": load,
                    "contact_fraction": fraction,
                    "verdict": int(codes[j, i]),
                    "error": wrong,
                    "iterations": found.report.iterations,
                    "convolutions": found.report.convolutions,
                    "said": said,
                }
            )
    draw_verdicts(ax, sides, loads, codes, texts=texts)
    percents = [f"{float(f'{100 * share:.2g}'):g} %" for share in shares]
    ax.set_yticks(range(len(loads)), [f"{p:g}  ({c})" for p, c in zip(loads, percents, strict=True)])
    ax.set(title=f"Hurst exponent {hurst:g}", xlabel="cells a side")
axes[0].set_ylabel("mean pressure / (E* slope / 2)  (share in contact)")
write("fft", figure, rows)
