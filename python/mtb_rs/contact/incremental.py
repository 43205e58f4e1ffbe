# SPDX-License-Identifier: MIT OR Apache-2.0
"""``method="incremental"``: the thesis' load increments, for comparison with the direct solution."""

from __future__ import annotations

import time
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .. import _mtb_rs
from ..base.check import positive
from ..base.errors import ConvergenceError
from ..base.plain import plain
from ..results.result import Displacement, Result
from .problem import ContactProblem, Solution
from .solve import displaced

Array = NDArray[np.float64]


@dataclass(frozen=True)
@plain
class IncrementalOptions:
    """Parameters of the thesis' incremental scheme, its Table 2.1.

    Attributes
    ----------
    estimated_steps : int
        Load increments in which the estimated approach is cut.
    force_tolerance : float [N] or None
        None: 1e-4 of the force.
    distance_tolerance : float [m] or None
        Surfaces closer than this may come into contact, points under pressure and farther apart than this
        have lost theirs. None: twice the first increment.
    max_resolutions : int
        Times one increment is resolved at most; the thesis found about three sufficient.
    max_releases : int
        Times lost contacts are released within one increment at most.
    max_increments : int
        Load increments at most, those to meet the force included.
    """

    estimated_steps: int = 20
    force_tolerance: float | None = None
    distance_tolerance: float | None = None
    max_resolutions: int = 20
    max_releases: int = 20
    max_increments: int = 500

    def __post_init__(self) -> None:
        for name in ("estimated_steps", "max_resolutions", "max_releases", "max_increments"):
            value = getattr(self, name)
            if isinstance(value, bool) or not isinstance(value, (int, np.integer)) or value < 1:
                raise ValueError(f"{name} is {value!r}: a whole number from 1 on is needed")
        for name, unit in (("force_tolerance", "N"), ("distance_tolerance", "m")):
            if getattr(self, name) is not None:
                object.__setattr__(self, name, positive(name, getattr(self, name), unit))


@dataclass(frozen=True)
@plain
class IncrementalFields:
    """What the scheme accumulates on its way, where a direct solution computes it from the pressure.

    `counts` go into the summary of the result: increments, complementarity problems, active sets,
    releases of lost contacts, difference of the pressures of the two bodies over the largest, vertical
    force [N], and the approach [m] and force [N] after each increment.
    """

    traction: Array
    displacement: Displacement
    approach: float
    counts: dict[str, Any]

    def put_into(self, result: Result) -> Result:
        """`result` with these fields in place of its own."""
        shape = result.pressure.shape
        displacement = Displacement(*(u.reshape(3, *shape) for u in self.displacement))
        summary = {**result.summary, "incremental": self.counts}
        traction = self.traction.reshape(3, *shape)
        return replace(
            result, traction=traction, displacement=displacement, approach=self.approach, summary=summary
        )


def solve_incremental(
    problem: ContactProblem, direction: tuple[float, float] | None, options: IncrementalOptions
) -> tuple[Solution, IncrementalFields]:
    """Lowers the upper half-space in increments until the force is met.

    All poles are lowered together, without tilt, as in the thesis.

    Raises
    ------
    ValueError
        If the scene is one that the scheme cannot state.
    """
    clock = time.perf_counter()
    motions = problem.upper.motions
    if problem.model != "half-space":
        raise ValueError(f'method is "incremental": it takes half-spaces, this model is {problem.model!r}')
    if problem.approach is not None:
        raise ValueError('method is "incremental": it presses with a force, an approach is given')
    friction = problem.friction.fixed
    if friction is None:
        raise ValueError('method is "incremental": it takes a friction coefficient that does not vary')
    if problem.upper.modes[:, 3:6].any():
        raise ValueError('method is "incremental": tilts are locked in it, moments are given')
    shares = problem.work[0]
    force = -float(shares.sum())
    if shares.size and float(np.ptp(shares)) > 1e-9 * force:
        raise ValueError(
            f'method is "incremental": it lowers all poles together, their loads are {(-shares).tolist()} N'
        )
    points = problem.points
    asked = dict(vars(options))
    if options.force_tolerance is None:
        asked["force_tolerance"] = 1e-4 * force
    out = _mtb_rs.solve_incremental(
        problem.lower.compliance,
        problem.upper.compliance,
        np.ascontiguousarray(points.points),
        np.ascontiguousarray(points.points + problem.loading.gap * points.normal),
        [(p.nx, p.ny) for p in problem.patches],
        np.ascontiguousarray(problem.area),
        np.ascontiguousarray(friction),
        (0.0, 0.0, 0.0) if direction is None else (direction[0], direction[1], 0.0),
        force,
        _mtb_rs.IncrementalOptions(**asked),
    )
    problem.time_s["increments"] = time.perf_counter() - clock
    solution = Solution(
        pressure=out.pressure,
        gap=out.gap,
        motion=np.full(len(motions), -out.approach),
        friction=friction,
        status=out.status,
        solver="load increments, active set, dense factorisation",
        iterations=out.resolutions,
        residual=out.residual,
        wedging_margin=None,
    )
    names = ("increments", "problems", "active_sets", "releases", "imbalance", "force", "history")
    # the increments start from what the pull has moved
    pulled = displaced(problem, "lower", np.zeros((3, problem.n)), np.zeros(0))
    fields = IncrementalFields(
        traction=out.traction,
        displacement=Displacement(upper=out.upper_displacement, lower=out.lower_displacement + pulled),
        approach=out.approach,
        counts={name: getattr(out, name) for name in names},
    )
    return solution, fields


def finish_incremental(fields: IncrementalFields, finish: Any) -> Result:
    """Runs `finish` and puts the accumulated fields into what it returns or raises."""
    try:
        return fields.put_into(finish())
    except ConvergenceError as error:
        raise type(error)(str(error), fields.put_into(error.result)) from None
