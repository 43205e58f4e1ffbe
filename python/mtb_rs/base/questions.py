# SPDX-License-Identifier: MIT OR Apache-2.0
"""Questions about what is allowed but looks like a slip of the unit: warnings, nothing is refused."""

from __future__ import annotations

import contextlib
from collections.abc import Iterable, Iterator, Mapping
from contextvars import ContextVar

from .check import warn

_gathering: ContextVar[list[str] | None] = ContextVar("gathering", default=None)


def ask(questions: Iterable[str], known: Iterable[str] = (), kind: type[Warning] = UserWarning) -> None:
    """Warns of each question that is not `known`."""
    gathering = _gathering.get()
    for question in dict.fromkeys(questions):
        if gathering is not None:
            gathering.append(question)
        elif question not in known:
            warn(question, kind)


def unusual(lengths: Mapping[str, float], limits: Mapping[str, tuple[float, float]]) -> list[str]:
    """Questions about lengths [m] outside what is usual."""
    return [
        f"{name} is {lengths[name]:g} m: {low:g} to {high:g} m is usual, and lengths are in metres"
        for name, (low, high) in limits.items()
        if name in lengths and not low <= lengths[name] <= high
    ]


@contextlib.contextmanager
def gathered() -> Iterator[list[str]]:
    """Questions that come up inside, in place of warnings: those of a copy have been asked before."""
    questions: list[str] = []
    token = _gathering.set(questions)
    try:
        yield questions
    finally:
        _gathering.reset(token)
