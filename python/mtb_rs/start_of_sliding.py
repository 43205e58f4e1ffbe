# SPDX-License-Identifier: MIT OR Apache-2.0
"""From sticking to full sliding, for bodies of any kind."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _mtb_rs
from .errors import ConvergenceError
from .friction import InterfaceLayer

Array = NDArray[np.float64]


@dataclass(frozen=True)
class StartOfSliding:
    """How a contact under fixed pressure gives way, step by step.

    Attributes
    ----------
    displacement : (m, 2) [m]
        Of the upper body over the lower one, away from the contact.
    force : (m, 2) [N]
        Friction on the lower body.
    slip_share : (m,) [-]
        Share of the contact area that slips in the step.
    traction : (2, n) [Pa]
        On the lower body, after the last step.
    status : (n,) int
        0 open, 1 stick, 2 slip, in the last step.
    iterations : (m,) int
        Newton steps.
    """

    displacement: Array
    force: Array
    slip_share: Array
    traction: Array
    status: NDArray[np.int8]
    iterations: NDArray[np.int64]


def start_of_sliding(
    compliance: _mtb_rs.Compliance,
    pressure: ArrayLike,
    area: ArrayLike,
    friction: float | ArrayLike,
    displacements: ArrayLike,
    layer: InterfaceLayer | None = None,
    tolerance: float = 1e-8,
) -> StartOfSliding:
    """Pushes one body over the other in steps, its pressure held, until everything slides.

    Parameters
    ----------
    compliance : Compliance
        Of both bodies together: displacement of the lower one relative to the upper one by a traction on
        the lower one, as `SlidingPair.compliance`.
    pressure, area : (n,) [Pa], [m2]
    friction : float or (n,) [-]
    displacements : (m, 2) [m]
        Of the upper body over the lower one at the end of each step, from rest.
    layer : InterfaceLayer or None
        Softens the start; without influence once everything slides.
    tolerance : float [-]

    Raises
    ------
    ConvergenceError
        Naming the step.
    """
    p, a = np.asarray(pressure, dtype=float).ravel(), np.asarray(area, dtype=float).ravel()
    n = compliance.points
    for name, values in (("pressure", p), ("area", a)):
        if values.shape != (n,) or not np.all(np.isfinite(values)) or np.any(values < 0.0):
            raise ValueError(f"{name} must hold {n} finite numbers of at least 0")
    mu = np.broadcast_to(np.asarray(friction, dtype=float), (n,))
    steps = np.atleast_2d(np.asarray(displacements, dtype=float))
    if steps.ndim != 2 or steps.shape[1] != 2 or not np.all(np.isfinite(steps)):
        raise ValueError(f"displacements has shape {steps.shape}: (m, 2) finite numbers are needed")
    matrix = np.block([[compliance.influence(row, column) for column in "xy"] for row in "xy"])
    if layer is not None:
        matrix[np.diag_indices(2 * n)] += layer.flexibility
    matrix = np.ascontiguousarray(matrix)
    contact = p > 0.0
    q = np.zeros(2 * n)
    before = np.zeros(2)
    force, share, counts = [], [], []
    status = np.zeros(n, dtype=np.int8)
    for k, step in enumerate(steps):
        offset = -np.repeat(step - before, n) - matrix @ q
        found = _mtb_rs.solve_discs_dense(matrix, offset, mu * p, [], tolerance)
        if not found["converged"]:
            raise ConvergenceError(
                f"no state found for the displacement {step.tolist()} m, step {k + 1}", found
            )
        q, status, before = found["field"], found["status"], step
        force.append([float(q[:n] @ a), float(q[n:] @ a)])
        share.append(float(a[status == 2].sum() / a[contact].sum()) if np.any(contact) else 0.0)
        counts.append(found["iterations"])
    return StartOfSliding(
        displacement=steps,
        force=np.array(force),
        slip_share=np.array(share),
        traction=q.reshape(2, n),
        status=status,
        iterations=np.array(counts),
    )
