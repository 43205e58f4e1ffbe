# SPDX-License-Identifier: MIT OR Apache-2.0
"""The table ``[stress]`` of a case file: in which body, and at which depths."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, get_args

from ..base.check import choice
from ..base.words import Body
from ..results.stressed import rising_depths
from .looks import NOT_NEGATIVE, check_keys, table

#: What the table looks like to an editor.
LOOK = table(
    [],
    body={"enum": list(get_args(Body)), "description": "The body; the lower one by default."},
    depths={
        "type": "array",
        "items": NOT_NEGATIVE,
        "minItems": 1,
        "description": "Rising depths [m]; by default 36 of them, to three half widths of the contact.",
    },
    patch={"type": "string", "description": "The grid below which, of several; else that of the peak."},
)


def stress_of(given: Any) -> dict[str, Any]:
    """The arguments of ``stress()`` of a result that the table means."""
    if not isinstance(given, Mapping):
        raise ValueError("a table, maybe with body, depths and patch, is needed")
    check_keys(given, LOOK)
    found = dict(given)
    if "body" in given:
        choice("body", given["body"], Body)
    if "depths" in given:
        found["depths"] = rising_depths(given["depths"])
    if not isinstance(given.get("patch", ""), str):
        raise ValueError(f"patch is {given['patch']!r}: the name of a grid is needed")
    return found
