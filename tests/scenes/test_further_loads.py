# SPDX-License-Identifier: MIT OR Apache-2.0
"""A further load on a body of one's own: its factorisation and condensation serve again."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
import pytest

import mtb_rs as mtb
from mtb_rs.base.cache import Memory
from mtb_rs.bodies.mesh import block_mesh

LINE = np.linspace(-0.02, 0.02, 6)
MESH = block_mesh(LINE, LINE, 0.02, halved=False, clamped=True)


def body(force: float = -5e3, **changed: Any) -> mtb.ElasticBody:
    held = mtb.Support("top", 0, 0, mtb.Guide(force))
    return mtb.ElasticBody(**{"mesh": MESH, "material": mtb.steel, "supports": [held], **changed})


def test_bodies_that_differ_by_their_load_share_their_factorisation() -> None:
    first = body()
    again = mtb.TetraMesh(np.array(MESH.nodes), np.array(MESH.cells), MESH.node_sets)
    for other in (body(-7e3), body(mesh=again), body(contact="bottom"), body(name="shoe")):
        assert other.core is first.core
    for other in (
        body(material=mtb.Material(2e11, 0.25)),
        body(mesh=MESH.moved(shift=(1e-3, 0, 0))),
        body(supports=[mtb.Support("top", 0, 0, 0.0)]),
        body(supports=[mtb.Support("rear", 0, 0, mtb.Guide(-5e3))]),
    ):
        assert other.core is not first.core


@pytest.mark.filterwarnings("ignore::mtb_rs.ToleranceWarning")
def test_a_further_load_gives_what_it_gives_alone() -> None:
    def solved(force: float) -> mtb.Result:
        return mtb.Scene(
            upper=body(force), lower=mtb.HalfSpace(mtb.steel), spacing=0.008, friction=0.2
        ).solve()

    alone = solved(-7e3)
    other = solved(-5e3)
    again = solved(-7e3)
    np.testing.assert_array_equal(again.pressure, alone.pressure)
    assert dict(again.report.error_estimates) == dict(alone.report.error_estimates)
    # linear: the same estimate under 5/7 of the load
    for quantity, value in alone.report.error_estimates.items():
        assert other.report.error_estimates[quantity] == pytest.approx(value, rel=1e-6)
    assert other.normal_force == pytest.approx(5e3, rel=1e-9)


def test_a_further_load_reads_no_matrix_again(monkeypatch: pytest.MonkeyPatch) -> None:
    """What a contact keeps is found by the objects it was made of, not by reading all their numbers."""
    scene = mtb.scenes.pole_shoe_on_rail(spacing=6e-3, friction=0.3)
    scene.solve("elastic-upper")
    read: list[int] = []
    recall = Memory.recall

    def counted(self: Memory, name: str, ingredients: Sequence[Any], build: Callable[[], Any]) -> Any:
        read.extend(part.size for part in ingredients if isinstance(part, np.ndarray))
        return recall(self, name, ingredients, build)

    monkeypatch.setattr(Memory, "recall", counted)
    again = scene.with_(magnetic_pressure=2.1e6).solve("elastic-upper")
    half = again.pressure.size // 2
    assert max(read) < half**2
