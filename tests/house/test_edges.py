# SPDX-License-Identifier: MIT OR Apache-2.0
"""The house keeps its order: allowed edges between crates, references that resolve, drawing in its place."""

from __future__ import annotations

import re
import tomllib
from pathlib import Path

ROOT = Path(__file__).parents[2]
ALLOWED = {
    "words": set(),
    "geometry": {"words"},
    "operator": {"words"},
    "complementarity": {"words", "operator"},
    "elasticity": {"words", "operator", "heat"},
    "heat": {"words"},
    "contact": {"words", "operator", "heat", "complementarity"},
    "wheelset": {"words", "geometry", "operator", "complementarity", "elasticity", "heat", "contact"},
    "capi": {"operator", "complementarity", "contact", "wheelset"},
    "fmu": {"words", "operator", "contact", "wheelset"},
    "mtb": {"words", "geometry", "operator", "complementarity", "elasticity", "heat", "contact", "wheelset"},
    "python": {"geometry", "operator", "complementarity", "elasticity", "heat", "contact", "wheelset"},
}
#: [Author1985], [Author1985, eq. 1], [AuthorOther1985; Another1990], [EN13715]
KEY = re.compile(r"[A-Z][A-Za-z]+(?:19|20)\d\d[a-z]?|EN\d+(?:-\d+)?")
BRACKET = re.compile(r"\[((?:[A-Z][A-Za-z]+(?:19|20)\d\d|EN\d{4,})[^\]]*)\]")


def sources() -> list[Path]:
    places = [("rust", "*.rs"), ("rust", "*.md"), ("python", "*.py"), ("tests", "*.py"), ("examples", "*")]
    return [path for place, kind in places for path in (ROOT / place).rglob(kind) if path.is_file()]


def test_edges_between_crates() -> None:
    crates = {path.parent.name: tomllib.loads(path.read_text()) for path in ROOT.glob("rust/*/Cargo.toml")}
    assert set(crates) == set(ALLOWED)
    for name, manifest in crates.items():
        used = {
            key.removeprefix("mtb-") for key in manifest.get("dependencies", {}) if key.startswith("mtb-")
        }
        assert used == ALLOWED[name], name


def test_pages_tell_the_edges_as_they_are() -> None:
    for page in ("docs/house.md", "docs/crates.md"):
        text = (ROOT / page).read_text(encoding="utf-8")
        told = {
            name: set(re.findall(r"`(\w+)`", words))
            for name, words in re.findall(r"`(\w+)` uses ((?:`\w+`|,| |and)+)[;.]", text)
        }
        assert told == {name: used for name, used in ALLOWED.items() if used}, page
        none = re.search(
            r"((?:`\w+`|,| |and)+) uses? no other crate, and none uses ((?:`\w+`|,| |or)+)\.", text
        )
        assert none is not None, page
        without, unused = (set(re.findall(r"`(\w+)`", part)) for part in none.groups())
        assert without == {name for name, used in ALLOWED.items() if not used}, page
        assert unused == set(ALLOWED) - set().union(*ALLOWED.values()), page


def test_maps_name_every_crate_once() -> None:
    crates = sorted(path.parent.name for path in ROOT.glob("rust/*/Cargo.toml"))
    house = (ROOT / "docs" / "house.md").read_text(encoding="utf-8")
    assert sorted(re.findall(r"^rust/(\w+) ", house, re.MULTILINE)) == crates
    page = (ROOT / "docs" / "crates.md").read_text(encoding="utf-8")
    assert sorted(re.findall(r"^\| (?:\[)?`(?:mtb-)?(\w+)`", page, re.MULTILINE)) == crates


def test_every_reference_resolves() -> None:
    page = (ROOT / "docs" / "references.md").read_text(encoding="utf-8")
    listed = re.findall(r"^- \[([^\]]+)\]", page, flags=re.MULTILINE)
    assert listed == sorted(listed, key=str.casefold)
    unknown = {}
    for path in sources():
        if path == Path(__file__):
            continue
        for bracket in BRACKET.findall(path.read_text(encoding="utf-8")):
            for key in KEY.findall(bracket):
                if key not in listed:
                    unknown[key] = str(path.relative_to(ROOT))
    assert unknown == {}


def test_links_of_the_readme_lead_to_files() -> None:
    """They are absolute, so that the README reads alike on the index; what they name is here."""
    text = (ROOT / "README.md").read_text(encoding="utf-8")
    links = re.findall(r"\]\(([^)]+)\)", text)
    assert links
    for link in links:
        at = re.fullmatch(
            r"https://(?:github\.com/mtb-rs/mtb-rs/blob|raw\.githubusercontent\.com/mtb-rs/mtb-rs)/main/(.+)",
            link,
        )
        assert at is not None or link.startswith("https://"), link
        page, _, heading = at[1].partition("#") if at else ("README.md", "", "")
        assert (ROOT / page).is_file(), link
        if heading:
            text_there = (ROOT / page).read_text(encoding="utf-8")
            headings = re.findall(r"^#+ (.+)$", text_there, re.MULTILINE)
            assert heading in [re.sub(r"[^\w -]", "", h).lower().replace(" ", "-") for h in headings], link
    # pictures are shown, not linked to
    assert all("raw.githubusercontent" in link for link in re.findall(r"!\[[^]]*\]\(([^)]+)\)", text))
