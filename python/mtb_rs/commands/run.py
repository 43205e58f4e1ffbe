# SPDX-License-Identifier: MIT OR Apache-2.0
"""``mtb-rs run``: solve a case and write its results and pictures."""

from __future__ import annotations

import argparse
import sys
import time
import warnings

from .arguments import add_case, directory_of
from .console import console_on, print_report


def add(commands: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """The command among the others."""
    run = commands.add_parser(
        "run",
        help="solve a case and write its results and pictures",
        description="Solves the scene of a case file, prints a report, and writes summary.json, the fields "
        "(NPZ, VTK) and pictures.",
    )
    add_case(run)
    run.set_defaults(command=_run)


def _run(options: argparse.Namespace) -> int:
    from ..case import load_case
    from ..pictures.files import check_saveable

    console = console_on(sys.stdout)
    directory = check_saveable(directory_of(options))
    case = load_case(options.case)
    with console.status("solving ..."):
        clock = time.perf_counter()
        result = case.solve()
        elapsed = time.perf_counter() - clock
    with console.status("writing ..."), warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        written = result.save(directory)
    print_report(result, console, elapsed)
    for warning in caught:
        console.print(f"notice: {warning.message}", style="yellow", markup=False, soft_wrap=True)
    console.print(f"{len(written)} files in {directory}", markup=False, soft_wrap=True)
    return 0
