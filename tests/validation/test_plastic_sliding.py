# SPDX-License-Identifier: MIT OR Apache-2.0
"""A yielding layer under bodies that slide, against closed forms, a solver of its own, and balances."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import mtb_rs as mtb
from mtb_rs.base.words import Model
from mtb_rs.case import case_from_words

Array = NDArray[np.float64]

RADIUS, WIDTH, FORCE, FRICTION = 0.1, 1.5e-3, 400.0, 0.8
#: Without a Poisson's ratio friction opens the gap most.
SOFT = mtb.Material(young_modulus=210e9, poisson_ratio=0.0)


def layer(strength: float, hardening: float = 0.0) -> mtb.PlasticLayer:
    return mtb.PlasticLayer(20e-6, 82e9, strength, hardening)


def ball(cells: int = 9, **given: Any) -> mtb.Scene:
    side = WIDTH / cells
    x = (np.arange(cells) - (cells - 1) / 2) * side
    gap = (x[None, :] ** 2 + x[:, None] ** 2) / (2.0 * RADIUS)
    bodies: dict[str, Any] = {"upper": mtb.Rigid(), "lower": SOFT, "force": FORCE, "friction": FRICTION}
    return mtb.Scene(**bodies | given, gap=gap, spacing=side)


def shoe(**given: Any) -> mtb.Scene:
    return mtb.scenes.pole_shoe_on_rail(friction=0.4, spacing=8e-3, **given)


def squares(cells: int, side: float) -> tuple[Array, Array]:
    """Displacement into a half-space by pressure and friction along x on squares [Johnson1985, 3.2, 3.6]."""
    x = np.arange(cells) * side
    apart = x[:, None] - x[None, :]
    dx, dy = apart[None, :, None, :], apart[:, None, :, None]
    h = 0.5 * side

    def love(x: Array, y: Array) -> Array:
        return x * np.arcsinh(y / np.abs(x)) + y * np.arcsinh(x / np.abs(y))

    def cerruti(x: Array, y: Array) -> Array:
        # its mixed derivative is x / (x^2 + y^2)
        return 0.5 * y * np.log(x**2 + y**2) + x * np.arctan(y / x)

    def of(part: Any) -> Array:
        total = part(dx + h, dy + h) - part(dx - h, dy + h) - part(dx + h, dy - h) + part(dx - h, dy - h)
        return np.asarray(total.reshape(cells**2, cells**2))

    nu, shear = SOFT.poisson_ratio, SOFT.young_modulus / (2.0 * (1.0 + SOFT.poisson_ratio))
    return (1.0 - nu) / (2.0 * np.pi * shear) * of(love), (1.0 - 2.0 * nu) / (4.0 * np.pi * shear) * of(
        cerruti
    )


def projected(strength: float, cells: int = 9) -> tuple[Array, Array]:
    """Pressure and friction by Gauss and Seidel, bisected over the approach until the force is carried."""
    side = WIDTH / cells
    x = (np.arange(cells) - (cells - 1) / 2) * side
    gap = ((x[None, :] ** 2 + x[:, None] ** 2) / (2.0 * RADIUS)).ravel()
    normal, along = squares(cells, side)
    low, high = 0.0, float(gap.max()) + FORCE * float(normal[0, 0]) / side**2
    pressure = np.zeros(gap.size)
    for _ in range(60):
        approach = 0.5 * (low + high)
        for _ in range(2000):
            before = pressure.copy()
            for i in range(gap.size):
                friction = np.minimum(FRICTION * pressure, strength)
                rest = normal[i] @ pressure + along[i] @ friction + gap[i] - approach
                pressure[i] = max(pressure[i] - rest / normal[i, i], 0.0)
            if np.abs(pressure - before).max() < 1e-13 * pressure.max():
                break
        low, high = (approach, high) if pressure.sum() * side**2 < FORCE else (low, approach)
    return pressure, np.minimum(FRICTION * pressure, strength)


@pytest.mark.coarse
@pytest.mark.parametrize("strength", [150e6, 400e6])
def test_against_a_solver_of_its_own(strength: float) -> None:
    pressure, friction = projected(strength)
    yields = friction >= strength
    assert 2 < yields.sum() < (pressure > 0.0).sum() - 2
    scene = ball(layer=layer(strength))
    for found in (scene.solve("half-space"), scene.prepare("half-space").step(velocity=1.0)):
        assert np.ravel(found.pressure) == pytest.approx(pressure, abs=1e-7 * pressure.max())
        assert np.ravel(found.traction[0]) == pytest.approx(friction, abs=1e-7 * pressure.max())
    status = scene.solve("half-space").status.ravel()
    assert np.array_equal(status == 3, yields)
    assert np.array_equal(status == 2, (pressure > 0.0) & ~yields)
    # the cap is felt: Coulomb's friction moves the pressure elsewhere
    other = ball().solve("half-space").pressure.ravel()
    assert np.abs(other - pressure).max() > 1e-3 * pressure.max()


@pytest.mark.coarse
@pytest.mark.parametrize("strength", [1e5, 1.2e6, 3e6])
def test_an_even_pressure_gives_the_least_of_both_bounds(strength: float) -> None:
    """Much softer than the bodies, a layer makes the pressure even: F = min(mu p, tau) A."""
    side, force, friction = 0.1, 3e4, 0.5
    scene = mtb.scenes.block_on_plane(
        side, 0.1, friction, force / side**2, 1e-2, normal_layer=1e-6, layer=layer(strength)
    )
    found = scene.solve("half-space")
    even = force / side**2
    assert found.pressure.ravel() == pytest.approx(even, rel=1e-4)
    assert found.force[0] == pytest.approx(min(friction * even, strength) * side**2, rel=1e-4)


@pytest.mark.coarse
@pytest.mark.parametrize("model", ["half-space", "elastic-upper"])
def test_a_layer_that_never_yields_is_not_there(model: Model) -> None:
    plain, strong = shoe(), shoe(layer=layer(1e15))
    for found, wanted in (
        (strong.solve(model), plain.solve(model)),
        (strong.prepare(model).step(velocity=1.0), plain.prepare(model).step(velocity=1.0)),
    ):
        assert np.abs(found.pressure - wanted.pressure).max() <= 1e-12 * wanted.pressure.max()
        assert np.abs(found.force - wanted.force).max() <= 1e-12 * np.abs(wanted.force).max()


@pytest.mark.coarse
@pytest.mark.parametrize("model", ["half-space", "elastic-upper"])
def test_all_ways_agree_and_the_power_is_the_work_of_friction(model: Model) -> None:
    strength, speed = 1.2e6, 3.0
    scene = shoe(layer=layer(strength), velocity=speed)
    found = scene.solve(model)
    step = scene.prepare(model).step(velocity=speed)
    assert step.force == pytest.approx(found.force, rel=1e-9, abs=1e-9 * FORCE)
    assert {2, 3} <= set(np.unique(found.status)) or model == "half-space"
    assert found.force[0] < 0.4 * found.normal_force
    assert found.friction_power == pytest.approx(speed * found.force[0], rel=1e-12)
    assert step.friction_power == pytest.approx(found.friction_power, rel=1e-9)
    table = mtb.sweep(scene, {"layer.yield_stress": [strength, 1e15]}, model=model)
    assert table["force_x"][0] == pytest.approx(found.force[0], rel=1e-12)
    assert table["force_x"][1] == pytest.approx(shoe().solve(model).force[0], rel=1e-12)


@pytest.mark.coarse
def test_heat_is_that_of_the_friction_that_the_layer_transmits() -> None:
    speed = 2.0
    given: dict[str, Any] = {"duration": 1.0, "steps": 4, "velocity": speed}
    plain, held = shoe().sliding_heat(**given), shoe(layer=layer(1e6)).sliding_heat(**given)
    assert held.friction_power < 0.98 * plain.friction_power
    entered = (held.heat_flux_upper + held.heat_flux_lower) * held.area
    assert entered.sum() == pytest.approx(held.friction_power, rel=1e-12)
    assert np.abs(held.friction_powers / (speed * held.forces[:, 0]) - 1.0).max() < 1e-10
    assert (held.status == 3).any()
    assert np.abs(held.traction).max() <= 1e6 * 1.5


@pytest.mark.coarse
def test_heat_that_opens_the_gap_follows_the_capped_friction() -> None:
    """With expansion the fed back heat is that of the traction; Coulomb in the limit."""
    steel = mtb.Conductor(50.0, 7850.0, 450.0, expansion=1.2e-5)
    given: dict[str, Any] = {
        "duration": 0.2, "steps": 4, "velocity": 0.5, "lower": steel, "upper": steel, "expansion": True,
        "tolerance": 0.2,
    }  # fmt: skip
    plain, strong = shoe().sliding_heat(**given), shoe(layer=layer(1e15)).sliding_heat(**given)
    assert np.abs(strong.pressure - plain.pressure).max() <= 1e-12 * plain.pressure.max()
    held = shoe(layer=layer(1e6)).sliding_heat(**given)
    assert np.abs(held.friction_powers / (0.5 * held.forces[:, 0]) - 1.0).max() < 1e-10
    assert (held.status == 3).any()


@pytest.mark.coarse
def test_wear_goes_on_with_the_capped_friction() -> None:
    strength, coefficient = 1.0e6, 1e-13
    scene = shoe(layer=layer(strength))
    worn = mtb.wear(scene, 100.0, coefficient, model="elastic-upper")
    assert np.abs(worn.forces[:, 0]).max() <= strength * worn.area.sum() * (1.0 + 1e-9)
    # the same pressure, worn by the force that presses: the volume is the law's
    load = -worn.forces[:, 2]
    assert load == pytest.approx(load[0], rel=2e-2)


@pytest.mark.coarse
@pytest.mark.parametrize("of", ["force", "moment", "peak_pressure"])
@pytest.mark.parametrize("by", ["friction", "magnetic_pressure", "sliding_direction"])
def test_derivatives_where_some_points_yield(of: str, by: str) -> None:
    # not along x, where both poles share the peak
    way = (1.0, 0.3)
    scene = shoe(layer=layer(1.2e6), magnetic_pressure=3e6, sliding_direction=way)
    found = scene.solve("elastic-upper")
    assert {2, 3} <= set(np.unique(found.status))
    exact = np.asarray(found.derivative(of, by))

    def value(scene: mtb.Scene) -> Any:
        result = scene.solve("elastic-upper")
        assert np.array_equal(result.status, found.status)
        return result.report.peak_pressure if of == "peak_pressure" else getattr(result, of)

    if by == "sliding_direction":
        width = 1e-4
        sides = [value(scene.with_(sliding_direction=(way[0], way[1] + s * width))) for s in (1.0, -1.0)]
        exact = exact[..., 1]
    else:
        here = {"friction": 0.4, "magnetic_pressure": 3e6}[by]
        width = 1e-5 * here
        sides = [value(scene.with_(**{by: here + s * width})) for s in (1.0, -1.0)]
    numeric = (np.asarray(sides[0]) - np.asarray(sides[1])) / (2.0 * width)
    size = max(float(np.abs(numeric).max()), 1e-9 * float(np.abs(np.asarray(sides[0])).max()) / width)
    assert np.abs(exact - numeric).max() <= 1e-6 * size


@pytest.mark.coarse
def test_derivatives_of_a_step_where_some_points_yield() -> None:
    contact = shoe(layer=layer(1.2e6)).prepare("elastic-upper")
    step = contact.step(velocity=(3.0, 0.2))
    exact = np.asarray(step.derivative("force", "velocity"))
    width = 1e-4
    for axis in (0, 1):
        ends = []
        for s in (1.0, -1.0):
            velocity = np.array([3.0, 0.2])
            velocity[axis] += s * width
            ends.append(contact.step(velocity=tuple(velocity)).force)
        numeric = (ends[0] - ends[1]) / (2.0 * width)
        assert np.abs(exact[:, axis] - numeric).max() <= 1e-6 * np.abs(step.force).max()


def test_what_cannot_be_is_refused() -> None:
    for hardening, why in ((1e9, "friction alone"), (-1e9, "no strength")):
        scene = shoe(layer=layer(1e6, hardening))
        for ask in (lambda s=scene: s.solve("half-space"), lambda s=scene: s.prepare("half-space")):
            with pytest.raises(ValueError, match=f"hardening of .* Pa/m.*{why}"):
                ask()
    with pytest.raises(ValueError, match="a Shift takes a PlasticLayer"):
        shoe(layer=layer(1e6)).start_of_sliding([1e-6], "half-space")
    with pytest.raises(ValueError, match="layer is PlasticLayer"):
        ball(upper=mtb.steel, lower=mtb.steel, layer=layer(1e6)).solve(method="incremental")


@pytest.mark.coarse
def test_files_of_steps_and_results_keep_the_layer(tmp_path: Path) -> None:
    scene = shoe(layer=layer(1.2e6))
    contact = scene.prepare("elastic-upper")
    contact.save(tmp_path / "shoe.mtb")
    again = mtb.PreparedContact.load(tmp_path / "shoe.mtb")
    assert np.array_equal(again.step(velocity=1.0).force, contact.copy().step(velocity=1.0).force)
    found = scene.solve("elastic-upper")
    found.save(tmp_path / "result")
    loaded = mtb.load(tmp_path / "result")
    assert loaded == found
    assert np.array_equal(loaded.status, found.status)


@pytest.mark.coarse
def test_a_case_file_states_it() -> None:
    words: dict[str, Any] = {
        "scene": "pole_shoe_on_rail",
        "spacing": 8e-3,
        "friction": 0.4,
        "layer": {"thickness": 20e-6, "shear_modulus": 82e9, "yield_stress": 1.2e6},
        "solve": {"model": "half-space"},
    }
    case = case_from_words(words)
    assert case.scene().layer == layer(1.2e6)
    assert "layer.yield_stress" in case.variables()
    with pytest.raises(mtb.CaseError, match="yield_stress"):
        case_from_words(words | {"layer": {"thickness": 1e-5, "shear_modulus": 1e9, "hardening": 1.0}})


def test_what_yields_is_found_from_any_state_before() -> None:
    # a set guessed at other pressures may have no solution: friction at its limit under hardly any pressure
    contact = shoe(layer=mtb.PlasticLayer(1e-3, 1e12, 1e6)).prepare("elastic-upper")
    turned = {"velocity": (7.0, -7.0), "friction": 0.5, "magnetic_pressure": 3e6}
    light = {"velocity": 10.0, "magnetic_pressure": 1e5}
    for step in (light, turned, {"velocity": -10.0, "friction": 0.5, "magnetic_pressure": 3e6}):
        fresh = contact.copy().step(**step)
        for before in ({"velocity": 10.0, "magnetic_pressure": 3e6}, turned, light):
            warm = contact.copy()
            warm.step(**before)
            found = warm.step(**step)
            assert found.force == pytest.approx(fresh.force, rel=1e-8)
            assert found.report.residual < 1e-9
    scene = shoe(layer=mtb.PlasticLayer(1e-3, 1e12, 1e6), sliding_direction=(0.7, -0.7)).with_(friction=0.5)
    solved = scene.solve("elastic-upper")
    assert np.linalg.norm(solved.traction, axis=0).max() == pytest.approx(1e6)
    assert solved.force == pytest.approx(contact.copy().step(**turned).force, rel=1e-8)
