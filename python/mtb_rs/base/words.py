# SPDX-License-Identifier: MIT OR Apache-2.0
"""The words that arguments take, each list once: for type checkers and for checks of input."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING, Literal, TypedDict

if TYPE_CHECKING:
    from matplotlib.axes import Axes  # noqa: TID251 (only for type checkers)
    from matplotlib.colors import Colormap  # noqa: TID251 (only for type checkers)

#: What of a scene is modelled.
Model = Literal["auto", "half-space", "elastic-upper", "elastic-lower", "elastic-both"]
#: The algorithm of :meth:`mtb_rs.Scene.solve`.
Method = Literal["direct", "incremental", "staggered"]
#: What a tolerance is about.
Quantity = Literal["pressure", "force", "displacement"]
#: What is drawn in the plane, and what in space besides.
Field = Literal[
    "pressure",
    "magnetic_pressure",
    "traction",
    "longitudinal_traction",
    "lateral_traction",
    "slip",
    "longitudinal_slip",
    "lateral_slip",
    "plastic_slip",
    "longitudinal_plastic_slip",
    "lateral_plastic_slip",
    "accumulated_plastic_slip",
    "friction_coefficient",
    "dissipation",
    "plastic_dissipation",
    "gap",
    "initial_gap",
    "plastic_indentation",
    "status",
    "temperature",
    "heat_flux",
    "wear",
    "vertical_displacement",
    "longitudinal_displacement",
    "lateral_displacement",
]
Stress = Literal["von_mises"]
#: Kinds of picture in the plane, and in space.
Flat = Literal["map", "line"]
Space = Literal["3d"]
Body = Literal["upper", "lower"]
Limits = tuple[float, float]


class FlatOptions(TypedDict, total=False):
    """Of a picture in the plane; see :func:`mtb_rs.pictures.plot`."""

    x: float | Iterable[float] | None
    y: float | Iterable[float] | None
    body: Body
    limits: Limits | None
    ax: Axes | None
    title: str | None
    cmap: str | Colormap | None
    figsize: tuple[float, float] | None


class StressOptions(TypedDict, total=False):
    """Of a picture of stresses in space; see :func:`mtb_rs.pictures.view_von_mises`."""

    limits: Limits | None
    scale: float | None
    off_screen: bool | None
    size: tuple[int, int]


class SpaceOptions(StressOptions, total=False):
    """Of a picture in space; see :func:`mtb_rs.pictures.view`."""

    body: Body


#: Which bodies the magnetic pressure acts on.
Attraction = Literal["upper", "both"]
#: Ways of holding the ready elastic bodies.
Held = Literal["driven-top", "clamped-top", "points", "fixed-points"]
#: Wheels of a wheelset.
Wheels = Literal["left", "right", "both"]
#: Wheels, or rails, of one side.
Side = Literal["left", "right"]
#: Pressure at the start of sliding.
Pressing = Literal["held", "follows"]
#: The border of the grid in the normal contact of half-spaces, and how that is solved.
Edge = Literal["auto", "error", "sharp", "grow"]
Convolution = Literal["auto", "dense", "fft", "kpec", "analyn"]
#: How normal and tangential contact are coupled.
Coupling = Literal["one-way", "full"]
#: Traction bound of the simplified theory.
Bound = Literal["parabolic", "elliptic"]
#: How many flexibilities the foundation of the simplified theory has.
Flexible = Literal[3, 1, "blended"]
#: Direction of the traction at the edge of adhesion.
StickDirection = Literal["strip theory", "CONTACT"]
#: Lengths in files.
Unit = Literal["m", "mm", "um", "in"]
#: Ways between the points of a profile, and ways that z of its file may point.
Interpolation = Literal["smooth", "linear"]
ZAxis = Literal["up", "down", "guess"]
#: Way of a passage through a contact.
Along = Literal["x", "y"]
#: How the axle of a rigid wheelset stands on the rails.
Axle = Literal["level", "free"]
#: Ways to an equivalent conicity, and what is drawn of a wheelset over rails.
Linearisation = Literal["integration", "harmonic"]
Guidance = Literal[
    "contact_points",
    "radius_difference",
    "contact_angle",
    "rail_position",
    "wheel_position",
    "equivalent_conicity",
    "wavelength",
]
#: What of a profile is drawn over y.
Shape = Literal["height", "angle", "curvature"]
#: What there is to ask of a stress: its components, and what follows from them.
StressPart = Literal[
    "xx",
    "yy",
    "zz",
    "yz",
    "xz",
    "xy",
    "von_mises",
    "tresca",
    "largest_shear",
    "largest_principal",
    "hydrostatic",
]
