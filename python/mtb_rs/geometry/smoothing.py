# SPDX-License-Identifier: MIT OR Apache-2.0
"""Measured profiles smoothed by splines over their arc length, with their kinks kept."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..base.check import positive, reals
from ..base.owning import owning
from ..base.plain import plain

Array = NDArray[np.float64]

#: Points of a smoothed curve over its wavelength, and least points of a piece between two kinks.
FINE, LEAST = 20, 5
#: Stiffness, over (wavelength / 2 pi)^4, at which splines of the points and of what is left keep half of a
#: wave.
STIFFNESS = 1.0 + np.sqrt(2.0)
#: Weight of the point that two pieces share at a kink, beside 1 of all others.
HELD = 1e8


@owning
@dataclass(frozen=True)
@plain
class Smoothing:
    """What smoothing has done to a profile.

    Attributes
    ----------
    wavelength : float [m]
        Waves of this length along the profile keep half of their height; those of twice the length keep 98 %
        and those of half the length 5 %.
    largest : float [m]
        Largest distance of a point from the smoothed profile, normal to it.
    at : float [m]
        y of that point.
    rms : float [m]
        Root mean square of these distances.
    kinks : (k,) [m]
        y of the kinks that were kept.
    kink_angles : (k,) [rad]
        By how much the profile turns at each, > 0 to the left with rising y.
    recognised : bool
        Whether the kinks were recognised, and not given.
    y, z : (n,) [m]
        The points before.
    """

    wavelength: float
    largest: float
    at: float
    rms: float
    kinks: Array
    kink_angles: Array
    recognised: bool
    y: Array
    z: Array


class Smoothed(NamedTuple):
    """Polynomials between places y, as the core takes them, and what was done."""

    numbers: Array
    smoothing: Smoothing


def smoothed(
    y: Array, z: Array, wavelength: float, kinks: Sequence[float] | None, kink_angle: float
) -> Smoothed:
    """Smoothing splines of y and z over the arc length; see :meth:`mtb_rs.Profile.smoothed`."""
    spline = _scipy()
    wavelength = positive("wavelength", wavelength, "m")
    limit = positive("kink_angle", kink_angle, "rad")
    s = np.append(0.0, np.cumsum(np.hypot(np.diff(y), np.diff(z))))
    step = float(np.median(np.diff(s)))
    if wavelength < 2.0 * step:
        raise ValueError(
            f"wavelength is {wavelength:g} m: the points of the profile lie {step:.3g} m apart, and at least "
            "twice that is needed"
        )
    if wavelength > s[-1]:
        raise ValueError(
            f"wavelength is {wavelength:g} m: the profile is {s[-1]:.4g} m long, and waves longer than that "
            "are the profile itself"
        )
    found = _recognised(s, y, z, wavelength, limit) if kinks is None else _given(y, kinks)
    ends = np.unique(np.concatenate([[0], found, [y.size - 1]]))
    if np.diff(ends).min() < LEAST - 1:
        k = int(np.diff(ends).argmin())
        raise ValueError(
            f"between y = {y[ends[k]]:.4g} and {y[ends[k + 1]]:.4g} m there are {ends[k + 1] - ends[k] + 1} "
            f"points: a piece between kinks or ends needs {LEAST}"
        )
    points = np.array([y, z])
    free = [_piece(spline, s, points, a, b, wavelength, None) for a, b in _pairs(ends)]
    # both pieces meet in the middle of where they would end
    joints: dict[int, Array] = {
        int(end): 0.5 * (before(s[end]) + after(s[end]))
        for end, before, after in zip(ends[1:-1], free[:-1], free[1:], strict=True)
    }
    curves = [_piece(spline, s, points, a, b, wavelength, joints) for a, b in _pairs(ends)]
    away, numbers = np.empty(y.size), []
    for (a, b), curve in zip(_pairs(ends), curves, strict=True):
        tangent = curve(s[a : b + 1], 1)
        normal = np.array([-tangent[:, 1], tangent[:, 0]]) / np.hypot(*tangent.T)
        away[a : b + 1] = ((points[:, a : b + 1] - curve(s[a : b + 1]).T) * normal).sum(axis=0)
        numbers.append(_polynomials(curve, s[a], s[b], min(step, wavelength / FINE), joints, (a, b)))
    angles = [
        _turn(before(s[k], 1), after(s[k], 1)) for k, before, after in _meetings(found, s, curves, ends)
    ]
    worst = int(np.abs(away).argmax())
    smoothing = Smoothing(
        wavelength=wavelength,
        largest=float(abs(away[worst])),
        at=float(y[worst]),
        rms=float(np.sqrt(np.mean(away**2))),
        kinks=np.array([joints[int(k)][0] for k in found]),
        kink_angles=np.array(angles),
        recognised=kinks is None,
        y=y,
        z=z,
    )
    return Smoothed(np.concatenate(numbers), smoothing)


def _scipy() -> Any:
    try:
        from scipy import interpolate
    except ImportError as error:
        raise ImportError("scipy is missing: pip install 'mtb-rs[smooth]'") from error
    return interpolate


def _pairs(ends: NDArray[np.intp]) -> list[tuple[int, int]]:
    return [(int(a), int(b)) for a, b in pairwise(ends.tolist())]


def _meetings(found: Any, s: Array, curves: list[Any], ends: NDArray[np.intp]) -> list[tuple[int, Any, Any]]:
    """Each kink with the curves before and after it."""
    places = {int(end): k for k, end in enumerate(ends)}
    return [(int(k), curves[places[int(k)] - 1], curves[places[int(k)]]) for k in found]


def _turn(before: Array, after: Array) -> float:
    """Angle from one direction to another."""
    return float(np.arctan2(before[0] * after[1] - before[1] * after[0], before @ after))


def _given(y: Array, kinks: Sequence[float]) -> NDArray[np.intp]:
    """The points next to given places."""
    places = np.atleast_1d(reals("kinks", kinks, "m"))
    if places.ndim != 1:
        raise ValueError(f"kinks has the shape {places.shape}: a sequence of places y is needed")
    for k, place in enumerate(places):
        if not y[0] < place < y[-1]:
            raise ValueError(
                f"kinks[{k}] is {place:g} m: a place inside of the profile, y = {y[0]:.4g} .. {y[-1]:.4g} m, "
                "is needed"
            )
    nearest = np.array([np.abs(y - place).argmin() for place in places], dtype=np.intp)
    points, count = np.unique(nearest, return_counts=True)
    if np.any(count > 1):
        twice = int(np.argmax(count > 1))
        one, other = np.flatnonzero(nearest == points[twice])[:2]
        raise ValueError(
            f"kinks[{one}] and kinks[{other}] are {places[one]:g} and {places[other]:g} m: both lie "
            f"next to one point of the profile, y = {y[points[twice]]:.6g} m; name each kink once"
        )
    return points


def _recognised(s: Array, y: Array, z: Array, wavelength: float, limit: float) -> NDArray[np.intp]:
    """Points where parabolas through the points on either side, over a wavelength, meet at an angle."""
    turn = np.zeros(y.size)
    first = np.searchsorted(s, s - wavelength, "left")
    last = np.searchsorted(s, s + wavelength, "right")
    # a whole window on either side, so that noise does not look like a kink
    inner = (s - wavelength >= s[0]) & (s + wavelength <= s[-1])
    for k in np.flatnonzero(inner):
        sides = [slice(first[k], k + 1), slice(k, last[k])]
        if min(side.stop - side.start for side in sides) < LEAST:
            continue
        ways = [np.polyfit(s[side] - s[k], np.column_stack([y[side], z[side]]), 2)[1] for side in sides]
        turn[k] = _turn(*ways)
    above = np.abs(turn) > limit
    starts = np.flatnonzero(above & ~np.append(False, above[:-1]))
    stops = np.flatnonzero(above & ~np.append(above[1:], False))
    runs = zip(starts, stops, strict=True)
    return np.array([a + int(np.abs(turn[a : b + 1]).argmax()) for a, b in runs], dtype=np.intp)


def _piece(
    spline: Any, s: Array, points: Array, a: int, b: int, wavelength: float, joints: dict[int, Array] | None
) -> Any:
    """The smoothing spline of points a .. b, through the joints at its ends, if there are any."""
    part = slice(a, b + 1)
    values, weight = points[:, part].copy(), np.gradient(s[part])
    weight /= weight.mean()
    for end, own in ((a, 0), (b, -1)):
        if joints is not None and end in joints:
            values[:, own], weight[own] = joints[end], HELD
    spacing = float(np.diff(s[part]).mean())
    stiffness = STIFFNESS * (wavelength / (2.0 * np.pi)) ** 4 / spacing

    def smooth(rows: Array) -> list[Any]:
        return [spline.make_smoothing_spline(s[part], row, w=weight, lam=stiffness) for row in rows]

    once = smooth(values)
    # smoothing what is left, too, keeps far more of long waves, and of arcs up to their ends
    twice = smooth(values - np.array([one(s[part]) for one in once]))

    def curve(at: Any, derivative: int = 0) -> Array:
        return np.stack(
            [one(at, derivative) + other(at, derivative) for one, other in zip(once, twice, strict=True)],
            axis=-1,
        )

    return curve


def _polynomials(
    curve: Any, start: float, end: float, step: float, joints: dict[int, Array], own: tuple[int, int]
) -> Array:
    """A piece of curve as cubic polynomials z(y), in the form of the core."""
    s = np.linspace(start, end, max(LEAST, int(np.ceil((end - start) / step)) + 1))
    y, z = curve(s).T
    # what two pieces share is the same number in both
    for k, place in ((0, own[0]), (-1, own[1])):
        if place in joints:
            y[k], z[k] = joints[place]
    back = np.flatnonzero(np.diff(y) <= 0.0)
    if back.size:
        raise ValueError(
            f"the smoothed profile turns back at y = {y[back[0]]:.4g} m, where it is steep: take a longer "
            "wavelength, or leave the points of the flank out"
        )
    return _cubics(y, z)


def _cubics(y: Array, z: Array) -> Array:
    """The cubic spline through points as pieces: ends, kind 0, origin, count and coefficients of each."""
    rising = _scipy().CubicSpline(y, z).c[::-1].T
    count = y.size - 1
    return np.column_stack([y[:-1], y[1:], np.zeros(count), y[:-1], np.full(count, 4.0), rising]).ravel()
