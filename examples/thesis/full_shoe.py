# SPDX-License-Identifier: MIT OR Apache-2.0
"""The full pole shoe held at nine points: friction and magnetic load varied: thesis chapter 4 and D.

The dimensions of the thesis' full shoe are not printed. Assumed here: two poles, each 96 mm long, from
|y| = 6 to 36 mm, 100 mm high above the crown; five points along the middle of the top share one height and
cannot move along y, four points across the rear end cannot move along x (thesis Fig. 4.4). Rail: half-space.
"""

from __future__ import annotations

import time
from pathlib import Path
from typing import Any

import numpy as np
from comparison import Field, of_result, write_table
from drawing import (
    DISPLACEMENT,
    LINES,
    MEGA,
    MM,
    PRESSURE,
    canvas,
    caption,
    draw_map,
    edge_of_contact,
    legend,
    output,
    save,
)

import mtb_rs as mtb
from mtb_rs.pictures.quantities import INK, LINE_COLOURS

LENGTH, HEIGHT, PEAK = 96e-3, 100e-3, 3e6
#: Thesis Table 4.1: friction coefficient and its time [s].
THESIS_SECONDS = {0.5: 494, 0.4: 648, 0.3: 816, 0.25: 940, 0.2: 998, 0.1: 1057}
#: Thesis (4.1): c_x half the length, at the rear; the widths are not printed, 0.4 of each side is assumed.
GAUSSIAN = mtb.GaussianPressure(PEAK, center=(-0.5 * LENGTH, 13.8e-3), sigma=(0.4 * LENGTH, 6.2e-3))


def wavy(x: Any, y: Any) -> Any:
    """Another load: strong at the front of the inner edge, weak in between."""
    return PEAK * (0.6 + 0.4 * np.cos(2.0 * np.pi * x / LENGTH) * np.exp(-(np.abs(y) - 6e-3) / 10e-3))


def scene(friction: float, magnetic_pressure: Any = PEAK, supports: str = "points") -> mtb.Scene:
    return mtb.scenes.pole_shoe_on_rail(
        height=HEIGHT,
        length=LENGTH,
        friction=friction,
        magnetic_pressure=magnetic_pressure,
        supports=supports,
    )


def main() -> None:
    folder = output(__doc__)
    scene(0.5).solve(model="elastic-upper")  # condenses the shoe, for all that follows
    sweep: dict[float, Field] = {}
    rows = []
    for friction, theirs in THESIS_SECONDS.items():
        clock = time.perf_counter()
        result = scene(friction).solve(model="elastic-upper")
        seconds = time.perf_counter() - clock
        sweep[friction] = of_result(result, f"friction {friction:g}")
        share = result.report.contact_area / float(result.area.sum())
        pinned = scene(friction, supports="fixed-points").solve(model="elastic-upper")
        rows.append([friction, f"{100 * share:.1f}", f"{result.normal_force:.1f}"])
        rows[-1] += [f"{pinned.normal_force:.1f}", f"{result.report.wedging_margin:.3f}"]
        rows[-1] += [f"{seconds:.2f}", theirs]
        print(*rows[-1])
    header = ["friction", "area_in_contact_percent", "normal_force_N", "normal_force_points_fixed_N"]
    write_table(folder / "table_4_1.csv", [*header, "wedging_margin", "seconds", "thesis_seconds"], rows)

    status(folder, sweep)
    for friction, names in ((0.5, ("fig_4_2", "fig_4_3")), (0.25, ("fig_D_2", "fig_D_3"))):
        fields = [sweep[friction]]
        for quantity, name in zip((PRESSURE, DISPLACEMENT), names, strict=True):
            save(relief(fields, quantity, f"full shoe, friction {friction:g}"), folder, name)
    loads: list[list[Any]] = []
    for load, names, title in (
        (
            GAUSSIAN,
            ("fig_4_5", "fig_4_6"),
            "magnetic pressure a Gauss function with its peak at the rear",
        ),
        (
            wavy,
            ("fig_D_4", "fig_D_5"),
            "magnetic pressure strongest amid the inner edge",
        ),
    ):
        clock = time.perf_counter()
        result = scene(0.2, load).solve(model="elastic-upper")
        seconds = time.perf_counter() - clock
        field = of_result(result, "friction 0.2")
        share = result.report.contact_area / float(result.area.sum())
        loads.append([title, 0.2, f"{100 * share:.1f}", f"{result.normal_force:.1f}"])
        loads[-1] += [f"{seconds:.2f}", 942 if load is GAUSSIAN else ""]
        print(*loads[-1])
        for quantity, name in zip((PRESSURE, DISPLACEMENT), names, strict=True):
            save(relief([field], quantity, f"{title}; friction 0.2", load), folder, name)
    header = ["load", "friction", "area_in_contact_percent", "normal_force_N", "seconds", "thesis_seconds"]
    write_table(folder / "table_4_2.csv", header, loads)


def status(folder: Path, sweep: dict[float, Field]) -> None:
    """Thesis Fig. 4.1: open on the left of each line, sliding contact on its right."""
    figure, ax = canvas(1, 1, (7.2, 2.9))
    for (friction, field), colour in zip(sweep.items(), LINE_COLOURS, strict=False):
        edge_of_contact(ax, field, f"friction {friction:g}", colors=colour, linewidths=1.6)
    ax.set_xlim(-48.0, 48.0)
    ax.set_ylim(6.0, 21.7)
    caption(ax, "edge of contact, left pole", "x [mm], sliding to the right", "y [mm]", grid=False)
    legend(ax, loc="center right")
    save(figure, folder, "fig_4_1")


def relief(fields: list[Field], quantity: tuple[str, str, float], title: str, load: Any = None) -> Any:
    """A map of the left pole over cuts along x; with the load, if it is not constant."""
    name, label, unit = quantity
    (field,) = fields
    figure, (top, below) = canvas(2, 1, (7.2, 4.6), sharex=True, height_ratios=(1, 1.5))
    values = getattr(field, name) / unit
    high = float(np.percentile(values, 97)) if name == "pressure" else float(values.max())
    low = 0.0 if name == "pressure" else float(values.min())
    shown = draw_map(top, field, values, vmin=low, vmax=high)
    edge_of_contact(top, field, colors="white", linewidths=1.2)
    caption(top, f"{title}; left pole", y="y [mm]", grid=False)
    bar = figure.colorbar(
        shown, ax=top, extend="max" if values.max() > 1.01 * high else "neither", aspect=9, pad=0.02
    )
    bar.set_label(label, fontsize=8.5, color=INK)
    for y, style in zip((7.5e-3, 13.8e-3, 20e-3), LINES, strict=False):
        below.plot(field.x / MM, field.cut(values, y), **style, label=f"y = {y / MM:g} mm")
        if load is not None and name == "pressure":
            pull = load(field.x, y + 0.0 * field.x) / MEGA
            below.plot(field.x / MM, pull, ls=":", lw=1.2, color=style["color"])
    if load is not None and name == "pressure":
        below.plot([], [], ls=":", lw=1.2, color=INK, label="magnetic pressure there")
    if name == "pressure":
        highest = 1.25 * field.pressure[1:-1, 1:-1].max() / unit
        if load is not None:
            highest = max(highest, 1.05 * PEAK / MEGA)
        below.set_ylim(0.0, highest)
    caption(below, "cuts", "x [mm], sliding to the right", label)
    legend(below, ncols=2)
    return figure


if __name__ == "__main__":
    main()
