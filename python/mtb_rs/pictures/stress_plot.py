# SPDX-License-Identifier: MIT OR Apache-2.0
"""Pictures of the stress inside a body: sections, lines into the depth, and a view with a quarter cut
away."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from ..base.check import choice, number
from ..base.words import Limits, StressPart
from ..results.fields import Field
from ..results.stress_field import LABELS, StressField
from .figures import canvas, style_axes
from .maps import colour_bar, within
from .quantities import INK, LINE_COLOURS, MILLIMETRE, Scale, bar_title, colour_scale, unit_of
from .space import _bar, _plotter

if TYPE_CHECKING:
    import pyvista

Array = NDArray[np.float64]

_KINDS = ("section", "depth", "3d")


def draw_stress(
    field: StressField, quantity: Any = "von_mises", kind: str | None = None, **options: Any
) -> Any:
    """Draws a stress; see :meth:`mtb_rs.StressField.plot`."""
    if kind not in (None, *_KINDS):
        raise ValueError(f"kind is {kind!r}: one of {', '.join(map(repr, _KINDS))} is needed")
    if field.depths is None:
        raise ValueError(
            "this stress is of points that were asked for: pictures need one at depths, of stress(depths=...)"
        )
    if quantity == "dang_van":
        return _draw_passage(field, kind, options)
    names = _names(quantity, several=kind == "depth")
    drawn: dict[str, Any] = {"depth": _draw_depth, "3d": _draw_space}
    taken = {
        "section": ("x", "y", "limits", "ax"),
        "depth": ("x", "y", "dimensionless", "ax"),
        "3d": ("limits", "off_screen", "size"),
    }[kind or "section"]
    given = _given(f"a picture of the kind {kind or 'section'!r}", options, taken)
    return drawn.get(kind or "section", _draw_section)(field, names, **given)


def _given(picture: str, options: dict[str, Any], taken: Sequence[str]) -> dict[str, Any]:
    """The options that a picture takes; ValueError for others."""
    for name, value in options.items():
        if name not in taken and value is not None and value is not False:
            raise ValueError(f"{name} is {value!r}: {picture} takes {', '.join(taken)}")
    return {name: value for name, value in options.items() if name in taken}


def _names(quantity: Any, *, several: bool) -> tuple[StressPart, ...]:
    names = (quantity,) if isinstance(quantity, str) or not several else tuple(quantity)
    for name in names:
        choice("quantity", name, StressPart)
    return names


#: Slope of the rows over x up to which they lie along it.
_ALONG = 1e-9


def _own(field: StressField, places: Array) -> Array:
    """Places (3, ...) [m] seen along the rows of a grid that is turned on the surface."""
    row = field.points[:2, 0, 0, -1] - field.points[:2, 0, 0, 0]
    if abs(row[1]) <= _ALONG * abs(row[0]):
        return places
    cos, sin = row / np.linalg.norm(row)
    turned = np.tensordot(np.array([[cos, sin], [-sin, cos]]), places[:2], 1)
    return np.concatenate([turned, places[2:]])


def _axes(field: StressField) -> tuple[Array, Array, str]:
    """x (nx,) and y (ny,) [m], and what is said of their names."""
    x, y, _ = own = _own(field, field.points)
    said = "" if own is field.points else " of the turned shoe"
    return x[0, 0], y[0, :, 0], said


def _nearest(name: str, asked: float | None, places: Array, usual: float) -> int:
    """Number of the line nearest to a place; ValueError for one beyond the cells."""
    place = usual if asked is None else number(name, asked, "m")
    step = float(np.diff(places).mean()) if places.size > 1 else np.inf
    if not places[0] - step <= place <= places[-1] + step:
        raise ValueError(f"{name} is {place:g} m: the points lie from {places[0]:g} to {places[-1]:g} m")
    return int(np.abs(places - place).argmin())


def _draw_section(
    field: StressField,
    names: tuple[StressPart, ...],
    x: float | None = None,
    y: float | None = None,
    limits: Limits | None = None,
    ax: Axes | None = None,
) -> Figure:
    if x is not None and y is not None:
        raise ValueError("both x and y are given: a section is a plane of one of them")
    name = names[0]
    places_x, places_y, said = _axes(field)
    place = _own(field, field.maximum()[1])
    values = field._values(name)
    along_y = x is not None or (y is None and places_x.size == 1)
    section: tuple[Any, ...]
    if along_y:
        k = _nearest("x", x, places_x, place[0])
        plane, section, at = values[:, :, k], (slice(None), slice(None), k), places_x[k]
        pressed = np.asarray(field.pressure)[:, k] > 0.0
    else:
        k = _nearest("y", y, places_y, place[1])
        plane, section, at = values[:, k], (slice(None), k), places_y[k]
        pressed = np.asarray(field.pressure)[k] > 0.0
    other = "x" if along_y else "y"
    title = f"{field.body} body at {other}{said} = {at / MILLIMETRE:.3g} mm"
    x_own, y_own, z_own = (own[section] for own in _own(field, field.points))
    places = (y_own, "y" + said) if along_y else (x_own, "x" + said)
    return _draw_plane(plane, places, z_own, field, pressed, (name, LABELS[name]), limits, ax, title)


def _draw_passage(field: StressField, kind: str | None, options: dict[str, Any]) -> Figure:
    """Dang Van's stress over the section across the way of a passage."""
    if kind not in (None, "section"):
        raise ValueError(f"kind is {kind!r}: of 'dang_van' there is a section")
    taken = ("coefficient", "residual_stress", "along", "limits", "ax")
    given = _given("a picture of 'dang_van'", options, taken)
    if "coefficient" not in given:
        raise ValueError("coefficient is missing: the weight of the hydrostatic stress, such as 0.35")
    limits, ax = given.pop("limits", None), given.pop("ax", None)
    along = given["along"] = field._passage(given.get("along"))
    plane = field.dang_van(**given)
    x, y, z = _own(field, field.points)
    pressed = np.asarray((np.asarray(field.pressure) > 0.0).any(axis=1 if along == "x" else 0))
    across, z = ((y[:, :, 0], "y"), z[:, :, 0]) if along == "x" else ((x[:, 0], "x"), z[:, 0])
    title = f"{field.body} body, passage along {along}"
    called = "dang_van", "shear stress after Dang Van"
    return _draw_plane(plane, across, z, field, pressed, called, limits, ax, title)


def _draw_plane(
    plane: Array,
    axis: tuple[Array, str],
    z: Array,
    field: StressField,
    pressed: NDArray[np.bool_],
    called: tuple[str, str],
    limits: Limits | None,
    ax: Axes | None,
    title: str,
) -> Figure:
    """Values (m, n) [Pa] over places along the surface, with their name, and heights (m, n) [m].

    The surface is marked where it is `pressed` (n,).
    """
    across, letter = axis
    name, label = called
    if min(plane.shape) < 2:
        raise ValueError("a section needs at least two depths, and two points beside each other")
    tall = max(float(np.ptp(z) / np.ptp(across)), 0.25)
    # as wide as its height leaves it, beside the key to the colours
    figure, ax = canvas(ax, (min(7.2, max(3.4, 5.2 / tall + 2.4)), min(6.4, 5.2 * tall + 1.1)))
    scale = colour_scale(plane, Field(name, label, "Pa", plane), limits)
    low, high = (float(end) for end in scale.norm.inverse(np.array([0.0, 1.0])))
    levels = np.linspace(low, high, 25)
    drawn = ax.contourf(
        across / MILLIMETRE,
        z / MILLIMETRE,
        plane / scale.factor,
        levels=levels,
        cmap=scale.colours,
        norm=scale.norm,
        extend=scale.extend,
    )
    drawn.set_edgecolor("face")
    ax.contour(
        across / MILLIMETRE,
        z / MILLIMETRE,
        plane / scale.factor,
        levels=levels[::4],
        colors="white",
        linewidths=0.4,
    )
    assert field.depths is not None
    above = field.depths[0] / (field.depths[1] - field.depths[0])
    line, surface = (places[0] + above * (places[0] - places[1]) for places in (across, z))
    surface = np.where(pressed, surface, np.nan) / MILLIMETRE
    ax.plot(line / MILLIMETRE, surface, color=INK, linewidth=3.0, solid_capstyle="butt", clip_on=False)
    spot = np.unravel_index(int(plane.argmax()), plane.shape)
    ax.plot(across[spot] / MILLIMETRE, z[spot] / MILLIMETRE, "+", color=INK, markersize=9, clip_on=False)
    ax.set_aspect("equal")
    ax.set(xlabel=f"{letter} [mm]", ylabel="z [mm]")
    style_axes(ax)
    colour_bar(figure, drawn, ax, f"{label} [{scale.unit}]", scale.extend)
    ax.set_title(
        within(ax, f"{title}, largest {plane.max() / scale.factor:.4g} {scale.unit} (+)"),
        fontsize=9.5,
        color=INK,
    )
    return figure


def _draw_depth(
    field: StressField,
    names: tuple[StressPart, ...],
    x: float | None = None,
    y: float | None = None,
    dimensionless: bool = False,
    ax: Axes | None = None,
) -> Figure:
    if not names:
        raise ValueError("quantity is []: at least one quantity is needed")
    places_x, places_y, _ = _axes(field)
    place = _own(field, field.maximum()[1])
    i, j = _nearest("x", x, places_x, place[0]), _nearest("y", y, places_y, place[1])
    lines = [field._values(name)[:, j, i] for name in names]
    deep = np.asarray(field.depths)
    figure, ax = canvas(ax, (5.4, 4.2))
    if dimensionless:
        if not field.half_width:
            raise ValueError("dimensionless is True: nothing presses that could give a scale")
        factor, unit, step = field.peak_pressure, "share of the peak pressure", field.half_width
        below = "depth over the half width of the contact"
    else:
        factor, unit = unit_of(np.concatenate(lines), "Pa")
        step, below = MILLIMETRE, "depth [mm]"
    for name, line, colour in zip(names, lines, _colours(len(names)), strict=True):
        ax.plot(line / factor, deep / step, color=colour, label=LABELS[name])
    ax.axvline(0.0, color="#9A9A9A", linewidth=0.8)
    ax.set_ylim(deep[-1] / step, 0.0)
    kind = LABELS[names[0]] if len(names) == 1 else "stress"
    ax.set(xlabel=f"{kind} [{unit}]", ylabel=below)
    at = field.points[:2, 0, j, i] / MILLIMETRE
    ax.set_title(
        f"{field.body} body at x = {at[0]:.3g} mm, y = {at[1]:.3g} mm",
        fontsize=9.5,
        color=INK,
    )
    if len(names) > 1:
        ax.legend(frameon=False, fontsize=8.5)
    style_axes(ax)
    return figure


def _colours(count: int) -> Sequence[str]:
    return [LINE_COLOURS[k % len(LINE_COLOURS)] for k in range(count)]


def stress_grid(field: StressField) -> pyvista.StructuredGrid:
    """See :meth:`mtb_rs.StressField.to_pyvista`."""
    try:
        import pyvista
    except ImportError as error:
        raise ImportError("pyvista is missing: pip install 'mtb-rs[viz]'") from error
    if field.depths is None:
        raise ValueError("this stress is of points that were asked for: a grid needs one at depths")
    grid = pyvista.StructuredGrid(*(np.moveaxis(row, 0, -1) for row in field.points))
    for name in LABELS:
        values = np.moveaxis(field._values(name), 0, -1)  # type: ignore[arg-type]
        grid.point_data[name] = values.ravel(order="F")
    grid.user_dict["units"] = dict.fromkeys(LABELS, "Pa")
    return grid


def _draw_space(
    field: StressField,
    names: tuple[StressPart, ...],
    limits: Limits | None = None,
    off_screen: bool | None = None,
    size: tuple[int, int] = (1400, 950),
) -> pyvista.Plotter:
    name = names[0]
    if min(field.points.shape[1:]) < 2:
        raise ValueError("a view in space needs at least two depths, and two points along x and along y")
    plotter = _plotter(off_screen, size)
    values = field._values(name)
    scale: Scale = colour_scale(values, Field(name, LABELS[name], "Pa", values), limits)
    grid = stress_grid(field)
    grid.point_data["drawn"] = grid.point_data[name] / scale.factor
    _, place = field.maximum(name)
    low, high = np.array(grid.bounds[::2]), np.array(grid.bounds[1::2])
    # the quarter in front of the largest value is taken away, or that of the middle where it is at a border
    cut = np.where(np.abs(place - low) * np.abs(high - place) > 0.0, place, 0.5 * (low + high))
    room = high - low
    box = [cut[0], high[0] + room[0], low[1] - room[1], cut[1], low[2] - room[2], high[2] + room[2]]
    body = grid.clip_box(box, invert=True)
    plotter.add_mesh(
        body,
        scalars="drawn",
        cmap=scale.colours,
        clim=(scale.norm.vmin, scale.norm.vmax),
        lighting=False,
        scalar_bar_args=_bar(bar_title(LABELS[name], values, scale)),
    )
    plotter.add_mesh(grid.outline(), color=INK, line_width=2)
    plotter.add_axes(color=INK, line_width=3)
    up = 1.0 if field.body == "lower" else -1.0
    middle, span = 0.5 * (low + high), float(room.max())
    eye = middle + span * np.array([1.2, -1.5, 1.1 * up])
    plotter.camera_position = [tuple(eye), tuple(middle), (0, 0, 1)]
    plotter.reset_camera()
    plotter.camera.SetWindowCenter(0.12, 0.0)
    return plotter
