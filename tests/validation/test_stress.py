# SPDX-License-Identifier: MIT OR Apache-2.0
"""Stress below the surface of half-spaces: closed forms, CONTACT, an own quadrature of point loads."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import mtb_rs as mtb

Array = NDArray[np.float64]
DATA = Path(__file__).parents[1] / "data" / "contact"
CASES = json.loads((DATA / "subsurface.json").read_text())["cases"]
FIELDS = np.load(DATA / "subsurface.npz")
STEEL = mtb.Material.from_shear_modulus(82e9, 0.28)
THIRD = mtb.Material(208e9, 0.3)


def rolled(
    pressure: Array,
    traction: Array,
    spacing: tuple[float, float],
    material: mtb.Material = STEEL,
    reference: float | None = None,
) -> mtb.FoundationResult:
    """A result that has these tractions on the lower body."""
    ny, nx = pressure.shape
    dx, dy = spacing
    x, y = (np.arange(nx) - 0.5 * (nx - 1)) * dx, (np.arange(ny) - 0.5 * (ny - 1)) * dy
    area = np.full(pressure.shape, dx * dy)
    return mtb.FoundationResult(
        points=np.stack(np.meshgrid(x, y)),
        area=area,
        pressure=pressure,
        traction=np.concatenate([traction, np.zeros((1, ny, nx))]),
        slip=np.zeros((2, ny, nx)),
        status=np.ones((ny, nx), dtype=np.int8),
        force=np.zeros(3),
        spin_moment=0.0,
        lower=mtb.HalfSpace(material),
        upper=mtb.HalfSpace(material),
        is_line=reference is not None,
    )


@pytest.mark.parametrize("case", CASES, ids=lambda case: str(case["name"]))
def test_the_stress_is_that_of_contact(case: dict[str, Any]) -> None:
    # its body 1 is the upper one, with z into it; its tractions act on that body; six digits are printed
    name, grid = case["name"], case["grid"]
    pressure, px, py = (1e6 * FIELDS[f"{name}/{key}"].astype(float) for key in ("pn", "px", "py"))
    spacing = (1e-3 * grid["dx"], 1e-3 * grid["dy"])
    result = rolled(pressure, np.stack([-px, -py]), spacing)
    points = 1e-3 * FIELDS[f"{name}/points"].astype(float).T
    shift = 1e-3 * np.array([grid["x0"] + 14 * grid["dx"], grid["y0"] + 14 * grid["dy"], 0.0])
    found = result.stress("upper", points=points - shift[:, None])
    xx, xy, xz, yy, yz, zz = 1e6 * FIELDS[f"{name}/sigma"].astype(float).T
    known = np.stack([xx, yy, zz, yz, xz, xy])
    assert found.stress == pytest.approx(known, abs=5e-6 * np.abs(known).max())
    mises = 1e6 * FIELDS[f"{name}/mises"].astype(float)
    assert found.von_mises == pytest.approx(mises, abs=5e-6 * mises.max())


@pytest.mark.parametrize("case", CASES, ids=lambda case: str(case["name"]))
def test_a_contact_solved_here_has_the_stress_of_contact(case: dict[str, Any]) -> None:
    name = case["name"]
    n, d = 29, 0.3e-3
    x = (np.arange(n) - n // 2) * d
    gap = (x[None] ** 2 + x[:, None] ** 2) * 1.0
    normal = mtb.solve_normal(gap, d, lower=STEEL, upper=STEEL, force=10e3, tolerance=1e-10)
    result: Any = normal
    if case["inputs"]["kind"] == "steady":
        xi, eta, _ = (float(word) for word in case["inputs"]["creepages_or_shift"].split())
        motion = mtb.Rolling((xi, eta, 0.0), velocity=1.0)
        result = mtb.solve_tangential(normal, motion, mtb.Coulomb(0.3), tolerance=1e-10)
    points = 1e-3 * FIELDS[f"{name}/points"].astype(float).T
    found = result.stress("upper", points=points)
    xx, xy, xz, yy, yz, zz = 1e6 * FIELDS[f"{name}/sigma"].astype(float).T
    known = np.stack([xx, yy, zz, yz, xz, xy])
    assert np.abs(found.stress - known).max() < 5e-3 * np.abs(known).max()


def test_the_middle_of_a_uniform_square() -> None:
    # side 1, p = 1, nu = 0.28, q = 0.999: three digits of CONTACT rev. 2707, at depths of tenths of a side
    pressed = rolled(np.ones((1, 1)) * 1e6, np.zeros((2, 1, 1)), (1e-3, 1e-3))
    deep = np.linspace(0.0, 1e-3, 11)
    below = pressed.stress(depths=deep)
    assert below.xx[0, 0, 0] == pytest.approx(-0.78e6, rel=1e-12)
    assert below.yy[0, 0, 0] == pytest.approx(-0.5 * (1.0 + 2.0 * 0.28) * 1e6, rel=1e-12)
    peak, place = below.maximum()
    assert peak == pytest.approx(0.665e6, abs=0.0005e6)
    assert place[2] == pytest.approx(-0.4e-3)
    rubbed = rolled(np.ones((1, 1)) * 1e6, 0.999e6 * np.array([[[1.0]], [[0.0]]]), (1e-3, 1e-3))
    assert rubbed.stress(depths=[0.0]).von_mises[0, 0, 0] == pytest.approx(1.744e6, abs=0.0005e6)


def orders(errors: list[float]) -> Array:
    return np.log2(np.array(errors[:-1]) / np.array(errors[1:]))


def test_below_a_hertzian_point_contact() -> None:
    # [Johnson1985, eq. 3.45] along the axis; 0.310 p0 at 0.48 a for nu = 0.3
    a, p0, nu = 1e-3, 1e9, 0.3
    z = a * np.linspace(0.1, 2.0, 39)
    zz = -p0 / (1.0 + (z / a) ** 2)
    side = -p0 * ((1.0 + nu) * (1.0 - z / a * np.arctan(a / z)) - 0.5 / (1.0 + (z / a) ** 2))
    errors = []
    for n in (20, 40, 80, 160):
        d = 2.0 * a / n
        x = (np.arange(n) - 0.5 * (n - 1)) * d
        # the mean over each cell, so that no error of a border cell hides that of the cells
        fine = (x[:, None] + d * (np.arange(8) - 3.5)[None] / 8.0).ravel()
        square = 1.0 - (fine[None] ** 2 + fine[:, None] ** 2) / a**2
        pressure = p0 * np.sqrt(np.maximum(square, 0.0)).reshape(n, 8, n, 8).mean(axis=(1, 3))
        result = rolled(pressure, np.zeros((2, n, n)), (d, d), THIRD)
        found = result.stress(points=np.stack([np.zeros_like(z), np.zeros_like(z), -z]))
        known = np.stack([side, side, zz])
        errors.append(float(np.abs(found.stress[:3] - known).max() / p0))
        assert np.abs(found.stress[3:]).max() < 1e-9 * p0
    assert np.all(orders(errors[:3]) > 1.8), errors
    assert errors[-1] < 1e-4
    hertz = mtb.hertz(1e3, 0.02, lower=THIRD, upper=THIRD)
    deep = hertz.semi_axes[0] * np.linspace(0.3, 0.7, 81)
    at = hertz.stress(points=np.stack([np.zeros_like(deep), np.zeros_like(deep), -deep]))
    value, place = at.maximum("largest_shear")
    assert value / hertz.peak_pressure == pytest.approx(0.310, abs=0.0005)
    assert -place[2] / hertz.semi_axes[0] == pytest.approx(0.48, abs=0.005)


def mcewen(x: Array, z: Array, a: float, p0: float) -> tuple[Array, Array, Array]:
    """xx, zz, xz below a line contact [Johnson1985, eq. 4.49; McEwen1949], z into the body."""
    inner = a * a - x * x + z * z
    root = np.sqrt(inner**2 + 4.0 * x * x * z * z)
    m, n = np.sqrt(0.5 * (root + inner)), np.sign(x) * np.sqrt(np.maximum(0.5 * (root - inner), 0.0))
    share = (z * z + n * n) / (m * m + n * n)
    return (
        -p0 / a * (m * (1.0 + share) - 2.0 * z),
        -p0 / a * m * (1.0 - share),
        -p0 / a * n * (m * m - z * z) / (m * m + n * n),
    )


def line_integral(x: Array, z: Array, a: float, load: Any, part: int) -> Array:
    """Stress xx, zz, xz by a strip with a load: Flamant's point loads [Johnson1985, eq. 2.23]."""
    s, weight = np.polynomial.legendre.leggauss(500)
    # dense at the ends of the strip, where the load has roots
    t, weight = a * np.sin(0.5 * np.pi * s), weight * a * 0.5 * np.pi * np.cos(0.5 * np.pi * s)
    away = x[..., None] - t
    fourth = (away**2 + z[..., None] ** 2) ** 2
    powers = ((2, 1), (0, 3), (1, 2)) if part == 0 else ((3, 0), (1, 2), (2, 1))
    i, j = zip(*powers, strict=True)
    loads = load(t) * weight
    sums = [(away**k * z[..., None] ** m / fourth * loads).sum(axis=-1) for k, m in zip(i, j, strict=True)]
    return -2.0 / np.pi * np.stack(sums)


@pytest.mark.parametrize("friction", [0.0, 0.3])
def test_below_a_line_contact_with_and_without_friction(friction: float) -> None:
    a, p0, nu = 1e-3, 1e9, 0.3
    x, z = np.meshgrid(
        a * np.array([-1.3, -0.6, 0.0, 0.4, 0.9, 1.7]), a * np.array([0.2, 0.5, 0.786, 1.5, 3.0])
    )

    def pressure(t: Array) -> Array:
        return np.asarray(p0 * np.sqrt(np.maximum(1.0 - (t / a) ** 2, 0.0)))

    known = np.stack(mcewen(x, z, a, p0))
    # McEwen's formulas as typed here are those of point loads
    assert line_integral(x, z, a, pressure, 0) == pytest.approx(known, abs=1e-7 * p0)
    known = known + friction * line_integral(x, z, a, pressure, 1)
    errors = []
    for n in (20, 40, 80):
        d = 2.0 * a / n
        fine = (np.arange(32 * n) + 0.5) * d / 32.0 - a
        cells = pressure(fine).reshape(n, 32).mean(axis=1)[None]
        # on the upper body friction acts against q; there z goes into the body
        traction = np.stack([-friction * cells, np.zeros_like(cells)])
        result = rolled(cells, traction, (d, 1.0), THIRD, reference=1.0)
        found = result.stress("upper", points=np.stack([x, np.zeros_like(x), z]))
        errors.append(float(np.abs(found.stress[[0, 2, 4]] - known).max() / p0))
        # plane strain
        assert found.yy == pytest.approx(nu * (found.xx + found.zz), abs=1e-9 * p0)
        assert np.abs(found.stress[[3, 5]]).max() < 1e-9 * p0
    assert np.all(orders(errors) > 1.7), errors
    assert errors[-1] < 2e-3


def test_the_largest_shear_below_a_line_contact() -> None:
    # 0.300 p0 at 0.786 b
    a, n = 1e-3, 400
    d = 2.0 * a / n
    t = (np.arange(n) - 0.5 * (n - 1)) * d
    pressure = 1e9 * np.sqrt(np.maximum(1.0 - (t / a) ** 2, 0.0))[None]
    result = rolled(pressure, np.zeros((2, 1, n)), (d, 1.0), THIRD, reference=1.0)
    deep = np.linspace(0.7, 0.9, 101) * a
    at = result.stress(depths=deep)
    middle = at.largest_shear[:, 0, n // 2]
    assert middle.max() / 1e9 == pytest.approx(0.300, abs=0.0005)
    assert deep[middle.argmax()] / a == pytest.approx(0.786, abs=0.005)
    assert at.half_width == pytest.approx(a, rel=2e-3)


def mindlin(x: Array, y: Array, z: Array, force: Array, nu: float) -> Array:
    """Stress (6, ...) by a point force on the surface, from displacements by Boussinesq and Cerruti.

    The displacements are those of [Johnson1985, eqs. 3.18 and 3.71] for a shear modulus of one; central
    differences of the sixth order make strains of them.
    """

    def moved(x: Array, y: Array, z: Array) -> Array:
        rho = np.sqrt(x * x + y * y + z * z)
        below, free = rho + z, 1.0 - 2.0 * nu
        fx, fy, fz = force
        along = [
            fz * (x * z / rho**3 - free * x / (rho * below)),
            fz * (y * z / rho**3 - free * y / (rho * below)),
            fz * (z * z / rho**3 + 2.0 * (1.0 - nu) / rho),
        ]
        for f, (p, q), own, other in ((fx, (x, y), 0, 1), (fy, (y, x), 1, 0)):
            along[own] += f * (1.0 / rho + p * p / rho**3 + free * (1.0 / below - p * p / (rho * below**2)))
            along[other] += f * (p * q / rho**3 - free * p * q / (rho * below**2))
            along[2] += f * (p * z / rho**3 + free * p / (rho * below))
        return np.stack(along) / (4.0 * np.pi)

    step = 2e-3 * np.sqrt(x * x + y * y + z * z)
    gradient = []
    for axis in range(3):
        off = [step if k == axis else 0.0 * step for k in range(3)]
        terms = [
            weight
            * (
                moved(x + m * off[0], y + m * off[1], z + m * off[2])
                - moved(x - m * off[0], y - m * off[1], z - m * off[2])
            )
            for m, weight in ((1, 45.0), (2, -9.0), (3, 1.0))
        ]
        gradient.append(sum(terms) / (60.0 * step))
    g = np.stack(gradient, axis=1)
    spread = 2.0 * nu / (1.0 - 2.0 * nu) * (g[0, 0] + g[1, 1] + g[2, 2])
    return np.stack(
        [
            *(2.0 * g[k, k] + spread for k in range(3)),
            g[1, 2] + g[2, 1],
            g[0, 2] + g[2, 0],
            g[0, 1] + g[1, 0],
        ]
    )


def test_one_cell_is_an_integral_of_point_loads() -> None:
    rng = np.random.default_rng(7)
    dx, dy = 1.5e-3, 1e-3
    points = rng.uniform(-3e-3, 3e-3, (3, 40))
    points[2] = rng.uniform(0.5e-3, 4e-3, 40)
    traction = np.array([0.7e6, -0.4e6, 1.3e6])
    # beside a cell without a load
    one = np.array([[1.0, 0.0]])
    result = rolled(traction[2] * one, traction[:2, None, None] * one, (dx, dy))
    middle = np.array([-0.5 * dx, 0.0, 0.0])[:, None]
    node, weight = np.polynomial.legendre.leggauss(24)
    for body, sign in (("lower", -1.0), ("upper", 1.0)):
        # into the body: the traction of the result acts on the lower one
        force = np.array([-sign * traction[0], -sign * traction[1], traction[2]])
        known = np.zeros((6, 40))
        for u, wu in zip(node, weight, strict=True):
            for v, wv in zip(node, weight, strict=True):
                x, y = points[0] - 0.5 * dx * u, points[1] - 0.5 * dy * v
                known += 0.25 * wu * wv * dx * dy * mindlin(x, y, points[2], force, 0.28)
        known *= np.array([1.0, 1.0, 1.0, sign, sign, 1.0])[:, None]
        at = middle + points * np.array([1.0, 1.0, sign])[:, None]
        found = result.stress(body, points=at)  # type: ignore[arg-type]
        assert found.stress == pytest.approx(known, abs=1e-8 * np.abs(known).max())


def loaded_cells() -> mtb.FoundationResult:
    rng = np.random.default_rng(3)
    pressure = rng.uniform(0.0, 1e9, (6, 9))
    return rolled(pressure, 0.3 * rng.uniform(-1e9, 1e9, (2, 6, 9)), (1e-3, 0.8e-3))


def test_the_stress_is_in_equilibrium() -> None:
    result = loaded_cells()
    centre = np.array([0.7e-3, -0.4e-3, -1.3e-3])
    worst = []
    for step in (2e-4, 1e-4, 5e-5):
        force = np.zeros(3)
        size = 0.0
        for axis, row in enumerate(((0, 5, 4), (5, 1, 3), (4, 3, 2))):
            offset = step * np.eye(3)[axis]
            places = np.stack([centre + m * offset for m in (-2, -1, 1, 2)], axis=1)
            found = result.stress(points=places).stress[list(row)]
            slope = (found @ np.array([1.0, -8.0, 8.0, -1.0])) / (12.0 * step)
            force += slope
            size = max(size, float(np.abs(slope).max()))
        worst.append(float(np.abs(force).max() / size))
    # the error of differences of the fourth order is all that is left
    assert worst[-1] < 2e-5
    assert np.all(orders(worst) > 3.7), worst


@pytest.mark.parametrize("body", ["lower", "upper"])
def test_the_traction_is_recovered_as_the_depth_goes_to_zero(body: mtb.base.words.Body) -> None:
    result = loaded_cells()
    errors = []
    for depth in (1e-5, 5e-6, 2.5e-6, 0.0):
        found = result.stress(body, depths=[depth])
        own = np.stack([found.xz[0], found.yz[0], -found.zz[0]])
        known = np.stack([result.traction[0], result.traction[1], result.pressure])
        errors.append(float(np.abs(own - known).max() / 1e9))
    assert errors[-1] < 1e-12
    assert np.all(orders(errors[:3]) > 0.9), errors


def test_depths_and_points_are_one_field() -> None:
    result = loaded_cells()
    below = result.stress(depths=[0.0, 0.2e-3, 5e-3])
    assert below.convolutions == 18
    at = result.stress(points=below.points)
    assert at.convolutions == 0
    assert at.stress == pytest.approx(below.stress, abs=1e-10 * np.abs(below.stress).max())
    pressed = rolled(result.pressure, np.zeros((2, 6, 9)), (1e-3, 0.8e-3))
    both = pressed.stress(depths=[0.0, 0.2e-3, 5e-3])
    rubbed = rolled(np.zeros((6, 9)), result.traction[:2], (1e-3, 0.8e-3)).stress(depths=[0.0, 0.2e-3, 5e-3])
    assert both.stress + rubbed.stress == pytest.approx(below.stress, abs=1e-10 * np.abs(below.stress).max())


def hamilton(x: float, y: float, z: float, a: float, p0: float, mu: float, nu: float) -> Array:
    """Stress at a point below a sliding sphere: own quadrature in polar coordinates about its projection.

    Point loads as in :func:`mindlin`, with exact integration over the disc by Gauss' nodes that follow its
    rim.
    """
    angle, turn = np.polynomial.legendre.leggauss(160)
    radius, length = np.polynomial.legendre.leggauss(160)
    # substitution r = a sin: the root at the rim is smooth in it
    s = 0.25 * np.pi * (radius + 1.0)
    r, dr = a * np.sin(s), 0.25 * np.pi * a * np.cos(s) * length
    t, dt = np.pi * (angle + 1.0), np.pi * turn
    rr, tt = np.meshgrid(r, t)
    weight = p0 * np.sqrt(1.0 - (rr / a) ** 2) * rr * np.outer(dt, dr)
    load = mindlin(
        x - rr * np.cos(tt), y - rr * np.sin(tt), np.full_like(rr, z), np.array([mu, 0.0, 1.0]), nu
    )
    return np.asarray((load * weight).sum(axis=(1, 2)))


@pytest.mark.parametrize("mu", [0.25])
def test_below_a_sliding_sphere(mu: float) -> None:
    a, p0, nu = 1e-3, 1e9, 0.3
    places = a * np.array(
        [[0.0, 0.0, 0.5], [0.6, 0.0, 0.4], [-0.8, 0.3, 0.5], [0.3, -0.9, 0.8], [1.5, 0.2, 0.6]]
    )
    known = np.stack([hamilton(x, y, z, a, p0, mu, nu) for x, y, z in places.tolist()], axis=1)
    # Hamilton's closed forms on the axis: only xz stems from friction there [Hamilton1983, eqs. 1 to 6]
    z = 0.5
    shear = -mu * p0 * (-1.0 + 1.5 * z * np.arctan(1.0 / z) - 0.5 * z**2 / (1.0 + z**2)) * -1.0
    assert known[4, 0] == pytest.approx(shear, rel=1e-6)
    errors = []
    for n in (20, 40, 80):
        d = 2.0 * a / n
        x = (np.arange(n) - 0.5 * (n - 1)) * d
        fine = (x[:, None] + d * (np.arange(8) - 3.5)[None] / 8.0).ravel()
        square = 1.0 - (fine[None] ** 2 + fine[:, None] ** 2) / a**2
        pressure = p0 * np.sqrt(np.maximum(square, 0.0)).reshape(n, 8, n, 8).mean(axis=(1, 3))
        result = rolled(pressure, np.stack([-mu * pressure, 0.0 * pressure]), (d, d), THIRD)
        found = result.stress("upper", points=places.T)
        errors.append(float(np.abs(found.stress - known).max() / p0))
    assert np.all(orders(errors) > 1.6), errors
    assert errors[-1] < 5e-4


def test_unlike_bodies_have_stresses_by_their_own_ratio() -> None:
    soft, stiff = mtb.Material(1e9, 0.45), mtb.Material(200e9, 0.1)
    hertz = mtb.hertz(1e3, 0.02, lower=soft, upper=stiff)
    grid = hertz.on_grid((21, 21), 2.4 * hertz.semi_axes[0] / 21)
    # at the middle of the surface xx = -(1 + 2 nu) / 2 p0 [Johnson1985, eq. 3.43]
    for body, nu in (("lower", 0.45), ("upper", 0.1)):
        found = grid.stress(body, depths=[0.0])  # type: ignore[arg-type]
        middle = found.xx[0, 10, 10] / found.peak_pressure
        assert middle == pytest.approx(-0.5 * (1.0 + 2.0 * nu), abs=0.02)


def test_a_wave_of_pressure_falls_into_the_depth() -> None:
    # plane strain along y; a complete contact of waves [Johnson1985, eq. 13.7]: zz = -(1 + k z) exp(-k z) p
    n, length, mean = 32, 1e-3, 1e8
    x = (np.arange(n) + 0.5) * length / n
    k = 2.0 * np.pi / length
    height = 1e-8
    gap = np.tile(height * (1.0 - np.cos(k * x)), (4, 1))
    result = mtb.solve_normal(
        gap, length / n, lower=THIRD, upper=mtb.Rigid(), force=mean * 4 * length**2 / n, periodic=True
    )
    assert (result.status > 0).all()
    amplitude = 0.5 * np.ptp(result.pressure) / np.cos(0.5 * k * length / n)
    deep = np.array([0.0, 0.1e-3, 0.4e-3])
    found = result.stress(depths=deep)
    wave = amplitude * np.cos(k * x)
    for depth, zz, xx, yy, xz in zip(deep, found.zz, found.xx, found.yy, found.xz, strict=True):
        fall = np.exp(-k * depth)
        assert zz[0] == pytest.approx(-mean - (1.0 + k * depth) * fall * wave, rel=1e-6, abs=1e-6 * mean)
        assert xx[0] == pytest.approx(-3.0 / 7.0 * mean - (1.0 - k * depth) * fall * wave, abs=1e-6 * mean)
        assert yy[0] == pytest.approx(-3.0 / 7.0 * mean - 0.6 * fall * wave, abs=1e-6 * mean)
        assert np.abs(xz[0]) == pytest.approx(
            np.abs(k * depth * fall * amplitude * np.sin(k * x)), abs=1e-6 * mean
        )
    with pytest.raises(ValueError, match="periodic"):
        result.stress(points=[[0.0], [0.0], [-1e-4]])
