# SPDX-License-Identifier: MIT OR Apache-2.0
"""A wheel on a rail: where their profiles touch, and the gap around it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .. import _mtb_rs
from ..base.check import number, positive
from ..base.owning import owning
from ..base.plain import plain
from ..base.questions import ask, unusual
from ..base.units import taking_quantities
from .contact_points import spacing_pair
from .profiles import Profile, as_profile, of_pair
from .slices import nominal_of

Array = NDArray[np.float64]


#: Lengths [m] that wheels and tracks have, toys and mines included.
USUAL_LENGTHS = {
    "wheel_radius": (0.02, 1.5),
    "roller_radius": (0.02, 3.0),
    "gauge": (0.2, 3.0),
    "gauge_depth": (2e-3, 0.05),
    "flange_back": (0.2, 3.0),
    "tape_circle": (0.01, 0.2),
    "lateral": (-0.04, 0.03),
}
#: Vertical forces [N] that no wheel carries: those of the heaviest trains have a quarter of the upper one,
#: small roller rigs ten times the lower one.
WEAK_FORCE, STRONG_FORCE = 100.0, 1e6


def of_wheel(given: Mapping[str, Any], placed: WheelRailGap) -> list[str]:
    """Questions about lengths of wheels and rails: arguments of :func:`mtb_rs.wheel_on_rail_gap`, the
    profiles as such, and where that has placed the wheel."""
    lengths = {name: number(name, given[name], "m") for name in USUAL_LENGTHS if given[name] is not None}
    questions = unusual(lengths, USUAL_LENGTHS)
    # unusual lengths explain it; a wheel on its flange stands higher than where the gauge is measured
    if not questions and placed.undeformed_height > given["gauge_depth"]:
        questions.append(
            f"the flange has climbed the rail: the wheel stands {1e3 * placed.undeformed_height:.3g} mm "
            f"higher than on its tread, with lateral = {given['lateral']:g} m; flanges touch the rail after "
            "some millimetres, and lengths are in metres"
        )
    if given["force"] < WEAK_FORCE:
        questions.append(
            f"force is {given['force']:g} N: it is the vertical force on one wheel, and forces are in "
            "newtons (36 kN is 36e3)"
        )
    if given["force"] > STRONG_FORCE:
        questions.append(
            f"force is {given['force']:g} N: no wheel carries more than {STRONG_FORCE:g} N, and forces are "
            "in newtons"
        )
    questions += of_pair(given["wheel"], given["rail"])
    back, gauge = given["flange_back"], given["gauge"]
    if back >= gauge:
        questions.append(
            f"flange_back is {back:g} m and gauge {gauge:g} m: the backs of the flanges usually stand closer "
            "together than the rails"
        )
    return questions


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


@taking_quantities
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
    roller_radius: float | None = None,
) -> WheelRailGap:
    """Where a wheel touches a rail, and the gap over the contact plane there; no yaw, no roll.

    The contact plane goes through the centroid of the estimated contact area with the rail's mean
    slope there. The wheel is a surface of revolution and the rail a prism, or with a `roller_radius` a
    surface of revolution too, all exact.

    Parameters
    ----------
    wheel, rail : str or Profile
        Names of standard profiles, or profiles in their own frames: tape circle or crown at y = 0.
        Jagged profiles (``Profile.from_points(..., "linear")``) keep their kinks.
    wheel_radius : float [m]
        Radius at z = 0 of the wheel profile, which is that of the tape circle of a new wheel.
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
    roller_radius : float [m], optional
        Of a roller in place of the rail: its radius at the top of the rail, as this stands with its
        inclination. The axis of the roller lies across the track, below the axle.

    Lengths that no railway has are warned of, not refused.
    """
    given = locals()
    as_profile(wheel), as_profile(rail)
    placed = place_wheel(given)
    ask(of_wheel({**given, "wheel": as_profile(wheel), "rail": as_profile(rail)}, placed))
    return placed


def place_wheel(given: Mapping[str, Any]) -> WheelRailGap:
    """What :func:`wheel_on_rail_gap` returns for all its arguments, without questions or slices."""
    pair = spacing_pair(given["spacing"])
    approach = given["approach"]
    (wheel, _), (rail, slices) = (nominal_of(name, given[name]) for name in ("wheel", "rail"))
    roller = given.get("roller_radius")
    if roller is not None and slices is not None:
        raise ValueError(
            f"roller_radius is {roller!r} and rail is {given['rail']!r}: a roller has one profile all "
            "around, and slices along a track do not close around it"
        )
    numbers: dict[str, Any] = dict(
        wheel_radius=positive("wheel_radius", given["wheel_radius"], "m"),
        roller_radius=None if roller is None else positive("roller_radius", roller, "m"),
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
    try:
        found = _mtb_rs.wheel_on_rail_gap(wheel._core, rail._core, **numbers)
    except ValueError as error:
        # profiles that cannot be placed may be the wrong way round
        raise ValueError("; ".join([str(error), *of_pair(wheel, rail)])) from None
    x0, y0 = found.start
    across, up = found.origin
    ny, nx = found.gap.shape
    cos, sin = np.cos(found.contact_angle), np.sin(found.contact_angle)
    made: dict[str, Any] = {
        "spacing": pair,
        "x": np.asarray(x0 + pair[0] * np.arange(nx)),
        "y": np.asarray(y0 + pair[1] * np.arange(ny)),
        "position": np.array([0.0, across, up]),
        "rotation": np.array([[1.0, 0.0, 0.0], [0.0, cos, -sin], [0.0, sin, cos]]),
    }
    names = [f.name for f in fields(WheelRailGap) if f.name not in made]
    return WheelRailGap(**made, **{name: getattr(found, name) for name in names})
