# SPDX-License-Identifier: MIT OR Apache-2.0
"""A pull on both bodies moves the lower one, in every model and by every way to solve it."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import mtb_rs as mtb
from mtb_rs.contact.estimate import GridField, difference


def block(**arguments: Any) -> mtb.Scene:
    given = {"height": 0.02, "friction": 0.1, "supports": "driven-top", "spacing": 0.0125}
    return mtb.scenes.block_on_plane(**{**given, "attraction": "both", **arguments})


def test_the_displacement_aimed_at_is_that_of_the_fuller_model() -> None:
    chosen, full = block().solve(quantity="displacement", tolerance=0.3), block().solve("elastic-upper")
    assert chosen.model == full.model
    assert chosen.report.error_estimates["displacement"] < 0.3
    u, v = chosen.displacement.lower[2], full.displacement.lower[2]
    np.testing.assert_allclose(u, v, rtol=0, atol=1e-9 * np.abs(v).max())


def test_a_half_space_is_moved_by_what_pulls_it() -> None:
    """Contact and pull cancel in the resultant, so that far points rest and near ones hardly move."""
    scene = block(friction=0.0, spacing=0.005)
    pulled, rested = scene.solve("half-space"), scene.with_(attraction="upper").solve("half-space")
    assert np.abs(pulled.displacement.lower).max() < 0.5 * np.abs(rested.displacement.lower).max()
    # the gap is what both surfaces leave: where there is contact both have moved by the same but the approach
    apart = (pulled.displacement.upper - pulled.displacement.lower)[2] - pulled.approach
    np.testing.assert_allclose(apart, pulled.gap, rtol=0, atol=1e-9 * abs(pulled.approach))


@pytest.mark.parametrize("way", ["convolutions", "increments", "a step"])
def test_all_ways_to_solve_half_spaces_agree(way: str, monkeypatch: pytest.MonkeyPatch) -> None:
    scene = block(friction=0.0)
    plain = scene.solve("half-space")
    if way == "a step":
        step = scene.prepare("half-space").step(velocity=(1.0, 0.0))
        np.testing.assert_allclose(
            step.pressure, plain.pressure.ravel(), rtol=0, atol=1e-8 * plain.pressure.max()
        )
        return
    if way == "convolutions":
        monkeypatch.setattr("mtb_rs.scenes.direct.DENSE_POINTS", 10)
        other = scene.solve("half-space")
        assert other.report.solver != plain.report.solver
    else:
        other = scene.solve("half-space", method="incremental")
    rough = 1e-7 if way == "convolutions" else 1e-3
    np.testing.assert_allclose(other.pressure, plain.pressure, rtol=0, atol=rough * plain.pressure.max())
    u, v = other.displacement.lower, plain.displacement.lower
    np.testing.assert_allclose(u, v, rtol=0, atol=rough * np.abs(plain.displacement.upper).max())


@pytest.mark.parametrize("quantity", ["pressure", "force", "displacement"])
def test_estimates_of_what_was_not_aimed_at_hold(quantity: str) -> None:
    result = block().solve(quantity=quantity, tolerance=0.3)
    truth = block(spacing=0.0125 / 3).solve("elastic-upper")
    nodes, fine = ([(p, *p.axes()) for p in r.patches] for r in (result, truth))
    rough, exact = (r.displacement.lower[2].ravel() for r in (result, truth))
    hats = None if result.model == "half-space" else rough
    apart = difference(GridField(fine, exact, exact), GridField(nodes, rough, hats), skip_border=True)
    assert apart is not None
    assert apart <= 2.0 * result.report.error_estimates.get("displacement", np.inf)
