# SPDX-License-Identifier: MIT OR Apache-2.0
"""Solids of CAD files: their shape, their own unit, and what cannot be read."""

from pathlib import Path

import numpy as np
import pytest

import mtb_rs as mtb
from mtb_rs.bodies.mesh import block_mesh
from mtb_rs.bodies.mesh_files import straightened
from mtb_rs.bodies.mesher import gmsh_beside

pytest.importorskip("gmsh", exc_type=ImportError)

skfem = pytest.importorskip("skfem")

HOLE, LENGTH, WIDTH, HEIGHT = 8.0, 100.0, 50.0, 40.0  # mm


def written(path: Path, solids: int = 1) -> Path:
    """A block in millimetres with a hole across, and spheres beside it."""
    # gmsh in this process would set SIGPIPE to its default
    with gmsh_beside() as gmsh:
        gmsh.option.setNumber("General.Terminal", 0)
        # a unit outlives its session
        gmsh.option.setString("Geometry.OCCTargetUnit", "MM")
        block = gmsh.model.occ.addBox(-LENGTH / 2, -WIDTH / 2, 0, LENGTH, WIDTH, HEIGHT)
        hole = gmsh.model.occ.addCylinder(0, -WIDTH, 25, 0, 2 * WIDTH, 0, HOLE)
        gmsh.model.occ.cut([(3, block)], [(3, hole)])
        for k in range(1, solids):
            gmsh.model.occ.addSphere(200.0 * k, 0, 0, 10)
        gmsh.model.occ.synchronize()
        gmsh.write(str(path))
    return path


def body(path: Path, **options: object) -> mtb.ElasticBody:
    guide = mtb.Support("top", x=0.0, y=0.0, z=mtb.Guide(-20e3))
    return mtb.ElasticBody.from_mesh(path, mtb.steel, supports=[guide], **options)


def test_a_solid_has_its_shape_in_metres(tmp_path: Path) -> None:
    block = body(written(tmp_path / "block.step"), size=6e-3)
    exact = 1e-9 * WIDTH * (LENGTH * HEIGHT - np.pi * HOLE**2)
    # scikit-fem numbers the nodes of a quadratic tetrahedron alike
    mesh = skfem.MeshTet2(*(np.ascontiguousarray(part.T) for part in (block.mesh.nodes, block.mesh.cells)))
    volume = skfem.Basis(mesh, skfem.ElementTetP0(), intorder=4).dx.sum()
    # flat facets of the same size would leave 3 % of the hole, 1e-3 of the whole
    assert volume == pytest.approx(exact, rel=2e-5)
    np.testing.assert_allclose(block.mesh.nodes.min(axis=0), [-0.05, -0.025, 0.0], atol=1e-9)
    np.testing.assert_allclose(block.mesh.nodes.max(axis=0), [0.05, 0.025, 0.04], atol=1e-9)
    faces = block.mesh.nodes[block.faces.astype(np.int64)]
    radius = np.hypot(faces[..., 0], faces[..., 2] - 0.025)
    in_hole = (radius[:, :3] < 1e-3 * HOLE + 1e-9).all(axis=1)
    assert in_hole.sum() > 50
    # corners and middles of edges lie on the cylinder
    np.testing.assert_allclose(radius[in_hole], 1e-3 * HOLE, rtol=1e-9)


def test_edges_that_turn_an_element_inside_out_are_straightened() -> None:
    mesh = block_mesh([0.0, 1.0, 2.0], [0.0, 1.0], 1.0)
    bent = mesh.nodes.copy()
    middle = mesh.cells[0, 4]
    bent[middle] += 0.6 * (mesh.nodes[mesh.cells[0, 2]] - mesh.nodes[middle])
    broken = mtb.TetraMesh(bent, mesh.cells)
    with pytest.raises(ValueError, match=r"inside out|inverted|volume"):
        broken.checked()
    mended = straightened(broken)
    mended.checked()
    np.testing.assert_allclose(mended.nodes, mesh.nodes, atol=1e-12)
    # and edges that do no harm stay as they are
    bent[middle] = mesh.nodes[middle] + 0.05
    np.testing.assert_array_equal(straightened(mtb.TetraMesh(bent, mesh.cells)).nodes, bent)


def test_a_solid_presses_a_half_space(tmp_path: Path) -> None:
    block = body(written(tmp_path / "block.stp"), size=6e-3)
    result = mtb.Scene(block, mtb.HalfSpace(mtb.steel), spacing=8e-3, friction=0.3).solve()
    assert result.area.sum() == pytest.approx(1e-6 * LENGTH * WIDTH, rel=1e-9)
    assert result.normal_force == pytest.approx(20e3, rel=1e-9)
    assert result.report.force_balance["relative_error"] < 1e-9


def test_what_cannot_be_read_is_named(tmp_path: Path) -> None:
    two = written(tmp_path / "two.step", solids=3)
    with pytest.raises(ValueError, match=r"two\.step holds 3 solids: one is needed"):
        body(two)
    with pytest.raises(
        ValueError, match=r'unit is \'in\': \.step files tell their own, "m" is needed, .* mm'
    ):
        body(two, unit="in")
    with pytest.raises(ValueError, match=r"two\.step holds 3 solids"):  # what it tells itself may be said
        body(two, unit="mm")
    with pytest.raises(ValueError, match="size is -1"):
        body(two, size=-1.0)
    with pytest.raises(ValueError, match=r"size is 1e-05 m: the solid, .* would have 6e\+08 triangles"):
        body(written(tmp_path / "one.step"), size=1e-5)
    torn = tmp_path / "torn.step"
    torn.write_bytes(two.read_bytes()[:900])
    with pytest.raises(ValueError, match=r"torn\.step (cannot be read|holds 0 solids)"):
        body(torn)
    (tmp_path / "text.stp").write_text("no CAD\n")
    with pytest.raises(ValueError, match=r"text\.stp (cannot be read|holds 0 solids)"):
        body(tmp_path / "text.stp")
