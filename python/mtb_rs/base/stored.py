# SPDX-License-Identifier: MIT OR Apache-2.0
"""Objects as plain data for files, and back: no more than numbers, text and arrays, checked by their types.

A class whose objects are kept says so by :func:`stored`. What is read makes objects of these classes only,
by their own constructors, from values that fit the types of their fields.
"""

from __future__ import annotations

import dataclasses
import hashlib
import math
import types
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any, Literal, TypeVar, Union, get_args, get_origin, get_type_hints

import numpy as np
from numpy.typing import NDArray

from .fingerprint import fingerprint

C = TypeVar("C", bound=type)

_CLASSES: dict[str, type] = {}
_ARRAY, _FLOAT, _TUPLE, _MAPPING, _CLASS = "array", "float", "tuple", "mapping", "class"


def stored(made: C) -> C:
    """Class decorator, of a dataclass or a named tuple: its objects go into files and come back."""
    _CLASSES[made.__name__] = made
    return made


def plain_data(value: Any) -> Any:
    """`value` as JSON can hold it, for people: None for NaN and infinity, else numbers, lists and text."""
    if value is None or isinstance(value, (bool, str, int)):
        return value
    if isinstance(value, np.generic):
        return plain_data(value.item())
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    if isinstance(value, np.ndarray):
        return plain_data(value.tolist())
    if isinstance(value, Mapping):
        return {str(key): plain_data(item) for key, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [plain_data(item) for item in value]
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        return {f.name: plain_data(getattr(value, f.name)) for f in dataclasses.fields(value) if f.repr}
    return str(value)


#: Most numbers of an array among the inputs that are listed one by one.
MOST_LISTED = 1000


def input_data(value: Any) -> Any:
    """An input as JSON can hold it, so that a reader knows what was solved.

    Large arrays are told by shape, range and digest, functions and other objects by name and digest, and what
    has a method `described` by what that says.
    """
    if hasattr(value, "described"):
        return {name: input_data(part) for name, part in value.described().items()}
    if isinstance(value, (list, tuple)) and not all(isinstance(part, (str, bool)) for part in value):
        try:
            array = np.array(value, dtype=float)
        except (ValueError, TypeError):
            return [input_data(part) for part in value]
        return input_data(array) if array.size > MOST_LISTED else plain_data(value)
    if isinstance(value, np.ndarray) and value.size > MOST_LISTED:
        return {
            "shape": list(value.shape),
            "smallest": plain_data(value.min()),
            "largest": plain_data(value.max()),
            "sha256": array_digest(value),
        }
    if isinstance(value, Mapping):
        return {str(key): input_data(part) for key, part in value.items()}
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        return {f.name: input_data(getattr(value, f.name)) for f in dataclasses.fields(value) if f.repr}
    if value is None or isinstance(value, (bool, str, int, float, np.generic, np.ndarray, list, tuple, Path)):
        return plain_data(value)
    return _object_data(value)


def _object_data(value: Any) -> dict[str, Any]:
    named = {
        "kind": type(value).__name__,
        "name": str(getattr(value, "name", getattr(value, "__name__", ""))),
    }
    try:
        return named | {"sha256": fingerprint(value)}
    except ValueError:  # it hides what it holds
        return named


def array_digest(*arrays: NDArray[Any]) -> str:
    """SHA-256 of the numbers of arrays, with their shapes and types."""
    digest = hashlib.sha256()
    for array in arrays:
        digest.update(f"{array.dtype.str}{array.shape}".encode())
        digest.update(np.ascontiguousarray(array).tobytes())
    return digest.hexdigest()


def without_functions(value: Any) -> Any:
    """`value`, or what :func:`input_data` tells of it if there are functions in it: what can be pickled."""
    return input_data(value) if _has_function(value) else value


def _has_function(value: Any) -> bool:
    if isinstance(value, (list, tuple)):
        return any(map(_has_function, value))
    if dataclasses.is_dataclass(value):
        return any(_has_function(getattr(value, f.name)) for f in dataclasses.fields(value) if f.init)
    return callable(value)


class Packer:
    """Takes objects apart: into what JSON holds exactly, and arrays under the names of their places.

    An array that has a name already, such as a field of a result, or one met before, is not kept twice.
    """

    def __init__(self, named: Mapping[str, NDArray[Any]]) -> None:
        self.arrays: dict[str, NDArray[Any]] = {}
        self._named = dict(named)
        self._known = {id(array): name for name, array in self._named.items()}
        self._taken = set(named)

    def pack(self, value: Any, place: str = "") -> Any:
        """`value` as data; `place` is where it stands, as "report.history"."""
        if value is None or isinstance(value, (bool, int, str)):
            return value
        if isinstance(value, np.generic):
            return self.pack(value.item(), place)
        if isinstance(value, float):
            return value if math.isfinite(value) else {_FLOAT: repr(value)}
        if isinstance(value, np.ndarray):
            return {_ARRAY: self._array(value, place)}
        if type(value).__name__ in _CLASSES and type(value) is _CLASSES[type(value).__name__]:
            parts = {
                name: self.pack(part, f"{place}.{name}" if place else name) for name, part in _parts(value)
            }
            return {_CLASS: type(value).__name__, "of": parts}
        if isinstance(value, (tuple, list)):
            return {_TUPLE: [self.pack(item, f"{place}.{k}") for k, item in enumerate(value)]}
        if isinstance(value, Mapping):
            return {_MAPPING: [[str(k), self.pack(item, f"{place}.{k}")] for k, item in value.items()]}
        # whatever else a user has put in is kept as its text
        return plain_data(value)

    def _array(self, array: NDArray[Any], place: str) -> str:
        if id(array) in self._known:
            return self._known[id(array)]
        name, k = place.replace("/", "_"), 1
        while name in self._taken:
            k += 1
            name = f"{place} {k}"
        self._taken.add(name)
        self.arrays[name] = array
        self._known[id(array)] = name
        return name


def unpack(data: Any, arrays: Mapping[str, NDArray[Any]], place: str = "result") -> Any:
    """The object that was packed; ValueError, naming its place, for what does not make one."""
    if data is None or isinstance(data, (bool, int, float, str)):
        return data
    if not isinstance(data, dict) or len(data) != (2 if _CLASS in data else 1):
        raise ValueError(f"{place} is no value that was saved")
    (kind, content), *others = data.items()
    if kind == _CLASS and others and others[0][0] == "of":
        return _made(content, others[0][1], arrays, place)
    if kind == _FLOAT and content in ("inf", "-inf", "nan"):
        return float(content)
    if kind == _ARRAY and isinstance(content, str):
        if content not in arrays:
            raise ValueError(f"{place} is the array {content!r}, which is missing")
        return arrays[content]
    if kind == _TUPLE and isinstance(content, list):
        return tuple(unpack(item, arrays, f"{place}[{k}]") for k, item in enumerate(content))
    if kind == _MAPPING and isinstance(content, list):
        found = {}
        for pair in content:
            if not isinstance(pair, list) or len(pair) != 2 or not isinstance(pair[0], str):
                raise ValueError(f"{place} is no mapping from names")
            found[pair[0]] = unpack(pair[1], arrays, f"{place}[{pair[0]!r}]")
        return found
    raise ValueError(f"{place} is no value that was saved")


def _made(name: Any, parts: Any, arrays: Mapping[str, NDArray[Any]], place: str) -> Any:
    made = _CLASSES.get(name) if isinstance(name, str) else None
    if made is None or not isinstance(parts, dict):
        raise ValueError(f"{place} is of the kind {name!r}, which is not known")
    hints = get_type_hints(made)
    known = {entry for entry, _ in _entries(made)}
    values = {}
    for entry, data in parts.items():
        where = f"{place}.{entry}"
        if entry not in known:
            raise ValueError(f"{where} is not known")
        values[entry] = unpack(data, arrays, where)
        if not _fits(values[entry], hints[entry]):
            raise ValueError(f"{where} is of the wrong type: {type(values[entry]).__name__}")
    missing = [entry for entry, needed in _entries(made) if needed and entry not in values]
    if missing:
        raise ValueError(f"{place}.{missing[0]} is missing")
    return made(**values)


def _entries(made: type) -> Iterator[tuple[str, bool]]:
    """Names of what an object is made of, and whether it is needed."""
    if not dataclasses.is_dataclass(made):
        yield from ((name, True) for name in getattr(made, "_fields"))  # noqa: B009 (a named tuple)
        return
    for entry in dataclasses.fields(made):
        if entry.init:
            nothing = (entry.default, entry.default_factory)
            yield entry.name, nothing == (dataclasses.MISSING, dataclasses.MISSING)


def _parts(value: Any) -> Iterator[tuple[str, Any]]:
    return ((name, getattr(value, name)) for name, _ in _entries(type(value)))


def _fits(value: Any, hint: Any) -> bool:
    """Whether a value has the type of a field; any word fits a list of words."""
    origin, arguments = get_origin(hint), get_args(hint)
    if hint is Any:
        return True
    if origin in (Union, types.UnionType):
        return any(_fits(value, one) for one in arguments)
    if origin is Literal:
        return isinstance(value, str)
    if hint is float:
        return isinstance(value, (int, float)) and not isinstance(value, bool)
    if hint is int:
        return isinstance(value, int) and not isinstance(value, bool)
    if hint is None:
        return value is None
    if origin is np.ndarray:
        kind = get_args(arguments[1])[0]
        is_text = kind is np.str_ and isinstance(value, np.ndarray) and value.dtype.kind == "U"
        return is_text or (isinstance(value, np.ndarray) and (kind is Any or value.dtype == np.dtype(kind)))
    if origin is tuple:
        if not isinstance(value, tuple):
            return False
        if len(arguments) == 2 and arguments[1] is Ellipsis:
            return all(_fits(item, arguments[0]) for item in value)
        return len(value) == len(arguments) and all(map(_fits, value, arguments))
    if origin is not None and issubclass(origin, Mapping):
        return isinstance(value, Mapping) and all(_fits(item, arguments[1]) for item in value.values())
    return isinstance(value, hint)
