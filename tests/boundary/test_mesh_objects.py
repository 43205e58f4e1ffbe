# SPDX-License-Identifier: MIT OR Apache-2.0
"""Meshes of trimesh, meshio and pyvista are taken wherever a mesh is, and results are datasets of pyvista."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh

import mtb_rs as mtb
from mtb_rs.bodies.mesh import block_mesh
from mtb_rs.bodies.mesh_objects import as_trimesh

meshio = pytest.importorskip("meshio", reason="meshio (extra mesh) is not installed")
pyvista = pytest.importorskip("pyvista", reason="pyvista (extra viz) is not installed")

LINE = np.linspace(-0.01, 0.01, 4)
#: A block of 20 x 20 x 10 mm on z = 0, of 4-node and of 10-node tetrahedra.
CURVED = block_mesh(LINE, LINE, 0.01)
CORNERS, CELLS = np.unique(CURVED.cells[:, :4], return_inverse=True)
LINEAR = mtb.TetraMesh(CURVED.nodes[CORNERS], CELLS.reshape(-1, 4))
BOUNDS = (-0.01, 0.01, -0.01, 0.01, 0.0, 0.01)


def grid(mesh: mtb.TetraMesh, **cells: Any) -> Any:
    kind = pyvista.CellType.QUADRATIC_TETRA if mesh.is_quadratic else pyvista.CellType.TETRA
    return pyvista.UnstructuredGrid({kind: mesh.cells, **cells}, np.asarray(mesh.nodes))


def rolled() -> Any:
    """A box as a surface of meshio, its quadrilaterals with mid-side nodes."""
    box = pyvista.Box(BOUNDS).clean()
    quads = box.regular_faces
    corners = np.asarray(box.points)
    ends = np.stack([quads, np.roll(quads, -1, axis=1)], axis=-1).reshape(-1, 2)
    points = np.concatenate([corners, corners[ends].mean(axis=1)])
    middles = len(corners) + np.arange(len(ends)).reshape(-1, 4)
    return meshio.Mesh(points, [("quad8", np.concatenate([quads, middles], axis=1))])


#: The same block, as every library may hold it.
SURFACES: dict[str, Callable[[], Any]] = {
    "trimesh": lambda: as_trimesh(LINEAR),
    "pyvista of quadrilaterals": lambda: pyvista.Box(BOUNDS),
    "pyvista of triangles": lambda: pyvista.Box(BOUNDS).triangulate(),
    "pyvista grid of points": lambda: pyvista.ImageData(
        dimensions=(3, 3, 3), spacing=(0.01, 0.01, 0.005), origin=(-0.01, -0.01, 0.0)
    ),
    "pyvista surface in a grid": lambda: pyvista.Box(BOUNDS).cast_to_unstructured_grid(),
    "meshio of triangles": lambda: meshio.Mesh(
        pyvista.Box(BOUNDS).points, [("triangle", pyvista.Box(BOUNDS).triangulate().regular_faces)]
    ),
    "meshio of quadrilaterals": lambda: meshio.Mesh(
        pyvista.Box(BOUNDS).points, [("quad", pyvista.Box(BOUNDS).regular_faces)]
    ),
    "meshio of curved quadrilaterals": rolled,
}
SOLIDS: dict[str, Callable[[], Any]] = {
    "TetraMesh": lambda: LINEAR,
    "TetraMesh, quadratic": lambda: CURVED,
    "meshio": lambda: meshio.Mesh(LINEAR.nodes, [("tetra", LINEAR.cells)]),
    "meshio, quadratic": lambda: meshio.Mesh(CURVED.nodes, [("tetra10", CURVED.cells)]),
    "pyvista": lambda: grid(LINEAR),
    "pyvista, quadratic": lambda: grid(CURVED),
    "pyvista, with its surface": lambda: grid(LINEAR, **{}).merge(
        pyvista.Box(BOUNDS).triangulate().cast_to_unstructured_grid()
    ),
}


@pytest.mark.parametrize("kind", [*SURFACES, *SOLIDS])
def test_every_mesh_is_a_surface_of_a_body(kind: str) -> None:
    given = (SURFACES | SOLIDS)[kind]()
    for body in (mtb.Rigid(given), mtb.HalfSpace(mtb.steel, given)):
        surface = body.surface
        assert isinstance(surface, mtb.BodySurface)
        place = np.array([[0.0, 4e-3, 0.02], [0.0, -7e-3, 0.0]])
        np.testing.assert_allclose(surface.top(*place), [0.01, 0.01, np.nan], atol=1e-9)
        np.testing.assert_allclose(surface.bottom(*place), [0.0, 0.0, np.nan], atol=1e-9)
    apex = mtb.BodySurface.paraboloid(0.1)
    found = mtb.surface_gap(apex, given, (-2e-3, 2e-3), (-2e-3, 2e-3), 1e-3)
    ball = mtb.surface_gap(apex, mtb.Rigid(as_trimesh(LINEAR)).surface, (-2e-3, 2e-3), (-2e-3, 2e-3), 1e-3)
    np.testing.assert_allclose(found.grid.gap, ball.grid.gap, atol=1e-9)


@pytest.mark.parametrize("kind", SOLIDS)
def test_every_solid_is_an_elastic_body(kind: str) -> None:
    body = mtb.ElasticBody.from_mesh(SOLIDS[kind](), mtb.steel, contact="bottom")
    nodes = np.asarray(body.mesh.nodes)
    assert len(nodes) == len(CURVED.nodes)
    np.testing.assert_allclose(np.ptp(nodes, axis=0), [0.02, 0.02, 0.01])


@pytest.mark.parametrize("kind", ["pyvista of quadrilaterals", "meshio of curved quadrilaterals"])
def test_a_surface_of_any_library_is_filled(kind: str) -> None:
    pytest.importorskip("gmsh", reason="gmsh (extra mesh) is not installed", exc_type=ImportError)
    body = mtb.ElasticBody.from_mesh(SURFACES[kind](), mtb.steel, contact="bottom", size=5e-3)
    np.testing.assert_allclose(np.ptp(body.mesh.nodes, axis=0), [0.02, 0.02, 0.01], atol=1e-9)
    assert body.resized(4e-3).size == 4e-3


def test_a_file_of_a_surface_that_meshio_reads_is_filled(tmp_path: Path) -> None:
    pytest.importorskip("gmsh", reason="gmsh (extra mesh) is not installed", exc_type=ImportError)
    SURFACES["meshio of triangles"]().write(tmp_path / "shell.vtk")
    body = mtb.ElasticBody.from_mesh(tmp_path / "shell.vtk", mtb.steel, contact="bottom", size=5e-3)
    np.testing.assert_allclose(np.ptp(body.mesh.nodes, axis=0), [0.02, 0.02, 0.01], atol=1e-9)


def test_a_solid_of_other_cells_beside_tetrahedra_is_refused() -> None:
    brick = pyvista.ImageData(dimensions=(2, 2, 2), spacing=(0.01,) * 3).cast_to_unstructured_grid()
    for mixed in (
        grid(LINEAR).merge(brick, merge_points=False),
        meshio.Mesh(LINEAR.nodes, [("tetra", LINEAR.cells), ("hexahedron", [list(range(8))])]),
    ):
        with pytest.raises(ValueError, match=r"the mesh has cells (hexahedron, tetra|tetra, voxel): either"):
            mtb.ElasticBody.from_mesh(mixed, mtb.steel)


def test_polygons_of_any_number_of_corners_are_a_surface() -> None:
    roller = pyvista.Cylinder(
        center=(0, 0, 0.05), direction=(0, 1, 0), radius=0.05, height=0.1, resolution=360
    )
    assert mtb.Rigid(roller).surface.bottom(0.0, 0.0) == pytest.approx(0.0, abs=1e-5)


def test_an_open_patch_is_a_surface() -> None:
    patch = pyvista.Plane(center=(0.0, 0.0, 0.002), i_size=0.02, j_size=0.02)
    assert mtb.Rigid(patch).surface.top(1e-3, 2e-3) == pytest.approx(0.002)


@pytest.mark.parametrize(
    "empty", [pyvista.PolyData(), pyvista.UnstructuredGrid(), pyvista.PolyData([[0.0, 0.0, 0.0]])]
)
def test_a_mesh_without_faces_is_refused(empty: Any) -> None:
    with pytest.raises(ValueError, match=r"surface is .*mesh of trimesh, meshio or pyvista"):
        mtb.Rigid(empty)
    with pytest.raises(ValueError, match="tetrahedra, or a closed surface, are needed"):
        mtb.ElasticBody.from_mesh(empty, mtb.steel)


def test_a_mesh_alone_has_no_material() -> None:
    with pytest.raises(ValueError, match="a surface alone has no material"):
        mtb.Scene(lower=pyvista.Box(BOUNDS), upper=mtb.steel, force=1.0)
    with pytest.raises(ValueError, match="lower is 3: a BodySurface, or a mesh"):
        mtb.surface_gap(3, mtb.BodySurface.plane(), (0.0, 1.0), (0.0, 1.0), 0.1)


@pytest.mark.coarse
def test_a_result_is_datasets_of_pyvista(tmp_path: Path) -> None:
    result = mtb.scenes.block_on_plane(spacing=0.02, friction=0.1).solve("elastic-upper")
    found = result.to_pyvista()
    contact = found["contact"]
    np.testing.assert_array_equal(contact.cell_data["pressure"], result.pressure.ravel())
    np.testing.assert_array_equal(contact.cell_data["traction"], result.traction.reshape(3, -1).T)
    areas = contact.compute_cell_sizes().cell_data["Area"]
    assert areas @ contact.cell_data["pressure"] == pytest.approx(result.normal_force)
    assert (
        contact.user_dict["units"]["dissipation" if "dissipation" in contact.cell_data else "pressure"]
        == "Pa"
    )
    assert set(contact.user_dict["units"]) == set(result.fields()) - {"points", "status"}
    (solid,) = result.solids()
    block = found[solid.name]
    np.testing.assert_array_equal(block.point_data["displacement"], solid.displacement.T)
    assert block.user_dict["units"]["von_mises"] == "Pa"
    assert contact.active_scalars_name == "pressure"
    assert block.active_scalars_name == "von_mises"
    # units outlive a file
    contact.save(tmp_path / "contact.vtp")
    assert pyvista.read(tmp_path / "contact.vtp").user_dict["units"]["pressure"] == "Pa"


def test_every_kind_of_result_is_datasets() -> None:
    x = np.linspace(-1.0, 1.0, 12)
    inside = np.maximum(0.0, 1.0 - x[None] ** 2 - x[:, None] ** 2)
    field = mtb.PressureField(1e8 * np.sqrt(inside), (1e-4, 1e-4), mtb.steel, mtb.steel)
    rolled = mtb.fastsim(field, (1e-3, 0.0, 0.0), mtb.Coulomb(0.3))
    contact = mtb.scenes.paraboloid_on_plane(points=8).prepare("half-space")
    assert isinstance(contact, mtb.PreparedContact)
    wheels = mtb.scenes.wheel_on_rail(spacing=1e-3).prepare()
    assert isinstance(wheels, mtb.PreparedWheels)
    patch = wheels.step(velocity=(20.0, 0.0, 0.0, 0.0, 20.0 / 0.46, 0.0)).patches[0]
    for result in (rolled, contact.step(), patch):
        block = result.to_pyvista()["contact"]
        np.testing.assert_array_equal(block.cell_data["pressure"], np.ravel(result.pressure))


def test_meshes_without_a_surface_are_named_by_their_cells() -> None:
    corners = np.array([[x, y, z] for z in (0, 1) for y in (0, 1) for x in (0, 1)], dtype=float)
    bricks = meshio.Mesh(corners, [("hexahedron", np.array([[0, 1, 3, 2, 4, 5, 7, 6]]))])
    for refused in (
        lambda: mtb.HalfSpace(mtb.steel, bricks),
        lambda: mtb.Rigid(bricks),
        lambda: mtb.surface_gap(bricks, bricks, 0.5, 0.5, 0.1),
    ):
        with pytest.raises(ValueError, match=r"is a mesh of hexahedron: .* triangles, .* is needed"):
            refused()
    for mesh in (bricks, trimesh.creation.box()):
        with pytest.raises(ValueError, match=r"a TetraMesh is needed; ElasticBody.from_mesh takes meshes"):
            mtb.ElasticBody(mesh, mtb.steel)
