# SPDX-License-Identifier: MIT OR Apache-2.0
"""Where a thin layer of springs is wrong: thickness over contact radius x Poisson's ratio.

A rigid sphere is pressed by one approach into a layer that is bonded to a rigid base (`Layered`). Shown is
the error of the largest pressure that springs of the flexibility of `ThinLayer` have under the same force, in
percent. The radius is that of the contact with springs. Above a Poisson's ratio of 0.45 `ThinLayer` refuses.
"""

import numpy as np
from atlas import draw_verdicts, panels, write

import mtb_rs as mtb

names = ("within 5 %", "within 20 %", "wrong")
colours = ("#56B4E9", "#E69F00", "#CC79A7")
ratios = [0.0, 0.2, 0.3, 0.4, 0.45, 0.49, 0.5]
thicknesses = [0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1.0, 2.0]
modulus, curvature = 3e9, 1.0
#: Approach of the sphere [m], the least number of cells over the contact radius of springs, and of cells
#: over the thickness.
approach, least, through = 1e-7, 40, 1.2


def peaks(nu: float, share: float) -> tuple[float, float]:
    """Largest pressure [Pa] on the layer of finite thickness, and on springs at its force."""
    contact = np.sqrt(2.0 * approach / curvature)
    h = share * contact
    if nu == 0.5:
        # springs do not give way at all
        return float("nan"), float("inf")
    cells = max(least, round(through / share))
    step = contact / cells
    x = (np.arange(3 * cells) - 0.5 * (3 * cells - 1)) * step
    gap = 0.5 * curvature * (x[None, :] ** 2 + x[:, None] ** 2)
    body = mtb.Layered(mtb.Material(modulus, nu), h, mtb.Rigid())
    whole = mtb.solve_normal(gap, step, lower=body, upper=mtb.Rigid(), approach=approach)
    flexibility = h * (1.0 + nu) * (1.0 - 2.0 * nu) / ((1.0 - nu) * modulus)
    # springs carry pi R d^2 / L, and L times the peak is the approach d
    peak = np.sqrt(whole.normal_force * curvature / (np.pi * flexibility))
    return float(whole.pressure.max()), float(peak)


if __name__ == "__main__":
    figure, axes = panels(1, height=4.0)
    rows = []
    errors = np.zeros((len(ratios), len(thicknesses)))
    for (j, i), _ in np.ndenumerate(errors):
        finite, springs = peaks(ratios[j], thicknesses[i])
        errors[j, i] = springs if np.isinf(springs) else springs / finite - 1.0
        rows.append(
            {
                "poisson_ratio": ratios[j],
                "thickness_over_radius": thicknesses[i],
                "peak_layered": finite,
                "peak_thin": springs,
                "error": float(errors[j, i]),
            }
        )
    size = np.abs(errors)
    codes = np.where(size <= 0.05, 0, np.where(size <= 0.2, 1, 2))
    texts = np.array([["∞" if np.isinf(e) else f"{round(100 * e)}" for e in line] for line in errors])
    draw_verdicts(axes[0], thicknesses, ratios, codes, names=names, colours=colours, texts=texts)
    axes[0].set(xlabel="thickness over contact radius", ylabel="Poisson's ratio")
    write("thin_layer", figure, rows)
