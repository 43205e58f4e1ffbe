# SPDX-License-Identifier: MIT OR Apache-2.0
"""From a scene to its result, on one page.

A scene becomes a :class:`ContactProblem` (points, gap, compliances, rigid motions with their
balance); the compiled core solves it; :func:`finish` turns the pressure into everything a user asks for.
"""

from __future__ import annotations

import time
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from . import _mtb_rs, memory
from .bodies import HalfSpace, Rigid
from .cache import Memory
from .check import warn
from .errors import ConvergenceError, ResultantError
from .geometry import SheetPoints
from .loads import PressureDependentFriction
from .loads import field as load_field
from .plain import plain
from .plausible import ask, of_result
from .report import Report
from .result import Displacement, Patch, Result, Surface
from .symmetry import Fold, folded
from .wedging import jammed, tipping_margin
from .words import Model

if TYPE_CHECKING:
    from .elastic import Averages

Array = NDArray[np.float64]

#: Changes of a pressure-dependent friction coefficient below this count as none.
FRICTION_TOLERANCE = 1e-10
FRICTION_ROUNDS = 60

#: Words for the size of an effect that could not be estimated.
UNKNOWN = "of unknown size: the model with it has no solution on wider cells"

#: Floating-point operations of an entry of a dense influence matrix, about.
ENTRY = 50.0


@dataclass(frozen=True)
@plain
class Side:
    """One body of a contact problem.

    Attributes
    ----------
    compliance : Compliance or None
        None for a rigid body.
    displacement : (3, n) [m]
        Of the contact points by everything but the contact, common frame: prescribed motion, attraction.
    motions : (m, 3, n)
        Of the contact points by a unit of each rigid motion the supports leave free, common frame.
    work : (m,) [J]
        Of all loads but the contact's on a unit of each motion.
    includes_motion : bool
        Whether the reported displacement contains the rigid part.
    state
        What the body needs to recover its inside from a solution (finite elements).
    operations : float
        Floating-point operations of its condensation, whether done now or found in the cache.
    """

    compliance: _mtb_rs.Compliance | None
    displacement: Array
    motions: Array
    work: Array
    includes_motion: bool = False
    state: Any = None
    operations: float = 0.0


@dataclass(frozen=True)
@plain
class Kept:
    """Which nodes of regular grids are contact points, where the others lie beside a body.

    Attributes
    ----------
    nodes : SheetPoints
        All nodes of the grids.
    numbers : (n,) int
        The contact points among them.
    rise : (n,) [m]
        Of the gap between the faces of the bodies over the cells around each contact point.
    part : (n,) int
        Part of the faces that each is on: kinks divide them.
    """

    nodes: SheetPoints
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
class ContactProblem:
    """Everything the solver needs, at the contact points.

    Attributes
    ----------
    points : SheetPoints
    area : (n,) [m2]
    patches : tuple of Patch
        The grids that the contact points are nodes or cells of.
    friction
        Number field (n,) or :class:`PressureDependentFriction`.
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
    memory : Memory
        What depends on the bodies alone; further loads on the same ones share it.
    doubts : tuple of str
        What its geometry makes doubtful, in whole sentences.
    """

    points: SheetPoints
    area: Array
    patches: tuple[Patch, ...]
    friction: Array | PressureDependentFriction
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
    doubts: tuple[str, ...] = ()

    @property
    def n(self) -> int:
        """Number of contact points."""
        return int(self.area.size)

    @property
    def operations(self) -> float:
        """Floating-point operations of the condensation of both bodies."""
        return self.upper.operations + self.lower.operations

    @property
    def places(self) -> Array:
        """Where the load of each contact point acts (3, n) [m]."""
        return self.points.points if self.averages is None else self.averages.places

    def friction_at(self, pressure: Array) -> Array:
        """Friction coefficient (n,)."""
        if isinstance(self.friction, PressureDependentFriction):
            return self.friction.at(pressure)
        return self.friction

    def relative_motions(self) -> tuple[Array, Array]:
        """Motions as (m, 3, n) of lower minus upper along the tangents and of the opening; their work."""
        parts = []
        for side, sign in ((self.upper, 1.0), (self.lower, -1.0)):
            local = to_local(side.motions, self.points)
            parts.append(np.stack([-sign * local[:, 0], -sign * local[:, 1], sign * local[:, 2]], axis=1))
        return (
            np.ascontiguousarray(np.concatenate(parts)),
            np.concatenate([self.upper.work, self.lower.work]),
        )

    def axes(self) -> list[tuple[Patch, Array, Array]]:
        """Each patch with the coordinates [m] of its columns (x) and rows (arc length)."""
        return [(patch, *patch.axes()) for patch in self.patches]

    def on_grid(self, values: NDArray[Any], rest: NDArray[Any] | float = 0.0) -> NDArray[Any]:
        """`values` (..., n) of the contact points at all points of the grids; `rest` beside the bodies."""
        return values if self.kept is None else self.kept.put(values, rest)

    def opening(self) -> Array:
        """Gap (n,) [m] with the motions prescribed on both bodies, before contact."""
        apart = self.upper.displacement - self.lower.displacement
        return np.ascontiguousarray(self.gap + np.einsum("in,in->n", apart, self.points.normal))


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
    unstable: bool = False
    convolutions: float = 0.0
    preconditionings: float = 0.0
    operations: float = 0.0

    def coefficients(self, problem: ContactProblem) -> Array:
        """The unknowns (3, n) [Pa]: traction along both tangents on the lower body, and pressure."""
        return np.concatenate([self.friction * self.pressure * problem.direction, self.pressure[None]])


def to_local(vectors: Array, points: SheetPoints) -> Array:
    """Vectors (..., 3, n) of the common frame in the frame (tangent x, tangent y, normal) of each point."""
    frame = np.stack([points.tangent_x, points.tangent_y, points.normal])
    return np.asarray(np.einsum("cin,...in->...cn", frame, vectors))


def to_global(components: Array, points: SheetPoints) -> Array:
    """The inverse of :func:`to_local`."""
    frame = np.stack([points.tangent_x, points.tangent_y, points.normal])
    return np.asarray(np.einsum("cin,...cn->...in", frame, components))


def sliding_direction(direction: tuple[float, float] | None, points: SheetPoints) -> Array:
    """Unit sliding direction (2, n) in each tangent plane; zeros where nothing slides."""
    n = points.points.shape[1]
    if direction is None:
        return np.zeros((2, n))
    vector = np.array([direction[0], direction[1], 0.0])
    if not np.isfinite(vector).all() or not vector.any():
        raise ValueError(f"sliding_direction is {direction}: two finite numbers, not both zero, are needed")
    vector = vector / np.abs(vector).max()
    local = np.stack([vector @ points.tangent_x, vector @ points.tangent_y])
    length = np.linalg.norm(local, axis=0)
    if length.min() < 1e-6 * np.linalg.norm(vector):
        raise ValueError(f"sliding_direction is {direction}: at some points it is normal to the surface")
    return np.ascontiguousarray(local / length)


def solve_direct(
    problem: ContactProblem, start: NDArray[np.bool_] | None = None, *, with_margin: bool = True
) -> Solution:
    """Solves the contact conditions as one complementarity problem.

    Raises
    ------
    ValueError
        If both bodies are free along z, so that nothing says how high they are.
    ResultantError
        If the load lies outside what the contact can carry.
    ConvergenceError
        If no sliding equilibrium exists (wedging), or none was found.
    """
    _check_height(problem)
    fold = folded(problem)
    if fold is not None:
        return _unfolded(_solve_whole(fold.half, start, with_margin), fold, problem)
    return _solve_whole(problem, start, with_margin)


def _check_height(problem: ContactProblem) -> None:
    """One body must know its height: contact only says how far they are apart."""
    if _lifting(problem.upper).any() and _lifting(problem.lower).any():
        free = [part.body.name for side in (problem.lower, problem.upper) for part in side.state or ()]
        also = f", and {free[1]} as well" if len(free) > 1 else ", and what lies above is free as well"
        raise ValueError(
            f"the supports leave {free[0]} free along z{also}: nothing says how high the bodies are. Hold z "
            "of one of them by a support (a guide gives a force, it does not hold)"
        )


def _lifting(side: Side) -> NDArray[np.bool_]:
    """Which motions of a side are translations along z of all of its points."""
    rise = np.abs(side.motions[:, 2])
    others = np.abs(side.motions[:, :2]).max(axis=(1, 2), initial=0.0)
    highest, lowest = rise.max(axis=1, initial=0.0), rise.min(axis=1, initial=np.inf)
    return np.asarray((highest > 0.0) & (lowest >= (1.0 - 1e-9) * highest) & (others <= 1e-9 * highest))


def _unfolded(solution: Solution, fold: Fold, problem: ContactProblem) -> Solution:
    """The solution of the whole from that of its half."""
    amplitudes = np.append(solution.motion, 0.0)
    return replace(
        solution,
        pressure=np.ascontiguousarray(solution.pressure[fold.source]),
        gap=np.ascontiguousarray(solution.gap[fold.source]),
        motion=amplitudes[fold.motion_source],
        friction=problem.friction_at(solution.pressure[fold.source]),
        solver=f"{solution.solver}, mirror half",
    )


def _solve_whole(problem: ContactProblem, start: NDArray[np.bool_] | None, with_margin: bool) -> Solution:
    clock = time.perf_counter()
    frictional = bool(problem.direction.any()) and not (
        isinstance(problem.friction, np.ndarray) and not problem.friction.any()
    )
    memory.say(memory.of_sliding(problem.n, frictional), f"the sliding contact of {problem.n} points")
    made_from = (problem.lower.compliance, problem.upper.compliance, problem.direction, frictional)
    pair = problem.memory.recall("pair", made_from, lambda: _mtb_rs.SlidingPair(*made_from))
    problem.time_s["influence matrix"] = time.perf_counter() - clock
    clock = time.perf_counter()
    motions, work = problem.relative_motions()
    gap = problem.opening()
    active = None if start is None else start.tolist()
    friction = problem.friction_at(np.zeros(problem.n))
    iterations = 0
    for _ in range(FRICTION_ROUNDS):
        effective = friction if frictional else np.zeros(problem.n)
        out = pair.solve(gap, problem.area, effective, problem.direction, motions, work, active)
        iterations += out["iterations"]
        before, friction = friction, problem.friction_at(out["pressure"])
        if np.abs(friction - before).max() <= FRICTION_TOLERANCE * max(1.0, float(friction.max())):
            break
        active = (out["pressure"] > 0.0).tolist() if out["status"] == "solved" else None
    else:
        out["status"] = "iteration limit"
    problem.time_s["complementarity"] = time.perf_counter() - clock
    clock = time.perf_counter()
    margin: float | None = None
    if frictional and with_margin:
        factor = problem.memory.recall(
            "wedging factor",
            [pair, problem.area, friction, motions],
            lambda: pair.wedging_factor(problem.area, friction, motions),
        )
        margin = 0.0 if np.isinf(factor) else (1.0 / factor if factor > 0.0 else float("inf"))
    problem.time_s["wedging margin"] = time.perf_counter() - clock
    return Solution(
        pressure=out["pressure"],
        gap=out["gap"],
        motion=out["motion"],
        friction=friction,
        status=out["status"],
        solver="Lemke pivots" if out["by_lemke"] else "active set, dense factorisation",
        iterations=iterations,
        residual=out["residual"],
        wedging_margin=margin,
        unstable=out["unstable"],
        operations=dense_operations(problem.n, int((out["pressure"] > 0.0).sum()), iterations),
    )


def dense_operations(points: int, contact: int, iterations: int) -> float:
    """Floating-point operations of a dense solve: its matrix, and a factorisation and a product each time."""
    return ENTRY * points**2 + iterations * (2.0 / 3.0 * contact**3 + 2.0 * points**2)


def finish(
    problem: ContactProblem,
    solution: Solution,
    *,
    method: str,
    surfaces: tuple[Surface, ...],
    summary: Mapping[str, Any],
    omitted: Mapping[str, Any] | None = None,
    errors: Mapping[str, float] | None = None,
    aim: tuple[str, float] | None = None,
    choosing: float = 0.0,
    spacing: tuple[float, float] | None = None,
    bodies: tuple[Any, Any] = (None, None),
) -> Result:
    """Tractions, displacements, forces and the report of a solution.

    Parameters
    ----------
    errors : Mapping of quantity to its estimated relative error
    aim : (quantity, tolerance)
    choosing : float
        Floating-point operations of what was solved besides, to choose and to estimate.
    spacing : (dx, dy) [m]

    Raises
    ------
    ConvergenceError, ResultantError
        If `solution` is none; the state is attached.
    """
    points, area, n = problem.points, problem.area, problem.n
    coefficients = solution.coefficients(problem)
    tangential, pressure = coefficients[:2], coefficients[2]
    load = _resultants(problem, coefficients)
    mean = mean_tractions(problem, coefficients)
    traction = to_global(np.concatenate([mean[:2], np.zeros((1, n))]), points)
    contact = pressure > 0.0
    status = np.where(contact, np.where(np.any(tangential != 0.0, axis=0), 2, 1), 0).astype(np.int8)

    m_upper = problem.upper.work.size
    displacement = Displacement(
        upper=displaced(problem.upper, -tangential, pressure, solution.motion[:m_upper], points, 1.0),
        lower=displaced(problem.lower, tangential, pressure, solution.motion[m_upper:], points, -1.0),
    )
    deformation = {
        "upper": _deformed(problem.upper, displacement.upper, solution.motion[:m_upper]),
        "lower": _deformed(problem.lower, displacement.lower, solution.motion[m_upper:]),
    }
    force = load.sum(axis=1)
    reference_point = np.zeros(3)
    moment = np.cross(problem.places, load, axis=0).sum(axis=1)
    balance, reactions = _balance(problem, coefficients, force)
    nodes = points if problem.kept is None else problem.kept.nodes

    def put(values: NDArray[Any], rest: NDArray[Any] | float = 0.0) -> NDArray[Any]:
        return problem.on_grid(values, rest).reshape(*values.shape[:-1], *problem.shape)

    converged = solution.status == "solved"
    tipping = tipping_margin(problem, solution.friction)
    pull = np.asarray(problem.loads.get("pull", problem.loads.get("magnetic", np.zeros(3))))
    grown = jammed(problem, solution, abs(float(pull[2]))) if converged else None
    words = _explain(problem, solution)
    if grown is not None:
        jam = f"body has jammed: {_jam_in_words(problem, solution, grown, pull)}"
        words = f"{words}, but the {jam}"
        warn(f"The {jam}.")
    report = Report(
        converged=converged,
        status=words,
        model=problem.model,
        method=method,
        solver=solution.solver,
        iterations=solution.iterations,
        residual=solution.residual,
        contact_area=float(area[contact].sum()),
        peak_pressure=float(mean[2].max(initial=0.0)),
        convolutions=solution.convolutions,
        preconditionings=solution.preconditionings,
        force_balance=balance,
        reactions=reactions,
        # the size of what was left out is unknown where the fuller model has no solution
        omitted={k: v if v != np.inf else UNKNOWN for k, v in (omitted or {}).items()},
        error_estimates={k: v for k, v in (errors or {}).items() if np.isfinite(v)},
        aim=aim,
        spacing=spacing,
        operations={
            "condensation": problem.operations,
            "solution": solution.operations,
            "choice and estimate": choosing,
        },
        wedging_margin=(
            None if solution.wedging_margin is None else max(solution.wedging_margin, tipping or 0.0)
        ),
        tipping_margin=tipping,
        time_s=dict(problem.time_s),
    )
    result = Result(
        points=put(points.points, nodes.points),
        area=put(area),
        normal=nodes.normal.reshape(3, *problem.shape),
        pressure=put(mean[2]),
        traction=put(traction),
        gap=put(solution.gap, nodes.gap),
        initial_gap=nodes.gap.reshape(problem.shape),
        status=put(status),
        displacement=Displacement(*map(put, displacement)),
        force=force,
        moment=moment,
        reference_point=reference_point,
        normal_force=float(mean[2] @ area),
        approach=_approach(problem, solution),
        model=problem.model,
        error_estimate=report.error_estimates.get("pressure"),
        report=report,
        patches=problem.patches,
        surfaces=surfaces,
        summary=summary,
        lower=bodies[0],
        upper=bodies[1],
        parts=(*(problem.upper.state or ()), *(problem.lower.state or ())),
        coefficients=coefficients,
        motion=solution.motion,
    )
    if not converged:
        kind = ResultantError if solution.status == "unreachable" else ConvergenceError
        raise kind(report.status, result)
    ask(of_result(result, deformation))
    return result


def _balance(
    problem: ContactProblem, coefficients: Array, force: Array
) -> tuple[dict[str, Any], dict[str, Array]]:
    """All forces (3,) [N] that must cancel, and the reaction of each support of the elastic bodies."""
    balance: dict[str, Any] = dict(problem.loads)
    balance["contact"] = force
    worst = _imbalance(problem, coefficients)
    reactions: dict[str, Array] = {}
    for name, side in (("upper", problem.upper), ("lower", problem.lower)):
        parts = side.state or ()
        forces = {part.body.name: part.forces(coefficients) for part in parts}
        if not forces:
            continue
        worst = max(worst, *(f.relative_error for f in forces.values()))
        held = {f"{body}: {k}": v[:3] for body, f in forces.items() for k, v in f.supports.items()}
        reactions |= held
        balance[f"supports of the {name} body"] = sum(held.values(), np.zeros(3))
        if name == "lower" and any(part.pull.any() for part in parts):
            balance["magnetic on the lower body"] = sum(
                (f.magnetic[:3] for f in forces.values()), np.zeros(3)
            )
    if "magnetic" in balance and not problem.upper.state:
        balance["supports of the upper body"] = force - np.asarray(balance["magnetic"])
    balance["relative_error"] = worst
    return balance, reactions


def mean_tractions(problem: ContactProblem, coefficients: Array) -> Array:
    """Mean tractions (3, n) [Pa] over each contact point, from the coefficients of its basis.

    Under hats the coefficients swing about a steep pressure; their means over the contact points do
    not, and are what other programs give as nodal pressure. What a point in contact would give to an
    open one it keeps, so the force stays and open points carry nothing.
    """
    if problem.averages is None:
        return coefficients
    return problem.averages.means(coefficients, problem.area)


def _resultants(problem: ContactProblem, coefficients: Array) -> Array:
    """Load (3, n) [N] of each contact point on the lower body."""
    local = coefficients * np.array([[1.0], [1.0], [-1.0]])
    if problem.averages is None:
        return problem.area * to_global(local, problem.points)
    return np.asarray(problem.area * np.einsum("cn,cin->in", local, problem.averages.frames))


def _imbalance(problem: ContactProblem, coefficients: Array) -> float:
    """Largest relative work left over on a free rigid motion."""
    worst = 0.0
    for motion, work in zip(*problem.relative_motions(), strict=True):
        parts = problem.area * (coefficients * motion).sum(axis=0)
        scale = float(np.abs(parts).sum() + abs(work))
        if scale > 0.0:
            worst = max(worst, float(abs(parts.sum() + work)) / scale)
    return worst


def displaced(
    side: Side, tangential: Array, pressure: Array, motion: Array, points: SheetPoints, into: float
) -> Array:
    """Displacement (3, n) of a body's contact points; `into` is +1 where the normal points into it."""
    total = side.displacement.copy()
    if side.compliance is not None:
        local = side.compliance.displacement(np.concatenate([tangential, pressure[None]]))
        local[2] *= into
        total += to_global(local, points)
    if side.includes_motion:
        total += np.einsum("m,min->in", motion, side.motions)
    return total


def _deformed(side: Side, displacement: Array, motion: Array) -> Array:
    """The displacement (3, n) of :func:`displaced` without rigid motion, free or prescribed."""
    if not side.includes_motion:
        return displacement
    own = displacement - np.einsum("m,min->in", motion, side.motions)
    return np.asarray(own - own.mean(axis=1, keepdims=True))


def _approach(problem: ContactProblem, solution: Solution) -> float | Array:
    """How far the bodies moved together [m], one number a free patch."""
    if problem.approach is not None:
        return problem.approach
    amplitudes = []
    for k, motion in enumerate(problem.upper.motions):
        vertical = motion[2]
        # translations only: tilts have no one approach
        if np.ptp(motion[:, vertical != 0.0], axis=1).max(initial=0.0) == 0.0 and vertical.any():
            amplitudes.append(-float(solution.motion[k]) * float(vertical[vertical != 0.0][0]))
    if not amplitudes:
        return 0.0
    return amplitudes[0] if len(amplitudes) == 1 else np.array(amplitudes)


def _explain(problem: ContactProblem, solution: Solution) -> str:
    """The status in words a user can act on."""
    if solution.status == "solved":
        if solution.unstable:
            return "solved, but on an unstable branch: a little more load gives less contact"
        return "solved"
    mu = float(solution.friction.max(initial=0.0))
    if solution.status == "unreachable":
        return (
            "the resultant of the load lies outside what the contact can carry: no pressure >= 0 on the "
            f"{problem.n} contact points balances it ({_loads_in_words(problem)}){_lost_hold(problem)}"
        )
    margin = solution.wedging_margin
    if solution.status == "no solution" or (margin is not None and margin > 1.0):
        limit = f"{mu / margin:.3g}" if margin not in (None, 0.0) else "unknown"
        held = "" if _friction_is_idle(problem) else " with its free tilts held"
        return (
            f"no sliding equilibrium: the body wedges. The friction coefficient is {mu:g}, sliding is "
            f"certain to exist only up to {limit} in this scene{held}"
        )
    outcome = f"not converged after {solution.iterations} iterations (residual {solution.residual:.1e}"
    if solution.solver.startswith(("load increments", "staggered")):
        return (
            f'{outcome}; {solution.solver}): method="direct" solves the scene without increments or factors'
        )
    return f"{outcome}{_lost_digits(problem)})"


def _friction_is_idle(problem: ContactProblem) -> bool:
    """Whether friction enters the balance of no free motion: then mu_sym is proved."""
    motions, _ = problem.relative_motions()
    return not np.einsum("cn,mcn->mn", problem.direction, motions[:, :2]).any()


def _jam_in_words(problem: ContactProblem, solution: Solution, grown: float, pull: Array) -> str:
    force = float(solution.pressure @ problem.area)
    over = f", {force / abs(pull[2]):.3g} times the pull" if pull[2] else ""
    mu = float(solution.friction.max(initial=0.0))
    return (
        f"the contact force is {force:.3g} N{over}, and {grown:.3g} times that without friction. A friction "
        f"coefficient of {mu:g} lies so near the wedging limit that any small change multiplies the force"
    )


def _lost_digits(problem: ContactProblem) -> str:
    """What rounding did, where the displacements by the load vanish beside the gap or swallow it."""
    pull = np.asarray(problem.loads.get("pull", np.zeros(3)))
    height = float(np.ptp(problem.gap))
    compliances = [side.compliance for side in (problem.upper, problem.lower) if side.compliance is not None]
    if not pull.any() or height == 0.0 or not compliances:
        return ""
    one = np.zeros((3, problem.n))
    one[2] = np.abs(pull[2]) / float(problem.area.sum())
    moved = sum(float(np.abs(c.displacement(one)[2]).max()) for c in compliances)
    if moved >= 1e-12 * height:
        return ""
    return (
        f"; the force of {abs(pull[2]):.3g} N moves the surfaces by about {moved:.1e} m, "
        f"lost in the rounding of a gap that varies by {height:.1e} m"
    )


def _loads_in_words(problem: ContactProblem) -> str:
    parts = (*(problem.upper.state or ()), *(problem.lower.state or ()))
    words = [line for part in parts for line in part.loads_in_words()]
    pull = problem.loads.get("pull", problem.loads.get("magnetic"))
    if pull is not None:
        words.insert(0, f"force {np.asarray(pull)[2]:.6g} N along z")
    return ", ".join(words) or "no force"


def _lost_hold(problem: ContactProblem) -> str:
    """Why no pressure balances the load: it pulls the bodies apart, or friction tips them over."""
    for side, up in ((problem.upper, 1.0), (problem.lower, -1.0)):
        lifts = [(part.body.name, lift) for part in side.state or () for lift in part.lifts]
        for (name, lift), work in zip(lifts, side.work, strict=False):
            if up * lift * work > 0.0:
                return f": in all {up * work / lift:.6g} N pull {name} off the contact"
    if problem.averages is not None and problem.direction.any():
        smooth = replace(problem, direction=np.zeros_like(problem.direction), time_s={})
        if solve_direct(smooth, with_margin=False).status == "solved":
            return ": without friction the contact carries it, so friction tips a body over"
    return ""


def sided_influence(
    compliance: _mtb_rs.Compliance | None, direction: Array, friction: Array, *, upper: bool
) -> Array:
    """Gap (n, n) [m/Pa] that a body opens under unit pressures and the friction they bring."""
    n = friction.size
    if compliance is None:
        return np.zeros((n, n))
    matrix = compliance.influence("n", "n")
    sign = -1.0 if upper else 1.0
    for component, along in zip("xy", direction, strict=True):
        slip = friction * along
        if slip.any():
            matrix += sign * compliance.influence("n", component) * slip
    return np.asarray(matrix)


def half_space_side(
    body: HalfSpace | Rigid,
    patches: tuple[Patch, ...],
    *,
    interact: bool,
) -> Side:
    """A half-space or rigid body under one or several patches of cells."""
    compliance, n = None, sum(p.nx * p.ny for p in patches)
    if isinstance(body, HalfSpace):
        compliance = _mtb_rs.half_space(
            body.material.shear_modulus,
            body.material.poisson_ratio,
            [(*p.origin, p.nx, p.ny) for p in patches],
            [p.spacing for p in patches],
            interact,
        )
    return Side(compliance, np.zeros((3, n)), np.zeros((0, 3, n)), np.zeros(0))


def with_loads(side: Side, motions: Array, work: Array) -> Side:
    """The same body with rigid motions that only the contact holds."""
    return replace(side, motions=motions, work=work)


def magnetic_field(
    spec: Any,
    points: SheetPoints,
    patches: tuple[Patch, ...],
    velocity: float | None,
    kept: Kept | None = None,
) -> Array:
    """Magnetic pressure (n,) [Pa] at the contact points."""
    numbers = None if kept is None else kept.numbers
    return load_field("magnetic_pressure", spec, points.points, patches, velocity, kept=numbers)
