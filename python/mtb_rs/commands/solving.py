# SPDX-License-Identifier: MIT OR Apache-2.0
"""What the commands that solve a case have in common: reading it, the bar, writing, the report."""

from __future__ import annotations

import argparse
import csv
import io
import json
import sys
import time
import warnings
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

from rich.console import Console
from rich.progress import Progress

from ..results.savable import Savable
from ..results.stressed import Stressed
from .arguments import directory_of
from .console import console_on, print_report, print_rows

if TYPE_CHECKING:
    from ..case import Case

S = TypeVar("S", bound=Savable)


def opened(options: argparse.Namespace) -> tuple[Console, Path, Case]:
    """Where to print, where to write, and the case."""
    from ..case import load_case
    from ..pictures.files import check_saveable

    console = console_on(sys.stdout)
    directory = check_saveable(directory_of(options))
    return console, directory, load_case(options.case)


def study(
    options: argparse.Namespace,
    word: str,
    needed: str,
    doing: str,
    solve: Callable[..., S],
    further: Callable[[S, Path], list[Path]],
) -> int:
    """A study that the table `word` of a case asks for, step by step, with a checkpoint and a bar.

    `needed` says what such a table needs, `solve` does it for the case, `further` writes what
    :meth:`Savable.save` does not.
    """
    console, directory, case = opened(options)
    if getattr(case, word) is None:
        raise ValueError(f"{options.case}: has no table [{word}]: one with {needed} is needed")
    with Progress(console=console) as bar:
        task = bar.add_task(doing, total=1.0)
        clock = time.perf_counter()
        result = solve(
            case,
            checkpoint=directory / f"{word}.jsonl",
            progress=lambda share: bar.update(task, completed=share),
        )
        elapsed = time.perf_counter() - clock
    return written(console, directory, case, result, elapsed, further)


def written(
    console: Console,
    directory: Path,
    case: Case,
    result: S,
    elapsed: float,
    further: Callable[[S, Path], list[Path]] = lambda *_: [],
) -> int:
    """Saves a result and the stress that its case asks for, prints its report and what there was to say, and
    counts the files.
    """
    with console.status("writing ..."), warnings.catch_warnings(record=True) as caught:
        from ..base.files import write_bytes
        from ..case.damage_words import damage_told

        warnings.simplefilter("always")
        files = [*result.save(directory), *further(result, directory)]
        if case.stress is not None and isinstance(result, Stressed):
            files += case.stressed(result).save(directory)
        told: list[tuple[str, str]] = []
        if case.damage is not None:
            # such a case rolls
            rolled: Any = result
            numbers, temperature = case.damaged(rolled)
            path = directory / "damage.json"
            write_bytes(path, json.dumps(numbers, indent=2).encode() + b"\n")
            files.append(path)
            files += [] if temperature is None else temperature.save(directory / "temperature")
            told = damage_told(numbers)
    print_report(result, console, elapsed)
    if told:
        print_rows(told, console)
    for warning in caught:
        console.print(f"notice: {warning.message}", style="yellow", markup=False, soft_wrap=True)
    console.print(f"{len(files)} files in {directory}", markup=False, soft_wrap=True)
    return 0


def write_rows(path: Path, heading: Iterable[str], rows: Iterable[Iterable[Any]]) -> Path:
    """A table as CSV."""
    from ..base.files import write_bytes

    stream = io.StringIO(newline="")
    writer = csv.writer(stream)
    writer.writerow(heading)
    writer.writerows(rows)
    write_bytes(path, stream.getvalue().encode())
    return path
