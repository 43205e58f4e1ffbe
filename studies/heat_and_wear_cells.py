# SPDX-License-Identifier: MIT OR Apache-2.0
"""What the cells of heat and wear mean: error and time over the width of the cells.

Usage: python studies/heat_and_wear_cells.py. Takes some minutes. A pole shoe slides at 10 m/s, for two
seconds with heat, with and without expansion and wear, and for 5 m with wear alone. Errors are those of
fields along the pole, means over its width, as root mean squares against cells of 2.5 mm; times are of the
processor, of a second run, with all meshes and factors ready. At 20 m/s and with a tenth of that wear hot
spots do not wear away: the hottest point of the first 0.3 s is that of the cells, which let spots be as
narrow as they are.
"""

import time
import warnings
from collections.abc import Callable
from typing import Any

import numpy as np
from atlas import panels, write

import mtb_rs as mtb

WIDTHS = (15e-3, 10e-3, 7.5e-3, 5e-3, 4e-3, 3e-3)
FINE = 2.5e-3
DURATION, VELOCITY, WEAR, WAY = 2.0, 10.0, 1e-12, 5.0
#: Places along the pole [m] at which fields are compared, away from its ends.
PLACES = np.linspace(-0.035, 0.035, 29)


def along(points: np.ndarray, area: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Means over the width of the pole, at the places."""
    x = np.round(points[0], 9)
    stations = np.unique(x)
    means = [np.average(values[x == at], weights=area[x == at]) for at in stations]
    return np.interp(PLACES, stations, means)


def heated(shoe: mtb.Scene, *, expansion: bool) -> tuple[dict[str, np.ndarray], float]:
    found = shoe.sliding_heat(
        DURATION, 64, VELOCITY, tolerance=0.05 if expansion else None, expansion=expansion,
        wear=WEAR if expansion else None, model="elastic-upper",
    )  # fmt: skip
    own = found.points, found.area
    fields = {"temperature": along(*own, found.temperatures[-1])}
    if expansion:
        fields |= {"pressure": along(*own, found.pressures[-1]), "depth": along(*own, found.depths[-1])}
    return fields, float(found.peaks.max())


def worn(shoe: mtb.Scene) -> tuple[dict[str, np.ndarray], float]:
    found = mtb.wear(shoe, WAY, WEAR, tolerance=0.01, model="elastic-upper")
    own = found.points, found.area
    return {
        "pressure": along(*own, found.pressures[-1]),
        "depth": along(*own, found.depths[0, -1]),
    }, np.nan


RUNS: dict[str, Callable[[mtb.Scene], tuple[dict[str, np.ndarray], float]]] = {
    "wear": worn,
    "heat": lambda shoe: heated(shoe, expansion=False),
    "heat, expansion and wear": lambda shoe: heated(shoe, expansion=True),
}
COLOURS = {"temperature": "#D55E00", "pressure": "#0072B2", "depth": "#009E73"}


def main() -> None:
    """Runs all and draws them."""

    def shoe_of(width: float) -> mtb.Scene:
        return mtb.scenes.pole_shoe_on_rail(friction=0.12, magnetic_pressure=2.5e6, spacing=width)

    warnings.simplefilter("ignore")  # coarse cells are what is measured
    rows: list[dict[str, Any]] = []
    figure, axes = panels(4)
    for place, (effects, run) in zip(axes, RUNS.items(), strict=False):
        found = {}
        for width in (*WIDTHS, FINE):
            shoe = shoe_of(width)
            run(shoe)
            clock = time.process_time()
            fields, hottest = run(shoe)
            found[width] = fields, hottest, time.process_time() - clock
        fine = found[FINE][0]
        for width, (fields, hottest, seconds) in found.items():
            row: dict[str, Any] = {"effects": effects, "cells_mm": 1e3 * width, "processor_s": seconds}
            for name in COLOURS:
                off = np.linalg.norm(fields[name] - fine[name]) if name in fields else np.nan
                row[f"error_{name}"] = off / np.linalg.norm(fine[name]) if name in fields else np.nan
            rows.append(row | {"hottest_k": hottest})
            print(rows[-1], flush=True)
        own = [row for row in rows if row["effects"] == effects and row["cells_mm"] > 1e3 * FINE]
        for name in fine:
            errors = [100 * row[f"error_{name}"] for row in own]
            place.loglog([row["cells_mm"] for row in own], errors, "o-", color=COLOURS[name], label=name)
        place.set(ylabel="error along the pole [%]", title=effects, ylim=(5e-3, 2.0))
        place.legend(fontsize=7)
    hottest = []
    for width in WIDTHS:
        given = {"tolerance": 0.1, "expansion": True, "wear": 0.1 * WEAR, "model": "elastic-upper"}
        clock = time.process_time()
        peaks = shoe_of(width).sliding_heat(0.3, 1, 20.0, **given).peaks
        seconds = time.process_time() - clock
        hottest.append(float(peaks.max()))
        row = {"effects": "hot spots", "cells_mm": 1e3 * width, "processor_s": seconds}
        row |= {f"error_{name}": np.nan for name in COLOURS}
        rows.append(row | {"hottest_k": hottest[-1]})
        print(rows[-1], flush=True)
    axes[3].semilogx([1e3 * width for width in WIDTHS], hottest, "o-", color=COLOURS["temperature"])
    axes[3].set(ylabel="hottest point [K]", title="hot spots", ylim=(0.0, None))
    for place in axes:
        place.set_xlabel("width of the cells [mm]")
        place.set_xticks([3, 5, 10, 15], ["3", "5", "10", "15"])
        place.set_xticks([], minor=True)
    write("heat_and_wear_cells", figure, rows)


if __name__ == "__main__":
    main()
