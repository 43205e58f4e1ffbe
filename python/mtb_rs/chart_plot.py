# SPDX-License-Identifier: MIT OR Apache-2.0
"""The chart as a picture (matplotlib)."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

from .chart import Chart
from .plot import INK, LINE_COLOURS

#: Told apart without colour as well.
MARKERS = "osD^vP*Xh<"


def draw(chart: Chart) -> Figure:
    """Processor time against error, both logarithmic; efficient points joined.

    Raises
    ------
    ValueError
        If no point has an error to show.
    """
    if not chart.drawn():
        raise ValueError(f"the chart has no point with an error in {chart.quantity}: nothing to draw")
    figure = Figure(figsize=(8.4, 5.4), layout="constrained")
    FigureCanvasAgg(figure)
    axes = figure.add_subplot()
    efficient = chart.efficient()
    axes.plot(
        [p.time for p in efficient],
        [100.0 * p.errors[chart.quantity] for p in efficient],
        color="0.72",
        lw=6,
        solid_capstyle="round",
        solid_joinstyle="round",
        zorder=1,
        label="efficient",
    )
    for k, series in enumerate(s for s in chart.series if chart.drawn(s)):
        points = sorted(chart.drawn(series), key=lambda p: p.unknowns)
        growth = chart.growth(series)
        axes.plot(
            [p.time for p in points],
            [100.0 * p.errors[chart.quantity] for p in points],
            MARKERS[k % len(MARKERS)] + "-",
            color=LINE_COLOURS[k % len(LINE_COLOURS)],
            ms=6.5,
            lw=0.9,
            mec="white",
            mew=0.6,
            label=series + ("" if growth is None else f"   time ~ n$^{{{growth:.1f}}}$"),
            zorder=3,
        )
    counts = [(p.time, p.errors[chart.quantity], f"{p.unknowns}") for p in efficient]
    for time, error, label in _together(counts):
        axes.annotate(
            label,
            (time, 100.0 * error),
            xytext=(5, 5),
            textcoords="offset points",
            fontsize=7,
            color="0.35",
        )
    asked = [
        (p.time, p.errors[chart.quantity], p.note.split(",")[0].removeprefix("tolerance "))
        for p in chart.drawn()
        if p.note
    ]
    for time, error, label in _together(asked):
        axes.annotate(
            label,
            (time, 100.0 * error),
            xytext=(-5, -10),
            textcoords="offset points",
            ha="right",
            fontsize=7,
            fontweight="bold",
            color="0.2",
        )
    axes.set_xscale("log")
    axes.set_yscale("log")
    _limits(chart, axes)
    span = [p.time for p in chart.drawn()] + [f.time for f in chart.figures]
    middle = np.sqrt(min(span) * max(span))
    for known in chart.figures:
        if known.error is None:
            axes.axvline(known.time, color="0.55", lw=0.9, ls=(0, (4, 3)), zorder=0)
            place = _end(chart, axes, known.time)
            # between two lines close together there is no room
            right = any(f.error is None and 0.0 < np.log10(known.time / f.time) < 0.2 for f in chart.figures)
            axes.annotate(
                known.label,
                (known.time, place),
                xycoords=("data", "axes fraction"),
                xytext=(3 if right else -3, 0),
                textcoords="offset points",
                rotation=90,
                ha="left" if right else "right",
                va="top" if place > 0.5 else "bottom",
                fontsize=7,
                color="0.35",
            )
        else:
            axes.plot(known.time, 100.0 * known.error, "*", ms=13, color=INK, zorder=4)
            axes.annotate(
                known.label,
                (known.time, 100.0 * known.error),
                xytext=(9, -3) if known.time < middle else (-9, -3),
                textcoords="offset points",
                ha="left" if known.time < middle else "right",
                fontsize=7.5,
                color=INK,
                # lines pass behind it
                bbox={"facecolor": "white", "edgecolor": "none", "pad": 0.8},
                zorder=2,
            )
    if chart.reference_error:
        axes.axhspan(axes.get_ylim()[0], 100.0 * chart.reference_error, color="0.93", zorder=0)
        axes.annotate(
            "error of the reference",
            (0.01, 100.0 * chart.reference_error),
            xycoords=("axes fraction", "data"),
            xytext=(0, -3),
            textcoords="offset points",
            va="top",
            fontsize=7,
            color="0.35",
        )
    plain = FuncFormatter(lambda v, _: f"{v:g}")
    for axis, (low, high) in ((axes.xaxis, axes.get_xlim()), (axes.yaxis, axes.get_ylim())):
        axis.set_major_locator(LogLocator(subs=(1.0,) if high > 50.0 * low else (1.0, 2.0, 5.0), numticks=40))
        axis.set_minor_locator(LogLocator(subs=tuple(range(2, 10)), numticks=40))
        axis.set_major_formatter(plain)
        axis.set_minor_formatter(NullFormatter())
    axes.grid(which="major", color="0.87", lw=0.7)
    axes.set_axisbelow(True)
    axes.spines[["top", "right"]].set_visible(False)
    axes.set_xlabel("processor time, median [s]")
    axes.set_ylabel(f"error of the {chart.quantity} [%]")
    axes.set_title(chart.title, loc="left", fontsize=12, fontweight="bold", color=INK)
    axes.set_title(f"against: {chart.reference}", loc="right", fontsize=8, color="0.35")
    axes.legend(fontsize=7.5, frameon=False, loc="upper left", bbox_to_anchor=(1.0, 1.0))
    return figure


def _together(labels: Sequence[tuple[float, float, str]]) -> list[tuple[float, float, str]]:
    """Labels at (time, error), those that would cover one another as one at the first place."""
    found: list[tuple[float, float, list[str]]] = []
    for time, error, label in sorted(labels):
        near = next((f for f in found if time < 2.5 * f[0] and 0.9 < error / f[1] < 1.1), None)
        if near is None:
            found.append((time, error, [label]))
        elif label not in near[2]:
            near[2].append(label)
    return [(time, error, ", ".join(parts)) for time, error, parts in found]


def _end(chart: Chart, axes: Axes, time: float) -> float:
    """Where the label of a line starts, as a share of the height: above, or below if marks are there."""
    low, high = np.log(axes.get_ylim())

    def height(error: float) -> float:
        return float((np.log(100.0 * error) - low) / (high - low))

    # the labels of marks reach far to the side, points do not
    taken = [height(f.error) for f in chart.figures if f.error]
    near = [p for p in chart.drawn() if abs(np.log10(p.time / time)) < 0.2]
    taken += [height(p.errors[chart.quantity]) for p in near]
    floor = max(height(chart.reference_error), 0.0) if chart.reference_error else 0.0
    if any(h > 0.65 for h in taken) and not any(h < floor + 0.35 for h in taken):
        return floor + 0.015
    return 0.985


def _limits(chart: Chart, axes: Axes) -> None:
    times = [p.time for p in chart.drawn()] + [f.time for f in chart.figures]
    errors = [100.0 * p.errors[chart.quantity] for p in chart.drawn()]
    errors += [100.0 * f.error for f in chart.figures if f.error]
    if chart.reference_error:
        errors.append(100.0 * chart.reference_error)
    room = 1.6
    axes.set_xlim(min(times) / room, max(times) * room)
    axes.set_ylim(np.min(errors) / room, np.max(errors) * room)
