# SPDX-License-Identifier: MIT OR Apache-2.0
"""Laws of wear: how much material sliding takes off, over pressure, speed and friction."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..base.check import number, positive, reals, shortened
from ..base.owning import owning
from ..base.plain import plain, short

Array = NDArray[np.float64]


@dataclass(frozen=True)
@plain
class Rubbing:
    """What rubs at the contact points, as a law of wear is asked about it.

    Attributes
    ----------
    pressure : (n,) [Pa]
        May be zero; the coefficient is then that of a pressure that begins.
    friction : (n,) [-]
        Friction coefficient.
    slip : (n,) [-]
        Distance slid over the distance that the law counts: 1 in sliding, the relative slip in rolling.
    speed : float or (n,) or None [m/s]
        Slip velocity; None: not known.
    points : (3, n) or (2, n) [m]
    """

    pressure: Array
    friction: Array
    slip: Array
    speed: float | Array | None
    points: Array


class WearLaw(ABC):
    """How much a body wears: its wear coefficient, by what rubs."""

    @abstractmethod
    def coefficient(self, rubbing: Rubbing) -> Array:
        """Depth worn off over distance slid and pressure (n,) [1/Pa], >= 0."""


def coefficients_of(law: WearLaw, rubbing: Rubbing) -> Array:
    """Coefficients (n,) [1/Pa] that a law gives; ValueError, naming it, for ones that are none."""
    found = law.coefficient(rubbing)
    bad = ~((found >= 0.0) & np.isfinite(found))
    if bad.any():
        k = int(np.argmax(bad))
        raise ValueError(
            f"the law of wear {shortened(law)} gives {found[k]:g} 1/Pa at point {k}, under "
            f"{rubbing.pressure[k]:g} Pa: finite wear coefficients of at least 0 are needed"
        )
    return found


def check_worn(law: WearLaw, depth: Array, height: float, of_what: str, distance: float) -> None:
    """ValueError where a body is worn by more than its height [m]: then no body is left."""
    deepest = float(depth.max(initial=0.0))
    if deepest <= height:
        return
    raise ValueError(
        f"after {distance:.4g} m of sliding {deepest:.4g} m are worn off, more than {of_what} of "
        f"{height:.4g} m, by the law {shortened(law)}: wear coefficients are in 1/Pa, and those of dry steel "
        "are about 1e-15 to 1e-12; a number in 1/MPa is a million times too large"
    )


@owning
@dataclass(frozen=True)
@plain
class Archard(WearLaw):
    """Archard's law: the depth is the coefficient times pressure times distance slid.

    Parameters
    ----------
    wear_coefficient : float or (n,) or as the contact grid [1/Pa]
        Wear coefficient ``k / H`` [1/Pa], with Archard's number k and the hardness H; one number, or one for
        each contact point. Measured coefficients scatter by 40 to 60 % [PodraAndersson1999], so worn depths
        are compared with each other rather than with a caliper.

    Examples
    --------
    >>> Archard.of_hardness(5e-4, 3e9).wear_coefficient
    1.6666666666666665e-13
    """

    wear_coefficient: Any

    def __post_init__(self) -> None:
        values = reals("wear_coefficient", self.wear_coefficient, "1/Pa")
        if not (np.isfinite(values).all() and (values >= 0.0).all()):
            raise ValueError(f"wear_coefficient is {self.wear_coefficient!r}: finite numbers >= 0 are needed")
        object.__setattr__(self, "wear_coefficient", float(values) if values.ndim == 0 else values)

    @classmethod
    def of_hardness(cls, k: float, hardness: float) -> Archard:
        """The law of Archard's number `k` [-] and a hardness [Pa]."""
        return cls(positive("k", k) / positive("hardness", hardness, "Pa"))

    def coefficient(self, rubbing: Rubbing) -> Array:
        """Depth worn off over distance slid and pressure (n,) [1/Pa]."""
        n = rubbing.pressure.size
        given = np.asarray(self.wear_coefficient, dtype=float)
        if given.size not in (1, n):
            raise ValueError(
                f"wear_coefficient has shape {given.shape}: a number, or one for each of {n} contact points"
            )
        return np.array(np.broadcast_to(given.reshape(-1), (n,)))


@owning
@dataclass(frozen=True)
@plain
class WearMap(WearLaw):
    """Archard's number over slip velocity and pressure, constant in each field of a map.

    Parameters
    ----------
    hardness : float [Pa]
        Of the body that wears.
    k : (pressures + 1, speeds + 1) [-]
        Archard's number in each field of the map.
    pressure : (pressures,) [Pa]
        Borders between the fields: pressures, rising.
    speed : (speeds,) [m/s]
        Borders between the fields: slip velocities, rising.
    """

    hardness: float
    k: Any
    pressure: Any
    speed: Any

    def __post_init__(self) -> None:
        put = object.__setattr__
        put(self, "hardness", positive("hardness", self.hardness, "Pa"))
        for name, unit in (("pressure", "Pa"), ("speed", "m/s")):
            put(self, name, _rising(name, getattr(self, name), unit))
        k = reals("k", self.k)
        wanted = (self.pressure.size + 1, self.speed.size + 1)
        if k.shape != wanted or not (k >= 0.0).all():
            raise ValueError(f"k has shape {k.shape}: numbers >= 0 of shape {wanted} are needed")
        put(self, "k", k)

    @classmethod
    def of_wheel_steel(cls, hardness: float) -> WearMap:
        """The map of dry wheel and rail steel [Jendel2002].

        1 to 10 10⁻⁴ below 0.2 m/s and above 0.7 m/s, 30 to 40 10⁻⁴ between them, 300 to 400 10⁻⁴ at pressures
        above 0.8 times the hardness: 5, 35 and 350 10⁻⁴ are taken. These borders and ranges are as they are
        commonly quoted, and were not compared with the printed map; the numbers within a range and one row
        above the border are our choice.
        """
        hardness = positive("hardness", hardness, "Pa")
        return cls(hardness, [[5e-4, 35e-4, 5e-4], [350e-4, 350e-4, 350e-4]], [0.8 * hardness], [0.2, 0.7])

    def coefficient(self, rubbing: Rubbing) -> Array:
        """Depth worn off over distance slid and pressure (n,) [1/Pa]."""
        if rubbing.speed is None:
            raise ValueError("a WearMap needs the slip velocity: give the velocity of the scene [m/s]")
        row = np.searchsorted(self.pressure, rubbing.pressure, side="right")
        column = np.searchsorted(self.speed, np.abs(rubbing.speed), side="right")
        return np.asarray(self.k[row, np.broadcast_to(column, row.shape)] / self.hardness)


@owning
@dataclass(frozen=True)
@plain
class EnergyWear(WearLaw):
    """Mass worn off over the energy that friction turns into heat, per area and distance.

    Parameters
    ----------
    energy : (k,) [Pa]
        Friction times slip (``T gamma / A``), rising from 0 on.
    rate : (k,) [kg/m3]
        Mass worn off over area and distance; linear between the entries, and beyond the last one.
    density : float [kg/m3]
        Of the body that wears.
    """

    energy: Any
    rate: Any
    density: float = 7850.0

    def __post_init__(self) -> None:
        put = object.__setattr__
        put(self, "density", positive("density", self.density, "kg/m^3"))
        energy, rate = _rising("energy", self.energy, "Pa"), reals("rate", self.rate, "kg/m^3")
        if energy.size < 2 or energy[0] != 0.0 or rate.shape != energy.shape or rate[0] != 0.0:
            raise ValueError(
                f"energy and rate have shapes {energy.shape} and {rate.shape}: two tables of equal length, "
                "both from 0 on, are needed"
            )
        if not (rate >= 0.0).all() or rate[-1] < rate[-2]:
            raise ValueError("rate must not be negative, nor fall at its end")
        put(self, "energy", energy)
        put(self, "rate", rate)

    @classmethod
    def of_wheel_steel(cls, density: float = 7850.0) -> EnergyWear:
        """Wheel steel R8T on rail steel 900A [Braghin2006]: mild, severe and catastrophic wear.

        5.3 T gamma/A up to 10.4 N/mm2, 55 up to 77.2, then 55 + 61.9 (T gamma/A - 77.2), in micrograms per
        metre and mm2. These numbers are as they are commonly quoted, and were not compared with the printed
        law; that 61.9 is the slope of a last branch which goes on from 55 is our reading of it.
        """
        energy = np.array([0.0, 10.4, 77.2, 177.2])
        rate = np.array([0.0, 55.0, 55.0, 55.0 + 61.9 * 100.0])
        # micrograms per mm2 and metre
        return cls(1e6 * energy, 1e-3 * rate, density)

    def coefficient(self, rubbing: Rubbing) -> Array:
        """Depth worn off over distance slid and pressure (n,) [1/Pa]."""
        share = rubbing.friction * rubbing.slip
        energy = share * rubbing.pressure
        first = self.rate[1] / self.energy[1]
        last = (self.rate[-1] - self.rate[-2]) / (self.energy[-1] - self.energy[-2])
        rate = np.interp(energy, self.energy, self.rate) + last * np.maximum(energy - self.energy[-1], 0.0)
        mean = np.where(energy > 1e-9 * self.energy[1], rate / np.where(energy > 0.0, energy, 1.0), first)
        # per distance slid
        return np.asarray(mean * rubbing.friction / self.density)


@dataclass(frozen=True)
@plain
class _OfFunction(WearLaw):
    """A user's function of what rubs."""

    function: Callable[[Rubbing], ArrayLike]

    def __repr__(self) -> str:
        """The name under which the user knows it."""
        return short(self.function)

    def coefficient(self, rubbing: Rubbing) -> Array:
        n = rubbing.pressure.size
        found = reals("wear coefficient", self.function(rubbing), "1/Pa")
        if found.shape not in ((), (n,)):
            raise ValueError(
                f"the law of wear returned shape {found.shape}: a number or ({n},) [1/Pa] is needed"
            )
        return np.array(np.broadcast_to(found, (n,)))


def depth_of_pass(
    law: Any,
    dissipation: Array,
    pressure: Array,
    friction: Array,
    slip: Array,
    speed: float | None,
    points: Array,
    step: float,
) -> Array:
    """Depth (ny,) [m] that one pass of a rolling contact wears off each line along x.

    Parameters
    ----------
    law : as for :func:`mtb_rs.wear`
    dissipation : (ny, nx) [Pa]
        Heat of friction per area and distance rolled: friction times pressure times slip.
    pressure, friction, slip : (ny, nx)
        Slip relative to the distance rolled.
    speed : float or None [m/s]
        Of rolling.
    points : (k, ny, nx) [m]
    step : float [m]
        Length of a cell along x.
    """
    p, mu, relative = (np.ascontiguousarray(part.reshape(-1)) for part in (pressure, friction, slip))
    velocity = None if speed is None else abs(speed) * relative
    rubbing = Rubbing(p, mu, relative, velocity, points.reshape(len(points), -1))
    coefficient = coefficients_of(as_wear_law("law", law), rubbing).reshape(pressure.shape)
    # what slips under a pressure and a friction dissipates their product
    rate = np.where(friction > 0.0, coefficient * dissipation / np.where(friction > 0.0, friction, 1.0), 0.0)
    return np.asarray(rate.sum(axis=1) * step)


def as_wear_law(name: str, given: Any) -> WearLaw:
    """The law of wear that was given: a law, a wear coefficient [1/Pa], or a function of :class:`Rubbing`."""
    if isinstance(given, WearLaw):
        return given
    if callable(given):
        return _OfFunction(given)
    if isinstance(given, (int, float, np.integer, np.floating)) and not isinstance(given, bool):
        if number(name, given, "1/Pa") < 0.0:
            raise ValueError(f"{name} is {given:g} 1/Pa: a wear coefficient of at least 0 is needed")
        return Archard(float(given))
    raise ValueError(
        f"{name} is {given!r}: a wear coefficient [1/Pa], a law (Archard, WearMap, EnergyWear) or a function "
        "of what rubs is needed"
    )


def _rising(name: str, given: Any, unit: str) -> Array:
    values = np.atleast_1d(reals(name, given, unit))
    if values.ndim != 1 or not np.all(np.diff(values) > 0.0) or (values.size and values[0] < 0.0):
        raise ValueError(f"{name} is {given!r}: numbers >= 0 that rise are needed")
    return values
