# SPDX-License-Identifier: MIT OR Apache-2.0
"""Table 1 of [Vollebregt2012]: the normal problem of a wheel on a rail, by force and by approach.

    python benches/paper_table_1.py [--out docs/charts]

"smooth" solves the very gaps of `tests/data/contact` (new S1002 on a UIC60, 6.2 mm lateral shift), for
which runs of CONTACT (2025) are at hand: its processor seconds and how far its numbers are from ours.
"measured" is the paper's own gap: a worn wheel, whose measured profile leaves irregularities, from CONTACT's
performance tests; 10 kN, or the approach of those tests, for which runs of CONTACT are at hand. One thread,
processor seconds, the median of the repeats; convolutions on all grids count in equivalents of one on the
whole finest grid.
"""

from __future__ import annotations

import argparse
import csv
import gzip
import json
import os
import statistics
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any

_parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
_parser.add_argument("--out", type=Path, default=Path("docs/charts"), help="where the CSV file goes")
_parser.add_argument("--draw", action="store_true", help="only draw the table again that is there")
_parser.add_argument("--repeats", type=int, default=3, help="solves, of whose times the median counts")
ARGUMENTS = _parser.parse_args()
for _name in ("OMP_NUM_THREADS", "RAYON_NUM_THREADS", "OPENBLAS_NUM_THREADS"):
    os.environ[_name] = "1"

import matplotlib.pyplot as plt
import numpy as np
import records
from numpy.typing import NDArray

import mtb_rs as mtb

Array = NDArray[np.float64]

DATA = Path(__file__).parents[1] / "tests" / "data" / "contact"
MM, MPA = 1e-3, 1e6
#: Steel of CONTACT's runs, and their force along the normal [N].
STEEL, NORMAL_FORCE = mtb.Material.from_shear_modulus(82e9, 0.28), 39206.8
MEASURED = json.loads((DATA / "paper_table_1.json").read_text(encoding="utf-8"))
LOADS = {"smooth": NORMAL_FORCE, "measured": 10e3}
#: Worst-case bar for counts: the solver's own residual.
TOLERANCE = 1e-8
#: [Vollebregt2012, Table 1]: spacing [mm] and what is prescribed; cells in contact, seconds of versions
#: 11.1 and 12.1.
PAPER = {
    ("0.1", "approach"): (3150, 4.3, 0.3),
    ("0.05", "approach"): (12900, 81.0, 1.7),
    ("0.025", "approach"): (50800, 1958.0, 17.3),
    ("0.1", "force"): (3150, 12.8, 0.6),
    ("0.05", "force"): (12900, 245.0, 3.9),
    ("0.025", "force"): (50800, 5104.0, 35.5),
}


def given_gap(spacing: str) -> Array:
    with gzip.open(DATA / f"s1002_uic60_y6.2_gap_dx{spacing}.csv.gz", "rt") as file:
        file.readline()
        return np.asarray(np.loadtxt(file, delimiter=",") * MM)


def measured_gap(spacing: str) -> Array:
    """The paper's own gap [m], on the cells of CONTACT's performance tests."""
    row = measured_run(spacing)
    x, y = (row[low] + (np.arange(row[n]) + 0.5) * row["dx"] for low, n in (("xl", "nx"), ("yl", "ny")))
    z = np.interp(y, MEASURED["y0"] + MEASURED["dy"] * np.arange(len(MEASURED["z"])), MEASURED["z"])
    return np.asarray((z[:, None] + x[None, :] ** 2 / (2.0 * MEASURED["radius"])) * MM)


def measured_run(spacing: str) -> dict[str, Any]:
    """CONTACT's run on the paper's own gap."""
    return next(row for row in MEASURED["cases"].values() if row["dx"] == float(spacing))


def contact_runs() -> dict[tuple[str, str], dict[str, str]]:
    """CONTACT's runs on the given gaps."""
    with (DATA / "table1_like.csv").open(encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    kinds = {"module3 N=1 (same gap)": "force", "module3 N=0 (same gap)": "approach"}
    return {(row["dx_mm"], kinds[row["case"]]): row for row in rows if row["case"] in kinds}


def as_run(row: dict[str, Any]) -> dict[str, str]:
    """What a run on the measured gap found, by the names of the other runs."""
    area = row["ncon"] * row["dx"] ** 2
    found = {"pmax_MPa": row["pmax"], "area_mm2": area, "approach_mm": row["approach"], "Fn_N": row["FN"]}
    return {name: str(value) for name, value in found.items()}


def timed(gap: Array, spacing: str, tolerance: float | None, load: dict[str, float]) -> Any:
    """The solution and its median processor seconds."""
    seconds = []
    for _ in range(ARGUMENTS.repeats):
        start = time.process_time()
        found = mtb.solve_normal(
            gap, float(spacing) * MM, lower=STEEL, upper=STEEL, tolerance=tolerance, method="fft", **load
        )
        seconds.append(time.process_time() - start)
    return found, statistics.median(seconds)


def main() -> None:
    runs, rows, pictures = contact_runs(), [], {}
    for profiles, field in (("smooth", given_gap), ("measured", measured_gap)):
        for spacing in ("0.1", "0.05", "0.025"):
            gap = field(spacing)
            approach = measured_run(spacing)["approach"] * MM if profiles == "measured" else None
            for prescribed in ("force", "approach"):
                load = {"force": LOADS[profiles]} if prescribed == "force" else {"approach": approach}
                found, seconds = timed(gap, spacing, TOLERANCE, load)
                default, default_seconds = timed(gap, spacing, None, load)
                approach = approach or found.approach
                if spacing == "0.05":
                    pictures[profiles] = found
                cells, before, after = PAPER[spacing, prescribed]
                row: dict[str, Any] = {
                    "profiles": profiles,
                    "prescribed": prescribed,
                    "spacing_mm": spacing,
                    "grid": f"{gap.shape[1]} x {gap.shape[0]}",
                    "cells_in_contact": int(found.status.sum()),
                    "paper_cells_in_contact": cells,
                    "paper_v11_1_s": before,
                    "paper_v12_1_s": after,
                }
                other = runs[spacing, prescribed] if profiles == "smooth" else None
                row["contact_2025_s"] = other["norm_cpu_s_median3"] if other else ""
                row["contact_2025_iterations"] = other["itcg_or_ncalls"] if other else ""
                if (profiles, prescribed) == ("measured", "approach"):
                    other = as_run(measured_run(spacing))
                row |= {"seconds": f"{seconds:.4f}", "iterations": found.report.iterations}
                row["convolutions"] = f"{found.report.convolutions:.1f}"
                row["preconditionings"] = f"{found.report.preconditionings:.1f}"
                row["seconds_default_tolerance"] = f"{default_seconds:.4f}"
                row["convolutions_default_tolerance"] = f"{default.report.convolutions:.1f}"
                row |= differences(found, other)
                rows.append(row)
                print(*row.values(), sep=", ")
    records.write(ARGUMENTS.out / "paper_table_1.csv", rows)
    chart(rows, pictures, ARGUMENTS.out / "paper_table_1.png")


def draw() -> None:
    """Solves what the picture shows of the contact, and takes the times from the table."""
    pictures = {}
    for profiles, field in (("smooth", given_gap), ("measured", measured_gap)):
        ARGUMENTS.repeats = 1
        pictures[profiles], _ = timed(field("0.05"), "0.05", TOLERANCE, {"force": LOADS[profiles]})
    rows = records.read(ARGUMENTS.out / "paper_table_1.csv")
    chart(rows, pictures, ARGUMENTS.out / "paper_table_1.png")


def chart(rows: Sequence[records.Record], pictures: dict[str, mtb.NormalResult], path: Path) -> None:
    """Both contact areas, and all times over the cells in contact."""
    figure = plt.figure(figsize=(7.4, 7.0))
    top, bottom = figure.subfigures(2, 1, height_ratios=(1.2, 1.35))
    maps = top.subplots(1, 2, width_ratios=(1.9, 1.0))
    for name, found, ax in zip(pictures, pictures.values(), maps, strict=True):
        x, y = found.points[0] / MM, found.points[1] / MM
        pressure = np.where(found.status > 0, found.pressure / MPA, np.nan)
        shown = ax.pcolormesh(x, y, pressure, vmin=0.0, rasterized=True)
        closed = np.argwhere(found.status > 0)
        low_y, low_x = np.maximum(closed.min(axis=0) - 8, 0)
        high_y, high_x = np.minimum(closed.max(axis=0) + 8, np.array(pressure.shape) - 1)
        ax.set(xlim=(x[0, low_x], x[0, high_x]), ylim=(y[low_y, 0], y[high_y, 0]), aspect="equal")
        ax.set(title=f"{name}: pressure [MPa]", xlabel="along the rail [mm]")
        ax.grid(visible=False)
        top.colorbar(shown, ax=ax, pad=0.01, shrink=0.8)
    maps[0].set_ylabel("across [mm]")
    ax = bottom.subplots()
    kinds = {"paper_v11_1_s": "paper, version 11.1", "paper_v12_1_s": "paper, version 12.1"}
    kinds |= {
        "contact_2025_s": "CONTACT (2025)",
        "seconds": "mtb_rs, 1e-8",
        "": "mtb_rs, measured, 1e-8",
    }
    for (key, label), marker in zip(kinds.items(), "sDvo^", strict=True):
        wanted = "smooth" if key and not key.startswith("paper") else "measured"
        mine = [row for row in rows if row["prescribed"] == "force" and row["profiles"] == wanted]
        size = "paper_cells_in_contact" if key.startswith("paper") else "cells_in_contact"
        ax.loglog(
            [float(row[size]) for row in mine],
            [float(row[key or "seconds"]) for row in mine],
            marker=marker,
            label=label,
        )
    ax.minorticks_off()
    ax.set_xticks([3000, 10000, 50000], ["3 000", "10 000", "50 000"])
    ax.set(xlabel="cells in contact", title="processor time [s], force prescribed")
    bottom.legend(*ax.get_legend_handles_labels(), loc="outside lower center", ncols=3)
    figure.savefig(path)


def differences(found: mtb.NormalResult, other: dict[str, str] | None) -> dict[str, str]:
    """Ours against CONTACT's, in per cent of it."""
    ours = {
        "peak": (found.pressure.max() / MPA, "pmax_MPa"),
        "area": (found.contact_area / MM**2, "area_mm2"),
        "approach": (found.approach / MM, "approach_mm"),
        "force": (found.normal_force, "Fn_N"),
    }
    return {
        f"{name}_difference_percent": f"{100.0 * (value / float(other[key]) - 1.0):.4f}" if other else ""
        for name, (value, key) in ours.items()
    }


if __name__ == "__main__":
    draw() if ARGUMENTS.draw else main()
