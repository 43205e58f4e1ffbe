# SPDX-License-Identifier: MIT OR Apache-2.0
"""What a solve would take, counted without solving: contact points, unknowns, memory, time.

Points and unknowns are those of the solve, as the same grids and meshes are made. Operations and memory
follow from them: the factor of a dissected mesh of u unknowns has some u^(4/3) entries and takes some u^2
operations. Seconds are operations over a stated rate for each processor: a rate measured at once would tell
more of what else runs on the machine.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import cast

import numpy as np

from .._mtb_rs import FACTOR_MEMORY
from ..base import memory, threads
from ..base.errors import TooLargeError
from ..base.plain import plain
from ..base.told import Row, Told, length
from ..base.words import Method, Model
from ..bodies.elastic_body import ElasticBody
from ..bodies.simple import HalfSpace
from ..contact.elastic import Held, rail_solid, upper_solids
from ..contact.estimate import coarsened
from ..contact.problem import ContactProblem
from ..contact.refined import (
    DIRECT_PAIR,
    PRODUCTS_FROM,
    REFINED_POINT,
    Lines,
    carrier_spacing,
    lines_of,
    spacing_of_lines,
)
from ..contact.solids import OwnBodies, count_points
from ..contact.solve import dense_operations, product_operations
from ..contact.symmetry import is_symmetric
from ..geometry.contact_points import Patch
from ..results.result import percent
from .auto import MODEL_SHARE, TOLERANCE
from .convolved import TRANSFORM, TRANSFORMS, is_by_convolution, is_coupled
from .direct import goes_far, with_wider_elements
from .posed import PosedScene

Spacing = tuple[float, float]

#: Entries of a factor over u^(4/3), its operations over u^2, and rows that a column of loads reaches over
#: u^(2/3): of blocks, poles and rails 14 to 20, 7 to 16, and 4 to 7.
ENTRIES, FACTOR, ROWS = 16.5, 11.0, 5.5
#: Share of a factor that the substitution of a column of loads passes through, over points^(-1/3); entries of
#: the products of columns over points^(3/2): 0.4 to 1.7 times this.
COLUMNS, PRODUCT = 1.5, 14.0
#: Rounds of the active sets, and the share of the points that touch: where a face is pulled down, and of a
#: curved one that is pressed.
ROUNDS, TOUCHING = (2, 8), (1.0, 0.33)
#: Products with the influence matrix: pressed alike half-spaces, unlike ones in turn, rolling, elastic
#: bodies.
PRODUCTS, IN_TURN, ROLLING, SETS = 20, 120, 240, 350
#: Share of a grid that the rectangle around a contact takes.
RECTANGLE = 0.45
#: Floating-point operations a second of each processor: condensation, dense factorisations, transforms.
CONDENSING, FACTORISING, TRANSFORMING = 3e10, 2e9, 3e9
#: Seconds for each unknown of a mesh: its order, what it adds to the stiffness.
ASSEMBLING = 6e-6
#: Seconds for each solve, and for each contact point: fields, copies, the estimate.
FIXED, EACH = 0.02, 3e-6
#: Memory over what is counted: meshes, stiffnesses, what the allocator keeps.
OVERHEAD = 1.2


@dataclass(frozen=True)
@plain
class Cost:
    """What one step of a solve would take.

    Attributes
    ----------
    name : str
        The model, or what follows: "rolling", "shift".
    points : int
        Contact points.
    unknowns : Mapping of str to int
        Of the finite elements, by body; empty for half-spaces.
    memory : float [bytes]
        About.
    operations : float
        Floating-point operations, about; those of the solves for the choice and the estimate are among them.
    time : float [s]
        About.
    """

    name: str
    points: int
    unknowns: Mapping[str, int]
    memory: float
    operations: float
    time: float


@dataclass(frozen=True)
@plain
class ExpectedCost(Told):
    """What solving a scene would take: numbers of points and unknowns exactly, memory and time about.

    Attributes
    ----------
    method : str
    choice : str
        How the model and the cells are found, in a sentence; "" where both are given.
    costs : tuple of Cost
        Of each model that may be chosen, cheapest first; then of a rolling or a shift.
    processors : int
        Of this machine, for which the time is.
    """

    method: str
    choice: str
    costs: tuple[Cost, ...]
    processors: int = field(compare=False)

    def with_motion(self, kind: str) -> ExpectedCost:
        """The same, followed by a "shift", or by "steady" or "transient" rolling."""
        pressed = self.costs[0]
        touching = int(RECTANGLE * pressed.points)
        operations = ROLLING * _transformed(touching)
        seconds = _seconds(operations, TRANSFORMING) + EACH * pressed.points
        name = "shift" if kind == "shift" else f"{kind} rolling"
        needed = memory.ROLLING_CELL[kind] * touching
        return replace(self, costs=(*self.costs, Cost(name, pressed.points, {}, needed, operations, seconds)))

    def told(self) -> list[Row]:
        """Its figures in words: what a notebook and ``mtb-rs check`` show."""
        rows = [("method", self.method)]
        if self.choice:
            rows.append(("choice", self.choice))
        for cost in self.costs:
            elements = "".join(f", {u} unknowns of the {body}" for body, u in cost.unknowns.items())
            rows.append(
                (
                    cost.name,
                    f"{cost.points} contact points{elements}; about {memory.amount(cost.memory)} of memory, "
                    f"about {duration(cost.time)}",
                )
            )
        rows.append(
            (
                "how sure",
                "points and unknowns are exact, unless the factor of a mesh comes near its largest size of "
                f"{memory.amount(FACTOR_MEMORY)}; memory may be half or twice as large; the time is a rough "
                f"estimate for {self.processors} processors, and may be a third or three times as long",
            )
        )
        return rows


def duration(seconds: float) -> str:
    """A time in words, as exactly as an estimate is."""
    unit, size = ("s", 1.0) if seconds < 60.0 else ("min", 60.0) if seconds < 3600.0 else ("h", 3600.0)
    number = float(f"{max(seconds, 0.1) / size:.1g}")
    return f"{number:g} {unit}"


def expected(
    scene: PosedScene, model: Model, method: Method, tolerance: float | None, quantity: str
) -> ExpectedCost:
    """What a solve with checked options would take; see :meth:`mtb_rs.Scene.expected_cost`."""
    free = scene.spacing is None
    start = scene.geometry.start if free else scene.known_spacing
    assert start is not None
    fixed = scene.with_(spacing=start) if free else scene
    models, words = [model], ""
    if model == "auto":
        models = fixed.models
        if len(models) > 1:
            words = (
                f"the first of {', '.join(models[:-1])} and {models[-1]} that leaves out less than "
                f"{percent(MODEL_SHARE * (tolerance or TOLERANCE))} of the {quantity}; solves on wider cells "
                "decide"
            )
    if free:
        cells = f"cells of {_sizes(start)} first, then finer ones until the tolerance is met"
        words = f"{words}; {cells}" if words else cells
    ladder = tuple(models) if model == "auto" and len(models) > 1 else ()
    is_judged = method == "direct" and (ladder or models[-1] == fixed.models[-1])
    costs = tuple(_cost(fixed, one, ladder, is_judged=bool(is_judged)) for one in models)
    return ExpectedCost(method, words, costs, threads.count())


def _sizes(spacing: Spacing) -> str:
    x, y = map(length, spacing)
    return x if x == y else f"{x} x {y}"


def _seconds(operations: float, rate: float) -> float:
    """Time of so many operations at a rate for each processor."""
    return operations / (rate * threads.count())


@dataclass(frozen=True)
class _Elements:
    """A meshed body with its contact points."""

    body: ElasticBody
    points: int
    #: Bodies of one name and key are one and the same.
    key: tuple[object, ...]
    #: Whether these are fewer than it touches in.
    is_refined: bool = False
    #: Whether the points of one half are the images of those of the other.
    are_images: bool = True

    @property
    def columns(self) -> int:
        """Columns over 3, of both halves together: a point without an image has one in each."""
        return self.points * (1 if self.are_images or not self.body.has_mirror else 2)

    @property
    def share(self) -> float:
        """What is factorised of it: of a body that is its own mirror image one half."""
        return 0.5 if self.body.has_mirror else 1.0

    @property
    def entries(self) -> float:
        return float(self.share * ENTRIES * self.body.unknowns ** (4.0 / 3.0))

    @property
    def rows(self) -> float:
        """Rows that the load of a contact point reaches."""
        u = self.body.unknowns
        return float(min(u, ROWS * u ** (2.0 / 3.0)))

    @property
    def factorising(self) -> float:
        return float(self.share * FACTOR * self.body.unknowns**2)

    @property
    def substituting(self) -> float:
        """Operations of the columns of its contact points."""
        return float(6.0 * COLUMNS * self.columns ** (2.0 / 3.0) * self.entries)

    @property
    def multiplying(self) -> float:
        """Operations of their products: a group of few points reaches few rows."""
        return float(9.0 * PRODUCT * (self.share * self.columns) ** 1.5 * self.rows)

    @property
    def substituted(self) -> float:
        """Memory [bytes] of the columns that are substituted."""
        return 8.0 * 3.0 * self.points * self.rows


def _cost(scene: PosedScene, model: Model, ladder: tuple[Model, ...], *, is_judged: bool) -> Cost:
    """What a model on the cells of the scene takes, with the choice out of a `ladder` and its estimate."""
    spacing = scene.known_spacing
    if model == "half-space" and not ladder:
        return _half_space(scene, scene.problem(model))
    problem = None if scene.own_model is not None else scene.problem("half-space")
    is_half = problem is not None and is_symmetric(problem)
    fine, n = _elements(scene, model, spacing, is_half=is_half)
    every = dict.fromkeys(fine)
    first = None
    if model == "half-space":
        assert problem is not None
        first = _half_space(scene, problem)
    for copy, one, width, thinner, carrier in _wider(scene, model, ladder, is_judged=is_judged):
        try:
            every.update(dict.fromkeys(_elements(copy, one, width, thinner, carrier, is_half=is_half)[0]))
        except ValueError:  # such cells or elements do not fit, and are left out
            continue
    # the same mesh is factorised once for all its contact points
    distinct = {e.key: e for e in every}.values()
    meshes = {id(e.body.core): e for e in distinct}.values()
    condensing = sum(e.factorising for e in meshes) + sum(e.substituting + e.multiplying for e in distinct)
    held = 8.0 * sum(e.entries for e in meshes) + max((e.substituted for e in distinct), default=0.0)
    operations, needed = condensing, OVERHEAD * held
    seconds = _seconds(condensing, CONDENSING) + ASSEMBLING * sum(e.body.unknowns for e in meshes)
    if first is not None:
        return Cost(model, n, {}, needed + first.memory, operations + first.operations, seconds + first.time)
    own = n if not is_half else (n + 1) // 2
    if any(e.is_refined for e in fine) and own >= PRODUCTS_FROM:
        solving = product_operations(own, SETS)
        needed += (REFINED_POINT + memory.SCENE_CELL) * n
    else:
        solving = _dense(own, is_pulled=scene.magnetic_pressure is not None)
        # blocks of both bodies, their halves, those of the pair
        needed += DIRECT_PAIR * n**2 + memory.SCENE_CELL * n
    seconds += _seconds(solving, FACTORISING) + FIXED + EACH * n
    unknowns = {e.body.name: e.body.unknowns for e in fine}
    return Cost(model, n, unknowns, needed, operations + solving, seconds)


def _wider(
    scene: PosedScene, model: Model, ladder: tuple[Model, ...], *, is_judged: bool
) -> Iterator[tuple[PosedScene, Model, Spacing, float, Spacing | None]]:
    """The solves on wider cells: scene, model, spacing, how much thinner the layers of elements are, and the
    spacing of the points that bodies under many points are condensed onto."""
    spacing = scene.known_spacing
    width = coarsened(spacing, scene.geometry.grid(spacing).patches)
    if width is None:
        return
    try:
        copy = with_wider_elements(scene, spacing, width)
    except ValueError:
        return
    ratio = float(np.sqrt(np.prod(width) / np.prod(spacing)))
    own = None if scene.own_model is not None else carrier_spacing(scene.geometry.grid(spacing).node_patches)
    wide = None if own is None else (ratio * own[0], ratio * own[1])
    for one in ladder:
        yield copy, one, width, 1.0, wide
    if is_judged and model != "half-space":
        yield copy, model, width, 1.0, wide
        if scene.own_model is None:
            yield copy, model, width, ratio if own is None else 1.0, own


def _elements(
    scene: PosedScene,
    model: Model,
    spacing: Spacing,
    thinner: float = 1.0,
    carrier: Spacing | None = None,
    *,
    is_half: bool,
) -> tuple[list[_Elements], int]:
    """The meshed bodies of a model that are condensed, and the number of contact points."""
    geometry = scene.geometry
    if scene.own_model is not None:
        n = count_points(cast(OwnBodies, geometry), spacing)
        are_images = n == geometry.grid(spacing).nodes.gap.size
        bodies = scene.solids.values()
        return [_Elements(body, n, (body.name, n), are_images=are_images) for body in bodies], n
    grid = geometry.grid(spacing)
    if model == "half-space":
        return [], int(grid.area.size)
    geometry.check_elastic(spacing)
    n = int(grid.nodes.gap.size)
    # that these are half-spaces is checked with the model
    upper, lower = cast(tuple[HalfSpace, HalfSpace], scene.simple)
    held = Held(scene.supports, scene.element_size, thinner, carrier)
    patches = grid.node_patches

    def above(lines: Lines | None) -> list[_Elements]:
        solids = upper_solids(geometry, grid, upper.material, held, {}, lines)
        key = spacing, thinner, carrier
        return [
            _Elements(solid, points, (solid.name, *key), lines is not None)
            for (solid, is_twin), points in zip(solids, _counts(patches, lines), strict=True)
            if not is_twin
        ]

    def below(lines: Lines | None) -> list[_Elements]:
        half = is_half and geometry.rail()[0].is_symmetric and isinstance(scene.supports, str)
        rail, carried = rail_solid(geometry, grid, lower.material, half=half, time_s={}, lines=lines)
        points = sum(_counts(carried, lines)[: len(carried)])
        return [_Elements(rail, points, (rail.name, spacing, carrier), lines is not None)]

    # many points are not those that the bodies are condensed onto
    found = _fitting(above, carrier, patches)
    if model == "elastic-both":
        found += _fitting(below, carrier, patches)
    return found, n


def _fitting(
    made: Callable[[Lines | None], list[_Elements]],
    carrier: Spacing | None,
    patches: Sequence[Patch],
) -> list[_Elements]:
    """Bodies that are made on all of their points or on some lines: on lines too where their factor would be
    too large on all points."""
    first = lines_of(patches, carrier)
    if first is not None:
        return made(first)
    try:
        found = made(None)
    except TooLargeError:
        found = []
    if found and all(8.0 * e.entries < FACTOR_MEMORY for e in found):
        return found
    return made(lines_of(patches, spacing_of_lines(patches)))


def _counts(patches: Sequence[Patch], lines: Lines | None) -> list[int]:
    """Points of each patch that bodies are condensed onto."""
    if lines is None:
        return [patch.nx * patch.ny for patch in patches]
    return [len(x) * len(y) for x, y in lines]


def _half_space(scene: PosedScene, problem: ContactProblem) -> Cost:
    """What the cells of half-spaces take."""
    n = problem.n
    sides = [(patch.nx, patch.ny) for patch in problem.patches]
    needed = memory.of_scene(sides)
    is_rubbing = bool(problem.direction.any())
    if goes_far(scene, problem) and is_by_convolution(scene, problem):
        operations = (IN_TURN if is_coupled(scene, problem) else PRODUCTS) * _transformed(n)
        seconds = _seconds(operations, TRANSFORMING)
    else:
        own = (n + 1) // 2 if is_symmetric(problem) else n
        operations = _dense(own, is_pulled=scene.magnetic_pressure is not None)
        needed += memory.of_sliding(own, is_rubbing)
        seconds = _seconds(operations, FACTORISING)
    return Cost("half-space", n, {}, needed, operations, FIXED + seconds + EACH * n)


def _dense(points: int, *, is_pulled: bool) -> float:
    """Operations of a dense solve."""
    rounds, touching = (pair[0 if is_pulled else 1] for pair in (ROUNDS, TOUCHING))
    return dense_operations(points, int(touching * points), int(rounds))


def _transformed(cells: int) -> float:
    """Operations of a product with the influence matrix of a grid."""
    padded = 4.0 * max(cells, 1)
    return float(TRANSFORMS * TRANSFORM * padded * np.log2(padded))
