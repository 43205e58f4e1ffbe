# SPDX-License-Identifier: MIT OR Apache-2.0
"""``mtb-rs wear``: wear the contact of a case."""

from __future__ import annotations

import argparse
from pathlib import Path

from ..results.wear_result import WearResult
from .arguments import add_case
from .solving import study, write_rows


def add(commands: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """The command among the others."""
    wear = commands.add_parser(
        "wear",
        help="wear the contact of a case that has a table [wear]",
        description="Wears the scene of a case file over the way of its table [wear], prints a report, and "
        "writes summary.json, the fields (NPZ, VTK), pictures, wear.csv with a row for each step, and "
        "on a rail, unless the shoe is turned, the worn profiles rail.prr and sole_NAME.prr. The steps "
        "are kept in wear.jsonl: the same command goes on where it was stopped.",
    )
    add_case(wear)
    wear.set_defaults(command=_wear)


def _wear(options: argparse.Namespace) -> int:
    needed = "distance [m] or passages, and law,"
    return study(options, "wear", needed, "wearing", lambda case, **how: case.worn(**how), _further)


def _further(worn: WearResult, directory: Path) -> list[Path]:
    """A row for each step, and on a rail the worn profiles of it and of soles of more than one row."""
    heading = ["distance [m]", "step [m]", "depth_upper [m]", "depth_lower [m]", "volume_upper [m^3]"]
    heading += ["volume_lower [m^3]", "peak_pressure [Pa]", "uniformity", "error", "solves"]
    columns = [worn.distance, worn.steps, *worn.depth, *worn.worn_volume]
    columns += [worn.peak_pressure, worn.uniformity, worn.errors]
    rows = zip(*(column.tolist() for column in (*columns, worn.solves)), strict=True)
    written = [write_rows(directory / "wear.csv", heading, rows)]
    if worn.has_profiles:
        profiles = {"rail.prr": worn.profile("lower")}
        # one row of contact points is no profile
        for grid in (grid for grid in worn.patches if grid.ny > 1):
            profiles[f"sole_{grid.name}.prr"] = worn.profile("upper", patch=grid.name)
        for name, profile in profiles.items():
            profile.to_file(directory / name)
            written.append(directory / name)
    return written
