# SPDX-License-Identifier: MIT OR Apache-2.0
"""``model="auto"``: no more model than the scene needs, judged on a coarse copy of the very scene.

The ladder is half-space, elastic upper body, elastic bodies on both sides. Each rung is solved on cells
about twice as wide; what a rung leaves out is the difference of its coarse solution to that of the fullest
rung. The cheapest rung that leaves out less than the tolerance is taken. The coarse solution of that rung
then also tells the discretisation error of the fine one.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .elastic import can_be_elastic
from .estimate import difference, extrapolated
from .layout import Layout
from .solve import ContactProblem, Solution, mean_tractions, solve_direct, to_global

Array = NDArray[np.float64]

LADDER = ("half-space", "elastic-upper", "elastic-both")

#: What a rung adds to the one below it.
EFFECTS = {
    "elastic-upper": "elasticity of the upper bodies beyond the half-space",
    "elastic-both": "elasticity of the rail beyond the half-space",
}

#: Share of the tolerance that the model may use up; the rest is for the discretisation.
MODEL_SHARE = 0.7


@dataclass(frozen=True)
class Coarse:
    """A rung solved on wide cells."""

    problem: ContactProblem
    solution: Solution
    spacing: tuple[float, float]


@dataclass(frozen=True)
class Choice:
    """The rung taken and why.

    Attributes
    ----------
    model : str
    omitted : Mapping of effect to its estimated relative size
    coarse : Coarse or None
        The rung on wide cells, where it was solved.
    time_s : float
    """

    model: str
    omitted: Mapping[str, float]
    coarse: Coarse | None
    time_s: float

    @property
    def model_error(self) -> float:
        """Estimated relative error by what is left out."""
        return float(sum(self.omitted.values()))


def rungs(layout: Layout, upper_is_elastic: bool, lower_is_elastic: bool) -> list[str]:
    """The models a scene has the geometry for, cheapest first."""
    found = ["half-space"]
    if upper_is_elastic and can_be_elastic(layout, "elastic-upper"):
        found.append("elastic-upper")
        if lower_is_elastic and can_be_elastic(layout, "elastic-both"):
            found.append("elastic-both")
    return found


def choose(solved: Mapping[str, Coarse], tolerance: float, quantity: str, time_s: float) -> Choice:
    """The cheapest of the coarsely solved rungs (cheapest first, fullest last) that is full enough."""
    models = list(solved)
    fullest = solved[models[-1]]
    for k, model in enumerate(models[:-1]):
        gap = apart(solved[model], fullest, quantity)
        if gap <= MODEL_SHARE * tolerance:
            names = " and ".join(EFFECTS[m] for m in models[k + 1 :])
            return Choice(model, {names: gap}, solved[model], time_s)
    return Choice(models[-1], {}, fullest, time_s)


def apart(one: Coarse, other: Coarse, quantity: str) -> float:
    """Relative difference of two coarse solutions in a quantity."""
    if one.solution.status != "solved" or other.solution.status != "solved":
        return float("inf")
    if quantity == "force":
        forces = [load(c.problem, c.solution).sum(axis=1) for c in (one, other)]
        return float(np.linalg.norm(forces[0] - forces[1]) / np.linalg.norm(forces[1]))
    if quantity == "displacement":
        fields = [closing(c.problem, c.solution) for c in (one, other)]
    else:
        fields = [mean_tractions(c.problem, c.solution.coefficients(c.problem))[2] for c in (one, other)]
    found = difference(other.problem.axes(), one.problem.axes(), (fields[1], fields[0]), skip_border=True)
    return float("inf") if found is None else found


def closing(problem: ContactProblem, solution: Solution) -> Array:
    """Normal displacement (n,) [m] of the lower body."""
    compliance = problem.lower.compliance
    if compliance is None:
        return np.zeros(problem.n)
    return np.asarray(compliance.displacement(solution.coefficients(problem))[2])


def load(problem: ContactProblem, solution: Solution) -> Array:
    """Load (3, n) [N] on the lower body."""
    local = solution.coefficients(problem) * np.array([[1.0], [1.0], [-1.0]])
    return problem.area * to_global(local, problem.points)


def discretisation_error(
    fine: ContactProblem,
    solution: Solution,
    spacing: tuple[float, float],
    coarse: Coarse | None,
    *,
    skip_border: bool,
) -> float | None:
    """Relative L2 error of the pressure away from the border, by the same model on wider cells."""
    if coarse is None or coarse.solution.status != "solved":
        return None
    pressures = (
        mean_tractions(fine, solution.coefficients(fine))[2],
        mean_tractions(coarse.problem, coarse.solution.coefficients(coarse.problem))[2],
    )
    found = difference(fine.axes(), coarse.problem.axes(), pressures, skip_border=skip_border)
    return None if found is None else extrapolated(found, spacing, coarse.spacing)


def coarse_copy(problem: ContactProblem, spacing: tuple[float, float]) -> Coarse:
    """A problem on wide cells, solved."""
    return Coarse(problem, solve_direct(problem, with_margin=False), spacing)
