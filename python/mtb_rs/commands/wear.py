# SPDX-License-Identifier: MIT OR Apache-2.0
"""``mtb-rs wear``: wear the contact of a case."""

from __future__ import annotations

import argparse
import csv
import io
import sys
import time
import warnings

from rich.progress import Progress

from ..results.wear_result import WearResult
from .arguments import add_case, directory_of
from .console import console_on, print_report


def add(commands: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """The command among the others."""
    wear = commands.add_parser(
        "wear",
        help="wear the contact of a case that has a table [wear]",
        description="Wears the scene of a case file over the way of its table [wear], prints a report, and "
        "writes summary.json, the fields (NPZ, VTK), pictures, wear.csv with a row for each step, and on a "
        "rail the worn profiles rail.prr and sole_NAME.prr. The steps are kept in wear.jsonl: the same "
        "command goes on where it was stopped.",
    )
    add_case(wear)
    wear.set_defaults(command=_wear)


def _wear(options: argparse.Namespace) -> int:
    from ..base.files import write_bytes
    from ..case import load_case
    from ..pictures.files import check_saveable

    console = console_on(sys.stdout)
    directory = check_saveable(directory_of(options))
    case = load_case(options.case)
    if case.wear is None:
        raise ValueError(
            f"{options.case}: has no table [wear]: one with distance [m] or passages, and law, is needed"
        )
    with Progress(console=console) as bar:
        task = bar.add_task("wearing", total=1.0)
        clock = time.perf_counter()
        worn = case.worn(
            checkpoint=directory / "wear.jsonl", progress=lambda share: bar.update(task, completed=share)
        )
        elapsed = time.perf_counter() - clock
    with console.status("writing ..."), warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        written = worn.save(directory)
    files = {"wear.csv": _rows(worn)}
    for name, content in files.items():
        write_bytes(directory / name, content)
    profiles = 0
    if worn.rail.size and worn.patches:
        worn.profile("lower").to_file(directory / "rail.prr")
        for grid in worn.patches:
            worn.profile("upper", patch=grid.name).to_file(directory / f"sole_{grid.name}.prr")
        profiles = 1 + len(worn.patches)
    print_report(worn, console, elapsed)
    for warning in caught:
        console.print(f"notice: {warning.message}", style="yellow", markup=False, soft_wrap=True)
    count = len(written) + len(files) + profiles
    console.print(f"{count} files in {directory}", markup=False, soft_wrap=True)
    return 0


def _rows(worn: WearResult) -> bytes:
    """A row for each step, as CSV."""
    stream = io.StringIO(newline="")
    writer = csv.writer(stream)
    heading = ["distance [m]", "step [m]", "depth_upper [m]", "depth_lower [m]", "volume_upper [m^3]"]
    writer.writerow([*heading, "volume_lower [m^3]", "peak_pressure [Pa]", "uniformity", "error", "solves"])
    depth, volume = worn.depth, worn.worn_volume
    for k in range(len(worn.distance)):
        numbers = [worn.distance[k], worn.steps[k], *depth[:, k], *volume[:, k]]
        numbers += [worn.peak_pressure[k], worn.uniformity[k], worn.errors[k]]
        writer.writerow([*map(float, numbers), int(worn.solves[k])])
    return stream.getvalue().encode()
