# SPDX-License-Identifier: MIT OR Apache-2.0
"""Pressures that a hardness bounds, against balance, full flow and a projected solver that shares no code."""

from typing import Any

import numpy as np
import pytest

import mtb_rs as mtb

STEEL: dict[str, Any] = {"lower": mtb.steel, "upper": mtb.steel}


def bowl(cells: int = 32) -> tuple[np.ndarray, float]:
    side = 6e-3 / cells
    x = (np.arange(cells) - 0.5 * (cells - 1)) * side
    return (x[None, :] ** 2 + x[:, None] ** 2) / (2.0 * 0.05), side


def influence(cells: int, side: float) -> np.ndarray:
    """Love's matrix of both half-spaces, from his formula for the corners of a rectangle."""

    def corner(x: np.ndarray, y: np.ndarray) -> np.ndarray:
        r = np.hypot(x, y)
        return np.asarray(x * np.log(y + r) + y * np.log(x + r))

    i, j = np.meshgrid(np.arange(cells), np.arange(cells), indexing="ij")
    x, y = i.ravel() * side, j.ravel() * side
    dx, dy, h = x[:, None] - x, y[:, None] - y, side / 2
    total = corner(dx + h, dy + h) + corner(dx - h, dy - h) - corner(dx + h, dy - h) - corner(dx - h, dy + h)
    modulus = mtb.steel.young_modulus / (1.0 - mtb.steel.poisson_ratio**2) / 2.0
    return np.asarray(total / (np.pi * modulus))


def projected(matrix: np.ndarray, gap: np.ndarray, approach: float, most: float) -> np.ndarray:
    """Pressures between zero and a bound, point by point [projected Gauss-Seidel]."""
    p = np.zeros(gap.size)
    w = gap - approach
    for _ in range(3000):
        worst = 0.0
        for i in range(gap.size):
            new = min(max(p[i] - w[i] / matrix[i, i], 0.0), most)
            if new != p[i]:
                w += matrix[:, i] * (new - p[i])
                worst, p[i] = max(worst, abs(new - p[i])), new
        if worst < 1e-10 * most:
            break
    return p


@pytest.mark.parametrize("share", [0.55, 0.7, 0.9])
def test_a_projected_solver_finds_the_same(share: float) -> None:
    cells = 14
    gap, side = bowl(cells)
    approach = 1.6e-5
    elastic = mtb.solve_normal(gap, side, **STEEL, approach=approach)
    hardness = share * float(elastic.pressure.max())
    found = mtb.solve_normal(gap, side, **STEEL, approach=approach, hardness=hardness, tolerance=1e-10)
    exact = projected(influence(cells, side), gap.ravel(), approach, hardness).reshape(gap.shape)
    assert np.abs(found.pressure - exact).max() < 1e-6 * hardness
    assert (found.pressure >= hardness).sum() >= 4
    # to the force of the approach the other way round
    again = mtb.solve_normal(gap, side, **STEEL, force=found.normal_force, hardness=hardness, tolerance=1e-10)
    assert again.approach == pytest.approx(approach, rel=1e-8)
    assert again.pressure == pytest.approx(found.pressure, abs=1e-6 * hardness)


@pytest.mark.parametrize("cells", [31, 64, 100])
def test_force_is_carried_and_the_contact_grows(cells: int) -> None:
    gap, side = bowl(cells)
    elastic = mtb.solve_normal(gap, side, **STEEL, force=500.0)
    hardness = 0.6 * float(elastic.pressure.max())
    found = mtb.solve_normal(gap, side, **STEEL, force=500.0, hardness=hardness)
    assert found.normal_force == pytest.approx(500.0, rel=1e-6)
    assert found.pressure.max() <= hardness * (1.0 + 1e-9)
    assert found.contact_area > elastic.contact_area
    flowed = found.plastic_indentation
    assert flowed is not None
    assert np.all((flowed > 0.0) <= (found.pressure >= hardness))
    # deepest in the middle, and where nothing flows the gap is closed or open
    assert flowed.max() == flowed[cells // 2, cells // 2] or cells % 2 == 0
    assert found.gap.min() > -1e-4 * found.approach
    rolled = mtb.solve_tangential(found, mtb.Rolling((1.0, 0.0, 0.0)), mtb.Coulomb(0.3))
    assert np.hypot(*rolled.traction[:2]).max() <= 0.3 * hardness * (1.0 + 1e-9)


def test_all_that_touches_flows_under_a_small_hardness() -> None:
    """F = H A: the whole contact at the hardness, but for a border of elastic cells."""
    gap, side = bowl(64)
    hardness = 2e7
    found = mtb.solve_normal(gap, side, **STEEL, force=100.0, hardness=hardness)
    assert found.contact_area == pytest.approx(100.0 / hardness, rel=0.02)


@pytest.mark.parametrize("hardness", [4e8, 1e9])
def test_area_of_rough_contact_saturates(hardness: float) -> None:
    """Fully plastic contact has the area fraction F / (H A0)."""
    cells, side = 64, 1e-6
    heights = mtb.roughness(cells, side, rms_slope=0.3, seed=1)
    nominal = (cells * side) ** 2
    pressed: dict[str, Any] = {"lower": mtb.steel, "upper": mtb.Rigid(), "periodic": True}
    force = 0.3 * hardness * nominal
    found = mtb.solve_normal(heights.max() - heights, side, **pressed, force=force, hardness=hardness)
    assert found.normal_force == pytest.approx(force, rel=1e-6)
    fraction = found.contact_area / nominal
    assert 0.3 * (1.0 - 1e-9) <= fraction < 0.3 * (1.1 if hardness < 5e8 else 1.25)
    soft = mtb.solve_normal(heights.max() - heights, side, **pressed, force=force)
    assert soft.contact_area < found.contact_area


def test_area_over_the_load_is_straight_where_tips_flow() -> None:
    heights = mtb.roughness(48, 1e-6, rms_slope=0.5, seed=2)
    nominal, hardness = (48e-6) ** 2, 3e8
    forces = np.array([0.05, 0.1, 0.2, 0.4]) * hardness * nominal
    curve = mtb.area_load_curve(
        heights.max() - heights, 1e-6, forces, lower=mtb.steel, upper=mtb.Rigid(), hardness=hardness
    )
    assert curve.contact_area == pytest.approx(forces / hardness, rel=0.08)
    assert np.all(curve.contact_area >= forces / hardness * (1.0 - 1e-9))


@pytest.mark.parametrize("tilts", [(None, None), (0.0, 0.0)])
@pytest.mark.parametrize("share", [0.05, 0.4])
def test_soft_bodies_whose_points_are_all_open_or_at_the_bound(share: float, tilts: Any) -> None:
    """The force is that of a whole number of cells, so that no point need lie between the bounds."""
    for seed in range(4):
        heights = mtb.roughness(40, 1e-6, rms_slope=0.5, seed=seed)
        force = share * 3e8 * (40e-6) ** 2
        found = mtb.solve_normal(
            heights.max() - heights, 1e-6, lower=mtb.steel, upper=mtb.Rigid(), hardness=3e8, force=force,
            edge="sharp", moments_about_axes=tilts,
        )  # fmt: skip
        assert found.normal_force == pytest.approx(force, rel=1e-9)
        assert found.gap.min() > -1e-4 * heights.std()


def test_a_high_hardness_changes_nothing() -> None:
    gap, side = bowl(40)
    elastic = mtb.solve_normal(gap, side, **STEEL, force=500.0)
    found = mtb.solve_normal(gap, side, **STEEL, force=500.0, hardness=1e12)
    assert found.pressure == pytest.approx(elastic.pressure, abs=1e-6 * elastic.pressure.max())
    assert found.plastic_indentation is not None
    assert not found.plastic_indentation.any()


def test_layer_and_hardness_together() -> None:
    """On soft springs a ball flows in a disc where d - r^2 / 2R > L H."""
    gap, side = bowl(60)
    layer, approach = 1e-11, 4e-5
    hardness = 0.5 * approach / layer
    found = mtb.solve_normal(
        gap, side, lower=mtb.steel, upper=mtb.Rigid(), approach=approach, normal_layer=1e4 * layer,
        hardness=1e-4 * hardness,
    )  # fmt: skip
    exact = np.clip((approach - gap) / (1e4 * layer), 0.0, 1e-4 * hardness)
    assert found.pressure == pytest.approx(exact, abs=2e-2 * exact.max())


def test_what_cannot_be_is_refused() -> None:
    gap, side = bowl(40)
    with pytest.raises(ValueError, match="hardness"):
        mtb.solve_normal(gap, side, **STEEL, force=1.0, hardness=-1.0)
    with pytest.raises(ValueError, match=r"at a hardness of 1e\+06 Pa the whole grid carries 36 N"):
        mtb.solve_normal(gap, side, **STEEL, force=36.0, hardness=1e6)
    with pytest.raises(ValueError, match='method is "dense"'):
        mtb.solve_normal(gap, side, **STEEL, force=1.0, hardness=1e9, method="dense")


def test_the_tolerance_follows_the_pressures_below_the_hardness() -> None:
    # where nearly all flows, the pressure is the hardness on any grid, and tells no error
    x = (np.arange(64) - 31.5) * 1e-5
    gap = (x[None] ** 2 + x[:, None] ** 2) / (2.0 * 0.01)
    words = {"lower": mtb.steel, "upper": mtb.Rigid(), "force": 60.0, "method": "fft"}
    hardness = 0.5 * mtb.solve_normal(gap, 1e-5, **words).report.peak_pressure
    found = mtb.solve_normal(gap, 1e-5, hardness=hardness, **words)
    tight = mtb.solve_normal(gap, 1e-5, hardness=hardness, tolerance=1e-10, **words)
    assert (tight.pressure >= hardness).sum() > 0.8 * (tight.status > 0).sum()
    assert found.report.iterations < tight.report.iterations - 2
    assert found.report.residual < 1e-5
    assert found.approach == pytest.approx(tight.approach, rel=1e-5)
    assert np.linalg.norm(found.pressure - tight.pressure) < 1e-3 * np.linalg.norm(tight.pressure)


@pytest.mark.parametrize("moments", [(0.0, 0.0), (0.0, None), (None, 0.0)])
def test_bodies_that_tilt_freely_flow_as_those_that_do_not(
    moments: tuple[float | None, float | None],
) -> None:
    """Of what is symmetric no tilt is needed; looking for it must not lose the balance."""
    step = 1e-4
    for n, share, hardness in ((16, 0.41, 0.7), (34, 0.27, 0.7), (34, 0.22, 0.9), (30, 0.34, 0.9)):
        x = (np.arange(n) + 0.5 - n / 2) * step
        radius, width = 0.05, share * n * step / 2
        given = {
            "gap": (x[None, :] ** 2 + x[:, None] ** 2) / (2.0 * radius),
            "spacing": step,
            "lower": mtb.steel,
            "upper": mtb.Rigid(),
            "force": 4.0 / 3.0 * mtb.steel.plane_strain_modulus * width**3 / radius,
        }
        bound = hardness * mtb.solve_normal(**given).report.peak_pressure
        level, free = (
            mtb.solve_normal(**given, hardness=bound, tolerance=1e-9, moments_about_axes=about)
            for about in ((None, None), moments)
        )
        assert free.pressure == pytest.approx(level.pressure, abs=1e-6 * bound)


@pytest.mark.parametrize("far", [3e-4, 5e-3, 1.0])
@pytest.mark.parametrize("force", [0.01, 0.1, 1.0])
def test_a_hardness_that_nothing_reaches_changes_nothing(far: float, force: float) -> None:
    """A pin with a domed end, far open beside it: the bodies stay elastic, and the search knows no bound."""
    x = (np.arange(64) - 31.5) * 1e-5
    square = x[None, :] ** 2 + x[:, None] ** 2
    gap = np.where(square < 1.5e-4**2, square / 0.1, far)
    elastic = mtb.solve_normal(gap, 1e-5, **STEEL, force=force, tolerance=1e-9)
    found = mtb.solve_normal(gap, 1e-5, **STEEL, force=force, tolerance=1e-9, hardness=3e9)
    assert np.abs(found.pressure - elastic.pressure).max() < 1e-6 * elastic.pressure.max()
    assert found.report.convolutions < 1.5 * elastic.report.convolutions


def test_a_surface_that_flowed_wholly_does_so_no_further_under_the_same_force() -> None:
    """A hollow strip of which every loaded cell flows: the approach is the least of all that would do."""
    x, y = np.meshgrid((np.arange(3) - 1.0) * 1e-5, (np.arange(200) - 99.5) * 1e-5)
    gap = -(x**2 + y**2) / 0.1
    gap -= gap.min()
    given: dict[str, Any] = {"edge": "sharp", "hardness": 1e8, "force": 1e8 * 0.01 * gap.size * 1e-10}
    first = mtb.solve_normal(gap, 1e-5, **STEEL, **given)
    assert (first.pressure[first.pressure > 0.0] > 0.999e8).all()
    dent = first.plastic_indentation
    again = mtb.solve_normal(gap + dent, 1e-5, **STEEL, **given)
    assert again.plastic_indentation.max() < 1e-3 * dent.max()
    assert abs(again.approach - first.approach) < 1e-3 * first.approach


@pytest.mark.parametrize(("shape", "ratio"), [((97, 101), 3.0), ((64, 64), 6.0)])
def test_bodies_that_tilt_far_flow_where_few_points_lie_between_the_bounds(
    shape: tuple[int, int], ratio: float
) -> None:
    """A flat top, so soft against its gap that three points carry what the others leave."""
    ny, nx = shape
    step, force = 1e-3, 100.0
    length = nx * step
    x = step * (np.arange(nx) - (nx - 1) / 2)[None, :]
    y = step * (np.arange(ny) - (ny - 1) / 2)[:, None]
    gap = np.maximum((x**2 + y**2) / length**2 - 0.04, 0.0) * length * 1e-3
    moments = (0.05 * force * length, 0.08 * force * length)
    hardness = ratio * force / (gap.size * step**2)
    found = mtb.solve_normal(
        gap, step, **STEEL, force=force, edge="sharp", tolerance=1e-6, moments_about_axes=moments,
        hardness=hardness,
    )  # fmt: skip
    assert found.pressure.max() <= hardness * (1.0 + 1e-9)
    assert found.normal_force == pytest.approx(force, rel=1e-9)
    about_x = float((found.pressure * y).sum()) * step**2
    about_y = float((found.pressure * x).sum()) * step**2
    assert np.abs([about_x, about_y]) == pytest.approx(np.abs(moments), rel=1e-6)
    between = (found.pressure > 0.0) & (found.pressure < hardness)
    assert between.sum() < 0.1 * (found.pressure >= hardness).sum()
    assert found.gap[~between & (found.pressure == 0.0)].min() > -1e-6 * found.approach
