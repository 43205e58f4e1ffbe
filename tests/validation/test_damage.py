# SPDX-License-Identifier: MIT OR Apache-2.0
"""Numbers of damage: against the work of friction, Hertz' closed form, and each other."""

from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.optimize import minimize

import mtb_rs as mtb
from mtb_rs.results.damage import elastic_limit, shakedown_limit

Array = NDArray[np.float64]

A, B, LOAD, MU = 6e-3, 4e-3, 80e3, 0.3


def pressed(cells: int = 24) -> mtb.NormalResult:
    hertz = mtb.hertz(LOAD, semi_axes=(A, B), lower=mtb.steel, upper=mtb.steel)
    return hertz.on_grid((cells, cells), (2.2 * A / cells, 2.2 * B / cells))


def rolled(creepage: tuple[float, float, float]) -> list[Any]:
    """By the full theory and by both quick ones."""
    normal = pressed()
    return [
        mtb.solve_tangential(normal, mtb.Rolling(creepage, velocity=20.0), mtb.Coulomb(MU)),
        mtb.fastsim(normal, creepage, mtb.Coulomb(MU)),
        mtb.fastrip(normal, creepage, mtb.Coulomb(MU)),
    ]


def test_t_gamma_is_the_work_of_friction() -> None:
    """Per distance: without spin the heat of steady rolling, exactly."""
    full, *quick = rolled((1e-3, 5e-4, 0.0))
    assert full.t_gamma() == pytest.approx(float((full.dissipation * full.area).sum()), rel=1e-9)
    assert full.t_gamma(with_spin=True) == full.t_gamma()
    for result in quick:
        assert result.t_gamma() == pytest.approx(full.t_gamma(), rel=0.1)
    # saturated: mu N times the creepage
    for result in rolled((0.05, 0.0, 0.0)):
        load = -result.force[2]
        assert result.t_gamma() == pytest.approx(MU * load * 0.05, rel=0.03)


def test_spin_counts_if_asked() -> None:
    full = rolled((5e-4, 0.0, 0.5))[0]
    with_spin = full.t_gamma() + abs(full.spin_moment * 0.5)
    assert full.t_gamma(with_spin=True) == pytest.approx(with_spin, rel=1e-12)
    # the cells' own heat is off by the first order
    heat = float((full.dissipation * full.area).sum())
    assert full.t_gamma(with_spin=True) == pytest.approx(heat, rel=0.1)


def test_a_rigid_slip_of_each_cell_counts_as_creepage_does() -> None:
    pressed = mtb.hertz(60e3, semi_axes=(6e-3, 4e-3), lower=mtb.steel, upper=mtb.steel)
    field, law = pressed.on_grid((20, 20), (0.63e-3, 0.43e-3)), mtb.Coulomb(MU)
    slip = np.zeros((2, 20, 20))
    slip[0], slip[1] = 3e-3, -1e-3
    expected = mtb.solve_tangential(field, mtb.Rolling((3e-3, -1e-3, 0.0)), law).t_gamma()
    for creepage, share in (((0.0, 0.0, 0.0), 1.0), ((1.5e-3, -0.5e-3, 0.0), 0.5)):
        motion = mtb.Rolling(creepage, rigid_slip=share * slip)
        assert mtb.solve_tangential(field, motion, law).t_gamma() == pytest.approx(expected, rel=1e-9)


def test_the_fatigue_index_on_an_ellipse() -> None:
    """mu - 2 pi a b k / (3 Fz), as published."""
    k = 300e6
    full = rolled((2e-3, 0.0, 0.0))[0]
    load = -full.force[2]
    index = np.hypot(*full.force[:2]) / load - 2.0 * np.pi * A * B * k / (3.0 * load)
    assert full.surface_fatigue_index(k) == pytest.approx(index, abs=3e-3)
    friction, over = full.shakedown(k)
    assert full.surface_fatigue_index(k) == pytest.approx(friction - 1.0 / over, rel=1e-12)
    assert over == pytest.approx(1.5 * load / (np.pi * A * B * k), rel=5e-3)


def test_a_yield_stress_in_megapascals_is_asked_about() -> None:
    full = rolled((2e-3, 0.0, 0.0))[0]
    with pytest.warns(UserWarning, match="shear_yield is 300 Pa: metals yield in shear at"):
        full.shakedown(300.0)


def test_patches_of_wheels() -> None:
    contact = mtb.scenes.wheel_on_rail(spacing=0.5e-3).prepare()
    assert isinstance(contact, mtb.PreparedWheels)
    patch = contact.step(velocity=(20.0, 0.0, 0.0, 0.0, 20.0 / 0.4605, 0.0)).patches[0]
    power = patch.friction_power / abs(patch.rolling_speed)
    assert patch.t_gamma(with_spin=True) == pytest.approx(power, rel=0.1)
    assert patch.shakedown(300e6)[1] == pytest.approx(patch.pressure.max() / 300e6, rel=1e-12)


def passage(stress: Array) -> mtb.StressField:
    """Of stresses (6, m, ny, nx)."""
    m, ny, nx = stress.shape[1:]
    depths = 1e-3 * np.arange(1.0, m + 1.0)
    z, y, x = np.meshgrid(-depths, 1e-3 * np.arange(ny), 1e-3 * np.arange(nx), indexing="ij")
    return mtb.StressField("lower", np.stack([x, y, z]), stress, 1e-3, 1e9, depths, np.ones((ny, nx)))


def tensors(stress: Array) -> Array:
    return stress[[[0, 5, 4], [5, 1, 3], [4, 3, 2]]].transpose(2, 0, 1)


def least_largest_shear(path: Array, coefficient: float) -> float:
    """Of a path (6, n), its unloaded state included, by a general minimiser."""
    matrices = tensors(np.concatenate([path, np.zeros((6, 1))], axis=1))
    means = np.trace(matrices, axis1=1, axis2=2) / 3.0
    deviators = matrices - means[:, None, None] * np.eye(3)
    scale = np.abs(deviators).max()
    vectors = deviators.reshape(-1, 9) / scale
    start = np.append(vectors.mean(axis=0), 4.0)
    found = minimize(
        lambda at: at[-1],
        start,
        constraints={"type": "ineq", "fun": lambda at: at[-1] - ((vectors - at[:-1]) ** 2).sum(axis=1)},
        method="SLSQP",
        options={"ftol": 1e-15, "maxiter": 1000},
    )
    middle = scale * found.x[:-1].reshape(3, 3)
    principal = np.linalg.eigvalsh(deviators - middle)
    return float((0.5 * (principal[:, 2] - principal[:, 0]) + coefficient * means).max())


@pytest.mark.parametrize("seed", range(6))
def test_dang_van_of_random_passages(seed: int) -> None:
    """Smallest balls against a general minimiser, along both ways."""
    rng = np.random.default_rng(seed)
    stress = 1e8 * rng.normal(size=(6, 2, 3, 4)).cumsum(axis=3)
    field = passage(stress)
    along_x, along_y = field.dang_van(0.35), field.dang_van(0.2, along="y")
    assert along_x.shape == (2, 3)
    assert along_y.shape == (2, 4)
    for deep in range(2):
        for j in range(3):
            expected = least_largest_shear(stress[:, deep, j], 0.35)
            assert along_x[deep, j] == pytest.approx(expected, rel=1e-6)
        for i in range(4):
            expected = least_largest_shear(stress[:, deep, :, i], 0.2)
            assert along_y[deep, i] == pytest.approx(expected, rel=1e-6)


def test_a_passage_below_a_rolling_wheel() -> None:
    """Turned contacts pass alike, and a residual stress counts by its mean."""
    wheel = mtb.hertz(LOAD, semi_axes=(A, B), lower=mtb.steel, upper=mtb.steel)
    other = mtb.hertz(LOAD, semi_axes=(B, A), lower=mtb.steel, upper=mtb.steel)
    depths = 1e-3 * np.array([0.5, 1.5, 2.5, 4.0])
    inside = wheel.on_grid((24, 20), (0.6e-3, 0.4e-3)).stress(depths=depths)
    turned = other.on_grid((20, 24), (0.4e-3, 0.6e-3)).stress(depths=depths)
    plain = inside.dang_van(0.35)
    assert turned.dang_van(0.35, along="y") == pytest.approx(plain, rel=1e-9)
    # half of the shear stress xz goes to and fro at least
    to_and_fro = np.abs(inside.xz).max(axis=(1, 2))
    assert (inside.dang_van(0.0).max(axis=1) >= to_and_fro - 1.0).all()
    assert (inside.dang_van(0.0) <= inside.largest_shear.max(axis=2) + 1.0).all()
    residual = np.array([9e7, 3e7, 0.0, 5e7, -2e7, 1e7])
    assert inside.dang_van(0.35, residual) == pytest.approx(plain + 0.35 * 4e7, rel=1e-12)
    each = residual[:, None] * np.array([1.0, 0.5, 0.0, 2.0])
    lifted = plain + 0.35 * 4e7 * np.array([[1.0], [0.5], [0.0], [2.0]])
    assert inside.dang_van(0.35, each) == pytest.approx(lifted, rel=1e-12)
    assert np.unravel_index(plain.argmax(), plain.shape)[0] in (1, 2)


def test_the_limits_of_a_line_contact() -> None:
    """Johnson and Jefferis: 4 k without friction, and the surface first above a friction of 0.367."""
    assert shakedown_limit(np.array([0.0])) == pytest.approx(4.0, rel=1e-4)
    slight, strong = np.array([0.1, 0.25, 0.36]), np.array([0.375, 0.5, 1.0])
    assert (shakedown_limit(slight) < 1.0 / slight - 1e-3).all()
    assert shakedown_limit(strong) == pytest.approx(1.0 / strong, rel=1e-6)
    # Hertz: 0.300 of the peak pressure
    assert elastic_limit(np.array([0.0])) == pytest.approx(1.0 / 0.3003, rel=1e-3)
    assert (elastic_limit(slight) < shakedown_limit(slight)).all()
    line = rolled((0.1, 0.0, 0.0))[0]
    figure = line.plot_shakedown(300e6)
    upper, _, point = figure.axes[0].lines
    assert point.get_xydata()[0] == pytest.approx(line.shakedown(300e6))
    assert upper.get_ydata()[-1] == pytest.approx(1.0 / upper.get_xdata()[-1])
    # a second one joins it
    line.plot_shakedown(50e6, figure.axes[0])
    assert len(figure.axes[0].lines) == 4
    assert figure.axes[0].get_ylim()[1] > line.shakedown(50e6)[1]


def test_the_damage_of_a_rail() -> None:
    assert mtb.rail_damage([0.0, 15.0, 40.0, 65.0, 120.0, 175.0]) == pytest.approx([0, 0, 0.5, 1, 0.5, 0])
    assert mtb.rail_damage(285.0) == pytest.approx(-1.0)


def test_what_cannot_be_is_refused() -> None:
    with pytest.raises(ValueError, match=r"^t_gamma is -1 N: numbers of at least 0 are needed"):
        mtb.rail_damage([1.0, -1.0])
    shifted = mtb.solve_tangential(pressed(), mtb.Shift((1e-6, 0.0)), mtb.Coulomb(MU))
    with pytest.raises(ValueError, match=r"^a shift passes over nothing"):
        shifted.t_gamma()
    with pytest.raises(ValueError, match=r"^shear_yield is 0.0: a positive number"):
        rolled((1e-3, 0.0, 0.0))[0].surface_fatigue_index(0.0)


def test_an_ellipse_beyond_the_grid_is_refused() -> None:
    hertz = mtb.hertz(80e3, semi_axes=(6e-3, 4e-3))
    whole = hertz.on_grid((32, 48), 0.3e-3)
    assert whole.pressure.max() == pytest.approx(hertz.peak_pressure, rel=2e-3)
    for shape, axis in (((48, 32), "x"), ((20, 48), "y"), ((2, 2), "x")):
        with pytest.raises(ValueError, match=f"the contact ellipse reaches beyond the grid along {axis}"):
            hertz.on_grid(shape, 0.3e-3)


def test_stress_is_no_more_than_the_pressure_at_depths_of_rounding() -> None:
    normal = mtb.hertz(500.0, semi_axes=(6e-3, 4e-3)).on_grid((30, 30), (0.45e-3, 0.4e-3))
    x, y = normal.points[0, 0], normal.points[1, :, 0]
    border = x[15] + 0.5 * normal.spacing[0]
    mean = 0.5 * (normal.pressure[12, 15] + normal.pressure[12, 16])
    near = normal.stress(points=[border, y[12], -1e-11])
    assert float(near.zz) == pytest.approx(-mean, rel=1e-6)
    for depth in (0.0, 1e-18, 0.1 + 0.2 - 0.3, 1e-40):
        with pytest.raises(ValueError, match="on the surface at the border of a loaded cell"):
            normal.stress(points=[border, y[12], -min(depth, 1e-17)])
    inside = normal.stress(points=[x[15], y[12], -1e-18])
    assert float(inside.zz) == pytest.approx(-normal.pressure[12, 15], rel=1e-12)
