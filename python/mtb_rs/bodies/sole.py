# SPDX-License-Identifier: MIT OR Apache-2.0
"""The underside of a body: which of its triangles "bottom" means, and "top" of a body upside down."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from .edges import connected, shared_edges, sharp_edges, turns

Array = NDArray[np.float64]
Index = NDArray[np.int64]
Mask = NDArray[np.bool_]

#: Slope up to which a face looks down: chamfers are mostly of 45 degrees.
STEEPEST = np.radians(40.0)
#: Turns at an edge: up to the first faces go on whatever lies beside, as a sole that is worn in does at its
#: unworn strips, and from the second on none does; between them facets of a curve do, chamfers do not.
SMOOTH, EDGE = np.radians(8.0), np.radians(30.0)
#: Share of the size of a body within which points are at one height: single precision, as STL files have it.
LEVEL = 1e-6
#: Share of the faces at the lowest height from which on they are the sole, and what is curved is its border.
MOSTLY_FLAT = 0.5


def underside(nodes: Array, faces: Index) -> Mask:
    """Which triangles (f, 3) or (f, 6) of a boundary are its underside.

    The triangles at the lowest height; and those that continue them, or the lowest point, without an edge,
    wherever these look down: all of a sole that is curved, but no chamfers. Of a sole that is mostly flat
    only what lies between its flat parts is added, so that its rounded edges are none of it. Parts of a sole
    beside each other, as slots make them, belong to it where they reach down to the height of the others.

    Parameters
    ----------
    nodes : (n, 3) [m]
    faces
        Counter-clockwise seen from outside.
    """
    corners = nodes[faces[:, :3]]
    double = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    size = np.linalg.norm(double, axis=1)
    # of corners: the middles of curved edges may lie lower, but no triangle ends there
    lowest = float(corners[:, :, 2].min())
    near = LEVEL * float(np.ptp(corners, axis=(0, 1)).max())
    flat: Mask = np.all(corners[:, :, 2] <= lowest + near, axis=1)
    down = np.flatnonzero(flat | (-double[:, 2] > np.cos(STEEPEST) * size))
    if not down.size:
        return flat
    own, area, z = faces[down], 0.5 * np.abs(double[down, 2]), corners[down, :, 2]
    pairs, ends = shared_edges(own)
    turn = turns(nodes, own, pairs, ends)
    goes_on = turn <= SMOOTH
    doubtful = ~goes_on & (turn < EDGE)
    if doubtful.any():
        goes_on |= doubtful & ~sharp_edges(nodes, pairs, ends, turn, len(own))
    piece = connected(pairs[goes_on], len(own))
    chosen = _pieces(piece, pairs, area, z, corners[down, :, :2], lowest, near)
    is_flat = flat[down] & chosen
    if area[is_flat].sum() >= MOSTLY_FLAT * area[chosen].sum():
        chosen = is_flat | (chosen & _between(corners[down, :, :2], is_flat))
    found = np.zeros(len(faces), dtype=bool)
    found[down[chosen]] = True
    return found


def _pieces(
    piece: Index, pairs: Index, area: Array, z: Array, places: Array, lowest: float, near: float
) -> Mask:
    """Triangles of the largest piece at the lowest height, and of those beside it that reach down to its."""
    count = int(piece.max()) + 1
    least, most = np.full(count, np.inf), np.full(count, -np.inf)
    np.minimum.at(least, piece, z.min(axis=1))
    np.maximum.at(most, piece, z.max(axis=1))
    total = np.bincount(piece, area, count)
    order = np.argsort(-total, kind="stable")
    touching = {k: set[int]() for k in range(count)}
    for one, other in piece[pairs].tolist():
        if one != other:
            touching[one].add(other)
            touching[other].add(one)
    # a body on a tip has no face there: then the piece that reaches down the farthest
    first = int(next(k for k in order if least[k] <= max(lowest, least.min()) + near))
    taken, highest = {first}, most[first]
    while True:
        new = next(
            (
                int(k)
                for k in order
                if k not in taken
                and least[k] <= highest + near
                and not touching[int(k)] & taken
                and not _hidden(places[piece == k], places[np.isin(piece, list(taken))])
            ),
            None,
        )
        if new is None:
            return np.isin(piece, list(taken))
        taken.add(new)
        highest = max(highest, most[new])


def _hidden(places: Array, others: Array) -> bool:
    """Whether triangles (f, 3, 2) lie behind others, seen along z, by the middles of some."""
    middles = places[:: max(1, len(places) // 50)].mean(axis=1)
    for middle in middles:
        a, b, c = (others[:, k] - middle for k in range(3))
        turned = [p[:, 0] * q[:, 1] - p[:, 1] * q[:, 0] for p, q in ((a, b), (b, c), (c, a))]
        if (np.all(np.array(turned) > 0.0, axis=0) | np.all(np.array(turned) < 0.0, axis=0)).any():
            return True
    return False


def _between(places: Array, flat: Mask) -> Mask:
    """Which triangles (f, 3, 2) lie within the convex hull of the flat ones, seen along z."""
    points = np.unique(places[flat].reshape(-1, 2), axis=0)
    near = LEVEL * float(np.ptp(places, axis=(0, 1)).max())
    inside = np.ones(places.shape[:2], dtype=bool)
    # the hull from its leftmost point to its rightmost one below, and back above
    for row in (points, points[::-1]):
        chain: list[Array] = []
        for point in row:
            while len(chain) > 1 and _left_of(chain[-2], chain[-1], point) <= 0.0:
                chain.pop()
            chain.append(point)
        for start, end in pairwise(chain):
            inside &= _left_of(start, end, places) >= -near * float(np.linalg.norm(end - start))
    return np.asarray(inside.all(axis=1))


def _left_of(start: Array, end: Array, places: Array) -> Array:
    """Twice the area (...) of the triangles from an edge to places (..., 2), positive on its left."""
    along, to = end - start, places - start
    return np.asarray(along[0] * to[..., 1] - along[1] * to[..., 0])
