# SPDX-License-Identifier: MIT OR Apache-2.0
"""A pull on both bodies moves the lower one, in every model and by every way to solve it."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import mtb_rs as mtb
from mtb_rs.bodies.mesh import block_mesh
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


def pulled_pair(*, turned: bool, crown: float, friction: float = 0.1) -> mtb.Scene:
    """A crowned body with a level top on a half-space, both pulled; turned over, the half-space lies above.

    What the one is given to rise by the other has as its approach: only the pull presses, on either of them.
    """
    x, y = np.linspace(-0.04, 0.05, 7), np.linspace(-0.03, 0.03, 5)
    mesh = block_mesh(x, y, 0.03)
    nodes = mesh.nodes.copy()
    nodes[:, 2] += crown * (nodes[:, 0] ** 2 + 2.0 * nodes[:, 1] ** 2) * (1.0 - nodes[:, 2] / 0.03)
    mesh = mtb.TetraMesh(nodes, mesh.cells, mesh.node_sets)
    if turned:
        mesh = mesh.moved(np.diag([1.0, -1.0, -1.0]))
    level: Any = 0.0 if turned else mtb.Guide(0.0)
    held = [mtb.Support("top", x=0.0, y=0.0, z=level)]
    pad = mtb.ElasticBody(mesh, mtb.Material(70e9, 0.33), "contact", held, "pad")
    bodies = (mtb.steel, pad) if turned else (pad, mtb.steel)
    sign = -1.0 if turned else 1.0
    return mtb.Scene(
        *bodies,
        spacing=0.015,
        friction=friction,
        sliding_direction=(sign, 0.5),
        magnetic_pressure=lambda x, y: 3e6 * (1.0 + 4.0 * x - 3.0 * sign * y),
        attraction="both",
    )


@pytest.mark.filterwarnings("ignore::mtb_rs.ToleranceWarning")
@pytest.mark.parametrize("crown", [0.0, 1e-4])
@pytest.mark.parametrize("way", ["solve", "step", "sweep", "file"])
def test_bodies_that_change_places_are_pulled_alike(way: str, crown: float, tmp_path: Path) -> None:
    pair = [pulled_pair(turned=turned, crown=crown) for turned in (False, True)]
    # the row of nodes at y becomes that at -y
    own, image = (scene.solve().pressure for scene in pair)
    size = own.max()
    np.testing.assert_allclose(image[::-1], own, rtol=0, atol=1e-7 * size)
    if crown == 0.0:
        # contact gives each body its own pull back: nothing is strained
        even = pulled_pair(turned=True, crown=0.0, friction=0.0).with_(magnetic_pressure=3e6).solve()
        np.testing.assert_allclose(even.pressure, 3e6, rtol=1e-6)
    for scene, whole in zip(pair, (own, image), strict=True):
        if way == "sweep":
            table = mtb.sweep(scene, {"friction": [0.05, 0.1]})
            peak = float(np.ravel(table["peak_pressure"])[-1])
            assert peak == pytest.approx(float(whole.max()), rel=1e-9)
        elif way != "solve":
            prepared = scene.prepare()
            if way == "file":
                prepared.save(tmp_path / "pair.mtbc")
                prepared = mtb.PreparedContact.load(tmp_path / "pair.mtbc")
            step = prepared.step(velocity=scene.sliding_direction)
            np.testing.assert_allclose(step.pressure, whole.ravel(), rtol=0, atol=1e-8 * size)
