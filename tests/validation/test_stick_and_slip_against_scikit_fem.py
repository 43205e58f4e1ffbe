# SPDX-License-Identifier: MIT OR Apache-2.0
"""A shoe that sticks and slips against scikit-fem: other elements, contact functions and solver."""

from __future__ import annotations

import numpy as np
import pytest
import scipy.sparse.linalg
from numpy.typing import NDArray

import mtb_rs as mtb
from mtb_rs.bodies.mesh import block_mesh

Array = NDArray[np.float64]
SIZES, HEIGHT, PULL, MU = (0.06, 0.04), 0.03, 3e6, 0.3
STEEL = mtb.Material(208e9, 0.3)


class Bricks:
    """The block of quadratic bricks, with linear tractions on its face, held against a rigid plane."""

    def __init__(self, cells: tuple[int, int, int]) -> None:
        import skfem
        from skfem.models.elasticity import lame_parameters, linear_elasticity

        lines = [np.linspace(-0.5 * s, 0.5 * s, n + 1) for s, n in zip(SIZES, cells, strict=False)]
        mesh = skfem.MeshHex.init_tensor(*lines, np.linspace(0.0, HEIGHT, cells[2] + 1))
        element = skfem.ElementVector(skfem.ElementHex2())
        basis = skfem.Basis(mesh, element, intorder=4)
        lame = lame_parameters(STEEL.young_modulus, STEEL.poisson_ratio)
        stiffness = linear_elasticity(*lame).assemble(basis)
        faces = mesh.facets_satisfying(lambda x: np.abs(x[2]) < 1e-9)
        there = skfem.FacetBasis(mesh, element, facets=faces, intorder=4)
        hats = skfem.FacetBasis(mesh, skfem.ElementHex1(), facets=faces, intorder=4)
        used = np.flatnonzero(np.abs(mesh.p[2]) < 1e-9)
        loads = []
        for c in range(3):
            form = skfem.BilinearForm(lambda u, v, w, c=c: u * v[c])
            loads.append(form.assemble(hats, there)[:, used])
        whole = scipy.sparse.hstack(loads, format="csc")
        free = np.flatnonzero(basis.doflocs[2] < HEIGHT - 1e-9)
        moved = scipy.sparse.linalg.splu(stiffness[free][:, free].tocsc()).solve(whole[free].toarray())
        one = skfem.LinearForm(lambda v, w: v).assemble(hats)[used]
        self.area = one
        #: Mean displacement (3 n) [m] by tractions (3 n) [Pa] on the block.
        self.compliance = whole[free].T @ moved / np.tile(one, 3)[:, None]

    def pressed(self, drawn: list[float]) -> list[tuple[float, float]]:
        """Force along x and pressure [N] on the plane after the top was drawn along x to each place.

        Fixed points of projections: pressure at least zero, friction in its disc.
        """
        n = self.area.size
        pull = np.concatenate([np.zeros(2 * n), -PULL * np.ones(n)])
        # tractions on the plane: opposite along it, the same size across
        sign = np.repeat([-1.0, -1.0, 1.0], n)
        matrix, offset = sign[:, None] * self.compliance * sign, sign * (self.compliance @ pull)
        size = 1.0 / np.linalg.norm(matrix, 2)
        u, out = np.concatenate([np.zeros(2 * n), PULL * np.ones(n)]), []
        before: Array | None = None
        for place, last in zip([0.0, *drawn], [0.0, 0.0, *drawn], strict=False):
            way = np.concatenate([np.full(n, place - last), np.zeros(n)])
            mu = 0.0 if before is None else MU
            for _ in range(60_000):
                v = matrix @ u + offset
                slip = np.zeros(2 * n) if before is None else v[: 2 * n] - before - way
                p = np.maximum(0.0, u[2 * n :] - size * v[2 * n :])
                z = (u[: 2 * n] - size * slip).reshape(2, n)
                z = z * np.minimum(1.0, mu * p / np.maximum(np.hypot(*z), 1e-300))
                new = np.concatenate([z.ravel(), p])
                change = np.abs(new - u).max()
                u = new
                if change < 1e-9 * PULL:
                    break
            before = (matrix @ u + offset)[: 2 * n]
            out.append((float(self.area @ u[:n]), float(self.area @ u[2 * n :])))
        return out[1:]


@pytest.mark.slow
@pytest.mark.coarse
def test_the_force_of_a_shoe_that_is_drawn_on_and_back() -> None:
    """Stick, partial slip, nearly full slip, reversal: within 2 % of the friction that it can bear."""
    x, y = (np.linspace(-0.5 * s, 0.5 * s, round(s / 5e-3) + 1) for s in SIZES)
    held = [mtb.Support("top", x=0, y=0, z=0)]
    body = mtb.ElasticBody(block_mesh(x, y, HEIGHT), STEEL, supports=held)
    scene = mtb.Scene(
        body,
        mtb.Rigid(),
        spacing=5e-3,
        friction=MU,
        sliding_direction=(1.0, 0.0),
        magnetic_pressure=PULL,
    )
    drawn = [2e-7, 4e-7, 6e-7, 3e-7, -3e-7]
    contact, place, found = scene.prepare(), 0.0, []
    assert isinstance(contact, mtb.PreparedContact)
    stuck = []
    for there in drawn:
        step = contact.step(shift=(there - place, 0.0))
        place = there
        found.append((step.force[0], -step.force[2]))
        stuck.append(np.mean(step.status == 1))
    expected = np.array(Bricks((6, 4, 3)).pressed(drawn))
    limit = MU * expected[0, 1]
    assert np.array(found) == pytest.approx(expected, abs=0.02 * limit)
    # all of it happens
    assert max(stuck) > 0.6
    assert min(stuck) < 0.2
    assert expected[2, 0] > 0.9 * limit > -0.9 * limit > expected[-1, 0]
