# SPDX-License-Identifier: MIT OR Apache-2.0
"""The libraries that programs in other languages load."""

import os
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest

import mtb_rs as mtb
from mtb_rs.bodies.mesh import block_mesh

ROOT = Path(__file__).parents[2]


@pytest.fixture(scope="session")
def library() -> Path:
    """Folder of the libraries of the C interface and of the mock-up units."""
    if shutil.which("cargo") is None:
        pytest.skip("cargo is not installed: the libraries cannot be built")
    packages = os.environ.get("CARGO_PACKAGES", "-p mtb-capi -p mtb-fmu").split()
    build = ["cargo", "build", "--release", "--locked", "--quiet", *packages]
    subprocess.run(build, cwd=ROOT, check=True)
    return Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target")) / "release"


@pytest.fixture(scope="session", params=["on a crown", "two bodies"])
def own_body(request: pytest.FixtureRequest) -> mtb.PreparedContact:
    """A prepared contact of bodies of one's own: a pad that rises and tilts."""
    line = np.linspace(-0.03, 0.03, 6)
    driven = [mtb.Support("top", x=0.0, y=0.0)]
    pad = mtb.ElasticBody(block_mesh(line, line, 0.02), mtb.steel, "contact", driven, "pad")
    if request.param == "two bodies":
        wide = np.linspace(-0.04, 0.04, 6)
        table = block_mesh(wide, wide, 0.03).moved(np.diag([1.0, -1.0, -1.0]))
        held = [mtb.Support("top", x=0.0, y=0.0, z=0.0)]
        aluminium = mtb.Material(70e9, 0.33)
        lower: mtb.ElasticBody | mtb.HalfSpace = mtb.ElasticBody(table, aluminium, "contact", held, "table")
    else:
        y = np.linspace(-0.05, 0.05, 41)
        lower = mtb.HalfSpace(mtb.steel, mtb.Profile.from_points(y, -(y**2) / 80.0))
    scene = mtb.Scene(
        pad,
        lower,
        spacing=10e-3,
        friction=mtb.VelocityTable((0.0, 10.0, 50.0), (0.2, 0.1, 0.05)),
        magnetic_pressure=mtb.VelocityTable((0.0, 60.0), (3e6, 1.5e6)),
        attraction="both",
    )
    return scene.prepare(reference_point=(0.0, 0.0, 0.02))
