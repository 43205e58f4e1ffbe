# SPDX-License-Identifier: MIT OR Apache-2.0
"""Scenes that slide and heat, expand and wear over the time."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..base.check import choice, flag, not_negative, number, pair, positive, reals, warn, whole
from ..base.errors import ConvergenceError
from ..base.stored import without_functions
from ..base.words import Model
from ..bodies.conductor import Conductor, check_conductors, conducting_steel
from ..bodies.sides import Side
from ..bodies.simple import are_layered, are_prisms, without_layers
from ..contact.heated_steps import Heated, HeatedSliding, Trial
from ..contact.problem import ContactProblem, Solution
from ..contact.sliding_heat import OVER_CONTACT, SlidingHeat, slide_and_heat
from ..contact.sliding_start import check_room
from ..contact.solve import NOT_CARRIED, failure, solve_direct
from ..friction.fields import as_form
from ..friction.wear_laws import as_wear_law
from ..results.plausible import SMALL
from .posed import PosedScene

Array = NDArray[np.float64]

#: Estimated error above which equal steps are too long: of one of them above the thermal limit, in the mean
#: below it, where the first steps after a sudden change of the speed have large ones at any length.
COARSE = 0.25
#: Part of the speed of shear waves above which inertia, which is left out, is felt: by its square.
FAST = 0.3
#: Steps, and time [s], of a slide at most: longer ones end in nobody's time, and in the rounding of the time.
MOST_STEPS, LONGEST = 1_000_000, 1e9


def heat(
    scene: PosedScene,
    duration: float,
    steps: int = 60,
    velocity: float | Callable[[float], float] | None = None,
    *,
    tolerance: float | None = None,
    model: Model = "auto",
    progress: Callable[[float], Any] | Literal[True] | None = None,
    **given: Any,
) -> SlidingHeat:
    """See :meth:`mtb_rs.Scene.sliding_heat`."""
    if whole("steps", steps) > MOST_STEPS:
        raise ValueError(f"steps is {steps}: at most {MOST_STEPS} are possible")
    if positive("duration", duration, "s") > LONGEST:
        raise ValueError(f"duration is {duration:g} s: at most {LONGEST:g} s are possible")
    if tolerance is not None:
        check_tolerance("tolerance", tolerance)
    if velocity is None and scene.velocity is None:
        raise ValueError("velocity is missing: a speed [m/s], or a function of the time that gives one")
    asked = scene.velocity if velocity is None else velocity
    heated_scene = HeatedScene.of(scene, *heated_of(scene, model, **given))

    def speed(time: float) -> float:
        try:
            found = asked(time) if callable(asked) else asked
        except TypeError as error:
            raise ValueError(f"velocity is {asked!r}: a function of the time is needed ({error})") from None
        value = number("velocity", found, "m/s")
        if value < 0.0:
            raise ValueError(f"velocity is {value:g} m/s at {time:g} s: it must not be negative")
        heated_scene.check_speed("velocity", value)
        return value

    sliding = heated_scene.sliding(steps=steps if tolerance is None else None)
    failed = heated_scene.failed
    found = slide_and_heat(sliding, float(duration), steps, speed, tolerance, failed, progress)
    margin, errors = found["thermal_margin"], found["errors"][1:]
    grows = margin is not None and margin > 1.0
    if tolerance is None and sliding.heated.expands and errors.size:
        # below the limit a single step does not spoil those after it
        error, which = (errors.max(), "one of them") if grows else (errors.mean(), "in the mean each of them")
        why = f", and the heat is {margin:.3g} times the thermal limit" if grows else ""
        if error > COARSE:
            warn(
                f"The steps are too long: {which} has an error of {error:.2g} of the heat and wear that it "
                f"adds{why}. Give tolerance, or more steps."
            )
    said = {
        "duration": duration,
        "steps": steps,
        "tolerance": tolerance,
        "velocity": without_functions(asked),
    }
    return heated_scene.result(found, said)


def check_tolerance(name: str, tolerance: float) -> None:
    """ValueError for a tolerance of steps that is none."""
    if positive(name, tolerance) >= 1.0:
        raise ValueError(f"{name} is {tolerance!r}: a number between 0 and 1 is needed")


@dataclass(frozen=True)
class HeatedScene:
    """A scene in its model, and what is said of its heat and wear, checked."""

    scene: PosedScene
    model: Model
    problem: ContactProblem
    first: Solution
    heated: Heated
    said: dict[str, Any]

    @classmethod
    def of(cls, scene: PosedScene, model: Model, heated: Heated, said: dict[str, Any]) -> HeatedScene:
        """The scene solved cold; `model`, `heated` and `said` are those of :func:`heated_of`."""
        problem = scene.problem(model, may_halve=False)
        if not problem.upper.state:
            raise ValueError(
                "the upper body is no elastic body: heat needs one that conducts, an ElasticBody"
            )
        if not problem.direction.any():
            raise ValueError("sliding_direction is None: nothing slides, so there is no heat")
        check_room(problem.n)
        return cls(scene, model, problem, _cold(scene, problem), heated, said)

    def of_shoe(self, share: float, depth: Array | None = None) -> HeatedScene:
        """The same under a share of the magnetic pressure, with a depth (n,) [m] worn off before."""
        if share == 1.0 and depth is None:
            return self
        problem = self.problem
        if problem.attracting is not None:
            factor = share * problem.attracting.factor
            problem = replace(problem, attracting=replace(problem.attracting, factor=factor))
        upper, lower = (_under_share(side, share) for side in (problem.upper, problem.lower))
        problem = replace(problem, upper=upper, lower=lower)
        if depth is not None:
            points = replace(problem.points, gap=problem.points.gap + depth)
            problem = replace(problem, gap=problem.gap + depth, points=points)
        return replace(self, problem=problem, first=_cold(self.scene, problem))

    def check_speed(self, name: str, speed: float) -> None:
        """ValueError for a speed [m/s] at which the bodies are no longer in static equilibrium."""
        scene, heated = self.scene, self.heated
        waves = []
        for is_upper, body, conductor in (
            (True, scene.upper, heated.upper),
            (False, scene.lower, heated.lower),
        ):
            own = scene.solids.get(is_upper)
            material = body.material if own is None else own.material  # type: ignore[union-attr]
            if material is not None:
                shear = material.young_modulus / (2.0 * (1.0 + material.poisson_ratio))
                waves.append(float(np.sqrt(shear / conductor.density)))
        slowest = min(waves)
        if speed > FAST * slowest:
            raise ValueError(
                f"{name} is {speed:g} m/s: the bodies are in static equilibrium here, without inertia, which "
                f"holds below about {FAST * slowest:.3g} m/s, {FAST:g} of the speed of shear waves in them"
            )

    def sliding(self, share: float = 1.0, *, steps: int | None) -> HeatedSliding:
        """The bodies at the beginning of their steps, with a share of the magnetic pressure.

        `steps` is their number, if all have one duration.
        """
        scene, problem = self.scene, self.problem
        kept, points, patches = problem.kept, problem.points, problem.patches

        def posed(velocity: float, pressure: Array) -> tuple[Array, Array | float]:
            field = as_form(scene.friction).coefficients(
                lambda: scene.friction_at(points, patches, kept, velocity)
            )
            friction = field.at(pressure)
            if problem.attracting is not None:
                return friction, share * as_form(scene.magnetic_pressure).factor(velocity)
            pull = problem.upper.pull
            if scene.magnetic_pressure is not None:
                pull = scene.pull_at(points, patches, kept, velocity=velocity)
            return friction, share * pull

        return HeatedSliding(problem, posed, self.first.pressure, self.heated, steps)

    def result(self, found: dict[str, Any], said: dict[str, Any]) -> SlidingHeat:
        """Histories and last fields of its steps, and what was asked for besides."""
        problem = self.problem
        fields: dict[str, Any] = {name: problem.on_grid(found.pop(name)) for name in OVER_CONTACT}
        nodes = problem.points if problem.kept is None else problem.kept.nodes
        lower, upper, elastic = self.scene.bodies_of(problem)
        return SlidingHeat(
            lower=lower,
            upper=upper,
            elastic=elastic,
            points=nodes.points,
            area=problem.on_grid(problem.area),
            patches=problem.patches,
            summary={**self.scene.statement(), **said, "model": self.model, "heat": self.said},
            **fields,
            **found,
        )

    def failed(self, trial: Trial, why: str | None) -> ConvergenceError:
        """The error for a step without a state, or for steps that do not converge."""
        outcome = trial.outcome
        is_carried = outcome.status not in NOT_CARRIED
        if trial.runs_away and is_carried:
            return ConvergenceError(
                f"the heat runs away: within a step it moves the faces by more than {100.0 * SMALL:.0f} % of "
                "the height of the upper body, and expansion is linear here. Above the thermal limit heat "
                "grows until wear, a resistance of the contact or melting, which is not modelled, ends it: "
                "give wear or resistance, a shorter duration, or a lower speed"
            )
        if why is not None and is_carried:
            return ConvergenceError(why)
        if outcome.status == "solved" and not outcome.unstable:
            return ConvergenceError(
                "friction and the temperatures by which it fades do not settle in a step: give a tolerance, "
                "by which steps are made short enough, or more steps"
            )
        if self.heated.expands and is_carried:
            return ConvergenceError(
                "a step has no single state: its heat is above the thermal limit of so long a step; give a "
                "tolerance, by which steps are made short enough, or more steps"
            )
        n = self.problem.n
        nothing = np.zeros(n)
        state = replace(
            self.first,
            status=outcome.status,
            pressure=nothing,
            gap=nothing,
            residual=outcome.residual,
            iterations=outcome.iterations,
        )
        return failure(self.problem, state)


def _under_share(side: Side, share: float) -> Side:
    """A body under a share of its magnetic pressure."""
    state = tuple(replace(part, pull=share * part.pull) for part in side.state)
    return replace(side, pull=share * side.pull, state=state)


def _cold(scene: PosedScene, problem: ContactProblem) -> Solution:
    """The contact before any heat."""
    found = solve_direct(problem, with_margin=False)
    if found.status != "solved":
        raise failure(problem, found)
    scene.check_touching(bool((found.pressure > 0.0).any()), problem.points, problem.loads)
    return found


def heated_of(
    scene: PosedScene,
    model: Model,
    *,
    lower: Conductor = conducting_steel,
    upper: Conductor = conducting_steel,
    bulk: tuple[float, float] = (0.0, 0.0),
    film: tuple[float, float] = (0.0, 0.0),
    resistance: float = 0.0,
    share: float = 0.5,
    expansion: bool = False,
    wear: Any = None,
    lower_wear: Any = None,
    fading: tuple[ArrayLike, ArrayLike] | None = None,
) -> tuple[Model, Heated, dict[str, Any]]:
    """The model, the heat and wear, and these in words, checked: nothing is solved."""
    choice("model", model, Model)
    if model == "auto":
        model = scene.own_model or "elastic-upper"
    for side, body in zip(("upper", "lower"), scene.simple, strict=True):
        if are_layered(body):
            raise ValueError(
                f"{side} is Layered: heat needs an elastic upper body, and finite elements are not known "
                "beside a layered body; a HalfSpace or Rigid is needed"
            )
    scene.check_model(model)
    if (scene.own_model is None and not model.startswith("elastic-")) or model == "elastic-lower":
        raise ValueError(
            f"model is {model!r}: heat needs an elastic upper body, 'elastic-upper' or 'elastic-both'"
        )
    check_conductors(lower, upper)
    flag("expansion", expansion)
    if expansion and not (lower.expands or upper.expands):
        raise ValueError("expansion is True: a Conductor with a coefficient of expansion [1/K] is needed")
    heated = Heated(
        lower=lower,
        upper=upper,
        bulk=pair("bulk", bulk, "K"),
        film=film_of(film),
        resistance=not_negative("resistance", resistance, "K m2/W"),
        share=share_of(share),
        expands=bool(expansion),
        poisson=_poisson_ratio(scene) if expansion and lower.expands else None,
        wear=None if wear is None else as_wear_law("wear", wear),
        lower_wear=None if lower_wear is None else as_wear_law("lower_wear", lower_wear),
        fading=None if fading is None else fading_of(fading),
    )
    said = {
        **{"lower": lower, "upper": upper, "bulk": bulk, "film": film},
        **{"resistance": resistance, "share": share, "expansion": expansion},
        **{"wear": _in_words(heated.wear), "lower_wear": _in_words(heated.lower_wear)},
        "fading": None if heated.fading is None else [part.tolist() for part in heated.fading],
    }
    return model, heated, said


def film_of(given: tuple[float, float]) -> tuple[float, float]:
    """Coefficient [W/(m2 K)] and temperature outside [K] of a film; ValueError for what is none."""
    coefficient, ambient = pair("film", given)
    return not_negative("film[0]", coefficient, "W/(m2 K)"), ambient


def share_of(given: float) -> float:
    """Share of the heat that arises on one side of a resistance; ValueError for what is none."""
    if not 0.0 <= number("share", given) <= 1.0:
        raise ValueError(f"share is {given:g}: a number from 0 to 1 is needed")
    return float(given)


#: What takes no layered bodies.
EXPANSION = "expansion by heat"


def _poisson_ratio(scene: PosedScene) -> float | None:
    """Of the lower body, which expands; None for one that does not deform."""
    own = scene.solids.get(False)
    if are_prisms(scene.lower):
        raise ValueError(
            f"lower is {scene.lower!r}, and the lower conductor expands: heat raises the surface of a "
            "half-space, and not of a Prism; a Conductor without expansion, "
            "lower=mtb_rs.Conductor(50, 7850, 450), leaves the rise of the rail out, and a Material in place "
            "of the Prism has it"
        )
    material = own.material if own is not None else without_layers(scene.simple, EXPANSION)[1].material
    return None if material is None else float(material.poisson_ratio)


def _in_words(law: Any) -> str | None:
    return None if law is None else repr(law)


def fading_of(given: tuple[ArrayLike, ArrayLike]) -> tuple[Array, Array]:
    """Temperatures [K] and factors on the friction; ValueError for what is no such table."""
    try:
        temperatures, factors = (reals("fading", part) for part in given)
    except (TypeError, ValueError):
        raise ValueError(
            f"fading is {given!r}: two rows are needed, temperatures [K] and factors on the friction"
        ) from None
    rising = temperatures.ndim == 1 and temperatures.size > 0 and (np.diff(temperatures) > 0.0).all()
    if not rising or factors.shape != temperatures.shape or (factors < 0.0).any():
        raise ValueError(
            f"fading is {given!r}: two rows of one length are needed, temperatures [K] that rise and "
            "factors of at least 0 on the friction"
        )
    return temperatures, factors
