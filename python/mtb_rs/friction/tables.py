# SPDX-License-Identifier: MIT OR Apache-2.0
"""Tables in files: their columns, in SI units, with the places where they stand."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from .. import _mtb_rs
from ..base.files import read_text

#: SI units per unit, by the names that headings have for it; the first one is the unit without a heading.
SPEEDS = {"m/s": 1.0, "mm/s": 1e-3, "mph": 0.44704, "ft/s": 0.3048, "knots": 1852.0 / 3600.0}
SPEEDS |= dict.fromkeys(("km/h", "kmh", "kph", "kmph", "km/hr"), 1.0 / 3.6)
LENGTHS = {"m": 1.0, "mm": 1e-3, "cm": 1e-2, "um": 1e-6, "µm": 1e-6, "μm": 1e-6, "in": 0.0254, "ft": 0.3048}
VALUES = {"-": 1.0, "1": 1.0, "%": 1e-2, "‰": 1e-3, "percent": 1e-2, "per cent": 1e-2, "permille": 1e-3}
VALUES |= {"Pa": 1.0, "kPa": 1e3, "MPa": 1e6, "GPa": 1e9, "bar": 1e5}
VALUES |= dict.fromkeys(("N/m2", "N/m²", "N/m^2"), 1.0)
VALUES |= dict.fromkeys(("N/mm2", "N/mm²", "N/mm^2"), 1e6)


@dataclass(frozen=True)
class Column:
    """A column that a table must have: what headings call it, and its units, the usual one first."""

    names: Sequence[str]
    units: dict[str, float]


@dataclass(frozen=True)
class Table:
    """Columns of a file.

    Attributes
    ----------
    path : Path
    values : (k, n)
        In SI units.
    lines : (n,)
        The line of each row, counted from 1.
    columns : sequence of Column
    factors : (k,)
        SI units per unit of each column; None where the heading states none.
    """

    path: Path
    values: NDArray[np.float64]
    lines: Sequence[int]
    columns: Sequence[Column]
    factors: Sequence[float | None]

    def place(self, row: int) -> str:
        """Where a row stands."""
        return f"table {self.path}, line {self.lines[row]} of the file"

    def told(self, column: int, value: float) -> str:
        """A value [SI] in the unit of its column."""
        factor = self.factors[column] or 1.0
        unit = next(name for name, size in self.columns[column].units.items() if size == factor)
        return f"{value / factor:.6g} {unit}"


def read_table(path: Path, columns: Sequence[Column]) -> Table:
    """The columns of a file; the last one may have any name, if there are no others.

    Raises
    ------
    ValueError
        If the file cannot be read; the message names it and the line.
    """
    text = read_text(path, "table")
    names, units = [list(c.names) for c in columns], [list(c.units.items()) for c in columns]
    try:
        values, lines, factors = _mtb_rs.read_columns(text, names, units)
    except ValueError as error:
        raise ValueError(f"table {path}, {error}") from None
    return Table(path, values, lines, columns, factors)
