# SPDX-License-Identifier: MIT OR Apache-2.0
"""Scenes of two half-spaces: conditions of contact, balance, symmetry, conventions, loads."""

import dataclasses
import pickle
from typing import Any

import numpy as np
import pytest

import mtb_rs as mtb

steel = mtb.steel
rubber = mtb.Material(young_modulus=5e9, poisson_ratio=0.2)


SCENES = [
    ("paraboloid", mtb.scenes.paraboloid_on_plane(points=18)),
    ("unlike", mtb.scenes.paraboloid_on_plane(points=18, upper=rubber)),
    ("rigid", mtb.scenes.paraboloid_on_plane(points=14, upper=mtb.Rigid(), friction=1.0)),
    ("shoe", mtb.scenes.pole_shoe_on_rail(spacing=6e-3)),
    ("shoe, unlike", mtb.scenes.pole_shoe_on_rail(spacing=6e-3, upper=rubber, sliding_direction=(1, 1))),
    ("shoe, uneven", mtb.scenes.pole_shoe_on_rail(spacing=6e-3, magnetic_pressure=(3e6, 1e6))),
    ("block", mtb.scenes.block_on_plane(spacing=1e-2, upper=rubber)),
]


@pytest.mark.coarse
@pytest.mark.parametrize(("name", "scene"), SCENES, ids=[name for name, _ in SCENES])
def test_conditions_of_contact_hold(name, scene):
    r = scene.solve(model="half-space")
    p, g = r.pressure, r.gap
    assert r.report.converged
    assert r.report.residual < 1e-12
    assert p.min() >= 0.0
    assert g.min() >= 0.0
    assert not np.any((p > 0.0) & (g > 0.0))
    np.testing.assert_array_equal(r.status > 0, p > 0.0)
    # g = g0 + (u_upper - u_lower) . n - approach
    apart = ((r.displacement.upper - r.displacement.lower) * r.normal).sum(axis=0)
    approach = np.broadcast_to(r.approach, np.shape(r.approach))
    if approach.ndim:
        approach = np.concatenate(
            [np.full(patch.nx * patch.ny, a) for patch, a in zip(r.patches, approach, strict=True)]
        )
    identity = r.initial_gap + apart - approach * r.normal[2] - g
    assert np.abs(identity).max() < 1e-12 * np.abs(approach).max()
    # Coulomb, along the sliding direction, on the lower body
    friction = np.linalg.norm(r.traction, axis=0)
    np.testing.assert_allclose(friction, scene.friction * p, rtol=1e-12)
    assert (r.traction * r.normal).sum(axis=0) == pytest.approx(0.0, abs=1e-9 * p.max())
    assert np.all(r.traction[0] >= 0.0)
    # the balance of forces
    load = r.area * (r.traction - p * r.normal)
    np.testing.assert_allclose(r.force, load.reshape(3, -1).sum(axis=1), rtol=1e-12)
    assert r.report.force_balance["relative_error"] < 1e-12
    assert r.normal_force == pytest.approx(float((p * r.area).sum()), rel=1e-12)


@pytest.mark.coarse
def test_like_materials_decouple_and_unlike_ones_do_not():
    plain = mtb.scenes.paraboloid_on_plane(points=18, friction=0.0).solve()
    like = mtb.scenes.paraboloid_on_plane(points=18, friction=0.5).solve()
    np.testing.assert_array_equal(like.pressure, plain.pressure)
    peak = like.pressure.max()
    assert np.abs(like.pressure - like.pressure[:, ::-1]).max() < 1e-12 * peak
    unlike = mtb.scenes.paraboloid_on_plane(points=18, friction=0.5, upper=rubber).solve()
    assert np.abs(unlike.pressure - unlike.pressure[:, ::-1]).max() > 1e-2 * unlike.pressure.max()
    # ... but stay symmetric across the sliding direction
    assert np.abs(unlike.pressure - unlike.pressure[::-1]).max() < 1e-10 * unlike.pressure.max()


def test_like_materials_couple_a_little_on_the_crown_of_a_rail():
    plain = mtb.scenes.pole_shoe_on_rail(friction=0.0, spacing=6e-3).solve("half-space").pressure
    rubbed = mtb.scenes.pole_shoe_on_rail(friction=0.3, spacing=6e-3).solve("half-space").pressure
    apart = np.abs(rubbed - plain)
    # as the theory page says
    assert apart.mean() == pytest.approx(0.006 * plain.mean(), rel=0.1)
    assert apart.max() < 0.015 * plain.max()
    assert rubbed.max() == pytest.approx(1.008 * plain.max(), rel=5e-4)


@pytest.mark.coarse
def test_turning_the_sliding_direction_turns_the_solution():
    along_x = mtb.scenes.paraboloid_on_plane(points=16, upper=rubber).solve()
    along_y = mtb.scenes.paraboloid_on_plane(points=16, upper=rubber, sliding_direction=(0, 1)).solve()
    assert np.abs(along_y.pressure - along_x.pressure.T).max() < 1e-10 * along_x.pressure.max()
    backwards = mtb.scenes.paraboloid_on_plane(points=16, upper=rubber, sliding_direction=(-1, 0)).solve()
    assert np.abs(backwards.pressure - along_x.pressure[:, ::-1]).max() < 1e-10 * along_x.pressure.max()
    assert backwards.force[0] < 0.0 < along_x.force[0]


@pytest.mark.coarse
@pytest.mark.filterwarnings("ignore:young_modulus of the")
def test_scaling_is_exact():
    """Lengths times 2^k, moduli times 2^m: the solution scales to rounding, at any size."""
    base = mtb.scenes.paraboloid_on_plane(points=12, radius=1.0, force=100.0, upper=rubber).solve()
    for length, modulus in ((2.0**-20, 1.0), (2.0**10, 2.0**-12), (1.0, 2.0**20)):
        scaled = mtb.scenes.paraboloid_on_plane(
            points=12,
            radius=length,
            force=100.0 * modulus * length**2,
            upper=mtb.Material(rubber.young_modulus * modulus, rubber.poisson_ratio),
            lower=mtb.Material(steel.young_modulus * modulus, steel.poisson_ratio),
        ).solve()
        np.testing.assert_allclose(scaled.pressure, modulus * base.pressure, rtol=1e-10, atol=0.0)
        np.testing.assert_allclose(scaled.approach, length * base.approach, rtol=1e-10)


@pytest.mark.coarse
def test_force_and_approach_are_two_views_of_one_state():
    pressed = mtb.scenes.paraboloid_on_plane(points=20, upper=rubber).solve()
    moved = dataclasses.replace(
        mtb.scenes.paraboloid_on_plane(points=20, upper=rubber), force=None, approach=pressed.approach
    ).solve()
    np.testing.assert_allclose(
        moved.pressure, pressed.pressure, rtol=1e-9, atol=1e-9 * pressed.pressure.max()
    )
    assert moved.approach == pressed.approach


@pytest.mark.coarse
def test_moments_free_the_tilts():
    r = np.hypot(*np.meshgrid(np.linspace(-1, 1, 15), np.linspace(-1, 1, 15)))
    gap = np.where(r < 0.75, 0.0, 1.0)
    scene = mtb.Scene(
        upper=mtb.Rigid(), lower=steel, gap=gap, spacing=1e-3, force=1e3, moments=(0.3, -0.2), friction=0.0
    )
    result = scene.solve()
    load = result.pressure * result.area
    x, y = result.points[0], result.points[1]
    # moments of the load on the upper body are balanced by the contact's pressures
    assert (y * load).sum() == pytest.approx(-0.3, rel=1e-9)
    assert -(x * load).sum() == pytest.approx(0.2, rel=1e-9)
    with pytest.raises(mtb.ResultantError, match="outside what the contact can carry"):
        scene.with_(moments=(30.0, 0.0)).solve()


def test_friction_as_field_function_table_and_of_pressure():
    number = mtb.scenes.pole_shoe_on_rail(spacing=6e-3, upper=rubber, friction=0.3).solve(model="half-space")

    def solve(friction, velocity=None):
        scene = mtb.scenes.pole_shoe_on_rail(spacing=6e-3, upper=rubber, friction=friction, velocity=velocity)
        return scene.solve(model="half-space")

    for friction in (np.full(number.pressure.size, 0.3), lambda x, y: 0.3 + 0.0 * x, [0.3, 0.3]):
        np.testing.assert_array_equal(solve(friction).pressure, number.pressure)
    table = mtb.VelocityTable(velocity=(0.0, 10.0), value=(0.5, 0.1))
    np.testing.assert_allclose(solve(table, 5.0).pressure, number.pressure, rtol=1e-12)
    with pytest.raises(ValueError, match=r"velocity is 11 m/s: the table covers 0 to 10 m/s"):
        solve(table, 11.0)
    with pytest.raises(ValueError, match="friction is a table over velocity"):
        solve(table)
    falling = solve(mtb.PressureDependentFriction(lambda p: 0.4 / (1.0 + p / 1e7)))
    ratio = np.linalg.norm(falling.traction, axis=0)
    np.testing.assert_allclose(
        ratio, 0.4 / (1.0 + falling.pressure / 1e7) * falling.pressure, rtol=1e-8, atol=1e-8 * ratio.max()
    )


def test_magnetic_pressure_in_all_its_forms():
    base = mtb.scenes.pole_shoe_on_rail(spacing=6e-3).solve(model="half-space")
    both = mtb.scenes.pole_shoe_on_rail(spacing=6e-3, magnetic_pressure=(3e6, 3e6)).solve(model="half-space")
    np.testing.assert_array_equal(both.pressure, base.pressure)
    uneven = mtb.scenes.pole_shoe_on_rail(spacing=6e-3, magnetic_pressure=(3e6, 1e6)).solve(
        model="half-space"
    )
    left, right = (
        patch.view(uneven.pressure * uneven.area * uneven.normal[2]).sum() for patch in uneven.patches
    )
    assert left == pytest.approx(3.0 * right, rel=1e-12)
    hill = mtb.GaussianPressure(peak=3e6, center=(-45e-3, 13.8e-3), sigma=(30e-3, 10e-3))
    gaussian = mtb.scenes.pole_shoe_on_rail(spacing=6e-3, magnetic_pressure=hill).solve(model="half-space")
    x, y = gaussian.points[:2]
    pull = (hill(x, y) * gaussian.area * gaussian.normal[2]).sum()
    assert gaussian.force[2] == pytest.approx(-pull, rel=1e-12)
    assert hill(np.array([-45e-3]), np.array([-13.8e-3]))[0] == pytest.approx(3e6)


def test_one_pole_and_a_displaced_shoe():
    one = mtb.scenes.pole_shoe_on_rail(spacing=6e-3, poles=1).solve(model="half-space")
    assert np.all(one.points[1] > 0.0)
    assert np.ndim(one.approach) == 0
    for moved in ({"lateral": 2e-6}, {"yaw": 1e-5}):
        r = mtb.scenes.pole_shoe_on_rail(spacing=3e-3, **moved).solve(model="half-space")
        left, right = (patch.view(r.pressure) for patch in r.patches)
        assert np.abs(left - right[::-1]).max() > 1e-3 * r.pressure.max()
        assert r.report.force_balance["relative_error"] < 1e-12


def test_results_pickle_and_repeat_bit_by_bit():
    scene = mtb.scenes.pole_shoe_on_rail(spacing=6e-3, upper=rubber)
    first = scene.solve(model="half-space")
    again = pickle.loads(pickle.dumps(scene)).solve(model="half-space")
    np.testing.assert_array_equal(first.pressure, again.pressure)
    copy = pickle.loads(pickle.dumps(first))
    np.testing.assert_array_equal(copy.pressure, first.pressure)
    assert copy.report.residual == first.report.residual


BAD = [
    (lambda: mtb.scenes.paraboloid_on_plane(radius=-1.0), "radius is -1.0: a positive number"),
    (lambda: mtb.scenes.paraboloid_on_plane(force=float("nan")), "force is nan"),
    (lambda: mtb.scenes.paraboloid_on_plane(points=3), "points is 3"),
    (lambda: mtb.scenes.pole_shoe_on_rail(friction=-0.1).solve(), "friction is .*-0.1.* at point 0"),
    (lambda: mtb.scenes.pole_shoe_on_rail(friction=np.ones(7)).solve(), r"friction has shape \(7,\)"),
    (lambda: mtb.scenes.pole_shoe_on_rail(magnetic_pressure=-3e6).solve(), "does not press the bodies"),
    (lambda: mtb.scenes.pole_shoe_on_rail(spacing=0.0).solve(), "spacing"),
    (lambda: mtb.scenes.pole_shoe_on_rail(sliding_direction=(0, 0)).solve(), "sliding_direction"),
    (lambda: mtb.scenes.pole_shoe_on_rail(attraction="down"), "attraction is 'down'"),
    (lambda: mtb.scenes.pole_shoe_on_rail().solve(model="fem"), "model is 'fem'"),
    (lambda: mtb.scenes.pole_shoe_on_rail().solve(tolerance=0), "tolerance is 0"),
    (lambda: mtb.Material(-1.0, 0.3), "young_modulus is -1.0"),
    (lambda: mtb.Material(1.0, 0.51), "poisson_ratio is 0.51"),
    (lambda: mtb.Material(1.0, -1.0), "poisson_ratio is -1"),
    (lambda: mtb.Scene(upper=steel, lower=steel, spacing=1.0, force=1.0), "gap is missing"),
    (lambda: mtb.Scene(upper=steel, lower=steel, gap=np.zeros((2, 2)), force=1.0), "at least 3 points"),
    (
        lambda: mtb.Scene(upper=steel, lower=steel, gap=np.full((4, 4), np.nan), force=1.0),
        r"gap\[0, 0\] is nan",
    ),
    (lambda: mtb.Scene(upper=steel, lower=steel, gap=np.zeros((4, 4))), "nothing presses"),
    (
        lambda: mtb.Scene(upper=steel, lower=steel, gap=np.zeros((4, 4)), force=1.0, approach=1.0),
        "force and approach press",
    ),
    (
        lambda: mtb.Scene(upper=mtb.Rigid(), lower=mtb.Rigid(), gap=np.zeros((4, 4)), force=1.0),
        "both Rigid",
    ),
    (lambda: mtb.Scene(upper="steel", lower=steel, gap=np.zeros((4, 4)), force=1.0), "upper is 'steel'"),
    (
        lambda: mtb.Scene(upper=steel, lower=steel, gap=np.zeros((4, 4)), force=1.0).solve(),
        "contact reaches the edge of the grid of 4 x 4 points",
    ),
    (
        lambda: mtb.Scene(upper=steel, lower=steel, gap=np.ones((4, 4)), approach=0.5, spacing=1.0).solve(),
        "the bodies never touch",
    ),
]


@pytest.mark.parametrize(("call", "message"), BAD, ids=[message[:30] for _, message in BAD])
def test_bad_input_is_named(call, message):
    with pytest.raises(ValueError, match=message):
        call()


@pytest.mark.coarse
@pytest.mark.parametrize("points", [13, 14])
def test_a_symmetric_scene_is_solved_as_its_half(points):
    """Same numbers to rounding as the whole, which the least asymmetry brings back."""
    for upper in (steel, rubber):
        scene = mtb.scenes.paraboloid_on_plane(points=points, upper=upper)
        half = scene.solve()
        assert "mirror half" in half.report.solver
        friction = np.full((points, points), 0.5)
        friction[0, 0] += 1e-9  # outside the contact, but not symmetric
        whole = mtb.scenes.paraboloid_on_plane(points=points, upper=upper, friction=friction).solve()
        assert "mirror half" not in whole.report.solver
        np.testing.assert_allclose(half.pressure, whole.pressure, rtol=0, atol=1e-11 * whole.pressure.max())
        assert half.approach == pytest.approx(whole.approach, rel=1e-12)
    shoe = mtb.scenes.pole_shoe_on_rail(spacing=6e-3, upper=rubber).solve(model="half-space")
    assert "mirror half" in shoe.report.solver
    uneven = mtb.scenes.pole_shoe_on_rail(
        spacing=6e-3, upper=rubber, magnetic_pressure=(3e6, 3e6 * (1 + 1e-9))
    ).solve(model="half-space")
    assert "mirror half" not in uneven.report.solver
    np.testing.assert_allclose(shoe.pressure, uneven.pressure, rtol=1e-7)


@pytest.mark.coarse
def test_a_solved_scene_is_the_normal_contact_of_rolling():
    wheel = mtb.scenes.wheel_on_rail(spacing=4e-4).solve()
    roll = mtb.solve_tangential(wheel, motion=mtb.Rolling(creepage=(1e-3, 0, 0)), friction=mtb.Coulomb(0.3))
    assert 0.0 < roll.force[0] < 0.3 * wheel.normal_force


def test_changed_scenes_and_uneven_loads_are_not_misreported():
    scene = mtb.scenes.pole_shoe_on_rail(spacing=6e-3, poles=1).with_(friction=0.1)
    result = scene.solve(model="half-space")
    assert result.summary["friction"] == 0.1
    assert result.force[0] == pytest.approx(0.1 * result.normal_force, rel=1e-12)
    uneven = mtb.scenes.pole_shoe_on_rail(spacing=6e-3, magnetic_pressure=(3e6, 1e6))
    with pytest.raises(ValueError, match="lowers all poles together"):
        uneven.solve(method="incremental")


N = 30
BOWL = 1e-5 * np.add.outer(2.0 * np.linspace(-1.0, 1.0, N) ** 2, np.linspace(-1.0, 1.0, N) ** 2)
UNLIKE = mtb.Scene(upper=steel, lower=rubber, gap=BOWL, spacing=0.3e-3, friction=0.5, force=100.0)
cork = mtb.Material(young_modulus=30e6, poisson_ratio=0.0)
ramp = np.tile(np.linspace(0.0, 0.6, N), (N, 1))


@pytest.mark.coarse
@pytest.mark.parametrize(
    "scene",
    [
        UNLIKE,
        UNLIKE.with_(force=None, approach=1.5e-6, sliding_direction=(1.0, -2.0)),
        UNLIKE.with_(upper=mtb.Rigid(), friction=ramp),
        UNLIKE.with_(friction=mtb.PressureDependentFriction(lambda p: 0.5 / (1.0 + p / 1e7))),
        UNLIKE.with_(moments=(0.02, -0.05)),
        UNLIKE.with_(lower=steel, force=1e3, moments=(0.2, -0.5)),
        # the opening by friction is as large as what the pressure closes
        UNLIKE.with_(lower=cork, friction=2.0, force=0.2),
        mtb.scenes.block_on_plane(spacing=4e-3, lower=cork, friction=2.0, magnetic_pressure=1e3),
    ],
    ids=["force", "approach", "field", "of pressure", "moments", "moments, like", "strong", "punch"],
)
def test_large_grids_are_solved_by_convolutions_to_the_same_numbers(scene, monkeypatch):
    dense = scene.solve(model="half-space")
    monkeypatch.setattr("mtb_rs.scenes.direct.DENSE_POINTS", 1)
    found = scene.solve(model="half-space")
    assert "dense" in dense.report.solver
    assert "FFT" in found.report.solver
    assert np.linalg.norm(found.pressure - dense.pressure) < 2e-8 * np.linalg.norm(dense.pressure)
    moved = np.abs(dense.displacement.lower).max()
    np.testing.assert_allclose(found.gap, dense.gap, atol=1e-8 * moved)
    np.testing.assert_allclose(found.force, dense.force, rtol=1e-7, atol=1e-7 * dense.normal_force)
    for one, other in zip(found.displacement, dense.displacement, strict=True):
        np.testing.assert_allclose(one, other, atol=1e-8 * np.abs(other).max())


def test_a_large_scene_of_unlike_bodies_is_solved_and_estimated():
    x = np.linspace(-1.0, 1.0, 150)
    scene = UNLIKE.with_(gap=1e-5 * np.add.outer(2.0 * x**2, x**2), spacing=0.06e-3)
    found = scene.solve(tolerance=0.02)
    assert found.error_estimate < 0.02
    operations = found.report.operations
    assert operations["choice and estimate"] < operations["solution"]


def test_a_tilt_that_no_contact_carries_is_named_on_large_grids_too(monkeypatch):
    monkeypatch.setattr("mtb_rs.scenes.direct.DENSE_POINTS", 1)
    for friction in (0.0, 0.5):
        with pytest.raises(mtb.ResultantError, match="outside what the contact can carry"):
            UNLIKE.with_(friction=friction, moments=(30.0, 0.0)).solve(model="half-space")


def test_more_points_than_the_memory_holds_are_refused():
    with pytest.raises(ValueError, match=r"70200 contact points take 197.1 GB; the limit is 8 GB"):
        mtb.scenes.pole_shoe_on_rail(spacing=0.2e-3, lateral=1e-4).solve(model="half-space")


@pytest.mark.coarse
def test_a_changed_copy_of_a_scene_has_the_gap_and_the_bodies_it_says():
    other = BOWL[:, ::-1] + 1e-6 * np.linspace(0.0, 1.0, N)
    for changed in (UNLIKE.with_(gap=other), dataclasses.replace(UNLIKE, gap=other)):
        found = changed.solve()
        np.testing.assert_array_equal(
            found.pressure, dataclasses.replace(changed, geometry=None).solve().pressure
        )
        assert not np.array_equal(found.pressure, UNLIKE.solve().pressure)
    with pytest.raises(ValueError, match=r"spacing is .*, the gap is given on cells of .*0\.0003"):
        UNLIKE.with_(spacing=0.15e-3)
    with pytest.raises(ValueError, match="a gap is given, but block_on_plane has a geometry of its own"):
        mtb.scenes.block_on_plane().with_(gap=BOWL)
    # by any gap, also one that no scene would take
    with pytest.raises(ValueError, match="a gap is given, but block_on_plane has a geometry of its own"):
        mtb.scenes.block_on_plane().with_(gap=BOWL[0])


def test_like_poles_couple_through_the_rail_and_through_nothing_else() -> None:
    def pressure(poles: int, friction: float, **options: Any) -> np.ndarray:
        scene = mtb.scenes.pole_shoe_on_rail(poles=poles, friction=friction, spacing=6e-3, **options)
        return scene.solve("half-space").pressure

    alone = pressure(1, 0.0)
    assert np.abs(pressure(1, 0.3) - alone).max() < 1e-12 * alone.max()
    both = pressure(2, 0.0)
    assert 5e-3 < np.abs(pressure(2, 0.3) - both).max() / both.max() < 5e-2
    # not so of unlike ones
    soft = mtb.Material(70e9, 0.33)
    unlike = pressure(1, 0.0, upper=soft)
    assert np.abs(pressure(1, 0.3, upper=soft) - unlike).max() > 1e-3 * unlike.max()
