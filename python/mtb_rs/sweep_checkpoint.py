# SPDX-License-Identifier: MIT OR Apache-2.0
"""Solved cases of a sweep in a file, so that nothing is lost when it stops."""

from __future__ import annotations

import json
import os
from pathlib import Path
from typing import Annotated, Any, BinaryIO

from pydantic import AfterValidator, BaseModel, ConfigDict, Field, ValidationError

from .check import path_of
from .sweep_table import check_column

Record = dict[str, Any]


class _Line(BaseModel):
    model_config = ConfigDict(strict=True, extra="forbid")


class _Head(_Line):
    """The first line of a checkpoint."""

    sweep: str


class _Solved(_Line):
    """A further line: what became of a case."""

    case: Annotated[int, Field(ge=0)]
    status: str
    model: Annotated[str, Field(pattern=r"^[ -~]*$")] | None = None
    numbers: dict[Annotated[str, AfterValidator(check_column)], float] | None = None


class Checkpoint:
    """Solved cases in a file, one line each; the first line says of which sweep.

    Lines are only ever added, but for one that was cut short. What was solved, or has no solution, is not
    solved again; what failed in another way is, since it may have been the machine.
    """

    def __init__(self, path: str | os.PathLike[str] | None, key: str, cases: int) -> None:
        self.path = None if path is None else path_of("checkpoint", path)
        self._head = {"sweep": key}
        self.cases = cases
        self.records: dict[int, Record] = {}
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
        lines = path.read_bytes().splitlines(keepends=True) if path.exists() else []
        whole = 0
        for number, line in enumerate(lines, 1):
            if not line.endswith(b"\n") and (number > 1 or self._line(self._head).startswith(line)):
                break  # cut short by an interruption: solved again
            try:
                content = json.loads(line)
                # two sweeps that start at once may both write it
                if number == 1 or content == self._head:
                    self._check_head(path, _Head.model_validate(content))
                else:
                    self._take(_Solved.model_validate(content))
            except ValidationError as error:
                first = error.errors()[0]
                where = ".".join(map(str, first["loc"]))
                problem = f"{where}: {first['msg']}" if where else str(first["msg"])
                raise ValueError(_damaged(path, number, problem)) from None
            except _OtherSweep:
                raise
            except (ValueError, RecursionError) as error:
                raise ValueError(_damaged(path, number, str(error))) from None
            whole += len(line)
        return whole

    def _check_head(self, path: Path, head: _Head) -> None:
        if head.sweep != self._head["sweep"]:
            raise _OtherSweep(
                f"{path} is the checkpoint of another sweep (scene, values, options, measure or version of "
                "mtb_rs): remove it, or write elsewhere (checkpoint=, on the command line -o)"
            )

    def _take(self, line: _Solved) -> None:
        if line.case >= self.cases:
            raise ValueError(f"case is {line.case} of {self.cases}")
        is_solved = line.status == "solved"
        if is_solved and (line.model is None or line.numbers is None):
            raise ValueError("a solved case without model and numbers")
        if not is_solved and line.numbers is not None:
            raise ValueError("numbers of a case that is not solved")
        if is_solved or line.status.startswith("no solution"):
            self.records[line.case] = line.model_dump(exclude={"case"}, exclude_none=True)

    def __exit__(self, *_: object) -> None:
        if self._stream is not None:
            self._stream.close()

    def add(self, index: int, record: Record) -> None:
        """Keeps a record for good."""
        self._write({"case": index, **record})

    def _write(self, content: Record) -> None:
        if self._stream is not None:
            self._stream.write(self._line(content))
            self._stream.flush()
            os.fsync(self._stream.fileno())

    @staticmethod
    def _line(content: Record) -> bytes:
        return json.dumps(content).encode() + b"\n"


class _OtherSweep(ValueError):
    """A checkpoint that is sound, but of other work."""


def _damaged(path: Path, line: int, problem: str) -> str:
    return f"{path}, line {line}: no line of a checkpoint: {problem}; without the file all are solved again"
