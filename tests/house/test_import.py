# SPDX-License-Identifier: MIT OR Apache-2.0
"""The bare package is light: no plotting, meshing or scientific library comes with the import."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import mtb_rs as mtb

HEAVY = ("matplotlib", "pyvista", "vtkmodules", "vtk", "scipy", "gmsh", "meshio", "pint", "pandas", "xarray")


def test_import_pulls_nothing_heavy() -> None:
    script = f"import sys, mtb_rs; print([m for m in {HEAVY!r} if m in sys.modules])"
    run = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
    assert run.stdout.strip() == "[]"


def test_every_public_name_exists_once() -> None:
    assert len(set(mtb.__all__)) == len(mtb.__all__)
    assert [name for name in mtb.__all__ if not hasattr(mtb, name)] == []


def test_every_documented_name_is_an_attribute() -> None:
    page = (Path(__file__).parents[2] / "docs" / "api.md").read_text(encoding="utf-8")
    names = sorted(set(re.findall(r"mtb_rs\.([A-Za-z_.]+)\b", page)) | {"pictures.plot", "case.load_case"})
    assert len(names) > 50
    # each in a state of the package in which nothing else has been asked for
    script = (
        "import sys, mtb_rs\n"
        f"assert not [m for m in {HEAVY!r} if m in sys.modules]\n"
        "def look(name):\n    found = mtb_rs\n    for part in name.split('.'): found = getattr(found, part)\n"
        f"for name in {names!r}: look(name)\n"
    )
    subprocess.run([sys.executable, "-c", script], check=True)
