# SPDX-License-Identifier: MIT OR Apache-2.0
"""Derivatives of the steps of a prepared contact, by pose, velocity, pull, gap and friction."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import cached_property, partial

import numpy as np
from numpy.typing import NDArray

from .. import _mtb_rs
from ..contact.tangent import Change, Effect, Points, SlidingTangent, Through
from ..friction.rough_law import RoughLaw
from ..results.derivatives import PULLS, ROUGH, Functional

Array = NDArray[np.float64]
Shape = tuple[int, ...]

#: Why steps of a contact whose bodies stayed behind have no derivatives by moduli.
MATERIALS = {
    f"{side}.{name}": (
        "a prepared contact from a file or a pickle keeps the displacements of its bodies, and not their "
        "materials: prepare it from its scene"
    )
    for side in ("upper", "lower")
    for name in ("young_modulus", "poisson_ratio")
}


#: Why there is no derivative by what was not given by numbers, or by those of a contact from a file.
BY_FIELD = (
    "the numbers that gave it are not known: '{name}_field' is the derivative by its value at each point"
)


class Shared:
    """What the derivatives of all steps of a prepared contact share, made once."""

    def __init__(self, core: _mtb_rs.PreparedContact) -> None:
        self._core = core
        self._felt: dict[tuple[int, ...], bool] = {}

    @cached_property
    def geometry(self) -> _mtb_rs.ContactGeometry:
        return self._core.geometry

    @cached_property
    def frame(self) -> Array:
        """Tangents (2, 3, n)."""
        return self.geometry.tangents

    @cached_property
    def resultants(self) -> Array:
        """Weights (6, 3, n) of the unknowns in force and moment."""
        x, y, z = self._core.reference_point
        return self.geometry.weights_of_resultants((x, y, z))

    def feels_pull(self, balanced: list[int], inputs: Callable[[], list[Array]]) -> bool:
        """Whether a uniform magnetic pressure changes anything while these motions are found from balance."""
        key = tuple(balanced)
        if key not in self._felt:
            self._felt[key] = any(bool(part[8].any()) for part in inputs())
        return self._felt[key]


@dataclass(frozen=True)
class StepDerived:
    """Where the derivatives of a step come from.

    Attributes
    ----------
    shared : Shared
        With all steps of the contact.
    tangent : Tangent
        Of the core: the equations of the step.
    pressure, gap : (n,)
        Unknowns [Pa] and gap [m] of the step.
    traction : (2, n) [Pa]
    velocity : (vx, vy) [m/s]
    by_field : callable or None
        What a magnetic pressure at each of some points changes, of motions; None where there is none.
    pull_slope : (n,) or None [Pa s/m]
        Change with the speed of a magnetic pressure that was given to the step; None where there is none.
    by_layer : (shape, callable) or None
        Shape of the numbers that give a layer, and what they change at a pressure (n,) [Pa]; None where there
        is none, or no such numbers.
    flexible : tuple of str
        Inputs by which each point gives way to its own pressure.
    by_hardness : (shape, callable) or None
        Shape of the numbers that give a hardness, and what they change; None where there are none.
    sheared : callable
        Friction (n,) in full sliding over the stress at which a layer yields, None without one; of the factor
        by which it fades at rest.
    magnet_numbers : Mapping of name to (..., 10), or None
        By each number of a magnet, changes of what the core derives its pull by; None where there is none.
    law : RoughLaw or None
        Of a rough layer.
    by_moduli : Mapping of name to callable
        What a unit of each modulus of a body changes.
    without_moduli : Mapping of name to str, or None
        Moduli by which there are no derivatives, and why; None where the bodies stayed behind.
    """

    shared: Shared
    linear: _mtb_rs.Tangent
    pressure: Array
    gap: Array
    traction: Array
    velocity: tuple[float, float]
    by_field: Callable[[Points, list[int]], Effect] | None
    pull_slope: Array | None
    by_layer: tuple[Shape, Callable[[Array], Change]] | None
    flexible: tuple[str, ...]
    by_hardness: tuple[Shape, Callable[[], Change]] | None
    sheared: Callable[[float], Array | None]
    magnet_numbers: Mapping[str, Array] | None
    law: RoughLaw | None
    by_moduli: Mapping[str, Callable[[], Change]]
    without_moduli: Mapping[str, str] | None

    @cached_property
    def _inputs(self) -> list[Array]:
        """What a unit of each component of pose, velocity and magnetic pressure changes."""
        inputs = self.linear.inputs()
        assert inputs is not None
        return inputs

    @property
    def friction(self) -> Array:
        """Coefficient of friction (n,) [-] at each point."""
        sliding = self.linear.sliding()
        assert sliding is not None
        return np.array(np.broadcast_to(sliding[0][0], self.pressure.shape))

    @property
    def share(self) -> float:
        """What acts of the coefficient that a step is given, at its speed."""
        sliding = self.linear.sliding()
        assert sliding is not None
        return float(sliding[2][0, 0])

    @cached_property
    def tangent(self) -> SlidingTangent:
        """The contact, linearised about the step."""
        geometry, n = self.shared.geometry, self.pressure.size
        sliding = self.linear.sliding()
        assert sliding is not None
        (friction,), direction, ((fade,),) = sliding
        balanced = self.linear.balanced()
        assert balanced is not None
        motions = len(balanced)

        def columns(which: slice) -> Change:
            gap, work, drag, pull = (part[which] for part in self._inputs)
            own = pull if pull.size else None
            return Change(gap=gap, work=work, drag=drag.reshape(-1, 2, n), pull=own)

        named: dict[str, tuple[Shape, Callable[[], Effect]]] = {
            "friction": ((), lambda: Change(drag=fade * direction[None])),
            "pose": ((6,), lambda: columns(slice(0, 6))),
            "work": ((motions,), lambda: Change(work=np.eye(motions))),
        }
        feels_pull = self.shared.feels_pull(balanced, lambda: self._inputs)
        for name, numbers in (self.magnet_numbers or {}).items():
            named[f"magnetic_pressure.{name}"] = (numbers.shape[:-1], partial(self._by_magnet, numbers))
        if self.law is not None:
            for name, opened in self.law.slopes(self.pressure).items():
                named[name] = ((len(opened),), partial(Change, gap=opened))
        is_attracted = self.magnet_numbers is not None
        if feels_pull and not is_attracted:
            named["magnetic_pressure"] = ((), lambda: columns(slice(8, 9)))
        points = Points((n,), None, self.shared.frame, geometry, self.pressure)

        def by_velocity() -> Effect:
            direct = columns(slice(6, 8))
            if self.pull_slope is None or self.by_field is None:
                return direct
            along = np.array(self.velocity) / np.hypot(*self.velocity)
            return Through(direct, self.by_field(points, balanced), along[:, None] * self.pull_slope)

        named["velocity"] = ((2,), by_velocity)
        if self.by_field is not None:
            by_field = self.by_field
            named["magnetic_pressure_field"] = ((n,), lambda: by_field(points, balanced))
        if self.by_layer is not None:
            shape, changed = self.by_layer
            named["normal_layer"] = (shape, lambda: changed(self.pressure))
        if self.by_hardness is not None:
            named["hardness"] = self.by_hardness
        named |= {name: ((), by_modulus) for name, by_modulus in self.by_moduli.items()}
        refused: dict[str, str] = {}
        if is_attracted:
            refused |= dict.fromkeys(("magnetic_pressure", "magnetic_pressure_field"), PULLS)
        elif not feels_pull:
            refused["magnetic_pressure"] = "nothing is pulled: prepare a scene with a magnetic pressure"
        if self.law is not None:
            refused["normal_layer"] = ROUGH
        if self.linear.limit() is not None and self.by_hardness is None:
            refused["hardness"] = BY_FIELD.format(name="hardness")
        if "normal_layer_field" in self.flexible and self.by_layer is None:
            refused["normal_layer"] = BY_FIELD.format(name="normal_layer")
        refused |= MATERIALS if self.without_moduli is None else self.without_moduli
        # what is given fades below the standstill speed, and all that follows from it
        return SlidingTangent(
            self.linear,
            points,
            motions,
            friction,
            fade * direction,
            named,
            self.flexible,
            self.gap,
            lambda: self.sheared(fade),
            self._wedging,
            refused,
            is_attracted=is_attracted,
        )

    @property
    def _along(self) -> Array:
        """Velocity (2, n) [m/s] along both tangents."""
        return np.asarray(np.einsum("kcn,c->kn", self.shared.frame[:, :2], self.velocity))

    @property
    def slope(self) -> Array:
        """Change (n,) [s/m] of the coefficients with the speed at which the faces slide there."""
        _, _, drag, _ = self._inputs
        radial = np.tensordot(self.velocity, drag[6:8].reshape(2, 2, -1), 1)
        along = self._along
        return np.asarray((radial * along).sum(axis=0) / (along**2).sum(axis=0))

    def by_slip(self, slip: Array, velocity: Array, falling: Array) -> Mapping[str, Array]:
        """Changes of all fields as the faces slide otherwise: the friction turns, and changes with the speed.

        Parameters
        ----------
        slip : (k, 2, n) [m/s]
            Of the upper body over the lower one along both tangents.
        velocity : (k, 2) [m/s]
            With which loads change that follow the speed.
        falling : (n,) [s/m]
            Besides `slope`.
        """
        along = self._along
        speed = np.hypot(*along)
        direction = along / speed
        forwards = (slip * direction).sum(axis=1)[:, None] * direction
        drag = self.friction / speed * (slip - forwards) + (self.slope + falling) * forwards
        n, balanced = self.pressure.size, self.linear.balanced()
        assert balanced is not None
        loads = self.tangent.change("velocity").of(velocity, n, len(balanced))
        return self.tangent.following(replace(loads, drag=np.ascontiguousarray(drag.reshape(-1, 2 * n))))

    def _by_magnet(self, numbers: Array) -> Change:
        fields = self.linear.magnet()
        assert fields is not None
        return Change(pull=np.atleast_2d(numbers) @ fields)

    def _wedging(self) -> float | None:
        factor = self.linear.wedging_factor()
        if np.isinf(factor):
            return 0.0
        return 1.0 / factor if factor > 0.0 else math.inf

    def functionals(self, area: Array, pressure: Callable[[], Array]) -> dict[str, Callable[[], Functional]]:
        """Numbers of the step that are sums of its fields, by name; `pressure` gives the mean (n,) [Pa]."""
        attracted: dict[str, Callable[[], Functional]] = {}
        if self.magnet_numbers is not None:
            attracted["attraction"] = lambda: Functional.of_one(magnetic_pressure=area)
        return attracted | {
            "force": lambda: Functional((3,), {"unknowns": self.shared.resultants[:3]}),
            "moment": lambda: Functional((3,), {"unknowns": self.shared.resultants[3:]}),
            "friction_power": self._power,
            **Functional.of_pressure(pressure, area, self.pressure > 0.0),
        }

    def _power(self) -> Functional:
        """Heat of sliding: tractions along the velocity, by which it is derived itself as well."""
        of_friction = self.shared.resultants[:2].copy()
        of_friction[:, 2] = 0.0
        by_velocity = np.array([(part[:2] * self.traction).sum() for part in of_friction])
        weights = np.tensordot(self.velocity, of_friction, 1)
        return Functional((), {"unknowns": weights[None]}, {"velocity": by_velocity[None]})
