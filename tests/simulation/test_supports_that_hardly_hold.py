# SPDX-License-Identifier: MIT OR Apache-2.0
"""A pole shoe on points, turned a little: its supports hardly hold its roll, and the contact does."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
import pytest

import mtb_rs as mtb

YAWS = (1e-3, 3e-3, 1e-2)


@lru_cache
def prepared(supports: str, yaw: float) -> mtb.PreparedContact:
    scene = mtb.scenes.pole_shoe_on_rail(friction=0.3, spacing=12e-3, supports=supports, yaw=yaw)
    return scene.prepare("elastic-upper")


def loads(contact: mtb.PreparedContact, z: float, velocity: float) -> tuple[float, float]:
    """Of the left pole and of the right one, at a height."""
    step = contact.copy().step([0.0, 0.0, z, 0.0, 0.0, 0.0], velocity)
    load, left = step.pressure * contact.area, contact.points[1] > 0.0
    return float(load[left].sum()), float(load[~left].sum())


@pytest.mark.parametrize("supports", ["points", "fixed-points"])
@pytest.mark.parametrize("yaw", YAWS)
def test_a_given_height_holds_both_poles(supports: str, yaw: float) -> None:
    """The loads hardly change with the yaw. Turned by 180 degrees the shoe is itself, but for the point that
    holds it along the rail."""
    contact = prepared(supports, yaw)
    assert contact.motions == prepared(supports, 0.0).motions
    for z in (0.0, -2e-7):
        (left, right), back = loads(contact, z, 1.0), loads(contact, z, -1.0)
        assert (left, right) == pytest.approx(back[::-1], rel=0.03)
        assert (left, right) == pytest.approx(loads(prepared(supports, YAWS[0]), z, 1.0), rel=0.03)
    assert loads(contact, -2e-7, 1.0) > loads(contact, 0.0, 1.0)
    assert loads(contact, 1e-5, 1.0) == (0.0, 0.0)


@pytest.mark.parametrize("supports", ["points", "fixed-points"])
@pytest.mark.parametrize("yaw", YAWS)
def test_points_stick_and_slip_as_it_is_pulled_on(supports: str, yaw: float) -> None:
    contact = prepared(supports, yaw).copy()
    forces = [contact.step(shift=3e-7).force for _ in range(20)]
    pulled = np.array([force[0] / -force[2] for force in forces])
    assert (np.diff(pulled) > -1e-4).all()
    assert pulled[0] < 0.15
    assert pulled[-1] == pytest.approx(0.3, rel=0.02)
    again = prepared(supports, yaw).copy()
    for _ in range(2):
        at_once = again.step(shift=3e-6).force
    assert at_once == pytest.approx(forces[-1], rel=0.02, abs=0.02 * np.abs(forces[-1]).max())
