# SPDX-License-Identifier: MIT OR Apache-2.0
"""Where a wheel with any pose touches a rail, and the gap over each contact plane."""

from __future__ import annotations

import inspect
import itertools
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .geometry import Profile, WheelRailGap, as_profile, wheel_on_rail_gap

Array = NDArray[np.float64]

#: Distance of the stations at which contact is looked for [m].
SAMPLING = 5e-5
#: Inclination against a contact plane beyond which that plane no longer serves [rad].
MOST_INCLINED = np.radians(20.0)
#: Slope at which a profile counts as vertical.
STEEP = 1e3
#: Gap [m] where there is no body.
NOTHING = 1e-2
#: Points of a patch from which on the spacing is taken for a mistake.
MOST_POINTS = 1_000_000
#: Steps of Newton's method towards a surface, the distance [m] at which they end, the longest of them [m],
#: the least cosine between surface and plane, and the distance at which a surface counts as found.
MOST_STEPS, CLOSE, LONGEST, STEEPEST, FOUND = 15, 1e-13, 2e-3, 0.05, 1e-9


@dataclass(frozen=True)
class FoundPatch:
    """The gap over a contact plane; a left wheel, in the track.

    Attributes
    ----------
    position : (3,) [m]
        Origin of the plane, on the rail.
    contact_angle : float [rad]
    first : (int, int)
        First grid line along x and across, in spacings from the origin.
    gap : (ny, nx) [m]
        Along the normal, negative where the undeformed bodies overlap.
    neglected : float [-]
        Share of the estimated contact area inclined too much for the plane.
    """

    position: Array
    contact_angle: float
    rail_position: float
    wheel_position: float
    first: tuple[int, int]
    gap: Array
    neglected: float

    @property
    def rotation(self) -> Array:
        """Columns: directions of x, across and normal."""
        cos, sin = np.cos(self.contact_angle), np.sin(self.contact_angle)
        return np.array([[1.0, 0.0, 0.0], [0.0, cos, -sin], [0.0, sin, cos]])


@dataclass(frozen=True)
class WheelOverRail:
    """A left wheel, of revolution about its axle, over a straight rail.

    Attributes
    ----------
    tape : float [m]
        Distance of the tape circle from the middle of the axle.
    first_height : float [m]
        Height of the tape circle over the top of the rail where the scene's wheel just touches.
    turn, shift : (2, 2), (2,) [m]
        Rotation and translation (y, z) of the rail from its own frame to the track.
    stations : (n,) [m]
        Lateral positions on the wheel, with radius and its slope there.
    head : (3, n)
        y [m], z [m] and slope angle [rad] of the rail's top side in the track, y rising.
    """

    wheel: Profile
    rail: Profile
    radius: float
    tape: float
    first_height: float
    turn: Array
    shift: Array
    stations: Array
    station_radius: Array
    station_slope: Array
    head: Array
    head_position: Array

    @classmethod
    def of(cls, placement: WheelRailGap, arguments: dict[str, Any]) -> WheelOverRail:
        """The wheel and the rail of :func:`mtb_rs.wheel_on_rail_gap` and its `arguments`."""
        bound = inspect.signature(wheel_on_rail_gap).bind(**arguments)
        bound.apply_defaults()
        given = bound.arguments
        wheel, rail = as_profile(given["wheel"]), as_profile(given["rail"])
        cos, sin = np.cos(given["rail_inclination"]), np.sin(given["rail_inclination"])
        turn = np.array([[cos, -sin], [sin, cos]])
        here = np.array([placement.rail_position, float(rail.height(placement.rail_position))])
        stations = _samples(wheel)
        height, slope = _height_and_slope(wheel, stations)
        own = _samples(rail)
        z, rise = _height_and_slope(rail, own)
        shift = placement.position[1:] - turn @ here
        y, up = turn @ np.stack([own, z]) + shift[:, None]
        across, along = cos - sin * rise, sin + cos * rise
        # the under side of a turned flank is never touched from above
        is_top = (across > 0.0) & (np.maximum.accumulate(y) == y)
        return cls(
            wheel=wheel,
            rail=rail,
            radius=float(given["wheel_radius"]),
            tape=0.5 * given["flange_back"] + given["tape_circle"],
            first_height=placement.undeformed_height,
            turn=turn,
            shift=shift,
            stations=stations,
            station_radius=given["wheel_radius"] - height,
            station_slope=-slope,
            head=np.stack([y, up, np.arctan2(along, across)])[:, is_top],
            head_position=own[is_top],
        )

    def _silhouette(self, centre: Array, axle: Array) -> Array:
        """Outline (3, n) [m] of the wheel as seen along the rail: where the prism can touch it."""
        along = np.array([1.0, 0.0, 0.0]) - axle[0] * axle
        length = np.sqrt(1.0 - axle[0] ** 2)
        along /= length
        down = np.cross(axle, along)
        sin = np.clip(self.station_slope * axle[0] / length, -1.0, 1.0)
        cos = np.sqrt(1.0 - sin**2)
        out = centre[:, None] + np.outer(axle, self.tape + self.stations)
        return np.asarray(out + self.station_radius * (np.outer(down, cos) + np.outer(along, sin)))

    def _clearance(self, outline: Array) -> Array:
        """Vertical distance (n,) [m] of the outline from the rail, infinite beside it."""
        rail = np.interp(outline[1], self.head[0], self.head[1], left=-np.inf, right=-np.inf)
        if np.isneginf(rail).all():
            ends = outline[1, [0, -1]]
            raise ValueError(
                f"the wheel, y = {ends[0]:.4g} .. {ends[1]:.4g} m, is nowhere above the head of the rail, "
                f"y = {self.head[0, 0]:.4g} .. {self.head[0, -1]:.4g} m (the right wheel seen in a mirror)"
            )
        return np.asarray(outline[2] - rail)

    def depth(self, centre: Array, axle: Array) -> float:
        """Largest vertical overlap [m] of the undeformed bodies, negative if apart.

        Raises
        ------
        ValueError
            If the wheel is nowhere over the rail.
        """
        return -float(self._clearance(self._silhouette(centre, axle)).min())

    def patches(self, centre: Array, axle: Array, spacing: tuple[float, float]) -> Iterator[FoundPatch]:
        """The gap over each plane where the undeformed bodies overlap.

        Parameters
        ----------
        centre : (3,) [m]
            Middle of the axle in the track.
        axle : (3,)
            Unit vector to the left.
        """
        outline = self._silhouette(centre, axle)
        clearance = self._clearance(outline)
        angle = np.interp(outline[1], self.head[0], self.head[2])
        for part in _parts(clearance, angle):
            yield self._patch(part, outline, clearance, angle, centre, axle, spacing)

    def _patch(
        self,
        part: slice,
        outline: Array,
        clearance: Array,
        angle: Array,
        centre: Array,
        axle: Array,
        spacing: tuple[float, float],
    ) -> FoundPatch:
        x, y = outline[:2, part]
        overlap, slope = -clearance[part], angle[part]
        for name, at, ends in (
            ("rail", y, self.head[0][[0, -1]]),
            ("wheel", self.stations[part], self.stations[[0, -1]]),
        ):
            if at.min() - ends[0] < 2.0 * SAMPLING or ends[1] - at.max() < 2.0 * SAMPLING:
                raise ValueError(f"the contact reaches the end of the {name} profile: it must go on further")
        # half the overlap is what a Hertzian contact covers
        pressed = np.maximum(overlap - 0.5 * overlap.max(), 0.0)
        width = np.abs(np.gradient(y)) if y.size > 1 else np.ones(1)
        weight = np.sqrt(pressed) * width
        lowest = int(overlap.argmax())
        if weight.sum() == 0.0:
            weight[lowest] = 1.0
        is_near = np.abs(slope - slope[lowest]) <= MOST_INCLINED
        share = weight * is_near / (weight * is_near).sum()
        contact_angle = float(share @ slope)
        rail_position = float(np.interp(share @ y, self.head[0], self.head_position))
        cos, sin = np.cos(contact_angle), np.sin(contact_angle)
        on_rail = np.array([rail_position, float(self.rail.height(rail_position))])
        across, up = self.turn @ on_rail + self.shift
        position = np.array([share @ x, across, up])
        # no pressure lies beyond the overlap of the undeformed bodies
        half = np.sqrt(2.0 * self.radius * overlap)
        reach_x = [
            float((x - half)[is_near].min()) - position[0],
            float((x + half)[is_near].max()) - position[0],
        ]
        heights = np.interp(y, self.head[0], self.head[1])
        t = cos * (y - across) + sin * (heights - up)
        reach_y = [float(t[is_near].min()), float(t[is_near].max())]
        lines = [
            np.arange(np.floor(low / d) - 1.0, np.ceil(high / d) + 2.0)
            for (low, high), d in zip((reach_x, reach_y), spacing, strict=True)
        ]
        if lines[0].size * lines[1].size > MOST_POINTS:
            raise ValueError(
                f"the contact takes {lines[0].size} x {lines[1].size} points of spacing {spacing} m: "
                f"at most {MOST_POINTS} are solved, so a larger spacing or less overlap is needed"
            )
        gap = self._gap(position, contact_angle, lines[0] * spacing[0], lines[1] * spacing[1], centre, axle)
        neglected = weight / np.cos(slope)
        return FoundPatch(
            position=position,
            contact_angle=contact_angle,
            rail_position=rail_position,
            wheel_position=float(share @ self.stations[part]),
            first=(int(lines[0][0]), int(lines[1][0])),
            gap=gap,
            neglected=float(neglected[~is_near].sum() / neglected.sum()),
        )

    def _gap(
        self, position: Array, contact_angle: float, x: Array, y: Array, centre: Array, axle: Array
    ) -> Array:
        """Distance (ny, nx) [m] from the rail to the wheel along the normal of the plane."""
        cos, sin = np.cos(contact_angle), np.sin(contact_angle)
        normal = np.array([0.0, -sin, cos])
        # the rail: a prism, so one row is enough
        foot = position[1:, None] + np.array([[cos], [sin]]) * y
        own = self.turn.T @ (foot - self.shift[:, None])
        ahead = self.turn.T @ normal[1:]
        low, high = self.rail.range
        below = np.zeros_like(y)
        for _ in range(MOST_STEPS):
            at = own + np.outer(ahead, below)
            z, rise = _height_and_slope(self.rail, np.clip(at[0], low, high))
            change = (at[1] - z) / np.maximum(ahead[1] - rise * ahead[0], STEEPEST)
            change = np.clip(change, -LONGEST, LONGEST)
            below -= change
            if np.abs(change).max() < CLOSE:
                break
        is_rail = (at[0] >= low) & (at[0] <= high) & (np.abs(change) < FOUND)
        # the wheel: of revolution, so the distance from the axle counts
        base = np.empty((3, y.size, x.size))
        base[0] = position[0] + x
        base[1:] = foot[:, :, None]
        base -= centre[:, None, None]
        low, high = self.wheel.range
        above = np.repeat(below[:, None], x.size, axis=1)
        for _ in range(MOST_STEPS):
            reach = base + normal[:, None, None] * above
            station = np.tensordot(axle, reach, axes=1)
            out = reach - axle[:, None, None] * station
            distance = np.sqrt((out * out).sum(axis=0))
            station -= self.tape
            height, slope = _height_and_slope(self.wheel, np.clip(station, low, high))
            rate = np.tensordot(normal, out, axes=1) / distance + slope * float(axle @ normal)
            change = (distance - (self.radius - height)) / np.minimum(rate, -STEEPEST)
            change = np.clip(change, -LONGEST, LONGEST)
            above -= change
            if np.abs(change).max() < CLOSE:
                break
        is_body = is_rail[:, None] & (station >= low) & (station <= high) & (np.abs(change) < FOUND)
        return np.where(is_body, above - below[:, None], NOTHING)


def _height_and_slope(profile: Profile, y: Array) -> tuple[Array, Array]:
    """Height [m] and slope [-], which some profiles have infinite at their ends."""
    height, slope = profile._stations(y)[:2]
    return height, np.clip(slope, -STEEP, STEEP)


def _samples(profile: Profile) -> Array:
    """Lateral positions over a profile [m], both ends and all breaks included."""
    breaks = profile.breaks
    pieces = [
        np.linspace(a, b, int(np.ceil((b - a) / SAMPLING)) + 1)[:-1] for a, b in itertools.pairwise(breaks)
    ]
    return np.concatenate([*pieces, breaks[-1:]])


def _parts(clearance: Array, angle: Array) -> Iterator[slice]:
    """Runs of stations that overlap, parted between lowest points that lie on different planes."""
    is_over = np.concatenate([[False], clearance < 0.0, [False]])
    ends = np.flatnonzero(np.diff(is_over.astype(int)))
    for start, stop in zip(ends[::2], ends[1::2], strict=True):
        inside = clearance[start:stop]
        before = np.concatenate([[np.inf], inside[:-1]])
        after = np.concatenate([inside[1:], [np.inf]])
        minima = np.flatnonzero((inside <= before) & (inside < after))
        cuts = [0]
        kept = int(minima[0])
        for low in minima[1:]:
            if abs(angle[start + low] - angle[start + kept]) > MOST_INCLINED:
                cuts.append(kept + int(inside[kept : low + 1].argmax()))
                kept = int(low)
            elif inside[low] < inside[kept]:
                kept = int(low)
        for a, b in zip(cuts, [*cuts[1:], stop - start], strict=True):
            yield slice(start + a, start + b)
