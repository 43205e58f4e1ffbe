# SPDX-License-Identifier: MIT OR Apache-2.0
"""The JSON schema of `summary.json`, made from the classes whose objects are written there."""

from __future__ import annotations

from dataclasses import fields
from typing import Any, get_args, get_type_hints

from pydantic import TypeAdapter

from ..base.words import Model, Side
from ..contact.sliding_heat import SlidingHeat
from ..contact.sliding_start import StartOfSliding
from ..half_space.creep_force import FoundationResult
from ..half_space.hertzian import Hertz
from ..half_space.normal import NormalResult
from ..half_space.tangential_result import TangentialResult
from ..results.fields import FIELDS, TOTALS
from ..results.report import Report
from ..results.result import Result
from ..results.saved import SCHEMA
from ..results.temperature import RollingTemperature
from ..results.wheel_result import WheelPatch, WheelReport, WheelStep
from ..simulation.stepping import StepReport, StepResult
from ..studies.braking import Braking

#: Numbers, which are null where they are infinite or not known, and arrays of them, of any depth.
NUMBER: dict[str, Any] = {"type": ["number", "null"]}
ARRAY: dict[str, Any] = {"anyOf": [NUMBER, {"type": "array", "items": {"$ref": "#/$defs/array"}}]}
#: What every summary has.
COMMON: dict[str, dict[str, Any]] = {
    "mtb_rs": {"type": "string", "description": "version that wrote it"},
    "schema": {"const": SCHEMA, "description": "form of the files"},
    "points": {"type": "integer", "minimum": 0, "description": "number of contact points"},
    "patches": {
        "type": "object",
        "description": "figures of each regular grid of contact points, by its name",
        "additionalProperties": {"$ref": "#/$defs/patch"},
    },
    "fields": {
        "type": "object",
        "description": "label and unit of each field in fields.npz",
        "propertyNames": {"enum": sorted(FIELDS)},
        "additionalProperties": {
            "type": "object",
            "properties": {"label": {"type": "string"}, "unit": {"type": "string"}},
            "required": ["label", "unit"],
            "additionalProperties": False,
        },
    },
    "files": {"type": "array", "items": {"type": "string"}, "description": "the other files of the result"},
    "notices": {"type": "array", "items": {"type": "string"}, "description": "what was left out, and why"},
}
_PATCH = {
    "points": "number of points",
    "in_contact": "number of points in contact",
    "contact_area": "area of the points in contact [m2]",
    "normal_force": "sum of pressure times area [N]",
    "peak_pressure": "largest pressure [Pa]",
}
_INPUTS = {
    "type": "object",
    "description": "what was solved: the arguments of a ready scene, or the fields of a scene of one's own "
    "(bodies with mesh, material and supports, gap, loads). Arrays of more than 1000 numbers are told by "
    "shape, range and sha256, functions and surfaces by name and sha256",
    "properties": {"scene": {"type": "string", "description": 'name of the ready scene, or "scene"'}},
}
#: Entries beside the common ones and the totals, by their names.
FACTS: dict[str, dict[str, Any]] = {
    "inputs": _INPUTS,
    "model": {"enum": list(get_args(Model))},
    "error_estimate": {**NUMBER, "description": "estimated relative error of the pressure [-]"},
    "motion": {"type": "object", "description": "the arguments of Rolling or Shift"},
    "iterations": {"type": "array", "items": {"type": "integer"}, "description": "Newton steps"},
    "time": {"$ref": "#/$defs/array", "description": "end of each step; of a stop the beginning as well [s]"},
    "peaks": {"$ref": "#/$defs/array", "description": "highest temperature of each step [K]"},
    "errors": {"$ref": "#/$defs/array", "description": "estimated relative error of each step [-]"},
    "thermal_margin": {
        **NUMBER,
        "description": "heat of friction over the bound from which uneven pressure grows [-]",
    },
    "friction_energy": {**NUMBER, "description": "heat of friction of all shoes [J]"},
    "open_energy": {
        **NUMBER,
        "description": "what is left of the kinetic energy less the work of the brakes, in parts of it [-]",
    },
    "path_error": {
        "$ref": "#/$defs/array",
        "description": "estimated relative error by the finite steps of the way [-]",
    },
    "semi_axes": {"$ref": "#/$defs/array", "description": "of the contact ellipse, along x and y [m]"},
    "peak_pressure": {**NUMBER, "description": "largest pressure [Pa]"},
    "curvatures": {"$ref": "#/$defs/array", "description": "of the gap, along x and y [1/m]"},
    "lower": {"type": "object", "description": "the lower body"},
    "upper": {"type": "object", "description": "the upper body"},
    "pose": {"$ref": "#/$defs/array", "description": "x, y, z [m], roll, pitch, yaw [rad]"},
    "velocity": {"$ref": "#/$defs/array", "description": "vx, vy, vz [m/s], wx, wy, wz [rad/s]"},
    "vertical_force": {
        "type": "object",
        "additionalProperties": NUMBER,
        "description": "of each wheel on its rail [N]",
    },
    "balance_error": {**NUMBER, "description": "relative departure from the vertical force asked for [-]"},
    "friction_work": {**NUMBER, "description": "heat of the step [J]"},
    "side": {"enum": list(get_args(Side)), "description": "side of the wheel"},
    "position": {"$ref": "#/$defs/array", "description": "origin of the patch in the track [m]"},
    "contact_angle": {**NUMBER, "description": "slope of the contact plane [rad]"},
    "rail_position": {**NUMBER, "description": "y of the origin in the profile of the rail [m]"},
    "wheel_position": {**NUMBER, "description": "y of the origin in the profile of the wheel [m]"},
    "rolling_speed": {**NUMBER, "description": "[m/s]"},
    "neglected": {**NUMBER, "description": "share of the area that is inclined too much [-]"},
    "inclination": {"$ref": "#/$defs/array", "description": "of each row in the track [rad]"},
    "row_position": {"$ref": "#/$defs/array", "description": "y and z of each row in the track [m]"},
    "row_creepage": {"$ref": "#/$defs/array", "description": "xi, eta [-] and phi [1/m] of each row"},
}
_LOADED = ("force", "moment", "reference_point")
_RUBBED = ("force", "spin_moment", "normal_force")
_PRESSED = ("error_estimate", "normal_force", "approach", "tilts")
_PLACED = ("side", "position", "contact_angle", "rail_position", "wheel_position", "approach")
_ROWS = ("inclination", "row_position", "row_creepage")
_HEATED = ("force", "friction_power", "heat_lower", "heat_upper")
_STOPPED = ("time", "speed", "way", "brake_forces", "other_force")
_BALANCED = ("pose", "velocity", "vertical_force", "balance_error", "friction_work", "friction_power")
#: Kinds of results: their entries, and the class of their report.
KINDS: dict[type, tuple[tuple[str, ...], type | None]] = {
    Result: (
        ("inputs", "model", "error_estimate", *_LOADED, "normal_force", "approach", "friction_power"),
        Report,
    ),
    NormalResult: ((*_PRESSED, "rolling_resistance"), Report),
    TangentialResult: (("motion", "creepage", *_RUBBED, "rolling_resistance"), Report),
    FoundationResult: (_RUBBED, None),
    SlidingHeat: (
        ("inputs", "time", "peaks", "errors", "thermal_margin", *_HEATED),
        None,
    ),
    Braking: (
        ("inputs", "friction_energy", "open_energy", "worn_volume", "errors", *_STOPPED),
        None,
    ),
    RollingTemperature: (("heat_lower", "heat_upper", "friction_power"), None),
    Hertz: (("semi_axes", "peak_pressure", "curvatures", "lower", "upper", *_PRESSED), Report),
    StepResult: ((*_LOADED, "friction_power"), StepReport),
    StartOfSliding: (
        ("inputs", "iterations", "path_error", "displacement", "force", "normal_force", "slip_share"),
        None,
    ),
    WheelPatch: (
        (*_PLACED, *_ROWS, "rolling_speed", "neglected", "normal_force", "creepage", "friction_power"),
        None,
    ),
    WheelStep: ((*_BALANCED, *_LOADED), WheelReport),
}
#: Entries that only some results of a kind have: a scene need not state how fast it slides, few bodies creep,
#: and few patches follow the rail.
SOMETIMES: dict[type, tuple[str, ...]] = {
    Result: ("friction_power",),
    NormalResult: ("rolling_resistance",),
    TangentialResult: ("rolling_resistance",),
    WheelPatch: _ROWS,
}


def summary_schema() -> dict[str, Any]:
    """The JSON schema of `summary.json`: [JSON Schema 2020-12], one branch for each kind of result."""
    return {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": "summary.json of mtb_rs",
        "type": "object",
        "oneOf": [_branch(kind) for kind in KINDS],
        "$defs": {
            "array": ARRAY,
            "patch": {
                "type": "object",
                "properties": {name: {**NUMBER, "description": told} for name, told in _PATCH.items()},
                "required": list(_PATCH),
                "additionalProperties": False,
            },
        },
    }


def _branch(kind: type) -> dict[str, Any]:
    names, report = KINDS[kind]
    properties = {"result": {"const": kind.__name__}, **COMMON}
    properties |= {name: FACTS[name] if name in FACTS else _total(name) for name in names}
    if report is not None:
        properties["report"] = _report(report)
    return {
        "title": kind.__name__,
        "type": "object",
        "properties": properties,
        "required": [name for name in properties if name not in SOMETIMES.get(kind, ())],
        "additionalProperties": False,
    }


def _total(name: str) -> dict[str, Any]:
    total = TOTALS[name]
    unit = f" [{total.unit}]" if total.unit else ""
    return {"$ref": "#/$defs/array", "description": f"{total.label}{unit}"}


def _report(made: type) -> dict[str, Any]:
    """The schema of a report, from the types of its fields."""
    hints = get_type_hints(made)
    names = [entry.name for entry in fields(made)]
    return {
        "type": "object",
        "description": f"how the solve went: see {made.__name__}",
        "properties": {name: _nullable(TypeAdapter(hints[name]).json_schema()) for name in names},
        "required": names,
        "additionalProperties": False,
    }


def _nullable(part: Any) -> Any:
    """The same, where each number may be null: infinity and NaN are."""
    if isinstance(part, list):
        return [_nullable(entry) for entry in part]
    if not isinstance(part, dict):
        return part
    inner = {name: _nullable(entry) for name, entry in part.items()}
    return inner | NUMBER if part.get("type") == "number" else inner
