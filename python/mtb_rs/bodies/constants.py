# SPDX-License-Identifier: MIT OR Apache-2.0
"""Constants of bodies, by which results are derived."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import TYPE_CHECKING, Any, Self

from ..base.differences import by_constant
from .material import Material

#: Those of a material.
MODULI = ("young_modulus", "poisson_ratio")


class OfMaterial:
    """A body that is known by its constants: those of its material, unless it says otherwise."""

    if TYPE_CHECKING:

        @property
        def material(self) -> Material: ...

    @property
    def constants(self) -> tuple[str, ...]:
        """Names of the constants by which results are derived."""
        return MODULI

    @property
    def without_derivatives(self) -> Mapping[str, str]:
        """Constants by which they are not, and why."""
        return {}

    def constant(self, name: str) -> float:
        """Its value [SI]."""
        return float(getattr(self.material, name))

    def with_constant(self, name: str, value: float) -> Self:
        """The same body with another value of a constant."""
        material = replace(self.material, **{name: value})
        changed: Self = replace(self, material=material)  # type: ignore[type-var]
        return changed

    def varied(self, name: str) -> list[tuple[float, Self]]:
        """Bodies with other values of a constant, and the weight of each in the derivative by it of whatever
        is smooth in it."""
        values = next(by_constant(name, self.constant(name)))
        return [(weight, self.with_constant(name, value)) for weight, value in values]


def refused_constants(sides: Mapping[str, Any]) -> dict[str, str]:
    """Constants of bodies, by their sides, by which results are not derived, and why."""
    without = {side: body.without_derivatives for side, body in sides.items()}
    return {f"{side}.{name}": why for side, of_body in without.items() for name, why in of_body.items()}
