# SPDX-License-Identifier: MIT OR Apache-2.0
"""Trials of derivatives where the pull follows the gap, a layer the pressure, or points stick."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
from trials import Array, Input, Trial, flowing, material, of_bodies

import mtb_rs as mtb

#: A ball of cells [m].
CELLS, CELL = 10, 1e-3


def ball(random: np.random.Generator) -> Array:
    """The gap of a rough ellipsoid."""
    x = (np.arange(CELLS) - 0.5 * (CELLS - 1)) * CELL
    a, b = random.uniform(0.4, 0.8, 2)
    return np.asarray(x[None, :] ** 2 / a + x[:, None] ** 2 / b + 3e-7 * random.random((CELLS, CELLS)))


def magnets(random: np.random.Generator) -> Trial:
    """A step of half-spaces that a magnet pulls together, with an iron of few corners."""
    limb = {"yoke": (random.uniform(0.1, 0.2), 3e-5), "armature": (random.uniform(0.05, 0.1), 3e-5)}
    magnet = mtb.Magnet(
        random.uniform(1e3, 3e3), random.uniform(1e-5, 1e-4), iron=((0.0, 1e2, 1e4), (0.0, 1.2, 2.0)),
        iron_share=random.uniform(1.0, 2.0), pole_length=random.uniform(0.0, 0.05),
        leakage=random.uniform(0.0, 1e-9), speed_factor=mtb.VelocityTable((0.0, 20.0), (1.0, 0.5)),
        **(limb if random.random() < 0.5 else {}),
    )  # fmt: skip
    scene = mtb.Scene(
        material(random), material(random), gap=ball(random), spacing=CELL, magnetic_pressure=magnet,
        attraction=random.choice(["upper", "both"]), friction=random.uniform(0.05, 0.4), velocity=5.0,
        sliding_direction=(1.0, random.uniform(-1.0, 1.0)),
    )  # fmt: skip
    contact = scene.prepare("half-space", standstill_speed=0.2)
    n = contact.area.size
    given: dict[str, Any] = {
        "pose": np.array([0.0, 0.0, np.nan, *random.uniform(-1e-5, 1e-5, 3)]),
        "velocity": random.uniform(1.0, 8.0) * np.array(scene.sliding_direction),
        "gap": 1e-7 * random.random(n),
        "friction_field": random.uniform(0.05, 0.4, n),
    }
    numbers = {
        name: np.array(getattr(magnet, name)) for name in ("ampere_turns", "non_magnetic_gap", "iron_share")
    }
    numbers |= {name: np.array(getattr(magnet, name)) for name in limb if getattr(magnet, name) is not None}

    def solved(name: str, e: Array) -> Any:
        changed = dict(given)
        if name in changed:
            changed[name] = changed[name] + e
        own = magnet
        if name in numbers:
            value = numbers[name] + e
            own = replace(magnet, **{name: tuple(value) if value.ndim else float(value)})
        pose, velocity = changed.pop("pose"), changed.pop("velocity")
        return contact.copy().step(
            pose, tuple(velocity), gap=changed["gap"], friction=changed["friction_field"],
            magnetic_pressure=own,
        )  # fmt: skip

    sizes = {"pose": 1e-5, "velocity": 4.0, "gap": 1e-6, "friction_field": 0.3}
    inputs = {
        name: Input(np.shape(value), sizes[name], lambda e, n=name: solved(n, e))
        for name, value in given.items()
    }
    for name, value in numbers.items():
        inputs[f"magnetic_pressure.{name}"] = Input(value.shape, value, lambda e, n=name: solved(n, e))
    # pulls are found to 1e-10, and the iron has corners
    return Trial(solved("", np.zeros(())), inputs, 1e-3, has_kinks=True)


def rough_layers(random: np.random.Generator) -> Trial:
    """A normal contact with a rough layer, on a surface that turns where both bodies are alike."""
    length = random.uniform(1e-7, 6e-7)
    layer = mtb.RoughLayer.exponential(random.uniform(2e9, 8e9), length)
    if random.random() < 0.5:
        share = np.cumsum(random.uniform(0.5, 1.5, 5))
        heights = 12.0 * length * (1.0 - np.array([0.0, *share / (share[-1] + 1.0)]))
        layer = mtb.RoughLayer(heights, [0.0, 1e6, 2e7, 2e8, 2e9, 2e10])
    body = material(random)
    given: dict[str, Any] = {"gap": ball(random), "upper": body, "lower": body, "normal_layer": layer}
    if random.random() < 0.5:
        given["inclination"] = random.uniform(0.1, 0.4) * np.linspace(-1.0, 1.0, CELLS)
    else:
        given["lower"] = material(random)
        if random.random() < 0.5:
            given["moments_about_axes"] = tuple(random.uniform(-0.2, 0.2, 2))
    way = "force" if "moments_about_axes" in given or random.random() < 0.5 else "approach"
    given[way] = random.uniform(5e2, 2e3) if way == "force" else 8e-6

    def solved(changed: dict[str, Any]) -> Any:
        return mtb.solve_normal(
            **{"spacing": CELL, "tolerance": 1e-13, "method": "fft", "edge": "sharp"} | changed
        )

    sizes = {"gap": 1e-6, "approach": 8e-6, "force": 1e3, "moments_about_axes": 0.3}

    def moved(name: str, e: Array) -> Any:
        value = np.asarray(given[name]) + e
        # a field, a pair, a number
        return solved(given | {name: (float, tuple, np.asarray)[value.ndim](value)})

    inputs = {
        name: Input(np.shape(given[name]), size, lambda e, n=name: moved(n, e))
        for name, size in sizes.items()
        if name in given
    }
    for name, size in (("gap", 1e-2 * length), ("pressure", 1e-2 * np.array(layer.pressure))):
        known = np.array(getattr(layer, name))
        inputs[f"normal_layer.{name}"] = Input(
            known.shape, size,
            lambda e, n=name, k=known: solved(given | {"normal_layer": replace(layer, **{n: k + e})}),
        )  # fmt: skip
    if "inclination" not in given:
        # a surface that turns is one of bodies of one material
        inputs |= dict(of_bodies(given, solved))
    # where a pressure passes one of the table, the law has a corner
    return Trial(solved(given), inputs, has_kinks=True)


def sticking(random: np.random.Generator) -> Trial:
    """A step with a shift after another one, by all that it was given and by what the one before left."""
    pulled = random.random() < 0.5
    load = {"magnetic_pressure": random.uniform(5e6, 2e7)} if pulled else {"force": random.uniform(5e2, 3e3)}
    scene = mtb.Scene(
        material(random), material(random), gap=ball(random), spacing=CELL, **load,
        friction=random.uniform(0.1, 0.4), sliding_direction=(1.0, 0.0),
    )  # fmt: skip
    contact = scene.prepare("half-space", reference_point=(0.01, 0.0, 0.02))
    n = contact.area.size
    start = contact.step(velocity=1.0)
    # on the way to where all points slip
    far = abs(float(start.force[0])) / (2e11 * 4e-3)
    given: dict[str, Any] = {
        "shift": far * random.uniform(-1.0, 1.0, 2),
        "pose": np.array([0.0, 0.0, np.nan, *random.uniform(-1e-6, 1e-6, 3)]),
        "gap": 1e-8 * random.random(n),
        "friction_field": scene.friction * random.uniform(0.9, 1.1, n),
    }
    if pulled:
        given["magnetic_pressure"] = load["magnetic_pressure"] * random.uniform(0.9, 1.1)
    before = start.state
    left = {f"state.{name}": getattr(before, name) for name in ("traction", "pressure", "rigid_displacement")}

    def solved(name: str, e: Array) -> Any:
        now = {key: value + e if key == name else value for key, value in given.items()}
        state = replace(before, **{name[6:]: left[name] + e}) if name in left else before
        return contact.copy().step(
            now["pose"], 1.0, shift=tuple(now["shift"]), gap=now["gap"], friction=now["friction_field"],
            magnetic_pressure=float(now["magnetic_pressure"]) if pulled else None, state=state, dt=1e-3,
        )  # fmt: skip

    sizes = {"shift": 1e-6, "pose": 1e-6, "gap": 1e-6, "friction_field": 0.3, "magnetic_pressure": 1e7}
    sizes |= {"state.traction": 1e8, "state.pressure": 5e8, "state.rigid_displacement": 1e-6}
    inputs = {
        name: Input(
            np.shape(value), sizes[name], lambda e, n=name: solved(n, e),
            np.broadcast_to(before.pressure > 0.0, np.shape(value)) if name in left else True,
        )
        for name, value in (given | left).items()
    }  # fmt: skip

    def prepared(changed: mtb.Scene) -> Any:
        """The same step of bodies of other moduli."""
        anew = changed.prepare("half-space", reference_point=(0.01, 0.0, 0.02))
        return anew.step(
            given["pose"], 1.0, shift=tuple(given["shift"]), gap=given["gap"],
            friction=given["friction_field"],
            magnetic_pressure=float(given["magnetic_pressure"]) if pulled else None, state=before, dt=1e-3,
        )  # fmt: skip

    inputs |= dict(of_bodies(scene, prepared))
    # tractions are found to 1e-11
    return Trial(solved("", np.zeros(())), inputs, 1e-3)


def heated(random: np.random.Generator) -> Trial:
    """Steady rolling whose friction falls with the temperature, at once or by a memory, coupled or not."""
    spacing = 6e-4
    coupled = random.random() < 0.3
    given: dict[str, Any] = {"upper": material(random), "lower": material(random)}
    if coupled:
        spacing = CELL
        given |= {"gap": ball(random), "normal_force": random.uniform(5e2, 2e3)}
    else:
        x = (np.arange(CELLS) - 0.5 * (CELLS - 1)) * spacing
        inside = 1.0 - (x[None, :] / 3e-3) ** 2 - (x[:, None] / random.uniform(2e-3, 3e-3)) ** 2
        given["pressure"] = random.uniform(4e8, 9e8) * np.sqrt(np.maximum(inside, 0.0))

    def metal() -> mtb.Conductor:
        return mtb.Conductor(random.uniform(30, 60), random.uniform(7e3, 8e3), random.uniform(4e2, 6e2))

    mu = random.uniform(0.2, 0.4)
    friction = mtb.TemperatureFriction(
        [0.0, random.uniform(150.0, 250.0), 600.0],
        [mu, random.uniform(0.7, 0.9) * mu, 0.5 * mu],
        metal(),
        metal(),
        bulk=tuple(random.uniform(5.0, 60.0, 2)),
        memory=random.uniform(5e-6, 5e-5) if random.random() < 0.4 else None,
        memory_min_slip=random.uniform(1e-2, 0.1),
    )
    motion = mtb.Rolling(
        (*random.uniform(-8e-3, 8e-3, 2), random.uniform(-0.4, 0.4)),
        force=(0.1 * 5e2, None) if coupled and random.random() < 0.5 else None,
        angle=random.choice([0.0, random.uniform(0.1, 1.4)]),
        velocity=random.uniform(5.0, 40.0),
        step=random.uniform(0.6, 1.4) * spacing,
    )
    given |= {"motion": motion, "friction": friction}
    if random.random() < 0.3:
        given["layer"] = mtb.InterfaceLayer(2e-5, 1e9)

    def solved(g: dict[str, Any]) -> Any:
        bodies = {"lower": g["lower"], "upper": g["upper"]}
        if coupled:
            pressed = mtb.solve_normal(
                g["gap"], spacing, force=g["normal_force"], tolerance=1e-13, edge="sharp", **bodies
            )
        else:
            pressed = mtb.PressureField(g["pressure"], (spacing, spacing), **bodies)
        return mtb.solve_tangential(
            pressed, g["motion"], g["friction"], g.get("layer"), tolerance=1e-12,
            coupling="full" if coupled else "one-way",
        )  # fmt: skip

    inputs = dict(of_bodies(given, solved))
    for name, size in (("gap", 1e-6), ("normal_force", 1e3), ("pressure", 5e8)):
        if name in given:
            value = given[name]
            inputs[name] = Input(
                np.shape(value), size, lambda e, n=name, v=value: solved(given | {n: v + e}),
                value > 0.0 if name == "pressure" else True,
            )  # fmt: skip
    half_cells = 2.0 / spacing * np.array(motion.step_vector((spacing, spacing)))
    off = np.abs(half_cells - np.round(half_cells))
    # widths are small beside the way to where a step ends on a border or middle of a cell
    away = min(1.0, 50.0 * float(off.min() if motion.angle else off[0]))
    sizes = {"creepage": 1e-3, "velocity": 10.0, "step": spacing * away}
    if motion.angle:
        # along the rows the heat of a cell has a kink, as a step is one of whole cells across
        sizes["angle"] = 0.1 * away
    for name, size in sizes.items():
        value = np.array(getattr(motion, name))
        inputs[name] = Input(
            value.shape, size,
            lambda e, n=name, v=value: solved(
                given | {"motion": replace(motion, **{n: tuple(v + e) if v.ndim else float(v + e)})}
            ),
        )  # fmt: skip

    def with_friction(**changed: Any) -> Any:
        return solved(given | {"friction": replace(friction, **changed)})

    for name in ("coefficient", "temperature", "bulk", "memory", "memory_min_slip"):
        if (value := getattr(friction, name)) is None:
            continue
        value = np.array(value)
        size = np.maximum(np.abs(value), 10.0) if name in ("temperature", "bulk") else value
        inputs[f"friction.{name}"] = Input(
            value.shape, size,
            lambda e, n=name, v=value: with_friction(**{n: list(v + e) if v.ndim else float(v + e)}),
        )  # fmt: skip
    for side in ("lower", "upper"):
        body = getattr(friction, side)
        for name in ("conductivity", "density", "specific_heat"):
            value = getattr(body, name)
            inputs[f"friction.{side}.{name}"] = Input(
                (), value,
                lambda e, s=side, b=body, n=name, v=value: with_friction(
                    **{s: replace(b, **{n: v + float(e)})}
                ),
            )  # fmt: skip

    def state(result: Any) -> bytes:
        """What sticks and slips, and between which points of the table and of the memory a cell is."""
        warm = result.temperature(**friction.surfaces).temperature_lower
        places = np.searchsorted(friction.temperature, warm[result.pressure > 0.0])
        slips = motion.velocity * np.hypot(*result.slip) > friction.memory_min_slip
        return flowing(result) + places.tobytes() + slips.tobytes()

    return Trial(solved(given), inputs, state=state)


def creeping(random: np.random.Generator) -> Trial:
    """Normal contacts and steady rolling of bodies that creep, coupled or not."""
    spacing, speed = CELL, random.uniform(0.5, 5.0)
    tread = mtb.Viscoelastic(
        mtb.Material(random.uniform(1e9, 5e9), random.uniform(0.1, 0.45)),
        random.uniform(0.3, 2.0),
        random.uniform(0.5, 5.0) * spacing / speed,
    )
    other: Any = (material(random), mtb.Rigid(), replace(tread, creep=random.uniform(0.1, 1.0)))[
        random.integers(3)
    ]
    given: dict[str, Any] = {"upper": other, "lower": tread}
    if random.random() < 0.5:
        given = {"upper": tread, "lower": other}
    given |= {"gap": ball(random), "force": random.uniform(10.0, 30.0)}
    given["rolling"] = mtb.Rolling(
        (*random.uniform(-8e-3, 8e-3, 2), random.uniform(-0.4, 0.4)), angle=random.uniform(0.1, 1.4),
        velocity=speed, step=random.uniform(0.6, 1.4) * spacing,
    )  # fmt: skip
    return of_compound(random, given, spacing)


def layered(random: np.random.Generator) -> Trial:
    """Shifts and rolling on layers, coupled, and pressures on them."""
    layer = mtb.Layered(material(random), random.uniform(1.0, 4.0) * CELL, material(random))
    given: dict[str, Any] = {"upper": material(random), "lower": layer}
    if random.random() < 0.5:
        given = {"upper": layer, "lower": material(random)}
    given |= {"gap": ball(random), "force": random.uniform(5e2, 2e3)}
    kind = random.integers(3)
    given["rolling"] = mtb.Rolling(
        (*random.uniform(-2e-3, 2e-3, 2), random.uniform(-0.4, 0.4)), angle=random.uniform(0.1, 1.4),
        step=random.uniform(0.6, 1.4) * CELL, transient=bool(kind == 1),
    )  # fmt: skip
    if kind == 2:
        given["rolling"] = mtb.Shift(tuple(random.uniform(-2e-6, 2e-6, 2)), spin=random.uniform(-1e-4, 1e-4))
    return of_compound(random, given, CELL)


def of_compound(random: np.random.Generator, given: dict[str, Any], spacing: float) -> Trial:
    """A contact of bodies that are no half-spaces of one material."""
    way = ("normal", "one-way", "full", "full")[random.integers(4)]
    if way != "normal":
        given["friction"] = mtb.Coulomb(random.uniform(0.1, 0.4))
    if random.random() < 0.3:
        given["normal_layer"] = 1e-3 / given["force"] * spacing**2 * random.uniform(0.3, 1.0)
    rolling, creeps = given["rolling"], any(isinstance(given[s], mtb.Viscoelastic) for s in SIDES)
    given_to_normal = ("gap", "force", "normal_layer") if way == "one-way" else ()

    def pressed(g: dict[str, Any]) -> Any:
        return mtb.solve_normal(
            g["gap"], spacing, lower=g["lower"], upper=g["upper"], force=g["force"], tolerance=1e-13,
            edge="sharp", method="dense", normal_layer=g.get("normal_layer", 0.0),
            rolling=g["rolling"] if creeps else None,
        )  # fmt: skip

    at = pressed(given)

    def solved(g: dict[str, Any]) -> Any:
        if way == "normal":
            return pressed(g)
        normal = at if way == "one-way" else pressed(g)
        if way == "one-way":
            sides = {side: None if isinstance(g[side], mtb.Rigid) else g[side] for side in SIDES}
            normal = mtb.PressureField(g.get("pressure", at.pressure), (spacing, spacing), **sides)
        return mtb.solve_tangential(
            normal,
            g["rolling"],
            g["friction"],
            tolerance=1e-12,
            coupling="full" if way == "full" else "one-way",
        )

    if way == "one-way":
        given["pressure"] = np.array(at.pressure)
    inputs = dict(of_bodies(given, solved))
    sizes = {"gap": 1e-6, "force": given["force"], "normal_layer": given.get("normal_layer", 0.0)}
    sizes["pressure"] = float(at.pressure.max())
    for name, size in sizes.items():
        if name not in given or name in given_to_normal:
            continue
        value = given[name]
        by = "normal_force" if name == "force" and way == "full" else name
        inputs[by] = Input(
            np.shape(value), size, lambda e, n=name, v=value: solved(given | {n: v + e}),
            value > 0.0 if name == "pressure" else True,
        )  # fmt: skip
    away = 1.0
    if isinstance(rolling, mtb.Rolling):
        half_cells = 2.0 / spacing * np.array(rolling.step_vector((spacing, spacing)))
        away = min(1.0, 50.0 * float(np.abs(half_cells - np.round(half_cells)).min()))
    moving = {
        "creepage": 1e-3, "velocity": 0.3 * rolling.slip_speed, "step": spacing * away, "angle": 0.02 * away,
        "displacement": 1e-6, "spin": 1e-4,
    }  # fmt: skip
    for name, size in moving.items():
        if (value := getattr(rolling, name, None)) is None:
            continue
        value = np.array(value)
        by = f"rolling.{name}" if way == "normal" else name
        inputs[by] = Input(
            value.shape, size,
            lambda e, n=name, v=value: solved(
                given | {"rolling": replace(rolling, **{n: tuple(v + e) if v.ndim else float(v + e)})}
            ),
        )  # fmt: skip
    if way != "normal":
        mu = given["friction"].coefficient
        inputs["friction"] = Input((), mu, lambda e: solved(given | {"friction": mtb.Coulomb(mu + float(e))}))
    return Trial(solved(given), inputs)


#: Of the bodies.
SIDES = ("lower", "upper")
