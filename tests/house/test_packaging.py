# SPDX-License-Identifier: MIT OR Apache-2.0
"""The recipes that package mtb-rs for others name what the project itself names."""

from __future__ import annotations

import re
import subprocess
import tomllib
from pathlib import Path

import pytest
import yaml

ROOT = Path(__file__).parents[2]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
VERSION = tomllib.loads((ROOT / "Cargo.toml").read_text(encoding="utf-8"))["workspace"]["package"]["version"]
# names that conda gives to packages of the Python index
CONDA = {"matplotlib": "matplotlib-base"}


def named(requirement: str) -> tuple[str, str]:
    """Name and bounds of a requirement."""
    name, bounds = re.fullmatch(r"([\w-]+)\s*(.*)", requirement).groups()
    return CONDA.get(name, name), bounds


def test_the_conda_recipe_follows_the_project() -> None:
    recipe = yaml.safe_load((ROOT / "packaging" / "conda" / "recipe.yaml").read_text(encoding="utf-8"))
    assert recipe["context"]["version"] == VERSION
    assert recipe["about"]["license"] == PROJECT["license"]
    assert recipe["about"]["summary"] == PROJECT["description"]
    wanted = {named(requirement) for requirement in PROJECT["dependencies"]}
    wanted.add(("python", PROJECT["requires-python"]))
    assert {named(requirement) for requirement in recipe["requirements"]["run"]} == wanted


def test_the_docker_file_installs_extras_and_libraries_that_exist() -> None:
    recipe = (ROOT / "packaging" / "Dockerfile").read_text(encoding="utf-8")
    extras = re.search(r"\.whl\)\[([\w,]+)\]", recipe)
    assert extras
    assert set(extras[1].split(",")) <= set(PROJECT["optional-dependencies"])
    # the Debian packages of 3-D pictures and gmsh are those of the gate, but for its browser
    gate = (ROOT / ".ci" / "run").read_text(encoding="utf-8")
    assert set(re.findall(r"\blib[\w-]+", recipe)) - {"lib"} == set(re.findall(r"\blib[a-z]\w*[\w-]*", gate))
    assert len([line for line in recipe.splitlines() if line and not line.startswith("#")]) <= 20


@pytest.mark.parametrize("script", ["runtime", "cross-wheels", "bare-debian"])
def test_scripts_have_no_errors_of_syntax(script: str) -> None:
    path = ROOT / "packaging" / script
    done = subprocess.run(["bash", "-n", str(path)], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert path.stat().st_mode & 0o111


def test_files_that_build_call_scripts_that_exist() -> None:
    callers = [*ROOT.glob(".ci/*"), *ROOT.glob(".github/workflows/*.yml"), *(ROOT / "packaging").iterdir()]
    for caller in callers:
        if caller.is_file():
            for name in re.findall(r"(?:\.ci|packaging)/[\w-]+", caller.read_text(encoding="utf-8")):
                assert (ROOT / name).exists(), f"{caller.name} calls {name}"
