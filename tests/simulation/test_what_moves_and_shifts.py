# SPDX-License-Identifier: MIT OR Apache-2.0
"""What moves includes the body; a shift needs a direction; what a file keeps is told."""

from __future__ import annotations

from pathlib import Path
from typing import Any

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


def test_a_contact_from_a_file_says_that_it_keeps_no_velocity(tmp_path: Path) -> None:
    contact = shoe()
    moves: dict[str, Any] = {"mass": [5.0, 5.0], "stiffness": [1e7, 1e7], "free": ("x", "z")}
    known = contact.stability(**moves)
    contact.save(tmp_path / "shoe.mtb", shift=True)
    loaded = mtb.PreparedContact.load(tmp_path / "shoe.mtb")
    with pytest.raises(ValueError, match="a contact from a file keeps none"):
        loaded.stability(**moves)
    again = loaded.stability(**moves, velocity=5.0)
    assert again.eigenvalues == pytest.approx(known.eigenvalues, rel=1e-9)
