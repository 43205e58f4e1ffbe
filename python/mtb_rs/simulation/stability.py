# SPDX-License-Identifier: MIT OR Apache-2.0
"""Stability of steady sliding: vibrations of a body on springs and on its prepared contact."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar, Literal, Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..base.check import positive
from ..base.errors import ConvergenceError, ResultantError
from ..base.owning import owning
from ..base.plain import plain
from ..base.stored import stored
from ..base.told import Row
from ..friction.fields import LARGEST_FRICTION
from ..results.doors import pictures, png
from ..results.study import Study
from .coordinates import POSE, Coordinates, free_of, matrix_of
from .drag import Answer, Drag

Array = NDArray[np.float64]
Modes = NDArray[np.complex128]
Kind = Literal["stable", "flutter", "divergence"]

#: Coefficients of friction at which the smallest unstable one is looked for, before halving.
STEPS = 60
#: Growth over the largest eigenvalue that counts as none: rounding of the root of a number, and of a number.
LEAST, SIMPLE = 1e-7, 1e-11
#: Size of an eigenvalue over the largest one that may be a double zero.
MEETS = 1e-6
#: Share of an eigenvalue that is rounding, and rounds that may come no nearer.
ROUNDING, LATE = 1e-13, 3
#: Size of an eigenvalue over the largest one below which its rounding counts, and one that nothing has.
SLOW, ASIDE = 1e-3, 1.37
#: How much quicker motions may be that friction holds than those that a damper slows down.
FASTER = 3.0
#: Rounds in which the pose is found from balance, and share of the load that may be missed then.
ROUNDS, FOUND = 60, 1e-9
#: The longest way of a round over the length of the contact.
FAR = 0.1
#: Share of the largest displacement below which a component of a motion is rounding.
NEGLIGIBLE = 1e-6

#: The motion (6,) about the reference point by amplitudes of motions, NaN of those that do not count, and by
#: the components of the pose that these are.
MovedBy = Callable[[Array, Sequence[str]], Array]


class Sliding(Protocol):
    """A contact that takes steps, as :class:`mtb_rs.PreparedContact`."""

    @property
    def points(self) -> Array: ...
    @property
    def area(self) -> Array: ...
    @property
    def motions(self) -> list[str]: ...
    @property
    def reference_point(self) -> Array: ...
    @property
    def step(self) -> Callable[..., Any]: ...


@stored
@owning
@dataclass(frozen=True)
@plain
class Stability(Study):
    """Vibrations about a state of sliding, as :meth:`mtb_rs.PreparedContact.stability` finds them.

    Attributes
    ----------
    free : tuple of str
        Coordinates, m of them: components of the pose that move, then vibrations of elastic bodies.
    frequency : (k,) [Hz]
        Of each vibration, rising; 0 for motions that do not swing.
    growth : (k,) [1/s]
        Rate at which it grows (> 0) or decays.
    shapes : (2, k, m)
        Real and imaginary part of the shape of each over `free` [m] and [rad], and [m kg^1/2] of vibrations,
        the largest component 1.
    kind : "stable", "flutter" or "divergence"
        Whether nothing grows, something swings and grows, or something grows without swinging. Of eigenvalues
        under 1e-6 of the largest one, growth under 1e-7 of that is rounding and does not count.
    friction : float [-]
        Coefficient of friction, of tables and fields the mean weighted with the pressure.
    critical_friction : float or None [-]
        The least coefficient at which something grows, if all coefficients grow by one factor; None: none up
        to the largest one that was looked at.
    critical_frequency : float or None [Hz]
        Of what begins to grow there; 0 if it does not swing.
    mass, damping, stiffness : (m, m)
        Matrices of the equations of motion, the contact's parts included: of the damping that of slow
        motions. Friction moves the faces whose slip it follows, and the eigenvalues count that besides.
    pose : (6,) [m], [rad]
        About which they are linear.
    velocity : (2,) [m/s]
    frictions : (n,) [-]
        Coefficients up to the largest one, for pictures.
    frequencies, growths : (n, w) [Hz], [1/s]
        Of all eigenvalues at these, at least 2m; NaN where fewer motions swing, or no state of sliding was
        found.
    reference_point : (3,) [m]
        About which the body turns.
    outline : (2, 3) [m]
        Least and largest coordinates of the contact points and the reference point, for pictures.
    """

    usual_name: ClassVar[str] = "stability"
    called: ClassVar[str] = "stability"
    endings: ClassVar[tuple[str, ...]] = ("png", "csv")

    free: tuple[str, ...]
    frequency: Array
    growth: Array
    shapes: Array
    kind: Kind
    friction: float
    critical_friction: float | None
    critical_frequency: float | None
    mass: Array
    damping: Array
    stiffness: Array
    pose: Array
    velocity: Array
    frictions: Array
    frequencies: Array
    growths: Array
    reference_point: Array
    outline: Array

    @property
    def eigenvalues(self) -> Modes:
        """Growth + i 2 pi frequency (k,) [1/s]."""
        return np.asarray(self.growth + 2j * np.pi * self.frequency)

    @property
    def modes(self) -> Modes:
        """Shape of each vibration over `free` (k, m) [m] and [rad]: the displacement is the real part of
        the shape times exp(eigenvalue t)."""
        return np.asarray(self.shapes[0] + 1j * self.shapes[1])

    @property
    def damping_ratio(self) -> Array:
        """Of each vibration (k,) [-]; below zero where it grows, 1 where it does not swing and decays."""
        size = np.abs(self.eigenvalues)
        return np.asarray(-self.growth / np.where(size > 0.0, size, 1.0))

    def growing(self) -> NDArray[np.bool_]:
        """Which eigenvalues grow (n, w) at the coefficients of `frictions`."""
        values = self.growths + 2j * np.pi * self.frequencies
        return np.array([_grows(np.nan_to_num(row)) for row in values])

    def plot(self, ax: Any = None) -> Any:
        """Frequencies and growth over the coefficient of friction; returns the figure.

        Parameters
        ----------
        ax : pair of matplotlib.axes.Axes, optional
            For the frequencies and for the growth.
        """
        return pictures().draw_stability(self, ax)

    def animate(self, path: str | Path, mode: int | None = None, frames_per_second: float = 12.0) -> Path:
        """A moving picture (.gif, .webp or .png) of a vibration, much enlarged, seen from the side.

        Parameters
        ----------
        path : str or Path
        mode : int or None
            Which row of `modes`; None: the one that grows most, or decays least.
        frames_per_second : float [1/s]
        """
        return Path(pictures().animate_stability(self, path, mode, frames_per_second))

    def told(self) -> list[Row]:
        """Its figures in words: what a notebook shows beside the picture."""
        rows: list[Row] = [
            ("state of sliding", self.kind),
            ("coefficient of friction", f"{self.friction:.4g}"),
        ]
        if self.critical_friction is None:
            rows.append(("smallest unstable coefficient", f"none up to {self.frictions[-1]:.4g}"))
        else:
            swings = "" if not self.critical_frequency else f" at {self.critical_frequency:.5g} Hz"
            rows.append(("smallest unstable coefficient", f"{self.critical_friction:.4g}{swings}"))
        for frequency, growth in zip(self.frequency, self.growth, strict=True):
            rows.append((f"{frequency:.5g} Hz", f"{growth:+.3g} 1/s"))
        return rows

    def columns(self) -> dict[str, Array]:
        """Coefficients of friction, and frequency and growth of each eigenvalue at them."""
        found = {"friction": self.frictions}
        for k in range(self.frequencies.shape[1]):
            found |= {f"frequency_{k}": self.frequencies[:, k], f"growth_{k}": self.growths[:, k]}
        return found

    def exports(self) -> tuple[dict[str, bytes], list[str]]:
        """A picture, and the columns as CSV."""
        columns = self.columns()
        units = {"friction": "-", "frequency": "Hz", "growth": "1/s"}
        head = ",".join(f"{name} [{units[name.partition('_')[0]]}]" for name in columns)
        rows = np.array(list(columns.values())).T.tolist()
        lines = [head, *(",".join(f"{value!r}" for value in row) for row in rows)]
        with pictures().own_figures():
            return {"png": png(self.plot()), "csv": "".join(f"{line}\n" for line in lines).encode()}, []

    def check(self) -> None:
        """Checks that what was read from files fits together; ValueError if it does not."""
        m, k, n = len(self.free), self.frequency.size, self.frictions.size
        shapes = {
            "growth": (self.growth, (k,)),
            "shapes": (self.shapes, (2, k, m)),
            "mass": (self.mass, (m, m)),
            "damping": (self.damping, (m, m)),
            "stiffness": (self.stiffness, (m, m)),
            "frequencies": (self.frequencies, (n, max(2 * m, self.growths.shape[-1]))),
            "growths": (self.growths, np.shape(self.frequencies)),
            "outline": (self.outline, (2, 3)),
        }
        for name, (values, shape) in shapes.items():
            if np.shape(values) != shape:
                raise ValueError(f"{name} has the shape {np.shape(values)}: {shape} is needed")

    def _repr_png_(self) -> bytes | None:
        """Its picture, for notebooks."""
        with pictures().own_figures():
            return png(self.plot())


def _balanced(stepped: Callable[[Array], Any], pose: Array, contact: Sliding, moved_by: MovedBy) -> Array:
    """The pose (6,) about the reference point in which a contact is that a step from balance finds.

    Components that are NaN are found, as far as the scene has motions of this name, and 0 otherwise. What is
    given holds the middle of a contact, and so may change as a body turns freely about that.
    """
    placed = np.where(np.isnan(pose), 0.0, pose)
    names = [motion.split()[-1] for motion in contact.motions]
    # those of the lower body, and others that are no component of a pose, stay free
    found = [k for k, name in enumerate(names) if name not in POSE or np.isnan(pose[POSE.index(name)])]
    own = {k for k in found if names[k] in POSE}
    if not own:
        return placed
    carried = stepped(pose)
    amplitudes = np.full(len(names), np.nan)
    amplitudes[found] = np.where([k in own for k in found], carried.state.motion, np.nan)
    moved = moved_by(amplitudes, [names[k] for k in own])
    placed = placed + moved
    # which of them open the contact or are known as motions: others do nothing that a load could tell
    extent = float(np.ptp(contact.points, axis=1).max())
    arm = np.array([1.0] * 3 + [extent] * 3)
    size = np.abs(moved) * arm
    named = {POSE.index(names[k]) for k in own}
    rows = [k for k in range(6) if k in named or (2 <= k <= 4 and size[k] > NEGLIGIBLE * size.max())]
    wanted, force = _load(carried), float(np.linalg.norm(carried.force))
    if force == 0.0:
        # nothing touches
        return placed
    search = _Search(stepped, rows, wanted / arm, force, arm)
    at = search.at(placed)
    # bodies of several motions move as one, and means over points are not values at them: to the same load
    for _ in range(ROUNDS):
        following = search.further(at)
        if following is not None and following.missed < 0.5 * at.missed:
            at = following
        elif at.missed <= FOUND:
            # rounding ends it
            return at.pose
        else:
            following = search.along(at)
            if following is None:
                break
            at = following
    raise ConvergenceError("the pose was not found from balance: give all of its components", None)


@dataclass(frozen=True)
class _Placed:
    """A pose (6,), its step, and the load over arms (m,) [N] that it misses, the largest over the force."""

    pose: Array
    step: Any
    miss: Array
    missed: float


@dataclass(frozen=True)
class _Search:
    """Newton's method for the pose that carries a load, by some of its components.

    Rotations count by what they move at an `arm`. The load rises with the pose, as the contact gets stiffer
    the deeper it is pressed: along a direction in which the load missed does work, it is nearest where this
    work turns, however many points open and close on the way.
    """

    stepped: Callable[[Array], Any]
    rows: list[int]
    wanted: Array
    force: float
    arm: Array

    def at(self, pose: Array) -> _Placed:
        step = self.stepped(pose)
        miss = (self.wanted - _load(step) / self.arm)[self.rows]
        return _Placed(pose, step, miss, float(np.abs(miss).max()) / self.force)

    def moved(self, at: _Placed, change: Array) -> _Placed | None:
        """After a change (m,) [m]; None beyond what a step takes, as where rotations are large."""
        pose = at.pose.copy()
        pose[self.rows] += change / self.arm[self.rows]
        try:
            return self.at(pose)
        except (ValueError, ConvergenceError, ResultantError):
            return None

    def slope(self, at: _Placed) -> Array:
        arm = self.arm
        return (_loads(at.step, _by_pose(at.step)) / np.outer(arm, arm))[np.ix_(self.rows, self.rows)]

    def further(self, at: _Placed) -> _Placed | None:
        """By a whole step of Newton's method; None if there is none."""
        try:
            return self.moved(at, np.asarray(np.linalg.solve(self.slope(at), at.miss), dtype=np.float64))
        except np.linalg.LinAlgError:
            return None

    def along(self, at: _Placed) -> _Placed | None:
        """To where the load missed does half of its work or less on the way; None if that is nowhere."""
        slope = self.slope(at)
        # where little touches it is as soft as a spring as long as the contact
        least = self.force / self.arm[3]
        stiffness = float(np.linalg.eigvalsh(0.5 * (slope + slope.T))[0])
        change = np.linalg.solve(slope + max(least - stiffness, 0.0) * np.eye(len(slope)), at.miss)
        change *= min(1.0, FAR * self.arm[3] / float(np.abs(change).max()))
        work, low, high, share = float(at.miss @ change), 0.0, np.inf, 1.0
        for _ in range(ROUNDS):
            there = self.moved(at, share * change)
            if there is not None and abs(float(there.miss @ change)) <= 0.5 * work:
                return there
            if there is None or float(there.miss @ change) < 0.0:
                high = share
            else:
                low = share
            share = 2.0 * low if np.isinf(high) else 0.5 * (low + high)
        return None


def _load(step: Any) -> Array:
    """Force and moment (6,) on the lower body, with those of a magnet that follows the gap."""
    load = np.concatenate([step.force, step.moment])
    if step.magnetic_pressure is None:
        return load
    return np.asarray(load + _pulling(step) @ step.magnetic_pressure)


def _pulling(step: Any) -> Array:
    """Weights (6, n) of a pull in force and moment on the lower body: a pressure does the opposite."""
    return np.asarray(-step._source().shared.resultants[:, 2])


def _by_pose(step: Any) -> Mapping[str, Array]:
    """Changes (6, ...) of all fields of a step by the components of its pose."""
    found: Mapping[str, Array] = step._source().tangent.forward({"pose": np.eye(6)})
    return found


def _loads(step: Any, changes: Mapping[str, Array]) -> Array:
    """Force and moment (6, k) on the lower body by changes of the fields, those of a magnet included."""
    load = np.tensordot(step._source().shared.resultants, changes["unknowns"], ((1, 2), (1, 2)))
    if step.magnetic_pressure is not None:
        load += _pulling(step) @ changes["magnetic_pressure"].T
    return np.asarray(load)


@dataclass(frozen=True)
class Faces:
    """How the faces of massless bodies move along each other: of the lower one less the upper one.

    Attributes
    ----------
    placed : (6, 2, n) [-], [m]
        Along both tangents by the pose.
    motions : (m, 2, n)
        By the free motions.
    slid_by : callable
        (k, 2 n) [m] by tractions and pressures (k, 3 n) [Pa], and the pull (k, n) [Pa] of a magnet.
    """

    placed: Array
    motions: Array
    slid_by: Callable[[Array, Array | None], Array]

    def slip(self, step: Any, changes: Mapping[str, Array]) -> Array:
        """Slip (6, 2, n) of the upper body over the lower one by the pose, with what that changes."""
        return np.asarray(-(self.placed + self.moved(step, changes)))

    def moved(self, step: Any, changes: Mapping[str, Array]) -> Array:
        """How the faces move (k, 2, n), without the pose, by changes of all fields."""
        count = len(changes["unknowns"])
        unknowns = np.ascontiguousarray(changes["unknowns"].reshape(count, -1))
        pull = np.ascontiguousarray(p) if (p := changes.get("magnetic_pressure")) is not None else None
        free = self.motions[step._source().linear.balanced()]
        slid = self.slid_by(unknowns, pull).reshape(count, 2, -1)
        return np.asarray(slid + np.tensordot(changes["motion"], free, 1))


@dataclass(frozen=True)
class Answered:
    """How a sliding contact answers small motions of k coordinates.

    Attributes
    ----------
    by_pose : (k, k)
        Load on the lower body over the coordinates by these.
    slip : (k, N) [-], [m]
        Of the faces by the rates.
    answer : callable
        Loads, and how far the faces are moved back, by slips.
    by_rate : (k, k) or float
        Load by the rates besides that of the slip.
    """

    by_pose: Array
    slip: Array
    answer: Answer
    by_rate: Array | float = 0.0


@dataclass(frozen=True)
class Elastic:
    """Bodies that vibrate on the contact.

    Attributes
    ----------
    coordinates : Coordinates
    compliance : (3 n, 3 n) [m/Pa]
        Of what has no inertia.
    direction : (2, n) [-]
        Of sliding along both tangents.
    speed : (n,) [m/s]
    """

    coordinates: Coordinates
    compliance: Array
    direction: Array
    speed: Array

    def at(self, pressure: Array, friction: Array, slope: Array, area: Array) -> Answered:
        """What a state of sliding answers; `slope` (n,) [s/m] is the change of the friction with the speed.

        The points in contact stay, and so does the direction in which they slide, but for their velocity.
        """
        shapes, n = self.coordinates.shapes, pressure.size
        closed = np.flatnonzero(pressure > 0.0)
        normal, along = 2 * n + closed, np.concatenate([closed, n + closed])
        direction = self.direction[:, closed]
        rubbing = (friction[closed] * direction).ravel()

        def rubbed(pressed: Array) -> Array:
            """Friction (2 c, b) of pressures (c, b)."""
            return np.asarray(rubbing[:, None] * np.vstack([pressed, pressed]))

        c_np, c_nq = self.compliance[np.ix_(normal, normal)], self.compliance[np.ix_(normal, along)]
        c_qp, c_qq = self.compliance[np.ix_(along, normal)], self.compliance[np.ix_(along, along)]
        count = closed.size
        of_pressure = np.linalg.inv(
            c_np + c_nq[:, :count] * rubbing[:count] + c_nq[:, count:] * rubbing[count:]
        )
        by_pose = np.asarray(-of_pressure @ shapes[normal], dtype=np.float64)
        # the faces also move along each other as pressure and friction change: else the load of what friction
        # does to the slip would not be that of its power, and any friction would feed some vibration
        slip = -(shapes[along] + c_qp @ by_pose + c_qq @ rubbed(by_pose))
        # slip turns, and so does friction; where its size changes with the speed, that as well
        turns = friction[closed] * pressure[closed] / self.speed[closed]
        falls = slope[closed] * pressure[closed]

        def load(pressed: Array, traction: Array) -> Array:
            total = shapes[normal].T @ (area[closed, None] * pressed)
            return np.asarray(-(total + shapes[along].T @ (np.tile(area[closed], 2)[:, None] * traction)))

        def answer(slips: Array) -> tuple[Array, Array]:
            moved = slips.reshape(-1, 2, count)
            forwards = (moved * direction).sum(axis=1)[:, None] * direction
            drag = (turns * (moved - forwards) + falls * forwards).reshape(len(slips), -1).T
            pressed = -of_pressure @ (c_nq @ drag)
            traction = drag + rubbed(pressed)
            return load(pressed, traction).T, (c_qp @ pressed + c_qq @ traction).T

        return Answered(load(by_pose, rubbed(by_pose)), slip.T, answer)


class _Contact:
    """A contact in a state of sliding, whose friction is scaled by a factor."""

    def __init__(
        self,
        contact: Sliding,
        searching: Sliding,
        velocity: tuple[float, float],
        pose: Array,
        rows: list[int],
        bodies: Elastic | Faces,
        moved_by: MovedBy,
    ) -> None:
        def stepped(at: Array, friction: Array | None) -> Any:
            return contact.step(at, velocity, friction=friction)

        self.pose = _balanced(lambda at: searching.step(at, velocity), pose, searching, moved_by)
        start = stepped(self.pose, None)
        carried = start.pressure * contact.area
        total = float(carried.sum())
        if total <= 0.0:
            if start.magnetic_pressure is None or isinstance(bodies, Elastic):
                raise ValueError("the bodies do not touch at this pose")
            # a magnet pulls all the same, and no friction counts
            carried = contact.area
            total = float(carried.sum())
        own = start._source().friction
        self.friction = float(carried @ own) / total
        #: Coefficients (n,) at a factor of 1; of a contact without friction, the factor itself.
        self._scaled = own if self.friction > 0.0 else np.ones(own.size)
        #: Steps are given coefficients of which this acts.
        self.share = start._source().share
        self._rows, self._stepped = rows, stepped
        self._bodies, self._contact = bodies, contact
        # what friction loses or gains with the velocity grows with its coefficient
        self._falling = start._source().slope - stepped(self.pose, own / self.share)._source().slope

    def at(self, factor: float) -> Answered:
        """What the contact answers, its friction scaled by a factor."""
        friction = factor * self._scaled
        step = self._stepped(self.pose, friction / self.share)
        falling = factor * self._falling
        bodies, rows = self._bodies, self._rows
        if isinstance(bodies, Elastic):
            # unknowns, not means over points
            slope = step._source().slope + falling
            return bodies.at(step.state.pressure, friction, slope, self._contact.area)
        by_pose, n = _by_pose(step), friction.size
        slip = bodies.slip(step, by_pose)[rows]
        by_slip = step._source().by_slip
        still = np.zeros((len(rows), 2, n))
        by_rate = _loads(step, by_slip(still, self._rates(step).T[rows], falling))

        def answer(slips: Array) -> tuple[Array, Array]:
            changes = by_slip(slips.reshape(-1, 2, n), np.zeros((len(slips), 2)), falling)
            return _loads(step, changes)[rows].T, bodies.moved(step, changes).reshape(len(slips), -1)

        loads = _loads(step, by_pose)[np.ix_(rows, rows)]
        return Answered(loads, slip.reshape(len(rows), -1), answer, by_rate[rows])

    def _rates(self, step: Any) -> Array:
        """Velocity (2, 6) of the centre of pressure by the rates of the pose: loads follow its speed."""
        carried = step.pressure * self._contact.area
        if not carried.any():
            carried = self._contact.area
        x, y, z = self._contact.points @ carried / carried.sum() - self._contact.reference_point
        return np.array([[1.0, 0.0, 0.0, 0.0, z, -y], [0.0, 1.0, 0.0, -z, 0.0, x]])


@dataclass(frozen=True)
class _Equations:
    """M x'' + (C + contact) x' + (S + contact) x = 0 over the free components."""

    root: Array
    damping: Array
    stiffness: Array

    def eigen(self, contact: Answered) -> tuple[Modes, Modes, Array]:
        """Eigenvalues (w,) and shapes (w, m) on a contact, w >= 2m, and its damper (m, m) of slow motions."""
        undelayed = contact.answer(contact.slip)[0].T + contact.by_rate
        values, shapes = self._undelayed(undelayed, contact.by_pose)
        fastest = float(np.abs(values).max(initial=0.0))
        if not undelayed.any() or fastest == 0.0:
            return values, shapes, undelayed
        drag = Drag.of(contact.slip, contact.answer, FASTER * fastest)
        values, shapes = self._followed(values, contact, drag)
        return *self._polished(values, shapes, contact, drag), undelayed

    def _followed(self, values: Modes, contact: Answered, drag: Drag) -> tuple[Modes, Modes]:
        """Eigenvalues and shapes with the memory of the drag: all that swing, and the next to those without.

        Held by friction, a motion swings that the damper alone would let creep.
        """
        inverse, damping, stiffness = self._of_unit_mass(contact.by_rate, contact.by_pose)
        m, r = len(inverse), len(drag.back)
        into, out = drag.into @ inverse.T, inverse @ drag.out
        # states: coordinates, rates, slips that the tractions follow; size * those are the rates of `kept`
        size = np.abs(values).max()
        states = np.block(
            [
                [np.zeros((m, m)), size * np.eye(m), np.zeros((m, r))],
                [-stiffness / size, -damping, -out],
                [np.zeros((r, m)), into, -np.eye(r)],
            ]
        )
        kept = np.eye(2 * m + r)
        kept[2 * m :, 2 * m :] = drag.back
        # about a rate that nothing has, as what is not moved back at all has none
        about = ASIDE * size
        inverted, vectors = np.linalg.eig(np.linalg.solve(states - about * kept, kept))
        finite = np.abs(inverted) * about > ROUNDING
        every, vectors = about + 1.0 / inverted[finite], vectors[:m, finite]
        # of a pair the one above first
        order = np.argsort(-every.imag, kind="stable")
        every, vectors = every[order], vectors[:, order]
        distance = np.abs(values[:, None] - every)
        chosen = np.zeros(every.size, dtype=bool)
        for _ in range(values.size):
            i, j = np.unravel_index(distance.argmin(), distance.shape)
            chosen[j] = True
            distance[i], distance[:, j] = np.inf, np.inf
        swings = (np.abs(every.imag) >= np.abs(every.real)) & (np.abs(every) <= FASTER * size)
        chosen |= swings
        chosen |= np.isin(every, np.conj(every[chosen]))
        return every[chosen], (inverse.T @ vectors[:, chosen]).T

    def _of_unit_mass(self, damping: Array | float, stiffness: Array) -> tuple[Array, Array, Array]:
        """What takes off the root of the mass, and damping and stiffness without it, the contact included."""
        inverse: Array = np.asarray(np.linalg.inv(self.root), dtype=np.float64)
        damped = inverse @ (self.damping + damping) @ inverse.T
        return inverse, damped, inverse @ (self.stiffness + stiffness) @ inverse.T

    def _undelayed(self, damping: Array, stiffness: Array) -> tuple[Modes, Modes]:
        """Eigenvalues (2m,) and shapes (2m, m), with the contact's matrices."""
        inverse, d, k = self._of_unit_mass(damping, stiffness)
        m = len(k)
        if not d.any():
            # exact in sign: real squares give pure swings
            squares, shapes = np.linalg.eig(k)
            values = np.sqrt(-squares.astype(np.complex128))
            return np.concatenate([values, -values]), (inverse.T @ np.hstack([shapes, shapes])).T
        state = np.block([[np.zeros((m, m)), np.eye(m)], [-k, -d]])
        values, vectors = np.linalg.eig(state)
        return values.astype(np.complex128), (inverse.T @ vectors[:m]).T

    def _polished(self, values: Modes, shapes: Modes, contact: Answered, drag: Drag) -> tuple[Modes, Modes]:
        """Eigenvalues and shapes, also of slow swings to all digits.

        By Newton's method for an eigenvalue and its shape at once [Ruhe1973], all of them side by side.
        """
        inverse, damping, stiffness = self._of_unit_mass(contact.by_rate, contact.by_pose)
        one = np.eye(len(stiffness))
        values, motions = values.copy(), shapes @ self.root
        motions /= np.linalg.norm(motions, axis=1)[:, None]
        size = np.abs(values)
        # others are known; what hardly moves has no memory
        left = np.flatnonzero((size < SLOW * size.max()) & (size > MEETS * size.max()) & (values.imag != 0.0))
        before = np.full(values.size, np.inf)
        for k in range(ROUNDS):
            if not left.size:
                break
            now, shape = values[left], motions[left, :, None]
            dampers, turned = (inverse @ d @ inverse.T for d in drag.at(now))
            at = now[:, None, None]
            size = np.abs(at)
            whole = (stiffness + at * (damping + dampers + at * one)) / size**2
            slope = (damping + dampers + at * (turned + 2.0 * one)) @ shape / size
            kept = np.conj(np.swapaxes(shape, 1, 2))
            bordered = np.block([[whole, slope], [kept, np.zeros((left.size, 1, 1))]])
            missed = np.concatenate([whole @ shape, np.zeros((left.size, 1, 1))], axis=1)
            # two motions of one eigenvalue have no border of their own
            change = -(np.linalg.pinv(bordered, rcond=ROUNDING) @ missed)[..., 0]
            values[left] += change[:, -1] * size[:, 0, 0]
            motions[left] += change[:, :-1]
            motions[left] /= np.linalg.norm(motions[left], axis=1)[:, None]
            by = np.abs(change[:, -1])
            # rounding ends it
            goes_on = (by > ROUNDING) & ((by < 0.5 * before[left]) | (k < LATE))
            before[left] = by
            left = left[goes_on]
        return values, motions @ inverse


def _grows(values: Modes) -> NDArray[np.bool_]:
    """Which eigenvalues grow, beyond the rounding of simple ones and of those that meet others or zero."""
    size = np.abs(values).max(initial=0.0)
    # what nothing damps swings to and fro alike, to the last digit
    is_damped = not np.array_equal(np.sort_complex(values), np.sort_complex(-values))
    simple = is_damped & (np.abs(values) > MEETS * size)
    return np.asarray(values.real > np.where(simple, SIMPLE, LEAST) * size)


def _swings(value: complex) -> float:
    """Frequency [Hz] of what begins to grow.

    Where two frequencies meet, the mean of their squares is known far better than each of them.
    """
    return float(np.sqrt(max((-(value**2)).real, 0.0)) / (2.0 * np.pi))


def stability_of(
    contact: Sliding,
    searching: Sliding,
    velocity: tuple[float, float],
    pose: Array,
    free: Sequence[str],
    mass: ArrayLike,
    stiffness: ArrayLike,
    damping: ArrayLike,
    largest_friction: float,
    bodies: Elastic | Faces,
    moved_by: MovedBy,
) -> Stability:
    """See :meth:`mtb_rs.PreparedContact.stability`; `pose` (6,): NaN where it is found from balance.

    `searching` is the contact that is tried in other poses on the way there, and asks nothing.
    """
    names = [] if isinstance(bodies, Elastic) else free_of(free)
    if not any(velocity):
        raise ValueError("velocity is 0: the stability is that of a body that slides")
    rows = [POSE.index(name) for name in names]
    sliding = _Contact(contact, searching, velocity, pose, rows, bodies, moved_by)
    friction = sliding.friction
    if isinstance(bodies, Faces):
        inertia = matrix_of("mass", mass, names, least=True)
        held, slowed = matrix_of("stiffness", stiffness, names), matrix_of("damping", damping, names)
    else:
        names = list(bodies.coordinates.names)
        inertia, held, slowed = (getattr(bodies.coordinates, a) for a in ("mass", "stiffness", "damping"))
    m = len(names)
    own = _Equations(np.asarray(np.linalg.cholesky(inertia), dtype=np.float64), slowed, held)
    answered = sliding.at(1.0 if friction > 0.0 else 0.0)
    values, shapes, by_velocity = own.eigen(answered)
    most = LARGEST_FRICTION * sliding.share
    largest = max(min(positive("largest_friction", largest_friction), most), friction)
    unit = friction if friction > 0.0 else 1.0
    frictions = np.linspace(0.0, largest, STEPS + 1)
    everything: list[Modes] = []

    def at(coefficient: float) -> Modes | None:
        try:
            return own.eigen(sliding.at(coefficient / unit))[0]
        except (ConvergenceError, ResultantError):
            # it wedges: nothing slides
            return None

    first: tuple[float, float] | None = None
    for k, coefficient in enumerate(frictions):
        found = at(coefficient)
        everything.append(np.zeros(0, dtype=np.complex128) if found is None else found)
        if first is None and (found is None or _grows(found).any()):
            first = (frictions[max(k - 1, 0)], coefficient)
    critical = swing = None
    if first is not None:
        low, high = first
        while low < (middle := 0.5 * (low + high)) < high:
            found = at(middle)
            low, high = (low, middle) if found is None or _grows(found).any() else (middle, high)
        critical, found = float(high), at(high)
        swing = 0.0 if found is None else _swings(complex(found[found.real.argmax()]))
    curves = np.full((STEPS + 1, max(2 * m, *map(len, everything))), np.nan, dtype=np.complex128)
    for row, found in zip(curves, everything, strict=True):
        row[: found.size] = found[np.lexsort((found.real, found.imag))]
    shown = np.flatnonzero(values.imag >= 0.0)
    shown = shown[np.lexsort((-values.real[shown], values.imag[shown]))]
    shapes = shapes / np.take_along_axis(shapes, np.abs(shapes).argmax(axis=1)[:, None], axis=1)
    growing = values[_grows(values)]
    corners = np.vstack([contact.points.T, contact.reference_point])
    kind: Kind = "stable"
    if growing.size:
        worst = growing[growing.real.argmax()]
        kind = "flutter" if abs(worst.imag) > LEAST * abs(worst) else "divergence"
    return Stability(
        free=tuple(names),
        frequency=values.imag[shown] / (2.0 * np.pi),
        growth=values.real[shown] + 0.0,
        shapes=np.array([shapes[shown].real, shapes[shown].imag]),
        kind=kind,
        friction=friction,
        critical_friction=critical,
        critical_frequency=swing,
        mass=inertia,
        damping=own.damping + by_velocity,
        stiffness=own.stiffness + answered.by_pose,
        frictions=frictions,
        # no minus before a zero
        frequencies=curves.imag / (2.0 * np.pi) + 0.0,
        growths=curves.real,
        pose=sliding.pose,
        velocity=np.array(velocity),
        reference_point=contact.reference_point,
        outline=np.array([corners.min(axis=0), corners.max(axis=0)]),
    )
