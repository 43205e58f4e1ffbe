# SPDX-License-Identifier: MIT OR Apache-2.0
"""The start of sliding with a pressure that follows: normal and tangential contact solved as one."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..base.errors import ConvergenceError
from ..base.plain import plain

Array = NDArray[np.float64]

#: Newton steps for a push, and halvings of a push that needs more.
_STEPS = 40
_HALVINGS = 6
#: Shortest step of the line search.
_SHORTEST = 1.0 / 64.0


@dataclass(frozen=True)
@plain
class CoupledContact:
    """Unilateral contact with friction at n points, every block of the compliance, free rigid motions.

    Unknowns, one after another: tractions along both tangents on the lower body and pressures
    ``u = (q_x, q_y, p)`` [Pa], and the amplitudes ``a`` of the motions. The displacement of the lower body
    relative to the upper one along the tangents, and the gap, are ``v = compliance u + motions a + v_0``.

    Attributes
    ----------
    compliance : (3 n, 3 n) [m/Pa]
    motions : (m, 3 n)
    area : (n,) [m2]
    friction : (n,) [-]
    opening : (n,) [m]
        Gap before contact and before any push.
    work : (m,) [J]
        Of all loads but the contact's on a unit of each motion.
    tolerance : float [-]
        Residual over the norm of the pressure.
    """

    compliance: Array
    motions: Array
    area: Array
    friction: Array
    opening: Array
    work: Array
    tolerance: float


@dataclass(frozen=True)
@plain
class CoupledState:
    """A state of the contact: tractions and pressures, amplitudes, push reached, displacement, status."""

    unknowns: Array
    motion: Array
    push: Array
    displacement: Array
    status: NDArray[np.int8]
    iterations: int = 0

    @property
    def pressure(self) -> Array:
        """(n,) [Pa]."""
        return self.unknowns[2 * self.status.size :]


def at_rest(contact: CoupledContact, pressure: Array, motion: Array) -> CoupledState:
    """The bodies pressed together without friction: where their tangential displacements count from."""
    unknowns = np.concatenate([np.zeros(2 * pressure.size), pressure])
    displacement = contact.compliance @ unknowns + motion @ contact.motions
    status = (pressure > 0.0).astype(np.int8)
    return CoupledState(unknowns, motion, np.zeros(3 * pressure.size), displacement, status)


def advance(contact: CoupledContact, state: CoupledState, push: Array) -> CoupledState:
    """The state at the push (3 n) [m]: of the upper body, along the tangents and the normal of each point.

    A semismooth Newton method on contact, friction and balance together [Kalker1990, ch. 4]; a push
    that it does not reach at once is reached in halves.

    Raises
    ------
    ConvergenceError
        With the last state as ``.result``.
    """
    parts = 1
    for _ in range(_HALVINGS + 1):
        reached: CoupledState | None = state
        for k in range(1, parts + 1):
            reached = _newton(contact, reached, state.push + k / parts * (push - state.push))
            if reached is None:
                break
        if reached is not None:
            return reached
        parts *= 2
    raise ConvergenceError(f"no state found, not even in {parts // 2} parts", state)


class _Iterate:
    """Unknowns with their displacement, the state of each point, and the residual."""

    def __init__(self, contact: CoupledContact, offset: Array, unknowns: Array, motion: Array) -> None:
        n = contact.area.size
        self.unknowns, self.motion = unknowns, motion
        self.displacement = contact.compliance @ unknowns + motion @ contact.motions + offset
        diagonal = np.diag(contact.compliance)
        self.stiffness = np.array([2.0 * n / diagonal[: 2 * n].sum(), n / diagonal[2 * n :].sum()])
        q, p = unknowns[: 2 * n].reshape(2, n), unknowns[2 * n :]
        wanted = p - self.stiffness[1] * self.displacement[2 * n :]
        self.is_closed = wanted > 0.0
        z = q - self.stiffness[0] * self.displacement[: 2 * n].reshape(2, n)
        self.length = np.hypot(*z)
        bound = contact.friction * np.maximum(p, 0.0)
        self.is_slipping = self.is_closed & (self.length > bound)
        self.normal = np.where(self.is_slipping, z / np.where(self.length > 0.0, self.length, 1.0), 0.0)
        with np.errstate(divide="ignore", invalid="ignore"):
            excess = np.where(
                self.is_slipping, self.length / np.maximum(bound, 1e-9 * self.length) - 1.0, 0.0
            )
        self.curvature = excess / self.stiffness[0]
        aim = np.where(self.is_slipping, bound * self.normal, z)
        aim = np.where(self.is_closed, aim, 0.0)
        residual = np.concatenate([(q - aim).ravel(), p - np.maximum(wanted, 0.0)])
        loads = np.tile(contact.area, 3) * unknowns
        balance = (contact.motions @ loads + contact.work) / np.maximum(
            np.abs(contact.motions) @ np.tile(contact.area, 3), 1e-300
        )
        self.residual = float(np.hypot(np.linalg.norm(residual), np.sqrt(n) * np.linalg.norm(balance)))


def _newton(contact: CoupledContact, state: CoupledState | None, push: Array) -> CoupledState | None:
    assert state is not None
    n = contact.area.size
    # relative displacement since the last state, less the push: minus the slip; below it, the gap
    offset = np.concatenate([-(push - state.push)[: 2 * n] - state.displacement[: 2 * n], contact.opening])
    offset[2 * n :] += push[2 * n :]
    iterate = _Iterate(contact, offset, state.unknowns, state.motion)
    size = max(float(np.linalg.norm(state.pressure)), 1e-300)
    # a push whose traction stays below the tolerance of the pressure still takes its linear step
    fewest = 1 if np.any(push != state.push) else 0
    for count in range(_STEPS + 1):
        size = max(size, float(np.linalg.norm(iterate.unknowns[2 * n :])))
        if count >= fewest and iterate.residual <= contact.tolerance * size:
            displacement = iterate.displacement - offset
            status = np.where(iterate.is_closed, np.where(iterate.is_slipping, 2, 1), 0).astype(np.int8)
            # what the last damped step left at open points is below the tolerance
            unknowns = np.where(np.tile(iterate.is_closed, 3), iterate.unknowns, 0.0)
            return CoupledState(unknowns, iterate.motion, push, displacement, status, count)
        full = _linear_step(contact, offset, iterate)
        if full is None or not np.all(np.isfinite(full)):
            return None
        share = 1.0
        while True:
            unknowns = iterate.unknowns + share * (full[: 3 * n] - iterate.unknowns)
            motion = iterate.motion + share * (full[3 * n :] - iterate.motion)
            new = _Iterate(contact, offset, unknowns, motion)
            if new.residual < (1.0 - 0.1 * share) * iterate.residual or share <= _SHORTEST:
                break
            share *= 0.5
        iterate = new
    return None


def _linear_step(contact: CoupledContact, offset: Array, iterate: _Iterate) -> Array | None:
    """Unknowns and amplitudes that meet the conditions linearised; None for a singular matrix."""
    n, m = contact.area.size, contact.work.size
    closed = np.flatnonzero(iterate.is_closed)
    free = np.concatenate([closed, n + closed, 2 * n + closed])
    k = closed.size
    block = np.hstack([contact.compliance[np.ix_(free, free)], contact.motions[:, free].T])
    first, second, gap = block[:k], block[k : 2 * k], block[2 * k :]
    nx, ny = iterate.normal[:, closed]
    slips = iterate.is_slipping[closed]
    matrix = np.zeros((3 * k + m, 3 * k + m))
    right = np.zeros(3 * k + m)
    matrix[: 3 * k] = block
    right[: 3 * k] = -offset[free]
    # a point that slips: its traction follows the pressure along the slip, and turns with it
    at = np.flatnonzero(slips)
    c, s = nx[at], ny[at]
    matrix[at] = 0.0
    matrix[at, at], matrix[at, k + at] = c, s
    matrix[at, 2 * k + at] = -contact.friction[closed][at]
    right[at] = 0.0
    matrix[k + at] = -s[:, None] * first[at] + c[:, None] * second[at]
    curvature = iterate.curvature[closed][at]
    matrix[k + at, at] -= curvature * s
    matrix[k + at, k + at] += curvature * c
    right[k + at] = s * offset[closed][at] - c * offset[n + closed][at]
    matrix[2 * k : 3 * k] = gap
    matrix[3 * k :, : 3 * k] = contact.motions[:, free] * np.tile(contact.area, 3)[free]
    right[3 * k :] = -contact.work
    # rows and columns to like sizes: displacements over the compliance, forces over the area
    scale = np.abs(matrix).max(axis=1)
    if not np.all(scale > 0.0):
        return None
    try:
        solution = np.linalg.solve(matrix / scale[:, None], right / scale)
    except np.linalg.LinAlgError:
        return None
    full = np.zeros(3 * n + m)
    full[free], full[3 * n :] = solution[: 3 * k], solution[3 * k :]
    return full
