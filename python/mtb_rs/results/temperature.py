# SPDX-License-Identifier: MIT OR Apache-2.0
"""Surface temperatures in rolling contact."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from .. import _mtb_rs
from ..base.check import pair, warn
from ..base.owning import solved
from ..base.plain import plain
from ..base.questions import ask
from ..base.stored import stored
from ..base.told import Row, in_words
from ..bodies.conductor import Conductor, check_conductors
from .result import Pictured

Array = NDArray[np.float64]

#: Peclet number below which heat flows noticeably along the surface and ahead of the contact.
SLOW = 10.0
#: Creepages from which on the speeds of the surfaces differ noticeably, and one of them may stand.
FAST, LOCKED = 0.2, 1.0


@stored
@solved
@dataclass(frozen=True, repr=False)
@plain
class RollingTemperature(Pictured):
    """Surface temperatures of two bodies in rolling contact, of :meth:`TangentialResult.temperature` and
    :meth:`WheelPatch.temperature`.

    Attributes
    ----------
    points : (2, ny, nx) [m]
        Cell centres.
    area : (ny, nx) [m2]
    pressure : (ny, nx) [Pa]
    status : (ny, nx) int
        0 open, 1 stick, 2 slip, 3 plastic.
    temperature_lower, temperature_upper : (ny, nx) [K]
        Of the surfaces, above the level from which the bulk temperatures count. Both are the same in contact.
    heat_flux_lower, heat_flux_upper : (ny, nx) [W/m2]
        Heat that enters each body; their sum is the power of friction.
    peclet : float
        Peclet number V a / (2 kappa) of the contact, with half of its length a: far above one, heat flows
        into the depth alone.
    """

    points: Array
    area: Array
    pressure: Array
    status: NDArray[np.int8]
    temperature_lower: Array
    temperature_upper: Array
    heat_flux_lower: Array
    heat_flux_upper: Array
    peclet: float
    _first_drawn: ClassVar[str] = "temperature_lower"
    _drawn: ClassVar[tuple[str, ...]] = (
        "points", "area", "pressure", "temperature_lower", "temperature_upper", "heat_flux_lower",
        "heat_flux_upper", "status",
    )  # fmt: skip
    _summed: ClassVar[tuple[str, ...]] = ("heat_lower", "heat_upper", "friction_power")

    @property
    def heat_lower(self) -> float:
        """Heat that enters the lower body [W]."""
        return float((self.heat_flux_lower * self.area).sum())

    @property
    def heat_upper(self) -> float:
        """Heat that enters the upper body [W]."""
        return float((self.heat_flux_upper * self.area).sum())

    @property
    def friction_power(self) -> float:
        """Heat of friction [W]."""
        return self.heat_lower + self.heat_upper

    @property
    def peak(self) -> float:
        """Highest temperature of a surface in contact [K]."""
        touching = self.status > 0
        return float(max(t[touching].max() for t in (self.temperature_lower, self.temperature_upper)))

    def told(self) -> list[Row]:
        """The highest temperature, and where the heat goes: what a notebook and the command line show."""
        rows = [("highest temperature in contact", in_words(self.peak, "K"))]
        return [*rows, *super().told(), ("Peclet number", f"{self.peclet:.4g}")]

    def __repr__(self) -> str:
        ny, nx = self.pressure.shape
        return f"{type(self).__name__}({nx} x {ny} cells, highest {self.peak:.4g} K)"


def peclet_number(half: float, speed: float, bodies: tuple[Conductor, Conductor]) -> float:
    """V a / (2 kappa) [-] of a `half` length [m] at a `speed` [m/s], in the body that conducts better."""
    return speed * half / (2.0 * max(body.diffusivity for body in bodies))


def flows_along(half: float, speed: float, bodies: tuple[Conductor, Conductor]) -> list[str]:
    """What is left out where heat flows along the surface as well, in a sentence."""
    peclet = peclet_number(half, speed, bodies)
    if peclet >= SLOW:
        return []
    return [
        f"The Peclet number of this contact is {peclet:.3g}. Below {SLOW:g} heat also flows along the "
        "surface, which is left out here: the temperatures are too high"
    ]


def rolling_temperature(
    points: Array,
    area: Array,
    pressure: Array,
    status: NDArray[np.int8],
    spacing: tuple[float, float],
    power: Array,
    angle: float,
    speed: float,
    bodies: tuple[Conductor, Conductor],
    bulk: tuple[float, float],
    creepage: Array,
) -> RollingTemperature:
    """Temperatures of lower and upper body on cells of a `spacing` [m], at `speed` [m/s] and a creepage (2,),
    from the heat of friction `power` (ny, nx) [W/m2]."""
    creeps = float(np.hypot(*creepage))
    if creeps >= LOCKED:
        raise ValueError(
            f"the creepage is {creeps:.3g}: one of the surfaces stands still or runs backwards, and "
            "temperature() needs both to pass through the contact at about the same speed"
        )
    if creeps > FAST:
        warn(
            f"The creepage is {creeps:.3g}, so the speeds of both surfaces differ by as much, and "
            "temperature() takes the mean of them for both."
        )
    check_conductors(*bodies)
    bulk = pair("bulk", bulk, "K")
    touches = status > 0
    dx, dy = spacing
    # along the rolling direction
    along = (points[0] * np.cos(angle) + points[1] * np.sin(angle))[touches]
    half = 0.5 * (float(np.ptp(along)) + dx * abs(np.cos(angle)) + dy * abs(np.sin(angle)))
    ask(f"{left_out}." for left_out in flows_along(half, speed, bodies))
    surface, flux = _mtb_rs.rolling_temperatures(
        np.ascontiguousarray(power),
        np.ascontiguousarray(touches),
        (dx, dy),
        float(angle),
        float(speed),
        (bodies[0].constants, bodies[1].constants),
        bulk,
    )
    return RollingTemperature(
        points,
        area,
        pressure,
        status,
        surface[0],
        surface[1],
        flux[0],
        flux[1],
        peclet_number(half, speed, bodies),
    )
