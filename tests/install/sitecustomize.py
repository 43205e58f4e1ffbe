# SPDX-License-Identifier: MIT OR Apache-2.0
"""Python imports this as it starts, if this folder is in PYTHONPATH: it hides modules."""

import os
import sys
from importlib.machinery import ModuleSpec, PathFinder
from typing import Any

HIDDEN = frozenset(os.environ.get("HIDDEN_MODULES", "").split())


class Visible(PathFinder):
    @classmethod
    def find_spec(cls, fullname: str, path: Any = None, target: Any = None) -> ModuleSpec | None:
        if fullname.partition(".")[0] in HIDDEN:
            return None
        return PathFinder.find_spec(fullname, path, target)


sys.meta_path = [Visible if finder is PathFinder else finder for finder in sys.meta_path]
