# SPDX-License-Identifier: MIT OR Apache-2.0
"""Nothing the package or its crates need is under a licence that spreads (GPL, AGPL); sources name theirs."""

from __future__ import annotations

import json
import re
import shutil
import subprocess
import tomllib
from importlib.metadata import Distribution, distribution
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
#: SPDX names of licences that ask for no more than their text to be kept.
PERMISSIVE = {
    "0BSD",
    "Apache-2.0",
    "Apache-2.0 WITH LLVM-exception",
    "BSD-2-Clause",
    "BSD-3-Clause",
    "BSL-1.0",
    "CC0-1.0",
    "ISC",
    "MIT",
    "MIT-0",
    "MIT-CMU",
    "PSF-2.0",
    "Unicode-3.0",
    "Unlicense",
    "Zlib",
}
#: file-wise copyleft: its own files stay under it, what uses them does not
PERMISSIVE |= {"MPL-2.0"}


def is_permitted(expression: str) -> bool:
    """Whether an SPDX expression leaves a choice that is permissive throughout."""
    expression = expression.replace("/", " OR ")
    while found := re.search(r"\(([^()]*)\)", expression):
        inner = "MIT" if is_permitted(found[1]) else "forbidden"
        expression = expression[: found.start()] + inner + expression[found.end() :]
    choices = [re.split(r"\s+AND\s+", choice) for choice in re.split(r"\s+OR\s+", expression)]
    return any(all(name.strip() in PERMISSIVE for name in choice) for choice in choices)


def test_expressions_are_understood() -> None:
    assert is_permitted("(MIT OR GPL-3.0-only) AND Unicode-3.0")
    assert is_permitted("MIT/Apache-2.0")
    assert not is_permitted("MIT AND GPL-2.0-or-later")
    assert not is_permitted("AGPL-3.0-only")
    assert not is_permitted("")


def test_crates() -> None:
    if shutil.which("cargo") is None:
        pytest.skip("cargo is not installed: the crates' licences are unknown here")
    command = ["cargo", "metadata", "--locked", "--format-version", "1"]
    run = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=True)
    packages = json.loads(run.stdout)["packages"]
    assert len(packages) > 50
    assert {p["name"]: p["license"] for p in packages if not is_permitted(p["license"] or "")} == {}


def licence(package: Distribution) -> str:
    """The SPDX expression, or what the classifiers and the older field say."""
    names = {
        "MIT License": "MIT",
        "BSD License": "BSD-3-Clause",
        "Apache Software License": "Apache-2.0",
        "Python Software Foundation License": "PSF-2.0",
    }
    if expression := package.metadata.get("License-Expression"):  # type: ignore[attr-defined]
        return expression
    classifiers = package.metadata.get_all("Classifier") or []
    stated = [c.split(" :: ")[-1] for c in classifiers if c.startswith("License ::")]
    if stated:
        return " AND ".join(names.get(name, name) for name in stated)
    return str(package.metadata.get("License") or "")  # type: ignore[attr-defined]


def needed(name: str, found: dict[str, str]) -> None:
    """All that an installation without extras brings along."""
    package = distribution(name)
    found[name] = licence(package)
    for requirement in package.requires or []:
        words = re.match(r"[A-Za-z0-9._-]+", requirement)
        if words and "extra ==" not in requirement and "python_version <" not in requirement:
            dependency = words[0].lower()
            if dependency not in found and "sys_platform" not in requirement:
                needed(dependency, found)


def test_python_packages() -> None:
    found: dict[str, str] = {}
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    for requirement in project["dependencies"]:
        needed(re.match(r"[A-Za-z0-9._-]+", requirement)[0].lower(), found)  # type: ignore[index]
    assert {"numpy", "trimesh"} <= set(found)
    assert {name: text for name, text in found.items() if not is_permitted(text)} == {}


def test_gpl_stays_behind_extras() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    assert not any(re.match("gmsh|tamaas", requirement) for requirement in project["dependencies"])


LINE = "SPDX-License-Identifier: MIT OR Apache-2.0"
#: Kinds of files that somebody writes, and that have comments.
KINDS = {
    ".c", ".cfg", ".cmake", ".cpp", ".css", ".f90", ".h", ".hpp", ".in", ".js", ".mplstyle", ".py", ".pyi",
    ".rs", ".sh", ".toml", ".yaml", ".yml",
}  # fmt: skip
#: Folders that are made, not written.
MADE = {"target", "_build", "out", "node_modules", "__pycache__", "build", "dist"}


def written(folder: Path) -> list[Path]:
    """Sources in a folder, those without an ending too, if they are scripts."""
    found = []
    for path in sorted(folder.iterdir()):
        if path.is_dir():
            if path.name not in MADE and (not path.name.startswith(".") or path.name == ".ci"):
                found += written(path)
            continue
        is_script = not path.suffix and path.read_bytes()[:2] == b"#!"
        if path.suffix in KINDS or path.name == "CMakeLists.txt" or is_script:
            found.append(path)
    return found


def test_every_source_names_its_licence() -> None:
    sources = written(ROOT)
    kinds = {path.suffix for path in sources}
    assert {"", ".py", ".pyi", ".rs", ".toml", ".c", ".h", ".f90", ".css"} <= kinds
    silent = [
        str(path.relative_to(ROOT))
        for path in sources
        if not any(LINE in line for line in path.read_text(encoding="utf-8").splitlines()[:2])
    ]
    assert silent == []
