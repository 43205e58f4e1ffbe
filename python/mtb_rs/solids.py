# SPDX-License-Identifier: MIT OR Apache-2.0
"""Contacts of elastic bodies of any geometry, on the nodes of a grid that lie on them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .bodies import HalfSpace, Rigid
from .elastic import (
    ElasticPart,
    condensed_part,
    elastic_side,
    half_space_on_nodes,
    moved_by,
    restricted_sampling,
)
from .elastic_body import ElasticBody
from .geometry import ContactSheet, SheetPoints
from .layout import cells_over, flat_points, flat_sheet, height_surface
from .result import Displacement, Patch, Result, Surface
from .solve import Side

Array = NDArray[np.float64]

#: Share of a cell below which a contact point is left out.
LEAST_SHARE = 0.02


@dataclass(frozen=True)
class BodyLayout:
    """The contact face of an elastic body of any geometry, against a plane or another body.

    The sheet is the plane z through the end of the face, with a regular grid over its bounding box; the
    gap is the distance of the face from that plane unless one is given.

    Parameters
    ----------
    body : ElasticBody
    upper : bool
        Whether it is the upper body.
    gap : (ny, nx) [m] or None
        At the nodes of the grid.
    """

    body: ElasticBody
    upper: bool
    gap: Array | None = None
    is_body_edge: bool = True
    is_grid: bool = True
    start: None = None

    def sheet(self, spacing: tuple[float, float]) -> ContactSheet:
        """Cells of about `spacing` that fill the bounding box of the contact face."""
        low, high, level = self._extent()
        size = high - low
        if min(size[:2]) <= 0.0:
            raise ValueError(
                f"the contact face of {self.body.name} measures {size[0]:g} x {size[1]:g} m in x and y: it "
                "must look along z"
            )
        self._check_outlook()
        nx, ny = cells_over((float(size[0]), float(size[1])), spacing)
        dx, dy = size[0] / nx, size[1] / ny
        x, y = low[0] + dx * np.arange(nx + 1), low[1] + dy * np.arange(ny + 1)
        depth = self._depth(x, y, level)
        if self.gap is not None:
            if self.gap.shape != (ny + 1, nx + 1):
                raise ValueError(
                    f"gap has shape {self.gap.shape}: the contact face of {self.body.name} has "
                    f"({ny + 1}, {nx + 1}) nodes at this spacing"
                )
            gap = self.gap
        else:
            gap = np.abs(depth)
        nodes = _at_level(flat_points(x, y, gap), level)
        middle = 0.25 * (gap[1:, 1:] + gap[1:, :-1] + gap[:-1, 1:] + gap[:-1, :-1])
        cells = _at_level(flat_points(x[:-1] + 0.5 * dx, y[:-1] + 0.5 * dy, middle), level)
        return flat_sheet(cells, nodes, nx, ny, (float(dx), float(dy)))

    def _extent(self) -> tuple[Array, Array, float]:
        """Corners (3,) [m] of the bounding box of the contact face, and the height of the plane."""
        corners = self.body.mesh.nodes[np.unique(self.body.faces[self.body.contact_faces][:, :3])]
        low, high = corners.min(axis=0), corners.max(axis=0)
        return low, high, float(low[2] if self.upper else high[2])

    def _check_outlook(self) -> None:
        """An upper body's face must look down, a lower one's up."""
        triangles = self.body.faces[self.body.contact_faces][:, :3].astype(np.int64)
        a, b, c = (self.body.mesh.nodes[triangles[:, k]] for k in range(3))
        up = float(np.cross(b - a, c - a)[:, 2].sum())
        if (up > 0.0) == self.upper:
            looks, must = ("up", "down") if self.upper else ("down", "up")
            side = "an upper" if self.upper else "a lower"
            raise ValueError(
                f"the contact face of {self.body.name} looks {looks}: the contact face of {side} body "
                f"must look {must}"
            )

    def _depth(self, x: Array, y: Array, level: float) -> Array:
        """Height (ny, nx) [m] of the face over the plane at grid lines; 0 beside the face."""
        triangles = self.body.faces[self.body.contact_faces][:, :3].astype(np.int64)
        a, b, c = (self.body.mesh.nodes[triangles[:, k]] for k in range(3))
        height = np.zeros((y.size, x.size))
        if max(np.abs(p[:, 2] - level).max() for p in (a, b, c)) == 0.0:
            return height
        double = (b[:, 0] - a[:, 0]) * (c[:, 1] - a[:, 1]) - (c[:, 0] - a[:, 0]) * (b[:, 1] - a[:, 1])
        for j, at_y in enumerate(y):
            for i, at_x in enumerate(x):
                first = ((b[:, 0] - at_x) * (c[:, 1] - at_y) - (c[:, 0] - at_x) * (b[:, 1] - at_y)) / double
                second = ((c[:, 0] - at_x) * (a[:, 1] - at_y) - (a[:, 0] - at_x) * (c[:, 1] - at_y)) / double
                inside = np.minimum(np.minimum(first, second), 1.0 - first - second)
                k = int(inside.argmax())
                weights = np.array([first[k], second[k], 1.0 - first[k] - second[k]])
                weights = np.clip(weights, 0.0, 1.0) / np.clip(weights, 0.0, 1.0).sum()
                height[j, i] = weights @ [a[k, 2], b[k, 2], c[k, 2]] - level
        return height

    def surfaces(self) -> tuple[Surface, ...]:
        """The boundary of the body, and the plane beside it."""
        nodes = self.body.mesh.nodes
        low, high = nodes.min(axis=0), nodes.max(axis=0)
        _, _, level = self._extent()
        wide = 0.25 * (high - low)
        x, y = (np.linspace(low[k] - wide[k], high[k] + wide[k], 9) for k in (0, 1))
        plane = height_surface("lower" if self.upper else "upper", x, y, np.full((9, 9), level))
        own = self.body.surface()
        named = Surface("upper" if self.upper else "lower", own.vertices, own.triangles)
        return (plane, named) if self.upper else (named, plane)


def _at_level(points: SheetPoints, level: float) -> SheetPoints:
    moved = points.points.copy()
    moved[2] = level
    return replace(points, points=moved)


@dataclass(frozen=True)
class BodyContact:
    """The contact of bodies of any geometry, on the nodes of a sheet that lie on them.

    Attributes
    ----------
    sheet : ContactSheet
    points : SheetPoints
        The nodes kept.
    kept : (n,) int
        Their numbers among all nodes of the sheet.
    area : (n,) [m2]
    upper, lower : Side
    """

    sheet: ContactSheet
    points: SheetPoints
    kept: NDArray[np.intp]
    area: Array
    upper: Side
    lower: Side


def body_contact(
    layout: BodyLayout,
    bodies: tuple[ElasticBody | HalfSpace | Rigid, ElasticBody | HalfSpace | Rigid],
    spacing: tuple[float, float],
    pulls: Callable[[SheetPoints, bool], Array],
    wrench: Array,
    time_s: dict[str, float],
) -> BodyContact:
    """Upper and lower body condensed, or half-spaces, on the nodes that lie on all elastic faces.

    Parameters
    ----------
    bodies : (upper, lower)
    pulls : callable
        Magnetic pressure (n,) [Pa] at given points on the upper (True) or lower body.
    wrench : (6,)
        Force [N] and moment about its centre of volume [N m] spread over an elastic upper body.
    """
    sheet = layout.sheet(spacing)
    nodes, patches = sheet.nodes, sheet.node_patches
    whole = [
        body.sample(nodes, patches, sheet.spacing, upper=upper)
        for body, upper in zip(bodies, (True, False), strict=True)
        if isinstance(body, ElasticBody)
    ]
    least = np.min([sampling.weights for sampling in whole], axis=0)
    kept = np.flatnonzero(least > LEAST_SHARE * sheet.spacing[0] * sheet.spacing[1])
    if kept.size == 0:
        raise ValueError("the contact faces of the bodies have no area in common")
    points = SheetPoints(**{k: np.ascontiguousarray(v[..., kept]) for k, v in vars(nodes).items()})
    n = kept.size
    area = restricted_sampling(whole[0], kept).weights
    sides = []
    for body, upper in zip(bodies, (True, False), strict=True):
        pull = pulls(points, upper)
        if isinstance(body, ElasticBody):
            part = ElasticPart(
                body,
                tuple(patches),
                nodes,
                0,
                sheet.spacing,
                upper,
                pull,
                np.zeros((0, 9)),
                kept,
                spread=wrench if upper else np.zeros(6),
            )
            flexible = condensed_part(part, time_s)
            part = part.on(flexible)
            sides.append(elastic_side([part], [flexible], [flexible.compliance], points))
            continue
        side = half_space_on_nodes(body, sheet, np.zeros(nodes.gap.size))
        compliance = side.compliance
        if compliance is not None:
            share = area / _hat_areas(patches[0], sheet.spacing)[kept]
            compliance = compliance.restricted(kept.tolist(), share.tolist())
        displacement = np.zeros((3, n))
        if compliance is not None and pull.any():
            load = np.stack([0.0 * pull, 0.0 * pull, -pull])
            displacement = moved_by(compliance, load, points, 1.0 if upper else -1.0)
        sides.append(Side(compliance, displacement, np.zeros((0, 3, n)), np.zeros(0)))
    return BodyContact(sheet, points, kept, area, sides[0], sides[1])


def _hat_areas(patch: Patch, spacing: tuple[float, float]) -> Array:
    """Area (n,) [m2] of each hat of a grid: whole, half at an edge, a quarter at a corner."""
    ends = [np.where((np.arange(k) == 0) | (np.arange(k) == k - 1), 0.5, 1.0) for k in (patch.nx, patch.ny)]
    return np.outer(ends[1], ends[0]).ravel() * spacing[0] * spacing[1]


def on_grid(result: Result, kept: NDArray[np.intp], sheet: ContactSheet) -> Result:
    """A result on some nodes of a grid as one on all; beside the bodies there is no area and no load."""
    patch = sheet.node_patches[0]
    shape = (patch.ny, patch.nx)

    def put(values: NDArray[Any], rest: NDArray[Any] | float = 0.0) -> NDArray[Any]:
        whole = np.broadcast_to(
            np.asarray(rest, dtype=values.dtype), (*values.shape[:-1], patch.nx * patch.ny)
        )
        out = np.array(whole)
        out[..., kept] = values
        return out.reshape(*values.shape[:-1], *shape)

    nodes = sheet.nodes
    return replace(
        result,
        points=nodes.points.reshape(3, *shape),
        area=put(result.area),
        normal=nodes.normal.reshape(3, *shape),
        pressure=put(result.pressure),
        traction=put(result.traction),
        gap=put(result.gap, nodes.gap),
        initial_gap=nodes.gap.reshape(shape),
        status=put(result.status),
        displacement=Displacement(*(put(u) for u in result.displacement)),
        patches=sheet.node_patches,
    )
