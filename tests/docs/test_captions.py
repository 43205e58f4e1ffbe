# SPDX-License-Identifier: MIT OR Apache-2.0
"""Every picture of the pages, of the notebooks and of the README has a caption that says what to see."""

from __future__ import annotations

import json
import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
DOCS = ROOT / "docs"
PAGES = [ROOT / "README.md", *sorted(DOCS.rglob("*.md"))]
BOOKS = sorted((DOCS / "notebooks").glob("*.ipynb"))

#: A fenced block, which is code unless it is a directive.
FENCE = re.compile(r"^(`{3,}|:{3,})(\{[\w-]+\})?[^\n]*\n(.*?)^\1 *$", re.DOTALL | re.MULTILINE)
#: A paragraph of emphasis that is a sentence at least.
CAPTION = re.compile(r"\*[^*\s][^*]*[.?]\*")


def bare_pictures(text: str) -> list[str]:
    """The pictures of a page without a caption."""
    bare = []
    for _, directive, content in FENCE.findall(text):
        told = directive == "{figure}" and re.search(r"^[^:\n]", content, re.MULTILINE)
        if directive in ("{image}", "{figure}") and not told:
            bare.append(content)
    paragraphs = [part.strip() for part in re.split(r"\n\s*\n", FENCE.sub("", text))]
    for paragraph, below in zip(paragraphs, [*paragraphs[1:], ""], strict=True):
        pictures = re.findall(r"!\[[^\]]*\]\([^)]*\)", paragraph) + re.findall(r"<img[^>]*>", paragraph)
        if pictures and not (pictures == [paragraph] and CAPTION.fullmatch(below)):
            bare += pictures
    return bare


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))
def test_a_page_says_what_its_pictures_show(page: Path) -> None:
    assert bare_pictures(page.read_text(encoding="utf-8")) == []


@pytest.mark.parametrize("book", BOOKS, ids=lambda path: path.stem)
def test_a_notebook_says_what_its_pictures_show(book: Path) -> None:
    cells = json.loads(book.read_text(encoding="utf-8"))["cells"]
    for number, cell in enumerate(cells):
        shown = json.dumps([output.get("data", {}) for output in cell.get("outputs", ())])
        if "image/png" in shown:
            below = cells[number + 1] if number + 1 < len(cells) else {"source": ""}
            assert CAPTION.fullmatch("".join(below["source"]).split("\n\n")[0]), "".join(cell["source"])


@pytest.mark.parametrize(
    "text",
    [
        "![axes](axes.svg)\n\nThe axes are drawn above.\n",
        "![axes](axes.svg)\n\n*axes*\n",
        "Text with a picture ![axes](axes.svg)\n\n*Its axes.*\n",
        "```{image} axes.svg\n:alt: axes\n```\n\n*Its axes.*\n",
        "```{figure} axes.svg\n:alt: axes\n```\n",
        '<img src="axes.svg">\n',
    ],
)
def test_a_picture_without_a_caption_is_found(text: str) -> None:
    assert len(bare_pictures(text)) == 1
    assert bare_pictures("![axes](axes.svg)\n\n*Its axes, x to the right.*\n") == []
