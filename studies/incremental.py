# SPDX-License-Identifier: MIT OR Apache-2.0
"""The thesis' load increments over their number and the distance tolerance, against the direct solution.

A paraboloid on a plane; the distance tolerance counts in first increments, the default is 2. A lower body
much stiffer than the upper one is the scheme's limit: it carries the pressures of both bodies along, and
under friction they come apart. Other unlike pairs do as well as like ones (tests/maps).
"""

import numpy as np
from atlas import GOOD, TOLD, WRONG, draw_verdicts, panels, write

import mtb_rs as mtb

hard = mtb.Material(young_modulus=600e9, poisson_ratio=0.2)
steps = [2, 4, 8, 16, 32]
tolerances = [0.01, 0.1, 0.5, 2.0, 5.0, 20.0]
rows = []
figure, axes = panels(3, columns=3, height=3.9)
cases = (
    ("steel on steel, no friction", 0.0, mtb.steel),
    ("steel on steel, friction 0.5", 0.5, mtb.steel),
    ("steel on carbide, friction 0.5", 0.5, hard),
)
for ax, (name, mu, lower) in zip(axes, cases, strict=True):
    scene = mtb.scenes.paraboloid_on_plane(points=12, friction=mu, lower=lower, upper=mtb.steel)
    direct = scene.solve("half-space")
    codes = np.zeros((len(tolerances), len(steps)), dtype=int)
    texts = np.full(codes.shape, "", dtype=object)
    for i, count in enumerate(steps):
        for j, tolerance in enumerate(tolerances):

            def attempt(scene=scene, direct=direct, count=count, tolerance=tolerance) -> float:
                found = scene.solve(
                    "half-space",
                    method="incremental",
                    estimated_steps=count,
                    distance_tolerance=tolerance * float(direct.approach) / count,
                )
                return float(
                    np.linalg.norm(found.pressure - direct.pressure) / np.linalg.norm(direct.pressure)
                )

            try:
                error, said = attempt(), ""
                codes[j, i] = GOOD if error < 0.02 else WRONG
            except mtb.ConvergenceError as refusal:
                error, said, codes[j, i] = np.nan, str(refusal), TOLD
            texts[j, i] = f"{100 * error:.1g}" if np.isfinite(error) else ""
            rows.append(
                {
                    "bodies": name,
                    "friction": mu,
                    "steps": count,
                    "distance_tolerance_in_steps": tolerance,
                    "verdict": int(codes[j, i]),
                    "error": error,
                    "said": said,
                }
            )
    draw_verdicts(ax, steps, tolerances, codes, texts=texts)
    ax.set(
        title=name,
        xlabel="load increments",
    )
axes[0].set_ylabel("distance tolerance / first increment")
write("incremental", figure, rows)
