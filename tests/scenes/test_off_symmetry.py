# SPDX-License-Identifier: MIT OR Apache-2.0
"""A shoe off its symmetry plane keeps its load, whatever the gap below it."""

from __future__ import annotations

import numpy as np
import pytest

import mtb_rs as mtb


@pytest.mark.parametrize(("lateral", "yaw"), [(0.0, 0.0), (2e-3, 0.0), (-2e-3, 0.0), (0.2e-3, 1e-3)])
def test_all_of_the_load_arrives(lateral: float, yaw: float) -> None:
    scene = mtb.scenes.pole_shoe_on_rail(height=20e-3, spacing=(6e-3, 5.2e-3), lateral=lateral, yaw=yaw)
    result = scene.solve(model="elastic-upper")
    strip = 2 * 0.09 * (21.6e-3 - 6e-3)
    assert -result.force[2] == pytest.approx(3e6 * strip, rel=2e-3)
    # each pole carries its own share
    vertical = result.pressure * result.area * result.normal[2]
    left, right = (float(patch.view(vertical).sum()) for patch in result.patches)
    assert left == pytest.approx(right, rel=0.01)


def test_mirrored_offsets_give_mirrored_poles() -> None:
    left, right = (
        mtb.scenes.pole_shoe_on_rail(height=20e-3, spacing=(6e-3, 5.2e-3), lateral=lateral).solve(
            model="elastic-upper"
        )
        for lateral in (1e-3, -1e-3)
    )
    # the diagonals of the two meshes differ, so by the error of the mesh, no more
    for own, twin in zip(left.patches, reversed(right.patches), strict=True):
        p, q = own.view(left.pressure), twin.view(right.pressure)[::-1]
        assert np.linalg.norm(p - q) < 0.03 * np.linalg.norm(p)
