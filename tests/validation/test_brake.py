# SPDX-License-Identifier: MIT OR Apache-2.0
"""Stops of a vehicle, against laws of mechanics and a stop by hand."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

import mtb_rs as mtb
from mtb_rs.bodies.mesh import block_mesh

#: Of a shoe whose conductivity and expansion change with its temperature.
CHANGING = mtb.Conductor(50.0, 7850.0, 460.0, 1.2e-5, conductivity_slope=-0.03, expansion_slope=5e-9)


def slowing(speed: float) -> float:
    """Force of the other brakes [N]."""
    return 500.0 + 10.0 * speed


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
    stops = [
        mtb.brake(shoe(friction=table), 25.0, 3000.0, tolerance=float(tolerance)) for tolerance in tolerances
    ]
    # m dv/dt = -N (0.3 - v / 150), with the N that a constant coefficient has
    normal = mtb.brake(shoe(), 25.0, 3000.0).forces[0, 0] / 0.1
    exact = 3000.0 / normal * 150.0 * np.log(0.3 / (0.3 - 25.0 / 150.0))
    errors = np.array([abs(stop.time[-1] / exact - 1.0) for stop in stops])
    # the pressure, and with it N, changes a little with friction
    assert np.all(errors < 1e-3)
    assert np.all(errors < tolerances)


@pytest.mark.parametrize(
    ("velocity", "value"),
    [
        ([0.0, 10.0, 40.0], [0.35, 0.22, 0.12]),
        ([0.0, 40.0], [0.12, 0.35]),
        ([0.0, 8.0, 12.0, 40.0], [0.3, 0.3, 0.1, 0.1]),
    ],
)
def test_stops_under_friction_that_depends_on_speed(velocity: list[float], value: list[float]) -> None:
    """Time and way of a stop are the integrals of m / F and of m v / F over the speed."""
    table, mass, first = mtb.VelocityTable(velocity, value), 500.0, 20.0

    def block(friction: Any) -> mtb.Scene:
        return mtb.scenes.block_on_plane(
            width=0.06, length=0.05, height=0.05, spacing=1e-2, supports="driven-top", friction=friction,
            magnetic_pressure=1e6,
        )  # fmt: skip

    v = np.linspace(0.0, first, 400_001)
    # on a plane friction is the coefficient times the pull
    pull = 1e6 * 0.06 * 0.05
    force = pull * np.interp(v, velocity, value)
    time, way = (float(np.trapezoid(mass * of / force, v)) for of in (np.ones_like(v), v))
    for tolerance in (0.3, 0.1, 0.01):
        stop = mtb.brake(block(table), first, mass, tolerance=tolerance)
        assert stop.time[-1] == pytest.approx(time, rel=1e-3 + 0.02 * tolerance)
        assert stop.way[-1] == pytest.approx(way, rel=1e-3 + 0.02 * tolerance)
        assert abs(stop.open_energy) < 1e-8
    other = mtb.brake(block(0.2), first, mass, lambda speed: 100.0 + 20.0 * speed)
    force = 0.2 * pull + 100.0 + 20.0 * v
    assert other.time[-1] == pytest.approx(float(np.trapezoid(mass / force, v)), rel=2e-3)
    assert other.way[-1] == pytest.approx(float(np.trapezoid(mass * v / force, v)), rel=2e-3)


@pytest.mark.parametrize(
    "effects",
    [
        {},
        {
            **{"expansion": True, "wear": 1e-12, "lower_wear": 1e-12, "resistance": 2e-5, "share": 0.0},
            **{"fading": ([0.0, 200.0], [1.0, 0.8]), "film": (20.0, 5.0), "upper": CHANGING},
        },
        {"magnet": True, "wear": 1e-12},
    ],
    ids=["cold", "all effects", "magnet"],
)
def test_a_stop_goes_on_where_it_was_stopped(effects: dict[str, Any], tmp_path: Path) -> None:
    """It equals the stop in one go, whatever the shoes are made of and pulled by."""
    table, rest = mtb.VelocityTable([0.0, 5.0, 30.0], [0.3, 0.2, 0.1]), dict(effects)
    magnet = mtb.Magnet(3000.0, 1e-3, speed_factor=mtb.VelocityTable([0.0, 50.0], [1.0, 0.6]))
    scene = shoe(friction=table, **({"magnetic_pressure": magnet} if rest.pop("magnet", None) else {}))
    given = {"shares": (0.8, 1.0, 1.0), "other_force": slowing, "tolerance": 0.2, **rest}
    file = tmp_path / "stop.jsonl"

    class Stop(Exception):
        pass

    shares: list[float] = []

    def stop(share: float) -> None:
        shares.append(share)
        if len(shares) == 9:
            raise Stop

    whole = mtb.brake(scene, 25.0, 3000.0, **given)
    with pytest.raises(Stop):
        mtb.brake(scene, 25.0, 3000.0, checkpoint=file, progress=stop, **given)
    rest_of: list[float] = []
    again = mtb.brake(scene, 25.0, 3000.0, checkpoint=file, progress=rest_of.append, **given)
    assert rest_of[0] == shares[-1]
    assert rest_of[-1] == pytest.approx(1.0)
    assert again.time == pytest.approx(whole.time, rel=1e-9)
    assert again.way == pytest.approx(whole.way, rel=1e-9)
    for one, other in zip(again.shoes, whole.shoes, strict=True):
        histories = ("forces", "stored", "peaks", "pressures", "depths", "openings")
        for name in (*histories, "volumes_lower", "errors"):
            largest = np.abs(getattr(other, name)).max()
            got, wanted = getattr(one, name), getattr(other, name)
            np.testing.assert_allclose(got, wanted, rtol=1e-8, atol=1e-10 * largest, err_msg=name)
        np.testing.assert_allclose(one.bodies[0], other.bodies[0], rtol=1e-9, atol=1e-12)
    assert abs(again.open_energy) < 1e-8
    # a step that is missing is no step
    lines = file.read_bytes().splitlines(keepends=True)
    file.write_bytes(b"".join(lines[:3] + lines[4:]))
    with pytest.raises(ValueError, match="step 3 of the stop is missing, and step 4 goes on from it"):
        mtb.brake(scene, 25.0, 3000.0, checkpoint=file, **given)
    for other_stop in ({"shares": (0.8, 1.0)}, {"tolerance": 0.1}, {"wear": 2e-12}):
        with pytest.raises(ValueError, match="checkpoint of another stop"):
            mtb.brake(scene, 25.0, 3000.0, checkpoint=file, **{**given, **other_stop})
    with pytest.raises(ValueError, match="checkpoint of another wear"):
        mtb.wear(scene.with_(velocity=25.0), 1.0, 1e-13, checkpoint=file)


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"scene": 3}, "a Scene that slides is needed"),
        ({"scene": shoe(sliding_direction=(0.8, 0.6))}, r"sliding_direction is \(0.8, 0.6\)"),
        ({"speed": 0.0}, "speed is 0"),
        ({"mass": -1.0}, "mass is -1"),
        ({"other_force": -5.0}, "other_force is -5 N: it must not be negative"),
        ({"other_force": lambda v: -v}, "other_force at 10 m/s is -10 N: it must not be negative"),
        ({"shares": ()}, "a positive number for each shoe"),
        ({"shares": (1.0, -1.0)}, "a positive number for each shoe"),
        ({"tolerance": 1.0}, "tolerance is 1"),
        ({"tolerance": None}, "tolerance is None: a finite number is needed"),
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


@pytest.mark.slow
def test_a_stop_moves(tmp_path: Path) -> None:
    """Frames of one size and scale; without wear there is no sole to show."""
    stop = mtb.brake(shoe(), 20.0, 2000.0, 900.0, shares=(0.5, 1.0), wear=1e-12, tolerance=0.4)
    cold = mtb.brake(shoe(poles=1), 20.0, 2000.0, 900.0, tolerance=0.4)
    heights = []
    for made in (stop, cold, stop.shoes[0]):
        with Image.open(made.animate(tmp_path / "stop.gif", frames=3)) as moving:
            assert moving.n_frames == 3  # type: ignore[attr-defined]
            frames = []
            for k in range(3):
                moving.seek(k)
                frames.append(np.array(moving.convert("RGB")))
        assert (frames[0] != frames[1]).any()
        assert (frames[1] != frames[2]).any()
        assert frames[0].shape == frames[2].shape
        heights.append(frames[0].shape[0])
    assert heights[0] == heights[2] > heights[1]
    for given, message in (
        ({"path": tmp_path / "stop.avi"}, r"\.gif, \.webp or \.png"),
        ({"frames": 0}, "frames is 0"),
        ({"frames": 2.5}, "frames is 2.5"),
        ({"frames_per_second": -1.0}, "frames_per_second is -1"),
    ):
        with pytest.raises(ValueError, match=message):
            stop.animate(**{"path": tmp_path / "stop.gif", **given})  # type: ignore[arg-type]


def test_nothing_that_brakes_is_said() -> None:
    with pytest.raises(mtb.ConvergenceError, match="nothing brakes"):
        mtb.brake(shoe(friction=0.0), 10.0, 1e3)
    with pytest.raises(ValueError, match="magnetic_pressure is None"):
        mtb.brake(mtb.scenes.paraboloid_on_plane(points=8), 10.0, 1e3)


def test_tables_that_end_above_standstill_are_refused_before_the_first_step() -> None:
    steps: list[float] = []
    scene = shoe(friction=mtb.VelocityTable([1.0, 40.0], [0.3, 0.1]))
    with pytest.raises(ValueError, match="velocity is 0 m/s: the table covers 1 to 40 m/s"):
        mtb.brake(scene, 20.0, 2000.0, progress=steps.append)
    assert not steps


def test_mean_speeds_that_do_not_settle_shorten_the_step() -> None:
    """Heat, wear and way are those of one speed then, and the work is that of friction."""
    scene = mtb.scenes.block_on_plane(
        friction=mtb.VelocityTable([0.0, 30.0], [0.3, 0.1]),
        spacing=2e-2,
        sliding_direction=(0.6, 0.8),
        layer=mtb.PlasticLayer(20e-6, 1e9, 2e5),
    )
    stop = mtb.brake(scene, 15.0, 5e3, 5e3, wear=1e-12, expansion=True, tolerance=0.3, shares=(1.0, 0.5))
    way = np.diff(stop.way)
    assert way == pytest.approx(0.5 * (stop.speed[1:] + stop.speed[:-1]) * np.diff(stop.time), rel=1e-4)
    for one in stop.shoes:
        load = one.pressures @ one.area
        assert one.volumes_upper[-1] == pytest.approx(1e-12 * float(load @ way), rel=1e-12)
    work = sum(float(one.friction_powers @ np.diff(stop.time)) for one in stop.shoes)
    assert work + stop.other_force @ way == pytest.approx(0.5 * 5e3 * 15.0**2, rel=1e-10)


def test_layered_and_rigid_shoes_do_not_heat() -> None:
    coated = mtb.Layered(mtb.Material(2e9, 0.3), 1e-3, mtb.steel)
    for upper in (coated, mtb.Rigid()):
        with pytest.raises(ValueError, match=f"upper is {type(upper).__name__}"):
            mtb.brake(shoe(upper=upper), 20.0, 2000.0)


@pytest.mark.parametrize("expansion", [False, True])
def test_friction_that_fades_is_that_of_its_own_temperature(expansion: bool) -> None:
    """Long steps go to the steady state of short ones, and do not flip between hot and cold."""
    scene = shoe(friction=0.3, velocity=40.0, magnetic_pressure=3e6)
    given: dict[str, Any] = {"fading": ([50.0, 100.0], [1.0, 0.3]), "wear": 1e-12, "expansion": expansion}
    by = {"tolerance": 0.2} if expansion else {}
    long, short = (scene.sliding_heat(10.0, steps, **given, **by) for steps in (15, 240))
    # power of friction and temperature fit each other, and stay
    assert long.friction_powers[-1] == pytest.approx(short.friction_powers[-1], rel=0.02)
    assert long.means[-1] == pytest.approx(short.means[-1], rel=0.02)
    if not expansion:
        last = long.friction_powers[-5:]
        assert np.ptp(last) < 0.01 * last.mean()
        warm = 0.5 * (long.temperature_upper + long.temperature_lower)
        friction = 0.3 * np.interp(warm, [50.0, 100.0], [1.0, 0.3])
        power = float((friction * long.pressure * 40.0) @ long.area)
        # fields are means over cells, whose products are not those of the basis functions
        assert long.friction_powers[-1] == pytest.approx(power, rel=3e-3)


@pytest.mark.slow
def test_a_stop_with_a_magnet_that_follows_the_gap_of_hot_spots() -> None:
    """Points that exchange heat change with the pull, and the pull with the gaps they open: both settle."""
    magnet = mtb.Magnet(3000.0, 1e-3, speed_factor=mtb.VelocityTable([0.0, 50.0], [1.0, 0.6]))
    friction = mtb.VelocityTable([0.0, 30.0], [0.3, 0.1])
    scene = shoe(friction=friction, magnetic_pressure=magnet)
    stop = mtb.brake(scene, 15.0, 2e3, 5e3, wear=1e-13, expansion=True, tolerance=0.3)
    assert stop.speed[-1] == 0.0
    way = np.diff(stop.way)
    work = float(stop.shoes[0].friction_powers @ np.diff(stop.time)) + stop.other_force @ way
    assert work == pytest.approx(0.5 * 2e3 * 15.0**2, rel=1e-10)
    assert stop.shoes[0].volumes_upper[-1] > 0.0


def test_bodies_of_ones_own_brake_in_the_model_that_they_make() -> None:
    def body(half: float, height: float, *, upper: bool) -> mtb.ElasticBody:
        mesh = block_mesh(np.linspace(-half, half, 5), np.linspace(-half, half, 5), height)
        if upper:
            return mtb.ElasticBody(mesh, mtb.steel, "bottom", [mtb.Support("top", x=0, y=0)])
        below = mesh.moved(shift=(0.0, 0.0, -height))
        return mtb.ElasticBody(below, mtb.steel, "top", [mtb.Support("bottom", x=0, y=0, z=0)])

    def scene(upper: Any, lower: Any) -> mtb.Scene:
        given: dict[str, Any] = {"spacing": 1.5e-2, "friction": 0.3, "magnetic_pressure": 1e6}
        return mtb.Scene(upper, lower, velocity=5.0, **given)

    both = scene(body(0.03, 0.05, upper=True), body(0.045, 0.04, upper=False))
    chosen, told = (mtb.brake(both, 20.0, 500.0, model=model) for model in ("auto", "elastic-both"))
    assert chosen.way[-1] == told.way[-1]
    assert chosen.way[-1] == pytest.approx(0.5 * 500.0 * 20.0**2 / (0.3 * 1e6 * 0.06**2), rel=1e-6)
    heat = both.sliding_heat(1.0, 3)
    assert heat.friction_powers == pytest.approx(
        both.sliding_heat(1.0, 3, model="elastic-both").friction_powers
    )
    below = scene(mtb.steel, body(0.045, 0.04, upper=False))
    for model in ("auto", "elastic-lower"):
        with pytest.raises(ValueError, match="heat needs an elastic upper body"):
            mtb.brake(below, 20.0, 500.0, model=model)
