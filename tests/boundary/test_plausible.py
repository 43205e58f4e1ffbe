# SPDX-License-Identifier: MIT OR Apache-2.0
"""Slips of the unit are questioned where they are made, once, and results that no body bears as well."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import mtb_rs as mtb

SCENES = [mtb.scenes.block_on_plane, mtb.scenes.pole_shoe_on_rail, mtb.scenes.wheel_on_rail]
PULLED = [mtb.scenes.block_on_plane, mtb.scenes.pole_shoe_on_rail]
#: Steel in MPa, in GPa and in kPa.
SLIPS = [mtb.Material(210e3, 0.3), mtb.Material(210.0, 0.3), mtb.Material(210e12, 0.3)]


def asked(make: Callable[[], Any]) -> list[str]:
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        # grids here are coarse
        warnings.simplefilter("ignore", mtb.ToleranceWarning)
        make()
    # the reader finds the line of the program, not one of the package
    assert all(warning.filename == __file__ for warning in caught)
    return [str(warning.message) for warning in caught]


def pad(material: mtb.Material, side: float = 0.02) -> mtb.ElasticBody:
    nodes = np.array([[x, y, z] for z in (0.0, side) for y in (0.0, side) for x in (0.0, side)])
    cells = np.array([[0, 1, 3, 7], [0, 3, 2, 7], [0, 2, 6, 7], [0, 6, 4, 7], [0, 4, 5, 7], [0, 5, 1, 7]])
    held = mtb.Support(lambda p: p[2] > 0.99 * side, x=0.0, y=0.0, z=0.0)
    return mtb.ElasticBody(mtb.TetraMesh(nodes, cells), material, supports=[held], contact="bottom")


@pytest.mark.parametrize("side", ["upper", "lower"])
@pytest.mark.parametrize(
    ("scene", "material"),
    # a wheel so soft sinks in by more than its gap allows, and says so
    [(scene, material) for scene in PULLED for material in SLIPS] + [(mtb.scenes.wheel_on_rail, SLIPS[-1])],
)
def test_moduli_in_other_units(scene: Callable[..., mtb.Scene], material: mtb.Material, side: str) -> None:
    questions = asked(lambda: scene(**{side: material}))
    assert len(questions) == 1
    assert f"young_modulus of the {side} body is {material.young_modulus:g} Pa" in questions[0]


@pytest.mark.parametrize("scene", PULLED)
@pytest.mark.parametrize(
    ("pull", "word"),
    [
        (3.0, "is 3 Pa"),
        ([3.0, 3e6], "is 3 Pa"),
        (mtb.VelocityTable([0.0, 10.0], [1.0, 3.0]), "is 3 Pa"),
        (mtb.GaussianPressure(3.0, (0.0, 0.0), (0.1, 0.1)), "is 3 Pa"),
        (3e9, "reaches 3e+09 Pa"),
    ],
)
def test_pulls_in_other_units(scene: Callable[..., mtb.Scene], pull: Any, word: str) -> None:
    questions = asked(lambda: scene(magnetic_pressure=pull, velocity=1.0))
    assert len(questions) == 1
    assert word in questions[0]


def test_bodies_of_ones_own_are_asked_too() -> None:
    questions = asked(
        lambda: mtb.Scene(
            upper=pad(mtb.Material(210e3, 0.3)), lower=mtb.steel, spacing=5e-3, magnetic_pressure=3.0
        )
    )
    assert len(questions) == 2


@pytest.mark.parametrize("scene", SCENES)
def test_a_copy_is_asked_about_what_is_new(scene: Callable[..., mtb.Scene]) -> None:
    stiff = mtb.Material(210e12, 0.3)
    with pytest.warns(UserWarning, match="upper body"):
        odd = scene(upper=stiff)
    assert asked(lambda: odd.with_(friction=0.1)) == []
    assert asked(lambda: odd.with_(spacing=2e-3)) == []
    (question,) = asked(lambda: odd.with_(lower=stiff))
    assert "lower body" in question


def test_a_body_that_deforms_by_more_than_small() -> None:
    soft = mtb.Material(2e6, 0.49)
    scene = mtb.scenes.block_on_plane(upper=soft, lower=soft, friction=0.1, spacing=0.025)
    for model in ("half-space", "elastic-upper"):
        questions = asked(lambda model=model: scene.solve(model))  # type: ignore[misc]
        assert [words.split(" deforms by")[0] for words in questions] == ["the upper body", "the lower body"]
    own = mtb.Scene(upper=pad(soft), lower=mtb.Rigid(), spacing=5e-3, force=1e3, friction=0.3)
    assert any("the upper body deforms by" in words for words in asked(own.solve))


def test_pressure_beyond_what_steel_bears() -> None:
    # the peak grows with the third root of the force
    at = mtb.scenes.paraboloid_on_plane(radius=0.1, force=1e4, friction=0.0)
    peak = at.solve().report.peak_pressure
    for factor, count in ((0.9, 0), (1.1, 1)):
        scene = at.with_(force=1e4 * (factor * 4.2e9 / peak) ** 3)
        assert sum("GPa, beyond what steel" in words for words in asked(scene.solve)) == count
    hard = mtb.Material(700e9, 0.22)
    assert asked(at.with_(force=1e4 * (1.1 * 4.2e9 / peak) ** 3, upper=hard, lower=hard).solve) == []


@pytest.mark.parametrize(
    "material", [mtb.Material(1.0, 0.0), mtb.Material(1e5, 0.49), mtb.Material(1.2e12, 0.1), mtb.steel]
)
def test_normalised_units_gels_and_diamond_are_not_questioned(material: mtb.Material) -> None:
    for scene in PULLED:
        pull = 1e-3 if material.young_modulus == 1.0 else 2e3
        assert asked(lambda: scene(upper=material, lower=material, magnetic_pressure=pull)) == []  # noqa: B023
    x = np.linspace(-1.0, 1.0, 15)
    gap = (x[:, None] ** 2 + x**2) / 20.0
    force = 1e-3 * material.young_modulus
    assert (
        asked(mtb.Scene(upper=material, lower=mtb.Rigid(), gap=gap, spacing=x[1] - x[0], force=force).solve)
        == []
    )


@pytest.mark.parametrize("given", [3.0, (0.3, 3.0), np.full((6, 30), 30.0), [[0.3, 3.0], 4.0]])
def test_friction_that_no_pair_of_bodies_has(given: Any) -> None:
    table = [mtb.VelocityTable([0.0, 10.0], [0.3, 3.0])] if isinstance(given, float) else []
    for friction in (given, *table):
        (question,) = asked(
            lambda: mtb.scenes.pole_shoe_on_rail(friction=friction, velocity=1.0)  # noqa: B023
        )
        assert "friction reaches" in question
    for law in (
        lambda: mtb.Coulomb(30.0),
        lambda: mtb.FallingFriction(30.0, 0.2, 0.1),
        lambda: mtb.TabulatedFriction([0.0, 1.0], [30.0, 20.0]),
        lambda: mtb.RailFriction([0.0], [30.0]),
    ):
        (question,) = asked(law)
        assert "reaches 30" in question
    assert asked(lambda: mtb.Coulomb(2.0)) == []


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: mtb.scenes.pole_shoe_on_rail(height=28.2), "height is 28.2 m"),
        (lambda: mtb.scenes.pole_shoe_on_rail(length=9.0, rail_length=10.0), "length is 9 m"),
        (lambda: mtb.scenes.block_on_plane(width=100.0, length=1.0, height=1.0), "width is 100 m"),
        (lambda: mtb.scenes.paraboloid_on_plane(force=3e10), "force is 3e"),
        (lambda: mtb.hertz(36e3, 0.46, upper=mtb.Material(210e3, 0.3)), "young_modulus of the upper body"),
        (lambda: mtb.hertz(3e10, 0.46), "Hertz' theory holds"),
        (lambda: mtb.hertz(36e3, 460e-6), "Hertz' theory holds"),
        (lambda: mtb.RailFriction([-20.0, 15.0], [0.1, 0.4]), "rail_position reaches -20 m"),
    ],
)
def test_lengths_and_forces_in_other_units(make: Callable[[], Any], words: str) -> None:
    questions = asked(make)
    assert any(words in question for question in questions), questions


def test_small_scales_and_rough_surfaces_are_not_questioned() -> None:
    assert asked(lambda: mtb.hertz(1e-6, 1e-6)) == []
    assert asked(lambda: mtb.scenes.block_on_plane(1e-5, 1e-5, spacing=1e-6)) == []
    assert asked(lambda: mtb.scenes.paraboloid_on_plane(radius=1e-5, force=1e-6).solve()) == []
    heights = mtb.roughness(64, 1e-6, rms_height=1e-7, seed=2)
    gap = heights.max() - heights
    assert asked(mtb.Scene(mtb.steel, mtb.steel, gap=gap, spacing=1e-6, force=1e-2).solve) == []


@pytest.mark.parametrize("lower", [mtb.steel, mtb.Rigid()])
def test_a_shoe_is_small_in_its_height(lower: mtb.Material | mtb.Rigid) -> None:
    # its length is three times its height
    scene = mtb.scenes.pole_shoe_on_rail(
        friction=0.3, magnetic_pressure=1e6, spacing=12e-3, upper=mtb.Material(10e6, 0.49), lower=lower
    )
    (question,) = asked(lambda: scene.solve("elastic-upper"))
    assert "% of its height of" in question
    contacts: list[Any] = []
    (at_preparing,) = asked(lambda: contacts.append(scene.prepare("elastic-upper")))
    assert at_preparing == question
    # once, not at every step
    assert asked(lambda: contacts[0].step(velocity=1.0)) == []
    calm = scene.with_(magnetic_pressure=1e4).prepare("elastic-upper")
    assert asked(lambda: calm.step(velocity=1.0)) == []
    (in_a_step,) = asked(lambda: [calm.step(velocity=1.0, magnetic_pressure=1e6) for _ in range(2)])
    assert in_a_step.split(", ")[0] == question.split(", ")[0]
    stiffer = scene.with_(upper=mtb.Material(100e6, 0.49))
    assert asked(lambda: stiffer.solve("elastic-upper")) == []
    assert asked(lambda: stiffer.prepare("elastic-upper").step(velocity=1.0)) == []


@pytest.mark.parametrize("side", ["upper", "lower"])
@pytest.mark.parametrize("material", SLIPS)
def test_moduli_in_other_units_of_fields(material: mtb.Material, side: str) -> None:
    x = np.linspace(-8e-3, 8e-3, 41)
    gap = (x[None, :] ** 2 + x[:, None] ** 2) / 0.8
    bodies = {"upper": mtb.steel, "lower": mtb.steel, side: material}
    questions = asked(lambda: mtb.solve_normal(gap, 4e-4, **bodies, approach=1e-6))
    assert [f"young_modulus of the {side} body is" in words for words in questions] == [True]


def test_a_wheel_that_carries_nothing() -> None:
    (question,) = asked(lambda: mtb.scenes.wheel_on_rail(lateral=0.0, force=36.0, spacing=1e-4))
    assert "force is 36 N" in question


def test_a_wheel_that_has_climbed_the_rail() -> None:
    (question,) = asked(lambda: mtb.wheel_on_rail_gap(lateral=0.02, spacing=1e-3))
    assert "the flange has climbed the rail: the wheel stands 20.2 mm higher" in question
    assert "lateral = 0.02 m" in question
    # on the root of the flange, and half way up it
    for lateral in (6.2e-3, 0.01):
        assert asked(lambda at=lateral: mtb.wheel_on_rail_gap(lateral=at, spacing=1e-3)) == []  # type: ignore[misc]
    scene = mtb.scenes.wheel_on_rail(lateral=0.0)
    (further,) = asked(lambda: scene.with_(lateral=0.05))
    assert "lateral is 0.05 m: -0.04 to 0.03 m is usual" in further
    (other_side,) = asked(lambda: mtb.wheel_on_rail_gap(lateral=-0.05, spacing=1e-3))
    assert "lateral is -0.05 m" in other_side


@pytest.mark.coarse
def test_a_pressure_that_no_rail_bears() -> None:
    given = {"lateral": 7.5e-3, "spacing": 1e-3}
    questions = asked(lambda: mtb.scenes.wheel_on_rail(**given).solve())  # type: ignore[arg-type]
    assert len(questions) == 1
    assert "GPa, more than the hardness of rail steel (R260: up to 2.9" in questions[0]
    # harder questions come alone, and other materials flow elsewhere
    (harder,) = asked(lambda: mtb.scenes.wheel_on_rail(lateral=0.01, spacing=3e-4).solve())
    assert "hardened bearing steel" in harder
    soft = mtb.Material(young_modulus=205e9, poisson_ratio=0.3), mtb.Material(70e9, 0.3)
    assert asked(lambda: mtb.scenes.wheel_on_rail(upper=soft[0], lower=soft[1], **given).solve()) == []  # type: ignore[arg-type]


def _ball(cells: int, spacing: float, radius: float = 0.4) -> np.ndarray:
    x = (np.arange(cells) - 0.5 * (cells - 1)) * spacing
    return (x[None, :] ** 2 + x[:, None] ** 2) / (2.0 * radius)


#: Gap, spacing and force of what looks like a slip, and the words of the questions.
MISTAKEN = {
    "gap in mm": (
        (1e3 * _ball(40, 2e-4), 2e-4, 5e3),
        ["31.3 GPa, beyond what steel bears", "deforms"],
    ),
    "spacing in mm": ((_ball(40, 2e-4), 0.2, 5e3), []),
    "force in kN": ((_ball(40, 2e-4), 2e-4, 5.0), []),
    "small radius": ((_ball(80, 5e-5, 0.003), 5e-5, 2e4), ["GPa, beyond what steel bears", "deforms"]),
    "nothing": ((_ball(40, 2e-4), 2e-4, 5e3), []),
}


@pytest.mark.parametrize("slip", MISTAKEN)
@pytest.mark.coarse
def test_half_spaces_are_asked_about_as_scenes_are(slip: str) -> None:
    (gap, spacing, force), words = MISTAKEN[slip]
    steel: dict[str, Any] = {"lower": mtb.steel, "upper": mtb.steel}
    found: list[mtb.NormalResult] = []
    by_door = asked(lambda: found.append(mtb.solve_normal(gap, spacing, force=force, **steel)))
    by_scene = asked(lambda: mtb.Scene(**steel, gap=gap, spacing=spacing, force=force).solve())
    # once each, though the same contact may be solved many times inside
    assert len(by_door) == len(by_scene) == len({*by_door}) == len({*by_scene})
    for word in words:
        assert any(word in said for said in by_door), word
        assert any(word in said for said in by_scene), word
    assert bool(by_door) == bool(words)
    # what was asked about the pressure is not asked again, unless it is all that is given
    roll, law = mtb.Rolling(creepage=(1e-4, 0.0, 0.0)), mtb.Coulomb(0.3)
    assert asked(lambda: mtb.solve_tangential(found[0], roll, law)) == []
    field = mtb.PressureField(found[0].pressure, found[0].spacing, mtb.steel, mtb.steel)
    of_field = [said for said in by_door if "deforms" not in said]
    assert asked(lambda: mtb.solve_tangential(field, roll, law)) == of_field
    assert asked(lambda: mtb.creep_curve(field, [[1e-4, 0.0, 0.0]], law)) == of_field


def test_a_contact_of_two_points_tells_no_pressure() -> None:
    steel: dict[str, Any] = {"lower": mtb.steel, "upper": mtb.steel}
    for gap, spacing, force in ((_ball(40, 2e-4), 0.2, 5e3), (_ball(40, 2e-4), 2e-4, 5.0)):
        with pytest.warns(mtb.ToleranceWarning, match="only 2 points wide along x"):
            mtb.solve_normal(gap, spacing, force=force, **steel)
        with pytest.warns(mtb.ToleranceWarning, match="at most 2 points wide along x"):
            mtb.Scene(**steel, gap=gap, spacing=spacing, force=force).solve()


def test_rough_surfaces_touch_in_few_cells_without_a_question() -> None:
    heights = 1e-6 * np.cos(np.arange(16.0))[:, None] * np.cos(np.arange(16.0)) + 1e-6
    mtb.area_load_curve(heights, 1e-6, [1e-4, 1e-3], lower=mtb.steel, upper=mtb.Rigid())
    soft = mtb.Material(208e3, 0.3)
    with pytest.warns(UserWarning, match="only foam is so soft") as caught:
        mtb.area_load_curve(heights, 1e-6, [1e-9, 1e-8], lower=soft, upper=mtb.Rigid())
    assert len(caught) == 1


def test_closed_form_beyond_the_strength_of_steel_is_asked_about() -> None:
    with pytest.warns(UserWarning, match="beyond what steel bears"):
        mtb.hertz(2e5, 0.02)
