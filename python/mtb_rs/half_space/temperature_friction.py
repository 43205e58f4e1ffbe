# SPDX-License-Identifier: MIT OR Apache-2.0
"""Friction that follows the temperature of the surfaces in steady rolling."""

from __future__ import annotations

import itertools
import warnings
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from .. import _mtb_rs
from ..base.check import pair, positive, reals, shortened
from ..base.owning import owning
from ..base.plain import plain
from ..base.questions import ask
from ..bodies.conductor import Conductor, check_conductors, conducting_steel
from ..friction.laws import Friction, of_friction
from ..geometry.contact_points import window
from ..results.temperature import rolling_temperature
from .motions import Motion
from .pressure_field import PressureField

Array = NDArray[np.float64]

#: Rounds of a solution at given coefficients and the coefficients by its temperatures.
_ROUNDS = 60
#: Rounds out of which the next coefficients are combined.
_DEPTH = 5
#: Change of the coefficients, over the largest, at which the rounds end: over the tolerance, and at least.
_SETTLED_OVER_TOLERANCE, _SETTLED = 10.0, 1e-9


@owning
@dataclass(frozen=True)
@plain
class TemperatureFriction(Friction):
    """A coefficient that follows the temperature of the surfaces in steady rolling.

    It is linear between given temperatures and constant beyond the first and the last one. The temperature
    is that of both surfaces in contact, as :meth:`TangentialResult.temperature` finds it for these materials
    from the heat of the same solution. With a memory, the coefficient of a particle follows it by
    ``dmu/dt = -max(s, memory_min_slip) / memory (mu - mu_T)``, with the slip speed s [Vollebregt2012, eq. 4].
    :func:`solve_tangential` and :func:`creep_curve` take this law, and so do scenes that roll steadily. A
    shift and a transient step do not, because the history of their heat is not known.

    Parameters
    ----------
    temperature : sequence of float [K]
        Strictly rising, over the level from which `bulk` counts.
    coefficient : sequence of float [-]
    lower, upper : Conductor
        What the bodies are made of.
    bulk : (float, float) [K]
        Temperatures with which the lower and the upper body come.
    memory : float [m] or None
        Slip distance over which the coefficient adapts; None: at once.
    memory_min_slip : float [m/s]
        Slip speed with which the coefficient still adapts where the surfaces stick.

    Examples
    --------
    A coefficient of 0.33 that falls to 0.14 at 400 K above the bulk:

    >>> law = TemperatureFriction([0.0, 400.0], [0.33, 0.14])
    >>> round(float(law.at(200.0)), 3)
    0.235
    """

    temperature: Sequence[float]
    coefficient: Sequence[float]
    lower: Conductor = conducting_steel
    upper: Conductor = conducting_steel
    bulk: tuple[float, float] = (0.0, 0.0)
    memory: float | None = None
    memory_min_slip: float = 1e-3

    def __post_init__(self) -> None:
        temperature = reals("temperature", self.temperature, "K")
        values = reals("coefficient", self.coefficient)
        if temperature.ndim != 1 or temperature.size < 1 or np.any(np.diff(temperature) <= 0.0):
            raise ValueError(
                f"temperature is {shortened(self.temperature)}: a list of strictly rising numbers is needed"
            )
        if values.shape != temperature.shape:
            raise ValueError(f"coefficient has {values.size} entries, temperature has {temperature.size}")
        if np.any(values < 0.0):
            at = int(np.argmin(values))
            raise ValueError(f"coefficient[{at}] is {values[at]:g}: numbers of at least 0 are needed")
        check_conductors(self.lower, self.upper)
        object.__setattr__(self, "bulk", pair("bulk", self.bulk, "K"))
        if self.memory is not None:
            positive("memory", self.memory, "m")
        positive("memory_min_slip", self.memory_min_slip, "m/s")
        ask(of_friction("coefficient", float(values.max())))

    def at(self, temperature: float | Array) -> Array:
        """Coefficient [-] at temperatures [K] of the surfaces."""
        return np.asarray(np.interp(temperature, self.temperature, self.coefficient))

    def at_rest(self) -> float:
        """Coefficient [-] where the surfaces meet, before friction has heated them."""
        weights = [self.lower.effusivity, self.upper.effusivity]
        return float(self.at(np.average(self.bulk, weights=weights)))

    def of_sliding(
        self, slip_speed: Array, pressure: Array, shape: tuple[int, int], cut: tuple[slice, slice]
    ) -> Array:
        """ValueError: the heat of a contact follows from its fields."""
        raise self._refused()

    def native(self, shape: tuple[int, int], cut: tuple[slice, slice]) -> _mtb_rs.Friction:
        """ValueError: the coefficients follow from the solution."""
        raise self._refused()

    def _refused(self) -> ValueError:
        return ValueError(
            "friction is a TemperatureFriction, which is taken in steady rolling by solve_tangential and "
            "creep_curve: Coulomb, FallingFriction or TabulatedFriction is needed here"
        )


def of_temperature(friction: Any) -> TemperatureFriction | None:
    """The law, if it follows the temperature."""
    return friction if isinstance(friction, TemperatureFriction) else None


class Followed(NamedTuple):
    """What solved a problem whose friction follows the temperature."""

    outcome: _mtb_rs.TangentialOutcome
    #: Solutions that it took, and their convolutions and preconditionings.
    rounds: int
    products: float
    preconditionings: float
    #: Last change of the coefficients over the largest.
    change: float
    converged: bool


def follow_temperature(
    friction: TemperatureFriction,
    field: PressureField,
    motion: Motion,
    operators: _mtb_rs.PatchOperators,
    cut: tuple[slice, slice],
    tolerance: float,
    solve: Callable[[_mtb_rs.Friction, Array | None], _mtb_rs.TangentialOutcome],
) -> Followed:
    """Solutions at given coefficients, and coefficients by their temperatures, in turn until these stay.

    Heat goes downstream only, and little of it comes from each cell. The next coefficients are those of the
    last rounds, combined such that the changes, taken as linear, vanish (Anderson's acceleration).
    """
    pressure = window(field.pressure, cut)
    touches = pressure > 0.0
    settled = max(_SETTLED_OVER_TOLERANCE * tolerance, _SETTLED)
    coefficient = np.full(pressure.shape, friction.at_rest())
    tried: list[Array] = []
    changes: list[Array] = []
    start = None
    products = preconditionings = 0.0
    while True:
        outcome = solve(_mtb_rs.Friction.coulomb(coefficient.ravel()), start)
        products += outcome.products
        preconditionings += outcome.preconditionings
        wanted = _wanted(friction, field, motion, operators, cut, outcome)
        tried.append(coefficient[touches])
        changes.append(wanted[touches] - coefficient[touches])
        change = float(np.abs(changes[-1]).max() / max(wanted[touches].max(), 1e-300))
        if change <= settled or not outcome.converged or len(tried) >= _ROUNDS:
            converged = outcome.converged and change <= settled
            return Followed(outcome, len(tried), products, preconditionings, change, converged)
        coefficient = np.full(pressure.shape, friction.at_rest())
        coefficient[touches] = _combined(tried[-_DEPTH:], changes[-_DEPTH:])
        start = outcome.traction


def _wanted(
    friction: TemperatureFriction,
    field: PressureField,
    motion: Motion,
    operators: _mtb_rs.PatchOperators,
    cut: tuple[slice, slice],
    outcome: _mtb_rs.TangentialOutcome,
) -> Array:
    """Coefficients on the rectangle `cut` by the temperatures of a solution."""
    shape, speed = field.pressure.shape, motion.slip_speed
    points = np.stack(np.meshgrid(*field.coordinates()))
    area = np.full(shape, field.spacing[0] * field.spacing[1])
    status = (field.pressure > 0.0).astype(np.int8)
    power = np.asarray(outcome.dissipation) * speed
    with warnings.catch_warnings():
        # whoever asks the result for its temperature is warned
        warnings.simplefilter("ignore")
        heated = rolling_temperature(
            points,
            area,
            field.pressure,
            status,
            power,
            motion.direction,
            speed,
            (friction.lower, friction.upper),
            friction.bulk,
            np.asarray(outcome.drive),
        )
    steady = friction.at(window(heated.temperature_lower, cut))
    if friction.memory is None:
        return steady
    slips = np.asarray(outcome.status) >= 2
    slip_speed = np.where(slips, np.hypot(*outcome.slip[:2]), 0.0) * speed
    memory = (float(friction.memory), float(friction.memory_min_slip))
    pressure = window(field.pressure, cut)
    return operators.remembered(pressure, speed, steady, slip_speed, friction.at_rest(), memory)


def _combined(tried: list[Array], changes: list[Array]) -> Array:
    """The next coefficients, none negative."""
    ahead = tried[-1] + changes[-1]
    if len(tried) > 1:
        differences = np.stack([b - a for a, b in itertools.pairwise(changes)], axis=1)
        steps = np.stack([b - a for a, b in itertools.pairwise(tried)], axis=1)
        shares = np.linalg.lstsq(differences, changes[-1], rcond=1e-10)[0]
        ahead = ahead - (steps + differences) @ shares
    return np.maximum(ahead, 0.0)
