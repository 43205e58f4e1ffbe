# SPDX-License-Identifier: MIT OR Apache-2.0
"""What a scene states beside its bodies and may not need: a layer, a hardness, a pull that follows the gap.

They are judged as models are: what leaving one out changes is the difference of two solutions of the very
scene, mostly on cells about twice as wide.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray

from ..base.plain import plain
from ..base.words import Model
from ..contact.problem import ContactProblem
from ..friction.fields import as_form
from ..friction.magnet import Magnet
from ..results.report import QUANTITIES
from ..results.result import percent
from .auto import Choice, Level, apart
from .posed import PosedScene

Array = NDArray[np.float64]

#: The fields that may be left out, by what the report calls them.
EFFECTS = {
    "normal_layer": "layer between the bodies",
    "hardness": "hardness",
    "magnetic_pressure": "pull that follows the gap",
}
#: Largest share of the pull by which its points may differ where all of the contact is closed.
UNIFORM = 1e-9


def stated(scene: PosedScene) -> list[str]:
    """The fields of a scene that may be left out."""
    return [
        name
        for name in EFFECTS
        if getattr(scene, name) is not None
        and (name != "magnetic_pressure" or as_form(scene.magnetic_pressure).follows_gap)
    ]


def without(scene: PosedScene, names: list[str], level: Level) -> PosedScene | None:
    """The scene without some of its effects; None for a magnet that pulls unevenly over a closed gap.

    In place of a magnet is what it pulls over a closed gap. `level` is a solution of the scene.
    """
    changes: dict[str, object] = dict.fromkeys(names)
    if "magnetic_pressure" in names:
        problem = level.problem
        pull = _attracting(scene, problem, np.zeros(problem.n))[0]
        poles = [patch.view(problem.on_grid(pull, np.nan)).ravel() for patch in problem.patches] or [pull]
        poles = [pole[np.isfinite(pole)] for pole in poles]
        if any(np.ptp(pole) > UNIFORM * pole.max() for pole in poles):
            return None
        each = [float(pole.mean()) for pole in poles]
        changes["magnetic_pressure"] = each if np.ptp(each) > UNIFORM * max(each) else each[0]
    return scene.with_(**changes)


def _attracting(scene: PosedScene, problem: ContactProblem, gap: Array) -> tuple[Array, float, list[float]]:
    """Pull (n,) [Pa], flux [Wb] and forces [A] of the poles of the magnet of a scene over gaps (n,) [m]."""
    magnet = cast("Magnet", as_form(scene.magnetic_pressure))
    kept = None if problem.kept is None else problem.kept.numbers
    circuit = magnet.circuit(problem.area, problem.patches, kept)
    pull, _, _, flux, forces = circuit.attract(np.ascontiguousarray(gap), magnet.factor(scene.velocity))
    return pull, flux, forces


def of_held_magnet(scene: PosedScene, level: Level) -> dict[str, Any]:
    """What the magnet of a scene, held as over a closed gap, does in a solution without it, for the report.

    "residual" is what its pull at the gaps of the solution differs by.
    """
    problem, held = level.problem, level.problem.attraction
    pull, flux, forces = _attracting(scene, problem, np.maximum(level.solution.gap, 0.0))
    return {
        "attraction": float(problem.area @ held),
        "flux": flux,
        "ampere_turns_of_poles": tuple(forces),
        "solves": 1,
        "residual": float(np.abs(pull - held).max() / held.max()),
    }


def changed_by(level: Level, full: Level, quantity: str) -> float:
    """Relative difference to a solution with all effects on the same points; infinite where one is none.

    All points count, those at the sharp edges of bodies too: the cells of both are the same, and a layer acts
    most there.
    """
    if quantity == "force" or not (level.is_solved and full.is_solved):
        return apart(level, full, quantity, skip_border=False)
    one, other = level.field(quantity), full.field(quantity)
    changed = size = 0.0
    for patch, _, _ in other.axes:
        before, after = patch.view(other.means), patch.view(one.means)
        if one.known is not None and other.known is not None:
            known = patch.view(one.known & other.known)
            before, after = before[known], after[known]
        changed += float(np.square(after - before).sum())
        size += float(np.square(before).sum())
    return float(np.sqrt(changed / size)) if size > 0.0 else float("inf")


@dataclass(frozen=True)
@plain
class Judged:
    """A scene without what does not matter, and the choice of its model.

    Attributes
    ----------
    scene : PosedScene
    choice : Choice
    omitted : dict of field to what leaving it out changes, relative to the quantity asked for
    errors : dict of quantity to what leaving out all of them changes
    notes : tuple of str
    level : Level or None
        A solution of the scene on its own cells, where there is one.
    """

    scene: PosedScene
    choice: Choice
    omitted: dict[str, float] = field(default_factory=dict)
    errors: dict[str, float] = field(default_factory=dict)
    notes: tuple[str, ...] = ()
    level: Level | None = None

    def with_effects(self, choice: Choice) -> Choice:
        """A choice of the model that leaves out these effects too."""
        if not self.omitted:
            return choice
        fuller = choice.fuller
        return replace(
            choice,
            omitted={**choice.omitted, **{EFFECTS[name]: size for name, size in self.omitted.items()}},
            errors={q: choice.errors.get(q, 0.0) + self.errors[q] for q in QUANTITIES},
            coarse=None,
            fuller=None if fuller is None else lambda: self.with_effects(fuller()),
        )


def judge(
    scene: PosedScene,
    choice: Choice,
    allowed: float,
    quantity: str,
    names: list[str],
    at: Callable[[PosedScene], Level],
    *,
    is_coarse: bool,
) -> Judged:
    """Leaves out those of the effects `names` that together change the `quantity` by at most `allowed`.

    A hardness is left out where no pressure reaches it, and so changes nothing. A magnet is kept where it has
    two states or one that does not stay.

    Parameters
    ----------
    at : callable
        The solution of a scene, on wider cells if `is_coarse`.
    """
    full = at(scene)
    own = None if is_coarse else full
    if not full.is_solved:
        return Judged(scene, choice, level=own)
    sizes: dict[str, float] = {}
    if "hardness" in names and full.problem.hardness is not None:
        reached = float((full.solution.pressure / full.problem.hardness).max(initial=0.0))
        if reached < 1.0:
            sizes["hardness"] = 0.0
    for name in names:
        is_settled = not full.solution.notes and not full.solution.unstable
        if name == "hardness" or (name == "magnetic_pressure" and not is_settled):
            continue
        changed = without(scene, [name], full)
        if changed is not None:
            sizes[name] = changed_by(at(changed), full, quantity)
    order = sorted(sizes, key=lambda name: sizes[name])
    rest = allowed - choice.errors.get(quantity, 0.0)
    while order:
        changed = without(scene, order, full)
        if changed is not None and sum(sizes[name] for name in order) <= rest:
            level = full if order == ["hardness"] else at(changed)
            errors: dict[str, float] = {q: changed_by(level, full, q) for q in QUANTITIES}
            if errors[quantity] <= rest:
                found = Judged(
                    changed,
                    choice,
                    {name: sizes[name] for name in order},
                    errors,
                    tuple(_note(name, sizes[name], quantity, choice.model, is_coarse) for name in order),
                    None if is_coarse or order == ["hardness"] else level,
                )
                return replace(found, choice=found.with_effects(choice))
        order.pop()
    return Judged(scene, choice, level=own)


def _note(name: str, size: float, quantity: str, model: Model, is_coarse: bool) -> str:
    """What was left out, and what it would have changed."""
    if name == "hardness":
        return (
            "hardness was left out: no pressure reaches it, so that it changes nothing. "
            f"model={model!r} keeps it."
        )
    where = ", as seen on wider cells" if is_coarse else ""
    instead = ": the magnet pulls everywhere as over a closed gap" if name == "magnetic_pressure" else ""
    what = "The Magnet's gap" if name == "magnetic_pressure" else name
    return (
        f"{what} was left out{instead}. It changes the {quantity} by {percent(size)}{where}; "
        f"model={model!r} keeps it."
    )
