# SPDX-License-Identifier: MIT OR Apache-2.0
"""Rough layer over its stiffness: where it is solved, what it costs, and where a linear layer does as well.

Usage: python studies/rough_layer.py. Takes about a minute. A rigid ball is pressed on a steel half-space by
one force. The linear layer beside it has the slope of the rough one at the mean pressure of Hertz.
"""

import warnings

import numpy as np
from atlas import GOOD, TOLD, draw_verdicts, panels, write

import mtb_rs as mtb

#: Length of the law over the approach of Hertz, and its pressure at no distance over the mean one.
LENGTHS = (0.003, 0.01, 0.03, 0.1)
PRESSURES = (10.0, 30.0, 100.0, 300.0, 1000.0, 1e4)
N, RADIUS, FORCE = 129, 10e-3, 100.0

# a ball of one centimetre would yield: only the ratios matter
warnings.simplefilter("ignore")
hertz = mtb.hertz(FORCE, RADIUS, lower=mtb.steel, upper=mtb.Rigid())
mean = FORCE / (np.pi * hertz.semi_axes[0] * hertz.semi_axes[1])
x = np.linspace(-1.0, 1.0, N) * 3.0 * hertz.semi_axes[0]
gap = (x[:, None] ** 2 + x**2) / (2.0 * RADIUS)


def pressed(layer: mtb.RoughLayer | float) -> mtb.NormalResult:
    return mtb.solve_normal(
        gap, x[1] - x[0], force=FORCE, lower=mtb.steel, upper=mtb.Rigid(), normal_layer=layer
    )


def apart(one: mtb.NormalResult, other: mtb.NormalResult) -> float:
    difference = np.linalg.norm(one.pressure - other.pressure)
    return float(difference / np.linalg.norm(other.pressure))


rows = []
plain = pressed(0.0)
codes = np.full((len(PRESSURES), len(LENGTHS)), TOLD)
costs, linear_errors = np.full((2, *codes.shape), "", dtype=object)
for (j, i), _ in np.ndenumerate(codes):
    layer = mtb.RoughLayer.exponential(PRESSURES[j] * mean, LENGTHS[i] * hertz.approach)
    step = 1e-4 * mean
    slope = float(layer.opening(mean + step) - layer.opening(mean - step)) / (2.0 * step)
    row = {"pressure_over_mean": PRESSURES[j], "length_over_approach": LENGTHS[i]}
    try:
        rough = pressed(layer)
    except mtb.ConvergenceError as error:
        rough = error.result
    else:
        codes[j, i] = GOOD
    cost = rough.report.convolutions / plain.report.convolutions
    error = apart(pressed(slope), rough)
    costs[j, i] = f"{cost:.0f} x"
    if codes[j, i] == GOOD:
        linear_errors[j, i] = f"{100 * error:.1f} %"
    rows.append(
        {
            **row,
            "solved": bool(codes[j, i] == GOOD),
            "convolutions_over_those_without": cost,
            "residual": rough.report.residual,
            "change_by_the_layer": apart(plain, rough),
            "error_of_a_linear_layer": error,
        }
    )
figure, axes = panels(2)
names = ("solved", "does not converge, and says so", "")
for place, texts, title in zip(
    axes,
    (costs, linear_errors),
    ("convolutions over those without a layer", "error of the pressure by a linear layer"),
    strict=True,
):
    draw_verdicts(place, LENGTHS, PRESSURES, codes, names=names, texts=texts)
    place.set(xlabel="length of the law over the approach", ylabel="pressure of the law over the mean one")
    place.set_title(title)
write("rough_layer", figure, rows)
