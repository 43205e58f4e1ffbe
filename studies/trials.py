# SPDX-License-Identifier: MIT OR Apache-2.0
"""What is tried of derivatives: a solved scene, what it was given, and how it is solved with other inputs."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

import mtb_rs as mtb

Array = NDArray[np.float64]
#: What is derived, by name: how it is asked for, its value in a result, its size.
Numbers = dict[str, tuple[Any, Callable[[Any], Array], float]]


@dataclass(frozen=True)
class Input:
    """What is given: its shape, its size, the result after a change of it, and where it may change."""

    shape: tuple[int, ...]
    size: Any
    solve: Callable[[Array], Any]
    where: Any = True


def flowing(result: Any) -> bytes:
    """The state of every point, and which are at the hardness."""
    hardness = getattr(result, "hardness", None)
    flows = b"" if hardness is None else (result.pressure >= hardness).tobytes()
    return bytes(np.asarray(result.status).tobytes() + flows)


@dataclass(frozen=True)
class Trial:
    """A solved scene, how it is solved with other inputs, and the steps of differences over their sizes.

    What is condensed, and steps that take the factors of another step, have fewer digits than other solves.
    `state` tells what has to stay the same; `numbers` what is derived, where it is not what other results
    have; `has_kinks` that differences of what is given have kinks of their own, as profiles have at stations.
    """

    result: Any
    inputs: dict[str, Input]
    width: float = 1e-4
    state: Callable[[Any], bytes] = flowing
    numbers: Numbers | None = None
    has_kinks: bool = False


def material(random: np.random.Generator) -> mtb.Material:
    return mtb.Material(random.uniform(60e9, 250e9), random.uniform(0.0, 0.45))


def of_bodies(owner: Any, solved: Callable[[Any], Any]) -> Iterator[tuple[str, Input]]:
    """Constants of the bodies of something that holds them."""
    for side in ("upper", "lower"):
        body = owner[side] if isinstance(owner, dict) else getattr(owner, side)
        for place, own in places(body):

            def at(e: Array, side: str = side, body: Any = body, place: str = place, own: float = own) -> Any:
                other = moved(body, place.split("."), own + float(e))
                return solved(
                    owner | {side: other} if isinstance(owner, dict) else replace(owner, **{side: other})
                )

            # parts of a body that is made of one material go by the names of their moduli
            name = place.removeprefix("material.").removeprefix("layer.")
            size = {"poisson_ratio": 3.0 if own < 0.4 else 1.0}.get(place.split(".")[-1], own)
            # a condensation has fewer digits than a solve
            yield f"{side}.{name}", Input((), size, at)


def places(body: Any) -> Iterator[tuple[str, float]]:
    """Where the constants of a body are, and their values."""
    if isinstance(body, mtb.Material):
        yield from ((name, getattr(body, name)) for name in ("young_modulus", "poisson_ratio"))
        return
    for part in ("material", "layer", "base"):
        of_part = getattr(body, part, None)
        # the material of a layered body is that of its layer
        if isinstance(of_part, mtb.Material) and not (part == "material" and hasattr(body, "layer")):
            yield from ((f"{part}.{name}", value) for name, value in places(of_part))
    for name in ("thickness", "creep", "creep_time"):
        if hasattr(body, name):
            yield name, getattr(body, name)


def moved(body: Any, place: list[str], value: float) -> Any:
    """A body with another value at a place."""
    name, *rest = place
    return replace(body, **{name: moved(getattr(body, name), rest, value) if rest else value})
