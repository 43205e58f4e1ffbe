# SPDX-License-Identifier: MIT OR Apache-2.0
"""How fine must the contact grid be? The basic model on 6, 3 and 1.5 mm: thesis Table C.1, Figs C.1, C.2."""

from __future__ import annotations

import time

import numpy as np
from comparison import Array, Field, of_result, write_table
from drawing import DISPLACEMENT, LINES, PRESSURE, cuts, output, save

import mtb_rs as mtb

#: Thesis Table C.1: spacing [m], points on the rail and time [s].
THESIS = {6e-3: (434, 20), 3e-3: (1586, 252), 1.5e-3: (6050, 11632)}


def main() -> None:
    folder = output(__doc__)
    fields: list[Field] = []
    rows = []
    for spacing in (*THESIS, 0.75e-3):
        scene = mtb.scenes.pole_shoe_on_rail(length=96e-3, spacing=spacing)
        clock = time.perf_counter()
        result = scene.solve(model="half-space")
        seconds = time.perf_counter() - clock
        fields.append(of_result(result, f"{1e3 * spacing:g} mm"))
        rows.append(
            [f"{1e3 * spacing:g}", result.pressure.size, f"{seconds:.2f}", *THESIS.get(spacing, ("", ""))]
        )
    finest, (bx, by) = fields[-1], fields[0].borders()
    for row, field in zip(rows, fields, strict=True):
        # means of the finest grid over the cells of each, away from the border cells of the coarsest
        inner = np.ix_(
            (by[1] < field.y) & (field.y < by[-2]),
            (bx[1] < field.x) & (field.x < bx[-2]),
        )
        p, u = (over_cells(finest, v, field)[inner] for v in (finest.pressure, finest.displacement))
        row.insert(2, f"{100 * np.mean(np.abs(field.pressure[inner] - p)) / p.mean():.2f}")
        row.insert(3, f"{100 * np.mean(np.abs(field.displacement[inner] - u)) / np.abs(u).mean():.2f}")
        print(*row)
    header = ["spacing_mm", "points", "pressure_difference_to_finest_percent"]
    header += ["displacement_difference_to_finest_percent", "seconds"]
    write_table(folder / "table_C_1.csv", [*header, "thesis_points_on_rail", "thesis_seconds"], rows)
    styles = [{**s, "marker": "o", "markersize": 2} for s in LINES[:3]] + [LINES[6]]
    for quantity, name in ((PRESSURE, "fig_C_1"), (DISPLACEMENT, "fig_C_2")):
        figure = cuts(
            fields, quantity, (7.6e-3, 12e-3), styles, title="half-spaces, friction 0.5, four grids"
        )
        figure.axes[0].set_ylim(*((0.0, 12.0) if quantity is PRESSURE else (None, None)))
        save(figure, folder, name)


def over_cells(fine: Field, values: Array, coarse: Field) -> Array:
    """Means of `values` (ny, nx) on the cells of one grid over the cells of another."""
    for axis, (own, other) in enumerate(zip(fine.borders(), coarse.borders(), strict=True)):
        lines = np.moveaxis(values, 1 - axis, -1)
        total = np.concatenate(
            [np.zeros_like(lines[..., :1]), np.cumsum(lines * np.diff(own), axis=-1)], axis=-1
        )
        at = np.array([np.interp(other, own, line) for line in total])
        values = np.moveaxis(np.diff(at, axis=-1) / np.diff(other), -1, 1 - axis)
    return values


if __name__ == "__main__":
    main()
