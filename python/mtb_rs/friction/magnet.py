# SPDX-License-Identifier: MIT OR Apache-2.0
"""A magnet whose pull follows the gap: coil, iron, poles in series."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any, ClassVar, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .. import _mtb_rs
from ..base.check import choice, number, positive, reals
from ..base.owning import owning
from ..base.plain import plain
from ..geometry.contact_points import Patch
from .fields import Asked, Form, VelocityTable, as_form

Array = NDArray[np.float64]

Branch = Literal["apart", "touching"]

#: Permeability of vacuum [H/m].
VACUUM = 4e-7 * np.pi

#: The steel of TEAM problem 13: points below 1.8 T, coefficients of B - mu0 H up to 2.22 T, and the
#: saturation polarisation [T].
_BELOW = (
    (0.0, 16.0, 30.0, 54.0, 93.0, 143.0, 191.0, 210.0, 222.0, 233.0, 247.0, 258.0, 272.0, 289.0, 313.0, 342.0,
     377.0, 433.0, 509.0, 648.0, 933.0, 1228.0, 1934.0, 2913.0, 4993.0, 7189.0),
    (0.0, 25e-4, 50e-4, 125e-4, 250e-4, 0.05, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1.0, 1.1, 1.2, 1.3,
     1.4, 1.5, 1.55, 1.6, 1.65, 1.7, 1.75),
)  # fmt: skip
_ABOVE, _SATURATION = (-2.381e-10, 2.327e-5, 1.590), 2.16
#: Fields [A/m] from the last point of the table to where the parabola has its top.
_FROM, _TO, _COUNT = 9423.0, 48866.0, 40


def low_carbon_steel() -> Array:
    """Curve of magnetisation of a low-carbon steel, as (2, n): field [A/m] and flux density [T].

    It is the steel of the TEAM problem 13 [TEAM13]: measured points up to 1.8 T, a parabola of
    ``B - mu0 H`` up to 2.22 T, and a saturation polarisation of 2.16 T beyond.
    """
    field = np.linspace(_FROM, _TO, _COUNT)
    a, b, c = _ABOVE
    density = VACUUM * field + np.minimum(a * field**2 + b * field + c, _SATURATION)
    density[-1] = VACUUM * field[-1] + _SATURATION
    return np.array([[*_BELOW[0], *field], [*_BELOW[1], *density]])


#: Curves of magnetisation by their names.
IRONS = {"low-carbon steel": low_carbon_steel}


@owning
@dataclass(frozen=True)
@plain
class Magnet(Form):
    """A magnet whose pull at each point follows the gap there, in place of a `magnetic_pressure`.

    A coil drives one flux through the poles in series, each of which is a grid of the contact. At a point
    with the gap g of a pole with the magnetomotive force T the flux density B satisfies
    ``T = H(B) pole_length + B (g + non_magnetic_gap) / mu0``, and the magnet pulls with
    ``iron_share B^2 / (2 mu0)``. In this formula B counts up to the saturation polarisation of the iron.
    The forces of all poles and what yoke and armature take add up to `ampere_turns`. [Roters1941],
    [Galardi2015]

    Parameters
    ----------
    ampere_turns : float [A]
        Turns of the coil times its current.
    non_magnetic_gap : float [m]
        Thickness of everything between the irons that is not magnetic: wear plates, coatings, roughness.
    iron : str or (field, flux_density)
        "low-carbon steel" (saturation polarisation 2.16 T), or a curve of magnetisation as two rows of
        numbers, A/m and T. It is straight between its points and from the origin to the first one, and rises
        as in vacuum beyond the last one. A single point is iron of one permeability up to there.
    iron_share : float [-]
        Area of iron at the face of a pole in parts of the area of its contact points. The default, 1, means
        that all of the contact is iron and all iron is contact. Above 1, iron beside the contact, such as
        chamfers, pulls with the flux density of the contact points.
    pole_length : float [m]
        Length of the column of iron above each point.
    yoke : (float, float) [m], [m2] or None
        Length and section of the iron that carries the flux on the side of the coil. None: it takes no
        magnetomotive force.
    armature : (float, float) [m], [m2] or None
        The same of the iron on the other side: the rail.
    leakage : float [H]
        Permeance of the air between the poles. Its flux passes through the yoke, and pulls nothing.
    speed_factor : VelocityTable or None
        Factor on the pull over the sliding velocity: eddy currents weaken the magnet.
    branch : "apart" or "touching"
        Where more than one state exists, whether the one is found that bodies reach from where they stand
        (the gap of the scene) or the one that they keep after they have touched.
    """

    ampere_turns: float
    non_magnetic_gap: float
    iron: str | Sequence[Sequence[float]] | ArrayLike = "low-carbon steel"
    iron_share: float = 1.0
    pole_length: float = 0.0
    yoke: tuple[float, float] | None = None
    armature: tuple[float, float] | None = None
    leakage: float = 0.0
    speed_factor: VelocityTable | None = None
    branch: Branch = "apart"
    is_one: ClassVar[bool] = True
    follows_gap: ClassVar[bool] = True

    def __post_init__(self) -> None:
        put = object.__setattr__
        put(self, "ampere_turns", positive("ampere_turns", self.ampere_turns, "A"))
        put(self, "non_magnetic_gap", positive("non_magnetic_gap", self.non_magnetic_gap, "m"))
        put(self, "iron_share", positive("iron_share", self.iron_share))
        for name, unit in (("pole_length", "m"), ("leakage", "H")):
            value = number(name, getattr(self, name), unit)
            if value < 0.0:
                raise ValueError(f"{name} is {value:g} {unit}: a number from 0 on is needed")
            put(self, name, value)
        for name in ("yoke", "armature"):
            put(self, name, _limb(name, getattr(self, name)))
        choice("branch", self.branch, Branch)
        if isinstance(self.iron, str):
            if self.iron not in IRONS:
                raise ValueError(
                    f"iron is {self.iron!r}: {', '.join(map(repr, IRONS))} or two rows of numbers, field "
                    "[A/m] and flux density [T], are needed"
                )
        else:
            curve = reals("iron", self.iron)
            if curve.ndim != 2 or len(curve) != 2 or not curve.size:
                raise ValueError(
                    f"iron has shape {curve.shape}: two rows of numbers, field [A/m] and flux density [T], "
                    "are needed"
                )
            put(self, "iron", tuple(map(tuple, curve.tolist())))
        self._check_factor()
        # the curve is checked where it is used
        try:
            self.circuit_over(np.ones(1), [1])
        except ValueError as refused:
            if isinstance(self.iron, str):
                raise
            raise ValueError(
                "iron is no curve of magnetisation: from point to point the field [A/m] must rise, and the "
                f"flux density [T] by more than in vacuum, mu0 times the rise of the field; {refused}"
            ) from None

    def _check_factor(self) -> None:
        if self.speed_factor is None:
            return
        form = as_form(self.speed_factor)
        if not list(form.tables()) or form.leaves() is None:
            raise ValueError(f"speed_factor is {self.speed_factor!r}: a VelocityTable of numbers is needed")
        nowhere = Asked("speed_factor", np.empty((3, 0)), (), None, 0.0)
        nowhere.check_range(form.placed("speed_factor"))

    @property
    def curve(self) -> Array:
        """The curve of magnetisation (2, n): field [A/m] and flux density [T]."""
        return IRONS[self.iron]() if isinstance(self.iron, str) else np.array(self.iron)

    @property
    def limit(self) -> float:
        """The largest pressure [Pa] that it can pull with, that of saturated iron."""
        return self.circuit_over(np.ones(1), [1]).limit

    @property
    def from_touching(self) -> bool:
        """Whether its state is looked for from bodies that touch."""
        return self.branch == "touching"

    def circuit(
        self, area: Array, patches: tuple[Patch, ...], kept: NDArray[np.intp] | None
    ) -> _mtb_rs.MagneticCircuit:
        """Its circuit over contact points with areas (n,) [m2], as the core has it."""
        return self.circuit_over(area, points_of_poles(area, patches, kept))

    def circuit_over(self, area: Array, poles: list[int]) -> _mtb_rs.MagneticCircuit:
        """The same over so many points for each pole."""
        field, density = (np.ascontiguousarray(row) for row in self.curve)
        return _mtb_rs.MagneticCircuit(
            field,
            density,
            self.ampere_turns,
            np.ascontiguousarray(area),
            poles,
            self.iron_share,
            self.pole_length,
            self.non_magnetic_gap,
            self.yoke,
            self.armature,
            self.leakage,
        )

    def factor(self, velocity: float | None) -> float:
        """Factor of the speed on its pull."""
        if self.speed_factor is None:
            return 1.0
        asked = Asked("speed_factor", np.zeros((3, 1)), (), velocity)
        return float(as_form(self.speed_factor).values(asked)[0])

    def magnet_numbers(self, velocity: float | None) -> dict[str, Array]:
        """By each of its numbers, changes (..., 10) of what its pull is derived by in the core."""
        units = np.eye(10)
        names = "ampere_turns", "non_magnetic_gap", "iron_share", "pole_length", "leakage"
        found = dict(zip(names, units, strict=False))
        if self.yoke is not None:
            found["yoke"] = units[5:7]
        if self.armature is not None:
            found["armature"] = units[7:9]
        if self.speed_factor is not None:
            here, rows = self.factor(velocity), []
            for leaf in as_form(self.speed_factor).leaves() or ():
                changed = replace(self, speed_factor=leaf.put(leaf.value + 1.0))
                rows.append((changed.factor(velocity) - here) * units[9])
            found["speed_factor"] = np.array(rows)
        return found

    def factor_slope(self, speed: float) -> float:
        """Change [s/m] of its factor with the speed.

        At a velocity of the table it is that below, at the least one that above.
        """
        if self.speed_factor is None or len(self.speed_factor.velocity) < 2:
            return 0.0
        known = self.speed_factor.velocity
        upper = min(max(1, int(np.searchsorted(known, speed))), len(known) - 1)
        low, high = known[upper - 1], known[upper]
        return (self.factor(high) - self.factor(low)) / (high - low)

    def values(self, asked: Asked) -> Array:
        """It has none before the gap is known."""
        raise ValueError(
            f"{asked.name} is a Magnet, whose pull follows the gap: here a number, a field or a table of "
            "these is needed. A Magnet stands alone, for all poles and velocities"
        )

    def tables(self) -> Iterator[VelocityTable]:
        """That of its factor over the velocity."""
        if self.speed_factor is not None:
            yield from as_form(self.speed_factor).tables()


def points_of_poles(area: Array, patches: tuple[Patch, ...], kept: NDArray[np.intp] | None) -> list[int]:
    """How many contact points with areas (n,) [m2] belong to each pole; `kept` are those of the grids."""
    counts = [patch.nx * patch.ny for patch in patches] or [area.size]
    if kept is None:
        return counts
    ends = np.searchsorted(kept, np.cumsum([0, *counts]))
    return [int(count) for count in np.diff(ends)]


def _limb(name: str, given: Any) -> tuple[float, float] | None:
    """Length [m] and section [m2] of a piece of iron."""
    if given is None:
        return None
    try:
        length, area = given
    except (TypeError, ValueError):
        raise ValueError(f"{name} is {given!r}: (length [m], area [m2]) or None is needed") from None
    return positive(f"{name}[0]", length, "m"), positive(f"{name}[1]", area, "m2")
