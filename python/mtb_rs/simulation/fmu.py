# SPDX-License-Identifier: MIT OR Apache-2.0
"""A prepared contact as a functional mock-up unit for co-simulation, by FMI 2.0 or 3.0."""

from __future__ import annotations

import hashlib
import os
import zipfile
from collections.abc import Container, Mapping
from dataclasses import dataclass, replace
from io import BytesIO
from pathlib import Path
from xml.etree import ElementTree
from xml.etree.ElementTree import Element, SubElement

import numpy as np
from numpy.typing import NDArray

from .._mtb_rs import __version__
from ..base.check import number, path_of, shortened
from ..base.files import read_bytes
from .coordinates import POSE

#: Name of the library inside a unit.
IDENTIFIER = "mtb_contact"
#: Folder of the library by how its file ends, in FMI 2; its system in FMI 3.
PLATFORMS = {
    ".so": ("linux64", "linux"),
    ".dylib": ("darwin64", "darwin"),
    ".dll": ("win64", "windows"),
}
#: What the heads of libraries (ELF, Mach-O, PE) call the processors of FMI 3.
PROCESSORS = {
    ".so": {62: "x86_64", 183: "aarch64"},
    ".dylib": {0x01000007: "x86_64", 0x0100000C: "aarch64"},
    ".dll": {0x8664: "x86_64", 0xAA64: "aarch64"},
}
#: Exponents of kg, m, s and rad.
UNITS = {
    "m": {"m": 1},
    "rad": {"rad": 1},
    "1/m": {"m": -1},
    "m/s": {"m": 1, "s": -1},
    "rad/s": {"rad": 1, "s": -1},
    "Pa": {"kg": 1, "m": -1, "s": -2},
    "A": {"A": 1},
    "N": {"kg": 1, "m": 1, "s": -2},
    "N.m": {"kg": 1, "m": 2, "s": -2},
    "W": {"kg": 1, "m": 2, "s": -3},
    "s": {"s": 1},
}


@dataclass(frozen=True)
class Quantity:
    """Numbers of one unit: a variable each in FMI 2, and an array in FMI 3 where the unit has all of them."""

    name: str
    unit: str
    numbers: tuple[str, ...]
    text: str


@dataclass(frozen=True)
class Kind:
    """A kind of contact of rust/fmu: its inputs and outputs in the order of their value references."""

    file: str
    text: str
    inputs: tuple[Quantity, ...]
    outputs: tuple[Quantity, ...]


def _numbers(name: str, components: str = "xyz") -> tuple[str, ...]:
    return tuple(f"{name}.{component}" for component in components)


def _pose(order: str) -> tuple[Quantity, ...]:
    """The pose, whose rotations follow each other in this order."""
    names = ("pose.roll", "pose.pitch", "pose.yaw")
    told = f"Roll, pitch, yaw: rotations about the fixed {order} axis through the reference point"
    return (
        Quantity("pose.translation", "m", _numbers("pose"), "Rigid displacement along x, y, z"),
        Quantity("pose.rotation", "rad", names, told),
    )


_MOMENT = "Moment of the force about the reference point"
#: Numbers of a rail and of a wheel beside their places, then their rates.
RAIL = ("y", "z", "roll", "vy", "vz", "wx")
WHEEL = (*POSE, "vx", "vy", "vz", "wx", "wy", "wz")


def _beside(body: str, numbers: tuple[str, ...], turns: int) -> tuple[Quantity, ...]:
    """Numbers of both rails or both wheels beside their places, of which so many are rotations."""
    half = len(numbers) // 2
    parts = {
        "translation": ("m", numbers[: half - turns], "Displacement"),
        "rotation": ("rad", numbers[half - turns : half], "Rotation"),
        "velocity": ("m/s", numbers[half : len(numbers) - turns], "Rate of the displacement"),
        "angular_velocity": ("rad/s", numbers[len(numbers) - turns :], "Rate of the rotation"),
    }
    return tuple(
        Quantity(
            f"{body}.{side}.{part}",
            unit,
            tuple(f"{body}.{side}.{number}" for number in own),
            f"{what} of the {side} {body} beside its place",
        )
        for side in ("left", "right")
        for part, (unit, own, what) in parts.items()
    )


_POWER = Quantity("friction_power", "W", ("friction_power",), "Heat of sliding")
SLIDING = Kind(
    "contact.mtbc",
    "Sliding contact; forces act on the lower body",
    (
        *_pose("x, then y, then z"),
        Quantity("velocity", "m/s", _numbers("velocity", "xy"), "Of the upper body over the lower one"),
        Quantity("magnetic_pressure", "Pa", ("magnetic_pressure",), "Uniform, in place of the scene's"),
        Quantity("ampere_turns", "A", ("ampere_turns",), "Of the magnet, whose pull follows the gap"),
    ),
    (
        Quantity("force", "N", _numbers("force"), "Force on the lower body"),
        Quantity("moment", "N.m", _numbers("moment"), _MOMENT),
        _POWER,
        Quantity("peak_pressure", "Pa", ("peak_pressure",), "Largest mean pressure of a contact point"),
        Quantity("attraction", "N", ("attraction",), "With which the magnet pulls"),
    ),
)
WHEELS = Kind(
    "wheels.mtbw",
    "Wheels on rails; forces act on the rails",
    (
        *_pose("y, then x, then z"),
        Quantity("velocity", "m/s", ("velocity",), "Speed of a wheelset that rolls on its tape circles"),
        Quantity("velocity", "m/s", _numbers("velocity"), "Velocity of the reference point"),
        Quantity(
            "angular_velocity",
            "rad/s",
            _numbers("angular_velocity"),
            "Rotation about x, y, z, that about the axle included, with its parts along x and z by yaw and "
            "roll, a roll that is found too",
        ),
        Quantity("lateral_force", "N", ("lateral_force",), "Of all wheels on the rails; y is found for it"),
        Quantity(
            "longitudinal_force",
            "N",
            ("longitudinal_force",),
            "Of all wheels on the rails; the rotation about the axle is found for it",
        ),
        Quantity(
            "axle_moment",
            "N.m",
            ("axle_moment",),
            "Of the forces on the rails about the axle; the rotation about it is found for it",
        ),
        Quantity("curvature", "1/m", ("curvature",), "Of the track, > 0 in a curve to the left"),
        *_beside("rail", RAIL, 1),
        *_beside("wheel", WHEEL, 3),
    ),
    (
        Quantity("force", "N", _numbers("force"), "Force of all patches on the rails"),
        Quantity("moment", "N.m", _numbers("moment"), _MOMENT),
        Quantity(
            "vertical_force",
            "N",
            ("vertical_force.left", "vertical_force.right"),
            "What the left and the right wheel press on their rails with, friction included",
        ),
        _POWER,
        Quantity("peak_pressure", "Pa", ("peak_pressure",), "Largest pressure of all patches"),
        Quantity("pose.z", "m", ("pose.z",), "Height found from the vertical force"),
        Quantity("pose.roll", "rad", ("pose.roll",), "Roll found from the vertical forces"),
        Quantity("pose.y", "m", ("pose.y",), "Lateral position found from the lateral force"),
        Quantity("rotation", "rad/s", _numbers("rotation"), "Of the wheelset, found about its axle"),
        *(
            Quantity(
                f"rail_displacement.{side}",
                "m",
                (f"rail_displacement.{side}.y", f"rail_displacement.{side}.z"),
                f"Of the {side} rail on its springs, and beside its place",
            )
            for side in ("left", "right")
        ),
    ),
)
#: The same, whose steps roll on from the last one.
TRANSIENT_WHEELS = replace(
    WHEELS, file="transient_wheels.mtbw", text="Wheels in transient rolling on rails; forces act on the rails"
)
#: A time in which nothing rolls on [s], as that of units.
AT_ONCE = 1e-12
#: What a velocity of six numbers gives.
RIGID = _numbers("velocity") + _numbers("angular_velocity")
#: The rotation that is found.
ROTATION = _numbers("rotation")
#: The outputs of wheels that are there for any wheels and any pose.
LOAD = (*_numbers("force"), *_numbers("moment"), "friction_power", "peak_pressure")


@dataclass(frozen=True)
class Variable:
    """A variable of a description; inputs have first values."""

    name: str
    reference: int
    size: int
    unit: str
    text: str
    starts: tuple[float, ...]


def first_pose(pose: Mapping[str, float] | None) -> dict[str, float]:
    """First values of the components of a pose that are inputs, by component.

    Raises
    ------
    ValueError
        If a name is no component, or a value no finite number.
    """
    given = {} if pose is None else pose
    if not isinstance(given, Mapping):
        raise ValueError(
            f"pose is {shortened(pose)}: a mapping from {', '.join(POSE)} to first values is needed"
        )
    for component in given:
        if component not in POSE:
            raise ValueError(f"pose has {component!r}: components are {', '.join(POSE)}")
    return {component: number(f"pose[{component!r}]", value) for component, value in given.items()}


def own_library() -> Path:
    """The library that this installation brings along, for the system on which it runs."""
    folder = Path(__file__).parents[1] / "runtime"
    found = sorted(path for path in folder.glob("*mtb_fmu.*") if path.suffix in PLATFORMS)
    if not found:
        raise ValueError(
            "library is missing: this installation of mtb_rs has no library of units. Released wheels "
            "bring one. Give the path to the one that `cargo build --release -p mtb-fmu` makes "
            "(target/release/libmtb_fmu.so on Linux)"
        )
    return found[0]


def check_version(fmi: int) -> int:
    """The version of the standard, 2 or 3."""
    if isinstance(fmi, bool) or fmi not in (2, 3):
        raise ValueError(f"fmi is {shortened(fmi)}: 2 or 3, the version of the standard, is needed")
    return int(fmi)


def packed(
    kind: Kind,
    contact: bytes,
    library: str | os.PathLike[str] | None,
    name: str,
    reference_point: NDArray[np.float64],
    starts: Mapping[str, float],
    outputs: Container[str] | None = None,
    fmi: int = 2,
) -> bytes:
    """The unit of a contact, given as the bytes of its file.

    Parameters
    ----------
    kind : Kind
    contact : bytes
    library : str, path object or None
        None: that of the installation.
    name : str
        Of the model.
    reference_point : (3,) [m]
        What the description says that moments and rotations are about.
    starts : Mapping[str, float]
        First values of the numbers that are inputs.
    outputs : container of str, optional
        The numbers that are outputs; None: all of them.
    fmi : int
        Version of the standard, 2 or 3.
    """
    source = own_library() if library is None else path_of("library", library)
    fitting = f"mtb-fmu-{__version__}-"
    needed = (
        f"library is {source}: the mtb_fmu library of version {__version__}, as `cargo build --release "
        f"-p mtb-fmu` makes it ({', '.join(PLATFORMS)}), is needed"
    )
    try:
        compiled = read_bytes(source, "library") if source.suffix in PLATFORMS else b""
    except ValueError as error:
        raise type(error)(f"{needed}; {error}") from error
    if fitting.encode() not in compiled:
        raise ValueError(needed)
    arrays = fmi == 3
    ins = _variables(kind.inputs, 0, starts, starts, arrays)
    first = _count(kind.inputs)
    every = [number for quantity in kind.outputs for number in quantity.numbers]
    outs = _variables(kind.outputs, first, every if outputs is None else outputs, {}, arrays)
    time = first + _count(kind.outputs)
    lines = [f"input {v.reference} {' '.join(map(repr, v.starts))}\n" for v in ins]
    lines += [f"output {v.reference} {v.size}\n" for v in outs]
    lines += [f"time {time}\n"] if arrays else []
    listed = "".join(lines)
    # the same contact with the same variables is the same unit
    known = f"{kind.file}\n{listed}".encode() + contact
    identifier = fitting + hashlib.sha256(known).hexdigest()[:32]
    point = ", ".join(f"{x:.6g}" for x in reference_point)
    text = f"{kind.text}; reference point at the zero pose: ({point}) m"
    if arrays:
        folder = f"{_processor(source, compiled)}-{PLATFORMS[source.suffix][1]}"
        description = _description_3(text, name, identifier, ins, outs, time)
    else:
        folder = PLATFORMS[source.suffix][0]
        description = _description_2(text, name, identifier, ins, outs)
    unit = BytesIO()
    with zipfile.ZipFile(unit, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("modelDescription.xml", description)
        archive.writestr(f"binaries/{folder}/{IDENTIFIER}{source.suffix}", compiled)
        archive.writestr(f"resources/{kind.file}", contact)
        # importing programs need not set what stays as the description has it
        archive.writestr("resources/variables.txt", listed)
    return unit.getvalue()


def _count(quantities: tuple[Quantity, ...]) -> int:
    return sum(len(quantity.numbers) for quantity in quantities)


def _variables(
    quantities: tuple[Quantity, ...],
    first: int,
    known: Container[str],
    starts: Mapping[str, float],
    arrays: bool,
) -> list[Variable]:
    """Variables of the numbers that are known, counted from `first`."""
    found = []
    for quantity in quantities:
        numbers = quantity.numbers
        places = [k for k, number in enumerate(numbers) if number in known]
        first_values = [(starts[number],) if number in starts else () for number in numbers]
        if arrays and len(places) == len(numbers) > 1:
            whole = sum(first_values, ())
            found.append(Variable(quantity.name, first, len(numbers), quantity.unit, quantity.text, whole))
        else:
            found += [
                Variable(numbers[k], first + k, 1, quantity.unit, quantity.text, first_values[k])
                for k in places
            ]
        first += len(numbers)
    return found


def _processor(source: Path, compiled: bytes) -> str:
    """What a library is compiled for."""
    place, size = {".so": (18, 2), ".dylib": (4, 4)}.get(source.suffix, (0x3C, 4))
    if source.suffix == ".dll":
        # the head of a program for Windows begins where a number at a fixed place says
        place, size = int.from_bytes(compiled[place : place + size], "little") + 4, 2
    code = int.from_bytes(compiled[place : place + size], "little")
    known = PROCESSORS[source.suffix]
    if code not in known:
        raise ValueError(
            f"library is {source}: one that is compiled for {' or '.join(known.values())} is needed for FMI 3"
        )
    return known[code]


def _description_2(
    text: str,
    name: str,
    identifier: str,
    inputs: list[Variable],
    outputs: list[Variable],
) -> bytes:
    """modelDescription.xml of FMI 2.0."""
    root = Element("fmiModelDescription", {"fmiVersion": "2.0", "guid": identifier}, **_head(text, name))
    SubElement(
        root,
        "CoSimulation",
        modelIdentifier=IDENTIFIER,
        canHandleVariableCommunicationStepSize="true",
        canNotUseMemoryManagementFunctions="true",
        canGetAndSetFMUstate="true",
        canSerializeFMUstate="true",
        providesDirectionalDerivative="true",
    )
    _add_units_and_categories(root)
    variables = SubElement(root, "ModelVariables")
    for variable in (*inputs, *outputs):
        entry = SubElement(
            variables,
            "ScalarVariable",
            name=variable.name,
            valueReference=str(variable.reference),
            description=variable.text,
            causality="input" if variable.starts else "output",
            variability="continuous",
        )
        real = SubElement(entry, "Real", unit=variable.unit)
        if variable.starts:
            real.set("start", repr(variable.starts[0]))
        else:
            entry.set("initial", "calculated")
    structure = SubElement(root, "ModelStructure")
    for part in ("Outputs", "InitialUnknowns"):
        unknowns = SubElement(structure, part)
        for k in range(len(outputs)):
            SubElement(unknowns, "Unknown", index=str(len(inputs) + k + 1))
    return _written(root)


def _description_3(
    text: str,
    name: str,
    token: str,
    inputs: list[Variable],
    outputs: list[Variable],
    time: int,
) -> bytes:
    """modelDescription.xml of FMI 3.0."""
    root = Element(
        "fmiModelDescription", {"fmiVersion": "3.0", "instantiationToken": token}, **_head(text, name)
    )
    SubElement(
        root,
        "CoSimulation",
        modelIdentifier=IDENTIFIER,
        canHandleVariableCommunicationStepSize="true",
        canGetAndSetFMUState="true",
        canSerializeFMUState="true",
        providesDirectionalDerivatives="true",
        providesAdjointDerivatives="true",
    )
    _add_units_and_categories(root)
    variables = SubElement(root, "ModelVariables")
    SubElement(
        variables,
        "Float64",
        name="time",
        valueReference=str(time),
        causality="independent",
        variability="continuous",
        unit="s",
    )
    for variable in (*inputs, *outputs):
        entry = SubElement(
            variables,
            "Float64",
            name=variable.name,
            valueReference=str(variable.reference),
            description=variable.text,
            causality="input" if variable.starts else "output",
            variability="continuous",
            unit=variable.unit,
        )
        if variable.starts:
            entry.set("start", " ".join(map(repr, variable.starts)))
        else:
            entry.set("initial", "calculated")
        if variable.size > 1:
            SubElement(entry, "Dimension", start=str(variable.size))
    structure = SubElement(root, "ModelStructure")
    for part in ("Output", "InitialUnknown"):
        for variable in outputs:
            SubElement(structure, part, valueReference=str(variable.reference))
    return _written(root)


def _head(text: str, name: str) -> dict[str, str]:
    """What both versions tell of a unit."""
    return {
        "modelName": name,
        "description": text,
        "generationTool": f"mtb_rs {__version__}",
        "variableNamingConvention": "structured",
    }


def _add_units_and_categories(root: Element) -> None:
    definitions = SubElement(root, "UnitDefinitions")
    for unit, exponents in UNITS.items():
        entry = SubElement(definitions, "Unit", name=unit)
        SubElement(entry, "BaseUnit", {base: str(power) for base, power in exponents.items()})
    categories = SubElement(root, "LogCategories")
    for category in ("logStatusError", "logStatusDiscard"):
        SubElement(categories, "Category", name=category)


def _written(root: Element) -> bytes:
    ElementTree.indent(root)
    return bytes(ElementTree.tostring(root, encoding="utf-8", xml_declaration=True))
