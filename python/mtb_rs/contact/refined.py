# SPDX-License-Identifier: MIT OR Apache-2.0
"""Elastic bodies on more contact points than they can be condensed onto.

At distances that are small against a body it gives way as a half-space does, and what is left is smooth. So
a body under many contact points is condensed onto the hats between some lines of their grids, and its
compliance on all of them is that of a half-space and, from the lines, the difference of the body to it. Near
a free edge of the body this difference varies over the distance from it, so the lines are dense there.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from .. import _mtb_rs
from ..bodies.elastic_body import Condensed
from ..bodies.material import Material
from ..geometry.contact_points import Patch

Array = NDArray[np.float64]
#: Numbers of the lines along x and y that are kept of each grid of nodes.
Lines = list[tuple[list[int], list[int]]]

#: Memory [bytes] for each pair of contact points of bodies that are condensed onto them: blocks of both
#: bodies, their halves, those of the pair.
DIRECT_PAIR = 24.0 * 8.0
#: Contact points up to which bodies are condensed onto all of them. Under more they are condensed onto lines,
#: which takes a fifth of the time and less, and errs by a tenth of what the cells do.
DIRECT_POINTS = 1000
#: Contact points from which on such bodies are solved by products, without a matrix.
PRODUCTS_FROM = _mtb_rs.PRODUCTS_FROM
#: Cells between lines on a patch, about, if its edges had none more: a strip has cells up to so many times
#: longer than wide.
CELLS, LONGEST = 75, 2.0
#: Distance between two lines over that of the first one from a free edge, at most.
GROWTH = 0.5
#: Step in the middle over the last one towards it, at least.
EVEN = 0.7
#: Layers of the elements between them are those of a grid finer by this factor.
THINNER = 0.7
#: Memory [bytes] for each contact point of bodies that are condensed onto fewer ones, about.
REFINED_POINT = 3e4


class NotRefinedError(ValueError):
    """A body that must be condensed onto all of its contact points."""


def carrier_spacing(patches: Sequence[Patch]) -> tuple[float, float] | None:
    """The largest distance (dx, dy) [m] of lines that bodies on these patches of nodes are condensed onto.

    None where all nodes are few enough for condensation itself.
    """
    n = sum(patch.nx * patch.ny for patch in patches)
    return None if n <= DIRECT_POINTS else spacing_of_lines(patches)


def spacing_of_lines(patches: Sequence[Patch]) -> tuple[float, float]:
    """The same distance, however few the nodes are."""
    patch = max(patches, key=lambda p: p.nx * p.ny)
    counts, steps = np.array([patch.nx, patch.ny]) - 1, np.array(patch.spacing)
    sides = counts * steps
    # what lies across a strip is nearer to its edges
    longer = np.clip(sides / sides.min() / 3.0, 1.0, LONGEST)
    size = float(np.sqrt(sides.prod() / (CELLS * longer.prod())))
    dx, dy = np.maximum(size * longer, steps).tolist()
    return dx, dy


def lines_of(patches: Sequence[Patch], carrier: tuple[float, float] | None) -> Lines | None:
    """The lines of patches of nodes that a body is condensed onto, at most `carrier` (dx, dy) [m] apart.

    None where the nodes are few, unless a `carrier` is given.
    """
    spacing = carrier_spacing(patches) if carrier is None else carrier
    if spacing is None:
        return None
    return [
        (_lines(p.nx, spacing[0] / p.spacing[0]), _lines(p.ny, spacing[1] / p.spacing[1])) for p in patches
    ]


def _lines(nodes: int, widest: float) -> list[int]:
    """Some of the nodes of a row, symmetric about its middle, at most so many cells apart.

    They are dense at its ends: there the pressure may be singular, and may a body have a free edge.
    """
    end, largest = nodes - 1, max(round(widest), 1)

    def step(line: int) -> int:
        """The longest one from a line on."""
        return min(max(int(GROWTH * line), 1), largest)

    near = [0]
    while near[-1] + step(near[-1]) <= end // 2:
        near.append(near[-1] + step(near[-1]))
    inner, inward = _middle(near[-1], end, step(near[-1]))
    # a spline between lines needs steps that change little
    while len(near) > 1 and 0.0 < inward < EVEN * (near[-1] - near[-2]):
        near.pop()
        inner, inward = _middle(near[-1], end, step(near[-1]))
    left = near + inner
    return sorted({*left, *(end - k for k in left)})


def _middle(first: int, end: int, longest: int) -> tuple[list[int], float]:
    """Nodes from `first` to the middle, in equal steps up to the `longest` to its image; their step."""
    rest = end - 2 * first
    parts = -(-rest // longest)
    # an odd rest has no node in its middle
    parts += rest % 2 == 1 and parts % 2 == 0
    return [first - (-rest * k) // parts for k in range(1, parts // 2 + 1)], rest / max(parts, 1)


def refined(
    coarse: Condensed, material: Material, lines: Lines, patches: Sequence[Patch], *, half: bool
) -> Condensed:
    """A body that is condensed onto the hats between `lines` of the patches, on all of their nodes.

    It is the whole, or the `half` of one that is its own mirror image about y = 0.

    Raises
    ------
    NotRefinedError
        If the body ends inside the patches, or is so stiff there that its compliance might not be positive
        definite.
    """
    grids = [((*p.origin, p.nx, p.ny), p.spacing) for p in patches]
    elastic = material.shear_modulus, material.poisson_ratio
    try:
        motions = np.ascontiguousarray(coarse.mode_displacement)
        compliance = _mtb_rs.refined(coarse.compliance, coarse.weights, motions, elastic, lines, grids, half)
    except ValueError as error:
        raise NotRefinedError(str(error)) from None

    def carried(amounts: Array) -> Array:
        """Integrals over the hats, or amounts by a unit of each (..., n)."""
        rows = np.ascontiguousarray(amounts.reshape(-1, amounts.shape[-1]))
        fine = _mtb_rs.carried(rows, lines)
        return fine.reshape(*amounts.shape[:-1], fine.shape[1])

    weights = carried(coarse.weights)

    def seen(means: Array) -> Array:
        """Displacements (..., n) of the points."""
        return carried(means * coarse.weights) / weights

    return replace(
        coarse,
        weights=weights,
        mode_displacement=seen(coarse.mode_displacement),
        case_displacement=seen(coarse.case_displacement),
        spread_displacement=seen(coarse.spread_displacement),
        contact_resultant=carried(coarse.contact_resultant),
        reaction=carried(coarse.reaction),
        refined=compliance,
    )
