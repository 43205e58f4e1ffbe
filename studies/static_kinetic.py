# SPDX-License-Identifier: MIT OR Apache-2.0
"""Static and kinetic friction on finer and finer grids: jump between the coefficients x cells, in shifts and
steady rolling.

A sphere on a plane; cells of each grid are quarters of those of the one before. Shown is by how much the
tractions change with the next grid, summed over the patch, over their own sum. With one coefficient
(ratio 1: Coulomb's law) that falls as it must; with two the border of the slip area hangs on single cells.
"""

from itertools import pairwise

import numpy as np
from atlas import draw_verdicts, panels, write

import mtb_rs as mtb
from mtb_rs import reference

names = ("as with one coefficient", "no state found (said)", "hangs on the grid")
colours = ("#56B4E9", "#E69F00", "#CC79A7")
ratios = [1.0, 0.9, 0.75, 0.5, 0.25]
cells = [12, 24, 48, 96]
static, load, radius = 0.4, 1e4, 3.2e-3
body = mtb.Material.from_shear_modulus(82e9, 0.28)
#: Change beyond that of Coulomb's law from which on the tractions hang on the grid.
BEYOND = 2.0

motions = (
    ("shift by 2 µm", mtb.Shift(displacement=(2e-6, 0.0))),
    ("shift by 4 µm", mtb.Shift(displacement=(4e-6, 0.0))),
    ("rolling, creepage 1 ‰", mtb.Rolling(creepage=(1e-3, 0.0, 0.0))),
    ("rolling, creepage 1 ‰ and spin", mtb.Rolling(creepage=(1e-3, 0.0, 0.5))),
)


def tractions(motion: mtb.Shift | mtb.Rolling, ratio: float) -> list[np.ndarray | str]:
    """On each grid (2, n, n) [Pa], or why there are none."""
    found: list[np.ndarray | str] = []
    for n in cells:
        patch = reference.elliptic_pressure(load, (radius, radius), (n, n), body, body)
        try:
            law = mtb.StaticKinetic(static, ratio * static)
            found.append(np.asarray(mtb.solve_tangential(patch, motion, law).traction[:2]))
        except mtb.ConvergenceError as refusal:
            found.append(str(refusal)[:200])
    return found


def change(rough: np.ndarray | str, fine: np.ndarray | str) -> float:
    """Between two grids, relative; NaN where one has no state."""
    if isinstance(rough, str) or isinstance(fine, str):
        return float("nan")
    mean = sum(fine[:, j::2, i::2] for j in (0, 1) for i in (0, 1)) / 4
    return float(np.abs(mean - rough).sum() / np.abs(rough).sum())


if __name__ == "__main__":
    figure, axes = panels(len(motions), height=2.7)
    rows = []
    for ax, (title, motion) in zip(axes, motions, strict=True):
        found = [tractions(motion, ratio) for ratio in ratios]
        changes = np.array([[change(*pair) for pair in pairwise(line)] for line in found])
        codes = np.where(np.isnan(changes), 1, np.where(changes > BEYOND * changes[0], 2, 0))
        texts = np.array([["" if np.isnan(c) else f"{100 * c:.1f}" for c in line] for line in changes])
        for (j, i), code in np.ndenumerate(codes):
            said = next((s for s in found[j][i : i + 2] if isinstance(s, str)), "")
            rows.append(
                {
                    "case": title,
                    "kinetic_over_static": ratios[j],
                    "cells": cells[i],
                    "verdict": names[code],
                    "change": float(changes[j, i]),
                    "said": said,
                }
            )
        draw_verdicts(ax, cells[:-1], ratios, codes, names=names, colours=colours, texts=texts)
        ax.set_xticks(range(len(cells) - 1), [f"{a} to {b}" for a, b in pairwise(cells)])
        ax.set(title=title, xlabel="cells over the patch", ylabel="kinetic over static")
    write("static_kinetic", figure, rows)
