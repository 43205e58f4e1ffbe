# SPDX-License-Identifier: MIT OR Apache-2.0
"""Steps of prepared wheels, steady and transient, as trials of derivatives: random poses, bodies, laws."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
from trials import Array, Input, Numbers, Trial, material, of_bodies

import mtb_rs as mtb
from mtb_rs.simulation.wheel_stepping import PreparedWheels

#: Relative residuals of pressures and tractions, and relative error of the force: differences of steps need
#: more than what the cells make.
EXACT = (1e-14, 1e-13, 1e-13)
#: What a change of the pose is: x, y, z [m], roll, pitch, yaw [rad].
POSE = np.array([5e-5, 5e-5, 5e-5, 5e-5, 1e-1, 1e-2])
#: Numbers of a step and of its patches, with what a change of them is, in their own size where it is None.
STEP = {"force": None, "moment": None, "pose": 1e-4, "friction_power": None}
PATCH = {
    "position": 1e-4, "contact_angle": 1e-3, "rail_position": 1e-4, "wheel_position": 1e-4, "approach": 1e-4,
    "creepage": 1e-3, "rolling_speed": None, "force": None, "friction_power": None, "normal_force": None,
}  # fmt: skip
FIELDS = ("pressure", "traction", "slip_velocity")


def state(step: mtb.WheelStep) -> bytes:
    """Which points are in contact, stick and slip, patch by patch."""
    return b"|".join(patch.status.tobytes() + str(patch.status.shape).encode() for patch in step.patches)


def law_of(random: np.random.Generator) -> tuple[Any, dict[str, tuple[Array, Callable[[Array], Any]]]]:
    """A law of friction, and by the name of each input its value and the law with another one."""
    mu, way = random.uniform(0.1, 0.4), random.integers(4)
    if way == 0:
        return mtb.Coulomb(mu), {"friction": (np.array(mu), lambda v: mtb.Coulomb(float(v)))}
    if way == 1:
        memory = {"memory": 1e-4} if random.random() < 0.7 else {}
        law = mtb.FallingFriction(mu, 0.6 * mu, random.uniform(0.1, 0.5), **memory)
        names = ("static", "kinetic", "half_slip", *memory)
        return law, {
            f"friction.{n}": (np.array(getattr(law, n)), lambda v, n=n: replace(law, **{n: float(v)}))
            for n in names
        }  # fmt: skip
    if way == 2:
        values = mu * np.array([1.0, 0.8, 0.5])
        at = [0.0, random.uniform(0.02, 0.05), 0.5]
        return mtb.TabulatedFriction(at, list(values)), {
            "friction.coefficient": (values, lambda v: mtb.TabulatedFriction(at, list(v)))
        }
    values = random.uniform(0.1, 0.4, 3)
    return mtb.friction.RailFriction([-0.06, 0.0, 0.03], list(values)), {
        "friction": (values, lambda v: mtb.friction.RailFriction([-0.06, 0.0, 0.03], list(v)))
    }


def wheels(random: np.random.Generator, *, transient: bool = False) -> Trial:
    """A step of prepared wheels that has derivatives: where there is none, another one."""
    while True:
        try:
            trial = one(random, transient)
            trial.result.gradient("force")["pose"]
        except (ValueError, mtb.ConvergenceError):
            continue
        if trial.result.patches:
            return trial


def transient_wheels(random: np.random.Generator) -> Trial:
    """A step that rolls on from another one, or from rest."""
    return wheels(random, transient=True)


def one(random: np.random.Generator, transient: bool) -> Trial:
    """A step, and what it was given."""
    scene = mtb.scenes.wheel_on_rail(
        lateral=0.0, force=random.uniform(3e4, 9e4), spacing=random.uniform(0.9e-3, 1.4e-3),
        wheel_radius=random.uniform(0.4, 0.55), rail_inclination=float(random.choice([0.025, 0.05])),
    )  # fmt: skip
    sides = ("left", "right", "both")[random.integers(3)]
    law, laws = law_of(random)
    thickness, flexibility = 2e-5, random.uniform(1e-15, 1e-14)
    cos = float(np.cos(scene.geometry.placement.contact_angle))
    bodies = {"upper": material(random), "lower": material(random)}

    def prepared(
        friction: Any = law, force: float = 0.0, layer: float = 0.0, bodies: dict[str, Any] = bodies
    ) -> PreparedWheels:
        contact = replace(scene, force=scene.force + force / cos, **bodies).prepare(
            side=sides, friction=friction,
            layer=mtb.InterfaceLayer(thickness, thickness / (flexibility + layer)),
        )  # fmt: skip
        return PreparedWheels(contact._core.to_accuracy(*EXACT))

    contact = prepared()
    found, (a, b, c) = random.integers(3), random.uniform(-1.0, 1.0, 3)
    roll = np.nan if sides == "both" and found == 2 else 1e-4 * a
    pose = np.array([0.0, random.uniform(-7e-3, 7e-3), np.nan, roll, 1e-3 * b, 5e-3 * c])
    speed = float(random.choice([-30.0, 2.0, 20.0]))
    velocity: Any = speed
    if random.random() < 0.5:
        a, b, c = random.uniform(-1.0, 1.0, 3)
        spin = speed / 0.46 * (1.0 + 2e-3 * c)
        velocity = np.array([speed, 0.03 * a, 0.0, 0.01 * b, spin, 0.05 * a])

    past: dict[str, Any] = {}
    if transient:
        before = contact.copy().step(pose, velocity if np.ndim(velocity) == 0 else list(velocity))
        cells = 10.0 ** random.uniform(-0.7, 1.0)
        past = {"dt": cells * float(np.diff(before.patches[0].x[:2])[0]) / abs(speed), "transient": True}
        if random.random() < 0.8:
            past["state"] = before.state
        else:
            # from rest, at a height that is known
            pose = np.array(before.pose)
        pose[0] = -past["dt"] * speed
        pose[1:] += random.uniform(-1.0, 1.0, 5) * [3e-4, 0.0, 1e-5, 1e-4, 2e-4]

    def solved(contact: PreparedWheels, pose: Array, velocity: Any, by: float = 0.0) -> mtb.WheelStep:
        # without memory, so that differences have none
        given = past | {"dt": past["dt"] + by} if transient else {}
        return contact.copy().step(pose, velocity if np.ndim(velocity) == 0 else list(velocity), **given)

    result = solved(contact, pose, velocity)
    if found == 0:
        pose = np.array(result.pose)
        result = solved(contact, pose, velocity)
    inputs = {
        "pose": Input((6,), POSE, lambda e: solved(contact, pose + e, velocity), np.isfinite(pose)),
        "velocity": Input(np.shape(velocity), 0.1, lambda e: solved(contact, pose, velocity + e)),
        "vertical_force": Input((), 3e3, lambda e: solved(prepared(force=float(e)), pose, velocity)),
        "layer": Input((), flexibility, lambda e: solved(prepared(layer=float(e)), pose, velocity)),
    }
    if transient:
        inputs["dt"] = Input((), 0.1 * past["dt"], lambda e: solved(contact, pose, velocity, float(e)))
    inputs |= of_bodies(bodies, lambda changed: solved(prepared(bodies=changed), pose, velocity))
    for name, (value, made) in laws.items():
        inputs[name] = Input(
            value.shape, 0.1 * value,
            lambda e, value=value, made=made: solved(prepared(made(value + e)), pose, velocity),
        )  # fmt: skip
    return Trial(result, inputs, 1e-4, state, numbers(result, random), has_kinks=True)


def numbers(result: mtb.WheelStep, random: np.random.Generator) -> Numbers:
    """What is derived of a step of wheels."""
    known: Numbers = {}

    def add(name: str, of: Any, value: Callable[[Any], Any], size: float | None = None) -> None:
        own = float(np.abs(value(result)).max(initial=0.0)) or 1.0
        known[name] = of, lambda r: np.ravel(value(r)), own if size is None else size

    for name, size in STEP.items():
        add(name, name, lambda r, name=name: getattr(r, name), size)
    add("vertical_force", "vertical_force", lambda r: np.array(list(r.vertical_force.values())))
    for name, size in PATCH.items():
        of = f"patch_{name}" if name in STEP else name
        add(of, of, lambda r, name=name: np.array([getattr(p, name) for p in r.patches]), size)
    add(
        "creep_force",
        "creep_force",
        lambda r: np.array([p.area * p.traction.sum(axis=(1, 2)) for p in r.patches]),
    )
    for name in FIELDS:

        def row(r: mtb.WheelStep, name: str = name) -> Array:
            parts = [getattr(p, name) for p in r.patches]
            return np.concatenate([part.reshape(*part.shape[:-2], -1) for part in parts], axis=-1)

        values = row(result)
        w = random.uniform(-1.0, 1.0, values.shape)
        size = float(np.sqrt(np.square(w * values).sum())) or 1.0
        add(f"sum of {name}", {name: w}, lambda r, w=w, row=row: (w * row(r)).sum(), size)
    return known
