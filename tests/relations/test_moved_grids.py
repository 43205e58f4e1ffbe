# SPDX-License-Identifier: MIT OR Apache-2.0
"""Contacts on grids, mirrored, turned, scaled, raised, or with their bodies exchanged."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import mtb_rs as mtb

# bodies are made twenty and forty times as stiff
pytestmark = pytest.mark.filterwarnings("ignore:young_modulus of the")

FEW = settings(max_examples=6, deadline=None, derandomize=True)
SPACING, SHAPE = (1e-4, 1.5e-4), (11, 16)
SOFT, STIFF = (2e10, 0.1), (2.1e11, 0.3)

#: How fields (ny, nx) and vectors in the plane turn, and whether the bodies change places.
TURNS: dict[str, tuple[np.ndarray, bool]] = {
    "mirror x": (np.diag([-1.0, 1.0]), False),
    "mirror y": (np.diag([1.0, -1.0]), False),
    "about": (np.diag([-1.0, -1.0]), False),
    "left": (np.array([[0.0, -1.0], [1.0, 0.0]]), False),
    "transposed": (np.array([[0.0, 1.0], [1.0, 0.0]]), False),
    "over": (np.diag([1.0, -1.0]), True),
    "exchanged": (np.eye(2), True),
}


def field(turn: np.ndarray, values: np.ndarray) -> np.ndarray:
    """A field (..., ny, nx) turned."""
    if turn[0, 0] == 0.0:
        values, turn = np.swapaxes(values, -1, -2), turn @ [[0.0, 1.0], [1.0, 0.0]]
    return values[..., :: int(turn[1, 1]), :: int(turn[0, 0])]


def vectors(turn: np.ndarray, values: np.ndarray) -> np.ndarray:
    """A field of vectors (2, ny, nx) turned."""
    return np.tensordot(turn, field(turn, values), axes=1)


def rough(seed: int) -> np.ndarray:
    x, y = (np.arange(n) - 0.5 * (n - 1) for n in SHAPE[::-1])
    bowl = (x * SPACING[0]) ** 2 / 0.1 + (y[:, None] * SPACING[1]) ** 2 / 0.14
    return bowl + 3e-7 * np.random.default_rng(seed).random(SHAPE)


def bodies(swaps: bool, stiff: float = 1.0) -> dict[str, Any]:
    low, high = (mtb.Material(stiff * e, nu) for e, nu in (SOFT, STIFF))
    return {"lower": high, "upper": low} if swaps else {"lower": low, "upper": high}


def pressed(gap: np.ndarray, spacing: Any = SPACING, **given: Any) -> mtb.NormalResult:
    return mtb.solve_normal(gap, spacing, tolerance=1e-12, **{"force": 40.0, "edge": "sharp", **given})


def close(found: Any, wanted: Any, tolerance: float) -> None:
    size = max(float(np.abs(wanted).max()), 1e-300)
    np.testing.assert_allclose(found, wanted, rtol=0, atol=tolerance * size)


@pytest.mark.parametrize("name", TURNS)
@FEW
@given(
    seed=st.integers(0, 99),
    way=st.sampled_from(
        [{"force": 40.0}, {"force": None, "approach": 3e-6}, {"moments_about_axes": (1e-3, 2e-3)}]
    ),
    method=st.sampled_from(["dense", "fft"]),
    periodic=st.booleans(),
)
def test_pressure_turns_with_its_gap(
    name: str, seed: int, way: dict[str, Any], method: str, periodic: bool
) -> None:
    turn, swaps = TURNS[name]
    periodic = periodic and method == "fft" and way == {"force": 40.0}
    gap, moved = rough(seed), dict(way)
    if "moments_about_axes" in way:
        # (my, -mx), first moments of the pressure along x and y, are a vector in the plane
        about_x, about_y = way["moments_about_axes"]
        along = turn @ np.array([about_y, -about_x])
        moved["moments_about_axes"] = (-along[1], along[0])
    sides = tuple(np.abs(turn) @ SPACING)
    own = pressed(gap, **way, method=method, periodic=periodic, **bodies(False))
    image = pressed(field(turn, gap), sides, **moved, method=method, periodic=periodic, **bodies(swaps))
    close(image.pressure, field(turn, own.pressure), 1e-7)
    close(image.gap, field(turn, own.gap), 1e-7)
    assert image.approach == pytest.approx(own.approach, rel=1e-8)


@FEW
@given(
    seed=st.integers(0, 99),
    size=st.sampled_from([1e-4, 0.3, 700.0]),
    stiff=st.sampled_from([1e-3, 40.0]),
    raised=st.floats(-1e-5, 1e-5),
    method=st.sampled_from(["dense", "fft"]),
)
def test_pressure_scales_and_does_not_know_its_height(
    seed: int, size: float, stiff: float, raised: float, method: str
) -> None:
    own = pressed(rough(seed), method=method, **bodies(False))
    sides = tuple(size * s for s in SPACING)
    force = stiff * size**2 * 40.0
    image = pressed(size * (rough(seed) + raised), sides, force=force, method=method, **bodies(False, stiff))
    close(image.pressure, stiff * own.pressure, 1e-7)
    assert image.approach == pytest.approx(size * (own.approach + raised), rel=1e-7, abs=1e-9 * size * 1e-5)


MOTIONS: dict[str, dict[str, Any]] = {
    "steady": {"creepage": (6e-4, -3e-4, 0.5), "angle": 0.0},
    "aslant": {"creepage": (4e-4, 2e-4, -0.8), "angle": np.pi / 2},
    "a step": {"creepage": (6e-4, 3e-4, 0.4), "angle": 0.0, "transient": True},
    "by force": {"creepage": (0.0, 2e-4, 0.0), "force": (3.0, None), "angle": 0.0},
    "shift": {"displacement": (3e-7, -2e-7), "spin": 2e-4},
}


def moving(
    name: str, turn: np.ndarray, swaps: bool, size: float = 1.0, stiff: float = 1.0
) -> mtb.Rolling | mtb.Shift:
    """The motion of the upper body over the lower one, turned; or of the other one, if they change places."""
    given, det = MOTIONS[name], float(np.linalg.det(turn))
    sign = -1.0 if swaps else 1.0
    if name == "shift":
        along = tuple(size * sign * turn @ given["displacement"])
        return mtb.Shift(along, spin=sign * det * given["spin"])
    xi, eta, phi = given["creepage"]
    angle, (x, y) = given["angle"], sign * turn @ [xi, eta]
    ahead = turn @ [np.cos(angle), np.sin(angle)]
    force = None
    if "force" in given:
        pulled = stiff * size**2 * sign * turn @ [given["force"][0], 0.0]
        force = (pulled[0], None) if turn[0, 0] else (None, pulled[1])
    return mtb.Rolling(
        (x, y, sign * det * phi / size),
        force,
        angle=float(np.arctan2(ahead[1], ahead[0])),
        transient=given.get("transient", False),
        step=size * 1e-4,
    )


@pytest.mark.parametrize("motion", MOTIONS)
@pytest.mark.parametrize("name", TURNS)
@FEW
@given(seed=st.integers(0, 9), coupling=st.sampled_from(["one-way", "full"]), layered=st.booleans())
def test_tractions_turn_with_their_contact(
    motion: str, name: str, seed: int, coupling: Any, layered: bool
) -> None:
    turn, swaps = TURNS[name]
    sign = -1.0 if swaps else 1.0
    coefficient = 0.2 + 0.1 * np.random.default_rng(seed).random(SHAPE)
    options: dict[str, Any] = {"coupling": coupling, "tolerance": 1e-10}
    options["layer"] = mtb.InterfaceLayer(1e-5, 1e10) if layered else None
    own = mtb.solve_tangential(
        pressed(rough(seed), **bodies(False)),
        moving(motion, np.eye(2), False),
        mtb.Coulomb(coefficient),
        **options,
    )
    image = mtb.solve_tangential(
        pressed(field(turn, rough(seed)), tuple(np.abs(turn) @ SPACING), **bodies(swaps)),
        moving(motion, turn, swaps),
        mtb.Coulomb(field(turn, coefficient)),
        **options,
    )
    rough_too = 1e-6 if coupling == "one-way" else 1e-4
    size = np.abs(own.traction).max()
    close(image.traction[:2] / size, sign * vectors(turn, own.traction[:2]) / size, rough_too)
    close(image.force[:2] / 40.0, sign * turn @ own.force[:2] / 40.0, rough_too)
    moment = sign * np.linalg.det(turn) * own.spin_moment
    assert image.spin_moment == pytest.approx(moment, rel=10 * rough_too, abs=1e-8 * 40.0)
    np.testing.assert_allclose(
        image.dissipation, field(turn, own.dissipation), rtol=0, atol=10 * rough_too * own.dissipation.max()
    )


@pytest.mark.parametrize("motion", MOTIONS)
@pytest.mark.parametrize(("size", "stiff"), [(1e-3, 20.0), (500.0, 0.01)])
def test_tractions_scale(motion: str, size: float, stiff: float) -> None:
    sides = tuple(size * s for s in SPACING)
    small = pressed(rough(3), **bodies(False))
    large = pressed(size * rough(3), sides, force=stiff * size**2 * 40.0, **bodies(False, stiff))
    own = mtb.solve_tangential(small, moving(motion, np.eye(2), False), mtb.Coulomb(0.3))
    image = mtb.solve_tangential(large, moving(motion, np.eye(2), False, size, stiff), mtb.Coulomb(0.3))
    close(image.traction, stiff * own.traction, 1e-6)
    close(image.force, stiff * size**2 * own.force, 1e-6)
    close(image.slip, (size if motion == "shift" else 1.0) * own.slip, 1e-5)
    assert image.spin_moment == pytest.approx(stiff * size**3 * own.spin_moment, rel=1e-5)
