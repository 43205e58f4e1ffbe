# SPDX-License-Identifier: MIT OR Apache-2.0
"""Values on the command line, as a case file has them."""

from __future__ import annotations

import argparse
import math
import os
import tomllib
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

import numpy as np

from ..base.check import path_of, shortened
from ..geometry.profiles import STANDARD_PROFILES
from ..studies.sweep_cases import MOST_CASES
from ..studies.sweeps import most_processes

#: Most seconds that a chart may take, and most solves of each of its points.
LONGEST_BUDGET, MOST_REPEATS = 604_800.0, 1000


def add_case(parser: argparse.ArgumentParser) -> None:
    """The case file that a command solves, and where it writes."""
    parser.add_argument("case", type=Path, metavar="CASE.toml")
    parser.add_argument(
        "-o",
        "--output",
        type=Path,
        metavar="DIR",
        help="where to write (default: a directory named as the case, here)",
    )


def offer(action: argparse.Action, words: Callable[[argparse.Namespace], Iterable[str]]) -> None:
    """Offers words for an argument to a shell that completes, by what else stands on its line."""
    # where argcomplete looks for them
    action.completer = lambda parsed_args, **_: words(parsed_args)  # type: ignore[attr-defined]


def directory_of(options: argparse.Namespace) -> Path:
    """Where to write: as told, or a directory named as the case."""
    if options.output is not None:
        return path_of("DIR", os.fspath(options.output))
    name = options.case.stem.strip(". ")
    if not name:
        raise ValueError(f"{options.case} has no name to call a directory by: -o DIR is needed")
    return Path(name)


def variation(text: str) -> tuple[str, list[Any]]:
    """KEY=VALUES of the command line: numbers between commas, words, lists [..], or first:last:count."""
    key, equals, values = text.partition("=")
    if not equals or not key or not values:
        raise argparse.ArgumentTypeError(f"{text!r}: KEY=VALUES is needed, for example friction=0.1,0.3")
    key = key.strip()
    if values.lstrip().startswith("["):
        return key, _lists(text, values)
    first, colon, rest = values.partition(":")
    if colon and not isinstance(_value(first), str):
        last, _, count = rest.partition(":")
        ends = (_value(first), _value(last))
        if isinstance(ends[1], str) or not count.strip().isdecimal() or not 1 <= int(count) <= MOST_CASES:
            raise argparse.ArgumentTypeError(
                f"{text!r}: first:last:count needs two finite numbers and a whole number from 1 on, "
                f"to {MOST_CASES}"
            )
        steps = np.linspace(*ends, int(count)).tolist()
        is_whole = all(isinstance(end, int) for end in ends) and all(step.is_integer() for step in steps)
        return key, [int(step) for step in steps] if is_whole else steps
    listed = [_value(value) for value in values.split(",")]
    words = [value for value in listed if isinstance(value, str)]
    if "" in words or 0 < len(words) < len(listed):
        raise argparse.ArgumentTypeError(f"{text!r}: all values must be finite numbers, or all of them words")
    return key, listed


def _lists(text: str, values: str) -> list[Any]:
    """Lists between commas, each as in a case file."""
    try:
        listed: list[Any] = tomllib.loads(f"it = [{values}]")["it"]
    except (ValueError, RecursionError):  # TOMLDecodeError is one
        listed = []
    if not listed or not all(isinstance(value, list) for value in listed):
        raise argparse.ArgumentTypeError(
            f"{text!r}: lists between commas are needed, each as in a case file: [1e-3, 0, 0],[2e-3, 0, 0]"
        )
    return listed


def _value(text: str) -> Any:
    """A finite number, whole if written so, or a word: 60E1 is one, though it reads as a number."""
    text = text.strip()
    try:
        number = float(text)
    except ValueError:
        return text
    if not math.isfinite(number) or text in STANDARD_PROFILES:
        return text
    return int(text) if text.lstrip("+-").isdecimal() else number


def processes(text: str) -> int:
    if not text.strip().isdecimal() or not text.strip().lstrip("0"):
        raise argparse.ArgumentTypeError(f"{shortened(text)}: a whole number from 1 on is needed")
    most = most_processes()
    if len(text) > 9 or int(text) > most:
        raise argparse.ArgumentTypeError(
            f"{shortened(text)}: at most {most} processes, four for each processor, are started"
        )
    return int(text)


def seconds(text: str) -> float:
    value = _value(text)
    if isinstance(value, str) or not 0.0 < value <= LONGEST_BUDGET:
        raise argparse.ArgumentTypeError(
            f"{shortened(text)}: seconds up to {LONGEST_BUDGET:g}, a week, are needed"
        )
    return float(value)


def repeats(text: str) -> int:
    if not text.strip().isdecimal() or len(text) > 9 or not 1 <= int(text) <= MOST_REPEATS:
        raise argparse.ArgumentTypeError(
            f"{shortened(text)}: a whole number from 1 to {MOST_REPEATS} is needed"
        )
    return int(text)
