# SPDX-License-Identifier: MIT OR Apache-2.0
"""``mtb-rs show``: report on a saved result and draw it, without solving."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import get_args

from rich.table import Table

from ..base.files import check_folder
from ..base.units import MEASURED_UNITS
from ..base.words import Field, Flat, Space, Stress
from ..contact.sliding_start import CURVES
from ..results.saved import load
from .arguments import offer
from .console import console_on, print_report


def add(commands: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """The command among the others."""
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
    quantity = show.add_argument("--quantity", metavar="Q", help="what is drawn (default: pressure)")
    offer(quantity, lambda _: (*get_args(Field), *get_args(Stress), *CURVES, *MEASURED_UNITS))
    kind = show.add_argument("--kind", metavar="K", help="map, line or 3d (default: map)")
    offer(kind, lambda _: (*get_args(Flat), *get_args(Space)))
    show.set_defaults(command=_show)


def _show(options: argparse.Namespace) -> int:
    if options.output is None and (options.quantity or options.kind):
        raise ValueError("-o PICTURE is missing: it says where to draw")
    console = console_on(sys.stdout)
    if options.output is not None:
        check_folder(options.output.parent)
    result = load(options.saved)
    if options.output is not None:
        from ..pictures.files import draw_into

        draw_into(options.output, result, options.quantity, options.kind)
    print_report(result, console)
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
    if table.row_count:
        console.print(table, markup=False)
    if options.output is not None:
        console.print(f"drawn in {options.output}", markup=False, soft_wrap=True)
    return 0
