# SPDX-License-Identifier: MIT OR Apache-2.0
"""How long does a step of a prepared contact take?

Three rides of a shoe with 400 contact points from 160 km/h down: friction and magnetic pressure from tables;
the same over a track that rolls and pitches the shoe; and jumps of load, pitch and direction at every
step. Then a wheel on a rail, height given or found from its force, in a wheelset that runs through its
sinusoidal path. Times are of the processor, so that other programs do not count; beside each ride stands what
its steps cost the same contact without memory, and the general solver of the shoe. Writes
docs/charts/stepping.csv and .png; `--draw` only draws the picture again.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Callable
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
import records

import mtb_rs as mtb
from mtb_rs import _mtb_rs
from mtb_rs.simulation.stepping import POSE

OUT = Path(__file__).parents[1] / "docs" / "charts"
FRICTION = mtb.VelocityTable((0.0, 5.0, 15.0, 30.0, 45.0), (0.35, 0.24, 0.16, 0.12, 0.10))
MAGNET = mtb.VelocityTable((0.0, 20.0, 45.0), (3.0e6, 2.6e6, 2.0e6))
STEPS = 2000
#: Steps of each ride that are taken without memory as well.
COMPARED = 200


def rides() -> dict[str, list[tuple[np.ndarray, float, float | None]]]:
    """Pose, velocity and magnetic pressure of each step."""
    speed = np.linspace(160 / 3.6, 0.5, STEPS)
    wave = np.arange(STEPS) / 50.0
    random = np.random.default_rng(1)
    tables, track, jumps = [], [], []
    for k, v in enumerate(speed):
        pose = np.full(6, np.nan)
        tables.append((pose, v, None))
        rocking = pose.copy()
        rocking[3] = 2e-5 * np.sin(wave[k]) + 2e-6 * random.standard_normal()
        rocking[4] = 2e-5 * np.cos(0.7 * wave[k])
        track.append((rocking, v, None))
        jump = pose.copy()
        jump[4] = 6e-5 * random.uniform(-1, 1)
        jumps.append((jump, v * random.choice((-1.0, 1.0)), 3e6 * random.uniform(0.2, 1.0)))
    return {"tables": tables, "rocking": track, "jumps": jumps}


def general_solver(scene: mtb.Scene, contact: mtb.PreparedContact) -> Callable[..., float]:
    """Processor time [s] of a step by the general solver."""
    problem = scene.with_(velocity=10.0).problem("elastic-upper")
    x, normal, direction = problem.points.points, problem.points.normal, problem.direction
    motions = np.concatenate([problem.upper.motions, problem.lower.motions])
    source = contact._source
    bodies = problem.lower.compliance, problem.upper.compliance
    of_upper = np.array([True] * problem.upper.work.size + [False] * problem.lower.work.size)
    # each keeps its matrices
    cores: dict[tuple[float, ...], _mtb_rs.Problem] = {}

    def solve(pose: np.ndarray, velocity: float, pull: float | None, force: np.ndarray) -> float:
        given = source.loads(MAGNET if pull is None else pull, abs(velocity))
        gap, work = given.gap, given.work
        turn = np.array([*np.nan_to_num(pose[3:5]), 0.0])
        gap = gap + np.einsum("in,in->n", np.cross(turn, x, axis=0), normal)
        free = [np.isnan(pose[POSE.index(name.split()[-1])]) for name in contact.motions]
        friction = np.full(gap.size, np.interp(abs(velocity), FRICTION.velocity, FRICTION.value))
        sign = float(np.sign(velocity))
        key = (sign, *map(float, free))
        if key not in cores:
            cores[key] = _mtb_rs.Problem(*bodies, problem.geometry, motions[free], of_upper[free].tolist())
            cores[key].prepare(sign * direction, True)
        loading = cores[key].loading(gap, work[free])
        clock = time.process_time()
        out = cores[key].slide(loading, sign * direction, friction)
        elapsed = time.process_time() - clock
        assert np.isclose((out.pressure * problem.area).sum(), -force[2], rtol=1e-2)
        return elapsed

    return solve


def wheel_rides() -> list[dict[str, object]]:
    """The rows of the table of a left wheel."""
    radius, speed = 0.46, 30.0
    contact = mtb.scenes.wheel_on_rail(lateral=0.0, force=60e3, spacing=5e-4).prepare(
        friction=mtb.Coulomb(0.3)
    )
    way = speed * 1e-3 * np.arange(STEPS)
    wave = 2.0 * np.pi / 20.0  # per metre
    lateral, yaw = 4e-3 * np.sin(wave * way), 4e-3 * wave * np.cos(wave * way)
    rate = -4e-3 * wave**2 * speed * np.sin(wave * way)
    rows = []
    height = np.full(STEPS, np.nan)
    for name in ("wheel, force given", "wheel, height given"):
        own = contact.copy()
        times, cold, cells = [], [], []
        for k in range(STEPS):
            spin = speed / radius
            pose = np.array([way[k], lateral[k], height[k], 0.0, 0.0, yaw[k]])
            velocity = [speed, speed * yaw[k], 0.0, -spin * yaw[k], spin, rate[k]]
            clock = time.process_time()
            out = own.step(pose, velocity)
            times.append(time.process_time() - clock)
            height[k] = out.pose[2]
            cells.append(sum(int((patch.pressure > 0.0).sum()) for patch in out.patches))
            if k % (STEPS // COMPARED) == 0:
                anew = own.copy()
                clock = time.process_time()
                anew.step(pose, velocity)
                cold.append((times[-1], time.process_time() - clock))
        rows.append(row(name, int(np.median(cells)), 1e3 * np.array(times), cold))
    return rows


def row(name: str, points: int, ms: np.ndarray, cold: list[tuple[float, float]]) -> dict[str, object]:
    """Percentiles of the times of a ride; `cold`: of some steps the time [s] with memory and without."""
    return {
        "ride": name,
        "points": points,
        "steps": len(ms),
        **{f"p{q}_ms": f"{np.percentile(ms, q):.3f}" for q in (50, 90, 99)},
        "max_ms": f"{ms.max():.3f}",
        "cold_median_ms": f"{1e3 * np.median([without for _, without in cold]):.3f}",
        "slower_than_cold": f"{sum(kept > without for kept, without in cold)} of {len(cold)}",
    }


def main() -> None:
    """Times the rides; writes the table and the chart."""
    scene = mtb.scenes.pole_shoe_on_rail(
        friction=FRICTION, magnetic_pressure=MAGNET, spacing=(90e-3 / 24, 2.3e-3)
    )
    contact = scene.prepare("elastic-upper")
    assert isinstance(contact, mtb.PreparedContact)
    points = contact.area.size
    solve_generally = general_solver(scene, contact)
    rows = []
    for name, ride in rides().items():
        own = contact.copy()
        times, cold, general = [], [], []
        refactored = products = 0
        for k, (pose, velocity, pull) in enumerate(ride):
            clock = time.process_time()
            out = own.step(pose, velocity, magnetic_pressure=pull)
            times.append(time.process_time() - clock)
            refactored += out.report.refactored
            products += out.report.products
            if k % (STEPS // COMPARED) == 0:
                anew = contact.copy()
                clock = time.process_time()
                anew.step(pose, velocity, magnetic_pressure=pull)
                cold.append((times[-1], time.process_time() - clock))
            if k % (STEPS // 20) == 0:
                general.append(solve_generally(pose, velocity, pull, out.force))
        ms = 1e3 * np.array(times)
        rows.append(
            row(name, points, ms, cold)
            | {"general_median_ms": f"{1e3 * np.median(general):.3f}"}
            | {"factorisations": refactored, "products_a_step": f"{products / len(ms):.1f}"}
        )
        print(rows[-1])
    for line in wheel_rides():
        print(line)
        rows.append(line)
    records.write(OUT / "stepping.csv", rows)
    draw(records.read(OUT / "stepping.csv"))


def draw(rows: list[dict[str, str]]) -> None:
    """The chart of a table: a line for each ride, from the median of its times to the longest."""
    figure, axes = plt.subplots(figsize=(7.4, 3.2))
    places = np.arange(len(rows))[::-1]
    axes.hlines(places, *([float(row[key]) for row in rows] for key in ("p50_ms", "max_ms")), color="#BBBBBB")
    marks = {
        "p50_ms": ("median", "o"),
        "p90_ms": ("90 % are shorter", "s"),
        "p99_ms": ("99 % are shorter", "D"),
        "max_ms": ("longest", "v"),
        "cold_median_ms": ("median without memory", "x"),
    }
    for key, (label, marker) in marks.items():
        axes.plot([float(row[key]) for row in rows], places, marker, ms=6, label=label)
    axes.set_yticks(places, [row["ride"] for row in rows])
    axes.set(xscale="log", title="time of a step [ms]")
    axes.set_xticks([1, 2, 3, 5, 10, 20, 30], minor=False)
    axes.minorticks_off()
    axes.xaxis.set_major_formatter("{x:g}")
    figure.legend(loc="outside lower center", ncols=3)
    figure.savefig(OUT / "stepping.png")


if __name__ == "__main__":
    if sys.argv[1:] == ["--draw"]:
        draw(records.read(OUT / "stepping.csv"))
    else:
        main()
