# SPDX-License-Identifier: MIT OR Apache-2.0
"""Derivatives through transient steps of wheels: Cattaneo and Mindlin, one step in two, differences."""

import numpy as np
import pytest

import mtb_rs as mtb

from .test_transient_wheel_derivatives import FREE, MOVING, RADIUS, V, exact, prepared, round_head

pytestmark = pytest.mark.filterwarnings("ignore:the peak pressure is")


def last_of(steps, of):
    """Gradients of a number of the last step."""
    return mtb.gradient_of_steps(steps, [*[{}] * (len(steps) - 1), of])


def test_two_shifts_of_a_wheel_at_rest_are_as_cattaneo_and_mindlin_have_them():
    """The force of a shift u is mu (P(d) - P(d - u / mu)); back by w takes 2 mu (P(d) - P(d - w / 2 mu))."""
    mu, dt = 0.3, 1e-3
    # Young's modulus 2 G and Poisson's ratio 0: tractions do what pressures do
    plain = mtb.Material(160e9, 0.0)
    scene = mtb.scenes.wheel_on_rail(
        wheel=mtb.Profile.from_points([-0.05, 0.05], [0.0, 0.0], "linear"), rail=round_head(),
        rail_inclination=0.0, lateral=0.0, force=60e3, spacing=5e-4, lower=plain, upper=plain,
        wheel_radius=RADIUS,
    )  # fmt: skip
    contact = scene.prepare(friction=mtb.Coulomb(mu))
    depth = -exact(contact).step([0.0, 0.0, FREE, 0.0, 0.0, 0.0], V).pose[2]

    def slope_at(d):
        """Of the normal force by the depth."""
        step = exact(contact).step([0.0, 0.0, -d, 0.0, 0.0, 0.0], V)
        return -step.derivative("normal_force", "pose")[0, 2]

    def shifted(*shifts):
        wheels = exact(contact)
        steps = []
        for shift in shifts:
            velocity = [0.0, shift / dt, 0.0, 0.0, 0.0, 0.0]
            steps.append(wheels.step([0.0, 0.0, -depth, 0.0, 0.0, 0.0], velocity, dt=dt, transient=True))
        return steps

    def by_shifts(steps):
        area = steps[-1].patches[0].area
        weights = np.zeros((2, steps[-1].patches[0].pressure.size))
        weights[1] = area
        return [by["velocity"][1] / dt for by in last_of(steps, {"traction": weights})]

    u, more = 0.25 * mu * depth, 0.15 * mu * depth
    inner = slope_at(depth - (u + more) / mu)
    assert by_shifts(shifted(u, more)) == pytest.approx([inner, inner], rel=1e-6)
    # back by less than twice the way: what was first stays in the ring that does not slip again
    back = 0.2 * mu * depth
    wanted = [slope_at(depth - u / mu), slope_at(depth - 0.5 * back / mu)]
    assert by_shifts(shifted(u, -back)) == pytest.approx(wanted, rel=1e-6)
    assert wanted[1] > 1.05 * wanted[0]


def test_a_chain_of_one_step_has_its_own_derivatives():
    contact = prepared(mtb.FallingFriction(0.35, 0.2, 0.2, memory=1e-4))
    contact.step([0.0, 1e-3, FREE, 0.0, 0.0, 2e-3], V)
    step = contact.step([1e-3, 1.2e-3, FREE, 0.0, 0.0, 2.1e-3], MOVING, dt=5e-5, transient=True)
    (found,) = mtb.gradient_of_steps([step], ["friction_power"])
    own = step.gradient("friction_power")
    assert [*found] == [*own]
    for by in ("pose", "velocity", "dt", "friction.memory", "upper.poisson_ratio", "rails.left"):
        np.testing.assert_array_equal(found[by], own[by])


@pytest.mark.parametrize("side", ["left", "right"])
@pytest.mark.parametrize(
    ("law", "name"),
    [(mtb.Coulomb(0.3), "friction"), (mtb.FallingFriction(0.35, 0.2, 0.2, memory=2e-3), "friction.static")],
)
def test_a_step_of_two_parts_hands_on_what_two_steps_do(law, name, side):
    """With the friction of the first step only its tractions and coefficients change, and roll on."""
    dt = 0.9e-3 / V
    pose = np.array([0.0, 1e-3, -7e-5, 0.0, 0.0, 2e-3])

    def rolled(count):
        contact = prepared(law, side)
        first = contact.step(list(pose), list(MOVING))
        ahead = [pose + np.eye(6)[0] * V * dt * (k + 1) * 2 / count for k in range(count)]
        way = 2 * dt / count
        return [first, *(contact.step(list(p), list(MOVING), dt=way, transient=True) for p in ahead)]

    whole, halves = rolled(1), rolled(2)
    np.testing.assert_allclose(whole[-1].force, halves[-1].force, rtol=1e-10)
    for of in ("force", "moment"):
        for weight in np.eye(3)[:2]:
            at_once, in_two = (last_of(steps, {of: weight})[0][name] for steps in (whole, halves))
            assert at_once == pytest.approx(in_two, rel=1e-8)
            assert abs(in_two) > 1e-2 * abs(last_of(halves, {of: weight})[-1][name])


LAWS = {
    "coulomb": (mtb.Coulomb, 0.3, "friction"),
    "memory": (lambda mu: mtb.FallingFriction(mu, 0.2, 0.2, memory=1e-4), 0.35, "friction.static"),
}


@pytest.mark.slow
@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize(("roller_radius", "cells"), [(None, (0.87, 2.6)), (0.6, (0.6, 0.87))])
def test_derivatives_through_steps_are_differences_of_chains(law, roller_radius, cells):
    made, mu, name = LAWS[law]
    # where no station of the profiles passes another one within the differences
    start = np.array([0.0, -1.013e-3, FREE, 0.0, 0.0, 2e-3])
    speed = MOVING * np.array([1.0, -1.0, 1.0, 1.0, 1.0, 1.0])
    ways = [count * 1e-3 / V for count in cells]

    def chain(mu=mu, pose=(0, 0.0), velocity=(0, 0.0), dt=(1, 0.0), axis=1):
        contact = prepared(made(mu), "right", roller_radius=roller_radius)
        unit = np.eye(6)[axis]
        steps, x = [], 0.0
        for k, way in enumerate((0.0, *ways)):
            x += 0.0 if roller_radius else V * way
            place = start + [x, -2e-4 * k, 0.0, 0.0, 0.0, 1e-4 * k] + unit * pose[1] * (k == pose[0])
            moving = speed + unit * velocity[1] * (k == velocity[0])
            rolls = {} if k == 0 else {"dt": way + dt[1] * (k == dt[0]), "transient": True}
            steps.append(contact.step(list(place), list(moving), **rolls))
        return steps

    steps = chain()
    ways_of = [
        ("pose", 0, 1, 2e-8, lambda by: chain(pose=(0, by))),
        ("pose", 1, 5, 1e-6, lambda by: chain(pose=(1, by), axis=5)),
        ("velocity", 0, 1, 2e-6, lambda by: chain(velocity=(0, by))),
        ("velocity", 1, 4, 2e-5, lambda by: chain(velocity=(1, by), axis=4)),
        ("dt", 1, None, 2e-8, lambda by: chain(dt=(1, by))),
        (name, None, None, 3e-5, lambda by: chain(mu + by)),
    ]
    numbers = [
        ({"force": np.eye(3)[1]}, lambda s: s.force[1]),
        ("friction_power", lambda s: s.friction_power),
    ]
    gradients = [last_of(steps, of) for of, _ in numbers]
    for by, at, k, small, moved in ways_of:
        chains = [moved(share * small) for share in (-1.0, -0.5, 0.5, 1.0)]
        states = {b"".join(p.status.tobytes() for s in c for p in s.patches) for c in (*chains, steps)}
        assert len(states) == 1, by
        for gradient, (of, value) in zip(gradients, numbers, strict=True):
            found = sum(g[by] for g in gradient) if at is None else gradient[at][by]
            found = found if k is None else found[k]
            a, b, c, d = (value(c[-1]) for c in chains)
            truth = (8.0 * (c - b) - (d - a)) / (6.0 * small)
            noise = 1e-11 * abs(value(steps[-1])) / small
            assert found == pytest.approx(truth, rel=1e-6, abs=noise), (by, of)


def test_steps_that_do_not_follow_each_other_are_told():
    contact = prepared(mtb.Coulomb(0.3))
    pose = np.array([0.0, 1e-3, FREE, 0.0, 0.0, 2e-3])
    steps = [contact.step(list(pose), V)]
    for k in (1, 2):
        steps.append(contact.step(list(pose + 1e-3 * k * np.eye(6)[0]), V, dt=5e-5, transient=True))
    numbers = [{}, {}, "friction_power"]
    assert abs(mtb.gradient_of_steps(steps, numbers)[0]["friction"]) > 0.0
    with pytest.raises(ValueError, match=r"results\[1\] does not start from the state of results\[0\]"):
        mtb.gradient_of_steps([steps[0], steps[2]], [{}, {}])
    with pytest.raises(ValueError, match=r"of has 'force', which is not a single number"):
        mtb.gradient_of_steps(steps, [{}, {}, "force"])
    # the state may be handed over, and a steady step follows from none
    other = contact.copy().step(list(steps[2].pose), V, dt=5e-5, state=steps[1].state, transient=True)
    assert abs(mtb.gradient_of_steps([steps[1], other], [{}, "friction_power"])[0]["dt"]) > 0.0
    steady = contact.step(list(pose), V)
    assert mtb.gradient_of_steps([steps[2], steady], [{}, "friction_power"])[0]["velocity"] == 0.0
