# SPDX-License-Identifier: MIT OR Apache-2.0
"""A flat round punch on a half-space [Johnson1985, 3.34-3.36]: a face that cuts the hats of its grid."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh

import mtb_rs as mtb

RADIUS, FORCE = 0.02, 1e4


@pytest.mark.coarse
@pytest.mark.filterwarnings("ignore:young_modulus of the upper body")
def test_a_rigid_round_punch() -> None:
    pytest.importorskip("gmsh")
    cylinder = trimesh.creation.cylinder(radius=RADIUS, height=0.02, sections=96)
    punch = mtb.ElasticBody.from_mesh(
        cylinder.apply_translation((0.0, 0.0, 0.01)),
        mtb.Material(1e7 * mtb.steel.young_modulus, 0.3),
        supports=[mtb.Support("top", x=0, y=0, z=mtb.Guide())],
        size=3e-3,
    )
    sunk = FORCE / (2.0 * mtb.steel.plane_strain_modulus * RADIUS)
    errors = []
    for spacing in (5e-3, 2.5e-3):
        result = mtb.Scene(punch, mtb.steel, spacing=spacing, friction=0.0, force=FORCE).solve()
        moved = -result.states()["body"].displacement[2]
        # first order in the spacing: the pressure is infinite at the edge
        assert moved.mean() == pytest.approx(sunk, rel=2.5 * spacing)
        distance = np.hypot(result.points[0], result.points[1]) / RADIUS
        inside = distance < 0.7
        exact = FORCE / (2.0 * np.pi * RADIUS**2 * np.sqrt(1.0 - distance[inside] ** 2))
        errors.append(float(np.abs(result.pressure[inside] / exact - 1.0).mean()))
    assert errors[0] < 0.06
    assert errors[1] < 0.6 * errors[0]
