# SPDX-License-Identifier: MIT OR Apache-2.0
"""The borders of the maps (docs/maps): inside a method converges to its reference, outside it says so."""

from __future__ import annotations

import importlib
import re
import sys
from contextlib import nullcontext
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest

import mtb_rs as mtb
from mtb_rs.half_space import reference

STUDIES = Path(__file__).parents[2] / "studies"


def study(name: str, monkeypatch: pytest.MonkeyPatch) -> ModuleType:
    """A script of a map, for the functions it is made of."""
    monkeypatch.syspath_prepend(str(STUDIES))
    sys.modules.pop(name, None)
    return importlib.import_module(name)


def apart(one: np.ndarray, other: np.ndarray) -> float:
    return float(np.linalg.norm(one - other) / np.linalg.norm(other))


@pytest.mark.parametrize(("height", "friction"), [(0.05, 0.2), (0.1, 0.5)])
def test_staggered_on_both_sides_of_its_predicted_limit(height: float, friction: float) -> None:
    scene = mtb.scenes.block_on_plane(height=height, friction=friction, spacing=0.0125)
    options = {"method": "staggered", "max_iterations": 200, "displacement_tolerance": 1e-7}
    fast = scene.solve("elastic-upper", factor=1.0, anderson_depth=8, **options)
    limit = float(fast.report.solver.rsplit("below ", 1)[1])
    slow = scene.solve("elastic-upper", factor=1.25 * limit, **options)
    assert apart(slow.pressure, fast.pressure) < 1e-5
    with pytest.raises(mtb.ConvergenceError, match=r'diverges below .*method="direct"') as caught:
        scene.solve("elastic-upper", factor=0.9 * limit, **options)
    assert not caught.value.result.report.converged


@pytest.mark.coarse
@pytest.mark.parametrize("ratio", [2.0, 5.0])
def test_sliding_exists_below_mu_sym_and_wedging_is_named_above(ratio: float) -> None:
    scene = mtb.scenes.block_on_plane(height=0.1 * ratio, friction=0.1, spacing=0.0125)
    limit = 0.1 / scene.solve("elastic-upper").report.wedging_margin
    assert limit == pytest.approx(1.6 / ratio, rel=0.25)  # beam theory
    below = scene.with_(friction=0.98 * limit).solve("elastic-upper")
    assert below.report.converged
    assert below.report.wedging_margin == pytest.approx(0.98, rel=1e-3)
    with pytest.raises(mtb.ConvergenceError, match="wedges") as caught:
        scene.with_(friction=1.6 * limit).solve("elastic-upper")
    named = float(re.search(r"only up to ([\d.]+)", str(caught.value))[1])  # type: ignore[index]
    assert named == pytest.approx(limit, rel=0.01)


@pytest.mark.coarse
def test_gauss_seidel_cycles_where_active_sets_solve(monkeypatch: pytest.MonkeyPatch) -> None:
    low, middle, high = study("complementarity", monkeypatch).examine(2.0, 6, [0.05, 0.5, 1.5])
    # one solution below mu_sym: both find it at first, then only the active sets; far above there is none
    assert low["positive_definite"] == middle["positive_definite"] == 1
    assert low["gauss_seidel_sweeps"] != "none"
    assert middle["gauss_seidel_sweeps"] == "none"
    assert not middle["needed_lemke"]
    assert "none" not in (low["active_set_iterations"], middle["active_set_iterations"])
    assert (high["positive_definite"], high["active_set_iterations"]) == (0, "none")


@pytest.mark.coarse
@pytest.mark.parametrize("lower", [mtb.steel, mtb.Material(70e9, 0.33), mtb.Material(3e9, 0.38)])
def test_increments_meet_the_direct_solution(lower: mtb.Material) -> None:
    scene = mtb.scenes.paraboloid_on_plane(points=12, lower=lower)
    found, direct = scene.solve("half-space", method="incremental"), scene.solve("half-space")
    assert apart(found.pressure, direct.pressure) < 5e-3


@pytest.mark.parametrize("lower", [mtb.Material(600e9, 0.2), mtb.Rigid()])
def test_increments_on_a_much_stiffer_body_are_refused(lower: mtb.Material | mtb.Rigid) -> None:
    scene = mtb.scenes.paraboloid_on_plane(points=12, lower=lower)
    with pytest.raises(mtb.ConvergenceError, match=r'load increments.*method="direct"'):
        scene.solve("half-space", method="incremental")


@pytest.mark.parametrize("load", [1e-4, 0.1, 1.0, 3.0])
@pytest.mark.parametrize("side", [8, 16])
def test_periodic_dense_and_fourier_agree_up_to_full_contact(load: float, side: int) -> None:
    step, slope = 1e-6, 0.1
    heights = mtb.roughness(side, step, hurst=0.3, rms_slope=slope, seed=side)
    force = load * 0.5 * mtb.steel.plane_strain_modulus * slope * (side * step) ** 2
    pair = {"lower": mtb.steel, "upper": mtb.Rigid(), "periodic": True, "force": force}
    gap = heights.max() - heights
    dense = mtb.solve_normal(gap, step, method="dense", **pair)
    fourier = mtb.solve_normal(gap, step, method="fft", tolerance=1e-11, **pair)
    assert dense.report.residual < 1e-10
    assert apart(fourier.pressure, dense.pressure) < 1e-7
    assert fourier.approach == pytest.approx(dense.approach, rel=1e-7)
    assert np.abs(fourier.gap - dense.gap).max() < 1e-7 * heights.std()


def test_contact_that_leaves_its_grid_and_loads_no_pressure_carries_are_refused() -> None:
    line = np.linspace(-1e-3, 1e-3, 64)
    gap = (line[None] ** 2 + line[:, None] ** 2) / 2.0
    pair = {"lower": mtb.steel, "upper": mtb.steel, "method": "fft"}
    step = float(line[1] - line[0])
    inside = mtb.solve_normal(gap, step, force=20.0, **pair)
    assert inside.report.converged
    with pytest.raises(ValueError, match=r"reaches the edge .* would not do"):
        mtb.solve_normal(gap, step, force=2e5, **pair)
    with pytest.raises(ValueError, match="moments"):
        mtb.solve_normal(gap, step, force=20.0, moments_about_axes=(None, 0.1), **pair)


def test_falling_friction_with_memory_is_smooth_and_without_it_says_so() -> None:
    body = mtb.Material.from_shear_modulus(82e9, 0.28)
    patch = reference.elliptic_pressure(1e4, (3.2e-3, 3.2e-3), (20, 20), body, body)
    layer = mtb.InterfaceLayer(thickness=0.125e-3, shear_modulus=0.82e9)
    creepages = [(xi, 0.0, 0.0) for xi in np.linspace(1e-3, 8e-3, 8)]

    def law(memory: float | None) -> mtb.FallingFriction:
        return mtb.FallingFriction(static=0.33, kinetic=0.14, half_slip=0.02, memory=memory)

    forces = mtb.creep_curve(patch, creepages, law(1e-4), layer=layer)[:, 0]
    assert np.abs(np.diff(forces, 2)).max() < 0.05 * forces.max()
    with pytest.raises(mtb.ConvergenceError, match="no convergence at creepages") as caught:
        mtb.creep_curve(patch, creepages, law(None), layer=layer)
    assert np.isnan(caught.value.result).any()


def test_friction_that_falls_at_once_has_no_state_without_a_memory() -> None:
    hertz = mtb.hertz(10e3, semi_axes=(4e-3, 3e-3), lower=mtb.steel, upper=mtb.steel)
    patch = hertz.on_grid((20, 20), (0.42e-3, 0.32e-3))
    motion = mtb.Rolling(creepage=(1.9e-4, 0.0, 0.2), velocity=10.0)
    for half_slip, memory in ((1e-2, None), (1.2e-3, 10e-6)):
        law = mtb.FallingFriction(static=0.35, kinetic=0.05, half_slip=half_slip, memory=memory)
        assert mtb.solve_tangential(patch, motion, law).report.converged
    with pytest.raises(mtb.ConvergenceError, match="may have no state without a memory"):
        mtb.solve_tangential(patch, motion, mtb.FallingFriction(static=0.35, kinetic=0.05, half_slip=1.2e-3))


def test_elements(monkeypatch: pytest.MonkeyPatch) -> None:
    elements = study("elements", monkeypatch)
    # a mesh as fine as the contact is smooth, a coarser one ripples
    (_, fine), (_, coarse) = (elements.mesh_against_contact(8, n) for n in (8, 4))
    assert coarse > 2.0 * fine
    # slivers down to 1e-4 change nothing, flat ones are refused by name
    assert elements.squashed(1e-4) == pytest.approx(elements.squashed(1.0), rel=1e-3)
    with pytest.raises(ValueError, match="tetrahedr"):
        elements.squashed(1e-13)
    with pytest.raises(ValueError, match="poisson_ratio"):
        mtb.Material(208e9, 0.51)


def test_quadratic_elements_do_not_lock_and_linear_ones_do(monkeypatch: pytest.MonkeyPatch) -> None:
    elements = study("elements", monkeypatch)
    line = np.linspace(-0.05, 0.05, 7)
    held = ("top", "rear", "front", "left", "right")
    share = {}
    for quadratic in (True, False):
        for ratio in (0.3, 0.499):
            mesh = elements.block_mesh(line, line, 0.1, quadratic=quadratic)
            words = "lock" if ratio > 0.45 else "too stiff"
            told = nullcontext() if quadratic else pytest.warns(UserWarning, match=words)
            with told:
                body = elements.body(mesh, ratio, held)
            own, weight = elements.compliance(body, 6)
            load = np.sign(np.arange(weight.size) % 7 - 3.0)
            share[quadratic, ratio] = float((weight * load) @ own @ load)
    assert share[True, 0.499] > 0.4 * share[True, 0.3]
    assert share[False, 0.499] < 0.2 * share[True, 0.499]


def test_facets_too_coarse_for_the_approach_are_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    facets = study("facets", monkeypatch)
    assert facets.gap_error(16, 1e-5) < 1e-4
    with pytest.raises(ValueError, match="facet"):
        facets.gap_error(4, 1e-7)


@pytest.mark.coarse
@pytest.mark.filterwarnings("ignore:young_modulus of the")
def test_scales_do_not_matter(monkeypatch: pytest.MonkeyPatch) -> None:
    scales = study("scales", monkeypatch)
    base = scales.paraboloid(0.1, 2e11)
    for length, modulus in ((1e-6, 1e12), (1e-6, 1e5), (1e3, 1e5)):
        assert np.abs(scales.paraboloid(length, modulus) - base).max() < 1e-12 * base.max()


def test_the_border_of_a_punch_is_what_does_not_converge() -> None:
    errors = {}
    fine = mtb.scenes.block_on_plane(friction=0.0, spacing=0.1 / 96).solve("half-space").pressure
    for n in (12, 24):
        pressure = mtb.scenes.block_on_plane(friction=0.0, spacing=0.1 / n).solve("half-space").pressure
        mean = fine.reshape(n, 96 // n, n, 96 // n).mean(axis=(1, 3))
        errors[n] = [apart(pressure, mean), apart(pressure[1:-1, 1:-1], mean[1:-1, 1:-1])]
    # cell averages: the border's error falls slowly, the inside's is smaller and falls faster
    assert errors[24][0] > 0.75 * errors[12][0]
    assert errors[24][1] < 0.85 * errors[12][1]
