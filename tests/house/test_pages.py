# SPDX-License-Identifier: MIT OR Apache-2.0
"""Pages show what their own code printed: `docs/gallery.py` numbers it by the blocks of Python."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

DOCS = Path(__file__).parents[2] / "docs"
PARTS = re.compile(r"^```(python)$|pictures/(\w+)_(\d+)\.txt", re.MULTILINE)


@pytest.mark.parametrize("page", sorted(DOCS.glob("*.md")), ids=lambda page: page.name)
def test_what_is_shown_is_of_the_block_above(page: Path) -> None:
    blocks = 0
    for language, name, number in PARTS.findall(page.read_text(encoding="utf-8")):
        if language:
            blocks += 1
        elif name == page.stem:
            assert int(number) == blocks
            assert (DOCS / "pictures" / f"{name}_{number}.txt").exists()
