# SPDX-License-Identifier: MIT OR Apache-2.0
"""Trials of derivatives where the pull follows the gap, a layer the pressure, or points stick."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
from trials import Array, Input, Trial, material, of_bodies

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
