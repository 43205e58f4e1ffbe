# SPDX-License-Identifier: MIT OR Apache-2.0
"""Finite elements against scikit-fem on the same mesh, and bodies from surfaces against extruded ones."""

from __future__ import annotations

from contextlib import nullcontext

import numpy as np
import pytest
import trimesh
from numpy.typing import NDArray

import mtb_rs as mtb
from mtb_rs.bodies.mesh import block_mesh, quadratic, rail_mesh, shoe_mesh
from mtb_rs.geometry.geometries import BlockOnPlane
from mtb_rs.geometry.pole_shoe import PoleShoe
from mtb_rs.geometry.profiles import Profile

Array = NDArray[np.float64]
STEEL = mtb.Material(young_modulus=208e9, poisson_ratio=0.3)


def volume(mesh: mtb.TetraMesh) -> float:
    corners = mesh.nodes[mesh.cells[:, :4]]
    a, b, c = (corners[:, k] - corners[:, 0] for k in (1, 2, 3))
    return float(np.einsum("ij,ij->i", np.cross(a, b), c).sum() / 6.0)


def free_block(*, is_quadratic: bool) -> mtb.TetraMesh:
    """A block whose inner nodes have moved."""
    x = np.linspace(0.0, 0.06, 5)
    mesh = block_mesh(x, x[:4], 0.05, quadratic=False)
    nodes = mesh.nodes.copy()
    low, high = nodes.min(axis=0), nodes.max(axis=0)
    inner = ((nodes > low + 1e-9) & (nodes < high - 1e-9)).all(axis=1)
    nodes[inner] += 2e-3 * (np.random.default_rng(1).random((inner.sum(), 3)) - 0.5)
    moved = mtb.TetraMesh(nodes, mesh.cells)
    return quadratic(moved) if is_quadratic else moved


@pytest.mark.parametrize("is_quadratic", [False, True])
def test_displacement_and_reactions_equal_scikit_fem(is_quadratic: bool) -> None:
    import skfem
    from skfem.models.elasticity import lame_parameters, linear_elasticity

    mesh = free_block(is_quadratic=is_quadratic)
    held = [mtb.Support("top", x=1e-6, y=0, z=-2e-6)]
    with nullcontext() if is_quadratic else pytest.warns(UserWarning, match="four nodes"):
        body = mtb.ElasticBody(mesh, STEEL, "bottom", held, linear=not is_quadratic)
    force = np.zeros((3, len(mesh.nodes)))
    bottom = body.nodes_at("load", "bottom")
    force[:, bottom] = np.random.default_rng(2).normal(size=(3, bottom.size)) * 1e3
    u = body.core.solve(force, body.case_values, np.zeros((0, 9)), np.zeros(0))
    reaction = body.core.reactions(u, force, (0.0, 0.0, 0.0))[0][0]

    straight = skfem.MeshTet(mesh.nodes[: mesh.cells[:, :4].max() + 1].T, mesh.cells[:, :4].T)
    element = skfem.ElementTetP2() if is_quadratic else skfem.ElementTetP1()
    basis = skfem.Basis(straight, skfem.ElementVector(element))
    stiffness = linear_elasticity(*lame_parameters(208e9, 0.3)).assemble(basis)
    # match degrees of freedom by place and component
    places = basis.doflocs.T
    component = np.empty(basis.N, dtype=int)
    for k in range(3):
        component[basis.split_indices()[k]] = k
    node = np.array([int(np.argmin(((mesh.nodes - p) ** 2).sum(axis=1))) for p in places])
    load = force[component, node]
    held = np.isin(node, body.nodes_at("top", "top"))  # type: ignore[assignment]
    prescribed = np.zeros(basis.N)
    prescribed[held] = np.array([1e-6, 0.0, -2e-6])[component[held]]
    expected = skfem.solve(*skfem.condense(stiffness, load, x=prescribed, D=np.flatnonzero(held)))
    assert np.abs(u[component, node] - expected).max() < 1e-11 * np.abs(expected).max()
    rest = stiffness @ expected - load
    total = np.array([rest[held & (component == k)].sum() for k in range(3)])
    assert np.abs(reaction - total).max() < 1e-9 * np.abs(total).max()


def test_extruded_meshes_have_the_volumes_of_their_bodies() -> None:
    x, y = np.linspace(-0.045, 0.045, 16), np.linspace(6e-3, 21.6e-3, 6)
    assert volume(block_mesh(x, y, 0.05)) == pytest.approx(0.09 * 15.6e-3 * 0.05, rel=1e-12)
    shoe, rail = PoleShoe(height=28.2e-3), Profile.standard("60E1")
    fine = np.linspace(6e-3, 36e-3, 20001)
    section = np.trapezoid(28.2e-3 - shoe.sole(fine), fine)
    for side in ("left", "right"):
        mesh = shoe_mesh(shoe, x, y, side=side)
        # corners lie on the true sole, their chords below it
        assert volume(mesh) == pytest.approx(0.09 * section, rel=2e-4)
        strip = mesh.nodes[mesh.node_sets["contact"]]
        assert np.abs(strip[:, 2] - rail.height(strip[:, 1])).max() < 1e-15
        assert np.abs(strip[:, 1]).min() == pytest.approx(6e-3)
        assert np.abs(strip[:, 1]).max() == pytest.approx(21.6e-3)
        mesh.checked()
    half = rail_mesh(rail, x, y, 0.18, half=True)
    whole = rail_mesh(rail, x, y, 0.18)
    assert volume(whole) == pytest.approx(2.0 * volume(half), rel=1e-12)
    # head by its profile, then flank, lower head, web and foot
    ys = np.linspace(0.0, 36e-3, 20001)
    head = np.trapezoid(rail.height(ys), ys)
    y_out = np.array([36.0, 37.33, 8.25, 8.25, 75.0, 75.0, 0.0, 0.0, 36.0]) * 1e-3
    z_out = np.array([0.0, -40.425, -51.0, -142.0, -160.5, -172.0, -172.0, 0.0, 0.0]) * 1e-3
    z_out[0] = rail.height(36e-3)
    outline = np.stack([y_out, z_out], axis=1)
    a, b = outline, np.roll(outline, -1, axis=0)
    area = abs(0.5 * np.sum(a[:, 0] * b[:, 1] - b[:, 0] * a[:, 1])) + head
    assert volume(half) == pytest.approx(0.18 * area, rel=5e-3)
    top = whole.nodes[whole.node_sets["head"]]
    assert np.abs(top[:, 2] - rail.height(top[:, 1])).max() < 1e-15
    half.checked()
    whole.checked()


def foot(body: mtb.ElasticBody, cells: float = 4e-3) -> tuple[object, object]:
    grid = BlockOnPlane(0.048, 0.032, 0.028).grid((cells, cells))
    sampling = body.sample(grid.nodes, grid.node_patches, upper=True)
    return grid, sampling


def test_a_surface_filled_by_gmsh_deforms_as_the_extruded_block() -> None:
    gmsh_body = mtb.ElasticBody.from_mesh(
        trimesh.creation.box((48.0, 32.0, 28.0)).apply_translation((0.0, 0.0, 14.0)),
        STEEL,
        unit="mm",
        contact="bottom",
        supports=[mtb.Support("top", x=0, y=0, z=0)],
        size=4e-3,
    )
    x, y = np.linspace(-0.024, 0.024, 13), np.linspace(-0.016, 0.016, 9)
    block = mtb.ElasticBody(block_mesh(x, y, 0.028), STEEL, supports=[mtb.Support("top", x=0, y=0, z=0)])
    fields = []
    for body in (gmsh_body, block):
        _, sampling = foot(body)
        assert sampling.weights.sum() == pytest.approx(0.048 * 0.032, rel=1e-12)  # type: ignore[attr-defined]
        condensed = body.condense(sampling, keep=False)
        traction = np.zeros((3, sampling.n_points))  # type: ignore[attr-defined]
        traction[2] = 1e6
        traction[0] = 0.3e6
        fields.append(condensed.compliance.displacement(traction))
    scale = np.abs(fields[1]).max()
    assert np.sqrt(np.mean((fields[0] - fields[1]) ** 2)) < 0.005 * scale
    # the same mesh every time: results can be kept
    again = mtb.ElasticBody.from_mesh(
        trimesh.creation.box((48.0, 32.0, 28.0)).apply_translation((0.0, 0.0, 14.0)),
        STEEL,
        unit="mm",
        size=4e-3,
    )
    assert np.array_equal(again.mesh.nodes, gmsh_body.mesh.nodes)


def test_a_worn_sole_from_a_surface_keeps_its_edge() -> None:
    shoe = PoleShoe(height=28.2e-3, length=0.06, poles=1)
    extruded = shoe_mesh(shoe, np.linspace(-0.03, 0.03, 31), np.linspace(6e-3, 21.6e-3, 13), quadratic=False)
    surface = trimesh.Trimesh(extruded.nodes, extruded.checked().faces())
    body = mtb.ElasticBody.from_mesh(
        surface,
        STEEL,
        contact=lambda p: (p[2] < shoe.sole(p[1]) + 2e-5) & (p[1] < 21.6e-3 + 1e-9),
        supports=[mtb.Support("top", x=0, y=0)],
        size=3e-3,
    )
    grid = shoe.grid(3e-3)
    sampling = body.sample(grid.nodes, grid.node_patches, upper=True)
    # the kink at the end of the strip is an edge of the new mesh: no part of the strip is lost
    assert sampling.weights.sum() == pytest.approx(grid.area.sum(), rel=1e-9)
    assert body.condense(sampling, keep=False).mode_names[0] == "translation along z"


def test_contact_can_hold_what_a_driven_top_leaves_free() -> None:
    x, y = np.linspace(-0.024, 0.024, 7), np.linspace(-0.016, 0.016, 5)
    body = mtb.ElasticBody(block_mesh(x, y, 0.028), STEEL, supports=[mtb.Support("top", x=5e-6, y=0)])
    _, sampling = foot(body, 8e-3)
    condensed = body.condense(sampling, keep=False)
    assert condensed.mode_names == ("translation along z", "rotation about x", "rotation about y")
    # a uniform pressure against an equal pull: nothing moves but the drive
    pressure = np.zeros((3, sampling.n_points))  # type: ignore[attr-defined]
    pressure[2] = 1e6
    work = np.einsum("mcn,cn,n->m", condensed.mode_displacement, pressure, condensed.weights)
    assert work[0] == pytest.approx(1e6 * 0.048 * 0.032)
    assert np.abs(work[1:]).max() < 1e-9
    # the drive alone, whatever the pins: a rigid motion the modes can undo
    given = body.given_displacement(condensed)
    flat = condensed.mode_displacement.reshape(3, -1)
    shift = np.zeros_like(given)
    shift[0] = 5e-6
    rest = (given - shift).ravel()
    rest = rest - flat.T @ np.linalg.lstsq(flat.T, rest, rcond=None)[0]
    assert np.abs(rest).max() < 1e-12 * 5e-6 + 1e-18


def test_guided_points_share_one_displacement() -> None:
    x, y = np.linspace(-0.024, 0.024, 7), np.linspace(-0.016, 0.016, 5)
    points = [(0.0, v, 0.028) for v in np.linspace(-0.016, 0.016, 5)]
    body = mtb.ElasticBody(
        block_mesh(x, y, 0.028),
        STEEL,
        supports=[
            mtb.Support(points, y=0, z=mtb.Guide(force=-50.0), name="hanger"),
            mtb.Support("rear", x=0, name="back"),
        ],
    )
    _, sampling = foot(body, 8e-3)
    condensed = body.condense(sampling, keep=False)
    assert condensed.mode_names == ("translation along z",)
    work = body.given_work(condensed)
    assert work == pytest.approx([-50.0])
    # pressure that balances the force on the guide
    traction = np.zeros((3, sampling.n_points))  # type: ignore[attr-defined]
    traction[2] = 50.0 / (0.048 * 0.032)
    state = body.recover(sampling, condensed.modes, traction, np.array([2e-6]))
    hanging = state.displacement[2, body.support_nodes(0)]
    assert np.ptp(hanging) < 1e-18
    assert state.reactions["1 hanger"][2] == pytest.approx(-50.0, rel=1e-9)
    assert state.left_over < 1e-8 * 50.0
