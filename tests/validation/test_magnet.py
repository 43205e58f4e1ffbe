# SPDX-License-Identifier: MIT OR Apache-2.0
"""A magnet whose pull follows the gap, against closed forms and scalar solves made here."""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import numpy as np
import pytest

import mtb_rs as mtb
from mtb_rs.bodies.mesh import block_mesh

# uniform states have no error of the cells
pytestmark = pytest.mark.coarse

MU0 = 4e-7 * np.pi
HEIGHT = 0.05
#: A curve of magnetisation that saturates at 1.6 T.
CURVE = ((200.0, 5e3, 4e4), (1.2, 1.5, 1.6 + 4e4 * MU0))


def field_of(density: float, curve: Any = CURVE) -> float:
    """Field [A/m] at a flux density [T], by bisection of the curve."""
    fields, densities = np.array([0.0, *curve[0]]), np.array([0.0, *curve[1]])
    low, high = 0.0, 1e8
    for _ in range(200):
        middle = 0.5 * (low + high)
        found = np.interp(middle, fields, densities) + MU0 * max(middle - fields[-1], 0.0)
        low, high = (middle, high) if found < density else (low, middle)
    return low


def flux_density(needed: Any, given: float) -> float:
    """Flux density [T] at which a rising magnetomotive force `needed` is `given`, by bisection."""
    low, high = 0.0, 10.0
    for _ in range(200):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if needed(middle) < given else (low, middle)
    return low


def plate(magnet: mtb.Magnet, gap: float = 0.0, modulus: float = 2e11) -> mtb.Scene:
    """A block without transverse strain, its face 4 cm by 4 cm, held at its top over a rigid plane."""
    x = np.linspace(-0.02, 0.02, 3)
    top = mtb.Support("top", x=0, y=0, z=0)
    block = mtb.ElasticBody(block_mesh(x, x, HEIGHT), mtb.Material(modulus, 0.0), "contact", [top])
    return mtb.Scene(
        block,
        mtb.Rigid(),
        gap=lambda x, y: np.full(x.shape, gap),
        spacing=0.02,
        sliding_direction=None,
        magnetic_pressure=magnet,
    )


def state_of(scene: mtb.Scene) -> tuple[float, float]:
    """The pull [Pa] and the gap [m] of a uniform state."""
    result = scene.solve()
    pull = result.magnetic_pressure
    assert pull is not None
    # hats press unevenly on elements as wide as they are; of the means that is left in second order
    assert np.ptp(pull) <= 1e-5 * pull.max()
    return float(pull.mean()), float(result.gap.mean())


@pytest.mark.parametrize(("ampere_turns", "length"), [(400.0, 0.0), (400.0, 0.1), (3e3, 0.1), (2e4, 0.1)])
def test_a_uniform_gap(ampere_turns: float, length: float) -> None:
    """The pull is B^2 / 2 mu0, with the flux density of one series of iron and gap."""
    layer, area = 5e-4, 1.6e-3
    yoke = (0.2, 1.5e-3)
    magnet = mtb.Magnet(ampere_turns, layer, iron=CURVE, pole_length=length, yoke=yoke)
    found, gap = state_of(plate(magnet, 2e-4))

    def needed(density: float) -> float:
        in_yoke = field_of(density * area / yoke[1]) * yoke[0]
        return field_of(density) * length + density * (gap + layer) / MU0 + in_yoke

    density = min(flux_density(needed, ampere_turns), 1.6)
    assert found == pytest.approx(density**2 / (2.0 * MU0), rel=1e-8)
    assert found <= magnet.limit * (1.0 + 1e-12)
    assert magnet.limit == pytest.approx(1.6**2 / (2.0 * MU0), rel=1e-12)


def test_named_iron_gives_1_86_mpa_at_most() -> None:
    """The steel of TEAM problem 13 is saturated at 2.16 T; its table goes on without a jump."""
    magnet = mtb.Magnet(1e9, 1e-4, pole_length=0.1)
    assert magnet.limit == pytest.approx(2.16**2 / (2.0 * MU0), rel=1e-12)
    assert state_of(plate(magnet))[0] == pytest.approx(magnet.limit, rel=1e-12)
    field, density = magnet.curve
    assert np.all(np.diff(density) > (1.0 - 1e-6) * MU0 * np.diff(field))
    # the measured points end at 1.8 T
    assert density[np.searchsorted(field, 9423.0)] == pytest.approx(1.8, abs=1e-3)


def test_the_pull_falls_as_the_gap_opens() -> None:
    """Without iron in its way the pull falls with the square of the distance."""
    magnet = mtb.Magnet(800.0, 5e-4)
    states = np.array([state_of(plate(magnet, gap)) for gap in np.linspace(0.0, 2e-3, 12)])
    assert all(a > b for a, b in pairwise(states[:, 0]))
    np.testing.assert_allclose(states[:, 0] * (states[:, 1] + 5e-4) ** 2, 0.5 * MU0 * 800.0**2, rtol=1e-9)


def test_a_wide_layer_leaves_a_constant_pressure() -> None:
    """Beside a layer that is not magnetic and very wide the gap does not matter: the pull is a number."""
    pressure, layer = 3e5, 1e5
    ampere_turns = np.sqrt(2.0 * pressure * MU0) * 2.0 * layer / MU0
    scene = mtb.scenes.pole_shoe_on_rail(magnetic_pressure=pressure, friction=0.3, spacing=6e-3)
    there = scene.solve(model="elastic-upper")
    here = scene.with_(magnetic_pressure=mtb.Magnet(ampere_turns, layer)).solve(model="elastic-upper")
    assert np.abs(here.pressure - there.pressure).max() <= 1e-8 * there.pressure.max()
    np.testing.assert_allclose(here.force, there.force, rtol=0.0, atol=1e-8 * abs(there.force[2]))


#: A plate magnet on a spring: stiffness [Pa/m] per area, gap [m] without pull, layer [m].
STIFFNESS, FREE, LAYER = 1e9, 1e-3, 5e-4
#: Magnetomotive force [A] above which it snaps on, where the distance has come down by a third.
PULL_IN = np.sqrt(8.0 * STIFFNESS * (FREE + LAYER) ** 3 / (27.0 * MU0))


#: The spring is a block: its hats press unevenly on elements as wide as they are, by this share.
OF_MESH = 2e-4


def sprung(ampere_turns: float, branch: Any = "apart") -> mtb.Scene:
    magnet = mtb.Magnet(ampere_turns, LAYER, iron=((1.0,), (1e3,)), branch=branch)
    return plate(magnet, FREE, STIFFNESS * HEIGHT)


@pytest.mark.parametrize("share", [0.3, 0.8, 0.97, 0.995])
def test_a_plate_on_a_spring_stays_apart_below_pull_in(share: float) -> None:
    """Equilibrium k (d0 - d) = mu0 NI^2 / 2 d^2, and the magnetic stiffness in parts of the spring's."""
    ampere_turns = share * PULL_IN
    result = sprung(ampere_turns).solve()
    whole = FREE + LAYER
    roots = np.roots([-STIFFNESS, STIFFNESS * whole, 0.0, -0.5 * MU0 * ampere_turns**2])
    distance = max(root.real for root in roots if abs(root.imag) < 1e-9 * whole)
    assert result.report.contact_area == 0.0
    # the magnet makes the error of the spring larger by as much as it makes it softer
    snap_share = 2.0 * (whole - distance) / distance
    amplified = 3.0 * OF_MESH / (1.0 - snap_share)
    np.testing.assert_allclose(result.gap, distance - LAYER, atol=amplified * (whole - distance))
    assert result.report.magnet["snap_share"] == pytest.approx(snap_share, rel=amplified + 1e-3)
    assert result.report.magnet["residual"] <= 1e-10
    # what has snapped on stays: the contact carries the pull less the spring
    on = sprung(ampere_turns, "touching").solve()
    kept = 0.5 * MU0 * (ampere_turns / LAYER) ** 2 - STIFFNESS * FREE
    if kept > 0.0:
        assert on.normal_force == pytest.approx(kept * 1.6e-3, abs=OF_MESH * STIFFNESS * FREE * 1.6e-3)
        assert "two states" in " ".join(on.report.notes)
        assert "two states" in " ".join(result.report.notes)
    else:
        np.testing.assert_allclose(on.gap, result.gap, rtol=1e-7)
        assert not result.report.notes


@pytest.mark.parametrize("share", [1.001, 1.01, 1.5])
def test_a_plate_on_a_spring_snaps_on_above_pull_in(share: float) -> None:
    """Above the pull-in of the closed form there is one state only, and it is closed."""
    ampere_turns = share * PULL_IN
    kept = 0.5 * MU0 * (ampere_turns / LAYER) ** 2 - STIFFNESS * FREE
    for branch in ("apart", "touching"):
        result = sprung(ampere_turns, branch).solve()
        assert result.report.contact_area == pytest.approx(1.6e-3)
        assert result.normal_force == pytest.approx(kept * 1.6e-3, abs=OF_MESH * STIFFNESS * FREE * 1.6e-3)
        assert "two states" not in " ".join(result.report.notes)


def test_steps_keep_what_has_touched() -> None:
    """A magnet that is lowered snaps on at one gap and lets go at another: both of the closed form."""
    ampere_turns = 0.8 * PULL_IN
    contact = sprung(ampere_turns).prepare()
    heights = np.linspace(0.0, -4e-4, 41)
    force = 0.5 * MU0 * ampere_turns**2
    # with a free distance D it snaps on where 4 k D^3 / 27 is the constant of the pull,
    on = np.cbrt(27.0 * force / (4.0 * STIFFNESS)) - (FREE + LAYER)
    # and lets go where the spring at the touching distance pulls as much as the magnet
    off = force / LAYER**2 / STIFFNESS - FREE
    assert -4e-4 < on < 0.0 < off
    touched = [bool(contact.step(gap=z).force[2] < 0.0) for z in heights]
    first = heights[touched.index(True)]
    assert first == pytest.approx(on, abs=1.1e-5)
    rising = np.linspace(-4e-4, 1.2 * off, 60)
    kept = [bool(contact.step(gap=z).force[2] < 0.0) for z in rising]
    assert rising[kept.index(False)] == pytest.approx(off, abs=1.1 * (rising[1] - rising[0]))
    # without a memory, a step is that of bodies that stand apart
    assert contact.copy().step(gap=0.5 * off).force[2] == 0.0
    # and with the state of another one it goes on from it
    state = contact.step(gap=-4e-4).state
    assert contact.copy().step(gap=0.0, state=state).force[2] < 0.0
