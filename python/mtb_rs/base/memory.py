# SPDX-License-Identifier: MIT OR Apache-2.0
"""What a solve takes of the memory, said before it starts."""

from __future__ import annotations

from collections.abc import Sequence

from .. import _mtb_rs
from . import cache
from .check import warn

#: Share of the free memory above which a solve says what it will take.
SAID_FROM = 0.5
#: What a scene takes for each cell of its contact grid, from making it to its result by convolutions [bytes];
#: dense matrices come on top and are counted apart.
SCENE_CELL = 1800.0
#: What it takes besides for each pair of points in one line of it, to compare it with a coarser one [bytes].
SCENE_LINE = 8.0
#: What a patch takes for each of its cells to roll or to be shifted, most of it spectra [bytes].
ROLLING_CELL = {"steady": 800.0, "transient": 950.0, "shift": 950.0}
#: The part of it that is still to come when the grid is made [bytes].
SOLVED_CELL = 1500.0


def available() -> float | None:
    """Memory [bytes] that this process can still have; None where the system does not tell.

    The least of what the machine has free and of what its container and its shell (`ulimit -v`) leave.
    """
    return _mtb_rs.available_memory()


def of_normal_contact(cells: tuple[int, int], method: str = "auto") -> float:
    """Memory [bytes] that :func:`mtb_rs.solve_normal` takes at most, for (nx, ny) cells and a method."""
    return _mtb_rs.normal_memory(cells, method)


def of_sliding(points: int, frictional: bool = True) -> float:
    """Memory [bytes] that the dense matrices of a sliding contact take at most, for a number of points."""
    return _mtb_rs.sliding_memory(points, frictional)


def amount(size: float) -> str:
    """Memory [bytes] in words, in the unit that leaves a tenth or more in front of the point."""
    unit, factor = next(
        (u, f) for u, f in (("GB", 1e9), ("MB", 1e6), ("kB", 1e3)) if size >= 0.1 * f or u == "kB"
    )
    return f"{size / factor:.1f} {unit}"


def of_scene(sides: Sequence[tuple[int, int]]) -> float:
    """Memory [bytes] that a scene takes at most whose grids have so many cells along their sides (nx, ny)."""
    return sum(SCENE_CELL * nx * ny + SCENE_LINE * (nx**2 + ny**2) for nx, ny in sides)


def of_least_matrix(points: float) -> float:
    """Memory [bytes] that a contact of so many points takes at least where its matrices are dense.

    One matrix of half of the points: what two poles that are mirror images share.
    """
    return of_matrices(points, 1) / 4.0


def of_matrices(points: float, matrices: int) -> float:
    """Memory [bytes] of dense matrices over so many points, at their peak."""
    return 8.0 * matrices * float(points) ** 2


def _free_for(needed: float) -> float | None:
    """Memory [bytes] that is free; what was kept for further solves goes where `needed` is more."""
    free = available()
    return available() if free is not None and needed > free and cache.forget_objects() else free


def say(needed: float, what: str) -> None:
    """Warns of a solve that takes more than half of the free memory.

    Parameters
    ----------
    needed : float [bytes]
    what : str
        What is solved, as the subject of the sentence.
    """
    free = _free_for(needed)
    # what there is not is refused by the solve itself
    if free is not None and SAID_FROM * free < needed <= free:
        warn(f"{what} may take {amount(needed)} of memory; {amount(free)} are free")


def refuse(needed: float, what: str, advice: str) -> None:
    """Refuses what the memory does not hold, before any of it is asked for.

    Parameters
    ----------
    needed : float [bytes]
    what : str
        What takes it, as the subject of the sentence.
    advice : str
        What would do.

    Raises
    ------
    ValueError
        If there is less.
    """
    free = _free_for(needed)
    if free is not None and needed > free:
        raise ValueError(
            f"{what} would take {amount(needed)} of memory; {amount(max(free, 0.0))} are free: {advice}"
        )
