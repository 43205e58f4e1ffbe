# SPDX-License-Identifier: MIT OR Apache-2.0
"""The libraries that programs in other languages load."""

import os
import shutil
import subprocess
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]


@pytest.fixture(scope="session")
def library() -> Path:
    """Folder of the libraries of the C interface and of the mock-up units."""
    if shutil.which("cargo") is None:
        pytest.skip("cargo is not installed: the libraries cannot be built")
    build = ["cargo", "build", "--release", "--locked", "--quiet", "-p", "mtb-capi", "-p", "mtb-fmu"]
    subprocess.run(build, cwd=ROOT, check=True)
    return Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target")) / "release"
