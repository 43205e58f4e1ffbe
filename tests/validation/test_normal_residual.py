# SPDX-License-Identifier: MIT OR Apache-2.0
"""The residual that a normal contact reports, evaluated again from its pressure, approach and tilts alone.

The definition of the docs, by another influence function and other products: the largest gap where there is
pressure or penetration where there is none, over the root mean square of the elastic displacement where there
is pressure.
"""

from __future__ import annotations

import itertools
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import mtb_rs as mtb

Array = NDArray[np.float64]

SPACING = (1.1e-5, 0.9e-5)
BODIES = (mtb.Material(210e9, 0.3), mtb.Material(70e9, 0.33))
#: 1 / E* [1/Pa]
COMPLIANCE = sum((1.0 - b.poisson_ratio**2) / b.young_modulus for b in BODIES)


def rectangle(x: Array, y: Array) -> Array:
    """Displacement by 1 Pa on a cell about the origin: [Johnson1985, eq. 3.25], by logarithms."""
    a, b = 0.5 * SPACING[0], 0.5 * SPACING[1]
    left, right, down, up = x - a, x + a, y - b, y + b

    def part(p: Array, q1: Array, q2: Array) -> Array:
        # p ln((q2 + r2) / (q1 + r1)), by whichever side of zero does not cancel
        r1, r2 = np.hypot(p, q1), np.hypot(p, q2)
        flip = (q1 < 0.0) & (q2 < 0.0)
        plain = np.log((q2 + r2) / np.where(flip, 1.0, q1 + r1))
        turned = np.log((r1 - q1) / np.where(flip, r2 - q2, 1.0))
        return np.asarray(p * np.where(flip, turned, plain))

    logs = part(right, down, up) - part(left, down, up) + part(up, left, right) - part(down, left, right)
    return COMPLIANCE / np.pi * logs


def displacement(pressure: Array, periodic: bool) -> Array:
    ny, nx = pressure.shape
    if periodic:
        kx = 2.0 * np.pi * np.fft.fftfreq(nx, SPACING[0])[None, :]
        ky = 2.0 * np.pi * np.fft.fftfreq(ny, SPACING[1])[:, None]
        k = np.hypot(kx, ky)
        k[0, 0] = np.inf
        return np.asarray(np.fft.ifft2(np.fft.fft2(pressure) * 2.0 * COMPLIANCE / k).real)
    x = SPACING[0] * np.arange(1 - nx, nx)[None, :]
    y = SPACING[1] * np.arange(1 - ny, ny)[:, None]
    shape = (3 * ny, 3 * nx)
    product = np.fft.fft2(pressure, shape) * np.fft.fft2(rectangle(x, y), shape)
    return np.asarray(np.fft.ifft2(product).real[ny - 1 : 2 * ny - 1, nx - 1 : 2 * nx - 1])


def measured(found: mtb.NormalResult, gap: Array) -> float:
    u = displacement(found.pressure, found.periodic)
    along, across = found.tilts
    apart = gap + u - found.approach - along * found.points[0] - across * found.points[1]
    loaded = found.pressure > 0.0
    wrong = np.where(loaded, np.abs(apart), -apart).max()
    return float(max(wrong, 0.0) / np.sqrt((u[loaded] ** 2).mean()))


def surface(kind: str, shape: tuple[int, int]) -> Array:
    ny, nx = shape
    x = SPACING[0] * (np.arange(nx) - 0.5 * (nx - 1))[None, :]
    y = SPACING[1] * (np.arange(ny) - 0.5 * (ny - 1))[:, None]
    if kind == "smooth":
        return np.asarray((x**2 + 1.3 * y**2) / 0.02)
    heights = mtb.roughness(shape, SPACING, rms_height=2e-9, hurst=0.7, roll_off=1e-4, shortest=4e-5, seed=4)
    return np.asarray((x**2 + 1.3 * y**2) / 0.06 - heights)


LOADS: dict[str, dict[str, Any]] = {
    "force": {"force": 0.6},
    "approach": {"approach": 3e-7},
    "force and moments": {"force": 0.6, "moments_about_axes": (1e-6, -8e-6)},
    "force and a moment": {"force": 0.5, "moments_about_axes": (None, 5e-6)},
    "approach and moments": {"approach": 3e-7, "moments_about_axes": (5e-6, -4e-6)},
}


@pytest.mark.coarse
@pytest.mark.filterwarnings("ignore:the peak pressure is")
@pytest.mark.parametrize("tolerance", [1e-4, 1e-8, 1e-11, None])
@pytest.mark.parametrize("method", ["dense", "fft"])
@pytest.mark.parametrize("kind", ["smooth", "rough"])
@pytest.mark.parametrize(
    ("load", "periodic"),
    [(load, False) for load in LOADS] + [("force", True), ("approach", True)],
)
def test_the_reported_residual_is_the_measured_one(
    load: str, periodic: bool, kind: str, method: Any, tolerance: float | None
) -> None:
    # odd and even cells; the dense method takes few
    shape = (26, 31) if method == "dense" else (72, 91)
    gap = surface(kind, shape)
    if load == "approach" and periodic:
        given: dict[str, Any] = {"approach": 0.3 * float(gap.mean()) + 0.7 * float(gap.min())}
    else:
        given = LOADS[load]
    found = mtb.solve_normal(
        gap,
        SPACING,
        lower=BODIES[0],
        upper=BODIES[1],
        periodic=periodic,
        method=method,
        edge="sharp",
        tolerance=tolerance,
        **given,
    )
    assert int(found.status.sum()) >= 3
    own = measured(found, gap)
    # digits that are lost in gaps beside displacements
    rounding = 2e-13
    assert abs(own - found.report.residual) <= rounding + 1e-6 * own
    assert own <= (1e-5 if tolerance is None else tolerance) + rounding


def test_a_worse_pressure_has_a_larger_residual() -> None:
    gap = surface("rough", (64, 64))
    pair = {"lower": BODIES[0], "upper": BODIES[1], "method": "fft", "edge": "sharp"}
    residuals = [
        measured(mtb.solve_normal(gap, SPACING, force=0.6, tolerance=t, **pair), gap)  # type: ignore[arg-type]
        for t in (1e-2, 1e-4, 1e-6, 1e-8)
    ]
    assert all(a > 5.0 * b for a, b in itertools.pairwise(residuals))
