# SPDX-License-Identifier: MIT OR Apache-2.0
"""How near a load is to tipping a body over, and bodies that have jammed."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

import mtb_rs as mtb
from mtb_rs.bodies.mesh import block_mesh


def block(friction: float) -> mtb.Scene:
    return mtb.scenes.block_on_plane(height=0.09, friction=friction, supports="driven-top", spacing=0.0125)


def leaning(friction: float) -> mtb.Scene:
    """A trapezoid that leans forwards, held along x and y at its top, free to approach and to tilt."""
    x = np.linspace(-0.03, 0.03, 7)
    mesh = block_mesh(x, x, 0.05)
    nodes = mesh.nodes.copy()
    nodes[:, 0] += 0.3 * nodes[:, 2]
    top = float(nodes[:, 2].max())
    middle = 0.3 * top
    # three points at the top keep it from sliding and from turning about z
    held = [
        mtb.Support(((middle, middle), (0.0, 0.0), (top, top)), x=0, y=0),
        mtb.Support(((middle + 0.01, middle + 0.01), (0.0, 0.0), (top, top)), y=0),
    ]
    body = mtb.ElasticBody.from_mesh(
        mtb.TetraMesh(nodes, mesh.cells), mtb.steel, contact="bottom", supports=held
    )
    return mtb.Scene(upper=body, lower=mtb.steel, spacing=1e-2, friction=friction, force=1e3)


def pushed(share: float) -> mtb.Scene:
    """A rigid flat punch on a half-space: moments move the resultant by `share` of a centimetre."""
    scene = mtb.scenes.block_on_plane(friction=0.3, spacing=0.01)
    force = 3e4
    return scene.with_(magnetic_pressure=None, force=force, moments=(0.0, -0.01 * share * force))


@pytest.mark.coarse
@pytest.mark.parametrize(
    ("make", "start", "model", "tips_at"),
    [
        # the moment of the friction about the middle takes the resultant to the border of the face
        (block, 0.2, "elastic-upper", 0.05 / 0.09),
        (leaning, 0.1, "auto", 0.03 / 0.05),
        (pushed, 1.0, "half-space", 5.0),
    ],
    ids=["ready elastic", "own body", "half-space with free tilts"],
)
def test_the_margin_says_at_which_load_a_body_tips_over(
    make: Callable[[float], mtb.Scene], start: float, model: str, tips_at: float
) -> None:
    first, second = (make(k * start).solve(model).report.tipping_margin for k in (1.0, 1.5))
    assert first is not None
    assert second is not None
    # linear in what moves the resultant: where it is 1 the body tips
    slope = (second - first) / (0.5 * start)
    limit = start + (1.0 - first) / slope
    assert limit == pytest.approx(tips_at, rel=1e-6)
    near = make(0.88 * limit).solve(model)
    assert near.report.converged
    assert "jammed" not in near.report.status
    assert near.report.tipping_margin == pytest.approx(0.88, abs=1e-6)
    assert near.report.wedging_margin >= near.report.tipping_margin
    assert "0.88 of the way to tipping over" in str(near)
    with pytest.raises(mtb.ResultantError) as caught:
        make(1.01 * limit).solve(model)
    assert caught.value.result.report.tipping_margin == pytest.approx(1.01, abs=1e-6)
    assert "Narrower cells" not in str(caught.value)
    # a load that only narrower cells carry, the resultant beyond the middle of the last cell
    with pytest.raises(
        mtb.ResultantError, match=r"0\.990 of the way .* Narrower cells would carry it"
    ) as caught:
        make(0.99 * limit).solve(model)
    assert caught.value.result.report.tipping_margin == pytest.approx(0.99, abs=1e-6)


@pytest.mark.coarse
@pytest.mark.parametrize("along", [(1.0, 0.0), (0.0, 1.0), (1.0, 2.0)])
def test_the_tipping_margin_is_that_of_the_face_whatever_the_cells(along: tuple[float, float]) -> None:
    height, friction = 0.07, 0.5
    # moments about the middle: friction shifts the resultant by mu h against the sliding
    ahead = friction * height * np.array(along) / np.hypot(*along)
    exact = np.abs(ahead / np.array([0.05, 0.04])).max()
    for spacing in (0.02, 0.0125, 0.01, (0.01, 0.016)):
        block = mtb.scenes.block_on_plane(
            height=height,
            length=0.08,
            friction=friction,
            supports="driven-top",
            spacing=spacing,
            sliding_direction=along,
        )
        try:
            report = block.solve("elastic-upper").report
        except mtb.ResultantError as error:
            report = error.result.report
        assert report.tipping_margin == pytest.approx(exact, abs=1e-6)


@pytest.mark.coarse
def test_where_no_load_determines_the_force_there_is_no_tipping_margin() -> None:
    gap = 1e-3 * np.hypot(*np.mgrid[-1:1:9j, -1:1:9j])
    scene = mtb.Scene(mtb.steel, mtb.steel, gap=gap, approach=1e-5, spacing=1e-3)
    assert scene.solve().report.tipping_margin is None
    clamped = mtb.scenes.block_on_plane(supports="clamped-top", spacing=0.02).solve("elastic-upper")
    assert clamped.report.tipping_margin is None
    assert "tipping" not in str(clamped)


@pytest.mark.coarse
def test_a_state_that_has_jammed_says_so() -> None:
    def scene(friction: float) -> mtb.Scene:
        return mtb.scenes.block_on_plane(height=0.5, friction=friction, supports="clamped-top", spacing=0.02)

    sliding = scene(0.1).solve("elastic-upper")
    assert sliding.report.converged
    assert "jammed" not in sliding.report.status
    low, high = 0.1, 1.0
    for _ in range(7):
        middle = 0.5 * (low + high)
        try:
            with pytest.MonkeyPatch.context() as patch:
                patch.setattr("mtb_rs.contact.solve.ask", lambda *_, **__: None)
                scene(middle).solve("elastic-upper")
            low = middle
        except mtb.ConvergenceError:
            high = middle
    with pytest.warns(UserWarning, match=r"has jammed: .* times the load, and .* without friction") as told:
        jammed = scene(low).solve("elastic-upper")
    # the line that asked, not one of the package
    assert {one.filename for one in told} == {__file__}
    assert jammed.report.converged
    assert "has jammed" in jammed.report.status
    assert jammed.normal_force > 10.0 * sliding.normal_force
