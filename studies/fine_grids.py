# SPDX-License-Identifier: MIT OR Apache-2.0
"""Elastic bodies on fewer lines than their contact grid has: error over the ratio of the grids, and over the
distance from the edge of the contact.

The default pole shoe is condensed onto all of its contact points, and onto lines between which there are more
and more cells. Errors are those of the pressure against the former.
"""

import numpy as np
from atlas import panels, write

import mtb_rs as mtb
from mtb_rs.base import cache
from mtb_rs.contact import refined

COUNTS = (600, 150, refined.CELLS, 20)
DISTANCES = np.array([0.0, 1.0, 2.0, 3.0, 4.0, 6.0, 8.0]) * 1e-3


def solved(scene: mtb.Scene, cells: int | None) -> mtb.Result:
    """With bodies condensed onto lines of about so many cells; None: onto all contact points."""
    refined.DIRECT_POINTS = 10**9 if cells is None else 0
    refined.CELLS = cells or refined.CELLS
    with cache.memory_only():
        cache.forget()
        return scene.solve("elastic-upper")


def pressure(result: mtb.Result) -> np.ndarray:
    return result.patches[0].view(result.pressure.reshape(-1))


rows = []
figure, (left, right) = panels(2, height=3.6)
for size, colour in ((1.5e-3, "#0072B2"), (1e-3, "#D55E00")):
    scene = mtb.scenes.pole_shoe_on_rail(spacing=size, friction=0.3)
    direct = solved(scene, None)
    patch, expected = direct.patches[0], pressure(direct)
    ends = [np.minimum(np.arange(n), n - 1 - np.arange(n)) for n in (patch.nx, patch.ny)]
    distance = np.minimum(*np.meshgrid(ends[0] * patch.spacing[0], ends[1] * patch.spacing[1]))
    ratios, series = [], {"all points": [], "border": [], "2 mm inside": []}
    for cells in COUNTS:
        found = solved(scene, cells)
        error = np.abs(pressure(found) - expected)
        lines = refined.lines_of(found.patches[:1], refined.carrier_spacing(found.patches))[0]
        ratio = float(np.sqrt(expected.size / (len(lines[0]) * len(lines[1]))))
        ratios.append(ratio)
        parts = {
            "all points": distance >= 0.0,
            "border": distance == 0.0,
            "2 mm inside": distance > 2e-3 - 1e-9,
        }
        for name, at in parts.items():
            mean = float(error[at].mean() / expected[at].mean())
            worst = float(error[at].max() / expected[at].mean())
            series[name].append(mean)
            rows.append(
                {
                    "cells_mm": 1e3 * size,
                    "lines": f"{len(lines[0])} x {len(lines[1])} of {patch.nx} x {patch.ny}",
                    "ratio": ratio,
                    "points": name,
                    "mean_error": mean,
                    "worst_over_mean_pressure": worst,
                    "condensation_operations": found.report.operations["condensation"],
                    "direct_operations": direct.report.operations["condensation"],
                }
            )
        if cells == COUNTS[2]:
            near = [
                (distance >= a - 1e-9) & (distance < b - 1e-9)
                for a, b in zip(DISTANCES, [*DISTANCES[1:], np.inf], strict=True)
            ]
            shown = [(d, error[at], expected[at]) for d, at in zip(DISTANCES, near, strict=True) if at.any()]
            label = f"cells of {1e3 * size:g} mm"
            where = [1e3 * d for d, _, _ in shown]
            right.semilogy(
                where,
                [100 * e.mean() / p.mean() for _, e, p in shown],
                "o-",
                color=colour,
                label=f"{label}, mean",
            )
            right.semilogy(
                where,
                [100 * e.max() / p.mean() for _, e, p in shown],
                "^--",
                color=colour,
                label=f"{label}, worst",
            )
            rows += [
                {
                    "cells_mm": 1e3 * size,
                    "lines": f"{len(lines[0])} x {len(lines[1])} of {patch.nx} x {patch.ny}",
                    "ratio": ratio,
                    "points": f"from {1e3 * d:g} mm on",
                    "mean_error": float(e.mean() / p.mean()),
                    "worst_over_mean_pressure": float(e.max() / p.mean()),
                    "condensation_operations": found.report.operations["condensation"],
                    "direct_operations": direct.report.operations["condensation"],
                }
                for d, e, p in shown
            ]
    for (name, errors), mark in zip(series.items(), "osD", strict=True):
        left.semilogy(
            ratios, 100 * np.array(errors), mark + "-", color=colour, label=f"{1e3 * size:g} mm, {name}"
        )
left.set(
    xlabel="root of points over coarse points", ylabel="mean error of the pressure [%]", ylim=(0.008, 1.0)
)
right.set(xlabel="distance from the border [mm]", ylabel="error of the pressure [%]")
left.legend(fontsize=6, loc="lower left")
right.legend(fontsize=6)
write("fine_grids", figure, rows)
