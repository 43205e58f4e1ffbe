# SPDX-License-Identifier: MIT OR Apache-2.0
"""The pole shoe of the Rust example is that of Python: mesh, supports, condensation, contact."""

from __future__ import annotations

import os
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest

import mtb_rs as mtb

ROOT = Path(__file__).parents[2]


@pytest.mark.coarse
@pytest.mark.parametrize("rail", ["half-space", "elastic"])
def test_the_pole_shoe_in_rust_is_that_of_python(rail: str) -> None:
    if shutil.which("cargo") is None:
        pytest.skip("cargo is not installed: the example cannot be built")
    packages = os.environ.get("CARGO_PACKAGES", "-p mtb").split()
    build = ["cargo", "build", "--release", "--locked", "--quiet", *packages, "--example", "pole_shoe"]
    subprocess.run(build, cwd=ROOT, check=True)
    example = Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target")) / "release" / "examples" / "pole_shoe"
    command = [example, "6", rail]
    told = subprocess.run(command, cwd=ROOT, check=True, capture_output=True, text=True).stdout.splitlines()
    rows = np.array([line.split() for line in told[2:]], dtype=float)
    assert rows[:, 0].tolist() == [0.0, 0.25, 0.5]
    for friction, *found in rows.tolist():
        scene = mtb.scenes.pole_shoe_on_rail(spacing=6e-3, friction=friction)
        # the rail of Python is the half of a symmetric one, that of Rust the whole
        result = scene.solve("elastic-both" if rail == "elastic" else "elastic-upper")
        assert told[0] == f"{result.pressure.size} contact points"
        expected = [result.force[0], result.force[2], 1e-6 * result.pressure.max()]
        np.testing.assert_allclose(found, expected, rtol=1e-9, atol=1e-6)
