# SPDX-License-Identifier: MIT OR Apache-2.0
"""Elastic materials."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import wraps
from typing import Any

from ..base.check import number, positive
from ..base.plain import plain
from ..base.stored import stored

#: Young's moduli [Pa]: up to the first, units are normalised ones; between it and the second only foams,
#: cork and what hardly changes its volume (rubber, gels) are so soft; diamond has half of the third.
NORMALISED, SOFT, STIFF = 10.0, 1e6, 2e12
#: Poisson's ratio from which a material counts as hardly changing its volume.
RUBBERY = 0.45


def _by_two(build: Callable[..., None]) -> Callable[..., None]:
    """A constructor that answers an attempt with the shear modulus."""

    @wraps(build)
    def answered(self: Material, *args: Any, **kwargs: Any) -> None:
        if "shear_modulus" in kwargs:
            raise TypeError(
                "Material takes young_modulus and poisson_ratio; Material.from_shear_modulus takes "
                "shear_modulus and poisson_ratio"
            )
        build(self, *args, **kwargs)

    return answered


@stored
@dataclass(frozen=True, slots=True)
@plain
class Material:
    """Isotropic linear elastic material.

    Parameters
    ----------
    young_modulus : float [Pa]
        Positive.
    poisson_ratio : float [-]
        In (-1, 0.5]; 0.5 itself (incompressible) is for half-spaces only.

    Examples
    --------
    >>> Material.from_shear_modulus(80e9, 0.3).young_modulus
    208000000000.0
    """

    young_modulus: float
    poisson_ratio: float

    def __post_init__(self) -> None:
        object.__setattr__(self, "young_modulus", positive("young_modulus", self.young_modulus, "Pa"))
        object.__setattr__(self, "poisson_ratio", number("poisson_ratio", self.poisson_ratio))
        if not -1.0 < self.poisson_ratio <= 0.5:
            raise ValueError(f"poisson_ratio is {self.poisson_ratio:g}: it must lie in (-1, 0.5]")

    @classmethod
    def from_shear_modulus(cls, shear_modulus: float, poisson_ratio: float) -> Material:
        """Material from its shear modulus [Pa] and Poisson's ratio [-]."""
        positive("shear_modulus", shear_modulus, "Pa")
        cls(1.0, poisson_ratio)  # judge Poisson's ratio by its own name first
        return cls(2.0 * shear_modulus * (1.0 + poisson_ratio), poisson_ratio)

    @property
    def shear_modulus(self) -> float:
        """Shear modulus G = E / (2 (1 + nu)) [Pa]."""
        return self.young_modulus / (2.0 * (1.0 + self.poisson_ratio))

    @property
    def plane_strain_modulus(self) -> float:
        """E / (1 - nu^2) [Pa]."""
        return self.young_modulus / (1.0 - self.poisson_ratio**2)


Material.__init__ = _by_two(Material.__init__)  # type: ignore[method-assign]
#: Steel of both sources' examples: G = 80 GPa, nu = 0.3.
steel = Material(young_modulus=208e9, poisson_ratio=0.3)


def of_material(side: str, material: Material) -> list[str]:
    """A question about a modulus that no material has, which is mostly a slip of the unit."""
    modulus, ratio = material.young_modulus, material.poisson_ratio
    if NORMALISED < modulus < SOFT and ratio < RUBBERY:
        return [
            f"young_modulus of the {side} body is {modulus:g} Pa beside a Poisson's ratio of {ratio:g}: "
            "only foam is so soft, and moduli are in pascals (steel has 208e9)"
        ]
    if modulus > STIFF:
        return [
            f"young_modulus of the {side} body is {modulus:g} Pa: nothing is so stiff, and moduli are in "
            "pascals (steel has 208e9; a half-space that does not deform is Rigid())"
        ]
    return []
