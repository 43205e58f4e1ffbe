# SPDX-License-Identifier: MIT OR Apache-2.0
"""Surface temperatures in rolling, against CONTACT, closed forms and an own quadrature."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import mtb_rs as mtb
from mtb_rs import _mtb_rs

Array = NDArray[np.float64]
DATA = Path(__file__).parents[1] / "data" / "contact"
CASES = json.loads((DATA / "rolling_heat.json").read_text())["cases"]
FIELDS = np.load(DATA / "rolling_heat.npz")
STEEL = mtb.conducting_steel
SPEED = 30.0


def bulk_of(case: dict[str, Any]) -> tuple[float, float]:
    inputs = case["inputs"]
    lower, upper = (inputs[name].split()[0] for name in ("heat_bulk_c_lambda_rho_body1", "body2"))
    return float(lower), float(upper)


@pytest.mark.parametrize("case", CASES, ids=lambda case: str(case["name"]))
def test_the_same_heat_gives_the_temperatures_of_contact(case: dict[str, Any]) -> None:
    # CONTACT counts the heat of a cell in this very cell twice, and takes traction times slip for the heat
    name, grid = case["name"], case["grid"]
    traction = np.hypot(FIELDS[f"{name}/px"], FIELDS[f"{name}/py"]) * 1e6
    power = traction * FIELDS[f"{name}/slip"] * SPEED
    spacing = 1e-3 * grid["dx"], 1e-3 * grid["dy"]
    bodies = STEEL.constants, STEEL.constants
    touches = FIELDS[f"{name}/status"] > 0
    found, flux = _mtb_rs.rolling_temperatures(power, touches, spacing, math.pi, SPEED, bodies, bulk_of(case))
    own = 2.0 * math.sqrt(0.5 * spacing[0]) * power / (2.0 * STEEL.effusivity * math.sqrt(math.pi * SPEED))
    # six digits are printed; where friction follows the temperature, T1 is of the iteration before
    follows = "temperature_fref_Tref_df_dT" in case["inputs"]["law"]
    for k, field, within in ((0, "T1", 2e-4 if follows else 1e-5), (1, "T2", 1e-5)):
        assert found[k] + own == pytest.approx(FIELDS[f"{name}/{field}"], abs=within * found.max())
    assert flux.sum(axis=0) == pytest.approx(power, abs=1e-12 * max(power.max(), 1.0))


def ertz_and_knothe(cells: int, creepage: float) -> mtb.TangentialResult:
    m = mtb.Material.from_shear_modulus(82e9, 0.28)
    hertz = mtb.hertz(100e3, semi_axes=(5.88e-3, 10.54e-3), lower=m, upper=m)
    patch = hertz.on_grid((cells, cells), (12.4e-3 / cells, 22.2e-3 / cells))
    rolling = mtb.Rolling((creepage, 0.0, 0.0), velocity=SPEED)
    return mtb.solve_tangential(patch, rolling, mtb.Coulomb(0.3))


def test_a_sliding_wheel_is_as_hot_as_ertz_and_knothe_say() -> None:
    # 1 m/s of slip; without the elastic slip the heat is friction times pressure times slip
    rolled = ertz_and_knothe(60, 1.0 / 30.0)
    a, q0 = 5.88e-3, 0.3 * rolled.pressure.max() * 1.0
    rigid = 2.188 * q0 * math.sqrt(a) / (2.0 * STEEL.effusivity * math.sqrt(math.pi * SPEED))
    assert rigid == pytest.approx(150.3, rel=3e-3)
    found = rolled.temperature()
    assert found.peak == pytest.approx(152.3, rel=1e-2)
    # the heat is force times slip, half of it into each of two like bodies
    assert found.friction_power == pytest.approx(abs(rolled.force[0]) * 1.0, rel=1e-10)
    assert found.heat_lower == pytest.approx(0.5 * found.friction_power, rel=1e-12)
    # the contact moves along +x: bodies leave it at -x, hotter there
    middle = found.temperature_lower[30]
    assert middle[:30].max() > 1.2 * middle[30:].max()


def test_coarse_cells_do_with_temperatures() -> None:
    peaks = np.array([ertz_and_knothe(cells, 1.0 / 30.0).temperature().peak for cells in (15, 30, 120)])
    assert peaks[:2] == pytest.approx(peaks[2], rel=5e-3)


def test_a_turned_contact_has_turned_temperatures() -> None:
    m = mtb.Material.from_shear_modulus(82e9, 0.28)
    hertz = mtb.hertz(10e3, semi_axes=(4e-3, 3e-3), lower=m, upper=m)
    patch = hertz.on_grid((30, 30), (0.29e-3, 0.27e-3))
    turned = mtb.PressureField(patch.pressure.T.copy(), patch.spacing[::-1], m, m)
    law, bodies = mtb.Coulomb(0.3), (mtb.Conductor(20.0, 7000.0, 500.0), STEEL)

    def temperature(field: mtb.PressureField, creepage: Any, angle: float) -> mtb.RollingTemperature:
        motion = mtb.Rolling(creepage, angle=angle, velocity=20.0)
        return mtb.solve_tangential(field, motion, law).temperature(*bodies, bulk=(20.0, 90.0))

    along = temperature(patch, (4e-3, 1e-3, 0.3), 0.0)
    # x becomes y, and y becomes -x
    across = temperature(turned, (-1e-3, 4e-3, 0.3), math.pi / 2)
    for name in ("temperature_lower", "temperature_upper", "heat_flux_lower", "heat_flux_upper"):
        straight, rotated = getattr(along, name), getattr(across, name)
        assert rotated[:, ::-1] == pytest.approx(straight.T, rel=1e-6, abs=1e-6 * np.abs(straight).max())
    assert np.array_equal(along.status > 0, along.pressure > 0)
    touching = along.status > 0
    assert along.temperature_lower[touching] == pytest.approx(along.temperature_upper[touching], rel=1e-9)


@pytest.mark.filterwarnings("ignore:The Peclet number")
@pytest.mark.parametrize("sides", [(4e-3, 1e-3), (1e-3, 4e-3)])
def test_one_cell_is_as_long_as_it_is(sides: tuple[float, float]) -> None:
    """Where its middle is, the heat of half a cell has come in: 2 q sqrt(t / pi) / effusivity."""
    m = mtb.steel
    field = mtb.PressureField([[400e6]], sides, m, m)
    rolled = mtb.solve_tangential(field, mtb.Rolling((5e-2, 0.0, 0.0), velocity=10.0), mtb.Coulomb(0.2))
    time = 0.5 * sides[0] / 10.0
    heat = 0.5 * float(rolled.dissipation[0, 0]) * 10.0
    closed = 2.0 * heat * math.sqrt(time / math.pi) / STEEL.effusivity
    assert rolled.temperature().temperature_lower[0, 0] == pytest.approx(closed, rel=1e-9)


def test_line_contacts_and_slow_ones() -> None:
    m = mtb.steel
    x = (np.arange(60) - 29.5) * 0.2e-3
    pressure = 500e6 * np.sqrt(np.maximum(0.0, 1.0 - (x / 5e-3) ** 2))[None, :]
    field = mtb.PressureField(pressure, (0.2e-3, 1.0), m, m, reference=1.0)
    rolled = mtb.solve_tangential(field, mtb.Rolling((5e-2, 0.0, 0.0), velocity=10.0), mtb.Coulomb(0.2))
    found = rolled.temperature()
    # sliding everywhere: half an ellipse of heat, and what elastic slip adds
    q0 = 0.2 * 500e6 * 0.05 * 10.0
    closed = 2.188 * q0 * math.sqrt(5e-3) / (2.0 * STEEL.effusivity * math.sqrt(math.pi * 10.0))
    assert found.peak == pytest.approx(closed, rel=0.05)
    slow = mtb.solve_tangential(field, mtb.Rolling((5e-2, 0.0, 0.0), velocity=0.01), mtb.Coulomb(0.2))
    with pytest.warns(UserWarning, match="Peclet number"):
        slow.temperature()


def test_wheels_of_steps_are_as_hot_as_the_same_contact_alone() -> None:
    step = (
        mtb.scenes.wheel_on_rail(spacing=0.5e-3, lateral=0.0)
        .prepare()
        .step(velocity=(20.0, *[0.0] * 3, 43.0, 0.0))
    )
    (patch,) = step.patches
    found = patch.temperature(bulk=(10.0, 60.0))
    bodies = STEEL.constants, STEEL.constants
    spacing = patch.x[1] - patch.x[0], patch.y[1] - patch.y[0]
    touches = patch.status > 0
    alone, _ = _mtb_rs.rolling_temperatures(
        patch.dissipation, touches, spacing, 0.0, patch.rolling_speed, bodies, (10.0, 60.0)
    )
    assert found.temperature_lower == pytest.approx(alone[0], rel=1e-9)
    assert found.temperature_upper == pytest.approx(alone[1], rel=1e-9)
    assert found.peak > 36.0
    assert found.friction_power == pytest.approx((patch.dissipation * patch.area).sum(), rel=1e-9)


def test_large_creepages_are_warned_of_and_locked_wheels_refused() -> None:
    with pytest.warns(UserWarning, match="speeds of both surfaces differ"):
        ertz_and_knothe(15, 0.3).temperature()
    with pytest.raises(ValueError, match="stands still"):
        ertz_and_knothe(15, 2.0).temperature()


def test_bad_input_is_refused() -> None:
    rolled = ertz_and_knothe(15, 1e-3)
    with pytest.raises(ValueError, match="upper is 5"):
        rolled.temperature(upper=5)  # type: ignore[arg-type]
    with pytest.raises(ValueError, match=r"bulk\[1\]"):
        rolled.temperature(bulk=(0.0, math.nan))
    with pytest.raises(ValueError, match="conductivity is -1"):
        mtb.Conductor(-1.0, 7850.0, 450.0)
    with pytest.raises(ValueError, match="expansion is -1e-05 1/K: at least 0"):
        mtb.Conductor(50.0, 7850.0, 450.0, expansion=-1e-5)
    for drawn in (rolled.temperature(), rolled.stress(depths=[1e-3, 2e-3])):
        with pytest.raises(ValueError, match="ax is 3: axes of matplotlib"):
            drawn.plot(ax=3)  # type: ignore[arg-type]
    m = mtb.steel
    patch = mtb.hertz(1e3, semi_axes=(1e-3, 1e-3), lower=m, upper=m).on_grid((12, 12), (0.2e-3, 0.2e-3))
    shifted = mtb.solve_tangential(patch, mtb.Shift((1e-6, 0.0)), mtb.Coulomb(0.3))
    with pytest.raises(ValueError, match="this is a shift"):
        shifted.temperature()
    step = mtb.solve_tangential(patch, mtb.Rolling((1e-3, 0.0, 0.0), transient=True), mtb.Coulomb(0.3))
    with pytest.raises(ValueError, match="transient step"):
        step.temperature()


@pytest.mark.parametrize(
    ("angle", "cell"), [(np.pi / 4, 3e-4), (-0.75 * np.pi, 3e-4), (np.arctan2(2.0, 4.0), (4e-4, 2e-4))]
)
def test_paths_across_the_corners_of_cells(angle: float, cell: Any) -> None:
    """A direction on the diagonal is nothing special, where the bulk temperatures differ as well."""
    dx, dy = np.broadcast_to(cell, 2)
    x, y = np.meshgrid((np.arange(31) - 15) * dx, (np.arange(31) - 15) * dy)
    normal = mtb.solve_normal((x**2 + y**2) / 0.4, cell, lower=mtb.steel, upper=mtb.steel, force=3e3)

    def peak(direction: float) -> float:
        creepage = (3e-3 * np.cos(direction), 3e-3 * np.sin(direction), 0.0)
        rolling = mtb.Rolling(creepage, angle=direction, velocity=20.0)
        return mtb.solve_tangential(normal, rolling, mtb.Coulomb(0.3)).temperature(bulk=(30.0, -20.0)).peak

    assert peak(angle) == pytest.approx(peak(angle + 1e-9), abs=1e-4)
