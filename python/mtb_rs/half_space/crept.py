# SPDX-License-Identifier: MIT OR Apache-2.0
"""Bodies that creep under a contact that rolls over them: what changes of their numbers do to it."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .. import _mtb_rs
from ..base.differences import AHEAD, CENTRAL, by_modulus
from ..bodies.simple import Core, do_creep

Array = NDArray[np.float64]
Pair = tuple[float, float]
#: A weight in a derivative, and the bodies that creep, as the core has them, by their sides.
Weighted = tuple[float, dict[str, Core]]

#: Widths of differences: of the way in a creep time over itself, or over a cell where there is none ...
_WIDTH = 3e-4
#: ... and of its direction, along which it passes by corners of many cells.
_TURN = 2e-5


class Crept:
    """The bodies among two that creep, in differences of the fourth order of what they are known by.

    Parameters
    ----------
    lower, upper : body
        Viscoelastic ones count.
    velocity : (float, float) [m/s]
        Of the contact over them.
    spacing : (float, float) [m]
        Of the cells.
    """

    def __init__(self, lower: Any, upper: Any, velocity: Pair, spacing: Pair) -> None:
        sides = {"lower": lower, "upper": upper}
        self.bodies = {side: body for side, body in sides.items() if do_creep(body)}
        self.velocity, self._cell = velocity, min(spacing)

    @property
    def numbers(self) -> dict[str, Callable[[], list[Weighted]]]:
        """By name, such as ``"lower.creep"``: the terms of a derivative by it."""
        names = ("young_modulus", "poisson_ratio", "creep", "creep_time")
        return {
            f"{side}.{name}": lambda s=side, n=name: list(self._by_number(s, n))  # type: ignore[misc]
            for side in self.bodies
            for name in names
        }

    @property
    def motions(self) -> dict[str, Callable[[], list[Weighted]]]:
        """The same by the speed and the direction of the contact, ``"velocity"`` and ``"angle"``."""
        return {"velocity": lambda: list(self._by_speed()), "angle": lambda: list(self._by_angle())}

    def under(self, velocity: Pair) -> dict[str, Core]:
        """The bodies under another velocity [m/s]."""
        return {side: body.under(velocity) for side, body in self.bodies.items()}

    def turned(self, angle: float) -> Pair:
        """The velocity in a direction that is turned by an angle [rad]."""
        x, y = self.velocity
        c, s = math.cos(angle), math.sin(angle)
        return x * c - y * s, x * s + y * c

    def _by_number(self, side: str, name: str) -> Iterator[Weighted]:
        body = self.bodies[side]
        for weight, changed in self._changed(body, name):
            yield weight, {side: changed.under(self.velocity)}

    def _changed(self, body: Any, name: str) -> Iterator[tuple[float, Any]]:
        if name in ("young_modulus", "poisson_ratio"):
            for values in by_modulus(name, getattr(body.material, name)):
                for weight, value in values:
                    yield weight, replace(body, material=replace(body.material, **{name: value}))
                return
        if name == "creep":
            # all is linear in it
            yield 1.0, replace(body, creep=body.creep + 1.0)
            yield -1.0, body
        if name == "creep_time":
            known = body.creep_time > 0.0
            width = _WIDTH * (body.creep_time if known else self._cell / math.hypot(*self.velocity))
            for place, weight in zip(*(CENTRAL if known else AHEAD), strict=True):
                yield weight / width, replace(body, creep_time=body.creep_time + place * width)

    def _by_speed(self) -> Iterator[Weighted]:
        speed = math.hypot(*self.velocity)
        for place, weight in zip(*CENTRAL, strict=True):
            share = 1.0 + place * _WIDTH
            yield weight / (_WIDTH * speed), self.under((share * self.velocity[0], share * self.velocity[1]))

    def _by_angle(self) -> Iterator[Weighted]:
        for place, weight in zip(*CENTRAL, strict=True):
            yield weight / _TURN, self.under(self.turned(place * _TURN))


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
