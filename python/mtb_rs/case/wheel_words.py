# SPDX-License-Identifier: MIT OR Apache-2.0
"""The table ``[step_wheels]`` of a case file: pose, velocity and forces of the wheels of a scene."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, get_args

from pydantic import ValidationInfo

from ..base.check import choice, flag, number, numbers, one_or_two, positive, shortened
from ..base.words import Wheels
from .looks import NUMBER, NUMBERS, POSITIVE, check_keys, table
from .values import PROFILE_LOOK, WHEEL_FRICTION_LOOK, friction_of, profile_of

_SIX = {**NUMBERS, "minItems": 6, "maxItems": 6}
_PAIR = {**NUMBERS, "minItems": 2, "maxItems": 2}
#: Numbers with their units.
_UNITS = {
    "x": "m", "y": "m", "z": "m", "roll": "rad", "pitch": "rad", "yaw": "rad", "lateral_force": "N",
    "longitudinal_force": "N", "axle_moment": "N m", "curvature": "1/m",
}  # fmt: skip
#: Profiles on the right.
_RIGHT = ("right_wheel", "right_rail")
#: What the table looks like to an editor.
LOOK = table(
    ["velocity"],
    velocity={
        "anyOf": [NUMBER, _SIX],
        "description": "Speed [m/s], or velocity x, y, z and rotation about x, y, z [m/s], [rad/s].",
    },
    side={"enum": list(get_args(Wheels)), "description": "Which wheels; the left one by default."},
    **{name: {**NUMBER, "description": f"[{unit}]"} for name, unit in _UNITS.items()},
    rails={
        **table([], left=NUMBERS, right=NUMBERS),
        "description": "Rails beside their places: y, z [m], roll [rad], and maybe their rates.",
    },
    wheels={
        **table([], left=NUMBERS, right=NUMBERS),
        "description": "Wheels beside their places: x, y, z [m], roll, pitch, yaw [rad], and maybe rates.",
    },
    rail_stiffness={**_PAIR, "description": "Lateral and vertical [N/m]; inf where a rail does not move."},
    rail_force={**_PAIR, "description": "On each rail, outwards and upwards [N]."},
    standstill_speed={**POSITIVE, "description": "[m/s]"},
    conformal={"type": "boolean", "description": "Whether patches follow the rail; on planes by default."},
    order={"enum": [1, 2], "description": "Of the errors of rolling in the size of the cells; 1 by default."},
    **{
        name: {**PROFILE_LOOK, "description": "On the right, seen in a mirror; that of the scene by default."}
        for name in _RIGHT
    },
    right_wheel_radius={**POSITIVE, "description": "On the right [m]; that of the scene by default."},
    right_friction={**WHEEL_FRICTION_LOOK, "description": "On the right; that of the scene by default."},
)


def wheels_of(given: Any, info: ValidationInfo) -> dict[str, Any]:
    """The arguments of :func:`mtb_rs.step_wheels` that the table means."""
    if not isinstance(given, Mapping):
        raise ValueError("a table with velocity, and maybe a pose and forces, is needed")
    check_keys(given, LOOK)
    if "velocity" not in given:
        raise ValueError("velocity is missing: a number [m/s], or six numbers, is needed")
    found = dict(given)
    if isinstance(given["velocity"], (list, tuple)):
        numbers("velocity", given["velocity"], 6)
    else:
        number("velocity", given["velocity"], "m/s")
    if "side" in given:
        choice("side", given["side"], Wheels)
    for name in _UNITS.keys() & given.keys():
        number(name, given[name], _UNITS[name])
    for name in ("standstill_speed", "right_wheel_radius"):
        if name in given:
            positive(name, given[name], "m/s" if name == "standstill_speed" else "m")
    for name in _RIGHT:
        if name in given:
            found[name] = profile_of(given[name], info)
    if "right_friction" in given:
        found["right_friction"] = friction_of(given["right_friction"], info)
    if "conformal" in given:
        flag("conformal", given["conformal"])
    if "order" in given:
        one_or_two("order", given["order"])
    for name in ("rails", "wheels"):
        if name in given and not isinstance(given[name], Mapping):
            raise ValueError(f"{name} is {shortened(given[name])}: a table of left and right is needed")
    return found
