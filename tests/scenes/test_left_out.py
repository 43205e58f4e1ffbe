# SPDX-License-Identifier: MIT OR Apache-2.0
"""``model="auto"`` leaves out what changes too little, says by how much, and keeps what matters."""

from __future__ import annotations

import importlib
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import mtb_rs as mtb
from mtb_rs.bodies.mesh import block_mesh

pytestmark = [
    pytest.mark.filterwarnings("ignore::mtb_rs.ToleranceWarning"),
    pytest.mark.filterwarnings("ignore::UserWarning"),
]

BLOCK = mtb.scenes.block_on_plane(spacing=0.02, friction=0.2)
CELLS, SIDE, RADIUS = 25, 30e-3, 2.0
X = (np.arange(CELLS) - CELLS // 2) * SIDE / CELLS
BALL = mtb.Scene(
    mtb.steel, mtb.steel, gap=np.add.outer(X**2, X**2) / (2.0 * RADIUS), spacing=SIDE / CELLS, force=2e3
)


def pad(**given: Any) -> mtb.Scene:
    mesh = block_mesh(np.linspace(-0.04, 0.04, 9), np.linspace(-0.02, 0.02, 5), 0.03)
    body = mtb.ElasticBody(mesh, mtb.steel, "bottom", [mtb.Support("top", x=0, y=0)], "pad")
    return mtb.Scene(body, mtb.steel, spacing=1e-2, friction=0.2, **given)


def relative(one: mtb.Result, other: mtb.Result) -> float:
    p, q = (np.asarray(r.pressure) for r in (one, other))
    return float(np.linalg.norm(p - q) / np.linalg.norm(q))


@pytest.mark.parametrize(
    ("scene", "thin", "thick"), [(BLOCK, 1e-15, 1e-12), (BALL, 1e-15, 1e-12), (pad(force=2e4), 1e-15, 1e-11)]
)
def test_a_layer_is_left_out_while_it_changes_little(scene: mtb.Scene, thin: float, thick: float) -> None:
    for flexibility, is_left in ((thin, True), (thick, False)):
        with_layer = scene.with_(normal_layer=flexibility)
        found = with_layer.solve()
        kept = with_layer.solve(model=found.report.model)
        assert not kept.report.notes
        if not is_left:
            np.testing.assert_array_equal(found.pressure, kept.pressure)
            assert "layer between the bodies" not in found.report.omitted
            continue
        bare = scene.solve(model=found.report.model)
        np.testing.assert_allclose(found.pressure, bare.pressure, rtol=1e-12)
        said = found.report.omitted["layer between the bodies"]
        true = relative(bare, kept)
        assert 0.0 < true < 0.05
        # of wider cells: what is said is the size, not its digits
        assert true / 3.0 < said < 3.0 * true
        assert any("normal_layer was left out" in note for note in found.report.notes)
        assert found.summary["normal_layer"] == flexibility


@pytest.mark.parametrize("layer", [1e-15, 5e-15, 5e-14])
@pytest.mark.parametrize("height", [0.03, 0.1])
def test_a_layer_counts_at_sharp_edges_too(height: float, layer: float) -> None:
    """It gives way most there: a block whose border takes ten times the change of its middle."""
    scene = mtb.scenes.block_on_plane(
        friction=0.2, height=height, spacing=10e-3, magnetic_pressure=1e6, normal_layer=layer
    )
    found = scene.solve(tolerance=0.05)
    kept = scene.solve(model=found.report.model)
    true, said = relative(found, kept), found.report.omitted.get("layer between the bodies", 0.0)
    assert true <= 0.05
    # on cells twice as wide a layer changes the mean over a cell at the edge by at least half as much
    assert true <= 2.0 * said
    assert abs(found.force[2] / kept.force[2] - 1.0) <= 0.05


def test_the_tolerance_and_the_quantity_decide() -> None:
    scene = BALL.with_(normal_layer=3e-15)
    size = scene.solve(tolerance=0.5).report.omitted["layer between the bodies"]
    for tolerance, is_left in ((1.3 * size, True), (0.9 * size, False)):
        assert ("layer between the bodies" in scene.solve(tolerance=tolerance).report.omitted) == is_left
    # the force is given, and no layer changes it
    assert scene.solve(tolerance=1e-6, quantity="force").report.omitted["layer between the bodies"] < 1e-9
    assert (
        "layer between the bodies" not in scene.solve(tolerance=1e-6, quantity="displacement").report.omitted
    )


def test_a_rough_layer_is_judged_as_well() -> None:
    for length, is_left in ((1e-10, True), (2e-7, False)):
        scene = BALL.with_(normal_layer=mtb.RoughLayer.exponential(1e10, length))
        found = scene.solve()
        assert ("layer between the bodies" in found.report.omitted) == is_left


@pytest.mark.parametrize("scene", [BLOCK, BALL, pad(force=2e4)])
def test_a_hardness_that_nothing_reaches_changes_nothing(scene: mtb.Scene) -> None:
    bare = scene.solve()
    peak = float(np.asarray(bare.coefficients)[2].max())
    high = scene.with_(hardness=1.001 * peak).solve()
    assert high.report.omitted["hardness"] == 0.0
    np.testing.assert_allclose(high.pressure, bare.pressure, rtol=1e-12)
    assert high.plastic_indentation is not None
    assert not high.plastic_indentation.any()
    assert high.summary["hardness"] == pytest.approx(1.001 * peak)
    # wider cells may not see it reached: the solve itself does
    low = scene.with_(hardness=0.97 * peak).solve()
    assert "hardness" not in low.report.omitted
    assert float(np.asarray(low.coefficients)[2].max()) <= 0.97 * peak * (1.0 + 1e-9)


def test_a_magnet_is_held_where_no_gap_opens() -> None:
    magnet = mtb.Magnet(2500.0, 1e-3)
    closed = pad(magnetic_pressure=magnet)
    found, kept = closed.solve(), closed.solve(model="elastic-upper")
    assert "pull that follows the gap" in found.report.omitted
    np.testing.assert_allclose(found.pressure, kept.pressure, rtol=1e-6)
    for name in ("attraction", "flux"):
        assert found.report.magnet[name] == pytest.approx(kept.report.magnet[name], rel=1e-6)
    with pytest.raises(ValueError, match=r"left it out, as changing too little"):
        found.derivative("force", "magnetic_pressure")
    # a roof of a gap, which no tilt closes: the pull at its ends is a fraction
    roof = pad(magnetic_pressure=magnet, gap=lambda x, y: 2e-3 * np.abs(x) / 0.04)
    assert "pull that follows the gap" not in roof.solve().report.omitted


def test_what_was_left_out_has_no_derivative_and_says_why() -> None:
    found = BALL.with_(normal_layer=1e-16).solve()
    for by in ("normal_layer", "normal_layer_field"):
        with pytest.raises(ValueError, match=f"by is '{by}': model='auto' left it out"):
            found.derivative("force", by)


def test_steps_and_sweeps_keep_everything() -> None:
    scene = BLOCK.with_(normal_layer=1e-14)
    step = scene.prepare().step(velocity=1.0)
    bare = BLOCK.prepare().step(velocity=1.0)
    assert np.abs(step.pressure - bare.pressure).max() > 1e-6 * bare.pressure.max()
    table = mtb.sweep(BLOCK, {"normal_layer": [1e-16, 1e-12]})
    peaks = [row["peak_pressure"] for row in table.rows()]
    for flexibility, peak in zip((1e-16, 1e-12), peaks, strict=True):
        alone = BLOCK.with_(normal_layer=flexibility).solve(model="elastic-upper")
        assert peak == pytest.approx(alone.report.peak_pressure, rel=1e-9)


@pytest.mark.parametrize("kind", ["given gap", "block", "pole shoe", "wheel", "own body"])
def test_a_sample_of_random_scenes_keeps_its_tolerance(kind: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """A sample of studies/left_out.py: the truth is the scene with and without, on its own cells."""
    monkeypatch.syspath_prepend(str(Path(__file__).parents[2] / "studies"))
    study = importlib.import_module("left_out")
    found = [f for f in (study.found(kind, seed) for seed in range(1000, 1006)) if f is not None]
    assert found
    for one in found:
        if one.is_left_out:
            assert one.truth <= one.tolerance
            assert one.truth < study.LEAST or 1 / 3 < one.truth / one.estimate < 3
