# SPDX-License-Identifier: MIT OR Apache-2.0
"""A prepared contact as a functional mock-up unit (FMI 2.0, co-simulation)."""

from __future__ import annotations

import hashlib
import os
import zipfile
from collections.abc import Mapping
from io import BytesIO
from pathlib import Path
from xml.etree import ElementTree

from .._mtb_rs import __version__
from ..base.check import path_of
from ..base.files import read_bytes

#: Name of the library inside a unit.
IDENTIFIER = "mtb_contact"
#: Folder of the library by how its file ends.
PLATFORMS = {".so": "linux64", ".dylib": "darwin64", ".dll": "win64"}
#: Value references of rust/fmu: inputs with their units, then outputs.
INPUTS = (
    *((f"pose.{axis}", "m") for axis in "xyz"),
    *((f"pose.{angle}", "rad") for angle in ("roll", "pitch", "yaw")),
    ("velocity.x", "m/s"),
    ("velocity.y", "m/s"),
    ("magnetic_pressure", "Pa"),
)
OUTPUTS = (
    *((f"force.{axis}", "N") for axis in "xyz"),
    *((f"moment.{axis}", "N.m") for axis in "xyz"),
    ("friction_power", "W"),
    ("peak_pressure", "Pa"),
)
#: Exponents of kg, m, s and rad.
UNITS = {
    "m": {"m": 1},
    "rad": {"rad": 1},
    "m/s": {"m": 1, "s": -1},
    "Pa": {"kg": 1, "m": -1, "s": -2},
    "N": {"kg": 1, "m": 1, "s": -2},
    "N.m": {"kg": 1, "m": 2, "s": -2},
    "W": {"kg": 1, "m": 2, "s": -3},
}


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


def packed(
    contact: bytes,
    library: str | os.PathLike[str] | None,
    name: str,
    starts: Mapping[str, float],
) -> bytes:
    """The unit of a contact, given as the bytes of its file, whose inputs are those with a start value."""
    source = own_library() if library is None else path_of("library", library)
    platform = PLATFORMS.get(source.suffix)
    fitting = f"mtb-fmu-{__version__}-"
    needed = (
        f"library is {source}: the mtb_fmu library of version {__version__}, as `cargo build --release "
        f"-p mtb-fmu` makes it ({', '.join(PLATFORMS)}), is needed"
    )
    try:
        compiled = read_bytes(source, "library") if platform else b""
    except ValueError as error:
        raise type(error)(f"{needed}; {error}") from error
    if fitting.encode() not in compiled:
        raise ValueError(needed)
    # the same contact is the same unit
    identifier = fitting + hashlib.sha256(contact).hexdigest()[:32]
    unit = BytesIO()
    with zipfile.ZipFile(unit, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("modelDescription.xml", _description(name, identifier, starts))
        archive.writestr(f"binaries/{platform}/{IDENTIFIER}{source.suffix}", compiled)
        archive.writestr("resources/contact.mtbc", contact)
        # importing programs need not set what stays as the description has it
        first = [f"{k} {starts[name]!r}\n" for k, (name, _) in enumerate(INPUTS) if name in starts]
        archive.writestr("resources/starts.txt", "".join(first))
    return unit.getvalue()


def _description(name: str, identifier: str, starts: Mapping[str, float]) -> bytes:
    """modelDescription.xml of the inputs that have a start value, and of all outputs."""
    root = ElementTree.Element(
        "fmiModelDescription",
        fmiVersion="2.0",
        modelName=name,
        guid=identifier,
        description="Sliding contact; forces act on the lower body",
        generationTool=f"mtb_rs {__version__}",
        variableNamingConvention="structured",
    )
    ElementTree.SubElement(
        root,
        "CoSimulation",
        modelIdentifier=IDENTIFIER,
        canHandleVariableCommunicationStepSize="true",
        canNotUseMemoryManagementFunctions="true",
        canGetAndSetFMUstate="true",
        providesDirectionalDerivative="true",
    )
    definitions = ElementTree.SubElement(root, "UnitDefinitions")
    for unit, exponents in UNITS.items():
        entry = ElementTree.SubElement(definitions, "Unit", name=unit)
        ElementTree.SubElement(entry, "BaseUnit", {base: str(power) for base, power in exponents.items()})
    variables = ElementTree.SubElement(root, "ModelVariables")
    outputs = []
    for reference, (variable, unit) in enumerate((*INPUTS, *OUTPUTS)):
        is_output = reference >= len(INPUTS)
        if not is_output and variable not in starts:
            continue
        entry = ElementTree.SubElement(
            variables,
            "ScalarVariable",
            name=variable,
            valueReference=str(reference),
            causality="output" if is_output else "input",
            variability="continuous",
        )
        if is_output:
            entry.set("initial", "calculated")
            ElementTree.SubElement(entry, "Real", unit=unit)
            outputs.append(str(len(variables)))
        else:
            ElementTree.SubElement(entry, "Real", unit=unit, start=repr(starts[variable]))
    structure = ElementTree.SubElement(root, "ModelStructure")
    for part in ("Outputs", "InitialUnknowns"):
        entry = ElementTree.SubElement(structure, part)
        for index in outputs:
            ElementTree.SubElement(entry, "Unknown", index=index)
    ElementTree.indent(root)
    return bytes(ElementTree.tostring(root, encoding="utf-8", xml_declaration=True))
