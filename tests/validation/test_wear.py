# SPDX-License-Identifier: MIT OR Apache-2.0
"""Wear against closed forms, eigenvalues and its own account; the step by step rule is tested in Rust."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh
from numpy.typing import NDArray

import mtb_rs as mtb
from mtb_rs.commands import main

Array = NDArray[np.float64]

#: m/m per Pa
WEAR = 1e-13
#: Of the ready shoe [m].
LENGTH = 90e-3


def ball(points: int, width: float, radius: float, **given: Any) -> mtb.Scene:
    """A paraboloid on a half-space, one of the two rigid."""
    x = (np.arange(points) - (points - 1) / 2) * width / points
    given = {"upper": mtb.Rigid(), "lower": mtb.steel, "friction": 0.0} | given
    return mtb.Scene(gap=(x[None] ** 2 + x[:, None] ** 2) / (2.0 * radius), spacing=width / points, **given)


def shoe(**given: Any) -> mtb.Scene:
    return mtb.scenes.pole_shoe_on_rail(**{"spacing": 6e-3} | given)


def test_a_worn_pin_has_the_flat_of_archard() -> None:
    """Once wear is far more than the approach, a^4 = 4 R kappa F s / pi, and the pressure is even."""
    radius, force = 0.05, 500.0
    scene = ball(36, 10e-3, radius, force=force)
    width = 4.2e-3
    distance = np.pi * width**4 / (4.0 * radius * WEAR * force)
    found = mtb.wear(scene, distance, WEAR, tolerance=0.02)
    flat = np.sqrt(found.area[found.pressure > 0.0].sum() / np.pi)
    assert flat == pytest.approx(width, rel=0.02)
    inside = np.hypot(*found.points[:2]) < 0.8 * width
    assert found.pressure[inside] == pytest.approx(force / (np.pi * width**2), rel=0.04)
    # the elastic approach is a small part of what was worn
    assert found.depth[0, -1] > 20.0 * force / (2.0 * width * 2.3e11)


def test_fretting_ends_at_the_shape_of_popov() -> None:
    """Only what slips is worn, until it carries nothing more [Popov2014]; the error falls with the cells."""
    radius, approach, stick = 0.5, 2e-6, 0.6e-3
    errors = []
    for points in (32, 48):
        scene = ball(points, 2.6e-3, radius, approach=approach)
        r = np.hypot(*scene.geometry.grid(scene.known_spacing).points[:2])
        found = mtb.wear(scene, 10.0, mtb.Archard(np.where(r < stick, 0.0, WEAR)))
        # the circle of as large an area as the cells that stick
        c = np.sqrt(np.count_nonzero(r < stick) * found.area[0] / np.pi)
        shape = r**2 / (2.0 * radius) * np.arcsin(np.minimum(c / r, 1.0)) + approach * np.arccos(
            np.minimum(c / r, 1.0)
        )
        shape -= c / (2.0 * radius) * np.sqrt(np.maximum(r**2 - c**2, 0.0))
        worn = found.initial_gap + found.depths[0, -1]
        # the pressure at the edge of what sticks is singular, and cells see it as far as some of them reach
        outside = (r > 1.5 * c) & (found.depths[0, -1] > 0.0)
        assert np.count_nonzero(outside) > 200
        errors.append(np.abs(worn / (2.0 / np.pi * shape) - 1.0)[outside].max())
        carried = found.pressure * found.area
        assert carried[outside].sum() < 1e-6 * carried.sum()
    assert errors[1] < 0.01
    assert errors[1] < 0.8 * errors[0]


@pytest.mark.coarse
@pytest.mark.parametrize("given", [{"friction": 0.3}, {"poles": 1}, {"attraction": "both", "friction": 0.1}])
def test_what_is_worn_is_the_law_integrated(given: dict[str, Any]) -> None:
    scene = shoe(**given)
    found = mtb.wear(scene, [mtb.Passages(20.0, 3, {"velocity": 5.0}), 30.0], WEAR, 0.2 * WEAR)
    work = np.cumsum(found.steps * (found.unknowns @ found.area))
    np.testing.assert_allclose(found.worn_volume[0], WEAR * work, rtol=1e-12)
    assert found.distance == pytest.approx(np.cumsum(found.steps), rel=1e-12)
    assert found.distance[-1] == pytest.approx(90.0, rel=1e-12)
    # one place of the rail sees a shoe's length of each passage
    passing = found.distance <= 60.0 * (1.0 + 1e-12)
    for grid in found.patches:
        depth = grid.view(found.depths[1])[passing]
        assert np.ptp(depth, axis=-1).max() <= 1e-15
        step = found.steps[passing, None, None] * grid.view(found.unknowns)[passing]
        width = grid.view(found.area) / grid.view(found.area).sum(axis=1, keepdims=True) * LENGTH
        wanted = 0.2 * WEAR * (np.cumsum(step, axis=0) * width).sum(axis=-1) / 20.0
        np.testing.assert_allclose(depth[..., 0], wanted, rtol=1e-12)
    # and all of the plain distance
    last = found.depths[1, -1] - found.depths[1, passing][-1]
    step = found.steps[~passing, None] * found.unknowns[~passing]
    np.testing.assert_allclose(last, 0.2 * WEAR * step.sum(axis=0), rtol=1e-9, atol=1e-18)


@pytest.mark.coarse
@pytest.mark.parametrize("friction", [0.0, 0.25])
def test_the_worn_state_is_reached_at_the_rates_of_the_matrix(friction: float) -> None:
    """In full contact the pressures approach the worn-in state as exp(-kappa s / lambda), with eigenvalues
    lambda of the influence matrix on pressures that leave the load as it is."""
    contact = shoe(friction=friction, spacing=8e-3).prepare("elastic-upper")
    worn = mtb.wear(contact, 5e4, WEAR).depths[0, -1]
    base = contact.step(gap=worn).state.pressure
    assert (base > 0.0).all()
    size = 1e-9
    unit = np.eye(base.size)
    # changes of the pressure by the gaps: minus the inverse of the influence on pressures that keep the load
    inverse = -np.array([contact.step(gap=worn + size * e).state.pressure - base for e in unit]).T / size
    rates, vectors = np.linalg.eig(inverse)
    moving = np.flatnonzero((np.abs(rates.imag) == 0.0) & (rates.real > 1e-6 * rates.real.max()))
    order = moving[np.argsort(rates.real[moving])]
    for k in order[[0, 1, len(order) // 2, -1]]:
        wave = size * vectors[:, k].real / np.abs(vectors[:, k]).max()
        length = 0.7 / (WEAR * rates.real[k])
        before = contact.step(gap=worn + wave).state.pressure - base
        after = contact.step(gap=worn + wave, diagonal=WEAR * length).state.pressure
        rest = contact.step(gap=worn, diagonal=WEAR * length).state.pressure
        np.testing.assert_allclose(after - rest, before / 1.7, atol=1e-5 * np.abs(before).max())


@pytest.mark.coarse
def test_a_shoe_is_even_after_few_steps_which_cost_a_solve_each() -> None:
    found = mtb.wear(shoe(friction=0.0), 1e4, WEAR, uniformity=0.9)
    assert found.uniformity[-1] >= 0.9 > found.uniformity[0]
    assert len(found.steps) - 1 <= 30
    whole = mtb.wear(shoe(friction=0.0), 1e4, WEAR)
    assert whole.uniformity[-1] > 0.999
    # but for the search for the first length
    assert whole.solves[2:].max() <= 2
    assert len(whole.steps) - 1 <= 40


@pytest.mark.coarse
@pytest.mark.parametrize("model", ["half-space", "elastic-upper", "elastic-both"])
def test_a_scene_and_its_prepared_contact_wear_alike(model: Any) -> None:
    scene = shoe(friction=0.2, velocity=5.0)
    one = mtb.wear(scene, 50.0, WEAR, model=model)
    other = mtb.wear(scene.prepare(model), 50.0, WEAR)
    np.testing.assert_allclose(one.depths, other.depths, atol=1e-7 * one.depths.max())
    assert one.final is not None
    # the worn contact itself has the pressure of the last step
    np.testing.assert_allclose(one.final.pressure.reshape(-1), one.pressure, atol=1e-7 * one.pressure.max())


@pytest.mark.coarse
def test_depths_keep_to_the_tolerance_of_their_steps() -> None:
    scene = shoe(friction=0.3)
    fine = mtb.wear(scene, 1.0, WEAR, tolerance=1e-3)
    for tolerance in (0.2, 0.05):
        rough = mtb.wear(scene, 1.0, WEAR, tolerance=tolerance)
        error = rough.depths[0, -1] - fine.depths[0, -1]
        size = fine.area @ fine.depths[0, -1] ** 2
        assert (fine.area @ error**2 / size) ** 0.5 < tolerance


LAWS: dict[str, Any] = {
    "number": WEAR,
    "place": lambda rubbing: WEAR * (1.0 + 3.0 * rubbing.points[0]),
    "map": mtb.WearMap.of_wheel_steel(3e9),
    "energy": mtb.EnergyWear.of_wheel_steel(),
    "function": lambda rubbing: WEAR * (1.0 + rubbing.pressure / 5e6) * (1.0 + 0.1 * rubbing.speed),
}


@pytest.mark.coarse
@pytest.mark.parametrize("name", LAWS)
def test_any_law_wears_by_what_it_says(name: str) -> None:
    scene = shoe(friction=0.3, velocity=0.5)
    found = mtb.wear(scene, 20.0, LAWS[name], tolerance=0.01)
    law = mtb.friction.wear_laws.as_wear_law("law", LAWS[name])
    n = found.area.size
    # the law under the pressures after each step, integrated along the way
    total = np.zeros(n)
    for length, pressure in zip(found.steps, found.unknowns, strict=True):
        rubbing = mtb.Rubbing(pressure, np.full(n, 0.3), np.ones(n), 0.5, found.points)
        total += length * law.coefficient(rubbing) * pressure
    assert np.abs(found.depths[0, -1] - total).max() <= 0.01 * total.max()
    assert found.depths[1].max() == 0.0


def test_laws_are_those_of_their_sources() -> None:
    def at(law: Any, pressure: float, speed: float = 1.0, friction: float = 0.3) -> float:
        one = np.ones(1)
        rubbing = mtb.Rubbing(pressure * one, friction * one, one, speed, np.zeros((3, 1)))
        return float(law.coefficient(rubbing)[0])

    assert mtb.Archard.of_hardness(5e-4, 2.5e9).wear_coefficient == pytest.approx(2e-13)
    steel = mtb.WearMap.of_wheel_steel(3e9)
    for speed, pressure, k in ((0.1, 1e9, 5e-4), (0.5, 1e9, 35e-4), (2.0, 1e9, 5e-4), (2.0, 2.5e9, 350e-4)):
        assert at(steel, pressure, speed) == pytest.approx(k / 3e9)
    energy = mtb.EnergyWear.of_wheel_steel(7850.0)
    # micrograms per metre and mm2 are 1e-3 kg/m3
    for density, rate in ((5.2e6, 27.5), (40e6, 55.0), (87.2e6, 55.0 + 619.0)):
        pressure = density / 0.3
        assert at(energy, pressure) * pressure == pytest.approx(1e-3 * rate / 7850.0)
    assert at(energy, 0.0) == pytest.approx(1e-3 * 55.0 / 10.4e6 / 7850.0 * 0.3)


@pytest.mark.coarse
def test_profiles_go_out_and_come_back(tmp_path: Path) -> None:
    scene = shoe(friction=0.2)
    found = mtb.wear(scene, mtb.Passages(0.5, 4), 2e-12, 20e-12)
    rail = found.profile("lower")
    y = np.linspace(-0.03, 0.03, 61)
    worn = mtb.Profile.standard("60E1").height(y) - rail.height(y)
    assert worn.max() == pytest.approx(found.depth[1, -1], rel=0.05)
    # nothing is worn beside the shoe
    assert np.abs(worn[np.abs(y) < 5e-3]).max() < 0.02 * worn.max()
    rail.to_file(tmp_path / "worn.prr")
    again = mtb.Profile.from_file(tmp_path / "worn.prr")
    assert again.height(y) == pytest.approx(rail.height(y), abs=1e-9)
    # and a scene takes it
    other = mtb.scenes.pole_shoe_on_rail(spacing=6e-3, rail=again, conforming_to=25e-3)
    assert other.solve("half-space").normal_force > 0.0
    sole = found.profile("upper", patch="right")
    assert sole.range[1] < 0.0
    with pytest.raises(ValueError, match="patch is 'middle': one of left, right is needed"):
        found.profile("upper", patch="middle")
    with pytest.raises(ValueError, match="no rail"):
        mtb.wear(ball(12, 10e-3, 0.05, force=10.0), 1.0, WEAR).profile()


@pytest.mark.coarse
@pytest.mark.parametrize("model", ["elastic-upper", "half-space"])
@pytest.mark.parametrize("passages", [50, 10_000])
def test_the_rail_below_a_symmetric_shoe_is_symmetric_and_loses_what_the_law_takes(
    model: Any, passages: int
) -> None:
    law, length = 2e-14, 0.2
    scene = mtb.scenes.pole_shoe_on_rail(friction=0.2, velocity=20.0, spacing=8e-3)
    found = mtb.wear(scene, [mtb.Passages(length, passages)], 1e-15, law, model=model)
    y = np.linspace(-30e-3, 30e-3, 60_001)
    # a smooth line through the points of the new rail, which the worn one starts from
    new, worn = (each.profile("lower") for each in (found.history()[0], found))
    lost, depth = new.height(y) - worn.height(y), found.depth[1, -1]
    assert lost == pytest.approx(lost[::-1], abs=1e-6 * depth)
    # nothing is higher than before, and no place deeper than the law wears, seen from above
    assert lost.min() > -1e-3 * depth
    slope = np.abs(mtb.Profile.standard("60E1").slope(21.6e-3))
    assert lost.max() < 1.002 * depth * np.hypot(1.0, slope)
    # every passage takes law times the load; the walls take half a depth times their width, of four edges
    pressed = found.pressures[-1] @ found.area
    taken = law * passages * pressed
    walls = 4 * 0.5 * depth * max(50e-6, 2.0 * depth)
    assert np.trapezoid(lost, y) == pytest.approx(taken + walls, rel=2e-3)
    # and a scene takes it, on which the shoe stands as evenly
    again = mtb.scenes.pole_shoe_on_rail(friction=0.2, velocity=20.0, spacing=8e-3, rail=worn)
    pressure, (_, across, _) = again.solve(model).pressure, found.points
    left, right = (float((pressure * found.area)[side].sum()) for side in (across > 0.0, across < 0.0))
    assert left == pytest.approx(right, rel=1e-9)


def test_a_turned_shoe_has_no_profiles(tmp_path: Path) -> None:
    """A mean along its turned rows is none along the track."""
    turned = mtb.wear(shoe(yaw=0.02, poles=1, rail_length=0.4), 0.5, 1e-12, 1e-12, model="half-space")
    for body in ("lower", "upper"):
        with pytest.raises(ValueError, match="along x: the upper body must not be turned"):
            turned.profile(body)  # type: ignore[arg-type]
    # what the profile of one that is not turned takes off is the volume over its length
    found = mtb.wear(shoe(poles=1), 5.0, 1e-12, 1e-12, model="half-space")
    new, worn = (each.profile(interpolation="linear") for each in (found.history()[0], found))
    y = np.linspace(-30e-3, 30e-3, 60001)
    section = np.trapezoid(new.height(y) - worn.height(y), y)
    assert section * LENGTH == pytest.approx(found.worn_volume[1, -1], rel=0.01)
    (tmp_path / "case.toml").write_text(
        'scene = "pole_shoe_on_rail"\nyaw = 0.02\npoles = 1\nrail_length = 0.4\nspacing = 6e-3\n'
        '[solve]\nmodel = "half-space"\n[wear]\ndistance = 0.5\nlaw = 1e-12\n'
    )
    assert main(["wear", str(tmp_path / "case.toml"), "-o", str(tmp_path / "out")]) == 0
    assert (tmp_path / "out" / "wear.csv").exists()
    assert not list((tmp_path / "out").glob("*.prr"))


@pytest.mark.coarse
def test_life_is_where_the_depth_is_reached() -> None:
    found = mtb.wear(shoe(friction=0.2), 1e3, WEAR)
    for share in (0.3, 1.0):
        limit = share * found.depth[0, -1]
        distance = found.life(limit)
        assert np.interp(distance, found.distance, found.depth[0]) == pytest.approx(limit)
    # worn in, it goes on evenly
    assert found.life(10.0 * found.depth[0, -1]) == pytest.approx(1e4, rel=1e-3)
    stopped = mtb.wear(shoe(friction=0.2), 1e3, WEAR, limit=found.depth[0, -1] / 3.0)
    assert stopped.depth[0, -1] >= found.depth[0, -1] / 3.0 > stopped.depth[0, -2]
    assert np.isinf(found.life(1e-6, "lower"))


@pytest.mark.coarse
def test_a_wear_goes_on_where_it_was_stopped(tmp_path: Path) -> None:
    scene, file = shoe(friction=0.2), tmp_path / "wear.jsonl"
    duty = [mtb.Passages(10.0, 5), 20.0]
    whole = mtb.wear(scene, duty, WEAR, WEAR)

    class Stop(Exception):
        pass

    shares: list[float] = []

    def stop(share: float) -> None:
        shares.append(share)
        if len(shares) == 9:
            raise Stop

    with pytest.raises(Stop):
        mtb.wear(scene, duty, WEAR, WEAR, checkpoint=file, progress=stop)
    assert shares == sorted(shares)
    rest: list[float] = []
    again = mtb.wear(scene, duty, WEAR, WEAR, checkpoint=file, progress=rest.append)
    assert rest[0] > shares[-1]
    assert rest[-1] == pytest.approx(1.0)
    np.testing.assert_allclose(again.depths[:, -1], whole.depths[:, -1], rtol=1e-6, atol=1e-15)
    with pytest.raises(ValueError, match="checkpoint of another wear"):
        mtb.wear(scene, duty, 2.0 * WEAR, checkpoint=file)


@pytest.mark.coarse
def test_wear_is_refused_where_it_has_no_meaning() -> None:
    scene = shoe()
    contact = scene.prepare("half-space")
    cases: list[tuple[Any, Any, Any, dict[str, Any], str]] = [
        (mtb.scenes.wheel_on_rail(), 1.0, WEAR, {}, "wear_depth"),
        (3.0, 1.0, WEAR, {}, "a Scene or a PreparedContact is needed"),
        (scene, -1.0, WEAR, {}, "distance is -1"),
        (scene, [], WEAR, {}, "distance is empty"),
        (scene, 1.0, -WEAR, {}, "law is -1e-13 1/Pa: a wear coefficient"),
        (scene, 1.0, "steel", {}, "law is 'steel'"),
        (scene, 1.0, mtb.Archard(np.ones(3)), {}, "one for each of"),
        (scene, 1.0, mtb.WearMap.of_wheel_steel(3e9), {}, "give the velocity"),
        (scene, 1.0, lambda rubbing: np.ones(3), {}, r"returned shape \(3,\)"),
        (scene, 1.0, lambda rubbing: -WEAR, {}, "at least 0 are needed"),
        (scene, 1.0, lambda rubbing: np.nan, {}, "finite"),
        (scene, 1.0, WEAR, {"tolerance": 2.0}, "tolerance is 2"),
        (scene, 1.0, WEAR, {"uniformity": 1.5}, "uniformity is 1.5"),
        (scene, 1.0, WEAR, {"limit": 0.0}, "limit is 0"),
        (scene, [1.0, mtb.Passages(1.0, 1, {"spacing": 9e-3})], WEAR, {}, "part 2 of the duty has other"),
        (scene.with_(yaw=0.02), mtb.Passages(1.0), WEAR, {}, "along x"),
        (scene.with_(sliding_direction=(0.0, 1.0)), mtb.Passages(1.0), WEAR, {}, "along x"),
        (contact, mtb.Passages(1.0, 1, {"friction": 0.3}), WEAR, {}, "take velocity and magnetic_pressure"),
        (contact, 1.0, WEAR, {"model": "half-space"}, "a prepared contact has its model"),
    ]
    for given, distance, law, options, words in cases:
        with pytest.raises(ValueError, match=words):
            mtb.wear(given, distance, law, **options)
    for wrong in ({"distance": 0.0}, {"distance": 1.0, "count": -1.0}, {"distance": 1.0, "changes": 3}):
        with pytest.raises(ValueError, match="is"):
            mtb.Passages(**wrong)  # type: ignore[arg-type]


@pytest.mark.coarse
def test_results_of_wear_are_kept_and_drawn(tmp_path: Path) -> None:
    found = mtb.wear(shoe(friction=0.2), mtb.Passages(5.0, 4), WEAR, WEAR)
    found.save(tmp_path / "out")
    again = mtb.load(tmp_path / "out")
    assert isinstance(again, mtb.WearResult)
    for name in ("depths", "pressures", "distance", "forces", "points"):
        np.testing.assert_array_equal(getattr(again, name), getattr(found, name))
    assert again.profile("lower") == found.profile("lower")
    for quantity in ("depth", "worn_volume", "uniformity", "peak_pressure"):
        assert again.plot(quantity).axes[0].lines
    found.plot("wear", body="upper")
    assert mtb.animate(found.history()[::6], tmp_path / "wear.gif").exists()
    with pytest.raises(ValueError, match="a line over the distance"):
        found.plot("depth", "3d")
    # what is over the distance and what is of the last state, in one list
    with pytest.raises(ValueError, match=r"quantity is 'depht': one of depth, worn_volume, .* pressure, "):
        found.plot("depht")


def test_pictures_of_wear_show_what_wears_and_whole_lines() -> None:
    found = mtb.wear(shoe(poles=1, friction=0.0), 1e4, WEAR, model="half-space")
    for quantity, options in (("pressure", {"kind": "line", "x": 0.0}), ("peak_pressure", {}), ("depth", {})):
        axes = found.plot(quantity, **options).axes[0]
        largest = max(float(np.max(line.get_ydata())) for line in axes.lines)
        assert axes.get_ylim()[0] == 0.0
        assert axes.get_ylim()[1] >= 1.04 * largest
    assert f"{1e3 * found.depth[0, -1]:.3g} mm" in found.plot("wear").axes[0].get_title(loc="left")
    assert "0 everywhere" in found.plot("wear", body="lower").axes[0].get_title(loc="left")


@pytest.mark.filterwarnings("ignore:friction reaches")
def test_a_contact_that_does_not_slide_says_so() -> None:
    wedged = mtb.scenes.pole_shoe_on_rail(spacing=8e-3, friction=0.3).with_(friction=40.0)
    with pytest.raises(mtb.ConvergenceError, match="after 0 m of sliding there is no state of contact"):
        mtb.wear(wedged, 1.0, WEAR, model="elastic-upper")


def hill(cells: int) -> mtb.PressureField:
    """An ellipsoid of pressure on half axes of 5 and 4 mm."""
    x = (np.arange(cells) + 0.5) / cells * 2.4 - 1.2
    inside = np.sqrt(np.maximum(0.0, 1.0 - x[None] ** 2 - x[:, None] ** 2))
    return mtb.PressureField(8e8 * inside, (12e-3 / cells, 9.6e-3 / cells), mtb.steel, mtb.steel)


def rolling(**given: Any) -> mtb.TangentialResult:
    return mtb.solve_tangential(hill(24), mtb.Rolling(**{"velocity": 20.0} | given), mtb.Coulomb(0.3))


def test_a_pass_of_rolling_wears_the_work_of_friction() -> None:
    """Without spin the heat is force times creepage, so that Archard wears kappa / mu times that volume."""
    for creepage in ((1e-3, 0.0, 0.0), (5e-3, 2e-3, 0.0)):
        found = rolling(creepage=creepage)
        width = float(found.points[1, 1, 0] - found.points[1, 0, 0])
        worn = found.wear_depth(WEAR).sum() * width
        work = abs(found.force[:2] @ np.array(creepage[:2]))
        assert worn == pytest.approx(WEAR / 0.3 * work, rel=1e-8)
        wheel = found.wear_depth(mtb.Archard(WEAR), wheel_radius=0.46)
        np.testing.assert_allclose(wheel * 2.0 * np.pi * 0.46, found.wear_depth(WEAR))
    # the energy law wears as fast where its table is a line
    line = mtb.EnergyWear([0.0, 1e9], [0.0, 1e9 * WEAR / 0.3 * 7850.0], 7850.0)
    np.testing.assert_allclose(found.wear_depth(line), found.wear_depth(WEAR), rtol=1e-9)
    assert found.wear_depth(mtb.WearMap.of_wheel_steel(3e9)).max() > 0.0
    shifted = mtb.solve_tangential(hill(16), mtb.Shift((1e-6, 0.0)), mtb.Coulomb(0.3))
    with pytest.raises(ValueError, match="a shift passes over nothing"):
        shifted.wear_depth(WEAR)


def test_a_wheel_wears_by_its_heat() -> None:
    step = mtb.scenes.wheel_on_rail(spacing=0.5e-3, friction=0.3).prepare().step(velocity=20.0)
    assert isinstance(step, mtb.WheelStep)
    for patch in step.patches:
        width = float(patch.y[1] - patch.y[0])
        worn = patch.wear_depth(WEAR).sum() * width
        heat = float(patch.dissipation.sum()) * patch.area / abs(patch.rolling_speed)
        assert worn == pytest.approx(WEAR / 0.3 * heat, rel=1e-6)


def test_a_case_wears(tmp_path: Path) -> None:
    words = (
        'scene = "pole_shoe_on_rail"\nspacing = 8e-3\nfriction = 0.2\nvelocity = 5.0\n'
        '[solve]\nmodel = "half-space"\n[wear]\nlower_law = {k = 1e-4, hardness = 3e9}\nlaw = 1e-13\n'
    )
    file = tmp_path / "case.toml"
    file.write_text(words + "passages = [{distance = 20.0, count = 3}, {distance = 5.0, velocity = 2.0}]\n")
    case = mtb.load_case(file)
    found = case.solve()
    assert isinstance(found, mtb.WearResult)
    shoe = mtb.scenes.pole_shoe_on_rail(spacing=8e-3, friction=0.2, velocity=5.0)
    duty = [mtb.Passages(20.0, 3), mtb.Passages(5.0, 1, {"velocity": 2.0})]
    own = mtb.wear(shoe, duty, WEAR, mtb.Archard.of_hardness(1e-4, 3e9), model="half-space")
    np.testing.assert_array_equal(found.depths, own.depths)
    for more, words_of in (
        ("", "one of distance"),
        ("distance = -1.0", "distance is -1"),
        ("distance = 1.0\nlimits = 1.0", "did you mean 'limit'"),
        ("distance = 1.0\n[rolling]\ncreepage = [1e-3, 0.0, 0.0]", "wear and a rolling or shift"),
        ("passages = [{count = 1}]", "a table with distance"),
    ):
        file.write_text(words + more)
        with pytest.raises(mtb.CaseError, match=words_of):
            mtb.load_case(file)


@pytest.mark.filterwarnings("ignore::mtb_rs.PictureWarning")
def test_a_sole_of_one_row_has_no_profile_and_its_rail_has(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file, out = tmp_path / "case.toml", tmp_path / "out"
    scene = 'scene = "pole_shoe_on_rail"\nspacing = 12e-3\n[solve]\nmodel = "half-space"\n'
    file.write_text(scene + "[wear]\ndistance = 10.0\nlaw = 1e-13\n")
    assert main(["wear", str(file), "-o", str(out)]) == 0
    capsys.readouterr()
    assert (out / "rail.prr").exists()
    assert not list(out.glob("sole_*.prr"))
    worn = mtb.load(out)
    assert isinstance(worn, mtb.WearResult)
    with pytest.raises(ValueError, match=r"sole left is one row of contact points wide, spacing 0"):
        worn.profile("upper", patch="left")


@pytest.mark.filterwarnings("ignore::mtb_rs.PictureWarning")
def test_the_command_wears_and_goes_on(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file, out = tmp_path / "case.toml", tmp_path / "out"
    scene = 'scene = "pole_shoe_on_rail"\nspacing = 8e-3\n[solve]\nmodel = "half-space"\n'
    file.write_text(scene + "[wear]\ndistance = 50.0\nlaw = 1e-13\n")
    assert main(["wear", str(file), "-o", str(out)]) == 0
    assert "worn off the upper body" in capsys.readouterr().out
    steps = (out / "wear.jsonl").read_bytes()
    rows = (out / "wear.csv").read_text().splitlines()
    assert len(rows) == len(mtb.load(out).distance) + 1  # type: ignore[union-attr]
    assert mtb.Profile.from_file(out / "rail.prr").height(0.0) == pytest.approx(0.0, abs=1e-9)
    assert main(["wear", str(file), "-o", str(out)]) == 0
    assert (out / "wear.jsonl").read_bytes() == steps
    file.write_text(scene)
    assert main(["wear", str(file), "-o", str(out)]) == 2
    assert "has no table [wear]" in capsys.readouterr().err


@pytest.mark.coarse
def test_a_gap_is_what_was_worn_before() -> None:
    """A contact that goes on wearing from its worn gap wears as one that was not stopped."""
    scene = shoe(friction=0.2)
    whole = mtb.wear(scene, 50.0, WEAR, model="half-space", tolerance=0.02)
    first = mtb.wear(scene, 20.0, WEAR, model="half-space", tolerance=0.02)
    rest = mtb.wear(scene, 30.0, WEAR, gap=first.depths[0, -1], model="half-space", tolerance=0.02)
    again = first.depths[0, -1] + rest.depths[0, -1]
    np.testing.assert_allclose(again, whole.depths[0, -1], atol=0.02 * again.max())
    np.testing.assert_allclose(rest.pressures[0], first.pressures[-1], atol=1e-7 * rest.pressures.max())
    with pytest.raises(ValueError, match="gap has 3 entries"):
        mtb.wear(scene, 1.0, WEAR, gap=np.zeros(3))
    with pytest.raises(ValueError, match="a prepared contact has the gap of its scene"):
        mtb.wear(scene.prepare("half-space"), 1.0, WEAR, gap=np.zeros(first.area.size))


@pytest.mark.parametrize("lower", [None, 1e-14])
@pytest.mark.parametrize("limit", [2e-5, 1e-4, 1e-3])
def test_wear_ends_at_its_limit(limit: float, lower: float | None) -> None:
    """However long the steps are by then, and where the way ends by what the rate is."""
    scene = shoe(spacing=12e-3)
    worn = mtb.wear(scene, 1e6, WEAR, lower, limit=limit)
    assert worn.depths[0, -1].max() == pytest.approx(limit, rel=1.1e-3)
    assert worn.distance[-1] == pytest.approx(worn.life(limit), rel=2e-3)
    through = mtb.wear(scene, 1.2 * float(worn.distance[-1]), WEAR, lower, tolerance=0.01)
    reached = np.interp(worn.distance[-1], through.distance, through.depths[0].max(axis=1))
    assert reached == pytest.approx(limit, rel=0.02)


@pytest.mark.parametrize(
    "stop", [{"limit": 1.2e-5}, {"uniformity": 0.9}, {"limit": 1.2e-5, "uniformity": 0.9}]
)
def test_a_checkpoint_that_went_further_does_not_pass_a_limit(stop: dict[str, float], tmp_path: Path) -> None:
    scene, file = shoe(spacing=12e-3, poles=1, friction=0.2), tmp_path / "wear.jsonl"
    duty = [50.0, mtb.Passages(50.0, 1, {"magnetic_pressure": 2e6})]
    through = mtb.wear(scene, duty, WEAR, checkpoint=file)
    written = file.read_bytes()
    kept = mtb.wear(scene, duty, WEAR, checkpoint=file, **stop)
    alone = mtb.wear(scene, duty, WEAR, **stop)
    assert kept.distance[-1] == pytest.approx(alone.distance[-1], rel=1e-6)
    np.testing.assert_allclose(kept.depths[:, -1], alone.depths[:, -1], rtol=1e-6, atol=1e-15)
    assert kept.distance[-1] < 0.5 * through.distance[-1]
    # the file is still that of the whole way, and the state at its end is that under the last part
    assert file.read_bytes() == written
    again = mtb.wear(scene, duty, WEAR, checkpoint=file)
    np.testing.assert_array_equal(again.depths, through.depths)
    for one, other in ((kept, alone), (again, through)):
        assert one.final is not None
        assert other.final is not None
        assert one.final.force == pytest.approx(other.final.force, rel=1e-6)


def test_passages_end_at_a_limit_too() -> None:
    parts = [mtb.Passages(300.0, 0.1), mtb.Passages(100.0, 200, {"magnetic_pressure": 2e6})]
    worn = mtb.wear(shoe(spacing=12e-3), parts, WEAR, 1e-14, limit=2e-5)
    assert worn.depths[0, -1].max() == pytest.approx(2e-5, rel=1.1e-3)
    assert worn.distance[-1] > 30.0


@pytest.mark.parametrize("spacing", [5e-3, 2.5e-3])
def test_passages_of_a_round_pin_wear_each_line_by_its_chord(spacing: float) -> None:
    """Under an even pressure, which a soft layer gives, a line is worn by law, pressure and chord."""
    pytest.importorskip("gmsh")
    radius, force, count = 20e-3, 1e4, 3
    cylinder = trimesh.creation.cylinder(radius=radius, height=0.02, sections=192)
    cylinder.apply_translation((0.0, 0.0, 0.01))
    held = mtb.Support("top", x=0, y=0, z=mtb.Guide())
    pin = mtb.ElasticBody.from_mesh(cylinder, mtb.steel, supports=[held], size=4e-3)
    scene = mtb.Scene(
        pin, mtb.steel, spacing=spacing, friction=0.0, force=force, sliding_direction=(1.0, 0.0),
        normal_layer=1e-9,
    )  # fmt: skip
    found = mtb.wear(scene, mtb.Passages(1.0, count), 0.0, 1e-18)
    rows = np.unique(found.points[1].round(9))
    depth = np.array([found.depths[1, -1][np.abs(found.points[1] - y) < 1e-9].max() for y in rows])
    # what is worn off all lines is the law times the load, and nothing beside the pin
    assert np.trapezoid(depth, rows) == pytest.approx(1e-18 * force * count, rel=1e-6)
    # lines are known by the means over the hats of their rows
    fine = np.linspace(-radius, radius, 20001)
    hats = np.maximum(1.0 - np.abs(fine - rows[:, None]) / spacing, 0.0)
    chord = hats @ (2.0 * np.sqrt(radius**2 - fine**2)) / hats.sum(axis=1)
    mean = 1e-18 * count * force / (np.pi * radius**2) * chord
    np.testing.assert_allclose(depth, mean, rtol=0.0, atol=0.02 * mean.max())


def test_tables_over_the_velocity_need_one() -> None:
    table = mtb.VelocityTable([1.0, 10.0, 30.0], [0.3, 0.2, 0.1])
    pull = mtb.Magnet(3000.0, 1e-3, speed_factor=mtb.VelocityTable([0.0, 50.0], [1.0, 0.5]))
    for given, message in (
        ({"friction": table}, "friction is a table"),
        ({"magnetic_pressure": pull}, "speed_factor is"),
    ):
        still = shoe(velocity=None, poles=1, **given)
        with pytest.raises(ValueError, match=f"{message} .*over velocity: give velocity"):
            mtb.wear(still, 1.0, WEAR, model="half-space")
        worn = mtb.wear(still, mtb.Passages(1.0, 1, {"velocity": 10.0}), WEAR, model="half-space")
        assert worn.forces[-1] == pytest.approx(
            still.with_(velocity=10.0).solve("half-space").force, rel=5e-3
        )


def test_what_cannot_wear_is_refused() -> None:
    with pytest.raises(ValueError, match=r"changes of Passages: with_\(speed=...\)"):
        mtb.wear(shoe(), [mtb.Passages(300.0, 50, {"speed": 3.0})], WEAR)
    with pytest.raises(ValueError, match="sliding_direction is None: nothing slides, so nothing wears"):
        mtb.wear(shoe().with_(sliding_direction=None), 10.0, WEAR)


@pytest.mark.parametrize("yield_stress", [80e6, 8e6])
def test_rolling_wears_through_a_yielding_layer_as_sliding_does(yield_stress: float) -> None:
    """Depth is pressure times slip, in full slip the load times the creepage, whatever the layer bears."""
    places = np.linspace(-6e-3, 6e-3, 40)
    x, y = np.meshgrid(places, places)
    step = float(places[1] - places[0])
    pressed = mtb.solve_normal((x**2 + y**2) / 0.8, step, lower=mtb.steel, upper=mtb.steel, force=20e3)
    layer = mtb.PlasticLayer(20e-6, 1e9, yield_stress)
    rolled = mtb.solve_tangential(pressed, mtb.Rolling((0.1, 0.0, 0.0)), mtb.Coulomb(0.3), layer)
    # the layer's own shear is a part of the creepage
    assert rolled.wear_depth(WEAR).sum() * step == pytest.approx(WEAR * 20e3 * 0.1, rel=0.01)
