# SPDX-License-Identifier: MIT OR Apache-2.0
"""The thesis' paraboloid (Tables 3.1, 3.2): errors and times by grid, basis and method (CSV and PNG)."""

from __future__ import annotations

import argparse
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
import records

import mtb_rs as mtb
from mtb_rs import _mtb_rs
from mtb_rs.base.files import output_folder
from mtb_rs.half_space.reference import SlidingParaboloid
from mtb_rs.pictures.quantities import LINE_COLOURS

#: Points along each side and seconds, thesis Table 3.2.
THESIS = {6: 1.9, 10: 2.1, 18: 14.5, 34: 163.0}
EXACT = SlidingParaboloid(1000.0, 5e6, 0.5, mtb.steel, mtb.steel)
MATERIAL = (mtb.steel.shear_modulus, mtb.steel.poisson_ratio)
#: Largest grid of each pair of basis and method; the dense ones end where a matrix outgrows a minute.
SERIES = {
    ("rectangles", "direct, FFT"): 130,
    ("rectangles", "direct"): 34,
    ("rectangles", "incremental"): 66,
    ("bilinear hats", "direct"): 34,
    ("Gaussians, 0.25 h", "direct"): 34,
    ("Gaussians, 0.35 h", "direct"): 34,
    ("Gaussians, 0.35 h", "incremental"): 34,
    ("Gaussians, 0.5 h", "direct"): 34,
}
QUANTITIES = ("pressure", "traction_x", "radius", "approach", "u_z", "u_x")


@dataclass(frozen=True)
class Grid:
    """Nodes over one metre, thesis Table 3.2."""

    points: int

    @property
    def h(self) -> float:
        return 1.0 / (self.points - 1)

    @property
    def xy(self) -> tuple[np.ndarray, np.ndarray]:
        line = (np.arange(self.points) - 0.5 * (self.points - 1)) * self.h
        x, y = np.meshgrid(line, line)
        return x.ravel(), y.ravel()

    @property
    def gap(self) -> np.ndarray:
        x, y = self.xy
        return (x**2 + y**2) / (2.0 * EXACT.radius)


def body_of(grid: Grid, basis: str) -> tuple[Any, np.ndarray]:
    """The half-space of both bodies and the weight of each point [m2]."""
    n, h = grid.points, grid.h
    x, y = grid.xy
    if basis == "rectangles":
        return _mtb_rs.half_space(MATERIAL, [(x[0], y[0], n, n)], (h, h), True), np.full(n * n, h * h)
    if basis == "bilinear hats":
        return _mtb_rs.half_space_hats(*MATERIAL, [(x[0], y[0], n, n)], (h, h), True)
    edge = 0.5 + 0.5 * h
    share = float(basis.split()[1])
    (body,), weights = _mtb_rs.half_space_gaussians([MATERIAL], x, y, share * h, (-edge, edge, -edge, edge))
    return body, weights


def solve(grid: Grid, basis: str, method: str) -> dict[str, Any]:
    """Pressure, displacement of the plane, approach, counts and seconds."""
    x, y = grid.xy
    n = x.size
    if method == "direct, FFT":
        body, weights = body_of(grid, basis)
        clock = time.perf_counter()
        shape = (grid.points, grid.points)
        result = mtb.solve_normal(
            grid.gap.reshape(shape),
            grid.h,
            lower=mtb.steel,
            upper=mtb.steel,
            force=EXACT.force,
            method="fft",
            tolerance=1e-8,
        )
        out = {"pressure": result.pressure.ravel(), "approach": result.approach}
        counts = f"{result.report.iterations} iterations"
        set_up = 0.0
    else:
        clock = time.perf_counter()
        body, weights = body_of(grid, basis)
        # the matrix itself is made on first use
        body.influence("n", "n")
        set_up = time.perf_counter() - clock
        clock = time.perf_counter()
        if method == "direct":
            direction = np.stack([np.ones(n), np.zeros(n)])
            level = _mtb_rs.ContactGeometry(np.stack([x, y, np.zeros(n)]), weights)
            up = np.stack([np.zeros(n), np.zeros(n), np.ones(n)])[None]
            friction = np.full(n, EXACT.friction)
            # under hats all quantities are means weighted with the hat of the node, the gap too
            gap = grid.gap + (grid.h**2 / (6.0 * EXACT.radius) if basis == "bilinear hats" else 0.0)
            problem = _mtb_rs.Problem(body, body, level, up, [True])
            found = problem.slide(problem.loading(gap, np.array([-EXACT.force])), direction, friction)
            status = found.status
            out = {"pressure": found.pressure, "approach": -float(found.motion[0])}
            counts = f"{found.iterations} active sets"
        else:
            options = _mtb_rs.IncrementalOptions(
                estimated_steps=20, force_tolerance=1e3, distance_tolerance=1e-5
            )
            stepped = _mtb_rs.solve_incremental(
                body,
                body,
                np.stack([x, y, np.zeros(n)]),
                np.stack([x, y, grid.gap]),
                [(grid.points, grid.points)],
                weights,
                np.full(n, EXACT.friction),
                (1.0, 0.0, 0.0),
                EXACT.force,
                options,
            )
            status = stepped.status
            names = ("pressure", "traction", "approach")
            out = {name: getattr(stepped, name) for name in names}
            out["displacement"] = stepped.lower_displacement
            counts = f"{stepped.increments} increments, {stepped.active_sets} active sets"
        if status != "solved":
            raise SystemExit(f"{grid} {basis} {method}: {status}")
    if "displacement" not in out:
        pressure = out["pressure"]
        if basis == "bilinear hats":
            out["pressure"] = cell_means(pressure.reshape(grid.points, grid.points)).ravel()
        u = body.displacement(np.stack([EXACT.friction * pressure, 0.0 * pressure, pressure]))
        out["displacement"] = np.stack([u[0], u[1], -u[2]])
    seconds = time.perf_counter() - clock
    return {**out, "weights": weights, "counts": counts, "set_up_s": set_up, "solve_s": seconds}


def cell_means(nodal: np.ndarray) -> np.ndarray:
    """Means over the cells about the nodes of what is bilinear between them: the values themselves swing."""
    for _ in range(2):
        padded = np.pad(nodal, ((1, 1), (0, 0)))
        nodal = (0.125 * (padded[:-2] + padded[2:]) + 0.75 * padded[1:-1]).T
    return nodal


def hat_means(field: np.ndarray, points: int) -> np.ndarray:
    """Means of a smooth field weighted with the hats of the nodes, to second order."""
    square = field.reshape(points, points)
    for _ in range(2):
        padded = np.pad(square, ((1, 1), (0, 0)), mode="reflect", reflect_type="odd")
        square = ((padded[:-2] + padded[2:] + 10.0 * square) / 12.0).T
    return square.ravel()


def errors(grid: Grid, basis: str, out: dict[str, Any]) -> dict[str, float]:
    """Relative: L2 over inner points of pressure, q_x, u_z, u_x; radius by second moment; approach."""
    x, y = grid.xy
    exact = EXACT.pressure(x, y)
    u = EXACT.displacement(x, y)
    if basis == "bilinear hats":
        u = np.stack([hat_means(component, grid.points) for component in u])
    pressure, weights = out["pressure"], out["weights"]
    traction = out["traction"][0] if "traction" in out else EXACT.friction * pressure
    second = (weights * pressure * (x**2 + y**2)).sum() / (weights * pressure).sum()

    # hats at the border are halves, whose means lie elsewhere
    inside = np.maximum(np.abs(x), np.abs(y)) < 0.5 - 0.5 * grid.h

    def norm(values: np.ndarray, reference: np.ndarray) -> float:
        return float(np.linalg.norm((values - reference)[inside]) / np.linalg.norm(reference[inside]))

    return {
        "pressure": norm(pressure, exact),
        "traction_x": norm(traction, EXACT.friction * exact),
        "radius": abs(float(np.sqrt(2.5 * second)) / EXACT.contact_radius - 1.0),
        "approach": abs(out["approach"] / EXACT.approach - 1.0),
        "u_z": norm(out["displacement"][2], u[2]),
        "u_x": norm(out["displacement"][0], u[0]),
    }


def run(grids: list[int]) -> list[dict[str, Any]]:
    """Every series on every grid."""
    rows: list[dict[str, Any]] = []
    for (basis, method), largest in SERIES.items():
        before: tuple[int, dict[str, float]] | None = None
        for points in grids:
            if points > largest:
                continue
            grid = Grid(points)
            clock, processor = time.perf_counter(), time.process_time()
            out = solve(grid, basis, method)
            wall, used = time.perf_counter() - clock, time.process_time() - processor
            found = errors(grid, basis, out)
            row: dict[str, Any] = {"basis": basis, "method": method, "points_a_side": points}
            for name in QUANTITIES:
                row[f"{name}_percent"] = f"{100.0 * found[name]:.4f}"
            for name in ("pressure", "u_z", "u_x"):
                ratio = before[1][name] / found[name] if before else 1.0
                rate = np.log(ratio) / np.log((points - 1) / (before[0] - 1)) if before else np.nan
                row[f"{name}_rate"] = "" if before is None else f"{rate:.2f}"
            square = out["pressure"].reshape(points, points)
            row["asymmetry"] = f"{np.abs(square - square[:, ::-1]).max() / square.max():.1e}"
            row |= {"counts": out["counts"], "coefficients_s": f"{out['set_up_s']:.4f}"}
            row |= {"solve_s": f"{out['solve_s']:.4f}", "wall_s": f"{wall:.4f}", "cpu_s": f"{used:.4f}"}
            row["thesis_s"] = THESIS.get(points, "")
            rows.append(row)
            before = points, found
            print(*row.values(), sep="  ")
    return rows


def draw(rows: list[dict[str, str]], path: Path) -> None:
    """Error over time, which is what counts, and error over the points."""
    figure, axes = plt.subplots(2, 2, figsize=(7.4, 7.6))
    time, points = ("cpu_s", "processor time [s]"), ("points_a_side", "points along each side")
    pressure, u_z = ("pressure_percent", "pressure"), ("u_z_percent", "vertical displacement")
    bases = list(dict.fromkeys(basis for basis, _ in SERIES))
    styles = {"direct": ("o", "-"), "direct, FFT": ("s", "--"), "incremental": ("^", ":")}
    for ax, ((y, name), (x, label)) in zip(
        axes.flat, [(pressure, points), (pressure, time), (u_z, points), (u_z, time)], strict=True
    ):
        for basis, method in SERIES:
            own = [row for row in rows if (row["basis"], row["method"]) == (basis, method)]
            marker, line = styles[method]
            ax.loglog(
                [float(row[x]) for row in own],
                [float(row[y]) for row in own],
                marker=marker,
                linestyle=line,
                color=LINE_COLOURS[bases.index(basis)],
                label=f"{basis}, {method}",
            )
        ax.set(title=f"error of the {name} [%]", xlabel=label)
        if x == "points_a_side":
            ax.set_xticks([6, 10, 18, 34, 66, 130], ["6", "10", "18", "34", "66", "130"])
        ax.minorticks_off()
    figure.legend(*axes[0, 0].get_legend_handles_labels(), loc="outside lower center", ncols=3)
    figure.savefig(path)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("-o", "--output", type=output_folder, default="docs/charts")
    parser.add_argument("--grids", type=int, nargs="+", default=[6, 10, 18, 34, 66, 130])
    parser.add_argument("--draw", action="store_true", help="only draw the table again that is there")
    arguments = parser.parse_args()
    table = arguments.output / "paraboloid.csv"
    if not arguments.draw:
        records.write(table, run(arguments.grids))
    draw(records.read(table), table.with_suffix(".png"))


if __name__ == "__main__":
    main()
