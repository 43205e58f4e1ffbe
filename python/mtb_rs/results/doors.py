# SPDX-License-Identifier: MIT OR Apache-2.0
"""The one door from results to pictures and files: opened when something is drawn or saved."""

from __future__ import annotations

import io
from types import ModuleType
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from matplotlib.figure import Figure  # noqa: TID251 (only for type checkers)


def pictures() -> ModuleType:
    """The room that draws and saves; it brings matplotlib with it."""
    from .. import pictures

    return pictures


def png(figure: Figure) -> bytes:
    """The figure as a file."""
    buffer = io.BytesIO()
    figure.savefig(buffer, format="png")
    return buffer.getvalue()
