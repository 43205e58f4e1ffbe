# SPDX-License-Identifier: MIT OR Apache-2.0
"""What rolling of second order gives: errors of forces over the cells and the time, without and with a layer.

Usage: python studies/second_order.py. Takes two minutes. Random elliptic contacts between half-spaces,
anywhere on their cells, with random creepages and spin up to full slip; errors of forces over friction
coefficient times normal force, against second order on the finest cells. Times are processor times of the
tangential problem over the shortest one.
"""

import time

import numpy as np
from atlas import panels, write

import mtb_rs as mtb

STEEL = mtb.Material(210e9, 0.28)
FRICTION, FORCE = 0.3, 60e3
#: Cells over the smaller semi-axis; the last ones are the truth.
CELLS = (2, 3, 4, 6, 8, 12, 16, 32)
COUNT = 24
#: Flexibility of the layer over that of the bodies, h / G over a / G of steel.
LAYERS = (0.0, 0.1, 1.0)
COLOURS = {1: "#0072B2", 2: "#D55E00"}

random = np.random.default_rng(7)
contacts = []
for _ in range(COUNT):
    ratio = np.exp(random.uniform(-1.0, 1.0))
    contacts.append((ratio, random.uniform(-0.5, 0.5, 2), random.normal(size=3), random.uniform(0.1, 2.0)))

rows = []
for layer in LAYERS:
    for k, (ratio, place, direction, size) in enumerate(contacts):
        radii = 0.4 * ratio, 0.4 / ratio
        hertz = mtb.hertz(FORCE, radii, STEEL, STEEL)
        a, b = hertz.semi_axes
        # what slips all over, so many times: creepages over mu c / rho, spin over that of a
        unit = FRICTION * hertz.approach / np.sqrt(a * b)
        creepage = size * direction / np.linalg.norm(direction) * [unit, unit, unit / np.sqrt(a * b)]
        made = mtb.InterfaceLayer(layer * a, STEEL.shear_modulus) if layer else None
        found = {}
        for cells in CELLS[::-1]:
            cell = min(a, b) / cells
            n = [int(np.ceil(1.3 * half / cell)) + 1 for half in (a, b)]
            x, y = (np.arange(-n[c], n[c] + 1) * cell + place[c] * cell for c in (0, 1))
            gap = np.add.outer(y**2 / (2.0 * radii[1]), x**2 / (2.0 * radii[0]))
            normal = mtb.solve_normal(gap, cell, lower=STEEL, upper=STEEL, force=FORCE)
            xi, eta, phi = creepage
            # about the middle of the contact
            own = xi - phi * place[1] * cell, eta + phi * place[0] * cell, phi
            for order in (1, 2):
                motion = mtb.Rolling(own, order=order)
                mtb.solve_tangential(normal, motion, mtb.Coulomb(FRICTION), made)
                began = time.process_time()
                result = mtb.solve_tangential(normal, motion, mtb.Coulomb(FRICTION), made)
                spent = time.process_time() - began
                found[order, cells] = np.asarray(result.force)[:2] / (FRICTION * FORCE), spent
        truth, _ = found[2, CELLS[-1]]
        for (order, cells), (force, spent) in found.items():
            error = float(np.abs(force - truth).max())
            rows.append(
                {
                    "layer": layer, "contact": k, "order": order, "cells": cells, "error": error,
                    "time": spent,
                }
            )  # fmt: skip
shortest = min(row["time"] for row in rows)
for row in rows:
    row["time"] /= shortest


def picked(name, order, cells, layer):
    return [row[name] for row in rows if (row["order"], row["cells"], row["layer"]) == (order, cells, layer)]


figure, (bare, timed, layered) = panels(3, columns=3)
for order, colour in COLOURS.items():
    word = "first" if order == 1 else "second"
    coarse = CELLS[:-1]
    for share, line in ((50, "o-"), (95, "s--")):
        errors = [100.0 * np.percentile(picked("error", order, cells, 0.0), share) for cells in coarse]
        name = f"{word} order, " + ("median" if share == 50 else "95 %")
        bare.loglog(coarse, errors, line, color=colour, label=name)
    times = [np.median(picked("time", order, cells, 0.0)) for cells in coarse]
    errors = [100.0 * np.median(picked("error", order, cells, 0.0)) for cells in coarse]
    timed.loglog(times, errors, "o-", color=colour, label=f"{word} order")
    for layer, line in ((0.1, "o-"), (1.0, "^:")):
        errors = [100.0 * np.median(picked("error", order, cells, layer)) for cells in coarse]
        layered.loglog(coarse, errors, line, color=colour, label=f"{word}, h = {layer:g} a")
bare.set(xlabel="cells over the smaller semi-axis", ylabel="error of force [%]", title="no layer")
timed.set(xlabel="processor time, over the shortest", title="no layer")
layered.set(xlabel="cells over the smaller semi-axis", title="layers of thickness h")
for axes in (bare, layered):
    axes.set_xticks(CELLS[:-1], [f"{cells:g}" for cells in CELLS[:-1]])
    axes.set_xticks([], minor=True)
timed.set_xticks([1, 2, 5, 10], ["1", "2", "5", "10"])
timed.set_xticks([], minor=True)
for axes in (bare, timed, layered):
    axes.legend(fontsize=6)
write("second_order", figure, rows)
for layer in LAYERS:
    for cells in CELLS[:-1]:
        told = [
            f"{100.0 * np.percentile(picked('error', order, cells, layer), share):.2f}"
            for order in (1, 2)
            for share in (50, 95)
        ]
        print(f"h = {layer:g} a, {cells} cells: {' '.join(told)}")
