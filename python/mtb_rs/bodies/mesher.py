# SPDX-License-Identifier: MIT OR Apache-2.0
"""gmsh in a process of its own: a file that ends it by a signal, or Ctrl-C, ends that process only.

:func:`gmsh_beside` gives what looks like the module gmsh; each call of one of its functions goes to the
other process, which is this file run as a program, and waits for the answer.
"""

from __future__ import annotations

import contextlib
import importlib.util
import os
import pickle
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any, BinaryIO


class GmshError(RuntimeError):
    """What gmsh says of a call, or that its process ended."""


class _Remote:
    """A function of gmsh, or a part of it that holds some, by its dotted name."""

    def __init__(self, process: subprocess.Popen[bytes], name: str = "") -> None:
        self._process, self._name = process, name

    def __getattr__(self, part: str) -> _Remote:
        return _Remote(self._process, f"{self._name}.{part}".lstrip("."))

    def __call__(self, *arguments: Any) -> Any:
        return _ask(self._process, (self._name, arguments))


def _ask(process: subprocess.Popen[bytes], question: Any) -> Any:
    assert process.stdin is not None
    assert process.stdout is not None
    try:
        pickle.dump(question, process.stdin)
        process.stdin.flush()
        is_good, answer = pickle.load(process.stdout)
    except (EOFError, OSError, pickle.UnpicklingError):
        code = process.wait()
        how = f"signal {-code} ({signal.Signals(-code).name})" if code < 0 else f"code {code}"
        why = "it cannot take this shape, or the memory did not suffice"
        raise GmshError(f"gmsh ended by {how}: {why}") from None
    if not is_good:
        raise GmshError(answer)
    return answer


@contextlib.contextmanager
def gmsh_beside() -> Iterator[Any]:
    """gmsh, silent and on one thread: the same mesh every time.

    Raises
    ------
    ImportError
        If gmsh is not installed, or a library that it loads is missing.
    """
    if importlib.util.find_spec("gmsh") is None:
        raise ImportError("No module named 'gmsh'", name="gmsh")
    # -P: the modules beside this file are not to be found under their bare names
    command = [sys.executable, "-P", str(Path(__file__))]
    with subprocess.Popen(
        command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL
    ) as other:
        try:
            try:
                _ask(other, sys.path)
            except GmshError as error:
                raise ImportError(str(error), name="gmsh") from None
            yield _Remote(other)
        finally:
            # not asked to end: it may be in the midst of a mesh
            other.kill()
            assert other.stdin is not None
            with contextlib.suppress(OSError):  # a question that it did not live to read
                other.stdin.close()


def _serve(questions: BinaryIO, answers: BinaryIO) -> None:
    """Calls what is asked for until there are no more questions."""
    sys.path[:] = pickle.load(questions)
    try:
        import gmsh

        gmsh.initialize(interruptible=False)
        gmsh.option.setNumber("General.Terminal", 0)
        gmsh.option.setNumber("General.NumThreads", 1)
        answer: tuple[bool, Any] = True, None
    except (ImportError, OSError) as error:
        answer = False, str(error)
    while True:
        pickle.dump(answer, answers)
        answers.flush()
        try:
            name, arguments = pickle.load(questions)
        except EOFError:
            return
        try:
            function: Any = gmsh
            for part in name.split("."):
                function = getattr(function, part)
            answer = True, function(*arguments)
        except Exception as error:
            answer = False, str(error)


def _end_with(asking: int) -> None:
    """Ends this process when the one that asks is no more."""
    while os.getppid() == asking:
        time.sleep(0.5)
    os._exit(1)


if __name__ == "__main__":
    # the one that asks ends this process; Ctrl-C goes to both
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    threading.Thread(target=_end_with, args=(os.getppid(),), daemon=True).start()
    # what gmsh prints is no answer
    answers = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)
    with contextlib.suppress(BrokenPipeError):
        _serve(sys.stdin.buffer, answers)
