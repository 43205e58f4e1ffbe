# SPDX-License-Identifier: MIT OR Apache-2.0
"""The notebooks of the documentation run, show what they showed, and tell nothing of the machine."""

from __future__ import annotations

import re
import runpy
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

nbformat = pytest.importorskip("nbformat", reason="pip install 'mtb-rs[test]'")
pytest.importorskip("nbclient", reason="pip install 'mtb-rs[test]'")

pytestmark = pytest.mark.slow  # starts a kernel for each

DOCS = Path(__file__).parents[2] / "docs"
BOOKS = sorted((DOCS / "notebooks").glob("*.ipynb"))
#: Most bytes of a notebook with its pictures.
MOST = 300_000
#: Numbers in what is printed.
NUMBER = re.compile(r"-?\d+(?:\.\d+)?(?:e[+-]?\d+)?")


def printed(book: Any) -> Iterator[str]:
    """What the cells print, and the words of what they show."""
    for cell in book.cells:
        for output in cell.get("outputs", ()):
            yield output.get("text", "")
            yield re.sub(r"<img[^>]*>|<[^>]+>", " ", output.get("data", {}).get("text/html", ""))


def test_there_are_notebooks() -> None:
    listed = re.findall(r"^notebooks/(\w+)$", (DOCS / "notebooks.md").read_text(encoding="utf-8"), re.M)
    assert sorted(listed) == [path.stem for path in BOOKS]


@pytest.mark.parametrize("path", BOOKS, ids=lambda path: path.stem)
def test_a_notebook_shows_what_it_showed(path: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend(str(DOCS))
    made = runpy.run_path(str(DOCS / "notebooks.py"))
    kept = nbformat.read(path, as_version=4)
    again = made["cleaned"](made["run"](path, str(tmp_path)))
    before, now = (" ".join(printed(book)) for book in (kept, again))
    assert NUMBER.sub("#", now) == NUMBER.sub("#", before)
    numbers = [[float(n) for n in NUMBER.findall(text)] for text in (now, before)]
    # other processors round otherwise, which the last digits show
    assert numbers[0] == pytest.approx(numbers[1], rel=2e-2, abs=1e-6)


@pytest.mark.parametrize("path", BOOKS, ids=lambda path: path.stem)
def test_a_notebook_is_small_and_tells_nothing_of_a_machine(path: Path) -> None:
    text = path.read_text(encoding="utf-8")
    assert len(text) < MOST
    book = nbformat.read(path, as_version=4)
    nbformat.validate(book)
    assert set(book.metadata) == {"kernelspec", "language_info"}
    shown = " ".join(printed(book))
    words = " ".join([shown, *(cell.source for cell in book.cells)])
    assert not re.search(r"(?<![\w.])/(home|root|tmp|work|opt|usr|Users)/|[A-Z]:\\", words)
    assert not re.search(r"\b\d{1,2}:\d\d\b|\b20\d\d-\d\d-\d\d\b|processor|\btime\b +[\d.]|\[s\]", shown)
    for cell in book.cells:
        assert not cell.metadata
        for output in cell.get("outputs", ()):
            assert output.output_type != "error"
            assert output.get("name") != "stderr"
            assert not (set(output.get("data", {})) >= {"text/html", "image/png"})
    # words between the cells, and a number that is compared
    assert sum(cell.cell_type == "markdown" for cell in book.cells) >= 4
    assert "assert" in words
