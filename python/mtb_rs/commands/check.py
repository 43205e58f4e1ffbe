# SPDX-License-Identifier: MIT OR Apache-2.0
"""``mtb-rs check``: what a case states, what solving it would take, and all that is wrong with it."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from ..base import memory
from ..base.told import stated
from .console import console_on, print_rows


def add(commands: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """The command among the others."""
    check = commands.add_parser(
        "check",
        help="say what a case would solve, how large it is and about how long it takes, without solving",
        description="Reads a case file and names everything that is wrong with it. If nothing is, prints "
        "what would be solved, the number of contact points and of unknowns, and about how much memory and "
        "time it takes. Nothing is solved and nothing is written.",
    )
    check.add_argument("case", type=Path, metavar="CASE.toml")
    check.set_defaults(command=_check)


def _check(options: argparse.Namespace) -> int:
    from ..case import load_case

    console = console_on(sys.stdout)
    case = load_case(options.case)
    with console.status("counting ..."):
        cost = case.expected_cost()
    rows = case.scene().told()
    if case.motion is not None:
        rows.append(stated({"then": repr(case.motion)})[0])
    console.print("What would be solved:", style="bold")
    print_rows(rows, console)
    console.print("\nWhat it would take:", style="bold")
    print_rows(cost.told(), console)
    free = memory.available()
    largest = max(part.memory for part in cost.costs)
    if free is not None and largest > free:
        console.print(
            f"notice: {memory.amount(largest)} may be more than the {memory.amount(free)} that are free: "
            "larger cells take less",
            style="yellow",
            markup=False,
            soft_wrap=True,
        )
    console.print(f"\nNo fault is found in {options.case}.", markup=False, soft_wrap=True)
    return 0
