# SPDX-License-Identifier: MIT OR Apache-2.0
"""The thermal limit of sliding against the closed form of a conductor on a rigid insulator.

The conductor is a slab of finite elements by scikit-fem, one half of a wave wide, in plane strain.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from skfem import (
    Basis,
    BilinearForm,
    ElementQuad2,
    ElementVector,
    FacetBasis,
    LinearForm,
    MeshQuad,
    condense,
    solve,
)
from skfem.helpers import ddot, div, dot, eye, grad, sym_grad, trace

from mtb_rs import _mtb_rs

Array = NDArray[np.float64]

YOUNG, NU, ALPHA, K = 208e9, 0.3, 12e-6, 50.0
LAME = YOUNG * NU / ((1.0 + NU) * (1.0 - 2.0 * NU))
SHEAR = YOUNG / (2.0 * (1.0 + NU))


def slab(wave: float, cells: int) -> tuple[Array, Array, Array, Array]:
    """Places and weights (n,) of hats on a face, and what pressures and steady fluxes open (n, n)."""
    depth = 1.5 * wave
    x = np.linspace(0.0, 0.5 * wave, cells + 1)
    z = depth * np.linspace(0.0, 1.0, 2 * cells + 1) ** 2
    mesh = MeshQuad.init_tensor(x, z).with_boundaries(
        {
            "sides": lambda p: (p[0] < 1e-12) | (p[0] > 0.5 * wave - 1e-12),
            "face": lambda p: p[1] < 1e-12,
            "back": lambda p: p[1] > depth - 1e-12,
        }
    )
    elastic = Basis(mesh, ElementVector(ElementQuad2()))
    thermal = elastic.with_element(ElementQuad2())

    @BilinearForm  # type: ignore[untyped-decorator]
    def stiffness(u: Any, v: Any, w: Any) -> Any:
        strain = sym_grad(u)
        return ddot(2.0 * SHEAR * strain + LAME * eye(trace(strain), 2), sym_grad(v))

    @BilinearForm  # type: ignore[untyped-decorator]
    def conduction(u: Any, v: Any, w: Any) -> Any:
        return K * dot(grad(u), grad(v))

    @BilinearForm  # type: ignore[untyped-decorator]
    def expansion(t: Any, v: Any, w: Any) -> Any:
        # 3 lambda + 2 mu: the strain across the plane is hindered as well
        return (3.0 * LAME + 2.0 * SHEAR) * ALPHA * t * div(v)

    rigid, heat = stiffness.assemble(elastic), conduction.assemble(thermal)
    warm = expansion.assemble(thermal, elastic)
    held = np.unique(np.concatenate([elastic.get_dofs("sides").all("u^1"), elastic.get_dofs("back").all()]))
    cold = thermal.get_dofs("back").all()
    on_face, heated_face = (
        FacetBasis(mesh, basis.elem, facets=mesh.boundaries["face"], intorder=6)
        for basis in (elastic, thermal)
    )
    n = cells + 1
    weights, loads, fluxes = np.zeros(n), [], []
    for i in range(n):

        def hat(p: Any, i: int = i) -> Any:
            return np.maximum(0.0, 1.0 - np.abs(p[0] - x[i]) / x[1])

        loads.append(LinearForm(lambda v, w, hat=hat: hat(w.x) * v[1]).assemble(on_face))
        fluxes.append(LinearForm(lambda v, w, hat=hat: hat(w.x) * v).assemble(heated_face))
        weights[i] = fluxes[-1].sum()
    mean = np.array(loads) / weights[:, None]
    by_pressure, by_flux = np.zeros((n, n)), np.zeros((n, n))
    for j in range(n):
        by_pressure[:, j] = mean @ solve(*condense(rigid, loads[j], D=held))
        temperature = solve(*condense(heat, fluxes[j], D=cold))
        by_flux[:, j] = mean @ solve(*condense(rigid, warm @ temperature, D=held))
    return x, weights, by_pressure, by_flux


@pytest.mark.parametrize(("wave", "known"), [(0.1, 8.7e-3), (0.03, 29e-3), (0.01, 87e-3)])
def test_a_conductor_on_a_rigid_insulator_has_its_limit(wave: float, known: float) -> None:
    mu, speed = 0.2, 1.0
    x, weights, by_pressure, by_flux = slab(wave, 16)
    n = x.size
    blocks = np.zeros((6, n, n))
    # forces on hats by pressures of hats, along the normal alone
    blocks[2] = weights[:, None] * by_pressure
    body = _mtb_rs.flexibility(weights, blocks)
    places = np.stack([x, np.zeros(n), np.zeros(n)])
    axes = np.eye(3)[:, :, None] * np.ones(n)
    fields = [np.ascontiguousarray(axis) for axis in (*axes, *axes)]
    geometry = _mtb_rs.ContactGeometry(places, weights, fields, None, [])
    rise = np.zeros((1, 3, n))
    rise[0, 2] = 1.0
    problem = _mtb_rs.Problem(None, body, geometry, rise, [True])
    direction = geometry.sliding_direction((0.0, 1.0))
    response = np.stack([1e9 * np.eye(n), np.zeros((n, n))])
    opening = np.stack([np.zeros((n, n)), by_flux])
    heating: Any = response, np.zeros((2, n)), np.full(n, speed), (0.0, 0.5), opening
    factor = problem.thermal_factor(direction, np.full(n, mu), heating, [True] * n)
    exact = 2.0 * (2.0 * np.pi / wave) * K * (1.0 - NU) / (mu * ALPHA * YOUNG)
    assert exact == pytest.approx(known, rel=0.02)
    assert factor * speed == pytest.approx(exact, rel=0.01)
    # without heat, and without what it opens, there is no limit
    assert problem.thermal_factor(direction, np.zeros(n), heating, [True] * n) == np.inf
    closed: Any = (*heating[:4], None)
    assert problem.thermal_factor(direction, np.full(n, mu), closed, [True] * n) == np.inf
    # a step of wear moves it up by its diagonal over the compliance of the wave, 2 (1 - nu^2) / (E m)
    worn = 0.3 * 2.0 * (1.0 - NU**2) * wave / (YOUNG * 2.0 * np.pi)
    moved = problem.thermal_factor(direction, np.full(n, mu), heating, [True] * n, np.full(n, worn))
    assert moved == pytest.approx(1.3 * factor, rel=0.02)
