# SPDX-License-Identifier: MIT OR Apache-2.0
"""Mistakes that a user is likely to make, each refused in a sentence that names what would be accepted."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import mtb_rs as mtb

steel = mtb.steel


def ball(**given: Any) -> mtb.Scene:
    return mtb.scenes.paraboloid_on_plane(points=8, **given)


def block(**given: Any) -> mtb.Scene:
    return mtb.scenes.block_on_plane(spacing=2e-2, **given)


def field(**given: Any) -> mtb.Scene:
    x = np.linspace(-1e-2, 1e-2, 7)
    gap = 5.0 * (x**2 + x[:, None] ** 2)
    return mtb.Scene(**{"lower": steel, "upper": steel, "gap": gap, "spacing": 1e-2 / 3.0, **given})


TABLE = mtb.VelocityTable((0.0, 10.0), (0.4, 0.2))

MISTAKES: dict[str, tuple[Callable[[], object], str]] = {
    "a material that is stiffer sideways": (
        lambda: mtb.Material(young_modulus=210e9, poisson_ratio=0.7),
        r"poisson_ratio is 0.7: it must lie in \(-1, 0.5\]",
    ),
    "nothing that deforms": (
        lambda: field(upper=mtb.Rigid(), lower=mtb.Rigid(), force=1.0),
        "upper and lower are both Rigid: one of them must deform",
    ),
    "no load": (field, "give exactly one of force"),
    "two loads": (lambda: field(force=1.0, approach=1e-6), "give exactly one of force"),
    "moments of an approach": (
        lambda: field(approach=1e-6, moments=(0.1, 0.0)),
        "moments are given beside approach: only a load can have them",
    ),
    "too few points": (
        lambda: mtb.scenes.paraboloid_on_plane(points=2),
        "points is 2: a whole number from 4",
    ),
    "a gap along a line": (lambda: field(gap=np.zeros(7), force=1.0), r"gap has shape \(7,\): \(ny, nx\)"),
    "no direction": (
        lambda: block(sliding_direction=(0.0, 0.0)).solve("half-space"),
        "sliding_direction is .*: two finite numbers, not both zero, are needed",
    ),
    "cells that nobody chooses": (
        lambda: block().with_(spacing=None).prepare("half-space"),
        r"spacing is None: only solve\(\)",
    ),
    "a tolerance above one": (
        lambda: block().solve(tolerance=2.0),
        "tolerance is 2.0: a number between 0 and 1",
    ),
    "increments of an approach": (
        lambda: field(approach=1e-6).solve(method="incremental"),
        'method is "incremental": it presses with a force, an approach is given',
    ),
    "increments of elastic bodies": (
        lambda: block().solve("elastic-upper", method="incremental"),
        'method is "incremental": it takes half-spaces',
    ),
    "a table without a velocity": (
        lambda: block(friction=TABLE).solve("half-space"),
        r"is a table over velocity: give velocity=... \[m/s\]",
    ),
    "a velocity beside its table": (
        lambda: block(friction=TABLE, velocity=20.0).solve("half-space"),
        "velocity is 20 m/s: the table covers 0 to 10 m/s",
    ),
    "a place in the plane": (
        lambda: ball().prepare("half-space", reference_point=(0.0, 0.0)),
        "reference_point is .*: three finite numbers",
    ),
    "a pose of three numbers": (
        lambda: ball().prepare("half-space").step(pose=(0.0, 0.0, -1e-6), velocity=1.0),
        r"pose is .*: six real numbers \(x, y, z, roll, pitch, yaw\) are needed",
    ),
    "a velocity in space": (
        lambda: ball(friction=0.1).prepare("half-space").step(velocity=(1.0, 0.0, 0.0)),
        r"velocity is .*: a number or \(vx, vy\) \[m/s\] is needed",
    ),
    "a velocity of nothing": (
        lambda: ball(friction=0.1).prepare("half-space").step(velocity=0.0),
        "velocity is 0: at rest friction has no direction; prepare with a standstill speed",
    ),
    "a magnet that is not there": (
        lambda: ball().prepare("half-space").step(velocity=1.0, magnetic_pressure=1e6),
        "magnetic_pressure is given, but the scene was prepared without one",
    ),
    "force and approach": (
        lambda: mtb.solve_normal(np.zeros((4, 4)), 1e-3, lower=steel, upper=steel, force=1.0, approach=1e-6),
        "either force or approach is needed",
    ),
    "a sweep over nothing": (
        lambda: mtb.sweep(block(), {}),
        "parameters is empty: at least one argument with its values is needed",
    ),
    "a sweep that repeats itself": (
        lambda: mtb.sweep(block(), {"friction": [0.1, 0.1]}),
        "has a value twice",
    ),
}


@pytest.mark.parametrize("name", MISTAKES)
def test_a_likely_mistake_is_refused_in_a_sentence(name: str) -> None:
    make, said = MISTAKES[name]
    with pytest.raises(ValueError, match=said):
        make()


@pytest.mark.parametrize("moments", [(0.0, 30.0), (-30.0, 0.0), (20.0, 20.0)])
@pytest.mark.parametrize("way", ["solve", "step", "start_of_sliding"])
def test_a_load_that_tips_the_body_over_is_refused_with_its_reason(
    way: str, moments: tuple[float, float]
) -> None:
    """A force of 1 kN on a face of 20 mm carries moments of 10 N m, about an axis along x or y."""
    scene = field(force=1e3, moments=moments)
    ways: dict[str, Callable[[], object]] = {
        "solve": lambda: scene.solve("half-space"),
        "step": lambda: scene.prepare("half-space").step(velocity=1.0),
        "start_of_sliding": lambda: scene.start_of_sliding([[1e-6, 0.0]], "half-space"),
    }
    with pytest.raises(mtb.ResultantError, match="outside"):
        ways[way]()
