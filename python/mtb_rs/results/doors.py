# SPDX-License-Identifier: MIT OR Apache-2.0
"""The one door from results to pictures and files: opened when something is drawn or saved."""

from __future__ import annotations

from types import ModuleType


def pictures() -> ModuleType:
    """The room that draws and saves; it brings matplotlib with it."""
    from .. import pictures

    return pictures
