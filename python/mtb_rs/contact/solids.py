# SPDX-License-Identifier: MIT OR Apache-2.0
"""Contacts of elastic bodies of any geometry, on the nodes of a grid that lie on them."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, replace
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray

from .. import _mtb_rs
from ..base import cache
from ..base.check import reals, refuse_masked
from ..base.fingerprint import fingerprint
from ..base.plain import plain
from ..base.questions import ask
from ..bodies.elastic_body import ElasticBody
from ..bodies.faces import Hats, hats, joined, owners, parts, profile_parts, thinned
from ..bodies.outline import area, corrected, outline, strip
from ..bodies.outline import covered as covered_share
from ..bodies.sides import ElasticPart
from ..bodies.simple import Simple
from ..bodies.surfaces import BodySurface, height_of
from ..geometry.contact_points import ContactGrid, ContactPoints
from ..geometry.geometries import Geometry, cells_over, check_room, flat_grid, flat_points
from ..geometry.profiles import Profile
from ..geometry.triangles import Surface, height_surface
from ..results.plausible import NARROW, width
from ..results.result import Result
from .estimate import hat_means
from .problem import ContactProblem, Kept
from .standing import Contact, ElasticBodies, Foundation, Standing, averages, condensed_part

Spacing = tuple[float, float]


Array = NDArray[np.float64]
Body = ElasticBody | Simple
#: Upper and lower one.
Bodies = tuple[Body, Body]

#: Share of a cell below which a contact point is left out.
LEAST_SHARE = 0.02

#: Cells of a grid from which on it is counted, before it is laid, how many of them are on the faces; cells
#: along a side of the grid by which they are counted.
MANY_CELLS, FEW_CELLS = 10_000, 32

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

#: Share of a contact face that may have nothing opposite without a word: cells of little area are left out.
BEYOND = 0.01

#: Share of the size of a body by which it may lie in the other one unnoticed.
OVERLAP = 1e-4


@dataclass(frozen=True)
@plain
class OwnBodies(Geometry):
    """The contact face of an elastic body of any geometry, against a plane or another body.

    Contact points lie in the plane z through the end of the face, on a regular grid over its bounding box, or
    over the part of it that another elastic body shares. The gap is that between the faces as their meshes
    lie, from a half-space or a rigid body that of the face from the plane, unless one is given.

    Parameters
    ----------
    body : ElasticBody
    upper : bool
        Whether it is the upper body.
    gap : (ny, nx) [m], function or None
        At the nodes of the grid; or of arrays x, y (n,) [m], the mean over the hats.
    opponent : ElasticBody or None
    step : (dx, dy) [m] or None
        Spacing at which the gap is given; on wider cells it is the mean over the hats of their nodes.
    beside : Profile, BodySurface or None
        Surface of the half-space or rigid body on the other side; None: a plane.
    """

    body: ElasticBody
    upper: bool
    gap: Array | Callable[[Array, Array], Any] | None = None
    opponent: ElasticBody | None = None
    step: Spacing | None = None
    beside: Profile | BodySurface | None = None
    is_body_edge: bool = True
    is_grid: bool = True
    start: None = None

    def grid(self, spacing: tuple[float, float]) -> ContactGrid:
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
        check_room([(nx, ny)], spacing, dense=self._covered(area) if nx * ny > MANY_CELLS else 0.0)
        dx, dy = size[0] / nx, size[1] / ny
        x, y = low[0] + dx * np.arange(nx + 1), low[1] + dy * np.arange(ny + 1)
        gap = np.zeros((ny + 1, nx + 1))
        if isinstance(self.gap, np.ndarray):
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
        return flat_grid(cells, nodes, nx, ny, (float(dx), float(dy)))

    def _covered(self, area: tuple[float, float]) -> float:
        """Share of the bounding box of sides `area` [m] where all elastic faces are, by few cells."""
        few = replace(self, gap=None).grid((area[0] / FEW_CELLS, area[1] / FEW_CELLS))
        faces = [(self.body, self.upper), (self.opponent, not self.upper)]
        covered = [
            body.sample(few.nodes, few.node_patches, upper=upper).weights > 0.0
            for body, upper in faces
            if body is not None
        ]
        return float(np.mean(np.all(covered, axis=0)))

    @property
    def solids(self) -> dict[bool, ElasticBody]:
        """The elastic bodies, by whether each is the upper one, which comes first."""
        found = {self.upper: self.body}
        if self.opponent is not None:
            found[not self.upper] = self.opponent
        return dict(sorted(found.items(), reverse=True))

    def is_coarser_than(self, spacing: Spacing) -> bool:
        """Whether a mesh that was given is too coarse for cells of `spacing` (dx, dy) [m]."""
        return any(body.size is None and _coarse(body, spacing) for body in self.solids.values())

    def level(self) -> float:
        """Height of the contact points [m]: the end of the face."""
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
            x, y = (np.linspace(low[k] - wide[k], high[k] + wide[k], 65) for k in (0, 1))
            beside = height_surface(other, x, y, self._heights_beside(x, y))
        return (beside, own) if self.upper else (own, beside)

    def _heights_beside(self, x: Array, y: Array) -> Array:
        """Heights (ny, nx) [m] of a half-space or rigid body on the other side, for pictures."""
        z = np.full((y.size, x.size), self.level())
        if self.beside is not None:
            z = height_of(self.beside, *np.meshgrid(x, y), upper=not self.upper)
        there = np.isfinite(z)
        return np.where(there, z, z[there].min() if there.any() else self.level())


def _extent(body: ElasticBody, *, upper: bool) -> tuple[Array, Array]:
    """Corners (3,) [m] of the bounding box of a contact face that looks at its opponent."""
    triangles = body.faces[body.contact_faces][:, :3].astype(np.int64)
    a, b, c = (body.mesh.nodes[triangles[:, k]] for k in range(3))
    corners = body.mesh.nodes[np.unique(triangles)]
    low, high = corners.min(axis=0), corners.max(axis=0)
    if min((high - low)[:2]) <= ROUNDING * float(np.ptp(body.mesh.nodes, axis=0).max()):
        raise ValueError(
            f"the contact face of {body.name} measures {high[0] - low[0]:g} x {high[1] - low[1]:g} m in x "
            "and y: it must face along z"
        )
    up = float(np.cross(b - a, c - a)[:, 2].sum())
    if (up > 0.0) == upper:
        looks, must = ("up", "down") if upper else ("down", "up")
        side = "an upper" if upper else "a lower"
        raise ValueError(
            f"the contact face of {body.name} faces {looks}: the contact face of {side} body must face {must}"
        )
    return low, high


def _at_level(points: ContactPoints, level: float) -> ContactPoints:
    moved = points.points.copy()
    moved[2] = level
    return replace(points, points=moved)


def body_contact(
    geometry: OwnBodies, bodies: Bodies, spacing: tuple[float, float], time_s: dict[str, float]
) -> Contact:
    """Upper and lower body condensed, or half-spaces, on the nodes that lie on all elastic faces.

    It is made once for the same bodies, gap and spacing.

    Parameters
    ----------
    bodies : (upper, lower)
    """
    grid = geometry.grid(spacing)
    parts: dict[str, Any] = {
        "grid": grid.spacing,
        "nodes": grid.nodes.points,
        "gap": grid.nodes.gap if isinstance(geometry.gap, np.ndarray) else fingerprint(geometry.gap),
        "carries the grid": "upper" if geometry.upper else "lower",
    }
    for upper, name, body in zip((True, False), ("upper", "lower"), bodies, strict=True):
        solid = geometry.solids.get(upper)
        parts[name] = fingerprint(body) if solid is None else (solid.name, solid.content)
    return cache.recalled(
        cache.content_key(parts), lambda: _condensed_contact(geometry, bodies, grid, time_s)
    )


def _common(
    geometry: OwnBodies, grid: ContactGrid
) -> tuple[dict[bool, Array], Array, _mtb_rs.Sampling, Hats]:
    """What all elastic faces share: how much of each quadrature point of each body, the gap there, the nodes'
    hats on the body that carries the grid, and the contact points with their basis."""
    nodes, patches = grid.nodes, grid.node_patches
    whole = {upper: body.sample(nodes, patches, upper=upper) for upper, body in geometry.solids.items()}
    there, apart = _apart(geometry, whole)
    factor = _factors(geometry, grid, whole)
    covered = {
        upper: np.where(there[upper], factor.ravel()[_cells(sampling, factor.shape)], 0.0)
        for upper, sampling in whole.items()
    }
    whole = {upper: thinned(sampling, covered[upper]) for upper, sampling in whole.items()}
    common = whole[geometry.upper]
    if not common.weights.any():
        raise ValueError("the contact faces of the bodies have no area in common")
    shape = (patches[0].ny, patches[0].nx)
    least = LEAST_SHARE * grid.spacing[0] * grid.spacing[1]
    return covered, apart, common, hats(common, _parts(geometry, whole), apart, shape, least)


def count_points(geometry: OwnBodies, spacing: Spacing) -> int:
    """Number of the contact points on cells of `spacing`, without condensing the bodies."""
    return int(_common(geometry, geometry.grid(spacing))[-1].kept.size)


def _condensed_contact(
    geometry: OwnBodies, bodies: Bodies, grid: ContactGrid, time_s: dict[str, float]
) -> Contact:
    nodes, patches = grid.nodes, grid.node_patches
    solids = geometry.solids
    covered, apart, common, basis = _common(geometry, grid)
    shape = (patches[0].ny, patches[0].nx)
    kept = basis.kept
    own = basis.of(common)
    doubts = [_coarse(body, grid.spacing) for body in solids.values()]
    if isinstance(geometry.gap, np.ndarray):
        rise = np.zeros(kept.size)
    else:
        mean, rise = _means(own, apart)
        gap = np.zeros(nodes.gap.size)
        gap[kept] = mean
        nodes = replace(nodes, gap=gap)
        grid = replace(grid, nodes=nodes)
        if geometry.gap is None:
            doubts.append(_overlapping(geometry, float(mean.min())))
    points = nodes.at(kept)
    places = points.points.copy()
    moved = (basis.place != np.stack([kept % shape[1], kept // shape[1]])).any(axis=0)
    step = np.array(grid.spacing)[:, None]
    places[:2, moved] = nodes.points[:2, :1] + basis.place[:, moved] * step
    points = replace(points, points=places)
    standing: list[Standing] = []
    carriers: dict[bool, ElasticPart] = {}
    for body, upper in zip(bodies, (True, False), strict=True):
        if upper in solids:
            part = ElasticPart(
                solids[upper],
                tuple(patches),
                nodes,
                0,
                upper,
                np.zeros(kept.size),
                np.zeros((0, 9)),
                basis,
                covered=covered[upper],
            )
            flexible = condensed_part(part, time_s)
            standing.append(ElasticBodies((part,), (flexible,), (flexible.compliance,), points))
            carriers[upper] = part
        else:
            first = nodes.points[:, patches[0].start]
            place = float(first[0]), float(first[1]), patches[0].nx, patches[0].ny
            cut = cast(Simple, body).on_cut_hats(basis, common, (place, patches[0].spacing))
            standing.append(Foundation(cut, points, upper))
    return Contact(
        points=points,
        area=own.weights,
        patches=patches,
        is_grid=True,
        upper=standing[0],
        lower=standing[1],
        averages=averages([carriers[geometry.upper]]),
        kept=Kept(nodes, kept, rise, basis.on),
        doubts=tuple(doubt for doubt in doubts if doubt),
        beyond=_beyond(geometry, float(own.weights.sum())),
    )


def _apart(
    geometry: OwnBodies, whole: Mapping[bool, _mtb_rs.Sampling]
) -> tuple[dict[bool, NDArray[np.bool_]], Array]:
    """Which quadrature points of each sampling the other body has as well, and the gap (q,) [m] at these."""
    found = {
        upper: np.ones(sampling.arrays()["weight"].size, dtype=bool) for upper, sampling in whole.items()
    }
    if len(whole) == 2:
        places = {upper: _numbers(sampling) for upper, sampling in whole.items()}
        found = {upper: np.isin(places[upper], places[not upper]) for upper in whole}
    common = thinned(whole[geometry.upper], found[geometry.upper])
    if isinstance(geometry.gap, np.ndarray):
        return found, np.zeros(common.arrays()["weight"].size)
    x, y = _places(geometry, common)
    apart: Array = np.zeros(x.size)
    if geometry.gap is not None:
        apart = function_values("gap", geometry.gap, x, y)
    else:
        for upper in (True, False):
            if upper in geometry.solids:
                height = geometry.solids[upper].heights(thinned(whole[upper], found[upper]))
            elif geometry.beside is not None:
                height = height_of(geometry.beside, x, y, upper=upper)
                if not np.isfinite(height).any():
                    _check_outlook(geometry.beside, x, y, upper=upper)
            else:
                height = np.full(x.size, geometry.level())
            apart = apart + height if upper else apart - height
    there = np.isfinite(apart)
    for upper, mask in found.items():
        mask[np.flatnonzero(mask)[~there]] = False
        found[upper] = mask
    return found, apart[there]


def _cells(sampling: _mtb_rs.Sampling, shape: tuple[int, ...]) -> NDArray[np.int64]:
    """Number of the cell (rows, columns) that each quadrature point is in."""
    node = sampling.arrays()["point"].reshape(-1, 4)[:, 0].astype(np.int64)
    row, column = np.divmod(node, shape[1] + 1)
    return np.asarray(row * shape[1] + column)


def _factors(geometry: OwnBodies, grid: ContactGrid, whole: Mapping[bool, _mtb_rs.Sampling]) -> Array:
    """Factors (rows, columns) on the weights in each cell, which make the area of cut cells exact.

    An outline of either body and the ends of a profile are known; where two of them cross in one cell, each
    takes its share of what the other leaves.
    """
    x, y = (ends + grid.nodes.points[k, 0] - ends[0] for k, ends in enumerate(grid.node_patches[0].axes()))
    shape = y.size - 1, x.size - 1
    factor = np.ones(shape)
    for upper, sampling in whole.items():
        weight = np.bincount(_cells(sampling, shape), sampling.arrays()["weight"], factor.size)
        counted = weight.reshape(shape) / (grid.spacing[0] * grid.spacing[1])
        factor *= corrected(covered_share(_outline(geometry.solids[upper], upper=upper), x, y), counted)
    if isinstance(geometry.beside, Profile):
        value = whole[geometry.upper].arrays()["value"].reshape(-1, 4)
        along = np.unique(np.round(value[:, 2] + value[:, 3], 9))
        start, end = geometry.beside.range
        places = y[:-1, None] + along * np.diff(y)[:, None]
        counted = ((places >= start) & (places <= end)).mean(axis=1)
        factor *= corrected(strip(start, end, y)[:, None], counted[:, None])
    return factor


def _outline(body: ElasticBody, *, upper: bool) -> Array:
    """Outline (k, 2, 2) [m] of a contact face."""
    faces = body.faces[body.contact_faces].astype(np.int64)
    return outline(body.mesh.nodes, faces, upward=not upper)


def _beyond(geometry: OwnBodies, common: float) -> tuple[str, float] | None:
    """The upper body and the share of its contact face (name, share) that has nothing opposite.

    None where the face of the other body ends nowhere in it, as what lies on a larger one may be small.
    """
    shares = [
        (body.name, 1.0 - common / area(_outline(body, upper=upper)))
        for upper, body in geometry.solids.items()
    ]
    is_cut = True in geometry.solids and all(share > BEYOND for _, share in shares)
    return shares[0] if is_cut else None


def _check_outlook(surface: Profile | BodySurface, x: Array, y: Array, *, upper: bool) -> None:
    """An open surface whose outer side does not face the other body may be wound the other way round."""
    if np.isfinite(height_of(surface, x, y, upper=not upper)).any():
        name, looks, must = ("upper", "up", "down") if upper else ("lower", "down", "up")
        raise ValueError(
            f"the surface of the {name} body faces {looks} where the elastic body lies: it must face {must}; "
            "reverse the order of the corners of its triangles"
        )


def function_values(name: str, function: Callable[[Array, Array], Any], x: Array, y: Array) -> Array:
    """Values (q,) [m] of a function of arrays x, y [m]; infinite where there is no body."""
    try:
        found = function(x, y)
    except Exception as error:
        raise ValueError(
            f"the function {name} fails with {type(error).__name__}: {error}; "
            "a function of the arrays x and y (n,) [m] is needed"
        ) from error
    what = f"what the function {name} returns"
    if isinstance(found, np.ndarray) and found.dtype.kind == "f":
        refuse_masked(what, found, "m")
        is_open = np.isposinf(found)
        values = np.where(is_open, np.inf, reals(what, np.where(is_open, 0.0, found), "m"))
    else:
        values = reals(what, found, "m")
    if values.shape not in (x.shape, ()):
        raise ValueError(
            f"the function {name} returns shape {values.shape}: {x.shape} is needed, as x and y have"
        )
    return np.broadcast_to(values, x.shape)


def _numbers(sampling: _mtb_rs.Sampling) -> NDArray[np.int64]:
    """A number for each quadrature point: its cell, and where in it."""
    arrays = sampling.arrays()
    point, value = arrays["point"].reshape(-1, 4).astype(np.int64), arrays["value"].reshape(-1, 4)
    along = np.floor(SHARES * np.stack([value[:, 1] + value[:, 3], value[:, 2] + value[:, 3]]))
    cell = point[:, 0] * SHARES + along[0].astype(np.int64)
    return np.asarray(cell * SHARES + along[1].astype(np.int64))


def _places(geometry: OwnBodies, sampling: _mtb_rs.Sampling) -> tuple[Array, Array]:
    """Coordinates x, y (q,) [m] of the quadrature points of a sampling of the body that carries the grid."""
    body, arrays = geometry.body, sampling.arrays()
    faces = body.faces[arrays["face"].astype(np.int64)].astype(np.int64)
    x, y, _ = np.einsum("kq,qkc->cq", body.face_shape(arrays["barycentric"]), body.mesh.nodes[faces])
    return x, y


def _parts(geometry: OwnBodies, whole: Mapping[bool, _mtb_rs.Sampling]) -> NDArray[np.int64]:
    """Part (q,) of the faces at each common quadrature point: kinks of both bodies divide them."""
    labels = []
    for upper in (True, False):
        if upper in geometry.solids:
            body = geometry.solids[upper]
            number = np.zeros(len(body.faces), dtype=np.int64)
            number[body.contact_faces.astype(np.int64)] = parts(body)
            labels.append(number[whole[upper].arrays()["face"].astype(np.int64)])
        elif isinstance(geometry.beside, Profile):
            labels.append(profile_parts(geometry.beside, _places(geometry, whole[geometry.upper])[1]))
    return joined(labels)


def _means(sampling: _mtb_rs.Sampling, apart: Array) -> tuple[Array, Array]:
    """Gap (n,) [m], the mean over the basis of each contact point, and its rise there.

    The displacements are means over it as well: so a curved face or one that ends within a cell is met with
    the same order as a flat one.
    """
    arrays, n = sampling.arrays(), sampling.n_points
    owner, points = owners(arrays), arrays["point"].astype(np.int64)
    gap = np.bincount(points, arrays["value"] * (arrays["weight"] * apart)[owner], n) / sampling.weights
    low, high = np.full(n, np.inf), np.full(n, -np.inf)
    np.minimum.at(low, points, apart[owner])
    np.maximum.at(high, points, apart[owner])
    return gap, high - low


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


def check_faces(bodies: Iterable[ElasticBody], problem: ContactProblem, result: Result) -> None:
    """Warns where faces are steep as they touch, part within a cell, or have facets that are not small."""
    assert problem.kept is not None
    touching = result.status.ravel()[problem.kept.numbers] > 0
    gap = result.gap.ravel()[problem.kept.numbers]
    if not _check_edges(problem, problem.kept, touching, gap):
        _check_width(problem, problem.kept, touching)
    closed = float(np.ptp(problem.points.gap[touching]))
    for body in bodies:
        faces = body.faces[body.contact_faces].astype(np.int64)
        middles = body.mesh.nodes[faces[:, :3]].mean(axis=1)
        near = _beside(middles, problem, problem.kept, touching, 2.0)
        slope = _slope(body, faces[near])
        if slope > STEEP:
            ask(
                [
                    f"the contact face of {body.name} has a slope of {slope:.2g} where it touches: pressure "
                    "and gap are taken along z, friction along x and y, which is right for small slopes only"
                ]
            )
        sag = _sagitta(body, faces[near])
        if closed > 0.0 and sag > max(
            FACETS * closed, ROUNDING * float(np.ptp(body.mesh.nodes, axis=0).max())
        ):
            ask(
                [
                    f"the contact face of {body.name} is made of flat facets, about {sag:.2g} m off the "
                    f"smooth surface they may stand for; the contact closes a gap of {closed:.2g} m. Give "
                    "smaller facets, elements of second order with their nodes on the surface, or gap"
                ]
            )


def _check_edges(problem: ContactProblem, kept: Kept, touching: NDArray[np.bool_], gap: Array) -> bool:
    """The gap of a node is the mean over its cells: where it opens all at once, they do not know the edge."""
    places = problem.points.points
    near = np.zeros(touching.size, dtype=bool)
    for part in np.unique(kept.part[touching]):
        # at a kink the edge is known
        own = kept.part == part
        near |= own & _beside(places.T, problem, kept, touching & own, 1.01)
    if touching[near].all():
        return False
    worst = np.flatnonzero(near)[kept.rise[near].argmax()]
    closed = float(np.ptp((problem.points.gap - gap)[near]))
    is_abrupt = bool(kept.rise[worst] > ABRUPT * closed)
    if is_abrupt:
        x, y = places[:2, worst]
        dx, dy = problem.patches[0].spacing
        ask(
            [
                f"the gap opens by {kept.rise[worst]:.2g} m within the cells at the edge of the contact, "
                f"near x = {x:.4g}, y = {y:.4g} m, where the bodies close by {closed:.2g} m: the edge is "
                f"known to a cell of {dx:.3g} x {dy:.3g} m only. Give a narrower spacing, or end the "
                "contact face where it turns away"
            ]
        )
    return is_abrupt


def _check_width(problem: ContactProblem, kept: Kept, touching: NDArray[np.bool_]) -> None:
    """A contact that ends on both sides within a face needs some cells over its width."""
    patch = problem.patches[0]
    on_face = patch.view(kept.put(np.ones(touching.size, dtype=bool), False))
    closed = patch.view(kept.put(touching, False))
    for k, name in enumerate("xy"):
        lines, bodies = (closed, on_face) if k == 0 else (closed.T, on_face.T)
        if width(lines, bodies) <= NARROW:
            ask(
                [
                    f"the contact is at most {NARROW} points wide along {name}, at a spacing of "
                    f"{patch.spacing[k]:.3g} m: its width and its pressure are not resolved; "
                    "a narrower spacing is needed"
                ]
            )
            return


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


def _overlapping(geometry: OwnBodies, gap: float) -> str:
    """Bodies that lie in one another before any load may be a slip of the pen."""
    size = float(np.ptp(geometry.body.mesh.nodes, axis=0).max())
    if geometry.opponent is None or gap >= -OVERLAP * size:
        return ""
    return (
        f"{geometry.body.name} and {geometry.opponent.name} overlap by up to {-gap:.4g} m before any load: "
        "they are pressed apart by that much"
    )
