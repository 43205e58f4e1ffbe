# SPDX-License-Identifier: MIT OR Apache-2.0
"""What is saved as files and comes back from them."""

from __future__ import annotations

from pathlib import Path
from typing import Any, ClassVar

from ..base.told import Told
from .fields import Field


class Savable(Told):
    """What :func:`mtb_rs.load` brings back: it has fields and totals, draws and saves itself."""

    #: Whether it is drawn in one way, and not as maps, lines or in space.
    is_one_picture: ClassVar[bool] = False

    def _kept(self) -> Any:
        """What goes into files in its place: the same as plain data."""
        return self

    def check(self) -> None:
        """Checks that what was read from files fits together; ValueError if it does not."""

    @property
    def heading(self) -> str:
        """What it is, where :meth:`told` does not say it."""
        return repr(self)

    def facts(self) -> dict[str, Any]:
        """What it tells besides: inputs, the model, how good it is, the report."""
        return {}

    def fields(self) -> dict[str, Field]:
        """Its fields over the contact points, by name: values with unit and label."""
        return {}

    def totals(self) -> dict[str, Field]:
        """Its forces, moments and motions, by name: values with unit and label."""
        return {}

    def save(self, directory: str | Path) -> list[Path]:
        """Writes its files into a directory."""
        raise NotImplementedError
