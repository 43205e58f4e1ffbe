# SPDX-License-Identifier: MIT OR Apache-2.0
"""Contacts of elastic bodies of any geometry, on the nodes of a grid that lie on them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from . import _mtb_rs, cache
from .bodies import HalfSpace, Rigid
from .cache import Memory
from .check import warn
from .elastic import (
    Averages,
    ElasticPart,
    averages,
    condensed_part,
    elastic_side,
    moved_by,
    owners,
    restricted_sampling,
    thinned,
)
from .elastic_body import Condensed, ElasticBody
from .estimate import hat_means
from .geometry import ContactSheet, SheetPoints
from .layout import Spacing, cells_over, flat_points, flat_sheet, height_surface
from .plain import plain
from .result import Result, Surface
from .solve import ContactProblem, Kept, Side

Array = NDArray[np.float64]
Body = ElasticBody | HalfSpace | Rigid
#: Upper and lower one.
Bodies = tuple[Body, Body]

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
@plain
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
    step : (dx, dy) [m] or None
        Spacing at which the gap is given; on wider cells it is the mean over the hats of their nodes.
    """

    body: ElasticBody
    upper: bool
    gap: Array | None = None
    opponent: ElasticBody | None = None
    step: Spacing | None = None
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
        area = float(size[0]), float(size[1])
        nx, ny = cells_over(area, spacing)
        dx, dy = size[0] / nx, size[1] / ny
        x, y = low[0] + dx * np.arange(nx + 1), low[1] + dy * np.arange(ny + 1)
        gap = np.zeros((ny + 1, nx + 1))
        if self.gap is not None:
            gap = self.gap
            own = cells_over(area, spacing if self.step is None else self.step)
            if gap.shape != (own[1] + 1, own[0] + 1):
                raise ValueError(
                    f"gap has shape {gap.shape}: the contact face of {self.body.name} has "
                    f"({own[1] + 1}, {own[0] + 1}) nodes at this spacing"
                )
            if own[0] < nx or own[1] < ny:
                raise ValueError(
                    f"spacing is {spacing} m, the gap is given on {own[0]} x {own[1]} cells: give it on the "
                    f"nodes of {nx} x {ny} cells as well"
                )
            if own != (nx, ny):
                at_x, at_y = (np.linspace(low[k], high[k], own[k] + 1) for k in (0, 1))
                gap = hat_means(y, at_y) @ gap @ hat_means(x, at_x).T
        nodes = _at_level(flat_points(x, y, gap), level)
        middle = 0.25 * (gap[1:, 1:] + gap[1:, :-1] + gap[:-1, 1:] + gap[:-1, :-1])
        cells = _at_level(flat_points(x[:-1] + 0.5 * dx, y[:-1] + 0.5 * dy, middle), level)
        return flat_sheet(cells, nodes, nx, ny, (float(dx), float(dy)))

    def is_coarser_than(self, spacing: Spacing) -> bool:
        """Whether the mesh of a body is too coarse for cells of `spacing` (dx, dy) [m]."""
        bodies = [self.body] if self.opponent is None else [self.body, self.opponent]
        return any(_coarse(body, spacing) for body in bodies)

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
@plain
class Standing:
    """One body where it stands in a contact, without what presses it.

    Attributes
    ----------
    compliance : Compliance or None
        None for a rigid body.
    part : ElasticPart or None
        Finite elements.
    condensed : Condensed or None
        Of these.
    """

    compliance: _mtb_rs.Compliance | None
    part: ElasticPart | None = None
    condensed: Condensed | None = None


@dataclass(frozen=True)
@plain
class BodyContact:
    """The contact of bodies of any geometry, on the nodes of a sheet that lie on them, without loads.

    Attributes
    ----------
    sheet : ContactSheet
    points : SheetPoints
        The nodes kept.
    kept : Kept
    area : (n,) [m2]
    averages : Averages
    upper, lower : Standing
    memory : Memory
        What is made of them for one load and serves the next.
    doubts : tuple of str
    """

    sheet: ContactSheet
    points: SheetPoints
    kept: Kept
    area: Array
    averages: Averages
    upper: Standing
    lower: Standing
    memory: Memory
    doubts: tuple[str, ...]

    @property
    def nbytes(self) -> float:
        """Memory of the matrices [bytes]: the blocks of two bodies, their halves, those of the pair."""
        return 24.0 * 8.0 * self.area.size**2

    def side(self, pull: Array, wrench: Array, *, upper: bool) -> Side:
        """One body under its load.

        Parameters
        ----------
        pull : (n,) [Pa]
            Magnetic pressure on it. A half-space above is not moved by it: its resultant presses.
        wrench : (6,)
            Force [N] and moment about its centre of volume [N m] spread over an elastic body.
        """
        body, n = self.upper if upper else self.lower, self.area.size
        if body.part is not None and body.condensed is not None:
            part = replace(body.part, pull=pull, spread=wrench).on(body.condensed)
            return elastic_side([part], [body.condensed], [body.condensed.compliance], self.points)
        displacement = np.zeros((3, n))
        if body.compliance is not None and not upper and pull.any():
            displacement = moved_by(
                body.compliance, np.stack([0.0 * pull, 0.0 * pull, -pull]), self.points, -1.0
            )
        return Side(body.compliance, displacement, np.zeros((0, 3, n)), np.zeros(0))


def body_contact(
    layout: BodyLayout, bodies: Bodies, spacing: tuple[float, float], time_s: dict[str, float]
) -> BodyContact:
    """Upper and lower body condensed, or half-spaces, on the nodes that lie on all elastic faces.

    It is made once for the same bodies, gap and spacing.

    Parameters
    ----------
    bodies : (upper, lower)
    """
    sheet = layout.sheet(spacing)
    parts: dict[str, Any] = {
        "sheet": sheet.spacing,
        "nodes": sheet.nodes.points,
        "gap": None if layout.gap is None else sheet.nodes.gap,
        "carries the grid": "upper" if layout.upper else "lower",
    }
    for name, body in zip(("upper", "lower"), bodies, strict=True):
        parts[name] = (body.name, body.content) if isinstance(body, ElasticBody) else body
    return cache.recalled(cache.content_key(parts), lambda: _condensed_contact(layout, bodies, sheet, time_s))


def _condensed_contact(
    layout: BodyLayout, bodies: Bodies, sheet: ContactSheet, time_s: dict[str, float]
) -> BodyContact:
    nodes, patches = sheet.nodes, sheet.node_patches
    whole = {
        upper: body.sample(nodes, patches, upper=upper)
        for body, upper in zip(bodies, (True, False), strict=True)
        if isinstance(body, ElasticBody)
    }
    covered = _covered_by_both(whole)
    if covered is not None:
        whole = {upper: thinned(sampling, covered[upper]) for upper, sampling in whole.items()}
    common = whole[layout.upper]
    kept = np.flatnonzero(common.weights > LEAST_SHARE * sheet.spacing[0] * sheet.spacing[1])
    if kept.size == 0:
        raise ValueError("the contact faces of the bodies have no area in common")
    doubts = [_coarse(body, sheet.spacing) for body in bodies if isinstance(body, ElasticBody)]
    rise = np.zeros(nodes.gap.size)
    if layout.gap is None:
        gap, rise = _gap(layout, bodies, whole)
        nodes = replace(nodes, gap=gap)
        sheet = replace(sheet, nodes=nodes)
        doubts.append(_overlapping(layout, float(gap[kept].min())))
    points = SheetPoints(**{k: np.ascontiguousarray(v[..., kept]) for k, v in vars(nodes).items()})
    standing = []
    for body, upper in zip(bodies, (True, False), strict=True):
        if isinstance(body, ElasticBody):
            part = ElasticPart(
                body,
                tuple(patches),
                nodes,
                0,
                upper,
                np.zeros(kept.size),
                np.zeros((0, 9)),
                kept,
                covered=None if covered is None else covered[upper],
            )
            flexible = condensed_part(part, time_s)
            standing.append(Standing(flexible.compliance, part, flexible))
        elif isinstance(body, HalfSpace):
            first = nodes.points[:, patches[0].start]
            cut = _mtb_rs.half_space_cut_hats(
                body.material.shear_modulus,
                body.material.poisson_ratio,
                (float(first[0]), float(first[1]), patches[0].nx, patches[0].ny),
                patches[0].spacing,
                common,
                kept.tolist(),
            )
            standing.append(Standing(cut))
        else:
            standing.append(Standing(None))
    carrier = standing[0 if layout.upper else 1].part
    assert carrier is not None
    return BodyContact(
        sheet=sheet,
        points=points,
        kept=Kept(nodes, kept, rise[kept]),
        area=restricted_sampling(common, kept).weights,
        averages=averages([carrier]),
        upper=standing[0],
        lower=standing[1],
        memory=Memory(),
        doubts=tuple(doubt for doubt in doubts if doubt),
    )


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
    bodies: Bodies,
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


def _coarse(body: ElasticBody, spacing: tuple[float, float]) -> str:
    """A mesh coarser than the grid makes ripples, or more contact points than its nodes can tell apart."""
    faces = body.faces[body.contact_faces].astype(np.int64)
    order = 2.0 if faces.shape[1] == 6 else 1.0
    apart = np.median(np.ptp(body.mesh.nodes[faces[:, :3], :2], axis=1), axis=0) / order
    if (apart <= COARSE * np.array(spacing)).all():
        return ""
    return (
        f"the nodes of {body.name} at the contact are about {apart[0]:.3g} x {apart[1]:.3g} m apart, the "
        f"cells of the grid {spacing[0]:.3g} x {spacing[1]:.3g} m wide: its mesh is too coarse for them; "
        "smaller elements (size) are needed, or a wider spacing"
    )


def check_faces(bodies: Bodies, problem: ContactProblem, result: Result) -> None:
    """Warns where faces are steep as they touch, part within a cell, or have facets that are not small."""
    assert problem.kept is not None
    touching = result.status.ravel()[problem.kept.numbers] > 0
    gap = result.gap.ravel()[problem.kept.numbers]
    _check_edges(problem, problem.kept, touching, gap)
    closed = float(np.ptp(problem.points.gap[touching]))
    for body in bodies:
        if not isinstance(body, ElasticBody):
            continue
        faces = body.faces[body.contact_faces].astype(np.int64)
        middles = body.mesh.nodes[faces[:, :3]].mean(axis=1)
        near = _beside(middles, problem, problem.kept, touching, 2.0)
        slope = _slope(body, faces[near])
        if slope > STEEP:
            warn(
                f"the contact face of {body.name} has a slope of {slope:.2g} where it touches: pressure and "
                "gap are taken along z, friction along x and y, which is right for small slopes only"
            )
        sag = _sagitta(body, faces[near])
        if closed > 0.0 and sag > max(
            FACETS * closed, ROUNDING * float(np.ptp(body.mesh.nodes, axis=0).max())
        ):
            warn(
                f"the contact face of {body.name} is made of flat facets, about {sag:.2g} m off the "
                f"smooth surface they may stand for; the contact closes a gap of {closed:.2g} m. Give "
                "smaller facets, elements of second order with their nodes on the surface, or gap"
            )


def _check_edges(problem: ContactProblem, kept: Kept, touching: NDArray[np.bool_], gap: Array) -> None:
    """The gap of a node is the mean over its cells: where it opens all at once, they do not know the edge."""
    places = problem.points.points
    near = _beside(places.T, problem, kept, touching, 1.01)
    if touching[near].all():
        return
    worst = np.flatnonzero(near)[kept.rise[near].argmax()]
    closed = float(np.ptp((problem.points.gap - gap)[near]))
    if kept.rise[worst] > ABRUPT * closed:
        x, y = places[:2, worst]
        dx, dy = problem.patches[0].spacing
        warn(
            f"the gap opens by {kept.rise[worst]:.2g} m within the cells at the edge of the contact, near "
            f"x = {x:.4g}, y = {y:.4g} m, where the bodies close by {closed:.2g} m: the edge is known to a "
            f"cell of {dx:.3g} x {dy:.3g} m only. Give a narrower spacing, or end the "
            "contact face where it turns away"
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


def _beside(
    places: Array, problem: ContactProblem, kept: Kept, chosen: NDArray[np.bool_], reach: float
) -> NDArray[np.bool_]:
    """Which places (k, 3) are within `reach` cells of some `chosen` (n,) points, seen along z."""
    patch = problem.patches[0]
    # how many are chosen in the corner below each node
    counts = np.zeros((patch.ny + 1, patch.nx + 1), dtype=np.int64)
    counts[1:, 1:] = patch.view(kept.put(chosen)).cumsum(axis=0).cumsum(axis=1)
    at = (places[:, :2] - kept.nodes.points[:2, 0]) / np.array(patch.spacing)
    sides = np.array([patch.nx, patch.ny])
    first = np.clip(np.ceil(at - reach), 0, sides).astype(np.int64)
    last = np.clip(np.floor(at + reach) + 1, first, sides).astype(np.int64)
    (x0, y0), (x1, y1) = first.T, last.T
    return np.asarray(counts[y1, x1] - counts[y0, x1] - counts[y1, x0] + counts[y0, x0] > 0)


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


def _overlapping(layout: BodyLayout, gap: float) -> str:
    """Bodies that lie in one another before any load may be a slip of the pen."""
    size = float(np.ptp(layout.body.mesh.nodes, axis=0).max())
    if layout.opponent is None or gap >= -OVERLAP * size:
        return ""
    return (
        f"{layout.body.name} and {layout.opponent.name} overlap by up to {-gap:.4g} m before any load: "
        "they are pressed apart by that much"
    )
