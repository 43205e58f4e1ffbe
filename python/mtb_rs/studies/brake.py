# SPDX-License-Identifier: MIT OR Apache-2.0
"""Stops: shoes that heat, expand and wear brake a vehicle, whose speed follows from their forces."""

from __future__ import annotations

import inspect
import math
import os
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from .. import _mtb_rs
from ..base.check import in_place, not_negative, positive, reals
from ..base.errors import ConvergenceError
from ..base.progress import shares_shown
from ..base.stored import input_data, without_functions
from ..base.units import taking_quantities
from ..base.words import Model
from ..contact.heated_steps import Heated, HeatedSliding, Trial
from ..contact.sliding_heat import Histories, Steps, stuck
from ..scenes.heating import HeatedScene, check_tolerance, heated_of
from ..scenes.scene import Scene, WheelScene
from .braking import Braking
from .sweep_checkpoint import Record, StepCheckpoint

Array = NDArray[np.float64]

#: The longest step [s], and solves of a step in which its mean speed settles.
LONGEST, SETTLING = 1.0, 20
#: A stop [s] that is none: more than a day, of more steps than anyone waits for.
ENDLESS = 1e5
#: Change of the speed at the end of a step, over its mean speed, that counts as none. The energy closes all
#: the same, and what it leaves open is of a higher order in the length of the step than the step's own error.
SETTLED = 1e-4
#: Change of the length of the last step, over its length, that counts as none: it ends at rest.
ENDED = 1e-12
#: Rise of the surface along the way up to which it is level: pressures do this share of their work on it.
LEVEL = 1e-3


@taking_quantities
def brake(
    scene: Scene,
    speed: float,
    mass: float,
    other_force: float | Callable[[float], float] = 0.0,
    *,
    shares: Sequence[float] = (1.0,),
    tolerance: float = 0.1,
    model: Model = "auto",
    checkpoint: str | os.PathLike[str] | None = None,
    progress: Callable[[float], Any] | Literal[True] | None = None,
    **heat: Any,
) -> Braking:
    """Brakes a vehicle by shoes until it stands.

    Each step is one contact problem of each shoe, with its heat, expansion and wear, and the speed at its end
    follows from all forces. Friction, pull and other forces are those at its mean speed, so that time and way
    are of second order in its length, under the pressure of the step before and at the temperature at its
    end. The speed at the end of a step is what the work over its way leaves, so that the energy closes; its
    way is that of its mean speed to 1e-4.

    Parameters
    ----------
    scene : Scene
        A shoe that slides along its direction, with a magnetic pressure; tables over the velocity follow the
        speed.
    speed : float [m/s]
        At the beginning.
    mass : float [kg]
        Of the vehicle, or of its share on these shoes, rotating masses included.
    other_force : float or function [N]
        Force of all other brakes, or a function of the speed [m/s] that gives it.
    shares : sequence of float [-]
        Share of the magnetic pressure of each shoe. Shoes with the same one are solved once.
    tolerance : float [-]
        Error of each step by which their lengths are chosen.
    model : "auto", "elastic-upper" or "elastic-both"
    checkpoint : path
        File that keeps the steps. The same stop that is called again with it goes on where it was stopped.
    progress : callable or True
        Called with the share of the kinetic energy that is gone. True shows a bar (extra ``notebook``).
    **heat
        Conductors, expansion, wear and the like, as of :meth:`Scene.sliding_heat`.

    Returns
    -------
    Braking

    Raises
    ------
    ValueError
        For bad input, a way along which the surface rises, and where so little brakes that it would not stand
        within a day.
    ConvergenceError
        If a step has no solution, or none is short enough, and where nothing brakes.
    """
    posed, stated, pulls = posed_shoe(
        scene, speed, mass, shares=shares, tolerance=tolerance, model=model, **heat
    )
    speed, mass = float(speed), float(mass)
    given = [posed, posed.inputs, *stated[:2], speed, mass, other_force, pulls, float(tolerance)]
    with (
        shares_shown(progress, "braking") as told,
        StepCheckpoint(
            checkpoint, given, "stop", "scene, vehicle, shares, heat, wear, model, tolerance"
        ) as kept,
    ):
        shoe = HeatedScene.of(posed, *stated)
        shoe.check_speed("speed", speed)
        ride = Ride(shoe, speed, mass, other_force, pulls, tolerance, kept)
        ride.run(told)
    said = {
        **{"speed": speed, "mass": mass, "other_force": without_functions(other_force)},
        **{"shares": pulls.tolist(), "tolerance": tolerance},
    }
    return ride.result(said)


def posed_shoe(
    scene: Scene,
    speed: float,
    mass: float,
    *,
    shares: Sequence[float] = (1.0,),
    tolerance: float = 0.1,
    model: Model = "auto",
    **heat: Any,
) -> tuple[Scene, tuple[Model, Heated, dict[str, Any]], Array]:
    """The scene at the beginning of :func:`brake`, its heat and wear, and the shares of the pull.

    ValueError for bad input, before anything is solved.
    """
    if isinstance(scene, WheelScene) or not isinstance(scene, Scene):
        raise ValueError(f"scene is {scene!r}: a Scene that slides is needed")
    if scene.magnetic_pressure is None:
        raise ValueError("magnetic_pressure is None: the shoes of a brake are pulled by one")
    positive("speed", speed, "m/s")
    positive("mass", mass, "kg")
    check_tolerance("tolerance", tolerance)
    pulls = pulls_of(shares)
    if set(heat) & {"duration", "steps", "velocity"}:
        raise ValueError("duration, steps and velocity follow from the stop: leave them out")
    known = list(inspect.signature(heated_of).parameters)[2:]
    for name in heat:
        if name not in known:
            hint = in_place(name, known, "it takes")
            raise ValueError(f"{name} is no argument of brake: {hint}")
    # tables over the velocity are those at the beginning until the first step
    posed = scene.with_(velocity=float(speed))
    return posed, heated_of(posed, model, **heat), pulls


def pulls_of(shares: Sequence[float]) -> Array:
    """Shares of the magnetic pressure; ValueError for what is not one positive number for each shoe."""
    pulls = reals("shares", shares)
    if pulls.ndim != 1 or pulls.size == 0 or (pulls <= 0.0).any():
        raise ValueError(f"shares is {shares!r}: a positive number for each shoe is needed")
    return pulls


@dataclass
class Step:
    """A step of a stop: its length [s], the shoes, the force of all [N], the speed [m/s] at its end, the
    force of the other brakes [N], and its error, NaN for one without a state; whether its mean speed is that
    of its forces."""

    length: float
    trials: list[Trial]
    force: float
    after: float
    other: float
    error: float = float("nan")
    is_settled: bool = True


class Ride:
    """A stop on its way; `worn` is the depth (n,) [m] taken off before it, for each different share."""

    def __init__(
        self,
        shoe: HeatedScene,
        speed: float,
        mass: float,
        other: float | Callable[[float], float],
        pulls: Array,
        tolerance: float,
        kept: StepCheckpoint,
        worn: Sequence[Array] | None = None,
    ) -> None:
        self.shoe, self.mass, self.other, self.first, self.kept = shoe, mass, other, speed, kept
        self.shares, self.of, self.counts = np.unique(pulls, return_inverse=True, return_counts=True)
        before = [None] * self.shares.size if worn is None else worn
        self.shoes = [
            shoe.of_shoe(float(share), depth) for share, depth in zip(self.shares, before, strict=True)
        ]
        self.sliding = [
            one.sliding(float(share), steps=None) for one, share in zip(self.shoes, self.shares, strict=True)
        ]
        self._check_level()
        # tables that end above standstill are told before the first step
        self.sliding[0].posed(0.0, shoe.first.pressure)
        for other_one in self.sliding[1:]:
            # the rail answers all shoes alike
            other_one.passing.share_table(self.sliding[0].passing)
        records = kept.in_order()
        self.plan = Steps(LONGEST, tolerance, records[-1]["numbers"][0] if records else None)
        self.histories = [Histories() for _ in self.sliding]
        self.time, self.speed, self.way = [0.0], [speed], [0.0]
        self.forces: list[Array] = []
        self.others: list[float] = []
        self.errors: list[float] = []
        self.deceleration: float | None = None
        for record in records:
            self._recall(record)

    def _check_level(self) -> None:
        """ValueError where the pressure would brake, as the surface rises along the way."""
        sliding = self.sliding[0]
        rise = float(np.abs(sliding.passing.along @ sliding.problem.points.normal[:2]).max())
        if rise > LEVEL:
            raise ValueError(
                f"sliding_direction is {self.shoe.scene.sliding_direction}: the surface below the shoe rises "
                f"by up to {rise:.2g} along it, where pressure would brake as well as friction: a stop runs "
                "along a surface that does not rise, as a rail along (1, 0)"
            )

    def run(self, told: Callable[[float], Any]) -> None:
        """Steps until it stands."""
        most = 2**self.plan.HALVES
        told(1.0 - (self.speed[-1] / self.first) ** 2)
        while self.speed[-1] > 1e-9 * self.first:
            step, _ = self.plan.taken(most, self._tried, self._failed)
            self._keep(step)
            self._take(step)
            told(1.0 - (self.speed[-1] / self.first) ** 2)

    def _take(self, step: Step) -> None:
        for sliding, history, trial in zip(self.sliding, self.histories, step.trials, strict=True):
            history.add(sliding.take(trial), step.after)
        self.deceleration = step.force / self.mass
        self._check_end(step)
        self.time.append(self.time[-1] + step.length)
        self.way.append(self.way[-1] + step.trials[0].way)
        self.speed.append(step.after)
        self.forces.append(self._along(step.trials))
        self.others.append(step.other)
        self.errors.append(step.error)

    def _check_end(self, step: Step) -> None:
        """ValueError for a vehicle that would not stand within the day."""
        left = step.after * self.mass / step.force
        if left > ENDLESS:
            raise ValueError(
                f"mass is {self.mass:g} kg: a force of {step.force:.4g} N brakes it at {step.after:.4g} m/s, "
                f"so that it would stand after {left:.2g} s, and at most {ENDLESS:.0e} s are computed: a "
                "smaller mass or stronger brakes are needed"
            )

    def _keep(self, step: Step) -> None:
        """Writes a step that is taken into the checkpoint."""
        parts = [trial.kept() for trial in step.trials]
        control = self.plan.control
        assert control is not None
        numbers = [control.next, step.length, step.force, step.after, step.other, step.error]
        shoes = {f"{name}.{k}": values for k, part in enumerate(parts) for name, values in part.items()}
        self.kept.add(len(self.forces), {"status": "solved", "numbers": numbers, **shoes})

    def _recall(self, record: Record) -> None:
        """Goes on by a step of the checkpoint."""
        trials = []
        for k, sliding in enumerate(self.sliding):
            own = {name.removesuffix(f".{k}"): of for name, of in record.items() if name.endswith(f".{k}")}
            trials.append(sliding.recalled(own))
        _, length, force, after, other, error = record["numbers"]
        self._take(Step(length, trials, force, after, other, error))

    def _failed(self, step: Step, length: float | None) -> ConvergenceError:
        bad = next((trial for trial in step.trials if not trial.is_state), step.trials[0])
        why = None
        if length is not None:
            # of the shoe that is pulled most
            heat = self.shoes[-1].sliding(float(self.shares[-1]), steps=None)
            why = stuck(self.time[-1], length, heat.thermal_margin(LONGEST, self.first))
        return self.shoe.failed(bad, why)

    def _along(self, trials: list[Trial]) -> Array:
        way = self.sliding[0].passing.along
        return np.array([float(trial.force[:2] @ way) for trial in trials])

    def _other(self, speed: float) -> float:
        try:
            given = self.other(speed) if callable(self.other) else self.other
        except TypeError as error:
            raise ValueError(
                f"other_force is {self.other!r}, which fails at {speed:g} m/s: {error}; a force [N] or a "
                "function of the speed is needed"
            ) from error
        where = f" at {speed:g} m/s" if callable(self.other) else ""
        return not_negative(f"other_force{where}", given, "N")

    def _tried(self, units: int) -> tuple[Step, float, float]:
        """A step of at most so many shortest ones, its length and its error."""
        step = self._settled(self.plan.seconds(units))
        if step.is_settled and all(trial.is_state for trial in step.trials):
            step.error = self._error(step)
        return step, step.length, step.error

    def _settled(self, longest: float) -> Step:
        """A step of at most a length [s], whose mean speed is that of its forces.

        The speed at its end is that which the work of the forces along its way leaves: so the energy closes,
        also where the mean speed is a little off.
        """
        before, length = self.speed[-1], longest
        slowed = before - length * (self.deceleration or 0.0)
        after = max(slowed, 0.0)
        for _ in range(SETTLING):
            if slowed <= 0.0:
                after = 0.0
            mean = 0.5 * (before + after)
            other = self._other(mean)
            trials = [one.tried(length, mean, mean) for one in self.sliding]
            if not all(trial.is_state for trial in trials):
                # a shorter step is tried at once
                return Step(length, trials, float("nan"), before, other)
            force = float(self._along(trials) @ self.counts) + other
            if not force > 0.0:
                raise ConvergenceError(f"nothing brakes at {self.time[-1]:.4g} s: the force is {force:.4g} N")
            left = before**2 - 2.0 * mean * length * force / self.mass
            now = math.sqrt(max(left, 0.0))
            stop = before * self.mass / force
            if stop <= (1.0 + ENDED) * longest:
                # it stands before the step ends
                if slowed <= 0.0 and abs(stop - length) <= ENDED * length:
                    return Step(length, trials, force, 0.0, other)
                slowed, length = 0.0, stop
                continue
            if slowed > 0.0 and left >= -ENDED * before**2 and abs(now - after) <= SETTLED * mean:
                return Step(length, trials, force, now, other)
            slowed = after = before - length * force / self.mass
        # so is one whose heat and speed do not agree
        return Step(length, trials, force, now, other, is_settled=False)

    def _error(self, step: Step) -> float:
        one = np.ones(1)
        before = np.array([self.first - self.speed[-1]])
        now = step.force / self.mass
        known = now if self.deceleration is None else self.deceleration
        of_speed = _mtb_rs.step_error(one, before, step.length, known * one, now * one)
        return max(of_speed, *(trial.error for trial in step.trials))

    def _margin(self, shoe: HeatedScene, sliding: HeatedSliding, share: float) -> float | None:
        """The thermal margin of a step as long as the stop, of a shoe as it was at the beginning."""
        if not shoe.heated.expands:
            return None
        begun = shoe.sliding(share, steps=None)
        begun.passing.share_table(sliding.passing)
        return begun.thermal_margin(self.time[-1], self.first)

    def result(self, said: dict[str, Any]) -> Braking:
        parts = zip(self.shoes, self.sliding, self.histories, self.shares, strict=True)
        shoes = [
            one.result(
                history.found(sliding, self._margin(one, sliding, float(share))),
                {**said, "share_of_pull": float(share)},
            )
            for one, sliding, history, share in parts
        ]
        return Braking(
            time=np.array(self.time),
            speed=np.array(self.speed),
            way=np.array(self.way),
            forces=np.array(self.forces)[:, self.of],
            other_force=np.array(self.others),
            errors=np.array(self.errors),
            mass=self.mass,
            shoes=tuple(shoes[k] for k in self.of),
            summary=input_data({**self.shoe.scene.statement(), **said, "heat": self.shoe.said}),
        )
