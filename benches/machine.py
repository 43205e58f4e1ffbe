# SPDX-License-Identifier: MIT OR Apache-2.0
"""How far are the solves from the speed of the machine? One table, one picture, kept with their history.

    pip install 'mtb-rs[bench]'
    python benches/machine.py [--rows NAME ...] [--threads 1 2] [--label TEXT] [-o docs/charts]
    python benches/machine.py --draw

Each kind of row runs in a process of its own for each number of threads. Beside each time stands a yardstick
that the same process measured: ten zero-padded convolutions by FFTW on the grid of the row, a dense
product, or the solution of a dense system. The ratio of the two hardly depends on the machine. Times with
one thread are of the processor, others of the clock; each is the least of its repeats, but for the
percentiles of steps, and for condensations, which are made once.

A run appends its rows to machine.csv with the date, the commit and the machine, and draws machine.png with
the last of each row, and those before it in a paler colour.
"""

from __future__ import annotations

import argparse
import datetime
import json
import math
import os
import platform
import resource
import subprocess
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from functools import partial
from pathlib import Path
from typing import Any

HERE = Path(__file__).parent
#: Everything that calls a thread pool into being reads these.
POOLS = ("OMP_NUM_THREADS", "RAYON_NUM_THREADS", "OPENBLAS_NUM_THREADS")
#: Seconds a row's repeats may take together before no further one begins.
PATIENCE = 20.0
#: Curvature of the sphere on the unit square: flat, so that its deformation is small.
FLATNESS = 0.01
#: What the rows write, in the order of the table.
COLUMNS = (
    "date", "commit", "label", "machine", "threads", "row", "seconds", "yardstick", "yardstick_s", "ratio",
    "goal", "iterations", "products", "preconditionings", "peak_mb",
)  # fmt: skip

Row = dict[str, Any]


def threads() -> int:
    """Threads of this process."""
    return int(os.environ["RAYON_NUM_THREADS"])


def least(work: Callable[[], object], repeats: int = 5) -> float:
    """Seconds of the fastest run after one that does not count."""
    clock = time.process_time if threads() == 1 else time.perf_counter
    begun, taken = time.perf_counter(), []
    work()
    while len(taken) < repeats and (not taken or time.perf_counter() - begun < PATIENCE):
        start = clock()
        work()
        taken.append(clock() - start)
    return min(taken)


def convolutions(nx: int, ny: int, count: int = 10) -> tuple[str, float]:
    """Name and seconds of `count` convolutions in free space by the faster of FFTW and pocketfft."""
    import numpy as np
    import scipy.fft

    shape = (scipy.fft.next_fast_len(2 * ny, True), scipy.fft.next_fast_len(2 * nx, True))
    field = np.random.default_rng(0).random((ny, nx))
    kernel = scipy.fft.rfft2(np.ones(shape))

    def pocketfft() -> object:
        spectrum = scipy.fft.rfft2(field, shape, workers=threads())
        spectrum *= kernel
        return scipy.fft.irfft2(spectrum, shape, workers=threads())[:ny, :nx]

    found = {"pocketfft": least(pocketfft, 3)}
    try:
        import pyfftw
    except ImportError:
        print("pyfftw is not installed: the yardstick is pocketfft alone", file=sys.stderr)
    else:
        padded = pyfftw.zeros_aligned(shape)
        spectrum = pyfftw.empty_aligned(kernel.shape, dtype=complex)
        back = pyfftw.empty_aligned(shape)
        plan = {"axes": (0, 1), "threads": threads(), "flags": ("FFTW_MEASURE",)}
        forward = pyfftw.FFTW(padded, spectrum, **plan)
        inverse = pyfftw.FFTW(spectrum, back, direction="FFTW_BACKWARD", **plan)

        def fftw() -> object:
            padded[:] = 0.0
            padded[:ny, :nx] = field
            forward.execute()
            np.multiply(spectrum, kernel, out=spectrum)
            inverse.execute()
            return back[:ny, :nx].copy()

        found["FFTW"] = least(fftw, 3)
    name = min(found, key=lambda name: found[name])
    return f"{count} convolutions ({name})", count * found[name]


def periodic_products(n: int, count: int) -> tuple[str, float]:
    """Name and seconds of `count` convolutions without padding by pocketfft."""
    import numpy as np
    import scipy.fft

    field = np.random.default_rng(0).random((n, n))
    kernel = scipy.fft.rfft2(field)

    def product() -> object:
        return scipy.fft.irfft2(scipy.fft.rfft2(field, workers=threads()) * kernel, workers=threads())

    return f"{count} periodic convolutions (pocketfft)", count * least(product, 3)


def dense_rate() -> float:
    """Operations per second of a dense product."""
    import numpy as np

    a = np.random.default_rng(0).random((1500, 1500))
    return 2.0 * 1500.0**3 / least(lambda: a @ a)


def of(report: Any) -> Row:
    """The counts of a report."""
    return {
        "iterations": report.iterations,
        "products": round(report.convolutions, 1),
        "preconditionings": round(report.preconditionings, 1),
    }


def hertz() -> Iterator[Row]:
    """Hertz in free space, contact over three quarters of a side, by force and by approach."""
    import numpy as np

    import mtb_rs as mtb

    before = None
    for n in (128, 256, 512, 1024, 2048):
        x = (np.arange(n) + 0.5) / n - 0.5
        gap = 0.5 * FLATNESS * (x[None, :] ** 2 + x[:, None] ** 2)
        of_n = {"lower": mtb.Material(1.0, 0.0), "upper": mtb.Rigid(), "tolerance": 1e-8, "edge": "sharp"}

        def solve(gap: Any = gap, n: int = n, of_n: Any = of_n, **load: float) -> Any:
            return mtb.solve_normal(gap, 1.0 / n, method="fft", **of_n, **load)

        force, approach = {"force": FLATNESS * 4.0 / 3.0 * 0.375**3}, {"approach": FLATNESS * 0.375**2}
        name, yardstick = convolutions(n, n)
        by_force, by_approach = least(lambda: solve(**force)), least(lambda: solve(**approach))  # noqa: B023
        row = {"row": f"Hertz, force, {n}²", "seconds": by_force, "yardstick": name, "yardstick_s": yardstick}
        yield row | {"goal": 1.3 if n == 512 else ""} | of(solve(**force).report)
        row = {"row": f"Hertz, force beside approach, {n}²", "seconds": by_force, "goal": 1.15}
        yield row | {"yardstick": "by approach", "yardstick_s": by_approach}
        if before:
            row = {"row": f"Hertz, {n}² beside {n // 2}²", "seconds": by_force, "goal": 4.6}
            yield row | {"yardstick": "half the cells a side", "yardstick_s": before}
        before = by_force


def rough() -> Iterator[Row]:
    """A rough periodic surface at about a fifth of contact."""
    import mtb_rs as mtb

    for n in (128, 256, 512, 1024):
        gap = mtb.roughness(n, 1.0 / n, rms_slope=0.1, hurst=0.8, roll_off=0.25, shortest=8.0 / n, seed=1)
        gap = gap.max() - gap

        def solve(gap: Any = gap, n: int = n) -> Any:
            bodies = {"lower": mtb.Material(1.0, 0.0), "upper": mtb.Rigid()}
            return mtb.solve_normal(gap, 1.0 / n, force=0.0105, tolerance=1e-8, periodic=True, **bodies)

        name, yardstick = periodic_products(n, 60)
        row = {"row": f"rough, periodic, {n}²", "seconds": least(solve)}
        yield row | {"yardstick": name, "yardstick_s": yardstick, "goal": 1.0} | of(solve().report)


def measured_profile() -> Iterator[Row]:
    """The gap of [Vollebregt2012, Table 1], by force and by approach."""
    import mtb_rs as mtb

    data = json.loads((HERE.parent / "tests" / "data" / "contact" / "paper_table_1.json").read_text())
    steel = mtb.Material.from_shear_modulus(82e9, 0.28)
    for spacing in (0.1, 0.05, 0.025, 0.0125):
        gap = measured_gap(data, spacing)
        ny, nx = gap.shape
        name, yardstick = convolutions(nx, ny)
        for kind, load in (("force", {"force": 1e4}), ("approach", {"approach": 0.02084e-3})):

            def solve(gap: Any = gap, spacing: float = spacing, load: dict[str, float] = load) -> Any:
                bodies = {"lower": steel, "upper": steel}
                return mtb.solve_normal(gap, spacing * 1e-3, tolerance=1e-8, method="fft", **bodies, **load)

            row = {"row": f"measured profile, {kind}, {spacing:g} mm", "seconds": least(solve)}
            yield row | {"yardstick": name, "yardstick_s": yardstick, "goal": ""} | of(solve().report)


def measured_gap(data: dict[str, Any], spacing: float) -> Any:
    """Gap [m] of the measured profile on cells of `spacing` [mm], centres at the middle of each."""
    import numpy as np

    xl, yl = -3.55, -6.15
    nx, ny = round(7.1 / spacing), round(8.1 / spacing)
    x, y = xl + (np.arange(nx) + 0.5) * spacing, yl + (np.arange(ny) + 0.5) * spacing
    across = np.interp(y, data["y0"] + data["dy"] * np.arange(len(data["z"])), data["z"])
    return 1e-3 * (across[:, None] + x[None, :] ** 2 / (2.0 * data["radius"]))


def rolling() -> Iterator[Row]:
    """Steady rolling with creepage along, across and about, and a step of transient rolling."""
    import mtb_rs as mtb
    from mtb_rs.half_space import reference

    body, law = mtb.Material.from_shear_modulus(82e9, 0.28), mtb.Coulomb(0.3)
    for n in (50, 100, 200, 400):
        patch = reference.elliptic_pressure(1e4, (3.205e-3, 3.205e-3), (n, n), body, body)
        name, yardstick = convolutions(n, n)
        yardsticks = {"yardstick": name, "yardstick_s": yardstick, "goal": ""}
        motion = mtb.Rolling(creepage=(4e-4, 3e-4, 0.2))

        def steady(patch: Any = patch, motion: Any = motion) -> Any:
            return mtb.solve_tangential(patch, motion, law)

        row = {"row": f"rolling, steady, {n}²", "seconds": least(steady, 3)}
        yield row | yardsticks | of(steady().report)
        if n > 100:
            continue
        step, state = mtb.Rolling(creepage=(4e-4, 3e-4, 0.2), transient=True), None
        for _ in range(n // 4):
            state = mtb.solve_tangential(patch, step, law, state=state).state

        def transient(patch: Any = patch, step: Any = step, state: Any = state) -> Any:
            return mtb.solve_tangential(patch, step, law, state=state)

        row = {"row": f"rolling, a transient step, {n}²", "seconds": least(transient)}
        yield row | yardsticks | of(transient().report)


def condensation() -> Iterator[Row]:
    """One pole shoe: its factorisation and the whole, beside the same operations in a dense product."""
    import condensation as bench

    rate = dense_rate()
    found = bench.condense(1)  # a second one would be found in the cache
    gflop = {key: float(str(found[f"{key}_gflop"])) for key in ("factor", "forward", "product")}
    name = f"a dense product at {1e-9 * rate:.0f} Gflop/s"
    for row, seconds, operations, goal in (
        ("condensation, factorisation", found["numeric_s"], gflop["factor"], 1.0 / 0.6),
        ("condensation, all of it", found["total_s"], sum(gflop.values()), ""),
    ):
        yield {
            "row": row,
            "seconds": float(str(seconds)),
            "yardstick": name,
            "yardstick_s": 1e9 * operations / rate,
            "goal": goal,
        }


def percentiles(name: str, taken: list[float], shares: Sequence[int], yardstick: float) -> Iterator[Row]:
    """Of the times of steps, beside a dense system of 400."""
    import numpy as np

    for share in shares:
        yield {
            "row": f"{name}, {'longest' if share == 100 else f'{share} % are shorter'}",
            "seconds": float(np.percentile(taken, share)),
            "yardstick": "a dense system of 400",
            "yardstick_s": yardstick,
            "goal": "",
        }


def steps() -> Iterator[Row]:
    """Percentiles of the steps of a shoe with 400 points, beside a dense system of its size."""
    import numpy as np
    import stepping as bench

    scene = bench.mtb.scenes.pole_shoe_on_rail(
        friction=bench.FRICTION, magnetic_pressure=bench.MAGNET, spacing=(90e-3 / 24, 2.3e-3)
    )
    contact = scene.prepare("elastic-upper")
    matrix = np.random.default_rng(0).random((contact.area.size,) * 2) + 400.0 * np.eye(contact.area.size)
    yardstick = least(lambda: np.linalg.solve(matrix, contact.area), 20)
    clock = time.process_time if threads() == 1 else time.perf_counter
    for name, ride in bench.rides().items():
        own, taken = contact.copy(), []
        for pose, velocity, pull in ride:
            start = clock()
            own.step(pose, velocity, magnetic_pressure=pull)
            taken.append(clock() - start)
        yield from percentiles(f"step, {name}", taken, (50, 99, 100), yardstick)


def wheelset() -> Iterator[Row]:
    """A wheelset on its sinusoidal path, of which height and roll are found, beside a dense system of 400."""
    import numpy as np

    import mtb_rs as mtb

    wheels = mtb.scenes.wheel_on_rail(lateral=0.0, force=60e3, spacing=1e-3).prepare(side="both")
    matrix = np.random.default_rng(0).random((400, 400)) + 400.0 * np.eye(400)
    yardstick = least(lambda: np.linalg.solve(matrix, matrix[0]), 20)
    clock = time.process_time if threads() == 1 else time.perf_counter
    taken = []
    for phase in np.linspace(0.0, 4.0 * np.pi, 400):
        start = clock()
        wheels.step([0.0, 5e-3 * np.sin(phase), math.nan, math.nan, 0.0, 5e-3 * np.cos(phase)], velocity=20.0)
        taken.append(clock() - start)
    yield from percentiles("wheelset step", taken, (50, 99), yardstick)


def fine_shoe(spacing: float) -> Iterator[Row]:
    """An elastic shoe on a fine contact grid, from nothing to the pressure."""
    import mtb_rs as mtb
    from mtb_rs.base import cache

    rate = dense_rate()
    with cache.memory_only():
        start = time.perf_counter()
        found = mtb.scenes.pole_shoe_on_rail(spacing=spacing).solve("elastic-upper")
        seconds = time.perf_counter() - start
    yield {
        "row": f"elastic shoe, {found.pressure.size} points",
        "seconds": seconds,
        "yardstick": f"1e11 operations of a dense product at {1e-9 * rate:.0f} Gflop/s",
        "yardstick_s": 1e11 / rate,
        "goal": "",
    }


# each in a process of its own, whose memory nothing earlier has filled
KINDS: dict[str, Callable[[], Iterator[Row]]] = {
    work.__name__: work for work in (hertz, rough, measured_profile, rolling, condensation, steps, wheelset)
} | {f"fine_shoe_{1e3 * spacing:g}_mm": partial(fine_shoe, spacing) for spacing in (1.5e-3, 1e-3, 0.5e-3)}


def child(kind: str) -> None:
    """Measures one kind of rows in this process; writes a line of JSON for each."""
    for row in KINDS[kind]():
        peak = round(1e-3 * resource.getrusage(resource.RUSAGE_SELF).ru_maxrss)
        print(json.dumps({"peak_mb": peak} | row), flush=True)


def commit() -> str:
    """The commit that is measured, with a plus where files differ from it."""
    git = ["git", "-C", str(HERE), "describe", "--always", "--dirty=+", "--exclude=*"]
    return subprocess.run(git, capture_output=True, text=True, check=True).stdout.strip()


def processor() -> str:
    """Name of the processor, and how many of them there are."""
    name = platform.processor() or platform.machine()
    information = Path("/proc/cpuinfo")
    if information.exists():
        for line in information.read_text().splitlines():
            if line.startswith("model name"):
                name = line.split(":", 1)[1].strip()
                break
    return f"{name}, {os.cpu_count()} processors"


def run(kinds: list[str], counts: list[int], label: str) -> tuple[list[Row], bool]:
    """All rows of this run, and whether every kind came to its end."""
    origin = {
        "date": datetime.datetime.now(datetime.UTC).strftime("%Y-%m-%d %H:%M"),
        "commit": commit(),
        "label": label,
        "machine": processor(),
    }
    rows: list[Row] = []
    is_whole = True
    for kind in kinds:
        for count in counts:
            environment = os.environ | dict.fromkeys(POOLS, str(count))
            with subprocess.Popen(
                [sys.executable, __file__, "--child", kind],
                stdout=subprocess.PIPE,
                text=True,
                env=environment,
            ) as process:
                assert process.stdout is not None
                for line in process.stdout:
                    found = json.loads(line)
                    found["ratio"] = found["seconds"] / found["yardstick_s"]
                    goal = f" (goal {found['goal']:.3g})" if found.get("goal") else ""
                    work = f", {found['products']:g} products" if "products" in found else ""
                    print(
                        f"{count} thread{'s' * (count > 1)}: {found['row']}: {found['seconds']:.4g} s{work}, "
                        f"{found['ratio']:.3g} times {found['yardstick']}{goal}",
                        flush=True,
                    )
                    for key in ("seconds", "yardstick_s", "ratio", "goal"):
                        found[key] = f"{found[key]:.4g}" if found.get(key) else ""
                    rows.append({key: (origin | {"threads": count} | found).get(key, "") for key in COLUMNS})
            if process.returncode:
                is_whole = False
                print(f"{kind} with {count} threads ended early, with exit code {process.returncode}")
    return rows, is_whole


def draw(rows: list[dict[str, str]], path: Path) -> None:
    """The last ratio of each row to its yardstick, its gain by a second thread; earlier ratios are paler."""
    import matplotlib.pyplot as plt

    # the table is in the order of time: the last one of each stays
    last = {(row["row"], row["threads"]): row for row in rows}
    place = {name: -k for k, name in enumerate(dict.fromkeys(row["row"] for row in rows))}
    earlier = [row for row in rows if row["threads"] == "1" and row is not last[row["row"], "1"]]
    now = [row for (_, count), row in last.items() if count == "1"]
    figure, (left, right) = plt.subplots(
        1, 2, figsize=(7.4, 1.4 + 0.17 * len(place)), sharey=True, width_ratios=(2, 1)
    )
    for mine, colour, label in ((earlier, "#BBBBBB", "earlier runs"), (now, "C0", "last run")):
        at = [place[row["row"]] for row in mine]
        left.plot([float(row["ratio"]) for row in mine], at, "o", ms=4, color=colour, label=label)
    goals = {row["row"]: float(row["goal"]) for row in now if row["goal"]}
    left.plot(list(goals.values()), [place[name] for name in goals], "|", ms=9, color="C1", label="aim")
    gain = {
        name: float(last[name, "1"]["seconds"]) / float(last[name, "2"]["seconds"])
        for name in place
        if (name, "1") in last and (name, "2") in last and " beside " not in name
    }
    right.plot(list(gain.values()), [place[name] for name in gain], "D", ms=4, color="C2")
    left.set_yticks(list(place.values()), list(place), fontsize=7)
    left.set(xscale="log", title="time / yardstick, one thread", ylim=(-len(place), 1))
    left.xaxis.set_major_formatter("{x:g}")
    right.set(title="gain by two threads", xlim=(0.0, 2.05))
    figure.legend(*left.get_legend_handles_labels(), loc="outside lower center", ncols=3)
    figure.savefig(path)


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    names = list(KINDS)
    parser.add_argument("--rows", nargs="+", choices=names, default=names, help="kinds of rows to measure")
    parser.add_argument("--threads", type=int, nargs="+", default=[1, 2], help="numbers of threads")
    parser.add_argument("--label", default="", help="a word on this run, for the table")
    parser.add_argument("-o", "--out", type=Path, default=HERE.parent / "docs" / "charts")
    parser.add_argument("--draw", action="store_true", help="only draw the table again that is there")
    parser.add_argument("--child", choices=names, help=argparse.SUPPRESS)
    chosen = parser.parse_args()
    if chosen.child:
        child(chosen.child)
        return
    import records

    table, is_whole = chosen.out / "machine.csv", True
    kept: list[Row] = list(records.read(table)) if table.exists() else []
    for kind in [] if chosen.draw else chosen.rows:
        rows, is_done = run([kind], chosen.threads, chosen.label)
        is_whole = is_whole and is_done
        kept += rows
        records.write(table, kept)  # after each kind: a run that is stopped keeps what it has
    draw(records.read(table), table.with_suffix(".png"))
    sys.exit(0 if is_whole else 1)


if __name__ == "__main__":
    main()
