# SPDX-License-Identifier: MIT OR Apache-2.0
"""``mtb-rs run``: solve a case and write its results and pictures."""

from __future__ import annotations

import argparse
import time

from .arguments import add_case
from .solving import opened, written


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
    console, directory, case = opened(options)
    with console.status("solving ..."):
        clock = time.perf_counter()
        result = case.solve()
        elapsed = time.perf_counter() - clock
    return written(console, directory, case, result, elapsed)
