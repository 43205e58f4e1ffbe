# SPDX-License-Identifier: MIT OR Apache-2.0
"""``mtb-rs brake``: the stop of a vehicle by the shoes of a case."""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np

from ..studies.braking import Braking
from .arguments import add_case
from .solving import study, write_rows


def add(commands: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """The command among the others."""
    brake = commands.add_parser(
        "brake",
        help="brake a vehicle by the shoes of a case that has a table [brake]",
        description="Brakes a vehicle as the table [brake] of a case file says, until it stands, prints a "
        "report, and writes summary.json, the fields (NPZ, VTK), pictures, and brake.csv with a row for each "
        "step. The steps are kept in brake.jsonl: the same command goes on where it was stopped.",
    )
    add_case(brake)
    brake.set_defaults(command=_brake)


def _brake(options: argparse.Namespace) -> int:
    needed = "speed [m/s] and mass [kg]"
    return study(options, "brake", needed, "braking", lambda case, **how: case.braked(**how), _further)


def _further(stop: Braking, directory: Path) -> list[Path]:
    """A row for each step: time, speed and way at its end, forces during it."""
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
    rows = np.transpose(list(columns.values())).tolist()
    return [write_rows(directory / "brake.csv", columns, rows)]
