# SPDX-License-Identifier: MIT OR Apache-2.0
"""How much stiffer a mesh is than the body it stands for, by recovery of its stress.

The stress of finite elements jumps from one to the next; averaged at the nodes it is better by an order
(Zienkiewicz and Zhu, Int. J. Numer. Meth. Engng 24 (1987) 337). The energy of the difference over that of the
stress itself is the share of the compliance that the mesh leaves out.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from .elastic_body import BodyState
from .mesh import EDGES

Array = NDArray[np.float64]

#: Barycentric coordinates of the four points that integrate quadratic polynomials over a tetrahedron.
_POINTS = np.full((4, 4), 0.1381966011250105) + (0.5854101966249685 - 0.1381966011250105) * np.eye(4)


def left_out(state: BodyState) -> tuple[float, float]:
    """Shares (whole body, elements at its contact) of the elastic energy that the mesh leaves out [-]."""
    body = state.body
    cells = np.asarray(body.mesh.cells)
    nodes, moved = body.mesh.nodes[cells], state.displacement.T[cells]
    nodal = state.stress.T[cells]
    shear, ratio = body.material.shear_modulus, body.material.poisson_ratio
    wrong, whole = np.zeros(len(cells)), np.zeros(len(cells))
    for point in _POINTS:
        value, slope = _shapes(point, cells.shape[1])
        jacobian = np.einsum("mkc,kr->mcr", nodes, slope)
        volume = np.linalg.det(jacobian) / 24.0
        gradient = np.einsum("mkc,kr,mrd->mcd", moved, slope, np.linalg.inv(jacobian))
        strain = 0.5 * (gradient + gradient.transpose(0, 2, 1))
        trace = np.trace(strain, axis1=1, axis2=2)[:, None, None] * np.eye(3)
        stress = 2.0 * shear * (strain + ratio / (1.0 - 2.0 * ratio) * trace)
        better = np.einsum("k,mks->ms", value, nodal)[:, [[0, 5, 4], [5, 1, 3], [4, 3, 2]]]
        wrong += volume * _energy(better - stress, shear, ratio)
        whole += volume * _energy(stress, shear, ratio)
    at_contact = np.isin(cells, body.faces[body.contact_faces]).any(axis=1)
    return tuple(  # type: ignore[return-value]
        float(wrong[chosen].sum() / max(whole[chosen].sum(), np.finfo(float).tiny))
        for chosen in (slice(None), at_contact)
    )


def _shapes(point: Array, nodes: int) -> tuple[Array, Array]:
    """Shape functions (k,) of a tetrahedron and their slopes (k, 3) along its edges 01, 02, 03."""
    along = np.array([[-1.0, -1.0, -1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]])
    if nodes == 4:
        return point, along
    a, b = np.array(EDGES).T
    value = np.concatenate([point * (2.0 * point - 1.0), 4.0 * point[a] * point[b]])
    between = 4.0 * (point[a, None] * along[b] + point[b, None] * along[a])
    return value, np.concatenate([(4.0 * point[:, None] - 1.0) * along, between])


def _energy(stress: Array, shear: float, ratio: float) -> Array:
    """Elastic energy (m,) [J/m3] of a stress (m, 3, 3) [Pa], twice."""
    trace = np.trace(stress, axis1=1, axis2=2)
    squares = np.einsum("mij,mij->m", stress, stress)
    return np.asarray((squares - ratio / (1.0 + ratio) * trace**2) / (2.0 * shear))
