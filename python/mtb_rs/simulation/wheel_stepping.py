# SPDX-License-Identifier: MIT OR Apache-2.0
"""Wheels on rails in a simulation: pose and velocity of the wheelset in, forces and tractions out."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from dataclasses import fields
from numbers import Integral, Real
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .. import _mtb_rs
from ..base.check import choice, flag, number, numbers, positive, reals, shortened, warn
from ..base.errors import ConvergenceError
from ..base.files import check_target, made_of, write_bytes
from ..base.questions import ask, unusual
from ..base.words import Wheels
from ..bodies.conductor import Conductor, of_effusivities
from ..bodies.material import Material
from ..bodies.simple import HalfSpace, Rigid, Simple, without_layers
from ..friction.laws import InterfaceLayer, ShearLayer, as_wheel_friction, in_a_row
from ..geometry.contact_points import spacing_pair
from ..geometry.geometries import RAIL_HARDNESS, WheelOnRail
from ..geometry.profiles import MOST_WORN, Profile, of_pair
from ..geometry.slices import RailSlices, WheelSlices, nominal_of
from ..geometry.wheel_rail import USUAL_LENGTHS
from ..half_space.pressure_field import OF_UNLIKE, UNLIKE, unlikeness
from ..results.plausible import of_hardness
from ..results.temperature import flows_along
from ..results.wheel_result import History, WheelPatch, WheelReport, WheelState, WheelStep
from ..scenes.posed import PosedScene
from ..scenes.taken import refuse_beyond
from . import fmu
from .coordinates import POSE
from .stepping import pose_of
from .wheel_derivatives import WheelTangent

Array = NDArray[np.float64]
#: Distance of the two contacts [m], and the creepage from which on a rotation beside the axle is asked about.
GAUGE, BESIDE_AXLE = 1.5, 1e-4

#: Farthest grid line of a state, in spacings.
FARTHEST = 10**15
#: Relative departure of the vertical force above which a height was found at a jump of the force.
OF_JUMP = 1e-6
#: Share of a contact that lies askew to its plane from which on a step says so.
NEGLECTED = 0.05
#: Distance from the back of a wheel up to which its flange reaches [m].
FLANGE_WIDTH = 33e-3
#: Rows of cells in a contact below which a step says so.
NARROW = 3
#: Position and slope of the plane of a patch, its pressure, its coefficients of friction and its creepages.
CoreHistory = tuple[list[float], float, Array, Array, list[float] | None]
#: A state as the core has it: overlaps; side, first cell and field of each patch; its history; what else was
#: found.
CoreState = tuple[
    list[float],
    list[tuple[str, tuple[int, int], Array]],
    list[CoreHistory | None],
    list[float] | None,
]
#: Numbers of a rail or a wheel beside its place, left and right: where it is, and its rates.
Deviations = list[list[list[float]]]
#: Lateral force [N], and whether a longitudinal force [N] or a moment [N m] is given, with its size.
Loads = tuple[float | None, tuple[bool, float] | None]
#: Right wheel, rail, radius [m] and friction, where they differ from the left ones.
Right = tuple[str | Profile | WheelSlices | None, str | Profile | RailSlices | None, float | None, Any]
SIDES = ("left", "right")


class PreparedWheels:
    """One or both wheels of a wheelset on the rails, ready for a simulation.

    :meth:`mtb_rs.Scene.prepare` makes it from a wheel on a rail, or :meth:`load` reads it. The wheelset of
    the scene is shifted by `lateral` to the left. In the track frame x points along the rails in the
    direction of travel, y to the left and z up; its origin lies on the top of the rails in the middle of the
    track. Patches of one wheel are solved apart from each other if their planes differ by more than 20
    degrees.

    Rolling is taken as steady. This is right where a patch rolls over its own length in less time than the
    forces take to change; else ask for transient steps. Each `step` starts from the memory of the last one,
    which changes only the time that a steady step takes. A pickle and a deep copy take this memory along;
    :meth:`copy` and a file do not. Calls from several threads wait for each other.
    """

    def __init__(self, core: _mtb_rs.PreparedWheels) -> None:
        self._core = core
        self.sides: tuple[str, ...] = tuple(core.sides)
        #: Whether a pressure above the hardness has been asked about: once, not in each step of a simulation.
        self._has_asked = False
        self._has_asked_about_axle = False
        self._bodies: list[Simple] = [
            Rigid() if own is None else HalfSpace(Material.from_shear_modulus(*own)) for own in core.materials
        ]

    def __repr__(self) -> str:
        return f"<PreparedWheels: {' and '.join(self.sides)}, {self._core.force:g} N each>"

    @property
    def reference_point(self) -> Array:
        """Reference point on the wheelset of poses, velocities and moments, at the zero pose [m]."""
        return np.array(self._core.reference_point)

    def step(
        self,
        pose: Sequence[float] | Array | None = None,
        velocity: float | Sequence[float] | Array | None = None,
        dt: float | None = None,
        state: WheelState | None = None,
        transient: bool = False,
        lateral_force: float | None = None,
        longitudinal_force: float | None = None,
        axle_moment: float | None = None,
        curvature: float = 0.0,
        rails: Mapping[str, Sequence[float] | Array] | None = None,
        wheels: Mapping[str, Sequence[float] | Array] | None = None,
    ) -> WheelStep:
        """Solves the contacts at one instant.

        A steady step is as if the wheels had rolled so for long. A transient one rolls on from the last step:
        each patch remembers its tractions, and the particles in it move by the rolling speed times `dt` and
        by what the patch has moved over the rail. From steady steps to transient ones nothing jumps. Where a
        patch moves by parts of a cell, what its earlier tractions did there is linear along x between the
        cells, so that steps of any length end at steady rolling. Patches that overlap across the rail from
        step to step hand on their tractions: if they merge, those of the less loaded are interpolated
        linearly on the cells of the other; if one parts, each of its cells goes to the nearest. A patch that
        overlaps none starts from rest.

        Parameters
        ----------
        pose : (x, y, z, roll, pitch, yaw) [m], [rad]
            Rigid displacement of the wheelset from its position in the scene, where it just touches the rail:
            rotations through `reference_point` by the pitch about the fixed y axis (how far the wheels have
            rolled), then by roll and yaw about the fixed x and z axes, then the translation. If z is NaN, it
            is found such that the wheel carries the scene's vertical force (both wheels twice that), friction
            included. If z and roll are NaN for both wheels, they are found such that each wheel carries it.
            With a `lateral_force` y is NaN as well, and found. None: z, the roll of both wheels, and y with a
            `lateral_force`, are NaN, and all other components are zero. On a roller x is the place of the
            axle over that of the roller, and not a way along a track.
        velocity : (vx, vy, vz, wx, wy, wz) [m/s], [rad/s]
            Velocity of the wheelset at `reference_point`, in the track, with its rotation about the axle (wy
            > 0 rolls forwards; for a yawed or rolled axle the rotation has components along x and z, for a
            roll that is found as well: its part along z is then the yaw rate and wy times this roll, and one
            of exactly 0 is asked about). A number v means v along x and v / r about the axle in its pose,
            with the radius r of the tape circle, or the mean of both. On a roller vx is the speed of its
            surface at `roller_radius`, which runs backwards below a wheelset whose middle of the axle stays
            where it is: the roller turns by -vx / roller_radius about y.
        dt : float [s]
            Length of the step, for `friction_work`, and of a transient step.
        state : WheelState
            State to start from in place of the memory.
        transient : bool
            Whether the step rolls on from the last one, or from rest if there is none, for `dt`. Pose and
            velocity are those at its end: a step over several cells is divided into parts of a cell at most,
            in which pressure and creepages change evenly from those of the last step. A step over more
            than four lengths of a patch is steady there. A wheel may stand still: then it is shifted by its
            slip velocity times `dt`, and needs no `standstill_speed`.
        lateral_force : float [N]
            Force of all wheels on the rails along y, for which y is found together with z (and roll),
            friction included. On a flange two positions may give it, below and above its steepest place, and
            on small rollers, or where friction pushes, several on the tread: the search goes from the y of
            the last step (or of `state`, or from 0) along the positions that carry the vertical force, and
            takes the first; on a flange the report says so.
        longitudinal_force, axle_moment : float [N], [N m]
            Force of all wheels on the rails along x (a braked wheelset pushes them forwards: > 0), or moment
            of the forces on the rails about the axle, for which the rotation about the axle is found; one of
            them. A wheelset that rolls freely has a moment of 0. The search begins with the rotation of the
            tape circle.
        curvature : float [1/m]
            Curvature of the track, > 0 in a curve to the left. The velocity is then relative to a frame that
            goes along the middle of the track with `vx` and turns with it; rails and patches are straight.
        rails : {"left", "right": (y, z, roll, vy, vz, wx)} [m], [rad], [m/s], [rad/s]
            Rails beside their places: displacement, rotation about the origin of their profile, and the
            rates of these, in the track. Three numbers leave the rates at zero.
        wheels : {"left", "right": (x, y, z, roll, pitch, yaw, and rates)} [m], [rad], [m/s], [rad/s]
            Wheels beside their places on the rigid wheelset, which a flexible one has: displacement of the
            middle of the tape circle and rotation, along and about the axes of the wheelset, which roll and
            yaw turn and the pitch does not. The rates are what the wheel moves and turns beside the rigid
            wheelset as this one turns: a wheel on an axle that is bent by `z` and `yaw` and stays so turns
            about its own middle and axle, by rates of `-omega * z` along x and `-omega * yaw` about x; `x`
            and `roll` add `omega * x` along z and `omega * roll` about z. `omega` is the rotation about the
            axle [rad/s].

        Raises
        ------
        ValueError
            If an argument is wrong, or a contact reaches the end of a profile.
        ConvergenceError
            If a problem was not solved, or the edge of a grid cuts a contact off.

        Warns
        -----
        UserWarning
            Once, of the first peak pressure above the hardness of rail steel.
        """
        forces = (lateral_force, longitudinal_force, axle_moment)
        place, motion, loads, alignment = _given(
            self.sides, pose, velocity, forces, (curvature, rails, wheels)
        )
        start = None if state is None else _core_state(state)
        if dt is not None:
            positive("dt", dt, "s")
        if not isinstance(transient, (bool, np.bool_)):
            raise ValueError(f"transient is {transient!r}: True or False is needed")
        if transient and dt is None:
            raise ValueError(
                "transient is True, and dt is missing: the time since the last step [s] is needed"
            )
        try:
            out = self._core.step(place, motion, start, dt if transient else None, *loads, alignment)
        except _mtb_rs.NotConverged as error:
            raise ConvergenceError(str(error)) from None
        carried = dict(out.vertical_force)
        names = [f.name for f in fields(WheelPatch) if f.name not in ("lower", "upper")]
        lower, upper = self._bodies
        patches = tuple(
            WheelPatch(**{name: getattr(p, name) for name in names}, lower=lower, upper=upper)
            for p in out.patches
        )
        if not self._has_asked and patches:
            peak = max(float(patch.pressure.max()) for patch in patches)
            questions = of_hardness(peak, RAIL_HARDNESS, self._core.young_moduli, np.inf)
            self._has_asked = bool(questions)
            ask(questions)
        if not self._has_asked_about_axle and motion.size == 6 and np.isnan(place[3]):
            is_found = longitudinal_force is not None or axle_moment is not None
            questions = _beside_axle(motion, float(out.pose[3]), is_found)
            self._has_asked_about_axle = bool(questions)
            ask(questions)
        step = WheelStep(
            force=out.force,
            moment=out.moment,
            vertical_force=carried,
            balance_error=out.balance_error,
            reference_point=out.reference_point,
            pose=out.pose,
            velocity=out.velocity,
            rail_displacement=dict(out.rail_displacement),
            patches=patches,
            friction_power=out.friction_power,
            friction_work=None if dt is None else out.friction_power * dt,
            state=_state_of(out.state),
            report=WheelReport(
                out.normal_solves,
                out.iterations,
                _in_words(
                    self._core,
                    patches,
                    out.balance_error,
                    None if lateral_force is None else out.force[1] - lateral_force,
                    sum(carried.values()),
                ),
            ),
        )
        points = sum(patch.pressure.size for patch in patches)
        names_of_forces = ("lateral_force", "longitudinal_force", "axle_moment")
        tangent = WheelTangent(
            out.tangent,
            self._by_friction(),
            self._bodies,
            motion.size == 1,
            {name for name, value in zip(names_of_forces, forces, strict=True) if value is not None},
            bool(transient),
            self._core.has_springs,
            self.sides,
            (len(patches), points),
            self._core.conformal,
        )
        object.__setattr__(step, "_derived", tangent)
        return step

    def _by_friction(self) -> dict[str, Array]:
        """Slopes (m, *shape) of the m numbers of friction that the core knows by what it is given by."""
        found: dict[str, Array] = {}
        for law, shapes, conductors in self._core.frictions:
            own = in_a_row({f"{law}.{name}".rstrip("."): tuple(shape) for name, shape in shapes})
            if conductors is not None:
                lower, upper = (Conductor(*constants) for constants in conductors)
                own |= of_effusivities(own.pop(f"{law}.effusivity"), lower, upper, law)
            found |= own
        return found

    def copy(self) -> PreparedWheels:
        """The same wheels without memory."""
        return PreparedWheels(self._core.copy())

    def save(self, path: str | os.PathLike[str]) -> None:
        """Writes the wheels for :meth:`load` and for the C interface, with a checksum; without memory.

        Raises
        ------
        ValueError
            If the path is a directory.
        OSError
            If nothing can be written there.
        """
        write_bytes(path, self._core.to_bytes())

    def save_fmu(
        self,
        path: str | os.PathLike[str],
        library: str | os.PathLike[str] | None = None,
        pose: Mapping[str, float] | None = None,
        velocity: float | Sequence[float] | Array | None = None,
        fmi: int = 2,
        lateral_force: float | None = None,
        longitudinal_force: float | None = None,
        axle_moment: float | None = None,
        curvature: float | None = None,
        rails: Mapping[str, Sequence[float] | Array] | None = None,
        wheels: Mapping[str, Sequence[float] | Array] | None = None,
        transient: bool = False,
    ) -> None:
        """Writes the wheels as a functional mock-up unit for co-simulation, which needs no Python.

        Inputs are those of `pose.x` to `pose.yaw` that `pose` names, and `velocity`, or `velocity.x` to
        `velocity.z` and `angular_velocity.x` to `angular_velocity.z`. If z is left out, it is found from the
        vertical force; if z and roll are left out for both wheels, they are found such that each wheel
        carries it. What is found is an output, `pose.z` and `pose.roll`. All other components that are left
        out are zero. Each of `lateral_force` to `wheels` that is given is an input as well, the numbers of
        rails and wheels as `rail.left.y` to `rail.right.wx` and `wheel.left.x` to `wheel.right.wz`; then
        `pose.y` and `rotation` (3) are outputs where they are found, and `rail_displacement.left.y` to
        `.right.z` where rails are inputs or have springs. Directional derivatives are by each input.
        Further outputs are `force.x` to `moment.z` (on the rails, about the reference point),
        `vertical_force.left` and `vertical_force.right`, `friction_power` and `peak_pressure`. By FMI 3
        `velocity`, `angular_velocity`, `force`, `moment` (3) and the `vertical_force` of both wheels (2) are
        arrays, and so are `pose.translation` and `pose.rotation` (3) where `pose` names all three.

        Parameters
        ----------
        path : str or path object
            For example "wheelset.fmu".
        library : str or path object, optional
            As of :meth:`PreparedContact.save_fmu`.
        pose : {"x", "y", "z", "roll", "pitch", "yaw": float} [m], [rad]
            First values of the components of the pose that are inputs.
        velocity : float or (vx, vy, vz, wx, wy, wz) [m/s], [rad/s]
            First values, as in :meth:`step`.
        fmi : int
            Version of the standard: 2 (FMI 2.0) or 3 (FMI 3.0).
        lateral_force, longitudinal_force : float [N]
        axle_moment : float [N m]
        curvature : float [1/m]
        rails : {"left", "right": (y, z, roll, vy, vz, wx)} [m], [rad], [m/s], [rad/s]
        wheels : {"left", "right": (x, y, z, roll, pitch, yaw, and rates)} [m], [rad], [m/s], [rad/s]
            First values, as in :meth:`step`.
        transient : bool
            False: each step is steady rolling. True: each step rolls on from the last one for its duration,
            as of :meth:`step`; `friction_power` is the mean over the step. The first values are those of
            steady rolling, or of wheels at rest pressed together without friction. States that an importing
            program keeps and goes back to hold the tractions.

        Raises
        ------
        ValueError
            If an argument is wrong, a contact reaches the end of a profile at the first values, or the
            library is of another version.
        ConvergenceError
            If the problem at the first values was not solved.
        OSError
            If nothing can be written there.
        """
        fmi = fmu.check_version(fmi)
        rolls_on = flag("transient", transient)
        given = fmu.first_pose(pose)
        is_found = "z" not in given
        finds_roll = is_found and "roll" not in given and len(self.sides) == 2
        place = np.array([0.0, 0.0, np.nan, np.nan if finds_roll else 0.0, 0.0, 0.0])
        if lateral_force is not None:
            if "y" in given or not is_found:
                raise ValueError("lateral_force is given: y and z of the pose are found, and are no inputs")
            place[1] = np.nan
        starts = {}
        for component, value in given.items():
            starts[f"pose.{component}"] = place[POSE.index(component)] = value
        motion = _velocity(velocity).tolist()
        names = ["velocity"] if len(motion) == 1 else [*fmu.RIGID]
        starts |= dict(zip(names, motion, strict=True))
        loads = {
            "lateral_force": lateral_force,
            "longitudinal_force": longitudinal_force,
            "axle_moment": axle_moment,
            "curvature": curvature,
        }
        starts |= {name: number(name, value) for name, value in loads.items() if value is not None}
        for body, numbers_of, beside in (("rail", fmu.RAIL, rails), ("wheel", fmu.WHEEL, wheels)):
            if beside is not None:
                both = _deviations(f"{body}s", beside, len(numbers_of) // 2, self.sides)
                for side in self.sides:
                    values = np.ravel(both[SIDES.index(side)]).tolist()
                    starts |= {f"{body}.{side}.{n}": v for n, v in zip(numbers_of, values, strict=True)}
        outputs = {*fmu.LOAD, *(f"vertical_force.{side}" for side in self.sides)}
        found = {
            "pose.z": is_found,
            "pose.roll": finds_roll,
            "pose.y": lateral_force is not None,
            **dict.fromkeys(fmu.ROTATION, longitudinal_force is not None or axle_moment is not None),
            **{
                f"rail_displacement.{side}.{c}": rails is not None or self._core.has_springs
                for side in self.sides
                for c in "yz"
            },
        }
        outputs |= {name for name, is_output in found.items() if is_output}
        target = check_target(path)
        # what cannot be solved shows here, not in the importing program
        first = {
            "pose": place,
            "velocity": motion[0] if len(motion) == 1 else motion,
            "lateral_force": lateral_force,
            "longitudinal_force": longitudinal_force,
            "axle_moment": axle_moment,
            "curvature": curvature or 0.0,
            "rails": rails,
            "wheels": wheels,
        }
        tried = self.copy()
        if not rolls_on or np.any(motion):
            tried.step(**first)
        if rolls_on:
            tried.step(**first, dt=fmu.AT_ONCE, transient=True)
        kind = fmu.TRANSIENT_WHEELS if rolls_on else fmu.WHEELS
        core, about = self._core.to_bytes(), self.reference_point
        unit = fmu.packed(kind, core, library, target.stem, about, starts, outputs, fmi)
        write_bytes(target, unit)

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> PreparedWheels:
        """Reads what :meth:`save` wrote.

        Raises
        ------
        ValueError
            If the file cannot be read, or holds no prepared wheels, or not all of them.
        """
        return cls(made_of(path, "file of prepared wheels", _mtb_rs.PreparedWheels.from_bytes))

    def __reduce__(self) -> tuple[Any, ...]:
        return _from_bytes, (self._core.to_bytes(), self._core.state)


def prepare_wheels(
    scene: PosedScene,
    geometry: WheelOnRail,
    side: Wheels,
    friction: Any,
    layer: ShearLayer | None,
    reference_point: ArrayLike | None,
    standstill_speed: float | None,
    rail_stiffness: ArrayLike | None = None,
    rail_force: ArrayLike | None = None,
    conformal: bool = False,
    second_order: bool = False,
    right: Right = (None, None, None, None),
) -> PreparedWheels:
    """The wheels of a scene; see :meth:`mtb_rs.Scene.prepare`."""
    choice("side", side, Wheels)
    refuse_beyond(scene, "wheels in steps")
    given = dict(geometry.arguments)
    point: tuple[float, ...] | None = None
    if reference_point is not None:
        centre = np.asarray(reference_point, dtype=float)
        if centre.shape != (3,) or not np.isfinite(centre).all():
            raise ValueError(f"reference_point is {reference_point!r}: three finite numbers [m] are needed")
        point = tuple(centre.tolist())
    if scene.force is None:
        raise ValueError("nothing presses the wheel: a scene with a force [N] is needed")
    law = as_wheel_friction("friction", friction).native_of_wheels()
    if layer is not None and not isinstance(layer, InterfaceLayer):
        raise ValueError(
            f"layer is {layer!r}: wheels in steps take an InterfaceLayer; Rolling takes a PlasticLayer"
        )
    if geometry.on_flange is not None:
        warn(geometry.on_flange)
    right_pair, right_friction = _right(given, side, right)
    place = geometry.placement
    (wheel, wheel_slices), (rail, rail_slices) = (nominal_of(name, given[name]) for name in ("wheel", "rail"))
    upper, lower = without_layers(scene.simple, "a wheel in steps")
    if second_order and unlikeness(lower.elastic, upper.elastic) > UNLIKE:
        warn(OF_UNLIKE)
    cos = float(np.cos(place.contact_angle))
    lengths = ("wheel_radius", "gauge", "gauge_depth", "flange_back", "tape_circle", "lateral")
    return PreparedWheels(
        _mtb_rs.PreparedWheels(
            wheel._core,
            rail._core,
            **{name: float(given[name]) for name in (*lengths, "rail_inclination")},
            roller_radius=None if given["roller_radius"] is None else float(given["roller_radius"]),
            first_height=place.undeformed_height,
            side=side,
            # the scene's acts along the normal of its own contact plane
            force=scene.force * cos,
            approach=place.approach / cos,
            spacing=place.spacing if scene.spacing is None else spacing_pair(scene.spacing),
            lower=lower.elastic,
            upper=upper.elastic,
            friction=law,
            layer=0.0 if layer is None else layer.flexibility,
            reference_point=point,
            standstill_speed=None
            if standstill_speed is None
            else positive("standstill_speed", standstill_speed, "m/s"),
            springs=_springs(rail_stiffness, rail_force),
            wheel_slices=wheel_slices,
            rail_slices=rail_slices,
            right=right_pair,
            right_friction=right_friction,
            conformal=conformal,
            second_order=second_order,
        )
    )


def _right(given: Mapping[str, Any], side: Wheels, right: Right) -> tuple[Any, Any]:
    """The right wheel and its friction as the core takes them, None where it is as the left one of the
    arguments `given`."""
    names = ("right_wheel", "right_rail", "right_wheel_radius", "right_friction")
    told = {name: value for name, value in zip(names, right, strict=True) if value is not None}
    if told and side == "left":
        name, value = next(iter(told.items()))
        raise ValueError(
            f'{name} is {shortened(value)}, and side is "left": "right" or "both" is needed for it'
        )
    friction = told.pop("right_friction", None)
    if friction is not None:
        friction = as_wheel_friction("right_friction", friction).native_of_wheels()
    if not told:
        return None, friction
    of = {name: told.get(f"right_{name}", given[name]) for name in ("wheel", "rail", "wheel_radius")}
    radius = positive("right_wheel_radius", of["wheel_radius"], "m")
    right_wheel, wheel_slices = nominal_of("wheel", of["wheel"], "right_")
    right_rail, rail_slices = nominal_of("rail", of["rail"], "right_")
    ask(
        [
            *unusual({"right_wheel_radius": radius}, {"right_wheel_radius": USUAL_LENGTHS["wheel_radius"]}),
            *_of_radii(given["wheel_radius"], radius),
            *of_pair(right_wheel, right_rail, "right_"),
        ]
    )
    pair = (right_wheel._core, right_rail._core, float(radius), wheel_slices, rail_slices)
    return pair, friction


def _of_radii(left: float, right: float) -> list[str]:
    """A question about wheels of one axle that differ by more than wheels wear."""
    if abs(right - left) <= MOST_WORN:
        return []
    return [
        f"right_wheel_radius is {right:g} m and wheel_radius {left:g} m: wheels of one axle differ by tenths "
        "of a millimetre"
    ]


def _springs(stiffness: Any, force: Any) -> list[list[float]] | None:
    if stiffness is None:
        if force is not None:
            raise ValueError(
                f"rail_force is {force!r}, and rail_stiffness is missing: rails without springs do not move"
            )
        return None
    found = np.asarray(stiffness, dtype=float)
    if found.shape != (2,) or not np.all(found > 0.0):
        raise ValueError(
            f"rail_stiffness is {stiffness!r}: (lateral, vertical) stiffness > 0 [N/m] is needed, "
            "infinity where a rail does not move"
        )
    acting = np.zeros(2) if force is None else np.asarray(numbers("rail_force", force, 2))
    return [found.tolist(), acting.tolist()]


def check_step(
    wheels: PreparedWheels,
    pose: Sequence[float],
    velocity: Any,
    forces: tuple[Any, Any, Any],
    alignment: tuple[Any, Any, Any],
) -> None:
    """ValueError for what a steady step refuses by its numbers alone, without solving it.

    `forces` are its lateral and longitudinal force and its moment, `alignment` curvature, rails and wheels.
    """
    place, motion, loads, beside = _given(wheels.sides, pose, velocity, forces, alignment)
    wheels._core.check(place, motion, *loads, beside)


def _given(
    sides: tuple[str, ...], pose: Any, velocity: Any, forces: Any, alignment: Any
) -> tuple[list[float], Array, Loads, tuple[float, Deviations, Deviations]]:
    """What a step is given, as the core takes it."""
    lateral = 0.0 if forces[0] is None else np.nan
    roll = np.nan if len(sides) == 2 else 0.0
    place = np.array([0.0, lateral, np.nan, roll, 0.0, 0.0]) if pose is None else pose_of(pose)
    curvature, rails, wheels = alignment
    beside = (
        number("curvature", curvature, "1/m"),
        _deviations("rails", rails, 3, sides),
        _deviations("wheels", wheels, 6, sides),
    )
    return place.tolist(), _velocity(velocity), _loads(*forces), beside


def _loads(lateral_force: Any, longitudinal_force: Any, axle_moment: Any) -> Loads:
    lateral = None if lateral_force is None else float(number("lateral_force", lateral_force, "N"))
    if longitudinal_force is not None and axle_moment is not None:
        raise ValueError(
            f"longitudinal_force is {longitudinal_force!r} and axle_moment is {axle_moment!r}: the rotation "
            "about the axle is found from one of them"
        )
    if longitudinal_force is not None:
        return lateral, (True, float(number("longitudinal_force", longitudinal_force, "N")))
    if axle_moment is not None:
        return lateral, (False, float(number("axle_moment", axle_moment, "N m")))
    return lateral, None


def _deviations(name: str, given: Any, count: int, sides: tuple[str, ...]) -> Deviations:
    """Place and rate of both sides; `count` numbers each."""
    found = {side: [[0.0] * count, [0.0] * count] for side in SIDES}
    if given is None:
        return list(found.values())
    if not isinstance(given, Mapping) or not set(given) <= set(sides):
        raise ValueError(f"{name} is {shortened(given)}: a dict with the keys {', '.join(sides)} is needed")
    for side, values in given.items():
        flat = reals(f"{name}[{side!r}]", values)
        if flat.shape not in ((count,), (2 * count,)):
            raise ValueError(
                f"{name}[{side!r}] has shape {flat.shape}: {count} numbers are needed, or "
                f"{2 * count} with the rates"
            )
        found[side][: flat.size // count] = flat.reshape(-1, count).tolist()
    return list(found.values())


def _in_words(
    core: _mtb_rs.PreparedWheels,
    patches: tuple[WheelPatch, ...],
    balance_error: float | None,
    sideways: float | None,
    carried: float,
) -> str:
    """How a step ended.

    `sideways` is what the lateral force departs by from the one asked for, `carried` the vertical force [N].
    """
    tape_circle = core.tape_circle
    is_balanced, error = balance_error is not None, balance_error or 0.0
    if not patches:
        return "solved: the wheels are lifted"
    touching = {patch.side for patch in patches}
    said = [f"the {side} wheel is lifted" for side in core.sides if side not in touching]
    said += [
        f"the flange of the {patch.side} wheel is in contact, where the contact {patch.ground} is inclined "
        f"by {np.degrees(patch.contact_angle):.0f}° and carries {patch.normal_force / 1e3:.4g} kN"
        for patch in patches
        if patch.on_flange
    ]
    said += [
        f"the {patch.side} wheel stands on the tip of its flange, {-1e3 * patch.wheel_position:.0f} mm "
        "beside its tape circle: it has climbed its rail"
        for patch in patches
        if not patch.on_flange and patch.wheel_position < FLANGE_WIDTH - tape_circle
    ]
    advice = ""
    if core.may_be_conformal:
        advice = ": prepare the wheels with conformal=True, whose patches follow the rail"
    said += [
        f"{100.0 * patch.neglected:.0f} % of the contact of the {patch.side} wheel is inclined by more than "
        "20° to its plane" + advice
        for patch in patches
        if patch.ground == "plane" and patch.neglected > NEGLECTED
    ]
    said += [
        f"the contact of the {patch.side} wheel is {rows} cell{'s' * (rows > 1)} wide, across: its pressure "
        "is rough, and smaller cells are needed"
        for patch in patches
        if (rows := int(np.count_nonzero(patch.pressure.max(axis=1)))) < NARROW
    ]
    bodies = {law: conductors for law, _, conductors in core.frictions if conductors is not None}
    for patch in patches:
        own = bodies.get("right_friction" if patch.side == "right" else "friction", bodies.get("friction"))
        if own is not None and patch.rolling_speed != 0.0:
            along = patch.x[patch.pressure.max(axis=0) > 0.0]
            half = 0.5 * float(np.ptp(along) + patch.x[1] - patch.x[0])
            lower, upper = (Conductor(*constants) for constants in own)
            said += flows_along(half, abs(patch.rolling_speed), (lower, upper))
    if is_balanced:
        said += [
            f"friction lifts the {patch.side} rail at {np.degrees(patch.contact_angle):.0f}° by more than "
            "the pressure presses it down: another height may carry the same force, and this is the one "
            "found from the last step"
            for patch in patches
            if patch.force[2] > 0.0
        ]
    if sideways is not None and any(patch.on_flange for patch in patches):
        said.append(
            "another position, further up the flange, may give the same lateral force: this is the one "
            "reached first from the last step, or from the middle of the track where no way leads from there"
        )
    elif core.has_springs and any(patch.on_flange for patch in patches):
        said.append(
            "the rails may rest on their springs at another place of the flange as well: this is the one "
            "found from the last step"
        )
    if is_balanced and abs(error) > OF_JUMP:
        name = "force on the spring of a rail"
        if abs(sideways or 0.0) > OF_JUMP * core.force:
            name = "lateral force"
        elif abs(carried / (len(core.sides) * core.force) - 1.0) > OF_JUMP:
            name = "vertical force"
        said.append(
            f"the {name} jumps here, as the contact plane turns: it is {abs(error):.1g} of the vertical "
            f"force {'larger' if error > 0.0 else 'smaller'} than in balance"
        )
    return ": ".join(["solved", *(["; ".join(said)] if said else [])])


def _from_bytes(data: bytes, state: CoreState) -> PreparedWheels:
    core = _mtb_rs.PreparedWheels.from_bytes(data)
    core.resume(state)
    return PreparedWheels(core)


def _state_of(state: CoreState) -> WheelState:
    depth, ratio, histories, found = state
    history: list[History | None] = []
    for known in histories:
        if known is None:
            history.append(None)
            continue
        (x, y, z), angle, pressure, coefficient, creepage = known
        history.append(
            ((x, y, z), angle, pressure, coefficient, None if creepage is None else tuple(creepage))
        )
    return WheelState(tuple(depth), tuple(ratio), tuple(history), None if found is None else tuple(found))


def _beside_axle(velocity: Array, roll: float, is_found: bool) -> list[str]:
    """Asks about a velocity (6) whose rotation has no part along z, where a roll [rad] was found."""
    missing = velocity[4] * roll
    apart = abs(missing * GAUGE / velocity[0]) if velocity[0] != 0.0 else 0.0
    if velocity[5] != 0.0 or apart < BESIDE_AXLE:
        return []
    advice = (
        "give wy = 0 where the rotation about the axle is found"
        if is_found
        else f"give the yaw rate and wy times the roll, {missing:.3g} rad/s, as wz, or a number as velocity"
    )
    return [
        f"the rotation of the velocity is about a level axle (wz = 0), but the roll is found, to "
        f"{1e3 * roll:.3g} mrad: the creepages of the two wheels are {apart:.1g} farther apart, or nearer, "
        f"than those of a wheelset that turns about its axle; {advice}"
    ]


def _velocity(velocity: Any) -> Array:
    if velocity is None:
        raise ValueError("velocity is missing: a number [m/s] or (vx, vy, vz, wx, wy, wz) is needed")
    if np.ndim(velocity) == 0:
        return np.array([number("velocity", velocity, "m/s")])
    if np.shape(velocity) != (6,):
        raise ValueError(f"velocity is {velocity!r}: a number or (vx, vy, vz, wx, wy, wz) is needed")
    return np.array(numbers("velocity", velocity, 6))


def _core_state(state: Any) -> CoreState:
    if not isinstance(state, WheelState):
        raise ValueError(f"state is {state!r}: a WheelState, the `state` of a step, is needed")
    if not isinstance(state.depth, (tuple, list)) or not all(
        isinstance(depth, Real) and np.isfinite(depth) and depth > 0.0 for depth in state.depth
    ):
        raise ValueError(f"state.depth is {state.depth!r}: a tuple of overlaps > 0 [m] is needed")
    if not isinstance(state.ratio, (tuple, list)):
        raise ValueError(f"state.ratio is {state.ratio!r}: a tuple with an entry per patch is needed")
    for k, entry in enumerate(state.ratio):
        side, first, ratio = entry if isinstance(entry, (tuple, list)) and len(entry) == 3 else (None,) * 3
        if (
            side not in ("left", "right")
            or not isinstance(first, (tuple, list))
            or len(first) != 2
            or not all(isinstance(line, Integral) and abs(line) <= FARTHEST for line in first)
            or not isinstance(ratio, np.ndarray)
            or ratio.dtype != np.float64
            or ratio.ndim != 3
            or ratio.shape[0] != 2
            or not np.isfinite(ratio).all()
        ):
            raise ValueError(
                f"state.ratio[{k}] is not (side, first (x, y) cell, finite array (2, ny, nx) of float64)"
            )
    ratios = [(side, (int(i), int(j)), ratio) for side, (i, j), ratio in state.ratio]
    found = None
    if state.found is not None:
        known = reals("state.found", state.found)
        if known.ndim != 1 or not 6 <= known.size <= 70:
            raise ValueError(f"state.found has shape {known.shape}: 6 to 70 numbers are needed, or None")
        found = [float(value) for value in known]
    return list(state.depth), ratios, _core_histories(state), found


def _core_histories(state: WheelState) -> list[CoreHistory | None]:
    if not isinstance(state.history, (tuple, list)) or len(state.history) not in (0, len(state.ratio)):
        raise ValueError(
            f"state.history is {shortened(state.history)}: an entry for each of {len(state.ratio)} patches "
            "is needed, or none at all"
        )
    found: list[CoreHistory | None] = []
    for k, (entry, (_, _, ratio)) in enumerate(zip(state.history, state.ratio, strict=False)):
        if entry is None:
            found.append(None)
            continue
        # of earlier versions without creepages
        if not isinstance(entry, (tuple, list)) or len(entry) not in (4, 5):
            raise ValueError(
                f"state.history[{k}] is {shortened(entry)}: (position (3,) [m], angle [rad], "
                "pressure (ny, nx) [Pa], coefficient (ny, nx) [-], creepage (3,) or None) is needed, or None"
            )
        place = numbers(f"state.history[{k}][0]", entry[0], 3)
        angle = number(f"state.history[{k}][1]", entry[1], "rad")
        fields_of = [reals(f"state.history[{k}][{2 + c}]", field) for c, field in enumerate(entry[2:4])]
        for c, field in enumerate(fields_of):
            if field.shape != ratio.shape[1:] or np.any(field < 0.0):
                raise ValueError(
                    f"state.history[{k}][{2 + c}] has shape {field.shape}: {ratio.shape[1:]}, as the ratio "
                    "of the patch, and nowhere a negative number is needed"
                )
        creepage = None
        if len(entry) == 5 and entry[4] is not None:
            creepage = [float(c) for c in numbers(f"state.history[{k}][4]", entry[4], 3)]
        found.append(([float(x) for x in place], float(angle), fields_of[0], fields_of[1], creepage))
    return found
