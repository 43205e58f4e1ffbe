# SPDX-License-Identifier: MIT OR Apache-2.0
"""The code of README and pages runs as it stands, with the extras that each page names and no others, and the
gallery holds every example."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from collections.abc import Callable
from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path
from types import ModuleType

import pytest

from mtb_rs.pictures.space import missing_for_view

pytestmark = pytest.mark.slow  # runs every page in a process of its own

ROOT = Path(__file__).parents[2]
DOCS = ROOT / "docs"


def _gallery() -> ModuleType:
    spec = spec_from_file_location("docs_gallery", DOCS / "gallery.py")
    assert spec is not None
    assert spec.loader is not None
    module = module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


GALLERY = _gallery()
PAGES = [ROOT / "README.md", ROOT / "rust" / "capi" / "README.md", *GALLERY.pages()]


def extras_named(text: str) -> set[str]:
    """Extras that a page names: those it installs, and those it says that something needs."""
    installed = re.findall(r"pip install [^\n`]*\[([\w,]+)\]", text)
    needed = re.findall(r"extra `(\w+)`", text)
    return {*needed, *(name for names in installed for name in names.split(","))}


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))
def test_page_runs(page: Path, tmp_path: Path, with_extras: Callable[..., dict[str, str]]) -> None:
    text = page.read_text(encoding="utf-8")
    if '"3d"' in text and page.name != "README.md" and missing_for_view():
        pytest.skip(f"{page.name} draws in space: {missing_for_view()}")
    if "from_mesh(" in text:
        pytest.importorskip("gmsh", reason="pip install 'mtb-rs[mesh]'", exc_type=ImportError)
    code = "import sys, pathlib, gallery; gallery.run_page(*map(pathlib.Path, sys.argv[1:]))"
    packages = re.findall(r"`pip install (\w+)`", text)
    environment = with_extras(*extras_named(text), packages=packages)
    environment["PYTHONPATH"] += f"{os.pathsep}{DOCS}"
    # without a GL driver save() warns
    command = [sys.executable, "-W", "ignore", "-c", code, str(page), str(tmp_path)]
    done = subprocess.run(command, env=environment, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr


def test_every_page_with_code_is_run() -> None:
    # a page is tutorial-like as soon as it has a block of Python
    assert {"tutorial.md", "fields.md", "simulation.md"} <= {page.name for page in PAGES}


@pytest.mark.parametrize("script", sorted((ROOT / "examples").glob("*.py")), ids=lambda path: path.stem)
def test_gallery_holds_every_example(script: Path) -> None:
    page = (DOCS / "gallery.md").read_text(encoding="utf-8")
    assert f"```{{example}} {script.stem}\n" in page
    assert (DOCS / "gallery" / script.stem / "printed.txt").stat().st_size > 0


def test_gallery_keeps_what_an_example_prints(tmp_path: Path) -> None:
    kept = (DOCS / "gallery" / "hertz" / "printed.txt").read_text(encoding="utf-8")
    assert GALLERY.run_example("hertz", tmp_path) == kept
