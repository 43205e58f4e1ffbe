# SPDX-License-Identifier: MIT OR Apache-2.0
"""What friction that turns does to small motions, where it moves the faces that slide as well.

Faces slide by the rates of the coordinates, ``S x'``. Friction follows the slip ``s``, and what it does to
massless bodies moves the faces on: ``s = S x' - d(T s)/dt``. So the load on the coordinates is that of a
damper with a memory, ``L (1 + lambda T)^-1 S`` for motions that go with exp(lambda t). A block Krylov space
of ``T`` from ``S`` holds it [Freund2003]: a few vectors in place of all contact points.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Modes = NDArray[np.complex128]

#: Share of a direction that is new below which it is rounding.
NEW = 1e-10
#: Share of the slip that may be missed at the fastest motion, and most directions.
MISSED, MOST = 1e-10, 200

#: Loads (b, k) on the coordinates, and how far the faces are moved back (b, N) [m], by slips (b, N) [m/s].
Answer = Callable[[Array], tuple[Array, Array]]


@dataclass(frozen=True)
class Drag:
    """A damper with a memory over k coordinates, by r directions of slip.

    Attributes
    ----------
    into : (r, k)
        Slip by the rates.
    out : (k, r)
        Load by the slip.
    back : (r, r) [s]
        How far slip moves the faces back.
    """

    into: Array
    out: Array
    back: Array

    @classmethod
    def of(cls, slip: Array, answer: Answer, fastest: float) -> Drag:
        """From the slip (k, N) by the rates, for motions up to a rate [1/s]."""
        size = np.linalg.norm(slip, axis=1)
        size = np.where(size > 0.0, size, 1.0)
        basis = _directions(slip / size[:, None], np.zeros((0, slip.shape[1])))
        into = basis @ slip.T
        loads, moved = answer(basis)
        first = 0
        while True:
            back = basis @ moved.T
            rest = moved[first:] - back[:, first:].T @ basis
            scaled = into / size
            eye = np.eye(len(basis))
            found = np.linalg.solve(eye + 1j * fastest * back, scaled.astype(np.complex128))
            missed = fastest * np.linalg.norm(rest.T @ found[first:])
            if missed <= MISSED * np.linalg.norm(scaled) or len(basis) >= min(MOST, slip.shape[1]):
                break
            length = np.linalg.norm(moved[first:], axis=1)
            new = _directions(rest / np.where(length > 0.0, length, 1.0)[:, None], basis)
            if not len(new):
                break
            first = len(basis)
            basis = np.vstack([basis, new])
            into = basis @ slip.T
            more, further = answer(new)
            loads, moved = np.vstack([loads, more]), np.vstack([moved, further])
        return cls(into, loads.T, back)

    def at(self, values: Modes) -> tuple[Modes, Modes]:
        """The damper (j, k, k) for motions that go with each of `values` (j,) [1/s], and its derivative."""
        matrix = np.eye(len(self.back)) + values[:, None, None] * self.back
        slip = np.linalg.solve(matrix, np.broadcast_to(self.into, (values.size, *self.into.shape)))
        turned = np.linalg.solve(matrix, -(self.back @ slip))
        return self.out @ slip, self.out @ turned


def _directions(fields: Array, basis: Array) -> Array:
    """Unit vectors (b, N) that span what `fields` (c, N) of size 1 have beside unit vectors (r, N)."""
    for _ in range(2):
        fields = fields - (fields @ basis.T) @ basis
    _, values, directions = np.linalg.svd(fields, full_matrices=False)
    new = directions[values > NEW * max(1.0, float(values.max(initial=0.0)))]
    new = new - (new @ basis.T) @ basis
    return np.ascontiguousarray(np.linalg.qr(new.T)[0].T)
