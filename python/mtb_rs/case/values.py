# SPDX-License-Identifier: MIT OR Apache-2.0
"""What the values of a case file mean, and what they look like to an editor."""

from __future__ import annotations

import inspect
import math
import re
import typing
from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any

import numpy as np
from pydantic import (
    BaseModel,
    ConfigDict,
    Field,
    PlainValidator,
    StrictFloat,
    StrictInt,
    StrictStr,
    ValidationInfo,
    WithJsonSchema,
    model_validator,
)

from ..base.check import choice, path_of, reals, shortened
from ..base.words import Held, Interpolation, Unit, ZAxis
from ..bodies.material import Material
from ..bodies.simple import Rigid
from ..friction.field_table import FieldTable, table_from_file
from ..friction.fields import GaussianPressure, VelocityTable
from ..friction.laws import InterfaceLayer
from ..geometry.profiles import STANDARD_PROFILES, Profile
from ..half_space.tangential import Rolling, Shift


class MaterialWords(BaseModel):
    """An elastic material: Poisson's ratio and one of the two moduli [Pa]."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)
    poisson_ratio: StrictFloat
    young_modulus: StrictFloat | None = None
    shear_modulus: StrictFloat | None = None

    @model_validator(mode="after")
    def _is_a_material(self) -> MaterialWords:
        self.material()
        return self

    def material(self) -> Material:
        """The material meant."""
        if self.young_modulus is not None and self.shear_modulus is None:
            return Material(self.young_modulus, self.poisson_ratio)
        if self.shear_modulus is not None and self.young_modulus is None:
            return Material.from_shear_modulus(self.shear_modulus, self.poisson_ratio)
        raise ValueError("one of young_modulus and shear_modulus [Pa] is needed, not both")


def _body(given: Any, check: Any) -> Material | Rigid:
    if isinstance(given, (Material, Rigid)):
        return given
    if given == "rigid":
        return Rigid()
    if not isinstance(given, Mapping):
        raise ValueError('a table with a modulus and poisson_ratio, or "rigid", is needed')
    words: MaterialWords = check(given)
    return words.material()


def _field(given: Any, info: ValidationInfo) -> Any:
    """Friction or magnetic pressure: a number, one entry per pole, a table, a hill."""
    if isinstance(given, (bool, str)):
        raise ValueError("a number, a list with one entry per pole, or a table is needed")
    if isinstance(given, (int, float)):
        if not math.isfinite(given):
            raise ValueError("a finite number is needed")
        return float(given)
    if isinstance(given, (list, tuple)):
        return [_field(part, info) for part in given]
    if isinstance(given, (VelocityTable, FieldTable, GaussianPressure)):
        return given
    if isinstance(given, Mapping):
        keys = set(given)
        if keys == {"velocity", "value"}:
            return VelocityTable(_numbers("velocity", given["velocity"]), _field(_list(given["value"]), info))
        if keys == {"x", "y", "value"}:
            rows = [_numbers("a row of value", row) for row in _list(given["value"])]
            x, y = (np.array(_numbers(axis, given[axis])) for axis in "xy")
            return FieldTable(x, y, reals("value", rows))
        if keys == {"file"}:
            return table_from_file(
                (info.context or {}).get("directory", Path()) / path_of("file", given["file"])
            )
        if {"peak", "center", "sigma"} <= keys <= {"peak", "center", "sigma", "floor"}:
            return GaussianPressure(
                _number("peak", given["peak"]),
                _pair(given["center"]),
                _pair(given["sigma"]),
                _number("floor", given.get("floor", GaussianPressure.floor)),
            )
        raise ValueError(
            f"the keys {', '.join(sorted(keys)) or '(none)'} do not go together: velocity and value, or "
            "x, y and value, or file (a CSV with these columns), or peak, center, sigma and floor (a hill) "
            "are needed"
        )
    raise ValueError("a number, a list with one entry per pole, or a table is needed")


def _list(given: Any) -> list[Any]:
    if not isinstance(given, (list, tuple)):
        raise ValueError("value is no list: one entry for each velocity, or one row for each y, is needed")
    return list(given)


def _number(name: str, given: Any) -> float:
    """One finite number, without a unit."""
    if isinstance(given, bool) or not isinstance(given, (int, float)) or not math.isfinite(given):
        raise ValueError(
            f"{name} is {shortened(given)}: a finite number in SI units, without text, is needed"
        )
    return float(given)


def _numbers(name: str, given: Any) -> list[float]:
    if not isinstance(given, (list, tuple)) or not all(
        isinstance(v, (int, float)) and not isinstance(v, bool) and math.isfinite(v) for v in given
    ):
        raise ValueError(f"{name} is {given!r}: a list of finite numbers is needed")
    return [float(v) for v in given]


def _profile(given: Any, info: ValidationInfo) -> str | Profile:
    """A profile by name, the path of its file, or a table with the file and how to read it."""
    if isinstance(given, Profile) or (isinstance(given, str) and given in STANDARD_PROFILES):
        return given
    known = f"one of {', '.join(STANDARD_PROFILES)}, the path of a profile file"
    if isinstance(given, str):
        given = {"file": given}
    accepted = ("file", *_PROFILE_WORDS)
    if not isinstance(given, Mapping) or "file" not in given or not set(given) <= set(accepted):
        raise ValueError(f"{known}, or a table of {', '.join(accepted)} is needed")
    for name, choices in _PROFILE_WORDS.items():
        if name in given:
            choice(name, given[name], choices)
    path = (info.context or {}).get("directory", Path()) / path_of("file", given["file"])
    if not path.exists():
        raise ValueError(f"there is no file {path}: {known} is needed")
    return Profile.from_file(path, **{k: v for k, v in given.items() if k != "file"})


#: How a profile file is to be read, where it does not say so itself.
_PROFILE_WORDS = {
    "unit": Unit,
    "interpolation": Interpolation,
    "z_axis": ZAxis,
}


def _layer(given: Any) -> InterfaceLayer:
    if isinstance(given, InterfaceLayer):
        return given
    if not isinstance(given, dict) or set(given) != {"thickness", "shear_modulus"}:
        raise ValueError("a table with thickness [m] and shear_modulus [Pa] is needed")
    thickness, modulus = _numbers("the layer", list(given[k] for k in ("thickness", "shear_modulus")))
    return InterfaceLayer(thickness=thickness, shear_modulus=modulus)


def motion_of(kind: type[Rolling] | type[Shift], given: Any) -> Rolling | Shift:
    """A rolling or a shift: a table of its arguments; "free" is None, in a force."""
    if isinstance(given, kind):
        return given
    known = list(inspect.signature(kind).parameters)
    if not isinstance(given, Mapping) or not set(given) <= set(known):
        raise ValueError(f"a table of {', '.join(known)} is needed")
    words = {key: _whole_numbers_too(value) for key, value in given.items()}
    if isinstance(force := words.get("force"), list):
        words["force"] = tuple(None if part == "free" else part for part in force)
    return kind(**words)


def _whole_numbers_too(given: Any) -> Any:
    """Numbers as floats: 1 is meant as 1.0."""
    if isinstance(given, list):
        return [_whole_numbers_too(part) for part in given]
    return float(given) if isinstance(given, int) and not isinstance(given, bool) else given


def _pair(given: Any) -> tuple[float, float]:
    numbers = _numbers("the pair", given)
    if len(numbers) != 2:
        raise ValueError("two numbers are needed")
    return numbers[0], numbers[1]


def _number_or_pair(given: Any) -> float | tuple[float, float]:
    return _pair(given) if isinstance(given, (list, tuple)) else _number("it", given)


#: What may follow the pressing, by the name of its table.
MOTIONS: dict[str, type[Rolling] | type[Shift]] = {motion.word: motion for motion in (Rolling, Shift)}


# --- what the words look like, for editors -------------------------------------------------------------


def _list_of(item: Any) -> dict[str, Any]:
    return {"type": "array", "items": item}


def _table(**properties: Any) -> dict[str, Any]:
    return {"type": "object", "additionalProperties": False, "properties": properties}


_NUMBER, _TEXT = {"type": "number"}, {"type": "string"}
_PAIR = {"type": "array", "items": _NUMBER, "minItems": 2, "maxItems": 2}
_TRIPLE = {"type": "array", "items": _NUMBER, "minItems": 3, "maxItems": 3}
_OVER_VELOCITY = _table(velocity=_list_of(_NUMBER), value=_list_of({}), file=_TEXT)
_OVER_X_AND_Y = _table(x=_list_of(_NUMBER), y=_list_of(_NUMBER), value=_list_of(_list_of(_NUMBER)))
_HILL = _table(peak=_NUMBER, center=_PAIR, sigma=_PAIR, floor=_NUMBER)
_PROFILE = _table(
    file=_TEXT, **{key: {"enum": list(typing.get_args(words))} for key, words in _PROFILE_WORDS.items()}
)
_FORCE = {"type": "array", "items": {"anyOf": [_NUMBER, {"const": "free"}]}, "minItems": 2, "maxItems": 2}
_BODY = _table(poisson_ratio=_NUMBER, young_modulus=_NUMBER, shear_modulus=_NUMBER)
#: JSON schemas of words that a Python function reads.
_LOOKS: dict[str, dict[str, Any]] = {
    "body": {"anyOf": [_BODY, {"const": "rigid"}]},
    "field": {"anyOf": [_NUMBER, _list_of({}), {"anyOf": [_OVER_VELOCITY, _OVER_X_AND_Y, _HILL]}]},
    "pair": _PAIR,
    "number or pair": {"anyOf": [_NUMBER, _PAIR]},
    "layer": _table(thickness=_NUMBER, shear_modulus=_NUMBER),
    "profile": {"anyOf": [{"enum": list(STANDARD_PROFILES)}, _TEXT, _PROFILE]},
    "rolling": _table(
        creepage=_TRIPLE,
        force=_FORCE,
        angle=_NUMBER,
        velocity=_NUMBER,
        transient={"type": "boolean"},
        step=_NUMBER,
    ),
    "shift": _table(displacement=_PAIR, force=_FORCE, spin=_NUMBER, duration=_NUMBER),
}


def read_by(function: Any, look: str) -> Any:
    """Words that `function` reads and that look like `look`."""
    return Annotated[Any, PlainValidator(function), WithJsonSchema(_LOOKS[look])]


# --- models, read off the signatures -----------------------------------------------------------------

_BY_NAME: dict[str, Any] = {
    **dict.fromkeys(
        ("upper", "lower"), read_by(lambda given: _body(given, MaterialWords.model_validate), "body")
    ),
    **dict.fromkeys(("friction", "magnetic_pressure"), read_by(_field, "field")),
    "sliding_direction": read_by(_pair, "pair"),
    "spacing": read_by(_number_or_pair, "number or pair"),
    "supports": Annotated[StrictStr, WithJsonSchema({"enum": list(typing.get_args(Held))})],
    "layer": read_by(_layer, "layer"),
    **dict.fromkeys(("rail", "wheel"), read_by(_profile, "profile")),
}
_BY_TYPE: dict[Any, Any] = {
    float: StrictFloat,
    int: StrictInt,
    str: StrictStr,
    float | None: StrictFloat | None,
    int | None: StrictInt | None,
}


def words_of(function: Any) -> dict[str, Any]:
    """Fields of a model from the arguments of `function`: their types, as TOML has them, and defaults."""
    hints, said = typing.get_type_hints(function), described(function)
    fields: dict[str, Any] = {}
    for name, parameter in inspect.signature(function).parameters.items():
        if name == "self" or parameter.kind is inspect.Parameter.VAR_KEYWORD:
            continue
        # which words, the scene says
        is_word = typing.get_origin(hints[name]) is typing.Literal
        kind = _BY_NAME.get(name)
        if kind is None and is_word:
            kind = Annotated[StrictStr, WithJsonSchema({"enum": list(typing.get_args(hints[name]))})]
        fields[name] = (kind or _BY_TYPE[hints[name]], Field(parameter.default, description=said.get(name)))
    return fields


def described(function: Any) -> dict[str, str]:
    """What the docstring of `function` says of each parameter: its kind and unit, and its sentences."""
    text = inspect.getdoc(function) or ""
    _, found, text = text.partition("Parameters\n----------\n")
    said: dict[str, str] = {}
    # a line that begins at the margin names parameters, the indented ones below speak of them
    for names, kind, more in re.findall(
        r"^(\w[\w, ]*?)(?: : (.*))?\n((?: .*\n|\n(?= ))*)", text + "\n", re.M
    ):
        words = " ".join([(kind and f"{kind}.") or "", *more.split()]).replace(":meth:", "").strip()
        said.update(dict.fromkeys(names.split(", "), words))
    return said if found else {}
