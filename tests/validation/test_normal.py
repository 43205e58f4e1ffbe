# SPDX-License-Identifier: MIT OR Apache-2.0
"""Frictionless contact on regular grids against closed forms, the dense solver and CONTACT's fields."""

from __future__ import annotations

import gzip
import itertools
import json
import math
import pickle
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import mtb_rs as mtb
from mtb_rs.half_space import reference, rough

DATA = Path(__file__).parents[1] / "data" / "contact"
MM, MPA = 1e-3, 1e6
STEEL = mtb.steel
#: steel of the reference runs
WHEEL = mtb.Material.from_shear_modulus(82e9, 0.28)

Array = NDArray[np.float64]


def relative(a: Array, b: Array) -> float:
    return float(np.linalg.norm(a - b) / np.linalg.norm(b))


def rate(errors: list[float]) -> float:
    """Mean order of errors on grids halved each time."""
    return math.log2(errors[0] / errors[-1]) / (len(errors) - 1)


def bowl(n: int, size: float, radius: float = 0.5) -> Array:
    x = ((np.arange(n) + 0.5) / n - 0.5) * size
    return np.asarray((x[None, :] ** 2 + x[:, None] ** 2) / (2.0 * radius))


@pytest.mark.parametrize("axes", [(2e-3, 2e-3), (3e-3, 1e-3), (1e-3, 5e-3)])
def test_hertz_rates(axes: tuple[float, float]) -> None:
    exact = mtb.hertz(1e4, semi_axes=axes, lower=STEEL, upper=mtb.Material(70e9, 0.33))
    away, approach, peak, gap, estimates = [], [], [], [], []
    for n in (32, 64, 128, 256):
        spacing = (2.4 * axes[0] / n, 2.4 * axes[1] / n)
        field = exact.on_grid((n, n), spacing)
        found = mtb.solve_normal(
            field.initial_gap, spacing, lower=exact.lower, upper=exact.upper, force=1e4, tolerance=1e-9
        )
        assert found.normal_force == pytest.approx(1e4, rel=1e-13)
        inside = np.hypot(field.points[0] / axes[0], field.points[1] / axes[1]) < 0.85
        pressure = exact.pressure(field.points[0], field.points[1])
        away.append(relative(found.pressure[inside], pressure[inside]))
        approach.append(abs(found.approach / exact.approach - 1.0))
        peak.append(abs(found.pressure.max() / exact.peak_pressure - 1.0))
        gap.append(float(np.abs(found.gap - field.gap).max() / exact.approach))
        estimates.append(found.error_estimate)
        if n == 256:
            assert found.contact_area == pytest.approx(exact.contact_area, rel=3e-3)
    # the border is met to a cell: first order for its neighbours, more away from it and in the mean
    assert rate(away) > 1.4
    assert away[-1] < 1e-4
    assert rate(approach) > 1.5
    assert approach[-1] < 6e-6
    assert rate(gap) > 1.0
    assert gap[-1] < 3e-4
    assert peak[-1] < 3e-5
    for estimate, error in zip(estimates[1:], away[1:], strict=True):
        assert estimate is not None
        assert 0.3 * error < estimate < 20.0 * error


def test_hertz_closed_form() -> None:
    # [Johnson1985, ch. 4]: circle in elementary functions
    radius, force = 0.4, 2e3
    modulus = 0.5 * STEEL.plane_strain_modulus
    circle = mtb.hertz(force, radius, lower=STEEL, upper=STEEL)
    a = (0.75 * force * radius / modulus) ** (1.0 / 3.0)
    assert circle.semi_axes == pytest.approx((a, a), rel=1e-13)
    assert circle.approach == pytest.approx(a * a / radius, rel=1e-13)
    assert circle.peak_pressure == pytest.approx(1.5 * force / (math.pi * a * a), rel=1e-13)
    # a rigid partner doubles the modulus
    rigid = mtb.hertz(force, radius, lower=mtb.Rigid(), upper=STEEL)
    assert rigid.approach == pytest.approx(circle.approach / 2.0 ** (2.0 / 3.0), rel=1e-13)
    for radii in [(0.5, 0.5000001), (0.5, 0.6), (3.0, 0.2), (1e-2, 10.0)]:
        ellipse = mtb.hertz(force, radii, lower=STEEL, upper=STEEL)
        assert ellipse.curvatures == pytest.approx((1.0 / radii[0], 1.0 / radii[1]), rel=1e-9)
        back = mtb.hertz(force, semi_axes=ellipse.semi_axes, lower=STEEL, upper=STEEL)
        assert back.approach == pytest.approx(ellipse.approach, rel=1e-9)
    # outside of the circle: Sneddon's form of the displacement [Johnson1985, eq. 3.42a]
    r = np.array([1.0, 1.2, 3.0, 40.0]) * a
    inside = (2.0 * a * a - r**2) * np.arcsin(a / r) + r * a * np.sqrt(1.0 - (a / r) ** 2)
    displacement = circle.peak_pressure / (2.0 * modulus * a) * inside
    expected = r**2 / (2.0 * radius) + displacement - circle.approach
    assert circle.separation(r, 0.0 * r) == pytest.approx(expected, rel=1e-9, abs=1e-12 * circle.approach)


@pytest.mark.coarse
def test_dense_and_fourier_give_the_same_pressures() -> None:
    rng = np.random.default_rng(3)
    gap = bowl(40, 4e-3)[:34] + 2e-7 * rng.standard_normal((34, 40))
    spacing = (1e-4, 1.2e-4)
    for load in (
        {"force": 500.0},
        {"force": 900.0, "moments_about_axes": (0.1, 0.05)},
        {"approach": 8e-6},
        {"approach": 8e-6, "moments_about_axes": (0.03, 0.02)},
    ):
        fields = [
            mtb.solve_normal(
                gap, spacing, lower=STEEL, upper=STEEL, tolerance=1e-11, method=method, edge="sharp", **load
            )
            for method in ("dense", "fft")
        ]
        assert [f.report.solver for f in fields] == ["active set, dense LU", "conjugate gradients, FFT"]
        dense, fast = (f.pressure for f in fields)
        assert np.abs(dense - fast).max() < 1e-8 * dense.max()
        assert fields[0].approach == pytest.approx(fields[1].approach, rel=1e-9)
        assert fields[0].tilts == pytest.approx(fields[1].tilts, rel=1e-7, abs=1e-13)


@pytest.mark.coarse
def test_what_the_fourier_method_does_not_solve_is_solved_by_the_dense_one() -> None:
    nx, ny, dx, dy = 200, 9, 1e-4, 1e-4 / 5.3
    x, y = np.meshgrid(np.arange(nx) - (nx - 1) / 2, np.arange(ny) - (ny - 1) / 2)
    gap = 1e-5 * np.sin(x / 8.0) * np.cos(y / 3.0)
    load: dict[str, Any] = {
        "force": 20.0,
        "moments_about_axes": (-20.0 * 0.23 * ny * dy / 2, 20.0 * 0.82 * nx * dx / 2),
    }
    both: dict[str, Any] = {"lower": mtb.steel, "upper": mtb.steel, "edge": "sharp", **load}
    with pytest.raises(mtb.ConvergenceError):
        mtb.solve_normal(gap, (dx, dy), method="fft", **both)
    result = mtb.solve_normal(gap, (dx, dy), **both)
    assert result.report.solver.startswith("active set")
    assert result.report.residual < 1e-8
    moment = (result.pressure * x).sum() * dx * dx * dy
    assert moment == pytest.approx(load["moments_about_axes"][1], rel=1e-8)


def test_conditions_of_contact_hold() -> None:
    gap = bowl(64, 5e-3)
    found = mtb.solve_normal(gap, 5e-3 / 64, lower=STEEL, upper=STEEL, force=2e3, tolerance=1e-10)
    assert found.pressure.min() == 0.0
    touching = found.pressure > 0.0
    assert np.array_equal(touching, found.status == 1)
    assert np.abs(found.gap[touching]).max() < 1e-8 * found.approach
    assert found.gap[~touching].min() > 0.0
    assert found.points[:2].mean(axis=(1, 2)) == pytest.approx([0.0, 0.0], abs=1e-18)
    assert found.report.residual <= 1e-10
    again = pickle.loads(pickle.dumps(found))
    assert np.array_equal(again.pressure, found.pressure)
    assert again.report == found.report


def test_flat_punch() -> None:
    exact = reference.FlatPunch(2e-3, 1e3, STEEL, STEEL)
    approach = []
    for n in (32, 64, 128):
        x = ((np.arange(n) + 0.5) / n - 0.5) * 4.4e-3
        r = np.hypot(x[None, :], x[:, None])
        gap = np.where(r <= 2e-3, 0.0, 1.0)
        found = mtb.solve_normal(gap, 4.4e-3 / n, lower=STEEL, upper=STEEL, force=1e3, tolerance=1e-9)
        approach.append(abs(found.approach / exact.approach - 1.0))
        inner = r < 1e-3
        assert found.pressure[inner] == pytest.approx(exact.pressure(r[inner]), rel=0.1 * 32 / n)
    assert approach[-1] < 0.01


def test_square_punch_with_free_tilts() -> None:
    # a plane gap is a punch: contact up to the sides of the grid; a tilted plane is levelled by free tilts
    n, side = 48, 1e-2
    x = (np.arange(n) + 0.5) / n * side - 0.5 * side
    level = mtb.solve_normal(np.zeros((n, n)), side / n, lower=STEEL, upper=mtb.Rigid(), force=1e4)
    slope = (2e-4, -1e-4)
    gap = 1e-5 + slope[0] * x[None, :] + slope[1] * x[:, None]
    tilted = mtb.solve_normal(
        gap,
        side / n,
        lower=STEEL,
        upper=mtb.Rigid(),
        force=1e4,
        moments_about_axes=(0.0, 0.0),
        tolerance=1e-11,
    )
    assert tilted.tilts == pytest.approx(slope, rel=1e-6)
    assert tilted.approach == pytest.approx(1e-5 + level.approach, rel=1e-6)
    assert relative(tilted.pressure, level.pressure) < 1e-3
    # a resultant off the middle: the prescribed moments are met
    moments = (12.0, -7.0)
    pair = {"lower": STEEL, "upper": STEEL, "force": 1e4, "tolerance": 1e-10}
    off = mtb.solve_normal(np.zeros((n, n)), side / n, moments_about_axes=(7.0, 12.0), **pair)
    found = [float((off.pressure * off.points[k] * off.area).sum()) for k in (0, 1)]
    assert found == pytest.approx(moments, rel=1e-9)
    with pytest.warns(DeprecationWarning, match=r"moments_about_axes=\(-b, a\)"):
        before = mtb.solve_normal(np.zeros((n, n)), side / n, moments=moments, **pair)
    assert np.array_equal(before.pressure, off.pressure)
    with pytest.raises(TypeError, match="both moments_about_axes and moments"):
        mtb.solve_normal(np.zeros((n, n)), side / n, moments=moments, moments_about_axes=(7.0, 12.0), **pair)


@pytest.mark.coarse
def test_moments_mean_the_same_in_a_scene() -> None:
    x = (np.arange(30) - 14.5) * 1e-3
    bowl = (x[None, :] ** 2 + 2.0 * x[:, None] ** 2) / (2.0 * 10.0)
    moments = (0.3, -0.5)
    load = {"lower": STEEL, "upper": mtb.Rigid(), "force": 1e3}
    field = mtb.solve_normal(bowl, 1e-3, moments_about_axes=moments, tolerance=1e-10, **load)
    scene = mtb.Scene(gap=bowl, spacing=1e-3, friction=0.0, moments=moments, **load)
    assert relative(scene.solve().pressure, field.pressure) < 1e-6
    # the load acts at x = my / F, y = -mx / F
    at = [float((field.pressure * field.points[k] * field.area).sum()) / 1e3 for k in (0, 1)]
    assert at == pytest.approx((-0.5e-3, -0.3e-3), rel=1e-6)


@pytest.mark.parametrize(("given", "at"), [((60.0, 0.0), 0), ((None, -60.0), 1)])
def test_a_moment_beyond_the_grid_is_named_by_its_axis(
    given: tuple[float | None, float | None], at: int
) -> None:
    pair = {"lower": STEEL, "upper": STEEL, "force": 1e4}
    with pytest.raises(ValueError, match=rf"moments_about_axes\[{at}\] is {given[at]:g} N m"):
        mtb.solve_normal(np.zeros((12, 12)), 1e-3, moments_about_axes=given, **pair)
    first = (given[1], None if given[0] is None else -given[0])
    with (
        pytest.warns(DeprecationWarning, match="moments_about_axes"),
        pytest.raises(ValueError, match=rf"moments\[{1 - at}\] is "),
    ):
        mtb.solve_normal(np.zeros((12, 12)), 1e-3, moments=first, **pair)


def test_wavy_surface_follows_westergaard() -> None:
    exact = reference.WavyContact(1e-6, 1e-3, 20e6, STEEL, STEEL)
    errors = []
    for n in (64, 128, 256):
        x = ((np.arange(n) + 0.5) / n - 0.5) * 1e-3
        gap = np.tile(1e-6 * (1.0 - np.cos(2.0 * math.pi * x / 1e-3)), (4, 1))
        found = mtb.solve_normal(
            gap, 1e-3 / n, lower=STEEL, upper=STEEL, force=20e6 * 4e-3 / n * 1e-3, periodic=True
        )
        errors.append(relative(found.pressure[0], exact.pressure(x)))
    assert rate(errors) > 0.7
    assert errors[-1] < 0.02
    full = reference.WavyContact(1e-6, 1e-3, 1.3 * exact.full_contact_pressure, STEEL, STEEL)
    force = full.mean_pressure * 4e-3 / n * 1e-3
    flat = mtb.solve_normal(gap, 1e-3 / n, lower=STEEL, upper=STEEL, force=force, periodic=True)
    assert relative(flat.pressure[0], full.pressure(x)) < 1e-9


def test_sphere_of_contact() -> None:
    table = np.genfromtxt(DATA / "normal_sphere_41x41.csv", delimiter=",", names=True)
    gap = table["h"].reshape(41, 41) * MM
    found = mtb.solve_normal(gap, 0.18 * MM, lower=WHEEL, upper=WHEEL, force=1e4, tolerance=1e-9)
    expected = table["pn"].reshape(41, 41) * MPA
    assert relative(found.pressure, expected) < 1e-5  # six digits are printed
    assert np.array_equal(found.status > 0, table["igs"].reshape(41, 41) > 0)
    assert found.approach == pytest.approx(0.0205444 * MM, rel=1e-5)


def test_refinement_of_contact() -> None:
    cells = {"sphere": (1.0, 7.38, 7.38), "ellipse": (2.8427, 8.61, 4.305)}
    with (DATA / "normal_refinement.csv").open() as file:
        names = file.readline().strip().split(",")
        rows = [dict(zip(names, line.strip().split(","), strict=True)) for line in file]
    for row in rows:
        n = int(row["n"])
        dx, dy = float(row["dx"]) * MM, float(row["dy"]) * MM
        factor, *size = cells[row["case"]]
        assert (n * dx, n * dy) == pytest.approx((size[0] * MM, size[1] * MM), rel=1e-4)
        x, y = ((np.arange(n) - 0.5 * (n - 1)) * d for d in (dx, dy))
        gap = x[None, :] ** 2 + factor * y[:, None] ** 2
        found = mtb.solve_normal(gap, (dx, dy), lower=WHEEL, upper=WHEEL, force=1e4, tolerance=1e-8)
        assert found.pressure.max() == pytest.approx(float(row["pmax"]) * MPA, rel=2e-5)
        assert found.approach == pytest.approx(float(row["approach"]) * MM, rel=2e-6)
        assert int(found.status.sum()) == pytest.approx(int(row["ncon"]), rel=1e-3)


@pytest.mark.parametrize("spacing", ["0.1", "0.05", "0.025"])
def test_wheel_on_rail_of_contact(spacing: str) -> None:
    with gzip.open(DATA / f"s1002_uic60_y6.2_gap_dx{spacing}.csv.gz", "rt") as file:
        file.readline()
        gap = np.loadtxt(file, delimiter=",") * MM
    side = float(spacing) * MM
    with (DATA / "table1_like.csv").open() as file:
        names = file.readline().strip().split(",")
        rows = [dict(zip(names, line.strip().split(","), strict=True)) for line in file]
    mine = [row for row in rows if row["dx_mm"] == spacing]
    by_force = mtb.solve_normal(gap, side, lower=WHEEL, upper=WHEEL, force=39206.8)
    approach = float(mine[2]["approach_mm"]) * MM
    by_approach = mtb.solve_normal(gap, side, lower=WHEEL, upper=WHEEL, approach=approach)
    for found, row in ((by_force, mine[1]), (by_approach, mine[2])):
        assert found.pressure.max() == pytest.approx(float(row["pmax_MPa"]) * MPA, rel=1e-4)
        assert found.contact_area == pytest.approx(float(row["area_mm2"]) * MM**2, rel=2e-3)
        assert found.approach == pytest.approx(float(row["approach_mm"]) * MM, rel=1e-5)
        assert found.normal_force == pytest.approx(float(row["Fn_N"]), rel=1e-5)
    if spacing == "0.1":
        with gzip.open(DATA / f"s1002_uic60_y6.2_pn_dx{spacing}_N1.csv.gz", "rt") as file:
            table = np.genfromtxt(file, delimiter=",", names=True)
        expected = table["pn"].reshape(gap.shape) * MPA
        assert relative(by_force.pressure, expected) < 1e-4


@pytest.mark.parametrize("case", ["norm_problm_1p", "norm_problm_2p", "norm_problm_4p"])
def test_measured_profile_of_contact(case: str) -> None:
    table = json.loads((DATA / "paper_table_1.json").read_text(encoding="utf-8"))
    row = table["cases"][case]
    x, y = (row[low] + (np.arange(row[n]) + 0.5) * row["dx"] for low, n in (("xl", "nx"), ("yl", "ny")))
    z = np.interp(y, table["y0"] + table["dy"] * np.arange(len(table["z"])), table["z"])
    gap = (z[:, None] + x[None, :] ** 2 / (2.0 * table["radius"])) * MM
    pair = {"lower": WHEEL, "upper": WHEEL, "tolerance": 1e-8}
    found = mtb.solve_normal(gap, row["dx"] * MM, approach=row["approach"] * MM, **pair)
    assert int(found.status.sum()) == row["ncon"]
    # CONTACT iterates to 1e-6 and prints six digits
    assert found.pressure.max() == pytest.approx(row["pmax"] * MPA, rel=2e-5)
    assert found.normal_force == pytest.approx(row["FN"], rel=1e-5)
    by_force = mtb.solve_normal(gap, row["dx"] * MM, force=found.normal_force, **pair)
    assert by_force.approach == pytest.approx(found.approach, rel=1e-7)
    # jagged as it is, a measured profile takes no more work on finer cells, nor by force than by approach
    assert max(found.report.convolutions, by_force.report.convolutions) < 14.0


def test_work_does_not_grow_with_the_grid() -> None:
    for n in (32, 64, 128, 256):
        smooth = mtb.solve_normal(
            bowl(n, 4e-3), 4e-3 / n, lower=STEEL, upper=STEEL, force=1e3, tolerance=1e-8, method="fft"
        )
        flat = mtb.solve_normal(
            np.zeros((n, n)), 4e-3 / n, lower=STEEL, upper=STEEL, force=1e3, tolerance=1e-8, method="fft"
        )
        for found, limit in ((smooth, 20.0), (flat, 16.0)):
            assert found.report.convolutions < limit
            assert found.report.preconditionings < limit


def test_the_default_tolerance_follows_the_discretisation() -> None:
    exact = mtb.hertz(1e3, 0.5, lower=STEEL, upper=STEEL)
    for n in (64, 128, 256):
        gap, side = bowl(n, 4e-3), 4e-3 / n
        default = mtb.solve_normal(gap, side, lower=STEEL, upper=STEEL, force=1e3)
        sharp = mtb.solve_normal(gap, side, lower=STEEL, upper=STEEL, force=1e3, tolerance=1e-12)
        pressure = exact.pressure(sharp.points[0], sharp.points[1])
        # what the solver leaves is far below what the cells cost
        assert relative(default.pressure, sharp.pressure) < 0.1 * relative(sharp.pressure, pressure)
        assert default.report.iterations < sharp.report.iterations


GAPS = {
    "sphere aside": lambda x, y: (x - 0.3e-3) ** 2 + (y + 0.17e-3) ** 2,
    "ellipse": lambda x, y: 2.0 * x**2 + 0.3 * y**2,
    "two bumps": lambda x, y: np.minimum(3.0 * (x - 1e-3) ** 2, 1.5 * (x + 1e-3) ** 2 + 6e-7) + 2.0 * y**2,
    "cone": lambda x, y: 6e-3 * np.hypot(x, y),
    "step": lambda x, y: x**2 + y**2 + 1.2e-6 * (x > 0.2e-3),
    "rounded cylinder": lambda x, y: 30.0 * np.maximum(np.abs(x) - 0.7e-3, 0.0) ** 2 + 0.6 * y**2,
    "square punch": lambda x, y: 1e-3 * (np.maximum(np.abs(x), np.abs(y)) > 1.3e-3),
}


@pytest.mark.parametrize("name", GAPS)
# the edges of a punch are sharp
@pytest.mark.filterwarnings("ignore:the peak pressure is")
def test_the_estimated_error_is_honest(name: str) -> None:
    def solve(n: int) -> mtb.NormalResult:
        x = 4e-3 * ((np.arange(n) + 0.5) / n - 0.5)
        gap = GAPS[name](x[None, :], x[:, None]) / 0.6
        return mtb.solve_normal(gap, 4e-3 / n, lower=STEEL, upper=STEEL, force=3e3, edge="sharp")

    fine = solve(512).pressure
    for n in (64, 128):
        found = solve(n)
        exact = fine.reshape(n, 512 // n, n, 512 // n).mean(axis=(1, 3))
        inside = found.pressure > 0.0
        rows, columns = np.nonzero(inside)
        # without a rim a twentieth as wide as the contact
        for _ in range(2 + min(int(np.ptp(rows)), int(np.ptp(columns))) // 20):
            bare = np.pad(inside, 1)
            inside = inside & bare[2:, 1:-1] & bare[:-2, 1:-1] & bare[1:-1, 2:] & bare[1:-1, :-2]
        assert found.error_estimate is not None
        assert relative(found.pressure[inside], exact[inside]) < 2.0 * found.error_estimate


@pytest.mark.coarse
def test_single_cells_and_tiny_loads() -> None:
    for shape in ((1, 1), (1, 7), (5, 1), (20, 20)):
        gap = bowl(41, 4e-3)[20 - shape[0] // 2 :, 20 - shape[1] // 2 :][: shape[0], : shape[1]]
        found = mtb.solve_normal(
            gap, 1e-4, lower=STEEL, upper=STEEL, force=1e-9, edge="sharp", method="fft", tolerance=1e-10
        )
        assert int(found.status.sum()) == 1
        assert found.normal_force == pytest.approx(1e-9, rel=1e-13)
    open_gap = mtb.solve_normal(bowl(40, 4e-3), 1e-4, lower=STEEL, upper=STEEL, approach=-1e-6)
    assert open_gap.normal_force == 0.0
    assert open_gap.report.converged
    assert np.all(open_gap.gap > 0.0)


@pytest.mark.coarse
@pytest.mark.parametrize("force", [1e3, 10.0, 1e-2, 1e-5])
def test_the_approach_that_a_force_makes_makes_the_force(force: float) -> None:
    flat_topped = [(np.maximum(bowl(n, 20e-3, 0.05) - 1.6e-4, 0.0), 20e-3 / n) for n in (65, 97, 129)]
    rng = np.random.default_rng(0)
    white = [(1e-6 * rng.standard_normal((97, 101)), (1e-4, 1e-3)) for _ in range(4)]
    for gap, spacing in flat_topped + white:
        both: dict[str, Any] = {
            "lower": STEEL,
            "upper": STEEL,
            "edge": "sharp",
            "tolerance": 1e-9,
            "method": "fft",
        }
        by_force = mtb.solve_normal(gap, spacing, force=force, **both)
        by_approach = mtb.solve_normal(gap, spacing, approach=by_force.approach, **both)
        # the last digit of the approach is that of the gap: a white one carries the least force by a few
        digits = 1e-15 * np.abs(gap).max() / (by_force.approach - gap.min())
        assert by_approach.normal_force == pytest.approx(force, rel=1e-6 + digits)
        assert relative(by_approach.pressure, by_force.pressure) < 1e-6 + digits


@pytest.mark.coarse
@pytest.mark.parametrize("method", ["dense", "fft", "auto"])
@pytest.mark.parametrize("shape", [(1, 2), (7, 1), (5, 5), (13, 17), (1, 2000)])
def test_a_plane_gap_over_a_period_is_pressed_evenly(shape: tuple[int, int], method: Any) -> None:
    spacing = (1e-3, 2.5e-3)
    found = mtb.solve_normal(
        np.full(shape, 3e-6), spacing, lower=STEEL, upper=STEEL, force=7.0, periodic=True, method=method
    )
    assert found.report.converged
    mean = 7.0 / (shape[0] * shape[1] * spacing[0] * spacing[1])
    assert np.abs(found.pressure / mean - 1.0).max() < 1e-13
    assert found.approach == pytest.approx(3e-6, rel=1e-13)


def test_contact_beyond_the_grid_is_an_error_with_the_size_that_would_do() -> None:
    gap = bowl(40, 2e-3)
    with pytest.raises(ValueError, match=r"reaches the edge of the grid of 0\.002 x 0\.002 m"):
        mtb.solve_normal(gap, 5e-5, lower=STEEL, upper=STEEL, force=1e3)
    grown = mtb.solve_normal(gap, 5e-5, lower=STEEL, upper=STEEL, force=1e3, edge="grow")
    exact = mtb.hertz(1e3, 0.5, lower=STEEL, upper=STEEL)
    assert min(grown.pressure.shape) * 5e-5 > 2.0 * exact.semi_axes[0]
    assert grown.pressure.max() == pytest.approx(exact.peak_pressure, rel=1e-3)
    cut = mtb.solve_normal(gap, 5e-5, lower=STEEL, upper=STEEL, force=1e3, edge="sharp")
    assert cut.pressure[0].max() > 0.0


def test_rough_contact_grows_nearly_in_proportion_to_the_load() -> None:
    # [Johnson1985, ch. 13.4]: small contact areas grow with the load
    heights = mtb.roughness(128, 1e-6, rms_slope=0.05, roll_off=64e-6, shortest=8e-6, seed=2)
    assert np.array_equal(
        heights, mtb.roughness(128, 1e-6, rms_slope=0.05, roll_off=64e-6, shortest=8e-6, seed=2)
    )
    gap = heights.max() - heights
    nominal = (128e-6) ** 2
    modulus = 0.5 * STEEL.plane_strain_modulus
    loads = np.array([0.01, 0.02, 0.04]) * modulus * 0.05 * nominal
    curve = mtb.area_load_curve(gap, 1e-6, loads, lower=STEEL, upper=STEEL)
    slope = curve.contact_area / nominal / (loads / (modulus * 0.05 * nominal))
    # between the theories' sqrt(8 / pi) and sqrt(2 pi), raised by whole border cells
    assert np.all(slope > 1.3)
    assert np.all(slope < 3.5)
    growth = [math.log(b / a) / math.log(2.0) for a, b in itertools.pairwise(curve.contact_area)]
    assert all(0.8 < g < 1.02 for g in growth)
    assert np.all(np.diff(curve.mean_gap) < 0.0)


def test_roughness_has_the_statistics_asked_for() -> None:
    heights = mtb.roughness((256, 128), (1e-6, 2e-6), hurst=0.7, rms_height=3e-7, seed=5)
    assert heights.shape == (256, 128)
    again = mtb.roughness((256, 128), (1e-6, 2e-6), hurst=0.7, rms_height=3e-7, seed=5)
    assert np.array_equal(heights, again)
    assert heights.mean() == pytest.approx(0.0, abs=1e-18)
    assert heights.std() == pytest.approx(3e-7, rel=1e-12)
    # the power spectrum falls with the power -2 (1 + H) of the wave number
    square = mtb.roughness(512, 1.0, hurst=0.7, rms_height=1.0, seed=1)
    power = np.abs(np.fft.fft2(square)) ** 2
    k = np.hypot(np.fft.fftfreq(512)[:, None], np.fft.fftfreq(512)[None, :]) * 512
    low, high = (power[(k > a) & (k < 1.5 * a)].mean() for a in (20.0, 80.0))
    assert math.log(low / high) / math.log(4.0) == pytest.approx(3.4, abs=0.15)


@pytest.mark.parametrize("shape", [(40, 30), (33, 41)])
def test_roughness_is_transformed_in_pieces_between_which_ctrl_c_is_answered(
    shape: tuple[int, int], monkeypatch: pytest.MonkeyPatch
) -> None:
    pieces: list[int] = []

    def counted(transform: Any) -> Any:
        def count(field: Array, *args: Any, **options: Any) -> Any:
            pieces.append(field.size)
            return transform(field, *args, **options)

        return count

    monkeypatch.setattr(rough, "PART", 150)
    with monkeypatch.context() as counting:
        for name in ("fft", "ifft", "rfft", "irfft"):
            counting.setattr(np.fft, name, counted(getattr(np.fft, name)))
        found = mtb.roughness(shape, 1.0, hurst=0.6, rms_height=1.0, seed=7)
    assert len(pieces) > 20
    assert max(pieces) <= 150
    # the same surface by NumPy's own transforms of the whole
    noise = np.random.default_rng(7).standard_normal(shape)
    k = np.hypot(np.fft.rfftfreq(shape[1])[None, :], np.fft.fftfreq(shape[0])[:, None])
    allowed = (k > 0.0) & (k <= 0.5)
    heights = np.fft.irfft2(np.fft.rfft2(noise) * np.where(allowed, k, np.inf) ** -1.6, s=shape)
    assert found == pytest.approx(heights / heights.std(), abs=1e-12)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"gap": np.zeros(4)}, "gap has shape"),
        ({"gap": np.full((3, 3), np.nan)}, r"gap\[0, 0\] is nan"),
        ({"gap": np.zeros((3, 3), dtype=complex)}, "real numbers"),
        ({"spacing": 0.0}, "spacing is"),
        ({"spacing": (1e-3, -1.0)}, r"spacing dy is -1"),
        ({"spacing": (1e-3, 1e-3, 1e-3)}, "a number or"),
        ({"force": -3.0}, "force is"),
        ({"force": None}, "either force or approach"),
        ({"approach": 1e-6}, "either force or approach"),
        ({"force": None, "approach": math.inf}, "approach is inf"),
        ({"tolerance": 2.0}, "tolerance is"),
        ({"lower": mtb.Rigid(), "upper": mtb.Rigid()}, "both bodies are rigid"),
        ({"lower": "steel"}, "lower is 'steel'"),
        ({"periodic": 1}, "periodic is 1"),
        ({"method": "fast"}, "method is 'fast'"),
        ({"edge": "soft"}, "edge is 'soft'"),
        ({"moments_about_axes": (1.0,)}, "moments_about_axes is"),
        ({"moments_about_axes": (None, 1.0)}, r"moments_about_axes\[1\] is 1 N m"),
        ({"moments_about_axes": (0.0, 0.0), "periodic": True}, "no tilt"),
        ({"force": None, "approach": 1e-9, "periodic": True}, "approach is 1e-09 m: .* mean gap, 0 m"),
    ],
)
def test_bad_input_is_named(change: dict[str, object], words: str) -> None:
    good: dict[str, object] = {"gap": np.zeros((3, 3)), "spacing": 1e-3, "force": 1.0}
    good |= {"lower": STEEL, "upper": STEEL}
    with pytest.raises(ValueError, match=words):
        mtb.solve_normal(**(good | change))  # type: ignore[arg-type]


@pytest.mark.filterwarnings("ignore:the contact is only")
@pytest.mark.parametrize("moments", [(0.0, 0.0), (None, 0.0)])
def test_few_cells_carry_a_load_that_tilts(moments: tuple[float | None, float | None]) -> None:
    """Three summits or so of a rough bowl: the factors that balance them grow beyond all numbers."""
    x = (np.arange(40) - 19.5) * 1.6e-4
    heights = np.random.default_rng(0)
    bodies: dict[str, Any] = {"lower": mtb.steel, "upper": mtb.steel}
    for _ in range(12):
        gap = (x**2 + x[:, None] ** 2) / 2.0 + 3e-7 * heights.standard_normal((40, 40))
        gap -= gap.min()
        given: dict[str, Any] = {"force": 1.0, "moments_about_axes": moments, "tolerance": 1e-6, **bodies}
        found = mtb.solve_normal(gap, 1.6e-4, method="fft", **given)
        exact = mtb.solve_normal(gap, 1.6e-4, method="dense", **given)
        assert np.abs(found.pressure - exact.pressure).max() < 1e-3 * exact.pressure.max()
        assert found.approach == pytest.approx(exact.approach, rel=1e-3)
