# SPDX-License-Identifier: MIT OR Apache-2.0
"""Old names still work: a scene's `layout` is its geometry now, the `sheet` of contact points their grid."""

import pickle
from collections.abc import Callable
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import mtb_rs as mtb
from mtb_rs.bodies.mesh import block_mesh
from mtb_rs.bodies.surfaces import SurfaceGap
from mtb_rs.moved import CLASSES

#: What 0.1.0 has pickled, made by the functions of `MADE`.
PICKLED = Path(__file__).parents[1] / "data" / "pickled" / "scenes_0_1_0.pickle"
GAP = np.arange(9.0).reshape(3, 3) ** 2 * 1e-6


def body() -> mtb.Scene:
    x = np.linspace(-0.02, 0.02, 3)
    support = mtb.Support("top", z=0.0, x=0.0, y=0.0)
    block = mtb.ElasticBody(block_mesh(x, x, 0.03), mtb.steel, "bottom", [support])
    return mtb.Scene(upper=block, lower=mtb.steel, spacing=1e-2, force=10.0)


def between() -> SurfaceGap:
    plane, ball = mtb.BodySurface.plane(), mtb.BodySurface.paraboloid(0.1)
    return mtb.surface_gap(plane, ball, (-1e-3, 1e-3), (-1e-3, 1e-3), 1e-3)


MADE: dict[str, Callable[[], Any]] = {
    "paraboloid": lambda: mtb.scenes.paraboloid_on_plane(points=8),
    "block": lambda: mtb.scenes.block_on_plane(spacing=0.02),
    "shoe": lambda: mtb.scenes.pole_shoe_on_rail(spacing=9e-3),
    "wheel": lambda: mtb.scenes.wheel_on_rail(spacing=1e-3),
    "gap": lambda: mtb.Scene(upper=mtb.steel, lower=mtb.steel, gap=GAP, spacing=1e-3, force=10.0),
    "body": body,
    "surface gap": between,
}


@pytest.fixture(scope="module")
def loaded() -> dict[str, Any]:
    with pytest.warns(DeprecationWarning, match="of mtb_rs.* is called .* now"):
        found: dict[str, Any] = pickle.loads(PICKLED.read_bytes())
    return found


@pytest.mark.parametrize("name", MADE)
def test_what_was_pickled_under_old_names_can_be_loaded(name: str, loaded: dict[str, Any]) -> None:
    made = MADE[name]()
    if name == "wheel":
        # the first version placed the contact plane elsewhere
        assert loaded[name].inputs == made.inputs
        assert loaded[name].geometry != made.geometry
    else:
        assert loaded[name] == made
    assert vars(loaded[name]).keys() == vars(made).keys()


def test_a_scene_takes_its_geometry_under_the_old_name() -> None:
    block, gap = mtb.scenes.block_on_plane(spacing=0.02), MADE["gap"]()
    bodies = {"upper": mtb.steel, "lower": mtb.steel, "spacing": 1e-3, "force": 1e3}
    bowl = mtb.scenes.paraboloid_on_plane(points=8).geometry
    with pytest.warns(DeprecationWarning, match="argument layout of Scene is called geometry now"):
        taken = mtb.Scene(**bodies, layout=bowl)  # type: ignore[call-arg, arg-type]
    assert taken == mtb.Scene(**bodies, geometry=bowl)  # type: ignore[arg-type]
    with pytest.warns(DeprecationWarning, match=r"Scene\.layout is called geometry now") as caught:
        assert block.layout is block.geometry  # type: ignore[attr-defined]
    assert [Path(one.filename).name for one in caught] == ["test_old_names.py"]
    longer = mtb.scenes.block_on_plane(spacing=0.02, length=0.2).geometry
    for scene, geometry in ((block, longer), (gap, None)):
        with pytest.warns(DeprecationWarning, match="argument layout of .* is called geometry now"):
            assert scene.with_(layout=geometry) == scene.with_(geometry=geometry)
    with pytest.raises(TypeError, match="both geometry and layout"):
        mtb.Scene(**bodies, geometry=bowl, layout=bowl)  # type: ignore[call-arg, arg-type]


def test_contact_points_are_found_under_the_old_name() -> None:
    shoe, found = mtb.PoleShoe(), between()
    with pytest.warns(DeprecationWarning, match=r"PoleShoe\.sheet is called grid now"):
        assert shoe.sheet(9e-3) == shoe.grid(9e-3)  # type: ignore[attr-defined]
    with pytest.raises(TypeError, match="unexpected keyword argument 'sheet'"):
        mtb.PoleShoe(sheet=1)  # type: ignore[call-arg]
    with pytest.warns(DeprecationWarning, match=r"SurfaceGap\.sheet is called grid now"):
        assert found.sheet is found.grid  # type: ignore[attr-defined]
    given = found.facet_error, found.nearest
    with pytest.warns(DeprecationWarning, match="argument sheet of SurfaceGap is called grid now"):
        again = SurfaceGap(sheet=found.grid, facet_error=given[0], nearest=given[1])  # type: ignore[call-arg]
    assert again == found


def test_the_approach_of_a_gap_is_taken_under_the_old_name() -> None:
    bodies = mtb.BodySurface.plane(), mtb.BodySurface.paraboloid(0.1)
    given = (-1e-3, 1e-3), (-1e-3, 1e-3), 1e-3
    with pytest.warns(DeprecationWarning, match="argument penetration of surface_gap is called approach now"):
        old = mtb.surface_gap(*bodies, *given, penetration=1e-5)  # type: ignore[call-arg]
    assert old == mtb.surface_gap(*bodies, *given, approach=1e-5)


@pytest.mark.coarse
def test_the_unit_of_the_slip_is_told_under_the_old_name() -> None:
    x = np.linspace(-2e-3, 2e-3, 9)
    pressed = mtb.solve_normal(
        (x[:, None] ** 2 + x**2) / 0.2, 5e-4, upper=mtb.steel, lower=mtb.steel, force=10.0
    )
    rolled = mtb.fastsim(pressed, (1e-4, 0.0, 0.0), mtb.Coulomb(0.3))
    patch = mtb.scenes.wheel_on_rail(lateral=0.0, spacing=2e-3).prepare().step(velocity=10.0).patches[0]
    for result, unit in ((rolled, "1"), (patch, "m/s"), (pressed, "1")):
        with pytest.warns(DeprecationWarning, match=r"slip_unit is fields\(\)\[.slip.\]\.unit now"):
            assert result.slip_unit == unit


@pytest.mark.parametrize(("place", "old"), [(place, old) for place in CLASSES for old in CLASSES[place]])
def test_old_names_of_classes_lead_to_the_new_ones(place: str, old: str) -> None:
    module, new = import_module(f"mtb_rs.{place}"), CLASSES[place][old]
    with pytest.warns(DeprecationWarning, match=f"{old} of mtb_rs.{place} is called {new} now"):
        assert getattr(module, old) is getattr(module, new)
    with pytest.raises(AttributeError, match="has no attribute 'nothing'"):
        module.nothing  # noqa: B018


def test_old_names_of_classes_in_old_modules_lead_to_the_new_ones() -> None:
    from mtb_rs.geometry.geometries import BlockOnPlane

    with pytest.warns(DeprecationWarning, match="take BlockOnPlane from mtb_rs.geometry.geometries"):
        assert import_module("mtb_rs.layout").BlockLayout is BlockOnPlane


def test_rolling_that_was_pickled_before_its_modules_parted_keeps_its_derivatives() -> None:
    pressure = np.outer([1.0, 3.0, 1.0], [1.0, 3.0, 2.0]) * 1e8
    contact = mtb.PressureField(pressure, (1e-3, 1e-3), mtb.steel, mtb.steel)
    result = mtb.solve_tangential(contact, mtb.Rolling((1e-3, 0.0, 0.0)), mtb.Coulomb(0.3))
    # text, in which the names of classes stand on lines of their own
    data = pickle.dumps(result, protocol=2).replace(b"tangential_result\nGiven\n", b"tangential\n_Given\n")
    for module in (b"motions", b"tangential_result", b"tangential_state"):
        assert b"half_space." + module + b"\n" in data
        data = data.replace(b"half_space." + module + b"\n", b"half_space.tangential\n")
    again = pickle.loads(data)
    assert again == result
    assert np.array_equal(again.derivative("force", "creepage"), result.derivative("force", "creepage"))
