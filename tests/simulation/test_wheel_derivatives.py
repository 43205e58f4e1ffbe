# SPDX-License-Identifier: MIT OR Apache-2.0
"""Derivatives of steps of wheels, as Python hands them out, against differences of the same steps.

The core compares all of them with differences of steps that it solves to rounding; here steps are solved as
everybody's are, so that differences carry the errors of the solvers.
"""

import copy
import pickle
from dataclasses import replace
from functools import lru_cache

import numpy as np
import pytest

import mtb_rs as mtb

pytestmark = pytest.mark.filterwarnings("ignore:the peak pressure is")

V = 20.0
#: tread, flange of the right wheel, backwards, and height and roll found from balance
POSES = {
    "tread": ((0.0, 2.3e-3, np.nan, 0.0, 0.0, 2e-3), V),
    "flange": ((0.0, -6.4e-3, np.nan, np.nan, 0.0, -3e-3), V),
    "backwards": ((0.0, 1.1e-3, -6e-5, 1e-4, 0.0, 1e-3), -V),
    "six": ((0.0, 1.1e-3, np.nan, np.nan, 0.0, 1e-3), (V, 0.02, 0.0, 0.01, 43.5, 0.05)),
}
NUMBERS = (
    "force", "moment", "vertical_force", "pose", "friction_power", "position", "contact_angle",
    "rail_position", "wheel_position", "approach", "creepage", "rolling_speed", "patch_force",
    "patch_friction_power", "normal_force", "creep_force", "spin_moment",
)  # fmt: skip
MODULI = [
    f"{side}.{constant}" for side in ("lower", "upper") for constant in ("young_modulus", "poisson_ratio")
]


def prepared(side, friction, **changes):
    scene = mtb.scenes.wheel_on_rail(lateral=0.0, force=60e3, spacing=1e-3, **changes)
    return scene.prepare(side=side, friction=friction)


@lru_cache
def wheels(side="both"):
    return prepared(side, mtb.Coulomb(0.3))


def told(step, name):
    """A number as the step itself tells it."""
    each = step.patches
    if name in ("force", "moment", "pose", "friction_power"):
        return np.asarray(getattr(step, name))
    if name == "vertical_force":
        return np.array(list(step.vertical_force.values()))
    if name == "creep_force":
        return np.array([p.area * p.traction.sum(axis=(1, 2)) for p in each])
    if name == "spin_moment":
        return np.array([p.area * (p.traction[1] * p.x - p.traction[0] * p.y[:, None]).sum() for p in each])
    own = {"patch_force": "force", "patch_friction_power": "friction_power"}.get(name, name)
    return np.array([getattr(p, own) for p in each])


def differences(at, small):
    """Of all numbers, by numbers of steps."""
    a, b, c, d = (at(share * small) for share in (-1.0, -0.5, 0.5, 1.0))
    return {
        name: (8.0 * (told(c, name) - told(b, name)) - (told(d, name) - told(a, name))) / (6.0 * small)
        for name in NUMBERS
    }


def compare(step, by, k, truth, sizes):
    for name in NUMBERS:
        found = np.asarray(step.derivative(name, by))
        found = found if k is None else found[..., k]
        # of the solvers' errors in differences, and of what changes with it
        size = max(
            np.abs(truth[name]).max(initial=0.0), 1e-3 * sizes(np.abs(told(step, name)).max(initial=0.0))
        )
        assert found == pytest.approx(truth[name], abs=1e-2 * size), (name, by, k)


@pytest.mark.parametrize("which", POSES)
def test_derivatives_by_pose_and_velocity_are_differences(which):
    pose, velocity = POSES[which]
    contact = wheels().copy()
    step = contact.step(pose, velocity)
    for k in (k for k in (1, 2, 3, 5) if np.isfinite(pose[k])):
        small = {3: 4e-9, 5: 4e-7}.get(k, 2e-8)

        def moved(by, k=k):
            return contact.copy().step(np.add(pose, by * np.eye(6)[k]), velocity)

        compare(step, "pose", k, differences(moved, small), lambda size, h=small: size * 1e-3 / h)
    for k in range(np.size(velocity)):
        unit = np.eye(6)[k] if np.size(velocity) == 6 else 1.0

        def faster(by, unit=unit):
            return contact.copy().step(pose, np.add(velocity, by * unit).tolist())

        index = None if np.size(velocity) == 1 else k
        compare(step, "velocity", index, differences(faster, 1e-4), lambda size: size)
    found = [k for k in range(6) if np.isnan(pose[k])]
    assert not np.any(step.derivative("force", "pose")[:, found])


@pytest.mark.parametrize(
    ("law", "names"),
    [
        (mtb.Coulomb(0.3), {"friction": ()}),
        (
            mtb.FallingFriction(0.3, 0.2, 0.2),
            {"friction.static": (), "friction.kinetic": (), "friction.half_slip": ()},
        ),
        (
            mtb.TabulatedFriction([0.0, 0.1, 0.5], [0.3, 0.25, 0.2]),
            {"friction.coefficient": (3,), "friction.slip_speed": (3,)},
        ),
        (mtb.friction.RailFriction([-0.04, 0.0, 0.02], [0.2, 0.3, 0.25]), {"friction": (3,)}),
        (
            mtb.friction.RailFriction([-0.04, 0.02], [[0.2, 0.3], [0.25, 0.3]], x=[-1.0, 1.0]),
            {"friction": (2, 2)},
        ),
    ],
)
@pytest.mark.filterwarnings("ignore:.*without a memory")
def test_each_law_is_derived_by_what_it_was_given(law, names):
    contact = prepared("left", law)
    step = contact.copy().step((0.0, 1e-3, np.nan, 0.0, 0.0, 2e-3), V)
    gradient = step.gradient("friction_power")
    given = {"pose": (6,), "velocity": (), **names, "vertical_force": (), "layer": ()}
    beside = {"curvature": (), "rails.left": (6,), "wheels.left": (12,)}
    assert gradient.inputs == given | beside | dict.fromkeys(MODULI, ())
    # all coefficients together scale the force where all slips, and something of it elsewhere
    for name, shape in names.items():
        assert np.shape(gradient[name]) == shape
        assert np.any(gradient[name])
        assert step.derivative("friction_power", name) == pytest.approx(gradient[name], rel=1e-12)


def of_bodies(lower, upper, layer=None):
    scene = mtb.scenes.wheel_on_rail(lateral=0.0, force=60e3, spacing=1e-3)
    return replace(scene, lower=lower, upper=upper).prepare(
        side="both", friction=mtb.Coulomb(0.3), layer=layer
    )


@pytest.mark.parametrize("by", MODULI)
@pytest.mark.parametrize("which", ["tread", "backwards"])
def test_derivatives_by_moduli_are_differences(which, by):
    pose, velocity = POSES[which]
    bodies = {"lower": mtb.Material(206e9, 0.28), "upper": mtb.Material(170e9, 0.2)}
    side, constant = by.split(".")
    step = of_bodies(**bodies).step(pose, velocity)
    value = getattr(bodies[side], constant)

    def moved(share):
        other = replace(bodies[side], **{constant: value * (1.0 + share)})
        return of_bodies(**(bodies | {side: other})).step(pose, velocity)

    truth = {name: change / value for name, change in differences(moved, 1e-5).items()}
    compare(step, by, None, truth, lambda size: size / value)


def test_forces_at_a_height_go_with_all_moduli_together():
    pose, velocity = POSES["backwards"]
    layer = mtb.InterfaceLayer(2e-5, 5e9)
    lower, upper = mtb.Material(206e9, 0.28), mtb.Material(170e9, 0.2)
    for pair in ((lower, upper), (mtb.Rigid(), upper), (lower, mtb.Rigid())):
        step = of_bodies(*pair, layer=layer).step(pose, velocity)
        by = step.gradient("force")
        together = -layer.flexibility * by["layer"]
        for side, body in zip(("lower", "upper"), pair, strict=True):
            if isinstance(body, mtb.Material):
                together = together + body.young_modulus * by[f"{side}.young_modulus"]
            else:
                with pytest.raises(ValueError, match="this body is rigid and has no moduli"):
                    step.derivative("force", f"{side}.young_modulus")
        # of the tolerance of the tractions
        assert together == pytest.approx(step.force, rel=1e-5)


def test_two_patches_of_a_wheel_have_their_own_derivatives():
    y = np.array([-0.052, -0.036, 0.06])
    wheel = mtb.Profile.from_points(y, [-1.8e-3 - 16e-3 * np.tan(np.radians(60)), -1.8e-3, 3e-3], "linear")
    contact = prepared("left", mtb.Coulomb(0.3), wheel=wheel)
    # shifted until tread and flange both bear
    low, high = 0.0, 12e-3
    for _ in range(20):
        lateral = 0.5 * (low + high)
        step = contact.step([0.0, lateral, np.nan, 0.0, 0.0, 0.0], V)
        if len(step.patches) == 2:
            break
        low, high = (lateral, high) if step.patches[0].contact_angle < 0.2 else (low, lateral)
    pose = step.pose
    step = contact.copy().step(pose, V)
    assert step.derivative("creepage", "pose").shape == (2, 3, 6)

    def moved(by):
        return contact.copy().step(pose + by * np.eye(6)[1], V)

    truth = differences(moved, 1e-8)
    for name in ("force", "normal_force", "contact_angle"):
        scale = np.abs(truth[name]).max()
        assert step.derivative(name, "pose")[..., 1] == pytest.approx(truth[name], abs=3e-3 * scale), name
    # the load of the flange alone
    ends = np.cumsum([p.pressure.size for p in step.patches])
    flange = np.arange(ends[-1]) < ends[0]
    of_flange = step.derivative({"pressure": step.patches[0].area * flange}, "pose")
    assert of_flange == pytest.approx(step.derivative("normal_force", "pose")[0], rel=1e-12)


def test_a_gradient_is_all_derivatives_and_fields_are_those_of_all_patches():
    step = wheels().copy().step((0.0, 2.3e-3, np.nan, np.nan, 0.0, 2e-3), V)
    gradient = step.gradient("moment")
    for by in gradient:
        assert gradient[by] == pytest.approx(step.derivative("moment", by), rel=1e-12)
    points = sum(p.pressure.size for p in step.patches)
    by_friction = step.derivative("traction", "friction")
    assert by_friction.shape == (2, points)
    area = step.patches[0].area
    across = area * by_friction.sum(axis=1)
    assert across == pytest.approx(step.derivative("creep_force", "friction").sum(axis=0), rel=1e-12)
    covered = np.array([p.area * (p.pressure > 0.0).sum() for p in step.patches])
    by_pose = step.derivative("normal_force", "pose") / covered[:, None]
    assert step.derivative("mean_pressure", "pose") == pytest.approx(by_pose, rel=1e-12)
    # pressures and friction carry what is asked for, and no more, whatever else changes
    assert -step.derivative("patch_force", "vertical_force")[:, 2] == pytest.approx(np.ones(2), rel=1e-9)
    size = np.abs(step.derivative("patch_force", "friction")).max()
    assert step.derivative("patch_force", "friction")[:, 2] == pytest.approx(np.zeros(2), abs=1e-9 * size)
    assert np.abs(step.derivative("pose", "friction")[2]) > 0.0


def test_lifted_wheels_have_derivatives_of_zero_and_a_margin():
    contact = wheels().copy()
    step = contact.step((0.0, 0.0, 1e-4, 0.0, 0.0, 0.0), V)
    assert not step.patches
    assert not np.any(step.derivative("force", "pose"))
    assert step.derivative("peak_pressure", "pose").shape == (0, 6)
    nearer = contact.step((0.0, 0.0, 1e-5, 0.0, 0.0, 0.0), V)
    assert 0.0 < nearer.margin().touching < step.margin().touching


def test_what_has_no_derivatives_says_so(tmp_path):
    contact = wheels("left")
    step = contact.copy().step(velocity=V)
    for other in (pickle.loads(pickle.dumps(step)), copy.copy(step)):
        assert other == step
        with pytest.raises(ValueError, match="loaded or copied"):
            other.derivative("force", "pose")
    with pytest.raises(ValueError, match="did you mean creepage"):
        step.derivative("crepage", "pose")
    for by, why in (("gap", "pose"), ("force", "vertical_force")):
        with pytest.raises(ValueError, match=why):
            step.derivative("force", by)
    with pytest.raises(ValueError, match="has pose, velocity, friction, vertical_force, curvature, rails"):
        step.derivative("force", "mass")
    # wheels that were read have them as well
    contact.save(tmp_path / "wheels")
    read = mtb.PreparedWheels.load(tmp_path / "wheels").step(velocity=V)
    assert read.derivative("force", "pose") == pytest.approx(step.derivative("force", "pose"), rel=1e-9)
