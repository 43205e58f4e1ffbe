# SPDX-License-Identifier: MIT OR Apache-2.0
"""How good a discretised pressure is, from the same scene on coarser cells."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import NDArray

from ..base.plain import plain
from ..geometry.contact_points import Patch

Array = NDArray[np.float64]
Index = NDArray[np.intp]

#: Order at which pressures converge in the spacing, away from sharp edges.
ORDER = 1.0
#: Order at which those of waves inside a contact do.
SMOOTH_ORDER = 2.0


def coarsened(
    spacing: tuple[float, float], patches: Sequence[Patch], times: int = 2
) -> tuple[float, float] | None:
    """About `times` the `spacing`, but at least 3 cells a side; None where there is nothing to coarsen."""
    counts = (min(p.nx for p in patches), min(p.ny for p in patches))
    wider = [d * n / max(3, -(-n // times)) if n > 3 else d for d, n in zip(spacing, counts, strict=True)]
    return None if wider == list(spacing) else (wider[0], wider[1])


@dataclass(frozen=True)
@plain
class GridField:
    """A field on grids, made of hats or constant in cells, ready to be averaged over the points of others.

    Attributes
    ----------
    axes : sequence of (patch, x, y)
        The grids with the coordinates [m] of their columns and rows.
    means : (n,)
        At each point: average over its cell, or weighted with its hat.
    hats : (n,) or None
        Coefficients of the hats; None for cells.
    known : (n,) bool or None
        Points that have a value, where not all do: beside a body nothing is displaced.
    """

    axes: Sequence[tuple[Patch, Array, Array]]
    means: Array
    hats: Array | None = None
    known: NDArray[np.bool_] | None = None


def difference(fine: GridField, rough: GridField, *, skip_border: bool) -> float | None:
    """Relative L2 difference of two fields, as averages over the points of the rough one.

    With `skip_border` its outermost points are left out, where the pressure at a sharp edge is singular.
    """
    apart = size = 0.0
    values, kinds = fine.means if fine.hats is None else fine.hats, (rough.hats is None, fine.hats is None)
    for (patch, x, y), (coarse, x_coarse, y_coarse) in zip(fine.axes, rough.axes, strict=True):
        rows, columns = _averaging(y_coarse, y, kinds), _averaging(x_coarse, x, kinds)
        mean = rows @ patch.view(values) @ columns.T
        gap = mean - coarse.view(rough.means)
        # where the fine grid does not reach it says nothing
        gap[~rows.any(axis=1)] = 0.0
        gap[:, ~columns.any(axis=1)] = 0.0
        if fine.known is not None and rough.known is not None:
            # a mean over what has no value is none
            share = rows @ patch.view(fine.known.astype(float)) @ columns.T
            nowhere = ~coarse.view(rough.known) | (share < 1.0 - 1e-9)
            gap[nowhere] = mean[nowhere] = 0.0
        if skip_border:
            inner = tuple(slice(1, -1) if n > 2 else slice(None) for n in mean.shape)
            gap, mean = gap[inner], mean[inner]
        apart += float((gap**2).sum())
        size += float((mean**2).sum())
    return float(np.sqrt(apart / size)) if size > 0.0 else None


def waves(fine: GridField, rough: GridField) -> float:
    """Relative L2 size of the waves of a fine field on cells that are too short for the cells of a rough one.

    Averages over rough cells cannot tell them, and the rough solution has none of them. They are what
    straight lines between the averages leave of the field, inside the contact: at its border the field is
    steep, not wavy. Fields of hats have none.
    """
    if fine.hats is not None or rough.hats is not None:
        return 0.0
    short = size = 0.0
    for (patch, x, y), (_, x_coarse, y_coarse) in zip(fine.axes, rough.axes, strict=True):
        values = patch.view(fine.means)
        rows, columns = _averaging(y_coarse, y, (True, True)), _averaging(x_coarse, x, (True, True))
        mean = rows @ values @ columns.T
        size += float((mean**2).sum())
        if min(mean.shape) < 3:
            continue
        lines = _between(y, y_coarse) @ mean @ _between(x, x_coarse).T
        closed = np.pad(rows @ (values > 0.0) @ columns.T > 1.0 - 1e-9, 1)
        inside = sliding_window_view(closed, (3, 3)).all(axis=(2, 3))
        short += float((rows @ (values - lines) ** 2 @ columns.T)[inside].sum())
    return float(np.sqrt(short / size)) if size > 0.0 else 0.0


def _between(points: Array, onto: Array) -> Array:
    """Weights (points, onto) of straight lines between evenly spaced places `onto`, continued beyond them."""
    place = (points - onto[0]) / (onto[-1] - onto[0]) * (onto.size - 1)
    first = np.clip(np.floor(place).astype(np.intp), 0, onto.size - 2)
    weights, row = np.zeros((points.size, onto.size)), np.arange(points.size)
    weights[row, first], weights[row, first + 1] = 1.0 - (place - first), place - first
    return weights


def extrapolated(
    difference: float, fine: tuple[float, float], rough: tuple[float, float], order: float = ORDER
) -> float:
    """Error of the fine solution from its difference to the coarse one (Richardson)."""
    ratio = np.sqrt(rough[0] * rough[1] / (fine[0] * fine[1]))
    return float(difference / (ratio**order - 1.0))


def hat_means(points: Array, onto: Array) -> Array:
    """Weights (points, onto) of the means over the hats of `points` of a field linear between `onto`."""
    return _averaging(points, onto, (False, False))


def _averaging(points: Array, onto: Array, are_cells: tuple[bool, bool]) -> Array:
    """Weights (points, onto) that average a field over the cells, or with the hats, of other points.

    Parameters
    ----------
    points, onto : (m,), (n,) [m]
        Evenly spaced: those averaged at, and those the field is made of.
    are_cells : (bool, bool)
        Whether each of them are cells; otherwise nodes of hats.
    """
    ends = [_ends(points, are_cells[0]), _ends(onto, are_cells[1])]
    inside = [e[(e >= max(ends[0][0], ends[1][0])) & (e <= min(ends[0][-1], ends[1][-1]))] for e in ends]
    breaks = np.unique(np.concatenate([*inside, [max(e[0] for e in ends), min(e[-1] for e in ends)]]))
    # two Gauss points a piece integrate products of hats
    half = 0.5 * np.diff(breaks)
    middle = breaks[:-1] + half
    at = np.concatenate([middle - half / np.sqrt(3.0), middle + half / np.sqrt(3.0)])
    weight = np.concatenate([half, half])
    product = np.zeros((points.size, onto.size))
    total = np.zeros((points.size, 1))
    for row, tested in _basis(points, ends[0], at, are_cells[0]):
        np.add.at(total[:, 0], row, tested * weight)
        for column, value in _basis(onto, ends[1], at, are_cells[1]):
            np.add.at(product, (row, column), tested * value * weight)
    return np.asarray(np.divide(product, total, out=np.zeros_like(product), where=total > 0.0))


def _ends(points: Array, are_cells: bool) -> Array:
    """Where the functions of the points have their kinks or steps."""
    if not are_cells:
        return points
    if points.size == 1:
        return np.array([points[0] - 0.5e9, points[0] + 0.5e9])
    middle = 0.5 * (points[1:] + points[:-1])
    return np.concatenate([[2 * points[0] - middle[0]], middle, [2 * points[-1] - middle[-1]]])


def _basis(points: Array, ends: Array, at: Array, are_cells: bool) -> list[tuple[Index, Array]]:
    """Numbers and values of the functions that are not zero `at` places: of one cell, or two hats."""
    last = points.size - 1
    if are_cells:
        cell = np.searchsorted(ends, at, side="right") - 1
        return [(np.clip(cell, 0, last), ((cell >= 0) & (cell <= last)).astype(float))]
    place = (at - points[0]) / (points[-1] - points[0]) * last
    first = np.floor(place).astype(np.intp)
    found = []
    for hat in (first, first + 1):
        value = np.where((hat >= 0) & (hat <= last), np.maximum(1.0 - np.abs(place - hat), 0.0), 0.0)
        found.append((np.clip(hat, 0, last), value))
    return found
