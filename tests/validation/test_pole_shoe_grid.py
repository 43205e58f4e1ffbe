# SPDX-License-Identifier: MIT OR Apache-2.0
"""The contact points of the pole shoe: they fill the conforming strip, and measure true gaps off centre."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import brentq

from mtb_rs.geometry.pole_shoe import PoleShoe
from mtb_rs.geometry.profiles import Profile

RAIL = Profile.standard("60E1")


@pytest.mark.parametrize("spacing", [6e-3, 3e-3, (1.5e-3, 2e-3), 0.5])
def test_cells_fill_the_strip_exactly(spacing: float | tuple[float, float]) -> None:
    shoe = PoleShoe()
    grid = shoe.grid(spacing)
    width = float(RAIL.arc_length(21.6e-3) - RAIL.arc_length(6e-3))
    assert grid.area.sum() == pytest.approx(2 * 90e-3 * width, rel=1e-13)
    dx, ds = np.broadcast_to(spacing, 2)
    left, right = grid.patches
    assert (left.name, left.nx, left.ny) == ("left", max(1, round(90e-3 / dx)), max(1, round(width / ds)))
    assert right.start == left.nx * left.ny
    # left first, x fastest, s rising; nodes run from edge to edge
    x, y = left.view(grid.points)[:2]
    assert np.all(np.diff(x, axis=1) > 0) or left.nx == 1
    assert np.all(y > 0)
    for patch, node_patch in zip(grid.patches, grid.node_patches, strict=True):
        nodes = node_patch.view(grid.nodes.points)
        assert np.allclose(nodes[0, :, [0, -1]], [[-45e-3], [45e-3]], atol=1e-16)
        edges = np.sort(np.abs(nodes[1, [0, -1], 0]))
        assert np.allclose(edges, [6e-3, 21.6e-3], atol=1e-15)
        assert np.all(np.diff(patch.view(grid.cells.arc_length), axis=0) > 0)
    assert np.allclose(np.diff(left.view(grid.cells.arc_length), axis=0), grid.spacing[1], atol=1e-15)


def test_centred_shoe_conforms_and_is_mirrored() -> None:
    grid = PoleShoe().grid(3e-3)
    assert np.all(grid.gap == 0.0)
    assert np.all(grid.nodes.gap == 0.0)
    left, right = (patch.view(grid.points) for patch in grid.patches)
    assert np.allclose(left[1], -right[1, ::-1], atol=1e-16)
    assert np.allclose(left[2], RAIL.height(left[1]), atol=1e-16)
    n, t1, t2 = grid.cells.normal, grid.cells.tangent_x, grid.cells.tangent_y
    assert np.allclose(np.cross(t1.T, t2.T).T, n, atol=1e-15)
    assert np.all(n[2] > 0)
    one = PoleShoe(poles=1).grid(3e-3)
    assert np.array_equal(one.points, grid.points[:, : one.area.size])


@settings(max_examples=15, deadline=None)
@given(lateral=st.floats(-4e-3, 4e-3), yaw=st.floats(-0.02, 0.02))
def test_gap_off_centre_is_the_distance_along_the_normal(lateral: float, yaw: float) -> None:
    shoe = PoleShoe(lateral=lateral, yaw=yaw)
    grid = shoe.grid(9e-3)
    for patch, node_patch in zip(grid.patches, grid.node_patches, strict=True):
        # every pole just touches, in a cell centre or at a corner of a cell
        gaps = [patch.view(grid.gap).ravel(), node_patch.view(grid.nodes.gap).ravel()]
        assert np.concatenate(gaps).min() == pytest.approx(0.0, abs=1e-15)
        points = node_patch.view(grid.nodes.points).reshape(3, -1)
        heights = sole(shoe, points[0], points[1])
        cells = patch.view(grid.points).reshape(3, -1)
        drop = min((heights - points[2]).min(), (sole(shoe, cells[0], cells[1]) - cells[2]).min())
        normals = patch.view(grid.normal).reshape(3, -1)
        for point, normal, gap in list(zip(cells.T, normals.T, gaps[0], strict=True))[::7]:
            exact = brentq(clearance, -1e-4, 3e-3, args=(shoe, drop, point, normal), xtol=1e-16)
            assert gap == pytest.approx(exact, abs=1e-13)


def clearance(t: float, shoe: PoleShoe, drop: float, point: np.ndarray, normal: np.ndarray) -> float:
    """Vertical distance of the lowered sole from the point `t` along a normal."""
    x, y, z = point + t * normal
    return float(sole(shoe, x, y) - drop - z)


def sole(shoe: PoleShoe, x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Height of the sole in the common frame."""
    return shoe.sole(-np.sin(shoe.yaw) * x + np.cos(shoe.yaw) * (y - shoe.lateral))


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"inner_edge": 22e-3}, "conforming_to is 0.0216: it must lie beyond inner_edge = 0.022 m"),
        ({"outer_edge": 20e-3}, "outer_edge is 0.02"),
        ({"inner_edge": -1e-3}, "inner_edge is -0.001"),
        ({"conforming_to": 40e-3, "outer_edge": 50e-3}, "the head of the rail ends"),
        ({"lateral": 20e-3}, "beyond the head of the rail"),
        ({"yaw": float("nan")}, "yaw is nan"),
        ({"length": float("inf")}, "length is inf"),
        ({"length": 0.0}, "length is 0"),
        ({"height": -1e-3}, "height is -0.001"),
        ({"relief_slope": -1.0}, "relief_slope is -1"),
        ({"poles": 3}, "poles is 3"),
        ({"rail": "49E1"}, "49E1"),
    ],
)
def test_bad_shoes_are_named(changes: dict[str, object], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        PoleShoe(**changes).grid(3e-3)  # type: ignore[arg-type]


@pytest.mark.parametrize("spacing", [0.0, -1e-3, float("nan"), (1e-3, 0.0), (1, 2, 3), "fine", 1e-9])
def test_bad_spacing_is_named(spacing: object) -> None:
    with pytest.raises(ValueError, match="spacing"):
        PoleShoe().grid(spacing)  # type: ignore[arg-type]
