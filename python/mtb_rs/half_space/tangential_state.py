# SPDX-License-Identifier: MIT OR Apache-2.0
"""The state that a shift or a transient step leaves behind."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..base.check import pair, reals
from ..base.owning import owning
from ..base.plain import plain
from ..base.stored import stored
from .pressure_field import PressureField

Array = NDArray[np.float64]
Pair = tuple[float, float]


@stored
@owning
@dataclass(frozen=True)
@plain
class TangentialState:
    """State after a step, from which the next one starts: plain arrays that can be saved.

    Attributes
    ----------
    traction : (2, ny, nx) [Pa]
        On the lower body.
    pressure : (ny, nx) [Pa]
    coefficient : (ny, nx) [-]
        Coefficient of friction that the particles carry.
    origin, spacing : (float, float) or None [m]
        Of the grid, as of :class:`PressureField`. With them a state may be followed by a step on another grid
        whose cells lie on the same lines; without (as of older files) the next grid must have the same shape
        and is taken for the same.
    accumulated_plastic_slip : (ny, nx) or None [m]
        Of the particles, in a :class:`PlasticLayer`; None where no layer yields.
    """

    traction: Array
    pressure: Array
    coefficient: Array
    origin: Pair | None = None
    spacing: Pair | None = None
    accumulated_plastic_slip: Array | None = None

    def __post_init__(self) -> None:
        shape = np.shape(self.pressure)
        of_particles = ("accumulated_plastic_slip",) if self.accumulated_plastic_slip is not None else ()
        for name in ("pressure", "coefficient", *of_particles):
            values = reals(f"state.{name}", getattr(self, name))
            if values.ndim != 2 or values.shape != shape or np.any(values < 0.0):
                raise ValueError(
                    f"state.{name} has shape {values.shape} and the least value {values.min():g}: "
                    "(ny, nx) like the pressure, nowhere negative, is needed"
                )
            object.__setattr__(self, name, values)
        traction = reals("state.traction", self.traction, "Pa")
        if traction.shape != (2, *shape):
            raise ValueError(f"state.traction has shape {traction.shape}: {(2, *shape)} is needed")
        object.__setattr__(self, "traction", traction)
        for name in ("origin", "spacing"):
            if getattr(self, name) is not None:
                object.__setattr__(self, name, pair(f"state.{name}", getattr(self, name), "m"))

    def cells_before(self, field: PressureField) -> tuple[int, int]:
        """Rows and columns that the first cell of this state lies after that of `field`.

        Raises
        ------
        ValueError
            If the cells of the two do not lie on the same lines.
        """
        shape = field.pressure.shape
        if self.origin is None or self.spacing is None:
            if self.pressure.shape != shape:
                raise ValueError(
                    f"state has shape {self.pressure.shape}, the pressure has {shape}: a state without "
                    "origin and spacing belongs to the same grid"
                )
            return 0, 0
        if not np.allclose(self.spacing, field.spacing, rtol=1e-9, atol=0.0):
            raise ValueError(
                f"state has cells of {self.spacing} m, the pressure has {field.spacing} m: "
                "they must be the same"
            )
        moved = [(a - b) / d for a, b, d in zip(self.origin, field.start, field.spacing, strict=True)]
        whole = [round(cells) for cells in moved]
        if any(abs(a - b) > 1e-6 for a, b in zip(moved, whole, strict=True)):
            raise ValueError(
                f"state begins at {self.origin} m, {moved[0]:.6g} and {moved[1]:.6g} cells from the grid of "
                "the pressure: whole numbers of cells are needed"
            )
        return whole[1], whole[0]
