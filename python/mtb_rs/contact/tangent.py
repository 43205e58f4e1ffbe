# SPDX-License-Identifier: MIT OR Apache-2.0
"""A sliding contact, linearised about its state: what the core gives, in the words of results."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from .. import _mtb_rs
from ..base.plain import plain
from ..base.words import Attraction
from ..results.derivatives import Gradient, Margin
from .problem import ContactProblem

Array = NDArray[np.float64]
Shape = tuple[int, ...]


class Effect(Protocol):
    """What some numbers (l) change in a sliding contact."""

    def weighted(self, by: Gradients) -> Array:
        """What they change (k, l) in k numbers whose gradients are given."""

    def of(self, values: Array, points: int, motions: int) -> Given:
        """What k changes (k, l) of the numbers do."""


@dataclass(frozen=True)
@plain
class Change:
    """What some numbers change in a sliding contact, by a unit of each of them; None: nothing.

    Attributes
    ----------
    gap : (l, n) [m]
    work : (l, m) [J]
    drag : (l, 2, n)
        Friction coefficient times direction of sliding.
    pull : (l, n) [Pa]
        Pull of a magnet that follows the gap, with all gaps held.
    hardness : (l, n) [Pa]
        Counts where the pressure is as large.
    """

    gap: Array | None = None
    work: Array | None = None
    drag: Array | None = None
    pull: Array | None = None
    hardness: Array | None = None

    def weighted(self, by: Gradients) -> Array:
        """What they change (k, l) in k numbers whose gradients are given."""
        parts = self.gap, self.work, self.drag, self.pull, self.hardness
        size = next(len(part) for part in parts if part is not None)
        sums = np.zeros((len(by.gap), size))
        if self.gap is not None:
            sums += by.gap @ self.gap.T
        if self.work is not None:
            sums += by.work @ self.work.T
        if self.drag is not None:
            for axis in (0, 1):
                along = self.drag[:, axis]
                if along.any():
                    sums += by.drag(axis) @ along.T
        if self.pull is not None:
            sums += by.pull @ self.pull.T
        if self.hardness is not None:
            sums += by.hardness @ self.hardness.T
        return sums

    def of(self, values: Array, points: int, motions: int) -> Given:
        """What k changes (k, l) of the numbers do."""
        k = len(values)
        own = [
            np.zeros((k, size)) if part is None else values @ np.reshape(part, (len(part), size))
            for part, size in ((self.gap, points), (self.work, motions), (self.drag, 2 * points))
        ]
        pull, hardness = (None if part is None else values @ part for part in (self.pull, self.hardness))
        return Given(own[0], own[1], own[2], pull, hardness)


@dataclass(frozen=True)
class Through:
    """What numbers (l) change by themselves, and through others (m), which follow by a `slope` (l, m)."""

    itself: Effect
    other: Effect
    slope: Array

    def weighted(self, by: Gradients) -> Array:
        """What they change (k, l) in k numbers whose gradients are given."""
        return self.itself.weighted(by) + self.other.weighted(by) @ self.slope.T

    def of(self, values: Array, points: int, motions: int) -> Given:
        """What k changes (k, l) of the numbers do."""
        return self.itself.of(values, points, motions) + self.other.of(values @ self.slope, points, motions)


@dataclass(frozen=True)
class Given:
    """Changes of what it is given: gap (k, n), work (k, m), drag (k, 2n), pull, hardness (k, n) or None."""

    gap: Array
    work: Array
    drag: Array
    pull: Array | None = None
    hardness: Array | None = None

    def __add__(self, other: Given) -> Given:
        pull, hardness = _both(self.pull, other.pull), _both(self.hardness, other.hardness)
        return Given(self.gap + other.gap, self.work + other.work, self.drag + other.drag, pull, hardness)


def _both(one: Array | None, other: Array | None) -> Array | None:
    """The sum of two changes, of which each may be none."""
    if one is None or other is None:
        return other if one is None else one
    return one + other


class Gradients:
    """Gradients of k numbers by what the core is given.

    Those by friction and hardness cost products with the influence matrices: they are made when asked for.

    Parameters
    ----------
    core : Tangent
    unknowns : (k, 3, n)
        Weights of tractions and pressures.
    gap, motion, pull : (k, n), (k, m), (k, n) or None
        Weights of these; None: none.
    """

    def __init__(
        self,
        core: _mtb_rs.Tangent,
        unknowns: Array,
        gap: Array | None,
        motion: Array | None,
        pull: Array | None = None,
    ) -> None:
        self._core = core
        self._unknowns = np.ascontiguousarray(unknowns)
        self._drag: dict[int, Array] = {}
        gap, motion, pull = (None if of is None else np.ascontiguousarray(of) for of in (gap, motion, pull))
        #: By the gap (k, n), the work (k, m), and the pull of a magnet (k, n), without one (k, 0).
        self.gap, self.work, self.pull = core.adjoint(self._unknowns, gap, motion, pull)

    def drag(self, axis: int) -> Array:
        """By friction coefficient times direction along a tangent (k, n)."""
        if axis not in self._drag:
            self._drag[axis] = self._core.by_drag(axis, self._unknowns, self.gap, self.work)
        return self._drag[axis]

    @cached_property
    def hardness(self) -> Array:
        """By the hardness (k, n) of each point."""
        return self._core.by_hardness(self._unknowns, self.gap, self.work)


@dataclass(frozen=True)
class Points:
    """How fields over the points of a result are those of its contact points.

    Attributes
    ----------
    shape : tuple of int
        Of a field of the result.
    kept : (n,) int or None
        The contact points among those of the result; None: all of them.
    frame : (2, 3, n)
        Tangents of each point.
    geometry : ContactGeometry
        Of the core: what means are.
    pressure : (n,) [Pa]
        Unknowns.
    """

    shape: Shape
    kept: NDArray[np.intp] | None
    frame: Array
    geometry: _mtb_rs.ContactGeometry
    pressure: Array

    def on_points(self, field: Array, lead: int = 1) -> Array:
        """A field (..., *shape) at the contact points (..., n), with `lead` axes in front."""
        flat = np.reshape(field, (*field.shape[:lead], -1))
        return flat if self.kept is None else flat[..., self.kept]

    def on_grid(self, values: Array) -> Array:
        """Values (..., n) of the contact points as a field (..., *shape), with zeros beside them."""
        if self.kept is not None:
            whole = np.zeros((*values.shape[:-1], int(np.prod(self.shape))))
            whole[..., self.kept] = values
            values = whole
        return np.reshape(values, (*values.shape[:-1], *self.shape))

    def means(self, values: Array) -> Array:
        """Changes (k, n) of means by those of the unknowns."""
        if self.mean_weights is None:
            return values
        return values @ self.mean_weights

    def of_means(self, weights: Array) -> Array:
        """Weights (k, n) of the unknowns that do what weights of their means do."""
        return self.geometry.weights_of_means(np.ascontiguousarray(weights), self.pressure)

    @cached_property
    def mean_weights(self) -> Array | None:
        """Weights of the unknowns (n, means) in each mean; None where means are the unknowns."""
        n = self.pressure.size
        probe = np.arange(1.0, n + 1.0)[None]
        if np.array_equal(self.of_means(probe), probe):
            return None
        return np.ascontiguousarray(self.of_means(np.eye(n)).T)


class PullField:
    """What a magnetic pressure at each point changes: gaps of bodies that it deforms, and work.

    Parameters
    ----------
    problem : ContactProblem
    attraction : {"upper", "both"}
    points : Points
        What the numbers are over.
    balanced : (m,) int, optional
        The free motions that count; all of them by default.
    """

    def __init__(
        self,
        problem: ContactProblem,
        attraction: Attraction,
        points: Points,
        balanced: Sequence[int] | None = None,
    ) -> None:
        self._points = points
        n, motions = problem.n, problem.relative_motions
        self._work = np.zeros((n, len(motions)))
        self._deformed = []
        sides = [(problem.upper, 0)]
        if attraction == "both":
            sides.append((problem.lower, problem.upper.work.size))
        for side, first in sides:
            if side.compliance is not None and side.is_pulled_at_face:
                self._deformed.append(side.compliance)
            own = slice(first, first + side.work.size)
            opening = motions[own, 2]
            self._work[:, own] -= (np.where(side.is_pulled[:, None], opening, 0.0) * problem.area).T
        if balanced is not None:
            self._work = np.ascontiguousarray(self._work[:, balanced])

    @property
    def is_felt(self) -> bool:
        """Whether it changes anything."""
        return bool(self._deformed) or bool(self._work.any())

    def weighted(self, by: Gradients) -> Array:
        """What they change (k, l) in k numbers whose gradients are given."""
        sums = by.work @ self._work.T
        for compliance in self._deformed:
            sums -= _rows(compliance.transposed, by.gap)
        return in_rows(self._points.on_grid(sums))

    def of(self, values: Array, points: int, motions: int) -> Given:
        """What k changes (k, l) of the numbers do."""
        pulls = np.ascontiguousarray(self._points.on_points(values.reshape(len(values), *self._points.shape)))
        gap = np.zeros((len(pulls), points))
        for compliance in self._deformed:
            gap -= _rows(compliance.displacement, pulls)
        return Given(gap, pulls @ self._work, np.zeros((len(pulls), 2 * points)))


def in_rows(values: Array) -> Array:
    """Changes (k, ...) with one row each (k, l), also where there are none of either."""
    return np.reshape(values, (len(values), int(np.prod(np.shape(values)[1:]))))


def _rows(normal: Callable[[Array], Array], rows: Array) -> Array:
    """The normal part of a map of three components (3, n), of normal rows (k, n) each."""
    found = np.zeros(rows.shape)
    for out, row in zip(found, rows, strict=True):
        out[:] = normal(np.stack([np.zeros(row.size), np.zeros(row.size), row]))[2]
    return found


class SlidingTangent:
    """The linearised equations of a sliding contact; see :class:`mtb_rs.results.derivatives.Tangent`.

    Parameters
    ----------
    core : Tangent
    points : Points
    motions : int
    friction : (n,)
    direction : (2, n)
    named : Mapping of name to (shape, what a unit of each of its numbers changes)
        Inputs besides the gap and the friction coefficient at each point.
    flexible : sequence of str
        Inputs of the shape of the points by which each of these gives way to its own pressure [m/Pa].
    gap : (n,) [m]
        Of the state; below zero where a body has flowed.
    sheared : callable
        Friction (n,) in full sliding over the stress at which a layer yields; None without one.
    wedging : callable
        The wedging margin of the state; None where it is not known.
    refused : dict of str to str
        What else could be asked for, and why there is no derivative by it.
    is_attracted : bool
        Whether a magnet pulls, whose pull follows the gap.
    """

    def __init__(
        self,
        core: _mtb_rs.Tangent,
        points: Points,
        motions: int,
        friction: Array,
        direction: Array,
        named: Mapping[str, tuple[Shape, Callable[[], Effect]]],
        flexible: Sequence[str],
        gap: Array,
        sheared: Callable[[], Array | None],
        wedging: Callable[[], float | None],
        refused: Mapping[str, str],
        *,
        is_attracted: bool = False,
    ) -> None:
        self._core = core
        self._points = points
        self._motions = motions
        self._friction = friction
        self._direction = direction
        self._named = dict(named)
        self._flexible = tuple(flexible)
        self._made: dict[str, Effect] = {}
        self._gap = gap
        hardness = core.limit()
        self._hardness, self._sheared = hardness, sheared
        #: Points at the hardness, whose gap stays closed and whose body flows.
        self._flows = None if hardness is None else points.pressure >= hardness
        self._wedging, self.refused = wedging, refused
        shape = points.shape
        self.inputs: dict[str, Shape] = {"gap": shape, "friction_field": shape}
        self.inputs |= {name: given[0] for name, given in named.items()}
        self.inputs |= dict.fromkeys(flexible, shape)
        self.fields: dict[str, Shape] = {
            "pressure": shape,
            "traction": (3, *shape),
            "gap": shape,
            "motion": (motions,),
            "unknowns": (3, points.pressure.size),
        }
        if hardness is not None:
            self.inputs["hardness_field"] = shape
            self.fields["plastic_indentation"] = shape
        if is_attracted:
            self.fields["magnetic_pressure"] = shape

    @cached_property
    def margin(self) -> Margin:
        """How near points are to coming into contact or leaving it, to flowing or to ceasing to."""
        pressure = self._points.pressure
        contact = pressure > 0.0
        if not contact.any():
            return Margin(np.inf, Margin.of_first_touch(self._gap), wedging=self._wedging())
        opening = self._core.opening()
        beside, moved = self._gap[~contact], float(np.abs(opening[contact]).max())
        yielding = unloading = None
        if self._flows is not None:
            assert self._hardness is not None
            elastic, flows = contact & ~self._flows, self._flows
            yielding = float((1.0 - pressure / self._hardness)[elastic].min(initial=np.inf))
            unloading = float(-self._gap[flows].max(initial=-np.inf) / moved)
        if (sheared := self._sheared()) is not None:
            nearest = float(np.abs(1.0 - sheared)[contact].min())
            yielding = nearest if yielding is None else min(yielding, nearest)
        return Margin(
            parting=float(pressure[contact].min() / pressure.max()),
            touching=float(beside.min() / moved) if beside.size else np.inf,
            wedging=self._wedging(),
            yielding=yielding,
            unloading=unloading,
        )

    def change(self, name: str) -> Effect:
        """What a unit of each number of an input changes."""
        if name not in self._made:
            self._made[name] = self._named[name][1]()
        return self._made[name]

    def forward(self, changes: Mapping[str, Array]) -> Mapping[str, Array]:
        """Changes (k, ...) of all fields by those of inputs (k, ...)."""
        points, n, m = self._points, self._points.pressure.size, self._motions
        k = len(next(iter(changes.values())))
        sums = Given(np.zeros((k, n)), np.zeros((k, m)), np.zeros((k, 2 * n)))
        for name, values in changes.items():
            if name in self._named:
                sums += self.change(name).of(in_rows(values), n, m)
                continue
            at = np.array(points.on_points(values))
            if name == "friction_field":
                sums.drag[:] += (at[:, None] * self._direction).reshape(k, 2 * n)
            elif name == "hardness_field":
                sums = replace(sums, hardness=_both(sums.hardness, at))
            else:
                sums.gap[:] += at * points.pressure if name in self._flexible else at
        return self.following(sums)

    def following(self, given: Given) -> Mapping[str, Array]:
        """Changes (k, ...) of all fields by those of what the core is given."""
        points, n, k = self._points, self._points.pressure.size, len(given.gap)
        pulled, hardened = (
            None if part is None else np.ascontiguousarray(part) for part in (given.pull, given.hardness)
        )
        pressure, traction, opened, motion, pull = self._core.forward(
            given.gap, np.ascontiguousarray(given.work), given.drag, pulled, hardened
        )
        local = traction.reshape(k, 2, n)
        mean = points.means(local.reshape(2 * k, n)).reshape(k, 2, n)
        found = {
            "pressure": points.on_grid(points.means(pressure)),
            "traction": points.on_grid(np.einsum("acn,kan->kcn", points.frame, mean)),
            "motion": motion,
            "unknowns": np.concatenate([local, pressure[:, None]], axis=1),
        }
        if "magnetic_pressure" in self.fields:
            found["magnetic_pressure"] = points.on_grid(pull)
        if self._flows is not None:
            # what flows is behind the gap
            found["plastic_indentation"] = points.on_grid(np.where(self._flows, -opened, 0.0))
            opened = np.where(self._flows, 0.0, opened)
        return {**found, "gap": points.on_grid(opened)}

    def adjoint(self, weights: Mapping[str, Array]) -> Mapping[str, Array]:
        """Gradients (k, ...) by the inputs, each made when it is asked for."""
        points, n = self._points, self._points.pressure.size
        k = len(next(iter(weights.values())))
        unknowns = weights["unknowns"] if "unknowns" in weights else np.zeros((k, 3, n))
        if "unknowns" in weights and ("pressure" in weights or "traction" in weights):
            unknowns = unknowns.copy()
        if "pressure" in weights:
            unknowns[:, 2] += points.of_means(points.on_points(weights["pressure"]))
        if "traction" in weights:
            local = np.einsum("acn,kcn->kan", points.frame, points.on_points(weights["traction"], 2))
            own = points.of_means(np.ascontiguousarray(local.reshape(2 * k, n)))
            unknowns[:, :2] += own.reshape(k, 2, n)
        gap = points.on_points(weights["gap"]) if "gap" in weights else None
        if self._flows is not None and not {"gap", "plastic_indentation"}.isdisjoint(weights):
            nothing = np.zeros((k, n))
            flowed = weights.get("plastic_indentation")
            flowed = nothing if flowed is None else points.on_points(flowed)
            gap = np.where(self._flows, -flowed, nothing if gap is None else gap)
        pull = points.on_points(weights["magnetic_pressure"]) if "magnetic_pressure" in weights else None
        given = Gradients(self._core, unknowns, gap, weights.get("motion"), pull)
        return Gradient(self.inputs, lambda name: self.by(name, given))

    def by(self, name: str, given: Gradients) -> Array:
        """The gradient (k, ...) by an input."""
        points, k = self._points, len(given.gap)
        if name == "gap":
            return points.on_grid(given.gap)
        if name in self._flexible:
            return points.on_grid(given.gap * points.pressure)
        if name == "friction_field":
            sums = np.zeros(given.gap.shape)
            for axis, along in enumerate(self._direction):
                if along.any():
                    sums += given.drag(axis) * along
            return points.on_grid(sums)
        if name == "hardness_field":
            return points.on_grid(given.hardness)
        return self.change(name).weighted(given).reshape(k, *self.inputs[name])
