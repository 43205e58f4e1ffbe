# SPDX-License-Identifier: MIT OR Apache-2.0
"""What the commands print, and where: reports, warnings, any terminal."""

from __future__ import annotations

import codecs
import contextlib
import io
import os
import sys
import warnings
from collections.abc import Iterator
from typing import Any, TextIO

import numpy as np
from rich.console import Console
from rich.table import Table

from ..results.result import Drawn, Result


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


def print_report(result: Drawn, console: Console, elapsed: float | None = None) -> None:
    """A short report: what was solved, what carries what, how well, how long it took, if that is known."""
    if isinstance(result, Result):
        _print_scene(result, console, elapsed)
        return
    console.print(str(result), markup=False, soft_wrap=True)
    for total in result.totals().values():
        numbers = ", ".join(f"{value:.6g}" for value in np.atleast_1d(total.values))
        console.print(f"{total.label}: {numbers} {total.unit}".rstrip(" -"), markup=False, soft_wrap=True)
    if elapsed is not None:
        console.print(f"time: {elapsed:.3g} s", markup=False)


def _print_scene(result: Result, console: Console, elapsed: float | None) -> None:
    report = result.report
    # what is rounding beside the whole is 0 here
    force = np.where(np.abs(result.force) < 1e-12 * np.linalg.norm(result.force), 0.0, result.force)
    fx, fy, fz = (f"{value:.6g}" for value in force)
    approach = ", ".join(_length(value) for value in np.atleast_1d(result.approach))
    rows: list[tuple[str, str]] = [
        ("model", f"{report.model}, {report.method} ({report.solver})"),
        ("outcome", "converged" if report.converged else f"NOT converged: {report.status}"),
        ("normal force", f"{result.normal_force:.6g} N"),
        ("force on the lower body", f"x {fx}, y {fy}, z {fz} N"),
    ]
    for name, value in report.force_balance.items():
        if isinstance(value, float):
            rows.append(("force balance, relative" if name == "relative_error" else name, _plain(value)))
        elif name != "contact":
            rows.append((name, ", ".join(f"{c} {v:.6g}" for c, v in zip("xyz", value, strict=False)) + " N"))
    closed = int(np.count_nonzero(result.status))
    rows += [
        ("approach", approach),
        ("contact area", f"{report.contact_area * 1e6:.6g} mm2, {closed} of {result.status.size} points"),
        ("peak pressure", f"{report.peak_pressure / 1e6:.5g} MPa"),
        ("iterations", f"{report.iterations}, residual {report.residual:.1e}"),
    ]
    rows += [("left out", words) for words in result.left_out()]
    if report.error_estimates:
        rows.append(("estimated error", result.errors_in_words()))
    if report.missed:
        rows.append(("tolerance", report.missed))
    stages = ", ".join(f"{name} {1e3 * value:.3g} ms" for name, value in report.time_s.items())
    if elapsed is not None:
        rows.append(("time", f"{elapsed:.3g} s" + (f" ({stages})" if stages else "")))
    elif stages:
        rows.append(("time", stages))
    table = Table(box=None, show_header=False, pad_edge=False, padding=(0, 2, 0, 0))
    table.add_column(style="bold", no_wrap=True)
    table.add_column(overflow="fold")
    for row in rows:
        table.add_row(*row)
    console.print(table, markup=False)


def _length(value: float) -> str:
    return f"{value * 1e6:.5g} µm" if abs(value) < 1e-3 else f"{value * 1e3:.5g} mm"


def _plain(value: Any) -> str:
    return f"{value:.3g}" if isinstance(value, float) else str(value)
