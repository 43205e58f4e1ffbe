# SPDX-License-Identifier: MIT OR Apache-2.0
"""What tables of a case file look like to an editor, and their keys."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from ..base.check import meant

NUMBER = {"type": "number"}
POSITIVE = {**NUMBER, "exclusiveMinimum": 0}
NOT_NEGATIVE = {**NUMBER, "minimum": 0}
NUMBERS = {"type": "array", "items": NUMBER}


def table(required: list[str], **properties: Any) -> dict[str, Any]:
    """The JSON schema of a table with these keys and no others."""
    return {"type": "object", "additionalProperties": False, "required": required, "properties": properties}


def check_keys(given: Mapping[str, Any], look: dict[str, Any]) -> None:
    """ValueError for a key that the JSON schema of a table does not know."""
    known = look["properties"]
    for name in given:
        if name not in known:
            near = meant(name, known)
            hint = f"did you mean {near!r}?" if near else f"known are {', '.join(known)}"
            raise ValueError(f"{name}: unknown key; {hint}")
