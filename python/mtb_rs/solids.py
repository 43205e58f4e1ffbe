# SPDX-License-Identifier: MIT OR Apache-2.0
"""Contacts of elastic bodies of any geometry, on the nodes of a grid that lie on them."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from . import _mtb_rs
from .bodies import HalfSpace, Rigid
from .elastic import (
    ElasticPart,
    condensed_part,
    elastic_side,
    moved_by,
    owners,
    restricted_sampling,
    thinned,
)
from .elastic_body import ElasticBody
from .geometry import ContactSheet, SheetPoints
from .layout import cells_over, flat_points, flat_sheet, height_surface
from .result import Displacement, Result, Surface
from .solve import Side

Array = NDArray[np.float64]

#: Share of a cell below which a contact point is left out.
LEAST_SHARE = 0.02

#: Parts of a cell by which the quadrature points in it are told apart.
SHARES = 1024

#: Cells between the nodes of a body at its contact above which it is too coarse for the grid.
COARSE = 1.5

#: Edges that turn by more than this are edges of the body, not of its facets [rad].
EDGE = np.radians(30.0)

#: Slope of a face where it touches, in the mean, from which pressure along z is 2 % off.
STEEP = 0.2

#: Share of what the contact closes by which facets may be off.
FACETS = 0.1

#: Rise of the gap within the cells at the edge of a contact, in parts of what the bodies close there. A
#: cylinder whose contact is 2.8 cells wide has 2.8 and is 0.5 % off, one of 1.4 cells 7.3 and 14 %; a chamfer
#: has tens.
ABRUPT = 6.0

#: Share of the size of a body below which facets lie in a plane: single precision, as STL files have it.
ROUNDING = 1e-7

#: Share of the size of a body by which it may lie in the other one unnoticed.
OVERLAP = 1e-4


@dataclass(frozen=True)
class BodyLayout:
    """The contact face of an elastic body of any geometry, against a plane or another body.

    The sheet is the plane z through the end of the face, with a regular grid over its bounding box, or over
    the part of it that another elastic body shares. The gap is that between the faces as their meshes lie,
    from a half-space or a rigid body that of the face from the plane, unless one is given.

    Parameters
    ----------
    body : ElasticBody
    upper : bool
        Whether it is the upper body.
    gap : (ny, nx) [m] or None
        At the nodes of the grid.
    opponent : ElasticBody or None
    """

    body: ElasticBody
    upper: bool
    gap: Array | None = None
    opponent: ElasticBody | None = None
    is_body_edge: bool = True
    is_grid: bool = True
    start: None = None

    def sheet(self, spacing: tuple[float, float]) -> ContactSheet:
        """Cells of about `spacing` that fill the bounding box of the contact; without a gap unless given."""
        low, high = _extent(self.body, upper=self.upper)
        level = self.level()
        if self.opponent is not None:
            other_low, other_high = _extent(self.opponent, upper=not self.upper)
            low, high = np.maximum(low, other_low), np.minimum(high, other_high)
            if (low[:2] >= high[:2]).any():
                raise ValueError(
                    f"the contact faces of {self.body.name} and {self.opponent.name} have no area in common: "
                    "seen along z they lie beside each other"
                )
        size = high - low
        nx, ny = cells_over((float(size[0]), float(size[1])), spacing)
        dx, dy = size[0] / nx, size[1] / ny
        x, y = low[0] + dx * np.arange(nx + 1), low[1] + dy * np.arange(ny + 1)
        gap = np.zeros((ny + 1, nx + 1)) if self.gap is None else self.gap
        if gap.shape != (ny + 1, nx + 1):
            raise ValueError(
                f"gap has shape {gap.shape}: the contact face of {self.body.name} has "
                f"({ny + 1}, {nx + 1}) nodes at this spacing"
            )
        nodes = _at_level(flat_points(x, y, gap), level)
        middle = 0.25 * (gap[1:, 1:] + gap[1:, :-1] + gap[:-1, 1:] + gap[:-1, :-1])
        cells = _at_level(flat_points(x[:-1] + 0.5 * dx, y[:-1] + 0.5 * dy, middle), level)
        return flat_sheet(cells, nodes, nx, ny, (float(dx), float(dy)))

    def level(self) -> float:
        """Height of the sheet [m]: the end of the face."""
        z = self.body.mesh.nodes[np.unique(self.body.faces[self.body.contact_faces]), 2]
        return float(z.min() if self.upper else z.max())

    def surfaces(self) -> tuple[Surface, ...]:
        """The boundary of the body, and the plane or body beside it."""
        own = replace(self.body.surface(), name="upper" if self.upper else "lower")
        other = "lower" if self.upper else "upper"
        if self.opponent is not None:
            beside = replace(self.opponent.surface(), name=other)
        else:
            nodes = self.body.mesh.nodes
            low, high = nodes.min(axis=0), nodes.max(axis=0)
            wide = 0.25 * (high - low)
            x, y = (np.linspace(low[k] - wide[k], high[k] + wide[k], 9) for k in (0, 1))
            beside = height_surface(other, x, y, np.full((9, 9), self.level()))
        return (beside, own) if self.upper else (own, beside)


def _extent(body: ElasticBody, *, upper: bool) -> tuple[Array, Array]:
    """Corners (3,) [m] of the bounding box of a contact face that looks at its opponent."""
    triangles = body.faces[body.contact_faces][:, :3].astype(np.int64)
    a, b, c = (body.mesh.nodes[triangles[:, k]] for k in range(3))
    corners = body.mesh.nodes[np.unique(triangles)]
    low, high = corners.min(axis=0), corners.max(axis=0)
    if min((high - low)[:2]) <= ROUNDING * float(np.ptp(body.mesh.nodes, axis=0).max()):
        raise ValueError(
            f"the contact face of {body.name} measures {high[0] - low[0]:g} x {high[1] - low[1]:g} m in x "
            "and y: it must look along z"
        )
    up = float(np.cross(b - a, c - a)[:, 2].sum())
    if (up > 0.0) == upper:
        looks, must = ("up", "down") if upper else ("down", "up")
        side = "an upper" if upper else "a lower"
        raise ValueError(
            f"the contact face of {body.name} looks {looks}: the contact face of {side} body must look {must}"
        )
    return low, high


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
    rise : (n,) [m]
        Of the gap between the faces over the cells around each node; 0 where a gap is given.
    upper, lower : Side
    """

    sheet: ContactSheet
    points: SheetPoints
    kept: NDArray[np.intp]
    area: Array
    rise: Array
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
    whole = {
        upper: body.sample(nodes, patches, upper=upper)
        for body, upper in zip(bodies, (True, False), strict=True)
        if isinstance(body, ElasticBody)
    }
    for body in bodies:
        if isinstance(body, ElasticBody):
            _check_fineness(body, sheet.spacing)
    covered = _covered_by_both(whole)
    if covered is not None:
        whole = {upper: thinned(sampling, covered[upper]) for upper, sampling in whole.items()}
    common = whole[layout.upper]
    kept = np.flatnonzero(common.weights > LEAST_SHARE * sheet.spacing[0] * sheet.spacing[1])
    if kept.size == 0:
        raise ValueError("the contact faces of the bodies have no area in common")
    rise = np.zeros(nodes.gap.size)
    if layout.gap is None:
        gap, rise = _gap(layout, bodies, whole)
        nodes = replace(nodes, gap=gap)
        sheet = replace(sheet, nodes=nodes)
        _check_overlap(layout, float(gap[kept].min()))
    points = SheetPoints(**{k: np.ascontiguousarray(v[..., kept]) for k, v in vars(nodes).items()})
    n = kept.size
    area = restricted_sampling(common, kept).weights
    sides = []
    for body, upper in zip(bodies, (True, False), strict=True):
        pull = pulls(points, upper)
        if isinstance(body, ElasticBody):
            part = ElasticPart(
                body,
                tuple(patches),
                nodes,
                0,
                upper,
                pull,
                np.zeros((0, 9)),
                kept,
                spread=wrench if upper else np.zeros(6),
                covered=None if covered is None else covered[upper],
            )
            flexible = condensed_part(part, time_s)
            part = part.on(flexible)
            sides.append(elastic_side([part], [flexible], [flexible.compliance], points))
            continue
        compliance = None
        displacement = np.zeros((3, n))
        if isinstance(body, HalfSpace):
            first = nodes.points[:, patches[0].start]
            compliance = _mtb_rs.half_space_cut_hats(
                body.material.shear_modulus,
                body.material.poisson_ratio,
                (float(first[0]), float(first[1]), patches[0].nx, patches[0].ny),
                patches[0].spacing,
                common,
                kept.tolist(),
            )
            if pull.any():
                load = np.stack([0.0 * pull, 0.0 * pull, -pull])
                displacement = moved_by(compliance, load, points, 1.0 if upper else -1.0)
        sides.append(Side(compliance, displacement, np.zeros((0, 3, n)), np.zeros(0)))
    return BodyContact(sheet, points, kept, area, rise[kept], sides[0], sides[1])


def _covered_by_both(whole: Mapping[bool, _mtb_rs.Sampling]) -> dict[bool, NDArray[np.bool_]] | None:
    """Which quadrature points of two samplings of one grid the other has as well; None for a single one."""
    if len(whole) == 1:
        return None
    places = {}
    for upper, sampling in whole.items():
        arrays = sampling.arrays()
        point, value = arrays["point"].reshape(-1, 4).astype(np.int64), arrays["value"].reshape(-1, 4)
        # its cell, and where in it
        along = np.floor(SHARES * np.stack([value[:, 1] + value[:, 3], value[:, 2] + value[:, 3]]))
        places[upper] = (point[:, 0] * SHARES + along[0].astype(np.int64)) * SHARES + along[1].astype(
            np.int64
        )
    return {upper: np.isin(places[upper], places[not upper]) for upper in whole}


def _gap(
    layout: BodyLayout,
    bodies: Sequence[ElasticBody | HalfSpace | Rigid],
    whole: Mapping[bool, _mtb_rs.Sampling],
) -> tuple[Array, Array]:
    """Gap (n,) [m] between the faces, the mean over the hat of each node, and its rise there; 0 beside them.

    The displacements are means over the hats as well: so a curved face or one that ends within a cell is
    met with the same order as a flat one.
    """
    apart: Array | float = 0.0
    for body, upper in zip(bodies, (True, False), strict=True):
        level = layout.level()
        height = body.heights(whole[upper]) - level if isinstance(body, ElasticBody) else 0.0
        apart = apart + height if upper else apart - height
    arrays = whole[layout.upper].arrays()
    owner = owners(arrays)
    weighted = arrays["value"] * arrays["weight"][owner]
    points, n = arrays["point"].astype(np.int64), whole[layout.upper].n_points
    total = np.bincount(points, weighted, n)
    apart = np.broadcast_to(apart, arrays["weight"].shape)[owner]
    gap = np.bincount(points, weighted * apart, n)
    low, high = np.full(n, np.inf), np.full(n, -np.inf)
    np.minimum.at(low, points, apart)
    np.maximum.at(high, points, apart)
    there = total > 0.0
    return np.where(there, gap / np.where(there, total, 1.0), 0.0), np.where(there, high - low, 0.0)


def _check_fineness(body: ElasticBody, spacing: tuple[float, float]) -> None:
    """A mesh coarser than the grid makes ripples, or more contact points than its nodes can tell apart."""
    faces = body.faces[body.contact_faces].astype(np.int64)
    order = 2.0 if faces.shape[1] == 6 else 1.0
    apart = np.median(np.ptp(body.mesh.nodes[faces[:, :3], :2], axis=1), axis=0) / order
    if (apart > COARSE * np.array(spacing)).any():
        warnings.warn(
            f"the nodes of {body.name} at the contact are about {apart[0]:.3g} x {apart[1]:.3g} m apart, the "
            f"cells of the grid {spacing[0]:.3g} x {spacing[1]:.3g} m wide: its mesh is too coarse for them; "
            "smaller elements (size) are needed, or a wider spacing",
            stacklevel=5,
        )


def check_faces(
    bodies: Sequence[ElasticBody | HalfSpace | Rigid],
    contact: BodyContact,
    touching: NDArray[np.bool_],
    gap: Array,
) -> None:
    """Warns where faces are steep as they touch, part within a cell, or have facets that are not small.

    Parameters
    ----------
    touching : (n,) bool
        Points in contact.
    gap : (n,) [m]
        When loaded.
    """
    _check_edges(contact, touching, gap)
    points = contact.points.points[:, touching]
    closed = float(np.ptp(contact.points.gap[touching]))
    for body in bodies:
        if not isinstance(body, ElasticBody):
            continue
        faces = body.faces[body.contact_faces].astype(np.int64)
        middles = body.mesh.nodes[faces[:, :3]].mean(axis=1)
        near = _beside(middles, points, 2.0 * np.array(contact.sheet.spacing))
        slope = _slope(body, faces[near])
        if slope > STEEP:
            warnings.warn(
                f"the contact face of {body.name} has a slope of {slope:.2g} where it touches: pressure and "
                "gap are taken along z, friction along x and y, which is right for small slopes only",
                stacklevel=4,
            )
        sag = _sagitta(body, faces[near])
        if closed > 0.0 and sag > max(
            FACETS * closed, ROUNDING * float(np.ptp(body.mesh.nodes, axis=0).max())
        ):
            warnings.warn(
                f"the contact face of {body.name} is made of flat facets, about {sag:.2g} m off the "
                f"smooth surface they may stand for; the contact closes a gap of {closed:.2g} m. Give "
                "smaller facets, elements of second order with their nodes on the surface, or gap",
                stacklevel=4,
            )


def _check_edges(contact: BodyContact, touching: NDArray[np.bool_], gap: Array) -> None:
    """The gap of a node is the mean over its cells: where it opens all at once, they do not know the edge."""
    places, spacing = contact.points.points, np.array(contact.sheet.spacing)
    near = _beside(places.T, places[:, touching], 1.01 * spacing)
    if touching[near].all():
        return
    worst = np.flatnonzero(near)[contact.rise[near].argmax()]
    closed = float(np.ptp((contact.points.gap - gap)[near]))
    if contact.rise[worst] > ABRUPT * closed:
        x, y = places[:2, worst]
        warnings.warn(
            f"the gap opens by {contact.rise[worst]:.2g} m within the cells at the edge of the contact, near "
            f"x = {x:.4g}, y = {y:.4g} m, where the bodies close by {closed:.2g} m: the edge is known to a "
            f"cell of {spacing[0]:.3g} x {spacing[1]:.3g} m only. Give a narrower spacing, or end the "
            "contact face where it turns away",
            stacklevel=5,
        )


def _slope(body: ElasticBody, faces: NDArray[np.int64]) -> float:
    """Slope of triangles in the mean, by their areas seen along z."""
    corners = body.mesh.nodes[faces[:, :3]]
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    seen = np.abs(normal[:, 2])
    level = seen > 1e-3 * np.linalg.norm(normal, axis=1)
    if not level.any():
        return 0.0
    rise = (normal[level, :2] ** 2).sum(axis=1) / seen[level]
    return float(np.sqrt(rise.sum() / seen[level].sum()))


def _beside(places: Array, points: Array, reach: Array) -> NDArray[np.bool_]:
    """Which places (k, 3) are within `reach` (2,) of some points (3, n), seen along z."""
    found = np.zeros(len(places), dtype=bool)
    for point in points[:2].T:
        found |= (np.abs(places[:, :2] - point) <= reach).all(axis=1)
    return found


def _sagitta(body: ElasticBody, faces: NDArray[np.int64]) -> float:
    """How far facets are off the curve that their edges hint at [m]; 0 for elements that are curved."""
    nodes = body.mesh.nodes
    if faces.shape[1] == 6:
        ends = nodes[faces[:, [0, 1, 2]]], nodes[faces[:, [1, 2, 0]]]
        bulge = nodes[faces[:, 3:]] - 0.5 * (ends[0] + ends[1])
        if np.abs(bulge).max() > 1e-9 * np.ptp(nodes, axis=0).max():
            return 0.0
    corners = nodes[faces[:, :3]]
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    double = np.linalg.norm(normal, axis=1)
    edges = np.sort(faces[:, [[0, 1], [1, 2], [2, 0]]], axis=2).reshape(-1, 2)
    order = np.lexsort(edges.T)
    same = (edges[order[1:]] == edges[order[:-1]]).all(axis=1)
    one, other = order[1:][same] // 3, order[:-1][same] // 3
    cosine = np.einsum("ij,ij->i", normal[one], normal[other]) / (double[one] * double[other])
    turn = np.arccos(np.clip(cosine, -1.0, 1.0))
    pair = edges[order[1:][same]]
    length = np.linalg.norm(nodes[pair[:, 0]] - nodes[pair[:, 1]], axis=1)
    # the curvature is the turn over two thirds of their height, from the middle of one to that of the other
    height = 0.5 * (double[one] + double[other]) / length
    sag = np.where(turn < EDGE, 3.0 / 16.0 * height * turn, 0.0)
    return float(sag.max(initial=0.0))


def _check_overlap(layout: BodyLayout, gap: float) -> None:
    """Bodies that lie in one another before any load may be a slip of the pen."""
    size = float(np.ptp(layout.body.mesh.nodes, axis=0).max())
    if layout.opponent is not None and gap < -OVERLAP * size:
        warnings.warn(
            f"{layout.body.name} and {layout.opponent.name} overlap by up to {-gap:.4g} m before any load: "
            "they are pressed apart by that much",
            stacklevel=5,
        )


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
