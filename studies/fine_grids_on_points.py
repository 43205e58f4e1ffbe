# SPDX-License-Identifier: MIT OR Apache-2.0
"""Elastic bodies on supports at points, condensed onto fewer lines than their contact grid has: error against
direct condensation, and its estimate.

Bodies give way at such supports by the width of their elements. Those of a body on lines are wider than the
cells, unless `element_size` gives both bodies the same.
"""

from typing import Any

import numpy as np
from atlas import panels, write

import mtb_rs as mtb
from mtb_rs.base import cache
from mtb_rs.contact import refined

SPACINGS = 2e-3, 1.6e-3, 1.4e-3
ELEMENTS = 3e-3
SUPPORTS: dict[str, Any] = {"clamped-top": "#0072B2", "points": "#D55E00", "fixed-points": "#009E73"}


def solved(scene: mtb.Scene, few: float) -> mtb.Result:
    """With bodies condensed onto all contact points up to so `few`."""
    refined.DIRECT_POINTS = int(few)
    with cache.memory_only():
        cache.forget()
        return scene.solve("elastic-upper")


def pressure(result: mtb.Result) -> np.ndarray:
    return result.patches[0].view(result.pressure.reshape(-1))


rows = []
for supports in SUPPORTS:
    for spacing in SPACINGS:
        for elements in (None, ELEMENTS):
            scene = mtb.scenes.block_on_plane(0.04, 0.04, friction=0.3, spacing=spacing, supports=supports)
            scene = scene.with_(element_size=elements)
            direct = solved(scene, 1e9)
            # wider cells, on which errors are estimated, are few enough
            found = solved(scene, 0.5 * direct.pressure.size)
            expected = pressure(direct)
            error = np.abs(pressure(found) - expected)
            away = (pressure(found) - expected)[1:-1, 1:-1]
            rows.append(
                {
                    "supports": supports,
                    "cells_mm": 1e3 * spacing,
                    "element_size_mm": "" if elements is None else f"{1e3 * elements:g}",
                    "points": expected.size,
                    "mean_error": float(error.mean() / expected.mean()),
                    "worst_over_mean_pressure": float(error.max() / expected.mean()),
                    "error_away_from_border": float(
                        np.linalg.norm(away) / np.linalg.norm(expected[1:-1, 1:-1])
                    ),
                    "estimate": found.report.error_estimates["pressure"],
                }
            )
            print(rows[-1], flush=True)

figure, (left, right) = panels(2, height=3.6)
for supports, colour in SUPPORTS.items():
    for elements, mark in (("", "o-"), (f"{1e3 * ELEMENTS:g}", "s--")):
        own = [row for row in rows if (row["supports"], row["element_size_mm"]) == (supports, elements)]
        label = f"{supports}, elements of {elements} mm" if elements else supports
        left.semilogy(
            [row["cells_mm"] for row in own],
            [100 * row["mean_error"] for row in own],
            mark,
            color=colour,
            label=label,
        )
        right.loglog(
            [100 * row["estimate"] for row in own],
            [100 * row["error_away_from_border"] for row in own],
            mark[0],
            color=colour,
        )
ends = np.array([0.3, 30.0])
right.loglog(ends, ends, "k-", lw=0.8)
right.loglog(ends, 2.0 * ends, "k:", lw=0.8)
left.set(xlabel="cells [mm]", ylim=(0.05, 60.0), ylabel="mean error of the pressure [%]")
right.set(xlabel="estimated error [%]", ylabel="error away from the border [%]")
left.legend(fontsize=6)
write("fine_grids_on_points", figure, rows)
