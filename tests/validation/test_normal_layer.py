# SPDX-License-Identifier: MIT OR Apache-2.0
"""A layer that gives way under the pressure, against a foundation of springs and Westergaard's wave."""

from typing import Any

import numpy as np
import pytest

import mtb_rs as mtb

RADIUS, FORCE, LAYER = 0.1, 200.0, 1e-9
#: With an approach d the springs carry F = pi R d^2 / L.
APPROACH = np.sqrt(FORCE * LAYER / (np.pi * RADIUS))


def bowl(cells: int) -> tuple[np.ndarray, float]:
    x = (np.arange(cells) - cells // 2) * 28e-3 / cells
    return (x[None, :] ** 2 + x[:, None] ** 2) / (2.0 * RADIUS), 28e-3 / cells


def ball(cells: int, **given: Any) -> mtb.Scene:
    """A sphere on a layer a thousand times softer than the bodies."""
    gap, spacing = bowl(cells)
    bodies: dict[str, Any] = {"upper": mtb.steel, "lower": mtb.steel, "normal_layer": LAYER}
    return mtb.Scene(**bodies | given, gap=gap, spacing=spacing, friction=0.3, force=FORCE)


# 51 x 51 cells are of a size for convolutions
@pytest.mark.parametrize(
    "scene",
    [
        ball(41),
        ball(41, lower=mtb.Rigid()),
        ball(51),
        ball(41, normal_layer=np.full((41, 41), LAYER)),
        ball(41, normal_layer=lambda x, y: LAYER + 0.0 * x),
        # the same flexibility by a material
        ball(41, normal_layer=mtb.ThinLayer(1e-3, 1e6, 0.0)),
    ],
)
def test_a_soft_layer_is_a_foundation_of_springs(scene: mtb.Scene) -> None:
    found = scene.solve()
    assert found.pressure.max() == pytest.approx(APPROACH / LAYER, rel=1e-2)
    # displacements are the bodies' own
    assert max(np.abs(u).max() for u in found.displacement) < 1e-2 * APPROACH
    stepped = scene.prepare().step(velocity=1.0)
    assert stepped.pressure.max() == pytest.approx(APPROACH / LAYER, rel=1e-2)


@pytest.mark.parametrize("method", ["dense", "fft"])
def test_half_spaces_alone_with_a_layer(method: Any) -> None:
    gap, spacing = bowl(41)
    bodies: dict[str, Any] = {"lower": mtb.steel, "upper": mtb.steel}
    found = mtb.solve_normal(gap, spacing, **bodies, force=FORCE, normal_layer=LAYER, method=method)
    assert found.pressure.max() == pytest.approx(APPROACH / LAYER, rel=1e-2)
    assert found.approach == pytest.approx(APPROACH, rel=1e-2)
    of_scene = ball(41).with_(friction=0.0).solve()
    assert found.pressure == pytest.approx(of_scene.pressure, abs=1e-5 * found.pressure.max())
    # rolling follows the pressure
    rolled = mtb.solve_tangential(found, mtb.Rolling((1e-3, 0.0, 0.0)), mtb.Coulomb(0.3))
    assert rolled.normal_force == pytest.approx(FORCE, rel=1e-6)


def test_a_wave_is_pressed_flat_through_a_layer() -> None:
    """In full contact each wave of the gap has its pressure over the sum of both compliances."""
    cells, length, height, layer = 64, 1e-3, 1e-7, 2e-14
    x = (np.arange(cells) + 0.5) * length / cells
    gap = np.broadcast_to(height * (1.0 - np.cos(2 * np.pi * 2 * x / length)), (cells, cells))
    rigid: dict[str, Any] = {"upper": mtb.Rigid(), "lower": mtb.steel, "periodic": True}
    mean = 4e9
    force = mean * length**2
    found = mtb.solve_normal(gap, length / cells, **rigid, force=force, normal_layer=layer)
    wave = 2.0 * (1.0 - mtb.steel.poisson_ratio**2) / mtb.steel.young_modulus / (4 * np.pi / length)
    exact = mean - height * -np.cos(2 * np.pi * 2 * x / length) / (wave + layer)
    assert found.pressure[3] == pytest.approx(exact, rel=1e-6)
    # the mean too gives way in the layer
    assert found.approach == pytest.approx(height + layer * mean, rel=1e-6)
    again = mtb.solve_normal(gap, length / cells, **rigid, approach=found.approach, normal_layer=layer)
    assert again.normal_force == pytest.approx(force, rel=1e-6)


@pytest.mark.parametrize("attraction", ["upper", "both"])
@pytest.mark.parametrize("model", ["half-space", "elastic-upper", "elastic-both"])
@pytest.mark.coarse
def test_a_step_under_another_pull_is_its_solve(model: Any, attraction: Any) -> None:
    shoe = mtb.scenes.pole_shoe_on_rail(spacing=6e-3, attraction=attraction, normal_layer=1e-12)
    other = shoe.with_(magnetic_pressure=1e6).solve(model)
    stepped = shoe.prepare(model).step(velocity=1.0, magnetic_pressure=1e6)
    assert stepped.pressure == pytest.approx(other.pressure, abs=1e-9 * other.pressure.max())


@pytest.mark.coarse
def test_mirror_halves_look_at_the_layer() -> None:
    """A shoe that is its own mirror image is solved by its half only with a layer that is, too."""
    shoe = mtb.scenes.pole_shoe_on_rail(spacing=6e-3, friction=0.1)
    even = shoe.with_(normal_layer=(2e-12, 2e-12)).solve("elastic-both")
    assert even.pressure == pytest.approx(
        shoe.with_(normal_layer=2e-12).solve("elastic-both").pressure, rel=1e-9
    )
    uneven = shoe.with_(normal_layer=(2e-12, 6e-12)).solve("elastic-both")
    assert uneven.pressure != pytest.approx(even.pressure, rel=1e-2)
    swapped = shoe.with_(normal_layer=(6e-12, 2e-12)).solve("elastic-both")
    assert np.sort(swapped.pressure) == pytest.approx(np.sort(uneven.pressure), rel=1e-6)


@pytest.mark.coarse
def test_derivatives_by_the_layer() -> None:
    scene = ball(21, normal_layer=3e-11)
    result = scene.solve("half-space")
    by = result.derivative("peak_pressure", "normal_layer")
    h = 1e-4 * 3e-11
    above, below = (
        ball(21, normal_layer=3e-11 + s).solve("half-space").report.peak_pressure for s in (h, -h)
    )
    assert by == pytest.approx((above - below) / (2.0 * h), rel=1e-4)


def test_a_thin_layer_is_the_limit_of_a_body() -> None:
    layer = mtb.ThinLayer(1e-3, 2e9, 0.3)
    assert layer.normal_flexibility == pytest.approx(1e-3 * 1.3 * 0.4 / (0.7 * 2e9))


def test_what_is_no_layer_is_refused() -> None:
    with pytest.raises(ValueError, match="normal_layer"):
        ball(41).with_(normal_layer=-1.0)
    gap, spacing = bowl(9)
    with pytest.raises(ValueError, match="normal_layer is -1 m/Pa"):
        mtb.solve_normal(gap, spacing, lower=mtb.steel, upper=mtb.steel, force=1.0, normal_layer=-1.0)
    with pytest.raises(ValueError, match=r"poisson_ratio is 0\.49: .* flows sideways"):
        mtb.ThinLayer(1e-3, 1e9, 0.49)
    with pytest.raises(ValueError, match=r"normal_layer is 1e-12: .* cannot take it"):
        mtb.scenes.pole_shoe_on_rail(spacing=6e-3, normal_layer=1e-12).solve(
            "half-space", method="incremental"
        )
