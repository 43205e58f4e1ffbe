# SPDX-License-Identifier: MIT OR Apache-2.0
"""Materials that conduct and store heat."""

from __future__ import annotations

import math
from dataclasses import dataclass, fields

from ..base.check import positive
from ..base.plain import plain
from ..base.stored import stored


@stored
@dataclass(frozen=True, slots=True)
@plain
class Conductor:
    """A material that conducts and stores heat, at constant properties.

    Parameters
    ----------
    conductivity : float [W/(m K)]
        Of heat. That of steel falls from 50 at room temperature to 27 at 800 degrees: take the value of the
        temperature expected.
    density : float [kg/m3]
    specific_heat : float [J/(kg K)]

    Examples
    --------
    >>> round(Conductor(50.0, 7850.0, 450.0).effusivity)
    13290
    """

    conductivity: float
    density: float
    specific_heat: float

    def __post_init__(self) -> None:
        units = {"conductivity": "W/(m K)", "density": "kg/m3", "specific_heat": "J/(kg K)"}
        for field in fields(self):
            value = positive(field.name, getattr(self, field.name), units[field.name])
            object.__setattr__(self, field.name, value)

    @property
    def diffusivity(self) -> float:
        """K / (rho c) [m2/s]."""
        return self.conductivity / (self.density * self.specific_heat)

    @property
    def effusivity(self) -> float:
        """sqrt(K rho c) [W s^1/2 / (m2 K)]: in a short time t, a flux q heats the surface by
        2 q sqrt(t / pi) over it."""
        return math.sqrt(self.conductivity * self.density * self.specific_heat)

    @property
    def constants(self) -> tuple[float, float, float]:
        """Conductivity, density and specific heat, as the core takes them."""
        return self.conductivity, self.density, self.specific_heat


#: Rail steel at room temperature, as in [ErtzKnothe2002].
conducting_steel = Conductor(conductivity=50.0, density=7850.0, specific_heat=450.0)


def check_conductors(lower: object, upper: object) -> None:
    """ValueError for a body that is none."""
    for side, body in (("lower", lower), ("upper", upper)):
        if not isinstance(body, Conductor):
            raise ValueError(f"{side} is {body!r}: a Conductor is needed, such as mtb_rs.conducting_steel")
