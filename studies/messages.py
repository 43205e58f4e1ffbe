# SPDX-License-Identifier: MIT OR Apache-2.0
"""All messages of the tests of bad input in one table: runs `tests/boundary`, writes `docs/messages.md`.

Each message once for the place in the package that gives it, as it reads with the input of a test.
"""

from __future__ import annotations

import argparse
import json
import os
import re
import subprocess
import sys
import tempfile
from collections import defaultdict
from pathlib import Path

ROOT = Path(__file__).parents[1]
#: Longest message in the table; a list of all names that would do is longer.
LONGEST = 500
HEAD = """# Messages

Every message that the tests of bad input meet, with the numbers of the test, so that they can be read in a
row. `studies/messages.py` writes this page from `tests/boundary`. Each message should say what is wrong,
where, and what would be accepted. Paths are shortened to `…`.
"""


def told_apart(message: str) -> str:
    """The message without what differs from one input to the next."""
    # quantities are refused in one sentence, whatever the argument
    message = re.sub(r"^\S+ is (.* candela: a quantity in )\S+,", r"\1", message)
    return re.sub(r"'[^']*'|\"[^\"]*\"|[-+]?\d[\d.,e+-]*|\[[^]]*\]|\([^)]*\)", "#", message)


def cleaned(message: str) -> str:
    """One line without the paths of this machine, fit for a table."""
    text = re.sub(r"(?:/[\w.+-]+)*/(?:pytest-of-[\w.+-]+|tmp[\w.+-]*)(?:/[\w.+-]+)*/?", "…/", message)
    text = text.replace(str(ROOT), "…")
    text = " ".join(text.split())
    if len(text) > LONGEST:
        text = text[:LONGEST] + "…"
    return re.sub(r"([\\|<>*_`$\[\]{}])", r"\\\1", text)


def page(lines: list[str]) -> str:
    """The page from what the tests kept."""
    rooms: dict[str, dict[tuple[str, str], str]] = defaultdict(dict)
    for line in sorted(lines):
        given = json.loads(line)
        text = cleaned(given["message"])
        rooms[given["place"]].setdefault((given["kind"], told_apart(text)), text)
    out = [HEAD]
    for place in sorted(rooms):
        out += [f"## `{place}`\n", "| kind | message |", "|---|---|"]
        out += [f"| {kind} | {text} |" for (kind, _), text in sorted(rooms[place].items())]
        out.append("")
    return "\n".join(out)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("-n", default="2", help="processes that run the tests")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        kept = Path(folder) / "messages.jsonl"
        environment = {**os.environ, "MTB_RS_MESSAGES": str(kept)}
        command = [sys.executable, "-m", "pytest", "-m", "not slow", "-n", options.n, "tests/boundary"]
        subprocess.run(command, cwd=ROOT, env=environment, check=False)
        lines = sorted(set(kept.read_text(encoding="utf-8").splitlines()))
    (ROOT / "docs" / "messages.md").write_text(page(lines), encoding="utf-8")
    print(f"{len(lines)} messages in docs/messages.md")


if __name__ == "__main__":
    main()
