# SPDX-License-Identifier: MIT OR Apache-2.0
"""A sample of studies/derivatives.py: random scenes of each kind, every number by every input."""

import importlib
from pathlib import Path
from typing import Any

import pytest

#: Of several results, which have names of their own.
CHAINS = "chains of wheels"
#: With elastic bodies, whose scenes are condensed anew at each change of a material.
SLOW = ("sliding elastic bodies", "ready scenes")
QUICK = (
    *("sliding half-spaces", "steps", "wheels", "normal", "shift"),
    *("magnets", "rough layers", "steps that stick"),
    *("layers that yield", "inclined contacts"),
)
KINDS = (
    *QUICK,
    *(
        "steady rolling",
        "transient rolling",
        "shift, coupled",
        "steady rolling, coupled",
        "transient wheels",
        "points that flow",
        CHAINS,
        "pressed prisms",
        "rolling on prisms",
        "heated rolling",
        "bodies that creep",
        "layered bodies",
        "layered scenes",
        "heated wheels",
    ),
)


@pytest.fixture
def study(monkeypatch: pytest.MonkeyPatch) -> Any:
    monkeypatch.syspath_prepend(str(Path(__file__).parents[2] / "studies"))
    return importlib.import_module("derivatives")


pytestmark = [
    pytest.mark.filterwarnings("ignore::mtb_rs.ToleranceWarning"),
    pytest.mark.filterwarnings("ignore::UserWarning"),
]


def test_all_kinds_are_here(study: Any) -> None:
    assert {*KINDS, *SLOW} == set(study.KINDS)


@pytest.mark.parametrize("kind", KINDS)
def test_derivatives_are_differences(study: Any, kind: str) -> None:
    found = [f for seed in ((1001, 1002) if kind in QUICK else (1001,)) for f in study.tried(kind, seed)]
    compared = [f for f in found if f.error is not None]
    assert len(compared) > 0.3 * len(found)
    assert [f for f in compared if f.error > study.ACCEPTED] == []


@pytest.mark.parametrize("kind", [*(kind for kind in KINDS if kind != CHAINS), "sliding elastic bodies"])
def test_every_name_is_answered_or_refused_by_a_sentence(study: Any, kind: str) -> None:
    assert study.riddles(kind, 1001) == []
