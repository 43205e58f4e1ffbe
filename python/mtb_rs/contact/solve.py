# SPDX-License-Identifier: MIT OR Apache-2.0
"""From a scene to its result, on one page.

A scene becomes a :class:`ContactProblem` (points, gap, compliances, rigid motions with their
balance); the compiled core solves it; :func:`finish` turns the pressure into everything a user asks for.
"""

from __future__ import annotations

import time
from collections.abc import Mapping
from dataclasses import replace
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from .. import _mtb_rs
from ..base import memory
from ..base.errors import ConvergenceError, ResultantError
from ..base.owning import check_finite
from ..base.questions import ask
from ..bodies.sides import Side
from ..friction.fields import field as load_field
from ..geometry.contact_points import ContactPoints, Patch
from ..geometry.triangles import Surface
from ..half_space.normal import FLOW
from ..results.plausible import of_result
from ..results.report import Report
from ..results.result import Displacement, Result
from .problem import ContactProblem, Kept, Solution, mean_tractions, to_global
from .symmetry import MirrorSymmetry, mirror_symmetry, turned_half
from .wedging import tipping_margin

Array = NDArray[np.float64]
Body = Literal["upper", "lower"]

#: Words for the size of an effect that could not be estimated.
UNKNOWN = "of unknown size: the model with it has no solution on wider cells"

#: What is not known of one half of a scene, and the margin from which on it matters.
SYMMETRIC_MARGIN = (
    "The margin to wedging and the stability of the branch are those of states that are their own mirror "
    "images, because a body was condensed as its half. In other states the bodies may wedge at up to 15 % "
    "less friction. A sliding_direction=(1, 1e-9) breaks the mirror, and tells both."
)
NEAR = 0.5

#: What is not known of a solution by products.
UNKNOWN_MARGIN = (
    "The margin to wedging and the stability of the branch were not computed, because {points} points are "
    "solved without a matrix. Wider cells, on which the margin is nearly the same, tell both."
)

#: Floating-point operations of an entry of a dense influence matrix, and of a contact point in a product
#: without one, about.
ENTRY, PRODUCT = 50.0, 2000.0


def solve_direct(problem: ContactProblem, *, with_margin: bool = True) -> Solution:
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
    symmetry = mirror_symmetry(problem)
    if symmetry is None:
        return _solve_whole(problem, with_margin)
    half = _solve_whole(symmetry.half, with_margin)
    margin = half.wedging_margin
    if margin is not None:
        turned = turned_half(problem, symmetry.image)
        if turned is not None and turned.n:
            # bodies may wedge first in states that the mirror turns around
            margin = max(margin, _margin(turned, half.friction[symmetry.off_plane]) or 0.0)
            if half.status == "solved" and margin > 1.0:
                # beyond it a state may leave its mirror image, which the half does not see
                return _solve_whole(problem, with_margin)
            half = replace(half, wedging_margin=margin)
        elif turned is None and margin > NEAR:
            half = replace(half, notes=(*half.notes, SYMMETRIC_MARGIN))
    return _of_both_halves(half, symmetry, problem)


def _margin(problem: ContactProblem, friction: Array) -> float | None:
    """Friction over the bound up to which sliding is certain; None where it is not known."""
    core, direction = problem.core, np.ascontiguousarray(problem.direction)
    most = float(friction.max(initial=0.0)) or 1.0
    # the same for all coefficients of one shape
    shape = np.ascontiguousarray(friction / most)
    factor = problem.memory.recall(
        "wedging factor", [core, direction, shape], lambda: core.wedging_factor(direction, shape)
    )
    if np.isnan(factor):
        return None
    return 0.0 if np.isinf(factor) else (most / factor if factor > 0.0 else float("inf"))


def _check_height(problem: ContactProblem) -> None:
    """One body must know its height: contact only says how far they are apart."""
    if _lifting(problem.upper).any() and _lifting(problem.lower).any():
        free = [part.body.name for side in (problem.lower, problem.upper) for part in side.state]
        also = f", and {free[1]} as well" if len(free) > 1 else ", and what lies above is free as well"
        raise ValueError(
            f"the supports leave {free[0]} free along z{also}: nothing says how high the bodies are. Hold z "
            "of one of them by a support (a guide gives a force, it does not hold)"
        )


def _lifting(side: Side) -> NDArray[np.bool_]:
    """Which motions of a side are translations along z of all of its points."""
    moves_all = np.all(np.any(side.motions, axis=1), axis=1)
    return np.asarray((side.lifts != 0.0) & moves_all)


def _of_both_halves(solution: Solution, symmetry: MirrorSymmetry, problem: ContactProblem) -> Solution:
    """The solution of the whole from that of its half."""
    return replace(
        solution,
        pressure=np.ascontiguousarray(solution.pressure[symmetry.source]),
        gap=np.ascontiguousarray(solution.gap[symmetry.source]),
        motion=symmetry.whole_motion(solution.motion),
        friction=problem.friction_at(solution.pressure[symmetry.source]),
        solver=f"{solution.solver}, mirror half",
    )


def _solve_whole(problem: ContactProblem, with_margin: bool) -> Solution:
    clock = time.perf_counter()
    law = problem.friction
    frictional = bool(problem.direction.any()) and law.may_act
    core, direction = problem.core, np.ascontiguousarray(problem.direction)
    if not core.is_by_products:
        memory.say(memory.of_sliding(problem.n, frictional), f"the sliding contact of {problem.n} points")
    core.prepare(direction, frictional)
    problem.time_s["influence matrix"] = time.perf_counter() - clock
    clock = time.perf_counter()
    coefficients = law.at if law.fixed is None else np.ascontiguousarray(law.fixed)
    magnet = problem.attracting
    notes: tuple[str, ...] = ()
    if magnet is None:
        out = core.slide(problem.loading, direction, coefficients)
    else:
        given = problem.free_loading, direction, coefficients, magnet.given
        out = core.slide(*given, magnet.start(problem.n), with_margin)
        if with_margin and out.status == "solved":
            notes = _other_state(out, core.slide(*given, magnet.start(problem.n, other=True)), problem)
    problem.time_s["complementarity"] = time.perf_counter() - clock
    clock = time.perf_counter()
    margin: float | None = None
    is_unknown = False
    if frictional and with_margin:
        margin = _margin(problem, out.friction)
        is_unknown = margin is None
        if is_unknown:
            notes = (*notes, UNKNOWN_MARGIN.format(points=problem.n))
    problem.time_s["wedging margin"] = time.perf_counter() - clock
    return Solution(
        pressure=out.pressure,
        gap=out.gap,
        motion=out.motion,
        friction=out.friction,
        status=out.status,
        solver=_solver_of(core, by_lemke=out.by_lemke),
        iterations=out.iterations,
        residual=out.residual,
        wedging_margin=margin,
        # by products no determinant is known
        unstable=None if is_unknown else out.unstable or snaps(out.settled),
        notes=notes,
        operations=(
            product_operations(problem.n, out.iterations)
            if core.is_by_products
            else dense_operations(problem.n, int((out.pressure > 0.0).sum()), out.iterations)
        ),
        settled=out.settled,
    )


#: Difference of the pulls of two states, in parts of the pull, from which on they are two.
TWO_STATES = 1e-6


def snaps(settled: _mtb_rs.Settled | None) -> bool:
    """Whether a magnet is stiffer than what holds the bodies, so that its state does not stay."""
    return settled is not None and settled.share is not None and settled.share >= 1.0


def _other_state(out: _mtb_rs.Outcome, other: _mtb_rs.Outcome, problem: ContactProblem) -> tuple[str, ...]:
    """What there is to say of a second state under a magnet."""
    assert problem.attracting is not None
    if other.status != "solved" or out.settled is None or other.settled is None:
        return ()
    here, there = (float(problem.area @ found.pull) for found in (out.settled, other.settled))
    if abs(here - there) <= TWO_STATES * max(here, there):
        return ()
    found, else_ = "bodies that stood apart", "bodies that have touched"
    if problem.attracting.from_touching:
        found, else_ = else_, found
    return (
        f"The magnet has two states here. This is that of {found}, with an attraction of {here:.6g} N; "
        f"that of {else_} has one of {there:.6g} N.",
    )


def product_operations(points: int, products: int) -> float:
    """Floating-point operations of a solve by products."""
    return PRODUCT * points * products


#: The solver of contacts of many points.
BY_PRODUCTS = "active set, GMRES"


def _solver_of(core: _mtb_rs.Problem, *, by_lemke: bool) -> str:
    if core.is_by_products:
        return BY_PRODUCTS
    return "Lemke pivots" if by_lemke else "active set, dense factorisation"


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
    velocity: Array | None = None,
) -> Result:
    """Tractions, displacements, forces and the report of a solution.

    Parameters
    ----------
    errors : Mapping of quantity to its estimated relative error
    aim : (quantity, tolerance)
    choosing : float
        Floating-point operations of what was solved besides, to choose and to estimate.
    spacing : (dx, dy) [m]
    velocity : (2,) [m/s] or None
        Of sliding; None: not known, or nothing slides.

    Raises
    ------
    ConvergenceError, ResultantError
        If `solution` is none; the state is attached.
    """
    problem = problem.settled(solution)
    points, area, n = problem.points, problem.area, problem.n
    check_finite("pressure", solution.pressure)
    coefficients = solution.coefficients(problem)
    tangential, pressure = coefficients[:2], coefficients[2]
    mean = mean_tractions(problem, coefficients)
    traction = to_global(np.concatenate([mean[:2], np.zeros((1, n))]), points)
    contact = pressure > 0.0
    moves = np.where(problem.yields(solution.friction, pressure), 3, 2)
    status = np.where(contact, np.where(np.any(tangential != 0.0, axis=0), moves, 1), 0).astype(np.int8)

    m_upper = problem.upper.work.size
    displacement = Displacement(
        upper=displaced(problem, "upper", coefficients, solution.motion[:m_upper]),
        lower=displaced(problem, "lower", coefficients, solution.motion[m_upper:]),
    )
    deformation = {
        "upper": _deformed(problem.upper, displacement.upper, solution.motion[:m_upper]),
        "lower": _deformed(problem.lower, displacement.lower, solution.motion[m_upper:]),
    }
    reference_point = np.zeros(3)
    load = problem.geometry.loads(np.ascontiguousarray(coefficients))
    force, moment = load.sum(axis=1), np.cross(problem.places, load, axis=0).sum(axis=1)
    balance, reactions = _balance(problem, coefficients, force)
    nodes = points if problem.kept is None else problem.kept.nodes

    def put(values: NDArray[Any], rest: NDArray[Any] | float = 0.0) -> NDArray[Any]:
        return problem.on_grid(values, rest).reshape(*values.shape[:-1], *problem.shape)

    # where one body has flowed the gap of the core is below zero
    flowed = None if problem.hardness is None else np.maximum(-solution.gap, 0.0)
    converged = solution.status == "solved"
    tipping = tipping_margin(problem, solution.friction)
    pull = problem.pressing
    grown = jammed(problem, solution, abs(float(pull[2]))) if converged else None
    words = _explain(problem, solution)
    if grown is not None:
        jam = f"body has jammed: {_jam_in_words(problem, solution, grown, pull)}"
        words = f"{words}, but the {jam}"
        ask([f"The {jam}."])
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
        omitted={k: v if v != np.inf else UNKNOWN for k, v in (omitted or {}).items()}
        | ({} if problem.hardness is None else {"plastic flow": FLOW}),
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
        notes=(*problem.notes, *solution.notes),
        magnet=of_magnet(problem.magnet, problem.area),
        time_s=dict(problem.time_s),
    )
    result = Result(
        points=put(points.points, nodes.points),
        area=put(area),
        normal=nodes.normal.reshape(3, *problem.shape),
        pressure=put(mean[2]),
        traction=put(traction),
        gap=put(np.maximum(solution.gap, 0.0) if flowed is not None else solution.gap, nodes.gap),
        magnetic_pressure=put(problem.attraction) if problem.attraction.any() else None,
        initial_gap=nodes.gap.reshape(problem.shape),
        status=put(status),
        displacement=Displacement(*map(put, displacement)),
        force=force,
        moment=moment,
        reference_point=reference_point,
        normal_force=float(mean[2] @ area),
        approach=_approach(problem, solution),
        friction_power=None if velocity is None else _power(problem, tangential, velocity),
        model=problem.model,
        error_estimate=report.error_estimates.get("pressure"),
        report=report,
        patches=problem.patches,
        surfaces=surfaces,
        summary=summary,
        lower=bodies[0],
        upper=bodies[1],
        parts=problem.parts,
        coefficients=coefficients,
        motion=solution.motion,
        plastic_indentation=None if flowed is None else put(flowed),
    )
    if not converged:
        raise failure(problem, solution, result)
    ask(of_result(result, deformation, result.parts))
    return result


def of_magnet(found: _mtb_rs.Settled | None, area: Array) -> dict[str, Any]:
    """What a magnet that follows the gap does, for the report."""
    if found is None:
        return {}
    told = {
        "attraction": float(area @ found.pull),
        "flux": found.flux,
        "ampere_turns_of_poles": tuple(found.forces),
        "solves": found.solves,
        "residual": found.residual,
    }
    return told if found.share is None else told | {"snap_share": found.share}


def _balance(
    problem: ContactProblem, coefficients: Array, force: Array
) -> tuple[dict[str, Any], dict[str, Array]]:
    """All forces (3,) [N] that must cancel, and the reaction of each support of the elastic bodies."""
    balance: dict[str, Any] = dict(problem.loads)
    balance["contact"] = force
    worst = _imbalance(problem, coefficients)
    reactions: dict[str, Array] = {}
    for name, side in (("upper", problem.upper), ("lower", problem.lower)):
        forces = {part.body.name: part.forces(coefficients) for part in side.state}
        if not forces:
            continue
        worst = max(worst, *(f.relative_error for f in forces.values()))
        held = {f"{body}: {k}": v[:3] for body, f in forces.items() for k, v in f.supports.items()}
        reactions |= held
        balance[f"supports of the {name} body"] = sum(held.values(), np.zeros(3))
        if name == "lower" and any(part.pull.any() for part in side.state):
            balance["magnetic on the lower body"] = sum(
                (f.magnetic[:3] for f in forces.values()), np.zeros(3)
            )
    if "magnetic" in balance and not problem.upper.state:
        balance["supports of the upper body"] = force - np.asarray(balance["magnetic"])
    balance["relative_error"] = worst
    return balance, reactions


def _imbalance(problem: ContactProblem, coefficients: Array) -> float:
    """Largest generalised load left over on a free rigid motion, relative to all tractions on their levers.

    The tractions count by their sizes, whatever their directions: a motion that none of them works on, such
    as one along the surface without friction, has rounding alone as its work.
    """
    worst = 0.0
    sizes = problem.area * np.linalg.norm(coefficients, axis=0)
    for motion, work in zip(problem.relative_motions, problem.loading.work, strict=True):
        rest = float((problem.area * (coefficients * motion).sum(axis=0)).sum() + work)
        scale = float(sizes @ np.linalg.norm(motion, axis=0) + abs(work))
        if scale > 0.0:
            worst = max(worst, abs(rest) / scale)
    return worst


def displaced(
    problem: ContactProblem, body: Body, coefficients: Array, motion: Array, pull: Array | None = None
) -> Array:
    """Displacement (3, n) [m] of a body's contact points, common frame.

    Parameters
    ----------
    coefficients : (3, n) [Pa]
        Unknowns: tractions on the lower body, and pressure.
    motion : (m,)
        Amplitudes of the body's own rigid motions.
    pull : (n,) [Pa] or None
        In place of the body's own.
    """
    side = problem.upper if body == "upper" else problem.lower
    pull = side.pull if pull is None else pull
    at_face = np.ascontiguousarray(pull) if side.is_pulled_at_face else None
    total = problem.core.displacement(np.ascontiguousarray(coefficients), body == "upper", at_face)
    total += side.displacement
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
    # translations only: tilts have no one approach
    lifts = problem.upper.lifts
    amplitudes = [-float(solution.motion[k] * lifts[k]) for k in np.flatnonzero(lifts)]
    if not amplitudes:
        return 0.0
    return amplitudes[0] if len(amplitudes) == 1 else np.array(amplitudes)


def _power(problem: ContactProblem, tangential: Array, velocity: Array) -> float:
    """Heat of sliding [W]: the work of friction (2, n) [Pa] on the velocity (2,) [m/s] of the upper body."""
    weights = problem.geometry.weights_of_resultants((0.0, 0.0, 0.0))[:2, :2]
    return float(np.einsum("k,kcn,cn->", velocity, weights, tangential))


#: Statuses of loads that no pressure of the contact carries.
NOT_CARRIED = ("unreachable", "overloaded")


def overload(hardness: Array | None, area: Array | None) -> str:
    """What there is to say of a load that the contact does not bear at its hardness."""
    over = "the load is more than the contact bears"
    if hardness is None or area is None:
        return f"{over} at its hardness, where it acts"
    return (
        f"{over}: at a hardness of {float(hardness.max()):.6g} Pa the contact points carry "
        f"{float(area @ hardness):.6g} N, if the load acts so that all of them flow, and less elsewhere"
    )


def failure(problem: ContactProblem, solution: Solution, result: Any = None) -> ConvergenceError:
    """The error of a solution that is none, in words a user can act on; its state is attached."""
    kind = ResultantError if solution.status in NOT_CARRIED else ConvergenceError
    return kind(_explain(problem, solution), result)


def _explain(problem: ContactProblem, solution: Solution) -> str:
    """The status in words a user can act on."""
    if solution.status == "solved":
        if snaps(solution.settled):
            return (
                "solved, but on an unstable branch: the magnet is stiffer than what holds the bodies, which "
                "snap together or apart"
            )
        if solution.unstable:
            return "solved, but on an unstable branch: a little more load gives less contact"
        return "solved"
    mu = float(solution.friction.max(initial=0.0))
    if solution.status == "overloaded":
        return f"{overload(problem.hardness, problem.area)} ({_loads_in_words(problem)})"
    if solution.status == "unreachable":
        return (
            "the resultant of the load lies outside what the contact can carry: no pressure >= 0 on the "
            f"{problem.n} contact points balances it ({_loads_in_words(problem)})"
            f"{_lost_hold(problem, solution)}"
        )
    margin = solution.wedging_margin
    if solution.status == "no solution" or (margin is not None and margin > 1.0):
        held = "" if _friction_is_idle(problem) else " with its free tilts held"
        certain = (
            f", sliding is certain to exist only up to {mu / margin:.3g} in this scene{held}"
            if margin
            else "; Scene.solve tells up to which one sliding is certain to exist"
        )
        return f"no sliding equilibrium: the body wedges. The friction coefficient is {mu:g}{certain}"
    outcome = f"not converged after {solution.iterations} iterations (residual {solution.residual:.1e}"
    if solution.solver.startswith(("load increments", "staggered")):
        return (
            f'{outcome}; {solution.solver}): method="direct" solves the scene without increments or factors'
        )
    if solution.solver.startswith(BY_PRODUCTS):
        outcome += "; so many points have no other method. Solve on wider cells"
    return f"{outcome}{_lost_digits(problem)})"


def _friction_is_idle(problem: ContactProblem) -> bool:
    """Whether friction enters the balance of no free motion: then mu_sym is proved."""
    return not np.einsum("cn,mcn->mn", problem.direction, problem.relative_motions[:, :2]).any()


def _jam_in_words(problem: ContactProblem, solution: Solution, grown: float, pull: Array) -> str:
    force = float(solution.pressure @ problem.area)
    over = f", {force / abs(pull[2]):.3g} times the load" if pull[2] else ""
    mu = float(solution.friction.max(initial=0.0))
    return (
        f"the contact force is {force:.3g} N{over}, and {grown:.3g} times that without friction. A friction "
        f"coefficient of {mu:g} lies so near the wedging limit that any small change multiplies the force"
    )


def _lost_digits(problem: ContactProblem) -> str:
    """What rounding did, where the displacements by the load vanish beside the gap or swallow it."""
    pull = np.asarray(problem.loads.get("pull", np.zeros(3)))
    height = float(np.ptp(problem.gap))
    if not pull.any() or height == 0.0:
        return ""
    one = np.zeros((3, problem.n))
    one[2] = np.abs(pull[2]) / float(problem.area.sum())
    moved = float(np.abs(problem.core.pair.displacement(one)[2]).max())
    if moved >= 1e-12 * height:
        return ""
    return (
        f"; the force of {abs(pull[2]):.3g} N moves the surfaces by about {moved:.1e} m, "
        f"lost in the rounding of a gap that varies by {height:.1e} m"
    )


def _loads_in_words(problem: ContactProblem) -> str:
    words = [line for part in problem.parts for line in part.loads_in_words()]
    if not problem.loads.keys().isdisjoint(("pull", "magnetic")):
        words.insert(0, f"force {problem.pressing[2]:.6g} N along z")
    if any(problem.moments):
        words.append("moments ({:.6g}, {:.6g}) N m about x and y".format(*problem.moments))
    return ", ".join(words) or "no force"


def _lost_hold(problem: ContactProblem, solution: Solution) -> str:
    """Why no pressure balances the load: it pulls the bodies apart, or friction tips them over."""
    for side, works, up in zip((problem.upper, problem.lower), problem.work, (1.0, -1.0), strict=True):
        lifts = [(part.body.name, lift) for part in side.state for lift in part.lifts]
        for (name, lift), work in zip(lifts, works, strict=False):
            if up * lift * work > 0.0:
                return f": in all {up * work / lift:.6g} N pull {name} off the contact"
    share = tipping_margin(problem, solution.friction)
    if share is not None and share < 1.0:
        return (
            f": it is {share:.3f} of the way to the border of the contact, where a body tips over, but "
            "nearer to it than these cells can carry a load. Narrower cells would carry it"
        )
    if problem.averages is None or not problem.direction.any():
        return ""
    if solve_direct(problem.without_friction(), with_margin=False).status == "solved":
        return ": without friction the contact carries it, so friction tips a body over"
    return ""


def sided_influence(
    compliance: _mtb_rs.Compliance | None, direction: Array, friction: Array, *, upper: bool
) -> Array:
    """Gap (n, n) [m/Pa] that a body opens under unit pressures and the friction they bring."""
    n = friction.size
    if compliance is None:
        return np.zeros((n, n))
    bodies = (None, compliance) if upper else (compliance, None)
    relative = _mtb_rs.Compliance.relative(*bodies)
    matrix = relative.influence("n", "n")
    for component, along in zip("xy", direction, strict=True):
        slip = friction * along
        if slip.any():
            matrix += relative.influence("n", component) * slip
    return np.asarray(matrix)


def magnetic_field(
    spec: Any,
    points: ContactPoints,
    patches: tuple[Patch, ...],
    velocity: float | None,
    kept: Kept | None = None,
) -> Array:
    """Magnetic pressure (n,) [Pa] at the contact points."""
    numbers = None if kept is None else kept.numbers
    return load_field("magnetic_pressure", spec, points.points, patches, velocity, kept=numbers)


#: Contact force over the load, and over that without friction, from which on a body counts as jammed. On the
#: way to the wedging limit of a clamped block ten times is passed just before it.
JAMMED = 10.0


def jammed(problem: ContactProblem, solution: Solution, pull: float) -> float | None:
    """Contact force over that without friction, where friction has multiplied it; None elsewhere.

    `pull` [N] is what presses the bodies together.
    """
    force = float(solution.pressure @ problem.area)
    beyond = solution.wedging_margin is not None and solution.wedging_margin > 1.0
    if not problem.direction.any() or not (beyond or 0.0 < JAMMED * pull < force):
        return None
    smooth = solve_direct(problem.without_friction(), with_margin=False)
    without = float(smooth.pressure @ problem.area)
    return force / without if smooth.status == "solved" and 0.0 < JAMMED * without < force else None
