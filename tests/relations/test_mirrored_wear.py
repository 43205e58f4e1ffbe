# SPDX-License-Identifier: MIT OR Apache-2.0
"""A symmetric scene wears as one that is a nanometre aside, which no mirror knows: the half may not show."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import mtb_rs as mtb

#: Too little to be seen, and too much for a mirror image [m].
ASIDE = 1e-9


def shoe(**given: Any) -> mtb.Scene:
    return mtb.scenes.pole_shoe_on_rail(**{"friction": 0.2, "velocity": 20.0, "spacing": 10e-3} | given)


def at_distance(worn: mtb.WearResult, distance: float) -> list[float]:
    """Mean depth [m] of the left and of the right pole after a distance [m]."""
    last = int(np.argmin(np.abs(worn.distance - distance)))
    left = worn.points[1] > 0.0
    return [float(worn.depths[0, last][own].mean()) for own in (left, ~left)]


@pytest.mark.parametrize("model", ["half-space", "elastic-upper"])
def test_an_even_part_of_a_duty_keeps_what_an_uneven_one_has_worn(model: Any) -> None:
    uneven = mtb.Passages(100.0, 1, {"magnetic_pressure": [3e6, 0.5e6]})
    for even in (1e-3, 100.0):
        centred, aside = (
            mtb.wear(shoe(lateral=y), [uneven, mtb.Passages(even, 1)], 1e-13, 1e-13, model=model)
            for y in (0.0, ASIDE)
        )
        for distance in (100.0, 100.0 + even):
            assert at_distance(centred, distance) == pytest.approx(at_distance(aside, distance), rel=1e-3)
        # the mean of the left pole by Archard's law, and of the right one under a sixth of the pull before
        assert at_distance(centred, 100.0 + even) == pytest.approx(
            [1e-13 * 3e6 * (100.0 + even), 1e-13 * (0.5e6 * 100.0 + 3e6 * even)], rel=2e-3
        )
