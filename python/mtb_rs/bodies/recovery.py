# SPDX-License-Identifier: MIT OR Apache-2.0
"""How much stiffer a mesh is than the body it stands for, by recovery of its stress.

The stress of finite elements jumps from one to the next; averaged at the nodes it is better by an order
(Zienkiewicz and Zhu, Int. J. Numer. Meth. Engng 24 (1987) 337). The energy of the difference over that of the
stress itself is the share of the compliance that the mesh leaves out.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from .elastic_body import ElasticBody
from .mesh import EDGES

Array = NDArray[np.float64]

#: Barycentric coordinates of the four points that integrate quadratic polynomials over a tetrahedron.
_POINTS = np.full((4, 4), 0.1381966011250105) + (0.5854101966249685 - 0.1381966011250105) * np.eye(4)


def left_out(body: ElasticBody, displacement: Array) -> tuple[float, float]:
    """Shares (whole body, elements at its contact) of the elastic energy that the mesh leaves out [-].

    `displacement` (3, N) [m] is that of the nodes.
    """
    cells = np.asarray(body.mesh.cells)
    count, kind = cells.shape
    values, slopes = zip(*(_shapes(point, kind) for point in _POINTS), strict=True)
    # all points of integration in one product: rows are cells and components
    slope = np.concatenate(slopes, axis=1)
    nodal = np.asarray(body.core.stress(displacement)[0])[:, cells] @ np.stack(values, axis=1)
    along = (body.mesh.nodes.T[:, cells] @ slope).reshape(3, count, len(_POINTS), 3)
    moved = (displacement[:, cells] @ slope).reshape(3, count, len(_POINTS), 3)
    # the rows of the inverse of the Jacobian are its columns' cross products over its determinant
    columns = [along[..., k] for k in range(3)]
    across = [np.cross(columns[i], columns[j], axis=0) for i, j in ((1, 2), (2, 0), (0, 1))]
    double = np.einsum("cmp,cmp->mp", columns[0], across[0])
    gradient = sum(moved[:, None, ..., k] * across[k][None] for k in range(3)) / double
    stress = _stress(gradient, body.material.shear_modulus, body.material.poisson_ratio)
    wrong, whole = (
        (double * _energy(field, body.material.shear_modulus, body.material.poisson_ratio)).sum(axis=1)
        for field in (nodal - stress, stress)
    )
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


def _stress(gradient: Array, shear: float, ratio: float) -> Array:
    """Stress (6, ...) [Pa], xx, yy, zz, yz, xz, xy, by the gradient (3, 3, ...) of the displacement."""
    trace = ratio / (1.0 - 2.0 * ratio) * (gradient[0, 0] + gradient[1, 1] + gradient[2, 2])
    normal = [2.0 * shear * (gradient[k, k] + trace) for k in range(3)]
    sheared = [shear * (gradient[i, j] + gradient[j, i]) for i, j in ((1, 2), (0, 2), (0, 1))]
    return np.stack([*normal, *sheared])


def _energy(stress: Array, shear: float, ratio: float) -> Array:
    """Elastic energy (...) [J/m3] of a stress (6, ...) [Pa], twice."""
    squares = (stress[:3] ** 2).sum(axis=0) + 2.0 * (stress[3:] ** 2).sum(axis=0)
    return np.asarray((squares - ratio / (1.0 + ratio) * stress[:3].sum(axis=0) ** 2) / (2.0 * shear))
