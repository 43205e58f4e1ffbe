# SPDX-License-Identifier: MIT OR Apache-2.0
"""The parts of a result: fields over the contact points and totals, each with its unit and its label."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..base.owning import owning
from ..base.plain import plain
from ..base.words import Body

#: What is drawn of a field: itself, its magnitude, or one of its components.
Part = Literal["value", "magnitude", "longitudinal", "lateral", "vertical"]
#: Where a field tells something: at points in contact, there and beside them, or everywhere.
Extent = Literal["contact", "around", "everywhere"]

_COMPONENTS: dict[Part, int] = {"longitudinal": 0, "lateral": 1, "vertical": 2}


@owning
@dataclass(frozen=True)
@plain
class Field:
    """One quantity of a result.

    Attributes
    ----------
    name : str
        Name under which it is stored.
    label : str
        In words.
    unit : str
        SI, as pint reads it; "1" of ratios, "" of codes.
    values : (...), or (k, ...) of a vector
        Values over the contact points; of a total one number or vector.
    is_vector : bool
    parts : tuple of "value", "magnitude", "longitudinal", "lateral", "vertical"
        Parts that pictures show; none for places and areas.
    extent : "contact", "around" or "everywhere"
        Where it has a meaning. A field of "contact" is drawn only there.
    body : "upper", "lower" or None
        The body to which it belongs, if it belongs to one.
    is_signed : bool
        Whether its sign has a meaning.
    is_distance : bool
        Whether small values are the important ones.
    """

    name: str
    label: str
    unit: str
    values: NDArray[Any]
    is_vector: bool = False
    parts: tuple[Part, ...] = ("value",)
    extent: Extent = "everywhere"
    body: Body | None = None
    is_signed: bool = False
    is_distance: bool = False

    @property
    def words(self) -> dict[str, Part]:
        """The words that its parts are asked for by."""
        stem = self.name if self.body is None else self.name.removesuffix(f"_{self.body}")
        return {stem if part in ("value", "magnitude") else f"{part}_{stem}": part for part in self.parts}

    def part(self, word: str) -> Field:
        """The scalar field that `word`, one of :attr:`words`, stands for."""
        part = self.words[word]
        if part == "value":
            return self
        if part == "magnitude":
            label, values = f"|{self.label}|", np.linalg.norm(self.values, axis=0)
        else:
            label, values = f"{part} {self.label}", self.values[_COMPONENTS[part]]
        signed = part != "magnitude"
        return replace(
            self, name=word, label=label, values=values, is_vector=False, parts=("value",), is_signed=signed
        )


_EMPTY = np.empty(0)
_FRICTION: tuple[Part, ...] = ("magnitude", "longitudinal", "lateral")
_MOVED: tuple[Part, ...] = ("vertical", "longitudinal", "lateral")
#: All fields that results have, without their values.
FIELDS = {
    field.name: field
    for field in (
        Field("points", "contact points", "m", _EMPTY, is_vector=True, parts=()),
        Field("area", "area", "m^2", _EMPTY, parts=()),
        Field("normal", "normal of the lower body", "1", _EMPTY, is_vector=True, parts=()),
        Field("pressure", "pressure", "Pa", _EMPTY, extent="contact"),
        Field("magnetic_pressure", "magnetic pressure", "Pa", _EMPTY),
        Field("traction", "traction", "Pa", _EMPTY, is_vector=True, parts=_FRICTION, extent="contact"),
        Field("slip", "slip", "1", _EMPTY, is_vector=True, parts=_FRICTION, extent="contact"),
        Field("plastic_slip", "plastic slip", "1", _EMPTY, is_vector=True, parts=_FRICTION, extent="contact"),
        Field("accumulated_plastic_slip", "accumulated plastic slip", "m", _EMPTY, extent="contact"),
        Field("friction_coefficient", "friction coefficient", "1", _EMPTY, extent="contact"),
        Field("dissipation", "dissipation", "Pa", _EMPTY, extent="around"),
        Field("plastic_dissipation", "plastic dissipation", "Pa", _EMPTY, extent="around"),
        Field("gap", "gap", "m", _EMPTY, is_distance=True),
        Field("initial_gap", "initial gap", "m", _EMPTY, is_distance=True),
        Field("plastic_indentation", "plastic indentation", "m", _EMPTY, extent="contact"),
        Field("status", "status", "", _EMPTY, extent="around"),
        Field("temperature_upper", "temperature", "K", _EMPTY, body="upper", extent="around"),
        Field("temperature_lower", "temperature", "K", _EMPTY, body="lower", extent="around"),
        Field("heat_flux_upper", "heat flux", "W/m^2", _EMPTY, body="upper", extent="around", is_signed=True),
        Field("heat_flux_lower", "heat flux", "W/m^2", _EMPTY, body="lower", extent="around", is_signed=True),
        Field("wear_upper", "depth of wear", "m", _EMPTY, body="upper"),
        Field("wear_lower", "depth of wear", "m", _EMPTY, body="lower"),
        Field("displacement_upper", "displacement", "m", _EMPTY, True, _MOVED, body="upper"),
        Field("displacement_lower", "displacement", "m", _EMPTY, True, _MOVED, body="lower"),
    )
}
#: All totals that results have, without their values.
TOTALS = {
    field.name: field
    for field in (
        Field("force", "force on the lower body", "N", _EMPTY, is_vector=True, parts=()),
        Field("moment", "moment on the lower body", "N m", _EMPTY, is_vector=True, parts=()),
        Field("spin_moment", "moment of friction", "N m", _EMPTY, parts=()),
        Field("reference_point", "reference point", "m", _EMPTY, is_vector=True, parts=()),
        Field("normal_force", "normal force", "N", _EMPTY, parts=()),
        Field("approach", "approach", "m", _EMPTY, parts=()),
        Field("tilts", "tilts", "1", _EMPTY, parts=()),
        Field("creepage", "creepage or shift", "", _EMPTY, parts=()),
        Field("rolling_resistance", "rolling resistance", "N", _EMPTY, parts=()),
        Field("friction_power", "heat of sliding", "W", _EMPTY, parts=()),
        Field("heat_lower", "heat into the lower body", "W", _EMPTY, parts=()),
        Field("heat_upper", "heat into the upper body", "W", _EMPTY, parts=()),
        Field("displacement", "displacement of the upper body", "m", _EMPTY, parts=()),
        Field("distance", "sliding distance", "m", _EMPTY, parts=()),
        Field("depth", "greatest depth of wear", "m", _EMPTY, parts=()),
        Field("worn_volume", "worn volume", "m^3", _EMPTY, parts=()),
        Field("uniformity", "uniformity of the pressure", "1", _EMPTY, parts=()),
        Field("peak_pressure", "peak pressure", "Pa", _EMPTY, parts=()),
        Field("time", "time", "s", _EMPTY, parts=()),
        Field("speed", "speed", "m/s", _EMPTY, parts=()),
        Field("way", "way", "m", _EMPTY, parts=()),
        Field("brake_forces", "brake force of each shoe", "N", _EMPTY, parts=()),
        Field("other_force", "force of the other brakes", "N", _EMPTY, parts=()),
        Field("slip_share", "share of the contact area that slips", "1", _EMPTY, parts=()),
    )
}


def normals(angles: NDArray[np.float64], columns: int) -> NDArray[np.float64]:
    """Normals (3, ny, nx) of rows of cells that rise along y by their `angles` (ny,) [rad]."""
    out = np.stack([np.zeros_like(angles), -np.sin(angles), np.cos(angles)])
    return np.repeat(out[..., None], columns, axis=2)


def fields_of(units: Mapping[str, str] | None = None, **values: ArrayLike) -> dict[str, Field]:
    """Fields of a result from their values, in another than their usual unit where `units` say so."""
    return _filled(FIELDS, units or {}, values)


def totals_of(**values: ArrayLike) -> dict[str, Field]:
    """Totals of a result from their values."""
    return _filled(TOTALS, {}, values)


def _filled(
    known: Mapping[str, Field], units: Mapping[str, str], values: Mapping[str, ArrayLike]
) -> dict[str, Field]:
    return {
        name: replace(known[name], values=np.asarray(given), unit=units.get(name, known[name].unit))
        for name, given in values.items()
    }
