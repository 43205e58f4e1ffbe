# SPDX-License-Identifier: MIT OR Apache-2.0
"""The command line: ``mtb-rs run``, ``mtb-rs show``, ``mtb-rs chart``, ``mtb-rs sweep``."""

from __future__ import annotations

import argparse
import codecs
import contextlib
import io
import math
import os
import sys
import time
import warnings
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, TextIO

import numpy as np
from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn
from rich.table import Table

from . import __version__
from .base.check import path_of, shortened
from .base.errors import CaseError, ConvergenceError
from .base.files import DATA, check_folder, read_text
from .geometry.profiles import STANDARD_PROFILES
from .results.report import QUANTITIES
from .results.result import Result
from .results.saved import load
from .studies.sweeps import MOST_CASES, most_processes

if TYPE_CHECKING:
    from .case import Case

#: Most seconds that a chart may take, and most solves of each of its points.
LONGEST_BUDGET, MOST_REPEATS = 604_800.0, 1000

#: Exit codes, beside 0: bad input or an unwritable directory; no solution; stopped by the user.
BAD_INPUT, NO_SOLUTION, STOPPED = 2, 3, 130


def main(arguments: Sequence[str] | None = None) -> int:
    """Runs the command line and returns its exit code."""
    options = _parser().parse_args(arguments)
    errors = _console(sys.stderr, markup=False, soft_wrap=True)
    try:
        with _warnings_on(errors):
            command: Callable[[argparse.Namespace], int] = options.command
            code = command(options)
        sys.stdout.flush()
        return code
    except ConvergenceError as error:
        errors.print(f"mtb-rs: no solution: {_one_line(error)}", style="red")
        return NO_SOLUTION
    except CaseError as error:
        errors.print("\n".join(f"mtb-rs: {line}" for line in str(error).splitlines()), style="red")
        return BAD_INPUT
    except MemoryError as error:
        errors.print(f"mtb-rs: the memory does not suffice: {_one_line(error)}", style="red")
        return BAD_INPUT
    except (ValueError, OSError) as error:
        errors.print(f"mtb-rs: {_one_line(error)}", style="red")
        return BAD_INPUT
    except KeyboardInterrupt:
        errors.print("mtb-rs: stopped", style="red")
        return STOPPED
    finally:
        _leave_standard_output()


@contextlib.contextmanager
def _warnings_on(console: Console) -> Iterator[None]:
    """Warnings as sentences, without the line of a program that nobody here wrote."""

    def show(message: Warning | str, *_: Any, **__: Any) -> None:
        console.print(f"mtb-rs: {' '.join(str(message).split())}", style="yellow")

    with warnings.catch_warnings():
        warnings.simplefilter("default", UserWarning)
        setattr(warnings, "showwarning", show)  # noqa: B010 (whatever else it is called with)
        yield


def _one_line(error: Exception) -> str:
    return " ".join(str(error).split())


def _console(stream: TextIO, **options: Any) -> Console:
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


def _leave_standard_output() -> None:
    """What could not be printed, to a full disk or a closed pipe, is not tried again at the end."""
    try:
        sys.stdout.flush()
    except OSError:
        with contextlib.suppress(OSError, ValueError):
            nowhere = os.open(os.devnull, os.O_WRONLY)
            os.dup2(nowhere, sys.stdout.fileno())
            os.close(nowhere)


def _directory(options: argparse.Namespace) -> Path:
    """Where to write: as told, or a directory named as the case."""
    if options.output is not None:
        return path_of("DIR", os.fspath(options.output))
    name = options.case.stem.strip(". ")
    if not name:
        raise ValueError(f"{options.case} has no name to call a directory by: -o DIR is needed")
    return Path(name)


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="mtb-rs", description="Frictional elastic contact: magnetic track brakes, wheels on rails."
    )
    parser.add_argument("--version", action="version", version=f"mtb-rs {__version__}")
    commands = parser.add_subparsers(title="commands", metavar="COMMAND", required=True)
    run = commands.add_parser(
        "run",
        help="solve a case and write its results and pictures",
        description="Solves the scene of a case file, prints a report, and writes summary.json, the fields "
        "(NPZ, VTK) and pictures.",
    )
    run.add_argument("case", type=Path, metavar="CASE.toml")
    run.add_argument(
        "-o",
        "--output",
        type=Path,
        metavar="DIR",
        help="where to write (default: a directory named as the case, here)",
    )
    run.set_defaults(command=_run)
    show = commands.add_parser(
        "show",
        help="report on a saved result and draw it, without solving",
        description="Prints the report of a result that `mtb-rs run` or `result.save` has written, with its "
        "fields, and draws one of them where -o says so.",
    )
    show.add_argument("saved", type=Path, metavar="DIR")
    show.add_argument(
        "-o",
        "--output",
        type=Path,
        metavar="PICTURE",
        help="where to draw: .png, .svg, .pdf; of kind 3d .png or .html (a page to turn)",
    )
    show.add_argument("--quantity", metavar="Q", help="what is drawn (default: pressure)")
    show.add_argument("--kind", metavar="K", help="map, line or 3d (default: map)")
    show.set_defaults(command=_show)
    chart = commands.add_parser(
        "chart",
        help="chart speed against accuracy of all models and methods",
        description="Solves the scene of a case file by every model and method that applies, at several "
        "resolutions, and charts time against error: chart.png, chart.html (hover over it), chart.csv. "
        "The options of [solve] are not used.",
    )
    chart.add_argument("case", type=Path, metavar="CASE.toml")
    chart.add_argument(
        "-o",
        "--output",
        type=Path,
        metavar="DIR",
        help="where to write (default: a directory named as the case, here)",
    )
    chart.add_argument(
        "--budget",
        type=_seconds,
        default=60.0,
        metavar="SECONDS",
        help="time to spend (default: %(default)g)",
    )
    chart.add_argument(
        "--repeats",
        type=_repeats,
        default=3,
        metavar="N",
        help="solves of each point, of whose times the median counts (default: %(default)d)",
    )
    chart.add_argument(
        "--quantity", choices=QUANTITIES, default="pressure", help="whose error (default: %(default)s)"
    )
    chart.set_defaults(command=_chart)
    sweep = commands.add_parser(
        "sweep",
        help="solve a case for all combinations of some of its arguments",
        description="Solves the scene of a case file for all combinations of the values of --vary and writes "
        "sweep.csv and, where xarray is installed, sweep.nc. What is solved is kept in sweep.jsonl: the same "
        "command goes on where it was stopped; other values need another DIR.",
    )
    sweep.add_argument("case", type=Path, metavar="CASE.toml")
    sweep.add_argument(
        "--vary",
        action="append",
        required=True,
        type=_variation,
        metavar="KEY=VALUES",
        help="an argument of the scene with its values as in a case file: 0.1,0.3,0.5, words, or "
        "first:last:count; repeated for further arguments",
    )
    sweep.add_argument(
        "-j", "--jobs", type=_processes, default=None, metavar="N", help="processes (default: this one alone)"
    )
    sweep.add_argument(
        "-o",
        "--output",
        type=Path,
        metavar="DIR",
        help="where to write (default: a directory named as the case, here)",
    )
    sweep.set_defaults(command=_sweep)
    return parser


def _run(options: argparse.Namespace) -> int:
    from .case import load_case
    from .pictures.files import check_saveable

    console = _console(sys.stdout)
    directory = check_saveable(_directory(options))
    case = load_case(options.case)
    with console.status("solving ..."):
        clock = time.perf_counter()
        result = case.solve()
        elapsed = time.perf_counter() - clock
    with console.status("writing ..."), warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        written = result.save(directory)
    print_report(result, console, elapsed)
    for warning in caught:
        console.print(f"notice: {warning.message}", style="yellow", markup=False, soft_wrap=True)
    console.print(f"{len(written)} files in {directory}", markup=False, soft_wrap=True)
    return 0


def _show(options: argparse.Namespace) -> int:
    if options.output is None and (options.quantity or options.kind):
        raise ValueError("-o PICTURE is missing: it says where to draw")
    console = _console(sys.stdout)
    if options.output is not None:
        check_folder(options.output.parent)
    result = load(options.saved)
    if options.output is not None:
        from .pictures.files import draw_into

        draw_into(options.output, result, options.quantity or "pressure", options.kind)
    if "inputs" in result.facts():
        print_report(result, console)
    else:
        console.print(str(result), markup=False, soft_wrap=True)
        for total in result.totals().values():
            numbers = ", ".join(f"{value:.6g}" for value in np.atleast_1d(total.values))
            console.print(f"{total.label}: {numbers} {total.unit}".rstrip(" -"), markup=False, soft_wrap=True)
    table = Table(box=None, pad_edge=False, padding=(0, 2, 0, 0))
    for name in ("field", "unit"):
        table.add_column(name)
    for name in ("smallest", "largest"):
        table.add_column(name, justify="right")
    for field in result.fields().values():
        for word in field.words:
            part = field.part(word)
            body = "" if field.body is None else f" of the {field.body} body"
            ends = (f"{float(end):.5g}" for end in (part.values.min(), part.values.max()))
            table.add_row(word.replace("_", " ") + body, part.unit, *ends)
    console.print(table, markup=False)
    if options.output is not None:
        console.print(f"drawn in {options.output}", markup=False, soft_wrap=True)
    return 0


def _chart(options: argparse.Namespace) -> int:
    from .case import load_case
    from .results.chart import check_saveable

    console = _console(sys.stdout)
    directory = check_saveable(_directory(options))
    scene = load_case(options.case).scene()
    with Progress(TextColumn("{task.description}"), BarColumn(), console=console, transient=True) as bar:
        task = bar.add_task("charting ...", total=1.0)
        chart = scene.chart(
            options.quantity,
            options.budget,
            options.repeats,
            lambda share, doing: bar.update(task, completed=share, description=doing),
        )
    own = "" if not chart.reference_error else f", its own error about {100.0 * chart.reference_error:.2g} %"
    console.print(f"against: {chart.reference}{own}", markup=False, soft_wrap=True)
    table = Table(box=None, pad_edge=False, padding=(0, 2, 0, 0))
    table.add_column("efficient")
    for name in ("points", "processor [s]", f"error of the {chart.quantity} [%]"):
        table.add_column(name, justify="right")
    for point in chart.efficient():
        error = 100.0 * point.errors[chart.quantity]
        table.add_row(point.series, str(point.unknowns), f"{point.time:.3g}", f"{error:.3g}")
    console.print(table, markup=False)
    for series in dict.fromkeys(p.series for p in chart.points if p.failure):
        failure = next(p.failure for p in chart.points if p.series == series and p.failure)
        console.print(f"failed: {series}: {failure}", style="yellow", markup=False, soft_wrap=True)
    written = chart.save(directory)
    console.print(f"{len(written)} files in {directory}", markup=False, soft_wrap=True)
    return 0


def _variation(text: str) -> tuple[str, list[Any]]:
    """KEY=VALUES of the command line: numbers between commas, words, or first:last:count."""
    key, equals, values = text.partition("=")
    if not equals or not key or not values:
        raise argparse.ArgumentTypeError(f"{text!r}: KEY=VALUES is needed, for example friction=0.1,0.3")
    key = key.strip()
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


def _meant(case: Case, key: str, values: list[Any]) -> Any:
    """The values of --vary as a case file means them, by their words."""
    if key not in case.arguments() or len(set(values)) < len(values):
        return values
    return {value: case.argument(key, value) for value in values}


def _processes(text: str) -> int:
    if not text.strip().isdecimal() or not text.strip().lstrip("0"):
        raise argparse.ArgumentTypeError(f"{shortened(text)}: a whole number from 1 on is needed")
    most = most_processes()
    if len(text) > 9 or int(text) > most:
        raise argparse.ArgumentTypeError(
            f"{shortened(text)}: at most {most} processes, four for each processor, are started"
        )
    return int(text)


def _seconds(text: str) -> float:
    value = _value(text)
    if isinstance(value, str) or not 0.0 < value <= LONGEST_BUDGET:
        raise argparse.ArgumentTypeError(
            f"{shortened(text)}: seconds up to {LONGEST_BUDGET:g}, a week, are needed"
        )
    return float(value)


def _repeats(text: str) -> int:
    if not text.strip().isdecimal() or len(text) > 9 or not 1 <= int(text) <= MOST_REPEATS:
        raise argparse.ArgumentTypeError(
            f"{shortened(text)}: a whole number from 1 to {MOST_REPEATS} is needed"
        )
    return int(text)


def _check_sweep_saveable(directory: Path) -> Path:
    """The directory, if what is replaced there is a sweep's, as its table or its checkpoint tells."""
    check_folder(directory)
    table = directory / "sweep.csv"
    is_own = (directory / "sweep.jsonl").exists()
    if not is_own and table.is_file():
        is_own = "status" in read_text(table, "table", DATA).partition("\n")[0].strip().split(",")
    for path in (table, directory / "sweep.nc"):
        if os.path.lexists(path) and not is_own:
            raise ValueError(
                f"{path} is there already, and no earlier sweep has written it: it would be overwritten; "
                "move it, or write into another directory"
            )
    return directory


def _sweep(options: argparse.Namespace) -> int:
    from .case import load_case
    from .studies.sweeps import sweep

    console = _console(sys.stdout)
    directory = _check_sweep_saveable(_directory(options))
    varied = [key for key, _ in options.vary]
    if len(set(varied)) < len(varied):
        twice = next(key for key in varied if varied.count(key) > 1)
        raise ValueError(f"--vary {twice}= is there twice: give all its values at once")
    case = load_case(options.case)
    parameters = {key: _meant(case, key, values) for key, values in options.vary}
    solving: Any = getattr(case, "solve_options")  # noqa: B009 (a field of the model of this case)
    with Progress(*Progress.get_default_columns(), MofNCompleteColumn(), console=console) as bar:
        task = bar.add_task("solving", total=None)
        table = sweep(
            case.scene(),
            parameters,
            executor=options.jobs,
            checkpoint=directory / "sweep.jsonl",
            progress=lambda done, total: bar.update(task, completed=done, total=total),
            **dict(solving),
        )
    written = [directory / "sweep.csv"]
    table.to_csv(written[0])
    try:
        table.to_netcdf(directory / "sweep.nc")
        written.append(directory / "sweep.nc")
    except ImportError as error:
        console.print(f"notice: no netCDF: {error}", style="yellow", markup=False, soft_wrap=True)
    for values, reason in table.failures:
        where = ", ".join(f"{k} = {v}" for k, v in values.items())
        console.print(f"{where}: {reason}", style="yellow", markup=False, soft_wrap=True)
    solved = len(table) - len(table.failures)
    console.print(f"{solved} of {len(table)} cases solved; {', '.join(map(str, written))}", markup=False)
    return 0 if solved else NO_SOLUTION


def print_report(result: Result, console: Console, elapsed: float | None = None) -> None:
    """A short report: what was solved, what carries what, how well, how long it took, if that is known."""
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


if __name__ == "__main__":
    sys.exit(main())
