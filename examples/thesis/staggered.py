# SPDX-License-Identifier: MIT OR Apache-2.0
"""When does the thesis' loop around finite elements converge, and what to: thesis C.0.2, Tables C.2, C.3.

The loop adds the share 1/f_FE of the finite-element displacement each time. Its limit (below it the loop
diverges) is predicted from the eigenvalues of the iteration.
"""

from __future__ import annotations

import time
from pathlib import Path
from typing import Any

import numpy as np
from comparison import Field, of_result, write_table
from drawing import DISPLACEMENT, LINES, MICRO, MM, PRESSURE, canvas, caption, cuts, draw_map, output, save
from full_shoe import GAUSSIAN, scene

import mtb_rs as mtb
from mtb_rs.pictures.quantities import INK

#: Thesis Table C.2: size of the finite elements [m] and time [s].
THESIS_SECONDS = {2e-3: 764, 3e-3: 494, 4e-3: 383, 6e-3: 312}
STEPS = 20


def staggered(case: mtb.Scene, factor: float | None, steps: int = STEPS, **options: Any) -> mtb.Result:
    """The loop, whatever becomes of it."""
    try:
        return case.solve(
            model="elastic-upper", method="staggered", factor=factor, max_iterations=steps, **options
        )
    except mtb.ConvergenceError as error:
        return error.result


def limit_of(result: mtb.Result) -> float:
    """The predicted limit, which the report gives in words."""
    return float(result.report.solver.rsplit(" ", 1)[1])


def main() -> None:
    folder = output(__doc__)
    mesh_study(folder)
    limits(folder)
    iterates(folder)


def mesh_study(folder: Path) -> None:
    """Thesis Figs C.3, C.4: elements of 2 to 6 mm under a contact grid of 3 mm, directly and by the loop."""
    fields: list[Field] = []
    rows = []
    for size, theirs in THESIS_SECONDS.items():
        case = scene(0.5).with_(element_size=size)
        clock = time.perf_counter()
        result = case.solve(model="elastic-upper")
        seconds = time.perf_counter() - clock
        fields.append(of_result(result, f"elements of {size / MM:g} mm"))
        looped = of_result(staggered(case, None, 200), "")
        rows.append([f"{size / MM:g}", f"{seconds:.2f}", theirs])
        inner = (slice(1, -1), slice(1, -1))
        finest = fields[0]
        for other in (finest, looped):
            off = np.abs(fields[-1].pressure - other.pressure)[inner].mean()
            rows[-1].append(f"{100 * off / finest.pressure[inner].mean():.2f}")
        up = np.abs(fields[-1].displacement - finest.displacement)[inner].mean()
        rows[-1].append(f"{100 * up / np.abs(finest.displacement[inner]).mean():.2f}")
        print(*rows[-1])
    header = ["element_size_mm", "seconds", "thesis_seconds", "pressure_difference_to_2_mm_percent"]
    header += ["pressure_difference_of_loop_percent", "displacement_difference_to_2_mm_percent"]
    write_table(folder / "table_C_2.csv", header, rows)
    title = "full shoe, friction 0.5, contact grid 3 mm"
    for quantity, name in ((PRESSURE, "fig_C_3"), (DISPLACEMENT, "fig_C_4")):
        figure = cuts(fields, quantity, (7.5e-3, 12e-3), LINES[:4], title=title)
        figure.axes[0].set_ylim(*((0.0, 10.0) if quantity is PRESSURE else (None, None)))
        save(figure, folder, name)


def limits(folder: Path) -> None:
    """Predicted limits beside the factors the thesis used, and what 20 iterations are worth."""
    block, shoe = mtb.scenes.block_on_plane, mtb.scenes.pole_shoe_on_rail
    cases: list[tuple[str, mtb.Scene, float]] = [
        ("block, 0.1 m, friction 0.5", block(height=0.1, friction=0.5), 20),
        ("block, 0.5 m, friction 0.2", block(height=0.5, friction=0.2), 20),
        ("block, 0.5 m, friction 0.5 (Table 3.5)", block(height=0.5, friction=0.5), 20),
        ("shoe of 28.2 mm, friction 0.5 (Table 3.6)", shoe(height=28.2e-3, length=96e-3), 25),
        ("full shoe, friction 0.5 (Table C.3)", scene(0.5), 25),
        ("full shoe, friction 0.5 (Table C.3)", scene(0.5), 10),
        ("full shoe, points fixed, friction 0.5", scene(0.5, supports="fixed-points"), 25),
        ("full shoe, Gauss function, friction 0.2 (Table 4.2)", scene(0.2, GAUSSIAN), 85),
    ]
    rows = []
    for name, case, factor in cases:
        after = staggered(case, factor)
        long = staggered(case, factor, 3000)
        quick = staggered(case, None, 200, anderson_depth=8)
        converged = long.report.converged
        rows.append([name, f"{limit_of(long):.3g}" if converged else "none", f"{factor:g}"])
        rows[-1] += [f"{100 * after.report.residual:.2g}", long.report.iterations if converged else "never"]
        rows[-1].append(quick.report.iterations if quick.report.converged else "never")
        rows[-1].append("")
        if converged:
            direct = case.solve(model="elastic-upper")
            off = np.linalg.norm(long.pressure - direct.pressure) / np.linalg.norm(direct.pressure)
            rows[-1][-1] = f"{100 * off:.1f}"
        print(*rows[-1])
    header = ["scene", "predicted_limit", "thesis_factor", "residual_after_20_iterations_percent"]
    header += ["iterations_to_converge", "iterations_with_anderson", "bias_of_loop_in_pressure_percent"]
    write_table(folder / "table_C_3.csv", header, rows)


def iterates(folder: Path) -> None:
    """Thesis Table C.3: the last three of 20 iterates, with a factor above and one below the limit."""
    case = scene(0.5)
    limit = limit_of(staggered(case, 25, 3000))
    factors = (25.0, 0.6 * limit)
    figure, axes = canvas(3, 2, (7.4, 4.2), sharex=True, sharey=True)
    every = {
        f: [of_result(staggered(case, f, k), "") for k in (STEPS - 2, STEPS - 1, STEPS)] for f in factors
    }
    values = np.concatenate([s.displacement.ravel() for states in every.values() for s in states]) / MICRO
    scale = {"cmap": "viridis_r", "vmin": values.min(), "vmax": values.max()}
    for column, (factor, states) in enumerate(every.items()):
        word = "above" if factor > limit else "below"
        for ax, state, k in zip(axes[:, column], states, ("18", "19", "20"), strict=True):
            u = state.displacement / MICRO
            shown = draw_map(ax, state, u, **scale)
            head = f"factor {factor:.3g}, {word} the limit {limit:.3g}\n" if k == "18" else ""
            caption(ax, f"{head}iterate {k}", y="y [mm]" if column == 0 else "", grid=False)
    for ax in axes[-1]:
        ax.set_xlabel("x [mm]", fontsize=9, color=INK)
    bar = figure.colorbar(shown, ax=axes.ravel().tolist(), aspect=30, pad=0.02)
    bar.set_label("vertical displacement of the left pole [µm]", fontsize=9, color=INK)
    bar.ax.tick_params(labelsize=8.5)
    save(figure, folder, "table_C_3")


if __name__ == "__main__":
    main()
