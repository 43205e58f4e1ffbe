# SPDX-License-Identifier: MIT OR Apache-2.0
"""The pole shoes of a magnetic track brake on a rail."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .. import _mtb_rs
from ..base.check import number, positive, reals
from ..base.plain import plain
from ..base.renamed import renamed
from .contact_points import ContactGrid, contact_grid, spacing_pair
from .profiles import Profile, as_profile

Array = NDArray[np.float64]


@renamed(sheet="grid")
@dataclass(frozen=True)
@plain
class PoleShoe:
    """A pole shoe of a magnetic track brake, each pole worn to the shape of the rail below it.

    Parameters
    ----------
    height : float [m]
        Height of the flat top above the crown.
    length : float [m]
    inner_edge, outer_edge : float [m]
        ``|y|`` of the edges of a pole.
    conforming_to : float [m]
        The sole follows the rail for ``inner_edge <= |y| <= conforming_to`` ...
    relief_slope : float [-]
        ... and rises from there with this slope ``dz/d|y|``.
    poles : int
        1 (left, y > 0) or 2.
    lateral, yaw : float [m], [rad]
        Offset along y and rotation about z of the shoe. The sole then no longer conforms; each pole
        is placed to just touch the rail.
    rail : str or Profile
    """

    height: float = 28.2e-3
    length: float = 90e-3
    inner_edge: float = 6e-3
    outer_edge: float = 36e-3
    conforming_to: float = 21.6e-3
    relief_slope: float = 0.02
    poles: int = 2
    lateral: float = 0.0
    yaw: float = 0.0
    rail: str | Profile = field(default="60E1")

    def __post_init__(self) -> None:
        put = object.__setattr__
        for name in ("inner_edge", "outer_edge", "conforming_to", "lateral"):
            put(self, name, number(name, getattr(self, name), "m"))
        for name in ("height", "length"):
            put(self, name, positive(name, getattr(self, name), "m"))
        put(self, "yaw", number("yaw", self.yaw, "rad"))
        put(self, "relief_slope", number("relief_slope", self.relief_slope))
        if isinstance(self.poles, bool) or not isinstance(self.poles, (int, np.integer)):
            raise ValueError(f"poles is {self.poles!r}: the whole number 1 or 2 is needed")
        if self.poles not in (1, 2):
            raise ValueError(f"poles is {self.poles!r}: a shoe has 1 or 2 poles")
        put(self, "rail", as_profile(self.rail))
        # one row of cells per pole, for the core to judge the rest at birth
        self.grid((self.length, 1.0))
        if self.height <= max(0.0, *(float(self.sole(side * self.outer_edge)) for side in self.sides)):
            raise ValueError(f"height is {self.height:g} m: the top must lie above the sole and the crown")

    @property
    def profile(self) -> Profile:
        """Profile of the rail."""
        return as_profile(self.rail)

    @property
    def sides(self) -> tuple[float, ...]:
        """Sign of y of each pole, the left one first."""
        return (1.0, -1.0)[: self.poles]

    def sole(self, y: ArrayLike) -> Array:
        """Height z [m] of the sole in the shoe's own frame at `y` [m], any shape."""
        y, end = reals("y", y), self.conforming_to
        worn = self.profile.height(np.clip(y, -end, end) if self.poles == 2 else np.minimum(y, end))
        return np.asarray(worn + self.relief_slope * np.maximum(np.abs(y) - end, 0.0))

    def grid(self, spacing: float | Sequence[float] = 3e-3) -> ContactGrid:
        """The potential contact: equal cells that fill the conforming strip of every pole exactly.

        Regular in the shoe's own x and in the arc length of its sole, which for the centred shoe are
        those of the rail; the gap of the centred shoe is exactly zero. Both poles have as many cells, which
        differ in width where the two sides of the rail do.

        Parameters
        ----------
        spacing : float or (dx, dy) [m]
            Cell size wanted; whole numbers of cells come as close as they can.
        """
        found = _mtb_rs.pole_shoe_grid(self.profile._core, self, spacing_pair(spacing))
        grid = contact_grid(found, ("left", "right")[: self.poles])
        # its places are those in the shoe's own frame
        return grid if self.lateral == 0.0 or self.yaw != 0.0 else grid.on_arc()
