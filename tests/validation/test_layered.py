# SPDX-License-Identifier: MIT OR Apache-2.0
"""Half-spaces with a layer: against published kernels, an integral equation, and all limits."""

from __future__ import annotations

import itertools
import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import mtb_rs as mtb
from mtb_rs import _mtb_rs

Array = NDArray[np.float64]

STEEL = mtb.steel
SOFT = mtb.Material(4e9, 0.38)
HARD = mtb.Material(450e9, 0.22)
RUBBER = mtb.Material(5e6, 0.5)


# --- the published kernels, on their own ----------------------------------------------------------------


def two_layers(q: Array, layer: mtb.Material, base: mtb.Material) -> Array:
    """G k / (1 - nu) times the displacement by a pressure wave, bonded [O'Sullivan & King 1988]."""
    stiffness = layer.shear_modulus / base.shear_modulus
    nu, below = layer.poisson_ratio, base.poisson_ratio
    one = 1.0 - 4.0 * (1.0 - nu) / (1.0 + stiffness * (3.0 - 4.0 * below))
    two = (stiffness - 1.0) / (stiffness + 3.0 - 4.0 * nu)
    decay = np.exp(-2.0 * q)
    upper = 1.0 + 4.0 * q * two * decay - one * two * decay**2
    return np.asarray(upper / (1.0 - (one + two + 4.0 * two * q**2) * decay + one * two * decay**2))


def on_rigid(q: Array, layer: mtb.Material, bonded: bool) -> Array:
    """The same on a rigid base [Johnson 1985, ch. 5.8], [Lebedev & Ufliand 1958]."""
    decay = np.exp(-2.0 * q)
    if not bonded:
        return np.asarray((1.0 - decay) ** 2 / (1.0 - decay**2 + 4.0 * q * decay))
    kappa = 3.0 - 4.0 * layer.poisson_ratio
    constant = (4.0 * q**2 + kappa**2 + 1.0) * decay
    return np.asarray((kappa * (1.0 - decay**2) - 4.0 * q * decay) / (kappa * (1.0 + decay**2) + constant))


def kernel_of(body: mtb.Layered) -> Callable[[Array], Array]:
    if isinstance(body.base, mtb.Rigid):
        return lambda q: on_rigid(q, body.layer, body.bonded)
    base = body.base
    return lambda q: two_layers(q, body.layer, base)


BODIES = {
    "soft on steel": mtb.Layered(SOFT, 1e-3, STEEL),
    "hard on steel": mtb.Layered(HARD, 0.2e-3, STEEL),
    "soft on rigid": mtb.Layered(SOFT, 1e-3, mtb.Rigid()),
    "soft on slippery rigid": mtb.Layered(SOFT, 1e-3, mtb.Rigid(), bonded=False),
    "rubber on rigid": mtb.Layered(RUBBER, 1e-3, mtb.Rigid()),
    "rubber on steel": mtb.Layered(RUBBER, 0.5e-3, STEEL),
}
each_body = pytest.mark.parametrize("body", BODIES.values(), ids=BODIES.keys())


def sphere(
    body: mtb.Layered, radius: float, contact: float, points: int = 80
) -> tuple[float, float, Callable[[Array], Array]]:
    """Force [N], approach [m] and pressure of a rigid sphere that touches a layer up to `contact` [m].

    Lebedev & Ufliand's integral equation for phi, of which the pressure is the transform of an Abel integral,
    by Gauss points. The layer enters by the Fourier transform of its published kernel less 1.
    """
    nodes, weights = np.polynomial.legendre.leggauss(points)
    t, w = 0.5 * contact * (nodes + 1.0), 0.5 * contact * weights
    h = body.thickness
    kernel = kernel_of(body)
    waves, shares = np.polynomial.legendre.leggauss(60)
    # finer towards long waves, where hard layers on soft bases bend
    ends = np.concatenate([[0.0], np.geomspace(1e-4, 1.0, 9), np.arange(2.0, 22.0)])
    q = np.concatenate([0.5 * ((b - a) * waves + a + b) for a, b in itertools.pairwise(ends)])
    dq = np.concatenate([0.5 * (b - a) * shares for a, b in itertools.pairwise(ends)])
    rest = (kernel(q) - 1.0) * dq / h

    def transformed(u: Array) -> Array:
        return np.cos(np.multiply.outer(u / h, q)) @ rest

    g = body.layer.shear_modulus / (1.0 - body.layer.poisson_ratio)
    places = np.append(t, contact)
    matrix = (transformed(np.subtract.outer(places, t)) + transformed(np.add.outer(places, t))) * w / np.pi
    # phi = by_one * approach + by_curve, at the points and at the rim, where it vanishes
    own = np.eye(points)
    right = 2.0 / np.pi * g * np.stack([np.ones(points), -(t**2) / radius], axis=1)
    inside = np.linalg.solve(own + matrix[:-1], right)
    rim = 2.0 / np.pi * g * np.array([1.0, -(contact**2) / radius]) - matrix[-1] @ inside
    approach = float(-rim[1] / rim[0])
    phi = inside @ np.array([approach, 1.0])
    # the slope of phi, which is even, for the pressure
    fit = np.polynomial.Chebyshev.fit(np.append(-t, t), np.append(phi, phi), 40, domain=[-contact, contact])
    slope = fit.deriv()

    def pressure(r: Array) -> Array:
        # -int_r^a phi'(t) / sqrt(t^2 - r^2) dt, with t = r cosh s
        r = np.asarray(r)
        upper = np.arccosh(contact / r)
        s = 0.5 * np.multiply.outer(upper, nodes + 1.0)
        return np.asarray(-(slope(r[..., None] * np.cosh(s)) @ weights) * 0.5 * upper)

    return float(2.0 * np.pi * (w @ phi)), approach, pressure


def pressed(
    body: mtb.Layered, radius: float, contact: float, cells: int, force: float
) -> tuple[mtb.NormalResult, Array]:
    """A rigid sphere on a layer, on so many cells over its radius of contact."""
    step = contact / cells
    n = 2 * round(1.3 * cells)
    x = (np.arange(n) - 0.5 * (n - 1)) * step
    gap = (x[None, :] ** 2 + x[:, None] ** 2) / (2.0 * radius)
    result = mtb.solve_normal(gap, step, lower=body, upper=mtb.Rigid(), force=force, tolerance=1e-10)
    return result, np.hypot(*np.meshgrid(x, x))


@each_body
def test_a_sphere_on_a_layer_is_that_of_the_integral_equation(body: mtb.Layered) -> None:
    radius, contact = 0.3, 1.7e-3
    force, approach, pressure = sphere(body, radius, contact)
    assert sphere(body, radius, contact, points=120)[0] == pytest.approx(force, rel=1e-9)
    errors, fields = [], []
    for cells in (12, 24, 48):
        result, r = pressed(body, radius, contact, cells, force)
        errors.append(abs(result.approach / approach - 1.0))
        within = r < 0.8 * contact
        exact = pressure(r[within])
        fields.append(np.linalg.norm(result.pressure[within] - exact) / np.linalg.norm(exact))
    assert errors[-1] < 1e-4
    assert np.log2(errors[0] / errors[-1]) / 2.0 > 1.75
    # second order but for how the rim lies in the cells
    assert fields[-1] < 1e-4
    assert np.log2(fields[0] / fields[-1]) / 2.0 > 1.3


@each_body
def test_waves_are_pressed_flat_by_the_published_kernel(body: mtb.Layered) -> None:
    n, length, height = 32, 4e-3, 1e-8
    k = 2.0 * np.pi * 3 / length
    x = (np.arange(n) + 0.5) * length / n
    gap = np.tile(height * (1.0 - np.cos(k * x)), (4, 1))
    spacing = (length / n, 1e-4)
    g = body.layer.shear_modulus / (1.0 - body.layer.poisson_ratio)
    amplitude = height * g * k / float(kernel_of(body)(np.array([k * body.thickness]))[0])
    mean = 3.0 * amplitude
    result = mtb.solve_normal(
        gap, spacing, lower=body, upper=mtb.Rigid(), force=mean * gap.size * spacing[0] * spacing[1],
        periodic=True, tolerance=1e-12,
    )  # fmt: skip
    expected = np.broadcast_to(mean + amplitude * np.cos(k * x), gap.shape)
    np.testing.assert_allclose(result.pressure, expected, rtol=1e-9)
    sunk = mean * body.mean_compliance
    assert result.approach == pytest.approx(height + sunk, rel=1e-9)


# --- all nine components, by the Fourier integral of an own program ----------------------------------------


def airy(z: float) -> Array:
    """Four solutions f of f^(4) - 2 f^(2) + f = 0 with their derivatives to the third (4, 4).

    Series that start with 1, z, z^2 and z^3, or, where these grow, exponentials with and without the depth.
    """
    if z < 3.0:
        found = np.zeros((4, 4))
        for m in range(4):
            c = np.zeros(64)
            c[m] = 1.0
            for n in range(60):
                product = (n + 4) * (n + 3) * (n + 2) * (n + 1)
                c[n + 4] = (2 * (n + 2) * (n + 1) * c[n + 2] - c[n]) / product
            p = np.polynomial.Polynomial(c)
            found[:, m] = [p.deriv(k)(z) if k else p(z) for k in range(4)]
        return found
    k = np.arange(4)
    e, back = np.exp(z), np.exp(-z)
    return np.stack([e + 0.0 * k, back * (-1.0) ** k, (k + z) * e, (z - k) * back * (-1.0) ** k], axis=1)


def surface(q: float, body: mtb.Layered) -> Array:
    """G k times displacements (x, z) by tractions (x, z) of a wave along x, by Airy's function."""
    g, nu = body.layer.shear_modulus, body.layer.poisson_ratio

    def states(f: Array) -> Array:
        """Displacements u sin, w cos (times G) and stresses shear sin, normal cos of Airy functions f cos."""
        # stresses: xx = f'' cos, zz = -f cos, xz = f' sin; 2 G e_xx = (1 - nu) xx - nu zz; u' - w = xz / G
        along = 0.5 * ((1 - nu) * f[2] + nu * f[0])
        into = 0.5 * ((1 - nu) * f[3] + nu * f[1]) - f[1]
        return np.stack([along, into, f[1], -f[0]])

    # one set of four solutions at both depths
    at_top = np.diag([1.0, 1.0, 2.0, 6.0])
    if q >= 3.0:
        k = np.arange(4)
        at_top = np.stack([1.0 + 0.0 * k, (-1.0) ** k, 1.0 * k, -k * (-1.0) ** k], axis=1)
    top, bottom = states(at_top), states(airy(q))
    if isinstance(body.base, mtb.Rigid):
        conditions = bottom[:2]
    else:
        base = body.base
        share = g / base.shear_modulus
        below = share * np.array(
            [
                [1 - base.poisson_ratio, base.poisson_ratio - 0.5],
                [base.poisson_ratio - 0.5, 1 - base.poisson_ratio],
            ]
        )
        conditions = bottom[:2] + below @ bottom[2:]
    loads = np.concatenate([-top[2:], conditions])
    amplitudes = np.linalg.solve(loads, np.eye(4)[:, :2])
    return np.asarray(top[:2] @ amplitudes)


@pytest.mark.parametrize("name", ["soft on steel", "hard on steel", "soft on rigid", "rubber on rigid"])
def test_influences_in_all_directions_are_fourier_integrals(name: str) -> None:
    body = BODIES[name]
    g, nu, h = body.layer.shear_modulus, body.layer.poisson_ratio, body.thickness
    cells = (0.4e-3, 0.7e-3)
    n = 5
    core = _mtb_rs.half_space(body.elastic, [(0.0, 0.0, n, n)], cells, True)
    plain = _mtb_rs.half_space((g, nu), [(0.0, 0.0, n, n)], cells, True)
    share = 0.0 if isinstance(body.base, mtb.Rigid) else g / body.base.shear_modulus
    own = np.array([[1 - nu, nu - 0.5], [nu - 0.5, 1 - nu]])
    # what the base changes falls as exp(-2 k h): polar Gauss points, finer towards long waves
    x, w = np.polynomial.legendre.leggauss(40)
    ends = np.concatenate([[1e-9], np.geomspace(1e-6, 0.5, 16), np.arange(1.0, 19.0, 0.5)])
    q = np.concatenate([0.5 * ((b - a) * x + a + b) for a, b in itertools.pairwise(ends)])
    dq = np.concatenate([0.5 * (b - a) * w for a, b in itertools.pairwise(ends)])
    in_plane = np.array([surface(one, body) - own for one in q])
    across = (share + np.tanh(q)) / (1 + share * np.tanh(q)) - 1.0
    angles = (np.arange(256) + 0.5) * np.pi / 128
    k = q / h
    kx, ky = (np.multiply.outer(k, f(angles)) for f in (np.cos, np.sin))
    # the transform of a cell, over its area; the integral over k dk of what falls with 1 / k
    cell = np.sinc(kx * cells[0] / (2 * np.pi)) * np.sinc(ky * cells[1] / (2 * np.pi))
    weights = cell * cells[0] * cells[1] * (dq / h)[:, None] * (np.pi / 128) / (4 * np.pi**2 * g)
    c, s = np.cos(angles), np.sin(angles)
    along, mixed, normal = in_plane[:, 0, 0], in_plane[:, 0, 1], in_plane[:, 1, 1]
    size = (1 - nu) * cells[0] / g
    for i, j in ((0, 0), (1, 0), (2, 3), (4, 1)):
        phase = kx * (i * cells[0]) + ky * (j * cells[1])
        even, odd = np.cos(phase) * weights, np.sin(phase) * weights
        tensor = {
            ("n", "n"): (even * normal[:, None]).sum(),
            ("x", "x"): (even * (along[:, None] * c**2 + across[:, None] * s**2)).sum(),
            ("y", "y"): (even * (along[:, None] * s**2 + across[:, None] * c**2)).sum(),
            ("x", "y"): (even * (along - across)[:, None] * c * s).sum(),
            ("x", "n"): (odd * mixed[:, None] * c).sum(),
            ("n", "x"): -(odd * mixed[:, None] * c).sum(),
            ("y", "n"): (odd * mixed[:, None] * s).sum(),
        }
        for (observed, loaded), value in tensor.items():
            change = core.influence(observed, loaded) - plain.influence(observed, loaded)
            found = change.reshape(n * n, n * n)[j * n + i, 0]
            assert abs(found - value) < 1e-8 * size, (observed, loaded, i, j)


# --- limits ----------------------------------------------------------------------------------------------

X = (np.arange(24) - 11.5) * 0.2e-3
GAP = (X[None, :] ** 2 + 1.4 * X[:, None] ** 2) / 2.0
UPPER = mtb.Material(70e9, 0.33)


@pytest.mark.parametrize(
    ("body", "same", "periods"),
    [
        (mtb.Layered(SOFT, 1e4, STEEL), SOFT, (False, True)),
        (mtb.Layered(SOFT, 1e4, mtb.Rigid()), SOFT, (False,)),
        # ten periods are enough, and leave more digits beside their mean compression
        (mtb.Layered(SOFT, 0.05, mtb.Rigid()), SOFT, (True,)),
        (mtb.Layered(HARD, 1e-15, SOFT), SOFT, (False, True)),
        (mtb.Layered(SOFT, 1e-15, STEEL, bonded=False), STEEL, (False, True)),
        (mtb.Layered(STEEL, 0.3e-3, STEEL), STEEL, (False, True)),
    ],
    ids=["thick", "thick on rigid", "ten periods on rigid", "thin", "thin and loose", "one material"],
)
def test_limits_are_half_spaces(body: mtb.Layered, same: mtb.Material, periods: tuple[bool, ...]) -> None:
    for periodic in periods:
        found, expected = (
            mtb.solve_normal(
                GAP, 0.2e-3, lower=lower, upper=UPPER, force=30.0, periodic=periodic, tolerance=1e-11
            )
            for lower in (body, same)
        )
        apart = np.abs(found.pressure - expected.pressure).max()
        assert apart < 1e-8 * expected.pressure.max()
        sunk = 30.0 / found.area.sum() * body.mean_compliance if periodic else 0.0
        assert found.approach - sunk == pytest.approx(expected.approach, rel=1e-8)


def test_a_thin_compressible_layer_is_the_thin_layer_in_first_order() -> None:
    errors = []
    for h in (1e-5, 0.5e-5, 0.25e-5):
        layer = mtb.ThinLayer(h, SOFT.young_modulus, SOFT.poisson_ratio)
        thin = mtb.solve_normal(
            GAP, 0.2e-3, lower=mtb.Rigid(), upper=mtb.steel, force=30.0, normal_layer=layer, tolerance=1e-10
        )
        whole = mtb.solve_normal(
            GAP, 0.2e-3, lower=mtb.Layered(SOFT, h, mtb.Rigid()), upper=mtb.steel, force=30.0, tolerance=1e-10
        )
        errors.append(np.linalg.norm(whole.pressure - thin.pressure) / np.linalg.norm(whole.pressure))
    assert errors[-1] < 5e-3
    assert np.log2(errors[0] / errors[-1]) / 2.0 > 0.9


PEER = json.loads((Path(__file__).parents[1] / "data" / "layer" / "finite_thickness.json").read_text())


@pytest.mark.parametrize(
    "case", PEER["cases"], ids=lambda case: f"{case['thickness']} {case['poisson_ratio']}"
)
def test_a_ball_on_a_layer_is_that_of_contactmechanics(case: dict[str, Any]) -> None:
    n, cell = PEER["cells"], 1e-3 * PEER["side"] / PEER["cells"]
    x = (np.arange(n) - n // 2) * cell
    gap = (x[:, None] ** 2 + x[None] ** 2) / (2e-3 * PEER["radius"])
    pad = mtb.Layered(
        mtb.Material(1e6 * PEER["young_modulus"], case["poisson_ratio"]),
        1e-3 * case["thickness"],
        mtb.Rigid(),
    )
    found = mtb.solve_normal(
        gap, cell, lower=pad, upper=mtb.Rigid(), force=PEER["force"], periodic=True, tolerance=1e-11
    )
    peer = 1e6 * np.array(case["pressure"])
    # its search ends at penetrations of 1e-12 mm, of the 3e-3 mm and more that the ball comes down
    assert found.pressure[n // 2] == pytest.approx(peer, abs=1e-7 * peer.max())
    assert found.approach == pytest.approx(1e-3 * case["approach"], rel=1e-8)
    assert (found.pressure > 0.0).mean() == case["share_in_contact"]
