# SPDX-License-Identifier: MIT OR Apache-2.0
"""Roots of a few functions that cost a contact solve each and end where a profile ends."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

#: Steps towards a root, and halvings of one of them.
MOST_STEPS, HALVINGS = 40, 8
#: Decrease of the residual that the derivatives at hand must give to be kept.
ENOUGH = 0.5


class NoRootError(Exception):
    """No step makes the residual smaller, or the steps are used up."""


def find_root(
    residual: Callable[[Array], Array],
    x: Array,
    jacobian: Array,
    tolerance: float,
    longest: float,
    small: float,
) -> Array:
    """Newton's method with a line search; Broyden's updates, and differences where those gain little.

    Parameters
    ----------
    residual : callable
        (n,) of (n,); ValueError outside its range, to which steps are shortened. The last call is the root.
    x : (n,)
        Start, in range.
    jacobian : (n, n)
        Estimate of the derivatives there.
    longest, small : float
        Largest change of x in a step, and the one for differences.

    Raises
    ------
    NoRootError
    """
    value = residual(x)
    is_fresh = False
    for _ in range(MOST_STEPS):
        if np.abs(value).max() < tolerance:
            return x
        there = shortened(residual, x, value, jacobian, longest)
        if there is None:
            if is_fresh:
                break
            gain = np.inf
        else:
            change, left = there[0] - x, there[1]
            gain = float(np.linalg.norm(left) / np.linalg.norm(value))
            jacobian = jacobian + np.outer(left - value - jacobian @ change, change) / (change @ change)
            x, value = there
            is_fresh = False
        if gain > ENOUGH and not np.abs(value).max() < tolerance:
            jacobian, is_fresh = differences(residual, x, value, small), True
    raise NoRootError


def shortened(
    residual: Callable[[Array], Array], x: Array, value: Array, jacobian: Array, longest: float
) -> tuple[Array, Array] | None:
    """The point of a Newton step, and its residual, after as many halvings as make that smaller."""
    change = -np.linalg.lstsq(jacobian, value)[0]
    change *= min(1.0, longest / max(float(np.abs(change).max()), np.finfo(float).tiny))
    for _ in range(HALVINGS):
        try:
            left = residual(x + change)
        except ValueError:
            change *= 0.5
            continue
        if np.linalg.norm(left) < np.linalg.norm(value):
            return x + change, left
        change *= 0.5
    return None


def differences(residual: Callable[[Array], Array], x: Array, value: Array, small: float) -> Array:
    """Derivatives (n, n) of the residual, backwards where it ends ahead."""
    columns = []
    for unit in np.eye(x.size):
        try:
            columns.append((residual(x + small * unit) - value) / small)
        except ValueError:
            columns.append((value - residual(x - small * unit)) / small)
    return np.stack(columns, axis=1)
