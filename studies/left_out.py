# SPDX-License-Identifier: MIT OR Apache-2.0
"""Does ``model="auto"`` leave out only what does not matter, and say by how much it would have?

Random scenes with a layer, a rough layer, a hardness or a magnet, of sizes that matter from not at all to a
lot, each with a random quantity and tolerance. The truth is the difference of two solutions of the scene on
its own cells, with the effect and without it, in the model that was chosen. The sizes are estimated with
the tolerance set aside, so that those that are kept can be compared too. Run from the root of the project:
``python studies/left_out.py 60`` takes 60 scenes of each kind; some minutes.
"""

from __future__ import annotations

import sys
import warnings
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from typing import Any

import numpy as np
from atlas import panels, write

import mtb_rs as mtb
from mtb_rs.bodies.mesh import block_mesh
from mtb_rs.scenes import direct
from mtb_rs.scenes.effects import EFFECTS, changed_by, without

QUANTITIES = ("pressure", "force", "displacement")
#: Estimates and truths below this [-] are nothing.
LEAST = 1e-9


@dataclass(frozen=True)
class Found:
    """An effect of a scene: its estimated and its true size, and whether a tolerance leaves it out."""

    kind: str
    effect: str
    model: str
    quantity: str
    tolerance: float
    estimate: float
    truth: float
    is_left_out: bool


def logarithmic(random: np.random.Generator, low: float, high: float) -> float:
    return float(np.exp(random.uniform(np.log(low), np.log(high))))


def effect(random: np.random.Generator, pressure: float, *, may_pull: bool) -> dict[str, Any]:
    """One of the effects, for contacts with about such a pressure [Pa]."""
    way = random.integers(4 if may_pull else 3)
    if way == 0:
        return {"normal_layer": logarithmic(random, 1e-17, 3e-14)}
    if way == 1:
        length = logarithmic(random, 1e-9, 3e-6)
        return {"normal_layer": mtb.RoughLayer.exponential(random.uniform(2.0, 20.0) * 1e9, length)}
    if way == 2:
        return {"hardness": pressure * logarithmic(random, 0.5, 30.0)}
    gap = logarithmic(random, 2e-5, 2e-3)
    return {"magnetic_pressure": mtb.Magnet(random.uniform(0.5, 1.5) * gap / 4e-7 / np.pi, gap)}


def material(random: np.random.Generator) -> mtb.Material:
    return mtb.Material(logarithmic(random, 5e9, 2.1e11), random.uniform(0.0, 0.4))


def ball(random: np.random.Generator) -> mtb.Scene:
    """A given gap between half-spaces, smooth or wavy."""
    cells, cell = int(random.integers(12, 30)), 1e-3
    x = (np.arange(cells) - 0.5 * (cells - 1)) * cell
    radius = random.uniform(0.3, 1.5)
    gap = (x[None, :] ** 2 + x[:, None] ** 2) / (2.0 * radius)
    if random.random() < 0.5:
        wave = 2.0 * np.pi / (cell * random.uniform(2.0, 8.0))
        gap = gap + logarithmic(random, 1e-7, 1e-6) * np.cos(wave * x[None, :]) * np.cos(
            0.7 * wave * x[:, None]
        )
    force = random.uniform(2e2, 2e3)
    return mtb.Scene(
        material(random), material(random), gap=gap, spacing=cell, force=force,
        friction=random.uniform(0.0, 0.3), **effect(random, 2e8, may_pull=False),
    )  # fmt: skip


def block(random: np.random.Generator) -> mtb.Scene:
    size = random.uniform(0.04, 0.1)
    return mtb.scenes.block_on_plane(
        width=size, height=random.uniform(0.3, 1.5) * size, spacing=size / int(random.integers(6, 11)),
        upper=material(random), lower=material(random), friction=random.uniform(0.0, 0.3),
        **{"magnetic_pressure": 3e6} | effect(random, 3e6, may_pull=True),
    )  # fmt: skip


def shoe(random: np.random.Generator) -> mtb.Scene:
    return mtb.scenes.pole_shoe_on_rail(
        spacing=random.uniform(7e-3, 1.1e-2), friction=random.uniform(0.05, 0.3),
        **{"magnetic_pressure": 3e6} | effect(random, 5e6, may_pull=True),
    )  # fmt: skip


def wheel(random: np.random.Generator) -> mtb.Scene:
    scene = mtb.scenes.wheel_on_rail(
        lateral=random.uniform(-2e-3, 2e-3), force=random.uniform(3e4, 9e4), spacing=1e-3
    )
    return scene.with_(**effect(random, 9e8, may_pull=False))


def own(random: np.random.Generator) -> mtb.Scene:
    """A body of one's own with a wavy or a tilted gap, above a half-space."""
    mesh = block_mesh(np.linspace(-0.04, 0.04, 9), np.linspace(-0.02, 0.02, 5), 0.03)
    body = mtb.ElasticBody(mesh, material(random), "bottom", [mtb.Support("top", x=0, y=0)])
    size, wave = logarithmic(random, 1e-8, 1e-6), random.uniform(30.0, 150.0)
    given = effect(random, 3e6, may_pull=True)
    load = {} if "magnetic_pressure" in given else {"force": random.uniform(3e3, 3e4)}
    return mtb.Scene(
        body, material(random), gap=lambda x, y: size * (1.0 + np.sin(wave * x)), spacing=1e-2,
        friction=random.uniform(0.0, 0.3), **given, **load,
    )  # fmt: skip


KINDS: dict[str, Callable[[np.random.Generator], mtb.Scene]] = {
    "given gap": ball, "block": block, "pole shoe": shoe, "wheel": wheel, "own body": own,
}  # fmt: skip


def found(kind: str, seed: int) -> Found | None:
    """One scene; None where it has no solution, or its effect no size to estimate."""
    warnings.simplefilter("ignore")
    random = np.random.default_rng([seed, sum(map(ord, kind))])
    quantity = QUANTITIES[random.integers(3)]
    tolerance = logarithmic(random, 5e-3, 0.1)
    try:
        scene = KINDS[kind](random)
        choice = direct.choose(scene, tolerance, quantity)
        judged = direct.effects_needed(scene, choice, tolerance, quantity, (), free=False)
        anyhow = direct.effects_needed(
            scene, direct.given(scene, choice.model), 1e9, quantity, (), free=False
        )
        if not anyhow.omitted:
            return None
        (name,) = anyhow.omitted
        spacing = scene.known_spacing
        full = direct.level_at(scene, choice.model, spacing)
        other = without(scene, [name], full)
        assert other is not None
        truth = changed_by(
            direct.level_at(other, choice.model, spacing),
            full,
            quantity,
        )
    except (ValueError, mtb.ConvergenceError):
        return None
    left = name in judged.omitted
    if name == "hardness" and left:
        # what the solve itself sees: a pressure of the fine cells that reaches it brings it back
        left = "hardness" in scene.solve(tolerance=tolerance, quantity=quantity).report.omitted
    estimate = anyhow.omitted[name]
    return Found(kind, EFFECTS[name], choice.model, quantity, tolerance, estimate, truth, left)


def main(whole: int) -> None:
    with ProcessPoolExecutor() as pool:
        waiting = {kind: [pool.submit(found, kind, seed) for seed in range(whole)] for kind in KINDS}
        all_of = {kind: [one.result() for one in waiting[kind]] for kind in KINDS}
    figure, (axes,) = panels(1, 1, 4.5)
    rows = []
    for k, (kind, given) in enumerate(all_of.items()):
        known = [f for f in given if f is not None]
        out = [f for f in known if f.is_left_out]
        kept = [f for f in known if not f.is_left_out]
        places = [(max(f.estimate, LEAST), max(f.truth, LEAST)) for f in known]
        if places:
            axes.loglog(*np.transpose(places), ".", color=f"C{k}", label=kind, markersize=4)
        sized = [f for f in out if f.truth > LEAST]
        ratios = [f.truth / max(f.estimate, LEAST) for f in sized]
        row = {
            "kind": kind,
            "scenes": len(given),
            "judged": len(known),
            "left_out": len(out),
            "beyond_tolerance": sum(f.truth > f.tolerance for f in out),
            "least_ratio": min(ratios, default=np.nan),
            "largest_ratio": max(ratios, default=np.nan),
            "kept": len(kept),
            "kept_without_need": sum(f.truth < 0.5 * f.tolerance for f in kept),
        }
        rows.append(row)
        print(", ".join(f"{name} {value}" for name, value in row.items()), flush=True)
        for f in sized:
            if not 1 / 3 < f.truth / max(f.estimate, LEAST) < 3 or f.truth > f.tolerance:
                print("   ", f, flush=True)
    ends = np.array([LEAST, 10.0])
    axes.loglog(ends, ends, "k-", linewidth=0.8)
    axes.fill_between(ends, ends / 3, 3 * ends, color="0.9", zorder=0)
    axes.set(xlabel="estimated change", ylabel="true change")
    axes.legend()
    write("left_out", figure, rows)


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 10)
