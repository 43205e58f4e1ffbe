# SPDX-License-Identifier: MIT OR Apache-2.0
"""A magnet that follows the gap, by each door that takes a magnetic pressure: one state, or a refusal."""

from __future__ import annotations

import pickle
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import mtb_rs as mtb

pytestmark = pytest.mark.coarse

MAGNET = mtb.Magnet(
    3e3, 1e-3, iron_share=1.9, pole_length=30e-3, yoke=(0.15, 3e-3), armature=(60e-3, 3e-3), leakage=1e-7
)


@cache
def shoe(**changes: Any) -> mtb.Scene:
    given = {"friction": 0.3, "magnetic_pressure": MAGNET, "spacing": 9e-3, "velocity": 10.0} | changes
    return mtb.scenes.pole_shoe_on_rail(**given)


@pytest.mark.parametrize("model", ["half-space", "elastic-upper", "elastic-both"])
@pytest.mark.parametrize("attraction", ["upper", "both"])
def test_the_state_is_that_of_its_own_pull(model: Any, attraction: Any) -> None:
    """A solve under the pull of the state, given as a field, is the state; the pull is that at its gaps."""
    scene = shoe(attraction=attraction, lateral=1e-3)
    result = scene.solve(model=model)
    pull = result.magnetic_pressure
    assert pull is not None
    again = scene.with_(magnetic_pressure=pull).solve(model=model)
    np.testing.assert_allclose(again.pressure, result.pressure, atol=1e-9 * result.pressure.max())
    np.testing.assert_allclose(again.force, result.force, atol=1e-9 * abs(result.force[2]))
    circuit = MAGNET.circuit(result.area, result.patches, None)
    np.testing.assert_allclose(circuit.attract(result.gap, 1.0)[0], pull, rtol=1e-9)
    told = result.report.magnet
    assert told["attraction"] == pytest.approx(float((pull * result.area).sum()), rel=1e-12)
    assert sum(told["ampere_turns_of_poles"]) < 3e3
    assert told["residual"] <= 1e-10
    assert 0.0 <= told["snap_share"] < 1e-2
    assert result.report.force_balance["relative_error"] < 1e-9
    step = scene.prepare(model=model).step()
    np.testing.assert_allclose(step.force, result.force, rtol=1e-8, atol=1e-6)
    np.testing.assert_allclose(step.magnetic_pressure, pull, rtol=1e-9)


def test_a_tilted_shoe_is_pulled_where_it_is_near() -> None:
    contact = shoe().prepare(model="elastic-upper")
    tilted = contact.step(pose=[0.0, 0.0, 3e-3, 0.0, 0.02, 0.0])
    assert tilted.magnetic_pressure is not None
    lower = np.argsort(tilted.gap)
    assert np.all(np.diff(tilted.magnetic_pressure[lower][contact.points[1][lower] > 0.0]) <= 1e-6)
    level = contact.step(pose=[0.0, 0.0, 3e-3, 0.0, 0.0, 0.0])
    assert tilted.report.magnet["attraction"] > level.report.magnet["attraction"]


def test_a_lifted_pole_weakens_the_other_one() -> None:
    """Both poles are in series: what the gap of one takes, the other one lacks."""
    contact = shoe().prepare(model="elastic-upper")
    left = contact.points[1] > 0.0
    # both poles are held: free ones would come down
    on, off = (contact.copy().step(pose=np.zeros(6), gap=np.where(left, lift, 0.0)) for lift in (0.0, 5e-3))
    assert on.magnetic_pressure is not None
    assert off.magnetic_pressure is not None
    assert off.magnetic_pressure[~left].max() < 0.5 * on.magnetic_pressure[~left].min()


def test_steps_take_other_pulls_in_its_place() -> None:
    contact, fixed = (
        shoe().prepare(model="elastic-upper"),
        shoe(magnetic_pressure=2e6).prepare("elastic-upper"),
    )
    for pull in (1e6, lambda x, y: 1e6 + 1e7 * x):
        np.testing.assert_allclose(
            contact.step(magnetic_pressure=pull).force,
            fixed.step(magnetic_pressure=pull).force,
            rtol=1e-9,
            atol=1e-6,
        )
    own, given = contact.copy().step(), fixed.step(magnetic_pressure=MAGNET)
    np.testing.assert_allclose(given.force, own.force, rtol=1e-8, atol=1e-6)
    assert given.report.magnet["attraction"] == pytest.approx(own.report.magnet["attraction"], rel=1e-9)


def test_the_speed_weakens_it() -> None:
    magnet = mtb.Magnet(3e3, 1e-3, speed_factor=mtb.VelocityTable((0.0, 50.0), (1.0, 0.5)))
    plain = mtb.Magnet(3e3, 1e-3)
    slow, fast = (shoe(magnetic_pressure=magnet, velocity=v).solve("half-space") for v in (0.0, 30.0))
    assert fast.normal_force == pytest.approx(0.7 * slow.normal_force, rel=1e-9)
    assert slow.normal_force == pytest.approx(
        shoe(magnetic_pressure=plain).solve("half-space").normal_force, rel=1e-9
    )
    contact = shoe(magnetic_pressure=magnet, velocity=None).prepare("half-space")
    assert contact.step(velocity=30.0).force[2] == pytest.approx(fast.force[2], rel=1e-9)
    with pytest.raises(ValueError, match="velocity is missing"):
        contact.step()
    with pytest.raises(ValueError, match="the table of speed_factor covers 0 to 50 m/s"):
        contact.step(velocity=60.0)


def test_wear_opens_gaps_that_are_pulled_less() -> None:
    """The worn state is that of its own pull, and worn steps of a prepared contact are those of the scene."""
    scene = shoe()
    found, stepped = (mtb.wear(worn, 300.0, 1e-12) for worn in (scene, scene.prepare(model="elastic-both")))
    final = found.final
    assert final is not None
    assert final.magnetic_pressure is not None
    circuit = MAGNET.circuit(final.area, final.patches, None)
    np.testing.assert_allclose(circuit.attract(final.gap, 1.0)[0], final.magnetic_pressure, rtol=1e-9)
    # what is pressed is pulled
    np.testing.assert_allclose(found.forces[:, 2], found.forces[0, 2], rtol=1e-2)
    np.testing.assert_allclose(stepped.depths[0][-1], found.depths[0][-1], rtol=0.02, atol=1e-7)


def test_heat_follows_it() -> None:
    held = shoe().sliding_heat(1.0, steps=3, model="elastic-upper")
    pull = shoe().solve("elastic-upper").magnetic_pressure
    fixed = shoe().with_(magnetic_pressure=pull).sliding_heat(1.0, steps=3, model="elastic-upper")
    np.testing.assert_allclose(held.forces, fixed.forces, rtol=1e-6, atol=1e-3)


def test_case_files_say_the_same(tmp_path: Path) -> None:
    path = tmp_path / "case.toml"
    path.write_text(
        'scene = "pole_shoe_on_rail"\nfriction = 0.3\nspacing = 9e-3\nvelocity = 10.0\n'
        "[magnetic_pressure]\nampere_turns = 3000\nnon_magnetic_gap = 1e-3\niron_share = 1.9\n"
        "pole_length = 30e-3\nyoke = [0.15, 3e-3]\narmature = [60e-3, 3e-3]\nleakage = 1e-7\n"
    )
    case = mtb.load_case(path)
    assert case.scene().magnetic_pressure == MAGNET
    text = path.read_text()
    for change, message in {
        "ampere_turn = 3": "a magnet has no ampere_turn; did you mean ampere_turns",
        'iron = "gold"': "'low-carbon steel' or two rows",
        "branch = 3": "branch",
    }.items():
        path.write_text(text + change + "\n")
        with pytest.raises(mtb.CaseError, match=message):
            mtb.load_case(path)


def test_what_is_saved_and_loaded(tmp_path: Path) -> None:
    result = shoe().solve("half-space")
    result.save(tmp_path)
    loaded = mtb.load(tmp_path)
    np.testing.assert_array_equal(loaded.magnetic_pressure, result.magnetic_pressure)
    assert loaded.report.magnet["flux"] == result.report.magnet["flux"]
    assert pickle.loads(pickle.dumps(shoe())) == shoe()
    step = shoe().prepare(model="elastic-upper").step()
    assert pickle.loads(pickle.dumps(step)) == step


def test_sweeps_take_magnets() -> None:
    table = mtb.sweep(
        shoe(), {"magnetic_pressure": {"weak": mtb.Magnet(1e3, 1e-3), "strong": MAGNET}}, model="half-space"
    )
    weak, strong = table["normal_force"]
    assert 0.0 < weak < strong


def test_what_holds_the_pull_refuses_it() -> None:
    scene = shoe()
    for method in ("incremental", "staggered"):
        with pytest.raises(ValueError, match="the pull of a Magnet follows the gap"):
            scene.solve(method=method)
    contact = scene.prepare(model="elastic-upper")
    for made in (scene.solve("half-space"), contact.step()):
        for by in ("magnetic_pressure", "magnetic_pressure_field"):
            with pytest.raises(ValueError, match="by the numbers of the magnet"):
                made.derivative("force", by)
    for wrong in ([MAGNET, MAGNET], mtb.VelocityTable((0.0, 20.0), (MAGNET, 1e6))):
        with pytest.raises(ValueError, match="A Magnet stands alone"):
            scene.with_(magnetic_pressure=wrong).solve("half-space")
    with pytest.raises(ValueError, match="friction is a Magnet"):
        scene.with_(friction=MAGNET).solve("half-space")


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"ampere_turns": 0.0}, "ampere_turns is 0"),
        ({"non_magnetic_gap": 0.0}, "non_magnetic_gap is 0"),
        ({"iron_share": -1.0}, "iron_share is -1"),
        ({"pole_length": -1.0}, "pole_length is -1"),
        ({"leakage": -1.0}, "leakage is -1"),
        ({"yoke": 0.1}, r"yoke is 0.1: \(length"),
        ({"armature": (0.1, 0.0)}, r"armature\[1\] is 0"),
        ({"iron": "gold"}, "iron is 'gold': 'low-carbon steel' or two rows"),
        ({"iron": (1.0, 2.0)}, "iron has shape"),
        ({"iron": ((1e3, 1e6), (1.5, 1.6))}, "beyond that in vacuum"),
        ({"iron": ((1e3, 1e2), (1.5, 1.6))}, "step of field"),
        ({"iron": ((0, 1, 2), (0, 2, 1))}, r"iron is no curve .* flux density \[T\] by more than in vacuum"),
        ({"speed_factor": 0.5}, "a VelocityTable of numbers"),
        ({"speed_factor": mtb.VelocityTable((0.0, 1.0), (1.0, -1.0))}, "speed_factor at 1 m/s is -1"),
        ({"branch": "both"}, "branch"),
    ],
)
def test_what_is_no_magnet_is_refused(given: dict[str, Any], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        mtb.Magnet(**({"ampere_turns": 1e3, "non_magnetic_gap": 1e-3} | given))
