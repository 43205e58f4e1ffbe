# SPDX-License-Identifier: MIT OR Apache-2.0
"""Stops of a vehicle, against laws of mechanics and a stop by hand."""

from __future__ import annotations

import numpy as np
import pytest

import mtb_rs as mtb


def shoe(**given: object) -> mtb.Scene:
    stated = {"friction": 0.1, "magnetic_pressure": 1e6, "spacing": 0.012, **given}
    return mtb.scenes.pole_shoe_on_rail(**stated)  # type: ignore[arg-type]


def test_a_constant_force_stops_as_galilei_has_it() -> None:
    stop = mtb.brake(shoe(), 20.0, 2000.0, 900.0, shares=(1.0, 0.5, 1.0))
    force = stop.forces[0]
    assert force[0] == pytest.approx(2.0 * force[1], rel=0.02)
    assert force[0] == force[2]
    total = force.sum() + 900.0
    assert stop.forces.sum(axis=1) + stop.other_force == pytest.approx(total, rel=1e-9)
    assert stop.time[-1] == pytest.approx(20.0 * 2000.0 / total, rel=1e-9)
    assert stop.way[-1] == pytest.approx(0.5 * 20.0**2 * 2000.0 / total, rel=1e-9)
    assert stop.speed[-1] == pytest.approx(0.0, abs=1e-8)
    assert abs(stop.open_energy) < 1e-9


def test_energy_and_mass_close_over_a_stop_with_all_effects() -> None:
    table = mtb.VelocityTable([0.0, 5.0, 30.0], [0.3, 0.2, 0.1])
    stop = mtb.brake(
        shoe(friction=table), 25.0, 3000.0, lambda v: 500.0 + 10.0 * v, shares=(1.0, 1.0), tolerance=0.2,
        expansion=True, wear=1e-12, lower_wear=1e-12, resistance=2e-5, share=0.0,
        fading=([0.0, 200.0], [1.0, 0.8]),
    )  # fmt: skip
    assert abs(stop.open_energy) < 1e-8
    one = stop.shoes[0]
    assert one.heats_upper + one.heats_lower == pytest.approx(one.friction_powers, rel=1e-12)
    steps = np.diff(stop.time)
    assert one.stored[-1] == pytest.approx(float((one.heats_upper - one.losses) @ steps), rel=1e-10)
    # as much is worn off both, if both wear alike
    upper, lower = stop.worn_volume
    assert upper == pytest.approx(lower, rel=1e-12)
    # forces follow the table, a little faded
    mu = stop.forces[:, 0] / np.abs(one.forces[:, 2])
    assert mu[0] == pytest.approx(np.interp(25.0, table.velocity, table.value), rel=0.02)
    assert mu[-1] > 2.0 * mu[0]
    assert "hottest contact" in dict(stop.told())


def test_a_stop_converges_with_its_tolerance() -> None:
    table = mtb.VelocityTable([0.0, 30.0], [0.3, 0.1])
    tolerances = np.array([0.2, 0.05, 0.0125])
    times = [
        mtb.brake(shoe(friction=table), 25.0, 3000.0, tolerance=float(tolerance)).time[-1]
        for tolerance in tolerances
    ]
    # m dv/dt = -N (0.3 - v / 150)
    normal = 3000.0 * 25.0
    force = -float(shoe().solve(model="elastic-upper").force[2])
    exact = normal / force / 25.0 * 150.0 * np.log(0.3 / (0.3 - 25.0 / 150.0))
    errors = np.abs(np.array(times) / exact - 1.0)
    assert errors[2] < errors[1] < errors[0]
    assert np.all(errors < tolerances)


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"scene": 3}, "a Scene that slides is needed"),
        ({"speed": 0.0}, "speed is 0"),
        ({"mass": -1.0}, "mass is -1"),
        ({"other_force": -5.0}, "other_force is -5 N"),
        ({"shares": ()}, "a positive number for each shoe"),
        ({"shares": (1.0, -1.0)}, "a positive number for each shoe"),
        ({"tolerance": 1.0}, "tolerance is 1"),
        ({"duration": 3.0}, "follow from the stop"),
        ({"shares": 1.0}, "a positive number for each shoe"),
        ({"shares": "all"}, "shares is 'all': real numbers"),
        ({"resistence": 1e-5}, "resistence is no argument of brake: did you mean resistance"),
        ({"other_force": lambda: 1.0}, "a force .N. or a function of the speed"),
    ],
)
def test_bad_input_is_refused(given: dict[str, object], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        mtb.brake(**{"scene": shoe(), "speed": 10.0, "mass": 1e3, **given})  # type: ignore[arg-type]


def test_nothing_that_brakes_is_said() -> None:
    with pytest.raises(mtb.ConvergenceError, match="nothing brakes"):
        mtb.brake(shoe(friction=0.0), 10.0, 1e3)
    with pytest.raises(ValueError, match="magnetic_pressure is None"):
        mtb.brake(mtb.scenes.paraboloid_on_plane(points=8), 10.0, 1e3)
