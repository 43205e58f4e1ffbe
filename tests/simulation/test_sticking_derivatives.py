# SPDX-License-Identifier: MIT OR Apache-2.0
"""Derivatives of steps in which points stick and slip, and of chains of them, against differences."""

from __future__ import annotations

import itertools
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import mtb_rs as mtb

Array = NDArray[np.float64]

pytestmark = [
    pytest.mark.coarse,
    pytest.mark.filterwarnings("ignore:.*(deforms|displaces|away from).*:UserWarning"),
]

N = 10
X = (np.arange(N) - 0.5 * (N - 1)) * 1e-3
BALL = (X[None, :] ** 2 + X[:, None] ** 2) / 0.6 + 2e-7 * np.random.default_rng(7).random((N, N))


def slope(of: Any) -> Array:
    """Derivative at 0 by central differences with Richardson's extrapolation."""
    wide, near = ((np.asarray(of(h)) - np.asarray(of(-h))) / (2.0 * h) for h in (1.0, 0.5))
    return np.asarray((4.0 * near - wide) / 3.0)


def ball(**given: Any) -> Any:
    chosen = {"force": 1500.0, "friction": 0.3, "sliding_direction": (1.0, 0.0)} | given
    return mtb.Scene(
        mtb.Material(80e9, 0.1), mtb.Material(200e9, 0.3), gap=BALL, spacing=1e-3, **chosen
    ).prepare("half-space", reference_point=(0.01, 0.0, 0.02))


def shoe() -> Any:
    return mtb.scenes.pole_shoe_on_rail(
        friction=0.3, magnetic_pressure=3e6, spacing=1.5e-2, velocity=1.0
    ).prepare(model="elastic-upper")


#: Each contact, what of the pose is given, and how far it is shifted: some points stick and some slip.
CONTACTS: dict[str, tuple[Any, float, tuple[float, float]]] = {
    "half-spaces": (ball, np.nan, (-2.8e-6, 1e-6)),
    "shoe": (shoe, np.nan, (-4e-7, 1e-7)),
    "pulled half-spaces": (
        lambda: ball(force=None, magnetic_pressure=1.5e7, normal_layer=5e-15), np.nan, (-3.6e-6, 1.2e-6)
    ),
    "held half-spaces": (lambda: ball(force=None, approach=9e-6), 0.0, (-3.6e-6, 1.2e-6)),
}  # fmt: skip


@pytest.mark.parametrize("name", CONTACTS)
def test_a_step_by_all_that_it_was_given(name: str) -> None:
    make, z, shift = CONTACTS[name]
    contact = make()
    n, random = contact.area.size, np.random.default_rng(1)
    given = {
        "pose": np.array([0.0, 0.0, z, 0.0, 0.0, 0.0]), "shift": np.array(shift),
        "gap": 1e-8 * random.random(n), "friction": random.uniform(0.25, 0.3, n),
        "diagonal": 1e-15 * random.random(n),
    }  # fmt: skip
    before = contact.step(velocity=1.0, friction=np.full(n, 0.3)).state
    state = {part: getattr(before, part) for part in ("traction", "pressure", "rigid_displacement")}

    def step(changed: dict[str, Array]) -> Any:
        now = given | {key: value for key, value in changed.items() if key in given}
        left = {key[6:]: value for key, value in changed.items() if key.startswith("state.")}
        return contact.copy().step(
            now["pose"], tuple(np.array([1.0, 0.0])), shift=tuple(now["shift"]), gap=now["gap"],
            friction=now["friction"], diagonal=now["diagonal"], state=replace(before, **left), dt=1e-3,
        )  # fmt: skip

    made = step({})
    assert (made.status == 1).any()
    assert (made.status == 2).any()
    w = random.standard_normal((3, n))
    of = {
        "force": ("force", lambda r: r.force),
        "moment": ("moment", lambda r: r.moment),
        "work": ("friction_work", lambda r: r.friction_work),
        "power": ("friction_power", lambda r: r.friction_power),
        "traction": ({"traction": w}, lambda r: (w * r.traction).sum()),
        "slip": ({"slip": w}, lambda r: (w * r.slip).sum()),
        "pressure": ({"pressure": w[0]}, lambda r: (w[0] * r.pressure).sum()),
        "gap": ({"gap": w[0]}, lambda r: (w[0] * r.gap).sum()),
        "rigid": (
            {"rigid_displacement": w[:2]}, lambda r: (w[:2] * r.state.rigid_displacement).sum()
        ),
    }  # fmt: skip
    inputs: dict[str, tuple[str, Array]] = {
        "pose": ("pose", np.array([0.0, 1e-9, 0.0 if np.isnan(z) else 1e-9, 1e-9, 1e-9, 1e-8])),
        "shift": ("shift", 1e-4 * np.array([shift[1], shift[0]])),
        "gap": ("gap", 1e-11 * random.standard_normal(n)),
        "friction_field": ("friction", 1e-5 * random.standard_normal(n)),
        "diagonal": ("diagonal", 1e-19 * random.standard_normal(n)),
    }
    for part, value in state.items():
        loaded = np.where(before.pressure > 0.0, 1.0, 0.0)
        size = 1e-5 * np.abs(value).max() * loaded
        inputs[f"state.{part}"] = (f"state.{part}", size * random.standard_normal(value.shape))
    compared = 0
    for by, (key, direction) in inputs.items():
        base = state[key[6:]] if key.startswith("state.") else given[key]
        moved = {s: step({key: base + s * direction}) for s in (1.0, 0.5, -0.5, -1.0)}
        if any(not np.array_equal(made.status, m.status) for m in moved.values()):
            continue
        compared += 1
        forward = made._tangent().forward({by: direction[None]})
        np.testing.assert_allclose(
            forward["slip"][0], wanted := slope(lambda s, moved=moved: moved[s].slip),
            rtol=1e-5, atol=2e-6 * np.abs(wanted).max(),
        )  # fmt: skip
        for how, value in of.values():
            exact = np.tensordot(np.asarray(made.derivative(how, by)), direction, direction.ndim)
            wanted = slope(lambda s, moved=moved, value=value: value(moved[s]))
            least = 1e-6 * max(float(np.abs(value(made)).max()), 1e-6)
            np.testing.assert_allclose(
                exact, wanted, rtol=2e-6, atol=2e-6 * max(float(np.abs(wanted).max()), least),
                err_msg=f"{how} by {by}",
            )  # fmt: skip
    assert compared >= len(inputs) - 1
    np.testing.assert_allclose(
        made.derivative("force", "friction"), made.derivative("force", "friction_field").sum(axis=-1)
    )
    margin = made.margin()
    assert margin.slipping is not None
    assert margin.sticking is not None
    assert 0.0 < margin.smallest < 1.0


def test_a_uniform_pull() -> None:
    contact = ball(force=None, magnetic_pressure=1.5e7)
    state = contact.step(velocity=1.0).state

    def step(pull: float) -> Any:
        return contact.copy().step(shift=(-3.6e-6, 1.2e-6), velocity=1.0, magnetic_pressure=pull, state=state)

    made = step(1.5e7)
    wanted = slope(lambda s: step(1.5e7 + 1e4 * s).force) / 1e4
    assert (made.status == 2).any()
    np.testing.assert_allclose(
        made.derivative("force", "magnetic_pressure"), wanted, rtol=1e-6, atol=1e-6 * np.abs(wanted).max()
    )


def test_a_chain_of_steps() -> None:
    """Friction of the first of three steps acts on the force of the last one."""
    contact = ball()
    n, shifts = contact.area.size, ((-1.2e-6, 0.4e-6), (0.3e-6, 0.5e-6), (0.4e-6, -0.2e-6))
    start = contact.step(velocity=1.0).state

    def ride(change: Array) -> list[Any]:
        own, steps, state = contact.copy(), [], start
        for k, shift in enumerate(shifts):
            friction = np.full(n, 0.3) + (change if k == 0 else 0.0)
            steps.append(own.step(shift=shift, velocity=1.0, friction=friction, state=state))
            state = steps[-1].state
        return steps

    made = ride(np.zeros(n))
    direction = 1e-5 * np.random.default_rng(2).standard_normal(n)
    by = mtb.gradient_of_steps(made, [{}, {}, {"traction": np.stack([made[2].area, *np.zeros((2, n))])}])
    wanted = slope(lambda s: ride(s * direction)[2].force[0])
    assert by[0]["friction_field"] @ direction == pytest.approx(wanted, rel=1e-6)
    wanted = slope(lambda s: ride(s * direction)[1].friction_work)
    first = mtb.gradient_of_steps(made[:2], [{}, "friction_work"])[0]["friction_field"]
    assert first @ direction == pytest.approx(wanted, rel=1e-6)
    with pytest.raises(ValueError, match=r"does not start from the state of results\[0\]"):
        mtb.gradient_of_steps([made[0], made[2]], [{}, {}])


def test_a_step_from_rest_is_refused_by_name() -> None:
    made = ball().step(shift=(1e-6, 0.0), velocity=1.0)
    with pytest.raises(ValueError, match="started from rest"):
        made.derivative("force", "shift")


def test_both_sides_of_the_first_slip() -> None:
    """Where a cell is about to slip the two one-sided derivatives differ; each is that of its own side."""
    x = (np.arange(12) - 5.5) * 5e-4
    gap = x[None, :] ** 2 / 0.2 + x[:, None] ** 2 / 0.3
    pressed = mtb.solve_normal(gap, 5e-4, lower=mtb.steel, upper=mtb.steel, force=2000.0)

    def shifted(d: float) -> Any:
        return mtb.solve_tangential(pressed, mtb.Shift((d, 1e-7)), mtb.Coulomb(0.3), tolerance=1e-13)

    # some cells slip already, so that the slowest one can be told from them
    way = np.linspace(4e-7, 3e-6, 20)
    states = [shifted(d).status for d in way]
    low, high = next(
        (way[k], way[k + 1])
        for k, (one, other) in enumerate(itertools.pairwise(states))
        if (one == 2).any() and not np.array_equal(one, other)
    )
    while high - low > 1e-9 * high:
        middle = 0.5 * (low + high)
        if np.array_equal(shifted(middle).status, shifted(low).status):
            low = middle
        else:
            high = middle
    below, above = shifted(low), shifted(high)
    h = 1e-4 * high
    behind = (3 * below.force[0] - 4 * shifted(low - h).force[0] + shifted(low - 2 * h).force[0]) / (2 * h)
    ahead = (-3 * above.force[0] + 4 * shifted(high + h).force[0] - shifted(high + 2 * h).force[0]) / (2 * h)
    exact = [made.derivative("force", "displacement")[0, 0] for made in (below, above)]
    np.testing.assert_allclose(exact, [behind, ahead], rtol=1e-6)
    assert abs(exact[1] / exact[0] - 1.0) > 1e-4
    assert below.margin().slipping == pytest.approx(0.0, abs=1e-7)
    assert above.margin().sticking == pytest.approx(0.0, abs=1e-6)
