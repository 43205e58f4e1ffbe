# SPDX-License-Identifier: MIT OR Apache-2.0
"""Arrays kept under a content hash: in memory for this process, on disk for the next ones.

A file holds a line of identification, the SHA-256 of what follows, and an NPZ archive. It is written
beside its place and then renamed, so several processes may share the folder; what does not match its
checksum is rebuilt.
"""

from __future__ import annotations

import contextlib
import hashlib
import io
import logging
import os
import sys
import tempfile
from collections import OrderedDict
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from threading import Lock
from typing import Any

import numpy as np
from numpy.typing import NDArray

Arrays = dict[str, NDArray[Any]]

#: Folder of the cache; "off" keeps nothing on disk.
VARIABLE = "MTB_RS_CACHE"

#: Size the folder is kept below [bytes]: the files unused for longest go first.
DISK_LIMIT = 4e9
#: Results kept in memory.
MEMORY_LIMIT = 8

_HEADER = b"mtb_rs arrays 1\n"
_SUFFIX = ".mtb"
_log = logging.getLogger("mtb_rs.cache")
_memory: OrderedDict[str, Arrays] = OrderedDict()
_lock = Lock()
_on_disk = True


@contextlib.contextmanager
def memory_only() -> Iterator[None]:
    """Leaves the folder alone, so that what is built takes the time it takes."""
    global _on_disk
    before, _on_disk = _on_disk, False
    try:
        yield
    finally:
        _on_disk = before


def folder(argument: str | Path | None = None) -> Path | None:
    """Folder of the cache: the argument, else the environment's, else the platform's; None if off."""
    given = os.environ.get(VARIABLE) if argument is None else str(argument)
    if given is not None:
        return None if given.strip().lower() in ("", "off", "0") else Path(given).expanduser()
    home = Path.home()
    if sys.platform == "win32":
        base = Path(os.environ.get("LOCALAPPDATA", home / "AppData" / "Local"))
    elif sys.platform == "darwin":
        base = home / "Library" / "Caches"
    else:
        base = Path(os.environ.get("XDG_CACHE_HOME") or home / ".cache")
    return base / "mtb_rs"


def content_key(parts: Mapping[str, Any]) -> str:
    """Hash of names, numbers, strings and arrays, independent of the order of the names."""
    digest = hashlib.sha256()
    for name in sorted(parts):
        value = parts[name]
        if isinstance(value, np.ndarray):
            array = np.ascontiguousarray(value)
            digest.update(f"{name}:{array.dtype.str}:{array.shape};".encode())
            digest.update(array.data)
        else:
            digest.update(f"{name}={value!r};".encode())
    return digest.hexdigest()


def fetch(key: str, build: Callable[[], Arrays], directory: Path | None) -> tuple[Arrays, str]:
    """Arrays under `key`, built if need be, and where they came from: "memory", "disk", "built"."""
    with _lock:
        if key in _memory:
            _memory.move_to_end(key)
            return _memory[key], "memory"
    if not _on_disk:
        directory = None
    arrays = None if directory is None else _read(directory / (key + _SUFFIX))
    origin = "disk"
    if arrays is None:
        arrays, origin = build(), "built"
        if directory is not None:
            _write(directory, key, arrays)
    with _lock:
        _memory[key] = arrays
        while len(_memory) > MEMORY_LIMIT:
            _memory.popitem(last=False)
    return arrays, origin


def forget() -> None:
    """Empties the cache in memory."""
    with _lock:
        _memory.clear()


def _read(path: Path) -> Arrays | None:
    try:
        content = path.read_bytes()
    except FileNotFoundError:
        return None
    except OSError as error:
        _log.warning("cannot read %s: %s", path, error)
        return None
    header, payload = content[: len(_HEADER) + 65], content[len(_HEADER) + 65 :]
    expected = _HEADER + hashlib.sha256(payload).hexdigest().encode() + b"\n"
    if header != expected:
        _log.warning("%s is damaged or of another kind: it is rebuilt", path)
        return None
    with np.load(io.BytesIO(payload), allow_pickle=False) as archive:
        arrays = {name: archive[name] for name in archive.files}
    if str(arrays.pop("key")) != path.stem:
        _log.warning("%s belongs to another body: it is rebuilt", path)
        return None
    with contextlib.suppress(OSError):
        os.utime(path)  # used just now
    return arrays


def _write(directory: Path, key: str, arrays: Arrays) -> None:
    buffer = io.BytesIO()
    np.savez(buffer, allow_pickle=False, key=np.array(key), **arrays)
    payload = buffer.getvalue()
    temporary = None
    try:
        directory.mkdir(parents=True, exist_ok=True)
        with tempfile.NamedTemporaryFile(dir=directory, prefix=".", delete=False) as file:
            temporary = Path(file.name)
            file.write(_HEADER + hashlib.sha256(payload).hexdigest().encode() + b"\n")
            file.write(payload)
        temporary.replace(directory / (key + _SUFFIX))
        _prune(directory)
    except OSError as error:
        _log.warning("cannot keep a result in %s: %s", directory, error)
        if temporary is not None:
            temporary.unlink(missing_ok=True)


def _prune(directory: Path) -> None:
    files = []
    for path in directory.glob("*" + _SUFFIX):
        with contextlib.suppress(OSError):  # another process may have removed it
            status = path.stat()
            files.append((status.st_mtime, status.st_size, path))
    total = sum(size for _, size, _ in files)
    for _, size, path in sorted(files, key=lambda f: f[0]):
        if total <= DISK_LIMIT:
            return
        path.unlink(missing_ok=True)
        total -= size
