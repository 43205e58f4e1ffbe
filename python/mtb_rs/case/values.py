# SPDX-License-Identifier: MIT OR Apache-2.0
"""What the values of a case file mean, and what they look like to an editor."""

from __future__ import annotations

import inspect
import math
import re
import typing
from collections.abc import Callable, Collection, Mapping
from dataclasses import fields
from functools import partial
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import (
    BaseModel,
    ConfigDict,
    Field,
    PlainValidator,
    StrictBool,
    StrictFloat,
    StrictInt,
    StrictStr,
    ValidationInfo,
    WithJsonSchema,
    model_validator,
)

from ..base.check import choice, meant, path_of, reals, shortened
from ..base.words import Held, Interpolation, Unit, ZAxis
from ..bodies.material import Material, steel
from ..bodies.prism import Prism
from ..bodies.simple import Layered, Rigid, Viscoelastic
from ..friction.field_table import FieldTable, table_from_file
from ..friction.fields import LARGEST_FRICTION, GaussianPressure, VelocityTable
from ..friction.laws import InterfaceLayer, PlasticLayer, ShearLayer
from ..friction.magnet import IRONS, Branch, Magnet
from ..geometry.profiles import STANDARD_PROFILES, Profile
from ..geometry.slices import RailSlices, WheelSlices
from ..half_space.motions import Forces, Rolling, Shift
from ..half_space.rough_layer import RoughLayer
from ..half_space.temperature_friction import TemperatureFriction, of_temperature


class MaterialWords(BaseModel):
    """An elastic material: Poisson's ratio and one of the two moduli [Pa]."""

    model_config = ConfigDict(
        extra="forbid",
        frozen=True,
        allow_inf_nan=False,
        json_schema_extra={"oneOf": [{"required": ["young_modulus"]}, {"required": ["shear_modulus"]}]},
    )
    poisson_ratio: StrictFloat = Field(json_schema_extra={"exclusiveMinimum": -1, "maximum": 0.5})
    young_modulus: StrictFloat | None = Field(None, json_schema_extra={"exclusiveMinimum": 0})
    shear_modulus: StrictFloat | None = Field(None, json_schema_extra={"exclusiveMinimum": 0})

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


class LayeredWords(BaseModel):
    """A layer [m] of one material on a half-space of another, or on a rigid base."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)
    layer: MaterialWords
    thickness: StrictFloat = Field(json_schema_extra={"exclusiveMinimum": 0})
    base: MaterialWords | Literal["rigid"]
    bonded: StrictBool = True

    @model_validator(mode="after")
    def _is_a_body(self) -> LayeredWords:
        self.body()
        return self

    def body(self) -> Layered:
        """The body meant."""
        base = Rigid() if isinstance(self.base, str) else self.base.material()
        return Layered(self.layer.material(), self.thickness, base, self.bonded)


class ViscoelasticWords(BaseModel):
    """A half-space that creeps under steady rolling: creep [-] and its time [s]."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)
    material: MaterialWords
    creep: StrictFloat = Field(json_schema_extra={"minimum": 0})
    creep_time: StrictFloat = Field(json_schema_extra={"minimum": 0})

    @model_validator(mode="after")
    def _is_a_body(self) -> ViscoelasticWords:
        self.body()
        return self

    def body(self) -> Viscoelastic:
        """The body meant."""
        return Viscoelastic(self.material.material(), self.creep, self.creep_time)


#: Words of a table that only a layered body has, and only one that creeps.
_OF_LAYERS = {"layer", "thickness", "base", "bonded"}
_OF_CREEP = {"material", "creep", "creep_time"}


def _body(given: Any, info: ValidationInfo) -> Material | Layered | Prism | Rigid | Viscoelastic:
    if isinstance(given, (Material, Layered, Prism, Rigid, Viscoelastic)):
        return given
    if given == "rigid":
        return Rigid()
    if not isinstance(given, Mapping):
        raise ValueError(
            "a table with a modulus and poisson_ratio, one with layer, thickness and base, one with "
            'material, creep and creep_time, one with prism, or "rigid", is needed'
        )
    if "prism" in given:
        return PrismWords.model_validate(given).body(info)
    if _OF_LAYERS & set(given):
        return LayeredWords.model_validate(given).body()
    if _OF_CREEP & set(given):
        return ViscoelasticWords.model_validate(given).body()
    return MaterialWords.model_validate(given).material()


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
    if isinstance(given, (VelocityTable, FieldTable, GaussianPressure, Magnet)):
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
        if "ampere_turns" in keys:
            return _magnet(given, info)
        if {"peak", "center", "sigma"} <= keys <= {"peak", "center", "sigma", "floor"}:
            return GaussianPressure(
                _number("peak", given["peak"]),
                _pair(given["center"]),
                _pair(given["sigma"]),
                _number("floor", given.get("floor", GaussianPressure.floor)),
            )
        raise ValueError(
            f"the keys {', '.join(sorted(keys)) or '(none)'} do not go together: velocity and value, or "
            "x, y and value, or file (a CSV with these columns), or peak, center, sigma and floor (a hill), "
            "or ampere_turns, non_magnetic_gap and what else a magnet has are needed"
        )
    raise ValueError("a number, a list with one entry per pole, or a table is needed")


def friction_of(given: Any, info: ValidationInfo) -> Any:
    """Friction: what a pressure may be, or a law over the temperature."""
    if of_temperature(given) is not None:
        return given
    if not isinstance(given, Mapping) or "temperature" not in given:
        return _field(given, info)
    unknown = sorted(set(given) - set(_OF_TEMPERATURE))
    if unknown or "coefficient" not in given:
        wrong = f"{', '.join(unknown)}: no words" if unknown else "coefficient is missing"
        raise ValueError(
            f"{wrong} of friction over the temperature: {', '.join(_OF_TEMPERATURE)} are its words"
        )
    made: dict[str, Any] = {name: _numbers(name, given[name]) for name in ("temperature", "coefficient")}
    if "bulk" in given:
        made["bulk"] = _pair(given["bulk"])
    made |= {name: _number(name, given[name]) for name in ("memory", "memory_min_slip") if name in given}
    return TemperatureFriction(**made)


#: Words of friction over the temperature of bodies of steel.
_OF_TEMPERATURE = ("temperature", "coefficient", "bulk", "memory", "memory_min_slip")


def _magnet(given: Mapping[str, Any], info: ValidationInfo) -> Magnet:
    words = {f.name for f in fields(Magnet)}
    for key in given:
        if key not in words:
            near = meant(key, sorted(words))
            hint = f"did you mean {near}?" if near else f"{', '.join(sorted(words))} are its words"
            raise ValueError(f"a magnet has no {key}; {hint}")
    if "non_magnetic_gap" not in given:
        raise ValueError("non_magnetic_gap [m] is missing: a magnet needs it and ampere_turns [A]")
    made = dict(given)
    if "speed_factor" in made:
        made["speed_factor"] = _field(made["speed_factor"], info)
    return Magnet(**made)


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


def profile_of(given: Any, info: ValidationInfo) -> str | Profile | RailSlices | WheelSlices:
    """A profile by name, the path of its file, or a table with the file and how to read it."""
    if isinstance(given, (Profile, RailSlices, WheelSlices)) or (
        isinstance(given, str) and given in STANDARD_PROFILES
    ):
        return given
    known = f"one of {', '.join(STANDARD_PROFILES)}, the path of a profile file"
    if isinstance(given, str):
        given = {"file": given}
    accepted = ("file", *_PROFILE_WORDS, "mirror", "wavelength")
    if not isinstance(given, Mapping) or "file" not in given or not set(given) <= set(accepted):
        raise ValueError(f"{known}, or a table of {', '.join(accepted)} is needed")
    for name, choices in _PROFILE_WORDS.items():
        if name in given:
            choice(name, given[name], choices)
    path = (info.context or {}).get("directory", Path()) / path_of("file", given["file"])
    if not path.exists():
        raise ValueError(f"there is no file {path}: {known} is needed")
    lists: dict[str, type[RailSlices] | type[WheelSlices]] = {".slcs": RailSlices, ".slcw": WheelSlices}
    if path.suffix.lower() in lists:
        if "wavelength" in given:
            raise ValueError(
                f"wavelength is given with {path.name}, a list of sections: they are not smoothed"
            )
        reading = {k: v for k, v in given.items() if k != "file"}
        return lists[path.suffix.lower()].from_file(path, **reading)
    profile = Profile.from_file(path, **{k: v for k, v in given.items() if k not in ("file", "wavelength")})
    return profile.smoothed(given["wavelength"]) if "wavelength" in given else profile


#: How a profile file is to be read, where it does not say so itself.
_PROFILE_WORDS = {
    "unit": Unit,
    "interpolation": Interpolation,
    "z_axis": ZAxis,
}


def _layer(given: Any) -> ShearLayer:
    if isinstance(given, ShearLayer):
        return given
    shears, yields = {"thickness", "shear_modulus"}, {"yield_stress", "hardening"}
    keys = set(given) if isinstance(given, dict) else set()
    if not shears <= keys <= shears | yields or keys & yields == {"hardening"}:
        raise ValueError(
            "a table with thickness [m] and shear_modulus [Pa] is needed, for a layer that yields also with "
            "yield_stress [Pa] and hardening [Pa/m]"
        )
    numbers = {key: _number(key, value) for key, value in given.items()}
    return (PlasticLayer if keys & yields else InterfaceLayer)(**numbers)


def _motion_arguments(kind: type[Rolling] | type[Shift]) -> list[str]:
    """What a table of a motion may state; the slip of single cells belongs to a grid of one's own."""
    return [name for name in inspect.signature(kind).parameters if name != "rigid_slip"]


def motion_of(kind: type[Rolling] | type[Shift], given: Any) -> Rolling | Shift:
    """A rolling or a shift: a table of its arguments; "free" is None, in a force."""
    if isinstance(given, kind):
        return given
    known = _motion_arguments(kind)
    if not isinstance(given, Mapping) or not set(given) <= set(known):
        raise ValueError(f"a table of {', '.join(known)} is needed")
    words = {key: value if key == "order" else _whole_numbers_too(value) for key, value in given.items()}
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


def _spacing(given: Any) -> float | tuple[float, float] | None:
    """One or two distances; None for what the solve finds."""
    if given is None or given == FOUND:
        return None
    if isinstance(given, str):
        raise ValueError(
            f"it is {given!r}: a finite number in SI units, without text, or two of them are needed, or "
            f"{FOUND!r} for one that the solve finds"
        )
    return _pair(given) if isinstance(given, (list, tuple)) else _number("it", given)


def _points(given: Any) -> int | None:
    """A count; None for one that the solve finds."""
    if given is None or given == FOUND:
        return None
    if isinstance(given, bool) or not isinstance(given, int):
        raise ValueError(
            f"it is {shortened(given)}: a whole number is needed, or {FOUND!r} for one that the solve finds"
        )
    return given


#: Cells that the solve finds, where Python has None.
FOUND = "auto"
#: What may follow the pressing, by the name of its table.
MOTIONS: dict[str, type[Rolling] | type[Shift]] = {motion.word: motion for motion in (Rolling, Shift)}


# --- what the words look like, for editors -------------------------------------------------------------


def _list_of(item: Any) -> dict[str, Any]:
    return {"type": "array", "items": item}


def _table(required: list[str], **properties: Any) -> dict[str, Any]:
    return {"type": "object", "additionalProperties": False, "required": required, "properties": properties}


_COUNT = {"type": "integer"}
_NUMBER, _TEXT = {"type": "number"}, {"type": "string"}
_POSITIVE = {**_NUMBER, "exclusiveMinimum": 0}
_FORCE = {"anyOf": [_NUMBER, {"const": "free"}]}


def _tuple_of(item: Any, count: int) -> dict[str, Any]:
    return {**_list_of(item), "minItems": count, "maxItems": count}


_PAIR = _tuple_of(_NUMBER, 2)
_OVER_X_AND_Y = _table(
    ["x", "y", "value"], x=_list_of(_NUMBER), y=_list_of(_NUMBER), value=_list_of(_list_of(_NUMBER))
)
_HILL = _table(
    ["peak", "center", "sigma"], peak=_NUMBER, center=_PAIR, sigma=_tuple_of(_POSITIVE, 2), floor=_NUMBER
)


def _field_look(number: dict[str, Any]) -> dict[str, Any]:
    """Friction or magnetic pressure, of which one is a `number`."""
    value = {"anyOf": [number, _HILL, _OVER_X_AND_Y, _table(["file"], file=_TEXT)]}
    over_velocity = _table(
        ["velocity", "value"],
        velocity=_list_of(_NUMBER),
        value=_list_of({"anyOf": [value, _list_of(value)]}),
    )
    part = {"anyOf": [value, over_velocity]}
    return {"anyOf": [part, _list_of(part)]}


#: Friction that follows the temperature of steady rolling.
_FRICTION_OF_TEMPERATURE = _table(
    ["temperature", "coefficient"],
    temperature=_list_of(_NUMBER),
    coefficient=_list_of({**_NUMBER, "minimum": 0, "maximum": LARGEST_FRICTION}),
    bulk=_tuple_of(_NUMBER, 2),
    memory=_POSITIVE,
    memory_min_slip=_POSITIVE,
)

#: One coefficient, or such a law.
_COEFFICIENT = {**_NUMBER, "minimum": 0, "maximum": LARGEST_FRICTION}
WHEEL_FRICTION_LOOK: dict[str, Any] = {"anyOf": [_COEFFICIENT, _FRICTION_OF_TEMPERATURE]}

#: A magnet whose pull follows the gap.
_MAGNET = _table(
    ["ampere_turns", "non_magnetic_gap"],
    ampere_turns=_POSITIVE,
    non_magnetic_gap=_POSITIVE,
    iron={"anyOf": [{"enum": list(IRONS)}, _tuple_of(_list_of(_NUMBER), 2)]},
    iron_share=_POSITIVE,
    pole_length={**_NUMBER, "minimum": 0},
    yoke=_tuple_of(_POSITIVE, 2),
    armature=_tuple_of(_POSITIVE, 2),
    leakage={**_NUMBER, "minimum": 0},
    speed_factor={
        "anyOf": [
            _table(["velocity", "value"], velocity=_list_of(_NUMBER), value=_list_of(_NUMBER)),
            _table(["file"], file=_TEXT),
        ]
    },
    branch={"enum": list(typing.get_args(Branch))},
)

_PROFILE = _table(
    ["file"],
    file=_TEXT,
    **{key: {"enum": list(typing.get_args(words))} for key, words in _PROFILE_WORDS.items()},
    mirror={"type": "boolean"},
    wavelength=_POSITIVE,
)


#: A profile, or the file of one, as an editor sees it.
PROFILE_LOOK: dict[str, Any] = {"anyOf": [_TEXT, _PROFILE]}
_SECTION: dict[str, Any] = {"anyOf": [_TEXT, _PROFILE, _tuple_of(_POSITIVE, 2)]}


class PrismWords(BaseModel):
    """A prism: its running surface or its width and height [m], and stiffnesses of its foundation [N/m2]."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)
    prism: Any = Field(json_schema_extra=_SECTION)
    material: MaterialWords | None = None
    foundation: tuple[float, float] | None = None

    def body(self, info: ValidationInfo) -> Prism:
        """The body meant."""
        section = self.prism if isinstance(self.prism, (list, tuple)) else profile_of(self.prism, info)
        if isinstance(section, (RailSlices, WheelSlices)):
            raise ValueError("prism is a list of sections: a prism has one, so a profile is needed")
        material = steel if self.material is None else self.material.material()
        return Prism(section, material, self.foundation)


#: JSON schema of a rough layer: by the exponential law, or by a table.
_ROUGH = {
    "anyOf": [
        _table(
            ["contact_pressure", "length"],
            **dict.fromkeys(("contact_pressure", "length", "height"), _POSITIVE),
        ),
        _table(["gap", "pressure"], gap=_list_of(_NUMBER), pressure=_list_of(_NUMBER)),
    ]
}


#: Words of the forms of a rough layer, those that may be left out, and what is made of them.
_ROUGH_FORMS: tuple[tuple[set[str], set[str], Callable[..., RoughLayer]], ...] = (
    ({"contact_pressure", "length"}, {"height"}, RoughLayer.exponential),
    ({"gap", "pressure"}, set(), RoughLayer),
)


def _normal_layer(given: Any, info: ValidationInfo) -> Any:
    """A flexibility in any form of a field, or a rough layer."""
    if isinstance(given, RoughLayer):
        return given
    if isinstance(given, Mapping):
        for words, optional, made in _ROUGH_FORMS:
            # one word that no other form has tells which is meant
            if words & set(given):
                if not words <= set(given) <= words | optional:
                    raise ValueError(
                        f"the keys {', '.join(sorted(given))} do not go together: a rough layer has "
                        "contact_pressure, length and, if need be, height, or gap and pressure"
                    )
                return made(**given)
    return _field(given, info)


#: JSON schemas of the types of the arguments of a motion.
_BY_HINT: dict[Any, dict[str, Any]] = {
    float: _NUMBER,
    float | None: _NUMBER,
    bool: {"type": "boolean"},
    tuple[float, float]: _PAIR,
    tuple[float, float, float]: _tuple_of(_NUMBER, 3),
    Forces | None: _tuple_of(_FORCE, 2),
}


_ABOVE_ZERO = {"exclusiveMinimum": 0}
_SHARE = {"exclusiveMinimum": 0, "exclusiveMaximum": 1}
#: Numbers that no scene takes.
_BOUNDS: dict[str, dict[str, Any]] = {
    **{name: _ABOVE_ZERO for name in ("width", "height", "length", "rail_length", "radius", "force")},
    **{name: _ABOVE_ZERO for name in ("wheel_radius", "gauge", "gauge_depth", "flange_back")},
    "roller_radius": _ABOVE_ZERO,
    **{name: {"minimum": 0} for name in ("inner_edge", "relief_slope", "velocity")},
    "rail_inclination": {"maximum": 0.5},
    "yaw": {"minimum": -0.5, "maximum": 0.5},
    "points": {"minimum": 4},
    "poles": {"minimum": 1, "maximum": 2},
    "tolerance": _SHARE,
    "displacement_tolerance": _SHARE,
}
_OF_MOTIONS: dict[str, dict[str, Any]] = {
    **dict.fromkeys(("velocity", "duration", "step"), _ABOVE_ZERO),
    "order": {"enum": [1, 2]},
}


def _motion_look(kind: type[Rolling] | type[Shift]) -> dict[str, Any]:
    """The table of a motion, from its arguments."""
    hints, said = typing.get_type_hints(kind), described(kind)
    arguments = {
        name: {**_BY_HINT.get(hints[name], {}), **_OF_MOTIONS.get(name, {}), "description": said[name]}
        for name in _motion_arguments(kind)
    }
    return _table([], **arguments)


def read_by(function: Any, look: dict[str, Any]) -> Any:
    """Words that `function` reads and that look like the JSON schema `look`."""
    return Annotated[Any, PlainValidator(function), WithJsonSchema(look)]


def motion_words(kind: type[Rolling] | type[Shift]) -> Any:
    """The table of a motion."""
    return read_by(partial(motion_of, kind), _motion_look(kind))


def _inlined(model: type[BaseModel]) -> dict[str, Any]:
    """The JSON schema of a model without references."""
    schema = model.model_json_schema()
    named = schema.pop("$defs", {})

    def put(part: Any) -> Any:
        if isinstance(part, list):
            return [put(item) for item in part]
        if not isinstance(part, dict):
            return part
        if "$ref" in part:
            return put(named[part["$ref"].rpartition("/")[2]])
        return {key: put(item) for key, item in part.items()}

    return typing.cast(dict[str, Any], put(schema))


# --- models, read off the signatures -----------------------------------------------------------------

_BY_NAME: dict[str, Any] = {
    **dict.fromkeys(
        ("upper", "lower"),
        read_by(
            _body,
            {
                "anyOf": [
                    _inlined(MaterialWords),
                    _inlined(LayeredWords),
                    _inlined(ViscoelasticWords),
                    _inlined(PrismWords),
                    {"const": "rigid"},
                ]
            },
        ),
    ),
    "friction": read_by(
        friction_of,
        {
            "anyOf": [
                _field_look(_COEFFICIENT),
                _FRICTION_OF_TEMPERATURE,
            ]
        },
    ),
    "magnetic_pressure": read_by(_field, {"anyOf": [_field_look(_NUMBER), _MAGNET]}),
    "normal_layer": read_by(_normal_layer, {"anyOf": [_field_look({**_NUMBER, "minimum": 0}), _ROUGH]}),
    "hardness": read_by(_field, _field_look(_POSITIVE)),
    "sliding_direction": read_by(_pair, _PAIR),
    "spacing": read_by(_spacing, {"anyOf": [_POSITIVE, _tuple_of(_POSITIVE, 2), {"const": FOUND}]}),
    "points": read_by(_points, {"anyOf": [_COUNT, {"const": FOUND}]}),
    "supports": Annotated[StrictStr, WithJsonSchema({"enum": list(typing.get_args(Held))})],
    "layer": read_by(
        _layer,
        _table(
            ["thickness", "shear_modulus"],
            **dict.fromkeys(("thickness", "shear_modulus", "yield_stress"), _POSITIVE),
            hardening=_NUMBER,
        ),
    ),
    **dict.fromkeys(("rail", "wheel"), read_by(profile_of, PROFILE_LOOK)),
}
_BY_TYPE: dict[Any, Any] = {
    float: StrictFloat,
    int: StrictInt,
    str: StrictStr,
    float | None: StrictFloat | None,
    int | None: StrictInt | None,
}


def words_of(function: Any, names: Collection[str] = ()) -> dict[str, Any]:
    """Fields of a model from the arguments of `function`: their types, as TOML has them, and defaults.

    All of them, or those of `names`.
    """
    hints, said = typing.get_type_hints(function), described(function)
    fields: dict[str, Any] = {}
    for name, parameter in inspect.signature(function).parameters.items():
        if name not in (names or hints) or parameter.kind is inspect.Parameter.VAR_KEYWORD:
            continue
        # which words, the scene says
        is_word = typing.get_origin(hints[name]) is typing.Literal
        kind = _BY_NAME.get(name)
        if kind is None and is_word:
            kind = Annotated[StrictStr, WithJsonSchema({"enum": list(typing.get_args(hints[name]))})]
        fields[name] = (
            kind or _BY_TYPE[hints[name]],
            Field(parameter.default, description=said.get(name), json_schema_extra=_BOUNDS.get(name)),
        )
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
