# SPDX-License-Identifier: MIT OR Apache-2.0
"""Wear of sliding contacts: few long steps to the worn-in state, each with a diagonal compliance."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .. import _mtb_rs
from ..base.check import choice, positive, reals, refuse_outside
from ..base.errors import ConvergenceError
from ..base.owning import owning
from ..base.plain import plain
from ..base.progress import shares_shown
from ..base.stored import input_data
from ..base.units import taking_quantities
from ..base.words import Model
from ..contact.problem import ContactProblem, mean_tractions, sliding_tractions
from ..contact.solve import overload, solve_direct
from ..contact.symmetry import MirrorSymmetry, alike, mirror_symmetry
from ..friction.wear_laws import Archard, Rubbing, WearLaw, as_wear_law, check_worn, coefficients_of
from ..geometry.contact_points import SAME_LINE, Patch
from ..geometry.profiles import Profile
from ..results.plausible import height_of
from ..results.result import Result
from ..results.wear_result import WearResult
from ..scenes.auto import TOLERANCE
from ..scenes.direct import choose
from ..scenes.posed import PosedScene
from ..scenes.scene import Scene, WheelScene
from ..simulation.stepping import LARGEST_GAP, PreparedContact, at_some_speed
from .sweep_checkpoint import Record, StepCheckpoint

Array = NDArray[np.float64]

#: Relative departure from a limit of depth that is accepted.
AT_LIMIT = 1e-3


@owning
@dataclass(frozen=True)
@plain
class Passages:
    """Passages of the upper body over the same stretch of the lower one: a part of a duty.

    The upper body slides all the way, ``count * distance``. Each place of the lower one is passed over
    `count` times, and is worn by all that lies above its line.

    Parameters
    ----------
    distance : float [m]
        Sliding distance of one passage.
    count : float
    changes : Mapping
        Arguments of the scene during these passages, such as ``{"velocity": 20.0}``; of a prepared contact
        `velocity` and `magnetic_pressure`.
    """

    distance: float
    count: float = 1.0
    changes: Mapping[str, Any] = field(default_factory=dict)

    def __post_init__(self) -> None:
        object.__setattr__(self, "distance", positive("distance", self.distance, "m"))
        object.__setattr__(self, "count", positive("count", self.count))
        if not isinstance(self.changes, Mapping):
            raise ValueError(f"changes is {self.changes!r}: a mapping from arguments to values is needed")

    @property
    def total(self) -> float:
        """Sliding distance of the upper body [m]."""
        return self.distance * self.count


@taking_quantities
def wear(
    contact: Scene | PreparedContact,
    distance: float | Passages | Sequence[float | Passages],
    law: WearLaw | float | Callable[[Rubbing], Any],
    lower_law: WearLaw | float | Callable[[Rubbing], Any] | None = None,
    *,
    gap: ArrayLike | None = None,
    model: Model = "auto",
    tolerance: float = 0.05,
    uniformity: float | None = None,
    limit: float | None = None,
    checkpoint: str | os.PathLike[str] | None = None,
    progress: Callable[[float], Any] | Literal[True] | None = None,
) -> WearResult:
    """Wears a sliding contact over a distance.

    Each step is a sliding contact with a diagonal compliance ``coefficient * length`` and the wear of the
    steps before in its gap. It is implicit: long steps are stable and go straight to the worn-in state. The
    lengths follow from an estimate of the error, small ones first, as sharp edges wear first.

    Parameters
    ----------
    contact : Scene or PreparedContact
        Of any bodies, loads and friction that slide. The upper body stays in its contact.
    distance : float, Passages, or a list of these [m]
        Sliding distance. After a plain distance the points of both bodies still lie together, as in fretting,
        and the lower body is worn where the contact is. With :class:`Passages` every place of the lower body
        under one line along x is worn alike.
    law : WearLaw, float [1/Pa] or function
        Of the upper body: :class:`Archard` (a number means its coefficient), :class:`WearMap`,
        :class:`EnergyWear`, or a function of :class:`Rubbing` that returns coefficients (n,) [1/Pa].
    lower_law : the same, or None
        Of the lower body; None: it does not wear.
    gap : (n,) or as the contact grid [m]
        Added to the gap of a scene: a sole of another shape, or what was worn off before on another rail.
    model : str
        Of a scene, as for :meth:`Scene.solve`.
    tolerance : float [-]
        Relative error of the worn depths by the length of the steps (root mean square over the area).
    uniformity : float or None [-]
        Stops once the pressure is so uniform (:attr:`WearResult.uniformity`).
    limit : float or None [m]
        Stops once the upper body is worn so deep, to a thousandth.
    checkpoint : path
        File that keeps the steps. The same wear that is called again with it goes on where it was stopped, or
        stops within it where `uniformity` or `limit` say so.
    progress : callable or True
        Called with the share of the distance. True shows a bar (extra ``notebook``).

    Returns
    -------
    WearResult

    Raises
    ------
    ValueError
        If something cannot be as given.
    ConvergenceError
        If there is no sliding state, new or worn; what was worn before is its `result`.

    Notes
    -----
    Measured coefficients scatter by about a half, so that depths are compared with each other. A sole that
    wears conforms to the one rail that it wears on.
    """
    duty, laws, stops, opened = checked_wear(
        contact,
        distance,
        law,
        lower_law,
        gap=gap,
        model=model,
        tolerance=tolerance,
        uniformity=uniformity,
        limit=limit,
    )
    given: list[Any] = [duty, laws, opened, model, tolerance]
    if checkpoint is not None:
        if isinstance(contact, Scene):
            given += [contact, contact.inputs]
        else:
            given.append(contact._core.to_bytes(False))
    with (
        shares_shown(progress, "wearing") as told,
        StepCheckpoint(checkpoint, given, "wear", "contact, duty, laws, model, tolerance") as kept,
    ):
        return _Worn(contact, duty, laws, opened, model, tolerance, stops, kept, told).run()


def checked_wear(
    contact: Scene | PreparedContact,
    distance: float | Passages | Sequence[float | Passages],
    law: WearLaw | float | Callable[[Rubbing], Any],
    lower_law: WearLaw | float | Callable[[Rubbing], Any] | None = None,
    *,
    gap: ArrayLike | None = None,
    model: Model = "auto",
    tolerance: float = 0.05,
    uniformity: float | None = None,
    limit: float | None = None,
) -> tuple[list[float | Passages], tuple[WearLaw, WearLaw], _Stops, Array | None]:
    """Duty, both laws, what ends it and the gap; ValueError for what :func:`wear` refuses at once."""
    if isinstance(contact, WheelScene):
        raise ValueError(
            "a wheel wears by rolling: wear_depth of its rolling result gives the depth of a pass"
        )
    if not isinstance(contact, (Scene, PreparedContact)):
        raise ValueError(f"contact is {contact!r}: a Scene or a PreparedContact is needed")
    if isinstance(contact, PosedScene):
        _check_sliding(contact)
    choice("model", model, Model)
    if positive("tolerance", tolerance) >= 1.0:
        raise ValueError(f"tolerance is {tolerance!r}: a number between 0 and 1 is needed")
    if uniformity is not None and not 0.0 < positive("uniformity", uniformity) <= 1.0:
        raise ValueError(f"uniformity is {uniformity!r}: a number between 0 and 1 is needed")
    if limit is not None:
        positive("limit", limit, "m")
    duty = _duty(distance)
    laws = as_wear_law("law", law), Archard(0.0) if lower_law is None else as_wear_law("lower_law", lower_law)
    stops = _Stops(uniformity, limit)
    opened = None if gap is None else reals("gap", gap, "m").reshape(-1)
    if opened is not None:
        refuse_outside("gap", opened, (-LARGEST_GAP, LARGEST_GAP), "m")
    if opened is not None and isinstance(contact, PreparedContact):
        raise ValueError(
            "gap is given: a prepared contact has the gap of its scene, so give the scene itself"
        )
    return duty, laws, stops, opened


def _check_sliding(scene: PosedScene) -> None:
    if scene.sliding_direction is None:
        raise ValueError("sliding_direction is None: nothing slides, so nothing wears")


def _duty(distance: Any) -> list[float | Passages]:
    parts = list(distance) if isinstance(distance, (list, tuple)) else [distance]
    if not parts:
        raise ValueError("distance is empty: at least one distance [m] or Passages is needed")
    return [part if isinstance(part, Passages) else positive("distance", part, "m") for part in parts]


def sliding_distance(distance: Any) -> float:
    """Distance [m] that the upper body slides in all, by the `distance` of :func:`wear`."""
    return sum(part.total if isinstance(part, Passages) else part for part in _duty(distance))


@dataclass(frozen=True)
class _Stops:
    uniformity: float | None
    limit: float | None


@dataclass(frozen=True)
class Place:
    """Where a contact is worn: its points as results have them."""

    points: Array
    normal: Array
    area: Array
    gap: Array
    patches: tuple[Patch, ...]
    rail: Array


def changed_by(scene: Scene, changes: Mapping[str, Any]) -> Scene:
    """The scene of passages with their changes."""
    try:
        return scene.with_(**changes) if changes else scene
    except TypeError as error:
        raise ValueError(f"changes of Passages: {error}") from error


class _Stage:
    """A scene in one of its models, or a prepared contact, as the core wears it."""

    def __init__(
        self,
        contact: Scene | PreparedContact,
        model: Model,
        changes: Mapping[str, Any],
        gap: Array | None,
    ) -> None:
        self.problem: ContactProblem | None
        self.scene: Scene | None = None
        self.prepared: PreparedContact | None = None
        if isinstance(contact, Scene):
            self.scene = changed_by(contact, changes)
            _check_sliding(self.scene)
            self.scene.ask_of_places()
            # gap, laws and what is worn need not be symmetric, which a rail known by its half would not tell
            self.problem = _opened(self.scene.problem(model, may_halve=False), gap)
            self.speed = None if self.scene.velocity is None else abs(float(self.scene.velocity))
        else:
            self.prepared = contact.copy()
            source = contact._source
            self.problem = None if source is None else source.problem
            unknown = set(changes) - {"velocity", "magnetic_pressure"}
            if unknown:
                raise ValueError(
                    f"changes has {', '.join(sorted(unknown))}: passages of a prepared contact take velocity "
                    "and magnetic_pressure"
                )
            self.changes = dict(changes)
            self.velocity = self.prepared._velocity(self.changes.get("velocity"))
            stated = self.changes.get("velocity", self.prepared._core.velocity)
            self.speed = None if stated is None else float(np.hypot(*self.velocity)) or None

    @property
    def direction(self) -> Array:
        if self.prepared is None:
            assert self.problem is not None
            return self.problem.direction
        return self.prepared._core.geometry.sliding_direction(self.velocity)

    def place(self) -> Place:
        problem = self.problem
        if problem is None:
            assert self.prepared is not None
            core = self.prepared._core
            n = core.area.size
            return Place(core.points, core.normal, core.area, np.zeros(n), (), np.empty((4, 0)))
        scene = self.scene if self.scene is not None else self.prepared._source.scene  # type: ignore[union-attr]
        return place_of(scene, problem)

    def lines(self) -> tuple[list[int], Array]:
        """The line along x that each contact point lies on, and its length along it."""
        problem = self.problem
        if problem is None or not problem.patches:
            raise ValueError("Passages need a contact whose points are on regular grids, not one from a file")
        if np.abs(self.direction[1]).max(initial=0.0) > 1e-12:
            raise ValueError("Passages are along x: the sliding direction must be along x as well")
        place = self.place()
        line = np.zeros(place.area.size, dtype=np.intp)
        length = np.zeros(place.area.size)
        rows = []
        for grid in problem.patches:
            y, area = grid.view(place.points[1]), grid.view(place.area)
            if not grid.is_along_x(place.points):
                raise ValueError(
                    "Passages need rows of contact points along x: the upper body must not be turned"
                )
            rows.append(np.round(y.mean(axis=1) / SAME_LINE))
            # the width of the lower body that a row stands for, also where the upper one ends within the row
            width = np.full((grid.ny, 1), grid.spacing[1])
            if not grid.holds_cells(place.area):
                width[[0, -1]] *= 0.5
            grid.view(length)[...] = area / width
        _, numbers = np.unique(np.concatenate(rows), return_inverse=True)
        first = 0
        for grid in problem.patches:
            grid.view(line)[...] = numbers[first : first + grid.ny, None]
            first += grid.ny
        if problem.kept is not None:
            line, length = line[problem.kept.numbers], length[problem.kept.numbers]
        return line.tolist(), np.ascontiguousarray(length)

    def height(self) -> tuple[float, str]:
        """How deep the upper body can be worn [m], and what this is."""
        own = None if self.problem is None else height_of(self.problem.upper.state)
        if own is not None:
            return own, "the height of the upper body"
        scene = self.scene
        if scene is None and self.prepared is not None and self.prepared._source is not None:
            scene = self.prepared._source.scene  # type: ignore[assignment]
        height = None if scene is None else scene.geometry.body_height
        return self.extent() if height is None else (height, "the height of the upper body")

    def extent(self) -> tuple[float, str]:
        """Width of the contact [m]: half-spaces worn as deep are none any more."""
        points = self.points()
        area = self.prepared._core.area if self.problem is None else self.problem.area  # type: ignore[union-attr]
        width = float(max(np.ptp(points[0]), np.ptp(points[1]), np.sqrt(area.max())))
        return width, "the width of the contact"

    def points(self) -> Array:
        return self.prepared._core.points if self.problem is None else self.problem.points.points  # type: ignore[union-attr]


def place_of(scene: PosedScene, problem: ContactProblem) -> Place:
    """Where the contact of a scene is worn."""
    nodes = problem.points if problem.kept is None else problem.kept.nodes
    rail = np.empty((4, 0))
    if "elastic-both" in scene.geometry.models:
        rail = _stations(scene.geometry.rail()[0], nodes.points[1])
    return Place(nodes.points, nodes.normal, problem.on_grid(problem.area), nodes.gap, problem.patches, rail)


def _stations(rail: Profile, places: Array) -> Array:
    """Points and normals (4, m) of a profile: at the places of contact points, and finely beside them."""
    start, end = rail.range
    own = np.unique(np.clip(np.round(places / SAME_LINE) * SAME_LINE, start, end))
    even = np.linspace(start, end, 401)
    # a spline through points that nearly coincide would swing
    apart = np.abs(even[:, None] - own).min(axis=1) > 0.5 * (even[1] - even[0])
    y = np.sort(np.concatenate([own, even[apart]]))
    return np.stack([y, rail.height(y), *rail.normal(y)])


def _opened(problem: ContactProblem, gap: Array | None) -> ContactProblem:
    """The problem with what is added to its gap, which is given at all points of its grids."""
    if gap is None:
        return problem
    own = problem.on_grid(problem.area)
    if gap.shape != own.shape:
        raise ValueError(
            f"gap has {gap.size} entries: one for each of the {own.size} contact points is needed"
        )
    at_points = gap if problem.kept is None else gap[problem.kept.numbers]
    points = replace(problem.points, gap=problem.points.gap + at_points)
    return replace(problem, gap=problem.gap + at_points, points=points)


class _Uneven(Exception):
    """A law wears mirror images differently: the half does not stand for the whole."""


@dataclass
class _Worn:
    """One wear on its way: what it was asked, and what it has found."""

    contact: Scene | PreparedContact
    duty: list[float | Passages]
    laws: tuple[WearLaw, WearLaw]
    gap: Array | None
    model: Model
    tolerance: float
    stops: _Stops
    kept: StepCheckpoint
    told: Callable[[float], Any]
    records: list[Record] = field(default_factory=list)
    #: Where a step beyond the limit is to end in place of its own end [m].
    cut: float | None = None
    #: Whether the laws have worn mirror images alike so far.
    may_halve: bool = True
    #: Whether further records go to the file.
    is_kept: bool = True

    def run(self) -> WearResult:
        model = self.model
        if isinstance(self.contact, Scene):
            self.contact.check_model(model)
            if model == "auto":
                model = choose(at_some_speed(self.contact), TOLERANCE, "pressure").model
        elif model != "auto":
            raise ValueError(f"model is {model!r}: a prepared contact has its model")
        kept = self.kept.in_order()
        self.records = self._up_to_a_stop(kept)
        # the file goes on as it was begun: what ends at a limit before its end is no part of it
        self.is_kept = len(self.records) == len(kept)
        total = sliding_distance(self.duty)
        lengths = [part.total if isinstance(part, Passages) else part for part in self.duty]
        ends = np.cumsum(lengths)
        done = self.records[-1]["numbers"][0] if self.records else 0.0
        first = min(int(np.searchsorted(ends * (1.0 + 1e-12), done)), ends.size - 1)
        stage = None
        for k, part in enumerate(self.duty[first:], first):
            if stage is not None and self._is_at_stop():
                break
            changes = part.changes if isinstance(part, Passages) else {}
            before, stage = stage, _Stage(self.contact, model, changes, self.gap)
            if before is not None and not np.array_equal(before.points(), stage.points()):
                raise ValueError(
                    f"part {k + 1} of the duty has other contact points than the first one: what is worn "
                    "belongs to the points"
                )
            if done < ends[k] * (1.0 - 1e-12) and not self._is_at_stop():
                self._wear_as_far_as(float(ends[k]), stage, part, total)
        assert stage is not None
        return self._result(stage)

    def _up_to_a_stop(self, records: list[Record]) -> list[Record]:
        """What the same wear without a checkpoint would have of the records at its limit."""
        limit = self.stops.limit
        for k, record in enumerate(records):
            if self._ends(record):
                is_beyond = limit is not None and record["numbers"][5] > (1.0 + AT_LIMIT) * limit
                return records[: k if is_beyond else k + 1]
        return records

    def _is_at_stop(self) -> bool:
        return bool(self.records) and self._ends(self.records[-1])

    def _ends(self, record: Record) -> bool:
        upper, even = record["numbers"][5], record["numbers"][4]
        limit = self.stops.limit
        return (limit is not None and upper >= (1.0 - AT_LIMIT) * limit) or (
            self.stops.uniformity is not None and even >= self.stops.uniformity
        )

    def _beyond(self, distance: float, depth: float) -> bool:
        """Whether a step has gone beyond the limit: then it notes down where that is, on a straight line."""
        limit = self.stops.limit
        if limit is None or depth <= (1.0 + AT_LIMIT) * limit or not self.records:
            return False
        numbers = self.records[-1]["numbers"]
        self.cut = numbers[0] + (distance - numbers[0]) * (limit - numbers[5]) / (depth - numbers[5])
        return True

    def _wear_as_far_as(self, end: float, stage: _Stage, part: float | Passages, total: float) -> None:
        """Wears a part to its end [m] or to the limit: a step beyond that is taken again, a shorter one."""
        until = end
        while True:
            self.cut = None
            try:
                self._wear(stage, part, until, total)
            except _Uneven:
                # the steps before were even: it goes on from there
                self.may_halve = False
                continue
            if self._is_at_stop() or self.records[-1]["numbers"][0] >= end * (1.0 - 1e-12):
                return
            until = end if self.cut is None else self.cut

    def _is_even(self, symmetry: MirrorSymmetry) -> bool:
        """Whether what is worn so far is its own mirror image."""
        worn = [np.array(self.records[-1][name]) for name in ("upper", "lower")] if self.records else []
        return all(alike(depth, depth[symmetry.image]) for depth in worn)

    def _wear(self, stage: _Stage, part: float | Passages, until: float, total: float) -> None:
        problem = stage.problem
        points = stage.points()
        n = points.shape[1]
        whole = np.arange(n)
        # a scene that is its own mirror image is worn by its half, if what is worn so far is one as well
        symmetry = None if problem is None or stage.prepared is not None else mirror_symmetry(problem)
        if not self.may_halve or (symmetry is not None and not self._is_even(symmetry)):
            symmetry = None
        source = whole if symmetry is None else symmetry.source
        chosen = whole if symmetry is None else np.unique(source, return_index=True)[1]
        passage = None
        if isinstance(part, Passages):
            line, length = stage.lines()
            passage = part.distance, [line[i] for i in chosen], np.ascontiguousarray(length[chosen])

        def law(pressure: Array, friction: Array) -> tuple[Array, Array]:
            rubbing = Rubbing(pressure[source], friction[source], np.ones(n), stage.speed, points)
            found = [coefficients_of(own, rubbing) for own in self.laws]
            if symmetry is not None and not all(alike(values, values[symmetry.image]) for values in found):
                raise _Uneven
            upper, lower = (np.ascontiguousarray(values[chosen]) for values in found)
            return upper, lower

        area = stage.place().area if problem is None else problem.area
        is_begun = bool(self.records)

        def told(step: _mtb_rs.WearStep) -> bool:
            nonlocal is_begun
            out = step.outcome
            if out.status != "solved":
                raise self._failure(out, step.distance, stage)
            if is_begun and step.length == 0.0:
                # the contact that the part before has left, under the load of this one
                return self._ends(self.records[-1])
            is_begun = True
            pressure, friction = out.pressure[source], out.friction[source]
            unknowns = sliding_tractions(pressure, friction, stage.direction)
            if problem is not None:
                mean = mean_tractions(problem, unknowns)[2]
                force = problem.geometry.loads(unknowns).sum(axis=1)
            else:
                assert stage.prepared is not None
                mean, force = stage.prepared._core.mean_pressure(out.pressure), out.force
            upper, lower = step.upper[source], step.lower[source]
            if self._beyond(step.distance, float(upper.max())):
                return True
            check_worn(self.laws[0], upper, *stage.height(), step.distance)
            check_worn(self.laws[1], lower, *stage.extent(), step.distance)
            load = float(mean @ area)
            even = float(np.minimum(mean, load / area.sum()) @ area) / load if load > 0.0 else 0.0
            record = {
                "status": "solved",
                "pressure": pressure.tolist(),
                "mean": mean.tolist(),
                "upper": upper.tolist(),
                "lower": lower.tolist(),
                "force": force.tolist(),
                "numbers": [
                    step.distance, step.length, step.error, float(step.solves), even, float(upper.max()),
                    step.next,
                ],
            }  # fmt: skip
            if self.is_kept:
                self.kept.add(len(self.records), record)
            self.records.append(record)
            self.told(min(step.distance / total, 1.0))
            return self._ends(record)

        last = self.records[-1] if self.records else None
        zero = np.zeros(chosen.size)
        worn = (
            (0.0, zero, zero, None)
            if last is None
            else (
                last["numbers"][0],
                np.ascontiguousarray(np.array(last["upper"])[chosen]),
                np.ascontiguousarray(np.array(last["lower"])[chosen]),
                last["numbers"][6],
            )
        )
        given = law, passage, self.tolerance, worn, until, told
        if stage.prepared is not None:
            pull = stage.changes.get("magnetic_pressure")
            if pull is not None and not isinstance(pull, (int, float)):
                raise ValueError("magnetic_pressure of passages of a prepared contact is one number [Pa]")
            _mtb_rs.wear_contact(stage.prepared._core, stage.velocity, pull, None, *given)
            return
        assert problem is not None
        cut = problem if symmetry is None else symmetry.half
        friction: Any = cut.friction.at if cut.friction.fixed is None else cut.friction.fixed
        if not callable(friction):
            friction = np.ascontiguousarray(friction)
        direction = np.ascontiguousarray(cut.direction)
        attracting = cut.attracting
        if attracting is None:
            _mtb_rs.wear_problem(cut.core, cut.loading, direction, friction, *given)
            return
        pulled = attracting.given, attracting.start(cut.n)
        _mtb_rs.wear_problem(cut.core, cut.free_loading, direction, friction, *given, *pulled)

    def _failure(self, out: _mtb_rs.Outcome, distance: float, stage: _Stage) -> ConvergenceError:
        problem = stage.problem
        hard = None if problem is None else problem.hardness
        why = {
            "no solution": "no sliding equilibrium: the body wedges",
            "unreachable": "the resultant of the load lies outside what the contact can carry",
            "overloaded": overload(hard, None if problem is None else problem.area),
        }.get(out.status, f"not converged (residual {out.residual:.1e})")
        before = self._put(stage) if self.records else None
        told = f"after {distance:.6g} m of sliding there is no state of contact: {why}"
        return ConvergenceError(told, before)

    def _put(self, stage: _Stage) -> WearResult:
        place, problem, records = stage.place(), stage.problem, self.records

        def field_of(name: str) -> Array:
            values = np.array([record[name] for record in records])
            return values if problem is None else problem.on_grid(values)

        numbers = np.array([record["numbers"][:4] for record in records])
        contact = self.contact
        said: dict[str, Any] = dict(contact.statement()) if isinstance(contact, Scene) else {}
        asked = {
            "distance": float(numbers[-1, 0]),
            "law": repr(self.laws[0]),
            "lower_law": repr(self.laws[1]),
            "wear_tolerance": self.tolerance,
        }
        return WearResult(
            distance=numbers[:, 0],
            depths=np.stack([field_of("upper"), field_of("lower")]),
            pressures=field_of("mean"),
            unknowns=field_of("pressure"),
            forces=np.array([record["force"] for record in records]),
            steps=numbers[:, 1],
            errors=numbers[:, 2],
            solves=numbers[:, 3].astype(np.int64),
            points=place.points,
            normal=place.normal,
            area=place.area,
            initial_gap=place.gap,
            patches=place.patches,
            rail=place.rail,
            summary=input_data(said) | asked,
        )

    def _result(self, stage: _Stage) -> WearResult:
        found = self._put(stage)
        scene, problem = stage.scene, stage.problem
        if scene is None or problem is None:
            return found
        return replace(found, final=worn_contact(scene, problem, self.records[-1]))


def worn_contact(scene: Scene, problem: ContactProblem, record: Record) -> Result:
    """The contact with what was worn off in its gap."""
    worn = np.array(record["upper"]) + np.array(record["lower"])
    points = replace(problem.points, gap=problem.points.gap + worn)
    after = replace(problem, gap=problem.gap + worn, points=points, time_s={})
    return scene.finished(after, solve_direct(after), "direct")
