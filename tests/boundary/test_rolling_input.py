# SPDX-License-Identifier: MIT OR Apache-2.0
"""Bad input to rolling and shifts is named; states can be saved and resumed; failures say so."""

from __future__ import annotations

import pickle
import re
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import mtb_rs as mtb
from mtb_rs.half_space import reference

PATCH = reference.elliptic_pressure(1e3, (2e-3, 3e-3), (10, 12), mtb.steel, mtb.steel)
MU = mtb.Coulomb(0.3)
FALLING = mtb.FallingFriction(0.4, 0.2, 0.01)
ROLL = mtb.Rolling(creepage=(1e-3, 0.0, 0.0))
LINE = reference.line_pressure(1e5, 3e-3, 20, mtb.steel, mtb.steel)
TWO = mtb.PressureField(np.array([[1e8, 0.0, 1e8]] * 3), (1e-3, 1e-3), mtb.steel, None)
SCENE_RESULT = mtb.scenes.paraboloid_on_plane(friction=0.0, force=100.0, points=18).solve(model="half-space")
STATE = mtb.solve_tangential(PATCH, mtb.Shift(displacement=(1e-6, 0.0)), MU).state


def patch(**changes: object) -> mtb.PressureField:
    values = {"pressure": PATCH.pressure, "spacing": (1e-3, 1e-3), "lower": mtb.steel, "upper": mtb.steel}
    return mtb.PressureField(**{**values, **changes})  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda: mtb.Rolling(creepage=(np.nan, 0, 0)), "creepage"),
        (lambda: mtb.Rolling(creepage=(0, 0)), "creepage"),
        (lambda: mtb.Rolling(velocity=0.0), "velocity is 0.0"),
        (lambda: mtb.Rolling(step=-1.0), "step is -1.0"),
        (lambda: mtb.Rolling(creepage=("1", 0, 0)), "creepage[0] is '1'"),
        (lambda: mtb.Rolling(creepage=1e-3), "3 finite numbers are needed"),
        (lambda: mtb.Rolling(transient="no"), "transient is 'no': True or False"),
        (lambda: mtb.Rolling(force=("1", None)), "force[0] is '1'"),
        (lambda: mtb.Rolling(force=(None, True)), "force[1] is True"),
        (lambda: mtb.Rolling(force=3.0), "force is 3.0: (Fx, Fy)"),
        (lambda: mtb.Rolling(force=(1.0, 2.0, 3.0)), "force is (1.0, 2.0, 3.0)"),
        (lambda: mtb.Rolling(angle="north"), "angle is 'north'"),
        (lambda: mtb.Shift(displacement=(1, 2, 3)), "displacement"),
        (lambda: mtb.Shift(force=(np.nan, None)), "force[0] is nan"),
        (lambda: mtb.Shift(duration=0.0), "duration"),
        (lambda: mtb.Coulomb(-0.1), "coefficient is -0.1"),
        (lambda: mtb.StaticKinetic(0.2, 0.3), "static is 0.2"),
        (lambda: mtb.FallingFriction(0.3, 0.1, 0.0), "half_slip is 0"),
        (lambda: mtb.TabulatedFriction((1.0, 2.0), (0.3, 0.2)), "slip_speed"),
        (lambda: mtb.TabulatedFriction((0.0, np.nan), (0.3, 0.2)), "slip_speed[1] is nan"),
        (lambda: mtb.TabulatedFriction((0.0, 1.0), (0.3, 0.2), memory=-1.0), "memory is -1"),
        (lambda: mtb.Coulomb("low"), "coefficient is 'low'"),
        (lambda: mtb.InterfaceLayer(1e-3, 0.0), "shear_modulus"),
        (lambda: patch(pressure=-PATCH.pressure), "must not be negative"),
        (lambda: patch(pressure=PATCH.pressure + np.inf), "pressure[0, 0] is inf"),
        (lambda: patch(spacing=(0.0, 1.0)), "spacing"),
        (lambda: patch(spacing=1e-3), "spacing is 0.001: two finite numbers [m]"),
        (lambda: patch(origin=(0.0,)), "origin is (0.0,): two finite numbers [m]"),
        (lambda: patch(lower=mtb.HalfSpace(mtb.steel)), "a Material, Layered or Prism is needed, or None"),
        (lambda: patch(pressure="soft"), "pressure is 'soft'"),
        (lambda: patch(lower=None, upper=None), "both bodies are rigid"),
        (lambda: patch(reference=1.0), "one row of cells"),
        (lambda: mtb.solve_tangential(patch(pressure=0 * PATCH.pressure), ROLL, MU), "zero everywhere"),
        (lambda: mtb.solve_tangential(3.0, ROLL, MU), "it has no 'pressure'"),
        (lambda: mtb.solve_tangential(PATCH, ROLL, 0.3), "friction is 0.3"),
        (lambda: mtb.solve_tangential(PATCH, ROLL, mtb.Coulomb(np.ones((2, 2)))), "coefficient has shape"),
        (lambda: mtb.solve_tangential(PATCH, ROLL, MU, state=STATE), "no past"),
        (lambda: mtb.solve_tangential(PATCH, ROLL, MU, state=5), "state is 5"),
        (lambda: mtb.solve_tangential(PATCH, ROLL, MU, layer=5), "layer is 5: an InterfaceLayer"),
        (lambda: mtb.solve_tangential(PATCH, 1e-3, MU), "motion is 0.001: a Rolling or a Shift"),
        (lambda: replace(STATE, traction=STATE.traction[0]), "state.traction has shape (12, 10)"),
        (lambda: replace(STATE, coefficient=-STATE.coefficient), "state.coefficient"),
        (lambda: replace(STATE, pressure=np.nan * STATE.pressure), "state.pressure[0, 0] is nan"),
        (lambda: mtb.solve_tangential(PATCH, ROLL, MU, tolerance=0.0), "tolerance is 0"),
        (lambda: mtb.creep_curve(PATCH, [[1e-3, 0, 0]], MU, layer=5), "layer is 5"),
        (lambda: mtb.creep_curve(PATCH, [[1e-3, np.nan, 0]], MU), "creepages[0, 1] is nan"),
        (lambda: mtb.solve_tangential(PATCH, mtb.Rolling(force=(301.0, None)), MU), "friction carries less"),
        (lambda: mtb.solve_tangential(PATCH, ROLL, MU, coupling="both"), "coupling is 'both'"),
        (lambda: mtb.solve_tangential(PATCH, ROLL, MU, coupling="full"), "needs a result of solve_normal"),
        (lambda: mtb.creep_curve(PATCH, [[1.0, 2.0]], MU), "has shape (1, 2): (3,) or (n, 3) is needed"),
        (lambda: mtb.fastsim(PATCH, (0, 0, 0), MU, bound="round"), "bound is 'round'"),
        (lambda: mtb.fastsim(PATCH, (0, 0, 0), mtb.FallingFriction(0.3, 0.1, 1.0, memory=1e-6)), "memory"),
        (lambda: mtb.fastsim(PATCH, (0, 0, 0), MU, order=True), "order is True"),
        (lambda: mtb.fastsim(PATCH, (0, 0, 0), MU, flexibilities=2), "3, 1 or 'blended'"),
        (
            lambda: mtb.fastsim(PATCH, (0, 0, 0), MU, slope_reduction=(1, 1)),
            "three numbers (k0, alpha, beta)",
        ),
        (lambda: mtb.fastsim(PATCH, (0, 0, 0), MU, slope_reduction=(1, 2, 0)), "slope_reduction[1] is 2"),
        (lambda: mtb.fastsim(PATCH, (0, 0, 0), MU, slope_reduction=(1, 1, -1)), "slope_reduction[2] is -1"),
        (lambda: mtb.fastsim(PATCH, (0, 0, 0), MU, angle=np.nan), "angle is nan"),
        (lambda: mtb.fastsim(PATCH, (0, 0, 0), MU, force=(301.0, None)), "friction carries less"),
        (lambda: mtb.fastsim(PATCH, (0, 0, 0), MU, force=3.0), "(Fx, Fy) [N] is needed"),
        (lambda: mtb.fastrip(PATCH, (0, 0, 0), mtb.FallingFriction(0.3, 0.1, 1.0)), "FaStrip takes Coulomb"),
        (lambda: mtb.fastrip(PATCH, (0, 0, 0), MU, stick_direction="x"), "stick_direction is 'x'"),
        (lambda: mtb.fastrip(LINE, (0, 0, 0), MU), "line contact"),
        (lambda: mtb.fastsim(PATCH, (0, 0, 0), MU, semi_axes=(1e-3, -1e-3)), "semi_axes[1] is -0.001"),
        (lambda: mtb.fastsim(patch(pressure=0 * PATCH.pressure), (0, 0, 0), MU), "zero everywhere"),
        (lambda: mtb.polach(patch(pressure=0 * PATCH.pressure), (0, 0, 0), MU), "zero everywhere"),
        (lambda: mtb.polach(LINE, (0, 0, 0), MU), "line contact"),
        (lambda: mtb.polach(TWO, (0, 0, 0), MU, semi_axes=(1e-3, 1e-3)), "2 separate contacts"),
        (lambda: mtb.polach(PATCH, (0, 0, 0), MU, velocity=0.0), "velocity is 0.0"),
        (lambda: mtb.polach(PATCH, (0, 0, 0), 0.3), "friction is 0.3"),
        (lambda: mtb.polach(PATCH, (0, 0, 0), MU, reduction=1.0), "reduction is 1.0"),
        (lambda: mtb.kalker_coefficients(20.0, 0.3), "semi-axes is 20"),
        (lambda: mtb.kalker_coefficients(None, 0.3), "ratio is None"),
        (lambda: mtb.kalker_coefficients(1.0, [0.3]), "poisson_ratio is [0.3]"),
        (lambda: mtb.solve_tangential(LINE, mtb.Rolling(angle=np.pi / 2), MU), "angle is 1.5708 rad"),
        (lambda: mtb.solve_tangential(LINE, mtb.Rolling(angle=0.3, transient=True), MU), "angle is 0.3 rad"),
        (lambda: mtb.solve_tangential(PATCH, mtb.Rolling(step=2e-6), MU), "step is 2e-06 m: steady"),
        (lambda: mtb.solve_tangential(SCENE_RESULT, ROLL, MU, coupling="full"), "normal is a Result"),
        (lambda: mtb.kalker_coefficients(1.0, 0.6), "poisson_ratio is 0.6"),
    ],
)
def test_bad_input_is_named(call: Callable[[], object], words: str) -> None:
    with pytest.raises(ValueError, match=re.escape(words)):
        call()


def test_a_state_survives_pickling() -> None:
    step = mtb.Rolling(creepage=(5e-4, 1e-4, 0.1), transient=True)
    direct = mtb.solve_tangential(PATCH, step, MU, state=STATE)
    resumed = mtb.solve_tangential(PATCH, step, MU, state=pickle.loads(pickle.dumps(STATE)))
    assert np.array_equal(direct.traction, resumed.traction)


def test_no_traction_without_friction_or_creepage() -> None:
    assert np.abs(mtb.solve_tangential(PATCH, ROLL, mtb.Coulomb(0.0)).traction).max() == 0.0
    assert np.abs(mtb.solve_tangential(PATCH, mtb.Rolling(), MU).traction).max() == 0.0
    assert not mtb.polach(PATCH, (1e-3, 1e-3, 0.1), mtb.Coulomb(0.0)).any()
    assert not mtb.fastsim(PATCH, (1e-3, 1e-3, 0.1), mtb.Coulomb(0.0)).force[:2].any()


@pytest.mark.parametrize(
    ("law", "creepage"),
    [
        (mtb.Coulomb(0.0), 1e-3),
        (mtb.TabulatedFriction([0.0, 0.01], [0.3, 0.0]), 1e-2),
        (mtb.Coulomb(np.where(np.arange(10) < 5, 0.0, 0.3) * np.ones((12, 1))), 2e-2),
    ],
)
def test_contact_without_friction_slips(law: mtb.Coulomb | mtb.TabulatedFriction, creepage: float) -> None:
    found = mtb.solve_tangential(PATCH, mtb.Rolling(creepage=(creepage, 0.0, 0.0)), law)
    assert np.array_equal(found.status == 2, PATCH.pressure > 0.0)
    assert found.report.contact_area == pytest.approx(np.sum(found.area[PATCH.pressure > 0.0]))
    free = (found.friction_coefficient == 0.0) & (PATCH.pressure > 0.0)
    assert free.any()
    assert found.slip[0][free] == pytest.approx(creepage, rel=0.2)


@pytest.mark.parametrize("share", [1.0 - 1e-13, 1.0, 1.0 + 1e-13])
def test_a_force_at_the_limit_is_refused(share: float) -> None:
    motion = mtb.Rolling(force=(share * 0.3 * PATCH.normal_force, None))
    with pytest.raises(ValueError, match="friction carries less"):
        mtb.solve_tangential(PATCH, motion, MU)


@pytest.mark.filterwarnings("ignore:StaticKinetic depends on the grid")
@pytest.mark.parametrize(
    ("kind", "numbers", "force"),
    [(mtb.FallingFriction, (0.3, 0.15, 0.05), 2900.0), (mtb.StaticKinetic, (0.3, 0.2), 2400.0)],
)
def test_a_force_beyond_what_a_falling_law_carries_is_refused_soon(
    kind: type[mtb.FallingFriction | mtb.StaticKinetic], numbers: tuple[float, ...], force: float
) -> None:
    law = kind(*numbers)
    normal = mtb.hertz(1e4, semi_axes=(4e-3, 3e-3)).on_grid((24, 24), (0.35e-3, 0.27e-3))
    with pytest.raises(mtb.ConvergenceError, match="above the largest one that this") as failure:
        mtb.solve_tangential(normal, mtb.Rolling(force=(force, None)), law)
    assert failure.value.result.report.iterations < 400


def test_the_law_that_contact_has_withdrawn_says_so_once() -> None:
    with pytest.warns(UserWarning, match="withdrawn this law as an artefact of the grid") as caught:
        law = mtb.StaticKinetic(0.3, 0.2)
    mtb.solve_tangential(PATCH, mtb.Rolling(creepage=(1e-3, 0.0, 0.0)), law)
    (warning,) = caught
    assert warning.filename == __file__


def test_a_line_contact_rolls_backwards_as_forwards() -> None:
    there, back = (
        mtb.solve_tangential(LINE, mtb.Rolling(creepage=(xi, 0.0, 0.0), angle=angle), MU)
        for xi, angle in ((1e-3, 0.0), (-1e-3, np.pi))
    )
    np.testing.assert_allclose(back.traction[0], -there.traction[0, :, ::-1], atol=1e-6 * 1e9)


def test_no_creepages_give_no_forces() -> None:
    assert mtb.fastsim_curve(PATCH, np.zeros((0, 3)), MU).shape == (0, 3)
    assert mtb.creep_curve(PATCH, np.zeros((0, 3)), MU).shape == (0, 3)
    assert mtb.polach(PATCH, np.zeros((0, 3)), MU).shape == (0, 3)


def test_friction_may_vary_over_the_patch() -> None:
    field = np.broadcast_to(np.linspace(0.1, 0.5, 12)[:, None], (12, 10))
    slides = mtb.solve_tangential(PATCH, mtb.Rolling(creepage=(1.0, 0.0, 0.0)), mtb.Coulomb(field))
    assert slides.force[0] == pytest.approx(
        np.sum(field * PATCH.pressure) * PATCH.spacing[0] * PATCH.spacing[1], rel=1e-6
    )


def test_what_does_not_converge_says_so() -> None:
    law = mtb.FallingFriction(static=0.33, kinetic=0.14, half_slip=0.1)
    body = mtb.Material.from_shear_modulus(82e9, 0.28)
    normal = reference.elliptic_pressure(106.7e3, (6.3e-3, 12.6e-3), (24, 24), body, body)
    motion = mtb.Rolling(creepage=(0.012, 0.0, 0.0))
    with pytest.raises(mtb.ConvergenceError, match=r"not found.*without a memory") as failure:
        mtb.solve_tangential(normal, motion, law, layer=mtb.InterfaceLayer(12.5e-3, 82e9))
    assert not failure.value.result.report.converged
    with pytest.raises(mtb.ConvergenceError, match=r"0\.012") as failure:
        mtb.creep_curve(normal, [(0.06, 0, 0), (0.012, 0, 0)], law, layer=mtb.InterfaceLayer(12.5e-3, 82e9))
    assert np.isnan(failure.value.result[1, 0])
    assert np.isfinite(failure.value.result[0, 0])


def test_a_table_is_saved_and_read(tmp_path: Path) -> None:
    table = mtb.CreepForceTable.build(ratios=(1.0,), nodes=5, cells=8)
    table.save(tmp_path / "table.npz")
    read = mtb.CreepForceTable.load(tmp_path / "table.npz")
    arguments = ((3e-3, 3e-3), 1e4, 80e9, 0.3, [(1e-3, 2e-4, -0.2)])
    assert np.array_equal(table.interpolate(*arguments), read.interpolate(*arguments))
    mirrored = table.interpolate(*arguments[:4], [(1e-3, -2e-4, 0.2)])
    assert mirrored == pytest.approx(read.interpolate(*arguments) * [1.0, -1.0, -1.0])
    with pytest.raises(ValueError, match="ratio 2"):
        table.interpolate((6e-3, 3e-3), *arguments[1:])
    for place, value, words in [
        (0, (-3e-3, -3e-3), "semi_axes[0] is -0.003"),
        (0, 3e-3, "semi_axes is 0.003"),
        (1, 0.0, "normal_force is 0.0"),
        (2, np.nan, "shear_modulus is nan"),
        (3, -0.3, "friction is -0.3"),
        (4, [(1e-3, np.inf, 0.0)], "creepages[0, 1] is inf"),
        (4, [1e-3, 0.0], "creepages has shape (2,): (3,) or (n, 3)"),
    ]:
        bad = [*arguments[:place], value, *arguments[place + 1 :]]
        with pytest.raises(ValueError, match=re.escape(words)):
            table.interpolate(*bad)
    assert not table.interpolate(*arguments[:3], 0.0, arguments[4]).any()
    table.save(tmp_path / "without_ending")
    again = mtb.CreepForceTable.load(tmp_path / "without_ending")
    assert np.array_equal(again.forces, table.forces)
    (tmp_path / "other.npz").write_bytes(b"nothing of the kind")
    np.savez(tmp_path / "part.npz", ratios=[1.0])
    np.savez(
        tmp_path / "short.npz", poisson_ratio=0.3, ratios=[1.0], scale=table.scale, forces=[0.0], cells=8
    )
    for name in ("other.npz", "part.npz", "short.npz"):
        with pytest.raises(ValueError, match=f"{name} is no creep-force table"):
            mtb.CreepForceTable.load(tmp_path / name)


def test_full_coupling_refuses_free_tilts_and_takes_punches():
    soft = mtb.Material(young_modulus=70e9, poisson_ratio=0.33)
    x = (np.arange(24) - 11.5) * 1e-4
    bowl = (x[None] ** 2 + x[:, None] ** 2) / 0.6
    tilted = mtb.solve_normal(
        bowl, 1e-4, lower=soft, upper=mtb.steel, force=20.0, moments_about_axes=(0.0, 20.0 * 1e-4)
    )
    rolling = mtb.Rolling(creepage=(1e-2, 0, 0))
    with pytest.raises(ValueError, match="free to tilt"):
        mtb.solve_tangential(tilted, rolling, mtb.Coulomb(0.3), coupling="full")
    punch = mtb.solve_normal(np.zeros((8, 8)), 1e-4, lower=soft, upper=mtb.steel, force=50.0)
    roll = mtb.solve_tangential(punch, rolling, mtb.Coulomb(0.3), coupling="full")
    assert roll.report.converged


@pytest.mark.coarse
def test_a_distance_common_to_all_points_costs_no_digits():
    x = (np.arange(16) - 7.5) * 1e-4
    bowl = (x[None] ** 2 + x[:, None] ** 2) / 0.6
    near = mtb.solve_normal(bowl, 1e-4, lower=mtb.steel, upper=mtb.steel, force=1e-2)
    far = mtb.solve_normal(bowl + 100.0, 1e-4, lower=mtb.steel, upper=mtb.steel, force=1e-2)
    assert far.normal_force == pytest.approx(1e-2, rel=1e-9)
    np.testing.assert_allclose(far.pressure, near.pressure, rtol=1e-3, atol=1e-3 * near.pressure.max())


@pytest.mark.parametrize(
    ("call", "name"),
    [
        (lambda **v: np.array(mtb.Rolling(creepage=(1e-3, 0.0, 0.0), **v).velocity), "Rolling"),
        (lambda **v: mtb.creep_curve(PATCH, [(2e-3, 0.0, 0.0)], FALLING, **v), "creep_curve"),
        (lambda **v: mtb.fastsim(PATCH, (2e-3, 0.0, 0.0), FALLING, **v).force, "fastsim"),
        (lambda **v: mtb.fastsim_curve(PATCH, [(2e-3, 0.0, 0.0)], FALLING, **v), "fastsim_curve"),
        (lambda **v: mtb.polach(PATCH, (2e-3, 0.0, 0.0), FALLING, **v), "polach"),
    ],
)
def test_the_old_name_of_the_velocity_still_works(call, name):
    with pytest.warns(DeprecationWarning, match=f"argument speed of {name} is called velocity now") as caught:
        old = call(speed=2.0)
    assert [Path(one.filename).name for one in caught] == ["test_rolling_input.py"]
    np.testing.assert_array_equal(old, call(velocity=2.0))
    with pytest.raises(TypeError, match="both velocity and speed"):
        call(velocity=2.0, speed=2.0)


def test_old_names_of_the_velocity_can_be_read():
    with pytest.warns(DeprecationWarning, match=r"Rolling\.speed is called velocity now"):
        assert mtb.Rolling(velocity=3.0).speed == 3.0  # type: ignore[attr-defined]
    with pytest.warns(DeprecationWarning, match="is called slip_speed now"):
        assert FALLING.sliding(speed=0.5) == FALLING.sliding(0.5)  # type: ignore[call-arg]


@pytest.mark.parametrize("name", ["static", "kinetic", "half_slip", "memory"])
def test_an_array_for_one_number_is_shown_in_one_line(name: str) -> None:
    given = {"static": 0.4, "kinetic": 0.2, "half_slip": 0.01, "memory": 1e-3, name: np.ones((30, 4))}
    with pytest.raises(ValueError, match=rf"{name} is array.*: a finite number is needed") as caught:
        mtb.FallingFriction(**given)  # type: ignore[arg-type]
    assert "\n" not in str(caught.value)
    with pytest.raises(
        ValueError, match=r"coefficient is array.*: numbers of at least 0 are needed"
    ) as caught:
        mtb.Coulomb(np.full((30, 4), -1.0))
    assert "\n" not in str(caught.value)


def test_progress_is_a_function_or_a_bar(capsys: pytest.CaptureFixture[str]) -> None:
    patch, law, rows = mtb.hertz(5e3, 0.4).on_grid((10, 10), 5e-4), mtb.Coulomb(0.3), [[1e-4, 0.0, 0.0]] * 2
    shares: list[float] = []
    mtb.creep_curve(patch, rows, law, progress=shares.append)
    assert shares == [0.5, 1.0]
    pytest.importorskip("tqdm")
    mtb.creep_curve(patch, rows, law, progress=True)
    assert "rolling: 100%" in capsys.readouterr().err
    mtb.CreepForceTable.build((1.0,), nodes=4, cells=4, progress=True)
    assert "tabulating: 100%" in capsys.readouterr().err
    for wrong in ("yes", False, 1):
        with pytest.raises(ValueError, match=f"progress is {wrong!r}: a function, True .* or None"):
            mtb.creep_curve(patch, rows, law, progress=wrong)
