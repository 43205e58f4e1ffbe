# SPDX-License-Identifier: MIT OR Apache-2.0
"""Layers that yield, against printed figures and fields of CONTACT, closed forms and the work done."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import mtb_rs as mtb

DATA = Path(__file__).parents[1] / "data" / "contact"
CASES = {case["name"]: case for case in json.loads((DATA / "plastic_layer.json").read_text())["cases"]}
#: of all runs of CONTACT
BODY = mtb.Material.from_shear_modulus(82e9, 0.28)
MM, MPA, MPA_PER_MM = 1e-3, 1e6, 1e9


def layer_of(thickness: float, modulus: float, yield_stress: float, hardening: float) -> mtb.PlasticLayer:
    """From CONTACT's h3, G3, tau_c0, k_tau in mm, MPa and MPa/mm."""
    return mtb.PlasticLayer(thickness * MM, modulus * MPA, yield_stress * MPA, hardening * MPA_PER_MM)


def one_cell(force: float, side: float = 1.0) -> mtb.PressureField:
    """A square cell of a side in mm under a force in N."""
    return mtb.PressureField(np.full((1, 1), force / side**2 * MPA), (side * MM, side * MM), BODY, BODY)


def pulled(path: list[Any], normal: mtb.PressureField, mu: float, layer: Any) -> list[mtb.TangentialResult]:
    """Shifts (x, y) in mm, one after the other."""
    state, found = None, []
    for x, y in path:
        shift = mtb.Shift((x * MM, y * MM))
        found.append(mtb.solve_tangential(normal, shift, mtb.Coulomb(mu), layer, state=state))
        state = found[-1].state
    return found


def yield_stress(found: mtb.TangentialResult, layer: mtb.PlasticLayer) -> np.ndarray:
    assert found.accumulated_plastic_slip is not None
    return np.asarray(layer.yield_stress + layer.hardening * found.accumulated_plastic_slip)


# G3, tau_c0, k_tau, shifts [mm] and tangential forces [N] as CONTACT's examples print them, h3 = 20 um
MAGNETITE = ((176.63, 560.0, 0.0), [0.035, 0.035, 0.035, 0.05], "280 560 560 560")
CLAY = (
    (106.25, 200.0, 435.0),
    [*[0.04] * 4, 0.036, 0.0, -0.036, 0.0, 0.046, 0.044, *[0.05] * 7],
    "200 216 232 248 262.4 262.4 82.43 82.43 266.4 284.0 304.0 324.1 344.1 364.1 384.1 404.1 424.1",
)


@pytest.mark.parametrize(("material", "shifts", "printed"), [MAGNETITE, CLAY], ids=["magnetite", "clay"])
def test_printed_series_of_oxide_and_clay(material: Any, shifts: list[float], printed: str) -> None:
    modulus, first, hardening = material
    layer = layer_of(0.02, modulus, first, hardening)
    found = pulled([(s, 0.0) for s in shifts], one_cell(900.0), 1.0, layer)
    for force, digits in zip((r.force[0] for r in found), printed.split(), strict=True):
        # half of the last digit that is printed
        assert force == pytest.approx(float(digits), abs=0.5 * 10.0 ** -len(digits.partition(".")[2]))


@pytest.mark.parametrize("name", ["one_cell_k0", "one_cell_hard", "one_cell_soft"])
def test_paths_of_one_cell_meet_contact(name: str) -> None:
    given, steps = CASES[name]["inputs"], CASES[name]["steps"]
    modulus, thickness, first, hardening = map(float, given["layer_G3_h3_tauc0_ktau"].split())
    layer = layer_of(thickness, modulus, first, hardening)
    # from the sixth step on CONTACT's softened cell sticks with a traction of four times its yield stress
    count = 5 if hardening < 0.0 else len(steps)
    normal = one_cell(given["FN"], given["cell"])
    plastic = np.zeros(2)
    found = pulled(given["path_shift_x_y"][:count], normal, given["mu"], layer)
    for result, row in zip(found, steps, strict=False):
        state, *printed = row
        assert result.status[0, 0] == state
        assert result.plastic_slip is not None
        plastic += result.plastic_slip[:, 0, 0] / MM
        # CONTACT's tractions act on the upper body
        own = [*(-result.traction[:2, 0, 0] / MPA), yield_stress(result, layer)[0, 0] / MPA, *(-plastic)]
        assert np.allclose(own, printed, rtol=4e-6, atol=1e-6)


@pytest.mark.parametrize("name", ["shift", "shift_soft", "steady", "steady_spin"])
def test_fields_meet_contact_cell_by_cell(name: str) -> None:
    given, grid, printed = (CASES[name][part] for part in ("inputs", "grid", "results"))
    with np.load(DATA / "plastic_layer.npz") as arrays:
        field = {k.partition("/")[2]: arrays[k].astype(float) for k in arrays if k.startswith(f"{name}/")}
    modulus, thickness = map(float, given["layer_G3_h3"].split())
    layer = layer_of(thickness, modulus, given["tau_c0"], given["k_tau"])
    x, y, spin = map(float, given["creepages_or_shift"].split())
    normal = mtb.PressureField(field["pn"] * MPA, (grid["dx"] * MM, grid["dy"] * MM), BODY, BODY)
    motion: Any = mtb.Shift((x * MM, y * MM), spin=spin)
    if given["kind"] == "steady":
        motion = mtb.Rolling((x, y, spin / MM), velocity=given["speed"] * MM)
    law = mtb.Coulomb(given["mu"])
    found = mtb.solve_tangential(normal, motion, law, layer)
    assert np.array_equal(found.status, field["status"])
    traction = np.stack([field["px"], field["py"]])
    # files of six digits, of a run that has converged to its own tolerance
    assert np.abs(-found.traction[:2] / MPA - traction).max() < 1e-5 * np.abs(traction).max()
    touching = found.status > 0
    hardened = yield_stress(found, layer)[touching] / MPA
    assert np.abs(hardened - field["tau_crit"][touching]).max() < 1e-5 * hardened.max()
    slip, unit = (field["slip"], 1.0) if "slip" in field else (field["shift"], MM)
    assert np.abs(np.hypot(*found.slip) / unit - slip).max() < 1e-5 * slip.max()
    for own, (key, scale) in zip(
        (*found.force[:2], found.spin_moment),
        (("FX", 1.0), ("FY", 1.0), ("MZ", MM)),
        strict=True,
    ):
        # four digits
        assert -own == pytest.approx(printed[key] * scale, rel=5e-4, abs=1e-3 * scale)
    if given["kind"] == "shift":
        # CONTACT's work is that of the whole traction on the slip, from zero, ours that of its mean
        assert 2.0 * (found.dissipation * found.area).sum() == pytest.approx(-printed["FRIC.WORK"], rel=5e-4)
    elastic = mtb.InterfaceLayer(layer.thickness, layer.shear_modulus)
    without = mtb.solve_tangential(normal, motion, law, elastic)
    assert found.report.iterations <= without.report.iterations + 3


def ball(cells: int = 25, unlike: bool = False) -> mtb.NormalResult:
    """A ball of steel in mm on steel, or on a softer body."""
    x = (np.arange(cells) - cells // 2) * 12.0 * MM / cells
    gap = (x[None, :] ** 2 + x[:, None] ** 2) / 0.6
    other = mtb.Material(70e9, 0.33) if unlike else mtb.steel
    return mtb.solve_normal(gap, 12.0 * MM / cells, lower=other, upper=mtb.steel, force=8e3)


LAYER = mtb.PlasticLayer(0.05 * MM, 1e9, 60e6, 2e12)


@pytest.mark.parametrize("hardening", [0.0, 2e12, -2e11])
@pytest.mark.parametrize("unlike", [False, True])
@pytest.mark.parametrize("angle", [0.0, 0.7])
def test_steps_of_rolling_end_in_the_steady_state(hardening: float, unlike: bool, angle: float) -> None:
    normal = ball(15, unlike)
    layer = mtb.PlasticLayer(0.05 * MM, 1e9, 60e6, hardening)
    rolling = {"creepage": (1.5e-3, 1e-3, 0.1), "angle": angle}
    steady = mtb.solve_tangential(normal, mtb.Rolling(**rolling), mtb.Coulomb(0.3), layer)
    state = None
    for _ in range(80):
        step = mtb.Rolling(**rolling, transient=True)
        found = mtb.solve_tangential(normal, step, mtb.Coulomb(0.3), layer, state=state)
        state = found.state
    assert (steady.status == 3).sum() > 5
    touching = steady.status > 0
    assert found.traction == pytest.approx(steady.traction, abs=1e-6 * np.abs(steady.traction).max())
    assert found.accumulated_plastic_slip is not None
    assert steady.accumulated_plastic_slip is not None
    own, other = found.accumulated_plastic_slip[touching], steady.accumulated_plastic_slip[touching]
    assert own == pytest.approx(other, abs=1e-6 * other.max())
    assert np.array_equal(found.status, steady.status)


def test_heat_in_the_layer_and_of_friction_are_the_work() -> None:
    normal = ball()
    found = mtb.solve_tangential(normal, mtb.Rolling((2e-3, 0.0, 0.0)), mtb.Coulomb(0.3), LAYER)
    assert found.plastic_dissipation is not None
    total = (found.dissipation * found.area).sum()
    assert total == pytest.approx(found.force[0] * 2e-3, rel=1e-7)
    in_layer = (found.plastic_dissipation * found.area).sum()
    assert 0.3 * total < in_layer < 0.9 * total


def test_heat_of_yield_is_the_yield_stress_over_the_plastic_slip() -> None:
    """In small shifts back and forth: the integral of tau_c du, which hardening makes a square."""
    errors = []
    for count in (20, 40, 80):
        way = np.sin(np.linspace(0.0, 2.5 * np.pi, count + 1)) * 8e-3  # mm
        found = pulled([(d, 0.0) for d in np.diff(way)], ball(15), 2.0, LAYER)
        heat = sum((r.plastic_dissipation * r.area).sum() for r in found)
        last = found[-1].accumulated_plastic_slip
        assert last is not None
        exact = ((LAYER.yield_stress * last + LAYER.hardening * last**2 / 2) * found[-1].area).sum()
        errors.append(abs(heat / exact - 1.0))
    # of first order: a step in which a point begins to yield counts the mean of its tractions
    assert errors[2] < 0.03
    assert errors[2] < 0.65 * errors[1] < 0.65**2 * errors[0]


def test_a_strong_layer_is_elastic_and_a_weak_one_flows() -> None:
    normal, shift = ball(), mtb.Shift((4e-6, 1e-6))
    strong = mtb.PlasticLayer(0.05 * MM, 1e9, 1e12)
    elastic = mtb.solve_tangential(normal, shift, mtb.Coulomb(0.3), mtb.InterfaceLayer(0.05 * MM, 1e9))
    found = mtb.solve_tangential(normal, shift, mtb.Coulomb(0.3), strong)
    assert np.array_equal(found.traction, elastic.traction)
    assert found.status.max() == 2
    weak = mtb.PlasticLayer(0.05 * MM, 1e9, 1e6)
    found = mtb.solve_tangential(normal, mtb.Shift((1e-3, 0.0)), mtb.Coulomb(1.0), weak)
    # at the very edge friction is weaker
    bound = np.minimum(found.pressure, 1e6)
    assert np.array_equal(found.status == 3, found.pressure > 1e6)
    assert found.traction[0] == pytest.approx(bound, rel=1e-6)


@pytest.mark.parametrize("share", [0.5, 0.95])
def test_a_force_below_the_strength_is_reached(share: float) -> None:
    normal = ball()
    strength = np.minimum(0.3 * normal.pressure, 60e6).sum() * normal.area.flat[0]
    layer = mtb.PlasticLayer(0.05 * MM, 1e9, 60e6)
    pushed = mtb.Shift(force=(share * strength, 0.0))
    found = mtb.solve_tangential(normal, pushed, mtb.Coulomb(0.3), layer)
    assert found.force[0] == pytest.approx(share * strength, rel=1e-7)
    beyond = mtb.Shift(force=(1.01 * strength, 0.0))
    with pytest.raises(ValueError, match=r"a tangential force of .* N is prescribed"):
        mtb.solve_tangential(normal, beyond, mtb.Coulomb(0.3), layer)


@pytest.mark.parametrize("motion", [mtb.Shift((0.05 * MM, 0.0)), mtb.Rolling((0.05, 0.0, 0.0))])
def test_softening_is_refused_from_the_stiffness_of_the_contact_on(motion: Any) -> None:
    cell = one_cell(900.0)
    elastic = mtb.solve_tangential(
        cell, mtb.Shift((1e-6, 0.0)), mtb.Coulomb(1.0), mtb.InterfaceLayer(20e-6, 176.63e6)
    )
    stiffness = elastic.traction[0, 0, 0] / 1e-6
    for slope in (0.5, 0.99):
        layer = mtb.PlasticLayer(20e-6, 176.63e6, 560e6, -slope * stiffness)
        mtb.solve_tangential(cell, motion, mtb.Coulomb(1.0), layer)
    layer = mtb.PlasticLayer(20e-6, 176.63e6, 560e6, -1.01 * stiffness)
    with pytest.raises(ValueError, match="more than one answer may exist"):
        mtb.solve_tangential(cell, motion, mtb.Coulomb(1.0), layer)


def test_memory_stays_at_cells_that_have_left_the_contact() -> None:
    """A shift under less load, then under the full one again."""
    x = (np.arange(15) - 7) * 0.8 * MM
    gap = (x[None, :] ** 2 + x[:, None] ** 2) / 0.6
    wide, narrow = (
        mtb.solve_normal(gap, 0.8 * MM, lower=mtb.steel, upper=mtb.steel, force=f) for f in (8e3, 5e2)
    )
    law, layer = mtb.Coulomb(0.5), LAYER
    first = mtb.solve_tangential(wide, mtb.Shift((8e-6, 0.0)), law, layer)
    second = mtb.solve_tangential(narrow, mtb.Shift((1e-7, 0.0)), law, layer, state=first.state)
    assert first.accumulated_plastic_slip is not None
    assert second.accumulated_plastic_slip is not None
    left = (wide.pressure > 0.0) & (narrow.pressure <= 0.0)
    assert first.accumulated_plastic_slip[left].max() > 0.0
    assert np.array_equal(second.accumulated_plastic_slip[left], first.accumulated_plastic_slip[left])


def test_what_cannot_yield_is_refused() -> None:
    normal, shift = ball(15), mtb.Shift((8e-6, 0.0))
    with pytest.raises(ValueError, match=r"friction is a FallingFriction, and the layer yields: .* Coulomb"):
        mtb.solve_tangential(normal, shift, mtb.FallingFriction(0.3, 0.1, 1.0, memory=1e-6), LAYER)
    with pytest.raises(ValueError, match="Coulomb"), pytest.warns(UserWarning, match="StaticKinetic"):
        mtb.creep_curve(normal, [(1e-3, 0.0, 0.0)], mtb.StaticKinetic(0.3, 0.2), LAYER)
    for wrong in ({"yield_stress": 0.0}, {"yield_stress": -1.0}, {"hardening": np.nan}, {"thickness": -1.0}):
        given = {"thickness": 1e-3, "shear_modulus": 1e9, "yield_stress": 1e6} | wrong
        with pytest.raises(ValueError, match=next(iter(wrong))):
            mtb.PlasticLayer(**given)


def test_results_show_and_keep_the_layer(tmp_path: Path) -> None:
    found = mtb.solve_tangential(ball(15), mtb.Shift((8e-6, 0.0)), mtb.Coulomb(0.3), LAYER)
    assert " plastic" in repr(found)
    found.save(tmp_path)
    again: Any = mtb.load(tmp_path)
    assert np.array_equal(again.plastic_slip, found.plastic_slip)
    assert np.array_equal(again.state.accumulated_plastic_slip, found.state.accumulated_plastic_slip)
    for quantity in ("status", "plastic_slip", "accumulated_plastic_slip", "plastic_dissipation"):
        again.plot(quantity)
        again.plot(quantity, x=0.0)
    curve = mtb.creep_curve(ball(15), [(1e-3, 0.0, 0.0)], mtb.Coulomb(0.3), LAYER)
    rolled = mtb.solve_tangential(ball(15), mtb.Rolling((1e-3, 0.0, 0.0)), mtb.Coulomb(0.3), LAYER)
    assert curve[0, 0] == pytest.approx(rolled.force[0], rel=1e-5)
    assert mtb.PlasticLayer(1e-3, 1e9, 1e6).flexibility == 1e-12
