# SPDX-License-Identifier: MIT OR Apache-2.0
"""Convolutions of a contact whose pressure is bounded by a hardness, over those of the elastic one.

Usage: python studies/hardness_iterations.py [CELLS ...]. A ball, and self-affine surfaces of Hurst exponent
0.3, 0.6 and 0.9 with a shortest wave of 4 cells, periodic and on a bowl in free space, under two loads each.
The hardness is a share of the elastic peak pressure; the tolerance is 1e-8. The map shows the most
of the cases of a cell.
"""

import sys
import warnings

import numpy as np
from atlas import GOOD, TOLD, draw_verdicts, panels, write

import mtb_rs as mtb

CELLS = [int(cells) for cells in sys.argv[1:]] or [128, 512]
SHARES = [0.3, 0.5, 0.7, 0.9, 0.95]
SLOPE, STEP = 0.02, 1e-6
PAIR = {"lower": mtb.steel, "upper": mtb.Rigid()}


def surfaces(n: int) -> dict[str, list[tuple[dict, float]]]:
    """Gaps with the way to solve them [m], and forces [N]."""
    x = ((np.arange(n) + 0.5) / n - 0.5) * n * STEP
    bowl = (x[None, :] ** 2 + x[:, None] ** 2) * (SLOPE / (n * STEP))
    whole = 0.5 * mtb.steel.plane_strain_modulus * SLOPE * (n * STEP) ** 2
    # the contact of the ball is as wide as 30 % and 80 % of the grid
    radius = 0.5 * n * STEP / SLOPE
    ball = [
        4.0 / 3.0 * mtb.steel.plane_strain_modulus * (share * n * STEP / 2) ** 3 / radius
        for share in (0.3, 0.8)
    ]
    cases: dict[str, list[tuple[dict, float]]] = {"ball": [({"gap": bowl}, force) for force in ball]}
    for hurst in (0.3, 0.6, 0.9):
        heights = mtb.roughness(n, STEP, hurst=hurst, rms_slope=SLOPE, shortest=4 * STEP, seed=4)
        flat = {"gap": heights.max() - heights, "periodic": True}
        curved = {"gap": heights.max() - heights + bowl, "edge": "sharp"}
        cases[f"rough, {hurst}"] = [(flat, load * whole) for load in (0.1, 0.5)]
        cases[f"rough bowl, {hurst}"] = [(curved, load * whole) for load in (0.05, 0.3)]
    return cases


warnings.simplefilter("ignore")
rows = []
figure, axes = panels(len(CELLS), height=3.6)
for ax, n in zip(axes, CELLS, strict=False):
    named = surfaces(n)
    most = np.zeros((len(named), len(SHARES)))
    codes = np.full(most.shape, GOOD)
    for j, (name, cases) in enumerate(named.items()):
        for words, force in cases:
            words = {"spacing": STEP, "force": force, "tolerance": 1e-8, "method": "fft", **PAIR, **words}
            elastic = mtb.solve_normal(**words)
            for i, share in enumerate(SHARES):
                hardness = share * elastic.report.peak_pressure
                if force > 0.8 * hardness * (n * STEP) ** 2:
                    # nearly all of the grid would flow
                    continue
                try:
                    found, said = mtb.solve_normal(**words, hardness=hardness), ""
                except mtb.ConvergenceError as refusal:
                    found, said, codes[j, i] = refusal.result, str(refusal), TOLD
                ratio = found.report.convolutions / elastic.report.convolutions
                most[j, i] = max(most[j, i], ratio)
                rows.append(
                    {
                        "surface": name,
                        "cells_a_side": n,
                        "force": force,
                        "hardness_over_elastic_peak": share,
                        "share_in_contact": float((elastic.status > 0).mean()),
                        "share_of_it_that_flows": float(
                            (found.pressure >= hardness).sum() / (found.status > 0).sum()
                        ),
                        "convolutions_elastic": elastic.report.convolutions,
                        "convolutions": found.report.convolutions,
                        "ratio": ratio,
                        "preconditionings_ratio": found.report.preconditionings
                        / elastic.report.preconditionings,
                        "said": said,
                    }
                )
                print(rows[-1], flush=True)
    texts = np.vectorize(lambda ratio: f"{ratio:.2f}" if ratio else "")(most)
    names = ("solved", "does not converge, and says so", "")
    draw_verdicts(ax, SHARES, list(range(len(named))), codes, names=names, texts=texts)
    ax.set_yticks(range(len(named)), list(named))
    ax.set(title=f"{n} x {n}", xlabel="hardness over the elastic peak")
write("hardness_iterations", figure, rows)
