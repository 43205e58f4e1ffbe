# SPDX-License-Identifier: MIT OR Apache-2.0
"""Infinitely long elastic bodies of one cross-section, such as rails."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .. import _mtb_rs
from ..base.check import number, pair, positive, reals, shortened
from ..base.plain import plain
from ..base.stored import stored
from ..geometry.contact_points import ContactPoints, Patch
from ..geometry.profiles import Profile, as_profile
from .constants import OfMaterial
from .material import Material, steel

Array = NDArray[np.float64]

#: Elements between two rows of contact points: under a shoe, on cells of 3 and 6 mm, a rail with two is 0.3 %
#: off one with four, and with one 0.6 to 1 %.
PARTS = 2
#: Elements of an outline under a row of cells: coarser ones answer short waves in another way than a
#: half-space, so that more waves are taken, for nothing.
FINE_PARTS = 4
#: Share of what a row moves by its own load, from which waves that are left out are asked about.
LEFT_OUT = 5e-3
#: Share of a cell by which contact points may lie off the surface of a prism.
OFF = 1e-3

#: What takes a prism, and what does not.
BELOW = (
    "a Prism is the lower body of scenes whose contact rows lie along it: pole_shoe_on_rail(lower=...), "
    'block_on_plane(lower=...) and Scene(lower=...), with model="half-space" or "elastic-upper"; either body '
    "of solve_normal, and of solve_tangential after it"
)

Points = tuple[tuple[float, float], ...]


class _OfMaterial(OfMaterial):
    """What its material says of a prism."""

    @property
    def elastic(self) -> tuple[float, float]:
        """Shear modulus [Pa] and Poisson's ratio of its material."""
        return self.material.shear_modulus, self.material.poisson_ratio

    @property
    def normal_compliance(self) -> float:
        """(1 - nu) / G [1/Pa] of its material."""
        return (1.0 - self.material.poisson_ratio) / self.material.shear_modulus

    @property
    def plane_strain_compliance(self) -> float:
        """(1 - nu^2) / E [1/Pa] of its material."""
        return 0.5 * self.normal_compliance


@stored
@dataclass(frozen=True)
@plain
class KeptPrism(_OfMaterial):
    """What a saved result keeps of a prism: all but its section."""

    material: Material
    foundation: tuple[float, float] | None
    #: It is no half-space, and what takes half-spaces only refuses it.
    is_half_space: ClassVar[bool] = False
    elastic_depth: ClassVar[float] = math.inf
    mean_compliance: ClassVar[float] = 0.0
    without_stress: ClassVar[str] = "is a Prism: the stress inside its section is not known"

    def described(self) -> dict[str, Any]:
        """What `summary.json` tells of it."""
        return {"kind": "Prism", "material": self.material, "foundation": self.foundation}

    def kept(self) -> KeptPrism:
        """What a saved result keeps of it: all."""
        return self


@dataclass(frozen=True)
@plain
class Prism(_OfMaterial):
    """An infinitely long elastic body of one cross-section, along x: a rail without ends, or a bar.

    Its section is divided into quadratic triangles, and solved wave by wave along x. It is the elastic rail
    without the ends of a piece of rail, at a fraction of its cost.

    Parameters
    ----------
    profile : str, Profile, (width, height) [m] or (n, 2) [m]
        Running surface of a rail, whose web and foot are those of 60E1; or a rectangle with its running
        surface at z = 0, symmetric about y = 0; or points (y, z) of the outline of any section: what is free
        of it, from one end of its base to the other, straight between the points. Such a one is for
        :func:`mtb_rs.solve_normal`. There the upper body is a rectangle, or an outline whose material lies
        above its running surface.
    material : Material
    foundation : (vertical, lateral) [N/m2] or None
        Stiffness per length of the springs on which the base stands, spread over its width; the lateral one
        holds along x as well. None: the base does not move.
    base : (m, 2) [m] or None
        Points of the base, from the last point of an outline to the first; None for a straight one.
    origin : float or (float, float) [m]
        Where the cells of :func:`mtb_rs.solve_normal` have y = 0: a point (y, z) of the running surface, or
        of a profile and a rectangle its y. The rows of cells go along the surface from there.

    Raises
    ------
    ValueError
        For sizes and stiffnesses that are not positive, and for points that are no outline.

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
    base: Any = None
    origin: Any = 0.0
    is_half_space: ClassVar[bool] = KeptPrism.is_half_space
    elastic_depth: ClassVar[float] = KeptPrism.elastic_depth
    mean_compliance: ClassVar[float] = KeptPrism.mean_compliance
    without_stress: ClassVar[str] = KeptPrism.without_stress

    def __post_init__(self) -> None:
        put = object.__setattr__
        if not isinstance(self.material, Material):
            raise ValueError(f"material of a prism is {shortened(self.material)}: a Material is needed")
        if self.material.poisson_ratio >= 0.5:
            raise ValueError("Poisson's ratio of a prism is 0.5: finite elements need less than 0.5")
        if isinstance(self.profile, (str, Profile)):
            put(self, "profile", as_profile(self.profile))
        elif np.ndim(self.profile) == 2:
            put(self, "profile", _points("profile", self.profile, 3))
        else:
            width, height = pair("profile", self.profile, "m")
            put(self, "profile", (positive("width", width, "m"), positive("height", height, "m")))
        if self.base is not None:
            if not self._is_outline:
                raise ValueError("base is given: it belongs to an outline, whose points are given as profile")
            put(self, "base", _points("base", self.base, 1))
        put(self, "origin", self._origin())
        if self.foundation is not None:
            vertical, lateral = pair("foundation", self.foundation, "N/m2")
            put(
                self,
                "foundation",
                (positive("vertical", vertical, "N/m2"), positive("lateral", lateral, "N/m2")),
            )

    @property
    def _is_outline(self) -> bool:
        return isinstance(self.profile, tuple) and isinstance(self.profile[0], tuple)

    @property
    def is_inverse_to_modulus(self) -> bool:
        """Whether all displacements are inverse to Young's modulus, since its base stands on no springs."""
        return self.foundation is None

    def _origin(self) -> tuple[float, float]:
        """The origin as a point (y, z)."""
        if np.ndim(self.origin) > 0:
            return pair("origin", self.origin, "m")
        y = number("origin", self.origin, "m")
        if self._is_outline and y != 0.0:
            raise ValueError(f"origin is {y:g} m: the origin of an outline is a point (y, z) [m] of it")
        return y, float(self.height(np.array([y]))[0])

    def height(self, y: Array) -> Array:
        """Height z [m] of the running surface of a profile or a rectangle."""
        if isinstance(self.profile, Profile):
            return self.profile.height(y)
        return np.zeros_like(y)

    def _outline(self, *, upper: bool) -> tuple[Array, Array]:
        """Points (n, 2) of what is free, and of the base (m, 2); a rectangle lies above as the upper body."""
        none = np.zeros((0, 2))
        if self._is_outline:
            return np.array(self.profile), none if self.base is None else np.array(self.base)
        if isinstance(self.profile, Profile):
            return _mtb_rs.rail_outline(self.profile._core), none
        width, height = self.profile
        end = height if upper else -height
        sides = [(-0.5 * width, end), (-0.5 * width, 0.0), (0.5 * width, 0.0), (0.5 * width, end)]
        return np.array(sides), none

    def under_rows(self, rows: int, width: float, ahead: float, *, upper: bool) -> UnderRows:
        """The section under rows of cells of a `width` [m] along the surface, their middle `ahead` [m] of the
        origin; of an upper body, which lies above its running surface, seen in the mirror z = 0."""
        mirror = np.array([1.0, -1.0 if upper else 1.0])
        free, base = (np.ascontiguousarray(points * mirror) for points in self._outline(upper=upper))
        origin = (self.origin[0], self.origin[1] * mirror[1])
        section = _mtb_rs.outline_section(free, base, origin, ahead, (rows, width, FINE_PARTS))
        along = np.diff(section.surface()[::FINE_PARTS] * mirror, axis=0)
        angles = np.unwrap(np.arctan2(along[:, 1], along[:, 0]))
        return UnderRows((self.elastic, section, self.foundation), angles)

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
        if self._is_outline:
            raise ValueError(
                "the Prism has an outline of points: scenes take one of a profile or a rectangle, and "
                "solve_normal takes outlines"
            )
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
        described = {
            "kind": "Prism",
            "profile": profile,
            "material": self.material,
            "foundation": self.foundation,
        }
        return described | ({"base": self.base, "origin": self.origin} if self._is_outline else {})

    def kept(self) -> KeptPrism:
        """What a saved result keeps of it: all but its section."""
        return KeptPrism(self.material, self.foundation)


def _points(name: str, values: ArrayLike, least: int) -> Points:
    """Points (n, 2) [m], checked."""
    points = reals(name, values, "m")
    if points.ndim != 2 or points.shape[1] != 2 or len(points) < least:
        raise ValueError(
            f"{name} has shape {points.shape}: {least} points (y, z) [m] of an outline at least, (n, 2), are "
            "needed"
        )
    return tuple((float(y), float(z)) for y, z in points)


def too_thin(tail: float) -> list[str]:
    """Questions about a section whose answer to waves as short as a cell is not that of a half-space yet."""
    if tail <= LEFT_OUT:
        return []
    return [
        "the section of the Prism is thin beside the cells: shorter waves, which are left out, move a row by "
        f"some {100.0 * tail:.1g} % of what its own load does, and by several times that if the section is "
        "thinner than a cell: narrower cells, or a Layered on a Rigid base, are needed"
    ]


@dataclass(frozen=True)
class UnderRows:
    """A section under rows of cells.

    Attributes
    ----------
    core : (constants, section, foundation), as the core takes them
    angles : (rows,) [rad]
        Of the surface at each row, positive where it rises.
    """

    core: tuple[tuple[float, float], _mtb_rs.Section, tuple[float, float] | None]
    angles: Array


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
        Share of the own displacement of any row that the last range of waves adds, or that shorter ones would
        if the section went on as it answers the shortest.
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
