# SPDX-License-Identifier: MIT OR Apache-2.0
"""``method="direct"``: which model, which spacing, the solution, and how good it is."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from .auto import (
    AIM,
    EFFECTS,
    MODEL_SHARE,
    SHARE_OF_FREE_SPACING,
    Choice,
    Errors,
    Ladder,
    Level,
    estimated,
    resolved,
    rungs,
)
from .bodies import HalfSpace, Rigid
from .estimate import coarsened
from .normal import solve_normal
from .solve import ContactProblem, Solution, solve_direct

if TYPE_CHECKING:
    from .result import Result
    from .scene import Scene

Spacing = tuple[float, float]

#: Points up to which a dense factorisation is faster than convolutions.
DENSE_POINTS = 2000
#: Relative residual of the convolution solver; the answer is then that of the dense one to eight digits.
CONVOLUTION_TOLERANCE = 1e-9
#: Floating-point operations of a Fourier transform of n points over n log2 n; transforms of a convolution,
#: on twice as many points each way.
TRANSFORM, TRANSFORMS = 5.0, 2


def solve(scene: Scene, model: str, tolerance: float, quantity: str) -> Result:
    """Solves a scene directly; see :meth:`mtb_rs.Scene.solve`."""
    assert scene.layout is not None
    started = time.perf_counter()
    layout = scene.layout
    free = scene.spacing is None
    start = layout.start if scene.spacing is None else scene._pair
    assert start is not None
    fixed = scene.with_(spacing=start) if free else scene
    chosen = choose(fixed, tolerance, quantity, free=free) if model == "auto" else given(fixed, model)
    besides = chosen.operations
    # the same on wider cells, the least wide first
    copies = [] if chosen.coarse is None else [chosen.coarse]

    def at(spacing: Spacing, before: Sequence[Level]) -> tuple[Level, Errors | None]:
        nonlocal besides
        level = level_at(fixed, chosen.model, spacing, coupled=chosen.coupled)
        wider = [*before, *copies]
        # to end the choice of a spacing at once takes two of them
        while len(wider) < (2 if free else 1) and level.is_solved and (free or chosen.errors):
            last = wider[-1] if wider else level
            # what is cheap on fine grids, by convolutions, is not much cheaper on half as fine ones
            times = 3 if level.solution.convolutions > 0.0 else 2
            width = coarsened(last.spacing, layout.sheet(last.spacing).patches, times)
            if width is None:
                break
            try:
                copies.append(level_at(fixed, chosen.model, width, coupled=chosen.coupled, like=level))
            except ValueError:  # such cells do not fit the scene: the contact reaches the edge of their grid
                break
            wider.append(copies[-1])
            besides += copies[-1].operations
        return level, estimated(level, wider, chosen, skip_border=layout.is_body_edge)

    spent = 0.0
    if free:
        level, errors, spent = resolved(at, start, tolerance, quantity)
        fixed = scene.with_(spacing=level.spacing)
    else:
        level, errors = at(start, [])
        # a fuller model helps where the tolerance is missed by what is left out, not by the cells
        while errors is not None and chosen.fuller is not None and errors.total(quantity) > tolerance:
            if errors.cells[quantity] > AIM * tolerance:
                break
            besides += level.operations
            chosen = chosen.fuller()
            copies = [] if chosen.coarse is None else [chosen.coarse]
            level, errors = at(start, [])
    clock = time.perf_counter()
    problem = level.problem
    if chosen.time_s:
        problem.time_s["choice of the model"] = chosen.time_s
    result = fixed._finish(
        problem,
        level.solution,
        "direct",
        omitted=chosen.omitted,
        errors=errors.totals() if errors is not None and chosen.errors else None,
        aim=(quantity, tolerance),
        choosing=besides + spent,
        spacing=level.cell,
    )
    fixed._check_reach(problem, result)
    stages = sum(problem.time_s.values()) + time.perf_counter() - clock
    problem.time_s["fields"] = time.perf_counter() - clock
    problem.time_s["estimate"] = max(time.perf_counter() - started - stages, 0.0)
    return replace(result, report=replace(result.report, time_s=dict(problem.time_s)))


def choose(scene: Scene, tolerance: float, quantity: str, *, free: bool = False) -> Choice:
    """The cheapest model that leaves out less than the tolerance, by coarse copies of the scene.

    With a `free` spacing a larger share of the tolerance is left to the cells.
    """
    assert scene.layout is not None
    clock = time.perf_counter()
    models = ["half-space"]
    if scene.magnetic_pressure is not None:
        models = rungs(scene.layout, *(isinstance(body, HalfSpace) for body in (scene.upper, scene.lower)))
    spacing = scene._pair
    sheet = scene.layout.sheet(spacing)
    large = len(models) == 1 and sheet.area.size > DENSE_POINTS
    ladder = [(model, True) for model in models]
    if large and is_coupled(scene, scene.problem(models[0])):
        ladder.insert(0, (models[0], False))
    if len(ladder) == 1:
        return Choice(models[0])
    wider = coarsened(spacing, sheet.patches) or spacing
    try:
        solved = [level_at(scene, m, wider, coupled=coupled, is_rough=True) for m, coupled in ladder]
    except ValueError:
        # bad input is for the fine problem to name
        return Choice(models[-1], time_s=time.perf_counter() - clock)
    skip, used = scene.layout.is_body_edge, time.perf_counter() - clock
    found = Ladder(ladder, solved, quantity, skip, wider != spacing, used)
    return found.cheapest((SHARE_OF_FREE_SPACING if free else MODEL_SHARE) * tolerance)


def given(scene: Scene, model: str) -> Choice:
    """A model the user has chosen: what it leaves out is named, its size would cost more than the solve."""
    assert scene.layout is not None
    if scene.magnetic_pressure is None:
        return Choice(model)
    models = rungs(scene.layout, *(isinstance(body, HalfSpace) for body in (scene.upper, scene.lower)))
    omitted = {EFFECTS[m]: "not estimated; model='auto' does" for m in models[models.index(model) + 1 :]}
    return Choice(model, omitted, {}) if omitted else Choice(model)


def level_at(
    scene: Scene,
    model: str,
    spacing: Spacing,
    *,
    coupled: bool = True,
    is_rough: bool = False,
    like: Level | None = None,
) -> Level:
    """A model solved at a spacing.

    Parameters
    ----------
    coupled : bool
        Whether friction opens the gap between half-spaces.
    is_rough : bool
        Only an estimate is made of it.
    like : Level
        Solved roughly, by the solver of this one.
    """
    clock = time.perf_counter()
    problem = scene.problem(model, spacing)
    problem.time_s["geometry and bodies"] = time.perf_counter() - clock - sum(problem.time_s.values())
    is_rough = is_rough or like is not None
    needs_dense = coupled and is_coupled(scene, problem)
    is_large = problem.n > DENSE_POINTS if like is None else like.solution.convolutions > 0.0
    if is_large and _is_plain(scene, problem) and not needs_dense:
        # a rough one need not be better than its cells
        tolerance = None if is_rough else CONVOLUTION_TOLERANCE
        return Level(problem, _by_convolution(scene, problem, tolerance), spacing)
    if not coupled:
        smooth = replace(problem, direction=np.zeros_like(problem.direction))
        solution = solve_direct(smooth, with_margin=False)
        return Level(problem, replace(solution, friction=problem.friction_at(solution.pressure)), spacing)
    return Level(problem, solve_direct(problem, with_margin=not is_rough), spacing)


def is_coupled(scene: Scene, problem: ContactProblem) -> bool:
    """Whether friction changes the gap between two half-spaces: something rubs, and materials are unlike."""
    if not problem.direction.any() or (
        isinstance(problem.friction, np.ndarray) and not problem.friction.any()
    ):
        return False
    mixed = [
        (1.0 - 2.0 * body.material.poisson_ratio) / body.material.shear_modulus
        if isinstance(body, HalfSpace)
        else 0.0
        for body in (scene.upper, scene.lower)
    ]
    return abs(mixed[0] - mixed[1]) > 1e-12 * max(map(abs, mixed))


def _is_plain(scene: Scene, problem: ContactProblem) -> bool:
    """Whether this is one flat grid of cells between half-spaces without tilt."""
    flat = len(problem.patches) == 1 and bool((problem.points.normal[2] == 1.0).all())
    return problem.model == "half-space" and flat and scene.moments is None


def _by_convolution(scene: Scene, problem: ContactProblem, tolerance: float | None) -> Solution:
    clock = time.perf_counter()
    assert scene.layout is not None
    assert isinstance(scene.lower, (HalfSpace, Rigid))
    assert isinstance(scene.upper, (HalfSpace, Rigid))
    grid, x, y = problem.axes()[0]
    normal = solve_normal(
        problem.points.gap.reshape(grid.ny, grid.nx),
        (float(x[-1] - x[0]) / (grid.nx - 1), float(y[-1] - y[0]) / (grid.ny - 1)),
        lower=scene.lower,
        upper=scene.upper,
        force=None if scene.approach is not None else -float(problem.upper.work.sum()),
        approach=scene.approach,
        tolerance=tolerance,
        edge="sharp" if scene.layout.is_body_edge else "error",
    )
    problem.time_s["convolutions"] = time.perf_counter() - clock
    pressure = np.ascontiguousarray(normal.pressure.reshape(-1))
    products = normal.report.convolutions + normal.report.preconditionings
    padded = 4.0 * problem.n
    return Solution(
        pressure=pressure,
        gap=np.ascontiguousarray(normal.gap.reshape(-1)),
        motion=np.full(problem.upper.work.size, -normal.approach),
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
