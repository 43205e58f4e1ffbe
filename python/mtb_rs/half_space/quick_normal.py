# SPDX-License-Identifier: MIT OR Apache-2.0
"""Normal contact by interpenetration, as results of :func:`mtb_rs.solve_normal`."""

from __future__ import annotations

import time
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..bodies.simple import Layered, Simple
from ..results.report import Report
from .hertzian import modulus
from .interpenetration import Quick, press
from .normal import NormalResult, centres

Array = NDArray[np.float64]

_SOLVERS = {"kpec": "KPEC: interpenetration", "analyn": "ANALYN: interpenetration, Hertz row by row"}


def quick_result(
    heights: Array,
    sides: tuple[float, float],
    bodies: tuple[Simple, Simple],
    load: tuple[float | None, float | None],
    method: Quick,
    refused: dict[str, Any],
) -> NormalResult:
    """The result at a load, a force [N] or an approach [m]; `refused`: arguments given in vain."""
    started = time.perf_counter()
    for name, value in refused.items():
        raise ValueError(
            f'{name} is {value!r}: method="{method}" does not take it; method="auto", "dense" or "fft" does'
        )
    lower, upper = bodies
    for side, body in (("lower", lower), ("upper", upper)):
        if isinstance(body, Layered):
            raise ValueError(
                f'{side} is a Layered: method="{method}" is for half-spaces; "auto" takes layers'
            )
    found = press(heights, sides, modulus(lower, upper), *load, method)
    touches = found.pressure > 0.0
    gap = heights + found.displacement - found.approach
    area = sides[0] * sides[1]
    wrong = max(
        float(np.abs(gap[touches]).max(initial=0.0)), float(np.maximum(-gap[~touches], 0.0).max(initial=0.0))
    )
    moved = float(np.sqrt(np.mean(found.displacement[touches] ** 2))) if touches.any() else 1.0
    report = Report(
        converged=True,
        status="approximate",
        model="half-space",
        method=method,
        solver=_SOLVERS[method],
        iterations=0,
        residual=wrong / moved,
        contact_area=float(np.count_nonzero(touches) * area),
        peak_pressure=float(found.pressure.max()),
        time_s={"solve": time.perf_counter() - started},
    )
    return NormalResult(
        points=centres((heights.shape[0], heights.shape[1]), sides),
        area=np.full(heights.shape, area),
        spacing=sides,
        pressure=found.pressure,
        gap=gap,
        initial_gap=heights,
        status=touches.astype(np.int8),
        approach=found.approach,
        tilts=(0.0, 0.0),
        normal_force=float(found.pressure.sum() * area),
        contact_area=report.contact_area,
        lower=lower,
        upper=upper,
        periodic=False,
        error_estimate=None,
        report=report,
    )
