# SPDX-License-Identifier: MIT OR Apache-2.0
"""Elastic bodies at the door: bad meshes, supports and contacts are named; condensations are kept safely."""

from __future__ import annotations

import subprocess
import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

import meshio
import numpy as np
import pytest
import trimesh

import mtb_rs as mtb
from mtb_rs.base import cache
from mtb_rs.bodies.elastic_body import Condensed
from mtb_rs.bodies.mesh import block_mesh
from mtb_rs.bodies.mesh_files import _expected
from mtb_rs.geometry.geometries import BlockOnPlane

STEEL = mtb.steel
TOP = mtb.Support("top", x=0, y=0, z=0)


PIPES = """
import os, threading, trimesh, mtb_rs as mtb
box = trimesh.creation.box((0.04, 0.02, 0.02))
def mesh():
    mtb.ElasticBody.from_mesh(box, mtb.steel, supports=[mtb.Support("top", x=0, y=0, z=0)])
mesh()
thread = threading.Thread(target=mesh)
thread.start()
thread.join()
read, write = os.pipe()
os.close(read)
try:
    os.write(write, b"x")
except BrokenPipeError:
    print("alive")
"""


def test_meshing_leaves_broken_pipes_to_python() -> None:
    # gmsh sets SIGPIPE to its default: the process would end without a word
    run = subprocess.run([sys.executable, "-c", PIPES], capture_output=True, text=True, timeout=300)
    assert (run.returncode, run.stdout.strip()) == (0, "alive"), run.stderr


def small_mesh() -> mtb.TetraMesh:
    return block_mesh(np.linspace(-0.02, 0.02, 5), np.linspace(-0.01, 0.01, 3), 0.02)


def condensed(body: mtb.ElasticBody, **options: object) -> Condensed:
    grid = BlockOnPlane(0.04, 0.02, 0.02).grid((10e-3, 10e-3))
    sampling = body.sample(grid.nodes, grid.node_patches, upper=True)
    return body.condense(sampling, **options)  # type: ignore[arg-type]


def refused(*message: str) -> pytest.RaisesExc[ValueError]:
    return pytest.raises(ValueError, match=".*".join(message))


def test_bad_meshes_are_named() -> None:
    mesh = small_mesh()
    cells = mesh.cells.copy()
    cells[3, [0, 1]] = cells[3, [1, 0]]
    with refused("tetrahedron 3 is inverted"):
        mtb.ElasticBody(mtb.TetraMesh(mesh.nodes, cells, mesh.node_sets), STEEL)
    nodes = mesh.nodes * [1.0, 1.0, 1e-6]
    with refused("tetrahedron 0 is a sliver", "quality"):
        mtb.ElasticBody(mtb.TetraMesh(nodes, mesh.cells, mesh.node_sets), STEEL)
    with refused("node 0 of the mesh is .*: finite numbers are needed"):
        mtb.ElasticBody(
            mtb.TetraMesh(mesh.nodes * np.nan, mesh.cells, mesh.node_sets), STEEL, contact="bottom"
        )
    with refused("cells have 5 nodes"):
        mtb.ElasticBody(mtb.TetraMesh(mesh.nodes, mesh.cells[:, :5], mesh.node_sets), STEEL)
    with refused("cells contain the node number -1"):
        mtb.ElasticBody(mtb.TetraMesh(mesh.nodes, mesh.cells - 1, mesh.node_sets), STEEL)
    twice = mtb.TetraMesh(
        np.concatenate([mesh.nodes, mesh.nodes + 1.0]),
        np.concatenate([mesh.cells, mesh.cells + len(mesh.nodes)]),
    )
    with refused("2 separate pieces: one connected piece is needed"):
        mtb.ElasticBody(twice, STEEL, contact="bottom")
    with refused("Poisson's ratio is 0.5"):
        mtb.ElasticBody(mesh, mtb.Material(1e9, 0.5))


def test_bad_surfaces_are_named(tmp_path: Path) -> None:
    box = trimesh.creation.box((0.04, 0.02, 0.02))
    open_box = trimesh.Trimesh(box.vertices, box.faces[1:])
    with refused("not closed: 3 edges", "first near"):
        mtb.ElasticBody.from_mesh(open_box, STEEL)
    thin = np.concatenate([box.faces, [[0, 0, 1]]])
    with refused("triangle", "degenerate"):
        mtb.ElasticBody.from_mesh(trimesh.Trimesh(box.vertices, thin, process=False), STEEL)
    beside = trimesh.util.concatenate([box, box.copy().apply_translation((0.1, 0.0, 0.0))])
    with refused(
        "2 separate pieces", r"\[0.0, 0.0, 0.0\] and \[0.1, 0.0, 0.0\] m: one connected piece is needed"
    ):
        mtb.ElasticBody.from_mesh(beside, STEEL)
    with refused("size is 1 m", "0.04"):
        mtb.ElasticBody.from_mesh(box, STEEL, size=1.0)
    with refused("unit is 'ft'", "'mm'"):
        mtb.ElasticBody.from_mesh(box, STEEL, unit="ft")
    with refused("is not there"):
        mtb.ElasticBody.from_mesh(tmp_path / "nothing.stl", STEEL)
    with refused("is no mesh"):
        mtb.ElasticBody.from_mesh(3.0, STEEL)
    with refused("no corner of a triangle of the surface lies in the place given as contact"):
        mtb.ElasticBody.from_mesh(box, STEEL, contact=lambda x: x[2] > 1.0)
    path = tmp_path / "wires.vtk"
    meshio.Mesh(box.vertices, [("line", box.edges)]).write(path)
    with refused("the mesh has cells line"):
        mtb.ElasticBody.from_mesh(path, STEEL)


def test_supports_and_contacts_are_named() -> None:
    mesh = small_mesh()
    with refused("leave the body free to move", "translation along x, translation along y, rotation about z"):
        condensed(mtb.ElasticBody(mesh, STEEL), keep=False)
    with refused("contact of body: 'sole' is unknown", "'contact', 'top'"):
        mtb.ElasticBody(mesh, STEEL, contact="sole")
    with refused("contact of body, .*, contains no node"):
        mtb.ElasticBody(mesh, STEEL, contact=lambda x: x[2] < -1.0)
    with refused("no triangle of the surface has all its corners"):
        mtb.ElasticBody(mesh, STEEL, contact=((-1e-3, 1e-3), (-1e-3, 1e-3), (0.005, 0.015)))
    with refused("the function returns float64"):
        mtb.ElasticBody(mesh, STEEL, contact=lambda x: x[2])
    with refused("support 'points' of body", "m away from the nearest node"):
        mtb.ElasticBody(mesh, STEEL, supports=[mtb.Support([(1.0, 0.0, 0.0)], x=0)])
    with refused("x of a support is nan"):
        mtb.Support("top", x=float("nan"))
    with refused('supports "top" and "front" both hold z of node'):
        mtb.ElasticBody(mesh, STEEL, supports=[TOP, mtb.Support("front", z=mtb.Guide())])
    with refused("gives x = 1e-06 m at node", "another support gives 0 m there"):
        mtb.ElasticBody(mesh, STEEL, supports=[TOP, mtb.Support("front", x=1e-6)])
    with refused("a box runs from y = 0.01 to -0.01 m: the lower end comes first"):
        mtb.Support(((0.0, 0.02), (0.01, -0.01), (None, None)), x=0)
    with refused("supports contain 'top'"):
        mtb.ElasticBody(mesh, STEEL, supports=["top"])  # type: ignore[list-item]
    with refused("the supports hold every node"):
        mtb.ElasticBody(mesh, STEEL, supports=[mtb.Support(lambda x: x[2] > -1.0, x=0, y=0, z=0)])
    beside = BlockOnPlane(0.08, 0.02, 0.02).grid((10e-3, 10e-3))
    body = mtb.ElasticBody(mesh, STEEL, supports=[TOP])
    sampling = body.sample(beside.nodes, beside.node_patches, upper=True)
    with refused("contact point 0 lies beside the contact face", "lay the point on the face"):
        body.condense(sampling, keep=False)
    for supports in (TOP, None, "top", 3):
        with refused("supports is", "a list of Support objects is needed"):
            mtb.ElasticBody(mesh, STEEL, supports=supports)  # type: ignore[arg-type]
    for name in (None, 3, ""):
        with refused("name is", "a word is needed"):
            mtb.ElasticBody(mesh, STEEL, supports=[TOP], name=name)  # type: ignore[arg-type]
    with refused("name of a support is 3"):
        mtb.Support("top", x=0, name=3)  # type: ignore[arg-type]
    with refused("supports is None: one of 'driven-top', 'clamped-top', 'points', 'fixed-points'"):
        mtb.scenes.block_on_plane(supports=None)  # type: ignore[arg-type]
    with refused("upper is 'steel': a Material, HalfSpace, Layered, Rigid or ElasticBody"):
        mtb.Scene("steel", STEEL, gap=np.zeros((4, 4)), force=1.0)  # type: ignore[arg-type]


def test_places_are_functions_of_points_component_first() -> None:
    mesh = small_mesh()
    now = mtb.ElasticBody(mesh, STEEL, contact=lambda p: p[2] < 1e-9)
    with pytest.warns(
        DeprecationWarning, match=r"\(n, 3\). That is deprecated: points are now given as \(3, n\)"
    ):
        before = mtb.ElasticBody(mesh, STEEL, contact=lambda p: p[:, 2] < 1e-9)
    np.testing.assert_array_equal(now.contact_faces, before.contact_faces)
    # where a function takes both, points are component first
    asked = []

    def low(points: np.ndarray) -> np.ndarray:
        asked.append(points.shape)
        return points.T[:, 2] < 1e-9

    np.testing.assert_array_equal(mtb.ElasticBody(mesh, STEEL, contact=low).contact_faces, now.contact_faces)
    assert {shape[0] for shape in asked} == {3}


def test_sizes_that_no_mesh_can_have_are_named() -> None:
    scene = mtb.scenes.pole_shoe_on_rail(poles=1, spacing=6e-3)
    with refused("element_size is 1 m: the contact measures 0.09", "smaller elements are needed"):
        replace(scene, element_size=1.0).solve("elastic-upper")
    unusual = pytest.warns(UserWarning, match="height is 1e-09 m: 0.001 to 0.5 m is usual")
    with refused("height is 1e-09 m: the left pole cannot be filled", "tetrahedron"), unusual:
        mtb.scenes.pole_shoe_on_rail(height=1e-9, poles=1, spacing=6e-3).solve("elastic-upper")


@pytest.mark.coarse
def test_why_bodies_do_not_touch() -> None:
    def scene(pull: float = 1e6, **held: object) -> mtb.Scene:
        body = mtb.ElasticBody(small_mesh(), STEEL, supports=[mtb.Support("top", x=0, y=0, **held)])  # type: ignore[arg-type]
        return mtb.Scene(body, STEEL, spacing=1e-2, magnetic_pressure=pull)

    with refused("never touch: the attraction by magnetic_pressure is -800 N, it must be positive"):
        scene(-1e6, z=0).solve()
    with refused("never touch: without load they lie on each other", "supports lift them apart"):
        scene(z=1e-3).solve()
    tiny = replace(scene(z=0), sliding_direction=(1e-300, 0.0), friction=0.2).solve()
    assert tiny.force[0] == pytest.approx(0.2 * tiny.normal_force)


def test_a_ragged_border_of_a_box_is_told() -> None:
    whole = mtb.ElasticBody(small_mesh(), STEEL, ((None, None), (None, None), (-1e-6, 1e-6)), [TOP])
    assert whole.contact_faces.size == 4 * 2 * 2
    with pytest.warns(
        UserWarning,
        match="the box given as contact .* covers 0.0004 m2 .* 0.0003 m2, and only whole triangles",
    ):
        mtb.ElasticBody(small_mesh(), STEEL, ((-0.014, None), (-0.002, None), (-1e-6, 1e-6)), [TOP])


def test_millimetres_by_mistake_are_suspected() -> None:
    mesh = small_mesh()
    large = mtb.TetraMesh(mesh.nodes * 1e3, mesh.cells, mesh.node_sets)
    with pytest.warns(UserWarning, match='is 40 m large: is its mesh in millimetres. Then say unit="mm"'):
        mtb.ElasticBody(large, STEEL)
    fine = mtb.ElasticBody.from_mesh(large, STEEL, unit="mm", contact="contact")
    assert np.allclose(fine.mesh.nodes, mesh.nodes)


def test_ready_meshes_come_through_meshio(tmp_path: Path) -> None:
    mesh = small_mesh()
    # a node that belongs to nothing, and cells numbered the wrong way round
    nodes = np.concatenate([mesh.nodes, [[9.0, 9.0, 9.0]]]) * 1e3
    wrong = mesh.cells[:, [1, 0, 2, 3, 4, 6, 5, 8, 7, 9]]
    path = tmp_path / "block.vtu"
    meshio.Mesh(nodes, [("tetra10", wrong)]).write(path)
    body = mtb.ElasticBody.from_mesh(path, STEEL, unit="mm", supports=[TOP])
    expected = condensed(mtb.ElasticBody(mesh, STEEL, supports=[TOP]), keep=False)
    found = condensed(body, keep=False)
    assert np.allclose(
        found.flexibility, expected.flexibility, rtol=1e-9, atol=1e-12 * expected.flexibility.max()
    )


def test_kept_condensations_are_found_and_judged(
    tmp_path: Path, caplog: pytest.LogCaptureFixture, monkeypatch: pytest.MonkeyPatch
) -> None:
    body = mtb.ElasticBody(small_mesh(), STEEL, supports=[TOP])
    monkeypatch.setenv(cache.VARIABLE, str(tmp_path))
    cache.forget()
    first = condensed(body)
    assert first.origin == "built"
    assert condensed(body).origin == "memory"
    cache.forget()
    second = condensed(body)
    assert second.origin == "disk"
    assert np.array_equal(first.flexibility, second.flexibility)
    assert second.cost == first.cost
    (file,) = tmp_path.iterdir()
    # another material, another support: not the same body
    for other in (
        mtb.ElasticBody(body.mesh, mtb.Material(100e9, 0.3), supports=[TOP]),
        mtb.ElasticBody(body.mesh, STEEL, supports=[mtb.Support("top", x=0, y=0)]),
    ):
        assert condensed(other).origin == "built"
    # what is prescribed does not matter
    assert (
        condensed(mtb.ElasticBody(body.mesh, STEEL, supports=[mtb.Support("top", x=1e-6, y=0, z=0)])).origin
        == "memory"
    )
    content = bytearray(file.read_bytes())
    content[-100] ^= 1
    for damage in (bytes(content), bytes(content[: len(content) // 2]), b""):
        file.write_bytes(damage)
        cache.forget()
        caplog.clear()
        assert condensed(body).origin == "built"
        assert "damaged" in caplog.text
    # a sound file under another body's name
    strangers = [f for f in tmp_path.iterdir() if f != file]
    strangers[0].replace(file)
    cache.forget()
    again = condensed(body)
    assert again.origin == "built"
    assert np.array_equal(again.flexibility, first.flexibility)
    # nowhere to write: a warning, not an error
    blocked = tmp_path / "a file"
    blocked.write_text("")
    cache.forget()
    assert condensed(body, directory=blocked / "below").origin == "built"
    monkeypatch.setenv(cache.VARIABLE, "off")
    cache.forget()
    assert condensed(body).origin == "built"


SCRIPT = """
import sys, numpy as np, mtb_rs as mtb
from mtb_rs.base import cache
from mtb_rs.geometry.geometries import BlockOnPlane
from mtb_rs.bodies.mesh import block_mesh
mesh = block_mesh(np.linspace(-0.02, 0.02, 5), np.linspace(-0.01, 0.01, 3), 0.02)
body = mtb.ElasticBody(mesh, mtb.steel, supports=[mtb.Support("top", x=0, y=0, z=0)])
grid = BlockOnPlane(0.04, 0.02, 0.02).grid((10e-3, 10e-3))
sampling = body.sample(grid.nodes, grid.node_patches, upper=True)
for _ in range(20):
    cache.forget()
    print(body.condense(sampling, directory=sys.argv[1]).flexibility.sum())
"""


def test_two_processes_share_a_folder(tmp_path: Path) -> None:
    command = [sys.executable, "-c", SCRIPT, str(tmp_path)]
    runs = [subprocess.Popen(command, stdout=subprocess.PIPE, text=True) for _ in range(2)]
    sums = [float(line) for run in runs for line in run.communicate(timeout=120)[0].split()]
    assert [run.returncode for run in runs] == [0, 0]
    assert len(sums) == 40
    assert np.ptp(sums) <= 1e-12 * abs(sums[0])
    assert len(list(tmp_path.iterdir())) == 1


def test_tetrahedra_that_overlap_are_named() -> None:
    mesh = block_mesh(np.linspace(0.0, 0.1, 3), np.linspace(0.0, 0.1, 3), 0.1, quadratic=False)
    again = np.concatenate([mesh.cells, mesh.cells[5:6]])
    with pytest.raises(ValueError, match=rf"tetrahedra 5 and {len(mesh.cells)} have the same corners"):
        mtb.TetraMesh(mesh.nodes, again).checked()
    # one more tetrahedron on a face that already has two
    corners = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1], [0, 0, -1], [0.1, 0.1, 2]])
    cells = np.array([[0, 1, 2, 3], [0, 2, 1, 4], [0, 1, 2, 5]])
    mtb.TetraMesh(corners[:5], cells[:2]).checked()
    with pytest.raises(ValueError, match=r"tetrahedra 0, 1 and 2 share the face \[0, 1, 2\]"):
        mtb.TetraMesh(corners, cells).checked()


def standing(height: float, z: mtb.Guide | None = None) -> mtb.ElasticBody:
    mesh = block_mesh(np.linspace(-0.015, 0.015, 4), np.linspace(-0.015, 0.015, 4), height)
    return mtb.ElasticBody(mesh, STEEL, supports=[mtb.Support("top", x=0, y=0, z=z)], name="pad")


@pytest.mark.parametrize(
    ("height", "z", "given", "reason"),
    [
        (0.1, None, {"force": 1e4, "friction": 0.8}, r"force -10000 N along z on pad\): without friction"),
        (
            0.02,
            mtb.Guide(2e3),
            {"magnetic_pressure": 1e6},
            r"guide 'top' of pad 2000 .*in all 1100 N pull pad off",
        ),
        (0.02, None, {"force": 1e4, "moments": (0.0, 800.0)}, r"moment \(0, 800, 0\) N m about the.* pad\)$"),
    ],
)
def test_a_load_that_no_contact_carries_is_explained(
    height: float, z: mtb.Guide | None, given: dict[str, Any], reason: str
) -> None:
    scene = mtb.Scene(standing(height, z), STEEL, spacing=1e-2, **given)
    with pytest.raises(mtb.ResultantError, match=reason):
        scene.solve()


@pytest.mark.coarse
def test_an_approach_needs_a_body_held_along_z() -> None:
    with pytest.raises(ValueError, match="supports leave pad free along z and nothing presses it"):
        mtb.Scene(standing(0.02), STEEL, spacing=1e-2, approach=1e-5, friction=0.3).solve()
    guided = mtb.Scene(standing(0.02, mtb.Guide(-2e3)), STEEL, spacing=1e-2)
    # it would move the body and not the contact
    with pytest.raises(
        ValueError, match=r"leave pad free along z, where a guide presses it: .* Leave approach"
    ):
        guided.with_(approach=1e-5).solve()
    pressed = guided.solve()
    assert pressed.normal_force == pytest.approx(2e3, rel=1e-9)


@pytest.mark.parametrize("size", [1e-5, 1e-29])
def test_meshes_beyond_the_memory_are_refused_before_they_are_made(size: float) -> None:
    with pytest.raises(ValueError, match=r"more than 4e.06: larger elements"):
        mtb.scenes.block_on_plane(spacing=1e-2).with_(element_size=size).solve(model="elastic-upper")
    with pytest.raises(ValueError, match=r"more than 4e.06: larger elements"):
        mtb.scenes.pole_shoe_on_rail(spacing=6e-3).with_(element_size=size).solve(model="elastic-upper")
    with pytest.raises(ValueError, match=rf"size is {size:g} m: the mesh would have about .* unknowns"):
        mtb.ElasticBody.from_mesh(trimesh.creation.box((0.08, 0.04, 0.04)), STEEL, size=size)


@pytest.mark.parametrize("size", [4e-3, 8e-3])
def test_the_number_of_tetrahedra_is_foreseen(size: float) -> None:
    pytest.importorskip("gmsh")
    box = trimesh.creation.box((0.08, 0.04, 0.04))
    body = mtb.ElasticBody.from_mesh(box, STEEL, contact="bottom", size=size)
    bottom = box.vertices[:, 2] < 0.0
    assert 0.4 < _expected(box, bottom, size) / len(body.mesh.cells) < 2.0


def test_a_contact_across_triangles_is_named() -> None:
    pytest.importorskip("gmsh")
    box = trimesh.creation.box((0.08, 0.04, 0.04))
    with pytest.raises(ValueError, match="split the triangles of the surface along the edges of that place"):
        mtb.ElasticBody.from_mesh(box, STEEL, contact=lambda p: (p[2] < 0.0) & (abs(p[0]) < 0.02))
    with pytest.warns(
        UserWarning, match=r"the function given as contact .* covers 0\.001\d* m2 .* 0\.00\d+ m2, and only"
    ):
        mtb.ElasticBody.from_mesh(
            box, STEEL, contact=lambda p: (p[2] < -0.0199) & (abs(p[0]) > 0.02), size=8e-3
        )
    # no warning where the edges are met; side walls within the tolerance are not meant
    mtb.ElasticBody.from_mesh(box, STEEL, contact=lambda p: p[2] < -0.017, size=8e-3)


def test_a_node_of_a_file_that_is_no_number_is_named() -> None:
    mesh = block_mesh([0.0, 0.1], [0.0, 0.1], 0.1, quadratic=False)
    nodes = mesh.nodes.copy()
    nodes[3, 1] = np.nan
    with pytest.raises(ValueError, match=r"node 3 of the mesh is \[.*nan"):
        mtb.ElasticBody.from_mesh(meshio.Mesh(nodes, [("tetra", mesh.cells)]), STEEL)


def test_a_mesh_that_needs_a_package_names_it(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setitem(sys.modules, "meshio", None)
    (tmp_path / "block.vtu").write_text("<VTKFile>", encoding="utf-8")
    with pytest.raises(ValueError, match=r"needs the extra mesh .pip install 'mtb-rs.mesh.'"):
        mtb.ElasticBody.from_mesh(tmp_path / "block.vtu", mtb.steel, contact="bottom")


@pytest.mark.coarse
def test_functions_of_the_gap_give_numbers_of_metres() -> None:
    scene = mtb.Scene(standing(0.02, mtb.Guide(-2e3)), STEEL, spacing=1e-2)
    for gap, found in (
        (lambda x, y: np.where(x > 0.0, np.nan, 0.0), r"\[\d+\] is nan: finite numbers \[m\]"),
        (lambda x, y: np.where(x > 0.0, -np.inf, 0.0), r"\[\d+\] is -inf: finite numbers \[m\]"),
        (lambda x, y: x > 0.0, r"real numbers \[m\] are needed"),
        (lambda x, y: "flat", r"is 'flat': real numbers \[m\] are needed"),
        (lambda x, y: np.ma.masked_greater(x, 0.0), "is masked"),
        (lambda x, y: 1j * x, r"real numbers \[m\] are needed"),
    ):
        with pytest.raises(ValueError, match=rf"what the function gap returns.*{found}"):
            scene.with_(gap=gap).solve("elastic-upper")
    # nothing is opposite where it is infinite
    half = scene.with_(gap=lambda x, y: np.where(x > 0.0, np.inf, 0.0))
    solved = half.solve("elastic-upper")
    assert solved.pressure.any()
    assert not solved.pressure[solved.points[0] > 5e-3].any()


@pytest.mark.coarse
def test_steps_of_a_face_that_does_not_fill_its_grid(tmp_path: Path) -> None:
    cos, sin = np.cos(0.5), np.sin(0.5)
    mesh = block_mesh(np.linspace(-0.04, 0.04, 9), np.linspace(-0.015, 0.015, 4), 0.02)
    turned = mesh.moved([[cos, -sin, 0.0], [sin, cos, 0.0], [0.0, 0.0, 1.0]])
    body = mtb.ElasticBody(turned, STEEL, "bottom", [mtb.Support("top", x=0.0, y=0.0, name="top")], "shoe")
    scene = mtb.Scene(body, STEEL, spacing=8e-3, friction=0.2, magnetic_pressure=2e6, velocity=5.0)
    result, contact = scene.solve("elastic-upper"), scene.prepare("elastic-upper")
    step = contact.step()
    assert step.pressure.size < result.pressure.size
    for what in (step.plot("pressure"), step.save(tmp_path), step.to_xarray()):
        assert what
    with pytest.raises(ValueError, match="scattered"):
        step.stress("lower")
    with pytest.raises(
        ValueError, match=r"in no tetrahedron .* whose face does not fill the grid .* points="
    ):
        result.stress("upper")
    # what is given at all points of the grid, as heat and wear of a scene have it
    worn = 1e-7 * np.random.default_rng(0).random(result.pressure.shape)
    own = worn.ravel()[contact._source.problem.kept.numbers]  # type: ignore[union-attr]
    assert contact.copy().step(gap=worn).force == pytest.approx(contact.copy().step(gap=own).force, rel=1e-12)
