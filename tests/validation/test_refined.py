# SPDX-License-Identifier: MIT OR Apache-2.0
"""Bodies that are condensed onto fewer points than they touch in, against direct condensation."""

from typing import Any

import numpy as np
import pytest

import mtb_rs as mtb
from mtb_rs.base import cache
from mtb_rs.contact import refined


def solved(scene: mtb.Scene, model: Any, monkeypatch: pytest.MonkeyPatch, cells: int | None) -> mtb.Result:
    """The scene with bodies condensed onto lines of about so many cells; None: onto all contact points."""
    monkeypatch.setattr(refined, "DIRECT_MEMORY", float("inf") if cells is None else 0.0)
    monkeypatch.setattr(refined, "PRODUCTS_FROM", 0)
    monkeypatch.setattr(refined, "CELLS", cells or 1)
    with cache.memory_only():
        return scene.solve(model)


SCENES = {
    "shoe": (mtb.scenes.pole_shoe_on_rail(spacing=(4e-3, 1.8e-3)), "elastic-upper"),
    "shoe on its rail": (mtb.scenes.pole_shoe_on_rail(spacing=(4e-3, 1.8e-3)), "elastic-both"),
    "clamped block that rubs": (mtb.scenes.block_on_plane(spacing=5e-3, friction=0.5), "elastic-upper"),
    "block on a rigid plane": (
        mtb.scenes.block_on_plane(spacing=5e-3, lower=mtb.Rigid(), friction=0.1),
        "elastic-upper",
    ),
}


@pytest.mark.slow
@pytest.mark.parametrize("name", SCENES)
@pytest.mark.coarse
def test_the_pressure_is_that_of_direct_condensation(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    scene, model = SCENES[name]
    direct = solved(scene, model, monkeypatch, None)
    result = solved(scene, model, monkeypatch, 60)
    lines = refined.lines_of(result.patches, refined.carrier_spacing(result.patches) or (0.0, 0.0))
    assert sum(len(x) * len(y) for x, y in lines) < 0.8 * result.pressure.size
    assert result.report.force_balance["relative_error"] < 1e-9
    assert result.normal_force == pytest.approx(direct.normal_force, rel=5e-3)
    found, expected = (r.patches[0].view(r.pressure.reshape(-1)) for r in (result, direct))
    error = np.abs(found - expected)
    mean = expected.mean()
    # in the mean over all points, at the border, and anywhere
    border = np.ones(expected.shape, dtype=bool)
    border[1:-1, 1:-1] = False
    assert error.mean() < 0.015 * mean
    assert error[border].mean() < 0.03 * expected[border].mean()
    assert error.max() < 0.1 * expected.max()


def test_lines_are_dense_at_free_edges_and_symmetric() -> None:
    for nodes in (2, 3, 7, 32, 181):
        for widest in (1.0, 2.0, 7.0, 60.0):
            for graded in (True, False):
                lines = refined._lines(nodes, widest, graded=graded)
                assert lines == [nodes - 1 - k for k in reversed(lines)]
                steps = np.diff(lines)
                assert lines[0] == 0
                assert (steps > 0).all()
                assert steps.max() <= max(round(widest), 1)
                near = np.minimum(lines[1:], nodes - 1 - np.array(lines[:-1]))
                assert not graded or (steps <= np.maximum(refined.GROWTH * near, 1)).all()
                kept = refined.elements(lines)
                assert kept == [nodes - 1 - k for k in reversed(kept)]
                assert set(kept) <= set(lines)


@pytest.mark.slow
@pytest.mark.coarse
@pytest.mark.parametrize("name", ["shoe on its rail", "clamped block that rubs"])
def test_derivatives_by_products_are_those_of_matrices(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    scene, model = SCENES[name]
    # along x two corners of the block share its peak to the last bit, and rounding chooses between them
    scene = scene.with_(sliding_direction=(1.0, 0.3)) if "block" in name else scene
    of: list[Any] = ["force", "moment", "peak_pressure"]

    def gradients() -> dict[str, Any]:
        with cache.memory_only():
            gradient = scene.solve(model).gradient(of)
            return {by: np.asarray(gradient[by]) for by in gradient if "ratio" not in by}

    monkeypatch.setattr(refined, "DIRECT_MEMORY", 0.0)
    monkeypatch.setattr(refined, "CELLS", 60)
    monkeypatch.setattr(refined, "PRODUCTS_FROM", 10**9)
    expected = gradients()
    monkeypatch.setattr(refined, "PRODUCTS_FROM", 0)
    found = gradients()
    assert list(found) == list(expected)
    for by, wanted in expected.items():
        size = np.abs(wanted).reshape(len(wanted), -1).max(axis=1)
        error = np.abs(found[by] - wanted).reshape(len(wanted), -1).max(axis=1)
        # forces and moments that are given, or zero by symmetry, are rounding
        assert error[-1] <= 1e-6 * size[-1], by
        assert np.all(error <= 1e-6 * np.maximum(size, size[:3].max())), by
