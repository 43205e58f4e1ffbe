# SPDX-License-Identifier: MIT OR Apache-2.0
"""Steps of prepared wheels, steady, transient and in chains, as trials of derivatives: random poses, laws."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from trials import Array, Input, Numbers, Trial, material, of_bodies

import mtb_rs as mtb
from mtb_rs.simulation.wheel_stepping import PreparedWheels

#: Relative residuals of pressures and tractions, and relative error of the force: differences of steps need
#: more than what the cells make.
EXACT = (1e-14, 1e-13, 1e-13)
#: The same of rails on springs, whose forces across are made of tractions; differences are wider.
SETTLED = (1e-14, 1e-11, 1e-10)
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
        # a table begins at 0, and stays there
        return mtb.TabulatedFriction(at, list(values)), {
            "friction.coefficient": (values, lambda v: mtb.TabulatedFriction(at, list(v))),
            "friction.slip_speed": (
                np.array(at), lambda v: mtb.TabulatedFriction([0.0, *v[1:]], list(values))
            ),
        }  # fmt: skip
    values = random.uniform(0.1, 0.4, 3)
    return mtb.friction.RailFriction([-0.06, 0.0, 0.03], list(values)), {
        "friction": (values, lambda v: mtb.friction.RailFriction([-0.06, 0.0, 0.03], list(v)))
    }


def heated_law(random: np.random.Generator) -> tuple[Any, dict[str, tuple[Array, Callable[[Array], Any]]]]:
    """A law that falls with the temperature, at once or by a memory, as `law_of` has others."""
    mu, warm = random.uniform(0.2, 0.4), random.uniform(80.0, 250.0)
    lower, upper = (
        mtb.Conductor(random.uniform(30, 60), random.uniform(7e3, 8e3), random.uniform(4e2, 6e2))
        for _ in range(2)
    )
    law = mtb.TemperatureFriction(
        [0.0, warm, 900.0], [mu, 0.8 * mu, 0.4 * mu], lower, upper, bulk=tuple(random.uniform(5.0, 60.0, 2)),
        memory=random.uniform(5e-5, 5e-4) if random.random() < 0.4 else None, memory_min_slip=1e-2,
    )  # fmt: skip
    found: dict[str, tuple[Array, Callable[[Array], Any]]] = {}
    memory = () if law.memory is None else ("memory", "memory_min_slip")
    for name in ("coefficient", "temperature", "bulk", *memory):
        value = np.array(getattr(law, name), dtype=float)
        found[f"friction.{name}"] = (
            value, lambda v, n=name: replace(law, **{n: list(v) if v.ndim else float(v)})
        )  # fmt: skip
    for side, body in (("lower", lower), ("upper", upper)):
        for name in ("conductivity", "density", "specific_heat"):
            found[f"friction.{side}.{name}"] = (
                np.array(getattr(body, name)),
                lambda v, s=side, b=body, n=name: replace(law, **{s: replace(b, **{n: float(v)})}),
            )
    return law, found


def heated_wheels(random: np.random.Generator) -> Trial:
    """A steady step whose friction follows the temperature."""
    return wheels(random, law_of=heated_law)


def wheels(random: np.random.Generator, *, transient: bool = False, law_of: Any = law_of) -> Trial:
    """A step of prepared wheels that has derivatives: where there is none, another one."""
    while True:
        try:
            trial = one(random, transient, law_of)
            trial.result.gradient("force")["pose"]
        except (ValueError, mtb.ConvergenceError):
            continue
        if trial.result.patches:
            return trial


def transient_wheels(random: np.random.Generator) -> Trial:
    """A step that rolls on from another one, or from rest."""
    return wheels(random, transient=True)


@dataclass(frozen=True)
class Drawn:
    """Wheels drawn at random: how they are prepared with something else, and with what."""

    sides: str
    prepared: Callable[..., PreparedWheels]
    laws: dict[str, tuple[Array, Callable[[Array], Any]]]
    bodies: dict[str, Any]
    flexibility: float
    springs: tuple[Array, Array] | None


def drawn(random: np.random.Generator, **more: Any) -> Drawn:
    """Wheels on rails; with more words for :func:`mtb.scenes.wheel_on_rail`, and `springs` of the rails."""
    springs, laws_of = more.pop("springs", None), more.pop("law_of", law_of)
    scene = mtb.scenes.wheel_on_rail(
        lateral=0.0, force=random.uniform(3e4, 9e4), spacing=random.uniform(0.9e-3, 1.4e-3),
        wheel_radius=random.uniform(0.4, 0.55), rail_inclination=float(random.choice([0.025, 0.05])), **more,
    )  # fmt: skip
    sides = ("left", "right", "both")[random.integers(3)]
    law, laws = laws_of(random)
    thickness, flexibility = 2e-5, random.uniform(1e-15, 1e-14)
    cos = float(np.cos(scene.geometry.placement.contact_angle))
    bodies = {"upper": material(random), "lower": material(random)}

    def prepared(
        friction: Any = law, force: float = 0.0, layer: float = 0.0, bodies: dict[str, Any] = bodies,
        springs: tuple[Array, Array] | None = springs,
    ) -> PreparedWheels:  # fmt: skip
        rails = (
            {} if springs is None else {"rail_stiffness": list(springs[0]), "rail_force": list(springs[1])}
        )
        contact = replace(scene, force=scene.force + force / cos, **bodies).prepare(
            side=sides, friction=friction,
            layer=mtb.InterfaceLayer(thickness, thickness / (flexibility + layer)), **rails,
        )  # fmt: skip
        # what is found beside the height has fewer digits
        return PreparedWheels(contact._core.to_accuracy(*(EXACT if springs is None else SETTLED)))

    return Drawn(sides, prepared, laws, bodies, flexibility, springs)


def one(random: np.random.Generator, transient: bool, law_of: Any) -> Trial:
    """A step, and what it was given."""
    made = drawn(random, law_of=law_of)
    prepared, sides = made.prepared, made.sides
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
        "layer": Input((), made.flexibility, lambda e: solved(prepared(layer=float(e)), pose, velocity)),
    }
    if transient:
        inputs["dt"] = Input((), 0.1 * past["dt"], lambda e: solved(contact, pose, velocity, float(e)))
    inputs |= of_bodies(made.bodies, lambda changed: solved(prepared(bodies=changed), pose, velocity))
    for name, (value, law) in made.laws.items():
        inputs[name] = Input(
            value.shape, 0.1 * value,
            lambda e, value=value, law=law: solved(prepared(law(value + e)), pose, velocity),
        )  # fmt: skip
    # coefficients by the temperature are found to 1e-11
    width = 1e-3 if law_of is heated_law else 1e-4
    return Trial(result, inputs, width, state, numbers(result, random), has_kinks=True)


@dataclass(frozen=True)
class Chain:
    """Steps that follow each other, of which the last is derived, by what one of them was given or all."""

    steps: tuple[mtb.WheelStep, ...]
    one: int

    def gradient(self, of: Any) -> dict[str, Any]:
        nothing = [{} for _ in self.steps[1:]]
        found = mtb.gradient_of_steps(self.steps, [*nothing, of])
        return {
            by: found[self.one][by] if by in OF_ONE else sum(own[by] for own in found) for by in self.inputs
        }

    @property
    def inputs(self) -> dict[str, Any]:
        given = self.steps[self.one]._tangent().inputs
        return {by: given[by] for by in given if not by.startswith(("rails", "wheels", "curvature"))}

    def _tangent(self) -> Chain:
        return self


#: What one step of a chain is given alone.
OF_ONE = ("pose", "velocity", "dt", "lateral_force", "longitudinal_force", "axle_moment")
#: What is derived of the last step: sums with random weights.
OF_CHAIN = ("force", "moment", "pose", "friction_power", "rail_displacement", "creepage", *FIELDS)


def chained_wheels(random: np.random.Generator) -> Trial:
    """Two to five steps that roll on one from the other, the first one steady or from rest."""
    while True:
        try:
            trial = chain(random)
        except (ValueError, mtb.ConvergenceError):
            continue
        if trial.result.steps[-1].patches:
            return trial


def chain(random: np.random.Generator) -> Trial:
    """Steps, and what they were given."""
    worn = {}
    if random.random() < 0.4:
        worn["wheel"] = measured(random)
    springs = None
    if random.random() < 0.3:
        springs = random.uniform(1e7, 6e7, 2), random.uniform(-2e3, 2e3, 2)
    made = drawn(random, springs=springs, **worn)
    count = int(random.integers(2, 6))
    is_steady = random.random() < 0.8
    is_found = random.random() < 0.7
    speed = float(random.choice([-30.0, 2.0, 20.0]))
    roll = np.nan if made.sides == "both" and is_found and random.random() < 0.4 else 0.0
    pose = np.array([0.0, random.uniform(-6e-3, 6e-3), np.nan, roll, 0.0, 5e-3 * random.uniform(-1.0, 1.0)])
    contact = made.prepared()
    at_first = contact.copy().step(pose, speed)
    if not is_found:
        pose[:4] = at_first.pose[:4]
    cell = float(np.diff(at_first.patches[0].x[:2])[0])
    poses, velocities, times = [], [], []
    for k in range(count):
        cells = 10.0 ** random.uniform(-0.7, 0.5)
        times.append(cells * cell / abs(speed))
        if k:
            pose = pose + random.uniform(-1.0, 1.0, 6) * [0.0, 3e-4, 0.0, 1e-5, 1e-4, 2e-4]
            pose[0] += times[-1] * speed
        poses.append(pose)
        a, b, c = random.uniform(-1.0, 1.0, 3)
        velocities.append(
            np.array([speed, 0.03 * a, 0.0, 0.01 * b, speed / 0.46 * (1.0 + 2e-3 * c), 0.05 * a])
        )

    def solved(contact: PreparedWheels, **changed: tuple[int, Array]) -> Chain:
        wheels, steps = contact.copy(), []
        for k in range(count):

            def own(name: str, value: Any, k: int = k) -> Any:
                place, by = changed.get(name, (-1, 0.0))
                return value + by if place == k else value

            rolls = {} if k == 0 and is_steady else {"dt": float(own("dt", times[k])), "transient": True}
            motion = own("velocity", velocities[k])
            steps.append(wheels.step(own("pose", poses[k]), list(motion), **rolls))
        return Chain(tuple(steps), one)

    one = int(random.integers(count - 1))
    result = solved(contact)
    inputs = {
        "pose": Input((6,), POSE, lambda e: solved(contact, pose=(one, e)), np.isfinite(poses[one])),
        "velocity": Input((6,), 0.1, lambda e: solved(contact, velocity=(one, e))),
        "dt": Input((), 0.1 * times[one], lambda e: solved(contact, dt=(one, e))),
        "vertical_force": Input((), 3e3, lambda e: solved(made.prepared(force=float(e)))),
        "layer": Input((), made.flexibility, lambda e: solved(made.prepared(layer=float(e)))),
    }
    if springs is not None:
        stiffness, force = springs
        inputs["rail_stiffness"] = Input(
            (2,), stiffness, lambda e: solved(made.prepared(springs=(stiffness + e, force)))
        )
        inputs["rail_force"] = Input(
            (2,), 2e3, lambda e: solved(made.prepared(springs=(stiffness, force + e)))
        )
    inputs |= of_bodies(made.bodies, lambda changed: solved(made.prepared(bodies=changed)))
    for name, (value, law) in made.laws.items():
        inputs[name] = Input(
            value.shape, 0.1 * value,
            lambda e, value=value, law=law: solved(made.prepared(law(value + e))),
        )  # fmt: skip
    known: Numbers = {}
    last = result.steps[-1]
    for name in OF_CHAIN:
        values = values_of(last, name)
        w = random.uniform(-1.0, 1.0, values.shape)
        size = {"pose": 1e-4, "creepage": 1e-3, "rail_displacement": 1e-4}.get(name)
        known[f"sum of {name}"] = (
            {name: w}, lambda r, w=w, name=name: np.array([(w * values_of(r.steps[-1], name)).sum()]),
            size or float(np.sqrt(np.square(w * values).sum())) or 1.0,
        )  # fmt: skip

    def states(result: Chain) -> bytes:
        return b"/".join(state(step) for step in result.steps)

    width = 1e-4 if springs is None else 1e-3
    return Trial(result, inputs, width, states, known, has_kinks=True)


def measured(random: np.random.Generator) -> mtb.Profile:
    """A wheel worn hollow, as it is measured to two micrometres, and smoothed."""
    y = np.arange(-0.06, 0.05, 2.5e-4)
    z = mtb.Profile.standard("S1002").height(y) + random.uniform(0.0, 2e-4) * np.exp(-((y / 0.02) ** 2))
    return mtb.Profile.from_points(y, z + random.normal(0.0, 2e-6, y.size)).smoothed()


def values_of(step: mtb.WheelStep, name: str) -> Array:
    """A number or a field of a step, as its derivatives have them."""
    if name == "creepage":
        return np.array([patch.creepage for patch in step.patches])
    if name == "rail_displacement":
        return np.array(list(step.rail_displacement.values()))
    if name not in FIELDS:
        return np.asarray(getattr(step, name))
    parts = [getattr(patch, name) for patch in step.patches]
    return np.concatenate([part.reshape(*part.shape[:-2], -1) for part in parts], axis=-1)


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
        values = values_of(result, name)
        w = random.uniform(-1.0, 1.0, values.shape)
        size = float(np.sqrt(np.square(w * values).sum())) or 1.0
        add(f"sum of {name}", {name: w}, lambda r, w=w, name=name: (w * values_of(r, name)).sum(), size)
    return known
