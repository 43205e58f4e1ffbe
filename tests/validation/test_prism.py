# SPDX-License-Identifier: MIT OR Apache-2.0
"""Prisms against half-spaces, beams, and the rail of tetrahedra."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

import mtb_rs as mtb
from mtb_rs.bodies.prism import OnPrism
from mtb_rs.contact.elastic import rail
from mtb_rs.contact.standing import hats_of
from mtb_rs.geometry.geometries import BlockOnPlane

Array = NDArray[np.float64]
STEEL = mtb.Material(208e9, 0.3)
FLAT = BlockOnPlane(0.02, 0.02, 0.02)


def on_flat(prism: mtb.Prism, spacing: float = 2e-3) -> tuple[OnPrism, Array]:
    """A prism under the hats of a square of 20 mm, and where these are."""
    grid = FLAT.grid((spacing, spacing))
    return prism.on(grid.nodes, grid.node_patches, hats=True), grid.nodes.points


def hill(points: Array) -> Array:
    """A pressure that is smooth and vanishes at the edge of the square."""
    return np.asarray(np.prod(np.cos(0.5 * np.pi * points[:2] / 0.01) ** 2, axis=0))


def test_a_large_block_is_a_half_space() -> None:
    """Within half a percent, but for what far sides and base do evenly over the contact."""
    size = 0.3
    body, places = on_flat(mtb.Prism((size, size), STEEL), 4e-3)
    grid = FLAT.grid((4e-3, 4e-3))
    half_space = hats_of(mtb.HalfSpace(STEEL), grid.nodes, grid.node_patches, upper=False).compliance
    assert half_space is not None
    middle = places.shape[1] // 2
    for component in range(3):
        traction = np.zeros((3, places.shape[1]))
        traction[component] = hill(places)
        own, exact = body.compliance.displacement(traction), half_space.displacement(traction)
        largest = np.abs(exact).max()
        apart = own - exact
        assert np.abs(apart - apart[:, [middle]]).max() < 5e-3 * largest
        # some F / (G size), where the block in itself moves as F / (G 10 mm)
        force = float(hill(places).sum()) * 16e-6
        assert abs(apart[component, middle]) < 1.5 * force / (STEEL.shear_modulus * size)


def test_a_rail_on_soft_pads_is_a_beam_on_winklers_foundation() -> None:
    """Far below what is local: deflection F / (2 sqrt(2) (E I)^(1/4) c^(3/4)) [Johnson1985]."""
    width, height, c = 0.04, 0.05, 2e6
    soft, hard = (on_flat(mtb.Prism((width, height), STEEL, (stiffness, 1e4))) for stiffness in (c, 4.0 * c))
    traction = np.zeros((3, soft[1].shape[1]))
    traction[2] = hill(soft[1])
    grid = FLAT.grid((2e-3, 2e-3))
    force = float(hill(soft[1]) @ (grid.node_patches[0].spacing[0] ** 2 * np.ones(soft[1].shape[1])))
    inertia = width * height**3 / 12.0
    moved = [body.compliance.displacement(traction)[2].max() for body, _ in (soft, hard)]
    # shear and what is local are the same on both: the difference is that of two beams
    beams = [force / (2.0**1.5 * (208e9 * inertia) ** 0.25 * k**0.75) for k in (c, 4.0 * c)]
    assert moved[0] - moved[1] == pytest.approx(beams[0] - beams[1], rel=5e-3)


def shoe(lower: object = STEEL, **given: object) -> mtb.Scene:
    return mtb.scenes.pole_shoe_on_rail(lower=lower, friction=0.4, **given)  # type: ignore[arg-type]


@pytest.mark.slow
def test_it_is_the_rail_of_tetrahedra_without_its_ends() -> None:
    """Within 2 % of a rail of 3 m: the head bends sideways on its web over half a metre to either side."""
    spacing = (9e-3, 9e-3)
    long = shoe(spacing=spacing, rail_length=3.0)
    grid = long.geometry.grid(spacing)
    solid, _ = rail(long.geometry, grid, STEEL, None, None, {})
    prism = mtb.Prism("60E1", STEEL).on(grid.nodes, grid.node_patches, hats=True)
    for component in range(3):
        traction = np.zeros((3, grid.nodes.gap.size))
        traction[component] = 1e6
        exact, own = (body.displacement(traction) for body in (solid.compliance, prism.compliance))
        assert own[component].mean() == pytest.approx(exact[component].mean(), rel=0.02)


@pytest.mark.coarse
@pytest.mark.slow
def test_ways_of_a_scene(tmp_path: Path) -> None:
    """Solve, steps, save and load, case files."""
    rail = mtb.Prism("60E1", STEEL, (1e8, 5e7))
    scene = shoe(rail, spacing=9e-3, attraction="both")
    for model in ("half-space", "elastic-upper"):
        result = scene.solve(model)  # type: ignore[arg-type]
        step = scene.prepare(model).step(velocity=1.0)  # type: ignore[arg-type]
        assert np.allclose(step.force, result.force, rtol=1e-6, atol=1e-6 * result.normal_force)
        result.save(tmp_path / model)
        again = mtb.load(tmp_path / model)
        assert np.array_equal(again.pressure, result.pressure)
    assert result.displacement.lower[2].min() < 0.0
    file = tmp_path / "case.toml"
    file.write_text(
        'scene = "pole_shoe_on_rail"\nspacing = 9e-3\nfriction = 0.4\nattraction = "both"\n'
        '[lower]\nprism = "60E1"\nfoundation = [1e8, 5e7]\n'
        "material = { young_modulus = 208e9, poisson_ratio = 0.3 }\n"
    )
    assert mtb.load_case(file).scene().lower == rail


REFUSED = {
    "above": (lambda: mtb.scenes.block_on_plane(upper=mtb.Prism((0.1, 0.1))), "upper is Prism"),
    "turned": (lambda: shoe(mtb.Prism("60E1"), yaw=0.01, spacing=9e-3).solve("half-space"), "turned against"),
    "other profile": (
        lambda: shoe(mtb.Prism((0.1, 0.1)), spacing=9e-3).solve("half-space"),
        "off the surface",
    ),
    "both": (lambda: shoe(mtb.Prism("60E1"), spacing=9e-3).solve("elastic-both"), "elastic in every model"),
    "rolling": (lambda: mtb.scenes.wheel_on_rail(lower=mtb.Prism("60E1")), "which is not taken here"),
    "narrow": (
        lambda: mtb.scenes.block_on_plane(lower=mtb.Prism((0.05, 0.1)), spacing=0.02).solve("half-space"),
        "the contact strip lies within",
    ),
    "size": (lambda: mtb.Prism((0.0, 1.0)), "width"),
    "foundation": (lambda: mtb.Prism("60E1", foundation=(1e8, 0.0)), "lateral"),
    "rubber": (lambda: mtb.Prism("60E1", mtb.Material(1e7, 0.5)), "Poisson's ratio of a prism"),
    "stress": (
        lambda: shoe(mtb.Prism("60E1"), spacing=9e-3).solve("half-space").stress(body="lower"),
        "is a Prism",
    ),
}


@pytest.mark.coarse
@pytest.mark.parametrize("name", REFUSED)
def test_what_it_is_not_for_is_refused(name: str) -> None:
    ask, words = REFUSED[name]
    with pytest.raises(ValueError, match=words):
        ask()


def test_steps_over_a_prism_are_kept_and_read_again(tmp_path: Path) -> None:
    scene = mtb.scenes.pole_shoe_on_rail(friction=0.3, spacing=12e-3, lower=mtb.Prism("60E1"))
    contact = scene.prepare("half-space")
    for name, given in (("slid", {"velocity": 1.0}), ("shifted", {"shift": 1e-7})):
        step = contact.step(**given)
        step.save(tmp_path / name)
        again = mtb.load(tmp_path / name)
        assert isinstance(again, mtb.StepResult)
        np.testing.assert_array_equal(again.traction, step.traction)
