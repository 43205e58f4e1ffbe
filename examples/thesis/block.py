# SPDX-License-Identifier: MIT OR Apache-2.0
"""A block sliding on a plane against CalculiX, and why the thesis' block jams: 3.2.1, Figs 3.14-3.16, D.1.

The thesis' block (0.5 m high, friction 0.5) has no sliding equilibrium, so the comparison is made on blocks
of 0.05 and 0.1 m, for which tests/data/fe has references. All hang from a top that moves along x only.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from comparison import Field, errors, of_finite_elements, of_result, write_table
from drawing import (
    DISPLACEMENT,
    LINES,
    MICRO,
    MM,
    PRESSURE,
    REFERENCE,
    canvas,
    caption,
    edge_of_contact,
    legend,
    output,
    save,
)
from matplotlib.tri import Triangulation

import mtb_rs as mtb
from mtb_rs.pictures.quantities import INK, LINE_COLOURS

WIDTH, PULL, SPACING = 0.1, 3e6, 5e-3
#: Name of the reference: height [m], friction.
CASES = {"block_h050_he5": (0.05, 0.5), "block_h100_he5": (0.1, 0.5), "block_h100_he5_mu0": (0.1, 0.0)}


def solve(height: float, friction: float, model: str = "elastic-upper") -> mtb.Result:
    scene = mtb.scenes.block_on_plane(WIDTH, height, friction, PULL, SPACING)
    return scene.solve(model=model)


def main() -> None:
    folder = output(__doc__)
    results = {name: solve(*case) for name, case in CASES.items()}
    fields = {name: of_result(result, "block elastic") for name, result in results.items()}
    references = {name: of_finite_elements(name, "reference: CalculiX") for name in CASES}
    rows = []
    for name, (height, friction) in CASES.items():
        e, result = errors(fields[name], references[name]), results[name]
        area = np.outer(*(np.diff(b) for b in references[name].borders()[::-1]))
        theirs = float((references[name].pressure * area).sum())
        rows.append(
            [f"{height:g}", f"{friction:g}", f"{100 * e.pressure:.2f}", f"{100 * e.displacement:.2f}"]
        )
        rows[-1] += [f"{result.normal_force / (PULL * WIDTH**2):.4f}", f"{theirs / (PULL * WIDTH**2):.4f}"]
        rows[-1] += [e.compared, e.excluded, f"{result.report.wedging_margin or 0.0:.3f}"]
        print(*rows[-1])
    header = ["height_m", "friction", "pressure_error_percent", "displacement_error_percent"]
    header += ["normal_force_over_pull", "reference_force_over_pull", "points_compared", "points_excluded"]
    write_table(folder / "block.csv", [*header, "wedging_margin"], rows)
    cuts_of_blocks(folder, fields, references)
    status(folder, fields["block_h100_he5"], references["block_h100_he5"])
    side_view(folder, results["block_h100_he5"], references["block_h100_he5"])
    wedging(folder)


def cuts_of_blocks(folder: Path, fields: dict[str, Field], references: dict[str, Field]) -> None:
    """Thesis Figs 3.14 and 3.15: through the middle and beside the edge."""
    for (quantity, label, unit), name in ((PRESSURE, "fig_3_14"), (DISPLACEMENT, "fig_3_15")):
        figure, axes = canvas(1, 2, (7.6, 3.4), sharex=True, sharey=True)
        for ax, y in zip(axes, (0.0, 0.04), strict=True):
            for (case, (height, friction)), style in zip(CASES.items(), LINES, strict=False):
                field, ref = fields[case], references[case]
                text = f"height {height / MM:g} mm, friction {friction:g}"
                ax.plot(field.x / MM, field.cut(getattr(field, quantity), y) / unit, **style, label=text)
                ax.plot(
                    ref.x / MM,
                    ref.cut(getattr(ref, quantity), y) / unit,
                    **{**REFERENCE, "color": style["color"]},
                )
            ax.plot([], [], **REFERENCE, label="CalculiX")
            caption(ax, f"y = {y / MM:g} mm", "x [mm], sliding to the right")
        axes[0].set_ylabel(label, fontsize=9, color=INK)
        figure.legend(
            *axes[0].get_legend_handles_labels(),
            loc="outside lower center",
            ncols=2,
            frameon=False,
            fontsize=8.5,
        )
        save(figure, folder, name)


def status(folder: Path, field: Field, ref: Field) -> None:
    """Thesis Fig. D.1: open on the left of the line, in sliding contact on its right."""
    figure, (ax, tall) = canvas(1, 2, (7.4, 4.0), sharey=True)
    for f, colour, style in ((field, LINE_COLOURS[0], "-"), (ref, "black", "--")):
        edge_of_contact(ax, f, f.label, colors=colour, linestyles=style, linewidths=1.6)
    caption(ax, "height 0.1 m, friction 0.5", "x [mm], sliding to the right", "y [mm]", grid=False)
    legend(ax, loc="center")
    for friction, colour in zip((0.1, 0.2, 0.25, 0.28), LINE_COLOURS, strict=False):
        shape = of_result(solve(0.5, friction), "")
        edge_of_contact(tall, shape, f"friction {friction:g}", colors=colour, linewidths=1.6)
    caption(tall, "height 0.5 m; no sliding from 0.31 on", "x [mm]", grid=False)
    legend(tall, loc="center", bbox_to_anchor=(0.42, 0.5))
    for one in (ax, tall):
        one.set_xlim(-51.0, 50.0)
        one.set_aspect("equal")
    save(figure, folder, "fig_D_1")


def side_view(folder: Path, short: mtb.Result, ref: Field) -> None:
    """Thesis Fig. 3.16: vertical displacement seen from the side, on the deformed shape."""
    tall = solve(0.5, 0.2)
    figure, axes = canvas(1, 2, (7.4, 5.2), width_ratios=(1.5, 1.0))
    for ax, result, factor, title in (
        (axes[0], short, 5000.0, "0.1 m, friction 0.5"),
        (axes[1], tall, 2000.0, "0.5 m, friction 0.2"),
    ):
        state = result.states()["block"]
        nodes, moved = state.body.mesh.nodes.T, state.displacement
        side = np.abs(nodes[1] - nodes[1].min()) < 1e-9
        vertices, u_z = nodes[:, side], moved[2, side]
        drive = moved[0, nodes[2] > nodes[2].max() - 1e-9].mean()
        u = moved[:, side] - np.array([[drive], [0.0], [0.0]])
        faces = Triangulation(vertices[0], vertices[2]).triangles
        place = (vertices + factor * u) / MM
        shown = ax.tripcolor(place[0], place[2], faces, u_z / MICRO, shading="gouraud", cmap="viridis_r")
        ax.set_aspect("equal")
        caption(ax, f"{title}; {factor:g} times", "x [mm]", "z [mm]", grid=False)
        bar = figure.colorbar(shown, ax=ax, orientation="horizontal", aspect=22, pad=0.02)
        bar.set_label("vertical displacement [µm]", fontsize=9, color=INK)
        if result is short:
            ax.plot([], [], **REFERENCE, label="CalculiX, foot")
            foot = vertices[2] < 1e-9
            order = np.argsort(vertices[0, foot])
            drift = np.interp(ref.x, vertices[0, foot][order], u[0, foot][order])
            ax.plot((ref.x + factor * drift) / MM, factor * ref.displacement[0] / MM, **REFERENCE)
            legend(ax, loc="lower right", bbox_to_anchor=(1.0, 1.06))
    save(figure, folder, "fig_3_16")


def wedging(folder: Path) -> None:
    """The normal force over friction: it grows without bound towards a limit, beyond which nothing slides."""
    figure, ax = canvas(1, 1, (7.2, 4.0))
    rows = []
    for height, colour in zip((0.5, 0.25, 0.1), LINE_COLOURS, strict=False):
        frictions, forces, limit = [], [], float("nan")
        extra = (
            (0.28, 0.29, 0.295, 0.305, 0.31)
            if height == 0.5
            else (0.62, 0.64, 0.66)
            if height == 0.25
            else ()
        )
        for friction in (*np.arange(0.05, 0.95, 0.05), *extra):
            try:
                result = solve(height, float(friction))
            except mtb.ConvergenceError as error:
                rows.append(
                    [f"{height:g}", f"{friction:.3f}", "none", f"{error.result.report.wedging_margin:.3f}"]
                )
                continue
            margin = result.report.wedging_margin
            assert margin is not None
            limit = float(friction) / margin
            frictions.append(float(friction))
            forces.append(result.normal_force / (PULL * WIDTH**2))
            rows.append([f"{height:g}", f"{friction:.3f}", f"{forces[-1]:.4f}", f"{margin:.3f}"])
        order = np.argsort(frictions)
        ax.semilogy(
            np.array(frictions)[order],
            np.array(forces)[order],
            "o-",
            ms=3,
            color=colour,
            label=f"height {height:g} m",
        )
        if limit < 0.9:
            ax.axvline(limit, color=colour, ls=":", lw=1.2)
            ax.text(
                limit - 0.006,
                25.0,
                f"sliding certain up to {limit:.3f}",
                rotation=90,
                ha="right",
                va="top",
                fontsize=8,
                color=colour,
            )
    ax.text(
        0.325,
        12.0,
        "the thesis' block\n(0.5 m, friction 0.5)\nlies beyond the\nend of this line",
        fontsize=8.5,
        color=LINE_COLOURS[0],
    )
    ax.set_ylim(0.3, 40.0)
    caption(
        ax,
        "width 0.1 m, on a half-space; lines end where nothing slides any more",
        "friction coefficient",
        "normal force over magnetic force",
    )
    legend(ax, loc="upper right")
    save(figure, folder, "wedging")
    write_table(
        folder / "wedging.csv", ["height_m", "friction", "normal_force_over_pull", "wedging_margin"], rows
    )


if __name__ == "__main__":
    main()
