# SPDX-License-Identifier: MIT OR Apache-2.0
"""Modules that have another place and classes that have another name by now.

Their old names keep working, with a warning that tells the new."""

from __future__ import annotations

import sys
from collections.abc import Callable, Mapping, Sequence
from importlib import import_module
from importlib.abc import Loader, MetaPathFinder
from importlib.machinery import ModuleSpec
from types import ModuleType
from typing import Any

from .base.check import warn

#: Old names of modules, and where what they held is now.
PLACES = {
    "cache": ("base.cache",),
    "chart": ("results.chart", "results.report", "studies.measuring"),
    "elastic_body": ("bodies.elastic_body",),
    "errors": ("base.errors",),
    "export": ("pictures.files",),
    "layout": ("geometry.geometries", "geometry.triangles"),
    "loads": ("friction.fields",),
    "material": ("bodies.material",),
    "mesh": ("bodies.mesh",),
    "plot": ("pictures.plane", "pictures.quantities", "pictures.moving", "pictures.figures"),
    "reference": ("half_space.reference",),
    "result": ("results.result", "geometry.contact_points", "geometry.triangles"),
    "surfaces": ("bodies.surfaces",),
    "view": ("pictures.space",),
}
#: Old names of classes that objects were pickled with, and their new ones, by their modules.
CLASSES = {
    "contact.solids": {"BodyLayout": "OwnBodies"},
    "geometry.contact_points": {"ContactSheet": "ContactGrid", "SheetPoints": "ContactPoints"},
    "geometry.geometries": {
        "BlockLayout": "BlockOnPlane",
        "FieldLayout": "GapField",
        "Layout": "Geometry",
        "ParaboloidLayout": "ParaboloidOnPlane",
        "ShoeLayout": "ShoeOnRail",
        "WheelLayout": "WheelOnRail",
    },
}
_PACKAGE = __name__.partition(".")[0]


class _Moved(ModuleType):
    """A module that is not there any more: it hands out what its successors have."""

    def __getattr__(self, name: str) -> Any:
        old = self.__name__.removeprefix(f"{_PACKAGE}.")
        modules = [import_module(f"{_PACKAGE}.{place}") for place in PLACES[old]]
        for module in () if name.startswith("__") else modules:
            place = module.__name__.removeprefix(f"{_PACKAGE}.")
            name = CLASSES.get(place, {}).get(name, name)
            found = vars(module).get(name)
            # not where it is only used
            if found is not None and getattr(found, "__module__", module.__name__) == module.__name__:
                warn(
                    f"{self.__name__} has moved: take {name} from {module.__name__}, "
                    f"or from {_PACKAGE} if it is there",
                    DeprecationWarning,
                )
                return found
        raise AttributeError(f"module {self.__name__!r} has no attribute {name!r}")


class _Finder(MetaPathFinder, Loader):
    """Finds the old names."""

    def find_spec(
        self, name: str, path: Sequence[str] | None, target: ModuleType | None = None
    ) -> ModuleSpec | None:
        package, _, old = name.partition(".")
        return ModuleSpec(name, self) if package == _PACKAGE and old in PLACES else None

    def create_module(self, spec: ModuleSpec) -> ModuleType:
        return _Moved(spec.name)

    def exec_module(self, module: ModuleType) -> None:
        """There is nothing in it."""


def _old_classes(module: ModuleType, new_names: Mapping[str, str]) -> Callable[[str], Any]:
    """What looks up the names that a module does not have."""

    def look_up(name: str) -> Any:
        if name not in new_names:
            raise AttributeError(f"module {module.__name__!r} has no attribute {name!r}")
        warn(f"{name} of {module.__name__} is called {new_names[name]} now.", DeprecationWarning)
        return getattr(module, new_names[name])

    return look_up


def keep() -> None:
    """Lets the old names be imported."""
    sys.meta_path.append(_Finder())
    for place, new_names in CLASSES.items():
        module: Any = import_module(f"{_PACKAGE}.{place}")
        module.__getattr__ = _old_classes(module, new_names)
