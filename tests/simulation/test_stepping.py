# SPDX-License-Identifier: MIT OR Apache-2.0
"""Prepared contacts: steps equal solves, poses move, reversals reverse, memory changes nothing but time."""

import os
import pickle
import threading
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import mtb_rs as mtb

FRICTION = mtb.VelocityTable((0.0, 10.0, 50.0), (0.4, 0.2, 0.1))
MAGNET = mtb.VelocityTable(
    (0.0, 20.0, 60.0), (3e6, mtb.GaussianPressure(3e6, (0.0, 15e-3), (0.04, 0.02)), 1.5e6)
)
rubber = mtb.Material(young_modulus=5e9, poisson_ratio=0.2)


def shoe(**changes):
    arguments = {"friction": FRICTION, "magnetic_pressure": MAGNET, "spacing": 6e-3, **changes}
    return mtb.scenes.pole_shoe_on_rail(**arguments)


SCENES = {
    "half-space": (shoe(upper=rubber), "half-space"),
    "elastic": (shoe(), "elastic-upper"),
    "both pulled": (shoe(attraction="both", poles=1), "elastic-upper"),
    "clamped": (mtb.scenes.block_on_plane(spacing=1e-2, friction=0.4), "elastic-upper"),
    "force": (mtb.scenes.paraboloid_on_plane(points=14, upper=rubber, friction=FRICTION), "half-space"),
}


@pytest.mark.coarse
@pytest.mark.parametrize("name", SCENES)
def test_a_step_equals_a_solve(name):
    scene, model = SCENES[name]
    contact = scene.prepare(model, reference_point=(0.0, 0.0, 0.05))
    for velocity in (15.0, 14.99, 45.0, 3.0):
        step = contact.step(velocity=velocity)
        solved = scene.with_(velocity=velocity).solve(model=model)
        np.testing.assert_allclose(step.force, solved.force, rtol=1e-9, atol=1e-9 * abs(solved.force[2]))
        moment = solved.moment - np.cross([0.0, 0.0, 0.05], solved.force)
        np.testing.assert_allclose(step.moment, moment, rtol=0, atol=1e-9 * np.abs(moment).max())
        apart = np.abs(step.pressure - solved.pressure.ravel()).max()
        assert apart < 1e-9 * solved.pressure.max()
        assert step.report.residual < 1e-11


@pytest.mark.coarse
@pytest.mark.parametrize("attraction", ["upper", "both"])
def test_a_symmetric_shoe_on_an_elastic_rail_takes_loads_that_are_not_symmetric(attraction):
    """The rail is the mirror image of itself, and so is the scene; what comes later need not be."""
    scene = mtb.scenes.pole_shoe_on_rail(spacing=8e-3, friction=0.3, attraction=attraction)
    contact = scene.prepare("elastic-both")
    for pull in (3e6, [4e6, 1e6]):
        step = contact.step(velocity=1.0, magnetic_pressure=pull)
        solved = scene.with_(magnetic_pressure=pull).solve("elastic-both")
        apart = np.abs(step.pressure - solved.pressure.ravel()).max()
        assert apart < 1e-9 * solved.pressure.max()
        np.testing.assert_allclose(step.force, solved.force, rtol=0, atol=1e-9 * abs(solved.force[2]))


def test_steps_are_as_near_to_convolutions_as_they_say():
    """More than 2000 points of a flat grid: the solve iterates, the step has the matrices."""
    scene = mtb.scenes.paraboloid_on_plane(points=46, upper=rubber, friction=0.3)
    solved, step = scene.solve("half-space"), scene.prepare("half-space").step(velocity=1.0)
    assert "FFT" in solved.report.solver
    largest = solved.pressure.max()
    np.testing.assert_allclose(step.pressure, solved.pressure.ravel(), rtol=0, atol=1e-6 * largest)
    np.testing.assert_allclose(step.force, solved.force, rtol=0, atol=1e-9 * abs(solved.force[2]))


def test_backwards_is_the_mirror_image_of_forwards():
    scene, model = SCENES["elastic"]
    contact = scene.prepare(model)
    forwards = contact.step(velocity=12.0)
    backwards = contact.step(velocity=-12.0)
    mirror = np.array([-1.0, 1.0, 1.0])
    np.testing.assert_allclose(
        backwards.force, mirror * forwards.force, rtol=1e-7, atol=1e-7 * forwards.force[0]
    )
    assert forwards.friction_power > 0.0
    assert backwards.friction_power == pytest.approx(forwards.friction_power, rel=1e-7)
    as_vector = contact.step(velocity=(-12.0, 0.0), dt=0.5)
    np.testing.assert_allclose(as_vector.force, backwards.force, rtol=1e-9, atol=1e-6)
    assert as_vector.friction_work == pytest.approx(0.5 * as_vector.friction_power)


def test_a_pose_found_from_balance_reproduces_itself_when_prescribed():
    scene, model = SCENES["half-space"]
    scene = scene.with_(velocity=10.0)
    contact = scene.prepare(model)
    assert contact.motions == ["left z", "right z"]
    free = contact.step()
    # both poles go down alike: the approach is the pose
    pose = np.full(6, np.nan)
    pose[2] = -scene.solve(model=model).approach[0]
    held = contact.step(pose)
    np.testing.assert_allclose(held.force, free.force, rtol=1e-9, atol=1e-6)
    assert held.state.motion.size == 0
    assert contact.step(1.1 * pose).force[2] < held.force[2]
    assert contact.step(np.zeros(6)).force[2] == pytest.approx(0.0, abs=1e-6)


def test_prescribed_pitch_moves_the_pressure_forward():
    scene, model = SCENES["elastic"]
    contact = scene.with_(velocity=10.0).prepare(model)
    level = np.array([np.nan, np.nan, np.nan, np.nan, 0.0, np.nan])
    nose_down = level.copy()
    nose_down[4] = 2e-5
    before, after = contact.step(level), contact.step(nose_down)
    x = contact.points[0]

    def centre(step):
        return (x * step.pressure * contact.area).sum() / (step.pressure * contact.area).sum()

    assert centre(after) > centre(before) + 1e-3
    assert after.force[2] == pytest.approx(before.force[2], rel=1e-9)  # z stays free


def test_magnetic_pressure_in_place_of_the_scenes():
    scene, model = SCENES["elastic"]
    contact = scene.prepare(model)
    for pull in (2e6, lambda x, y: 2e6 * (1.0 + 3.0 * x), [2e6, 1e6]):
        solved = scene.with_(velocity=5.0, magnetic_pressure=pull).solve(model=model)
        step = contact.step(velocity=5.0, magnetic_pressure=pull)
        np.testing.assert_allclose(step.force, solved.force, rtol=1e-9, atol=1e-9 * abs(solved.force[2]))


def test_saving_keeps_the_users_mode_and_leaves_nothing_behind(tmp_path):
    contact = mtb.scenes.paraboloid_on_plane(points=6, friction=0.2).prepare()
    plain, saved = tmp_path / "plain", tmp_path / "saved"
    plain.touch()
    contact.save(saved)
    assert saved.stat().st_mode == plain.stat().st_mode
    with pytest.raises(ValueError, match="it is a directory"):
        contact.save(tmp_path)
    assert sorted(tmp_path.iterdir()) == [plain, saved]


def test_memory_and_state_change_nothing_but_time(tmp_path):
    scene, model = SCENES["elastic"]
    contact = scene.prepare(model)
    first = contact.step(velocity=20.0)
    again = contact.step(velocity=20.0)
    assert not again.report.refactored
    assert again.report.products < first.report.products
    state = pickle.loads(pickle.dumps(first.state))
    other = contact.copy()
    resumed = other.step(velocity=20.0, state=state)
    fresh = contact.copy().step(velocity=20.0)
    file = tmp_path / "shoe.mtbc"
    contact.save(file)
    loaded = mtb.PreparedContact.load(file)
    copies = [
        resumed,
        again,
        fresh,
        loaded.step(velocity=20.0),
        pickle.loads(pickle.dumps(contact)).step(velocity=20.0),
    ]
    for step in copies:
        assert np.abs(step.state.pressure - first.state.pressure).max() < 1e-11 * first.state.pressure.max()
    np.testing.assert_array_equal(loaded.points, contact.points)
    data = bytearray(file.read_bytes())
    data[len(data) // 2] ^= 1
    file.write_bytes(data)
    with pytest.raises(ValueError, match=r"shoe\.mtbc: not a prepared contact: its checksum is wrong"):
        mtb.PreparedContact.load(file)
    with pytest.raises(ValueError, match="a contact from a file takes a number"):
        loaded.step(velocity=20.0, magnetic_pressure=[1e6, 2e6])


def test_a_contact_at_the_edge_of_its_grid_is_refused_from_any_file(tmp_path):
    """Half-spaces go on beyond their grid, a punch ends with it: the file says which."""
    x = np.linspace(-1.0, 1.0, 9) * 0.9e-3
    ball = mtb.Scene(
        upper=mtb.steel, lower=mtb.steel, gap=x[:, None] ** 2 + x**2, spacing=0.2e-3, friction=0.2, force=10.0
    )
    block = mtb.scenes.block_on_plane(width=0.04, height=0.02, spacing=1e-2, friction=0.2)
    for scene, model, is_refused in ((ball, "half-space", True), (block, "elastic-upper", False)):
        contact = scene.prepare(model)
        contact.save(tmp_path / "contact.mtbc")
        read = mtb.PreparedContact.load(tmp_path / "contact.mtbc")
        for own in (contact, contact.copy(), read, read.copy(), pickle.loads(pickle.dumps(contact))):
            fine = own.step(velocity=1.0)
            if is_refused:
                with pytest.raises(ValueError, match=r"reaches the edge of the grid of 9 x 9 points at x = "):
                    own.step([0.0, 0.0, -1e-5, 0.0, 0.0, 0.0], 1.0)
            else:
                own.step([0.0, 0.0, -1e-5, 0.0, 0.0, 0.0], 1.0)
            np.testing.assert_allclose(own.step(velocity=1.0).force, fine.force, rtol=1e-12, atol=1e-9)


def test_results_pickle():
    scene, model = SCENES["elastic"]
    step = scene.prepare(model).step(velocity=20.0)
    data = pickle.dumps(step)
    # the matrices stay behind
    assert len(data) < 100 * step.gap.nbytes
    again = pickle.loads(pickle.dumps(pickle.loads(data)))
    np.testing.assert_array_equal(again.pressure, step.pressure)
    np.testing.assert_array_equal(again.force, step.force)
    assert again.report == step.report
    assert again.plot("gap").axes
    assert again.plot(kind="line").axes


def test_heat_is_the_work_of_friction_alone():
    frictionless = shoe(upper=rubber, friction=0.0, magnetic_pressure=[3e6, 1e6]).prepare("half-space")
    across = frictionless.step(velocity=(0.0, 5.0), dt=1.0)
    # pressures push sideways on the round rail, which heats nothing
    assert abs(across.force[1]) > 10.0
    assert across.friction_power == across.friction_work == 0.0
    contact = shoe(upper=rubber, friction=0.3, magnetic_pressure=[3e6, 1e6]).prepare("half-space")
    for velocity in ((0.0, 5.0), (0.0, -5.0), (3.0, 4.0), (-2.0, 0.0)):
        step = contact.step(velocity=velocity)
        along = np.array([*velocity, 0.0])
        tangential = along[:, None] - contact.normal * (along @ contact.normal)
        heat = (0.3 * step.pressure * np.linalg.norm(tangential, axis=0) * contact.area).sum()
        assert step.friction_power == pytest.approx(heat, rel=1e-9)


def test_one_object_serves_threads():
    contact = shoe(upper=rubber).prepare("half-space")
    wanted = {v: contact.copy().step(velocity=v).force for v in np.linspace(1.0, 40.0, 8)}
    wrong = []

    def work(velocity):
        for _ in range(20):
            if np.abs(contact.step(velocity=velocity).force - wanted[velocity]).max() > 1e-6:
                wrong.append(velocity)

    threads = [threading.Thread(target=work, args=(v,)) for v in wanted]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert wrong == []


def resident() -> int:
    """Memory of this process [bytes]."""
    statm = Path("/proc/self/statm")
    if not statm.exists():
        pytest.skip("the memory of a process is read from /proc, which is not here")
    return int(statm.read_text().split()[1]) * os.sysconf("SC_PAGE_SIZE")


def test_memory_does_not_grow():
    contact = shoe().prepare("elastic-upper")
    random = np.random.default_rng(3)

    def ride(steps):
        for _ in range(steps):
            pose = np.full(6, np.nan)
            pose[4] = 6e-5 * random.uniform(-1, 1)
            contact.step(pose, random.uniform(1.0, 50.0) * random.choice((-1, 1)), 1e-3)

    ride(300)
    before = resident()
    ride(3000)
    # what a step returns is 4 kB; 3000 of them would be 12 MB
    assert resident() - before < 3e6


def test_wedging_is_named():
    scene = mtb.scenes.block_on_plane(width=0.1, height=0.5, spacing=2e-2, friction=0.1)
    contact = scene.with_(friction=mtb.VelocityTable((0.0, 1.0), (0.0, 1.0))).prepare("elastic-upper")
    assert contact.step(velocity=0.1).report.status == "solved"
    with pytest.raises(mtb.ConvergenceError, match="no sliding equilibrium: the body wedges") as caught:
        contact.step(velocity=0.9)
    assert caught.value.result.report.fell_back
    # and the memory is as good as before
    assert contact.step(velocity=0.1).report.status == "solved"


def bent(contact, **changes):
    return replace(contact.step(velocity=1.0).state, **changes)


BAD = [
    (lambda c: c.step(), "velocity is missing"),
    (lambda c: c.step(velocity=0.0), "velocity is 0: at rest friction has no direction"),
    (lambda c: c.step(velocity=70.0), "the table of friction covers 0 to 50 m/s"),
    (lambda c: c.step(velocity=float("nan")), "velocity is nan"),
    (lambda c: c.step(velocity=(1.0, 2.0, 3.0)), "velocity is .*a number or"),
    (lambda c: c.step([0.0] * 5, 1.0), "pose is .*six real numbers"),
    (lambda c: c.step([0.0] * 5 + [1j], 1.0), "pose is .*six real numbers"),
    (lambda c: c.step([0.0] * 5 + [[1.0]], 1.0), "pose is .*six real numbers"),
    (lambda c: c.step([np.inf] * 6, 1.0), "pose, x, is inf"),
    (lambda c: c.step([0.0, 0.0, -1e300, 0.0, 0.0, 0.0], 1.0), r"pose, z, is -1e\+300"),
    (lambda c: c.step(velocity=1.0, state=5), "state is 5: a StepState"),
    (lambda c: c.step(velocity=1.0, state=bent(c, pressure=[0.0])), "state.pressure is tuple"),
    (lambda c: c.step(velocity=1.0, state=bent(c, motion=np.zeros(2, "f4"))), "state.motion is float32"),
    (lambda c: c.step(velocity=1.0, dt=-1.0), "dt is -1.0"),
    (lambda c: c.step(velocity=1.0, magnetic_pressure=np.ones(3)), "magnetic_pressure has shape"),
]


@pytest.mark.parametrize(("call", "message"), BAD, ids=[message[:24] for _, message in BAD])
def test_bad_input_is_named(call, message):
    contact = shoe(upper=rubber).prepare("half-space")
    with pytest.raises(ValueError, match=message):
        call(contact)


def test_what_cannot_be_prepared_is_named():
    law = mtb.PressureDependentFriction(lambda p: 0.3 + 0.0 * p)
    with pytest.raises(ValueError, match="friction depends on the pressure"):
        shoe(friction=law).prepare("half-space")
    with pytest.raises(ValueError, match="standstill_speed is -1"):
        shoe().prepare("half-space", standstill_speed=-1)
    slow = shoe(upper=rubber).prepare("half-space", standstill_speed=0.1)
    assert slow.step(velocity=0.0).force[0] == 0.0
    full, half = slow.step(velocity=0.1), slow.step(velocity=0.05)
    assert half.force[0] == pytest.approx(0.5 * full.force[0], rel=1e-2)


def test_what_all_steps_share_cannot_be_written_to():
    contact = mtb.scenes.block_on_plane(spacing=2e-2).prepare("half-space")
    first = contact.step(velocity=1.0)
    for shared in (first.points, first.area):
        with pytest.raises(ValueError, match="read-only"):
            shared[...] = 0.0


def test_a_tolerance_given_to_prepare_is_held_to():
    scene = mtb.scenes.pole_shoe_on_rail(friction=0.3, magnetic_pressure=1e6, spacing=12e-3)
    with pytest.warns(mtb.ToleranceWarning, match="estimated error of the pressure") as caught:
        contact = scene.prepare(tolerance=0.05, quantity="pressure")
    (warning,) = caught
    assert warning.filename == __file__
    # without one no estimate is made
    equal = scene.prepare("elastic-upper")
    one, two = (c.step(velocity=1.0).force for c in (contact, equal))
    np.testing.assert_allclose(one, two, rtol=1e-9, atol=1e-6)
