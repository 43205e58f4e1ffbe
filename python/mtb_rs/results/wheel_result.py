# SPDX-License-Identifier: MIT OR Apache-2.0
"""Results of a step of wheels on rails."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from functools import partial
from typing import Any, ClassVar, Protocol

import numpy as np
from numpy.typing import NDArray

from ..base.check import positive
from ..base.owning import owning, solved
from ..base.plain import plain
from ..base.stored import stored
from ..base.told import Row, along, in_words, length
from ..base.words import Side
from ..bodies.conductor import Conductor, conducting_steel
from ..bodies.simple import Simple
from ..friction.wear_laws import Rubbing, WearLaw, depth_of_pass
from ..geometry.contact_points import Patch
from ..geometry.geometries import FLANGE
from .damage import Damaged, Rolled
from .derivatives import Chained, Functional, Gradient, Tangent, gradient_of
from .doors import pictures, png
from .fields import Field as ResultField
from .fields import totals_of
from .result import Drawn, Pictured
from .stressed import LoadedGrid, Loads, Stressed, loaded_grid
from .temperature import RollingTemperature, rolling_temperature

Array = NDArray[np.float64]

#: Rotations of a pose, in order.
POSE_TURNS = ("roll", "pitch", "yaw")
#: Slips of wheels are velocities.
SLIP_UNITS = {"slip": "m/s", "dissipation": "W/m^2"}


#: Origin of the frame of a patch and slope of its plane, pressure, coefficient of friction, creepages.
History = tuple[tuple[float, float, float], float, Array, Array, tuple[float, ...] | None]


@stored
@owning
@dataclass(frozen=True)
@plain
class WheelState:
    """State after a step, from which the next one starts: plain arrays that can be kept, copied and pickled.

    Attributes
    ----------
    depth : tuple of float
        Overlap [m] of the undeformed bodies that carries the force, one entry per unknown height.
    ratio : tuple of (side, first (x, y) cell, (2, ny, nx)) per patch
        Traction over pressure [-], in the frame of the patch.
    history : tuple of (position (3,), angle, pressure (ny, nx), coefficient (ny, nx), creepage (3,)) or None
        Per patch what a transient step rolls on from besides: the origin of the frame (x from the middle of
        the axle, y and z in the track) [m], the slope of its plane [rad], pressure [Pa] and coefficient of
        friction of the particles [-], creepages along x and across [-] and spin [1/m], all as of a left
        wheel, as `ratio` is; of conformal patches (x, 0, 0) and 0. Of a wheel that did not roll, and in
        states of earlier versions, the creepages are None or missing, and a step over several cells has those
        of its end all the way. Empty in states of versions before that.
    found : tuple of float or None
        What else was found, where a search of the next step begins: y of the pose [m], the creepage of the
        tape circle [-], displacements (y, z) of the left and of the right rail on springs [m]; zero where
        they were not found; then derivatives of the forces there.
    """

    depth: tuple[float, ...]
    ratio: tuple[tuple[str, tuple[int, int], Array], ...]
    history: tuple[History | None, ...] = ()
    found: tuple[float, ...] | None = None


#: Why there is no stress below a patch that follows the rail.
BELOW_CONFORMAL = (
    "the patch follows the rail (conformal=True), and stresses are known below planes only: prepare the "
    "wheels without conformal for them"
)


@stored
@solved
@dataclass(frozen=True)
@plain
class WheelPatch(Stressed, Damaged, Drawn):
    """A contact patch of a step; fields (ny, nx) in its own frame: x along the rail, y across, normal.

    Attributes
    ----------
    side : "left" or "right"
    position : (3,) [m]
        Origin of the frame, in the track.
    rotation : (3, 3)
        Columns: x, y and normal of the frame in the track; the normal points from the rail to the wheel.
    contact_angle : float [rad]
        Slope of the contact plane, > 0 where it rises to the field side (flange contact); of a conformal
        patch that of the plane it would have.
    rail_position, wheel_position : float [m]
        y of the origin in the profiles' own frames.
    x, y : (nx,), (ny,) [m]
        Grid lines; of conformal patches y is the way along the surface of the rail, from the origin.
    inclination : (ny,) or None [rad]
        Of conformal patches: the slope across the track at each row of the surface between rail and wheel,
        the mean of both, > 0 where it rises to larger y. Tractions across and pressures of a row act along
        and normal to it. None on a plane.
    row_position : (2, ny) or None [m]
        Of conformal patches: y and z of each row in the track.
    row_creepage : (3, ny) or None [-], [-], [1/m]
        Of conformal patches: creepages along and across each row and spin about its normal, as `creepage` at
        the origin. At x of a row the rigid slip is xi along it, and eta + phi x across.
    pressure : (ny, nx) [Pa]
    traction : (2, ny, nx) [Pa]
        On the rail.
    slip_velocity : (2, ny, nx) [m/s]
        Slip velocity of the wheel over the rail; zero where they stick.
    dissipation : (ny, nx) [W/m2]
        Work of friction that turns into heat: that of :class:`mtb_rs.TangentialResult` times the rolling
        speed. The mean traction of a particle over a step works on the slip, also at a column behind the
        trailing edge. Without spin its sum is `friction_power`; with spin the two differ by an error of first
        order in the cells.
    status : (ny, nx) int
        0 open, 1 stick, 2 slip.
    approach : float [m]
        Largest overlap of the undeformed bodies along the normal.
    creepage : (xi, eta, phi) [-], [-], [1/m]
        Rigid slip of the wheel over the rail at the origin, over the rolling speed. The velocity of the wheel
        is taken on its own undeformed surface, which there lies deeper than the rail's by `approach`. Of a
        wheel at rest in a transient step it is over the slip speed there.
    rolling_speed : float [m/s]
        Mean of the speeds at which the patch runs over rail and wheel; > 0 along x.
    normal_force : float [N]
    neglected : float [-]
        Share of the estimated contact area whose inclination against the contact plane is too large for it.
    friction_power : float [W]
        Heat of sliding: the power of the tractions on the rigid slip and, between unlike bodies, on the slip
        that the pressure causes. In steady rolling it is >= 0; the elastic energy is constant, so all of it
        turns into heat. Between like bodies it closes an energy balance of the wheelset, but for conformal
        patches, whose turned rows do work on each other: by 1 to 2 % between tread and flange.
        `dissipation` gives its distribution. The sum of traction times `slip_velocity` is smaller, by an
        error of first order in the cells. In a transient step it is the mean of the step, the sum of
        `dissipation`, because the elastic energy changes; where slip sets in or turns round in the step it
        may be too small, and below zero.
    lower, upper : HalfSpace, Rigid or None
        Rail and wheel; None of patches that were stored by an earlier version.
    """

    side: Side
    position: Array
    rotation: Array
    contact_angle: float
    rail_position: float
    wheel_position: float
    x: Array
    y: Array
    pressure: Array
    traction: Array
    slip_velocity: Array
    dissipation: Array
    status: NDArray[np.int8]
    approach: float
    creepage: Array
    rolling_speed: float
    normal_force: float
    neglected: float
    friction_power: float
    lower: Simple | None = None
    upper: Simple | None = None
    inclination: Array | None = None
    row_position: Array | None = None
    row_creepage: Array | None = None

    @property
    def _way(self) -> float:
        """Direction of rolling [rad]: along x or against it."""
        return 0.0 if self.rolling_speed >= 0.0 else float(np.pi)

    def _loads(self) -> Loads:
        return Loads((self.loaded(),), self.lower, self.upper, way=self._way)

    def loaded(self) -> LoadedGrid:
        """Its cells with their tractions, in its own frame; ValueError where that is no plane."""
        if self.inclination is not None:
            raise ValueError(BELOW_CONFORMAL)
        points = np.stack(np.meshgrid(self.x, self.y))
        return loaded_grid(points, self._sides, self.pressure, self.traction)

    @property
    def _sides(self) -> tuple[float, float]:
        """Of its cells [m]."""
        return float(self.x[1] - self.x[0]), float(self.y[1] - self.y[0])

    def _rolled(self) -> Rolled:
        x, y = np.meshgrid(self.x, self.y)
        moment = float((x * self.traction[1] - y * self.traction[0]).sum()) * self.area
        force = self.area * self.traction.sum(axis=(1, 2))
        xi, eta, phi = self.creepage
        rigid = np.zeros(2)
        if self.row_creepage is not None:
            # what rows slip besides what the creepages at the origin tell of a plane
            along, across, spin = self.row_creepage[..., None] - np.array([[[xi]], [[eta]], [[phi]]])
            slip = np.stack([along + phi * y, across + spin * x])
            rigid = self.area * (self.traction * slip).sum(axis=(1, 2))
        return Rolled(force, moment, self.normal_force, np.asarray(self.creepage), self.pressure, rigid)

    @property
    def on_flange(self) -> bool:
        """Whether the flange, or the root of it, is in contact here: its plane is steeper than 30 degrees."""
        return bool(self.contact_angle > FLANGE)

    @property
    def ground(self) -> str:
        """What the contact angle is of: a "plane", or the "surface" of a conformal patch in its middle."""
        return "plane" if self.inclination is None else "surface"

    @property
    def points(self) -> Array:
        """Cell centres (3, ny, nx) [m] in the track."""
        x, y = np.meshgrid(self.x, self.y)
        if self.row_position is not None:
            rows = np.broadcast_to(self.row_position[..., None], (2, *x.shape))
            return np.concatenate([(self.position[0] + x)[None], rows])
        flat = np.stack([x, y, np.zeros_like(x)])
        return np.asarray(self.position[:, None, None] + np.einsum("ij,jkl->ikl", self.rotation, flat))

    @property
    def frames(self) -> Array:
        """Directions (3, 3, ny) in the track: columns x, y and normal of each row, alike on a plane."""
        if self.inclination is None:
            return np.broadcast_to(self.rotation[..., None], (3, 3, self.y.size))
        one, none = np.ones(self.y.size), np.zeros(self.y.size)
        cos, sin = np.cos(self.inclination), np.sin(self.inclination)
        return np.array([[one, none, none], [none, cos, -sin], [none, sin, cos]])

    def in_track(self, own: Array) -> Array:
        """Vectors (2 or 3, ny, nx) along x, y and maybe the normal of the patch, in the track (3, ny, nx)."""
        return np.asarray(np.einsum("ijk,jkl->ikl", self.frames[:, : len(own)], own))

    @property
    def area(self) -> float:
        """Of each cell [m2]."""
        return float((self.x[1] - self.x[0]) * (self.y[1] - self.y[0]))

    @property
    def force(self) -> Array:
        """Force on the rail (3,) [N], in the track: creep force and normal force."""
        return np.asarray(self.load().sum(axis=(1, 2)))

    def temperature(
        self,
        lower: Conductor = conducting_steel,
        upper: Conductor = conducting_steel,
        bulk: tuple[float, float] = (0.0, 0.0),
    ) -> RollingTemperature:
        """Temperatures of rail and wheel in and behind this contact; see
        :meth:`mtb_rs.TangentialResult.temperature`.

        They are those of steady rolling with the heat that the step has now.

        Parameters
        ----------
        lower, upper : Conductor
            Rail and wheel.
        bulk : (float, float) [K]
            Temperatures with which rail and wheel come, over any common level.
        """
        drawn = self._picture()
        given = (drawn.points, drawn.area, drawn.pressure, drawn.status, self._sides, drawn.dissipation)
        if self.rolling_speed == 0.0:
            raise ValueError(
                "the contact stands still at this step: temperatures are those of a contact that rolls on"
            )
        angle = self._way
        bodies, creepage = (lower, upper), np.asarray(self.creepage)[:2]
        return rolling_temperature(*given, angle, abs(self.rolling_speed), bodies, bulk, creepage)

    def _picture(self) -> PatchPicture:
        x, y = np.meshgrid(self.x, self.y)
        return PatchPicture(
            points=np.stack([x, y]),
            area=np.full(x.shape, self.area),
            pressure=self.pressure,
            traction=self.traction,
            slip=self.slip_velocity,
            dissipation=self.dissipation,
            status=self.status,
            normal_force=self.normal_force,
            creepage=self.creepage,
            friction_power=self.friction_power,
            inclination=self.inclination,
        )

    def wear_depth(
        self, law: WearLaw | float | Callable[[Rubbing], Any], wheel_radius: float | None = None
    ) -> Array:
        """Depth (ny,) [m] that one pass wears off each line along x, as :meth:`TangentialResult.wear_depth`.

        The friction coefficient is traction over pressure where the wheel slips.
        """
        slips = self.status == 2
        if not slips.any() or self.rolling_speed == 0.0:
            return np.zeros(self.y.size)
        bound = np.hypot(*self.traction)
        own = np.where(slips, bound / np.where(slips, self.pressure, 1.0), 0.0)
        friction = np.where(slips, own, own[slips].mean())
        speed = abs(self.rolling_speed)
        depth = depth_of_pass(
            law,
            self.dissipation / speed,
            self.pressure,
            friction,
            np.hypot(*self.slip_velocity) / speed,
            speed,
            self.points,
            float(self.x[1] - self.x[0]),
        )
        if wheel_radius is None:
            return depth
        return depth / (2.0 * np.pi * positive("wheel_radius", wheel_radius, "m"))

    def facts(self) -> dict[str, Any]:
        """What else its `summary.json` holds: where the patch and its rows are, and how it moves."""
        names = ["side", "position", "contact_angle", "rail_position", "wheel_position", "approach"]
        names += ["rolling_speed", "neglected"]
        if self.inclination is not None:
            names += ["inclination", "row_position", "row_creepage"]
        return {name: getattr(self, name) for name in names}

    def load(self) -> Array:
        """Force on the rail at each cell (3, ny, nx) [N], in the track."""
        local = np.concatenate([self.traction, -self.pressure[None]])
        return np.asarray(self.area * self.in_track(local))


@solved
@dataclass(frozen=True)
@plain
class PatchPicture(Pictured):
    """A patch as pictures and files take it."""

    points: Array
    area: Array
    pressure: Array
    traction: Array
    slip: Array
    dissipation: Array
    status: NDArray[np.int8]
    normal_force: float
    creepage: Array
    friction_power: float
    inclination: Array | None = None
    _drawn: ClassVar[tuple[str, ...]] = (
        "points", "area", "pressure", "traction", "slip", "dissipation", "status",
    )  # fmt: skip
    _summed: ClassVar[tuple[str, ...]] = ("normal_force", "creepage", "friction_power")

    def _units(self) -> dict[str, str]:
        return SLIP_UNITS


@solved
@dataclass(frozen=True)
@plain
class StepPicture(Pictured):
    """All patches of a step as files take them: in rows, places and vectors in the track."""

    step: WheelStep
    points: Array
    area: Array
    normal: Array
    pressure: Array
    traction: Array
    slip: Array
    dissipation: Array
    status: NDArray[np.int8]
    patches: tuple[Patch, ...]

    _drawn: ClassVar[tuple[str, ...]] = (
        "points", "area", "normal", "pressure", "traction", "slip", "dissipation", "status",
    )  # fmt: skip

    def _units(self) -> dict[str, str]:
        return SLIP_UNITS

    def totals(self) -> dict[str, ResultField]:
        return self.step.totals()

    def facts(self) -> dict[str, Any]:
        return self.step.facts()

    def peak_x(self) -> None:
        return None

    def _draw(self, quantity: Any, kind: Any, options: dict[str, Any]) -> Any:
        return self.step._draw(quantity, kind, options)


def picture_of(step: WheelStep) -> StepPicture:
    """All patches of a step together."""
    patches: list[Patch] = []
    names: dict[str, int] = {}
    for patch in step.patches:
        name = f"{patch.side} {'flange' if patch.on_flange else 'wheel'}"
        names[name] = names.get(name, 0) + 1
        ny, nx = patch.pressure.shape
        patches.append(
            Patch(
                name if names[name] == 1 else f"{name} {names[name]}",
                patches[-1].start + patches[-1].nx * patches[-1].ny if patches else 0,
                nx,
                ny,
                (float(patch.x[1] - patch.x[0]), float(patch.y[1] - patch.y[0])),
                (float(patch.x[0]), float(patch.y[0])),
            )
        )

    def row(of: Callable[[WheelPatch], Array]) -> Array:
        parts = [of(patch) for patch in step.patches]
        return np.concatenate([part.reshape(*part.shape[:-2], -1) for part in parts], axis=-1)

    return StepPicture(
        step=step,
        points=row(lambda p: p.points),
        area=row(lambda p: np.full(p.pressure.shape, p.area)),
        normal=row(lambda p: np.broadcast_to(p.frames[:, 2, :, None], (3, *p.pressure.shape))),
        pressure=row(lambda p: p.pressure),
        traction=row(lambda p: p.in_track(p.traction)),
        slip=row(lambda p: p.in_track(p.slip_velocity)),
        dissipation=row(lambda p: p.dissipation),
        status=np.concatenate([p.status.ravel() for p in step.patches]),
        patches=tuple(patches),
    )


def _told_of(patch: WheelPatch, name: str) -> list[Row]:
    """A patch in words: what it carries, where it is, how it creeps."""
    creep = patch.area * patch.traction.sum(axis=(1, 2))
    xi, eta, phi = in_words(patch.creepage).split(", ")
    closed = np.count_nonzero(patch.status)
    share = np.count_nonzero(patch.status == 1) / closed if closed else 0.0
    carried = f"{1e-3 * patch.normal_force:.5g} kN, peak {1e-6 * patch.pressure.max():.5g} MPa"
    on_rail, on_wheel = length(patch.rail_position), length(patch.wheel_position)
    return [
        (name, f"{carried}, {patch.ground} at {np.degrees(patch.contact_angle):.1f} degrees"),
        ("  profiles touch", f"at y {on_rail} of the rail, {on_wheel} of the wheel"),
        ("  creep force", f"{creep[0]:.5g} N along, {creep[1]:.5g} N across"),
        ("  creepage", f"{float(xi):.5g} along, {float(eta):.5g} across, spin {float(phi):.5g} 1/m"),
        ("  sticks", f"{100.0 * share:.3g} % of the contact"),
    ]


@stored
@dataclass(frozen=True)
@plain
class WheelReport:
    """How a step went.

    Attributes
    ----------
    normal_solves : int
        Normal problems, of all patches and trials of the height.
    iterations : int
        Newton steps of the tangential problems, of all patches and trials of the height.
    status : str
        "solved", and in words where a flange is in contact, the wheels are lifted, or the height was found at
        a jump of the force.
    """

    normal_solves: int
    iterations: int
    status: str = "solved"


class HandedOn(Tangent, Protocol):
    """The linearised equations of a step, which changes of the step before act on."""

    def follows(self, earlier: Any) -> bool:
        """Whether the step rolled on from the state that another one has left, or from none."""

    def along(self, chain: Sequence[tuple[Any, Mapping[str, Array]]]) -> Mapping[str, Array]:
        """Gradients (k, *shape) by the inputs of this step of k sums over a chain that begins with it: the
        equations of each step, and the weights (k, ...) of its fields."""


@stored
@solved
@dataclass(frozen=True)
@plain
class WheelStep(Chained, Stressed, Drawn):
    """Contact load of a step.

    :meth:`fields` has the fields of all patches in rows (n,), with places and vectors (3, n) in the track.
    Maps and lines show all patches on one scale of colours and of length, each in its own frame: x along the
    rail. The view in space is of the patches of one wheel. :meth:`stress` is that below one
    patch, in its frame.

    Attributes
    ----------
    force, moment : (3,) [N], [N m]
        Load of all patches on the rails, in the track, with the moment about `reference_point`. The opposite
        acts on the wheelset. For the moment the forces act on the undeformed surface of the wheel, where its
        velocity is taken, so that their work on the wheelset is the heat, but for what conformal patches
        leave open (:class:`WheelPatch`), and for the pressure on planes that are not quite tangential to the
        motion of a wheel with yaw: up to 5 % of it on a flange at 10 mrad.
    vertical_force : dict of side to float [N]
        Downward force of each wheel on its rail, friction included.
    balance_error : float or None [-]
        Relative departure of the vertical force from the force for which the height was found. If roll was
        found too, it is the largest departure of a wheel; with a lateral force or a load of the axle it is
        the largest departure of all, over the vertical force. None if nothing was found. It is below 1e-8,
        except where a force that height or lateral position are found from jumps, because the contact plane
        turns there, and is within 0.1 % of the vertical force: the report then says so.
    reference_point : (3,) [m]
        Reference point on the wheelset, in its pose.
    pose : (6,)
        The pose, with the components that were found from balance.
    velocity : (6,) [m/s], [rad/s]
        The velocity, with the rotation about the axle that was found from its load.
    rail_displacement : dict of side to (y, z) [m]
        What each rail has moved by, on its springs and as it was given.
    patches : tuple of WheelPatch
        Contact patches; a wheel that is lifted has none.
    friction_power : float [W]
        Heat of sliding of all patches.
    friction_work : float or None [J]
        `friction_power` times `dt`.
    state : WheelState
        For the next step.
    """

    force: Array
    moment: Array
    vertical_force: dict[str, float]
    balance_error: float | None
    reference_point: Array
    pose: Array
    velocity: Array
    rail_displacement: dict[str, Array]
    patches: tuple[WheelPatch, ...]
    friction_power: float
    friction_work: float | None
    state: WheelState
    report: WheelReport

    def _pressures(self) -> Array:
        return np.concatenate([np.zeros(0), *(patch.pressure.ravel() for patch in self.patches)])

    def _tangent(self) -> Tangent:
        return self._linear()

    def _linear(self) -> HandedOn:
        # no field: what was put together or loaded was not solved
        made: HandedOn | None = vars(self).get("_derived")
        if made is None:
            raise ValueError(
                "this step was loaded or copied: derivatives are those of one that PreparedWheels.step has "
                "just returned"
            )
        return made

    def follows(self, earlier: Any) -> bool:
        """Whether it rolled on from the state that another step has left, or is steady."""
        return isinstance(earlier, WheelStep) and bool(self._linear().follows(earlier._linear()))

    def _through(self, results: Sequence[Any], functionals: Sequence[Functional]) -> list[Gradient]:
        chain = [(step._linear(), own.weights) for step, own in zip(results, functionals, strict=True)]
        # what comes after the last number changes none
        adds = [any(np.any(w) for w in weights.values()) for _, weights in chain]
        end = max((k + 1 for k, is_added in enumerate(adds) if is_added), default=0)
        found = []
        for k, (functional, (tangent, _)) in enumerate(zip(functionals, chain, strict=True)):
            by = tangent.along(chain[k : max(end, k + 1)])
            found.append(gradient_of(functional, by, tangent))
        return found

    def _functionals(self) -> dict[str, Callable[[], Functional]]:
        def of_pressure(name: str, patch: WheelPatch) -> Array:
            area = np.full(patch.pressure.shape, patch.area)
            known = Functional.of_pressure(lambda: patch.pressure, area, patch.pressure > 0.0)
            return known[name]().weights["pressure"]

        def of_creep(patch: WheelPatch) -> Array:
            weights = np.eye(2)[..., None, None] * np.full(patch.pressure.shape, patch.area)
            return np.asarray(weights)

        def of_spin(patch: WheelPatch) -> Array:
            if patch.inclination is not None:
                raise ValueError(
                    "spin_moment of conformal patches has no derivatives: their cells stay on the rail as "
                    "the origin moves that it is about; the moment of the step has them"
                )
            x, y = np.meshgrid(patch.x, patch.y)
            return np.array([[-y, x]]) * patch.area

        return {
            **{
                name: partial(self._of_each, "pressure", (), partial(of_pressure, name))
                for name in ("normal_force", "peak_pressure", "mean_pressure")
            },
            "creep_force": partial(self._of_each, "traction", (2,), of_creep),
            "spin_moment": partial(self._of_each, "traction", (), of_spin),
        }

    def _of_each(
        self, field: str, shape: tuple[int, ...], weigh: Callable[[WheelPatch], Array]
    ) -> Functional:
        """Numbers of each patch by weights (numbers, ..., ny, nx) of its field."""
        components = () if field == "pressure" else (2,)
        ends = np.cumsum([0, *(patch.pressure.size for patch in self.patches)])
        rows = [np.zeros((0, *components, ends[-1]))]
        for patch, start, end in zip(self.patches, ends, ends[1:], strict=False):
            own = weigh(patch)
            row = np.zeros((len(own), *components, ends[-1]))
            row[..., start:end] = own.reshape(*row.shape[:-1], -1)
            rows.append(row)
        return Functional((len(self.patches), *shape), {field: np.concatenate(rows)})

    def __getstate__(self) -> dict[str, Any]:
        return {name: value for name, value in self.__dict__.items() if name != "_derived"}

    @property
    def blank(self) -> str:
        """Why it has no picture of its contact points; "" where it has one."""
        return "" if self.patches else "the wheels are lifted: there is no patch to draw"

    def _picture(self) -> StepPicture:
        if self.blank:
            raise ValueError(self.blank)
        return picture_of(self)

    def _loads(self) -> Loads:
        if not self.patches:
            raise ValueError("the wheels are lifted: there is no patch below which stress could be")
        grids = tuple(replace(p.loaded(), name=f"patches[{k}]") for k, p in enumerate(self.patches))
        first = self.patches[0]
        return Loads(grids, first.lower, first.upper, are_apart=True, way=first._way)

    def fields(self) -> dict[str, ResultField]:
        """The fields of all patches, by name; none where the wheels are lifted."""
        return {} if self.blank else picture_of(self).fields()

    def totals(self) -> dict[str, ResultField]:
        """Its forces and moments, by name: values with unit and label."""
        return totals_of(
            force=self.force,
            moment=self.moment,
            reference_point=self.reference_point,
            friction_power=self.friction_power,
        )

    def facts(self) -> dict[str, Any]:
        """What else its `summary.json` holds: pose and velocity, the forces of the wheels, the report."""
        names = ("pose", "velocity", "vertical_force", "balance_error", "friction_work")
        return {name: getattr(self, name) for name in names} | {"report": asdict(self.report)}

    def ends(self) -> dict[str, float]:
        """Its numbers by name [SI]: the columns of a sweep. Lifted wheels have no peak and angle: NaN."""
        peaks = [float(patch.pressure.max()) for patch in self.patches]
        angles = [patch.contact_angle for patch in self.patches]
        return {
            **{f"force_{c}": float(v) for c, v in zip("xyz", self.force, strict=True)},
            **{f"moment_{c}": float(v) for c, v in zip("xyz", self.moment, strict=True)},
            **{f"vertical_force_{side}": force for side, force in self.vertical_force.items()},
            **{name: float(self.pose[k]) for k, name in ((1, "y"), (2, "z"), (3, "roll"))},
            "rotation": float(self.velocity[4]),
            "peak_pressure": max(peaks, default=float("nan")),
            "contact_angle": max(angles, key=abs, default=float("nan")),
            "friction_power": self.friction_power,
            "patches": float(len(self.patches)),
            "normal_solves": float(self.report.normal_solves),
        }

    def _draw(self, quantity: Any, kind: Any, options: dict[str, Any]) -> Any:
        if self.blank:
            raise ValueError(self.blank)
        if kind == "3d":
            if len({patch.side for patch in self.patches}) > 1:
                raise ValueError(
                    'kind is "3d": the patches of two wheels lie too far apart for one picture; '
                    "patch.plot draws one of step.patches"
                )
            return pictures().plot(self._picture(), quantity, kind, **options)
        names = [
            f"{p.side} wheel{', flange' if p.on_flange else ''}, {p.ground} at "
            f"{np.degrees(p.contact_angle):.1f}°, {p.normal_force / 1e3:.1f} kN"
            for p in self.patches
        ]
        drawn = [p._picture() for p in self.patches]
        return pictures().plot_side_by_side(drawn, names, quantity, kind, **options)

    @property
    def heading(self) -> str:
        """Nothing that :meth:`told` does not say."""
        return ""

    def told(self) -> list[Row]:
        """Pose, motion, forces and patches in words: what a notebook and the command line show."""
        place, turn = self.pose[:3], 1e3 * self.pose[3:]
        wheels = ", ".join(f"{side} {1e-3 * force:.6g} kN" for side, force in self.vertical_force.items())
        rows = [
            ("outcome", self.report.status),
            ("pose", ", ".join(f"{axis} {length(v)}" for axis, v in zip("xyz", place, strict=True))),
            ("turned by", ", ".join(f"{n} {v:.5g} mrad" for n, v in zip(POSE_TURNS, turn, strict=True))),
            ("velocity", along(self.velocity[:3], "m/s")),
            ("rotation", along(self.velocity[3:], "rad/s")),
            ("force on the rails", along(self.force, "N")),
            ("moment on the rails", along(self.moment, "N m")),
            ("vertical force", wheels),
        ]
        for side, (y, z) in self.rail_displacement.items():
            if y or z:
                rows.append((f"{side} rail moved by", f"y {length(y)}, z {length(z)}"))
        rows.append(("heat of sliding", in_words(self.friction_power, "W")))
        if self.friction_work is not None:
            rows.append(("heat of the step", in_words(self.friction_work, "J")))
        names = [f"{p.side} wheel{', flange' if p.on_flange else ''}" for p in self.patches]
        for k, (name, patch) in enumerate(zip(names, self.patches, strict=True)):
            count = names[:k].count(name) + 1
            rows += _told_of(patch, name if count == 1 else f"{name} {count}")
        return rows

    def _repr_png_(self) -> bytes | None:
        """The pressure maps, for notebooks; none of lifted wheels."""
        with pictures().own_figures():
            return png(self.plot("pressure")) if self.patches else None
