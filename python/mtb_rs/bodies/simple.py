# SPDX-License-Identifier: MIT OR Apache-2.0
"""Bodies, as the contact sees them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import Any, ClassVar

from .. import _mtb_rs
from ..base.check import shortened
from ..base.plain import plain
from ..base.stored import stored
from ..geometry.profiles import Profile
from .faces import Hats
from .material import Material
from .surfaces import BodySurface, as_surface

#: First point (x, y) [m], numbers of points along x and y, and spacing (dx, dy) [m] of a flat grid.
Grid = tuple[tuple[float, float, int, int], tuple[float, float]]


@stored
@dataclass(frozen=True)
@plain
class HalfSpace:
    """A body that is so large that its contact behaves like that of an elastic half-space.

    Parameters
    ----------
    material : Material
    surface : Profile, BodySurface, mesh of trimesh, meshio or pyvista, or None
        Its shape below or above an :class:`mtb_rs.ElasticBody`, in the frame of that body's mesh. A profile
        z(y) is straight along x, a mesh is in metres, and a name means a standard profile. None: the plane
        through the end of the other face.
    """

    material: Material
    surface: Any = None
    is_half_space: ClassVar[bool] = True
    #: Moduli of its material by which results are derived.
    moduli: ClassVar[tuple[str, ...]] = ("young_modulus", "poisson_ratio")
    #: Moduli by which they are not, and why.
    without_derivatives: ClassVar[Mapping[str, str]] = MappingProxyType({})

    def with_modulus(self, name: str, value: float) -> HalfSpace:
        """The same of a material with another modulus."""
        return replace(self, material=replace(self.material, **{name: value}))

    @property
    def elastic(self) -> tuple[float, float]:
        """Shear modulus [Pa] and Poisson's ratio, as the core takes them."""
        return self.material.shear_modulus, self.material.poisson_ratio

    @property
    def normal_compliance(self) -> float:
        """(1 - nu) / G [1/Pa]."""
        return (1.0 - self.material.poisson_ratio) / self.material.shear_modulus

    @property
    def plane_strain_compliance(self) -> float:
        """(1 - nu^2) / E [1/Pa]."""
        return 1.0 / self.material.plane_strain_modulus

    @property
    def mixed_compliance(self) -> float:
        """(1 - 2 nu) / G [1/Pa]: twice what couples normal and tangential."""
        return (1.0 - 2.0 * self.material.poisson_ratio) / self.material.shear_modulus

    def on_cells(self, grids: Sequence[Grid], *, interact: bool) -> _mtb_rs.Compliance | None:
        """Compliance on the cells of flat grids; without `interact` each lies on a half-space of its own."""
        places, spacings = zip(*grids, strict=True)
        return _mtb_rs.half_space(*self.elastic, list(places), list(spacings), interact)

    def on_hats(self, grids: Sequence[Grid], *, interact: bool) -> _mtb_rs.Compliance | None:
        """The same on the nodes of the grids: their hats."""
        places, spacings = zip(*grids, strict=True)
        compliance, _ = _mtb_rs.half_space_hats(*self.elastic, list(places), list(spacings), interact)
        return compliance

    def on_cut_hats(self, hats: Hats, carrier: _mtb_rs.Sampling, grid: Grid) -> _mtb_rs.Compliance | None:
        """The same on hats of one grid that end where the body of `carrier` ends."""
        return hats.half_space(carrier, *self.elastic, *grid)

    def described(self) -> dict[str, Any]:
        """What `summary.json` tells of it."""
        return {"kind": "HalfSpace", "material": self.material, "surface": self.surface}

    def kept(self) -> HalfSpace:
        """What a saved result keeps of it: the material."""
        return HalfSpace(self.material)

    def __post_init__(self) -> None:
        if not isinstance(self.material, Material):
            raise ValueError(f"material of a half-space is {self.material!r}: a Material is needed")
        object.__setattr__(self, "surface", as_surface(self.surface))


@stored
@dataclass(frozen=True)
@plain
class Rigid:
    """A body that does not deform.

    Parameters
    ----------
    surface
        As of :class:`HalfSpace`.
    """

    surface: Any = None
    is_half_space: ClassVar[bool] = False
    material: ClassVar[None] = None
    moduli: ClassVar[tuple[str, ...]] = ()
    without_derivatives: ClassVar[Mapping[str, str]] = MappingProxyType(
        dict.fromkeys(("young_modulus", "poisson_ratio"), "this body is rigid and has no moduli")
    )
    elastic: ClassVar[None] = None
    normal_compliance: ClassVar[float] = 0.0
    plane_strain_compliance: ClassVar[float] = 0.0
    mixed_compliance: ClassVar[float] = 0.0

    def on_cells(self, grids: Sequence[Grid], *, interact: bool) -> None:
        """It does not give way."""

    on_hats = on_cells

    def on_cut_hats(self, hats: Hats, carrier: _mtb_rs.Sampling, grid: Grid) -> None:
        """It does not give way."""

    def described(self) -> dict[str, Any]:
        """What `summary.json` tells of it."""
        return {"kind": "Rigid", "surface": self.surface}

    def kept(self) -> Rigid:
        """What a saved result keeps of it."""
        return Rigid()

    def __post_init__(self) -> None:
        object.__setattr__(self, "surface", as_surface(self.surface))


Simple = HalfSpace | Rigid


def as_body(name: str, body: object) -> Simple:
    """A body, or the half-space of a material."""
    if isinstance(body, Material):
        return HalfSpace(body)
    if isinstance(body, (HalfSpace, Rigid)):
        return body
    from .mesh_objects import as_trimesh  # brings trimesh

    if isinstance(body, (Profile, BodySurface)) or as_trimesh(body) is not None:
        raise ValueError(
            f"{name} is {shortened(body)}: a surface alone has no material: HalfSpace(material, surface) or "
            "Rigid(surface) is needed"
        )
    raise ValueError(f"{name} is {body!r}: a Material, HalfSpace, Rigid or ElasticBody is needed")
