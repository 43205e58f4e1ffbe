# SPDX-License-Identifier: MIT OR Apache-2.0
"""Charts mesh bodies of one's own again where they can, and say so where they cannot."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import trimesh

import mtb_rs as mtb
from mtb_rs.studies import chart_scene

pytest.importorskip("gmsh", exc_type=ImportError)


def pad(path: Path | trimesh.Trimesh, size: float) -> mtb.ElasticBody:
    top = [mtb.Support("top", x=0.0, y=0.0, z=0.0)]
    return mtb.ElasticBody.from_mesh(path, mtb.steel, supports=top, size=size, name="pad")


@pytest.fixture
def surface() -> trimesh.Trimesh:
    return trimesh.creation.box((0.04, 0.03, 0.02), trimesh.transformations.translation_matrix((0, 0, 0.01)))


def test_a_solid_is_filled_again_with_another_size(surface: trimesh.Trimesh, tmp_path: Path) -> None:
    path = tmp_path / "pad.stl"
    surface.export(path)
    body = pad(path, 10e-3)
    fine = body.resized(5e-3)
    assert (body.size, fine.size) == (10e-3, 5e-3)
    assert len(fine.mesh.cells) > 3 * len(body.mesh.cells)
    assert (fine.name, fine.material) == (body.name, body.material)
    np.testing.assert_allclose(np.ptp(fine.mesh.nodes, axis=0), (0.04, 0.03, 0.02), atol=1e-8)
    # a surface handed over is kept as it was
    held = pad(surface, 10e-3)
    surface.apply_scale(2.0)
    np.testing.assert_allclose(np.ptp(held.resized(8e-3).mesh.nodes, axis=0), (0.04, 0.03, 0.02), atol=1e-8)
    # what is no longer that solid says so
    given = replace(body, mesh=held.mesh)
    assert given.size is None
    with pytest.raises(ValueError, match="pad has no size: its mesh was given as it is"):
        given.resized(5e-3)
    surface.export(path)
    with pytest.raises(ValueError, match=r"pad\.stl has changed since"):
        body.resized(5e-3)


def test_a_chart_meshes_a_solid_with_its_cells(surface: trimesh.Trimesh, tmp_path: Path) -> None:
    body = pad(surface, 10e-3)
    scenes = [
        mtb.Scene(upper, mtb.steel, spacing=7e-3, friction=0.4, magnetic_pressure=3e6)
        for upper in (body, replace(body))
    ]
    # cells go on where a given mesh ends, and the elements with them
    finest = [min(chart_scene._spacings(scene)) for scene in scenes]
    assert finest[0] < finest[1]
    copies = chart_scene._Copies(scenes[0])
    assert copies.at((7e-3, 7e-3))["upper"] is body
    assert copies.at((3.5e-3, 3.5e-3))["upper"].size == pytest.approx(5e-3)
    assert chart_scene._Copies(scenes[1]).at((3.5e-3, 3.5e-3)) == {}
    meshed, given = (scene.chart(quantity="force", budget=4.0, repeats=1) for scene in scenes)
    assert not any(point.failure for point in meshed.points)
    assert "meshed as finely" in meshed.reference
    assert not meshed.remark
    assert given.remark.startswith("The mesh of pad was given and stays as it is")
    given.save(tmp_path)
    assert given.remark in (tmp_path / "chart.html").read_text(encoding="utf-8")
