# SPDX-License-Identifier: MIT OR Apache-2.0
"""Points of measured profiles as files have them: unit, order, direction of z, mirror, what is guessed."""

from __future__ import annotations

from itertools import pairwise
from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..base.check import choice
from ..base.words import Unit, ZAxis

Array = NDArray[np.float64]

#: Widths [m] of rails and wheels, toys included.
USUAL_WIDTH = (5e-3, 0.5)
#: Points from which on gaps between them count.
FEW = 50
#: Widest gap between points, and how far one may stand out from both its neighbours [m].
HOLE, SPIKE = 4e-3, 1e-3
#: Width [m] below which a unit that nothing states is doubtful.
DOUBTFUL_WIDTH = 30e-3
#: Departure [m] from the height at y = 0 beyond which a profile goes down into a flange or a flank.
FLANGE_HEIGHT = 10e-3
#: Metres per unit of length.
UNITS: dict[Unit, float] = {"m": 1.0, "mm": 1e-3, "um": 1e-6, "in": 0.0254}
#: Share of the larger departure from the median height from which on the smaller one makes a guess doubtful.
DOUBTFUL = 0.5
#: Share of the whole width that the one run of points has whose ends may be cut off.
MOST_OF_IT = 0.8
#: Slope beyond which y = 0 is neither a crown nor a tape circle.
NO_CROWN = 0.3


class Points(NamedTuple):
    """Points of a profile, y rising, z up [m], and what was recognised on the way."""

    y: Array
    z: Array
    notes: list[str]


def metres(unit: Unit) -> float:
    """Length of a unit known by name [m]."""
    return UNITS[choice("unit", unit, Unit)]


def departs_upwards(z: Array) -> bool:
    """Whether the larger departure from the median height points up."""
    middle = np.sort(z)[z.size // 2]
    return bool(z.max() - middle > middle - z.min())


def recognised(
    y: Array,
    z: Array,
    *,
    stated: float | None,
    form: str,
    unit: Unit | Literal["guess"],
    z_axis: ZAxis,
    mirror: bool | Literal["guess"],
) -> Points:
    """The points of a file in metres, y rising, z up, gauge side or flange at y < 0.

    Parameters
    ----------
    y, z : (n,)
        In the unit of the file.
    stated : float or None [m]
        The unit that the file states.
    form : str
        "columns" are not named by a heading, so that they may be swapped.
    unit, z_axis, mirror
        As of :meth:`mtb_rs.Profile.from_file`.

    Raises
    ------
    ValueError
        If the points are no profile: two of them, or y runs backwards inside.
    """
    notes: list[str] = []
    repeated = np.append(False, (np.diff(y) == 0.0) & (np.diff(z) == 0.0))
    if repeated.any():
        y, z = y[~repeated], z[~repeated]
        notes.append(f"{repeated.sum()} of its points repeat the one before: they are left out")
    if y.size < 2:
        return Points(y, z, notes)
    if form == "columns" and _is_monotonic(z) and _turns_back(y):
        y, z = z, y
        notes.append(
            "its first column turns back and the second one does not: they are taken for z and y; name the "
            "columns in a heading (z, y)"
        )
    y, z = _one_run(y, z, notes)
    if y[-1] < y[0]:
        y, z = y[::-1], z[::-1]
    scale = _scale(y, stated, form, unit, notes)
    y, z = scale * y, scale * z
    notes += _gaps(y, z)
    middle = np.sort(z)[z.size // 2]
    larger, smaller = sorted((float(z.max() - middle), float(middle - z.min())), reverse=True)
    is_doubtful = smaller > DOUBTFUL * larger
    # where the points leave it open, z of .prr and .prw is down
    if z_axis == "guess" and is_doubtful and form == "framed":
        z_axis = "down"
    if z_axis == "down" or (z_axis == "guess" and departs_upwards(z)):
        z = -z
    if z_axis == "guess" and is_doubtful:
        notes.append(
            f"z goes {1e3 * larger:.3g} mm to one side of its median and {1e3 * smaller:.3g} mm to the "
            "other: that the larger one is down is a guess; state z_axis"
        )
    if mirror is True or (mirror == "guess" and _goes_down_outside(y, z)):
        y, z = -y[::-1], z[::-1]
        if mirror == "guess":
            notes.append(
                "its deep side, a flange or a gauge face, lies at y > 0: it is mirrored, because that side "
                "belongs to y < 0 here; state mirror"
            )
    elif mirror == "guess":
        inside, outside = falls(y, z)
        if outside > FLANGE_HEIGHT > inside:
            notes.append(
                f"it goes down by {1e3 * outside:.3g} mm at y > 0 and by {1e3 * inside:.3g} mm at y < 0: "
                "whether its flange or gauge face lies at y > 0, where it does not belong here, is not "
                "guessed; state mirror"
            )
    notes += _of_origin(y, z)
    return Points(np.ascontiguousarray(y), np.ascontiguousarray(z), notes)


def _is_monotonic(values: Array) -> bool:
    steps = np.diff(values)
    return bool((steps > 0.0).all() or (steps < 0.0).all())


def _turns_back(values: Array) -> bool:
    steps = np.diff(values)
    return bool((steps > 0.0).any() and (steps < 0.0).any())


def _one_run(y: Array, z: Array, notes: list[str]) -> tuple[Array, Array]:
    """The run of points along which y rises or falls, if no more than the ends is left out with it."""
    if y.size < 3 or _is_monotonic(y):
        return y, z
    way = np.sign(np.diff(y))
    turns = np.flatnonzero(np.diff(way)) + 1
    ends = np.concatenate([[0], turns, [y.size - 1]])
    runs = [(int(a), int(b)) for a, b in pairwise(ends.tolist()) if way[a] != 0.0]
    if not runs:
        return y, z
    runs.sort(key=lambda run: -abs(y[run[1]] - y[run[0]]))
    first, last = runs[0]
    width = abs(float(y[last] - y[first]))
    if len(runs) > 1:
        low, high = (max(min(y[a], y[b]) for a, b in runs[:2]), min(max(y[a], y[b]) for a, b in runs[:2]))
        narrow = min(abs(float(y[b] - y[a])) for a, b in runs[:2])
        if narrow > 0.5 * width and high - low > 0.5 * narrow:
            later = max(runs[0][0], runs[1][0])
            raise ValueError(
                f"y runs twice over the same {narrow:.4g} of its unit, the second time from row {later + 1} "
                "of the points on: these look like two profiles, and one a file is read"
            )
    if width < MOST_OF_IT * np.ptp(y):
        # the core names the row where y turns back
        return y, z
    left_out = y.size - (last - first + 1)
    notes.append(
        f"y turns back at {y[first]:.4g} or {y[last]:.4g} of its unit, where a flange or flank is undercut: "
        f"the {left_out} points beyond are left out"
    )
    return y[first : last + 1], z[first : last + 1]


def _scale(
    y: Array, stated: float | None, form: str, unit: Unit | Literal["guess"], notes: list[str]
) -> float:
    """Metres per unit of the points."""
    if stated is not None:
        return stated
    if unit != "guess":
        return metres(unit)
    width = float(np.ptp(y))
    low, high = USUAL_WIDTH
    if form != "miniprof":
        for name in ("m", "um"):
            scale = UNITS[name]
            if low <= scale * width <= high:
                notes.append(
                    f"its width is {width:.4g} without a unit, taken as {name}, because no rail or wheel is "
                    f"{width:.4g} mm wide; state unit"
                )
                return scale
    if UNITS["mm"] * width < DOUBTFUL_WIDTH and (form == "miniprof" or low <= UNITS["mm"] * width):
        notes.append(
            f"its width is {width:.4g} without a unit, taken as mm, which is a toy's: rails and wheels "
            "are as wide in centimetres or inches; state unit"
        )
    return UNITS["mm"]


def _gaps(y: Array, z: Array) -> list[str]:
    """Notes on points that are missing, and on single ones that stand out."""
    if y.size < FEW:
        return []
    notes = []
    away = np.hypot(np.diff(y), np.diff(z))
    widest = int(np.argmax(away))
    usual = float(np.median(away))
    if away[widest] > HOLE and away[widest] > 20.0 * usual:
        notes.append(
            f"no point lies between y = {1e3 * y[widest]:.4g} and {1e3 * y[widest + 1]:.4g} mm, where others "
            f"are {1e3 * usual:.2g} mm apart: what is missing there is made up by the curve through the rest"
        )
    rises = np.diff(z)
    # up and down again, or down and up, between two points that lie side by side
    out = np.minimum(np.abs(rises[:-1]), np.abs(rises[1:]))
    alone = (rises[:-1] * rises[1:] < 0.0) & (out > np.maximum(SPIKE, y[2:] - y[:-2]))
    if alone.any():
        at = int(np.argmax(alone))
        notes.append(
            f"the point at y = {1e3 * y[at + 1]:.4g} mm stands out from both its neighbours by "
            f"{1e3 * out[at]:.3g} mm: a single one, as of dirt; leave it out"
        )
    return notes


def _goes_down_outside(y: Array, z: Array) -> bool:
    """Whether only the side y > 0 goes down as a flange or a gauge face does."""
    inside, outside = falls(y, z)
    return outside > FLANGE_HEIGHT and inside < 0.5 * FLANGE_HEIGHT


def falls(y: Array, z: Array) -> tuple[float, float]:
    """How far points fall below their height at y = 0, or at the end next to it, at y < 0 and y > 0 [m]."""
    middle = float(np.interp(0.0, y, z))
    inside, outside = (middle - float(z[side].min(initial=middle)) for side in (y <= 0.0, y >= 0.0))
    return inside, outside


def _of_origin(y: Array, z: Array) -> list[str]:
    """A question where y = 0 is neither a crown nor a tape circle."""
    if y.size < 4:
        return []
    if not y[0] < 0.0 < y[-1]:
        return [
            f"y = 0, where a rail has its crown and a wheel its tape circle, is not between its ends at "
            f"{1e3 * y[0]:.4g} and {1e3 * y[-1]:.4g} mm: shift its y"
        ]
    near = np.abs(y) <= max(2e-3, 2.0 * float(np.diff(y).max()))
    slope = float(np.polyfit(y[near], z[near], 1)[0])
    if abs(slope) <= NO_CROWN:
        return []
    return [
        f"at y = 0, where a rail has its crown and a wheel its tape circle, z slopes by {slope:.2g}: shift "
        "its y"
    ]
