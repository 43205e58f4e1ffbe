# SPDX-License-Identifier: MIT OR Apache-2.0
"""Profiles, surfaces, grids of contact points and gaps. SI units, z up."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .. import _mtb_rs
from ..base.check import choice, path_of, reals
from ..base.files import read_text, write_bytes
from ..base.owning import frozen
from ..base.plain import same
from ..base.questions import ask
from ..base.words import Interpolation, Shape, Unit, ZAxis
from .contact_points import ROUNDING
from .profile_files import FLANGE_HEIGHT, USUAL_WIDTH, departs_upwards, recognised
from .smoothing import Smoothing, smoothed

Array = NDArray[np.float64]

#: Profiles known by name: rail head 60E1 (UIC 60, EN 13674-1), wheel S1002 (EN 13715).
STANDARD_PROFILES = ("60E1", "S1002")


class Profile:
    """Height z(y) [m] of the cross-section of a rail or a wheel, z up.

    Rails have their crown at y = 0. Wheels have the tape circle at y = 0, the field side at y > 0 and the
    flange at y < 0. Use :meth:`standard`, :meth:`from_points` or :meth:`from_file` to make a profile, and
    :meth:`smoothed` to take the noise out of a measured one.

    Attributes
    ----------
    name : str
    smoothing : Smoothing or None
        What :meth:`smoothed` has done to it, with the residual.

    Examples
    --------
    >>> rail = Profile.standard("60E1")
    >>> round(float(rail.height(0.02)) * 1e3, 3)
    -1.11
    """

    __slots__ = ("_core", "_points", "_recipe", "name", "smoothing")

    _core: _mtb_rs.Profile
    _points: tuple[Array, Array] | None
    _recipe: tuple[Any, ...]
    name: str
    smoothing: Smoothing | None

    def __init__(
        self,
        core: _mtb_rs.Profile,
        name: str = "",
        recipe: tuple[Any, ...] = (),
        points: tuple[Array, Array] | None = None,
        smoothing: Smoothing | None = None,
    ) -> None:
        if not isinstance(core, _mtb_rs.Profile):
            raise ValueError(
                "a Profile is made by Profile.standard, Profile.from_points or Profile.from_file, not by "
                "its class"
            )
        self._core = core
        self._recipe = recipe
        self._points = points
        self.name = name
        self.smoothing = smoothing

    @classmethod
    def standard(cls, name: str) -> Profile:
        """Standard profile of the given name: "60E1" or "S1002"."""
        makers = {"60E1": _mtb_rs.Profile.rail_60e1, "S1002": _mtb_rs.Profile.wheel_s1002}
        if not isinstance(name, str) or name not in makers:
            raise ValueError(
                f"profile {name!r} is unknown: {', '.join(STANDARD_PROFILES)} are known by name, and "
                "Profile.from_file reads a file; RailSlices and WheelSlices are for prepared wheels"
            )
        return cls(makers[name](), name, (cls.standard, (name,)))

    @classmethod
    def from_points(
        cls,
        y: ArrayLike,
        z: ArrayLike,
        interpolation: Interpolation = "smooth",
        name: str = "table",
        *,
        z_axis: ZAxis = "up",
    ) -> Profile:
        """Profile through points (y, z) [m], y strictly rising or strictly falling.

        "smooth" is a cubic spline, "linear" keeps every irregularity of the table. `z_axis` is the direction
        of z in the table, as in :meth:`from_file`, but "up" by default.
        """
        y, z = np.atleast_1d(reals("y", y)), np.atleast_1d(reals("z", z))
        if y.ndim != 1 or z.ndim != 1:
            raise ValueError(
                f"y and z have shapes {y.shape} and {z.shape}: one-dimensional arrays are needed"
            )
        choice("interpolation", interpolation, Interpolation)
        choice("z_axis", z_axis, ZAxis)
        # as of files
        if z_axis == "down" or (z_axis == "guess" and z.size and departs_upwards(z)):
            z = -z
        core = _mtb_rs.Profile.from_points(y, z, interpolation)
        points = frozen(y), frozen(z)
        return cls(core, name, (cls.from_points, (*points, interpolation, name)), points)

    @classmethod
    def from_file(
        cls,
        path: str | Path,
        interpolation: Interpolation = "smooth",
        *,
        unit: Unit | Literal["guess"] = "guess",
        z_axis: ZAxis = "guess",
        mirror: bool | Literal["guess"] = "guess",
    ) -> Profile:
        """Profile from a file: two columns (y, z), .prr or .prw with a header, or MiniProf's .ban or .whl.

        Forms are known by their content, not by the ending. What a file does not say is recognised from its
        points: unit, order of the points and of the columns, direction of z, mirror; each guess that may be
        wrong is said in a warning, and the argument that states it silences that. Points that repeat the one
        before are left out, and so are the ends where y turns back, as it does behind a flange.

        Parameters
        ----------
        path : str or Path
            Columns are separated by blanks, commas or semicolons, and numbers between semicolons or tabs may
            have decimal commas; exponents may be those of Fortran (``1.5D-03``), and comments begin with #,
            !, % or //. A heading gives their order and units, for example ``z [mm], y [mm]``, and may call
            them x and z, or x and y, too. Files of more than two columns need a heading. Of MiniProf files X
            and Y are taken as they are, without the alignment that a header may describe.
        interpolation : "smooth" or "linear"
        unit : str
            Length unit of files that do not state theirs: "m", "mm", "um" or "in". A guess takes mm, but m or
            µm where only these give the width of a rail or a wheel.
        z_axis : "up", "down" or "guess"
            Direction of z in the file. A guess takes the larger departure from the median height as down,
            because rails fall off at their flanks and wheels at their flange.
        mirror : bool or "guess"
            Whether y is turned over. The flange of a wheel and the gauge face of a rail belong to y < 0; a
            guess turns over what goes down at y > 0 only.

        A width that no rail or wheel has gives a warning, because it is mostly a mistake in the unit; so does
        a profile that is steep at y = 0, where rails have their crown and wheels their tape circle.

        Raises
        ------
        ValueError
            If the file cannot be read, holds several profiles, or lists sections (slices), which
            :class:`RailSlices` and :class:`WheelSlices` read.
            For a wrong line the message names it.
        """
        path = path_of("path", path)
        choice("interpolation", interpolation, Interpolation)
        choice("z_axis", z_axis, ZAxis)
        if unit != "guess":
            choice("unit", unit, Unit)
        if not (isinstance(mirror, bool) or mirror == "guess"):
            raise ValueError(f'mirror is {mirror!r}: True, False or "guess" is needed')
        text = read_text(path, "profile file")
        try:
            y, z, stated, form = _mtb_rs.read_profile(text)
            points = recognised(y, z, stated=stated, form=form, unit=unit, z_axis=z_axis, mirror=mirror)
            profile = cls.from_points(points.y, points.z, interpolation, path.name)
        except ValueError as error:
            raise ValueError(f"profile file {str(path)!r}: {error}") from None
        questions = [*points.notes, *of_width("profile", profile)]
        ask(f"profile file {str(path)!r}: {question}" for question in questions)
        return profile

    @classmethod
    def _of_numbers(cls, numbers: Array, name: str, smoothing: Smoothing) -> Profile:
        """A smoothed profile, also from a pickle."""
        core = _mtb_rs.Profile.from_numbers(numbers)
        recipe = (cls._of_numbers, (frozen(numbers), name, smoothing))
        return cls(core, name, recipe, (smoothing.y, smoothing.z), smoothing)

    def smoothed(
        self,
        wavelength: float = 4e-3,
        *,
        kinks: Sequence[float] | None = None,
        kink_angle: float = 0.2,
    ) -> Profile:
        """The profile without its noise: smoothing splines of y and z over the arc length (extra ``smooth``).

        A cubic smoothing spline [Reinsch1967] takes the points, and another one what that leaves: together
        they keep the share 1 - (x / (1 + x))^2 of the height of a wave along the profile, with x = 2.414
        (wavelength / length)^4. The points carry the same weight by their length along the profile, however
        they are spaced. Kinks part it into pieces that are smoothed apart and meet.

        Parameters
        ----------
        wavelength : float [m]
            Waves of this length keep half of their height, those of twice the length 98 %, those of half the
            length 5 %.
        kinks : (k,) [m] or None
            Places y of kinks, () for none; None: they are recognised by their angle.
        kink_angle : float [rad]
            Angle from which on a kink is recognised: that between parabolas through the points on either
            side, over a wavelength. A jump of curvature is none.

        Returns
        -------
        Profile
            Its `smoothing` has the largest and the rms distance of the points, and the kinks.

        Raises
        ------
        ValueError
            For profiles that are no points, such as standard ones, a wavelength shorter than two steps or
            longer than the profile, kinks outside or too near to each other, and where the smoothed profile
            turns back.
        """
        if self._points is None:
            raise ValueError(f"the profile {self.name!r} is made of formulas: there is no noise to smooth")
        y, z = self._points
        if y[-1] < y[0]:
            y, z = y[::-1], z[::-1]
        found = smoothed(y, z, wavelength, kinks, kink_angle)
        return self._of_numbers(found.numbers, f"{self.name}, smoothed", found.smoothing)

    def plot(self, quantity: Shape = "height", ax: Any = None) -> Any:
        """Draws the profile, into matplotlib's axes `ax` if given; returns the figure.

        Parameters
        ----------
        quantity : "height", "angle" or "curvature"
            Over y. The height has equal scales along both axes, and the points of a table; of a smoothed
            profile the points before and the kinks are drawn as well.
        ax : matplotlib.axes.Axes, optional
        """
        from ..pictures import draw_profile

        return draw_profile(self, choice("quantity", quantity, Shape), ax)

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

    def to_file(self, path: str | Path, y: ArrayLike | None = None) -> None:
        """Writes points of the profile in the form of .prr and .prw files, in millimetres, z down.

        :meth:`from_file` and the programs that read these forms take it again.

        Parameters
        ----------
        path : str or Path
        y : (n,) [m] or None
            Where; None: 1001 places over its range, and all places where its formula changes.

        Raises
        ------
        ValueError
            If `y` lies outside of the range, or the path is a directory.
        OSError
            If nothing can be written there.
        """
        start, end = self.range
        if y is None:
            places = np.union1d(np.linspace(start, end, 1001), self.breaks)
            # breaks beside one of the places are one point of it
            places = places[np.append(True, np.diff(places) > 1e-9 * (end - start))]
        else:
            places = np.unique(reals("y", y, "m"))
        name = self.name.encode("ascii", "replace").decode()
        lines = [
            "header.begin",
            "  version = 1",
            "header.end",
            "spline.begin",
            "  approx.smooth = 0.0",
            f"  comment = '{name}: y and z down in mm, written by mtb_rs'".replace("''", "'profile'"),
            "  units.len.f = 1000.0",
            "  point.begin",
            *(
                f"    {across:.17g} {down:.17g} 1.0"
                for across, down in zip(1e3 * places, -1e3 * self.height(places), strict=True)
            ),
            "  point.end",
            "spline.end",
        ]
        write_bytes(path, "\n".join([*lines, ""]).encode())

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


#: Height of a wheel profile at its tape circle [m] that no wear makes.
MOST_WORN = 6e-3


def of_shape(wheel: Profile, rail: Profile) -> list[str]:
    """Questions about profiles that look turned over, mirrored or taken for each other."""
    (wheel_falls, wheel_rises), (rail_falls, rail_rises) = map(_departures, (wheel, rail))
    if min(wheel_falls) > FLANGE_HEIGHT and min(rail_falls) < 0.5 * FLANGE_HEIGHT < 0.5 * max(rail_falls):
        return [
            "the wheel profile falls off on both sides, as a rail does, and the rail profile on one side "
            "only, as a wheel does: wheel and rail look swapped"
        ]
    start, end = wheel.range
    worn = float(wheel.height(0.0)) if start <= 0.0 <= end else 0.0
    questions = []
    if abs(worn) > MOST_WORN:
        questions.append(
            f"the wheel profile has z = {1e3 * worn:.3g} mm at y = 0, so that the radius of its tape circle "
            "is wheel_radius - z: wheels wear by less, and a profile is shifted in z such that "
            "wheel_radius, as measured at the tape circle, is at z = 0"
        )
    turned = "z points up here: Profile.from_points and Profile.from_file take z_axis"
    if max(wheel_rises) > FLANGE_HEIGHT:
        questions.append(
            f"the wheel profile rises by {1e3 * max(wheel_rises):.3g} mm beside the tape circle, where a "
            f"flange goes down: it looks upside down; {turned}"
        )
    elif wheel_falls[1] > FLANGE_HEIGHT > 2.0 * wheel_falls[0]:
        questions.append(
            f"the wheel profile goes down by {1e3 * wheel_falls[1]:.3g} mm at y > 0, the field side: its "
            "flange belongs to y < 0, and the profile looks mirrored"
        )
    if max(rail_rises) > FLANGE_HEIGHT:
        questions.append(
            f"the rail profile rises by {1e3 * max(rail_rises):.3g} mm beside its crown at y = 0: it looks "
            f"upside down; {turned}"
        )
    return questions


def _departures(profile: Profile) -> tuple[list[float], list[float]]:
    """How far a profile falls below, and rises above, its height at y = 0 [m]: at y < 0 and at y > 0."""
    start, end = profile.range
    middle = float(profile.height(min(max(0.0, start), end)))
    falls, rises = [], []
    for low, high in ((start, min(0.0, end)), (max(0.0, start), end)):
        # of a side that the profile does not have nothing departs
        z = profile.height(np.linspace(low, high, 200)) - middle if low < high else np.zeros(1)
        falls.append(-min(0.0, float(z.min())))
        rises.append(max(0.0, float(z.max())))
    return falls, rises


def of_pair(wheel: Profile, rail: Profile, side: str = "") -> list[str]:
    """Questions about the profiles of a wheel and of its rail; `side` is what their names begin with."""
    widths = (of_width(f"{side}{name} profile", p) for name, p in (("wheel", wheel), ("rail", rail)))
    return [*(words for found in widths for words in found), *of_shape(wheel, rail)]


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
