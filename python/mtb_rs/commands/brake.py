# SPDX-License-Identifier: MIT OR Apache-2.0
"""``mtb-rs brake``: the stop of a vehicle by the shoes of a case."""

from __future__ import annotations

import argparse
import csv
import io
import sys
import time
import warnings

import numpy as np
from rich.progress import Progress

from ..studies.braking import Braking
from .arguments import add_case, directory_of
from .console import console_on, print_report


def add(commands: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """The command among the others."""
    brake = commands.add_parser(
        "brake",
        help="brake a vehicle by the shoes of a case that has a table [brake]",
        description="Brakes a vehicle as the table [brake] of a case file says, until it stands, prints a "
        "report, and writes summary.json, the fields (NPZ, VTK), pictures, and brake.csv with a row for each "
        "step. Nothing is written before the vehicle stands: a stop that is interrupted begins anew.",
    )
    add_case(brake)
    brake.set_defaults(command=_brake)


def _brake(options: argparse.Namespace) -> int:
    from ..base.files import write_bytes
    from ..case import load_case
    from ..pictures.files import check_saveable

    console = console_on(sys.stdout)
    directory = check_saveable(directory_of(options))
    case = load_case(options.case)
    if case.brake is None:
        raise ValueError(
            f"{options.case}: has no table [brake]: one with speed [m/s] and mass [kg] is needed"
        )
    with Progress(console=console) as bar:
        task = bar.add_task("braking", total=1.0)
        clock = time.perf_counter()
        stop = case.braked(progress=lambda share: bar.update(task, completed=share))
        elapsed = time.perf_counter() - clock
    with console.status("writing ..."), warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        written = stop.save(directory)
    write_bytes(directory / "brake.csv", _rows(stop))
    print_report(stop, console, elapsed)
    for warning in caught:
        console.print(f"notice: {warning.message}", style="yellow", markup=False, soft_wrap=True)
    console.print(f"{len(written) + 1} files in {directory}", markup=False, soft_wrap=True)
    return 0


def _rows(stop: Braking) -> bytes:
    """A row for each step, as CSV: time, speed and way at its end, forces during it."""
    columns = {
        "time [s]": stop.time[1:],
        "speed [m/s]": stop.speed[1:],
        "way [m]": stop.way[1:],
        "force_of_shoes [N]": stop.forces.sum(axis=1),
        "other_force [N]": stop.other_force,
        "hottest_contact [K]": np.max([shoe.peaks for shoe in stop.shoes], axis=0),
        "hottest_sole [K]": np.max([shoe.means for shoe in stop.shoes], axis=0),
        "volume_upper [m^3]": np.sum([shoe.volumes_upper for shoe in stop.shoes], axis=0),
        "volume_lower [m^3]": np.sum([shoe.volumes_lower for shoe in stop.shoes], axis=0),
        "error": stop.errors,
    }
    stream = io.StringIO(newline="")
    writer = csv.writer(stream)
    writer.writerow(columns)
    writer.writerows(np.transpose(list(columns.values())).tolist())
    return stream.getvalue().encode()
