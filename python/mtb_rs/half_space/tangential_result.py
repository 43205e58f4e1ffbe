# SPDX-License-Identifier: MIT OR Apache-2.0
"""A solved tangential problem, and what it was solved from."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from functools import partial
from typing import TYPE_CHECKING, Any, ClassVar, cast

import numpy as np
from numpy.typing import NDArray

from .. import _mtb_rs
from ..base.check import positive
from ..base.differences import AHEAD
from ..base.owning import solved
from ..base.plain import plain
from ..base.stored import stored
from ..base.told import Row, in_words, length
from ..bodies.conductor import Conductor, conducting_steel
from ..bodies.constants import refused_constants
from ..bodies.material import Material
from ..bodies.simple import Core, FieldBody, are_layered
from ..friction.laws import Friction, InterfaceLayer, PlasticLayer
from ..friction.wear_laws import Rubbing, WearLaw, depth_of_pass
from ..results.damage import Damaged, Rolled
from ..results.derivatives import ChainedBack, Functional, Margin
from ..results.fields import Field, fields_of, totals_of
from ..results.report import Report
from ..results.result import Judged, TangentialFields
from ..results.stressed import BELOW_INCLINED, Loads, Stressed, loaded_grid
from ..results.temperature import RollingTemperature, rolling_temperature
from .compound import TURN, Compound
from .coupled_tangent import CoupledTangent, GapByTraction
from .motions import Motion, Rolling, Shift
from .pressure_field import PressureField
from .tangential_operators import (
    Key,
    cut_before,
    earlier,
    key_of,
    operators_around,
    plasticity_of,
    velocity_of,
)
from .tangential_state import TangentialState
from .tangential_tangent import Course, Grids, Made, TangentialTangent, Weighted, Yielded

if TYPE_CHECKING:
    from .normal import NormalResult

Array = NDArray[np.float64]
Pair = tuple[float, float]


@stored
@solved
@dataclass(frozen=True, repr=False)
@plain
class TangentialResult(Judged, ChainedBack, Stressed, Damaged, TangentialFields):
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
        in a shift. The mean of the tractions of a particle before and after a step works on its slip: half
        of the traction of a cell works on the slip there, and half of the traction before works on the slip
        one step behind, also at a column behind the trailing edge. The sum over the cells is the work of the
        mean traction on the rigid slip (between unlike bodies also on the slip by pressure), minus the
        growth of the elastic energy in a shift or a transient step. In steady rolling of like bodies without
        spin it is exactly force times creepage, unless a body creeps, which then takes a part of that work;
        between unlike bodies the pressure works as well, on the slip that it causes. The sum of
        traction times `slip` is more than a tenth too small on 20 cells. The work of a layer that yields is
        part of it.
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
    lower, upper : HalfSpace, Layered, Viscoelastic, Prism, Rigid or None
        None of results that were stored by an earlier version.
    is_line : bool
        Whether it is a line contact: plane strain, one row of cells.
    is_inclined : bool
        Whether the surface turns from row to row, by the inclination of the normal contact.
    inclination : (ny,) or None [rad]
        Of each row of cells, where the surface turns or a body is a prism; its `force` and `traction` are
        along the rows. None on a plane, and of results that were stored by an earlier version.
    rolling_resistance : float or None [N]
        Force that the creep of the bodies puts up against the rolling, as that of a :class:`NormalResult`.
        With ``coupling="full"`` also what the tractions of unlike bodies do, which press their surfaces up
        and down: the dissipation is force times creepage and this resistance, but for the cells (1, 0.3 and
        0.05 % on 40, 80 and 160 cells a side). None where neither is, in a shift, where the pressure was
        given without a gap, and where it reaches the edge of the grid.
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
    lower: FieldBody | None = None
    upper: FieldBody | None = None
    is_line: bool = False
    is_inclined: bool = False
    inclination: Array | None = None
    rolling_resistance: float | None = None
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

    @property
    def friction_power(self) -> float:
        """Heat of friction [W]; of a shift, its work over its duration."""
        return float(self.motion.slip_speed * (self.dissipation * self.area).sum())

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
            A result keeps no materials: under a :class:`TemperatureFriction` the temperatures by which it was
            solved are ``result.temperature(**law.surfaces)``.
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
        given = (self.points, self.area, self.pressure, self.status, cast(Pair, self.state.spacing))
        return rolling_temperature(
            *given, power, direction, motion.slip_speed, bodies, bulk, self.creepage[:2]
        )

    def _loads(self) -> Loads:
        if self.is_inclined:
            raise ValueError(BELOW_INCLINED)
        # those of every state that a solve has left
        spacing = cast(Pair, self.state.spacing)
        grid = loaded_grid(self.points, spacing, self.pressure, self.traction)
        return Loads((grid,), self.lower, self.upper, is_line=self.is_line, way=self.motion.passage)

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
        rows = [
            (f"creepage{found}", f"x {1e3 * x:.6g}, y {1e3 * y:.6g} per mille"),
            ("spin", in_words(about_z, "1/m")),
        ]
        if self.rolling_resistance is not None:
            rows.append(("rolling resistance", in_words(self.rolling_resistance, "N")))
        return rows

    def totals(self) -> dict[str, Field]:
        """Its forces, moments and motions, by name, the rolling resistance where a body creeps."""
        if self.rolling_resistance is None:
            return super().totals()
        return super().totals() | totals_of(rolling_resistance=self.rolling_resistance)

    def facts(self) -> dict[str, Any]:
        """What else its `summary.json` holds: the motion asked for, the report."""
        return {"motion": self.motion, "report": self.report.as_dict()}

    def _rolled(self) -> Rolled:
        if self.motion.dissipation_unit != "Pa":
            raise ValueError("a shift passes over nothing: T gamma and what follows from it are of rolling")
        given = self.motion.rigid_slip
        extra = np.zeros(2) if given is None else (self.traction[:2] * given * self.area).sum(axis=(1, 2))
        load = -float(self.force[2])
        return Rolled(self.force[:2], self.spin_moment, load, self.creepage, self.pressure, extra)

    def wear_depth(
        self, law: WearLaw | float | Callable[[Rubbing], Any], wheel_radius: float | None = None
    ) -> Array:
        """Depth (ny,) [m] that one pass of steady or transient rolling wears off each line along x.

        With Archard's law it is the wear coefficient over the friction coefficient times the `dissipation`
        along the line, so that it sums up to the work of friction exactly. Where a :class:`PlasticLayer`
        yields, traction over pressure takes the place of the coefficient, as all of its shear is slip to the
        law: depth is then pressure times slip, as :func:`mtb_rs.wear` has it in sliding.

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
        # where a layer yields, less than friction times pressure works on the slip
        yields = (self.status == 3) & (self.pressure > 0.0)
        own = np.hypot(*self.traction[:2]) / np.where(yields, self.pressure, 1.0)
        friction = np.where(yields, own, self.friction_coefficient)
        depth = depth_of_pass(
            law,
            self.dissipation,
            self.pressure,
            friction,
            slip,
            self.motion.slip_speed,
            self.points,
            cast(Pair, self.state.spacing)[0],
        )
        if wheel_radius is None:
            return depth
        return depth / (2.0 * np.pi * positive("wheel_radius", wheel_radius, "m"))

    def follows(self, earlier: Any) -> bool:
        """Whether it started from the state that another one left, as far as it knows."""
        if not isinstance(earlier, TangentialResult):
            return False
        given: Given | None = vars(self).get("_given")
        if given is None:
            return True
        own, left = given.state, earlier.state
        return own is not None and all(
            np.array_equal(getattr(own, name), getattr(left, name))
            for name in ("traction", "pressure", "coefficient", "accumulated_plastic_slip")
        )

    def _carried(self, by: Mapping[str, Array]) -> dict[str, Array]:
        if "state.traction" not in by:
            return {}
        flat = by["state.traction"]
        carried = {
            "traction": np.concatenate([flat, np.zeros_like(flat[:, :1])], axis=1),
            "pressure": by["state.pressure"],
            "friction_coefficient": by["state.coefficient"],
        }
        given: Given = vars(self)["_given"]
        assert given.state is not None
        if "state.accumulated_plastic_slip" in by and given.state.accumulated_plastic_slip is not None:
            carried["accumulated_plastic_slip"] = by["state.accumulated_plastic_slip"]
        return carried

    def _tangent(self) -> TangentialTangent | CoupledTangent:
        given: Given | None = vars(self).get("_given")
        if given is None:
            raise ValueError(
                "this result was read from a file or put together, and does not know what was given: "
                "derivatives are those of a result that solve_tangential has just returned"
            )
        return given.tangent(self)

    def _kept(self) -> TangentialResult:
        lower, upper = (None if body is None else body.kept() for body in (self.lower, self.upper))
        return replace(self, lower=lower, upper=upper)

    def _functionals(self) -> dict[str, Callable[[], Functional]]:
        area, shape = self.area, self.pressure.shape
        x, y = self.points
        none = np.zeros(shape)
        along = [np.array([area, none, none]), np.array([none, area, none]), np.zeros((3, *shape))]
        force = {"traction": np.stack(along), "pressure": np.stack([none, none, -area])}
        moving, speed = self.motion.moving(), self.motion.slip_speed

        def resistance() -> Functional:
            given: Given | None = vars(self).get("_given")
            if given is not None and given.pressed is not None:
                raise ValueError(
                    "of is 'rolling_resistance': its derivatives are not known where the pressure follows "
                    "the traction (coupling='full'); 'force' and 'friction_power' have some"
                )
            raise ValueError(
                "of is 'rolling_resistance': it is one of the pressure, and the result of solve_normal that "
                "pressed has its derivatives"
            )

        return {
            **({} if self.rolling_resistance is None else {"rolling_resistance": resistance}),
            "force": lambda: Functional((3,), force),
            **Functional.of_pressure(lambda: self.pressure, area, self.status > 0),
            "spin_moment": lambda: Functional.of_one(traction=np.stack([-y * area, x * area, none])),
            "friction_power": lambda: Functional(
                (),
                {"dissipation": speed * area[None]},
                {moving.speed: np.array([self.friction_power * moving.speed_slope])},
            ),
        }

    def __repr__(self) -> str:
        return f"{super().__repr__()[:-1]}, {self.report.status})"


@dataclass(frozen=True)
class Given:
    """What a tangential problem was solved from, besides its motion."""

    field: PressureField
    friction: Friction
    layer: InterfaceLayer | PlasticLayer | None
    state: TangentialState | None
    #: What has been asked of it: what other operators make of the solution, and what a unit of a modulus
    #: adds to the gap that the tractions open.
    made: dict[str, Made]
    added: dict[str, Array]
    #: The last normal problem, where the pressure follows the traction.
    pressed: NormalResult | None = None

    def tangent(self, result: TangentialResult) -> TangentialTangent | CoupledTangent:
        """The problem at its solution."""
        tangential = self._tangential(result)
        if self.pressed is None:
            return tangential
        opened = gap_by_traction(self.field, result.motion)
        return CoupledTangent(
            self.pressed._tangent(), tangential, opened, np.asarray(result.traction), self.added
        )

    def _tangential(self, result: TangentialResult) -> TangentialTangent:
        """The tangential problem, its pressure given."""
        field, motion, friction = self.field, result.motion, self.friction
        shape = (field.pressure.shape[0], field.pressure.shape[1])
        operators, cut, origin = operators_around(field, motion, self.layer, self.state)
        key = key_of(field, motion, self.layer, cut)
        before, there = None, None
        if self.state is not None:
            before = (self.state.pressure.shape[0], self.state.pressure.shape[1])
            there = cut_before(self.state, field, cut)
        slips, slip_given = result.status == 2, motion.slip_given(shape)
        yielded, slip = None, np.asarray(result.slip)
        if result.plastic_slip is not None:
            slip = slip + result.plastic_slip
            yielded = Yielded(_plastic_share(result), slip, np.asarray(result.dissipation))
        grids = Grids(shape, cut, before, there, result.status == 0)
        core = _mtb_rs.TangentialTangent(
            operators,
            grids.cells(field.pressure),
            origin,
            motion.drive(),
            float(motion.rigid[2]),
            float(motion.slip_speed),
            friction.native(shape, cut),
            earlier(self.state, friction, there),
            (
                grids.cells(result.traction[:2]),
                grids.cells(slip),
                grids.cells(result.friction_coefficient, friction.at_rest()),
                result.creepage[:2].tolist(),
            ),
            (shape[::-1], (cut[1].start, cut[0].start)),
            None if slip_given is None else grids.cells(slip_given),
            plasticity_of(self.layer, self.state, there),
        )
        bodies = {"lower": field.lower, "upper": field.upper}

        def other_bodies(lower: Pair | None, upper: Pair | None) -> _mtb_rs.PatchOperators:
            return _mtb_rs.PatchOperators(*key._replace(lower=lower, upper=upper, layer=0.0, prisms=None))

        return TangentialTangent(
            core,
            grids,
            motion.moving(),
            friction.slopes(slips),
            friction.followed(),
            None if self.layer is None else (self.layer.thickness, self.layer.shear_modulus),
            {side: body for side, body in bodies.items() if isinstance(body, Material)},
            other_bodies,
            self._courses(motion, key) | self._by_prisms(key) | self._by_compound(motion, key),
            self._refused(motion),
            _margin(result, self.layer),
            yielded,
            made=self.made,
            is_inclined=field.inclination is not None,
        )

    @property
    def _carries(self) -> tuple[str, str] | None:
        """What a step carries along besides tractions, and what would carry nothing; None for nothing."""
        if self.friction.remembers:
            return "the memory of the friction", "friction without memory"
        if self.layer is not None and self.layer.plasticity is not None:
            return "the plastic slip of the layer", "a layer that does not yield"
        return None

    def _by_prisms(self, key: Key) -> dict[str, Course]:
        """What operators are made for: the moduli of prisms."""
        prisms = self.field.prisms()
        if prisms is None or key.prisms is None:
            return {}
        first = key.prisms[1]

        def terms(modulus: str) -> Iterator[Weighted]:
            for weight, body, both in prisms.varied(modulus):
                changed = key._replace(prisms=(both.core, first))
                if modulus.startswith("lower"):
                    changed = changed._replace(lower=body.elastic)
                else:
                    changed = changed._replace(upper=body.elastic)
                yield weight, _mtb_rs.PatchOperators(*changed)

        return {modulus: partial(terms, modulus) for modulus in prisms.moduli}

    def _compound(self, motion: Motion) -> Compound:
        """What is layered or creeps under the contact."""
        velocity = velocity_of(self.field, motion)
        return Compound(self.field.lower, self.field.upper, velocity, self.field.spacing)

    def _by_compound(self, motion: Motion, key: Key) -> dict[str, Course]:
        """What operators are made for: the constants of bodies that are layered or creep, and the velocity of
        the contact over the latter."""
        compound = self._compound(motion)

        def terms(weighted: Callable[[], list[tuple[float, dict[str, Core]]]]) -> Iterator[Weighted]:
            for weight, bodies in weighted():
                yield weight, _mtb_rs.PatchOperators(*key.of(bodies))

        named = compound.numbers | {name: by for name, by in compound.motions.items() if name == "velocity"}
        return {name: partial(terms, weighted) for name, weighted in named.items()}

    def _courses(self, motion: Motion, key: Key) -> dict[str, Course]:
        """What operators are made for, besides the bodies."""

        compound = self._compound(motion)

        def turns(name: str) -> bool:
            """Whether what creeps is rolled over in another direction."""
            return name == "angle" and compound.velocity is not None

        def terms(name: str, size: float, step: Callable[[float], Pair]) -> Iterator[Weighted]:
            for place, weight in zip(*AHEAD, strict=True):
                bodies: dict[str, Core] = {}
                if turns(name):
                    bodies = compound.under(compound.turned(place * size))
                changed = key._replace(step=step(place * size)).of(bodies)
                yield weight / size, _mtb_rs.PatchOperators(*changed)

        if self._carries:
            return {}
        courses = motion.courses(self.field)
        if self._is_along_rows:
            courses = {name: course for name, course in courses.items() if name != "angle"}
        return {
            name: partial(terms, name, min(size, TURN) if turns(name) else size, step)
            for name, (size, step) in courses.items()
        }

    @property
    def _is_along_rows(self) -> bool:
        """Whether rolling is known along the rows of cells alone."""
        return self.field.inclination is not None or self.field.is_in_rows

    def _refused(self, motion: Motion) -> dict[str, str]:
        """What could be asked for as well, and why there is no derivative by it."""
        sides = {"lower": self.field.lower, "upper": self.field.upper}
        refused = refused_constants({side: body for side, body in sides.items() if are_layered(body)})
        if self.pressed is None:
            reason = (
                "the pressure is given, and follows from it by the normal contact: derive by 'pressure' and "
                "take the derivatives of solve_normal, or solve with coupling='full'"
            )
            refused |= dict.fromkeys(("gap", "normal_force", "approach"), reason)
        if self._is_along_rows and "angle" in motion.courses(self.field):
            rows = "a body is a Prism" if self.field.is_in_rows else "the surface is inclined"
            refused["angle"] = f"{rows}, and rolling is known along the rows of cells alone"
        if self._carries:
            carried, other = self._carries
            reason = f"{carried} is carried along by the step, which is not derived: {other} has this"
            refused |= dict.fromkeys(motion.courses(self.field), f"{reason} derivative")
        return refused


def _plastic_share(result: TangentialResult) -> Array:
    """Share (ny, nx) of the slip that is plastic."""
    assert result.plastic_slip is not None
    plastic, surfaces = (np.hypot(*part) for part in (result.plastic_slip, result.slip))
    heat, whole = np.asarray(result.dissipation), plastic + surfaces
    share = np.divide(plastic, whole, where=whole > 0.0, out=np.zeros_like(whole))
    # cells that stick turn work into heat one step behind
    is_alone = (whole == 0.0) & (heat != 0.0)
    plastic_heat = np.asarray(result.plastic_dissipation)
    return np.asarray(np.divide(plastic_heat, heat, where=is_alone, out=share))


def _margin(result: TangentialResult, layer: InterfaceLayer | PlasticLayer | None) -> Margin:
    """How near points are to slipping, sticking or yielding; those in contact are given."""
    size, slip = np.hypot(*result.traction[:2]), np.hypot(*result.slip)
    bound = friction = result.friction_coefficient * result.pressure
    sticks, slips = result.status == 1, result.status >= 2
    yielding = None
    if result.plastic_slip is not None:
        assert layer is not None
        assert layer.plasticity is not None
        stress = layer.plasticity[0] + layer.plasticity[1] * np.asarray(result.accumulated_plastic_slip)
        bound = np.minimum(friction, stress)
        plastic = np.hypot(*result.plastic_slip)
        # what has hardened up to friction slips with the rest
        slip = np.where(result.status == 3, plastic, slip)
        is_apart = slips & ((result.status == 3) | (plastic == 0.0))
        apart = np.abs(friction - stress)[is_apart] / bound.max()
        yielding = float(apart.min(initial=math.inf))
    return Margin(
        parting=math.inf,
        touching=math.inf,
        slipping=float((bound - size)[sticks].min() / bound.max()) if sticks.any() else math.inf,
        sticking=float(slip[slips].min() / slip.max()) if slips.any() else math.inf,
        yielding=yielding,
    )


def gap_by_traction(field: PressureField, motion: Motion) -> GapByTraction:
    """How tractions on the cells of a field open the gap in a motion."""
    ny, nx = field.pressure.shape
    bodies = {"lower": field.lower, "upper": field.upper}
    elastic = {side: body for side, body in bodies.items() if body is not None}
    return GapByTraction(
        (ny, nx), field.spacing, elastic, velocity_of(field, motion), field.inclination, field.prisms()
    )
