# SPDX-License-Identifier: MIT OR Apache-2.0
"""Solvers of the frictional complementarity problem: active sets against projected Gauss-Seidel.

Over friction, slenderness and grid, on the matrix of a clamped block sliding on a half-space. Below the
line the matrix is positive definite, so there is exactly one solution; Gauss-Seidel cycles long before.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np
from atlas import draw_verdicts, panels, write

import mtb_rs as mtb
from mtb_rs.contact.solve import sided_influence


def gauss_seidel(matrix: np.ndarray, offset: np.ndarray, omega: float, sweeps: int) -> int | None:
    """Sweeps of projected Gauss-Seidel to a residual of 1e-8, None if they do not suffice."""
    pressure = np.zeros(offset.size)
    scale = np.abs(offset).max()
    for sweep in range(1, sweeps + 1):
        for i in range(offset.size):
            pressure[i] = max(0.0, pressure[i] - omega * (offset[i] + matrix[i] @ pressure) / matrix[i, i])
        if not np.isfinite(pressure).all() or pressure.max() * np.abs(matrix).max() > 1e12 * scale:
            return None
        slack = offset + matrix @ pressure
        if np.abs(np.minimum(slack, pressure * matrix[0, 0])).max() < 1e-8 * scale:
            return sweep
    return None


def examine(ratio: float, cells: int, frictions: Sequence[float]) -> list[dict[str, Any]]:
    """What both solvers make of a block `ratio` times as high as wide, at some friction coefficients."""
    block = mtb.scenes.block_on_plane(height=0.1 * ratio, friction=1.0, spacing=0.1 / cells)
    problem = block.problem("elastic-upper")
    one = problem.friction.fixed
    sides = ((problem.lower, False), (problem.upper, True))
    smooth, rubbing = (
        sum(sided_influence(s.compliance, problem.direction, mu, upper=upper) for s, upper in sides)
        for mu in (0.0 * one, one)
    )
    weight = np.sqrt(problem.area)
    similar = weight[:, None] / weight[None, :]
    normal, coupled = smooth * similar, (rubbing - smooth) * similar
    root = np.linalg.inv(np.linalg.cholesky(0.5 * (normal + normal.T)))
    limit = 1.0 / np.linalg.eigvalsh(-root @ (0.5 * (coupled + coupled.T)) @ root.T).max()
    offset = problem.loading.gap
    rows = []
    for mu in frictions:
        try:
            result = block.with_(friction=mu).solve("elastic-upper")
            iterations, lemke = result.report.iterations, "Lemke" in result.report.solver
        except mtb.ConvergenceError:
            iterations, lemke = None, True
        sweeps = gauss_seidel(smooth + mu * (rubbing - smooth), offset, 1.0, 1500)
        rows.append(
            {
                "points": problem.n,
                "height_over_width": ratio,
                "friction": mu,
                "mu_sym": limit,
                "positive_definite": int(mu < limit),
                "active_set_iterations": iterations or "none",
                "needed_lemke": int(lemke),
                "gauss_seidel_sweeps": sweeps or "none",
            }
        )
    return rows


if __name__ == "__main__":
    names = (
        "both converge",
        "only active sets converge",
        "no sliding equilibrium (said)",
        "only Gauss-Seidel converges",
    )
    colours = ("#56B4E9", "#E69F00", "#BBBBBB", "#000000")
    slenderness = [0.5, 1.0, 2.0, 3.5, 5.0]
    frictions = [0.05, 0.1, 0.2, 0.3, 0.5, 0.7, 1.0, 1.5]
    rows = []
    figure, axes = panels(2, height=3.8)
    for ax, cells in zip(axes, (6, 10), strict=True):
        codes = np.zeros((len(frictions), len(slenderness)), dtype=int)
        texts = np.full(codes.shape, "", dtype=object)
        limits = []
        for i, ratio in enumerate(slenderness):
            found = examine(ratio, cells, frictions)
            limits.append(found[0]["mu_sym"])
            for j, row in enumerate(found):
                iterations, sweeps = row["active_set_iterations"], row["gauss_seidel_sweeps"]
                solved = iterations != "none", sweeps != "none"
                codes[j, i] = {(True, True): 0, (True, False): 1, (False, False): 2, (False, True): 3}[solved]
                texts[j, i] = f"{iterations}" if iterations != "none" else ""
            rows += found
        draw_verdicts(ax, slenderness, frictions, codes, names=names, colours=colours, texts=texts)
        # a limit beyond the map stands at its border
        places = np.interp(
            np.log(limits), np.log(frictions), np.arange(len(frictions)), right=len(frictions) - 0.5
        )
        ax.plot(range(len(slenderness)), places, "-", color="black", lw=2, alpha=0.55)
        ax.set(
            title=f"{rows[-1]['points']} contact points",
            xlabel="height / width",
            ylabel="friction coefficient",
        )
    write("complementarity", figure, rows)
