# SPDX-License-Identifier: MIT OR Apache-2.0
"""Layered bodies and bodies that creep: what changes of their constants do to what they give way."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .. import _mtb_rs
from ..base.differences import AHEAD, CENTRAL
from ..bodies.simple import Core, are_compound, do_creep, medium_of

Array = NDArray[np.float64]
Pair = tuple[float, float]
#: A weight in a derivative, and the bodies that change, as the core has them, by their sides.
Weighted = tuple[float, dict[str, Core]]

#: Widths of differences: of the speed over itself, and of the way in a creep time over a cell ...
_WIDTH = 3e-4
#: ... and of its direction, along which it passes by corners of many cells.
TURN = 2e-5


class Compound:
    """The bodies among two that are layered or creep, in differences of the fourth order of what they are
    known by.

    Parameters
    ----------
    lower, upper : body
        Layered and Viscoelastic ones count.
    velocity : (float, float) or None [m/s]
        Of the contact over those that creep.
    spacing : (float, float) [m]
        Of the cells.
    """

    def __init__(self, lower: Any, upper: Any, velocity: Pair | None, spacing: Pair) -> None:
        sides = {"lower": lower, "upper": upper}
        self.bodies = {side: body for side, body in sides.items() if are_compound(body)}
        self.velocity, self._cell = velocity, min(spacing)

    @property
    def numbers(self) -> dict[str, Callable[[], list[Weighted]]]:
        """By name, such as ``"lower.creep"``: the terms of a derivative by it."""
        return {
            f"{side}.{name}": partial(self._by_constant, side, name)
            for side, body in self.bodies.items()
            for name in body.constants
        }

    @property
    def motions(self) -> dict[str, Callable[[], list[Weighted]]]:
        """The same by the speed and the direction of the contact, ``"velocity"`` and ``"angle"``; none where
        nothing creeps."""
        if self.velocity is None:
            return {}
        return {"velocity": lambda: list(self._by_speed()), "angle": lambda: list(self._by_angle())}

    @property
    def _rolling(self) -> Pair:
        assert self.velocity is not None
        return self.velocity

    def under(self, velocity: Pair) -> dict[str, Core]:
        """The bodies under another velocity [m/s]."""
        return {side: body.under(velocity) for side, body in self.bodies.items() if do_creep(body)}

    def turned(self, angle: float) -> Pair:
        """The velocity in a direction that is turned by an angle [rad]."""
        x, y = self._rolling
        c, s = math.cos(angle), math.sin(angle)
        return x * c - y * s, x * s + y * c

    def _by_constant(self, side: str, name: str) -> list[Weighted]:
        body = self.bodies[side]
        is_at_once = name == "creep_time" and body.creep_time == 0.0
        terms = self._by_first_time(body) if is_at_once else body.varied(name)
        return [(weight, {side: _core(changed, self.velocity)}) for weight, changed in terms]

    def _by_first_time(self, body: Any) -> Iterator[tuple[float, Any]]:
        width = _WIDTH * self._cell / math.hypot(*self._rolling)
        for place, weight in zip(*AHEAD, strict=True):
            yield weight / width, replace(body, creep_time=place * width)

    def _by_speed(self) -> Iterator[Weighted]:
        x, y = self._rolling
        speed = math.hypot(x, y)
        for place, weight in zip(*CENTRAL, strict=True):
            share = 1.0 + place * _WIDTH
            yield weight / (_WIDTH * speed), self.under((share * x, share * y))

    def _by_angle(self) -> Iterator[Weighted]:
        for place, weight in zip(*CENTRAL, strict=True):
            yield weight / TURN, self.under(self.turned(place * TURN))


def _core(body: Any, velocity: Pair | None) -> Core:
    core = medium_of(body, velocity)
    assert core is not None
    return core


def opened_by_terms(
    terms: list[Weighted], load: Array, spacing: Pair, signs: Mapping[str, float] | None = None
) -> Array:
    """Gap (ny, nx) [m] that a load (3, ny, nx) [Pa] on the lower body opens, by terms of a derivative.

    `signs` of both sides count where the load is along the surface: on the upper body it is turned round.
    """
    ny, nx = load.shape[1:]
    flat = np.ascontiguousarray(load.reshape(3, -1))
    found = np.zeros((ny, nx))
    for weight, bodies in terms:
        for side, body in bodies.items():
            surface = _mtb_rs.half_space(body, [(0.0, 0.0, nx, ny)], spacing, True)
            sign = 1.0 if signs is None else signs[side]
            found += sign * weight * surface.displacement(flat)[2].reshape(ny, nx)
    return found


def opened_by_waves(body: Any, pressure: Array, spacing: Pair) -> Array:
    """Gap (ny, nx) [m] that a periodic pressure (ny, nx) [Pa] opens on a half-space or a Layered body."""
    ny, nx = pressure.shape
    along = 2.0 * np.pi * np.fft.rfftfreq(nx, spacing[0])
    across = 2.0 * np.pi * np.fft.fftfreq(ny, spacing[1])
    numbers = np.hypot(along[None], across[:, None])
    waves = body.waves(numbers.ravel()).reshape(numbers.shape)
    return np.asarray(np.fft.irfft2(waves * np.fft.rfft2(pressure), (ny, nx)))
