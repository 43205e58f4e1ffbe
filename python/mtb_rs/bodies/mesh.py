# SPDX-License-Identifier: MIT OR Apache-2.0
"""Tetrahedral meshes, and the built-in bodies, which the compiled core fills.

Built-in bodies are grids of hexahedra, each cut into six tetrahedra, symmetric where the body is: turning
the sliding direction round turns the solution round. Their contact face follows the contact grid it is
given. Lengths in metres, z up.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .. import _mtb_rs
from ..base.check import choice, positive, reals
from ..base.owning import owning
from ..base.plain import plain
from ..base.stored import array_digest, stored
from ..base.words import Side
from ..geometry.pole_shoe import PoleShoe
from ..geometry.profiles import Profile

Array = NDArray[np.float64]
Index = NDArray[np.int64]

#: How far a matrix may be from a rotation, as entries with seven digits are.
ORTHONORMAL = 1e-6

#: No turn and no shift.
UNTURNED = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
UNMOVED = (0.0, 0.0, 0.0)

#: Bodies larger than this are suspected to be in millimetres [m].
SUSPICIOUS_SIZE = 10.0
#: Ends of the edges that carry the mid-side nodes 4 to 9.
EDGES = ((0, 1), (1, 2), (0, 2), (0, 3), (1, 3), (2, 3))


@stored
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

    def described(self) -> dict[str, Any]:
        """What `summary.json` tells of it."""
        return {
            "kind": "TetraMesh",
            "nodes": len(self.nodes),
            "cells": len(self.cells),
            "is_quadratic": self.is_quadratic,
            "lowest": self.nodes.min(axis=0),
            "highest": self.nodes.max(axis=0),
            "sha256": array_digest(self.nodes, self.cells),
        }

    def moved(self, rotation: ArrayLike = UNTURNED, shift: ArrayLike = UNMOVED) -> TetraMesh:
        """The mesh rotated by a matrix (3, 3) and then shifted by a vector (3,) [m].

        Raises
        ------
        ValueError
            If the matrix is no rotation, but a mirror or a scaling.
        """
        return TetraMesh(placed(rotation, shift)(self.nodes), self.cells, self.node_sets)

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


def placed(rotation: ArrayLike, shift: ArrayLike) -> Callable[[Array], Array]:
    """Where points (n, 3) [m] come to by a rotation (3, 3) and a shift (3,) [m] after it, both checked."""
    turn, step = reals("rotation", rotation), reals("shift", shift, "m")
    if turn.shape != (3, 3):
        raise ValueError(f"rotation has shape {turn.shape}: a matrix (3, 3) is needed")
    if step.shape != (3,):
        raise ValueError(f"shift has shape {step.shape}: a vector (3,) in metres is needed")
    hint = "its columns are the axes of the part after the turn: of length 1, at right angles, right-handed"
    if np.abs(turn @ turn.T - np.eye(3)).max() > ORTHONORMAL:
        raise ValueError(f"rotation is {turn.tolist()}, which is no rotation, as it scales or shears: {hint}")
    if np.linalg.det(turn) < 0.0:
        raise ValueError(f"rotation is {turn.tolist()}, which is no rotation but a mirror: {hint}")
    return lambda points: np.asarray(points @ turn.T + step)


def quadratic(mesh: TetraMesh) -> TetraMesh:
    """Linear tetrahedra with nodes in the middle of their straight edges, numbered behind the others.

    A set of nodes gets those between two of its own, on the boundary or in a tetrahedron that is all in it.
    """
    made = _mtb_rs.quadratic_mesh(
        np.ascontiguousarray(mesh.nodes, dtype=float),
        np.ascontiguousarray(mesh.cells, dtype=np.uintp),
        [(name, np.ascontiguousarray(own, dtype=np.uintp)) for name, own in mesh.node_sets.items()],
    )
    return _mesh(made)


def check_unknowns(tetrahedra: float, *, quadratic: bool = True) -> None:
    """Refuses a mesh before it is made, where factorising it will be refused.

    Raises
    ------
    ValueError
    """
    _mtb_rs.check_unknowns(tetrahedra, quadratic)


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
                f"tetrahedra {owners[a]} and {owners[b]} have the same corners {points[b].tolist()}: each "
                "tetrahedron may be there only once"
            )
    raise ValueError(
        f"the tetrahedra {owners[0]}, {owners[1]} and {owners[2]} share the face {ranked[k].tolist()}: "
        "a face can belong to two tetrahedra at most"
    )


def tetrahedra(
    corners: Array, *, flipped: tuple[ArrayLike, ArrayLike] = (False, False), quadratic: bool = True
) -> tuple[Array, Index, Index]:
    """Tetrahedra of a curvilinear grid of hexahedra.

    Parameters
    ----------
    corners : (nx, ny, nz, 3) [m]
        Right-handed.
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
    columns, rows = (
        np.broadcast_to(np.asarray(f, dtype=bool), n - 1).tolist()
        for f, n in zip(flipped, corners.shape, strict=False)
    )
    (nodes, cells, _), number = _mtb_rs.tetrahedra(
        np.ascontiguousarray(corners, dtype=float), columns, rows, quadratic
    )
    return nodes, cells, number


def _mesh(made: tuple[Array, Index, list[tuple[str, Index]]]) -> TetraMesh:
    nodes, cells, sets = made
    return TetraMesh(nodes, cells, dict(sets))


def _stations(name: str, values: ArrayLike) -> Array:
    places = np.asarray(values, dtype=float)
    if places.ndim != 1:
        raise ValueError(f"{name}: at least two rising numbers [m] are needed")
    return np.ascontiguousarray(places)


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
    filling = (halved, clamped, thinner, quadratic)
    return _mesh(_mtb_rs.block_mesh(x, y, positive("height", height, "m"), filling))


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
    toward = 1.0 if choice("side", side, Side) == "left" else -1.0
    filling = (halved, clamped, thinner, quadratic)
    return _mesh(_mtb_rs.pole_mesh(shoe.profile._core, shoe, toward, shoe.height, x, y, filling))


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
    beyond = y if right is None else _stations("right", right)
    made = _mtb_rs.rail_mesh(
        profile._core,
        section or RailSection(),
        x,
        y,
        None if half else beyond,
        positive("length", length, "m"),
        quadratic,
    )
    return _mesh(made)
