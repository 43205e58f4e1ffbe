# SPDX-License-Identifier: MIT OR Apache-2.0
"""Bodies, as the contact sees them."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from types import MappingProxyType
from typing import Any, ClassVar, Self, cast

import numpy as np
from numpy.typing import NDArray

from .. import _mtb_rs
from ..base.check import number, positive, shortened
from ..base.plain import plain
from ..base.stored import stored
from ..geometry.profiles import Profile
from .constants import MODULI, OfMaterial
from .faces import Hats
from .material import Material
from .prism import BELOW, KeptPrism, Prism
from .surfaces import BodySurface, as_surface

Array = NDArray[np.float64]
#: What a half-space is made of, as the core takes it: constants, a layer on a base, or what creeps.
Core = tuple[float, float] | _mtb_rs.Layered | tuple[tuple[float, float], float, tuple[float, float]]
#: What the inside of a body is made of, as the core takes it.
Inside = tuple[float, float] | _mtb_rs.Layered
#: First point (x, y) [m], numbers of points along x and y, and spacing (dx, dy) [m] of a flat grid.
Grid = tuple[tuple[float, float, int, int], tuple[float, float]]


@stored
@dataclass(frozen=True)
@plain
class HalfSpace(OfMaterial):
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
    #: Displacement by a uniform pressure [m/Pa] where that is finite, otherwise 0.
    mean_compliance: ClassVar[float] = 0.0
    #: Whether all displacements are inverse to Young's modulus.
    is_inverse_to_modulus: ClassVar[bool] = True
    #: Why the stress inside is not known; empty where it is.
    without_stress: ClassVar[str] = ""
    #: Depth [m] to which there is something elastic.
    elastic_depth: ClassVar[float] = math.inf

    @property
    def elastic(self) -> tuple[float, float]:
        """Shear modulus [Pa] and Poisson's ratio, as the core takes them."""
        return self.material.shear_modulus, self.material.poisson_ratio

    @property
    def inside(self) -> tuple[float, float]:
        """Shear modulus [Pa] and Poisson's ratio of the inside, as the core takes them."""
        return self.elastic

    @property
    def normal_compliance(self) -> float:
        """(1 - nu) / G [1/Pa]."""
        return (1.0 - self.material.poisson_ratio) / self.material.shear_modulus

    @property
    def plane_strain_compliance(self) -> float:
        """(1 - nu^2) / E [1/Pa]."""
        return 1.0 / self.material.plane_strain_modulus

    def waves(self, numbers: Array) -> Array:
        """Displacement (n,) [m/Pa] by waves of pressure with wave numbers (n,) [1/m]; 0 by the mean, which it
        does not carry."""
        return np.divide(self.normal_compliance, numbers, out=np.zeros_like(numbers), where=numbers > 0.0)

    @property
    def mixed_compliance(self) -> float:
        """(1 - 2 nu) / G [1/Pa]: twice what couples normal and tangential."""
        return (1.0 - 2.0 * self.material.poisson_ratio) / self.material.shear_modulus

    def on_cells(self, grids: Sequence[Grid], *, interact: bool) -> _mtb_rs.Compliance | None:
        """Compliance on the cells of flat grids; without `interact` each lies on a half-space of its own."""
        places, spacings = zip(*grids, strict=True)
        return _mtb_rs.half_space(self.elastic, list(places), list(spacings), interact)

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
    constants: ClassVar[tuple[str, ...]] = ()
    without_derivatives: ClassVar[Mapping[str, str]] = MappingProxyType(
        dict.fromkeys(("young_modulus", "poisson_ratio"), "this body is rigid and has no moduli")
    )
    without_stress: ClassVar[str] = "is Rigid, and has no stress"
    elastic_depth: ClassVar[float] = 0.0
    elastic: ClassVar[None] = None
    inside: ClassVar[None] = None
    mean_compliance: ClassVar[float] = 0.0
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


_OF_BASE = tuple(f"base.{name}" for name in MODULI)


@lru_cache(maxsize=16)
def _core(
    layer: tuple[float, float], thickness: float, base: tuple[float, float] | None, bonded: bool
) -> _mtb_rs.Layered:
    """The same body for equal constants, which keeps what was computed of it."""
    return _mtb_rs.Layered(layer, thickness, base, bonded)


@stored
@dataclass(frozen=True)
@plain
class Layered(OfMaterial):
    """An elastic layer of constant thickness on an elastic half-space, or on a rigid base: a coated body.

    Any thickness and any Poisson's ratio are taken, 0.5 included. A :class:`mtb_rs.ThinLayer` is the limit of
    a thin, compressible layer on a rigid base.

    Parameters
    ----------
    layer : Material
        Of the layer, whose surface is in contact.
    thickness : float [m]
        Of the layer.
    base : Material or Rigid
        Below the layer: a half-space of this material, or a rigid body.
    bonded : bool
        True: layer and base move as one at their interface. False: the layer slides on its base without
        friction, and does not leave it. Such a layer would be carried away by friction on its surface, so
        that it takes contacts without friction only.

    Raises
    ------
    ValueError
        For a thickness that is not positive, and for a base that is neither.

    References
    ----------
    [Burmister1945], [Johnson1985, ch. 5.8]

    Examples
    --------
    >>> import mtb_rs as mtb
    >>> rubber = mtb.Material(5e6, 0.499)
    >>> pad = mtb.Layered(rubber, 2e-3, mtb.Rigid())
    >>> coated = mtb.Layered(mtb.Material(300e9, 0.25), 5e-6, mtb.steel)
    """

    layer: Material
    thickness: float
    base: Material | Rigid
    bonded: bool = True
    #: It is no half-space of one material, which is what other ways than half-spaces take.
    is_half_space: ClassVar[bool] = False
    is_inverse_to_modulus: ClassVar[bool] = False
    without_stress: ClassVar[str] = ""

    def __post_init__(self) -> None:
        base: Any = self.base
        if isinstance(base, HalfSpace) and base.surface is None:
            base = base.material
        if isinstance(base, Rigid) and base.surface is not None:
            raise ValueError("base is a Rigid with a surface: below a layer it is plane, and has none")
        if not isinstance(base, (Material, Rigid)):
            raise ValueError(f"base of a layer is {shortened(base)}: a Material or Rigid() is needed")
        if not isinstance(self.layer, Material):
            raise ValueError(f"layer is {shortened(self.layer)}: a Material is needed")
        if not isinstance(self.bonded, bool):
            raise ValueError(f"bonded is {self.bonded!r}: True or False is needed")
        object.__setattr__(self, "base", base)
        object.__setattr__(self, "thickness", positive("thickness", self.thickness, "m"))

    @property
    def material(self) -> Material:
        """That at its surface."""
        return self.layer

    @property
    def constants(self) -> tuple[str, ...]:
        """Names of the constants by which results are derived: those of the layer go without a prefix."""
        return (*MODULI, "thickness", *(() if self._below is None else _OF_BASE))

    @property
    def without_derivatives(self) -> Mapping[str, str]:
        """Constants by which they are not, and why."""
        if self._below is not None:
            return {}
        return dict.fromkeys(_OF_BASE, "the base of this layer is rigid and has no moduli")

    def constant(self, name: str) -> float:
        """Its value [SI]."""
        if name == "thickness":
            return self.thickness
        part = self.base if name in _OF_BASE else self.layer
        return float(getattr(part, name.removeprefix("base.")))

    def with_constant(self, name: str, value: float) -> Self:
        """The same body with another value of a constant."""
        if name == "thickness":
            return replace(self, thickness=value)
        part = "base" if name in _OF_BASE else "layer"
        changed = replace(getattr(self, part), **{name.removeprefix("base."): value})
        return replace(self, **{part: changed})

    @property
    def elastic(self) -> _mtb_rs.Layered:
        """The body as the core has it."""
        base = None if self._below is None else (self._below.shear_modulus, self._below.poisson_ratio)
        return _core((self.layer.shear_modulus, self.layer.poisson_ratio), self.thickness, base, self.bonded)

    @property
    def inside(self) -> _mtb_rs.Layered:
        """The inside, as the core has it."""
        return self.elastic

    @property
    def elastic_depth(self) -> float:
        """Depth [m] to which there is something elastic: that of a layer on a rigid base."""
        return math.inf if self._below is not None else self.thickness

    @property
    def _below(self) -> Material | None:
        """Material of the base; None of a rigid one."""
        return self.base if isinstance(self.base, Material) else None

    @property
    def mean_compliance(self) -> float:
        """Displacement by a uniform pressure [m/Pa] on a rigid base; 0 on a half-space, which has none."""
        return 0.0 if self._below is not None else float(self.waves(np.zeros(1))[0])

    def waves(self, numbers: Array) -> Array:
        """Displacement (n,) [m/Pa] by waves of pressure with wave numbers (n,) [1/m]; 0 by the mean on an
        elastic base, which does not carry it."""
        return self.elastic.waves(numbers)

    @property
    def normal_compliance(self) -> float:
        """(1 - nu) / G [1/Pa] of the layer or of the base, whichever gives way more."""
        materials = [self.layer, *([] if self._below is None else [self._below])]
        return max((1.0 - m.poisson_ratio) / m.shear_modulus for m in materials)

    @property
    def plane_strain_compliance(self) -> float:
        """(1 - nu^2) / E [1/Pa], likewise."""
        return 0.5 * self.normal_compliance

    def on_cells(self, grids: Sequence[Grid], *, interact: bool) -> _mtb_rs.Compliance:
        """Compliance on the cells of flat grids; without `interact` each lies on a body of its own."""
        places, spacings = zip(*grids, strict=True)
        return _mtb_rs.half_space(self.elastic, list(places), list(spacings), interact)

    def on_hats(self, grids: Sequence[Grid], *, interact: bool) -> _mtb_rs.Compliance:
        """Refused: hats belong to elastic bodies beside it."""
        raise ValueError(BESIDE_ELASTIC)

    def on_cut_hats(self, hats: Hats, carrier: _mtb_rs.Sampling, grid: Grid) -> _mtb_rs.Compliance:
        """Refused, likewise."""
        raise ValueError(BESIDE_ELASTIC)

    def described(self) -> dict[str, Any]:
        """What `summary.json` tells of it."""
        base = "Rigid" if self._below is None else self._below
        return {
            "kind": "Layered",
            "layer": self.layer,
            "thickness": self.thickness,
            "base": base,
            "bonded": self.bonded,
        }

    def kept(self) -> Layered:
        """What a saved result keeps of it: all."""
        return self


@stored
@dataclass(frozen=True)
@plain
class Viscoelastic(OfMaterial):
    """A half-space that creeps while a contact rolls over it: a standard linear solid.

    Under a stress that is held its compliance is ``(1 + creep (1 - exp(-t / creep_time)))`` times that of
    `material` a time t later, with one Poisson's ratio. Where a contact passes much faster than it creeps,
    this is the half-space of `material`, and where it passes much slower the one of `relaxed`.

    It is a body of :func:`mtb_rs.solve_normal` (with `rolling`), of steady rolling in
    :func:`mtb_rs.solve_tangential`, and of scenes that roll steadily: case files with ``[rolling]``, and
    :func:`mtb_rs.sweep` with a motion. Nothing else takes it.

    Parameters
    ----------
    material : Material
        Its constants before it creeps.
    creep : float [-]
        Compliance that creep adds in the long run, over that before; at least 0.
    creep_time : float [s]
        Time in which the creep comes to all but 1/e of its end; 0 for at once.

    Raises
    ------
    ValueError
        For a creep or a time that is negative.

    References
    ----------
    [Kalker1990, ch. 3], [Hunter1961]

    Examples
    --------
    >>> import mtb_rs as mtb
    >>> tread = mtb.Viscoelastic(mtb.Material(20e6, 0.49), creep=1.5, creep_time=1e-3)
    >>> round(tread.relaxed.young_modulus)
    8000000
    """

    material: Material
    creep: float
    creep_time: float
    #: It is no half-space of one elastic material, which is what other ways take.
    is_half_space: ClassVar[bool] = False
    #: Whether it is known how the contact rolls over it.
    is_rolled: ClassVar[bool] = False
    mean_compliance: ClassVar[float] = 0.0
    is_inverse_to_modulus: ClassVar[bool] = True
    #: Creep changes displacements only: with one Poisson's ratio the stress is that of the tractions alone.
    without_stress: ClassVar[str] = ""
    elastic_depth: ClassVar[float] = math.inf

    def __post_init__(self) -> None:
        if not isinstance(self.material, Material):
            raise ValueError(
                f"material of a body that creeps is {shortened(self.material)}: a Material is needed"
            )
        for name, unit in (("creep", "1"), ("creep_time", "s")):
            value = number(name, getattr(self, name), unit)
            if value < 0.0:
                raise ValueError(f"{name} is {value:g}: a number of at least 0 is needed")
            object.__setattr__(self, name, value)

    @property
    def constants(self) -> tuple[str, ...]:
        """Names of the constants by which results are derived."""
        return (*MODULI, "creep", "creep_time")

    def constant(self, name: str) -> float:
        """Its value [SI]."""
        return float(getattr(self.material if name in MODULI else self, name))

    def with_constant(self, name: str, value: float) -> Self:
        """The same body with another value of a constant."""
        if name in MODULI:
            return super().with_constant(name, value)
        return replace(self, **cast(Any, {name: value}))

    def varied(self, name: str) -> list[tuple[float, Self]]:
        """Bodies with other values of a constant, and the weight of each in the derivative by it: all is
        linear in the creep."""
        if name == "creep":
            return [(1.0, replace(self, creep=self.creep + 1.0)), (-1.0, self)]
        return super().varied(name)

    @property
    def inside(self) -> tuple[float, float]:
        """Shear modulus [Pa] and Poisson's ratio of the inside, before it creeps."""
        return self.material.shear_modulus, self.material.poisson_ratio

    @property
    def relaxed(self) -> Material:
        """Constants when all creep has come to its end."""
        softer = self.material.young_modulus / (1.0 + self.creep)
        return Material(softer, self.material.poisson_ratio)

    def deborah_number(self, velocity: float, length: float) -> float:
        """Creep time over the time in which a contact passes.

        Parameters
        ----------
        velocity : float [m/s]
            Of the contact over the body.
        length : float [m]
            Of the contact, along its way.

        Returns
        -------
        float [-]
            Small where the body creeps at once, large where it does not creep at all.
        """
        return positive("velocity", velocity, "m/s") * self.creep_time / positive("length", length, "m")

    def elastic_errors(self, velocity: float, length: float) -> tuple[float, float]:
        """How wrong the pressure is at most, about, if the body is taken for an elastic one.

        These are the leading terms of slow and of fast rolling with the Deborah number D,
        ``creep / (1 + creep) D (2 + ln(1 + 1 / D))`` and ``creep / D (1 + ln(1 + D))``. Where they are
        below 0.3, the true errors are a third of them to all of them for cylinders, after [Hunter1961], and a
        seventh to all for balls. A value that is not small says only that creep counts.

        Parameters
        ----------
        velocity : float [m/s]
            Of the contact over the body.
        length : float [m]
            Of the contact, along its way.

        Returns
        -------
        (float, float) [-]
            Relative errors (L2 over the contact) of the pressure on `relaxed`, and on `material`.

        Examples
        --------
        >>> import mtb_rs as mtb
        >>> tread = mtb.Viscoelastic(mtb.Material(20e6, 0.49), creep=1.0, creep_time=5e-3)
        >>> relaxed, hard = tread.elastic_errors(velocity=0.005, length=4e-3)
        >>> round(relaxed, 3)
        0.022
        """
        passed = self.deborah_number(velocity, length)
        if passed == 0.0:
            return 0.0, math.inf
        slow = self.creep / (1.0 + self.creep) * passed * (2.0 + math.log1p(1.0 / passed))
        return slow, self.creep / passed * (1.0 + math.log1p(passed))

    @property
    def normal_compliance(self) -> float:
        """(1 - nu) / G [1/Pa] at the end of its creep."""
        return (1.0 - self.material.poisson_ratio) / self.relaxed.shear_modulus

    @property
    def plane_strain_compliance(self) -> float:
        """(1 - nu^2) / E [1/Pa], likewise."""
        return 0.5 * self.normal_compliance

    @property
    def elastic(self) -> Core:
        """The body as the core has it, at rest."""
        return self.under((0.0, 0.0))

    def under(self, velocity: tuple[float, float]) -> Core:
        """The body as the core has it, under a contact that rolls at a velocity (x, y) [m/s]."""
        way = (velocity[0] * self.creep_time, velocity[1] * self.creep_time)
        return (self.material.shear_modulus, self.material.poisson_ratio), self.creep, way

    def rolled_over(self, velocity: tuple[float, float]) -> RolledOver:
        """The body under a contact that rolls at a velocity (x, y) [m/s], as cells of a scene stand on it."""
        return RolledOver(self.material, self.creep, self.creep_time, velocity)

    def on_cells(self, grids: Sequence[Grid], *, interact: bool) -> _mtb_rs.Compliance:
        """Refused: how the contact rolls is not known."""
        raise ValueError(BESIDE_ROLLING)

    def on_hats(self, grids: Sequence[Grid], *, interact: bool) -> _mtb_rs.Compliance:
        """Refused: hats belong to elastic bodies beside it, which do not roll."""
        raise ValueError(BESIDE_ROLLING)

    def on_cut_hats(self, hats: Hats, carrier: _mtb_rs.Sampling, grid: Grid) -> _mtb_rs.Compliance:
        """Refused, likewise."""
        raise ValueError(BESIDE_ROLLING)

    def described(self) -> dict[str, Any]:
        """What `summary.json` tells of it."""
        return {
            "kind": "Viscoelastic",
            "material": self.material,
            "creep": self.creep,
            "creep_time": self.creep_time,
        }

    def kept(self) -> Viscoelastic:
        """What a saved result keeps of it: all."""
        return self


@dataclass(frozen=True)
@plain
class RolledOver(Viscoelastic):
    """A half-space that creeps under a contact that rolls over it at a `velocity` (x, y) [m/s]."""

    velocity: tuple[float, float] = (0.0, 0.0)
    is_rolled: ClassVar[bool] = True

    @property
    def constants(self) -> tuple[str, ...]:
        """Names of the constants by which results are derived."""
        return tuple(name for name in super().constants if name not in self.without_derivatives)

    @property
    def without_derivatives(self) -> Mapping[str, str]:
        """Constants by which they are not, and why."""
        if self.creep_time > 0.0:
            return {}
        why = "the creep time is 0 and can only grow: results of solve_normal and solve_tangential have it"
        return {"creep_time": why}

    @property
    def elastic(self) -> Core:
        """The body as the core has it, at its velocity."""
        return self.under(self.velocity)

    def on_cells(self, grids: Sequence[Grid], *, interact: bool) -> _mtb_rs.Compliance:
        """Compliance on the cells of flat grids; without `interact` each lies on a body of its own."""
        places, spacings = zip(*grids, strict=True)
        return _mtb_rs.half_space(self.elastic, list(places), list(spacings), interact)

    def kept(self) -> Viscoelastic:
        """What a saved result keeps of it: the body, without how it was rolled over."""
        return Viscoelastic(self.material, self.creep, self.creep_time)


#: Why a body that creeps is none of what does not roll.
BESIDE_ROLLING = (
    "a Viscoelastic body is known in steady rolling only: solve_normal(..., rolling=mtb.Rolling(...)), "
    "solve_tangential, case files with [rolling] and sweep(..., motion=mtb.Rolling(...)) take it; elsewhere "
    "its `material` (before it creeps) or `relaxed` is needed"
)

#: Why a layered body is none of finite elements, and none beside them.
BESIDE_ELASTIC = (
    "a Layered body is known under cells of uniform traction only, and not beside elastic bodies of finite "
    'elements: model="half-space" takes it, and beside an ElasticBody a HalfSpace or Rigid is needed'
)


Simple = HalfSpace | Layered | Rigid | Viscoelastic


#: What rolling contact takes for a body.
Medium = Material | Layered | Viscoelastic | Prism


def are_unlike(one: Simple, other: Simple) -> bool:
    """Whether a pressure moves the surfaces of two bodies tangentially against each other."""
    simple = [body for body in (one, other) if not isinstance(body, (Layered, Prism, Viscoelastic))]
    if len(simple) < 2:
        return one != other
    mixed = [body.mixed_compliance for body in simple]
    return abs(mixed[0] - mixed[1]) > 1e-12 * max(map(abs, mixed))


def as_body(name: str, body: object) -> Simple:
    """A body, or the half-space of a material."""
    if isinstance(body, Material):
        return HalfSpace(body)
    if isinstance(body, (HalfSpace, Layered, Rigid, Viscoelastic)):
        return body
    if isinstance(body, Prism):
        raise ValueError(f"{name} is {body!r}, which is not taken here: {BELOW}")
    from .mesh_objects import as_trimesh  # brings trimesh

    if isinstance(body, (Profile, BodySurface)) or as_trimesh(body) is not None:
        raise ValueError(
            f"{name} is {shortened(body)}: a surface alone has no material: HalfSpace(material, surface) or "
            "Rigid(surface) is needed"
        )
    raise ValueError(
        f"{name} is {body!r}: a Material, HalfSpace, Layered, Rigid or ElasticBody is needed, or in rolling "
        "a Viscoelastic"
    )


#: What may lie under cells in rows, and what results keep of it.
FieldBody = Simple | Prism | KeptPrism


def not_prism(body: FieldBody | None, what: str) -> Simple:
    """A body that is no prism; ValueError that names what takes none."""
    if isinstance(body, (Prism, KeptPrism)):
        raise ValueError(f"a body is a Prism: {what} does not take it; {BELOW}")
    return Rigid() if body is None else body


def field_body(name: str, body: object) -> Simple | Prism:
    """A body under cells in rows: as :func:`as_body`, or a prism."""
    own = prism_of(body)
    return as_body(name, body) if own is None else own


def prism_of(body: object) -> Prism | None:
    """The body if it is a prism; None of any other."""
    if isinstance(body, KeptPrism):
        raise ValueError(
            "a body is a Prism that was read from a file, which does not keep its section: a result that "
            "solve_normal has just returned is needed"
        )
    return body if isinstance(body, Prism) else None


def without_layers(bodies: Sequence[Simple], what: str) -> list[HalfSpace | Rigid]:
    """The bodies, where none is layered; ValueError that names what takes no other ones."""
    found: list[HalfSpace | Rigid] = []
    for body in bodies:
        if isinstance(body, Layered):
            raise ValueError(
                f"a body is {body!r}: {what} takes a Material, a HalfSpace or Rigid; solve_normal and scenes "
                'of half-spaces (model="half-space") take layers'
            )
        if isinstance(body, Viscoelastic):
            raise ValueError(f"a body is {body!r}: {what} does not take it; {BESIDE_ROLLING}")
        if isinstance(body, Prism):
            raise ValueError(f"a body is {body!r}: {what} does not take it; {BELOW}")
        found.append(body)
    return found


def are_layered(*bodies: object) -> bool:
    """Whether a body is layered."""
    return any(isinstance(body, Layered) for body in bodies)


def are_prisms(*bodies: object) -> bool:
    """Whether a body is a prism."""
    return any(isinstance(body, Prism) for body in bodies)


def do_creep(*bodies: object) -> bool:
    """Whether a body creeps."""
    return any(isinstance(body, Viscoelastic) for body in bodies)


def velocity_over(*bodies: object) -> tuple[float, float] | None:
    """Velocity (x, y) [m/s] of the contact over bodies of a scene that creep; None where none does."""
    return next((body.velocity for body in bodies if isinstance(body, RolledOver)), None)


def are_compound(*bodies: object) -> bool:
    """Whether a body is no half-space of one elastic material, and not rigid either."""
    return are_layered(*bodies) or do_creep(*bodies)


def surface_of(body: Medium) -> Material:
    """The material at the surface of a body."""
    return body if isinstance(body, Material) else body.material


def medium_of(body: Medium | Simple, velocity: tuple[float, float] | None) -> Core | None:
    """What a body is made of, as the core takes it, under a contact that rolls at a velocity (x, y) [m/s]."""
    if isinstance(body, Viscoelastic):
        if velocity is None:
            raise ValueError(f"a body is {body!r}: {BESIDE_ROLLING}")
        return body.under(velocity)
    if isinstance(body, Material):
        return body.shear_modulus, body.poisson_ratio
    return body.elastic
