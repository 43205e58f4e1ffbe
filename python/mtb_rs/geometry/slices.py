# SPDX-License-Identifier: MIT OR Apache-2.0
"""Rails whose profile varies along the track, and wheels whose profile varies around them."""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path
from typing import Any, ClassVar, NamedTuple, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .. import _mtb_rs
from ..base.check import path_of, reals
from ..base.files import read_text
from ..base.owning import frozen
from ..base.plain import same
from ..base.questions import ask
from .profiles import Profile, as_profile

Array = NDArray[np.float64]

#: How far the surface may go beyond sections side by side, over what all sections differ, and at least [m].
SWINGS, LEAST_SWING = 1.0, 1e-6
#: y at which that is looked at.
STATIONS = 25
#: Largest departure of a profile [m]: rails and tyres are not thicker.
MOST_DEPARTURE = 0.1
#: And that none in service has.
USUAL_DEPARTURE = 0.02
#: How a list joins its sections.
INTERPOLATED, APPROXIMATED = 1, 2
#: Angle [rad] up to which a turn is closed but for the digits of a scale.
CLOSED = 1e-3
#: Stretch of track [m] that sections with slices usually cover.
USUAL_STRETCH = (5e-3, 1e4)
#: What begins a remark in a list.
_REMARK = re.compile(r"[%!]")
#: A section in a list: its place, and the file of its profile.
_SECTION = re.compile(r"(\S+)\s+(['\"])(.+?)\2")


class _Slices:
    """What :class:`RailSlices` and :class:`WheelSlices` share."""

    __slots__ = ("_core", "_recipe", "name", "nominal", "positions")

    #: The body, the unit of the positions, what they are called, and what a departure is of.
    body: ClassVar[str]
    unit: ClassVar[str]
    place: ClassVar[str]
    is_around: ClassVar[bool]

    _core: _mtb_rs.Slices
    _recipe: tuple[Any, ...]
    name: str
    nominal: Profile
    positions: Array

    def __init__(
        self,
        positions: ArrayLike,
        profiles: Sequence[str | Profile],
        features: ArrayLike | None = None,
        nominal: str | Profile | None = None,
        name: str = "slices",
    ) -> None:
        self._through(positions, profiles, features, nominal, name)

    def _made(
        self,
        core: _mtb_rs.Slices,
        positions: Array,
        nominal: Profile,
        name: str,
        recipe: tuple[Any, ...],
    ) -> None:
        self._core = core
        self._recipe = recipe
        self.positions = positions
        self.nominal = nominal
        self.name = name

    def _through(
        self,
        positions: ArrayLike,
        profiles: Sequence[str | Profile],
        features: ArrayLike | None,
        nominal: str | Profile | None,
        name: str,
    ) -> None:
        places = _in_a_row(self.place, positions, self.unit)
        if isinstance(profiles, (str, Profile)):
            raise ValueError(f"profiles is {profiles!r}: a sequence of profiles is needed, one a section")
        try:
            listed = list(profiles)
        except TypeError:
            raise ValueError(
                f"profiles is {profiles!r}: a sequence of profiles is needed, one a section"
            ) from None
        sections = tuple(map(as_profile, listed))
        if not sections:
            raise ValueError("profiles is empty: one for each section is needed")
        shape = sections[0] if nominal is None else as_profile(nominal)
        lines: list[list[float]] = []
        if features is not None:
            table = frozen(reals("features", features, "m"))
            features = table
            own = places.size + (nominal is not None)
            if table.ndim != 2 or table.shape[0] != own:
                also = ", that of the nominal profile first" if nominal is not None else ""
                raise ValueError(
                    f"features has shape {table.shape}: (sections, features) = ({own}, k) is needed{also}"
                )
            # on the nominal profile first
            lines = (table if nominal is not None else table[[0, *range(own)]]).T.tolist()
        if not self.is_around and places.size > 1:
            way = float(places[-1] - places[0])
            low, high = USUAL_STRETCH
            if way > 0.0 and not low <= way <= high:
                ask(
                    [
                        f"positions go from {places[0]:g} to {places[-1]:g} m, over {way:g} m of track: are "
                        "they in metres? Those of lists (.slcs) are in millimetres, times their scale"
                    ]
                )
        core = _mtb_rs.Slices(
            shape._core, places, [section._core for section in sections], lines, self.is_around
        )
        recipe = (type(self), (places, sections, features, nominal, name))
        self._made(core, places, shape, name, recipe)
        if features is None:
            self._ask_about_swings()

    @classmethod
    def _raised(cls, profile: str | Profile, positions: ArrayLike, departure: ArrayLike, name: str) -> Self:
        places = _in_a_row(cls.place, positions, cls.unit)
        heights = _in_a_row("departure", departure, "m")
        if heights.size and np.abs(heights).max() > MOST_DEPARTURE:
            k = int(np.abs(heights).argmax())
            raise ValueError(
                f"departure[{k}] is {heights[k]:g} m: a profile that departs by {MOST_DEPARTURE:g} m at most "
                "is needed"
            )
        if heights.size and np.ptp(heights) > USUAL_DEPARTURE:
            ask(
                [
                    f"departure varies by {np.ptp(heights):.3g} m: {USUAL_DEPARTURE:g} m is more than wheels "
                    "and rails in service have, and lengths are in metres"
                ]
            )
        shape = as_profile(profile)
        # material that is there is up on a rail, and down, where z points away from, on a wheel
        sign = -1.0 if cls.is_around else 1.0
        core = _mtb_rs.Slices.raised(shape._core, places, sign * heights, cls.is_around)
        made = cls.__new__(cls)
        recipe = (cls._raised, (shape, places, heights, name))
        made._made(core, places, shape, name, recipe)
        made._ask_about_swings()
        return made

    def _ask_about_swings(self) -> None:
        """Asks where the surface leaves its sections by more than they differ, as a spline may at a step."""
        places = self.positions
        if places.size < 2:
            return
        ends = np.append(places, places[0] + 2.0 * np.pi) if self.is_around else places
        y = np.linspace(*self.range, STATIONS)
        own = self.height(ends[:, None], y)
        shares = np.array([0.25, 0.5, 0.75])
        between = ends[:-1, None] + shares * np.diff(ends)[:, None]
        surface = self.height(between[..., None], y)
        low, high = np.minimum(own[:-1], own[1:])[:, None], np.maximum(own[:-1], own[1:])[:, None]
        beyond = np.nan_to_num(np.maximum(surface - high, low - surface))
        differ = float(np.nanmax(own.max(axis=0) - own.min(axis=0)))
        if beyond.max() > max(SWINGS * differ, LEAST_SWING):
            i, j, _ = np.unravel_index(int(beyond.argmax()), beyond.shape)
            ask(
                [
                    f"at {between[i, j]:.4g} {self.unit} the surface of {self.name!r} is "
                    f"{1e3 * beyond.max():.3g} mm beyond the sections at {ends[i]:.4g} and {ends[i + 1]:.4g} "
                    f"{self.unit}, and all sections differ by {1e3 * differ:.3g} mm: a spline goes through "
                    "them, which swings beside a step between near sections. Give sections at about equal "
                    "distances around it"
                ]
            )

    @classmethod
    def _from_list(cls, path: str | Path, reading: dict[str, Any]) -> Self:
        path = path_of("path", path)
        try:
            listed = _listed(read_text(path, "list of slices"), cls.is_around)
        except ValueError as error:
            raise ValueError(f"list of slices {str(path)!r}: {error}") from None
        positions, files, table, left_out = listed
        ask(f"list of slices {str(path)!r}: {words}" for words in left_out)
        sections = []
        for file in files:
            try:
                sections.append(Profile.from_file(path.parent / file, **reading))
            except ValueError as error:
                raise ValueError(f"list of slices {str(path)!r}: the section {file!r}: {error}") from error
        features = None
        if table is not None:
            # places by the length along each section from its first point
            own = []
            for section, lengths in zip(sections, table, strict=True):
                first, last = section.arc_length(np.array(section.range))
                # lists close their last part by a length beyond the section
                own.append(section.position(np.clip(first + lengths, first, last)))
            features = np.array(own)
        return cls(positions, sections, features, None, path.name)

    @property
    def range(self) -> tuple[float, float]:
        """First and last y [m] on the nominal profile that all sections have."""
        return self._core.range()

    def height(self, position: ArrayLike, y: ArrayLike) -> Array:
        """Height z [m] of the profile at positions and y [m], of one shape; NaN beside the sections."""
        s, across = np.broadcast_arrays(reals(self.place, position, self.unit), reals("y", y, "m"))
        found = self._core.at(np.ascontiguousarray(s.ravel()), np.ascontiguousarray(across.ravel()))
        return np.asarray(found[0].reshape(s.shape))

    def departure(self, position: ArrayLike, y: ArrayLike) -> Array:
        """How far the surface stands out of its nominal profile [m], of one shape: > 0 for more material."""
        s, across = np.broadcast_arrays(reals(self.place, position, self.unit), reals("y", y, "m"))
        sign = -1.0 if self.is_around else 1.0
        return np.asarray(sign * (self.height(s, across) - self.nominal.height(across)))

    def plot(self, ax: Any = None) -> Any:
        """Draws the departure from the nominal profile over positions and y; returns the figure.

        Parameters
        ----------
        ax : matplotlib.axes.Axes, optional
        """
        from ..pictures import draw_slices

        return draw_slices(self, ax)

    def __reduce__(self) -> tuple[Any, ...]:
        return self._recipe

    def __eq__(self, other: object) -> bool:
        return type(self) is type(other) and same(self._recipe, other._recipe)

    def __hash__(self) -> int:
        return hash(self.name)

    def __repr__(self) -> str:
        first, last = self.positions[[0, -1]]
        ends = f"{self.place} = {first:g} .. {last:g} {self.unit}"
        return f"{type(self).__name__}({self.name!r}, {self.positions.size} sections, {ends})"


class RailSlices(_Slices):
    """A rail whose profile varies along the track: sections of switches, crossings, dips, joints.

    The surface is a spline through the sections, twice continuously differentiable along the track, at the
    same y of all of them. Before the first and after the last section the rail goes on as they are. In
    scenes x of the track is the position, both rails are alike (unless the right one is told by itself), and
    the height, the gauge and the zero pose are those of the nominal profile.

    Parameters
    ----------
    positions : (n,) [m]
        Places along the track, rising.
    profiles : sequence of str or Profile
        One a section, in one frame. What not all of them have is left out.
    features : (n, k) [m], optional
        y of features of the sections that belong together, such as a gauge corner or the nose of a crossing,
        rising in each row: the surface follows them, and does not blur them where they move aside. Between
        two features shapes are stretched across, beside them they are shifted. With `nominal` a first row has
        its features.
    nominal : str or Profile, optional
        Profile that height and gauge are measured on; None: the first one.
    name : str

    Raises
    ------
    ValueError
        If positions do not rise, sections have nothing in common, or features are not one row a section.

    Examples
    --------
    A dip of 0.3 mm over 60 mm:

    >>> s = np.linspace(0.0, 0.06, 31)
    >>> dip = RailSlices.uneven("60E1", s, -0.3e-3 * np.sin(np.pi * s / 0.06) ** 2)
    >>> round(1e3 * float(dip.height(0.03, 0.0)), 6)
    -0.3
    """

    __slots__ = ()
    body, unit, place, is_around = "rail", "m", "positions", False

    @classmethod
    def uneven(
        cls, profile: str | Profile, positions: ArrayLike, departure: ArrayLike, name: str = "uneven"
    ) -> RailSlices:
        """A profile raised all across by `departure` (n,) [m] at `positions` (n,) [m]; < 0 for dips."""
        return cls._raised(profile, positions, departure, name)

    @classmethod
    def from_file(cls, path: str | Path, **reading: Any) -> RailSlices:
        """Slices from a list of sections (``.slcs``): positions and the files of their profiles.

        Positions are in millimetres, times the scale and from the offset of the list. Files are found from
        the folder of the list. Features, which a list has by the length along each section, are taken.

        Parameters
        ----------
        path : str or Path
        reading
            How profiles are read: arguments of :meth:`mtb_rs.Profile.from_file`.

        Raises
        ------
        ValueError
            If the list or one of its profiles cannot be read, or a section leaves out a feature.
        """
        return cls._from_list(path, reading)


class WheelSlices(_Slices):
    """A wheel whose profile varies around it: out of round, with flats, measured in sections.

    The surface is a spline through the sections, twice continuously differentiable around the wheel, which
    closes. Sections that leave out more than twice their widest step have a straight line there. At zero
    pitch the angle 0 points down, and the wheel stands on its angle `pitch` when it has rolled forwards
    by that. Both wheels of a wheelset are alike, unless the right one is told by itself. The radius at an
    angle is `wheel_radius` less z of the profile there.

    Parameters
    ----------
    angles : (n,) [rad]
        Places around the wheel, rising, once around at most; forwards at its lower side.
    profiles : sequence of str or Profile
        One a section, in one frame. What not all of them have is left out.
    features : (n, k) [m], optional
        As of :class:`RailSlices`.
    nominal : str or Profile, optional
        Profile that the zero pose stands on; None: the first one.
    name : str

    Raises
    ------
    ValueError
        If there are fewer than four sections, their angles do not rise or go around more than once, sections
        have nothing in common, or features are not one row a section.

    Examples
    --------
    A wheel whose centre is off its axle by 0.2 mm:

    >>> angles = np.linspace(-np.pi, np.pi, 73)
    >>> wheel = WheelSlices.out_of_round("S1002", angles, 0.2e-3 * np.cos(angles))
    >>> round(1e3 * float(wheel.departure(0.0, 0.0)), 6)
    0.2
    """

    __slots__ = ()
    body, unit, place, is_around = "wheel", "rad", "angles", True

    def __init__(
        self,
        angles: ArrayLike,
        profiles: Sequence[str | Profile],
        features: ArrayLike | None = None,
        nominal: str | Profile | None = None,
        name: str = "slices",
    ) -> None:
        self._through(angles, profiles, features, nominal, name)

    @classmethod
    def out_of_round(
        cls, profile: str | Profile, angles: ArrayLike, departure: ArrayLike, name: str = "out of round"
    ) -> WheelSlices:
        """A profile whose radius departs by `departure` (n,) [m] at `angles` (n,) [rad]; < 0 for flats."""
        return cls._raised(profile, angles, departure, name)

    @classmethod
    def from_file(cls, path: str | Path, **reading: Any) -> WheelSlices:
        """Slices from a list of sections (``.slcw``): angles and the files of their profiles.

        Angles are in radians, times the scale and from the offset of the list, and those beyond half a turn
        to either side, which lists repeat, are left out. Else as :meth:`RailSlices.from_file`.
        """
        return cls._from_list(path, reading)


def _in_a_row(name: str, given: Any, unit: str) -> Array:
    values = np.atleast_1d(reals(name, given, unit))
    if values.ndim != 1:
        raise ValueError(f"{name} has shape {values.shape}: numbers in a row [{unit}] are needed")
    return frozen(values)


def nominal_of(name: str, given: Any, side: str = "") -> tuple[Profile, _mtb_rs.Slices | None]:
    """The profile of the `name` "wheel" or "rail", nominal where it has slices, and those.

    `side`: nothing, or "right_" where the argument is called so.
    """
    if not isinstance(given, (_Slices, Profile, str)):
        raise ValueError(
            f"{side}{name} is {given!r}: a Profile, the name of a standard one, or slices are needed"
        )
    if not isinstance(given, _Slices):
        return as_profile(given), None
    if given.body != name:
        accepted = "WheelSlices" if name == "wheel" else "RailSlices"
        raise ValueError(f"{side}{name} is {given!r}: {accepted}, a Profile or the name of one is needed")
    return given.nominal, given._core


class _List(NamedTuple):
    """What a list of slices says."""

    #: [m] or [rad]
    positions: Array
    files: list[str]
    #: Lengths [m] of features along the sections.
    features: Array | None
    #: Sentences on what of it has no part.
    left_out: list[str]


def _listed(text: str, is_around: bool) -> _List:
    """A list of slices [the slcs and slcw files of CONTACT]."""
    rows = [(number, _REMARK.split(line)[0].strip()) for number, line in enumerate(text.splitlines(), 1)]
    rows = [(number, line) for number, line in rows if line]
    if len(rows) < 4:
        raise ValueError("it ends before its header does: offset and scale, counts and method are needed")
    offset, scale = _leading(rows[0], 2)
    n, (k, kinks, bends) = _counts(rows[1], 1)[0], _counts(rows[2], 3)
    (method,) = _counts(rows[3], 1)
    if method not in (INTERPOLATED, APPROXIMATED):
        raise ValueError(
            f"line {rows[3][0]} is {rows[3][1]!r}: how the sections are joined is needed, 1 for a spline "
            "through them, 2 for one along them"
        )
    left_out = []
    if method == APPROXIMATED:
        left_out.append("its sections would be approximated by a spline, and here it goes through them")
    sections, rest = rows[4 : 4 + n], rows[4 + n :]
    if more := [place for place, words in rest if _SECTION.match(words)]:
        raise ValueError(f"it states {n} sections, and line {more[0]} names a further one")
    if len(sections) < n:
        raise ValueError(f"it names {len(sections)} sections and states {n}")
    if k > 1 and kinks + bends:
        # a row of part numbers for each of both
        for parts, count in zip(rest, filter(None, (kinks, bends)), strict=False):
            _leading(parts, count)
        rest = rest[bool(kinks) + bool(bends) :]
        left_out.append(
            f"it states kinks or bends between its parts ({kinks} and {bends}), which profiles have of their "
            "own: these are taken"
        )
    positions, files = [], []
    for number, line in sections:
        found = _SECTION.match(line)
        if not found:
            raise ValueError(
                f"line {number} is {line!r}: a position and the name of a file in quotes are needed"
            )
        positions.append(_number(found[1], number))
        # as some systems part folders
        files.append(found[3].replace("\\", "/"))
    if not scale > 0.0:
        raise ValueError(
            f"line {rows[0][0]} is {rows[0][1]!r}: the scale, its second number, must be above 0"
        )
    unit = 1.0 if is_around else 1e-3
    places = unit * (scale * (np.array(positions) + offset))
    keep = np.ones(n, bool)
    if is_around and n:
        keep, said = _one_turn(places, files)
        left_out += said
    table = None
    if k > 1:
        own = {}
        for line_of in rest[:n]:
            values = _leading(line_of, k + 1)
            own[values[0]] = values[1:]
        missing = [position for position in positions if position not in own]
        if missing:
            raise ValueError(f"the section at {missing[0]:g} has no row of features")
        table = 1e-3 * np.array([own[position] for position in positions])
        if (table < 0.0).any():
            row = int(np.argwhere(table < 0.0)[0, 0])
            raise ValueError(
                f"the section at {positions[row]:g} leaves out a feature: sections that end before others do "
                "are not taken, so give the sections that have all features in a list of their own"
            )
        table = table[keep]
    kept = [file for file, is_kept in zip(files, keep, strict=True) if is_kept]
    return _List(places[keep], kept, table, left_out)


def _one_turn(places: Array, files: list[str]) -> tuple[NDArray[np.bool_], list[str]]:
    """Which sections of a list around a wheel go around it once, and what to say of the others.

    Lists may go on over half a turn more and repeat sections there. A last section that is the first one
    again is put where it closes the turn, but for the digits of the scale.
    """
    turn, first, last = 2.0 * np.pi, float(places[0]), float(places[-1])
    is_usual = -1.5 * np.pi - CLOSED <= first and last <= 1.5 * np.pi + CLOSED
    if not is_usual and not -CLOSED <= first <= last <= turn + CLOSED:
        raise ValueError(
            f"its angles go from {first:.4g} to {last:.4g} rad: 0 to 2 pi, or -1.5 pi to 1.5 pi at most, are "
            "needed. Of a list in degrees the scale, the second number of its first line, is 0.0174532925"
        )
    keep = np.ones(len(places), bool)
    if abs(last - first - turn) < CLOSED:
        places[-1] = first + turn
        return keep, []
    if last - first < turn:
        return keep, []
    start = float(np.clip(-np.pi, first, last - turn))
    keep = (places >= start - CLOSED) & (places < start + turn - CLOSED)
    said = []
    for k in np.flatnonzero(~keep).tolist():
        same = np.flatnonzero(keep & (np.abs(np.abs(places - places[k]) - turn) < CLOSED))
        if not same.size:
            said.append(f"the section at {places[k]:.6g} rad lies beyond one turn and is left out")
        elif files[same[0]] != files[k]:
            raise ValueError(
                f"the section at {places[k]:.6g} rad is {files[k]!r}, and a turn away, at "
                f"{places[same[0]]:.6g} rad, it is {files[same[0]]!r}: the same one is needed"
            )
    return keep, said


def _counts(row: tuple[int, str], most: int) -> list[int]:
    """The counts of a line, up to `most` of them; those that it leaves out are 0."""
    number, line = row
    words = line.replace(",", " ").split()[:most]
    found: list[int] = []
    for word in words:
        if not word.isdigit():
            break
        found.append(int(word))
    if not found:
        raise ValueError(f"line {number} is {line!r}: a count, a whole number from 0 on, is needed")
    return found + [0] * (most - len(found))


def _leading(row: tuple[int, str], count: int) -> list[float]:
    """The first numbers of a line."""
    number, line = row
    words = line.replace(",", " ").split()
    if len(words) < count:
        raise ValueError(f"line {number} is {line!r}: {count} numbers are needed")
    return [_number(word, number) for word in words[:count]]


def _number(word: str, line: int) -> float:
    try:
        value = float(word.replace("d", "e").replace("D", "e"))
    except ValueError:
        value = np.nan
    if not np.isfinite(value):
        raise ValueError(f"line {line}: {word!r} is no number")
    return value
