# SPDX-License-Identifier: MIT OR Apache-2.0
"""The table ``[wear]`` of a case file: over which way, and by which laws."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from ..base.check import positive
from ..friction.wear_laws import Archard, EnergyWear, WearLaw, WearMap
from ..studies.wear import Passages
from .looks import NUMBERS, POSITIVE, check_keys, table

#: Laws by the keys of their tables, with what makes them.
_LAWS: dict[frozenset[str], Callable[..., WearLaw]] = {
    frozenset({"k", "hardness"}): lambda k, hardness: Archard.of_hardness(k, hardness),
    frozenset({"wheel_steel_map"}): lambda wheel_steel_map: WearMap.of_wheel_steel(wheel_steel_map),
    frozenset({"wheel_steel_energy"}): lambda wheel_steel_energy: EnergyWear.of_wheel_steel(
        wheel_steel_energy
    ),
    frozenset({"hardness", "k", "pressure", "speed"}): lambda **given: WearMap(**given),
    frozenset({"energy", "rate", "density"}): lambda **given: EnergyWear(**given),
}

#: What a law looks like to an editor.
LAW = {
    "anyOf": [
        {"type": "number", "minimum": 0},
        table(["k", "hardness"], k=POSITIVE, hardness=POSITIVE),
        table(["wheel_steel_map"], wheel_steel_map=POSITIVE),
        table(["wheel_steel_energy"], wheel_steel_energy=POSITIVE),
        table(
            ["hardness", "k", "pressure", "speed"],
            hardness=POSITIVE,
            k={"type": "array", "items": NUMBERS},
            pressure=NUMBERS,
            speed=NUMBERS,
        ),
        table(["energy", "rate", "density"], energy=NUMBERS, rate=NUMBERS, density=POSITIVE),
    ],
    "description": "Wear coefficient [1/Pa]; or k and hardness [Pa]; or a map or a table of energies.",
}
_PASSAGES = {
    "type": "object",
    "required": ["distance"],
    "properties": {"distance": POSITIVE, "count": POSITIVE},
    "description": "Passages over the same rail; other keys are arguments of the scene during them.",
}
#: What the table looks like to an editor.
LOOK = table(
    ["law"],
    distance=POSITIVE | {"description": "Sliding distance [m], both bodies worn where they touch."},
    passages={"type": "array", "items": _PASSAGES, "minItems": 1},
    law=LAW,
    lower_law=LAW,
    tolerance={"type": "number", "exclusiveMinimum": 0, "exclusiveMaximum": 1},
    uniformity={"type": "number", "exclusiveMinimum": 0, "maximum": 1},
    limit=POSITIVE,
) | {"oneOf": [{"required": ["distance"]}, {"required": ["passages"]}]}


def wear_of(given: Any) -> dict[str, Any]:
    """The arguments of :func:`mtb_rs.wear`, but for the contact, that the table means."""
    if not isinstance(given, Mapping):
        raise ValueError("a table with distance or passages, and law, is needed")
    check_keys(given, LOOK)
    if ("distance" in given) == ("passages" in given):
        raise ValueError("one of distance [m] and passages is needed")
    if "law" not in given:
        raise ValueError("law is missing: a wear coefficient [1/Pa] or a table is needed")
    found: dict[str, Any] = {
        name: law_of(name, given[name]) for name in ("law", "lower_law") if name in given
    }
    if "distance" in given:
        found["distance"] = positive("distance", given["distance"], "m")
    else:
        parts = given["passages"]
        if not isinstance(parts, (list, tuple)) or not parts:
            raise ValueError("passages is no list of tables, each with a distance")
        found["distance"] = [_passages(part) for part in parts]
    numbers = ("tolerance", "uniformity", "limit")
    return found | {name: positive(name, given[name]) for name in numbers if name in given}


def law_of(name: str, given: Any) -> WearLaw:
    """The law that a number or a table means; ValueError, which calls it `name`, for another."""
    if not isinstance(given, Mapping):
        if isinstance(given, bool) or not isinstance(given, (int, float)):
            raise ValueError(f"{name} is {given!r}: a wear coefficient [1/Pa] or a table is needed")
        return Archard(float(given))
    make = _LAWS.get(frozenset(given))
    if make is None:
        ways = "; ".join(", ".join(sorted(keys)) for keys in _LAWS)
        raise ValueError(f"{name} has the keys {', '.join(map(str, given))}: these go together: {ways}")
    return make(**given)


def _passages(given: Any) -> Passages:
    if not isinstance(given, Mapping) or "distance" not in given:
        raise ValueError("passages: a table with distance [m], and count, is needed")
    changes = {key: value for key, value in given.items() if key not in ("distance", "count")}
    return Passages(given["distance"], given.get("count", 1.0), changes)
