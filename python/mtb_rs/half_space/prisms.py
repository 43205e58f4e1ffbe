# SPDX-License-Identifier: MIT OR Apache-2.0
"""Prisms under rows of cells: what they do beside half-spaces of their materials."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .. import _mtb_rs
from ..base import memory
from ..bodies.prism import Prism
from ..bodies.simple import prism_of

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Prisms:
    """Two bodies under rows of cells, of which one or both are prisms.

    Attributes
    ----------
    core : PrismPair
    angles : (ny,) [rad]
        Of the surface at each row, positive where it rises along +y: of the lower body if it is a prism.
    """

    core: _mtb_rs.PrismPair
    angles: Array

    def normal(self, shape: tuple[int, int], spacing: tuple[float, float]) -> _mtb_rs.NormalPrisms:
        """What pressure and tractions do to the gap on all rows of cells (nx, ny)."""
        return _normal(self.core, shape, spacing)

    @property
    def notes(self) -> tuple[str, ...]:
        """What there is to say of each."""
        return tuple(
            f"A prism has {unknowns} unknowns in its section, for each of {count} waves of up to "
            f"{largest:.3g} 1/m; the shortest of them add {tail:.1g} of what a row of cells moves by its "
            "own load."
            for count, largest, tail, unknowns in self.core.waves
        )


@lru_cache(maxsize=4)
def _normal(
    core: _mtb_rs.PrismPair, shape: tuple[int, int], spacing: tuple[float, float]
) -> _mtb_rs.NormalPrisms:
    return core.normal(shape, spacing)


@lru_cache(maxsize=4)
def _prisms(
    lower: Prism | None,
    upper: Prism | None,
    first: float,
    shape: tuple[int, int],
    spacing: tuple[float, float],
) -> Prisms:
    ny, nx = shape
    middle = first + 0.5 * (ny - 1) * spacing[1]
    below, above = (
        None if body is None else body.under_rows(ny, spacing[1], middle, upper=side == 1)
        for side, body in enumerate((lower, upper))
    )
    core = _mtb_rs.PrismPair(
        None if below is None else below.core, None if above is None else above.core, (nx, ny), spacing
    )
    either = below if below is not None else above
    assert either is not None
    return Prisms(core, either.angles)


def prisms_under(
    lower: Any, upper: Any, first: float, shape: tuple[int, int], spacing: tuple[float, float]
) -> Prisms | None:
    """The prisms among two bodies under cells (ny, nx) with their first row at y = `first` [m], or None."""
    bodies = prism_of(lower), prism_of(upper)
    if bodies == (None, None):
        return None
    ny, nx = int(shape[0]), int(shape[1])
    # waves of each prism, a table of all offsets, and maps of the components
    needed = 8.0 * ny**2 * (2400.0 * sum(body is not None for body in bodies) + 80.0 * nx)
    what = f"a contact of {nx} x {ny} cells on a Prism"
    memory.refuse(needed, what, "take fewer rows of cells")
    memory.say(needed, what)
    # rounding of the place is no other place
    digits = max(0, 9 - int(np.floor(np.log10(spacing[1]))))
    return _prisms(*bodies, round(first, digits), (ny, nx), spacing)
