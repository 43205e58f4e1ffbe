# SPDX-License-Identifier: MIT OR Apache-2.0
"""Units of arguments and of measured quantities, and quantities with a unit at the door.

Columns of pandas and arrays of xarray are taken wherever an argument has a unit, as plain numbers in it.
Quantities of pint, astropy and unyt are taken wherever an argument has a unit. They are known by what they
can do, ``value.to(unit)``; none of these packages is imported. All that is kept is plain numbers in SI units.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from functools import wraps
from inspect import CO_VARKEYWORDS, isfunction, signature, unwrap
from typing import Any, TypeVar, cast

import numpy as np

from .check import is_quantity, shortened
from .owning import is_solved

Function = TypeVar("Function", bound=Callable[..., Any])
#: Unit of a number, or of each entry of a sequence.
Unit = str | tuple[str, ...]

_LENGTHS = (
    "accumulated_plastic_slip approach center conforming_to element_size flange_back gap gauge "
    "gauge_depth depths height heights inner_edge lateral length longest memory nodes origin outer_edge "
    "radii radius radius_y non_magnetic_gap pole_length rail_length rail_position reach reference "
    "reference_point rms_height roll_off roller_radius s semi_axes shift "
    "shortest sigma size spacing start step tape_circle thickness vertices wheel_radius width x y z "
    "right_wheel_radius "
    "departure depth features positions "
    "displacement displacements where amplitude base kinks radius_difference shifts wavelength"
)
_RATIOS = (
    "coefficient floor friction hurst iron_share kinetic points poisson_ratio poles ratio ratios "
    "reduction relief_slope right_friction slope_reduction "
    "conicity rms_slope static stop_tolerance tangential_ratio tilts tolerance"
)
#: Units of all public arguments that have one, by name; of a sequence whose entries differ, of each.
ARGUMENT_UNITS: dict[str, Unit] = {
    **dict.fromkeys(_LENGTHS.split(), "m"),
    **dict.fromkeys(_RATIOS.split(), "1"),
    **dict.fromkeys(
        (
            "angle",
            "angles",
            "contact_angle",
            "inclination",
            "kink_angle",
            "pitch",
            "rail_inclination",
            "roll",
            "spin",
            "yaw",
        ),
        "rad",
    ),
    **dict.fromkeys(("half_slip", "memory_min_slip", "slip_speed", "standstill_speed", "velocity"), "m/s"),
    **dict.fromkeys(
        ("contact_pressure", "magnetic_pressure", "peak", "pressure", "pressures", "traction"), "Pa"
    ),
    **dict.fromkeys(("contact_modulus", "hardness", "shear_modulus", "yield_stress", "young_modulus"), "Pa"),
    **dict.fromkeys(
        ("force", "forces", "lateral_force", "longitudinal_force", "normal_force", "rail_force"), "N"
    ),
    **dict.fromkeys(("axle_moment", "moments", "moments_about_axes"), "N m"),
    **dict.fromkeys(("budget", "creep_time", "dt", "duration"), "s"),
    **dict.fromkeys(("creepage", "creepages"), ("1", "1", "1/m")),
    "area": "m^2",
    "curvature": "1/m",
    "foundation": "N/m^2",
    "rail_stiffness": "N/m",
    **dict.fromkeys(("bulk", "temperature"), "K"),
    "resistance": "K m^2/W",
    "film": ("W/K/m^2", "K"),
    "share": "1",
    "energy": "Pa",
    **dict.fromkeys(("law", "lower_law", "wear_coefficient"), "1/Pa"),
    **dict.fromkeys(("distance", "limit"), "m"),
    **dict.fromkeys(("creep", "k", "slip", "uniformity"), "1"),
    "ampere_turns": "A",
    "armature": ("m", "m^2"),
    "yoke": ("m", "m^2"),
    "leakage": "H",
    "conductivity": "W/(m K)",
    "conductivity_slope": "W/(m K^2)",
    "expansion": "1/K",
    "expansion_slope": "1/K^2",
    "fading": ("K", "1"),
    "mass": "kg",
    "other_force": "N",
    "shares": "1",
    **dict.fromkeys(("wear", "lower_wear"), "1/Pa"),
    "density": "kg/m^3",
    "frequency": "Hz",
    **dict.fromkeys(("diagonal", "normal_layer"), "m/Pa"),
    "displacement_tolerance": "1",
    "distance_tolerance": "m",
    "force_tolerance": "N",
    "hardening": "Pa/m",
    "rate": "kg/m^3",
    "rigid_slip": "1",
    "speed": "m/s",
    "frames_per_second": "1/s",
    "pose": ("m", "m", "m", "rad", "rad", "rad"),
    **dict.fromkeys(("residual_stress", "shear_yield"), "Pa"),
    "specific_heat": "J/(kg K)",
    "t_gamma": "N",
    "value": "1 or Pa",
}
#: In place of a unit: that of what another argument names, which is known, and converted to, further on.
LATER = "later"
#: Columns that a table of pandas has, in any order, where it stands for one of these arguments.
COLUMNS = dict.fromkeys(("creepage", "creepages"), ("xi", "eta", "phi"))
#: Where an argument of this name has another unit.
EXCEPTIONS: dict[str, dict[str, Unit]] = {
    # one method of many results
    **{
        f"{name}.stress": {"points": "m"}
        for name in (
            *("FoundationResult", "Hertz", "NormalResult", "Result", "SlidingHeat", "StartOfSliding"),
            *("StepResult", "Stressed", "TangentialResult", "WearResult", "WheelPatch", "WheelStep"),
        )
    },
    "Rolling.along_arc": {"roll": "1/m"},
    "Prism": {"profile": "m", "base": "m", "origin": "m"},
    "Shift": {"rigid_slip": "m"},
    # of components that are displacements and of those that are rotations
    **{
        f"PreparedContact.{name}": dict.fromkeys(("mass", "stiffness", "damping"), LATER)
        for name in ("stability", "vibrating")
    },
    "VibratingContact.struck": {"rate": LATER},
    "VibratingContact.step": {"load": LATER},
    # the motion of a wheelset: (vx, vy, vz, wx, wy, wz); a number is a velocity
    # and rails and wheels beside their places, with the rates
    **{
        name: {
            "velocity": ("m/s", "m/s", "m/s", "rad/s", "rad/s", "rad/s"),
            "rails": ("m", "m", "rad", "m/s", "m/s", "rad/s"),
            "wheels": ("m", "m", "m", "rad", "rad", "rad", "m/s", "m/s", "m/s", "rad/s", "rad/s", "rad/s"),
        }
        for name in ("PreparedWheels.step", "PreparedWheels.save_fmu", "step_wheels")
    },
}
#: Units of the quantities a sweep measures by itself.
MEASURED_UNITS = {
    "force_x": "N",
    "force_y": "N",
    "force_z": "N",
    "moment_x": "N m",
    "moment_y": "N m",
    "moment_z": "N m",
    "spin_moment": "N m",
    "creepage_x": "1",
    "creepage_y": "1",
    "creepage_spin": "1/m",
    "displacement_x": "m",
    "displacement_y": "m",
    "displacement_spin": "rad",
    "stick_area": "m^2",
    "rolling_resistance": "N",
    "t_gamma": "N",
    "t_gamma_with_spin": "N",
    "surface_fatigue_index": "1",
    "traction_coefficient": "1",
    "load_factor": "1",
    "normal_force": "N",
    "peak_pressure": "Pa",
    "contact_area": "m^2",
    "approach": "m",
    "wedging_margin": "1",
    "error_estimate": "1",
    "residual": "1",
    "iterations": "1",
    "time": "s",
    "distance": "m",
    "depth_upper": "m",
    "depth_lower": "m",
    "volume_upper": "m^3",
    "volume_lower": "m^3",
    "uniformity": "1",
    "duration": "s",
    "way": "m",
    "end_speed": "m/s",
    "friction_energy": "J",
    "heat_energy_upper": "J",
    "peak_temperature": "K",
    "mean_temperature": "K",
    "error_of_steps": "1",
    "steps": "1",
    "slip_share": "1",
    "path_error": "1",
    "vertical_force_left": "N",
    "vertical_force_right": "N",
    "y": "m",
    "z": "m",
    "roll": "rad",
    "rotation": "rad/s",
    "contact_angle": "rad",
    "friction_power": "W",
    "patches": "1",
    "normal_solves": "1",
}
#: What is no quantity, at a glance.
_PLAIN = (float, int, str, bool, type(None), np.ndarray, np.float64)


class _Shown(str):
    """Text that messages show without quotation marks."""

    __repr__ = str.__str__


def unit_of_argument(name: str) -> str:
    """The unit of an argument whose entries have one unit; empty where it has none."""
    unit = ARGUMENT_UNITS.get(_last(name), "")
    return unit if isinstance(unit, str) else ""


def _last(name: str) -> str:
    """The argument that a name like "rolling.velocity" means."""
    return name.rpartition(".")[2]


def in_si(place: str, value: Any, unit: Unit | None) -> Any:
    """`value` with the quantities in it, at any depth of lists and mappings, as plain numbers in `unit`.

    Entries of a mapping whose name is that of an argument are in its unit.

    Raises
    ------
    ValueError
        If a quantity has another dimension, or none is accepted here; it names the place, the value and the
        unit needed.
    """
    kind = type(value)
    if kind in _PLAIN:
        return value if kind is not np.ndarray or value.dtype.kind != "O" else _of_objects(place, value, unit)
    if kind in (list, tuple):
        is_row = not any(type(entry) in (list, tuple) for entry in value)
        each = isinstance(unit, tuple) and is_row and len(unit) == len(value)
        units = cast(tuple[str, ...], unit) if each else (unit,) * len(value)
        taken = [in_si(f"{place}[{k}]", v, u) for k, (v, u) in enumerate(zip(value, units, strict=True))]
        changed = any(a is not b for a, b in zip(taken, value, strict=True))
        return kind(taken) if changed else value
    if isinstance(value, Mapping):
        return _of_mapping(place, value, unit)
    if unit is not None and hasattr(value, "to_numpy"):
        return _of_table(place, value, unit)
    return _converted(place, value, unit) if is_quantity(value) else value


def _of_mapping(place: str, value: Mapping[Any, Any], unit: Unit | None) -> Any:
    taken = {}
    for name, entry in value.items():
        own = ARGUMENT_UNITS.get(_last(name), unit) if isinstance(name, str) else unit
        taken[name] = in_si(f"{place}[{name!r}]", entry, own)
    return taken if any(taken[name] is not entry for name, entry in value.items()) else value


def _of_table(place: str, value: Any, unit: Unit) -> Any:
    """A column or table of pandas, or an array of xarray, as numbers: x and y in our order."""
    said = getattr(value, "attrs", {}).get("units", unit)
    if said != unit and said not in str(unit).split(" or "):
        raise ValueError(f"{place} is in {said!r}, as its attribute says: numbers in {unit} are needed")
    axes = _axes(value)
    if axes:
        value = value.transpose(..., axes["y"], axes["x"]).sortby(
            [a for a in axes.values() if a in value.coords]
        )
    elif _places(value):
        value = value.sort_index(axis=0).sort_index(axis=1)
    held = getattr(value, "data", None)
    if is_quantity(held):
        return _converted(place, held, unit)
    array = _in_order(place, value).to_numpy()
    if array.dtype.kind == "O":
        array = _of_objects(place, array, unit)
    return array.item() if array.ndim == 0 else array


def _of_objects(place: str, array: Any, unit: Unit | None) -> Any:
    """An array of objects, with the quantities among them as plain numbers."""
    if not any(is_quantity(entry) for entry in array.flat):
        return array
    entries = [in_si(f"{place}[{k}]", entry, unit) for k, entry in enumerate(array.flat)]
    return np.array(entries).reshape(array.shape)


def _axes(value: Any) -> dict[str, Any]:
    """The names of the dimensions x and y of an array of xarray, which may be capital letters."""
    names = {str(name).lower(): name for name in getattr(value, "dims", ())}
    return {axis: names[axis] for axis in "xy"} if {"x", "y"} <= names.keys() else {}


def _places(value: Any) -> dict[str, Any]:
    """Where the points of an array of xarray are along x and y; of a table of pandas by decimal numbers."""
    if hasattr(value, "dims"):
        return {axis: value.coords[name] for axis, name in _axes(value).items() if name in value.coords}
    if not hasattr(value, "columns"):
        return {}
    named = {"x": _decimals(value.columns), "y": _decimals(value.index)}
    return named if all(names is not None for names in named.values()) else {}


def _decimals(names: Any) -> Any:
    """Names of columns or rows that are decimal numbers, as files have them in text; None for any others."""
    if names.dtype.kind != "f" and not all(isinstance(name, str) for name in names):
        return None
    try:
        return np.asarray([float(name) for name in names])
    except ValueError:
        return None


def _in_order(place: str, value: Any) -> Any:
    """A table, or a row of one, with the entries that are needed by their names, in our order."""
    wanted, names = COLUMNS.get(place), getattr(value, "columns" if value.ndim == 2 else "index", None)
    # numbered columns have no names: their places count
    if wanted is None or names is None or not any(isinstance(name, str) for name in names):
        return value
    if sorted(names, key=str) != sorted(wanted):
        raise ValueError(
            f"{place} has the columns {', '.join(map(str, names))}: {', '.join(wanted)} are needed, in any "
            "order"
        )
    return value[list(wanted)]


def _converted(place: str, value: Any, unit: Unit | None) -> Any:
    """A quantity as a number or an array in `unit`."""
    shape = np.shape(getattr(value, "magnitude", value))
    given = getattr(value, "units", None) or getattr(value, "unit", "")
    # of many numbers the unit counts
    words = f"an array of shape {shape} in {given}" if shape else " ".join(str(value).split())
    shown = f"{place} is {shortened(_Shown(words))}"
    if unit is None:
        raise ValueError(f"{shown}: this argument has no unit, and takes no quantity with a unit")
    if isinstance(unit, tuple):
        one = np.ndim(value) == 0 and unit[0]
        if not one:
            raise ValueError(
                f"{shown}: its entries have the units {', '.join(unit)}; a sequence of quantities, each with "
                "its own unit, is needed"
            )
        unit = one
    for accepted in unit.split(" or "):
        try:
            # pint and unyt read "N*m"; astropy reads it, too
            there = value.to("" if accepted == "1" else accepted.replace(" ", "*"))
        except Exception:
            continue
        number = getattr(there, "magnitude", None)
        number = np.asarray(there.value if number is None else number)
        return float(number) if number.ndim == 0 else number
    raise ValueError(f"{shown}: a quantity in {unit}, or a plain number in this unit, is needed")


def taking_quantities(function: Function) -> Function:
    """The same function, whose arguments may be quantities wherever they have a unit."""
    code = unwrap(function).__code__
    names = code.co_varnames[: code.co_argcount]
    units = {
        "limits": LATER,
        **ARGUMENT_UNITS,
        **EXCEPTIONS.get(function.__qualname__.removesuffix(".__init__"), {}),
    }
    usual = getattr(signature(unwrap(function)).parameters.get("spacing"), "default", None)

    @wraps(function)
    def called(*args: Any, **kwargs: Any) -> Any:
        taken = [
            value if units.get(name) == LATER else in_si(name, value, units.get(name))
            for name, value in zip(names, args, strict=False)
        ]
        given = {
            name: value if units.get(name) == LATER else in_si(name, value, units.get(name))
            for name, value in kwargs.items()
        }
        said = {k: _places(v) for k, v in (*zip(names, args, strict=False), *kwargs.items()) if _may_say(v)}
        if any(said.values()):
            here = dict(zip(names, taken, strict=False))
            own = here.get("self")
            spacing = {**here, **given}.get("spacing", getattr(own, "spacing", usual))
            on_grid = "gap" in names or isinstance(getattr(own, "gap", None), np.ndarray)
            for name, places in said.items():
                if {"x", "y"} <= set(names):
                    _check_axes(name, places, here | given)
                else:
                    _check_places(name, places, spacing, on_grid)
        return function(*taken, *args[len(names) :], **given)

    return cast(Function, called)


def _may_say(value: Any) -> bool:
    """Whether it may say where its points are; at a glance, as every call asks."""
    return type(value) not in _PLAIN and hasattr(value, "to_numpy")


def _check_axes(name: str, places: Mapping[str, Any], given: Mapping[str, Any]) -> None:
    """Checks that an array's coordinates are those given beside it, as x and y."""
    for axis, found in places.items():
        if not np.array_equal(np.sort(np.asarray(found, dtype=float)), np.asarray(given.get(axis))):
            raise ValueError(f"{name} has coordinates {axis} that are not the {axis} given, rising")


def _check_places(name: str, places: Mapping[str, Any], spacing: Any, on_grid: bool) -> None:
    """Checks that an array's coordinates are those of the grid that takes it, which is centred.

    Raises
    ------
    ValueError
        If a point is off by more than a hundredth of a cell; it names the axis and what is needed.
    """
    try:
        steps = dict(zip("xy", np.broadcast_to(np.asarray(spacing, dtype=float), 2).tolist(), strict=True))
    except (TypeError, ValueError):
        return  # there is none, or it is refused where it is used
    for axis, found in places.items():
        said = getattr(found, "attrs", {}).get("units", "m")
        if said != "m":
            raise ValueError(
                f"{name} has {axis} in {said!r}, as its attribute says: coordinates in m are needed"
            )
        there, step = np.sort(np.asarray(found, dtype=float)), steps[axis]
        if not np.all(np.isfinite(there)):
            raise ValueError(
                f"{name} has {axis} = {there[~np.isfinite(there)][0]}: finite coordinates in m are needed"
            )
        even = step * (np.arange(there.size) - (there.size - 1) / 2)
        middle = 0.0 if on_grid else (there[0] + there[-1]) / 2
        if not np.all(np.abs(there - middle - even) <= 0.01 * abs(step)):
            raise ValueError(
                f"{name} has {there.size} points from {axis} = {there[0]:.6g} to {there[-1]:.6g} m: with a "
                f"spacing of {step:.6g} m they must be evenly spaced from {even[0] + middle:.6g} to "
                f"{even[-1] + middle:.6g} m. With a = {name}, mtb_rs.FieldTable(a.x, a.y, a) is interpolated "
                "to any grid"
            )


def take_quantities(classes: Iterable[type]) -> None:
    """Lets the methods of classes, and of those of this package that they inherit from, take quantities.

    What solvers return is made of plain numbers, many times in a step: of these classes only the methods do.
    """
    package = __name__.partition(".")[0]
    inherited = (base for made in classes for base in made.__mro__)
    for made in dict.fromkeys(b for b in inherited if b.__module__.partition(".")[0] == package):
        for name, method in list(vars(made).items()):
            is_made = name == "__init__" and not is_solved(made)
            function = getattr(method, "__func__", method)
            if (is_made or not name.startswith("_")) and isfunction(function) and _has_units(function):
                taking = taking_quantities(function)
                setattr(made, name, taking if function is method else type(method)(taking))


def _has_units(function: Callable[..., Any]) -> bool:
    """Whether an argument has a unit, or may be any."""
    code = unwrap(function).__code__
    names = code.co_varnames[: code.co_argcount + code.co_kwonlyargcount]
    return bool(code.co_flags & CO_VARKEYWORDS) or not ARGUMENT_UNITS.keys().isdisjoint(names)
