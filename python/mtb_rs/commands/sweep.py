# SPDX-License-Identifier: MIT OR Apache-2.0
"""``mtb-rs sweep``: solve a case for all combinations of some of its arguments."""

from __future__ import annotations

import argparse
import sys
import warnings
from typing import TYPE_CHECKING, Any

from rich.progress import MofNCompleteColumn, Progress

from ..results.sweep_table import SweepTable
from ..studies.sweeps import sweep
from .arguments import add_case, directory_of, offer, processes, variation
from .console import console_on
from .exits import NO_SOLUTION

if TYPE_CHECKING:
    from ..case import Case


def add(commands: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """The command among the others."""
    sweep = commands.add_parser(
        "sweep",
        help="solve a case for all combinations of some of its arguments",
        description="Solves the scene of a case file for all combinations of the values of --vary and writes "
        "sweep.csv, sweep.json and sweep.npz, which `mtb-rs show` reads, and, where xarray is installed, "
        "sweep.nc. What is solved is kept in sweep.jsonl: the same "
        "command goes on where it was stopped; other values need another DIR.",
    )
    add_case(sweep)
    vary = sweep.add_argument(
        "--vary",
        action="append",
        required=True,
        type=variation,
        metavar="KEY=VALUES",
        help="an argument of the scene, or of its motion as rolling.velocity, with its values as in a case "
        "file: 0.1,0.3,0.5, words, lists, or first:last:count; repeated for further arguments",
    )
    offer(vary, _variables)
    sweep.add_argument(
        "-j", "--jobs", type=processes, default=None, metavar="N", help="processes (default: this one alone)"
    )
    sweep.set_defaults(command=_sweep)


def _variables(given: argparse.Namespace) -> list[str]:
    """What may be varied of the case on a line, as far as it can be read."""
    from ..case import load_case

    try:
        return [f"{name}=" for name in load_case(given.case).variables()]
    except ValueError:
        return []


def _meant(case: Case, key: str, values: list[Any]) -> Any:
    """The values of --vary as a case file means them, by their words."""
    labels = [str(value) if isinstance(value, list) else value for value in values]
    if key not in case.variables() or len(set(labels)) < len(labels):
        return values
    return {label: case.argument(key, value) for label, value in zip(labels, values, strict=True)}


def _sweep(options: argparse.Namespace) -> int:
    from ..case import load_case

    console = console_on(sys.stdout)
    directory = SweepTable.check_saveable(directory_of(options))
    varied = [key for key, _ in options.vary]
    if len(set(varied)) < len(varied):
        twice = next(key for key in varied if varied.count(key) > 1)
        raise ValueError(f"--vary {twice}= is there twice: give all its values at once")
    case = load_case(options.case)
    parameters = {key: _meant(case, key, values) for key, values in options.vary}
    with Progress(*Progress.get_default_columns(), MofNCompleteColumn(), console=console) as bar:
        task = bar.add_task("solving", total=None)
        table = sweep(
            case.scene(),
            parameters,
            executor=options.jobs,
            checkpoint=directory / "sweep.jsonl",
            progress=lambda done, total: bar.update(task, completed=done, total=total),
            **case.swept,
        )
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        written = table.save(directory)
    for warning in caught:
        console.print(f"notice: {warning.message}", style="yellow", markup=False, soft_wrap=True)
    for values, reason in table.failures:
        where = ", ".join(f"{k} = {v}" for k, v in values.items())
        console.print(f"{where}: {reason}", style="yellow", markup=False, soft_wrap=True)
    solved = len(table) - len(table.failures)
    console.print(f"{solved} of {len(table)} cases solved; {', '.join(map(str, written))}", markup=False)
    return 0 if solved else NO_SOLUTION
