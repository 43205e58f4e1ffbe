# SPDX-License-Identifier: MIT OR Apache-2.0
"""Half-spaces on one flat grid, solved by convolutions without a matrix."""

from __future__ import annotations

import time
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from ..base.questions import gathered
from ..bodies.simple import are_layered, are_prisms, are_unlike, velocity_over, without_layers
from ..contact.problem import ContactProblem, Solution
from ..half_space.motions import rolling_at
from ..half_space.normal import solve_normal
from .posed import PosedScene
from .taken import beyond

Array = NDArray[np.float64]

#: Relative residual of the convolution solver; the answer is then that of the dense one to eight digits.
CONVOLUTION_TOLERANCE = 1e-9
#: Rounds of pressure and friction in turn, and the share of the last change to which each is solved.
COUPLED_ROUNDS, ROUND_SHARE = 300, 0.1
#: Relative change by the last round of a solution of which only an estimate is made.
ROUGH_ROUND = 1e-4
#: Floating-point operations of a Fourier transform of n points over n log2 n; transforms of a convolution,
#: on twice as many points each way.
TRANSFORM, TRANSFORMS = 5.0, 2


def is_coupled(scene: PosedScene, problem: ContactProblem) -> bool:
    """Whether friction changes the gap between two half-spaces: something rubs, and materials are unlike."""
    if not problem.direction.any() or not problem.friction.may_act:
        return False
    return are_unlike(*scene.simple)


def is_by_convolution(scene: PosedScene, problem: ContactProblem) -> bool:
    """Whether this is one flat grid of cells between half-spaces, and nothing else."""
    flat = len(problem.patches) == 1 and bool((problem.points.normal[2] == 1.0).all())
    return (
        problem.model == "half-space"
        and flat
        and not beyond(scene, "convolutions")
        and problem.attracting is None
        and not are_prisms(*scene.simple)
        # waves of the opening that a round sends back may grow on a layer that hardly gives way
        and not (is_layered(scene) and is_coupled(scene, problem))
    )


def is_layered(scene: PosedScene) -> bool:
    return are_layered(*scene.simple)


def in_turn(scene: PosedScene, problem: ContactProblem, tolerance: float | None) -> Solution:
    """Unlike half-spaces that slide: pressure, and the opening of the gap by its friction, in turn.

    Waves of the opening that a round sends back are those it was given times `i mu beta cos`, with Dundurs'
    constant `beta` and the angle between wave and sliding: turned by a right angle, so that taking the share
    `1 / (1 + (mu beta)^2)` of each change leaves `mu beta / sqrt(1 + (mu beta)^2)` of the error, whatever
    the friction.
    """
    bodies = without_layers(scene.simple, "pressure and friction in turn")
    mixed = [body.mixed_compliance for body in bodies]
    plain = sum(body.normal_compliance for body in bodies)
    beta = abs(mixed[0] - mixed[1]) / (2.0 * plain)
    aim = ROUGH_ROUND if tolerance is None else tolerance
    opening = np.zeros(problem.n)
    products = preconditionings = operations = apart = 0.0
    iterations = 0
    for _ in range(COUPLED_ROUNDS):
        # the first round starts from no friction at all
        inner = max(aim, min(ROUND_SHARE * apart, ROUGH_ROUND)) if iterations else ROUGH_ROUND
        solution = by_convolution(scene, problem, inner, opening)
        iterations += solution.iterations
        products += solution.convolutions
        preconditionings += solution.preconditionings
        operations += solution.operations
        if solution.status != "solved":
            return solution
        wanted = _opening_by_friction(problem, solution)
        contact = solution.pressure > 0.0
        change = wanted - opening
        # a change of the approach alone changes no pressure under a force
        alone = 0.0 if scene.approach is not None or not contact.any() else change[contact].mean()
        approach = -solution.motion[0] if scene.approach is None else scene.approach
        moved = approach + solution.gap - opening - problem.points.gap
        size = float(np.linalg.norm(moved[contact]))
        apart = float(np.linalg.norm((change - alone)[contact])) / size if size > 0.0 else 0.0
        if apart <= aim and solution.residual <= 10.0 * aim:
            break
        steep = beta * float(np.abs(solution.friction[contact]).max(initial=0.0))
        opening += change / (1.0 + steep**2)
    fixed = problem.friction.fixed
    is_uniform = fixed is not None and bool(np.ptp(fixed) == 0.0)
    return replace(
        solution,
        solver=f"{solution.solver}, friction in turn",
        status="solved" if apart <= aim else "iteration limit",
        # uniform friction adds a skew part to a positive definite operator: there is no limit
        wedging_margin=0.0 if is_uniform else None,
        iterations=iterations,
        residual=max(solution.residual, apart),
        convolutions=products,
        preconditionings=preconditionings,
        operations=operations,
    )


def _opening_by_friction(problem: ContactProblem, solution: Solution) -> Array:
    """What friction adds to the gap (n,) [m]."""
    coefficients = solution.coefficients(problem)
    coefficients[2] = 0.0
    return np.asarray(problem.core.pair.displacement(coefficients)[2])


def by_convolution(
    scene: PosedScene, problem: ContactProblem, tolerance: float | None, opening: Array | None = None
) -> Solution:
    """The pressure without friction, or with the `opening` (n,) [m] of the gap by it."""
    clock = time.perf_counter()
    upper, lower = scene.simple
    grid, x, y = problem.axes()[0]
    # the approach is the solver's own; what is pulled up is nearer from the start
    gap = problem.points.gap + (problem.loading.gap - problem.gap)
    if opening is not None:
        gap = gap + opening
    about_x, about_y = scene.moments or (None, None)
    force = None if scene.approach is not None else -float(problem.work[0][0])
    if force is not None and not (
        abs(about_y or 0.0) < 0.5 * force * float(np.ptp(x))
        and abs(about_x or 0.0) < 0.5 * force * float(np.ptp(y))
    ):
        return _unreachable(problem)
    # the scene asks its own questions
    with gathered():
        normal = solve_normal(
            gap.reshape(grid.ny, grid.nx),
            (float(x[-1] - x[0]) / (grid.nx - 1), float(y[-1] - y[0]) / (grid.ny - 1)),
            lower=lower,
            upper=upper,
            force=force,
            approach=scene.approach,
            moments_about_axes=(about_x, about_y),
            tolerance=tolerance,
            edge="sharp",
            rolling=rolling_at(velocity_over(lower, upper)),
        )
    # in the words of the scene, whose arguments are others
    scene.check_edge(problem.patches, normal.pressure.reshape(-1))
    problem.time_s["convolutions"] = problem.time_s.get("convolutions", 0.0) + time.perf_counter() - clock
    pressure = np.ascontiguousarray(normal.pressure.reshape(-1))
    products = normal.report.convolutions + normal.report.preconditionings
    padded = 4.0 * problem.n
    return Solution(
        pressure=pressure,
        gap=np.ascontiguousarray(normal.gap.reshape(-1)),
        motion=np.array([-normal.approach, -normal.tilts[1], normal.tilts[0]])[: problem.upper.work.size],
        friction=problem.friction_at(pressure),
        status="solved",
        solver=normal.report.solver,
        iterations=normal.report.iterations,
        residual=normal.report.residual,
        wedging_margin=0.0 if problem.direction.any() else None,
        convolutions=normal.report.convolutions,
        preconditionings=normal.report.preconditionings,
        operations=products * TRANSFORMS * TRANSFORM * padded * float(np.log2(padded)),
    )


def _unreachable(problem: ContactProblem) -> Solution:
    """No solution: the resultant of the load lies outside the grid."""
    zero = np.zeros(problem.n)
    return Solution(
        pressure=zero,
        gap=problem.points.gap,
        motion=np.zeros(problem.upper.work.size),
        friction=problem.friction_at(zero),
        status="unreachable",
        solver="conjugate gradients, FFT",
        iterations=0,
        residual=1.0,
        wedging_margin=None,
    )
