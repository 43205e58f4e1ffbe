# SPDX-License-Identifier: MIT OR Apache-2.0
"""Pictures of sweeps: a quantity over the arguments of a scene, areas over loads."""

from __future__ import annotations

import textwrap
from collections.abc import Mapping, Sequence
from itertools import cycle
from typing import Any, Protocol

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from ..results.fields import Field
from ..results.sweep_table import SweepTable
from .figures import canvas, from_zero, style_axes
from .quantities import INK, LINE_COLOURS, PREFIXES, unit_of

Array = NDArray[np.float64]

#: Letters of a label that stand beside each other under a picture of usual width.
LETTERS = 84
#: Most labels that are listed under a picture.
MOST_LISTED = 12


def draw_sweep(table: SweepTable, quantity: str, ax: Axes | None) -> Figure:
    """A quantity of a sweep over its first parameter, a line for each value of the others."""
    if not table.columns:
        raise ValueError("nothing to draw: no case of the sweep is solved")
    if quantity not in table.columns:
        raise ValueError(f"quantity is {quantity!r}: one of {', '.join(table.columns)} is needed")
    (first, along), *others = table.parameters.items()
    values = table.columns[quantity]
    unit = table.units.get(quantity, "")
    factor = 1.0
    if unit in PREFIXES and unit != "1":
        factor, unit = unit_of(values[np.isfinite(values)], unit)
    numeric = all(isinstance(v, (int, float)) and not isinstance(v, bool) for v in along)
    places = np.array(along, dtype=float) if numeric else np.arange(len(along), dtype=float)
    measured = table.units.get(first, "")
    if measured in PREFIXES and measured != "1":
        step, measured = unit_of(places, measured)
        places = places / step
    order = np.argsort(places, kind="stable")
    figure, ax = canvas(ax, (7.2, 3.9))
    styles = ((colour, dash) for dash in cycle(("-", "--", ":", "-.")) for colour in LINE_COLOURS)
    for at, (colour, dash) in zip(np.ndindex(values.shape[1:]), styles, strict=False):
        label = ", ".join(
            f"{spaced(k)} = {_measured(table, k, i)}" for (k, v), i in zip(others, at, strict=True)
        )
        line = values[(slice(None), *at)][order] / factor
        # labels have no places between them
        ax.plot(
            places[order],
            line,
            linestyle=dash if numeric else "none",
            marker="." if numeric else "o",
            color=colour,
            linewidth=1.6,
            label=label or None,
        )
    if not numeric:
        _name_places(ax, places, [_plain(v) for v in along], spaced(first))
    else:
        ax.set_xlabel(f"{spaced(first)} [{measured}]" if measured not in ("", "1") else spaced(first))
    name = spaced(quantity)
    ax.set_ylabel(f"{name} [{unit}]" if unit not in ("", "1") else name)
    # "scene" is what one is called that was given no name
    name = table.attributes["scene"]
    ax.set_title("" if name == "scene" else spaced(name), loc="left", fontsize=10.5, color=INK)
    if others:
        _explain_lines(ax)
    # whole numbers, not what they are above another one
    ax.ticklabel_format(axis="y", useOffset=False)
    style_axes(ax)
    ax.grid(True, color="#DDDDDD", linewidth=0.6)
    return figure


def draw_area_load(curve: AreaLoad, ax: Axes | None) -> Figure:
    """Contact area over the force of a rough contact, in the order of the forces."""
    order = np.argsort(curve.force, kind="stable")
    newton, force = _unit(_FORCES, float(curve.force.max()))
    square, area = _unit(_AREAS, float(curve.contact_area.max()))
    figure, ax = canvas(ax, (7.2, 3.9))
    labels = f"normal force [{force}]", f"contact area [{area}]"
    areas = {"": curve.contact_area[order] / square}
    _draw_lines(ax, curve.force[order] / newton, areas, labels, "Contact area over load")
    from_zero(ax)
    return figure


def draw_start(start: Start, quantity: str, ax: Axes | None) -> Figure:
    """The force or the share that slips over the way of the upper body, from rest."""
    steps = np.concatenate([np.zeros((1, 2)), start.displacement])
    way = np.cumsum(np.linalg.norm(np.diff(steps, axis=0), axis=1))
    factor, unit = unit_of(way, "m")
    figure, ax = canvas(ax, (7.2, 3.9))
    asked = start.totals()[quantity]
    if quantity == "force":
        size, name = _unit(_FORCES, float(np.abs(start.force).max(initial=0.0)))
        lines = {"along x": start.force[:, 0] / size, "along y": start.force[:, 1] / size}
        # a component that is rounding beside the other one tells nothing
        least = 1e-6 * max(float(np.abs(line).max(initial=0.0)) for line in lines.values())
        lines = {label: line for label, line in lines.items() if np.abs(line).max(initial=0.0) > least}
    else:
        name, lines = "%", {"": 100.0 * asked.values}
    if quantity == "slip_share":
        ax.set_ylim(0.0, 105.0)
    over = f"way of the upper body [{unit}]"
    _draw_lines(ax, way / factor, lines, (over, f"{asked.label} [{name}]"), "Start of sliding")
    return figure


def _draw_lines(
    ax: Axes, over: Array, lines: Mapping[str, Array], labels: tuple[str, str], title: str
) -> None:
    """Lines over the steps of a study, with a legend where there are several."""
    for (name, line), colour in zip(lines.items(), LINE_COLOURS, strict=False):
        shown = name if len(lines) > 1 else None
        ax.plot(over, line, marker=".", color=colour, linewidth=1.6, label=shown)
    if len(lines) > 1:
        ax.legend(frameon=False, fontsize=9)
    ax.set_xlim(left=0.0)
    ax.set_xlabel(labels[0])
    ax.set_ylabel(labels[1])
    ax.set_title(title, loc="left", fontsize=10.5, color=INK)
    style_axes(ax)
    ax.grid(True, color="#DDDDDD", linewidth=0.6)


class Worn(Protocol):
    """A contact that was worn over a distance."""

    @property
    def distance(self) -> Array: ...
    def totals(self) -> Mapping[str, Any]: ...


def draw_wear(worn: Worn, quantity: str, ax: Axes | None) -> Figure:
    """Depth, volume, uniformity or peak pressure over the sliding distance."""
    asked = worn.totals()[quantity]
    factor, unit = unit_of(worn.distance, "m") if worn.distance[-1] < 1e3 else (1e3, "km")
    figure, ax = canvas(ax, (7.2, 3.9))
    values = np.atleast_2d(asked.values)
    if quantity == "uniformity":
        size, name = 1e-2, "%"
    elif quantity == "worn_volume":
        size, name = 1e-9, "mm³"
    else:
        size, name = unit_of(values, asked.unit)
    labels = ["upper body", "lower body"] if len(values) == 2 else [""]
    lines = {label: line / size for label, line in zip(labels, values, strict=True) if line.any()}
    over = f"sliding distance [{unit}]"
    _draw_lines(ax, worn.distance / factor, lines, (over, f"{asked.label} [{name}]"), "Wear")
    if quantity == "uniformity":
        ax.set_ylim(0.0, 105.0)
    else:
        from_zero(ax)
    return figure


class HeatOverTime(Protocol):
    """Temperatures and heat over the time."""

    @property
    def time(self) -> Array: ...


#: Histories of heat: in words, with their units.
_HEAT = {
    "peaks": ("highest temperature", "K"),
    "means": ("mean temperature of the contact face above", "K"),
    "friction_powers": ("heat of friction", "W"),
    "heats_upper": ("heat into the upper body", "W"),
    "heats_lower": ("heat into the lower body", "W"),
    "losses": ("heat out of the upper body through its film", "W"),
    "stored": ("heat in the upper body", "J"),
    "volumes_upper": ("worn off the upper body", "mm³"),
    "volumes_lower": ("worn off the lower body", "mm³"),
    "errors": ("error of a step", "%"),
}


def draw_heat(heat: HeatOverTime, quantity: str, ax: Axes | None) -> Figure:
    """A temperature, a heat, what is worn or the error of steps, over the time of sliding."""
    values = np.asarray(getattr(heat, quantity))
    words, unit = _HEAT[quantity]
    largest = float(np.abs(values).max(initial=0.0))
    size, name = (1e3, f"k{unit}") if unit in ("W", "J") and largest >= 1e3 else (1.0, unit)
    size = {"mm³": 1e-9, "%": 1e-2}.get(unit, size)
    figure, ax = canvas(ax, (7.2, 3.9))
    _draw_lines(ax, heat.time, {"": values / size}, ("time [s]", f"{words} [{name}]"), "Heat of sliding")
    return figure


class Stop(Protocol):
    """Forces (k, m) [N] of shoes and others over the time, and each shoe."""

    @property
    def time(self) -> Array: ...
    @property
    def speed(self) -> Array: ...
    @property
    def forces(self) -> Array: ...
    @property
    def other_force(self) -> Array: ...
    @property
    def errors(self) -> Array: ...
    @property
    def shoes(self) -> Sequence[HeatOverTime]: ...


def draw_braking(stop: Stop, quantity: str, ax: Axes | None) -> Figure:
    """The speed, the forces, or what the shoes of least and most pull have, over the time of a stop."""
    figure, ax = canvas(ax, (7.2, 3.9))
    if quantity == "speed":
        _draw_lines(ax, stop.time, {"": stop.speed}, ("time [s]", "speed [m/s]"), "Stop")
        from_zero(ax)
        return figure
    if quantity == "forces":
        forces = {"all shoes": stop.forces.sum(axis=1)}
        if stop.other_force.any():
            forces["other brakes"] = stop.other_force
        size, name = _unit(_FORCES, float(np.concatenate(list(forces.values())).max()))[:2]
        lines = {label: line / size for label, line in forces.items()}
        words = f"brake force [{name}]"
    elif quantity == "errors":
        lines, words = {"": 1e2 * stop.errors}, "error of a step [%]"
    else:
        pulls = stop.forces[0]
        order = {"most pulled shoe": int(pulls.argmax()), "least pulled shoe": int(pulls.argmin())}
        if pulls.max() == pulls.min():
            order = {"": 0}
        label, unit = _HEAT[quantity]
        scale = 1e-9 if unit == "mm³" else 1.0
        lines = {name: np.asarray(getattr(stop.shoes[k], quantity)) / scale for name, k in order.items()}
        words = f"{label} [{unit}]"
    _draw_lines(ax, stop.time[1:], lines, ("time [s]", words), "Stop")
    if quantity == "forces":
        from_zero(ax)
    return figure


def _unit(units: tuple[tuple[float, str], ...], largest: float) -> tuple[float, str]:
    return next((unit for unit in units if largest >= unit[0]), units[-1])


#: Newtons of the units of a force, square metres of those of an area.
_FORCES = ((1e3, "kN"), (1.0, "N"), (1e-3, "mN"), (1e-6, "µN"))
_AREAS = ((1.0, "m²"), (1e-6, "mm²"), (1e-12, "µm²"))


class AreaLoad(Protocol):
    """Areas [m2] over forces [N]."""

    @property
    def force(self) -> Array: ...
    @property
    def contact_area(self) -> Array: ...


class Start(Protocol):
    """Forces (m, 2) [N] over displacements (m, 2) [m], and other totals."""

    @property
    def displacement(self) -> Array: ...
    @property
    def force(self) -> Array: ...
    def totals(self) -> dict[str, Field]: ...


def _name_places(ax: Axes, places: Array, labels: list[str], name: str) -> None:
    """Labels at the places if they fit beside each other, else their numbers, with a list under the axis."""
    room = min(max(LETTERS // len(labels), 8), 24)
    lines = [textwrap.wrap(label, room, break_long_words=False) or [""] for label in labels]
    if all(len(line) <= 3 and max(map(len, line)) <= room for line in lines):
        ax.set_xticks(places, ["\n".join(line) for line in lines])
        ax.set_xlabel(name)
        return
    ax.set_xticks(places, [str(k) for k in range(1, len(labels) + 1)])
    listed = "\n".join(f"{k}: {_shortened(label)}" for k, label in enumerate(labels[:MOST_LISTED], 1))
    more = f"\n... to {len(labels)}" if len(labels) > MOST_LISTED else ""
    ax.set_xlabel(f"{name}\n{listed}{more}", loc="left", multialignment="left")


def _explain_lines(ax: Axes) -> None:
    """A legend beside the picture; of long names below it."""
    handles, labels = ax.get_legend_handles_labels()
    names = [_shortened(label) for label in labels]
    if max(map(len, names)) <= 28:
        ax.legend(handles, names, frameon=False, fontsize=9, loc="upper left", bbox_to_anchor=(1.0, 1.0))
    else:
        below = -0.2 - 0.06 * ax.get_xlabel().count("\n")
        ax.legend(handles, names, frameon=False, fontsize=9, loc="upper left", bbox_to_anchor=(0.0, below))


def _shortened(label: str) -> str:
    return label if len(label) <= LETTERS else f"{label[: LETTERS - 24]} ... {label[-20:]}"


def spaced(name: str) -> str:
    return name.replace("_", " ")


def _measured(table: SweepTable, name: str, at: int) -> str:
    """One of the values of a parameter with its unit, all in the same one."""
    values = table.parameters[name]
    factor, unit = 1.0, table.units.get(name, "")
    if unit in PREFIXES and unit != "1":
        factor, unit = unit_of(np.array(values, dtype=float), unit)
    value = values[at] / factor if factor != 1.0 else values[at]
    return _plain(value) if unit in ("", "1") else f"{_plain(value)} {unit}"


def _plain(value: Any) -> str:
    return f"{value:g}" if isinstance(value, float) else str(value)
