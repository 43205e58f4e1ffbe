# SPDX-License-Identifier: MIT OR Apache-2.0
"""Roughness as a layer between bodies that are smooth otherwise."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..base.check import positive, reals, shortened
from ..base.plain import plain
from ..base.progress import shares_shown
from ..base.stored import stored
from ..base.units import taking_quantities
from ..bodies.material import Material
from ..bodies.simple import Simple, as_body, without_layers
from ..friction.rough_law import RoughLaw
from ..geometry.contact_points import spacing_pair
from .normal import solve_normal

Array = NDArray[np.float64]

#: Loads of a law, and the pressures of the first and the last one over the rms slope times the contact
#: modulus: from the first tips to a fourth of the area in contact.
LOADS, FIRST, LAST = 25, 1e-4, 0.12
#: Distance of the first touch in lengths, where an exponential law is given none.
TOUCHES_AT = 12.0


@stored
@dataclass(frozen=True)
@plain
class RoughLayer(RoughLaw):
    """Roughness as a layer, `normal_layer` of contacts: its mean pressure over the distance of the planes.

    Between the points of a table the distance is linear in ``ln(1 + p / p1)``, with its second pressure p1.
    `gap` of a contact counts from the first touch of the tips, `height` above the mean planes.

    A contact with a rough layer and with the same roughness in its gap counts the roughness twice.

    Parameters
    ----------
    gap : (k,) [m]
        Distances of the mean planes, falling from that of the first touch.
    pressure : (k,) [Pa]
        Mean pressures there, rising from 0. A contact with a pressure beyond the last one is refused.
    tangential_ratio : float or None [-]
        Tangential over normal stiffness of the layer before points slip; for like bodies it is Mindlin's
        ``2 (1 - nu) / (2 - nu)`` [Campana2011]. As `normal_layer` of a contact the layer acts along the
        normal alone: :meth:`interface_layer` makes of the ratio the `layer` in which tractions shear it.
    is_exponential : bool
        Whether the law is the exponential one; see :meth:`exponential`.

    Examples
    --------
    >>> import mtb_rs as mtb
    >>> layer = mtb.RoughLayer.exponential(contact_pressure=5e9, length=0.5e-6)
    >>> f"{float(layer.opening(1e6)) * 1e6:.2f}"
    '1.76'
    """

    @classmethod
    @taking_quantities
    def exponential(
        cls,
        contact_pressure: float,
        length: float,
        height: float | None = None,
        tangential_ratio: float | None = None,
    ) -> RoughLayer:
        """The law ``p = contact_pressure (exp(-g / length) - exp(-height / length))`` of the distance g.

        Parameters
        ----------
        contact_pressure : float [Pa]
            Pressure extrapolated to the mean planes on each other, a part of the contact modulus
            [Persson2007].
        length : float [m]
            Distance over which the pressure falls by a factor e; about half the rms height.
        height : float [m]
            Distance of the first touch; by default 12 lengths.
        tangential_ratio : float or None [-]
            As of :class:`RoughLayer`.
        """
        top = positive("contact_pressure", contact_pressure, "Pa")
        length = positive("length", length, "m")
        height = TOUCHES_AT * length if height is None else positive("height", height, "m")
        floor = top * np.exp(-height / length)
        if floor == 0.0:
            raise ValueError(
                f"height is {height:g} m, {height / length:.3g} lengths: at most 700 are needed, as the "
                "pressure there is 0 in floating-point numbers"
            )
        return cls([height, height - length], [0.0, floor * np.expm1(1.0)], tangential_ratio, True)

    @classmethod
    @taking_quantities
    def from_surface(
        cls,
        heights: ArrayLike,
        spacing: float | Sequence[float],
        *,
        lower: Material | Simple,
        upper: Material | Simple,
        pressures: ArrayLike | None = None,
        hardness: float | None = None,
        progress: Callable[[float], Any] | Literal[True] | None = None,
    ) -> RoughLayer:
        """The layer that a measured rough surface is on a smooth one, by :func:`mtb_rs.solve_normal`.

        The surface is taken as one period. The distance of the mean planes is then free of the bodies' own
        displacement, which the contact with the layer has.

        Parameters
        ----------
        heights : (ny, nx) [m]
            Of the surface, or the sum of those of both.
        spacing : float or (float, float) [m]
            Sides of its cells, some ten to the shortest wave for pressures that do not change any more.
        lower, upper : Material, HalfSpace or Rigid
        pressures : (k,) [Pa]
            Mean pressures at which it is solved, rising; by default 25, from the first tips to about a
            fourth of the area in contact.
        hardness : float or None [Pa]
            As of :func:`mtb_rs.solve_normal`.
        progress : function of the share that is done, True (a bar) or None

        Raises
        ------
        ValueError
            For bad input, such as a surface that is smooth.
        ConvergenceError
            If a load was not solved.
        """
        height = reals("heights", heights, "m")
        if height.ndim != 2 or min(height.shape) < 3 or np.ptp(height) == 0.0:
            raise ValueError(
                f"heights is {shortened(heights)}: at least 3 x 3 heights (ny, nx) [m] that are not all "
                "equal are needed"
            )
        sides = spacing_pair(spacing)
        bodies = without_layers(
            [as_body("lower", lower), as_body("upper", upper)], "the layer of a rough surface"
        )
        elastic = [body.material for body in bodies if body.material is not None]
        if not elastic:
            raise ValueError("both bodies are rigid: one of them must be elastic")
        modulus = 1.0 / sum(1.0 / material.plane_strain_modulus for material in elastic)
        if pressures is None:
            slopes = [
                (np.roll(height, -1, axis) - height) / side for axis, side in ((1, sides[0]), (0, sides[1]))
            ]
            scale = modulus * float(np.sqrt(sum(np.mean(slope**2) for slope in slopes)))
            loads = np.geomspace(FIRST * scale, LAST * scale, LOADS)
        else:
            loads = reals("pressures", pressures, "Pa")
            if loads.ndim != 1 or not loads.size or loads[0] <= 0.0 or np.any(np.diff(loads) <= 0.0):
                raise ValueError(
                    f"pressures is {shortened(pressures)}: positive pressures [Pa] that rise are needed"
                )
        if hardness is not None and positive("hardness", hardness, "Pa") <= loads[-1]:
            raise ValueError(
                f"hardness is {hardness:g} Pa: more than the largest mean pressure of {loads[-1]:.4g} Pa is "
                "needed, or smaller pressures"
            )
        gap = height.max() - height
        area = height.size * sides[0] * sides[1]
        apart = [float(gap.mean())]
        with shares_shown(progress, "rough layer") as tell:
            for number, pressure in enumerate(loads, start=1):
                found = solve_normal(
                    gap, sides, lower=bodies[0], upper=bodies[1], force=float(pressure) * area, periodic=True,
                    hardness=hardness,
                )  # fmt: skip
                apart.append(float(gap.mean() - found.approach))
                tell(number / len(loads))
        normal = sum((1.0 - m.poisson_ratio) / m.shear_modulus for m in elastic)
        along = sum((1.0 - 0.5 * m.poisson_ratio) / m.shear_modulus for m in elastic)
        return cls(apart, [0.0, *loads.tolist()], normal / along)
