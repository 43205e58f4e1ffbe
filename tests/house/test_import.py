# SPDX-License-Identifier: MIT OR Apache-2.0
"""The bare package is light: no plotting, meshing or scientific library comes with the import."""

from __future__ import annotations

import subprocess
import sys

import mtb_rs as mtb

HEAVY = ("matplotlib", "pyvista", "vtkmodules", "vtk", "scipy", "gmsh", "meshio", "pint", "pandas", "xarray")


def test_import_pulls_nothing_heavy() -> None:
    script = f"import sys, mtb_rs; print([m for m in {HEAVY!r} if m in sys.modules])"
    run = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
    assert run.stdout.strip() == "[]"


def test_every_public_name_exists_once() -> None:
    assert len(set(mtb.__all__)) == len(mtb.__all__)
    assert [name for name in mtb.__all__ if not hasattr(mtb, name)] == []
