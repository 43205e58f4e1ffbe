# SPDX-License-Identifier: MIT OR Apache-2.0
"""The same normal contacts by mtb_rs, tamaas and ContactMechanics: time against error.

    pip install 'mtb-rs[bench]'
    python benches/normal_peers.py [--points 512] [--repeats 3] [--out docs/charts]

One thread each, CPU seconds, force prescribed. The error is measured the same way for all: from the
pressure a solver returns, its displacement by one and the same convolution, and with it the relative
complementarity residual, sqrt(sum of squared gaps in contact and penetrations outside / sum of squared
displacements in contact), the approach being the mean over the contact. Each solver runs through a
range of its own tolerances; what counts is the first run whose measured error is below 1e-8.
"""

from __future__ import annotations

import argparse
import os
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

for _name in ("OMP_NUM_THREADS", "RAYON_NUM_THREADS", "OPENBLAS_NUM_THREADS"):
    os.environ[_name] = "1"

import matplotlib.pyplot as plt
import numpy as np
import records
from numpy.typing import NDArray

import mtb_rs as mtb
from mtb_rs import _mtb_rs
from mtb_rs.base.files import output_folder

Array = NDArray[np.float64]

#: E / (1 - nu^2) = 1 against a rigid plane, on the unit square
ELASTIC, RIGID = mtb.Material(1.0, 0.0), mtb.Rigid()
GOAL = 1e-8


@dataclass(frozen=True)
class Case:
    """A contact on the unit square: its gap, mean pressure and surroundings."""

    name: str
    gap: Array
    mean_pressure: float
    periodic: bool


def cases(n: int) -> list[Case]:
    """Smooth ones in free space, and a rough periodic surface at about 2 % and 20 % contact."""
    x = (np.arange(n) + 0.5) / n - 0.5
    r2 = x[None, :] ** 2 + x[:, None] ** 2
    waves = np.cos(6.0 * np.pi * x)[None, :] * np.cos(6.0 * np.pi * x)[:, None]
    rough = mtb.roughness(n, 1.0 / n, rms_slope=0.1, hurst=0.8, roll_off=0.25, shortest=8.0 / n, seed=1)
    rough = rough.max() - rough
    # Hertz with a contact radius of 0.375: F = 4 E* a^3 / (3 R), R = 1
    return [
        Case("Hertz, free", 0.5 * r2, 4.0 / 3.0 * 0.375**3, False),
        Case("bowl with waves, free", 0.5 * r2 + 2e-3 * (1.0 - waves), 0.05, False),
        Case("rough, periodic, 2 %", rough, 0.0009, True),
        Case("rough, periodic, 20 %", rough, 0.0105, True),
    ]


def residual(case: Case, pressure: Array) -> float:
    """Relative complementarity residual of a pressure, whoever found it."""
    n = len(case.gap)
    if case.periodic:
        k = 2.0 * np.pi * np.hypot(np.fft.fftfreq(n, 1.0 / n)[:, None], np.fft.rfftfreq(n, 1.0 / n)[None, :])
        k[0, 0] = np.inf
        u = np.fft.irfft2(np.fft.rfft2(pressure) * 2.0 / k, s=(n, n))
    else:
        body = _mtb_rs.half_space((ELASTIC.shear_modulus, 0.0), [(0.0, 0.0, n, n)], (1.0 / n, 1.0 / n), True)
        traction = np.zeros((3, n * n))
        traction[2] = pressure.ravel()
        u = body.displacement(traction)[2].reshape(n, n)
    loaded = pressure > 0.0
    gap = case.gap + u
    gap = gap - gap[loaded].mean()
    wrong = (gap[loaded] ** 2).sum() + (np.minimum(gap[~loaded], 0.0) ** 2).sum()
    return float(np.sqrt(wrong / (u[loaded] ** 2).sum()))


Solver = Callable[[Case, float], tuple[float, Array]]


def ours(case: Case, tolerance: float) -> tuple[float, Array]:
    """mtb_rs: everything, from the height field to the result."""
    n = len(case.gap)
    start = time.process_time()
    found = mtb.solve_normal(
        case.gap,
        1.0 / n,
        lower=ELASTIC,
        upper=RIGID,
        force=case.mean_pressure,
        tolerance=tolerance,
        periodic=case.periodic,
    )
    return time.process_time() - start, found.pressure


def tamaas(case: Case, tolerance: float) -> tuple[float, Array]:
    """tamaas: model and operator are made beforehand, only the solve is timed."""
    import tamaas as tm

    tm.set_log_level(tm.LogLevel.error)
    n = len(case.gap)
    model = tm.ModelFactory.createModel(tm.model_type.basic_2d, [1.0, 1.0], [n, n])
    model.E, model.nu = 1.0, 0.0
    solver = tm.PolonskyKeerRey(model, -case.gap, tolerance)
    solver.max_iter = 3000
    if not case.periodic:
        tm.ModelFactory.registerNonPeriodic(model, "free")
        solver.setIntegralOperator("free")
    start = time.process_time()
    solver.solve(case.mean_pressure)
    return time.process_time() - start, np.array(model.traction)


def contact_mechanics(case: Case, tolerance: float) -> tuple[float, Array]:
    """ContactMechanics: system and kernel are made beforehand, only the solve is timed."""
    from ContactMechanics import FreeFFTElasticHalfSpace, PeriodicFFTElasticHalfSpace
    from ContactMechanics.Systems import NonSmoothContactSystem
    from SurfaceTopography import Topography

    n = len(case.gap)
    kind = PeriodicFFTElasticHalfSpace if case.periodic else FreeFFTElasticHalfSpace
    substrate = kind((n, n), 1.0, (1.0, 1.0))
    system = NonSmoothContactSystem(substrate, Topography(-case.gap, (1.0, 1.0), periodic=case.periodic))
    scale = float(np.ptp(case.gap))
    start = time.process_time()
    found = system.minimize_proxy(
        external_force=case.mean_pressure,
        pentol=tolerance * scale,
        forcetol=tolerance * case.mean_pressure / n**2,
        maxiter=3000,
    )
    taken = time.process_time() - start
    force = np.abs(np.asarray(found.jac))[:n, :n]
    return taken, np.where(force > 0.0, force, 0.0) * n**2


SOLVERS: dict[str, tuple[Solver, list[float]]] = {
    "mtb_rs": (ours, [1e-4, 1e-6, GOAL, 1e-10]),
    "tamaas": (tamaas, [1e-4, 1e-6, 1e-8, 1e-10, 1e-12, 1e-14, 1e-16]),
    "ContactMechanics": (contact_mechanics, [1e-4, 1e-6, 1e-8, 1e-10]),
}


def run(n: int, repeats: int) -> list[dict[str, object]]:
    """All cases by all solvers, each up to the tolerance that meets the goal."""
    rows: list[dict[str, object]] = []
    for case in cases(n):
        for name, (solver, tolerances) in SOLVERS.items():
            for tolerance in tolerances:
                best, pressure = solver(case, tolerance)
                for _ in range(repeats - 1 if best < 5.0 else 0):
                    best = min(best, solver(case, tolerance)[0])
                error = residual(case, pressure)
                contact = float((pressure > 0.0).mean())
                row = {"case": case.name, "points": n, "solver": name, "tolerance": tolerance}
                rows.append(row | {"error": error, "seconds": best, "contact": contact})
                print(f"{case.name:24s} {name:17s} {tolerance:.0e} {error:9.1e} {best:9.3f} s  {contact:.4f}")
                if error <= GOAL and name != "mtb_rs":
                    break
    return rows


def summary(rows: list[dict[str, object]]) -> None:
    """Seconds to the goal, and how many times longer the peers take."""
    for case in dict.fromkeys(row["case"] for row in rows):
        taken: dict[str, float] = {}
        for row in rows:
            if row["case"] == case and float(str(row["error"])) <= GOAL:
                taken.setdefault(str(row["solver"]), float(str(row["seconds"])))
        mine = taken.get("mtb_rs", np.nan)
        others = [f"{name} {s:.3f} s ({s / mine:.1f} x)" for name, s in taken.items() if name != "mtb_rs"]
        print(f"{case}: mtb_rs {mine:.4f} s, {', '.join(others) or 'no other got there'}")


def chart(rows: list[dict[str, str]], path: Path) -> None:
    """Time against error."""
    names = list(dict.fromkeys(row["case"] for row in rows))
    figure, axes = plt.subplots(2, -(-len(names) // 2), figsize=(7.4, 6.0), sharex=True, sharey=True)
    for axis, case in zip(axes.flat, names, strict=True):
        for solver, marker in zip(SOLVERS, "osv", strict=True):
            mine = [row for row in rows if row["case"] == case and row["solver"] == solver]
            axis.loglog(
                [float(r["seconds"]) for r in mine],
                [float(r["error"]) for r in mine],
                marker=marker,
                label=solver,
            )
        axis.axhline(GOAL, color="#777777", linewidth=1.0, linestyle=":")
        axis.set(title=case, xlim=(0.03, 15.0))
        axis.set_xticks([0.1, 1.0, 10.0], ["0.1", "1", "10"])
    for axis in axes[-1]:
        axis.set_xlabel("processor time [s], one thread")
    for axis in axes[:, 0]:
        axis.set_ylabel("measured residual [-]")
    figure.legend(*axes.flat[0].get_legend_handles_labels(), loc="outside lower center", ncols=3)
    figure.savefig(path)


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--points", type=int, default=512, help="cells per side")
    parser.add_argument("--repeats", type=int, default=3, help="runs, of which the fastest counts")
    parser.add_argument("--out", type=output_folder, default="docs/charts", help="where CSV and chart go")
    parser.add_argument("--draw", action="store_true", help="only draw the table again that is there")
    arguments = parser.parse_args()
    table = arguments.out / "normal_peers.csv"
    if not arguments.draw:
        rows = run(arguments.points, arguments.repeats)
        summary(rows)
        records.write(table, rows)
    chart(records.read(table), table.with_suffix(".png"))


if __name__ == "__main__":
    main()
