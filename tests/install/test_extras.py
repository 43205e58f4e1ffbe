# SPDX-License-Identifier: MIT OR Apache-2.0
"""What an installation with some extras can do, and how it names the extra that the rest needs."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest
import trimesh

from mtb_rs.bodies.mesh_files import SURFACE_FILES

pytestmark = pytest.mark.slow  # starts Python for each extra

Environment = Callable[..., dict[str, str]]


def run(code: str, environment: dict[str, str], folder: Path) -> str:
    command = [sys.executable, "-W", "error", "-c", code]
    done = subprocess.run(command, env=environment, cwd=folder, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return done.stdout


def test_what_no_extra_brings_is_hidden(with_extras: Environment, tmp_path: Path) -> None:
    code = """
from importlib.util import find_spec
names = ["numpy", "trimesh", "matplotlib", "gmsh", "scipy", "networkx", "pyvista", "vtkmodules", "pytest"]
print(*(name for name in names if find_spec(name)))
"""
    assert run(code, with_extras(), tmp_path).split() == ["numpy", "trimesh", "matplotlib"]
    found = run(code, with_extras("mesh"), tmp_path).split()
    assert {"gmsh", "scipy", "networkx"} <= set(found)
    assert not {"pyvista", "vtkmodules", "pytest"} & set(found)


@pytest.fixture(scope="module")
def surfaces(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A block in every kind of file of surfaces, and one with a triangle turned round."""
    folder = tmp_path_factory.mktemp("surfaces")
    block = trimesh.creation.box((0.04, 0.03, 0.02))
    for ending in SURFACE_FILES:
        if ending != ".gltf":
            block.export(folder / f"block{ending}")
    for name, content in block.export(file_type="gltf").items():
        (folder / name.replace("model", "block")).write_bytes(content)
    faces = block.faces.copy()
    faces[3] = faces[3][::-1]
    trimesh.Trimesh(block.vertices, faces).export(folder / "turned.ply")
    return folder


SOLVE = f"""
import numpy as np
import mtb_rs as mtb
held = [mtb.Support("top", x=0, y=0, z=mtb.Guide(-1e3))]
for name in [*("block" + ending for ending in {SURFACE_FILES!r}), "turned.ply"]:
    body = mtb.ElasticBody.from_mesh(name, mtb.steel, supports=held, size=1e-2)
    a, b, c, d = body.mesh.nodes[body.mesh.cells[:, :4]].transpose(1, 0, 2)
    assert abs(np.linalg.det(np.stack([b - a, c - a, d - a], axis=1)).sum() / 6 / 2.4e-5 - 1) < 1e-6, name
    if name != "turned.ply":
        mtb.BodySurface.from_file(name, unit="m")
"""


def test_the_extra_mesh_reads_every_surface(with_extras: Environment, surfaces: Path) -> None:
    pytest.importorskip("gmsh", exc_type=ImportError)
    run(SOLVE, with_extras("mesh"), surfaces)


@pytest.mark.parametrize("name", ["block.stl", "block.3mf", "turned.ply", "block.step", "block.msh"])
def test_a_missing_extra_is_named(name: str, with_extras: Environment, surfaces: Path) -> None:
    (surfaces / "block.step").write_text("no solid")
    (surfaces / "block.msh").write_text("no mesh")
    code = f"""
import mtb_rs as mtb
try:
    mtb.ElasticBody.from_mesh({name!r}, mtb.steel)
except ValueError as error:
    print(error)
"""
    told = run(code, with_extras(), surfaces)
    assert "needs the extra mesh (pip install 'mtb-rs[mesh]'): No module" in told
