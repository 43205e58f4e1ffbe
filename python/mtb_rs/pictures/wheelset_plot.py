# SPDX-License-Identifier: MIT OR Apache-2.0
"""Profiles, and wheels on rails over the lateral shift, as railway engineers draw them."""

from __future__ import annotations

from typing import ClassVar, Protocol

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from ..base.words import Guidance, Shape, Wheels
from ..geometry.profiles import Profile
from .figures import canvas, figure_of, new_figure, style_axes
from .quantities import INK, LINE_COLOURS, MILLIMETRE

Array = NDArray[np.float64]

#: By how much a wheel is raised over its rail where lines join the points that touch each other [mm].
RAISED = 14.0
#: Names of lines: how far their middle is off the wheel, the width of a sign and the height [points].
OFF, OF_SIGN, OF_LINE = 9.0, 7.0, 9.0
#: Height of a title above several axes and of the margins of a figure [inch].
OF_TITLE, PADS = 0.25, 0.1
#: Points of a profile that are drawn.
POINTS = 2001
_ACROSS = "#BBBBBB"
_LABELS = {
    "radius_difference": "rolling radius, left less right [mm]",
    "contact_angle": "contact angle [°]",
    "rail_position": "contact on the rail profile, y [mm]",
    "wheel_position": "contact on the wheel profile, y [mm]",
    "equivalent_conicity": "equivalent conicity [-]",
    "wavelength": "wavelength [m]",
}
_TITLES = {
    "contact_points": "Contact points over the shift [mm]",
    "radius_difference": "Difference of rolling radii",
    "contact_angle": "Contact angle",
    "rail_position": "Contact points on the rails",
    "wheel_position": "Contact points on the wheels",
    "equivalent_conicity": "Equivalent conicity",
    "wavelength": "Wavelength of the kinematic motion",
}


class Touching(Protocol):
    """Contact points of one wheel, as :class:`mtb_rs.TouchingWheel` has them."""

    @property
    def y(self) -> Array: ...
    @property
    def z(self) -> Array: ...
    @property
    def rail_position(self) -> Array: ...
    @property
    def wheel_position(self) -> Array: ...
    @property
    def contact_angle(self) -> Array: ...
    @property
    def rail(self) -> Array: ...
    @property
    def wheel(self) -> Array: ...


class Guided(Protocol):
    """A wheelset over its lateral shift, as :class:`mtb_rs.WheelsetGeometry` has it."""

    @property
    def shift(self) -> Array: ...
    @property
    def roll(self) -> Array: ...
    @property
    def radius_difference(self) -> Array: ...
    @property
    def left(self) -> Touching: ...
    @property
    def right(self) -> Touching: ...
    @property
    def rail_inclination(self) -> float: ...
    @property
    def names(self) -> tuple[str, str]: ...
    def amplitudes(self) -> Array: ...
    def equivalent_conicity(self, amplitude: Array, method: str) -> Array: ...
    def wavelength(self, amplitude: Array) -> Array: ...


def draw_profile(profile: Profile, quantity: Shape, ax: Axes | None) -> Figure:
    """A profile over y, and what it was before it was smoothed."""
    start, end = profile.range
    breaks = profile.breaks
    y = np.union1d(np.linspace(start, end, POINTS), breaks if breaks.size < POINTS else [])
    figure, ax = canvas(ax, (7.2, 3.9))
    smoothing = profile.smoothing
    before = None if smoothing is None else Profile.from_points(smoothing.y, smoothing.z)
    colour = LINE_COLOURS[0]
    if quantity == "height":
        points = profile._points
        if points is not None and points[0].size <= POINTS:
            label = "points" if smoothing is None else "points before"
            ax.plot(
                *(values / MILLIMETRE for values in points), ".", color=_ACROSS, markersize=3, label=label
            )
        label = profile.name
        ax.plot(y / MILLIMETRE, profile.height(y) / MILLIMETRE, color=colour, linewidth=1.6, label=label)
        ax.set_aspect("equal")
        ax.set_ylabel("z [mm]")
    else:
        wanted = _angle if quantity == "angle" else _curvature
        # at a jump the piece before it ends, so that it is drawn as one
        if before is not None:
            own = y[(y >= before.range[0]) & (y <= before.range[1])]
            # noise has curvatures a hundred times as large: as a line it would be a wall
            ax.plot(own / MILLIMETRE, wanted(before, own), ".", color=_ACROSS, markersize=2, label="before")
        ax.plot(y / MILLIMETRE, wanted(profile, y), color=colour, linewidth=1.4, label="smoothed")
        ax.set_ylabel("slope angle [°]" if quantity == "angle" else "curvature [1/m]")
        if before is not None and quantity == "curvature":
            # the smoothed curve is what is to be seen
            inner = wanted(profile, y[20:-20])
            room = 0.3 * max(float(np.ptp(inner)), 1e-9)
            ax.set_ylim(float(inner.min()) - room, float(inner.max()) + room)
    if smoothing is not None:
        for k, kink in enumerate(smoothing.kinks):
            named = "kinks" if k == 0 else None
            ax.axvline(kink / MILLIMETRE, color=LINE_COLOURS[1], linewidth=0.8, linestyle="--", label=named)
        residual = f"largest {1e6 * smoothing.largest:.3g} µm, rms {1e6 * smoothing.rms:.3g} µm"
        ax.set_title(f"{profile.name}: {residual}", loc="left", fontsize=10.5, color=INK)
        ax.legend(frameon=False, fontsize=8.5)
    else:
        ax.set_title(profile.name, loc="left", fontsize=10.5, color=INK)
    ax.set_xlabel("y [mm]")
    style_axes(ax)
    ax.grid(True, color="#DDDDDD", linewidth=0.6)
    return figure


class Uneven(Protocol):
    """A rail or a wheel with slices."""

    name: str
    positions: Array
    nominal: Profile
    is_around: ClassVar[bool]

    @property
    def range(self) -> tuple[float, float]: ...
    def departure(self, position: Array, y: Array) -> Array: ...


def draw_slices(slices: Uneven, ax: Axes | None) -> Figure:
    """Departure of a rail or a wheel from its nominal profile, over the position and y."""
    first, last = (-np.pi, np.pi) if slices.is_around else slices.positions[[0, -1]]
    along = np.linspace(first, last, POINTS)
    start, end = slices.range
    y = np.linspace(max(start, slices.nominal.range[0]), min(end, slices.nominal.range[1]), 161)[1:-1]
    departure = slices.departure(along[None, :], y[:, None]) / MILLIMETRE
    figure, ax = canvas(ax, (7.2, 3.9))
    largest = max(float(np.nanmax(np.abs(departure))), 1e-9)
    unit = np.pi / 180.0 if slices.is_around else MILLIMETRE
    drawn = ax.pcolormesh(
        along / unit, y / MILLIMETRE, departure, cmap="RdBu", vmin=-largest, vmax=largest, rasterized=True
    )
    figure.colorbar(drawn, ax=ax, label="departure [mm], > 0 outwards")
    ax.set_xlabel("angle on the wheel [°]" if slices.is_around else "position along the track [mm]")
    ax.set_ylabel("y [mm]")
    ax.set_title(
        f"{slices.name}: {slices.positions.size} sections on {slices.nominal.name}",
        loc="left",
        fontsize=10.5,
        color=INK,
    )
    return figure


def _angle(profile: Profile, y: Array) -> Array:
    return np.degrees(np.arctan(profile.slope(y)))


def _curvature(profile: Profile, y: Array) -> Array:
    return profile.curvature(y)


def draw_wheelset_geometry(of: Guided, quantity: Guidance, ax: Axes | None, side: Wheels) -> Figure:
    """What :meth:`mtb_rs.WheelsetGeometry.plot` draws."""
    sides = ("left", "right") if side == "both" else (side,)
    if quantity == "contact_points":
        return _draw_contact_points(of, ax, sides)
    figure, ax = canvas(ax, (7.2, 3.9))
    if quantity in ("equivalent_conicity", "wavelength"):
        over = of.amplitudes()
        lines = (
            {
                "by the wavelength": of.equivalent_conicity(over, "integration"),
                "harmonic": of.equivalent_conicity(over, "harmonic"),
            }
            if quantity == "equivalent_conicity"
            else {"": of.wavelength(over)}
        )
        ax.set_xlabel("amplitude [mm]")
    else:
        over = of.shift
        lines = (
            {"": of.radius_difference / MILLIMETRE}
            if quantity == "radius_difference"
            else {s: _of_side(getattr(of, s), quantity) for s in sides}
        )
        ax.set_xlabel("lateral shift to the left [mm]")
    styles = ("-", "--")
    for (name, line), colour, style in zip(lines.items(), LINE_COLOURS, styles, strict=False):
        places = over / MILLIMETRE
        if quantity in ("rail_position", "wheel_position"):
            # the point jumps where a wheel touches twice
            ax.plot(places, line, ".", color=colour, markersize=3, label=name)
        else:
            ax.plot(places, line, style, color=colour, linewidth=1.6, label=name or None)
    if len(lines) > 1:
        ax.legend(frameon=False, fontsize=9)
    if quantity in ("equivalent_conicity", "wavelength"):
        ax.set_ylim(0.0, None)
    ax.set_ylabel(_LABELS[quantity])
    title = f"{_TITLES[quantity]}: {' on '.join(of.names)}"
    ax.set_title(title, loc="left", fontsize=10.5, color=INK)
    style_axes(ax)
    ax.grid(True, color="#DDDDDD", linewidth=0.6)
    return figure


def _of_side(wheel: Touching, quantity: str) -> Array:
    values: Array = getattr(wheel, quantity)
    return np.degrees(values) if quantity == "contact_angle" else values / MILLIMETRE


def _draw_contact_points(of: Guided, ax: Axes | None, sides: tuple[str, ...]) -> Figure:
    if ax is None and len(sides) == 2:
        figure = new_figure((10.0, 3.5))
        # the left rail is on the left, as seen along the track
        panels = list(figure.subplots(1, 2))
        figure.suptitle(f"{_TITLES['contact_points']}: {' on '.join(of.names)}", fontsize=10.5, color=INK)
        _draw_sides(panels, of, sides, is_own=True)
        return figure
    if len(sides) == 2:
        raise ValueError(
            'side is "both": contact points of both wheels are drawn beside each other, without ax'
        )
    is_own = ax is None
    figure, ax = canvas(ax, (7.2, 4.0))
    title = f"{_TITLES['contact_points']}: {' on '.join(of.names)}"
    ax.set_title(title, loc="left", fontsize=10.5, color=INK)
    _draw_sides([ax], of, sides, is_own)
    return figure


def _draw_sides(panels: list[Axes], of: Guided, sides: tuple[str, ...], is_own: bool) -> None:
    """Wheels and lines, and then their names, once the axes have their places; a figure of its own is as high
    as the profiles need.
    """
    figure = figure_of(panels[0])
    drawn = [_draw_side(ax, of, side) for ax, side in zip(panels, sides, strict=True)]
    figure.draw_without_rendering()
    if is_own:
        boxes = [ax.get_tightbbox() for ax in panels]
        high = max(box.height for box in boxes if box is not None) / figure.dpi
        figure.set_figheight(high + OF_TITLE * (len(panels) > 1) + PADS)
        figure.draw_without_rendering()
    for ax, (ends, ways, wheel) in zip(panels, drawn, strict=True):
        _name_lines(ax, of.shift, ends, ways, wheel)


def _draw_side(ax: Axes, of: Guided, side: str) -> tuple[Array, Array, Array]:
    """A wheel raised over its rail, where it stands least shifted, with lines between touching points.

    Seen along the track: y to the left is drawn to the left. Returned are the ends of the lines on the wheel,
    the ways there from the rail, and the wheel, all as drawn [mm].
    """
    own: Touching = getattr(of, side)
    sign = 1.0 if side == "left" else -1.0
    middle = int(np.abs(of.shift).argmin())
    turn = of.rail_inclination
    rail = _turned(own.rail, turn)
    at = _turned(np.array([own.rail_position[middle], np.interp(own.rail_position[middle], *own.rail)]), turn)
    rail = rail + (np.array([sign * own.y[middle], own.z[middle]]) - at)[:, None]
    roll = sign * of.roll[middle]
    wheel = _turned(own.wheel, roll)
    spot = _turned(
        np.array([own.wheel_position[middle], np.interp(own.wheel_position[middle], *own.wheel)]), roll
    )
    to_track = np.array([sign * own.y[middle], own.z[middle]]) - spot
    wheel = wheel + to_track[:, None]
    raised = np.array([0.0, RAISED * MILLIMETRE])[:, None]
    on_wheel = _turned(np.array([own.wheel_position, np.interp(own.wheel_position, *own.wheel)]), roll)
    on_wheel = on_wheel + to_track[:, None] + raised
    on_rail = _turned(np.array([own.rail_position, np.interp(own.rail_position, *own.rail)]), turn)
    on_rail = on_rail + (np.array([sign * own.y[middle], own.z[middle]]) - at)[:, None]
    # seen along the track the left is at the left
    x = -1.0 if side == "left" else 1.0
    for curve, colour in ((rail, INK), (wheel + raised, LINE_COLOURS[0])):
        ax.plot(x * curve[0] / MILLIMETRE, curve[1] / MILLIMETRE, color=colour, linewidth=1.6)
    for k, shift in enumerate(of.shift):
        is_named = abs(shift / MILLIMETRE - round(shift / MILLIMETRE)) < 1e-6
        ends = np.array([on_rail[:, k], on_wheel[:, k]]).T / MILLIMETRE
        colour, width = (LINE_COLOURS[1], 0.9) if is_named else (_ACROSS, 0.4)
        ax.plot(x * ends[0], ends[1], color=colour, linewidth=width, zorder=3 if is_named else 1)
    ax.set_aspect("equal")
    # the rail, and of the wheel what faces it or touches
    across = np.concatenate([rail[0], on_wheel[0]]) / MILLIMETRE
    up = np.concatenate([rail[1], on_wheel[1]]) / MILLIMETRE
    ax.set_xlim(*sorted((x * (across.min() - 8.0), x * (across.max() + 8.0))))
    ax.set_ylim(up.min() - 3.0, up.max() + 7.0)
    ax.set_xlabel(f"right of the track's middle [mm], {side} wheel raised by {RAISED:g} mm")
    ax.set_ylabel("z [mm]")
    style_axes(ax)
    flip = np.array([[x], [1.0]]) / MILLIMETRE
    return flip * on_wheel, flip * (on_wheel - on_rail), flip * (wheel + raised)


def _turned(points: Array, angle: float) -> Array:
    """Points (2, ...) turned from y to z."""
    cos, sin = np.cos(angle), np.sin(angle)
    return np.array([cos * points[0] - sin * points[1], sin * points[0] + cos * points[1]])


def _name_lines(ax: Axes, shift: Array, ends: Array, ways: Array, wheel: Array) -> None:
    """The shifts of lines at whole millimetres, beside their ends (2, n) [mm], as many as have room.

    The axes must have their place in the figure.
    """
    dots_per_point = figure_of(ax).dpi / 72.0

    def in_points(places: Array) -> Array:
        return np.asarray(ax.transData.transform(places.T).T / dots_per_point)

    curve, at = in_points(wheel), in_points(ends)
    taken = curve
    whole = np.abs(shift / MILLIMETRE - np.round(shift / MILLIMETRE)) < 1e-6
    most = np.abs(shift[whole]).max(initial=0.0)

    def rank(k: int) -> tuple[bool, bool, float]:
        # the middle and the ends are named first
        size = float(abs(shift[k]))
        return 1e-9 < size < most - 1e-9, size % 4e-3 > 1e-9, size

    for k in sorted((int(k) for k in np.flatnonzero(whole)), key=rank):
        words = f"{shift[k] / MILLIMETRE + 0.0:.0f}".replace("-", "\N{MINUS SIGN}")
        nearest = int(np.hypot(*(curve - at[:, [k]])).argmin())
        before, after = curve[:, max(nearest - 1, 0)], curve[:, min(nearest + 1, curve.shape[1] - 1)]
        normal = np.array([before[1] - after[1], after[0] - before[0]]) / np.hypot(*(after - before))
        # on the side that the rail is not on
        away = OFF * normal * (1.0 if normal @ ways[:, k] > 0.0 else -1.0)
        half = 0.5 * np.array([OF_SIGN * len(words), OF_LINE])
        if (np.abs(taken - (at[:, k] + away)[:, None]) < half[:, None]).all(axis=0).any():
            continue
        # the corners and the middles of its sides keep others off
        frame = np.array([[-1, -1, -1, 0, 0, 1, 1, 1, 0], [-1, 0, 1, -1, 1, -1, 0, 1, 0]])
        taken = np.hstack([taken, (at[:, k] + away)[:, None] + frame * half[:, None]])
        ax.annotate(
            words,
            (float(ends[0, k]), float(ends[1, k])),
            (float(away[0]), float(away[1])),
            textcoords="offset points",
            ha="center",
            va="center",
            fontsize=7.5,
            color=INK,
        )
