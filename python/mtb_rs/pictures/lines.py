# SPDX-License-Identifier: MIT OR Apache-2.0
"""Cuts through a field along the lines of its grids."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import cycle
from typing import Literal

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from ..base.words import Body, Limits
from ..base.words import Field as Word
from ..geometry.contact_points import Patch
from ..results.grids import flat, line_borders, patches
from ..results.result import Pictured
from .figures import canvas, from_zero, label_of, style_axes
from .quantities import INK, LINE_COLOURS, MILLIMETRE, STATUS_NAMES, quantity_of, states_of, unit_of

Array = NDArray[np.float64]


def draw_lines(
    result: Pictured,
    quantity: Word,
    cut: Literal["x", "y"],
    at: float | Iterable[float] | None,
    body: Body,
    limits: Limits | None,
    ax: Axes | None,
) -> Figure:
    """The quantity along the lines of cells whose coordinate `cut` is nearest to `at`; what is constant by
    cell is drawn as steps."""
    asked = quantity_of(result, quantity, body)
    grids = patches(result)
    if not grids:
        raise ValueError('kind="line" needs a regular grid of contact points; this result has scattered ones')
    x, y = flat(result, result.points)[:2] / MILLIMETRE
    place, along = (y, x) if cut == "y" else (x, y)
    lines = [_Line(patch, cut, k) for patch in grids for k in range(patch.ny if cut == "y" else patch.nx)]
    if at is None:
        peak = np.array([line.of(flat(result, result.pressure)).max() for line in lines])
        chosen = [[lines[int(peak.argmax())]]]
    else:
        chosen = _nearest(lines, np.array([line.of(place).mean() for line in lines]), cut, at)

    values = flat(result, asked.values).astype(float)
    factor, unit = (
        (1.0, "")
        if quantity == "status"
        else unit_of(
            np.concatenate([line.of(values) for pieces in chosen for line in pieces])
            if limits is None
            else np.array(limits),
            asked.unit,
        )
    )
    figure, ax = canvas(ax, (7.2, 3.9))
    for pieces, colour in zip(chosen, cycle(LINE_COLOURS), strict=False):
        at = round(float(pieces[0].of(place).mean()), 9)  # the middle of a grid is zero but for rounding
        label: str | None = f"{cut} = {at + 0.0:.3g} mm".replace("-", "\N{MINUS SIGN}")
        for line in pieces:
            centres = line.of(along)
            field = line.of(values) / factor
            if asked.unit == "m":
                ax.plot(centres, field, color=colour, linewidth=1.6, label=label)
            else:
                edges = line_borders(result, line.patch, cut)[line.index] / MILLIMETRE
                ax.stairs(field, edges, baseline=None, color=colour, linewidth=1.6, label=label)
            if centres.size <= 80:
                ax.plot(centres, field, ".", color=colour, markersize=4)
            label = None
    if not any(line.of(values).any() for pieces in chosen for line in pieces) and quantity != "status":
        ax.text(0.5, 0.5, "zero all along", transform=ax.transAxes, ha="center", fontsize=9, color=INK)
        ax.set_ylim(0.0, 1.0)
    if quantity == "status":
        count = states_of(result.status)
        ax.set_yticks(range(count), STATUS_NAMES[:count])
        ax.set_ylim(-0.3, count - 0.7)
    elif limits is not None:
        ax.set_ylim(limits[0] / factor, limits[1] / factor)
    elif not asked.is_signed:
        from_zero(ax)
    ax.margins(x=0.02)
    ax.set_xlabel("x [mm]" if cut == "y" else "y [mm]")
    ax.set_ylabel(f"{asked.label} [{unit}]" if unit else asked.label)
    ax.set_title(label_of(asked, body), loc="left", fontsize=10.5, color=INK)
    ax.legend(
        frameon=False, fontsize=9, loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=4, borderaxespad=0.2
    )
    style_axes(ax)
    ax.grid(True, color="#DDDDDD", linewidth=0.6)
    return figure


@dataclass(frozen=True)
class _Line:
    """A line of cells: a row, at a y, or a column, at an x."""

    patch: Patch
    cut: Literal["x", "y"]
    index: int

    def of(self, values: Array) -> Array:
        field = self.patch.view(values)
        return np.asarray(field[self.index] if self.cut == "y" else field[:, self.index])


def _nearest(
    lines: Sequence[_Line], places: Array, cut: Literal["x", "y"], at: float | Iterable[float]
) -> list[list[_Line]]:
    """The lines, at `places` [mm], that a cut `at` each [m] goes through: of every patch that reaches there,
    or else the nearest one."""
    wanted = np.atleast_1d(np.asarray(at, dtype=float))
    if wanted.ndim != 1 or not wanted.size or not np.all(np.isfinite(wanted)):
        raise ValueError(f"{cut} is {at!r}: finite numbers [m] are needed")
    reach = np.array([line.patch.spacing[0 if cut == "x" else 1] for line in lines]) / MILLIMETRE
    # rounding puts no cut beyond the outermost cells
    low, high = (places - 0.5 * reach).min() - 1e-6, (places + 0.5 * reach).max() + 1e-6
    outside = wanted[(wanted < MILLIMETRE * low) | (wanted > MILLIMETRE * high)]
    if outside.size:
        raise ValueError(
            f"{cut} is {outside[0]:g} m: the contact points lie between {cut} = {MILLIMETRE * low:.4g} and "
            f"{MILLIMETRE * high:.4g} m"
        )
    # rounding must not decide between two lines equally far: the first wins
    distance = np.round(np.abs(places - wanted[:, None] / MILLIMETRE), 6)
    starts = np.array([line.patch.start for line in lines])
    found: dict[int, list[_Line]] = {}
    for away in distance:
        first = int(away.argmin())
        best = [int(np.where(starts == start, away, np.inf).argmin()) for start in np.unique(starts)]
        through = [k for k in best if k == first or away[k] <= 0.5 * reach[k]]
        found.setdefault(first, [lines[k] for k in sorted(through)])
    return list(found.values())
