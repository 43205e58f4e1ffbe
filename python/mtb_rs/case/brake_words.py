# SPDX-License-Identifier: MIT OR Apache-2.0
"""The table ``[brake]`` of a case file: which vehicle stops, by how many shoes, with which heat and wear."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
from pydantic import BaseModel, ConfigDict, Field, create_model

from ..base.check import not_negative, number, pair, positive, shortened
from ..bodies.conductor import Conductor
from ..friction.fields import VelocityTable
from ..scenes.heating import check_tolerance, fading_of, film_of, share_of
from ..scenes.scene import Scene
from ..studies.brake import brake, pulls_of
from .looks import NOT_NEGATIVE, NUMBER, NUMBERS, POSITIVE, check_keys, table
from .values import described, read_by
from .wear_words import LAW, law_of

_PAIR = {**NUMBERS, "minItems": 2, "maxItems": 2}
#: What a conductor looks like to an editor.
CONDUCTOR = table(
    ["conductivity", "density", "specific_heat"],
    **dict.fromkeys(("conductivity", "density", "specific_heat"), POSITIVE),
    **dict.fromkeys(("expansion", "conductivity_slope", "expansion_slope"), NUMBER),
)


def _keys(given: Any, look: dict[str, Any]) -> Mapping[str, Any]:
    """A table whose keys are those of its JSON schema; ValueError for another."""
    if not isinstance(given, Mapping):
        raise ValueError(f"a table of {', '.join(look['properties'])} is needed")
    check_keys(given, look)
    needed = look["required"]
    missing = [name for name in needed if name not in given]
    if missing:
        raise ValueError(f"{missing[0]} is missing: {', '.join(needed)} are needed")
    return given


def conductor_of(given: Any) -> Conductor:
    """The conductor that a table means."""
    return Conductor(**_keys(given, CONDUCTOR))


_OVER_SPEED = table(["velocity", "value"], velocity=NUMBERS, value=NUMBERS)


@dataclass(frozen=True)
class _OverSpeed:
    """A force [N] over the speed [m/s], as :func:`mtb_rs.brake` calls it."""

    velocity: tuple[float, ...]
    value: tuple[float, ...]

    def __call__(self, speed: float) -> float:
        slower, faster, weight = VelocityTable(self.velocity, self.value).bracket(speed)
        return float((1.0 - weight) * slower + weight * faster)


def _force(given: Any) -> float | _OverSpeed:
    if not isinstance(given, Mapping):
        return not_negative("other_force", given, "N")
    table = VelocityTable(**_keys(given, _OVER_SPEED))
    if table.velocity[0] > 0.0:
        raise ValueError(
            f"velocity[0] is {table.velocity[0]:g} m/s: a stop goes down to standstill, so that a table from "
            "0 m/s on is needed"
        )
    values = tuple(not_negative("other_force", value, "N") for value in table.value)
    return _OverSpeed(tuple(table.velocity), values)


def _tolerance(given: Any) -> float:
    check_tolerance("tolerance", number("tolerance", given))
    return float(given)


def _shares(given: Any) -> list[float]:
    if not isinstance(given, (list, tuple)):
        raise ValueError(f"shares is {shortened(given)}: a list, a positive number for each shoe, is needed")
    return [float(share) for share in pulls_of(given)]


def _truth(given: Any) -> bool:
    if not isinstance(given, bool):
        raise ValueError("true or false is needed")
    return given


def _fading(given: Any) -> list[list[float]]:
    return [np.asarray(row).tolist() for row in fading_of(given)]


#: What reads each word, and what it looks like to an editor.
_WORDS: dict[str, tuple[Callable[[Any], Any], dict[str, Any]]] = {
    "speed": (lambda given: positive("speed", given, "m/s"), POSITIVE),
    "mass": (lambda given: positive("mass", given, "kg"), POSITIVE),
    "other_force": (_force, {"anyOf": [NOT_NEGATIVE, _OVER_SPEED]}),
    "shares": (_shares, {"type": "array", "items": POSITIVE, "minItems": 1}),
    "tolerance": (_tolerance, {**POSITIVE, "exclusiveMaximum": 1}),
    "lower": (conductor_of, CONDUCTOR),
    "upper": (conductor_of, CONDUCTOR),
    "bulk": (lambda given: pair("bulk", given, "K"), _PAIR),
    "film": (film_of, _PAIR),
    "resistance": (lambda given: not_negative("resistance", given, "K m2/W"), NOT_NEGATIVE),
    "share": (share_of, {**NOT_NEGATIVE, "maximum": 1}),
    "expansion": (_truth, {"type": "boolean"}),
    "wear": (partial(law_of, "wear"), LAW),
    "lower_wear": (partial(law_of, "lower_wear"), LAW),
    "fading": (_fading, {"type": "array", "items": NUMBERS, "minItems": 2, "maxItems": 2}),
}


def _model(said: Mapping[str, str]) -> type[BaseModel]:
    fields: dict[str, Any] = {
        name: (
            read_by(function, look),
            Field(... if name in ("speed", "mass") else None, description=said[name]),
        )
        for name, (function, look) in _WORDS.items()
    }
    return create_model(
        "BrakeWords", __config__=ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False), **fields
    )


#: The table: its words are arguments of :func:`mtb_rs.brake`.
BrakeWords = _model({**described(Scene.sliding_heat), **described(brake)})


def brake_of(words: BaseModel) -> dict[str, Any]:
    """The arguments of :func:`mtb_rs.brake`, but for the scene, that were given."""
    return {name: value for name, value in words if name in words.model_fields_set}
