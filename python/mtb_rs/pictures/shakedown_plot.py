# SPDX-License-Identifier: MIT OR Apache-2.0
"""The shakedown map: load over friction, with the limits of a line contact."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ..results.damage import elastic_limit, shakedown_limit
from .figures import canvas, style_axes
from .quantities import INK, LINE_COLOURS


def draw_shakedown(friction: float, load: float, ax: Axes | None) -> Figure:
    """See :meth:`mtb_rs.TangentialResult.plot_shakedown`."""
    is_first = ax is None or not ax.lines
    figure, ax = canvas(ax, (5.4, 4.2))
    if is_first:
        most = max(0.6, 1.1 * friction)
        over = np.linspace(0.0, most, 121)
        ax.plot(over, shakedown_limit(over), color=LINE_COLOURS[1], label="limit of shakedown")
        ax.plot(over, elastic_limit(over), color=LINE_COLOURS[0], label="limit of elasticity")
        ax.set(
            xlim=(0.0, most),
            ylim=(0.0, max(5.0, 1.1 * load)),
            xlabel="creep force over normal force",
            ylabel="peak pressure over yield stress in shear",
        )
        ax.set_title("Limits of a line contact in full slip", fontsize=9.5, color=INK)
        ax.legend(frameon=False, fontsize=8.5)
        style_axes(ax)
    ax.plot(friction, load, "o", color=INK, markersize=6)
    if load > ax.get_ylim()[1]:
        ax.set_ylim(0.0, 1.1 * load)
    if friction > ax.get_xlim()[1]:
        ax.set_xlim(0.0, 1.1 * friction)
    return figure
