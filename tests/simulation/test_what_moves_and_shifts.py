# SPDX-License-Identifier: MIT OR Apache-2.0
"""What moves includes the body; a shift needs a direction; what a file keeps is told."""

from __future__ import annotations

import copy
import pickle
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import mtb_rs as mtb


def shoe(**given: Any) -> mtb.PreparedContact:
    stated = {"friction": 0.3, "spacing": 12e-3, "velocity": 5.0} | given
    return mtb.scenes.pole_shoe_on_rail(**stated).prepare("elastic-upper")


@pytest.mark.parametrize("modes", [3, 12])
def test_a_mass_below_that_of_the_body_is_refused(modes: int) -> None:
    contact = shoe()
    least = contact.reduced(density=7850.0, modes=modes).mass
    moves: dict[str, Any] = {"stiffness": [1e7, 1e7], "free": ("x", "z"), "density": 7850.0, "modes": modes}
    for mass, which in (([0.99 * least, 5.0], "x"), ([5.0, 0.5 * least], "z")):
        with pytest.raises(ValueError, match=rf"mass along {which} is .* kg, and the body alone has"):
            contact.stability(mass=mass, **moves)
        with pytest.raises(ValueError, match="the body included"):
            contact.vibrating(1e-6, mass=mass, **moves)
    assert contact.stability(mass=[1.01 * least, 1.01 * least], **moves).eigenvalues.size


def test_a_shift_without_a_direction_is_refused_where_there_is_friction() -> None:
    with pytest.raises(ValueError, match="sliding_direction=None, without friction"):
        shoe(sliding_direction=None).step(shift=(1e-5, 0.0))
    assert shoe(sliding_direction=None, friction=0.0).step(shift=(1e-5, 0.0)).force[0] == 0.0


@pytest.mark.parametrize("velocity", [0.1, 20.0, None])
def test_files_pickles_and_copies_keep_the_velocity_of_their_scene(
    velocity: float | None, tmp_path: Path
) -> None:
    scene = mtb.scenes.pole_shoe_on_rail(friction=0.3, spacing=12e-3, velocity=velocity)
    contact = scene.prepare("elastic-upper", standstill_speed=0.2)
    moves: dict[str, Any] = {"mass": [5.0, 5.0], "stiffness": [1e7, 1e7], "free": ("x", "z")}
    contact.save(tmp_path / "shoe.mtb", shift=True)
    others = {
        "file": mtb.PreparedContact.load(tmp_path / "shoe.mtb"),
        "pickle": pickle.loads(pickle.dumps(contact)),
        "deep copy": copy.deepcopy(contact),
        "copy": contact.copy(),
    }
    expected = contact.step(dt=1e-3)
    speed = 1.0 if velocity is None else abs(velocity)
    assert expected.friction_power == pytest.approx(speed * abs(expected.force[0]), rel=1e-3)
    for name, other in others.items():
        found = other.step(dt=1e-3)
        assert np.array_equal(found.force, expected.force), name
        assert found.friction_power == expected.friction_power, name
        if velocity is None:
            with pytest.raises(ValueError, match="the scene states none"):
                other.stability(**moves)
            with pytest.raises(ValueError, match="a WearMap needs the slip velocity"):
                mtb.wear(other, 1.0, mtb.WearMap.of_wheel_steel(3e9))
        else:
            again = other.stability(**moves)
            assert again.eigenvalues == pytest.approx(contact.stability(**moves).eigenvalues, rel=1e-9)


@pytest.mark.parametrize("spacing", [12e-3, 6e-3])
def test_displacements_across_curved_faces_close_gaps_as_poses_do(spacing: float) -> None:
    """Under hats a motion goes by the mean normal: those at the nodes gave less than half of the force."""
    scene = mtb.scenes.pole_shoe_on_rail(spacing=spacing, friction=0.2, magnetic_pressure=2e6)
    for way in ([1e-7, 0.0], [0.0, 1e-7], [-0.5e-7, -1e-7]):
        contact = scene.prepare("elastic-upper")
        contact.step(pose=(0, 0, np.nan, np.nan, np.nan, 0), shift=0.0)
        posed = contact.step(pose=(*way, np.nan, np.nan, np.nan, 0), shift=0.0)
        started = scene.start_of_sliding([way], "elastic-upper")
        assert started.force[0] == pytest.approx(posed.force[:2], rel=1e-2, abs=1e-2)
