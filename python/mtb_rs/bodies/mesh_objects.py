# SPDX-License-Identifier: MIT OR Apache-2.0
"""Meshes as other libraries hold them: trimesh, meshio, pyvista. They are known by what they have."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
import trimesh
from numpy.typing import NDArray

from .mesh import EDGES, TetraMesh

Array = NDArray[np.float64]
Index = NDArray[np.int64]

#: Cells by their numbers in VTK.
_KINDS = {5: "triangle", 9: "quad", 10: "tetra", 22: "triangle6", 23: "quad8", 24: "tetra10"}
_KINDS |= {11: "voxel", 12: "hexahedron", 13: "wedge", 14: "pyramid"}
_KINDS |= {25: "hexahedron20", 26: "wedge15", 27: "pyramid13", 29: "hexahedron27"}
#: Triangles that stand for a cell of a surface: the mid-side nodes of curved ones are corners.
_PIECES = {
    "triangle": ((0, 1, 2),),
    "triangle6": ((0, 3, 5), (3, 1, 4), (5, 4, 2), (3, 4, 5)),
    "quad": ((0, 1, 2), (0, 2, 3)),
    "quad8": ((0, 4, 7), (4, 1, 5), (5, 2, 6), (6, 3, 7), (4, 5, 6), (4, 6, 7)),
}
#: Faces of a tetrahedron, seen from outside.
_FACES = ((0, 2, 1), (0, 1, 3), (1, 2, 3), (0, 3, 2))
_MIDDLES = {frozenset(ends): 4 + k for k, ends in enumerate(EDGES)}


@dataclass(frozen=True)
class MeshCells:
    """Points (n, 3) and cells by their kind, in meshio's words; `source` has the named sets, if any."""

    points: Array
    cells: dict[str, Index]
    source: Any = field(default=None, repr=False)

    @property
    def solids(self) -> list[str]:
        """The kinds of tetrahedra in it."""
        return [kind for kind in ("tetra10", "tetra") if kind in self.cells]

    def surface(self) -> trimesh.Trimesh | None:
        """Its surface cells, or the boundary of its tetrahedra, as triangles; None if it has neither."""
        if self.solids:
            faces = np.concatenate([_boundary(self.cells[kind]) for kind in self.solids])
        else:
            kinds = [kind for kind in _PIECES if kind in self.cells]
            pieces = [self.cells[kind][:, np.array(_PIECES[kind])].reshape(-1, 3) for kind in kinds]
            faces = np.concatenate(pieces) if pieces else np.empty((0, 3), dtype=np.int64)
        return trimesh.Trimesh(self.points, faces, process=True) if len(faces) else None


def _boundary(cells: Index) -> Index:
    """Triangles that belong to one tetrahedron only; four for each face of one with mid-side nodes."""
    corners: Index = cells[:, np.array(_FACES)].reshape(-1, 3)
    _, first, counts = np.unique(np.sort(corners, axis=1), axis=0, return_index=True, return_counts=True)
    outer = first[counts == 1]
    if cells.shape[1] == 4:
        corners = corners[outer]
        return corners
    curved = np.array([(*f, *(_MIDDLES[frozenset((f[k], f[k - 2]))] for k in range(3))) for f in _FACES])
    faces: Index = cells[:, curved].reshape(-1, 6)[outer][:, np.array(_PIECES["triangle6"])]
    return faces.reshape(-1, 3)


def cells_of(source: Any) -> MeshCells | None:
    """Points and cells of a mesh of meshio or pyvista, or of a TetraMesh; None for anything else."""
    if isinstance(source, TetraMesh):
        kind = "tetra10" if source.is_quadratic else "tetra"
        return MeshCells(np.asarray(source.nodes), {kind: np.asarray(source.cells)}, source)
    if hasattr(source, "cast_to_unstructured_grid"):
        return _of_pyvista(source)
    if hasattr(source, "cells_dict") and hasattr(source, "points"):
        return MeshCells(np.asarray(source.points), source.cells_dict, source)
    return None


def _of_pyvista(source: Any) -> MeshCells:
    kinds = {_KINDS.get(int(kind)) for kind in getattr(source, "celltypes", ())}
    if kinds & {"tetra", "tetra10"}:
        known = source.extract_cells(np.isin(source.celltypes, list(_KINDS)))
        cells = {_KINDS[int(kind)]: np.asarray(own, np.int64) for kind, own in known.cells_dict.items()}
        return MeshCells(np.asarray(known.points, dtype=float), cells)
    # polygons, strips, grids: whatever it is made of, its surface is triangles
    is_surface = hasattr(source, "is_all_triangles")
    surface = source if is_surface else source.extract_surface(algorithm="dataset_surface")
    triangles = surface.triangulate()
    cells = {"triangle": np.asarray(triangles.regular_faces, np.int64)} if triangles.n_cells else {}
    return MeshCells(np.asarray(triangles.points, dtype=float), cells)


def as_trimesh(source: Any) -> trimesh.Trimesh | None:
    """The surface of a mesh of any library, in its own unit; None for what is no mesh, or has no surface."""
    if hasattr(source, "vertices") and hasattr(source, "faces"):
        return trimesh.Trimesh(np.asarray(source.vertices), np.asarray(source.faces), process=True)
    cells = cells_of(source)
    return None if cells is None else cells.surface()
