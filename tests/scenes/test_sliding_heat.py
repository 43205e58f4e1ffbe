# SPDX-License-Identifier: MIT OR Apache-2.0
"""Heat of friction in bodies that slide, against closed forms, balances and an own solution."""

from __future__ import annotations

import itertools
import math
import pickle
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.special import erf

import mtb_rs as mtb
from mtb_rs.contact.heated_steps import Heated, Passing

Array = NDArray[np.float64]
STEEL = mtb.conducting_steel
#: Takes no heat; stays cold whatever enters it.
WOOL, COLD = mtb.Conductor(1e-6, 1.0, 1e-3), mtb.Conductor(1e9, 1e6, 1e6)


def shoe(**given: object) -> mtb.Scene:
    stated = {"friction": 0.1, "magnetic_pressure": 1e6, "spacing": 8e-3, **given}
    return mtb.scenes.pole_shoe_on_rail(**stated)  # type: ignore[arg-type]


def test_pressures_are_those_of_cold_bodies_and_heat_is_conserved() -> None:
    cold = shoe().solve(model="elastic-upper")
    found = shoe().sliding_heat(10.0, 8, 20.0, film=(40.0, -5.0))
    assert found.pressure == pytest.approx(cold.pressure, rel=1e-9, abs=1e-6 * cold.pressure.max())
    assert found.force == pytest.approx(cold.force, rel=1e-9, abs=1e-9 * np.abs(cold.force).max())
    # friction times speed is the heat; it goes into both bodies
    assert found.friction_powers == pytest.approx(abs(cold.force[0]) * 20.0, rel=2e-3)
    assert found.heats_upper + found.heats_lower == pytest.approx(found.friction_powers, rel=1e-12)
    dt = np.diff(found.time, prepend=0.0)
    kept = np.cumsum((found.heats_upper - found.losses) * dt)
    assert found.stored == pytest.approx(kept, rel=1e-10)
    # in contact both have one temperature
    touching = found.status > 0
    assert found.temperature_upper[touching] == pytest.approx(found.temperature_lower[touching], rel=1e-9)
    assert np.all(np.diff(found.means) > 0.0)
    # of either body, which differ by rounding
    assert found.peaks[-1] == pytest.approx(found.temperature_upper.max(), rel=1e-12)


def test_all_heat_into_the_shoe_is_the_root_of_the_time() -> None:
    # a block whose face takes all the heat, before its depth counts
    scene = mtb.scenes.block_on_plane(spacing=5e-3, friction=0.1)
    duration, speed = 2.0, 3.0
    runs = [
        scene.sliding_heat(duration, steps, speed, lower=WOOL, model="elastic-upper") for steps in (20, 40)
    ]
    mean = 0.1 * (runs[0].pressure @ runs[0].area) / runs[0].area.sum() * speed
    exact = 2.0 * mean * math.sqrt(duration / math.pi) / STEEL.effusivity
    errors = [abs(run.means[-1] / exact - 1.0) for run in runs]
    assert errors[1] < 6e-3
    assert errors[1] < errors[0]
    assert runs[1].heats_lower == pytest.approx(0.0, abs=1e-3 * runs[1].friction_power)


def test_a_cold_rail_takes_all_and_a_resistance_keeps_the_shares() -> None:
    cold = shoe().sliding_heat(5.0, 4, 20.0, lower=COLD)
    assert np.abs(cold.peaks).max() < 1e-3
    assert cold.heats_upper == pytest.approx(0.0, abs=1e-3 * cold.friction_power)
    # nothing passes a resistance that is large beside those of the bodies
    apart = shoe().sliding_heat(5.0, 4, 20.0, resistance=1e4, share=0.3)
    assert apart.heats_upper == pytest.approx(0.3 * apart.friction_powers, rel=1e-4)


def by_lines(power: Array, rail: Array, dt: float, steps: int, depth: float, cells: int) -> Array:
    """Temperatures of points that each heat a column of their own above a rail, by finite volumes."""
    dz = depth / cells
    n = power.size
    conduction = np.zeros((cells, cells))
    for k in range(cells - 1):
        conduction[k : k + 2, k : k + 2] += STEEL.conductivity / dz * np.array([[1.0, -1.0], [-1.0, 1.0]])
    stored = STEEL.density * STEEL.specific_heat * dz / dt * np.eye(cells)
    inverse = np.linalg.inv(stored + conduction)
    # the surface is half a cell before the first centre
    own = inverse[0, 0] + 0.5 * dz / STEEL.conductivity
    temperature = np.zeros((n, cells))
    for _ in range(steps):
        before = (inverse @ (stored @ temperature.T)).T
        upper = np.linalg.solve(own * np.eye(n) + rail, rail @ power - before[:, 0])
        temperature = before + np.outer(upper, inverse[:, 0])
    return np.asarray(before[:, 0] + own * upper)


def test_a_long_shoe_agrees_with_columns_over_a_rail() -> None:
    # lateral conduction is weak over a long block in a short time; the rail by the heat of points upstream
    scene = mtb.scenes.block_on_plane(spacing=0.02, friction=0.1)
    duration, steps, speed = 4.0, 40, 8.0
    found = scene.sliding_heat(duration, steps, speed, model="elastic-upper")
    ny = found.patches[0].ny
    nx = found.patches[0].nx
    row = slice((ny // 2) * nx, (ny // 2 + 1) * nx)
    x, area = found.points[0][row], found.area[row]
    length = np.where((x == x.min()) | (x == x.max()), 0.5, 1.0) * found.patches[0].spacing[0]
    # sliding along +x: the rail comes from the front
    order = np.argsort(-x)
    ends = np.concatenate([[0.0], np.cumsum(length[order])])
    middle = np.abs(x[order] - x.max())
    rail = np.zeros((nx, nx))
    for i in range(nx):
        for j in range(i + 1):
            near = max(middle[i] - ends[j + 1], 0.0)
            rail[i, j] = 2.0 * (math.sqrt(max(middle[i] - ends[j], 0.0)) - math.sqrt(near))
    rail *= 1.0 / (STEEL.effusivity * math.sqrt(math.pi * speed))
    power = 0.1 * found.pressure[row][order] * speed
    assert area.min() > 0.0
    own = by_lines(power, rail, duration / steps, steps, 0.1, 400)
    inner = slice(2, nx - 2)
    assert found.temperature_upper[row][order][inner] == pytest.approx(own[inner], rel=0.05)


def test_steps_are_of_first_order_and_stable() -> None:
    runs = [shoe().sliding_heat(8.0, steps, 20.0).means[-1] for steps in (5, 10, 20, 40)]
    changes = np.abs(np.diff(runs))
    assert changes[0] / changes[1] == pytest.approx(2.0, abs=0.5)
    assert changes[1] / changes[2] == pytest.approx(2.0, abs=0.5)
    # an hour in one step
    assert 0.0 < shoe().sliding_heat(3600.0, 1, 20.0).means[-1] < 100.0


def test_slow_sliding_and_standing_settle_with_the_steps() -> None:
    scene = shoe(spacing=0.012)
    for speed, bulk in ((1.0, (0.0, 0.0)), (0.0, (0.0, 50.0)), (5.0, (0.0, 0.0))):
        means = [scene.sliding_heat(2.0, n, speed, bulk=bulk).means[-1] for n in (20, 80, 320)]
        assert abs(means[2] - means[1]) < 0.5 * abs(means[1] - means[0]) + 1e-3 * means[2]
        assert means[2] == pytest.approx(means[1], rel=0.03)
    ends = [scene.sliding_heat(4.0, n, lambda t: max(0.0, 20.0 - 5.0 * t)).stored[-1] for n in (60, 240, 960)]
    assert abs(ends[2] - ends[1]) < 0.5 * abs(ends[1] - ends[0])
    assert ends[2] == pytest.approx(ends[1], rel=0.01)


def passing_of_a_block() -> tuple[Passing, Array]:
    """The rail below a block, and the shares (n, n) of the hats of its points in their rectangles."""
    scene = mtb.scenes.block_on_plane(spacing=0.01, friction=0.1)
    problem = scene.problem("elastic-upper")
    patch = problem.patches[0]
    # hats along a line: three quarters lie on the own rectangle; at the ends it is half of one
    lines = []
    for count in (patch.ny, patch.nx):
        line = np.diag(np.full(count, 0.75)) + 0.125 * (np.eye(count, k=1) + np.eye(count, k=-1))
        line[0, 1] = line[-1, -2] = 0.25
        lines.append(line)
    heated = Heated(STEEL, STEEL, (0.0, 0.0), (0.0, 0.0), 0.0, 0.5)
    return Passing(problem, heated), np.asarray(np.kron(*lines), dtype=float)


def test_a_strip_of_heat_warms_the_rail_as_the_root_of_the_way() -> None:
    # uniform heat: at each point 2 sqrt(s / pi V) / effusivity over its way s below the contact
    passing, shares = passing_of_a_block()
    warm = passing.at(passing.of(1e3, 1e4, 0.0))[0].sum(axis=1)
    s = (passing.places + 0.5 * passing.sizes)[:, 0].max() - passing.places[:, 0]
    exact = shares @ (2.0 * np.sqrt(s / (math.pi * 10.0)) / STEEL.effusivity)
    # along the middle, away from the front, where the mean of a root is less than that of its middle
    inner = (s > 1.5 * passing.sizes.max()) & (np.abs(passing.places[:, 1]) < 1e-9)
    assert inner.sum() > 5
    assert warm[inner] == pytest.approx(exact[inner], rel=0.01)


def by_instants(places: Array, sizes: Array, age: Sequence[float], gone: Sequence[float]) -> Array:
    """Temperatures (n, n) by a unit flux into each rectangle, of a half-space that passes below them.

    The fluxes end and begin at two ages, when as much of the way has been gone since. Green's function of an
    instant, over rectangles in closed form and over the time by Gauss' rule.
    """
    conductivity, density, specific_heat = STEEL.constants
    diffusivity = conductivity / density / specific_heat
    ahead = places[:, None, :] - places[None, :, :]
    found = np.zeros(ahead.shape[:2])
    speed = (gone[1] - gone[0]) / (age[1] - age[0])
    # the way that has been gone, over the columns that it crosses
    crossed = np.arange(0.0, 61.0) * sizes[:, 0].max() / 4.0
    cuts = age[0] + np.maximum(crossed - gone[0], 0.0) / max(speed, 1e-9)
    ends = np.sqrt(age)
    cuts = np.concatenate(
        [np.sqrt(np.minimum(cuts, age[1])), ends[0] + np.ptp(ends) * np.linspace(0.0, 1.0, 9)]
    )
    x, w = np.polynomial.legendre.leggauss(4)
    for low, high in itertools.pairwise(np.unique(cuts)):
        for s, weight in zip(low + (high - low) * (x + 1.0) / 2.0, w * (high - low) / 2.0, strict=True):
            reach = 2.0 * math.sqrt(diffusivity) * s
            part = np.full(found.shape, 2.0 / (density * specific_heat * math.sqrt(math.pi * diffusivity)))
            for c, way in ((0, gone[0] + speed * (s * s - age[0])), (1, 0.0)):
                far = ahead[..., c] + way + 0.5 * sizes[:, c]
                near = ahead[..., c] + way - 0.5 * sizes[:, c]
                part *= 0.5 * (erf(far / reach) - erf(near / reach))
            found += weight * part
    return found


@pytest.mark.parametrize(
    ("speed", "worst", "mean"),
    [
        (10.0, 0.004, 0.004),
        (0.1, 0.015, 0.006),
        (0.01, 0.06, 0.03),
        (1e-3, 0.18, 0.06),
        (0.0, 0.25, 0.06),
    ],
)
def test_a_rail_that_has_just_been_met_is_warm_where_it_has_been(
    speed: float, worst: float, mean: float
) -> None:
    passing, shares = passing_of_a_block()
    for part in (0.15, 0.4, 0.8):
        time = part * passing.length / max(speed, 2e-3)
        warm = passing.at(passing.of(time, speed * time, 0.0))[0].sum(axis=1)
        exact = shares @ by_instants(passing.places, passing.sizes, (0.0, time), (0.0, speed * time)).sum(
            axis=1
        )
        assert np.abs(warm - exact).max() < worst * exact.max()
        assert warm.mean() == pytest.approx(exact.mean(), rel=mean)


def way_of(*parts: tuple[float, float, int]) -> list[tuple[float, float]]:
    """Durations [s] and speeds [m/s] of steps, by parts of a time, a speed and a number of steps."""
    return [(time / count, speed) for time, speed, count in parts for _ in range(count)]


#: Steps, and errors relative to the hottest point and to the mean.
WAYS = {
    "fast": (way_of((0.054, 1.0, 6)), 0.002, 0.001),
    "slow": (way_of((0.54, 0.1, 6)), 0.02, 0.006),
    "hardly": (way_of((54.0, 1e-3, 6)), 0.15, 0.08),
    "slower by half": (way_of((0.02, 10.0, 5), (0.01, 5.0, 5)), 0.005, 0.002),
    "slower by far": (way_of((0.02, 10.0, 5), (0.2, 0.1, 10)), 0.04, 0.015),
    "hardly at last": (way_of((0.02, 10.0, 5), (1.0, 0.01, 10)), 0.12, 0.06),
    "faster": (way_of((0.5, 0.1, 5), (0.004, 10.0, 5)), 0.04, 0.01),
    "at rest at last": (way_of((0.02, 10.0, 5), (3.0, 0.0, 10)), 0.06, 0.02),
    "on after a rest": (way_of((0.02, 10.0, 5), (1.0, 0.0, 10), (0.1, 0.1, 5)), 0.25, 0.06),
    "braked": ([(0.01, 2.0 - 0.01 * (k + 0.5)) for k in range(200)], 0.03, 0.01),
}


@pytest.mark.parametrize("name", WAYS)
def test_a_rail_is_as_warm_as_the_heat_of_each_step_has_made_it(name: str) -> None:
    """Heat and speed that change from step to step, by superposition; heat goes on at rest, as it may."""
    steps, worst, mean = WAYS[name]
    passing, shares = passing_of_a_block()
    n = len(passing.sizes)
    # more at the front than at the rear
    slope = 1.0 + 5.0 * passing.places[:, 0]
    fluxes = [(1.0, 3.0, 0.5, 2.0, 1.0, 1.5)[k % 6] * slope for k in range(len(steps))]
    if name == "at rest at last":
        fluxes[5:] = [np.zeros(n)] * 10
    lengths = np.array([duration for duration, _ in steps])
    ways = lengths * np.array([speed for _, speed in steps])
    for k, flux in enumerate(fluxes):
        passed = passing.of(lengths[k], ways[k], 0.0)
        warm = passing.at(passed)[0] @ flux
        carried = passing.carried(passed)
        warm += 0.0 if carried is None else carried[0]
        passing.keep(ways[k], lengths[k], flux)
        if k not in (0, 3, 5, 6, len(fluxes) - 1):
            continue
        exact = np.zeros(n)
        age, gone = 0.0, 0.0
        for j in range(k, -1, -1):
            if gone > 1.2 * passing.length:
                break
            ends = (age, age + lengths[j]), (gone, gone + ways[j])
            exact += shares @ by_instants(passing.places, passing.sizes, *ends) @ shares @ fluxes[j]
            age, gone = ends[0][1], ends[1][1]
        assert np.abs(warm - exact).max() < worst * exact.max()
        assert warm.mean() == pytest.approx(exact.mean(), rel=mean)


@pytest.mark.parametrize("speed", [0.0, 0.1, 10.0])
@pytest.mark.parametrize("duration", [0.0173, 0.3])
def test_a_hot_shoe_without_friction_cools_in_steps_of_any_lengths(speed: float, duration: float) -> None:
    """Its heat flows into the cold rail alone, also in short steps after long ones."""
    scene = shoe(friction=0.0, spacing=0.012)
    chosen = scene.sliding_heat(duration, velocity=speed, tolerance=0.1, bulk=(0.0, 50.0))
    assert np.diff(chosen.time).min() < 0.1 * np.diff(chosen.time).max()
    assert chosen.heats_upper.max() < 0.0
    assert chosen.temperature_lower.min() > 0.0
    equal = scene.sliding_heat(duration, 200, speed, bulk=(0.0, 50.0))
    assert equal.heats_upper.max() < 0.0
    assert chosen.means[-1] == pytest.approx(equal.means[-1], rel=0.01)


@pytest.mark.filterwarnings("ignore:The steps are too long")
def test_a_shoe_that_stands_after_sliding_cools() -> None:
    for given in ({}, {"resistance": 1e-4, "share": 0.0}, {"expansion": True, "wear": 1e-12}):
        slid = shoe(spacing=0.012).sliding_heat(3.0, 120, lambda t: max(0.0, 20.0 - 20.0 * t), **given)  # type: ignore[arg-type]
        standing = slid.time > 1.05
        assert slid.friction_powers[standing].max() == 0.0
        assert (np.diff(slid.peaks[standing]) < 0.0).all()
        assert slid.peaks[-1] < 0.5 * slid.peaks.max()


def test_heat_is_the_friction_power_of_steps_on_slopes_too() -> None:
    scene = shoe(spacing=0.012, sliding_direction=(0.0, 1.0))
    found = scene.sliding_heat(1.0, 2, 20.0)
    step = scene.prepare(model="elastic-upper").step(velocity=(0.0, 20.0))
    assert found.friction_power == pytest.approx(step.friction_power, rel=1e-9)


def test_speed_and_tables_change_with_the_time() -> None:
    table = mtb.VelocityTable([0.0, 10.0, 30.0], [0.2, 0.15, 0.1])
    found = shoe(friction=table, velocity=20.0).sliding_heat(4.0, 8, lambda t: 30.0 - 7.0 * t)
    assert found.velocity == pytest.approx(30.0 - 7.0 * found.time)
    mu = np.abs(found.forces[:, 0]) / np.abs(found.forces[:, 2])
    assert mu == pytest.approx(np.interp(found.velocity, table.velocity, table.value), rel=0.02)
    still = shoe().sliding_heat(4.0, 4, 0.0, bulk=(0.0, 50.0))
    assert still.friction_power == 0.0
    assert still.heat_upper == pytest.approx(-still.heat_lower)
    assert still.heat_upper < 0.0
    assert 0.0 < still.means[-1] < 50.0


def test_temperatures_count_from_any_level() -> None:
    warm = shoe().sliding_heat(2.0, 4, 20.0, bulk=(30.0, 30.0))
    level = shoe().sliding_heat(2.0, 4, 20.0)
    assert warm.temperature_upper == pytest.approx(level.temperature_upper + 30.0, rel=1e-9)
    assert warm.stored == pytest.approx(level.stored, rel=1e-6)


def test_rails_of_elements_and_bodies_of_their_own_are_heated() -> None:
    both = shoe(spacing=0.012).sliding_heat(4.0, 4, 20.0, model="elastic-both")
    assert both.heats_upper + both.heats_lower == pytest.approx(both.friction_powers, rel=1e-12)
    ready = mtb.scenes.block_on_plane(spacing=0.0125, friction=0.1)
    upper = ready.solve(model="elastic-upper").parts[0].body
    own = mtb.Scene(
        upper,
        ready.lower,
        spacing=0.0125,
        friction=0.1,
        magnetic_pressure=ready.magnetic_pressure,
        sliding_direction=(1.0, 0.0),
    )
    seen = own.sliding_heat(2.0, 4, 5.0)
    known = ready.sliding_heat(2.0, 4, 5.0)
    assert seen.heats_upper == pytest.approx(known.heats_upper, rel=0.02)
    assert seen.peaks == pytest.approx(known.peaks, rel=0.02)


def test_it_is_saved_and_drawn(tmp_path: Path) -> None:
    found = shoe().sliding_heat(2.0, 2, lambda t: 20.0 - t, bulk=(5.0, 5.0))
    assert found.summary["heat"]["bulk"] == (5.0, 5.0)
    assert repr(pickle.loads(pickle.dumps(found))) == repr(found)
    files = {path.name for path in found.save(tmp_path / "heat")}
    assert {"temperature.png", "pressure.png", "peaks.png", "stored.png"} <= files
    assert found.plot().axes[0].get_ylabel() == "highest temperature [K]"
    with pytest.raises(ValueError, match="a line over the time"):
        found.plot("means", "3d")
    loaded = mtb.load(tmp_path / "heat")
    assert isinstance(loaded, mtb.SlidingHeat)
    assert np.array_equal(loaded.temperatures, found.temperatures)
    assert loaded.totals()["heat_upper"].values == found.heat_upper


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"duration": -1.0}, "duration is -1"),
        ({"steps": 0}, "steps is 0"),
        ({"steps": 2**63}, "steps is 9223372036854775808: a whole number of at most"),
        ({"steps": 1_000_001}, "steps is 1000001: at most 1000000 are possible"),
        ({"duration": float(2**63)}, r"duration is 9\.22337e\+18 s: at most 1e\+09 s"),
        ({"velocity": -2.0}, "velocity is -2 m/s at"),
        ({"velocity": lambda t: math.nan}, "velocity is nan"),
        ({"film": (-1.0, 0.0)}, r"film\[0\] is -1"),
        ({"resistance": -1.0}, "resistance is -1"),
        ({"share": 1.5}, "share is 1.5"),
        ({"upper": 3}, "upper is 3: a Conductor"),
        ({"model": "half-space"}, "heat needs an elastic upper body"),
    ],
)
def test_bad_input_is_refused(given: dict[str, object], message: str) -> None:
    stated = {"duration": 1.0, "steps": 1, "velocity": 20.0, **given}
    with pytest.raises(ValueError, match=message):
        shoe().sliding_heat(**stated)  # type: ignore[arg-type]


def test_without_a_speed_or_a_direction_nothing_is_heated() -> None:
    with pytest.raises(ValueError, match="velocity is missing"):
        shoe().sliding_heat(1.0, 1)
    with pytest.raises(ValueError, match="nothing slides"):
        shoe(sliding_direction=None).sliding_heat(1.0, 1, 20.0)


def test_a_scene_that_is_turned_has_the_same_heat() -> None:
    def heated(turned: bool) -> mtb.SlidingHeat:
        sides = (40e-3, 60e-3) if turned else (60e-3, 40e-3)
        block = mtb.scenes.block_on_plane(
            length=sides[0], width=sides[1], height=30e-3, spacing=5e-3, friction=0.2, velocity=20.0,
            sliding_direction=(0.0, 1.0) if turned else (1.0, 0.0), magnetic_pressure=1e6,
        )  # fmt: skip
        return block.sliding_heat(1.0, 4)

    along, across = heated(False), heated(True)
    for name in ("pressure", "heat_flux_upper", "heat_flux_lower", "temperature_upper"):
        one, other = (np.sort(np.ravel(getattr(h, name))) for h in (along, across))
        assert other == pytest.approx(one, abs=1e-8 * np.abs(one).max())
    assert across.heats_upper == pytest.approx(along.heats_upper, rel=1e-9)
