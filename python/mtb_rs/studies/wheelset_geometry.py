# SPDX-License-Identifier: MIT OR Apache-2.0
"""Where a rigid wheelset touches its rails over the lateral shift, and what follows for its running."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .. import _mtb_rs
from ..base.check import choice, number, positive, reals
from ..base.owning import owning
from ..base.plain import plain
from ..base.questions import ask, unusual
from ..base.stored import stored
from ..base.told import Row
from ..base.units import taking_quantities
from ..base.words import Axle, Guidance, Linearisation, Wheels
from ..geometry.profiles import Profile, as_profile, of_pair
from ..geometry.wheel_rail import USUAL_LENGTHS
from ..results.doors import pictures, png
from ..results.study import Study
from .conicity import equivalent_conicity, klingel_wavelength, middle_of

Array = NDArray[np.float64]

#: Amplitudes [m] of curves of equivalent conicity: of tables of EN 15302 and below.
AMPLITUDES = np.arange(0.5e-3, 12.01e-3, 0.25e-3)
#: Points that a profile is kept at for pictures.
DRAWN = 600
_UNITS = {
    "shift": "m",
    "height": "m",
    "roll": "rad",
    "radius_difference": "m",
    "y": "m",
    "z": "m",
    "rail_position": "m",
    "wheel_position": "m",
    "contact_angle": "rad",
    "rolling_radius": "m",
}


@stored
@owning
@dataclass(frozen=True)
@plain
class TouchingWheel:
    """Contact points of one wheel over the lateral shift of its wheelset.

    Attributes
    ----------
    y, z : (n,) [m]
        Contact point in the track: y to the left from its middle, z up from the top of the rail.
    rail_position, wheel_position : (n,) [m]
        y of the contact point in the frames of the profiles.
    contact_angle : (n,) [rad]
        Slope of the rail there, > 0 where it rises to the field side (flange contact).
    rolling_radius : (n,) [m]
    rail, wheel : (2, k) [m]
        The profiles, y and z in their own frames, for pictures.
    wheel_radius : float [m]
        At the tape circle.
    """

    y: Array
    z: Array
    rail_position: Array
    wheel_position: Array
    contact_angle: Array
    rolling_radius: Array
    rail: Array
    wheel: Array
    wheel_radius: float

    _columns: ClassVar[tuple[str, ...]] = (
        "y",
        "z",
        "rail_position",
        "wheel_position",
        "contact_angle",
        "rolling_radius",
    )


@stored
@owning
@dataclass(frozen=True)
@plain
class WheelsetGeometry(Study):
    """Contact points of a wheelset over its lateral shift, as :func:`mtb_rs.wheelset_geometry` finds them.

    Attributes
    ----------
    shift : (n,) [m]
        Of the wheelset to the left.
    height : (n,) [m]
        Of the middle of the axle over the top of the rails; of a level axle the mean of what the two wheels
        take.
    roll : (n,) [rad]
        About the track, > 0 where the left wheel stands higher; 0 of a level axle.
    left, right : TouchingWheel
    base : float [m]
        Distance between the tape circles.
    rail_inclination : float [rad]
    names : (str, str)
        Of the left wheel and its rail.
    """

    usual_name: ClassVar[str] = "wheelset_geometry"
    called: ClassVar[str] = "wheelset geometry"
    endings: ClassVar[tuple[str, ...]] = ("png", "csv")

    shift: Array
    height: Array
    roll: Array
    left: TouchingWheel
    right: TouchingWheel
    base: float
    rail_inclination: float
    names: tuple[str, str]

    @property
    def radius_difference(self) -> Array:
        """Rolling radius of the left wheel less that of the right one (n,) [m]."""
        return self.left.rolling_radius - self.right.rolling_radius

    @property
    def wheel_radius(self) -> float:
        """Mean radius at the tape circles [m]."""
        return 0.5 * (self.left.wheel_radius + self.right.wheel_radius)

    def equivalent_conicity(
        self, amplitude: ArrayLike = 3e-3, method: Linearisation = "integration"
    ) -> Array:
        """Equivalent conicity [-] at amplitudes [m] of any shape; see :func:`mtb_rs.equivalent_conicity`."""
        return equivalent_conicity(self.shift, self.radius_difference, amplitude, method)

    def wavelength(self, amplitude: ArrayLike = 3e-3) -> Array:
        """Wavelength of the free kinematic motion [m] at amplitudes [m] of any shape: that of cones of the
        equivalent conicity by :func:`mtb_rs.klingel_wavelength`; NaN where there is no such motion."""
        cone = self.equivalent_conicity(amplitude)
        known = np.where(cone > 0.0, cone, 1.0)
        return np.where(cone > 0.0, klingel_wavelength(known, self.wheel_radius, self.base), np.nan)

    def amplitudes(self) -> Array:
        """Amplitudes [m] that pictures and tables of the equivalent conicity have."""
        middle = middle_of(self.shift, self.radius_difference)
        if middle is None:
            return np.empty(0)
        reach = min(middle - self.shift[0], self.shift[-1] - middle)
        inside: Array = AMPLITUDES[float(reach) + 1e-12 >= AMPLITUDES]
        return inside

    def plot(self, quantity: Guidance = "contact_points", ax: Any = None, side: Wheels = "both") -> Any:
        """Draws it, into matplotlib's axes `ax` if given; returns the figure.

        Parameters
        ----------
        quantity : str
            "contact_points" draws the wheels raised over their rails, with lines that join the points that
            touch each other. "radius_difference" and "contact_angle" are drawn over the shift,
            "equivalent_conicity" and "wavelength" over the amplitude, "rail_position" and "wheel_position",
            the places on the profiles, over the shift.
        ax : matplotlib.axes.Axes, optional
        side : "left", "right" or "both"
            Which wheel; "contact_points" of both takes no `ax`.
        """
        choice("quantity", quantity, Guidance)
        choice("side", side, Wheels)
        return pictures().draw_wheelset_geometry(self, quantity, ax, side)

    def told(self) -> list[Row]:
        """Its figures in words: what a notebook shows beside the picture."""
        span = f"{1e3 * self.shift[0]:.4g} to {1e3 * self.shift[-1]:.4g} mm"
        rows = [("wheel on rail", " on ".join(self.names)), ("lateral shift", span)]
        amplitudes = self.amplitudes()
        if amplitudes.size and amplitudes[-1] >= 3e-3 - 1e-12:
            cone = {m: float(self.equivalent_conicity(3e-3, m)) for m in ("integration", "harmonic")}
            rows += [
                (f"equivalent conicity at 3 mm, {m}", f"{value:.4f}" if value == value else "none")
                for m, value in cone.items()
            ]
            wave = float(self.wavelength(3e-3))
            rows.append(("wavelength at 3 mm", f"{wave:.4g} m" if wave == wave else "none"))
        largest = max(float(np.degrees(wheel.contact_angle).max()) for wheel in (self.left, self.right))
        rows.append(("largest contact angle", f"{largest:.4g}\N{DEGREE SIGN}"))
        return rows

    def columns(self) -> dict[str, Array]:
        """Everything over the shift by name, those of the wheels with ``left_`` or ``right_`` before them."""
        own = {
            "shift": self.shift,
            "height": self.height,
            "roll": self.roll,
            "radius_difference": self.radius_difference,
        }
        for side, wheel in (("left", self.left), ("right", self.right)):
            own |= {f"{side}_{name}": getattr(wheel, name) for name in TouchingWheel._columns}
        return own

    def to_pandas(self) -> Any:
        """The columns as a :class:`pandas.DataFrame` (extra ``sweep``); units are its ``attrs["units"]``."""
        try:
            import pandas
        except ImportError as error:
            raise ImportError("pandas is missing: pip install 'mtb-rs[sweep]'") from error
        columns = self.columns()
        frame = pandas.DataFrame(columns)
        frame.attrs = {"units": {name: _unit(name) for name in columns}}
        return frame

    def to_xarray(self) -> Any:
        """The columns over the shift as an :class:`xarray.Dataset` (extra ``sweep``), with units."""
        try:
            import xarray
        except ImportError as error:
            raise ImportError("xarray is missing: pip install 'mtb-rs[sweep]'") from error
        columns = {
            name: xarray.Variable("shift", values, {"units": _unit(name)})
            for name, values in self.columns().items()
        }
        return xarray.Dataset(columns, {"shift": columns.pop("shift")})

    def exports(self) -> tuple[dict[str, bytes], list[str]]:
        """A picture, and the columns as CSV."""
        columns = self.columns()
        rows = [
            ",".join(f"{value!r}" for value in row) for row in np.array(list(columns.values())).T.tolist()
        ]
        lines = [",".join(f"{name} [{_unit(name)}]" for name in columns), *rows]
        with pictures().own_figures():
            return {"png": png(self.plot()), "csv": "".join(f"{line}\n" for line in lines).encode()}, []

    def check(self) -> None:
        """Checks that what was read from files fits together; ValueError if it does not."""
        shapes = {name: values.shape for name, values in self.columns().items()}
        if self.shift.ndim != 1 or any(shape != self.shift.shape for shape in shapes.values()):
            raise ValueError(f"its columns have the shapes {list(shapes.values())}")

    def _repr_png_(self) -> bytes | None:
        """Its picture, for notebooks."""
        with pictures().own_figures():
            return png(self.plot())


def _unit(name: str) -> str:
    return _UNITS[name.removeprefix("left_").removeprefix("right_")]


def _together(profiles: Sequence[Profile]) -> str:
    """The name of both profiles, left and right, or the names of two."""
    return " and ".join(dict.fromkeys(profile.name for profile in profiles))


@taking_quantities
def wheelset_geometry(
    wheel: str | Profile | Sequence[str | Profile] = "S1002",
    rail: str | Profile | Sequence[str | Profile] = "60E1",
    *,
    wheel_radius: float | Sequence[float] = 0.46,
    gauge: float = 1.435,
    rail_inclination: float = 1 / 40,
    shifts: ArrayLike | None = None,
    axle: Axle = "level",
    gauge_depth: float = 14e-3,
    flange_back: float = 1.360,
    tape_circle: float = 70e-3,
) -> WheelsetGeometry:
    """Contact points of a rigid wheelset on rigid rails over its lateral shift.

    The wheelset stands on both rails without yaw, and each wheel touches its rail where
    :class:`mtb_rs.PreparedWheels` would begin to press them together in this pose. Contact angle, difference
    of rolling radii, equivalent conicity and wavelength follow.

    Parameters
    ----------
    wheel, rail : str or Profile, or two of them
        Names of standard profiles or profiles in their own frames, of both sides or of the left and the right
        one. Those of the right side are given like left ones, as seen in a mirror: gauge side and flange at y
        < 0.
    wheel_radius : float or (float, float) [m]
        Radius at z = 0 of the wheel profile, which is that of the tape circle of a new wheel; of both wheels
        or of the left and the right one.
    gauge, gauge_depth : float [m]
        Track gauge, and the depth below the top of the rail down to which it is measured.
    rail_inclination : float [rad]
        Rotation of the rails towards the middle of the track; 0 for profiles that have it in.
    shifts : (n,) [m] or None
        Lateral shifts of the wheelset to the left, rising; None: from -8 to 8 mm by 0.1 mm.
    axle : "level" or "free"
        A level axle does not roll: each wheel touches its rail as if it were alone, as the scenes of wheels
        on rails and the reference results of EN 15302 have it. A free one rolls until both wheels touch; of
        cones of 1/20 this makes the conicity larger by 5 %.
    flange_back, tape_circle : float [m]
        Distance between the backs of the flanges, and of the tape circle from them.

    Returns
    -------
    WheelsetGeometry

    Raises
    ------
    ValueError
        If an argument is wrong, or the wheelset cannot stand on the rails at one of the shifts, such as one
        at which it touches the end of a profile; the message names the shift.
    """
    wheels, rails = _two("wheel", wheel), _two("rail", rail)
    radii = (wheel_radius,) * 2 if np.ndim(wheel_radius) == 0 else tuple(wheel_radius)  # type: ignore[arg-type]
    if len(radii) != 2:
        raise ValueError(
            f"wheel_radius is {wheel_radius!r}: a number, or one each of left and right, is needed"
        )
    radii = tuple(positive("wheel_radius", radius, "m") for radius in radii)
    # by 0.1 mm, written so that none of them is off zero by rounding
    places = reals("shifts", np.arange(-80, 81) * 1e-4 if shifts is None else shifts, "m")
    if places.ndim != 1 or not places.size or not (np.diff(places) > 0.0).all():
        raise ValueError("shifts: rising lateral shifts [m] are needed, at least one")
    choice("axle", axle, Axle)
    numbers = {
        "gauge": positive("gauge", gauge, "m"),
        "gauge_depth": positive("gauge_depth", gauge_depth, "m"),
        "rail_inclination": number("rail_inclination", rail_inclination, "rad"),
        "flange_back": positive("flange_back", flange_back, "m"),
        "tape_circle": number("tape_circle", tape_circle, "m"),
    }
    pairs = [(w._core, r._core, radius) for w, r, radius in zip(wheels, rails, radii, strict=True)]
    doubts = [words for w, r in zip(wheels, rails, strict=True) for words in of_pair(w, r)]
    try:
        found = _mtb_rs.standing_wheelsets(pairs, level=axle == "level", shifts=places, **numbers)
    except ValueError as error:
        raise ValueError("; ".join(dict.fromkeys([str(error), *doubts]))) from None
    lengths = {"wheel_radius": min(radii), **numbers, "lateral": float(places[np.abs(places).argmax()])}
    ask([*unusual(lengths, USUAL_LENGTHS), *doubts])
    touching = []
    for side, (own_wheel, own_rail, radius) in enumerate(zip(wheels, rails, radii, strict=True)):
        y, z, rail_position, wheel_position, angle, rolling = found[2 + 6 * side : 8 + 6 * side]
        touching.append(
            TouchingWheel(
                y=y if side == 0 else -y,
                z=z,
                rail_position=rail_position,
                wheel_position=wheel_position,
                contact_angle=angle,
                rolling_radius=rolling,
                rail=_outline(own_rail),
                wheel=_outline(own_wheel),
                wheel_radius=radius,
            )
        )
    return WheelsetGeometry(
        shift=places,
        height=found[0],
        roll=found[1],
        left=touching[0],
        right=touching[1],
        base=numbers["flange_back"] + 2.0 * numbers["tape_circle"],
        rail_inclination=numbers["rail_inclination"],
        names=(_together(wheels), _together(rails)),
    )


def _two(name: str, given: Any) -> tuple[Profile, Profile]:
    """The profile of both sides, or that of each."""
    if isinstance(given, (str, Profile)):
        return (as_profile(given),) * 2
    try:
        left, right = given
    except (TypeError, ValueError):
        raise ValueError(
            f"{name} is {given!r}: a profile, or one each of left and right, is needed"
        ) from None
    return as_profile(left), as_profile(right)


def _outline(profile: Profile) -> Array:
    start, end = profile.range
    y = np.union1d(np.linspace(start, end, DRAWN), profile.breaks if profile.breaks.size < DRAWN else [])
    return np.array([y, profile.height(y)])
