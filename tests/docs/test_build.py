# SPDX-License-Identifier: MIT OR Apache-2.0
"""The documentation builds without a warning, and names all there is."""

from __future__ import annotations

import re
import subprocess
import sys
from importlib.util import find_spec
from pathlib import Path

import pytest

import mtb_rs as mtb

pytestmark = pytest.mark.slow  # builds the pages

ROOT = Path(__file__).parents[2]
DOCS = ROOT / "docs"
NEEDED = ("sphinx", "myst_parser", "furo")


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
