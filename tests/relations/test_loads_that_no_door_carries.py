# SPDX-License-Identifier: MIT OR Apache-2.0
"""What has no solution, or none on its grid, is refused alike by every way of asking."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import mtb_rs as mtb
from mtb_rs.bodies.mesh import block_mesh

pytestmark = pytest.mark.coarse

X = (np.arange(9) - 4) * 1e-3
BOWL = (X[None, :] ** 2 + X[:, None] ** 2) / 0.6


def own(**given: Any) -> mtb.Scene:
    """A block with an own mesh on a half-space."""
    x = np.linspace(-0.02, 0.02, 5)
    support = [mtb.Support("top", x=0, y=0, z=None)]
    body = mtb.ElasticBody(block_mesh(x, x, 0.02), mtb.steel, "contact", support, "pad")
    return mtb.Scene(body, mtb.steel, spacing=1e-2, friction=0.2, force=1e4, **given)


def flat(**given: Any) -> mtb.Scene:
    """Flat half-spaces of the size of the grid."""
    stated: dict[str, Any] = {"force": 100.0, "friction": 0.2, "spacing": 1e-3, **given}
    return mtb.Scene(mtb.steel, mtb.steel, gap=np.zeros((9, 9)), **stated)


def block(**given: Any) -> mtb.Scene:
    return mtb.scenes.block_on_plane(supports="driven-top", spacing=2e-2, friction=0.1).with_(**given)


def start(scene: mtb.Scene, model: Any) -> Any:
    return scene.start_of_sliding([[1e-6, 0.0]], model=model)


def held(scene: mtb.Scene, model: Any) -> Any:
    return scene.start_of_sliding([[1e-6, 0.0]], model=model, pressure="held")


def step(scene: mtb.Scene, model: Any) -> Any:
    return scene.prepare(model).step(velocity=1.0)


def swept(scene: mtb.Scene, model: Any) -> Any:
    return mtb.sweep(scene, {"friction": [0.1]}, model=model)


TIPPED = {
    "block, elastic": (block(moments=(2e4, 0.0)), "elastic-upper"),
    "block, half-space": (block(moments=(2e4, 0.0)), "half-space"),
    "half-spaces": (flat(moments=(0.0, 5.0)), "half-space"),
    "own body": (own(moments=(0.0, 800.0)), "auto"),
}


@pytest.mark.parametrize("name", TIPPED)
def test_a_tipping_load_is_named_by_every_door(name: str) -> None:
    scene, model = TIPPED[name]
    with pytest.raises(mtb.ResultantError) as caught:
        scene.solve(model)
    for door in (start, held):
        with pytest.raises(mtb.ResultantError) as again:
            door(scene, model)
        assert str(again.value) == str(caught.value)
    with pytest.raises(mtb.ResultantError, match="lies outside what the contact can carry"):
        step(scene, model)
    assert swept(scene, model).status[0] == f"no solution: {caught.value}"


def both_ways(scene: mtb.Scene, model: Any, tmp_path: Path) -> list[mtb.PreparedContact]:
    contact = scene.prepare(model)
    contact.save(tmp_path / "contact.mtb")
    return [contact, mtb.PreparedContact.load(tmp_path / "contact.mtb")]


@pytest.mark.parametrize("model", ["half-space", "elastic-upper"])
def test_a_step_whose_pull_lifts_the_body_is_named(model: Any, tmp_path: Path) -> None:
    for contact in both_ways(block(), model, tmp_path):
        with pytest.raises(mtb.ResultantError, match="lies outside what the contact can carry") as caught:
            contact.step(velocity=1.0, magnetic_pressure=-1e6)
        assert caught.value.result.report.status == "unreachable"
        # the contact is still there
        assert contact.step(velocity=1.0).force[2] < 0.0
    field = block().prepare(model)
    with pytest.raises(mtb.ResultantError, match="lies outside"):
        field.step(velocity=1.0, magnetic_pressure=lambda x, y: -1e6 + 0.0 * x)


def incremental(scene: mtb.Scene, model: Any) -> Any:
    return scene.solve("half-space", method="incremental")


def solved(scene: mtb.Scene, model: Any) -> Any:
    return scene.solve(model)


NARROW = {
    "paraboloid": mtb.scenes.paraboloid_on_plane(points=12, width=0.3),
    "given gap": mtb.Scene(mtb.steel, mtb.steel, gap=BOWL, spacing=1e-3, friction=0.3, force=8e4),
    "given gap, rigid": mtb.Scene(mtb.Rigid(), mtb.steel, gap=BOWL, spacing=1e-3, friction=0.3, force=8e4),
}


@pytest.mark.parametrize("door", [solved, incremental, step, start, held])
@pytest.mark.parametrize("name", NARROW)
def test_a_contact_cut_off_by_its_grid_is_refused(name: str, door: Callable[..., Any]) -> None:
    with pytest.raises(ValueError, match="the contact reaches the edge of the grid of"):
        door(NARROW[name], "half-space")


def test_a_wheel_cut_off_by_its_grid_is_refused() -> None:
    iron = mtb.Material(170e9, 0.3)
    wheel = mtb.scenes.wheel_on_rail(spacing=1e-3, lateral=0.0, upper=iron, lower=iron)
    # an approach that the grid, which is made for the force, has no room for
    pressed = replace(wheel, approach=1e-3, force=None)
    for door in (solved, start):
        with pytest.raises(ValueError, match="the contact reaches the edge of the grid of"):
            door(pressed, "half-space")


@pytest.mark.parametrize("coefficient", [0.3, mtb.Coulomb(0.3)], ids=["number", "law"])
@pytest.mark.parametrize("pressure", ["follows", "held"])
def test_a_wheel_pushed_along_the_rail_slides_with_its_friction(coefficient: Any, pressure: Any) -> None:
    wheel = mtb.scenes.wheel_on_rail(spacing=1e-3, lateral=0.0, friction=coefficient)
    found = wheel.start_of_sliding([[1e-3, 0.0]], pressure=pressure)
    # like half-spaces: the law of Coulomb over the whole contact
    assert wheel.force is not None
    assert found.force[-1] == pytest.approx([0.3 * wheel.force, 0.0], rel=1e-6, abs=1e-6 * wheel.force)


@pytest.mark.parametrize(
    "law", [mtb.FallingFriction(0.4, 0.3, 0.1), mtb.TabulatedFriction((0.0, 1.0), (0.4, 0.3))]
)
def test_friction_that_changes_with_slip_is_refused_from_rest(law: Any) -> None:
    wheel = mtb.scenes.wheel_on_rail(spacing=2e-3, lateral=0.0, friction=law)
    with pytest.raises(ValueError, match="a number or Coulomb, is needed"):
        wheel.start_of_sliding([[1e-3, 0.0]])


@pytest.mark.parametrize("pressure", ["follows", "held"])
def test_the_force_of_sliding_is_that_of_the_slid_contact(pressure: Any) -> None:
    # turned, so that the tangents of the contact are not x and y
    shoe = mtb.scenes.pole_shoe_on_rail(spacing=(18e-3, 12e-3), yaw=0.02, friction=0.1)
    if pressure == "held":
        # at rest with no friction the pressure is another one: what is left is the load at no push
        rest = shoe.with_(friction=0.0).solve("elastic-upper")
        found = shoe.with_(friction=0.0).start_of_sliding([[0.0, 0.0]], "elastic-upper", pressure="held")
        expected = rest.force[:2]
    else:
        slid = shoe.solve("elastic-upper")
        # far enough that the way there is forgotten
        way = [[1e-4, 0.0], [1e-3, 0.0], [5e-2, 0.0], [1e-1, 0.0]]
        found = shoe.start_of_sliding(way, "elastic-upper")
        expected = slid.force[:2]
        rest = slid
    assert found.force[-1] == pytest.approx(expected, abs=1e-4 * abs(rest.force[2]))


def test_a_step_that_reaches_the_edge_is_refused_and_a_lighter_one_is_not() -> None:
    contact = NARROW["given gap"].with_(force=None, magnetic_pressure=1e5).prepare()
    assert contact.step(velocity=1.0).force[2] < 0.0
    with pytest.raises(ValueError, match="the contact reaches the edge of the grid of"):
        contact.step(velocity=1.0, magnetic_pressure=1e10)


@pytest.mark.parametrize("door", [solved, step, start])
@pytest.mark.parametrize("scene", [own(), block()], ids=["own body", "block"])
def test_where_bodies_end_contact_may_reach_their_edge(scene: mtb.Scene, door: Callable[..., Any]) -> None:
    door(scene, "auto")


def test_bodies_apart_are_named_by_every_door() -> None:
    apart = mtb.Scene(mtb.steel, mtb.steel, gap=BOWL + 1e-5, spacing=1e-3, friction=0.3, approach=1e-6)
    words = "the bodies never touch: approach is 1e-06 m, the smallest gap is 1e-05 m"
    doors: list[Callable[[], Any]] = [
        apart.solve,
        lambda: start(apart, "auto"),
        lambda: apart.chart(budget=1.0),
    ]
    for door in doors:
        with pytest.raises(ValueError, match=words):
            door()
    # in a simulation bodies part and meet again
    assert apart.prepare().step(velocity=1.0).force[2] == 0.0
