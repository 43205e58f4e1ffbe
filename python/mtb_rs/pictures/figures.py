# SPDX-License-Identifier: MIT OR Apache-2.0
"""Figures that belong to nobody or to pyplot, and the look of their axes."""

from __future__ import annotations

import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from contextvars import ContextVar
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ..base.words import Body
from ..results.doors import png
from ..results.fields import Field
from .quantities import INK


class ResultFigure(Figure):
    """A matplotlib figure that shows itself in a notebook; pyplot's own where pyplot is in use."""

    def show(self, warn: bool = True) -> None:
        """Shows the figure in a window, if there is a display."""
        if self.canvas.manager is None:
            from matplotlib import pyplot
            from matplotlib._pylab_helpers import Gcf

            # a figure of pyplot's gives the canvas of its backend, and its number
            window = pyplot.figure()
            number, canvas = window.number, type(window.canvas)
            pyplot.close(window)
            manager = canvas.new_manager(self, number)
            Gcf._set_new_active_manager(manager)
        super().show(warn)

    def _repr_png_(self) -> bytes:
        return png(self)


#: Whether figures belong to nobody: those that the library makes for its own files and notebooks.
_IS_OWN: ContextVar[bool] = ContextVar("own figures", default=False)


@contextmanager
def own_figures() -> Iterator[None]:
    """Figures drawn inside do not become pyplot's, which would keep them."""
    token = _IS_OWN.set(True)
    try:
        yield
    finally:
        _IS_OWN.reset(token)


def new_figure(size: tuple[float, float]) -> Figure:
    pyplot = sys.modules.get("matplotlib.pyplot")
    if pyplot is None or _IS_OWN.get():
        return ResultFigure(figsize=size, dpi=150, layout="constrained")
    figure: Figure = pyplot.figure(FigureClass=ResultFigure, figsize=size, dpi=150, layout="constrained")
    return figure


def canvas(ax: Axes | None, size: tuple[float, float]) -> tuple[Figure, Axes]:
    if ax is None:
        figure = new_figure(size)
        return figure, figure.add_subplot()
    return figure_of(ax), ax


def canvases(ax: tuple[Axes, Axes] | None, size: tuple[float, float]) -> tuple[Figure, Axes, Axes]:
    """A figure with two places beside each other: those given, or new ones."""
    if ax is None:
        figure = new_figure(size)
        left, right = figure.subplots(1, 2)
        return figure, left, right
    if not isinstance(ax, Sequence | np.ndarray) or len(ax) != 2:
        raise ValueError(f"ax is {ax!r}: two axes of matplotlib are needed, as of figure.subplots(1, 2)")
    left, right = ax
    figure_of(right)
    return figure_of(left), left, right


def figure_of(ax: Any) -> Figure:
    if not isinstance(ax, Axes):
        raise ValueError(f"ax is {ax!r}: axes of matplotlib are needed, as of figure.add_subplot()")
    owner = ax.get_figure(root=True)
    if owner is None:
        raise ValueError("ax belongs to no figure")
    return owner


def label_of(asked: Field, body: Body) -> str:
    return asked.label + (f" of the {asked.body} body" if asked.body is not None else "")


def from_zero(ax: Axes) -> None:
    """Begins the axis at zero, with room above what is largest: a constant has no range of its own."""
    ax.set_ylim(0.0, max(ax.get_ylim()[1], 1.05 * float(ax.dataLim.y1)))


def style_axes(ax: Axes) -> None:
    ax.spines[["top", "right"]].set_visible(False)
    ax.spines[["left", "bottom"]].set_color("#888888")
    ax.tick_params(labelsize=8.5, color="#888888", labelcolor=INK)
    ax.xaxis.label.set(color=INK, fontsize=9.5)
    ax.yaxis.label.set(color=INK, fontsize=9.5)
    ax.set_axisbelow(True)
