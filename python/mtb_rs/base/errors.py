# SPDX-License-Identifier: MIT OR Apache-2.0
"""Errors and warnings of the package. Bad input is a plain :class:`ValueError`."""

from __future__ import annotations

from typing import Any


class CaseError(ValueError):
    """A case file that cannot be used: names the file, the key and the value."""


class ConvergenceError(RuntimeError):
    """No solution exists, or none was found.

    Attributes
    ----------
    result
        The last state, with a report that says what happened; never to be taken for a solution.
    """

    def __init__(self, message: str, result: Any = None) -> None:
        super().__init__(message)
        self.result = result

    def __reduce__(self) -> tuple[type, tuple[str, Any]]:
        return type(self), (str(self), self.result)


class ResultantError(ConvergenceError, ValueError):
    """The load cannot be carried by any pressure: its resultant lies outside the contact."""


class MissingFileError(FileNotFoundError, ValueError):
    """A file that was asked for and is not there."""


class ViewError(RuntimeError):
    """A 3-D picture that cannot be made on this machine; the message says what is missing."""


class ToleranceWarning(UserWarning):
    """A result whose estimated error exceeds what was aimed at; the message says what would do."""


class PictureWarning(UserWarning):
    """A file that was left out, and what to install to have it."""
