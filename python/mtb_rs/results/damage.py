# SPDX-License-Identifier: MIT OR Apache-2.0
"""Numbers by which rolling contact is judged for wear, cracks and plastic flow."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..base.check import positive, reals
from ..base.plain import plain
from ..base.questions import ask
from ..base.units import taking_quantities
from .doors import pictures

Array = NDArray[np.float64]

#: Energy per distance [N] at which cracks begin, grow fastest, and are worn off as fast as they grow; as
#: commonly quoted of [Burstow2004], not compared with the print.
BEGINS, WORST, WORN = 15.0, 65.0, 175.0
#: Yield stress in shear [Pa] below which it is asked about.
SOFTEST = 1e6


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
    pressure : (ny, nx) [Pa]
    by_rigid_slip : (2,) [N]
        Energy per distance that the traction takes, along x and y, from a rigid slip given cell by cell.
    """

    force: Array
    spin_moment: float
    normal_force: float
    creepage: Array
    pressure: Array
    by_rigid_slip: Array = field(default_factory=lambda: np.zeros(2))


class Damaged:
    """A patch in rolling, from which damage is estimated."""

    def _rolled(self) -> Rolled:
        raise NotImplementedError

    def t_gamma(self, with_spin: bool = False) -> float:
        """Energy per distance rolled [N], T gamma: force times creepage, along x and along y.

        ``|Fx xi| + |Fy eta|``, and ``|Mz phi|`` if spin is to count, which most limits of wear and rolling
        contact fatigue leave out. `dissipation` has the exact distribution of the heat. Its sum is the work
        of both with their signs between like bodies; between unlike ones the pressure moves the surfaces
        along each other and does work as well, which is no part of T gamma: a third of the heat between
        steel and a body of 150 GPa. Bodies that creep take more from the traction than friction turns into
        heat. A rigid slip that is given cell by cell counts as creepage does.

        Parameters
        ----------
        with_spin : bool

        Raises
        ------
        ValueError
            For a shift, which passes over nothing.
        """
        rolled = self._rolled()
        energy = float(np.abs(rolled.force * rolled.creepage[:2] + rolled.by_rigid_slip).sum())
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

        A line contact that slips in full shakes down to elastic strains below a load of 4 without friction,
        2.9 at 0.3, and 1 over the friction above 0.367 [JohnsonJefferis1963]; :meth:`plot_shakedown` draws
        it. A point contact bears more where its inside yields first, and the same where its surface does.

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
        if yielding < SOFTEST:
            ask(
                [
                    f"shear_yield is {yielding:g} Pa: metals yield in shear at 1e7 Pa and more, and stresses "
                    "are in pascals (300 MPa are 300e6)"
                ]
            )
        rolled = self._rolled()
        if not rolled.normal_force > 0.0:
            raise ValueError("the patch carries no pressure")
        return float(np.hypot(*rolled.force)) / rolled.normal_force, float(rolled.pressure.max()) / yielding

    def plot_shakedown(self, shear_yield: float, ax: Any = None) -> Any:
        """The patch on the shakedown map, with the limits of a line contact; returns the figure.

        Parameters
        ----------
        shear_yield : float [Pa]
            Yield stress k in shear.
        ax : matplotlib.axes.Axes or None
            Of another such picture, to which the point is added, or for a new one.

        Raises
        ------
        ValueError
            As :meth:`surface_fatigue_index`.
        """
        return pictures().draw_shakedown(*self.shakedown(shear_yield), ax)


#: Cells of a half width from which the largest stresses below a line contact are taken.
_CELLS = 200


@cache
def _line_contact() -> tuple[Array, Array]:
    """Stresses xx, zz and xz (3, nz, nx) below a line contact, over the peak pressure, by the pressure and by
    a traction equal to it along x [McEwen1949; Johnson1985, eq. 4.49 and 7.5]."""
    x = np.arange(-2 * _CELLS, 2 * _CELLS + 1) / _CELLS
    z = np.arange(0, 2 * _CELLS + 1)[:, None] / _CELLS
    inner = 1.0 - x**2 + z**2
    root = np.sqrt(inner**2 + 4.0 * x**2 * z**2)
    m, n = np.sqrt(0.5 * (root + inner)), np.copysign(np.sqrt(np.clip(0.5 * (root - inner), 0.0, None)), x)
    square = m**2 + n**2
    # the edge of the contact, where all of them vanish
    ratio = np.divide(z**2 + n**2, square, out=np.ones_like(square), where=square > 0.0)
    other = np.divide(m**2 - z**2, square, out=np.ones_like(square), where=square > 0.0)
    shear = -n * other
    pressed = np.array([-(m * (1.0 + ratio) - 2.0 * z), -m * (1.0 - ratio), shear])
    return pressed, np.array([n * (2.0 + other) - 2.0 * x, shear, pressed[0]])


def _limit(friction: Array, shear: Callable[[Array, Array, Array], Array]) -> Array:
    """Where the largest of a shear stress, of the stresses xx, zz and xz, is k."""
    pressed, dragged = _line_contact()
    return np.array([1.0 / shear(*(pressed + mu * dragged)).max() for mu in friction])


def elastic_limit(friction: Array) -> Array:
    """Peak pressure over yield stress in shear up to which a line contact is elastic, by Tresca's criterion
    [Johnson1985, ch. 4.2 and 7.1]; Poisson's ratio is 0.3.

    Parameters
    ----------
    friction : (n,) [-]
        Traction over pressure, in full slip.
    """

    def shear(xx: Array, zz: Array, xz: Array) -> Array:
        mean, radius = 0.5 * (xx + zz), np.hypot(0.5 * (xx - zz), xz)
        out = 0.4 * mean
        return np.asarray(np.maximum(radius, 0.5 * (np.abs(out) + radius)))

    return _limit(friction, shear)


def shakedown_limit(friction: Array) -> Array:
    """Peak pressure over yield stress in shear up to which a line contact that rolls and slips in full shakes
    down to elastic strains, by Melan's theorem [JohnsonJefferis1963].

    Residual stresses along the surface relieve all but the shear stress xz: its largest value is k. The
    limit is 4 without friction, and 1 over the friction above 0.367, where the surface yields first.

    Parameters
    ----------
    friction : (n,) [-]
        Traction over pressure, in full slip.
    """
    return _limit(friction, lambda xx, zz, xz: np.abs(xz))


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
