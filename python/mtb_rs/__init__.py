# SPDX-License-Identifier: MIT OR Apache-2.0
"""Frictional elastic contact: magnetic track brakes, wheels on rails."""

from __future__ import annotations

import sys
from typing import TYPE_CHECKING, Any

from . import moved, scenes
from ._mtb_rs import __version__
from .base import threads, units
from .base.errors import (
    CaseError,
    ConvergenceError,
    PictureWarning,
    ResultantError,
    ToleranceWarning,
    TooLargeError,
    ViewError,
)
from .bodies.conductor import Conductor, conducting_steel
from .bodies.elastic_body import ElasticBody
from .bodies.material import Material, steel
from .bodies.mesh import TetraMesh
from .bodies.prism import Prism
from .bodies.simple import HalfSpace, Layered, Rigid, Viscoelastic
from .bodies.supports import Guide, Support
from .bodies.surfaces import BodySurface, surface_gap
from .contact.sliding_heat import SlidingHeat
from .contact.sliding_start import StartOfSliding, start_of_sliding
from .friction.field_table import FieldTable
from .friction.fields import GaussianPressure, PressureDependentFriction, VelocityTable
from .friction.laws import (
    Coulomb,
    FallingFriction,
    InterfaceLayer,
    PlasticLayer,
    RailFriction,
    StaticKinetic,
    TabulatedFriction,
    ThinLayer,
)
from .friction.magnet import Magnet
from .friction.wear_laws import Archard, EnergyWear, Rubbing, WearLaw, WearMap
from .geometry.pole_shoe import PoleShoe
from .geometry.profiles import Profile
from .geometry.slices import RailSlices, WheelSlices
from .geometry.smoothing import Smoothing
from .geometry.wheel_rail import wheel_on_rail_gap
from .half_space.chain import gradient_of_steps
from .half_space.creep_force import (
    FoundationResult,
    KalkerCoefficients,
    fastrip,
    fastrip_curve,
    fastsim,
    fastsim_curve,
    kalker_coefficients,
    polach,
)
from .half_space.creep_force_table import CreepForceTable
from .half_space.hertzian import Hertz, hertz
from .half_space.motions import Rolling, Shift
from .half_space.normal import NormalResult, solve_normal
from .half_space.pressure_field import PressureField
from .half_space.rough import AreaLoadCurve, area_load_curve, roughness
from .half_space.rough_layer import RoughLayer
from .half_space.tangential import creep_curve, solve_tangential
from .half_space.tangential_result import TangentialResult
from .half_space.tangential_state import TangentialState
from .half_space.temperature_friction import TemperatureFriction
from .results.chart import Chart, ChartPoint
from .results.damage import rail_damage
from .results.derivatives import Gradient, Margin
from .results.fields import Field
from .results.report import Report
from .results.result import Displacement, Result
from .results.solid import Solid
from .results.stress_field import StressField
from .results.sweep_table import SweepTable
from .results.temperature import RollingTemperature
from .results.wear_result import WearResult
from .results.wheel_result import WheelPatch, WheelState, WheelStep
from .results.with_jax import jax_function
from .scenes.scene import Scene, WheelScene
from .simulation.reduced import ReducedBody
from .simulation.stability import Stability
from .simulation.stepping import PreparedContact, StepResult, StepState
from .simulation.vibrating import VibratingContact, VibratingState, VibratingStep
from .simulation.vibration import Vibration, vibration
from .simulation.wheel_stepping import PreparedWheels
from .studies.brake import brake
from .studies.braking import Braking
from .studies.conicity import equivalent_conicity, klingel_wavelength
from .studies.stops import wear_of_stops
from .studies.sweeps import sweep
from .studies.wear import Passages, wear
from .studies.wheel_step import step_wheels
from .studies.wheel_wear import WheelWear, wear_of_wheels
from .studies.wheelset_geometry import TouchingWheel, WheelsetGeometry, wheelset_geometry

if TYPE_CHECKING:
    from pathlib import Path

    from .case import Case, load_case
    from .pictures.moving import animate
    from .pictures.space import write_html

    def load(
        saved: str | Path,
    ) -> (
        Result
        | NormalResult
        | TangentialResult
        | FoundationResult
        | RollingTemperature
        | SlidingHeat
        | Hertz
        | StepResult
        | StartOfSliding
        | WheelStep
        | WheelPatch
        | Chart
        | StressField
        | SweepTable
        | AreaLoadCurve
        | WearResult
        | Braking
        | Stability
        | Vibration
        | WheelWear
        | WheelsetGeometry
    ):
        """What was saved, of the kind that was saved; the room of results does not know them all."""
else:
    from .results.saved import load

threads.limit()
moved.keep()
units.take_quantities(entry for entry in list(globals().values()) if isinstance(entry, type))

#: Names that bring heavy packages with them (pydantic, matplotlib): loaded when first used.
_LATER = {"Case": "case", "animate": "pictures.moving", "load_case": "case", "write_html": "pictures.space"}


#: Rooms that do, likewise.
_ROOMS_LATER = ("case", "pictures")


def __getattr__(name: str) -> Any:
    from importlib import import_module

    if name in _ROOMS_LATER:
        return import_module(f".{name}", __name__)
    if name not in _LATER:
        if name in moved.PLACES:
            return sys.modules[f"{__name__}.{name}"]
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(f".{_LATER[name]}", __name__), name)


def __dir__() -> list[str]:
    return sorted({*__all__, *(name for name in globals() if name.startswith("__"))})


__all__ = [
    "Archard",
    "AreaLoadCurve",
    "BodySurface",
    "Braking",
    "Case",
    "CaseError",
    "Chart",
    "ChartPoint",
    "Conductor",
    "ConvergenceError",
    "Coulomb",
    "CreepForceTable",
    "Displacement",
    "ElasticBody",
    "EnergyWear",
    "FallingFriction",
    "Field",
    "FieldTable",
    "FoundationResult",
    "GaussianPressure",
    "Gradient",
    "Guide",
    "HalfSpace",
    "Hertz",
    "InterfaceLayer",
    "KalkerCoefficients",
    "Layered",
    "Magnet",
    "Margin",
    "Material",
    "NormalResult",
    "Passages",
    "PictureWarning",
    "PlasticLayer",
    "PoleShoe",
    "PreparedContact",
    "PreparedWheels",
    "PressureDependentFriction",
    "PressureField",
    "Prism",
    "Profile",
    "RailFriction",
    "RailSlices",
    "ReducedBody",
    "Report",
    "Result",
    "ResultantError",
    "Rigid",
    "Rolling",
    "RollingTemperature",
    "RoughLayer",
    "Rubbing",
    "Scene",
    "Shift",
    "SlidingHeat",
    "Smoothing",
    "Solid",
    "Stability",
    "StartOfSliding",
    "StaticKinetic",
    "StepResult",
    "StepState",
    "StressField",
    "Support",
    "SweepTable",
    "TabulatedFriction",
    "TangentialResult",
    "TangentialState",
    "TemperatureFriction",
    "TetraMesh",
    "ThinLayer",
    "ToleranceWarning",
    "TooLargeError",
    "TouchingWheel",
    "VelocityTable",
    "VibratingContact",
    "VibratingState",
    "VibratingStep",
    "Vibration",
    "ViewError",
    "Viscoelastic",
    "WearLaw",
    "WearMap",
    "WearResult",
    "WheelPatch",
    "WheelScene",
    "WheelSlices",
    "WheelState",
    "WheelStep",
    "WheelWear",
    "WheelsetGeometry",
    "__version__",
    "animate",
    "area_load_curve",
    "brake",
    "conducting_steel",
    "creep_curve",
    "equivalent_conicity",
    "fastrip",
    "fastrip_curve",
    "fastsim",
    "fastsim_curve",
    "gradient_of_steps",
    "hertz",
    "jax_function",
    "kalker_coefficients",
    "klingel_wavelength",
    "load",
    "load_case",
    "polach",
    "rail_damage",
    "roughness",
    "scenes",
    "solve_normal",
    "solve_tangential",
    "start_of_sliding",
    "steel",
    "step_wheels",
    "surface_gap",
    "sweep",
    "vibration",
    "wear",
    "wear_of_stops",
    "wear_of_wheels",
    "wheel_on_rail_gap",
    "wheelset_geometry",
    "write_html",
]
