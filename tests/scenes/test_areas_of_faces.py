# SPDX-License-Identifier: MIT OR Apache-2.0
"""Areas of contact faces whose outlines cut cells, the pull on them, and what of it has nothing opposite."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import mtb_rs as mtb
from mtb_rs.bodies.mesh import block_mesh
from mtb_rs.bodies.outline import area, covered

HELD = [mtb.Support("top", x=0.0, y=0.0, z=mtb.Guide(0.0))]


def ring(corners):
    """Outline of a polygon (k, 2), counter-clockwise."""
    corners = np.asarray(corners, dtype=float)
    return np.stack([corners, np.roll(corners, -1, axis=0)], axis=1)


@settings(max_examples=25, deadline=None)
@given(st.lists(st.floats(0.1, 1.0), min_size=3, max_size=9), st.floats(-1.0, 1.0), st.floats(0.0, 6.0))
def test_shares_of_cells_add_up_to_the_area(radii, off, turn):
    """Polygons around a point, within the grid and over its edge, against a fine count."""
    angle = turn + np.linspace(0.0, 2.0 * np.pi, len(radii), endpoint=False)
    pieces = ring(np.stack([off + radii * np.cos(angle), radii * np.sin(angle)], axis=1))
    x, y = np.linspace(-2.0, 2.0, 12), np.linspace(-1.0, 1.0, 8)
    share = covered(pieces, x, y)
    cell = (x[1] - x[0]) * (y[1] - y[0])
    assert cell * share.sum() == pytest.approx(area(pieces), rel=1e-9)
    # and those of half a grid to the part that lies on it
    half = covered(pieces, x[4:], y)
    assert np.abs(half - share[:, 4:]).max() < 1e-9


def test_shares_of_cells_are_those_of_a_rectangle_with_a_hole():
    outer = ring([(0, 0), (3, 0), (3, 2), (0, 2)])
    hole = ring([(1.25, 0.5), (1.25, 1.5), (1.75, 1.5), (1.75, 0.5)])
    share = covered(np.concatenate([outer, hole]), np.arange(5.0), np.arange(4.0))
    expected = np.zeros((3, 4))
    expected[:2, :3] = 1.0
    expected[:2, 1] = 0.75
    assert share == pytest.approx(expected, abs=1e-12)


def holed(ends=(0.04, 0.03)):
    """An oval block with an oval hole: its mesh is a ring, its edges are curved."""
    mesh = block_mesh(np.linspace(0.0, 1.0, 25), np.linspace(0.4, 1.0, 4), 0.03)
    angle, radius = -2.0 * np.pi * mesh.nodes[:, 0], mesh.nodes[:, 1]
    nodes = np.stack(
        [ends[0] * radius * np.cos(angle), -ends[1] * radius * np.sin(angle), mesh.nodes[:, 2]], axis=1
    )
    nodes[:, :2] = nodes[:, :2] * [1.0, -1.0]
    # the ends of the ring become one
    _, first, number = np.unique(np.round(nodes, 9), axis=0, return_index=True, return_inverse=True)
    cells = number.reshape(-1)[mesh.cells]
    from mtb_rs.bodies.mesh_files import upright

    return upright(mtb.TetraMesh(nodes[first], cells))


@pytest.mark.coarse
@pytest.mark.parametrize("spacing", [9e-3, (7e-3, 5e-3)])
def test_the_pull_is_that_of_the_face_at_any_spacing(spacing):
    body = mtb.ElasticBody(holed(), mtb.steel, "bottom", HELD)
    # of ellipses: the parabolas of 24 elements around are within 1e-5 of them
    face = np.pi * 0.04 * 0.03 * (1.0 - 0.4**2)
    scene = mtb.Scene(body, mtb.steel, spacing=spacing, friction=0.1, magnetic_pressure=1e6)
    result = scene.solve()
    assert result.area.sum() == pytest.approx(face, rel=1e-4)
    assert -result.force[2] == pytest.approx(1e6 * face, rel=1e-4)
    assert result.force[0] == pytest.approx(0.1 * 1e6 * face, rel=1e-4)
    assert result.report.force_balance["relative_error"] < 1e-9


def block(length=0.12, width=0.06, level=0.0, height=0.04, supports=HELD, contact="contact"):
    mesh = block_mesh(np.linspace(-length / 2, length / 2, 13), np.linspace(-width / 2, width / 2, 7), height)
    nodes = mesh.nodes + np.array([0.0, 0.0, level])
    return mtb.ElasticBody(
        mtb.TetraMesh(nodes, mesh.cells, mesh.node_sets), mtb.steel, contact, supports, f"block {width:g}"
    )


def flat(half):
    return mtb.Profile.from_points([-half, 0.0, half], [0.0, 0.0, 0.0])


@pytest.mark.coarse
@pytest.mark.parametrize("half", [0.02, 0.012, 0.005])
def test_what_has_nothing_opposite_is_told(half):
    scene = mtb.Scene(
        upper=block(), lower=mtb.HalfSpace(mtb.steel, flat(half)), spacing=(6e-3, 4e-3), magnetic_pressure=1e6
    )
    missing = 100.0 * (1.0 - half / 0.03)
    with pytest.warns(
        UserWarning, match=rf"{missing:.2g} % of the contact face of block 0.06 has nothing opposite"
    ):
        result = scene.solve()
    # where the bodies face one another the pull is all there
    assert -result.force[2] == pytest.approx(1e6 * 0.12 * 2.0 * half, rel=1e-9)


@pytest.mark.coarse
def test_what_lies_on_a_larger_body_is_not_told():
    for lower in (
        mtb.HalfSpace(mtb.steel, flat(0.035)),
        mtb.Rigid(mtb.BodySurface.block(0.2, 0.08)),
        block(0.2, 0.1, -0.04, supports=[mtb.Support("bottom", x=0.0, y=0.0, z=0.0)], contact="top"),
    ):
        result = mtb.Scene(block(), lower, spacing=6e-3, magnetic_pressure=1e6).solve()
        assert -result.force[2] == pytest.approx(7200.0, rel=1e-9)


@pytest.mark.coarse
def test_two_bodies_that_cross_tell_the_upper_one():
    lower = block(0.2, 0.03, -0.04, supports=[mtb.Support("bottom", x=0.0, y=0.0, z=0.0)], contact="top")
    with pytest.warns(UserWarning, match=r"50 % of the contact face of block 0\.06 has nothing"):
        result = mtb.Scene(block(), lower, spacing=7e-3, magnetic_pressure=1e6).solve()
    assert -result.force[2] == pytest.approx(3600.0, rel=1e-9)
    assert result.report.force_balance["relative_error"] < 1e-9


@pytest.mark.coarse
@pytest.mark.filterwarnings("ignore:the gap opens|the contact is at most:UserWarning")
@pytest.mark.parametrize("spacing", [(1e-2, 6e-3), (1e-2, 5e-3), (1e-2, 4e-3)])
@pytest.mark.parametrize("friction", [0.0, 0.142])
def test_a_flat_block_stands_on_the_crown_of_a_rail(spacing, friction):
    """Its only row of points on the crown leaves the roll free, which nothing turns."""
    body = block(supports=[mtb.Support("top", x=0.0, y=0.0)])
    rail = mtb.HalfSpace(mtb.steel, mtb.Profile.standard("60E1"))
    result = mtb.Scene(body, rail, spacing=spacing, friction=friction, magnetic_pressure=1e6).solve()
    assert result.force == pytest.approx([friction * 7200.0, 0.0, -7200.0], rel=1e-9, abs=1e-3)
    assert np.abs(result.pressure - result.pressure[::-1]).max() <= 1e-6 * result.pressure.max()


@pytest.mark.coarse
def test_a_force_that_balance_gives_is_known():
    """Whatever the mesh: load and friction coefficient alone make it; of a body that is held they do not."""
    free, held = (
        mtb.Scene(
            block(supports=[mtb.Support("top", x=0.0, y=0.0, z=z)]),
            mtb.steel,
            spacing=6e-3,
            friction=0.3,
            **load,
        ).solve()
        for z, load in ((None, {"force": 5e3}), (-1e-5, {}))
    )
    assert free.force == pytest.approx([1500.0, 0.0, -5000.0], rel=1e-9, abs=1e-6)
    assert free.report.error_estimates["force"] < 1e-9 < 1e-3 < free.report.error_estimates["pressure"]
    assert 1e-4 < held.report.error_estimates["force"] < 0.1
