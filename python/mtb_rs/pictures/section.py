# SPDX-License-Identifier: MIT OR Apache-2.0
"""The bodies of a scene before anything presses them, cut across at x = 0."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure
from numpy.typing import NDArray

from ..geometry.triangles import Surface
from .figures import canvas, style_axes
from .quantities import INK

Array = NDArray[np.float64]

#: Colours of the upper and of the lower body.
UPPER, LOWER = "#0072b2", INK
#: Width over height of what is drawn from which on both axes have scales of their own.
FLATTEST = 12.0


def draw_section(surfaces: Sequence[Surface]) -> Figure:
    """Lines y, z in which surfaces, called "upper..." or "lower...", meet the plane x = 0.

    Surfaces that do not reach it are cut in their middle.
    """
    figure, ax = canvas(None, (4.6, 3.0))
    scale = 1e3
    low, high = np.full(2, np.inf), np.full(2, -np.inf)
    for surface in surfaces:
        lines = scale * cut(surface)
        if not lines.size:
            continue
        color = UPPER if surface.name.startswith("upper") else LOWER
        ax.add_collection(LineCollection(list(lines), colors=color, linewidths=1.6, capstyle="round"))
        low = np.minimum(low, lines.min(axis=(0, 1)))
        high = np.maximum(high, lines.max(axis=(0, 1)))
    for side, color in (("upper", UPPER), ("lower", LOWER)):
        labels = {surface.label for surface in surfaces if surface.name.startswith(side)}
        ax.plot([], [], color=color, label=labels.pop() if len(labels) == 1 else f"{side} body")
    width, height = np.maximum(high - low, 1e-9)
    ax.set(xlabel="y [mm]", ylabel="z [mm]")
    ax.set_xlim(low[0] - 0.05 * width, high[0] + 0.05 * width)
    ax.set_ylim(low[1] - 0.08 * height, high[1] + 0.08 * height)
    if width < FLATTEST * height:
        ax.set_aspect("equal", adjustable="box")
    else:
        ax.set_title("heights are drawn larger than widths", fontsize=8.5, color=INK)
    figure.legend(frameon=False, fontsize=8.5, loc="outside lower center", ncols=2)
    style_axes(ax)
    return figure


def cut(surface: Surface) -> Array:
    """Lines (k, 2, 2) from y, z to y, z [m] in which a surface meets the plane x = 0, or else its middle."""
    x = surface.vertices[0]
    middle = 0.0 if x.min() <= 0.0 <= x.max() else 0.5 * (x.min() + x.max())
    # beside the plane, so that no edge lies in it
    corners = (
        surface.vertices[:, surface.triangles]
        - np.array([middle + 1e-7 * np.ptp(x), 0.0, 0.0])[:, None, None]
    )
    ends = []
    for a, b in ((0, 1), (1, 2), (2, 0)):
        first, last = corners[:, :, a], corners[:, :, b]
        meets = (first[0] > 0.0) != (last[0] > 0.0)
        share = first[0] / np.where(meets, first[0] - last[0], 1.0)
        place = np.where(meets, first[1:] + share * (last[1:] - first[1:]), np.nan)
        ends.append(place.T)
    met = np.stack(ends, axis=1)
    met = met[(~np.isnan(met[..., 0])).sum(axis=1) == 2]
    return np.asarray(met[~np.isnan(met[..., 0])].reshape(-1, 2, 2))
