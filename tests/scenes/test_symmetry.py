# SPDX-License-Identifier: MIT OR Apache-2.0
"""Scenes that are their own mirror image are solved as their half, the others are not."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import mtb_rs as mtb
from mtb_rs.bodies.mesh import block_mesh
from mtb_rs.contact import solve
from mtb_rs.contact.symmetry import mirror_symmetry

BUILD = {"shoe": mtb.scenes.pole_shoe_on_rail, "paraboloid": mtb.scenes.paraboloid_on_plane}


@pytest.mark.coarse
@pytest.mark.parametrize(
    ("kind", "model", "arguments"),
    [
        ("paraboloid", "half-space", {"points": 15, "lower": mtb.Material(7e10, 0.33)}),
        ("paraboloid", "half-space", {"points": 16, "sliding_direction": (-1.0, 0.0)}),
        ("shoe", "half-space", {"spacing": 6e-3}),
        ("shoe", "elastic-upper", {"spacing": 6e-3}),
        ("shoe", "elastic-upper", {"spacing": 6e-3, "supports": "points", "friction": 0.1}),
        ("shoe", "elastic-upper", {"spacing": 6e-3, "magnetic_pressure": (2e6, 2e6)}),
    ],
)
def test_the_half_gives_the_numbers_of_the_whole(
    kind: str, model: str, arguments: dict[str, Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    scene = BUILD[kind](**arguments)
    half = scene.solve(model)
    assert "mirror half" in half.report.solver
    monkeypatch.setattr(solve, "mirror_symmetry", lambda problem: None)
    whole = scene.solve(model)
    assert "mirror half" not in whole.report.solver
    size = float(np.abs(whole.points).max())
    scales = {
        "pressure": whole.pressure.max(),
        "traction": whole.pressure.max(),
        "gap": np.abs(whole.displacement.upper).max(),
        "force": whole.normal_force,
        "moment": whole.normal_force * size,
    }
    for name, scale in scales.items():
        assert np.abs(getattr(half, name) - getattr(whole, name)).max() < 1e-9 * scale, name


@pytest.mark.parametrize(
    ("kind", "model", "arguments"),
    [
        ("paraboloid", "half-space", {"sliding_direction": (1.0, 0.3)}),
        ("paraboloid", "half-space", {"sliding_direction": (0.0, 1.0)}),
        ("paraboloid", "half-space", {"friction": lambda x, y: 0.2 + 0.1 * (y > 0)}),
        ("shoe", "half-space", {"spacing": 6e-3, "magnetic_pressure": (3e6, 2e6)}),
        ("shoe", "half-space", {"spacing": 6e-3, "poles": 1}),
        ("shoe", "half-space", {"spacing": 6e-3, "lateral": 1e-3}),
        ("shoe", "half-space", {"spacing": 6e-3, "yaw": 1e-3}),
        ("shoe", "elastic-upper", {"spacing": 6e-3, "sliding_direction": (1.0, 0.2)}),
    ],
)
def test_what_is_not_symmetric_is_not_halved(kind: str, model: str, arguments: dict[str, Any]) -> None:
    assert mirror_symmetry(BUILD[kind](**arguments).problem(model)) is None


@pytest.mark.coarse
@pytest.mark.parametrize("side", ["left", "right"])
def test_a_body_held_on_one_side_is_not_halved(side: str) -> None:
    """Points, gap and prescribed motion are symmetric; the body is not."""
    line = np.linspace(-0.05, 0.05, 6)
    body = mtb.ElasticBody(
        block_mesh(line, line, 0.1), mtb.steel, "contact", [mtb.Support(side, x=0, y=0, z=0)]
    )
    scene = mtb.Scene(upper=body, lower=mtb.steel, spacing=0.02, friction=0.2, approach=1e-6)
    pressure = scene.solve().pressure
    held, free = (pressure[-1], pressure[0]) if side == "left" else (pressure[0], pressure[-1])
    assert held.sum() > 2.0 * free.sum()


@pytest.mark.coarse
# such a friction is asked about
@pytest.mark.filterwarnings("ignore::UserWarning")
@pytest.mark.parametrize("friction", [0.2, 2.7, 2.83, 2.9])
def test_the_half_tells_the_wedging_of_the_whole(friction: float) -> None:
    # the poles wedge in turn first, which is a state that the mirror turns around
    arguments: dict[str, Any] = {"spacing": 9e-3, "friction": friction, "supports": "clamped-top"}
    half = mtb.scenes.pole_shoe_on_rail(**arguments)
    whole = half.with_(sliding_direction=(1.0, 1e-9))
    if friction == 2.9:
        said = []
        for scene in (half, whole):
            with pytest.raises(mtb.ConvergenceError, match="wedges") as refusal:
                scene.solve("elastic-upper")
            said.append(str(refusal.value))
        assert said[0] == said[1]
        return
    one, other = half.solve("elastic-upper"), whole.solve("elastic-upper")
    assert one.report.wedging_margin == pytest.approx(other.report.wedging_margin, rel=1e-8)
    assert one.report.status == other.report.status
    assert one.pressure == pytest.approx(other.pressure, rel=1e-6, abs=1e-6 * other.pressure.max())
    step = half.prepare("elastic-upper").step(velocity=1.0)
    assert step.margin().wedging == pytest.approx(one.report.wedging_margin, rel=1e-6)


@pytest.mark.coarse
def test_a_body_condensed_as_its_half_says_what_its_margin_leaves_out() -> None:
    scene = mtb.scenes.pole_shoe_on_rail(spacing=9e-3, friction=2.0, supports="clamped-top")
    assert any("mirror images" in note for note in scene.solve("elastic-both").report.notes)
    assert not scene.with_(friction=0.2).solve("elastic-both").report.notes
