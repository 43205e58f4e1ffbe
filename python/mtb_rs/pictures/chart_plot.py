# SPDX-License-Identifier: MIT OR Apache-2.0
"""The chart as a picture (matplotlib)."""

from __future__ import annotations

import textwrap
from collections.abc import Sequence
from itertools import cycle

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

from ..results.chart import Chart
from ..results.chart import Figure as Known
from .quantities import INK, LINE_COLOURS

#: Told apart without colour as well.
MARKERS = "osD^vP*Xh<"


#: Letters that a line of the caption has room for.
MOST_LETTERS = 105
#: Names of times known from elsewhere.
LETTERS = "abcdefghijklmnopqrstuvwxyz"


def draw(chart: Chart) -> Figure:
    """Processor time against error, both logarithmic; efficient points joined.

    Times known from elsewhere are letters at the upper edge, or stars where their error is known; the legend
    names them.

    Raises
    ------
    ValueError
        If no point has an error to show.
    """
    chart.check_drawable()
    series = [s for s in chart.series if chart.drawn(s)]
    known = sorted(chart.figures, key=lambda f: f.time)
    rows = -(-(len(series) + 1) // 2) + -(-len(known) // 2)
    figure = Figure(figsize=(7.4, 4.6 + 0.2 * rows), dpi=150, layout="constrained")
    FigureCanvasAgg(figure)
    axes = figure.add_subplot()
    efficient = chart.efficient()
    axes.plot(
        [p.time for p in efficient],
        [100.0 * p.errors[chart.quantity] for p in efficient],
        color="0.8",
        lw=7,
        solid_capstyle="round",
        solid_joinstyle="round",
        zorder=1,
        label="no other one beats these",
    )
    for k, name in enumerate(series):
        points = sorted(chart.drawn(name), key=lambda p: p.unknowns)
        growth = chart.growth(name)
        axes.plot(
            [p.time for p in points],
            [100.0 * p.errors[chart.quantity] for p in points],
            MARKERS[k % len(MARKERS)] + "-",
            color=LINE_COLOURS[k % len(LINE_COLOURS)],
            ms=6.5,
            lw=0.9,
            mec="white",
            mew=0.6,
            label=name + ("" if growth is None else f", time ~ n$^{{{growth:.1f}}}$"),
            zorder=3,
        )
    axes.set_xscale("log")
    axes.set_yscale("log")
    _limits(chart, axes)
    _draw_known(known, axes)
    if chart.reference_error:
        axes.axhspan(axes.get_ylim()[0], 100.0 * chart.reference_error, color="0.93", zorder=0)
        axes.annotate(
            "error of the reference itself",
            (0.99, 100.0 * chart.reference_error),
            xycoords=("axes fraction", "data"),
            xytext=(0, -3),
            textcoords="offset points",
            ha="right",
            va="top",
            fontsize=8,
            color="0.35",
        )
    plain = FuncFormatter(lambda v, _: f"{v:g}")
    for axis, (low, high) in ((axes.xaxis, axes.get_xlim()), (axes.yaxis, axes.get_ylim())):
        axis.set_major_locator(LogLocator(subs=(1.0,) if high > 1e3 * low else (1.0, 2.0, 5.0), numticks=40))
        axis.set_minor_locator(LogLocator(subs=tuple(range(2, 10)), numticks=40))
        axis.set_major_formatter(plain)
        axis.set_minor_formatter(NullFormatter())
    axes.tick_params(labelsize=8.5)
    axes.grid(which="major", color="0.87", lw=0.7)
    axes.set_axisbelow(True)
    axes.spines[["top", "right"]].set_visible(False)
    axes.set_xlabel("processor time, median [s]", fontsize=9)
    sizes = sorted((p.time, p.unknowns) for p in efficient)
    ends = f"; grey line: {sizes[0][1]} to {sizes[-1][1]} points" if len(sizes) > 1 else ""
    figure.suptitle(chart.title, x=0.02, ha="left", fontsize=11, fontweight="bold", color=INK)
    remark = f"\n{chart.remark}" if chart.remark else ""
    caption = f"error against: {chart.reference}{ends}{remark}"
    lines = [part for line in caption.splitlines() for part in textwrap.wrap(line, MOST_LETTERS)]
    axes.set_title("\n".join(lines), loc="left", fontsize=8.5, color="0.35")
    axes.set_ylabel(f"error of the {chart.quantity} [%]", fontsize=9)
    figure.legend(
        *axes.get_legend_handles_labels(), loc="outside lower left", ncols=2, fontsize=8.5, frameon=False
    )
    return figure


def _draw_known(known: Sequence[Known], axes: Axes) -> None:
    """Times known from elsewhere: letters where nothing else is known, stars with one where the error is."""
    low, high = np.log10(axes.get_xlim())
    last, level = -np.inf, 0
    for letter, one in zip(cycle(LETTERS), known):
        label = f"{letter}: {one.label}, {_seconds(one.time)}"
        if one.error is not None:
            place = (one.time, 100.0 * one.error)
            axes.plot(*place, "*", ms=12, color=INK, zorder=4)
            axes.annotate(letter, place, xytext=(6, 5), textcoords="offset points", fontsize=9, color=INK)
        else:
            # letters that would cover one another stand in rows
            share = (np.log10(one.time) - low) / (high - low)
            level = level + 1 if share - last < 0.022 else 0
            last = share
            axes.axvline(one.time, color="0.6", lw=0.9, ls=(0, (4, 3)), zorder=0)
            axes.text(
                one.time,
                0.985 - 0.045 * (level % 4),
                letter,
                transform=axes.get_xaxis_transform(),
                ha="center",
                va="top",
                fontsize=9,
                color=INK,
                bbox={"facecolor": "white", "edgecolor": "none", "pad": 0.6},
            )
        axes.plot([], [], " ", label=label)


def _seconds(time: float) -> str:
    return f"{time:.3g} s" if time < 1e3 else f"{time:.0f} s"


def _limits(chart: Chart, axes: Axes) -> None:
    times = [p.time for p in chart.drawn()] + [f.time for f in chart.figures]
    errors = [100.0 * p.errors[chart.quantity] for p in chart.drawn()]
    errors += [100.0 * f.error for f in chart.figures if f.error]
    if chart.reference_error:
        errors.append(100.0 * chart.reference_error)
    room = 1.6
    axes.set_xlim(min(times) / room, max(times) * room)
    axes.set_ylim(np.min(errors) / room, np.max(errors) * room)
