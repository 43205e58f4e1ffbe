# SPDX-License-Identifier: MIT OR Apache-2.0
"""Prisms against half-spaces, beams, finite elements of scikit-fem, and the rail of tetrahedra."""

from __future__ import annotations

import time
from pathlib import Path

import numpy as np
import pytest
import scipy.sparse.linalg
from numpy.typing import NDArray

import mtb_rs as mtb
from mtb_rs.bodies.prism import OnPrism
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


@pytest.mark.parametrize("component", [0, 1, 2])
def test_a_large_block_is_a_half_space(component: int) -> None:
    """Within half a percent: its base, at 50 contact widths, takes off about that."""
    body, places = on_flat(mtb.Prism((1.0, 1.0), STEEL))
    grid = FLAT.grid((2e-3, 2e-3))
    half_space = hats_of(mtb.HalfSpace(STEEL), grid.nodes, grid.node_patches, upper=False).compliance
    assert half_space is not None
    traction = np.zeros((3, places.shape[1]))
    traction[component] = hill(places)
    own, exact = body.compliance.displacement(traction), half_space.displacement(traction)
    largest = np.abs(exact).max()
    middle = places.shape[1] // 2
    # what a base takes off is even: it is not part of what half-space and prism have in common
    apart = own - exact
    assert np.abs(apart - apart[:, [middle]]).max() < 5e-4 * largest
    assert -0.02 * largest < apart[component, middle] < 0.0


def test_a_rail_on_soft_pads_is_a_beam_on_winklers_foundation() -> None:
    """Far below what is local: deflection F / (2 sqrt(2) (E I)^(1/4) c^(3/4)) [Johnson1985]."""
    width, height, c = 0.04, 0.05, 2e6
    soft, hard = (on_flat(mtb.Prism((width, height), STEEL, (stiffness, 1e8))) for stiffness in (c, 4.0 * c))
    traction = np.zeros((3, soft[1].shape[1]))
    traction[2] = hill(soft[1])
    grid = FLAT.grid((2e-3, 2e-3))
    force = float(hill(soft[1]) @ (grid.node_patches[0].spacing[0] ** 2 * np.ones(soft[1].shape[1])))
    inertia = width * height**3 / 12.0
    moved = [body.compliance.displacement(traction)[2].max() for body, _ in (soft, hard)]
    # shear and what is local are the same on both: the difference is that of two beams
    beams = [force / (2.0**1.5 * (208e9 * inertia) ** 0.25 * k**0.75) for k in (c, 4.0 * c)]
    assert moved[0] - moved[1] == pytest.approx(beams[0] - beams[1], rel=5e-3)


@pytest.mark.slow
def test_against_a_long_bar_of_scikit_fem() -> None:
    """A bar of 60 x 50 mm held below, 0.3 m long: its ends are free, far away."""
    import skfem
    from skfem.models.elasticity import lame_parameters, linear_elasticity

    width, height, length = 0.06, 0.05, 0.3
    along = np.array([0.0, 5e-3, 10e-3, 16e-3, 28e-3, 50e-3, 0.09, 0.5 * length])
    across = np.array([0.0, 5e-3, 10e-3, 18e-3, 0.5 * width])
    depth = -np.array([height, 0.03, 0.016, 7e-3, 0.0])
    # a quarter, symmetric about x = 0 and y = 0
    mesh = skfem.MeshHex.init_tensor(along, across, depth)
    element = skfem.ElementVector(skfem.ElementHex2())
    basis = skfem.Basis(mesh, element)
    stiffness = linear_elasticity(*lame_parameters(208e9, 0.3)).assemble(basis)
    top = skfem.FacetBasis(mesh, element, facets=mesh.facets_satisfying(lambda x: np.abs(x[2]) < 1e-9))
    coarse = np.linspace(-10e-3, 10e-3, 5)

    def bilinear(at: Array) -> Array:
        line = np.cos(0.5 * np.pi * coarse / 0.01) ** 2
        return np.asarray(np.interp(at[0], coarse, line) * np.interp(at[1], coarse, line))

    inside = skfem.LinearForm(
        lambda v, w: -bilinear(w.x) * v[2] * (np.abs(w.x[0]) < 0.01) * (np.abs(w.x[1]) < 0.01)
    )
    load = inside.assemble(top)
    x, y, z = basis.doflocs
    held = np.abs(z + height) < 1e-9
    direction = np.empty(basis.N, dtype=int)
    for c in range(3):
        direction[np.unique(basis.get_dofs(elements=True).all(f"u^{c + 1}"))] = c
    held |= (direction == 0) & (np.abs(x) < 1e-9)
    held |= (direction == 1) & (np.abs(y) < 1e-9)
    free = np.flatnonzero(~held)
    moved = np.zeros(basis.N)
    moved[free] = scipy.sparse.linalg.spsolve(stiffness[free][:, free].tocsc(), load[free])
    energy = float(4.0 * load @ moved)

    grid = FLAT.grid((5e-3, 5e-3))
    body = mtb.Prism((width, height), STEEL).on(grid.nodes, grid.node_patches, hats=True)
    traction = np.zeros((3, grid.nodes.gap.size))
    traction[2] = bilinear(grid.nodes.points)
    own = body.compliance.displacement(traction)[2]
    work = float((5e-3**2 * traction[2] * own).sum())
    assert work == pytest.approx(energy, rel=5e-3)


def shoe(lower: object = STEEL, **given: object) -> mtb.Scene:
    return mtb.scenes.pole_shoe_on_rail(lower=lower, friction=0.4, **given)  # type: ignore[arg-type]


@pytest.mark.slow
def test_it_is_the_rail_of_tetrahedra_without_its_ends() -> None:
    """Displacement within 2 %, for less than a fifth of the time."""
    scene, on_prism = shoe(spacing=3e-3, rail_length=0.4), shoe(mtb.Prism("60E1", STEEL), spacing=3e-3)
    clock = time.process_time()
    below = scene.problem("elastic-both", may_halve=False)
    whole = time.process_time() - clock
    clock = time.process_time()
    grid = on_prism.geometry.grid((3e-3, 3e-3))
    made = mtb.Prism("60E1", STEEL).on(grid.nodes, grid.node_patches, hats=True)
    own = time.process_time() - clock
    upper = scene.problem("elastic-upper")
    assert upper.n == below.n == grid.nodes.gap.size
    traction = np.zeros((3, below.n))
    traction[2] = 3e6
    traction[0] = 1e6
    assert below.lower.compliance is not None
    solid = below.lower.compliance.displacement(traction)
    prism = made.compliance.displacement(traction)
    for component in (0, 2):
        size = np.abs(solid[component]).max()
        assert np.abs(prism[component] - solid[component]).max() < 0.02 * size
    print(f"prism {own:.2f} s, both bodies of tetrahedra {whole:.2f} s")


@pytest.mark.slow
def test_the_shoe_on_it_is_that_on_the_rail() -> None:
    solid = shoe(spacing=6e-3, rail_length=0.4).solve("elastic-both")
    prism = shoe(mtb.Prism("60E1", STEEL), spacing=6e-3).solve("elastic-upper")
    assert prism.normal_force == pytest.approx(solid.normal_force, rel=1e-3)
    inner = solid.pressure > 0.2 * solid.pressure.max()
    apart = np.linalg.norm((prism.pressure - solid.pressure)[inner]) / np.linalg.norm(solid.pressure[inner])
    assert apart < 0.02
    assert any("The prism has" in note for note in prism.report.notes)


@pytest.mark.coarse
def test_ways_of_a_scene(tmp_path: Path) -> None:
    """Solve, steps, save and load, case files."""
    rail = mtb.Prism("60E1", STEEL, (1e8, 5e7))
    scene = shoe(rail, spacing=9e-3, attraction="both")
    for model in ("half-space", "elastic-upper"):
        result = scene.solve(model)  # type: ignore[arg-type]
        step = scene.prepare(model).step(velocity=1.0)  # type: ignore[arg-type]
        assert step.normal_force == pytest.approx(result.normal_force, rel=1e-6)
        result.save(tmp_path / model)
        again = mtb.load(tmp_path / model)
        assert np.array_equal(again.pressure, result.pressure)
        with pytest.raises(ValueError, match="Prism"):
            result.derivative("normal_force", "lower.young_modulus")
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
