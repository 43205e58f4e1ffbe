# SPDX-License-Identifier: MIT OR Apache-2.0
"""A ready scene with an argument changed is the one made with that argument; so are cases of sweeps."""

from __future__ import annotations

import inspect
from dataclasses import fields
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import mtb_rs as mtb
from mtb_rs.base.fingerprint import fingerprint

Y = np.linspace(-0.04, 0.04, 41)
READY = [getattr(mtb.scenes, name) for name in mtb.scenes.__all__]
#: Other values than those by default, all of which every ready scene with such an argument takes.
OTHERS: dict[str, list[Any]] = {
    "attraction": ["both"],
    "conforming_to": [18e-3],
    "flange_back": [1.3605],
    "force": [2e4, 9e4],
    "friction": [
        0.1,
        np.full((4, 4), 0.2),
        mtb.VelocityTable([0.0, 9.0], [0.4, 0.2]),
        lambda x, y: 0.1 + 0 * x,
    ],
    "gauge": [1.436],
    "gauge_depth": [13e-3],
    "hardness": [1e8, (1e8, 1e9)],
    "height": [0.05],
    "inner_edge": [8e-3],
    "lateral": [1e-3, 5e-3],
    "layer": [mtb.InterfaceLayer(1e-4, 1e9)],
    "length": [0.08],
    "lower": [mtb.Material(7e10, 0.33), mtb.Rigid()],
    "magnetic_pressure": [1e6, (2e6, 1e6), mtb.GaussianPressure(3e6, (0.0, 0.01), (0.02, 0.02))],
    "normal_layer": [1e-12, (1e-12, 3e-12), mtb.RoughLayer.exponential(1e10, 1e-6)],
    "outer_edge": [30e-3],
    "points": [12, None],
    "poles": [1],
    "radius": [0.5],
    "rail": [mtb.Profile.from_points(Y, -1e-2 * (np.abs(Y) / 0.04) ** 2 - 10e-3 * (np.abs(Y) / 0.04) ** 8)],
    "rail_inclination": [1 / 20],
    "rail_length": [0.25],
    "relief_slope": [0.05],
    "roller_radius": [0.4],
    "sliding_direction": [(0.0, 1.0), None],
    "spacing": [2e-3, (1e-3, 2e-3), None],
    "supports": ["points", (mtb.Support("top", x=0, y=0, z=0),)],
    "tape_circle": [70.5e-3],
    "upper": [mtb.Material(1e11, 0.25)],
    "velocity": [5.0],
    "wheel": ["S1002"],
    "wheel_radius": [0.5],
    "width": [0.07],
    "yaw": [1e-2],
}
CASES = [(build, name) for build in READY for name in inspect.signature(build).parameters]


def same(one: mtb.Scene, other: mtb.Scene) -> None:
    for f in fields(one):
        assert fingerprint(getattr(one, f.name)) == fingerprint(getattr(other, f.name)), f.name


@pytest.mark.parametrize(("build", "name"), CASES, ids=lambda part: getattr(part, "__name__", part))
def test_a_changed_argument_makes_the_scene_made_with_it(build: Any, name: str) -> None:
    for value in OTHERS[name]:
        same(build().with_(**{name: value}), build(**{name: value}))


@settings(max_examples=25, deadline=None)
@given(st.data())
def test_several_changes_in_any_order(data: st.DataObject) -> None:
    build = data.draw(st.sampled_from(READY))
    # where both say how fine the grid is, the later one counts
    names = [n for n in inspect.signature(build).parameters if n not in ("width", "points")]
    drawn = data.draw(st.sets(st.sampled_from(names), max_size=4))
    chosen = {n: data.draw(st.sampled_from(OTHERS[n])) for n in sorted(drawn)}
    try:
        made = build(**chosen)
    except ValueError:
        return
    scene = build()
    for name in data.draw(st.permutations(sorted(chosen))):
        try:
            scene = scene.with_(**{name: chosen[name]})
        except ValueError:  # together they go, one after the other in this order they do not
            return
    same(scene, made)


def test_what_no_ready_scene_takes_stays_through_changes() -> None:
    shoe = mtb.scenes.pole_shoe_on_rail().with_(moments=(1.0, 2.0)).with_(height=0.05)
    assert shoe.moments == (1.0, 2.0)
    assert shoe.inputs["height"] == 0.05
    pressed = mtb.scenes.paraboloid_on_plane(points=9).with_(force=None, approach=1e-4)
    assert (pressed.force, pressed.approach) == (None, 1e-4)
    assert "force" not in pressed.inputs
    assert mtb.scenes.paraboloid_on_plane().with_(spacing=0.1).with_(points=12).spacing == (
        mtb.scenes.paraboloid_on_plane(points=12).spacing
    )


@pytest.mark.coarse
@pytest.mark.parametrize(
    ("build", "arguments"),
    [
        (mtb.scenes.paraboloid_on_plane, {"points": 12, "friction": 0.0}),
        (mtb.scenes.wheel_on_rail, {"spacing": 1e-3}),
    ],
)
def test_a_sweep_of_the_force_solves_the_ready_scenes(build: Any, arguments: dict[str, Any]) -> None:
    forces = [3e4, 6e4, 5e7][: 3 if build is mtb.scenes.paraboloid_on_plane else 2]
    table = mtb.sweep(build(**arguments), {"force": forces})
    for k, force in enumerate(forces):
        solved = build(**arguments, force=force).solve()
        assert table["peak_pressure"][k] == solved.report.peak_pressure
        assert table["normal_force"][k] == solved.normal_force
        assert table["approach"][k] == solved.approach


@pytest.mark.parametrize(
    "friction",
    [0.15, mtb.Coulomb(0.15), mtb.FallingFriction(0.3, 0.1, 1.0), mtb.RailFriction([-0.1, 0.1], [0.1, 0.2])],
)
@pytest.mark.coarse
def test_a_wheel_rolls_with_the_friction_of_its_scene(friction: Any, tmp_path: Path) -> None:
    plain = mtb.scenes.wheel_on_rail(spacing=1e-3)
    scene = mtb.scenes.wheel_on_rail(spacing=1e-3, friction=friction)
    law = mtb.Coulomb(friction) if isinstance(friction, float) else friction
    state = {"velocity": (10.0, 0.0, 0.0, 0.0, 10.0 / 0.46 * 1.02, 0.0)}
    expected = plain.prepare(friction=law).step(**state)
    assert np.linalg.norm(expected.force[:2]) > 1.0
    for asked in (scene, plain.with_(friction=friction), scene.with_(force=50e3).with_(force=36e3)):
        assert np.array_equal(asked.prepare().step(**state).force, expected.force)
    # pressed at rest, without friction, whatever will be rolled with
    result = scene.solve()
    assert np.array_equal(result.pressure, plain.solve().pressure)
    assert not result.traction[:2].any()
    assert result.save(tmp_path)


@pytest.mark.parametrize("friction", [-0.1, float("nan"), "dry", True])
def test_a_friction_that_no_wheel_has_is_named(friction: Any) -> None:
    with pytest.raises(ValueError, match=r"friction|coefficient"):
        mtb.scenes.wheel_on_rail(spacing=1e-3, friction=friction)
