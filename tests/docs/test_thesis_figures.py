# SPDX-License-Identifier: MIT OR Apache-2.0
"""Every figure of the thesis has a picture that answers it, drawn by a committed script."""

from __future__ import annotations

import tomllib
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

ROOT = Path(__file__).parents[2]
FIGURES = tomllib.loads((ROOT / "docs" / "thesis_figures.toml").read_text(encoding="utf-8"))
WANTED = {
    *(f"3.{k}" for k in (*range(2, 13), *range(14, 19))),
    *(f"4.{k}" for k in (1, 2, 3, 5, 6)),
    *(f"B.{k}" for k in range(1, 5)),
    *(f"C.{k}" for k in range(1, 5)),
    *(f"D.{k}" for k in range(1, 6)),
}


def test_list_is_complete() -> None:
    assert set(FIGURES) == WANTED


@pytest.mark.parametrize("number", sorted(WANTED))
def test_picture_is_there_and_not_blank(number: str) -> None:
    entry = FIGURES[number]
    assert entry["shows"]
    picture, script = ROOT / entry["picture"], ROOT / entry["script"]
    assert script.exists()
    with Image.open(picture) as image:
        pixels = np.asarray(image.convert("L"), dtype=float)
    assert min(pixels.shape) > 250
    assert pixels.std() > 8.0
    assert len(np.unique(pixels)) > 20
