# SPDX-License-Identifier: MIT OR Apache-2.0
"""Bodies that vibrate on their contact, step by step in time."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .. import _mtb_rs
from ..base.check import reals
from ..base.errors import ConvergenceError
from ..base.owning import owning
from ..base.plain import plain
from ..base.questions import ask
from ..base.stored import stored
from .coordinates import Coordinates, along_x_and_y, in_units_of

Array = NDArray[np.float64]

#: Steps in a period that tell how a mass rings.
STEPS_OF_A_PERIOD = 4
#: Square of a frequency over the largest one below which it is rounding of none.
SMALLEST_SQUARE = 1e-14
#: Traction over the largest pressure that is rounding of no friction.
ROUNDING = 1e-12
#: Powers by which a largest eigenvalue is found, and change of it that is none.
POWERS, ALMOST = 100, 1e-4
#: Cosine between two fields of traction above which they are along each other.
ALIKE = 0.5


@stored
@owning
@dataclass(frozen=True)
@plain
class VibratingState:
    """Where vibrating bodies are, and from where the next step starts: plain arrays.

    Attributes
    ----------
    traction : (2, n) [Pa]
        Unknowns along both tangents of the contact points on the lower body.
    pressure : (n,) [Pa]
    amplitude, rate : (k,)
        Coordinates of :attr:`VibratingContact.coordinates`, from where the bodies were at the beginning, and
        their rates: [m], [m/s] and [rad], [rad/s] of a pose, [m kg^1/2], [m/s kg^1/2] of rigid motions and
        vibrations.
    load : (k,)
        Loads on them, besides those at the beginning.
    """

    traction: Array
    pressure: Array
    amplitude: Array
    rate: Array
    load: Array

    @property
    def _given(self) -> tuple[Array, Array, Array, Array]:
        whole = np.concatenate([self.traction.ravel(), self.pressure])
        return whole, self.amplitude, self.rate, self.load


@stored
@owning
@dataclass(frozen=True)
@plain
class VibratingStep:
    """A step of vibrating bodies.

    Attributes
    ----------
    force, moment : (3,) [N], [N m]
        Load of the contact on the lower body at the end, with the moment about the reference point.
    status : (n,)
        0 open, 1 stick, 2 slip.
    slip : (3, n) [m]
        Of the upper body over the lower one in the step, common frame.
    gap : (n,) [m]
    friction_work, drive_work, load_work, damping_work, closing_work : float [J]
        Of friction, mean traction times slip, which becomes heat; of what drives the bodies along; of the
        loads on the coordinates; of the dampers; and of the pressures of points that open or close in the
        step.
    kinetic_energy, potential_energy, contact_energy : float [J]
        Of the motion, of springs and vibrations, and of what gives way at the contact points, at the end.
        Their sum changes by ``drive_work + load_work - friction_work - damping_work + closing_work``.
    state : VibratingState
    iterations : int
        Newton steps.
    residual : float [-]
        Relative residual of the conditions of contact and friction.
    """

    force: Array
    moment: Array
    status: NDArray[np.int8]
    slip: Array
    gap: Array
    friction_work: float
    drive_work: float
    load_work: float
    damping_work: float
    closing_work: float
    kinetic_energy: float
    potential_energy: float
    contact_energy: float
    state: VibratingState
    iterations: int
    residual: float

    @property
    def energy(self) -> float:
        """All of it [J], the loads of the beginning aside: these do their part of `load_work`."""
        return self.kinetic_energy + self.potential_energy + self.contact_energy


class VibratingContact:
    """Bodies with inertia on a contact without, in steps of one length.

    :meth:`mtb_rs.PreparedContact.vibrating` makes it. Each step starts from the last one, or from a `state`.
    """

    def __init__(
        self,
        made_from: tuple[Any, ...],
        coordinates: Coordinates,
        start: VibratingState,
        forwards: tuple[float, float],
        velocity: tuple[float, float],
        tangents: Array,
        resultants: Array,
        edges: NDArray[np.intp],
    ) -> None:
        self._core = _mtb_rs.VibratingContact(*made_from)
        #: Length of a step [s].
        self.dt = float(made_from[-1])
        self._coordinates, self._last = coordinates, start
        self._drive = velocity[0] * self.dt, velocity[1] * self.dt
        self._forwards, self._tangents, self._resultants = forwards, tangents, resultants
        self._edges = edges
        # whether it has asked how the mass rings on points that stick; tractions (2, n) of those that slipped
        # last; how many stuck, and these tractions, where it was last found
        self._asked = False
        # whether it has asked how friction that falls drives points without mass
        self._asked_falling = False
        # slowest and fastest of the points in the step before
        self._speeds = (np.inf, 0.0)
        self._rubbing: Array | None = None
        self._found: tuple[int, Array] | None = None
        self._parts = made_from, coordinates, forwards, velocity, tangents, resultants, edges

    def __reduce__(self) -> tuple[Any, ...]:
        made, coordinates, *others = self._parts
        return VibratingContact, (made, coordinates, self._last, *others), self._met

    @property
    def _met(self) -> dict[str, Any]:
        return {
            name: getattr(self, name)
            for name in ("_asked", "_asked_falling", "_speeds", "_rubbing", "_found")
        }

    def copy(self) -> VibratingContact:
        """Another one that goes on from the same state by itself."""
        made, coordinates, forwards, velocity, tangents, resultants, edges = self._parts
        another = VibratingContact(
            made, coordinates, self._last, forwards, velocity, tangents, resultants, edges
        )
        another.__dict__.update(self._met)
        return another

    def __repr__(self) -> str:
        n, k = self._last.pressure.size, self._last.amplitude.size
        return f"<VibratingContact: {n} points, {k} coordinates, steps of {self.dt:g} s>"

    @property
    def coordinates(self) -> tuple[str, ...]:
        """Names (k) of what moves: components of the pose, rigid motions and vibrations of bodies."""
        return self._coordinates.names

    @property
    def mass(self) -> Array:
        """Mass matrix (k, k) of the coordinates."""
        return self._coordinates.mass.copy()

    @property
    def state(self) -> VibratingState:
        """From where the next step starts."""
        return self._last

    def energy(self, state: VibratingState | None = None) -> tuple[float, float, float]:
        """Energy [J] of the motion, of springs and vibrations, and of what gives way at the contact points.

        Parameters
        ----------
        state : VibratingState
            None: from where the next step starts.
        """
        return self._core.energy(self._checked(state)._given)

    def struck(self, rate: ArrayLike) -> VibratingState:
        """The state from which the next step starts, with these rates added to those of its coordinates.

        Parameters
        ----------
        rate : (k,)
            In the units of :class:`VibratingState`.
        """
        last = self._last
        names = self.coordinates
        added = _over("rate", in_units_of("rate", rate, names), len(names))
        return VibratingState(last.traction, last.pressure, last.amplitude, last.rate + added, last.load)

    def step(
        self,
        shift: float | Sequence[float] | None = None,
        load: ArrayLike = 0.0,
        *,
        friction: ArrayLike | None = None,
        state: VibratingState | None = None,
    ) -> VibratingStep:
        """A step of the length `dt`.

        Parameters
        ----------
        shift : float or (dx, dy) [m]
            How far the lower body is drawn away below the upper one, or the frame of the upper body driven on
            at no acceleration: displacement of the upper body over the lower one in the step, besides that of
            the coordinates. A number is along the scene's sliding direction. None: the velocity of the
            beginning times `dt`.
        load : (k,)
            Loads on the coordinates at the end of the step, besides those of the beginning, in N and N m of a
            pose and kg^1/2 m/s2 of rigid motions and vibrations; they change linearly from those at its
            start.
        friction : float or (n,) [-]
            Coefficients in place of the scene's. Tables are taken, at each contact point, at the speed with
            which it slides at the end of the step, along the slip of the step. Where they rise, that of a
            point that turned its slip within the step is at most twice its mean one.
        state : VibratingState
            To start from.

        Raises
        ------
        ValueError
            If something cannot be as given, or the contact reaches the edge of a grid beyond which the
            bodies go on.
        ConvergenceError
            If no state of stick and slip was found.
        """
        last = self._checked(state)
        x, y = self._drive if shift is None else along_x_and_y("shift", shift, "m", self._forwards)
        drive = np.einsum("kcn,c->kn", self._tangents, [x, y, 0.0]).ravel()
        rubbing = None if friction is None else _over("friction", friction, last.pressure.size)
        if rubbing is not None and (rubbing < 0.0).any():
            raise ValueError(f"friction is {float(rubbing.min()):g}: numbers of at least 0 are needed")
        names = self.coordinates
        loads = _over("load", in_units_of("load", load, names), len(names))
        try:
            out = self._core.step(last._given, drive, loads, rubbing)
        except ValueError:
            # a speed outside the table may be one that points reached as they ran away
            if rubbing is not None or self.dt >= self._needed(last):
                raise
            out = None
        if out is None:
            advice = "take a shorter dt"
            if rubbing is None and self.dt < (needed := self._needed(last)):
                advice = (
                    "friction falls with the speed of sliding, and contact points have no mass. Take a dt of "
                    f"{_rounded_up(needed)} s or more, or friction that falls less steeply"
                )
            raise ConvergenceError(f"no state of stick and slip was found for the step: {advice}", None)
        n = last.pressure.size
        if (out["traction"][2 * n + self._edges] > 0.0).any():
            raise ValueError(
                "the contact reaches the edge of its grid, but the bodies go on beyond it: prepare the scene "
                "on a wider one"
            )
        new = VibratingState(
            out["traction"][: 2 * n].reshape(2, n),
            out["traction"][2 * n :],
            out["amplitude"],
            out["rate"],
            out["load"],
        )
        turned = np.sum(last.traction * out["slip"].reshape(2, n), axis=0) < 0.0
        self._ask_about_ringing(out["points"], turned, new)
        if rubbing is None:
            self._ask_about_falling(out["points"] == 2, out["slip"].reshape(2, n), new)
        load_of = np.einsum("kcn,cn->k", self._resultants, out["traction"].reshape(3, n))
        kinetic, potential, contact = self._core.energy(new._given)
        self._last = new
        return VibratingStep(
            force=load_of[:3],
            moment=load_of[3:],
            status=out["points"],
            slip=np.einsum("kcn,kn->cn", self._tangents, out["slip"].reshape(2, n)),
            gap=out["gap"],
            friction_work=out["friction_work"],
            drive_work=out["drive_work"],
            load_work=out["load_work"],
            damping_work=out["damping_work"],
            closing_work=out["closing_work"],
            kinetic_energy=kinetic,
            potential_energy=potential,
            contact_energy=contact,
            state=new,
            iterations=out["iterations"],
            residual=out["residual"],
        )

    def _ask_about_ringing(
        self, status: NDArray[np.int8], turned: NDArray[np.bool_], new: VibratingState
    ) -> None:
        """Asks, once, where points stick after others have slipped and the mass rings on them unresolved.

        Points that slip against their traction of before have stuck within the step. It is found again as
        twice as many stick as when it was last, or after a slip in another direction.
        """
        if self._asked:
            return
        slips = status == 2
        rubbing = new.traction * slips
        if np.abs(rubbing).max() > ROUNDING * new.pressure.max():
            self._rubbing = rubbing
        sticks = (status == 1) | slips & turned
        count = int(np.count_nonzero(sticks))
        if self._rubbing is None or count == 0:
            return
        if self._found is not None:
            before, last = self._found
            known = abs(float(np.sum(last * self._rubbing)))
            is_alike = known > ALIKE * float(np.linalg.norm(last) * np.linalg.norm(self._rubbing))
            if count < 2 * before and is_alike:
                return
        self._found = count, self._rubbing
        period = self._period_of_sticking(status > 0, sticks, self._rubbing)
        if period < STEPS_OF_A_PERIOD * self.dt:
            self._asked = True
            ask(
                [
                    f"points stick, and what moves rings on the stiffness of the contact along the surface "
                    f"with a period of {period:.3g} s, which steps of {self.dt:.3g} s do not resolve: cycles "
                    "of stick and slip may come out up to twice as large. Take a dt of "
                    f"{period / STEPS_OF_A_PERIOD:.2g} s or less, and halve it until the result stays"
                ]
            )

    @cached_property
    def _largest_compliance(self) -> float:
        """Most that tractions of 1 Pa move a point along the surface [m/Pa], at the most."""
        n = self._last.pressure.size
        return float(np.abs(self._parts[0][0][: 2 * n, : 2 * n]).sum(axis=1).max())

    @cached_property
    def _falls(self) -> Array:
        """How steeply friction falls (t - 1, n) [s/m] between the speeds of its table."""
        speeds, friction = self._parts[0][2:4]
        falls: Array = -np.diff(friction, axis=0) / np.diff(speeds)[:, None]
        return np.maximum(falls, 0.0)

    def _shortest(self, falls: Array, way: Array, pressure: Array) -> float:
        """Length of a step [s] below which what falling friction gains grows from step to step.

        Contact points have no mass: a change of friction dq moves them by C dq, at C dq / dt, and so changes
        by `falls` times the pressure times that.

        Parameters
        ----------
        falls : (n,) [s/m]
        way : (2, n) [-]
            In which the points slide.
        pressure : (n,) [Pa]
        """
        compliance, n = self._parts[0][0], pressure.size
        on = np.flatnonzero(falls * pressure > 0.0)
        gives = np.zeros((on.size, on.size))
        for a in range(2):
            for b in range(2):
                block = compliance[np.ix_(a * n + on, b * n + on)]
                gives += way[a, on][:, None] * block * way[b, on]
        # it goes on by t / (t - dt) of this time t from step to step; found by powers
        driven, time, mode = (falls * pressure)[on], 0.0, np.ones(on.size)
        for _ in range(POWERS):
            mode = driven * (gives @ mode)
            before, time = time, float(np.linalg.norm(mode))
            if abs(time - before) <= ALMOST * time:
                break
            mode /= time
        return 2.0 * time

    def _needed(self, state: VibratingState) -> float:
        """The same [s] where all points slide along their tractions, at the steepest fall."""
        falls = self._falls
        if not falls.any():
            return 0.0
        size = np.hypot(*state.traction)
        way = state.traction / np.where(size > 0.0, size, 1.0)
        return self._shortest(falls.max(axis=0), way, state.pressure)

    def _ask_about_falling(self, slips: NDArray[np.bool_], slip: Array, new: VibratingState) -> None:
        """Asks, once, where friction falls so steeply that points without mass run away within a step."""
        falls = self._falls
        if self._asked_falling or not falls.any():
            return
        size, speeds = np.hypot(*slip), self._parts[0][2]
        presses = new.pressure > 0.0
        sliding = np.where(slips, size / self.dt, 0.0)[presses]
        now = float(sliding.min(initial=np.inf)), float(sliding.max(initial=0.0))
        before, self._speeds = self._speeds, now
        most = float((falls.max(axis=0) * new.pressure).max())
        if now[1] == 0.0 or self.dt >= 2.0 * most * self._largest_compliance:
            return
        # points that run away stick in one step and are beyond the steep part of the table in the next one
        slowest, fastest = min(now[0], before[0]), max(now[1], before[1])
        first, last = (int(np.searchsorted(speeds[1:-1], speed)) for speed in (slowest, fastest))
        falling = falls[first : last + 1].max(axis=0)
        way = np.where(size > 0.0, slip, new.traction)
        length = np.hypot(*way)
        if self.dt < self._shortest(falling, way / np.where(length > 0.0, length, 1.0), new.pressure):
            self._asked_falling = True
            ask(
                [
                    f"friction falls by {falling.max():.3g} s/m as the speed of sliding rises, and contact "
                    f"points have no mass: in steps of {self.dt:.3g} s they stick and slip in turn, whatever "
                    "the bodies do, and forces do not settle as steps get shorter. Take a dt of "
                    f"{_rounded_up(self._needed(new))} s or more, or friction that falls less steeply"
                ]
            )

    def _period_of_sticking(
        self, presses: NDArray[np.bool_], sticks: NDArray[np.bool_], pull: Array
    ) -> float:
        """Period [s] of the motion that yields most to a pull (2, n) [Pa] of the surface.

        It is one of the motions of the masses on their springs and on the contact points as they are; fast
        vibrations of a body near its contact yield less than the whole does. The period is infinite where
        the points that stick give the motion less than half of its stiffness.
        """
        compliance, area = self._parts[0][:2]
        areas, shapes = np.tile(area, 3), self._coordinates.shapes

        def held(points: NDArray[np.bool_]) -> Array:
            rows = np.flatnonzero(points)
            forces = areas[rows, None] * np.linalg.solve(compliance[np.ix_(rows, rows)], shapes[rows])
            stiffness = shapes[rows].T @ forces
            return np.asarray(0.5 * (stiffness + stiffness.T))

        slips = np.zeros_like(sticks)
        pressed = held(np.concatenate([slips, slips, presses]))
        stuck = held(np.concatenate([sticks, sticks, presses]))
        inverse = np.linalg.inv(np.linalg.cholesky(self._coordinates.mass))
        squares, motions = np.linalg.eigh(inverse @ (self._coordinates.stiffness + stuck) @ inverse.T)
        motions = inverse.T @ motions
        added = np.einsum("ik,ij,jk->k", motions, stuck - pressed, motions)
        pulls = (area * pull).ravel() @ shapes[: 2 * area.size] @ motions
        swings = squares > SMALLEST_SQUARE * squares.max()
        most = int(np.argmax(np.where(swings, pulls**2 / np.where(swings, squares, 1.0), 0.0)))
        return 2.0 * np.pi / np.sqrt(squares[most]) if added[most] > 0.5 * squares[most] > 0.0 else np.inf

    def _checked(self, state: VibratingState | None) -> VibratingState:
        if state is None:
            return self._last
        if not isinstance(state, VibratingState):
            raise ValueError(f"state is {state!r}: a VibratingState, the `state` of a step, is needed")
        n, k = self._last.pressure.size, len(self.coordinates)
        shapes = {"traction": (2, n), "pressure": (n,), "amplitude": (k,), "rate": (k,), "load": (k,)}
        for name, shape in shapes.items():
            if np.shape(getattr(state, name)) != shape:
                raise ValueError(
                    f"state.{name} has shape {np.shape(getattr(state, name))}: {shape} is needed"
                )
        if (state.pressure < 0.0).any():
            k = int(np.flatnonzero(state.pressure < 0.0)[0])
            raise ValueError(
                f"state.pressure[{k}] is {state.pressure[k]:g}: pressures of at least 0 are needed"
            )
        return state


def _rounded_up(value: float) -> str:
    """A number > 0 in two digits, not below it."""
    digit = 10.0 ** (math.floor(math.log10(value)) - 1)
    return f"{math.ceil(value / digit * (1.0 - 1e-9)) * digit:.2g}"


def _over(name: str, given: ArrayLike, size: int) -> Array:
    values = reals(name, given)
    if values.shape not in ((), (size,)):
        raise ValueError(f"{name} has shape {values.shape}: a number or ({size},) is needed")
    return np.array(np.broadcast_to(values, (size,)))
