# SPDX-License-Identifier: MIT OR Apache-2.0
"""Ctrl-C at random moments of long work: how long it takes until the work has ended.

    python studies/ctrl_c.py [NAME ...] [--times 8] [--seed 0]

Each work runs in a process of its own, once to its end and then again from the start, SIGINT sent at a random
moment of it. Printed are the latencies, as processor time of the process (all its threads) and as time of a
clock; on a machine with other work to do the first one counts. The inputs are fresh each time: nothing is
taken from a cache.
"""

from __future__ import annotations

import argparse
import os
import random
import select
import signal
import subprocess
import sys
import time
import warnings
from collections.abc import Callable, Iterator
from pathlib import Path

#: What may take how long: processor time [s] until work has ended.
AIM = 0.5


def _works() -> dict[str, Callable[[], Callable[[], object]]]:
    """What is interrupted, by name; each makes its input, and gives what is then timed."""
    import numpy as np

    import mtb_rs as mtb

    def square(cells: int, size: float = 0.02) -> tuple[np.ndarray, float]:
        x = (np.arange(cells) - 0.5 * (cells - 1)) * size / cells
        return (x[None, :] ** 2 + x[:, None] ** 2) / 0.4, size / cells

    def normal(cells: int, **options: object) -> Callable[[], object]:
        gap, spacing = square(cells)
        return lambda: mtb.solve_normal(gap, spacing, lower=mtb.steel, upper=mtb.steel, force=2e4, **options)

    def field(cells: int) -> Callable[[], object]:
        gap, spacing = square(cells)
        scene = mtb.Scene(mtb.steel, mtb.steel, gap=gap, spacing=spacing, friction=0.3, force=2e4)
        return scene.solve

    def rolling(cells: int) -> Callable[[], object]:
        gap, spacing = square(cells)
        pressed = mtb.solve_normal(gap, spacing, lower=mtb.steel, upper=mtb.steel, force=2e4)
        return lambda: mtb.solve_tangential(pressed, mtb.Rolling(creepage=(1e-3, 0.0, 0.0)), mtb.Coulomb(0.3))

    def block(spacing: float, model: str, method: str) -> Callable[[], object]:
        scene = mtb.scenes.block_on_plane(height=0.1, friction=0.3, spacing=spacing)
        return lambda: scene.solve(model, method=method)

    def start(spacing: float) -> Callable[[], object]:
        scene = mtb.scenes.block_on_plane(height=0.1, friction=0.3, spacing=spacing)
        return lambda: scene.start_of_sliding([1e-6, 1e-5], model="elastic-upper")

    def shoe(spacing: float, method: str, *arguments: object) -> Callable[[], object]:
        scene = mtb.scenes.pole_shoe_on_rail(spacing=spacing, friction=0.3)
        return lambda: getattr(scene, method)(*arguments)

    def meshing() -> Callable[[], object]:
        import trimesh

        box = trimesh.creation.box((0.1, 0.06, 0.04))
        return lambda: mtb.ElasticBody.from_mesh(box, mtb.steel, size=2e-3)

    def surfaces() -> Callable[[], object]:
        import trimesh

        ball = trimesh.creation.icosphere(subdivisions=7, radius=0.05)
        return lambda: mtb.BodySurface.mesh(ball.vertices.T, ball.faces)

    return {
        "normal-dense": lambda: normal(90, method="dense"),
        "normal-convolution": lambda: normal(4096),
        "normal-periodic": lambda: (
            lambda: mtb.area_load_curve(
                mtb.roughness(1024, 1e-6, rms_height=1e-7),
                1e-6,
                [1e-2, 1e-1, 1.0],
                lower=mtb.steel,
                upper=mtb.steel,
            )
        ),
        # normals turn over the rail: no convolution
        "sliding-dense": lambda: shoe(9e-4, "solve", "half-space"),
        "sliding-convolution": lambda: field(1024),
        "condensation": lambda: shoe(1.5e-3, "solve", "elastic-upper"),
        "prepare": lambda: shoe(1.5e-3, "prepare", "elastic-upper"),
        "both": lambda: shoe(3e-3, "solve", "elastic-both"),
        "auto": lambda: shoe(3e-3, "solve"),
        "chart": lambda: lambda: mtb.scenes.pole_shoe_on_rail(friction=0.3).chart(),
        "meshing": meshing,
        "surface": surfaces,
        "roughness": lambda: lambda: mtb.roughness(6000, 1e-6, rms_height=1e-7),
        "staggered": lambda: block(5e-3, "elastic-upper", "staggered"),
        "incremental": lambda: block(2.5e-3, "half-space", "incremental"),
        "start-of-sliding": lambda: start(5e-3),
        "rolling": lambda: rolling(400),
    }


def _serve(name: str) -> None:
    """Does the work once for each line of the input, and says how it ended and what it took so far."""
    warnings.simplefilter("ignore")
    from mtb_rs.base import cache

    make = _works()[name]
    for _ in sys.stdin:
        cache.forget()
        try:
            signal.signal(signal.SIGINT, signal.SIG_IGN)
            work = make()
            print(f"begin {time.process_time()}", flush=True)
            signal.signal(signal.SIGINT, signal.default_int_handler)
            work()
            word = "done"
        except KeyboardInterrupt:
            word = "stopped"
        signal.signal(signal.SIGINT, signal.SIG_IGN)
        print(f"{word} {time.process_time()}", flush=True)


def _processor_time(pid: int) -> float:
    """Of all threads of a process [s]; in steps of a hundredth."""
    fields = Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def _latencies(name: str, times: int, draw: random.Random) -> Iterator[tuple[float, float, float]]:
    """The moment of the signal, and the latency of the processor and of the clock [s]; first the whole."""
    command = [sys.executable, __file__, name, "--serve"]
    environment = {**os.environ, "MTB_RS_CACHE": "off"}
    with subprocess.Popen(
        command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, env=environment
    ) as other:
        assert other.stdin is not None
        assert other.stdout is not None

        def ask() -> float:
            print("go", file=other.stdin, flush=True)
            return float(other.stdout.readline().split()[1])

        begun, clock = ask(), time.monotonic()
        whole = float(other.stdout.readline().split()[1]) - begun
        yield whole, whole, time.monotonic() - clock
        for _ in range(times):
            begun, moment = ask(), draw.uniform(0.0, whole)
            # it may be quicker than the first time
            while (
                _processor_time(other.pid) - begun < moment
                and not select.select([other.stdout], [], [], 2e-3)[0]
            ):
                pass
            sent, clock = _processor_time(other.pid), time.monotonic()
            other.send_signal(signal.SIGINT)
            word, ended = other.stdout.readline().split()
            if word == "stopped":
                yield moment, float(ended) - sent, time.monotonic() - clock
        other.stdin.close()


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("names", nargs="*")
    parser.add_argument("--times", type=int, default=8)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--serve", action="store_true", help=argparse.SUPPRESS)
    given = parser.parse_args()
    if given.serve:
        _serve(given.names[0])
        return
    draw = random.Random(given.seed)
    for name in given.names or _works():
        whole, *found = _latencies(name, given.times, draw)
        worst = max(found, key=lambda f: f[1], default=(float("nan"),) * 3)
        mark = "  <-- above the aim" if worst[1] > AIM else ""
        print(
            f"{name:20s} takes {whole[1]:6.2f} s ({whole[2]:6.2f} s), stopped {len(found)} times; "
            f"slowest {worst[1]:5.2f} s ({worst[2]:5.2f} s) at {worst[0]:5.2f} s{mark}",
            flush=True,
        )


if __name__ == "__main__":
    main()
