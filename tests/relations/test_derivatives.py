# SPDX-License-Identifier: MIT OR Apache-2.0
"""Derivatives of sliding scenes and of their steps against differences of solves."""

from __future__ import annotations

import itertools
import pickle
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import mtb_rs as mtb
from mtb_rs.bodies.mesh import block_mesh

Array = NDArray[np.float64]

#: Cells are few, and bodies soft, so that many scenes are cheap.
pytestmark = [
    pytest.mark.filterwarnings("ignore::mtb_rs.ToleranceWarning"),
    pytest.mark.filterwarnings("ignore:.*(deforms|displaces|away from).*:UserWarning"),
]

SOFT, HARD = mtb.Material(80e9, 0.1), mtb.Material(200e9, 0.3)
TABLE = mtb.VelocityTable([0.0, 5.0, 20.0], [0.4, 0.3, 0.2])
N = 12
X = (np.arange(N) - 0.5 * (N - 1)) * 1e-3
ROUGH = 2e-7 * np.random.default_rng(7).random((N, N))
BALL = (X[None, :] ** 2 + X[:, None] ** 2) / 0.6 + ROUGH


def elastic(*, upper: bool) -> mtb.ElasticBody:
    x, y = np.linspace(-0.04, 0.04, 6), np.linspace(-0.02, 0.02, 4)
    mesh = block_mesh(x, y, 0.04)
    if upper:
        return mtb.ElasticBody(mesh, HARD, "bottom", [mtb.Support("top", x=0, y=0)])
    held = [mtb.Support("bottom", x=0, y=0, z=0)]
    return mtb.ElasticBody(mesh.moved(shift=(0.0, 0.0, -0.04)), SOFT, "top", held)


def ball(**given: Any) -> mtb.Scene:
    return mtb.Scene(
        **{"upper": SOFT, "lower": HARD, "gap": BALL, "spacing": 1e-3, "friction": 0.3, "velocity": 4.0}
        | given
    )


def on_block(**given: Any) -> mtb.Scene:
    def gap(x: Array, y: Array) -> Array:
        return np.asarray(6e-7 * (x / 0.04) ** 2 + 2e-7 * np.sin(90.0 * x + 130.0 * y))

    chosen = {"upper": elastic(upper=True), "lower": HARD, "gap": gap, "spacing": 8e-3, "friction": 0.3}
    return mtb.Scene(**chosen | given)


SCENES: dict[str, Callable[[], mtb.Scene]] = {
    "force": lambda: ball(force=2e3, sliding_direction=(1.0, 0.5)),
    "moments": lambda: ball(force=2e3, moments=(0.5, -1.0), friction=TABLE),
    "approach": lambda: ball(approach=8e-6, friction=lambda x, y: 0.2 + 10.0 * x),
    "hill": lambda: ball(
        magnetic_pressure=mtb.GaussianPressure(4e7, (0.0, 0.0), (4e-3, 3e-3)), attraction="both"
    ),
    "pull over the speed": lambda: ball(magnetic_pressure=mtb.VelocityTable([0.0, 5.0], [1e7, 2e7])),
    "friction by pressure": lambda: ball(
        force=2e3, friction=mtb.PressureDependentFriction(lambda p: 0.4 / (1.0 + p / 3e8))
    ),
    "smooth": lambda: ball(force=2e3, sliding_direction=None),
    "like": lambda: ball(lower=SOFT, force=2e3),
    "rigid": lambda: ball(lower=mtb.Rigid(), approach=8e-6),
    "elastic block": lambda: on_block(magnetic_pressure=3e6),
    "block under moments": lambda: on_block(force=2e4, moments=(20.0, -30.0)),
    "two elastic bodies": lambda: on_block(lower=elastic(upper=False), force=2e4),
    "table": lambda: on_block(
        upper=HARD,
        lower=elastic(upper=False),
        magnetic_pressure=3e6,
        attraction="both",
        friction=TABLE,
        velocity=7.0,
    ),
    "pressed by its support": lambda: on_block(
        upper=mtb.ElasticBody(
            elastic(upper=True).mesh, HARD, "bottom", [mtb.Support("top", x=0, y=0, z=-1e-6)]
        ),
        approach=2e-6,
    ),
    "prism": lambda: ball(lower=mtb.Prism((0.06, 0.05), SOFT), force=2e3),
    "prism on springs": lambda: ball(lower=mtb.Prism((0.06, 0.05), SOFT, foundation=(3e8, 1e8)), force=2e3),
    "ready block": lambda: mtb.scenes.block_on_plane(spacing=2e-2, friction=0.2),
    "ready shoe": lambda: mtb.scenes.pole_shoe_on_rail(spacing=1e-2, friction=[0.1, TABLE], velocity=3.0),
}


OF = ("force", "moment", "normal_force", "peak_pressure", "mean_pressure", "approach")


def numbers(found: Any, place: int, of: list[str]) -> Array:
    """Numbers of a result, the peak at the point where it was before the change."""
    known = {
        "force": found.force,
        "moment": found.moment,
        "friction_power": getattr(found, "friction_power", None),
        "normal_force": (found.pressure * found.area).sum(),
        "peak_pressure": found.pressure.flat[place],
        "mean_pressure": (found.pressure * found.area).sum() / found.area[found.status > 0].sum(),
        "approach": getattr(found, "approach", None),
    }
    return np.concatenate([np.ravel(known[name]) for name in of])


def sizes(found: Any, of: list[str]) -> Array:
    """How large they are when they are not balanced away."""
    force = float((found.pressure * found.area).sum())
    reach, peak = float(np.abs(found.points[:2]).max()), float(found.pressure.max())
    known = {
        "force": 3 * [force],
        "moment": 3 * [force * reach],
        "friction_power": [force],
        "normal_force": [force],
        "peak_pressure": [peak],
        "mean_pressure": [peak],
        "approach": np.size(getattr(found, "approach", 0.0)) * [1e-5],
    }
    return np.concatenate([known[name] for name in of])


def agree(by: str, found: Any, wanted: Array, scale: Array, size: float) -> None:
    """`found` equals differences to 1e-6, and to their digits where a number of its size is balanced away."""
    own = np.concatenate([np.ravel(v) for v in found])
    allowed = 1e-6 * np.abs(wanted) + 2e-8 * scale / size
    assert np.all(np.abs(own - wanted) <= allowed), (by, own, wanted, allowed)


def richardson(of: Callable[[float], Array], by: float) -> Array:
    """Central difference, extrapolated."""
    wide, narrow = ((of(h) - of(-h)) / (2.0 * h) for h in (by, 0.5 * by))
    return np.asarray((4.0 * narrow - wide) / 3.0)


def moved(scene: mtb.Scene, by: str, k: int, e: float) -> mtb.Scene:
    """The scene with one number of an argument changed by e."""
    if "." in by:
        side, name = by.split(".")
        body = getattr(scene, side)
        material = replace(body.material, **{name: getattr(body.material, name) + e})
        return replace(scene, **{side: replace(body, material=material)})
    value = getattr(scene, by)
    if isinstance(value, mtb.VelocityTable):
        rows = [v + e * (j == k) for j, v in enumerate(value.value)]
        return replace(scene, **{by: mtb.VelocityTable(value.velocity, rows)})
    if isinstance(value, mtb.GaussianPressure):
        return replace(scene, **{by: replace(value, peak=value.peak + e)})
    if isinstance(value, (tuple, list)) and isinstance(value[0], float):
        flat = list(value)
        if k == 0:
            flat[0] += e
        else:
            table = flat[1] if by == "friction" else None
            if table is None:
                flat[1] += e
            else:
                rows = [v + e * (j == k - 1) for j, v in enumerate(table.value)]
                flat[1] = mtb.VelocityTable(table.velocity, rows)
        return replace(scene, **{by: type(value)(flat)})
    return replace(scene, **{by: value + e})


def size_of(scene: mtb.Scene, by: str) -> float:
    """The size of a number that is given; differences take a ten-thousandth of it."""
    if "." in by:
        side, name = by.split(".")
        return float(getattr(getattr(scene, side).material, name))
    return {
        "force": scene.force or 0.0, "approach": 8e-6, "moments": 10.0, "friction": 0.3, "velocity": 4.0,
        "sliding_direction": 1.0, "magnetic_pressure": 3e6,
    }[by]  # fmt: skip


@pytest.mark.coarse
@pytest.mark.parametrize("name", SCENES)
def test_of_scenes(name: str) -> None:
    scene = SCENES[name]()
    result = scene.solve(model=scene.models[-1])
    model = result.model
    inputs = result._tangent().inputs
    of = [number for number in OF if number in result._functionals()]
    gradients = [result.gradient(number) for number in of]
    closed, scale, place = result.status > 0, sizes(result, of), int(result.pressure.argmax())
    assert closed.sum() > 3

    def solved(changed: mtb.Scene) -> Array:
        found = changed.solve(model=model)
        assert np.array_equal(found.status > 0, closed), "the step of the difference is too large"
        return numbers(found, place, of)

    compared = 0
    for by, shape in inputs.items():
        if by.endswith("_field") or by == "gap":
            continue
        size = size_of(scene, by)
        for k, index in enumerate(np.ndindex(shape)):
            # a condensation has fewer digits than a solve
            width = (1e-3 if by.endswith("poisson_ratio") else 1e-4) * size
            if name == "prism on springs" and by.startswith("lower"):
                width *= 10.0  # the springs leave fewer still
            wanted = richardson(lambda e: solved(moved(scene, by, k, e)), width)  # noqa: B023
            agree(by, [np.asarray(g[by])[(..., *index)] for g in gradients], wanted, scale, size)
            compared += 1
            # the other way round
            field = np.asarray(result.derivative("pressure", by))[(..., *index)]
            total = np.asarray(result.derivative("normal_force", by))[index]
            assert (field * result.area).sum() == pytest.approx(total, rel=1e-8, abs=1e-10 * scale[0] / size)
    assert compared
    # fields, along a direction without structure
    weights = np.random.default_rng(3).uniform(-1.0, 1.0, result.pressure.shape)
    axes = tuple(range(-weights.ndim, 0))
    if isinstance(scene.gap, np.ndarray):
        wanted = richardson(lambda e: solved(replace(scene, gap=BALL + e * weights)), 1e-9)
        agree("gap", [(g["gap"] * weights).sum(axis=axes) for g in gradients], wanted, scale, 1e-5)
    friction = result_friction(scene, result)
    if friction is not None:
        wanted = richardson(lambda e: solved(replace(scene, friction=(friction + e * weights).ravel())), 3e-5)
        agree(
            "friction",
            [(g["friction_field"] * weights).sum(axis=axes) for g in gradients],
            wanted,
            scale,
            0.3,
        )


def result_friction(scene: mtb.Scene, result: mtb.Result) -> Array | None:
    """The friction coefficient at the points of a result, where it does not depend on the pressure."""
    if scene.sliding_direction is None or isinstance(scene.friction, mtb.PressureDependentFriction):
        return None
    if callable(scene.friction):
        return np.asarray(scene.friction(result.points[0], result.points[1]))
    if isinstance(scene.friction, tuple):
        table = 0.4 - 0.1 * 3.0 / 5.0
        return np.where(result.points[1] > 0.0, 0.1, table)
    value = (
        TABLE.bracket(scene.velocity or 0.0) if scene.friction is TABLE else (scene.friction,) * 2 + (0.0,)
    )
    return np.full(result.pressure.shape, value[0] + value[2] * (value[1] - value[0]))


def test_weights_and_functions_of_fields() -> None:
    result = ball(force=2e3).solve(model="half-space")
    left = result.points[0] < 0.0
    on_left = result.derivative({"pressure": result.area * left}, "friction")
    on_right = result.derivative({"pressure": result.area * ~left}, "friction")
    # the force is given
    assert on_left == pytest.approx(-on_right, rel=1e-9)
    squares = result.derivative(lambda r: ((r.pressure**2).sum(), {"pressure": 2.0 * r.pressure}), "force")
    assert squares == pytest.approx((2.0 * result.pressure * result.derivative("pressure", "force")).sum())
    whole = result.derivative("pressure", "gap")
    assert whole.shape == (N, N, N, N)
    # of bodies that friction does not couple, and areas that are equal, it is symmetric
    smooth = ball(force=2e3, sliding_direction=None).solve(model="half-space").derivative("pressure", "gap")
    flat = smooth.reshape(N * N, N * N)
    assert np.abs(flat - flat.T).max() < 1e-9 * np.abs(flat).max()
    assert set(result.gradient("force")) >= {"gap", "friction", "force", "friction_field"}
    # nothing moves under an approach
    held = ball(approach=8e-6).solve(model="half-space")
    assert held.derivative("motion", "gap").shape == (0, N, N)
    traction = result.derivative("traction", "friction")
    assert traction[0].sum() * 1e-6 == pytest.approx(result.derivative("force", "friction")[0])


def test_numbers_in_a_row_have_the_derivatives_of_each() -> None:
    scene = on_block(force=2e4, velocity=4.0, friction=TABLE)
    results: list[Any] = [scene.solve(model="elastic-upper")]
    contact = scene.prepare("elastic-upper")
    # the second by factors of another friction
    results += [contact.step(velocity=v) for v in (4.0, 12.0)]
    pressed = mtb.solve_normal(BALL, 1e-3, lower=SOFT, upper=HARD, force=2e3)
    results.append(mtb.solve_tangential(pressed, mtb.Rolling((1e-3, 5e-4, 0.1)), mtb.Coulomb(0.3)))
    for result in results:
        weights = {"traction": np.random.default_rng(1).random(result._tangent().fields["traction"])}
        of = ["force", "friction_power", weights, "peak_pressure"]
        alone = [result.gradient(part) for part in of]
        together = result.gradient(of)
        assert list(together) == list(alone[0])
        for by, shape in together.inputs.items():
            wanted = np.concatenate([np.reshape(g[by], (-1, *shape)) for g in alone])
            assert wanted.shape == together[by].shape == (6, *shape)
            np.testing.assert_allclose(together[by], wanted, rtol=1e-9, atol=1e-9 * abs(wanted).max())
            np.testing.assert_array_equal(result.derivative(of, by), together[by])


def test_hertz() -> None:
    """dF/d(approach) = 2 a E* [Johnson1985, chapter 4], to the grid's error, which falls with the cells."""
    errors = []
    for points in (24, 48):
        scene = mtb.scenes.paraboloid_on_plane(force=1e3, points=points)
        pressed = scene.solve(model="half-space")
        approach = float(pressed.approach)
        gap, spacing = pressed.initial_gap, pressed.report.spacing
        held = mtb.Scene(scene.upper, scene.lower, gap=gap, spacing=spacing, approach=approach)
        slope = held.solve(model="half-space").derivative("normal_force", "approach")
        # F = c approach^1.5
        errors.append(abs(slope / (1.5 * 1e3 / approach) - 1.0))
    assert errors[1] < 0.7 * errors[0]
    assert errors[1] < 2e-2


def test_both_sides_of_a_touching_point() -> None:
    """Where a point only just touches, each side has its own derivative, and the margin says so."""
    scene = ball(approach=8e-6, sliding_direction=None)
    touching = scene.solve(model="half-space")
    assert touching.margin().smallest > 1e-5
    # raise one gap beside the contact until it is nought
    beside = np.where(touching.status == 0, touching.gap, np.inf)
    k = np.unravel_index(beside.argmin(), beside.shape)
    slope = touching.derivative("gap", "approach")[k]
    at = 8e-6 - float(beside[k]) / slope
    sides = [scene.with_(approach=at + e).solve(model="half-space") for e in (-1e-11, 1e-11)]
    assert all(side.margin().smallest < 1e-4 for side in sides)
    below, above = (side.derivative("normal_force", "approach") for side in sides)
    assert above > below * (1.0 + 1e-6)
    for side, sign, slope in zip(sides, (-1.0, 1.0), (below, above), strict=True):
        h = 1e-10
        there = [scene.with_(approach=at + sign * (1e-11 + e)).solve(model="half-space") for e in (h, 2 * h)]
        one, two = (
            sign * (s.normal_force - side.normal_force) / e for s, e in zip(there, (h, 2 * h), strict=True)
        )
        assert 2.0 * one - two == pytest.approx(slope, rel=1e-5)


STEPS: dict[str, Callable[[], mtb.Scene]] = {
    "ball": lambda: ball(force=2e3, moments=(0.0, 0.0), friction=TABLE),
    "hill": SCENES["hill"],
    "elastic block": lambda: on_block(magnetic_pressure=3e6, friction=TABLE, velocity=4.0),
    "ready shoe": lambda: mtb.scenes.pole_shoe_on_rail(spacing=1e-2, friction=TABLE, velocity=3.0),
}


@pytest.mark.parametrize("name", STEPS)
def test_of_steps_by_moduli(name: str) -> None:
    """Against differences of contacts that were prepared from bodies of other moduli."""
    scene = STEPS[name]()
    model, given = scene.models[-1], {"velocity": (-3.0, 1.0)}
    pull = {"magnetic_pressure": 3.1e6} if scene.magnetic_pressure is not None else {}
    pose = (0.0, 0.0, np.nan, np.nan, np.nan, 1e-5)

    def solved(scene: mtb.Scene) -> Any:
        return scene.prepare(model, reference_point=(0.01, 0.0, 0.02)).step(pose, **given, **pull)

    contact = scene.prepare(model, reference_point=(0.01, 0.0, 0.02))
    step = contact.step(pose, **given, **pull)
    place = int(step.pressure.argmax())
    of = ["force", "moment", "friction_power", "peak_pressure"]
    gradients, scale = [step.gradient(number) for number in of], sizes(step, of)
    for side, modulus in itertools.product(("upper", "lower"), ("young_modulus", "poisson_ratio")):
        body = getattr(scene, side)
        value = getattr(body.material, modulus)

        def changed(e: float) -> Array:
            there = replace(scene, **{side: body.with_constant(modulus, value + e)})  # noqa: B023
            return numbers(solved(there), place, of)

        wanted = richardson(changed, 1e-3 * value)
        own = [g[f"{side}.{modulus}"] for g in gradients]
        agree(f"{side}.{modulus}", own, wanted, scale, value)
        # forward as transposed
        w = np.random.default_rng(1).random(step.pressure.shape)
        forward = step.derivative("pressure", f"{side}.{modulus}")
        assert (w * forward).sum() == pytest.approx(
            step.derivative({"pressure": w}, f"{side}.{modulus}"), rel=1e-9, abs=1e-9 * abs(forward).sum()
        )
    copied = pickle.loads(pickle.dumps(contact)).step(pose, velocity=(-3.0, 1.0))
    with pytest.raises(ValueError, match=r"by is 'upper.young_modulus': .* from a file or a pickle"):
        copied.derivative("force", "upper.young_modulus")


@pytest.mark.parametrize("name", ["ball", "hill", "elastic block"])
def test_of_steps_that_stick_by_moduli(name: str) -> None:
    """Against differences of contacts of other moduli that start from the same state."""
    scene = STEPS[name]()
    model, shift = scene.models[-1], (3e-7, -2e-7)
    contact = scene.prepare(model)
    contact.step(shift=(0.0, 0.0), velocity=4.0)
    first = contact.step(shift=(2e-7, 1e-7), velocity=4.0)
    step = contact.step(shift=shift, velocity=4.0)
    assert (step.status == 1).any()
    w = np.random.default_rng(1).uniform(-1.0, 1.0, step.traction.shape)
    rigid = w[:2].reshape(2, -1)
    weights = ({"traction": w}, {"slip": w}, {"gap": w[0]}, {"rigid_displacement": rigid})
    of = ["force", "friction_work", *weights]

    def found(there: Any) -> Array:
        assert there.slip is not None
        assert there.state.rigid_displacement is not None
        sums = [(w * there.traction).sum(), (w * there.slip).sum(), (w[0] * there.gap).sum()]
        left = rigid * np.reshape(there.state.rigid_displacement, rigid.shape)
        return np.array([*there.force, there.friction_work, *sums, left.sum()])

    force, slipped = float((step.pressure * step.area).sum()), float(np.hypot(*shift))
    sums = [float(np.abs(step.traction).sum()), slipped * w.size, float(np.abs(step.gap).sum())]
    scale = np.array([force] * 3 + [force * slipped, *sums, slipped * rigid.size])
    for side, modulus in itertools.product(("upper", "lower"), ("young_modulus", "poisson_ratio")):
        body = getattr(scene, side)
        value, by = getattr(body.material, modulus), f"{side}.{modulus}"

        def changed(e: float) -> Array:
            there = replace(scene, **{side: body.with_constant(modulus, value + e)})  # noqa: B023
            return found(there.prepare(model).step(shift=shift, velocity=4.0, state=first.state))

        wanted = richardson(changed, 1e-3 * value)
        agree(by, [step.derivative(of, by)], wanted, scale, value)
        for field in ("traction", "slip"):
            forward = (w * step.derivative(field, by)).sum()
            assert forward == pytest.approx(step.derivative({field: w}, by), rel=1e-9, abs=1e-30)


def test_steps_have_the_derivatives_by_moduli_of_the_scene() -> None:
    scene = STEPS["ready shoe"]()
    result, step = scene.solve(model="elastic-upper"), scene.prepare("elastic-upper").step(velocity=3.0)
    for by in ("upper.young_modulus", "lower.poisson_ratio"):
        wanted = result.derivative("peak_pressure", by)
        assert step.derivative("peak_pressure", by) == pytest.approx(wanted, rel=1e-6)


@pytest.mark.coarse
@pytest.mark.parametrize(
    ("name", "speed"), list(itertools.product(STEPS, [(4.0, 0.0), (-3.0, 1.0), (0.05, 0.0)]))
)
def test_of_steps(name: str, speed: tuple[float, float]) -> None:
    scene = STEPS[name]()
    contact = scene.prepare(scene.models[-1], reference_point=(0.01, 0.0, 0.02), standstill_speed=0.2)
    free = contact.motions
    pose = np.array([0.0, 0.0, np.nan, 4e-6, np.nan, 1e-5])
    if not any(motion.endswith("z") for motion in free):
        pose[2] = -1e-6
    pull = {"magnetic_pressure": 3.1e6} if scene.magnetic_pressure is not None else {}
    contact.step(pose, (0.9 * speed[0], speed[1]), **pull)
    step = contact.step(pose, speed, **pull)
    closed, place = step.status > 0, int(step.pressure.argmax())
    of = ["force", "moment", "friction_power", "peak_pressure"]
    gradients, scale = [step.gradient(number) for number in of], sizes(step, of)

    def solved(pose: Array, velocity: Any, **pull: float) -> Array:
        found = contact.step(pose, velocity, **pull)
        assert np.array_equal(found.status > 0, closed)
        return numbers(found, place, of)

    for k, component in enumerate(("x", "y", "z", "roll", "pitch", "yaw")):
        own = [g["pose"][..., k] for g in gradients]
        if np.isnan(pose[k]):
            if any(motion.split()[-1] == component for motion in free):
                assert not np.concatenate([np.ravel(v) for v in own]).any()
            continue
        size, unit = (1e-5, 1e-4)[k > 2], np.eye(6)[k]
        wanted = richardson(lambda e: solved(pose + e * unit, speed, **pull), 5e-4 * size)  # noqa: B023
        agree(component, own, wanted, scale, size)
    for k in range(2):
        size, unit = abs(speed[0]), np.eye(2)[k]
        wanted = richardson(lambda e: solved(pose, np.array(speed) + e * unit, **pull), 3e-3 * size)  # noqa: B023
        agree("velocity", [g["velocity"][..., k] for g in gradients], wanted, scale, size)
    if pull:
        wanted = richardson(lambda e: solved(pose, speed, magnetic_pressure=3.1e6 + e), 3e2)
        agree("pull", [g["magnetic_pressure"] for g in gradients], wanted, scale, 3e6)
        # a uniform pressure is one at all points
        whole = np.concatenate([np.ravel(g["magnetic_pressure_field"].sum(axis=-1)) for g in gradients])
        agree("pull", [g["magnetic_pressure"] for g in gradients], whole, scale, 3e6)
    # after another step the derivatives are still those of this one
    before = step.derivative("force", "gap")
    contact.step(pose, (-speed[0], speed[1]), **pull)
    np.testing.assert_allclose(
        step.derivative("force", "gap"), before, rtol=1e-8, atol=1e-9 * scale[0] / 1e-5
    )


@pytest.mark.parametrize("own", [1e7, mtb.VelocityTable([0.0, 5.0, 20.0], [1e7, 9e6, 5e6])])
@pytest.mark.parametrize("pose", [None, (0.0, 0.0, -2e-5, 0.0, 0.0, 0.0)])
def test_a_table_that_is_given_to_a_step_is_derived_by_the_velocity(own: Any, pose: Any) -> None:
    table = mtb.VelocityTable([0.0, 5.0, 20.0], [2e7, 1.2e7, 5e6])
    contact = ball(magnetic_pressure=own, friction=TABLE).prepare("half-space", standstill_speed=0.2)
    at = np.array([6.0, 3.0])

    def numbers(change: Any) -> Any:
        step = contact.copy().step(pose, tuple(at + change), magnetic_pressure=table)
        return np.append(step.force, [step.friction_power, step.pressure.max()])

    step = contact.step(pose, tuple(at), magnetic_pressure=table)
    for of in ("force", "friction_power", "peak_pressure"):
        assert step.derivative(of, "velocity") == pytest.approx(step.gradient(of)["velocity"], rel=1e-9)
    found = step.derivative(["force", "friction_power", "peak_pressure"], "velocity")
    size = np.abs(numbers(0.0))[:, None]
    for axis in (0, 1):
        h = 0.02 * np.eye(2)[axis]
        near, wide = ((numbers(s * h) - numbers(-s * h)) / (0.04 * s) for s in (0.5, 1.0))
        wanted = (4.0 * near - wide) / 3.0
        np.testing.assert_allclose(found[:, axis], wanted, atol=1e-6 * size.ravel().max(), rtol=1e-6)
    # from half a slope to the next one
    at = np.array([5.0, 0.0])
    lower, upper = (numbers(np.array([s, 0.0]))[2] for s in (-0.01, 0.0))
    kink = contact.copy().step(pose, tuple(at), magnetic_pressure=table).derivative("force", "velocity")[2, 0]
    assert kink == pytest.approx((upper - lower) / 0.01, rel=1e-2)


def test_the_margin_tells_of_two_peaks() -> None:
    shoe = mtb.scenes.pole_shoe_on_rail(spacing=12e-3, friction=0.2, magnetic_pressure=3e6)
    assert shoe.solve(model="elastic-upper").margin().peak == pytest.approx(0.0, abs=1e-9)
    alone = ball(force=2e3, moments=(0.3, 0.2)).solve(model="half-space")
    second, largest = np.sort(alone.pressure.ravel())[-2:]
    assert alone.margin().peak == pytest.approx(1.0 - second / largest)
    assert alone.margin().smallest <= alone.margin().parting


def test_a_step_and_its_scene_have_the_same_derivatives() -> None:
    scene = ball(force=2e3, moments=(0.5, -1.0))
    result, step = scene.solve(model="half-space"), scene.prepare("half-space").step()
    for by in ("gap", "friction_field", "friction"):
        for of in ("force", "moment", "peak_pressure", "mean_pressure"):
            own, other = (np.reshape(r.derivative(of, by), -1) for r in (result, step))
            size = sizes(result, [of])[0] / (1e-5 if by == "gap" else 0.3)
            np.testing.assert_allclose(own, other, rtol=1e-7, atol=1e-9 * size)
    assert result.margin().parting == pytest.approx(step.margin().parting)


def test_gradients_that_are_kept_are_those_of_the_step() -> None:
    # what the transposed equations answer is kept: it goes with points, motions and friction alone
    contact = ball(force=2e3, moments=(0.5, -1.0)).prepare("half-space", reference_point=(0.01, 0.0, 0.02))
    free = np.full(6, np.nan)
    level, tilted = free.copy(), free.copy()
    level[3:5], tilted[4] = (1e-6, 0.0), 2e-6
    ride = [
        # the same points under another load, other free motions, friction, direction, points
        (free, 4.0, {}), (free, 4.0, {"gap": 1e-9 * np.arange(N * N)}), (level, 4.0, {}), (tilted, 4.0, {}),
        (free, 4.0, {"friction": 0.2}), (free, (1.0, 2.0), {}), (free, 4.0, {"gap": 3e-8 * np.arange(N * N)}),
        (free, 4.0, {}),
    ]  # fmt: skip
    weights = np.random.default_rng(7).random((3, N * N))
    for pose, velocity, given in ride:
        step = contact.step(pose, velocity, **given)
        # as many numbers at once, and one
        for of in (["peak_pressure", {"traction": weights}], {"pressure": weights[0]}):
            kept = step.gradient(of)
            new = contact.copy().step(pose, velocity, **given).gradient(of)
            for by in ("gap", "friction_field", "work", "pose", "velocity"):
                scale = np.abs(new[by]).max(initial=0.0) + 1e-300
                np.testing.assert_allclose(kept[by], new[by], rtol=0.0, atol=1e-9 * scale, err_msg=by)


def test_the_wedging_margin_of_a_step_is_that_of_its_scene() -> None:
    # under an approach, since under a load that of a scene may be that of tipping over
    scene = on_block(
        upper=HARD, lower=elastic(upper=False), approach=1e-6, sliding_direction=(1.0, 0.5), spacing=1e-2
    )
    model = scene.models[-1]
    result, contact = scene.solve(model=model), scene.prepare(model)
    along = np.array(scene.sliding_direction)
    step = contact.step(velocity=tuple(4.0 * along))
    wedging = step.margin().wedging
    assert wedging is not None
    assert 1e-6 < wedging < 1.0
    assert wedging == pytest.approx(result.margin().wedging, rel=1e-6)
    # the other way round friction opens where it closed
    other = scene.with_(sliding_direction=tuple(-along)).solve(model=model)
    assert contact.step(velocity=tuple(-4.0 * along)).margin().wedging == pytest.approx(
        other.margin().wedging, rel=1e-6
    )
    weaker = contact.step(velocity=tuple(4.0 * along), friction=0.15).margin().wedging
    assert weaker == pytest.approx(0.5 * wedging, rel=1e-6)


def test_steps_of_half_spaces_do_not_wedge() -> None:
    # friction opens as much gap on one side of a cell as it closes on the other, and none of like bodies
    assert ball(force=2e3).prepare("half-space").step().margin().wedging == pytest.approx(0.0, abs=1e-12)
    assert ball(lower=SOFT, force=2e3).prepare("half-space").step().margin().wedging == 0.0


def test_the_heat_of_friction_by_a_velocity_that_no_table_follows() -> None:
    result = ball(force=2e3).solve(model="half-space")
    assert result.derivative("friction_power", "velocity") == pytest.approx(0.3 * 2e3)
    assert not result.derivative("force", "velocity").any()
    assert result.gradient("friction_power")["velocity"] == pytest.approx(0.3 * 2e3)


def test_a_gap_and_a_friction_of_one_step_are_those_of_a_scene() -> None:
    random = np.random.default_rng(5)
    added, friction = 1e-7 * random.random((N, N)), 0.1 + 0.2 * random.random((N, N))
    contact = ball(force=2e3, moments=(0.5, -1.0)).prepare("half-space", standstill_speed=0.1)
    step = contact.step(velocity=4.0, gap=added.ravel(), friction=friction.ravel())
    other = ball(force=2e3, moments=(0.5, -1.0), gap=BALL + added, friction=friction).solve(
        model="half-space"
    )
    np.testing.assert_allclose(step.force, other.force, rtol=1e-8)
    np.testing.assert_allclose(step.pressure, other.pressure.ravel(), atol=1e-8 * other.pressure.max())
    for of, by in itertools.product(("force", "peak_pressure"), ("gap", "friction_field")):
        own, wanted = (np.reshape(r.derivative(of, by), -1) for r in (step, other))
        np.testing.assert_allclose(own, wanted, rtol=1e-6, atol=1e-8 * np.abs(wanted).max())
    # it fades below the standstill speed, and the next step is as if nothing had been
    slow = contact.step(velocity=0.05, friction=0.4)
    assert slow.force[0] == pytest.approx(0.2 * -slow.force[2])
    # by what was given, of which a half acts
    assert slow.derivative("force", "friction")[0] == pytest.approx(0.5 * 2e3)
    assert slow.derivative("force", "friction_field")[0].sum() == pytest.approx(0.5 * 2e3)
    assert contact.step(velocity=4.0).force[0] == pytest.approx(0.3 * 2e3)
    uniform = contact.step(velocity=4.0, friction=0.2).derivative("force", "velocity")
    assert uniform[0, 0] == pytest.approx(0.0, abs=1e-9)
    for given, words in (
        ({"gap": np.zeros(3)}, r"gap has shape \(3,\): a number or \(144,\)"),
        ({"friction": -0.1}, r"friction\[0\] is -0.1: numbers from 0 to 1000 are needed"),
        ({"gap": np.nan}, "gap"),
    ):
        with pytest.raises(ValueError, match=words):
            contact.step(velocity=4.0, **given)


def test_a_diagonal_of_a_step_is_what_it_opens_and_has_its_derivatives() -> None:
    contact = ball(force=2e3, moments=(0.5, -1.0)).prepare("half-space")
    diagonal = 1e-15 * np.random.default_rng(6).uniform(-0.2, 2.0, N * N)
    plain = contact.step(velocity=4.0)
    step = contact.step(velocity=4.0, diagonal=diagonal)
    assert np.abs(step.pressure - plain.pressure).max() > 0.01 * plain.pressure.max()
    # the same opening as a gap gives the same state, and the same derivatives but those by what follows it
    opened = contact.step(velocity=4.0, gap=diagonal * step.pressure)
    np.testing.assert_allclose(opened.pressure, step.pressure, atol=1e-8 * step.pressure.max())
    closed, weights = step.status > 0, np.random.default_rng(7).random((2, N * N))

    def solved(e: float) -> Array:
        found = contact.step(velocity=4.0, diagonal=diagonal + e * weights[0])
        assert np.array_equal(found.status > 0, closed)
        return np.concatenate([found.force, [weights[1] @ found.pressure]])

    wanted = richardson(solved, 1e-18)
    of_pressure = step.derivative({"pressure": weights[1]}, "diagonal") @ weights[0]
    assert of_pressure == pytest.approx(wanted[-1], rel=1e-6)
    assert step.derivative("force", "diagonal") @ weights[0] == pytest.approx(wanted[:3], abs=1e12)
    with pytest.raises(ValueError, match=r"diagonal\[7\] is -1 m/Pa, but the bodies give way there by"):
        contact.step(velocity=4.0, diagonal=np.where(np.arange(N * N) == 7, -1.0, 0.0))
    with pytest.raises(ValueError, match=r"diagonal has shape \(3,\)"):
        contact.step(velocity=4.0, diagonal=np.zeros(3))


@pytest.mark.parametrize("layer", [2e-15, 1e-15 * np.random.default_rng(2).uniform(0.5, 2.0, (N, N))])
def test_a_layer_of_steps_has_the_derivatives_of_its_scene(layer: Any) -> None:
    scene = ball(force=2e3, normal_layer=layer)
    step, result = scene.prepare("half-space").step(velocity=4.0), scene.solve("half-space")
    # the force is given
    of = ["moment", "peak_pressure"]
    own, whole = step.gradient(of), result.gradient(of)
    field = np.reshape(own["normal_layer_field"], whole["normal_layer_field"].shape)
    assert field == pytest.approx(whole["normal_layer_field"], rel=1e-8, abs=1e-8 * np.abs(field).max())
    if np.ndim(layer) == 0:
        for found in (own["normal_layer"], own["normal_layer_field"].sum(axis=-1)):
            assert found == pytest.approx(whole["normal_layer"], rel=1e-8)
        return
    with pytest.raises(ValueError, match="'normal_layer_field' is the derivative by its value at each point"):
        step.derivative("force", "normal_layer")
    # along a random direction, by prepared contacts of other layers
    along = 1e-16 * np.random.default_rng(4).uniform(-1.0, 1.0, (N, N))

    def at(e: float) -> Array:
        moved = ball(force=2e3, normal_layer=layer + e * along).prepare("half-space").step(velocity=4.0)
        assert np.array_equal(moved.status, step.status)
        return np.array([*moved.moment, moved.pressure.max()])

    slopes = [(at(h) - at(-h)) / (2.0 * h) for h in (2e-2, 1e-2)]
    wanted = (4.0 * slopes[1] - slopes[0]) / 3.0
    assert own["normal_layer_field"] @ along.ravel() == pytest.approx(wanted, rel=1e-6, abs=1e-9)


def test_what_has_no_derivatives_says_so() -> None:
    result = ball(force=2e3).solve(model="half-space")
    with pytest.raises(ValueError, match="of is 'forces': did you mean force"):
        result.derivative("forces", "gap")
    with pytest.raises(ValueError, match="by is 'frictions': did you mean friction"):
        result.derivative("force", "frictions")
    with pytest.raises(ValueError, match=r"of\['pressure'\] has shape \(3,\): \(12, 12\) is needed"):
        result.derivative({"pressure": np.ones(3)}, "gap")
    assert result.derivative({}, "friction") == 0.0
    assert not result.gradient({})["gap"].any()
    for weights in ("a", 1j, [[1.0], [1.0, 2.0]]):
        with pytest.raises(ValueError, match=r"of\['pressure'\] is no array of real numbers"):
            result.derivative({"pressure": weights}, "gap")
    square = pytest.importorskip("pint").UnitRegistry().mm ** 2
    for weights in (1.0 * square, np.ones((12, 12)) * square):
        with pytest.raises(ValueError, match=r"of\['pressure'\] has a unit: plain numbers"):
            result.derivative({"pressure": weights}, "gap")
        with pytest.raises(ValueError, match=r"of\['pressure'\] has a unit: plain numbers"):
            result.gradient(lambda r, w=weights: (0.0, {"pressure": w}))
    with pytest.raises(ValueError, match="of is a function whose value is"):
        result.derivative(lambda r: (1.0 * square, {"pressure": r.pressure}), "gap")
    with pytest.raises(ValueError, match="of is a function whose value is nan"):
        result.derivative(lambda r: (np.nan, {"pressure": r.pressure}), "gap")
    with pytest.raises(ValueError, match="loaded or copied, without the matrices"):
        replace(result, pressure=result.pressure[::-1]).derivative("force", "gap")
    with pytest.raises(ValueError, match="a name, weights of fields, or a function"):
        result.derivative(3.0, "gap")  # type: ignore[arg-type]
    with pytest.raises(ValueError, match="of is empty: a name, weights of fields, or a function"):
        result.gradient([])
    with pytest.raises(ValueError, match="of is 'forces': did you mean force"):
        result.gradient(["moment", "forces"])
    with pytest.raises(ValueError, match="loaded or copied, without the matrices"):
        pickle.loads(pickle.dumps(result)).derivative("force", "friction")
    increments = mtb.scenes.block_on_plane(spacing=2e-2).solve(model="half-space", method="incremental")
    with pytest.raises(ValueError, match="method='incremental': derivatives are those of method='direct'"):
        increments.derivative("force", "gap")
    varying = ball(approach=8e-6, lower=mtb.Rigid(), friction=lambda x, y: 0.2 + x).solve(model="half-space")
    with pytest.raises(ValueError, match=r"by is 'friction': it was given as a function.*'friction_field'"):
        varying.derivative("force", "friction")
    with pytest.raises(ValueError, match=r"by is 'lower.young_modulus': this body is rigid"):
        varying.derivative("force", "lower.young_modulus")
    step = ball(force=2e3, lower=mtb.Rigid()).prepare("half-space").step()
    with pytest.raises(ValueError, match=r"by is 'lower.young_modulus': this body is rigid"):
        step.derivative("force", "lower.young_modulus")
    with pytest.raises(ValueError, match="by is 'magnetic_pressure': nothing is pulled"):
        step.derivative("force", "magnetic_pressure")
    with pytest.raises(ValueError, match="loaded, copied or is not solved"):
        pickle.loads(pickle.dumps(step)).derivative("force", "gap")


def test_gaps_and_margins_where_a_body_flows() -> None:
    """At the hardness the gap stays closed and the body flows: by differences, and both sides of the kink."""
    x = (np.arange(12) - 5.5) * 1e-3
    gap = x[None] ** 2 / 0.5 + x[:, None] ** 2 / 0.7

    def pressed(force: float, hardness: float) -> mtb.Result:
        scene = mtb.Scene(
            mtb.steel, HARD, gap=gap, spacing=1e-3, force=force, friction=0.3, hardness=hardness
        )
        return scene.solve("half-space")

    result = pressed(2000.0, 1.7e8)
    flows = result.pressure >= 1.7e8
    assert 0 < flows.sum() < (result.pressure > 0.0).sum()
    more, less = pressed(2001.0, 1.7e8), pressed(1999.0, 1.7e8)
    for name in ("gap", "plastic_indentation", "pressure"):
        slope = (getattr(more, name) - getattr(less, name)) / 2.0
        found = result.derivative(name, "force")
        assert found == pytest.approx(slope, rel=1e-5, abs=1e-7 * np.abs(slope).max())
        weights = np.arange(144.0).reshape(12, 12)
        own = result.gradient({name: weights})["force"]
        assert own == pytest.approx((weights * found).sum(), rel=1e-9)
    assert not result.derivative("gap", "force")[flows].any()
    assert 0.0 < result.margin().unloading < 0.2
    assert 0.0 < result.margin().yielding < 0.2
    # just below the hardness the derivative ahead is another one than that behind, and the margin says so
    peak = pressed(2000.0, 1e9).pressure.max()
    result = pressed(2000.0, peak * (1.0 + 1e-9))
    assert result.margin().smallest == pytest.approx(1e-9, rel=1e-3)
    ahead = (pressed(2000.2, peak * (1.0 + 1e-9)).pressure.max() - peak) / 0.2
    behind = (peak - pressed(1999.8, peak * (1.0 + 1e-9)).pressure.max()) / 0.2
    assert result.derivative("peak_pressure", "force") == pytest.approx(behind, rel=1e-3)
    assert ahead < 1e-3 * behind


def test_a_hardness_is_an_input_where_points_flow() -> None:
    """As numbers, as a field, forward and backward; one of two poles moves nothing but its own pressure."""
    given = {"friction": 0.2, "magnetic_pressure": 3e6, "velocity": 5.0, "spacing": 1e-2, "poles": 2}

    def shoe(of_left: float, of_right: float) -> mtb.Scene:
        return mtb.scenes.pole_shoe_on_rail(**given, hardness=(of_left, of_right))

    result = shoe(5e6, 6e6).solve("elastic-upper")
    step = shoe(5e6, 6e6).prepare("elastic-upper").step()
    flows = result.plastic_indentation > 0.0
    assert 0 < flows.sum() < (result.pressure > 0.0).sum()
    for name in ("pressure", "gap", "plastic_indentation", "traction"):
        found = result.derivative(name, "hardness")
        for pole, by in enumerate(((1e3, 0.0), (0.0, 1e3))):
            more, less = (shoe(5e6 + s * by[0], 6e6 + s * by[1]).solve("elastic-upper") for s in (1, -1))
            slope = (getattr(more, name) - getattr(less, name)) / 2e3
            assert found[..., pole] == pytest.approx(slope, rel=1e-5, abs=1e-6 * np.abs(slope).max())
        weights = np.random.default_rng(3).random(found.shape[:-1])
        own = result.gradient({name: weights})
        assert own["hardness"] == pytest.approx(np.tensordot(weights, found, found.ndim - 1), rel=1e-9)
        assert own["hardness_field"].sum() == pytest.approx(own["hardness"].sum(), rel=1e-9)
        assert not own["hardness_field"][~flows].any()
    assert step.derivative("force", "hardness") == pytest.approx(
        result.derivative("force", "hardness"), rel=1e-6
    )
    by_field = step.derivative("moment", "hardness_field")
    loaded = pickle.loads(pickle.dumps(shoe(5e6, 6e6).prepare("elastic-upper"))).step()
    assert loaded.derivative("moment", "hardness_field") == pytest.approx(by_field, rel=1e-9)
    with pytest.raises(ValueError, match="by is 'hardness': the numbers that gave it are not known"):
        loaded.derivative("force", "hardness")


@pytest.mark.parametrize("shift", [None, (1e-6, 0.0)])
def test_steps_without_free_motions_have_derivatives(shift: tuple[float, float] | None) -> None:
    """Where the pose is given nothing is found from balance: fields and inputs that are empty stay so."""
    scene = mtb.scenes.block_on_plane(spacing=2e-2, friction=0.1, supports="clamped-top")
    contact = scene.prepare()
    pose = (0.0, 0.0, -1e-6, 0.0, 0.0, 0.0)
    given = {} if shift is None else {"shift": shift}
    contact.step(pose=pose, velocity=1.0)
    step = contact.step(pose=pose, **given) if shift else contact.step(pose=pose, velocity=1.0)
    tangent = step._tangent()
    assert tangent.fields["motion"] == (0,)
    for of, shape in tangent.fields.items():
        for by, over in tangent.inputs.items():
            found = step.derivative(of, by)
            assert found.shape == (*shape, *over)
            assert np.isfinite(found).all()


def test_the_margin_knows_the_hardness_of_steps_and_the_yielding_of_layers() -> None:
    given = {"friction": 0.2, "magnetic_pressure": 3e6, "spacing": 1e-2}
    contact = mtb.scenes.pole_shoe_on_rail(**given, hardness=5e6).prepare("elastic-upper")
    step = contact.step(velocity=5.0)
    assert step.plastic_indentation is not None
    assert step.plastic_indentation.any()
    slope = contact.step(velocity=5.0, magnetic_pressure=3.001e6).gap
    slope = (slope - contact.step(velocity=5.0, magnetic_pressure=2.999e6).gap) / 2e3
    assert step.derivative("gap", "magnetic_pressure") == pytest.approx(slope, rel=1e-5, abs=1e-20)
    assert step.margin().unloading > 0.0
    scene = mtb.scenes.pole_shoe_on_rail(**given, layer=mtb.PlasticLayer(2e-5, 1e9, 6e5))
    contact = scene.prepare("elastic-upper")
    step, solved = contact.step(velocity=5.0), scene.solve("elastic-upper")
    over = 0.2 * solved.coefficients[2] / 6e5
    nearest = np.abs(1.0 - over)[over > 0.0].min()
    assert (over > 1.0).any()
    assert step.margin().yielding == pytest.approx(nearest, rel=1e-4)
    assert solved.margin().yielding == pytest.approx(nearest, rel=1e-4)


def test_the_margin_knows_the_first_touch() -> None:
    x = (np.arange(12) - 5.5) * 5e-4
    gap = x[None] ** 2 / 0.2 + x[:, None] ** 2 / 0.3
    pressed = mtb.solve_normal(gap - gap.min(), 5e-4, lower=mtb.steel, upper=mtb.steel, approach=0.0)
    assert pressed.margin().touching == 0.0
    contact = mtb.scenes.block_on_plane(spacing=2e-2, friction=0.1, supports="clamped-top").prepare()
    assert contact.step(velocity=1.0, pose=(0, 0, 0, 0, 0, 0), magnetic_pressure=0.0).margin().touching == 0.0


@pytest.mark.parametrize("share", [1e-4, 1e-9])
def test_cells_that_hardly_touch_leave_their_derivatives_to_the_others(share: float) -> None:
    """A cell with a ten-thousandth of the pressure slips; its traction follows its own pressure alone."""
    steel = mtb.Material(2.08e11, 0.3)
    x = 1e-3 * (np.arange(12) - 5.5)
    pressure = 2e9 * np.sqrt(np.clip(1.0 - (x / 4e-3) ** 2 - (x[:, None] / 2.2e-3) ** 2, 0.0, None))
    row, column = np.argwhere(pressure > 0.0)[0]
    column -= 1
    pressure[row, column] = share * pressure.max()

    def rolled(pressed: np.ndarray) -> mtb.TangentialResult:
        field = mtb.PressureField(pressed, (1e-3, 1e-3), steel, steel)
        return mtb.solve_tangential(field, mtb.Rolling((-3e-2, 1e-2, 0.5)), mtb.Coulomb(0.3))

    found = rolled(pressure)
    derivative = np.asarray(found.derivative("traction", "pressure"))
    # friction is 0.3 in the direction of the slip, whatever the pressure is
    own = derivative[:2, row, column, row, column]
    assert np.linalg.norm(own) == pytest.approx(0.3, rel=1e-8)
    assert own == pytest.approx(found.traction[:2, row, column] / pressure[row, column], rel=share + 1e-8)
    # another cell, against differences
    width = 1e-4 * pressure.max()
    more, less = pressure.copy(), pressure.copy()
    more[6, 6] += width
    less[6, 6] -= width
    between = (rolled(more).traction - rolled(less).traction) / (2.0 * width)
    assert derivative[:, :, :, 6, 6] == pytest.approx(between, abs=1e-5)
