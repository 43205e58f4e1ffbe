# SPDX-License-Identifier: MIT OR Apache-2.0
"""What the derivatives of a solved scene are by: its contact, linearised, in the words of its arguments."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cached_property, partial
from typing import Any, Literal, cast

import numpy as np
from numpy.typing import NDArray

from .. import _mtb_rs
from ..base.words import Model
from ..bodies.constants import refused_constants
from ..contact.problem import ContactProblem, frame_of
from ..contact.tangent import Change, Effect, Points, PullField, SlidingTangent
from ..friction.fields import Leaf, VelocityTable, as_form
from ..results.derivatives import PULLS, ROUGH, Functional
from ..results.result import Result
from .posed import PosedScene

Array = NDArray[np.float64]
Shape = tuple[int, ...]
SideName = Literal["upper", "lower"]

SIDES: tuple[SideName, ...] = ("upper", "lower")

#: Half the width, relative to the pressure, of the differences of a user's law of friction over the pressure.
_WIDTH = 1e-4


def _shape_of(spec: Any) -> Shape | None:
    """Shape of the numbers that a field is given by; None where there are none."""
    form = as_form(spec)
    numbers = form.leaves()
    if numbers is None:
        return None
    return () if form.is_one else (len(numbers),)


def _slopes(scene: PosedScene, name: str, at: Callable[[PosedScene], Array | None], here: Array) -> Array:
    """Changes (numbers, n) of a field by a unit of each number that gives it: `at` is the field (n,) of a
    scene, `here` that of this one."""
    rows = []
    for leaf in as_form(getattr(scene, name)).leaves() or ():
        by = abs(leaf.value) or 1.0
        there = at(replace(scene, **{name: leaf.put(leaf.value + by)}))
        assert there is not None
        rows.append((there - here) / by)
    return np.array(rows)


def by_hardness(scene: PosedScene, problem: ContactProblem) -> tuple[Shape, Callable[[], Change]] | None:
    """Shape of the numbers that give the hardness, and what they change; None where there are none."""
    here = problem.hardness
    shape = None if here is None else _shape_of(scene.hardness)
    if here is None or shape is None:
        return None

    def at(other: PosedScene) -> Array | None:
        return other.hardness_at(problem.points, problem.patches, problem.kept)

    return shape, lambda: Change(hardness=_slopes(scene, "hardness", at, here))


def by_layer(scene: PosedScene, problem: ContactProblem) -> tuple[Shape, Callable[[Array], Change]] | None:
    """Shape of the numbers that give the layer, and what they change at pressures (n,) [Pa], as each point
    gives way by its own; None where there are none, or not such."""
    here = problem.layer
    shape = None if here is None or scene.rough is not None else _shape_of(scene.normal_layer)
    if here is None or shape is None:
        return None

    def at(other: PosedScene) -> Array | None:
        return other.normal_layer_at(problem.points, problem.patches, problem.kept)

    return shape, lambda pressure: Change(gap=_slopes(scene, "normal_layer", at, here) * pressure)


def bodies_of(scene: PosedScene, problem: ContactProblem, side: SideName) -> list[Any]:
    """The body of a side, and those of its parts."""
    return [getattr(scene, side), *(part.body for part in getattr(problem, side).state)]


def moduli_of(scene: PosedScene, problem: ContactProblem) -> list[tuple[SideName, str]]:
    """Sides of a scene, and their moduli by which the displacement of the body is known."""
    found: list[tuple[SideName, str]] = []
    for side in SIDES:
        bodies = bodies_of(scene, problem, side)
        found += [(side, name) for name in bodies[0].constants if all(name in b.constants for b in bodies)]
    return found


def refused_moduli(scene: PosedScene) -> dict[str, str]:
    """Moduli of the bodies of a scene by which there are no derivatives, and why."""
    return refused_constants({side: getattr(scene, side) for side in SIDES})


@dataclass(frozen=True)
class Deformed:
    """Bodies of a scene under a state of their contact, which give way as their moduli say.

    Attributes
    ----------
    scene : PosedScene
    pose : callable
        The contact problem of a scene with other moduli.
    problem : ContactProblem
        Of the scene itself.
    unknowns : (3, n) [Pa]
        Tractions along both tangents, zeros where they are not to deform, and pressures.
    pulls : Mapping of "upper" and "lower" to (n,) [Pa]
        Attraction of each body.
    """

    scene: PosedScene
    pose: Callable[[PosedScene], ContactProblem]
    problem: ContactProblem
    unknowns: Array
    pulls: Mapping[SideName, Array]

    def by(self, side: SideName, name: str) -> Change:
        """What a unit of a modulus of a body changes, while the state stays as it is."""
        opened = np.einsum("cn,cn->n", self.parted(side, name), self.problem.points.normal)
        return Change(gap=opened[None])

    def parted(self, side: SideName, name: str) -> Array:
        """Displacement (3, n) `u_upper - u_lower` [m] by a unit of a modulus of one of them.

        Displacements are inverse to Young's modulus, or smooth in it, and smooth in Poisson's ratio; those of
        half-spaces are polynomials of the second degree.
        """
        body = getattr(self.scene, side)
        parts = bodies_of(self.scene, self.problem, side)
        if name == "young_modulus" and all(part.is_inverse_to_modulus for part in parts):
            return np.asarray(-self._parted(self.problem, side) / body.constant(name))
        parted = np.zeros((3, self.problem.n))
        for weight, other in body.varied(name):
            changed = replace(self.scene, **{side: other})
            parted += weight * self._parted(self.pose(changed), side)
        return parted

    def _parted(self, problem: ContactProblem, side: SideName) -> Array:
        """Displacement (3, n) [m] `u_upper - u_lower` by one body."""
        own, pull = getattr(problem, side), self.pulls[side]
        at_face = np.ascontiguousarray(pull) if own.is_pulled_at_face and pull.any() else None
        moved = problem.core.displacement(self.unknowns, side == "upper", at_face) + own.displacement
        return np.asarray(moved if side == "upper" else -moved)


@dataclass(frozen=True)
class Derived:
    """Where the derivatives of a result come from.

    Attributes
    ----------
    scene : PosedScene
        On the cells of the result.
    model : str
    is_coupled : bool
        Whether friction opens and closes the gap in what was solved.
    by_products : bool
        Whether it was solved without a matrix, by convolutions.
    left_out : tuple of str
        Fields of the scene that were given and left out, as changing too little.
    """

    scene: PosedScene
    model: Model
    is_coupled: bool
    by_products: bool
    left_out: tuple[str, ...] = ()

    def of(self, result: Result) -> DerivedState:
        """The contact of `result` at its state."""
        return DerivedState(self, result)


@dataclass(frozen=True)
class DerivedState:
    """A result and the contact problem that it solves, posed once for all derivatives."""

    derived: Derived
    result: Result

    @property
    def scene(self) -> PosedScene:
        return self.derived.scene

    @cached_property
    def problem(self) -> ContactProblem:
        return self._posed(self.scene)

    def _posed(self, scene: PosedScene) -> ContactProblem:
        # what there is to say of the scene was said when it was solved
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            problem = scene.problem(self.derived.model, may_halve=False)
        attracting = problem.attracting
        if attracting is None:
            return problem
        # a magnet is linearised about the pull of the state, and everything else is under it
        assert self.result.magnetic_pressure is not None
        pull = np.ravel(self.result.magnetic_pressure)
        pull = pull if problem.kept is None else pull[problem.kept.numbers]
        return replace(attracting.under(np.ascontiguousarray(pull)), attracting=attracting)

    @cached_property
    def magnet_numbers(self) -> dict[str, Array]:
        """By each number of a magnet, changes (..., 10) of what the core derives its pull by."""
        return as_form(self.scene.magnetic_pressure).magnet_numbers(self.scene.velocity)

    @cached_property
    def unknowns(self) -> Array:
        assert self.result.coefficients is not None
        return np.ascontiguousarray(self.result.coefficients)

    @property
    def pressure(self) -> Array:
        return np.ascontiguousarray(self.unknowns[2])

    @cached_property
    def friction(self) -> Array:
        return np.ascontiguousarray(self.problem.friction_at(self.pressure))

    @cached_property
    def coefficient(self) -> Array:
        """Friction coefficient (n,), also where a layer yields before it is reached."""
        return np.ascontiguousarray(self.problem.friction.at(self.pressure))

    @cached_property
    def slope(self) -> Array:
        """Derivative (n,) of friction times pressure by the pressure."""
        law = self.problem.friction
        if law.fixed is not None:
            return self.coefficient
        # a user's function: Richardson's extrapolation of differences
        p = self.pressure
        width = _WIDTH * np.maximum(p, 1e-3 * p.max())

        def by(h: Array) -> Array:
            return np.asarray(
                (law.at(p + h) - law.at(np.maximum(p - h, 0.0))) / (p + h - np.maximum(p - h, 0.0))
            )

        return np.ascontiguousarray(self.coefficient + p * (4.0 * by(0.5 * width) - by(width)) / 3.0)

    def points(self) -> Points:
        problem = self.problem
        kept = None if problem.kept is None else problem.kept.numbers
        return Points(
            self.result.pressure.shape, kept, frame_of(problem.points)[:2], problem.geometry, self.pressure
        )

    @cached_property
    def gap(self) -> Array:
        """Gap (n,) [m]; below zero where a body has flowed."""
        result = self.result
        flowed = 0.0 if result.plastic_indentation is None else result.plastic_indentation
        return np.ascontiguousarray(self.points().on_points(result.gap - flowed, 0))

    @cached_property
    def core(self) -> _mtb_rs.Tangent:
        """The equations of the contact, linearised about its state."""
        problem = self.problem
        return problem.core.tangent(
            self.pressure,
            self.friction,
            self.slope,
            np.ascontiguousarray(problem.direction),
            self.derived.is_coupled and bool(problem.direction.any()),
            self.derived.by_products,
            None if problem.attracting is None else problem.attracting.given,
            self.gap,
        )

    @cached_property
    def tangent(self) -> SlidingTangent:
        """The contact, linearised about its state."""
        problem, result, points = self.problem, self.result, self.points()
        return SlidingTangent(
            self.core,
            points,
            len(problem.relative_motions),
            self.friction,
            problem.direction,
            dict(self._inputs()),
            () if self.problem.layer is None else ("normal_layer_field",),
            self.gap,
            lambda: problem.sheared(self.coefficient, self.pressure),
            lambda: result.report.wedging_margin,
            self._refused(),
            is_attracted=problem.attracting is not None,
        )

    def _refused(self) -> dict[str, str]:
        """What could be asked for as well, and why there is no derivative by it."""
        refused = dict.fromkeys(
            [name for left in self.derived.left_out for name in (left, f"{left}_field")],
            "model='auto' left it out, as changing too little (report.notes): name the model, which keeps it",
        )
        if self.scene.rough is not None:
            refused["normal_layer"] = ROUGH
        elif self.scene.normal_layer is not None and as_form(self.scene.normal_layer).leaves() is None:
            given = type(self.scene.normal_layer).__name__
            refused["normal_layer"] = (
                f"it was given as a {given}, by whose parts nothing is derived: 'normal_layer_field' is the "
                "derivative by its value at each point"
            )
        for name in ("friction", "magnetic_pressure", "hardness"):
            spec = getattr(self.scene, name)
            if spec is not None and as_form(spec).follows_gap:
                refused |= dict.fromkeys((name, f"{name}_field"), PULLS)
            elif spec is not None and as_form(spec).leaves() is None:
                refused[name] = (
                    f"it was given as a {type(spec).__name__}, by whose parts nothing is derived: "
                    f"'{name}_field' is the derivative by its value at each point"
                )
        return refused | refused_moduli(self.scene)

    # what is given

    def _inputs(self) -> Iterator[tuple[str, tuple[Shape, Callable[[], Effect]]]]:
        scene = self.scene
        for name in ("force", "approach"):
            value = getattr(scene, name)
            if value is not None:
                leaf = Leaf(value, lambda v: v)
                yield name, ((), partial(self._by_loads, name, [leaf]))
        if scene.moments is not None:
            mx, my = scene.moments
            leaves = [Leaf(mx, lambda v: (v, my)), Leaf(my, lambda v: (mx, v))]
            yield "moments", ((2,), partial(self._by_loads, "moments", leaves))
        for name, by in (("friction", self._by_friction), ("magnetic_pressure", self._by_pull)):
            spec = getattr(scene, name)
            if spec is None or (name == "friction" and scene.sliding_direction is None):
                continue
            if name in self.derived.left_out:
                continue
            shape = _shape_of(spec)
            if shape is not None:
                yield name, (shape, by)
        for name, changes in self.magnet_numbers.items():
            yield f"magnetic_pressure.{name}", (changes.shape[:-1], partial(self._by_magnet, changes))
        is_given = scene.magnetic_pressure is not None and self.problem.attracting is None
        if is_given and "magnetic_pressure" not in self.derived.left_out:
            yield "magnetic_pressure_field", (self.result.pressure.shape, self._by_pull_field)
        of_layer = by_layer(scene, self.problem)
        if of_layer is not None:
            shape, changed = of_layer
            yield "normal_layer", (shape, lambda: changed(self.pressure))
        of_hardness = by_hardness(scene, self.problem)
        if of_hardness is not None:
            yield "hardness", of_hardness
        if scene.rough is not None:
            for name, opened in scene.rough.slopes(self.pressure).items():
                yield name, ((len(opened),), partial(Change, gap=opened))
        if scene.velocity is not None:
            yield "velocity", ((), self._by_velocity)
        if scene.sliding_direction is not None:
            yield "sliding_direction", ((2,), self._by_direction)
        for side, name in moduli_of(scene, self.problem):
            yield f"{side}.{name}", ((), partial(self._deformed.by, side, name))

    @property
    def _deformed(self) -> Deformed:
        problem, unknowns = self.problem, self.unknowns
        if not self.derived.is_coupled:
            unknowns = np.concatenate([np.zeros_like(unknowns[:2]), unknowns[2:]])
        pulls: dict[SideName, Array] = {"upper": problem.upper.pull, "lower": problem.lower.pull}
        return Deformed(self.scene, self._posed, problem, unknowns, pulls)

    def _loading_change(self, scene: PosedScene, by: float) -> tuple[Array, Array]:
        """What the loads of another scene change, for each unit of `by`."""
        here, there = self.problem.loading, self._posed(scene).loading
        return (there.gap - here.gap) / by, (there.work - here.work) / by

    def _by_loads(self, name: str, leaves: list[Leaf]) -> Change:
        """Gap and work are linear in the loads."""
        gaps, works = [], []
        for leaf in leaves:
            by = abs(leaf.value) or 1.0
            changed = replace(self.scene, **{name: leaf.put(leaf.value + by)})
            gap, work = self._loading_change(changed, by)
            gaps.append(gap)
            works.append(work)
        return Change(gap=np.array(gaps), work=np.array(works))

    def _by_pull(self) -> Change:
        return self._by_loads("magnetic_pressure", as_form(self.scene.magnetic_pressure).leaves() or [])

    def _by_friction(self) -> Change:
        problem = self.problem

        def at(scene: PosedScene) -> Array | None:
            return scene.friction_at(problem.points, problem.patches, problem.kept, scene.velocity)

        slopes = _slopes(self.scene, "friction", at, self.coefficient)
        return Change(drag=slopes[:, None] * problem.direction)

    def _by_pull_field(self) -> PullField:
        """By a magnetic pressure at each point of the result, though only contact points count."""
        return PullField(self.problem, self.scene.attraction, self.points())

    def _by_magnet(self, numbers: Array) -> Change:
        fields = self.core.magnet()
        assert fields is not None
        return Change(pull=np.atleast_2d(numbers) @ fields)

    def _tables(self) -> list[VelocityTable]:
        specs = (self.scene.friction, self.scene.magnetic_pressure)
        return [table for spec in specs if spec is not None for table in as_form(spec).tables()]

    def _by_velocity(self) -> Change:
        """Tables are linear between two of their velocities: at one of them, on the side below."""
        scene, problem = self.scene, self.problem
        if not self._tables():
            return Change(work=np.zeros((1, len(problem.relative_motions))))
        velocity = float(cast("float", scene.velocity))
        below = [v for table in self._tables() for v in table.velocity if v < velocity]
        above = [v for table in self._tables() for v in table.velocity if v > velocity]
        is_lowest = any(table.velocity[0] == velocity for table in self._tables())
        other = 0.5 * (velocity + (min(above) if is_lowest else max(below)))
        changed, by = replace(scene, velocity=other), other - velocity
        gap, work = self._loading_change(changed, by)
        there = self.friction
        if not as_form(scene.friction).depends_on_pressure:
            there = changed.friction_at(problem.points, problem.patches, problem.kept, other)
        drag = (there - self.friction) / by * problem.direction
        pull = None
        if problem.attracting is not None:
            fields = self.core.magnet()
            assert fields is not None
            factors = [as_form(scene.magnetic_pressure).factor(v) for v in (other, velocity)]
            pull = (factors[0] - factors[1]) / by * fields[9:]
        return Change(gap=gap[None], work=work[None], drag=drag[None], pull=pull)

    def _by_direction(self) -> Change:
        problem = self.problem
        along = np.array(self.scene.sliding_direction)
        tangents = frame_of(problem.points)[:2, :2]
        projected = np.einsum("acn,c->an", tangents, along)
        length = np.linalg.norm(projected, axis=0)
        radial = np.einsum("acn,an->cn", tangents, problem.direction)
        turned = (tangents - radial * problem.direction[:, None]) / length
        return Change(drag=np.moveaxis(turned * self.friction, 1, 0))

    # what is found

    def functionals(self) -> dict[str, Callable[[], Functional]]:
        """Numbers of the result that are sums of its fields, by name."""
        result, problem = self.result, self.problem
        known = {
            "force": lambda: self._resultant(slice(0, 3)),
            "moment": lambda: self._resultant(slice(3, 6)),
        } | Functional.of_pressure(lambda: result.pressure, result.area, result.status > 0)
        lifts = problem.upper.lifts
        if problem.approach is None and lifts.any():
            known["approach"] = self._approach
        if self.scene.velocity is not None and problem.direction.any():
            known["friction_power"] = self._power
        return known

    def _resultant(self, which: slice) -> Functional:
        place = self.result.reference_point
        weights = self.problem.geometry.weights_of_resultants((place[0], place[1], place[2]))
        return Functional((3,), {"unknowns": weights[which]})

    def _approach(self) -> Functional:
        lifts = self.problem.upper.lifts
        rising = np.flatnonzero(lifts)
        weights = np.zeros((rising.size, len(self.problem.relative_motions)))
        weights[np.arange(rising.size), rising] = -lifts[rising]
        return Functional(() if rising.size == 1 else (rising.size,), {"motion": weights})

    def _power(self) -> Functional:
        """Heat of sliding [W], at the velocity of the scene along its direction of sliding."""
        x, y = np.array(self.scene.sliding_direction) / np.hypot(*cast("Any", self.scene.sliding_direction))
        weights = self.problem.geometry.weights_of_resultants((0.0, 0.0, 0.0))
        of_unit = x * weights[0] + y * weights[1]
        of_unit[2] = 0.0
        velocity = float(cast("float", self.scene.velocity))
        # the velocity, and the direction it has, work on the tractions as they are
        unit = np.array([(weights[c][:2] * self.unknowns[:2]).sum() for c in (0, 1)])
        size = float(np.hypot(*cast("Any", self.scene.sliding_direction)))
        along = np.array([x, y])
        explicit = {
            "velocity": np.array([unit @ along]),
            "sliding_direction": (velocity * (unit - (unit @ along) * along) / size)[None],
        }
        return Functional((), {"unknowns": velocity * of_unit[None]}, explicit)
