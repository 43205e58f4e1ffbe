# SPDX-License-Identifier: MIT OR Apache-2.0
"""Errors and warnings of the package. Bad input is a plain :class:`ValueError`."""

from __future__ import annotations

from typing import Any

from .._mtb_rs import TooLargeError as TooLargeError


class CaseError(ValueError):
    """A case file cannot be used. The message names the file, the key and the value."""


class ConvergenceError(RuntimeError):
    """No solution exists, or none was found.

    Attributes
    ----------
    result
        The last state, whose report gives the reason. It is not a solution.
    """

    def __init__(self, message: str, result: Any = None) -> None:
        super().__init__(message)
        self.result = result

    def __reduce__(self) -> tuple[type, tuple[str, Any]]:
        return type(self), (str(self), self.result)


class ResultantError(ConvergenceError, ValueError):
    """The load cannot be carried by any pressure: its resultant lies outside the contact."""


class MissingFileError(FileNotFoundError, ValueError):
    """A file that was asked for does not exist."""


class ViewError(RuntimeError):
    """A 3-D picture cannot be made on this machine. The message names the missing part."""


class ToleranceWarning(UserWarning):
    """The estimated error of a result exceeds its tolerance. The message names cells that would meet it."""


class PictureWarning(UserWarning):
    """A file was left out. The message names the package to install for it."""
