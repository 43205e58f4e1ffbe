# SPDX-License-Identifier: MIT OR Apache-2.0
"""A worn pole shoe drawn in CAD touches its rail where the ready one does."""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

import mtb_rs as mtb
from mtb_rs.geometry import PoleShoe
from mtb_rs.mesher import gmsh_beside

pytest.importorskip("gmsh", exc_type=ImportError)

LENGTH, SPACING, PULL, FRICTION = 40e-3, 4e-3, 3e6, 0.3


def drawn(path: Path, shoe: PoleShoe, cuts: tuple[float, ...]) -> Path:
    """One pole as a STEP solid [mm]: its sole is a spline through 60 points, one between two `cuts` [m]."""
    stations = np.unique(np.concatenate([np.linspace(shoe.inner_edge, shoe.conforming_to, 60), cuts]))
    end = shoe.outer_edge
    corners = [(end, float(shoe.sole(end))), (end, shoe.height), (shoe.inner_edge, shoe.height)]
    with gmsh_beside() as gmsh:
        occ = gmsh.model.occ

        def point(y: float, z: float) -> int:
            return occ.addPoint(-0.5e3 * shoe.length, 1e3 * y, 1e3 * z)

        sole = [point(y, float(shoe.sole(y))) for y in stations]
        ring = [sole[-1], *(point(*corner) for corner in corners), sole[0]]
        ends = [0, *np.searchsorted(stations, cuts).tolist(), stations.size - 1]
        lines = [occ.addSpline(sole[a : b + 1]) for a, b in pairwise(ends)]
        lines += [occ.addLine(a, b) for a, b in pairwise(ring)]
        occ.extrude([(2, occ.addPlaneSurface([occ.addCurveLoop(lines)]))], 1e3 * shoe.length, 0.0, 0.0)
        occ.synchronize()
        gmsh.write(str(path))
    return path


def on_rail(path: Path, shoe: PoleShoe, size: float) -> mtb.Scene:
    """The solid on the rail that it is worn to."""

    def sole(points: np.ndarray) -> np.ndarray:
        _, y, z = points
        return (y < shoe.conforming_to + 1e-7) & (z < shoe.sole(y) + 2e-6)

    def top(points: np.ndarray) -> np.ndarray:
        return points[2] > shoe.height - 1e-7

    body = mtb.ElasticBody.from_mesh(
        path, mtb.steel, contact=sole, supports=[mtb.Support(top, x=0, y=0)], size=size, name="pole"
    )
    rail = mtb.HalfSpace(mtb.steel, shoe.profile)
    return mtb.Scene(body, rail, spacing=SPACING, friction=FRICTION, magnetic_pressure=PULL)


@pytest.mark.parametrize(("worn", "size"), [(False, 4e-3), (True, 2e-3)])
@pytest.mark.filterwarnings("ignore::mtb_rs.ToleranceWarning")
def test_a_sole_of_cad_touches_all_over(worn: bool, size: float, tmp_path: Path) -> None:
    """New: the arcs of the rail, and a face of the sole for each. Worn: one spline that turns ever more."""
    rail = mtb.Profile.standard("60E1")
    if worn:
        y = np.linspace(-36e-3, 36e-3, 145)
        rail = mtb.Profile.from_points(y, -(y**2) / 0.3 - 1e-4 * (y / 0.02) ** 4)
    shoe = PoleShoe(length=LENGTH, poles=1, rail=rail)
    arcs = rail.breaks[(rail.breaks > shoe.inner_edge) & (rail.breaks < shoe.conforming_to)].tolist()
    cuts = () if worn else tuple(arcs)
    assert worn or len(cuts) == 1
    own = on_rail(drawn(tmp_path / "pole.step", shoe, cuts), shoe, size).solve()
    ready = mtb.scenes.pole_shoe_on_rail(
        length=LENGTH, poles=1, rail=rail, friction=FRICTION, magnetic_pressure=PULL, spacing=SPACING
    ).solve("elastic-upper")
    fields = [np.asarray(r.patches[0].view(np.ravel(r.pressure))) for r in (own, ready)]
    assert fields[0].shape == fields[1].shape
    # all but a point or two at the edge that lifts
    assert ((fields[0] > 0.0) != (fields[1] > 0.0)).mean() < 0.05
    assert own.report.contact_area == pytest.approx(ready.report.contact_area, rel=0.05)
    # the ready one is pulled along the normals of the rail, which the sole meets at up to 10 degrees
    inner = [field[1:-1, 1:-1] for field in fields]
    np.testing.assert_allclose(np.linalg.norm(inner[0] - inner[1]) / np.linalg.norm(inner[1]), 0.0, atol=0.05)
