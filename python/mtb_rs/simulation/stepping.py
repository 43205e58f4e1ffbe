# SPDX-License-Identifier: MIT OR Apache-2.0
"""A sliding contact in a simulation: condensed once, solved once a step."""

from __future__ import annotations

import contextlib
import os
import warnings
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass, field, replace
from functools import cached_property, partial
from typing import Any, ClassVar, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .. import _mtb_rs
from ..base.check import choice, flag, number, positive, reals, refuse_outside, warn
from ..base.errors import ConvergenceError, ResultantError
from ..base.files import check_target, made_of, write_bytes
from ..base.owning import own, owning, solved
from ..base.plain import plain
from ..base.questions import ask
from ..base.stored import stored
from ..base.words import Model
from ..bodies.simple import FieldBody, Simple
from ..contact.problem import ContactProblem, Kept
from ..contact.solve import JAMMED, NOT_CARRIED, Body, displaced, of_magnet, overload
from ..contact.tangent import Change, Points, PullField
from ..friction.fields import LARGEST_FRICTION, VelocityTable, as_form
from ..friction.magnet import Magnet, points_of_poles
from ..geometry.contact_points import Patch
from ..results.derivatives import ChainedBack, Functional, Tangent
from ..results.fields import Field as ResultField
from ..results.fields import fields_of
from ..results.plausible import SMALL, height_of, of_deformation, width_of
from ..results.result import Pictured
from ..results.stressed import Loads, Stressed, loaded_patches
from ..scenes.derived import (
    Deformed,
    SideName,
    by_hardness,
    by_layer,
    moduli_of,
    refused_moduli,
)
from ..scenes.posed import PosedScene
from . import fmu
from .coordinates import (
    POSE,
    Coordinates,
    along_x_and_y,
    coordinates_of,
    free_of,
    motion_of,
    without_inertia,
)
from .reduced import ReducedBody, reduced
from .stability import Elastic, Faces, Stability, stability_of
from .step_derivatives import Shared, StepDerived
from .stuck_derivatives import StuckDerived
from .vibrating import VibratingContact, VibratingState

Array = NDArray[np.float64]
Shape = tuple[int, ...]

BODIES: tuple[Body, ...] = ("upper", "lower")
#: Share of other components up to which a free motion is one along or about an axis.
NEARLY = 0.2
#: Why bodies under a magnet do not vibrate.
NO_PULL = (
    "magnetic_pressure is a Magnet: bodies that vibrate take a pull that the gap does not change. Prepare "
    "the scene with the magnetic_pressure of a result, or with a number"
)


@stored
@solved
@dataclass(frozen=True)
@plain
class StepState:
    """State after a step, from which the next one starts: plain arrays that can be kept, copied and pickled.

    Attributes
    ----------
    pressure : (n,) [Pa]
        Unknowns of the contact points.
    motion : (m,)
        Amplitudes of the motions found from balance.
    magnetic_pressure : (n,) [Pa] or None
        Pull of a :class:`mtb_rs.Magnet`, from which that of the next step is found.
    traction, rigid_displacement : (2, n) [Pa], [m] or None
        What a step with a `shift` starts from: unknowns along both tangents of the contact points on the
        lower body, and displacement of the lower body less that of the upper one there by their rigid
        motions and by the loads on them. The displacement is None of a contact from a file, which knows no
        such steps.
    """

    pressure: Array
    motion: Array
    magnetic_pressure: Array | None = None
    traction: Array | None = None
    rigid_displacement: Array | None = None


@stored
@solved
@dataclass(frozen=True)
@plain
class StepReport:
    """Report on a step.

    Attributes
    ----------
    status : str
    iterations : int
        Active sets.
    refactored : bool
        Whether the influence matrix of the points in contact was factorised anew.
    products : int
        Products with the influence matrix, and solves with its factors.
    fell_back : bool
        Whether the general solver, which does not use the last step, had to take over.
    residual : float [-]
        Relative complementarity residual.
    unstable : bool
        Whether more load gives less contact here.
    magnet : Mapping[str, Any]
        Of a :class:`mtb_rs.Magnet`, as in :class:`mtb_rs.Report`; otherwise empty.
    """

    status: str
    iterations: int
    refactored: bool
    products: int
    fell_back: bool
    residual: float
    unstable: bool
    magnet: Mapping[str, Any] = field(default_factory=dict)

    def as_dict(self) -> dict[str, Any]:
        """The report as plain Python data, ready for JSON."""
        return asdict(self)


@stored
@owning
@dataclass(frozen=True)
@plain
class StepGrid:
    """Where a step acts, and on which bodies.

    Attributes
    ----------
    points : (3, n) [m]
    area : (n,) [m2]
    patches : tuple of Patch
    lower, upper : HalfSpace, Layered, Prism, Rigid or None
        None of those of finite elements, and of a contact from a file.
    elastic : tuple of str
        Which bodies, "lower" or "upper", have finite elements.
    """

    points: Array
    area: Array
    patches: tuple[Patch, ...]
    lower: FieldBody | None = None
    upper: FieldBody | None = None
    elastic: tuple[str, ...] = ()


@stored
@solved
@dataclass(frozen=True)
@plain
class StepResult(ChainedBack, Stressed, Pictured):
    """Contact load of a step. It can draw pressure, gap and status.

    Attributes
    ----------
    force, moment : (3,) [N], [N m]
        Load of the contact on the lower body, with the moment about `reference_point`. The opposite acts on
        the upper body.
    reference_point : (3,) [m]
    friction_power : float [W]
        Heat of sliding, >= 0: friction times velocity, without the power of the pressures. Of a step with a
        `shift`, `friction_work` over `dt`, and NaN without a `dt`.
    friction_work : float or None [J]
        `friction_power` times `dt`. Of a step with a `shift`, friction times slip: what the step turns into
        heat.
    gap : (n,) [m]
        Deformed gap, >= 0.
    state : StepState
        For the next step.
    report : StepReport
    magnetic_pressure : (n,) [Pa] or None
        With which a :class:`mtb_rs.Magnet` pulls at the gaps of the step; None for all other loads.
    plastic_indentation : (n,) or None [m]
        Depth to which one body has flowed; None where none has, as without a hardness.
    slip : (3, n) or None [m]
        Slip of the upper body over the lower one in the step, common frame: zero where points stick, and at
        open points how far they passed each other. None of a step without a `shift`.

    Points that slide have the status 2, also where a layer yields.
    """

    # of a shift in no known time
    _unbounded = ("friction_power",)
    force: Array
    moment: Array
    reference_point: Array
    friction_power: float
    friction_work: float | None
    gap: Array
    state: StepState
    report: StepReport
    _grid: StepGrid = field(repr=False)
    _core: _mtb_rs.PreparedContact | None = field(repr=False, compare=False)
    _pressure: Array | None = field(default=None, repr=False, compare=False)
    magnetic_pressure: Array | None = None
    plastic_indentation: Array | None = None
    _traction: Array | None = field(default=None, repr=False, compare=False)
    slip: Array | None = None
    _status: NDArray[np.int8] | None = field(default=None, repr=False, compare=False)
    _drawn: ClassVar[tuple[str, ...]] = ("points", "area", "pressure", "gap", "status")
    _summed: ClassVar[tuple[str, ...]] = ("force", "moment", "reference_point", "friction_power")

    @property
    def points(self) -> Array:  # type: ignore[override]
        """Contact points (3, n) [m]."""
        return self._grid.points

    @property
    def area(self) -> Array:  # type: ignore[override]
        """Area (n,) [m2] of each contact point."""
        return self._grid.area

    @property
    def patches(self) -> tuple[Patch, ...]:  # type: ignore[override]
        """Regular grids of the points; none of a contact from a file, or where a face does not fill them."""
        return self._grid.patches

    @property
    def status(self) -> NDArray[np.int8]:  # type: ignore[override]
        """0 open, 1 stick, 2 slip (n,); no point sticks in a step without a `shift`."""
        if self._status is not None:
            return self._status
        return np.where(self.state.pressure > 0.0, 2, 0).astype(np.int8)

    @property
    def pressure(self) -> Array:  # type: ignore[override]
        """Mean pressure (n,) [Pa] over each contact point."""
        if self._core is None:
            return np.asarray(self._pressure)
        return self._core.mean_pressure(self.state.pressure)

    @property
    def traction(self) -> Array:
        """Mean friction (3, n) [Pa] over each contact point, on the lower body, common frame."""
        if self._traction is None:
            raise ValueError(
                "this step was saved by an earlier version, which kept no traction: take it again"
            )
        if self._core is None:
            return self._traction
        geometry = self._core.geometry
        own = np.asarray(self._traction).reshape(2, -1)
        mean = geometry.mean_tractions(np.concatenate([own, self.state.pressure[None]]))
        return np.asarray(np.einsum("kcn,kn->cn", geometry.tangents, mean[:2]))

    def fields(self) -> dict[str, ResultField]:
        """Its fields over the contact points, by name: values with unit and label."""
        pull = {} if self.magnetic_pressure is None else {"magnetic_pressure": self.magnetic_pressure}
        flowed = {} if self.plastic_indentation is None else {"plastic_indentation": self.plastic_indentation}
        rubbed = {} if self._traction is None else {"traction": self.traction}
        slipped = {} if self.slip is None else {"slip": self.slip}
        return super().fields() | fields_of({"slip": "m"}, **rubbed, **slipped, **pull, **flowed)

    def facts(self) -> dict[str, Any]:
        """What else its `summary.json` holds: the report."""
        return {"report": self.report.as_dict()}

    def _loads(self) -> Loads:
        grid = self._grid
        grids = loaded_patches(grid.patches, grid.points, grid.area, self.pressure, self.traction)
        return Loads(grids, grid.lower, grid.upper, elastic=grid.elastic)

    def _kept_traction(self) -> Array | None:
        return None if self._traction is None else self.traction

    def _kept(self) -> StepResult:
        # without the matrices
        return replace(self, _core=None, _pressure=self.pressure, _traction=self._kept_traction())

    def _tangent(self) -> Tangent:
        return self._source().tangent

    def _functionals(self) -> Mapping[str, Callable[[], Functional]]:
        return self._source().functionals(self.area, lambda: self.pressure)

    def _source(self) -> StepDerived | StuckDerived:
        # not a field: what is put together from parts of it was not solved
        source: StepDerived | StuckDerived | None = vars(self).get("_derived")
        if self.slip is not None and source is None and self._core is not None:
            raise ValueError(
                "this step was given a shift, and started from rest: of steps with a shift those have "
                "derivatives that start from a step before them. A first step with a shift of (0, 0) is such "
                "a one; otherwise take differences of steps from one state"
            )
        if source is None:
            raise ValueError(
                "this step was loaded, copied or is not solved: only a step that its contact has solved has "
                "derivatives"
            )
        return source

    def follows(self, earlier: Any) -> bool:
        """Whether this step, with a shift, started from another one."""
        source = vars(self).get("_derived")
        if not (isinstance(source, StuckDerived) and isinstance(earlier, StepResult)):
            return False
        state = earlier.state
        if state.traction is None or state.rigid_displacement is None:
            return False
        unknowns = np.concatenate([np.reshape(state.traction, (2, -1)), state.pressure[None]])
        return source.started_from(unknowns, state.rigid_displacement)

    def _carried(self, by: Mapping[str, Array]) -> dict[str, Array]:
        left = np.concatenate([by["state.traction"], by["state.pressure"][:, None]], axis=1)
        return {"unknowns": left, "rigid_displacement": by["state.rigid_displacement"]}

    def __getstate__(self) -> dict[str, Any]:
        # without the matrices
        kept = {name: value for name, value in self.__dict__.items() if name != "_derived"}
        return kept | {"_core": None, "_pressure": self.pressure, "_traction": self._kept_traction()}

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__dict__.update(state)
        own(self)


class PreparedContact:
    """A sliding contact that is ready for a simulation.

    :meth:`mtb_rs.Scene.prepare` makes it, or :meth:`load` reads it. Each `step` starts from the memory of the
    last one (active points, factors). The memory changes only the time that a step takes.

    Wherever the sliding state is unique, the pressures of a step equal those of ``scene.solve`` to 1e-9 of
    the largest one if `solve` uses dense matrices. Half-spaces on more than 2000 points of a flat grid are
    solved by convolutions, which are iterated until a residual of 1e-9 is reached; the pressures of a step
    then equal them to 1e-6 of the largest one. Forces agree to 1e-9 in both cases.

    One object is for one contact in one simulation; :meth:`copy` makes another one, without memory, that
    shares the matrices. A pickle and a deep copy go on from the last step as the original does. Calls from
    several threads wait for each other.
    """

    def __init__(self, core: _mtb_rs.PreparedContact, source: Source | None = None) -> None:
        self._core = core
        self._source = source
        known = ((), None, None, ()) if source is None else (source.patches, *source.bodies)
        self._grid = StepGrid(core.points, core.area, *known)
        self._asked: set[str] = set()
        self._shared = Shared(core)

    def __repr__(self) -> str:
        free = ", ".join(self.motions) or "nothing"
        return f"<PreparedContact: {self.area.size} points, free: {free}>"

    @property
    def points(self) -> Array:
        """Contact points (3, n) [m]."""
        return self._core.points

    @property
    def normal(self) -> Array:
        """Unit normals (3, n) of the lower body, pointing to the upper one."""
        return self._core.normal

    @property
    def area(self) -> Array:
        """Area (n,) [m2] of each contact point."""
        return self._core.area

    @property
    def motions(self) -> list[str]:
        """Motions of the upper body found from balance, for example "left z"."""
        return self._core.motions

    @property
    def reference_point(self) -> Array:
        """The point that moments and rotations are about [m]."""
        return np.array(self._core.reference_point)

    def step(
        self,
        pose: Sequence[float] | Array | None = None,
        velocity: float | Sequence[float] | None = None,
        dt: float | None = None,
        magnetic_pressure: Any = None,
        state: StepState | None = None,
        *,
        shift: float | Sequence[float] | None = None,
        gap: ArrayLike | None = None,
        friction: ArrayLike | None = None,
        diagonal: ArrayLike | None = None,
    ) -> StepResult:
        """Solves the contact at one instant.

        Without a `shift` all points in contact slide in the direction of the velocity. With a `shift` they
        stick or slip, and remember their tractions from step to step.

        Parameters
        ----------
        pose : (x, y, z, roll, pitch, yaw) [m], [rad]
            Rigid displacement of the upper body from its position in the scene: rotations about the fixed x,
            then y, then z axis through `reference_point`, then the translation. A component that is NaN
            (None: all of them) is found from balance if the scene leaves the motion free, and is zero
            otherwise. Of an elastic body it is the mean motion, weighted with its volume; what holds a given
            component that its supports leave free is spread over the body as its inertia is. Where a
            rotation is free, a body turns about the middle of its contact, and a given z is that of this
            middle, of each pole its own, wherever `reference_point` is. Gaps change by the displacement along
            the normals, which must be small against the radii of the surfaces: rotations above 0.5 rad are
            refused, and so are a z deeper than the contact is long, and an x or y of more than half of the
            contact along a face that is not plane there.
        velocity : float or (vx, vy) [m/s]
            Velocity of the upper body over the lower one. A number is the velocity along the scene's sliding
            direction, negative backwards. It gives the direction of friction, and tables are evaluated at its
            magnitude. None: the scene's own velocity; if it states none, and neither friction nor pull depend
            on it, forwards at 1 m/s, which `friction_power` is of then. At rest friction has no direction,
            which is an error unless the contact was prepared with a `standstill_speed`.
        dt : float [s]
            Length of the step, for `friction_work`.
        magnetic_pressure : float [Pa], or as for scenes
            Pressure in place of the scene's. A number costs nothing; a field costs a product with the
            compliance. With a :class:`mtb_rs.Magnet` the pull follows the gaps of the step, pose and `gap`
            included; it is found from that of the last step, so that bodies which have touched keep
            together until the magnet cannot hold them.
        state : StepState
            State to start from in place of the memory.
        shift : float or (dx, dy) [m]
            Displacement of the upper body over the lower one since the last step, in addition to the change
            of its pose, which shifts points as well. A number is along the scene's sliding direction,
            negative backwards; 0.0 lets the body stand. Points then stick, or slip and rub, from the
            tractions that the last step left. Pressure and friction are solved together. Tables are taken at
            the velocity, if it is None at the shift over `dt`. Where all points slip steadily, the step
            equals one without a shift. The first step starts from the bodies pressed together without
            friction. The shift opens and closes no gaps; the pose does. A pull that differs from that of the
            last step moves elastic bodies along their faces, which is part of the slip.
        gap : (n,) [m]
            Added to the gap at this step: a joint of the rail, wear. From -1000 m to 1000 m. Here and below,
            values at all points of the grids of the scene's results are taken as well, where the face of a
            body leaves some of them free.
        friction : float or (n,) [-]
            Friction coefficients in place of those of the scene, at this step. Below a `standstill_speed`
            they fade as those do.
        diagonal : float or (n,) [m/Pa]
            Diagonal compliance at this step: how far a pressure opens its own point besides what it does to
            the bodies, as a layer or a step of wear do. Below zero the point closes under its own pressure,
            by less than the bodies give way there.

        Raises
        ------
        ValueError
            If something cannot be as given, or the contact reaches the edge of a grid beyond which the
            bodies go on. A shift is refused with a hardness, a rough layer or an interface layer that yields,
            and by a contact from a file that was not saved for shifts.
        ResultantError
            If no pressure carries the load. With a shift, if the body tips over: its free motions turn it by
            more than 0.5 rad, or no state is found, and none carries the load where all points slide.
        ConvergenceError
            If the body wedges: no sliding state exists. The last state is its `result`. With a shift, if no
            state of stick and slip is found.
        """
        place = np.full(6, np.nan) if pose is None else pose_of(pose)
        if dt is not None:
            positive("dt", dt, "s")
        moved = None if shift is None else self._along("shift", shift, "m")
        if shift is not None and np.any(shift) and self._source is not None:
            scene = self._source.scene
            if scene.sliding_direction is None and as_form(scene.friction).number != 0.0:
                raise ValueError(
                    "shift is given, and the scene has sliding_direction=None, without friction: give the "
                    "scene a direction, or friction=0"
                )
        is_shifted = velocity is None and moved is not None and dt is not None
        if is_shifted:
            assert moved is not None
            assert dt is not None
            velocity = (moved[0] / dt, moved[1] / dt)
        sliding = self._velocity(velocity)
        uniform, given, magnet = None, None, None
        speed = float(np.hypot(*sliding))
        if magnetic_pressure is None:
            pass
        elif as_form(magnetic_pressure).follows_gap:
            form, places = as_form(magnetic_pressure), self._poles
            if places is None:
                raise ValueError(
                    "magnetic_pressure is a Magnet, but this contact is of a file that was written without "
                    "one: it takes a number [Pa]"
                )
            circuit = form.circuit_over(*places)
            assert circuit is not None
            magnet = circuit, form.factor(speed), form.factor_slope(speed)
        elif isinstance(magnetic_pressure, (int, float, np.integer, np.floating)):
            uniform = number("magnetic_pressure", magnetic_pressure, "Pa")
        elif self._source is None:
            raise ValueError(
                "magnetic_pressure is a field: a contact from a file takes a number [Pa], or a Magnet where "
                "it was written with one"
            )
        else:
            given = self._source.loads(magnetic_pressure, speed)
        n = self.area.size
        kept = None if self._source is None else self._source.problem.kept
        added = None if gap is None else _at_points("gap", gap, n, "m", (-LARGEST_GAP, LARGEST_GAP), kept)
        most = 0.0, LARGEST_FRICTION
        rubbing = None if friction is None else _at_points("friction", friction, n, "1", most, kept)
        own = None if diagonal is None else _at_points("diagonal", diagonal, n, "m/Pa", None, kept)
        if state is not None:
            # once all else that is given has been taken
            self._check_state(state)
            stuck = None
            if state.traction is not None and state.rigid_displacement is not None:
                stuck = state.traction, state.rigid_displacement
            elif moved is not None:
                raise ValueError(
                    "state holds no tractions, from which a step with a shift starts: it is of an earlier "
                    "version, or of a contact from a file"
                )
            self._core.resume(state.pressure, state.motion, state.magnetic_pressure, stuck)
        out, tangent, linear = self._core.step(
            place.tolist(), sliding, uniform, given, added, rubbing, own, magnet, moved
        )
        power, work = out.friction_power, None if dt is None else out.friction_power * dt
        slip = None
        if moved is not None:
            work = None if out.slipped is None else out.slipped[1]
            power = np.nan if dt is None or work is None else work / dt
            if out.slipped is not None:
                slip = np.einsum("kcn,kn->cn", self._core.geometry.tangents[:2], out.slipped[0])
        attraction = None if out.settled is None else out.settled.pull
        status = out.status
        pull = self._pull(magnetic_pressure, uniform) if attraction is None else float(self.area @ attraction)
        if status == "solved" and np.isnan(place).all() and -out.force[2] > JAMMED * pull > 0.0:
            status = (
                f"solved, but the body has jammed: the contact force is {-out.force[2]:.3g} N, "
                f"{-out.force[2] / pull:.3g} times the load"
            )
            warn(f"The step is {status}.")
        result = StepResult(
            force=out.force,
            moment=out.moment,
            reference_point=self.reference_point,
            friction_power=power,
            friction_work=work,
            gap=np.maximum(out.gap, 0.0),
            state=StepState(out.pressure, out.motion, attraction, out.traction, out.rigid),
            report=StepReport(
                status=status,
                iterations=out.iterations,
                refactored=out.factorisations > 0,
                products=out.products,
                fell_back=out.fell_back,
                # where nothing balances the load there is no state, and nothing of it is solved
                residual=1.0 if out.status in NOT_CARRIED else out.residual,
                unstable=out.unstable,
                magnet=of_magnet(out.settled, self.area),
            ),
            magnetic_pressure=attraction,
            _grid=self._grid,
            _core=self._core,
            # what sticks and slips does not flow, and is closed but for rounding
            plastic_indentation=-np.minimum(out.gap, 0.0) if moved is None and out.gap.min() < 0.0 else None,
            _traction=out.traction,
            slip=slip,
            _status=None if moved is None else out.points,
        )
        if linear is not None and out.slipped is not None:
            layer, flexible = self._layer(own is not None)
            derived = StuckDerived(
                self._shared,
                linear,
                np.concatenate([np.reshape(out.traction, (2, -1)), out.pressure[None]]),
                out.gap,
                np.reshape(out.slipped[0], (2, -1)),
                out.friction,
                out.points,
                dt,
                is_shifted,
                layer,
                flexible,
                self._magnet_numbers(magnetic_pressure, speed),
                self._parted_by_moduli(out, magnetic_pressure, speed),
                None if self._source is None else self._source.without_moduli,
            )
            object.__setattr__(result, "_derived", derived)
        if tangent is not None:
            source = self._derived(tangent, out, sliding, magnetic_pressure, rubbing, own is not None)
            object.__setattr__(result, "_derived", source)
        if out.status == "unreachable" and moved is not None and out.slipped is not None:
            raise ResultantError(
                f"the body tips over under the shift ({moved[0]:g}, {moved[1]:g}) m: the resultant of the "
                "load and of the friction that turns it lies outside what the contact can carry",
                result,
            )
        if out.status == "iteration limit" and moved is not None and out.slipped is not None:
            raise ConvergenceError(
                f"no state of stick and slip was found for the shift ({moved[0]:g}, {moved[1]:g}) m, also "
                "not over states between the last step and this one: take shorter shifts, or smaller "
                "changes of pull and friction",
                result,
            )
        if out.status != "solved":
            hard = None if self._source is None else self._source.problem.hardness
            raise _failure(out, result, uniform, hard, self.area)
        if self._source is not None and moved is None:
            forwards = float(np.dot(sliding, self._core.sliding_direction)) >= 0.0
            traction = (out.friction if forwards else -out.friction) * out.pressure
            pulled = magnetic_pressure if attraction is None else attraction
            self._source.ask_once(self._asked, out.pressure, traction, pulled, speed)
        return result

    def stability(
        self,
        mass: ArrayLike,
        stiffness: ArrayLike = 0.0,
        damping: ArrayLike = 0.0,
        *,
        free: Sequence[str] = POSE,
        pose: Sequence[float] | Array | None = None,
        velocity: float | Sequence[float] | None = None,
        largest_friction: float = 1.0,
        density: float | Mapping[str, float] | None = None,
        modes: int = 12,
    ) -> Stability:
        """Vibrations of the upper body on springs about steady sliding: do they grow?

        The contact enters with its exact tangent by pose and velocity, which friction makes unsymmetric: two
        vibrations may join and grow though friction does not fall with the velocity (mode coupling
        [Hoffmann2002]). Friction that falls with the velocity counts as well, and so does the velocity across
        it, which turns the friction: at each contact point by the velocity at which the faces slide there, as
        the body rotates and as the faces are moved along each other by pressure and friction.

        Parameters
        ----------
        mass : (m,) or (m, m)
            Inertia of the upper body about `reference_point`, in kg and kg m2, over the m components that
            are `free`: the diagonal, or all of the matrix.
        stiffness, damping : (m,) or (m, m)
            What holds the body, besides the contact; 0: nothing does. Forces over displacements [N/m] and
            velocities [N s/m], moments over rotations [N m].
        free : of "x", "y", "z", "roll", "pitch", "yaw"
            Components that move; all others are held.
        pose : (6,) [m], [rad] or None
            About which; components that are NaN, or None, are found from balance as in :meth:`step`. Where
            several bodies are found from balance, they then move as one.
        velocity : float or (vx, vy) [m/s]
            As in :meth:`step`; not None where the scene has none.
        largest_friction : float
            Up to this coefficient, or that of the contact if it is larger, the smallest unstable one is
            looked for.
        density : float or {"upper": float, "lower": float} [kg/m3]
            Of elastic bodies, the upper one if it is a number. They vibrate besides, by their lowest `modes`;
            what these carry is taken off the compliance. None: bodies give way without inertia.
        modes : int
            Vibrations that are kept of each elastic body.

        Returns
        -------
        Stability

        Notes
        -----
        Loads other than that of the contact are dead ones: they stay the same, but for the pull of a
        :class:`mtb_rs.Magnet`. It works on the body as well, grows as the body comes nearer, and so takes
        from the stiffness; a body that it holds in the air is stable, or snaps on. Left out are the changes
        of the arms of these loads, of the order of the load times the displacement.

        Raises
        ------
        ValueError
            If something cannot be as given, the velocity is zero, or a :class:`mtb_rs.Magnet` pulls bodies
            with a `density`; of a contact from a file that was not saved for shifts, which does not hold how
            the faces move along each other.
        ResultantError, ConvergenceError
            As :meth:`step`, at the coefficient of the contact.
        """
        known = self._core.velocity
        if density is not None and self.magnet is not None:
            raise ValueError(NO_PULL)
        if velocity is None and known is None:
            raise ValueError(
                "velocity is missing, and the scene states none: the damping of lateral motions follows "
                "from it"
            )
        place = np.full(6, np.nan) if pose is None else pose_of(pose)
        sliding, names = self._velocity(velocity), free_of(free)
        bodies: Elastic | Faces
        if density is not None and any(sliding):
            vibrating = self._bodies_of(density, modes)
            moving = coordinates_of(self._places, names, mass, stiffness, damping, vibrating)
            bodies = self._elastic(moving, vibrating, sliding)
        else:
            x, y, z = self._core.reference_point
            # what a traction does by the pose is its load
            loads = self._core.geometry.weights_of_resultants((x, y, z))[:, :2] / self.area
            bodies = Faces(-loads, self._core.motion_shapes[:, :2], self._core.slid_by)
        moved_by = partial(motion_of, self._places, self._core.motion_shapes)
        searching = self.copy()
        # deformations on the way are none that anything has
        searching._asked = set(BODIES)
        return stability_of(
            self.copy(),
            searching,
            sliding,
            place,
            names,
            mass,
            stiffness,
            damping,
            largest_friction,
            bodies,
            moved_by,
        )

    def vibrating(
        self,
        dt: float,
        mass: ArrayLike | None = None,
        stiffness: ArrayLike = 0.0,
        damping: ArrayLike = 0.0,
        *,
        free: Sequence[str] | None = None,
        pose: Sequence[float] | Array | None = None,
        velocity: float | Sequence[float] | None = None,
        density: float | Mapping[str, float] | None = None,
        modes: int = 12,
    ) -> VibratingContact:
        """The contact with the inertia of its bodies, step by step in time: they stick, slip and vibrate.

        What moves is the upper body as a whole on springs, by the components of its pose that are `free`,
        elastic bodies by their lowest vibrations, or both. Where no component is free, elastic bodies move by
        the rigid motions that their supports leave, as well. The contact points have no inertia of their own:
        at each instant they are a static contact, with what the vibrations carry taken off the compliance.

        The bodies begin in balance: sliding steadily at the velocity, or, at a velocity of 0, pressed
        together without friction. All loads of the scene stay what they are.

        Parameters
        ----------
        dt : float [s]
            Length of the steps, a twentieth of the shortest period of interest or less. Where friction falls
            with the speed, by a slope s [s/m], a third of m / (s N) or less as well, the time in which it
            feeds a mass m under the force N: longer steps make limit cycles too small. Where points stick and
            slip in turn, a quarter as well of the period of the mass on the stiffness of the contact along
            the surface, which is far shorter: coarser steps leave it ringing, and cycles come out up to twice
            as large. Steps ask where they find that, with the period.
        mass : (m,) or (m, m), optional
            Inertia of all that moves with the pose, as in :meth:`stability`.
        stiffness, damping : (m,) or (m, m)
            What holds it, as in :meth:`stability`.
        free : of "x", "y", "z", "roll", "pitch", "yaw"
            Components of the pose that move; None: all of them if a mass is given, otherwise none.
        pose : (6,) [m], [rad] or None
            At the beginning; components that are NaN, or None, are found from balance as in :meth:`step`.
        velocity : float or (vx, vy) [m/s]
            At the beginning, of the upper body over the lower one, and in all steps without a shift of their
            own.
        density : float or {"upper": float, "lower": float} [kg/m3]
            Of elastic bodies that vibrate, the upper one if it is a number.
        modes : int
            Vibrations that are kept of each elastic body.

        Returns
        -------
        VibratingContact

        Notes
        -----
        Steps follow the trapezoidal rule, which is of second order and neither damps nor feeds vibrations.
        The friction goes along the slip of the whole step, an error of first order where that turns. Loads
        other than that of the contact are dead ones.

        Raises
        ------
        ValueError
            If something cannot be as given, or nothing moves; with a hardness, a rough layer or an interface
            layer that yields, a :class:`mtb_rs.Magnet`, and of a contact from a file.
        ResultantError, ConvergenceError
            As :meth:`step`.
        """
        positive("dt", dt, "s")
        source = self._source
        if source is None:
            raise ValueError("a contact from a file holds no bodies that could vibrate: prepare its scene")
        problem = source.problem
        if source.follows_gap:
            raise ValueError(NO_PULL)
        _refuse_bounds(problem)
        if free is None:
            free = () if mass is None else POSE
        if free and mass is None:
            raise ValueError(f"mass is missing: that of {', '.join(free_of(free))} is needed")
        bodies = {} if density is None else self._bodies_of(density, modes)
        names = free_of(free) if free else []
        moving = coordinates_of(
            self._places, names, 0.0 if mass is None else mass, stiffness, damping, bodies
        )
        if not np.allclose(moving.stiffness, moving.stiffness.T, rtol=1e-9, atol=0.0):
            raise ValueError(
                "stiffness is not symmetric: springs have an energy, of which these steps keep account"
            )
        place = np.full(6, np.nan) if pose is None else pose_of(pose)
        known = 0.0 if source.velocity is None and velocity is None else velocity
        sliding = self._velocity(known)
        stands = not any(sliding)
        begun = self.copy().step(place, sliding, shift=0.0 if stands else None)
        assert begun.state.traction is not None
        traction = np.concatenate([begun.state.traction.ravel(), begun.state.pressure])
        speeds = _speeds(source.scene.friction) or [0.0]
        friction = np.array([source.friction(v) for v in speeds])
        made = (
            without_inertia(problem, self._softened, bodies),
            self.area,
            speeds,
            np.ascontiguousarray(friction),
            traction,
            begun.gap,
            moving.mass,
            moving.damping,
            moving.stiffness,
            np.ascontiguousarray(moving.shapes),
            float(dt),
        )
        k = len(moving.names)
        start = VibratingState(
            begun.state.traction, begun.state.pressure, np.zeros(k), np.zeros(k), np.zeros(k)
        )
        geometry = self._core.geometry
        x, y, z = self._core.reference_point
        forwards = self._core.sliding_direction
        return VibratingContact(
            made,
            moving,
            start,
            (forwards[0], forwards[1]),
            sliding,
            geometry.tangents,
            geometry.weights_of_resultants((x, y, z)),
            _edges_of(problem.windows),
        )

    @property
    def _softened(self) -> float:
        """What softens the tangents [m/Pa]."""
        layer = None if self._source is None else self._source.scene.layer
        return 0.0 if layer is None else float(layer.flexibility)

    @property
    def _places(self) -> _Places:
        normal, tangents = self.normal, self._core.geometry.tangents
        averages = None if self._source is None else self._source.problem.averages
        if averages is not None:
            tangents, normal = averages.frames[:2], averages.frames[2]
        return _Places(self.points, normal, self.reference_point, tangents)

    def _bodies_of(self, density: Any, modes: int) -> dict[str, ReducedBody]:
        """Elastic bodies that vibrate, by "upper" and "lower"."""
        given = density if isinstance(density, Mapping) else {"upper": density}
        named = {choice("density of", name, Body): rho for name, rho in given.items()}
        return {body: self.reduced(rho, modes, body) for body, rho in named.items()}

    def _elastic(
        self, moving: Coordinates, bodies: Mapping[str, ReducedBody], velocity: tuple[float, float]
    ) -> Elastic:
        assert self._source is not None
        problem = self._source.problem
        _refuse_bounds(problem)
        along = np.einsum("kcn,c->kn", self._core.geometry.tangents, [*velocity, 0.0])
        # coefficients are those of a number, at each point in the direction of its tangents
        size = np.hypot(*along)
        return Elastic(moving, without_inertia(problem, self._softened, bodies), along / size, size)

    def reduced(self, density: float, modes: int = 12, body: Body = "upper") -> ReducedBody:
        """A body of the contact in motion: its lowest vibrations, and what else gives way at its points.

        It is what a program of multibody dynamics needs besides :meth:`step`: loads on the contact points in,
        their displacements out. What the kept vibrations carry is taken off the compliance, so that nothing
        is counted twice.

        Parameters
        ----------
        density : float [kg/m3]
            Of steel, some 7850.
        modes : int
            Vibrations that are kept of each elastic body.
        body : "upper" or "lower"
            Which side. Several bodies, such as two poles, are one reduced body, whose parts do not see each
            other.

        Returns
        -------
        ReducedBody

        Raises
        ------
        ValueError
            If something cannot be as given, or this body has no finite elements in the model that was
            prepared; of a contact from a file, which holds no finite elements.
        """
        if self._source is None:
            raise ValueError("a contact from a file holds no finite elements: prepare it from its scene")
        problem, name = self._source.problem, choice("body", body, Body)
        return reduced(problem.upper if name == "upper" else problem.lower, name, density, modes)

    def _layer(
        self, has_diagonal: bool
    ) -> tuple[tuple[Shape, Callable[[Array], Change]] | None, tuple[str, ...]]:
        """Numbers of a layer with what they change, and inputs of points that give way to their pressure."""
        flexible: tuple[str, ...] = ("diagonal",) if has_diagonal else ()
        if self._source is None:
            return None, flexible
        if self._source.problem.layer is not None:
            flexible += ("normal_layer_field",)
        return self._source.by_layer, flexible

    def _parted_by_moduli(
        self, out: _mtb_rs.Outcome, pull: Any, speed: float
    ) -> dict[str, Callable[[Array, bool], Array]]:
        """Displacement of the bodies from each other by a unit of each modulus; see :class:`StuckDerived`."""
        source = self._source
        if source is None:
            return {}

        def parted(side: SideName, name: str, unknowns: Array, is_pulled: bool) -> Array:
            acting = np.zeros(out.pressure.size)
            if is_pulled:
                acting = source.pull(pull, speed) if out.settled is None else out.settled.pull
            return source.deformed(unknowns, acting).parted(side, name)

        return {f"{side}.{name}": partial(parted, side, name) for side, name in source.moduli}

    def _derived(
        self,
        tangent: _mtb_rs.Tangent,
        out: _mtb_rs.Outcome,
        velocity: tuple[float, float],
        pull: Any,
        rubbing: Array | None,
        has_diagonal: bool,
    ) -> StepDerived:
        by_field = pull_slope = None
        source, pressure, speed = self._source, out.pressure, float(np.hypot(*velocity))
        layer, flexible = self._layer(has_diagonal)
        numbers = self._magnet_numbers(pull, speed)
        if source is not None and numbers is None and source.is_pulled(pull):
            by_field, pull_slope = source.by_pull_field, source.pull_slope(pull, speed)

        def sheared(fade: float) -> Array | None:
            if source is None or source.problem.shear is None:
                return None
            own = source.friction(speed) if rubbing is None else rubbing
            return source.problem.sheared(fade * own, pressure)

        by_moduli: dict[str, Callable[[], Change]] = {}
        if source is not None:
            unknowns = np.concatenate([np.reshape(out.traction, (2, -1)), pressure[None]])

            def by_modulus(side: SideName, name: str) -> Change:
                acting = source.pull(pull, speed) if out.settled is None else out.settled.pull
                return source.deformed(unknowns, acting).by(side, name)

            by_moduli = {f"{side}.{name}": partial(by_modulus, side, name) for side, name in source.moduli}

        return StepDerived(
            self._shared,
            tangent,
            pressure,
            out.gap,
            out.traction,
            velocity,
            by_field,
            pull_slope,
            layer,
            flexible,
            None if source is None else source.by_hardness,
            sheared,
            numbers,
            None if source is None else source.problem.rough,
            by_moduli,
            None if source is None else source.without_moduli,
        )

    def _magnet_numbers(self, pull: Any, speed: float) -> dict[str, Array] | None:
        """Numbers of the magnet of a step, where no pull is given the scene's own; None without a magnet."""
        spec = self.magnet if pull is None else pull
        if spec is None or not as_form(spec).follows_gap:
            return None
        return as_form(spec).magnet_numbers(speed)

    @cached_property
    def magnet(self) -> Magnet | None:
        """The magnet of its scene, also of a contact from a file; None where no pull follows the gap."""
        if self._source is not None:
            return self._source.scene.magnetic_pressure if self._source.follows_gap else None
        parts = self._core.magnet
        if parts is None:
            return None
        _, curve, numbers, (yoke, armature), (speeds, factors) = parts
        ampere_turns, non_magnetic_gap, iron_share, pole_length, leakage = numbers
        factor = None if (speeds, factors) == ([0.0], [1.0]) else VelocityTable(speeds, factors)
        return Magnet(
            ampere_turns, non_magnetic_gap, curve, iron_share, pole_length, yoke, armature, leakage, factor
        )

    @property
    def _poles(self) -> tuple[Array, list[int]] | None:
        """Areas (n,) [m2] of the points, and points of each pole; None of a file that does not tell."""
        if self._source is not None:
            return self._source.poles
        parts = self._core.magnet
        return None if parts is None else (self.area, parts[0])

    def _pull(self, magnetic_pressure: Any, uniform: float | None) -> float:
        """What presses the bodies together [N]; 0 where it is not known."""
        if uniform is not None:
            return uniform * float(self.area.sum())
        if magnetic_pressure is not None or self._source is None:
            return 0.0
        return abs(float(self._source.problem.pressing[2]))

    def copy(self) -> PreparedContact:
        """The same contact without memory; the matrices are shared."""
        other = PreparedContact(self._core.copy(), self._source)
        other._asked = self._asked
        return other

    def save(self, path: str | os.PathLike[str], *, shift: bool = False) -> None:
        """Writes the contact for :meth:`load` and for the C interface: all matrices, with a checksum.

        Parameters
        ----------
        path : str or path object
            For example "shoe.mtbc".
        shift : bool
            Whether what is read takes steps with a `shift`, and :meth:`stability`, as well. The file then
            holds 72 bytes more for each pair of points: 12 MB at 400 points. Under a :class:`mtb_rs.Magnet`
            it holds another 8 bytes, or 24 with `shift`.

        Raises
        ------
        ValueError
            If the path is a directory. With `shift`, if the contact is of a file without it.
        OSError
            If nothing can be written there.
        """
        write_bytes(path, self._bytes(flag("shift", shift)))

    def save_fmu(
        self,
        path: str | os.PathLike[str],
        library: str | os.PathLike[str] | None = None,
        pose: Mapping[str, float] | None = None,
        velocity: float | Sequence[float] | None = None,
        magnetic_pressure: float | None = None,
        fmi: int = 2,
        *,
        shift: bool = False,
        ampere_turns: float | None = None,
    ) -> None:
        """Writes the contact as a functional mock-up unit for co-simulation, which needs no Python.

        Inputs are `velocity.x` and `velocity.y`, those of `pose.x` to `pose.yaw` that `pose` names, and
        `magnetic_pressure` or `ampere_turns` if given. All other components are found from balance, or stay
        as in the scene. Outputs are `force.x` to `moment.z` (on the lower body, about `reference_point`),
        `friction_power`, `peak_pressure` (of the mean over a point), and `attraction` of a
        :class:`mtb_rs.Magnet`, if it acts. By FMI 3 `velocity` (2), `force` (3) and `moment` (3) are
        arrays, and so are `pose.translation` and `pose.rotation` (3) where `pose` names all three.

        Parameters
        ----------
        path : str or path object
            For example "shoe.fmu".
        library : str or path object, optional
            The compiled `mtb_fmu` of this version, which the unit contains. Released wheels bring their own;
            the source distribution has none. For it, in a clone, and for another system,
            ``cargo build --release -p mtb-fmu`` in a clone makes one. The unit runs
            on systems like the one for which the library was built.
        pose : {"x", "y", "z", "roll", "pitch", "yaw": float} [m], [rad]
            First values of the components of the pose that are inputs.
        velocity, magnetic_pressure
            First values, as in :meth:`step`.
        fmi : int
            Version of the standard: 2 (FMI 2.0) or 3 (FMI 3.0).
        shift : bool
            False: all points slide at each step. True: points stick or slip and keep their tractions from
            step to step, as of :meth:`step` with a `shift`, which is `velocity` times the duration of the
            step. The bodies are first pressed together without friction; `friction_power` is the mean over
            the step. States that an importing program keeps and goes back to hold the tractions.
        ampere_turns : float [A]
            First value for the coil of the :class:`mtb_rs.Magnet` of the scene; 0: switched off.

        Raises
        ------
        ValueError
            If an argument is wrong, or the library is of another version.
        ConvergenceError
            If there is no sliding state at the first values.
        OSError
            If nothing can be written there.
        """
        fmi = fmu.check_version(fmi)
        sliding = self._velocity(velocity)
        starts = {"velocity.x": sliding[0], "velocity.y": sliding[1]}
        place = np.full(6, np.nan)
        for component, value in fmu.first_pose(pose).items():
            starts[f"pose.{component}"] = place[POSE.index(component)] = value
        if magnetic_pressure is not None:
            starts["magnetic_pressure"] = number("magnetic_pressure", magnetic_pressure, "Pa")
        turns = None if ampere_turns is None else number("ampere_turns", ampere_turns, "A")
        if turns is not None:
            if self.magnet is None or magnetic_pressure is not None:
                taken = "a magnetic_pressure takes the place of the magnet"
                why = "the scene has no Magnet" if self.magnet is None else taken
                raise ValueError(f"ampere_turns is {turns:g} A, but {why}")
            if turns < 0.0:
                raise ValueError(f"ampere_turns is {turns:g} A: a number from 0 on is needed")
            starts["ampere_turns"] = turns
        target = check_target(path)
        # what cannot be solved shows here, not in the importing program
        sticks = flag("shift", shift)
        first = (0.0, 0.0) if sticks else None
        pull: Any = magnetic_pressure
        if turns is not None:
            assert self.magnet is not None
            # without a current it does not pull
            pull = replace(self.magnet, ampere_turns=turns) if turns > 0.0 else 0.0
        self.copy().step(place, sliding, magnetic_pressure=pull, shift=first)
        outputs = {number for quantity in fmu.SLIDING.outputs for number in quantity.numbers}
        if self.magnet is None or magnetic_pressure is not None:
            outputs.discard("attraction")
        contact, about = self._bytes(sticks), self.reference_point
        unit = fmu.packed(fmu.SLIDING, contact, library, target.stem, about, starts, outputs, fmi)
        write_bytes(target, unit)

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> PreparedContact:
        """Reads what :meth:`save` wrote.

        Raises
        ------
        ValueError
            If the file cannot be read, or holds no prepared contact, or not all of one.
        """
        return cls(made_of(path, "prepared contact", _mtb_rs.PreparedContact.from_bytes))

    def __reduce__(self) -> tuple[Any, ...]:
        # finite elements stay behind: the copy is as one read from a file, with the memory of the last step
        return _from_bytes, (self._bytes(self._core.takes_shifts), self._core.memory())

    def _bytes(self, shift: bool) -> bytes:
        return self._core.to_bytes(shift)

    def _check_state(self, state: Any) -> None:
        if not isinstance(state, StepState):
            raise ValueError(f"state is {state!r}: a StepState, the `state` of a step, is needed")
        n = self.area.size
        for name, values, shape in (("pressure", state.pressure, (n,)), ("motion", state.motion, None)):
            array = values if isinstance(values, np.ndarray) else np.zeros(())
            if array.dtype != np.float64 or array.ndim != 1 or (shape and array.shape != shape):
                found = getattr(values, "dtype", type(values).__name__)
                raise ValueError(
                    f"state.{name} is {found} of shape {np.shape(values)}: an array of float64, "
                    f"{shape or '(m,)'}, is needed"
                )

        for name, given in (
            ("traction", state.traction),
            ("rigid_displacement", state.rigid_displacement),
        ):
            if given is None:
                continue
            if np.shape(given) != (2, n) or not np.isfinite(given).all():
                raise ValueError(
                    f"state.{name} has shape {np.shape(given)}: {(2, n)} finite numbers, as of a step, are "
                    "needed"
                )

    def _velocity(self, velocity: float | Sequence[float] | None) -> tuple[float, float]:
        if velocity is None:
            known = self._core.velocity
            if known is None and self._core.is_tabulated:
                raise ValueError(
                    "velocity is missing: friction or magnetic pressure is a table over it; with a shift, dt "
                    "gives it as well"
                )
            velocity = 1.0 if known is None else known
        return self._along("velocity", velocity, "m/s")

    def _along(self, name: str, given: Any, unit: str) -> tuple[float, float]:
        """Components along x and y; a number is along the scene's sliding direction."""
        return along_x_and_y(name, given, unit, self._core.sliding_direction)


def _refuse_bounds(problem: ContactProblem) -> None:
    """ValueError for what makes the contact of vibrating bodies nonlinear beside contact and friction."""
    if problem.hardness is not None or problem.rough is not None or problem.shear is not None:
        raise ValueError(
            "a hardness, a rough layer or a layer that yields is given, but bodies that vibrate take "
            "none into account"
        )


def _edges_of(windows: Sequence[Patch]) -> NDArray[np.intp]:
    """Numbers of the points at the edges of grids beyond which the bodies go on."""
    found = [np.zeros(0, dtype=np.intp)]
    for grid in windows:
        numbers = grid.start + np.arange(grid.nx * grid.ny).reshape(grid.ny, grid.nx)
        inner = np.zeros(numbers.shape, dtype=bool)
        inner[1:-1, 1:-1] = True
        found.append(numbers[~inner])
    return np.concatenate(found)


class _Places(NamedTuple):
    """Contact points, their axes and the point that poses turn about."""

    points: Array
    normal: Array
    reference_point: Array
    tangents: Array


#: Gaps [m] beyond this drown those that decide which points touch in rounding: at 1 km the largest pressure
#: is off by 1e-7, at 1e30 m by any factor.
LARGEST_GAP = 1e3


def _at_points(
    name: str,
    given: ArrayLike,
    n: int,
    unit: str,
    within: tuple[float, float] | None = None,
    kept: Kept | None = None,
) -> Array:
    """A number or values (n,) at the contact points, or at all points of the grids of which these are `kept`;
    `within` these ends, if they are given."""
    values = reals(name, given, unit)
    if kept is not None and values.size == kept.nodes.gap.size:
        values = values.reshape(-1)[kept.numbers]
    if values.shape not in ((), (n,)):
        raise ValueError(
            f"{name} has shape {values.shape}: a number or ({n},), one for each contact point, is needed"
        )
    values = np.array(np.broadcast_to(values, (n,)))
    if within is not None:
        refuse_outside(name, values, within, unit)
    return values


def pose_of(pose: Any) -> Array:
    """A pose (6,) as numbers that are finite or NaN, each at most as large as any input may be."""
    try:
        given = np.asarray(pose)
        is_real = given.dtype.kind in "iuf"
    except ValueError:
        is_real = False
    if not is_real or given.shape != (6,):
        raise ValueError(f"pose is {pose!r}: six real numbers (x, y, z, roll, pitch, yaw) are needed")
    place = given.astype(float)
    for name, value in zip(POSE, place, strict=True):
        if not np.isnan(value):
            number(f"pose, {name},", float(value), "rad" if name in POSE[3:] else "m")
    return place


def _from_bytes(data: bytes, memory: Array | None = None) -> PreparedContact:
    core = _mtb_rs.PreparedContact.from_bytes(data)
    if memory is not None:
        core.recall(memory)
    return PreparedContact(core)


def _failure(
    out: _mtb_rs.Outcome,
    result: StepResult,
    magnetic_pressure: float | None,
    hardness: Array | None,
    area: Array,
) -> ConvergenceError:
    mu = float(out.friction.max(initial=0.0))
    if out.status == "unreachable":
        apart = ""
        if magnetic_pressure is not None and magnetic_pressure < 0.0:
            apart = (
                f". magnetic_pressure is {magnetic_pressure:g} Pa, and a negative one pushes the bodies apart"
            )
        elif mu > 0.0:
            apart = (
                ". If friction tips a body over, less friction or narrower cells may carry the load: "
                "Scene.solve under this load says which"
            )
        return ResultantError(
            "the resultant of the load lies outside what the contact can carry: no pressure "
            f">= 0 on the {out.friction.size} contact points balances it{apart}",
            result,
        )
    if out.status == "overloaded":
        return ResultantError(overload(hardness, area), result)
    if out.status == "no solution":
        return ConvergenceError(
            f"no sliding equilibrium: the body wedges. The friction coefficient is {mu:g}; the report of "
            "Scene.solve says up to which one sliding is certain",
            result,
        )
    return ConvergenceError(f"not converged (residual {out.residual:.1e})", result)


@dataclass(frozen=True)
@plain
class Source:
    """Where a prepared contact came from: what new loads are made with.

    Attributes
    ----------
    softness : Mapping of "upper" and "lower" to float [m/Pa]
        Largest displacement of a body that deforms, by a pressure of 1 Pa on all points.
    """

    scene: PosedScene
    problem: ContactProblem
    softness: Mapping[str, float]

    @property
    def bodies(self) -> tuple[Simple | None, Simple | None, tuple[str, ...]]:
        """Lower and upper body, None of those with finite elements, and which these are."""
        return self.scene.bodies_of(self.problem)

    @property
    def patches(self) -> tuple[Patch, ...]:
        """Regular grids of the contact points; none where a body leaves some of their nodes free."""
        return self.problem.patches if self.problem.kept is None else ()

    @property
    def velocity(self) -> float | None:
        """The scene's own velocity [m/s]."""
        return self.scene.velocity

    def _width(self, pressure: Array) -> float:
        problem = self.problem
        area = float(problem.area.max())
        return width_of(problem.points.points, area, pressure > 0.0, problem.patches)

    def friction(self, speed: float) -> Array:
        """Coefficients (n,) of the scene at a speed [m/s]."""
        problem = self.problem
        return np.asarray(self.scene.friction_at(problem.points, problem.patches, problem.kept, speed))

    def pull(self, magnetic_pressure: Any, speed: float | None) -> Array:
        """Attraction (n,) [Pa] by a magnetic pressure, None for the scene's, at a speed [m/s]."""
        problem = self.problem
        spec = self.scene.magnetic_pressure if magnetic_pressure is None else magnetic_pressure
        if spec is None:
            return np.zeros(problem.n)
        if isinstance(spec, np.ndarray) and spec.shape == (problem.n,):
            # at the contact points themselves
            return reals("magnetic_pressure", spec, "Pa")
        return self.scene.pull_at(
            problem.points, problem.patches, problem.kept, magnetic_pressure=spec, velocity=speed
        )

    def pull_slope(self, magnetic_pressure: Any, speed: float) -> Array | None:
        """Change (n,) [Pa s/m] with the speed of a magnetic pressure that was given to a step.

        Tables are linear between two of their velocities; at one of them it is the slope below. None where
        it does not change; that of the scene is known to the core.
        """
        if magnetic_pressure is None or not (speeds := _speeds(magnetic_pressure)):
            return None
        upper = max(1, int(np.searchsorted(speeds, speed)))
        if speed == 0.0 or upper == len(speeds):
            return None
        there, here = (self.pull(magnetic_pressure, v) for v in (speeds[upper], speeds[upper - 1]))
        return np.asarray((there - here) / (speeds[upper] - speeds[upper - 1]))

    def may_deform(self, name: str, pressure: Array) -> bool:
        """Whether a body is so soft that a closer look at its displacement is worth a product."""
        side = self.problem.upper if name == "upper" else self.problem.lower
        mean = float(pressure @ self.problem.area) / float(self.problem.area.sum())
        if mean <= self._harmless[name]:
            return False
        uniform = np.array([[4.0 * mean * self.softness.get(name, 0.0)], [0.0], [0.0]])
        return bool(of_deformation(name, uniform, side.state, self._width(pressure)))

    @cached_property
    def _harmless(self) -> dict[str, float]:
        """Mean pressure [Pa] up to which a body deforms by little, be the contact a single cell."""
        found: dict[str, float] = {}
        for name in BODIES:
            side = self.problem.upper if name == "upper" else self.problem.lower
            height = height_of(side.state)
            size = float(np.sqrt(self.problem.area.max())) if height is None else height
            softness = self.softness.get(name, 0.0)
            found[name] = SMALL * size / (4.0 * softness) if softness > 0.0 else np.inf
        return found

    def ask_once(
        self, asked: set[str], pressure: Array, traction: Array, magnetic_pressure: Any, speed: float
    ) -> None:
        """Warns of each body once that deforms by more than a small share of its size.

        Parameters
        ----------
        asked : set of str
            Bodies that were warned of.
        pressure, traction : (n,) [Pa]
            Traction on the lower body along the sliding direction of each point.
        magnetic_pressure : as for scenes, or None
            In place of the scene's.
        speed : float [m/s]
        """
        problem = self.problem
        for name in BODIES:
            if name in asked or not self.may_deform(name, pressure):
                continue
            side = problem.upper if name == "upper" else problem.lower
            is_pulled = name == "upper" or self.scene.attraction == "both"
            pull = self.pull(magnetic_pressure, speed) if is_pulled else np.zeros(problem.n)
            unknowns = np.concatenate([traction * problem.direction, pressure[None]])
            moved = displaced(problem, name, unknowns, np.zeros(len(side.motions)), pull)
            if side.includes_motion:
                moved = moved - moved.mean(axis=1, keepdims=True)
            questions = of_deformation(name, moved, side.state, self._width(pressure))
            if questions:
                asked.add(name)
                ask(questions)

    @property
    def follows_gap(self) -> bool:
        """Whether the scene is pulled by a magnet that follows the gap."""
        return self.problem.attracting is not None

    @property
    def poles(self) -> tuple[Array, list[int]]:
        """Areas (n,) [m2] of the points, and how many belong to each pole."""
        problem = self.problem
        kept = None if problem.kept is None else problem.kept.numbers
        return problem.area, points_of_poles(problem.area, problem.patches, kept)

    def is_pulled(self, magnetic_pressure: Any) -> bool:
        """Whether a magnetic pressure acts, the scene's own where None is given."""
        return magnetic_pressure is not None or self.scene.magnetic_pressure is not None

    @property
    def by_layer(self) -> tuple[tuple[int, ...], Callable[[Array], Change]] | None:
        """Shape of the numbers that give the layer, and what they change at a pressure (n,) [Pa]."""
        return by_layer(self.scene, self.problem)

    @property
    def by_hardness(self) -> tuple[tuple[int, ...], Callable[[], Change]] | None:
        """Shape of the numbers that give the hardness, and what they change."""
        return by_hardness(self.scene, self.problem)

    def by_pull_field(self, points: Points, balanced: list[int]) -> PullField:
        """What a magnetic pressure at each point changes, of the motions that are found from balance."""
        return PullField(self.problem, self.scene.attraction, points, balanced)

    @cached_property
    def moduli(self) -> list[tuple[SideName, str]]:
        """Sides, and moduli by which the displacement of their bodies is known."""
        return moduli_of(self.scene, self.problem)

    @cached_property
    def without_moduli(self) -> dict[str, str]:
        """Moduli by which there are no derivatives, and why."""
        return refused_moduli(self.scene)

    def deformed(self, unknowns: Array, pull: Array) -> Deformed:
        """The bodies under tractions and pressures (3, n) [Pa] and an attraction (n,) [Pa]."""
        below = pull if self.scene.attraction == "both" else np.zeros_like(pull)

        def pose(scene: PosedScene) -> ContactProblem:
            # what there is to say of the scene was said when it was prepared
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")
                return at_some_speed(scene).problem(self.problem.model, may_halve=False)

        return Deformed(self.scene, pose, self.problem, unknowns, {"upper": pull, "lower": below})

    def loads(self, magnetic_pressure: Any, speed: float) -> _mtb_rs.Loading:
        """Gap before contact and generalised load on each motion under a magnetic pressure."""
        pull = self.pull(magnetic_pressure, speed)
        below = pull if self.scene.attraction == "both" else np.zeros_like(pull)
        return self.problem.loading_by(pull, below)


def prepare(
    scene: PosedScene, model: Model, reference_point: ArrayLike, standstill_speed: float | None
) -> PreparedContact:
    """Prepares the contact of a scene in one of its models; see :meth:`mtb_rs.Scene.prepare`."""
    if as_form(scene.friction).depends_on_pressure:
        raise ValueError("friction depends on the pressure: a step takes numbers, fields and tables")
    scene.shear(1, is_still=False)
    if standstill_speed is not None:
        positive("standstill_speed", standstill_speed, "m/s")
    origin = np.asarray(reference_point, dtype=float)
    if origin.shape != (3,) or not np.isfinite(origin).all():
        raise ValueError(f"reference_point is {reference_point!r}: three finite numbers [m] are needed")
    moving = at_some_speed(scene)
    problem = moving.problem(model, may_halve=False)
    one = np.concatenate([np.zeros((2, problem.n)), np.ones((1, problem.n))])
    softness = {
        name: float(np.sqrt((side.compliance.displacement(one) ** 2).sum(axis=0)).max())
        for name, side in (("upper", problem.upper), ("lower", problem.lower))
        if side.compliance is not None
    }
    source = Source(scene, problem, softness)
    magnetic, magnet = None, None
    pulled = [(True, problem.upper.is_pulled_at_face)]
    if scene.attraction == "both":
        pulled.append((False, problem.lower.is_pulled_at_face))
    speeds = _speeds(scene.magnetic_pressure) or [0.0]
    if problem.attracting is not None:
        form = as_form(scene.magnetic_pressure)
        magnet = problem.attracting.circuit, speeds, [form.factor(v) for v in speeds]
    elif scene.magnetic_pressure is not None:
        magnetic = speeds, np.array([source.pull(None, v) for v in speeds])
    friction_speed = _speeds(scene.friction) or [0.0]
    places = problem.points, problem.patches, problem.kept
    friction = np.array([scene.friction_at(*places, v) for v in friction_speed])
    direction = np.zeros(2)
    if scene.sliding_direction is None:
        friction[:] = 0.0
    else:
        direction = np.array(scene.sliding_direction) / np.hypot(*scene.sliding_direction)
    core = _mtb_rs.PreparedContact(
        problem.core,
        problem.loading_by(np.zeros(problem.n), np.zeros(problem.n)),
        _named(problem),
        friction_speed,
        np.ascontiguousarray(friction),
        pulled,
        magnetic,
        magnet,
        (float(direction[0]), float(direction[1])),
        (float(origin[0]), float(origin[1]), float(origin[2])),
        standstill_speed,
        None if scene.velocity is None else float(scene.velocity),
        0.0 if scene.layer is None else scene.layer.flexibility,
    )
    contact = PreparedContact(core, source)
    pressure = np.full(problem.n, contact._pull(None, None) / float(problem.area.sum()))
    if any(source.may_deform(name, pressure) for name in ("upper", "lower")):
        # a step under the scene's own load asks; where there is none, steps will say so
        with contextlib.suppress(ConvergenceError, ValueError):
            contact.copy().step(velocity=moving.velocity)
    return contact


def at_some_speed(scene: PosedScene) -> PosedScene:
    """The scene at a velocity that its tables cover, if it has tables and no velocity."""
    if scene.velocity is not None:
        return scene
    return scene.with_(velocity=next(iter(_speeds([scene.friction, scene.magnetic_pressure])), None))


def _named(problem: ContactProblem) -> list[tuple[str, int | None]]:
    """Name of each free motion, and the component of the pose that it is."""
    named: list[tuple[str, int | None]] = []
    for side in (problem.upper, problem.lower):
        for motion, mode in zip(side.motions, side.modes, strict=True):
            component = _component(mode)
            here = np.flatnonzero(np.any(problem.on_grid(motion) != 0.0, axis=0))
            at = [p.name for p in problem.patches if p.start <= here[0] < p.start + p.nx * p.ny]
            of = "" if side is problem.upper else " of the lower body"
            name = f"{at[0]} {'motion' if component is None else POSE[component]}{of}"
            named.append((name, component if side is problem.upper else None))
    return named


def _component(mode: Array) -> int | None:
    """The component of a pose whose place a rigid motion (9,) takes: rotations about any point count as
    rotations, and those about an axis that a yaw has turned a little as those about the axis."""
    shift, turn = np.abs(mode[:3]), np.abs(mode[3:6])
    part, first = (turn, 3) if turn.any() else (shift, 0)
    main = int(part.argmax())
    return first + main if np.delete(part, main).max() <= NEARLY * part[main] else None


def _speeds(spec: Any) -> list[float]:
    """Velocities [m/s] of all tables in `spec`, inside the range they have in common."""
    tables = list(as_form(spec).tables())
    if not tables:
        return []
    first, last = max(t.velocity[0] for t in tables), min(t.velocity[-1] for t in tables)
    return sorted({v for t in tables for v in t.velocity if first <= v <= last})
