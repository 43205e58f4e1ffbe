# SPDX-License-Identifier: MIT OR Apache-2.0
"""Pressure from the interpenetration of undeformed bodies: KPEC and ANALYN, quick and approximate."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from .. import _mtb_rs
from ..base.errors import ConvergenceError
from .ellipse import axis_ratio, curvatures, elliptic_integrals

Array = NDArray[np.float64]
Quick = Literal["kpec", "analyn"]

#: Share of the approach at which the undeformed bodies are cut by KPEC for the shape of the contact.
_CUT = 0.5
_SEVERAL = (
    "the undeformed bodies meet in more than one place: KPEC and ANALYN take a single contact; cut the gap "
    'between them, or take method="auto"'
)
#: Smallest curvature across the rolling direction over the one along it that ANALYN takes: Hertz' contact of
#: cylinders has no approach.
_FLATTEST = 1e-4
#: Relative error of the force at which the approach counts as found.
_BALANCED = 1e-10


class _TooSmallError(ValueError):
    """The grid is too small for the contact."""

    def __init__(self) -> None:
        super().__init__(
            "the contact reaches the side of the grid: a larger grid, or a smaller load, is needed"
        )


@dataclass(frozen=True)
class Pressed:
    """Pressure (ny, nx) [Pa] and displacement of both bodies together [m], at an approach [m]."""

    pressure: Array
    displacement: Array
    approach: float


def hertz(along: float, across: float) -> tuple[float, float, float]:
    """Semi-axes along x and y [m] and peak over contact modulus [-] of Hertz' contact at a unit approach.

    `along`, `across`: half the curvatures [1/m] of the gap, positive. All three grow with the root of the
    approach.
    """
    major = min(along, across)
    slim = axis_ratio(max(along, across) / major)
    first = elliptic_integrals(slim)[0]
    longer = math.sqrt(curvatures(slim)[0] / (major * first))
    shorter = slim * longer
    a, b = (shorter, longer) if along > across else (longer, shorter)
    return a, b, 1.0 / (shorter * first)


def press(
    gap: Array,
    spacing: tuple[float, float],
    modulus: float,
    force: float | None,
    approach: float | None,
    method: Quick,
) -> Pressed:
    """The pressure at a force [N] or an approach [m], between bodies of a contact modulus [Pa].

    Raises
    ------
    ValueError
        If the gap is none that the method takes.
    """
    rows = _Rows(gap, spacing)
    at: Callable[[float], Array] = rows.kpec if method == "kpec" else rows.analyn
    area = spacing[0] * spacing[1]
    base = float(gap.min())
    if approach is not None:
        depth = approach - base
        found = modulus * at(depth) if depth > 0.0 else np.zeros_like(gap)
    else:
        assert force is not None
        depth = _depth(lambda d: modulus * float(at(d).sum()) * area, force, rows.start(force / modulus))
        found = modulus * at(depth)
        found *= force / (float(found.sum()) * area)
    return Pressed(found, rows.moved(found) / modulus, depth + base)


def _depth(force_at: Callable[[float], float], force: float, start: float) -> float:
    """The approach above the least gap that carries the force, by false position on logarithms."""

    def miss(logarithm: float) -> float:
        try:
            carried = force_at(float(np.exp(logarithm)))
        except _TooSmallError:
            return np.inf
        return float(np.log(carried / force)) if carried > 0.0 else -np.inf

    low = high = float(np.log(start))
    below = above = miss(low)
    for _ in range(200):
        if below <= 0.0:
            break
        high, above, low = low, below, low - 0.2
        below = miss(low)
    for _ in range(200):
        if above >= 0.0:
            break
        low, below, high = high, above, high + 0.2
        above = miss(high)
    for _ in range(100):
        is_bounded = np.isfinite(below) and np.isfinite(above)
        share = float(np.clip(below / (below - above), 0.02, 0.98)) if is_bounded else 0.5
        middle = low + share * (high - low)
        value = miss(middle)
        if abs(value) <= _BALANCED:
            return float(np.exp(middle))
        if high - low <= 1e-14 * abs(high):
            if np.isinf(above):
                raise _TooSmallError
            return float(np.exp(middle))
        if value > 0.0:
            high, above = middle, value
        else:
            low, below = middle, value
    raise ConvergenceError(f"no approach was found for a force of {force:g} N", None)


class _Rows:
    """A gap row by row: the least of each by a parabola through three cells, its place and its curvature."""

    def __init__(self, gap: Array, spacing: tuple[float, float]) -> None:
        ny, nx = gap.shape
        if ny < 3 or nx < 3:
            raise ValueError(f"gap has shape {gap.shape}: at least 3 cells along x and along y are needed")
        self.spacing = dx, dy = spacing
        self.gap = gap - gap.min()
        self.x = (np.arange(nx) - 0.5 * (nx - 1)) * dx
        self.y = (np.arange(ny) - 0.5 * (ny - 1)) * dy
        # of a contact modulus of 1
        self.half_space = _mtb_rs.half_space((0.5, 0.0), [(self.x[0], self.y[0], nx, ny)], [spacing], True)
        lowest = np.clip(np.argmin(self.gap, axis=1), 1, nx - 2)
        every = np.arange(ny)
        behind, here, ahead = (self.gap[every, lowest + k] for k in (-1, 0, 1))
        bend = ahead - 2.0 * here + behind
        rise = 0.5 * (ahead - behind)
        shift = np.where(bend > 0.0, -rise / np.where(bend > 0.0, bend, 1.0), 0.0)
        shift = np.clip(shift, -0.5, 0.5)
        self.along = 0.5 * bend / dx**2
        self.middle = self.x[lowest] + shift * dx
        self.least = here + rise * shift + 0.5 * bend * shift**2
        self.first = divmod(int(np.argmin(self.gap)), nx)
        inner = self.least[2:] - 2.0 * self.least[1:-1] + self.least[:-2]
        self.across = np.concatenate([inner[:1], inner, inner[-1:]]) * 0.5 / dy**2
        unit = np.zeros_like(self.gap)
        unit[self.first] = 1.0
        # the displacement at the point of first contact by a unit on each cell
        self.at_first = self.moved(unit)
        row = self.first[0]
        if not self.along[row] > 0.0:
            raise ValueError(
                "gap does not grow along x on both sides of its least value: KPEC and ANALYN take a contact "
                "between bodies that are round along x"
            )
        rounds = np.where(self.along > 0.0, self.along, self.along[row])
        self.across_each = np.maximum(self.across, _FLATTEST * rounds)
        pairs = zip(rounds, self.across_each, strict=True)
        self.hertz_each = np.array([hertz(float(a), float(c)) for a, c in pairs]).T

    def start(self, load: float) -> float:
        """An approach near that of a load over the contact modulus [m2]: Hertz' on a sphere."""
        row = self.first[0]
        curvature = 2.0 * self.along[row]
        if self.across[row] > 0.0:
            curvature = 2.0 * float(np.sqrt(self.along[row] * self.across[row]))
        return float(np.cbrt((0.75 * load) ** 2 * curvature))

    def moved(self, pressure: Array) -> Array:
        """Displacement [m] by a pressure over the contact modulus."""
        traction = np.zeros((3, pressure.size))
        traction[2] = pressure.ravel()
        return np.asarray(self.half_space.displacement(traction)[2].reshape(pressure.shape))

    def kpec(self, approach: float) -> Array:
        """Pressure over the contact modulus, semi-elliptic along x with one steepness in all rows.

        The bodies are cut at half the approach; Hertz' contact of the ellipse of that cut tells by which
        parabola about its middle, across, the gap is to be lowered for Hertz' proportions.
        """
        cut = _CUT * approach
        row, _ = self.first
        left = self._crossing(cut, row, -1)
        right = self._crossing(cut, row, 1)
        met = (self.y < left) | (self.y > right)
        if (self.least[met] < cut).any():
            raise ValueError(_SEVERAL)
        self._check_rows(cut)
        middle, width = 0.5 * (left + right), 0.5 * (right - left)
        along, across = self.along[row], cut / width**2
        a, b, _ = (math.sqrt(approach) * v for v in hertz(along, across))
        rest = across - along * (a / b) ** 2
        corrected = self.gap - (rest * (self.y - middle) ** 2)[:, None]
        shape = self._semi_ellipses(corrected, along * a * a)
        # at the point of first contact the displacement is the approach
        return np.asarray(shape * (approach / float((self.at_first * shape).sum())))

    def analyn(self, approach: float) -> Array:
        """Pressure over the contact modulus, in each row that of Hertz' contact with the curvatures there."""
        self._check_rows(_CUT * approach)
        across, (a, b, peak) = self.across_each, np.sqrt(approach) * self.hertz_each
        # in Hertz' contact the gap is `across` times y^2
        square = a**2 - (a / b) ** 2 / across * self.least
        squares = square[:, None] - (self.x - self.middle[:, None]) ** 2
        return self._checked(np.sqrt(np.maximum(squares, 0.0)) * (peak / a)[:, None])

    def _check_rows(self, level: float) -> None:
        """Refuses bodies that meet twice along the rolling direction where they are cut at a level."""
        cut = np.pad(self.gap < level, ((0, 0), (1, 1))).astype(np.int8)
        if ((np.diff(cut, axis=1) == 1).sum(axis=1) > 1).any():
            raise ValueError(_SEVERAL)

    def _crossing(self, level: float, row: int, way: int) -> float:
        """Where the least gap of the rows grows beyond a level, up or down from a row."""
        k = row
        while 0 <= k + way < len(self.y):
            if self.least[k + way] > level:
                share = (level - self.least[k]) / (self.least[k + way] - self.least[k])
                return float(self.y[k] + way * max(share, 0.0) * self.spacing[1])
            k += way
        raise _TooSmallError

    def _semi_ellipses(self, gap: Array, level: float) -> Array:
        """The square root of l^2 - (x - m)^2 in each row, where the gap is below a level over 2 l about m."""
        dx = self.spacing[0]
        found = np.zeros_like(gap)
        for out, row in zip(found, gap, strict=True):
            inside = np.flatnonzero(row < level)
            if inside.size == 0:
                continue
            first, last = int(inside[0]), int(inside[-1])
            if first == 0 or last == len(row) - 1:
                raise _TooSmallError
            left = self.x[first] - dx * (level - row[first]) / (row[first - 1] - row[first])
            right = self.x[last] + dx * (level - row[last]) / (row[last + 1] - row[last])
            place = self.x - 0.5 * (left + right)
            out[:] = np.sqrt(np.maximum((0.5 * (right - left)) ** 2 - place**2, 0.0))
        return self._checked(found)

    def _checked(self, pressure: Array) -> Array:
        """One contact that ends inside of the grid, around the point of first contact."""
        touched = np.flatnonzero(pressure.any(axis=1))
        if touched.size and touched[-1] - touched[0] >= touched.size:
            raise ValueError(_SEVERAL)
        sides = (pressure[0], pressure[-1], pressure[:, 0], pressure[:, -1])
        if any(side.any() for side in sides):
            raise _TooSmallError
        return pressure
