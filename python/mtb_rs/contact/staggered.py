# SPDX-License-Identifier: MIT OR Apache-2.0
"""``method="staggered"``: the thesis' loop around finite elements, for comparison with the direct solution.

It counts the local compliance of the elastic body twice, and needs a factor to converge.
"""

from __future__ import annotations

import time
from dataclasses import replace

import numpy as np

from .. import _mtb_rs
from ..base.check import positive, whole
from ..base.memory import of_matrices, refuse
from ..bodies.sides import Side
from ..geometry.contact_points import ContactPoints
from ..results.result import Displacement, Result
from .problem import ContactProblem, Solution, to_global
from .solve import sided_influence
from .symmetry import mirror_symmetry

#: Times a predicted factor is corrected at most, and how far above the limit it is then taken.
PREDICTIONS, SAFETY = 4, 1.3

#: Iterates combined where a predicted factor converges too slowly.
DEPTH = 5


def staggered(
    problem: ContactProblem,
    half_space: Side,
    *,
    factor: float | None = None,
    max_iterations: int = 20,
    displacement_tolerance: float = 1e-3,
    anderson_depth: int = 0,
) -> tuple[Solution, _mtb_rs.StaggeredOutcome]:
    """Half-space contact and finite elements by turns: thesis 2.3.

    Parameters
    ----------
    problem : ContactProblem
        With the elastic upper body.
    half_space : Side
        The upper body as a half-space, on the same points.
    factor : float
        f_FE: the share 1/f of the finite-element displacement applied each time; None: predicted.
    max_iterations : int
        Thesis: 20.
    displacement_tolerance : float [-]
        Change of the displacement, relative to the largest, at which the loop has converged.
    anderson_depth : int
        Earlier iterates combined to accelerate; 0: none, unless a predicted factor does not converge in
        `max_iterations`: then 5 are.
    """
    factor = None if factor is None else positive("factor", factor)
    max_iterations = whole("max_iterations", max_iterations)
    displacement_tolerance = positive("displacement_tolerance", displacement_tolerance)
    if anderson_depth != 0 or isinstance(anderson_depth, bool):
        anderson_depth = whole("anderson_depth", anderson_depth)
    clock = time.perf_counter()
    symmetry = mirror_symmetry(problem)
    given = problem
    if symmetry is not None:
        problem = symmetry.half
        assert half_space.compliance is not None
        half = half_space.compliance.symmetric_half(symmetry.image.tolist())
        half_space = replace(half_space, compliance=half)
    friction = problem.friction.fixed
    if friction is None:
        raise ValueError("method is 'staggered': friction that depends on pressure is not part of it")
    # the blocks of half-spaces are those of the whole, in whose units a half's own matrices are few
    matrices = 18 if symmetry is None else 12
    refuse(of_matrices(given.n, matrices), f"the staggered loop over {given.n} points", "take larger cells")
    lower = sided_influence(problem.lower.compliance, problem.direction, friction, upper=False)
    upper = sided_influence(half_space.compliance, problem.direction, friction, upper=True)
    structure = sided_influence(problem.upper.compliance, problem.direction, friction, upper=True)
    motions, loading = problem.relative_motions, problem.loading
    opening = motions[:, 2]
    slid = np.einsum("cn,mcn->mn", problem.direction, motions[:, :2])
    balance = problem.area * (opening + friction * slid)

    def attempt(factor: float | None, depth: int = anderson_depth) -> _mtb_rs.StaggeredOutcome:
        return _mtb_rs.solve_staggered(
            np.ascontiguousarray(lower + upper),
            np.ascontiguousarray(structure),
            loading.gap,
            problem.area,
            np.ascontiguousarray(-opening),
            np.ascontiguousarray(-balance),
            loading.work,
            factor,
            max_iterations,
            displacement_tolerance,
            depth,
        )

    out = attempt(factor)
    iterations = out.iterations
    for _ in range(PREDICTIONS if factor is None else 0):
        # the prediction holds for one set in contact; the one it led to may need a larger factor
        limit = out.predicted_limit
        if out.status == "solved" or not out.factor < SAFETY * limit < np.inf:
            break
        out = attempt(SAFETY * limit)
        iterations += out.iterations
    combined = ""
    if factor is None and anderson_depth == 0 and out.status != "solved" and out.predicted_limit < np.inf:
        out = attempt(None, DEPTH)
        iterations += out.iterations
        combined = f", {DEPTH} iterates combined"
    margin = None
    if out.status != "solved":
        wedging = 0.0
        if friction.any():
            wedging = problem.core.wedging_factor(np.ascontiguousarray(problem.direction), friction)
        margin = 1.0 / wedging if 0.0 < wedging < np.inf else None
    problem.time_s["staggered loop"] = time.perf_counter() - clock
    pressure, gap, motion = out.pressure, out.gap, out.motion
    if symmetry is not None:
        pressure, gap = pressure[symmetry.source], gap[symmetry.source]
        motion = symmetry.whole_motion(motion)
        friction = given.friction_at(pressure)
    solution = Solution(
        pressure=np.ascontiguousarray(pressure),
        gap=np.ascontiguousarray(gap),
        motion=motion,
        friction=friction,
        status=out.status,
        solver=f"staggered loop, f_FE = {out.factor:.4g}, diverges below {out.predicted_limit:.4g}{combined}",
        iterations=iterations,
        residual=out.residual,
        wedging_margin=margin,
    )
    return solution, out


def with_half_space(result: Result, half_space: Side, points: ContactPoints) -> Result:
    """The result with what the scheme moves the upper surface as a half-space, besides its elements."""
    assert result.coefficients is not None
    assert half_space.compliance is not None
    load = result.coefficients * np.array([[-1.0], [-1.0], [1.0]])
    moved = to_global(half_space.compliance.displacement(load), points)
    upper, lower = result.displacement
    return replace(result, displacement=Displacement(upper + moved.reshape(upper.shape), lower))
