# SPDX-License-Identifier: MIT OR Apache-2.0
"""Transient steps of wheels: general solver, a model in NumPy, Cattaneo's shift, limits, memory handed on."""

import copy
import itertools
import math
import pickle
from dataclasses import replace
from functools import lru_cache
from typing import Any

import numpy as np
import pytest

import mtb_rs as mtb

# a flange under these forces is loaded above the hardness
pytestmark = pytest.mark.filterwarnings("ignore:the peak pressure is")

V, RADIUS, HEAD = 20.0, 0.46, 0.3
FREE = float("nan")
#: Young's modulus 2 G and Poisson's ratio 0: tractions along x and y do not mix, and do what pressures do.
PLAIN = mtb.Material(160e9, 0.0)


def cone(slope):
    return mtb.Profile.from_points([-0.05, 0.05], [-0.05 * slope, 0.05 * slope], "linear")


def round_head():
    angle = np.linspace(-0.12, 0.12, 1601)
    y, z = HEAD * np.sin(angle), HEAD * (np.cos(angle) - 1.0)
    # a flank, for the gauge to be measured at
    return mtb.Profile.from_points(np.r_[y[0] - 2e-3, y], np.r_[z[0] - 30e-3, z], "linear")


def hollow(depth=1.5e-4):
    """A cone worn hollow where it rolls: two places on nearly one plane touch, 11 mm apart."""
    y = np.linspace(-0.05, 0.05, 2001)
    return mtb.Profile.from_points(y, 0.025 * y + depth * np.exp(-(((y + 4e-3) / 4e-3) ** 2)))


def flat_wheel():
    angle = np.radians(np.arange(-180.0, 180.01, 0.25))
    near = np.abs(angle) < np.radians(4.0)
    departure = np.where(near, -3e-4 * np.cos(0.5 * np.pi * angle / np.radians(4.0)) ** 2, 0.0)
    return mtb.WheelSlices.out_of_round("S1002", angle, departure, name="flat")


@lru_cache
def made(kind="S1002", spacing=1e-3, lower=mtb.steel, upper=mtb.steel):
    given = dict(lateral=0.0, force=60e3, spacing=spacing, lower=lower, upper=upper, wheel_radius=RADIUS)
    if kind in ("cone", "upright", "hollow"):
        wheel = hollow() if kind == "hollow" else cone(0.05 if kind == "cone" else 0.0)
        return mtb.scenes.wheel_on_rail(wheel=wheel, rail=round_head(), rail_inclination=0.0, **given)
    if kind == "flat":
        return mtb.scenes.wheel_on_rail(flat_wheel(), "60E1", **given)
    return mtb.scenes.wheel_on_rail(**given)


def exact(wheels):
    """Solved far better than the cells make: differences of steps are then no noise of the solver."""
    return mtb.PreparedWheels(wheels._core.to_accuracy(1e-13, 1e-11, 1e-11))


def spacing_of(patch):
    return float(patch.x[1] - patch.x[0]), float(patch.y[1] - patch.y[0])


def frame(step, patch):
    """Origin of a patch as of a left wheel, x from the reference point; its slope; the mirror."""
    mirror = 1.0 if patch.side == "left" else -1.0
    at = patch.position - np.array([step.reference_point[0], 0.0, 0.0])
    return at * [1.0, mirror, 1.0], patch.contact_angle, mirror


def moved(before, now, dt):
    """How far the frame of the one patch of a step has moved over the particles [m]."""
    (old, new) = (frame(step, step.patches[0]) for step in (before, now))
    angle = 0.5 * (old[1] + new[1])
    away = new[0] - old[0]
    across = (away[1] * math.cos(angle) + away[2] * math.sin(angle)) * new[2]
    return np.array([away[0] + now.patches[0].rolling_speed * dt, across])


def on_lines(patch, field, lines):
    """A field of a patch on other lines of its frame, in spacings; 0 beside it."""
    (x, y), spacing = lines, spacing_of(patch)
    found = np.zeros((y.size, x.size))
    i, j = (np.round(at[0] / h).astype(int) for at, h in zip((patch.x, patch.y), spacing, strict=True))
    i, j = i - x[0], j - y[0]
    found[j : j + patch.y.size, i : i + patch.x.size] = field
    return found


def seen_between(field, way, shares):
    """A field (..., ny, nx) where a `way` (cells) leads, by shares of cells along x and across."""
    found = np.zeros_like(field)
    for (i, along), (j, across) in itertools.product(
        *(share(w) for share, w in zip(shares, way, strict=True))
    ):
        found += along * across * np.roll(field, (-j, -i), axis=(-2, -1))
    return found


def linear(way):
    """Between two cells; a twentieth more than whole cells is beyond the second of them."""
    base = max(0, math.ceil(abs(way) - 1.05))
    sense = -1 if way < 0.0 else 1
    return [(sense * base, 1.0 + base - abs(way)), (sense * (base + 1), abs(way) - base)]


def cubic(way):
    """Hermite's cubic with the slopes of the chords over two cells."""
    low = math.floor(way)
    t = way - low
    slope = (t * (1 - t) ** 2, -t * t * (1 - t))
    shares = [0.0, (1 + 2 * t) * (1 - t) ** 2, t * t * (3 - 2 * t), 0.0]
    for k in (0, 1):
        shares[k + 2] += 0.5 * slope[k]
        shares[k] -= 0.5 * slope[k]
    return [(low - 1 + k, share) for k, share in enumerate(shares)]


def bilinear(way):
    """Between the two nearest cells."""
    low = math.floor(way)
    return [(low, 1.0 - way + low), (low + 1, way - low)]


def on_grid(field, state, to):
    """A field of a state on the grid of another one; its end values beyond."""
    i, j = (round((b - a) / h) for a, b, h in zip(state.origin, to.origin, state.spacing, strict=True))
    ny, nx = to.pressure.shape
    rows = np.clip(np.arange(j, j + ny), 0, field.shape[-2] - 1)
    columns = np.clip(np.arange(i, i + nx), 0, field.shape[-1] - 1)
    return field[..., rows[:, None], columns]


#: Cells beside a patch, so that nothing is carried over an end.
BESIDE = 5


def by_general_solver(before, now, dt, state, friction, bodies, layer):
    """Traction and status by `solve_tangential`, heat [W] and state.

    In parts of a cell and a twentieth at most, in which pressure and creepages change evenly, on the lines
    of both. What earlier tractions did is linear along x between cells and cubic across: as if they were
    mixed with those of the cells around, and had rolled by one cell.
    """
    (patch,) = now.patches
    spacing = spacing_of(patch)
    patches = [patch] if before is None else [*before.patches, patch]
    lines = [
        np.arange(
            min(round(p[at][0] / h) for p in ({"x": q.x, "y": q.y} for q in patches)) - BESIDE,
            max(round(p[at][-1] / h) for p in ({"x": q.x, "y": q.y} for q in patches)) + 1 + BESIDE,
        )
        for at, h in zip(("x", "y"), spacing, strict=True)
    ]
    pressure = on_lines(patch, patch.pressure, lines)
    old = pressure if before is None else on_lines(patches[0], patches[0].pressure, lines)
    way = np.array([patch.rolling_speed * dt, 0.0]) if before is None else moved(before, now, dt)
    parts = max(1, math.ceil(abs(patch.rolling_speed) * dt / spacing[0] - 0.05))
    way, dt = way / parts / spacing, dt / parts
    rolled = patch.rolling_speed * dt
    sense = math.copysign(1.0, rolled)
    last = patch.creepage if before is None else patches[0].creepage
    lower, upper = bodies
    start = (float(lines[0][0] * spacing[0]), float(lines[1][0] * spacing[1]))
    heat = 0.0
    for k in range(1, parts + 1):
        if state is not None:
            shares = (linear, cubic)
            field = mtb.PressureField(old, spacing, lower, upper, start)
            traction, pressed, mu = (
                on_grid(f, state, field) for f in (state.traction, state.pressure, state.coefficient)
            )
            state = mtb.TangentialState(
                seen_between(np.roll(traction, int(sense), axis=-1), way, shares),
                np.maximum(0.0, seen_between(np.roll(pressed, int(sense), axis=-1), way, shares)),
                seen_between(np.roll(mu, int(sense), axis=-1), way, (bilinear, bilinear)),
                start,
                spacing,
            )
        motion = mtb.Rolling(
            creepage=(last + k / parts * (patch.creepage - last)) * abs(rolled) / spacing[0],
            angle=0.0 if sense > 0.0 else math.pi,
            velocity=spacing[0] / dt,
            transient=True,
            step=spacing[0],
        )
        field = mtb.PressureField(old + k / parts * (pressure - old), spacing, lower, upper, start)
        law = friction((parts - k) * rolled, field) if callable(friction) else friction
        truth = mtb.solve_tangential(field, motion, law, layer, state, tolerance=1e-11)
        state = truth.state
        heat += float(truth.dissipation.sum() * patch.area * truth.motion.velocity) / parts
    rows, columns = (
        slice(first, first + count)
        for first, count in (
            (round(patch.y[0] / spacing[1]) - lines[1][0], patch.y.size),
            (round(patch.x[0] / spacing[0]) - lines[0][0], patch.x.size),
        )
    )
    return truth.traction[:2, rows, columns], truth.status[rows, columns], heat, state


def ride(k):
    """A wheelset that moves to the side and yaws."""
    phase = 0.35 * k
    return [0.0, 4e-4 * np.sin(phase), FREE, 0.0, 0.0, 2e-3 * np.cos(phase)]


CASES = {
    "left": {},
    "right": {"side": "right"},
    "backwards": {"sense": -1.0},
    "round": {"kind": "cone"},
    # no pressure below zero beside a patch, which the mixture would have across
    "unlike": {"upper": mtb.Material(20e9, 0.3), "kind": "cone", "straight": True, "near": 1e-6},
    "layer": {"layer": mtb.InterfaceLayer(2e-5, 1e9)},
    "table of friction": {"friction": mtb.TabulatedFriction([0.0, 0.5, 2.0], [0.35, 0.3, 0.25], memory=1e-3)},
    "falling, with memory": {"friction": mtb.FallingFriction(0.4, 0.25, 0.2, memory=1e-3)},
    "flat": {"kind": "flat", "steps": 3},
    "hollow": {"kind": "hollow"},
}


@pytest.mark.coarse
@pytest.mark.parametrize("case", CASES)
def test_a_step_solves_what_the_general_solver_does_from_the_state_before(case):
    given = {"kind": "S1002", "side": "left", "sense": 1.0, "steps": 6, "layer": None, "upper": mtb.steel}
    given |= {"friction": mtb.Coulomb(0.3), "straight": False, "near": 1e-7} | CASES[case]
    scene = made(given["kind"], upper=given["upper"])
    wheels = scene.prepare(side=given["side"], friction=given["friction"], layer=given["layer"])
    wheels = exact(wheels)
    before = state = None
    states = set()
    for k in range(given["steps"]):
        dt = (0.7e-3, 1.1e-3, 3.3e-3)[k % 3] / V
        pose = ride(k)
        velocity: Any = given["sense"] * V
        if given["straight"]:
            pose, velocity = [0.0, 0.0, FREE, 0.0, 0.0, 0.0], [V, 0.02 * k, 0.0, 0.0, 1.001 * V / RADIUS, 0.0]
        if given["kind"] == "flat":
            pose = [0.0, 0.0, FREE, 0.0, np.radians(-3.0) + k * dt * V / RADIUS, 0.0]
        now = wheels.step(pose, velocity, dt=dt, transient=True)
        (patch,) = now.patches
        traction, status, _, state = by_general_solver(
            before, now, dt, state, given["friction"], (mtb.steel, given["upper"]), given["layer"]
        )
        np.testing.assert_allclose(patch.traction, traction, atol=given["near"] * np.abs(traction).max())
        np.testing.assert_array_equal(patch.status, status)
        states |= set(np.unique(patch.status))
        before = now
    # the way was no whole number of cells, and most patches moved to the side
    assert {0, 1, 2} <= states


def influence(x, y, spacing):
    """Integral of 1 / r over a rectangle around 0, at (x, y) [m]."""
    a, b = 0.5 * spacing[0], 0.5 * spacing[1]
    total = 0.0
    for i, j in ((1, 1), (-1, -1), (1, -1), (-1, 1)):
        u, v = x + i * a, y + j * b
        r = np.hypot(u, v)
        total = total + i * j * (u * np.arcsinh(v / np.abs(u)) + v * np.arcsinh(u / np.abs(v)) + 0.0 * r)
    return total


@pytest.mark.filterwarnings("ignore:coefficient reaches")
def test_wheels_that_stick_follow_a_model_in_numpy_wherever_their_patch_goes():
    """Dense matrices of Boussinesq's 1 / r: no Poisson's ratio, and friction that lets nothing slip."""
    wheels = exact(made("S1002", 1e-3, PLAIN, PLAIN).prepare(friction=mtb.Coulomb(1e4)))
    shear = PLAIN.shear_modulus
    before, known, moves = None, None, []
    for k in range(8):
        dt = (0.5e-3 + 0.25e-3 * (k % 3)) / V
        y, yaw = 3e-4 * np.sin(0.9 * k), 1e-3 * np.cos(0.7 * k)
        now = wheels.step([0.0, y, FREE, 0.0, 0.0, yaw], V, dt=dt, transient=True)
        (patch,) = now.patches
        spacing = spacing_of(patch)
        x, across = (c[patch.pressure > 0.0] for c in np.meshgrid(patch.x, patch.y))
        way = np.array([patch.rolling_speed * dt, 0.0]) if before is None else moved(before, now, dt)
        xi, eta, phi = patch.creepage * patch.rolling_speed * dt
        # rigid slip a sixth of a cell ahead
        slip = np.array([xi - phi * across, eta + phi * (x + spacing[0] / 6.0)])

        def matrix(from_x, from_y, x=x, across=across, spacing=spacing, way=(0.0, 0.0)):
            far = x[:, None] + way[0] - from_x, across[:, None] + way[1] - from_y
            return influence(*far, spacing) / (np.pi * shear)

        wanted = slip.T
        if known is not None:
            # linear along x between the cells, cubic across
            shares = itertools.product(linear(way[0] / spacing[0]), cubic(way[1] / spacing[1]))
            for (i, along), (j, aside) in shares:
                there = matrix(*known[:2], way=(i * spacing[0], j * spacing[1]))
                wanted = wanted + along * aside * there @ known[2]
        traction = np.linalg.solve(matrix(x, across), wanted)
        assert (patch.status[patch.pressure > 0.0] == 1).all()
        own = patch.traction[:, patch.pressure > 0.0].T
        np.testing.assert_allclose(own, traction, atol=1e-7 * np.abs(traction).max())
        before, known = now, (x, across, traction)
        moves.append(abs(way[1]) / spacing[1])
    # by parts of a cell
    assert max(moves) > 0.3


def test_a_wheel_at_rest_is_shifted_as_cattaneo_has_it():
    """Without Poisson's ratio the traction is of two pressures, cell by cell: mu (p(d) - p(d - u / mu))."""
    mu, share = 0.3, 0.6
    wheels = made("upright", 5e-4, PLAIN, PLAIN).prepare(friction=mtb.Coulomb(mu))
    depth = -exact(wheels).step([0.0, 0.0, FREE, 0.0, 0.0, 0.0], V).pose[2]

    def pressure_at(d):
        (patch,) = exact(wheels).step([0.0, 0.0, -d, 0.0, 0.0, 0.0], V).patches
        lines = [
            np.round(c / h).astype(int) for c, h in zip((patch.x, patch.y), spacing_of(patch), strict=True)
        ]
        return dict(zip(((i, j) for j in lines[1] for i in lines[0]), patch.pressure.ravel(), strict=True))

    full, inner = pressure_at(depth), pressure_at(share * depth)
    shift, dt = mu * (1.0 - share) * depth, 1e-3
    velocity = [0.0, shift / dt, 0.0, 0.0, 0.0, 0.0]
    pose = [0.0, 0.0, -depth, 0.0, 0.0, 0.0]
    now = exact(wheels).step(pose, velocity, dt=dt, transient=True)
    (patch,) = now.patches
    assert patch.rolling_speed == 0.0
    hx, hy = spacing_of(patch)
    keys = [(round(x / hx), round(y / hy)) for y in patch.y for x in patch.x]
    closed = np.array([mu * (full.get(k, 0.0) - inner.get(k, 0.0)) for k in keys]).reshape(
        patch.pressure.shape
    )
    np.testing.assert_allclose(patch.traction[1], closed, atol=1e-7 * mu * patch.pressure.max())
    np.testing.assert_allclose(patch.traction[0], 0.0, atol=1e-7 * mu * patch.pressure.max())
    # in two shifts as in one: what sticks does not forget
    twice = exact(wheels)
    for _ in range(2):
        again = twice.step(pose, [0.5 * v for v in velocity], dt=dt, transient=True)
    np.testing.assert_allclose(again.force, now.force, rtol=1e-7, atol=1e-6)
    # and back by a half: Mindlin's reversal, the traction of twice the smaller shift taken off
    back = twice.step(pose, [-0.5 * v for v in velocity], dt=dt, transient=True)
    middle = pressure_at((1.0 - 0.25 * (1.0 - share)) * depth)
    taken = 2.0 * mu * sum(full[k] - middle.get(k, 0.0) for k in full) * patch.area
    assert back.force[1] == pytest.approx(now.force[1] - taken, rel=1e-6)


@pytest.mark.parametrize("sense", [1.0, -1.0])
@pytest.mark.parametrize("side", ["left", "right"])
def test_steady_rolling_stays_and_is_the_end_of_long_rolling(side, sense):
    mirror = 1.0 if side == "left" else -1.0
    wheels = exact(made().prepare(side=side, friction=mtb.Coulomb(0.3)))
    pose = [0.0, mirror * 1e-3, FREE, 0.0, 0.0, mirror * 2e-3]
    steady = wheels.step(pose, sense * V)
    (patch,) = steady.patches
    dt = spacing_of(patch)[0] / abs(patch.rolling_speed)
    most = np.abs(patch.traction).max()
    stays = wheels.step(steady.pose, sense * V, dt=dt, transient=True)
    np.testing.assert_allclose(stays.patches[0].traction, patch.traction, atol=1e-9 * most)
    np.testing.assert_allclose(stays.force, steady.force, atol=1e-6)
    assert stays.friction_power == pytest.approx(steady.patches[0].dissipation.sum() * patch.area, rel=1e-7)
    rolling = wheels.copy()
    rolling = exact(rolling)
    far = []
    for _ in range(90):
        last = rolling.step(steady.pose, sense * V, dt=dt, transient=True)
        far.append(np.abs(last.patches[0].traction - patch.traction).max() / most)
    assert far[0] > 0.5
    assert far[-1] < 1e-6


def test_a_sudden_change_of_creepage_acts_over_a_way():
    """The force does not jump: half of the way, half of the change."""
    wheels = exact(made().prepare(friction=mtb.Coulomb(0.3)))
    pose = [0.0, 1e-3, FREE, 0.0, 0.0, 1e-3]
    steady = wheels.step(pose, V)
    omega = V / RADIUS
    changes = []
    for way in (4e-5, 2e-5, 1e-5):
        step = wheels.step(
            steady.pose,
            [V, 0.02, 0.0, 0.0, 1.001 * omega, 0.0],
            dt=way / V,
            state=steady.state,
            transient=True,
        )
        changes.append(np.linalg.norm(step.force - steady.force))
    settled = wheels.step(steady.pose, [V, 0.02, 0.0, 0.0, 1.001 * omega, 0.0])
    assert changes[-1] < 0.01 * np.linalg.norm(settled.force - steady.force)
    np.testing.assert_allclose(np.divide(changes[:-1], changes[1:]), 2.0, rtol=0.1)


@pytest.mark.slow
def test_steps_on_a_path_that_grows_longer_come_near_to_steady_ones():
    """What transients add is of first order in the length of the patch over that of the path."""
    largest = []
    for wave in (0.15, 0.3):
        transient, steady = (made().prepare(friction=mtb.Coulomb(0.3)) for _ in range(2))
        way, worst, scale = 1e-3, 0.0, 0.0
        for k in range(round(wave / way)):
            turn = 2.0 * np.pi * k * way / wave
            y, yaw = 2e-4 * np.sin(turn), 2e-3 * np.cos(turn)
            pose = [0.0, y, FREE, 0.0, 0.0, yaw]
            rolled = transient.step(pose, V, dt=way / V, transient=k > 0)
            held = steady.step(pose, V)
            worst = max(worst, abs(rolled.force[1] - held.force[1]))
            scale = max(scale, np.ptp([held.force[1], rolled.force[1]]), abs(held.force[1]))
        largest.append(worst / scale)
    assert 0.02 < largest[0] < 0.5
    assert largest[1] == pytest.approx(0.5 * largest[0], rel=0.25)


@pytest.mark.coarse
def test_patches_that_merge_or_part_carry_their_forces_over():
    """The state of a worn wheel with two places in contact, cut in two patches.

    With whole cells between their frames it is the same. With half cells linear interpolation changes the
    forces by 1.4 % of the tangential one.
    """
    wheels = exact(made("hollow").prepare(friction=mtb.Coulomb(0.3)))
    pose = [0.0, 0.0, FREE, 0.0, 0.0, 1e-3]
    whole = wheels.step(pose, V)
    (entry,), (history,) = whole.state.ratio, whole.state.history
    (patch,) = whole.patches
    gap = np.flatnonzero(~(patch.pressure > 0.0).any(axis=1))
    cut = int(gap[(gap > 5) & (gap < patch.y.size - 5)].mean())
    dt = 1e-3 / V

    def halves(away):
        """Both halves as patches, the frame of the second `away` cells (x, y) from its own."""
        side, (i, j), ratio = entry
        position, angle, pressure, coefficient, creepage = history
        hx, hy = spacing_of(patch)
        shift = np.array([hx * away[0], hy * away[1] * math.cos(angle), hy * away[1] * math.sin(angle)])
        other = tuple(np.array(position) + shift)
        first = (side, (i, j), ratio[:, :cut]), (position, angle, pressure[:cut], coefficient[:cut], creepage)
        column, row = i - math.floor(away[0] + 0.5), j + cut - math.floor(away[1] + 0.5)
        rest = other, angle, pressure[cut:], coefficient[cut:], creepage
        second = (side, (column, row), ratio[:, cut:])
        return replace(whole.state, ratio=(first[0], second), history=(first[1], rest))

    rolled = wheels.step(whole.pose, V, dt=dt, state=whole.state, transient=True)
    merged = wheels.step(whole.pose, V, dt=dt, state=halves((3.0, -2.0)), transient=True)
    np.testing.assert_allclose(merged.force, rolled.force, atol=1e-4)
    # half a cell off on both lines is the worst for linear interpolation
    smeared = wheels.step(whole.pose, V, dt=dt, state=halves((0.49, 0.49)), transient=True)
    moved = wheels.step(whole.pose, V, dt=dt, state=halves((1e-9, 0.0)), transient=True)
    np.testing.assert_allclose(moved.force, rolled.force, atol=1e-3)
    tangential = np.hypot(*rolled.force[:2])
    assert 1e-4 < np.linalg.norm(smeared.force - rolled.force) / tangential < 0.02


def test_a_patch_that_parts_gives_each_place_its_own():
    """Tread and flange as one earlier patch: both go on nearly as from their own."""
    y = np.array([-0.052, -0.036, 0.06])
    wheel = mtb.Profile.from_points(y, [-1.8e-3 - 16e-3 * np.tan(np.radians(60)), -1.8e-3, 3e-3], "linear")
    scene = mtb.scenes.wheel_on_rail(wheel=wheel, lateral=0.0, force=60e3, spacing=5e-4)
    wheels = exact(scene.prepare(friction=mtb.Coulomb(0.3)))
    low, high = 0.0, 12e-3
    for _ in range(20):
        lateral = 0.5 * (low + high)
        both = wheels.step([0.0, lateral, FREE, 0.0, 0.0, 0.0], V)
        if len(both.patches) == 2:
            break
        low, high = (lateral, high) if both.patches[0].contact_angle < 0.2 else (low, lateral)
    dt = 2e-4 / V
    kept = wheels.step(both.pose, V, dt=dt, state=both.state, transient=True)
    # the flange joins the tread's frame, on whole cells
    flange, tread = both.state.ratio
    (place, angle, *flanged, _), (origin, slope, *treaded, creepage) = both.state.history
    middle, away = 0.5 * (angle + slope), np.subtract(place, origin)
    hx, hy = spacing_of(both.patches[0])
    rows = round((away[1] * math.cos(middle) + away[2] * math.sin(middle)) / hy)
    columns = round(away[0] / hx)
    parts = [(flange, flanged, columns, rows), (tread, treaded, 0, 0)]
    starts = np.array([(entry[1][0] + i, entry[1][1] + j) for entry, _, i, j in parts])
    ends = starts + [entry[2].shape[:0:-1] for entry, *_ in parts]
    first, (nx, ny) = starts.min(axis=0), ends.max(axis=0) - starts.min(axis=0)
    ratio, pressure, coefficient = np.zeros((2, ny, nx)), np.zeros((ny, nx)), np.full((ny, nx), 0.3)
    for (entry, fields, *_), (i, j) in zip(parts, starts - first, strict=True):
        on = (slice(j, j + fields[0].shape[0]), slice(i, i + fields[0].shape[1]))
        loaded = fields[0] > 0.0
        pressure[on][loaded], coefficient[on][loaded] = fields[0][loaded], fields[1][loaded]
        ratio[:, *on][:, loaded] = entry[2][:, loaded]
    joined = replace(
        both.state,
        ratio=(("left", (int(first[0]), int(first[1])), ratio),),
        history=((origin, slope, pressure, coefficient, creepage),),
    )
    parted = wheels.step(both.pose, V, dt=dt, state=joined, transient=True)
    fresh = exact(scene.prepare(friction=mtb.Coulomb(0.3))).step(both.pose, V, dt=dt, transient=True)
    for own, from_one, from_rest in zip(kept.patches, parted.patches, fresh.patches, strict=True):
        size = np.linalg.norm(own.traction.sum(axis=(1, 2)))
        jump = np.linalg.norm((from_one.traction - own.traction).sum(axis=(1, 2)))
        lost = np.linalg.norm((from_rest.traction - own.traction).sum(axis=(1, 2)))
        assert jump < 0.05 * size < 0.5 * lost


def test_copies_and_files_start_from_rest_and_pickles_and_states_roll_on():
    wheels = made().prepare(side="both", friction=mtb.Coulomb(0.3))
    pose, dt = [0.0, 5e-4, FREE, 0.0, 0.0, 1e-3], 1e-3 / V
    for _ in range(3):
        last = wheels.step(pose, V, dt=dt, transient=True)
    for other in (pickle.loads(pickle.dumps(wheels)), copy.deepcopy(wheels)):
        assert (
            other.step(pose, V, dt=dt, transient=True).force.tolist()
            == wheels.step(pose, V, dt=dt, state=last.state, transient=True).force.tolist()
        )
    state = pickle.loads(pickle.dumps(last.state))
    again = wheels.copy().step(pose, V, dt=dt, state=state, transient=True)
    on = wheels.step(pose, V, dt=dt, state=last.state, transient=True)
    np.testing.assert_allclose(again.force, on.force, rtol=1e-7, atol=1e-3)
    fresh = wheels.copy().step(pose, V, dt=dt, transient=True)
    assert np.hypot(*fresh.force[:2]) < 0.6 * np.hypot(*on.force[:2])


@pytest.mark.parametrize("side", ["left", "right"])
@pytest.mark.parametrize("speed", [V, -V])
def test_a_long_step_is_many_short_ones_and_a_very_long_one_is_steady(side, speed):
    """On a pose that is held. Four lengths on, 2e-3 of the friction bound is left of a start at rest."""
    made_new = made().prepare(side=side, friction=mtb.Coulomb(0.3)).copy
    pose = [0.0, 0.0, FREE, 0.0, 0.0, 0.0]
    velocity = [speed, 0.01, 0.0, 0.0, 1.001 * speed / RADIUS, 0.0]
    steady = exact(made_new()).step(pose, velocity)
    (patch,) = steady.patches
    pose, most = steady.pose, 0.3 * patch.normal_force
    cells = np.count_nonzero((patch.pressure > 0.0).any(axis=0))
    cell = 1e-3 / abs(patch.rolling_speed)
    short = exact(made_new())
    powers = []
    for k in range(4 * cells - 1):
        now = short.step(pose, velocity, dt=cell, transient=True)
        powers.append(now.friction_power)
        if k + 1 in (2, cells, 4 * cells - 1):
            once = exact(made_new()).step(pose, velocity, dt=(k + 1) * cell, transient=True)
            np.testing.assert_allclose(once.force, now.force, atol=1e-9 * most)
            assert once.friction_power == pytest.approx(np.mean(powers), rel=1e-7)
    left = np.linalg.norm(now.force - steady.force)
    assert 1e-5 * most < left < 3e-3 * most
    beyond = exact(made_new()).step(pose, velocity, dt=(4 * cells + 1) * cell, transient=True)
    np.testing.assert_allclose(beyond.force, steady.force, atol=1e-9 * most)
    # what is steady stays so in whole cells, and nearly so in parts that are shorter
    for count, error in ((1.0, 1e-9), (5.0, 1e-9), (6.2, 0.01), (3.9 * cells, 3e-3)):
        stays = short.step(pose, velocity, dt=count * cell, state=steady.state, transient=True)
        np.testing.assert_allclose(stays.force, steady.force, atol=error * most)


@pytest.mark.parametrize("lifted", [4.5e-5, 3e-5])
def test_a_patch_that_grows_is_not_steady_before_it_has_rolled_over_its_own_length(lifted):
    """The way counts in lengths of the longer one of both patches."""
    wheels = exact(made().prepare(friction=mtb.Coulomb(0.3)))
    velocity = [V, 0.01, 0.0, 0.0, 1.001 * V / RADIUS, 0.0]
    steady = wheels.step([0.0, 0.0, FREE, 0.0, 0.0, 0.0], velocity)
    (patch,) = steady.patches
    raised = steady.pose.copy()
    raised[2] += lifted
    before = wheels.step(raised, velocity)
    assert 0 < np.count_nonzero((before.patches[0].pressure > 0.0).any(axis=0)) <= 7
    cell = 1e-3 / abs(patch.rolling_speed)
    # creepages that change evenly would lag besides
    state = replace(before.state, history=(before.state.history[0][:4],))
    forces = []
    for count in range(3, 37, 3):
        step = wheels.step(steady.pose, velocity, dt=count * cell, state=state, transient=True)
        forces.append(step.force[0])
    # without a jump on the way to the steady one, behind which the growing pressure lags after 36 cells, too
    changes = np.abs(np.diff(forces))
    assert (changes[1:] < changes[:-1]).all()
    assert abs(forces[0] - steady.force[0]) > 0.2 * 0.3 * patch.normal_force
    assert forces[-1] == pytest.approx(steady.force[0], abs=0.02 * 0.3 * patch.normal_force)


@pytest.mark.parametrize("dt", [5e-5, 5e-7])
def test_a_patch_that_jumps_across_the_rail_starts_from_rest(dt):
    """Nothing of what was before is in it, however short the way along."""
    wheels = exact(made().prepare(friction=mtb.Coulomb(0.3)))
    before, after = (wheels.step([0.0, y, FREE, 0.0, 0.0, 0.0], V) for y in (-1e-3, 3e-3))
    places = [step.patches[0].position[1] for step in (before, after)]
    assert abs(places[1] - places[0]) > 10e-3
    jumped = wheels.step(after.pose, V, dt=dt, state=before.state, transient=True)
    rested = exact(wheels.copy()).step(after.pose, V, dt=dt, transient=True)
    most = np.abs(rested.patches[0].traction).max()
    np.testing.assert_allclose(jumped.patches[0].traction, rested.patches[0].traction, atol=1e-7 * most)


@pytest.mark.coarse
def test_long_steps_on_a_path_are_of_second_order():
    """Against steps of a cell: pressure and creepages change evenly over a step."""
    end, errors = 96e-3, []
    height = made().prepare(friction=mtb.Coulomb(0.3)).step([0.0, 0.0, FREE, 0.0, 0.0, 0.0], V).pose[2]
    for cells in (1, 3, 6, 12):
        wheels = exact(made().prepare(friction=mtb.Coulomb(0.3)))
        way, forces = cells * 1e-3, []
        for k in range(round(end / way) + 1):
            turn = np.pi * k * way / end
            z = height - 1e-5 * np.cos(turn)
            pose = [0.0, 3e-4 * np.sin(turn), z, 0.0, 0.0, 1e-3 * np.cos(turn)]
            rolled = wheels.step(pose, V, dt=way / V, transient=k > 0)
            forces.append(rolled.force)
        creep = np.array(forces)[:: 12 // cells, :2]
        if cells == 1:
            truth = creep
        else:
            errors.append(np.abs(creep - truth).max() / np.abs(truth).max())
    assert errors[0] < 0.001
    np.testing.assert_allclose(np.divide(errors[1:], errors[:-1]), 4.0, rtol=0.15)


@pytest.mark.parametrize("side", ["left", "right"])
@pytest.mark.parametrize("speed", [V, -V])
def test_a_long_step_is_short_ones_whose_creepages_change_evenly(side, speed):
    """On a pose that is held, under a lateral velocity that changes; and states that know no creepages."""
    wheels = exact(made().prepare(side=side, friction=mtb.Coulomb(0.3)))
    creeping = np.array([speed, 0.01, 0.0, 0.0, 1.001 * speed / RADIUS, 0.0])
    slower = creeping - [0.0, 0.03, 0.0, 0.0, 0.0, 0.0]
    before = wheels.step([0.0, 0.0, FREE, 0.0, 0.0, 0.0], creeping)
    most = 0.3 * before.patches[0].normal_force
    parts = 5
    cell = 1e-3 / abs(before.patches[0].rolling_speed)

    def rolled(count, state, velocities):
        power = []
        for velocity in velocities:
            now = wheels.step(before.pose, list(velocity), dt=count * cell, state=state, transient=True)
            state = now.state
            power.append(now.friction_power)
        return now.force, np.mean(power)

    known = before.state
    ((place, angle, pressure, coefficient, _),) = known.history
    cases = [(known, [creeping + k / parts * (slower - creeping) for k in range(1, parts + 1)])]
    for history in ((place, angle, pressure, coefficient), (place, angle, pressure, coefficient, None)):
        cases.append((replace(known, history=(history,)), [slower] * parts))
    once = []
    for state, velocities in cases:
        force, power = rolled(1, state, velocities)
        long, mean = rolled(parts, state, [slower])
        np.testing.assert_allclose(long, force, atol=1e-7 * most)
        assert mean == pytest.approx(power, rel=1e-6)
        once.append(long)
    assert np.linalg.norm(once[0] - once[1]) > 0.02 * most
    assert once[1].tolist() == once[2].tolist()


def test_a_wheel_that_did_not_roll_leaves_no_creepages():
    """Its first step over several cells is one whose creepages are those of its end."""
    wheels = exact(made().prepare(friction=mtb.Coulomb(0.3)))
    pose = wheels.step([0.0, 0.0, FREE, 0.0, 0.0, 0.0], V).pose
    rest = wheels.copy().step(pose, [0.0] * 6, dt=1e-3, transient=True)
    assert rest.state.history[0][4] is None
    assert rest.patches[0].rolling_speed == 0.0
    velocity = [V, 0.01, 0.0, 0.0, 1.001 * V / RADIUS, 0.0]
    started = wheels.step(pose, velocity, dt=5e-3 / V, state=rest.state, transient=True)
    fresh = exact(wheels.copy()).step(pose, velocity, dt=5e-3 / V, transient=True)
    np.testing.assert_allclose(started.force, fresh.force, rtol=1e-7)
    assert np.all(np.isfinite(started.state.history[0][4]))


def test_a_patch_that_jumps_along_the_track_starts_from_rest():
    """As it does across: yaw takes it 27 mm ahead, which is twice as long as it is."""
    scene = mtb.scenes.wheel_on_rail("S1002", "60E1", lateral=0.0, force=6e4, spacing=1e-3)
    wheels = scene.prepare(friction=mtb.Coulomb(0.3))
    velocity, dt = [10.0, 0.0, 0.0, 0.0, 10.0 / RADIUS, 0.0], 1e-4
    pose = (10.0 * dt, 3e-3, FREE, 0.0, 0.0, 0.02)
    wheels.step((0.0, 3e-3, FREE, 0.0, 0.0, -0.02), velocity)
    jumped = wheels.step(pose, velocity, dt=dt, transient=True)
    # a wheel that stood aside has left nothing there either
    wheels.step((0.0, -6e-3, FREE, 0.0, 0.0, -0.02), velocity)
    aside = wheels.step(pose, velocity, dt=dt, transient=True)
    np.testing.assert_allclose(jumped.force, aside.force, atol=1e-6 * 6e4)
    # and what is near goes on from what was
    wheels.step((0.0, 3e-3, FREE, 0.0, 0.0, 0.019), velocity)
    near = wheels.step(pose, velocity, dt=dt, transient=True)
    assert np.linalg.norm(near.force - jumped.force) > 1e-2 * 6e4


def test_what_makes_no_transient_step_is_named():
    wheels = made().prepare(friction=mtb.Coulomb(0.3))
    steady = wheels.step(velocity=V)
    with pytest.raises(ValueError, match=r"dt is missing: the time since the last step"):
        wheels.step(velocity=V, transient=True)
    with pytest.raises(ValueError, match=r"transient is 1: True or False"):
        wheels.step(velocity=V, dt=5e-5, transient=1)
    old = replace(steady.state, history=())
    with pytest.raises(ValueError, match=r"state has no pressures of the left wheel"):
        wheels.step(velocity=V, dt=5e-5, state=old, transient=True)
    # it is enough for a steady step
    np.testing.assert_allclose(wheels.step(velocity=V, state=old).force, steady.force, rtol=1e-6, atol=1e-2)
    with pytest.raises(ValueError, match=r"state.history is .*: an entry for each of 1 patches"):
        wheels.step(velocity=V, state=replace(steady.state, history=(None, None)))
    position, angle, pressure, coefficient, creepage = steady.state.history[0]
    for history, message in (
        ((position, angle, pressure), r"state.history\[0\] is"),
        ((position, angle, pressure[:1], coefficient), r"state.history\[0\]\[2\] has shape"),
        ((position, angle, pressure, -coefficient), r"state.history\[0\]\[3\] has shape"),
        ((position[:2], angle, pressure, coefficient), r"state.history\[0\]\[0\]"),
        ((position, angle, pressure, coefficient, creepage[:2]), r"state.history\[0\]\[4\]"),
        ((position, angle, pressure, coefficient, (*creepage[:2], FREE)), r"state.history\[0\]\[4\]"),
    ):
        with pytest.raises(ValueError, match=message):
            wheels.step(velocity=V, state=replace(steady.state, history=(history,)))
    step = wheels.step(velocity=V, dt=5e-5, transient=True)
    assert step.margin().slipping >= 0.0


@pytest.mark.coarse
def test_friction_that_changes_along_the_track_acts_over_a_way():
    """A wheel rolls from a dry rail on a wet one: the general solver under the same coefficients."""
    law = mtb.RailFriction([-20e-3, 20e-3], [[0.4, 0.4], [0.1, 0.1]], x=[2e-3, 2.5e-3])
    wheels = exact(made("cone").prepare(friction=law))
    moving = [V, 0.06, 0.0, 0.0, 1.002 * V / RADIUS, 0.0]
    step = wheels.step([-8e-3, 0.0, FREE, 0.0, 0.0, 0.0], moving)
    z, before, state = step.pose[2], step, None
    x = -8e-3
    for way in (*[1e-3] * 5, *[3e-3] * 4, 1e-3):
        x += way
        now = wheels.step([x, 0.0, z, 0.0, 0.0, 0.0], moving, dt=way / V, transient=True)
        (patch,) = now.patches
        if state is None:
            old = before.patches[0]
            mu = np.full(old.pressure.shape, 0.4)
            origin = (old.x[0], old.y[0])
            state = mtb.TangentialState(old.traction, old.pressure, mu, origin, spacing_of(old))

        def on_the_way(behind, field, x=x):
            places = x + field.origin[0] + 1e-3 * np.arange(field.pressure.shape[1])
            mu = np.interp(places - behind, [2e-3, 2.5e-3], [0.4, 0.1])
            return mtb.Coulomb(np.broadcast_to(mu, field.pressure.shape))

        traction, _, _, state = by_general_solver(
            before, now, way / V, state, on_the_way, (mtb.steel, mtb.steel), None
        )
        np.testing.assert_allclose(patch.traction, traction, atol=1e-7 * np.abs(traction).max())
        before = now
    assert now.force[1] < 0.5 * step.force[1]


#: What may differ of wheels that roll steadily.
ROLLING = {
    "plain": {},
    "layer": {"layer": mtb.InterfaceLayer(2e-5, 1e9)},
    "conformal": {"conformal": True},
    "memory": {"friction": mtb.FallingFriction(0.4, 0.25, 0.2, memory=1e-3)},
    "unlike": {},
}
MOVING = [V, 0.01, 0.0, 0.0, 1.0005 * V / RADIUS, 0.0]


@pytest.mark.coarse
@pytest.mark.parametrize("kind", ROLLING)
def test_steps_of_any_part_of_a_cell_stay_at_steady_rolling(kind):
    """Forces to rounding; the heat, which is a mean over the step, to first order in the cells."""
    pose, upper = (
        [0.0, 1e-3, FREE, 0.0, 0.0, 1e-3],
        mtb.Material(100e9, 0.3) if kind == "unlike" else mtb.steel,
    )
    given = {"friction": mtb.Coulomb(0.3)} | ROLLING[kind]
    heats: list[list[float]] = []
    for spacing in (2e-3, 1e-3):
        wheels = exact(made(spacing=spacing, upper=upper).prepare(**given))
        heats.append([])
        for cells in (0.02, 0.2, 0.6, 1.0, 1.7):
            steady = step = wheels.step(pose, MOVING)
            for _ in range(10):
                step = wheels.step(step.pose, MOVING, dt=cells * spacing / V, transient=True)
            np.testing.assert_allclose(step.force, steady.force, atol=1e-6)
            heats[-1].append(abs(step.friction_power / steady.friction_power - 1.0))
    coarse, fine = np.array(heats)
    assert fine.max() < 0.01
    assert fine.max() < 0.6 * coarse.max()


@pytest.mark.parametrize("cells", [0.05, 0.3, 0.7])
def test_steps_of_a_part_of_a_cell_end_at_steady_rolling(cells):
    """From another creepage, after some lengths of the contact."""
    wheels = exact(made(spacing=1e-3).prepare(friction=mtb.Coulomb(0.3)))
    pose = [0.0, 1e-3, FREE, 0.0, 0.0, 1e-3]
    wanted = wheels.step(pose, MOVING)
    start = wheels.step(pose, V)
    assert abs(start.force[0] - wanted.force[0]) > 0.1 * 0.3 * 60e3
    step = start
    for _ in range(round(70 / cells)):
        step = wheels.step(wanted.pose, MOVING, dt=cells * 1e-3 / V, transient=True)
    np.testing.assert_allclose(step.force, wanted.force, atol=1e-5 * 0.3 * 60e3)


@pytest.mark.parametrize("spacing", [2e-3, 3e-3])
def test_patches_that_jump_along_and_across_start_from_rest(spacing: float) -> None:
    wheels = mtb.scenes.wheel_on_rail(lateral=0.0, force=60e3, spacing=spacing).prepare(side="both")
    wheels.step((0, 1e-3, np.nan, np.nan, 0, 3.28e-3), 20.0)
    step = wheels.step((0, -2.35e-3, np.nan, np.nan, 0, -4.96e-3), 20.0, dt=1e-5, transient=True)
    assert step.force[2] == pytest.approx(-120e3, rel=1e-8)
