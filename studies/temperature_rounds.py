# SPDX-License-Identifier: MIT OR Apache-2.0
"""Friction that falls with the temperature, gently to within 2 K: rounds, convolutions, what is not found.

Random creepages and speeds on one ellipse; convolutions are over those of Coulomb's friction.
"""

import warnings

import numpy as np

import mtb_rs as mtb

warnings.simplefilter("ignore")
contact = mtb.hertz(80e3, semi_axes=(6e-3, 5e-3), lower=mtb.steel, upper=mtb.steel)
patch = contact.on_grid((40, 40), (0.35e-3, 0.3e-3))
rng = np.random.default_rng(1)
for temperature, coefficient in (
    ([0.0, 400.0], [0.33, 0.14]),
    ([40.0, 55.0], [0.5, 0.1]),
    ([100.0, 115.0], [0.5, 0.1]),
    ([200.0, 215.0], [0.5, 0.1]),
    ([100.0, 105.0], [0.5, 0.1]),
    ([60.0, 62.0], [0.5, 0.1]),
):
    law = mtb.TemperatureFriction(temperature, coefficient)
    rounds, convolutions, lost = [], [], 0
    for _ in range(40):
        creepage = rng.normal(size=3) * 10.0 ** rng.uniform(-3.5, -1.7) * np.array([1.0, 1.0, 100.0])
        motion = mtb.Rolling(tuple(creepage), velocity=10.0 ** rng.uniform(0.5, 1.8))
        plain = mtb.solve_tangential(patch, motion, mtb.Coulomb(coefficient[0])).report
        try:
            report = mtb.solve_tangential(patch, motion, law).report
        except mtb.ConvergenceError:
            lost += 1
            continue
        rounds.append(int(report.method.rpartition(", ")[2].split()[0]))
        convolutions.append(report.convolutions / plain.convolutions)
    print(
        f"{coefficient[0]} to {coefficient[1]} from {temperature[0]:g} to {temperature[1]:g} K: rounds",
        *(f"{value:.0f}" for value in np.percentile(rounds, [50, 95, 100])),
        "at 50, 95, 100 %, convolutions",
        *(f"{value:.1f}" for value in np.percentile(convolutions, [50, 95, 100])),
        f"times those of Coulomb, {lost} of 40 not found",
    )
