# SPDX-License-Identifier: MIT OR Apache-2.0
"""The number of threads of the compiled core, as its environment asks for it."""

from __future__ import annotations

import os

from .check import warn

VARIABLE = "RAYON_NUM_THREADS"


def _asked() -> str:
    return os.environ.get(VARIABLE, "").strip()


def most() -> int:
    """Threads beyond which more take memory and no work off the others."""
    return max(64, 4 * (os.cpu_count() or 1))


def count() -> int:
    """Threads that the core works on: as many as its environment asks for, or the processors it may use."""
    asked = _asked()
    if asked.isdecimal() and int(asked) > 0:
        return int(asked)
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def limit() -> None:
    """Lowers what the environment asks for to what a machine can start; the core reads it at its first work.

    Warns
    -----
    UserWarning
        If it was lowered.
    """
    asked = _asked()
    if asked and not asked.isdecimal():
        warn(f"{VARIABLE} is {asked!r}: a whole number from 1 on is needed; it is ignored")
    elif asked.isdecimal() and (len(asked) > 9 or int(asked) > most()):
        os.environ[VARIABLE] = str(most())
        warn(f"{VARIABLE} is {asked}: {most()} threads are started")
