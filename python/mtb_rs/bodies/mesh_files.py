# SPDX-License-Identifier: MIT OR Apache-2.0
"""Meshes from elsewhere: solids of CAD and closed surfaces, filled by gmsh, ready meshes through meshio."""

from __future__ import annotations

import contextlib
import hashlib
import io
import re
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import trimesh
from numpy.typing import NDArray

from ..base.check import path_of, positive, shortened
from ..base.files import check_readable, check_surface_file, check_triangles
from ..base.words import Unit
from ..geometry.profile_files import UNITS, metres
from .mesh import EDGES, SUSPICIOUS_SIZE, TetraMesh, check_unknowns, quadratic
from .mesh_objects import MeshCells, cells_of
from .mesher import gmsh_beside

Array = NDArray[np.float64]
Index = NDArray[np.int64]
#: Which vertices (n, 3) [m] of a closed surface are on its contact face; its triangles (m, 3) look outwards.
Near = Callable[[Array, Index], NDArray[np.bool_]]

#: Files of closed surfaces and of solids; all others are taken for ready meshes.
SURFACE_FILES = (".stl", ".ply", ".obj", ".off", ".glb", ".gltf", ".3mf")
SOLID_FILES = (".step", ".stp", ".iges", ".igs")

#: Curved elements on a full turn of a curved face of a solid, at least: the nodes of each lie on it.
ELEMENTS_A_TURN = 16
#: The smallest of these, in parts of the size at the contact.
SMALLEST = 4.0
#: Most bytes of a file of a mesh or a solid.
MOST_BYTES = 1_000_000_000
#: Most triangles of a closed surface: gmsh takes about 0.1 ms for each of them.
MOST_GIVEN = 300_000
#: Triangles from which on the size is taken for a mistake.
MOST_TRIANGLES = 2_000_000

#: Tetrahedra far from the contact are this many times as large as at it.
FAR = 2.5

#: Jacobian below which a curved tetrahedron is straightened, in parts of the straight one's.
LEAST_JACOBIAN = 0.1

#: The length unit of solids within gmsh [m].
MILLIMETRE = 1e-3

#: Growth of the size over the distance from the contact.
GROWTH = 0.2

#: Edges of a surface that turn by more than this angle stay edges [rad]: the end of a worn sole is a
#: kink of 11 degrees.
FEATURE_ANGLE = np.radians(8.0)


class MissingExtra(ValueError):
    """A library is not installed, or lacks one of its own."""


@contextlib.contextmanager
def extra_mesh(purpose: str) -> Iterator[None]:
    """Says where the libraries come from that `purpose` needs: gmsh, meshio, and what trimesh calls."""
    try:
        yield
    except ImportError as error:
        raise MissingExtra(f"{purpose} needs the extra mesh (pip install 'mtb-rs[mesh]'): {error}") from None


def read_mesh(
    source: Any, unit: Unit = "m", *, size: float | None = None, near: Near | None = None
) -> TetraMesh:
    """Tetrahedra from a file or a mesh object.

    Parameters
    ----------
    source
        Path, mesh of trimesh, meshio or pyvista, or TetraMesh (taken as it is).
    unit : "m", "mm", "um" or "in"
        Of the numbers; files of solids tell their own.
    size : float [m]
        Size of the tetrahedra near the contact; for closed surfaces and solids only.
    near : function of the vertices (n, 3) [m] and triangles (m, 3) of a surface
        Which vertices are on the contact face.
    """
    scale = metres(unit)
    if isinstance(source, TetraMesh):
        return TetraMesh(source.nodes * scale, source.cells, source.node_sets)
    if isinstance(source, trimesh.Trimesh):
        return filled(np.asarray(source.vertices) * scale, np.asarray(source.faces), size, near)
    if isinstance(source, (str, Path)):
        path = path_of("mesh file", source)
        if not path.exists():
            raise ValueError(f"{path} is not there: the path of a mesh file is needed")
        check_readable(path, "mesh file", MOST_BYTES)
        if path.stat().st_size == 0:
            raise ValueError(f"{path} is empty: a mesh is needed")
        is_solid = path.suffix.lower() in SOLID_FILES
        if is_solid and scale != 1.0:
            _check_stated(path, unit)
        if is_solid or path.suffix.lower() in SURFACE_FILES:
            if is_solid:
                return solid(path, size, near)
            check_surface_file(path, "mesh file", MOST_GIVEN)
            surface = read_surface(path)
            try:
                return filled(np.asarray(surface.vertices) * scale, np.asarray(surface.faces), size, near)
            except ValueError as error:
                raise ValueError(f"{path}: {error}") from None
        source = _read_by_meshio(path)
    given = cells_of(source)
    if given is None:
        raise ValueError(
            f"{shortened(source)} is no mesh: a path, a mesh of trimesh, meshio or pyvista, or a TetraMesh "
            "is needed"
        )
    outer = None if given.solids else given.surface()
    if outer is not None:
        return filled(np.asarray(outer.vertices) * scale, np.asarray(outer.faces), size, near)
    return _from_cells(given, scale)


#: Metres per unit of length that STEP files state, by prefix or name.
_STEP_UNITS = {b"$": 1.0, b".CENTI.": 1e-2, b".MILLI.": 1e-3, b".MICRO.": 1e-6, b"INCH": 0.0254}


def _check_stated(path: Path, unit: Unit) -> None:
    """ValueError where a file of a solid states another unit than the one given, or none read here."""
    content = path.read_bytes()
    metric = re.findall(rb"SI_UNIT\s*\(\s*(\$|\.\w+\.)\s*,\s*\.METRE\.", content)
    # other units of length are defined by a metric one
    others = re.findall(rb"CONVERSION_BASED_UNIT\s*\(\s*'(INCH)'", content, re.I)
    stated = {_STEP_UNITS.get(word.upper()) for word in others or metric}
    if stated != {metres(unit)}:
        names = [name for name, size in UNITS.items() if size in stated]
        told = f", {', '.join(names)}" if names else ""
        raise ValueError(
            f'unit is {unit!r}: {path.suffix} files tell their own, "m" is needed, or what {path} tells{told}'
        )


@dataclass(frozen=True)
class MeshSource:
    """A solid or closed surface that can be meshed again.

    Attributes
    ----------
    source
        Path or surface as trimesh holds it, of its own.
    unit : "m", "mm", "um" or "in"
    size : float [m]
        Of the tetrahedra that it was filled with.
    digest : str
        Of the file as it was then.
    place : function
        Where points (n, 3) [m] of the source come to in the body.
    """

    source: Any
    unit: Unit
    size: float
    digest: str
    place: Callable[[Array], Array]

    @classmethod
    def of(
        cls, source: Any, unit: Unit, size: float | None, mesh: TetraMesh, place: Callable[[Array], Array]
    ) -> MeshSource | None:
        """What `mesh` was made of; None where it was given."""
        extent = float(np.ptp(mesh.nodes, axis=0).max())
        size = extent / 15.0 if size is None else float(size)
        if isinstance(source, trimesh.Trimesh):
            return cls(source.copy(), unit, size, "", place)
        given = None if isinstance(source, TetraMesh) else cells_of(source)
        if given is not None and not given.solids:
            return cls(given.surface(), unit, size, "", place)
        if isinstance(source, (str, Path)) and Path(source).suffix.lower() in SOLID_FILES + SURFACE_FILES:
            path = Path(source).absolute()
            return cls(path, unit, size, _digest(path), place)
        return None

    def mesh(self, size: float, near: Near) -> TetraMesh:
        """Tetrahedra of another size [m], at their place in the body; `near` is asked there.

        Raises
        ------
        ValueError
            As :func:`read_mesh`, or if the file is another one now.
        """
        if isinstance(self.source, Path) and self.source.is_file() and _digest(self.source) != self.digest:
            raise ValueError(f"{self.source} has changed since its solid was meshed: make the body anew")
        made = read_mesh(
            self.source, self.unit, size=size, near=lambda points, faces: near(self.place(points), faces)
        )
        return TetraMesh(self.place(made.nodes), made.cells, made.node_sets)


def _digest(path: Path) -> str:
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def read_surface(path: Path) -> trimesh.Trimesh:
    """The one triangulated surface of a file, as trimesh reads it."""
    accepted = f"a file of one surface of triangles is needed ({', '.join(SURFACE_FILES)})"
    if path.suffix.lower() in SOLID_FILES:
        raise ValueError(f"{path} holds a solid of CAD: {accepted}; ElasticBody.from_mesh takes solids")
    try:
        with extra_mesh(f"reading {path.suffix} files"):
            # degenerate and doubled triangles stay: they are for us to name
            surface = trimesh.load_mesh(path, process=False)
    except MissingExtra:
        raise
    except Exception as error:  # its readers raise whatever they stumble over
        reason = (str(error) or type(error).__name__).splitlines()[0]
        raise ValueError(
            f"{path} cannot be read: it is no {path.suffix} file, or a damaged one ({reason}); {accepted}"
        ) from None
    if not isinstance(surface, trimesh.Trimesh):
        raise ValueError(f"{path} holds {type(surface).__name__}: {accepted}")
    if not len(surface.faces):
        raise ValueError(f"{path} holds no triangles: it is empty, cut off or damaged; {accepted}")
    return surface


def turn_outwards(surface: trimesh.Trimesh) -> None:
    """Makes neighbouring triangles agree on their side, and those of a closed surface look outwards."""
    with extra_mesh("turning the triangles of a surface outwards"):
        if not surface.is_winding_consistent:
            trimesh.repair.fix_winding(surface)  # type: ignore[no-untyped-call]
        if surface.is_watertight and surface.volume < 0.0:
            surface.invert()


def solid(path: Path, size: float | None = None, near: Near | None = None) -> TetraMesh:
    """Quadratic tetrahedra inside the one solid of a CAD file, by gmsh; their nodes lie on its true faces.

    Parameters
    ----------
    size, near
        As of :func:`filled`; `near` is asked about triangles of the solid's faces.
    """
    if size is not None:
        positive("size", size, "m")
    with _gmsh(f"reading {path.suffix} files") as gmsh:
        # gmsh's tolerances are absolute, and made for millimetres
        gmsh.option.setString("Geometry.OCCTargetUnit", "MM")
        try:
            gmsh.model.occ.importShapes(str(path))
            gmsh.model.occ.synchronize()
        except Exception as error:  # its own class, of any cause
            raise ValueError(
                f"{path} cannot be read: it is no {path.suffix} file of a solid ({error})"
            ) from None
        solids = gmsh.model.getEntities(3)
        if len(solids) != 1:
            raise ValueError(f"{path} holds {len(solids)} solids: one is needed")
        low, high = MILLIMETRE * np.array(gmsh.model.getBoundingBox(-1, -1)).reshape(2, 3)
        extent = float((high - low).max())
        size = extent / 15.0 if size is None else size
        area = MILLIMETRE**2 * sum(gmsh.model.occ.getMass(2, tag) for _, tag in gmsh.model.getEntities(2))
        count = 4.0 / np.sqrt(3.0) * area / size**2
        if count > MOST_TRIANGLES:
            raise ValueError(
                f"{path}: size is {size:g} m: the solid, {extent:g} m large, would have {count:.0e} "
                f"triangles: at most {MOST_TRIANGLES:g} are made"
            )
        _check_size(size, extent)
        try:
            return _curved(gmsh, size, near)
        except ValueError as error:
            raise ValueError(f"{path}: {error}") from None
        except Exception as error:
            raise ValueError(f"{path}: gmsh cannot mesh the solid: {error}") from None


def _curved(gmsh: Any, size: float, near: Near | None) -> TetraMesh:
    """Quadratic tetrahedra in gmsh's one solid of the boundary representation."""
    step = size / MILLIMETRE
    _set_sizes(gmsh, 0.0, step, ELEMENTS_A_TURN)
    gmsh.model.mesh.generate(2)
    vertices, triangles = _elements(gmsh, 2, 3)
    vertices *= MILLIMETRE
    surface = trimesh.Trimesh(vertices, triangles.copy(), process=False)
    # gmsh's triangles look where the faces of the solid do
    turn_outwards(surface)
    is_contact = _on_contact(surface, near)
    _check_count(surface, is_contact, size)
    at_contact, first = [], 0
    for _, tag in gmsh.model.getEntities(2):
        # gmsh counts the elements of a kind face by face
        own = triangles[first : first + len(gmsh.model.mesh.getElementsByType(2, tag)[0])]
        first += len(own)
        if is_contact is None or is_contact[own].all(axis=1).any():
            at_contact.append(tag)
    gmsh.model.mesh.clear()
    _grow_away(gmsh, at_contact, step)
    _set_sizes(gmsh, step / SMALLEST, FAR * step, ELEMENTS_A_TURN)
    gmsh.model.mesh.generate(3)
    gmsh.model.mesh.setOrder(2)
    nodes, cells = _elements(gmsh, 11, 10)
    # gmsh counts the last two mid-side nodes the other way round
    order = [0, 1, 2, 3, 4, 5, 6, 7, 9, 8]
    return straightened(upright(TetraMesh(nodes * MILLIMETRE, cells[:, order])))


def straightened(mesh: TetraMesh) -> TetraMesh:
    """The mesh with straight edges where curved ones turn a quadratic tetrahedron inside out."""
    cells, nodes = mesh.cells, mesh.nodes.copy()
    ends = cells[:, np.array(EDGES)]
    for _ in range(len(EDGES)):  # a straight edge may bend a neighbour
        bad = _least_jacobian(nodes[cells]) < LEAST_JACOBIAN
        if not bad.any():
            break
        nodes[cells[bad, 4:]] = nodes[ends[bad]].mean(axis=2)
    return TetraMesh(nodes, cells, mesh.node_sets)


def _least_jacobian(corners: Array) -> Array:
    """Smallest Jacobian at the nodes of quadratic tetrahedra (m, 10, 3), relative to straight ones."""
    ends = np.array(EDGES)
    places = np.concatenate([np.eye(4), 0.5 * (np.eye(4)[ends[:, 0]] + np.eye(4)[ends[:, 1]])])
    slopes = np.array([[-1.0, -1.0, -1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]])

    def jacobian(place: Array) -> Array:
        at_corners = (4.0 * place - 1.0)[:, None] * slopes
        i, j = ends.T
        at_edges = 4.0 * (place[i, None] * slopes[j] + place[j, None] * slopes[i])
        slope = np.concatenate([at_corners, at_edges])
        return np.asarray(np.linalg.det(np.einsum("mnx,ns->mxs", corners, slope)))

    straight = np.linalg.det(np.einsum("mnx,ns->mxs", corners[:, :4], slopes))
    return np.asarray(np.min([jacobian(place) for place in places], axis=0) / straight)


def _read_by_meshio(path: Path) -> Any:
    with extra_mesh(f"reading {path}"):
        import meshio
    try:
        # it prints what it then raises
        with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(io.StringIO()):
            return meshio.read(path)
    except SystemExit:
        raise ValueError(f"{path} cannot be read: it is no {path.suffix} file that meshio knows") from None
    except Exception as error:  # its readers raise whatever they stumble over
        reason = str(error).splitlines()[0] if str(error) else type(error).__name__
        raise ValueError(f"{path} cannot be read as a mesh: {reason}") from None


def _from_cells(mesh: MeshCells, scale: float) -> TetraMesh:
    blocks, kinds = mesh.cells, mesh.solids
    others = [kind for kind in blocks if kind.startswith(("voxel", "hexahedron", "wedge", "pyramid"))]
    if len(kinds) != 1 or others:
        found = f"cells {', '.join(sorted(blocks))}" if blocks else "no cells"
        raise ValueError(
            f"the mesh has {found}: either 4-node or 10-node tetrahedra, or a closed surface, are needed"
        )
    cells = np.asarray(blocks[kinds[0]], dtype=np.int64)
    points = np.asarray(mesh.points, dtype=float)
    if points.ndim != 2 or points.shape[1] != 3 or not cells.size:
        raise ValueError(
            f"the mesh has points {points.shape} and {len(cells)} tetrahedra: (n, 3) and some are needed"
        )
    if cells.min() < 0 or cells.max() >= len(points):
        wrong = cells[(cells < 0) | (cells >= len(points))][0]
        raise ValueError(f"tetrahedra name the node {wrong}: there are 0 to {len(points) - 1}")
    used, cells = np.unique(cells, return_inverse=True)
    wrong = ~np.isfinite(points[used]).all(axis=1)
    if wrong.any():
        node = int(used[np.argmax(wrong)])
        raise ValueError(f"node {node} of the mesh is {points[node].tolist()}: finite numbers are needed")
    nodes = points[used] * scale
    named = {} if mesh.source is None else _node_sets(mesh.source)
    sets = {name: np.searchsorted(used, own[np.isin(own, used)]) for name, own in named.items()}
    return upright(TetraMesh(nodes, cells.reshape(-1, blocks[kinds[0]].shape[1]).astype(np.int64), sets))


def _node_sets(mesh: Any) -> dict[str, Index]:
    """Nodes of the named sets of a meshio object; those of its points go before those of its cells.

    Sets of cells, of any dimension, stand for their nodes: physical groups of gmsh and groups of MED too.
    """
    blocks = [np.asarray(block.data, dtype=np.int64) for block in mesh.cells]
    found: dict[str, list[Index]] = {}
    for name, chosen in mesh.cell_sets.items():
        if str(name).startswith("gmsh:"):  # what gmsh bounds its entities by, not named by anyone
            continue
        for block, own in zip(blocks, chosen, strict=True):
            if own is not None:
                found.setdefault(str(name), []).append(block[np.asarray(own, dtype=np.int64)].ravel())
    for name, (tag, dimension) in _groups(mesh):
        # gmsh numbers the groups of each dimension by themselves
        for cells, block, tags in zip(mesh.cells, blocks, mesh.cell_data["gmsh:physical"], strict=True):
            if cells.dim == dimension:
                found.setdefault(name, []).append(block[np.asarray(tags) == tag].ravel())
    for tag, names in getattr(mesh, "cell_tags", {}).items():
        for name in names:
            for block, tags in zip(blocks, mesh.cell_data.get("cell_tags", ()), strict=False):
                found.setdefault(str(name), []).append(block[np.asarray(tags) == tag].ravel())
    sets = {name: np.unique(np.concatenate(parts)) for name, parts in found.items()}
    tagged: dict[str, list[Index]] = {}
    for tag, names in getattr(mesh, "point_tags", {}).items():
        for name in names:
            own = np.flatnonzero(np.asarray(mesh.point_data.get("point_tags", ())) == tag)
            tagged.setdefault(str(name), []).append(own)
    sets.update({name: np.unique(np.concatenate(parts)) for name, parts in tagged.items()})
    sets.update(
        {str(name): np.unique(np.asarray(own, dtype=np.int64)) for name, own in mesh.point_sets.items()}
    )
    return sets


def _groups(mesh: Any) -> list[tuple[str, Any]]:
    """Physical groups of gmsh by name: their tag and dimension, unless they are sets of cells already."""
    if "gmsh:physical" not in mesh.cell_data:
        return []
    return [(str(name), tag) for name, tag in mesh.field_data.items() if name not in mesh.cell_sets]


def upright(mesh: TetraMesh) -> TetraMesh:
    """The mesh with its tetrahedra numbered the right way round, if all are the wrong way."""
    corners = mesh.nodes[mesh.cells[:, :4]]
    a, b, c = (corners[:, k] - corners[:, 0] for k in (1, 2, 3))
    if (np.einsum("ij,ij->i", np.cross(a, b), c) > 0.0).any():
        return mesh
    swap = [1, 0, 2, 3] if mesh.cells.shape[1] == 4 else [1, 0, 2, 3, 4, 6, 5, 8, 7, 9]
    return TetraMesh(mesh.nodes, mesh.cells[:, swap], mesh.node_sets)


def check_surface(vertices: Array, triangles: Index) -> trimesh.Trimesh:
    """A closed surface without degenerate triangles, its vertices merged.

    Raises
    ------
    ValueError
        Naming the first triangle or edge that is wrong, or pieces beside each other.
    """
    if vertices.ndim != 2 or vertices.shape[1] != 3 or triangles.ndim != 2 or triangles.shape[1] != 3:
        raise ValueError(
            f"vertices and triangles of the surface have shapes {vertices.shape} and {triangles.shape}: "
            "(n, 3) and (m, 3) are needed"
        )
    if not len(triangles):
        raise ValueError("the surface has no triangles")
    check_triangles(len(triangles), MOST_GIVEN, "the surface")
    if triangles.min() < 0 or triangles.max() >= len(vertices):
        wrong = triangles[(triangles < 0) | (triangles >= len(vertices))][0]
        raise ValueError(f"triangles name the vertex {wrong}: there are 0 to {len(vertices) - 1}")
    if not np.isfinite(vertices).all():
        bad = int(np.argmin(np.isfinite(vertices).all(axis=1)))
        raise ValueError(
            f"vertex {bad} of the surface is {vertices[bad].tolist()}: finite numbers are needed"
        )
    surface = trimesh.Trimesh(vertices, triangles, process=True)
    length = float(np.ptp(vertices, axis=0).max())
    area = surface.area_faces
    if (area <= 1e-14 * length**2).any():
        bad = int(np.argmin(area))
        raise ValueError(f"triangle {bad} of the surface is degenerate: its area is {area[bad]:.3g} m2")
    if not surface.is_watertight:
        edges, counts = np.unique(surface.edges_sorted, axis=0, return_counts=True)
        bad_edges = edges[counts != 2]
        place = surface.vertices[bad_edges[0]].mean(axis=0)
        raise ValueError(
            f"the surface is not closed: {len(bad_edges)} edges do not belong to exactly two triangles, "
            f"the first near {np.round(place, 6).tolist()} m; close the surface"
        )
    _check_pieces(surface)
    turn_outwards(surface)
    return surface


def _check_pieces(surface: trimesh.Trimesh) -> None:
    """Pieces of a closed surface beside each other are several bodies; those within one are its holes."""
    count = len(surface.faces)
    labels = trimesh.graph.connected_component_labels(surface.face_adjacency, count)  # type: ignore[no-untyped-call]
    corners = [surface.triangles[labels == k].reshape(-1, 3) for k in range(labels.max() + 1)]
    low, high = surface.bounds
    # the outer one has the bounds of the whole
    if not any((c.min(axis=0) == low).all() and (c.max(axis=0) == high).all() for c in corners):
        middles = [np.round(c.mean(axis=0), 6).tolist() for c in corners[:2]]
        raise ValueError(
            f"the surface has {len(corners)} separate pieces, the first two around {middles[0]} and "
            f"{middles[1]} m: one connected piece is needed; unite the pieces first"
        )


def filled(
    vertices: Array, triangles: Index, size: float | None = None, near: Near | None = None
) -> TetraMesh:
    """Quadratic tetrahedra inside a closed surface, by gmsh.

    Parameters
    ----------
    vertices, triangles : (n, 3) [m], (m, 3)
    size : float [m]
        Size near the contact; by default a fifteenth of the largest extent. Elsewhere up to 2.5 times that.
    near : function of the vertices (n, 3) [m] and triangles (m, 3) of the surface
        Which vertices are on the contact face; by default all of the surface is meshed at `size`.
    """
    with extra_mesh("checking a closed surface"):
        surface = check_surface(np.asarray(vertices, dtype=float), np.asarray(triangles, dtype=np.int64))
    extent = float(np.ptp(surface.vertices, axis=0).max())
    size = extent / 15.0 if size is None else positive("size", size, "m")
    _check_size(size, extent)
    is_contact = _on_contact(surface, near)
    if is_contact is not None and not is_contact[surface.faces].all(axis=1).any():
        raise ValueError("no triangle of the surface lies on the contact face")
    _check_count(surface, is_contact, size)
    with _gmsh("filling a closed surface with tetrahedra") as gmsh:
        try:
            nodes, cells = _gmsh_tetrahedra(gmsh, surface, is_contact, size)
        except Exception as error:
            raise ValueError(f"gmsh cannot mesh the surface: {error}") from None
    return quadratic(upright(TetraMesh(nodes, cells)))


def _check_size(size: float, extent: float) -> None:
    if size > extent:
        raise ValueError(f"size is {size:g} m: the body is only {extent:g} m large, a smaller size is needed")


def _on_contact(surface: trimesh.Trimesh, near: Near | None) -> NDArray[np.bool_] | None:
    """Which vertices are on the contact face; None for all of them."""
    is_contact = None if near is None else near(np.asarray(surface.vertices), np.asarray(surface.faces))
    if is_contact is not None and not is_contact.any():
        raise ValueError(
            "no corner of a triangle of the surface lies in the place given as contact, and only whole "
            "triangles may touch: split the triangles of the surface along the edges of that place"
        )
    return is_contact


def _check_count(surface: trimesh.Trimesh, is_contact: NDArray[np.bool_] | None, size: float) -> None:
    """Refuses a mesh too large for the memory before it is made."""
    try:
        check_unknowns(_expected(surface, is_contact, size))
    except ValueError as error:
        extent = float(np.ptp(surface.vertices, axis=0).max())
        doubt = f'. The body is {extent:g} m large: if that is millimetres, say unit="mm"'
        raise ValueError(f"size is {size:g} m: {error}{doubt if extent > SUSPICIOUS_SIZE else ''}") from None


def _expected(surface: trimesh.Trimesh, is_contact: NDArray[np.bool_] | None, size: float) -> float:
    """About how many tetrahedra fill the surface: regular ones, of the sizes asked for."""
    regular = 1.0 / (6.0 * np.sqrt(2.0)) * size**3
    chosen = slice(None) if is_contact is None else is_contact[surface.faces].all(axis=1)
    area = float(surface.area_faces[chosen].sum())
    # the size grows by GROWTH of the distance: the integral of 1 / size^3 up to FAR
    near = area * size * 0.5 / GROWTH * (1.0 - FAR**-2)
    volume = abs(float(surface.volume))
    return float(min(volume, near + volume / FAR**3) / regular)


@contextlib.contextmanager
def _gmsh(purpose: str) -> Iterator[Any]:
    """gmsh, in a process of its own."""
    with contextlib.ExitStack() as stack:
        with extra_mesh(purpose):
            gmsh = stack.enter_context(gmsh_beside())
        yield gmsh


def _gmsh_tetrahedra(
    gmsh: Any, surface: trimesh.Trimesh, is_contact: NDArray[np.bool_] | None, size: float
) -> tuple[Array, Index]:
    tag = gmsh.model.addDiscreteEntity(2)
    # in sizes of the contact mesh: gmsh's tolerances are absolute
    numbers = np.arange(1, len(surface.vertices) + 1)
    gmsh.model.mesh.addNodes(2, tag, numbers, (surface.vertices / size).ravel())
    gmsh.model.mesh.addElementsByType(tag, 2, [], (surface.faces + 1).ravel())
    gmsh.model.mesh.classifySurfaces(FEATURE_ANGLE, True, True, np.pi)
    gmsh.model.mesh.createGeometry()
    surfaces = [tag for _, tag in gmsh.model.getEntities(2)]
    gmsh.model.geo.addVolume([gmsh.model.geo.addSurfaceLoop(surfaces)])
    gmsh.model.geo.synchronize()
    at_contact = []
    for tag in surfaces:
        # parts of the surface with a whole triangle on the contact face
        corners = gmsh.model.mesh.getElementsByType(2, tag)[1].reshape(-1, 3).astype(np.int64) - 1
        if is_contact is None or is_contact[corners].all(axis=1).any():
            at_contact.append(tag)
    _grow_away(gmsh, at_contact, 1.0)
    _set_sizes(gmsh, 0.0, FAR, 0)
    gmsh.model.mesh.generate(3)
    nodes, cells = _elements(gmsh, 4, 4)
    if not cells.size:
        raise ValueError("no tetrahedron was made")
    return nodes * size, cells


def _grow_away(gmsh: Any, at_contact: list[int], size: float) -> None:
    """Elements of `size` at these faces, larger ones away from them."""
    if not at_contact:
        raise ValueError("no triangle of the surface lies on the contact face")
    distance = gmsh.model.mesh.field.add("Distance")
    gmsh.model.mesh.field.setNumbers(distance, "SurfacesList", at_contact)
    gmsh.model.mesh.field.setNumber(distance, "Sampling", 60)
    grown = gmsh.model.mesh.field.add("MathEval")
    growth = f"{size} + Min({(FAR - 1.0) * size}, {GROWTH} * F{distance})"
    gmsh.model.mesh.field.setString(grown, "F", growth)
    gmsh.model.mesh.field.setAsBackgroundMesh(grown)
    gmsh.option.setNumber("Mesh.Algorithm3D", 1)
    gmsh.option.setNumber("Mesh.Optimize", 1)


def _set_sizes(gmsh: Any, least: float, most: float, a_turn: int) -> None:
    """What bounds the size of elements besides the growth; options of gmsh outlive a session."""
    options = {"Min": least, "Max": most, "FromCurvature": a_turn, "ExtendFromBoundary": 0, "FromPoints": 0}
    for name, value in options.items():
        gmsh.option.setNumber(f"Mesh.MeshSize{name}", value)


def _elements(gmsh: Any, kind: int, corners: int) -> tuple[Array, Index]:
    """Nodes (n, 3) and elements (m, corners) of one of gmsh's kinds, nodes of others left out."""
    tags, coordinates, _ = gmsh.model.mesh.getNodes()
    used, cells = np.unique(gmsh.model.mesh.getElementsByType(kind)[1], return_inverse=True)
    order = np.argsort(tags)
    rows = order[np.searchsorted(tags[order], used)]
    return coordinates.reshape(-1, 3)[rows], cells.reshape(-1, corners).astype(np.int64)
