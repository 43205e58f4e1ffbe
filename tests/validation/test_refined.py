# SPDX-License-Identifier: MIT OR Apache-2.0
"""Bodies that are condensed onto fewer points than they touch in, against direct condensation."""

from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest

import mtb_rs as mtb
from mtb_rs.base import cache
from mtb_rs.contact import refined


@pytest.fixture(autouse=True)
def _forgotten() -> Iterator[None]:
    """What is condensed here is not for other tests."""
    yield
    cache.forget()


def afresh(scene: mtb.Scene, model: Any, **given: Any) -> mtb.Result:
    """The scene on bodies that are condensed anew: what is kept knows nothing of the number of lines."""
    with cache.memory_only():
        cache.forget()
        return scene.solve(model, **given)


def solved(scene: mtb.Scene, model: Any, monkeypatch: pytest.MonkeyPatch, cells: int | None) -> mtb.Result:
    """The scene with bodies condensed onto lines of about so many cells; None: onto all contact points."""
    monkeypatch.setattr(refined, "DIRECT_POINTS", 10**9 if cells is None else 0)
    monkeypatch.setattr(refined, "PRODUCTS_FROM", 0)
    monkeypatch.setattr(refined, "CELLS", cells or 1)
    return afresh(scene, model)


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
    result = solved(scene, model, monkeypatch, 20)
    # both bodies are other ones
    operations = result.report.operations["condensation"]
    assert 0.0 < operations < 0.8 * direct.report.operations["condensation"]
    assert result.report.force_balance["relative_error"] < 1e-9
    assert result.normal_force == pytest.approx(direct.normal_force, rel=5e-3)
    found, expected = (r.patches[0].view(r.pressure.reshape(-1)) for r in (result, direct))
    error = np.abs(found - expected)
    mean = expected.mean()
    # in the mean over all points, at the border, and anywhere
    border = np.ones(expected.shape, dtype=bool)
    border[1:-1, 1:-1] = False
    assert error.mean() < 0.01 * mean
    assert error[border].mean() < 0.015 * expected[border].mean()
    assert error.max() < 0.03 * expected.max()


def test_lines_are_dense_at_free_edges_and_symmetric() -> None:
    for nodes in (2, 3, 7, 32, 181):
        for widest in (1.0, 2.0, 7.0, 60.0):
            lines = refined._lines(nodes, widest)
            assert lines == [nodes - 1 - k for k in reversed(lines)]
            steps = np.diff(lines)
            assert lines[0] == 0
            assert (steps > 0).all()
            assert steps.max() <= max(round(widest), 1)
            near = np.minimum(lines[1:], nodes - 1 - np.array(lines[:-1]))
            assert (steps <= np.maximum(refined.GROWTH * near, 1)).all()


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
            cache.forget()
            gradient = scene.solve(model).gradient(of)
            return {by: np.asarray(gradient[by]) for by in gradient if "ratio" not in by}

    monkeypatch.setattr(refined, "DIRECT_POINTS", 0)
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


def inside(result: mtb.Result) -> Any:
    """The pressure away from the border, where it is compared."""
    return result.patches[0].view(result.pressure.reshape(-1))[1:-1, 1:-1]


def with_direct_copies(monkeypatch: pytest.MonkeyPatch, points: int) -> None:
    """Bodies under so many points are condensed onto fewer, and those under half of them onto all."""
    monkeypatch.setattr(refined, "DIRECT_POINTS", points // 2)
    monkeypatch.setattr(refined, "CELLS", 45)


@pytest.mark.slow
@pytest.mark.coarse
@pytest.mark.filterwarnings("ignore:The estimated error")
@pytest.mark.parametrize("supports", ["points", "fixed-points"])
def test_the_estimate_counts_supports_at_points(supports: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    scene = mtb.scenes.block_on_plane(0.04, 0.04, friction=0.3, spacing=1.6e-3, supports=supports)
    expected = inside(solved(scene, "elastic-upper", monkeypatch, None))
    with_direct_copies(monkeypatch, expected.size)
    result = afresh(scene, "elastic-upper", tolerance=0.02)
    truth = np.linalg.norm(inside(result) - expected) / np.linalg.norm(expected)
    estimate = result.report.error_estimates["pressure"]
    # the elements of the body on fewer points are wider at its supports, which are too stiff then
    assert truth > 0.005
    assert truth < 2.0 * estimate
    assert sum("held at points" in note for note in result.report.notes) == 1
    assert ("supports that are faces" in result.report.missed) == (estimate > 0.02)


@pytest.mark.coarse
@pytest.mark.filterwarnings("ignore:The estimated error")
@pytest.mark.parametrize("supports", ["points", "fixed-points"])
def test_supports_at_points_are_the_same_on_elements_of_one_size(
    supports: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    scene = mtb.scenes.block_on_plane(0.04, 0.04, friction=0.3, spacing=2e-3, supports=supports)
    scene = scene.with_(element_size=4e-3)
    expected = inside(solved(scene, "elastic-upper", monkeypatch, None))
    with_direct_copies(monkeypatch, expected.size)
    result = afresh(scene, "elastic-upper")
    assert np.linalg.norm(inside(result) - expected) < 0.01 * np.linalg.norm(expected)
    assert not any("held at points" in note for note in result.report.notes)
