# SPDX-License-Identifier: MIT OR Apache-2.0
"""Speed against accuracy: every model and method, timed and judged at several resolutions."""

from __future__ import annotations

import csv
import io
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING, ClassVar

import numpy as np

from ..base.check import choice
from ..base.files import read_bytes
from ..base.owning import owning
from ..base.plain import plain
from ..base.stored import stored
from ..base.told import Row
from ..base.words import Quantity
from .doors import pictures, png
from .report import QUANTITIES
from .result import percent
from .study import Study

if TYPE_CHECKING:
    from matplotlib.figure import Figure as Drawing  # noqa: TID251 (only for type checkers)

#: Errors below this are none.
ROUNDING = 1e-12


#: What the table of a chart begins with.
HEADING = b"series,spacing_m,unknowns,"


@stored
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
        Processor time of each repeat, all threads together. On a busy machine it varies less than elapsed
        time.
    clock : tuple of float [s]
        Elapsed time of each repeat.
    errors : Mapping of a quantity to its relative error [-]
        Errors against the reference; empty for a solve that failed.
    failure : str
        Reason of the failure, or "" if there was none.
    is_reference : bool
    note : str
        The tolerance that was asked for, if the series chooses its spacing.
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


@stored
@dataclass(frozen=True)
@plain
class Figure:
    """A time from another source: a line, or a mark if its error is known too.

    Attributes
    ----------
    label : str
    time : float [s]
    error : float or None [-]
    """

    label: str
    time: float
    error: float | None = None


@stored
@owning
@dataclass(frozen=True)
@plain
class Chart(Study):
    """Points of time against error, and the reference of the errors.

    Attributes
    ----------
    title : str
    points : tuple of ChartPoint
    reference : str
        The reference, in words.
    reference_error : float or None [-]
        Estimated error of the reference itself; 0 for a closed form. Smaller errors are not resolved.
    quantity : "pressure", "force" or "displacement"
        Quantity whose error is drawn; the CSV holds all of them.
    figures : tuple of Figure
        Times from other sources.
    remark : str
        One sentence on the effects that the errors do not contain.
    """

    usual_name: ClassVar[str] = "chart"
    called: ClassVar[str] = "chart"
    endings: ClassVar[tuple[str, ...]] = ("png", "html", "csv")

    title: str
    points: tuple[ChartPoint, ...]
    reference: str
    reference_error: float | None = None
    quantity: Quantity = "pressure"
    figures: tuple[Figure, ...] = ()
    remark: str = ""

    def told(self) -> list[Row]:
        """The efficient points in words: what a notebook shows beside the picture."""
        own = f", its own error about {percent(self.reference_error)}" if self.reference_error else ""
        rows = [("against", f"{self.reference}{own}")]
        for point in self.efficient():
            error = percent(point.errors[self.quantity])
            rows.append((point.series, f"{point.unknowns} points: {point.time:.3g} s, {error}"))
        return rows

    def _repr_png_(self) -> bytes | None:
        """Its picture, for notebooks; none where no point has an error to show."""
        with pictures().own_figures():
            return png(self.plot()) if self.drawn() else None

    def check_drawable(self) -> None:
        """ValueError if no point has an error to show."""
        if not self.drawn():
            raise ValueError(f"the chart has no point with an error in {self.quantity}: nothing to draw")

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
        """Points that no other point beats in both time and error, fastest first."""
        best, kept = np.inf, []
        for point in sorted(self.drawn(), key=lambda p: (p.time, p.errors[self.quantity])):
            if point.errors[self.quantity] < best:
                best = point.errors[self.quantity]
                kept.append(point)
        return kept

    def growth(self, series: str) -> float | None:
        """Exponent of the processor time over the unknowns, from the four finest points of a series.

        None if there are too few points, or if the time falls because the solver changed along the series.
        """
        points = sorted((p for p in self.points if p.series == series), key=lambda p: p.unknowns)
        points = [p for p in points if not p.failure and not p.is_reference and p.time > 2e-3][-4:]
        rising = all(a.time < b.time for a, b in pairwise(points))
        if len(points) < 3 or not rising or points[-1].unknowns < 3 * points[0].unknowns:
            return None
        logs = np.log([[p.unknowns, p.time] for p in points])
        return float(np.polyfit(logs[:, 0], logs[:, 1], 1)[0])

    def table(self) -> list[dict[str, str | int | float]]:
        """One row for each point, as in the CSV."""
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

    def plot(self, quantity: Quantity | None = None) -> Drawing:
        """Draws processor time against the error of a quantity; None: that of the chart."""
        shown = self if quantity is None else replace(self, quantity=choice("quantity", quantity, Quantity))
        figure: Drawing = pictures().drawing_of_chart(shown)
        return figure

    def exports(self) -> tuple[dict[str, bytes], list[str]]:
        """A picture, an interactive page, and the points as a table."""
        picture = io.BytesIO()
        self.plot().savefig(picture, dpi=150, format="png")
        page = pictures().page_of_chart(self).encode()
        return {"png": picture.getvalue(), "html": page, "csv": self.csv().encode()}, []

    @classmethod
    def wrote(cls, folder: Path, name: str) -> bool:
        """Whether the table is that of a chart: version 0.1.0 wrote no record."""
        try:
            return read_bytes(folder / f"{name}.csv").startswith(HEADING)
        except ValueError:
            return False
