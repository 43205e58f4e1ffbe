# SPDX-License-Identifier: MIT OR Apache-2.0
"""How good are FASTSIM, Polach and the table? Forces over random creepages against the full solution.

The error is the difference of the tangential force vectors over the size of the full one. The literature
states under 10 % for FASTSIM but for large spin, where more than 20 % occur in 15 to 20 % of cases
[Vollebregt2012]. Small and large spin are told apart at `phi sqrt(a b)` against the creepage.
"""

import argparse

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
table = mtb.CreepForceTable.build(ratios=ratios, poisson_ratio=0.28, nodes=11, cells=20)
methods = ("FASTSIM parabolic", "FASTSIM elliptic", "FASTSIM2 parabolic", "Polach", "table")
errors: dict[tuple[str, str], list[float]] = {}
curves = {name: [] for name in methods}
for ratio in ratios:
    a, b = 5e-3 * np.sqrt(ratio), 5e-3 / np.sqrt(ratio)
    patch = reference.elliptic_pressure(load, (a, b), (arguments.cells, arguments.cells), body, body)
    count = arguments.cases // len(ratios)
    rows = random.standard_normal((count, 3))
    rows /= np.linalg.norm(rows, axis=1)[:, None]
    # from a tenth of what friction carries to full sliding
    rows *= friction * load / (a * b * 82e9) * 10 ** random.uniform(-1.3, 1.0, (count, 1))
    rows[:, 2] /= np.sqrt(a * b)
    full = mtb.creep_curve(patch, rows, law)[:, :2]
    found = {
        "FASTSIM parabolic": mtb.fastsim_curve(patch, rows, law, semi_axes=(a, b))[:, :2],
        "FASTSIM elliptic": mtb.fastsim_curve(patch, rows, law, bound="elliptic", semi_axes=(a, b))[:, :2],
        "FASTSIM2 parabolic": mtb.fastsim_curve(patch, rows, law, order=2, semi_axes=(a, b))[:, :2],
        "Polach": mtb.polach(patch, rows, law, semi_axes=(a, b))[:, :2],
        "table": table.interpolate((a, b), load, 82e9, friction, rows)[:, :2],
    }
    spin = np.abs(rows[:, 2]) * np.sqrt(a * b)
    large = spin > np.hypot(rows[:, 0], rows[:, 1])
    for name, forces in found.items():
        error = np.linalg.norm(forces - full, axis=1) / np.linalg.norm(full, axis=1)
        for kind, chosen in (("all", large | ~large), ("small spin", ~large), ("large spin", large)):
            errors.setdefault((name, kind), []).extend(error[chosen])

table = []
for (name, kind), values in errors.items():
    e = np.array(values)
    shares = [np.mean(e < 0.1), np.mean(e > 0.2), np.median(e), np.quantile(e, 0.95)]
    columns = ("within_10_percent", "beyond_20_percent", "median", "p95")
    row = {"method": name, "creepages": kind, "cases": len(e)}
    table.append(row | {c: f"{value:.4f}" for c, value in zip(columns, shares, strict=True)})
    print(f"{name:20s} {kind:10s} {len(e):4d}: " + "  ".join(f"{100 * value:5.1f} %" for value in shares))
records.write(arguments.output / "creep_force_errors.csv", table)
figure, axes = plt.subplots(1, 2, figsize=(7.4, 4.4), sharey=True)
for axis, kind in zip(axes, ("small spin", "large spin"), strict=True):
    for name in methods:
        e = np.sort(errors[name, kind])
        axis.semilogx(100 * e, 100 * np.arange(1, e.size + 1) / e.size, label=name)
    axis.axvline(10, color="#777777", lw=1, ls=":")
    axis.set(title=f"{kind}, {e.size} cases", xlabel="error of the force vector [%]", xlim=(0.03, 200))
    axis.set_xticks([0.1, 1, 10, 100], ["0.1", "1", "10", "100"])
axes[0].set_ylabel("cases with a smaller error [%]")
figure.legend(*axes[0].get_legend_handles_labels(), loc="outside lower center", ncols=3)
figure.savefig(arguments.output / "creep_force_errors.png")
