# SPDX-License-Identifier: MIT OR Apache-2.0
"""A hardness in scenes and steps, against a projected solver with its own matrix, full flow, solve_normal."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import mtb_rs as mtb
from mtb_rs.bodies.mesh import block_mesh

Array = NDArray[np.float64]

RADIUS, WIDTH, FORCE = 0.1, 3e-3, 400.0
MODULUS = mtb.steel.young_modulus / (1.0 - mtb.steel.poisson_ratio**2) / 2.0
#: Hertz' peak pressure.
PEAK = (6.0 * FORCE * MODULUS**2 / (np.pi**3 * RADIUS**2)) ** (1 / 3)
HARD = 0.7 * PEAK


def bowl(cells: int) -> tuple[Array, float]:
    side = WIDTH / cells
    x = (np.arange(cells) - (cells - 1) / 2) * side
    return (x[None, :] ** 2 + x[:, None] ** 2) / (2.0 * RADIUS), side


def ball(cells: int = 21, **given: Any) -> mtb.Scene:
    gap, side = bowl(cells)
    bodies: dict[str, Any] = {"upper": mtb.steel, "lower": mtb.steel, "force": FORCE, "hardness": HARD}
    return mtb.Scene(**bodies | given, gap=gap, spacing=side)


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


def projected(matrix: Array, gap: Array, force: float, cap: float, area: float) -> tuple[Array, Array]:
    """Gauss and Seidel with bounds, bisected over the approach until the force is carried."""
    low, high = 0.0, float(cap * np.trace(matrix)) + float(gap.max())
    pressure = np.zeros(gap.size)
    for _ in range(60):
        approach = 0.5 * (low + high)
        for _ in range(4000):
            before = pressure.copy()
            for i in range(gap.size):
                rest = matrix[i] @ pressure + gap[i] - approach
                pressure[i] = min(max(pressure[i] - rest / matrix[i, i], 0.0), cap)
            if np.abs(pressure - before).max() < 1e-12 * cap:
                break
        low, high = (approach, high) if pressure.sum() * area < force else (low, approach)
    return pressure, matrix @ pressure + gap - approach


@pytest.mark.coarse
def test_against_a_projected_solver() -> None:
    cells = 9
    gap, side = bowl(cells)
    found = ball(cells, friction=0.0).solve("half-space")
    pressure, left = projected(influence(cells, side), gap.ravel(), FORCE, HARD, side**2)
    assert (pressure >= HARD).sum() >= 4
    assert found.pressure.ravel() == pytest.approx(pressure, abs=1e-7 * HARD)
    assert found.plastic_indentation is not None
    flowed = np.maximum(-left, 0.0)
    assert found.plastic_indentation.ravel() == pytest.approx(flowed, abs=1e-7 * flowed.max())
    assert found.gap.min() >= 0.0


@pytest.mark.coarse
@pytest.mark.parametrize("friction", [0.0, 0.4])
def test_like_half_spaces_are_those_of_solve_normal(friction: float) -> None:
    """Friction of like bodies opens nothing."""
    gap, side = bowl(21)
    normal = mtb.solve_normal(
        gap, side, lower=mtb.steel, upper=mtb.steel, force=FORCE, hardness=HARD, tolerance=1e-11
    )
    scene = ball(friction=friction)
    for found in (scene.solve("half-space"), scene.prepare().step(velocity=1.0)):
        assert found.pressure.ravel() == pytest.approx(normal.pressure.ravel(), abs=1e-7 * HARD)
        assert found.plastic_indentation is not None
        assert normal.plastic_indentation is not None
        flowed = normal.plastic_indentation
        assert np.ravel(found.plastic_indentation) == pytest.approx(flowed.ravel(), abs=1e-6 * flowed.max())
    whole = scene.solve("half-space")
    flows = whole.pressure >= HARD
    assert flows.sum() > 10
    assert whole.traction[0][flows] == pytest.approx(friction * HARD, rel=1e-12)
    assert whole.report.force_balance["relative_error"] < 1e-9
    assert "plastic flow" in whole.report.omitted


@pytest.mark.coarse
def test_a_rigid_punch_flows_everywhere_at_its_limit_load() -> None:
    side, hard = 12e-3, 5e8
    limit = hard * side**2
    punch = mtb.scenes.block_on_plane(side, 0.1, 0.3, spacing=1e-3, hardness=hard)
    for share in (0.9, 1.0 - 1e-6):
        scene = punch.with_(magnetic_pressure=None, force=share * limit)
        for found in (scene.solve("half-space"), scene.prepare("half-space").step(velocity=1.0)):
            assert np.abs(found.pressure - hard).max() < 1.01 * 144 * (1.0 - share) * hard
            assert found.pressure.mean() == pytest.approx(share * hard, rel=1e-9)
    beyond = punch.with_(magnetic_pressure=None, force=1.01 * limit)
    with pytest.raises(mtb.ResultantError, match=r"hardness of 5e\+08 Pa the contact points carry 72000 N"):
        beyond.solve("half-space")
    with pytest.raises(mtb.ResultantError, match="hardness"):
        beyond.prepare("half-space").step(velocity=1.0)


@pytest.mark.coarse
@pytest.mark.parametrize("model", ["half-space", "elastic-upper", "elastic-both"])
@pytest.mark.parametrize("attraction", ["upper", "both"])
def test_pole_shoe(model: Any, attraction: Any) -> None:
    shoe = mtb.scenes.pole_shoe_on_rail(spacing=6e-3, attraction=attraction)
    elastic = shoe.solve(model)
    mean = elastic.normal_force / float(elastic.area.sum())
    hard = 0.5 * (elastic.report.peak_pressure + mean)
    scene = shoe.with_(hardness=hard)
    found = scene.solve(model)
    assert "mirror half" in found.report.solver
    assert found.coefficients is not None
    pressure = found.coefficients[2]
    assert pressure.max() == pytest.approx(hard, rel=1e-12)
    assert (pressure >= hard).sum() >= 4
    assert found.report.force_balance["relative_error"] < 1e-8
    stepped = scene.prepare(model).step(velocity=1.0)
    assert stepped.state.pressure == pytest.approx(pressure, abs=1e-7 * hard)
    # not symmetric: one pole is softer
    uneven = shoe.with_(hardness=(hard, 10.0 * hard)).solve(model)
    assert "mirror half" not in uneven.report.solver
    assert uneven.coefficients is not None
    left, right = np.split(uneven.coefficients[2], 2)
    assert left.max() == pytest.approx(hard, rel=1e-12)
    assert right.max() > 1.05 * hard
    swapped = shoe.with_(hardness=(10.0 * hard, hard)).solve(model)
    assert np.sort(swapped.pressure.ravel()) == pytest.approx(np.sort(uneven.pressure.ravel()), rel=1e-6)


@pytest.mark.coarse
def test_own_bodies() -> None:
    line = np.linspace(-10e-3, 10e-3, 9)
    block = mtb.ElasticBody(
        block_mesh(line, line, 10e-3), mtb.steel, "contact", [mtb.Support("top", x=0, y=0)], "block"
    )
    scene = mtb.Scene(block, mtb.steel, spacing=2.5e-3, friction=0.2, force=2e4)
    hard = 1.4 * 2e4 / 20e-3**2
    found = scene.with_(hardness=hard).solve()
    assert found.coefficients is not None
    assert found.coefficients[2].max() == pytest.approx(hard, rel=1e-12)
    assert found.normal_force == pytest.approx(2e4, rel=1e-8)


@pytest.mark.coarse
def test_steps_go_on_from_flow_and_back(tmp_path: Path) -> None:
    """Steps remember what flowed, and find what a first step would."""
    shoe = mtb.scenes.pole_shoe_on_rail(spacing=6e-3)
    peak = shoe.solve("elastic-upper").report.peak_pressure
    prepared = shoe.with_(hardness=0.7 * peak).prepare("elastic-upper")
    for velocity, pull in ((1.0, 3e6), (2.0, 1e6), (3.0, 4e6), (-1.0, 3.5e6), (1.0, 3e6)):
        walked = prepared.step(velocity=velocity, magnetic_pressure=pull)
        fresh = prepared.copy().step(velocity=velocity, magnetic_pressure=pull)
        assert walked.state.pressure == pytest.approx(fresh.state.pressure, abs=1e-8 * peak)
        assert walked.state.pressure.max() <= 0.7 * peak
    assert walked.plastic_indentation is not None
    # a file knows it
    prepared.save(tmp_path / "shoe.mtbc")
    read = mtb.PreparedContact.load(tmp_path / "shoe.mtbc").step(velocity=1.0, magnetic_pressure=3e6)
    assert np.array_equal(read.state.pressure, fresh.state.pressure)
    assert np.array_equal(mtb.load(walked.save(tmp_path / "step")[0].parent).gap, walked.gap)


@pytest.mark.coarse
def test_derivatives_hold_what_flows() -> None:
    scene = ball(friction=0.3)
    found = scene.solve("half-space")
    h = 1e-4 * FORCE
    by = found.derivative("approach", "force")
    there, here = (scene.with_(force=FORCE + s).solve("half-space") for s in (h, -h))
    assert by == pytest.approx((there.approach - here.approach) / (2.0 * h), rel=1e-4)
    assert found.derivative("peak_pressure", "force") == pytest.approx(0.0, abs=1e-9)
    h = 1e-4 * HARD
    by = found.derivative("approach", "hardness")
    there, here = (scene.with_(hardness=HARD + s).solve("half-space") for s in (h, -h))
    assert by == pytest.approx((there.approach - here.approach) / (2.0 * h), rel=1e-4)
    assert found.derivative("peak_pressure", "hardness") == pytest.approx(1.0, rel=1e-9)


@pytest.mark.coarse
def test_wear_and_heat_keep_the_bound() -> None:
    scene = ball(15, friction=0.3, velocity=1.0)
    worn = mtb.wear(scene, 1.0, 1e-15, model="half-space")
    assert worn.pressure.max() <= HARD * (1.0 + 1e-12)


@pytest.mark.coarse
def test_messages(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="hardness is -1"):
        ball(hardness=-1.0)
    with pytest.raises(ValueError, match=r"hardness is .*pressure=\"held\" takes it"):
        ball(friction=0.3).start_of_sliding([[1e-7, 0.0]])
    started = ball(friction=0.3).start_of_sliding([[1e-7, 0.0]], pressure="held")
    assert started.pressure.max() == pytest.approx(HARD)
    with pytest.raises(ValueError, match=r"hardness is .*cannot take it"):
        ball(friction=0.3).solve("half-space", method="incremental")
    layer = mtb.InterfaceLayer(1e-6, 1e9)
    with pytest.raises(ValueError, match="which shears and does not give way"):
        ball(normal_layer=layer)
    result = ball(friction=0.3).solve("half-space")
    result.save(tmp_path)
    again = mtb.load(tmp_path)
    assert np.array_equal(again.plastic_indentation, result.plastic_indentation)
