# SPDX-License-Identifier: MIT OR Apache-2.0
"""From rest to sliding with a pressure that follows: where it ends, and where there is no end."""

from __future__ import annotations

import itertools
import re
from typing import Any

import numpy as np
import pytest

import mtb_rs as mtb


def along_x(distances: np.ndarray) -> np.ndarray:
    return np.outer(distances, [1.0, 0.0])


def block(height: float, friction: float) -> mtb.Scene:
    return mtb.scenes.block_on_plane(
        width=0.1, height=height, friction=friction, magnetic_pressure=3e6, spacing=10e-3
    )


SHOE = mtb.scenes.pole_shoe_on_rail(friction=0.5, spacing=6e-3)


@pytest.mark.coarse
@pytest.mark.parametrize(
    ("scene", "model"),
    [
        (block(0.1, 0.5), "elastic-upper"),
        (block(0.5, 0.2), "elastic-upper"),
        (SHOE, "elastic-upper"),
        (SHOE, "elastic-both"),
        (SHOE.with_(friction=[0.2, 0.5], attraction="both"), "elastic-both"),
    ],
    ids=["low block", "tall block", "pole shoe", "pole shoe on elastic rail", "two coefficients"],
)
@pytest.mark.slow
def test_the_start_ends_in_gross_sliding(scene: mtb.Scene, model: Any) -> None:
    start = scene.start_of_sliding(along_x(np.geomspace(1e-7, 20e-3, 16)), model=model)
    slides = scene.solve(model=model)
    assert start.slip_share[0] < 0.6
    assert start.slip_share[-1] == 1.0
    assert start.force[-1, 0] == pytest.approx(slides.force[0], rel=1e-5)
    assert start.normal_force[-1] == pytest.approx(slides.normal_force, rel=1e-5)
    peak = slides.pressure.max()
    np.testing.assert_allclose(start.pressure, slides.pressure.ravel(), atol=1e-4 * peak)


@pytest.mark.coarse
@pytest.mark.parametrize("scene", [SHOE, SHOE.with_(poles=1)], ids=["two poles", "one pole"])
def test_an_elastic_rail_softens_the_start_in_each_direction(scene: mtb.Scene) -> None:

    def stiffness(model: Any) -> np.ndarray:
        ways = [np.array([[0.0, 0.0], way]) for way in 1e-9 * np.eye(2)]
        forces = [scene.start_of_sliding(way, model=model).force for way in ways]
        # the pressure of one pole pushes aside already
        return np.array([force[1] - force[0] for force in forces]) / 1e-9

    soft, stiff = stiffness("elastic-both"), stiffness("elastic-upper")
    # sticking bodies are linear, and their stiffness is that of an energy
    np.testing.assert_allclose(soft, soft.T, rtol=0, atol=1e-6 * np.abs(soft).max())
    assert np.linalg.eigvalsh(soft).min() > 0.0
    assert np.linalg.eigvalsh(stiff - soft).min() > 0.0


def test_beyond_the_wedging_limit_a_body_jams() -> None:
    scene = block(0.5, 0.5)
    with pytest.raises(mtb.ConvergenceError, match="wedges"):
        scene.solve(model="elastic-upper")
    start = scene.start_of_sliding(along_x(np.linspace(20e-6, 400e-6, 16)), model="elastic-upper")
    # both forces grow in proportion to the way, the friction within its bound
    for force in (start.force[:, 0], start.normal_force):
        assert np.diff(force)[-8:] == pytest.approx(np.full(8, np.diff(force)[-1]), rel=0.1)
        assert np.diff(force)[-1] > 0.0
    assert np.all(start.force[:, 0] < 0.5 * start.normal_force)
    assert start.slip_share.max() < 0.6


def test_like_half_spaces_keep_their_pressure() -> None:
    scene = mtb.scenes.paraboloid_on_plane(friction=0.3, points=12)
    path = np.array([[2e-4, 0.0], [4e-4, 1e-4], [1e-3, 1e-4]])
    held, follows = (
        scene.start_of_sliding(path, model="half-space", pressure=kind) for kind in ("held", "follows")
    )
    assert follows.force == pytest.approx(held.force, rel=1e-5, abs=1e-5 * held.force.max())
    assert follows.slip_share == pytest.approx(held.slip_share)
    np.testing.assert_allclose(follows.pressure, held.pressure, atol=1e-6 * held.pressure.max())


@pytest.mark.parametrize("pressure", ["held", "follows"])
def test_tiny_pushes_are_linear(pressure: str) -> None:
    scene = block(0.1, 0.5)
    force = [
        scene.start_of_sliding([[size, 0.0]], model="elastic-upper", pressure=pressure).force[0, 0] / size
        for size in (1e-12, 1e-15)
    ]
    assert force[0] > 0.0
    assert force[1] == pytest.approx(force[0], rel=0.02)


def test_a_start_is_shown_in_one_line() -> None:
    scene = mtb.scenes.paraboloid_on_plane(friction=0.0, points=8)
    start = scene.start_of_sliding([[1e-4, 0.0]], model="half-space", pressure="held")
    assert re.fullmatch(r"StartOfSliding\(1 steps, \d+ points, last: 0 stick, .* N\)", repr(start))
    assert start.slip_share[0] == 1.0


def test_bad_input_is_named() -> None:
    scene = block(0.1, 0.5)
    for arguments, words in [
        ({"displacements": [[1e-6, 0.0]], "pressure": "free"}, "pressure is 'free'"),
        ({"displacements": [[1e-6, np.nan]]}, "displacements[0, 1] is nan"),
        ({"displacements": [1e-6, 0.0, 0.0]}, "displacements has shape (1, 3)"),
    ]:
        with pytest.raises(ValueError, match=re.escape(words)):
            scene.start_of_sliding(model="elastic-upper", **arguments)


@pytest.mark.parametrize("pressure", ["held", "follows"])
def test_the_state_does_not_depend_on_the_number_of_steps(pressure: str) -> None:
    scene = mtb.scenes.paraboloid_on_plane(friction=0.3, points=12, lower=mtb.Rigid())
    # to the side at last, where the tractions must turn
    corners = np.array([[0.0, 0.0], [3e-5, 0.0], [3e-5, 2e-5]])
    starts = []
    for count in (1, 2, 8):
        share = np.arange(1, count + 1)[:, None] / count
        path = np.concatenate([a + share * (b - a) for a, b in itertools.pairwise(corners)])
        starts.append(scene.start_of_sliding(path, model="half-space", pressure=pressure))
    friction = 0.3 * starts[0].normal_force[-1]
    for start in starts:
        assert np.diff(start.path_error, prepend=0.0).max() <= 1e-3
        assert start.path_error.shape == start.iterations.shape
        assert start.slip_share[0] > 0.1
        assert np.linalg.norm(start.force[-1] - starts[-1].force[-1]) < 2e-3 * friction


def test_steps_too_long_for_the_tolerance_are_told(monkeypatch: pytest.MonkeyPatch) -> None:
    scene = mtb.scenes.paraboloid_on_plane(friction=0.3, points=8, lower=mtb.Rigid())
    monkeypatch.setattr(mtb._mtb_rs, "PATH_TOLERANCE", 1e-12)
    with pytest.warns(mtb.ToleranceWarning, match="length of step 1"):
        scene.start_of_sliding([[3e-5, 0.0]], model="half-space", pressure="held")


def test_a_layer_is_no_body_of_its_own_material() -> None:
    """A thin coating of soft material changes little; the whole of it is soft."""
    soft = mtb.Material(5e9, 0.4)

    def force(upper: Any) -> float:
        scene = mtb.scenes.block_on_plane(friction=0.3, spacing=2e-2, upper=upper)
        return float(scene.start_of_sliding([(1e-6, 0.0)], model="auto").force[0, 0])

    coated, steel, whole = force(mtb.Layered(soft, 1e-6, mtb.steel)), force(mtb.steel), force(soft)
    half_space = mtb.scenes.block_on_plane(friction=0.3, spacing=2e-2).start_of_sliding(
        [(1e-6, 0.0)], model="half-space"
    )
    assert coated == pytest.approx(float(half_space.force[0, 0]), rel=0.02)
    assert coated > 5.0 * whole
    assert steel > 5.0 * whole
