# SPDX-License-Identifier: MIT OR Apache-2.0
"""How the figures look: one canvas, one set of colours, the package's words on the axes."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from comparison import ROOT, Field
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from mtb_rs.base.files import output_folder
from mtb_rs.pictures.quantities import INK, LINE_COLOURS

Array = NDArray[np.float64]

MM, MICRO, MEGA = 1e-3, 1e-6, 1e6
#: The quantities of a `Field`: attribute, label, unit of the picture.
PRESSURE = ("pressure", "pressure [MPa]", MEGA)
DISPLACEMENT = ("displacement", "vertical displacement [µm]", MICRO)


def output(description: str | None) -> Path:
    """The folder to write to: option -o, by default the one of the documentation."""
    parser = argparse.ArgumentParser(description=description)
    parser.add_argument("-o", "--output", type=output_folder, default=str(ROOT / "docs/figures/thesis"))
    folder: Path = parser.parse_args().output
    return folder


def canvas(rows: int = 1, columns: int = 1, size: tuple[float, float] = (7.2, 3.6), **options: Any) -> Any:
    """A figure and its axes in the house's style."""
    figure = Figure(figsize=size, dpi=130, layout="constrained")
    axes = figure.subplots(rows, columns, **options)
    for ax in np.atleast_1d(axes).flat:
        ax.spines[["top", "right"]].set_visible(False)
        ax.spines[["left", "bottom"]].set_color("#888888")
        ax.tick_params(labelsize=8.5, color="#888888", labelcolor=INK)
        ax.set_axisbelow(True)
    return figure, axes


def caption(ax: Axes, title: str, x: str = "", y: str = "", *, grid: bool = True) -> None:
    """Title and labels of one pair of axes."""
    ax.set_title(title, loc="left", fontsize=9.5, color=INK)
    ax.set_xlabel(x, fontsize=9, color=INK)
    ax.set_ylabel(y, fontsize=9, color=INK)
    if grid:
        ax.grid(True, color="#DDDDDD", linewidth=0.6)


def legend(ax: Axes, **options: Any) -> None:
    ax.legend(**{"frameon": False, "fontsize": 8.5, **options})


def save(figure: Figure, folder: Path, name: str) -> None:
    figure.savefig(folder / f"{name}.png")
    print(folder / f"{name}.png")


def maps(fields: Sequence[Field], quantity: tuple[str, str, float], size: tuple[float, float]) -> Figure:
    """The fields one above the other.

    Pressures share a colour scale, which stops at 97 % of their points. Displacements, which may differ by
    whole rigid motions, have one each.
    """
    name, label, unit = quantity
    figure, axes = canvas(len(fields), 1, size, squeeze=False, sharex=True)
    every = np.concatenate([getattr(f, name).ravel() for f in fields]) / unit
    shared = name == "pressure"
    high = np.percentile(every, 97)
    for ax, field in zip(axes.flat, fields, strict=True):
        values = getattr(field, name) / unit
        shown = draw_map(ax, field, values, **({"vmin": 0.0, "vmax": high} if shared else {}))
        if shared:
            edge_of_contact(ax, field, colors="white", linewidths=1.2)
        else:
            _bar(figure, shown, ax, "", aspect=8)
        caption(ax, field.label if shared else f"{field.label}: {label}", y="y [mm]", grid=False)
    axes.flat[-1].set_xlabel("x [mm]", fontsize=9, color=INK)
    if shared:
        extend = "max" if every.max() > 1.01 * high > 0.0 else "neither"
        _bar(figure, shown, axes.ravel().tolist(), label, aspect=30, extend=extend)
    return figure


def _bar(figure: Figure, shown: Any, axes: Any, label: str, **options: Any) -> None:
    bar = figure.colorbar(shown, ax=axes, pad=0.02, **options)
    bar.set_label(label, color=INK, fontsize=9)
    bar.ax.tick_params(labelsize=8.5, colors=INK)


def draw_map(ax: Axes, field: Field, values: Array, **style: Any) -> Any:
    """Values (ny, nx) of a field, each over the area that belongs to it; lengths in mm."""
    x, y = field.borders()
    shown = ax.pcolormesh(x / MM, y / MM, values, rasterized=True, **{"cmap": "viridis", **style})
    ax.set_aspect("equal")
    return shown


def edge_of_contact(ax: Axes, field: Field, label: str = "", **style: Any) -> None:
    """The line between contact and no contact, if there is one."""
    state = field.pressure / field.pressure.mean()
    open_ = field.pressure <= 0.0
    if open_.any() and field.gap is not None:
        state = np.where(open_, -field.gap / max(float(field.gap[open_].mean()), 1e-15), state)
    else:
        state = np.where(open_, -1.0, 1.0)
    if open_.any():
        ax.contour(field.x / MM, field.y / MM, state, [0.0], **style)
    if label:
        lines = {
            "color": style["colors"],
            "lw": style.get("linewidths", 1.6),
            "ls": style.get("linestyles", "-"),
        }
        ax.plot([], [], label=label + ("" if open_.any() else ": all closed"), **lines)


def cuts(
    fields: Sequence[Field],
    quantity: tuple[str, str, float],
    places: Sequence[float],
    styles: Sequence[dict[str, Any]],
    *,
    columns: int = 2,
    title: str = "",
) -> Figure:
    """The fields along x, one pair of axes for each y [m]."""
    name, label, unit = quantity
    rows = -(-len(places) // columns)
    figure, axes = canvas(rows, columns, (7.6, 0.6 + 2.5 * rows), squeeze=False, sharex=True, sharey=True)
    for ax, y in zip(axes.flat, places, strict=True):
        for field, style in zip(fields, styles, strict=True):
            ax.plot(
                field.x / MM, field.cut(getattr(field, name), y) / unit, **{"label": field.label, **style}
            )
        caption(ax, f"y = {y / MM:.3g} mm")
    for ax in axes[-1]:
        ax.set_xlabel("x [mm], sliding to the right", fontsize=9, color=INK)
    for ax in axes[:, 0]:
        ax.set_ylabel(label, fontsize=9, color=INK)
    handles, labels = axes.flat[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=3, frameon=False, fontsize=8.5)
    if title:
        figure.suptitle(title, x=0.01, ha="left", fontsize=10.5, color=INK)
    return figure


#: A reference is drawn as points, solutions as lines.
REFERENCE: dict[str, Any] = {
    "color": "black",
    "marker": "o",
    "markersize": 3,
    "linestyle": "none",
    "zorder": 5,
}
LINES: tuple[dict[str, Any], ...] = tuple({"color": c, "linewidth": 1.5} for c in LINE_COLOURS)
