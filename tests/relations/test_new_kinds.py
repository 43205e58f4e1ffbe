# SPDX-License-Identifier: MIT OR Apache-2.0
"""A friction law, a form of a field or a motion that the package has never seen is one class: all ask it."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
import pytest

import mtb_rs as mtb
from mtb_rs import _mtb_rs
from mtb_rs.friction.fields import Asked, Form
from mtb_rs.friction.laws import Friction
from mtb_rs.half_space.motions import Motion

ROLLING = mtb.Rolling((1e-3, 0.0, 0.0))


@dataclass(frozen=True)
class TwoSpeeds(Friction):
    """A coefficient that falls along a straight line up to a slip speed of 1 m/s."""

    slow: float
    fast: float
    depends_on_speed: ClassVar[bool] = True

    def at_rest(self) -> float:
        return self.slow

    def of_sliding(self, slip_speed: Any, pressure: Any, shape: Any, cut: Any) -> Any:
        return self.slow + (self.fast - self.slow) * np.minimum(slip_speed, 1.0)

    def native(self, shape: Any, cut: Any) -> Any:
        return _mtb_rs.Friction.table(np.array([0.0, 1.0]), np.array([self.slow, self.fast]), None)


def patch() -> mtb.NormalResult:
    return mtb.hertz(1e4, 0.46).on_grid((12, 12), 1e-3)


def test_a_new_law_of_friction_is_asked_by_every_theory() -> None:
    new, known = TwoSpeeds(0.4, 0.3), mtb.TabulatedFriction([0.0, 1.0], [0.4, 0.3])
    pressed = patch()
    for solve in (mtb.solve_tangential, mtb.fastsim):
        motion: Any = ROLLING if solve is mtb.solve_tangential else ROLLING.creepage
        assert np.array_equal(solve(pressed, motion, new).traction, solve(pressed, motion, known).traction)
    assert np.array_equal(mtb.polach(pressed, (0.05, 0, 0), new), mtb.polach(pressed, (0.05, 0, 0), known))
    scene = mtb.scenes.wheel_on_rail(spacing=1e-3)
    steps = [scene.prepare(friction=law).step(velocity=(20.0, 0, 0, 0, 44.0, 0)) for law in (new, known)]
    assert np.array_equal(steps[0].force, steps[1].force)
    # and it may not stay silent about what it does not have
    with pytest.raises(ValueError, match="a coefficient that does not change"):
        mtb.scenes.wheel_on_rail(friction=new, spacing=1e-3).start_of_sliding([[1e-6, 0.0]])


@dataclass(frozen=True)
class Slope(Form):
    """A field that rises along x."""

    middle: float
    rise: float

    def values(self, asked: Asked) -> Any:
        return self.middle + self.rise * asked.points[0]

    def numbers(self) -> Iterator[float]:
        yield self.middle


@pytest.mark.coarse
@pytest.mark.parametrize("name", ["friction", "magnetic_pressure"])
def test_a_new_form_of_a_field_is_asked_by_solves_and_steps(name: Any) -> None:
    middle = {"friction": 0.3, "magnetic_pressure": 2e6}[name]

    def known(x: Any, y: Any) -> Any:
        return middle + middle * x

    shoes = [
        mtb.scenes.pole_shoe_on_rail(spacing=8e-3, **{name: form}) for form in (Slope(middle, middle), known)
    ]
    new, old = (shoe.solve("half-space") for shoe in shoes)
    assert np.array_equal(new.pressure, old.pressure)
    assert np.array_equal(new.traction, old.traction)
    steps = [shoe.prepare("half-space").step(velocity=1.0) for shoe in shoes]
    assert np.array_equal(steps[0].pressure, steps[1].pressure)
    new, old = (shoe.on_cells((9e-3, 9e-3)).solve("half-space") for shoe in shoes)
    assert np.array_equal(new.pressure, old.pressure)


@dataclass(frozen=True)
class Twist(Motion):
    """A rotation about the middle, without any displacement."""

    angle: float
    force: None = None
    slip_unit: ClassVar[str] = "m"
    dissipation_unit: ClassVar[str] = "J/m^2"

    @property
    def rigid(self) -> tuple[float, float, float]:
        return 0.0, 0.0, self.angle

    @property
    def slip_speed(self) -> float:
        return 1.0

    @property
    def kind(self) -> str:
        return "shift"

    def step_on(self, field: mtb.PressureField) -> tuple[float, float]:
        return 0.0, 0.0


def test_a_new_motion_is_solved_and_reported() -> None:
    new = mtb.solve_tangential(patch(), Twist(1e-4), mtb.Coulomb(0.3))  # type: ignore[arg-type]
    old = mtb.solve_tangential(patch(), mtb.Shift(spin=1e-4), mtb.Coulomb(0.3))
    assert new.spin_moment == old.spin_moment != 0.0
    assert np.array_equal(new.traction, old.traction)
    assert new.fields()["slip"].unit == "m"
