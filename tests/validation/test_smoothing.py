# SPDX-License-Identifier: MIT OR Apache-2.0
"""Smoothed profiles: the closed form of the filter, kinks, contact on noisy, smoothed and exact profiles."""

from __future__ import annotations

import pickle
import warnings

import numpy as np
import pytest
from numpy.typing import NDArray

import mtb_rs as mtb

Array = NDArray[np.float64]
WHEEL, RAIL = mtb.Profile.standard("S1002"), mtb.Profile.standard("60E1")


def measured(exact: mtb.Profile, low: float, high: float, noise: float, seed: int) -> mtb.Profile:
    """Points every 0.1 mm along the profile with noise normal to it, as instruments measure."""
    s = np.arange(float(exact.arc_length(low)), float(exact.arc_length(high)), 1e-4)
    y = exact.position(s)
    points = np.array([y, exact.height(y)])
    points += noise * np.random.default_rng(seed).standard_normal(y.size) * exact.normal(y)
    return mtb.Profile.from_points(*points, name=exact.name)


@pytest.mark.parametrize("length", [2e-3, 4e-3, 8e-3, 20e-3])
def test_waves_keep_the_share_of_two_smoothing_splines(length: float) -> None:
    y = np.arange(-30e-3, 30e-3, 1e-4)
    wave = 1e-6 * np.sin(2.0 * np.pi * y / length)
    found = mtb.Profile.from_points(y, wave).smoothed(4e-3, kinks=())
    inner = np.abs(y) < 20e-3
    share = (found.height(y[inner]) @ wave[inner]) / (wave[inner] @ wave[inner])
    x = (1.0 + np.sqrt(2.0)) * (4e-3 / length) ** 4
    assert share == pytest.approx(1.0 - (x / (1.0 + x)) ** 2, abs=2e-3)


def test_the_residual_is_that_of_the_points() -> None:
    noisy = measured(RAIL, -0.0355, 0.0355, 5e-6, 1)
    found = noisy.smoothed()
    smoothing = found.smoothing
    assert smoothing is not None
    assert noisy.smoothing is None
    # 5 um of noise, of which a share of all waves stays in the smoothed profile
    assert 4.7e-6 < smoothing.rms < 5.3e-6
    assert 2.5 * smoothing.rms < smoothing.largest < 5.0 * smoothing.rms
    assert smoothing.kinks.size == 0
    # the largest one, measured again from the profile itself
    slope = found.slope(smoothing.y)
    away = (smoothing.z - found.height(smoothing.y)) / np.hypot(1.0, slope)
    assert np.abs(away).max() == pytest.approx(smoothing.largest, rel=0.02)
    assert smoothing.y[np.abs(away).argmax()] == smoothing.at
    assert pickle.loads(pickle.dumps(found)) == found
    with pytest.raises(ValueError, match="made of formulas"):
        RAIL.smoothed()
    for wavelength, words in ((1e-5, "at least twice that"), (1.0, "longer than that")):
        with pytest.raises(ValueError, match=words):
            noisy.smoothed(wavelength)
    with pytest.raises(ValueError, match=r"kinks\[1\] is 0.05 m"):
        noisy.smoothed(kinks=[0.0, 0.05])
    with pytest.raises(ValueError, match=r"kinks\[0\] and kinks\[2\] .* one point"):
        noisy.smoothed(kinks=[0.0, 5e-3, 1e-6])
    with pytest.raises(ValueError, match="needs 5"):
        noisy.smoothed(kinks=[0.0, 3e-4])


def roof(y: Array, angle: float) -> Array:
    """Two arcs of 80 mm radius that meet at y = 3 mm at an angle."""
    bent = -(y**2) / 0.16
    return np.asarray(bent - np.tan(angle) * np.maximum(0.0, y - 3e-3))


@pytest.mark.parametrize("noise", [0.0, 5e-6])
def test_kinks_are_recognised_and_kept(noise: float) -> None:
    y = np.arange(-25e-3, 25e-3, 2e-4)
    z = roof(y, np.radians(25.0)) + noise * np.random.default_rng(2).standard_normal(y.size)
    profile = mtb.Profile.from_points(y, z, name="roof")
    for found in (profile.smoothed(), profile.smoothed(kinks=[3e-3])):
        smoothing = found.smoothing
        assert smoothing is not None
        assert smoothing.kinks == pytest.approx([3e-3], abs=2.5e-4)
        assert np.degrees(smoothing.kink_angles) == pytest.approx([-25.0], abs=1.5)
        inner = y[5:-5]
        off = np.abs(found.height(inner) - roof(inner, np.radians(25.0)))
        # splines end without curvature, which bends arcs of 80 mm by some (wavelength / 2 pi)^2 / 80 mm there
        assert off.max() < noise + (4e-3 / (2.0 * np.pi)) ** 2 / 0.08
    # taken for no kink it is rounded
    rounded = profile.smoothed(kinks=())
    inner = y[5:-5]
    assert np.abs(rounded.height(inner) - roof(inner, np.radians(25.0))).max() > 50e-6
    # a jump of curvature is no kink
    assert measured(RAIL, -0.0355, 0.0355, 2e-6, 3).smoothed().smoothing.kinks.size == 0  # type: ignore[union-attr]
    assert measured(WHEEL, -0.06, 0.058, 2e-6, 3).smoothed().smoothing.kinks.size == 0  # type: ignore[union-attr]


def peak(wheel: mtb.Profile, rail: mtb.Profile, lateral: float) -> float:
    scene = mtb.scenes.wheel_on_rail(
        wheel, rail, lateral=lateral, force=36e3, spacing=2e-4, gauge_depth=12e-3
    )
    return float(scene.solve().pressure.max())


@pytest.mark.coarse
@pytest.mark.slow
@pytest.mark.parametrize(("lateral", "tolerance"), [(0.0, 0.1), (1e-3, 0.03), (3e-3, 0.03), (6.2e-3, 0.1)])
def test_contact_on_smoothed_profiles_is_that_on_exact_ones(lateral: float, tolerance: float) -> None:
    """At 0 and 6.2 mm the contact lies over a jump of curvature, which smoothing rounds."""
    exact = peak(WHEEL, RAIL, lateral)
    noisy = measured(WHEEL, -0.06, 0.058, 2e-6, 5), measured(RAIL, -0.0359, 0.0355, 2e-6, 6)
    with warnings.catch_warnings():
        # that steel does not bear it
        warnings.simplefilter("ignore")
        raw = peak(*noisy, lateral)
    smooth = peak(noisy[0].smoothed(), noisy[1].smoothed(), lateral)
    # what 2 um of noise make of the raw table
    assert raw > 1.3 * exact
    assert smooth == pytest.approx(exact, rel=tolerance)
