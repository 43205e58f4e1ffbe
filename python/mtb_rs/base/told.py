# SPDX-License-Identifier: MIT OR Apache-2.0
"""Things told in rows of a name and its words: on a terminal, and as a table with a picture in a notebook."""

from __future__ import annotations

import base64
import html
from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np

#: A name and what is to be said of it.
Row = tuple[str, str]
#: Most rows of a table in a notebook, most signs of a stated value, the largest picture there [pixels].
MOST_ROWS, MOST_SIGNS, WIDTH, HEIGHT = 40, 160, 640, 600
#: Most numbers of an array that are listed in a row.
MOST_NUMBERS = 12


class Told:
    """What shows itself in a notebook as a table, beside a picture if it has one."""

    def told(self) -> list[Row]:
        """Its figures in words, each with its name: what a notebook and the command line show."""
        raise NotImplementedError

    def _repr_png_(self) -> bytes | None:
        """Its picture, if it has one."""
        return None

    def _repr_html_(self) -> str:
        """A table of what it tells, and its picture: for notebooks."""
        title = f"<b>{html.escape(type(self).__name__)}</b>"
        return f"<div>{title}{table_of(self.told())}{image_of(self._repr_png_())}</div>"


def image_of(picture: bytes | None) -> str:
    """A PNG in HTML, of the size that notebooks have room for; nothing for None."""
    if picture is None:
        return ""
    data = base64.b64encode(picture).decode()
    size = f"max-width:min(100%,{WIDTH}px);max-height:{HEIGHT}px"
    return f'<img alt="picture" style="{size}" src="data:image/png;base64,{data}">'


def table_of(rows: Iterable[Iterable[str]], heading: Iterable[str] = ()) -> str:
    """Rows of text as a table in HTML, cut after the first ones."""
    listed = [list(row) for row in rows]
    lines = [
        "<tr>" + "".join(f'<td style="text-align:left">{html.escape(cell)}</td>' for cell in row) + "</tr>"
        for row in listed[:MOST_ROWS]
    ]
    if len(listed) > MOST_ROWS:
        lines.append(f"<tr><td>and {len(listed) - MOST_ROWS} more</td></tr>")
    head = "".join(f'<th style="text-align:left">{html.escape(name)}</th>' for name in heading)
    return f"<table>{f'<tr>{head}</tr>' if head else ''}{''.join(lines)}</table>"


def in_words(values: Any, unit: str = "") -> str:
    """Numbers with their unit; what is rounding beside the largest is zero."""
    array = np.atleast_1d(np.asarray(values, dtype=float))
    size = float(np.abs(array).max(initial=0.0))
    numbers = ", ".join(f"{0.0 if abs(value) < 1e-12 * size else value:.6g}" for value in array)
    return f"{numbers} {unit}".removesuffix(" 1").rstrip()


def along(values: Any, unit: str) -> str:
    """A vector (3,) by its components."""
    parts = in_words(values).split(", ")
    return ", ".join(f"{axis} {part}" for axis, part in zip("xyz", parts, strict=False)) + f" {unit}"


def length(value: float) -> str:
    """A length [m] in the unit that suits it."""
    small = abs(value) < 1e-3
    return f"{value * 1e6:.5g} \N{MICRO SIGN}m" if small else f"{value * 1e3:.5g} mm"


def stated(given: Mapping[str, Any], units: Mapping[str, str] | None = None) -> list[Row]:
    """Names with their values and units, each in one line."""
    rows = []
    for name, value in given.items():
        is_number = isinstance(value, (int, float, tuple)) and not isinstance(value, bool)
        unit = (units or {}).get(name, "") if is_number else ""
        words = f"{_plainly(value)} {unit if unit not in ('1', '-') else ''}".rstrip()
        rows.append(
            (name.replace("_", " "), words if len(words) <= MOST_SIGNS else words[: MOST_SIGNS - 3] + "...")
        )
    return rows


def _plainly(value: Any) -> str:
    if isinstance(value, bool) or value is None:
        return {True: "yes", False: "no", None: "none"}[value]
    if isinstance(value, (int, float, np.floating)):
        return f"{value:.6g}"
    if isinstance(value, Mapping):
        return ", ".join(f"{name.replace('_', ' ')}: {_plainly(part)}" for name, part in value.items())
    if isinstance(value, np.ndarray) and value.ndim and value.size > MOST_NUMBERS:
        return f"{' x '.join(map(str, value.shape))} values"
    if isinstance(value, (list, tuple, np.ndarray)):
        return ", ".join(_plainly(part) for part in value)
    return value if isinstance(value, str) else " ".join(repr(value).split())
