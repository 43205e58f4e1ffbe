# SPDX-License-Identifier: MIT OR Apache-2.0
"""What another solve of a known scene costs: friction, load, the thesis' Table 4.1, `model="auto"`.

    python benches/further_solves.py -o docs/charts/further_solves.csv
    PYTHONPATH=... python benches/further_solves.py --beside before   # another version, for the same table

Processor times, medians of several, from one run; two versions are compared on one machine by two calls.
"""

from __future__ import annotations

import argparse
import time
import warnings
from collections.abc import Callable
from pathlib import Path
from statistics import median

import records

import mtb_rs as mtb

REPEATS = 9
#: Coefficients of the thesis' Table 4.1.
TABLE = (0.5, 0.4, 0.3, 0.25, 0.2, 0.1)


def milliseconds(solve: Callable[[int], object], repeats: int = REPEATS) -> float:
    """Median processor time [ms] of `solve(k)`."""
    times = []
    for k in range(repeats):
        started = time.process_time()
        solve(k)
        times.append(time.process_time() - started)
    return 1e3 * median(times)


def table_4_1(shoe: mtb.Scene) -> None:
    for friction in TABLE:
        shoe.with_(friction=friction).solve("elastic-upper")


def measured() -> dict[str, float]:
    """Each row in milliseconds."""
    rows: dict[str, float] = {}
    scene = mtb.scenes.pole_shoe_on_rail(spacing=3e-3, friction=0.3)
    points = scene.solve("elastic-upper").pressure.size
    friction = [0.2 + 0.01 * k for k in range(REPEATS)]
    pull = [2e6 + 1e5 * k for k in range(REPEATS)]
    rows[f"another friction, {points} points"] = milliseconds(
        lambda k: scene.with_(friction=friction[k]).solve("elastic-upper")
    )
    rows[f"another pull, {points} points"] = milliseconds(
        lambda k: scene.with_(magnetic_pressure=pull[k]).solve("elastic-upper")
    )
    last = scene.solve("auto").model
    rows[f"model auto, which takes {last}"] = milliseconds(
        lambda k: scene.with_(friction=friction[k]).solve("auto")
    )
    scene.solve(last)
    rows[f"{last}, named"] = milliseconds(lambda k: scene.with_(friction=friction[k]).solve(last))
    shoe = mtb.scenes.pole_shoe_on_rail(height=0.1, length=0.096, supports="points", friction=0.5)
    shoe.solve("elastic-upper")
    rows["sweep of Table 4.1"] = milliseconds(lambda _: table_4_1(shoe), 3)
    return rows


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("-o", "--output", type=Path, default=Path("docs/charts/further_solves.csv"))
    parser.add_argument("--beside", default="now", help="name of the column")
    chosen = parser.parse_args()
    warnings.simplefilter("ignore")
    rows = measured()
    known: dict[str, dict[str, str]] = {}
    if chosen.output.exists():
        known = {row["what"]: row for row in records.read(chosen.output)}
    for what, time_ms in rows.items():
        known.setdefault(what, {"what": what})[f"{chosen.beside}_ms"] = f"{time_ms:.3g}"
        print(f"{what}: {time_ms:.3g} ms")
    columns = sorted({key for row in known.values() for key in row if key != "what"})
    records.write(chosen.output, [{k: row.get(k, "") for k in ("what", *columns)} for row in known.values()])


if __name__ == "__main__":
    main()
