# SPDX-License-Identifier: MIT OR Apache-2.0
"""What an input is, as a short text: the same for the same input in any process, another for another."""

from __future__ import annotations

import functools
import hashlib
import sys
import sysconfig
from dataclasses import fields, is_dataclass
from dis import get_instructions
from enum import Enum
from pathlib import Path
from types import (
    BuiltinFunctionType,
    CellType,
    CodeType,
    FunctionType,
    MappingProxyType,
    MethodType,
    ModuleType,
)
from typing import Any

import numpy as np

from .owning import Held

_PLAIN = (type(None), bool, int, float, complex, str, bytes, range, slice, type(...), np.generic, Enum)
#: This package.
_OWN = __name__.partition(".")[0]
#: Code in there is known by its name.
_LIBRARIES = tuple(Path(sysconfig.get_path(k)) for k in ("stdlib", "platstdlib", "purelib", "platlib"))


def fingerprint(value: Any) -> str:
    """Tells inputs apart by all they consist of.

    Functions count by their code, defaults, closure and the globals they read, objects by their class and
    what they hold (as pickle sees it).

    Raises
    ------
    ValueError
        If something in it hides what it holds.
    """
    return hashlib.sha256(_Words().of(value).encode("utf-8", "surrogatepass")).hexdigest()


class _Words:
    """Inputs as text; functions and classes are written out where they first appear."""

    def __init__(self) -> None:
        self.known: dict[int, int] = {}
        self.alive: list[Any] = []  # so that no number in `known` is given away again
        self.above: list[int] = []

    def of(self, value: Any) -> str:
        if isinstance(value, _PLAIN):
            return f"{type(value).__name__}:{value!r}"
        if isinstance(value, ModuleType):
            return f"module {value.__name__}"
        if isinstance(value, CodeType):
            return self._code(value)
        if isinstance(value, (FunctionType, type)):
            if id(value) in self.known:
                return f"known {self.known[id(value)]}"
            self.known[id(value)] = len(self.known)
            self.alive.append(value)
            return self._function(value) if isinstance(value, FunctionType) else self._class(value)
        if id(value) in self.above:
            return f"above {len(self.above) - self.above.index(id(value))}"
        self.alive.append(value)
        self.above.append(id(value))
        try:
            return self._parts(value)
        finally:
            self.above.pop()

    def _parts(self, value: Any) -> str:
        if isinstance(value, np.ndarray) and not value.dtype.hasobject:
            content = hashlib.sha256(np.ascontiguousarray(value).tobytes()).hexdigest()
            return f"{value.shape}{value.dtype}{content}"
        if isinstance(value, np.ndarray):
            return f"{value.shape}{self.of(value.tolist())}"
        if type(value) in (dict, Held, MappingProxyType):
            return "{" + ",".join(f"{self.of(k)}:{self.of(v)}" for k, v in value.items()) + "}"
        if type(value) in (list, tuple):
            return "[" + ",".join(map(self.of, value)) + "]"
        if type(value) in (set, frozenset):
            return "{" + ",".join(sorted(map(self.of, value))) + "}"
        if is_dataclass(value) and type(value).__module__.startswith(f"{_OWN}."):
            named = ",".join(
                f"{f.name}={self.of(getattr(value, f.name))}" for f in fields(value) if f.compare and f.init
            )
            return f"{type(value).__name__}({named})"
        if isinstance(value, MethodType):
            return f"method({self.of(value.__self__)},{self.of(value.__func__)})"
        if isinstance(value, BuiltinFunctionType):
            return f"builtin({self.of(value.__self__)},{value.__qualname__})"
        if isinstance(value, np.ufunc):
            return f"ufunc {value.__name__}"
        return self._object(value)

    def _object(self, value: Any) -> str:
        try:
            reduced = value.__reduce_ex__(4)
        except Exception as error:  # objects raise what they like here
            raise ValueError(
                f"{value!r} cannot be told apart from another {type(value).__qualname__} ({error})"
            ) from error
        if isinstance(reduced, str):
            wrapped = getattr(value, "__wrapped__", None)
            module = getattr(value, "__module__", "")
            return f"{type(value).__qualname__} {module}.{reduced}{self.of(wrapped)}"
        # how it is built, from what; its state; what it holds as a list and as a dictionary
        held = [*reduced[:3], *(list(more) for more in reduced[3:5] if more is not None)]
        return f"object({self.of(type(value))},{self.of(held)})"

    def _function(self, function: FunctionType) -> str:
        title = f"{function.__module__}.{function.__qualname__}"
        if _in_library(function.__module__) and "<" not in title:
            return title
        cells = [self.of(cell.cell_contents) for cell in function.__closure__ or () if cell != CellType()]
        read = {}
        if not _in_library(function.__module__):
            read = {
                k: function.__globals__[k] for k in _names(function.__code__) if k in function.__globals__
            }
        held = [function.__defaults__, function.__kwdefaults__, read]
        return f"{title}({self._code(function.__code__)},{self.of(held)},{cells})"

    def _code(self, code: CodeType) -> str:
        constants = [self.of(c) for c in code.co_consts]
        return f"{code.co_code.hex()}{code.co_names}{constants}"

    def _class(self, kind: type) -> str:
        name = f"{kind.__module__}.{kind.__qualname__}"
        if _in_library(kind.__module__):
            return name
        # what `class` itself puts there says nothing, and some of it differs between processes
        own = {
            k: v
            for k, v in vars(kind).items()
            if isinstance(v, FunctionType) or not (k.startswith("__") or k == "_abc_impl")
        }
        parts = [f"{k}={self.of(_unwrapped(v))}" for k, v in own.items()]
        return f"{name}({parts},{[self.of(base) for base in kind.__bases__]})"


def _names(code: CodeType) -> list[str]:
    """Globals a function reads, those of the functions inside it included; attributes are none."""
    own = {str(i.argval) for i in get_instructions(code) if i.opname in ("LOAD_GLOBAL", "LOAD_NAME")}
    inner = {name for c in code.co_consts if isinstance(c, CodeType) for name in _names(c)}
    return sorted(own | inner)


def _unwrapped(member: Any) -> Any:
    if isinstance(member, (staticmethod, classmethod)):
        return member.__func__
    if isinstance(member, property):
        return [member.fget, member.fset]
    if isinstance(member, functools.cached_property):
        return member.func
    # slots and the like: their values are in the state
    return member.__name__ if hasattr(member, "__objclass__") else member


@functools.cache
def _in_library(name: str) -> bool:
    """Whether a module is of Python, of an installed package, or of this one."""
    top = name.partition(".")[0]
    if top in sys.builtin_module_names or top in sys.stdlib_module_names or top == _OWN:
        return top != "__main__"
    path = getattr(sys.modules.get(name), "__file__", None)
    return path is not None and any(Path(path).is_relative_to(folder) for folder in _LIBRARIES)
