# SPDX-License-Identifier: MIT OR Apache-2.0
"""Moving pictures of a history of results, on one scale."""

from __future__ import annotations

import io
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from numpy.typing import NDArray
from PIL import Image

from ..base.files import check_target, write_bytes
from ..base.units import taking_quantities, unit_of_argument
from ..base.words import Field as Word
from ..results.result import Drawn, Pictured
from .figures import own_figures
from .maps import window_of
from .plane import is_a_cut, plot_within, shared_limits
from .quantities import INK, PREFIXES, as_drawn, quantity_of, unit_of
from .sweep_plot import spaced


@taking_quantities
def animate(
    history: Iterable[Drawn],
    path: str | Path,
    quantity: Word = "pressure",
    *,
    frames_per_second: float = 10.0,
    captions: Sequence[str] | None = None,
    **options: Any,
) -> Path:
    """A moving picture (.gif, .webp or .png) of one quantity over a history of results.

    All frames share their scale: the colours of maps and 3-D views, the axes of lines; and the part of the
    plane that maps show.

    Parameters
    ----------
    history : results
        At least one, in order, all of one kind.
    path : str or Path
    quantity : str
        As for :func:`plot`.
    frames_per_second : float [1/s]
    captions : sequence of str, one for each frame
        What stands over them, such as the time. By default the arguments of the scenes in which the results
        differ; where there are none, the number of the step.
    **options
        As for :func:`plot`, `kind`, `x` and `y` included; not `ax`.
    """
    target = check_moving(path, frames_per_second)
    if not isinstance(history, Iterable):
        raise ValueError(f"history is {history!r}: a list of results is needed")
    drawn = [as_drawn(result)._picture() for result in history]
    if not drawn:
        raise ValueError("history is empty: at least one result is needed")
    quantity_of(drawn[0], quantity)
    if captions is not None and (isinstance(captions, str) or len(captions) != len(drawn)):
        raise ValueError(
            f"captions has {len(captions)} entries: one for each of the {len(drawn)} results is needed"
        )
    shared = {"limits": shared_limits(drawn, quantity, options), **options}
    if options.get("kind") in (None, "map") and not is_a_cut(options):
        shared["window"] = window_of(drawn, quantity_of(drawn[0], quantity))
    captions = _differences(drawn) if captions is None else captions
    frames = [
        _frame(result, quantity, caption, shared) for result, caption in zip(drawn, captions, strict=True)
    ]
    return moving_picture(frames, target, frames_per_second)


def check_moving(path: str | Path, frames_per_second: float) -> Path:
    """Where a moving picture is to be written; ValueError if it cannot be."""
    target = check_target(path)
    if target.suffix not in (".gif", ".webp", ".png"):
        raise ValueError(f"path is {str(path)!r}: a name ending in .gif, .webp or .png is needed")
    if not (np.isfinite(frames_per_second) and frames_per_second > 0.0):
        raise ValueError(f"frames_per_second is {frames_per_second!r}: a positive number is needed")
    return target


def moving_picture(frames: Iterable[NDArray[np.uint8]], target: Path, frames_per_second: float) -> Path:
    """Writes images (height, width, 3) that follow each other."""
    first, *others = [Image.fromarray(frame) for frame in frames]
    pause = round(1000.0 / frames_per_second)
    moving = io.BytesIO()
    kind = {".gif": "GIF", ".webp": "WEBP", ".png": "PNG"}[target.suffix]
    first.save(moving, kind, save_all=True, append_images=others, duration=pause, loop=0)
    write_bytes(target, moving.getbuffer())
    return target


def image_of(figure: Figure) -> NDArray[np.uint8]:
    """A figure as an image (height, width, 3)."""
    canvas: Any = FigureCanvasAgg(figure)
    canvas.draw()
    return np.array(canvas.buffer_rgba())[..., :3]


def _frame(result: Pictured, quantity: str, caption: str, options: dict[str, Any]) -> NDArray[np.uint8]:
    with own_figures():
        picture = plot_within(result, quantity, **options)
    if isinstance(picture, Figure):
        picture.suptitle(caption, x=0.01, ha="left", fontsize=11, color=INK)
        return image_of(picture)
    picture.add_text(caption, position="upper_left", font_size=12, color=INK)
    image = np.array(picture.screenshot(return_img=True))
    picture.close()
    return image


def _differences(history: Sequence[Pictured]) -> list[str]:
    """The numbers given to the scenes of the results in which they differ, or which step each is."""
    steps = [f"step {k} of {len(history)}" for k in range(1, len(history) + 1)]
    given = [dict(result.facts().get("inputs", {})) for result in history]
    numbers = {
        name: [inputs[name] for inputs in given]
        for name in given[0]
        if all(isinstance(inputs.get(name), (int, float)) for inputs in given)
    }
    said = []
    for name, values in numbers.items():
        if all(value == values[0] for value in values):
            continue
        factor, unit = 1.0, unit_of_argument(name)
        if unit in PREFIXES and unit != "1":
            factor, unit = unit_of(np.array(values, dtype=float), unit)
        unit = "" if unit in ("", "1") else f" {unit}"
        said.append([f"{spaced(name)} {value / factor:.4g}{unit}" for value in values])
    return [", ".join(words) for words in zip(*said, strict=True)] if said else steps
