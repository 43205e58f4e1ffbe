# SPDX-License-Identifier: MIT OR Apache-2.0
"""Forces on elastic bodies: reactions are those of the finite elements, and every body is in balance."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import mtb_rs as mtb
from mtb_rs.bodies.mesh import block_mesh
from mtb_rs.bodies.sides import Forces
from mtb_rs.contact.solve import _imbalance as imbalance
from mtb_rs.contact.solve import solve_direct

pytestmark = pytest.mark.usefixtures("own_cache")

ROOF = ((None, None), (None, None), (0.05, 0.05))
SCENES = {
    "driven": lambda: mtb.scenes.pole_shoe_on_rail(spacing=6e-3),
    "uneven": lambda: mtb.scenes.pole_shoe_on_rail(spacing=6e-3, magnetic_pressure=(3e6, 2e6), friction=0.2),
    "points": lambda: mtb.scenes.pole_shoe_on_rail(spacing=6e-3, height=70e-3, supports="points"),
    "clamped, both pulled": lambda: mtb.scenes.pole_shoe_on_rail(
        spacing=6e-3, supports="clamped-top", attraction="both"
    ),
    "oblique": lambda: mtb.scenes.pole_shoe_on_rail(spacing=6e-3, sliding_direction=(0.5, 1.0), friction=0.2),
    "aside": lambda: mtb.scenes.pole_shoe_on_rail(spacing=6e-3, lateral=1e-3, yaw=1e-3),
    "turned": lambda: mtb.scenes.pole_shoe_on_rail(spacing=6e-3).with_(moments=(4.0, -9.0)),
}


def hanging_block(**supports) -> mtb.ElasticBody:
    x = np.linspace(-0.05, 0.05, 9)
    held = mtb.Support(ROOF, **supports, name="roof")
    return mtb.ElasticBody(block_mesh(x, x, 0.05), mtb.steel, supports=[held])


def check(result, model_bodies):
    """Reported reactions are those of the whole solution, and each body is in balance."""
    balance = result.report.force_balance
    states = result.states()
    assert set(states) == model_bodies
    scale = 1e-8 * result.normal_force
    for part, (name, state) in zip(result.parts, states.items(), strict=True):
        if part.is_half:
            continue
        for support, force in state.reactions.items():
            assert np.abs(result.report.reactions[f"{name}: {support}"] - force).max() < scale
        found = part.forces(result.coefficients)
        for support, moment in state.moments.items():
            assert np.abs(found.supports[support][3:] - moment).max() < 0.1 * scale
        # nothing is left over on the nodes that nothing holds
        assert state.left_over < scale
    assert balance["relative_error"] < 1e-9
    upper = balance.get("magnetic", np.zeros(3)) - balance["contact"] + balance["supports of the upper body"]
    assert np.abs(upper).max() < scale
    return balance


@pytest.mark.parametrize("name", SCENES)
def test_reported_reactions_are_those_of_the_finite_elements(name):
    result = SCENES[name]().solve(model="elastic-upper")
    check(result, {"left pole", "right pole"})


@pytest.mark.coarse
@pytest.mark.parametrize("name", ["driven", "uneven"])
def test_the_rail_passes_on_what_presses_it(name):
    result = SCENES[name]().with_(attraction="both").solve(model="elastic-both")
    balance = check(result, {"left pole", "right pole", "rail"})
    # each side integrates over its own facets
    pressed = balance["contact"] + balance["magnetic on the lower body"]
    size = np.linalg.norm(balance["contact"])
    assert np.abs(pressed + balance["supports of the lower body"]).max() < 2e-3 * size
    assert balance["magnetic on the lower body"][2] == pytest.approx(-balance["magnetic"][2], rel=2e-3)


@pytest.mark.coarse
@pytest.mark.parametrize("given", [{"friction": 0.0}, {"attraction": "both"}])
def test_moments_that_are_rounding_are_no_scale(given):
    """Symmetric loads on a body have no moment about the middle, and its rounding is in balance."""
    result = mtb.scenes.pole_shoe_on_rail(spacing=6e-3, **given).solve(model="elastic-both")
    assert result.report.force_balance["relative_error"] < 1e-9


def test_a_motion_that_nothing_works_on_is_in_balance():
    """A body that is free along y, without friction: the load along y is rounding."""
    problem = mtb.scenes.pole_shoe_on_rail(spacing=6e-3, friction=0.0).problem("half-space")
    solution = solve_direct(problem)
    aside = np.zeros((1, 3, problem.area.size))
    aside[:, 1] = 1.0
    side = replace(
        problem.upper,
        motions=np.concatenate([problem.upper.motions, aside]),
        work=np.append(problem.upper.work, 1e-13),
        is_pulled=np.append(problem.upper.is_pulled, False),
    )
    assert imbalance(replace(problem, upper=side), solution.coefficients(problem)) < 1e-12
    side = replace(side, work=np.append(problem.upper.work, 1.0))
    assert imbalance(replace(problem, upper=side), solution.coefficients(problem)) > 1e-5


def test_forces_and_moments_have_one_scale():
    """A couple alone, forces alone, and either of them left over."""
    none, couple = np.zeros(6), np.array([0.0, 0.0, 0.0, 0.0, 40.0, 0.0])
    force = np.array([0.0, 0.0, 800.0, 0.0, 0.0, 0.0])
    rounding = np.full(6, 1e-13)
    for load in (couple, force):
        assert Forces(none, none, load, {"held": rounding - load}, 0.05).relative_error < 1e-14
    # 40 N m on 50 mm are 800 N
    for load in (couple, force):
        held = {"held": np.append(-force[:3], -couple[3:]) + load}
        assert Forces(force + couple, none, none, held, 0.05).relative_error == pytest.approx(1 / 3)


def test_a_wrong_solution_is_caught():
    problem = mtb.scenes.pole_shoe_on_rail(spacing=6e-3).problem("elastic-upper")
    solution = solve_direct(problem)
    part = problem.upper.state[0]
    assert part.balance is not None
    right = solution.coefficients(problem)
    assert part.forces(right).relative_error < 1e-12
    # a thousandth too much of one component, in one point: held by nothing, so left over
    peak = int(right[2].argmax())
    wrong = right.copy()
    wrong[2, peak] *= 1.001
    assert part.forces(wrong).relative_error > 1e-6
    # a lost unit of moment
    wrong = right.copy()
    wrong[2, [peak, peak + 1]] += np.array([1.0, -1.0]) * 1e-3 * right[2, peak]
    assert part.forces(wrong).relative_error > 1e-7
    # reactions of another body: a support that was condensed wrongly
    balance = part.balance
    broken = replace(part, balance=replace(balance, reaction=balance.reaction * 1.001))
    assert broken.forces(right).relative_error > 1e-5
    # friction of the opposite sign: only balanced loads reach supports that leave a motion free
    held = mtb.Scene(hanging_block(x=0, y=0, z=-1e-5), mtb.steel, spacing=12.5e-3, friction=0.3)
    problem = held.problem("elastic")
    right = solve_direct(problem).coefficients(problem)
    part = problem.upper.state[0]
    wrong = right * np.array([[-1.0], [1.0], [1.0]])
    friction = part.forces(right).supports["roof"][0]
    assert abs(friction) > 100.0
    assert part.forces(wrong).supports["roof"][0] == pytest.approx(-friction)


def test_forces_of_guides_close_the_balance_without_a_pull():
    body = hanging_block(x=0, y=0, z=mtb.Guide(force=-2e4))
    result = mtb.Scene(body, mtb.steel, spacing=12.5e-3, friction=0.3).solve()
    balance = check(result, {"body"})
    assert result.normal_force == pytest.approx(2e4, rel=1e-10)
    np.testing.assert_allclose(balance["supports of the upper body"], [0.3 * 2e4, 0.0, -2e4], atol=1e-6)


def test_force_and_moments_press_an_elastic_body_as_statics_says():
    """The centre of pressure follows from the moments and the lever of friction."""
    body = hanging_block(x=0, y=0)
    force, moments = 3e4, (200.0, -300.0)
    for friction in (0.0, 0.2):
        scene = mtb.Scene(body, mtb.steel, spacing=12.5e-3, friction=friction, force=force, moments=moments)
        result = scene.solve()
        check_force = result.report.force_balance
        assert result.normal_force == pytest.approx(force, rel=1e-10)
        assert check_force["relative_error"] < 1e-9
        state = result.states()["body"]
        assert state.left_over < 1e-8 * force
        # the roof guides along x and y: it takes the friction, and no moment it could only take vertically
        roof = state.reactions["roof"]
        np.testing.assert_allclose(roof, [friction * force, 0.0, 0.0], atol=1e-6 * force)
        lever = 0.05 * friction * force
        np.testing.assert_allclose(state.moments["roof"][:2], [0.0, lever], atol=1e-6 * force)
        # equilibrium about the middle of the foot
        part = result.parts[0]
        contact = part.forces(result.coefficients).contact
        np.testing.assert_allclose(contact[3:5], [-moments[0], -moments[1] - lever], atol=1e-6 * force)
        centre = np.array([-contact[4], contact[3]]) / force
        assert np.abs(centre - np.array([moments[1] + lever, -moments[0]]) / force).max() < 1e-9
        np.testing.assert_allclose(
            result.moment[:2], [-force * centre[1], force * centre[0]], atol=1e-6 * force
        )
    # without moments they agree with a weight
    plain = mtb.Scene(body, mtb.steel, spacing=12.5e-3, friction=0.0, force=force).solve()
    assert np.abs(plain.parts[0].forces(plain.coefficients).contact[3:]).max() < 1e-6 * force


def test_moments_beyond_the_edge_are_refused():
    body = hanging_block(x=0, y=0)
    with pytest.raises(mtb.ConvergenceError, match="outside what the contact can carry"):
        mtb.Scene(body, mtb.steel, spacing=12.5e-3, friction=0.0, force=3e4, moments=(0.0, 1600.0)).solve()


def test_moments_on_a_half_space_over_an_elastic_table():
    x = np.linspace(-0.05, 0.05, 9)
    mesh = block_mesh(x, x, 0.05).moved(np.diag([1.0, -1.0, -1.0]))
    table = mtb.ElasticBody(mesh, mtb.steel, supports=[mtb.Support("bottom", x=0, y=0, z=0)])
    force, moments = 3e4, (200.0, -300.0)
    result = mtb.Scene(
        mtb.Rigid(), table, spacing=12.5e-3, friction=0.0, force=force, moments=moments
    ).solve()
    contact = result.parts[0].forces(result.coefficients).contact
    np.testing.assert_allclose(contact[:3], [0.0, 0.0, -force], atol=1e-6 * force)
    np.testing.assert_allclose(contact[3:5], moments, atol=1e-6 * force)
    assert np.linalg.norm(result.moment[:2] - moments) < 1e-6 * force


def test_moments_on_both_poles_shift_their_pressures():
    plain = mtb.scenes.pole_shoe_on_rail(spacing=6e-3, friction=0.0)
    turned = plain.with_(moments=(0.0, 20.0))
    results = [scene.solve(model="elastic-upper") for scene in (plain, turned)]
    for k in range(2):
        first, second = (r.parts[k].forces(r.coefficients) for r in results)
        # the contact turns the poles back, each by its half
        assert second.contact[4] - first.contact[4] == pytest.approx(-10.0, rel=1e-8)
        assert second.contact[2] == pytest.approx(first.contact[2], rel=1e-10)


@pytest.mark.parametrize("model", ["half-space", "elastic-upper", "elastic-both"])
def test_what_two_poles_carry_adds_up_to_the_moments(model):
    """In statics: the pressures of a scene turn its lower body by the moments that the scene states."""
    flat = mtb.Profile.from_points([-0.05, 0.0, 0.05], [0.0, 0.0, 0.0])
    # on a crowned rail the supports take a part of what turns about x
    crowned = {"rail": "60E1"} if model == "elastic-both" else {"rail": flat, "relief_slope": 0.1}
    given = np.array([0.0 if model == "elastic-both" else 6.0, 20.0])

    def carried(moments) -> np.ndarray:
        shoe = mtb.scenes.pole_shoe_on_rail(spacing=6e-3, friction=0.0, magnetic_pressure=2e6, **crowned)
        shoe = shoe.with_(moments=tuple(moments))
        return np.array([shoe.solve(model).moment[:2], shoe.prepare(model).step(velocity=1.0).moment[:2]])

    turned = carried(given) - carried((0.0, 0.0))
    np.testing.assert_allclose(turned, [given, given], atol=1e-6 * 20.0)


def test_a_force_and_moments_on_two_rigid_poles_add_up():
    flat = mtb.Profile.from_points([-0.05, 0.0, 0.05], [0.0, 0.0, 0.0])
    shoe = mtb.scenes.pole_shoe_on_rail(spacing=6e-3, friction=0.0, rail=flat, upper=mtb.Rigid())
    result = shoe.with_(magnetic_pressure=None, force=6e3, moments=(6.0, -20.0)).solve("half-space")
    assert result.normal_force == pytest.approx(6e3, rel=1e-9)
    np.testing.assert_allclose(result.moment[:2], [6.0, -20.0], atol=1e-6 * 20.0)
