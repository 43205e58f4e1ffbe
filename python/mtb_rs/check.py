# SPDX-License-Identifier: MIT OR Apache-2.0
"""Numbers at the door: checked once, with the name of the argument in the message."""

from __future__ import annotations

import math
from typing import Any

import numpy as np


def number(name: str, value: Any, unit: str = "") -> float:
    """`value` as a finite float."""
    if isinstance(value, bool) or not isinstance(value, (int, float, np.integer, np.floating)):
        raise ValueError(f"{name} is {value!r}: a finite number{_in(unit)} is needed")
    if not math.isfinite(value):
        raise ValueError(f"{name} is {value!r}: a finite number{_in(unit)} is needed")
    return float(value)


def positive(name: str, value: Any, unit: str = "") -> float:
    """`value` as a positive float."""
    checked = number(name, value, unit)
    if checked <= 0.0:
        raise ValueError(f"{name} is {value!r}: a positive number{_in(unit)} is needed")
    return checked


def whole(name: str, value: Any) -> int:
    """`value` as a positive whole number."""
    if isinstance(value, bool) or not isinstance(value, (int, np.integer)) or value < 1:
        raise ValueError(f"{name} is {value!r}: a positive whole number is needed")
    return int(value)


def pair(name: str, value: Any, unit: str = "") -> tuple[float, float]:
    """`value` as two finite floats."""
    try:
        first, second = value
    except (TypeError, ValueError):
        raise ValueError(f"{name} is {value!r}: two finite numbers{_in(unit)} are needed") from None
    return number(f"{name}[0]", first, unit), number(f"{name}[1]", second, unit)


def numbers(name: str, value: Any, count: int, unit: str = "") -> tuple[float, ...]:
    """`value` as `count` finite floats."""
    wanted = f"{count} finite numbers{_in(unit)} are needed"
    try:
        entries = () if isinstance(value, str) else tuple(value)
    except TypeError:
        entries = ()
    if len(entries) != count:
        raise ValueError(f"{name} is {value!r}: {wanted}")
    return tuple(number(f"{name}[{k}]", entry, unit) for k, entry in enumerate(entries))


def array(name: str, value: Any, wanted: str) -> np.ndarray[Any, np.dtype[np.float64]]:
    """`value` as an array of finite floats; `wanted` says which shape and unit."""
    try:
        checked = np.ascontiguousarray(value)
        if checked.dtype.kind not in "fiu":
            raise TypeError
        checked = checked.astype(np.float64)
    except (TypeError, ValueError):
        raise ValueError(f"{name} is {value!r}: {wanted} is needed") from None
    if not np.all(np.isfinite(checked)):
        at = tuple(int(k) for k in np.argwhere(~np.isfinite(checked))[0])
        raise ValueError(f"{name} at {at} is {checked[at]}, not finite: {wanted} is needed")
    return checked


def choice(name: str, value: Any, choices: tuple[str, ...]) -> str:
    """`value`, one of `choices`."""
    if not isinstance(value, str) or value not in choices:
        raise ValueError(f"{name} is {value!r}: one of {', '.join(map(repr, choices))} is needed")
    return value


def _in(unit: str) -> str:
    return f" [{unit}]" if unit else ""
