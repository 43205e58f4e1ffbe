# SPDX-License-Identifier: MIT OR Apache-2.0
"""The contact problem at its points: two bodies, a gap, loads, friction; and its solution."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .. import _mtb_rs
from ..base.cache import Memory
from ..base.plain import plain
from ..base.words import Model
from ..bodies.sides import ElasticPart, Side
from ..friction.fields import Coefficients
from ..friction.rough_law import RoughLaw
from ..geometry.contact_points import ContactPoints, Patch, tangents_of
from . import refined

Array = NDArray[np.float64]

#: Part of a yield stress by which friction may be below it where the layer yields: rounding.
YIELDED = 1e-9


@dataclass(frozen=True)
@plain
class Kept:
    """Which nodes of regular grids are contact points, where the others lie beside a body.

    Attributes
    ----------
    nodes : ContactPoints
        All nodes of the grids.
    numbers : (n,) int
        The contact points among them.
    rise : (n,) [m]
        Of the gap between the faces of the bodies over the cells around each contact point.
    part : (n,) int
        Part of the faces that each is on: kinks divide them.
    """

    nodes: ContactPoints
    numbers: NDArray[np.intp]
    rise: Array
    part: NDArray[np.int64]

    def put(self, values: NDArray[Any], rest: NDArray[Any] | float = 0.0) -> NDArray[Any]:
        """`values` (..., n) at the contact points and `rest` beside them, at all nodes (..., N)."""
        out = np.empty((*values.shape[:-1], self.nodes.gap.size), dtype=values.dtype)
        out[...] = rest
        out[..., self.numbers] = values
        return out


@dataclass(frozen=True)
@plain
class Attracting:
    """A magnet whose pull follows the gap.

    Attributes
    ----------
    circuit : MagneticCircuit
    factor : float
        Of the speed.
    bodies : list of (bool, bool)
        Of each body that it pulls, whether it is the upper one, and whether the pull moves its face.
    from_touching : bool
        Whether its state is looked for from bodies that touch.
    under : function
        The problem under a pull (n,) [Pa].
    """

    circuit: _mtb_rs.MagneticCircuit
    factor: float
    bodies: list[tuple[bool, bool]]
    from_touching: bool
    under: Callable[[Array], ContactProblem] = field(compare=False)

    @property
    def given(self) -> tuple[_mtb_rs.MagneticCircuit, list[tuple[bool, bool]], float]:
        """As the core takes it."""
        return self.circuit, self.bodies, self.factor

    def at_gap(self, gap: Array) -> Array:
        """Its pull (n,) [Pa] over gaps (n,) [m]."""
        return self.circuit.attract(np.ascontiguousarray(gap), self.factor)[0]

    def start(self, n: int, *, other: bool = False) -> Array | None:
        """The pull to look for the state from, or for the other one; None: that at the gap of the bodies."""
        return self.at_gap(np.zeros(n)) if self.from_touching != other else None


@dataclass(frozen=True)
@plain
class ContactProblem:
    """Everything the solver needs, at the contact points.

    Attributes
    ----------
    points : ContactPoints
    area : (n,) [m2]
    patches : tuple of Patch
        The grids that the contact points are nodes or cells of.
    friction
        At the contact points.
    direction : (2, n) [-]
        Sliding direction of the upper body in the tangent plane; zero where nothing slides.
    gap : (n,) [m]
        Undeformed gap, prescribed approach taken off.
    shape : tuple of int
        Of the fields of a result, over all points of the grids.
    averages : Averages or None
        For unknowns that are coefficients of hats; None where they are pressures of cells.
    kept : Kept or None
        Where not all points of the grids are contact points.
    windows : tuple of Patch
        The grids beyond which the bodies go on, so that no pressure may reach their edge.
    notes : tuple of str
        What there is to say of the bodies, in sentences.
    layer : (n,) or None [m/Pa]
        Flexibility of a layer between the bodies at each point; None for none.
    attracting : Attracting or None
        A magnet whose pull follows the gap. The sides then have its pull at the gap of the problem, and
        :meth:`settled` gives them that of a solution.
    magnet : Settled or None
        What was found of this magnet, where the pull is that of a solution.
    hardness : (n,) or None [Pa]
        Pressure at which one body flows, at each point; None for bodies that stay elastic.
    shear : (n,) or None [Pa]
        Yield stress of a layer between the bodies, the largest friction that it transmits; None for none.
    rough : RoughLaw or None
        Law of a rough layer between the bodies.
    moments : (mx, my) [N m]
        That the scene states for a body whose forces are not those of a part of the problem: for messages.
    memory : Memory
        What depends on the bodies alone; further loads on the same ones share it.
    """

    points: ContactPoints
    area: Array
    patches: tuple[Patch, ...]
    friction: Coefficients
    direction: Array
    gap: Array
    upper: Side
    lower: Side
    model: Model
    approach: float | None
    loads: Mapping[str, Any]
    shape: tuple[int, ...]
    averages: Averages | None = None
    time_s: dict[str, float] = field(default_factory=dict)
    kept: Kept | None = None
    memory: Memory = field(default_factory=Memory)
    windows: tuple[Patch, ...] = ()
    moments: tuple[float, float] = (0.0, 0.0)
    notes: tuple[str, ...] = ()
    layer: Array | None = None
    attracting: Attracting | None = None
    magnet: _mtb_rs.Settled | None = None
    hardness: Array | None = None
    rough: RoughLaw | None = None
    shear: Array | None = None

    @property
    def n(self) -> int:
        """Number of contact points."""
        return int(self.area.size)

    @property
    def geometry(self) -> _mtb_rs.ContactGeometry:
        """The contact points as the core has them: tangents of sliding, means and resultants are its own."""

        return core_geometry(self.memory, self.points, self.area, self.averages, self.windows)

    @property
    def core(self) -> _mtb_rs.Problem:
        """The bodies on their points with the motions that are free: what stays while loads change."""
        upper, lower = self.upper, self.lower
        motions = np.ascontiguousarray(np.concatenate([upper.motions, lower.motions]))
        of_upper = [True] * upper.work.size + [False] * lower.work.size
        is_pulled = [*upper.is_pulled.tolist(), *lower.is_pulled.tolist()]
        # what it is made of is what it is found again by
        bodies = lower.compliance, upper.compliance
        made_from = (
            *(*bodies, self.geometry, motions, of_upper),
            *(is_pulled, refined.PRODUCTS_FROM, self.layer),
            *(self.hardness, self.shear, None if self.rough is None else self.rough.core),
        )
        return self.memory.recall("problem", made_from, lambda: _mtb_rs.Problem(*made_from))

    @cached_property
    def turn(self) -> Array:
        """Parts (2, 2, n) along :func:`tangents_of` the surface of unit vectors along rows and columns."""
        tangents = tangents_of(self.points.normal)
        return np.asarray(np.einsum("kcn,icn->kin", tangents, frame_of(self.points)[:2]))

    @cached_property
    def loading(self) -> _mtb_rs.Loading:
        """Gap (n,) [m] before contact and generalised loads (m,) [J] on the free motions, by all loads."""
        return self.loading_by(self.upper.pull, self.lower.pull)

    @property
    def attraction(self) -> Array:
        """Magnetic pressure (n,) [Pa] between the bodies."""
        return self.upper.pull

    @property
    def free_loading(self) -> _mtb_rs.Loading:
        """The loading without attraction."""
        return self.loading_by(np.zeros(self.n), np.zeros(self.n))

    def settled(self, solution: Solution) -> ContactProblem:
        """The problem under the pull of its solution, where a magnet follows the gap; elsewhere itself."""
        if self.attracting is None or solution.settled is None:
            return self
        under = self.attracting.under(solution.settled.pull)
        return replace(
            self,
            upper=under.upper,
            lower=under.lower,
            loads=under.loads,
            attracting=None,
            magnet=solution.settled,
        )

    def loading_by(self, upper_pull: Array, lower_pull: Array) -> _mtb_rs.Loading:
        """The same with other attractions (n,) [Pa] of the bodies."""
        core = self.core
        loading = core.loading(
            np.ascontiguousarray(self.gap), np.concatenate([self.upper.work, self.lower.work])
        )
        for side, pull, is_upper in ((self.upper, upper_pull, True), (self.lower, lower_pull, False)):
            if side.displacement.any():
                displacement = np.ascontiguousarray(side.displacement)
                loading = core.with_displacement(loading, displacement, is_upper)
            if pull.any():
                loading = core.with_pull(
                    loading, np.ascontiguousarray(pull), is_upper, side.is_pulled_at_face
                )
        return loading

    @property
    def work(self) -> tuple[Array, Array]:
        """Generalised loads [J], all but the contact's, on each motion of the upper and the lower body."""
        work, m = self.loading.work, self.upper.work.size
        return work[:m], work[m:]

    @property
    def operations(self) -> float:
        """Floating-point operations of the condensation of both bodies."""
        return self.upper.operations + self.lower.operations

    @property
    def places(self) -> Array:
        """Where the load of each contact point acts (3, n) [m]."""
        return self.points.points if self.averages is None else self.averages.places

    def friction_at(self, pressure: Array) -> Array:
        """Friction over pressure (n,): the coefficient, or less where a layer yields."""
        return self.capped(self.friction.at(pressure), pressure)

    def capped(self, friction: Array, pressure: Array) -> Array:
        """Friction over pressure (n,) by coefficients (n,): less than these where a layer yields."""
        if self.shear is None:
            return friction
        over = friction * pressure > self.shear
        return np.where(over, self.shear / np.where(over, pressure, 1.0), friction)

    def sheared(self, friction: Array, pressure: Array) -> Array | None:
        """Friction of coefficients (n,) over the stress (n,) at which a layer yields; None without one."""
        return None if self.shear is None else friction * pressure / self.shear

    def yields(self, friction: Array, pressure: Array) -> NDArray[np.bool_]:
        """Which points (n,) slide by the yielding of a layer, with this friction over the pressure (n,)."""
        if self.shear is None:
            return np.zeros(self.n, dtype=bool)
        return np.asarray((pressure > 0.0) & (friction * pressure >= self.shear * (1.0 - YIELDED)))

    @property
    def parts(self) -> tuple[ElasticPart, ...]:
        """The elastic bodies of finite elements, the upper ones first."""
        return self.upper.state + self.lower.state

    @property
    def pressing(self) -> Array:
        """The load (3,) [N] that presses the bodies together, where it is known; zeros elsewhere."""
        return np.asarray(self.loads.get("pull", self.loads.get("magnetic", np.zeros(3))))

    def without_friction(self) -> ContactProblem:
        """The same bodies at rest under the same loads; what it takes is not counted."""
        return replace(self, direction=np.zeros_like(self.direction), time_s={})

    @property
    def relative_motions(self) -> Array:
        """Motions as (m, 3, n) of lower minus upper along the tangents and of the opening."""
        return self.core.motions

    def axes(self) -> list[tuple[Patch, Array, Array]]:
        """Each patch with the coordinates [m] of its columns (x) and rows (arc length)."""
        return [(patch, *patch.axes()) for patch in self.patches]

    def on_grid(self, values: NDArray[Any], rest: NDArray[Any] | float = 0.0) -> NDArray[Any]:
        """`values` (..., n) of the contact points at all points of the grids; `rest` beside the bodies."""
        return values if self.kept is None else self.kept.put(values, rest)


@dataclass(frozen=True)
@plain
class Solution:
    """Pressures and what is known about them."""

    pressure: Array
    gap: Array
    motion: Array
    friction: Array
    status: str
    solver: str
    iterations: int
    residual: float
    #: mu / mu_sym
    wedging_margin: float | None
    #: None: not known
    unstable: bool | None = False
    convolutions: float = 0.0
    preconditionings: float = 0.0
    operations: float = 0.0
    notes: tuple[str, ...] = ()
    settled: _mtb_rs.Settled | None = None

    def coefficients(self, problem: ContactProblem) -> Array:
        """The unknowns (3, n) [Pa]: traction along both tangents on the lower body, and pressure."""
        return sliding_tractions(self.pressure, self.friction, problem.direction)


def frame_of(points: ContactPoints) -> Array:
    """(tangent x, tangent y, normal) of each point (3, 3, n)."""
    return np.stack([points.tangent_x, points.tangent_y, points.normal])


def to_global(components: Array, points: ContactPoints) -> Array:
    """Vectors (..., 3, n) in the common frame from the frame (tangent x, tangent y, normal) of each point."""
    return np.asarray(np.einsum("cin,...cn->...in", frame_of(points), components))


def core_geometry(
    memory: Memory,
    points: ContactPoints,
    area: Array,
    averages: Averages | None,
    windows: tuple[Patch, ...],
) -> _mtb_rs.ContactGeometry:
    """Contact points as the core has them, made once for all loads on them."""

    def build() -> _mtb_rs.ContactGeometry:
        means = None
        unit = mean = frame_of(points)
        places = points.points
        if averages is not None:
            means = averages.start.tolist(), averages.column.tolist(), averages.share
            mean, places = averages.frames, averages.places
        return _mtb_rs.ContactGeometry(
            np.ascontiguousarray(places),
            np.ascontiguousarray(area),
            [np.ascontiguousarray(field) for field in (*unit, *mean)],
            means,
            [(grid.start, grid.nx, grid.ny) for grid in windows],
        )

    # objects of the contact, the same ones for every load: they are compared by what they are, not read
    return memory.recall("geometry", [points, area, averages, windows], build)


def sliding_direction(
    direction: tuple[float, float] | None, geometry: _mtb_rs.ContactGeometry, n: int
) -> Array:
    """Unit sliding direction (2, n) in each tangent plane; zeros where nothing slides."""
    if direction is None:
        return np.zeros((2, n))
    vector = np.array([direction[0], direction[1], 0.0])
    if not np.isfinite(vector).all() or not vector.any():
        raise ValueError(f"sliding_direction is {direction}: two finite numbers, not both zero, are needed")
    vector = vector / np.abs(vector).max()
    try:
        return geometry.sliding_direction((float(vector[0]), float(vector[1])))
    except ValueError as error:
        raise ValueError(f"sliding_direction is {direction}: {error}") from None


def sliding_tractions(pressure: Array, friction: Array, direction: Array) -> Array:
    """Coefficients (3, n) [Pa] of the basis where points slide along `direction` (2, n)."""
    return np.ascontiguousarray(np.concatenate([friction * pressure * direction, pressure[None]]))


def mean_tractions(problem: ContactProblem, coefficients: Array) -> Array:
    """Mean tractions (3, n) [Pa] over each contact point, from the coefficients of its basis.

    Under hats the coefficients swing about a steep pressure; their means over the contact points do
    not, and are what other programs give as nodal pressure. What a point in contact would give to an
    open one it keeps, so the force stays and open points carry nothing.
    """
    if problem.averages is None:
        return coefficients
    return problem.geometry.mean_tractions(np.ascontiguousarray(coefficients))


def along_surface(problem: ContactProblem, components: Array) -> Array:
    """Vectors (2, n) along :func:`tangents_of` the surface from those along rows and columns of points."""
    return np.asarray(np.einsum("kin,in->kn", problem.turn, components))


@dataclass(frozen=True)
@plain
class Averages:
    """What is known of the contact surface beyond its nodes.

    Attributes
    ----------
    frames : (3, 3, n)
        Means of (tangent x, tangent y, normal) over each contact point: frame, component, point. On a
        curved surface they are a little shorter than one; with them resultants are exact.
    places : (3, n) [m]
        Mean positions: where a hat at the edge of a body presses is not its node.
    start, column, share : (n + 1,), (k,), (k,)
        Shares of the hats in the area of each point i: those of the points ``column[start[i]:start[i + 1]]``.
        They add up to one, and turn the coefficients of the hats into mean tractions over each contact point.
    """

    frames: Array
    places: Array
    start: NDArray[np.uintp]
    column: NDArray[np.uintp]
    share: Array
