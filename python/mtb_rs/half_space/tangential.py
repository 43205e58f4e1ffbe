# SPDX-License-Identifier: MIT OR Apache-2.0
"""Stick and slip: shifts, transient and steady rolling."""

from __future__ import annotations

import math
import time
from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import lru_cache, partial
from typing import TYPE_CHECKING, Any, ClassVar, Literal, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .. import _mtb_rs
from ..base import memory
from ..base.check import choice, number, numbers, pair, positive, reals
from ..base.errors import ConvergenceError
from ..base.owning import check_finite, owning, solved
from ..base.plain import plain
from ..base.progress import shares_shown
from ..base.questions import ask, gathered
from ..base.renamed import renamed
from ..base.stored import stored
from ..base.told import Row, in_words, length
from ..base.units import taking_quantities
from ..base.words import Coupling
from ..bodies.conductor import Conductor, conducting_steel
from ..bodies.material import Material
from ..friction.laws import Friction, InterfaceLayer, PlasticLayer, ShearLayer, as_law
from ..friction.wear_laws import Rubbing, WearLaw, depth_of_pass
from ..geometry.contact_points import window
from ..results.derivatives import Differentiable, Functional, Margin
from ..results.fields import Field, fields_of
from ..results.plausible import of_dent
from ..results.report import Report
from ..results.result import Judged, TangentialFields
from ..results.temperature import RollingTemperature, rolling_temperature
from .coupled_tangent import CoupledTangent, GapByTraction
from .pressure_field import PressureField, creepage_rows, pressure_field
from .tangential_tangent import Course, Grids, Moving, TangentialTangent

if TYPE_CHECKING:
    from .normal import NormalResult

Array = NDArray[np.float64]
Pair = tuple[float, float]
Forces = tuple[float | None, float | None]


class Motion(ABC):
    """What the tangential problem asks of a motion of the upper body over the lower one."""

    #: The word for it, and for what is given along x and y and about z.
    word: ClassVar[str]
    rigid_word: ClassVar[str]
    #: Units of slip and of dissipation.
    slip_unit: ClassVar[str]
    dissipation_unit: ClassVar[str]
    force: Forces | None

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
    """

    creepage: tuple[float, float, float] = (0.0, 0.0, 0.0)
    force: Forces | None = None
    angle: float = 0.0
    velocity: float = 10.0
    transient: bool = False
    step: float | None = None
    word: ClassVar[str] = "rolling"
    rigid_word: ClassVar[str] = "creepage"
    slip_unit: ClassVar[str] = "1"
    dissipation_unit: ClassVar[str] = "Pa"

    def __post_init__(self) -> None:
        object.__setattr__(self, "creepage", numbers("creepage", self.creepage, 3))
        _check_force(self.force)
        number("angle", self.angle, "rad")
        positive("velocity", self.velocity, "m/s")
        if not isinstance(self.transient, (bool, np.bool_)):
            raise ValueError(f"transient is {self.transient!r}: True or False is needed")
        if self.step is not None:
            positive("step", self.step, "m")

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
        if self.step is not None and self.is_steady:
            cell = math.hypot(*replace(self, step=None).step_vector(field.spacing))
            if self.step < _SHORTEST_STEP * cell:
                raise ValueError(
                    f"step is {self.step:g} m: steady rolling needs a step of at least "
                    f"{_SHORTEST_STEP * cell:g} m, {_SHORTEST_STEP:g} of a cell; step=None makes it one cell "
                    "long"
                )
        return along, across

    def courses(self, field: PressureField) -> dict[str, tuple[float, Callable[[float], Pair]]]:
        """Step and direction; a line contact has no other direction."""
        length = math.hypot(*self.step_on(field))
        courses = {
            "step": (_COURSE * length, lambda by: replace(self, step=length + by).step_on(field)),
            "angle": (_COURSE, lambda by: replace(self, angle=self.angle + by).step_on(field)),
        }
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
    """

    displacement: tuple[float, float] = (0.0, 0.0)
    force: Forces | None = None
    spin: float = 0.0
    duration: float = 1.0
    word: ClassVar[str] = "shift"
    rigid_word: ClassVar[str] = "displacement"
    slip_unit: ClassVar[str] = "m"
    dissipation_unit: ClassVar[str] = "J/m^2"

    def __post_init__(self) -> None:
        object.__setattr__(self, "displacement", pair("displacement", self.displacement, "m"))
        _check_force(self.force)
        number("spin", self.spin, "rad")
        positive("duration", self.duration, "s")

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


#: Distance over the one before up to which a creep curve is continued by its last two points.
_FARTHEST = 3.0

#: Small changes of a step, over it, and of a direction [rad], by which operators are derived.
_COURSE = 1e-3

#: Shortest step, over a cell, by which the slip of steady rolling is measured.
_SHORTEST_STEP = 0.1


def _check_force(force: Any) -> None:
    if force is None:
        return
    if not isinstance(force, (tuple, list, np.ndarray)) or len(force) != 2:
        raise ValueError(f"force is {force!r}: (Fx, Fy) [N] is needed, None for a given component")
    for k, value in enumerate(force):
        if value is not None:
            number(f"force[{k}]", value, "N")


@stored
@owning
@dataclass(frozen=True)
@plain
class TangentialState:
    """State after a step, from which the next one starts: plain arrays that can be saved.

    Attributes
    ----------
    traction : (2, ny, nx) [Pa]
        On the lower body.
    pressure : (ny, nx) [Pa]
    coefficient : (ny, nx) [-]
        Coefficient of friction that the particles carry.
    origin, spacing : (float, float) or None [m]
        Of the grid, as of :class:`PressureField`. With them a state may be followed by a step on another grid
        whose cells lie on the same lines; without (as of older files) the next grid must have the same shape
        and is taken for the same.
    accumulated_plastic_slip : (ny, nx) or None [m]
        Of the particles, in a :class:`PlasticLayer`; None where no layer yields.
    """

    traction: Array
    pressure: Array
    coefficient: Array
    origin: Pair | None = None
    spacing: Pair | None = None
    accumulated_plastic_slip: Array | None = None

    def __post_init__(self) -> None:
        shape = np.shape(self.pressure)
        of_particles = ("accumulated_plastic_slip",) if self.accumulated_plastic_slip is not None else ()
        for name in ("pressure", "coefficient", *of_particles):
            values = reals(f"state.{name}", getattr(self, name))
            if values.ndim != 2 or values.shape != shape or np.any(values < 0.0):
                raise ValueError(
                    f"state.{name} has shape {values.shape} and the least value {values.min():g}: "
                    "(ny, nx) like the pressure, nowhere negative, is needed"
                )
            object.__setattr__(self, name, values)
        traction = reals("state.traction", self.traction, "Pa")
        if traction.shape != (2, *shape):
            raise ValueError(f"state.traction has shape {traction.shape}: {(2, *shape)} is needed")
        object.__setattr__(self, "traction", traction)
        for name in ("origin", "spacing"):
            if getattr(self, name) is not None:
                object.__setattr__(self, name, pair(f"state.{name}", getattr(self, name), "m"))

    def cells_before(self, field: PressureField) -> tuple[int, int]:
        """Rows and columns that the first cell of this state lies after that of `field`.

        Raises
        ------
        ValueError
            If the cells of the two do not lie on the same lines.
        """
        shape = field.pressure.shape
        if self.origin is None or self.spacing is None:
            if self.pressure.shape != shape:
                raise ValueError(
                    f"state has shape {self.pressure.shape}, the pressure has {shape}: a state without "
                    "origin and spacing belongs to the same grid"
                )
            return 0, 0
        if not np.allclose(self.spacing, field.spacing, rtol=1e-9, atol=0.0):
            raise ValueError(
                f"state has cells of {self.spacing} m, the pressure has {field.spacing} m: "
                "they must be the same"
            )
        moved = [(a - b) / d for a, b, d in zip(self.origin, field.start, field.spacing, strict=True)]
        whole = [round(cells) for cells in moved]
        if any(abs(a - b) > 1e-6 for a, b in zip(moved, whole, strict=True)):
            raise ValueError(
                f"state begins at {self.origin} m, {moved[0]:.6g} and {moved[1]:.6g} cells from the grid of "
                "the pressure: whole numbers of cells are needed"
            )
        return whole[1], whole[0]


@stored
@solved
@dataclass(frozen=True, repr=False)
@plain
class TangentialResult(Judged, Differentiable, TangentialFields):
    """A solved tangential problem; vectors act on the lower body.

    Attributes
    ----------
    points : (2, ny, nx) [m]
        Cell centres.
    area : (ny, nx) [m2]
    pressure : (ny, nx) [Pa]
    traction : (3, ny, nx) [Pa]
        Friction on the lower body; the third component is zero.
    slip : (2, ny, nx)
        Slip of the upper body over the lower one: relative [-] in rolling, [m] in a shift. It is zero where
        the surfaces do not slip.
    status : (ny, nx) int
        0 open, 1 stick, 2 slip, 3 plastic: the yield stress of a :class:`PlasticLayer` limits the traction.
    friction_coefficient : (ny, nx) [-]
        Coefficient of friction that acts at each point.
    dissipation : (ny, nx)
        Work of friction that turns into heat: per area and distance rolled [Pa] in rolling, per area [J/m2]
        in a shift. The mean of the tractions of a particle before and after a step works on its slip: half of
        the traction of a cell works on the slip there, and half of the traction before works on the slip one
        step behind, also at a column behind the trailing edge. The sum over the cells is the work of the mean
        traction on the rigid slip (between unlike bodies also on the slip by pressure), minus the growth of
        the elastic energy in a shift or a transient step. In steady rolling without spin it is exactly force
        times creepage. The sum of traction times `slip` is more than a tenth too small on 20 cells. The work
        of a layer that yields is part of it.
    force : (3,) [N]
        Friction (x, y) and minus the normal force (z).
    spin_moment : float [N m]
        Sum of (x q_y - y q_x) area.
    creepage : (3,)
        (xi, eta, phi) in rolling, (x, y [m], rotation [rad]) in a shift: given, or found for a force.
    motion : Rolling or Shift
        As asked for.
    state : TangentialState
        For the next shift or transient step.
    plastic_slip : (2, ny, nx) or None
        Plastic shear of a :class:`PlasticLayer`, of the upper body over the lower one, in the unit of `slip`
        and beside it: the two add up to the whole motion of the bodies past each other that is not elastic.
        None without such a layer.
    accumulated_plastic_slip : (ny, nx) or None [m]
        Length of the way of plastic slip that each particle has behind it. In steady rolling it is counted
        from the leading edge.
    plastic_dissipation : (ny, nx) or None
        Part of `dissipation` that turns into heat in the layer.
    """

    points: Array
    area: Array
    pressure: Array
    traction: Array
    slip: Array
    status: NDArray[np.int8]
    friction_coefficient: Array
    dissipation: Array
    force: Array
    spin_moment: float
    creepage: Array
    motion: Rolling | Shift
    state: TangentialState
    report: Report
    plastic_slip: Array | None = None
    accumulated_plastic_slip: Array | None = None
    plastic_dissipation: Array | None = None
    _drawn: ClassVar[tuple[str, ...]] = (
        "points", "area", "pressure", "traction", "slip", "friction_coefficient", "dissipation", "status",
    )  # fmt: skip
    _summed: ClassVar[tuple[str, ...]] = ("force", "spin_moment", "normal_force", "creepage")

    @property
    def slip_unit(self) -> str:
        """Relative in rolling, metres in a shift."""
        return self.motion.slip_unit

    @property
    def dissipation_unit(self) -> str:
        """Work per area and distance rolled, or per area in a shift."""
        return self.motion.dissipation_unit

    def _units(self) -> dict[str, str]:
        slip, heat = self.slip_unit, self.dissipation_unit
        return {"slip": slip, "plastic_slip": slip, "dissipation": heat, "plastic_dissipation": heat}

    def fields(self) -> dict[str, Field]:
        """Its fields over the contact points, by name, those of a layer that yields where there is one."""
        plastic = {
            name: values
            for name in ("plastic_slip", "accumulated_plastic_slip", "plastic_dissipation")
            if (values := getattr(self, name)) is not None
        }
        return super().fields() | fields_of(self._units(), **plastic)

    def temperature(
        self,
        lower: Conductor = conducting_steel,
        upper: Conductor = conducting_steel,
        bulk: tuple[float, float] = (0.0, 0.0),
    ) -> RollingTemperature:
        """Temperatures of both surfaces in and behind a rolling contact.

        The heat is `dissipation` times the rolling velocity. Both bodies pass through the contact at this
        velocity and heat flows into their depth alone, so that a particle that took up the heat q dt a time t
        ago is warmer by ``q dt / (beta sqrt(pi t))``, with the effusivity beta. In contact both surfaces have
        one temperature [ErtzKnothe2002].

        Parameters
        ----------
        lower, upper : Conductor
        bulk : (float, float) [K]
            Temperatures with which the lower and the upper body come, over any common level.

        Returns
        -------
        RollingTemperature
            Exact at the cell centres for the piecewise constant heat. A body that comes into contact twice
            while the bulk temperatures differ has an error of the order of the cells.

        Raises
        ------
        ValueError
            For a shift or a transient step, whose surfaces have no steady temperature.
        """
        motion = self.motion
        if not motion.is_steady:
            raise ValueError(
                f"temperature() is of steady rolling, and this is a "
                f"{'transient step' if motion.slip_unit == '1' else 'shift'}: solve_tangential with "
                "Rolling(..., transient=False) gives a steady one"
            )
        power = self.dissipation * motion.slip_speed
        direction, bodies = motion.direction, (lower, upper)
        given = (self.points, self.area, self.pressure, self.status)
        return rolling_temperature(
            *given, power, direction, motion.slip_speed, bodies, bulk, self.creepage[:2]
        )

    def left_out(self) -> list[str]:
        """What the model leaves out, with its size."""
        change = self.report.omitted.get("gap_change_by_traction_m")
        if change is None:
            return []
        return [
            f"the normal displacement by the traction (it changes the gap by up to {length(change)}; "
            "coupling='full' takes it into account)"
        ]

    def told(self) -> list[Row]:
        """What acts, how the bodies move, how well it is solved: what notebooks and the command line show."""
        return [self._told_outcome(), *super().told(), *self._motion_told(), *self._told_of_solve()]

    def _motion_told(self) -> list[Row]:
        x, y, about_z = self.creepage
        found = "" if not self.motion.is_driven else " (found for the force)"
        if self.motion.slip_unit == "m":
            return [
                (f"shift{found}", f"x {length(x)}, y {length(y)}"),
                (f"rotation{found}", in_words(1e3 * about_z, "mrad")),
            ]
        return [
            (f"creepage{found}", f"x {1e3 * x:.6g}, y {1e3 * y:.6g} per mille"),
            ("spin", in_words(about_z, "1/m")),
        ]

    def facts(self) -> dict[str, Any]:
        """What else its `summary.json` holds: the motion asked for, the report."""
        return {"motion": self.motion, "report": self.report.as_dict()}

    def wear_depth(
        self, law: WearLaw | float | Callable[[Rubbing], Any], wheel_radius: float | None = None
    ) -> Array:
        """Depth (ny,) [m] that one pass of steady or transient rolling wears off each line along x.

        With Archard's law it is the wear coefficient over the friction coefficient times the `dissipation`
        along the line, so that it sums up to the work of friction exactly.

        Parameters
        ----------
        law : as for :func:`mtb_rs.wear`
            Of the body that wears.
        wheel_radius : float or None [m]
            For the depth that a wheel loses in each metre rolled, [m/m]: it passes once a turn.

        Raises
        ------
        ValueError
            For a shift, which passes over nothing.
        """
        if self.motion.dissipation_unit != "Pa":
            raise ValueError("a shift passes over nothing: wear_depth is of rolling, and mtb.wear of sliding")
        if abs(np.sin(self.motion.direction)) > 1e-9:
            raise ValueError("rolling is at an angle to the rows of cells: wear_depth needs it along x")
        slip = np.hypot(*self.slip)
        step = float(self.points[0, 0, 1] - self.points[0, 0, 0])
        depth = depth_of_pass(
            law,
            self.dissipation,
            self.pressure,
            self.friction_coefficient,
            slip,
            self.motion.slip_speed,
            self.points,
            step,
        )
        if wheel_radius is None:
            return depth
        return depth / (2.0 * np.pi * positive("wheel_radius", wheel_radius, "m"))

    def follows(self, before: TangentialResult) -> bool:
        """Whether it started from the state that another one left, as far as it knows."""
        given: _Given | None = vars(self).get("_given")
        if given is None:
            return True
        own, left = given.state, before.state
        return own is not None and all(
            np.array_equal(getattr(own, name), getattr(left, name))
            for name in ("traction", "pressure", "coefficient", "accumulated_plastic_slip")
        )

    def _tangent(self) -> TangentialTangent | CoupledTangent:
        given: _Given | None = vars(self).get("_given")
        if given is None:
            raise ValueError(
                "this result was read from a file or put together, and does not know what was given: "
                "derivatives are those of a result that solve_tangential has just returned"
            )
        if self.plastic_slip is not None:
            raise ValueError(
                "the layer of this result yields, and derivatives do not know it: take differences of "
                "results, or an InterfaceLayer, which stays elastic"
            )
        return given.tangent(self)

    def _functionals(self) -> dict[str, Callable[[], Functional]]:
        area, shape = self.area, self.pressure.shape
        x, y = self.points
        none = np.zeros(shape)
        along = [np.array([area, none, none]), np.array([none, area, none]), np.zeros((3, *shape))]
        force = {"traction": np.stack(along), "pressure": np.stack([none, none, -area])}
        speed, total = self.motion.slip_speed, float((self.dissipation * area).sum())
        moving = self.motion.moving()
        return {
            "force": lambda: Functional((3,), force),
            **Functional.of_pressure(self.pressure, area, self.status > 0),
            "spin_moment": lambda: Functional.of_one(traction=np.stack([-y * area, x * area, none])),
            "friction_power": lambda: Functional(
                (),
                {"dissipation": speed * area[None]},
                {moving.speed: np.array([speed * total * moving.speed_slope])},
            ),
        }

    def __repr__(self) -> str:
        return f"{super().__repr__()[:-1]}, {self.report.status})"


@dataclass(frozen=True)
class _Given:
    """What a tangential problem was solved from, besides its motion."""

    field: PressureField
    friction: Friction
    layer: InterfaceLayer | PlasticLayer | None
    state: TangentialState | None
    #: The last normal problem, where the pressure follows the traction.
    pressed: NormalResult | None = None

    def tangent(self, result: TangentialResult) -> TangentialTangent | CoupledTangent:
        """The problem at its solution."""
        tangential = self._tangential(result)
        if self.pressed is None:
            return tangential
        return CoupledTangent(
            self.pressed._tangent(), tangential, _gap_by_traction(self.field), np.asarray(result.traction)
        )

    def _tangential(self, result: TangentialResult) -> TangentialTangent:
        """The tangential problem, its pressure given."""
        field, motion, friction = self.field, result.motion, self.friction
        shape = (field.pressure.shape[0], field.pressure.shape[1])
        operators, cut, origin = _prepare(field, motion, self.layer, self.state)
        key = _key(field, motion, self.layer, cut)
        before, there = None, None
        if self.state is not None:
            before = (self.state.pressure.shape[0], self.state.pressure.shape[1])
            there = _cut_before(self.state, field, cut)
        slips = result.status == 2
        grids = Grids(shape, cut, before, there, result.status == 0)
        core = _mtb_rs.TangentialTangent(
            operators,
            grids.cells(field.pressure),
            origin,
            motion.drive(),
            float(motion.rigid[2]),
            float(motion.slip_speed),
            friction.native(shape, cut),
            _earlier(self.state, friction, there),
            (
                grids.cells(result.traction[:2]),
                grids.cells(result.slip),
                grids.cells(result.friction_coefficient, friction.at_rest()),
                result.creepage[:2].tolist(),
            ),
            (shape[::-1], (cut[1].start, cut[0].start)),
        )
        bodies = {"lower": field.lower, "upper": field.upper}

        def other_bodies(lower: Pair | None, upper: Pair | None) -> _mtb_rs.PatchOperators:
            return _mtb_rs.PatchOperators(*key._replace(lower=lower, upper=upper, layer=0.0))

        return TangentialTangent(
            core,
            grids,
            motion.moving(),
            friction.slopes(slips),
            friction.followed(),
            None if self.layer is None else (self.layer.thickness, self.layer.shear_modulus),
            {side: body for side, body in bodies.items() if body is not None},
            other_bodies,
            self._courses(motion, key),
            self._refused(motion),
            _margin(result),
        )

    @property
    def _carries(self) -> bool:
        """Whether a step carries the memory of friction along."""
        return self.friction.depends_on_speed and not self.friction.lacks_memory

    def _courses(self, motion: Motion, key: _Key) -> dict[str, Course]:
        """What operators are made for, besides the bodies."""

        def operators(step: Callable[[float], Pair], by: float) -> _mtb_rs.PatchOperators:
            return _mtb_rs.PatchOperators(*key._replace(step=step(by)))

        if self._carries:
            return {}
        courses = motion.courses(self.field).items()
        return {name: Course(size, partial(operators, step)) for name, (size, step) in courses}

    def _refused(self, motion: Motion) -> dict[str, str]:
        """What could be asked for as well, and why there is no derivative by it."""
        refused: dict[str, str] = {}
        if self.pressed is None:
            reason = (
                "the pressure is given, and follows from it by the normal contact: derive by 'pressure' and "
                "take the derivatives of solve_normal, or solve with coupling='full'"
            )
            refused |= dict.fromkeys(("gap", "normal_force", "approach"), reason)
        if self._carries:
            reason = (
                "the memory of the friction is carried along by the step, which is not derived: friction "
                "without memory has this derivative"
            )
            refused |= dict.fromkeys(motion.courses(self.field), reason)
        return refused


def _margin(result: TangentialResult) -> Margin:
    """How near points are to slipping or sticking; those in contact are given."""
    size = np.hypot(*result.traction[:2])
    bound = result.friction_coefficient * result.pressure
    sticks, slips = result.status == 1, result.status == 2
    slip = np.hypot(*result.slip)
    return Margin(
        parting=math.inf,
        touching=math.inf,
        slipping=float((bound - size)[sticks].min() / bound.max()) if sticks.any() else math.inf,
        sticking=float(slip[slips].min() / slip.max()) if slips.any() else math.inf,
    )


class _Key(NamedTuple):
    """All that the operators depend on."""

    shape: tuple[int, int]
    spacing: Pair
    lower: Pair | None
    upper: Pair | None
    layer: float
    motion: str
    step: Pair
    reference: float | None
    softens: bool


@lru_cache(maxsize=4)
def _operators(key: _Key) -> _mtb_rs.PatchOperators:
    return _mtb_rs.PatchOperators(*key)


def _constants(body: Material | None) -> Pair | None:
    return None if body is None else (body.shear_modulus, body.poisson_ratio)


def _key(
    field: PressureField,
    motion: Rolling | Shift,
    layer: InterfaceLayer | PlasticLayer | None,
    cut: tuple[slice, slice],
) -> _Key:
    """What the operators on a rectangle of cells depend on."""
    plasticity = None if layer is None else layer.plasticity
    return _Key(
        shape=(cut[1].stop - cut[1].start, cut[0].stop - cut[0].start),
        spacing=field.spacing,
        lower=_constants(field.lower),
        upper=_constants(field.upper),
        layer=0.0 if layer is None else layer.flexibility,
        motion=motion.kind,
        step=motion.step_on(field),
        reference=field.reference,
        softens=plasticity is not None and plasticity[1] < 0.0,
    )


def _plasticity(
    layer: InterfaceLayer | PlasticLayer | None,
    state: TangentialState | None,
    there: tuple[slice, slice] | None,
) -> tuple[float, float, Array | None] | None:
    """The yield of a layer, with the plastic slip of an earlier state on a rectangle of its cells."""
    if layer is None or layer.plasticity is None:
        return None
    earlier = None
    if state is not None and there is not None:
        before = state.accumulated_plastic_slip
        earlier = window(np.zeros(state.pressure.shape) if before is None else before, there)
    return (*layer.plasticity, earlier)


def _cut_before(
    state: TangentialState, field: PressureField, cut: tuple[slice, slice]
) -> tuple[slice, slice]:
    """A rectangle of cells of the field, in those of an earlier state."""
    rows, columns = state.cells_before(field)
    return (
        slice(cut[0].start - rows, cut[0].stop - rows),
        slice(cut[1].start - columns, cut[1].stop - columns),
    )


def _earlier(
    state: TangentialState | None, friction: Friction, there: tuple[slice, slice] | None
) -> tuple[Array, Array, Array] | None:
    """An earlier state on a rectangle of its cells, as the core takes it."""
    if state is None or there is None:
        return None
    return (
        window(state.traction, there),
        window(state.pressure, there),
        window(state.coefficient, there, fill=friction.at_rest()),
    )


def _prepare(
    field: PressureField,
    motion: Rolling | Shift,
    layer: InterfaceLayer | PlasticLayer | None,
    state: TangentialState | None,
) -> tuple[_mtb_rs.PatchOperators, tuple[slice, slice], Pair]:
    """Operators on the smallest rectangle that holds the contact, that rectangle, and its first cell.

    The rectangle is in cells of the field, and goes beyond them where the state does.
    """
    loaded = np.argwhere(field.pressure > 0.0)
    if not loaded.size:
        raise ValueError("the pressure is zero everywhere: there is no contact to roll or to slide")
    if state is not None:
        carried = np.any(state.traction != 0.0, axis=0) | (state.pressure > 0.0)
        if state.accumulated_plastic_slip is not None and motion.kind == "shift":
            # in rolling, what has left the contact does not come back
            carried |= state.accumulated_plastic_slip > 0.0
        loaded = np.concatenate([loaded, np.argwhere(carried) + state.cells_before(field)])
    first, last = loaded.min(axis=0).tolist(), loaded.max(axis=0).tolist()
    cut = (slice(first[0], last[0] + 1), slice(first[1], last[1] + 1))
    key = _key(field, motion, layer, cut)
    origin = (
        field.start[0] + cut[1].start * field.spacing[0],
        field.start[1] + cut[0].start * field.spacing[1],
    )
    nx, ny = key.shape
    needed, what = memory.ROLLING_CELL[key.motion] * nx * ny, f"the tangential contact of {nx} x {ny} cells"
    memory.refuse(needed, what, "take fewer, larger cells")
    memory.say(needed, what)
    return _operators(key), cut, origin


@taking_quantities
def solve_tangential(
    normal: Any,
    motion: Rolling | Shift,
    friction: Friction,
    layer: InterfaceLayer | PlasticLayer | None = None,
    state: TangentialState | None = None,
    tolerance: float = 1e-8,
    coupling: Coupling = "one-way",
) -> TangentialResult:
    """Traction, stick and slip of a contact that shifts or rolls.

    The bodies are half-spaces under piecewise constant tractions. The solver is a semismooth Newton method
    that starts from coarser grids and computes its products by the Fourier transform. In steady rolling the
    slip is a first-order difference over one step, and in steady and transient rolling the rigid slip is
    taken a sixth of a step ahead. CONTACT does both, so its fields agree cell by cell. The error falls with
    `Rolling.step`, by default one cell.

    Parameters
    ----------
    normal : NormalResult, Result or PressureField
        Pressure on one regular patch, and the two bodies.
    motion : Rolling or Shift
    friction : Coulomb, StaticKinetic, FallingFriction or TabulatedFriction
    layer : InterfaceLayer, PlasticLayer or None
        Layer that adds its shear compliance; an elastic one has no influence in full sliding. One that yields
        bounds the traction as well; it takes Coulomb's friction.
    state : TangentialState or None
        Earlier state of a shift or a transient step; None for surfaces without traction.
    tolerance : float [-]
        Relative residual of the contact conditions.
    coupling : {"one-way", "full"}
        For unlike bodies. Their pressure always moves the surfaces tangentially. "one-way" leaves out the
        normal displacement by the traction, and reports the size of this change of the gap as
        ``report.omitted["gap_change_by_traction_m"]``. "full" repeats both problems in turn until the
        pressure stays, at the normal force of `normal`, and reports the change of the pressure over its
        peak, as ``report.force_balance["pressure_change_by_traction"]``. It needs the gap, so `normal` must
        be a result of `solve_normal` with locked tilts: a scene's result, a :class:`PressureField`,
        a line contact, a periodic contact or free tilts (`moments`) are refused. Like bodies settle
        in one round.

    Raises
    ------
    ValueError
        For bad input, for a force of at least what the coefficient at rest and the layer carry, and for a
        layer that softens so fast that more than one answer may exist.
    ConvergenceError
        If no solution was found. The message names the likely cause, and the last iterate is its ``result``.
    """
    choice("coupling", coupling, Coupling)
    _check_problem(motion, as_law(friction), layer, state)
    number("tolerance", tolerance)
    if coupling == "full":
        # what presses has been asked about where it was solved
        with gathered():
            return _alternate(normal, motion, friction, layer, state, tolerance)
    started = time.perf_counter()
    field = pressure_field(normal)
    _ask_about(normal)
    if motion.is_steady and state is not None:
        raise ValueError("state is given, but steady rolling has no past: use transient=True or leave it out")
    shape = field.pressure.shape
    operators, cut, origin = _prepare(field, motion, layer, state)
    prepared = time.perf_counter()
    there = None if state is None else _cut_before(state, field, cut)
    found = operators.solve(
        window(field.pressure, cut),
        origin,
        motion.drive(),
        float(motion.rigid[2]),
        float(motion.slip_speed),
        friction.native(shape, cut),
        _earlier(state, friction, there),
        float(tolerance),
        around=(shape[::-1], (cut[1].start, cut[0].start)),
        plasticity=_plasticity(layer, state, there),
    )
    finished = time.perf_counter()
    result = _result(field, motion, friction, layer, cut, found, (started, prepared, finished))
    # what was given is no field of a result, but its derivatives need it
    object.__setattr__(result, "_given", _Given(field, friction, layer, state))
    if not result.report.converged:
        raise ConvergenceError(
            f"stick and slip were not found: residual {result.report.residual:.1e} after "
            f"{result.report.iterations} Newton steps, {tolerance:.0e} asked for"
            f"{_likely_cause(motion, friction)}",
            result,
        )
    return result


def _ask_about(normal: Any) -> None:
    """Questions about a pressure that was given; those about a result came where it was solved."""
    if isinstance(normal, PressureField):
        ask(of_dent(float(normal.pressure.max()), [normal.lower, normal.upper]))


def _likely_cause(motion: Rolling | Shift, friction: Friction) -> str:
    """What may stand against a solution, to be put behind a message."""
    if friction.is_constant:
        return ""
    causes = []
    if motion.is_driven:
        causes.append("the force prescribed may be above the largest one that this friction law carries")
    if friction.lacks_memory:
        advice = "friction that depends on the slip may have no state without a memory: give it one"
        causes.append(advice + motion.advice)
    return f"; {', or '.join(causes)}" if causes else ""


def _check_problem(motion: Any, friction: Friction, layer: Any, state: Any) -> None:
    if not isinstance(motion, Motion):
        raise ValueError(f"motion is {motion!r}: a Rolling or a Shift is needed")
    if layer is not None and not isinstance(layer, ShearLayer):
        raise ValueError(f"layer is {layer!r}: an InterfaceLayer or a PlasticLayer is needed, or None")
    if layer is not None and layer.plasticity is not None and not friction.is_constant:
        raise ValueError(
            f"friction is a {type(friction).__name__}, and the layer yields: a layer that yields is solved "
            "with Coulomb's friction"
        )
    if state is not None and not isinstance(state, TangentialState):
        raise ValueError(f"state is {state!r}: the TangentialState of an earlier result is needed, or None")


#: Largest change of the pressure, over its peak, at which the alternation of both problems ends, and over
#: the tolerance; the lesser of the two counts.
_SETTLED = 1e-6
_SETTLED_OVER_TOLERANCE = 100.0


def _alternate(
    normal: Any,
    motion: Rolling | Shift,
    friction: Friction,
    layer: InterfaceLayer | PlasticLayer | None,
    state: TangentialState | None,
    tolerance: float,
) -> TangentialResult:
    """Normal and tangential problem in turn [Kalker1990, ch. 4] until the pressure stays."""
    from .normal import NormalResult, solve_normal

    if not isinstance(normal, NormalResult):
        raise ValueError(
            f"normal is a {type(normal).__name__}: coupling='full' needs a result of solve_normal"
        )
    if any(normal.tilts):
        raise ValueError(
            "coupling='full' does not let the bodies tilt, but they were free to tilt in the normal contact: "
            "a result of solve_normal without moments_about_axes is needed"
        )
    first = pressure_field(normal)
    field = first
    changes: list[float] = []
    opened = _gap_by_traction(field)
    settled = min(_SETTLED, _SETTLED_OVER_TOLERANCE * tolerance)
    result = solve_tangential(field, motion, friction, layer, state, tolerance)
    while not changes or changes[-1] > settled:
        again = solve_normal(
            normal.initial_gap + opened.of(result.traction),
            field.spacing,
            lower=normal.lower,
            upper=normal.upper,
            force=normal.normal_force,
            tolerance=min(tolerance, 1e-8),
            # contact at the edge of the grid was legitimate in the normal problem already
            edge="sharp",
            normal_layer=normal.normal_layer,
            hardness=normal.hardness,
        )
        pressure = np.maximum(np.asarray(again.pressure, dtype=float), 0.0)
        changes.append(float(np.abs(pressure - field.pressure).max() / pressure.max()))
        field = replace(field, pressure=pressure)
        result = solve_tangential(field, motion, friction, layer, state, tolerance)
        if len(changes) > 3 and changes[-1] > 0.9 * changes[-2] > 10.0 * settled:
            raise ConvergenceError(
                f"normal and tangential problem do not settle: the pressure changes by {changes[-1]:.1e}",
                result,
            )
    whole = float(np.abs(field.pressure - first.pressure).max() / first.pressure.max())
    balance = {**result.report.force_balance, "pressure_change_by_traction": whole}
    report = replace(
        result.report, method=f"alternating, {len(changes)} rounds", omitted={}, force_balance=balance
    )
    settled_result = replace(result, report=report)
    object.__setattr__(settled_result, "_given", _Given(field, friction, layer, state, again))
    return settled_result


def _balance(motion: Rolling | Shift, force: Array) -> dict[str, float]:
    """The part of prescribed forces that is missing, over the normal force; nothing where none is."""
    pairs = zip(force, motion.force or (), strict=False)
    missing = [abs(own - given) for own, given in pairs if given is not None]
    return {"relative_error": float(max(missing) / abs(force[2]))} if missing else {}


def _gap_by_traction(field: PressureField) -> GapByTraction:
    """How tractions on the cells of a field open the gap."""
    ny, nx = field.pressure.shape
    bodies = {"lower": field.lower, "upper": field.upper}
    elastic = {side: body for side, body in bodies.items() if body is not None}
    return GapByTraction((ny, nx), field.spacing, elastic)


def _left_out(field: PressureField, traction: Array, status: NDArray[Any]) -> dict[str, float]:
    """Size of the change of the gap by traction, which the pressure given has not felt."""
    opened = _gap_by_traction(field)
    if field.reference is not None or opened.cancels:
        return {}
    change = opened.of(traction)[status > 0]
    return {"gap_change_by_traction_m": float(np.abs(change - change.mean()).max())}


def _result(
    field: PressureField,
    motion: Rolling | Shift,
    friction: Friction,
    layer: InterfaceLayer | PlasticLayer | None,
    cut: tuple[slice, slice],
    found: _mtb_rs.TangentialOutcome,
    times: tuple[float, float, float],
) -> TangentialResult:
    shape = field.pressure.shape

    def whole(part: NDArray[Any], fill: float = 0.0) -> NDArray[Any]:
        """`part` of the grid (..., ny, nx) put back into the whole of it."""
        seen = tuple(slice(-c.start, n - c.start) for c, n in zip(cut, shape, strict=True))
        return window(part, seen, fill)

    status = whole(found.status)
    slip = whole(found.slip)
    slip[:, status < 2] = 0.0
    dissipation = np.asarray(found.dissipation)
    plastic_slip = accumulated = plastic_heat = None
    areas = {}
    area = field.spacing[0] * field.spacing[1]
    if found.plastic is not None:
        share, accumulated = (whole(part) for part in found.plastic)
        plastic_slip, plastic_heat = share * slip, share * dissipation
        slip = (1.0 - share) * slip
        areas["plastic_area"] = float(np.count_nonzero(status == 3) * area)
    x, y = field.coordinates()
    coefficient = whole(found.coefficient, fill=friction.at_rest())
    tangential = whole(found.traction)
    traction = np.concatenate([tangential, np.zeros((1, *shape))])
    force = np.array([*found.force, -field.normal_force])
    spin = motion.rigid[2]
    report = Report(
        converged=found.converged,
        status="converged" if found.converged else "no convergence",
        model="half-space" if layer is None else "half-space and layer",
        method="direct",
        solver="semismooth Newton on discs, GMRES, FFT, nested grids",
        iterations=found.iterations,
        residual=found.history[-1],
        contact_area=float(np.count_nonzero(status) * area),
        peak_pressure=float(field.pressure.max()),
        convolutions=found.products,
        preconditionings=found.preconditionings,
        force_balance={
            "tangential": float(np.hypot(force[0], force[1])),
            "normal": field.normal_force,
            "stick_area": float(np.count_nonzero(status == 1) * area),
            **areas,
            **_balance(motion, force),
        },
        omitted=_left_out(field, traction, status),
        time_s={"operators": times[1] - times[0], "solve": times[2] - times[1]},
        history=tuple(found.history),
    )
    state = TangentialState(tangential, field.pressure, coefficient, field.start, field.spacing, accumulated)
    return TangentialResult(
        points=np.stack(np.meshgrid(x, y)),
        area=np.full(field.pressure.shape, area),
        pressure=field.pressure,
        traction=traction,
        slip=slip,
        status=status,
        friction_coefficient=coefficient,
        dissipation=dissipation,
        force=force,
        spin_moment=found.spin_moment,
        creepage=np.array([*found.drive, spin]),
        motion=motion,
        state=state,
        report=report,
        plastic_slip=plastic_slip,
        accumulated_plastic_slip=accumulated,
        plastic_dissipation=plastic_heat,
    )


@taking_quantities
@renamed(speed="velocity")
def creep_curve(
    normal: Any,
    creepages: ArrayLike,
    friction: Friction,
    layer: InterfaceLayer | PlasticLayer | None = None,
    velocity: float = 10.0,
    tolerance: float = 1e-6,
    progress: Callable[[float], Any] | Literal[True] | None = None,
) -> Array:
    """Forces of steady rolling over a list of creepages.

    Along a line of creepages each solve starts from the last two, which halves the work if they are close.

    Parameters
    ----------
    normal : NormalResult, Result or PressureField
    creepages : (n, 3)
        (xi, eta, phi) [-, -, 1/m] each. Columns of a table of pandas are taken by their names "xi", "eta" and
        "phi", in whatever order.
    friction, layer
        As in :func:`solve_tangential`.
    velocity : float [m/s]
        Of rolling.
    tolerance : float [-]
    progress : callable or True
        Called with the share done after each creepage; True shows a bar (extra ``notebook``).

    Returns
    -------
    (n, 3) float
        Fx, Fy [N] and Mz [N m] on the lower body.

    Raises
    ------
    ConvergenceError
        If creepages did not converge. The message names them, and ``.result`` holds all forces, with NaN for
        these.
    """
    rows = creepage_rows(creepages)
    number("tolerance", tolerance)
    field = pressure_field(normal)
    _ask_about(normal)
    _check_problem(Rolling(velocity=velocity), as_law(friction), layer, None)
    operators, cut, origin = _prepare(field, Rolling(velocity=velocity), layer, None)
    law = friction.native(field.pressure.shape, cut)
    plasticity = _plasticity(layer, None, None)
    pressure = window(field.pressure, cut)
    forces: Array = np.zeros((len(rows), 3))
    converged = np.zeros(len(rows), dtype=bool)
    # where friction falls with slip there may be several states, and the start would choose among them
    is_unique = not friction.depends_on_speed
    size = math.sqrt(np.count_nonzero(pressure) * field.spacing[0] * field.spacing[1])
    places = rows * np.array([1.0, 1.0, size])
    last: list[Array] = []
    with shares_shown(progress, "rolling") as told:
        for k, (xi, eta, phi) in enumerate(rows.tolist()):
            drive = [(xi, False), (eta, False)]
            start = _along(places[k - 2 : k + 1], last) if is_unique and len(last) == 2 else None
            found = operators.solve(
                pressure,
                origin,
                drive,
                phi,
                float(velocity),
                law,
                None,
                float(tolerance),
                start,
                plasticity=plasticity,
            )
            forces[k], converged[k] = (*found.force, found.spin_moment), found.converged
            last = [*last[-1:], found.traction] if converged[k] else []
            told((k + 1) / len(rows))
    failed = np.flatnonzero(~converged)
    if failed.size:
        forces[failed] = np.nan
        cause = _likely_cause(Rolling(velocity=velocity), friction)
        raise ConvergenceError(f"no convergence at creepages {rows[failed].tolist()}{cause}", forces)
    check_finite("forces", forces)
    return forces


def _along(places: Array, last: list[Array]) -> Array | None:
    """The traction at the third of three places from those at the two before; None where no line goes on."""
    before, ahead = np.diff(places, axis=0)
    square = float(before @ before)
    share = float(ahead @ before) / square if square > 0.0 else 0.0
    if not 0.0 < share < _FARTHEST or np.linalg.norm(ahead - share * before) > 0.1 * np.linalg.norm(ahead):
        return None
    return np.ascontiguousarray(last[1] + share * (last[1] - last[0]))
