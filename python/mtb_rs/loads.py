# SPDX-License-Identifier: MIT OR Apache-2.0
"""Friction and magnetic pressure as users state them, and as fields over the contact points."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .result import Patch

Array = NDArray[np.float64]


@dataclass(frozen=True)
class GaussianPressure:
    """Magnetic pressure with a floor and a Gaussian hill, thesis (4.1).

    ``p(x, y) = peak (floor + (1 - floor) exp(-(x - cx)^2 / 2 sx^2) exp(-(y - cy)^2 / 2 sy^2))``

    Parameters
    ----------
    peak : float [Pa]
    center : (cx, cy) [m]
        The y of a hill on two poles is meant as its distance ``|y|`` from the symmetry plane.
    sigma : (sx, sy) [m]
    floor : float [-]
    """

    peak: float
    center: tuple[float, float]
    sigma: tuple[float, float]
    floor: float = 0.25

    def __post_init__(self) -> None:
        numbers = (self.peak, *self.center, *self.sigma, self.floor)
        if not np.all(np.isfinite(numbers)):
            raise ValueError(f"a Gaussian pressure needs finite numbers, not {self}")
        if min(self.sigma) <= 0.0:
            raise ValueError(f"sigma is {self.sigma}: both widths [m] must be positive")

    def __call__(self, x: Array, y: Array) -> Array:
        """Pressure [Pa] at x, y [m]."""
        (cx, cy), (sx, sy) = self.center, self.sigma
        hill = np.exp(-((x - cx) ** 2) / (2 * sx**2) - (np.abs(y) - cy) ** 2 / (2 * sy**2))
        return np.asarray(self.peak * (self.floor + (1.0 - self.floor) * hill))


@dataclass(frozen=True)
class VelocityTable:
    """A quantity tabulated over the sliding velocity, thesis 2.2.1.

    Parameters
    ----------
    velocity : sequence of float [m/s]
        Rising.
    value : sequence
        One value for each velocity: numbers, or anything the quantity itself may be (a distribution, an
        array); between two velocities the fields are interpolated linearly, outside is an error.
    """

    velocity: Sequence[float]
    value: Sequence[Any]

    def __post_init__(self) -> None:
        velocity = tuple(float(v) for v in self.velocity)
        if len(velocity) < 2 or len(velocity) != len(self.value):
            raise ValueError(
                f"a velocity table has {len(velocity)} velocities and {len(self.value)} values: "
                "at least two of each, and as many of one as of the other, are needed"
            )
        if not np.all(np.isfinite(velocity)) or np.any(np.diff(velocity) <= 0.0):
            raise ValueError(f"velocity is {velocity}: finite numbers [m/s] that rise are needed")
        object.__setattr__(self, "velocity", velocity)
        object.__setattr__(self, "value", tuple(self.value))

    def bracket(self, velocity: float) -> tuple[Any, Any, float]:
        """The two values around `velocity` [m/s] and the weight of the second."""
        if not self.velocity[0] <= velocity <= self.velocity[-1]:
            raise ValueError(
                f"velocity is {velocity:g} m/s: the table covers "
                f"{self.velocity[0]:g} to {self.velocity[-1]:g} m/s"
            )
        upper = max(1, int(np.searchsorted(self.velocity, velocity)))
        low, high = self.velocity[upper - 1], self.velocity[upper]
        return self.value[upper - 1], self.value[upper], (velocity - low) / (high - low)


@dataclass(frozen=True)
class PressureDependentFriction:
    """A friction coefficient that depends on the local pressure.

    Parameters
    ----------
    function : callable
        Friction coefficients [-] for an array of pressures [Pa], element by element.
    """

    function: Callable[[Array], ArrayLike]

    def at(self, pressure: Array) -> Array:
        """Friction coefficient (n,) at `pressure` (n,) [Pa], checked."""
        return _checked("friction", np.broadcast_to(self.function(pressure), pressure.shape), 0.0)


def field(
    name: str,
    spec: Any,
    points: Array,
    patches: tuple[Patch, ...],
    velocity: float | None,
    minimum: float | None = None,
) -> Array:
    """Values (n,) at the contact points of anything a user may state a field by.

    Parameters
    ----------
    spec
        A number, an array (n,) or of the grid's shape, one entry per pole (list or tuple, left
        first), a callable of x and y [m], or a :class:`VelocityTable` of these.
    points : (3, n) [m]
    minimum : float
        Smallest value accepted.
    """
    n = points.shape[1]
    if isinstance(spec, VelocityTable):
        if velocity is None:
            raise ValueError(f"{name} is a table over velocity: give velocity=... [m/s]")
        first, second, weight = spec.bracket(velocity)
        parts = [field(name, part, points, patches, velocity, minimum) for part in (first, second)]
        return (1.0 - weight) * parts[0] + weight * parts[1]
    if isinstance(spec, (list, tuple)) and len(spec) == len(patches) > 1:
        out = np.empty(n)
        for patch, part in zip(patches, spec, strict=True):
            cut = slice(patch.start, patch.start + patch.nx * patch.ny)
            whole = (Patch(patch.name, 0, patch.nx, patch.ny),)
            out[cut] = field(f"{name}[{patch.name}]", part, points[:, cut], whole, velocity, minimum)
        return out
    if callable(spec):
        spec = np.broadcast_to(np.asarray(spec(points[0], points[1]), dtype=float), (n,))
    try:
        values = np.asarray(spec, dtype=float)
    except (TypeError, ValueError) as error:
        raise ValueError(
            f"{name} is {spec!r}: a number, an array, a callable of x and y, or a table over velocity "
            "is needed"
        ) from error
    if values.ndim == 0:
        values = np.full(n, float(values))
    if values.size != n:
        raise ValueError(f"{name} has shape {values.shape}: there are {n} contact points")
    return _checked(name, values.reshape(n), minimum)


def _checked(name: str, given: Any, minimum: float | None) -> Array:
    values: Array = np.ascontiguousarray(given, dtype=float)
    bad = ~np.isfinite(values)
    if minimum is not None:
        bad |= values < minimum
    if bad.any():
        at = int(np.argmax(bad))
        need = "a finite number" if minimum is None else f"a finite number not below {minimum:g}"
        raise ValueError(f"{name} is {values[at]!r} at point {at}: {need} is needed")
    return values
