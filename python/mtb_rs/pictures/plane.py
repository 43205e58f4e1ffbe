# SPDX-License-Identifier: MIT OR Apache-2.0
"""Pictures of a result: maps over the patches and cuts (matplotlib), and the way to the 3-D view.

Nothing here touches pyplot: a picture is a figure of its own, or is drawn into axes handed in.
"""

from __future__ import annotations

import io
import sys
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass
from itertools import cycle
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, Protocol, Unpack, get_args, overload

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.cm import ScalarMappable
from matplotlib.collections import LineCollection
from matplotlib.colors import BoundaryNorm, Colormap, ListedColormap
from matplotlib.figure import Figure
from matplotlib.patches import Patch as Swatch
from matplotlib.transforms import Affine2D, ScaledTranslation
from matplotlib.tri import Triangulation
from numpy.typing import NDArray
from PIL import Image

from ..base.check import choice, pair
from ..base.files import check_target, write_bytes
from ..base.words import Body, Field, Flat, FlatOptions, Limits, Space, SpaceOptions, Stress, StressOptions
from ..geometry.contact_points import Patch
from ..results.grids import corners, flat, line_borders, patches
from ..results.result import Pictured, Result, png
from ..results.sweep_table import ARGUMENT_UNITS, UNITS, SweepTable
from .quantities import (
    _PREFIXES,
    INK,
    LINE_COLOURS,
    MILLIMETRE,
    OPEN_COLOUR,
    QUANTITIES,
    STATUS_COLOURS,
    STATUS_NAMES,
    Quantity,
    colour_scale,
    quantity_of,
    unit_of,
)
from .space import view, view_von_mises

if TYPE_CHECKING:
    import pyvista

Array = NDArray[np.float64]


#: Lower and upper ends (x, y) [mm] of what a map shows.
Window = tuple[Array, Array]


class ResultFigure(Figure):
    """A matplotlib figure that shows itself in a notebook; pyplot's own where pyplot is in use."""

    def show(self, warn: bool = True) -> None:
        """Shows the figure in a window, if there is a display."""
        if self.canvas.manager is None:
            from matplotlib import pyplot
            from matplotlib._pylab_helpers import Gcf

            # a figure of pyplot's gives the canvas of its backend, and its number
            window = pyplot.figure()
            number, canvas = window.number, type(window.canvas)
            pyplot.close(window)
            manager = canvas.new_manager(self, number)
            Gcf._set_new_active_manager(manager)
        super().show(warn)

    def _repr_png_(self) -> bytes:
        return png(self)


#: Whether figures belong to nobody: those that the library makes for its own files and notebooks.
_IS_OWN: ContextVar[bool] = ContextVar("own figures", default=False)


@contextmanager
def own_figures() -> Iterator[None]:
    """Figures drawn inside do not become pyplot's, which would keep them."""
    token = _IS_OWN.set(True)
    try:
        yield
    finally:
        _IS_OWN.reset(token)


def _figure(size: tuple[float, float]) -> Figure:
    pyplot = sys.modules.get("matplotlib.pyplot")
    if pyplot is None or _IS_OWN.get():
        return ResultFigure(figsize=size, dpi=150, layout="constrained")
    figure: Figure = pyplot.figure(FigureClass=ResultFigure, figsize=size, dpi=150, layout="constrained")
    return figure


@overload
def plot(
    result: Pictured, quantity: Field = ..., kind: Flat | None = ..., **options: Unpack[FlatOptions]
) -> Figure: ...


@overload
def plot(
    result: Pictured, quantity: Field, kind: Space, **options: Unpack[SpaceOptions]
) -> pyvista.Plotter: ...


@overload
def plot(
    result: Pictured, quantity: Field = ..., *, kind: Space, **options: Unpack[SpaceOptions]
) -> pyvista.Plotter: ...


@overload
def plot(
    result: Pictured, quantity: Stress, kind: Space | None = ..., **options: Unpack[StressOptions]
) -> pyvista.Plotter: ...


def plot(result: Any, quantity: Any = "pressure", kind: Any = None, **options: Any) -> Any:
    """Draws one quantity of a result.

    Parameters
    ----------
    result : Result, NormalResult, TangentialResult, FoundationResult or StepResult
    quantity : str
        What the result has of "pressure", "traction" (its magnitude, with arrows where it turns),
        "longitudinal_traction", "lateral_traction", "slip" (its magnitude), "longitudinal_slip",
        "lateral_slip", "friction_coefficient", "dissipation", "gap", "initial_gap", "status",
        "vertical_displacement", "longitudinal_displacement", "lateral_displacement"; or "von_mises", the
        equivalent stress on the deformed elastic bodies of a scene, which is a picture in space.
    kind : "map", "line" or "3d"
        A map over the patches (default), cuts (default where `x` or `y` is given), or the bodies in
        space, if the result has any, with the quantity on the contact patch. A map shows the surroundings of
        the contact where that fills less than half of the grid.
    x, y : float or floats [m]
        Where to cut: along y at each `x`, or along x at each `y`. The line of cells nearest to it is drawn,
        with its own place in the legend: pressure and traction are constant by cell. By default along x,
        the row of the peak pressure.
    body : "lower" or "upper"
        Whose displacement is drawn.
    limits : (low, high) [SI unit of the quantity]
        Ends of the scale, to compare pictures; by default those of the values.
    ax : matplotlib.axes.Axes
        Draw there, not into a figure of its own (not for "3d").
    title : str
        In place of the one that says the quantity and its range.
    cmap : str or matplotlib.colors.Colormap
        Colours of a map.
    figsize : (width, height) [in]
        Of the figure. Like `title` and `cmap` not for "3d", nor beside `ax`.
    **options
        For "3d": see :func:`mtb_rs.pictures.view` and :func:`mtb_rs.pictures.view_von_mises`.

    Returns
    -------
    matplotlib.figure.Figure or pyvista.Plotter
    """
    return _plot(result, quantity, kind, **options)


def _plot(
    result: Pictured,
    quantity: Any,
    kind: Any = None,
    *,
    x: float | Iterable[float] | None = None,
    y: float | Iterable[float] | None = None,
    body: Body = "lower",
    limits: Limits | None = None,
    ax: Axes | None = None,
    title: str | None = None,
    cmap: str | Colormap | None = None,
    figsize: tuple[float, float] | None = None,
    window: Window | None = None,
    **options: Any,
) -> Any:
    """What :func:`plot` draws; a map of what lies in `window`, where there is one."""
    choice("body", body, Body)
    if limits is not None and not (np.all(np.isfinite(limits)) and limits[0] < limits[1]):
        raise ValueError(f"limits is {limits!r}: two finite numbers that rise are needed")
    if kind not in (None, *get_args(Flat), *get_args(Space)):
        raise ValueError(f'kind is {kind!r}: "map", "line" or "3d" is needed')
    is_styled = not (title is None and cmap is None and figsize is None)
    if is_styled and (kind == "3d" or quantity in get_args(Stress)):
        raise ValueError('title, cmap and figsize have no meaning for kind="3d"')
    if quantity in get_args(Stress):
        if kind not in (None, "3d") or x is not None or y is not None or ax is not None:
            raise ValueError("quantity is 'von_mises': it has no map and no lines, only kind='3d'")
        if not isinstance(result, Result):
            raise ValueError("quantity is 'von_mises': only scenes have bodies with stresses")
        return view_von_mises(result, limits=limits, **options)
    quantity_of(result, quantity)
    if x is not None and y is not None:
        raise ValueError("x and y are both given: a cut along y is at an x, one along x is at a y")
    cut: Literal["x", "y"] = "x" if x is not None else "y"
    is_cut = x is not None or y is not None
    if kind is None:
        kind = "line" if is_cut else "map"
    if cmap is not None and kind != "map":
        raise ValueError('cmap has a meaning for kind="map" only')
    if figsize is not None and ax is not None:
        raise ValueError("figsize has no meaning beside ax")
    if kind == "3d":
        if is_cut or ax is not None:
            raise ValueError('x, y and ax have no meaning for kind="3d"')
        return view(result, quantity, body=body, limits=limits, **options)
    if options:
        raise ValueError(f'unknown options for kind="{kind}": {", ".join(options)}')
    if kind == "map":
        if is_cut:
            raise ValueError(f'{cut} has no meaning for kind="map"; cuts are kind="line"')
        figure = draw_map(result, quantity, body, limits, ax, window=window)
    else:
        figure = draw_lines(result, quantity, cut, x if cut == "x" else y, body, limits, ax)
    if figsize is not None:
        figure.set_size_inches(*pair("figsize", figsize, "in"))
    drawn = figure.axes[0] if ax is None else ax
    if cmap is not None:
        _recolour(drawn, cmap)
    if title is not None:
        drawn.set_title(title, loc="left", fontsize=10.5, color=INK)
    return figure


def _recolour(drawn: Axes, cmap: str | Colormap) -> None:
    for shown in (*drawn.collections, *drawn.images):
        if shown.get_array() is not None:
            shown.set_cmap(cmap)


def plot_side_by_side(
    results: Sequence[Pictured], names: Sequence[str], quantity: Field, kind: Flat | None, **options: Any
) -> Figure:
    """One quantity of several results on one scale, each under its name; options as for :func:`plot`."""
    if kind in get_args(Space) or "ax" in options:
        raise ValueError('several patches are drawn as maps or lines: neither kind="3d" nor ax has a meaning')
    if kind not in (None, *get_args(Flat)):
        raise ValueError(f'kind is {kind!r}: "map" or "line" is needed')
    quantity_of(results[0], quantity)
    title, cmap, figsize = (options.pop(name, None) for name in ("title", "cmap", "figsize"))
    unknown = [name for name in options if name not in ("x", "y", "body", "limits")]
    if unknown:
        raise ValueError(f"unknown options: {', '.join(unknown)}")
    if options.get("limits") is None:
        given = {"kind": kind, **options} if kind else options
        options["limits"] = _shared_limits(results, quantity, given)
    if kind == "line" or _is_cut(options):
        figure = _figure((7.2, 3.6 * len(results)))
        if cmap is not None:
            raise ValueError('cmap has a meaning for kind="map" only')
        panels = figure.subplots(len(results), 1, squeeze=False)[:, 0]
        for axes, result, name in zip(panels, results, names, strict=True):
            plot(result, quantity, kind, ax=axes, **options)
            axes.set_title(f"{name}: {axes.get_title(loc='left')}", loc="left", fontsize=9.5, color=INK)
    else:
        body = options.get("body", "lower")
        figure = _maps_side_by_side(results, names, quantity, body, options["limits"])
        if cmap is not None:
            for axes in figure.axes:
                _recolour(axes, cmap)
    if figsize is not None:
        figure.set_size_inches(*pair("figsize", figsize, "in"))
    if title is not None:
        figure.suptitle(title, x=0.01, ha="left", fontsize=10.5, color=INK)
    return figure


def _maps_side_by_side(
    results: Sequence[Pictured], names: Sequence[str], quantity: Field, body: Body, limits: Limits | None
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
    height = width * half[1] / half[0] + 1.0
    figure = _figure((7.2, rows * height + 0.2))
    panels = figure.subplots(rows, columns, squeeze=False).ravel()
    for axes, result, name, (low, high) in zip(panels, results, names, boxes, strict=False):
        draw_map(result, quantity, body, limits, axes, panel=True)
        # nothing touches beyond the grid either
        axes.set_facecolor(OPEN_COLOUR if quantity != "status" else STATUS_COLOURS[0])
        middle = 0.5 * (low + high)
        axes.set_xlim(middle[0] - half[0], middle[0] + half[0])
        axes.set_ylim(middle[1] - half[1], middle[1] + half[1])
        told = "" if quantity == "status" else f"\n{axes.get_title(loc='left')}"
        axes.set_title(name + told, loc="left", fontsize=9.5, color=INK)
    for axes in panels[len(results) :]:
        axes.set_axis_off()
    if quantity == "status":
        present = np.unique(np.concatenate([np.ravel(result.status) for result in results]))
        handles = _status_swatches(present)
        figure.legend(handles=handles, loc="outside upper right", ncols=3, frameon=False, fontsize=9)
    else:
        everything = np.concatenate([asked.values(result, body)[result.status > 0] for result in results])
        scale = colour_scale(everything, asked, limits)
        drawn = ScalarMappable(scale.norm, scale.colours)
        _colour_bar(figure, drawn, list(panels), f"{asked.label} [{scale.unit}]", scale.extend)
    return figure


def _status_swatches(present: Iterable[int]) -> list[Swatch]:
    return [
        Swatch(facecolor=STATUS_COLOURS[c], edgecolor=INK, lw=0.5, label=STATUS_NAMES[c]) for c in present
    ]


def _colour_bar(figure: Figure, drawn: Any, axes: Any, label: str, extend: str) -> None:
    bar = figure.colorbar(drawn, ax=axes, extend=extend, shrink=0.9, aspect=28, pad=0.02)
    bar.set_label(label, color=INK)
    bar.outline.set_visible(False)
    bar.ax.tick_params(labelsize=8.5, colors=INK)


def animate(
    history: Iterable[Pictured],
    path: str | Path,
    quantity: Field = "pressure",
    *,
    frames_per_second: float = 10.0,
    captions: Sequence[str] | None = None,
    **options: Any,
) -> Path:
    """A moving picture (.gif, .webp or .png) of one quantity over a history of results.

    All frames share their scale: the colours of maps and 3-D views, the axes of lines; and the part of the
    plane that maps show.

    Parameters
    ----------
    history : results
        At least one, in order, all of one kind.
    path : str or Path
    quantity : str
        As for :func:`plot`.
    frames_per_second : float [1/s]
    captions : sequence of str, one for each frame
        What stands over them, such as the time. By default the arguments of the scenes in which the results
        differ; where there are none, the number of the step.
    **options
        As for :func:`plot`, `kind`, `x` and `y` included; not `ax`.
    """
    target = check_target(path)
    if target.suffix not in (".gif", ".webp", ".png"):
        raise ValueError(f"path is {str(path)!r}: a name ending in .gif, .webp or .png is needed")
    history = list(history)
    if not history:
        raise ValueError("history is empty: at least one result is needed")
    quantity_of(history[0], quantity)
    if captions is not None and (isinstance(captions, str) or len(captions) != len(history)):
        raise ValueError(f"captions are {len(captions)}: one for each of {len(history)} results is needed")
    if not (np.isfinite(frames_per_second) and frames_per_second > 0.0):
        raise ValueError(f"frames_per_second is {frames_per_second!r}: a positive number is needed")
    shared = {"limits": _shared_limits(history, quantity, options), **options}
    if options.get("kind") in (None, "map") and not _is_cut(options):
        shared["window"] = _window(history, QUANTITIES[quantity])
    captions = _differences(history) if captions is None else captions
    first, *others = [
        Image.fromarray(_frame(result, quantity, caption, shared))
        for result, caption in zip(history, captions, strict=True)
    ]
    pause = round(1000.0 / frames_per_second)
    moving = io.BytesIO()
    kind = {".gif": "GIF", ".webp": "WEBP", ".png": "PNG"}[target.suffix]
    first.save(moving, kind, save_all=True, append_images=others, duration=pause, loop=0)
    write_bytes(target, moving.getbuffer())
    return target


def _frame(result: Pictured, quantity: str, caption: str, options: dict[str, Any]) -> NDArray[np.uint8]:
    with own_figures():
        picture = _plot(result, quantity, **options)
    if isinstance(picture, Figure):
        picture.suptitle(caption, x=0.01, ha="left", fontsize=11, color=INK)
        canvas: Any = FigureCanvasAgg(picture)
        canvas.draw()
        return np.array(canvas.buffer_rgba())[..., :3]
    picture.add_text(caption, position="upper_left", font_size=12, color=INK)
    image = np.array(picture.screenshot(return_img=True))
    picture.close()
    return image


def _differences(history: Sequence[Pictured]) -> list[str]:
    """The numbers given to the scenes of the results in which they differ, or which step each is."""
    steps = [f"step {k} of {len(history)}" for k in range(1, len(history) + 1)]
    given = [dict(result.summary) if isinstance(result, Result) else {} for result in history]
    numbers = {
        name: [inputs[name] for inputs in given]
        for name in given[0]
        if all(isinstance(inputs.get(name), (int, float)) for inputs in given)
    }
    said = []
    for name, values in numbers.items():
        if all(value == values[0] for value in values):
            continue
        factor, unit = 1.0, ARGUMENT_UNITS.get(name, "")
        if unit in _PREFIXES:
            factor, unit = unit_of(np.array(values, dtype=float), unit)
        unit = "" if unit in ("", "1") else f" {unit}"
        said.append([f"{_spaced(name)} {value / factor:.4g}{unit}" for value in values])
    return [", ".join(words) for words in zip(*said, strict=True)] if said else steps


def _is_cut(options: Mapping[str, Any]) -> bool:
    return options.get("x") is not None or options.get("y") is not None


def _shared_limits(history: Sequence[Pictured], quantity: Field, options: dict[str, Any]) -> Limits | None:
    """Ends of one scale for all results; None for the status, which has no scale."""
    if quantity == "status":
        return None
    asked, body = quantity_of(history[0], quantity), options.get("body", "lower")
    is_line = options.get("kind") == "line" or _is_cut(options)
    window = None if is_line or options.get("kind") == "3d" else _window(history, asked)
    kept = []
    for result in history:
        values = flat(result, np.asarray(asked.values(result, body), dtype=float))
        shown = flat(result, result.status) > 0 if asked.contact_only else _inside(result, window)
        kept.append(values[shown])
    everything = np.concatenate(kept)
    if is_line:
        low, high = float(everything.min(initial=0.0)), float(everything.max(initial=0.0))
        return (low, 1.05 * high) if low < high else (0.0, 1.0)
    scale = colour_scale(everything, asked)
    low, high = (float(v) * scale.factor for v in (scale.norm.vmin, scale.norm.vmax))  # type: ignore[arg-type]
    return (low, high) if low < high else None


def _inside(result: Pictured, window: Window | None) -> NDArray[np.bool_]:
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


def _window(results: Sequence[Pictured], asked: Quantity) -> Window | None:
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
    inside = asked.contact_only or asked.source in ("status", "dissipation")
    half = (_AROUND if inside else _BEYOND) * half
    low, high = np.maximum(middle - half, grid.min(axis=1)), np.minimum(middle + half, grid.max(axis=1))
    return None if np.prod(high - low) > _CROPPED * np.prod(np.ptp(grid, axis=1)) else (low, high)


def draw_map(
    result: Pictured,
    quantity: Field,
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
    asked = quantity_of(result, quantity)
    grids = patches(result)
    x, y = flat(result, result.points)[:2]
    values = flat(result, asked.values(result, body)).astype(float)
    closed = flat(result, result.status) > 0
    window = _window([result], asked) if window is None and not panel else window
    shown = closed if asked.contact_only else _inside(result, window)
    width, height = (np.ptp(x), np.ptp(y)) if window is None else window[1] - window[0]
    ratio = float(np.clip(height / max(width, 1e-12), 0.25, 1.1))
    figure, ax = _canvas(ax, (7.2, 5.7 * ratio + 1.15))

    factor, unit, extend = 1.0, "", "neither"
    if quantity == "status":
        style: dict[str, Any] = {
            "cmap": ListedColormap(STATUS_COLOURS),
            "norm": BoundaryNorm([-0.5, 0.5, 1.5, 2.5], 3),
        }
    else:
        scale = colour_scale(values[shown], asked, limits)
        factor, unit, extend = scale.factor, scale.unit, scale.extend
        style = {"cmap": scale.colours, "norm": scale.norm}
    style["rasterized"] = True
    drawn = None
    for patch in grids:
        field = np.ma.masked_where(~patch.view(shown), patch.view(values) / factor)
        edges = list(corners(result, patch, flat(result, result.points))[:2] / MILLIMETRE)
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
    _style(ax)
    if panel:
        pass
    elif quantity == "status":
        handles = _status_swatches(code for code in (0, 1, 2) if np.any(values == code))
        ax.legend(
            handles=handles, loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=3, frameon=False, fontsize=9
        )
    elif drawn is not None:
        _colour_bar(figure, drawn, ax, f"{asked.label} [{unit}]", extend)
    ax.set_title(
        _title(_label(asked, body), values[shown] / factor, unit), loc="left", fontsize=10.5, color=INK
    )
    if hasattr(result, "traction"):
        if quantity in ("traction", "slip"):
            _arrows(ax, result, getattr(result, asked.source))
        if not panel:
            _friction_arrow(figure, ax, result)
    return figure


def draw_lines(
    result: Pictured,
    quantity: Field,
    cut: Literal["x", "y"],
    at: float | Iterable[float] | None,
    body: Body,
    limits: Limits | None,
    ax: Axes | None,
) -> Figure:
    """The quantity along the lines of cells whose coordinate `cut` is nearest to `at`; what is constant by
    cell is drawn as steps."""
    asked = quantity_of(result, quantity)
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

    values = flat(result, asked.values(result, body)).astype(float)
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
    figure, ax = _canvas(ax, (7.2, 3.9))
    for pieces, colour in zip(chosen, cycle(LINE_COLOURS), strict=False):
        label: str | None = f"{cut} = {pieces[0].of(place).mean():.3g} mm".replace("-", "\N{MINUS SIGN}")
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
    if quantity == "status":
        ax.set_yticks(range(3), STATUS_NAMES)
        ax.set_ylim(-0.3, 2.3)
    elif limits is not None:
        ax.set_ylim(limits[0] / factor, limits[1] / factor)
    elif not asked.by_body and not quantity.startswith(("longitudinal", "lateral")):
        ax.set_ylim(bottom=0.0)
    ax.margins(x=0.02)
    ax.set_xlabel("x [mm]" if cut == "y" else "y [mm]")
    ax.set_ylabel(f"{asked.label} [{unit}]" if unit else asked.label)
    ax.set_title(_label(asked, body), loc="left", fontsize=10.5, color=INK)
    ax.legend(
        frameon=False, fontsize=9, loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=4, borderaxespad=0.2
    )
    _style(ax)
    ax.grid(True, color="#DDDDDD", linewidth=0.6)
    return figure


def draw_sweep(table: SweepTable, quantity: str, ax: Axes | None) -> Figure:
    """A quantity of a sweep over its first parameter, a line for each value of the others."""
    if not table.columns:
        raise ValueError("nothing to draw: no case of the sweep is solved")
    if quantity not in table.columns:
        raise ValueError(f"quantity is {quantity!r}: one of {', '.join(table.columns)} is needed")
    (first, along), *others = table.parameters.items()
    values = table.columns[quantity]
    unit = UNITS.get(quantity, "")
    factor = 1.0
    if unit in _PREFIXES:
        factor, unit = unit_of(values[np.isfinite(values)], unit)
    numeric = all(isinstance(v, (int, float)) and not isinstance(v, bool) for v in along)
    places = np.array(along, dtype=float) if numeric else np.arange(len(along), dtype=float)
    measured = table.units.get(first, "")
    if measured in _PREFIXES:
        step, measured = unit_of(places, measured)
        places = places / step
    order = np.argsort(places, kind="stable")
    figure, ax = _canvas(ax, (7.2, 3.9))
    styles = ((colour, dash) for dash in cycle(("-", "--", ":", "-.")) for colour in LINE_COLOURS)
    for at, (colour, dash) in zip(np.ndindex(values.shape[1:]), styles, strict=False):
        label = ", ".join(
            f"{_spaced(k)} = {_measured(table, k, i)}" for (k, v), i in zip(others, at, strict=True)
        )
        line = values[(slice(None), *at)][order] / factor
        # labels have no places between them
        ax.plot(
            places[order],
            line,
            dash if numeric else "none",
            marker="." if numeric else "o",
            color=colour,
            linewidth=1.6,
            label=label or None,
        )
    if not numeric:
        ax.set_xticks(places, [str(v) for v in along])
    ax.set_xlabel(f"{_spaced(first)} [{measured}]" if measured not in ("", "1") else _spaced(first))
    name = _spaced(quantity)
    ax.set_ylabel(f"{name} [{unit}]" if unit not in ("", "1") else name)
    ax.set_title(_spaced(table.attributes["scene"]), loc="left", fontsize=10.5, color=INK)
    if others:
        ax.legend(frameon=False, fontsize=9, loc="upper left", bbox_to_anchor=(1.0, 1.0))
    _style(ax)
    ax.grid(True, color="#DDDDDD", linewidth=0.6)
    return figure


def draw_area_load(curve: AreaLoad, ax: Axes | None) -> Figure:
    """Contact area over the force of a rough contact, in the order of the forces."""
    order = np.argsort(curve.force, kind="stable")
    newton, force = next((unit for unit in _FORCES if curve.force.max() >= unit[0]), _FORCES[-1])
    square, area = next((unit for unit in _AREAS if curve.contact_area.max() >= unit[0]), _AREAS[-1])
    figure, ax = _canvas(ax, (7.2, 3.9))
    ax.plot(
        curve.force[order] / newton,
        curve.contact_area[order] / square,
        marker=".",
        color=LINE_COLOURS[0],
        linewidth=1.6,
    )
    ax.set_xlim(left=0.0)
    ax.set_ylim(bottom=0.0)
    ax.set_xlabel(f"normal force [{force}]")
    ax.set_ylabel(f"contact area [{area}]")
    ax.set_title("Contact area over load", loc="left", fontsize=10.5, color=INK)
    _style(ax)
    ax.grid(True, color="#DDDDDD", linewidth=0.6)
    return figure


#: Newtons of the units of a force, square metres of those of an area.
_FORCES = ((1e3, "kN"), (1.0, "N"), (1e-3, "mN"), (1e-6, "µN"))
_AREAS = ((1.0, "m²"), (1e-6, "mm²"), (1e-12, "µm²"))


class AreaLoad(Protocol):
    """Areas [m2] over forces [N]."""

    @property
    def force(self) -> Array: ...
    @property
    def contact_area(self) -> Array: ...


def _spaced(name: str) -> str:
    return name.replace("_", " ")


def _measured(table: SweepTable, name: str, at: int) -> str:
    """One of the values of a parameter with its unit, all in the same one."""
    values = table.parameters[name]
    factor, unit = 1.0, table.units.get(name, "")
    if unit in _PREFIXES:
        factor, unit = unit_of(np.array(values, dtype=float), unit)
    value = values[at] / factor if factor != 1.0 else values[at]
    return _plain(value) if unit in ("", "1") else f"{_plain(value)} {unit}"


def _plain(value: Any) -> str:
    return f"{value:g}" if isinstance(value, float) else str(value)


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
    # rounding must not decide between two lines equally far: the first wins
    distance = np.round(np.abs(places - wanted[:, None] / MILLIMETRE), 6)
    reach = np.array([line.patch.spacing[0 if cut == "x" else 1] for line in lines]) / MILLIMETRE
    starts = np.array([line.patch.start for line in lines])
    found: dict[int, list[_Line]] = {}
    for away in distance:
        first = int(away.argmin())
        best = [int(np.where(starts == start, away, np.inf).argmin()) for start in np.unique(starts)]
        through = [k for k in best if k == first or away[k] <= 0.5 * reach[k]]
        found.setdefault(first, [lines[k] for k in sorted(through)])
    return list(found.values())


def _canvas(ax: Axes | None, size: tuple[float, float]) -> tuple[Figure, Axes]:
    if ax is None:
        figure = _figure(size)
        return figure, figure.add_subplot()
    owner = ax.get_figure(root=True)
    if owner is None:
        raise ValueError("ax belongs to no figure")
    return owner, ax


def _label(asked: Quantity, body: Body) -> str:
    return asked.label + (f" of the {body} body" if asked.by_body else "")


def _style(ax: Axes) -> None:
    ax.spines[["top", "right"]].set_visible(False)
    ax.spines[["left", "bottom"]].set_color("#888888")
    ax.tick_params(labelsize=8.5, color="#888888", labelcolor=INK)
    ax.xaxis.label.set(color=INK, fontsize=9.5)
    ax.yaxis.label.set(color=INK, fontsize=9.5)
    ax.set_axisbelow(True)


def _title(label: str, values: Array, unit: str) -> str:
    if not unit or not values.size:
        return label
    low, high = float(values.min()), float(values.max())
    if low < 0.0:
        return f"{label}, {low:.3g} to {high:.3g} {unit}".replace("-", "\N{MINUS SIGN}")
    return f"{label}, largest {high:.3g} {unit}"


def _border(edges: list[Array]) -> tuple[Array, Array]:
    """The outline of a whole patch, for `ax.plot`."""
    x, y = (np.concatenate([e[0], e[1:, -1], e[-1, -2::-1], e[-2::-1, 0]]) for e in edges)
    return x, y


def _outline(ax: Axes, edges: list[Array], closed: NDArray[np.bool_]) -> None:
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


def _arrows(ax: Axes, result: Any, field: Array) -> None:
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


def _friction_arrow(figure: Figure, ax: Axes, result: Any) -> None:
    """The direction in which friction drags the lower body, as an arrow below the picture."""
    pull = (flat(result, result.traction) * flat(result, result.area)).sum(axis=1)[:2]
    size = float(np.hypot(*pull))
    if size <= 1e-3 * result.normal_force:
        return
    # in points from the lower right corner of the axes, on the line of the x label
    place: Any = Affine2D().scale(1 / 72) + figure.dpi_scale_trans + ScaledTranslation(1.0, 0.0, ax.transAxes)  # type: ignore[arg-type]
    middle, half = np.array([-9.0, -27.0]), 9.0 * pull / size
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
        -27.0,
        "friction on the lower body",
        transform=place,
        ha="right",
        va="center_baseline",
        fontsize=8.5,
        color=INK,
    )
