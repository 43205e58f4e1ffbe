# SPDX-License-Identifier: MIT OR Apache-2.0
"""Friction of the right wheel alone: like friction, mirrors, each by itself, derivatives, files."""

from __future__ import annotations

import pickle
import warnings
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import mtb_rs as mtb
from mtb_rs.case import case_from_words

pytestmark = [
    pytest.mark.coarse,
    pytest.mark.filterwarnings("ignore:the peak pressure is"),
    pytest.mark.filterwarnings("ignore:on the flange"),
    pytest.mark.filterwarnings("ignore:StaticKinetic depends on the grid"),
]

NAN, V = np.nan, 20.0
with warnings.catch_warnings():
    warnings.simplefilter("ignore")
    STATIC = mtb.StaticKinetic(0.45, 0.3)
#: One of each kind, and whether it has transient steps.
LAWS: dict[str, tuple[Any, bool]] = {
    "coulomb": (mtb.Coulomb(0.4), True),
    "static": (STATIC, True),
    "falling": (mtb.FallingFriction(0.4, 0.2, 0.5, memory=1e-3), True),
    "tabulated": (mtb.TabulatedFriction([0.0, 0.5, 2.0], [0.3, 0.2, 0.1]), True),
    "rail": (mtb.RailFriction([-8e-3, 8e-3], [0.15, 0.45]), True),
    "temperature": (mtb.TemperatureFriction([0.0, 300.0], [0.5, 0.1]), False),
}
GREASED = mtb.Coulomb(0.1)
POSE = np.array([0, 1e-3, NAN, NAN, 0, 3e-3])
MIRROR = np.array([1.0, -1.0, 1.0, -1.0, 1.0, -1.0])


def scene(**changes: Any) -> Any:
    return mtb.scenes.wheel_on_rail(**{"lateral": 0.0, "force": 60e3, "spacing": 1.5e-3} | changes)


def prepared(left: Any, right: Any = None, side: Any = "both", **more: Any) -> mtb.PreparedWheels:
    contact: mtb.PreparedWheels = scene().prepare(side=side, friction=left, right_friction=right, **more)
    return contact


def two_steps(contact: mtb.PreparedWheels, pose: Any, transient: bool) -> list[mtb.WheelStep]:
    """A steady one, then one that rolls on by a cell and a third."""
    steps = [contact.step(pose, V)]
    if transient:
        steps.append(contact.step(pose, V, 1e-4, transient=True))
    return steps


@pytest.mark.parametrize("kind", LAWS)
def test_what_is_told_to_be_alike_is(kind: str) -> None:
    law, transient = LAWS[kind]
    for alike, told in zip(
        two_steps(prepared(law), POSE, transient),
        two_steps(prepared(law, law), POSE, transient),
        strict=True,
    ):
        assert np.array_equal(alike.force, told.force)
    # where there is no left wheel, its friction has no meaning
    right, other = prepared(law, side="right"), prepared(GREASED, law, side="right")
    assert np.array_equal(right.step(None, V).force, other.step(None, V).force)


@pytest.mark.parametrize("kind", LAWS)
def test_the_mirror_image_has_friction_changed_over(kind: str) -> None:
    law, transient = LAWS[kind]
    own = two_steps(prepared(GREASED, law), POSE, transient)
    image = two_steps(prepared(law, GREASED), MIRROR * POSE, transient)
    for left, right in zip(own, image, strict=True):
        assert right.force == pytest.approx(MIRROR[:3] * left.force, abs=2e-3)
        assert right.friction_power == pytest.approx(left.friction_power, rel=1e-6)
    if transient:
        with pytest.raises(AssertionError):
            # it does matter
            assert own[0].force == pytest.approx(prepared(law).step(POSE, V).force, rel=1e-2)


@pytest.mark.parametrize("kind", LAWS)
def test_each_wheel_has_its_own(kind: str) -> None:
    law, transient = LAWS[kind]
    steps = two_steps(prepared(GREASED, law, reference_point=(0, 0, 0.46)), POSE, transient)
    for side, friction in (("left", GREASED), ("right", law)):
        alone = prepared(friction, side=side, reference_point=(0, 0, 0.46))
        for number, step in enumerate(steps):
            rolled = number > 0
            one = alone.step(step.pose, step.velocity, 1e-4 if rolled else None, transient=rolled)
            (patch,) = (patch for patch in step.patches if patch.side == side)
            assert one.patches[0].force == pytest.approx(patch.force, abs=2e-3)
            assert one.patches[0].friction_power == pytest.approx(patch.friction_power, rel=1e-6)


@pytest.mark.parametrize("kind", LAWS)
def test_derivatives_are_differences(kind: str) -> None:
    law, transient = LAWS[kind]
    exact = (1e-13, 1e-11, 1e-10)

    def stepped(left: Any, right: Any, state: Any = None) -> mtb.WheelStep:
        contact = mtb.PreparedWheels(prepared(left, right)._core.to_accuracy(*exact))
        first = contact.step(POSE, V, state=state)
        return contact.step(POSE, V, 1e-4, transient=True) if transient else first

    step = stepped(GREASED, law)
    inputs = [name for name in vars(step)["_derived"].inputs if "friction" in name]
    assert "friction" in inputs
    (derived,) = (name for name in inputs if name in RIGHT[kind])
    make, value = RIGHT[kind][derived]
    # the last step alone changes: the state before is that of the same friction
    width = 1e-5 * value
    changes = [
        ("friction", lambda s: (mtb.Coulomb(0.1 + 1e-6 * s), law), 1e-6),
        (derived, lambda s: (GREASED, make(value + width * s)), width),
    ]
    for name, laws, size in changes:
        wanted = np.zeros(3)
        for s in (-1.0, 1.0):
            contact = mtb.PreparedWheels(prepared(GREASED, law)._core.to_accuracy(*exact))
            first = contact.step(POSE, V)
            changed = mtb.PreparedWheels(prepared(*laws(s))._core.to_accuracy(*exact))
            if transient:
                found = changed.step(POSE, V, 1e-4, transient=True, state=first.state)
            else:
                found = changed.step(POSE, V, state=first.state)
            wanted += s * found.force / (2.0 * size)
        by = np.asarray(step.derivative("force", name)).reshape(3, -1)[:, 0]
        assert by == pytest.approx(wanted, rel=2e-4, abs=2e-4 * np.abs(wanted).max())


#: A number of each law by its name, how the law is made with another one, and its value.
RIGHT: dict[str, dict[str, tuple[Any, float]]] = {
    "coulomb": {"right_friction": (mtb.Coulomb, 0.4)},
    "static": {"right_friction.kinetic": (lambda mu: mtb.StaticKinetic(0.45, mu), 0.3)},
    "falling": {"right_friction.static": (lambda mu: mtb.FallingFriction(mu, 0.2, 0.5, memory=1e-3), 0.4)},
    "tabulated": {
        "right_friction.coefficient": (lambda mu: mtb.TabulatedFriction([0.0, 0.5, 2.0], [mu, 0.2, 0.1]), 0.3)
    },
    "rail": {"right_friction": (lambda mu: mtb.RailFriction([-8e-3, 8e-3], [mu, 0.45]), 0.15)},
    "temperature": {
        "right_friction.coefficient": (lambda mu: mtb.TemperatureFriction([0.0, 300.0], [mu, 0.1]), 0.5)
    },
}


def test_files_pickles_sweeps_and_cases_have_it(tmp_path: Path) -> None:
    for law, _ in LAWS.values():
        contact = prepared(GREASED, law)
        force = contact.copy().step(POSE, V).force
        contact.save(tmp_path / "wheels.mtbw")
        assert np.array_equal(mtb.PreparedWheels.load(tmp_path / "wheels.mtbw").step(POSE, V).force, force)
        assert np.array_equal(pickle.loads(pickle.dumps(contact)).step(POSE, V).force, force)
    words: dict[str, Any] = {"velocity": V, "side": "both", "y": 1e-3, "yaw": 3e-3}
    given = {"scene": "wheel_on_rail", "lateral": 0.0, "force": 60e3, "spacing": 1.5e-3, "friction": 0.1}
    over = {"temperature": [0.0, 300.0], "coefficient": [0.5, 0.1]}
    for right, law in ((0.4, mtb.Coulomb(0.4)), (over, LAWS["temperature"][0])):
        case = case_from_words(given | {"step_wheels": words | {"right_friction": right}})
        found = case.solve()
        assert isinstance(found, mtb.WheelStep)
        assert np.array_equal(found.force, prepared(GREASED, law).step(POSE, V).force)
    called = mtb.step_wheels(
        scene(friction=0.1), V, side="both", y=1e-3, yaw=3e-3, right_friction=mtb.Coulomb(0.4)
    )
    assert np.array_equal(called.force, prepared(GREASED, mtb.Coulomb(0.4)).step(POSE, V).force)


def test_what_is_no_friction_of_a_right_wheel_is_named() -> None:
    for given, words in (
        ({"right_friction": 0.3}, 'right_friction is Coulomb.*side is "left"'),
        ({"right_friction": "wet", "side": "both"}, "right_friction is 'wet'"),
        ({"right_friction": -0.1, "side": "both"}, "-0.1"),
        ({"right_friction": mtb.Coulomb([[0.1, 0.2]]), "side": "both"}, "friction varies over the patch"),
    ):
        with pytest.raises(ValueError, match=words):
            scene().prepare(**given)
    temperature, _ = LAWS["temperature"]
    hot = prepared(GREASED, temperature)
    hot.step(POSE, V)
    with pytest.raises(ValueError, match="temperature"):
        hot.step(POSE, V, 1e-4, transient=True)
    along = mtb.RailFriction([0.0], [[0.2], [0.3]], x=[0.0, 1.0])
    with pytest.raises(ValueError, match="friction varies along the track"):
        scene(roller_radius=0.5).prepare(side="both", right_friction=along)
    with pytest.raises(ValueError, match="right_friction is for wheels on rails"):
        mtb.scenes.block_on_plane().prepare(right_friction=0.2)
