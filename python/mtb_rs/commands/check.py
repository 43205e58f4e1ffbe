# SPDX-License-Identifier: MIT OR Apache-2.0
"""``mtb-rs check``: what a case states, what solving it would take, and all that is wrong with it."""

from __future__ import annotations

import argparse
import sys
import warnings
from pathlib import Path

from ..base import memory
from ..base.told import in_words, stated
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
    from ..studies.wear import sliding_distance

    console = console_on(sys.stdout)
    with warnings.catch_warnings(record=True) as doubts:
        warnings.simplefilter("always")
        try:
            case = load_case(options.case)
            with console.status("counting ..."):
                cost = case.expected_cost()
            rows = case.scene().told()
        finally:
            texts = dict.fromkeys(str(doubt.message) for doubt in doubts)
            told = console_on(sys.stderr)
            for text in texts:
                told.print(f"mtb-rs: {' '.join(text.split())}", style="yellow", markup=False, soft_wrap=True)
    if case.motion is not None:
        rows.append(stated({"then": repr(case.motion)})[0])
    if case.brake is not None:
        shoes = len(case.brake.get("shares", (1.0,)))
        vehicle = f"{in_words(case.brake['mass'], 'kg')} from {in_words(case.brake['speed'], 'm/s')}"
        rows.append(("then", f"brake {vehicle} by {shoes} such shoe{'s' if shoes > 1 else ''}"))
    if case.wear is not None:
        way = in_words(sliding_distance(case.wear["distance"]), "m")
        rows.append(("then", f"wear over {way} of sliding"))
    if case.step_wheels is not None:
        asked = ", ".join(f"{name} {value}" for name, value in case.step_wheels.items())
        rows.append(("then", f"a step of wheels: {asked}"))
    console.print("What would be solved:", style="bold")
    print_rows(rows, console)
    studies = (case.brake, case.wear, case.step_wheels)
    what = "it" if all(study is None for study in studies) else "one contact of it"
    console.print(f"\nWhat {what} would take:", style="bold")
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
    found = "No fault is found" if not texts else "Nothing is refused, but the warnings above are doubts"
    console.print(f"\n{found} in {options.case}.", markup=False, soft_wrap=True)
    return 0
