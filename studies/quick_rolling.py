# SPDX-License-Identifier: MIT OR Apache-2.0
"""KPEC and ANALYN on smooth gaps and on wheels, and strips across the rows of cells: docs/failures.md.

Usage: python studies/quick_rolling.py. Takes about ten seconds. The gaps are round along x; across
they have random cubic and quartic parts beside a parabola, up to half of it at the semi-axis. Pressures are
compared with those of the half-space at the same force. Round contacts are rolled along random directions
over square cells. On wheels, S1002 on 60E1 under 60 kN in 31 places, errors are those of the peak pressure
and of the pressure summed over the cells.
"""

import warnings

import numpy as np
from numpy.typing import NDArray

import mtb_rs as mtb

Array = NDArray[np.float64]

STEEL = {"lower": mtb.steel, "upper": mtb.steel}
CREEPAGES = ((1e-3, 0.0, 0.0), (0.0, 1e-3, 0.0), (5e-4, 5e-4, 0.1), (2e-3, 1e-3, 0.0))


def smooth_gap(rng: np.random.Generator) -> tuple[Array, tuple[float, float], float]:
    """A gap [m], its cells [m], and an approach [m] that closes most of it."""
    a, b = 5e-3 * 10 ** rng.uniform(-0.3, 0.3, 2)
    x, y = (np.linspace(-1.6, 1.6, 61) * side for side in (a, b))
    along = 1.0 / 0.92
    across = along * (a / b) ** 2
    t = (y / b)[:, None]
    odd, even = rng.uniform(0.0, 0.5) * rng.uniform((-1.0, 0.0), 1.0)
    gap = along * x**2 + across * b**2 * (t**2 + odd * t**3 + even * t**4)
    return gap - gap.min(), (x[1] - x[0], y[1] - y[0]), 0.7 * along * a**2


def of_smooth_gaps(count: int = 200) -> None:
    rng = np.random.default_rng(3)
    errors: dict[str, list[float]] = {"kpec": [], "analyn": []}
    for _ in range(count):
        gap, spacing, approach = smooth_gap(rng)
        full = mtb.solve_normal(gap, spacing, approach=approach, edge="sharp", **STEEL)
        force = float(full.pressure.sum()) * spacing[0] * spacing[1]
        for method, found in errors.items():
            try:
                quick = mtb.solve_normal(gap, spacing, force=force, method=method, **STEEL)
            except ValueError:
                continue
            found.append(float(np.abs(quick.pressure - full.pressure).sum() / full.pressure.sum()))
    for method, found in errors.items():
        low, middle, high = 100.0 * np.percentile(found, [0, 50, 100])
        print(f"{method}: {low:.1f} to {high:.1f} %, median {middle:.1f} %, of {len(found)} of {count} gaps")


def of_wheels() -> None:
    errors: dict[str, list[tuple[float, float]]] = {"kpec": [], "analyn": []}
    places = np.linspace(-6e-3, 9e-3, 31)
    for y in places:
        scene = mtb.scenes.wheel_on_rail(lateral=y, force=6e4, spacing=2.5e-4)
        full = scene.solve()
        given = full.initial_gap, (2.5e-4, 2.5e-4)
        pressure = mtb.solve_normal(*given, force=6e4, edge="sharp", **STEEL).pressure
        for method, found in errors.items():
            try:
                quick = mtb.solve_normal(*given, force=6e4, method=method, **STEEL).pressure
            except ValueError:
                continue
            peak = abs(float(quick.max() / pressure.max()) - 1.0)
            found.append((peak, float(np.abs(quick - pressure).sum() / pressure.sum())))
    for method, of_method in errors.items():
        for name, values in zip(("peak pressure", "pressure"), np.array(of_method).T, strict=True):
            low, middle, high = 100.0 * np.percentile(values, [10, 50, 90])
            print(
                f"{method} on wheels, {name}: {low:.0f}, {middle:.0f}, {high:.0f} % (10, 50, 90 % of "
                f"{len(values)} of {len(places)} places), at most {100.0 * values.max():.0f} %"
            )


def across_the_rows() -> None:
    rng = np.random.default_rng(4)
    for cells in (20, 40, 80):
        x = (np.arange(int(1.1 * cells)) + 0.5 - 0.5 * int(1.1 * cells)) * 2.0 / cells
        pressure = 1e9 * np.sqrt(np.maximum(1.0 - x**2 - x[:, None] ** 2, 0.0))
        field = mtb.PressureField(pressure, (10e-3 / cells,) * 2, mtb.steel, mtb.steel)
        errors = []
        for angle in rng.uniform(0.0, 0.25 * np.pi, 10):
            turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
            for xi, eta, phi in CREEPAGES:
                for method in (mtb.fastsim, mtb.fastrip):
                    straight = turn @ method(field, (xi, eta, phi), mtb.Coulomb(0.3)).force[:2]
                    creepage = (*(turn @ (xi, eta)), phi)
                    turned = method(field, creepage, mtb.Coulomb(0.3), angle=angle).force[:2]
                    errors.append(np.linalg.norm(turned - straight) / np.linalg.norm(straight))
        middle, worst = 100.0 * np.percentile(errors, [50, 100])
        print(f"round contact of {cells} cells: median {middle:.2f} %, at most {worst:.2f} %")


if __name__ == "__main__":
    warnings.simplefilter("ignore")
    of_smooth_gaps()
    of_wheels()
    across_the_rows()
