# SPDX-License-Identifier: MIT OR Apache-2.0
"""``mtb-rs chart``: speed against accuracy of all models and methods."""

from __future__ import annotations

import argparse
import sys

from rich.progress import BarColumn, Progress, TextColumn
from rich.table import Table

from ..results.chart import Chart
from ..results.report import QUANTITIES
from .arguments import add_case, directory_of, repeats, seconds
from .console import console_on


def add(commands: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """The command among the others."""
    chart = commands.add_parser(
        "chart",
        help="chart speed against accuracy of all models and methods",
        description="Solves the scene of a case file by every model and method that applies, at several "
        "resolutions, and charts time against error: chart.png, chart.html (hover over it), chart.csv. "
        "The options of [solve] are not used.",
    )
    add_case(chart)
    chart.add_argument(
        "--budget",
        type=seconds,
        default=60.0,
        metavar="SECONDS",
        help="time to spend (default: %(default)g)",
    )
    chart.add_argument(
        "--repeats",
        type=repeats,
        default=3,
        metavar="N",
        help="solves of each point, of whose times the median counts (default: %(default)d)",
    )
    chart.add_argument(
        "--quantity", choices=QUANTITIES, default="pressure", help="whose error (default: %(default)s)"
    )
    chart.set_defaults(command=_chart)


def _chart(options: argparse.Namespace) -> int:
    from ..case import load_case

    console = console_on(sys.stdout)
    directory = Chart.check_saveable(directory_of(options))
    case = load_case(options.case)
    for word in ("wear", "brake", "step_wheels", "stress"):
        if getattr(case, word) is not None:
            raise ValueError(
                f"{options.case}: [{word}] is given, and a chart compares single solves: take the table out"
            )
    if case.motion is not None:
        raise ValueError(
            f"{options.case}: [{case.motion.word}] is given, and a chart compares ways to press down, "
            "none of which rolls or shifts: take the table out for a chart of the pressing alone"
        )
    scene = case.scene()
    with Progress(TextColumn("{task.description}"), BarColumn(), console=console, transient=True) as bar:
        task = bar.add_task("charting ...", total=1.0)
        chart = scene.chart(
            options.quantity,
            options.budget,
            options.repeats,
            lambda share, doing: bar.update(task, completed=share, description=doing),
        )
    own = "" if not chart.reference_error else f", its own error about {100.0 * chart.reference_error:.2g} %"
    console.print(f"against: {chart.reference}{own}", markup=False, soft_wrap=True)
    table = Table(box=None, pad_edge=False, padding=(0, 2, 0, 0))
    table.add_column("efficient")
    for name in ("points", "processor [s]", f"error of the {chart.quantity} [%]"):
        table.add_column(name, justify="right")
    for point in chart.efficient():
        error = 100.0 * point.errors[chart.quantity]
        table.add_row(point.series, str(point.unknowns), f"{point.time:.3g}", f"{error:.3g}")
    console.print(table, markup=False)
    for series in dict.fromkeys(p.series for p in chart.points if p.failure):
        failure = next(p.failure for p in chart.points if p.series == series and p.failure)
        console.print(f"failed: {series}: {failure}", style="yellow", markup=False, soft_wrap=True)
    written = chart.save(directory)
    console.print(f"{len(written)} files in {directory}", markup=False, soft_wrap=True)
    return 0
