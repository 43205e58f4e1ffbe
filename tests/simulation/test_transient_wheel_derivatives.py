# SPDX-License-Identifier: MIT OR Apache-2.0
"""Derivatives of transient steps of wheels: Cattaneo's shift, the scale of time, differences of steps."""

import numpy as np
import pytest

import mtb_rs as mtb
from mtb_rs.simulation.wheel_stepping import PreparedWheels

pytestmark = pytest.mark.filterwarnings("ignore:the peak pressure is")

V, RADIUS, FREE = 20.0, 0.46, np.nan
MOVING = np.array([V, 2e-3, 0.0, 1e-3, 1.0004 * V / RADIUS, 5e-3])


def exact(contact):
    return PreparedWheels(contact._core.to_accuracy(1e-14, 1e-13, 1e-13))


def prepared(friction, side="left", **changes):
    scene = mtb.scenes.wheel_on_rail(
        **{"lateral": 0.0, "force": 60e3, "spacing": 1e-3, "wheel_radius": RADIUS} | changes
    )
    return exact(scene.prepare(side=side, friction=friction))


def round_head(radius=0.3):
    angle = np.linspace(-0.12, 0.12, 1601)
    y, z = radius * np.sin(angle), radius * (np.cos(angle) - 1.0)
    # a flank, for the gauge to be measured at
    return mtb.Profile.from_points(np.r_[y[0] - 2e-3, y], np.r_[z[0] - 30e-3, z], "linear")


def test_a_wheel_at_rest_is_shifted_on_as_cattaneo_has_it():
    """By the shift u the traction mu (p(d) - p(d - u / mu)) has the slope of the inner pressure."""
    mu, share, dt = 0.3, 0.6, 1e-3
    # Young's modulus 2 G and Poisson's ratio 0: tractions do what pressures do
    plain = mtb.Material(160e9, 0.0)
    scene = mtb.scenes.wheel_on_rail(
        wheel=mtb.Profile.from_points([-0.05, 0.05], [0.0, 0.0], "linear"), rail=round_head(),
        rail_inclination=0.0, lateral=0.0, force=60e3, spacing=5e-4, lower=plain, upper=plain,
        wheel_radius=RADIUS,
    )  # fmt: skip
    contact = scene.prepare(friction=mtb.Coulomb(mu))
    depth = -exact(contact).step([0.0, 0.0, FREE, 0.0, 0.0, 0.0], V).pose[2]

    def slope_at(d):
        """Of the normal force by the depth."""
        step = exact(contact).step([0.0, 0.0, -d, 0.0, 0.0, 0.0], V)
        return -step.derivative("normal_force", "pose")[0, 2]

    shift = mu * (1.0 - share) * depth
    step = exact(contact).step(
        [0.0, 0.0, -depth, 0.0, 0.0, 0.0], [0.0, shift / dt, 0.0, 0.0, 0.0, 0.0], dt=dt, transient=True
    )
    by_velocity = step.derivative("force", "velocity")
    inner, outer = slope_at(share * depth), slope_at(depth)
    assert by_velocity[1, 1] == pytest.approx(dt * inner, rel=1e-6)
    assert step.derivative("force", "dt")[1] == pytest.approx(shift / dt * inner, rel=1e-6)
    # in the contact plane, which turns a little as the linear pieces of the head give way
    by_height = step.derivative("creep_force", "pose")[0, 1, 2]
    assert by_height == pytest.approx(-mu * (outer - inner), rel=1e-6)
    # the sliding rim alone warms; friction by its coefficient, at a given shift
    (patch,) = step.patches
    sideways = patch.area * patch.traction[1].sum()
    by_friction = step.derivative("creep_force", "friction")[0, 1]
    assert by_friction == pytest.approx((sideways - shift * inner) / mu, rel=1e-6)
    assert 0.0 < by_friction < patch.normal_force


@pytest.mark.parametrize("roller_radius", [None, 0.6])
def test_time_has_no_scale_under_coulomb_friction(roller_radius):
    """Faster in less time is the same way: forces are the same, and the power goes with the speed."""
    contact = prepared(mtb.Coulomb(0.3), roller_radius=roller_radius)
    dt = 0.83e-3 / V
    contact.step([0.0, 1e-3, FREE, 0.0, 0.0, 2e-3], MOVING.tolist())
    step = contact.step([-dt * V, 1.2e-3, FREE, 0.0, 0.0, 2.1e-3], MOVING.tolist(), dt=dt, transient=True)

    def scaled(of):
        return step.derivative(of, "velocity") @ MOVING - dt * step.derivative(of, "dt")

    force = np.abs(step.derivative("force", "velocity") * MOVING).max()
    assert scaled("force") == pytest.approx(np.zeros(3), abs=1e-7 * force)
    assert np.abs(dt * step.derivative("force", "dt")[:2]).max() > 1e-3 * np.hypot(*step.force[:2])
    assert scaled("friction_power") == pytest.approx(step.friction_power, rel=1e-7)
    assert scaled("pose") == pytest.approx(np.zeros(6), abs=1e-14)


LAWS = {
    "coulomb": (mtb.Coulomb, 0.3, "friction"),
    "along the track": (
        lambda mu: mtb.RailFriction([-20e-3, 20e-3], [[mu, mu], [0.1, 0.1]], x=[-9e-3, 5e-3]),
        *(0.35, "friction"),
    ),
    "memory": (lambda mu: mtb.FallingFriction(mu, 0.2, 0.2, memory=1e-4), 0.35, "friction.static"),
}


@pytest.mark.slow
@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("cells", [0.87, 6.3])
def test_derivatives_are_differences_of_steps(law, cells):
    made, mu, name = LAWS[law]
    before = prepared(made(mu), "right")
    dt = cells * 1e-3 / V
    state = before.step([0.0, -1e-3, FREE, 0.0, 0.0, 2e-3], V).state
    pose = np.array([-dt * V, -1.3e-3, FREE, 0.0, 0.0, 2.2e-3])

    def at(contact=before, pose=pose, velocity=MOVING, dt=dt):
        return contact.copy().step(list(pose), list(velocity), dt=dt, state=state, transient=True)

    step = at()
    ways = [
        ("pose", 1, 2e-8, lambda by: at(pose=pose + by * np.eye(6)[1])),
        ("pose", 5, 2e-7, lambda by: at(pose=pose + by * np.eye(6)[5])),
        ("velocity", 1, 2e-6, lambda by: at(velocity=MOVING + by * np.eye(6)[1])),
        ("velocity", 4, 4e-6, lambda by: at(velocity=MOVING + by * np.eye(6)[4])),
        ("dt", None, 1e-9, lambda by: at(dt=dt + by)),
        (name, None, 1e-6, lambda by: at(prepared(made(mu + by), "right"))),
    ]
    for by, k, small, moved in ways:
        a, b, c, d = (moved(share * small) for share in (-1.0, -0.5, 0.5, 1.0))
        states = {b"".join(p.status.tobytes() for p in r.patches) for r in (a, b, c, d, step)}
        assert len(states) == 1, by
        for of in ("force", "moment", "friction_power", "pose"):
            found = np.asarray(step.derivative(of, by))
            if by == "friction" and law == "along the track":
                found = found[..., 0, :].sum(axis=-1)
            found = found if k is None else found[..., k]
            a_, b_, c_, d_ = (np.asarray(getattr(r, of)) for r in (a, b, c, d))
            truth = (8.0 * (c_ - b_) - (d_ - a_)) / (6.0 * small)
            noise = 1e-11 * np.abs(np.nan_to_num(getattr(step, of))).max() / small
            size = 1e-6 * np.abs(truth).max() + noise
            assert found == pytest.approx(truth, abs=size), (of, by, k)


def test_what_a_transient_step_is_not_derived_by_is_told():
    contact = prepared(mtb.Coulomb(0.3))
    steady = contact.step([0.0, 1e-3, FREE, 0.0, 0.0, 2e-3], V, dt=1e-4)
    with pytest.raises(ValueError, match="by is 'dt': the step is steady"):
        steady.derivative("force", "dt")
    step = contact.step([0.0, 1e-3, FREE, 0.0, 0.0, 2e-3], V, dt=1e-4, transient=True)
    assert "dt" in step.gradient("force")
    assert "dt" not in steady.gradient("force")
    with pytest.raises(
        ValueError, match=r"by is 'state.traction': what the step before has left follows from what"
    ):
        step.derivative("force", "state.traction")


def test_a_layer_does_nothing_where_all_points_slip_from_rest():
    """The traction is friction coefficient times pressure, against the slip, whatever the layer."""
    scene = mtb.scenes.wheel_on_rail(lateral=0.0, force=60e3, spacing=1e-3, wheel_radius=RADIUS)
    layer = mtb.InterfaceLayer(2e-5, 1e10)
    contact = exact(scene.prepare(side="left", friction=mtb.Coulomb(0.3), layer=layer))
    pose = [0.0, 1e-3, FREE, 0.0, 0.0, 2e-3]
    step = contact.step(pose, [V, 0.5, 0.0, 0.01, 1.05 * V / RADIUS, 0.05], dt=5e-5, transient=True)
    (patch,) = step.patches
    assert set(np.unique(patch.status)) == {0, 2}
    by_layer = step.derivative("creep_force", "layer")
    thickness_over_modulus = 2e-15
    assert by_layer * thickness_over_modulus == pytest.approx(np.zeros((1, 2)), abs=1e-8 * patch.normal_force)
