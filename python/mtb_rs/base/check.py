# SPDX-License-Identifier: MIT OR Apache-2.0
"""Numbers at the door: checked once, with the name of the argument in the message."""

from __future__ import annotations

import difflib
import math
import os
import sys
import warnings
from collections.abc import Iterable, Mapping
from inspect import isclass
from pathlib import Path
from typing import Any, get_args

import numpy as np
from numpy.typing import NDArray

#: Numbers larger than this, and positive ones smaller than its inverse, are refused: their products
#: would overflow or vanish, and nothing in SI units is so large or so small.
LARGEST = 1e30

#: Whole numbers are at most so large: nothing is counted, and no loop ends, beyond it.
MOST = 1_000_000_000


def flag(name: str, value: bool) -> bool:
    """A yes or no.

    Raises
    ------
    ValueError
        If it is neither.
    """
    if not isinstance(value, (bool, np.bool_)):
        raise ValueError(f"{name} is {value!r}: True or False is needed")
    return bool(value)


def number(name: str, value: Any, unit: str = "") -> float:
    """`value` as a finite float."""
    if isinstance(value, bool) or not isinstance(value, (int, float, np.integer, np.floating)):
        raise ValueError(f"{name} is {shortened(value)}: a finite number{_in(unit)} is needed")
    try:
        checked = float(value)
    except OverflowError:
        checked = 2.0 * LARGEST
    if not math.isfinite(checked):
        raise ValueError(f"{name} is {shortened(value)}: a finite number{_in(unit)} is needed")
    if abs(checked) > LARGEST:
        raise ValueError(
            f"{name} is {shortened(value)}: a number{_in(unit)} of at most {LARGEST:g} is needed"
        )
    return checked


def positive(name: str, value: Any, unit: str = "") -> float:
    """`value` as a positive float."""
    checked = number(name, value, unit)
    if checked <= 0.0:
        raise ValueError(f"{name} is {shortened(value)}: a positive number{_in(unit)} is needed")
    if checked < 1.0 / LARGEST:
        raise ValueError(
            f"{name} is {value:.6g}: a number{_in(unit)} of at least {1.0 / LARGEST:g} is needed"
        )
    return checked


def not_negative(name: str, value: Any, unit: str = "") -> float:
    """`value` as a float of at least zero."""
    checked = number(name, value, unit)
    if checked < 0.0:
        raise ValueError(f"{name} is {checked:g}{unit and f' {unit}'}: it must not be negative")
    return checked


def whole(name: str, value: Any) -> int:
    """`value` as a positive whole number."""
    if isinstance(value, bool) or not isinstance(value, (int, np.integer)) or value < 1:
        raise ValueError(f"{name} is {shortened(value)}: a positive whole number is needed")
    if value > MOST:
        raise ValueError(f"{name} is {shortened(value)}: a whole number of at most {MOST} is needed")
    return int(value)


def pair(name: str, value: Any, unit: str = "") -> tuple[float, float]:
    """`value` as two finite floats."""
    try:
        first, second = value
    except (TypeError, ValueError):
        raise ValueError(f"{name} is {shortened(value)}: two finite numbers{_in(unit)} are needed") from None
    return number(f"{name}[0]", first, unit), number(f"{name}[1]", second, unit)


def numbers(name: str, value: Any, count: int, unit: str = "") -> tuple[float, ...]:
    """`value` as `count` finite floats."""
    wanted = f"{count} finite numbers{_in(unit)} are needed"
    try:
        entries = () if isinstance(value, str) else tuple(value)
    except TypeError:
        entries = ()
    if len(entries) != count:
        raise ValueError(f"{name} is {shortened(value)}: {wanted}")
    return tuple(number(f"{name}[{k}]", entry, unit) for k, entry in enumerate(entries))


def choice(name: str, value: Any, words: Any) -> Any:
    """`value`, one of `words`: strings, or a Literal of them (:mod:`mtb_rs.base.words`)."""
    choices = get_args(words) or tuple(words)
    if not isinstance(value, str) or value not in choices:
        raise ValueError(f"{name} is {shortened(value)}: one of {', '.join(map(repr, choices))} is needed")
    return value


def one_or_two(name: str, value: Any) -> int:
    """`value`, 1 or 2."""
    if isinstance(value, bool) or not isinstance(value, (int, np.integer)) or value not in (1, 2):
        raise ValueError(f"{name} is {shortened(value)}: 1 or 2 is needed")
    return int(value)


def reals(name: str, values: Any, unit: str = "") -> NDArray[np.float64]:
    """`values` as a C-ordered array of finite floats, of any shape."""
    if is_quantity(values):
        # those of arguments are numbers by now: this one a function gave
        raise ValueError(
            f"{name} is {shortened(values)}: plain numbers{_in(unit)}, without a unit, are needed"
        )
    try:
        given = np.asanyarray(values)
    except (TypeError, ValueError):  # ragged nesting
        given = np.empty(0, dtype=object)
    if given.dtype.kind not in "fiu":
        raise ValueError(f"{name} is {shortened(values)}: real numbers{_in(unit)} are needed")
    refuse_masked(name, given, unit)
    array = np.ascontiguousarray(np.asarray(given), dtype=float).reshape(given.shape)
    bad = ~(np.abs(array) <= LARGEST)
    if bad.any():
        value = float(array[bad][0])
        need = f"numbers of at most {LARGEST:g}" if math.isfinite(value) else "finite numbers"
        raise ValueError(f"{name}{_at(bad)} is {value:.6g}: {need}{_in(unit)} are needed")
    return array


def refuse_outside(name: str, values: NDArray[np.float64], ends: tuple[float, float], unit: str) -> None:
    """Refuses values (n,) outside these ends, with the place of the first one; "1" is no unit."""
    outside = ~((values >= ends[0]) & (values <= ends[1]))
    if outside.any():
        k = int(outside.argmax())
        of = "" if unit == "1" else f" {unit}"
        raise ValueError(
            f"{name}[{k}] is {values[k]:g}{of}: numbers from {ends[0]:g} to {ends[1]:g}{of} are needed"
        )


def is_quantity(value: Any) -> bool:
    """Whether it is a number or an array with a unit, by what it can do."""
    return hasattr(value, "to") and not isclass(value) and (hasattr(value, "units") or hasattr(value, "unit"))


def in_a_row(name: str, values: Any, needed: str) -> list[Any]:
    """The entries of something that has several, a name not being one."""
    if isinstance(values, (str, bytes, Mapping)) or not isinstance(values, Iterable):
        raise ValueError(f"{name} is {shortened(values)}: {needed}, are needed")
    return list(values)


def refuse_masked(name: str, given: NDArray[Any], unit: str = "") -> None:
    """ValueError for an array with masked values: what lies under a mask is no number."""
    masked = np.ma.getmaskarray(given) if isinstance(given, np.ma.MaskedArray) else None
    if masked is not None and masked.any():
        raise ValueError(
            f"{name}{_at(masked)} is masked: masked values are not accepted, "
            f"give every point a number{_in(unit)}"
        )


def path_of(name: str, value: Any) -> Path:
    """`value`, a str or path object, as a Path."""
    if not isinstance(value, (str, os.PathLike)) or not isinstance(os.fspath(value), str):
        raise ValueError(f"{name} is {shortened(value)}: a path is needed")
    if not os.fspath(value) or "\0" in os.fspath(value):
        raise ValueError(f"{name} is {shortened(value)}: a path is needed")
    return Path(value)


def _at(bad: NDArray[np.bool_]) -> str:
    """Place of the first bad entry."""
    if bad.ndim == 0:
        return ""
    return str([int(k) for k in np.argwhere(bad)[0]])


def shortened(value: Any) -> str:
    """`value` as messages show it: in one line."""
    try:
        text = repr(value)
        text = " ".join(text.split()) if "\n" in text else text
    except ValueError:  # whole numbers of thousands of digits
        return "a whole number of thousands of digits"
    return text if len(text) <= 60 else text[:57] + "..."


def _in(unit: str) -> str:
    return f" [{unit}]" if unit else ""


def meant(name: object, known: Iterable[str]) -> str | None:
    """The known name that another one is a slip of the fingers from; None if none is so near."""
    near = difflib.get_close_matches(str(name), list(known), n=1, cutoff=0.75)
    return near[0] if near else None


def in_place(name: object, known: Iterable[str], told: str = "it has") -> str:
    """What stands in place of a name that is not known: the one meant, else all of them, after some words."""
    near = meant(name, known := list(dict.fromkeys(known)))
    return f"did you mean {near}?" if near else f"{told} {', '.join(known)}"


def warn(message: str, kind: type[Warning] = UserWarning) -> None:
    """Warns at the line that called this package, however deep in it the reason was found."""
    own = __name__.partition(".")[0]
    frame, level = sys._getframe(1), 2
    while frame.f_back is not None and frame.f_globals.get("__name__", "").split(".")[0] == own:
        frame, level = frame.f_back, level + 1
    warnings.warn(message, kind, stacklevel=level)
