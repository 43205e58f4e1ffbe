# SPDX-License-Identifier: MIT OR Apache-2.0
"""Frictional elastic contact: magnetic track brakes, wheels on rails."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from . import scenes, threads
from ._mtb_rs import __version__
from .bodies import HalfSpace, Rigid
from .chart import Chart, ChartPoint
from .creepforce import (
    FoundationResult,
    KalkerCoefficients,
    fastsim,
    fastsim_curve,
    kalker_coefficients,
    polach,
)
from .creepforce_table import CreepForceTable
from .elastic_body import ElasticBody
from .errors import (
    CaseError,
    ConvergenceError,
    PictureWarning,
    ResultantError,
    ToleranceWarning,
    ViewError,
)
from .friction import (
    Coulomb,
    FallingFriction,
    InterfaceLayer,
    RailFriction,
    StaticKinetic,
    TabulatedFriction,
)
from .geometry import PoleShoe, Profile, wheel_on_rail_gap
from .hertzian import Hertz, hertz
from .loads import GaussianPressure, PressureDependentFriction, VelocityTable
from .material import Material, steel
from .mesh import TetraMesh
from .normal import NormalResult, solve_normal
from .patch import PressureField
from .report import Report
from .result import Displacement, Result
from .roughness import AreaLoadCurve, area_load_curve, roughness
from .scene import Scene, WheelScene
from .start_of_sliding import StartOfSliding, start_of_sliding
from .stepping import PreparedContact, StepResult, StepState
from .supports import Guide, Support
from .surfaces import BodySurface, surface_gap
from .sweep_table import SweepTable
from .sweeps import sweep
from .tangential import (
    Rolling,
    Shift,
    TangentialResult,
    TangentialState,
    creep_curve,
    solve_tangential,
)
from .wheel_result import WheelPatch, WheelState, WheelStep
from .wheel_stepping import PreparedWheels

if TYPE_CHECKING:
    from .case import Case, load_case
    from .plot import animate
    from .view import write_html

threads.limit()

#: Names that bring heavy packages with them (pydantic, matplotlib): loaded when first used.
_LATER = {"Case": "case", "animate": "plot", "load_case": "case", "write_html": "view"}


def __getattr__(name: str) -> Any:
    if name not in _LATER:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    from importlib import import_module

    return getattr(import_module(f".{_LATER[name]}", __name__), name)


def __dir__() -> list[str]:
    return sorted({*__all__, *(name for name in globals() if name.startswith("__"))})


__all__ = [
    "AreaLoadCurve",
    "BodySurface",
    "Case",
    "CaseError",
    "Chart",
    "ChartPoint",
    "ConvergenceError",
    "Coulomb",
    "CreepForceTable",
    "Displacement",
    "ElasticBody",
    "FallingFriction",
    "FoundationResult",
    "GaussianPressure",
    "Guide",
    "HalfSpace",
    "Hertz",
    "InterfaceLayer",
    "KalkerCoefficients",
    "Material",
    "NormalResult",
    "PictureWarning",
    "PoleShoe",
    "PreparedContact",
    "PreparedWheels",
    "PressureDependentFriction",
    "PressureField",
    "Profile",
    "RailFriction",
    "Report",
    "Result",
    "ResultantError",
    "Rigid",
    "Rolling",
    "Scene",
    "Shift",
    "StartOfSliding",
    "StaticKinetic",
    "StepResult",
    "StepState",
    "Support",
    "SweepTable",
    "TabulatedFriction",
    "TangentialResult",
    "TangentialState",
    "TetraMesh",
    "ToleranceWarning",
    "VelocityTable",
    "ViewError",
    "WheelPatch",
    "WheelScene",
    "WheelState",
    "WheelStep",
    "__version__",
    "animate",
    "area_load_curve",
    "creep_curve",
    "fastsim",
    "fastsim_curve",
    "hertz",
    "kalker_coefficients",
    "load_case",
    "polach",
    "roughness",
    "scenes",
    "solve_normal",
    "solve_tangential",
    "start_of_sliding",
    "steel",
    "surface_gap",
    "sweep",
    "wheel_on_rail_gap",
    "write_html",
]
