# SPDX-License-Identifier: MIT OR Apache-2.0
"""Keeps the messages that users meet, for `studies/messages.py`: set MTB_RS_MESSAGES to a file."""

from __future__ import annotations

import json
import os
import traceback
import warnings
from pathlib import Path
from typing import Any

import pytest
from _pytest.raises import RaisesExc

import mtb_rs

PACKAGE = Path(mtb_rs.__file__).parent
KEPT = os.environ.get("MTB_RS_MESSAGES")


def keep(kind: str, message: str, files: list[str]) -> None:
    """One line of the file, if the innermost of `files` is one of the package."""
    if not files or not Path(files[-1]).is_relative_to(PACKAGE):
        return
    # checks are written once, what matters is who asked
    asked = [f for f in files if Path(f).is_relative_to(PACKAGE) and Path(f).parent.name != "base"]
    place = Path((asked or files)[-1]).relative_to(PACKAGE).as_posix()
    line = json.dumps({"place": place, "kind": kind, "message": message})
    assert KEPT is not None
    with open(KEPT, "a", encoding="utf-8") as out:
        out.write(line + "\n")


if KEPT:

    @pytest.fixture(autouse=True)
    def _messages_kept(monkeypatch: pytest.MonkeyPatch) -> None:
        leave, warn = RaisesExc.__exit__, warnings.warn

        def left(self: Any, kind: Any, error: Any, trace: Any) -> Any:
            if error is not None:
                files = [frame.filename for frame in traceback.extract_tb(trace)]
                keep(kind.__name__, str(error), files)
            return leave(self, kind, error, trace)

        def warned(message: Any, category: Any = UserWarning, stacklevel: int = 1, **options: Any) -> None:
            files = [frame.filename for frame in traceback.extract_stack()[:-1]]
            keep(category.__name__, str(message), files)
            warn(message, category, stacklevel + 1, **options)

        monkeypatch.setattr(RaisesExc, "__exit__", left)
        monkeypatch.setattr(warnings, "warn", warned)
