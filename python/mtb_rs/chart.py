# SPDX-License-Identifier: MIT OR Apache-2.0
"""Speed against accuracy: every model and method, timed and judged at several resolutions."""

from __future__ import annotations

import csv
import io
import os
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import pairwise
from pathlib import Path
from typing import TypeVar, get_args

import numpy as np

from .errors import ConvergenceError
from .files import check_folder, drafted, read_bytes
from .owning import owning
from .plain import plain
from .words import Quantity

T = TypeVar("T")

#: Errors below this are none.
ROUNDING = 1e-12
#: What an error can be measured in.
QUANTITIES: tuple[Quantity, ...] = get_args(Quantity)
#: Files of a chart, and what its table begins with.
KINDS = ("png", "html", "csv")
HEADING = b"series,spacing_m,unknowns,"


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


@owning
@dataclass(frozen=True)
@plain
class ChartPoint:
    """One way to solve the scene.

    Attributes
    ----------
    series : str
        Model and method.
    spacing : float [m]
    unknowns : int
    times : tuple of float [s]
        Processor time of each repeat, all threads together; on a busy machine it is steadier than the clock.
    clock : tuple of float [s]
        Elapsed time of each repeat.
    errors : Mapping of a quantity to its relative error [-]
        Against the reference; empty for a solve that failed.
    failure : str
        Why it failed, "" if it did not.
    is_reference : bool
    note : str
        What was asked for, where not a spacing.
    """

    series: str
    spacing: float
    unknowns: int
    times: tuple[float, ...]
    clock: tuple[float, ...]
    errors: Mapping[str, float] = field(default_factory=dict)
    iterations: int = 0
    convolutions: float = 0.0
    solver: str = ""
    failure: str = ""
    is_reference: bool = False
    note: str = ""

    @property
    def time(self) -> float:
        """Median processor time [s]."""
        return float(np.median(self.times))

    def again(self, seconds: float, elapsed: float) -> ChartPoint:
        """The same point with one more repeat."""
        return replace(self, times=(*self.times, seconds), clock=(*self.clock, elapsed))


@dataclass(frozen=True)
@plain
class Figure:
    """A time known from elsewhere: a line, or a mark where its error is known too.

    Attributes
    ----------
    label : str
    time : float [s]
    error : float or None [-]
    """

    label: str
    time: float
    error: float | None = None


@owning
@dataclass(frozen=True)
@plain
class Chart:
    """Points of time against error, and what the error is measured against.

    Attributes
    ----------
    title : str
    points : tuple of ChartPoint
    reference : str
        In words.
    reference_error : float or None [-]
        Of the reference itself, estimated; 0 for a closed form. Smaller errors are not resolved.
    quantity : "pressure", "force" or "displacement"
        Which error is drawn; the CSV holds all.
    figures : tuple of Figure
        Known from elsewhere.
    """

    title: str
    points: tuple[ChartPoint, ...]
    reference: str
    reference_error: float | None = None
    quantity: Quantity = "pressure"
    figures: tuple[Figure, ...] = ()

    @property
    def series(self) -> tuple[str, ...]:
        """Names of the series, in the order of the points."""
        return tuple(dict.fromkeys(p.series for p in self.points))

    def drawn(self, series: str | None = None) -> list[ChartPoint]:
        """Points with an error that a logarithmic axis can show, those of one series if it is given."""
        return [
            p
            for p in self.points
            if (series is None or p.series == series)
            and not p.is_reference
            and p.errors.get(self.quantity, 0.0) > ROUNDING
        ]

    def efficient(self) -> list[ChartPoint]:
        """Points that no other one beats in both time and error, fastest first."""
        best, kept = np.inf, []
        for point in sorted(self.drawn(), key=lambda p: (p.time, p.errors[self.quantity])):
            if point.errors[self.quantity] < best:
                best = point.errors[self.quantity]
                kept.append(point)
        return kept

    def growth(self, series: str) -> float | None:
        """Exponent of the processor time over the unknowns, from the four finest points of a series.

        None where there are too few, or where the time falls: the solver then changed on the way.
        """
        points = sorted((p for p in self.points if p.series == series), key=lambda p: p.unknowns)
        points = [p for p in points if not p.failure and not p.is_reference and p.time > 2e-3][-4:]
        rising = all(a.time < b.time for a, b in pairwise(points))
        if len(points) < 3 or not rising or points[-1].unknowns < 3 * points[0].unknowns:
            return None
        logs = np.log([[p.unknowns, p.time] for p in points])
        return float(np.polyfit(logs[:, 0], logs[:, 1], 1)[0])

    def table(self) -> list[dict[str, str | int | float]]:
        """One row a point, as the CSV has them."""
        efficient = {id(p) for p in self.efficient()}
        return [
            {
                "series": p.series,
                "spacing_m": float(f"{p.spacing:.6g}"),
                "unknowns": p.unknowns,
                "processor_s": float(f"{p.time:.4g}"),
                "clock_s": float(f"{np.median(p.clock):.4g}"),
                "repeats": len(p.times),
                **{
                    f"{name}_error": float(f"{p.errors[name]:.4g}") if name in p.errors else ""
                    for name in QUANTITIES
                },
                "iterations": p.iterations,
                "convolutions": round(p.convolutions, 1),
                "efficient": int(id(p) in efficient),
                "solver": p.solver,
                "note": "reference" if p.is_reference else p.failure or p.note,
            }
            for p in self.points
        ]

    def csv(self) -> str:
        """The points as CSV, sources' figures last."""
        rows = self.table()
        out = io.StringIO()
        writer = csv.DictWriter(out, fieldnames=list(rows[0]), lineterminator="\n")
        writer.writeheader()
        writer.writerows(rows)
        for known in self.figures:
            error = "" if known.error is None else known.error
            writer.writerow(
                {
                    "series": known.label,
                    "clock_s": known.time,
                    f"{self.quantity}_error": error,
                    "note": "source",
                }
            )
        return out.getvalue()

    def save(self, directory: str | Path, name: str = "chart") -> list[Path]:
        """Writes the chart as PNG, as a page to hover over (HTML), and as CSV.

        Raises
        ------
        ValueError
            If no point has an error to show, or there are files of these names that are no chart's.
        OSError
            If nothing can be written there.
        """
        from .chart_page import page
        from .chart_plot import draw

        directory = check_saveable(directory, name)
        files = [directory / f"{name}.{kind}" for kind in KINDS]
        picture = io.BytesIO()
        draw(self).savefig(picture, dpi=150, format="png")
        contents = [picture.getvalue(), page(self).encode(), self.csv().encode()]
        with drafted(directory) as draft:
            for path, content in zip(files, contents, strict=True):
                draft.write(path.name, content)
            for path in files:
                draft.move(path.name)
        return files


def check_saveable(directory: str | Path, name: str = "chart") -> Path:
    """The directory that a chart is to be saved into; nothing is left there.

    Raises
    ------
    ValueError, OSError
        As :meth:`Chart.save`.
    """
    folder = check_folder(directory)
    present = [folder / f"{name}.{kind}" for kind in KINDS if os.path.lexists(folder / f"{name}.{kind}")]
    if present and not _is_of_chart(folder / f"{name}.csv"):
        raise ValueError(
            f"{present[0]} is there, and {name}.csv is no table of an earlier chart: it would be lost; move "
            "it, or save into another directory"
        )
    return folder


def _is_of_chart(path: Path) -> bool:
    try:
        return read_bytes(path).startswith(HEADING)
    except ValueError:
        return False


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
    repeatable = [i for i, p in enumerate(points) if not p.failure]
    for _ in range(1, repeats):
        for i, (candidate, spacing) in zip(repeatable, calls, strict=True):
            spent = time.perf_counter() - started
            if spent + points[i].clock[0] > budget:
                continue
            progress(spent / budget, f"again: {candidate.words(spacing)}")
            if candidate.prepare is not None:
                candidate.prepare(spacing)
            _, seconds, elapsed = clocked(lambda c=candidate, s=spacing: c.solve(s))  # type: ignore[misc]
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
