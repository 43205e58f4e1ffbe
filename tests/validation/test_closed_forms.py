# SPDX-License-Identifier: MIT OR Apache-2.0
"""The closed forms themselves: against the integrals and conditions that define them."""

from __future__ import annotations

import math

import numpy as np
import pytest

import mtb_rs as mtb
from mtb_rs import _mtb_rs
from mtb_rs.half_space import reference

STEEL = mtb.steel
RUBBER = mtb.Material(young_modulus=20e9, poisson_ratio=0.2)


def integrals_over_hertz(x: float, y: float) -> np.ndarray:
    """Integrals of q/R, q X^2/R^3, q XY/R^3, q X/R^2, q Y/R^2 over the unit disc, q = sqrt(1 - r^2).

    Along a ray from the observed point the load is an arc of an ellipse with a known area.
    """
    r = math.hypot(x, y)
    if r < 1.0:
        angle = (np.arange(720) + 0.5) * 2.0 * math.pi / 720
        weight = np.full(720, 2.0 * math.pi / 720)
    else:
        nodes, weights = np.polynomial.legendre.leggauss(200)
        reach = math.asin(1.0 / r)
        angle = math.atan2(-y, -x) + reach * nodes
        weight = reach * weights
    cos, sin = np.cos(angle), np.sin(angle)
    middle = -(x * cos + y * sin)
    half2 = np.maximum(1.0 - r**2 + middle**2, 0.0)

    def area(u: np.ndarray) -> np.ndarray:
        half = np.sqrt(half2)
        return 0.5 * (
            u * np.sqrt(np.maximum(half2 - u**2, 0.0)) + half2 * np.arcsin(np.clip(u / half, -1, 1))
        )

    line = area(np.sqrt(half2)) - (area(-middle) if r < 1.0 else area(-np.sqrt(half2)))
    kernels = np.stack([np.ones_like(cos), cos**2, cos * sin, -cos, -sin])
    return np.asarray(kernels @ (weight * line))


@pytest.mark.parametrize("body", ["lower", "upper"])
def test_paraboloid_displacements_are_boussinesq_and_cerruti(body: str) -> None:
    exact = reference.SlidingParaboloid(800.0, 4e6, 0.4, STEEL, RUBBER)
    a = exact.contact_radius
    material, sign = (STEEL, 1.0) if body == "lower" else (RUBBER, -1.0)
    g, nu, mu = material.shear_modulus, material.poisson_ratio, 0.4
    for x, y in [(0.1, 0.0), (0.4, -0.7), (-0.3, 0.2), (0.0, 0.99), (1.3, 0.4), (-0.9, -2.0), (5.0, 0.0)]:
        one, xx, xy, dx, dy = integrals_over_hertz(x, y)
        unit = exact.peak_pressure * a / (2.0 * math.pi * g)
        mixed = 0.5 * (1.0 - 2.0 * nu)
        expected = unit * np.array(
            [
                sign * mu * ((1.0 - nu) * one + nu * xx) - mixed * dx,
                sign * mu * nu * xy - mixed * dy,
                -sign * ((1.0 - nu) * one + sign * mu * mixed * dx),
            ]
        )
        value = exact.displacement(a * x, a * y, body)
        assert np.abs(value - expected).max() < 3e-6 * np.abs(expected).max()
    with pytest.raises(ValueError, match="body is 'left'"):
        exact.displacement(0.0, 0.0, "left")


def test_paraboloid_closes_its_own_gap() -> None:
    exact = reference.SlidingParaboloid(1000.0, 5e6, 0.5, STEEL, STEEL)
    # thesis Table 3.1 with (3.1) to (3.3)
    assert exact.contact_radius == pytest.approx(0.3201448, rel=1e-6)
    assert exact.approach == pytest.approx(1.024927e-4, rel=1e-6)
    assert exact.peak_pressure == pytest.approx(2.329263e7, rel=1e-6)
    x, y = np.meshgrid(np.linspace(-0.5, 0.5, 41), np.linspace(-0.5, 0.5, 41))
    r2 = x**2 + y**2
    gap = r2 / 2000.0 - exact.approach
    gap = gap + exact.displacement(x, y, "upper")[2] - exact.displacement(x, y, "lower")[2]
    inside = r2 < exact.contact_radius**2
    assert np.abs(gap[inside]).max() < 1e-12 * exact.approach
    assert gap[~inside].min() > 0.0
    assert exact.displacement(0.0, 0.0)[0] > 0.0  # dragged along


def test_love_agrees_with_the_influence_coefficients() -> None:
    half_sides = (1.5e-3, 1e-3)
    body = _mtb_rs.half_space((80e9, 0.3), [(0.0, 0.0, 5, 4)], (3e-3, 2e-3), True)
    traction = np.zeros((3, 20))
    traction[2, 7] = 1e6
    x, y = np.meshgrid(3e-3 * (np.arange(5) - 2), 2e-3 * (np.arange(4) - 1))
    expected = reference.uniform_rectangle_displacement(x, y, half_sides, 1e6, STEEL).reshape(3, -1)
    assert np.abs(body.displacement(traction) - expected).max() < 1e-13 * np.abs(expected).max()
    centre = reference.uniform_rectangle_displacement(0.0, 0.0, (1.0, 1.0), 1.0, STEEL)[2]
    corner = reference.uniform_rectangle_displacement(1.0, 1.0, (1.0, 1.0), 1.0, STEEL)[2]
    assert centre == pytest.approx(8.0 * math.log(1.0 + math.sqrt(2.0)) * 0.7 / (2.0 * math.pi * 80e9))
    assert centre == pytest.approx(2.0 * corner)


@pytest.mark.parametrize(("friction", "upper"), [(0.0, RUBBER), (0.6, STEEL), (0.9, RUBBER)])
def test_sliding_punch_meets_its_integral_equation(friction: float, upper: mtb.Material) -> None:
    lower = mtb.Material(young_modulus=50e9, poisson_ratio=0.1)
    punch = reference.SlidingFlatPunch(2e-3, 5e4, friction, lower, upper)
    a, g = punch.half_width, punch.exponent
    from scipy.integrate import quad

    def smooth(t: float) -> float:
        t = min(max(t, 1e-9 - 1.0), 1.0 - 1e-9)
        return float(punch.pressure(a * t) / ((1.0 + t) ** (g - 0.5) * (1.0 - t) ** (-g - 0.5)))

    carried = a * quad(smooth, -1.0, 1.0, weight="alg", wvar=(g - 0.5, -g - 0.5))[0]
    assert carried == pytest.approx(punch.force_per_length, rel=1e-10)
    # the relative indentation is flat, and the other body's share of it enters with the opposite friction
    others = (-0.8, -0.1, 0.5)
    indentation = []
    for x in others:
        total = 0.0
        for material, mu in ((lower, friction), (upper, -friction)):
            shear, nu = material.shear_modulus, material.poisson_ratio
            below = punch.load_share(a * x)
            # -(1 - nu)/(pi G) int p ln|x - s| ds + mu (1 - 2 nu)/(4 G) int p sgn(x - s) ds
            total += mu * (1.0 - 2.0 * nu) / (4.0 * shear) * (2.0 * below - 1.0)
            total -= (1.0 - nu) / (math.pi * shear) * _log_potential(punch, x)
        indentation.append(total * punch.force_per_length)
    scale = punch.force_per_length * (1.0 - 0.1) / lower.shear_modulus
    assert np.ptp(indentation) < 1e-6 * scale
    # where the lower body gives way sideways more than the upper one, the rear carries more
    assert (punch.pressure(-0.5 * a) > punch.pressure(0.5 * a)) == (
        friction * reference.dundurs_beta(lower, upper) > 0.0
    )
    assert reference.dundurs_beta(STEEL, STEEL) == 0.0


def _log_potential(punch: reference.SlidingFlatPunch, x: float) -> float:
    """Mean of ln|x - s| over the pressure, s in half-widths."""
    from scipy.integrate import quad

    a, g = punch.half_width, punch.exponent
    unit = a / punch.force_per_length
    total = 0.0
    for edge, exponent in ((-1.0, g - 0.5), (1.0, -g - 0.5)):
        power = 1.0 / (1.0 + exponent)
        length = abs(x - edge)

        def integrand(t: float, edge: float = edge, power: float = power, length: float = length) -> float:
            d = length * t**power
            if d <= 0.0 or d >= length:
                return 0.0
            pressure = float(punch.pressure(a * (edge - math.copysign(d, edge)))) * unit
            return pressure * math.log(length - d) * length * power * t ** (power - 1.0)

        total += quad(integrand, 0.0, 1.0, limit=200, epsabs=1e-8, epsrel=1e-8)[0]
    return total


def test_flat_punch_and_wave_carry_their_loads() -> None:
    from scipy.integrate import quad

    punch = reference.FlatPunch(0.01, 1e4, STEEL, RUBBER)
    carried = quad(
        lambda t: 2.0 * math.pi * punch.pressure(0.01 * math.sin(t)) * 1e-4 * math.sin(t) * math.cos(t),
        0,
        math.pi / 2,
    )
    assert carried[0] == pytest.approx(1e4, rel=1e-8)
    # the centre sinks by the approach: int p 2 pi r / r dr (1 - nu) / (2 pi G), both bodies
    depth = sum((1.0 - m.poisson_ratio) / m.shear_modulus for m in (STEEL, RUBBER))
    depth *= quad(lambda t: punch.pressure(0.01 * math.sin(t)) * 0.01 * math.cos(t), 0, math.pi / 2)[0]
    assert depth == pytest.approx(punch.approach, rel=1e-8)
    for share in (0.1, 0.7, 1.3):
        wave = reference.WavyContact(1e-6, 2e-3, 1.0, STEEL, STEEL)
        wave = reference.WavyContact(1e-6, 2e-3, share * wave.full_contact_pressure, STEEL, STEEL)
        edge = wave.half_width
        assert (edge == pytest.approx(1e-3)) is (share > 1.0)
        mean = quad(wave.pressure, -edge, edge, limit=200)[0] / wave.wavelength
        assert mean == pytest.approx(wave.mean_pressure, rel=1e-7)
