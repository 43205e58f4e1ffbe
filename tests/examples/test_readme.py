# SPDX-License-Identifier: MIT OR Apache-2.0
"""The README's example runs as it stands, and is short."""

from __future__ import annotations

import re
import warnings
from pathlib import Path
from typing import Any

import pytest

pytestmark = pytest.mark.slow  # runs the README in a process of its own

README = (Path(__file__).parents[2] / "README.md").read_text(encoding="utf-8")


def test_python_block(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (block,) = re.findall(r"```python\n(.*?)```", README, flags=re.DOTALL)
    assert len(block.splitlines()) <= 20
    monkeypatch.chdir(tmp_path)
    names: dict[str, Any] = {}
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # without a GL driver save() says so
        exec(compile(block, "README.md", "exec"), names)
    result = names["result"]
    # what the magnets pull, 3 MPa on the strips of both poles seen from above, arrives on the rail
    strip = 2 * 0.09 * (21.6e-3 - 6e-3)
    assert -result.force[2] == pytest.approx(3e6 * strip, rel=1e-3)
    assert all(path.exists() for path in names["files"])
    assert (tmp_path / "pressure.png").exists()
