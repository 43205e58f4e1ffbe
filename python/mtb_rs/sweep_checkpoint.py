# SPDX-License-Identifier: MIT OR Apache-2.0
"""Solved cases of a sweep in a file, so that nothing is lost when it stops."""

from __future__ import annotations

import json
import os
import zlib
from pathlib import Path
from typing import Any, BinaryIO

from .check import path_of

Record = dict[str, Any]


class Checkpoint:
    """Solved cases in a file, one line of JSON each, with its checksum; the first says of which sweep.

    Lines are only ever added, but for one that was cut short. What was solved, or has no solution, is not
    solved again; what failed in another way is, since it may have been the machine.
    """

    def __init__(self, path: str | os.PathLike[str] | None, key: str) -> None:
        self.path = None if path is None else path_of("checkpoint", path)
        self.records: dict[int, Record] = {}
        self._head = _line({"sweep": key})
        self._stream: BinaryIO | None = None

    def __enter__(self) -> Checkpoint:
        if self.path is None:
            return self
        if self.path.is_dir():
            raise ValueError(f"checkpoint is {self.path}: a file is needed, not a directory")
        whole = self._read(self.path)
        self._stream = self.path.open("ab")
        self._stream.truncate(whole)
        if not whole:
            self._write(self._head)
        return self

    def _read(self, path: Path) -> int:
        """Takes up the records; returns the bytes of whole lines."""
        lines = path.read_bytes().split(b"\n") if path.exists() else [b""]
        # what an interruption cut short is solved again
        cut = lines.pop()
        if cut and not lines and not self._head.startswith(cut):
            raise ValueError(_damaged(path, 1))
        for number, line in enumerate(lines, 1):
            content = _content(line)
            if content is None or (number == 1 and "sweep" not in content):
                raise ValueError(_damaged(path, number))
            if "sweep" in content:
                # two sweeps that begin at once may both write it
                if line + b"\n" != self._head:
                    raise ValueError(
                        f"{path} is the checkpoint of another sweep (scene, values, options, measure or "
                        "version of mtb_rs): remove it, or write elsewhere (checkpoint=, on the command "
                        "line -o)"
                    )
            elif content["status"] == "solved" or content["status"].startswith("no solution"):
                self.records[content.pop("case")] = content
        return sum(len(line) + 1 for line in lines)

    def __exit__(self, *_: object) -> None:
        if self._stream is not None:
            self._stream.close()

    def add(self, index: int, record: Record) -> None:
        """Keeps a record for good."""
        self._write(_line({"case": index, **record}))

    def _write(self, line: bytes) -> None:
        if self._stream is not None:
            self._stream.write(line)
            self._stream.flush()
            os.fsync(self._stream.fileno())


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
    content: Record = json.loads(text)
    return content


def _damaged(path: Path, line: int) -> str:
    return (
        f"{path}, line {line}: no line of a checkpoint, or a damaged one: remove it, and its case is solved "
        "again; without the file all are"
    )
