# SPDX-License-Identifier: MIT OR Apache-2.0
"""Sliding with heat that expands the bodies and with wear: balances, steps, limits."""

from __future__ import annotations

import itertools
from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

import mtb_rs as mtb
from mtb_rs.contact.heated_body import ReducedBody, WholeBody
from mtb_rs.scenes.heating import HeatedScene, heated_of

Array = NDArray[np.float64]
STEEL = mtb.conducting_steel
#: Of a soft sole [1/Pa]: it wears faster than hot spots grow.
SOFT = 1e-12


def shoe(**given: object) -> mtb.Scene:
    stated = {"friction": 0.1, "magnetic_pressure": 1e6, "spacing": 8e-3, **given}
    return mtb.scenes.pole_shoe_on_rail(**stated)  # type: ignore[arg-type]


def test_heat_and_wear_close_over_a_coupled_transient() -> None:
    # unlike coefficients along x, so that the law is no constant, and a rail that wears as well
    n = shoe().sliding_heat(0.1, 1, 10.0).pressure.size
    law = mtb.Archard(SOFT * np.linspace(0.5, 1.5, n))
    given = {"film": (40.0, -5.0), "resistance": 2e-5, "share": 0.2, "expansion": True}
    found = shoe().sliding_heat(4.0, 20, lambda t: 15.0 - t, wear=law, lower_wear=2e-15, **given)  # type: ignore[arg-type]
    entered = found.heats_upper + found.heats_lower
    assert entered == pytest.approx(found.friction_powers, rel=1e-12)
    dt = np.diff(found.time, prepend=0.0)
    assert found.stored == pytest.approx(np.cumsum((found.heats_upper - found.losses) * dt), rel=1e-10)
    # friction times the mean speed of each step
    speed = found.velocity + 0.5 * dt
    assert found.friction_powers == pytest.approx(np.abs(found.forces[:, 0]) * speed, rel=2e-3)
    # the law integrated, by the pressures that wear: hats of a pole, whose means are `pressures`
    way = dt * speed
    assert np.diff(found.volumes_lower, prepend=0.0) == pytest.approx(
        2e-15 * np.abs(found.forces[:, 2]) * way, rel=1e-3
    )
    uniform = shoe().sliding_heat(4.0, 8, 10.0, wear=SOFT, lower_wear=SOFT, **given)  # type: ignore[arg-type]
    assert uniform.volumes_upper == pytest.approx(uniform.volumes_lower, rel=1e-12)
    assert uniform.depths[-1] @ uniform.area == pytest.approx(uniform.volumes_upper[-1], rel=1e-12)


def test_expansion_without_heat_and_wear_without_speed_change_nothing() -> None:
    cold = shoe().sliding_heat(1.0, 3, 0.0)
    same = shoe().sliding_heat(1.0, 3, 0.0, expansion=True, wear=SOFT)
    assert same.pressure == pytest.approx(cold.pressure, rel=1e-9, abs=1e-9 * cold.pressure.max())
    assert not same.volumes_upper.any()
    # a body that is warm all through has grown, and is pressed as before
    warm = shoe().sliding_heat(1.0, 3, 0.0, expansion=True, bulk=(80.0, 80.0))
    assert warm.pressure == pytest.approx(cold.pressure, rel=1e-6, abs=1e-6 * cold.pressure.max())


def test_a_hot_sole_bows_and_presses_in_its_middle() -> None:
    # the sole warms while the back is cold: it bows towards the rail, and its ends lift
    cold = shoe(friction=0.02).sliding_heat(30.0, 5, 0.2)
    hot = shoe(friction=0.02).sliding_heat(
        30.0, 10, 0.2, expansion=True, tolerance=0.05, lower=mtb.Conductor(1e-6, 1.0, 1e-3)
    )
    x = hot.points[0] - hot.points[0].mean()
    inner = np.abs(x) < 0.5 * x.max()

    def share(found: mtb.SlidingHeat) -> float:
        load = found.pressure * found.area
        return float(load[inner].sum() / load.sum())

    assert share(hot) > 1.05 * share(cold)
    assert hot.pressure @ hot.area == pytest.approx(cold.pressure @ cold.area, rel=1e-3)


def test_steps_are_of_first_order_where_wear_holds_the_hot_spots() -> None:
    given = {"expansion": True, "wear": SOFT, "resistance": 2e-5, "share": 0.0}
    ends = [shoe().sliding_heat(4.0, steps, 20.0, **given) for steps in (16, 32, 64, 128)]  # type: ignore[arg-type]
    fields = [found.pressure for found in ends]
    changes = np.array([np.abs(a - b).max() for a, b in itertools.pairwise(fields)])
    assert changes[:-1] / changes[1:] == pytest.approx([2.0, 2.0], abs=0.2)
    # beyond the limit, which is said
    assert ends[0].thermal_margin is not None
    assert ends[0].thermal_margin > 1.0
    assert "heat over its thermal limit" in dict(ends[0].told())
    # a tolerance chooses as good steps
    chosen = shoe().sliding_heat(4.0, 2, 20.0, tolerance=0.05, **given)  # type: ignore[arg-type]
    assert chosen.time[-1] == pytest.approx(4.0, rel=1e-12)
    assert np.all(chosen.errors[1:] <= 1.5 * 0.05)
    assert np.abs(chosen.pressure - fields[-1]).max() < 1e-3 * fields[-1].max()
    assert len(chosen.time) < 64


def test_a_step_of_the_prepared_contact_with_what_heat_and_wear_open_is_that_step() -> None:
    changing = mtb.Conductor(50.0, 7850.0, 460.0, 1.2e-5, conductivity_slope=-0.03, expansion_slope=5e-9)
    hot = shoe().sliding_heat(
        2.0, 6, 10.0, expansion=True, wear=SOFT, resistance=2e-5, share=0.0, tolerance=0.2, upper=changing,
        bulk=(0.0, 20.0),
    )  # fmt: skip
    contact = shoe().prepare("elastic-upper")
    cold = contact.step(velocity=10.0)
    assert np.abs(hot.openings[-1]).max() > 1e-6
    for k in (0, len(hot.time) // 2, -1):
        step = contact.step(velocity=10.0, gap=hot.depths[k] + hot.openings[k])
        largest = hot.pressures[k].max()
        # the strain is linear over a step
        assert np.abs(step.pressure - hot.pressures[k]).max() < 2e-3 * largest
        assert np.abs(cold.pressure - hot.pressures[k]).max() > 0.02 * largest
    steady = shoe().sliding_heat(2.0, 6, 10.0, expansion=True, wear=SOFT, tolerance=0.2)
    for k in (0, -1):
        step = contact.step(velocity=10.0, gap=steady.depths[k] + steady.openings[k])
        assert np.abs(step.pressure - steady.pressures[k]).max() < 1e-10 * steady.pressures[k].max()
    assert not shoe().sliding_heat(2.0, 2, 10.0).openings.any()


@pytest.mark.parametrize("lateral", [0.0, 2e-3])
@pytest.mark.parametrize("changes", [False, True])
def test_modes_take_the_steps_of_the_whole_bodies(lateral: float, changes: bool) -> None:
    scene = shoe(lateral=lateral)
    conductor = replace(STEEL, conductivity_slope=-0.1, expansion_slope=5e-9) if changes else STEEL
    given = {"film": (200.0, -5.0), "resistance": 2e-5, "share": 0.3, "bulk": (0.0, 40.0), "upper": conductor}
    posed = HeatedScene.of(scene, *heated_of(scene, "auto", expansion=True, wear=SOFT, **given))  # type: ignore[arg-type]
    whole, reduced = (posed.sliding(steps=steps) for steps in (1, None))
    assert all(isinstance(body, WholeBody) for body in whole.bodies)
    first, second = reduced.bodies
    assert isinstance(first, ReducedBody)
    assert isinstance(second, ReducedBody)
    # poles that are mirror images have modes in common
    assert (first._modes[0] is second._modes[0]) == (lateral == 0.0)
    assert whole.thermal_margin(0.5, 10.0) == pytest.approx(reduced.thermal_margin(0.5, 10.0), rel=1e-4)
    time = 0.0
    for duration, speed in ((1e-3, 10.0), (0.01, 10.0), (0.01, 9.0), (0.1, 9.0), (0.5, 8.0), (0.05, 8.0)):
        time += duration
        known, found = (one.take(one.tried(duration, speed, speed)) for one in (whole, reduced))
        # what films do to heat from the contact is that of the first conductivity
        inside = 1e-4 if changes else 1e-5
        for name, part in (
            ("temperatures", 1e-6),
            ("pressures", 1e-5),
            ("openings", inside),
            ("depths", 1e-5),
        ):
            largest = np.abs(known[name]).max()
            assert np.abs(found[name] - known[name]).max() < part * largest, (time, name)
        # heat is that which has entered, in both
        for row in (known, found):
            entered = duration * (row["heats_upper"] - row["losses"])
            assert row["gained"] == pytest.approx(entered, abs=1e-11 * whole.held())
    for one, other in zip(whole.bodies, reduced.bodies, strict=True):
        assert one.level == other.level
        assert (one.level != 0) == changes
        assert np.abs(other.nodes() - one.nodes()).max() < (1e-2 if changes else 1e-3)


@pytest.mark.parametrize("is_symmetric", [True, False])
@pytest.mark.parametrize("expansion", [False, True])
def test_poles_that_are_mirror_images_conduct_as_two_bodies_do(
    is_symmetric: bool, expansion: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    def heated() -> mtb.SlidingHeat:
        scene = shoe(magnetic_pressure=1e6 if is_symmetric else lambda x, y: 1e6 * (1.0 + 5.0 * y))
        changing = replace(STEEL, conductivity_slope=-0.1)
        return scene.sliding_heat(
            1.0, 4, 10.0, expansion=expansion, wear=SOFT, film=(200.0, -5.0), resistance=2e-5, upper=changing
        )

    advances: list[float] = []
    coasted = WholeBody._coasted

    def counted(body: WholeBody, duration: float) -> Array:
        advances.append(duration)
        return coasted(body, duration)

    monkeypatch.setattr(WholeBody, "_coasted", counted)
    together = heated()
    # one is computed for both as long as their temperatures are mirror images: at the beginning they are
    assert len(advances) == (4 if is_symmetric else 7)
    monkeypatch.setattr("mtb_rs.contact.heated_body._image", lambda first, part: None)
    apart = heated()
    assert len(advances) == (4 if is_symmetric else 7) + 8
    for name in ("pressures", "temperatures", "openings", "depths", "losses", "stored"):
        known = getattr(apart, name)
        assert np.abs(getattr(together, name) - known).max() <= 1e-9 * np.abs(known).max(), name


def test_the_margin_follows_the_heat_of_friction() -> None:
    slow, twice, long = (
        shoe(friction=mu).sliding_heat(duration, 4, 0.05, expansion=True).thermal_margin
        for mu, duration in ((0.05, 1.0), (0.1, 1.0), (0.05, 4.0))
    )
    assert slow is not None
    assert twice is not None
    assert long is not None
    # friction also turns the gap, which moves it a little
    assert twice == pytest.approx(2.0 * slow, rel=0.1)
    assert long > slow
    assert shoe().sliding_heat(1.0, 2, 10.0).thermal_margin is None


def test_material_follows_the_temperature() -> None:
    # a conductivity that falls is that of its mean temperature, in the end
    bulk = (200.0, 200.0)
    falling = replace(STEEL, conductivity_slope=-0.05)
    fallen = replace(STEEL, conductivity=40.0)
    there, then, now = (
        shoe().sliding_heat(1.0, 10, 5.0, upper=upper, lower=upper, bulk=bulk).peaks[-1] - 200.0
        for upper in (falling, fallen, STEEL)
    )
    assert there == pytest.approx(then, rel=0.02)
    assert abs(now / then - 1.0) > 0.05
    # an expansion that grows bows the sole as the one of its temperature
    grows = replace(STEEL, expansion_slope=1e-8)
    grown = replace(STEEL, expansion=12e-6 + 2.0 * 1e-8 * 200.0)
    by_slope, by_value = (
        shoe(friction=0.02).sliding_heat(1.0, 20, 0.5, upper=upper, bulk=bulk, expansion=True).pressure
        for upper in (grows, grown)
    )
    assert by_slope == pytest.approx(by_value, abs=0.02 * by_value.max())


def test_friction_fades_with_the_temperature() -> None:
    faded = shoe().sliding_heat(1.0, 10, 20.0, fading=([0.0, 10.0], [1.0, 0.5]))
    forces = np.abs(faded.forces[:, 0] / faded.forces[:, 2])
    assert 0.05 < forces[-1] < forces[0] < 0.1
    # by the temperature at the end of the step itself, nearly the same all over
    assert forces == pytest.approx(0.1 * np.interp(faded.means, [0.0, 10.0], [1.0, 0.5]), rel=0.01)
    fixed = shoe(friction=0.05).sliding_heat(1.0, 10, 20.0)
    far = shoe().sliding_heat(1.0, 10, 20.0, fading=([-10.0], [0.5]))
    assert far.means == pytest.approx(fixed.means, rel=1e-9)


def test_equal_steps_beyond_the_limit_say_so() -> None:
    with pytest.warns(UserWarning, match="The steps are too long"):
        shoe().sliding_heat(2.0, 10, 5.0, expansion=True)
    with pytest.raises(mtb.ConvergenceError, match="no single state"):
        shoe(friction=0.3, magnetic_pressure=3e6).sliding_heat(20.0, 2, 30.0, expansion=True)


@pytest.mark.parametrize(("friction", "velocity", "steps"), [(0.1, 2.0, 60), (0.3, 1.0, 600)])
def test_heat_that_runs_away_is_no_result(friction: float, velocity: float, steps: int) -> None:
    """Linear expansion above the thermal limit would end at 1e22 MPa and beyond the largest number."""
    block = mtb.scenes.block_on_plane(friction=friction, spacing=0.02)
    with pytest.raises(mtb.ConvergenceError, match="the heat runs away"):
        block.sliding_heat(600.0, steps, velocity, expansion=True)


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"tolerance": 2.0}, "tolerance is 2"),
        ({"expansion": 3}, "expansion is 3"),
        (
            {"expansion": True, "lower": mtb.Conductor(1, 1, 1), "upper": mtb.Conductor(1, 1, 1)},
            "coefficient",
        ),
        ({"wear": -1.0}, "wear is -1 1/Pa: a wear coefficient of at least 0"),
        ({"lower_wear": "steel"}, "lower_wear is 'steel'"),
        ({"fading": 3.0}, "fading is 3.0"),
        ({"fading": ([1.0, 0.0], [1.0, 1.0])}, "that rise"),
        ({"fading": ([0.0, 1.0], [1.0])}, "one length"),
    ],
)
def test_bad_input_is_refused(given: dict[str, object], message: str) -> None:
    with pytest.raises((ValueError, TypeError), match=message):
        shoe().sliding_heat(1.0, 1, 20.0, **given)  # type: ignore[arg-type]


@pytest.mark.filterwarnings("ignore:The steps are too long")
@pytest.mark.parametrize("body", ["lower", "upper"])
def test_expansion_has_one_scale_of_temperature(body: str) -> None:
    """(a + b T) T about T0 is (a + 2 b T0) t + b t^2 with t = T - T0."""
    a, b, start = 12e-6, 2e-8, 300.0
    scene = mtb.scenes.pole_shoe_on_rail(friction=0.15, velocity=20.0, spacing=(18e-3, 8e-3))

    def slid(expansion: float, bulk: float) -> mtb.SlidingHeat:
        bodies = dict.fromkeys(("lower", "upper"), mtb.Conductor(50.0, 7850.0, 450.0))
        bodies[body] = mtb.Conductor(50.0, 7850.0, 450.0, expansion, expansion_slope=b)
        return scene.sliding_heat(0.5, 5, bulk=(bulk, bulk), expansion=True, wear=1e-12, **bodies)

    warm, cold = slid(a, start), slid(a + 2.0 * b * start, 0.0)
    assert warm.openings[-1] == pytest.approx(cold.openings[-1], rel=1e-9, abs=1e-18)
    assert warm.pressure == pytest.approx(cold.pressure, rel=1e-9)


def test_short_steps_below_a_resistance_have_a_single_state() -> None:
    """Where all heat arises at the rail, this swells by the heat that it has met, and by no more."""
    scene = mtb.scenes.pole_shoe_on_rail(friction=0.2, magnetic_pressure=3e6, velocity=20.0, spacing=6e-3)
    found = scene.sliding_heat(0.12, tolerance=0.1, expansion=True, resistance=1e-5, share=0.0, wear=1e-13)
    assert found.time[-1] == pytest.approx(0.12)
    assert np.median(found.errors) <= 0.1
