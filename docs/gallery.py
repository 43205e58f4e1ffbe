# SPDX-License-Identifier: MIT OR Apache-2.0
"""Runs the examples, and the code of the pages, and keeps what they print and draw for the documentation.

    python docs/gallery.py [EXAMPLE | PAGE.md ...]

Without a name everything is run, which takes some minutes. An example leaves what it printed and drew in
`gallery/NAME/`; a page leaves in `pictures/` those it shows from there, and as `PAGE_K.txt` what its K-th
block of Python printed.
"""

from __future__ import annotations

import argparse
import contextlib
import io
import os
import re
import shlex
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

DOCS = Path(__file__).resolve().parent
EXAMPLES = DOCS.parent / "examples"
PICTURES = (".png", ".gif")
#: The folder of one case in several languages, which need a toolchain.
SIDE_BY_SIDE = "side_by_side"

#: A fenced block: its language, its options, its text.
FENCE = re.compile(r"^```(?:\{code-block\} )?(\w+)\n((?::\w+:[^\n]*\n)*)(.*?)^```$", re.DOTALL | re.MULTILINE)


def run_example(name: str, folder: Path) -> str:
    """Runs a script of `examples/` in `folder`, where its pictures are then, and returns what it printed.

    A name without a script is that of a folder, whose `run` is started.
    """
    script = EXAMPLES / f"{name}.py"
    command = [sys.executable, str(script)] if script.exists() else ["sh", str(EXAMPLES / name / "run")]
    environment = os.environ | {"PYTHON": sys.executable}
    done = subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True, check=False)
    if done.returncode:
        raise RuntimeError(f"{name}: {done.stderr}")
    return done.stdout


def run_page(page: Path, folder: Path) -> list[str]:
    """Runs the code of a page in `folder`, in its order, and returns what each block of Python printed.

    ``python`` blocks share their names; a ``toml`` or ``text`` block with a caption is written to the file
    that it names; the ``mtb-rs`` lines of a ``console`` block must end with 0.
    """
    names: dict[str, Any] = {"__name__": "__main__"}
    printed: list[str] = []
    with contextlib.chdir(folder):
        for language, options, text in FENCE.findall(page.read_text(encoding="utf-8")):
            caption = re.search(r":caption: (\S+)", options)
            if language == "python":
                out = io.StringIO()
                with contextlib.redirect_stdout(out):
                    exec(compile(text, str(page), "exec"), names)
                printed.append(out.getvalue())
            elif language in ("toml", "text") and caption:
                Path(caption[1]).write_text(text, encoding="utf-8")
            elif language == "console":
                for line in commands(text):
                    run_command(line)
    return printed


def commands(text: str) -> Iterator[list[str]]:
    """The words after ``$ mtb-rs`` of each such line."""
    for line in text.splitlines():
        if line.startswith("$ mtb-rs "):
            yield shlex.split(line)[2:]


def run_command(words: list[str]) -> None:
    from mtb_rs.commands import main

    printed = io.StringIO()
    with contextlib.redirect_stdout(printed), contextlib.redirect_stderr(printed):
        code = main(words)
    if code:
        raise RuntimeError(f"mtb-rs {' '.join(words)} ends with {code}: {printed.getvalue()}")


def pages() -> list[Path]:
    """The pages that have code to run."""
    every = sorted(DOCS.glob("*.md"))
    return [page for page in every if any(block[0] == "python" for block in FENCE.findall(page.read_text()))]


def keep_example(name: str) -> None:
    kept = DOCS / "gallery" / name
    shutil.rmtree(kept, ignore_errors=True)
    kept.mkdir(parents=True)
    with tempfile.TemporaryDirectory() as folder:
        (kept / "printed.txt").write_text(run_example(name, Path(folder)), encoding="utf-8")
        for picture in sorted(Path(folder).iterdir()):
            if picture.suffix in PICTURES:
                shutil.copy(picture, kept)


def keep_page(page: Path) -> None:
    wanted = re.findall(r"pictures/([\w.-]+)", page.read_text(encoding="utf-8"))
    with tempfile.TemporaryDirectory() as folder:
        for k, text in enumerate(run_page(page, Path(folder)), start=1):
            (Path(folder) / f"{page.stem}_{k}.txt").write_text(text, encoding="utf-8")
        for name in dict.fromkeys(wanted):
            shutil.copy(Path(folder) / name, DOCS / "pictures" / name)


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("names", nargs="*", metavar="EXAMPLE | PAGE.md")
    names = parser.parse_args().names
    os.environ.setdefault("MPLBACKEND", "Agg")
    if not names:
        names = [p.stem for p in sorted(EXAMPLES.glob("*.py"))] + [SIDE_BY_SIDE] + [p.name for p in pages()]
    (DOCS / "pictures").mkdir(exist_ok=True)
    for name in names:
        print(name)
        if name.endswith(".md"):
            keep_page(DOCS / name)
        else:
            keep_example(name)


if __name__ == "__main__":
    main()
