# SPDX-License-Identifier: MIT OR Apache-2.0
"""Fields on one grid, the finite-element references, and the thesis' measures of error."""

from __future__ import annotations

import csv
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

import mtb_rs as mtb

Array = NDArray[np.float64]
ROOT = Path(__file__).resolve().parents[2]
DATA = ROOT / "tests" / "data" / "fe"

#: Of the mean reference pressure: points below it are counted, not compared.
SOLID = 0.1


@dataclass(frozen=True)
class Field:
    """Pressure [Pa] and vertical displacement [m] of the upper body, (ny, nx), over x and y [m].

    Its points are nodes, the outermost on the edge of the contact, or centres of cells. The
    gap [m] (ny, nx) is known for own results.
    """

    label: str
    x: Array
    y: Array
    pressure: Array
    displacement: Array
    at_nodes: bool = True
    gap: Array | None = None

    def borders(self) -> tuple[Array, Array]:
        """Where the areas of the columns and rows end [m]."""
        both = []
        for points in (self.x, self.y):
            middle = 0.5 * (points[1:] + points[:-1])
            first, last = points[[0, -1]] if self.at_nodes else 2 * points[[0, -1]] - middle[[0, -1]]
            both.append(np.concatenate([[first], middle, [last]]))
        return both[0], both[1]

    def at(self, values: Array, x: Array, y: Array) -> Array:
        """`values` (ny, nx) at the grid of `x` and `y`, linear between points."""
        along = np.array([np.interp(x, self.x, row) for row in values])
        return np.array([np.interp(y, self.y, column) for column in along.T]).T

    def cut(self, values: Array, y: float) -> Array:
        """`values` along x at one `y` [m]."""
        return self.at(values, self.x, np.array([y]))[0]


def of_result(result: mtb.Result, label: str, patch: int = 0) -> Field:
    """One patch of a result; the vertical displacement is that of the upper body, rigid motion included.

    The staggered loop has no displacement of its own for it, having two bodies in the place of one: there
    it is the lower body's plus the change of the gap.
    """
    grid = result.patches[patch]
    n = result.pressure.size
    x, y = grid.view(result.points.reshape(3, n)[0])[0], grid.view(result.points.reshape(3, n)[1])[:, 0]
    up = result.displacement.upper.reshape(3, n)[2]
    if result.report.method == "staggered":
        opened = (result.gap - result.initial_gap).reshape(n) * result.normal.reshape(3, n)[2]
        up = result.displacement.lower.reshape(3, n)[2] + opened
    up = grid.view(up)
    cells = result.model == "half-space"
    if cells:
        up = up - np.broadcast_to(result.approach, len(result.patches))[patch]
    pressure, gap = (grid.view(v.reshape(n)) for v in (result.pressure, result.gap))
    return Field(label, x, y, pressure, up, not cells, gap)


def of_finite_elements(name: str, label: str) -> Field:
    """A reference of tests/data/fe: mean pressure by node, displacement of the upper body.

    References are halves: a block's is completed by its mirror image, a shoe has its left pole.
    """
    table = np.genfromtxt(DATA / f"{name}_contact.csv.gz", delimiter=",", names=True)
    x, y = (np.unique(np.round(table[c], 7)) for c in "xy")
    place = np.searchsorted(y, np.round(table["y"], 7)), np.searchsorted(x, np.round(table["x"], 7))
    pressure, displacement = np.empty((y.size, x.size)), np.empty((y.size, x.size))
    pressure[place], displacement[place] = table["p_lump"], table["uz_s"]
    if y[0] == 0.0:
        y = np.concatenate([-y[:0:-1], y])
        pressure, displacement = (np.concatenate([v[:0:-1], v]) for v in (pressure, displacement))
    return Field(label, x, y, pressure, displacement)


@dataclass(frozen=True)
class Errors:
    """Mean of |difference| / |reference| over inner points, thesis 3.1.2.

    Attributes
    ----------
    pressure, displacement : float [-]
    tilt : float [-]
        Of the displacement without its mean, over the mean size of the reference's.
    compared, excluded : int
        Inner points used for the pressure, and those whose reference pressure is below `SOLID` of the mean.
    """

    pressure: float
    displacement: float
    tilt: float
    compared: int
    excluded: int


def errors(field: Field, reference: Field, border: int = 1) -> Errors:
    """Errors at the points of `field` but for its `border` outermost rows."""
    inner = (slice(border, -border),) * 2
    p_ref, u_ref = (
        reference.at(v, field.x, field.y)[inner] for v in (reference.pressure, reference.displacement)
    )
    p, u = field.pressure[inner], field.displacement[inner]
    solid = p_ref > SOLID * reference.pressure.mean()
    apart = (u - u.mean()) - (u_ref - u_ref.mean())
    return Errors(
        pressure=float(np.mean(np.abs(p - p_ref)[solid] / p_ref[solid])),
        displacement=float(np.mean(np.abs(u - u_ref) / np.abs(u_ref))),
        tilt=float(np.mean(np.abs(apart)) / np.mean(np.abs(u_ref))),
        compared=int(solid.sum()),
        excluded=int((~solid).sum()),
    )


def write_table(path: Path, header: Sequence[str], rows: Iterable[Sequence[Any]]) -> None:
    """A CSV table; floats to five digits."""
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow(header)
        for row in rows:
            writer.writerow([f"{v:.5g}" if isinstance(v, float) else v for v in row])
