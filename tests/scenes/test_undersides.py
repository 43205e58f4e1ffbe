# SPDX-License-Identifier: MIT OR Apache-2.0
"""What "bottom" and "top" of a body mean, whatever its sole looks like."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest

import mtb_rs as mtb
from mtb_rs.bodies.mesh import block_mesh

LENGTH, WIDTH, HEIGHT = 0.12, 0.06, 0.04
#: Turns a body upside down.
OVER = np.diag([1.0, -1.0, -1.0])


def stations(*ends, parts=3):
    return np.unique(np.concatenate([np.linspace(a, b, parts + 1) for a, b in pairwise(ends)]))


X = stations(-0.06, -0.055, -0.01, -0.004, 0.055, 0.06)
Y = stations(-0.03, -0.025, -0.0125, 0.0, 0.0125, 0.025, 0.03, parts=2)


def worn(y, depth=1e-3, half=0.025):
    """Height of a groove of a circle between two strips."""
    radius = (half**2 + depth**2) / (2 * depth)
    return np.where(np.abs(y) < half, np.sqrt(np.maximum(radius**2 - y**2, 0.0)) - (radius - depth), 0.0)


def chamfer(x, slope):
    return slope * np.maximum(np.abs(x) - 0.055, 0.0)


def rounded(x):
    """An edge of 5 mm radius at both ends."""
    into = np.clip(np.abs(x) - 0.055, 0.0, 0.00499)
    return 0.005 - np.sqrt(0.005**2 - into**2)


def shaped(rise, slot=None, x=X, y=Y):
    """A block whose sole is raised by a function of x and y, with a slot across it."""
    mesh = block_mesh(x, y, HEIGHT)
    nodes = mesh.nodes + np.outer(
        rise(mesh.nodes[:, 0], mesh.nodes[:, 1]) * (1 - mesh.nodes[:, 2] / HEIGHT), [0, 0, 1]
    )
    cells = mesh.cells
    if slot is not None:
        middle = mesh.nodes[cells[:, :4]].mean(axis=1)
        cells = cells[~((middle[:, 0] > slot[0]) & (middle[:, 0] < slot[1]) & (middle[:, 2] < 0.012))]
    used, cells = np.unique(cells, return_inverse=True)
    return mtb.TetraMesh(nodes[used], cells.reshape(-1, mesh.cells.shape[1]))


def area(body):
    """Area of a contact face seen along z [m2]; each of its triangles looks the same way."""
    corners = body.mesh.nodes[body.faces[body.contact_faces][:, :3].astype(int)]
    double = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])[:, 2]
    assert (double > 0).all() or (double < 0).all()
    return 0.5 * abs(double.sum())


FULL, BETWEEN = LENGTH * WIDTH, 0.11 * WIDTH
SOLES = {
    "flat": (lambda x, y: 0 * x, None, FULL),
    "flat, chamfers of 45 degrees": (lambda x, y: chamfer(x, 1.0), None, BETWEEN),
    "flat, chamfers of 14 degrees": (lambda x, y: chamfer(x, 0.25), None, BETWEEN),
    "flat, rounded edges": (lambda x, y: rounded(x), None, BETWEEN),
    "flat, slot": (lambda x, y: 0 * x, (-0.01, -0.004), FULL - 0.006 * WIDTH),
    "concave": (lambda x, y: worn(y), None, FULL),
    "concave without strips": (lambda x, y: worn(y, half=0.03), None, FULL),
    "concave, one strip higher": (lambda x, y: worn(y) + 5e-5 * (y + 0.03) / WIDTH, None, FULL),
    "concave in the middle only": (lambda x, y: worn(y, 2e-4, 0.0125), None, FULL),
    "concave, chamfers of 45 degrees": (lambda x, y: worn(y) + chamfer(x, 1.0), None, BETWEEN),
    "concave, chamfers of 14 degrees": (lambda x, y: worn(y) + chamfer(x, 0.25), None, BETWEEN),
    "concave, slot": (lambda x, y: worn(y), (-0.01, -0.004), FULL - 0.006 * WIDTH),
    "convex": (lambda x, y: y**2 / 0.6, None, FULL),
    "convex along": (lambda x, y: x**2 / 4.0, None, FULL),
    "convex along, slot off the middle": (lambda x, y: x**2 / 4.0, (-0.01, -0.004), FULL - 0.006 * WIDTH),
    "convex, chamfers": (lambda x, y: y**2 / 0.6 + chamfer(x, 1.0), None, BETWEEN),
    "domed": (lambda x, y: (x**2 + y**2) / 2.0, None, FULL),
}


@pytest.mark.parametrize("name", SOLES)
def test_the_underside_is_the_whole_sole(name):
    rise, slot, expected = SOLES[name]
    mesh = shaped(rise, slot)
    # triangles at a corner of a curve and a chamfer belong to either
    assert area(mtb.ElasticBody(mesh, mtb.steel, "bottom")) == pytest.approx(expected, rel=1e-9)
    over = mtb.ElasticBody(mesh.moved(OVER, (0, 0, HEIGHT)), mtb.steel, "top")
    assert area(over) == pytest.approx(expected, rel=1e-9)
    linear = mtb.TetraMesh(mesh.nodes, mesh.cells[:, :4])
    used, cells = np.unique(linear.cells, return_inverse=True)
    again = mtb.TetraMesh(linear.nodes[used], cells.reshape(-1, 4))
    assert area(mtb.ElasticBody(again, mtb.steel, "bottom")) == pytest.approx(expected, rel=1e-9)


def test_a_ball_has_an_underside_up_to_its_slope():
    trimesh = pytest.importorskip("trimesh")
    from mtb_rs.bodies.sole import STEEPEST, underside

    ball = trimesh.creation.icosphere(subdivisions=3, radius=0.02)
    found = underside(ball.vertices, ball.faces)
    outline = ball.vertices[ball.faces[found]].reshape(-1, 3)
    assert found.any()
    assert outline[:, 2].max() < 0.0
    assert np.hypot(*outline[:, :2].T).max() == pytest.approx(0.02 * np.sin(STEEPEST), rel=0.1)


def test_a_set_of_nodes_of_that_name_goes_first():
    mesh = shaped(lambda x, y: worn(y))
    strip = np.flatnonzero((mesh.nodes[:, 2] < 1e-9) & (mesh.nodes[:, 1] > 0.0))
    named = mtb.TetraMesh(mesh.nodes, mesh.cells, {"bottom": strip})
    assert area(mtb.ElasticBody(named, mtb.steel, "bottom")) == pytest.approx(LENGTH * 0.005)


@pytest.mark.parametrize(
    ("wrong", "match"),
    [
        (np.diag([1.0, 1.0, -1.0]), "no rotation but a mirror"),
        (2.0 * np.eye(3), "scales or shears"),
        ([[1, 0.1, 0], [0, 1, 0], [0, 0, 1]], "scales or shears"),
        (np.eye(2), r"shape \(2, 2\): a matrix \(3, 3\)"),
        (np.full((3, 3), np.nan), "rotation"),
    ],
)
def test_what_is_no_rotation_is_refused(wrong, match):
    mesh = shaped(lambda x, y: 0 * x)
    with pytest.raises(ValueError, match=match):
        mesh.moved(wrong)
    with pytest.raises(ValueError, match=match):
        mtb.ElasticBody.from_mesh(mesh, mtb.steel, rotation=wrong)
    with pytest.raises(ValueError, match="shift"):
        mesh.moved(shift=(1.0, 2.0))


def test_a_part_with_other_axes_is_turned_before_its_places_are_looked_for():
    mesh = shaped(lambda x, y: worn(y))
    # as drawn: x along the rail, y up
    drawn = mesh.moved([[1, 0, 0], [0, 0, 1], [0, -1, 0]], (0.5, 0.0, 0.0))
    back = [[1, 0, 0], [0, 0, -1], [0, 1, 0]]
    body = mtb.ElasticBody.from_mesh(drawn, mtb.steel, rotation=back, shift=(-0.5, 0.0, 0.0))
    assert np.abs(body.mesh.nodes - mesh.nodes).max() < 1e-12
    assert area(body) == pytest.approx(FULL)


@pytest.mark.slow
def test_a_surface_with_other_axes_can_be_meshed_again():
    pytest.importorskip("gmsh", exc_type=ImportError)
    trimesh = pytest.importorskip("trimesh")
    box = trimesh.creation.box(extents=(40, 20, 30))
    body = mtb.ElasticBody.from_mesh(
        box,
        mtb.steel,
        unit="mm",
        size=0.01,
        supports=[mtb.Support("top", x=0, y=0, z=0)],
        rotation=[[1, 0, 0], [0, 0, -1], [0, 1, 0]],
        shift=(0, 0, 0.01),
    )
    for one in (body, body.resized(0.008)):
        assert np.allclose(
            [one.mesh.nodes.min(axis=0), one.mesh.nodes.max(axis=0)],
            [[-0.02, -0.015, 0], [0.02, 0.015, 0.02]],
        )
        assert area(one) == pytest.approx(0.04 * 0.03)


def test_two_corners_are_questioned():
    with pytest.warns(UserWarning, match=r"corners of a box\? .*\(\(0, 1\), \(-2, 3\), \(4, 5\)\)"):
        mtb.Support(((0, 3, 5), (1, -2, 4)), z=0)
    mtb.Support(((0, 3, 5), (1, -2, 5)), z=0)  # two screws
    with pytest.raises(ValueError, match=r"given as 2 points \(a box is .*not two corners\)"):
        mtb.ElasticBody(shaped(lambda x, y: 0 * x), mtb.steel, ((-0.06, -0.03, 0), (0.06, 0.03, 0.04)))
    assert "((x0, x1), (y0, y1), (z0, z1))" in mtb.Support.__doc__


def test_a_function_on_a_curved_sole_is_told_only_where_area_is_lost():
    mesh = shaped(lambda x, y: worn(y, 2e-3))

    def on_the_face(points):
        return np.abs(points[2] - worn(points[1], 2e-3)) < 1e-7

    # between the nodes facets are off a curve, and so not in a function as tight
    assert area(mtb.ElasticBody(mesh, mtb.steel, on_the_face)) == pytest.approx(FULL)
    with pytest.warns(UserWarning, match="only whole triangles can touch"):
        mtb.ElasticBody(mesh, mtb.steel, lambda p: on_the_face(p) & (p[0] < 0.03))
