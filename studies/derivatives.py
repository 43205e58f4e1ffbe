# SPDX-License-Identifier: MIT OR Apache-2.0
"""Are exact derivatives exact? Every number by every input of random scenes of each kind, by differences.

Each scene is solved anew with an input moved along a random direction, to both sides and at two distances:
central differences with Richardson's extrapolation. Where a point comes into contact, leaves it, sticks or
slips on the way there is nothing to compare, and the pair is left out and counted. What differs by more than
1e-6, or has a kink, is compared once more with ten times the width: the smaller error counts. An error is
relative to the derivative, or to a fiftieth of the number over the input where the derivative is smaller.
Run from the root of the project: ``python studies/derivatives.py 200`` takes 200 scenes of each kind. Each is
written to out/derivatives.jsonl as it is done, and a second run goes on from there; delete the file after a
change of the library. ``--draw`` only draws the maps and writes the table. ``--cells`` writes which
numbers of each kind are derived by which inputs, and which inputs are refused by name; kinds that are named
after it alone, with the others as they are.
"""

from __future__ import annotations

import csv
import json
import sys
import warnings
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from atlas import FOLDER, panels, write
from further_trials import CELL, CELLS, ball, creeping, heated, layered, magnets, rough_layers, sticking
from numpy.typing import NDArray
from trials import Input, Numbers, Trial, flowing, material, of_bodies
from wheel_trials import chained_wheels, heated_wheels, transient_wheels, wheels

import mtb_rs as mtb
from mtb_rs.bodies.mesh import block_mesh
from mtb_rs.half_space.pressure_field import PressureField

Array = NDArray[np.float64]
Solve = Callable[[], Any]

#: What an error may be, relative to the derivative.
ACCEPTED = 1e-6
#: Share of a number over an input below which a derivative counts as nothing.
LEAST = 0.02
#: Fields whose sums with random weights are derived too.
FIELDS = (
    *("pressure", "traction", "gap", "slip", "friction_coefficient", "dissipation"),
    *("plastic_indentation", "plastic_slip", "accumulated_plastic_slip", "plastic_dissipation"),
    "magnetic_pressure",
)
#: What has been compared so far.
KNOWN = Path("out") / "derivatives.jsonl"


@dataclass(frozen=True)
class Found:
    """One number by one input."""

    kind: str
    of: str
    by: str
    error: float | None


def of_scene(scene: mtb.Scene, model: Any) -> Trial:
    """A scene, and what it states."""

    def solved(changed: mtb.Scene) -> Any:
        return changed.solve(model=model)

    result = solved(scene)
    inputs: dict[str, Input] = {}
    sizes = {"force": scene.force, "approach": scene.approach, "velocity": scene.velocity}
    for name, value in sizes.items():
        if value is not None:
            inputs[name] = Input(
                (), value, lambda e, n=name, v=value: solved(replace(scene, **{n: v + float(e)}))
            )
    for name, size in (("moments", 5.0), ("sliding_direction", 1.0)):
        pair = getattr(scene, name)
        if pair is not None:
            inputs[name] = Input(
                (2,), size, lambda e, n=name, v=pair: solved(replace(scene, **{n: tuple(np.array(v) + e)}))
            )
    friction, pull, shape = scene.friction, scene.magnetic_pressure, result.pressure.shape
    if isinstance(friction, mtb.VelocityTable):
        values = np.array(friction.value)
        inputs["friction"] = Input(
            values.shape, 0.3,
            lambda e: solved(replace(scene, friction=mtb.VelocityTable(friction.velocity, list(values + e)))),
        )  # fmt: skip
    elif friction:
        inputs["friction"] = Input((), 0.3, lambda e: solved(replace(scene, friction=friction + float(e))))
        inputs["friction_field"] = Input(shape, 0.3, lambda e: solved(replace(scene, friction=friction + e)))
    if pull is not None:
        inputs["magnetic_pressure"] = Input(
            (), pull, lambda e: solved(replace(scene, magnetic_pressure=pull + float(e)))
        )
        inputs["magnetic_pressure_field"] = Input(
            shape, pull, lambda e: solved(replace(scene, magnetic_pressure=pull + e))
        )
    for name in ("normal_layer", "hardness"):
        own = getattr(scene, name)
        if own is None:
            continue

        def with_more(e: Any, name: str = name, own: Any = own) -> Any:
            return solved(replace(scene, **{name: own + e}))

        inputs[name] = Input((), own, lambda e, more=with_more: more(float(e)))
        inputs[f"{name}_field"] = Input(shape, own, with_more)
    if isinstance(scene.gap, np.ndarray):
        gap = scene.gap
        inputs["gap"] = Input(gap.shape, 1e-6, lambda e: solved(replace(scene, gap=gap + e)))
    inputs |= dict(of_bodies(scene, solved))
    return Trial(result, inputs)


def pressing(random: np.random.Generator, *, tilting: bool) -> dict[str, Any]:
    """One of the ways to press."""
    way = random.integers(4 if tilting else 3)
    if way == 0:
        return {"force": random.uniform(5e2, 3e3)}
    if way == 1:
        return {"approach": random.uniform(5e-6, 1e-5)}
    if way == 2:
        return {"magnetic_pressure": random.uniform(5e6, 2e7), "attraction": random.choice(["upper", "both"])}
    return {"force": random.uniform(5e2, 3e3), "moments": tuple(random.uniform(-0.3, 0.3, 2))}


def sliding(random: np.random.Generator) -> dict[str, Any]:
    """How it slides, and by what friction."""
    angle = random.uniform(0.0, 2.0 * np.pi)
    friction: Any = random.uniform(0.05, 0.4)
    if random.random() < 0.4:
        friction = mtb.VelocityTable([0.0, 5.0, 20.0], [friction, 0.8 * friction, 0.5 * friction])
    return {
        "friction": friction, "velocity": random.uniform(1.0, 15.0),
        "sliding_direction": (np.cos(angle), np.sin(angle)),
    }  # fmt: skip


def half_space(random: np.random.Generator) -> mtb.Scene:
    lower = mtb.Rigid() if random.random() < 0.2 else material(random)
    return mtb.Scene(
        material(random),
        lower,
        gap=ball(random),
        spacing=CELL,
        normal_layer=random.uniform(1e-15, 2e-14) if random.random() < 0.3 else None,
        **pressing(random, tilting=True),
        **sliding(random),
    )


def on_layer(random: np.random.Generator) -> mtb.Scene:
    """Half-spaces, of which one or both are layered."""
    scene, first = half_space(random), random.integers(3)
    for number, side in enumerate(("lower", "upper")):
        if first in (number, 2):
            base = mtb.Rigid() if random.random() < 0.3 else material(random)
            body = mtb.Layered(material(random), random.uniform(1.0, 4.0) * CELL, base)
            scene = scene.with_(**{side: body})
    return scene


def block(random: np.random.Generator) -> mtb.Scene:
    """A body of finite elements above, below or on both sides."""
    mesh = block_mesh(np.linspace(-0.04, 0.04, 5), np.linspace(-0.02, 0.02, 4), 0.03)
    side = random.integers(3)
    upper: Any = material(random)
    lower: Any = material(random)
    if side != 1:
        upper = mtb.ElasticBody(mesh, upper, "bottom", [mtb.Support("top", x=0, y=0)])
    if side != 0:
        held = [mtb.Support("bottom", x=0, y=0, z=0)]
        lower = mtb.ElasticBody(mesh.moved(shift=(0.0, 0.0, -0.03)), lower, "top", held)
    waves, sizes = random.uniform(50.0, 200.0, 2), random.uniform(1e-7, 4e-7, 2)

    def gap(x: Array, y: Array) -> Array:
        return np.asarray(
            sizes[0] * (1 + (x / 0.04) ** 2 * 2) + sizes[1] * np.sin(waves[0] * x + waves[1] * y)
        )

    load: dict[str, Any] = {"force": random.uniform(1e4, 3e4)}
    if random.random() < 0.5:
        load = {"magnetic_pressure": random.uniform(2e6, 5e6)}
    return mtb.Scene(upper, lower, gap=gap, spacing=1e-2, **load, **sliding(random))


def own_body(random: np.random.Generator) -> mtb.Scene:
    """A ready scene of other sizes: a shoe or a block."""
    friction = random.uniform(0.05, 0.3)
    if random.random() < 0.5:
        return mtb.scenes.block_on_plane(spacing=2e-2, friction=friction)
    return mtb.scenes.pole_shoe_on_rail(
        spacing=1.2e-2,
        friction=friction,
        magnetic_pressure=random.uniform(2e6, 4e6),
        velocity=random.uniform(1, 9),
    )


def scene_of(make: Callable[[np.random.Generator], mtb.Scene]) -> Callable[[np.random.Generator], Trial]:
    def trial(random: np.random.Generator) -> Trial:
        scene = make(random)
        trial = of_scene(scene, scene.models[-1])
        return trial if scene.models[-1] == "half-space" else replace(trial, width=1e-3)

    return trial


def step(random: np.random.Generator) -> Trial:
    """A step of a prepared contact, after another one."""
    pulled = random.random() < 0.5
    load = {"magnetic_pressure": random.uniform(5e6, 2e7)} if pulled else {"force": random.uniform(5e2, 3e3)}
    scene = mtb.Scene(
        material(random), material(random), gap=ball(random), spacing=CELL, **load, **sliding(random)
    )
    contact = scene.prepare("half-space", reference_point=(0.01, 0.0, 0.02), standstill_speed=0.2)
    n = contact.points.shape[1]
    given = {
        "pose": np.array([0.0, 0.0, np.nan, *random.uniform(-2e-5, 2e-5, 3)]),
        "velocity": random.uniform(1.0, 8.0) * np.array(scene.sliding_direction),
        "gap": 1e-7 * random.random(n),
    }
    if random.random() < 0.5:
        given["friction"] = random.uniform(0.05, 0.4, n)
    if pulled:
        given["magnetic_pressure"] = random.uniform(5e6, 2e7)

    def solved(name: str, e: Array) -> Any:
        changed = given | {name: given[name] + (float(e) if np.ndim(given[name]) == 0 else e)}
        pose, velocity = changed.pop("pose"), changed.pop("velocity")
        return contact.step(pose, tuple(velocity), **changed)

    result = solved("gap", np.zeros(n))
    scale = {"pose": 1e-5, "velocity": 4.0, "gap": 1e-6, "friction": 0.3, "magnetic_pressure": 1e7}
    inputs = {
        name: Input(np.shape(value), scale[name], lambda e, name=name: solved(name, e))
        for name, value in given.items()
    }
    if "friction" in given:
        inputs["friction_field"] = inputs.pop("friction")
        inputs["friction"] = Input((), 0.3, lambda e: solved("friction", np.full(n, float(e))))

    def prepared(changed: mtb.Scene) -> Any:
        anew = changed.prepare("half-space", reference_point=(0.01, 0.0, 0.02), standstill_speed=0.2)
        rest = {name: value for name, value in given.items() if name not in ("pose", "velocity")}
        return anew.step(given["pose"], tuple(given["velocity"]), **rest)

    inputs |= dict(of_bodies(scene, prepared))
    return Trial(result, inputs, 1e-3)


def at_hardness(random: np.random.Generator) -> Trial:
    """A scene where some points flow, or a step of it."""
    while True:
        scene = (half_space, block)[random.integers(2)](random)
        model = scene.models[-1]
        peak = float(scene.solve(model=model).pressure.max())
        scene = replace(scene, hardness=random.uniform(0.5, 0.8) * peak)
        try:
            result = scene.solve(model=model)
        except mtb.ResultantError:
            continue  # the load is more than the contact bears
        if (result.pressure < scene.hardness).any():
            break

    def state(result: Any) -> bytes:
        return bytes(result.status.tobytes() + (result.plastic_indentation > 0.0).tobytes())

    if random.random() < 0.5:
        return replace(of_scene(scene, model), width=1e-3, state=state)
    pose = np.array([0.0, 0.0, np.nan if scene.approach is None else -scene.approach, 0.0, 0.0, 0.0])
    velocity = random.uniform(1.0, 8.0) * np.array(scene.sliding_direction)

    def stepped(changed: mtb.Scene, pose: Array = pose, velocity: Array = velocity) -> Any:
        return changed.prepare(model).step(pose, tuple(velocity))

    inputs = {
        "pose": Input((6,), 1e-5, lambda e: stepped(scene, pose=pose + e)),
        "velocity": Input((2,), 4.0, lambda e: stepped(scene, velocity=velocity + e)),
        "hardness": Input(
            (), scene.hardness, lambda e: stepped(replace(scene, hardness=scene.hardness + float(e)))
        ),
    }
    return Trial(stepped(scene), inputs | dict(of_bodies(scene, stepped)), 1e-3, state)


def prism(random: np.random.Generator) -> mtb.Prism:
    """A bar, its base held or on springs."""
    springs = tuple(random.uniform(2e8, 2e9, 2)) if random.random() < 0.5 else None
    return mtb.Prism(tuple(random.uniform(0.03, 0.06, 2)), material(random), springs)


def normal(random: np.random.Generator, *, on_prisms: bool = False) -> Trial:
    given: dict[str, Any] = {"gap": ball(random), "upper": material(random), "lower": material(random)}
    if on_prisms:
        given["lower"] = prism(random)
        if random.random() < 0.5:
            given["upper"] = prism(random)
    way = random.integers(2 if on_prisms else 3)
    given |= {"approach": 8e-6} if way == 0 else {"force": random.uniform(5e2, 2e3)}
    if way == 2:
        given["moments_about_axes"] = tuple(random.uniform(-0.3, 0.3, 2))
    if random.random() < 0.4:
        given["normal_layer"] = random.uniform(1e-15, 2e-14)
    if random.random() < 0.4:
        elastic = mtb.solve_normal(**given, spacing=CELL, edge="sharp")
        given["hardness"] = random.uniform(0.5, 0.8) * float(elastic.pressure.max())

    def solved(changed: dict[str, Any]) -> Any:
        by_products = given["gap"].sum() * 1e9 % 2 < 1 and "hardness" not in given and not on_prisms
        method = "fft" if by_products else "auto"
        return mtb.solve_normal(
            **{"spacing": CELL, "tolerance": 1e-13, "method": method, "edge": "sharp"} | changed
        )

    sizes = {
        "gap": 1e-6, "approach": 8e-6, "force": 1e3, "moments_about_axes": 0.3,
        "normal_layer": 1e-14, "hardness": 5e8,
    }  # fmt: skip
    inputs = {
        name: Input(
            np.shape(value), sizes[name],
            lambda e, n=name, v=value: solved(given | {n: v + (float(e) if np.ndim(v) == 0 else e)}),
        )
        for name, value in given.items() if name in sizes
    }  # fmt: skip
    inputs |= dict(of_bodies(given, solved))
    return Trial(solved(given), inputs)


def rubbing(
    kind: str, *, yields: bool = False, inclined: bool = False, on_prisms: bool = False
) -> Callable[[np.random.Generator], Trial]:
    """Shifts and rolling; with `coupled` at the end the pressure follows the traction."""

    def trial(random: np.random.Generator) -> Trial:
        coupled = kind.endswith("coupled")
        given: dict[str, Any] = {"upper": material(random), "lower": material(random)}
        turn: dict[str, Any] = {}
        if inclined:
            # of one material, and rolling along the rows
            given["upper"] = given["lower"]
            turn["inclination"] = random.uniform(0.1, 0.4) * np.linspace(-1.0, 1.0, CELLS)
        if on_prisms:
            sides = (("lower",), ("upper",), ("lower", "upper"))[random.integers(3)]
            given |= {side: prism(random) for side in sides}
        if coupled:
            given |= {"gap": ball(random), "normal_force": random.uniform(5e2, 2e3)}
            if random.random() < 0.3:
                given["normal_layer"] = random.uniform(1e-15, 2e-14)
        else:
            x = (np.arange(CELLS) - 0.5 * (CELLS - 1)) * 6e-4
            inside = 1.0 - (x[None, :] / 3e-3) ** 2 - (x[:, None] / random.uniform(2e-3, 3e-3)) ** 2
            given["pressure"] = random.uniform(4e8, 9e8) * np.sqrt(np.maximum(inside, 0.0))
        spacing = CELL if coupled else 6e-4
        mu = random.uniform(0.1, 0.4)
        friction: Any = mtb.Coulomb(mu)
        if random.random() < 0.5 and not coupled:
            friction = mtb.FallingFriction(mu, 0.8 * mu, random.uniform(2.0, 8.0))
        layer: Any = mtb.InterfaceLayer(2e-5, 1e9) if random.random() < 0.3 else None
        if yields:
            friction = mtb.Coulomb(mu)
            layer = mtb.PlasticLayer(
                2e-6, 1e9, yield_stress=random.uniform(0.2, 0.8) * mu * float(given["pressure"].max()),
                hardening=random.choice([6e13, 2e14]),
            )  # fmt: skip
        rolls = not kind.startswith("shift")
        if not rolls:
            motion: Any = mtb.Shift(
                tuple(random.uniform(-2e-6, 2e-6, 2)), spin=random.uniform(-1e-4, 1e-4), duration=1e-3
            )
        else:
            motion = mtb.Rolling(
                (*random.uniform(-2e-3, 2e-3, 2), random.uniform(-0.4, 0.4)),
                angle=0.0 if inclined or on_prisms else random.uniform(0.1, 1.4),
                step=random.uniform(0.6, 1.4) * spacing,
                transient=not kind.startswith("steady"),
            )  # fmt: skip
        given |= {"motion": motion, "friction": friction, "layer": layer, "state": None}

        def solved(g: dict[str, Any]) -> Any:
            bodies = {"lower": g["lower"], "upper": g["upper"]}
            if coupled:
                pressed = mtb.solve_normal(
                    g["gap"], spacing, force=g["normal_force"], tolerance=1e-13, edge="sharp",
                    normal_layer=g.get("normal_layer", 0.0), **bodies,
                )  # fmt: skip
            else:
                pressed = PressureField(g["pressure"], (spacing, spacing), **bodies, **turn)
            return mtb.solve_tangential(
                pressed, g["motion"], g["friction"], layer=g["layer"], state=g["state"], tolerance=1e-12,
                coupling="full" if coupled else "one-way",
            )  # fmt: skip

        if not kind.startswith("steady"):
            given["state"] = solved(given | {"motion": mtb.Shift((1e-6, -1e-6))}).state
        result = solved(given)
        inputs = {} if inclined else dict(of_bodies(given, solved))
        away = 1.0
        if rolls:
            # their widths are small beside the way to where a step ends on a border or middle of a cell
            half_cells = 2.0 / spacing * np.array(motion.step_vector((spacing, spacing)))
            away = min(away, 50.0 * float(np.abs(half_cells - np.round(half_cells)).min()))
        for name, size in (
            ("gap", 1e-6),
            ("normal_force", 1e3),
            ("normal_layer", 1e-14),
            ("pressure", 5e8),
        ):
            if name in given:
                value = given[name]
                # cells out of contact stay so
                inputs[name] = Input(
                    np.shape(value), size,
                    lambda e, n=name, v=value: solved(
                        given | {n: v + (float(e) if np.ndim(v) == 0 else e)}
                    ),
                    value > 0.0 if name == "pressure" else True,
                )  # fmt: skip
        sizes = {
            "creepage": 1e-3, "displacement": 1e-6, "spin": 1e-4, "duration": 1e-3, "velocity": 10.0,
            "step": spacing * away, "angle": away,
        }  # fmt: skip
        if inclined or on_prisms:
            # rolling is known along the rows alone
            del sizes["angle"]
        for name, size in sizes.items():
            value = getattr(motion, name, None)
            if value is not None:
                inputs[name] = Input(
                    np.shape(value), size,
                    lambda e, n=name, v=value: solved(
                        given | {"motion": replace(motion, **{n: tuple(v + e) if e.ndim else v + float(e)})}
                    ),
                )  # fmt: skip
        for prefix, owner in (("friction", friction), ("layer", layer)):
            for name in (
                "coefficient",
                "static",
                "limit",
                "kinetic",
                "half_slip",
                "thickness",
                "shear_modulus",
                "yield_stress",
                "hardening",
            ):
                value = getattr(owner, name, None)
                if isinstance(value, float):
                    by = prefix if name == "coefficient" else f"{prefix}.{name}"
                    inputs[by] = Input(
                        (), value,
                        lambda e, p=prefix, o=owner, n=name, v=value: solved(
                            given | {p: replace(o, **{n: v + float(e)})}
                        ),
                    )  # fmt: skip
        if given["state"] is not None:
            state = given["state"]
            for name, size in (("traction", 1e8), ("pressure", 5e8), ("accumulated_plastic_slip", 1e-7)):
                value = getattr(state, name)
                if value is None:
                    continue
                inputs[f"state.{name}"] = Input(
                    value.shape, size,
                    lambda e, n=name, v=value: solved(given | {"state": replace(state, **{n: v + e})}),
                    state.pressure > 0.0 if name != "accumulated_plastic_slip" else value > 0.0,
                )  # fmt: skip
        if yields and not result.plastic_slip.any():
            # where nothing yields, its heat is rounding
            return trial(random)
        return Trial(result, inputs, state=yielding if yields else flowing)

    return trial


def yielding(result: Any) -> bytes:
    """The state of every cell, and where the layer yields."""
    return flowing(result) + np.any(result.plastic_slip != 0.0, axis=0).tobytes()


def one_of(*kinds: str, **more: bool) -> Callable[[np.random.Generator], Trial]:
    """A shift or rolling of one of some kinds."""

    def trial(random: np.random.Generator) -> Trial:
        return rubbing(kinds[random.integers(len(kinds))], **more)(random)

    return trial


#: Kinds in which something follows the state, or the step before.
FOLLOWING = ("magnets", "rough layers", "steps that stick")
#: Kinds that were compared last.
FURTHER = (
    "transient wheels",
    "chains of wheels",
    "layers that yield",
    "inclined contacts",
    "pressed prisms",
    "rolling on prisms",
    "heated rolling",
    "bodies that creep",
    "layered bodies",
    "layered scenes",
    "heated wheels",
)

KINDS: dict[str, Callable[[np.random.Generator], Trial]] = {
    "sliding half-spaces": scene_of(half_space),
    "sliding elastic bodies": scene_of(block),
    "ready scenes": scene_of(own_body),
    "steps": step,
    "wheels": wheels,
    "normal": normal,
    "shift": rubbing("shift"),
    "steady rolling": rubbing("steady"),
    "transient rolling": rubbing("transient"),
    "shift, coupled": rubbing("shift, coupled"),
    "steady rolling, coupled": rubbing("steady, coupled"),
    "magnets": magnets,
    "rough layers": rough_layers,
    "steps that stick": sticking,
    "transient wheels": transient_wheels,
    "chains of wheels": chained_wheels,
    "layers that yield": one_of("shift", "steady", "transient", yields=True),
    "inclined contacts": one_of("shift", "steady", "transient", inclined=True),
    "points that flow": at_hardness,
    "pressed prisms": partial(normal, on_prisms=True),
    "heated rolling": heated,
    "bodies that creep": creeping,
    "layered bodies": layered,
    "layered scenes": scene_of(on_layer),
    "heated wheels": heated_wheels,
    "rolling on prisms": one_of("shift", "steady", "transient", "steady, coupled", on_prisms=True),
}

#: Maps, and the kinds in each of them.
MAPS = {
    "derivatives": tuple(kind for kind in KINDS if kind not in (*FOLLOWING, *FURTHER)),
    "derivatives_following": FOLLOWING,
    "derivatives_further": FURTHER,
}

#: Kinds whose bodies are condensed anew at every change of a material: they come last.
SLOW = ("sliding elastic bodies", "ready scenes")


def power(result: Any) -> float:
    """Heat of sliding [W]: of shifts and rolling the sum of the dissipation, over their own time."""
    if isinstance(result, mtb.TangentialResult):
        return float(result.motion.slip_speed * (result.dissipation * result.area).sum())
    return float(getattr(result, "friction_power", None) or 0.0)


def numbers(trial: Trial, random: np.random.Generator) -> Numbers:
    """What is derived of a result."""
    if trial.numbers is not None:
        return trial.numbers
    result = trial.result
    p, area = result.pressure, result.area
    place, whole = int(p.argmax()), float(area[result.status > 0].sum())
    force, reach = float((p * area).sum()), float(np.abs(result.points[:2]).max())
    own: dict[str, tuple[Callable[[Any], Any], float]] = {
        "force": (lambda r: r.force, force),
        "moment": (lambda r: r.moment, force * reach),
        "normal_force": (lambda r: (r.pressure * area).sum(), force),
        "peak_pressure": (lambda r: r.pressure.flat[place], float(p.max())),
        "mean_pressure": (lambda r: (r.pressure * area).sum() / whole, float(p.max())),
        "approach": (lambda r: r.approach, 1e-5),
        "tilts": (lambda r: np.array(r.tilts), 1e-5 / reach),
        "spin_moment": (lambda r: r.spin_moment, 0.3 * force * reach),
        "creepage": (lambda r: r.creepage, 1e-3),
        "friction_power": (power, abs(power(result))),
        "rolling_resistance": (lambda r: r.rolling_resistance, 0.1 * force),
    }
    known = {}
    if power(result) <= 1e-9 * abs(float(np.abs(p).max()) * float(area.sum())):
        # nothing slips, or the result does not tell
        own.pop("friction_power")
    for name, (value, size) in own.items():
        try:
            result.gradient(name)
        except ValueError:
            continue
        known[name] = (name, lambda r, value=value: np.ravel(value(r)), size)
    fields = result._tangent().fields
    for name in FIELDS:
        field = getattr(result, name, None)
        if field is None or name not in fields:
            continue
        if name in ("slip", "dissipation") and not (result.status == 2).any():
            continue
        w = random.uniform(-1.0, 1.0, np.shape(field))
        size = float(np.sqrt((np.square(w * field)).sum())) or 1.0
        known[f"sum of {name}"] = (
            {name: w}, lambda r, w=w, name=name: np.array([(w * getattr(r, name)).sum()]), size
        )  # fmt: skip
    return known


#: All names of numbers and fields, and of inputs, that any kind has, and some that none has.
OF = (
    *("force", "moment", "normal_force", "approach", "tilts", "peak_pressure", "mean_pressure", "creepage"),
    *(
        "friction_power",
        "spin_moment",
        "rolling_resistance",
        "motion",
        "unknowns",
        "contact_area",
        "status",
        *FIELDS,
    ),
)
BY = (
    *("gap", "pressure", "friction", "friction_field", "friction.static", "friction.coefficient", "spacing"),
    *("force", "approach", "moments", "moments_about_axes", "normal_force", "tilts", "pose", "work"),
    *("normal_layer", "normal_layer_field", "hardness", "hardness_field", "diagonal"),
    *("magnetic_pressure", "magnetic_pressure_field", "velocity", "sliding_direction", "step", "angle"),
    *("creepage", "displacement", "spin", "duration", "layer.thickness", "layer.shear_modulus"),
    *("state.traction", "state.pressure", "state.coefficient", "upper.young_modulus", "upper.poisson_ratio"),
    *("lower.young_modulus", "lower.poisson_ratio", "shift", "state.rigid_displacement"),
    *(
        "magnetic_pressure.ampere_turns",
        "magnetic_pressure.yoke",
        "normal_layer.gap",
        "normal_layer.pressure",
    ),
)
#: Numbers of a derivative above which a field by a field is not tried.
MOST = 2000


def riddles(kind: str, seed: int) -> list[str]:
    """All names asked of one scene: what is neither answered nor refused with a sentence about a name."""
    result = KINDS[kind](np.random.default_rng([seed, sum(map(ord, kind))])).result
    fields, inputs = result._tangent().fields, result._tangent().inputs
    found = []
    for of in OF:
        for by in BY:
            if np.prod(fields.get(of, ()), dtype=int) * np.prod(inputs.get(by, ()), dtype=int) > MOST:
                continue
            try:
                if not np.isfinite(result.derivative(of, by)).all():
                    found.append(f"{of} by {by} is not finite")
            except Exception as error:
                if not (isinstance(error, ValueError) and str(error).startswith(("of is", "by is"))):
                    found.append(f"{of} by {by}: {error!r}")
    return found


@dataclass(frozen=True)
class Cells:
    """What some scenes of a kind answer: numbers and fields, inputs, and inputs that they refuse by name."""

    kind: str
    of: tuple[str, ...]
    by: tuple[str, ...]
    refused: tuple[str, ...]
    missing: tuple[tuple[str, str], ...]


def cells(kind: str, seeds: Sequence[int]) -> Cells:
    """Every number and field by every input that scenes of a kind have: which answer, and which do not."""
    ofs, bys, refused, missing = [], [], [], []
    for seed in seeds:
        result = KINDS[kind](np.random.default_rng([seed, sum(map(ord, kind))])).result
        tangent = result._tangent()
        own = [*result._functionals(), *tangent.fields]
        refused += list(tangent.refused)
        for of in own:
            shape = tangent.fields.get(of, ())
            # fields have very many numbers: a sum of one tells as much
            how = {of: np.ones(shape)} if of in tangent.fields else of
            gradient = result.gradient(how)
            ofs.append(of)
            for by in tangent.inputs:
                bys.append(by)
                if not np.isfinite(gradient[by]).all():
                    missing.append((of, by))
    known = tuple(dict.fromkeys(bys))
    return Cells(
        kind, tuple(dict.fromkeys(ofs)), known,
        tuple(name for name in dict.fromkeys(refused) if name not in known), tuple(dict.fromkeys(missing)),
    )  # fmt: skip


def tabulate(kinds: list[str], count: int = 6) -> None:
    """Writes which numbers of some kinds are derived by which inputs, and which are refused by name."""
    file = FOLDER / "derivatives_cells.csv"
    there: dict[str, list[str]] = {}
    if file.exists():
        with file.open(newline="") as old:
            there = {row[0]: row for row in list(csv.reader(old))[1:]}
    with file.open("w", newline="") as out:
        rows = csv.writer(out, lineterminator="\n")
        rows.writerow(["kind", "of", "by", "refused", "missing"])
        for kind in KINDS:
            if kind not in kinds:
                rows.writerows([there[kind]] if kind in there else [])
                continue
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")
                found = cells(kind, range(2 if kind in SLOW else count))
            told = [" by ".join(pair) for pair in found.missing]
            row = [kind, *(", ".join(names) or "none" for names in (found.of, found.by, found.refused, told))]
            rows.writerow(row)
            print(row, flush=True)


def tried(kind: str, seed: int) -> Iterator[Found]:
    """One scene of a kind: each number by each input."""
    random = np.random.default_rng([seed, sum(map(ord, kind))])
    trial = KINDS[kind](random)
    asked = numbers(trial, random)
    given = trial.result._tangent().inputs
    gradients = {of: trial.result.gradient(how) for of, (how, _, _) in asked.items()}
    for by, own in trial.inputs.items():
        if by not in given:
            continue
        direction = np.where(own.where, own.size * random.uniform(-1.0, 1.0, own.shape), 0.0)
        errors = dict.fromkeys(asked)
        # a wrong derivative is as wrong with ten times the width, a kink is as sharp, and noise a tenth
        for width in (trial.width, 10.0 * trial.width):
            doubtful = [of for of, error in errors.items() if error is None or error > ACCEPTED]
            if not doubtful:
                break
            found = compared(trial, own, direction, width, {of: asked[of] for of in doubtful}, gradients, by)
            for of, error in found.items():
                if error is not None:
                    errors[of] = min(error, errors[of] if errors[of] is not None else np.inf)
        for of, error in errors.items():
            yield Found(kind, of, by, error)


def compared(
    trial: Trial, own: Input, direction: Array, h: float, asked: Numbers, gradients: dict[str, Any], by: str
) -> dict[str, float | None]:
    """Errors of the derivatives of some numbers by an input along a direction; None where they have kinks."""
    shares = [s * step for step in (h, 0.5 * h) for s in (1.0, -1.0)]
    try:
        moved = [own.solve(np.asarray(share * direction)) for share in shares]
    except mtb.ConvergenceError:
        # to so many digits not every step of wheels is solved
        moved = []
    states = {trial.state(m) for m in (trial.result, *moved)}
    if not moved or states != {trial.state(trial.result)}:
        return dict.fromkeys(asked)
    errors: dict[str, float | None] = {}
    for of, (_, value, size) in asked.items():
        values = [value(m) for m in moved]
        wide, near = (values[0] - values[1]) / (2 * h), (values[2] - values[3]) / h
        wanted = (4.0 * near - wide) / 3.0
        least = LEAST * size
        # noise that is taken for no kink has to be well below what is accepted
        noise = 0.3 * ACCEPTED * np.fmax(np.abs(wanted), least)
        if trial.has_kinks and has_kink(value(trial.result), values, h, noise):
            errors[of] = None
            continue
        gradient = np.asarray(gradients[of][by])
        found = np.ravel(
            np.tensordot(gradient, direction, np.ndim(direction)) if own.shape else gradient * direction
        )
        errors[of] = float((np.abs(found - wanted) / np.maximum(np.abs(wanted), least)).max())
    return errors


def has_kink(at: Array, values: list[Array], h: float, accepted: Array) -> bool:
    """Whether second differences go with the width instead of its square, or slopes differ by the width."""
    far, near = values[0] - 2.0 * at + values[1], values[2] - 2.0 * at + values[3]
    apart = (values[0] - values[1]) / (2.0 * h) - (values[2] - values[3]) / h
    return bool((np.abs(far - 4.0 * near) / h > accepted).any() or (np.abs(apart) > accepted).any())


def listed(kind: str, seed: int) -> list[Found]:
    """One scene, in a process of its own."""
    warnings.simplefilter("ignore")
    return list(tried(kind, seed))


def compare(whole: int, kinds: list[str]) -> None:
    """Writes the comparisons of each scene as soon as it is done, those that are there left out."""
    there = set(known())
    # scenes of all kinds in turn, so that an end before the last one leaves some of each
    waiting = [(kind, seed) for seed in range(whole) for kind in kinds if (kind, seed) not in there]
    waiting.sort(key=lambda one: one[0] in SLOW)
    KNOWN.parent.mkdir(exist_ok=True)
    with ProcessPoolExecutor() as pool, KNOWN.open("a") as out:
        running = {pool.submit(listed, *one): one for one in waiting}
        for done in as_completed(running):
            kind, seed = running[done]
            found = [(f.of, f.by, f.error) for f in done.result()]
            out.write(json.dumps([kind, seed, found]) + "\n")
            out.flush()


def known() -> dict[tuple[str, int], list[Found]]:
    """All comparisons so far, by kind and number of the scene."""
    if not KNOWN.exists():
        return {}
    rows = [json.loads(line) for line in KNOWN.read_text().splitlines()]
    return {(kind, seed): [Found(kind, *one) for one in found] for kind, seed, found in rows}


def draw(name: str, kinds: list[str]) -> None:
    """A map and its table of all comparisons so far."""
    scenes = known()
    figure, axes = panels(len(kinds), 2, 3.0)
    rows = []
    for kind, ax in zip(kinds, axes, strict=False):
        own = [found for (of_kind, _), found in scenes.items() if of_kind == kind]
        found = [f for scene in own for f in scene]
        compared = [f for f in found if f.error is not None]
        ofs, bys = list(dict.fromkeys(f.of for f in found)), list(dict.fromkeys(f.by for f in found))
        table = np.full((len(ofs), len(bys)), np.nan)
        for f in compared:
            i, j = ofs.index(f.of), bys.index(f.by)
            table[i, j] = np.fmax(table[i, j], np.log10(max(f.error or 0.0, 1e-12)))
        mesh = ax.pcolormesh(table, vmin=-12.0, vmax=-5.0, cmap="viridis")
        ax.set_title(f"{kind}: {len(own)} scenes", fontsize=7)
        ax.set_xticks(np.arange(len(bys)) + 0.5, bys, rotation=90, fontsize=4.5)
        ax.set_yticks(np.arange(len(ofs)) + 0.5, ofs, fontsize=4.5)
        ax.invert_yaxis()
        figure.colorbar(mesh, ax=ax).set_label("largest error, power of ten", fontsize=5)
        row = {
            "kind": kind,
            "scenes": len(own),
            "compared": len(compared),
            "left_out": len(found) - len(compared),
            "worse_than_1e-6": sum((f.error or 0.0) > ACCEPTED for f in compared),
            "largest_error": max((f.error or 0.0 for f in compared), default=0.0),
        }
        rows.append(row)
        print(", ".join(f"{name} {value}" for name, value in row.items()), flush=True)
    write(name, figure, rows)


if __name__ == "__main__":
    if sys.argv[1:2] == ["--cells"]:
        # a chain is asked what its steps are asked
        tabulate(sys.argv[2:] or [kind for kind in KINDS if kind != "chains of wheels"])
        sys.exit()
    if sys.argv[1:] != ["--draw"]:
        compare(int(sys.argv[1]) if len(sys.argv) > 1 else 20, sys.argv[2:] or list(KINDS))
    for name, kinds in MAPS.items():
        if own := [kind for kind in kinds if any(known_kind == kind for known_kind, _ in known())]:
            draw(name, own)
