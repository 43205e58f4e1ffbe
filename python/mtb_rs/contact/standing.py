# SPDX-License-Identifier: MIT OR Apache-2.0
"""Bodies where they stand in a contact: on its points, and what each load makes of them.

What stands is made once for its geometry, its materials and its supports (:func:`standing`); loads, friction,
velocity and direction are applied to it.
"""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from .. import _mtb_rs
from ..base.cache import Memory
from ..base.errors import ToleranceWarning
from ..base.plain import plain
from ..base.questions import ask
from ..bodies.elastic_body import Condensed
from ..bodies.prism import Prism, too_thin
from ..bodies.sides import ElasticPart, Side
from ..bodies.simple import Simple
from ..geometry.contact_points import ContactPoints, Patch
from .problem import Averages, Kept, core_geometry, to_global
from .refined import DIRECT_PAIR, REFINED_POINT, Lines, refined

Array = NDArray[np.float64]


class Standing(Protocol):
    """A body on its contact points, without what presses it."""

    @property
    def centre(self) -> Array | None:
        """Centre of volume (3,) [m] of a body whose supports hold it; None where only its load presses it."""

    def side(self, pull: Array, wrench: Array) -> Side:
        """The body under its load.

        Parameters
        ----------
        pull : (n,) [Pa]
            Magnetic pressure on it.
        wrench : (6,)
            Force [N] and moment about its centre of volume [N m] spread over it.
        """


@dataclass(frozen=True)
@plain
class Foundation:
    """A half-space or a rigid body (`compliance` None) on contact points.

    Unless `is_pulled_at_face` its pull does not move its face: only the resultant presses it.
    """

    compliance: _mtb_rs.Compliance | None
    points: ContactPoints
    upper: bool
    is_pulled_at_face: bool = True
    centre: None = None
    notes: tuple[str, ...] = ()

    def side(self, pull: Array, wrench: Array) -> Side:
        n = self.points.gap.size
        return Side(
            self.compliance,
            np.zeros((3, n)),
            np.zeros((0, 3, n)),
            np.zeros((0, 9)),
            np.zeros(0),
            pull,
            np.zeros(0, dtype=bool),
            is_pulled_at_face=self.is_pulled_at_face,
        )


@dataclass(frozen=True)
@plain
class ElasticBodies:
    """Finite elements side by side on contact points.

    Attributes
    ----------
    parts : tuple of ElasticPart
        Without loads.
    condensed : tuple of Condensed
    compliances : tuple of Compliance
        Of each part.
    points : ContactPoints
        All contact points of the parts.
    image : (n,) int or None
        The mirror image of each point of the whole, where the only part is half of a symmetric body.
    compliance : Compliance
        Of all of them, on all points.
    """

    parts: tuple[ElasticPart, ...]
    condensed: tuple[Condensed, ...]
    compliances: tuple[_mtb_rs.Compliance, ...]
    points: ContactPoints
    image: NDArray[np.intp] | None = None
    compliance: _mtb_rs.Compliance = field(init=False, compare=False)

    def __post_init__(self) -> None:
        own = list(self.compliances)
        whole = own[0] if len(own) == 1 else _mtb_rs.Compliance.separate(own)
        if self.image is not None:
            whole = whole.symmetric_whole(self.image.tolist())
        object.__setattr__(self, "compliance", whole)

    @property
    def centre(self) -> Array:
        return self.condensed[0].centre

    def side(self, pull: Array, wrench: Array) -> Side:
        parts = [
            replace(p, pull=pull[p.first : p.first + p.pull.size], spread=wrench).on(c)
            for p, c in zip(self.parts, self.condensed, strict=True)
        ]
        side = replace(
            elastic_side(parts, self.condensed, self.points), compliance=self.compliance, pull=pull
        )
        if self.image is None:
            return side
        mirrored = side.displacement[:, self.image[self.points.gap.size :]] * np.array([[1.0], [-1.0], [1.0]])
        return replace(
            side,
            displacement=np.concatenate([side.displacement, mirrored], axis=1),
            motions=np.zeros((0, 3, self.image.size)),
        )


@dataclass(frozen=True)
@plain
class Contact:
    """Two bodies that stand on each other, without what presses them.

    Attributes
    ----------
    points : ContactPoints
        Contact points.
    area : (n,) [m2]
    patches : tuple of Patch
        The grids that the contact points are nodes or cells of.
    is_grid : bool
        Whether results have the shape (ny, nx) of one grid.
    upper, lower : Standing
    averages : Averages or None
        For unknowns that are coefficients of hats.
    kept : Kept or None
        Where not all points of the grids are contact points.
    doubts : tuple of str
        What its geometry makes doubtful, in whole sentences.
    beyond : (name, share) or None
        The body of which this share of the contact face has nothing opposite.
    memory : Memory
        What is made of the bodies for one load and serves the next.
    windows : tuple of Patch
        The grids beyond which the bodies go on.
    notes : tuple of str
        What there is to say of the bodies, in sentences.
    """

    points: ContactPoints
    area: Array
    patches: tuple[Patch, ...]
    is_grid: bool
    upper: Standing
    lower: Standing
    averages: Averages | None = None
    kept: Kept | None = None
    doubts: tuple[str, ...] = ()
    beyond: tuple[str, float] | None = None
    memory: Memory = field(default_factory=Memory)
    windows: tuple[Patch, ...] = ()
    notes: tuple[str, ...] = ()

    @property
    def nbytes(self) -> float:
        """Memory of the matrices [bytes] at most.

        Cells have two of the pair, and those of its mirror half. Hats have the blocks of both bodies as well,
        but those of bodies that are condensed onto fewer points have tables.
        """
        sides = [side for side in (self.upper, self.lower) if isinstance(side, ElasticBodies)]
        if any(c.refined is not None for side in sides for c in side.condensed):
            return REFINED_POINT * self.area.size
        pair = 8.0 * 2.5 if self.averages is None else DIRECT_PAIR
        return pair * self.area.size**2

    @property
    def shape(self) -> tuple[int, ...]:
        """Of the fields of a result, over all points of the grids."""
        grid = self.patches[0]
        return (grid.ny, grid.nx) if self.is_grid else (self.area.size,)

    @property
    def geometry(self) -> _mtb_rs.ContactGeometry:
        """The contact points as the core has them."""
        return core_geometry(self.memory, self.points, self.area, self.averages, self.windows)

    def load_of(self, pull: Array) -> Array:
        """Load (3, n) [N] on the upper body by a magnetic pressure (n,) [Pa]."""
        return np.asarray(-(pull * self.area * self.normals))

    @property
    def normals(self) -> Array:
        """Mean normals (3, n) of the contact points: what loads and rigid motions see."""
        return self.points.normal if self.averages is None else self.averages.frames[2]

    @property
    def places(self) -> Array:
        """Where the load of each contact point acts (3, n) [m]."""
        return self.points.points if self.averages is None else self.averages.places

    def middle(self, patch: Patch) -> Array:
        """The middle (3,) [m] of a grid."""
        points = self.points if self.kept is None else self.kept.nodes
        return np.asarray(points.points[:, patch.cut].mean(axis=1))


def cells_of(
    body: Simple | Prism, points: ContactPoints, patches: Sequence[Patch], *, upper: bool
) -> Foundation:
    """A half-space or rigid body under cells. One below carries all patches, each above is its own.

    Above, this is the thesis' basic model: only the resultant of the pull counts.
    """
    if isinstance(body, Prism):
        return _on_prism(body, points, patches, hats=False)
    return Foundation(
        body.on_cells([((*p.origin, p.nx, p.ny), p.spacing) for p in patches], interact=not upper),
        points,
        upper,
        is_pulled_at_face=not upper,
    )


def hats_of(
    body: Simple | Prism, points: ContactPoints, patches: Sequence[Patch], *, upper: bool
) -> Foundation:
    """A half-space or rigid body under the hats of elastic bodies, as :func:`cells_of`."""
    if isinstance(body, Prism):
        return _on_prism(body, points, patches, hats=True)
    return Foundation(
        body.on_hats([((*p.origin, p.nx, p.ny), p.spacing) for p in patches], interact=not upper),
        points,
        upper,
    )


def _on_prism(body: Prism, points: ContactPoints, patches: Sequence[Patch], *, hats: bool) -> Foundation:
    """A prism below the contact points, which are nodes or cells of patches."""
    made = body.on(points, patches, hats=hats)
    ask(too_thin(made.tail), kind=ToleranceWarning)
    return Foundation(made.compliance, points, upper=False, notes=(made.note,))


def condensed_part(part: ElasticPart, time_s: dict[str, float], lines: Lines | None = None) -> Condensed:
    """A body on its contact points; with `lines` of its grids, condensed onto the hats between these.

    Raises
    ------
    NotRefinedError
    """
    clock = time.perf_counter()
    sampling = part.sampling()
    if lines is None:
        flexible = part.body.condense(sampling)
    else:
        coarse = part.body.condense(sampling.on_lines(lines))
        flexible = refined(coarse, part.body.material, lines, part.patches, half=part.is_half)
    time_s["condensation"] = time_s.get("condensation", 0.0) + time.perf_counter() - clock
    return flexible


def elastic_side(
    parts: Sequence[ElasticPart],
    condensed: Sequence[Condensed],
    points: ContactPoints,
) -> Side:
    """Elastic bodies side by side: what is given to them, their free motions."""
    n = points.points.shape[1]
    displacement = np.zeros((3, n))
    motions: list[Array] = []
    work: list[float] = []
    for part, flexible in zip(parts, condensed, strict=True):
        into = 1.0 if part.upper else -1.0
        cut = slice(part.first, part.first + part.pull.size)
        given = part.body.given_displacement(flexible)
        given += np.einsum("k,kcn->cn", part.spread, flexible.spread_displacement)
        given[2] *= into
        own = part.own_points()
        displacement[:, cut] = to_global(given, own)
        works = part.body.given_work(flexible) + flexible.spread_work(part.spread)
        for mode, amount in zip(flexible.mode_displacement, works, strict=True):
            local = mode * np.array([[1.0], [1.0], [into]])
            whole = np.zeros((3, n))
            whole[:, cut] = to_global(local, own)
            motions.append(whole)
            work.append(float(amount))
    return Side(
        None,
        displacement,
        np.array(motions).reshape(-1, 3, n),
        np.concatenate([part.modes for part in parts]),
        np.array(work),
        np.concatenate([part.pull for part in parts]),
        np.ones(len(work), dtype=bool),
        includes_motion=True,
        state=tuple(parts),
        operations=sum({id(c.flexibility): c.operations for c in condensed}.values()),
    )


def averages(parts: Sequence[ElasticPart]) -> Averages:
    """Averages over the contact points of elastic bodies side by side."""
    frames, places, starts, columns, shares = [], [], [np.zeros(1, dtype=np.uintp)], [], []
    entries = 0
    for part in parts:
        frame, place, (start, column, share) = part.body.core_mesh.averages(part.sampling())
        if part.upper:
            # the upper body's face lies a gap above the points
            nodes = part.own_points()
            place -= nodes.gap * nodes.normal
        else:
            frame[2] *= -1.0  # the third direction of a lower body points into it, against the normal
        frames.append(frame)
        places.append(place)
        starts.append(start[1:] + entries)
        columns.append(column + part.first)
        shares.append(share)
        entries += share.size
    rows = np.concatenate(starts), np.concatenate(columns), np.concatenate(shares)
    return Averages(np.concatenate(frames, axis=2), np.concatenate(places, axis=1), *rows)
