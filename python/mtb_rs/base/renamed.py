# SPDX-License-Identifier: MIT OR Apache-2.0
"""Arguments and attributes that have got another name: the old one still works, and says the new one."""

from __future__ import annotations

import inspect
from collections.abc import Callable
from dataclasses import MISSING, fields
from functools import wraps
from typing import Any, TypeVar, cast

from .check import warn

Named = TypeVar("Named", bound=Callable[..., Any])


def renamed(**new_names: str) -> Callable[[Named], Named]:
    """Decorator of a function or of a class: keyword arguments are taken under their old names as well.

    Parameters
    ----------
    **new_names : str
        The new name of each old one. Of a class, the old name stays readable as an attribute, too, and
        objects that were pickled with it can be loaded.

    Warns
    -----
    DeprecationWarning
        Where an old name is used; it names the new one.
    """

    def decorate(called: Named) -> Named:
        if inspect.isclass(called):
            made: Any = called
            known = inspect.signature(made).parameters
            arguments = {old: new for old, new in new_names.items() if new in known}
            made.__init__ = _translating(made.__init__, made.__name__, arguments)
            made.__setstate__ = _restoring(getattr(made, "__setstate__", _restore), new_names)
            for old, new in new_names.items():
                setattr(made, old, property(_reader(f"{made.__name__}.{old}", new)))
            return cast(Named, made)
        # a method is known by its own name: its class may be one that others stand on
        return cast(Named, _translating(called, called.__name__, new_names))

    return decorate


def _translating(build: Callable[..., Any], name: str, new_names: dict[str, str]) -> Callable[..., Any]:
    @wraps(build)
    def translated(*args: Any, **kwargs: Any) -> Any:
        for old in new_names.keys() & kwargs.keys():
            new = new_names[old]
            if new in kwargs:
                raise TypeError(f"{name}() got both {new} and {old}, its old name")
            warn(f"The argument {old} of {name} is called {new} now.", DeprecationWarning)
            kwargs[new] = kwargs.pop(old)
        return build(*args, **kwargs)

    return translated


def _restore(self: Any, state: dict[str, Any]) -> None:
    self.__dict__.update(state)


def _restoring(restore: Callable[..., None], new_names: dict[str, str]) -> Callable[..., None]:
    def renamed_and_restored(self: Any, state: dict[str, Any]) -> None:
        # what has come since has its default
        since = {f.name: f.default for f in fields(self) if f.default is not MISSING}
        restore(self, since | {new_names.get(name, name): value for name, value in state.items()})

    return renamed_and_restored


def _reader(place: str, new: str) -> Callable[[Any], Any]:
    def read(self: Any) -> Any:
        warn(f"{place} is called {new} now.", DeprecationWarning)
        return getattr(self, new)

    return read
