# SPDX-License-Identifier: MIT OR Apache-2.0
"""Rough layers against closed forms, a rough sphere solved otherwise, smooth contact, resolved roughness."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.sparse.linalg import LinearOperator, cg

import mtb_rs as mtb

Array = NDArray[np.float64]

RADIUS, WIDTH = 0.1, 2e-3
STEEL: dict[str, Any] = {"upper": mtb.steel, "lower": mtb.steel}
MODULUS = mtb.steel.young_modulus / (1.0 - mtb.steel.poisson_ratio**2) / 2.0


def bowl(cells: int) -> tuple[Array, float]:
    side = WIDTH / cells
    x = (np.arange(cells) - (cells - 1) / 2) * side
    return (x[None, :] ** 2 + x[:, None] ** 2) / (2.0 * RADIUS), side


@pytest.mark.coarse
@pytest.mark.filterwarnings("ignore:young_modulus")
def test_a_flat_punch_comes_down_by_the_law() -> None:
    """Bodies that hardly give way, by 1e-11 m: p = F / A, and the approach is the opening."""
    stiff = mtb.Material(1e19, 0.3)
    top, length, height = 5e9, 0.4e-6, 3e-6
    layer = mtb.RoughLayer.exponential(top, length, height)
    gap, side = np.zeros((8, 8)), 1e-3
    for force in (1.0, 1e3, 1e6):
        p = force / (8 * side) ** 2
        wanted = height + length * np.log(p / top + np.exp(-height / length))
        scene = mtb.scenes.block_on_plane(
            8 * side, 0.1, 0.0, spacing=side, upper=stiff, lower=mtb.Rigid(), normal_layer=layer
        ).with_(magnetic_pressure=None, force=force)
        assert scene.solve("half-space").approach == pytest.approx(wanted, rel=1e-5)
        found = mtb.solve_normal(
            gap, side, upper=stiff, lower=mtb.Rigid(), force=force, normal_layer=layer, tolerance=1e-10
        )
        assert found.approach == pytest.approx(wanted, rel=1e-5)
        assert found.pressure == pytest.approx(p, rel=1e-5)


def influence(cells: int, side: float) -> Array:
    """Love's displacements of squares, written down once more."""
    x = np.arange(cells) * side
    dx, dy = x[:, None] - x[None, :], x[:, None] - x[None, :]
    dx, dy = dx[None, :, None, :], dy[:, None, :, None]

    def part(x: Array, y: Array) -> Array:
        return x * np.arcsinh(y / np.abs(x)) + y * np.arcsinh(x / np.abs(y))

    h = 0.5 * side
    total = part(dx + h, dy + h) - part(dx - h, dy + h) - part(dx + h, dy - h) + part(dx - h, dy - h)
    return np.asarray(total.reshape(cells**2, cells**2) / (np.pi * MODULUS))


def rough_sphere(law: Callable[[Array], Array], approach: float, cells: int) -> Array:
    """Pressures with p = law(gap of the mean planes), point by point in turn."""
    gap, side = bowl(cells)
    matrix, undeformed = influence(cells, side), gap.ravel() - approach
    pressure = np.zeros(gap.size)
    for _ in range(3000):
        before = pressure.copy()
        for i in range(gap.size):
            own = matrix[i, i]
            rest = matrix[i] @ pressure - own * pressure[i] + undeformed[i]
            low, high = 0.0, float(law(np.array(rest)))
            for _ in range(60):
                middle = 0.5 * (low + high)
                low, high = (middle, high) if middle < law(rest + own * middle) else (low, middle)
            pressure[i] = 0.5 * (low + high)
        if np.abs(pressure - before).max() < 1e-12 * pressure.max():
            return pressure
    raise AssertionError("not settled")


def gaussian(modulus: float, rms: float) -> Callable[[Any], Array]:
    """Greenwood and Tripp: spheres of one radius with Gaussian heights, beta eta sigma = 0.05."""
    tip, density = 20e-6, 0.05 / (20e-6 * rms)
    t = np.linspace(0.0, 9.0, 1501)

    def law(distance: Any) -> Array:
        s = np.asarray(distance)[..., None] / rms
        excess = t**1.5 * np.exp(-0.5 * (t + s) ** 2) / np.sqrt(2.0 * np.pi)
        sums = np.trapezoid(excess, t, axis=-1)
        return np.asarray(4.0 / 3.0 * density * modulus * np.sqrt(tip) * rms**1.5 * sums)

    return law


@pytest.mark.coarse
@pytest.mark.slow
def test_greenwood_and_tripps_rough_sphere() -> None:
    rms, cells = 0.5e-6, 11
    law = gaussian(MODULUS, rms)
    distances = np.linspace(4.5 * rms, -3.0 * rms, 300)
    table = law(distances)
    layer = mtb.RoughLayer(distances, [0.0, *table[1:]])
    gap, side = bowl(cells)
    # the gap of the scene counts from the first touch
    approach = 1.5e-6
    wanted = rough_sphere(law, approach, cells)
    scene = mtb.Scene(
        **STEEL, gap=gap, spacing=side, approach=approach + layer.height, normal_layer=layer, friction=0.0
    )
    found = scene.solve("half-space")
    assert found.pressure.ravel() == pytest.approx(wanted, abs=2e-4 * wanted.max())
    # much wider than Hertz' contact
    assert found.report.contact_area > 2.0 * np.pi * RADIUS * approach


@pytest.mark.coarse
@pytest.mark.parametrize("friction", [0.0, 0.4])
def test_solve_normal_scenes_and_steps_agree(friction: float) -> None:
    gap, side = bowl(25)
    layer = mtb.RoughLayer.exponential(0.3 * MODULUS, 0.2e-6)
    scene = mtb.Scene(**STEEL, gap=gap, spacing=side, force=150.0, normal_layer=layer, friction=friction)
    normal = mtb.solve_normal(
        gap, side, **STEEL, force=150.0, normal_layer=layer, edge="sharp", tolerance=1e-10
    )
    peak = normal.pressure.max()
    found = scene.solve("half-space")
    assert found.pressure == pytest.approx(normal.pressure, abs=1e-6 * peak)
    assert found.approach == pytest.approx(normal.approach, rel=1e-7)
    prepared = scene.prepare()
    for load in (1.0, 2.0):
        stepped = prepared.step(velocity=load)
        assert stepped.pressure == pytest.approx(found.pressure.ravel(), abs=1e-8 * peak)
    # an approach in place of the force
    again = mtb.solve_normal(
        gap, side, **STEEL, approach=normal.approach, normal_layer=layer, edge="sharp", tolerance=1e-10
    )
    assert again.pressure == pytest.approx(normal.pressure, abs=1e-6 * peak)


@pytest.mark.coarse
@pytest.mark.parametrize("model", ["half-space", "elastic-upper", "elastic-both"])
def test_pole_shoe_and_newton_steps(model: Any) -> None:
    shoe = mtb.scenes.pole_shoe_on_rail(spacing=6e-3)
    smooth = shoe.solve(model)
    layer = mtb.RoughLayer.exponential(1e10, 1e-6)
    scene = shoe.with_(normal_layer=layer)
    found = scene.solve(model)
    assert "mirror half" in found.report.solver
    assert found.report.force_balance["relative_error"] < 1e-8
    assert found.report.peak_pressure < 0.98 * smooth.report.peak_pressure
    assert found.report.iterations <= smooth.report.iterations + 3
    stepped = scene.prepare(model).step(velocity=1.0)
    assert found.coefficients is not None
    assert stepped.state.pressure == pytest.approx(
        found.coefficients[2], abs=1e-7 * found.report.peak_pressure
    )


@pytest.mark.coarse
def test_a_stiff_layer_is_smooth_contact() -> None:
    """What the layer changes falls with its length, with one order."""
    gap, side = bowl(25)
    given: dict[str, Any] = {**STEEL, "gap": gap, "spacing": side, "force": 300.0}
    smooth = mtb.Scene(**given).solve("half-space")
    inner = smooth.pressure > 0.3 * smooth.pressure.max()
    errors = []
    for length in (4e-8, 2e-8, 1e-8, 5e-9):
        layer = mtb.RoughLayer.exponential(MODULUS, length)
        rough = mtb.Scene(**given, normal_layer=layer).solve("half-space")
        errors.append(np.linalg.norm((rough.pressure - smooth.pressure)[inner]))
    orders = np.log2(np.array(errors[:-1]) / np.array(errors[1:]))
    # the pressure is as large as it is over some lengths of the law: a logarithm comes on top of the order
    assert np.all((orders > 0.8) & (orders < 1.05))


@pytest.mark.coarse
def test_table_and_law() -> None:
    closed = mtb.RoughLayer.exponential(2e9, 0.5e-6, 4e-6)
    g = np.linspace(4e-6, -1e-6, 200)
    p = 2e9 * (np.exp(-g / 0.5e-6) - np.exp(-4e-6 / 0.5e-6))
    assert closed.opening(np.maximum(p, 0.0)) == pytest.approx(4e-6 - g, abs=1e-15)
    table = mtb.RoughLayer(g, np.maximum(p, 0.0))
    assert table.opening(p[50:]) == pytest.approx(4e-6 - g[50:], rel=1e-9)
    assert table.normal_stiffness(p[100]) == pytest.approx((p[100] + 2e9 * np.exp(-8.0)) / 0.5e-6, rel=0.02)
    with pytest.raises(ValueError, match="the law is known"):
        table.opening(2.0 * p[-1])
    gap, side = bowl(15)
    with pytest.raises(ValueError, match="the table of the rough layer ends at"):
        mtb.Scene(**STEEL, gap=gap, spacing=side, force=1e5, normal_layer=table).solve("half-space")
    for bad in (dict(gap=[1e-6, 2e-6], pressure=[0.0, 1e6]), dict(gap=[2e-6, 1e-6], pressure=[1.0, 1e6])):
        with pytest.raises(ValueError, match="are needed"):
            mtb.RoughLayer(**bad)
    with pytest.raises(ValueError, match="tangential_ratio is None"):
        table.interface_layer(1e6)


@pytest.mark.coarse
def test_derivatives_through_a_rough_layer() -> None:
    gap, side = bowl(15)
    layer = mtb.RoughLayer.exponential(1e10, 0.3e-6)
    scene = mtb.Scene(**STEEL, gap=gap, spacing=side, force=200.0, normal_layer=layer, friction=0.2)
    found = scene.solve("half-space")
    h = 0.02
    there, here = (scene.with_(force=200.0 + s).solve("half-space") for s in (h, -h))
    by = found.derivative("peak_pressure", "force")
    assert by == pytest.approx((there.report.peak_pressure - here.report.peak_pressure) / (2 * h), rel=1e-4)
    with pytest.raises(ValueError, match=r"normal_layer.*RoughLayer"):
        found.derivative("peak_pressure", "normal_layer")


def test_roughness_to_layer_to_contact() -> None:
    """A rough sphere with its roughness resolved, and with the layer that the roughness is."""
    cells, side = 128, 10e-6
    heights = mtb.roughness(cells, side, rms_height=0.2e-6, hurst=0.8, longest=16 * side, roll_off=16 * side,
                            shortest=8 * side, seed=3)  # fmt: skip
    layer = mtb.RoughLayer.from_surface(heights, side, lower=mtb.steel, upper=mtb.steel)
    assert layer.tangential_ratio == pytest.approx(2 * (1 - 0.3) / (2 - 0.3), rel=0.03)
    # exponential with a length of about half the rms height over its middle
    middle = slice(8, 20)
    slope = np.polyfit(np.log(layer.pressure[middle]), layer.gap[middle], 1)[0]
    assert 0.3 < -slope / heights.std() < 0.7
    x = (np.arange(cells) - (cells - 1) / 2) * side
    sphere = (x[None, :] ** 2 + x[:, None] ** 2) / (2.0 * 0.1)
    force = 20.0
    resolved = mtb.solve_normal(sphere + heights.max() - heights, side, **STEEL, force=force)
    smooth = mtb.solve_normal(sphere, side, **STEEL, force=force)
    layered = mtb.solve_normal(sphere, side, **STEEL, force=force, normal_layer=layer)
    # tips are few: pressures differ from place to place, the approach and the spread of the load do not
    assert layered.approach == pytest.approx(resolved.approach, rel=0.03)
    assert smooth.approach < 0.6 * resolved.approach
    r = np.hypot(x[None, :], x[:, None])

    def spread(found: mtb.NormalResult) -> float:
        return float(np.sqrt((found.pressure * r**2).sum() / found.pressure.sum()))

    assert spread(layered) == pytest.approx(spread(resolved), rel=0.1)
    assert spread(smooth) < 0.85 * spread(resolved)


@pytest.mark.filterwarnings("ignore:the contact is only")
@pytest.mark.parametrize("seed", range(24))
def test_laws_of_any_stiffness_are_met_on_rough_gaps(seed: int) -> None:
    """By Love's displacements as written above, from a law that is nearly a step to one softer than all."""
    rng = np.random.default_rng(seed)
    cells = int(rng.integers(14, 22))
    gap, side = bowl(cells)
    gap = gap * 10 ** rng.uniform(-1.0, 1.0) + 1e-7 * rng.standard_normal(gap.shape)
    force = 10 ** rng.uniform(1.0, 3.0)
    mean = force / (side * cells) ** 2
    approach = force / (MODULUS * side * cells)
    layer = mtb.RoughLayer.exponential(
        mean * 10 ** rng.uniform(1.0, 5.0), approach * 10 ** rng.uniform(-3.0, 0.5)
    )
    result = mtb.solve_normal(
        gap, side, force=force, normal_layer=layer, method="fft", edge="sharp", tolerance=1e-9, **STEEL
    )
    pressure = result.pressure.ravel()
    elastic = influence(cells, side) @ pressure
    left = gap.ravel() + elastic + layer.opening(pressure) - result.approach
    scale = np.sqrt((elastic**2).mean())
    assert np.abs(left[pressure > 0.0]).max() <= 1e-6 * scale
    assert left[pressure == 0.0].min(initial=0.0) >= -1e-6 * scale
    assert result.gap.ravel() == pytest.approx(left, abs=1e-6 * scale)


def test_the_work_hardly_grows_with_a_layer() -> None:
    """Counted in convolutions, under a ball, over the two numbers of the law."""
    gap, side = bowl(129)
    radius = RADIUS / 4.0
    gap *= 4.0
    force = 20.0
    smooth = mtb.solve_normal(gap, side, force=force, **STEEL)
    hertz = mtb.hertz(force, radius, lower=mtb.steel, upper=mtb.steel)
    for pressure in (10.0, 100.0, 1e3, 1e4):
        for length in (3e-3, 3e-2, 1e-1):
            layer = mtb.RoughLayer.exponential(pressure * hertz.peak_pressure / 1.5, length * hertz.approach)
            rough = mtb.solve_normal(gap, side, force=force, normal_layer=layer, **STEEL)
            assert rough.report.convolutions < 8.0 * smooth.report.convolutions


def sheared(touching: NDArray[np.bool_], side: float) -> float:
    """Traction over the shift of two equal half-spaces that stick where they touch, one period: [Pa/m].

    A wave shears each of them along itself by ``(1 - nu) / (G k)`` and across by ``1 / (G k)``.
    """
    n, count = touching.shape[0], int(touching.sum())
    k = 2.0 * np.pi * np.fft.fftfreq(n, side)
    kx, ky = np.meshgrid(k, k)
    size = np.hypot(kx, ky)
    size[0, 0] = np.inf
    shear = 0.5 * mtb.steel.young_modulus / (1.0 + mtb.steel.poisson_ratio)
    along, across = 2.0 * (1.0 - mtb.steel.poisson_ratio) / shear, 2.0 / shear
    xx, yy = ((along * a**2 + across * b**2) / size**3 for a, b in ((kx, ky), (ky, kx)))
    xy = (along - across) * kx * ky / size**3

    def displaced(tractions: Array) -> Array:
        fields = np.zeros((2, n, n))
        fields[:, touching] = tractions.reshape(2, count)
        x, y = np.fft.fft2(fields)
        moved = np.fft.ifft2(np.stack([xx * x + xy * y, xy * x + yy * y])).real
        return np.asarray(moved[:, touching].ravel())

    shift = np.repeat([1.0, 0.0], count)
    operator = LinearOperator((2 * count, 2 * count), matvec=displaced)
    found, status = cg(operator, shift, rtol=1e-8, maxiter=4000)
    assert status == 0
    return float(found[:count].sum() / n**2)


def test_tangential_stiffness_of_a_rough_surface() -> None:
    """Against an own Fourier solution of the sticking tips: few of them, many, and most of the area."""
    cells, side = 96, 20e-6 / 3.0
    heights = mtb.roughness(cells, side, rms_height=0.2e-6, hurst=0.8, longest=48 * side, roll_off=48 * side,
                            shortest=12 * side, seed=3)  # fmt: skip
    pressures = np.array([[p, 1.01 * p] for p in (3e7, 1e8, 3e8, 6e8)])
    layer = mtb.RoughLayer.from_surface(
        heights, side, lower=mtb.steel, upper=mtb.steel, pressures=pressures.ravel()
    )
    gap = heights.max() - heights
    assert layer.tangential_ratio is not None
    shares = []
    for k, pair in enumerate(pressures):
        stiffness = np.diff(pair) / -np.diff(layer.gap[1 + 2 * k : 3 + 2 * k])
        force = float(pair[0]) * gap.size * side**2
        touching = mtb.solve_normal(gap, side, **STEEL, force=force, periodic=True).pressure > 0.0
        # patches longer along the shift are stiffer than those across it: of single surfaces
        assert sheared(touching, side) / stiffness[0] == pytest.approx(layer.tangential_ratio, rel=0.04)
        shares.append(touching.mean())
    assert shares[0] < 0.12
    assert shares[-1] > 0.8


def test_tangential_stiffness_of_a_rough_sphere() -> None:
    """Its tips shifted by so little that they stick, by the tangential solver."""
    cells, side = 128, 10e-6
    heights = mtb.roughness(cells, side, rms_height=0.2e-6, hurst=0.8, longest=16 * side, roll_off=16 * side,
                            shortest=8 * side, seed=3)  # fmt: skip
    x = (np.arange(cells) - (cells - 1) / 2) * side
    gap = (x[None, :] ** 2 + x[:, None] ** 2) / (2.0 * 0.1) + heights.max() - heights
    pressed, more = (
        mtb.solve_normal(gap, side, **STEEL, force=force, tolerance=1e-9) for force in (20.0, 20.2)
    )
    stiffness = 0.2 / (more.approach - pressed.approach)
    shifted = mtb.solve_tangential(pressed, mtb.Shift((1e-10, 0.0)), mtb.Coulomb(1.5))
    assert not (shifted.status == 2).any()
    nu = mtb.steel.poisson_ratio
    ratio = abs(shifted.force[0]) / 1e-10 / stiffness
    assert ratio == pytest.approx(2.0 * (1.0 - nu) / (2.0 - nu), rel=0.01)


def test_surfaces_that_make_no_layer_are_refused_by_what_was_given() -> None:
    wave = 1e-6 * np.cos(2.0 * np.pi * np.arange(16) / 16)[None]
    steel = {"lower": mtb.steel, "upper": mtb.steel}
    with pytest.raises(ValueError, match=r"at least 3 x 3 heights \(ny, nx\) \[m\] that are not all equal"):
        mtb.RoughLayer.from_surface(wave, 1e-5, **steel)
    with pytest.raises(ValueError, match=r"^hardness is 100000 Pa: more than the largest mean pressure of"):
        mtb.RoughLayer.from_surface(np.repeat(wave, 4, 0), 1e-5, hardness=1e5, **steel)
