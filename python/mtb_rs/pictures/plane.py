# SPDX-License-Identifier: MIT OR Apache-2.0
"""Pictures of a result in the plane: maps and cuts, and the way to the view in space.

Nothing here touches pyplot: a picture is a figure of its own, or is drawn into axes handed in.
"""

from __future__ import annotations

import inspect
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any, Literal, Unpack, get_args, overload

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import Colormap
from matplotlib.figure import Figure

from ..base.check import choice, pair
from ..base.units import in_si
from ..base.words import Body, Flat, FlatOptions, Limits, Space, SpaceOptions, Stress, StressOptions
from ..base.words import Field as Word
from ..results.grids import flat
from ..results.result import Pictured
from .figures import new_figure
from .lines import draw_lines
from .maps import Window, draw_map, inside_window, maps_side_by_side, window_of, within
from .quantities import INK, as_drawn, colour_scale, quantity_of
from .space import view, view_von_mises

if TYPE_CHECKING:
    import pyvista


@overload
def plot(
    result: Pictured, quantity: Word = ..., kind: Flat | None = ..., **options: Unpack[FlatOptions]
) -> Figure: ...


@overload
def plot(
    result: Pictured, quantity: Word, kind: Space, **options: Unpack[SpaceOptions]
) -> pyvista.Plotter: ...


@overload
def plot(
    result: Pictured, quantity: Word = ..., *, kind: Space, **options: Unpack[SpaceOptions]
) -> pyvista.Plotter: ...


@overload
def plot(
    result: Pictured, quantity: Stress, kind: Space | None = ..., **options: Unpack[StressOptions]
) -> pyvista.Plotter: ...


def plot(result: Any, quantity: Any = "pressure", kind: Any = None, **options: Any) -> Any:
    """Draws one quantity of a result.

    Parameters
    ----------
    result : any result with contact points
    quantity : str
        One of these, if the result has it:
        "pressure", "traction" (its magnitude, with arrows where it turns),
        "longitudinal_traction", "lateral_traction", "slip" (its magnitude), "longitudinal_slip",
        "lateral_slip", "plastic_slip" (its magnitude), "longitudinal_plastic_slip", "lateral_plastic_slip",
        "accumulated_plastic_slip", "friction_coefficient", "dissipation", "plastic_dissipation", "gap",
        "initial_gap", "plastic_indentation", "status",
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
    return plot_within(as_drawn(result)._picture(), quantity, kind, **options)


def plot_within(
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
    asked = None if quantity in get_args(Stress) else quantity_of(result, quantity, body)
    limits = in_si("limits", limits, "Pa" if asked is None else asked.unit or None)
    if limits is not None and not (np.all(np.isfinite(limits)) and limits[0] < limits[1]):
        raise ValueError(f"limits is {limits!r}: two finite numbers that rise are needed")
    if kind not in (None, *get_args(Flat), *get_args(Space)):
        raise ValueError(f'kind is {kind!r}: "map", "line" or "3d" is needed')
    is_styled = not (title is None and cmap is None and figsize is None)
    if is_styled and (kind == "3d" or quantity in get_args(Stress)):
        raise ValueError('title, cmap and figsize are for maps and lines, not for kind="3d"')
    if quantity in get_args(Stress):
        if kind not in (None, "3d") or x is not None or y is not None or ax is not None:
            raise ValueError("quantity is 'von_mises': it is drawn by kind='3d' only, without x, y and ax")
        _check_known(options, view_von_mises, 'quantity="von_mises"')
        return view_von_mises(result, limits=limits, **options)
    if x is not None and y is not None:
        raise ValueError(
            "x and y are both given: one of them is needed, x for a line along y, y for a line along x"
        )
    cut: Literal["x", "y"] = "x" if x is not None else "y"
    is_cut = x is not None or y is not None
    if kind is None:
        kind = "line" if is_cut else "map"
    if cmap is not None and kind != "map":
        raise ValueError('cmap is for kind="map" only')
    if figsize is not None and ax is not None:
        raise ValueError(
            "figsize and ax are both given: the axes have a size already, so give one of the two"
        )
    if kind == "3d":
        if is_cut or ax is not None:
            raise ValueError('x, y and ax are for maps and lines, not for kind="3d"')
        _check_known(options, view, 'kind="3d"')
        return view(result, quantity, body=body, limits=limits, **options)
    if options:
        raise ValueError(
            f'{", ".join(options)}: unknown options for kind="{kind}"; known are x, y, body, limits, ax, '
            "title, cmap and figsize"
        )
    if kind == "map":
        if is_cut:
            raise ValueError(f'{cut} is for kind="line", which draws along a line, not for kind="map"')
        figure = draw_map(result, quantity, body, limits, ax, window=window)
    else:
        figure = draw_lines(result, quantity, cut, x if cut == "x" else y, body, limits, ax)
    if figsize is not None:
        figure.set_size_inches(*pair("figsize", figsize, "in"))
    drawn = figure.axes[0] if ax is None else ax
    if cmap is not None:
        recolour(drawn, cmap)
    if title is not None:
        said = within(drawn, title) if kind == "map" else title
        drawn.set_title(said, loc="left", fontsize=10.5, color=INK)
    return figure


def _check_known(options: Mapping[str, Any], draws: Callable[..., Any], where: str) -> None:
    """ValueError for options that a picture in space does not have."""
    known = [p.name for p in inspect.signature(draws).parameters.values() if p.kind is p.KEYWORD_ONLY]
    unknown = [name for name in options if name not in known]
    if unknown:
        raise ValueError(f"{', '.join(unknown)}: unknown options for {where}; known are {', '.join(known)}")


def recolour(drawn: Axes, cmap: str | Colormap) -> None:
    for shown in (*drawn.collections, *drawn.images):
        if shown.get_array() is not None:
            shown.set_cmap(cmap)


def plot_beside(result: Pictured, quantities: Sequence[Word]) -> Figure:
    """Maps of several quantities of one result, beside each other."""
    figure = new_figure((5.4 * len(quantities), 4.4))
    for axes, quantity in zip(figure.subplots(1, len(quantities)), quantities, strict=True):
        plot(result, quantity, ax=axes)
    return figure


def plot_side_by_side(
    results: Sequence[Pictured], names: Sequence[str], quantity: Word, kind: Flat | None, **options: Any
) -> Figure:
    """One quantity of several results on one scale, each under its name; options as for :func:`plot`."""
    if kind in get_args(Space) or "ax" in options:
        raise ValueError('several patches are drawn as maps or lines: kind="3d" and ax cannot be used')
    if kind not in (None, *get_args(Flat)):
        raise ValueError(f'kind is {kind!r}: "map" or "line" is needed')
    quantity_of(results[0], quantity)
    title, cmap, figsize = (options.pop(name, None) for name in ("title", "cmap", "figsize"))
    unknown = [name for name in options if name not in ("x", "y", "body", "limits")]
    if unknown:
        raise ValueError(
            f"{', '.join(unknown)}: unknown options; known are x, y, body, limits, title, cmap and figsize"
        )
    if options.get("limits") is None:
        given = {"kind": kind, **options} if kind else options
        options["limits"] = shared_limits(results, quantity, given)
    if kind == "line" or is_a_cut(options):
        figure = new_figure((7.2, 3.6 * len(results)))
        if cmap is not None:
            raise ValueError('cmap is for kind="map" only')
        panels = figure.subplots(len(results), 1, squeeze=False)[:, 0]
        for axes, result, name in zip(panels, results, names, strict=True):
            plot(result, quantity, kind, ax=axes, **options)
            axes.set_title(f"{name}: {axes.get_title(loc='left')}", loc="left", fontsize=9.5, color=INK)
    else:
        body = options.get("body", "lower")
        figure = maps_side_by_side(results, names, quantity, body, options["limits"])
        if cmap is not None:
            for axes in figure.axes:
                recolour(axes, cmap)
    if figsize is not None:
        figure.set_size_inches(*pair("figsize", figsize, "in"))
    if title is not None:
        figure.suptitle(title, x=0.01, ha="left", fontsize=10.5, color=INK)
    return figure


def is_a_cut(options: Mapping[str, Any]) -> bool:
    return options.get("x") is not None or options.get("y") is not None


def shared_limits(history: Sequence[Pictured], quantity: Word, options: dict[str, Any]) -> Limits | None:
    """Ends of one scale for all results; None for the status, which has no scale."""
    if quantity == "status":
        return None
    asked, body = quantity_of(history[0], quantity), options.get("body", "lower")
    is_line = options.get("kind") == "line" or is_a_cut(options)
    window = None if is_line or options.get("kind") == "3d" else window_of(history, asked)
    kept = []
    for result in history:
        values = flat(result, quantity_of(result, quantity, body).values).astype(float)
        is_local = asked.extent == "contact"
        shown = flat(result, result.status) > 0 if is_local else inside_window(result, window)
        kept.append(values[shown])
    everything = np.concatenate(kept)
    if is_line:
        low, high = float(everything.min(initial=0.0)), float(everything.max(initial=0.0))
        return (low, 1.05 * high) if low < high else (0.0, 1.0)
    scale = colour_scale(everything, asked)
    low, high = (float(v) * scale.factor for v in (scale.norm.vmin, scale.norm.vmax))  # type: ignore[arg-type]
    return (low, high) if low < high else None
