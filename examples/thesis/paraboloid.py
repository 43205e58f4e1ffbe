# SPDX-License-Identifier: MIT OR Apache-2.0
"""A paraboloid sliding on a plane against its closed form, on the thesis' grids: thesis 3.1.1, Table 3.2."""

from __future__ import annotations

import time
import warnings
from pathlib import Path

import numpy as np
from comparison import write_table
from drawing import MEGA, MICRO, canvas, caption, legend, output, save
from numpy.typing import NDArray

import mtb_rs as mtb
from mtb_rs.half_space.reference import SlidingParaboloid
from mtb_rs.pictures.quantities import INK, LINE_COLOURS

Array = NDArray[np.float64]
#: Points along each side; thesis Table 3.2 with its times [s].
THESIS_SECONDS = {6: 1.9, 10: 2.1, 18: 14.5, 34: 163.0}
FINER = (66, 130)
RADIUS, FORCE, FRICTION = 1000.0, 5e6, 0.5
EXACT = SlidingParaboloid(RADIUS, FORCE, FRICTION, mtb.steel, mtb.steel)


def solve(points: int, method: str) -> tuple[mtb.Result, float]:
    scene = mtb.scenes.paraboloid_on_plane(RADIUS, FORCE, FRICTION, points)
    clock = time.perf_counter()
    with warnings.catch_warnings():
        # grids as coarse as the thesis'
        warnings.simplefilter("ignore", mtb.ToleranceWarning)
        result = scene.solve(model="half-space", method=method)
    return result, time.perf_counter() - clock


def errors(result: mtb.Result) -> list[float]:
    """Relative: L2 of pressure, approach, L2 of u_z and of u_x, largest left-right asymmetry of pressure."""
    x, y = result.points[:2]
    u = EXACT.displacement(x, y)
    pairs = [
        (result.pressure, EXACT.pressure(x, y)),
        (result.displacement.lower[2], u[2]),
        (result.displacement.lower[0], u[0]),
    ]
    p, u_z, u_x = (float(np.linalg.norm(a - b) / np.linalg.norm(b)) for a, b in pairs)
    skew = float(np.abs(result.pressure - result.pressure[:, ::-1]).max() / result.pressure.max())
    return [p, abs(float(result.approach) / EXACT.approach - 1.0), u_z, u_x, skew]


def main() -> None:
    folder = output(__doc__)
    solved: dict[tuple[int, str], mtb.Result] = {}
    rows = []
    for method, counts in (
        ("direct", (*THESIS_SECONDS, *FINER[:1])),
        ("incremental", tuple(THESIS_SECONDS)),
    ):
        before: tuple[int, float] | None = None
        for points in counts:
            result, seconds = solve(points, method)
            solved[points, method] = result
            e = errors(result)
            rate = ""
            if before is not None:
                rate = f"{np.log(before[1] / e[0]) / np.log((points - 1) / (before[0] - 1)):.2f}"
            before = points, e[0]
            percent = [f"{100 * v:.3f}" for v in e[:4]]
            rows.append([method, points, *percent, rate, f"{e[4]:.1e}", f"{seconds:.3f}"])
            rows[-1].append(THESIS_SECONDS.get(points, ""))
            print(*rows[-1])
    header = ["method", "points_a_side", "pressure_L2_percent", "approach_percent", "u_z_L2_percent"]
    header += ["u_x_L2_percent", "pressure_rate", "asymmetry", "seconds", "thesis_seconds"]
    write_table(folder / "table_3_2.csv", header, rows)
    for name, quantities in (("fig_3_2", ("pressure", "u_z")), ("fig_3_3", ("traction", "u_x"))):
        lines(folder, name, quantities, solved)
    deformed(folder, solved[34, "direct"])


def row(result: mtb.Result, quantity: str) -> tuple[Array, Array]:
    """A quantity over x at y = 0, the mean of the two rows beside it."""
    n = result.pressure.shape[0]
    values = {
        "pressure": result.pressure,
        "traction": result.traction[0],
        "u_z": result.displacement.lower[2],
        "u_x": result.displacement.lower[0],
    }[quantity]
    return result.points[0, 0], 0.5 * (values[n // 2 - 1] + values[n // 2])


def exact(quantity: str, x: Array, y: Array) -> Array:
    if quantity in ("pressure", "traction"):
        return EXACT.pressure(x, y) * (1.0 if quantity == "pressure" else FRICTION)
    return EXACT.displacement(x, y)[2 if quantity == "u_z" else 0]


LABELS = {
    "pressure": ("pressure [MPa]", MEGA),
    "traction": ("longitudinal traction [MPa]", MEGA),
    "u_z": ("vertical displacement [µm]", MICRO),
    "u_x": ("longitudinal displacement [µm]", MICRO),
}


def lines(
    folder: Path, name: str, quantities: tuple[str, ...], solved: dict[tuple[int, str], mtb.Result]
) -> None:
    """Thesis Figs 3.2 and 3.3: the plane along the sliding direction, and below it the differences."""
    figure, axes = canvas(2, 2, (7.6, 5.6), sharex=True, height_ratios=(2, 1))
    x = np.linspace(-0.5, 0.5, 801)
    for (ax, below), quantity in zip(axes.T, quantities, strict=True):
        label, unit = LABELS[quantity]
        ax.plot(x, exact(quantity, x, 0.0 * x) / unit, color="black", linewidth=1.2, label="closed form")
        for points, colour in zip(THESIS_SECONDS, LINE_COLOURS, strict=False):
            result = solved[points, "direct"]
            at, values = row(result, quantity)
            middle = abs(float(result.points[1, points // 2, 0]))
            ax.plot(
                at, values / unit, "o-", color=colour, ms=2.5, lw=0.9, label=f"{points} x {points}, direct"
            )
            off = values - exact(quantity, at, middle + 0.0 * at)
            below.plot(at, off / unit, "o-", color=colour, ms=2, lw=0.9)
        at, values = row(solved[34, "incremental"], quantity)
        middle = abs(float(solved[34, "incremental"].points[1, 17, 0]))
        off = values - exact(quantity, at, middle + 0.0 * at)
        below.plot(at, off / unit, color=INK, lw=1.2, ls=":", label="34 x 34, incremental")
        caption(ax, f"{label.split(' [')[0]} of the plane at y = 0", y=label)
        caption(below, "solution minus closed form on the same row", "x [m]", label.split(" ")[-1])
    handles, labels = axes[0, 0].get_legend_handles_labels()
    more = axes[1, 0].get_legend_handles_labels()
    figure.legend(
        handles + more[0], labels + more[1], loc="outside lower center", ncols=3, frameon=False, fontsize=8.5
    )
    save(figure, folder, name)


def deformed(folder: Path, result: mtb.Result) -> None:
    """Thesis Fig. 3.4: a cut through both bodies before and after contact, then with u_x 2500 times."""
    x, u_x = row(result, "u_x")
    _, u_z = row(result, "u_z")
    n = x.size
    up = result.displacement.upper
    upper_x, upper_z = (0.5 * (up[c, n // 2 - 1] + up[c, n // 2]) for c in (0, 2))
    height = x**2 / (2.0 * RADIUS)
    approach = float(result.approach)
    figure, axes = canvas(3, 1, (7.2, 6.4), sharex=True)
    states = (
        ("before contact", 0.0, 0.0, 0.0),
        (f"after contact: the bodies moved {approach / MICRO:.1f} µm together", 1.0, 1.0, approach),
        ("the same, longitudinal displacements 2500 times", 1.0, 2500.0, approach),
    )
    for ax, (title, vertical, along, moved) in zip(axes, states, strict=True):
        lower = x + along * u_x, vertical * u_z / MICRO
        upper = x + along * upper_x, (height - moved + vertical * upper_z) / MICRO
        ax.fill_between(*lower, -160.0, color=LINE_COLOURS[0], alpha=0.25, lw=0)
        ax.fill_between(*upper, 160.0, color=LINE_COLOURS[1], alpha=0.25, lw=0)
        ax.plot(*lower, ".-", color=LINE_COLOURS[0], lw=1.2, ms=4, label="plane")
        ax.plot(*upper, ".-", color=LINE_COLOURS[1], lw=1.2, ms=4, label="paraboloid")
        ax.set_ylim(-95.0, 135.0)
        caption(ax, title, y="z [µm]", grid=False)
    axes[-1].set_xlabel("x [m]; the paraboloid slides to the right", fontsize=9, color=INK)
    legend(axes[0], loc="lower right", ncols=2)
    save(figure, folder, "fig_3_4")


if __name__ == "__main__":
    main()
