# SPDX-License-Identifier: MIT OR Apache-2.0
"""Derivatives by differences of the fourth order: places, in widths, and their weights."""

from __future__ import annotations

from collections.abc import Iterator

#: On both sides.
CENTRAL = ((-2, -1, 1, 2), (1.0 / 12.0, -2.0 / 3.0, 2.0 / 3.0, -1.0 / 12.0))
#: From here on to larger values, and from smaller ones to here.
AHEAD = ((0, 1, 2, 3, 4), (-25.0 / 12.0, 4.0, -3.0, 4.0 / 3.0, -0.25))
BEHIND = ((0, -1, -2, -3, -4), (25.0 / 12.0, -4.0, 3.0, -4.0 / 3.0, 0.25))

#: Widths for Young's moduli, over themselves, and for Poisson's ratios.
_MODULUS, _RATIO = 3e-3, 1e-3


def by_modulus(name: str, value: float) -> Iterator[list[tuple[float, float]]]:
    """Weights in a derivative by a modulus, and its values, in each way there is, the best one first."""
    width = _MODULUS * value if name == "young_modulus" else _RATIO
    for places, weights in (CENTRAL, BEHIND, AHEAD):
        values = [value + place * width for place in places]
        if name == "young_modulus" or max(values) < 0.5:
            yield [(weight / width, other) for weight, other in zip(weights, values, strict=True)]
