# SPDX-License-Identifier: MIT OR Apache-2.0
"""What is dear to make, kept under a hash of what it was made from.

Arrays are kept in memory for this process and on disk for the next ones, other objects in memory only.

A file holds a line of identification, the SHA-256 of what follows, and an NPZ archive. It is written
beside its place and then renamed, so several processes may share the folder; what does not match its
checksum, or does not hold the arrays that such a result has, is rebuilt. Who can write into the folder is
trusted: a checksum tells damage, not a forged number.
"""

from __future__ import annotations

import contextlib
import hashlib
import io
import logging
import os
import sys
from collections import OrderedDict
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from threading import Lock
from typing import Any, Protocol, TypeVar

import numpy as np
from numpy.typing import NDArray

from .errors import MissingFileError
from .files import drafted, read_arrays, read_bytes

Arrays = dict[str, NDArray[Any]]
T = TypeVar("T")

#: Folder of the cache; "off" keeps nothing on disk.
VARIABLE = "MTB_RS_CACHE"

#: Size the folder is kept below [bytes]: the files unused for longest go first.
DISK_LIMIT = 4e9
#: Results kept in memory.
MEMORY_LIMIT = 8
#: Memory for objects besides the largest one [bytes].
OBJECTS_LIMIT = 1e9
#: Objects kept at a time: small ones take more memory than that of their matrices.
MOST_OBJECTS = 64


class Sized(Protocol):
    """An object that knows about how much memory it takes."""

    @property
    def nbytes(self) -> float:
        """Memory [bytes]."""


Kept = TypeVar("Kept", bound=Sized)

_HEADER = b"mtb_rs arrays 1\n"
_SUFFIX = ".mtb"
_log = logging.getLogger("mtb_rs.cache")
_memory: OrderedDict[str, Arrays] = OrderedDict()
_objects: OrderedDict[str, Sized] = OrderedDict()
_lock = Lock()
_on_disk = True


def _renew_lock() -> None:
    """Another thread may have held the lock when the process was forked."""
    global _lock
    _lock = Lock()


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_renew_lock)


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
    """Folder of the cache: the argument, else the environment's, else the platform's; None if off.

    None also for a user without a home directory.

    Raises
    ------
    ValueError
        If the folder begins with a ~ of somebody who has no home directory.
    """
    given = os.environ.get(VARIABLE) if argument is None else str(argument)
    if given is not None:
        if given.strip().lower() in ("", "off", "0"):
            return None
        try:
            return Path(given).expanduser()
        except RuntimeError:
            named = VARIABLE if argument is None else "directory"
            raise ValueError(
                f"{named} is {given!r}: there is no such home directory; a folder, or 'off', is needed"
            ) from None
    base = {
        "win32": os.environ.get("LOCALAPPDATA") or "~/AppData/Local",
        "darwin": "~/Library/Caches",
    }.get(sys.platform, os.environ.get("XDG_CACHE_HOME") or "~/.cache")
    try:
        return Path(base).expanduser() / "mtb_rs"
    except RuntimeError:  # a container's user that the system does not know
        return None


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


def fetch(
    key: str, build: Callable[[], Arrays], directory: Path | None, fits: Callable[[Arrays], bool]
) -> tuple[Arrays, str]:
    """Arrays under `key`, built if need be, and where they came from: "memory", "disk", "built".

    `fits` says whether what lies on the disk can be what would be built.
    """
    with _lock:
        if key in _memory:
            _memory.move_to_end(key)
            return _memory[key], "memory"
    if not _on_disk:
        directory = None
    arrays = None if directory is None else _read(directory / (key + _SUFFIX), fits)
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


def recalled(key: str, build: Callable[[], Kept]) -> Kept:
    """The object under `key` in the memory of this process, built if need be.

    The largest one is kept whatever its size: a fine contact stays while coarse ones come for its estimate.
    """
    with _lock:
        if key in _objects:
            _objects.move_to_end(key)
            return _objects[key]  # type: ignore[return-value]
    made = build()
    with _lock:
        _objects[key] = made
        sizes = [o.nbytes for o in _objects.values()]
        while len(sizes) > MOST_OBJECTS or sum(sizes) - max(sizes) > OBJECTS_LIMIT:
            _objects.popitem(last=False)
            sizes.pop(0)
    return made


def forget_objects() -> bool:
    """Drops the objects in memory, and says whether there were any."""
    with _lock:
        had_any = bool(_objects)
        _objects.clear()
    return had_any


class Memory:
    """The last thing made under each name, for as long as it is asked for with the same ingredients."""

    def __init__(self) -> None:
        self._kept: dict[str, tuple[tuple[Any, ...], Any]] = {}

    def recall(self, name: str, ingredients: Sequence[Any], build: Callable[[], T]) -> T:
        """What `build` made under `name` if it was of the same `ingredients`, otherwise what it makes now.

        Arrays are the same by their values, other objects as they say themselves.
        """
        key = tuple(v.tobytes() if isinstance(v, np.ndarray) else v for v in ingredients)
        known = self._kept.get(name)
        if known is None or known[0] != key:
            known = key, build()
            self._kept[name] = known
        made: T = known[1]
        return made

    def __reduce__(self) -> tuple[type[Memory], tuple[()]]:
        # what is remembered can be made again
        return Memory, ()


def forget() -> None:
    """Empties the cache in memory."""
    with _lock:
        _memory.clear()
        _objects.clear()


def _read(path: Path, fits: Callable[[Arrays], bool]) -> Arrays | None:
    try:
        content = read_bytes(path, "cached result")
    except MissingFileError:
        return None
    except ValueError as error:
        _log.warning("%s", error)
        return None
    header, payload = content[: len(_HEADER) + 65], content[len(_HEADER) + 65 :]
    expected = _HEADER + hashlib.sha256(payload).hexdigest().encode() + b"\n"
    if header != expected:
        _log.warning("%s is damaged or of another kind: it is rebuilt", path)
        return None
    try:
        arrays = read_arrays(payload)
    except ValueError as error:
        _log.warning("%s cannot be read, %s: it is rebuilt", path, error)
        return None
    if str(arrays.pop("key", "")) != path.stem:
        _log.warning("%s belongs to another body: it is rebuilt", path)
        return None
    if not fits(arrays):
        _log.warning("%s does not hold what such a body has: it is rebuilt", path)
        return None
    with contextlib.suppress(OSError):
        os.utime(path)  # used just now
    return arrays


def _write(directory: Path, key: str, arrays: Arrays) -> None:
    buffer = io.BytesIO()
    np.savez(buffer, allow_pickle=False, key=np.array(key), **arrays)
    payload = buffer.getbuffer()
    name = key + _SUFFIX
    try:
        with drafted(directory) as draft:
            draft.write(name, _HEADER + hashlib.sha256(payload).hexdigest().encode() + b"\n", payload)
            draft.move(name)
        _prune(directory)
    except OSError as error:
        _log.warning("cannot keep a result: %s", error)


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
