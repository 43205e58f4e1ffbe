# SPDX-License-Identifier: MIT OR Apache-2.0
"""Wheels on rails in a simulation: pose and velocity of the wheelset in, forces and tractions out."""

from __future__ import annotations

import threading
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _mtb_rs
from .bodies import HalfSpace
from .check import choice, number, numbers, positive
from .errors import ConvergenceError
from .friction import Coulomb, Friction, InterfaceLayer, native_law
from .geometry import spacing_pair
from .stepping import pose_of
from .wheel_balance import NoRootError, differences, find_root
from .wheel_contact import FoundPatch, WheelOverRail
from .wheel_result import WheelPatch, WheelReport, WheelState, WheelStep

if TYPE_CHECKING:
    from .layout import WheelLayout
    from .scene import Scene

Array = NDArray[np.float64]

SIDES = ("left", "right", "both")
#: Relative residuals of the normal and the tangential problem of a step.
NORMAL_TOLERANCE, TANGENTIAL_TOLERANCE = 1e-9, 1e-6
#: Relative error of a vertical force that the height is found for.
FORCE_TOLERANCE = 1e-7
#: Error of the undeformed overlap that the search for height and roll begins with, and the change of height
#: for differences, both over the approach; and the longest step of that search [m].
LAID, DIFFERENCE, LONGEST = 1e-2, 1e-4, 5e-4
#: Operators are made for multiples of so many cells, so that few serve all patches ...
CELLS = 8
#: ... and so many of them are kept.
KEPT = 12
#: Largest displacement [m]; beyond it cells drown in rounding.
FARTHEST = 1e6
#: Roll and yaw [rad] beyond which a wheelset is not on its rails.
MOST_TURNED = 0.5
#: Below this share of the speed of the wheel's rim rolling has no direction.
NO_ROLLING = 1e-9


@dataclass
class _Trial:
    """Patches and pressures of one wheel at one height."""

    force: float
    patches: list[tuple[FoundPatch, Array]] = field(default_factory=list)


class PreparedWheels:
    """One or both wheels of a wheelset on the rails, ready for a simulation.

    Made by :meth:`mtb_rs.Scene.prepare` from a wheel on a rail; the scene's wheelset stands shifted by its
    `lateral` to the left. The track frame: x along the rails, the
    direction of travel, y to the left, z up; its origin lies on the top of the rails in the middle of the
    track. Patches of one wheel are solved apart from each other if their planes differ.

    Rolling is taken as steady: right where a patch rolls over its own length in less time than forces take
    to change.
    """

    def __init__(
        self,
        scene: Scene,
        layout: WheelLayout,
        side: str,
        friction: Friction,
        layer: InterfaceLayer | None,
        reference_point: ArrayLike | None,
        standstill_speed: float | None,
    ) -> None:
        choice("side", side, SIDES)
        arguments = dict(layout.arguments)
        self._wheel = WheelOverRail.of(layout.placement, arguments)
        self.sides: tuple[str, ...] = ("left", "right") if side == "both" else (side,)
        self._radius = float(arguments["wheel_radius"])
        axle = np.array([0.0, float(arguments["lateral"]), self._radius + self._wheel.first_height])
        if reference_point is None:
            self._centre = axle
        else:
            self._centre = np.asarray(reference_point, dtype=float)
            if self._centre.shape != (3,) or not np.isfinite(self._centre).all():
                raise ValueError(
                    f"reference_point is {reference_point!r}: three finite numbers [m] are needed"
                )
        self._axle = axle - self._centre
        if scene.force is None:
            raise ValueError("nothing presses the wheel: a scene with a force [N] is needed")
        # the scene's acts along the normal of its own contact plane
        self._force = scene.force * float(np.cos(layout.placement.contact_angle))
        self._spacing = layout.placement.spacing if scene.spacing is None else spacing_pair(scene.spacing)
        bodies = (scene.lower, scene.upper)
        materials = [body.material if isinstance(body, HalfSpace) else None for body in bodies]
        self._constants = [None if m is None else (m.shear_modulus, m.poisson_ratio) for m in materials]
        if isinstance(friction, Coulomb) and np.ndim(friction.coefficient):
            raise ValueError("friction varies over the patch: patches move, one coefficient is needed")
        if layer is not None and not isinstance(layer, InterfaceLayer):
            raise ValueError(f"layer is {layer!r}: an InterfaceLayer is needed")
        native_law(friction, (1, 1), (slice(0, 1), slice(0, 1)))
        self._friction = friction
        self._layer = 0.0 if layer is None else layer.flexibility
        self._standstill = (
            0.0 if standstill_speed is None else positive("standstill_speed", standstill_speed, "m/s")
        )
        self._operators: dict[tuple[int, int], _mtb_rs.PatchOperators] = {}
        self._state: WheelState | None = None
        # vertical approach of the force alone, where no step has been taken yet
        self._depth = layout.placement.approach / float(np.cos(layout.placement.contact_angle))
        self._lock = threading.RLock()

    def __repr__(self) -> str:
        return f"<PreparedWheels: {' and '.join(self.sides)}, {self._force:g} N each>"

    @property
    def reference_point(self) -> Array:
        """The point of the wheelset that poses, velocities and moments are about, at the zero pose [m]."""
        return self._centre.copy()

    def step(
        self,
        pose: Sequence[float] | Array | None = None,
        velocity: float | Sequence[float] | Array | None = None,
        dt: float | None = None,
        state: WheelState | None = None,
    ) -> WheelStep:
        """Solves the contacts at one instant.

        Parameters
        ----------
        pose : (x, y, z, roll, pitch, yaw) [m], [rad]
            Rigid displacement of the wheelset from where the scene has it, just touching the rail: rotations
            about fixed x, then y, then z axis through `reference_point`, then the translation. z NaN: found
            so that the pressures carry the scene's vertical force (on both wheels twice that); z and roll
            NaN, both wheels: so that each carries it. None: z NaN, all else zero.
        velocity : (vx, vy, vz, wx, wy, wz) [m/s], [rad/s]
            Of the wheelset at `reference_point`, in the track, with its rotation about the axle (wy > 0
            rolls forwards; a yawed or rolled axle has parts of it along x and z). A number v: v along x,
            v / wheel_radius about the axle as posed.
        dt : float [s]
            Length of the step, for `friction_work`.
        state : WheelState
            Starts from this one in place of the memory.

        Raises
        ------
        ValueError
            If something cannot be as given; if a contact reaches the end of a profile.
        ConvergenceError
            If a problem was not solved.
        """
        place = np.zeros(6) if pose is None else pose_of(pose)
        if pose is None:
            place[2] = np.nan
        is_free = np.isnan(place)
        if is_free[[0, 1, 4, 5]].any() or (is_free[3] and not (is_free[2] and len(self.sides) == 2)):
            raise ValueError(
                f"pose is {place.tolist()}: z alone, or z and roll of both wheels, can be found from balance"
            )
        for name, value in zip("xyz", place, strict=False):
            if abs(value) > FARTHEST:
                raise ValueError(f"pose, {name}, is {value:g} m: at most {FARTHEST:g} m is needed")
        for name, value in (("roll", place[3]), ("yaw", place[5])):
            if abs(value) > MOST_TURNED:
                raise ValueError(
                    f"{name} is {value:g} rad: at most {MOST_TURNED} rad is needed, or the wheelset does "
                    "not roll along the rails"
                )
        motion = self._velocity(velocity)
        if state is not None:
            self._check_state(state)
        if dt is not None:
            positive("dt", dt, "s")
        with self._lock:
            return self._step(place, motion, dt, self._state if state is None else state)

    def _step(self, place: Array, motion: Array, dt: float | None, state: WheelState | None) -> WheelStep:
        self._solves = self._iterations = 0
        self._depths: tuple[float, ...] = () if state is None else state.depth
        if np.isnan(place[2]):
            trials = self._in_balance(place, state)
        else:
            trials = [self._trial(side, place) for side in self.sides]
        centre = self._centre + place[:3]
        if motion.size == 1:
            motion = np.array([motion[0], 0.0, 0.0, *(motion[0] / self._radius * rotation(*place[3:])[:, 1])])
        patches, ratios = [], []
        for side, trial in zip(self.sides, trials, strict=True):
            known = [] if state is None else [r for r in state.ratio if r[0] == side]
            for k, (found, pressure) in enumerate(trial.patches):
                start = moved(known[k][2], known[k][1], found) if k < len(known) else None
                patch, ratio = self._rolling(side, found, pressure, centre, motion, start)
                patches.append(patch)
                ratios.append((side, found.first, ratio))
        force, moment = np.zeros(3), np.zeros(3)
        for patch in patches:
            load = patch.load()
            force += load.sum(axis=(1, 2))
            arm = patch.points - centre[:, None, None]
            moment += np.cross(arm, load, axis=0).sum(axis=(1, 2))
        power = sum(patch.friction_power for patch in patches)
        self._state = WheelState(self._depths, tuple(ratios))
        return WheelStep(
            force=force,
            moment=moment,
            reference_point=centre,
            pose=place,
            patches=tuple(patches),
            friction_power=power,
            friction_work=None if dt is None else power * dt,
            state=self._state,
            report=WheelReport(self._solves, self._iterations),
        )

    def copy(self) -> PreparedWheels:
        """The same wheels without memory."""
        other = object.__new__(PreparedWheels)
        other.__dict__.update(self.__dict__)
        other._operators, other._state, other._lock = {}, None, threading.RLock()
        return other

    def __getstate__(self) -> dict[str, Any]:
        return {k: v for k, v in self.__dict__.items() if k not in ("_operators", "_lock")}

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__dict__.update(state, _operators={}, _lock=threading.RLock())

    def _velocity(self, velocity: Any) -> Array:
        if velocity is None:
            raise ValueError("velocity is missing: a number [m/s] or (vx, vy, vz, wx, wy, wz) is needed")
        if np.ndim(velocity) == 0:
            return np.array([number("velocity", velocity, "m/s")])
        if np.shape(velocity) != (6,):
            raise ValueError(f"velocity is {velocity!r}: a number or (vx, vy, vz, wx, wy, wz) is needed")
        return np.array(numbers("velocity", velocity, 6))

    def _check_state(self, state: Any) -> None:
        if not isinstance(state, WheelState):
            raise ValueError(f"state is {state!r}: a WheelState, the `state` of a step, is needed")
        if not all(np.isfinite(depth) and depth > 0.0 for depth in state.depth):
            raise ValueError(f"state.depth is {state.depth!r}: overlaps > 0 [m] are needed")
        for k, entry in enumerate(state.ratio):
            side, first, ratio = entry if isinstance(entry, tuple) and len(entry) == 3 else (None, (), None)
            if (
                side not in ("left", "right")
                or len(first) != 2
                or not isinstance(ratio, np.ndarray)
                or ratio.dtype != np.float64
                or ratio.ndim != 3
                or ratio.shape[0] != 2
                or not np.isfinite(ratio).all()
            ):
                raise ValueError(
                    f"state.ratio[{k}] is not (side, first (x, y) cell, finite array (2, ny, nx) of float64)"
                )

    def _mirrored(self, side: str, place: Array) -> tuple[Array, Array]:
        """Centre of the axle [m] and its unit direction, for the right wheel seen in a mirror."""
        turn = rotation(*place[3:])
        centre = self._centre + place[:3] + turn @ self._axle
        direction = turn[:, 1].copy()
        if side == "right":
            centre[1] = -centre[1]
            direction[[0, 2]] = -direction[[0, 2]]
        return centre, direction

    def _trial(self, side: str, place: Array) -> _Trial:
        """Patches of a wheel and their pressures; the force is the vertical one [N]."""
        trial = _Trial(0.0)
        elastic = [constants for constants in self._constants if constants is not None]
        for found in self._wheel.patches(*self._mirrored(side, place), self._spacing):
            base = float(found.gap.min())
            if base >= 0.0:
                continue
            solution = _mtb_rs.solve_normal(
                found.gap - base,
                self._spacing,
                elastic,
                None,
                -base,
                (None, None),
                NORMAL_TOLERANCE,
                False,
                "auto",
            )
            self._solves += 1
            if solution["status"] not in ("solved", "stagnated") or solution["residual"] > 1e-6:
                raise ConvergenceError(
                    f"the normal contact of the {side} wheel: {solution['status']}, residual "
                    f"{solution['residual']:.1e}"
                )
            pressure = np.maximum(solution["pressure"], 0.0)
            normal = pressure.sum() * self._spacing[0] * self._spacing[1]
            trial.force += float(normal * np.cos(found.contact_angle))
            trial.patches.append((found, pressure))
        return trial

    def _in_balance(self, place: Array, state: WheelState | None) -> list[_Trial]:
        """Lowers (and rolls) the wheelset until its wheels carry the force; `place` gets what was found.

        Unknowns are the height [m] and, if free, roll times `tape` [m]. Force goes nearly with
        overlap^(3/2), so force^(2/3) is nearly linear; its first derivatives are those of the undeformed
        overlap, which cost no solve and know that a roll moves a flange sideways.
        """
        is_each = bool(np.isnan(place[3]))
        n = 2 if is_each else 1
        wanted = self._force * (1.0 if is_each else len(self.sides))
        depth = np.full(n, self._depth)
        if state is not None and len(state.depth) == n:
            depth = np.array(state.depth)
        trials: list[_Trial] = []

        def posed(x: Array) -> Array:
            place[2] = x[0]
            if is_each:
                place[3] = x[1] / self._wheel.tape
            return place

        def overlap(x: Array) -> Array:
            found = np.array([self._wheel.depth(*self._mirrored(side, posed(x))) for side in self.sides])
            return found if is_each else found.max(keepdims=True)

        def carried(x: Array) -> Array:
            """force^(2/3) over that wanted, less 1; a lifted wheel counts by how far it is up."""
            trials[:] = [self._trial(side, posed(x)) for side in self.sides]
            forces = np.array([trial.force for trial in trials])
            root = ((forces if is_each else forces.sum(keepdims=True)) / wanted) ** (2.0 / 3.0)
            if not root.all():
                root = np.where(root > 0.0, root, np.minimum(overlap(x) / self._depth, 0.0))
            return np.asarray(root - 1.0)

        small = DIFFERENCE * self._depth
        level = np.zeros(n)
        level[0] = (overlap(level) - depth).max()
        try:
            slope = differences(overlap, level, overlap(level), small)
            x = find_root(lambda x: overlap(x) - depth, level, slope, LAID * self._depth, LONGEST, small)
        except (NoRootError, ValueError):
            # a flange that climbs: from the wheel that touches first
            x = level
        slope = differences(overlap, x, overlap(x), small) / depth[:, None]
        try:
            x = find_root(carried, x, slope, FORCE_TOLERANCE / 1.5, LONGEST, small)
        except NoRootError:
            reached = ", ".join(f"{trial.force:g} N" for trial in trials)
            raise ConvergenceError(
                f"no height{' and roll' * is_each} of the wheelset found at which "
                f"{'each wheel carries' if is_each else 'its wheels carry'} {wanted:g} N: the last carries "
                f"{reached}"
            ) from None
        self._depths = tuple(overlap(x).tolist())
        return trials

    def _rolling(
        self, side: str, found: FoundPatch, pressure: Array, centre: Array, motion: Array, start: Array | None
    ) -> tuple[WheelPatch, Array]:
        """The patch with its traction, and traction over pressure for the next step, as of a left wheel."""
        mirror = np.array([1.0, -1.0, 1.0]) if side == "right" else np.ones(3)
        turn = found.rotation
        spin_vector = -mirror * motion[3:] if side == "right" else motion[3:]
        rigid = mirror * motion[:3] + np.cross(spin_vector, found.position - mirror * centre)
        along, across = turn[:, 0] @ rigid, turn[:, 1] @ rigid
        spin = float(turn[:, 2] @ spin_vector)
        rolling = float(motion[0] - 0.5 * along)
        speed = max(abs(rolling), self._standstill)
        if speed <= NO_ROLLING * float(np.abs(rigid).max(initial=abs(motion[0]))) or speed == 0.0:
            raise ValueError(
                f"the {side} wheel does not roll (velocity {motion.tolist()}): at rest friction has no "
                "direction; prepare with a standstill_speed [m/s]"
            )
        creepage = np.array([along, across, spin]) / speed
        dx, dy = self._spacing
        cells = pressure.shape
        fields = np.zeros((5, *cells))
        loaded = pressure > 0.0
        rows, columns = np.flatnonzero(loaded.any(axis=1)), np.flatnonzero(loaded.any(axis=0))
        cut = (slice(int(rows[0]), int(rows[-1]) + 1), slice(int(columns[0]), int(columns[-1]) + 1))
        # rolling backwards is rolling forwards seen from the other side
        sense = -1 if rolling < 0.0 else 1
        view = (..., *cut)
        rows_of, columns_of = cells_of(cut)
        shape = (-(-rows_of // CELLS) * CELLS, -(-columns_of // CELLS) * CELLS)
        padding = [(0, shape[0] - rows_of), (0, shape[1] - columns_of)]

        def turned(part: Array) -> Array:
            return np.ascontiguousarray(part[..., ::sense, ::sense])

        def padded(part: Array) -> Array:
            return np.pad(turned(part), [(0, 0)] * (part.ndim - 2) + padding)

        first = (found.first[0] + cut[1].start, found.first[1] + cut[0].start)
        last = (first[0] + columns_of - 1, first[1] + rows_of - 1)
        origin = first if sense > 0 else (-last[0], -last[1])
        warm = None if start is None else padded(sense * start[view] * pressure[cut])
        law = native_law(self._friction, shape, (slice(None), slice(None)))
        out = self._operators_of(shape).solve(
            padded(pressure[cut]),
            (origin[0] * dx, origin[1] * dy),
            [(sense * float(creepage[0]), False), (sense * float(creepage[1]), False)],
            float(creepage[2]),
            speed,
            law,
            None,
            TANGENTIAL_TOLERANCE,
            warm,
        )
        if not out["converged"]:
            raise ConvergenceError(
                f"stick and slip under the {side} wheel: residual {out['history'][-1]:.1e}"
            )
        self._iterations += out["iterations"] + out["coarse_iterations"]
        size = (slice(None), slice(0, rows_of), slice(0, columns_of))
        fields[(slice(0, 2), *cut)] = sense * turned(out["traction"][size])
        fields[(slice(2, 4), *cut)] = sense * speed * turned(out["slip"][size])
        fields[(4, *cut)] = turned(out["status"][size[1:]])
        fields[2:4, fields[4] != 2] = 0.0
        ratio = np.divide(fields[:2], pressure, out=np.zeros((2, *cells)), where=loaded)
        x: Array = dx * (found.first[0] + np.arange(float(cells[1])))
        y: Array = dy * (found.first[1] + np.arange(float(cells[0])))
        position, rotation = found.position, turn
        if side == "right":
            # out of the mirror; y stays to the left
            position = mirror * position
            rotation = mirror[:, None] * turn * mirror
            creepage = creepage * [1.0, -1.0, -1.0]
            y = -y[::-1]
            pressure = np.ascontiguousarray(pressure[::-1])
            fields = fields[:, ::-1].copy()
            fields[[1, 3]] *= -1.0
        patch = WheelPatch(
            side=side,
            position=position,
            rotation=rotation,
            contact_angle=found.contact_angle,
            rail_position=found.rail_position,
            wheel_position=found.wheel_position,
            x=x,
            y=y,
            pressure=pressure,
            traction=fields[:2],
            slip_velocity=fields[2:4],
            status=fields[4].astype(np.int8),
            creepage=creepage,
            rolling_speed=sense * speed,
            normal_force=float(pressure.sum() * dx * dy),
            neglected=found.neglected,
        )
        return patch, ratio

    def _operators_of(self, shape: tuple[int, int]) -> _mtb_rs.PatchOperators:
        """Operators of a grid (ny, nx); the ones used longest ago are dropped."""
        key = (shape[1], shape[0])
        made = self._operators.pop(key, None)
        if made is None:
            made = _mtb_rs.PatchOperators(
                key,
                self._spacing,
                self._constants[0],
                self._constants[1],
                self._layer,
                "steady",
                (self._spacing[0], 0.0),
                None,
            )
            while len(self._operators) >= KEPT:
                del self._operators[next(iter(self._operators))]
        self._operators[key] = made
        return made


def cells_of(cut: tuple[slice, slice]) -> tuple[int, int]:
    """Rows and columns of a part of a grid."""
    return cut[0].stop - cut[0].start, cut[1].stop - cut[1].start


def moved(ratio: Array, first: tuple[int, int], found: FoundPatch) -> Array:
    """A field (2, ny, nx) that begins at the grid lines `first`, on the grid of `found`; zero beyond."""
    out = np.zeros((2, *found.gap.shape))
    here, there = [], []
    for axis, n in ((1, 0), (0, 1)):
        offset = first[axis] - found.first[axis]
        begin = max(0, offset)
        end = min(found.gap.shape[n], offset + ratio.shape[n + 1])
        if end <= begin:
            return out
        here.append(slice(begin, end))
        there.append(slice(begin - offset, end - offset))
    out[:, here[0], here[1]] = ratio[:, there[0], there[1]]
    return out


def rotation(roll: float, pitch: float, yaw: float) -> Array:
    """Rotation by roll about x, then pitch about y, then yaw about z, all fixed axes."""
    (sr, sp, sy), (cr, cp, cy) = np.sin([roll, pitch, yaw]), np.cos([roll, pitch, yaw])
    return np.array(
        [
            [cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
            [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
            [-sp, cp * sr, cp * cr],
        ]
    )
