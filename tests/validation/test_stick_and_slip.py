# SPDX-License-Identifier: MIT OR Apache-2.0
"""Shifts and rolling against closed forms and against fields of CONTACT (tests/data/contact)."""

from __future__ import annotations

import gzip
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import mtb_rs as mtb
from mtb_rs._mtb_rs import Compliance, ContactGeometry, Problem, half_space
from mtb_rs.half_space import reference

DATA = Path(__file__).parents[1] / "data" / "contact"
#: of all runs in that folder
BODY = mtb.Material.from_shear_modulus(82e9, 0.28)
MU = mtb.Coulomb(0.3)
LIMIT = 0.3 * 1e4  # N


def table(name: str) -> Any:
    path = DATA / name
    text = gzip.decompress(path.read_bytes()).decode() if path.suffix == ".gz" else path.read_text("utf-8")
    return np.genfromtxt(text.splitlines(), delimiter=",", names=True, dtype=None, encoding=None)


def contact_fields(name: str) -> tuple[mtb.PressureField, np.ndarray, Any]:
    """Pressure, traction on the lower body [Pa], and the table, of a 45 x 45 run."""
    rows = table(name)
    pressure = mtb.PressureField(rows["pn"].reshape(45, 45) * 1e6, (0.16e-3, 0.16e-3), BODY, BODY)
    return pressure, -np.stack([rows["px"], rows["py"]]).reshape(2, 45, 45) * 1e6, rows


@pytest.fixture(scope="module")
def circle() -> mtb.PressureField:
    return contact_fields("steady_circle_ksi5e-4.csv.gz")[0]


def relative(found: np.ndarray, exact: np.ndarray) -> float:
    return float(np.linalg.norm(found - exact) / np.linalg.norm(exact))


def test_steady_rolling_meets_contact_cell_by_cell() -> None:
    pressure, traction, rows = contact_fields("steady_circle_ksi5e-4.csv.gz")
    roll = mtb.solve_tangential(pressure, mtb.Rolling(creepage=(-5e-4, 0.0, 0.0)), MU)
    # printed to six digits
    assert relative(roll.traction[:2], traction) < 1e-5
    assert np.array_equal(roll.status.ravel(), rows["igs"])
    slip = np.hypot(*roll.slip).ravel()
    assert np.abs(slip - rows["srel"]).max() < 1e-5 * rows["srel"].max()
    assert roll.force[0] == pytest.approx(-1498.96, abs=0.01)
    assert roll.force[2] == -pressure.normal_force


@pytest.mark.parametrize("by_force", [False, True])
def test_shift_meets_contact_cell_by_cell(by_force: bool) -> None:
    pressure, traction, rows = contact_fields("cattaneo_circle_fx0.5.csv.gz")
    motion = mtb.Shift(force=(1500.0, None)) if by_force else mtb.Shift(displacement=(2.72347e-6, 0.0))
    shift = mtb.solve_tangential(pressure, motion, MU)
    assert relative(shift.traction[:2], traction) < 1e-5
    assert np.array_equal(shift.status.ravel(), rows["igs"])
    assert shift.creepage[0] == pytest.approx(2.72347e-6, rel=1e-5)
    assert shift.force[0] == pytest.approx(1500.0, rel=1e-5)


def test_creep_curves_of_contact(circle: mtb.PressureField) -> None:
    rows = table("creep_curves_circle.csv")
    rows = rows[rows["method"] == "contact_full"]
    creepages = np.stack([rows["cksi"], rows["ceta"], 1e3 * rows["cphi_rad_per_mm"]], axis=1)
    forces = mtb.creep_curve(circle, creepages, MU)
    assert np.abs(forces[:, 0] + rows["Fx_N"]).max() < 1e-5 * LIMIT
    assert np.abs(forces[:, 1] + rows["Fy_N"]).max() < 1e-5 * LIMIT
    assert np.abs(forces[:, 2] + 1e-3 * rows["Mz_Nmm"]).max() < 1e-5 * LIMIT * 3.2e-3


def test_from_cattaneo_to_carter(circle: mtb.PressureField) -> None:
    rows = table("cattaneo_to_carter_forced.csv")
    force = (1971.0, None)
    step = mtb.solve_tangential(circle, mtb.Shift(force=force), MU)
    found = [(step.creepage[0] * 1e3, np.count_nonzero(step.status == 1))]
    for _ in rows[1:]:
        step = mtb.solve_tangential(circle, mtb.Rolling(force=force, transient=True), MU, state=step.state)
        found.append((step.creepage[0], np.count_nonzero(step.status == 1)))
    creepage, stick = np.array(found).T
    assert np.allclose(creepage, rows["rigid_shift_mm_or_cksi"], rtol=2e-4)  # printed to four digits
    assert np.array_equal(stick, rows["nadh"])
    # and on to the steady state, which the same force reaches at once
    steady = mtb.solve_tangential(circle, mtb.Rolling(force=force), MU)
    assert creepage[-1] == pytest.approx(steady.creepage[0], rel=1e-3)


def test_first_order_towards_the_known_limit() -> None:
    forces = []
    for n in (25, 50, 100):
        patch = reference.elliptic_pressure(1e4, (3.205e-3, 3.205e-3), (n, n), BODY, BODY)
        forces.append(mtb.solve_tangential(patch, mtb.Rolling(creepage=(5e-4, 0.0, 0.0)), MU).force[0])
    # CONTACT extrapolates to 1475 +- 3 N
    assert forces[2] - (forces[1] - forces[2]) == pytest.approx(1475.0, abs=5.0)
    assert forces[0] > forces[1] > forces[2] > 1475.0


def test_sphere_pushed_sideways() -> None:
    """Cattaneo and Mindlin, exact without Poisson's ratio [Johnson1985, ch. 7.2]."""
    body = mtb.Material.from_shear_modulus(82e9, 0.0)
    a, force, share = 3e-3, 1e4, 0.6
    shift = reference.cattaneo_displacement(force, a, 0.3, share, (body, body))
    field_error, force_error = [], []
    for n in (20, 40, 80):
        patch = reference.elliptic_pressure(force, (a, a), (n, n), body, body)
        found = mtb.solve_tangential(patch, mtb.Shift(displacement=(shift, 0.0)), MU)
        radius = np.hypot(*found.points)
        exact = reference.cattaneo_traction(radius, a, 1.5 * force / np.pi / a**2, 0.3, share)
        field_error.append(relative(found.traction[0], exact))
        force_error.append(abs(found.force[0] / (share * LIMIT) - 1.0))
    assert field_error[-1] < 6e-3
    assert np.log2(field_error[0] / field_error[-1]) / 2 > 0.9
    assert force_error[-1] < 3e-4
    assert np.log2(force_error[0] / force_error[-1]) / 2 > 1.8


@pytest.mark.parametrize("share", [0.3, 0.7, 0.95])
def test_rolling_cylinder(share: float) -> None:
    """Carter [Johnson1985, ch. 8.3]: line contact, first order in the cell size."""
    a, load = 3e-3, 1e6
    peak = 2.0 * load / np.pi / a
    creepage = reference.carter_creepage(a, peak, 0.3, share, (BODY, BODY))
    field_error, force_error, creepage_error = [], [], []
    for n in (50, 200, 800):
        patch = reference.line_pressure(load, a, n, BODY, BODY)
        found = mtb.solve_tangential(patch, mtb.Rolling(creepage=(creepage, 0.0, 0.0)), MU)
        exact = reference.carter_traction(patch.coordinates()[0], a, peak, 0.3, share)
        field_error.append(relative(found.traction[0, 0], exact))
        force_error.append(abs(found.force[0] / (share * 0.3 * load) - 1.0))
        driven = mtb.solve_tangential(patch, mtb.Rolling(force=(share * 0.3 * load, None)), MU)
        # systems of a line under a force are too ill-conditioned for single precision
        assert driven.report.iterations <= 6
        creepage_error.append(abs(driven.creepage[0] / creepage - 1.0))
    assert field_error[-1] < 2e-3
    assert force_error[-1] < 6e-4
    # an error of the force turns into one of the creepage by d ln xi / d ln F
    stick = reference.carter_stick_share(share)
    assert creepage_error[-1] < 6e-4 * max(share / (2.0 * stick * (1.0 - stick)), 1.0)
    for errors in (force_error, creepage_error):
        assert np.log2(errors[0] / errors[-1]) / 4 > 0.9


@pytest.mark.parametrize("ratio", [0.5, 1.0, 2.0])
def test_kalkers_coefficients(ratio: float) -> None:
    rows = table("kalker_coefficients.csv")
    row = rows[(rows["nu"] == 0.25) & (rows["a_over_b"] == ratio) & (rows["elements_per_2a"] == 80)][0]
    published = mtb.kalker_coefficients(ratio, 0.25)
    assert published[:3] == pytest.approx([row["table_C11"], row["table_C22"], row["table_C23"]], rel=1e-9)
    body = mtb.Material.from_shear_modulus(80e9, 0.25)
    a, b = 5e-3 * np.sqrt(ratio), 5e-3 / np.sqrt(ratio)
    patch = reference.elliptic_pressure(1e4, (a, b), (80, 80), body, body)
    e, unit = 1e-7, 80e9 * a * b
    small = [(e, 0.0, 0.0), (0.0, e, 0.0), (0.0, 0.0, e / np.sqrt(a * b))]
    forces = mtb.creep_curve(patch, small, mtb.Coulomb(1.0), tolerance=1e-7) / (unit * e)
    found = [forces[0, 0], forces[1, 1], forces[2, 1]]
    assert found == pytest.approx(published[:3], rel=0.01)
    assert found == pytest.approx([row["C11"], row["C22"], row["C23"]], rel=1e-3)
    assert -forces[1, 2] / np.sqrt(a * b) == pytest.approx(-row["C32_from_Mz"], rel=1e-3)
    assert forces[2, 2] / np.sqrt(a * b) == pytest.approx(row["C33"], rel=2e-3)


LAYER = mtb.InterfaceLayer(1.524e-4, 1e9)  # 1.524e-4 mm3/N
FALL = mtb.FallingFriction(static=0.33, kinetic=0.14, half_slip=1.25)
MEMORY = mtb.FallingFriction(static=0.33, kinetic=0.14, half_slip=1.25, memory=3e-6, memory_min_slip=1e-3)
FIGURE_1 = {
    "original_coulomb0.33": (mtb.Coulomb(0.33), None),
    "falling_mem_nolayer": (MEMORY, None),
    "layerL1.524e-4_coulomb": (mtb.Coulomb(0.33), LAYER),
    "layerL1.524e-4_falling_mem(paper_intended)": (MEMORY, LAYER),
    "layerL1.524e-4_falling_nomem": (FALL, LAYER),
    "layerL1.524e-6_falling_mem(as_printed)": (MEMORY, mtb.InterfaceLayer(0.125e-3, 82e9)),
}


@pytest.mark.parametrize("model", FIGURE_1)
def test_traction_curve_of_the_europrinter(model: str) -> None:
    """[Vollebregt2012, fig. 1] as CONTACT computes it; that run's own pressure was not kept."""
    friction, layer = FIGURE_1[model]
    rows = table("paper_fig1.csv")
    rows = rows[rows["model"] == model]
    patch = reference.elliptic_pressure(106.7e3, (6.3e-3, 12.6e-3), (42, 42), BODY, BODY)
    creepages = np.stack([rows["cksi"], 0.0 * rows["cksi"], 0.0 * rows["cksi"]], axis=1)
    forces = mtb.creep_curve(patch, creepages, friction, layer=layer, velocity=10.0)
    assert np.abs(forces[:, 0] + rows["Fx_N"]).max() < 1e-3 * 0.33 * 106.7e3


def test_rolling_in_any_direction_is_rolling(circle: mtb.PressureField) -> None:
    xi, eta, phi = 4e-4, -3e-4, 0.2
    ahead = mtb.solve_tangential(circle, mtb.Rolling(creepage=(xi, eta, phi)), MU)
    quarter = mtb.Rolling(creepage=(-eta, xi, phi), angle=np.pi / 2)
    turned = mtb.solve_tangential(circle, quarter, MU)
    # rotate the first solution by a quarter turn: x -> y, y -> -x
    rotated = np.stack([-np.rot90(ahead.traction[1], -1), np.rot90(ahead.traction[0], -1)])
    assert relative(turned.traction[:2], rotated) < 1e-6
    assert turned.spin_moment == pytest.approx(ahead.spin_moment, rel=1e-6)
    backward = mtb.solve_tangential(circle, mtb.Rolling(creepage=(-xi, -eta, phi), angle=np.pi), MU)
    assert backward.force[:2] == pytest.approx(-ahead.force[:2], rel=1e-6)
    # between the axes the step is interpolated: the circle must not feel it
    diagonal = mtb.solve_tangential(
        circle, mtb.Rolling(creepage=(5e-4 / np.sqrt(2), 5e-4 / np.sqrt(2), 0.0), angle=np.pi / 4), MU
    )
    straight = mtb.solve_tangential(circle, mtb.Rolling(creepage=(5e-4, 0.0, 0.0)), MU)
    # 1.6 % is what the straight one is from its limit of 1475 N on this grid
    assert np.hypot(*diagonal.force[:2]) == pytest.approx(straight.force[0], rel=0.016)


def test_transient_rolling_ends_in_the_steady_state() -> None:
    circle = reference.elliptic_pressure(1e4, (3.2e-3, 3.2e-3), (20, 20), BODY, BODY)
    creepage = (3e-4, 2e-4, 0.15)
    steady = mtb.solve_tangential(circle, mtb.Rolling(creepage=creepage), MU)
    state = None
    for _ in range(180):
        step = mtb.solve_tangential(circle, mtb.Rolling(creepage=creepage, transient=True), MU, state=state)
        state = step.state
    assert relative(step.traction, steady.traction) < 1e-6
    assert relative(step.slip, steady.slip) < 1e-5
    assert step.creepage == pytest.approx(creepage)


@pytest.mark.filterwarnings("ignore:coefficient reaches")
def test_unlike_bodies_feel_their_pressure() -> None:
    """Free rolling of unlike cylinders [Johnson1985, ch. 8.2]: traction without creepage force."""
    soft = mtb.Material.from_shear_modulus(1e9, 0.25)
    patch = reference.line_pressure(1e5, 3e-3, 200, soft, mtb.Material(1e15, 0.3))
    roll = mtb.solve_tangential(patch, mtb.Rolling(force=(0.0, None)), mtb.Coulomb(10.0))
    assert abs(roll.force[0]) < 1e-6 * 1e5
    # equal materials roll freely without any
    equal = reference.line_pressure(1e5, 3e-3, 200, soft, soft)
    free = mtb.solve_tangential(equal, mtb.Rolling(creepage=(0.0, 0.0, 0.0)), mtb.Coulomb(10.0))
    assert np.abs(free.traction).max() == 0.0
    assert np.abs(roll.traction).max() > 0.01 * patch.pressure.max()


@pytest.mark.filterwarnings("ignore:StaticKinetic depends on the grid")
def test_static_and_kinetic_friction_meet_the_law(circle: mtb.PressureField) -> None:
    law = mtb.StaticKinetic(static=0.4, kinetic=0.3)
    for motion in (mtb.Rolling(creepage=(6e-4, 2e-4, 0.1)), mtb.Shift(displacement=(3e-6, 0.0))):
        found = mtb.solve_tangential(circle, motion, law)
        size = np.hypot(*found.traction[:2])
        slips = found.status == 2
        assert np.allclose(size[slips], 0.3 * circle.pressure[slips], rtol=1e-6)
        assert np.all(size <= 0.4 * circle.pressure * (1 + 1e-6))


def test_start_of_sliding_is_the_same_dense_or_by_fourier() -> None:
    from mtb_rs._mtb_rs import half_space

    patch = reference.elliptic_pressure(1e4, (3e-3, 3e-3), (12, 12), BODY, BODY)
    # two equal half-spaces are one of half the shear modulus
    both = half_space((41e9, 0.28), [(0.0, 0.0, 12, 12)], patch.spacing, True)
    area = np.full(144, patch.spacing[0] * patch.spacing[1])
    path = np.array([[1e-6, 0.0], [2e-6, 1e-6], [3e-5, 1e-6]])
    layer = mtb.InterfaceLayer(1e-5, 80e9)
    dense = mtb.start_of_sliding(both, patch.pressure, area, 0.3, path, layer)
    forces: dict[int, list[np.ndarray]] = {}
    for parts in (32, 64):
        state, last, forces[parts] = None, np.zeros(2), []
        for to in path:
            motion = mtb.Shift(displacement=tuple((to - last) / parts))
            for _ in range(parts):
                step = mtb.solve_tangential(patch, motion, MU, layer=layer, state=state)
                state = step.state
            last = to
            forces[parts].append(step.force[:2])
    # a path in parts is right to first order: twice the finer one less the coarser one is the limit
    limit = 2.0 * np.array(forces[64]) - np.array(forces[32])
    assert (np.abs(dense.force - limit).max(axis=1) <= (dense.path_error + 1e-6) * LIMIT).all()
    assert dense.path_error[-1] < 3e-3
    assert dense.slip_share[-1] == 1.0
    assert dense.force[-1, 0] == pytest.approx(LIMIT, rel=1e-3)


@settings(max_examples=60, deadline=None)
@given(
    cells=st.tuples(st.integers(1, 24), st.integers(1, 24)),
    aspect=st.floats(-1.0, 1.0),
    size=st.floats(-4.0, 3.0),
    direction=st.tuples(*[st.floats(-1.0, 1.0)] * 3),
    angle=st.floats(-3.2, 3.2),
    holes=st.integers(0, 2**31),
    rolls=st.booleans(),
    layer=st.sampled_from([0.0, 1e-14, 1e-12]),
)
def test_every_problem_is_solved(
    cells: tuple[int, int],
    aspect: float,
    size: float,
    direction: tuple[float, float, float],
    angle: float,
    holes: int,
    rolls: bool,
    layer: float,
) -> None:
    """Full adhesion to full slip, strong spin, patches with holes, cells from 0.1 to 10 in shape."""
    nx, ny = cells
    dx, dy = 1e-4, 1e-4 * 10**aspect
    x = (np.arange(nx) - 0.5 * (nx - 1)) * 2 / nx
    y = (np.arange(ny) - 0.5 * (ny - 1)) * 2 / ny
    pressure = 1e9 * np.sqrt(np.maximum(1 - x**2 - y[:, None] ** 2, 0.0))
    random = np.random.default_rng(holes)
    pressure[random.random(pressure.shape) < 0.3 * random.random()] = 0.0
    if not np.any(pressure):
        pressure[0, 0] = 1e9
    field = mtb.PressureField(pressure, (dx, dy), BODY, BODY)
    scale = 0.3 * 1e9 / 82e9 * 10**size
    reach = max(nx * dx, ny * dy)
    xi, eta, phi = (scale * d for d in direction)
    motion: mtb.Rolling | mtb.Shift
    if rolls:
        motion = mtb.Rolling(creepage=(xi, eta, phi / reach), angle=angle)
    else:
        motion = mtb.Shift(displacement=(xi * reach, eta * reach), spin=phi)
    found = mtb.solve_tangential(field, motion, MU, layer=mtb.InterfaceLayer(layer, 1.0))
    bound = 0.3 * pressure
    assert np.all(np.hypot(*found.traction[:2]) <= bound * (1 + 1e-9))
    slips = found.status == 2
    # where it slips, traction has the size of the bound and the direction of slip
    power = np.sum(found.traction[:2] * found.slip, axis=0)[slips]
    exact = (bound * np.hypot(*found.slip))[slips]
    assert np.all(power >= exact - 1e-5 * np.abs(exact).max(initial=0.0))


@settings(max_examples=30, deadline=None)
@given(
    share=st.one_of(st.floats(0.0, 0.9), st.floats(0.9, 0.9999)),
    angle=st.floats(0.0, 6.3),
    cells=st.tuples(st.integers(4, 30), st.integers(4, 30)),
    rolls=st.booleans(),
    spin=st.floats(-0.05, 0.05),
)
def test_any_force_below_the_limit_is_reached(
    share: float, angle: float, cells: tuple[int, int], rolls: bool, spin: float
) -> None:
    patch = reference.elliptic_pressure(1e4, (3e-3, 4e-3), cells, BODY, BODY)
    force = (share * LIMIT * np.cos(angle), share * LIMIT * np.sin(angle))
    # spin takes its part of friction: only as much as leaves the force within reach
    rest = spin * (1.0 - share) ** 2
    motion = mtb.Rolling(creepage=(0.0, 0.0, rest), force=force) if rolls else mtb.Shift(force=force)
    found = mtb.solve_tangential(patch, motion, MU)
    assert found.force[:2] == pytest.approx(force, abs=1e-6 * LIMIT)


def test_unlike_bodies_change_their_pressure_a_little() -> None:
    soft = mtb.Material(5e9, 0.2)
    h = 0.34e-3
    x = (np.arange(40) - 19.5) * h
    gap = (x**2 + x[:, None] ** 2) / (2 * 0.3)
    motion = mtb.Rolling(creepage=(2e-3, 0.0, 0.0))
    like = mtb.solve_normal(gap, (h, h), lower=mtb.steel, upper=mtb.steel, force=3000.0)
    unlike = mtb.solve_normal(gap, (h, h), lower=soft, upper=mtb.steel, force=3000.0)
    assert mtb.solve_tangential(like, motion, MU).report.omitted == {}
    one_way = mtb.solve_tangential(unlike, motion, MU)
    full = mtb.solve_tangential(unlike, motion, MU, coupling="full")
    left_out = one_way.report.omitted["gap_change_by_traction_m"]
    assert 0.0 < left_out < 0.1 * unlike.approach
    effect = full.report.force_balance["pressure_change_by_traction"]
    assert 1e-4 < effect < 0.2
    assert full.pressure.sum() * h * h == pytest.approx(3000.0, rel=1e-6)
    # what moves the gap at the leading edge up moves it down at the trailing one
    shift = np.sum(full.pressure * full.points[0]) / np.sum(full.pressure)
    assert abs(shift) > 1e-6


def test_a_drive_too_small_for_its_squares_is_none(circle: mtb.PressureField) -> None:
    found = mtb.solve_tangential(circle, mtb.Rolling(creepage=(0.0, 1e-158, 0.0)), MU)
    assert found.report.converged
    assert np.abs(found.force[:2]).max() < 1e-100 * LIMIT


@pytest.mark.parametrize("size", [1e-12, 1e-14, 1e-15])
def test_tiny_drives_are_linear(size: float) -> None:
    patch = reference.elliptic_pressure(1e4, (3e-3, 4e-3), (40, 40), BODY, BODY)
    direction = np.array([1.0, 0.7, 100.0])

    def of_creepage(scale: float) -> np.ndarray:
        found = mtb.solve_tangential(patch, mtb.Rolling(creepage=tuple(scale * direction)), MU)
        return np.array([*found.force[:2], found.spin_moment]) / scale

    assert of_creepage(size) == pytest.approx(of_creepage(1e-7), rel=1e-6)
    for motion in (mtb.Rolling, mtb.Shift):
        large, small = (
            mtb.solve_tangential(patch, motion(force=(share * LIMIT, 0.4 * share * LIMIT)), MU)
            for share in (1e-4, 1e3 * size)
        )
        assert small.creepage[:2] / (1e3 * size) == pytest.approx(large.creepage[:2] / 1e-4, rel=1e-6)
        assert small.force[:2] / (1e3 * size * LIMIT) == pytest.approx([1.0, 0.4], rel=1e-6)


def two_contacts(distance: float, cells: int = 30) -> mtb.PressureField:
    """Two ellipses side by side, loaded by 10 kN and 8 kN."""
    one = reference.elliptic_pressure(1e4, (3e-3, 4e-3), (cells, cells), BODY, BODY)
    between = np.zeros((round(distance / one.spacing[1]) - cells, cells))
    return mtb.PressureField(np.vstack([one.pressure, between, 0.8 * one.pressure]), one.spacing, BODY, BODY)


@pytest.mark.parametrize("creepage", [(1e-3, 0.0, 0.0), (3e-4, 3e-4, 0.05), (0.0, 5e-4, 0.02)])
def test_fast_approximations_on_two_contacts(creepage: tuple[float, float, float]) -> None:
    both = two_contacts(16e-3)
    limit = 0.3 * both.normal_force
    full = mtb.solve_tangential(both, mtb.Rolling(creepage=creepage), MU)
    simple = mtb.fastsim(both, creepage, MU)
    # what the theory itself is off on one ellipse, not more
    assert np.abs(simple.force[:2] - full.force[:2]).max() < 0.05 * limit
    assert simple.spin_moment == pytest.approx(full.spin_moment, abs=0.03 * limit * 16e-3)
    closed = mtb.polach(both, creepage, MU)
    assert np.abs(closed[:2] - full.force[:2]).max() < 0.07 * limit
    # the forces of both at their places; what each has about its own centre is left out
    assert closed[2] == pytest.approx(full.spin_moment, abs=0.06 * limit * 16e-3)
    # the same contacts one by one, with the creepages that spin makes of their places
    apart = [
        mtb.fastsim(replace(part, origin=None), (creepage[0] - creepage[2] * y, *creepage[1:]), MU)
        for _, part in both.patches()
        for y in [part.centre()[1]]
    ]
    assert simple.force == pytest.approx(apart[0].force + apart[1].force, rel=1e-9, abs=1e-9)


def test_contacts_that_touch_at_a_corner_are_one() -> None:
    def count(rows: list[list[int]]) -> int:
        pressure = np.array(rows, dtype=float)
        return len(mtb.PressureField(pressure, (1e-3, 1e-3), BODY, BODY).patches())

    assert count([[1, 0], [0, 1]]) == 1
    assert count([[1, 0, 1], [1, 0, 1], [1, 1, 1]]) == 1
    assert count([[1, 1, 1], [1, 0, 1], [0, 0, 0], [1, 0, 1]]) == 3
    assert count([[0, 1, 0, 1], [1, 0, 1, 0]]) == 1


@pytest.mark.parametrize("layer", [None, mtb.InterfaceLayer(0.1e-3, 1e9)])
def test_a_creep_curve_is_the_same_in_any_order(
    circle: mtb.PressureField, layer: mtb.InterfaceLayer | None
) -> None:
    line = np.linspace(-3.0, 3.0, 25)[:, None] * np.array([1e-3, -0.5e-3, 0.2])
    # a corner, a jump, a place twice, and a place alone
    rows = np.concatenate(
        [line, line[-1:] * np.array([1.0, 2.0, 1.0]), line[:3], line[2:3], [[1e-2, 0.0, 0.0]]]
    )
    forces = mtb.creep_curve(circle, rows, MU, layer=layer, tolerance=1e-9)
    alone = np.concatenate([mtb.creep_curve(circle, row, MU, layer=layer, tolerance=1e-9) for row in rows])
    size = np.abs(alone).max(axis=0)
    np.testing.assert_allclose(forces / size, alone / size, rtol=0.0, atol=1e-7)


def test_a_creep_curve_tells_how_far_it_is(circle: mtb.PressureField) -> None:
    done: list[float] = []
    mtb.creep_curve(circle, [[1e-4, 0, 0], [2e-4, 0, 0]], MU, progress=done.append)
    assert done == [0.5, 1.0]


def as_one(
    normal: mtb.NormalResult, displacement: tuple[float, float], friction: float, soft: Any, stiff: Any
) -> Any:
    """One Newton method on pressure and traction: of bodies displaced, the pressure's own share taken off."""
    ny, nx = normal.pressure.shape
    cell = normal.spacing[0]
    bodies = [
        half_space((body.shear_modulus, body.poisson_ratio), [(0.0, 0.0, nx, ny)], (cell, cell), True)
        for body in (soft, stiff)
    ]
    x = (np.arange(nx) - 0.5 * (nx - 1)) * cell
    points = nx * ny
    places = np.stack([*(v.ravel() for v in np.meshgrid(x, x)), np.zeros(points)])
    up = np.repeat([[[0.0], [0.0], [1.0]]], points, axis=2)
    level = ContactGeometry(places, np.full(points, cell**2))
    problem = Problem(bodies[0], bodies[1], level, up, [True])
    push = np.repeat([[displacement[0]], [displacement[1]], [0.0]], points, axis=1)
    # a shift counts the displacements by the pressure itself
    rest = np.stack([np.zeros(points), np.zeros(points), normal.pressure.ravel()])
    push[:2] -= Compliance.relative(*bodies).displacement(rest)[:2]
    gap = (x**2 + x[:, None] ** 2) / 0.1
    loading = problem.loading(gap.ravel(), np.array([-BALL_FORCE]))
    (found,) = problem.stick_or_slip(loading, np.full(points, friction), 0.0, push[None], 1e-10)
    assert found.status == "solved"
    return found


BALL_FORCE = 30.0
SOFT, STIFF = (mtb.Material.from_shear_modulus(g, nu) for g, nu in ((20e9, 0.2), (80e9, 0.3)))


def pressed_ball(lower: mtb.Material, upper: mtb.Material) -> mtb.NormalResult:
    n, cell = 14, 1e-4
    x = (np.arange(n) - 0.5 * (n - 1)) * cell
    gap = (x**2 + x[:, None] ** 2) / 0.1
    return mtb.solve_normal(gap, cell, lower=lower, upper=upper, force=BALL_FORCE, tolerance=1e-10)


@pytest.mark.filterwarnings("ignore:coefficient reaches 1000")
@pytest.mark.parametrize("displacement", [(0.0, 0.0), (3e-7, 1e-7), (1e-6, 0.0)])
def test_problems_in_turn_and_as_one_agree_for_unlike_bodies(displacement: tuple[float, float]) -> None:
    """The alternation of solve_tangential against one Newton method on pressure and traction.

    Everything sticks: what sticks does not depend on the path, which the one takes in parts.
    """
    normal = pressed_ball(SOFT, STIFF)
    in_turn = mtb.solve_tangential(
        normal, mtb.Shift(displacement=displacement), mtb.Coulomb(1e3), coupling="full"
    )
    found = as_one(normal, displacement, 1e3, SOFT, STIFF)
    assert relative(in_turn.traction[:2], found.traction.reshape(2, 14, 14)) < 1e-6
    assert relative(in_turn.pressure.ravel(), found.pressure) < 1e-6
    assert np.array_equal(in_turn.status.ravel(), found.points)
    change = np.abs(found.pressure - normal.pressure.ravel()).max() / normal.pressure.max()
    assert change > 0.05  # the bodies act on each other by no small share
    assert in_turn.report.force_balance["pressure_change_by_traction"] == pytest.approx(change, rel=1e-4)


@pytest.mark.parametrize("displacement", [(3e-7, 1e-7), (1e-6, 0.0)])
def test_slip_in_parts_and_as_one_agrees(displacement: tuple[float, float]) -> None:
    """Of bodies that are alike the pressure displaces nothing, so that both take the same straight path."""
    normal = pressed_ball(SOFT, SOFT)
    forces = {}
    for parts in (32, 64):
        state = None
        for _ in range(parts):
            motion = mtb.Shift(displacement=(displacement[0] / parts, displacement[1] / parts))
            step = mtb.solve_tangential(normal, motion, MU, state=state)
            state = step.state
        forces[parts] = step.force[:2]
    limit = 2.0 * forces[64] - forces[32]
    found = as_one(normal, displacement, 0.3, SOFT, SOFT)
    force = found.traction.reshape(2, -1).sum(axis=1) * normal.spacing[0] ** 2
    assert np.abs(force - limit).max() <= (found.path_error + 1e-6) * 0.3 * BALL_FORCE


@pytest.mark.parametrize("ratio", [0.2, 0.5, 2.0, 5.0])
@pytest.mark.parametrize("upper", [BODY, mtb.Material.from_shear_modulus(40e9, 0.2)], ids=["like", "unlike"])
def test_mirrored_and_turned_problems_have_mirrored_and_turned_tractions(
    ratio: float, upper: mtb.Material
) -> None:
    """Ellipses, oblong cells, spin, falling friction with memory, a layer, any rolling angle."""
    axes = (np.sqrt(12e-6 * ratio), np.sqrt(12e-6 / ratio))
    patch = reference.elliptic_pressure(1e4, axes, (26, 34), BODY, upper)
    law = mtb.FallingFriction(0.33, 0.14, 1.25, memory=3e-6)
    layer = mtb.InterfaceLayer(1e-4, 8e9)
    xi, eta, phi = 1.1e-3, -6e-4, 0.4

    def traction(field: mtb.PressureField, creepage: tuple[float, float, float], angle: float) -> np.ndarray:
        motion = mtb.Rolling(creepage=creepage, angle=angle)
        return mtb.solve_tangential(field, motion, law, layer=layer).traction[:2]

    first = traction(patch, (xi, eta, phi), 0.0)
    mirrored = traction(patch, (xi, -eta, -phi), 0.0)[:, ::-1]
    assert relative(mirrored * np.array([1.0, -1.0])[:, None, None], first) < 1e-7
    half_turn = traction(patch, (-xi, -eta, phi), np.pi)
    assert relative(-half_turn[:, ::-1, ::-1], first) < 1e-7
    turned = mtb.PressureField(patch.pressure.T[:, ::-1], patch.spacing[::-1], BODY, upper)
    along_y = traction(turned, (-eta, xi, phi), 0.5 * np.pi)
    assert relative(np.stack([along_y[1].T[::-1], -along_y[0].T[::-1]]), first) < 1e-7


@pytest.mark.parametrize(
    "motion", [mtb.Shift(displacement=(3e-6, 0.0)), mtb.Rolling((4e-4, 3e-4, 0.2), transient=True)]
)
def test_newton_steps_stay_few_on_finer_grids(motion: mtb.Rolling | mtb.Shift) -> None:
    # each linear system is solved to the last reduction of the residual to the power of 1.5
    steps = []
    for n in (25, 50, 80):
        patch = reference.elliptic_pressure(1e4, (3.2e-3, 3.2e-3), (n, n), BODY, BODY)
        steps.append(mtb.solve_tangential(patch, motion, MU).report.iterations)
    assert max(steps) <= 5


@pytest.mark.parametrize("cells", [150, 300])
@pytest.mark.parametrize("motion", ["force", "creepage"])
def test_long_line_contacts_that_slip_both_ways_are_solved(cells: int, motion: str) -> None:
    """Slip that turns along a line contact, in steps that are no whole cells."""
    x = (np.arange(cells) - 0.5 * (cells - 1)) / (0.5 * cells)
    pressure = 5e8 * np.sqrt(np.clip(1.0 - 1.2 * x**2, 0.0, None))[None]
    limit = 0.3 * float(pressure.sum()) * 1e-4
    line = mtb.PressureField(pressure, (1e-4, 1.0), mtb.steel, mtb.steel, reference=1.0)
    by_force = mtb.Rolling(force=(0.5 * limit, 0.5 * limit), step=1.7e-4)
    rolling = by_force if motion == "force" else mtb.Rolling((1e-3, -2e-3, 0.0), step=0.5e-4)
    result = mtb.solve_tangential(line, rolling, mtb.Coulomb(0.3))
    assert result.report.converged
    bound = 0.3 * pressure
    assert np.hypot(*result.traction[:2]).max() <= bound.max() * (1.0 + 1e-12)
    assert np.all(np.hypot(*result.traction[:2]) <= bound * (1.0 + 1e-9))
    slips = result.status == 2
    along = np.einsum("cij,cij->ij", result.slip, result.traction[:2])[slips]
    # friction on the lower body goes where the upper one slips to
    assert np.all(along >= 0.999 * (np.hypot(*result.slip) * bound)[slips])
    if motion == "force":
        np.testing.assert_allclose(result.force[:2], 0.5 * limit, rtol=1e-7)


@pytest.mark.parametrize(
    ("creepage", "angle"),
    [((0, 0, 0), 0.0), ((1e-3, 0, 0), 0.0), ((0, 5e-4, 0.3), 0.0), ((3e-4, 2e-4, 0), np.pi / 2)],
)
def test_the_heat_of_unlike_bodies_is_creep_and_rolling_resistance(creepage: Any, angle: float) -> None:
    """Work of the load: on the creep, and on the way, where the pressure leans ahead of the contact."""
    soft, radius, errors = mtb.Material(young_modulus=5e9, poisson_ratio=0.3), 0.05, []
    for n in (20, 40, 80):
        cell = 8e-3 / n
        x = (np.arange(n) + 0.5) * cell - 4e-3
        gap = (x**2 + x[:, None] ** 2) / (2.0 * radius)
        normal = mtb.solve_normal(gap, cell, lower=mtb.steel, upper=soft, force=500.0)
        rolling = mtb.Rolling(creepage, angle=angle)
        found = mtb.solve_tangential(normal, rolling, MU, coupling="full")
        assert mtb.solve_tangential(normal, rolling, MU).rolling_resistance is None
        resistance = found.rolling_resistance
        assert resistance is not None
        heat = float((found.dissipation * found.area).sum())
        load = float(found.force[:2] @ found.creepage[:2] + found.spin_moment * found.creepage[2])
        errors.append(abs(heat - load - resistance) / heat)
    # the moment of the pressure about the middle of the contact, for a sphere on a plane
    way = x * np.cos(angle) + x[:, None] * np.sin(angle)
    moment = float((found.pressure * found.area * way).sum())
    assert resistance == pytest.approx(moment / radius, rel=1e-2)
    assert resistance > 0.5 * heat
    # of first order and better in the cells
    assert errors[0] < 0.05
    assert errors[2] < 0.3 * errors[0]
    with pytest.raises(ValueError, match="'force' and 'friction_power'"):
        found.gradient("rolling_resistance")
    like = mtb.solve_normal(gap, cell, lower=soft, upper=soft, force=500.0)
    assert mtb.solve_tangential(like, rolling, MU, coupling="full").rolling_resistance is None


def sphere(n: int, cell: float, **given: Any) -> mtb.NormalResult:
    """A steel sphere of 30 mm on something soft."""
    x = (np.arange(n) - 0.5 * (n - 1)) * cell
    soft = mtb.Material(3e9, 0.2)
    return mtb.solve_normal((x**2 + x[:, None] ** 2) / 0.06, cell, lower=mtb.steel, upper=soft, **given)


def test_full_coupling_keeps_what_was_given() -> None:
    rolling = mtb.Rolling((4e-3, 0.0, 0.0))
    for load in ({"force": 1000.0}, {"approach": 1.2e-4}):
        normal = sphere(40, 2e-4, **load)
        found = mtb.solve_tangential(normal, rolling, MU, coupling="full")
        if "force" in load:
            assert found.normal_force == pytest.approx(1000.0, rel=1e-6)
        else:
            # the tractions press the surfaces up between them
            assert found.normal_force > 1.005 * normal.normal_force
    ball = mtb.hertz(1e4, 0.3, lower=mtb.steel, upper=mtb.Material(3e9, 0.2)).on_grid((24, 24), 1.2e-3)
    full = mtb.solve_tangential(ball, rolling, MU, coupling="full")
    assert full.normal_force == pytest.approx(1e4, rel=1e-6)
    for method in ("kpec", "analyn"):
        quick = sphere(40, 2e-4, force=1000.0, method=method)
        with pytest.raises(ValueError, match=f"approximation by '{method}'"):
            mtb.solve_tangential(quick, rolling, MU, coupling="full")


def test_full_coupling_refuses_a_contact_that_grows_over_the_edge() -> None:
    x = (np.arange(40) - 19.5) * 1e-4
    gap = (x**2 + x[:, None] ** 2) / 0.06
    normal = mtb.solve_normal(gap, 1e-4, lower=mtb.Rigid(), upper=mtb.Material(3e9, 0.0), force=960.0)
    with pytest.raises(ValueError, match="the contact reaches the edge of the grid"):
        mtb.solve_tangential(normal, mtb.Rolling((5e-2, 0, 0)), mtb.Coulomb(0.6), coupling="full")


def test_derivatives_of_full_coupling_go_by_what_was_given() -> None:
    rolling, step = mtb.Rolling((4e-3, 0.0, 0.0)), 1e-8
    found = mtb.solve_tangential(sphere(30, 2.6e-4, approach=1.2e-4), rolling, MU, coupling="full")
    gradient = found.gradient("force")
    assert "approach" in gradient
    assert "normal_force" not in gradient
    ends = [
        mtb.solve_tangential(sphere(30, 2.6e-4, approach=1.2e-4 + d), rolling, MU, coupling="full").force
        for d in (-step, step)
    ]
    assert gradient["approach"] == pytest.approx((ends[1] - ends[0]) / (2.0 * step), rel=1e-4, abs=1e2)
    assert all(np.isfinite(np.asarray(value)).all() for value in dict(gradient).values())
    with pytest.raises(ValueError, match="the approach is held, and the normal force is found"):
        found.derivative("force", "normal_force")
    by_force = mtb.solve_tangential(sphere(30, 2.6e-4, force=1000.0), rolling, MU, coupling="full")
    with pytest.raises(ValueError, match="the normal force is held, and the approach is found"):
        by_force.derivative("force", "approach")
