# SPDX-License-Identifier: MIT OR Apache-2.0
"""Solvers of the frictional complementarity problem: active sets against projected Gauss-Seidel.

Over friction, slenderness and grid, on the matrix of a clamped block sliding on a half-space. Below the
line the matrix is positive definite, so there is exactly one solution; Gauss-Seidel cycles long before.
"""

import numpy as np
from atlas import draw_verdicts, panels, write

import mtb_rs as mtb
from mtb_rs.solve import sided_influence


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


names = ("both", "active sets only", "no sliding equilibrium (said)", "neither")
colours = ("#56B4E9", "#E69F00", "#BBBBBB", "#000000")
slenderness = [0.5, 1.0, 2.0, 3.5, 5.0]
frictions = [0.05, 0.1, 0.2, 0.3, 0.5, 0.7, 1.0, 1.5]
rows = []
figure, axes = panels(2, width=5.4)
for ax, cells in zip(axes, (6, 10), strict=True):
    codes = np.zeros((len(frictions), len(slenderness)), dtype=int)
    texts = np.full(codes.shape, "", dtype=object)
    limits = []
    for i, ratio in enumerate(slenderness):
        block = mtb.scenes.block_on_plane(height=0.1 * ratio, friction=1.0, spacing=0.1 / cells)
        problem = block.problem("elastic-upper")
        one = problem.friction
        smooth = sum(
            sided_influence(side.compliance, problem.direction, 0.0 * one, upper=upper)
            for side, upper in ((problem.lower, False), (problem.upper, True))
        )
        rubbing = sum(
            sided_influence(side.compliance, problem.direction, one, upper=upper)
            for side, upper in ((problem.lower, False), (problem.upper, True))
        )
        weight = np.sqrt(problem.area)
        similar = weight[:, None] / weight[None, :]
        normal, coupled = smooth * similar, (rubbing - smooth) * similar
        root = np.linalg.inv(np.linalg.cholesky(0.5 * (normal + normal.T)))
        largest = np.linalg.eigvalsh(-root @ (0.5 * (coupled + coupled.T)) @ root.T).max()
        limits.append(1.0 / largest)
        offset = problem.opening()
        for j, mu in enumerate(frictions):
            scene = block.with_(friction=mu)
            try:
                result = scene.solve("elastic-upper")
                direct, iterations = True, result.report.iterations
                lemke = "Lemke" in result.report.solver
            except mtb.ConvergenceError:
                direct, iterations, lemke = False, 0, True
            sweeps = gauss_seidel(smooth + mu * (rubbing - smooth), offset, 1.0, 1500)
            codes[j, i] = {(True, True): 0, (True, False): 1, (False, False): 2, (False, True): 3}[
                direct, sweeps is not None
            ]
            texts[j, i] = f"{iterations} | {sweeps or '-'}"
            rows.append(
                {
                    "points": problem.n,
                    "height_over_width": ratio,
                    "friction": mu,
                    "mu_sym": limits[-1],
                    "positive_definite": int(mu < limits[-1]),
                    "active_set_iterations": iterations if direct else "none",
                    "needed_lemke": int(lemke),
                    "gauss_seidel_sweeps": sweeps or "none",
                }
            )
    draw_verdicts(ax, slenderness, frictions, codes, names=names, colours=colours, texts=texts)
    places = np.interp(np.log(limits), np.log(frictions), np.arange(len(frictions)))
    ax.plot(range(len(slenderness)), places, "o-", color="#D55E00", lw=1.5, ms=3, alpha=0.7)
    ax.set(
        title=f"{problem.n} points; sets | sweeps; line: positive definite below",
        xlabel="height / width",
        ylabel="friction coefficient",
    )
    ax.title.set_fontsize(9)
write("complementarity", figure, rows)
