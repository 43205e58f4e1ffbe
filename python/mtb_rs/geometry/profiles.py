# SPDX-License-Identifier: MIT OR Apache-2.0
"""Profiles, surfaces, grids of contact points and gaps. SI units, z up."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .. import _mtb_rs
from ..base.check import choice, path_of, reals
from ..base.files import read_text
from ..base.owning import frozen
from ..base.plain import same
from ..base.questions import ask
from ..base.words import Interpolation, Unit, ZAxis
from .contact_points import ROUNDING

Array = NDArray[np.float64]

#: Profiles known by name: rail head 60E1 (UIC 60, EN 13674-1), wheel S1002 (EN 13715).
STANDARD_PROFILES = ("60E1", "S1002")
#: Widths [m] of rails and wheels, toys included.
USUAL_WIDTH = (5e-3, 0.5)

#: Metres per unit of length.
UNITS: dict[Unit, float] = {"m": 1.0, "mm": 1e-3, "um": 1e-6, "in": 0.0254}


def metres(unit: Unit) -> float:
    """Length of a unit known by name [m]."""
    return UNITS[choice("unit", unit, Unit)]


class Profile:
    """Height z(y) [m] of the cross-section of a rail or a wheel, z up.

    Rails have their crown at y = 0. Wheels have the tape circle at y = 0, the field side at y > 0 and the
    flange at y < 0. Use :meth:`standard`, :meth:`from_points` or :meth:`from_file` to make a profile.

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

    def __init__(self, core: _mtb_rs.Profile, name: str = "", recipe: tuple[Any, ...] = ()) -> None:
        if not isinstance(core, _mtb_rs.Profile):
            raise ValueError(
                "a Profile is made by Profile.standard, Profile.from_points or Profile.from_file, not by "
                "its class"
            )
        self._core = core
        self._recipe = recipe
        self.name = name

    @classmethod
    def standard(cls, name: str) -> Profile:
        """Standard profile of the given name: "60E1" or "S1002"."""
        makers = {"60E1": _mtb_rs.Profile.rail_60e1, "S1002": _mtb_rs.Profile.wheel_s1002}
        if not isinstance(name, str) or name not in makers:
            raise ValueError(
                f"profile {name!r} is unknown: {', '.join(STANDARD_PROFILES)} are known by name, and "
                "Profile.from_file reads a file"
            )
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
            Its columns are separated by blanks, commas or semicolons; comments begin with #, !, % or //. A
            heading gives their order and units, for example ``z [mm], y [mm]``. Files of more than two
            columns need a heading.
        interpolation : "smooth" or "linear"
        unit : str
            Length unit of files that do not state theirs: "m", "mm", "um" or "in".
        z_axis : "up", "down" or "guess"
            Direction of z in the file. A guess takes the larger departure from the median height as down,
            because rails fall off at their flanks and wheels at their flange.

        A width that no rail or wheel has gives a warning, because it is mostly a mistake in the unit.

        Raises
        ------
        ValueError
            If the file cannot be read. For a wrong line the message names it.
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
        profile = cls(core, path.name, recipe)
        ask(f"profile file {str(path)!r}: {question}" for question in of_width("profile", profile))
        return profile

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


def of_width(name: str, profile: Profile) -> list[str]:
    """A question about a profile that is wider or narrower than rails and wheels are."""
    start, end = profile.range
    low, high = USUAL_WIDTH
    if low <= end - start <= high:
        return []
    return [
        f"the width of the {name} is {end - start:.4g} m: {low:g} to {high:g} m is usual; state the unit of "
        "a file in its heading (y [mm], z [mm]) or by unit=, and lengths in metres elsewhere"
    ]


def as_profile(profile: str | Profile) -> Profile:
    """A profile, or the standard one of that name."""
    return profile if isinstance(profile, Profile) else Profile.standard(profile)
