# SPDX-License-Identifier: MIT OR Apache-2.0
"""Heat of friction in bodies that slide: implicit steps over the time."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from typing import Any, ClassVar, Literal

import numpy as np
from numpy.typing import NDArray

from .. import _mtb_rs
from ..base.owning import solved
from ..base.plain import plain
from ..base.progress import shares_shown
from ..base.stored import input_data, stored
from ..base.told import Row, along, in_words
from ..bodies.conductor import Conductor
from ..bodies.sides import ElasticPart
from ..geometry.contact_points import Patch
from ..results.doors import pictures
from ..results.result import Curved, Pictured
from .problem import ContactProblem, mean_tractions

Array = NDArray[np.float64]

#: What it has at each contact point.
OVER_CONTACT = (
    *("pressure", "traction", "status", "temperature_upper", "temperature_lower"),
    *("heat_flux_upper", "heat_flux_lower", "pressures", "temperatures"),
)


@stored
@solved
@dataclass(frozen=True, repr=False)
@plain
class SlidingHeat(Curved, Pictured):
    """Temperatures and pressure over the time of bodies that slide; see :meth:`Scene.sliding_heat`.

    The fields are those of the last step. Arrays with k entries have one for each step.

    Attributes
    ----------
    points : (3, n) [m]
        Contact points.
    area : (n,) [m2]
    pressure : (n,) [Pa]
    traction : (2, n) [Pa]
        On the lower body.
    status : (n,) int
        0 open, 1 stick (without friction), 2 slip.
    temperature_upper, temperature_lower : (n,) [K]
        Of the surfaces, above the level from which the bulk temperatures count: means over
        the contact points.
    heat_flux_upper, heat_flux_lower : (n,) [W/m2]
        Heat that enters each body; their sum is the power of friction.
    time : (k,) [s]
        At the end of each step.
    velocity : (k,) [m/s]
    forces : (k, 3) [N]
        On the lower body.
    friction_powers, heats_upper, heats_lower : (k,) [W]
        Heat of friction, and heat that enters the upper and the lower body.
    losses : (k,) [W]
        Heat that leaves the upper body through its film.
    stored : (k,) [J]
        Heat in the upper body since the beginning.
    peaks : (k,) [K]
        Highest temperature of a contact point.
    means : (k,) [K]
        Mean temperature of the contact face of the upper body.
    pressures : (k, n) [Pa]
    temperatures : (k, n) [K]
        Of the contact points of the upper body.
    bodies : tuple of (N,) [K]
        Temperatures of the nodes of each upper body after the last step.
    patches : tuple of Patch
    summary : Mapping
        Inputs of the scene, and of the heat.
    """

    # what the user has said
    _unbounded = ("summary",)

    points: Array
    area: Array
    pressure: Array
    traction: Array
    status: NDArray[np.int8]
    temperature_upper: Array
    temperature_lower: Array
    heat_flux_upper: Array
    heat_flux_lower: Array
    time: Array
    velocity: Array
    forces: Array
    friction_powers: Array
    heats_upper: Array
    heats_lower: Array
    losses: Array
    stored: Array
    peaks: Array
    means: Array
    pressures: Array
    temperatures: Array
    bodies: tuple[Array, ...]
    patches: tuple[Patch, ...] = ()
    summary: Mapping[str, Any] = field(default_factory=dict)
    _drawn: ClassVar[tuple[str, ...]] = (
        "points", "area", "pressure", "traction", "temperature_upper", "temperature_lower",
        "heat_flux_upper", "heat_flux_lower", "status",
    )  # fmt: skip
    curves: ClassVar[tuple[str, ...]] = (
        "peaks", "means", "friction_powers", "heats_upper", "heats_lower", "losses", "stored",
    )  # fmt: skip
    over: ClassVar[str] = "the time"
    _summed: ClassVar[tuple[str, ...]] = ("force", "friction_power", "heat_lower", "heat_upper")

    @property
    def force(self) -> Array:
        """Force on the lower body (3,) [N] in the last step."""
        return np.asarray(self.forces[-1])

    @property
    def friction_power(self) -> float:
        """Heat of friction [W] in the last step."""
        return float(self.friction_powers[-1])

    @property
    def heat_upper(self) -> float:
        """Heat that enters the upper body [W] in the last step."""
        return float(self.heats_upper[-1])

    @property
    def heat_lower(self) -> float:
        """Heat that enters the lower body [W] in the last step."""
        return float(self.heats_lower[-1])

    def _line(self, quantity: str, ax: Any) -> Any:
        return pictures().draw_heat(self, quantity, ax)

    def _kept(self) -> SlidingHeat:
        return replace(self, summary=input_data(self.summary))

    def facts(self) -> dict[str, Any]:
        """What else its `summary.json` holds: inputs, and the highest temperatures."""
        return {"inputs": self.summary, "time": self.time, "peaks": self.peaks}

    def told(self) -> list[Row]:
        """What happened, in words: what a notebook and the command line show."""
        return [
            ("time", f"{in_words(float(self.time[-1]), 's')} in {self.time.size} steps"),
            ("force on the lower body", along(self.force, "N")),
            ("highest temperature", in_words(float(self.peaks.max()), "K")),
            ("heat in the upper body", in_words(float(self.stored[-1]), "J")),
            ("peak pressure", f"{self.pressure.max() / 1e6:.5g} MPa"),
        ]

    def __repr__(self) -> str:
        return (
            f"{type(self).__name__}({self.time.size} steps to {self.time[-1]:.4g} s, "
            f"{self.area.size} points, highest {self.peaks.max():.4g} K)"
        )


@dataclass(frozen=True)
class Heated:
    """What is said of heat, checked: lower body first where there are two numbers."""

    duration: float
    steps: int
    velocity: Callable[[float], float]
    lower: Conductor
    upper: Conductor
    bulk: tuple[float, float]
    film: tuple[float, float]
    resistance: float
    share: float


@dataclass(frozen=True)
class _Body:
    """An upper body that conducts, and its contact points."""

    points: slice
    conducting: _mtb_rs.ConductingBody
    step: _mtb_rs.ConductionStep

    @classmethod
    def of(cls, part: ElasticPart, heated: Heated) -> _Body:
        body = part.body
        coefficient, ambient = heated.film
        contact = set(body.contact_faces.tolist())
        free = [k for k in range(len(body.faces)) if k not in contact]
        films = [(free, coefficient, ambient)] if coefficient else []
        sampling = part.sampling()
        conducting = _mtb_rs.ConductingBody(body.core_mesh, heated.upper.constants, films)
        step = conducting.step(heated.duration / heated.steps, sampling)
        return cls(slice(part.first, part.first + sampling.n_points), conducting, step)


def _rectangles(problem: ContactProblem) -> tuple[Array, Array]:
    """Centres and sizes (n, 2) [m] of the rectangles that the contact points stand for, along x and y."""
    count = sum(patch.nx * patch.ny for patch in problem.patches)
    lengths, moved = np.empty(count), np.zeros(count)
    for patch in problem.patches:
        length = np.full((patch.ny, patch.nx), patch.spacing[0])
        inwards = np.zeros((patch.ny, patch.nx))
        if problem.averages is not None and patch.nx > 1:
            # hats at both ends reach inwards only
            length[:, [0, -1]] *= 0.5
            inwards[:, 0], inwards[:, -1] = 0.25 * patch.spacing[0], -0.25 * patch.spacing[0]
        lengths[patch.cut], moved[patch.cut] = length.ravel(), inwards.ravel()
    if problem.kept is not None:
        lengths, moved = lengths[problem.kept.numbers], moved[problem.kept.numbers]
    x, y = problem.points.points[:2]
    return np.stack([x + moved, y], axis=1), np.stack([lengths, problem.area / lengths], axis=1)


class _Passing:
    """The lower body, which passes below the contact and comes back cold."""

    def __init__(self, problem: ContactProblem, conductor: Conductor, speed: float) -> None:
        way = problem.direction @ problem.area
        self.way = way / np.linalg.norm(way)
        self.places, self.sizes = _rectangles(problem)
        self.conductor = conductor
        self.length = float(np.ptp(self.places @ self.way))
        self.speed = speed
        #: Times [s] and distances [m] of sliding so far.
        self.times, self.distances = [0.0], [0.0]
        self._last: tuple[float, Array] | None = None

    def response(self, time: float, speed: float) -> Array:
        """Temperatures (n, n) [K m2/W] by a unit flux into each point, at a time [s] with a speed [m/s].

        The lower body passes with the mean speed of what is now at the rear end, since it came to the front
        end. Where all of it has been below the contact from the beginning, it has been there for this time.
        """
        gone = self.distances[-1] + 0.5 * (self.speed + speed) * (time - self.times[-1])
        self.speed = speed
        self.times.append(time)
        self.distances.append(gone)
        entered = float(np.interp(gone - self.length, self.distances, self.times))
        passing = self.length / (time - entered) if gone > 0.0 else self.length / time
        if self._last is None or abs(self._last[0] / passing - 1.0) > 1e-12:
            velocity = (-passing * float(self.way[0]), -passing * float(self.way[1]))
            given = self.conductor.constants, velocity, self.places, self.sizes
            self._last = passing, _mtb_rs.moving_half_space(*given)
        return self._last[1]


def slide_and_heat(
    problem: ContactProblem,
    posed: Callable[[float, Array], tuple[Array, Array]],
    pressure: Array,
    heated: Heated,
    failed: Callable[[Any], Exception],
    progress: Callable[[float], Any] | Literal[True] | None = None,
) -> dict[str, Any]:
    """Histories and last fields of bodies that slide and heat each other.

    Parameters
    ----------
    problem : ContactProblem
    posed : function
        Friction (n,) and magnetic pressure (n,) [Pa] at a velocity [m/s] and under the pressure (n,) [Pa] of
        the step before.
    pressure : (n,) [Pa]
        At the beginning.
    heated : Heated
    failed : function
        The error for a state that was not found.
    """
    n, dt = problem.n, heated.duration / heated.steps
    bodies = [_Body.of(part, heated) for part in problem.upper.state]
    passing = _Passing(problem, heated.lower, heated.velocity(0.0))
    direction = np.ascontiguousarray(problem.direction)
    temperatures = [np.full(len(part.body.mesh.nodes), heated.bulk[1]) for part in problem.upper.state]

    def held() -> float:
        return sum(body.conducting.heat(warm) for body, warm in zip(bodies, temperatures, strict=True))

    # of the velocity, what lies along friction: in the mean over each contact point, as in resultants
    frames = problem.geometry.tangents if problem.averages is None else problem.averages.frames[:2]
    along = np.array([*passing.way, 0.0])
    share_of_speed = np.einsum("kcn,kn,c->n", frames, direction, along)
    response = np.zeros((2, n, n))
    for body in bodies:
        response[1, body.points, body.points] = body.step.response
    before = np.full((2, n), heated.bulk[0])
    start, active = held(), (pressure > 0.0).tolist()
    area = np.concatenate([problem.area[body.points] for body in bodies])
    histories: dict[str, list[Any]] = {}
    with shares_shown(progress, "heat") as told:
        for k in range(heated.steps):
            time = (k + 1) * dt
            speed = heated.velocity(time)
            friction, pull = posed(speed, pressure)
            response[0] = passing.response(time, speed)
            for body, warm in zip(bodies, temperatures, strict=True):
                coasted = body.step.advance(warm, np.zeros(body.step.weights.size))
                before[1, body.points] = body.step.observe(coasted)
            outcome, flux, surface, _ = problem.core.slide_heated(
                problem.loading_by(pull, pull if problem.lower.pull.any() else problem.lower.pull),
                direction,
                np.ascontiguousarray(friction),
                response,
                before,
                speed * share_of_speed,
                (heated.resistance, heated.share),
                active,
            )
            if outcome.status != "solved":
                raise failed(outcome)
            pressure, active = outcome.pressure, (outcome.pressure > 0.0).tolist()
            temperatures = [
                body.step.advance(warm, np.ascontiguousarray(flux[1, body.points]))
                for body, warm in zip(bodies, temperatures, strict=True)
            ]
            tractions = np.concatenate([outcome.traction, outcome.pressure[None]])
            mean = mean_tractions(problem, np.ascontiguousarray(tractions))
            face = np.concatenate([surface[1, body.points] for body in bodies])
            entered = flux @ problem.area
            row = {
                "time": time,
                "velocity": speed,
                "forces": outcome.force,
                "friction_powers": entered.sum(),
                "heats_upper": entered[1],
                "heats_lower": entered[0],
                "losses": sum(
                    body.conducting.loss(warm) for body, warm in zip(bodies, temperatures, strict=True)
                ),
                "stored": held() - start,
                "peaks": surface.max(),
                "means": float(face @ area / area.sum()),
                "pressures": mean[2],
                "temperatures": surface[1],
            }
            for name, value in row.items():
                histories.setdefault(name, []).append(value)
            told((k + 1) / heated.steps)
    last = {
        "pressure": mean[2],
        "traction": mean[:2],
        "status": outcome.points,
        "temperature_upper": surface[1],
        "temperature_lower": surface[0],
        "heat_flux_upper": flux[1],
        "heat_flux_lower": flux[0],
        "bodies": tuple(temperatures),
    }
    return {**{name: np.array(values) for name, values in histories.items()}, **last}
