# SPDX-License-Identifier: MIT OR Apache-2.0
"""Steps with a shift: points stick or slip, remember their tractions, and slide as steps without one do."""

from __future__ import annotations

import copy
import pickle
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import mtb_rs as mtb

pytestmark = pytest.mark.coarse

MU = 0.3
SHEAR = 80e9
#: Along the tangents these give way as along the normal: what is known of the one is known of the other.
EVEN = mtb.Material.from_shear_modulus(SHEAR, 0.0)
RUBBER = mtb.Material(young_modulus=5e9, poisson_ratio=0.2)
#: Of the upper body [m]: to and fro, askew, on, back, and at rest.
WAY = [(2e-6, 0.0), (1.5e-6, 1e-6), (-1e-6, 1e-6), (-4e-6, -2e-6), (0.0, 0.0), (6e-6, 1e-6), (3e-6, -3e-6)]


def ball(force: float = 1e3, points: int = 14, **given: Any) -> mtb.Scene:
    # as wide for all loads, but wider on a soft body
    words = {"upper": EVEN, "lower": EVEN, "friction": MU, "width": 3e-3} | given
    if words["upper"] is RUBBER:
        words["width"] = None
    return mtb.scenes.paraboloid_on_plane(radius=0.05, force=force, points=points, **words)


def shoe(**given: Any) -> mtb.Scene:
    words = {"friction": 0.3, "magnetic_pressure": 3e6, "spacing": 12e-3, "poles": 1} | given
    return mtb.scenes.pole_shoe_on_rail(**words)


def test_it_follows_shifts_as_solve_tangential_does() -> None:
    body = mtb.Material.from_shear_modulus(SHEAR, 0.28)
    scene = ball(upper=body, lower=body)
    contact, normal, state = scene.prepare("half-space"), scene.solve("half-space"), None
    limit = MU * normal.pressure.max()
    stuck = set()
    for shift in WAY:
        step = contact.step(shift=shift)
        known = mtb.solve_tangential(
            normal, mtb.Shift(displacement=shift), mtb.Coulomb(MU), state=state, tolerance=1e-11
        )
        state = known.state
        apart = step.traction[:2] - known.traction[:2].reshape(2, -1)
        assert np.abs(apart).max() < 1e-8 * limit
        assert np.array_equal(step.status, known.status.ravel())
        assert np.abs(step.slip[:2] - known.slip.reshape(2, -1))[:, step.status == 2].max(initial=0.0) < 1e-14
        stuck.add(np.count_nonzero(step.status == 1))
    # from full stick over partial slip to none
    assert min(stuck) == 0
    assert len(stuck) > 3


def test_loading_unloading_and_reversal_follow_mindlin_and_deresiewicz() -> None:
    """Superposed frictionless contacts, exact cell by cell without Poisson's ratio [Johnson1985, ch. 7.4]."""
    load = 1e3

    def pressed(force: float) -> tuple[np.ndarray, float]:
        found = ball(force).solve("half-space")
        return np.asarray(found.pressure.ravel()), float(found.approach)

    whole, depth = pressed(load)
    contact = ball(load).prepare("half-space")
    turned, tractions, place = (0.0, 0.0), np.zeros_like(whole), 0.0
    # the force at which the way turns, as a share of the limit, and shares on the way there
    for first, aims in ((1.0, (0.3, 0.6)), (-2.0, (0.2, -0.1, -0.6)), (2.0, (-0.2, 0.3, 0.6))):
        for aim in aims:
            left = load * (1.0 - (aim - turned[0]) / first)
            inner, shallow = pressed(left)
            wanted = tractions + first * MU * (whole - inner)
            there = turned[1] + first * MU * (depth - shallow)
            step = contact.step(shift=(there - place, 0.0))
            place = there
            assert step.force[0] == pytest.approx(aim * MU * load, abs=1e-8 * MU * load)
            assert np.abs(step.traction[0] - wanted).max() < 1e-7 * MU * whole.max()
            assert np.abs(step.traction[1]).max() < 1e-9 * MU * whole.max()
        turned, tractions = (aim, place), step.traction[0]
    # the loop is closed: where the way turned first, it comes back to
    assert step.force[0] == pytest.approx(0.6 * MU * load, rel=1e-8)


def test_a_thousand_cycles_do_not_drift() -> None:
    contact = ball(points=8, upper=RUBBER).prepare("half-space")
    cycle = [(3e-6, 1e-6), (-3e-6, 0.0), (-3e-6, -1e-6), (3e-6, 0.0)]
    forces = np.array([[contact.step(shift=shift).force for shift in cycle] for _ in range(1000)])
    assert np.abs(forces[-1] - forces[3]).max() < 1e-9 * 1e3
    # it is a loop, and it rubs
    assert np.ptp(forces[-1, :, 0]) > 0.2 * MU * 1e3


def love(points: np.ndarray, size: float) -> np.ndarray:
    """Displacement by uniform tractions on squares of two bodies alike, Poisson's ratio 0 [Love1929]."""
    x = points[0][:, None] - points[0]
    y = points[1][:, None] - points[1]
    total = np.zeros_like(x)
    for sign, a, b in ((1, 0.5, 0.5), (-1, -0.5, 0.5), (-1, 0.5, -0.5), (1, -0.5, -0.5)):
        u, v = x + a * size, y + b * size
        r = np.hypot(u, v)
        total += sign * (u * np.log(v + r) + v * np.log(u + r))
    return total / (2.0 * np.pi * SHEAR) * 2.0


def test_friction_turns_the_work_into_heat() -> None:
    contact = ball().prepare("half-space")
    area = contact.area[0]
    matrix = love(contact.points, np.sqrt(area))
    before, stored, heat, work = np.zeros((2, contact.area.size)), 0.0, 0.0, 0.0
    for shift in WAY:
        step = contact.step(shift=shift, dt=1e-3)
        q = step.traction[:2]
        assert step.friction_work is not None
        assert step.friction_work >= 0.0
        assert step.friction_power == pytest.approx(step.friction_work / 1e-3)
        energy, jump = (0.5 * area * np.einsum("cn,nm,cm", t, matrix, t) for t in (q, q - before))
        done = float(step.force[:2] @ shift)
        # the step ends at its last traction: on the way there it was less
        assert done == pytest.approx(step.friction_work + energy - stored + jump, abs=1e-10 * MU * 1e3 * 6e-6)
        before, stored, heat, work = q, energy, heat + step.friction_work, work + done
    assert heat > 0.1 * work


FULL = {
    "half-space": (ball(upper=RUBBER), "half-space", (1e-3, 0.0)),
    "askew": (ball(upper=RUBBER), "half-space", (1e-3, -2e-3)),
    "elastic": (shoe(poles=2), "elastic-upper", (-1e-3, 0.0)),
    "rail": (shoe(attraction="both"), "elastic-both", (1e-3, 0.0)),
}


@pytest.mark.parametrize("name", FULL)
def test_where_all_points_slide_it_is_a_step_without_a_shift(name: str) -> None:
    scene, model, shift = FULL[name]
    contact = scene.prepare(model)
    # the elastic displacements settle within some steps
    for _ in range(12):
        stuck = contact.step(shift=shift)
    slid = contact.copy().step(velocity=shift)
    most = slid.pressure.max()
    assert np.abs(stuck.pressure - slid.pressure).max() < 1e-11 * most
    assert np.abs(stuck.traction - slid.traction).max() < 1e-11 * most
    assert np.array_equal(stuck.status, slid.status)
    # and from sliding it goes on as from itself
    after = contact.copy().step(shift=0.0, state=slid.state)
    assert np.abs(after.traction - contact.step(shift=0.0).traction).max() < 1e-9 * most


def conditions(
    scene: mtb.Scene, model: Any, steps: list[tuple[mtb.StepResult, Any]], friction: float
) -> set[int]:
    """Holds states against the conditions of contact and friction; which states points had."""
    problem = scene.problem(model, may_halve=False)
    pair, loading, n = problem.core.pair, problem.loading, problem.n
    matrix = np.block([[pair.influence(i, j) for j in "xyn"] for i in "xyn"])
    motions = problem.relative_motions.reshape(-1, 3 * n)
    area = np.tile(problem.area, 3)
    tangents = problem.geometry.tangents[:, :2, :]
    old, seen = None, set()
    for step, shift in steps:
        assert step.state.traction is not None
        q, p = step.state.traction, step.state.pressure
        u = np.concatenate([q.ravel(), p])
        v = (matrix @ u + step.state.motion @ motions).reshape(3, n)
        gap = loading.gap + v[2]
        if old is not None:
            slip = np.einsum("kcn,c->kn", tangents, np.asarray(shift)) - (v[:2] - old)
            most, far = p.max(), max(np.abs(slip).max(), 1e-9)
            assert p.min() >= 0.0
            assert gap.min() > -1e-10 * np.abs(v[2]).max()
            assert np.abs(p * gap).max() < 1e-9 * most * np.abs(v[2]).max()
            stick, slide = step.status == 1, step.status == 2
            assert np.all(np.hypot(*q) <= friction * p + 1e-9 * most)
            assert np.abs(slip[:, stick]).max(initial=0.0) < 1e-9 * far
            along = slip[:, slide] / np.hypot(*slip[:, slide])
            assert np.abs(q[:, slide] - friction * p[slide] * along).max(initial=0.0) < 1e-7 * most
            seen |= set(step.status.tolist())
        balance = motions @ (area * u) + loading.work
        assert np.abs(balance).max(initial=0.0) < 1e-9 * np.abs(area * u).sum()
        old = v[:2]
    return seen


@pytest.mark.parametrize("model", ["elastic-upper", "elastic-both"])
def test_elastic_bodies_meet_the_conditions_of_stick_and_slip(model: Any) -> None:
    scene = shoe()
    contact = scene.prepare(model)
    steps = []
    # rest, to sliding, rest again, reversal, askew
    for shift in [(0.0, 0.0), (2e-6, 0.0), (4e-6, 0.0), (2e-5, 0.0), (0.0, 0.0), (-5e-6, 2e-6), (-3e-5, 0.0)]:
        steps.append((contact.step(shift=shift), shift))
    assert {1, 2} <= conditions(scene, model, steps, 0.3)
    forces = [step.force[0] for step, _ in steps]
    assert abs(forces[0]) < 1e-3 * abs(steps[0][0].force[2])
    assert 0.0 < forces[1] < forces[2]
    assert forces[2] == pytest.approx(forces[3], rel=2e-2)
    # it stands, and its friction goes on holding
    assert forces[4] == pytest.approx(forces[3], rel=1e-9)
    assert forces[6] < 0.0


def test_a_block_stands_on_a_slope_and_breaks_away_beyond_the_angle_of_friction() -> None:
    """Pushed by a share of its weight that grows as the slope does: it slides once that is above mu."""
    load, mass, dt = 1e3, 100.0, 1e-4
    contact = ball(load, points=10).prepare("half-space")
    for slope, slides in ((0.95 * MU, False), (1.05 * MU, True)):
        held = contact.copy()
        held.step(shift=0.0)
        speed, way, force = 0.0, 0.0, 0.0
        for k in range(800):
            # the slope rises, then stays; the damper calms the spring of the contact
            push = slope * load * min(1.0, k / 300)
            speed += dt * (push - force - 2e4 * speed) / mass
            way += dt * speed
            force = float(held.step(shift=(dt * speed, 0.0)).force[0])
        if slides:
            assert force == pytest.approx(MU * load, rel=1e-9)
            assert speed == pytest.approx((slope - MU) * load / 2e4, rel=0.05)
        else:
            assert force == pytest.approx(slope * load, rel=1e-3)
            assert abs(speed) * dt < 1e-4 * way


def test_a_pose_shifts_points_as_a_shift_does() -> None:
    nan = float("nan")
    first, second = (ball().prepare("half-space") for _ in range(2))
    # the first one presses the bodies where they are
    for x, shift in ((1e-6, 0.0), (3e-6, 2e-6), (2e-6, -1e-6)):
        by_pose = first.step(pose=(x, 0.0, nan, nan, nan, nan), shift=0.0)
        by_shift = second.step(shift=(shift, 0.0))
        most = by_shift.pressure.max()
        np.testing.assert_allclose(by_pose.traction, by_shift.traction, rtol=0.0, atol=1e-9 * most)
    assert by_shift.traction.any()


def test_turning_on_the_spot_rubs_round_the_middle() -> None:
    nan = float("nan")
    contact = ball().prepare("half-space")
    contact.step(shift=0.0)
    step = contact.step(pose=(0.0, 0.0, nan, 0.0, 0.0, 5e-3), shift=0.0)
    x, y = contact.points[:2]
    turned = x * step.traction[1] - y * step.traction[0]
    rubs = (step.status == 2) & (np.hypot(x, y) > 0.0)
    assert rubs.any()
    assert np.allclose(turned[rubs], MU * (np.hypot(x, y) * step.pressure)[rubs], rtol=2e-2)
    assert np.hypot(*step.force[:2]) < 1e-9 * 1e3


def test_states_go_on_where_they_were_left() -> None:
    contact = ball(upper=RUBBER).prepare("half-space")
    for shift in WAY[:3]:
        step = contact.step(shift=shift)
    state = pickle.loads(pickle.dumps(step.state))
    on = contact.step(shift=WAY[3])
    again = contact.copy().step(shift=WAY[3], state=state)
    np.testing.assert_allclose(again.traction, on.traction, rtol=0.0, atol=1e-10 * on.pressure.max())
    assert not np.allclose(contact.copy().step(shift=WAY[3]).traction, on.traction)


@pytest.mark.parametrize("made", [ball, shoe])
def test_pickles_and_deep_copies_go_on_as_the_original_does(made: Any) -> None:
    scene = made(upper=RUBBER) if made is ball else made(magnetic_pressure=mtb.Magnet(4e3, 1e-3))
    contact = scene.prepare("half-space" if made is ball else "auto")
    new = pickle.loads(pickle.dumps(contact))
    first = contact.step(shift=WAY[0])
    np.testing.assert_allclose(new.step(shift=WAY[0]).traction, first.traction, rtol=0.0, atol=1e-6)
    # a step that slides is remembered as well
    for sliding in (False, True):
        for shift in WAY[1:3]:
            contact.step(shift=shift)
        if sliding:
            contact.step(velocity=1.0)
        others = [pickle.loads(pickle.dumps(contact)), copy.deepcopy(contact), copy.copy(contact)]
        others.append(pickle.loads(pickle.dumps(others[0])))
        fresh = contact.copy()
        for shift in WAY[3:]:
            on, new_one = contact.step(shift=shift), fresh.step(shift=shift)
            if shift == WAY[3]:
                assert not np.allclose(new_one.traction, on.traction, rtol=0.0, atol=1e-3 * on.pressure.max())
            for other in others:
                again = other.step(shift=shift)
                largest = on.pressure.max()
                np.testing.assert_allclose(again.traction, on.traction, rtol=0.0, atol=1e-9 * largest)
                assert np.array_equal(again.status, on.status)


def test_it_says_what_it_cannot_do(tmp_path: Path) -> None:
    contact = ball(points=6).prepare("half-space")
    step = contact.step(shift=(1e-6, 0.0))
    assert np.isnan(step.friction_power)
    with pytest.raises(ValueError, match="started from rest"):
        step.gradient("force_x")  # type: ignore[attr-defined]
    with pytest.raises(ValueError, match=r"shift is \(1, 2, 3\): a number or \(dx, dy\) \[m\] is needed"):
        contact.step(shift=(1, 2, 3))
    with pytest.raises(ValueError, match=r"gap\[0\] is 1e\+30 m: numbers from -1000 to 1000 m are needed"):
        contact.step(velocity=1.0, gap=np.full(36, 1e30))
    bare = mtb.StepState(step.state.pressure, step.state.motion)
    with pytest.raises(ValueError, match="state holds no tractions"):
        contact.step(shift=0.0, state=bare)
    contact.save(tmp_path / "ball.mtbc")
    with pytest.raises(ValueError, match="the compliance along the tangents is not known"):
        mtb.PreparedContact.load(tmp_path / "ball.mtbc").step(shift=0.0)
    hard = ball(points=6, force=1e3).with_(hardness=3e9).prepare("half-space")
    with pytest.raises(ValueError, match="a step with a shift takes none into account"):
        hard.step(shift=0.0)


def test_free_motions_may_change_from_step_to_step() -> None:
    """A height that was held and is free again, a lift and a new touch: as if the rest had not been."""
    contact = mtb.scenes.paraboloid_on_plane(
        radius=0.05, force=1e3, points=10, upper=mtb.steel, lower=mtb.steel, friction=0.3, width=3e-3
    ).prepare("half-space")
    fresh = contact.copy().step(shift=1e-6)
    held = (0.0, 0.0, -5e-6, 0.0, 0.0, 0.0)
    contact.step(shift=1e-6)
    assert contact.step(pose=held, shift=1e-6).slip is not None
    assert contact.step(shift=0.0).force[2] == pytest.approx(-1e3, rel=1e-9)
    lifted = contact.step(pose=(0.0, 0.0, 1e-3, 0.0, 0.0, 0.0), shift=1e-6)
    assert not lifted.force.any()
    again = contact.step(shift=1e-6)
    assert again.force == pytest.approx(fresh.force, rel=1e-8, abs=1e-8)


def test_without_friction_or_load_nothing_sticks() -> None:
    contact = mtb.scenes.pole_shoe_on_rail(
        friction=0.3, magnetic_pressure=3e6, spacing=14e-3, poles=2
    ).prepare("elastic-upper")
    contact.step(shift=1e-7)
    smooth = contact.step(shift=1e-7, friction=0.0)
    assert smooth.report.status == "solved"
    assert not smooth.traction[:2].any()
    off = contact.step(shift=1e-7, magnetic_pressure=0.0)
    assert off.report.status == "solved"
    # what is left is the rounding of micrometres
    assert np.abs(off.force).max() < 1e-9


def test_what_is_called_solved_carries_the_load() -> None:
    """Far lateral shifts, under which the poles tip: a balanced state, or none."""
    contact = mtb.scenes.pole_shoe_on_rail(
        friction=0.3, magnetic_pressure=3e6, spacing=14e-3, poles=2
    ).prepare("elastic-upper")
    load = contact.copy().step(shift=0.0).force[2]
    solved = 0
    for shift in (-1e-3, -3e-4, -1e-4, -1e-5, -1e-6, -1e-7):
        try:
            step = contact.copy().step(shift=(0.0, shift))
        except mtb.ConvergenceError:
            continue
        solved += 1
        assert step.force[2] == pytest.approx(load, rel=1e-8)
        assert step.friction_work is None or step.friction_work >= 0.0
    assert solved > 0


def test_a_refused_step_leaves_the_memory() -> None:
    contact = mtb.scenes.paraboloid_on_plane(
        radius=0.05, force=1e3, points=10, upper=mtb.steel, lower=mtb.steel, friction=0.3, width=3e-3
    ).prepare("half-space")
    rest = contact.step(shift=0.0).state
    moved = contact.step(shift=1e-6)
    with pytest.raises(ValueError, match="gap"):
        contact.step(shift=0.0, gap=np.full(contact.area.size, np.nan), state=rest)
    assert contact.step(shift=0.0).force == pytest.approx(moved.force, rel=1e-9, abs=1e-9)


class TestPullThatChanges:
    """An elastic body that is pulled at its face moves along it as well."""

    #: In parts of the first one.
    WAY = (1.02, 1.3, 0.9, 1.5, 1.0)

    @pytest.mark.parametrize("case", ["shoe on a rigid rail", "pulled alike", "half-space", "block"])
    def test_a_body_that_sticks_keeps_its_tractions(self, case: str) -> None:
        """Held on a rigid body, it does not move: its pressure takes all of the change, and friction nothing.

        The same holds for two bodies that are pulled towards each other at their faces, and for pulls that
        move no surface.
        """
        words: dict[str, Any] = {"friction": 0.6, "magnetic_pressure": 3e6}
        if case == "half-space":
            scene, model = mtb.scenes.pole_shoe_on_rail(spacing=12e-3, poles=1, **words), "half-space"
        elif case == "pulled alike":
            scene, model = shoe(attraction="both", friction=0.6), "elastic-both"
        elif case == "block":
            scene, model = (
                mtb.scenes.block_on_plane(spacing=20e-3, lower=mtb.Rigid(), supports="driven-top", **words),
                "elastic-upper",
            )
        else:
            scene, model = shoe(poles=2, friction=0.6, lower=mtb.Rigid()), "elastic-upper"
        contact = scene.prepare(model)
        contact.step(shift=0.0)
        first = contact.step(shift=(2e-8, 0.0))
        assert first.traction.any()
        assert (first.pressure > 0.0).all() or case in ("pulled alike", "half-space")
        for share in self.WAY:
            held = contact.step(shift=0.0, magnetic_pressure=share * 3e6)
            assert np.all(held.status[held.pressure > 0.0] == 1)
            if case != "half-space":
                assert np.abs(held.traction - first.traction).max() < 1e-8 * first.pressure.max()
            if case in ("block", "shoe on a rigid rail"):
                more = held.pressure - first.pressure
                assert more == pytest.approx((share - 1.0) * 3e6, rel=1e-6, abs=1.0)
        # back at the first pull, all is as it was
        assert np.abs(held.traction - first.traction).max() < 1e-8 * first.pressure.max()

    @pytest.mark.parametrize("model", ["elastic-upper", "elastic-both"])
    def test_a_shoe_at_rest_holds_as_its_pull_grows(self, model: Any) -> None:
        contact = shoe(poles=2).prepare(model)
        rest = contact.step(shift=0.0)
        for share in self.WAY:
            held = contact.step(shift=0.0, magnetic_pressure=share * 3e6)
            assert np.all(held.status == 1)
            assert held.state.traction is not None
            share_of_bound = np.hypot(*held.state.traction) / (MU * held.state.pressure)
            assert share_of_bound.max() < (0.05 if share == 1.02 else 0.7)
        assert np.abs(held.traction - rest.traction).max() < 1e-8 * rest.pressure.max()

    @pytest.mark.parametrize("attraction", ["upper", "both"])
    def test_what_sticks_does_not_move(self, attraction: Any) -> None:
        """Against the displacements of both bodies under all that acts on them, point by point."""
        scene = shoe(attraction=attraction)
        contact, problem = scene.prepare("elastic-both"), scene.problem("elastic-both", may_halve=False)
        motions = problem.relative_motions.reshape(-1, 3, problem.n)[:, :2]
        tangents = problem.geometry.tangents[:, :2, :]

        def place(step: mtb.StepResult, share: float) -> np.ndarray:
            q, p = step.state.traction, step.state.pressure
            pull = share * np.asarray(problem.upper.pull)
            unknowns = np.ascontiguousarray(np.concatenate([q, p[None]]))
            below = pull if attraction == "both" else None
            lower = problem.core.displacement(unknowns, False, below)
            upper = problem.core.displacement(unknowns, True, pull)
            along = [axis for axis in problem.geometry.tangents[:2]]
            apart = np.array([np.einsum("cn,cn->n", axis, lower - upper) for axis in along])
            return apart + np.einsum("m,mkn->kn", step.state.motion, motions)

        last, share = contact.step(shift=0.0), 1.0
        slips, sticks = 0, 0
        for new, shift in ((1.4, 0.0), (0.7, 3e-7), (0.3, 2e-6), (0.9, 0.0), (0.5, -2e-6)):
            step = contact.step(shift=(shift, 0.0), magnetic_pressure=new * 3e6)
            moved = np.einsum("kcn,c->kn", tangents, np.array([shift, 0.0])) - (
                place(step, new) - place(last, share)
            )
            assert step.slip is not None
            known = np.einsum("kcn,cn->kn", problem.geometry.tangents[:2], step.slip)
            closed = step.pressure > 0.0
            assert np.abs(moved - known)[:, closed].max() < 1e-13
            slips += int(np.count_nonzero(step.status == 2))
            sticks += int(np.count_nonzero(step.status == 1))
            last, share = step, new
        assert slips > 0
        assert sticks > 0

    def test_all_ways_to_give_a_pull_are_one(self) -> None:
        """Number, field, table over the velocity, and a magnet that follows the gap."""
        table = mtb.VelocityTable((0.0, 10.0), (3e6, 1.5e6))
        plain = shoe()
        number, field = (plain.prepare("elastic-upper") for _ in range(2))
        over = shoe(magnetic_pressure=table).prepare("elastic-upper")
        for speed, shift in ((0.0, 0.0), (4.0, 1e-7), (10.0, 5e-7), (1.0, 0.0)):
            pull = 3e6 - 1.5e5 * speed
            a = number.step(shift=shift, magnetic_pressure=pull)
            b = field.step(shift=shift, magnetic_pressure=np.asarray(number._source.pull(pull, 0.0)))
            c = over.step(shift=shift, velocity=(speed, 0.0))
            for other in (b, c):
                np.testing.assert_allclose(other.traction, a.traction, rtol=0.0, atol=1e-9 * a.pressure.max())
        assert a.traction.any()
        follow, given = plain.prepare("elastic-upper"), plain.prepare("elastic-upper")
        for turns, shift in ((4e3, 0.0), (3e3, 1e-7), (5e3, 2e-7), (2e3, 0.0)):
            a = follow.step(shift=shift, magnetic_pressure=mtb.Magnet(turns, 1e-3))
            b = given.step(shift=shift, magnetic_pressure=a.magnetic_pressure)
            np.testing.assert_allclose(b.traction, a.traction, rtol=0.0, atol=1e-8 * a.pressure.max())
        assert a.traction.any()


@pytest.mark.parametrize(
    ("poles", "model"), [(1, "elastic-upper"), (2, "elastic-upper"), (2, "elastic-both")]
)
def test_random_steps_find_their_state(poles: int, model: Any) -> None:
    """Pull, friction and shift change by any amount, and back; work is never taken out of friction."""
    rng = np.random.default_rng(7)
    attraction = "both" if model == "elastic-both" else "upper"
    contact = shoe(poles=poles, spacing=14e-3, attraction=attraction).prepare(model)
    for _ in range(60):
        size, angle = 10 ** rng.uniform(-8.0, -4.0), rng.uniform(0.0, 2.0 * np.pi)
        shift = (size * np.cos(angle), size * np.sin(angle))
        pull, friction = 3e6 * rng.uniform(0.2, 2.0), rng.uniform(0.0, 0.6)
        step = contact.step(shift=shift, magnetic_pressure=pull, friction=friction)
        assert step.friction_work is not None
        assert step.friction_work >= 0.0
        q, p = step.state.traction, step.state.pressure
        assert q is not None
        assert np.all(np.hypot(*q) <= friction * p + 1e-8 * p.max())
        slides = step.status == 2
        assert np.allclose(np.hypot(*q)[slides], friction * p[slides], rtol=0.0, atol=1e-8 * p.max())


def test_jumps_of_height_and_tilt_take_few_newton_steps() -> None:
    """Where a lift leaves no point in contact, the search begins with those that press."""
    rng = np.random.default_rng(3)
    contact = shoe(poles=2, spacing=8e-3).prepare("elastic-upper")
    for k in range(80):
        pose = np.full(6, np.nan)
        if k % 2:
            pose[2] = rng.uniform(-1e-5, 2e-5)
        else:
            pose[3:5] = rng.uniform(-1e-4, 1e-4, 2)
        step = contact.step(pose=pose, shift=rng.uniform(-1e-6, 1e-6, 2))
        # it took up to 500, over states between
        assert step.report.iterations < 100
        assert step.pressure.max() > 0.0


def test_a_body_that_tips_over_is_told() -> None:
    contact = mtb.scenes.pole_shoe_on_rail(
        friction=0.9, magnetic_pressure=3e6, spacing=14e-3, poles=1
    ).prepare("elastic-upper")
    contact.step(shift=0.0)
    with pytest.raises(mtb.ResultantError, match="tips over"):
        contact.step(shift=(0.0, -2e-2))


def test_rounding_keeps_no_shoe_from_its_state() -> None:
    """Amplitudes of motions beside tractions once left 1e-11 of the pressure, where Newton stood still."""
    contact = mtb.scenes.pole_shoe_on_rail(
        friction=0.3, magnetic_pressure=3e6, spacing=(90e-3 / 24, 2.3e-3)
    ).prepare("elastic-upper")
    residuals = [contact.step(shift=shift).report.residual for shift in (0.0, 25e-9, 24.8e-9, 23.3e-9)]
    assert max(residuals) < 1e-13
