# SPDX-License-Identifier: MIT OR Apache-2.0
"""Meshes for truths: unstructured tetrahedra by gmsh, which share nothing with the package's extruded ones.

Sizes grow evenly with the distance from the contact, about as wide as the contact cells there. Nodes of
curved faces are put on them. Each function has the arguments and the node sets of its namesake
in `mtb_rs.mesh`.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any
from unittest import mock

import numpy as np
from numpy.typing import NDArray

from mtb_rs import elastic
from mtb_rs.geometry import PoleShoe, Profile
from mtb_rs.mesh import RailSection, TetraMesh
from mtb_rs.mesh_files import straightened, upright
from mtb_rs.mesher import gmsh_beside

Array = NDArray[np.float64]

#: gmsh's tolerances are made for millimetres.
MILLIMETRE = 1e-3
#: Growth of the size over the distance from the contact, and the largest size in parts of a body's width.
GROWTH, LARGEST = 0.25, 0.15


def filled(build: Callable[[Any], object], size: str) -> TetraMesh:
    """Quadratic tetrahedra, their nodes on true faces, in what `build` makes of gmsh's OpenCASCADE [mm].

    Parameters
    ----------
    size
        Of the elements, a formula of x, y, z [mm].
    """
    with gmsh_beside() as gmsh:
        build(gmsh.model.occ)
        gmsh.model.occ.synchronize()
        field = gmsh.model.mesh.field.add("MathEval")
        gmsh.model.mesh.field.setString(field, "F", size)
        gmsh.model.mesh.field.setAsBackgroundMesh(field)
        for name in ("FromPoints", "ExtendFromBoundary", "FromCurvature"):
            gmsh.option.setNumber(f"Mesh.MeshSize{name}", 0)
        # HXT, another algorithm than that of the package
        gmsh.option.setNumber("Mesh.Algorithm3D", 10)
        gmsh.option.setNumber("Mesh.Optimize", 1)
        gmsh.model.mesh.generate(3)
        gmsh.model.mesh.setOrder(2)
        tags, places, _ = gmsh.model.mesh.getNodes()
        corners = gmsh.model.mesh.getElementsByType(11)[1]
    used, cells = np.unique(corners, return_inverse=True)
    order = np.argsort(tags)
    nodes = MILLIMETRE * places.reshape(-1, 3)[order[np.searchsorted(tags[order], used)]]
    # gmsh counts the last two mid-side nodes the other way round
    cells = cells.reshape(-1, 10)[:, [0, 1, 2, 3, 4, 5, 6, 7, 9, 8]].astype(np.int64)
    return straightened(upright(TetraMesh(nodes, cells)))


def box(low: Array, high: Array, step: float, cut: float | None = None) -> TetraMesh:
    """A box whose lowest face touches, cut at a `cut` of y; elements of `step` there [m]."""
    (x0, y0, z0), (x1, y1, z1) = 1e3 * np.asarray(low), 1e3 * np.asarray(high)
    middle = y1 if cut is None else 1e3 * cut

    def build(occ: Any) -> None:
        first = occ.addBox(x0, y0, z0, x1 - x0, middle - y0, z1 - z0)
        if middle < y1 - 1e-6:
            second = occ.addBox(x0, middle, z0, x1 - x0, y1 - middle, z1 - z0)
            occ.fragment([(3, first)], [(3, second)])

    largest = max(1e3 * step, LARGEST * min(x1 - x0, y1 - y0))
    return filled(build, f"Min({1e3 * step} + {GROWTH} * (z - ({z0})), {largest})")


def block_mesh(x: Array, y: Array, height: float, **_: Any) -> TetraMesh:
    """As `mtb_rs.mesh.block_mesh`."""
    mesh = box(np.array([x[0], y[0], 0.0]), np.array([x[-1], y[-1], height]), _step(x, y))
    return TetraMesh(mesh.nodes, mesh.cells, _faces(mesh.nodes))


def shoe_mesh(shoe: PoleShoe, x: Array, y: Array, *, side: str = "left", **_: Any) -> TetraMesh:
    """As `mtb_rs.mesh.shoe_mesh`."""
    low, high = np.array([x[0], y[0], 0.0]), np.array([x[-1], shoe.outer_edge, shoe.height])
    has_relief = shoe.outer_edge - shoe.conforming_to > 1e-9
    flat = box(low, high, _step(x, y), shoe.conforming_to if has_relief else None)
    toward = 1.0 if side == "left" else -1.0
    sets, nodes = _faces(flat.nodes), flat.nodes.copy()
    sole = shoe.sole(toward * nodes[:, 1])
    nodes[:, 2] = sole + flat.nodes[:, 2] * (1.0 - sole / shoe.height)
    sets["sole"], sets["inner"], sets["outer"] = sets["contact"], sets.pop("right"), sets.pop("left")
    sets["contact"] = sets["sole"][nodes[sets["sole"], 1] <= shoe.conforming_to + 1e-9]
    mesh = TetraMesh(nodes, flat.cells, sets)
    return mesh if toward > 0.0 else mesh.mirrored()


def rail_mesh(
    profile: Profile,
    x: Array,
    y: Array,
    length: float,
    *,
    right: Array | None = None,
    half: bool = False,
    **_: Any,
) -> TetraMesh:
    """As `mtb_rs.mesh.rail_mesh`, with the section of a rail that is its default."""
    cut, strips = RailSection(), [y, y if right is None else right]
    step = min(_step(y, strip) for strip in strips)
    section = {side: _half_section(profile, side, cut) for side in ((1.0,) if half else (1.0, -1.0))}

    def build(occ: Any) -> None:
        solids = []
        for points, smooth in section.values():
            tags = [occ.addPoint(-0.5e3 * length, *(1e3 * p)) for p in points]
            lines = [occ.addSpline(tags[:smooth])]
            lines += [
                occ.addLine(a, b) for a, b in zip(tags[smooth - 1 :], [*tags[smooth:], tags[0]], strict=True)
            ]
            face = occ.addPlaneSurface([occ.addCurveLoop(lines)])
            solids += [s for s in occ.extrude([(2, face)], 1e3 * length, 0.0, 0.0) if s[0] == 3]
        if not half:
            occ.fragment(solids[:1], solids[1:])

    inner, outer = (1e3 * np.array([s[k] for s in strips]) for k in (0, -1))
    away = [f"Max(0, Abs(x) - {1e3 * np.abs(x).max()})", "Max(0, -z - 3)"]
    away.append(f"Max(0, Max({inner.min()} - Abs(y), Abs(y) - {outer.max()}))")
    distance = "Sqrt(" + " + ".join(f"({a})^2" for a in away) + ")"
    mesh = filled(build, f"Min({1e3 * step} + {GROWTH} * {distance}, 12)")
    nodes = mesh.nodes.copy()
    # the running surface lies on the spline to some micrometres
    head = _on_boundary(mesh) & (nodes[:, 2] > cut.head_edge[1] + 1e-3)
    head &= np.abs(nodes[:, 0]) <= 0.5 * length
    off = profile.height(np.clip(nodes[:, 1], *profile.range)) - nodes[:, 2]
    head &= np.abs(off) < 3e-5
    nodes[head, 2] += off[head]
    tiny = 1e-9
    along = np.abs(nodes[:, 1])
    sets = {
        "head": np.flatnonzero(head),
        "contact": np.flatnonzero(head),
        "left": np.flatnonzero(head & (nodes[:, 1] > y[0] - tiny) & (nodes[:, 1] < y[-1] + tiny)),
        "base": np.flatnonzero(nodes[:, 2] < cut.bottom + tiny),
    }
    if half:
        sets["symmetry"] = np.flatnonzero(along < tiny)
    return straightened(TetraMesh(nodes, mesh.cells, sets))


def _half_section(profile: Profile, side: float, cut: RailSection) -> tuple[Array, int]:
    """Points (n, 2) round one half of a rail [m], the first ones on its running surface, and their number."""
    start, end = profile.range
    surface = np.linspace(0.0, end if side > 0.0 else -start, 200)
    top = np.stack([side * surface, profile.height(side * surface)], axis=1)
    toe = cut.bottom + cut.foot_toe
    rest = [
        cut.head_edge,
        (cut.web_half_width, cut.web_top),
        (cut.web_half_width, cut.web_bottom),
        (cut.foot_half_width, toe),
        (cut.foot_half_width, cut.bottom),
        (0.0, cut.bottom),
    ]
    return np.concatenate([top, np.array(rest) * [side, 1.0]]), len(top)


def _on_boundary(mesh: TetraMesh) -> NDArray[np.bool_]:
    """Which nodes lie on faces of one tetrahedron alone, edges' middles included."""
    sides = np.array([[0, 1, 2, 4, 5, 6], [0, 1, 3, 4, 8, 7], [0, 2, 3, 6, 9, 7], [1, 2, 3, 5, 9, 8]])
    faces = mesh.cells[:, sides].reshape(-1, 6)
    _, first, count = np.unique(np.sort(faces[:, :3], axis=1), axis=0, return_index=True, return_counts=True)
    found = np.zeros(len(mesh.nodes), dtype=bool)
    found[faces[first[count == 1]]] = True
    return found


def _step(x: Array, y: Array) -> float:
    return float(min(np.diff(x).min(), np.diff(y).min()))


def _faces(nodes: Array) -> dict[str, NDArray[np.int64]]:
    """The six faces of a box."""
    low, high = nodes.min(axis=0), nodes.max(axis=0)
    tiny = 1e-9
    names = (("rear", "front"), ("right", "left"), ("contact", "top"))
    found = {}
    for axis, (least, most) in enumerate(names):
        found[least] = np.flatnonzero(nodes[:, axis] < low[axis] + tiny)
        found[most] = np.flatnonzero(nodes[:, axis] > high[axis] - tiny)
    return found


@contextmanager
def truths() -> Iterator[None]:
    """Ready scenes with elastic bodies are meshed this way within."""
    own = {"block_mesh": block_mesh, "shoe_mesh": shoe_mesh, "rail_mesh": rail_mesh}
    with mock.patch.multiple(elastic, **own):
        yield
