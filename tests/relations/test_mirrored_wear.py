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


def severe_on_the_right(rubbing: Any) -> Any:
    """Severe wear above 1 MPa, where the right pole is softer: even under any lower pressure."""
    return np.where((rubbing.points[1] < 0.0) & (rubbing.pressure > 1e6), 1e-12, 1e-14)


@pytest.mark.parametrize("model", ["half-space", "elastic-upper", "elastic-both"])
@pytest.mark.parametrize("body", ["upper", "lower"])
def test_a_law_that_is_uneven_only_under_pressure_wears_unevenly(model: Any, body: str) -> None:
    scene = shoe()
    laws = (severe_on_the_right, 1e-14) if body == "upper" else (1e-14, severe_on_the_right)
    found = [mtb.wear(own, 1.0, *laws, model=model) for own in (scene, scene.with_(lateral=ASIDE))]
    found.append(mtb.wear(scene.prepare(model), 1.0, *laws))
    centred, *others = (worn.depths[:, -1] for worn in found)
    for other in others:
        np.testing.assert_allclose(centred, other, rtol=0.0, atol=1e-3 * centred.max())
    right, side = found[0].points[1] < 0.0, 0 if body == "upper" else 1
    assert centred[side, right].max() > 5.0 * centred[side, ~right].max()


def softer_once_worn_in(rubbing: Any) -> Any:
    """Faster in the middle of the right pole, under pressures that the middle of new poles does not have."""
    x, y = rubbing.points[:2]
    faster = 2.0 * np.clip((rubbing.pressure - 2.8e6) / 1e6, 0.0, 1.0)
    return 1e-13 * (1.0 + np.where((y < 0.0) & (np.abs(x) < 20e-3), faster, 0.0))


def test_a_wear_that_becomes_uneven_goes_on_unevenly() -> None:
    centred, aside = (
        mtb.wear(shoe(lateral=y), 200.0, softer_once_worn_in, 1e-14, model="half-space") for y in (0.0, ASIDE)
    )
    left = centred.points[1] > 0.0
    apart = np.abs(centred.depths[0][:, left].sum(axis=1) - centred.depths[0][:, ~left].sum(axis=1))
    even = int(np.argmax(apart > 1e-9 * apart.max()))
    assert 1 < even < centred.distance.size - 2
    np.testing.assert_allclose(
        centred.depths[:, -1], aside.depths[:, -1], rtol=0.0, atol=1e-3 * aside.depth[0, -1]
    )


@pytest.mark.parametrize("model", ["half-space", "elastic-upper", "elastic-both"])
def test_a_gap_that_is_uneven_presses_as_in_a_step(model: Any) -> None:
    """With next to no wear the contact is that of the prepared one with the same gap, before and after."""
    scene = shoe(spacing=12e-3)
    prepared = scene.prepare(model)
    x, y = prepared.points[:2]
    gap = np.where(y < 0.0, 2e-6 * (x / 45e-3) ** 2, 0.0)
    step = prepared.step(gap=gap)
    found = mtb.wear(scene, 1e-3, 1e-20, model=model, gap=gap)
    np.testing.assert_allclose(found.pressures[0], step.pressure, rtol=0.0, atol=1e-6 * step.pressure.max())
    assert found.final is not None
    np.testing.assert_allclose(found.final.pressure, step.pressure, rtol=0.0, atol=1e-6 * step.pressure.max())
