# SPDX-License-Identifier: MIT OR Apache-2.0
"""Poles that are pressed, land or are lifted, with motions free: states that solve, and what steps refuse."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import mtb_rs as mtb
from mtb_rs.contact.problem import ContactProblem

nan = float("nan")
#: Above the rail head, where a shoe is hung.
HUNG = (0.0, 0.0, 28.2e-3)

pytestmark = [pytest.mark.coarse, pytest.mark.filterwarnings("ignore:.*deform")]


def shoe(spacing: Any, **given: Any) -> mtb.Scene:
    return mtb.scenes.pole_shoe_on_rail(
        spacing=spacing, **{"friction": 0.3, "magnetic_pressure": 3e6} | given
    )


def check(problem: ContactProblem, pose: Any, step: mtb.StepResult, friction: float) -> None:
    """The conditions of contact, each relative to its own parts."""
    assert step.report.residual < 1e-9
    p, gap = step.state.pressure, np.ravel(step.gap)
    assert problem.averages is not None
    motions = problem.relative_motions
    slid = np.einsum("cn,mcn->mn", problem.direction, motions[:, :2])
    assert p.min() >= 0.0
    assert gap.min() >= 0.0
    assert not (p * gap).any()
    free = [k for k in range(6) if np.isnan(pose[(2, 3, 4)[k % 3]])]
    work = np.concatenate(problem.work)
    for k in free:
        parts = p * problem.area * (motions[k, 2] + friction * slid[k])
        least = 1e-5 * np.abs(problem.area * motions[k, 2]).max() * p.max()
        assert abs(parts.sum() + work[k]) <= 1e-9 * max(np.abs(parts).sum(), abs(work[k]), least), k


def rides() -> dict[str, list[tuple[float, ...]]]:
    """Poses that rock a shoe until one pole is off the rail, hang it above, and let it land aslant."""
    rock = 3e-3 * np.sin(9e-3 * np.concatenate([np.arange(92, 102), np.arange(0, 2000, 190)]))
    drop = 5e-5 - 6e-5 * np.linspace(0.0, 1.0, 12)
    return {
        "rocking": [(0.0, nan, -5e-6, float(roll), nan, nan) for roll in rock],
        "hanging": [(0.0, nan, 2e-5, float(roll), nan, nan) for roll in rock[8:]],
        "landing": [(0.0, nan, float(z), 1e-3, nan, nan) for z in drop],
        "landing level": [(0.0, nan, float(z), nan, nan, nan) for z in drop],
    }


@pytest.mark.parametrize("friction", [0.0, 0.3])
@pytest.mark.parametrize(("model", "spacing"), [("elastic-upper", 6e-3), ("elastic-both", 12e-3)])
def test_a_pole_off_the_rail_is_solved_from_any_start(model: Any, spacing: float, friction: float) -> None:
    scene = shoe(spacing, friction=friction)
    problem = scene.problem(model, may_halve=False)
    contact = scene.prepare(model, reference_point=HUNG)
    for poses in rides().values():
        warm = contact.copy()
        for pose in poses:
            ridden = warm.step(pose=pose, velocity=20.0)
            fresh = contact.copy().step(pose=pose, velocity=20.0)
            check(problem, pose, ridden, friction)
            check(problem, pose, fresh, friction)
            if friction == 0.0:
                # with friction on a free pitch two states may hold
                most = max(float(fresh.state.pressure.max()), 1.0)
                np.testing.assert_allclose(
                    ridden.state.pressure, fresh.state.pressure, rtol=0.0, atol=1e-9 * most
                )


def test_what_a_step_refuses_says_why() -> None:
    contact = shoe(12e-3).prepare("elastic-upper")
    with pytest.raises(ValueError, match=r"pitch of the pose is 1: .* up to 0.5 here"):
        contact.step(pose=(nan, nan, nan, nan, 1.0, nan), velocity=20.0)
    with pytest.raises(ValueError, match="z of the pose is -1: contacts take small displacements"):
        contact.step(pose=(nan, nan, -1.0, nan, nan, nan), velocity=20.0)
    with pytest.raises(ValueError, match=r"^y of the pose is -1: .* up to 0.0164 here"):
        contact.step(pose=(nan, -1.0, nan, nan, nan, nan), velocity=20.0)
    assert contact.step(pose=(100.0, nan, nan, nan, nan, nan), velocity=20.0).force[2] < 0.0  # along the rail
    lifted = contact.step(pose=(nan, nan, 1.0, 0.0, 0.0, nan), velocity=20.0)
    assert not lifted.force.any()
    state = contact.step(velocity=20.0).state
    spoiled = state.pressure.copy()
    spoiled[3] = -1e30
    with pytest.raises(ValueError, match=r"state\[3\] is -1e\+?30, it must not be negative"):
        contact.step(velocity=20.0, state=mtb.StepState(spoiled, state.motion))
