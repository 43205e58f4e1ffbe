# SPDX-License-Identifier: MIT OR Apache-2.0
"""Solved cases of a sweep in a file, so that nothing is lost when it stops."""

from __future__ import annotations

import errno
import json
import os
import zlib
from io import FileIO
from pathlib import Path
from typing import Any, ClassVar, Self

from .._mtb_rs import __version__
from ..base.check import path_of
from ..base.errors import MissingFileError
from ..base.files import read_bytes, unwritable
from ..base.fingerprint import fingerprint

Record = dict[str, Any]


class Checkpoint:
    """Solved cases in a file, one line of JSON each, with its checksum; the first says of which sweep.

    Lines are only ever added, but for one that was cut short. What was solved, or has no solution, is not
    solved again; what failed in another way is, since it may have been the machine. Who can write the file
    is trusted: a checksum tells damage, not a forged number.

    Parameters
    ----------
    path : path or None
    key : str
        What the sweep is known by.
    count : int
        Cases of the sweep.
    """

    #: What it is the checkpoint of, in messages.
    study = "sweep"
    told_by = "scene, values, options, measure or version of mtb_rs"
    #: What a damaged line asks for.
    mended_by = "remove it, and its case is solved again"

    def __init__(self, path: str | os.PathLike[str] | None, key: str, count: int) -> None:
        self.path = None if path is None else path_of("checkpoint", path)
        self._count = count
        self.records: dict[int, Record] = {}
        self._head = _line({"sweep": key})
        self._stream: FileIO | None = None

    def __enter__(self) -> Self:
        if self.path is None:
            return self
        whole = self._read(self.path)
        try:
            self.path.parent.mkdir(parents=True, exist_ok=True)
            # without a buffer, whose rest would be tried again when the file is closed
            self._stream = self.path.open("ab", buffering=0)
            self._stream.truncate(whole)
        except OSError as error:
            self.__exit__()
            raise unwritable(self.path, error) from None
        if not whole:
            self._write(self._head)
        return self

    def _read(self, path: Path) -> int:
        """Takes up the records; returns the bytes of whole lines."""
        try:
            lines = read_bytes(path, "checkpoint").split(b"\n")
        except MissingFileError:
            lines = [b""]
        # what an interruption cut short is solved again
        cut = lines.pop()
        if cut and not lines and not self._head.startswith(cut):
            raise ValueError(self._damaged(path, 1))
        for number, line in enumerate(lines, 1):
            content = _content(line)
            if content is None or (number == 1 and "sweep" not in content):
                raise ValueError(self._damaged(path, number))
            if "sweep" in content:
                # two sweeps that begin at once may both write it
                if line + b"\n" != self._head:
                    raise ValueError(
                        f"{path} is the checkpoint of another {self.study} ({self.told_by}): remove it, or "
                        "write elsewhere (checkpoint=, on the command line -o)"
                    )
            elif not self._is_record(content):
                raise ValueError(self._damaged(path, number))
            elif content["status"] == "solved" or content["status"].startswith("no solution"):
                self.records[content.pop("case")] = content
        return sum(len(line) + 1 for line in lines)

    def _is_record(self, content: Record) -> bool:
        case, numbers = content.get("case"), content.get("numbers", {})
        return (
            type(case) is int
            and 0 <= case < self._count
            and isinstance(content.get("status"), str)
            and isinstance(content.get("model", ""), str)
            and isinstance(content.get("missed", ""), str)
            and isinstance(content.get("asked", []), list)
            and all(isinstance(question, str) for question in content.get("asked", []))
            and isinstance(numbers, dict)
            and all(type(v) is float or (type(v) is int and abs(v) < 2**63) for v in numbers.values())
        )

    def _damaged(self, path: Path, line: int) -> str:
        return (
            f"{path}, line {line}: no line of a checkpoint, or a damaged one: {self.mended_by}; without the "
            "file all are"
        )

    def __exit__(self, *_: object) -> None:
        if self._stream is not None:
            self._stream.close()

    def add(self, index: int, record: Record) -> None:
        """Keeps a record for good, where there is a file."""
        if self._stream is not None:
            self._write(_line({"case": index, **record}))

    def _write(self, line: bytes) -> None:
        if self._stream is None or self.path is None:
            return
        try:
            begun = os.fstat(self._stream.fileno()).st_size
            if self._stream.write(line) != len(line):
                self._stream.truncate(begun)
                raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
            os.fsync(self._stream.fileno())
        except OSError as error:
            raise unwritable(self.path, error) from None


class StepCheckpoint(Checkpoint):
    """Steps of a study in a file, as :class:`Checkpoint` keeps cases: each a record of lists of numbers.

    Parameters
    ----------
    path : path or None
    given : list
        All that the study was asked.
    study : str
        What it is called in messages.
    told_by : str
        What tells it from another one.
    """

    mended_by = "remove it and all lines after it, and those steps are solved again"
    #: Steps that a file may hold.
    MOST: ClassVar[int] = 1_000_000

    def __init__(
        self, path: str | os.PathLike[str] | None, given: list[Any], study: str, told_by: str
    ) -> None:
        key = ""
        if path is not None:
            try:
                key = fingerprint([__version__, study, *given])
            except ValueError as error:
                raise ValueError(f"no checkpoint is possible: {error}") from error
        super().__init__(path, key, self.MOST)
        self.study, self.told_by = study, f"{told_by} or version of mtb_rs"

    def in_order(self) -> list[Record]:
        """What the file holds, from the first step on.

        Raises
        ------
        ValueError
            If a step is missing: those after it begin where it has ended.
        """
        numbers = sorted(self.records)
        for k, number in enumerate(numbers):
            if k != number:
                raise ValueError(
                    f"{self.path}: step {k + 1} of the {self.study} is missing, and step {number + 1} goes "
                    "on from it: remove the lines from there on, and those steps are solved again; without "
                    "the file all are"
                )
        return [self.records[k] for k in numbers]

    def _is_record(self, content: Record) -> bool:
        lists = [value for name, value in content.items() if name not in ("case", "status")]
        return (
            type(content.get("case")) is int
            and content.get("status") == "solved"
            and "numbers" in content
            and all(
                isinstance(values, list) and all(type(v) in (float, int, type(None)) for v in values)
                for values in lists
            )
        )


_SUM = b', "crc32": '


def _line(content: Record) -> bytes:
    text = json.dumps(content).encode()
    return text[:-1] + _SUM + str(zlib.crc32(text)).encode() + b"}\n"


def _content(line: bytes) -> Record | None:
    """What :func:`_line` made a line of; None for any other line."""
    start, _, end = line.rpartition(_SUM)
    text = start + b"}"
    if end != str(zlib.crc32(text)).encode() + b"}":
        return None
    try:
        content = json.loads(text)
    except (ValueError, RecursionError):
        return None
    return content if isinstance(content, dict) else None
