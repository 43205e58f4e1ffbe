# SPDX-License-Identifier: MIT OR Apache-2.0
"""How the maps are drawn and written: a verdict in each cell, PNG and CSV into docs/maps."""

from __future__ import annotations

import csv
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import ListedColormap
from matplotlib.figure import Figure
from matplotlib.patches import Patch

FOLDER = Path(__file__).parents[1] / "docs" / "maps"

#: Right; the library says that there is no answer, or none to rely on; wrong without a word.
GOOD, TOLD, WRONG = 0, 1, 2
VERDICTS = ("converges to the reference", "fails, and says so", "wrong without a word")
COLOURS = ("#56B4E9", "#E69F00", "#000000")


plt.style.use("mtb_rs.pictures")


def panels(count: int, columns: int = 2, height: float = 3.3) -> tuple[Figure, list[Axes]]:
    """`count` plots, `columns` a row, each `height` inches high; all rows as wide as a page."""
    columns = min(count, columns)
    rows = -(-count // columns)
    width = plt.rcParams["figure.figsize"][0]
    figure, axes = plt.subplots(rows, columns, figsize=(width, height * rows), squeeze=False)
    for unused in axes.flat[count:]:
        unused.set_axis_off()
    return figure, list(axes.flat[:count])


def draw_verdicts(
    axes: Axes,
    x: Sequence[float],
    y: Sequence[float],
    codes: np.ndarray,
    *,
    names: Sequence[str] = VERDICTS,
    colours: Sequence[str] = COLOURS,
    texts: np.ndarray | None = None,
) -> None:
    """Cells of verdicts (len(y), len(x)) at evenly drawn places, each with a short text."""
    axes.pcolormesh(
        np.arange(len(x) + 1) - 0.5,
        np.arange(len(y) + 1) - 0.5,
        codes,
        cmap=ListedColormap(list(colours)),
        vmin=-0.5,
        vmax=len(colours) - 0.5,
        edgecolors="white",
        lw=0.8,
    )
    if texts is not None:
        for (j, i), text in np.ndenumerate(texts):
            ink = "white" if colours[int(codes[j, i])] == "#000000" else "black"
            # on a ground of its own, which breaks a line that runs through it
            ground = {"boxstyle": "round,pad=0.25", "lw": 0, "facecolor": colours[int(codes[j, i])]}
            axes.text(
                i, j, text, ha="center", va="center", fontsize=8, color=ink, bbox=ground if text else None
            )
    axes.grid(visible=False)
    axes.set_xticks(range(len(x)), [f"{v:.3g}" for v in x])
    axes.set_yticks(range(len(y)), [f"{v:.3g}" for v in y])
    # what no cell of any plot has is no entry
    told = {names[int(code)] for code in np.unique(codes)}
    for earlier in list(axes.figure.legends):
        told |= {entry.get_text() for entry in earlier.get_texts()}
        earlier.remove()
    handles = [Patch(color=c, label=n) for c, n in zip(colours, names, strict=True) if n in told]
    axes.figure.legend(handles=handles, loc="outside lower center", ncols=min(len(handles), 3))


def write(name: str, figure: Figure, rows: Sequence[dict[str, Any]]) -> None:
    """Picture and table of a map."""
    FOLDER.mkdir(parents=True, exist_ok=True)
    figure.savefig(FOLDER / f"{name}.png")
    with (FOLDER / f"{name}.csv").open("w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, fieldnames=list(rows[0]), lineterminator="\n")
        writer.writeheader()
        for row in rows:
            writer.writerow({k: f"{v:.5g}" if isinstance(v, float) else v for k, v in row.items()})
    print(f"{name}: {len(rows)} cells")
