# SPDX-License-Identifier: MIT OR Apache-2.0
"""Stability of sliding against closed forms, differences of steps and vibrations in time."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import mtb_rs as mtb
from mtb_rs.bodies.mesh import block_mesh

Array = NDArray[np.float64]

# rigid on incompressible: friction opens no gap
SOFT = mtb.Material(2e9, 0.5)
SPEED, MASS = 10.0, 6.0
XZ: dict[str, Any] = {"free": ("x", "z")}


def block(friction: Any = 0.2, cells: int = 6, **given: Any) -> mtb.PreparedContact:
    given = {"upper": mtb.Rigid(), "lower": SOFT, "velocity": SPEED} | given
    return mtb.scenes.block_on_plane(0.1, 0.05, friction, spacing=0.1 / cells, **given).prepare("half-space")


def normal_stiffness(contact: mtb.PreparedContact, pose: Array) -> float:
    """By differences of steps."""
    h = 1e-9
    forces = [contact.step(pose + s * h * np.eye(6)[2], SPEED).force[2] for s in (1.0, -1.0)]
    return float(forces[0] - forces[1]) / (2.0 * h)


@pytest.mark.parametrize("seed", range(6))
def test_mode_coupling_of_two_degrees_of_freedom(seed: int) -> None:
    """Flutter where (k11 - k22)^2 + 4 k12 (k12 - mu k3) < 0 [Hoffmann2002]."""
    rng = np.random.default_rng(seed)
    contact = block()
    k12 = 1e8 * rng.uniform(1.0, 3.0)
    k11 = 1e8 * rng.uniform(3.0, 6.0)
    held = np.array([[k11, k12], [k12, 4e8]])
    found = contact.stability([MASS, MASS], held, **XZ, largest_friction=4.0)
    k3 = found.stiffness[1, 1] - held[1, 1]
    assert k3 == pytest.approx(normal_stiffness(contact, found.pose), rel=1e-6)
    k22 = held[1, 1] + k3
    assert found.critical_friction == pytest.approx(((k11 - k22) ** 2 / (4.0 * k12) + k12) / k3, rel=1e-10)
    swing = np.sqrt(0.5 * (k11 + k22) / MASS) / (2.0 * np.pi)
    assert found.critical_frequency == pytest.approx(swing, rel=1e-10)
    assert found.kind == "stable"
    discriminant = np.sqrt((k11 - k22) ** 2 + 4.0 * k12 * (k12 - 0.2 * k3))
    squares = 0.5 * (k11 + k22 + np.array([-1.0, 1.0]) * discriminant) / MASS
    assert found.frequency == pytest.approx(np.sqrt(squares) / (2.0 * np.pi), rel=1e-10)
    assert (found.growth == 0.0).all()
    # slid backwards, friction couples the other way, until the stiffness has no determinant
    other = contact.stability([MASS, MASS], held, **XZ, velocity=-SPEED, largest_friction=8.0)
    assert other.critical_friction == pytest.approx((k11 * k22 - k12**2) / (k12 * k3), rel=1e-10)
    assert other.critical_frequency == 0.0


@pytest.mark.parametrize("mu", [0.1, 0.4])
def test_falling_friction_and_lateral_damping(mu: float) -> None:
    """One degree of freedom each: growth by the slope of friction, decay by friction that turns."""
    slope = -0.01
    table = mtb.VelocityTable([0.0, 2.0 * SPEED], [mu - slope * SPEED, mu + slope * SPEED])
    contact = block(table)
    k, c = 1e7, 3.0
    along = contact.stability([MASS], [k], [c], free=["x"])
    load = -contact.step(velocity=SPEED).force[2]
    damping = c + load * slope
    # the faces move as friction changes, which changes it in turn
    assert along.growth == pytest.approx([-damping / (2.0 * MASS)], rel=2e-4)
    assert along.damping == pytest.approx(damping, rel=1e-9)
    assert along.kind == "flutter"
    # where the friction is so small that the damper holds it
    assert along.critical_friction == pytest.approx(mu * c / -(load * slope), rel=1e-6)
    across = contact.stability([MASS], [k], free=["y"])
    assert across.growth == pytest.approx([-load * mu / SPEED / (2.0 * MASS)], rel=2e-3)
    assert across.damping == pytest.approx(load * mu / SPEED, rel=1e-9)
    assert across.kind == "stable"


def all_eigenvalues(contact: mtb.PreparedContact, mu: float, slope: float, speed: float, **asked: Any) -> Any:
    """Those of the coordinates and of all tractions: friction q of the slip s is q = B s, with
    s = -d/dt (G_t x + C_tt q + C_tn p) and C_nn p + C_nt q + G_n x = 0."""
    made = contact.vibrating(1e-6, velocity=speed, **asked)
    (compliance, area, *_), moves = made._parts[0], made._coordinates
    pressure = made.state.pressure
    n, closed = pressure.size, np.flatnonzero(pressure > 0.0)
    rows = [closed, n + closed, 2 * n + closed]
    c = [[compliance[np.ix_(i, j)] for j in rows] for i in rows]
    g, a, p = [moves.shapes[i] for i in rows], area[closed], pressure[closed]
    one = np.eye(closed.size)
    # sliding along the first tangent: it carries mu p and what falls, the second one what turns
    falls, turns = slope * p, mu * p / speed
    of_pressure = np.linalg.inv(c[2][2] + mu * c[2][0])
    # tractions t = (mu p + f_x, f_y) by f and the coordinates
    pressed = [-of_pressure @ c[2][0], -of_pressure @ c[2][1], -of_pressure @ g[2]]
    faces = [
        [c[i][0] + (c[i][2] + mu * c[i][0]) @ pressed[0], c[i][1] + (c[i][2] + mu * c[i][0]) @ pressed[1]]
        for i in (0, 1)
    ]
    by_x = [g[i] + (c[i][2] + mu * c[i][0]) @ pressed[2] for i in (0, 1)]
    back, rigid = np.block(faces), np.vstack(by_x)
    use = np.concatenate([falls, turns]) != 0.0
    drag = np.concatenate([falls, turns])[use]
    back, rigid = back[np.ix_(use, use)], rigid[use]
    count, k = drag.size, len(moves.mass)
    whole = np.hstack([mu * pressed[0] + one, mu * pressed[1]])[:, use]
    across = np.hstack([0.0 * one, one])[:, use]
    carried = np.hstack([pressed[0], pressed[1]])[:, use]
    load = -sum(w.T @ (a[:, None] * t) for w, t in zip(g, (whole, across, carried), strict=True))
    by_pose = -(g[0].T * a * mu + g[2].T * a) @ pressed[2]
    inverse = np.linalg.inv(moves.mass)
    # states: x, x', f; back f' = -rigid x' - f / drag
    still, to = np.zeros((k, k)), np.linalg.inv(back)
    states = np.block(
        [
            [still, np.eye(k), np.zeros((k, count))],
            [-inverse @ (moves.stiffness + by_pose), -inverse @ moves.damping, -inverse @ load],
            [np.zeros((count, k)), -to @ rigid, -to / drag],
        ]
    )
    return np.linalg.eigvals(states)


def check_all(found: mtb.Stability, every: Any) -> None:
    """Each eigenvalue is one, once, and none that swings or grows is missing."""
    size = np.abs(found.eigenvalues).max()
    assert max(np.abs(every - value).min() for value in found.eigenvalues) < 1e-8 * size
    apart = np.abs(found.eigenvalues[:, None] - found.eigenvalues) + size * np.eye(found.frequency.size)
    assert apart.min() > 1e-9 * size
    swings = every[(every.imag > 0.0) & (every.imag > np.abs(every.real)) & (np.abs(every) < 2.0 * size)]
    assert max(np.abs(found.eigenvalues - value).min() for value in swings) < 1e-7 * size


@pytest.mark.parametrize("speed", [3e-3, 1e-3])
def test_what_friction_holds_across_swings_and_may_grow(speed: float) -> None:
    """At low speeds the damper of slow motions lets a block creep across that swings, and grows."""
    springs = np.diag([48e6, 33e6, 16e6, 93e3, 38e3, 1e3])
    rows, columns = np.triu_indices(6, 1)
    springs[rows, columns] = [
        1.1e6, 0.52e6, 0.62e6, -0.33e6, 35e3, 4.9e6, 0.29e6, -97e3, 76e3, 0.46e6, 0.24e6, -21e3, 8.8e3,
        -3.3e3, 1.4e3,
    ]  # fmt: skip
    springs = np.triu(springs) + np.triu(springs, 1).T
    asked: dict[str, Any] = {
        "mass": [6, 6, 6, 0.027, 0.012, 0.0096], "stiffness": springs,
        "free": ("x", "y", "z", "roll", "pitch", "yaw"),
    }  # fmt: skip
    contact = mtb.scenes.block_on_plane(
        0.1, 0.05, 0.3, spacing=0.025, upper=mtb.Rigid(), lower=mtb.Material(2e9, 0.0), velocity=speed
    ).prepare("half-space")
    found = contact.stability(**asked)
    every = all_eigenvalues(contact, 0.3, 0.0, speed, **asked)
    swings = every[every.imag > np.abs(every.real)]
    assert max(np.abs(found.eigenvalues - value).min() for value in swings) < 1e-5 * np.abs(swings).max()
    assert found.kind == "flutter"
    assert found.growth.max() == pytest.approx(every.real.max(), rel=1e-6)
    assert found.critical_friction is not None
    assert found.critical_friction < 0.3
    assert found.growing()[-1].any()


@pytest.mark.parametrize("speed", [5.0, 0.2, 0.01])
@pytest.mark.parametrize("slope", [0.0, -1e-3])
def test_friction_moves_the_faces_that_slide(speed: float, slope: float) -> None:
    """Of a block on a lining, against all eigenvalues with the tractions of all points."""
    mu = 0.3
    friction = (
        mu if slope == 0.0 else mtb.VelocityTable([0.0, 2.0 * speed], mu + slope * speed * np.array([-1, 1]))
    )
    contact = block(friction, lower=mtb.Material(2e9, 0.4), velocity=speed)
    asked: dict[str, Any] = {
        "mass": [6, 6, 6, 0.01, 0.01, 0.01], "stiffness": [1e7, 2e7, 3e7, 1e4, 1e4, 1e4],
        "free": ("x", "y", "z", "roll", "pitch", "yaw"),
    }  # fmt: skip
    found = contact.stability(velocity=speed, **asked)
    every = all_eigenvalues(contact, mu, slope, speed, **asked)
    check_all(found, every)


@pytest.mark.coarse
@pytest.mark.parametrize("speed", [20.0, 1.0, 0.1])
def test_friction_moves_the_faces_of_bodies_that_vibrate(speed: float) -> None:
    """A pole shoe on an elastic rail: without what the faces do it grows 16 times as quickly at 1 m/s."""
    contact = mtb.scenes.pole_shoe_on_rail(
        friction=0.35, velocity=speed, spacing=12e-3, supports="clamped-top", upper=mtb.Material(1.7e11, 0.28)
    ).prepare("elastic-both")
    asked: dict[str, Any] = {
        "mass": [8.0, 8.0, 0.02], "stiffness": [5e7, 2.5e8, 1e5], "damping": [10.0, 50.0, 0.01],
        "free": ("x", "z", "pitch"), "density": 7200.0, "modes": 4,
    }  # fmt: skip
    found = contact.stability(velocity=speed, **asked)
    every = all_eigenvalues(contact, 0.35, 0.0, speed, **asked)
    check_all(found, every)
    assert (found.kind == "stable") == (speed < 0.5)


def pulled_block(magnet: mtb.Magnet, **given: Any) -> mtb.PreparedContact:
    given = {"upper": mtb.Rigid(), "lower": SOFT, "velocity": SPEED, "friction": 0.3} | given
    scene = mtb.scenes.block_on_plane(0.04, 0.05, spacing=0.01, magnetic_pressure=magnet, **given)
    return scene.prepare("half-space", reference_point=(0.0, 0.0, 0.02))


@pytest.mark.parametrize("share", [0.95, 0.7, 0.6667, 0.6666, 0.5])
def test_a_plate_magnet_on_a_spring_snaps_on_at_two_thirds(share: float) -> None:
    """At the distance d of the irons, D without pull, the stiffness is k (3 d - 2 D) / d."""
    whole, layer, spring, area, vacuum = 3e-3, 5e-4, 4e5, 0.04**2, 4e-7 * np.pi
    distance = share * whole
    # so much pulls as far as there
    turns = np.sqrt(2.0 * spring * (whole - distance) / (vacuum * area)) * distance
    contact = pulled_block(mtb.Magnet(turns, layer))
    pose = [0.0, 0.0, distance - layer, 0.0, 0.0, 0.0]
    found = contact.stability([MASS], [spring], free=["z"], pose=pose)
    wanted = spring * (3.0 * distance - 2.0 * whole) / distance
    assert found.stiffness == pytest.approx(np.array([[wanted]]), rel=1e-9)
    assert found.kind == ("stable" if 3.0 * distance > 2.0 * whole else "divergence")
    rate = np.sqrt(abs(wanted) / MASS)
    if found.kind == "stable":
        assert found.frequency == pytest.approx([rate / (2.0 * np.pi)], rel=1e-9)
    else:
        assert found.growth.max() == pytest.approx(rate, rel=1e-9)
    # nothing rubs in the air
    assert found.critical_friction == (None if found.kind == "stable" else 0.0)


def test_a_magnet_is_a_number_beside_a_wide_layer_and_a_spring_beside_a_narrow_one() -> None:
    pressure, layer, vacuum = 3e6, 1e5, 4e-7 * np.pi
    turns = np.sqrt(2.0 * pressure * vacuum) * layer / vacuum
    free: dict[str, Any] = {"free": ("x", "z", "pitch")}
    mass, held = [MASS, MASS, 5e-3], np.array([[2e8, 8e7, 0.0], [8e7, 1e8, 1e5], [0.0, 1e5, 3e4]])
    number = pulled_block(pressure)
    wide = pulled_block(mtb.Magnet(turns, layer, iron=((1.0, 2.0), (100.0, 200.0))))
    there, here = (contact.stability(mass, held, **free) for contact in (number, wide))
    scale = np.abs(there.stiffness).max()
    np.testing.assert_allclose(here.stiffness, there.stiffness, rtol=1e-7, atol=1e-9 * scale)
    np.testing.assert_allclose(here.pose, there.pose, rtol=1e-7, atol=1e-14)
    np.testing.assert_allclose(here.frequency, there.frequency, rtol=1e-7)
    assert here.critical_friction == pytest.approx(there.critical_friction, rel=1e-6)
    # differences of what contact and magnet do to the body, partly in contact
    contact = pulled_block(mtb.Magnet(900.0, 3e-4), lower=mtb.Material(2e8, 0.5))
    pose = np.array([0.0, 0.0, -2e-7, 0.0, 3e-5, 0.0])
    found = contact.stability(mass, held, **free, pose=pose)
    points, area = contact.points - contact.reference_point[:, None], contact.area

    def load(at: Array) -> Array:
        step = contact.step(at, SPEED)
        pull = step.magnetic_pressure
        assert pull is not None
        moment = step.moment[1] - float(points[0] @ (pull * area))
        return np.array([step.force[0], step.force[2] + float(pull @ area), moment])

    columns = []
    for k, h in ((0, 1e-9), (2, 1e-10), (4, 1e-9)):
        sides = [load(pose + sign * h * np.eye(6)[k]) for sign in (1.0, -1.0)]
        columns.append((sides[0] - sides[1]) / (2.0 * h))
    slopes, own = np.array(columns).T, found.stiffness - held
    assert 0 < np.count_nonzero(contact.step(pose, SPEED).pressure) < contact.area.size
    np.testing.assert_allclose(own, slopes, rtol=1e-5, atol=1e-6 * np.abs(slopes).max())


def test_growth_in_time() -> None:
    """Steps of the contact itself, integrated from a small disturbance, grow as the eigenvalue tells."""
    contact = block(0.6, cells=4)
    held = np.array([[5e8, 3e8], [3e8, 2e8]])
    k3 = normal_stiffness(contact, contact.stability([MASS] * 2, held, **XZ).pose)
    held[0, 0], held[0, 1], held[1, 0] = held[1, 1] + k3, 0.3 * k3, 0.3 * k3
    found = contact.stability([MASS, MASS], held, **XZ)
    assert found.kind == "flutter"
    worst = found.eigenvalues[found.growth.argmax()]
    rest = contact.step(found.pose, SPEED).force[[0, 2]]

    def rate(state: Array) -> Array:
        pose = found.pose.copy()
        pose[[0, 2]] += state[:2]
        force = contact.step(pose, (SPEED + state[2], 0.0)).force[[0, 2]] - rest
        return np.concatenate([state[2:], -(held @ state[:2] + force) / MASS])

    mode = found.modes[found.growth.argmax()] * 1e-12
    state = np.concatenate([mode, worst * mode]).real
    period = 1.0 / found.frequency[found.growth.argmax()]
    dt, sizes = period / 60.0, []
    for _ in range(3 * 60 + 1):
        sizes.append(np.hypot(*state[:2]))
        a = rate(state)
        b = rate(state + 0.5 * dt * a)
        c = rate(state + 0.5 * dt * b)
        d = rate(state + dt * c)
        state = state + dt / 6.0 * (a + 2.0 * b + 2.0 * c + d)
    grown = np.log(max(sizes[120:]) / max(sizes[:61])) / (2.0 * period)
    assert grown == pytest.approx(found.growth.max(), rel=0.02)


@pytest.mark.parametrize("model", ["half-space", "elastic-upper"])
def test_the_contact_of_a_pole_shoe_by_differences(model: Any) -> None:
    """All six components, with friction that falls and opens the gap."""
    table = mtb.VelocityTable([0.0, 20.0], [0.3, 0.1])
    contact = mtb.scenes.pole_shoe_on_rail(friction=table, spacing=10e-3, velocity=8.0).prepare(model)
    found = contact.stability([6, 6, 6, 0.02, 0.1, 0.1], 1e6 * np.ones(6))
    load = contact.step(velocity=8.0).force
    at = contact.step(found.pose, 8.0)
    same = [0, 2, 4]
    # its poles are found from balance one by one, and then move as one
    assert at.force[2] == pytest.approx(load[2], rel=1e-9)

    def loads(pose: Array, velocity: Any) -> Array:
        step = contact.step(pose, velocity)
        return np.concatenate([step.force, step.moment])

    h = np.array([1e-9] * 3 + [1e-8] * 3)
    stiffness = np.array(
        [
            (loads(found.pose + h[k] * e, 8.0) - loads(found.pose - h[k] * e, 8.0)) / (2.0 * h[k])
            for k, e in enumerate(np.eye(6))
        ]
    ).T
    scale = np.sqrt(np.outer(np.abs(np.diag(stiffness)) + 1.0, np.abs(np.diag(stiffness)) + 1.0))
    assert np.abs((found.stiffness - 1e6 * np.eye(6) - stiffness) / scale)[np.ix_(same, same)].max() < 1e-5
    slope = (loads(found.pose, 8.01) - loads(found.pose, 7.99))[0] / 0.02
    assert found.damping[0, 0] == pytest.approx(slope, rel=1e-6)


@pytest.mark.parametrize("velocity", [SPEED, (6.0, -8.0)])
def test_little_friction_damps_by_the_slip_of_each_point(velocity: Any) -> None:
    """Faces that friction does not move along each other: sums over the points in closed form."""
    mu, fall = 1e-7, -4e-9
    table = mtb.VelocityTable([0.0, 2.0 * SPEED], [mu - fall * SPEED, mu + fall * SPEED])
    contact = block(table)
    found = contact.stability(np.ones(6), velocity=velocity)
    step = contact.step(found.pose, velocity)
    along = np.array(velocity if isinstance(velocity, tuple) else (velocity, 0.0)) / SPEED
    x, y, z = step.points - contact.reference_point[:, None]
    one, nothing = np.ones(x.size), np.zeros(x.size)
    slip = np.array([[one, nothing, nothing, nothing, z, -y], [nothing, one, nothing, -z, nothing, x]])
    forwards, across = (np.tensordot(d, slip, 1) for d in (along, (-along[1], along[0])))
    load = step.pressure * step.area
    wanted = mu / SPEED * (across * load) @ across.T + fall * (forwards * load) @ forwards.T
    # what friction opens and slides besides is of the order of the friction
    np.testing.assert_allclose(found.damping, wanted, atol=1e-5 * np.abs(wanted).max())


@pytest.mark.coarse
@pytest.mark.parametrize("model", ["half-space", "elastic-upper", "elastic-both"])
@pytest.mark.parametrize("way", ["scene", "file", "density"])
def test_little_friction_feeds_nothing(model: Any, way: str, tmp_path: Path) -> None:
    """The power of friction in its own slip: the damper is symmetric, and no motion gains by it."""
    scene = mtb.scenes.pole_shoe_on_rail(
        friction=1e-7,
        spacing=15e-3,
        velocity=2.0,
        upper=mtb.steel,
        lower=mtb.Material(9e10, 0.2),
    )
    contact = scene.prepare(model, reference_point=(0.01, 0.02, 0.05))
    pose = contact.stability(np.ones(6)).pose
    if way == "density" and model == "half-space":
        pytest.skip("half-spaces do not vibrate")
    if way == "file":
        contact.save(tmp_path / "it.mtbc", shift=True)
        contact = mtb.PreparedContact.load(tmp_path / "it.mtbc")
    density = 100.0 if way == "density" else None
    mass = 1e3 * np.ones(6)
    damping = contact.stability(mass, pose=pose, velocity=2.0, density=density, modes=3).damping
    size = np.sqrt(np.abs(np.diag(damping)).clip(1e-6 * np.abs(damping).max()))
    damping = damping / np.outer(size, size)
    # arms are those of the body before it turns, and friction counts by itself as well
    np.testing.assert_allclose(damping, damping.T, atol=1e-5)
    assert np.linalg.eigvalsh(0.5 * (damping + damping.T))[0] > -1e-5


@pytest.mark.parametrize("velocity", [0.3, 2.0])
def test_below_its_standstill_speed_friction_fades_once(velocity: float) -> None:
    """Damping and stiffness by differences of steps, which are given no coefficients."""
    table = mtb.VelocityTable([0.0, 5.0], [0.4, 0.2])
    scene = mtb.scenes.block_on_plane(0.1, 0.05, table, 2e6, velocity=velocity, spacing=0.025)
    contact = scene.prepare("elastic-upper", standstill_speed=1.0)
    pose = np.zeros(6)
    found = contact.stability(np.ones(6), pose=pose)

    def load(at: Array, v: float) -> Array:
        step = contact.step(at, v)
        return np.concatenate([step.force, step.moment])

    h = 1e-4 * velocity
    by_velocity = (load(pose, velocity + h) - load(pose, velocity - h)) / (2.0 * h)
    # of second order in the table over the velocity
    np.testing.assert_allclose(found.damping[:, 0], by_velocity, atol=1e-6 * np.abs(by_velocity).max())
    up = 1e-9 * np.eye(6)[2]
    by_height = (load(pose + up, velocity) - load(pose - up, velocity)) / 2e-9
    np.testing.assert_allclose(found.stiffness[:, 2], by_height, atol=1e-6 * np.abs(by_height).max())


def tied_block(friction: float) -> mtb.PreparedContact:
    """An elastic block whose centre of pressure friction moves by some millimetres."""
    scene = mtb.scenes.block_on_plane(
        height=0.05,
        friction=friction,
        magnetic_pressure=2e6,
        velocity=0.1,
        spacing=20e-3,
        supports="clamped-top",
    )
    return scene.prepare("elastic-upper")


@pytest.mark.coarse
def test_the_least_unstable_coefficient_is_that_of_a_scene_that_has_it() -> None:
    """However much friction the scene has that is asked."""
    rng = np.random.default_rng(7)
    sides, size = rng.normal(size=(6, 6)), np.array([1.0] * 3 + [0.05] * 3)
    held = (0.5 * sides @ sides.T + 0.3 * np.eye(6)) * 1e8 * np.outer(size, size)
    asked: dict[str, Any] = {
        "mass": [30.0] * 3 + [0.5] * 3, "stiffness": held, "pose": np.zeros(6), "largest_friction": 0.8,
    }  # fmt: skip
    found = [tied_block(mu).stability(**asked).critical_friction for mu in (0.02, 0.3, 0.6)]
    assert found[0] is not None
    assert found == pytest.approx([found[0]] * 3, rel=1e-6)
    for share, kind in ((0.999, "stable"), (1.001, "flutter")):
        there = tied_block(share * found[0]).stability(**asked)
        assert there.kind == kind


def aside(model: Any, poles: int, **given: Any) -> mtb.PreparedContact:
    scene = mtb.scenes.pole_shoe_on_rail(poles=poles, friction=0.3, velocity=5.0, spacing=15e-3, **given)
    return scene.prepare(model)


@pytest.mark.coarse
@pytest.mark.parametrize("model", ["half-space", "elastic-upper"])
@pytest.mark.parametrize("poles", [1, 2])
@pytest.mark.parametrize("given", [{}, {"lateral": 1e-3}, {"lateral": 2e-3}, {"yaw": 1e-2}, {"yaw": -0.05}])
def test_the_state_of_a_shoe_that_stands_aside_is_found(model: Any, poles: int, given: Any) -> None:
    contact = aside(model, poles, **given)
    carried = contact.step()
    found = contact.stability(np.ones(6), [1e8] * 3 + [1e5] * 3)
    there = contact.step(found.pose)
    assert there.force[2] == pytest.approx(carried.force[2], rel=1e-8)
    if poles == 1:
        # one body: the very state
        np.testing.assert_allclose(there.pressure, carried.pressure, atol=1e-5 * carried.pressure.max())


def about(arm: Array) -> Array:
    """What makes the pose (6,) about a point at this arm, if it is small, that about the origin."""
    x, y, z = arm
    turned = np.eye(6)
    turned[:3, 3:] = [[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]]
    return turned


def edge_held(arm: Array) -> mtb.PreparedContact:
    """A block that turns about an edge alone."""
    x = np.linspace(-0.02, 0.02, 5)
    supports = [mtb.Support("top", x=0, y=0), mtb.Support("rear", z=0)]
    body = mtb.ElasticBody(block_mesh(x, x, 0.03), mtb.steel, supports=supports)
    scene = mtb.Scene(body, mtb.steel, spacing=1e-2, magnetic_pressure=1e6, friction=0.2)
    return scene.prepare(reference_point=tuple(arm))


def hung_block(arm: Array) -> mtb.PreparedContact:
    """A block that its top leaves free in z, roll and pitch."""
    scene = mtb.scenes.block_on_plane(0.04, 0.03, 0.2, 1e6, spacing=1e-2, supports="driven-top")
    return scene.prepare("elastic-upper", reference_point=tuple(arm))


def hung_shoe(arm: Array) -> mtb.PreparedContact:
    """Two poles, which are found from balance one by one."""
    scene = mtb.scenes.pole_shoe_on_rail(spacing=15e-3, friction=0.2, magnetic_pressure=(1e6, 1.2e6))
    return scene.prepare("elastic-upper", reference_point=tuple(arm))


@pytest.mark.coarse
@pytest.mark.parametrize("made", [hung_block, edge_held, hung_shoe])
@pytest.mark.parametrize("density", [None, 7850.0])
@pytest.mark.parametrize("pose", [None, (np.nan, np.nan, np.nan, np.nan, 1e-6, np.nan)])
def test_it_is_the_same_about_any_point(made: Any, density: float | None, pose: Any) -> None:
    """Where a body and its springs are told about another point, and what the pose is, changes nothing."""
    if pose is not None and made is not hung_block:
        pytest.skip("another pitch is another state where a body turns about an edge, or several turn")
    mass, stiffness = np.diag([2.0] * 3 + [2e-3] * 3), np.diag([1e8] * 3 + [1e5] * 3)
    found = []
    for arm in (np.zeros(3), np.array([0.02, 0.01, 0.05])):
        turn = about(arm)
        found.append(
            made(arm).stability(
                turn.T @ mass @ turn,
                turn.T @ stiffness @ turn,
                velocity=SPEED,
                density=density,
                pose=pose,
                modes=3,
                largest_friction=0.2,
            )
        )
    here, there = found
    # what displacements do to the arms of the load is left out, of the load over a stiffness and a length
    np.testing.assert_allclose(there.frequency, here.frequency, rtol=5e-6, atol=1e-6)
    # what flutters is a pair of one frequency, in either order
    growth = np.sort([here.growth, there.growth])
    np.testing.assert_allclose(growth[1], growth[0], atol=5e-4 * np.abs(growth).max())
    # and the state carries what one from balance does; poles that are found one by one then move as one
    carried = made(np.zeros(3)).step(pose=pose, velocity=SPEED)
    again = made(np.zeros(3)).step(pose=here.pose, velocity=SPEED)
    load = [np.r_[step.force[2], step.moment[:2] / 0.02] for step in (again, carried)]
    np.testing.assert_allclose(load[0], load[1], atol=1e-7 * abs(carried.force[2]))
    if made is not hung_shoe:
        np.testing.assert_allclose(again.pressure, carried.pressure, atol=1e-7 * carried.pressure.max())


@pytest.mark.coarse
def test_a_contact_from_a_file_finds_its_state(tmp_path: Path) -> None:
    arm = np.array([0.02, 0.01, 0.05])
    asked: dict[str, Any] = {
        "mass": [2.0] * 3 + [2e-3] * 3, "stiffness": [1e8] * 3 + [1e5] * 3, "velocity": SPEED,
        "largest_friction": 0.2,
    }  # fmt: skip
    for made in (hung_block, edge_held):
        made(arm).save(tmp_path / "it.mtbc", shift=True)
        again = mtb.PreparedContact.load(tmp_path / "it.mtbc").stability(**asked)
        np.testing.assert_allclose(again.frequency, made(arm).stability(**asked).frequency, rtol=1e-9)


def test_a_file_for_sliding_alone_is_refused(tmp_path: Path) -> None:
    block().save(tmp_path / "it.mtbc")
    with pytest.raises(ValueError, match=r"write it for steps with a shift \(shift=True in Python\)"):
        mtb.PreparedContact.load(tmp_path / "it.mtbc").stability([MASS, MASS], **XZ, velocity=SPEED)


def test_the_critical_coefficient_is_that_of_any_scene() -> None:
    """Also of one without friction, whose slip damps nothing yet."""
    held = [[5e8, 0.0, 1e8], [0.0, 4e8, 0.0], [1e8, 0.0, 2.5e8]]
    lower = mtb.Material(2e9, 0.4)
    found = [block(mu, lower=lower).stability([6.0] * 3, held, free=("x", "y", "z")) for mu in (0.0, 0.1)]
    critical = [one.critical_friction for one in found]
    assert critical[0] == pytest.approx(critical[1], rel=1e-9)
    # and is where the growths that are shown begin
    for one in found:
        assert one.critical_friction is not None
        grows = one.growing().any(axis=1)
        np.testing.assert_array_equal(grows, one.frictions >= one.critical_friction)


def test_what_stays_stable_is_said_to() -> None:
    """One degree of freedom has nothing to couple with."""
    found = block(0.2).stability([MASS], [1e7], free=["x"], largest_friction=2.0)
    assert found.critical_friction is None
    assert found.frictions[-1] == 2.0
    assert (found.growths == 0.0).all()


def test_what_is_kept_and_shown(tmp_path: Path) -> None:
    held = [[5e8, 3e8], [3e8, 2e8]]
    found = block().stability([MASS, MASS], held, **XZ, largest_friction=2.0)
    files = found.save(tmp_path)
    assert {file.suffix for file in files} == {".png", ".csv", ".json", ".npz"}
    assert mtb.load(tmp_path) == found
    assert found.plot().axes[0].get_xlabel() == "coefficient of friction [-]"
    assert found.animate(tmp_path / "mode.gif", mode=0).exists()
    said = dict(found.told())
    assert said["state of sliding"] == "stable"
    assert said["smallest unstable coefficient"].endswith("Hz")
    assert found.damping_ratio == pytest.approx(0.0, abs=1e-12)
    with pytest.raises(ValueError, match=r"^mode is 7: a number from 0 to 1 is needed"):
        found.animate(tmp_path / "mode.gif", mode=7)


@pytest.mark.parametrize(
    ("given", "why"),
    [
        ({"mass": [1.0, 2.0, 3.0]}, r"^mass has shape \(3,\): \(2,\) or \(2, 2\), for x, z, is needed"),
        ({"mass": [1.0, 0.0]}, r"^mass is \[1.0, 0.0\]: a mass > 0 is needed for each free component"),
        ({"mass": [[1.0, 0.5], [0.0, 1.0]]}, r"^mass is not symmetric"),
        ({"stiffness": [np.nan, 1.0]}, r"^stiffness"),
        ({"stiffness": 1e6}, r"^stiffness has shape \(\): \(2,\) or \(2, 2\)"),
        ({"free": ("x", "x")}, r"^free is \('x', 'x'\): different components of x, y, z, roll"),
        ({"free": ()}, r"^free is \(\): different"),
        ({"free": 3.0}, r"^free is 3.0: different"),
        ({"free": [["x"], ["z"]]}, r"^free is \[\['x'\], \['z'\]\]: different"),
        ({"velocity": 0.0}, r"^velocity is 0: the stability is that of a body that slides"),
        ({"pose": [0, 0, 1e-3, 0, 0, 0]}, r"^the bodies do not touch at this pose"),
        ({"largest_friction": -1.0}, r"^largest_friction is -1"),
    ],
)
def test_what_cannot_be_is_refused(given: dict[str, Any], why: str) -> None:
    with pytest.raises(ValueError, match=why):
        block().stability(**{"mass": [MASS, MASS], **XZ} | given)


def test_a_velocity_is_needed() -> None:
    contact = block(velocity=None)
    with pytest.raises(ValueError, match=r"^velocity is missing"):
        contact.stability([MASS, MASS], **XZ)
