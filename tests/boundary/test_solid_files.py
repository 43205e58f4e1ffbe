# SPDX-License-Identifier: MIT OR Apache-2.0
"""Elastic bodies as files and pictures: displacement and stress at all nodes."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import mtb_rs as mtb
from mtb_rs import PictureWarning
from mtb_rs.pictures import space as view

pyvista = pytest.importorskip("pyvista")
WRITTEN = ("lower_rail.vtp", "left_pole.vtu", "right_pole.vtu")


def test_bodies_are_written_with_their_stress(tmp_path: Path) -> None:
    result = mtb.scenes.pole_shoe_on_rail(spacing=(9e-3, 7.8e-3)).solve(model="elastic-upper")
    if view.missing_for_view() is None:
        names = {path.name for path in result.save(tmp_path)}
        assert "von_mises.png" in names
    else:
        with pytest.warns(PictureWarning):
            names = {path.name for path in result.save(tmp_path)}
    assert {f"body_{name}" for name in WRITTEN} == {n for n in names if n.startswith("body")}
    for name, state in result.states().items():
        solid = pyvista.read(tmp_path / f"body_{name.replace(' ', '_')}.vtu")
        assert set(solid.celltypes) == {pyvista.CellType.QUADRATIC_TETRA}
        np.testing.assert_array_equal(solid.points, state.body.mesh.nodes)
        np.testing.assert_allclose(solid.point_data["displacement"].T, state.displacement, rtol=1e-12)
        xx, yy, zz, xy, yz, xz = solid.point_data["stress"].T
        pairs = (xx - yy) ** 2 + (yy - zz) ** 2 + (zz - xx) ** 2
        equivalent = np.sqrt(0.5 * pairs + 3.0 * (xy**2 + yz**2 + xz**2))
        np.testing.assert_allclose(solid.point_data["von_mises"], equivalent, rtol=1e-9)
    # a body held from above and rubbed along x: the mean of its shear stress xz follows from statics
    solid = pyvista.read(tmp_path / "body_left_pole.vtu")
    middle = solid.slice(normal="z", origin=(0.0, 0.0, 0.5 * solid.bounds[5])).compute_cell_sizes()
    cells = middle.point_data_to_cell_data()
    carried = (cells["stress"][:, 5] * cells["Area"]).sum()
    assert carried == pytest.approx(0.5 * result.force[0], rel=0.05)


@pytest.mark.coarse
def test_a_half_body_is_written_whole() -> None:
    scene = mtb.scenes.pole_shoe_on_rail(spacing=(9e-3, 7.8e-3), height=7.45e-3)
    solids = view.solid_meshes(scene.solve(model="elastic-both"))
    assert list(solids) == ["left pole", "right pole", "rail", "rail mirrored"]
    half, other = solids["rail"], solids["rail mirrored"]
    np.testing.assert_array_equal(other.points[:, 1], -half.points[:, 1])
    on_plane = half.points[:, 1] == 0.0
    np.testing.assert_array_equal(other.point_data["von_mises"], half.point_data["von_mises"])
    # nothing shears the plane of symmetry: what the mirror turns round is small there
    shear = np.abs(half.point_data["stress"][on_plane][:, [3, 4]]).max()
    assert shear < 0.2 * half.point_data["von_mises"].max()


@pytest.mark.skipif(view.missing_for_view() is not None, reason=str(view.missing_for_view()))
def test_the_picture_shows_the_stress() -> None:
    scene = mtb.scenes.pole_shoe_on_rail(spacing=(9e-3, 7.8e-3), poles=1)
    result = scene.solve(model="elastic-upper")
    uniform = []
    for limits in (None, (0.0, 1e9)):
        plotter = result.plot("von_mises", off_screen=True, limits=limits, size=(350, 250))
        pixels = plotter.screenshot(return_img=True).reshape(-1, 3)
        plotter.close()
        drawn = pixels[(pixels < 250).any(axis=1)] // 8
        uniform.append(np.unique(drawn, axis=0, return_counts=True)[1].max() / len(drawn))
    # on the wide scale the body has one colour
    assert uniform[1] > 0.5 > 2.0 * uniform[0]
    with pytest.raises(ValueError, match="by kind='3d' only"):
        result.plot("von_mises", "map")
    with pytest.raises(ValueError, match="no body has finite elements"):
        scene.solve(model="half-space").plot("von_mises")
