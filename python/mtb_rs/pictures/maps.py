# SPDX-License-Identifier: MIT OR Apache-2.0
"""Maps of a field over the contact, seen from above."""

from __future__ import annotations

import textwrap
from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.collections import LineCollection
from matplotlib.colors import BoundaryNorm, ListedColormap
from matplotlib.figure import Figure
from matplotlib.patches import Patch as Swatch
from matplotlib.transforms import Affine2D, ScaledTranslation
from matplotlib.tri import Triangulation
from numpy.typing import NDArray

from ..base.words import Body, Limits
from ..base.words import Field as Word
from ..results.fields import Field
from ..results.grids import corners, flat, patches
from ..results.result import Pictured
from .figures import canvas, figure_of, label_of, new_figure, style_axes
from .quantities import (
    INK,
    MILLIMETRE,
    OPEN_COLOUR,
    STATUS_COLOURS,
    STATUS_NAMES,
    colour_scale,
    quantity_of,
    without_rounding,
)

Array = NDArray[np.float64]


#: Lower and upper ends (x, y) [mm] of what a map shows.
Window = tuple[Array, Array]


def draw_map(
    result: Pictured,
    quantity: Word,
    body: Body,
    limits: Limits | None,
    ax: Axes | None,
    *,
    panel: bool = False,
    window: Window | None = None,
) -> Figure:
    """The quantity over all patches, seen from above, on one colour scale.

    A `panel` of several leaves the key to the colours and the direction of friction to the whole. `window` is
    that of the result, unless it is given.
    """
    asked = quantity_of(result, quantity, body)
    grids = patches(result)
    points = flat(result, result.points)
    x, y = points[:2]
    values = flat(result, asked.values).astype(float)
    closed = flat(result, result.status) > 0
    window = window_of([result], asked) if window is None and not panel else window
    shown = closed if asked.extent == "contact" else inside_window(result, window)
    cells = [corners(result, patch, points)[:2] / MILLIMETRE for patch in grids]
    if window is None:
        # with their cells: the points of one row have no height
        places = np.concatenate([edges.reshape(2, -1) for edges in cells] or [points[:2]], axis=1)
        width, height = np.ptp(places, axis=1)
    else:
        width, height = window[1] - window[0]
    ratio = float(height / width)
    tall = min(5.7 * max(ratio, 0.25), _TALLEST)
    # as wide as its height leaves it, beside the key to the colours
    figure, ax = canvas(ax, (min(7.2, max(_NARROWEST, tall / ratio + 2.3)), tall + 1.15))

    factor, unit, extend = 1.0, "", "neither"
    if quantity == "status":
        style: dict[str, Any] = {
            "cmap": ListedColormap(STATUS_COLOURS),
            "norm": BoundaryNorm([-0.5, 0.5, 1.5, 2.5, 3.5], 4),
        }
    else:
        scale = colour_scale(values[shown], asked, limits)
        factor, unit, extend = scale.factor, scale.unit, scale.extend
        style = {"cmap": scale.colours, "norm": scale.norm}
    style["rasterized"] = True
    drawn = None
    for patch, edges in zip(grids, cells, strict=True):
        field = np.ma.masked_where(~patch.view(shown), patch.view(values) / factor)
        ax.pcolormesh(*edges, np.ones(field.shape), cmap=ListedColormap([OPEN_COLOUR]), rasterized=True)
        drawn = ax.pcolormesh(*edges, field, **style)
        if quantity != "status":
            _outline(ax, edges, patch.view(closed))
        if not panel:
            ax.plot(*_border(edges), color="#9A9A9A", linewidth=0.8)
    if not grids:
        drawn = _scattered(
            ax, x / MILLIMETRE, y / MILLIMETRE, np.ma.masked_where(~shown, values / factor), style
        )

    ax.set_aspect("equal")
    if window is not None:
        ax.set_xlim(window[0][0], window[1][0])
        ax.set_ylim(window[0][1], window[1][1])
    ax.set_xlabel("x [mm]")
    ax.set_ylabel("y [mm]")
    style_axes(ax)
    is_wide = _width(figure, ax) >= _WIDE
    if panel:
        pass
    elif quantity == "status":
        handles = status_swatches(np.unique(values).astype(int))
        ax.legend(
            handles=handles,
            loc="lower right",
            bbox_to_anchor=(1.0, 1.0),
            ncols=len(handles),
            frameon=False,
            fontsize=9 if is_wide else 8,
            **({} if is_wide else {"handlelength": 1.2, "columnspacing": 1.0, "borderaxespad": 0.1}),
        )
    elif drawn is not None:
        colour_bar(figure, drawn, ax, f"{asked.label} [{unit}]", extend)
    # above the key to the colours, where both do not stand beside each other
    raised: dict[str, Any] = {} if is_wide or panel or quantity != "status" else {"pad": 20.0}
    ax.set_title(
        within(ax, _title(label_of(asked, body), values[shown] / factor, unit)),
        loc="left",
        fontsize=10.5,
        color=INK,
        **raised,
    )
    fields = result.fields()
    if "traction" in fields:
        if quantity in fields and fields[quantity].is_vector:
            _arrows(ax, result, fields[quantity].values)
        if not panel:
            _friction_arrow(figure, ax, result, fields["traction"].values)
    return figure


def maps_side_by_side(
    results: Sequence[Pictured], names: Sequence[str], quantity: Word, body: Body, limits: Limits | None
) -> Figure:
    """Maps that show as much of the plane each, so that the patches compare, with one colour bar."""
    asked = quantity_of(results[0], quantity)
    boxes = []
    for result in results:
        points = flat(result, result.points)[:2, flat(result, result.status) > 0] / MILLIMETRE
        boxes.append((points.min(axis=1), points.max(axis=1)))
    # a margin of a tenth, or of a millimetre
    half = np.array([0.5 * np.ptp(box, axis=0) for box in boxes]).max(axis=0)
    half += np.maximum(0.15 * half, 1.0)
    columns = 1 if half[0] > 2.0 * half[1] else min(2, len(results))
    rows = -(-len(results) // columns)
    width = (7.2 - 1.0) / columns - 0.7
    height = min(width * half[1] / half[0], _TALLEST) + 1.0
    figure = new_figure((7.2, rows * height + 0.2))
    panels = figure.subplots(rows, columns, squeeze=False).ravel()
    for axes, result, name, (low, high) in zip(panels, results, names, boxes, strict=False):
        draw_map(result, quantity, body, limits, axes, panel=True)
        # nothing touches beyond the grid either
        axes.set_facecolor(OPEN_COLOUR if quantity != "status" else STATUS_COLOURS[0])
        middle = 0.5 * (low + high)
        axes.set_xlim(middle[0] - half[0], middle[0] + half[0])
        axes.set_ylim(middle[1] - half[1], middle[1] + half[1])
        told = "" if quantity == "status" else f"\n{axes.get_title(loc='left')}"
        axes.set_title(within(axes, name + told), loc="left", fontsize=9.5, color=INK)
    for axes in panels[len(results) :]:
        axes.set_axis_off()
    if quantity == "status":
        present = np.unique(np.concatenate([np.ravel(result.status) for result in results]))
        handles = status_swatches(present)
        figure.legend(handles=handles, loc="outside upper right", ncols=3, frameon=False, fontsize=9)
    else:
        drawn_of = [(quantity_of(result, quantity, body).values, result.status > 0) for result in results]
        everything = np.concatenate([values[closed] for values, closed in drawn_of])
        scale = colour_scale(everything, asked, limits)
        drawn = ScalarMappable(scale.norm, scale.colours)
        colour_bar(figure, drawn, list(panels), f"{asked.label} [{scale.unit}]", scale.extend)
    return figure


def status_swatches(present: Iterable[int]) -> list[Swatch]:
    return [
        Swatch(facecolor=STATUS_COLOURS[c], edgecolor=INK, lw=0.5, label=STATUS_NAMES[c]) for c in present
    ]


def colour_bar(figure: Figure, drawn: Any, axes: Any, label: str, extend: str) -> None:
    bar = figure.colorbar(drawn, ax=axes, extend=extend, shrink=0.9, aspect=28, pad=0.02)
    bar.set_label(label, color=INK)
    bar.outline.set_visible(False)
    bar.ax.tick_params(labelsize=8.5, colors=INK)


def inside_window(result: Pictured, window: Window | None) -> NDArray[np.bool_]:
    """Which points (n,) a map of the window shows."""
    places = flat(result, result.points)[:2] / MILLIMETRE
    if window is None:
        return np.ones(places.shape[1], dtype=bool)
    low, high = (end[:, None] for end in window)
    return np.asarray(((places >= low) & (places <= high)).all(axis=0))


#: Share of the grid that contact fills, and that its surroundings fill, below which a map shows these only.
_SMALL, _CROPPED = 0.5, 0.75
#: Size of the surroundings over that of the contact: of fields in it, and of those that go on beyond it.
_AROUND, _BEYOND = 1.2, 1.4


def window_of(results: Sequence[Pictured], asked: Field) -> Window | None:
    """What maps of the results show: the surroundings of all contact; None where that fills the grid."""
    whole, contact = [], []
    share = 0.0
    for result in results:
        closed = flat(result, result.status) > 0
        points = flat(result, result.points)
        for patch in patches(result):
            edges = corners(result, patch, points)[:2] / MILLIMETRE
            touching = patch.view(closed)
            whole.append(edges.reshape(2, -1))
            for corner in (np.s_[:-1, :-1], np.s_[:-1, 1:], np.s_[1:, :-1], np.s_[1:, 1:]):
                contact.append(edges[(slice(None), *corner)][:, touching])
        if not patches(result):
            whole.append(points[:2] / MILLIMETRE)
            contact.append(points[:2, closed] / MILLIMETRE)
        share = max(share, float(closed.mean()))
    if not 0.0 < share < _SMALL:
        return None
    grid, places = np.concatenate(whole, axis=1), np.concatenate(contact, axis=1)
    middle, half = 0.5 * (places.max(axis=1) + places.min(axis=1)), 0.5 * np.ptp(places, axis=1)
    half = (_BEYOND if asked.extent == "everywhere" else _AROUND) * half
    low, high = np.maximum(middle - half, grid.min(axis=1)), np.minimum(middle + half, grid.max(axis=1))
    return None if np.prod(high - low) > _CROPPED * np.prod(np.ptp(grid, axis=1)) else (low, high)


def _title(label: str, values: Array, unit: str) -> str:
    if not unit or not values.size:
        return label
    values = without_rounding(values)
    low, high = float(values.min()), float(values.max())
    # what three digits of the largest do not show is told as zero
    if low < -5e-4 * high:
        return f"{label}, {low:.3g} to {high:.3g} {unit}".replace("-", "\N{MINUS SIGN}")
    if high == 0.0:
        return f"{label}, 0 everywhere"
    return f"{label}, largest {high:.3g} {unit}"


def _border(edges: Array) -> tuple[Array, Array]:
    """The outline of a whole patch, for `ax.plot`."""
    x, y = (np.concatenate([e[0], e[1:, -1], e[-1, -2::-1], e[-2::-1, 0]]) for e in edges)
    return x, y


def _outline(ax: Axes, edges: Array, closed: NDArray[np.bool_]) -> None:
    """The border of the region in contact, along cell edges; none where everything or nothing is."""
    x, y = edges
    if closed.all() or not closed.any():
        return
    ring = np.pad(closed, 1)
    segments = []
    for j, i in np.argwhere(ring[1:, 1:-1] != ring[:-1, 1:-1]):
        segments.append([(x[j, i], y[j, i]), (x[j, i + 1], y[j, i + 1])])
    for j, i in np.argwhere(ring[1:-1, 1:] != ring[1:-1, :-1]):
        segments.append([(x[j, i], y[j, i]), (x[j + 1, i], y[j + 1, i])])
    ax.add_collection(LineCollection(segments, colors=INK, linewidths=0.9, capstyle="round"))


def _scattered(ax: Axes, x: Array, y: Array, field: Any, style: dict[str, Any]) -> Any:
    """Scattered points as triangles between neighbours; long ones, across gaps, are left out."""
    net = Triangulation(x, y)
    corner = np.stack([x[net.triangles], y[net.triangles]])
    longest = np.sqrt(((corner - np.roll(corner, 1, axis=2)) ** 2).sum(axis=0)).max(axis=1)
    away = longest > 3.0 * np.median(longest)
    net.set_mask(away)
    ax.tripcolor(net, np.ones(x.size), cmap=ListedColormap([OPEN_COLOUR]), rasterized=True)
    net.set_mask(away | np.ma.getmaskarray(field)[net.triangles].any(axis=1))
    return ax.tripcolor(net, np.ma.getdata(field), shading="flat", **style)


#: Arrows along the longer side of a map at the most.
_ARROWS = 26


def _arrows(ax: Axes, result: Pictured, field: Array) -> None:
    """The directions of a field that turns over a regular grid; in gross sliding one arrow says it all."""
    size = np.hypot(field[0], field[1])
    if field.ndim != 3 or not size.any():
        return
    direction = field[:2] / np.where(size > 0.0, size, 1.0)
    if np.ptp(direction[:, size > 0.0], axis=1).max() < 1e-3:
        return
    rows, columns = np.nonzero(result.status > 0)
    extent = max(np.ptp(rows), np.ptp(columns)) + 1
    step = max(1, int(np.ceil(extent / _ARROWS)))
    thin = (slice(rows.min() % step, None, step), slice(columns.min() % step, None, step))
    x, y = (result.points[c][thin] / MILLIMETRE for c in (0, 1))
    shown = (result.status > 0)[thin] & (size[thin] > 0.02 * size.max())
    spacing = step * float(np.hypot(*(np.ptp(result.points[c]) for c in (0, 1)))) / np.hypot(*size.shape)
    ax.quiver(
        x[shown],
        y[shown],
        *(field[c][thin][shown] / size.max() for c in (0, 1)),
        color="white",
        edgecolor=INK,
        linewidth=0.3,
        angles="xy",
        scale_units="xy",
        scale=MILLIMETRE / spacing,
        width=0.003,
    )


#: Height [in] of a map at the most.
_TALLEST = 6.27
#: Width [in] of the figure of a narrow map: the key to its states, and what friction does, still fit.
_NARROWEST = 3.0
#: Room [in] beside a map for the key to its colours, and width of a letter of a title, about.
_BESIDE, _LETTER = 1.15, 0.092


def within(ax: Axes, title: str) -> str:
    """The title of a map in lines that are no wider than the map and the key to its colours."""
    owner = figure_of(ax)
    letters = int((_width(owner, ax) + _BESIDE) / _LETTER)
    return "\n".join(textwrap.fill(line, letters, break_long_words=False) for line in title.split("\n"))


#: Width [in] of axes from which a title and a key, or a label and a remark, stand beside each other.
_WIDE = 4.5


def _width(figure: Figure, ax: Axes) -> float:
    """Width [in] of the map in axes of equal scales, about: a layout may still take some of it for labels."""
    width, height = ax.get_position(original=True).size * figure.get_size_inches()
    return float(min(width, height * np.ptp(ax.get_xlim()) / np.ptp(ax.get_ylim())))


def _friction_arrow(figure: Figure, ax: Axes, result: Pictured, traction: Array) -> None:
    """The direction in which friction drags the lower body, as an arrow below the picture."""
    area = flat(result, result.area)
    pull = (flat(result, traction) * area).sum(axis=1)[:2]
    size = float(np.hypot(*pull))
    if size <= 1e-3 * float(flat(result, result.pressure) @ area):
        return
    below = -27.0
    if _width(figure, ax) < _WIDE:
        # both do not stand side by side
        ax.set_xlabel(f"{ax.get_xlabel()}\n")
        below = -41.0
    elif np.ptp(ax.get_xlim()) < np.ptp(ax.get_ylim()):
        # nor do they below the middle of a narrow map
        ax.set_xlabel(ax.get_xlabel(), loc="left")
    # in points from the lower right corner of the axes, on the line of the x label
    place: Any = Affine2D().scale(1 / 72) + figure.dpi_scale_trans + ScaledTranslation(1.0, 0.0, ax.transAxes)  # type: ignore[arg-type]
    middle, half = np.array([-9.0, below]), 9.0 * pull / size
    ax.annotate(
        "",
        xy=tuple(middle + half),
        xytext=tuple(middle - half),
        xycoords=place,
        arrowprops={"arrowstyle": "-|>", "color": INK, "linewidth": 1.2, "shrinkA": 0, "shrinkB": 0},
        annotation_clip=False,
    )
    ax.text(
        -23.0,
        below,
        "friction on the lower body",
        transform=place,
        ha="right",
        va="center_baseline",
        fontsize=8.5,
        color=INK,
    )
