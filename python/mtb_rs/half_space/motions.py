# SPDX-License-Identifier: MIT OR Apache-2.0
"""What moves over what, and how: shifts, transient and steady rolling."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..base.check import flag, number, numbers, one_or_two, pair, positive, reals
from ..base.owning import owning
from ..base.plain import plain
from ..base.renamed import renamed
from ..base.stored import stored
from .pressure_field import PressureField, pressure_field
from .tangential_tangent import Moving

Array = NDArray[np.float64]
Pair = tuple[float, float]
Forces = tuple[float | None, float | None]

#: Small changes of a step, over it, and of a direction [rad], by which operators are derived ...
_COURSE = 1e-3
#: ... and the most of the way to where a step ends on a border of a cell, or on the middle of one: there the
#: slope of the influence is that of a logarithm, or what is carried along has a kink. Nearer than so many
#: cells it ends on it.
_OF_WAY, _ON_IT = 1e-2, 1e-6

#: Rolling along the cells, to the digits in which an angle is told.
_ALONG = 1e-5
#: Longest transient step of second order, over a cell.
_LONGEST_STEP = 1.0 + 1e-9

#: Shortest step, over a cell, by which the slip of steady rolling is measured.
_SHORTEST_STEP = 0.1


class Motion(ABC):
    """What the tangential problem asks of a motion of the upper body over the lower one."""

    #: The word for it, and for what is given along x and y and about z.
    word: ClassVar[str]
    rigid_word: ClassVar[str]
    #: Units of slip and of dissipation.
    slip_unit: ClassVar[str]
    dissipation_unit: ClassVar[str]
    force: Forces | None
    #: Order of the errors in the size of the cells.
    order: int = 1
    #: Rigid slip (2, ny, nx) that is given besides, in the unit of the slip.
    rigid_slip: Array | None = None

    @property
    @abstractmethod
    def rigid(self) -> tuple[float, float, float]:
        """What is given along x and y, and the rotation about z."""

    @property
    @abstractmethod
    def slip_speed(self) -> float:
        """Slip speed [m/s] of a unit of slip."""

    @property
    @abstractmethod
    def kind(self) -> str:
        """The kind of its operator: "steady" or "transient" rolling, or "shift"."""

    @abstractmethod
    def step_on(self, field: PressureField) -> Pair:
        """The step (x, y) [m] of its operator on the cells of `field`, checked."""

    @property
    def is_steady(self) -> bool:
        """Whether it has no state before."""
        return False

    @property
    def direction(self) -> float:
        """Direction in which the contact moves over the bodies, from +x towards +y [rad]."""
        return 0.0

    @property
    def passage(self) -> float | None:
        """Direction [rad] in which it passes over the bodies; None where it passes over nothing."""
        return None

    @property
    def steady_velocity(self) -> Pair:
        """Velocity (x, y) [m/s] at which the contact moves over bodies that creep.

        Raises
        ------
        ValueError
            For a motion that has a past.
        """
        if not self.is_steady:
            raise ValueError(
                f"the motion is {self!r}: what a body that creeps (Viscoelastic) has felt before is not "
                "known; steady rolling takes it, a Rolling without transient=True"
            )
        return self.slip_speed * math.cos(self.direction), self.slip_speed * math.sin(self.direction)

    @property
    def advice(self) -> str:
        """How a step that has no solution may have one, to be put behind the advice of a memory."""
        return ""

    def courses(self, field: PressureField) -> dict[str, tuple[float, Callable[[float], Pair]]]:
        """What its operators are made for on the cells of `field`: a small change of it, and the step (x, y)
        [m] after a change."""
        return {}

    def moving(self) -> Moving:
        """What moves, as derivatives name it."""
        raise ValueError(f"a {self.word} has no derivatives")

    def _found(self) -> tuple[bool, bool]:
        x, y = (is_force for _, is_force in self.drive())
        return x, y

    def slip_given(self, shape: tuple[int, int]) -> Array | None:
        """The rigid slip (2, ny, nx) that is given besides, on cells of `shape`."""
        given = self.rigid_slip
        if given is not None and given.shape[1:] != shape:
            raise ValueError(
                f"rigid_slip has shape {given.shape}: (2, {shape[0]}, {shape[1]}) is needed, x and y "
                "components on the cells of the contact"
            )
        return given

    @property
    def is_driven(self) -> bool:
        """Whether a force is given along x or y."""
        return self.force is not None and any(f is not None for f in self.force)

    def drive(self) -> list[tuple[float, bool]]:
        """What is given along x and y, and whether it is a force."""
        forces = self.force if self.force is not None else (None, None)
        return [
            (float(given), False) if force is None else (float(force), True)
            for given, force in zip(self.rigid[:2], forces, strict=True)
        ]


@stored
@renamed(speed="velocity")
@owning
@dataclass(frozen=True)
@plain
class Rolling(Motion):
    """Rolling contact: the upper body rolls over the lower one.

    The rigid slip of the upper body over the lower one, relative to the rolling velocity, is
    ``(xi - phi y, eta + phi x)``. `xi` > 0 pulls the lower body towards +x.

    Parameters
    ----------
    creepage : (xi, eta, phi)
        Creepage along x and along y [-], for any `angle`, and spin [1/m]. Creepages (l, t) along the rolling
        direction and to its left give ``xi = l cos(angle) - t sin(angle)`` and
        ``eta = l sin(angle) + t cos(angle)``.
    force : (Fx, Fy) or None [N]
        Total tangential force on the lower body. The creepage of a component with a given force is found;
        None is for a component whose creepage is given.
    angle : float [rad]
        Direction of rolling from +x towards +y; a line contact rolls along +x or -x only.
    velocity : float [m/s]
        Velocity of rolling, for friction that depends on the slip speed.
    transient : bool
        Whether to solve one step from a state instead of the steady state.
    step : float or None [m]
        Distance rolled in a transient step, and distance over which steady slip is measured; None for one
        cell. The rigid slip is taken a sixth of it ahead. Steady slip is sound from half a cell on. For
        shorter steps the influence of a cell's own traction on the difference vanishes, and a step below a
        tenth of a cell is refused.
    rigid_slip : (2, ny, nx) float or None [-]
        Rigid slip at each cell besides that of `creepage`, relative to the rolling velocity: of flexible
        bodies, or of a curved surface (:meth:`along_arc`).
    order : {1, 2}
        Order of the errors in the size of the cells. 1 is the scheme of CONTACT, with whose fields it agrees
        cell by cell. 2 has forces as good on cells three to eight times as large: the slip of a cell is
        continued to its middle from its leading face, half a cell ahead, and the one before, and the traction
        of the first cell of each row is to that of the next one as their pressures are. Rolling is then
        along the rows or the columns of cells, steady by one cell, or transient along the rows by up to one,
        under no layer that yields; between unlike bodies the error stays of first order.
    """

    creepage: tuple[float, float, float] = (0.0, 0.0, 0.0)
    force: Forces | None = None
    angle: float = 0.0
    velocity: float = 10.0
    transient: bool = False
    step: float | None = None
    rigid_slip: Array | None = None
    order: int = 1
    word: ClassVar[str] = "rolling"
    rigid_word: ClassVar[str] = "creepage"
    slip_unit: ClassVar[str] = "1"
    dissipation_unit: ClassVar[str] = "Pa"

    def __post_init__(self) -> None:
        object.__setattr__(self, "creepage", numbers("creepage", self.creepage, 3))
        _check_force(self.force)
        number("angle", self.angle, "rad")
        positive("velocity", self.velocity, "m/s")
        flag("transient", self.transient)
        if self.step is not None:
            positive("step", self.step, "m")
        _check_rigid_slip(self)
        object.__setattr__(self, "order", one_or_two("order", self.order))

    def slip_given(self, shape: tuple[int, int]) -> Array | None:
        """The rigid slip (2, ny, nx) given besides on cells of `shape`, at the places where it is taken."""
        given = super().slip_given(shape)
        if given is None or self.order == 1:
            return given
        # halfway to the next cell
        axis = 2 if abs(math.cos(self.angle)) > 0.5 else 1
        sense = 1 if math.cos(self.angle) + math.sin(self.angle) > 0.0 else -1
        last = [slice(None)] * 3
        last[axis] = slice(-1, None) if sense > 0 else slice(0, 1)
        shifted = np.roll(given, -sense, axis)
        shifted[tuple(last)] = given[tuple(last)]
        return np.asarray(0.5 * (given + shifted))

    def along_arc(self, normal: Any, roll: float = 0.0, inclination: ArrayLike | None = None) -> Rolling:
        """The same rolling on a surface that is curved across the rows of cells, whose slip it gives.

        The upper body turns by `creepage`'s spin about the normal at y = 0, and rolls about y: the rigid slip
        at the place (x, Y, Z) of a row inclined by a is ``(xi - phi Y + roll Z, eta cos a + phi_a x)`` with
        the row's own spin ``phi_a = phi cos a - roll sin a``. For a wheel of radius R whose axle is inclined
        by b to the surface at y = 0, roll is cos(b) / R and the spin of free rolling sin(b) / R, with the
        sign that makes phi_a vanish where the surface is parallel to the axle.

        Parameters
        ----------
        normal : NormalResult or PressureField
            The contact, whose cells are meant.
        roll : float [1/m]
            Rotation about y per distance rolled: the upper body rolls towards +x for a positive one.
        inclination : (ny,) float or None [rad]
            Angles of the rows; None for those of `normal`, of a prism those of its surface.

        Raises
        ------
        ValueError
            For a direction of rolling other than +x, and where there are no angles.
        """
        field = pressure_field(normal)
        rows, columns = field.pressure.shape
        number("roll", roll, "1/m")
        if self.angle != 0.0:
            raise ValueError(
                f"angle is {self.angle:g} rad: along an arc a body rolls towards +x, and 0 is needed"
            )
        own = field.angles() if inclination is None else inclination
        if own is None:
            raise ValueError(
                "inclination is None, and the contact has none: the angles [rad] of its rows are needed"
            )
        angles = reals("inclination", own, "rad")
        if angles.shape != (rows,):
            raise ValueError(
                f"inclination has shape {angles.shape}: one angle for each of the {rows} rows is needed"
            )
        x, y = field.coordinates()
        if self.order == 1:
            # the slip is taken a sixth of a step ahead, as that of the spin
            x = x + self.step_vector(field.spacing)[0] / 6.0
        _, eta, phi = self.creepage
        places = []
        for slope in (np.cos(angles), np.sin(angles)):
            along = np.concatenate([[0.0], np.cumsum(0.5 * (slope[1:] + slope[:-1]) * field.spacing[1])])
            places.append(along - np.interp(0.0, y, along))
        level, height = places
        along_x = -phi * (level - y) + roll * height
        across = eta * (np.cos(angles) - 1.0)
        own = phi * (np.cos(angles) - 1.0) - roll * np.sin(angles)
        slip = np.stack([np.repeat(along_x[:, None], columns, axis=1), across[:, None] + own[:, None] * x])
        return replace(self, rigid_slip=slip if self.rigid_slip is None else slip + self.rigid_slip)

    @property
    def rigid(self) -> tuple[float, float, float]:
        """Creepages and spin."""
        return self.creepage

    @property
    def slip_speed(self) -> float:
        """Slip speed [m/s] of a unit of slip: slip is relative to the velocity."""
        return self.velocity

    @property
    def direction(self) -> float:
        """Direction of rolling [rad]."""
        return self.angle

    @property
    def passage(self) -> float | None:
        """Direction of rolling [rad]."""
        return self.angle

    def moving(self) -> Moving:
        """Creepages and spin together, at a velocity."""
        return Moving({"creepage": (0, 1, 2)}, "velocity", 1.0 / self.velocity, self._found())

    @property
    def is_steady(self) -> bool:
        """Whether there is no state before."""
        return not self.transient

    @property
    def advice(self) -> str:
        """How a step that has no solution may have one."""
        return ", or roll over a longer step; a shorter one makes it worse" if self.transient else ""

    @property
    def kind(self) -> str:
        """The kind of its operator."""
        return "steady" if self.is_steady else "transient"

    def step_on(self, field: PressureField) -> Pair:
        """The step (x, y) [m] of its operator on the cells of `field`, checked."""
        along, across = self.step_vector(field.spacing)
        if field.reference is not None:
            # the second spacing is a length without meaning there, and rounding of pi no reason to refuse
            if abs(across) > 1e-9 * math.hypot(along, across):
                raise ValueError(
                    f"angle is {self.angle:g} rad: a line contact rolls along +x (0) or -x (pi) only"
                )
            across = 0.0
        if self.order == 2:
            along, across = self._step_of_second_order(field, along, across)
        if self.step is not None and self.is_steady:
            cell = math.hypot(*replace(self, step=None).step_vector(field.spacing))
            if self.step < _SHORTEST_STEP * cell:
                raise ValueError(
                    f"step is {self.step:g} m: steady rolling needs a step of at least "
                    f"{_SHORTEST_STEP * cell:g} m, {_SHORTEST_STEP:g} of a cell; without a step it is one "
                    "cell long"
                )
            longest = self._length_of(field)
            if self.step > max(longest, cell):
                raise ValueError(
                    f"step is {self.step:g} m: steady rolling measures slip over at most the length of the "
                    f"contact, {longest:.4g} m that way; without a step it is one cell long"
                )
        return along, across

    def _length_of(self, field: PressureField) -> float:
        """Length [m] of what is pressed along the way."""
        rows, columns = np.nonzero(np.asarray(field.pressure) > 0.0)
        if not rows.size:
            return math.inf
        dx, dy = field.spacing
        way = columns * dx * math.cos(self.angle) + rows * dy * math.sin(self.angle)
        return float(np.ptp(way)) + abs(dx * math.cos(self.angle)) + abs(dy * math.sin(self.angle))

    def _step_of_second_order(self, field: PressureField, along: float, across: float) -> Pair:
        """The step (x, y) [m], checked, and along the cells to rounding."""
        length = math.hypot(along, across)
        if min(abs(along), abs(across)) > _ALONG * length:
            raise ValueError(
                f"order is 2 and angle is {self.angle:g} rad: slip of second order is known in rolling along "
                "the cells, at 0, pi, or half of pi to either side; order=1 rolls in any direction"
            )
        is_across = abs(across) > abs(along)
        if self.transient and is_across:
            raise ValueError(
                f"order is 2 and angle is {self.angle:g} rad: a transient step of second order rolls along "
                "x, at 0 or pi; order=1 rolls in any direction"
            )
        cell = field.spacing[is_across]
        if self.transient and length > _LONGEST_STEP * cell:
            raise ValueError(
                f"order is 2 and step is {length:g} m: a transient step of second order is at most one cell "
                f"long, {cell:g} m; take several"
            )
        if not self.transient and abs(length - cell) > 1e-9 * cell:
            raise ValueError(
                f"order is 2 and step is {length:g} m: slip of second order is measured over one cell, "
                f"{cell:g} m; leave step out"
            )
        return (0.0, math.copysign(length, across)) if is_across else (math.copysign(length, along), 0.0)

    def courses(self, field: PressureField) -> dict[str, tuple[float, Callable[[float], Pair]]]:
        """Step and direction; a line contact has no other direction."""
        along, across = self.step_on(field)
        length = math.hypot(along, across)

        def small(x: float, y: float) -> float:
            """Change of a number by which the step changes by so many times (x, y) [m]."""
            small = _COURSE
            for place, rate, cell in zip((along, across), (x, y), field.spacing, strict=True):
                half_cells = 2.0 * place / cell
                away = 0.5 * abs(half_cells - round(half_cells))
                if away > _ON_IT and rate != 0.0:
                    small = min(small, _OF_WAY * away * cell / abs(rate))
            return small

        courses = {
            "step": (
                length * small(along, across),
                lambda by: replace(self, step=length + by).step_on(field),
            ),
            "angle": (small(-across, along), lambda by: replace(self, angle=self.angle + by).step_on(field)),
        }
        if self.order == 2:
            # along the cells, and steady by one of them
            return {"step": courses["step"]} if self.transient else {}
        return courses if field.reference is None else {"step": courses["step"]}

    def step_vector(self, spacing: Pair) -> Pair:
        """The step (x, y) [m] on cells of the size `spacing` [m]."""
        c, sine = math.cos(self.angle), math.sin(self.angle)
        length = self.step if self.step is not None else spacing[0] * c * c + spacing[1] * sine * sine
        return (length * c, length * sine)


@stored
@owning
@dataclass(frozen=True)
@plain
class Shift(Motion):
    """One finite displacement of the upper body over the lower one.

    Parameters
    ----------
    displacement : (float, float) [m]
    force : (Fx, Fy) or None [N]
        Total tangential force on the lower body. The displacement of a component with a given force is found;
        None is for a component whose displacement is given.
    spin : float [rad]
        Rotation about z through (0, 0).
    duration : float [s]
        Duration of the shift, for friction that depends on the slip speed.
    rigid_slip : (2, ny, nx) float or None [m]
        Displacement of each cell of the upper body besides that of `displacement` and `spin`.
    """

    displacement: tuple[float, float] = (0.0, 0.0)
    force: Forces | None = None
    spin: float = 0.0
    duration: float = 1.0
    rigid_slip: Array | None = None
    word: ClassVar[str] = "shift"
    rigid_word: ClassVar[str] = "displacement"
    slip_unit: ClassVar[str] = "m"
    dissipation_unit: ClassVar[str] = "J/m^2"

    def __post_init__(self) -> None:
        object.__setattr__(self, "displacement", pair("displacement", self.displacement, "m"))
        _check_force(self.force)
        number("spin", self.spin, "rad")
        positive("duration", self.duration, "s")
        _check_rigid_slip(self)

    @property
    def rigid(self) -> tuple[float, float, float]:
        """Displacement [m] and rotation [rad]."""
        return (*self.displacement, self.spin)

    @property
    def slip_speed(self) -> float:
        """Slip speed [m/s] of a unit of slip."""
        return 1.0 / self.duration

    def moving(self) -> Moving:
        """The displacement, and the rotation, over a duration."""
        rigid = {"displacement": (0, 1), "spin": (2,)}
        return Moving(rigid, "duration", -1.0 / self.duration, self._found())

    @property
    def kind(self) -> str:
        """The kind of its operator."""
        return "shift"

    def step_on(self, field: PressureField) -> Pair:
        """There is none."""
        return 0.0, 0.0


def _check_rigid_slip(motion: Rolling | Shift) -> None:
    if motion.rigid_slip is None:
        return
    slip = reals("rigid_slip", motion.rigid_slip)
    if slip.ndim != 3 or slip.shape[0] != 2:
        raise ValueError(f"rigid_slip has shape {slip.shape}: (2, ny, nx) is needed, x and y components")
    object.__setattr__(motion, "rigid_slip", slip)


def _check_force(force: Any) -> None:
    if force is None:
        return
    if not isinstance(force, (tuple, list, np.ndarray)) or len(force) != 2:
        raise ValueError(f"force is {force!r}: (Fx, Fy) [N] is needed, None for a given component")
    for k, value in enumerate(force):
        if value is not None:
            number(f"force[{k}]", value, "N")


def rolling_at(velocity: Pair | None) -> Rolling | None:
    """Free rolling at a velocity (x, y) [m/s]; None for none."""
    if velocity is None:
        return None
    return Rolling(velocity=math.hypot(*velocity), angle=math.atan2(velocity[1], velocity[0]))
