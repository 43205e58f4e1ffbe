# SPDX-License-Identifier: MIT OR Apache-2.0
"""Times and errors of ways to solve a scene, from coarse to fine."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import TypeVar

import numpy as np

from ..base.errors import ConvergenceError
from ..base.plain import plain
from ..results.chart import ChartPoint

T = TypeVar("T")


@dataclass(frozen=True)
@plain
class Run:
    """One solve, as far as a chart needs it.

    Attributes
    ----------
    unknowns : int
    errors : Mapping of a quantity to its relative error [-]
    iterations : int
    convolutions : float
    solver : str
    spacing : float or None [m]
        Where the solve itself chose it.
    note : str
        What was asked for, where not a spacing.
    """

    unknowns: int
    errors: Mapping[str, float]
    iterations: int = 0
    convolutions: float = 0.0
    solver: str = ""
    spacing: float | None = None
    note: str = ""


@dataclass(frozen=True)
@plain
class Candidate:
    """One series: how to solve at each spacing.

    Attributes
    ----------
    name : str
    solve : callable
        Of a spacing (dx, dy) [m]; returns what judges the solution, which is not timed.
    prepare : callable or None
        Run before each timed solve, untimed.
    spacings : sequence of (dx, dy) [m] or None
        Its own, coarse to fine, instead of those of all.
    tolerances : sequence of float or None
        For a series that chooses its spacing: what it is asked for, large to small, and what `solve` and
        `prepare` are called with, twice, instead of a spacing.
    """

    name: str
    solve: Callable[[tuple[float, float]], Callable[[], Run]]
    prepare: Callable[[tuple[float, float]], object] | None = None
    spacings: Sequence[tuple[float, float]] | None = None
    tolerances: Sequence[float] | None = None

    def steps(self, spacings: Sequence[tuple[float, float]]) -> Sequence[tuple[float, float]]:
        """What it is solved at, one after the other."""
        if self.tolerances is not None:
            return [(t, t) for t in self.tolerances]
        return spacings if self.spacings is None else self.spacings

    def words(self, step: tuple[float, float]) -> str:
        """A step, for the progress."""
        return f"{self.name}, {_mean(step):.3g} {'m' if self.tolerances is None else 'tolerance'}"


def clocked(call: Callable[[], T]) -> tuple[T, float, float]:
    """What `call` returns, its processor time and its elapsed time [s]."""
    started, used = time.perf_counter(), time.process_time()
    found = call()
    return found, max(time.process_time() - used, 1e-6), time.perf_counter() - started


def measure(
    candidates: Sequence[Candidate],
    spacings: Sequence[tuple[float, float]],
    *,
    budget: float,
    repeats: int,
    progress: Callable[[float, str], None],
) -> tuple[ChartPoint, ...]:
    """Runs candidates from coarse to fine while the budget lasts, then repeats what was cheap.

    Parameters
    ----------
    spacings : sequence of (dx, dy) [m]
        Coarse to fine.
    budget : float [s]
        Elapsed time; one solve that was thought to be shorter may exceed it.
    repeats : int
        Of each point, at most.
    progress : callable
        Told the share that is done and what is being done.
    """
    started = time.perf_counter()
    points: list[ChartPoint] = []
    calls: list[tuple[Candidate, tuple[float, float]]] = []
    for k, candidate in enumerate(candidates):
        # two thirds for first runs, shared alike among what is left
        left = 2.0 / 3.0 * budget - (time.perf_counter() - started)
        end = time.perf_counter() + left / (len(candidates) - k)
        last = 0.0  # processor seconds
        for spacing in candidate.steps(spacings):
            load = sum(p.clock[0] for p in points) / max(sum(p.times[0] for p in points), 1e-3)
            if last and time.perf_counter() + 5.0 * last * max(1.0, load) > end:
                break
            spent = time.perf_counter() - started
            progress(min(spent / budget, 1.0), candidate.words(spacing))
            points.append(_first(candidate, spacing))
            last = points[-1].times[0]
            if not points[-1].failure:
                calls.append((candidate, spacing))
            elif candidate.tolerances is not None:
                # a smaller one takes more
                break
    repeatable = [i for i, p in enumerate(points) if not p.failure]
    for _ in range(1, repeats):
        for i, (candidate, spacing) in zip(repeatable, calls, strict=True):
            spent = time.perf_counter() - started
            if spent + points[i].clock[0] > budget:
                continue
            progress(spent / budget, f"again: {candidate.words(spacing)}")
            if candidate.prepare is not None:
                candidate.prepare(spacing)
            try:
                _, seconds, elapsed = clocked(lambda c=candidate, s=spacing: c.solve(s))  # type: ignore[misc]
            except ValueError:
                if candidate.tolerances is None:
                    raise
                # by now the time that is left is too short for this tolerance
                continue
            points[i] = points[i].again(seconds, elapsed)
    progress(1.0, "done")
    return tuple(points)


def _first(candidate: Candidate, spacing: tuple[float, float]) -> ChartPoint:
    started, used = time.perf_counter(), time.process_time()
    try:
        if candidate.prepare is not None:
            candidate.prepare(spacing)
        judge, seconds, elapsed = clocked(lambda: candidate.solve(spacing))
        run = judge()
    except (ConvergenceError, ValueError) as error:
        used, elapsed = time.process_time() - used, time.perf_counter() - started
        return ChartPoint(candidate.name, _mean(spacing), 0, (used,), (elapsed,), failure=str(error))
    return ChartPoint(
        candidate.name,
        _mean(spacing) if run.spacing is None else run.spacing,
        run.unknowns,
        (seconds,),
        (elapsed,),
        run.errors,
        run.iterations,
        run.convolutions,
        run.solver,
        note=run.note,
    )


def _mean(spacing: tuple[float, float]) -> float:
    return float(np.sqrt(spacing[0] * spacing[1]))


def silent(share: float, doing: str) -> None:
    """Progress that nobody watches."""


def halvings(spacing: tuple[float, float], coarsest: float = 4.0) -> Iterator[tuple[float, float]]:
    """Spacings from `coarsest` times the given one, each finer by the root of two, without end."""
    factor = coarsest
    while True:
        yield spacing[0] * factor, spacing[1] * factor
        factor /= np.sqrt(2.0)
