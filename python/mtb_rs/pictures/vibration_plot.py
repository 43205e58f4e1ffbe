# SPDX-License-Identifier: MIT OR Apache-2.0
"""Elastic bodies that vibrate, in pictures and moving ones."""

from __future__ import annotations

from pathlib import Path
from typing import Any, Protocol

import numpy as np
from matplotlib import colormaps
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator
from mpl_toolkits.mplot3d.art3d import Line3DCollection, Poly3DCollection
from mpl_toolkits.mplot3d.axes3d import Axes3D
from numpy.typing import NDArray

from .figures import new_figure, own_figures
from .moving import check_moving, image_of, moving_picture
from .quantities import INK, MILLIMETRE

Array = NDArray[np.float64]

#: Pictures of one period, and by how much of the size of the body it moves at most.
FRAMES, SHOWN = 24, 0.12
_REST = "#999999"
#: Cosine of the angle between two triangles below which their common edge is drawn.
_SHARP = 0.8
_COLOURS = "viridis"


class Vibrating(Protocol):
    """A body with its vibrations, as :class:`mtb_rs.Vibration` has them."""

    @property
    def frequency(self) -> Array: ...
    @property
    def shapes(self) -> Array: ...
    @property
    def points(self) -> Array: ...
    @property
    def triangles(self) -> NDArray[np.int64]: ...
    @property
    def name(self) -> str: ...


def draw_vibration(of: Vibrating, mode: int, ax: Any) -> Figure:
    """What :meth:`mtb_rs.Vibration.plot` draws."""
    _check_mode(of, mode)
    if ax is None:
        figure = new_figure((5.8, 4.6))
        ax = figure.add_subplot(projection="3d")
    else:
        if not isinstance(ax, Axes3D):
            raise ValueError(f"ax is {ax!r}: axes in space (projection='3d') are needed")
        figure = ax.get_figure(root=True)
    _draw(of, mode, 1.0, ax)
    shown = ScalarMappable(Normalize(0.0, 1.0), colormaps[_COLOURS])
    figure.colorbar(shown, ax=ax, shrink=0.6, pad=0.12, label="displacement / largest [-]")
    return figure


def animate_vibration(of: Vibrating, path: str | Path, mode: int, frames_per_second: float) -> Path:
    """What :meth:`mtb_rs.Vibration.animate` writes."""
    target = check_moving(path, frames_per_second)
    _check_mode(of, mode)
    frames = []
    for turn in np.arange(FRAMES) / FRAMES:
        with own_figures():
            figure = new_figure((5.6, 4.2))
        _draw(of, mode, float(np.cos(2.0 * np.pi * turn)), figure.add_subplot(projection="3d"))
        frames.append(image_of(figure))
    return moving_picture(frames, target, frames_per_second)


def _check_mode(of: Vibrating, mode: Any) -> None:
    if isinstance(mode, bool) or mode not in range(of.frequency.size):
        raise ValueError(f"mode is {mode!r}: a number from 0 to {of.frequency.size - 1} is needed")


def _draw(of: Vibrating, mode: int, part: float, ax: Any) -> None:
    """The body at `part` of its largest displacement."""
    used, corners = np.unique(of.triangles, return_inverse=True)
    rest, shape = of.points[:, used].T / MILLIMETRE, of.shapes[mode][:, used].T
    size = float(np.ptp(rest, axis=0).max())
    far = np.linalg.norm(shape, axis=1)
    largest = float(far.max())
    there = rest + part * SHOWN * size / largest * shape
    corners = corners.reshape(-1, 3)
    share = abs(part) * far[corners].mean(axis=1) / largest
    ax.computed_zorder = False
    ax.add_collection3d(
        Line3DCollection(
            rest[_edges(rest, corners)[0]], colors=_REST, linewidths=0.8, linestyles="--", zorder=1
        )
    )
    colours = colormaps[_COLOURS](share)
    ax.add_collection3d(
        Poly3DCollection(there[corners], facecolors=colours, edgecolors=colours, linewidths=0.3, zorder=2)
    )
    edges, normals = _edges(there, corners)
    elevation, azimuth = np.radians([ax.elev, ax.azim])
    eye = np.array(
        [np.cos(elevation) * np.cos(azimuth), np.cos(elevation) * np.sin(azimuth), np.sin(elevation)]
    )
    seen = (normals @ eye > 0.0).any(axis=1)
    ax.add_collection3d(Line3DCollection(there[edges[seen]], colors=INK, linewidths=0.8, zorder=3))
    middle = 0.5 * (rest.max(axis=0) + rest.min(axis=0))
    half = 0.5 * np.ptp(rest, axis=0) + SHOWN * size
    for name, at, room in zip("xyz", middle, half, strict=True):
        getattr(ax, f"set_{name}lim")(at - room, at + room)
        getattr(ax, f"set_{name}label")(f"{name} [mm]")
        getattr(ax, f"{name}axis").set_major_locator(MaxNLocator(4))
    ax.set_box_aspect(half)
    ax.set_title(f"{of.name}: {of.frequency[mode]:.5g} Hz, much enlarged", fontsize=10.5, color=INK)


def _edges(points: Array, triangles: NDArray[np.int64]) -> tuple[NDArray[np.int64], Array]:
    """Edges (e, 2) at which the surface turns sharply, and the normals (e, 2, 3) beside them."""
    a, b, c = (points[triangles[:, k]] for k in range(3))
    normal = np.cross(b - a, c - a)
    normal = normal / np.linalg.norm(normal, axis=1, keepdims=True)
    pairs = np.sort(triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
    owner = np.repeat(np.arange(len(triangles)), 3)
    order = np.lexsort(pairs.T)
    # each edge of a closed surface has two triangles, which follow each other now
    pairs, beside = pairs[order].reshape(-1, 2, 2)[:, 0], normal[owner[order]].reshape(-1, 2, 3)
    sharp = (beside[:, 0] * beside[:, 1]).sum(axis=1) < _SHARP
    return pairs[sharp], beside[sharp]
