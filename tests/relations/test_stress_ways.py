# SPDX-License-Identifier: MIT OR Apache-2.0
"""The stress inside the bodies of every kind of result, and of what is refused."""

from __future__ import annotations

import copy
import pickle
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import mtb_rs as mtb

COULOMB = mtb.Coulomb(0.3)
SOFT = mtb.Material(70e9, 0.33)


@cache
def normal() -> mtb.NormalResult:
    x = (np.arange(16) - 7.5) * 0.1e-3
    gap = (x[None] ** 2 + x[:, None] ** 2) / 0.2
    return mtb.solve_normal(gap, 0.1e-3, lower=mtb.steel, upper=SOFT, force=150.0)


@cache
def shifted() -> mtb.TangentialResult:
    return mtb.solve_tangential(normal(), mtb.Shift((2e-7, 1e-7)), COULOMB)


def transient() -> mtb.TangentialResult:
    motion = mtb.Rolling((5e-4, 0.0, 0.0), velocity=10.0, transient=True, step=1e-4)
    return mtb.solve_tangential(normal(), motion, COULOMB, state=shifted().state)


@cache
def steady() -> mtb.TangentialResult:
    return mtb.solve_tangential(normal(), mtb.Rolling((5e-4, 0.0, 0.0), velocity=10.0), COULOMB)


@cache
def ball() -> mtb.Scene:
    return mtb.scenes.paraboloid_on_plane(radius=1.0, force=1e4, friction=0.3, points=14)


@cache
def shoe() -> mtb.Scene:
    return mtb.scenes.pole_shoe_on_rail(friction=0.3, spacing=6e-3)


@cache
def wheels() -> mtb.PreparedWheels:
    scene = mtb.scenes.wheel_on_rail(force=50e3, lateral=0.0, spacing=1e-3, friction=0.3)
    return scene.prepare()  # type: ignore[return-value]


def rolled() -> mtb.WheelStep:
    return wheels().step((0.0, 0.0, np.nan, 0.0, 0.0, 0.0), velocity=10.0)


def patch() -> mtb.WheelPatch:
    return rolled().patches[0]


def prepared() -> mtb.StepResult:
    return ball().prepare(model="half-space").step()


def creeping() -> mtb.TangentialResult:
    motion = mtb.Rolling((5e-4, 0.0, 0.0), velocity=10.0)
    body = mtb.Viscoelastic(SOFT, creep=0.5, creep_time=1e-4)
    pressed = mtb.solve_normal(
        normal().initial_gap, 0.1e-3, lower=body, upper=body, force=150.0, rolling=motion
    )
    return mtb.solve_tangential(pressed, motion, COULOMB)


def started() -> mtb.StartOfSliding:
    return ball().start_of_sliding([(1e-6, 0.0), (1e-3, 0.0)], model="half-space")


def coated() -> mtb.TangentialResult:
    coat = mtb.Layered(SOFT, 0.2e-3, mtb.steel)
    pressed = mtb.solve_normal(normal().initial_gap, 0.1e-3, lower=coat, upper=coat, force=150.0)
    return mtb.solve_tangential(pressed, mtb.Rolling((5e-4, 0.0, 0.0), velocity=10.0), COULOMB)


WAYS: dict[str, Callable[[], Any]] = {
    "solve_normal": normal,
    "hertz": lambda: mtb.hertz(1e3, 0.5, lower=mtb.steel, upper=SOFT),
    "shift": shifted,
    "transient": transient,
    "steady": steady,
    "full coupling": lambda: mtb.solve_tangential(
        normal(), mtb.Rolling((5e-4, 0.0, 0.0), velocity=10.0), COULOMB, coupling="full"
    ),
    "fastsim": lambda: mtb.fastsim(normal(), (5e-4, 0.0, 0.0), COULOMB, velocity=10.0),
    "scene": lambda: ball().solve(model="half-space", tolerance=0.5),
    "scene of patches": lambda: shoe().solve(model="half-space", tolerance=0.99),
    "prepared": prepared,
    "start of sliding": started,
    "wheel": patch,
    "wear": lambda: mtb.wear(ball(), 1e-3, 1e-13, model="half-space"),
    "wheels": rolled,
    "creeping": creeping,
    "coated": coated,
}


@pytest.mark.filterwarnings("ignore:the bodies are unlike")
@pytest.mark.parametrize("way", WAYS)
def test_each_result_has_the_stress_of_its_tractions(way: str, tmp_path: Path) -> None:
    result = WAYS[way]()
    for body, sign in (("lower", -1.0), ("upper", 1.0)):
        found = result.stress(body, depths=[0.0, 1e-4])
        assert (sign * found.points[2] >= 0.0).all()
        # on the surface of both bodies zz is minus the pressure
        assert found.zz[0] == pytest.approx(-found.pressure, abs=1e-9 * found.peak_pressure)
        drawn = result.fields().get("traction")
        if drawn is not None and drawn.values.ndim == 3:
            own = np.stack([found.xz[0], found.yz[0]])
            assert own == pytest.approx(drawn.values[:2], abs=1e-9 * found.peak_pressure)
        # one point at a time costs as much as there are cells, so some rows of a fine grid have to do
        rows = max(1, found.points.shape[2] // 8)
        at = result.stress(body, points=found.points[:, :, ::rows])
        assert at.stress == pytest.approx(found.stress[:, :, ::rows], abs=1e-8 * np.abs(found.stress).max())
    usual = result.stress()
    assert usual.depths[0] == 0.0
    assert usual.depths[-1] == pytest.approx(3.0 * usual.half_width, rel=0.02)
    # the files of a result hold what its stress takes
    for other in (pickle.loads(pickle.dumps(result)), copy.deepcopy(result)):
        assert other.stress(depths=[0.0, 1e-4]) == result.stress(depths=[0.0, 1e-4])
    if way != "wheel":
        result.save(tmp_path)
        again = mtb.load(tmp_path)
        assert again.stress(depths=[0.0, 1e-4]) == result.stress(depths=[0.0, 1e-4])


def test_a_stress_is_saved_and_drawn(tmp_path: Path) -> None:
    found = steady().stress()
    assert pickle.loads(pickle.dumps(found)) == found
    assert found != steady().stress("upper")
    names = sorted(path.name for path in found.save(tmp_path))
    assert names == ["stress.json", "stress.npz", "stress.png"]
    assert mtb.load(tmp_path) == found
    for options in ({}, {"y": 0.0}, {"x": 0.0}, {"limits": (0.0, 1e8)}):
        found.plot("von_mises", **options)
    found.plot(["xx", "zz"], "depth", x=0.0, y=0.0, dimensionless=True)
    with pytest.raises(ValueError, match="kind is 'map'"):
        found.plot("xx", "map")
    with pytest.raises(ValueError, match="quantity is 'x'"):
        found.plot("x")
    with pytest.raises(ValueError, match="both x and y"):
        found.plot("xx", x=0.0, y=0.0)
    with pytest.raises(ValueError, match="x is 1 m"):
        found.plot("xx", x=1.0)
    with pytest.raises(ValueError, match="dimensionless is True: a picture of the kind 'section' takes"):
        found.plot("xx", dimensionless=True)
    dataset = found.to_xarray()
    assert dataset["xx"].dims == ("depth", "y", "x")
    assert dataset["xx"].attrs["units"] == "Pa"
    some = steady().stress(points=[[0.0, 1e-4], [0.0, 0.0], [-1e-4, -2e-4]])
    assert some.to_xarray()["zz"].dims == ("point",)
    with pytest.raises(ValueError, match="points that were asked for"):
        some.plot()
    assert [path.name for path in some.save(tmp_path / "points")] == ["stress.npz", "stress.json"]
    assert mtb.load(tmp_path / "points") == some


def test_what_follows_from_the_components() -> None:
    found = steady().stress(depths=[0.0, 1e-4])
    tensor = found.tensor()
    assert tensor == pytest.approx(np.swapaxes(tensor, -1, -2))
    principal = found.principal()
    assert (np.diff(principal, axis=0) <= 0.0).all()
    assert principal.sum(axis=0) == pytest.approx(3.0 * found.hydrostatic, abs=1.0)
    deviator = tensor - found.hydrostatic[..., None, None] * np.eye(3)
    mises = np.sqrt(1.5 * (deviator**2).sum(axis=(-1, -2)))
    assert found.von_mises == pytest.approx(mises, rel=1e-9)
    assert found.tresca == pytest.approx(2.0 * found.largest_shear)
    value, place = found.maximum("xz")
    assert value == found.xz.max()
    assert place.shape == (3,)


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({"depths": [-1e-6]}, "depths are measured into the body"),
        ({"depths": [1e-3, 1e-4]}, "rising depths are needed"),
        ({"depths": [0.0, 0.0]}, "rising depths are needed"),
        ({"depths": []}, r"depths has shape \(0,\)"),
        ({"depths": [[0.0]]}, r"depths has shape \(1, 1\)"),
        ({"depths": [np.nan]}, "depths"),
        ({"depths": "deep"}, "depths"),
        ({"points": [[0.0], [0.0], [1e-4]]}, "outside of the lower body: its inside has z <= 0"),
        ({"body": "upper", "points": [[0.0], [0.0], [-1e-4]]}, "its inside has z >= 0"),
        ({"points": [[0.0], [0.0], [np.inf]]}, "points"),
        ({"points": [[0.0], [0.0]]}, r"points has shape \(2, 1\)"),
        ({"points": [[0.05e-3], [0.0], [0.0]]}, "at the border of a loaded cell"),
        ({"points": [[0.0], [0.0], [-1e-4]], "depths": [0.0]}, "both depths and points"),
        ({"body": "both"}, "body is 'both'"),
        ({"patch": "left"}, "patch is 'left': one of 'contact' is needed"),
        ({"patch": 1}, "patch is 1: the name of a grid"),
        ({"material": mtb.steel}, "the result knows the lower body"),
        ({"material": 0.3}, "a Material is needed"),
    ],
)
def test_hostile_input_is_refused(given: dict[str, Any], words: str) -> None:
    with pytest.raises(ValueError, match=words):
        normal().stress(**given)


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({"coefficient": "a"}, "coefficient is 'a'"),
        ({"coefficient": np.nan}, "coefficient is nan"),
        ({"along": "z"}, "along is 'z'"),
        ({"residual_stress": [1.0, 2.0]}, r"residual_stress has shape \(2,\): \(6,\) or \(6, 2\) is needed"),
        ({"residual_stress": [np.nan] * 6}, "residual_stress"),
    ],
)
def test_bad_passages_are_refused(given: dict[str, Any], words: str) -> None:
    inside = steady().stress(depths=[1e-4, 2e-4])
    with pytest.raises(ValueError, match=words):
        inside.dang_van(**{"coefficient": 0.3, **given})
    with pytest.raises(ValueError, match=words):
        inside.plot("dang_van", **{"coefficient": 0.3, **given})


@pytest.mark.filterwarnings("ignore:the bodies are unlike")
def test_passages_go_the_way_of_the_rolling(tmp_path: Path) -> None:
    pressed = normal()
    motions = {angle: mtb.Rolling((5e-4, 2e-4, 0.0), angle=angle) for angle in (0.0, np.pi / 2, np.pi, 0.3)}
    rolled = {angle: mtb.solve_tangential(pressed, motion, COULOMB) for angle, motion in motions.items()}
    quick = {angle: mtb.fastsim(pressed, (5e-4, 2e-4, 0.0), COULOMB, angle=angle) for angle in motions}
    for results in (rolled, quick):
        inside = {angle: result.stress(depths=[1e-4, 2e-4]) for angle, result in results.items()}
        for angle, along in ((0.0, "x"), (np.pi / 2, "y"), (np.pi, "x")):
            wanted = inside[angle].dang_van(0.3, along=along)
            assert np.array_equal(inside[angle].dang_van(0.3), wanted)
            folder = tmp_path / f"{type(results[angle]).__name__}_{angle:.1f}"
            inside[angle].save(folder)
            assert np.array_equal(mtb.load(folder).dang_van(0.3), wanted)
        shown = inside[np.pi / 2].plot("dang_van", coefficient=0.3)
        assert shown.axes[0].get_xlabel() == "x [mm]"
        with pytest.raises(ValueError, match=r"rolls at 17\.19° to x"):
            inside[0.3].dang_van(0.3)
        assert inside[0.3].dang_van(0.3, along="x").shape == inside[0.0].dang_van(0.3).shape
    # what does not roll has a passage along x
    still = pressed.stress(depths=[1e-4, 2e-4])
    assert np.array_equal(still.dang_van(0.3), still.dang_van(0.3, along="x"))


def test_passages_need_lines() -> None:
    some = steady().stress(points=[[0.0, 1e-4], [0.0, 0.0], [-1e-4, -2e-4]])
    with pytest.raises(ValueError, match="a passage needs one at depths"):
        some.dang_van(0.3)
    inside = steady().stress(depths=[1e-4, 2e-4])
    with pytest.raises(ValueError, match="coefficient is missing"):
        inside.plot("dang_van")
    with pytest.raises(ValueError, match="of 'dang_van' there is a section"):
        inside.plot("dang_van", "depth", coefficient=0.3)
    with pytest.raises(ValueError, match="takes coefficient, residual_stress, along, limits, ax"):
        inside.plot("dang_van", coefficient=0.3, x=0.0)
    shown = inside.plot("dang_van", coefficient=0.3, along="y")
    assert shown.axes[0].get_xlabel() == "x [mm]"


def test_bodies_without_a_known_stress_are_refused() -> None:
    x = (np.arange(16) - 7.5) * 0.1e-3
    gap = (x[None] ** 2 + x[:, None] ** 2) / 0.2
    coat = mtb.Layered(mtb.steel, 1e-4, SOFT)
    coated = mtb.solve_normal(gap, 0.1e-3, lower=coat, upper=mtb.Rigid(), force=150.0)
    with pytest.raises(
        ValueError, match="the upper body is Rigid, and has no stress; body='lower' is the other one"
    ):
        coated.stress("upper")
    unloaded = mtb.solve_normal(gap, 0.1e-3, lower=mtb.steel, upper=mtb.steel, approach=0.0)
    with pytest.raises(ValueError, match="nothing presses"):
        unloaded.stress()
    assert not unloaded.stress(depths=[0.0, 1e-3]).stress.any()


def test_a_step_from_a_file_is_told_its_material(tmp_path: Path) -> None:
    contact = ball().prepare(model="half-space")
    contact.save(tmp_path / "ball.mtb")
    step = mtb.PreparedContact.load(tmp_path / "ball.mtb").step()
    with pytest.raises(ValueError, match="the contact points are scattered"):
        step.stress()


def one_depth_of_a_line() -> mtb.StressField:
    x = (np.arange(24) - 11.5) * 0.1e-3
    gap = x[None] ** 2 / 0.2
    line = mtb.solve_normal(gap, 0.1e-3, lower=SOFT, upper=SOFT, force=20.0, edge="sharp")
    return line.stress(depths=[1e-4])


@pytest.mark.parametrize(
    "made",
    [lambda: steady().stress(depths=[1e-4]), lambda: steady().stress(depths=0.0), one_depth_of_a_line],
    ids=["point", "surface", "line"],
)
def test_a_stress_at_one_depth_is_saved_without_a_section(
    made: Callable[[], mtb.StressField], tmp_path: Path
) -> None:
    found = made()
    # the section of an earlier one does not stay beside it
    steady().stress().save(tmp_path)
    assert sorted(path.name for path in found.save(tmp_path)) == ["stress.json", "stress.npz"]
    assert sorted(path.name for path in tmp_path.iterdir()) == ["stress.json", "stress.npz"]
    assert mtb.load(tmp_path) == found
    assert found._repr_png_() is None
    with pytest.raises(ValueError, match="at least two depths"):
        found.plot()


def test_a_single_cell_is_saved_with_its_line_into_the_depth(tmp_path: Path) -> None:
    cell = mtb.solve_normal(np.zeros((1, 1)), 1e-3, lower=SOFT, upper=SOFT, force=20.0, edge="sharp")
    found = cell.stress(depths=[0.0, 1e-3, 2e-3])
    assert sorted(path.name for path in found.save(tmp_path)) == ["stress.json", "stress.npz", "stress.png"]


@pytest.mark.slow
def test_elastic_bodies_have_the_stress_of_their_elements() -> None:
    result = shoe().solve(model="elastic-upper", tolerance=0.99)
    above = result.stress("upper", depths=[1e-3, 5e-3])
    solid = result.solids()[0]
    assert above.von_mises.max() <= 1.2 * solid.von_mises.max()
    # below, the half-space: its forces are those of the contact
    grid = result.patches[0]
    below = result.stress("lower", depths=[0.0, 3e-3], patch=grid.name)
    carried = float((grid.view(result.pressure) * grid.view(result.area)).sum())
    assert -below.zz[0].sum() * grid.spacing[0] * grid.spacing[1] == pytest.approx(carried, rel=1e-9)
    chosen = slice(None, None, len(solid.mesh.nodes) // 7)
    some = np.array(solid.mesh.nodes)[chosen].T
    at = result.stress("upper", points=some)
    assert at.stress == pytest.approx(solid.stress[:, chosen], abs=1e-9 * np.abs(solid.stress).max())
    with pytest.raises(ValueError, match="is in no tetrahedron of the body, of the upper body"):
        result.stress("upper", points=[[1.0], [0.0], [0.0]])
    with pytest.raises(ValueError, match="of the upper body 'left pole'"):
        result.stress("upper", patch="left", depths=[0.0, 1.0])
    for patch in result.patches:
        usual = result.stress("upper", patch=patch.name)
        assert usual.depths is not None
        assert len(usual.depths) == 36
        # two of the default ones again, by name
        again = result.stress("upper", patch=patch.name, depths=usual.depths[[3, 35]])
        assert again.stress == pytest.approx(usual.stress[:, [3, 35]], rel=1e-12)
    both = shoe().solve(model="elastic-both", tolerance=0.99)
    inside = both.stress("lower", depths=[2e-3])
    assert np.abs(inside.zz).max() < 3.0 * both.pressure.max()
    step = shoe().prepare(model="elastic-upper").step()
    with pytest.raises(ValueError, match="the upper body has finite elements, whose inside this result"):
        step.stress("upper")
    assert step.stress("lower", depths=[1e-3]).zz.min() < 0.0


def test_a_heated_shoe_has_the_stress_of_its_rail() -> None:
    heat = mtb.scenes.block_on_plane(spacing=0.025, friction=0.1).sliding_heat(1.0, 2, 1.0)
    grid = heat.patches[0]
    below = heat.stress(depths=[0.0, 1e-2])
    carried = float((grid.view(heat.pressure) * grid.view(heat.area)).sum())
    assert -below.zz[0].sum() * grid.spacing[0] * grid.spacing[1] == pytest.approx(carried, rel=1e-9)
    rubbed = float((grid.view(heat.traction[0]) * grid.view(heat.area)).sum())
    assert below.xz[0].sum() * grid.spacing[0] * grid.spacing[1] == pytest.approx(rubbed, rel=1e-9)
    with pytest.raises(ValueError, match="the upper body has finite elements, whose inside this result"):
        heat.stress("upper")


def test_each_patch_of_a_step_of_wheels_is_apart() -> None:
    step = rolled()
    for k, one in enumerate(step.patches):
        assert step.stress(patch=f"patches[{k}]") == one.stress()
    with pytest.raises(ValueError, match=r"patch is 'left': one of 'patches\[0\]'"):
        step.stress(patch="left")
    lifted = wheels().step((0.0, 0.0, 1e-3, 0.0, 0.0, 0.0), velocity=10.0)
    with pytest.raises(ValueError, match="the wheels are lifted"):
        lifted.stress()


def test_wear_of_a_prepared_contact_is_refused() -> None:
    with pytest.raises(ValueError, match="wear of the scene has its stress"):
        mtb.wear(ball().prepare(model="half-space"), 1e-3, 1e-13).stress()
