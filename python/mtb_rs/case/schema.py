# SPDX-License-Identifier: MIT OR Apache-2.0
"""The JSON schema of case files, for editors that complete and check them."""

from __future__ import annotations

import inspect
from itertools import combinations
from typing import Any

from ..scenes import ready as scenes
from . import SCENES, case_model
from .values import MOTIONS


def schema() -> dict[str, Any]:
    """The JSON schema of case files, for editors: [JSON Schema 2020-12], one branch for each scene."""
    branches, shared = [], {}
    for name in SCENES:
        branch = case_model(name).model_json_schema()
        shared.update(branch.pop("$defs", {}))
        branch["properties"]["scene"] = {
            "const": name,
            "description": (inspect.getdoc(getattr(scenes, name)) or "").split("\n")[0],
        }
        branch["title"] = name
        pairs = [*combinations(("wear", "brake", "step_wheels", *MOTIONS), 2), ("brake", "stress")]
        branch["not"] = {"anyOf": [{"required": list(pair)} for pair in pairs]}
        branches.append(branch)
    return {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": "case file of mtb_rs",
        "type": "object",
        "oneOf": branches,
        "$defs": shared,
    }
