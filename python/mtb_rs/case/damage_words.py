# SPDX-License-Identifier: MIT OR Apache-2.0
"""The table ``[damage]`` of a case file: T gamma, surface fatigue and temperatures of a rolling contact."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from ..base.check import pair, positive
from ..bodies.conductor import Conductor
from ..half_space.tangential_result import TangentialResult
from ..results.temperature import RollingTemperature
from .brake_words import CONDUCTOR, conductor_of
from .looks import NUMBERS, POSITIVE, check_keys, table

#: What the table looks like to an editor.
LOOK = table(
    [],
    shear_yield={
        **POSITIVE,
        "description": "Yield stress in cyclic shear [Pa], for the fatigue index and the shakedown map.",
    },
    lower={**CONDUCTOR, "description": "What conducts in the lower body; steel by default."},
    upper={**CONDUCTOR, "description": "What conducts in the upper body; steel by default."},
    bulk={
        **NUMBERS,
        "minItems": 2,
        "maxItems": 2,
        "description": "Temperatures [K] with which lower and upper body come, over any common level.",
    },
)


def damage_of(given: Any) -> dict[str, Any]:
    """The arguments of :func:`damage_found` that the table means."""
    if not isinstance(given, Mapping):
        raise ValueError("a table, maybe with shear_yield, lower, upper and bulk, is needed")
    check_keys(given, LOOK)
    found: dict[str, Any] = {}
    if "shear_yield" in given:
        found["shear_yield"] = positive("shear_yield", given["shear_yield"], "Pa")
    for side in ("lower", "upper"):
        if side in given:
            try:
                found[side] = conductor_of(given[side])
            except ValueError as error:
                raise ValueError(f"{side}: {error}") from error
    if "bulk" in given:
        found["bulk"] = pair("bulk", given["bulk"], "K")
    return found


def why_not_damage(words: Mapping[str, Any], motion: Any) -> str | None:
    """Why a motion has no such numbers, before anything is solved."""
    if motion is None or motion.dissipation_unit != "Pa":
        return "damage is given without [rolling]: T gamma, fatigue and temperatures are of rolling"
    heat = [name for name in ("lower", "upper", "bulk") if name in words]
    if heat and not motion.is_steady:
        return (
            f"damage.{heat[0]} is given, and the rolling is transient: temperatures are of steady rolling, "
            "so take it or transient out"
        )
    return None


def _heat_of_rolling(
    result: TangentialResult,
    lower: Conductor | None = None,
    upper: Conductor | None = None,
    bulk: tuple[float, float] = (0.0, 0.0),
) -> RollingTemperature | None:
    """Temperatures of the surfaces; None of transient rolling."""
    if not result.motion.is_steady:
        return None
    given = {"lower": lower, "upper": upper}
    bodies = {side: body for side, body in given.items() if body is not None}
    return result.temperature(**bodies, bulk=bulk)


def damage_found(
    result: TangentialResult, shear_yield: float | None = None, **heat: Any
) -> tuple[dict[str, float], RollingTemperature | None]:
    """T gamma [N], the surface fatigue index and the point of the shakedown map [-], and the highest
    temperature [K] in contact, by name; and the temperatures of the surfaces, which transient rolling does
    not have.
    """
    found = {"t_gamma": result.t_gamma(), "t_gamma_with_spin": result.t_gamma(with_spin=True)}
    if shear_yield is not None:
        found["surface_fatigue_index"] = result.surface_fatigue_index(shear_yield)
        found["traction_coefficient"], found["load_factor"] = result.shakedown(shear_yield)
    temperature = _heat_of_rolling(result, **heat)
    if temperature is not None:
        found["peak_temperature"] = temperature.peak
    return found, temperature


def damage_numbers(result: TangentialResult, **words: Any) -> dict[str, float]:
    """The numbers of :func:`damage_found`, a measure of a sweep."""
    return damage_found(result, **words)[0]


def damage_told(numbers: Mapping[str, float]) -> list[tuple[str, str]]:
    """The same in words."""
    names = {
        "t_gamma": ("T gamma", "N"),
        "t_gamma_with_spin": ("T gamma with spin", "N"),
        "surface_fatigue_index": ("surface fatigue index", ""),
        "traction_coefficient": ("creep force over normal force", ""),
        "load_factor": ("peak pressure over yield stress in shear", ""),
        "peak_temperature": ("highest temperature in contact", "K"),
    }
    return [(names[key][0], f"{value:.5g} {names[key][1]}".rstrip()) for key, value in numbers.items()]
