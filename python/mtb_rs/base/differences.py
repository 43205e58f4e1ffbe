# SPDX-License-Identifier: MIT OR Apache-2.0
"""Derivatives by differences of the fourth order: places, in widths, and their weights."""

from __future__ import annotations

from collections.abc import Iterator

#: On both sides.
CENTRAL = ((-2, -1, 1, 2), (1.0 / 12.0, -2.0 / 3.0, 2.0 / 3.0, -1.0 / 12.0))
#: From here on to larger values, and from smaller ones to here.
AHEAD = ((0, 1, 2, 3, 4), (-25.0 / 12.0, 4.0, -3.0, 4.0 / 3.0, -0.25))
BEHIND = ((0, -1, -2, -3, -4), (25.0 / 12.0, -4.0, 3.0, -4.0 / 3.0, 0.25))

#: Widths for Poisson's ratios, and for all other constants of bodies, over themselves.
_RATIO, _SHARE = 1e-3, 3e-3


def by_constant(name: str, value: float) -> Iterator[list[tuple[float, float]]]:
    """Weights in a derivative by a constant of a body, and its values, in each way there is, the best one
    first: no value of Poisson's ratio comes to 0.5 that is not there already."""
    is_ratio = name.endswith("poisson_ratio")
    width = _RATIO if is_ratio else _SHARE * value
    for places, weights in (CENTRAL, BEHIND, AHEAD):
        values = [value + place * width for place in places]
        if not is_ratio or max(values) < 0.5 or max(values) == value:
            yield [(weight / width, other) for weight, other in zip(weights, values, strict=True)]
