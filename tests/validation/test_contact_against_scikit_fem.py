# SPDX-License-Identifier: MIT OR Apache-2.0
"""Sliding contact of elastic bodies against scikit-fem: its stiffness, its integrals, an active set."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest
import scipy.sparse.linalg
from numpy.typing import NDArray

import mtb_rs as mtb
from mtb_rs.mesh import block_mesh

Array = NDArray[np.float64]
PULL, SPACING = 3e6, 1e-2


@dataclass(frozen=True)
class Block:
    """A block with one face in the plane z = 0, its other end held."""

    mesh: mtb.TetraMesh
    height: float
    material: mtb.Material
    upper: bool

    def gap(self, grid: tuple[Array, Array], slip: Array, pull: float) -> tuple[Array, Array, Array]:
        """Gap that hats of pressure with their friction open, gap of the pull, areas; by scikit-fem."""
        import skfem
        from skfem.models.elasticity import lame_parameters, linear_elasticity

        sign = 1.0 if self.upper else -1.0
        corners, cells = np.unique(self.mesh.cells[:, :4], return_inverse=True)
        mesh = skfem.MeshTet(
            np.ascontiguousarray(self.mesh.nodes[corners].T), np.ascontiguousarray(cells.reshape(-1, 4).T)
        )
        element = skfem.ElementVector(skfem.ElementTetP2())
        basis = skfem.Basis(mesh, element)
        lame = lame_parameters(self.material.young_modulus, self.material.poisson_ratio)
        stiffness = linear_elasticity(*lame).assemble(basis)
        face = skfem.FacetBasis(mesh, element, facets=mesh.facets_satisfying(lambda x: np.abs(x[2]) < 1e-9))
        x, y, _ = np.asarray(face.global_coordinates())
        normal, along = [], []
        for hat_y in (_hat(y, grid[1], j) for j in range(grid[1].size)):
            for hat in (hat_y * _hat(x, grid[0], i) for i in range(grid[0].size)):
                press = skfem.LinearForm(lambda v, w, hat=hat: hat * v[2])
                drag = skfem.LinearForm(lambda v, w, hat=hat: hat * (v[0] * slip[0] + v[1] * slip[1]))
                normal.append(press.assemble(face))
                along.append(drag.assemble(face))
        pressed, dragged = np.array(normal).T, np.array(along).T
        free = np.flatnonzero(np.abs(np.abs(basis.doflocs[2]) - self.height) > 1e-9)
        loads = np.column_stack([sign * (pressed - dragged), -sign * pull * pressed.sum(axis=1)])
        moved = scipy.sparse.linalg.splu(stiffness[free][:, free].tocsc()).solve(loads[free])
        opened = sign * pressed[free].T @ moved
        return opened[:, :-1], opened[:, -1], pressed.sum(axis=0)

    def body(self) -> mtb.ElasticBody:
        """The same block of the package."""
        held = mtb.Support("top" if self.upper else "bottom", x=0, y=0, z=0)
        return mtb.ElasticBody(self.mesh, self.material, supports=[held], name=f"upper {self.upper}")


def _hat(at: Array, nodes: Array, k: int) -> Array:
    return np.asarray(np.interp(at, nodes, np.eye(nodes.size)[k]))


def _block(x: Array, y: Array, height: float, material: mtb.Material, *, upper: bool) -> Block:
    mesh = block_mesh(x, y, height)
    return Block(mesh if upper else mesh.moved(np.diag([1.0, -1.0, -1.0])), height, material, upper)


def _active_set(matrix: Array, offset: Array) -> Array:
    active = np.ones(offset.size, dtype=bool)
    for _ in range(60):
        p = np.zeros(offset.size)
        p[active] = np.linalg.solve(matrix[np.ix_(active, active)], -offset[active])
        gap = matrix @ p + offset
        wrong = np.where(active, p < -1e-10 * p.max(), gap < -1e-10 * np.abs(offset).max())
        if not wrong.any():
            return p
        active ^= wrong
    raise AssertionError("no solution")


@pytest.mark.coarse
@pytest.mark.parametrize(
    ("sizes", "heights", "materials", "friction", "direction", "attraction"),
    [
        # width, length; upper, lower height (None: rigid); E and nu of both
        ((0.06, 0.04), (0.02, None), ((208e9, 0.3), None), 0.3, (1.0, 0.0), "upper"),
        ((0.05, 0.05), (0.06, None), ((70e9, 0.2), None), 0.4, (1.0, 0.7), "upper"),
        ((0.06, 0.03), (0.04, None), ((100e9, 0.45), None), 0.6, (-1.0, 0.0), "upper"),
        ((0.04, 0.03), (0.03, 0.02), ((208e9, 0.3), (70e9, 0.25)), 0.3, (1.0, 0.5), "upper"),
        ((0.04, 0.03), (0.02, 0.03), ((100e9, 0.1), (208e9, 0.3)), 0.4, (0.0, -1.0), "both"),
    ],
    ids=["flat", "tall, oblique", "backwards", "two bodies", "both pulled"],
)
def test_blocks(sizes, heights, materials, friction, direction, attraction) -> None:
    x, y = (np.linspace(-0.5, 0.5, round(size / SPACING) + 1) * size for size in sizes)
    upper = _block(x, y, heights[0], mtb.Material(*materials[0]), upper=True)
    lower = None
    if materials[1] is not None:
        lower = _block(x, y, heights[1], mtb.Material(*materials[1]), upper=False)
    slip = friction * np.array(direction) / np.hypot(*direction)
    matrix, offset, area = upper.gap((x, y), slip, PULL)
    if lower is not None:
        more, pulled, _ = lower.gap((x, y), slip, PULL if attraction == "both" else 0.0)
        matrix, offset = matrix + more, offset + pulled
    expected = _active_set(matrix, offset)
    result = mtb.Scene(
        upper.body(),
        mtb.Rigid() if lower is None else lower.body(),
        spacing=SPACING,
        friction=friction,
        sliding_direction=direction,
        magnetic_pressure=PULL,
        attraction=attraction,
    ).solve()
    assert result.coefficients is not None
    np.testing.assert_array_equal(result.status.ravel() > 0, expected > 0.0)
    # the quadratures of the hats differ, which shows at the edges
    np.testing.assert_allclose(result.coefficients[2], expected, rtol=0, atol=0.01 * expected.max())
    # the package's quadrature of hats is not exact on the triangles of a cell, scikit-fem's is
    assert result.normal_force == pytest.approx(expected @ area, rel=1e-4)
    np.testing.assert_allclose(result.force[:2], slip * result.normal_force, atol=1e-6 * result.normal_force)
    assert result.report.force_balance["relative_error"] < 1e-10
