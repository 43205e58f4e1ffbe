# SPDX-License-Identifier: MIT OR Apache-2.0
"""Contact faces and their parts: where a face ends or has a kink, hats end as well.

One side of a kink is a part of its own. A contact point is a node of the grid on the face, and carries
what its neighbours on another part would carry of its own. The hat of a node beside the face presses where
the rest of it lies.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .. import _mtb_rs
from ..geometry.profiles import Profile
from .edges import LEAST_TURN, SHARPER, connected, shared_edges, sharp_edges, turns
from .elastic_body import ElasticBody

Array = NDArray[np.float64]


Index = NDArray[np.int64]
Mask = NDArray[np.bool_]

#: Value of a hat from which a quadrature point is one of the four nearest to its node.
NEAREST = 0.8
#: Cells from the middle of a hat up to which a quadrature point tells that the face is there.
NEAR = 0.15
#: Cells up to which a point on the face takes what its neighbours have beside it.
REACH = 2


@dataclass(frozen=True)
class Hats:
    """The basis of a contact: hats on the parts of a face, given to the points that lie on them.

    Attributes
    ----------
    kept : (n,) int
        Contact points as nodes of the grid.
    place : (2, n)
        Where they are, in columns and rows of the grid: the node, or the middle of what is left of its hat.
    on : (n,) int
        Part of the face that each of them is on.
    shares : tuple of (p,)
        Part of the face, node, contact point and factor of each hat.
    start, point, value
        Contact points and values at each quadrature point, as in a sampling.
    part : (q,) int
        Part of the face at each quadrature point.
    """

    kept: NDArray[np.intp]
    place: Array
    on: Index
    shares: tuple[Index, Index, Index, Array]
    start: Index
    point: Index
    value: Array
    part: Index

    def of(self, sampling: _mtb_rs.Sampling) -> _mtb_rs.Sampling:
        """The same quadrature with this basis."""
        arrays = sampling.arrays()
        return _mtb_rs.Sampling(
            self.kept.size,
            arrays["face"],
            arrays["barycentric"],
            arrays["weight"],
            arrays["frame"],
            self.start.astype(np.uintp),
            self.point.astype(np.uintp),
            self.value,
        )

    def half_space(
        self,
        sampling: _mtb_rs.Sampling,
        shear_modulus: float,
        poisson_ratio: float,
        patch: tuple[float, float, int, int],
        spacing: tuple[float, float],
    ) -> _mtb_rs.Compliance:
        """A half-space under this basis; `sampling` is that of all nodes."""
        parts = [thinned(sampling, self.part == k) for k in range(int(self.part.max()) + 1)]
        shares = list(zip(*(column.tolist() for column in self.shares), strict=True))
        return _mtb_rs.half_space_cut_hats(
            shear_modulus, poisson_ratio, patch, spacing, parts, shares, self.kept.size
        )


def hats(sampling: _mtb_rs.Sampling, part: Index, apart: Array, shape: tuple[int, int], least: float) -> Hats:
    """Contact points on the parts of a face.

    Parameters
    ----------
    sampling : Sampling
        The basis of all nodes of a grid.
    part : (q,) int
        Part of the face at each quadrature point, counted from 0.
    apart : (q,) [m]
        Gap there: a node on a kink belongs to the part that is nearer to the opponent.
    shape : (ny, nx)
        Nodes of the grid.
    least : float [m2]
        Points of less area are left out.
    """
    arrays = sampling.arrays()
    owner, node, value = owners(arrays), arrays["point"].astype(np.int64), arrays["value"]
    count, nodes = int(part.max(initial=0)) + 1, shape[0] * shape[1]
    pair = node * count + part[owner]

    def summed(what: Array) -> Array:
        return np.asarray(np.bincount(pair, what, nodes * count).reshape(nodes, count), dtype=float)

    weighted = value * arrays["weight"][owner]
    area = summed(weighted)
    near = summed((value > NEAREST).astype(float))
    owned = _owned(near, area, summed(weighted * apart[owner]))
    beside = near.max(axis=1) == 0.0
    # where in the grid the quadrature points lie, and the middles of the hats
    grid = np.stack([node % shape[1], node // shape[1]])
    at = np.array([np.bincount(owner, value * g, part.size) for g in grid])
    middle = np.array([summed(weighted * a[owner]) for a in at]) / np.where(area > 0.0, area, 1.0)
    off = np.abs(at[:, owner] - middle.reshape(2, -1)[:, pair]).max(axis=0)
    on_face = summed((off < NEAR).astype(float)) > 0.0
    largest = area == area.max(axis=1, keepdims=True)
    owned |= beside[:, None] & largest & (area > least) & on_face
    source, target, factor = _targets(owned, area > 0.0, shape)
    carried = np.bincount(target, factor * area.ravel()[source], nodes)
    kept = np.flatnonzero(carried > least)
    alone = middle[:, np.arange(nodes), area.argmax(axis=1)]
    place = np.where(beside, alone, np.stack([np.arange(nodes) % shape[1], np.arange(nodes) // shape[1]]))
    number = np.full(nodes, -1, dtype=np.int64)
    number[kept] = np.arange(kept.size)
    there = number[target] >= 0
    source, point, factor = source[there], number[target[there]], factor[there]
    order = np.argsort(source, kind="stable")
    source, point, factor = source[order], point[order], factor[order]
    # the points that take each basis value, one after the other
    times = np.bincount(source, minlength=nodes * count)
    first = np.concatenate([[0], np.cumsum(times)[:-1]])
    entry = np.repeat(np.arange(pair.size), times[pair])
    step = np.arange(entry.size) - np.repeat(np.cumsum(times[pair]) - times[pair], times[pair])
    taker = first[pair[entry]] + step
    return Hats(
        kept=kept,
        place=np.ascontiguousarray(place[:, kept]),
        on=np.where(owned, area, -1.0).argmax(axis=1)[kept],
        shares=(source % count, source // count, point, factor),
        start=np.concatenate([[0], np.cumsum(np.bincount(owner[entry], minlength=part.size))]),
        point=point[taker],
        value=value[entry] * factor[taker],
        part=part,
    )


def _owned(near: Array, area: Array, moment: Array) -> Mask:
    """Which parts (nodes, parts) a node lies on: one, or several alike of which it is a corner."""
    most = near.max(axis=1, keepdims=True)
    on = (near == most) & (near > 0.0)
    gap = np.where(on, moment / np.where(area > 0.0, area, 1.0), np.inf)
    least = gap.min(axis=1, keepdims=True)
    return np.asarray(on & (gap <= least + 1e-9 * np.abs(gap[on]).max(initial=0.0)))


def _targets(owned: Mask, there: Mask, shape: tuple[int, int]) -> tuple[Index, Index, Array]:
    """Which node takes each hat on each part: pair of node and part, taker and its share."""
    ny, nx = shape
    count = owned.shape[1]
    node, part = np.nonzero(there)
    own = owned[node, part]
    found = [(node[own] * count + part[own], node[own], np.ones(int(own.sum())))]
    node, part = node[~own], part[~own]
    steps = [(i, j) for j in range(-REACH, REACH + 1) for i in range(-REACH, REACH + 1) if i or j]
    for distance in sorted({i * i + j * j for i, j in steps}):
        takers = []
        for i, j in steps:
            if i * i + j * j != distance:
                continue
            x, y = node % nx + i, node // nx + j
            inside = (x >= 0) & (x < nx) & (y >= 0) & (y < ny)
            other = np.where(inside, y * nx + x, 0)
            takers.append(np.where(inside & owned[other, part], other, -1))
        taken = np.array(takers)
        times = (taken >= 0).sum(axis=0)
        which, k = np.nonzero(taken >= 0)
        found.append((node[k] * count + part[k], taken[which, k], 1.0 / times[k]))
        node, part = node[times == 0], part[times == 0]
    # a part so narrow that no node is on it: its hats stay
    found.append((node * count + part, node, np.ones(node.size)))
    source, target, factor = (np.concatenate(column) for column in zip(*found, strict=True))
    return source, target, factor


def owners(arrays: Mapping[str, NDArray[Any]]) -> NDArray[np.int64]:
    """The quadrature point of each basis value."""
    start = arrays["start"].astype(np.int64)
    counts = start[1:] - start[:-1]
    return np.repeat(np.arange(counts.size), counts)


def thinned(whole: _mtb_rs.Sampling, share: NDArray[Any]) -> _mtb_rs.Sampling:
    """The basis at some of its quadrature points: those that keep a `share` (q,) of their weights."""
    arrays = whole.arrays()
    covered = share > 0
    start = arrays["start"].astype(np.int64)
    there = np.repeat(covered, np.diff(start))
    return _mtb_rs.Sampling(
        whole.n_points,
        arrays["face"][covered],
        arrays["barycentric"][covered],
        arrays["weight"][covered] * share[covered],
        arrays["frame"][covered],
        np.concatenate([[0], np.cumsum(np.diff(start)[covered])]).astype(np.uintp),
        arrays["point"][there],
        arrays["value"][there],
    )


def joined(labels: Sequence[Index]) -> Index:
    """Parts that differ in any of several ways, counted from 0."""
    out = labels[0]
    for other in labels[1:]:
        out = out * (int(other.max(initial=0)) + 1) + other
    return np.unique(out, return_inverse=True)[1].reshape(-1)


def parts(body: ElasticBody) -> Index:
    """Part (f,) of each triangle of a contact face; kinks that run through the face divide it."""
    triangles = body.faces[body.contact_faces].astype(np.int64)
    pairs, ends = shared_edges(triangles)
    if not len(pairs):
        return np.zeros(len(triangles), dtype=np.int64)
    turn = turns(body.mesh.nodes, triangles, pairs, ends)
    smooth = ~sharp_edges(body.mesh.nodes, pairs, ends, turn, len(triangles))
    return connected(pairs[smooth], len(triangles))


def profile_parts(profile: Profile, y: Array) -> Index:
    """Part of a profile at each `y` [m]: between kinks that are sharper than those beside them."""
    breaks = profile.breaks[1:-1]
    start, end = profile.range
    step = 1e-9 * (end - start)
    turn = np.abs(profile.slope(breaks + step) - profile.slope(breaks - step))
    beside = np.maximum(np.concatenate([[0.0], turn[:-1]]), np.concatenate([turn[1:], [0.0]]))
    sharp = (turn > LEAST_TURN) & (turn > SHARPER * beside)
    return np.searchsorted(breaks[sharp], y).astype(np.int64)
