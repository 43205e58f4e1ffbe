# SPDX-License-Identifier: MIT OR Apache-2.0
"""A shoe turned with its way on a flat rail: heat, stops, wear, the start of sliding and stress turn too."""

import numpy as np
import pytest

import mtb_rs as mtb

YAW, SPEED, WAY = 0.3, 20.0, np.array([1.0, 0.3]) / np.hypot(1.0, 0.3)
COS, SIN = np.cos(YAW), np.sin(YAW)
TURN = np.array([[COS, -SIN], [SIN, COS]])

pytestmark = pytest.mark.filterwarnings("ignore::UserWarning")


def flat():
    y = np.linspace(-0.3, 0.3, 101)
    return mtb.Profile.from_points(y, -1e-9 * y**2)


def shoe(yaw=0.0, way=WAY, rail=None, **given):
    cos, sin = np.cos(yaw), np.sin(yaw)
    turned = (cos * way[0] - sin * way[1], sin * way[0] + cos * way[1])
    given = {"relief_slope": 0.0, "rail": flat()} | given if rail is None else {"rail": rail} | given
    return mtb.scenes.pole_shoe_on_rail(
        poles=1, spacing=10e-3, friction=0.25, velocity=SPEED, yaw=yaw, sliding_direction=turned,
        rail_length=0.6, lower=mtb.Material(1.5e11, 0.25), **given,
    )  # fmt: skip


@pytest.fixture(params=["half-space", "elastic-upper"])
def model(request):
    return request.param


def total(result, field):
    """Sum over the contact points, times their areas."""
    return field.reshape(*field.shape[: field.ndim - result.area.ndim], -1) @ result.area.ravel()


def test_heat_and_wear_do_not_know_a_common_turn():
    straight, turned = (shoe(yaw).sliding_heat(0.3, 3, expansion=True, wear=1e-13) for yaw in (0.0, YAW))
    for name in ("temperature_upper", "temperature_lower", "depth", "pressure", "friction_powers", "means"):
        a, b = getattr(straight, name), getattr(turned, name)
        np.testing.assert_allclose(b, a, atol=1e-6 * np.abs(a).max(), err_msg=name)
    assert turned.thermal_margin == pytest.approx(straight.thermal_margin, rel=1e-9)
    np.testing.assert_allclose(TURN.T @ turned.traction, straight.traction, atol=1e-5 * turned.traction.max())


@pytest.mark.parametrize(("rail", "yaw"), [(None, 0.3), (None, -0.45), ("60E1", 0.05)])
def test_heat_is_force_times_speed_and_a_stop_loses_what_becomes_heat(rail, yaw):
    """The shoe alone is turned: it slides along the track."""
    scene = shoe(yaw, (np.cos(yaw), -np.sin(yaw)), rail)
    assert scene.sliding_direction == pytest.approx((1.0, 0.0))
    heated = scene.sliding_heat(0.5, 4)
    assert heated.friction_powers == pytest.approx(heated.forces[:, 0] * SPEED, rel=1e-12)
    mass = 100.0
    stop = mtb.brake(scene, speed=SPEED, mass=mass, tolerance=0.5)
    slower = np.diff(stop.speed) / np.diff(stop.time)
    assert -mass * slower[-1] == pytest.approx(stop.shoes[0].forces[-1][0], rel=1e-9)
    assert abs(stop.open_energy) < 1e-10


def test_the_start_of_sliding_turns(model):
    way = np.array([[1e-6, 0.3e-6], [3e-6, 1e-6], [20e-6, 6e-6]])
    straight = shoe().start_of_sliding(way, model=model)
    turned = shoe(YAW).start_of_sliding(way @ TURN.T, model=model)
    np.testing.assert_allclose(turned.force, straight.force @ TURN.T, rtol=1e-6, atol=1e-2)
    most = np.abs(straight.traction).max()
    np.testing.assert_allclose(
        TURN.T @ turned.traction.reshape(2, -1), straight.traction.reshape(2, -1), atol=1e-4 * most
    )
    np.testing.assert_allclose(total(turned, turned.traction), turned.force[-1], rtol=1e-6)


@pytest.mark.parametrize("kind", ["sliding", "start"])
@pytest.mark.parametrize("body", ["lower", "upper"])
def test_the_stress_turns(kind, body):
    """At depths and at points, in the frame of the track."""
    results = []
    for yaw in (0.0, YAW):
        scene = shoe(yaw)
        way = np.array([[1e-6, 0.3e-6], [3e-6, 1e-6]])
        if yaw:
            way = way @ TURN.T
        solved = scene.solve(model="half-space") if kind == "sliding" else None
        results.append(solved or scene.start_of_sliding(way, model="half-space"))
    depths = [0.0, 1e-3, 8e-3]
    straight, turned = (result.stress(body, depths=depths) for result in results)
    about = np.eye(3)
    about[:2, :2] = TURN
    np.testing.assert_allclose(
        np.tensordot(about, straight.points, 1), turned.points, atol=1e-6 * np.abs(turned.points).max()
    )

    def tensor(stress):
        xx, yy, zz, yz, xz, xy = stress
        return np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])

    wanted = np.einsum("ik,jl,kl...->ij...", about, about, tensor(straight.stress))
    np.testing.assert_allclose(tensor(turned.stress), wanted, atol=1e-5 * np.abs(wanted).max())
    result = results[1]
    traction = result.traction[:2] if kind == "sliding" else result.traction
    area = result.area.ravel()
    assert [turned.xz[0].ravel() @ area, turned.yz[0].ravel() @ area] == pytest.approx(
        total(result, traction), rel=1e-6
    )
    # the places are those of the contact points, and may be asked for
    np.testing.assert_allclose(
        turned.points[:2, 0].reshape(2, -1), result.points.reshape(3, -1)[:2], atol=1e-9
    )
    inside = turned.points[:, 1:]
    asked = result.stress(body, points=inside)
    np.testing.assert_allclose(asked.stress, turned.stress[:, 1:], atol=1e-9 * np.abs(wanted).max())
    # a passage along the track does not run along the rows of the turned shoe
    with pytest.raises(ValueError, match="do not lie on straight lines along x"):
        turned.dang_van(coefficient=0.35)


@pytest.mark.parametrize("lateral", [0.0, 2e-3, -3e-3])
@pytest.mark.parametrize("rail", [None, "60E1"])
def test_the_stress_below_a_shoe_that_stands_aside_is_below_its_points(lateral, rail):
    """Along the arc of the rail."""
    scene = shoe(0.0, (1.0, 0.0), rail, lateral=lateral)
    result = scene.solve(model="half-space")
    arc = (scene.geometry.shoe.profile).arc_length(result.points[1].ravel())
    below = result.stress(depths=[1e-3]).points[1].ravel()
    # rows lie evenly along the arc of the sole, and nearly so along that of the rail
    np.testing.assert_allclose(below, arc, atol=6e-3 * abs(lateral) + 1e-9)
    assert np.mean(below - arc) == pytest.approx(0.0, abs=1e-9)
    if rail is None:
        np.testing.assert_allclose(below, result.points[1].ravel(), atol=1e-9)
