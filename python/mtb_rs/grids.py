# SPDX-License-Identifier: MIT OR Apache-2.0
"""The regular grids inside a result, as pictures and files need them: cells and their corners."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from .result import Array, Patch, Pictured


def flat(result: Pictured, values: NDArray[Any]) -> NDArray[Any]:
    """A field of `result`, (..., ny, nx) or (..., n), with its points in one row: (..., n)."""
    lead = values.ndim - result.pressure.ndim
    return values.reshape(*values.shape[:lead], -1)


def patches(result: Pictured) -> tuple[Patch, ...]:
    """The regular grids of a result, for use with :func:`flat`; none where the points are scattered."""
    if result.pressure.ndim == 2:
        ny, nx = result.pressure.shape
        return (Patch("contact", 0, nx, ny),)
    return tuple(getattr(result, "patches", ()))


def borders(centres: Array, halved: tuple[bool, bool] = (False, False)) -> Array:
    """Cell borders (..., n + 1) along the last axis, from the points (..., n) of the cells.

    Inside, a border is the mean of its two points. The ends are extrapolated linearly, so that a uniform
    grid gives back its own cells; where the first or last cell is `halved`, its point is the end itself.
    """
    if centres.shape[-1] < 2:
        raise ValueError("a single row or column of cells has no borders: at least 2 x 2 cells are needed")
    first, last = (0.0 if half else 0.5 for half in halved)
    start = centres[..., :1] - first * (centres[..., 1:2] - centres[..., :1])
    end = centres[..., -1:] + last * (centres[..., -1:] - centres[..., -2:-1])
    return np.concatenate([start, 0.5 * (centres[..., 1:] + centres[..., :-1]), end], axis=-1)


def corners(result: Pictured, patch: Patch, values: Array) -> Array:
    """Corners (..., ny + 1, nx + 1) of the cells of `patch`, from `values` (..., n) at all points.

    Points may be the centres of cells, or nodes whose border cells are halved by the edge of the body:
    their areas tell.
    """
    area = patch.view(flat(result, result.area))
    columns, rows = area.mean(axis=0), area.mean(axis=1)
    inside = borders(patch.view(values), _halved(columns))
    return np.swapaxes(borders(np.swapaxes(inside, -1, -2), _halved(rows)), -1, -2)


def row_borders(result: Pictured, patch: Patch, values: Array) -> Array:
    """Borders along x (ny, nx + 1) of the cells in each row of `patch`, from `values` (n,) at all points."""
    columns = patch.view(flat(result, result.area)).mean(axis=0)
    return borders(patch.view(values), _halved(columns))


def _halved(area: Array) -> tuple[bool, bool]:
    return bool(area[0] < 0.75 * area[1]), bool(area[-1] < 0.75 * area[-2])


def quads(nx: int, ny: int) -> NDArray[np.int64]:
    """Corner numbers (ny * nx, 4) of the cells of one grid, counter-clockwise, x fastest."""
    corner = np.arange((ny + 1) * (nx + 1)).reshape(ny + 1, nx + 1)
    cells = [corner[:-1, :-1], corner[:-1, 1:], corner[1:, 1:], corner[1:, :-1]]
    return np.stack(cells, axis=-1).reshape(-1, 4)
