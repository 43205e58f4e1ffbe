# SPDX-License-Identifier: MIT OR Apache-2.0
"""Where friction turns into heat: fields that close the balance of energy."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

import mtb_rs as mtb
from mtb_rs._mtb_rs import half_space

STEEL = mtb.Material(210e9, 0.28)
RUBBER = mtb.Material(3e9, 0.45)
LAYER = mtb.InterfaceLayer(1e-4, 8.2e9)


def field(n: int = 20, upper: mtb.Material = STEEL, *, two: bool = False) -> mtb.PressureField:
    """Hertz's pressure on `n` cells along the longer axis, or two such patches on one grid; room around."""
    a, b, border = 3e-3, 2e-3, 3
    dx = 2.0 * a / n
    x = (np.arange(n + 2 * border) - (n + 2 * border - 1) / 2.0) * dx
    x, y = np.meshgrid(x, x)
    pressure = 1e9 * np.sqrt(np.maximum(0.0, 1.0 - (x / a) ** 2 - (y / b) ** 2))
    if two:
        pressure = np.concatenate([pressure, 0.6 * pressure], axis=1)
    return mtb.PressureField(pressure, (dx, dx), STEEL, upper)


def rigid(result: Any, behind: tuple[float, float] = (0.0, 0.0)) -> np.ndarray:
    """Rigid slip of a rolling contact a sixth of the step ahead of the cells, less `behind` [m]."""
    step = result.motion.step_vector((result.points[0, 0, 1] - result.points[0, 0, 0],) * 2)
    x, y = (result.points[c] + step[c] / 6.0 - behind[c] for c in (0, 1))
    xi, eta, phi = result.creepage
    return np.stack([xi - phi * y, eta + phi * x])


def elastic_energy(field: mtb.PressureField, traction: np.ndarray, layer: mtb.InterfaceLayer | None) -> float:
    """Of tangential tractions (2, ny, nx) on like bodies [J]."""
    ny, nx = field.pressure.shape
    load = np.ascontiguousarray(np.concatenate([traction.reshape(2, -1), np.zeros((1, nx * ny))]))
    moved = sum(
        half_space(
            (body.shear_modulus, body.poisson_ratio), [(0.0, 0.0, nx, ny)], field.spacing, True
        ).displacement(load)
        for body in (field.lower, field.upper)
    )
    if layer is not None:
        moved = moved + layer.flexibility * load  # type: ignore[assignment]
    return 0.5 * float((load * moved).sum()) * field.spacing[0] * field.spacing[1]


@pytest.mark.parametrize("layer", [None, LAYER], ids=["bare", "layer"])
@pytest.mark.parametrize("two", [False, True], ids=["one patch", "two patches"])
@pytest.mark.parametrize("degrees", [0.0, 90.0, 180.0, 25.0, -130.0])
def test_heat_of_steady_rolling_is_force_times_creepage(degrees: float, two: bool, layer: Any) -> None:
    motion = mtb.Rolling((1.5e-3, -5e-4, 0.0), angle=math.radians(degrees))
    result = mtb.solve_tangential(field(two=two), motion, mtb.Coulomb(0.3), layer)
    heat = float((result.dissipation * result.area).sum())
    assert heat == pytest.approx(float(result.force[:2] @ result.creepage[:2]), rel=1e-12)
    # along the cells no cell can lose: it slips along its own traction
    if degrees % 90.0 == 0.0:
        assert result.dissipation.min() > -1e-6 * result.dissipation.max()
    cellwise = float((result.traction[:2] * result.slip).sum(axis=0).ravel() @ result.area.ravel())
    # what the field mends: traction times slip in the same cell
    assert 0.3 * heat < cellwise < 0.97 * heat


@pytest.mark.parametrize("degrees", [0.0, 90.0, 180.0, 25.0])
@pytest.mark.parametrize("friction", [mtb.Coulomb(0.3), mtb.FallingFriction(0.4, 0.2, 2.0, memory=1e-4)])
def test_heat_with_spin_is_the_work_of_the_mean_traction(degrees: float, friction: mtb.Coulomb) -> None:
    motion = mtb.Rolling((5e-4, -2e-4, 0.4), angle=math.radians(degrees))
    result = mtb.solve_tangential(field(), motion, friction, LAYER)
    step = motion.step_vector((3e-4, 3e-4))
    work = 0.5 * (result.traction[:2] * (rigid(result) + rigid(result, step))).sum(axis=0) * result.area
    scale = np.abs(work).sum()
    assert (result.dissipation * result.area).sum() == pytest.approx(work.sum(), abs=1e-12 * scale)


@pytest.mark.parametrize("layer", [None, LAYER], ids=["bare", "layer"])
@pytest.mark.parametrize("degrees", [0.0, 90.0, 30.0])
@pytest.mark.parametrize("kind", ["transient", "shift"])
def test_heat_of_a_step_is_work_less_the_growth_of_the_elastic_energy(
    kind: str, degrees: float, layer: mtb.InterfaceLayer | None
) -> None:
    here = field()
    c, s = math.cos(math.radians(degrees)), math.sin(math.radians(degrees))
    if kind == "shift":
        motions: list[Any] = [mtb.Shift((2e-6 * c, 2e-6 * s)), mtb.Shift((-1e-6, 3e-6))]
        length, step = 1.0, (0.0, 0.0)
    else:
        first = mtb.Rolling((1e-3, 2e-4, 0.0), angle=math.radians(degrees), transient=True)
        motions = [first, replace(first, creepage=(-5e-4, 1e-3, 0.0))]
        step = first.step_vector(here.spacing)
        length = math.hypot(*step)
    state, before = None, np.zeros((2, *here.pressure.shape))
    for motion in motions:
        result = mtb.solve_tangential(here, motion, mtb.Coulomb(0.3), layer, state)
        after = result.traction[:2]
        mean = 0.5 * (after + before).sum(axis=(1, 2)) * result.area[0, 0]
        work = length * float(mean @ result.creepage[:2])
        growth = elastic_energy(here, after, layer) - elastic_energy(here, before, layer)
        heat = length * float((result.dissipation * result.area).sum())
        assert heat == pytest.approx(work - growth, abs=1e-11 * (abs(work) + abs(growth)))
        assert heat > -1e-9 * work
        state, before = result.state, after


def test_heat_of_unlike_bodies_and_of_a_line_contact() -> None:
    unlike = mtb.solve_tangential(field(upper=RUBBER), mtb.Rolling((2e-3, 0.0, 0.0)), mtb.Coulomb(0.3))
    # the pressure moves both surfaces along: without creepage that alone dissipates
    still = mtb.solve_tangential(field(upper=RUBBER), mtb.Rolling(), mtb.Coulomb(0.3))
    for result in (unlike, still):
        assert (result.dissipation * result.area).sum() > 0.0
    assert (still.dissipation * still.area).sum() > float(still.force[:2] @ still.creepage[:2])
    x = np.linspace(-1.0, 1.0, 41)[None]
    line = mtb.PressureField(5e8 * np.sqrt(1.0 - x**2), (1e-4, 1.0), STEEL, STEEL, reference=1.0)
    for angle in (0.0, math.pi):
        rolled = mtb.solve_tangential(line, mtb.Rolling((5e-4, 0.0, 0.0), angle=angle), mtb.Coulomb(0.3))
        heat = float((rolled.dissipation * rolled.area).sum())
        assert heat == pytest.approx(float(rolled.force[0] * 5e-4), rel=1e-12)


def test_where_it_arises_settles_with_the_cells() -> None:
    """Heat of the front and back halves converges, against a grid twice as fine as any compared."""

    def halves(n: int) -> np.ndarray:
        result = mtb.solve_tangential(field(n), mtb.Rolling((8e-4, 0.0, 0.0)), mtb.Coulomb(0.3))
        heat = result.dissipation * result.area
        ahead = result.points[0] > -1.5e-3
        return np.array([heat[ahead].sum(), heat[~ahead].sum()]) / heat.sum()

    found = {n: halves(n) for n in (16, 32, 64, 128)}
    error = [float(np.abs(found[n] - found[128]).max()) for n in (16, 32, 64)]
    assert error[2] < 0.6 * error[1] < 0.36 * error[0]


def test_wheels_tell_where_their_heat_arises() -> None:
    apart = []
    for spacing in (1e-3, 5e-4):
        contact = mtb.scenes.wheel_on_rail(force=80e3, spacing=spacing).prepare(friction=mtb.Coulomb(0.3))
        assert isinstance(contact, mtb.PreparedWheels)
        for speed in (20.0, -20.0):
            step = contact.step(velocity=[speed, 0.0, 0.0, 0.0, 1.002 * speed / 0.46, 0.0])
            (patch,) = step.patches
            total = float(patch.dissipation.sum() * patch.area)
            apart.append(abs(total / step.friction_power - 1.0))
            cellwise = float((patch.traction * patch.slip_velocity).sum() * patch.area)
            assert cellwise < 0.99 * total
            assert patch.dissipation[patch.pressure == 0.0].sum() * patch.area < 0.1 * total
    assert patch.plot("dissipation").axes[0].get_title(loc="left").endswith("W/m²")
    # the spin of a cone moves the two apart by a part of a cell
    assert apart[0] == pytest.approx(apart[1], rel=1e-5)
    assert apart[2] < 0.6 * apart[0] < 6e-3
