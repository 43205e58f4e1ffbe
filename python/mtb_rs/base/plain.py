# SPDX-License-Identifier: MIT OR Apache-2.0
"""Objects that are their values: shown in one line, equal where their fields are."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import fields, is_dataclass
from pathlib import Path
from typing import Any, TypeVar

import numpy as np

Class = TypeVar("Class")

#: Longest text of one field and of all, and number of entries of a sequence above which they are counted.
_LONGEST, _LINE, _MANY = 60, 240, 6


def plain(cls: type[Class]) -> type[Class]:
    """Gives a class a representation of one line, unless it has one, and equality by value, arrays included.

    Stands below ``@dataclass``, which keeps what a class already has; on a named tuple it stands alone.
    """
    is_tuple = issubclass(cls, tuple)
    if is_tuple or cls.__dict__.get("__repr__", cls.__mro__[1].__repr__) in (object.__repr__, one_line):
        setattr(cls, "__repr__", one_line)  # noqa: B010
    setattr(cls, "__eq__", equal)  # noqa: B010
    if is_tuple:
        setattr(cls, "__ne__", object.__ne__)  # noqa: B010
    return cls


def one_line(self: Any) -> str:
    """Name and fields, those that differ from their default, in one line: arrays by shape, parts by name.

    Fields beyond a line are left out: the first ones say what it is.
    """
    if hasattr(self, "_fields"):
        return f"{type(self).__name__}({', '.join(f'{n}={short(v)}' for n, v in self._asdict().items())})"
    shown = []
    for entry in fields(self):
        if not entry.repr or entry.name.startswith("_"):
            continue
        value = getattr(self, entry.name)
        is_empty = isinstance(value, (Mapping, tuple, list)) and not value
        if is_empty or value is entry.default or (np.isscalar(value) and same(value, entry.default)):
            continue
        shown.append(f"{entry.name}={short(value)}")
        if sum(map(len, shown)) > _LINE:
            shown[-1] = "..."
            break
    return f"{type(self).__name__}({', '.join(shown)})"


def short(value: Any) -> str:
    """A value as a part of one line: functions by name."""
    if isinstance(value, np.ndarray):
        if value.ndim <= 1 and value.size <= _MANY:
            return f"[{', '.join(short(v) for v in value.tolist())}]" if value.ndim else short(value.item())
        return f"{value.dtype.name} {value.shape}"
    if isinstance(value, float):
        return f"{value:.6g}"
    if isinstance(value, Mapping):
        return f"{{{len(value)} entries}}" if value else "{}"
    if isinstance(value, (tuple, list)) and not hasattr(value, "_fields"):
        opening, closing = "()" if isinstance(value, tuple) else "[]"
        if len(value) > _MANY:
            return f"{opening}{len(value)} entries{closing}"
        text = f"{opening}{', '.join(short(v) for v in value)}{closing}"
    elif is_dataclass(value) or hasattr(value, "_fields"):
        text = repr(value)
        text = text if len(text) <= _LONGEST and "\n" not in text else f"{type(value).__name__}(...)"
    elif callable(value) and hasattr(value, "__name__"):
        text = str(value.__name__)
    elif isinstance(value, Path):
        text = repr(str(value))
    else:
        text = repr(value)
    text = " ".join(text.split())
    return text if len(text) <= _LONGEST else f"{text[: _LONGEST - 3]}..."


def equal(self: Any, other: object) -> Any:
    """Whether both are of one class and their fields the same."""
    return same(self, other) if type(self) is type(other) else NotImplemented


def same(a: Any, b: Any) -> bool:
    """Whether two values are the same, part by part; NaN is NaN."""
    if a is b:
        return True
    if isinstance(a, np.ndarray) or isinstance(b, np.ndarray):
        return _arrayssame(a, b)
    if type(a) is not type(b):
        return isinstance(a, (int, float)) and isinstance(b, (int, float)) and a == b
    if isinstance(a, float):
        return a == b or (a != a and b != b)
    if is_dataclass(a):
        return all(same(getattr(a, f.name), getattr(b, f.name)) for f in fields(a) if f.compare)
    if isinstance(a, Mapping):
        return a.keys() == b.keys() and all(same(a[k], b[k]) for k in a)
    if isinstance(a, (tuple, list)):
        return len(a) == len(b) and all(same(x, y) for x, y in zip(a, b, strict=True))
    return bool(a == b)


def _arrayssame(a: Any, b: Any) -> bool:
    if not (isinstance(a, np.ndarray) and isinstance(b, np.ndarray)) or a.shape != b.shape:
        return False
    return bool(np.array_equal(a, b, equal_nan=a.dtype.kind in "fc" and b.dtype.kind in "fc"))
