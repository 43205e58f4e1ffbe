# SPDX-License-Identifier: MIT OR Apache-2.0
"""The ellipse of Hertz' contact: elliptic integrals, and the ratio of its axes [Johnson1985, ch. 4]."""

from __future__ import annotations

import math


def elliptic_integrals(ratio: float) -> tuple[float, float]:
    """Complete elliptic integrals K and E of modulus k, with k'^2 = 1 - k^2 = `ratio`^2 in (0, 1].

    By the arithmetic-geometric mean, to rounding.
    """
    a, b, factor = 1.0, ratio, 0.5
    deficit = factor * (1.0 - ratio * ratio)
    while abs(a - b) > 1e-15 * a:
        c = 0.5 * (a - b)
        a, b = 0.5 * (a + b), math.sqrt(a * b)
        factor *= 2.0
        deficit += factor * c * c
    first = 0.5 * math.pi / a
    return first, first * (1.0 - deficit)


def curvatures(slim: float) -> tuple[float, float]:
    """Curvatures along and across the long axis of a contact with semi-axes 1 and `slim`, per load.

    The load is 3 F / (pi E*); [Johnson1985, eq. 4.26].
    """
    k2 = 1.0 - slim * slim
    if k2 < 1e-4:
        # both expressions are differences of nearly equal numbers: their series about the circle
        return (
            0.25 * math.pi * (1.0 + k2 * (3.0 / 8.0 + k2 * 15.0 / 64.0)),
            0.25 * math.pi * (1.0 + k2 * (9.0 / 8.0 + k2 * 75.0 / 64.0)),
        )
    first, second = elliptic_integrals(slim)
    return (first - second) / k2, (second / (slim * slim) - first) / k2


def axis_ratio(ratio: float) -> float:
    """Ratio of the semi-axes, at most 1, of the contact whose radii of curvature have `ratio` >= 1."""
    target = math.log(ratio)
    if target == 0.0:
        return 1.0

    def miss(logarithm: float) -> float:
        along, across = curvatures(math.exp(logarithm))
        return math.log(across / along) - target

    # bisection on the logarithm; the axes differ by less than the radii
    low, high = -target - 1.0, 0.0
    while low < (middle := 0.5 * (low + high)) < high:
        low, high = (middle, high) if miss(middle) > 0.0 else (low, middle)
    return math.exp(middle)
