"""Solids of CAD files: their shape, their own unit, and what cannot be read."""

from pathlib import Path

import numpy as np
import pytest

import mtb_rs as mtb
from mtb_rs.mesh_files import read_solid

gmsh = pytest.importorskip("gmsh", exc_type=ImportError)

HOLE, LENGTH, WIDTH, HEIGHT = 8.0, 100.0, 50.0, 40.0  # mm


def written(path: Path, solids: int = 1) -> Path:
    """A block in millimetres with a hole across, and spheres beside it."""
    gmsh.initialize(interruptible=False)
    try:
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
    finally:
        gmsh.finalize()
    return path


def body(path: Path, **options: object) -> mtb.ElasticBody:
    guide = mtb.Support("top", x=0.0, y=0.0, z=mtb.Guide(-20e3))
    return mtb.ElasticBody.from_mesh(path, mtb.steel, supports=[guide], **options)


def test_a_solid_has_its_shape_in_metres(tmp_path: Path) -> None:
    surface = read_solid(written(tmp_path / "block.step"), 6e-3)
    exact = 1e-9 * WIDTH * (LENGTH * HEIGHT - np.pi * HOLE**2)
    # the hole is a polygon of 90 sides at least
    polygon = 1e-9 * WIDTH * (LENGTH * HEIGHT - 45.0 * HOLE**2 * np.sin(np.pi / 45.0))
    assert exact < surface.volume <= polygon * (1.0 + 1e-9)
    block = body(tmp_path / "block.step", size=6e-3)
    np.testing.assert_allclose(block.mesh.nodes.min(axis=0), [-0.05, -0.025, 0.0], atol=1e-9)
    np.testing.assert_allclose(block.mesh.nodes.max(axis=0), [0.05, 0.025, 0.04], atol=1e-9)


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
    with pytest.raises(ValueError, match=r'unit is \'mm\': \.step files tell their own, "m" is needed'):
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
