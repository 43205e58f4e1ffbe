# SPDX-License-Identifier: MIT OR Apache-2.0
"""Sharp edges: rates of convergence under a flat punch, with and without its border cells, and of a
smooth sphere.

A square rigid punch has a pressure that grows beyond bounds at its edges; pointwise it never converges
there. Away from the border cells the rate comes back, force and approach do not suffer.
"""

import numpy as np
from atlas import panels, write

import mtb_rs as mtb
from mtb_rs.contact.estimate import GridField, difference
from mtb_rs.geometry.contact_points import Patch
from mtb_rs.geometry.geometries import centred

sides = [8, 16, 32, 64, 128]
fine, side = 768, 0.1
pair = {"lower": mtb.steel, "upper": mtb.Rigid(), "tolerance": 1e-9}


def solved(shape: str, n: int) -> tuple[GridField, float]:
    x = centred(n, side / n)
    gap = np.zeros((n, n)) if shape == "punch" else (x[None] ** 2 + x[:, None] ** 2) / (2 * 10.0)
    edge = "sharp" if shape == "punch" else "error"
    found = mtb.solve_normal(gap, side / n, force=2e5, edge=edge, **pair)
    patch = Patch("contact", 0, n, n, (side / n, side / n))
    return GridField([(patch, x, x)], found.pressure.ravel()), found.approach


rows = []
figure, (ax,) = panels(1, height=4.4)
series: dict[str, list[float]] = {}
for shape in ("punch", "sphere"):
    best, approach = solved(shape, fine)
    for n in sides:
        found, own = solved(shape, n)
        for skip in (False, True):
            if shape == "sphere" and skip:
                continue
            apart = difference(best, found, skip_border=skip)
            name = f"{shape}, pressure" + (", border left out" if skip else "")
            series.setdefault(name, []).append(float(apart or np.nan))
        series.setdefault(f"{shape}, approach", []).append(abs(own - approach) / approach)
marks = iter("osD^v")
for colour, (name, errors) in zip(
    ("#0072B2", "#56B4E9", "#000000", "#D55E00", "#E69F00"), series.items(), strict=True
):
    rate = -np.polyfit(np.log(sides), np.log(errors), 1)[0]
    ax.loglog(
        sides, 100 * np.array(errors), next(marks) + "-", color=colour, label=f"{name}: rate {rate:.2f}"
    )
    rows += [
        {"series": name, "cells_a_side": n, "error": e, "rate": float(rate)}
        for n, e in zip(sides, errors, strict=True)
    ]
ax.set(xlabel="cells a side", ylabel="error [%]", title=f"against {fine} x {fine} cells")
ax.legend()
write("sharp_edges", figure, rows)
