# SPDX-License-Identifier: MIT OR Apache-2.0
"""Scripts that the tests do not run keep up with the package: names and calls that are no more show here."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

pytest.importorskip("mypy", reason="pip install 'mtb-rs[test]'")

ROOT = Path(__file__).parents[2]
#: The package is checked whole elsewhere; of scripts, what would end them at once.
ENDS_A_SCRIPT = ("[call-arg]", "[name-defined]", "[import-not-found]", "multiple values for keyword")
#: Of the extra `bench`.
NOT_INSTALLED = ("tamaas", "ContactMechanics", "SurfaceTopography", "pyfftw")


@pytest.fixture(scope="module")
def cache(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("mypy")


@pytest.mark.parametrize(
    "folder", ["studies", "benches", "examples", "examples/thesis", "examples/side_by_side"]
)
@pytest.mark.slow
def test_calls_fit(folder: str, cache: Path) -> None:
    scripts = sorted(str(path.relative_to(ROOT)) for path in (ROOT / folder).glob("*.py"))
    assert scripts
    run = subprocess.run(
        [sys.executable, "-m", "mypy", "--cache-dir", str(cache), "--allow-untyped-defs", *scripts],
        cwd=ROOT,
        env=os.environ | {"MYPYPATH": os.pathsep.join(["python", folder])},
        capture_output=True,
        text=True,
        check=False,
    )
    assert run.returncode in (0, 1), run.stderr
    told = [line for line in run.stdout.splitlines() if any(what in line for what in ENDS_A_SCRIPT)]
    assert [line for line in told if not any(name in line for name in NOT_INSTALLED)] == []
