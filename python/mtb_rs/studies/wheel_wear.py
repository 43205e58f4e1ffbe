# SPDX-License-Identifier: MIT OR Apache-2.0
"""Wear of wheel and rail profiles by wheelsets that run over them at many lateral positions."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from math import ceil
from typing import Any, ClassVar, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..base.check import positive, reals, whole
from ..base.errors import ConvergenceError
from ..base.owning import solved
from ..base.plain import plain
from ..base.progress import shares_shown
from ..base.stored import stored
from ..base.told import Row, length
from ..base.units import taking_quantities
from ..friction.wear_laws import Rubbing, WearLaw, check_worn
from ..geometry.geometries import WheelOnRail
from ..geometry.profiles import Profile, as_profile
from ..results.doors import pictures, png
from ..results.study import Study
from ..results.wheel_result import WheelPatch
from ..scenes.scene import WheelScene

Array = NDArray[np.float64]

#: Distance [m] along a profile between the points that wear.
STATIONS = 2e-4
#: Standard deviations after which the weights of smoothing are left out.
TAILS = 5.0
#: Share of the distance whose positions may have no answer.
MISSED = 0.1
#: Part of an update by which one may be longer than what `depth` allows: rounding.
ROUNDING = 1e-12
#: Updates of the profiles at most.
MOST = 10_000


@stored
@solved
@dataclass(frozen=True, repr=False)
@plain
class WheelWear(Study):
    """Worn profiles of wheel and rail, of :func:`mtb_rs.wear_of_wheels`; k updates, n and m points.

    Attributes
    ----------
    distances : (k + 1,) [m]
        Rolled so far, from 0 on.
    wheel_points : (k + 1, 2, n) [m]
        y and z of the wheel's profile in its own frame.
    rail_points : (k + 1, 2, m) [m]
        The same of the rail.
    wheel_depths : (k + 1, n) [m]
        Worn off the wheel so far, normal to the profile.
    rail_depths : (k + 1, m) [m]
        The same of the rail.
    wheel_volumes : (k + 1,) [m3]
        Worn off each wheel.
    rail_areas : (k + 1,) [m2]
        Worn off the section of each rail.
    smoothed : (2, k) [m]
        Largest change that smoothing made to the depth of an update, of wheel and rail.
    peak_pressures : (k, shifts) [Pa]
        Largest pressure at each lateral position, before each update; 0 where there was no answer.
    left_out : (k,) [-]
        Share of the distance at whose positions the contacts were not found; the others stand for it.
    shifts, shares : (shifts,) [m], [-]
        Lateral positions, and the share of the distance that is run at each.
    right : WheelWear or None
        Of the right side, where both wear apart; all else is then of the left one. None: of both alike.
    """

    usual_name: ClassVar[str] = "wheel_wear"
    called: ClassVar[str] = "wear of wheels"
    endings: ClassVar[tuple[str, ...]] = ("png", "csv")

    distances: Array
    wheel_points: Array
    rail_points: Array
    wheel_depths: Array
    rail_depths: Array
    wheel_volumes: Array
    rail_areas: Array
    smoothed: Array
    peak_pressures: Array
    left_out: Array
    shifts: Array
    shares: Array
    right: WheelWear | None = None

    def wheel(self, update: int = -1) -> Profile:
        """The wheel's profile after an update; by default after the last one, and 0 is the new one."""
        return _profile(self.wheel_points[update], "worn wheel")

    def rail(self, update: int = -1) -> Profile:
        """The same of the rail."""
        return _profile(self.rail_points[update], "worn rail")

    def sides(self) -> dict[str, WheelWear]:
        """Itself as "left" and what is of the "right" side; as "" where both wear alike."""
        return {"": self} if self.right is None else {"left": self, "right": self.right}

    def told(self) -> list[Row]:
        """Its figures in words: what a notebook shows beside the picture."""
        rows: list[Row] = [
            ("distance", f"{self.distances[-1] / 1e3:.6g} km in {self.distances.size - 1} updates")
        ]
        for each, found in self.sides().items():
            of = f"the {each}".rstrip()
            rows += [
                (f"largest depth of {of} wheel", length(float(found.wheel_depths[-1].max()))),
                (
                    f"worn off {of if each else 'each'} wheel",
                    f"{found.wheel_volumes[-1] * 1e6:.4g} cm3",
                ),
            ]
            if found.rail_depths.any():
                rows += [
                    (f"largest depth of {of} rail", length(float(found.rail_depths[-1].max()))),
                    (f"worn off the section of {of} rail", f"{found.rail_areas[-1] * 1e6:.4g} mm2"),
                ]
        rows.append(("largest change by smoothing", length(float(self.smoothed.max(initial=0.0)))))
        if self.left_out.any():
            rows.append(
                ("left out of an update", f"up to {100.0 * float(self.left_out.max()):.2g} % of the way")
            )
        return rows

    def plot(self, ax: Any = None) -> Any:
        """The profile of the wheel before and after, and the depth over it as it grows; returns the figure.

        Where the sides wear apart it is the left wheel, and ``right.plot()`` shows the right one.

        Parameters
        ----------
        ax : pair of matplotlib.axes.Axes, optional
            For the profiles and for the depths.
        """
        return pictures().draw_wheel_wear(self, ax)

    def columns(self) -> dict[str, Array]:
        """Places and depths of wheel and rail over the distance, one row for each point and update.

        Where the sides wear apart these are of the left one, and ``right.columns()`` has the right one.
        """
        found: dict[str, list[Array]] = {name: [] for name in ("body", "distance", "y", "z", "depth")}
        for k, distance in enumerate(self.distances):
            for body, points, depths in (
                (1.0, self.wheel_points, self.wheel_depths),
                (0.0, self.rail_points, self.rail_depths),
            ):
                n = points.shape[2]
                rows = (np.full(n, body), np.full(n, distance), *points[k], depths[k])
                for name, row in zip(found, rows, strict=True):
                    found[name].append(row)
        return {name: np.concatenate(rows) for name, rows in found.items()}

    def exports(self) -> tuple[dict[str, bytes], list[str]]:
        """A picture, and the columns as CSV."""
        head, told = "body,distance [m],y [m],z [m],depth [m]", []
        for each, found in self.sides().items():
            columns = found.columns()
            bodies = np.where(columns.pop("body") > 0.0, "wheel", "rail").tolist()
            rows = np.array(list(columns.values())).T.tolist()
            told += [
                f"{each} {body},".lstrip() + ",".join(map(repr, row))
                for body, row in zip(bodies, rows, strict=True)
            ]
        with pictures().own_figures():
            return {"png": png(self.plot()), "csv": "\n".join([head, *told, ""]).encode()}, []

    def check(self) -> None:
        """Checks that what was read from files fits together; ValueError if it does not."""
        k, n, m = self.distances.size, self.wheel_points.shape[-1], self.rail_points.shape[-1]
        shapes = {
            "wheel_points": (k, 2, n),
            "rail_points": (k, 2, m),
            "wheel_depths": (k, n),
            "rail_depths": (k, m),
            "wheel_volumes": (k,),
            "rail_areas": (k,),
            "smoothed": (2, k - 1),
            "peak_pressures": (k - 1, self.shifts.size),
            "left_out": (k - 1,),
            "shares": (self.shifts.size,),
        }
        for name, shape in shapes.items():
            if getattr(self, name).shape != shape:
                raise ValueError(f"{name} has the shape {getattr(self, name).shape}: {shape} is needed")
        if self.right is not None:
            self.right.check()

    def _repr_png_(self) -> bytes | None:
        with pictures().own_figures():
            return png(self.plot())

    def __repr__(self) -> str:
        deepest = [f"{1e3 * found.wheel_depths[-1].max():.3g} mm" for found in self.sides().values()]
        return (
            f"WheelWear({self.distances[-1] / 1e3:.4g} km, wheel worn by up to "
            f"{', the right one by up to '.join(deepest)} in {self.distances.size - 1} updates)"
        )


@taking_quantities
def wear_of_wheels(
    scene: WheelScene,
    distance: float,
    law: WearLaw | float | Callable[[Rubbing], Any],
    *,
    shifts: ArrayLike,
    shares: ArrayLike | None = None,
    yaw: ArrayLike = 0.0,
    velocity: float = 20.0,
    lower_law: WearLaw | float | Callable[[Rubbing], Any] | None = None,
    passages: float = 0.0,
    depth: float = 2e-5,
    wavelength: float = 4e-3,
    apart: bool = False,
    progress: Callable[[float], Any] | Literal[True] | None = None,
    **wheels: Any,
) -> WheelWear:
    """Wears the profiles of a wheelset, and of the rails below it, over many positions across the track.

    The wheelset rolls straight on at each of the lateral positions; height and roll follow from balance. The
    depths that its contacts wear off in a metre, weighted with the shares and spread over the profiles such
    that no material is lost, are the rates of wear. They hold until one of the profiles has lost `depth`
    anywhere; then the contacts are found anew on the worn profiles. So the error is of first order in
    `depth`. The shifts must lie so close that the contacts of neighbours overlap: about four for each
    millimetre. Left and right wear alike, as where a vehicle turns around and curves go both ways: the
    profiles of both wheels, and of both rails, have the mean of both. `apart` wears each side by what its own
    contacts do.

    Worn profiles may fit each other so well in the flange root that no contact plane holds all of the
    contact, or no height carries the load. Such a position is left out, and the others stand for it, as long
    as no more than a tenth of the way is run there.

    Parameters
    ----------
    scene : WheelScene
        Of :func:`mtb_rs.scenes.wheel_on_rail`, with the new profiles. Its `lateral` is added to the shifts.
    distance : float [m]
        That the wheelset rolls.
    law : WearLaw, float [1/Pa] or function
        Of the wheel, as for :func:`mtb_rs.wear`.
    shifts : (k,) [m]
        Lateral positions of the wheelset, > 0 to the left.
    shares : (k,) or None [-]
        Share of the distance run at each; only their ratios count. None: equal ones.
    yaw : float or (k,) [rad]
        Angle of the wheelset at each position.
    velocity : float [m/s]
    lower_law : WearLaw, float [1/Pa], function or None
        Of the rail. None: the rail does not wear.
    passages : float
        Number of wheelsets that pass over the same place of the rail meanwhile; needed with a `lower_law`.
    depth : float [m]
        Largest depth worn off between two updates of the profiles. Where all of a contact slides, waves of
        the profile of a length L grow from update to update with a depth of more than 2 p L / (pi E*): 20 um
        for the 4 mm of `wavelength`, a mean pressure of 1 GPa and steel.
    wavelength : float [m]
        The depths of an update are averaged along the profile by a bell (Gaussian) that leaves half of the
        height of waves of this length; it keeps the volume. The sums over few shifts are jagged otherwise.
    apart : bool
        Whether the left and the right side wear apart. They do where a wheel, a rail, a radius or friction is
        given for the right one.
    progress : callable or True
        Called with the share of the distance. True shows a bar (extra ``notebook``).
    **wheels
        As :meth:`WheelScene.prepare`: `friction`, `layer`, `standstill_speed`, `conformal`, `order`, and
        `right_wheel`, `right_rail`, `right_wheel_radius`, `right_friction`.

    Returns
    -------
    WheelWear

    Raises
    ------
    ValueError
        For bad input, and for a law that wears a profile away.
    ConvergenceError
        If more than a tenth of the way is run where the contacts are not found, with the first reason.
    """
    if not isinstance(scene, WheelScene):
        raise ValueError(f"scene is {type(scene).__name__}: one of mtb_rs.scenes.wheel_on_rail is needed")
    given = dict(scene.geometry.arguments)
    if not isinstance(apart, (bool, np.bool_)):
        raise ValueError(f"apart is {apart!r}: True or False is needed")
    is_apart = apart or any(name.startswith("right_") and wheels[name] is not None for name in wheels)
    if law is None:
        raise ValueError("law is None: a law of wear, a coefficient [1/Pa] or a function is needed")
    total, most = positive("distance", distance, "m"), positive("depth", depth, "m")
    positive("velocity", velocity, "m/s")
    bell = positive("wavelength", wavelength, "m") * np.sqrt(2.0 * np.log(2.0)) / (2.0 * np.pi)
    places = np.atleast_1d(reals("shifts", shifts, "m"))
    if places.ndim != 1 or not places.size:
        raise ValueError(f"shifts has shape {places.shape}: (k,), at least one lateral position, is needed")
    parts = np.ones(places.size) if shares is None else np.atleast_1d(reals("shares", shares))
    if parts.shape != places.shape or parts.min() < 0.0 or not parts.sum() > 0.0:
        raise ValueError(f"shares is {shares!r}: {places.size} numbers of at least 0, not all 0, are needed")
    parts = parts / parts.sum()
    angles = reals("yaw", yaw, "rad")
    if angles.shape not in ((), places.shape):
        raise ValueError(f"yaw has shape {angles.shape}: a number, or {places.size} of them, is needed")
    angles = np.broadcast_to(angles, places.shape)
    if (lower_law is None) != (passages == 0.0):
        raise ValueError("lower_law and passages go together: how a rail wears, and how many wheelsets pass")
    rate = 0.0 if lower_law is None else positive("passages", passages) / total
    sides = {"left": _Side(given["wheel"], given["rail"], float(given["wheel_radius"]))}
    if is_apart:
        # None is what the left side has
        own = {name.removeprefix("right_"): of for name, of in wheels.items() if of is not None}
        mine = {name: own.get(name, given[name]) for name in ("wheel", "rail", "wheel_radius")}
        radius = positive("right_wheel_radius", mine["wheel_radius"], "m")
        sides["right"] = _Side(mine["wheel"], mine["rail"], radius)
    laws = ((law, True, 1.0), (lower_law, False, rate))
    done = [0.0]
    peaks: list[list[float]] = []
    left_out: list[float] = []
    worn = scene
    with shares_shown(progress, "wear") as told:
        while done[-1] < total:
            contact = worn.prepare(side="both", **wheels)
            for side in sides.values():
                side.begin()
            peaks.append([])
            missed: list[tuple[float, str]] = []
            for place, angle, part in zip(places, angles, parts, strict=True):
                pose = [0.0, place, np.nan, np.nan, 0.0, angle]
                try:
                    step = contact.step(pose=pose, velocity=velocity)
                except (ConvergenceError, ValueError) as error:
                    peaks[-1].append(0.0)
                    missed.append((part, f"{_where(done[-1], place)}: {error}"))
                    continue
                peaks[-1].append(max((float(p.pressure.max()) for p in step.patches), default=0.0))
                for patch in step.patches:
                    # alike: the mean of the left and the right one
                    side, each = (sides[patch.side], 1.0) if is_apart else (sides["left"], 0.5)
                    for rubs, is_wheel, count in laws:
                        if rubs is not None:
                            gone = patch.wear_depth(rubs, side.radius if is_wheel else None)
                            side.add(is_wheel, each * part * count, patch, gone)
            lost = float(sum(part for part, _ in missed))
            if lost > MISSED:
                raise ConvergenceError(missed[0][1], None)
            left_out.append(lost)
            fastest = max(side.averaged(lost, bell) for side in sides.values())
            left = total - done[-1]
            way = left if fastest * left <= most else most / fastest
            # equal updates rather than a last one that is short
            way = left / ceil(left / way * (1.0 - ROUNDING)) if way < left else left
            if len(peaks) + left / way > MOST + 1:
                raise ValueError(
                    f"depth is {most:g} m: more than {MOST} updates are needed, {way:.3g} m each; give a "
                    "larger depth or a law that wears less"
                )
            for side in sides.values():
                side.wear(way, (law, lower_law), done[-1] + way)
            done.append(total if way == left else done[-1] + way)
            of_rail = [None if lower_law is None else side.rail.profile() for side in sides.values()]
            worn = _with_profiles(scene, sides["left"].wheel.profile(), of_rail[0])
            if is_apart:
                wheels["right_wheel"] = sides["right"].wheel.profile()
                wheels["right_rail"] = wheels.get("right_rail") if of_rail[1] is None else of_rail[1]
            told(done[-1] / total)
    common: dict[str, Any] = {
        "distances": np.array(done),
        "peak_pressures": np.array(peaks),
        "left_out": np.array(left_out),
        "shifts": places,
        "shares": parts,
    }
    right = WheelWear(**common, **sides["right"].told()) if "right" in sides else None
    return WheelWear(**common, **sides["left"].told(), right=right)


def _profile(points: Array, name: str) -> Profile:
    """Through points (2, n)."""
    return Profile.from_points(points[0], points[1], name=name)


def _where(distance: float, shift: float) -> str:
    return f"after {distance:.6g} m, at the shift {shift:g} m"


def _with_profiles(scene: WheelScene, wheel: Profile, rail: Profile | None) -> WheelScene:
    """The scene with other profiles and the same vertical force; None: the rail's own."""
    old = scene.geometry
    changed = {"wheel": wheel} if rail is None else {"wheel": wheel, "rail": rail}
    new = WheelOnRail.placed(**{**dict(old.arguments), **changed})
    assert scene.force is not None
    vertical = scene.force * float(np.cos(old.placement.contact_angle))
    return replace(scene, geometry=new, force=vertical / float(np.cos(new.placement.contact_angle)))


class _Side:
    """Wheel and rail of a side, which wear."""

    def __init__(self, wheel: Any, rail: Any, radius: float) -> None:
        self.wheel, self.rail = _Worn(as_profile(wheel), 1.0), _Worn(as_profile(rail), -1.0)
        self.radius = radius
        self.smoothed: list[tuple[float, float]] = []
        self._rates: list[Array] = []
        self._averaged: list[Array] = []

    def begin(self) -> None:
        """Begins to add what the profiles as they are lose in a metre."""
        self._rates = [np.zeros(body.points.shape[1]) for body in (self.wheel, self.rail)]

    def add(self, is_wheel: bool, weight: float, patch: WheelPatch, depth: Array) -> None:
        """Adds the depths (ny,) of a patch with a weight."""
        body, found = (self.wheel, self._rates[0]) if is_wheel else (self.rail, self._rates[1])
        found += weight * body.spread(patch, depth)

    def averaged(self, lost: float, bell: float) -> float:
        """Averages the depths of a metre, where a share of it is `lost`; the largest of them."""
        self._rates = [found / (1.0 - lost) for found in self._rates]
        bodies = zip((self.wheel, self.rail), self._rates, strict=True)
        self._averaged = [body.averaged(found, bell) for body, found in bodies]
        return max(float(found.max()) for found in self._averaged)

    def wear(self, way: float, laws: tuple[Any, Any], distance: float) -> None:
        """Takes off what is lost on a way [m]."""
        pairs = zip(self._averaged, self._rates, strict=True)
        changes = [way * float(np.abs(averaged - plain).max()) for averaged, plain in pairs]
        self.smoothed.append((changes[0], changes[1]))
        for body, found, law in zip((self.wheel, self.rail), self._averaged, laws, strict=True):
            if law is not None:
                body.wear(way * found, law, distance)
            else:
                body.stay()

    def told(self) -> dict[str, Any]:
        """What :class:`WheelWear` has of a side."""
        return {
            "wheel_points": np.array(self.wheel.kept),
            "rail_points": np.array(self.rail.kept),
            "wheel_depths": np.array(self.wheel.depths),
            "rail_depths": np.array(self.rail.depths),
            "wheel_volumes": 2.0 * np.pi * self.radius * np.array(self.wheel.areas),
            "rail_areas": np.array(self.rail.areas),
            "smoothed": np.array(self.smoothed).T.copy(),
        }


class _Worn:
    """A profile that wears: its points, and what they have lost."""

    def __init__(self, profile: Profile, inwards: float) -> None:
        ends = profile.arc_length(np.array(profile.range))
        count = whole("points", max(3, round(float(np.ptp(ends)) / STATIONS)))
        along = np.linspace(float(ends[0]), float(ends[1]), count)
        y = np.clip(profile.position(along), *profile.range)
        self.points = np.stack([y, profile.height(y)])
        #: Where material is, seen from the contact: above the wheel's profile and below the rail's.
        self.inwards = inwards
        self.depth = np.zeros(count)
        self.kept, self.depths, self.areas = [self.points], [self.depth], [0.0]
        self._current = self.profile()

    def profile(self) -> Profile:
        """Through the points."""
        return _profile(self.points, "worn")

    def widths(self) -> tuple[Array, Array]:
        """Borders (n + 1,) and widths (n,) [m] along the profile of what the points stand for."""
        s = self._current.arc_length(self.points[0])
        borders = np.concatenate([s[:1], 0.5 * (s[1:] + s[:-1]), s[-1:]])
        return borders, np.diff(borders)

    def spread(self, patch: WheelPatch, depth: Array) -> Array:
        """Depths (n,) at the points, of the same area as those (ny,) of the lines of a patch."""
        at = patch.wheel_position if self.inwards > 0.0 else patch.rail_position
        step = float(patch.y[1] - patch.y[0])
        # lines run to the left of the track, and profiles to the outside
        outwards = 1.0 if patch.side == "left" else -1.0
        lines = outwards * patch.y
        order = np.argsort(lines)
        middle = float(self._current.arc_length(at))
        ends = middle + np.append(lines[order] - 0.5 * step, lines.max() + 0.5 * step)
        gone = np.concatenate([[0.0], np.cumsum(depth[order]) * step])
        borders, widths = self.widths()
        depths: Array = np.diff(np.interp(borders, ends, gone)) / widths
        return depths

    def averaged(self, depth: Array, bell: float) -> Array:
        """Depths averaged along the profile with the weights of a bell; the same area."""
        borders, widths = self.widths()
        s = 0.5 * (borders[1:] + borders[:-1])
        found = np.zeros_like(depth)
        for k in np.flatnonzero(depth):
            near = slice(*np.searchsorted(s, [s[k] - TAILS * bell, s[k] + TAILS * bell]))
            weights = np.exp(-0.5 * ((s[near] - s[k]) / bell) ** 2)
            found[near] += depth[k] * widths[k] * weights / (weights @ widths[near])
        return found

    def wear(self, depth: Array, law: Any, distance: float) -> None:
        """Takes depths (n,) off, normal to the profile."""
        _, widths = self.widths()
        normal = self._current.normal(self.points[0])
        self.depth = self.depth + depth
        check_worn(law, self.depth, float(np.ptp(self.kept[0][0])), "the width of its profile", distance)
        self.points = self.points + self.inwards * depth * normal
        self.areas.append(self.areas[-1] + float(depth @ widths))
        self._keep()

    def stay(self) -> None:
        """Goes on as it is."""
        self.areas.append(self.areas[-1])
        self._keep()

    def _keep(self) -> None:
        self.kept.append(self.points)
        self.depths.append(self.depth)
        self._current = self.profile()
