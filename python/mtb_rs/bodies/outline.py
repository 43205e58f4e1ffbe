# SPDX-License-Identifier: MIT OR Apache-2.0
"""How much of each cell of a grid a face covers, seen along z, by its outline.

Quadrature points tell whether they lie on a face, and so its area in a cell to some percent where its outline
runs through. The area between an outline and the cells is that of polygons, exactly.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Index = NDArray[np.int64]

#: Straight pieces of a curved edge: between them and the curve lies a part in PIECES^2 of its segment.
PIECES = 16
#: Share of a cell by which counted and exact areas may differ by rounding.
ROUNDING = 1e-9
#: Least share of what the points of a cell stand for that is left to them.
LEAST = 0.05


def outline(nodes: Array, faces: Index, *, upward: bool) -> Array:
    """Border (k, 2, 2) of triangles (f, 3) or (f, 6) that look up or down, seen along z.

    Straight pieces from their first to their second ends, with the face on their left; and the area on their
    left is the face's, holes left out.
    """
    corners = nodes[faces[:, :3], :2]
    one, other = (corners[:, k] - corners[:, 0] for k in (1, 2))
    double = one[:, 0] * other[:, 1] - other[:, 0] * one[:, 1]
    faces = faces[double > 0.0] if upward else faces[double < 0.0]
    edges = faces[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2)
    ranked = np.sort(edges, axis=1)
    _, inverse, times = np.unique(ranked, axis=0, return_inverse=True, return_counts=True)
    alone = times[inverse.reshape(-1)] == 1
    start, end = nodes[edges[alone, 0], :2], nodes[edges[alone, 1], :2]
    middle = 0.5 * (start + end)
    if faces.shape[1] == 6:
        middle = nodes[faces[:, 3:].reshape(-1)[alone], :2]
    bulge = np.linalg.norm(middle - 0.5 * (start + end), axis=1)
    is_curved = bulge > ROUNDING * np.linalg.norm(end - start, axis=1)
    straight = np.stack([start, end], axis=1)[~is_curved]
    start, middle, end = start[is_curved], middle[is_curved], end[is_curved]
    at = np.linspace(0.0, 1.0, PIECES + 1)[:, None, None]
    places = (1 - at) * (1 - 2 * at) * start + at * (2 * at - 1) * end + 4 * at * (1 - at) * middle
    curved = np.stack([places[:-1], places[1:]], axis=2).reshape(-1, 2, 2)
    pieces = np.concatenate([straight, curved])
    return pieces if upward else pieces[:, ::-1]


def covered(pieces: Array, x: Array, y: Array) -> Array:
    """Share (rows, columns) of each cell between `x` (columns + 1,) and `y` (rows + 1,) that lies on a face.

    Each piece of the outline takes away the area on its right, row by row.

    Parameters
    ----------
    pieces : (k, 2, 2)
        See :func:`outline`.
    """
    ends = [(pieces[:, :, k] - a[0]) / (a[-1] - a[0]) * (a.size - 1) for k, a in enumerate((x, y))]
    columns, rows = x.size - 1, y.size - 1
    own, beyond = np.zeros((rows, columns)), np.zeros((rows, columns + 1))
    for (x0, x1), (y0, y1) in zip(ends[0].tolist(), ends[1].tolist(), strict=True):
        if y0 == y1:
            continue
        cuts = [0.0, 1.0]
        for first, last, count in ((x0, x1, columns), (y0, y1, rows)):
            low, high = min(first, last), max(first, last)
            lines = np.arange(max(0, int(np.ceil(low))), min(count, int(np.floor(high))) + 1)
            if last != first:
                cuts.extend(((lines - first) / (last - first)).tolist())
        at = np.clip(np.unique(cuts), 0.0, 1.0)
        middle = 0.5 * (at[1:] + at[:-1])
        rise = (y1 - y0) * np.diff(at)
        across, up = x0 + (x1 - x0) * middle, y0 + (y1 - y0) * middle
        row = np.floor(up).astype(np.int64)
        inside = (row >= 0) & (row < rows) & (across > 0.0)
        row, across, rise = row[inside], across[inside], rise[inside]
        column = np.minimum(np.floor(across).astype(np.int64), columns)
        there = column < columns
        np.add.at(own, (row[there], column[there]), rise[there] * (across - column)[there])
        np.add.at(beyond, (row, column), rise)
    # a piece covers all cells on its left
    whole = beyond[:, ::-1].cumsum(axis=1)[:, ::-1][:, 1:]
    return np.asarray(np.clip(own + whole, 0.0, 1.0))


def area(pieces: Array) -> float:
    """Area [m2] on the left of an outline."""
    start, end = pieces[:, 0], pieces[:, 1]
    return float(0.5 * (start[:, 0] * end[:, 1] - end[:, 0] * start[:, 1]).sum())


def strip(start: float, end: float, y: Array) -> Array:
    """Share (rows,) of each row between `y` (rows + 1,) that lies between `start` and `end`."""
    return np.asarray(np.clip(np.minimum(y[1:], end) - np.maximum(y[:-1], start), 0.0, None) / np.diff(y))


def corrected(exact: Array, counted: Array) -> Array:
    """Factors (rows, columns) on the weights of the points in each cell that make their areas exact.

    Cells that are covered so little that no point of theirs is on the face give their share to the fullest
    cell beside them.

    Parameters
    ----------
    exact, counted : (rows, columns)
        Covered share of each cell, and that which its points stand for.
    """
    wanted = np.where(counted > 0.0, np.maximum(exact, LEAST * counted), 0.0)
    for row, column in np.argwhere((counted <= 0.0) & (exact > ROUNDING)).tolist():
        around = slice(max(row - 1, 0), row + 2), slice(max(column - 1, 0), column + 2)
        near = counted[around]
        if near.any():
            i, j = np.unravel_index(int(near.argmax()), near.shape)
            wanted[around][i, j] += exact[row, column]
    factor = np.ones_like(exact)
    off = (counted > 0.0) & (np.abs(wanted - counted) > ROUNDING)
    factor[off] = wanted[off] / counted[off]
    return factor
