# SPDX-License-Identifier: MIT OR Apache-2.0
"""What the commands print, and where: reports, warnings, any terminal."""

from __future__ import annotations

import codecs
import contextlib
import io
import os
import sys
import warnings
from collections.abc import Iterable, Iterator
from typing import Any, TextIO

from rich.console import Console
from rich.table import Table

from ..base.told import Row
from ..results.savable import Savable


@contextlib.contextmanager
def warnings_on(console: Console) -> Iterator[None]:
    """Warnings as sentences, without the line of a program that nobody here wrote."""

    def show(message: Warning | str, *_: Any, **__: Any) -> None:
        console.print(f"mtb-rs: {' '.join(str(message).split())}", style="yellow")

    with warnings.catch_warnings():
        warnings.simplefilter("default", UserWarning)
        setattr(warnings, "showwarning", show)  # noqa: B010 (whatever else it is called with)
        yield


def one_line(error: Exception) -> str:
    return " ".join(str(error).split())


def console_on(stream: TextIO, **options: Any) -> Console:
    """A console that prints on any terminal: signs that its encoding lacks are written plainly."""
    if isinstance(stream, io.TextIOWrapper):
        stream.reconfigure(errors=_PLAIN)
    return Console(file=stream, highlight=False, emoji=False, **options)


def _plainly(error: UnicodeError) -> tuple[str, int]:
    if not isinstance(error, UnicodeEncodeError):
        raise error
    return "".join(
        "u" if sign in "\u00b5\u03bc" else "?" for sign in error.object[error.start : error.end]
    ), error.end


_PLAIN = "mtb_rs.plain"
codecs.register_error(_PLAIN, _plainly)


def leave_standard_output() -> None:
    """What could not be printed, to a full disk or a closed pipe, is not tried again at the end."""
    try:
        sys.stdout.flush()
    except OSError:
        with contextlib.suppress(OSError, ValueError):
            nowhere = os.open(os.devnull, os.O_WRONLY)
            os.dup2(nowhere, sys.stdout.fileno())
            os.close(nowhere)


def print_report(result: Savable, console: Console, elapsed: float | None = None) -> None:
    """A short report: what was solved, what carries what, how well, how long it took, if that is known."""
    if result.heading:
        console.print(result.heading, markup=False, soft_wrap=True)
    rows = result.told()
    times: dict[str, float] = result.facts().get("report", {}).get("time_s", {})
    stages = ", ".join(f"{name} {1e3 * value:.3g} ms" for name, value in times.items())
    if elapsed is not None:
        rows.append(("time", f"{elapsed:.3g} s" + (f" ({stages})" if stages else "")))
    elif stages:
        rows.append(("time", stages))
    print_rows(rows, console)


def print_rows(rows: Iterable[Row], console: Console) -> None:
    """Names and what is to be said of them, in two columns."""
    table = Table(box=None, show_header=False, pad_edge=False, padding=(0, 2, 0, 0))
    table.add_column(style="bold", no_wrap=True)
    table.add_column(overflow="fold")
    for row in rows:
        table.add_row(*row)
    console.print(table, markup=False)
