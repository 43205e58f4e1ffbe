# SPDX-License-Identifier: MIT OR Apache-2.0
"""The regular grids inside a result, as pictures and files need them: cells and their corners."""

from __future__ import annotations

from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from ..geometry.contact_points import Patch
from .result import Pictured

Array = NDArray[np.float64]


def flat(result: Pictured, values: NDArray[Any]) -> NDArray[Any]:
    """A field of `result`, (..., ny, nx) or (..., n), with its points in one row: (..., n)."""
    lead = values.ndim - result.pressure.ndim
    return values.reshape(*values.shape[:lead], -1)


def patches(result: Pictured) -> tuple[Patch, ...]:
    """The regular grids of a result, for use with :func:`flat`; none where the points are scattered."""
    own = result.patches
    if result.pressure.ndim == 1 or len(own) == 1:
        return own
    ny, nx = result.pressure.shape
    # the middle row and the middle column stand for all: rows of cells are alike, and results have many
    lines = result.points[:, ny // 2], result.points[:, :, nx // 2]
    steps = [np.linalg.norm(np.diff(line), axis=0) for line in lines]
    dx, dy = (float(step.mean()) if step.size else 0.0 for step in steps)
    # a single row or column has its width by the area, and a single cell is a square
    cell = float(result.area.max())
    dx = dx or (cell / dy if dy else cell**0.5)
    dy = dy or cell / dx
    return (Patch("contact", 0, nx, ny, (dx, dy)),)


def borders(centres: Array, halved: tuple[bool, bool] = (False, False)) -> Array:
    """Cell borders (..., n + 1) along the last axis, from the points (..., n) of the cells.

    Inside, a border is the mean of its two points. The ends are extrapolated linearly, so that a uniform
    grid gives back its own cells; where the first or last cell is `halved`, its point is the end itself.
    """
    first, last = (0.0 if half else 0.5 for half in halved)
    start = centres[..., :1] - first * (centres[..., 1:2] - centres[..., :1])
    end = centres[..., -1:] + last * (centres[..., -1:] - centres[..., -2:-1])
    return np.concatenate([start, 0.5 * (centres[..., 1:] + centres[..., :-1]), end], axis=-1)


def corners(result: Pictured, patch: Patch, points: Array) -> Array:
    """Corners (..., ny + 1, nx + 1) of the cells of `patch`, from the `points` (2 or 3, n) of all cells.

    Points may be the centres of cells, or nodes whose border cells are halved by the edge of the body:
    their areas tell.
    """
    area = patch.view(flat(result, result.area))
    columns, rows = area.mean(axis=0), area.mean(axis=1)
    along, across = _single_steps(result, patch)
    cell = float(np.prod(patch.spacing))
    inside = _spread(patch.view(points), _halved(columns, cell), along)
    return np.swapaxes(_spread(np.swapaxes(inside, -1, -2), _halved(rows, cell), across), -1, -2)


def line_borders(result: Pictured, patch: Patch, cut: Literal["x", "y"]) -> Array:
    """Borders [m] of the cells along each line of `patch`: of rows along x (ny, nx + 1), which lie at a y, or
    of columns along y (nx, ny + 1)."""
    points, area = patch.view(flat(result, result.points)), patch.view(flat(result, result.area))
    along, across = _single_steps(result, patch)
    cell = float(np.prod(patch.spacing))
    if cut == "y":
        return np.asarray(_spread(points, _halved(area.mean(axis=0), cell), along)[0])
    return np.asarray(_spread(np.swapaxes(points, -1, -2), _halved(area.mean(axis=1), cell), across)[1])


def _spread(points: Array, halved: tuple[bool, bool], step: Array) -> Array:
    """Borders (k, m, n + 1) along the last axis of `points` (k, m, n); a single one has its `step` (3,)."""
    if points.shape[-1] > 1:
        return borders(_at_ends(points, halved, step), halved)
    half = 0.5 * step[: len(points), None, None]
    return np.concatenate([points - half, points + half], axis=-1)


def _at_ends(points: Array, halved: tuple[bool, bool], step: Array) -> Array:
    """Points (k, m, n) whose first and last, if they are `halved` cells, lie at the ends of the body.

    Nodes do. Prepared contacts have the mean places of hats, which for half a hat is a third of a `step`
    inside.
    """
    moved, n = points.copy(), points.shape[-1]
    whole = float(np.linalg.norm(step)) * np.sqrt(points.shape[1])
    if n == 2:
        apart = points[..., 1] - points[..., 0]
        if all(halved) and np.linalg.norm(apart) < 0.6 * whole:
            # a third of a step lies between the means of two halves
            moved[..., 0], moved[..., 1] = points[..., 0] - apart, points[..., 1] + apart
        return moved
    for is_halved, end, near, far in zip(halved, (0, -1), (1, -2), (2, -3), strict=True):
        outer, inner = points[..., end] - points[..., near], points[..., near] - points[..., far]
        # of three points both neighbours may be halves
        length = whole if n == 3 and all(halved) else np.linalg.norm(inner)
        if is_halved and np.linalg.norm(outer) < 0.85 * length:
            moved[..., end] = points[..., near] + 1.5 * outer
    return moved


def _single_steps(result: Pictured, patch: Patch) -> tuple[Array, Array]:
    """Steps (3,) [m] along and across a patch, from one cell to the next were there any."""
    points = np.zeros((3, patch.ny, patch.nx))
    points[: len(result.points)] = patch.view(flat(result, result.points))
    normal = np.array([0.0, 0.0, 1.0])
    fields = result.fields()
    # rows that are inclined are drawn side by side in a plane
    if "normal" in fields and len(result.points) == 3:
        normal = patch.view(flat(result, fields["normal"].values)).reshape(3, -1).mean(axis=1)
    if patch.nx > 1:
        along = points[:, 0, 1] - points[:, 0, 0]
    elif patch.ny > 1:
        along = np.cross(points[:, 1, 0] - points[:, 0, 0], normal)
    else:
        along = np.array([1.0, 0.0, 0.0])
    across = np.cross(normal, along)
    dx, dy = patch.spacing
    return dx * along / np.linalg.norm(along), dy * across / np.linalg.norm(across)


def _halved(area: Array, cell: float) -> tuple[bool, bool]:
    """Whether the first and the last of a row of cells are halved, by their areas and that of a whole one."""
    if area.size == 1:
        return False, False
    if area.size == 2:
        both = bool(area.mean() < 0.75 * cell)
        return both, both
    return bool(area[0] < 0.75 * area[1]), bool(area[-1] < 0.75 * area[-2])


def quads(nx: int, ny: int) -> NDArray[np.int64]:
    """Corner numbers (ny * nx, 4) of the cells of one grid, counter-clockwise, x fastest."""
    corner = np.arange((ny + 1) * (nx + 1)).reshape(ny + 1, nx + 1)
    cells = [corner[:-1, :-1], corner[:-1, 1:], corner[1:, 1:], corner[1:, :-1]]
    return np.stack(cells, axis=-1).reshape(-1, 4)
