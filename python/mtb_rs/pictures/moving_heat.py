# SPDX-License-Identifier: MIT OR Apache-2.0
"""A moving picture of a shoe that slides: pressure, temperature and sole over the time."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.figure import Figure
from numpy.typing import NDArray

from ..base.check import whole
from ..base.words import Field as Word
from ..results.grids import flat, patches
from ..results.result import Pictured
from .figures import new_figure, own_figures, style_axes
from .maps import draw_map, window_of
from .moving import check_moving, image_of, moving_picture
from .quantities import INK, LINE_COLOURS, MILLIMETRE, Scale, colour_scale, quantity_of

Array = NDArray[np.float64]
S = TypeVar("S", bound="Slid")

#: Height over width of the contact below which maps stand below each other.
FLAT = 0.45
#: Part of the states whose fields fit into the scale.
MOST = 0.95
#: What the maps show, and of which body.
MAPS: tuple[Word, ...] = ("pressure", "temperature")


class Slid(Pictured):
    """What :class:`mtb_rs.SlidingHeat` has over its steps."""

    time: Array
    velocity: Array
    forces: Array
    pressures: Array
    temperatures: Array
    depths: Array


@dataclass(frozen=True)
class Line:
    """Values (k,) over times (k,) [s], and what they are."""

    time: Array
    values: Array
    label: str


def animate_sliding(
    heat: Any, lines: Sequence[Line], path: str | Path, frames: int, frames_per_second: float
) -> Path:
    """Moving picture of a :class:`mtb_rs.SlidingHeat` below two lines over the time.

    Between steps the fields are linear in time. All frames have the same scales.
    """
    target = check_moving(path, frames_per_second)
    whole("frames", frames)
    times = np.linspace(heat.time[0], heat.time[-1], frames) if frames > 1 else heat.time[-1:]
    states = [_at(heat, float(time)) for time in times]
    scales = {word: _scale(states, word) for word in MAPS}
    deepest = float(heat.depths.max(initial=0.0))

    places: list[Any] = []

    def drawn(time: float, state: Slid) -> NDArray[np.uint8]:
        with own_figures():
            figure = _drawn(state, time, lines, scales, deepest)
            if places:
                _placed(figure, places)
            image = image_of(figure)
            if not places:
                # all frames have the same axes, and to lay them out takes longer than to draw them
                places.extend(axes.get_position(original=True) for axes in figure.axes)
            return image

    pictures = (drawn(*each) for each in zip(times, states, strict=True))
    return moving_picture(pictures, target, frames_per_second)


def _at(heat: S, time: float) -> S:
    """The state at a time [s]."""

    def between(fields: Array) -> Array:
        after = int(np.searchsorted(heat.time, time).clip(max=heat.time.size - 1))
        before = max(after - 1, 0)
        length = heat.time[after] - heat.time[before]
        weight = (time - heat.time[before]) / length if length > 0.0 else 1.0
        return np.asarray((1.0 - weight) * fields[before] + weight * fields[after])

    pressure = between(heat.pressures)
    status = np.where(pressure > 0.0, 2, 0).astype(np.int8)
    changed: dict[str, Any] = {"temperature_upper": between(heat.temperatures), "depth": between(heat.depths)}
    return replace(heat, pressure=pressure, status=status, **changed)  # type: ignore[type-var]


def _scale(states: Sequence[Slid], word: Word) -> Scale:
    """One scale for all states. A single one, such as that of a new sole with its edges, and what is singular
    at sharp edges do not flatten the rest: its end is then open."""
    asked = quantity_of(states[0], word, "upper")
    fields = [quantity_of(state, word, "upper").values[state.status > 0] for state in states]
    every = np.concatenate(fields)
    if every.min() < 0.0:
        return colour_scale(every, asked)
    usual = np.quantile([np.percentile(field, 97.0) for field in fields if field.size], MOST)
    round_end = colour_scale(np.array([usual]), asked)
    return colour_scale(every, asked, (0.0, (round_end.norm.vmax or 1.0) * round_end.factor))


def _drawn(
    state: Any, time: float, lines: Sequence[Line], scales: dict[Word, Scale], deepest: float
) -> Figure:
    places = flat(state, state.points)[:2]
    ratio = float(np.clip(np.ptp(places[1]) / max(np.ptp(places[0]), 1e-12), 0.16, 1.1))
    rows: list[Any] = [["lines", "lines"]]
    heights = [1.7]
    if ratio < FLAT:
        rows += [[word, word] for word in MAPS]
        heights += [6.2 * ratio + 0.35] * len(MAPS)
    else:
        rows.append(list(MAPS))
        heights.append(3.0 * ratio + 0.4)
    if deepest:
        rows.append(["sole", "sole"])
        heights.append(1.3)
    figure = new_figure((7.4, sum(heights) + 0.4))
    figure.set_dpi(100)
    axes: Any = figure.subplot_mosaic(rows, height_ratios=heights)
    _draw_lines(axes["lines"], time, lines)
    for word, scale in scales.items():
        asked = quantity_of(state, word, "upper")
        limits = (scale.norm.vmin or 0.0) * scale.factor, (scale.norm.vmax or 1.0) * scale.factor
        window = window_of([state], asked)
        draw_map(state, word, "upper", limits, axes[word], panel=True, window=window)
        largest = asked.values[state.status > 0].max(initial=0.0) / scale.factor
        name = "temperature of the sole" if word == "temperature" and ratio < FLAT else asked.label
        title = f"{name}, largest {largest:.3g} {scale.unit}"
        axes[word].set_title(title, loc="left", fontsize=10.5, color=INK)
        if ratio < FLAT:
            # as wide as the lines above and below
            axes[word].set_aspect("auto")
        drawn = ScalarMappable(scale.norm, scale.colours)
        bar = figure.colorbar(drawn, ax=axes[word], extend=scale.extend, aspect=12, pad=0.01)
        bar.set_label(f"[{scale.unit}]", color=INK)
        bar.outline.set_visible(False)
    axes["pressure"].set_xlabel("x [mm]" if ratio >= FLAT else "")
    if deepest:
        _draw_sole(axes["sole"], state, deepest)
    return figure


def _placed(figure: Figure, places: Sequence[Any]) -> None:
    """Puts the axes of a figure where those of another one are."""
    figure.set_layout_engine("none")
    for axes, place in zip(figure.axes, places, strict=True):
        axes.set_position(place)


def _draw_lines(ax: Axes, time: float, lines: Sequence[Line]) -> None:
    now = []
    # lines of which neither changes do not lie on each other
    room = (1.05, 1.3)
    for line, colour, side, above in zip(lines, LINE_COLOURS, (ax, ax.twinx()), room, strict=False):
        value = float(np.interp(time, line.time, line.values))
        side.plot(line.time, line.values, color=colour, linewidth=1.6)
        side.plot([time], [value], "o", color=colour, markersize=6.0, clip_on=False)
        side.set_ylim(0.0, above * max(float(line.values.max()), 1e-12))
        style_axes(side)
        side.set_ylabel(line.label, color=colour)
        side.tick_params(axis="y", labelcolor=colour)
        name, unit = line.label.removesuffix("]").split(" [")
        now.append(f"{name} {value:.3g} {unit}")
    side.spines["right"].set_visible(True)
    side.spines["right"].set_color("#888888")
    ax.set_xlim(0.0, None)
    ax.set_xlabel("time [s]")
    ax.set_title(f"{time:.2f} s: " + ", ".join(now), loc="left", fontsize=10.5, color=INK)


def _draw_sole(ax: Axes, state: Any, deepest: float) -> None:
    """The sole before and now along x, in the mean over the width of each grid."""
    x, depth = flat(state, state.points)[0] / MILLIMETRE, flat(state, state.depth)
    grids = patches(state)
    size, unit = (1e-3, "mm") if deepest >= 1e-3 else (1e-6, "µm")
    ax.axhline(0.0, color="#888888", linestyle="--", linewidth=1.2)
    for grid in grids:
        along = grid.view(x).mean(axis=0)
        ax.plot(along, -grid.view(depth).mean(axis=0) / size, color=LINE_COLOURS[0], linewidth=1.6)
    if not grids:
        ax.plot(x, -depth / size, ".", color=LINE_COLOURS[0], markersize=3.0)
    ax.set_ylim(-1.05 * deepest / size, 0.08 * deepest / size)
    ax.set_title(
        f"sole, new (dashed) and worn, mean across [{unit}]; a point at most {depth.max() / size:.3g} {unit}",
        loc="left",
        fontsize=10.5,
        color=INK,
    )
    along, across = state.forces[0, :2]
    way = "" if abs(along) <= abs(across) else f", sliding to the {'right' if along > 0.0 else 'left'}"
    ax.set_xlabel(f"x [mm]{way}")
    style_axes(ax)
    ax.grid(True, color="#DDDDDD", linewidth=0.6)
