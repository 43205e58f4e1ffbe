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


def panels(count: int, width: float = 4.4, height: float = 4.0) -> tuple[Figure, list[Axes]]:
    """A row of `count` plots."""
    figure, axes = plt.subplots(
        1, count, figsize=(width * count, height), layout="constrained", squeeze=False
    )
    return figure, list(axes[0])


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
            axes.text(i, j, text, ha="center", va="center", fontsize=6.5, color=ink)
    axes.set_xticks(range(len(x)), [f"{v:.3g}" for v in x], fontsize=8)
    axes.set_yticks(range(len(y)), [f"{v:.3g}" for v in y], fontsize=8)
    handles = [Patch(color=c, label=n) for c, n in zip(colours, names, strict=True)]
    axes.figure.legend(
        handles=handles, loc="outside lower center", ncols=len(names), fontsize=8, frameon=False
    )


def write(name: str, figure: Figure, rows: Sequence[dict[str, Any]]) -> None:
    """Picture and table of a map."""
    FOLDER.mkdir(parents=True, exist_ok=True)
    figure.savefig(FOLDER / f"{name}.png", dpi=120)
    with (FOLDER / f"{name}.csv").open("w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, fieldnames=list(rows[0]), lineterminator="\n")
        writer.writeheader()
        for row in rows:
            writer.writerow({k: f"{v:.5g}" if isinstance(v, float) else v for k, v in row.items()})
    print(f"{name}: {len(rows)} cells")
