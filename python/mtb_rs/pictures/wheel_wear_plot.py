# SPDX-License-Identifier: MIT OR Apache-2.0
"""Worn profiles of wheels and rails, and how the depth grows."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from .figures import canvases, style_axes
from .quantities import INK, LINE_COLOURS, MILLIMETRE

#: Lines of depth at most.
MOST_LINES = 6


def draw_wheel_wear(of: Any, ax: tuple[Axes, Axes] | None) -> Figure:
    """See :meth:`mtb_rs.WheelWear.plot`."""
    figure, left, right = canvases(ax, (9.6, 3.8))
    bodies = [("wheel", of.wheel_points, of.wheel_depths)]
    if of.rail_depths.any():
        bodies.append(("rail", of.rail_points, of.rail_depths))
    for (name, points, _), colour in zip(bodies, LINE_COLOURS, strict=False):
        left.plot(*points[0] / MILLIMETRE, color=colour, linewidth=0.9, linestyle="--", label=f"{name}, new")
        left.plot(*points[-1] / MILLIMETRE, color=colour, linewidth=1.4, label=f"{name}, worn")
    left.set(xlabel="y [mm]", ylabel="z [mm]")
    last = of.distances.size - 1
    chosen = np.unique(np.linspace(1, last, min(last, MOST_LINES)).round().astype(int))
    for k in chosen:
        shade = 0.25 + 0.75 * k / last
        for (name, points, depths), colour, style in zip(bodies, LINE_COLOURS, ("-", "--"), strict=False):
            told = f"{of.distances[k] / 1e3:,.0f} km".replace(",", " ") if name == "wheel" else None
            right.plot(
                points[k, 0] / MILLIMETRE,
                depths[k] / MILLIMETRE,
                style,
                color=colour,
                alpha=shade,
                linewidth=1.2,
                label=told,
            )
    right.set(xlabel="y [mm]", ylabel="depth worn off [mm]")
    right.set_ylim(bottom=0.0)
    for axes in (left, right):
        style_axes(axes)
        axes.legend(frameon=False, fontsize=8.5)
    right.set_title("wheel solid, rail dashed" if len(bodies) > 1 else "wheel", fontsize=9.5, color=INK)
    return figure
