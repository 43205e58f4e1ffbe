# SPDX-License-Identifier: MIT OR Apache-2.0
"""Wear over many stops, against all of them computed one after the other."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import mtb_rs as mtb
from mtb_rs.scenes.heating import HeatedScene
from mtb_rs.studies.brake import Ride, posed_shoe
from mtb_rs.studies.sweep_checkpoint import StepCheckpoint

SPEED, MASS, COUNT = 20.0, 2000.0, 12
STEPS = 0.3


def shoe(**given: Any) -> mtb.Scene:
    table = mtb.VelocityTable([0.0, 5.0, 30.0], [0.3, 0.2, 0.1])
    stated = {"spacing": (12e-3, 5.2e-3), "friction": table, "magnetic_pressure": 1e6, "poles": 1}
    return mtb.scenes.pole_shoe_on_rail(**{**stated, **given})


def one_by_one(scene: mtb.Scene, **heat: Any) -> tuple[np.ndarray, np.ndarray]:
    """Depth (n,) worn off by all stops, each computed in full, and the way of each."""
    posed, stated, pulls = posed_shoe(scene, SPEED, MASS, tolerance=STEPS, **heat)
    cold = HeatedScene.of(posed, *stated)
    worn, ways = np.zeros(cold.problem.n), []
    for _ in range(COUNT):
        nothing = StepCheckpoint(None, [], "stop", "")
        ride = Ride(cold, SPEED, MASS, 0.0, pulls, STEPS, nothing, [worn])
        ride.run(lambda _: None)
        worn = worn + ride.sliding[0].worn
        ways.append(ride.way[-1])
    return worn, np.array(ways)


def size(result: mtb.WearResult, field: np.ndarray) -> float:
    return float(np.sqrt(result.area @ field**2))


@pytest.mark.slow
def test_few_stops_wear_as_all_of_them() -> None:
    exact, _ = one_by_one(shoe(), wear=1e-16)
    errors, computed = [], []
    tolerances = (0.05, 0.002)
    for tolerance in tolerances:
        (found,) = mtb.wear_of_stops(
            shoe(), SPEED, MASS, COUNT, wear=1e-16, tolerance=tolerance, stop_tolerance=STEPS
        )
        depths = found.depths[0]
        errors.append(size(found, depths[-1] - exact) / size(found, exact))
        # what the errors of the rows come to, each in parts of its step and a tenth of all
        parts = [
            error * (size(found, depths[k] - depths[k - 1]) + 0.1 * size(found, depths[k]))
            for k, error in enumerate(found.errors)
            if k
        ]
        assert errors[-1] < sum(parts) / size(found, exact) < tolerance
        computed.append(int(found.solves.sum()))
    assert computed[0] <= 5
    assert computed[0] < computed[1] < COUNT
    # at least of first order in the tolerance
    assert np.log(errors[0] / errors[1]) / np.log(tolerances[0] / tolerances[1]) > 0.9


@pytest.mark.slow
def test_few_stops_of_a_magnet_that_follows_the_gap_wear_as_all_of_them() -> None:
    scene = shoe(magnetic_pressure=mtb.Magnet(1500.0, 2e-4))
    exact, _ = one_by_one(scene, wear=1e-16)
    (found,) = mtb.wear_of_stops(scene, SPEED, MASS, COUNT, wear=1e-16, tolerance=0.05, stop_tolerance=STEPS)
    depths = found.depths[0]
    parts = [
        error * (size(found, depths[k] - depths[k - 1]) + 0.1 * size(found, depths[k]))
        for k, error in enumerate(found.errors)
        if k
    ]
    assert size(found, depths[-1] - exact) < sum(parts) < 0.05 * size(found, exact)
    assert found.solves.sum() <= 5
    worn = np.diff(found.worn_volume[0])
    assert worn == pytest.approx(1e-16 * found.steps[1:] * (found.unknowns[1:] @ found.area), rel=1e-12)


@pytest.mark.slow
def test_the_volume_is_that_of_the_law() -> None:
    (found,) = mtb.wear_of_stops(shoe(friction=0.1), 5.0, MASS, 200, wear=1e-14, stop_tolerance=0.5)
    # whatever its shape, the contact bears the pull
    assert found.forces[:, 2] == pytest.approx(np.full(len(found.steps), found.forces[0, 2]), rel=1e-8)
    assert found.steps.sum() == pytest.approx(found.distance[-1], rel=1e-14)
    worn = np.diff(found.worn_volume[0])
    own = 1e-14 * found.steps[1:] * (found.unknowns[1:] @ found.area)
    assert worn == pytest.approx(own, rel=1e-12)
    assert found.solves.sum() < 10
    assert found.distance[-1] == pytest.approx(200 * found.distance[1], rel=1e-4)


@pytest.mark.slow
def test_shoes_of_different_pull_wear_apart() -> None:
    given: dict[str, Any] = {"wear": 1e-15, "stop_tolerance": 0.5, "tolerance": 0.1}
    outer, inner, again = mtb.wear_of_stops(shoe(), 10.0, MASS, 6, shares=(0.8, 1.0, 0.8), **given)
    assert outer == again
    assert outer.worn_volume[0, -1] == pytest.approx(0.8 * inner.worn_volume[0, -1], rel=0.01)
    assert inner.final is not None
    assert inner.life(1e-3) > inner.distance[-1]
    assert inner.summary["share_of_pull"] == 1.0


@pytest.mark.slow
def test_they_go_on_where_they_were_stopped(tmp_path: Path) -> None:
    given: dict[str, Any] = {"wear": 1e-15, "stop_tolerance": 0.5, "tolerance": 0.1, "shares": (0.8, 1.0)}
    file = tmp_path / "stops.jsonl"

    class Stop(Exception):
        pass

    shares: list[float] = []

    def stop(share: float) -> None:
        shares.append(share)
        if len(shares) == 4:
            raise Stop

    whole = mtb.wear_of_stops(shoe(), 10.0, MASS, 60, **given)
    with pytest.raises(Stop):
        mtb.wear_of_stops(shoe(), 10.0, MASS, 60, checkpoint=file, progress=stop, **given)
    rest: list[float] = []
    again = mtb.wear_of_stops(shoe(), 10.0, MASS, 60, checkpoint=file, progress=rest.append, **given)
    assert rest[0] == shares[-1] > 0.0
    assert rest[-1] == 1.0
    for one, other in zip(again, whole, strict=True):
        assert len(other.distance) > 5
        np.testing.assert_array_equal(one.solves, other.solves)
        for name in ("distance", "depths", "pressures", "errors", "forces"):
            np.testing.assert_allclose(getattr(one, name), getattr(other, name), rtol=1e-12, err_msg=name)
    # all of it is there: nothing is computed
    assert mtb.wear_of_stops(shoe(), 10.0, MASS, 60, checkpoint=file, **given) == again
    with pytest.raises(ValueError, match="checkpoint of another wear of stops"):
        mtb.wear_of_stops(shoe(), 10.0, MASS, 61, checkpoint=file, **given)


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({}, "wear is None: a law"),
        ({"wear": 1e-14, "lower_wear": 1e-14}, "lower_wear is given: each stop meets the rail"),
        ({"wear": 1e-14, "count": 0}, "count is 0: a positive whole number"),
        ({"wear": 1e-14, "tolerance": 1.0}, "tolerance is 1"),
        ({"wear": 1e-14, "tolerance": None}, "^tolerance is None: a finite number is needed"),
        ({"wear": 1e-14, "stop_tolerance": -1.0}, "^stop_tolerance is -1"),
        ({"wear": 1e-14, "stop_tolerance": None}, "^stop_tolerance is None: a finite number is needed"),
        ({"wear": 1e-14, "count": 10**400}, r"^count is 10+\.\.\.: a whole number of at most 1000000000"),
        ({"wear": 1e-14, "shares": ()}, "a positive number for each shoe"),
    ],
)
def test_bad_input_is_refused(given: dict[str, Any], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        mtb.wear_of_stops(**{"scene": shoe(), "speed": 10.0, "mass": 1e3, "count": 3, **given})


def test_a_law_that_wears_nothing_leaves_the_sole() -> None:
    (found,) = mtb.wear_of_stops(shoe(), 5.0, 1e3, 4, wear=0.0, stop_tolerance=STEPS)
    assert not found.depths.any()
    assert not found.errors.any()
    (worn,) = mtb.wear_of_stops(shoe(), 5.0, 1e3, 4, wear=1e-25, stop_tolerance=STEPS)
    assert found.distance[-1] == pytest.approx(worn.distance[-1], rel=1e-9)


def test_a_shoe_that_is_worn_through_is_refused() -> None:
    with pytest.raises(ValueError, match="more than the height of the upper body"):
        mtb.wear_of_stops(shoe(), SPEED, MASS, 10_000_000, wear=1e-13, stop_tolerance=STEPS)


def test_a_shoe_under_half_of_the_pull_is_one_of_half_the_pull() -> None:
    """From its first row on, at the speed of the stop whatever velocity the scene has."""
    friction = mtb.PressureDependentFriction(lambda p: 0.1 + 0.1 * np.exp(-p / 2e6))

    def found(pull: float, share: float, **given: Any) -> tuple[mtb.WearResult, mtb.Braking]:
        scene = shoe(magnetic_pressure=pull, friction=friction, **given)
        stops = mtb.wear_of_stops(scene, 10.0, 1e3, 3, wear=1e-14, shares=(share,), stop_tolerance=STEPS)
        return stops[0], mtb.brake(scene, 10.0, 1e3, shares=(share,), tolerance=STEPS, wear=1e-14)

    one = found(1e6, 1.0)
    for other in (found(2e6, 0.5), found(1e6, 1.0, velocity=2.0)):
        assert other[0].pressures == pytest.approx(one[0].pressures, rel=1e-6)
        assert other[0].forces == pytest.approx(one[0].forces, rel=1e-6, abs=1e-6)
        assert other[1].forces[0] == pytest.approx(one[1].forces[0], rel=1e-6, abs=1e-6)


def test_the_thermal_margin_of_a_stop_is_that_of_its_duration() -> None:
    scene = shoe(friction=0.15, magnetic_pressure=2e6)
    heat: dict[str, Any] = {"expansion": True, "wear": 1e-12, "resistance": 1e-5, "share": 0.0}
    stop = mtb.brake(scene, 10.0, 4e3, **heat, tolerance=0.3)
    alone = scene.sliding_heat(float(stop.time[-1]), 4, 10.0, **heat, tolerance=0.3)
    assert stop.shoe.thermal_margin == pytest.approx(alone.thermal_margin, rel=1e-6)
