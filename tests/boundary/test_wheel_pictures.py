# SPDX-License-Identifier: MIT OR Apache-2.0
"""Pictures of wheels: the bodies that are drawn are those of the gap, patches are drawn to one scale."""

import numpy as np
import pytest

import mtb_rs as mtb


@pytest.mark.parametrize("lateral", [0.0, 6.2e-3])
def test_wheel_and_rail_are_drawn_where_they_are(lateral):
    geometry = mtb.scenes.wheel_on_rail(lateral=lateral, spacing=5e-4).geometry
    rail, wheel = geometry.surfaces()
    assert (rail.name, wheel.name) == ("lower rail", "upper wheel")
    place = geometry.placement
    sides = []
    for surface in (rail, wheel):
        x, y, z = surface.vertices
        # the side that faces the other body, in the middle
        middle = np.abs(x) < 1e-9
        half = middle.sum() // 2
        sides.append((y[middle][:half], z[middle][:half]))
    below, above = (np.interp(place.y, y, z) for y, z in sides)
    column = place.gap[:, int(np.abs(place.x).argmin())]
    # drawn as it touches first, the gap as it has come down along the normal: some 20 um further across
    np.testing.assert_allclose(above - below, column, atol=1e-5)


def test_patches_are_drawn_to_one_scale():
    wheels = mtb.scenes.wheel_on_rail(lateral=0.0, force=60e3, spacing=1e-3).prepare(side="both")
    step = wheels.step((0.0, 2e-3, np.nan, np.nan, 0.0, 1e-3), 30.0)
    for quantity, keys in (("pressure", 1), ("traction", 1), ("status", 0)):
        figure = step.plot(quantity)
        panels, others = figure.axes[:2], figure.axes[2:]
        assert len(others) == keys
        assert all("wheel, plane at" in panel.get_title(loc="left") for panel in panels)
        spans = [(np.ptp(panel.get_xlim()), np.ptp(panel.get_ylim())) for panel in panels]
        assert spans[0] == pytest.approx(spans[1])
        for panel, patch in zip(panels, step.patches, strict=True):
            x, y = (1e3 * line for line in np.meshgrid(patch.x, patch.y))
            closed = patch.status > 0
            for values, (low, high) in ((x, panel.get_xlim()), (y, panel.get_ylim())):
                assert low < values[closed].min()
                assert values[closed].max() < high
    assert len(step.plot("pressure", kind="line").axes) == 2
