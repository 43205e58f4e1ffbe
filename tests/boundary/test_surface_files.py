# SPDX-License-Identifier: MIT OR Apache-2.0
"""Files of triangles at both doors, bodies that are filled and surfaces: the same is taken, and refused."""

from __future__ import annotations

import zipfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh

import mtb_rs as mtb

pytest.importorskip("gmsh")

LENGTH, WIDTH, HEIGHT = 0.04, 0.03, 0.02


def block() -> trimesh.Trimesh:
    return trimesh.creation.box((LENGTH, WIDTH, HEIGHT)).subdivide().subdivide()


def turned(which: slice) -> trimesh.Trimesh:
    sound = block()
    faces = sound.faces.copy()
    faces[which] = faces[which, ::-1]
    return trimesh.Trimesh(sound.vertices, faces, process=False)


#: Sound, half inside out, one triangle inside out, all of them.
WINDINGS = {"none": slice(0), "half": slice(0, None, 2), "one": slice(7, 8), "all": slice(None)}


def body(source: Any) -> mtb.ElasticBody:
    return mtb.ElasticBody.from_mesh(source, mtb.steel, size=1e-2)


def surface(path: Path) -> mtb.BodySurface:
    return mtb.BodySurface.from_file(path, unit="m")


@pytest.mark.parametrize("suffix", [".stl", ".ply", ".obj"])
@pytest.mark.parametrize("which", WINDINGS)
def test_triangles_are_turned_outwards_at_both_doors(which: str, suffix: str, tmp_path: Path) -> None:
    path = tmp_path / f"block{suffix}"
    turned(WINDINGS[which]).export(path)
    face = surface(path)
    assert face.top(0.0, 0.0) == pytest.approx(0.5 * HEIGHT, rel=1e-6)
    assert face.bottom(0.0, 0.0) == pytest.approx(-0.5 * HEIGHT, rel=1e-6)
    if suffix == ".stl":
        mesh = body(path).mesh
        corners = mesh.nodes[mesh.cells[:, :4]]
        volume = np.linalg.det(corners[:, 1:] - corners[:, :1]).sum() / 6.0
        assert volume == pytest.approx(LENGTH * WIDTH * HEIGHT, rel=1e-6)


@pytest.mark.parametrize("which", WINDINGS)
def test_objects_are_turned_outwards_and_stay_as_they_are(which: str) -> None:
    given = turned(WINDINGS[which])
    faces = given.faces.copy()
    scene = mtb.Scene(
        lower=mtb.HalfSpace(mtb.steel, given), upper=body(block()), spacing=1e-2, force=1.0, friction=0.1
    )
    assert scene.lower.surface.top(0.0, 0.0) == pytest.approx(0.5 * HEIGHT, rel=1e-6)
    np.testing.assert_array_equal(given.faces, faces)


def _archive(path: Path, name: str, text: str) -> None:
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr(name, text)


DAMAGED: dict[str, Callable[[Path], Any]] = {
    "no archive.3mf": lambda p: p.write_bytes(b"hello"),
    "no model.3mf": lambda p: _archive(p, "readme.txt", "hello"),
    "cut model.3mf": lambda p: _archive(p, "3D/3dmodel.model", "<model>"),
    "short.glb": lambda p: p.write_bytes(b"hello"),
    "short.gltf": lambda p: p.write_text("{"),
    "words.ply": lambda p: p.write_text("hello"),
    "words.off": lambda p: p.write_text("hello"),
}


@pytest.mark.parametrize("door", [body, surface])
@pytest.mark.parametrize("name", DAMAGED)
def test_damaged_files_are_named_with_what_would_do(
    name: str, door: Callable[[Path], Any], tmp_path: Path
) -> None:
    path = tmp_path / name
    DAMAGED[name](path)
    with pytest.raises(ValueError, match=r"damaged one \(.+\); a file of one surface .*\.3mf") as caught:
        door(path)
    message = str(caught.value)
    assert message.startswith(f"{path} cannot be read: it is no {path.suffix} file")
    assert "\n" not in message


def test_solids_are_no_surfaces(tmp_path: Path) -> None:
    path = tmp_path / "block.step"
    path.write_text("ISO-10303-21;")
    with pytest.raises(ValueError, match=r"holds a solid of CAD: .*ElasticBody.from_mesh takes solids"):
        surface(path)


@pytest.mark.parametrize("door", [body, surface])
def test_without_a_library_of_its_own_the_extra_is_named(
    door: Callable[[Path], Any], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "block.ply"
    turned(WINDINGS["half"]).export(path)
    missing = trimesh.exceptions.ExceptionWrapper(ModuleNotFoundError("No module named 'networkx'"))
    monkeypatch.setattr(trimesh.repair, "nx", missing)
    with pytest.raises(ValueError, match=r"needs the extra mesh .*mtb-rs\[mesh\].*networkx"):
        door(path)
