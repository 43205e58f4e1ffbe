# SPDX-License-Identifier: MIT OR Apache-2.0
"""Elastic blocks and shoes in one solve, against independent finite-element programs and the thesis' loop."""

import csv
import gzip
import pickle
from pathlib import Path

import numpy as np
import pytest

import mtb_rs as mtb

pytestmark = pytest.mark.usefixtures("own_cache")

DATA = Path(__file__).parents[1] / "data" / "fe"


def reference(name):
    with gzip.open(DATA / f"{name}_contact.csv.gz", "rt") as file:
        rows = list(csv.DictReader(file))
    return {key: np.array([float(row[key]) for row in rows]) for key in rows[0]}


def at(patch, result, values, x, y):
    """Values of a result at places x, y, bilinear between the contact points."""
    own_x = patch.view(result.points[0].reshape(-1))[0]
    own_y = patch.view(result.points[1].reshape(-1))[:, 0]
    grid = patch.view(values.reshape(-1))
    order = np.argsort(own_y)
    along = np.array([np.interp(x, own_x, row) for row in grid[order]])
    return np.array([np.interp(v, own_y[order], column) for v, column in zip(y, along.T, strict=True)])


@pytest.mark.parametrize(
    ("name", "height", "friction"),
    [("block_h100_he5", 0.1, 0.5), ("block_h100_he5_mu0", 0.1, 0.0), ("block_h050_he5", 0.05, 0.5)],
)
@pytest.mark.slow
def test_block_against_calculix(name, height, friction):
    """Normal force within 3 %, pressure within 5 % and u_z within 2 % in the mean, away from the border."""
    ref = reference(name)
    result = mtb.scenes.block_on_plane(height=height, friction=friction).solve(model="elastic-upper")
    assert result.normal_force == pytest.approx(2.0 * ref["p_lump"] @ ref["area"], rel=0.03)
    inner = (np.abs(ref["x"]) < 0.0451) & (ref["y"] < 0.0451)
    counted = inner & (ref["p_lump"] > 0.1 * ref["p_lump"].mean())
    p = at(result.patches[0], result, result.pressure, ref["x"], ref["y"])
    assert (np.abs(p - ref["p_lump"])[counted] / ref["p_lump"][counted]).mean() < 0.025
    u = at(result.patches[0], result, result.displacement.upper[2], ref["x"], ref["y"])
    assert (np.abs(u - ref["uz_s"])[inner] / np.abs(ref["uz_s"][inner])).mean() < 0.02
    assert ((p > 0.0) == (ref["contact"] > 0)).mean() > 0.97
    # tangentially: friction coefficient times pressure, and nothing else
    assert result.force[0] == pytest.approx(friction * result.normal_force, rel=1e-12, abs=1e-6)
    assert result.report.residual < 1e-12


@pytest.mark.slow
def test_thin_shoe_against_calculix():
    """Height 7.45 mm: pressure within 12 % on a half-space rail, 4 % (u_z 3 %) on the rail itself."""
    ref = reference("shoe_xi7_ny8_zfree")
    inner = (np.abs(ref["x"]) < 0.0455) & (ref["y"] > 0.0065) & (ref["y"] < 0.0213)
    for model, spacing, bound in (
        ("elastic-upper", (3e-3, 1.95e-3), 0.06),
        ("elastic-both", (4e-3, 1.95e-3), 0.04),
    ):
        scene = mtb.scenes.pole_shoe_on_rail(height=7.45e-3, length=96e-3, spacing=spacing)
        result = scene.solve(model=model)
        left = result.patches[0]
        p = at(left, result, result.pressure, ref["x"], ref["y"])
        assert (np.abs(p - ref["p_lump"])[inner] / ref["p_lump"][inner]).mean() < bound
        assert ((p > 0.0) == (ref["contact"] > 0)).mean() > 0.97
        one_pole = left.view(result.pressure * result.area).sum()
        assert one_pole == pytest.approx(ref["p_lump"] @ ref["area"], rel=2e-3)
        # the top is free in z: contact carries the whole pull
        assert result.force[2] == pytest.approx(result.report.force_balance["magnetic"][2], rel=1e-8)
        assert result.report.force_balance["relative_error"] < 1e-10
    u = at(left, result, result.displacement.upper[2], ref["x"], ref["y"])
    assert (np.abs(u - ref["uz_s"])[inner] / np.abs(ref["uz_s"][inner])).mean() < 0.03


@pytest.mark.coarse
def test_conditions_of_contact_hold_for_elastic_bodies():
    scenes = {
        "shoe": mtb.scenes.pole_shoe_on_rail(spacing=6e-3),
        "uneven": mtb.scenes.pole_shoe_on_rail(spacing=6e-3, magnetic_pressure=(3e6, 2e6)),
        "clamped": mtb.scenes.pole_shoe_on_rail(spacing=6e-3, supports="clamped-top"),
        "both pulled": mtb.scenes.pole_shoe_on_rail(spacing=6e-3, attraction="both"),
        "askew": mtb.scenes.pole_shoe_on_rail(spacing=6e-3, lateral=1e-6, yaw=1e-6),
        "lateral": mtb.scenes.pole_shoe_on_rail(spacing=6e-3, sliding_direction=(0.2, 1.0), friction=0.2),
        "block": mtb.scenes.block_on_plane(spacing=1e-2, friction=0.8),
    }
    for name, scene in scenes.items():
        r = scene.solve(model="elastic-upper")
        assert r.report.residual < 1e-10, name
        assert r.pressure.min() >= 0.0, name
        assert r.gap.min() >= 0.0, name
        assert not np.any((r.pressure > 0.0) & (r.gap > 0.0)), name
        np.testing.assert_array_equal(r.status > 0, r.pressure > 0.0)
        apart = ((r.displacement.upper - r.displacement.lower) * r.normal).sum(axis=0)
        identity = r.initial_gap + apart - r.gap
        size = np.abs(apart).max() + r.initial_gap.max()
        assert np.abs(identity).max() < 1e-9 * size, name
        friction = np.linalg.norm(r.traction, axis=0)
        np.testing.assert_allclose(friction, scene.friction * r.pressure, rtol=1e-9, atol=1.0)


def test_the_supports_decide_what_reaches_the_rail():
    free = mtb.scenes.pole_shoe_on_rail(spacing=6e-3, height=7.45e-3).solve(model="elastic-upper")
    held = mtb.scenes.pole_shoe_on_rail(spacing=6e-3, height=7.45e-3, supports="clamped-top").solve(
        model="elastic-upper"
    )
    assert held.normal_force < 0.15 * free.normal_force
    guided = mtb.scenes.pole_shoe_on_rail(spacing=6e-3, height=70e-3, supports="points").solve(
        model="elastic-upper"
    )
    assert guided.force[2] == pytest.approx(free.force[2], rel=2e-3)


@pytest.mark.coarse
def test_wedging_is_named_and_never_returned_as_an_answer():
    with pytest.raises(mtb.ConvergenceError, match="no sliding equilibrium: the body wedges") as caught:
        mtb.scenes.block_on_plane(height=0.5, spacing=1e-2).solve(model="elastic-upper")
    assert not caught.value.result.report.converged
    margins = []
    for friction in (0.1, 0.2):
        result = mtb.scenes.block_on_plane(height=0.5, spacing=1e-2, friction=friction).solve(
            model="elastic-upper"
        )
        margins.append(result.report.wedging_margin)
    assert margins[1] == pytest.approx(2.0 * margins[0], rel=1e-6)
    # 12 x 12 hexahedra gave mu_sym = .256 for this slenderness
    assert 0.2 / margins[1] == pytest.approx(0.256, rel=0.06)


def test_the_whole_body_follows_from_the_contact():
    result = mtb.scenes.pole_shoe_on_rail(spacing=6e-3).solve(model="elastic-upper")
    states = result.states()
    assert set(states) == {"left pole", "right pole"}
    for name, state in states.items():
        assert state.left_over < 1e-8 * result.normal_force, name
    reaction = sum(sum(state.reactions.values()) for state in states.values())
    # supports, contact and attraction balance
    pull = result.report.force_balance["magnetic"]
    assert np.abs(reaction - result.force + pull).max() < 1e-7 * result.normal_force
    assert states["left pole"].von_mises.max() > result.pressure.max() * 0.1


def test_staggered_scheme_converges_to_the_doubly_counted_contact():
    scene = mtb.scenes.pole_shoe_on_rail(spacing=6e-3)
    loop = scene.solve(
        model="elastic-upper", method="staggered", max_iterations=300, displacement_tolerance=1e-9
    )
    fast = scene.solve(
        model="elastic-upper",
        method="staggered",
        max_iterations=60,
        displacement_tolerance=1e-9,
        anderson_depth=6,
    )
    np.testing.assert_allclose(loop.pressure, fast.pressure, rtol=0, atol=1e-6 * loop.pressure.max())
    assert fast.report.iterations < loop.report.iterations
    # the reported surfaces enclose the reported gap: the scheme moves the upper one twice
    apart = (loop.displacement.upper - loop.displacement.lower) * loop.normal
    opened = loop.initial_gap + apart.sum(axis=0)
    assert np.abs(opened - loop.gap).max() < 1e-5 * np.abs(apart).max()
    direct = scene.solve(model="elastic-upper")
    apart = np.linalg.norm(loop.pressure - direct.pressure) / np.linalg.norm(direct.pressure)  # type: ignore[assignment]
    assert 0.01 < apart < 0.5
    with pytest.raises(mtb.ConvergenceError, match="not converged"):
        scene.solve(model="elastic-upper", method="staggered", factor=0.5)
    # points that share a height: a predicted factor alone is not done in the thesis' 20 iterations
    pole = mtb.scenes.pole_shoe_on_rail(poles=1, supports="points")
    held = pole.solve(model="elastic-upper", method="staggered")
    assert "5 iterates combined" in held.report.solver
    slow = pole.solve(model="elastic-upper", method="staggered", max_iterations=200)
    assert held.normal_force == pytest.approx(slow.normal_force, rel=1e-4)
    tall = mtb.scenes.block_on_plane(height=0.5, spacing=2e-2)
    with pytest.raises(mtb.ConvergenceError, match=r"the body wedges\. The friction coefficient is 0.5"):
        tall.solve(model="elastic-upper", method="staggered")
    for option, value, needed in (
        ("factor", "a", "a finite number"),
        ("factor", -1, "a positive number"),
        ("max_iterations", 2.5, "a positive whole number"),
        ("displacement_tolerance", 0, "a positive number"),
        ("anderson_depth", -1, "a positive whole number"),
    ):
        with pytest.raises(ValueError, match=f"{option} is {value!r}: {needed} is needed"):
            tall.solve(model="elastic-upper", method="staggered", **{option: value})
    with pytest.raises(ValueError, match="unknown option 'relaxation' of the staggered method"):
        scene.solve(model="elastic-upper", method="staggered", relaxation=2.0)


def test_incremental_scheme_reaches_the_direct_solution_with_a_slight_asymmetry():
    scene = mtb.scenes.paraboloid_on_plane(points=18)
    direct, steps = scene.solve(), scene.solve(method="incremental")
    apart = np.linalg.norm(steps.pressure - direct.pressure) / np.linalg.norm(direct.pressure)
    assert apart < 2e-3
    askew = np.abs(steps.pressure - steps.pressure[:, ::-1]).max() / steps.pressure.max()
    assert 1e-5 < askew < 1e-2
    assert steps.report.method == "incremental"


def test_elastic_results_pickle():
    result = mtb.scenes.pole_shoe_on_rail(spacing=6e-3).solve(model="elastic-upper")
    copy = pickle.loads(pickle.dumps(result))
    np.testing.assert_array_equal(copy.pressure, result.pressure)
    state = copy.states()["left pole"]
    np.testing.assert_allclose(state.displacement, result.states()["left pole"].displacement, rtol=1e-9)


BAD = [
    (lambda: mtb.scenes.paraboloid_on_plane().solve(model="elastic-upper"), "no geometry for its elastic"),
    (lambda: mtb.scenes.block_on_plane().solve(model="elastic-both"), "no geometry for its elastic"),
    (
        lambda: mtb.scenes.pole_shoe_on_rail(upper=mtb.Rigid()).solve(model="elastic-upper"),
        "upper is Rigid",
    ),
    (lambda: mtb.scenes.pole_shoe_on_rail(supports="glue"), "supports is 'glue'"),
    (
        lambda: mtb.scenes.pole_shoe_on_rail(magnetic_pressure=-1e6).solve(model="elastic-upper"),
        "does not press the bodies together",
    ),
    (
        lambda: mtb.scenes.pole_shoe_on_rail(upper=mtb.Material(1e9, 0.5)).solve(model="elastic-upper"),
        "Poisson",
    ),
]


@pytest.mark.parametrize(("call", "message"), BAD, ids=[message[:30] for _, message in BAD])
def test_bad_input_is_named(call, message):
    with pytest.raises(ValueError, match=message):
        call()


@pytest.mark.slow
def test_a_layer_softens_the_start_and_changes_nothing_in_gross_sliding():
    pushes = np.outer(np.geomspace(0.2e-6, 100e-6, 9), [1.0, 0.0])
    layer = mtb.InterfaceLayer(thickness=1e-5, shear_modulus=1e8)
    plain = mtb.scenes.pole_shoe_on_rail(spacing=6e-3)
    soft = mtb.scenes.pole_shoe_on_rail(spacing=6e-3, layer=layer)
    starts = [scene.start_of_sliding(pushes, model="elastic-upper") for scene in (plain, soft)]
    forces = [start.force[:, 0] for start in starts]
    # the pressure follows: the force may pass its end a little, by what friction changes of the pressure
    assert np.all(np.diff(forces[0]) > -1e-3 * forces[0][-1])
    assert forces[1][0] < 0.9 * forces[0][0]
    # both end where everything slides, at friction times the normal force
    result = plain.solve(model="elastic-upper")
    assert forces[0][-1] == pytest.approx(0.5 * result.normal_force, rel=5e-3)
    with_layer = soft.solve(model="elastic-upper")
    np.testing.assert_array_equal(with_layer.pressure, result.pressure)
