# SPDX-License-Identifier: MIT OR Apache-2.0
"""Iterations of the Fourier solver on rough surfaces: contact fraction, roughness, shortest wave, grid.

Self-affine surfaces of Hurst exponent 0.3, 0.6 and 0.9 with shortest waves of 2 to 32 cells, periodic and
on a bowl in free space, pressed until 1 to 90 % of the cells touch; tolerance 1e-8 at the worst point. The
map shows the most iterations of the three exponents, on 128 x 128 and on 512 x 512 cells.
"""

import numpy as np
from atlas import GOOD, TOLD, draw_verdicts, panels, write

import mtb_rs as mtb

SHORTEST = [2, 4, 8, 16, 32]
LOADS = [0.02, 0.1, 0.3, 0.8, 1.5, 3.0]
HURST = (0.3, 0.6, 0.9)
SLOPE, STEP = 0.02, 1e-6
rows = []
figure, axes = panels(4, height=3.6)
for ax, (surroundings, n) in zip(
    axes, [(s, n) for s in ("periodic", "bowl") for n in (128, 512)], strict=True
):
    codes = np.zeros((len(LOADS), len(SHORTEST)), dtype=int)
    most = np.zeros(codes.shape, dtype=int)
    shares = np.zeros(len(LOADS))
    x = ((np.arange(n) + 0.5) / n - 0.5) * n * STEP
    bowl = (x[None, :] ** 2 + x[:, None] ** 2) * (SLOPE / (n * STEP))
    for i, shortest in enumerate(SHORTEST):
        for j, load in enumerate(LOADS):
            for hurst in HURST:
                heights = mtb.roughness(
                    n, STEP, hurst=hurst, rms_slope=SLOPE, shortest=shortest * STEP, seed=shortest
                )
                periodic = surroundings == "periodic"
                gap = heights.max() - heights + (0.0 if periodic else bowl)
                force = load * 0.5 * mtb.steel.plane_strain_modulus * SLOPE * (n * STEP) ** 2
                pair = {"lower": mtb.steel, "upper": mtb.Rigid(), "periodic": periodic, "method": "fft"}
                edge = "auto" if periodic else "sharp"
                said = ""
                try:
                    found = mtb.solve_normal(gap, STEP, force=force, tolerance=1e-8, edge=edge, **pair)
                except mtb.ConvergenceError as refusal:
                    found, said = refusal.result, str(refusal)
                    codes[j, i] = TOLD
                fraction = float((found.status > 0).mean())
                shares[j] += fraction / (len(SHORTEST) * len(HURST))
                most[j, i] = max(most[j, i], found.report.iterations)
                rows.append(
                    {
                        "surroundings": surroundings,
                        "cells_a_side": n,
                        "hurst": hurst,
                        "shortest_wave_cells": shortest,
                        "contact_fraction": fraction,
                        "iterations": found.report.iterations,
                        "convolutions": found.report.convolutions,
                        "residual": found.report.residual,
                        "said": said,
                    }
                )
    codes[codes != TOLD] = GOOD
    draw_verdicts(ax, SHORTEST, list(100 * shares), codes, texts=most.astype(str))
    ax.set(title=f"{surroundings}, {n} x {n}", xlabel="shortest wave [cells]")
axes[0].set_ylabel("share in contact [%]")
axes[2].set_ylabel("share in contact [%]")
write("rough_iterations", figure, rows)
