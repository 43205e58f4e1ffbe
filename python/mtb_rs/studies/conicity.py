# SPDX-License-Identifier: MIT OR Apache-2.0
"""Equivalent conicity of a wheelset from its difference of rolling radii over the lateral shift."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..base.check import choice, positive, reals
from ..base.units import taking_quantities
from ..base.words import Linearisation

Array = NDArray[np.float64]

#: Steps of the quadrature over half a wave, and of each search by halves.
NODES, HALVES = 2000, 60


@taking_quantities
def klingel_wavelength(conicity: ArrayLike, wheel_radius: float = 0.46, base: float = 1.5) -> Array:
    """Wavelength of the sinusoidal path of a free wheelset of two cones [m] [Klingel1883].

    2 pi sqrt(wheel_radius base / (2 conicity)).

    Parameters
    ----------
    conicity : any shape [-]
        Tangent of the cone angle, > 0, or an equivalent conicity.
    wheel_radius : float [m]
    base : float [m]
        Distance between the contacts of the two wheels.
    """
    cone = reals("conicity", conicity)
    if not (cone > 0.0).all():
        raise ValueError(
            f"conicity is {conicity!r}: positive numbers are needed, other wheelsets do not oscillate"
        )
    radius, width = positive("wheel_radius", wheel_radius, "m"), positive("base", base, "m")
    return np.asarray(2.0 * np.pi * np.sqrt(0.5 * radius * width / cone))


@taking_quantities
def equivalent_conicity(
    shift: ArrayLike,
    radius_difference: ArrayLike,
    amplitude: ArrayLike = 3e-3,
    method: Linearisation = "integration",
) -> Array:
    """Tangent of the angle of two cones that run like a wheelset at a lateral amplitude.

    Parameters
    ----------
    shift : (n,) [m]
        Lateral shift of the wheelset, rising.
    radius_difference : (n,) [m]
        Rolling radius of the wheel towards which it is shifted less that of the other one; straight between
        the points.
    amplitude : any shape [m]
        Half of the width of the motion; 3 mm is the one that limits of vehicles are stated for.
    method : "integration" or "harmonic"
        "integration" takes the wavelength of the kinematic motion, from the integral of the nonlinear
        equation d2y/dx2 = -radius_difference / (base wheel_radius), and the cones that have it by Klingel's
        formula: the method of EN 15302 [EN15302], annex B. "harmonic" takes the first harmonic of the
        difference over a sinusoidal motion, 1 / (2 pi A) int difference(A sin p) sin p dp
        (quasi-linearisation).

    Returns
    -------
    Array like `amplitude` [-]
        0 within a play in which both radii are the same, as of cylindrical treads, about whose middle the
        amplitude counts. NaN by "integration" where the wheelset does not oscillate through the middle: the
        difference has the other sign there, as that of worn wheels with negative conicity, and its integral
        up to the amplitude does not make up for it.

    Raises
    ------
    ValueError
        If the motion would leave the range of `shift`, or the difference never passes zero rising.
    """
    y, difference = reals("shift", shift, "m"), reals("radius_difference", radius_difference, "m")
    wanted = reals("amplitude", amplitude, "m")
    choice("method", method, Linearisation)
    if y.ndim != 1 or y.shape != difference.shape or y.size < 3:
        raise ValueError(
            f"shift and radius_difference have the shapes {y.shape} and {difference.shape}: one row each, of "
            "at least 3, is needed"
        )
    if not (np.diff(y) > 0.0).all():
        raise ValueError("shift does not rise from place to place")
    if not (wanted > 0.0).all():
        raise ValueError(f"amplitude is {amplitude!r}: positive numbers [m] are needed")
    table = _Difference(y, difference)
    reach = min(table.middle - y[0], y[-1] - table.middle)
    if wanted.size and wanted.max() > reach:
        raise ValueError(
            f"amplitude is {wanted.max():g} m: shift leaves {reach:.4g} m on both sides of y = "
            f"{table.middle:.4g} m, where both radii are the same"
        )
    found = (table.by_wavelength if method == "integration" else table.by_harmonic)(wanted.ravel())
    return np.asarray(found.reshape(wanted.shape))


def middle_of(shift: Array, difference: Array) -> float | None:
    """Where a difference of radii passes zero rising, the nearest to the middle of the track [m].

    Where it is zero over some width, as with cylindrical treads, this is the middle of that; None: nowhere.
    """
    signs = np.flatnonzero(difference)
    rises = [(i, j) for i, j in pairwise(signs) if difference[i] < 0.0 < difference[j]]
    places = [
        0.5 * (shift[i + 1] + shift[j - 1])
        if j > i + 1
        else shift[i] - difference[i] * (shift[j] - shift[i]) / (difference[j] - difference[i])
        for i, j in rises
    ]
    return float(min(places, key=abs)) if places else None


class _Difference:
    """The difference of radii, straight between its points, and its integral."""

    def __init__(self, y: Array, difference: Array) -> None:
        self.y, self.difference = y, difference
        middle = middle_of(y, difference)
        if middle is None:
            raise ValueError(
                "radius_difference never passes zero rising over shift: the wheelset has no middle to run "
                "about"
            )
        self.middle = middle
        self.integral = np.append(0.0, np.cumsum(0.5 * (difference[1:] + difference[:-1]) * np.diff(y)))
        self.integral -= self.at(np.array([self.middle]))[0]

    def at(self, y: Array) -> Array:
        """The integral of the difference from the middle [m2]."""
        k = np.clip(np.searchsorted(self.y, y, "right") - 1, 0, self.y.size - 2)
        step = y - self.y[k]
        slope = (self.difference[k + 1] - self.difference[k]) / (self.y[k + 1] - self.y[k])
        return np.asarray(self.integral[k] + step * (self.difference[k] + 0.5 * slope * step))

    def ends(self, amplitude: Array) -> tuple[Array, Array]:
        """From where to where motions go that are wide by twice the amplitude."""
        # the higher end is the one whose integral is the same as at the lower end, a width away
        low, high = self.middle - 2.0 * amplitude, np.full(amplitude.size, self.middle)
        for _ in range(HALVES):
            start = 0.5 * (low + high)
            inside = np.maximum(start, self.y[0])
            stop = np.minimum(start + 2.0 * amplitude, self.y[-1])
            is_left = self.at(inside) + (inside - start) > self.at(stop) + (start + 2.0 * amplitude - stop)
            low, high = np.where(is_left, start, low), np.where(is_left, high, start)
        start = 0.5 * (low + high)
        stop = start + 2.0 * amplitude
        beyond = (start < self.y[0] - 1e-9 * amplitude) | (stop > self.y[-1] + 1e-9 * amplitude)
        if beyond.any():
            k = int(beyond.argmax())
            raise ValueError(
                f"amplitude is {amplitude[k]:g} m: the motion goes from {start[k]:.4g} to {stop[k]:.4g} m, "
                f"and shift from {self.y[0]:.4g} to {self.y[-1]:.4g} m"
            )
        return start, stop

    def by_wavelength(self, amplitude: Array) -> Array:
        start, stop = self.ends(amplitude)
        energy = 0.5 * (self.at(start) + self.at(stop))
        # y = middle + arm sin(p) takes the root out of the ends
        turn = np.asarray((np.arange(NODES) + 0.5) * (0.5 * np.pi / NODES), dtype=float)
        total = np.zeros(amplitude.size)
        for arm in (start - self.middle, stop - self.middle):
            y = self.middle + arm[:, None] * np.sin(turn)
            left = energy[:, None] - self.at(y.ravel()).reshape(y.shape)
            with np.errstate(invalid="ignore", divide="ignore"):
                slowness = np.abs(arm)[:, None] * np.cos(turn) / np.sqrt(left)
            # nothing drives it back within a play, and what drives it on keeps it from the ends
            slowness[left == 0.0] = np.inf
            slowness[left < 0.0] = np.nan
            total += slowness.sum(axis=1) * (0.5 * np.pi / NODES)
        return np.asarray((np.pi / total) ** 2)

    def by_harmonic(self, amplitude: Array) -> Array:
        turn = np.asarray((np.arange(2 * NODES) + 0.5) * (np.pi / NODES), dtype=float)
        low, high = self.middle - amplitude, self.middle + amplitude
        low = np.maximum(low, self.y[0] + amplitude)
        high = np.minimum(high, self.y[-1] - amplitude)
        for _ in range(HALVES):
            # the middle about which the mean of the difference is zero
            bias = 0.5 * (low + high)
            mean = self._over(bias, amplitude, turn).mean(axis=1)
            low, high = np.where(mean < 0.0, bias, low), np.where(mean < 0.0, high, bias)
        values = self._over(0.5 * (low + high), amplitude, turn)
        return np.asarray((values * np.sin(turn)).mean(axis=1) / amplitude)

    def _over(self, bias: Array, amplitude: Array, turn: Array) -> Array:
        y = bias[:, None] + amplitude[:, None] * np.sin(turn)
        return np.interp(y.ravel(), self.y, self.difference).reshape(y.shape)
