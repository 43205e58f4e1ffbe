# SPDX-License-Identifier: MIT OR Apache-2.0
"""What one way of asking refuses, its neighbours refuse or ask about."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import mtb_rs as mtb

CELL = 2.5e-4
X, Y = np.meshgrid(*[np.linspace(-10e-3, 10e-3, 81)] * 2)


@pytest.mark.parametrize("method", ["kpec", "analyn"])
@pytest.mark.parametrize("ahead", [True, False])
def test_two_places_ahead_of_each_other_are_refused_as_those_beside(method: Any, ahead: bool) -> None:
    along, across = (X, Y) if ahead else (Y, X)
    gap = np.minimum((along - 5e-3) ** 2, (along + 5e-3) ** 2) / 0.6 + across**2 / 0.6
    with pytest.raises(ValueError, match="meet in more than one place"):
        mtb.solve_normal(gap, CELL, lower=mtb.steel, upper=mtb.steel, force=2e4, method=method)
    one = (X**2 + Y**2) / 0.6
    found = mtb.solve_normal(one, CELL, lower=mtb.steel, upper=mtb.steel, force=2e3, method=method)
    assert found.normal_force == pytest.approx(2e3, rel=1e-6)


def test_steady_slip_is_measured_within_the_contact() -> None:
    patch = mtb.hertz(500.0, 0.015, lower=mtb.steel, upper=mtb.steel).on_grid((48, 48), 2e-5)
    law = mtb.Coulomb(0.3)
    for angle in (0.0, 0.7, np.pi / 2):
        with pytest.raises(ValueError, match="at most the length of the contact"):
            mtb.solve_tangential(patch, mtb.Rolling((1e-4, 0, 0), step=2e-3, angle=angle), law)
        found = mtb.solve_tangential(patch, mtb.Rolling((1e-4, 0, 0), step=1e-4, angle=angle), law)
        assert found.report.converged


def test_the_start_of_sliding_without_friction_is_without_force() -> None:
    scene = mtb.scenes.block_on_plane(spacing=2e-2, supports="driven-top", friction=0.0)
    found = scene.start_of_sliding([[1e-7, 0.0]], "elastic-upper")
    assert np.abs(found.force).max() < 1e-12 * found.normal_force[-1]
    assert found.path_error[-1] < 1e-12


@pytest.mark.parametrize("load", [{"axle_moment": 0.0}, {"longitudinal_force": 500.0}])
def test_a_rotation_is_not_found_from_a_point_on_the_rail(load: dict[str, float]) -> None:
    scene = mtb.scenes.wheel_on_rail(lateral=0.0, force=6e4, spacing=1e-3)
    pose = (0, 0, np.nan, np.nan, 0, 0)
    low = scene.prepare(side="both", reference_point=(0.0, 0.0, 1e-3))
    with pytest.raises(ValueError, match="height of reference_point above the rail"):
        low.step(pose, 20.0, **load)
    found = scene.prepare(side="both").step(pose, 20.0, **load)
    assert found.velocity[4] == pytest.approx(20.0 / 0.46, rel=1e-2)
    # where the rotation is given the point is any
    assert low.step(pose, (20.0, 0, 0, 0, 43.4, 0)).velocity[4] == 43.4


def test_gaps_of_wear_are_as_small_as_those_of_steps() -> None:
    scene = mtb.scenes.pole_shoe_on_rail(friction=0.2, spacing=12e-3, velocity=10.0)
    gap = np.zeros(scene.solve("elastic-upper").pressure.size)
    gap[3] = 1e4
    with pytest.raises(ValueError, match=r"gap\[3\] is 10000 m: numbers from -1000 to 1000 m"):
        mtb.wear(scene, 1.0, 1e-13, gap=gap, model="elastic-upper")


@pytest.mark.parametrize("quick", [mtb.fastsim, mtb.fastrip, mtb.polach])
def test_quick_forces_ask_about_surfaces_that_turn(quick: Any) -> None:
    y = (np.arange(41) - 20) * 4e-4
    gap = (y[None] ** 2 + y[:, None] ** 2) / 0.6
    for most, asks in ((0.4, True), (0.02, False)):
        normal = mtb.solve_normal(
            gap, 4e-4, lower=mtb.steel, upper=mtb.steel, force=2e4, inclination=most * y / y[-1]
        )
        arguments = (normal, (1e-3, 0.0, 0.0), mtb.Coulomb(0.3))
        if asks:
            with pytest.warns(UserWarning, match="the surface turns by 1"):
                quick(*arguments)
        else:
            quick(*arguments)


def test_what_quick_pressures_and_standing_wheels_lack_is_told() -> None:
    quick = mtb.solve_normal(
        (X**2 + Y**2) / 0.6, CELL, lower=mtb.steel, upper=mtb.steel, force=2e3, method="kpec"
    )
    with pytest.raises(ValueError, match="approximation by 'kpec', of which no derivatives are known"):
        quick.derivative("approach", "force")
    wheels = mtb.scenes.wheel_on_rail(spacing=1e-3).prepare()
    pose = (0, 0, np.nan, 0, 0, 0)
    patch = wheels.step(pose, 20.0).patches[0]
    assert patch.stress(depths=[1e-3]).way == 0.0
    assert wheels.step(pose, -20.0).patches[0].stress(depths=[1e-3]).way == np.pi
    still = wheels.step(pose, (0, 0, 0, 0, 0, 0), dt=1e-3, transient=True).patches[0]
    with pytest.raises(ValueError, match="the contact stands still at this step"):
        still.temperature()
