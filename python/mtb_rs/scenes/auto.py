# SPDX-License-Identifier: MIT OR Apache-2.0
"""``model="auto"``: no more model than the scene needs, judged on a coarse copy of the very scene.

The ladder is half-space, elastic upper body, elastic bodies on both sides; large grids of unlike half-spaces
have a lower rung, without the coupling of friction and pressure. Each rung is solved on cells about twice as
wide; what a rung leaves out is the difference of its coarse solution to that of the fullest rung. The
cheapest rung that leaves out less than the tolerance is taken. The coarse solution of that rung then also
tells the discretisation error of the fine one, and where the spacing is free, that error chooses the next.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from ..base.plain import plain
from ..base.words import Model
from ..contact.estimate import ORDER, SMOOTH_ORDER, GridField, difference, extrapolated, waves
from ..contact.problem import ContactProblem, Solution, mean_tractions, to_global
from ..contact.solve import displaced
from ..results.plausible import NARROW, width
from ..results.report import QUANTITIES

Array = NDArray[np.float64]
Spacing = tuple[float, float]

#: What a rung adds to the one below it.
EFFECTS = {
    "elastic-upper": "elasticity of the upper bodies beyond the half-space",
    "elastic-both": "elasticity of the rail beyond the half-space",
}
COUPLING = "opening of the gap by friction between unlike bodies"

#: Share of the tolerance that the model may use up: where the spacing is given, and where it has to make up
#: for the rest.
MODEL_SHARE, SHARE_OF_FREE_SPACING = 0.9, 0.5

#: Share of the tolerance aimed at by the next spacing; its least and largest ratio to the one before.
AIM, FINEST_STEP, WIDEST_STEP = 0.8, 0.4, 0.7

#: What is aimed at where nothing is asked for, and how many times that an estimate may be without a word.
TOLERANCE, LEEWAY = 0.05, 1.5

#: Ratio of the areas of cells from which an error is estimated: at least, and if there is a choice.
LEAST_COARSENING, COARSENING = 1.2, 2.5

#: Points by which the error estimated from n of them is raised, (1 + k / n): few may agree by chance.
FEW_POINTS = 8.0

#: Error of the pressure in a contact of n points across, in parts of 1 / n, that cells twice as wide do not
#: resolve: of a sphere, wherever its grid lies, 0.36 to 0.76.
OF_WIDTH = 0.8

#: Share of the force that may be left undetermined by rounding alone.
DETERMINED = 1e-9

#: Operations of the finest solve that is tried where the spacing is free: some minutes.
MOST_OPERATIONS = 2e12


@dataclass(frozen=True)
@plain
class Level:
    """A model solved at a spacing."""

    problem: ContactProblem
    solution: Solution
    spacing: Spacing
    #: Whether it was solved by convolutions, without a matrix.
    is_convolved: bool = False

    @property
    def operations(self) -> float:
        """Floating-point operations of bodies and solution."""
        return self.problem.operations + self.solution.operations

    @property
    def cell(self) -> Spacing:
        """Size [m] of the cells, which fill the contact exactly where they may."""
        _, x, y = self.problem.axes()[0]
        sizes = [
            np.ptp(a) / (a.size - 1) if a.size > 1 else s for a, s in zip((x, y), self.spacing, strict=True)
        ]
        return float(sizes[0]), float(sizes[1])

    @property
    def is_solved(self) -> bool:
        return self.solution.status == "solved"

    @property
    def width(self) -> tuple[float, str]:
        """Width [points] of the contact where it is narrower, "x" or "y"; infinite where a face ends it."""
        kept = self.problem.kept
        closed = self.problem.on_grid(self.solution.pressure) > 0.0
        found = []
        for patch in self.problem.patches:
            own = patch.view(closed)
            there = np.ones_like(own)
            if kept is not None:
                there = patch.view(kept.put(np.ones(kept.numbers.size, dtype=bool), False))
            found += [(width(own, there), "x"), (width(own.T, there.T), "y")]
        return min(found)

    def field(self, quantity: str) -> GridField:
        """The pressure, or the normal displacement of the lower body, to be compared with others."""
        coefficients = self.solution.coefficients(self.problem)
        hats = self.problem.averages is not None
        if quantity == "displacement" and self.problem.lower.compliance is not None:
            # all that is reported, what the pull does included
            motion = self.solution.motion[self.problem.upper.work.size :]
            points = self.problem.points
            u = displaced(self.problem, "lower", coefficients, motion)
            moved = self.problem.on_grid(-np.einsum("in,in->n", u, points.normal))
            known = self.problem.on_grid(np.ones(points.gap.size, dtype=bool), False)
            return GridField(self.problem.axes(), moved, moved if hats else None, known)
        means = self.problem.on_grid(mean_tractions(self.problem, coefficients)[2])
        pressure = self.problem.on_grid(coefficients[2])
        return GridField(self.problem.axes(), means, pressure if hats else None)

    @property
    def undetermined(self) -> float:
        """Share of the force on the lower body that balance leaves to the elasticity of the bodies.

        A body that is free to move along z carries its load, however stiff it is, and slides under friction
        times that. Each component of the force is a sum over the pressures, and so is the balance of each
        free motion: what the second ones add up to is known.
        """
        if self.problem.friction.fixed is None:
            # friction that follows the pressure is no sum
            return 1.0
        unit = replace(self.solution, pressure=np.ones(self.problem.n)).coefficients(self.problem)
        force = self.problem.geometry.loads(np.ascontiguousarray(unit))
        motions = np.asarray(self.problem.relative_motions).reshape(-1, 3, self.problem.n)
        balance = self.problem.area * (unit * motions).sum(axis=1)
        size = np.linalg.norm(balance, axis=1)
        rows = balance[size > 0.0] / size[size > 0.0, None]
        rest = force - force @ np.linalg.pinv(rows) @ rows if rows.size else force
        left = float(np.linalg.norm(rest) / np.linalg.norm(force))
        return left if left > DETERMINED else 0.0

    def force(self) -> Array:
        """Load (3,) [N] on the lower body."""
        local = self.solution.coefficients(self.problem) * np.array([[1.0], [1.0], [-1.0]])
        return np.asarray((self.problem.area * to_global(local, self.problem.points)).sum(axis=1))


@dataclass(frozen=True)
@plain
class Choice:
    """The rung taken and why.

    Attributes
    ----------
    model : str
    omitted : Mapping of effect to its estimated relative size, or to words where it was not measured
    errors : Mapping of quantity to the estimated relative error by what is left out
        Empty where that was not measured.
    coupled : bool
        Whether friction opens the gap between half-spaces.
    coarse : Level or None
        The rung on wide cells, where it was solved.
    operations : float
        Of all that was solved to choose.
    time_s : float
    fuller : callable or None
        The choice of the next rung; None for the fullest one.
    """

    model: Model
    omitted: Mapping[str, float | str] = field(default_factory=dict)
    errors: Mapping[str, float] = field(default_factory=lambda: dict.fromkeys(QUANTITIES, 0.0))
    coupled: bool = True
    coarse: Level | None = None
    operations: float = 0.0
    time_s: float = 0.0
    fuller: Callable[[], Choice] | None = None


@dataclass(frozen=True)
@plain
class Ladder:
    """The models a scene has the geometry for, cheapest first, each solved on wide cells.

    Attributes
    ----------
    rungs : list of (model, coupled)
    solved : list of Level
    quantity : str
        What sizes are measured in.
    skip_border : bool
    is_coarse : bool
        Whether the cells are wider than those of the scene.
    time_s : float
    """

    rungs: Sequence[tuple[Model, bool]]
    solved: list[Level]
    quantity: str
    skip_border: bool
    is_coarse: bool
    time_s: float

    def cheapest(self, allowed: float) -> Choice:
        """The first rung that leaves out at most `allowed`."""
        last = len(self.solved) - 1
        return self.rung(next((k for k in range(last) if self._apart(k, last) <= allowed), last))

    def rung(self, k: int) -> Choice:
        """A rung, what it leaves out, and how much by step and altogether."""
        model, coupled = self.rungs[k]
        last = len(self.solved) - 1
        return Choice(
            model=model,
            omitted={_effect(self.rungs[j + 1]): self._apart(j, j + 1) for j in range(k, last)},
            errors={q: self._apart(k, last, q) if k < last else 0.0 for q in QUANTITIES},
            coupled=coupled,
            coarse=self.solved[k] if self.is_coarse else None,
            operations=sum(level.operations for level in self.solved),
            time_s=self.time_s,
            fuller=(lambda: self.rung(k + 1)) if k < last else None,
        )

    def _apart(self, one: int, other: int, quantity: str | None = None) -> float:
        quantity = quantity or self.quantity
        rough, fine = self.solved[one], self.solved[other]
        inside = apart(rough, fine, quantity, skip_border=self.skip_border)
        if not self.skip_border or (rough.problem.averages is None) == (fine.problem.averages is None):
            return inside
        # a border point of these cells holds inner points of the cells of the scene, on which a half-space
        # differs most from a body that ends there
        whole = apart(rough, fine, quantity, skip_border=False)
        return max(inside, float(np.hypot(inside, whole) / np.sqrt(2.0)))


def _effect(rung: tuple[Model, bool]) -> str:
    """What a rung adds to the one below it."""
    return EFFECTS.get(rung[0], COUPLING)


def apart(rough: Level, fine: Level, quantity: str, *, skip_border: bool) -> float:
    """Relative difference of two solutions in a quantity, infinite if one of them is none."""
    if not (rough.is_solved and fine.is_solved):
        return float("inf")
    if quantity == "force":
        size = float(np.linalg.norm(fine.force()))
        return float(np.linalg.norm(rough.force() - fine.force())) / size if size > 0.0 else float("inf")
    found = difference(fine.field(quantity), rough.field(quantity), skip_border=skip_border)
    return float("inf") if found is None else found


@dataclass(frozen=True)
@plain
class Errors:
    """Estimated relative errors by quantity.

    Attributes
    ----------
    cells : Mapping
        Of the discretisation, by the same model on wider cells.
    model : Mapping
        By what the model leaves out; nothing where that was not measured.
    mesh : Mapping
        Of the meshes of bodies of one's own; nothing for others, whose elements vary with the cells.
    narrow : str
        "x" or "y", along which the contact is too narrow for its pressure to be known; "" where it is not.
    supports : Mapping
        By supports at points of bodies that are condensed onto fewer points than touch: they give way more
        the narrower the elements are. Nothing for others, whose elements vary with the cells.
    """

    cells: Mapping[str, float]
    model: Mapping[str, float]
    mesh: Mapping[str, float] = field(default_factory=dict)
    narrow: str = ""
    supports: Mapping[str, float] = field(default_factory=dict)

    def total(self, quantity: str) -> float:
        """All together: cells and elements both make a body too stiff, model and supports know nothing of
        them."""
        discrete = self.cells[quantity] + self.mesh.get(quantity, 0.0)
        return math.hypot(discrete, self.model.get(quantity, 0.0), self.supports.get(quantity, 0.0))

    def with_mesh(self, whole: float, at_contact: float, undetermined: float) -> Errors:
        """With shares of the elastic energy that a mesh leaves out: pressure errs by their root, and of the
        force what is `undetermined` by balance.

        Averages at nodes see half of what singular edges leave out.
        """
        of_force = 2.0 * whole * undetermined
        by = {"pressure": float(np.sqrt(at_contact)), "force": of_force, "displacement": 2.0 * whole}
        return replace(self, mesh=by)

    def totals(self) -> dict[str, float]:
        return {quantity: self.total(quantity) for quantity in self.cells}


@dataclass(frozen=True)
@plain
class Layers:
    """Copies of an elastic solution on wider cells.

    Attributes
    ----------
    wider : Level
        Differs by its cells alone.
    pair : (Level, Level)
        Differ from each other by the layers of elements alone, or by the lines that bodies are condensed onto
        and all points.
    are_of_lines : bool
    on_points : bool
        Whether a body that is condensed onto lines is held at points.
    """

    wider: Level
    pair: tuple[Level, Level]
    are_of_lines: bool = False
    on_points: bool = False

    def operations(self, known: Sequence[Level]) -> float:
        """Of those that were not known before."""
        new = {id(level): level for level in (self.wider, *self.pair)}
        found = sum(level.operations for level in new.values() if all(level is not k for k in known))
        # where only layers differ, the rails are one and the same, condensed once
        return found - (0.0 if self.are_of_lines else self.wider.problem.lower.operations)


def estimated(
    fine: Level,
    wider: Sequence[Level],
    choice: Choice,
    layers: Layers | None = None,
    *,
    skip_border: bool,
) -> Errors | None:
    """Errors of a solution from those on wider cells, the least wide first; None without any.

    The difference to the next wider one tells the error; the one after it guards against two solutions that
    agree by chance, since no error falls faster than with the square of the spacing. Two copies of elastic
    bodies that differ by their `layers` of elements alone, or by the lines they are condensed onto, tell what
    these add.
    """
    if not wider or not all(level.is_solved for level in (fine, *wider)):
        return None
    # differences between near spacings are mostly noise
    wider = [w for w in wider if np.prod(w.cell) >= COARSENING * np.prod(fine.cell)] or wider[-1:]
    if np.prod(wider[0].cell) < LEAST_COARSENING * np.prod(fine.cell):
        return None
    cells: dict[str, float] = {q: _cell_error(fine, wider[0], q, skip_border) for q in QUANTITIES}
    # among these as well
    guard = next((w for w in wider[1:] if np.prod(w.cell) >= COARSENING * np.prod(wider[0].cell)), None)
    if guard is not None:
        gain = float(np.prod(fine.cell) / np.prod(wider[0].cell))
        for q in QUANTITIES:
            cells[q] = max(cells[q], gain * _cell_error(wider[0], guard, q, skip_border))
    supports: dict[str, float] = {}
    if layers is not None and layers.on_points:
        one, other = layers.pair
        # a body gives way under a force at a point like the inverse of the width of its elements: those of
        # lines stay where they are, and those of all points would be as wide as the cells
        finer = float(np.sqrt(np.prod(one.cell) / np.prod(fine.cell)))
        supports = {q: finer * apart(other, one, q, skip_border=skip_border) for q in QUANTITIES}
    elif layers is not None:
        # their thickness goes with the root of the cells' size, their error with the square of the thickness;
        # lines stay where they are
        one, other = layers.pair
        apart_by = {
            q: apart(other, one, q, skip_border=skip_border)
            if layers.are_of_lines
            else _cell_error(fine, one, q, skip_border, other)
            for q in QUANTITIES
        }
        cells = {q: float(np.hypot(cells[q], apart_by[q])) for q in QUANTITIES}
    points, along = fine.width
    if points <= NARROW:
        # two such contacts agree by what they carry, whatever their pressure should be
        cells["pressure"] = max(cells["pressure"], 1.0)
        return Errors(cells, choice.errors, narrow=along, supports=supports)
    if wider[0].width[0] <= NARROW:
        cells["pressure"] = max(cells["pressure"], OF_WIDTH / points)
    return Errors(cells, choice.errors, supports=supports)


def _cell_error(
    fine: Level, rough: Level, quantity: str, skip_border: bool, other: Level | None = None
) -> float:
    """Error of `fine` by its difference to `rough`, or by that of an `other` one to `rough`."""
    different = apart(other or rough, fine if other is None else rough, quantity, skip_border=skip_border)
    found = extrapolated(different, fine.cell, rough.cell)
    if quantity == "pressure" and other is None and np.isfinite(found):
        short = waves(fine.field(quantity), rough.field(quantity))
        found = float(np.hypot(found, extrapolated(short, fine.cell, rough.cell, SMOOTH_ORDER)))
    return found * (1.0 + FEW_POINTS / max(_compared(rough, skip_border), 1))


def _compared(level: Level, skip_border: bool) -> int:
    """Points in contact of a level at which it is compared."""
    margin = 1 if skip_border else 0
    pressure = level.problem.on_grid(level.solution.pressure)
    loaded = [patch.view(pressure) > 0.0 for patch in level.problem.patches]
    return int(sum(p[margin : p.shape[0] - margin, margin : p.shape[1] - margin].sum() for p in loaded))


def finer_by(errors: Errors, tolerance: float, quantity: str) -> float:
    """Ratio of the cells that meet a tolerance to those of which the errors are, at the least order."""
    left_out = min(errors.model.get(quantity, 0.0) / tolerance, 0.9)
    aim = AIM * tolerance * float(np.sqrt(1.0 - left_out**2))
    return float((aim / max(errors.cells[quantity], 1e-300)) ** (1.0 / ORDER))


def resolved(
    solve: Callable[[Spacing, Sequence[Level]], tuple[Level, Errors | None]],
    start: Spacing,
    tolerance: float,
    quantity: str,
    affords: Callable[[float, float], bool],
) -> tuple[Level, Errors | None, float, str]:
    """Solves at finer and finer spacings until the estimated error is within the tolerance.

    A spacing that is refused, above all because the memory does not hold its matrices, ends it with the one
    before: bodies refuse their size before they are factorised.

    Parameters
    ----------
    solve : callable
        Of a spacing and the levels before it, the last one first; returns the level and its estimated errors.
    start : (dx, dy) [m]
    affords : callable
        Whether so many operations may follow after those that all levels have taken.

    Raises
    ------
    ValueError
        If they may not.

    Returns
    -------
    level, its errors, operations of all levels before it, why a finer one was refused ("": none was).
    """
    before: list[Level] = []
    spacing, spent, known = start, 0.0, None
    while True:
        try:
            level, errors = solve(spacing, before)
        except ValueError as error:
            if not before:
                raise
            return before[0], known, spent - before[0].operations, str(error)
        if errors is None and (before or not level.is_solved):
            return level, errors, spent, ""
        if errors is not None and errors.supports.get(quantity, 0.0) > tolerance:
            # on narrower cells this grows
            return level, errors, spent, ""
        if errors is None:
            # without a solution on wider cells: those half as wide have these to be compared with
            factor = 0.5
        elif errors.total(quantity) <= tolerance or not np.isfinite(errors.total(quantity)):
            return level, errors, spent, ""
        else:
            factor = float(np.clip(finer_by(errors, tolerance, quantity), FINEST_STEP, WIDEST_STEP))
        growth = 6.0
        if before and before[0].operations < level.operations:
            growth = float(np.log(level.operations / before[0].operations))
            growth /= float(np.log(before[0].spacing[0] / level.spacing[0]))
        # as fine as the operations allow, if they do not allow what is needed
        factor = max(factor, (level.operations / MOST_OPERATIONS) ** (1.0 / growth))
        if factor > WIDEST_STEP:
            return level, errors, spent, ""
        spent += level.operations
        if not affords(level.operations * factor**-growth, spent):
            raise ValueError(
                f"a tolerance of {tolerance:g} takes cells of about {1e3 * factor * level.cell[0]:.2g} mm, "
                "for which no time is left"
            )
        known = errors
        before = [level, *before]
        spacing = (spacing[0] * factor, spacing[1] * factor)
