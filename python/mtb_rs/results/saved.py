# SPDX-License-Identifier: MIT OR Apache-2.0
"""A result as data in a folder, and back from there without solving.

`result.json` tells how the result is built, down to numbers and text; its arrays are in `fields.npz`, those
that are fields or totals, and in `result.npz`. A chart or a table has NAME.json and NAME.npz.
"""

from __future__ import annotations

import hashlib
import io
import json
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .. import _mtb_rs
from ..base.check import path_of
from ..base.errors import MissingFileError
from ..base.files import read_arrays, read_bytes, read_text
from ..base.stored import Packer, unpack
from .savable import Savable

#: What lists the files of a result; how it is built; its fields and totals; its other arrays.
SUMMARY, RESULT, FIELDS, REST = "summary.json", "result.json", "fields.npz", "result.npz"
#: What the checksum of a record's own numbers and text is known by, among those of its arrays.
STRUCTURE = "result"
#: The form of `result.json`, and of what it refers to: the next number where an older reader would fail.
SCHEMA = 1


def mark() -> dict[str, Any]:
    """What the files of a result are known by."""
    return {"mtb_rs": _mtb_rs.__version__, "schema": SCHEMA}


def summary_in(directory: Path) -> dict[str, Any] | None:
    """The summary of an earlier result; None without one of this library."""
    try:
        found = json.loads(read_text(directory / SUMMARY))
    except (ValueError, RecursionError):
        return None
    is_own = isinstance(found, dict) and isinstance(found.get("mtb_rs"), str)
    return found if is_own and isinstance(found.get("files"), list) else None


def data_files(kept: Savable) -> dict[str, bytes]:
    """The files that :func:`load` reads, from a result as plain data."""
    told = {**kept.fields(), **kept.totals()}
    named = {name: field.values for name, field in told.items()}
    return _files(kept, RESULT, REST, named, {FIELDS: _archive(named)})


def record_files(kept: Savable, name: str) -> dict[str, bytes]:
    """The same of a study, under its name."""
    return _files(kept, f"{name}.json", f"{name}.npz", {}, {})


def _files(
    kept: Savable, record: str, rest: str, named: dict[str, NDArray[Any]], files: dict[str, bytes]
) -> dict[str, bytes]:
    packer = Packer(named)
    structure = packer.pack(kept)
    # what would not come back is told before anything is written
    unpack(structure, named | packer.arrays)
    if packer.arrays:
        files[rest] = _archive(packer.arrays)
    sums = {name: _sum(content) for name, content in files.items()}
    sums[STRUCTURE] = _sum(_canonical(structure))
    whole = {**mark(), "sha256": sums, "result": structure}
    # the record comes last: with it the others are complete
    return files | {record: json.dumps(whole, allow_nan=False).encode() + b"\n"}


def _canonical(structure: Any) -> bytes:
    """The structure of a result as bytes that do not depend on how its file is laid out."""
    return json.dumps(structure, sort_keys=True, separators=(",", ":")).encode()


def class_of(record: Path) -> str | None:
    """The class of what a record holds; None if it is none of this library."""
    try:
        found = json.loads(read_text(record))
    except (ValueError, RecursionError, OSError):
        return None
    is_own = isinstance(found, dict) and isinstance(found.get("mtb_rs"), str) and "schema" in found
    held = found.get("result") if is_own else None
    kind = held.get("class") if isinstance(held, dict) else None
    return kind if isinstance(kind, str) else None


def _sum(content: bytes) -> str:
    return hashlib.sha256(content).hexdigest()


def _archive(arrays: dict[str, NDArray[Any]]) -> bytes:
    buffer = io.BytesIO()
    np.savez_compressed(buffer, allow_pickle=False, **arrays)
    return buffer.getvalue()


def load(saved: str | Path) -> Any:
    """Loads what was saved into a directory, without solving: by ``save`` of a result, a chart, a sweep or a
    curve, or by ``mtb-rs run``, ``demo``, ``chart``, ``sweep``, ``wear`` or ``brake``.

    It can be drawn, exported and saved like the original, and its numbers are the same to the last bit.
    A result has elastic bodies at their nodes only (:meth:`mtb_rs.Result.solids`), the inputs of a scene as
    in its summary, and half-spaces without their surfaces.

    Parameters
    ----------
    saved : str or Path
        The directory. If it holds a result beside charts or sweeps, the result is loaded. If it holds several
        charts or sweeps and no result, give the file of one of them, such as ``"out/chart.json"``.

    Returns
    -------
    Result, NormalResult, TangentialResult, RollingTemperature, SlidingHeat, FoundationResult, Hertz, \
StepResult, StartOfSliding, WheelStep, WheelPatch, StressField, Chart, SweepTable, AreaLoadCurve, \
WearResult, WheelWear, Braking, Stability, Vibration or WheelsetGeometry
        Of the kind that was saved.

    Raises
    ------
    ValueError
        If there is no such directory (then it is also a FileNotFoundError), if nothing was saved there, if
        another version saved it, or if a file is damaged or was changed. The message names the file.
    """
    place = path_of("directory", saved)
    if place.is_file() and place.suffix == ".json":
        own = place.name in (SUMMARY, RESULT)
        return _load_result(place.parent) if own else _load_study(place)
    if not place.is_dir():
        kind = ValueError if place.exists() else MissingFileError
        raise kind(f"{place} is no directory: one that a result was saved into is needed")
    if summary_in(place) is None and not (place / RESULT).exists():
        studies = [path for path in sorted(place.glob("*.json")) if class_of(path) is not None]
        if len(studies) == 1:
            return _load_study(studies[0])
        if studies:
            names = ", ".join(path.name for path in studies)
            raise ValueError(f"{place} holds {names}: the path of one of these files is needed")
    return _load_result(place)


def _load_result(folder: Path) -> Any:
    summary = summary_in(folder)
    if summary is None:
        raise ValueError(f"{folder} has no {SUMMARY} of mtb_rs: no result was saved there")
    if summary.get("is_complete") is False:
        raise ValueError(f"the result in {folder} is not complete: saving it was interrupted; save it again")
    if "schema" not in summary:
        raise ValueError(
            f"the result in {folder} was saved by an mtb_rs that did not yet keep what loading needs: solve "
            "and save it again"
        )
    _check_form(summary, f"the result in {folder}")
    structure, sums = _structure(folder / RESULT, _json(folder / RESULT))
    arrays = {
        name: array for file in (FIELDS, REST) for name, array in _arrays(folder / file, sums, RESULT).items()
    }
    return _made(folder / RESULT, structure, arrays)


def _load_study(record: Path) -> Any:
    found = _json(record)
    _check_form(found, str(record))
    structure, sums = _structure(record, found)
    arrays = record.with_suffix(".npz")
    is_listed = sums is None or arrays.name in sums
    return _made(record, structure, _arrays(arrays, sums, record.name) if is_listed else {})


def _check_form(found: Any, what: str) -> None:
    if isinstance(found, dict) and found.get("schema", SCHEMA) != SCHEMA:
        raise ValueError(
            f"{what} was saved in format {found['schema']!r} by mtb_rs {found.get('mtb_rs')}: mtb_rs "
            f"{_mtb_rs.__version__} reads format {SCHEMA}"
        )


def _made(record: Path, structure: Any, arrays: dict[str, NDArray[Any]]) -> Any:
    try:
        result = unpack(structure, arrays)
        if not isinstance(result, Savable):
            raise ValueError(f"result is of the kind {type(result).__name__}, which is no result")
        result.check()
    # constructors raise whatever they stumble over
    except (ValueError, TypeError, RuntimeError, IndexError, KeyError, AttributeError, MemoryError) as error:
        told = " ".join(str(error).split())
        raise ValueError(f"{record} cannot be read: it is damaged, {told}") from None
    return result


def _json(path: Path) -> Any:
    text = read_text(path, "result")
    try:
        return json.loads(text)
    except (ValueError, RecursionError) as error:
        told = "it is nested too deeply" if isinstance(error, RecursionError) else f"it is no JSON: {error}"
        raise ValueError(f"{path} cannot be read: {told}") from None


def _structure(path: Path, found: Any) -> tuple[Any, dict[str, Any] | None]:
    """How a result is built, and the checksums, from what `path` holds; mtb_rs 0.1.0 has written none."""
    if not isinstance(found, dict) or found.get("schema") != SCHEMA or "result" not in found:
        raise ValueError(f"{path} cannot be read: it holds no result in format {SCHEMA}")
    sums = found.get("sha256")
    if not (sums is None or isinstance(sums, dict)):
        raise ValueError(f"{path} cannot be read: the checksums of its arrays are damaged")
    # earlier versions have kept no sum of the structure
    if sums and STRUCTURE in sums and sums[STRUCTURE] != _sum(_canonical(found["result"])):
        raise ValueError(
            f"{path} is not the file that was saved: its numbers or its text differ from the checksum "
            "(SHA-256) that stands in it; save the result again"
        )
    return found["result"], sums


def _arrays(path: Path, sums: dict[str, Any] | None, record: str) -> dict[str, NDArray[Any]]:
    if path.name == REST and not path.exists() and path.name not in (sums or {}):
        return {}
    content = read_bytes(path, "arrays")
    try:
        arrays = read_arrays(content)
    except ValueError as error:
        raise ValueError(f"{path} cannot be read: {error}") from None
    if sums is not None and sums.get(path.name) != _sum(content):
        raise ValueError(
            f"{path} is not the file that was saved: its checksum (SHA-256) differs from the one in "
            f"{record}; save the result again"
        )
    return arrays
