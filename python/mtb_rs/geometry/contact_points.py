# SPDX-License-Identifier: MIT OR Apache-2.0
"""Where two bodies may touch: regular grids of contact points, as flat arrays."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .. import _mtb_rs
from ..base.check import positive
from ..base.owning import owning
from ..base.plain import plain
from ..base.stored import stored

Array = NDArray[np.float64]

#: Distances along y that count as the same line along x [m].
SAME_LINE = 1e-9


@stored
@owning
@dataclass(frozen=True)
@plain
class Patch:
    """A regular grid of contact points inside the flat arrays of a result.

    ``points[:, start:start + nx * ny].reshape(3, ny, nx)`` is the patch's grid, x fastest; its points are
    `spacing` (dx, dy) [m] apart. In the plane into which the lower body is unrolled, x along the rows of the
    grid and y the arc length across them, the first one is at `origin` [m].
    """

    name: str
    start: int
    nx: int
    ny: int
    spacing: tuple[float, float]
    origin: tuple[float, float] = (0.0, 0.0)

    def axes(self) -> tuple[Array, Array]:
        """Coordinates [m] of the columns (nx,) and of the rows (ny,) in that plane."""
        (x0, y0), (dx, dy) = self.origin, self.spacing
        return np.asarray(x0 + dx * np.arange(self.nx)), np.asarray(y0 + dy * np.arange(self.ny))

    @property
    def cut(self) -> slice:
        """Its points among those of the flat arrays."""
        return slice(self.start, self.start + self.nx * self.ny)

    def holds_cells(self, area: Array) -> bool:
        """Whether its points are middles of cells, not their corners, by the `area` (n,) of all points."""
        whole = self.nx * self.ny * self.spacing[0] * self.spacing[1]
        return bool(abs(area[self.cut].sum() - whole) <= 1e-6 * whole)

    def is_along_x(self, points: Array) -> bool:
        """Whether its rows lie along x, by the `points` (3, n) of a whole result: not below turned bodies."""
        return bool(np.ptp(self.view(points[1]), axis=1).max() <= SAME_LINE)

    def view(self, values: NDArray[Any]) -> NDArray[Any]:
        """`values` (..., n) of a whole result, cut to this patch and shaped (..., ny, nx)."""
        return values[..., self.cut].reshape(*values.shape[:-1], self.ny, self.nx)


def tangents_of(normal: Array) -> Array:
    """Unit vectors (2, 3, ...) in a surface with `normal` (3, ...): along x, seen from above, and across."""
    ahead = np.zeros_like(normal)
    ahead[0] = 1.0
    along = ahead - normal[0] * normal
    along = along / np.linalg.norm(along, axis=0)
    return np.stack([along, np.cross(normal, along, axis=0)])


#: Coordinates, gaps, loads that differ by less, relative to their size, count as images of each other.
ROUNDING = 1e-11


def spacing_pair(spacing: float | Sequence[float]) -> tuple[float, float]:
    """`spacing` as (dx, dy) [m]: a number means both."""
    try:
        dx, dy = spacing  # type: ignore[misc]
    except TypeError:
        side = positive("spacing", spacing, "m")
        return side, side
    except ValueError:
        raise ValueError(f"spacing is {spacing!r}: a number or (dx, dy) in metres is needed") from None
    return positive("spacing dx", dx, "m"), positive("spacing dy", dy, "m")


@owning
@dataclass(frozen=True)
@plain
class ContactPoints:
    """Points on the lower body with the undeformed gap above them.

    Attributes
    ----------
    points : (3, n) [m]
    normal : (3, n) [-]
        Unit normals of the lower body, pointing up.
    tangent_x, tangent_y : (3, n) [-]
        Unit tangents along the rows of the grid, which are along x unless the upper body is turned, and
        across (normal x tangent_x).
    arc_length : (n,) [m]
        Arc length over the lower body, from its crown, rising with y.
    gap : (n,) [m]
        Distance to the upper body along the normal, > 0 open.
    """

    points: Array
    normal: Array
    tangent_x: Array
    tangent_y: Array
    arc_length: Array
    gap: Array

    def at(self, chosen: slice | NDArray[np.intp]) -> ContactPoints:
        """Some of the points, by their numbers."""
        return ContactPoints(**{k: np.ascontiguousarray(v[..., chosen]) for k, v in vars(self).items()})


@owning
@dataclass(frozen=True)
@plain
class ContactGrid:
    """A potential contact: regular grids of equal cells over the surface of the lower body.

    Attributes
    ----------
    cells : ContactPoints
        Cell centres.
    nodes : ContactPoints
        Corners of the cells, for bases of hats.
    area : (n,) [m2]
    patches, node_patches : tuple of Patch
        The grids of cells and of nodes inside the flat arrays, left (y > 0) first, each with the size of its
        cells along its rows and across (arc length).
    """

    cells: ContactPoints
    nodes: ContactPoints
    area: Array
    patches: tuple[Patch, ...]
    node_patches: tuple[Patch, ...]

    @property
    def spacing(self) -> tuple[float, float]:
        """Mean cell size (dx, dy) [m] along the rows and across; only on rails that are not symmetric do
        cells differ."""
        dx, dy = np.mean([patch.spacing for patch in self.patches], axis=0).tolist()
        return dx, dy

    def on_arc(self) -> ContactGrid:
        """The same with its rows where they are on the lower body, in the mean, along its arc."""
        rows = np.concatenate([np.repeat(patch.axes()[1], patch.nx) for patch in self.patches])
        aside = float(np.mean(self.cells.arc_length - rows))
        cells, nodes = (
            tuple(replace(p, origin=(p.origin[0], p.origin[1] + aside)) for p in patches)
            for patches in (self.patches, self.node_patches)
        )
        return replace(self, patches=cells, node_patches=nodes)

    @property
    def points(self) -> Array:
        """Cell centres (3, n) [m]."""
        return self.cells.points

    @property
    def normal(self) -> Array:
        """Unit normals (3, n) at the cell centres."""
        return self.cells.normal

    @property
    def gap(self) -> Array:
        """Undeformed gap (n,) [m] at the cell centres."""
        return self.cells.gap


def _points(found: _mtb_rs.ContactPoints) -> ContactPoints:
    return ContactPoints(
        points=found.points,
        normal=found.normal,
        tangent_x=found.tangent_x,
        tangent_y=found.tangent_y,
        arc_length=found.arc_length,
        gap=found.gap,
    )


def contact_grid(found: _mtb_rs.ContactGrid, names: Sequence[str]) -> ContactGrid:
    """A potential contact from what the core returns, with a name for each of its patches."""
    cells, nodes = [], []
    for name, ((nx, ny, start, node_start), (dx, dy), (x0, y0)) in zip(names, found.patches, strict=True):
        cells.append(Patch(name, start, nx, ny, (dx, dy), (x0 + 0.5 * dx, y0 + 0.5 * dy)))
        nodes.append(Patch(name, node_start, nx + 1, ny + 1, (dx, dy), (x0, y0)))
    return ContactGrid(
        cells=_points(found.cells),
        nodes=_points(found.nodes),
        area=found.area,
        patches=tuple(cells),
        node_patches=tuple(nodes),
    )


def window(values: NDArray[Any], cut: tuple[slice, ...], fill: float = 0.0) -> NDArray[Any]:
    """The rectangle `cut` (rows, columns) of a grid (..., ny, nx), which may go beyond it: `fill` there."""
    size = tuple(c.stop - c.start for c in cut)
    part: NDArray[Any] = np.full((*values.shape[:-2], *size), fill, dtype=values.dtype)
    inside = tuple(
        slice(max(c.start, 0), min(c.stop, n)) for c, n in zip(cut, values.shape[-2:], strict=True)
    )
    if all(c.start < c.stop for c in inside):
        to = tuple(slice(i.start - c.start, i.stop - c.start) for i, c in zip(inside, cut, strict=True))
        part[..., to[0], to[1]] = values[..., inside[0], inside[1]]
    return part
