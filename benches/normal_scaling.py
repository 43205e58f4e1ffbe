# SPDX-License-Identifier: MIT OR Apache-2.0
"""Work and time of the normal solver against the size of the grid.

    python benches/normal_scaling.py [--largest 2048] [--threads 1] [--out docs/charts]

Free space, force prescribed, residual 1e-8: a Hertz contact over three quarters of the grid, a flat square
punch, a bowl with waves and a rough bowl. Products with the influence matrix and applications of the
preconditioner are counted on all levels, in equivalents of one on the whole finest grid. The yardstick of
time is ten bare convolutions on the same grid (zero-padded, real transforms, kernel transformed
beforehand), by SciPy's pocketfft and by the package's own transform; the faster one counts.
"""

from __future__ import annotations

import argparse
import os
import time
from collections.abc import Callable
from pathlib import Path

_parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
_parser.add_argument("--largest", type=int, default=2048, help="cells per side of the largest grid")
_parser.add_argument("--threads", type=int, default=1)
_parser.add_argument("--repeats", type=int, default=3, help="runs, of which the fastest counts")
_parser.add_argument("--out", type=Path, default=Path("docs/charts"), help="where CSV and chart go")
_parser.add_argument("--draw", action="store_true", help="only draw the table again that is there")
ARGUMENTS = _parser.parse_args()
for _name in ("OMP_NUM_THREADS", "RAYON_NUM_THREADS", "OPENBLAS_NUM_THREADS"):
    os.environ[_name] = str(ARGUMENTS.threads)

import matplotlib.pyplot as plt
import numpy as np
import records
import scipy.fft
from numpy.typing import NDArray

import mtb_rs as mtb
from mtb_rs import _mtb_rs

Array = NDArray[np.float64]
ELASTIC, RIGID = mtb.Material(1.0, 0.0), mtb.Rigid()  # E* = 1 on the unit square


def cases(n: int) -> dict[str, tuple[Array, float]]:
    """Gap and force of each case."""
    x = (np.arange(n) + 0.5) / n - 0.5
    r2 = x[None, :] ** 2 + x[:, None] ** 2
    waves = np.cos(6.0 * np.pi * x)[None, :] * np.cos(6.0 * np.pi * x)[:, None]
    # the same waves on every grid that resolves them
    rough = mtb.roughness(n, 1.0 / n, rms_height=2e-3, hurst=0.8, roll_off=0.25, shortest=1.0 / 16.0, seed=1)
    return {
        "Hertz": (0.5 * r2, 4.0 / 3.0 * 0.375**3),
        "flat punch": (np.zeros((n, n)), 1.0),
        "bowl with waves": (0.5 * r2 + 2e-3 * (1.0 - waves), 0.05),
        "rough bowl": (0.5 * r2 - rough, 0.05),
    }


def fastest(work: Callable[[], object]) -> float:
    """Seconds of the fastest run: of the processor with one thread, of the clock with more."""
    clock = time.process_time if ARGUMENTS.threads == 1 else time.perf_counter
    taken = []
    for _ in range(ARGUMENTS.repeats):
        start = clock()
        work()
        taken.append(clock() - start)
    return min(taken)


def bare_convolution(n: int) -> tuple[float, str]:
    """Seconds of one convolution by the faster transform, and which that is."""
    field = np.random.default_rng(0).random((n, n))
    kernel = scipy.fft.rfft2(np.ones((2 * n, 2 * n)))
    workers = ARGUMENTS.threads

    def pocketfft() -> Array:
        spectrum = scipy.fft.rfft2(field, (2 * n, 2 * n), workers=workers) * kernel
        return np.asarray(scipy.fft.irfft2(spectrum, (2 * n, 2 * n), workers=workers)[:n, :n])

    # without compressibility a pressure moves the surface along its normal only: one product
    body = _mtb_rs.half_space((1.0, 0.5), [(0.0, 0.0, n, n)], (1.0 / n, 1.0 / n), True)
    traction = np.zeros((3, n * n))
    traction[2] = field.ravel()
    body.displacement(traction)
    own = fastest(lambda: body.displacement(traction))
    other = fastest(pocketfft)
    return (own, "mtb_rs") if own < other else (other, "pocketfft")


def run() -> list[dict[str, object]]:
    """Every case on every grid."""
    sizes = [n for n in (32, 64, 128, 256, 512, 1024, 2048, 4096) if n <= ARGUMENTS.largest]
    rows: list[dict[str, object]] = []
    for n in sizes:
        bare, transform = bare_convolution(n)
        for name, (gap, force) in cases(n).items():

            def solve(gap: Array = gap, force: float = force, n: int = n) -> mtb.NormalResult:
                return mtb.solve_normal(
                    gap,
                    1.0 / n,
                    lower=ELASTIC,
                    upper=RIGID,
                    force=force,
                    tolerance=1e-8,
                    edge="sharp",
                    method="fft",
                )

            report = solve().report
            seconds = fastest(solve)
            row = {"case": name, "points": n, "threads": ARGUMENTS.threads, "iterations": report.iterations}
            row |= {
                "convolutions": round(report.convolutions, 2),
                "preconditionings": round(report.preconditionings, 2),
                "seconds": seconds,
                "bare_convolution_seconds": bare,
                "bare_by": transform,
                "ratio_to_ten": seconds / (10.0 * bare),
            }
            rows.append(row)
            print(
                f"{name:16s} {n:5d}: {report.iterations:3d} iterations, "
                f"{report.convolutions:5.1f} convolutions, "
                f"{report.preconditionings:5.1f} preconditionings, {seconds:8.4f} s, "
                f"{seconds / (10.0 * bare):5.2f} times ten bare convolutions ({transform})"
            )
    return rows


def chart(rows: list[dict[str, str]], path: Path) -> None:
    """Counts and relative time over the size."""
    panels = (
        ("convolutions", "convolutions"),
        ("preconditionings", "preconditionings"),
        ("ratio_to_ten", "time / that of ten convolutions"),
    )
    figure, axes = plt.subplots(1, 3, figsize=(7.4, 3.4))
    for name, marker in zip(dict.fromkeys(row["case"] for row in rows), "osD^v*", strict=False):
        mine = [row for row in rows if row["case"] == name]
        for axis, (key, _) in zip(axes, panels, strict=True):
            axis.plot(
                [int(row["points"]) for row in mine],
                [float(row[key]) for row in mine],
                marker=marker,
                label=name,
            )
    for axis, (_, title) in zip(axes, panels, strict=True):
        axis.set(title=title, xlabel="cells a side", ylim=(0, None), xscale="log")
        axis.set_xticks([32, 128, 512, 2048], ["32", "128", "512", "2048"])
        axis.minorticks_off()
    figure.legend(*axes[0].get_legend_handles_labels(), loc="outside lower center", ncols=4)
    figure.savefig(path)


if __name__ == "__main__":
    table = ARGUMENTS.out / f"normal_scaling_{ARGUMENTS.threads}.csv"
    if not ARGUMENTS.draw:
        records.write(table, run())
    chart(records.read(table), table.with_suffix(".png"))
