# SPDX-License-Identifier: MIT OR Apache-2.0
"""Rounding below zero does not turn the colours of a map, at any size of the values."""

from __future__ import annotations

import numpy as np
import pytest

from mtb_rs.pictures.maps import _title
from mtb_rs.pictures.quantities import colour_scale
from mtb_rs.results.fields import FIELDS

VALUES = np.linspace(0.0, 4e5, 50)
ASKED = FIELDS["dissipation"]


@pytest.mark.parametrize("size", [1e-9, 1.0, 1e6])
@pytest.mark.parametrize("low", [0.0, -1e-9, -1e-3])
def test_rounding_below_zero_has_no_sign(size: float, low: float) -> None:
    values = np.append(VALUES, low) * size
    limits = (float(values.min()), float(values.max()))
    for scale in (colour_scale(values, ASKED), colour_scale(values, ASKED, limits)):
        assert scale.colours == "viridis"
        assert scale.norm.vmin == pytest.approx(0.0, abs=1e-6)
    assert " to " not in _title("dissipation", values, "Pa")
    # nor what three digits of the largest do not show
    values[-1] = -1e-5 * values.max()
    assert _title("dissipation", values, "Pa").startswith("dissipation, largest ")


@pytest.mark.parametrize(("low", "colours"), [(-0.01, "viridis"), (-0.1, "RdBu_r"), (-1.0, "RdBu_r")])
def test_true_negatives_have_one(low: float, colours: str) -> None:
    assert colour_scale(np.append(VALUES, low * VALUES.max()), ASKED).colours == colours
    assert colour_scale(-VALUES, ASKED).colours == "viridis_r"
