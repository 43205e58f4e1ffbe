# SPDX-License-Identifier: MIT OR Apache-2.0
"""Frequencies and growth of vibrations over the friction, and vibrations that move."""

from __future__ import annotations

from pathlib import Path
from typing import Protocol

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from .figures import canvases, from_zero, new_figure, own_figures, style_axes
from .moving import check_moving, image_of, moving_picture
from .quantities import INK, LINE_COLOURS, MILLIMETRE

Array = NDArray[np.float64]

#: Pictures of one period, and by how much of the height of the body it moves at most.
FRAMES, SHOWN = 24, 0.25
_REST = "#BBBBBB"


class Vibrating(Protocol):
    """Vibrations about a state of sliding, as :class:`mtb_rs.Stability` has them."""

    @property
    def free(self) -> tuple[str, ...]: ...
    @property
    def frequency(self) -> Array: ...
    @property
    def growth(self) -> Array: ...
    @property
    def modes(self) -> NDArray[np.complex128]: ...
    @property
    def friction(self) -> float: ...
    @property
    def critical_friction(self) -> float | None: ...
    @property
    def frictions(self) -> Array: ...
    @property
    def frequencies(self) -> Array: ...
    @property
    def growths(self) -> Array: ...
    @property
    def kind(self) -> str: ...
    def growing(self) -> NDArray[np.bool_]: ...
    @property
    def outline(self) -> Array: ...
    @property
    def reference_point(self) -> Array: ...


def draw_stability(of: Vibrating, ax: tuple[Axes, Axes] | None) -> Figure:
    """What :meth:`mtb_rs.Stability.plot` draws."""
    figure, upper, lower = canvases(ax, (7.2, 3.6))
    above, grows = of.frequencies >= 0.0, of.growing()
    for place, values, label in (
        (upper, of.frequencies, "frequency [Hz]"),
        (lower, of.growths, "growth [1/s]"),
    ):
        over = np.broadcast_to(of.frictions[:, None], values.shape)
        for these, colour, name in (
            (above & ~grows, LINE_COLOURS[0], "decays or stays"),
            (above & grows, LINE_COLOURS[1], "grows"),
        ):
            place.plot(over[these], values[these], ".", color=colour, markersize=3.5, label=name)
        place.axvline(of.friction, color=INK, linewidth=0.9, linestyle="--", label="this contact")
        if of.critical_friction is not None:
            place.axvline(
                of.critical_friction,
                color=LINE_COLOURS[1],
                linewidth=0.9,
                label="smallest unstable coefficient",
            )
        place.set_xlabel("coefficient of friction [-]")
        place.set_ylabel(label)
        style_axes(place)
        place.grid(True, color="#DDDDDD", linewidth=0.6)
    from_zero(upper)
    lower.axhline(0.0, color="#888888", linewidth=0.8)
    handles, labels = upper.get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=4, frameon=False, fontsize=8.5)
    return figure


def animate_stability(of: Vibrating, path: str | Path, mode: int | None, frames_per_second: float) -> Path:
    """What :meth:`mtb_rs.Stability.animate` writes."""
    target = check_moving(path, frames_per_second)
    if mode is not None and mode not in range(of.frequency.size):
        raise ValueError(f"mode is {mode!r}: a number from 0 to {of.frequency.size - 1} is needed")
    k = int(of.growth.argmax() if mode is None else mode)
    low, high = of.outline[:, [0, 2]] / MILLIMETRE
    width = float(high[0] - low[0])
    height = max(2.0 * float(high[1] - low[1]), 0.3 * width)
    corners = np.array(
        [[low[0], low[1]], [high[0], low[1]], [high[0], low[1] + height], [low[0], low[1] + height]]
    )
    shape = dict(zip(of.free, of.modes[k], strict=True))
    x, z, pitch = (shape.get(name, 0.0) for name in ("x", "z", "pitch"))
    # a rotation about y turns z towards x
    arms = corners * MILLIMETRE - of.reference_point[[0, 2]]
    moved = np.stack([x + pitch * arms[:, 1], z - pitch * arms[:, 0]], axis=1)
    size = float(np.abs(moved).max())
    moved = moved * (SHOWN * height / size if size > 0.0 else 0.0)
    growth = of.growth[k] / max(of.frequency[k], 1e-300)
    said = f"{of.frequency[k]:.4g} Hz, {'grows' if growth > 1e-6 else 'decays or stays'}, much enlarged"
    frames = []
    for turn in np.arange(FRAMES) / FRAMES:
        there = corners + (moved * np.exp(2j * np.pi * turn)).real
        with own_figures():
            figure = new_figure((6.0, 3.4))
        ax = figure.add_subplot()
        ax.axhline(low[1], color="#888888", linewidth=1.2)
        ax.fill(*corners.T, facecolor="none", edgecolor=_REST, linestyle="--")
        ax.fill(*there.T, facecolor=LINE_COLOURS[0], alpha=0.6, edgecolor=INK)
        room = 0.35 * height
        ax.set_xlim(low[0] - room, high[0] + room)
        ax.set_ylim(low[1] - room, low[1] + height + room)
        ax.set_aspect("equal")
        ax.set_xlabel("x [mm]")
        ax.set_ylabel("z [mm]")
        ax.set_title(said, loc="left", fontsize=10.5, color=INK)
        style_axes(ax)
        frames.append(image_of(figure))
    return moving_picture(frames, target, frames_per_second)
