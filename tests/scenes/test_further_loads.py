# SPDX-License-Identifier: MIT OR Apache-2.0
"""A further load on a body of one's own: its factorisation and condensation serve again."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import mtb_rs as mtb
from mtb_rs.base import cache, memory
from mtb_rs.base.cache import Memory
from mtb_rs.bodies.mesh import block_mesh
from mtb_rs.contact import elastic, standing

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


@pytest.mark.parametrize("spacing", [6e-3, 1.15e-3])
def test_another_friction_makes_no_contact_anew(spacing: float, monkeypatch: pytest.MonkeyPatch) -> None:
    """Neither on a coarse shoe nor on one of more than 2000 points, with the grids of its estimate."""
    scene = mtb.scenes.pole_shoe_on_rail(spacing=spacing, friction=0.3)
    cache.forget()
    first = scene.solve("half-space")
    assert (first.pressure.size > 2000) == (spacing < 2e-3)
    made: list[Any] = []
    real = standing.Contact

    def counted(*parts: Any, **named: Any) -> Any:
        made.append(real(*parts, **named))
        return made[-1]

    monkeypatch.setattr(elastic, "Contact", counted)
    core = scene.problem("half-space").core
    for changed in ({"friction": 0.2}, {"magnetic_pressure": 2e6}, {"velocity": 3.0}):
        other = scene.with_(**changed)
        other.solve("half-space")
        assert other.problem("half-space").core is core
    assert made == []
    cache.forget()
    scene.solve("half-space")
    assert made


class Heavy:
    def __init__(self, nbytes: float) -> None:
        self.nbytes = nbytes


@settings(max_examples=60, deadline=None)
@given(st.lists(st.floats(0.0, 4.0 * cache.OBJECTS_LIMIT), min_size=1, max_size=12))
def test_what_is_kept_is_bounded(sizes: list[float]) -> None:
    cache.forget()
    for k, size in enumerate(sizes):
        cache.recalled(str(k), lambda size=size: Heavy(size))  # type: ignore[misc]
        kept = [thing.nbytes for thing in cache._objects.values()]
        assert sum(kept) <= max(kept) + cache.OBJECTS_LIMIT
        assert kept[-1] == size
    assert cache.forget_objects()
    assert not cache.forget_objects()


def test_what_is_kept_goes_where_the_memory_is_needed(monkeypatch: pytest.MonkeyPatch) -> None:
    def free() -> float:
        return 2e9 - sum(thing.nbytes for thing in cache._objects.values())

    cache.forget()
    monkeypatch.setattr(memory, "available", free)
    cache.recalled("contact", lambda: Heavy(1.5e9))
    memory.refuse(0.4e9, "what fits beside it", "")
    assert cache._objects
    memory.refuse(1.8e9, "what does not fit beside it", "")
    assert not cache._objects
    with pytest.raises(ValueError, match=r"would take 2\.5 GB of memory; 2\.0 GB are free: take less"):
        memory.refuse(2.5e9, "what fits nowhere", "take less")
