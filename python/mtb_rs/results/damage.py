# SPDX-License-Identifier: MIT OR Apache-2.0
"""Numbers by which rolling contact is judged for wear, cracks and plastic flow."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..base.check import positive, reals
from ..base.plain import plain
from ..base.units import taking_quantities

Array = NDArray[np.float64]

#: Energy per distance [N] at which cracks begin, grow fastest, and are worn off as fast as they grow; as
#: commonly quoted of [Burstow2004], not compared with the print.
BEGINS, WORST, WORN = 15.0, 65.0, 175.0


@dataclass(frozen=True)
@plain
class Rolled:
    """What a patch carries, for the numbers of damage.

    Attributes
    ----------
    force : (2,) [N]
        Creep force.
    spin_moment : float [N m]
    normal_force : float [N]
    creepage : (3,) [-], [-], [1/m]
    peak : float [Pa]
        Largest pressure.
    """

    force: Array
    spin_moment: float
    normal_force: float
    creepage: Array
    peak: float


class Damaged:
    """A patch in rolling, from which damage is estimated."""

    def _rolled(self) -> Rolled:
        raise NotImplementedError

    def t_gamma(self, with_spin: bool = False) -> float:
        """Energy per distance rolled [N], T gamma: force times creepage, along x and along y.

        ``|Fx xi| + |Fy eta|``, and ``|Mz phi|`` if spin is to count, which most limits of wear and rolling
        contact fatigue leave out. `dissipation` has the exact distribution of the heat, whose sum is the work
        of both with their signs.

        Parameters
        ----------
        with_spin : bool

        Raises
        ------
        ValueError
            For a shift, which passes over nothing.
        """
        rolled = self._rolled()
        energy = float(np.abs(rolled.force * rolled.creepage[:2]).sum())
        return energy + (abs(rolled.spin_moment * float(rolled.creepage[2])) if with_spin else 0.0)

    def surface_fatigue_index(self, shear_yield: float) -> float:
        """FI_surf [-] of surface-initiated fatigue: above 0 cracks begin [EkbergKaboAndersson2002].

        Creep force over normal force, less the yield stress in shear over the peak pressure. On a Hertzian
        ellipse with semi-axes a and b the latter is ``2 pi a b k / (3 Fz)``, as the index is published; on
        other patches the peak pressure is that of the solution.

        Parameters
        ----------
        shear_yield : float [Pa]
            Yield stress k in cyclic shear, of the hardened surface.

        Raises
        ------
        ValueError
            For a shift, and for a patch without pressure.
        """
        friction, load = self.shakedown(shear_yield)
        return friction - 1.0 / load

    def shakedown(self, shear_yield: float) -> tuple[float, float]:
        """The patch as a point of the shakedown map: (creep force over normal force, peak pressure over k).

        A line contact that slips in full shakes down to elastic strains below a load of 4 for a friction of
        up to 1/4, and of 1 over the friction above [JohnsonJefferis1963]. A point contact bears more below
        0.3, and the same above.

        Parameters
        ----------
        shear_yield : float [Pa]
            Yield stress k in shear.

        Raises
        ------
        ValueError
            As :meth:`surface_fatigue_index`.
        """
        yielding = positive("shear_yield", shear_yield, "Pa")
        rolled = self._rolled()
        if not rolled.normal_force > 0.0:
            raise ValueError("the patch carries no pressure")
        return float(np.hypot(*rolled.force)) / rolled.normal_force, rolled.peak / yielding


@taking_quantities
def rail_damage(t_gamma: ArrayLike) -> Array:
    """Damage of a rail in one passage over the largest one [-], by the whole-life rail model [Burstow2004].

    Cracks begin above 15 N of `t_gamma`, grow fastest at 65 N, where the number is 1, and are worn off as
    fast as they grow at 175 N; below zero wear prevails. Straight between these, and beyond the last on the
    same line. The numbers are as commonly quoted for rails of grade R220, and not compared with the print.

    Parameters
    ----------
    t_gamma : any shape [N]
        Energy per distance rolled, without spin.
    """
    energy = reals("t_gamma", t_gamma, "N")
    if (energy < 0.0).any():
        raise ValueError(f"t_gamma is {float(energy.min()):g} N: numbers of at least 0 are needed")
    rising = np.clip((energy - BEGINS) / (WORST - BEGINS), 0.0, None)
    return np.asarray(np.minimum(rising, (WORN - energy) / (WORN - WORST)))
