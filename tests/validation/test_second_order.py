# SPDX-License-Identifier: MIT OR Apache-2.0
"""Rolling whose errors are of second order in the cells.

Against closed forms, against the scheme of first order, and against itself where cells, directions and ways
of asking differ.
"""

import json
import math
from dataclasses import replace

import numpy as np
import pytest

import mtb_rs as mtb
from mtb_rs.commands import main
from mtb_rs.half_space import reference

STEEL = mtb.Material(210e9, 0.28)
FORCE, MU = 80e3, 0.3
COULOMB = mtb.Coulomb(MU)
V = 20.0
FREE = np.nan
#: Creepages and spin: along, across, spin, and all three with spin that helps and hinders.
CREEPAGES = [
    (1e-3, 0.0, 0.0),
    (0.0, 1e-3, 0.0),
    (0.0, 0.0, 0.3),
    (5e-4, 5e-4, 0.3),
    (1e-3, -5e-4, -0.5),
    (0.0, 6e-4, 0.8),
]


def pressed(cell, offset=(0.0, 0.0), lower=STEEL, upper=STEEL, radii=(0.46, 0.3)):
    """A wheel-like contact of 13 by 10 mm on cells of one size, which lie anywhere."""
    n = round(9e-3 / cell)
    at = (np.arange(2 * n + 1) - n) * cell
    x, y = np.meshgrid(at + offset[0] * cell, at + offset[1] * cell)
    gap = x**2 / (2.0 * radii[0]) + y**2 / (2.0 * radii[1])
    return mtb.solve_normal(gap, cell, lower=lower, upper=upper, force=FORCE)


def rolled(normal, creepage, **given):
    order = given.pop("order", 2)
    friction = given.pop("friction", COULOMB)
    layer = given.pop("layer", None)
    motion = mtb.Rolling(creepage, order=order, **given)
    return mtb.solve_tangential(normal, motion, friction, layer)


def bounded(result):
    """Forces over what friction carries."""
    return np.asarray(result.force)[:2] / (MU * FORCE)


# --- the order -------------------------------------------------------------------------------------------


@pytest.mark.parametrize("share", [0.25, 0.6])
def test_carter_converges_at_second_order_wherever_the_cells_lie(share):
    """The creepage of a line contact under a force [Johnson1985, ch. 8.3], at worst."""
    a, peak = 6e-3, 1e9
    errors: dict[int, list[float]] = {1: [], 2: []}
    for cells in (10, 20, 40):
        for order, found in errors.items():
            own = []
            for offset in np.linspace(-0.5, 0.4, 7):
                h = 2.0 * a / cells
                x = (np.arange(cells + 4) - 0.5 * (cells + 3) + offset) * h
                ends = np.clip([x - 0.5 * h, x + 0.5 * h], -a, a)
                whole = 0.5 * (ends * np.sqrt(1.0 - (ends / a) ** 2) + a * np.arcsin(ends / a))
                pressure = peak * (whole[1] - whole[0]) / h
                line = mtb.PressureField(pressure[None], (h, 1.0), STEEL, STEEL, reference=1.0)
                force = share * MU * pressure.sum() * h
                result = mtb.solve_tangential(line, mtb.Rolling(force=(force, None), order=order), COULOMB)
                exact = reference.carter_creepage(a, peak, MU, share, (STEEL, STEEL))
                own.append(result.creepage[0] / exact - 1.0)
            found.append(np.abs(own).max())
    first, second = np.array(errors[1]), np.array(errors[2])
    assert (first[1:] / first[:-1]).max() < 0.65
    assert (second[1:] / second[:-1]).max() < 0.4
    assert second[-1] / second[0] < 0.12
    assert (second < 0.45 * first).all()
    assert second[-1] < 0.12 * first[-1]


@pytest.mark.parametrize("creepage", CREEPAGES)
def test_it_ends_where_the_scheme_of_first_order_does_and_much_sooner(creepage):
    """Extrapolated from its two finest grids, that is another way to the same forces."""
    fine = {cell: bounded(rolled(pressed(cell), creepage, order=1)) for cell in (2e-4, 1e-4)}
    found = {cell: bounded(rolled(pressed(cell), creepage)) for cell in (1e-3, 5e-4, 2.5e-4, 1e-4)}
    assert found[1e-4] == pytest.approx(2.0 * fine[1e-4] - fine[2e-4], abs=1.2e-3)
    errors = [np.abs(found[cell] - found[1e-4]).max() for cell in (1e-3, 5e-4, 2.5e-4)]
    assert errors[0] < 7e-3
    assert errors[1] < 2.2e-3
    assert errors[2] < 7e-4
    # and the slip: what the tractions work on it, over the heat
    open_work = []
    for cell in (1e-3, 5e-4, 2.5e-4):
        result = rolled(pressed(cell), creepage)
        open_work.append(abs((result.traction[:2] * result.slip).sum() / result.dissipation.sum() - 1.0))
    assert open_work[1] < 0.5 * open_work[0]
    assert open_work[2] < 0.1 * open_work[0] + 1e-4


@pytest.mark.parametrize("creepage", CREEPAGES)
def test_forces_hardly_depend_on_where_the_cells_lie(creepage):
    xi, eta, phi = creepage
    spread = {}
    for order in (1, 2):
        found = []
        for at in [(0.0, 0.0), (0.25, 0.1), (0.5, 0.5), (-0.3, 0.25), (0.1, -0.4)]:
            # the middle of the contact, about which it spins
            x, y = -1e-3 * np.array(at)
            own = (xi + phi * y, eta - phi * x, phi)
            found.append(bounded(rolled(pressed(1e-3, at), own, order=order)))
        spread[order] = np.ptp(found, axis=0).max()
    assert spread[2] < 4e-3
    assert spread[2] < 0.8 * spread[1]


def test_forces_are_continuous_where_cells_come_into_contact():
    """As the load grows, cells join at the edges: no force jumps."""
    normal = [
        mtb.solve_normal(
            np.add.outer(y**2 / 0.6, y**2 / 0.92), 1e-3, lower=STEEL, upper=STEEL, force=float(force)
        )
        for y in [(np.arange(21) - 10) * 1e-3]
        for force in np.linspace(60e3, 84e3, 241)
    ]
    forces = np.array([rolled(one, (5e-4, 5e-4, 0.3)).force[:2] for one in normal])
    touching = [int((one.pressure > 0.0).sum()) for one in normal]
    assert len(set(touching)) > 4
    steps = np.diff(forces, axis=0)
    # a step is 0.15 % of the load
    assert np.abs(steps - np.median(steps, axis=0)).max() < 5e-4 * MU * 60e3


@pytest.mark.parametrize("ratio", [0.5, 1.0, 2.0])
def test_kalkers_coefficients_on_few_cells(ratio):
    """As published [Kalker1990], on 20 and 40 cells along either axis."""
    published = np.array(mtb.kalker_coefficients(ratio, 0.25)[:3])
    body = mtb.Material.from_shear_modulus(80e9, 0.25)
    a, b = 5e-3 * np.sqrt(ratio), 5e-3 / np.sqrt(ratio)
    e, unit = 1e-7, 80e9 * a * b
    small = [(e, 0.0, 0.0), (0.0, e, 0.0), (0.0, 0.0, e / np.sqrt(a * b))]
    wrong = {}
    for order, cells in ((1, 20), (1, 40), (2, 20), (2, 40)):
        patch = reference.elliptic_pressure(1e4, (a, b), (cells, cells), body, body)
        forces = mtb.creep_curve(patch, small, mtb.Coulomb(1.0), tolerance=1e-7, order=order) / (unit * e)
        wrong[order, cells] = np.abs([forces[0, 0], forces[1, 1], forces[2, 1]] / published - 1.0).max()
    assert wrong[2, 20] < 0.65 * wrong[1, 20]
    assert wrong[2, 40] < 0.5 * wrong[1, 40]
    assert wrong[2, 40] < 0.5 * wrong[2, 20]


@pytest.mark.parametrize("thickness", [1e-3, 6e-3])
def test_layers_converge_at_second_order_too(thickness):
    """A layer of the bodies' modulus, against the scheme of first order, extrapolated."""
    layer, creepage = mtb.InterfaceLayer(thickness, STEEL.shear_modulus), (1e-3, -5e-4, -0.5)
    fine = {cell: bounded(rolled(pressed(cell), creepage, order=1, layer=layer)) for cell in (2e-4, 1e-4)}
    found = {
        cell: bounded(rolled(pressed(cell), creepage, layer=layer)) for cell in (1e-3, 5e-4, 2.5e-4, 1e-4)
    }
    assert found[1e-4] == pytest.approx(2.0 * fine[1e-4] - fine[2e-4], abs=2e-3)
    errors = [np.abs(found[cell] - found[1e-4]).max() for cell in (1e-3, 5e-4, 2.5e-4)]
    assert errors[0] < 0.01
    assert errors[1] < 5e-3
    assert errors[2] < 0.35 * errors[0]
    assert errors[2] < 2e-3


# --- balances and relations ------------------------------------------------------------------------------


@pytest.mark.parametrize("layer", [None, mtb.InterfaceLayer(2e-5, 1e10)], ids=["bare", "layer"])
def test_heat_is_the_work_of_the_load(layer):
    """To rounding, spin included, which the scheme of first order misses by some per cent."""
    creepage = (5e-4, -4e-4, 0.3)
    for cell in (1e-3, 5e-4):
        result = rolled(pressed(cell), creepage, layer=layer)
        work = np.dot([*result.force[:2], result.spin_moment], creepage)
        assert result.dissipation.sum() * cell**2 == pytest.approx(work, rel=1e-10)


LAWS = {
    "Coulomb": lambda: COULOMB,
    "falling": lambda: mtb.FallingFriction(0.4, 0.2, 0.05),
    "memory": lambda: mtb.FallingFriction(0.4, 0.2, 0.05, memory=1e-3),
    "table": lambda: mtb.TabulatedFriction([0.0, 0.1, 0.5], [0.4, 0.3, 0.2], memory=1e-3),
    "temperature": lambda: mtb.TemperatureFriction([0.0, 400.0], [0.33, 0.14]),
}


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.filterwarnings("ignore:.*without a memory", "ignore:the peak pressure is")
def test_each_law_is_nearer_on_cells_of_one_size(law):
    friction = LAWS[law]()
    creepage = (5e-4, 5e-4, 0.3)
    fine = 2e-4
    truth = {
        order: np.asarray(rolled(pressed(fine), creepage, order=order, friction=friction).force)[:2]
        for order in (1, 2)
    }
    coarse = {
        order: np.asarray(rolled(pressed(1e-3), creepage, order=order, friction=friction).force)[:2]
        for order in (1, 2)
    }
    bound = MU * FORCE
    assert truth[2] == pytest.approx(truth[1], abs=4e-3 * bound)
    error = {order: np.abs(coarse[order] - truth[2]).max() / bound for order in (1, 2)}
    assert error[2] < 0.55 * error[1]


@pytest.mark.parametrize("layer", [None, mtb.InterfaceLayer(2e-4, 1e10)])
def test_directions_of_rolling_are_turned_and_mirrored_problems(layer):
    """Along x, against it, and along and against y, on the problem that is turned with it."""
    normal = pressed(1e-3, (0.2, 0.3))
    pressure = normal.pressure
    xi, eta, phi = 5e-4, -4e-4, 0.4
    given = {"lower": STEEL, "upper": STEEL}

    def found(field, creepage, angle):
        patch = mtb.PressureField(np.ascontiguousarray(field), (1e-3, 1e-3), **given)
        return rolled(patch, creepage, angle=angle, layer=layer)

    ahead = found(pressure, (xi, eta, phi), 0.0)
    # half a turn about z
    back = found(pressure[::-1, ::-1], (-xi, -eta, phi), math.pi)
    np.testing.assert_allclose(back.traction[:2], -ahead.traction[:2, ::-1, ::-1], atol=1.0)
    # mirrored across x
    mirrored = found(pressure[::-1], (xi, -eta, -phi), 0.0)
    np.testing.assert_allclose(mirrored.traction[0], ahead.traction[0, ::-1], atol=1.0)
    np.testing.assert_allclose(mirrored.traction[1], -ahead.traction[1, ::-1], atol=1.0)
    # a quarter turn to the left: x to y, y to -x
    left = found(np.rot90(pressure, -1), (-eta, xi, phi), 0.5 * math.pi)
    np.testing.assert_allclose(left.force[:2], [-ahead.force[1], ahead.force[0]], atol=1e-6 * FORCE)
    right = found(np.rot90(pressure, 1), (eta, -xi, phi), -0.5 * math.pi)
    np.testing.assert_allclose(right.force[:2], [ahead.force[1], -ahead.force[0]], atol=1e-6 * FORCE)


def test_rigid_slip_of_cells_is_that_of_creepage_and_spin():
    """Told cell by cell, at their middles, but for cells at the edge of the grid."""
    normal = pressed(1e-3)
    x, y = normal.points[0], normal.points[1]
    whole = rolled(normal, (5e-4, 4e-4, 0.3))
    for angle in (0.0, math.pi, 1.5708):
        whole = rolled(normal, (5e-4, 4e-4, 0.3), angle=angle)
        slip = np.stack([5e-4 - 0.3 * y, 4e-4 + 0.3 * x])
        apart = rolled(normal, (0.0, 0.0, 0.0), rigid_slip=slip, angle=angle)
        np.testing.assert_allclose(apart.traction, whole.traction, atol=10.0)


@pytest.mark.parametrize("share", [1.0, 0.5, 0.2])
def test_transient_steps_end_at_steady_rolling(share):
    normal = pressed(1e-3)
    creepage = (5e-4, 4e-4, 0.3)
    steady = rolled(normal, creepage)
    state = None
    for _ in range(round(90 / share)):
        motion = mtb.Rolling(creepage, order=2, transient=True, step=share * 1e-3)
        result = mtb.solve_tangential(normal, motion, COULOMB, state=state)
        state = result.state
    np.testing.assert_allclose(result.force, steady.force, atol=2e-5 * MU * FORCE)
    assert result.dissipation.sum() == pytest.approx(steady.dissipation.sum(), rel=1e-4)


def test_curves_and_tables_have_it():
    normal = pressed(1e-3)
    rows = [(5e-4, 4e-4, 0.3), (1e-3, 0.0, 0.0)]
    curve = mtb.creep_curve(normal, rows, COULOMB, order=2)
    for row, found in zip(rows, curve, strict=True):
        np.testing.assert_allclose(found[:2], rolled(normal, row).force[:2], atol=1e-5 * MU * FORCE)


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"order": 3}, "order is 3: 1 or 2 is needed"),
        ({"order": 2.0}, "order is 2.0: 1 or 2 is needed"),
        ({"order": True}, "order is True: 1 or 2 is needed"),
        ({"angle": 0.3}, "angle is 0.3 rad: slip of second order is known in rolling along the cells"),
        ({"step": 2.5e-4}, "step is 0.00025 m: slip of second order is measured over one cell"),
        ({"layer": mtb.PlasticLayer(2e-5, 1e10, yield_stress=1.5e8)}, "order is 2 and the layer yields"),
        ({"transient": True, "step": 2e-3}, "a transient step of second order is at most one cell long"),
        ({"transient": True, "angle": 0.5 * math.pi}, "a transient step of second order rolls along x"),
    ],
)
def test_what_it_cannot_do_is_refused(given, message):
    normal = pressed(1e-3)
    with pytest.raises(ValueError, match=message):
        rolled(normal, (1e-3, 0.0, 0.0), **given)


# --- wheels ----------------------------------------------------------------------------------------------


def wheel(cell=1e-3, **changes):
    return mtb.scenes.wheel_on_rail(lateral=0.0, force=60e3, spacing=cell, **changes)


def exact(wheels):
    return mtb.PreparedWheels(wheels._core.to_accuracy(1e-13, 1e-11, 1e-11))


POSE = [0.0, 1e-3, FREE, 0.0, 0.0, 2e-3]
KINDS = {
    "plain": {},
    "layer": {"layer": mtb.InterfaceLayer(2e-5, 1e10)},
    "conformal": {"conformal": True},
    "memory": {"friction": mtb.FallingFriction(0.4, 0.25, 0.2, memory=1e-3)},
    "rail": {"friction": mtb.RailFriction([-20e-3, 0.0, 20e-3], [0.2, 0.3, 0.4])},
    "unlike": {},
}


@pytest.mark.filterwarnings("ignore:the peak pressure is")
@pytest.mark.parametrize("y", [-4e-3, 2e-3, 6e-3, 8e-3])
def test_steps_are_of_second_order(y):
    """From the field side to the flange: against cells of 0.125 mm, on one patch throughout."""
    pose = [0.0, y, FREE, 0.0, 0.0, 2e-3]
    found = {}
    for order in (1, 2):
        for cell in (1e-3, 5e-4, 1.25e-4):
            step = wheel((cell, min(cell, 2.5e-4))).prepare(friction=COULOMB, order=order).step(pose, V)
            found[order, cell] = np.array([*step.force[:2] / (MU * 60e3), step.friction_power])
    truth = found[2, 1.25e-4]
    assert found[1, 1.25e-4][:2] == pytest.approx(truth[:2], abs=7e-3)
    error = {key: np.abs(value - truth)[:2].max() for key, value in found.items()}
    assert error[2, 1e-3] < 0.75 * error[1, 1e-3]
    assert error[2, 5e-4] < 3e-3
    assert error[2, 5e-4] < 0.4 * error[1, 5e-4]
    assert abs(found[2, 5e-4][2] / truth[2] - 1.0) < 0.01


@pytest.mark.parametrize("lateral", [0.0, -6e-3])
def test_a_step_is_what_its_patches_do_alone(lateral):
    step = wheel(5e-4).prepare(friction=COULOMB, order=2).step([0, lateral, FREE, 0, 0, 2e-3], V)
    for patch in step.patches:
        area = (patch.x[1] - patch.x[0]) * (patch.y[1] - patch.y[0])
        (force,) = mtb.creep_curve(patch, [patch.creepage], COULOMB, order=2)
        assert force[:2] == pytest.approx(area * patch.traction.sum(axis=(1, 2)), abs=1e-5 * MU * 60e3)
        slips = patch.status == 2
        size = np.hypot(*patch.traction)
        # cells that are nearly tied to slipping ones stay that much below their bound
        np.testing.assert_allclose(size[slips], MU * patch.pressure[slips], rtol=2e-3)
        along = (patch.traction * patch.slip_velocity).sum(axis=0)[slips]
        np.testing.assert_allclose(along, (size * np.hypot(*patch.slip_velocity))[slips], rtol=0.05, atol=1e4)


@pytest.mark.filterwarnings("ignore:order is 2 and the bodies are unlike")
@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("speed", [V, -V])
def test_steps_of_any_length_stay_at_steady_rolling(kind, speed):
    """With their heat, to rounding where bodies are reciprocal."""
    upper = mtb.Material(100e9, 0.3) if kind == "unlike" else mtb.steel
    wheels = exact(wheel(upper=upper).prepare(**{"friction": COULOMB, "order": 2} | KINDS[kind]))
    for cells in (0.02, 0.4, 1.0, 1.7):
        steady = step = wheels.step(POSE, speed)
        for _ in range(4):
            step = wheels.step(step.pose, speed, dt=cells * 1e-3 / V, transient=True)
        np.testing.assert_allclose(step.force, steady.force, atol=1e-5)
        # influences between rows that are turned are not reciprocal
        near = 5e-4 if kind == "conformal" else 1e-7
        assert step.friction_power == pytest.approx(steady.friction_power, rel=near)


@pytest.mark.parametrize("kind", KINDS)
def test_both_wheels_are_mirror_images(kind):
    wheels = exact(wheel().prepare(side="both", **{"friction": COULOMB, "order": 2} | KINDS[kind]))
    one = wheels.step([0.0, 2e-3, FREE, 1e-4, 0.0, 2e-3], V)
    other = wheels.step([0.0, -2e-3, FREE, -1e-4, 0.0, -2e-3], V)
    np.testing.assert_allclose(one.force * [1, -1, 1], other.force, atol=2e-5 * MU * 60e3)


def test_files_copies_and_cases_keep_it(tmp_path):
    wheels = wheel().prepare(side="both", friction=COULOMB, order=2)
    step = wheels.step(POSE, V)
    first = wheel().prepare(side="both", friction=COULOMB, order=1).step(POSE, V)
    plain = wheel().prepare(side="both", friction=COULOMB).step(POSE, V)
    np.testing.assert_array_equal(first.force, plain.force)
    assert np.abs(step.force - first.force).max() > 10.0
    wheels.save(tmp_path / "wheels.mtbw")
    for again in (mtb.PreparedWheels.load(tmp_path / "wheels.mtbw"), wheels.copy()):
        np.testing.assert_array_equal(again.step(POSE, V).force, step.force)
    (tmp_path / "case.toml").write_text(
        "scene = 'wheel_on_rail'\nlateral = 0.0\nforce = 60e3\nspacing = 1e-3\nfriction = 0.3\n"
        "[step_wheels]\nvelocity = 20.0\nside = 'both'\ny = 1e-3\nyaw = 2e-3\nroll = 0.0\norder = 2\n",
        encoding="utf-8",
    )
    assert main(["run", str(tmp_path / "case.toml"), "-o", str(tmp_path / "out")]) == 0
    summary = json.loads((tmp_path / "out" / "summary.json").read_text(encoding="utf-8"))
    np.testing.assert_allclose(summary["force"], step.force, rtol=1e-9)
    (tmp_path / "rolling.toml").write_text(
        "scene = 'wheel_on_rail'\nlateral = 0.0\nforce = 60e3\nspacing = 1e-3\nfriction = 0.3\n"
        "[rolling]\ncreepage = [1e-3, 0.0, 0]\norder = 2\n",
        encoding="utf-8",
    )
    assert mtb.load_case(tmp_path / "rolling.toml").motion == mtb.Rolling((1e-3, 0.0, 0.0), order=2)


def test_unlike_bodies_are_asked_about():
    """Their error is of first order, and larger than that of the first; by how much is told."""
    soft = mtb.Material(100e9, 0.3)
    forces = {}
    for order in (1, 2):
        for cell in (1e-3, 5e-4):
            normal = pressed(cell, upper=soft)
            if order == 2:
                with pytest.warns(UserWarning, match="order is 2 and the bodies are unlike"):
                    found = rolled(normal, (2e-3, 0.0, 0.0))
            else:
                found = rolled(normal, (2e-3, 0.0, 0.0), order=1)
            forces[order, cell] = bounded(found)[0]
    fine = bounded(rolled(pressed(1.25e-4, upper=soft), (2e-3, 0.0, 0.0), order=1))[0]
    for cell in (1e-3, 5e-4):
        assert abs(forces[2, cell] - fine) < 4.0 * abs(forces[1, cell] - fine)
    with pytest.warns(UserWarning, match="order is 2 and the bodies are unlike"):
        wheel(upper=soft).prepare(order=2)
    with pytest.warns(UserWarning, match="order is 2 and the bodies are unlike"):
        mtb.creep_curve(normal, [(2e-3, 0.0, 0.0)], COULOMB, order=2)
    # steel on another steel is like enough
    rolled(pressed(1e-3, upper=mtb.Material(208e9, 0.3)), (2e-3, 0.0, 0.0))


def test_pressures_next_to_nothing_are_no_trouble():
    pressure = pressed(1e-3).pressure.copy()
    touching = np.argwhere(pressure > 0.0)
    pressure[tuple(touching[0] + [0, 1])] = 1e-100
    pressure[tuple(touching[-1] - [0, 3])] = 1e-100
    field = mtb.PressureField(pressure, (1e-3, 1e-3), STEEL, STEEL)
    assert np.isfinite(rolled(field, (5e-4, 5e-4, 0.3)).force).all()
    layered = rolled(field, (5e-4, 5e-4, 0.3), layer=mtb.InterfaceLayer(2e-4, 1e10))
    assert np.isfinite(layered.force).all()


@pytest.mark.parametrize("share", [0.3, 0.7])
def test_the_step_derives_as_differences(share):
    """Of a transient step from a state, with its heat."""
    normal, creepage = pressed(1e-3), (5e-4, 4e-4, 0.3)
    field = mtb.half_space.pressure_field.pressure_field(normal)
    first = mtb.Rolling((2e-4, 0.0, 0.1), order=2, transient=True, step=5e-4)
    state = mtb.solve_tangential(field, first, COULOMB, tolerance=1e-12).state

    def at(step):
        motion = mtb.Rolling(creepage, order=2, transient=True, step=step)
        return mtb.solve_tangential(field, motion, COULOMB, state=state, tolerance=1e-12)

    step, small = share * 1e-3, 1e-9
    result = at(step)
    ends = [at(step + sign * small) for sign in (1.0, -1.0)]
    by = np.subtract(ends[0].force, ends[1].force) / (2.0 * small)
    np.testing.assert_allclose(result.derivative("force", "step"), by, rtol=1e-5, atol=1e-4 * abs(by).max())
    power = np.subtract(ends[0].friction_power, ends[1].friction_power) / (2.0 * small)
    assert result.derivative("friction_power", "step") == pytest.approx(power, rel=1e-4)


def test_an_order_of_something_else_is_refused():
    with pytest.raises(ValueError, match="order is 3: 1 or 2 is needed"):
        wheel().prepare(order=3)
    with pytest.raises(ValueError, match="order is for wheels on rails"):
        mtb.scenes.pole_shoe_on_rail(friction=0.3, spacing=12e-3).prepare("half-space", order=2)


@pytest.mark.filterwarnings("ignore:the peak pressure is")
def test_derivatives_of_rolling_are_differences():
    """By creepages, a force and pressures that keep the cells in contact."""
    normal = pressed(1e-3)
    field = mtb.half_space.pressure_field.pressure_field(normal)
    motion = mtb.Rolling((5e-4, 4e-4, 0.3), order=2)
    result = mtb.solve_tangential(field, motion, COULOMB, tolerance=1e-12)
    by = result.derivative("force", "creepage")
    for k in range(3):
        small = 1e-4 * motion.creepage[k]
        ends = [
            mtb.solve_tangential(
                field,
                replace(motion, creepage=tuple(np.add(motion.creepage, sign * small * np.eye(3)[k]))),
                COULOMB,
                tolerance=1e-12,
            ).force
            for sign in (1.0, -1.0)
        ]
        np.testing.assert_allclose(by[:, k], np.subtract(*ends) / (2.0 * small), rtol=2e-4, atol=1.0)
