# SPDX-License-Identifier: MIT OR Apache-2.0
"""The page of messages is what the package says: a sample of bad input, and every place it names."""

from __future__ import annotations

import importlib.util
import re
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import mtb_rs as mtb

ROOT = Path(__file__).parents[2]
PAGE = (ROOT / "docs" / "messages.md").read_text(encoding="utf-8")
SAMPLE: list[Callable[[], object]] = [
    lambda: mtb.Coulomb(-0.1),
    lambda: mtb.FallingFriction(0.3, 0.1, 0.0),
    lambda: mtb.scenes.pole_shoe_on_rail(lateral=float("nan")),
    lambda: mtb.ElasticBody(
        mtb.TetraMesh(np.zeros((3, 4)), np.zeros((5, 1), dtype=int), {}), mtb.steel, "top"
    ),
]


def shape_of(message: str) -> str:
    spec = importlib.util.spec_from_file_location("messages", ROOT / "studies" / "messages.py")
    assert spec is not None
    assert spec.loader is not None
    script = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(script)
    return str(script.told_apart(script.cleaned(message)))


@pytest.mark.parametrize("call", SAMPLE)
def test_a_sample_is_on_the_page(call: Callable[[], object]) -> None:
    with pytest.raises(ValueError) as caught:  # noqa: PT011
        call()
    rows = {shape_of(row.replace("\\", "")) for row in re.findall(r"^\| \w+ \| (.*) \|$", PAGE, re.MULTILINE)}
    assert shape_of(str(caught.value)) in rows


def test_places_are_there() -> None:
    places = re.findall(r"^## `(.+)`$", PAGE, re.MULTILINE)
    assert len(places) > 20
    assert [place for place in places if not (ROOT / "python" / "mtb_rs" / place).is_file()] == []
