# SPDX-License-Identifier: MIT OR Apache-2.0
"""FASTSIM and FaStrip, KPEC and ANALYN against figures of CONTACT, limits and symmetries."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import mtb_rs as mtb

DATA = Path(__file__).parents[1] / "data" / "contact"
BODY = mtb.Material.from_shear_modulus(82e9, 0.28)
MU = mtb.Coulomb(0.3)
A, B, LOAD = 8e-3, 4e-3, 82e3
#: N, what friction carries
LIMIT = 0.3 * LOAD


def ellipse(n: int = 40, a: float = A, b: float = B) -> mtb.PressureField:
    """Hertz' pressure at the centres of n x n cells over the ellipse."""
    spacing = (2.0 * a / n, 2.0 * b / n)
    place = (np.arange(n) + 0.5) * 2.0 / n - 1.0
    x, y = np.meshgrid(place, place)
    pressure = 1.5 * LOAD / (np.pi * a * b) * np.sqrt(np.maximum(0.0, 1.0 - x**2 - y**2))
    return mtb.PressureField(pressure, spacing, BODY, BODY)


ROWS = np.genfromtxt(DATA / "fast_methods.csv", delimiter=",", names=True, dtype=None, encoding="utf-8")
FIELDS = np.load(DATA / "fast_methods.npz")


def of_contact(method: str) -> tuple[np.ndarray, np.ndarray, Any, Any]:
    """Creepages and forces on the lower body in our signs and units, cells that stick, and the slope."""
    rows = ROWS[ROWS["method"] == method]
    creepages = np.stack([rows["cksi"], rows["ceta"], 1e3 * rows["cphi_rad_per_mm"]], axis=1)
    forces = -np.stack([rows["Fx_N"], rows["Fy_N"], 1e-3 * rows["Mz_Nmm"]], axis=1)
    slope = tuple(float(rows[0][k]) for k in ("k0", "alpha", "beta"))
    return creepages, forces, rows["nadh"], slope


def relative(found: np.ndarray, exact: np.ndarray) -> float:
    return float(np.linalg.norm(found - exact) / np.linalg.norm(exact))


# CONTACT takes the load, 82 000 N, where we take the sum over the cells, 82 062 N: 8e-4 of what friction
# carries, in the scale of the parabolic bound and in the steepness of strip theory; the elliptic bound is
# that of each cell in both
@pytest.mark.parametrize(
    ("name", "run", "allowed"),
    [
        ("fastsim_ell", lambda p, c, s: mtb.fastsim(p, c, MU, "elliptic", "blended", semi_axes=(A, B)), 3e-5),
        (
            "fastsim_par",
            lambda p, c, s: mtb.fastsim(p, c, MU, "parabolic", "blended", semi_axes=(A, B)),
            1e-3,
        ),
        (
            "modified",
            lambda p, c, s: mtb.fastsim(
                p, c, MU, flexibilities="blended", semi_axes=(A, B), slope_reduction=s
            ),
            1e-3,
        ),
        ("fastrip", lambda p, c, s: mtb.fastrip(p, c, MU, semi_axes=(A, B), stick_direction="CONTACT"), 1e-3),
        (
            "modified_fastrip",
            lambda p, c, s: mtb.fastrip(
                p, c, MU, semi_axes=(A, B), stick_direction="CONTACT", slope_reduction=s
            ),
            1e-3,
        ),
    ],
)
def test_forces_of_contact(name: str, run: Any, allowed: float) -> None:
    creepages, forces, stick, slope = of_contact(name)
    patch = ellipse()
    for row, force, sticking in zip(creepages, forces, stick, strict=True):
        found = run(patch, tuple(row), slope)
        assert np.abs(found.force[:2] - force[:2]).max() < allowed * LIMIT, row
        # printed to four digits
        assert abs(found.spin_moment - force[2]) < allowed * LIMIT * B + 5e-4 * abs(force[2]), row
        assert abs(np.count_nonzero(found.status == 1) - sticking) <= (0 if allowed < 1e-4 else 8), row


def test_traction_of_fastrip_meets_contact_cell_by_cell() -> None:
    found = mtb.fastrip(ellipse(), (0.0, -6e-4, 0.6), MU, semi_axes=(A, B), stick_direction="CONTACT")
    assert np.array_equal(found.status, FIELDS["fastrip_1_status"])
    exact = -1e6 * np.stack([FIELDS["fastrip_1_px"], FIELDS["fastrip_1_py"]])
    # the steepness by the sum over the cells: 8e-4
    assert relative(found.traction[:2], exact) < 1e-3


def test_the_direction_of_strip_theory_is_nearer_to_the_full_solution() -> None:
    creepages, forces, _, _ = of_contact("full")
    patch = ellipse()
    own = mtb.fastrip_curve(patch, creepages, MU)
    like_contact = mtb.fastrip_curve(patch, creepages, MU, stick_direction="CONTACT")
    # with spin, and not all of the contact slips
    for k in (1, 2):
        errors = [relative(found[k, :2], forces[k, :2]) for found in (own, like_contact)]
        assert errors[0] < 0.02 < 0.05 < errors[1]
    # without spin, and where all slips, nothing is left of it but the cut at the bound
    assert np.allclose(own[[0, 3, 4]], like_contact[[0, 3, 4]], rtol=0.0, atol=1e-3 * LIMIT)


GAP_SPACING = 0.3e-3


def gap_of_contact() -> np.ndarray:
    x = 0.3 * (np.arange(35) - 17)
    y = 0.3 * (np.arange(47) - 23)[:, None]
    return np.asarray(1e-3 * (x**2 / 920 + 6e-4 * y**2 + 4e-5 * np.maximum(y, 0.0) ** 3))


@pytest.mark.parametrize(
    ("method", "peak", "force"), [("kpec", 606.703, 29984.72), ("analyn", 607.548, 30052.20)]
)
def test_pressure_of_contact_by_interpenetration(method: Any, peak: float, force: float) -> None:
    found = mtb.solve_normal(
        gap_of_contact(), GAP_SPACING, lower=BODY, upper=BODY, approach=0.04041e-3, method=method
    )
    exact = 1e6 * FIELDS[f"nonhertzian_{method}_pn"].astype(float)
    ny, nx = exact.shape
    # CONTACT's first cell is at (-4.2, -6.3) mm
    own = found.pressure[2 : 2 + ny, 3 : 3 + nx]
    assert np.abs(own - exact).max() < 2e4  # of 607 MPa, printed to six digits
    assert np.array_equal(own > 0.0, exact > 0.0)
    assert found.pressure.max() == pytest.approx(1e6 * peak, rel=1e-5)
    assert found.normal_force == pytest.approx(force, rel=1e-6)
    # and back from the force
    by_force = mtb.solve_normal(
        gap_of_contact(), GAP_SPACING, lower=BODY, upper=BODY, force=found.normal_force, method=method
    )
    assert by_force.approach == pytest.approx(found.approach, rel=1e-8)
    # known errors against the solved contact, as CONTACT has them: 4 to 7 % of the pressure
    solved = mtb.solve_normal(gap_of_contact(), GAP_SPACING, lower=BODY, upper=BODY, force=3e4)
    assert 0.01 < relative(found.pressure, solved.pressure) < 0.08
    assert 0.0 < found.report.residual < 0.2
    assert found.report.status == "approximate"
    rolled = mtb.solve_tangential(found, mtb.Rolling(creepage=(-1e-3, 5e-4, 0.2)), MU)
    assert rolled.force[0] < 0.0


@pytest.mark.parametrize("method", ["kpec", "analyn"])
@pytest.mark.parametrize("radii", [(0.46, 0.3), (0.3, 0.46), (0.4, 0.4), (0.5, 0.08)])
def test_interpenetration_of_quadratic_gaps_is_hertz(method: Any, radii: tuple[float, float]) -> None:
    exact = mtb.hertz(1e4, radii, BODY, BODY)
    errors = []
    for n in (24, 48):
        shape = (n + 1, n + 1)
        spacing = tuple(2.6 * axis / n for axis in exact.semi_axes)
        grid = exact.on_grid(shape, spacing)
        found = mtb.solve_normal(
            grid.initial_gap, spacing, lower=BODY, upper=BODY, approach=exact.approach, method=method
        )
        errors.append(
            (relative(found.pressure, exact.pressure(*grid.points[:2])), found.normal_force / 1e4 - 1)
        )
    # ANALYN is exact at each cell; KPEC finds the ends of its strips by straight lines, second order
    limit = (2e-3, 2e-2) if method == "analyn" else (1e-2, 2e-2)
    assert errors[1][0] < limit[0]
    assert abs(errors[1][1]) < limit[1]
    assert errors[1][0] < 0.6 * errors[0][0] or errors[1][0] < 1e-6


def test_small_creepages_give_kalkers_linear_forces() -> None:
    c = mtb.kalker_coefficients(A / B, 0.28)
    scale = 82e9 * A * B
    size = 1e-7
    rows = [(size, 0.0, 0.0), (0.0, size, 0.0), (0.0, 0.0, size / A)]
    exact = [scale * c.C11 * size, scale * c.C22 * size, scale * np.sqrt(A * B) * c.C23 * size / A]
    errors = []
    for n in (20, 40, 80):
        f = mtb.fastrip_curve(ellipse(n), rows, MU, semi_axes=(A, B))
        errors.append(np.abs([f[0, 0] / exact[0], f[1, 1] / exact[1], f[2, 1] / exact[2]] - np.ones(3)).max())
    # what sticks to the trailing edge is singular there: order one half in the cells
    assert errors[2] < 0.05
    assert 0.4 < np.log2(errors[0] / errors[2]) / 2.0 < 0.7


@pytest.mark.parametrize("run", [mtb.fastsim_curve, mtb.fastrip_curve])
def test_large_creepages_slide(run: Any) -> None:
    patch = ellipse()
    forces = run(patch, [(0.3, 0.4, 0.0), (-0.5, 0.0, 0.0)], MU)
    carried = 0.3 * patch.normal_force
    assert np.allclose(forces[:, :2], carried * np.array([[0.6, 0.8], [-1.0, 0.0]]), atol=2e-3 * carried)
    # spin alone: no force along x, and the moment of what slides around the middle
    spun = run(patch, [(0.0, 0.0, 50.0)], MU)[0]
    x, y = np.meshgrid(*patch.coordinates())
    torque = 0.3 * float((np.hypot(x, y) * patch.pressure).sum()) * patch.spacing[0] * patch.spacing[1]
    assert abs(spun[0]) < 1e-9 * carried
    assert spun[2] == pytest.approx(torque, rel=0.1)


def test_fastrip_stays_below_its_bound() -> None:
    patch = ellipse()
    for row in ((4e-4, 2e-4, 0.3), (0.0, 0.0, 0.5), (1e-3, -5e-4, -0.6), (0.0, 6e-4, 0.9)):
        found = mtb.fastrip(patch, row, MU)
        size = np.hypot(*found.traction[:2])
        assert np.all(size <= 0.3 * patch.pressure * (1.0 + 1e-12))
        slips = found.status == 2
        assert np.allclose(size[slips], 0.3 * patch.pressure[slips])


def turned(field: mtb.PressureField) -> mtb.PressureField:
    """By a quarter, from +x to +y."""
    return mtb.PressureField(np.rot90(field.pressure, -1).copy(), field.spacing[::-1], BODY, BODY)


def egg(n: int = 30) -> mtb.PressureField:
    """A patch without any symmetry but that of its rows."""
    x, y = np.meshgrid((np.arange(n) + 0.5) * 2.0 / n - 1.0, (np.arange(n + 4) + 0.5) * 2.0 / n - 1.1)
    height = np.maximum(0.0, 1.0 - x**2 * (1.0 + 0.3 * y) - 0.9 * (y + 0.2 * x) ** 2)
    return mtb.PressureField(6e8 * np.sqrt(height), (0.25e-3, 0.35e-3), BODY, BODY)


ROLLED = [
    pytest.param(lambda p, c, **v: mtb.fastsim(p, c, MU, **v), id="fastsim"),
    pytest.param(lambda p, c, **v: mtb.fastsim(p, c, MU, order=2, **v), id="second order"),
    pytest.param(lambda p, c, **v: mtb.fastsim(p, c, MU, flexibilities="blended", **v), id="blended"),
    pytest.param(lambda p, c, **v: mtb.fastrip(p, c, MU, **v), id="fastrip"),
]


@pytest.mark.parametrize("roll", ROLLED)
def test_a_turned_contact_has_turned_forces(roll: Any) -> None:
    patch, creepage = egg(), (7e-4, -4e-4, 0.35)
    straight = roll(patch, creepage)
    quarter = roll(turned(patch), (4e-4, 7e-4, 0.35), angle=np.pi / 2)
    force = straight.force
    assert np.allclose(quarter.force[:2], [-force[1], force[0]], rtol=1e-9, atol=1e-9 * abs(force[2]))
    assert quarter.spin_moment == pytest.approx(straight.spin_moment, rel=1e-9)
    assert np.array_equal(np.rot90(straight.status, -1), quarter.status)
    back = mtb.PressureField(patch.pressure[::-1, ::-1].copy(), patch.spacing, BODY, BODY)
    half = roll(back, (-7e-4, 4e-4, 0.35), angle=np.pi)
    assert np.allclose(half.force[:2], -force[:2], rtol=1e-9, atol=1e-9 * abs(force[2]))


@pytest.mark.parametrize("roll", ROLLED)
def test_rolling_across_the_cells_tends_to_the_same(roll: Any) -> None:
    # a round contact: the direction does not matter
    creepage, angle = np.array([5e-4, 3e-4, 0.2]), 0.6
    c, s = np.cos(angle), np.sin(angle)
    across = (c * creepage[0] - s * creepage[1], s * creepage[0] + c * creepage[1], creepage[2])
    errors = []
    for n in (20, 80):
        patch = ellipse(n, 5e-3, 5e-3)
        straight = roll(patch, tuple(creepage), semi_axes=(5e-3, 5e-3)).force[:2]
        found = roll(patch, across, angle=angle, semi_axes=(5e-3, 5e-3)).force[:2]
        exact = [c * straight[0] - s * straight[1], s * straight[0] + c * straight[1]]
        errors.append(relative(found, np.array(exact)))
    assert errors[1] < 0.01
    assert errors[1] < 0.5 * errors[0]


@pytest.mark.parametrize("roll", ROLLED)
@given(
    xi=st.floats(-2e-3, 2e-3),
    eta=st.floats(-2e-3, 2e-3),
    phi=st.floats(-0.6, 0.6),
    larger=st.floats(0.1, 10.0),
)
@settings(max_examples=15, deadline=None)
def test_mirror_and_scale(roll: Any, xi: float, eta: float, phi: float, larger: float) -> None:
    patch = egg(16)
    found = roll(patch, (xi, eta, phi))
    mirror = mtb.PressureField(patch.pressure[::-1].copy(), patch.spacing, BODY, BODY)
    image = roll(mirror, (xi, -eta, -phi))
    tiny = 1e-9 * patch.normal_force
    assert np.allclose(image.force[:2], found.force[:2] * [1.0, -1.0], atol=tiny)
    assert np.allclose(image.spin_moment, -found.spin_moment, atol=tiny)
    # similar bodies under the same pressure: forces grow with the area, spin falls with the size
    size = (larger * patch.spacing[0], larger * patch.spacing[1])
    grown = roll(mtb.PressureField(patch.pressure, size, BODY, BODY), (xi, eta, phi / larger))
    assert np.allclose(
        grown.force, larger**2 * found.force, rtol=1e-6, atol=1e-6 * larger**2 * patch.normal_force
    )


@pytest.mark.filterwarnings("ignore:a contact lies oblique")
@pytest.mark.parametrize("roll", ROLLED)
@pytest.mark.parametrize("angle", [0.0, 0.7])
def test_creepages_are_found_for_forces(roll: Any, angle: float) -> None:
    patch = egg()
    for creepage in ((6e-4, -3e-4, 0.2), (3e-4, 1e-3, -0.3)):
        known = roll(patch, creepage, angle=angle)
        found = roll(patch, (0.0, 0.0, creepage[2]), angle=angle, force=tuple(known.force[:2]))
        assert np.allclose(found.creepage, creepage, rtol=1e-4, atol=1e-8)
        assert np.allclose(found.force, known.force, atol=1e-8 * patch.normal_force)
        one = roll(patch, (0.0, *creepage[1:]), angle=angle, force=(float(known.force[0]), None))
        assert np.allclose(one.creepage, creepage, rtol=1e-4, atol=1e-8)


def test_blended_flexibilities_end_in_the_direction_of_the_rigid_slip() -> None:
    # three flexibilities slide in a direction of their own, one does not
    patch = ellipse()
    rows = [(0.05, 0.05, 0.0)]
    along = [np.divide(*mtb.fastsim_curve(patch, rows, MU, flexibilities=f)[0, :2]) for f in (3, "blended")]
    assert along[1] == pytest.approx(1.0, abs=1e-3)
    assert abs(along[0] - 1.0) < 0.1


def test_a_table_takes_patches_of_any_shape() -> None:
    table = mtb.CreepForceTable.build((1.4, 2.0), 0.28, nodes=9, cells=16)
    rows = [(3e-4, 2e-4, 0.1), (1e-3, -5e-4, 0.2)]
    patch = ellipse(24)
    by_axes = table.interpolate(patch.semi_axes(), patch.normal_force, 82e9, 0.3, rows)
    assert np.allclose(table.creep_forces(patch, rows, MU), by_axes, rtol=1e-12)
    # two such contacts beside each other: creepages about the centre of each
    apart = 30
    two = np.zeros((24, 48 + apart))
    two[:, :24] = two[:, -24:] = patch.pressure
    pair = mtb.PressureField(two, patch.spacing, BODY, BODY)
    found = table.creep_forces(pair, [(3e-4, 2e-4, 0.1)], MU)[0]
    x = 0.5 * (24 + apart) * patch.spacing[0]
    own = [
        table.interpolate(patch.semi_axes(), patch.normal_force, 82e9, 0.3, [(3e-4, 2e-4 + 0.1 * at, 0.1)])[0]
        for at in (-x, x)
    ]
    assert np.allclose(found[:2], own[0][:2] + own[1][:2], rtol=1e-9)
    assert found[2] == pytest.approx(own[0][2] + own[1][2] + x * (own[1][1] - own[0][1]), rel=1e-9)
    with pytest.raises(ValueError, match=r"ratios from 1\.4 to 2"):
        table.creep_forces(ellipse(24, 4e-3, 8e-3), rows, MU)
    soft = mtb.Material.from_shear_modulus(82e9, 0.4)
    between = mtb.PressureField(patch.pressure, patch.spacing, soft, soft)
    with pytest.raises(ValueError, match=r"Poisson's ratio 0\.4"):
        table.creep_forces(between, rows, MU)


def test_a_table_gives_no_more_than_coulombs_friction() -> None:
    table, load = mtb.CreepForceTable.build((1.0,), 0.28, nodes=5, cells=8), 60e3
    rng = np.random.default_rng(1)
    angle, size = rng.uniform(0.0, 2.0 * np.pi, 2000), 10.0 ** rng.uniform(-5.0, 0.0, 2000)
    spin = 10.0 ** rng.uniform(-3.0, 1.0, 2000)
    rows = np.stack([size * np.cos(angle), size * np.sin(angle), spin], axis=1)
    forces = table.interpolate((6e-3, 6e-3), load, 80e9, 0.3, rows)
    assert np.hypot(forces[:, 0], forces[:, 1]).max() <= 0.3 * load * (1.0 + 1e-12)
