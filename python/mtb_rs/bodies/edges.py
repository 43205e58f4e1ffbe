# SPDX-License-Identifier: MIT OR Apache-2.0
"""Edges of triangulated faces: what they connect, how much they turn, and which of them are kinks."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Index = NDArray[np.int64]
Mask = NDArray[np.bool_]

#: Turn from which an edge may be a kink [rad]: over cells of some millimetres less rises by less than
#: contacts close.
LEAST_TURN = 2e-4
#: A kink turns this much more than the edges beside it; those of a curve's facets turn alike.
SHARPER = 3.0
#: Edges beside a kink are this far from it, in parts of its length; nearer ones are the kink's own.
BESIDE = 0.3
#: Cosine from which on two edges run alike.
ALIKE = 0.7


def shared_edges(triangles: Index) -> tuple[Index, Index]:
    """Pairs of triangles (e, 2) that share an edge, and its ends (e, 2)."""
    edges = np.sort(triangles[:, [[0, 1], [1, 2], [2, 0]]], axis=2).reshape(-1, 2)
    order = np.lexsort(edges.T)
    same = (edges[order[1:]] == edges[order[:-1]]).all(axis=1)
    pairs = np.stack([order[:-1][same] // 3, order[1:][same] // 3], axis=1)
    return pairs, edges[order[1:][same]]


def turns(nodes: Array, triangles: Index, pairs: Index, ends: Index) -> Array:
    """Angle (e,) [rad] between the normals on both sides of each edge, in its middle."""
    normals = []
    for side in (0, 1):
        own = triangles[pairs[:, side]]
        place = 0.5 * ((own[:, :3] == ends[:, :1]) | (own[:, :3] == ends[:, 1:]))
        slopes = np.array([[1.0, 0.0], [0.0, 1.0], [-1.0, -1.0]])
        shape = np.broadcast_to(slopes, (len(own), 3, 2))
        if own.shape[1] == 6:
            corner = (4.0 * place - 1.0)[:, :, None] * slopes
            i, j = np.array([0, 1, 2]), np.array([1, 2, 0])
            edge = 4.0 * (place[:, i, None] * slopes[j] + place[:, j, None] * slopes[i])
            shape = np.concatenate([corner, edge], axis=1)
        along = np.einsum("enx,ens->esx", nodes[own], shape)
        normal = np.cross(along[:, 0], along[:, 1])
        normals.append(normal / np.linalg.norm(normal, axis=1)[:, None])
    # by the sine: the cosine of small angles is lost in rounding
    return np.asarray(np.arcsin(np.clip(np.linalg.norm(np.cross(*normals), axis=1), 0.0, 1.0)))


def sharp_edges(nodes: Array, pairs: Index, ends: Index, turn: Array, count: int) -> Mask:
    """Which edges turn more than those beside them, as kinks do and facets of a curve do not."""
    of: list[list[int]] = [[] for _ in range(count)]
    for edge, pair in enumerate(pairs.tolist()):
        for triangle in pair:
            of[triangle].append(edge)
    middle = nodes[ends].mean(axis=1)
    along = nodes[ends[:, 1]] - nodes[ends[:, 0]]
    length = np.linalg.norm(along, axis=1)
    sharp = turn > LEAST_TURN
    for edge in np.flatnonzero(sharp).tolist():
        ring = set(pairs[edge].tolist())
        for _ in range(2):
            ring |= {t for triangle in ring for other in of[triangle] for t in pairs[other].tolist()}
        beside = np.array(sorted({other for triangle in ring for other in of[triangle]}))
        away = middle[beside] - middle[edge]
        off = np.linalg.norm(np.cross(away, along[edge] / length[edge]), axis=1)
        # facets of a curve turn about like axes, another kink may cross this one
        cosine = along[beside] @ along[edge] / (length[beside] * length[edge])
        others = turn[beside[(off > BESIDE * length[edge]) & (np.abs(cosine) > ALIKE)]]
        sharp[edge] = turn[edge] > SHARPER * others.max(initial=0.0)
    return sharp


def connected(pairs: Index, count: int) -> Index:
    """Label (count,) of the piece each triangle belongs to, of those that `pairs` (e, 2) connect."""
    label = np.arange(count)
    while True:
        least = label[pairs].min(axis=1) if len(pairs) else label[:0]
        new = label.copy()
        np.minimum.at(new, pairs[:, 0], least)
        np.minimum.at(new, pairs[:, 1], least)
        new = new[new]
        if (new == label).all():
            return np.unique(label, return_inverse=True)[1].reshape(-1)
        label = new
