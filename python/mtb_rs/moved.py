# SPDX-License-Identifier: MIT OR Apache-2.0
"""Modules that have another place and classes that have another name by now.

Their old names keep working, with a warning that tells the new."""

from __future__ import annotations

import sys
from collections.abc import Callable
from importlib import import_module
from importlib.machinery import ModuleSpec
from types import ModuleType
from typing import Any

from .base.check import warn

#: Old names of modules, and where what they held is now. Some of them are the names of rooms today.
PLACES = {
    "auto": ("scenes.auto",),
    "bodies": ("bodies.simple",),
    "cache": ("base.cache",),
    "chart": ("results.chart", "results.report", "studies.measuring"),
    "chart_page": ("pictures.chart_page",),
    "chart_plot": ("pictures.chart_plot",),
    "chart_scene": ("studies.chart_scene",),
    "check": ("base.check",),
    "creepforce": ("half_space.creep_force", "base.words"),
    "creepforce_table": ("half_space.creep_force_table",),
    "direct": ("scenes.direct", "scenes.convolved"),
    "elastic": ("contact.elastic", "contact.standing", "contact.problem", "bodies.sides", "bodies.faces"),
    "elastic_body": ("bodies.elastic_body",),
    "errors": ("base.errors",),
    "estimate": ("contact.estimate",),
    "export": ("pictures.files", "results.fields", "base.plain"),
    "fingerprint": ("base.fingerprint",),
    "fmu": ("simulation.fmu",),
    "friction": ("friction.laws", "base.words"),
    "geometry": ("geometry.profiles", "geometry.profile_files", "geometry.contact_points", "base.words"),
    "grids": ("results.grids",),
    "hertzian": ("half_space.hertzian", "half_space.ellipse"),
    "incremental": ("contact.incremental",),
    "layout": ("geometry.geometries", "geometry.triangles"),
    "loads": ("friction.fields",),
    "material": ("bodies.material",),
    "memory": ("base.memory",),
    "mesh": ("bodies.mesh",),
    "mesh_files": ("bodies.mesh_files", "bodies.mesh"),
    "normal": ("half_space.normal",),
    "patch": ("half_space.pressure_field",),
    "plot": (
        "pictures.quantities",
        "pictures.plane",
        "pictures.moving",
        "pictures.figures",
        "pictures.maps",
        "pictures.lines",
        "pictures.sweep_plot",
        "base.words",
    ),
    "reference": ("half_space.reference",),
    "report": ("results.report",),
    "result": ("results.result", "geometry.contact_points", "geometry.triangles"),
    "roughness": ("half_space.rough",),
    "scene": ("scenes.scene", "scenes.posed", "scenes.methods"),
    "scenes": ("scenes.ready",),
    "solids": ("contact.solids",),
    "solve": ("contact.solve", "contact.problem", "bodies.sides"),
    "staggered": ("contact.staggered",),
    "start_of_sliding": ("contact.sliding_start",),
    "stepping": ("simulation.stepping",),
    "supports": ("bodies.supports",),
    "surfaces": ("bodies.surfaces",),
    "sweep_checkpoint": ("studies.sweep_checkpoint",),
    "sweep_table": ("results.sweep_table", "base.units"),
    "sweeps": ("studies.sweeps", "studies.sweep_cases"),
    "tangential": (
        "half_space.tangential",
        "half_space.motions",
        "half_space.tangential_result",
        "half_space.tangential_state",
    ),
    "threads": ("base.threads",),
    "view": ("pictures.space",),
    "wheel_result": ("results.wheel_result",),
    "wheel_stepping": ("simulation.wheel_stepping",),
}
#: Old names of classes, functions and tables, and their new ones, by their modules.
CLASSES = {
    "base.units": {"UNITS": "MEASURED_UNITS"},
    "contact.solids": {"BodyLayout": "OwnBodies"},
    "geometry.contact_points": {
        "ContactSheet": "ContactGrid",
        "SheetPoints": "ContactPoints",
        "contact_sheet": "contact_grid",
    },
    "geometry.geometries": {
        "BlockLayout": "BlockOnPlane",
        "FieldLayout": "GapField",
        "Layout": "Geometry",
        "ParaboloidLayout": "ParaboloidOnPlane",
        "ShoeLayout": "ShoeOnRail",
        "WheelLayout": "WheelOnRail",
        "flat_sheet": "flat_grid",
    },
}
#: Rooms that have the name of an old module. (That of cases still holds what it held.)
ROOMS = ("bodies", "friction", "geometry", "scenes")
_PACKAGE = __name__.partition(".")[0]


class _Moved(ModuleType):
    """A module that is not there any more: it hands out what its successors have."""

    def __init__(self, old: str) -> None:
        name = f"{_PACKAGE}.{old}"
        super().__init__(name)
        self.__spec__ = ModuleSpec(name, None)
        self._old = old

    def __getattr__(self, name: str) -> Any:
        return _look_up(self, self._old, name)


def _look_up(module: ModuleType, old: str, name: str) -> Any:
    """What a module held before its contents moved."""
    for place in () if name.startswith("_") else PLACES[old]:
        successor = import_module(f"{_PACKAGE}.{place}")
        new = CLASSES.get(place, {}).get(name, name)
        if _is_held(successor, new):
            found = vars(successor)[new]
            package = sys.modules[_PACKAGE]
            home = _PACKAGE if vars(package).get(new) is found else successor.__name__
            warn(f"{module.__name__}.{name} has moved: take {new} from {home}.", DeprecationWarning)
            return found
    raise AttributeError(f"module {module.__name__!r} has no attribute {name!r}")


def _is_held(module: ModuleType, name: str) -> bool:
    """Whether a module holds something by itself, and does not only use another's."""
    found = vars(module).get(name)
    if found is None or isinstance(found, ModuleType):
        return False
    home = getattr(found, "__module__", None) if callable(found) else None
    return home in (None, module.__name__) or str(home).partition(".")[0] != _PACKAGE


def _old_names(module: ModuleType) -> Callable[[str], Any]:
    """What looks up the names that a module does not have any more."""
    place = module.__name__.removeprefix(f"{_PACKAGE}.")
    new_names = CLASSES.get(place, {})

    def look_up(name: str) -> Any:
        if name in new_names:
            warn(f"{name} of {module.__name__} is called {new_names[name]} now.", DeprecationWarning)
            return getattr(module, new_names[name])
        if place in PLACES:
            return _look_up(module, place, name)
        raise AttributeError(f"module {module.__name__!r} has no attribute {name!r}")

    return look_up


def keep() -> None:
    """Lets the old names be imported.

    Modules are put where the import looks first, and not on its path: it would then set them as attributes
    of the package, where `roughness` and `start_of_sliding` are functions.
    """
    for old in PLACES:
        module: Any = import_module(f"{_PACKAGE}.{old}") if old in ROOMS else _Moved(old)
        if old in ROOMS:
            module.__getattr__ = _old_names(module)
        sys.modules[module.__name__] = module
    for place in CLASSES:
        module = import_module(f"{_PACKAGE}.{place}")
        module.__getattr__ = _old_names(module)
