# SPDX-License-Identifier: MIT OR Apache-2.0
"""Bodies that vibrate on their contact: energy, eigenvalues, closed forms, bodies stiff or at rest."""

from __future__ import annotations

import pickle
import re
import warnings
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import mtb_rs as mtb

Array = NDArray[np.float64]
pytestmark = [pytest.mark.coarse, pytest.mark.filterwarnings("ignore:.*The contact point")]

DENSITY, SPEED, MASS = 7850.0, 10.0, 6.0
#: Friction opens no gap.
SOFT = mtb.Material(2e9, 0.5)
SHEAR = 80e9
EVEN = mtb.Material.from_shear_modulus(SHEAR, 0.0)


def ball(friction: Any = 0.3, **given: Any) -> mtb.PreparedContact:
    words: dict[str, Any] = {"upper": mtb.Rigid(), "lower": SOFT, "width": 1e-2, "points": 12} | given
    scene = mtb.scenes.paraboloid_on_plane(radius=0.05, force=1e3, friction=friction, **words)
    return scene.prepare("half-space")


def shoe(friction: Any = 0.2, **given: Any) -> mtb.PreparedContact:
    words = {"supports": "clamped-top", "magnetic_pressure": 1e6, "spacing": 15e-3, "poles": 1} | given
    return mtb.scenes.pole_shoe_on_rail(friction=friction, velocity=SPEED, **words).prepare("elastic-upper")


def test_without_friction_the_energy_stays_to_second_order() -> None:
    """A ball bounces on its contact, whose area grows and shrinks: points open and close all the time."""
    contact = ball(friction=0.0, points=18)
    begun = 0.5 * MASS * 0.3**2 + sum(contact.vibrating(1e-6, [MASS], free=["z"]).energy())
    lost = []
    for steps in (40, 80, 160):
        period, work, counts = 4e-4, 0.0, []
        moving = contact.vibrating(period / steps, [MASS], free=["z"])
        state = moving.struck([0.3])
        for _ in range(steps):
            step = moving.step(0.0, state=state)
            state, work = step.state, work + step.load_work
            counts.append(np.count_nonzero(step.status))
        assert max(counts) > 2 * min(counts)
        lost.append(abs(step.energy - work - begun))
    assert lost[0] < 1e-2 * 0.5 * MASS * 0.3**2
    assert lost[0] / lost[1] == pytest.approx(4.0, rel=0.5)
    assert lost[1] / lost[2] == pytest.approx(4.0, rel=0.5)


@pytest.mark.parametrize("slides", [True, False])
def test_what_the_energy_loses_is_what_friction_turns_into_heat(slides: bool) -> None:
    """Of an elastic shoe, to rounding; stresses do no work that is not accounted for."""
    moving = shoe().vibrating(2e-6, density=DENSITY, modes=6, velocity=SPEED if slides else 0.0)
    heat, seen = 0.0, set()
    rng = np.random.default_rng(2)
    state = moving.struck(rng.normal(size=len(moving.coordinates)) * (1e-2 if slides else 1e-4))
    before = sum(moving.energy(state))
    for k in range(60):
        step = moving.step(None if slides else 3e-8 * np.sin(0.3 * k), state=state)
        state = step.state
        change = step.drive_work + step.load_work - step.friction_work + step.closing_work
        size = abs(step.drive_work) + abs(step.load_work) + step.friction_work + step.energy
        assert step.energy - before == pytest.approx(change, abs=1e-10 * size)
        assert step.friction_work >= -1e-12 * size
        before, heat = step.energy, heat + step.friction_work
        seen |= set(step.status.tolist())
    assert heat > 0.0
    assert (1 in seen) != slides


def test_a_body_on_a_spring_sticks_and_slips_as_piece_by_piece_in_closed_form() -> None:
    """Half-spaces without Poisson's ratio: full slip is friction of a constant size."""
    load, mu, mass = 1e3, 0.3, 2.0
    contact = ball(mu, upper=EVEN, lower=EVEN, width=3e-3, points=8)
    stiffness = 1e5
    omega = np.sqrt(stiffness / mass)
    dt = 2.0 * np.pi / omega / 400
    moving = contact.vibrating(dt, [mass], [stiffness], free=["x"], velocity=0.0)
    # drawn far by a slow load and let go, it comes to rest after some half swings
    far = 3.5 * 2.0 * mu * load / stiffness
    for k in range(400):
        share = 0.5 * (1.0 - np.cos(np.pi * (k + 1) / 400))
        moving.step(0.0, [share * (stiffness * far + mu * load)])
    ways = np.array([moving.step(0.0, [0.0]).state.amplitude[0] for _ in range(2000)])
    turns = np.flatnonzero((np.diff(ways[:-1]) * np.diff(ways[1:])) < 0.0) + 1
    # half swings are shorter by the same amount, as long as it slips
    swings = ways[turns[:3]]
    assert np.diff(np.abs(swings)) == pytest.approx(-2.0 * mu * load / stiffness, rel=0.03)
    # it rests where the spring does not move it
    assert abs(ways[-1]) <= 1.02 * mu * load / stiffness


def test_the_growth_in_time_is_that_of_the_eigenvalue() -> None:
    """Flutter of an elastic shoe, whose vibrations count, by its steps and by its tangent."""
    contact, mass = shoe(0.6), np.array([60.0, 60.0])
    alone = contact.stability(mass, 1e6 * np.ones(2), free=("x", "z"))
    normal = alone.stiffness[1, 1]
    held = normal * np.array([[1.0, 0.15], [0.15, 0.0]])
    words: dict[str, Any] = {"free": ("x", "z"), "density": DENSITY, "modes": 6}
    found = contact.stability(mass, held, **words, largest_friction=0.7)
    worst = int(found.growth.argmax())
    assert found.kind == "flutter"
    rate, swing = found.growth[worst], found.frequency[worst]
    dt = 1.0 / swing / 100
    moving = contact.vibrating(dt, mass, held, **words, velocity=SPEED)
    mode = found.modes[worst] * found.eigenvalues[worst]
    # both its parts, so small that no point opens
    state = moving.struck(1e-10 * mode.real)
    sizes = []
    count = 100 * max(6, round(6.0 / (rate / swing)))
    count = min(count, 3000)
    for _ in range(count):
        step = moving.step(state=state)
        state = step.state
        shape = np.linalg.norm(np.sqrt(np.diag(moving.mass)) * state.rate)
        sizes.append(shape)
    late = [max(sizes[k : k + 100]) for k in (count - 500, count - 100)]
    grown = np.log(late[1] / late[0]) / (400 * dt)
    assert grown == pytest.approx(rate, rel=0.02)


def lined_block(friction: float, velocity: float) -> mtb.PreparedContact:
    """A rigid block on a lining whose gap friction opens."""
    lining = mtb.Material(2e9, 0.4)
    scene = mtb.scenes.block_on_plane(
        friction=friction, velocity=velocity, spacing=20e-3, upper=mtb.Rigid(), lower=lining
    )
    return scene.prepare("half-space")


#: Of a rigid block by all six components.
HELD: dict[str, Any] = {"mass": [30.0] * 3 + [0.5] * 3, "stiffness": [1e8, 1.3e8, 1e8, 1e5, 4e5, 2e5]}


@pytest.mark.parametrize("which", [0, 1, 2, 5])
def test_the_decay_in_time_of_a_rigid_block_is_that_of_the_eigenvalue(which: int) -> None:
    """It rolls, yaws and moves across, and the faces move along each other as the pressure changes."""
    # so quick that they follow without delay
    contact, steps = lined_block(0.3, 5.0), 120
    found = contact.stability(**HELD)
    swing, rate = found.frequency[which], found.growth[which]
    moving = contact.vibrating(1.0 / swing / steps, pose=found.pose, **HELD)
    shape = found.modes[which].real
    state, seen = moving.struck(1e-10 * 2.0 * np.pi * swing * shape), []
    for _ in range(20 * steps):
        state = moving.step(state=state).state
        seen.append(shape @ found.mass @ state.rate)
    # the part that swings at this frequency, over the first and the last periods
    turned = np.array(seen) * np.exp(-2.0j * np.pi * np.arange(len(seen)) / steps)
    first, last = (np.abs(turned[k : k + 5 * steps].mean()) for k in (0, 15 * steps))
    assert np.log(last / first) * swing / 15.0 == pytest.approx(rate, rel=0.01)


@pytest.mark.parametrize("friction", [0.02, 0.3])
@pytest.mark.parametrize("velocity", [5e-3, 0.5])
def test_constant_friction_feeds_no_vibration_that_couples_with_none(
    friction: float, velocity: float
) -> None:
    found = lined_block(friction, velocity).stability(**HELD)
    assert found.kind == "stable"
    assert found.critical_friction is None


def driven(spacing: float) -> tuple[mtb.PreparedContact, dict[str, Any]]:
    """A block that its supports leave free to move along z and to pitch, and what moves of it."""
    scene = mtb.scenes.block_on_plane(friction=0.2, velocity=SPEED, spacing=spacing, supports="driven-top")
    return scene.prepare("elastic-upper"), {"mass": [8.0, 0.02], "free": ("z", "pitch")}


def test_the_decay_in_time_is_that_of_the_eigenvalue() -> None:
    """Friction damps by how the faces themselves move along each other, however they deform."""
    contact, words = driven(25e-3)
    words |= {"density": 100.0, "modes": 4}
    found = contact.stability(**words)
    # without pairs of vibrations that couple small friction feeds nothing: it takes power from each of them
    assert found.kind == "stable"
    assert found.critical_friction is None or found.critical_friction > 0.1
    which = 3
    swing = found.frequency[which]
    moving = contact.vibrating(1.0 / swing / 60, velocity=SPEED, **words)
    shape = found.modes[which] * found.eigenvalues[which]
    state, seen = moving.struck(1e-10 * shape.real), []
    left = found.mass @ found.modes[which].real
    for _ in range(60 * 14):
        state = moving.step(state=state).state
        seen.append(left @ state.rate)
    # the part that swings at this frequency, over the first and the last periods
    turned = np.array(seen) * np.exp(-2.0j * np.pi * np.arange(len(seen)) / 60)
    first, last = (np.abs(turned[k : k + 300].mean()) for k in (0, len(seen) - 300))
    decay = np.log(last / first) / ((len(seen) - 300) / 60 / swing)
    assert decay == pytest.approx(found.growth[which], rel=0.03)


#: Falls by 0.05 s/m at 5 m/s, where it is 0.3.
FALLING = mtb.VelocityTable((0.0, 4.0, 6.0, 100.0), (0.4, 0.35, 0.25, 0.2))


def growth(contact: mtb.PreparedContact, mass: float, stiffness: float, free: str) -> float:
    """Of a body with one free component in time [1/s], by the peaks of the first and the last periods."""
    steps, periods = 60, 30
    swing = contact.stability([mass], [stiffness], free=[free]).frequency[0]
    moving = contact.vibrating(1.0 / swing / steps, [mass], [stiffness], free=[free])
    state, seen = moving.struck([1e-3]), []
    for _ in range(steps * periods):
        state = moving.step(state=state).state
        seen.append(state.amplitude[0])
    turned = np.array(seen) * np.exp(-2.0j * np.pi * np.arange(len(seen)) / steps)
    means = np.abs(turned.reshape(periods, steps).mean(axis=1))
    return float(np.polyfit(np.arange(periods) / swing, np.log(means), 1)[0])


def long_block(upper: Any, lower: Any, model: Any) -> mtb.PreparedContact:
    """A block on a table of friction that falls."""
    scene = mtb.scenes.block_on_plane(
        width=0.04, length=0.16, height=0.05, friction=FALLING, velocity=5.0, spacing=10e-3,
        upper=upper, lower=lower, magnetic_pressure=1e6,
    )  # fmt: skip
    return scene.prepare(model, reference_point=(0.0, 0.0, 0.05))


def test_falling_friction_feeds_what_turns_by_the_speed_of_each_point() -> None:
    """A rigid block that yaws: each point of it at its place across slides faster or slower."""
    contact = long_block(mtb.Rigid(), mtb.Material(2e9, 0.4), "half-space")
    force, (x, y) = contact.step().pressure * contact.area, contact.points[:2]
    # as the friction falls along the velocity, and turns across it
    damping = -0.05 * (force @ y**2) + 0.3 / 5.0 * (force @ x**2)
    assert damping < 0.0
    # what the lining gives way in a period is left out
    assert growth(contact, 0.05, 1e5, "yaw") == pytest.approx(-0.5 * damping / 0.05, rel=0.005)


def test_falling_friction_feeds_what_pitches_as_the_faces_move() -> None:
    """An elastic block, whose points have one speed but for what pressure and friction move its face."""
    contact = long_block(mtb.steel, mtb.steel, "elastic-upper")
    found = contact.stability([0.05], [1e5], free=["pitch"])
    assert found.growth[0] > 0.0
    # what the faces move counts at the mean rate of a step, of which there are 60 in a period
    assert growth(contact, 0.05, 1e5, "pitch") == pytest.approx(found.growth[0], rel=0.01)


def caught(dt: float, **given: Any) -> mtb.VibratingContact:
    """A rigid block on a spring, on a belt slow enough to catch it."""
    scene = mtb.scenes.block_on_plane(
        width=0.04, length=0.04, height=0.05, friction=0.4, velocity=0.05, spacing=8e-3, upper=mtb.Rigid(),
        lower=mtb.Material(2.08e11, 0.3), magnetic_pressure=1e6,
    )  # fmt: skip
    return scene.prepare("half-space").vibrating(dt, [MASS], [1e6], free=["x"], **given)


def run(moving: mtb.VibratingContact, steps: int) -> int:
    """Steps after a strike that the belt ends, and in how many of them a point sticks."""
    state, stuck = moving.struck([-0.2]), 0
    for _ in range(steps):
        step = moving.step(state=state)
        state, stuck = step.state, stuck + int((step.status == 1).any())
    return stuck


def test_steps_too_long_for_points_that_stick_are_asked_about_with_the_period_at_which_they_ring() -> None:
    # too small a strike for points inside to slip
    moving, ways = caught(2e-6, velocity=0.0), []
    state = moving.struck([1e-7])
    for _ in range(400):
        state = moving.step(state=state).state
        ways.append(state.amplitude[0])
    rises = [k for k in range(1, len(ways)) if ways[k - 1] < 0.0 <= ways[k]]
    period = 2e-6 * (rises[-1] - rises[0]) / (len(rises) - 1)

    moving = caught(1e-4)
    with pytest.warns(UserWarning, match="points stick") as asked:
        run(moving, 200)
    [told] = [str(one.message) for one in asked]
    assert float(told.split("a period of ")[1].split()[0]) == pytest.approx(period, rel=0.03)
    # once, in copies as well
    for again in (moving, moving.copy(), pickle.loads(pickle.dumps(moving))):
        run(again, 20)

    assert run(caught(period / 5.0), 2000) > 0


@pytest.mark.parametrize("before", ["nothing", "rest", "pressed", "pushed aside"])
def test_what_happened_before_a_mass_is_drawn_along_asks_no_less(before: str) -> None:
    scene = mtb.scenes.pole_shoe_on_rail(
        friction=0.3, spacing=12e-3, velocity=0.05, magnetic_pressure=1e6, poles=1
    )
    moving = scene.prepare("elastic-upper").vibrating(
        1e-4, [5.0, 40.0, 5.0], [1e6, 1e6, 1e6], free=("x", "y", "z"), velocity=0.0
    )
    loads = {"nothing": [], "rest": [0.0] * 3, "pressed": [0.0, 0.0, -5.0], "pushed aside": [0.0, 20.0, 0.0]}
    # nothing has slipped
    for _ in range(3 if before != "nothing" else 0):
        moving.step(0.0, loads[before])

    def drawn() -> None:
        for _ in range(200):
            moving.step(0.05e-4)

    with pytest.warns(UserWarning, match="points stick"):
        drawn()


@pytest.mark.filterwarnings("ignore:points stick")  # friction that falls feeds what coarse steps lose
def test_a_limit_cycle_on_a_falling_table_is_that_of_one_mass() -> None:
    """It sticks and slips: beside an integration of its own, of a mass without a contact."""
    mass, spring, speed, force = 10.0, 2e5, 0.03, 1600.0
    table = mtb.VelocityTable((0.0, 0.02, 0.1, 1.0), (0.5, 0.3, 0.2, 0.15))
    swing = np.sqrt(spring / mass)
    held = force * np.interp(speed, table.velocity, table.value)
    way, rate, sticks, ways = 0.0, 1e-3, False, []
    dt = 2.0 * np.pi / swing / 4000
    for k in range(40 * 4000):
        push = held - spring * way
        slip = speed + rate
        if sticks:
            sticks = abs(push) <= 0.5 * force
            rate = -speed if sticks else rate + dt * (push - np.copysign(0.5 * force, push)) / mass
        else:
            rubbing = force * np.interp(abs(slip), table.velocity, table.value)
            after = rate + dt * (push - np.copysign(rubbing, slip)) / mass
            sticks = (speed + after) * slip <= 0.0 and abs(push) <= 0.5 * force
            rate = -speed if sticks else after
        way += dt * rate
        if k > 35 * 4000:
            ways.append(way)
    own = 0.5 * np.ptp(ways)
    scene = mtb.scenes.block_on_plane(
        width=0.04, length=0.04, height=0.05, friction=table, velocity=speed, spacing=20e-3,
        upper=mtb.Rigid(), lower=mtb.Material(2.08e11, 0.3), magnetic_pressure=1e6,
    )  # fmt: skip
    # friction that falls by 10 s/m feeds the mass within 1/1600 s, which is 2.8 steps
    steps = 200
    moving = scene.prepare("half-space").vibrating(2.0 * np.pi / swing / steps, [mass], [spring], free=["x"])
    state, found, status = moving.struck([1e-3]), [], set()
    for k in range(40 * steps):
        step = moving.step(state=state)
        state = step.state
        status |= set(step.status.tolist())
        if k > 35 * steps:
            found.append(state.amplitude[0])
    assert status == {1, 2}
    assert 0.5 * np.ptp(found) == pytest.approx(own, rel=0.01)


def lowest(found: mtb.Stability) -> Array:
    """The two lowest frequencies, and the growths there, rising."""
    return np.concatenate([found.frequency[:2], np.sort(found.growth[:2])])


def test_stiff_bodies_are_rigid_and_kept_vibrations_count_once() -> None:
    contact = shoe(0.4)
    mass = np.array([60.0, 60.0])
    words: dict[str, Any] = {"free": ("x", "z"), "largest_friction": 0.5}
    normal = contact.stability(mass, 1e6 * np.ones(2), **words).stiffness[1, 1]
    held = normal * np.array([[1.0, 0.15], [0.15, 0.0]])
    rigid = contact.stability(mass, held, **words)
    assert rigid.kind == "flutter"
    # so quick that turning friction damps nothing: the least damping lowers the critical friction
    quick = words | {"velocity": 1e12}
    still = contact.stability(mass, held, **quick)
    # without inertia of its own the body is what it is at rest, however many vibrations carry it
    for modes in (1, 8):
        light = contact.stability(mass, held, **quick, density=0.1, modes=modes)
        assert lowest(light) == pytest.approx(lowest(rigid), rel=1e-5)
        # frequencies that meet are known to the root of the rounding of the highest one
        assert light.critical_friction == pytest.approx(still.critical_friction, rel=1e-2)
    # its own inertia moves the result by more than what further vibrations would
    whole, more = (contact.stability(mass, held, **words, density=DENSITY, modes=k) for k in (8, 16))
    effect, left = lowest(whole) - lowest(rigid), lowest(more) - lowest(whole)
    assert np.abs(effect[:2]).max() > 1e-4 * rigid.frequency[0]
    assert np.abs(left).max() < 0.2 * np.abs(effect).max()


@pytest.mark.parametrize("modes", [1, 4])
def test_a_light_shoe_is_damped_as_a_massless_one(modes: int) -> None:
    """On a curved head, by all six components: two ways to take the slip of the faces."""
    contact = shoe(0.1)
    # so quick that the faces follow without delay
    words = HELD | {"velocity": 50.0}
    massless = contact.stability(**words)
    light = contact.stability(**words, density=0.1, modes=modes, pose=massless.pose)
    assert light.frequency[:6] == pytest.approx(massless.frequency, rel=1e-6)
    assert np.count_nonzero(massless.growth < -1e-5) == 5
    # a light body has a share of the mass of 1e-6
    assert light.growth[:6] == pytest.approx(massless.growth, rel=1e-5, abs=1e-9)


def test_a_body_that_its_supports_leave_free_is_stiff_as_its_elements_are_fine() -> None:
    """Vibrations on the contact of a body that hardly has inertia of its own, and of one that has none."""
    found = []
    for spacing in (25e-3, 12.5e-3):
        contact, words = driven(spacing)
        found.append(contact.stability(**words).frequency)
        light = contact.stability(**words, density=0.1, modes=4)
        assert light.frequency[:2] == pytest.approx(found[-1], rel=1e-4)
    assert found[0] == pytest.approx(found[1], rel=0.06)


def test_a_mass_below_that_of_its_vibrations_is_refused() -> None:
    contact = shoe()
    body = contact.reduced(DENSITY, 8)
    carried = (body.participation[:, :3] ** 2).sum(axis=0)
    assert (carried < body.mass).all()
    assert carried[0] > 0.5 * body.mass
    with pytest.raises(ValueError, match=r"^mass along x is .* kg, and the body alone has"):
        contact.vibrating(1e-6, [0.4 * body.mass] * 2, 1e8 * np.ones(2), free=("x", "z"), density=DENSITY)


def test_at_rest_it_stays_and_under_a_steady_load_it_is_a_static_contact() -> None:
    """A damper takes the vibrations; what is left is the step of the prepared contact at that place."""
    contact = ball(0.0)
    moving = contact.vibrating(1e-4, [MASS], [0.0], [2.0 * MASS * 4e3], free=["z"], velocity=0.0)
    start = moving.state
    step = moving.step(0.0)
    assert np.abs(step.state.pressure - start.pressure).max() < 1e-9 * start.pressure.max()
    assert np.abs(step.state.rate).max() < 1e-12
    for _ in range(600):
        step = moving.step(0.0, [-500.0])
    assert step.force[2] == pytest.approx(-1500.0, rel=1e-6)
    there = contact.copy().step(velocity=1.0)
    assert there.force[2] == pytest.approx(-1000.0, rel=1e-9)
    pose = np.zeros(6)
    pose[2] = contact.copy().step(velocity=1.0).state.motion[0] + step.state.amplitude[0]
    same = contact.copy().step(pose, velocity=1.0)
    assert np.abs(same.pressure - step.state.pressure).max() < 1e-6 * same.pressure.max()


def test_bodies_that_supports_leave_free_move_by_their_own_inertia() -> None:
    """A shoe that may rise and tilt: in balance it stays, and a blow rises it by its momentum."""
    scene = mtb.scenes.pole_shoe_on_rail(friction=0.0, spacing=15e-3, poles=1, magnetic_pressure=1e5)
    contact = scene.prepare("elastic-upper")
    body = contact.reduced(DENSITY, 3)
    moving = contact.vibrating(1e-5, density=DENSITY, modes=3, velocity=SPEED)
    free = len(body.rigid)
    assert moving.coordinates[:2] == ("upper rigid 0", "upper rigid 1")
    assert len(moving.coordinates) == free + 3
    begun = moving.state
    for _ in range(20):
        step = moving.step()
    assert np.abs(step.state.pressure - begun.pressure).max() < 1e-6 * begun.pressure.max()
    # so fast that it leaves the rail: then the pull alone slows it
    rise = body.rigid[:, 2].mean(axis=1)
    blow = np.concatenate([rise / (rise @ rise) * 5.0, np.zeros(3)])
    step = moving.step(state=moving.struck(blow))
    while step.status.any():
        step = moving.step()
    before = step.state.rate[:free] @ rise
    for _ in range(50):
        step = moving.step()
    assert not step.status.any()
    slowed = (before - step.state.rate[:free] @ rise) / (50 * moving.dt)
    pull = 1e5 * contact.area.sum()
    assert slowed == pytest.approx(pull / body.mass, rel=0.05)


@pytest.mark.parametrize(
    ("given", "why"),
    [
        ({}, r"^nothing moves: mass with the components that are free, or the density of an elastic body"),
        ({"free": ["x"]}, r"^mass is missing: that of x is needed"),
        ({"free": 3.0}, r"^free is 3.0: different components"),
        ({"mass": [1.0], "free": [["x"]]}, r"^free is \[\['x'\]\]: different components"),
        (
            {"density": {"upper": DENSITY}, "modes": 10**400},
            r"^modes is 10+\.\.\.: a whole number of at most",
        ),
        ({"mass": [1.0], "free": ["w"]}, r"^free is \['w'\]"),
        ({"dt": 0.0, "mass": [1.0], "free": ["x"]}, r"^dt is 0"),
        ({"density": DENSITY}, r"^body is 'upper': a body of finite elements is needed in this model"),
        ({"density": {"both": DENSITY}}, r"^density of is 'both'"),
    ],
)
def test_what_cannot_be_is_refused(given: dict[str, Any], why: str) -> None:
    with pytest.raises(ValueError, match=why):
        ball().vibrating(**{"dt": 1e-6} | given)


def test_states_go_on_where_they_were_left() -> None:
    moving = ball().vibrating(1e-5, [MASS, MASS], [1e7, 0.0], free=["x", "z"], velocity=0.0)
    first = [moving.step(1e-7) for _ in range(4)]
    again = moving.step(1e-7, state=first[1].state)
    assert np.abs(again.state.traction - first[2].state.traction).max() < 1e-9 * again.state.pressure.max()
    # copies and other processes go on by themselves, by the same steps
    copies = [moving.copy(), pickle.loads(pickle.dumps(moving))]
    on = moving.step(1e-7)
    for other in copies:
        step = other.step(1e-7)
        assert np.abs(step.state.traction - on.state.traction).max() < 1e-9 * on.state.pressure.max()
    with pytest.raises(ValueError, match=r"^state is 5: a VibratingState"):
        moving.step(state=5)  # type: ignore[arg-type]
    with pytest.raises(ValueError, match=r"^load has shape \(3,\): a number or \(2,\) is needed"):
        moving.step(load=[1.0, 2.0, 3.0])


@pytest.mark.parametrize("dt", [1e-3, 1e-4, 1e-5, 1e-6])
def test_friction_that_rises_is_found_where_a_body_is_driven_to_and_fro(dt: float) -> None:
    """Reversals, in steps from far too long to far shorter than the contact takes to follow."""
    speeds, coefficients = [0.0, 0.02, 0.1, 50.0], [0.1, 0.2, 0.3, 0.4]
    scene = mtb.scenes.block_on_plane(
        friction=mtb.VelocityTable(speeds, coefficients), velocity=0.05, spacing=0.025,
        upper=mtb.Rigid(), lower=mtb.Material(2e9, 0.4),
    )  # fmt: skip
    made = scene.prepare("half-space").vibrating(dt, [8.0], [5e6], free=("x",))
    missed = []
    with warnings.catch_warnings():
        # of the long steps it asks how the mass rings
        warnings.simplefilter("ignore")
        for k in range(100):
            step = made.step(0.05 * dt * (-1) ** (k // 20))
            carried = np.hypot(*step.state.traction) / np.where(
                step.state.pressure > 0.0, step.state.pressure, 1.0
            )
            assert (carried <= np.interp(np.inf, speeds, coefficients)).all()
            slips = step.status == 2
            speed = np.linalg.norm(step.slip, axis=0) / dt
            law = np.interp(speed, speeds, coefficients)
            missed.append(np.abs(carried - law)[slips].max(initial=0.0))
    if dt <= 1e-6:
        # the speed of the end of a short step is its mean one
        assert max(missed) < 5e-3


def test_steps_below_what_falling_friction_bears_are_asked_about() -> None:
    """The largest eigenvalue of the fall times the pressure times the compliance, of points without mass."""
    law = mtb.VelocityTable([0.0, 0.02, 0.1, 50.0], [0.4, 0.2, 0.18, 0.1])
    contact = mtb.scenes.pole_shoe_on_rail(
        friction=law, velocity=0.012, spacing=12e-3, poles=1, supports="clamped-top"
    ).prepare("elastic-upper")
    held: dict[str, Any] = {"mass": [50.0], "stiffness": [1e7], "damping": [5e4], "free": ("x",)}
    made = contact.vibrating(1e-4, **held)
    p = made.state.pressure
    on = np.flatnonzero(p > 0.0)
    time = np.abs(np.linalg.eigvals(10.0 * p[on, None] * made._parts[0][0][np.ix_(on, on)])).max()

    def swing(dt: float) -> float:
        made = contact.vibrating(dt, **held)
        state, forces = made.struck([1e-6]), []
        for _ in range(150):
            step = made.step(state=state)
            state = step.state
            forces.append(step.force[0])
        return float(np.ptp(forces[-50:]))

    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert swing(2.2 * time) < 1e-2
    with pytest.warns(UserWarning, match="Take a dt of .* s or more"):
        assert swing(1.5 * time) > 50.0


@pytest.mark.parametrize(("dt", "asks"), [(1e-4, False), (6.4e-5, False), (5e-5, True), (2.5e-5, True)])
def test_points_that_run_over_the_steep_part_of_a_table_are_asked_about(dt: float, asks: bool) -> None:
    """They stick in one step and are on its flat part in the next one; below 63 µs the heat is wrong."""
    law = mtb.VelocityTable([0.0, 0.5, 2.0, 20.0], [0.4, 0.3, 0.2, 0.15])
    contact = mtb.scenes.block_on_plane(
        0.1, 0.05, law, spacing=0.025, upper=mtb.Rigid(), lower=mtb.Material(2e9, 0.4), velocity=0.3
    ).prepare("half-space")
    made = contact.vibrating(dt, mass=[6.0], stiffness=[1e6], damping=[100.0], free=["x"], velocity=0.3)
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        heat = sum(made.step((0.3 - 30.0 * (k + 0.5) * dt) * dt).friction_work for k in range(int(0.01 / dt)))
    assert any("have no mass" in str(one.message) for one in told) == asks
    assert (heat == pytest.approx(5.2, rel=0.02)) != asks
    if asks:
        advised = float(re.findall(r"Take a dt of (\S+) s", "".join(str(one.message) for one in told))[0])
        assert 6.31e-5 < advised < 6.6e-5


def test_a_state_whose_pressure_pulls_is_refused() -> None:
    made = (
        mtb.scenes.block_on_plane(friction=0.3, velocity=4.0, spacing=0.05)
        .prepare("half-space")
        .vibrating(1e-5, [6.0], [5e8], free=("x",))
    )
    state = made.state
    pulled = state.pressure.copy()
    pulled[1] = -1.0
    with pytest.raises(ValueError, match=r"state\.pressure\[1\] is -1: pressures of at least 0"):
        made.step(state=mtb.VibratingState(state.traction, pulled, state.amplitude, state.rate, state.load))


def test_springs_that_keep_no_energy_are_refused() -> None:
    contact = mtb.scenes.block_on_plane(friction=0.3, velocity=4.0, spacing=0.05).prepare("half-space")
    with pytest.raises(ValueError, match="stiffness is not symmetric"):
        contact.vibrating(1e-5, [6.0, 6.0], [[5e8, 3e8], [-1e8, 2.5e8]], free=("x", "z"))
