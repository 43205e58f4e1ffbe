# SPDX-License-Identifier: MIT OR Apache-2.0
"""How near a load is to what the contact can carry: tipping over, and jamming."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from .problem import ContactProblem, frame_of

Array = NDArray[np.float64]


#: Weight of the sum in :func:`_least_total`: its square is the relative error.
_SUM = 1e-5


def tipping_margin(problem: ContactProblem, friction: Array) -> float | None:
    """Distance of the resultant from the middle of the contact points, over that at which a body tips over.

    Free motions are balanced by pressures >= 0 and the friction they bring. The resultant of the loads must
    lie in the convex hull of the points as these balances see them (friction on a tall body shifts them); the
    middle is the resultant of a uniform pressure. 0: in the middle, 1: on the border, above: nothing balances
    the load. The hull is that of the face itself, nodes of hats and corners of cells, which no spacing moves;
    a grid carries what lies in the hull of its mean points, a little less. Of several bodies that move apart
    from each other the largest; None where no load determines the force, as under a prescribed approach.
    """
    motions, work = problem.relative_motions, problem.loading.work
    if not work.any():
        return None
    balance = _balance(problem, friction, motions)
    border = [_balance(problem, friction, motions + step) for step in _to_border(problem, motions)]
    shares = [
        _share(
            balance[rows][:, points],
            work[rows],
            problem.area[points],
            np.concatenate([b[rows][:, points] for b in border], axis=1),
        )
        for rows, points in _apart(balance)
    ]
    known = [share for share in shares if share is not None]
    return max(known) if known else None


def _balance(problem: ContactProblem, friction: Array, motions: Array) -> Array:
    """What a unit of pressure at each point adds to each balance (m, n): it works against the load."""
    slid = np.einsum("cn,mcn->mn", problem.direction, motions[:, :2])
    return np.asarray(-problem.area * (motions[:, 2] + friction * slid))


def _to_border(problem: ContactProblem, motions: Array) -> list[Array]:
    """What the rigid motions (m, 3, n) change from the mean points to the farthest ones of hats or cells."""
    frame = frame_of(problem.points)
    if problem.averages is not None:
        steps = [problem.points.points - problem.places]
    else:
        half = np.zeros((2, problem.n))
        for patch in problem.patches:
            half[:, patch.cut] = 0.5 * np.array(patch.spacing)[:, None]
        steps = [s * half[0] * frame[0] + t * half[1] * frame[1] for s in (-1, 1) for t in (-1, 1)]
    turns = np.zeros((len(motions), 3))
    for turn, motion in zip(turns, motions, strict=True):
        there = np.abs(motion).max(axis=0) > 0.0
        # a rigid motion from its components along the frame of each point
        at = problem.places[:, there] - problem.places[:, there].mean(axis=1, keepdims=True)
        axes = frame[:, :, there]
        moved = np.concatenate([axes, np.cross(at[None], axes, axis=1)], axis=1)
        scale = float(np.abs(at).max(initial=0.0)) or 1.0
        moved[:, 3:] /= scale
        found = np.linalg.lstsq(
            moved.transpose(0, 2, 1).reshape(-1, 6), motion[:, there].ravel(), rcond=1e-9
        )[0]
        turn[:] = found[3:] / scale
    return [
        np.einsum("cin,min->mcn", frame, np.cross(turns[:, :, None], step[None], axis=1)) for step in steps
    ]


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


def _share(balance: Array, work: Array, area: Array, border: Array) -> float | None:
    # the combination of balances that comes nearest to the sum of all forces
    scale = np.linalg.norm(balance, axis=1)
    weights = np.linalg.lstsq((balance / scale[:, None]).T, area, rcond=1e-10)[0] / scale
    carried, load = weights @ balance, float(weights @ work)
    if load <= 0.0 or carried.min() <= 1e-3 * carried.max():
        return None
    places = border / (weights @ border)
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
