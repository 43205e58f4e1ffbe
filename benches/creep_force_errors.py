# SPDX-License-Identifier: MIT OR Apache-2.0
"""How good are the quick methods of rolling? Forces over random creepages against the full solution.

The error is the difference of the tangential force vectors over the size of the full one. The literature
states under 10 % for FASTSIM but for large spin, where more than 20 % occur in 15 to 20 % of cases
[Vollebregt2012]. Small and large spin are told apart at `phi sqrt(a b)` against the creepage. Ellipses come
first, then patches of a wheel on a rail that are none, there also with the pressure by KPEC and by ANALYN.
The time is that of one creepage in a list of them, with the pressure where the method makes it.
"""

import argparse
import functools
import time
from collections.abc import Callable
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
import records

import mtb_rs as mtb
from mtb_rs.base.files import output_folder
from mtb_rs.half_space import reference

parser = argparse.ArgumentParser(description=__doc__)
parser.add_argument("-o", "--output", type=output_folder, default="docs/charts")
parser.add_argument("--cases", type=int, default=400)
parser.add_argument("--cells", type=int, default=40)
arguments = parser.parse_args()

random = np.random.default_rng(2012)
body = mtb.Material.from_shear_modulus(82e9, 0.28)
ratios = (0.5, 0.7, 1.0, 1.4, 2.0)
friction, load = 0.3, 5e4
law = mtb.Coulomb(friction)
table = mtb.CreepForceTable.build(ratios=(0.25, *ratios, 3.0, 5.0), poisson_ratio=0.28, nodes=11, cells=20)
Axes = tuple[float, float] | None
methods: dict[str, Callable[..., np.ndarray]] = {
    "FASTSIM parabolic": lambda p, rows, axes: mtb.fastsim_curve(p, rows, law, semi_axes=axes),
    "FASTSIM elliptic": lambda p, rows, axes: mtb.fastsim_curve(p, rows, law, "elliptic", semi_axes=axes),
    "FASTSIM2 parabolic": lambda p, rows, axes: mtb.fastsim_curve(p, rows, law, order=2, semi_axes=axes),
    "FASTSIM blended": lambda p, rows, axes: mtb.fastsim_curve(
        p, rows, law, flexibilities="blended", semi_axes=axes
    ),
    "FASTSIM one flexibility": lambda p, rows, axes: mtb.fastsim_curve(
        p, rows, law, flexibilities=1, semi_axes=axes
    ),
    "FaStrip": lambda p, rows, axes: mtb.fastrip_curve(p, rows, law, semi_axes=axes),
    "FaStrip, direction of CONTACT": lambda p, rows, axes: mtb.fastrip_curve(
        p, rows, law, semi_axes=axes, stick_direction="CONTACT"
    ),
    "Polach": lambda p, rows, axes: mtb.polach(p, rows, law, semi_axes=axes),
    "table": lambda p, rows, axes: table.creep_forces(p, rows, law, semi_axes=axes),
}
errors: dict[tuple[str, str], list[float]] = {}
times: dict[tuple[str, str], list[float]] = {}


def creepages(count: int, a: float, b: float, load: float) -> np.ndarray:
    """Random ones from a tenth of what friction carries to full sliding."""
    rows = random.standard_normal((count, 3))
    rows /= np.linalg.norm(rows, axis=1)[:, None]
    rows *= friction * load / (a * b * 82e9) * 10 ** random.uniform(-1.3, 1.0, (count, 1))
    rows[:, 2] /= np.sqrt(a * b)
    return np.asarray(rows)


def judge(name: str, found: Callable[[], np.ndarray], full: np.ndarray, kinds: dict[str, np.ndarray]) -> None:
    start = time.process_time()
    forces = found()[:, :2]
    spent = (time.process_time() - start) / len(full)
    error = np.linalg.norm(forces - full, axis=1) / np.linalg.norm(full, axis=1)
    for kind, chosen in kinds.items():
        errors.setdefault((name, kind), []).extend(error[chosen])
        times.setdefault((name, kind), []).append(spent)


for ratio in ratios:
    a, b = 5e-3 * np.sqrt(ratio), 5e-3 / np.sqrt(ratio)
    patch = reference.elliptic_pressure(load, (a, b), (arguments.cells, arguments.cells), body, body)
    rows = creepages(arguments.cases // len(ratios), a, b, load)
    full = mtb.creep_curve(patch, rows, law, order=2)[:, :2]
    large = np.abs(rows[:, 2]) * np.sqrt(a * b) > np.hypot(rows[:, 0], rows[:, 1])
    kinds = {"all": large | ~large, "small spin": ~large, "large spin": large}
    for name, method in methods.items():
        judge(name, functools.partial(method, patch, rows, (a, b)), full, kinds)


def by_interpenetration(gap: np.ndarray, force: float, quick: Any) -> mtb.NormalResult:
    return mtb.solve_normal(gap, 3e-4, lower=body, upper=body, force=force, method=quick)


def pressed_and_rolled(gap: np.ndarray, force: float, quick: str, curve: Any, rows: np.ndarray) -> np.ndarray:
    return np.asarray(curve(by_interpenetration(gap, force, quick), rows, law))


# a new wheel on a new rail, whose patches are no ellipses: on the tread, and beside the flange
for lateral in (0.0, 1e-3, 2e-3, 3e-3, 4e-3, 6.2e-3):
    pressed = mtb.scenes.wheel_on_rail(
        lateral=lateral, force=8e4, spacing=3e-4, upper=body, lower=body
    ).solve(model="half-space")
    spacing = (3e-4, 3e-4)
    whole = mtb.PressureField(pressed.pressure, spacing, body, body)
    _, patch = max(whole.patches(), key=lambda part: part[1].normal_force)
    rows = creepages(arguments.cases // 8, *patch.semi_axes(), patch.normal_force)
    full = mtb.creep_curve(whole, rows, law, order=2)[:, :2]
    every = {"real profiles": np.ones(len(rows), dtype=bool)}
    for name, method in methods.items():
        judge(name, functools.partial(method, whole, rows, None), full, every)
    gap, force = pressed.initial_gap, pressed.normal_force
    for quick in ("kpec", "analyn"):
        try:
            by_interpenetration(gap, force, quick)
        except ValueError as refused:
            print(f"{quick} at {lateral:g} m: {refused}")
            continue
        for name, curve in (
            ("full", mtb.creep_curve),
            ("FASTSIM", mtb.fastsim_curve),
            ("FaStrip", mtb.fastrip_curve),
        ):
            both = functools.partial(pressed_and_rolled, gap, force, quick, curve, rows)
            judge(f"{quick.upper()} and {name}", both, full, every)

lines = []
for (name, kind), values in errors.items():
    e = np.array(values)
    shares = [np.mean(e < 0.1), np.mean(e > 0.2), np.median(e), np.quantile(e, 0.95)]
    shares.append(1e6 * np.mean(times[name, kind]))
    columns = ("within_10_percent", "beyond_20_percent", "median", "p95", "microseconds")
    row = {"method": name, "creepages": kind, "cases": len(e)}
    lines.append(row | {c: f"{value:.4g}" for c, value in zip(columns, shares, strict=True)})
    print(f"{name:20s} {kind:10s} {len(e):4d}: " + "  ".join(f"{value:7.3g}" for value in shares))
records.write(arguments.output / "creep_force_errors.csv", lines)
shown = {
    "FASTSIM parabolic": "#1f77b4",
    "FASTSIM blended": "#17becf",
    "FASTSIM elliptic": "#7f7f7f",
    "FaStrip": "#d62728",
    "FaStrip, direction of CONTACT": "#ff9896",
    "Polach": "#2ca02c",
    "table": "#000000",
    "KPEC and full": "#9467bd",
    "ANALYN and full": "#8c564b",
    "KPEC and FASTSIM": "#e377c2",
}
figure, axes = plt.subplots(1, 3, figsize=(10.2, 4.6), sharey=True)
for axis, kind in zip(axes, ("small spin", "large spin", "real profiles"), strict=True):
    for name, colour in shown.items():
        if (name, kind) in errors:
            e = np.sort(errors[name, kind])
            style = "--" if " and " in name else "-"
            axis.semilogx(100 * e, 100 * np.arange(1, e.size + 1) / e.size, style, color=colour, label=name)
    axis.axvline(10, color="#777777", lw=1, ls=":")
    count = len(errors["Polach", kind])
    where = "" if kind == "real profiles" else "ellipses, "
    axis.set(title=f"{where}{kind}, {count} cases", xlabel="error of the force vector [%]", xlim=(0.03, 200))
    axis.set_xticks([0.1, 1, 10, 100], ["0.1", "1", "10", "100"])
axes[0].set_ylabel("cases with a smaller error [%]")
figure.legend(*axes[2].get_legend_handles_labels(), loc="outside lower center", ncols=4)
figure.savefig(arguments.output / "creep_force_errors.png")
