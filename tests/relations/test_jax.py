# SPDX-License-Identifier: MIT OR Apache-2.0
"""Results as functions of JAX: its own check of gradients, forward and in reverse."""

from __future__ import annotations

import subprocess
import sys
from typing import Any

import numpy as np
import pytest

import mtb_rs as mtb

jax = pytest.importorskip("jax")
test_util = pytest.importorskip("jax.test_util")

N = 8
X = (np.arange(N) - 0.5 * (N - 1)) * 1e-3
BALL = (X[None, :] ** 2 + X[:, None] ** 2) / 0.4
SCENE = mtb.Scene(mtb.Material(80e9, 0.1), mtb.steel, gap=BALL, spacing=1e-3, force=2e3, moments=(0.0, 0.0))

pytestmark = pytest.mark.filterwarnings("ignore::mtb_rs.ToleranceWarning")


@pytest.fixture(autouse=True)
def _double() -> Any:
    with jax.enable_x64(True):
        yield


def stepped() -> Any:
    contact = SCENE.with_(friction=0.3).prepare("half-space")
    by = {"gap": "gap", "friction": "friction_field", "velocity": "velocity"}
    at = {"gap": np.zeros(N * N), "friction": np.full(N * N, 0.3), "velocity": np.array([4.0, 1.0])}
    return mtb.jax_function(lambda **given: contact.step(**given), ("force", "peak_pressure"), by, at), at


def test_gradients_are_those_that_jax_checks() -> None:
    function, at = stepped()
    # in units in which all of them are about one
    sizes = {"gap": 1e-7, "friction": 0.1, "velocity": 1.0}

    def scaled(*given: Any) -> Any:
        force, peak = function(*(at[name] + sizes[name] * v for name, v in zip(at, given, strict=True)))
        return force / 2e3, peak / 1e9

    random = np.random.default_rng(0)
    given = [0.3 * random.standard_normal(np.shape(at[name])) for name in at]
    test_util.check_grads(scaled, given, order=1, modes=["fwd", "rev"], eps=1e-3, rtol=1e-5, atol=1e-7)
    with pytest.raises(NotImplementedError, match="second derivatives of a solve are not known"):
        jax.jacfwd(jax.jacrev(scaled))(*given)


def test_it_is_compiled_mapped_and_differentiated() -> None:
    function, at = stepped()

    def brake(friction: Any) -> Any:
        return function(at["gap"], friction, velocity=at["velocity"])[0][0]

    slope = jax.jit(jax.grad(brake))(at["friction"])
    assert slope.shape == (N * N,)
    assert float(slope.sum()) == pytest.approx(2e3 * 4.0 / np.hypot(4.0, 1.0), rel=1e-6)
    forces = jax.vmap(brake)(np.array([np.full(N * N, mu) for mu in (0.1, 0.2)]))
    assert forces[1] / forces[0] == pytest.approx(2.0)


def test_fields_and_scenes() -> None:
    def solve(force: Any) -> mtb.Result:
        return SCENE.with_(force=float(force), friction=0.3).solve(model="half-space")

    field = mtb.jax_function(solve, "pressure", {"force": "force"}, {"force": 2e3})
    slope = jax.jacfwd(field)(2e3)
    assert float((slope * 1e-6).sum()) == pytest.approx(1.0)


def test_numbers_reach_the_solve_as_numbers() -> None:
    # a scene and a motion refuse an array without axes, and a friction would be a field
    def solve(force: Any, friction: Any) -> mtb.Result:
        return SCENE.with_(force=force, friction=friction).solve(model="half-space")

    by = {"force": "force", "friction": "friction"}
    function = mtb.jax_function(solve, "force", by, {"force": 2e3, "friction": 0.3})
    by_force, by_friction = jax.jacrev(function, (0, 1))(2e3, 0.3)
    assert float(by_force[0]) == pytest.approx(0.3)
    assert float(by_friction[0]) == pytest.approx(2e3)
    with pytest.raises(TypeError, match="force is complex: real numbers are needed"):
        function(2e3 + 1j, 0.3)


def test_what_does_not_fit_is_told() -> None:
    contact = SCENE.prepare("half-space")

    def solve(gap: Any) -> mtb.StepResult:
        return contact.step(gap=gap)

    with pytest.raises(ValueError, match=r"at\['gap'\] has shape \(\), but gap has the shape \(64,\)"):
        mtb.jax_function(solve, "force", {"gap": "gap"}, {"gap": 0.0})
    with pytest.raises(ValueError, match="the arguments of by, are needed"):
        mtb.jax_function(solve, "force", {"gap": "gap"}, {})
    words = "of is 'weight': a StepResult does not have this as a number or an array"
    with pytest.raises(ValueError, match=words):
        mtb.jax_function(solve, "weight", {"gap": "gap"}, {"gap": np.zeros(N * N)})
    with jax.enable_x64(False), pytest.raises(ValueError, match="single precision"):
        mtb.jax_function(solve, "force", {"gap": "gap"}, {"gap": np.zeros(N * N)})


def test_jax_is_imported_only_when_asked_for() -> None:
    told = subprocess.run(
        [sys.executable, "-c", "import sys, mtb_rs; print('jax' in sys.modules)"],
        capture_output=True, text=True, check=True,
    )  # fmt: skip
    assert told.stdout.strip() == "False"


def test_what_is_no_argument_or_number_is_refused_at_the_call() -> None:
    function, at = stepped()
    with pytest.raises(TypeError, match="it was given gap twice"):
        function(at["gap"], at["friction"], at["velocity"], gap=at["gap"])
    with pytest.raises(TypeError, match="velocity is missing"):
        function(at["gap"], at["friction"])
    with pytest.raises(TypeError, match="it was given depth too"):
        function(at["gap"], at["friction"], at["velocity"], depth=1.0)
    with pytest.raises(TypeError, match="it was given 4 arguments"):
        function(at["gap"], at["friction"], at["velocity"], 1.0)
    with pytest.raises(ValueError, match="solve cannot be called so"):
        mtb.jax_function(lambda gap: SCENE.solve(), of="force", by={"gab": "gap"}, at={"gab": 0.0})
    with pytest.raises(TypeError, match=r"gap has shape \(\): \(64,\), as in at"):
        function(1e-6, at["friction"], at["velocity"])
    contact = SCENE.with_(friction=0.3).prepare("half-space")

    def solve(friction: Any) -> Any:
        return contact.step(friction=float(friction))

    for of, words in (({"pressure": np.ones(N * N)}, "of is"), ("weight", "StepResult does not have this")):
        with pytest.raises(ValueError, match=words):
            mtb.jax_function(solve, of, {"friction": "friction"}, {"friction": 0.3})  # type: ignore[arg-type]


def test_a_number_of_jax_is_a_number() -> None:
    result = SCENE.with_(friction=0.3).solve(model="half-space")
    value, weights = jax.value_and_grad(lambda p: (p**2).sum())(result.pressure)
    by = result.derivative(lambda _: (value, {"pressure": weights}), "force")
    own = result.derivative({"pressure": 2.0 * result.pressure}, "force")
    assert by == pytest.approx(own, rel=1e-12)


@pytest.mark.parametrize(
    ("changed", "words"),
    [
        ({"solve": None}, "^solve is None: a function"),
        ({"of": None}, "^of is None"),
        ({"of": []}, r"^of is \[\]"),
        ({"by": None}, "^by is None: a mapping"),
        ({"by": {}}, "^by is {}: a mapping"),
        ({"by": ["gap"]}, "^by is .*: a mapping"),
        ({"by": {"gap": None}}, "^by is .*: a mapping"),
        ({"at": None}, "^at is None: a mapping"),
        ({"at": "gap"}, "^at is 'gap': a mapping"),
        ({"at": {"gap": "flat"}}, r"^at\['gap'\] is 'flat': real numbers"),
        ({"at": {"gap": None}}, r"^at\['gap'\] is None: real numbers"),
    ],
)
def test_what_is_none_of_the_arguments_is_refused_in_words(changed: dict[str, Any], words: str) -> None:
    contact = SCENE.prepare("half-space")
    given = {"solve": lambda gap: contact.step(gap=gap), "of": "force", "by": {"gap": "gap"}}
    with pytest.raises(ValueError, match=words):
        mtb.jax_function(**(given | {"at": {"gap": np.zeros(N * N)}} | changed))


def test_numbers_of_wheels_and_patches() -> None:
    wheels = mtb.scenes.wheel_on_rail(lateral=0.0, force=60e3, spacing=1e-3).prepare(side="both")
    pose = np.array([0.0, 1e-3, np.nan, np.nan, 0.0, 1e-3])
    step = wheels.step(pose, 20.0)
    names = ("vertical_force", "rail_displacement", "position", "creepage", "contact_angle", "normal_force")
    for of in names:
        made = mtb.jax_function(lambda pose: wheels.step(pose, 20.0), of, {"pose": "pose"}, {"pose": pose})
        wanted = step.derivative(of, "pose")
        assert np.asarray(made(pose)).shape == wanted.shape[:-1]
        np.testing.assert_allclose(
            np.asarray(jax.jacfwd(made)(pose)), wanted, rtol=1e-6, atol=1e-9 * abs(wanted).max() + 1e-6
        )
    with pytest.raises(ValueError, match="of is 'pressure': a WheelStep does not have this as a number"):
        mtb.jax_function(lambda pose: wheels.step(pose, 20.0), "pressure", {"pose": "pose"}, {"pose": pose})
