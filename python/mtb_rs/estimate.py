# SPDX-License-Identifier: MIT OR Apache-2.0
"""How good a discretised pressure is, from the same scene on coarser cells."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from .result import Patch

Array = NDArray[np.float64]

#: Order at which pressures converge in the spacing, away from sharp edges.
ORDER = 1.0


def coarsened(spacing: tuple[float, float], patches: Sequence[Patch]) -> tuple[float, float] | None:
    """About twice the `spacing`, but at least 3 cells a side; None where there is nothing to coarsen."""
    counts = (min(p.nx for p in patches), min(p.ny for p in patches))
    wider = [d * n / max(3, -(-n // 2)) if n > 3 else d for d, n in zip(spacing, counts, strict=True)]
    return None if wider == list(spacing) else (wider[0], wider[1])


def difference(
    fine: Sequence[tuple[Patch, Array, Array]],
    rough: Sequence[tuple[Patch, Array, Array]],
    pressures: tuple[Array, Array],
    *,
    skip_border: bool,
) -> float | None:
    """Relative L2 difference of two pressures, as averages over the coarse cells.

    Parameters
    ----------
    fine, rough : sequence of (patch, x, y)
        Grids of both solutions with the coordinates [m] of their columns and rows.
    pressures : (fine, rough) [Pa]
    skip_border : bool
        Leave out the outermost cells, where the pressure at a sharp edge is singular.
    """
    apart = size = 0.0
    for (patch, x, y), (coarse, x_coarse, y_coarse) in zip(fine, rough, strict=True):
        p = patch.view(pressures[0])
        mean = _overlap(y_coarse, y) @ p @ _overlap(x_coarse, x).T
        gap = mean - coarse.view(pressures[1])
        if skip_border:
            inner = tuple(slice(1, -1) if n > 2 else slice(None) for n in mean.shape)
            gap, mean = gap[inner], mean[inner]
        apart += float((gap**2).sum())
        size += float((mean**2).sum())
    return float(np.sqrt(apart / size)) if size > 0.0 else None


def extrapolated(difference: float, fine: tuple[float, float], rough: tuple[float, float]) -> float:
    """Error of the fine solution from its difference to the coarse one (Richardson)."""
    ratio = np.sqrt(rough[0] * rough[1] / (fine[0] * fine[1]))
    return float(difference / (ratio**ORDER - 1.0))


def _overlap(coarse: Array, fine: Array) -> Array:
    """Weights (coarse, fine) that average a cell-wise constant function over coarser cells."""

    def edges(centres: Array) -> Array:
        if centres.size == 1:
            return np.array([-np.inf, np.inf])
        middle = 0.5 * (centres[1:] + centres[:-1])
        return np.concatenate([[2 * centres[0] - middle[0]], middle, [2 * centres[-1] - middle[-1]]])

    low, high = edges(coarse), edges(fine)
    shared = np.minimum(low[1:, None], high[None, 1:]) - np.maximum(low[:-1, None], high[None, :-1])
    shared = np.maximum(shared, 0.0)
    if coarse.size == 1:
        shared = np.ones((1, fine.size))
    total = shared.sum(axis=1, keepdims=True)
    return np.asarray(np.divide(shared, total, out=np.zeros_like(shared), where=total > 0.0))
