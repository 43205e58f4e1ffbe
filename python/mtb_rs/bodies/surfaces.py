# SPDX-License-Identifier: MIT OR Apache-2.0
"""Surfaces of bodies and the gap between any two of them. SI units, z up."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .. import _mtb_rs
from ..base.check import path_of, reals, shortened
from ..base.files import check_surface_file, check_triangles
from ..base.owning import owning
from ..base.plain import plain
from ..base.renamed import renamed
from ..base.units import taking_quantities
from ..base.words import Unit
from ..geometry.contact_points import ContactGrid, contact_grid, spacing_pair
from ..geometry.profile_files import metres
from ..geometry.profiles import Profile, as_profile

Array = NDArray[np.float64]

#: Most triangles of a surface: each takes about 10 us and 1 kB.
MOST_TRIANGLES = 1_000_000


class BodySurface:
    """Surface of a body, placed in the common frame.

    A lower body lies below its surface, an upper body above it. Use the class methods to make a surface.

    Examples
    --------
    >>> ball = BodySurface.paraboloid(0.08)
    >>> round(float(ball.top(2e-3, 0.0)) * 1e6, 6)
    25.0
    """

    __slots__ = ("_core", "_recipe", "_seen_from_below", "name")

    _core: _mtb_rs.BodySurface
    name: str

    def __init__(self, core: _mtb_rs.BodySurface, name: str, recipe: tuple[Any, ...]) -> None:
        self._core = core
        self._recipe = recipe
        self._seen_from_below: _mtb_rs.BodySurface | None = None
        self.name = name

    def __reduce__(self) -> tuple[Any, ...]:
        return _made, self._recipe

    def __repr__(self) -> str:
        return f"BodySurface({self.name!r})"

    @classmethod
    def plane(cls, height: float = 0.0) -> BodySurface:
        """The plane z = `height` [m]."""
        return cls(_mtb_rs.BodySurface.plane(height), "plane", ("plane", height))

    @classmethod
    def block(cls, length: float, width: float, height: float = 0.0) -> BodySurface:
        """Face z = `height` [m] of a block of `length` along x and `width` along y, about the origin."""
        core = _mtb_rs.BodySurface.block((length, width), height)
        return cls(core, "block", ("block", length, width, height))

    @classmethod
    def paraboloid(cls, radius: float, radius_y: float | None = None) -> BodySurface:
        """z = x^2 / (2 radius) + y^2 / (2 radius_y), apex at the origin; negative radii open downwards."""
        radii = (radius, radius if radius_y is None else radius_y)
        return cls(_mtb_rs.BodySurface.paraboloid(radii), "paraboloid", ("paraboloid", *radii))

    @classmethod
    def rail(cls, profile: str | Profile = "60E1", length: float = 0.18) -> BodySurface:
        """A profile z(y), straight for abs(x) <= length / 2."""
        profile = as_profile(profile)
        core = _mtb_rs.BodySurface.prism(profile._core, length)
        return cls(core, profile.name, ("rail", profile, length))

    @classmethod
    def height_field(
        cls, heights: ArrayLike, spacing: float | Sequence[float], start: tuple[float, float] | None = None
    ) -> BodySurface:
        """Heights (ny, nx) [m] on a regular grid, bicubic between its points.

        `start` is the place (x, y) of the first height; by default the grid is centred at the origin.
        """
        heights = reals("heights", heights)
        if heights.ndim != 2:
            raise ValueError(f"heights has shape {heights.shape}: (ny, nx) is needed")
        dx, dy = spacing_pair(spacing)
        ny, nx = heights.shape
        if start is None:
            start = (-0.5 * dx * (nx - 1), -0.5 * dy * (ny - 1))
        core = _mtb_rs.BodySurface.height_field(heights, start, (dx, dy))
        return cls(core, "height field", ("height_field", np.array(heights), (dx, dy), start))

    @classmethod
    def mesh(
        cls, vertices: ArrayLike, triangles: ArrayLike, *, closed: bool = True, name: str = "mesh"
    ) -> BodySurface:
        """Triangles (m, 3), counter-clockwise seen from outside, of `vertices` (3, n) [m].

        Between its vertices the surface is curved, by cubics that are fitted around the vertices. Edges
        sharper than 30 degrees stay edges. `closed` bodies must be watertight. The limit is a million
        triangles.
        """
        points = reals("vertices", vertices)
        if points.ndim != 2 or points.shape[0] != 3:
            raise ValueError(f"vertices has shape {points.shape}: (3, n) is needed")
        faces = np.asarray(triangles)
        if faces.ndim != 2 or faces.shape[1] != 3 or faces.dtype.kind not in "iu":
            raise ValueError(
                f"triangles has shape {faces.shape}, {faces.dtype}: (m, 3) of integers is needed"
            )
        check_triangles(len(faces), MOST_TRIANGLES, name)
        if faces.size and faces.min() < 0:
            raise ValueError(f"triangles holds {faces.min()}: vertices are counted from 0")
        core = _mtb_rs.BodySurface.mesh(
            np.ascontiguousarray(points.T), np.ascontiguousarray(faces, dtype=np.uintp), closed
        )
        return cls(core, name, ("_of_mesh", np.array(points), np.array(faces), closed, name))

    @classmethod
    def _of_mesh(cls, points: Array, faces: NDArray[np.int64], closed: bool, name: str) -> BodySurface:
        """What a pickled mesh is made of again."""
        return cls.mesh(points, faces, closed=closed, name=name)

    @classmethod
    def from_file(cls, path: str | Path, *, unit: Unit, closed: bool = True) -> BodySurface:
        """Triangle mesh from any file trimesh reads (STL, PLY, OBJ, ...).

        Triangles that contradict their neighbours, or look inwards, are turned.

        Parameters
        ----------
        unit : str
            Length unit of the coordinates, which most formats do not state: "m", "mm", "um" or "in".
        closed : bool
            Whether the mesh must be watertight.
        """
        from .mesh_files import read_surface
        from .mesh_objects import as_trimesh

        scale = metres(unit)
        if not path_of("path", path).exists():
            raise ValueError(f"mesh file {str(path)!r} does not exist")
        path = check_surface_file(path, "mesh file", MOST_TRIANGLES)
        if path.stat().st_size == 0:
            raise ValueError(f"mesh file {str(path)!r} is empty")
        vertices, faces = _outward(as_trimesh(read_surface(path)))
        try:
            return cls.mesh(vertices.T * scale, faces, closed=closed, name=path.name)
        except ValueError as error:
            raise ValueError(f"mesh file {str(path)!r}: {error}") from None

    def top(self, x: ArrayLike, y: ArrayLike) -> Array:
        """Height z [m] of the highest point over (x, y) [m], any shape; NaN beside the body."""
        return _top(self._core, x, y)

    def bottom(self, x: ArrayLike, y: ArrayLike) -> Array:
        """Height z [m] of the lowest point over (x, y) [m], any shape; NaN beside the body.

        For all surfaces other than meshes it equals the top.
        """
        if self._recipe[0] != "_of_mesh":
            return self.top(x, y)
        if self._seen_from_below is None:
            _, points, faces, closed, name = self._recipe
            turned = points * np.array([[1.0], [1.0], [-1.0]])
            self._seen_from_below = type(self)._of_mesh(turned, faces[:, ::-1], closed, name)._core
        return -_top(self._seen_from_below, x, y)


def _top(core: _mtb_rs.BodySurface, x: ArrayLike, y: ArrayLike) -> Array:
    grid_x, grid_y = np.broadcast_arrays(reals("x", x), reals("y", y))
    flat = core.top(np.ascontiguousarray(grid_x).ravel(), np.ascontiguousarray(grid_y).ravel())
    return flat.reshape(grid_x.shape)


def _made(kind: str, *arguments: Any) -> BodySurface:
    made: BodySurface = getattr(BodySurface, kind)(*arguments)
    return made


def _outward(merged: Any) -> tuple[Array, NDArray[np.int64]]:
    """Vertices (n, 3) and triangles (m, 3) of a surface of trimesh with merged vertices, all on one side."""
    from .mesh_files import turn_outwards

    turn_outwards(merged)
    return np.asarray(merged.vertices, dtype=float), np.asarray(merged.faces)


def as_surface(surface: Any) -> Profile | BodySurface | None:
    """The surface of a half-space or rigid body, of any of its forms."""
    if surface is None or isinstance(surface, BodySurface):
        return surface
    if isinstance(surface, (str, Profile)):
        return as_profile(surface)
    made = _of_mesh_object("surface", surface)
    if made is None:
        raise ValueError(
            f"surface is {shortened(surface)}: a Profile, the name of a standard one, a BodySurface, or a "
            "mesh of trimesh, meshio or pyvista in metres is needed (of a file: BodySurface.from_file)"
        )
    return made


def _of_mesh_object(name: str, mesh: Any) -> BodySurface | None:
    """The surface of a mesh of any library; None for anything else, ValueError for a mesh without one."""
    from .mesh_objects import as_trimesh, cells_of  # brings trimesh

    # a copy: what was given stays as it is
    merged = as_trimesh(mesh)
    if merged is None:
        given = cells_of(mesh)
        if given is None:
            return None
        raise ValueError(
            f"{name} is a mesh of {', '.join(given.cells) or 'points alone'}: a mesh of trimesh, meshio or "
            "pyvista with triangles, quadrilaterals or tetrahedra is needed (pyvista's extract_surface makes "
            "one of any cells)"
        )
    closed = bool(merged.is_watertight)
    vertices, faces = _outward(merged)
    return BodySurface.mesh(vertices.T, faces, closed=closed)


def _checked(name: str, surface: Any) -> BodySurface:
    """A body of :func:`surface_gap`."""
    made = surface if isinstance(surface, BodySurface) else _of_mesh_object(name, surface)
    if made is None:
        raise ValueError(
            f"{name} is {shortened(surface)}: a BodySurface, or a mesh of trimesh, meshio or pyvista in "
            "metres is needed"
        )
    return made


def height_of(surface: Profile | BodySurface, x: Array, y: Array, *, upper: bool) -> Array:
    """Height z [m] of the face of an upper or lower body at `x`, `y` [m]; NaN beside it."""
    if isinstance(surface, BodySurface):
        return surface.bottom(x, y) if upper else surface.top(x, y)
    start, end = surface.range
    inside = (y >= start) & (y <= end)
    return np.where(inside, surface.height(np.clip(y, start, end)), np.nan)


@renamed(sheet="grid")
@owning
@dataclass(frozen=True)
@plain
class SurfaceGap:
    """Contact points between two surfaces, and how well its gap is known.

    Attributes
    ----------
    grid : ContactGrid
        Points on the lower body, gap along its normal; infinite where there is no upper body.
    facet_error : (n,) [m]
        Estimated error of the gap because bodies are known by facets only.
    nearest : (n,) bool
        Where the normal misses the upper body; the gap is then the distance of its nearest point.
    """

    grid: ContactGrid
    facet_error: Array
    nearest: NDArray[np.bool_]


@taking_quantities
@renamed(penetration="approach")
def surface_gap(
    lower: Any,
    upper: Any,
    x: tuple[float, float],
    y: tuple[float, float],
    spacing: float | Sequence[float],
    *,
    reach: float = 5e-3,
    approach: float | None = None,
) -> SurfaceGap:
    """Contact points over the rectangle `x` by `y` seen from above, and the gap between two bodies there.

    Parameters
    ----------
    lower, upper : BodySurface, or mesh of trimesh, meshio or pyvista in metres
    x, y : (from, to) [m]
    spacing : float or (dx, dy) [m]
        Seen from above; whole numbers of cells come as close as they can.
    reach : float [m]
        Distance up to which the upper body is looked for.
    approach : float [m], optional
        Expected approach. A ValueError refuses facets whose error is more than a tenth of it where contact is
        expected.
    """
    grid, facet_error, nearest = _mtb_rs.surface_gap(
        _checked("lower", lower)._core,
        _checked("upper", upper)._core,
        x=x,
        y=y,
        spacing=spacing_pair(spacing),
        reach=reach,
        approach=approach,
    )
    return SurfaceGap(
        grid=contact_grid(grid, ("contact",)),
        facet_error=facet_error,
        nearest=nearest,
    )
