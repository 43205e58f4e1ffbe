# SPDX-License-Identifier: MIT OR Apache-2.0
"""Friction and magnetic pressure as they are measured or computed elsewhere: on a grid over x and y."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..base.check import path_of, reals
from ..base.files import read_text
from ..base.owning import owning
from ..base.plain import plain
from .fields import Asked, Form, VelocityTable, extent
from .tables import LENGTHS, VALUES, Column, Table, read_table

Array = NDArray[np.float64]

_COLUMNS = Column(["x"], LENGTHS), Column(["y"], LENGTHS), Column(["value"], VALUES)
#: A table that is so many times as wide as the contact is in another unit.
_WIDE = 100.0


@owning
@dataclass(frozen=True)
@plain
class FieldTable(Form):
    """A quantity tabulated over x and y, interpolated bilinearly.

    Parameters
    ----------
    x : (nx,) [m]
        Places along x in the scene, rising. They need not be evenly spaced.
    y : (ny,) [m]
        Places along y, rising.
    value : (ny, nx)
        The quantity at each place, x fastest. The table must cover the contact: a point outside of it is an
        error.
    """

    x: Array
    y: Array
    value: Array
    #: Where the table was read, and the line of each place (ny, nx); for messages.
    _file: tuple[Path, NDArray[np.int64]] | None = field(default=None, init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        put = object.__setattr__
        for axis in "xy":
            places = reals(f"{axis} of a field", getattr(self, axis), "m")
            if places.ndim != 1 or places.size < 2:
                raise ValueError(
                    f"{axis} of a field has shape {places.shape}: at least two places [m], (n{axis},), are "
                    "needed"
                )
            if np.any(falls := np.diff(places) <= 0.0):
                k = int(np.argmax(falls))
                raise ValueError(
                    f"{axis}[{k + 1}] of a field is {places[k + 1]:.6g} m after {places[k]:.6g} m: places "
                    "that rise are needed"
                )
            put(self, axis, places)
        value = reals("value of a field", self.value)
        if value.shape != (self.y.size, self.x.size):
            raise ValueError(
                f"value of a field has shape {value.shape}: (ny, nx) = ({self.y.size}, {self.x.size}), one "
                "value for each y and x, is needed"
            )
        put(self, "value", value)

    @classmethod
    def from_file(cls, path: str | Path) -> FieldTable:
        """Field from a CSV with three columns: x, y and the value there.

        A heading gives their order and units, for example ``x [mm],y [mm],pressure [MPa]``. Without a heading
        they are x [m], y [m] and the value in its SI unit. Further columns are ignored if the heading names
        "x", "y" and "value". The rows may come in any order, and there is one for each place of a grid.

        Parameters
        ----------
        path : str or Path
            Its columns are separated by blanks, commas or semicolons; comments begin with #, !, % or //.

        Raises
        ------
        ValueError
            If the file cannot be read, if a place of the grid is missing, or if one stands in it twice. The
            message names the line or the place.
        """
        table = read_table(path_of("path", path), _COLUMNS)
        x, y, value = table.values
        (xs, column), (ys, row) = (np.unique(axis, return_inverse=True) for axis in (x, y))
        if xs.size < 2 or ys.size < 2:
            raise ValueError(
                f"table {table.path} has {xs.size} places along x and {ys.size} along y: at least two of "
                "each are needed"
            )
        lines = np.zeros((ys.size, xs.size), dtype=np.int64)
        for k in range(x.size):
            earlier = lines[row[k], column[k]]
            if earlier:
                raise ValueError(
                    f"{table.place(k)}: {_named(table, x[k], y[k])} stands in line {earlier} too"
                )
            lines[row[k], column[k]] = table.lines[k]
        if (lines == 0).any():
            j, i = np.argwhere(lines == 0)[0]
            raise ValueError(
                f"table {table.path} has no row for {_named(table, xs[i], ys[j])}: a row for each of the "
                f"{xs.size} x {ys.size} places of its grid is needed"
            )
        grid = np.empty(lines.shape)
        grid[row, column] = value
        made = cls(xs, ys, grid)
        object.__setattr__(made, "_file", (table.path, lines))
        return made

    def values(self, asked: Asked) -> Array:
        """Values (n,) at the contact points, linear along x and y between the places around each."""
        asked.check_range(self.placed(asked.name))
        across, up = asked.points[:2]
        (i, s), (j, t) = self._between("x", across, asked), self._between("y", up, asked)
        below = (1.0 - s) * self.value[j, i] + s * self.value[j, i + 1]
        above = (1.0 - s) * self.value[j + 1, i] + s * self.value[j + 1, i + 1]
        return np.asarray((1.0 - t) * below + t * above)

    def _between(self, axis: str, at: Array, asked: Asked) -> tuple[NDArray[np.intp], Array]:
        """The place before each coordinate, and its share of the way to the next one."""
        places = getattr(self, axis)
        # a border of the contact may be that of the table
        spare = 1e-9 * (places[-1] - places[0])
        outside = (at < places[0] - spare) | (at > places[-1] + spare)
        if outside.any():
            k = int(np.argmax(outside))
            px, py = asked.points[:2, k]
            raise ValueError(
                f"{asked.name} is needed at x = {px:.6g} m, y = {py:.6g} m, outside of {self._called}, which "
                f"covers {extent(self.x, self.y)}: the contact points reach {extent(*asked.points[:2])}"
            )
        before = np.clip(np.searchsorted(places, at, side="right") - 1, 0, places.size - 2)
        share = np.clip((at - places[before]) / (places[before + 1] - places[before]), 0.0, 1.0)
        return before, share

    @property
    def has_places(self) -> bool:
        """Its places are some."""
        return True

    @property
    def _called(self) -> str:
        return "its table" if self._file is None else f"table {self._file[0]}"

    def placed(self, name: str) -> Iterator[tuple[str, float]]:
        """The least and the largest value."""
        for k in (int(self.value.argmin()), int(self.value.argmax())):
            j, i = divmod(k, self.x.size)
            place = f"{name} at x = {self.x[i]:.6g} m, y = {self.y[j]:.6g} m"
            if self._file is not None:
                place += f" (table {self._file[0]}, line {self._file[1][j, i]} of the file)"
            yield place, float(self.value[j, i])

    def doubts(self, asked: Asked) -> Iterator[str]:
        """Whether its places are in another unit."""
        for axis, places, at in (("x", self.x, asked.points[0]), ("y", self.y, asked.points[1])):
            if np.ptp(places) > _WIDE * np.ptp(at) > 0.0:
                yield (
                    f"{asked.name} is tabulated from {axis} = {places[0]:.6g} to {places[-1]:.6g} m, more "
                    f"than {_WIDE:g} times as far as the contact reaches: lengths are in metres, and the "
                    f"heading of a file states others ({axis} [mm])"
                )


def _named(table: Table, x: float, y: float) -> str:
    return f"x = {table.told(0, x)}, y = {table.told(1, y)}"


def table_from_file(path: Path) -> Any:
    """The table in a file: over x and y if its heading names both, else over the velocity."""
    for line in read_text(path, "table").splitlines():
        if {"x", "y"} <= set(re.findall(r"[^\W\d_]+", line.lower())):
            return FieldTable.from_file(path)
        if re.match(r'\s*["\']?[-+.]?\d', line):
            break
    return VelocityTable.from_file(path)
