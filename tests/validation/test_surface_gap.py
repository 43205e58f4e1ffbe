# SPDX-License-Identifier: MIT OR Apache-2.0
"""The gap between arbitrary surfaces: meshes from files against exact distances."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import trimesh

from mtb_rs.bodies.surfaces import BodySurface, surface_gap
from mtb_rs.geometry.profiles import Profile

RADIUS = 0.08
PATCH = ((-4e-3, 4e-3), (-4e-3, 4e-3))


def ball_file(directory: Path, subdivisions: int) -> Path:
    """A ball standing on the plane, in millimetres, without shared vertices."""
    ball = trimesh.creation.icosphere(subdivisions=subdivisions, radius=RADIUS * 1e3)
    ball.apply_transform(trimesh.transformations.rotation_matrix(0.3, [1.0, 0.4, 0.2]))
    ball.apply_translation([0.0, 0.0, RADIUS * 1e3])
    path = directory / f"ball{subdivisions}.ply"
    ball.export(path)
    return path


def test_mesh_from_file_converges_to_the_ball(tmp_path: Path) -> None:
    plane = BodySurface.plane()
    errors, estimates = [], []
    for subdivisions in (3, 4, 5):
        ball = BodySurface.from_file(ball_file(tmp_path, subdivisions), unit="mm")
        found = surface_gap(plane, ball, *PATCH, 5e-4, reach=0.02)
        x, y = found.grid.points[:2]
        exact = RADIUS - np.sqrt(RADIUS**2 - x**2 - y**2)
        errors.append(float(np.abs(found.grid.gap - exact).max()))
        estimates.append(float(found.facet_error.max()))
        assert not found.nearest.any()
    rates = np.log2(np.divide(errors[:-1], errors[1:]))
    assert np.all(rates > 3.5), (errors, rates)
    # facets of 2.8 mm: flat ones would be 12 um off
    assert errors[-1] < 5e-8
    assert np.all(np.asarray(estimates) > errors)


def test_coarse_facets_are_refused(tmp_path: Path) -> None:
    plane = BodySurface.plane()
    ball = BodySurface.from_file(ball_file(tmp_path, 2), unit="mm")
    with pytest.raises(ValueError, match="not small against the approach"):
        surface_gap(plane, ball, *PATCH, 1e-3, reach=0.02, approach=1e-6)
    fine = BodySurface.from_file(ball_file(tmp_path, 5), unit="mm")
    surface_gap(plane, fine, *PATCH, 1e-3, reach=0.02, approach=1e-6)


def test_points_beside_the_upper_body() -> None:
    plane, block = BodySurface.plane(), BodySurface.block(4e-3, 4e-3, height=1e-3)
    found = surface_gap(plane, block, (-4e-3, 4e-3), (-4e-3, 4e-3), 1e-3)
    inside = np.abs(found.grid.points[:2]).max(axis=0) < 2e-3
    assert np.allclose(found.grid.gap[inside], 1e-3, atol=1e-16)
    assert np.all(np.isinf(found.grid.gap[~inside]))
    # a mesh of the same block has sides, and those are near
    box = trimesh.creation.box([4e-3, 4e-3, 2e-3])
    box.apply_translation([0.0, 0.0, 2e-3])
    mesh = BodySurface.mesh(box.vertices.T, box.faces)
    found = surface_gap(plane, mesh, (-4e-3, 4e-3), (-4e-3, 4e-3), 1e-3)
    assert np.array_equal(found.nearest, ~inside)
    beyond = np.maximum(np.abs(found.grid.points[:2]) - 2e-3, 0.0)
    assert np.allclose(found.grid.gap, np.hypot(1e-3, np.hypot(*beyond)), atol=1e-15)


def test_height_field_on_rail() -> None:
    rail = BodySurface.rail("60E1", length=0.1)
    profile = Profile.standard("60E1")
    x, y = np.linspace(-0.02, 0.02, 161), np.linspace(-8e-3, 8e-3, 161)
    heights = profile.height(y)[:, None] + 1e-5 + 0.5 * x**2
    field = BodySurface.height_field(heights, (x[1] - x[0], y[1] - y[0]))
    found = surface_gap(rail, field, (-0.01, 0.01), (-5e-3, 5e-3), 1e-3)
    grid = found.grid
    # nearly parallel surfaces: the normal distance is the vertical one times the normal's rise
    exact = (1e-5 + 0.5 * grid.points[0] ** 2) * grid.normal[2]
    assert np.allclose(grid.gap, exact, rtol=2e-3, atol=1e-9)
    assert np.allclose(grid.area, grid.spacing[0] * grid.spacing[1] / grid.normal[2], rtol=1e-14)
    assert np.allclose(rail.top(0.0, y), profile.height(y), atol=1e-17)
    assert np.isnan(rail.top(0.2, 0.0))


def test_bad_bodies_are_named(tmp_path: Path) -> None:
    box = trimesh.creation.box([0.1, 0.1, 0.1])
    vertices, faces = np.asarray(box.vertices).T, np.asarray(box.faces)
    cases = [
        (vertices, faces[1:], "not watertight: 3 edges"),
        (vertices, faces[:, ::-1], "point inwards"),
        (vertices * 1e3, faces, "unit"),
        (vertices * np.nan, faces, r"vertices\[0, 0\] is nan"),
        (vertices, np.where(faces == 7, 99, faces), "vertex 99"),
        (vertices, np.where(faces == 7, -1, faces), "counted from 0"),
        (vertices, np.vstack([faces, [[0, 1, 1]]]), "triangle 12 is degenerate"),
        (vertices, faces.astype(float), "integers"),
        (vertices.T, faces, r"\(3, n\) is needed"),
        (vertices, faces[:, :2], r"\(m, 3\) of integers"),
    ]
    for points, triangles, message in cases:
        with pytest.raises(ValueError, match=message):
            BodySurface.mesh(points, triangles)
    with pytest.raises(ValueError, match="does not exist"):
        BodySurface.from_file(tmp_path / "none.stl", unit="mm")
    broken = tmp_path / "broken.stl"
    broken.write_text("no mesh")
    with pytest.raises(ValueError, match=r"broken\.stl"):
        BodySurface.from_file(broken, unit="mm")
    with pytest.raises(ValueError, match="unit is 'furlong'"):
        BodySurface.from_file(broken, unit="furlong")
    with pytest.raises(ValueError, match=r"heights\[0, 1\] is nan"):
        BodySurface.height_field([[0.0, np.nan], [0.0, 0.0]], 1e-3)
    with pytest.raises(ValueError, match="paraboloid radius is 0"):
        BodySurface.paraboloid(0.0)
    with pytest.raises(ValueError, match="block width is -1"):
        BodySurface.block(1.0, -1.0)


def test_bad_grids_are_named() -> None:
    plane, ball = BodySurface.plane(), BodySurface.paraboloid(0.1)
    with pytest.raises(ValueError, match="never touch"):
        surface_gap(plane, BodySurface.plane(0.1), *PATCH, 1e-3)
    with pytest.raises(ValueError, match="no surface at"):
        surface_gap(BodySurface.block(1e-3, 1e-3), ball, *PATCH, 1e-3)
    with pytest.raises(ValueError, match="y to is 0"):
        surface_gap(plane, ball, (0.0, 1.0), (0.0, 0.0), 1e-3)
    with pytest.raises(ValueError, match="reach is -1"):
        surface_gap(plane, ball, *PATCH, 1e-3, reach=-1.0)
    with pytest.raises(ValueError, match="approach is 0"):
        surface_gap(plane, ball, *PATCH, 1e-3, approach=0.0)
