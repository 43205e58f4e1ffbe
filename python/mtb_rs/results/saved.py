# SPDX-License-Identifier: MIT OR Apache-2.0
"""A result as data in a folder, and back from there without solving.

`result.json` tells how the result is built, down to numbers and text; its arrays are in `fields.npz`, those
that are fields or totals, and in `result.npz`.
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
from .result import Drawn

#: What lists the files of a result; how it is built; its fields and totals; its other arrays.
SUMMARY, RESULT, FIELDS, REST = "summary.json", "result.json", "fields.npz", "result.npz"
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


def data_files(kept: Drawn) -> dict[str, bytes]:
    """The files that :func:`load` reads, from a result as plain data."""
    told = {**kept.fields(), **kept.totals()}
    named = {name: field.values for name, field in told.items()}
    packer = Packer(named)
    structure = packer.pack(kept)
    files = {FIELDS: _archive(named)}
    if packer.arrays:
        files[REST] = _archive(packer.arrays)
    sums = {name: _sum(content) for name, content in files.items()}
    whole = {**mark(), "sha256": sums, "result": structure}
    return files | {RESULT: json.dumps(whole, allow_nan=False).encode() + b"\n"}


def _sum(content: bytes) -> str:
    return hashlib.sha256(content).hexdigest()


def _archive(arrays: dict[str, NDArray[Any]]) -> bytes:
    buffer = io.BytesIO()
    np.savez_compressed(buffer, allow_pickle=False, **arrays)
    return buffer.getvalue()


def load(directory: str | Path) -> Any:
    """Loads a result that ``result.save`` or ``mtb-rs run`` saved into a directory, without solving.

    It can be drawn, exported and saved like the original, and its fields and its report are the same to the
    last bit. It has elastic bodies at their nodes only (:meth:`mtb_rs.Result.solids`), the inputs of a scene
    as in its summary, and half-spaces without their surfaces.

    Parameters
    ----------
    directory : str or Path

    Returns
    -------
    Result, NormalResult, TangentialResult, FoundationResult, StepResult or WheelPatch
        Of the kind that was saved.

    Raises
    ------
    ValueError
        If there is no such directory (then it is also a FileNotFoundError), if it holds no result, if another
        version saved it, or if a file is damaged or was changed. The message names the file.
    """
    folder = path_of("directory", directory)
    if not folder.is_dir():
        kind = ValueError if folder.exists() else MissingFileError
        raise kind(f"{folder} is no directory: one that a result was saved into is needed")
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
    if summary["schema"] != SCHEMA:
        raise ValueError(
            f"the result in {folder} was saved in format {summary['schema']!r} by mtb_rs "
            f"{summary['mtb_rs']}: mtb_rs {_mtb_rs.__version__} reads format {SCHEMA}"
        )
    structure, sums = _structure(folder / RESULT)
    arrays = {name: array for file in (FIELDS, REST) for name, array in _arrays(folder / file, sums).items()}
    try:
        result = unpack(structure, arrays)
        if not isinstance(result, Drawn):
            raise ValueError(f"result is of the kind {type(result).__name__}, which is no result")
        result.check()
    # constructors raise whatever they stumble over
    except (ValueError, TypeError, RuntimeError, IndexError, KeyError, AttributeError, MemoryError) as error:
        told = " ".join(str(error).split())
        raise ValueError(f"{folder / RESULT} cannot be read: it is damaged, {told}") from None
    return result


def _structure(path: Path) -> tuple[Any, dict[str, Any] | None]:
    """How a result is built, and the sums of its arrays; mtb_rs 0.1.0 has written none."""
    text = read_text(path, "result")
    try:
        found = json.loads(text)
    except (ValueError, RecursionError) as error:
        told = "it is nested too deeply" if isinstance(error, RecursionError) else f"it is no JSON: {error}"
        raise ValueError(f"{path} cannot be read: {told}") from None
    if not isinstance(found, dict) or found.get("schema") != SCHEMA or "result" not in found:
        raise ValueError(f"{path} cannot be read: it holds no result in format {SCHEMA}")
    sums = found.get("sha256")
    if not (sums is None or isinstance(sums, dict)):
        raise ValueError(f"{path} cannot be read: the checksums of its arrays are damaged")
    return found["result"], sums


def _arrays(path: Path, sums: dict[str, Any] | None) -> dict[str, NDArray[Any]]:
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
            f"{RESULT}; save the result again"
        )
    return arrays
