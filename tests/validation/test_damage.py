# SPDX-License-Identifier: MIT OR Apache-2.0
"""Numbers of damage: against the work of friction, Hertz' closed form, and each other."""

from typing import Any

import numpy as np
import pytest

import mtb_rs as mtb

A, B, LOAD, MU = 6e-3, 4e-3, 80e3, 0.3


def pressed(cells: int = 24) -> mtb.NormalResult:
    hertz = mtb.hertz(LOAD, semi_axes=(A, B), lower=mtb.steel, upper=mtb.steel)
    return hertz.on_grid((cells, cells), (2.2 * A / cells, 2.2 * B / cells))


def rolled(creepage: tuple[float, float, float]) -> list[Any]:
    """By the full theory and by both quick ones."""
    normal = pressed()
    return [
        mtb.solve_tangential(normal, mtb.Rolling(creepage, velocity=20.0), mtb.Coulomb(MU)),
        mtb.fastsim(normal, creepage, mtb.Coulomb(MU)),
        mtb.fastrip(normal, creepage, mtb.Coulomb(MU)),
    ]


def test_t_gamma_is_the_work_of_friction() -> None:
    """Per distance: without spin the heat of steady rolling, exactly."""
    full, *quick = rolled((1e-3, 5e-4, 0.0))
    assert full.t_gamma() == pytest.approx(float((full.dissipation * full.area).sum()), rel=1e-9)
    assert full.t_gamma(with_spin=True) == full.t_gamma()
    for result in quick:
        assert result.t_gamma() == pytest.approx(full.t_gamma(), rel=0.1)
    # saturated: mu N times the creepage
    for result in rolled((0.05, 0.0, 0.0)):
        load = -result.force[2]
        assert result.t_gamma() == pytest.approx(MU * load * 0.05, rel=0.03)


def test_spin_counts_if_asked() -> None:
    full = rolled((5e-4, 0.0, 0.5))[0]
    with_spin = full.t_gamma() + abs(full.spin_moment * 0.5)
    assert full.t_gamma(with_spin=True) == pytest.approx(with_spin, rel=1e-12)
    # the cells' own heat is off by the first order
    heat = float((full.dissipation * full.area).sum())
    assert full.t_gamma(with_spin=True) == pytest.approx(heat, rel=0.1)


def test_the_fatigue_index_on_an_ellipse() -> None:
    """mu - 2 pi a b k / (3 Fz), as published."""
    k = 300e6
    full = rolled((2e-3, 0.0, 0.0))[0]
    load = -full.force[2]
    index = np.hypot(*full.force[:2]) / load - 2.0 * np.pi * A * B * k / (3.0 * load)
    assert full.surface_fatigue_index(k) == pytest.approx(index, abs=3e-3)
    friction, over = full.shakedown(k)
    assert full.surface_fatigue_index(k) == pytest.approx(friction - 1.0 / over, rel=1e-12)
    assert over == pytest.approx(1.5 * load / (np.pi * A * B * k), rel=5e-3)


def test_patches_of_wheels() -> None:
    contact = mtb.scenes.wheel_on_rail(spacing=0.5e-3).prepare()
    assert isinstance(contact, mtb.PreparedWheels)
    patch = contact.step(velocity=(20.0, 0.0, 0.0, 0.0, 20.0 / 0.4605, 0.0)).patches[0]
    power = patch.friction_power / abs(patch.rolling_speed)
    assert patch.t_gamma(with_spin=True) == pytest.approx(power, rel=0.1)
    assert patch.shakedown(300e6)[1] == pytest.approx(patch.pressure.max() / 300e6, rel=1e-12)


def test_the_damage_of_a_rail() -> None:
    assert mtb.rail_damage([0.0, 15.0, 40.0, 65.0, 120.0, 175.0]) == pytest.approx([0, 0, 0.5, 1, 0.5, 0])
    assert mtb.rail_damage(285.0) == pytest.approx(-1.0)


def test_what_cannot_be_is_refused() -> None:
    with pytest.raises(ValueError, match=r"^t_gamma is -1 N: numbers of at least 0 are needed"):
        mtb.rail_damage([1.0, -1.0])
    shifted = mtb.solve_tangential(pressed(), mtb.Shift((1e-6, 0.0)), mtb.Coulomb(MU))
    with pytest.raises(ValueError, match=r"^a shift passes over nothing"):
        shifted.t_gamma()
    with pytest.raises(ValueError, match=r"^shear_yield is 0.0: a positive number"):
        rolled((1e-3, 0.0, 0.0))[0].surface_fatigue_index(0.0)
