# SPDX-License-Identifier: MIT OR Apache-2.0
"""Friction that follows the temperature of the surfaces in steady rolling."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .. import _mtb_rs
from ..base.check import pair, positive, reals, shortened
from ..base.owning import owning
from ..base.plain import plain
from ..base.questions import ask
from ..bodies.conductor import Conductor, check_conductors, conducting_steel, of_effusivities
from ..friction.laws import MEMORY_PARAMETERS, Friction, in_a_row, of_friction

Array = NDArray[np.float64]


#: Temperatures of bodies farther than this outside the table of their friction [K] are asked about.
FAR = 200.0


def of_level(temperature: Array, bulk: tuple[float, float]) -> list[str]:
    """A question about bodies that come with temperatures from which no friction of the table is in sight."""
    first, last = float(temperature[0]), float(temperature[-1])
    if first == last or max(first - max(bulk), min(bulk) - last) <= FAR:
        return []
    return [
        f"temperature goes from {first:g} to {last:g} K, and bulk is {bulk[0]:g} and {bulk[1]:g} K, more "
        f"than {FAR:g} K outside: friction hardly leaves the end of its table. Are both counted from one "
        "level? Quantities in degrees Celsius become kelvin from absolute zero: give both a unit, or none"
    ]


@owning
@dataclass(frozen=True)
@plain
class TemperatureFriction(Friction):
    """A coefficient that follows the temperature of the surfaces in steady rolling.

    It is linear between given temperatures and constant beyond the first and the last one. The temperature
    is that of both surfaces in contact, as :meth:`TangentialResult.temperature` finds it for these materials
    from the heat of the same solution. With a memory, the coefficient of a particle follows it by
    ``dmu/dt = -max(s, memory_min_slip) / memory (mu - mu_T)``, with the slip speed s [Vollebregt2012, eq. 4].
    :func:`solve_tangential` and :func:`creep_curve` take this law, and so do scenes that roll steadily and
    steady steps of prepared wheels. A shift and a transient step do not, because the history of their heat is
    not known.

    Parameters
    ----------
    temperature : sequence of float [K]
        Strictly rising, over the level from which `bulk` counts.
    coefficient : sequence of float [-]
    lower, upper : Conductor
        What the bodies are made of.
    bulk : (float, float) [K]
        Temperatures with which the lower and the upper body come, from the level of `temperature`: where one
        of both has a unit such as degrees Celsius, which become kelvin from absolute zero, both need it.
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
        ask(of_level(temperature, self.bulk))

    def at(self, temperature: float | Array) -> Array:
        """Coefficient [-] at temperatures [K] of the surfaces."""
        return np.asarray(np.interp(temperature, self.temperature, self.coefficient))

    def steepest(self) -> tuple[float, float, float]:
        """The steepest fall [-] between two temperatures of the table, and both of these [K]."""
        values, places = np.asarray(self.coefficient, dtype=float), np.asarray(self.temperature, dtype=float)
        k = int(np.argmin(np.diff(values) / np.diff(places)))
        return float(values[k] - values[k + 1]), float(places[k]), float(places[k + 1])

    @property
    def surfaces(self) -> dict[str, Any]:
        """What :meth:`TangentialResult.temperature` takes: ``lower``, ``upper`` and ``bulk`` of the law."""
        return {"lower": self.lower, "upper": self.upper, "bulk": self.bulk}

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
        """The law as the solver takes it."""
        memory = None if self.memory is None else (float(self.memory), float(self.memory_min_slip))
        return _mtb_rs.Friction.of_temperature(
            np.array(self.temperature, dtype=float),
            np.array(self.coefficient, dtype=float),
            (self.lower.constants, self.upper.constants),
            self.bulk,
            memory,
        )

    @property
    def remembers(self) -> bool:
        """Whether the coefficient follows the temperature by a memory."""
        return self.memory is not None

    def followed(self) -> dict[str, Array]:
        """The table, the bulk temperatures and what the bodies are made of, then the memory."""
        points = (len(self.temperature),)
        shapes: dict[str, tuple[int, ...]] = {"friction.coefficient": points, "friction.temperature": points}
        shapes |= {"friction.bulk": (2,), "effusivity": (2,)}
        found = in_a_row(shapes | (MEMORY_PARAMETERS if self.remembers else {}))
        return found | of_effusivities(found.pop("effusivity"), self.lower, self.upper)

    def _refused(self) -> ValueError:
        return ValueError(
            "friction is a TemperatureFriction, which is taken in steady rolling by solve_tangential, "
            "creep_curve and steps of wheels: Coulomb, FallingFriction or TabulatedFriction is needed here"
        )


def of_temperature(friction: Any) -> TemperatureFriction | None:
    """The law, if it follows the temperature."""
    return friction if isinstance(friction, TemperatureFriction) else None
