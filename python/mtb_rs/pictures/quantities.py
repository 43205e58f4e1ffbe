# SPDX-License-Identifier: MIT OR Apache-2.0
"""What can be drawn of a result: names, units, labels, colours."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.colors import Normalize
from numpy.typing import NDArray

from ..base.plain import plain
from ..base.words import Body, Limits
from ..results.fields import Field
from ..results.result import Drawn, Pictured

Array = NDArray[np.float64]


#: Okabe and Ito's colours: told apart by everybody, and in grey.
LINE_COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#000000")
STATUS_NAMES = ("open", "stick", "slip", "plastic")
STATUS_COLOURS = ("#E4E4E4", "#0072B2", "#E69F00", "#CC79A7")
OPEN_COLOUR = "#EDEDED"
INK = "#333333"
MILLIMETRE = 1e-3
#: Values below this share of the largest are rounding: they have no sign.
ROUNDING = 1e-6

PREFIXES: dict[str, tuple[tuple[float, str], ...]] = {
    "Pa": ((1e9, "GPa"), (1e6, "MPa"), (1e3, "kPa"), (1.0, "Pa")),
    "m": ((1.0, "m"), (1e-3, "mm"), (1e-6, "µm"), (1e-9, "nm")),
    "1": ((1.0, "-"), (1e-3, "10⁻³"), (1e-6, "10⁻⁶"), (1e-9, "10⁻⁹")),
    "W/m^2": ((1e9, "GW/m²"), (1e6, "MW/m²"), (1e3, "kW/m²"), (1.0, "W/m²")),
    "K": ((1.0, "K"), (1e-3, "mK")),
    "J/m^2": ((1e3, "kJ/m²"), (1.0, "J/m²"), (1e-3, "mJ/m²")),
    "m/s": ((1.0, "m/s"), (1e-3, "mm/s"), (1e-6, "\N{MICRO SIGN}m/s")),
}


def states_of(status: NDArray[np.int8]) -> int:
    """How many states pictures tell apart: plastic ones where there are some."""
    return 4 if (status == 3).any() else 3


def drawable(result: Pictured) -> tuple[Any, ...]:
    """The words of what this kind of result has to draw."""
    return tuple(dict.fromkeys(word for field in result.fields().values() for word in field.words))


def as_drawn(result: Any) -> Drawn:
    """The door: whatever it is that is to be drawn; `ValueError` if it is no result."""
    if not isinstance(result, Drawn):
        raise ValueError(f"{result!r} cannot be drawn: a result of a solve or a step is needed")
    return result


def quantity_of(result: Pictured, word: str, body: Body = "lower") -> Field:
    """What a word stands for in a result, of a body where bodies differ; `ValueError` for one it has not."""
    found = [field for field in result.fields().values() if word in field.words]
    of_body = [field for field in found if field.body in (None, body)]
    # what one body alone has needs no word for the body
    if found and (of_body or len(found) == 1):
        return (of_body or found)[0].part(word)
    named = _named(result).get(word)
    if named is not None:
        return named.part(next(iter(named.words)))
    raise ValueError(_unknown(word, result))


def check_quantity(result: Pictured, word: Any, curves: tuple[str, ...]) -> None:
    """`ValueError` for what is neither drawn of the last state of a result nor one of its curves."""
    if word not in (*_accepted(result), *_named(result)):
        raise ValueError(_unknown(word, result, curves))


def _named(result: Pictured) -> dict[str, Field]:
    """Fields of one body each that their own names draw as well."""
    fields = result.fields().values()
    return {field.name: field for field in fields if field.body is not None and not field.is_vector}


def _accepted(result: Pictured) -> tuple[str, ...]:
    # stresses are drawn in space, of bodies that have elements
    return (*drawable(result), "von_mises") if result.has_solids else drawable(result)


def _unknown(word: Any, result: Pictured, curves: tuple[str, ...] = ()) -> str:
    return f"quantity is {word!r}: one of {', '.join((*curves, *_accepted(result)))} is needed"


def unit_of(values: Array, unit: str) -> tuple[float, str]:
    """The prefix that suits the largest value: 0.3 to 300 of it."""
    largest = float(np.abs(values).max(initial=0.0))
    for factor, name in PREFIXES[unit]:
        if largest >= 0.3 * factor:
            return factor, name
    return PREFIXES[unit][-2 if largest == 0.0 else -1]


#: Ends of scales, times a power of ten: their quarters have two digits at most.
_ROUND = (1.0, 1.2, 1.6, 2.0, 2.4, 3.2, 4.0, 5.0, 6.0, 8.0, 10.0)


@dataclass(frozen=True)
@plain
class Scale:
    """Unit and colours of a picture: drawn is value / factor, in `unit`."""

    factor: float
    unit: str
    colours: str
    norm: Normalize
    extend: str


def without_rounding(values: Array) -> Array:
    """The values, zero where they are rounding beside the largest."""
    least = ROUNDING * float(np.abs(values).max(initial=0.0))
    return np.where(np.abs(values) <= least, 0.0, values)


def colour_scale(values: Array, asked: Field, limits: Limits | None = None) -> Scale:
    """Unit and colours for `values` [SI], or for given `limits` [SI].

    Values on both sides of zero get a scale that is white there. Peaks at sharp edges, singular in
    theory, do not flatten the rest: the scale then ends below them, and says so by its open end, or where
    a bar has none by :func:`bar_title`.
    """
    spanned = values if limits is None else np.array(limits)
    factor, unit = unit_of(spanned, asked.unit)
    spanned = spanned / factor
    spanned = without_rounding(spanned)
    low, high = (float(spanned.min()), float(spanned.max())) if spanned.size else (0.0, 1.0)
    if limits is not None:
        below = bool(values.size and values.min() < limits[0])
        above = bool(values.size and values.max() > limits[1])
        extend = "both" if below and above else "min" if below else "max" if above else "neither"
        mixed, falling = low < 0.0 < high, high <= 0.0 and low < 0.0
        colours = "RdBu_r" if mixed else "viridis_r" if falling or asked.is_distance else "viridis"
        return Scale(factor, unit, colours, Normalize(low, high), extend)
    if min(-low, high) > 0.02 * max(-low, high):
        bound = max(-low, high)
        return Scale(factor, unit, "RdBu_r", Normalize(-bound, bound), "neither")
    if -low > high:
        return Scale(factor, unit, "viridis_r", Normalize(low, high), "neither")
    robust = float(np.percentile(spanned, 97.0)) if spanned.size else high
    peaked = high > 1.4 * robust > 0.0
    norm = Normalize(0.0, _round(robust if peaked else high))
    return Scale(
        factor, unit, "viridis_r" if asked.is_distance else "viridis", norm, "max" if peaked else "neither"
    )


def _round(value: float) -> float:
    """The next number that four ticks divide into round ones; 1 for nothing."""
    if value <= 0.0 or not np.isfinite(value):
        return 1.0
    power = 10.0 ** np.floor(np.log10(value))
    return float(power * min(n for n in _ROUND if n * power >= value * (1 - 1e-12)))


def bar_title(label: str, values: Array, scale: Scale) -> str:
    """What stands over the bar of a picture in space: what, in which unit, and what the scale leaves out."""
    title = f"{label}\n[{scale.unit}]"
    if scale.extend in ("max", "both"):
        title += f"\n(largest {values.max() / scale.factor:.3g})"
    if scale.extend in ("min", "both"):
        title += f"\n(smallest {values.min() / scale.factor:.3g})"
    return title
