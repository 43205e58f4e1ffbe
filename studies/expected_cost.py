# SPDX-License-Identifier: MIT OR Apache-2.0
"""How near are the counts and the times of `Scene.expected_cost` to those of the solve?

Blocks, shoes and rails, symmetric ones of which one half is factorised and others; of each body what was
counted beside what the condensation did, of each scene the time that was told beside the one it took. The
constants of mtb_rs.scenes.cost are from this table.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

import mtb_rs as mtb
from mtb_rs.base import cache
from mtb_rs.bodies.elastic_body import Condensed, ElasticBody
from mtb_rs.scenes import cost

block, shoe = mtb.scenes.block_on_plane, mtb.scenes.pole_shoe_on_rail
#: Held at two sides: no mirror image of itself.
ASKEW = (mtb.Support("top", x=0.0, y=0.0), mtb.Support("left", z=0.0), mtb.Support("rear", y=0.0))
SCENES: dict[str, tuple[mtb.Scene, Any]] = {
    "paraboloid": (mtb.scenes.paraboloid_on_plane(points=50), "half-space"),
    "paraboloid, by convolutions": (mtb.scenes.paraboloid_on_plane(points=200), "half-space"),
    "paraboloid, fine": (mtb.scenes.paraboloid_on_plane(points=512), "half-space"),
    "cube as a half-space": (block(0.1, 0.1, 0.3, spacing=2e-3), "half-space"),
    "shoe as a half-space": (shoe(spacing=(2e-3, 1.2e-3), friction=0.3), "half-space"),
    "shoe of many points": (shoe(spacing=0.6e-3, friction=0.3), "elastic-upper"),
    "shoe on rail, choice": (shoe(spacing=3e-3, friction=0.3), "auto"),
    "thick block": (block(0.04, 0.03, 0.3, spacing=0.8e-3, length=0.03), "elastic-upper"),
    "cube": (block(0.1, 0.1, 0.3, spacing=3e-3), "elastic-upper"),
    "cube, wide": (block(0.1, 0.1, 0.3, spacing=6e-3), "elastic-upper"),
    "flat block": (block(0.05, 0.01, 0.3, spacing=1.2e-3), "elastic-upper"),
    "cube, askew": (block(0.1, 0.1, 0.3, spacing=4e-3, supports=ASKEW), "elastic-upper"),
    "flat block, askew": (block(0.05, 0.01, 0.3, spacing=1.5e-3, supports=ASKEW), "elastic-upper"),
    "bar": (block(0.15, 0.02, 0.3, spacing=1.5e-3, length=0.02), "elastic-upper"),
    "bar, askew": (block(0.15, 0.02, 0.3, spacing=1.5e-3, length=0.02, supports=ASKEW), "elastic-upper"),
    "shoe": (shoe(spacing=(4e-3, 2e-3), friction=0.3), "elastic-upper"),
    "shoe, fine": (shoe(spacing=(2e-3, 1.2e-3), friction=0.3), "elastic-upper"),
    "shoe, shifted": (shoe(spacing=3e-3, friction=0.3, lateral=1e-3), "elastic-upper"),
    "shoe on rail": (shoe(spacing=4e-3, friction=0.3), "elastic-both"),
    "shoe on rail, shifted": (shoe(spacing=4e-3, friction=0.3, lateral=1e-3), "elastic-both"),
}


def condensed(act: Callable[[], object]) -> list[tuple[ElasticBody, Condensed]]:
    """The bodies that are condensed while something is done."""
    found, condense = [], ElasticBody.condense

    def watched(self: ElasticBody, *given: Any) -> Condensed:
        result = condense(self, *given)
        found.append((self, result))
        return result

    ElasticBody.condense = watched  # type: ignore[method-assign,assignment]
    try:
        act()
    finally:
        ElasticBody.condense = condense  # type: ignore[method-assign]
    return found


def main() -> None:
    print("counted over done; time told and taken [s]")
    for name, (scene, model) in SCENES.items():
        with cache.memory_only():
            cache.forget()
            told = scene.expected_cost(model).costs[-1]
            cache.forget()
            clock = time.perf_counter()
            bodies = condensed(lambda scene=scene, model=model: scene.solve(model))  # type: ignore[misc]
            taken = time.perf_counter() - clock
        for body, found in bodies:
            own, done = cost._Elements(body, found.weights.size, ()), found.cost
            print(
                f"  {body.name:12} {own.points:5} points {body.unknowns:7} unknowns half {body.has_mirror:1}"
                f" entries {own.entries / done['factor_entries']:5.2f}"
                f" factor {own.factorising / done['factor_flops']:5.2f}"
                f" forward {own.substituting / done['forward_flops']:5.2f}"
                f" products {own.multiplying / done['product_flops']:5.2f}"
                f" at {1e-9 * done['factor_flops'] / max(done['numeric_s'], 1e-3):4.0f} Gflop/s"
            )
        print(f"{name:24} {told.time:7.1f} {taken:7.1f}  {told.time / taken:5.2f}", flush=True)


if __name__ == "__main__":
    main()
