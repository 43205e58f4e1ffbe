# SPDX-License-Identifier: MIT OR Apache-2.0
"""How near a load is to what the contact can carry: tipping over, and jamming."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from .problem import ContactProblem

Array = NDArray[np.float64]


#: Weight of the sum in :func:`_least_total`: its square is the relative error.
_SUM = 1e-5


def tipping_margin(problem: ContactProblem, friction: Array) -> float | None:
    """Distance of the resultant from the middle of the contact points, over that at which a body tips over.

    Free motions are balanced by pressures >= 0 and the friction they bring. The resultant of the loads must
    lie in the convex hull of the points as these balances see them (friction on a tall body shifts them); the
    middle is the resultant of a uniform pressure. 0: in the middle, 1: on the border, above: nothing balances
    the load. Of several bodies that move apart from each other the largest; None where no load determines the
    force, as under a prescribed approach.
    """
    motions, work = problem.relative_motions, problem.loading.work
    if not work.any():
        return None
    slid = np.einsum("cn,mcn->mn", problem.direction, motions[:, :2])
    # pressure on the lower body works against its load
    balance = -problem.area * (motions[:, 2] + friction * slid)
    shares = [
        _share(balance[rows][:, points], work[rows], problem.area[points]) for rows, points in _apart(balance)
    ]
    known = [share for share in shares if share is not None]
    return max(known) if known else None


def _apart(balance: Array) -> list[tuple[list[int], NDArray[np.intp]]]:
    """Motions that share points, and these points."""
    groups: list[tuple[list[int], NDArray[np.bool_]]] = []
    for k, row in enumerate(balance):
        rows, reach = [k], row != 0.0
        for other in [g for g in groups if (g[1] & reach).any()]:
            groups.remove(other)
            rows, reach = [*other[0], *rows], reach | other[1]
        groups.append((rows, reach))
    return [(sorted(rows), np.flatnonzero(reach)) for rows, reach in groups if reach.any()]


def _share(balance: Array, work: Array, area: Array) -> float | None:
    # the combination of balances that comes nearest to the sum of all forces
    scale = np.linalg.norm(balance, axis=1)
    weights = np.linalg.lstsq((balance / scale[:, None]).T, area, rcond=1e-10)[0] / scale
    carried, load = weights @ balance, float(weights @ work)
    if load <= 0.0 or carried.min() <= 1e-3 * carried.max():
        return None
    places = balance / carried
    middle = balance.sum(axis=1) / carried.sum()
    reach = np.abs(places - middle[:, None]).max(axis=1)
    moving = reach > 1e-9 * np.abs(places).max(axis=1)
    away = (work / load - middle)[moving] / reach[moving]
    if not moving.any() or np.abs(away).max() < 1e-12:
        return 0.0
    return _least_total((places - middle[:, None])[moving] / reach[moving][:, None], away)


def _least_total(places: Array, target: Array) -> float:
    """Least sum of numbers >= 0 by which the columns of `places` add up to `target`.

    By non-negative least squares [LawsonHanson1974, ch. 23] with the sum as a weak further equation.
    """
    matrix = np.vstack([places, np.full(places.shape[1], _SUM)])
    right = np.append(target, 0.0)
    amounts = np.zeros(matrix.shape[1])
    inside: list[int] = []
    # each pass brings the residual down with another set of at most as many columns as rows
    for _ in range(20 * matrix.shape[0]):
        slope = matrix.T @ (right - matrix @ amounts)
        slope[inside] = -np.inf
        entering = int(np.argmax(slope))
        if slope[entering] <= 1e-13 * float(np.abs(target).max()):
            break
        inside.append(entering)
        while True:
            found = np.linalg.lstsq(matrix[:, inside], right, rcond=None)[0]
            if found.min() > 0.0:
                break
            old = amounts[inside]
            falling = found <= 0.0
            step = float((old[falling] / (old[falling] - found[falling])).min())
            old += step * (found - old)
            amounts[:] = 0.0
            kept = old > 1e-14 * old.max()
            inside = [k for k, keep in zip(inside, kept, strict=True) if keep]
            amounts[inside] = old[kept]
        amounts[:] = 0.0
        amounts[inside] = found
    return float(amounts.sum())
