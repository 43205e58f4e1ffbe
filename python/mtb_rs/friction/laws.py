# SPDX-License-Identifier: MIT OR Apache-2.0
"""Friction laws, and the layer between the bodies."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .. import _mtb_rs
from ..base.check import number, reals, shortened
from ..base.owning import owning
from ..base.plain import plain
from ..base.questions import ask
from ..base.renamed import renamed
from ..geometry.contact_points import window

Array = NDArray[np.float64]


#: Coefficients of friction above this are mostly percentages, or a slip of the pen: clean metals in vacuum
#: and soft rubber reach it.
HIGH_FRICTION = 2.0


def of_friction(name: str, largest: float) -> list[str]:
    """A question about a coefficient of friction that hardly any pair of bodies has."""
    if largest <= HIGH_FRICTION:
        return []
    return [
        f"{name} reaches {largest:g}: coefficients of friction are numbers such as 0.3, and above "
        f"{HIGH_FRICTION:g} only soft rubber and clean metals in vacuum have them"
    ]


def _number(name: str, value: float, lowest: float = 0.0, strictly: bool = False) -> float:
    checked = number(name, value)
    if checked < lowest or (strictly and checked == lowest):
        raise ValueError(f"{name} is {value:g}: it must be {'above' if strictly else 'at least'} {lowest:g}")
    return checked


@owning
@dataclass(frozen=True)
@plain
class Coulomb:
    """A coefficient of friction that does not change with slip.

    Parameters
    ----------
    coefficient : float or (ny, nx) float [-]
        One number, or one per cell of the patch.
    """

    coefficient: float | Array

    def __post_init__(self) -> None:
        values = reals("coefficient", self.coefficient)
        if values.size == 0 or np.any(values < 0.0):
            raise ValueError(
                f"coefficient is {shortened(self.coefficient)}: numbers of at least 0 are needed"
            )
        if values.ndim not in (0, 2):
            raise ValueError(f"coefficient has shape {values.shape}: one number or (ny, nx) is needed")
        ask(of_friction("coefficient", float(values.max())))

    def at_rest(self) -> float:
        """Largest coefficient at rest [-]."""
        return float(np.max(self.coefficient))


@dataclass(frozen=True)
@plain
class StaticKinetic:
    """One coefficient for points that stick, another for points that slip.

    The jump between the two makes the result depend on the grid: single cells decide where the slip area ends
    and whether several states exist. CONTACT has withdrawn this law for that reason. The total force in full
    slip is sound, and the fields near the edge of the slip area are not. Use :class:`FallingFriction` with a
    memory where they matter. A warning says so.

    Parameters
    ----------
    static, kinetic : float [-]
        `kinetic` must not exceed `static`.
    """

    static: float
    kinetic: float

    def __post_init__(self) -> None:
        _number("kinetic", self.kinetic)
        if _number("static", self.static) < self.kinetic:
            raise ValueError(f"static is {self.static:g}: it must not be below kinetic = {self.kinetic:g}")
        withdrawn = (
            "StaticKinetic depends on the grid: single cells decide where the slip area ends, and CONTACT "
            "has withdrawn this law as an artefact of the grid. The total force in full slip is sound; for "
            "fields near the edge of the slip area take FallingFriction with a memory"
        )
        ask([withdrawn, *of_friction("static", self.static)])

    def at_rest(self) -> float:
        """Coefficient at rest [-]."""
        return self.static


@dataclass(frozen=True)
@plain
class FallingFriction:
    """A coefficient that falls exponentially with the slip speed [Vollebregt2012, eq. 3, 4].

    ``mu_s(s) = kinetic + (static - kinetic) exp(-ln 2 s / half_slip)``; with a memory the coefficient of a
    particle follows it by ``dmu/dt = -max(s, memory_min_slip) / memory (mu - mu_s)``. Without one,
    transient rolling is unstable on fine grids.

    Parameters
    ----------
    static, kinetic : float [-]
        Coefficients at rest and at high slip speed.
    half_slip : float [m/s]
        Slip speed at which the coefficient has fallen by half of the difference.
    memory : float [m] or None
        Slip distance over which the coefficient adapts.
    memory_min_slip : float [m/s]
        Slip speed with which the coefficient still adapts where the surfaces stick.
    """

    static: float
    kinetic: float
    half_slip: float
    memory: float | None = None
    memory_min_slip: float = 1e-3

    def __post_init__(self) -> None:
        _number("static", self.static)
        _number("kinetic", self.kinetic)
        _number("half_slip", self.half_slip, strictly=True)
        if self.memory is not None:
            _number("memory", self.memory, strictly=True)
        _number("memory_min_slip", self.memory_min_slip, strictly=True)
        for name in ("static", "kinetic"):
            ask(of_friction(name, getattr(self, name)))

    def at_rest(self) -> float:
        """Coefficient at rest [-]."""
        return self.static

    @renamed(speed="slip_speed")
    def sliding(self, slip_speed: float | Array) -> Array:
        """Coefficient [-] of continuous sliding at the slip speed [m/s]."""
        fall = np.exp(-math.log(2.0) * np.asarray(slip_speed, dtype=float) / self.half_slip)
        return np.asarray(self.kinetic + (self.static - self.kinetic) * fall)


@owning
@dataclass(frozen=True)
@plain
class TabulatedFriction:
    """A coefficient given at slip speeds, linear between them and constant beyond the last.

    Parameters
    ----------
    slip_speed : sequence of float [m/s]
        Strictly rising from 0.
    coefficient : sequence of float [-]
    memory : float [m] or None
        As in :class:`FallingFriction`.
    memory_min_slip : float [m/s]
    """

    slip_speed: Sequence[float]
    coefficient: Sequence[float]
    memory: float | None = None
    memory_min_slip: float = 1e-3

    def __post_init__(self) -> None:
        speed = reals("slip_speed", self.slip_speed, "m/s")
        values = reals("coefficient", self.coefficient)
        if speed.ndim != 1 or speed.size < 1 or speed[0] != 0.0 or np.any(np.diff(speed) <= 0.0):
            raise ValueError("slip_speed must rise strictly from 0")
        if values.shape != speed.shape:
            raise ValueError(f"coefficient has {values.size} entries, slip_speed has {speed.size}")
        if np.any(values < 0.0):
            at = int(np.argmin(values))
            raise ValueError(f"coefficient[{at}] is {values[at]:g}: numbers of at least 0 are needed")
        if self.memory is not None:
            _number("memory", self.memory, strictly=True)
        _number("memory_min_slip", self.memory_min_slip, strictly=True)
        ask(of_friction("coefficient", float(values.max())))

    def at_rest(self) -> float:
        """Coefficient at rest [-]."""
        return float(self.coefficient[0])

    @renamed(speed="slip_speed")
    def sliding(self, slip_speed: float | Array) -> Array:
        """Coefficient [-] of continuous sliding at the slip speed [m/s]."""
        return np.asarray(np.interp(slip_speed, self.slip_speed, self.coefficient))


Friction = Coulomb | StaticKinetic | FallingFriction | TabulatedFriction


@owning
@dataclass(frozen=True)
@plain
class RailFriction:
    """A coefficient of friction over the rail, for wheels in steps (:meth:`mtb_rs.Scene.prepare`).

    The coefficient is fixed to the rail, and each step evaluates it at the cells of its patches. It is linear
    between the given places and constant beyond the first and the last one; two places close together make a
    step. Both rails have the same coefficient, the right rail as a mirror image.

    Parameters
    ----------
    rail_position : (n,) float [m]
        Places across the rail, strictly rising: y in the rail profile's own frame, as `rail_position` of a
        patch; the gauge corner of the ready rail is at y < 0.
    coefficient : (n,) or (m, n) float [-]
        At least 0; (m, n) with `x`.
    x : (m,) float [m] or None
        Places along the track, strictly rising; None: friction does not vary along it.

    Examples
    --------
    A gauge corner with grease on it, and a rail that is wet from x = 10 m on:

    >>> corner = RailFriction([-20e-3, -15e-3], [0.1, 0.4])
    >>> wet = RailFriction([0.0], [[0.4], [0.15]], x=[10.0, 10.001])
    """

    rail_position: Array
    coefficient: Array
    x: Array | None = None

    def __post_init__(self) -> None:
        position = _places("rail_position", self.rail_position)
        values = reals("coefficient", self.coefficient)
        along = None if self.x is None else _places("x", self.x)
        shape = position.shape if along is None else (along.size, position.size)
        if values.shape != shape:
            raise ValueError(
                f"coefficient has shape {values.shape}: {shape} is needed, "
                f"{'one for each rail_position' if along is None else 'a row for each x'}"
            )
        if np.any(values < 0.0):
            raise ValueError(f"coefficient is {np.min(values):g}: numbers of at least 0 are needed")
        ask(of_friction("coefficient", float(values.max(initial=0.0))))
        for name, field in (("rail_position", position), ("coefficient", values), ("x", along)):
            object.__setattr__(self, name, field)


def _places(name: str, values: ArrayLike) -> Array:
    places = reals(name, values, "m")
    if places.ndim != 1 or not places.size or np.any(np.diff(places) <= 0.0):
        raise ValueError(f"{name} is {shortened(values)}: places [m] that rise strictly are needed")
    return places


@dataclass(frozen=True)
@plain
class InterfaceLayer:
    """A layer of debris or roughness between the bodies, as shear springs [Vollebregt2012, eq. 2].

    Parameters
    ----------
    thickness : float [m]
    shear_modulus : float [Pa]
    """

    thickness: float
    shear_modulus: float

    def __post_init__(self) -> None:
        _number("thickness", self.thickness)
        _number("shear_modulus", self.shear_modulus, strictly=True)

    @property
    def flexibility(self) -> float:
        """Displacement per traction, thickness over shear modulus [m/Pa]."""
        return self.thickness / self.shear_modulus


def coulomb_field(friction: Coulomb, shape: tuple[int, int]) -> Array:
    """The coefficient (ny, nx) on a grid of that shape."""
    values = np.asarray(friction.coefficient, dtype=float)
    if values.ndim and values.shape != shape:
        raise ValueError(
            f"coefficient has shape {values.shape}: one number, or the shape of the patch, {shape}, is needed"
        )
    return np.broadcast_to(values, shape)


def native_law(friction: Friction, shape: tuple[int, int], cut: tuple[slice, slice]) -> _mtb_rs.Friction:
    """The law as the solver takes it, on the rectangle `cut` of a grid of `shape` (ny, nx)."""
    if isinstance(friction, Coulomb):
        return _mtb_rs.Friction.coulomb(window(coulomb_field(friction, shape), cut).ravel())
    if isinstance(friction, StaticKinetic):
        return _mtb_rs.Friction.static_kinetic(float(friction.static), float(friction.kinetic))
    if not isinstance(friction, (FallingFriction, TabulatedFriction)):
        raise ValueError(f"friction is {friction!r}: a friction law, such as Coulomb(0.3), is needed")
    memory = None if friction.memory is None else (float(friction.memory), float(friction.memory_min_slip))
    if isinstance(friction, FallingFriction):
        return _mtb_rs.Friction.exponential(
            float(friction.static), float(friction.kinetic), float(friction.half_slip), memory
        )
    speed = np.array(friction.slip_speed, dtype=float)
    return _mtb_rs.Friction.table(speed, np.array(friction.coefficient, dtype=float), memory)
