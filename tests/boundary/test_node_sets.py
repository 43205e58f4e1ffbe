# SPDX-License-Identifier: MIT OR Apache-2.0
"""Named places of meshes: read from files, kept as they were given."""

from __future__ import annotations

import copy
import pickle
from pathlib import Path

import meshio
import numpy as np
import pytest
import trimesh

import mtb_rs as mtb
from mtb_rs.bodies.mesh import block_mesh

LINE = np.linspace(-0.02, 0.02, 4)
BLOCK = block_mesh(LINE, LINE, 0.02, halved=False, clamped=True)
CELLS = BLOCK.cells[:, :4]
ON_TOP = np.abs(BLOCK.nodes[:, 2] - 0.02) < 1e-9
TOP = np.flatnonzero(ON_TOP & np.isin(np.arange(len(ON_TOP)), CELLS))
FACES = np.concatenate([CELLS[:, [0, 1, 2]], CELLS[:, [0, 1, 3]], CELLS[:, [0, 2, 3]], CELLS[:, [1, 2, 3]]])
FACES = FACES[ON_TOP[FACES].all(axis=1)]
BLOCK_NAMED = mtb.TetraMesh(BLOCK.nodes, BLOCK.cells, {"clamp": np.flatnonzero(ON_TOP)})
#: Tags of the triangles and of the tetrahedra; gmsh counts each dimension by itself.
TAGS = [np.full(len(FACES), 3), np.full(len(CELLS), 3)]


def point_set() -> meshio.Mesh:
    return meshio.Mesh(BLOCK.nodes, [("tetra", CELLS)], point_sets={"clamp": TOP})


def cell_set() -> meshio.Mesh:
    return meshio.Mesh(
        BLOCK.nodes,
        [("triangle", FACES), ("tetra", CELLS)],
        cell_sets={"clamp": [np.arange(len(FACES)), np.arange(0)]},
    )


def physical_group() -> meshio.Mesh:
    return meshio.Mesh(
        BLOCK.nodes,
        [("triangle", FACES), ("tetra", CELLS)],
        cell_data={"gmsh:physical": TAGS, "gmsh:geometrical": TAGS},
        field_data={"clamp": np.array([3, 2]), "steel": np.array([3, 3])},
    )


def held(source: object) -> mtb.ElasticBody:
    return mtb.ElasticBody.from_mesh(source, mtb.steel, supports=[mtb.Support("clamp", 0, 0, 0)])


@pytest.mark.parametrize("made", [point_set, cell_set, physical_group])
def test_sets_of_a_mesh_are_places(made: object) -> None:
    body = held(made())  # type: ignore[operator]
    chosen = body.mesh.nodes[body.support_nodes(0)]
    by_place = held(BLOCK_NAMED).mesh
    top = by_place.nodes[np.abs(by_place.nodes[:, 2] - 0.02) < 1e-9]
    np.testing.assert_allclose(np.sort(chosen, axis=0), np.sort(top, axis=0), atol=1e-12)


@pytest.mark.parametrize(
    ("name", "file_format", "made"),
    [("body.inp", "abaqus", point_set), ("body.msh", "gmsh22", physical_group)],
)
def test_sets_of_a_file_are_places(tmp_path: Path, name: str, file_format: str, made: object) -> None:
    meshio.write(tmp_path / name, made(), file_format=file_format)  # type: ignore[operator]
    body = held(tmp_path / name)
    assert body.support_nodes(0).size == held(made()).support_nodes(0).size  # type: ignore[operator]


def test_a_set_without_nodes_of_tetrahedra_says_so() -> None:
    mesh = point_set()
    mesh.points = np.concatenate([mesh.points, [[0.0, 0.0, 1.0]]])
    mesh.point_sets["clamp"] = np.array([len(mesh.points) - 1])
    with pytest.raises(ValueError, match="support 'clamp' of body, 'clamp', contains no node"):
        held(mesh)


def test_named_sets_stay_as_given() -> None:
    sets = BLOCK_NAMED.node_sets
    for change in (
        lambda: sets.__setitem__("other", np.arange(3)),
        lambda: sets.update(other=np.arange(3)),  # type: ignore[attr-defined]
        lambda: sets.pop("clamp"),  # type: ignore[attr-defined]
    ):
        with pytest.raises(TypeError, match="does not change"):
            change()
    assert list(sets) == ["clamp"]
    for twin in (pickle.loads(pickle.dumps(BLOCK_NAMED)), copy.deepcopy(BLOCK_NAMED)):
        assert list(twin.node_sets) == ["clamp"]
        with pytest.raises(TypeError):
            twin.node_sets["other"] = np.arange(3)


@pytest.mark.parametrize("upper", [True, False])
def test_a_surface_that_faces_away_is_named(upper: bool) -> None:
    ends = 0.1 * np.array([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]])
    up = [[0, 1, 2], [0, 2, 3]]
    surface = trimesh.Trimesh(ends, up if upper else np.fliplr(up), process=False)
    side = "top" if upper else "bottom"
    body = mtb.ElasticBody(
        BLOCK, mtb.steel, side, [mtb.Support("bottom" if upper else "top", 0, 0, 1e-6 if upper else -1e-6)]
    )
    bodies = {"lower": body, "upper": mtb.HalfSpace(mtb.steel, surface)}
    if not upper:
        bodies = {"upper": body, "lower": mtb.HalfSpace(mtb.steel, surface)}
    name, faces = ("upper", "up") if upper else ("lower", "down")
    with pytest.raises(ValueError, match=f"surface of the {name} body faces {faces}"):
        mtb.Scene(**bodies, spacing=1e-2, approach=1e-6 if upper else None).solve()
