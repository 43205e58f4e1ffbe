# SPDX-License-Identifier: MIT OR Apache-2.0
"""The one way in and out of files.

What is read is a regular file of a size that makes sense: pipes and devices could give bytes for ever, or
none. What is written is made beside its place, flushed to the disk and then moved there, so that a full disk
or a killed process leaves no half of a file. Drafts lie in folders with a mark in their names, which a
writer holds a lock on as long as it lives: those that killed writers left are cleared by the next one.
"""

from __future__ import annotations

import argparse
import codecs
import contextlib
import io
import os
import shutil
import stat
import tempfile
import time
import zipfile
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from .check import path_of
from .errors import MissingFileError

try:
    import fcntl
except ImportError:  # Windows
    fcntl = None  # type: ignore[assignment]

T = TypeVar("T")

#: Most bytes of files that people write: cases, profiles, tables.
TEXT = 16_000_000
#: Most bytes of files that programs write: meshes, prepared contacts, checkpoints, cached bodies.
DATA = 4_000_000_000

#: What the names of drafts begin with.
DRAFT = ".mtb-rs-draft-"
#: Where there are no locks a draft of this age is taken for abandoned [s].
ABANDONED = 86_400.0


# --- in ------------------------------------------------------------------------------------------------


def read_bytes(path: str | os.PathLike[str], what: str = "file", most: int = DATA) -> bytes:
    """The bytes of a regular file.

    Parameters
    ----------
    path : path
    what : str
        What the file is, for the message; may be empty.
    most : int
        Bytes up to which it is read.

    Raises
    ------
    ValueError
        If there is no such file (then a FileNotFoundError, too), if it cannot be read, is no regular file
        or too large.
    """
    where = path_of("path", path)
    # a pipe without a writer would be waited for, for ever
    flags = os.O_RDONLY | sum(getattr(os, name, 0) for name in ("O_NONBLOCK", "O_NOCTTY", "O_BINARY"))
    try:
        if where.is_dir():
            raise _unreadable(what, where, "it is a directory, a file is needed")
        with open(os.open(where, flags), "rb") as stream:
            status = os.fstat(stream.fileno())
            if not stat.S_ISREG(status.st_mode):
                raise _unreadable(what, where, "it is a pipe or a device, a regular file is needed")
            if status.st_size > most:
                size = f"it has {status.st_size:.3g} bytes: at most {most:.3g} are read"
                raise _unreadable(what, where, size)
            # asked for by its size: a buffer of `most` bytes may be more than the process can have
            content = stream.read(status.st_size + 1)
            # a file that grows, or one of the system's that tells no size
            while len(content) <= most and (more := stream.read(1 << 20)):
                content += more
    except FileNotFoundError:
        raise _unreadable(what, where, "No such file", MissingFileError) from None
    except OSError as error:
        raise _unreadable(what, where, error.strerror or str(error)) from None
    except MemoryError:
        raise _unreadable(what, where, "its bytes do not fit into the memory") from None
    if len(content) > most:
        raise _unreadable(what, where, f"it has more than {most:.3g} bytes: at most {most:.3g} are read")
    return content


def made_of(path: str | os.PathLike[str], what: str, make: Callable[[bytes], T]) -> T:
    """What `make` makes of the bytes of a regular file; errors as :func:`read_bytes`, and those of `make`."""
    data = read_bytes(path, what)
    try:
        return make(data)
    except ValueError as error:
        raise ValueError(f"{path}: {error}") from None


def read_text(path: str | os.PathLike[str], what: str = "file", most: int = TEXT) -> str:
    """The text (UTF-8) of a regular file; errors as :func:`read_bytes`."""
    try:
        return text_of(read_bytes(path, what, most))
    except UnicodeError as error:
        raise _unreadable(what, path, f"it is {error}") from None


def text_of(content: bytes) -> str:
    """Text in UTF-8, without the mark by which Windows begins it; lines end in LF, whatever ended them.

    Raises
    ------
    UnicodeError
        If it is in another encoding; it says what it is and what is needed.
    """
    if content.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)):
        raise UnicodeError(
            "not UTF-8 text but UTF-16, as > of Windows PowerShell 5 writes it: save it again in UTF-8"
        )
    try:
        return content.decode("utf-8-sig").replace("\r\n", "\n").replace("\r", "\n")
    except UnicodeDecodeError as error:
        # counted in the file
        start = error.start + (len(content) - len(error.object))
        raise UnicodeError(f"not UTF-8 text: byte {start} is no character") from None


def read_arrays(content: bytes, most: int = DATA) -> dict[str, NDArray[Any]]:
    """The arrays of an NPZ archive, of numbers and text only.

    Parameters
    ----------
    content : bytes
        As the file has them.
    most : int
        Bytes up to which the arrays are unpacked: a small archive can hold zeros for ever.

    Raises
    ------
    ValueError
        If it is no such archive, or a larger one.
    """
    try:
        with zipfile.ZipFile(io.BytesIO(content)) as archive:
            size = sum(entry.file_size for entry in archive.infolist())
            if size > most:
                raise ValueError(f"its arrays take {size:.3g} bytes: at most {most:.3g} are read")
        with np.load(io.BytesIO(content), allow_pickle=False) as arrays:
            return {name: arrays[name] for name in arrays.files}
    except ValueError:
        raise
    except Exception as error:  # the readers of archives raise whatever they stumble over
        raise ValueError(f"it is no archive of arrays: {error}") from None


def check_readable(path: str | os.PathLike[str], what: str = "file", most: int = DATA) -> Path:
    """The path of a regular file that another library is to read; errors as :func:`read_bytes`."""
    where = path_of("path", path)
    try:
        status = where.stat()
    except FileNotFoundError:
        raise _unreadable(what, where, "No such file", MissingFileError) from None
    except OSError as error:
        raise _unreadable(what, where, error.strerror or str(error)) from None
    if not stat.S_ISREG(status.st_mode):
        kind = "a directory, a" if stat.S_ISDIR(status.st_mode) else "a pipe or a device, a regular"
        raise _unreadable(what, where, f"it is {kind} file is needed")
    if status.st_size > most:
        raise _unreadable(what, where, f"it has {status.st_size:.3g} bytes: at most {most:.3g} are read")
    return where


#: Bytes of a triangle in a file of a surface, at most: text with normals; packed archives hold more in less.
TRIANGLE = 300
PACKED_TRIANGLE = 30


def check_surface_file(path: str | os.PathLike[str], what: str, most: int) -> Path:
    """The path of a file of a triangulated surface that another library is to read.

    Parameters
    ----------
    path : path
    what : str
        What the file is, for the message.
    most : int
        Triangles up to which it is read. A binary STL file tells their number, of others the size bounds it.

    Raises
    ------
    ValueError
        As :func:`check_readable`; if the file holds more triangles.
    """
    kind = Path(path_of("path", path)).suffix.lower()
    bytes_each = PACKED_TRIANGLE if kind == ".3mf" else TRIANGLE
    where = check_readable(path, what, DATA)
    size = where.stat().st_size
    if kind == ".stl" and size >= 84:
        with where.open("rb") as stream:
            count = int.from_bytes(stream.read(84)[80:], "little")
        if size == 84 + 50 * count:
            check_triangles(count, most, f"{what} {where}")
    if size > bytes_each * most:
        raise _unreadable(
            what,
            where,
            f"it has {size:.3g} bytes: at most {bytes_each * most:.3g} are read, enough for {most} "
            "triangles; thin it out first (decimate or remesh it)",
        )
    return where


def check_triangles(count: int, most: int, what: str) -> None:
    """ValueError, about `what`, if a surface has more triangles than `most`."""
    if count > most:
        raise ValueError(
            f"{what} has {count} triangles: at most {most} are taken; thin it out first (decimate or remesh "
            "it to about the size of the cells of the contact)"
        )


def _unreadable(what: str, path: object, why: str, kind: type[ValueError] = ValueError) -> ValueError:
    colon = "" if what else ":"
    return kind(f"{what} {path}{colon} cannot be read: {why}".lstrip())


# --- out -----------------------------------------------------------------------------------------------


class Draft:
    """Files on their way into a folder."""

    def __init__(self, place: Path, target: Path) -> None:
        self._place, self._target = place, target

    def write(self, name: str, *data: bytes | memoryview) -> None:
        """Writes a file beside its place."""
        with open(self._place / name, "xb") as stream:
            stream.writelines(data)
            stream.flush()
            # some file systems find no room only now
            os.fsync(stream.fileno())

    def move(self, name: str, new: str | None = None) -> None:
        """Moves a written file into its place, in one step, under a new name if one is given."""
        os.replace(self._place / name, self._target / (new or name))


@contextlib.contextmanager
def drafted(folder: Path) -> Iterator[Draft]:
    """A draft of files for a folder, which is made if need be, and taken away again on failure.

    Raises
    ------
    OSError
        In one sentence, if the folder or a file of the draft cannot be written.
    """
    made: list[Path] = []
    try:
        _make(folder, made)
        clear(folder)
        with _locked_draft(folder) as place:
            yield Draft(place, folder)
    except OSError as error:
        _take_away(made)
        raise unwritable(folder, error) from None
    except BaseException:
        _take_away(made)
        raise


def write_bytes(path: str | os.PathLike[str], data: bytes | memoryview) -> None:
    """Writes a file so that what stands there is complete; folders that are missing are made.

    Raises
    ------
    ValueError
        If there is something else than a regular file.
    OSError
        If nothing can be written there.
    """
    target = check_target(path)
    with drafted(target.parent) as draft:
        draft.write(target.name, data)
        draft.move(target.name)


def check_target(path: str | os.PathLike[str]) -> Path:
    """The path of a file to be written, links followed; ValueError for what no file can replace."""
    given = path_of("path", path)
    target = Path(os.path.realpath(given))
    if target.is_dir():
        raise ValueError(f"cannot save into {given}: it is a directory, a file is needed")
    if target.exists() and not target.is_file():
        raise ValueError(f"cannot save into {given}: it is a pipe or a device, a regular file is needed")
    return target


def check_folder(folder: str | os.PathLike[str]) -> Path:
    """The path of a folder to be written into; nothing is left there.

    Raises
    ------
    ValueError
        If it is no folder.
    OSError
        In one sentence, if nothing can be written there.
    """
    target = path_of("directory", folder)
    if target.exists() and not target.is_dir():
        raise ValueError(f"cannot save into {target}: it is not a directory")
    made: list[Path] = []
    try:
        _make(target, made)
        with _locked_draft(target):
            pass
    except OSError as error:
        raise unwritable(target, error) from None
    finally:
        _take_away(made)
    return target


def output_folder(text: str) -> Path:
    """The type of an option -o of argparse: a folder, made if it is missing, into which one can write."""
    try:
        folder = check_folder(text)
        folder.mkdir(parents=True, exist_ok=True)
    except (ValueError, OSError) as error:
        raise argparse.ArgumentTypeError(str(error)) from None
    return folder


def clear(folder: Path) -> None:
    """Removes the drafts in a folder whose writers are no more."""
    try:
        left = [p for p in folder.iterdir() if p.name.startswith(DRAFT)]
    except OSError:
        return
    for place in left:
        with contextlib.suppress(OSError), _held(place) as is_free:
            if is_free and place.is_dir() and not place.is_symlink():
                shutil.rmtree(place, ignore_errors=True)


@contextlib.contextmanager
def _locked_draft(folder: Path) -> Iterator[Path]:
    while True:
        place = Path(tempfile.mkdtemp(prefix=DRAFT, dir=folder))
        with _held(place, wait=True):
            # another writer may have taken it for abandoned, in between
            if not place.exists():
                continue
            try:
                yield place
            finally:
                shutil.rmtree(place, ignore_errors=True)
            return


@contextlib.contextmanager
def _held(place: Path, wait: bool = False) -> Iterator[bool]:
    """Holds the lock of a draft; False where its writer lives."""
    if fcntl is None:
        yield wait or time.time() - place.stat().st_mtime > ABANDONED
        return
    handle = os.open(place, os.O_RDONLY | os.O_DIRECTORY | os.O_NOFOLLOW | os.O_CLOEXEC)
    try:
        try:
            fcntl.flock(handle, fcntl.LOCK_EX | (0 if wait else fcntl.LOCK_NB))
            is_free = True
        except BlockingIOError:
            is_free = False
        except OSError:  # a file system without locks
            is_free = wait or time.time() - os.fstat(handle).st_mtime > ABANDONED
        yield is_free
    finally:
        os.close(handle)


def _make(folder: Path, made: list[Path]) -> None:
    """Makes a folder and those above it, and notes which."""
    missing = []
    while not folder.exists():
        missing.append(folder)
        folder = folder.parent
    for one in reversed(missing):
        with contextlib.suppress(FileExistsError):
            one.mkdir()
            made.append(one)


def _take_away(made: list[Path]) -> None:
    for folder in reversed(made):
        with contextlib.suppress(OSError):
            folder.rmdir()


def unwritable(target: Path, error: OSError) -> OSError:
    """An error of writing, as one sentence."""
    told = type(error)(f"nothing can be written to {target}: {error.strerror or error}")
    told.errno = error.errno
    return told
