# SPDX-License-Identifier: MIT OR Apache-2.0
"""Where wear, heat, hardness and magnets end: refused by name, with the cause; and what they are read by."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import mtb_rs as mtb
from mtb_rs.case import case_from_words

HEIGHT = 28.2e-3


def shoe(**given: Any) -> mtb.Scene:
    return mtb.scenes.pole_shoe_on_rail(friction=0.3, spacing=12e-3, **given)


@pytest.mark.coarse
@pytest.mark.parametrize("model", ["half-space", "elastic-upper"])
def test_no_shoe_wears_by_more_than_its_height(model: Any) -> None:
    for contact, options in ((shoe(), {"model": model}), (shoe().prepare(model), {})):
        with pytest.raises(ValueError, match=r"more than the height .* of 0\.02\d+ m.*1e-07.*1/MPa"):
            mtb.wear(contact, 1e3, 1e-7, **options)
    found = mtb.wear(shoe(), 1e3, 1e-13, model=model)
    assert 0.0 < found.depth[0, -1] < HEIGHT
    with pytest.raises(ValueError, match="more than the height"):
        shoe().sliding_heat(10.0, 5, 20.0, wear=1e-7)


@pytest.mark.coarse
def test_half_spaces_without_a_height_wear_by_the_width_of_their_contact() -> None:
    x = (np.arange(15) - 7) * 1e-3
    gap = (x[None, :] ** 2 + x[:, None] ** 2) / 0.2
    scene = mtb.Scene(mtb.steel, mtb.steel, gap=gap, spacing=1e-3, force=100.0, friction=0.2)
    with pytest.raises(ValueError, match=r"more than the width of the contact of 0\.014 m"):
        mtb.wear(scene, 1e4, 1e-6)


@pytest.mark.coarse
def test_laws_that_add_material_are_refused_by_name() -> None:
    for name in ("law", "lower_law"):
        given: dict[str, Any] = {"law": 1e-13, name: -2e-13}
        with pytest.raises(ValueError, match=f"^{name} is -2e-13 1/Pa: a wear coefficient of at least 0"):
            mtb.wear(shoe(), 1.0, model="half-space", **given)

    def grows(rubbing: Any) -> float:
        return -2e-13

    why = r"the law of wear grows gives -2e-13 1/Pa at point 0"
    with pytest.raises(ValueError, match=why):
        mtb.wear(shoe(), 1.0, grows, model="half-space")
    with pytest.raises(ValueError, match=why):
        shoe().sliding_heat(1.0, 2, 1.0, wear=grows)
    with pytest.raises(ValueError, match=r"^wear is -2e-13 1/Pa"):
        mtb.brake(shoe(), 10.0, 1e4, wear=-2e-13)


@pytest.mark.coarse
@pytest.mark.parametrize("model", ["half-space", "elastic-upper"])
@pytest.mark.parametrize("friction", [0.0, 0.3])
def test_two_unequal_poles_near_their_hardness_are_said_to_be_overloaded(model: Any, friction: float) -> None:
    """Each pole is a body of its own: the one pulled more bears no more than hardness times its area."""
    hard = 3.05e6
    scene = shoe(hardness=hard, magnetic_pressure=[0.9 * hard, 1.0001 * hard]).with_(friction=friction)
    why = "the load is more than the contact bears: at a hardness of 3.05e\\+06 Pa"
    with pytest.raises(mtb.ResultantError, match=why):
        scene.solve(model)
    with pytest.raises(mtb.ResultantError, match=why):
        scene.prepare(model).step(velocity=1.0)
    with pytest.raises(mtb.ConvergenceError, match=why):
        mtb.wear(scene, 1.0, 1e-13, model=model)
    if model == "elastic-upper" and friction:
        with pytest.raises(mtb.ResultantError, match=why):
            scene.sliding_heat(1.0, 2, 1.0)
        with pytest.raises(mtb.ResultantError, match=why):
            mtb.brake(scene, 1.0, 1e3)
    # with friction also tilts are to be borne
    borne = scene.with_(magnetic_pressure=[0.5 * hard, 0.6 * hard]).solve(model)
    assert borne.report.converged
    assert borne.pressure.max() <= hard * (1.0 + 1e-9)


@pytest.mark.coarse
def test_a_metre_between_the_bodies_is_crossed() -> None:
    """A free body comes down from any height: the state is that of bodies that touch from the beginning."""
    x = (np.arange(21) - 10) * 5e-3
    bowl = (x[:, None] ** 2 + x[None, :] ** 2) / 2.0 / 5.0
    rough = mtb.RoughLayer.exponential(contact_pressure=1e8, length=1e-6)

    def of(height: float) -> mtb.Scene:
        magnet = mtb.Magnet(ampere_turns=4000.0, non_magnetic_gap=1e-3)
        return mtb.Scene(
            mtb.steel, mtb.steel, gap=bowl + height, spacing=5e-3, friction=0.3, magnetic_pressure=magnet,
            normal_layer=rough, hardness=3e7,
        )  # fmt: skip

    near, far = of(0.0).solve("half-space"), of(1.0).solve("half-space")
    assert far.pressure == pytest.approx(near.pressure, abs=1e-6 * near.pressure.max())
    assert far.approach == pytest.approx(near.approach + 1.0, abs=1e-12)
    step = of(0.0).prepare("half-space").step(velocity=1.0, gap=1.0)
    assert step.pressure == pytest.approx(near.pressure.ravel(), abs=1e-6 * near.pressure.max())


@pytest.mark.parametrize("name", ["magnetic_pressure", "friction", "gap", "hardness", "normal_layer"])
def test_masked_arrays_are_refused_wherever_fields_are(name: str) -> None:
    grid = np.ones((12, 12))
    masked = np.ma.masked_array(grid, mask=np.eye(12, k=1, dtype=bool))
    given: dict[str, Any] = {"gap": 0.0 * grid, "spacing": 5e-3, "magnetic_pressure": 1e6}
    with pytest.raises(ValueError, match=rf"^{name}\[0, 1\] is masked"):
        mtb.Scene(mtb.steel, mtb.steel, **given | {name: masked})
    with pytest.raises(ValueError, match=r"^value\[1\]\[0, 1\] is masked"):
        mtb.VelocityTable([0.0, 1.0], [grid, masked])
    # without anything below it a mask is none
    mtb.Scene(mtb.steel, mtb.steel, **given | {name: np.ma.masked_array(grid)})


@pytest.mark.coarse
def test_steps_below_the_thermal_limit_are_not_called_too_long() -> None:
    steel = mtb.Conductor(50.0, 7850.0, 450.0, expansion=1.2e-5)
    heat: dict[str, Any] = {"expansion": True, "lower": steel, "upper": steel}
    # every warning is an error
    slow = shoe().sliding_heat(20.0, 40, 0.01, **heat)
    assert slow.thermal_margin is not None
    assert slow.thermal_margin < 1.0
    assert slow.errors.max() > 0.25
    with pytest.warns(UserWarning, match="one of them has an error of .* times the thermal limit"):
        shoe().with_(friction=0.4, spacing=8e-3).sliding_heat(2.0, 4, 2.0, **heat)


@pytest.mark.coarse
@pytest.mark.parametrize("speed", [1e9, 1e3])
def test_speeds_of_waves_are_refused(speed: float) -> None:
    why = r"without inertia, which holds below about 9\d\d m/s, 0.3 of the speed of shear waves"
    with pytest.raises(ValueError, match=f"^speed is .*{why}"):
        mtb.brake(shoe(), speed, 1e4)
    with pytest.raises(ValueError, match=f"^velocity is .*{why}"):
        shoe().sliding_heat(1.0, 2, speed)


@pytest.mark.coarse
def test_a_sweep_changes_what_a_magnet_is_made_of(tmp_path: Path) -> None:
    magnet = {"ampere_turns": 3000.0, "non_magnetic_gap": 1e-3}
    words = {"scene": "pole_shoe_on_rail", "spacing": 12e-3, "magnetic_pressure": magnet}
    case = case_from_words(words | {"solve": {"model": "half-space"}})
    assert "magnetic_pressure.ampere_turns" in case.variables()
    assert case.argument("magnetic_pressure.ampere_turns", 4000.0) == 4000.0
    turns = [2000.0, 3000.0, 4000.0]
    table = mtb.sweep(case.scene(), {"magnetic_pressure.ampere_turns": turns}, model="half-space")
    assert table.units["magnetic_pressure.ampere_turns"] == "A"
    for k, given in enumerate(turns):
        one = case.scene().with_(magnetic_pressure=mtb.Magnet(given, 1e-3)).solve("half-space")
        assert table["normal_force"][k] == one.normal_force
    with pytest.raises(ValueError, match=r"did you mean 'magnetic_pressure\.ampere_turns'"):
        mtb.sweep(case.scene(), {"magnetic_pressure.ampere_turn": turns})


@pytest.mark.coarse
def test_heat_offers_what_it_holds() -> None:
    hot = shoe().sliding_heat(1.0, 3, 5.0, wear=1e-13)
    for word in ("wear", "wear_upper", "temperature_upper", "temperature_lower", "heat_flux_upper"):
        title = hot.plot(word).axes[0].get_title(loc="left")
        assert ("upper" if word != "temperature_lower" else "lower") in title


@pytest.mark.coarse
@pytest.mark.slow
def test_what_comes_back_equals_what_was_saved(tmp_path: Path) -> None:
    scene = shoe(velocity=2.0)
    results: list[Any] = [
        scene.solve("half-space"), scene.solve("elastic-upper"), scene.sliding_heat(1.0, 2),
        mtb.wear(scene, 1.0, 1e-13, model="elastic-upper"), mtb.brake(scene, 2.0, 1e4),
        scene.prepare("half-space").step(velocity=1.0),
        scene.start_of_sliding([1e-6, 2e-6], "half-space"),
    ]  # fmt: skip
    for k, result in enumerate(results):
        result.save(tmp_path / str(k))
        assert mtb.load(tmp_path / str(k)) == result, type(result).__name__
    assert mtb.load(tmp_path / "0") != results[1]


@pytest.mark.coarse
@pytest.mark.parametrize("model", ["half-space", "elastic-upper"])
def test_power_and_traction_are_read_where_they_are_derived(model: Any, tmp_path: Path) -> None:
    speed = 7.0
    scene = shoe(velocity=speed)
    found = scene.solve(model)
    step = scene.prepare(model).step(velocity=speed)
    assert found.friction_power == pytest.approx(speed * found.force[0], rel=1e-12)
    assert found.friction_power == pytest.approx(step.friction_power, rel=1e-9)
    assert found.totals()["friction_power"].unit == "W"
    # derived by the velocity it is the force
    assert found.derivative("friction_power", "velocity") == pytest.approx(found.force[0], rel=1e-9)
    assert shoe().solve(model).friction_power is None
    assert step.traction.shape == (3, step.pressure.size)
    size = np.abs(found.traction).max()
    assert step.traction == pytest.approx(found.traction.reshape(3, -1), abs=1e-9 * size)
    step.save(tmp_path / "step")
    assert np.array_equal(mtb.load(tmp_path / "step").traction, step.traction)


@pytest.mark.coarse
def test_a_scene_has_a_speed_and_slides_backwards_by_its_direction() -> None:
    """Before, `solve` slid forwards and a step backwards where the velocity of a scene was negative."""
    for given in (
        lambda: shoe(velocity=-20.0),
        lambda: shoe().with_(velocity=-1e-9),
        lambda: mtb.wear(shoe(velocity=20.0), mtb.Passages(10.0, 2, {"velocity": -20.0}), 1e-13),
    ):
        with pytest.raises(ValueError, match=r"a speed of at least 0 .* sliding_direction=\(-1, 0\)"):
            given()
    with pytest.raises(mtb.CaseError, match=r"velocity.*a speed of at least 0"):
        case_from_words({"scene": "pole_shoe_on_rail", "velocity": -20.0}).scene()
    turned = mtb.wear(shoe(velocity=20.0, sliding_direction=(-1, 0)), 10.0, 1e-13, model="half-space")
    back = mtb.Passages(10.0, 1, {"velocity": -20.0})
    stepped = mtb.wear(shoe(velocity=20.0).prepare("half-space"), back, 1e-13)
    size = turned.depths.max()
    assert stepped.depths[0, -1] == pytest.approx(turned.depths[0, -1], abs=1e-10 * size)
    assert turned.forces[-1, 0] < 0.0


@pytest.mark.coarse
def test_passages_that_do_not_slide_do_not_wear() -> None:
    still = mtb.Passages(10.0, 2, {"sliding_direction": None})
    for scene, duty in ((shoe(sliding_direction=None), 10.0), (shoe(), [10.0, still])):
        with pytest.raises(ValueError, match="sliding_direction is None: nothing slides, so nothing wears"):
            mtb.wear(scene, duty, 1e-13, model="half-space")  # type: ignore[arg-type]


def test_a_stop_that_would_never_end_is_refused() -> None:
    with pytest.raises(ValueError, match=r"mass is 1e\+30 kg: .* would stand after .* s, and at most 1e\+05"):
        mtb.brake(shoe(), 20.0, 1e30)


@pytest.mark.coarse
def test_expansion_above_a_prism_takes_a_rail_that_does_not_expand() -> None:
    rail, cold = mtb.Prism("60E1"), mtb.Conductor(50.0, 7850.0, 450.0)
    scene = shoe(lower=rail)
    with pytest.raises(ValueError, match=r"the lower conductor expands: .* a Conductor without expansion"):
        scene.sliding_heat(0.2, 2, 1.0, expansion=True)
    hot = scene.sliding_heat(0.2, 4, 1.0, expansion=True, lower=cold, wear=1e-13)
    assert np.abs(hot.openings[-1]).max() > 0.0
    # the same gaps, solved without heat
    contact = scene.prepare("elastic-upper")
    for k, pressure in enumerate(hot.pressures):
        step = contact.step(velocity=1.0, gap=hot.depths[k] + hot.openings[k])
        assert step.pressure == pytest.approx(pressure, abs=1e-9 * pressure.max())
    assert hot.heats_upper + hot.heats_lower == pytest.approx(hot.friction_powers, rel=1e-12)
