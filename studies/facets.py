# SPDX-License-Identifier: MIT OR Apache-2.0
"""Facets: a facetted sphere over a plane, facet size against the approach of the bodies.

A chord of length c on a radius R is c^2 / (8 R) off. Facets known to be too coarse for the approach are
refused; what passes is compared with the exact gap.
"""

import numpy as np
from atlas import GOOD, TOLD, WRONG, draw_verdicts, panels, write

import mtb_rs as mtb

RADIUS = 0.5


def gap_error(cells: int, approach: float) -> float:
    """Largest error of the gap over the contact, over the approach."""
    reach = 0.02
    line = np.linspace(-reach, reach, cells + 1)
    x, y = np.meshgrid(line, line)
    z = RADIUS - np.sqrt(RADIUS**2 - x**2 - y**2)
    corner = (np.arange(cells)[:, None] * (cells + 1) + np.arange(cells)[None]).ravel()
    triangles = np.concatenate(
        [
            np.stack([corner, corner + cells + 2, corner + 1], axis=1),
            np.stack([corner, corner + cells + 1, corner + cells + 2], axis=1),
        ]
    )
    vertices = np.stack([x.ravel(), y.ravel(), z.ravel()])
    upper = mtb.BodySurface.mesh(vertices, triangles, closed=False)
    half = min(0.7 * reach, 1.5 * float(np.sqrt(2.0 * RADIUS * approach)))
    span = (-half, half)
    found = mtb.surface_gap(mtb.BodySurface.plane(), upper, span, span, half / 20.0, approach=approach)
    points = found.grid.cells
    px, py = points.points[:2]
    exact = RADIUS - np.sqrt(RADIUS**2 - px**2 - py**2)
    near = exact < approach
    return float(np.abs(points.gap - exact)[near].max()) / approach


if __name__ == "__main__":
    counts = [4, 8, 16, 32, 64]
    approaches = [1e-7, 1e-6, 1e-5, 1e-4]
    codes = np.zeros((len(approaches), len(counts)), dtype=int)
    texts = np.full(codes.shape, "", dtype=object)
    rows = []
    for (j, i), _ in np.ndenumerate(codes):
        said, error = "", np.nan
        try:
            error = gap_error(counts[i], approaches[j])
            codes[j, i] = GOOD if error < 0.1 else WRONG
            texts[j, i] = f"{100 * error:.2g} %"
        except ValueError as refusal:
            codes[j, i], said = TOLD, str(refusal)
        chord = 0.04 / counts[i]
        rows.append(
            {
                "facet_m": chord,
                "approach_m": approaches[j],
                "sagitta_over_approach": chord**2 / (8 * RADIUS) / approaches[j],
                "verdict": int(codes[j, i]),
                "error": error,
                "said": said,
            }
        )
    figure, (ax,) = panels(1, height=3.6)
    draw_verdicts(ax, [40.0 / c for c in counts], [1e6 * a for a in approaches], codes, texts=texts)
    ax.set(
        title="a sphere of triangles on a plane; numbers: error of the gap over the approach",
        xlabel="width of a facet [mm]",
        ylabel="approach [µm]",
    )
    write("facets", figure, rows)
