# SPDX-License-Identifier: MIT OR Apache-2.0
"""Prisms under rows of cells: what they do beside half-spaces of their materials."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from .. import _mtb_rs
from ..base import memory
from ..base.differences import by_constant
from ..bodies.prism import Prism, UnderRows, too_thin
from ..bodies.simple import prism_of

Array = NDArray[np.float64]

#: Cosine of the angle of a running surface below which its material is on the other side: gauge faces and
#: flanks may overhang a little.
OVERHANG = -0.2
#: Angle [rad] by which surfaces that touch may be turned against each other at the nearest row, as on facets.
FACING = 0.2


@dataclass(frozen=True)
class Prisms:
    """Two bodies under rows of cells, of which one or both are prisms.

    Attributes
    ----------
    lower, upper : Prism or None
        None for a body that is none.
    first : float [m]
        y of the first row.
    shape : (ny, nx)
    spacing : (float, float) [m]
    """

    lower: Prism | None
    upper: Prism | None
    first: float
    shape: tuple[int, int]
    spacing: tuple[float, float]

    @property
    def _places(self) -> tuple[_Place | None, ...]:
        """Each prism, as the section under the rows is asked for."""
        bodies = ((self.lower, False), (self.upper, True))
        ny = self.shape[0]
        return tuple(
            None if body is None else _Place(body, is_upper, self.first, ny, self.spacing[1])
            for body, is_upper in bodies
        )

    @cached_property
    def _angles(self) -> tuple[Array | None, ...]:
        """Of the surface of each prism at each row."""
        angles = tuple(None if place is None else _under(place).angles for place in self._places)
        _check_sides(*angles)
        return angles

    @cached_property
    def _rows(self) -> tuple[_mtb_rs.PrismRows | None, ...]:
        """What the rows of each prism do to each other."""
        nx, dx = self.shape[1], self.spacing[0]
        both = zip(self._places, self._angles, strict=True)
        return tuple(
            None if place is None or angles is None else _rows(place, nx, dx) for place, angles in both
        )

    @cached_property
    def core(self) -> _mtb_rs.PrismPair:
        """Both, as the core takes them."""
        return _mtb_rs.PrismPair(*self._rows)

    @property
    def angles(self) -> Array:
        """(ny,) [rad] of the surface at each row, positive where it rises along +y; of the lower body, if it
        is a prism."""
        return next(angles for angles in self._angles if angles is not None)

    @cached_property
    def normal(self) -> _mtb_rs.NormalPrisms:
        """What pressure and tractions do to the gap on all rows of cells."""
        return self.core.normal(self.shape[::-1], self.spacing)

    @property
    def notes(self) -> tuple[str, ...]:
        """What there is to say of each."""
        known = (rows.waves for rows in self._rows if rows is not None)
        return tuple(
            f"A prism has {unknowns} unknowns in its section, for each of {count} waves of up to "
            f"{largest:.3g} 1/m; the shortest of them add {tail:.1g} of what a row of cells moves by its "
            "own load."
            for count, largest, tail, unknowns in known
        )

    @property
    def questions(self) -> list[str]:
        """What there is to ask of their sections."""
        return [question for rows in self._rows if rows is not None for question in too_thin(rows.waves[2])]

    def varied(self, modulus: str) -> list[tuple[float, Prism, Prisms]]:
        """Other values of a modulus, as ``"lower.young_modulus"``: the weight of each in the derivative by
        it, the prism, and both.

        Raises
        ------
        ValueError
            Where these bodies are known by other numbers of waves, between which nothing is smooth.
        """
        side, _, name = modulus.partition(".")
        body: Prism = getattr(self, side)
        for values in by_constant(name, body.constant(name)):
            bodies = [(weight, body.with_constant(name, value)) for weight, value in values]
            terms = [(weight, other, self._with(side, other)) for weight, other in bodies]
            if len({both._waves for *_, both in terms}) == 1:
                return terms
        raise ValueError(
            f"the {side} body is a Prism, and a small change of its {name} changes the number of waves that "
            "it is known by: take differences of results"
        )

    def _with(self, side: str, body: Prism) -> Prisms:
        return replace(self, lower=body) if side == "lower" else replace(self, upper=body)

    @property
    def _waves(self) -> tuple[int, ...]:
        return tuple(rows.waves[0] for rows in self._rows if rows is not None)

    def opened_by(self, modulus: str, load: Array) -> Array:
        """Gap (ny, nx) [m] that tractions on the lower body and a pressure (3, ny, nx) [Pa] open for a unit
        more of a modulus of one prism, as ``"lower.young_modulus"``."""
        ny, nx = self.shape
        # on the upper body tractions act turned round
        sign = 1.0 if modulus.startswith("lower") else -1.0
        on_body = load.reshape(3, -1) * [[sign], [sign], [1.0]]
        opened = np.zeros(self.shape)
        for weight, body, both in self.varied(modulus):
            beside = _mtb_rs.half_space(body.elastic, [(0.0, 0.0, nx, ny)], self.spacing, True)
            opened += weight * beside.displacement(on_body)[2].reshape(self.shape)
            opened += weight * both.normal.opening(load)
        return opened

    @property
    def moduli(self) -> list[str]:
        """Names of the moduli of the prisms, as ``"lower.young_modulus"``."""
        sides = {"lower": self.lower, "upper": self.upper}
        prisms = {side: body for side, body in sides.items() if body is not None}
        return [f"{side}.{name}" for side, body in prisms.items() for name in body.constants]


def _check_sides(lower: Array | None, upper: Array | None) -> None:
    """Refuses bodies that lie on one side, by the angles of their surfaces at each row."""
    for side, angles, other in (("lower", lower, "above"), ("upper", upper, "below")):
        if angles is not None and np.cos(angles[angles.size // 2]) < OVERHANG:
            raise ValueError(
                f"the material of the {side} body, a Prism, lies {other} its running surface: the lower body "
                "lies below the contact, as rails of a profile do; the upper body is a rectangle, or a Prism "
                "of points whose material lies above"
            )
    if lower is None or upper is None:
        return
    turned = upper - lower
    if turned.min() > FACING or turned.max() < -FACING:
        least = float(np.abs(turned).min())
        raise ValueError(
            f"the running surfaces of the two prisms are turned against each other by {least:.2g} rad and "
            "more at all rows of cells: where they touch they have one normal; origin says where on each of "
            "them the cells have y = 0"
        )


class _Place(NamedTuple):
    """A prism under so many rows of cells of a width [m], the first of them at a y [m]."""

    body: Prism
    is_upper: bool
    first: float
    rows: int
    width: float


@lru_cache(maxsize=8)
def _under(place: _Place) -> UnderRows:
    middle = place.first + 0.5 * (place.rows - 1) * place.width
    return place.body.under_rows(place.rows, place.width, middle, upper=place.is_upper)


@lru_cache(maxsize=8)
def _rows(place: _Place, nx: int, dx: float) -> _mtb_rs.PrismRows:
    return _mtb_rs.PrismRows(*_under(place).core, (nx, place.rows), (dx, place.width))


@lru_cache(maxsize=4)
def _prisms(*of: Any) -> Prisms:
    return Prisms(*of)


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
