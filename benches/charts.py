# SPDX-License-Identifier: MIT OR Apache-2.0
"""Charts of speed against accuracy of the six standing scenes, with the sources' own figures.

Run from the root of the project: ``python benches/charts.py [name ...] [--budget 120]``. Writes PNG, HTML
and CSV into docs/charts, and how all charts there grow into growth.csv; ``--growth`` writes that alone.
Times of the thesis were taken on an Intel Xeon E5-1620 v3 at 3.5 GHz with 32 GB, those of the paper on
hardware it does not state, those of CONTACT and CalculiX as processor seconds on a 2.5 GHz core.
"""

from __future__ import annotations

import argparse
import csv
import sys
import time
from collections.abc import Callable
from dataclasses import replace
from functools import cache
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
import records

import mtb_rs as mtb
from mtb_rs.base.files import output_folder
from mtb_rs.results.chart import Chart, ChartPoint, Figure
from mtb_rs.studies.chart_scene import closed_form, fields_of
from mtb_rs.studies.measuring import Candidate, Run, measure

steel = mtb.Material.from_shear_modulus(80e9, 0.3)
Spacing = tuple[float, float]


def report(share: float, doing: str) -> None:
    """Progress on one line."""
    sys.stderr.write(f"\r{100 * share:3.0f} %  {doing:60.60s}")


def paraboloid(budget: float) -> Chart:
    """Thesis 3.1.1; Table 3.2's times stand at the errors of our run of the thesis' scheme on its grids."""
    chart = mtb.scenes.paraboloid_on_plane(radius=1000.0, force=5e6, points=34).chart(
        budget=budget, progress=report
    )
    figures = []
    for points, seconds in ((6, 1.9), (10, 2.1), (18, 14.5), (34, 163.0)):
        scene = mtb.scenes.paraboloid_on_plane(points=points)
        exact = closed_form(scene)
        assert exact is not None
        spacing = (1.0 / (points - 1),) * 2
        result = scene.solve("half-space", method="incremental")
        error = fields_of(scene, result, spacing).errors(exact, skip_border=False)["pressure"]
        figures.append(Figure(f"thesis, {points}x{points} (error: our re-run)", seconds, error))
    return replace(chart, figures=tuple(figures))


def block(budget: float) -> Chart:
    """Thesis 3.2.1, at a height where sliding equilibrium exists."""
    chart = mtb.scenes.block_on_plane().chart(budget=budget, progress=report)
    return replace(chart, figures=(Figure("CalculiX, C3D8I 5 mm", 209.1),))


def pole_shoe(budget: float) -> Chart:
    """Thesis 3.1.2 and 3.2.2; its errors are means relative to its own FE benchmark."""
    chart = mtb.scenes.pole_shoe_on_rail().chart(budget=budget, progress=report)
    figures = (
        Figure("thesis basic, 3 mm (its error)", 252.0, 0.4589),
        Figure("thesis extended (its error)", 1200.0, 0.1673),
        Figure("thesis C.1: 6 mm", 20.0),
        Figure("thesis C.1: 1.5 mm", 11632.0),
        Figure("thesis 4.1, C.2: extended", 494.0),
        Figure("thesis: full FE", 16800.0),
        Figure("CalculiX", 47.4),
    )
    return replace(chart, figures=figures)


def wheel(budget: float) -> Chart:
    """Paper Table 1, force prescribed; another worn profile there, so times only."""
    chart = mtb.scenes.wheel_on_rail().chart(budget=budget, progress=report)
    figures = [
        Figure(f"paper v{version}, {spacing} mm", seconds)
        for spacing, old, new in ((0.1, 12.8, 0.6), (0.05, 245.0, 3.9), (0.025, 5104.0, 35.5))
        for version, seconds in (("11.1", old), ("12.1", new))
    ]
    # the same equations as ours: their error is that of ours at the spacing
    own = {
        round(p.spacing, 7): p.errors.get("pressure")
        for p in chart.points
        if "FFT" in p.series and not p.is_reference
    }
    for spacing, seconds in ((1e-4, 0.0464), (5e-5, 0.26), (2.5e-5, 1.1545)):
        error = own.get(spacing)
        figures.append(Figure(f"CONTACT, {1e3 * spacing:g} mm (our re-run)", seconds, error or None))
    return replace(chart, figures=tuple(figures))


def rolling(budget: float) -> Chart:
    """Steady rolling with spin on a circle: FASTSIM, Polach and the table against the full solution."""
    body = mtb.Material.from_shear_modulus(82e9, 0.28)
    radius, load, law = 3.205e-3, 1e4, mtb.Coulomb(0.3)
    creepage = (4e-4, 3e-4, 0.2)

    ball = mtb.hertz(load, lower=body, upper=body, semi_axes=(radius, radius))

    @cache
    def patch(n: int) -> mtb.NormalResult:
        cell = 2.0 * radius / n
        x = (np.arange(n + 4) - 0.5 * (n + 3)) * cell
        gap = 0.5 * ball.curvatures[0] * np.add.outer(x**2, x**2)
        return mtb.solve_normal(gap, cell, lower=body, upper=body, force=load)

    # extrapolated from two fine grids
    forces = [mtb.creep_curve(patch(n), [creepage], law, tolerance=1e-8, order=2)[0, :2] for n in (160, 240)]
    exact = forces[1] + (forces[1] - forces[0]) * 160**2 / (240**2 - 160**2)
    own = float(np.linalg.norm(forces[1] - exact) / np.linalg.norm(exact))

    def judged(found: np.ndarray, unknowns: int, iterations: int = 0, products: float = 0.0) -> Run:
        error = float(np.linalg.norm(np.asarray(found)[:2] - exact) / np.linalg.norm(exact))
        return Run(unknowns, {"force": error}, iterations, products)

    def full(order: int) -> Callable[[Spacing], Callable[[], Run]]:
        def solve(spacing: Spacing) -> Callable[[], Run]:
            n = round(2 * radius / spacing[0])
            found = mtb.solve_tangential(patch(n), mtb.Rolling(creepage, order=order), law, tolerance=1e-6)
            counts = found.report
            return lambda: judged(found.force, n * n, counts.iterations, counts.convolutions)

        return solve

    def simplified(**options: object) -> Callable[[Spacing], Callable[[], Run]]:
        def solve(spacing: Spacing) -> Callable[[], Run]:
            n = round(2 * radius / spacing[0])
            found = mtb.fastsim(patch(n), creepage, law, **options)  # type: ignore[arg-type]
            return lambda: judged(found.force, n * n)

        return solve

    sides = (8, 12, 16, 24, 32, 48, 64, 96, 128)
    for n in sides:
        patch(n)
    fine = patch(200)
    table = mtb.CreepForceTable.build(ratios=(1.0,), poisson_ratio=0.28, nodes=11, cells=20)

    def closed(spacing: Spacing) -> Callable[[], Run]:
        found = mtb.polach(fine, creepage, law, semi_axes=(radius, radius))
        return lambda: judged(found, 1)

    def tabulated(spacing: Spacing) -> Callable[[], Run]:
        rows = np.array([creepage])
        found = table.interpolate((radius, radius), load, 82e9, 0.3, rows)[0]
        return lambda: judged(found, 1)

    spacings = [(2 * radius / n,) * 2 for n in sides]
    one = spacings[:1]
    candidates = [
        Candidate("full solution", full(1), full(1)),
        Candidate("full solution, second order", full(2), full(2)),
        Candidate("FASTSIM, parabolic", simplified()),
        Candidate("FASTSIM, elliptic", simplified(bound="elliptic")),
        Candidate("FASTSIM, second order", simplified(order=2)),
        Candidate("Polach", closed, spacings=one),
        Candidate("table, once built", tabulated, spacings=one),
    ]
    points = measure(candidates, spacings, budget=budget, repeats=5, progress=report)
    figures = tuple(
        Figure(f"CONTACT SteadyGS, {n}x{n}", seconds)
        for n, seconds in ((25, 0.04095), (50, 0.92949), (100, 24.70807))
    )
    words = "second order, extrapolated from 160 and 240 cells"
    return Chart("steady rolling with spin", points, words, own, "force", figures)


def rough(budget: float) -> Chart:
    """A rough plane, its shortest wave 1/24 of the side, pressed to a few per cent of contact; periodic."""
    side, finest = 1e-3, 768
    step = side / finest
    heights = mtb.roughness(finest, step, rms_slope=0.05, longest=side / 2, shortest=side / 24, seed=3)
    gap = heights.max() - heights
    force = 0.02 * side**2 * 0.05 * reference_modulus()

    def solved(spacing: Spacing, **options: object) -> mtb.NormalResult:
        every = round(spacing[0] / step)
        given = np.ascontiguousarray(gap[::every, ::every])
        return mtb.solve_normal(
            given,
            every * step,
            lower=steel,
            upper=mtb.Rigid(),
            force=force,
            periodic=True,
            **options,  # type: ignore[arg-type]
        )

    clock, used = time.perf_counter(), time.process_time()
    best = solved((step, step), tolerance=1e-8)
    used, elapsed = time.process_time() - used, time.perf_counter() - clock

    def error(result: mtb.NormalResult) -> float:
        # at the places both know: a given field is sampled, not averaged
        every = round(result.spacing[0] / step)
        apart = result.pressure - best.pressure[::every, ::every]
        return float(np.linalg.norm(apart) / np.linalg.norm(best.pressure[::every, ::every]))

    def by(**options: object) -> Callable[[Spacing], Callable[[], Run]]:
        def solve(spacing: Spacing) -> Callable[[], Run]:
            result = solved(spacing, **options)
            counts = result.report
            return lambda: Run(
                result.pressure.size,
                {"pressure": error(result)},
                counts.iterations,
                counts.convolutions,
                counts.solver,
            )

        return solve

    spacings = [(side / n,) * 2 for n in (24, 32, 48, 64, 96, 128, 192, 256, 384)]
    candidates = [
        Candidate("FFT", by(method="fft")),
        Candidate("FFT, residual 1e-8", by(method="fft", tolerance=1e-8)),
        Candidate("dense", by(method="dense"), spacings=spacings[:4]),
    ]
    points = measure(candidates, spacings, budget=budget, repeats=5, progress=report)
    # first order from the two finest of the converged series
    converged = [p for p in points if p.series == "FFT, residual 1e-8"]
    own = converged[-1].errors["pressure"] * step / max(converged[-1].spacing - step, step)
    words = f"FFT, {finest} x {finest} points, residual 1e-8"
    mark = ChartPoint("FFT, residual 1e-8", step, best.pressure.size, (used,), (elapsed,), is_reference=True)
    return Chart("rough surface", (*points, mark), words, own)


def reference_modulus() -> float:
    """E* of steel on a rigid plane [Pa]."""
    return steel.plane_strain_modulus


CHARTS = {
    "paraboloid": paraboloid,
    "block": block,
    "pole_shoe": pole_shoe,
    "wheel": wheel,
    "rolling": rolling,
    "rough": rough,
}


def read(path: Path) -> Chart:
    """A chart as its CSV keeps it, for :meth:`Chart.growth`: without errors and sources' figures."""
    with path.open(encoding="utf-8", newline="") as file:
        rows = [row for row in csv.DictReader(file) if row["unknowns"]]
    points = [
        ChartPoint(
            row["series"],
            float(row["spacing_m"]),
            int(row["unknowns"]),
            (float(row["processor_s"]),),
            (float(row["clock_s"]),),
            is_reference=row["note"] == "reference",
        )
        for row in rows
    ]
    return Chart(path.stem.removeprefix("scene_").replace("_", " "), tuple(points), "")


def write_growth(folder: Path) -> None:
    """Exponents of the time over the unknowns, of all charts in a folder."""
    charts = [read(path) for path in sorted(folder.glob("scene_*.csv"))]
    with (folder / "growth.csv").open("w", encoding="utf-8", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(["scene", "series", "finest_unknowns", "exponent"])
        for chart in charts:
            for series in chart.series:
                exponent = None if series.startswith("auto") else chart.growth(series)
                if exponent is not None:
                    finest = max(
                        p.unknowns for p in chart.points if p.series == series and not p.is_reference
                    )
                    writer.writerow([chart.title, series, finest, f"{exponent:.2f}"])


def draw_for_readme(folder: Path) -> None:
    """The pole shoe's chart with the least one has to know: three models, and the thesis."""
    rows = records.read(folder / "scene_pole_shoe.csv")
    names = {
        "half-space, direct": "shoe and rail as half-spaces",
        "elastic-upper, direct": "shoe of finite elements",
        "elastic-both, direct": "shoe and rail of finite elements",
    }
    figure, axes = plt.subplots(figsize=(7.4, 4.0))
    for (series, name), marker in zip(names.items(), "osD", strict=True):
        own = [row for row in rows if row["series"] == series and row["note"] != "reference"]
        places = [(float(row["processor_s"]), 100.0 * float(row["pressure_error"])) for row in own]
        axes.loglog(*zip(*sorted(places), strict=True), marker + "-", ms=7, label=name)
    thesis = [row for row in rows if row["series"].startswith("thesis") and row["pressure_error"]]
    axes.loglog(
        [float(row["clock_s"]) for row in thesis],
        [100.0 * float(row["pressure_error"]) for row in thesis],
        "*",
        ms=13,
        color="black",
        label="diploma thesis, its own models",
    )
    axes.set(xlabel="computing time of the first solve [s]", title="error of the pressure [%]")
    axes.set_xticks([0.01, 0.1, 1, 10, 100, 1000], ["0.01", "0.1", "1", "10", "100", "1000"])
    axes.set_yticks([2, 5, 10, 20, 50], ["2", "5", "10", "20", "50"])
    axes.minorticks_off()
    figure.legend(loc="outside lower center", ncols=2)
    figure.savefig(folder / "readme.png")


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument(
        "names", nargs="*", default=list(CHARTS), help=f"of {', '.join(CHARTS)}; all by default"
    )
    parser.add_argument("-o", "--output", type=output_folder, default="docs/charts")
    parser.add_argument("--budget", type=float, default=120.0, help="seconds for each chart")
    parser.add_argument(
        "--growth",
        action="store_true",
        help="measure nothing, only write what follows from the tables",
    )
    arguments = parser.parse_args()
    for chosen in [] if arguments.growth else arguments.names:
        chart = CHARTS[chosen](arguments.budget)
        chart.save(arguments.output, f"scene_{chosen}")
        sys.stderr.write("\n")
        print(f"{chosen}: against {chart.reference}, own error {chart.reference_error}")
        for series in chart.series:
            print(f"  {series}: growth {chart.growth(series)}")
    write_growth(arguments.output)
    draw_for_readme(arguments.output)
