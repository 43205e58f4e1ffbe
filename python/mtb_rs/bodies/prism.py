# SPDX-License-Identifier: MIT OR Apache-2.0
"""Infinitely long elastic bodies of one cross-section, such as rails."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from .. import _mtb_rs
from ..base.check import pair, positive, shortened
from ..base.plain import plain
from ..base.stored import stored
from ..geometry.contact_points import ContactPoints, Patch
from ..geometry.profiles import Profile, as_profile
from .material import Material, steel

Array = NDArray[np.float64]

#: Elements between two rows of contact points: under a shoe, on cells of 3 and 6 mm, a rail with two is 0.3 %
#: off one with four, and with one 0.6 to 1 %.
PARTS = 2
#: Share of a cell by which contact points may lie off the surface of a prism.
OFF = 1e-3

_NO_DERIVATIVES = (
    "this body is a Prism, and derivatives by its moduli are not known: take differences of results"
)

#: What takes a prism, and what does not.
BELOW = (
    "a Prism is the lower body of scenes whose contact rows lie along it: pole_shoe_on_rail(lower=...), "
    'block_on_plane(lower=...) and Scene(lower=...), with model="half-space" or "elastic-upper"'
)


@stored
@dataclass(frozen=True)
@plain
class KeptPrism:
    """What a saved result keeps of a prism: all but its section."""

    material: Material
    foundation: tuple[float, float] | None
    #: It is no half-space, and what takes half-spaces only refuses it.
    is_half_space: ClassVar[bool] = False
    mean_compliance: ClassVar[float] = 0.0
    moduli: ClassVar[tuple[str, ...]] = ()
    without_derivatives: ClassVar[Mapping[str, str]] = MappingProxyType(
        dict.fromkeys(("young_modulus", "poisson_ratio"), _NO_DERIVATIVES)
    )
    without_stress: ClassVar[str] = "is a Prism: the stress inside its section is not known"

    def described(self) -> dict[str, Any]:
        """What `summary.json` tells of it."""
        return {"kind": "Prism", "material": self.material, "foundation": self.foundation}

    def kept(self) -> KeptPrism:
        """What a saved result keeps of it: all."""
        return self


@dataclass(frozen=True)
@plain
class Prism:
    """An infinitely long elastic body of one cross-section, along x: a rail without ends, or a bar.

    Its section is divided into quadratic triangles, and solved wave by wave along x. It is the elastic rail
    without the ends of a piece of rail, at a fraction of its cost.

    Parameters
    ----------
    profile : str, Profile or (width, height) [m]
        Running surface of a rail, whose web and foot are those of 60E1; or a rectangle with its top at
        z = 0, symmetric about y = 0.
    material : Material
    foundation : (vertical, lateral) [N/m2] or None
        Stiffness per length of the springs on which the base stands, spread over its width; the lateral one
        holds along x as well. None: the base does not move.

    Raises
    ------
    ValueError
        For sizes and stiffnesses that are not positive.

    Examples
    --------
    >>> import mtb_rs as mtb
    >>> rail = mtb.Prism("60E1", foundation=(1e8, 3e7))
    >>> scene = mtb.scenes.pole_shoe_on_rail(lower=rail, spacing=6e-3)

    Notes
    -----
    Of a section that is solved at wave numbers k the compliance of the contact rows differs from that of a
    half-space by what is smooth: few waves are enough, and what is local is in closed form.
    """

    profile: Any
    material: Material = steel
    foundation: tuple[float, float] | None = None
    is_half_space: ClassVar[bool] = KeptPrism.is_half_space
    mean_compliance: ClassVar[float] = KeptPrism.mean_compliance
    moduli: ClassVar[tuple[str, ...]] = KeptPrism.moduli
    without_derivatives: ClassVar[Mapping[str, str]] = KeptPrism.without_derivatives
    without_stress: ClassVar[str] = KeptPrism.without_stress

    def __post_init__(self) -> None:
        put = object.__setattr__
        if not isinstance(self.material, Material):
            raise ValueError(f"material of a prism is {shortened(self.material)}: a Material is needed")
        if self.material.poisson_ratio >= 0.5:
            raise ValueError("Poisson's ratio of a prism is 0.5: finite elements need less than 0.5")
        if isinstance(self.profile, (str, Profile)):
            put(self, "profile", as_profile(self.profile))
        else:
            width, height = pair("profile", self.profile, "m")
            put(self, "profile", (positive("width", width, "m"), positive("height", height, "m")))
        if self.foundation is not None:
            vertical, lateral = pair("foundation", self.foundation, "N/m2")
            put(
                self,
                "foundation",
                (positive("vertical", vertical, "N/m2"), positive("lateral", lateral, "N/m2")),
            )

    @property
    def normal_compliance(self) -> float:
        """(1 - nu) / G [1/Pa] of its material."""
        return (1.0 - self.material.poisson_ratio) / self.material.shear_modulus

    @property
    def plane_strain_compliance(self) -> float:
        """(1 - nu^2) / E [1/Pa] of its material."""
        return 0.5 * self.normal_compliance

    def height(self, y: Array) -> Array:
        """Height z [m] of the running surface."""
        if isinstance(self.profile, Profile):
            return self.profile.height(y)
        return np.zeros_like(y)

    def _beside(self, y: Array, step: float) -> Array:
        """Places (y) a `step` [m] along the surface from others."""
        if isinstance(self.profile, Profile):
            return np.asarray(self.profile.position(self.profile.arc_length(y) + step))
        return np.asarray(y + step)

    def on(self, points: ContactPoints, patches: Sequence[Patch], *, hats: bool) -> OnPrism:
        """The body under the hats of contact points that are nodes of patches, or under cells about them.

        Raises
        ------
        ValueError
            For rows that do not lie along the prism, and points that are not on its surface.
        """
        lines = []
        for patch in patches:
            x, y, z = (patch.view(p) for p in points.points)
            near = OFF * min(patch.spacing)
            if np.ptp(y, axis=1).max() > near or np.ptp(x, axis=0).max() > near:
                raise ValueError(
                    "the contact rows are turned against the prism, whose rows lie along x: yaw=0, or a "
                    "half-space or an elastic rail, is needed"
                )
            rows = y.mean(axis=1)
            off = float(np.abs(z - self.height(y)).max())
            if off > near:
                raise ValueError(
                    f"the contact points lie up to {off:.3g} m off the surface of {self!r}: its profile must "
                    "be that of the scene (of flat contacts, a rectangle)"
                )
            if not hats:
                half = 0.5 * patch.spacing[1]
                rows = np.append(self._beside(rows[:1], -half), self._beside(rows, half))
            lines.append(np.ascontiguousarray(rows))
        profile = self.profile
        if isinstance(profile, Profile):
            section = _mtb_rs.rail_section(profile._core, lines, PARTS)
        else:
            section = _mtb_rs.block_section(profile, lines, PARTS)
        compliance, (waves, largest, tail, unknowns) = _mtb_rs.prism(
            (self.material.shear_modulus, self.material.poisson_ratio),
            section,
            self.foundation,
            [(*p.origin, p.nx, p.ny) for p in patches],
            [p.spacing for p in patches],
            lines,
            hats,
        )
        return OnPrism(compliance, waves, largest, tail, unknowns)

    def described(self) -> dict[str, Any]:
        """What `summary.json` tells of it."""
        profile = self.profile.name if isinstance(self.profile, Profile) else self.profile
        return {
            "kind": "Prism",
            "profile": profile,
            "material": self.material,
            "foundation": self.foundation,
        }

    def kept(self) -> KeptPrism:
        """What a saved result keeps of it: all but its section."""
        return KeptPrism(self.material, self.foundation)


@dataclass(frozen=True)
class OnPrism:
    """A prism under contact points.

    Attributes
    ----------
    compliance : Compliance
    waves : int
        Wave numbers that it is known by.
    largest : float [1/m]
        The largest of them.
    tail : float [-]
        Share of the own displacement of any row that the last range of waves adds: about what is left out.
    unknowns : int
        Displacements of its section.
    """

    compliance: _mtb_rs.Compliance
    waves: int
    largest: float
    tail: float
    unknowns: int

    @property
    def note(self) -> str:
        """What there is to say of it."""
        return (
            f"The prism has {self.unknowns} unknowns in its section, for each of {self.waves} waves of up to "
            f"{self.largest:.3g} 1/m; the shortest of them add {self.tail:.1g} of what a row of points moves "
            "by its own load."
        )
