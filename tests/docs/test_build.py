# SPDX-License-Identifier: MIT OR Apache-2.0
"""The documentation builds without a warning, and names all there is."""

from __future__ import annotations

import html
import json
import re
import shutil
import subprocess
import sys
from importlib.util import find_spec
from pathlib import Path
from typing import Any
from urllib.parse import unquote

import pytest

import mtb_rs as mtb

pytestmark = pytest.mark.slow  # builds the pages

ROOT = Path(__file__).parents[2]
DOCS = ROOT / "docs"
NEEDED = ("sphinx", "myst_parser", "myst_nb", "furo")


@pytest.fixture(scope="module")
def pages(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The built pages."""
    missing = [name for name in NEEDED if find_spec(name) is None]
    if missing:
        pytest.skip(f"{', '.join(missing)} missing: pip install 'mtb-rs[docs]'")
    out = tmp_path_factory.mktemp("docs")
    command = [sys.executable, "-m", "sphinx", "-W", "--keep-going", "-q", "-b", "html"]
    command += ["-d", str(out / "trees"), str(DOCS), str(out / "html")]
    built = subprocess.run(command, capture_output=True, text=True, check=False)
    assert built.returncode == 0, built.stderr
    return out / "html"


def test_every_page_is_there(pages: Path) -> None:
    for page in DOCS.glob("*.md"):
        text = (pages / f"{page.stem}.html").read_text(encoding="utf-8")
        assert "<h1>" in text
    # formulas are drawn by the browser alone; nothing is fetched from elsewhere
    theory = (pages / "theory.html").read_text(encoding="utf-8")
    assert "<math" in theory
    assert not re.search(r"<(script|link)[^>]*(src|href)=.https?:", theory)


@pytest.mark.parametrize("name", sorted(mtb.__all__))
def test_api_reference_is_complete(name: str) -> None:
    words = (DOCS / "api.md").read_text(encoding="utf-8")
    assert re.search(rf"\bmtb_rs\.{name}\b", words)


#: Widths [pixels] of a telephone and of a laptop.
WIDTHS = (400, 1280)


def seen_in_a_browser(folder: Path, names: list[str], profile: Path) -> list[Any]:
    """What a browser finds wrong in pages of a folder, at both widths."""
    browser = shutil.which("chromium") or shutil.which("google-chrome")
    if browser is None:
        pytest.skip("no browser: apt-get install chromium")
    script = (Path(__file__).parent / "browser.js").read_text(encoding="utf-8")
    known = f"const PAGES = {json.dumps(names)}, WIDTHS = {json.dumps(WIDTHS)};"
    (folder / "_frames.html").write_text(f"<!doctype html><body><script>{known}{script}</script></body>")
    command = [browser, "--headless", "--no-sandbox", "--disable-gpu", "--disable-web-security"]
    command += [f"--user-data-dir={profile}", "--virtual-time-budget=600000", "--dump-dom"]
    command += [(folder / "_frames.html").as_uri()]
    done = subprocess.run(command, capture_output=True, text=True, check=False, timeout=300)
    (folder / "_frames.html").unlink()
    report = re.search(r'<pre id="report">(.*?)</pre>', done.stdout, re.DOTALL)
    assert report is not None, done.stderr[-2000:]
    return list(json.loads(html.unescape(report[1])))


def test_pages_fit_narrow_and_wide_screens(pages: Path, tmp_path: Path) -> None:
    names = sorted(str(path.relative_to(pages)) for path in pages.rglob("*.html"))
    assert seen_in_a_browser(pages, names, tmp_path) == []


def test_a_page_that_fails_its_reader_is_found(tmp_path: Path) -> None:
    page = (
        '<!doctype html><article><img src="no.png"><a href="#no">x</a><p style="width:3000px">x</p></article>'
    )
    (tmp_path / "page.html").write_text(page)
    found = seen_in_a_browser(tmp_path, ["page.html"], tmp_path / "profile")
    said = [words for _, width, words in found if width == 400]
    assert [words.split(":")[0] for words in said] == [
        "broken image no.png",
        "broken link #no",
        "wider than the page",
    ]


def test_pictures_of_pages_are_figures_with_a_caption(pages: Path) -> None:
    figures = 0
    for page in DOCS.glob("*.md"):
        text = (pages / f"{page.stem}.html").read_text(encoding="utf-8")
        article = text[text.index("<article") : text.index("</article>")]
        said = r"<figcaption>\s*<p><span class=.caption-text.>(<strong>)?\w"
        told = re.compile(rf"<figure(?:(?!</figure>).)*{said}.*?</figure>", re.DOTALL)
        bare, found = told.subn("", article)
        figures += found
        assert "<img" not in bare, page.name
    assert figures > 50


def test_links_between_pages_lead_somewhere(pages: Path) -> None:
    anchors = {
        path: set(re.findall(r'\bid="([^"]+)"', path.read_text(encoding="utf-8")))
        for path in pages.rglob("*.html")
    }
    broken = []
    for path in anchors:
        for link in re.findall(r'<a [^>]*href="([^"]+)"', path.read_text(encoding="utf-8")):
            place, _, anchor = html.unescape(link).partition("#")
            if re.match(r"[a-z]+:", place) or not place:
                continue
            target = (path.parent / unquote(place)).resolve()
            known = target.is_file() and (
                not anchor or target not in anchors or unquote(anchor) in anchors[target]
            )
            if not known:
                broken.append((path.name, link))
    assert broken == []
