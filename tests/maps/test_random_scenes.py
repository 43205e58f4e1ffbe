# SPDX-License-Identifier: MIT OR Apache-2.0
"""Scenes drawn at random over all maps: what is returned obeys the laws of contact, or it is not returned.

The laws are checked from the fields of the result alone: gaps from displacements, forces from sums.
"""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import HealthCheck, event, given, settings
from hypothesis import strategies as st

import mtb_rs as mtb
from mtb_rs.half_space import reference

MODEST = settings(
    max_examples=25,
    deadline=None,
    derandomize=True,
    suppress_health_check=[HealthCheck.too_slow, HealthCheck.filter_too_much],
)

moduli = st.floats(6.0, 12.0).map(lambda e: 10.0**e)
ratios = st.floats(0.0, 0.49)
materials = st.builds(mtb.Material, moduli, ratios)
bodies = st.one_of(materials, st.just(mtb.Rigid()))
lengths = st.floats(-6.0, 3.0).map(lambda e: 10.0**e)
angles = st.floats(0.0, 2.0 * np.pi)
seeds = st.integers(0, 2**31)


def told(refusal: Exception) -> None:
    """A refusal names what is wrong."""
    event(f"refused: {str(refusal)[:40]}")
    assert len(str(refusal)) > 20


def check_contact(result: mtb.Result, *, moved: bool) -> None:
    """Signorini's conditions, Coulomb's law in sliding, status, and the sums."""
    p, gap = result.pressure.ravel(), result.gap.ravel()
    shift = 0.0 if moved else np.asarray(result.approach, dtype=float)
    u = result.displacement.upper - result.displacement.lower
    normal = result.normal
    opened = result.initial_gap + (u * normal).sum(axis=0) - shift * normal[2]
    scale = max(
        float(np.abs(result.displacement.upper).max()),
        float(np.abs(result.displacement.lower).max()),
        float(np.ptp(result.initial_gap)),
        float(np.abs(shift)),
    )
    assert result.report.converged
    assert p.min() >= 0.0
    assert np.abs(opened.ravel() - gap).max() <= 1e-8 * scale
    assert gap.min() >= -1e-8 * scale
    assert np.abs(gap[p > 0.0]).max(initial=0.0) <= 1e-8 * scale
    assert ((result.status.ravel() > 0) == (p > 0.0)).all()
    load = result.traction - result.pressure * normal
    force = (load * result.area).reshape(3, -1).sum(axis=1)
    assert np.linalg.norm(force - result.force) <= 2e-3 * np.linalg.norm(force)  # frames of curved points
    assert abs(float((result.pressure * result.area).sum()) / result.normal_force - 1.0) < 1e-9
    assert result.report.force_balance["relative_error"] < 1e-8


@pytest.mark.coarse
@MODEST
@given(
    seed=seeds,
    length=lengths,
    lower=bodies,
    upper=bodies,
    friction=st.floats(0.0, 1.5),
    angle=angles,
    flatness=st.floats(-6.0, -1.0),
    load=st.floats(-6.0, -2.0),
    press=st.booleans(),
)
def test_half_spaces(
    seed: int,
    length: float,
    lower: mtb.Material | mtb.Rigid,
    upper: mtb.Material | mtb.Rigid,
    friction: float,
    angle: float,
    flatness: float,
    load: float,
    press: bool,
) -> None:
    rng = np.random.default_rng(seed)
    nx, ny = rng.integers(4, 14, 2)
    x, y = np.linspace(-1.0, 1.0, nx), np.linspace(-1.0, 1.0, ny)
    rough = 0.05 * rng.standard_normal((ny, nx))
    gap = 10.0**flatness * length * (x[None] ** 2 + y[:, None] ** 2 + rough - rough.min())
    soft = min((b.young_modulus for b in (lower, upper) if isinstance(b, mtb.Material)), default=1.0)
    given_load: dict[str, float] = (
        {"force": 10.0 ** (load + flatness) * soft * length**2}
        if press
        else {"approach": float(gap.min() + 10.0**load * np.ptp(gap) + 1e-12 * length)}
    )
    try:
        scene = mtb.Scene(
            upper=upper,
            lower=lower,
            gap=gap,
            spacing=(2.0 * length / nx, 2.0 * length / ny),
            friction=friction,
            sliding_direction=(float(np.cos(angle)), float(np.sin(angle))),
            **given_load,  # type: ignore[arg-type]
        )
        result = scene.solve("half-space")
    except (ValueError, mtb.ConvergenceError) as refusal:
        told(refusal)
        return
    event("solved")
    check_contact(result, moved=False)
    tangential = result.traction[:2]
    expected = friction * result.pressure * np.array([np.cos(angle), np.sin(angle)])[:, None, None]
    assert np.abs(tangential - expected).max() <= 1e-9 * result.pressure.max()
    if press:
        assert abs(result.normal_force / given_load["force"] - 1.0) < 1e-9


@pytest.mark.coarse
@settings(MODEST, max_examples=20)
@given(
    slenderness=st.floats(0.2, 5.0),
    friction=st.one_of(st.floats(0.0, 0.3), st.floats(0.0, 2.0)),
    angle=angles,
    length=st.floats(-3.0, 0.0).map(lambda e: 10.0**e),
    lower=bodies,
    supports=st.sampled_from(["clamped-top", "driven-top"]),
    ratio=ratios,
    cells=st.integers(3, 6),
)
@pytest.mark.filterwarnings("ignore:the (upper|lower) body deforms")
def test_elastic_blocks(
    slenderness: float,
    friction: float,
    angle: float,
    length: float,
    lower: mtb.Material | mtb.Rigid,
    supports: str,
    ratio: float,
    cells: int,
) -> None:
    try:
        result = mtb.scenes.block_on_plane(
            width=length,
            height=slenderness * length,
            spacing=length / cells,
            friction=friction,
            sliding_direction=(float(np.cos(angle)), float(np.sin(angle))),
            supports=supports,
            upper=mtb.Material(2e11, ratio),
            lower=lower,
        ).solve("elastic-upper")
    except (ValueError, mtb.ConvergenceError) as refusal:
        told(refusal)
        return
    event("solved")
    # fields of hats are means over the points: the gap is the solver's, pressure and sums are checked
    p = result.pressure.ravel()
    # on a rigid plane a block may carry just its pull and not move at all
    alone = 3e6 * slenderness * length / 2e11
    scale = max(alone, float(np.abs(result.displacement.upper).max()))
    assert result.report.converged
    assert p.min() >= 0.0
    assert result.gap.min() >= -1e-8 * scale
    assert np.abs(result.gap.ravel()[p > 0.0]).max(initial=0.0) <= 1e-8 * scale
    assert ((result.status.ravel() > 0) == (p > 0.0)).all()
    opened = result.initial_gap + result.displacement.upper[2] - result.displacement.lower[2]
    assert np.abs(opened - result.gap).max() <= 1e-6 * scale
    if supports == "driven-top":
        assert abs(result.normal_force / (3e6 * length**2) - 1.0) < 1e-8
    assert (
        abs(float(np.linalg.norm(result.force[:2])) / result.normal_force - friction) < 1e-9 + 1e-9 * friction
    )


@MODEST
@pytest.mark.coarse
@pytest.mark.filterwarnings("ignore:.*(deforms by|beyond what steel bears)")
@given(
    seed=seeds,
    side=st.integers(4, 48),
    length=lengths,
    hurst=st.floats(0.1, 1.0),
    load=st.floats(-5.0, 0.7),
    periodic=st.booleans(),
    method=st.sampled_from(["auto", "dense", "fft"]),
)
def test_rough_surfaces(
    seed: int, side: int, length: float, hurst: float, load: float, periodic: bool, method: str
) -> None:
    if method == "dense":
        side = min(side, 16)
    step = length / side
    heights = mtb.roughness(side, step, hurst=hurst, rms_slope=0.1, seed=seed)
    force = 10.0**load * 0.1 * mtb.steel.plane_strain_modulus * length**2
    try:
        result = mtb.solve_normal(
            heights.max() - heights,
            step,
            lower=mtb.steel,
            upper=mtb.Rigid(),
            force=force,
            periodic=periodic,
            edge="auto" if periodic else "sharp",
            method=method,
            tolerance=1e-9,
        )
    except (ValueError, mtb.ConvergenceError) as refusal:
        told(refusal)
        return
    event("solved")
    scale = float(np.ptp(heights))
    touching = result.pressure > 0.0
    assert result.pressure.min() >= 0.0
    assert abs(result.pressure.sum() * step**2 / force - 1.0) < 1e-8
    assert np.abs(result.gap[touching]).max() < 1e-5 * scale
    assert result.gap.min() > -1e-5 * scale
    assert ((result.status > 0) == touching).all()


@MODEST
@given(
    seed=seeds,
    friction=st.floats(0.01, 1.0),
    size=st.floats(-1.5, 1.5),
    aspect=st.floats(-0.7, 0.7),
    rolls=st.booleans(),
)
def test_stick_and_slip(seed: int, friction: float, size: float, aspect: float, rolls: bool) -> None:
    rng = np.random.default_rng(seed)
    body = mtb.Material.from_shear_modulus(82e9, 0.28)
    a, b = 3e-3 * 10.0**aspect, 3e-3
    patch = reference.elliptic_pressure(1e4, (a, b), (int(rng.integers(6, 24)), 14), body, body)
    drive = rng.standard_normal(3)
    drive *= friction * 1e4 / (a * b * 82e9) * 10.0**size / np.linalg.norm(drive)
    motion: mtb.Rolling | mtb.Shift
    if rolls:
        motion = mtb.Rolling(creepage=(drive[0], drive[1], drive[2] / np.sqrt(a * b)))
    else:
        motion = mtb.Shift(displacement=(drive[0] * a, drive[1] * a))
    try:
        result = mtb.solve_tangential(patch, motion, mtb.Coulomb(friction), tolerance=1e-9)
    except mtb.ConvergenceError as refusal:
        told(refusal)
        return
    event("solved")
    bound = friction * patch.pressure
    size_of = np.linalg.norm(result.traction[:2], axis=0)
    slip = np.linalg.norm(result.slip, axis=0)
    top = bound.max()
    assert (size_of <= bound + 1e-7 * top).all()
    slipping, open_ = result.status == 2, result.status == 0
    assert (open_ == (patch.pressure == 0.0)).all()
    assert np.abs(size_of - bound)[slipping].max(initial=0.0) <= 1e-6 * top
    # friction opposes the lower body's lag: along the slip of the upper one
    along = (result.traction[:2] * result.slip).sum(axis=0)
    assert (along[slipping] >= (1.0 - 1e-5) * (size_of * slip)[slipping] - 1e-7 * top * slip.max()).all()
    area = patch.spacing[0] * patch.spacing[1]
    total = result.traction[:2].reshape(2, -1).sum(axis=1) * area
    assert np.abs(total - result.force[:2]).max() <= 1e-9 * friction * 1e4
