# SPDX-License-Identifier: MIT OR Apache-2.0
"""Profiles, surfaces, sheets of contact points and gaps. SI units, z up."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _mtb_rs
from .check import choice, number, path_of, positive, reals
from .files import read_text
from .owning import frozen, owning
from .plain import plain, same
from .plausible import ask, of_wheel
from .result import Patch
from .words import Interpolation, Unit, ZAxis

Array = NDArray[np.float64]

#: Profiles known by name: rail head 60E1 (UIC 60, EN 13674-1), wheel S1002 (EN 13715).
STANDARD_PROFILES = ("60E1", "S1002")


#: Coordinates, gaps, loads that differ by less, relative to their size, count as images of each other.
ROUNDING = 1e-11

#: Metres per unit of length.
UNITS: dict[Unit, float] = {"m": 1.0, "mm": 1e-3, "um": 1e-6, "in": 0.0254}


def metres(unit: Unit) -> float:
    """Length of a unit known by name [m]."""
    return UNITS[choice("unit", unit, Unit)]


def spacing_pair(spacing: float | Sequence[float]) -> tuple[float, float]:
    """`spacing` as (dx, dy) [m]: a number means both."""
    try:
        dx, dy = spacing  # type: ignore[misc]
    except TypeError:
        side = positive("spacing", spacing, "m")
        return side, side
    except ValueError:
        raise ValueError(f"spacing is {spacing!r}: a number or (dx, dy) in metres is needed") from None
    return positive("spacing dx", dx, "m"), positive("spacing dy", dy, "m")


class Profile:
    """Height z(y) [m] of the cross-section of a rail or a wheel, z up.

    Rails have their crown at y = 0; wheels have the tape circle at y = 0, the field side at y > 0
    and the flange at y < 0. Made by :meth:`standard`, :meth:`from_points` or :meth:`from_file`.

    Examples
    --------
    >>> rail = Profile.standard("60E1")
    >>> round(float(rail.height(0.02)) * 1e3, 3)
    -1.11
    """

    __slots__ = ("_core", "_recipe", "name")

    _core: _mtb_rs.Profile
    _recipe: tuple[Any, ...]
    name: str

    def __init__(self, core: _mtb_rs.Profile, name: str, recipe: tuple[Any, ...]) -> None:
        self._core = core
        self._recipe = recipe
        self.name = name

    @classmethod
    def standard(cls, name: str) -> Profile:
        """Profile known by name: "60E1" or "S1002"."""
        makers = {"60E1": _mtb_rs.Profile.rail_60e1, "S1002": _mtb_rs.Profile.wheel_s1002}
        if not isinstance(name, str) or name not in makers:
            raise ValueError(f"profile {name!r} is unknown: {', '.join(STANDARD_PROFILES)} are known by name")
        return cls(makers[name](), name, (cls.standard, (name,)))

    @classmethod
    def from_points(
        cls, y: ArrayLike, z: ArrayLike, interpolation: Interpolation = "smooth", name: str = "table"
    ) -> Profile:
        """Profile through points (y, z) [m], y strictly rising or strictly falling.

        "smooth" is a cubic spline, "linear" keeps every irregularity of the table.
        """
        y, z = np.atleast_1d(reals("y", y)), np.atleast_1d(reals("z", z))
        if y.ndim != 1 or z.ndim != 1:
            raise ValueError(
                f"y and z have shapes {y.shape} and {z.shape}: one-dimensional arrays are needed"
            )
        choice("interpolation", interpolation, Interpolation)
        core = _mtb_rs.Profile.from_points(y, z, interpolation)
        return cls(core, name, (cls.from_points, (frozen(y), frozen(z), interpolation, name)))

    @classmethod
    def from_file(
        cls,
        path: str | Path,
        interpolation: Interpolation = "smooth",
        *,
        unit: Unit = "mm",
        z_axis: ZAxis = "guess",
    ) -> Profile:
        """Profile from a file of two columns (y, z), or of the .prr / .prw form with its header.

        Parameters
        ----------
        path : str or Path
            Columns parted by blanks, commas or semicolons; comments begin with #, !, % or //. A file of more
            than two columns needs a heading that names y and z.
        interpolation : "smooth" or "linear"
        unit : str
            Length unit of files that do not state theirs: "m", "mm", "um" or "in".
        z_axis : "up", "down" or "guess"
            Way of z in the file; guessed, the larger departure from the median height is down: rails
            fall off at their flanks, wheels at their flange.
        """
        path = path_of("path", path)
        choice("interpolation", interpolation, Interpolation)
        choice("z_axis", z_axis, ZAxis)
        text = read_text(path, "profile file")
        try:
            core = _mtb_rs.Profile.parse(text, metres(unit), z_axis, interpolation)
        except ValueError as error:
            raise ValueError(f"profile file {str(path)!r}: {error}") from None
        recipe = (cls._parsed, (text, metres(unit), z_axis, interpolation, path.name))
        return cls(core, path.name, recipe)

    @classmethod
    def _parsed(cls, text: str, unit: float, z_axis: str, interpolation: str, name: str) -> Profile:
        """What a pickled profile from a file is made of again."""
        core = _mtb_rs.Profile.parse(text, unit, z_axis, interpolation)
        return cls(core, name, (cls._parsed, (text, unit, z_axis, interpolation, name)))

    def __reduce__(self) -> tuple[Any, ...]:
        return self._recipe

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Profile) and same(self._recipe, other._recipe)

    def __hash__(self) -> int:
        return hash(self.name)

    def __repr__(self) -> str:
        start, end = self.range
        return f"Profile({self.name!r}, y = {start:g} .. {end:g} m)"

    @property
    def range(self) -> tuple[float, float]:
        """First and last y [m]."""
        return self._core.range()

    @property
    def breaks(self) -> Array:
        """Values of y [m] where the formula changes, both ends included."""
        return self._core.breaks()

    def _stations(self, y: ArrayLike) -> Array:
        y = reals("y", y)
        return self._core.stations(y.ravel()).reshape(5, *y.shape)

    def height(self, y: ArrayLike) -> Array:
        """Height z [m] at `y` [m], any shape."""
        return np.asarray(self._stations(y)[0])

    def slope(self, y: ArrayLike) -> Array:
        """Slope dz/dy [-] at `y` [m]."""
        return np.asarray(self._stations(y)[1])

    def curvature(self, y: ArrayLike) -> Array:
        """Signed curvature [1/m] at `y` [m], negative where the profile is convex upwards."""
        return np.asarray(self._stations(y)[2])

    def normal(self, y: ArrayLike) -> Array:
        """Unit normals (2, ...): components y and z, pointing up."""
        return self._stations(y)[3:]

    def arc_length(self, y: ArrayLike) -> Array:
        """Arc length s [m] from y = 0 to `y` [m], rising with y."""
        y = reals("y", y)
        return self._core.arc_length(y.ravel()).reshape(y.shape)

    def position(self, s: ArrayLike) -> Array:
        """Lateral position y [m] at arc length `s` [m]: the inverse of :meth:`arc_length`."""
        s = reals("s", s)
        return self._core.position(s.ravel()).reshape(s.shape)

    @property
    def is_symmetric(self) -> bool:
        """Whether it is its own mirror image about y = 0, but for rounding."""
        start, end = self.range
        size = max(-start, end)
        if abs(start + end) > ROUNDING * size:
            return False
        ends = np.unique(np.abs(np.append(self.breaks, 0.0)))
        # between two breaks of either side both are one piece, of at most the third degree
        y = np.concatenate([ends[:-1] + share * np.diff(ends) for share in (0.0, 0.25, 0.5, 0.75)])
        return bool(np.abs(self.height(y) - self.height(-y)).max() <= ROUNDING * size)


def as_profile(profile: str | Profile) -> Profile:
    """A profile, or the standard one of that name."""
    return profile if isinstance(profile, Profile) else Profile.standard(profile)


@owning
@dataclass(frozen=True)
@plain
class SheetPoints:
    """Points on the lower body with the undeformed gap above them.

    Attributes
    ----------
    points : (3, n) [m]
    normal : (3, n) [-]
        Unit normals of the lower body, pointing up.
    tangent_x, tangent_y : (3, n) [-]
        Unit tangents along the rows of the grid, which are along x unless the upper body is turned, and
        across (normal x tangent_x).
    arc_length : (n,) [m]
        Arc length over the lower body, from its crown, rising with y.
    gap : (n,) [m]
        Distance to the upper body along the normal, > 0 open.
    """

    points: Array
    normal: Array
    tangent_x: Array
    tangent_y: Array
    arc_length: Array
    gap: Array


@owning
@dataclass(frozen=True)
@plain
class ContactSheet:
    """A potential contact: regular grids of equal cells over the surface of the lower body.

    Attributes
    ----------
    cells : SheetPoints
        Cell centres.
    nodes : SheetPoints
        Corners of the cells, for bases of hats.
    area : (n,) [m2]
    patches, node_patches : tuple of Patch
        The grids of cells and of nodes inside the flat arrays, left (y > 0) first, each with the size of its
        cells along its rows and across (arc length).
    """

    cells: SheetPoints
    nodes: SheetPoints
    area: Array
    patches: tuple[Patch, ...]
    node_patches: tuple[Patch, ...]

    @property
    def spacing(self) -> tuple[float, float]:
        """Mean cell size (dx, dy) [m] along the rows and across; only on rails that are not symmetric do
        cells differ."""
        dx, dy = np.mean([patch.spacing for patch in self.patches], axis=0).tolist()
        return dx, dy

    @property
    def points(self) -> Array:
        """Cell centres (3, n) [m]."""
        return self.cells.points

    @property
    def normal(self) -> Array:
        """Unit normals (3, n) at the cell centres."""
        return self.cells.normal

    @property
    def gap(self) -> Array:
        """Undeformed gap (n,) [m] at the cell centres."""
        return self.cells.gap


def contact_sheet(fields: dict[str, Any], names: Sequence[str]) -> ContactSheet:
    """A sheet from what the core returns, with a name for each of its grids."""
    cells, nodes = [], []
    for name, ((nx, ny, start, node_start), (dx, dy), (x0, y0)) in zip(names, fields["grids"], strict=True):
        cells.append(Patch(name, start, nx, ny, (dx, dy), (x0 + 0.5 * dx, y0 + 0.5 * dy)))
        nodes.append(Patch(name, node_start, nx + 1, ny + 1, (dx, dy), (x0, y0)))
    return ContactSheet(
        cells=SheetPoints(**fields["cells"]),
        nodes=SheetPoints(**fields["nodes"]),
        area=fields["area"],
        patches=tuple(cells),
        node_patches=tuple(nodes),
    )


@dataclass(frozen=True)
@plain
class PoleShoe:
    """A pole shoe of a magnetic track brake, each pole worn to the shape of the rail below it.

    Parameters
    ----------
    height : float [m]
        Height of the flat top above the crown.
    length : float [m]
    inner_edge, outer_edge : float [m]
        ``|y|`` of the edges of a pole.
    conforming_to : float [m]
        The sole follows the rail for ``inner_edge <= |y| <= conforming_to`` ...
    relief_slope : float [-]
        ... and rises from there with this slope ``dz/d|y|``.
    poles : int
        1 (left, y > 0) or 2.
    lateral, yaw : float [m], [rad]
        Offset along y and rotation about z of the shoe. The sole then no longer conforms; each pole
        is placed to just touch the rail.
    rail : str or Profile
    """

    height: float = 28.2e-3
    length: float = 90e-3
    inner_edge: float = 6e-3
    outer_edge: float = 36e-3
    conforming_to: float = 21.6e-3
    relief_slope: float = 0.02
    poles: int = 2
    lateral: float = 0.0
    yaw: float = 0.0
    rail: str | Profile = field(default="60E1")

    def __post_init__(self) -> None:
        put = object.__setattr__
        for name in ("inner_edge", "outer_edge", "conforming_to", "lateral"):
            put(self, name, number(name, getattr(self, name), "m"))
        for name in ("height", "length"):
            put(self, name, positive(name, getattr(self, name), "m"))
        put(self, "yaw", number("yaw", self.yaw, "rad"))
        put(self, "relief_slope", number("relief_slope", self.relief_slope))
        if isinstance(self.poles, bool) or not isinstance(self.poles, (int, np.integer)):
            raise ValueError(f"poles is {self.poles!r}: the whole number 1 or 2 is needed")
        if self.poles not in (1, 2):
            raise ValueError(f"poles is {self.poles!r}: a shoe has 1 or 2 poles")
        put(self, "rail", as_profile(self.rail))
        # one row of cells per pole, for the core to judge the rest at birth
        self.sheet((self.length, 1.0))
        if self.height <= max(0.0, *(float(self.sole(side * self.outer_edge)) for side in self.sides)):
            raise ValueError(f"height is {self.height:g} m: the top must lie above the sole and the crown")

    @property
    def profile(self) -> Profile:
        """Profile of the rail."""
        return as_profile(self.rail)

    @property
    def sides(self) -> tuple[float, ...]:
        """Sign of y of each pole, the left one first."""
        return (1.0, -1.0)[: self.poles]

    def sole(self, y: ArrayLike) -> Array:
        """Height z [m] of the sole in the shoe's own frame at `y` [m], any shape."""
        y, end = reals("y", y), self.conforming_to
        worn = self.profile.height(np.clip(y, -end, end) if self.poles == 2 else np.minimum(y, end))
        return np.asarray(worn + self.relief_slope * np.maximum(np.abs(y) - end, 0.0))

    def sheet(self, spacing: float | Sequence[float] = 3e-3) -> ContactSheet:
        """Sheet of equal cells that fill the conforming strip of every pole exactly.

        Regular in the shoe's own x and in the arc length of its sole, which for the centred shoe are
        those of the rail; the gap of the centred shoe is exactly zero. Both poles have as many cells, which
        differ in width where the two sides of the rail do.

        Parameters
        ----------
        spacing : float or (dx, dy) [m]
            Cell size wanted; whole numbers of cells come as close as they can.
        """
        fields = _mtb_rs.pole_shoe_sheet(
            self.profile._core,
            length=self.length,
            inner_edge=self.inner_edge,
            conforming_to=self.conforming_to,
            outer_edge=self.outer_edge,
            relief_slope=self.relief_slope,
            poles=self.poles,
            lateral=self.lateral,
            yaw=self.yaw,
            spacing=spacing_pair(spacing),
        )
        return contact_sheet(fields, ("left", "right")[: self.poles])


@owning
@dataclass(frozen=True)
@plain
class WheelRailGap:
    """Undeformed gap of a wheel on a rail over the contact plane, and where that plane lies.

    Track frame: x along the rail, y from the middle of the track towards the field side, z up from
    the highest point of the rail.

    Attributes
    ----------
    gap : (ny, nx) [m]
        Distance along the normal of the plane, the least one being zero.
    spacing : (dx, dy) [m]
    x, y : (nx,), (ny,) [m]
        Grid lines in the contact plane: along the rail, and across towards the field side; the origin
        is a grid point.
    contact_angle : float [rad]
        Slope of the contact plane, > 0 where it rises to the field side (flange contact).
    position : (3,) [m]
        Origin of the contact plane, on the rail, in the track frame.
    rotation : (3, 3)
        Columns: directions of x, y and normal of the contact plane in the track frame.
    rail_position, wheel_position : float [m]
        y of the origin in the profiles' own frames.
    first_rail_position : float [m]
        First contact of the undeformed bodies: y of the rail profile.
    undeformed_height : float [m]
        Height of the tape circle over the top of the rail at first contact.
    approach : float [m]
        Approach along the normal, given or estimated from the force.
    neglected : float [-]
        Share of the estimated contact area inclined by more than 20 degrees to the plane.
    """

    gap: Array
    spacing: tuple[float, float]
    x: Array
    y: Array
    contact_angle: float
    position: Array
    rotation: Array
    rail_position: float
    wheel_position: float
    first_rail_position: float
    undeformed_height: float
    approach: float
    neglected: float


def wheel_on_rail_gap(
    wheel: str | Profile = "S1002",
    rail: str | Profile = "60E1",
    *,
    wheel_radius: float = 0.46,
    gauge: float = 1.435,
    rail_inclination: float = 1 / 40,
    lateral: float = 6.2e-3,
    force: float = 36e3,
    approach: float | None = None,
    contact_modulus: float = 208e9 / 0.91 / 2,
    spacing: float | Sequence[float] = 1e-4,
    scale: float = 1.0,
    gauge_depth: float = 14e-3,
    flange_back: float = 1.360,
    tape_circle: float = 70e-3,
) -> WheelRailGap:
    """Where a wheel touches a rail, and the gap over the contact plane there; no yaw, no roll.

    The contact plane goes through the centroid of the estimated contact area with the rail's mean
    slope there. The wheel is a surface of revolution and the rail a prism, both exact.

    Parameters
    ----------
    wheel, rail : str or Profile
        Names of standard profiles, or profiles in their own frames: tape circle or crown at y = 0.
        Jagged profiles (``Profile.from_points(..., "linear")``) keep their kinks.
    wheel_radius : float [m]
        Radius of the tape circle.
    gauge, gauge_depth : float [m]
        Track gauge, and the depth below the top of the rail down to which it is measured.
    rail_inclination : float [rad]
        Rotation of the rail towards the middle of the track; 0 for profiles that have it in.
    lateral : float [m]
        Shift of the wheelset towards flange contact.
    force : float [N]
        Vertical force, for the estimate of the approach.
    approach : float [m], optional
        Approach along the normal, in place of the estimate.
    contact_modulus : float [Pa]
        1 / (1/E1' + 1/E2') with E' = E / (1 - nu^2), for the estimate; steel on steel by default.
    spacing : float or (dx, dy) [m]
    scale : float
        Size of the grid against the overlap of the undeformed bodies; raise it if the contact reaches
        the edge. The ends of the profiles bound the grid.
    flange_back, tape_circle : float [m]
        Distance between the backs of the flanges, and of the tape circle from them.

    Lengths that no railway has are warned of, not refused.
    """
    given = locals()
    placed = place_wheel(given)
    ask(of_wheel({**given, "wheel": as_profile(wheel), "rail": as_profile(rail)}))
    return placed


def place_wheel(given: Mapping[str, Any]) -> WheelRailGap:
    """What :func:`wheel_on_rail_gap` returns for all its arguments, without questions."""
    pair = spacing_pair(given["spacing"])
    approach = given["approach"]
    fields = _mtb_rs.wheel_on_rail_gap(
        as_profile(given["wheel"])._core,
        as_profile(given["rail"])._core,
        wheel_radius=positive("wheel_radius", given["wheel_radius"], "m"),
        gauge=positive("gauge", given["gauge"], "m"),
        gauge_depth=number("gauge_depth", given["gauge_depth"], "m"),
        rail_inclination=number("rail_inclination", given["rail_inclination"], "rad"),
        flange_back=number("flange_back", given["flange_back"], "m"),
        tape_circle=number("tape_circle", given["tape_circle"], "m"),
        lateral=number("lateral", given["lateral"], "m"),
        force=positive("force", given["force"], "N"),
        contact_modulus=positive("contact_modulus", given["contact_modulus"], "Pa"),
        approach=None if approach is None else number("approach", approach, "m"),
        spacing=pair,
        scale=positive("scale", given["scale"]),
    )
    x0, y0 = fields.pop("start")
    across, up = fields.pop("origin")
    ny, nx = fields["gap"].shape
    cos, sin = np.cos(fields["contact_angle"]), np.sin(fields["contact_angle"])
    return WheelRailGap(
        spacing=pair,
        x=x0 + pair[0] * np.arange(nx),
        y=y0 + pair[1] * np.arange(ny),
        position=np.array([0.0, across, up]),
        rotation=np.array([[1.0, 0.0, 0.0], [0.0, cos, -sin], [0.0, sin, cos]]),
        **fields,
    )
