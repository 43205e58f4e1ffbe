# SPDX-License-Identifier: MIT OR Apache-2.0
"""Elastic bodies of finite elements: supports, condensation onto the contact, recovery of the inside."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, fields, replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any
from weakref import WeakValueDictionary

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .. import _mtb_rs
from ..base import cache
from ..base.check import shortened, warn
from ..base.owning import own, solved
from ..base.plain import one_line, plain
from ..base.questions import ask
from ..base.words import Unit
from ..geometry.contact_points import ContactPoints, Patch
from ..geometry.triangles import Surface
from .constants import OfMaterial
from .material import Material
from .mesh import SUSPICIOUS_SIZE, UNMOVED, UNTURNED, TetraMesh, check_unknowns, placed, quadratic
from .sole import underside
from .supports import Support, Where, is_box, place_in_words, select

if TYPE_CHECKING:
    from .mesh_files import MeshSource


def of_body(name: str, size: float) -> list[str]:
    """Questions about the `size` [m] of a mesh."""
    if size > SUSPICIOUS_SIZE:
        return [f'{name} is {size:g} m large: is its mesh in millimetres? Then say unit="mm"']
    return []


Array = NDArray[np.float64]
Index = NDArray[np.int64]


#: Poisson's ratio over which tetrahedra of four nodes lock: a quarter too stiff at 0.49, sevenfold at 0.4999.
LOCKING = 0.45

#: Share by which the area of a contact face may miss that of the function that gives it.
BORDER = 0.03


@dataclass(frozen=True)
@plain
class Condensed:
    """A body condensed onto contact points, in the frame (tangential 1, tangential 2, into) of each.

    Attributes
    ----------
    weights : (n,) [m2]
        Area of each contact point, the integral of its basis function.
    flexibility : (6, n, n) [m3/Pa]
        Blocks 11, 22, nn, 12, 1n, 2n; the compliance is a block over the weight of the observed point. Of the
        points of the condensation, where the contact points are finer.
    mode_names : tuple of str
        Rigid motions that the supports leave free and contact must hold.
    modes : (m, 9)
        Translation, rotation and reference point of each.
    mode_displacement : (m, 3, n)
        Of the contact points by a unit of each mode; the generalised load
        of a traction t on it is the sum of weights * mode_displacement * t.
    case_displacement : (k, 3, n)
        Of the contact points by a unit of each support component: displacement [m], or force on a guide [N].
    case_work : (k, m)
        Generalised load of a unit of each support component on each mode; zero unless guided.
    spread_displacement : (6, 3, n)
        Of the contact points by a unit force [N] along and moment [N m] about x, y, z through `centre`,
        spread over the body as weight and inertia are.
    centre : (3,) [m]
        Of volume.
    contact_resultant : (6, 3, n)
        Force and moment about the origin of a unit traction of each contact point.
    reaction : (s, 6, 3, n)
        Force and moment about the origin of each support on the body by a unit traction of each contact
        point: stiffness times displacement less load, on the nodes it holds.
    case_reaction, spread_reaction : (s, 6, k), (s, 6, 6)
        The same by a unit of each support component and of each spread load.
    cost : Mapping
        Unknowns, entries and operations of the factorisation, seconds by stage.
    origin : "built", "disk" or "memory"
    refined : Compliance or None
        On finer contact points than those of the condensation.
    """

    weights: Array
    flexibility: Array
    mode_names: tuple[str, ...]
    modes: Array
    mode_displacement: Array
    case_displacement: Array
    case_work: Array
    spread_displacement: Array
    centre: Array
    contact_resultant: Array
    reaction: Array
    case_reaction: Array
    spread_reaction: Array
    cost: Mapping[str, float]
    origin: str
    refined: _mtb_rs.Compliance | None = None

    @property
    def operations(self) -> float:
        """Floating-point operations of the condensation."""
        return float(sum(self.cost[f"{stage}_flops"] for stage in ("factor", "forward", "product")))

    @cached_property
    def compliance(self) -> _mtb_rs.Compliance:
        """Traction in, displacement out."""
        return self.refined or _mtb_rs.flexibility(self.weights, self.flexibility)

    def spread_work(self, wrench: Array) -> Array:
        """Generalised load (m,) of a spread force and moment about `centre` (6,) on each mode."""
        rotation = self.modes[:, 3:6]
        moved = self.modes[:, :3] + np.cross(rotation, self.centre - self.modes[:, 6:])
        return np.asarray(moved @ wrench[:3] + rotation @ wrench[3:])


def _can_be(arrays: cache.Arrays, n: int) -> bool:
    """Whether these are the arrays of a body condensed onto n points."""
    counted = ("mode_names", "case_work", "reaction")
    if not all(name in arrays and arrays[name].ndim for name in (*counted, "cost_names")):
        return False
    names, cases, supports = (arrays[name] for name in counted)
    m, k, s = len(names), len(cases), len(supports)
    shapes = {
        "weights": (n,),
        "flexibility": (6, n, n),
        "modes": (m, 9),
        "mode_displacement": (m, 3, n),
        "case_displacement": (k, 3, n),
        "case_work": (k, m),
        "spread_displacement": (6, 3, n),
        "centre": (3,),
        "contact_resultant": (6, 3, n),
        "reaction": (s, 6, 3, n),
        "case_reaction": (s, 6, k),
        "spread_reaction": (s, 6, 6),
    }
    labels = ("mode_names", "cost_names")
    return (
        set(arrays) == {*shapes, *labels, "cost"}
        and all(
            arrays[name].dtype == np.float64
            and arrays[name].shape == shape
            and bool(np.isfinite(arrays[name]).all())
            for name, shape in {**shapes, "cost": arrays["cost_names"].shape}.items()
        )
        and all(arrays[name].dtype.kind == "U" and arrays[name].ndim == 1 for name in labels)
    )


@dataclass(frozen=True)
@plain
class Balance:
    """What loads amount to on a body, and what its supports answer: (fx, fy, fz, mx, my, mz), [N] and [N m].

    Moments are about the origin. In equilibrium all that act on a body add up to nothing; where supports
    leave it free, only a contact that holds it does that.

    Attributes
    ----------
    contact : (6, 3, n)
        Of a unit traction of each contact point.
    reaction : (s, 6, 3, n)
        Of each support by a unit traction of each contact point.
    given : (s, 6)
        Of each support by what it is given and by the spread load.
    spread : (6,)
        The spread load.
    supports : tuple of str
    """

    contact: Array
    reaction: Array
    given: Array
    spread: Array
    supports: tuple[str, ...]

    def of(self, traction: Array) -> tuple[Array, dict[str, Array]]:
        """Resultant (6,) of a traction (3, n) [Pa], and reaction (6,) of each support to all loads."""
        answers = self.given + np.einsum("skcn,cn->sk", self.reaction, traction)
        return np.einsum("kcn,cn->k", self.contact, traction), dict(zip(self.supports, answers, strict=True))


@dataclass(frozen=True, eq=False)
class _Core:
    """A body in the compiled core, for as long as one that needs it lives."""

    core: _mtb_rs.TetraBody


_CORES: WeakValueDictionary[str, _Core] = WeakValueDictionary()


@solved
@dataclass(frozen=True)
@plain
class BodyState:
    """The whole of a loaded body.

    Attributes
    ----------
    displacement : (3, N) [m]
        Of the nodes.
    reactions : Mapping of names to (3,) [N]
        Force of each support on the body.
    moments : Mapping of names to (3,) [N m]
        Moment of each support on the body about the origin.
    left_over : float [N]
        Largest force left unbalanced on a free node.
    """

    body: ElasticBody
    displacement: Array
    reactions: Mapping[str, Array]
    moments: Mapping[str, Array]
    left_over: float

    @cached_property
    def _stress(self) -> tuple[Array, Array]:
        return self.body.core.stress(self.displacement)

    @property
    def stress(self) -> Array:
        """Stress (6, N) [Pa] at the nodes: xx, yy, zz, yz, xz, xy."""
        return self._stress[0]

    @property
    def von_mises(self) -> Array:
        """Von Mises' equivalent stress (N,) [Pa] at the nodes."""
        return self._stress[1]

    def at(self, points: Array) -> Array:
        """Displacement (3, n) [m] at `points` (3, n) [m] of the contact face.

        These are values at the points themselves, while a condensed body gives means over the hats around the
        points. The two differ at the edges of the face.
        """
        body = self.body
        reach = 0.02 * float(np.ptp(body.mesh.nodes, axis=0).max())
        places = np.ascontiguousarray(np.asarray(points, dtype=float).reshape(3, -1).T)
        return body.core.displacement_at(self.displacement, places, body.contact_faces, reach)

    @property
    def surface(self) -> Surface:
        """The deformed boundary with its stress, for pictures."""
        plain = self.body.surface()
        used = self.body.surface_nodes
        return replace(plain, displacement=self.displacement[:, used], von_mises=self.von_mises[used])


@dataclass(frozen=True, eq=False)
class ElasticBody(OfMaterial):
    """An elastic body of finite elements, its contact face and its supports.

    Parameters
    ----------
    mesh : TetraMesh
        :meth:`from_mesh` takes meshes of other libraries, and files.
    material : Material
    contact
        Place where the body may touch, one of the forms of `where` in :class:`Support`: the boundary
        triangles with all corners there. A warning comes if a function or a box covers more of the surface
        than these triangles. "bottom" and "top" are the whole underside and upper side, which may be curved
        or slotted: the triangles at the lowest height, and all that go on from the lowest point without an
        edge while they are less than 40 degrees steep. Chamfers are none of it. Of a side that is mostly flat
        only what lies between its flat parts is added, so that its rounded edges are none of it either.
    supports : sequence of Support
        Supports of the body. The contact must hold all motions that the supports leave free; a motion that it
        cannot hold is an error.
    name : str
        For reports and files; two bodies of one name become "upper <name>" and "lower <name>" in a scene.
    linear : bool
        Whether tetrahedra of four nodes are kept, with a warning: they are far too stiff in bending and at
        high Poisson's ratios. Otherwise they get nodes in the middle of their straight edges, which are
        numbered after those of the mesh.
    """

    mesh: TetraMesh
    material: Material
    contact: Where = "contact"
    supports: Sequence[Support] = ()
    name: str = "body"
    linear: bool = False
    _nodes: dict[int, Index] = field(default_factory=dict, init=False, repr=False, compare=False)
    #: What its mesh was made of, where that is known.
    _source: MeshSource | None = field(default=None, init=False, repr=False)

    __repr__ = one_line

    def __post_init__(self) -> None:
        if not isinstance(self.mesh, TetraMesh):
            raise ValueError(
                f"mesh is {shortened(self.mesh)}: a TetraMesh is needed; ElasticBody.from_mesh takes meshes "
                "of trimesh, meshio and pyvista, and files, with the same arguments"
            )
        if not isinstance(self.material, Material):
            raise ValueError(f"material is {self.material!r}: a Material is needed")
        if isinstance(self.supports, (str, Support)) or not isinstance(self.supports, Sequence):
            raise ValueError(f"supports is {self.supports!r}: a list of Support objects is needed")
        if not isinstance(self.name, str) or not self.name:
            raise ValueError(f"name is {self.name!r}: a word is needed")
        own(self)
        for support in self.supports:
            if not isinstance(support, Support):
                raise ValueError(f"supports contain {support!r}: Support objects are needed")
        wrong = ~np.isfinite(self.mesh.nodes).all(axis=1)
        if wrong.any():
            node = int(np.argmax(wrong))
            place = self.mesh.nodes[node].tolist()
            raise ValueError(f"node {node} of the mesh is {place}: finite numbers are needed")
        size = float(np.ptp(self.mesh.nodes, axis=0).max())
        ask(of_body(self.name, size))
        self._make_quadratic()
        self._check_values()
        _ = self.core
        _ = self.contact_faces
        if callable(self.contact) or is_box(self.contact):
            self._check_border()

    def _make_quadratic(self) -> None:
        """Nodes in the middle of the edges, unless they are there or not wanted."""
        cells = np.asarray(self.mesh.cells)
        if cells.ndim != 2 or cells.shape[1] != 4 or not cells.size:
            return
        if not self.linear and cells.min() >= 0 and cells.max() < len(self.mesh.nodes):
            try:
                check_unknowns(len(cells))
            except ValueError as error:
                raise ValueError(f"{self.name} with nodes in the middle of its edges: {error}") from None
            object.__setattr__(self, "mesh", quadratic(self.mesh))
        elif self.linear:
            ratio = self.material.poisson_ratio
            locks = f", and above poisson_ratio = {LOCKING:g} they lock (it is {ratio:g})"
            warn(
                f"{self.name} keeps tetrahedra of four nodes (linear=True): they are too stiff, by half "
                f"in bending{locks if ratio > LOCKING else ''}; without linear=True they get nodes in the "
                "middle of their edges"
            )

    def __getstate__(self) -> dict[str, Any]:
        """The body without what can be made again from it."""
        names = [f.name for f in fields(self) if f.init]
        return {**{name: getattr(self, name) for name in names}, "_nodes": {}, "content": self.content}

    @cached_property
    def content(self) -> str:
        """Hash of all that the contact can know of the body; the same in any process."""
        parts: dict[str, Any] = {
            "nodes": np.asarray(self.mesh.nodes, dtype=np.float64),
            "cells": np.asarray(self.mesh.cells, dtype=np.int64),
            "material": (self.material.young_modulus, self.material.poisson_ratio),
            "contact": self.contact_faces,
        }
        for k, support in enumerate(self.supports):
            parts[f"support {k}"] = (support.name, support.values)
            parts[f"support {k} nodes"] = self.support_nodes(k)
        return cache.content_key(parts)

    @classmethod
    def from_mesh(
        cls,
        path_or_mesh: Any,
        material: Material,
        unit: Unit = "m",
        contact: Where = "bottom",
        supports: Sequence[Support] = (),
        size: float | None = None,
        name: str = "body",
        linear: bool = False,
        rotation: ArrayLike = UNTURNED,
        shift: ArrayLike = UNMOVED,
    ) -> ElasticBody:
        """Body from a file or a mesh.

        Parameters
        ----------
        path_or_mesh
            Solid of CAD (STEP, IGES) or closed surface (any file trimesh reads, or an object of trimesh,
            meshio or pyvista), which gmsh fills with tetrahedra; ready tetrahedra (any file meshio reads, or
            an object of meshio or pyvista); or a TetraMesh.
        material : Material
        unit : "m", "mm", "um" or "in"
            Unit of the numbers in the file, which STL files do not state. STEP and IGES files state it; keep
            "m" for them.
        contact, supports
            As in :class:`ElasticBody`, in metres. The contact face consists of whole triangles, so its edges
            must be edges of the surface.
        size : float [m]
            Size of the tetrahedra at the contact face, for solids and surfaces; they grow away from it. On
            curved faces of solids the tetrahedra are curved, with their nodes on the true face, and they are
            smaller where the face is strongly curved.
        name : str
            For reports and files.
        linear : bool
            Whether ready tetrahedra of four nodes are kept; see :class:`ElasticBody`.
        rotation : (3, 3)
            Turns a part with other axes: its columns are the directions in which the axes of the file then
            point. `contact` and `supports` are places after the turn.
        shift : (3,) [m]
            Added after the turn.
        """
        from .mesh_files import MeshSource, read_mesh  # brings trimesh

        place = placed(rotation, shift)

        def near(vertices: Array, triangles: Index) -> NDArray[np.bool_]:
            return _at_contact(place(vertices), triangles, contact)

        mesh = read_mesh(path_or_mesh, unit, size=size, near=near)
        body = cls(mesh.moved(rotation, shift), material, contact, supports, name, linear)
        object.__setattr__(body, "_source", MeshSource.of(path_or_mesh, unit, size, mesh, place))
        return body

    @property
    def size(self) -> float | None:
        """Size [m] of the tetrahedra that its solid or surface was filled with; None for a mesh as given.

        A copy with another mesh or other supports (`dataclasses.replace`), and one from another process,
        count as given.
        """
        return None if self._source is None else self._source.size

    def resized(self, size: float) -> ElasticBody:
        """The same solid or surface, filled with tetrahedra of another size [m] at its contact.

        Raises
        ------
        ValueError
            If its mesh was given, the file has changed since, or it cannot be filled so.
        """
        if self._source is None:
            raise ValueError(
                f"{self.name} has no size: its mesh was given as it is; a body from a STEP, IGES or STL "
                "file, or from another closed surface, can be meshed again"
            )
        mesh = self._source.mesh(size, lambda points, faces: _at_contact(points, faces, self.contact))
        body = replace(self, mesh=mesh)
        object.__setattr__(body, "_source", replace(self._source, size=float(size)))
        return body

    def named(self, name: str) -> ElasticBody:
        """The same body, with all that is known of it, under another name."""
        twin = object.__new__(type(self))
        twin.__dict__.update(self.__dict__, name=name)
        return twin

    @cached_property
    def core_mesh(self) -> _mtb_rs.TetraMesh:
        """The checked mesh in the compiled core."""
        return self.mesh.checked()

    @cached_property
    def core(self) -> _mtb_rs.TetraBody:
        """The body in the compiled core; factorised when first needed."""
        return self._shared.core

    @cached_property
    def _shared(self) -> _Core:
        """What all living bodies share that differ by no more than their loads and contact faces."""
        words = [(s.name, self.support_nodes(k).tolist(), s.words) for k, s in enumerate(self.supports)]
        elastic = self.material.shear_modulus, self.material.poisson_ratio
        parts: dict[str, Any] = {
            "nodes": np.asarray(self.mesh.nodes, dtype=np.float64),
            "cells": np.asarray(self.mesh.cells),
            "material": elastic,
            "supports": words,
        }
        key = cache.content_key(parts)
        shared = _CORES.get(key)
        if shared is None:
            shared = _Core(_mtb_rs.TetraBody(self.core_mesh, *elastic, words))  # type: ignore[arg-type]
            _CORES[key] = shared
        return shared

    @cached_property
    def faces(self) -> NDArray[np.uintp]:
        """Triangles (f, 3) or (f, 6) of the boundary, counter-clockwise seen from outside."""
        return self.core_mesh.faces()

    @cached_property
    def contact_faces(self) -> NDArray[np.uintp]:
        """Numbers of the boundary triangles of the contact face."""
        if _is_side(self.contact) and self.contact not in self.mesh.node_sets:
            found = np.flatnonzero(_side(self.mesh.nodes, self.faces.astype(np.int64), str(self.contact)))
            if not found.size:
                raise ValueError(
                    f"contact of {self.name} is {self.contact!r}, but no triangle of its surface looks that "
                    "way there: turn the body (rotation=), or give a box, a function or a set of nodes"
                )
            return found.astype(np.uintp)
        chosen = self.nodes_at("contact", self.contact)
        inside = np.zeros(len(self.mesh.nodes), dtype=bool)
        inside[chosen] = True
        found = np.flatnonzero(inside[self.faces[:, :3]].all(axis=1))
        if found.size == 0:
            raise ValueError(
                f"contact of {self.name}, {place_in_words(self.contact)}, contains {chosen.size} nodes, but "
                "no triangle of the surface has all its corners among them: a larger place or a finer mesh "
                "is needed"
            )
        return found.astype(np.uintp)

    @property
    def case_values(self) -> Array:
        """What the support components are given (k,): displacement [m], or force on a guide [N]."""
        return np.array([self.supports[k].given[component] for k, component, _ in self.core.cases])

    def support_nodes(self, support: int) -> Index:
        """Nodes of one of the supports."""
        if support not in self._nodes:
            what = f"support {self.supports[support].name!r}"
            self._nodes[support] = self.nodes_at(what, self.supports[support].where)
        return self._nodes[support]

    def nodes_at(self, what: str, where: Where) -> Index:
        """Numbers of the nodes at a place; `what` is for the message if there are none."""
        try:
            found = np.flatnonzero(select(self.mesh.nodes, self.mesh.node_sets, where))
        except ValueError as error:
            raise ValueError(f"{what} of {self.name}: {error}") from None
        if found.size == 0:
            raise ValueError(
                f"{what} of {self.name}, {place_in_words(where)}, contains no node of the mesh: a place with "
                "nodes is needed"
            )
        return found.astype(np.int64)

    @cached_property
    def unknowns(self) -> int:
        """Number of the unknown displacements of its finite elements."""
        held = np.zeros((len(self.mesh.nodes), 3), dtype=bool)
        for support, component, _ in self.core.cases:
            held[self.support_nodes(support), component] = True
        # a guide moves all its nodes by one unknown; each motion that is left free is pinned at one component
        guides = sum(is_guided for *_, is_guided in self.core.cases)
        return int((~held).sum()) + guides - len(self.core.modes((0.0, 0.0, 0.0))[0])

    @cached_property
    def has_mirror(self) -> bool:
        """Whether it is its own mirror image, of which one half is factorised."""
        return self.core.has_mirror

    def _check_values(self) -> None:
        """Two supports that prescribe the same component of a node must agree."""
        for component in range(3):
            seen = np.full(len(self.mesh.nodes), np.nan)
            for k, support in enumerate(self.supports):
                if component not in support.prescribed:
                    continue
                value = support.prescribed[component]
                nodes = self.support_nodes(k)
                clash = nodes[~np.isnan(seen[nodes]) & (seen[nodes] != value)]
                if clash.size:
                    raise ValueError(
                        f"support {support.name!r} gives {'xyz'[component]} = {value:g} m at node "
                        f"{clash[0]}, and another support gives {seen[clash[0]]:g} m there: supports that "
                        "share a node must agree"
                    )
                seen[nodes] = value

    def _check_border(self) -> None:
        """Warns if whole triangles follow the border of a contact given as a function or a box badly."""
        corners = self.mesh.nodes[self.faces[:, :3].astype(np.int64)]
        double = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        chosen = np.zeros(len(corners), dtype=bool)
        chosen[self.contact_faces] = True
        # what looks elsewhere, such as side walls within a tolerance, is not meant
        outlook = double[chosen].sum(axis=0)
        alike = double @ outlook > 0.7 * np.linalg.norm(double, axis=1) * np.linalg.norm(outlook)
        fine = 6  # points within a triangle: the middles of its 36 parts, but for those upside down
        i, j = np.nonzero(np.add.outer(np.arange(fine), np.arange(fine)) < fine)
        share = np.stack([i + 1 / 3, j + 1 / 3, fine - i - j - 2 / 3]) / fine
        # on curved elements: a function may be as tight as the face itself
        whole = self.mesh.nodes[self.faces[alike].astype(np.int64)]
        points = np.einsum("kp,fkc->fpc", self.face_shape(share.T), whole)
        inside = select(points.reshape(-1, 3), {}, self.contact).reshape(points.shape[:2]).mean(axis=1)
        area = 0.5 * np.linalg.norm(double, axis=1)
        meant, taken = float(inside @ area[alike]), float(area[chosen & alike].sum())
        place = "function" if callable(self.contact) else "box"
        # of a curved face chords tell too little: triangles that cover more lose nothing
        if taken < (1.0 - BORDER) * meant:
            warn(
                f"the {place} given as contact of {self.name} covers {meant:.4g} m2 of its surface, but the "
                f"triangles that lie wholly in it cover {taken:.4g} m2, and only whole triangles can touch: "
                f"split the triangles of the mesh along the border of the {place}, or take a finer mesh"
            )

    def sample(self, points: ContactPoints, patches: Sequence[Patch], *, upper: bool) -> _mtb_rs.Sampling:
        """Hats on the grids of the contact points, sampled on the contact face.

        Parameters
        ----------
        points : ContactPoints
            Places of the hats, the nodes of the grids.
        patches : sequence of Patch
            The grids.
        upper : bool
            Whether this is the upper body: into it is along the normal of the points, otherwise against it.
        """
        into = points.normal if upper else -points.normal
        frames = np.stack([points.tangent_x, points.tangent_y, into]).transpose(2, 0, 1)
        parts = []
        for patch in patches:
            cut = patch.cut
            parts.append(
                self.core_mesh.sample(
                    (patch.nx, patch.ny),
                    patch.spacing,
                    np.ascontiguousarray(points.points[:, cut].T),
                    np.ascontiguousarray(frames[cut]),
                    self.contact_faces,
                )
            )
        return _mtb_rs.Sampling.joined(parts)

    def heights(self, sampling: _mtb_rs.Sampling) -> Array:
        """Height z (q,) [m] of the face at the quadrature points of a sampling; curved elements count."""
        arrays = sampling.arrays()
        shape = self.face_shape(arrays["barycentric"])
        z = self.mesh.nodes[self.faces[arrays["face"].astype(np.int64)].astype(np.int64), 2]
        return np.asarray(np.einsum("kq,qk->q", shape, z))

    def face_shape(self, barycentric: Array) -> Array:
        """Shape functions (3, q) or (6, q) of the triangles of its boundary at barycentric (q, 3)."""
        a, b, c = barycentric.T
        shape = np.stack([a, b, c])
        if self.faces.shape[1] == 3:
            return shape
        corner = shape * (2.0 * shape - 1.0)
        return np.concatenate([corner, 4.0 * np.stack([a * b, b * c, c * a])])

    def condense(
        self, sampling: _mtb_rs.Sampling, *, keep: bool = True, directory: str | Path | None = None
    ) -> Condensed:
        """The body as its contact points see it, from the cache if it is there.

        Ctrl-C is answered between the stages and inside assembly, factorisation, substitutions and products;
        nested dissection and each of the two stages of the symbolic factorisation are one piece.

        Parameters
        ----------
        sampling : Sampling
            Traction basis on the contact face; see :meth:`sample`.
        keep : bool
            False: neither look into the cache nor add to it.
        directory : path
            Folder of the cache; see :func:`mtb_rs.base.cache.folder`.

        Raises
        ------
        ValueError
            If neither the supports nor the contact hold the body, if a contact point has no area, or if
            the mesh is too large.
        """
        arrays, origin = (
            cache.fetch(
                self._key(sampling),
                lambda: self._build(sampling),
                cache.folder(directory),
                lambda found: _can_be(found, sampling.n_points),
            )
            if keep
            else (self._build(sampling), "built")
        )
        cost = dict(zip(arrays["cost_names"].tolist(), arrays["cost"].tolist(), strict=True))
        fields: dict[str, Any] = {
            k: v for k, v in arrays.items() if k not in ("cost", "cost_names", "mode_names")
        }
        return Condensed(**fields, mode_names=tuple(arrays["mode_names"].tolist()), cost=cost, origin=origin)

    def _build(self, sampling: _mtb_rs.Sampling) -> cache.Arrays:
        out = self.core.condense(sampling)
        cost = out.pop("cost")
        out["cost_names"] = np.array(list(cost))
        out["cost"] = np.array(list(cost.values()), dtype=float)
        out["mode_names"] = np.array(out["mode_names"], dtype=np.str_)
        return out

    def _key(self, sampling: _mtb_rs.Sampling) -> str:
        parts: dict[str, Any] = {
            # changes by itself with the code that condenses
            "code": _mtb_rs.CONDENSATION_DIGEST,
            "nodes": np.asarray(self.mesh.nodes, dtype=np.float64),
            "cells": np.asarray(self.mesh.cells, dtype=np.int64),
            "material": (self.material.young_modulus, self.material.poisson_ratio),
            "points": sampling.n_points,
        }
        parts.update({f"sampling {name}": value for name, value in sampling.arrays().items()})
        for k, support in enumerate(self.supports):
            parts[f"support {k}"] = support.words
            parts[f"support {k} nodes"] = self.support_nodes(k)
        return cache.content_key(parts)

    def given_displacement(self, condensed: Condensed) -> Array:
        """Displacement (3, n) of the contact points by what the supports are given, their own frame."""
        return np.asarray(np.einsum("k,kcn->cn", self.case_values, condensed.case_displacement))

    def given_work(self, condensed: Condensed) -> Array:
        """Generalised load (m,) of the forces on the guides on each free motion."""
        return np.asarray(self.case_values @ condensed.case_work)

    def balance(self, condensed: Condensed, spread: Array) -> Balance:
        """Loads and reactions with a spread force and moment about the centre of volume (6,)."""
        given = condensed.case_reaction @ self.case_values + condensed.spread_reaction @ spread
        about_origin = spread.copy()
        about_origin[3:] += np.cross(condensed.centre, spread[:3])
        return Balance(
            condensed.contact_resultant, condensed.reaction, given, about_origin, self.support_names
        )

    @property
    def support_names(self) -> tuple[str, ...]:
        """Names of the supports, numbered where there are several."""
        if len(self.supports) == 1:
            return (self.supports[0].name,)
        return tuple(f"{k + 1} {s.name}" for k, s in enumerate(self.supports))

    def recover(
        self,
        sampling: _mtb_rs.Sampling,
        modes: Array,
        traction: Array,
        motion: Array,
        force: Array | None = None,
    ) -> BodyState:
        """The whole body under its contact tractions, its supports and its rigid motion.

        Parameters
        ----------
        modes : (m, 9)
            The rigid motions the supports leave free; see :attr:`Condensed.modes`.
        traction : (3, n) [Pa]
            All tractions on the contact points, frame of the sampling.
        motion : (m,)
            Amplitudes of the free motions.
        force : (3, N) [N]
            Other forces on the nodes.
        """
        u, load = self.moved(sampling, modes, traction, motion, force)
        forces, moments, left_over = self.core.reactions(u, load, (0.0, 0.0, 0.0))
        return BodyState(
            body=self,
            displacement=u,
            reactions=dict(zip(self.support_names, forces, strict=True)),
            moments=dict(zip(self.support_names, moments, strict=True)),
            left_over=left_over,
        )

    def moved(
        self,
        sampling: _mtb_rs.Sampling,
        modes: Array,
        traction: Array,
        motion: Array,
        force: Array | None = None,
    ) -> tuple[Array, Array]:
        """Displacement (3, N) [m] and load (3, N) [N] of the nodes; see :meth:`recover`."""
        load = self.core.contact_force(sampling, np.ascontiguousarray(traction, dtype=float))
        if force is not None:
            load = load + force
        u = self.core.solve(load, self.case_values, modes, np.ascontiguousarray(motion, dtype=float))
        return u, load

    @cached_property
    def surface_nodes(self) -> Index:
        """Numbers of the corners on the boundary."""
        return np.unique(self.faces[:, :3]).astype(np.int64)

    @property
    def is_inverse_to_modulus(self) -> bool:
        """Whether all displacements are inverse to Young's modulus, since no support displaces it."""
        values = [value for support in self.supports for value in support.values]
        return not any(np.isscalar(value) and value != 0.0 for value in values)

    def described(self) -> dict[str, Any]:
        """What `summary.json` tells of it."""
        names = ("name", "mesh", "material", "contact", "supports", "linear")
        return {"kind": "ElasticBody", **{name: getattr(self, name) for name in names}}

    def kept(self) -> None:
        """A saved result keeps its nodes, displacements and stresses, not what was given."""

    def surface(self) -> Surface:
        """The boundary, for pictures."""
        used = self.surface_nodes
        triangles = np.searchsorted(used, self.faces[:, :3].astype(np.int64))
        return Surface(self.name, np.ascontiguousarray(self.mesh.nodes[used].T), triangles.astype(np.int64))


def _is_side(where: Where) -> bool:
    """Whether a place is the underside or the upper side as a whole, which may be curved."""
    return isinstance(where, str) and where in ("bottom", "top")


def _side(nodes: Array, faces: Index, side: str) -> NDArray[np.bool_]:
    """Which triangles (f, 3) or (f, 6) are the underside ("bottom") or the upper side ("top") of a body."""
    if side == "bottom":
        return underside(nodes, faces)
    # upside down; a mirror turns the triangles round as well
    mirrored = nodes * np.array([1.0, 1.0, -1.0])
    order = [0, 2, 1] if faces.shape[1] == 3 else [0, 2, 1, 5, 4, 3]
    return underside(mirrored, faces[:, order])


def _at_contact(nodes: Array, faces: Index, where: Where) -> NDArray[np.bool_]:
    """Which corners (n, 3) [m] of a closed surface are at the place of a contact."""
    if not _is_side(where):
        return select(nodes, {}, where)
    found = np.zeros(len(nodes), dtype=bool)
    found[faces[_side(nodes, faces, str(where))].ravel()] = True
    return found
