# SPDX-License-Identifier: MIT OR Apache-2.0
"""Stress inside layered bodies against Airy's functions of waves, limits, equilibrium and continuity."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import mtb_rs as mtb
from mtb_rs import _mtb_rs

SOFT = mtb.Material(3e9, 0.42)
STEEL = mtb.Material(208e9, 0.28)
COMPONENTS = ("xx", "yy", "zz", "yz", "xz", "xy")
Array = NDArray[np.float64]


def constants(material: mtb.Material) -> tuple[float, float]:
    return material.shear_modulus, material.poisson_ratio


def at(body: mtb.Layered | mtb.HalfSpace, loads: Any, points: Any, sides: tuple[float, float]) -> Array:
    """Stress (n, 6) at points (n, 3) by tractions (3,) on one cell about the origin."""
    cell = np.array([[0.0, 0.0, *sides]])
    return np.asarray(
        _mtb_rs.stress_at(body.inside, cell, np.array(loads, dtype=float)[:, None], np.array(points))
    )


def plane_waves(
    k: Array, layer: tuple[float, float], base: tuple[float, float] | None, h: float, z: float
) -> tuple[Array, Array]:
    """Amplitudes (3, 2, n) of zz, xx (cosines) and xz (sine) at a depth by the waves of a pressure
    ``cos k x`` and of a traction ``sin k x``, and of tz and lt (2, n) by a wave across.

    Airy's function is ``f(z) cos k x`` with ``(A + B z) exp(-k z) + (C + D (z - h)) exp(k (z - h))`` in the
    layer and ``(E + F (z - h)) exp(-k (z - h))`` in the base; its six constants follow from the two tractions
    above and the four conditions at the interface.
    """

    def falling(sign: float, from_: float, at_: float) -> list[list[Array]]:
        """Derivatives 0 to 3 of exp(s k (z - z0)) and of (z - z0) times it, s = sign."""
        w, s = at_ - from_, sign * k
        e = np.exp(s * w)
        return [
            [s**n * e for n in range(4)],
            [(w * s**n + n * s ** (n - 1.0) if n else w + 0.0 * k) * e for n in range(4)],
        ]

    def states(basis: list[list[Array]], g: float, nu: float) -> Array:
        """zz, xx, xz, u and w (5, functions, n)."""
        rows = []
        for f, d1, d2, d3 in basis:
            u = ((1.0 - nu) * d2 + nu * k**2 * f) / (2.0 * g * k)
            du = ((1.0 - nu) * d3 + nu * k**2 * d1) / (2.0 * g * k)
            rows.append([-(k**2) * f, d2, k * d1, u, -(k * d1 / g - du) / k])
        return np.moveaxis(np.array(rows), 0, 1)

    def of_layer(place: float) -> Array:
        return states(falling(-1.0, 0.0, place) + falling(1.0, h, place), *layer)

    n = k.size
    matrix, given = np.zeros((n, 6, 6)), np.zeros((n, 6, 2))
    top, bottom = of_layer(0.0), of_layer(h)
    matrix[:, 0, :4], matrix[:, 1, :4] = top[0].T, top[2].T
    given[:, 0, 0], given[:, 1, 1] = -1.0, -1.0
    below = states(falling(-1.0, h, h), *(base or layer))
    # zz and xz go on, and so do u and w, which vanish on a rigid base
    for row, component in enumerate((0, 2, 3, 4)):
        matrix[:, 2 + row, :4] = bottom[component].T
        matrix[:, 2 + row, 4:] = -below[component].T
    if base is None:
        # the base's own constants are then no unknowns
        matrix[:, 2:4] = 0.0
        matrix[:, 2, 4] = matrix[:, 3, 5] = 1.0
        matrix[:, 4:, 4:] = 0.0
    # rows of one size
    scale = np.abs(matrix).max(axis=2, keepdims=True)
    found = np.linalg.solve(matrix / scale, given / scale)
    if z <= h:
        here = np.einsum("cfn,nfl->cln", of_layer(z)[:3], found[:, :4])
    else:
        here = np.einsum("cfn,nfl->cln", states(falling(-1.0, h, z), *(base or layer))[:3], found[:, 4:])
    # across: displacement over the traction at the interface, then downwards
    b = layer[0] / base[0] if base else 0.0
    above = np.cosh(k * h) + b * np.sinh(k * h)
    if z <= h:
        left = k * (h - z)
        across = [-(np.cosh(left) + b * np.sinh(left)) / above, (np.sinh(left) + b * np.cosh(left)) / above]
    else:
        across = [-np.exp(-k * (z - h)) / above, np.exp(-k * (z - h)) / above]
    return here, np.array(across)


def by_waves(
    body: mtb.Layered, loads: tuple[float, float, float], point: tuple[float, float, float], side: float
) -> Array:
    """Stress (6,) by tractions on a square as a double integral over its waves."""
    x, y, z = point
    base = body.base if isinstance(body.base, mtb.Material) else None
    # long waves find a base of any stiffness
    ends = np.concatenate([[0.0], 0.5 / z * 4.0 ** np.arange(-16.0, 0.0), np.linspace(0.5, 36.0, 60) / z])
    nodes, weights = np.polynomial.legendre.leggauss(12)
    half = 0.5 * np.diff(ends)[:, None]
    k = (ends[:-1, None] + half * (1.0 + nodes)).ravel()
    dk = (half * weights).ravel()
    turns = 256
    theta = 2.0 * np.pi * (np.arange(turns) + 0.5) / turns
    c, s = np.cos(theta)[:, None], np.sin(theta)[:, None]
    nu = (body.layer if z <= body.thickness or base is None else base).poisson_ratio
    waves, (tz, lt) = plane_waves(
        k, constants(body.layer), constants(base) if base else None, body.thickness, z
    )
    # from cosines and sines to the complex wave
    along, across = c * loads[0] + s * loads[1], c * loads[1] - s * loads[0]
    pressed, dragged = waves[:, 0], waves[:, 1]
    zz = loads[2] * pressed[0] + 1j * along * dragged[0]
    ll = loads[2] * pressed[1] + 1j * along * dragged[1]
    lz = -1j * loads[2] * pressed[2] + along * dragged[2]
    tt = nu * (zz + ll)
    tz, lt = across * tz, 1j * across * lt
    stress = [
        ll * c**2 + tt * s**2 - 2.0 * lt * c * s,
        ll * s**2 + tt * c**2 + 2.0 * lt * c * s,
        zz,
        lz * s + tz * c,
        lz * c - tz * s,
        (ll - tt) * c * s + lt * (c**2 - s**2),
    ]
    square = side**2 * np.sinc(k * c * side / (2.0 * np.pi)) * np.sinc(k * s * side / (2.0 * np.pi))
    wave = square * np.exp(1j * k * (c * x + s * y)) * k * dk * (2.0 * np.pi / turns) / (4.0 * np.pi**2)
    return np.array([(component * wave).sum().real for component in stress])


BODIES = {
    "coating": mtb.Layered(STEEL, 0.8e-3, SOFT),
    "pad": mtb.Layered(SOFT, 0.8e-3, STEEL),
    "rigid base": mtb.Layered(SOFT, 0.8e-3, mtb.Rigid()),
    "incompressible": mtb.Layered(mtb.Material(5e6, 0.5), 0.8e-3, mtb.Rigid()),
}


@pytest.mark.parametrize("name", BODIES)
@pytest.mark.parametrize("loads", [(1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)])
def test_a_loaded_square_on_a_layer(name: str, loads: tuple[float, float, float]) -> None:
    body, side = BODIES[name], 1e-3
    places = [(0.2e-3, -0.3e-3, 0.4e-3), (0.9e-3, 0.7e-3, 0.8e-3)]
    if isinstance(body.base, mtb.Material):
        places.append((-0.4e-3, 0.6e-3, 1.7e-3))
    found = at(body, loads, places, (side, side))
    for place, own in zip(places, found, strict=True):
        # the waves end at exp(-36), and their quadrature is as good
        assert own == pytest.approx(by_waves(body, loads, place, side), abs=2e-10)


def test_the_limits_are_half_spaces() -> None:
    generator = np.random.default_rng(5)
    points = np.stack([*generator.uniform(-4e-3, 4e-3, (2, 12)), generator.uniform(1e-6, 4e-3, 12)], axis=1)
    soft, hard = mtb.HalfSpace(SOFT), mtb.HalfSpace(STEEL)
    for loads in np.eye(3):
        for thickness in (1e-5, 1e-3, 3e-3):
            same = at(mtb.Layered(SOFT, thickness, SOFT), loads, points, (1e-3, 0.6e-3))
            assert same == pytest.approx(at(soft, loads, points, (1e-3, 0.6e-3)), abs=1e-10)
        # the base is felt by the square of the size over the thickness, and a thin layer by its thickness
        thick = [at(mtb.Layered(SOFT, h, STEEL), loads, points, (1e-3, 0.6e-3)) for h in (1.0, 1e3)]
        apart = [np.abs(one - at(soft, loads, points, (1e-3, 0.6e-3))).max() for one in thick]
        assert apart[0] < 1e-5
        assert apart[1] < 1e-8
        thin = at(mtb.Layered(SOFT, 1e-12, STEEL), loads, points, (1e-3, 0.6e-3))
        assert thin == pytest.approx(at(hard, loads, points, (1e-3, 0.6e-3)), abs=1e-7)


def test_tractions_are_recovered_and_go_through_the_interface() -> None:
    body, loads = mtb.Layered(SOFT, 0.5e-3, STEEL), (0.3, -0.2, 1.0)
    (surface,) = at(body, loads, [(0.1e-3, 0.2e-3, 0.0)], (1e-3, 1e-3))
    assert surface[2:5] == pytest.approx([-1.0, 0.2, -0.3], abs=1e-10)
    (beside,) = at(body, loads, [(0.8e-3, 0.2e-3, 0.0)], (1e-3, 1e-3))
    assert beside[2:5] == pytest.approx(0.0, abs=1e-10)
    over, under = at(
        body, loads, [(0.3e-3, 0.1e-3, 0.5e-3), (0.3e-3, 0.1e-3, 0.5e-3 * (1.0 + 1e-11))], (1e-3, 1e-3)
    )
    assert under[2:5] == pytest.approx(over[2:5], abs=1e-9)
    # what does not go through does jump
    assert np.abs(under[:2] - over[:2]).min() > 0.1


@pytest.mark.parametrize("depth", [0.3e-3, 1.1e-3])
def test_the_stress_is_in_equilibrium(depth: float) -> None:
    body, loads, middle = (
        mtb.Layered(STEEL, 0.7e-3, SOFT),
        (0.5, 0.4, 1.0),
        np.array([0.35e-3, 0.2e-3, depth]),
    )
    worst = []
    for step in (4e-5, 2e-5):
        sums = np.zeros(3)
        rows = np.array([[0, 5, 4], [5, 1, 3], [4, 3, 2]])
        for axis in range(3):
            away = np.zeros((4, 3))
            away[:, axis] = step * np.array([-2.0, -1.0, 1.0, 2.0])
            stress = at(body, loads, middle + away, (1e-3, 1e-3))
            change = np.array([1.0, -8.0, 8.0, -1.0]) @ stress / (12.0 * step)
            sums += change[rows[axis]]
        worst.append(np.abs(sums).max() * 1e-3)
    assert worst[1] < 1e-4
    # the differences are of fourth order
    assert worst[0] / worst[1] > 12.0


def test_below_grids_as_at_points() -> None:
    x = (np.arange(14) - 6.5) * 0.1e-3
    gap = (x[None] ** 2 + x[:, None] ** 2) / 0.2
    coat = mtb.Layered(STEEL, 0.15e-3, SOFT)
    pressed = mtb.solve_normal(gap, 0.1e-3, lower=coat, upper=coat, force=2.0)
    rolled = mtb.solve_tangential(pressed, mtb.Rolling((1e-3, 2e-4, 0.3)), mtb.Coulomb(0.3))
    for body in ("lower", "upper"):
        below = rolled.stress(body, depths=[0.0, 0.15e-3, 0.4e-3])
        points = rolled.stress(body, points=below.points)
        assert points.stress == pytest.approx(below.stress, abs=1e-9 * np.abs(below.stress).max())
        assert below.zz[0] == pytest.approx(-below.pressure, abs=1e-9 * below.peak_pressure)
        assert np.stack([below.xz[0], below.yz[0]]) == pytest.approx(
            rolled.traction[:2], abs=1e-9 * below.peak_pressure
        )


@pytest.mark.parametrize("name", BODIES)
def test_a_strip_is_in_plane_strain(name: str) -> None:
    body, strip = BODIES[name], (1e-3, 1e6)
    for z in (0.3e-3, 0.8e-3):
        for loads in ((1.0, 0.0, 0.0), (0.0, 0.0, 1.0)):
            (found,) = at(body, loads, [(0.3e-3, 0.0, z)], strip)
            xx, yy, zz, yz, _, xy = found
            # a million times as long as wide: tables over twenty octaves leave 1e-8
            assert yy == pytest.approx(body.layer.poisson_ratio * (xx + zz), abs=5e-8)
            assert [yz, xy] == pytest.approx([0.0, 0.0], abs=1e-9)


def test_a_rigid_base_has_no_stress() -> None:
    x = (np.arange(40) - 19.5) * 0.05e-3
    pad = mtb.Layered(SOFT, 0.3e-3, mtb.Rigid())
    pressed = mtb.solve_normal(
        x[None] ** 2 / 0.2 + x[:, None] ** 2 / 0.2, 0.05e-3, lower=mtb.Rigid(), upper=pad, force=2.0
    )
    # depths that are not given end where the layer does
    assert pressed.stress("upper").depths[-1] == pytest.approx(0.3e-3, rel=1e-12)
    words = r"place 1 is 0\.0004 m deep in the upper body, whose layer ends at 0\.0003 m: its base is rigid"
    with pytest.raises(ValueError, match=words):
        pressed.stress("upper", depths=[0.1e-3, 0.4e-3])
    with pytest.raises(ValueError, match="place 0 is"):
        pressed.stress("upper", points=[[0.0], [0.0], [0.4e-3]])
    with pytest.raises(ValueError, match="the lower body is Rigid, and has no stress"):
        pressed.stress()


@pytest.mark.parametrize("bonded", [True, False])
def test_waves_below_a_periodic_contact(bonded: bool) -> None:
    n, period, h = 32, 1e-3, 0.2e-3
    x = np.arange(n) * period / n
    gap = np.broadcast_to(1e-9 * np.cos(2.0 * np.pi * x / period), (8, n))
    body = mtb.Layered(SOFT, h, STEEL, bonded=bonded)
    pressed = mtb.solve_normal(
        gap, period / n, lower=body, upper=mtb.Rigid(), force=8 * n * (period / n) ** 2 * 50e3, periodic=True
    )
    mean = pressed.pressure.mean()
    depths = [0.1e-3, 0.5e-3]
    found = pressed.stress(depths=depths)
    k = np.array([2.0 * np.pi / period])
    amplitude = 2.0 * (pressed.pressure[0] * np.cos(k * x)).mean()
    if not bonded:
        # no shear stress reaches the interface
        assert np.abs(pressed.stress(depths=[h]).xz).max() < 1e-9 * mean
        return
    for row, z in enumerate(depths):
        (zz, xx, xz), _ = plane_waves(k, constants(SOFT), constants(STEEL), h, z)
        assert found.zz[row, 0] == pytest.approx(-mean + amplitude * zz[0] * np.cos(k * x), abs=1e-6 * mean)
        assert 0.5 * np.ptp(found.xx[row, 0]) == pytest.approx(abs(amplitude * xx[0, 0]), rel=1e-6)
        # into the body z falls: a shear stress of the own frame changes its sign
        assert found.xz[row, 0] == pytest.approx(-amplitude * xz[0] * np.sin(k * x), abs=1e-6 * mean)
