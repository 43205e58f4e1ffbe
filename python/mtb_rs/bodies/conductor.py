# SPDX-License-Identifier: MIT OR Apache-2.0
"""Materials that conduct and store heat."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..base.check import number, positive
from ..base.plain import plain
from ..base.stored import stored

Array = NDArray[np.float64]


@stored
@dataclass(frozen=True, slots=True)
@plain
class Conductor:
    """A material that conducts and stores heat, and expands by it.

    Parameters
    ----------
    conductivity : float [W/(m K)]
        Of heat.
    density : float [kg/m3]
    specific_heat : float [J/(kg K)]
    expansion : float [1/K]
        Coefficient of linear expansion, not negative; only where it is asked for does it move surfaces.
    conductivity_slope : float [W/(m K^2)]
        Change of the conductivity with the temperature, counted from the level of the bulk temperatures. That
        of steel falls from 50 at room temperature to 27 at 800 degrees: by about -0.03. In sliding it is
        taken at the mean temperature of each body before each step; in rolling it is left out.
    expansion_slope : float [1/K^2]
        Change of the coefficient of expansion, from the same level: ``(expansion + slope T) T`` is the
        strain. A step is linear about the mean temperature of the body before it.

    Examples
    --------
    >>> round(Conductor(50.0, 7850.0, 450.0).effusivity)
    13290
    """

    conductivity: float
    density: float
    specific_heat: float
    expansion: float = 0.0
    conductivity_slope: float = 0.0
    expansion_slope: float = 0.0

    def __post_init__(self) -> None:
        units = {"conductivity": "W/(m K)", "density": "kg/m3", "specific_heat": "J/(kg K)"}
        for name, unit in units.items():
            object.__setattr__(self, name, positive(name, getattr(self, name), unit))
        slopes = {"expansion": "1/K", "conductivity_slope": "W/(m K2)", "expansion_slope": "1/K2"}
        for name, unit in slopes.items():
            object.__setattr__(self, name, number(name, getattr(self, name), unit))
        if self.expansion < 0.0:
            raise ValueError(
                f"expansion is {self.expansion:g} 1/K: at least 0 is needed, such as 12e-6 for steel"
            )

    @property
    def expands(self) -> bool:
        """Whether it has a coefficient of expansion."""
        return bool(self.expansion or self.expansion_slope)

    def strain(self, temperature: Any) -> Any:
        """Strain [-] of free expansion at temperatures [K]."""
        return (self.expansion + self.expansion_slope * temperature) * temperature

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
conducting_steel = Conductor(conductivity=50.0, density=7850.0, specific_heat=450.0, expansion=12e-6)


def check_conductors(lower: object, upper: object) -> None:
    """ValueError for a body that is none."""
    for side, body in (("lower", lower), ("upper", upper)):
        if not isinstance(body, Conductor):
            raise ValueError(f"{side} is {body!r}: a Conductor is needed, such as mtb_rs.conducting_steel")


def of_effusivities(
    slopes: Array, lower: Conductor, upper: Conductor, law: str = "friction"
) -> dict[str, Array]:
    """Slopes (m,) of m numbers by what two bodies are made of, as ``"friction.lower.density"`` of that law,
    from those (m, 2) by their effusivities, the roots of the products of all three."""
    found = {}
    for k, (side, body) in enumerate((("lower", lower), ("upper", upper))):
        for name in ("conductivity", "density", "specific_heat"):
            share = 0.5 * body.effusivity / getattr(body, name)
            found[f"{law}.{side}.{name}"] = np.asarray(share * slopes[:, k])
    return found
