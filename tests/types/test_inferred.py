# SPDX-License-Identifier: MIT OR Apache-2.0
"""What mypy infers of scenes and results, pyright infers as well: editors show it while one types."""

from __future__ import annotations

import importlib.util
import json
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]

pytestmark = pytest.mark.slow  # starts a type checker


@pytest.mark.skipif(importlib.util.find_spec("basedpyright") is None, reason="pip install 'mtb-rs[test]'")
def test_pyright_infers_the_same_types(tmp_path: Path) -> None:
    settings = tmp_path / "pyrightconfig.json"
    settings.write_text(
        json.dumps(
            {
                "include": [str(ROOT / "tests" / "types" / "inferred.py")],
                "extraPaths": [str(ROOT / "python")],
                "typeCheckingMode": "basic",
                "pythonVersion": "3.11",
            }
        ),
        encoding="utf-8",
    )
    command = [sys.executable, "-m", "basedpyright", "--pythonpath", sys.executable, "-p", str(settings)]
    done = subprocess.run([*command, "--outputjson"], capture_output=True, text=True, check=False)
    report = json.loads(done.stdout)
    assert report["summary"]["filesAnalyzed"] == 1
    found = [f"{d['range']['start']['line'] + 1}: {d['message']}" for d in report["generalDiagnostics"]]
    assert not found, "\n".join(found)
