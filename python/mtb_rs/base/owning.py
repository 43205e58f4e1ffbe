# SPDX-License-Identifier: MIT OR Apache-2.0
"""Objects own what they keep: no change of the caller's arrays reaches them, and nobody changes theirs."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import fields
from functools import cache, wraps
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from .check import refuse_masked
from .errors import ConvergenceError

C = TypeVar("C")

#: Kinds of values that hold no array; asked first, because a step asks many times.
_PLAIN = frozenset({type(None), bool, int, float, complex, str})


def frozen(array: NDArray[Any]) -> NDArray[Any]:
    """The array, or a copy of it, in memory that nobody can write to."""
    if array.dtype.hasobject or not array.size:
        held = array.copy()
        held.flags.writeable = False
        return held
    base: Any = array
    while isinstance(base, np.ndarray):
        if base.flags.writeable:
            break
        base = base.base
    if isinstance(base, bytes) and type(array) is np.ndarray and array.flags.c_contiguous:
        return array
    return np.frombuffer(np.asarray(array).tobytes(), array.dtype).reshape(array.shape)


def owned(value: Any, name: str = "value") -> Any:
    """`value` with the arrays it holds frozen; lists become tuples, mappings are copied and held.

    Raises
    ------
    ValueError
        For masked values: an array of one's own has no mask.
    """
    if isinstance(value, np.ndarray):
        refuse_masked(name, value)
        return frozen(value)
    if isinstance(value, tuple) and hasattr(value, "_make"):
        return type(value)._make(owned(entry, f"{name}[{k}]") for k, entry in enumerate(value))
    if type(value) in (list, tuple):
        return tuple(owned(entry, f"{name}[{k}]") for k, entry in enumerate(value))
    if isinstance(value, Mapping):
        return Held(
            (key, owned(entry, key if isinstance(key, str) else name)) for key, entry in value.items()
        )
    return value


class Held(dict[Any, Any]):
    """A dictionary that nobody can change; its copies and unions are plain ones."""

    def _refuse(self, *_: Any, **__: Any) -> Any:
        raise TypeError(
            "this mapping belongs to an object that does not change: make a new one with dict(...)"
        )

    __setitem__ = __delitem__ = __ior__ = _refuse
    clear = pop = popitem = setdefault = update = _refuse

    def __reduce__(self) -> tuple[Any, ...]:
        return Held, (dict(self),)


def owning(made: type[C]) -> type[C]:
    """Class decorator: instances of a frozen dataclass own what they keep, unpickled ones too."""
    return _built(made, own)


def solved(made: type[C]) -> type[C]:
    """Class decorator of what solvers return: an owning dataclass none of whose numbers is NaN or infinite.

    Making one that has such a number raises :class:`mtb_rs.ConvergenceError`. Numbers that may be infinite
    are named by the class, as ``_unbounded``.
    """

    def keep(self: Any) -> None:
        own(self)
        for name in _kept(self.__class__):
            value = getattr(self, name)
            if _lost(value) is not None and name not in getattr(made, "_unbounded", ()):
                check_finite(f"{name} of the {made.__name__}", value)

    setattr(made, "_is_solved", True)  # noqa: B010
    return _built(made, keep)


def is_solved(made: type) -> bool:
    """Whether solvers return it: :func:`solved`."""
    return "_is_solved" in vars(made)


def _built(made: type[C], keep: Callable[[Any], None]) -> type[C]:
    build: Callable[..., None] = vars(made)["__init__"]

    @wraps(build)
    def __init__(self: Any, *args: Any, **kwargs: Any) -> None:
        build(self, *args, **kwargs)
        keep(self)

    def __setstate__(self: Any, state: dict[str, Any]) -> None:
        self.__dict__.update(state)
        own(self)

    changed: Any = made
    changed.__init__ = __init__
    if "__setstate__" not in vars(made):
        changed.__setstate__ = __setstate__
    return made


def own(self: Any) -> None:
    """Freezes what an instance of a frozen dataclass keeps."""
    for name in _given(self.__class__):
        value = getattr(self, name, None)
        if type(value) not in _PLAIN and isinstance(value, (np.ndarray, list, tuple, Mapping)):
            object.__setattr__(self, name, owned(value, name))


@cache
def _kept(made: type) -> tuple[str, ...]:
    """Names of the fields of a dataclass."""
    return tuple(entry.name for entry in fields(made))


@cache
def _given(made: type) -> tuple[str, ...]:
    """Those that it is given: what it notes down for itself later it may change."""
    return tuple(entry.name for entry in fields(made) if entry.init)


def check_finite(name: str, value: Any) -> Any:
    """`value`, if all of its numbers are finite.

    Raises
    ------
    ConvergenceError
        Naming the first one that is NaN or infinite.
    """
    place = _lost(value)
    if place is not None:
        raise ConvergenceError(
            f"the solution has lost its numbers: {name}{place} is NaN or infinite. The input may be too "
            "large, too small or too uneven for floating-point numbers"
        )
    return value


def _lost(value: Any) -> str | None:
    """Place of the first number that is NaN or infinite; None if there is none."""
    if isinstance(value, float):
        return None if math.isfinite(value) else ""
    if type(value) in _PLAIN:
        return None
    if isinstance(value, np.ndarray):
        if value.dtype.kind not in "fc" or np.isfinite(value).all():
            return None
        return str([int(k) for k in np.argwhere(~np.isfinite(value))[0]])
    if isinstance(value, np.generic):
        return _lost(np.asarray(value))
    entries: list[tuple[str, Any]] = []
    if isinstance(value, Mapping):
        entries = [(f"[{name!r}]", entry) for name, entry in value.items()]
    elif isinstance(value, tuple):
        entries = [(f"[{k}]", entry) for k, entry in enumerate(value)]
    places = ((name, _lost(entry)) for name, entry in entries)
    return next((name + place for name, place in places if place is not None), None)
