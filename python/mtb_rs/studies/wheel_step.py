# SPDX-License-Identifier: MIT OR Apache-2.0
"""One step of the wheels of a scene: what a case file and a sweep ask of them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..base.check import number
from ..base.units import taking_quantities
from ..base.words import Model, Wheels
from ..friction.laws import InterfaceLayer
from ..geometry.profiles import Profile
from ..geometry.slices import RailSlices, WheelSlices
from ..results.wheel_result import WheelStep
from ..scenes.scene import WheelScene
from ..simulation.wheel_stepping import PreparedWheels, check_step

Array = NDArray[np.float64]
Deviation = Mapping[str, Sequence[float] | Array]


@taking_quantities
def step_wheels(
    scene: WheelScene,
    velocity: float | Sequence[float] | Array,
    *,
    side: Wheels = "left",
    x: float = 0.0,
    y: float | None = None,
    z: float | None = None,
    roll: float | None = None,
    pitch: float = 0.0,
    yaw: float = 0.0,
    lateral_force: float | None = None,
    longitudinal_force: float | None = None,
    axle_moment: float | None = None,
    curvature: float = 0.0,
    rails: Deviation | None = None,
    wheels: Deviation | None = None,
    rail_stiffness: ArrayLike | None = None,
    rail_force: ArrayLike | None = None,
    standstill_speed: float | None = None,
    friction: Any = None,
    layer: InterfaceLayer | None = None,
    model: Model = "auto",
    conformal: bool | None = None,
    order: int | None = None,
    right_wheel: str | Profile | WheelSlices | None = None,
    right_rail: str | Profile | RailSlices | None = None,
    right_wheel_radius: float | None = None,
    right_friction: Any = None,
) -> WheelStep:
    """One steady step of the wheels of a scene, at a pose or under forces.

    It prepares the wheels and makes their first step; a simulation prepares them once
    (:meth:`mtb_rs.Scene.prepare`). Case files have it as the table ``[step_wheels]``, and sweeps vary its
    arguments by names like "step_wheels.lateral_force".

    Parameters
    ----------
    scene : WheelScene
    velocity : float or (vx, vy, vz, wx, wy, wz) [m/s], [rad/s]
        As in :meth:`mtb_rs.PreparedWheels.step`.
    side : "left", "right" or "both"
    x, y, z : float [m]
    roll, pitch, yaw : float [rad]
        Pose of the wheelset, turned by pitch, then roll, then yaw. None: z is found from the vertical force
        of the scene, roll with it for both
        wheels (else 0), and y from `lateral_force` (else 0).
    lateral_force, longitudinal_force : float [N]
    axle_moment : float [N m]
        Forces of the wheels on the rails for which y and the rotation about the axle are found.
    curvature : float [1/m]
        Of the track.
    rails : {"left", "right": (y, z, roll, vy, vz, wx)} [m], [rad], [m/s], [rad/s]
    wheels : {"left", "right": (x, y, z, roll, pitch, yaw, and rates)} [m], [rad], [m/s], [rad/s]
        What is beside its place, as in :meth:`mtb_rs.PreparedWheels.step`.
    rail_stiffness : (lateral, vertical) [N/m]
    rail_force : (outwards, upwards) [N]
    standstill_speed : float [m/s]
    right_wheel, right_rail : str, Profile or slices
    right_wheel_radius : float [m]
    friction, right_friction, layer, model, conformal, order
        As in :meth:`mtb_rs.Scene.prepare`.

    Raises
    ------
    ValueError
        If the scene is no wheel on a rail, or an argument is wrong.
    ConvergenceError
        If no pose carries the forces, or a problem was not solved.
    """
    contact, pose = prepared_step(
        scene,
        velocity,
        side=side,
        x=x,
        y=y,
        z=z,
        roll=roll,
        pitch=pitch,
        yaw=yaw,
        lateral_force=lateral_force,
        longitudinal_force=longitudinal_force,
        axle_moment=axle_moment,
        curvature=curvature,
        rails=rails,
        wheels=wheels,
        rail_stiffness=rail_stiffness,
        rail_force=rail_force,
        standstill_speed=standstill_speed,
        friction=friction,
        layer=layer,
        model=model,
        conformal=conformal,
        order=order,
        right_wheel=right_wheel,
        right_rail=right_rail,
        right_wheel_radius=right_wheel_radius,
        right_friction=right_friction,
    )
    return contact.step(
        pose,
        velocity,
        lateral_force=lateral_force,
        longitudinal_force=longitudinal_force,
        axle_moment=axle_moment,
        curvature=curvature,
        rails=rails,
        wheels=wheels,
    )


def prepared_step(
    scene: Any,
    velocity: Any,
    *,
    side: Wheels = "left",
    x: float = 0.0,
    y: float | None = None,
    z: float | None = None,
    roll: float | None = None,
    pitch: float = 0.0,
    yaw: float = 0.0,
    lateral_force: float | None = None,
    longitudinal_force: float | None = None,
    axle_moment: float | None = None,
    curvature: float = 0.0,
    rails: Deviation | None = None,
    wheels: Deviation | None = None,
    **prepared: Any,
) -> tuple[PreparedWheels, list[float]]:
    """The wheels, and the pose with what is found; ValueError for what the step refuses before it solves."""
    if not isinstance(scene, WheelScene):
        raise ValueError(f"step_wheels is for a wheel on a rail (wheel_on_rail), and the scene is {scene!r}")
    if lateral_force is not None and (y is not None or z is not None):
        name, value = ("y", y) if y is not None else ("z", z)
        raise ValueError(f"{name} is {value!r} and a lateral_force is given: y and z are found for it")
    contact = scene.prepare(side=side, **prepared)
    finds_roll = z is None and len(contact.sides) == 2
    missing = {
        "y": 0.0 if lateral_force is None else np.nan,
        "z": np.nan,
        "roll": np.nan if finds_roll else 0.0,
    }
    given = {"x": x, "y": y, "z": z, "roll": roll, "pitch": pitch, "yaw": yaw}
    pose = [
        missing[name] if value is None else number(name, value, "m" if name in "xyz" else "rad")
        for name, value in given.items()
    ]
    forces = (lateral_force, longitudinal_force, axle_moment)
    check_step(contact, pose, velocity, forces, (curvature, rails, wheels))
    return contact, pose
