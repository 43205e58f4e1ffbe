# SPDX-License-Identifier: MIT OR Apache-2.0
"""The labelled table that a sweep returns."""

from __future__ import annotations

import csv
import html
import io
import os
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from ..base.files import DATA, read_text, write_bytes
from ..base.owning import owning
from ..base.plain import plain
from ..base.stored import stored
from ..base.told import Row, image_of, in_words, table_of
from ..base.units import unit_of_argument
from .doors import pictures, png
from .study import Study

if TYPE_CHECKING:
    import pandas
    import xarray
    from matplotlib.axes import Axes  # noqa: TID251 (only for type checkers)
    from matplotlib.figure import Figure  # noqa: TID251 (only for type checkers)


#: Most failures and labels that a report lists.
MOST_FAILURES = 10
#: Share of the largest value of a column below which a change is rounding.
_ROUNDING = 1e-9


def argument_units(grid: Mapping[str, Mapping[Any, Any]]) -> dict[str, str]:
    """Units of arguments that have one, of a grid from names to labels to values: where labels are values."""
    return {
        name: unit_of_argument(name)
        for name, values in grid.items()
        if unit_of_argument(name)
        and all(
            isinstance(value, (int, float)) and not isinstance(value, bool) and value == label
            for label, value in values.items()
        )
    }


def check_column(name: Any) -> str:
    """`name` as that of a column: printable text without a slash, which netCDF does not take."""
    text = name if isinstance(name, str) else ""
    if not text or not text.isprintable() or "/" in text or text.strip(" .") != text:
        raise ValueError(f"{name!r} is no name of a column: printable text without slashes is needed")
    return text


@stored
@owning
@dataclass(frozen=True)
@plain
class SweepTable(Study):
    """Quantities over the grid of the parameters of a sweep.

    ``table["force_x"]`` is an array with one axis for each parameter, in their order. It is NaN for a case
    without a solution, whose reason is in `status`.

    Attributes
    ----------
    parameters : Mapping of names to tuples
        The values of each parameter, or their labels if they are not numbers.
    columns : Mapping of names to arrays
    status : array of str
        "solved", or why not.
    attributes : Mapping
        The model and the scene.
    units : Mapping of names to units
        Units of the columns, and of the parameters that are numbers with a unit; labels have none.
    """

    usual_name: ClassVar[str] = "sweep"
    called: ClassVar[str] = "sweep"
    endings: ClassVar[tuple[str, ...]] = ("csv", "nc")

    parameters: Mapping[str, tuple[Any, ...]]
    columns: Mapping[str, NDArray[np.float64]]
    status: NDArray[np.str_]
    attributes: Mapping[str, str]
    units: Mapping[str, str] = field(default_factory=dict)

    def __getitem__(self, name: str) -> NDArray[np.float64]:
        if name not in self.columns:
            raise KeyError(f"{name!r}: the sweep has {', '.join(self.columns)}")
        return self.columns[name]

    def __len__(self) -> int:
        return int(self.status.size)

    def __repr__(self) -> str:
        grid = " x ".join(f"{len(v)} {k}" for k, v in self.parameters.items())
        return f"<SweepTable: {grid}, {len(self) - len(self.failures)} of {len(self)} solved>"

    @property
    def failures(self) -> list[tuple[dict[str, Any], str]]:
        """The cases without a solution, each with its reason."""
        return [(case, str(self.status[at])) for at, case in self._cases() if self.status[at] != "solved"]

    def rows(self) -> list[dict[str, float | str]]:
        """One row for each case: parameters, status, quantities."""
        return [
            {**case, "status": str(self.status[at])} | {k: float(v[at]) for k, v in self.columns.items()}
            for at, case in self._cases()
        ]

    def to_csv(self, path: str | os.PathLike[str]) -> None:
        """Writes the rows; the heading names the columns, with units. OSError if nothing can be written."""
        write_bytes(path, self._csv())

    def _csv(self) -> bytes:
        rows = self.rows()
        stream = io.StringIO(newline="")
        writer = csv.writer(stream)
        writer.writerow(
            [f"{k} [{self.units[k]}]" if k in self.columns and k in self.units else k for k in rows[0]]
        )
        writer.writerows([["" if v != v else v for v in row.values()] for row in rows])
        return stream.getvalue().encode()

    def exports(self) -> tuple[dict[str, bytes], list[str]]:
        """The table as CSV, and as netCDF-4 where xarray is installed."""
        try:
            return {"csv": self._csv(), "nc": self._netcdf()}, []
        except ImportError as error:
            return {"csv": self._csv()}, [f"no netCDF: {error}"]

    @classmethod
    def wrote(cls, folder: Path, name: str) -> bool:
        """Whether a checkpoint stands beside it, or the table is that of a sweep: 0.1.0 wrote no record."""
        if (folder / f"{name}.jsonl").exists():
            return True
        table = folder / f"{name}.csv"
        if not table.is_file():
            return False
        return "status" in read_text(table, "table", DATA).partition("\n")[0].strip().split(",")

    def check(self) -> None:
        """Checks that what was read from files fits together; ValueError if it does not."""
        shape = tuple(len(values) for values in self.parameters.values())
        for name, values in {**self.columns, "status": self.status}.items():
            if values.shape != shape:
                raise ValueError(f"{name} has the shape {values.shape}: {shape} is needed")

    def told(self) -> list[Row]:
        """Its parameters and columns in words."""
        rows = [(name, self._ranged(name, values)) for name, values in self.parameters.items()]
        rows += [(name, self._ranged(name, values.ravel())) for name, values in self.columns.items()]
        rows = [(name.replace("_", " "), words) for name, words in rows]
        rows.append(("solved", f"{len(self) - len(self.failures)} of {len(self)} cases"))
        for case, reason in self.failures[:MOST_FAILURES]:
            where = ", ".join(f"{name} = {value}" for name, value in case.items())
            rows.append(("not solved", f"{where}: {reason}"))
        if len(self.failures) > MOST_FAILURES:
            rows.append(("", f"and {len(self.failures) - MOST_FAILURES} more"))
        return rows

    def _ranged(self, name: str, values: Any) -> str:
        """Numbers by their range, with their unit; labels one by one."""
        count = f"{len(values)} values" if name in self.parameters else ""
        if not all(isinstance(v, (int, float, np.number)) and not isinstance(v, bool) for v in values):
            labels = ", ".join(map(str, values[:MOST_FAILURES]))
            return f"{count}: {labels}{', ...' if len(values) > MOST_FAILURES else ''}"
        finite = [float(v) for v in values if np.isfinite(v)]
        if not finite:
            return count or "none"
        low, high = min(finite), max(finite)
        ends = in_words(low) if low == high else f"{in_words(low)} to {in_words(high)}"
        told = f"{ends} {self.units.get(name, '')}".removesuffix(" 1").rstrip()
        return f"{count}, {told}" if count else told

    def _repr_png_(self) -> bytes | None:
        """The picture of its peak pressure, for notebooks; None where there are no lines to draw."""
        first = next(iter(self.parameters.values()))
        is_line = len(first) > 1 and all(isinstance(value, (int, float)) for value in first)
        if not is_line or not np.isfinite(self.columns.get("peak_pressure", np.array([]))).any():
            return None
        with pictures().own_figures():
            return png(self.plot())

    def _repr_html_(self) -> str:
        """Its rows and its picture, for notebooks: without the columns that do not change."""
        rows = self.rows()
        kept = [name for name in rows[0] if name in self.parameters or self._changes(name)]
        heading = [f"{name} [{self.units[name]}]" if name in self.units else name for name in kept]
        cells = [[f"{v:.6g}" if isinstance(v, float) else str(v) for v in map(row.get, kept)] for row in rows]
        left_out = [name for name in rows[0] if name not in kept and name != "status"]
        note = f"<div>the same in all cases: {html.escape(', '.join(left_out))}</div>" if left_out else ""
        table = f'<div style="overflow-x:auto">{table_of(cells, heading)}</div>'
        return f"<div>{table}{note}{image_of(self._repr_png_())}</div>"

    def _changes(self, name: str) -> bool:
        """Whether a column differs from case to case by more than rounding."""
        if name == "status":
            return bool(self.failures)
        values = self.columns[name]
        finite = values[np.isfinite(values)]
        if finite.size < values.size:
            return finite.size > 0
        # what is nothing but rounding beside the forces
        force = self.columns.get("normal_force", finite) if self.units.get(name) in ("N", "N m") else finite
        least = _ROUNDING * max(np.abs(finite).max(), 1e-3 * float(np.nanmax(np.abs(force))))
        return bool(np.ptp(finite) > least)

    def plot(self, quantity: str = "peak_pressure", *, ax: Axes | None = None) -> Figure:
        """Draws one quantity over the first parameter, a line for each value of the others.

        Parameters
        ----------
        quantity : str
            One of the columns. Cases without a solution leave a gap.
        ax : matplotlib.axes.Axes
            Axes to draw into, in place of a new figure.

        Returns
        -------
        matplotlib.figure.Figure
        """
        figure: Figure = pictures().draw_sweep(self, quantity, ax)
        return figure

    def to_pandas(self) -> pandas.DataFrame:
        """The rows as a :class:`pandas.DataFrame` (extra ``sweep``); units are its ``attrs["units"]``."""
        try:
            import pandas
        except ImportError as error:
            raise ImportError("pandas is missing: pip install 'mtb-rs[sweep]'") from error
        frame = pandas.DataFrame(self.rows())
        frame.attrs = {**self.attributes, "units": dict(self.units)}
        return frame

    def to_xarray(self) -> xarray.Dataset:
        """The table as an :class:`xarray.Dataset` (extra ``sweep``)."""
        try:
            import xarray
        except ImportError as error:
            raise ImportError("xarray is missing: pip install 'mtb-rs[sweep]'") from error
        names = list(self.parameters)
        data = {
            name: xarray.Variable(names, values, self._unit(name)) for name, values in self.columns.items()
        }
        data["status"] = xarray.Variable(names, self.status.astype(str))
        coordinates = {}
        for name, values in self.parameters.items():
            coordinates[name] = xarray.Variable(name, _coordinate(values), self._unit(name))
        return xarray.Dataset(data, coordinates, dict(self.attributes))

    def to_netcdf(self, path: str | os.PathLike[str]) -> None:
        """Writes the table as netCDF-4 (extra ``sweep``). OSError if nothing can be written."""
        write_bytes(path, self._netcdf())

    def _netcdf(self) -> bytes:
        table = self.to_xarray()
        try:
            import h5netcdf  # noqa: F401
        except ImportError as error:
            raise ImportError("h5netcdf is missing: pip install 'mtb-rs[sweep]'") from error
        # made in memory: HDF5 itself ends the process on a full disk
        stream = io.BytesIO()
        table.to_netcdf(stream, engine="h5netcdf")
        return stream.getvalue()

    def _unit(self, name: str) -> dict[str, str]:
        """As xarray and pint-xarray note the unit of a column or parameter."""
        return {"units": self.units[name]} if name in self.units else {}

    def _cases(self) -> Iterator[tuple[tuple[int, ...], dict[str, Any]]]:
        for at in np.ndindex(self.status.shape):
            yield at, {k: v[i] for (k, v), i in zip(self.parameters.items(), at, strict=True)}


def _coordinate(values: tuple[Any, ...]) -> NDArray[Any]:
    """Numbers, or all as text: files know no mixture, and no number beyond 64 bits."""
    array = np.array(values)
    return array if array.dtype.kind in "biufU" else np.array([str(v) for v in values])
