# SPDX-License-Identifier: MIT OR Apache-2.0
"""How far do half-spaces carry? Pole shoes of four heights against finite elements: thesis 3.1.2, 3.2.2, B.

The shoe is driven at its top. Two ways to hold this top are compared, as the thesis does not say how its
benchmark did:

- free: u_z of the top is free, the rail is one of finite section. The references of 7.45 and 28.2 mm are
  CalculiX' (tests/data/fe), those of 0.5 and 1.15 mm this package's own, both bodies elastic;
- level: the top moves along z as a whole, the rail is a half-space. All references are this package's own.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from comparison import Field, errors, of_finite_elements, of_result, write_table
from drawing import (
    DISPLACEMENT,
    LINES,
    MM,
    PRESSURE,
    REFERENCE,
    canvas,
    caption,
    cuts,
    draw_map,
    maps,
    output,
    save,
)
from matplotlib.colors import ListedColormap
from matplotlib.patches import Patch

import mtb_rs as mtb
from mtb_rs.pictures.quantities import INK, LINE_COLOURS

SPACING, FINE = 3e-3, (2e-3, 1.95e-3)
LEVEL = (mtb.Support("top", x=0.0, y=0.0, z=mtb.Guide(0.0)),)
#: Height of the shoe above the crown [m]: CalculiX reference, length of its rail [m].
CASES: dict[float, tuple[str | None, float]] = {
    0.5e-3: (None, 0.18),
    1.15e-3: (None, 0.18),
    7.45e-3: ("shoe_xi7_ny8_zfree", 0.18),
    28.2e-3: ("shoe_xi28_ny8_zfree_L600", 0.6),
}
MODELS = {
    "half-space": "half-spaces (basic)",
    "elastic-upper": "shoe elastic",
    "elastic-both": "shoe and rail elastic",
}
#: How the top is held, and the models compared with that reference.
TOPS = {"free": ("half-space", "elastic-upper", "elastic-both"), "level": ("half-space", "elastic-upper")}
TWO, FOUR = (7.95e-3, 13.8e-3), (7.95e-3, 11.85e-3, 15.75e-3, 19.65e-3)
#: Thesis Tables 3.4 and 3.7: error of pressure and of displacement, of its basic and extended model.
THESIS = {
    (0.5e-3, "half-space"): (0.0809, 0.0559),
    (1.15e-3, "half-space"): (0.0998, 0.0577),
    (7.45e-3, "half-space"): (0.2229, 0.0758),
    (28.2e-3, "half-space"): (0.4589, 0.1169),
    (28.2e-3, "elastic-both"): (0.1673, 0.0237),
}


def solve(
    height: float, model: str, spacing: float | tuple[float, float] = SPACING, top: str = "free"
) -> mtb.Result:
    scene = mtb.scenes.pole_shoe_on_rail(
        height=height,
        length=96e-3,
        spacing=spacing,
        rail_length=CASES[height][1],
        supports=LEVEL if top == "level" else "driven-top",
    )
    return scene.solve(model=model)


def reference(height: float, top: str) -> Field:
    if top == "level":
        return of_result(solve(height, "elastic-upper", FINE, top), "own reference, level top, 2 mm")
    name, _ = CASES[height]
    if name is not None:
        return of_finite_elements(name, "reference: CalculiX, free top")
    return of_result(solve(height, "elastic-both", FINE), "own reference, free top, 2 mm")


def main() -> None:
    folder = output(__doc__)
    references = {(height, top): reference(height, top) for height in CASES for top in TOPS}
    fields: dict[tuple[float, str, str], Field] = {}
    rows = []
    for height in CASES:
        for top, models in TOPS.items():
            for model in models:
                field = of_result(solve(height, model, top=top), MODELS[model])
                fields[height, top, model] = field
                e = errors(field, references[height, top])
                theirs = [f"{100 * v:.2f}" for v in THESIS.get((height, model), ())] or ["", ""]
                kind = "CalculiX" if CASES[height][0] and top == "free" else "own"
                ours = [f"{100 * v:.2f}" for v in (e.pressure, e.displacement, e.tilt)]
                rows.append([f"{height / MM:g}", top, model, kind, *ours, e.compared, e.excluded])
                rows[-1] += theirs
                print(*rows[-1])
    measures = ("pressure_error", "displacement_error", "displacement_shape_error")
    header = ["height_mm", "top", "model", "reference", *(f"{m}_percent" for m in measures)]
    header += ["points_compared", "points_excluded", "thesis_pressure_percent", "thesis_displacement_percent"]
    write_table(folder / "table_3_4_and_3_7.csv", header, rows)
    verify_own(folder, references)
    sketch(folder)

    for height, names in (
        (1.15e-3, ("3_6", "3_7", "3_8", "3_9")),
        (28.2e-3, ("3_10", None, "3_11", None)),
        (7.45e-3, ("B_3", None, "B_4", None)),
    ):
        basic = fields[height, "free", "half-space"]
        compare(folder, basic, [references[height, top] for top in TOPS], height, names)
    extended = [fields[28.2e-3, "free", m] for m in MODELS] + [references[28.2e-3, "free"]]
    for quantity, name in ((PRESSURE, "fig_3_17"), (DISPLACEMENT, "fig_3_18")):
        figure = cuts(extended, quantity, FOUR, [*LINES[:3], REFERENCE], title="height 28.2 mm, friction 0.5")
        if quantity is PRESSURE:
            figure.axes[0].set_ylim(0.0, 15.0)
        save(figure, folder, name)
    ten_percent(folder, references, fields)
    error_maps(folder, references[1.15e-3, "level"], fields[1.15e-3, "level", "half-space"])


def sketch(folder: Path) -> None:
    """Thesis Fig. 3.5: what touches what, in the section and from the side."""
    shoe = mtb.PoleShoe()
    rail, stations = shoe.profile, np.linspace(shoe.inner_edge, shoe.outer_edge, 60)
    y = np.linspace(-36e-3, 36e-3, 400)
    figure, (section, side) = canvas(1, 2, (8.6, 3.0), width_ratios=(80.0, 150.0), sharey=True)
    section.fill_between(y / MM, rail.height(y) / MM, -22.0, color=LINE_COLOURS[0], alpha=0.25, lw=0)
    section.plot(y / MM, rail.height(y) / MM, color=LINE_COLOURS[0])
    for sign in (1.0, -1.0):
        sole = shoe.sole(stations)
        section.fill_between(sign * stations / MM, sole / MM, 28.2, color=LINE_COLOURS[1], alpha=0.25, lw=0)
        worn = stations <= shoe.conforming_to
        section.plot(sign * stations[worn] / MM, sole[worn] / MM, color="black", lw=2.2)
    section.text(0.0, -15.0, "rail 60E1", ha="center", fontsize=9, color=LINE_COLOURS[0])
    for x in (-21.0, 21.0):
        section.text(x, 20.0, "pole", ha="center", fontsize=9, color=LINE_COLOURS[1])
    section.text(0.0, 2.2, "contact\n|y| = 6 to 21.6 mm", ha="center", fontsize=8.5)
    side.fill_between([-60, 60], [0, 0], -22.0, color=LINE_COLOURS[0], alpha=0.25, lw=0)
    side.fill_between([-48, 48], [28.2, 28.2], 0.0, color=LINE_COLOURS[1], alpha=0.25, lw=0)
    for height, colour in zip(CASES, LINE_COLOURS, strict=False):
        side.plot([-48, 48], [height / MM] * 2, color=colour, lw=1.2, ls="--")
        above = 3.0 if height == 1.15e-3 else 0.0
        side.text(
            49.0, height / MM + above, f"driven at {height / MM:g} mm", fontsize=8, color=colour, va="center"
        )
    arrow = {"arrowstyle": "-|>", "color": INK, "lw": 1.5}
    side.annotate("", (30.0, 33.0), (-10.0, 33.0), arrowprops=arrow)
    side.text(31.0, 33.0, "slides", va="center", fontsize=9, color=INK)
    for x in np.linspace(-40.0, 40.0, 9):
        side.annotate("", (x, 0.3), (x, 6.0), arrowprops={**arrow, "lw": 0.8})
    side.text(0.0, 10.0, "magnetic pressure 3 MPa on the sole", ha="center", fontsize=8.5, color=INK)
    caption(section, "section", "y [mm]", "z [mm]", grid=False)
    caption(side, "from the side", "x [mm]", grid=False)
    side.set_xlim(-60.0, 90.0)
    for ax in (section, side):
        ax.set_aspect("equal")
        ax.set_ylim(-22.0, 37.0)
    save(figure, folder, "fig_3_5")


def verify_own(folder: Path, references: dict[tuple[float, str], Field]) -> None:
    """What the own references are worth: against CalculiX where there is one, and between two grids."""
    rows = []
    for height, (name, _) in CASES.items():
        fine = of_result(solve(height, "elastic-both", FINE), "")
        coarse = of_result(solve(height, "elastic-both"), "")
        for other, label in ((references[height, "free"], "CalculiX"), (coarse, "own, 3 mm")):
            if name or label != "CalculiX":
                e = errors(fine, other)
                rows.append([f"{height / MM:g}", label])
                rows[-1] += [f"{100 * v:.2f}" for v in (e.pressure, e.displacement)]
                print("own reference:", *rows[-1])
    header = ["height_mm", "compared_with", "pressure_difference_percent", "displacement_difference_percent"]
    write_table(folder / "own_references.csv", header, rows)


def compare(
    folder: Path, basic: Field, references: list[Field], height: float, names: tuple[str | None, ...]
) -> None:
    """The basic model beside the references: maps and cuts, or cuts alone."""
    title = f"height {height / MM:g} mm, friction 0.5"
    styles = [LINES[0], REFERENCE, {**REFERENCE, "color": LINE_COLOURS[1], "marker": "s"}]
    for quantity, first, second in ((PRESSURE, *names[:2]), (DISPLACEMENT, *names[2:])):
        figure = cuts([basic, *references], quantity, FOUR if second else TWO, styles, title=title)
        figure.axes[0].set_ylim(*((0.0, 12.0) if quantity is PRESSURE else (None, None)))
        save(figure, folder, f"fig_{second or first}")
        if second:
            figure = maps([basic, *references], quantity, (7.2, 5.0))
            figure.suptitle(title, x=0.01, ha="left", fontsize=10.5, color=INK)
            save(figure, folder, f"fig_{first}")


def ten_percent(
    folder: Path, references: dict[tuple[float, str], Field], fields: dict[tuple[float, str, str], Field]
) -> None:
    """Thesis Fig. 3.12: where the pressure is within 10 %; and the elastic models beside the basic one."""
    shown = [("level", "half-space"), ("free", "half-space"), ("free", "elastic-upper")]
    shown.append(("free", "elastic-both"))
    figure, axes = canvas(4, len(CASES), (7.4, 5.2), sharex=True, sharey=True)
    colours = ListedColormap([LINE_COLOURS[5], "#E4E4E4", LINE_COLOURS[4]])
    for row, (top, model) in zip(axes, shown, strict=True):
        for ax, height in zip(row, CASES, strict=True):
            field, ref = fields[height, top, model], references[height, top]
            p = ref.at(ref.pressure, field.x, field.y)
            off = (field.pressure - p) / np.maximum(p, 0.1 * ref.pressure.mean())
            draw_map(ax, field, np.clip(np.round(5.0 * off), -1.0, 1.0), cmap=colours, vmin=-1.5, vmax=1.5)
            ax.set_aspect("auto")
            share = float((np.abs(off)[1:-1, 1:-1] < 0.1).mean())
            head = f"{height / MM:g} mm high\n" if top == "level" else ""
            caption(ax, f"{head}{100 * share:.0f} % within", grid=False)
        row[0].set_ylabel(f"{MODELS[model].replace(' (', chr(10) + '(')}\n{top} top", fontsize=8.5, color=INK)
    for ax in axes[-1]:
        ax.set_xlabel("x [mm]", fontsize=9, color=INK)
    names = ("more than 10 % low", "within 10 % of the reference", "more than 10 % high")
    swatches = [Patch(color=c, label=n) for c, n in zip(colours.colors, names, strict=True)]
    figure.legend(handles=swatches, loc="outside lower center", ncols=3, frameon=False, fontsize=8.5)
    save(figure, folder, "fig_3_12")


def error_maps(folder: Path, ref: Field, basic: Field) -> None:
    """Thesis Figs B.1 and B.2."""
    for name, quantity, figure_name in (
        ("pressure", "pressure", "fig_B_1"),
        ("displacement", "vertical displacement", "fig_B_2"),
    ):
        wanted = ref.at(getattr(ref, name), basic.x, basic.y)
        off = 100.0 * (getattr(basic, name) - wanted) / np.abs(wanted)
        # the singular border sets no scale
        bound = float(np.abs(off[1:-1, 1:-1]).max())
        figure, ax = canvas(1, 1, (7.2, 2.3))
        shown = draw_map(ax, basic, off, cmap="RdBu_r", vmin=-bound, vmax=bound)
        caption(
            ax,
            f"{quantity} of half-spaces against the own reference with level top, height 1.15 mm",
            "x [mm]",
            "y [mm]",
            grid=False,
        )
        bar = figure.colorbar(shown, ax=ax, extend="both", aspect=14, pad=0.02)
        bar.set_label("relative error [%]", fontsize=9, color=INK)
        save(figure, folder, figure_name)


if __name__ == "__main__":
    main()
