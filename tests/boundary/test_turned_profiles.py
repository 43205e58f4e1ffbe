# SPDX-License-Identifier: MIT OR Apache-2.0
"""Profiles of wheels and rails that look turned over, mirrored or swapped are asked about."""

from __future__ import annotations

import re
from typing import Any

import numpy as np
import pytest

import mtb_rs as mtb
from mtb_rs.base.questions import gathered
from mtb_rs.geometry.profiles import of_shape

WHEEL, RAIL = mtb.Profile.standard("S1002"), mtb.Profile.standard("60E1")


def turned(profile: mtb.Profile, across: float, up: float, **given: Any) -> mtb.Profile:
    y = np.linspace(*profile.range, 801)[2:-2]
    return mtb.Profile.from_points(across * y, up * profile.height(y), "linear", **given)


MIRRORED, UPSIDE_DOWN = turned(WHEEL, -1.0, 1.0), turned(WHEEL, 1.0, -1.0)


@pytest.mark.parametrize(
    ("wheel", "rail", "said"),
    [
        (MIRRORED, RAIL, "goes down by .* at y > 0, the field side: .* looks mirrored"),
        (UPSIDE_DOWN, RAIL, "rises by .* beside the tape circle.* looks upside down.* z_axis"),
        (turned(WHEEL, -1.0, -1.0), RAIL, "the wheel profile rises by .* upside down"),
        (WHEEL, turned(RAIL, 1.0, -1.0), "the rail profile rises by .* upside down"),
        (RAIL, WHEEL, "wheel and rail look swapped"),
    ],
)
def test_what_looks_turned_is_asked_about(wheel: mtb.Profile, rail: mtb.Profile, said: str) -> None:
    with gathered() as asked:
        try:
            mtb.scenes.wheel_on_rail(wheel, rail, lateral=0.0, force=60e3, spacing=0.4e-3)
        except ValueError as refused:
            asked.append(str(refused))
    assert any(re.search(said, question) for question in asked), asked


def test_usual_profiles_are_not() -> None:
    wheels = [WHEEL, turned(WHEEL, 1.0, 1.0), mtb.Profile.from_points([-0.06, 0.06], [-6e-3, 6e-3], "linear")]
    rails = [RAIL, turned(RAIL, -1.0, 1.0), mtb.Profile.from_points([-0.03, 0.03], [0.0, 0.0], "linear")]
    for wheel in wheels:
        for rail in rails:
            assert of_shape(wheel, rail) == []


@pytest.mark.parametrize("z_axis", ["down", "guess"])
def test_points_take_the_direction_of_z(z_axis: Any) -> None:
    y = np.linspace(-0.05, 0.05, 7)
    assert turned(WHEEL, 1.0, -1.0, z_axis=z_axis).height(y) == pytest.approx(WHEEL.height(y), abs=2e-5)
    # what points up already is not turned by a guess
    up = turned(WHEEL, 1.0, 1.0, z_axis="guess" if z_axis == "guess" else "up")
    assert up.height(y) == pytest.approx(WHEEL.height(y), abs=2e-5)
    with pytest.raises(ValueError, match="z_axis"):
        turned(WHEEL, 1.0, 1.0, z_axis="sideways")


@pytest.mark.parametrize(
    ("given", "named"),
    [
        ({"gauge": 1435.0}, r"gauge = 1435 m"),
        ({"lateral": 3.0}, r"lateral = 3 m"),
        ({"flange_back": 1e3}, "1000 m"),
    ],
)
def test_a_wheel_beside_its_rail_names_the_lengths(given: dict[str, float], named: str) -> None:
    with pytest.raises(ValueError, match=rf"nowhere above the head.*{named}.*Lengths are in metres"):
        mtb.scenes.wheel_on_rail(**{"lateral": 0.0, "force": 60e3, "spacing": 0.4e-3} | given)
