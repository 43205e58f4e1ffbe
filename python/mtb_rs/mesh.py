# SPDX-License-Identifier: MIT OR Apache-2.0
"""Tetrahedral meshes: built-in bodies by extrusion, closed surfaces through gmsh, files through meshio.

Built-in bodies are grids of hexahedra, each cut into six tetrahedra, symmetric where the body is: turning
the sliding direction round turns the solution round. Their contact face follows the contact grid it is
given. Lengths in metres, z up.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _mtb_rs
from .check import choice, positive
from .geometry import PoleShoe, Profile
from .owning import owning
from .plain import plain
from .words import Side

Array = NDArray[np.float64]
Index = NDArray[np.int64]

#: Of a body `ACROSS` elements wide, a rail `ACROSS_RAIL`: growth of a layer over the one before it, away from
#: the contact, and the thickest layer in widths. Finer elements have thinner layers everywhere.
GROWTH, THICKEST, ACROSS, ACROSS_RAIL = 1.7, 0.3, 10.0, 20.0

#: Elements over the height of web and foot of a rail and over half of its foot's width, as above.
FAR_LAYERS = (5, 3, 6)

#: Unknown displacements that no factorisation within the limits of the compiled core holds (8 GB).
MOST_UNKNOWNS = 4e6

#: Ends of the edges that carry the mid-side nodes 4 to 9.
EDGES = ((0, 1), (1, 2), (0, 2), (0, 3), (1, 3), (2, 3))


@owning
@dataclass(frozen=True)
@plain
class TetraMesh:
    """Tetrahedra with named sets of nodes.

    Attributes
    ----------
    nodes : (n, 3) [m]
        A row a node, as in meshio, trimesh and VTK; arrays of points elsewhere are (3, n).
    cells : (m, 4) or (m, 10)
        Node numbers: corners, then the middles of edges 01, 12, 02, 03, 13, 23.
    node_sets : Mapping of names to (k,)
        For contact faces and supports.
    """

    nodes: Array
    cells: Index
    node_sets: Mapping[str, Index] = field(default_factory=dict)

    @property
    def is_quadratic(self) -> bool:
        """Whether the tetrahedra have 10 nodes."""
        return bool(self.cells.shape[1] == 10)

    def moved(
        self, rotation: ArrayLike = ((1, 0, 0), (0, 1, 0), (0, 0, 1)), shift: ArrayLike = (0, 0, 0)
    ) -> TetraMesh:
        """The mesh rotated by a matrix (3, 3) and then shifted by a vector (3,) [m]."""
        nodes = self.nodes @ np.asarray(rotation, dtype=float).T + np.asarray(shift, dtype=float)
        return TetraMesh(nodes, self.cells, self.node_sets)

    def mirrored(self) -> TetraMesh:
        """The mesh seen in the mirror y = 0, its tetrahedra turned right side out again."""
        order = [1, 0, 2, 3, 4, 6, 5, 8, 7, 9][: self.cells.shape[1]]
        return TetraMesh(self.nodes * [1.0, -1.0, 1.0], self.cells[:, order], self.node_sets)

    def checked(self) -> _mtb_rs.TetraMesh:
        """The mesh in the compiled core, which checks it.

        Raises
        ------
        ValueError
            On indices out of range, inverted or flat tetrahedra, loose nodes, several pieces, tetrahedra that
            are there twice or share a face with two others.
        """
        cells = np.asarray(self.cells)
        if cells.ndim != 2 or np.asarray(self.nodes).ndim != 2:
            raise ValueError(
                f"nodes and cells have shapes {np.shape(self.nodes)} and {cells.shape}: (n, 3) and (m, 4) or "
                "(m, 10) are needed"
            )
        if cells.size and cells.min() < 0:
            raise ValueError(f"cells contain the node number {cells.min()}: numbers start at 0")
        mesh = _mtb_rs.TetraMesh(
            np.ascontiguousarray(self.nodes, dtype=np.float64), np.ascontiguousarray(cells, dtype=np.uintp)
        )
        _check_owners(cells[:, :4])
        return mesh


def quadratic(mesh: TetraMesh) -> TetraMesh:
    """Linear tetrahedra with nodes in the middle of their straight edges, numbered behind the others.

    A set of nodes gets those between two of its own, on the boundary or in a tetrahedron that is all in it.
    """
    pairs = np.sort(mesh.cells[:, np.array(EDGES)], axis=2)
    edges, which = np.unique(pairs.reshape(-1, 2), axis=0, return_inverse=True)
    which = which.reshape(-1, len(EDGES))
    n = len(mesh.nodes)
    faces, counts = np.unique(
        np.sort(mesh.cells[:, [[0, 1, 2], [0, 1, 3], [0, 2, 3], [1, 2, 3]]], axis=2).reshape(-1, 3),
        axis=0,
        return_counts=True,
    )
    outside = faces[counts == 1][:, [[0, 1], [0, 2], [1, 2]]].reshape(-1, 2)
    on_boundary = np.isin(edges @ [n, 1], outside @ [n, 1])
    sets = {}
    for name, own in mesh.node_sets.items():
        inside = np.zeros(n, dtype=bool)
        inside[own] = True
        solid = np.zeros(len(edges), dtype=bool)
        solid[which[inside[mesh.cells].all(axis=1)]] = True
        between = np.flatnonzero(inside[edges].all(axis=1) & (on_boundary | solid))
        sets[name] = np.concatenate([np.asarray(own, dtype=np.int64), n + between])
    middles = mesh.nodes[edges].mean(axis=1)
    cells = np.concatenate([mesh.cells, n + which], axis=1).astype(np.int64)
    return TetraMesh(np.concatenate([mesh.nodes, middles]), cells, sets)


def check_unknowns(tetrahedra: float, *, quadratic: bool = True) -> None:
    """Refuses a mesh before it is made, where factorising it will be refused.

    Raises
    ------
    ValueError
    """
    # four unknowns a tetrahedron of 10 nodes, half an unknown one of 4
    unknowns = tetrahedra * (4.0 if quadratic else 0.5)
    if unknowns > MOST_UNKNOWNS:
        raise ValueError(
            f"the mesh would have about {tetrahedra:.2g} tetrahedra with {unknowns:.2g} unknowns, more than "
            f"{MOST_UNKNOWNS:g}: larger elements are needed (element_size, size or spacing)"
        )


def _check_owners(corners: Index) -> None:
    """A face belongs to one tetrahedron or two; more overlap."""
    sides = ((0, 1, 2), (0, 1, 3), (0, 2, 3), (1, 2, 3))
    faces = np.sort(np.concatenate([corners[:, side] for side in sides]), axis=1)
    order = np.lexsort(faces.T)
    ranked = faces[order]
    third = np.flatnonzero((ranked[2:] == ranked[:-2]).all(axis=1))
    if not third.size:
        return
    k = third[0]
    owners = np.sort(order[k : k + 3] % len(corners))
    points = np.sort(corners[owners], axis=1)
    for a, b in ((0, 1), (1, 2), (0, 2)):
        if (points[a] == points[b]).all():
            raise ValueError(
                f"tetrahedron {owners[b]} has the corners {points[b].tolist()} of tetrahedron {owners[a]}: "
                "each must be there once"
            )
    raise ValueError(
        f"the tetrahedra {owners[0]}, {owners[1]} and {owners[2]} share the face {ranked[k].tolist()}: "
        "a face belongs to one or two"
    )


def layers(first: float, length: float, width: float, *, across: float = ACROSS, least: int = 2) -> Array:
    """Places from 0 to `length` [m] of layers of elements, away from the contact of a body `width` [m] wide.

    The first one is about `first` [m] thick. They grow with the distance, as what is local to the contact
    fades, up to a share of the width: bending does not fade. Growth beyond 1 and thickest layer shrink with
    the root of `first`: so each refinement refines all of the body, and an estimate made of two solutions
    sees the errors of all of its layers.
    """
    coarse = coarseness(first, width, across)
    growth = 1.0 + (GROWTH - 1.0) * coarse
    thickest = max(first, THICKEST * width * coarse)
    # thickness first + (growth - 1) z: up to the thickest, `graded` layers
    graded = float(np.log(thickest / first) / np.log(growth))
    end = (thickest - first) / (growth - 1.0)
    if length <= end:
        count = float(np.log1p((growth - 1.0) * length / first) / np.log(growth))
    else:
        count = graded + (length - end) / thickest
    at = np.linspace(0.0, count, max(least, round(count)) + 1)
    near = first * (growth ** np.minimum(at, graded) - 1.0) / (growth - 1.0)
    places = near + thickest * np.maximum(at - graded, 0.0)
    return np.asarray(places * (length / places[-1]))


def coarseness(first: float, width: float, across: float) -> float:
    """How much thicker than those of a body `across` elements wide its layers far from the contact are."""
    return float(np.sqrt(across * first / width))


def _heights(first: float, height: float, width: float, halved: bool, clamped: bool) -> Array:
    """Layers of a body from its contact to its top; see :func:`block_mesh`."""
    if not halved:
        places = layers(first, height, width)
        return np.insert(places, -1, (places[-2] + 2.0 * places[-1]) / 3.0) if clamped else places
    low = layers(first, 0.5 * height, width)
    high = layers(float(low[-1] - low[-2]), 0.5 * height, width)
    return np.concatenate([low, 0.5 * height + high[1:]])


def tetrahedra(
    corners: Array,
    keep: NDArray[np.bool_] | None = None,
    curved: tuple[tuple[Any, Any, Any], Array] | None = None,
    *,
    flipped: tuple[ArrayLike, ArrayLike] = (False, False),
    quadratic: bool = True,
) -> tuple[Array, Index, Index]:
    """Tetrahedra of a curvilinear grid of hexahedra.

    Parameters
    ----------
    corners : (nx, ny, nz, 3) [m]
        Right-handed.
    keep : (nx - 1, ny - 1, nz - 1)
        Hexahedra that exist; all by default.
    curved : indices into the doubled grid, and positions (..., 3) [m]
        Where nodes, mid-side ones included, have true places; elsewhere they lie on straight edges.
    flipped : (nx - 1,) and (ny - 1,) bool
        Columns and rows whose hexahedra are cut as seen in a mirror along x and along y. With one half
        flipped the mesh of a symmetric grid is symmetric.

    Returns
    -------
    nodes : (n, 3)
    cells : (m, 10) or (m, 4)
    number : (2 nx - 1, 2 ny - 1, 2 nz - 1)
        Node number at each place of the doubled grid, -1 where there is none.
    """
    nx, ny, nz = corners.shape[:3]
    flips = [np.broadcast_to(f, n - 1).astype(np.int64) for f, n in zip(flipped, (nx, ny), strict=True)]
    flips.append(np.zeros(nz - 1, dtype=np.int64))
    fine = np.empty((2 * nx - 1, 2 * ny - 1, 2 * nz - 1, 3))
    fine[::2, ::2, ::2] = corners
    for odd in np.ndindex(2, 2, 2):
        # every middle belongs to one edge of the six tetrahedra: from the first corner towards the last
        ends = []
        for turn in (0, 1):
            axes = zip(flips, odd, strict=True)
            i, j, k = [np.arange(f.size) + (f ^ turn) if o else np.arange(f.size + 1) for f, o in axes]
            ends.append(corners[np.ix_(i, j, k)])
        fine[odd[0] :: 2, odd[1] :: 2, odd[2] :: 2] = 0.5 * (ends[0] + ends[1])
    if curved is not None:
        fine[curved[0]] = curved[1]
    hexes = np.ones((nx - 1, ny - 1, nz - 1), dtype=bool) if keep is None else keep
    places = np.nonzero(hexes)
    flip = [f[place] for f, place in zip(flips, places, strict=True)]
    mirrored = (flip[0] + flip[1]) % 2 == 1
    shape = fine.shape[:3]
    tets = []
    for p, q, even in ((0, 1, 1), (1, 2, 1), (2, 0, 1), (1, 0, 0), (2, 1, 0), (0, 2, 0)):
        steps = np.zeros((4, 3), dtype=np.int64)
        steps[1:, p] = 2
        steps[2:, q] = 2
        steps[3] = 2
        if not even:
            steps[[1, 2]] = steps[[2, 1]]
        found = []
        for turned in (steps, steps[[1, 0, 2, 3]]):
            # a mirror turns tetrahedra inside out
            at = list(turned)
            if quadratic:
                at += [(turned[a] + turned[b]) // 2 for a, b in EDGES]
            index = [
                [2 * place + np.where(f, 2 - s[axis], s[axis]) for s in at]
                for axis, (place, f) in enumerate(zip(places, flip, strict=True))
            ]
            found.append(np.ravel_multi_index(np.array(index), shape).T)
        tets.append(np.where(mirrored[:, None], found[1], found[0]))
    cells = np.stack(tets, axis=1).reshape(-1, tets[0].shape[1])
    used, cells = np.unique(cells, return_inverse=True)
    number = np.full(shape, -1, dtype=np.int64)
    number.ravel()[used] = np.arange(used.size)
    return fine.reshape(-1, 3)[used], cells.reshape(-1, tets[0].shape[1]).astype(np.int64), number


def _symmetric(stations: Array) -> tuple[Array, NDArray[np.bool_]]:
    """Stations with one in the middle if they are symmetric, and which of their cells lie beyond it.

    A cell across the middle cannot be cut into six tetrahedra that are their own mirror image.
    """
    middle = 0.5 * (stations[0] + stations[-1])
    if np.abs(stations + stations[::-1] - 2.0 * middle).max() <= 1e-9 * np.ptp(stations):
        if stations.size % 2 == 0:
            stations = np.insert(stations, stations.size // 2, middle)
        # what is symmetric but for rounding becomes so
        stations = middle + 0.5 * ((stations - middle) - (stations - middle)[::-1])
    return stations, 0.5 * (stations[1:] + stations[:-1]) > middle


def _set(number: Index) -> Index:
    found = np.unique(number)
    return np.asarray(found[found >= 0], dtype=np.int64)


def _stations(name: str, values: ArrayLike) -> Array:
    places = np.asarray(values, dtype=float)
    if places.ndim != 1 or places.size < 2 or not np.isfinite(places).all() or (np.diff(places) <= 0.0).any():
        raise ValueError(f"{name}: at least two rising numbers [m] are needed")
    return places


def block_mesh(
    x: ArrayLike,
    y: ArrayLike,
    height: float,
    *,
    halved: bool = False,
    clamped: bool = False,
    thinner: float = 1.0,
    quadratic: bool = True,
) -> TetraMesh:
    """Block standing on the plane z = 0.

    Parameters
    ----------
    x, y : (nx,), (ny,) [m]
        Rising coordinates of the nodes of its foot, those of the contact grid.
    height : float [m]
    halved : bool
        Whether supports need nodes at half height.
    clamped : bool
        Whether all of the top is held: at its edge stress is singular, so there is one thin layer more.
    thinner : float [-]
        The layers are those of a grid finer by this factor.

    Node sets "contact" (z = 0), "top", "rear" (least x), "front", "right" (least y), "left".
    """
    x, y = _stations("x", x), _stations("y", y)
    step, width = float(min(np.diff(x).min(), np.diff(y).min())), float(min(np.ptp(x), np.ptp(y)))
    z = _heights(step / thinner, positive("height", height, "m"), width, halved, clamped)
    (x, ahead), (y, aside) = _symmetric(x), _symmetric(y)
    check_unknowns(6.0 * x.size * y.size * (z.size - 1), quadratic=quadratic)
    corners = np.stack(np.meshgrid(x, y, z, indexing="ij"), axis=-1)
    nodes, cells, number = tetrahedra(corners, flipped=(ahead, aside), quadratic=quadratic)
    return TetraMesh(nodes, cells, _box_sets(number))


def _box_sets(number: Index) -> dict[str, Index]:
    return {
        "contact": _set(number[:, :, 0]),
        "top": _set(number[:, :, -1]),
        "rear": _set(number[0]),
        "front": _set(number[-1]),
        "right": _set(number[:, 0]),
        "left": _set(number[:, -1]),
    }


def shoe_mesh(
    shoe: PoleShoe,
    x: ArrayLike,
    y: ArrayLike,
    *,
    side: Side = "left",
    halved: bool = False,
    clamped: bool = False,
    thinner: float = 1.0,
    quadratic: bool = True,
) -> TetraMesh:
    """One pole of a shoe in the shoe's own frame: sole on the profile, flat top.

    Parameters
    ----------
    shoe : PoleShoe
    x : (nx,) [m]
        Rising coordinates of the nodes along the pole.
    y : (ny,) [m]
        Rising |y| of the nodes over the conforming strip, from `inner_edge` to `conforming_to`.
    side : "left" (y > 0) or "right"
    halved : bool
        Whether supports need nodes at half height.
    clamped : bool
        Whether all of the top is held: at its edge stress is singular, so there is one thin layer more.
    thinner : float [-]
        The layers are those of a grid finer by this factor.

    Node sets "contact" (the conforming strip), "sole" (all of the underside), "top", "rear", "front",
    "inner", "outer".
    """
    x, y = _stations("x", x), _stations("y", y)
    if abs(y[0] - shoe.inner_edge) > 1e-9 or abs(y[-1] - shoe.conforming_to) > 1e-9:
        raise ValueError(
            f"y runs from {y[0]:g} to {y[-1]:g} m: the conforming strip is {shoe.inner_edge:g} to "
            f"{shoe.conforming_to:g} m"
        )
    toward = 1.0 if choice("side", side, Side) == "left" else -1.0
    x, ahead_of_middle = _symmetric(x)
    n_strip = y.size
    relief = shoe.outer_edge - shoe.conforming_to
    width = min(float(np.ptp(x)), shoe.outer_edge - shoe.inner_edge)
    if relief > 1e-9:
        y = np.concatenate([y, y[-1] + layers(float(np.diff(y)[-1]) / thinner, relief, width, least=1)[1:]])
    step = min(np.diff(x).min(), np.diff(y[:n_strip]).min())
    worn = shoe.sole(toward * y)
    thinnest = shoe.height - float(worn.max())
    tallest = shoe.height - float(worn.min())
    rise = _heights(float(min(step / thinner, thinnest)), tallest, width, halved, clamped) / tallest

    check_unknowns(6.0 * x.size * y.size * (rise.size - 1), quadratic=quadratic)

    def place(x: Array, y: Array, rise: Array) -> Array:
        xs, ys, rises = np.meshgrid(x, y, rise, indexing="ij")
        sole = shoe.sole(toward * y)[None, :, None]
        return np.stack([xs, ys, sole + rises * (shoe.height - sole)], axis=-1)

    sole = (slice(None), slice(None), 0)
    fine_sole = place(_doubled(x), _doubled(y), np.zeros(1))[:, :, 0]
    corners = place(x, y, rise)
    nodes, cells, number = tetrahedra(
        corners,
        curved=(sole, fine_sole) if quadratic else None,
        flipped=(ahead_of_middle, False),
        quadratic=quadratic,
    )
    sets = _box_sets(number)
    sets = {"sole": sets["contact"], "inner": sets.pop("right"), "outer": sets.pop("left"), **sets}
    sets["contact"] = _set(number[:, : 2 * n_strip - 1, 0])
    outwards = TetraMesh(nodes, cells, sets)
    return outwards if toward > 0.0 else outwards.mirrored()


def _doubled(places: Array) -> Array:
    fine = np.empty(2 * places.size - 1)
    fine[::2] = places
    fine[1::2] = 0.5 * (places[1:] + places[:-1])
    return fine


@dataclass(frozen=True)
@plain
class RailSection:
    """Section of a rail below the running surface of its head, simplified.

    Parameters
    ----------
    web_half_width : float [m]
    web_top, web_bottom : float [m]
        Heights z where the lower head and the foot meet the web.
    head_edge : (y, z) [m]
        Lower corner of the head.
    foot_half_width, foot_toe, bottom : float [m]
        Half width of the foot, its thickness at the toe, and the height z of its base.
    """

    web_half_width: float = 8.25e-3
    web_top: float = -51e-3
    web_bottom: float = -142e-3
    head_edge: tuple[float, float] = (37.33e-3, -40.425e-3)
    foot_half_width: float = 75e-3
    foot_toe: float = 11.5e-3
    bottom: float = -172e-3


def rail_mesh(
    profile: Profile,
    x: ArrayLike,
    y: ArrayLike,
    length: float,
    *,
    right: ArrayLike | None = None,
    half: bool = False,
    section: RailSection | None = None,
    quadratic: bool = True,
) -> TetraMesh:
    """Rail of finite length with its web and foot; its head follows `profile`.

    Parameters
    ----------
    profile : Profile
        Running surface, z = 0 at the crown.
    x : (nx,) [m]
        Rising coordinates of the nodes along the contact; the mesh grows coarser towards the ends.
    y, right : (ny,) [m]
        Rising |y| of the nodes over the contact strip at y > 0 and at y < 0, by default the same.
    length : float [m]
        Of the rail, centred at x = 0.
    half : bool
        Only y >= 0, for scenes and rails that are symmetric.

    Node sets "left", "right" (contact strips at y > 0 and y < 0), "head" (the running surface, also
    "contact"), "base" (underside of the foot), "rear", "front" (ends), and "symmetry" (y = 0) if `half`.
    """
    x, y = _stations("x", x), _stations("y", y)
    cut = section or RailSection()
    half_length = 0.5 * positive("length", length, "m")
    if x[0] <= -half_length or x[-1] >= half_length:
        raise ValueError(f"length is {length:g} m: the contact from {x[0]:g} to {x[-1]:g} m is longer")
    beyond = y if right is None else _stations("right", right)
    left, opposite = _Flank(profile, 1.0), _Flank(profile, -1.0)
    width = _gauge_corner(left) + _gauge_corner(left if half else opposite)
    step = float(min(np.diff(y).min(), np.diff(beyond).min()))
    ends = [
        layers(step_x, half_length - reach, width, across=ACROSS_RAIL, least=1)[1:]
        for step_x, reach in ((float(x[1] - x[0]), -float(x[0])), (float(x[-1] - x[-2]), float(x[-1])))
    ]
    x, ahead_of_middle = _symmetric(np.concatenate([x[0] - ends[0][::-1], x, x[-1] + ends[1]]))
    # 1 at the underside, 0 on top
    depth = layers(step, -cut.web_top, width, across=ACROSS_RAIL)[::-1] / -cut.web_top
    coarse = coarseness(step, width, ACROSS_RAIL)
    grid = _rail_columns(left, y, cut, depth, coarse)
    other = grid if half else _rail_columns(opposite, beyond, cut, depth, coarse)
    if half:
        plane, keep, offset = grid.plane, grid.keep, 0
    else:
        plane = np.concatenate([other.plane[:0:-1] * [-1.0, 1.0], grid.plane])
        keep = np.concatenate([other.keep[::-1], grid.keep])
        offset = other.plane.shape[0] - 1
    check_unknowns(6.0 * x.size * np.count_nonzero(keep), quadratic=quadratic)
    corners = np.empty((x.size, *plane.shape[:2], 3))
    corners[..., 0] = x[:, None, None]
    corners[..., 1:] = plane
    head = plane.shape[1] - 1
    fine = _running_surface(left, grid.surface)
    if not half:
        beside = _running_surface(opposite, other.surface)
        fine = np.concatenate([beside[:0:-1] * [-1.0, 1.0], fine])
    surface = np.empty((2 * x.size - 1, fine.shape[0], 3))
    surface[..., 0] = _doubled(x)[:, None]
    surface[..., 1:] = fine
    first = 2 * (offset - (other.surface.size - 1)) if not half else 0
    span = slice(first, first + fine.shape[0])
    curved = ((slice(None), span, 2 * head), surface)
    nodes, cells, number = tetrahedra(
        corners,
        np.broadcast_to(keep, (x.size - 1, *keep.shape)),
        curved if quadratic else None,
        flipped=(ahead_of_middle, np.arange(plane.shape[0] - 1) < offset),
        quadratic=quadratic,
    )
    start, stop = (2 * (offset + n) for n in grid.strip)
    sets = {
        "left": _set(number[:, start : stop + 1, -1]),
        "head": _set(number[:, span, -1]),
        "contact": _set(number[:, span, -1]),
        "base": _set(number[:, :, 0]),
        "rear": _set(number[0]),
        "front": _set(number[-1]),
    }
    if half:
        sets["symmetry"] = _set(number[:, 0])
    else:
        stop, start = (2 * (offset - n) for n in other.strip)
        sets["right"] = _set(number[:, start : stop + 1, -1])
    return TetraMesh(nodes, cells, sets)


@dataclass(frozen=True)
class _Flank:
    """One side of a profile, y > 0 or y < 0, over the distance |y|."""

    profile: Profile
    side: float

    @property
    def end(self) -> float:
        start, end = self.profile.range
        return end if self.side > 0.0 else -start

    def height(self, y: Array) -> Array:
        return self.profile.height(self.side * y)

    def slope(self, y: Array) -> Array:
        return self.side * self.profile.slope(self.side * y)


@dataclass(frozen=True)
class _Columns:
    """Half a rail section as a grid of columns (outwards) and layers (upwards)."""

    plane: Array  # (columns, layers, 2): y and z
    keep: NDArray[np.bool_]  # cells that exist
    surface: Array  # |y| of the nodes on the running surface, column by column
    strip: tuple[int, int]  # first and last column of the contact strip


def _rail_columns(profile: _Flank, y: Array, cut: RailSection, depth: Array, coarse: float) -> _Columns:
    """Head between its running surface and its underside, web below its inner columns, foot below all.

    `depth` are the layers of the head, 1 at its underside and 0 on top; `coarse` is the coarseness below.
    """
    corner = _gauge_corner(profile)
    inner = np.linspace(0.0, y[0], max(2, round(y[0] / np.diff(y)[0])) + 1) if y[0] > 0.0 else np.zeros(1)
    outer = np.linspace(y[-1], corner, max(2, round((corner - y[-1]) / (1.3 * np.diff(y)[-1]))) + 1)
    surface = np.concatenate([inner[:-1], y, outer[1:]])
    n_web = max(2, int(np.searchsorted(surface, cut.web_half_width)))
    n_columns = surface.size
    # underside of the head: the web, then the slope to its lower edge
    under = np.empty((n_columns, 2))
    under[: n_web + 1, 0] = np.linspace(0.0, cut.web_half_width, n_web + 1)
    under[: n_web + 1, 1] = cut.web_top
    share = np.linspace(0.0, 1.0, n_columns - n_web)
    under[n_web:, 0] = cut.web_half_width + share * (cut.head_edge[0] - cut.web_half_width)
    under[n_web:, 1] = cut.web_top + share * (cut.head_edge[1] - cut.web_top)
    top = np.stack([surface, profile.height(surface)], axis=1)
    down = depth[None, :, None]
    straight = (1.0 - down) * top[:, None] + down * under[:, None]
    flank = _flank(profile, corner, cut, depth)
    # what the outermost column adds to the straight line is shared out over the columns
    bulge = flank - straight[-1]
    weight = (surface / surface[-1])[:, None, None]
    head = straight + weight**2 * bulge[None]
    n_web_layers, n_foot_layers, n_foot = (max(2, round(n / coarse)) for n in FAR_LAYERS)
    web_z = np.linspace(cut.web_bottom, cut.web_top, n_web_layers + 1)
    foot_z = np.linspace(cut.bottom, cut.web_bottom, n_foot_layers + 1)
    total = max(n_columns, n_web + n_foot + 1)
    rows = foot_z.size - 1 + web_z.size - 1 + head.shape[1]
    plane = np.zeros((total, rows, 2))
    keep = np.zeros((total - 1, rows - 1), dtype=bool)
    base = foot_z.size - 1
    neck = base + web_z.size - 1
    plane[:n_columns, neck:] = head
    keep[: n_columns - 1, neck:] = True
    columns = under[: n_web + 1, 0]
    plane[: n_web + 1, base : neck + 1] = np.stack(np.meshgrid(columns, web_z, indexing="ij"), axis=-1)
    keep[:n_web, base:neck] = True
    feet = np.concatenate([columns, np.linspace(cut.web_half_width, cut.foot_half_width, n_foot + 1)[1:]])
    toe = cut.bottom + cut.foot_toe
    share = np.clip((feet - cut.web_half_width) / (cut.foot_half_width - cut.web_half_width), 0.0, 1.0)
    upper = cut.web_bottom + share * (toe - cut.web_bottom)
    up = np.linspace(0.0, 1.0, foot_z.size)
    plane[: feet.size, : base + 1, 0] = feet[:, None]
    plane[: feet.size, : base + 1, 1] = cut.bottom + up[None] * (upper - cut.bottom)[:, None]
    keep[: feet.size - 1, :base] = True
    first = inner.size - 1
    return _Columns(plane, keep, surface, (first, first + y.size - 1))


def _gauge_corner(profile: _Flank) -> float:
    """|y| [m] on the gauge corner where the profile falls as steeply as it runs."""
    end = profile.end
    places = np.linspace(0.5 * end, end, 2001)
    steep = profile.slope(places) < -1.0
    return float(places[int(np.argmax(steep))] if steep.any() else end)


def _flank(profile: _Flank, corner: float, cut: RailSection, depth: Array) -> Array:
    """Points (layers, 2) from the lower head edge up the flank and round the gauge corner to `corner`."""
    edge = profile.end
    around = np.linspace(corner, edge, 60)
    ring = np.stack([around, profile.height(around)], axis=1)
    ring = np.concatenate([ring, np.array([cut.head_edge])])
    run = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(ring, axis=0), axis=1))])
    at = depth * run[-1]
    return np.stack([np.interp(at, run, ring[:, c]) for c in range(2)], axis=1)


def _running_surface(profile: _Flank, y: Array) -> Array:
    fine = _doubled(y)
    return np.stack([fine, profile.height(fine)], axis=1)
