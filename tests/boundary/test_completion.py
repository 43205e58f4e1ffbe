# SPDX-License-Identifier: MIT OR Apache-2.0
"""A shell that asks what may follow is told commands, options and their words."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from mtb_rs.commands import main
from mtb_rs.commands.completion import SHELLS
from mtb_rs.commands.start import CASES

ASK = "import sys; from mtb_rs.commands import main; sys.argv[0] = 'mtb-rs'; main()"


def completed(line: str, tmp_path: Path) -> set[str]:
    """What a shell is told that asks for the end of a line."""
    answer = tmp_path / "answer"
    environment = {
        **os.environ,
        "_ARGCOMPLETE": "1",
        "_ARGCOMPLETE_STDOUT_FILENAME": str(answer),
        "_ARGCOMPLETE_IFS": "\n",
        "_ARGCOMPLETE_SUPPRESS_SPACE": "1",
        "COMP_LINE": line,
        "COMP_POINT": str(len(line)),
    }
    subprocess.run([sys.executable, "-c", ASK], env=environment, check=True, cwd=tmp_path, timeout=60)
    return {word.strip() for word in answer.read_text(encoding="utf-8").split("\n")}


@pytest.mark.slow
def test_commands_options_and_words_are_completed(tmp_path: Path) -> None:
    assert {"run", "check", "show", "chart", "sweep", "demo", "init", "schema"} <= completed(
        "mtb-rs ", tmp_path
    )
    assert completed("mtb-rs init ", tmp_path) >= set(CASES)
    assert "--quantity" in completed("mtb-rs chart case.toml --q", tmp_path)
    assert {"pressure", "force"} <= completed("mtb-rs chart case.toml --quantity ", tmp_path)
    assert completed("mtb-rs show out --kind ", tmp_path) == {"map", "line", "3d"}
    assert {"pressure", "von_mises", "slip_share"} <= completed("mtb-rs show out --quantity ", tmp_path)
    (tmp_path / "wheel.toml").write_text('scene = "wheel_on_rail"\n[rolling]\n', encoding="utf-8")
    keys = completed("mtb-rs sweep wheel.toml --vary ", tmp_path)
    assert {"friction=", "rolling.velocity="} <= keys
    assert "height=" not in keys
    (tmp_path / "shoe.toml").touch()
    assert completed("mtb-rs run sh", tmp_path) == {"shoe.toml"}
    assert completed("mtb-rs check sh", tmp_path) == {"shoe.toml"}


@pytest.mark.parametrize("shell", SHELLS)
def test_scripts_for_shells_name_the_command(shell: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["completion", shell]) == 0
    script = capsys.readouterr().out
    assert "mtb-rs" in script
    program = shutil.which(shell)
    if program is not None and shell in ("bash", "zsh", "fish"):
        # its grammar, as far as the shell is here
        subprocess.run([program, "-n", "/dev/stdin"], input=script, text=True, check=True)
