# SPDX-License-Identifier: MIT OR Apache-2.0
"""One palette everywhere: that of the package's own pictures."""

from __future__ import annotations

from matplotlib import style

from mtb_rs.pictures.quantities import LINE_COLOURS


def test_style_sheet_has_the_palette_of_the_package() -> None:
    with style.context("mtb_rs.pictures"):
        from matplotlib import rcParams

        drawn = tuple(f"#{colour.lstrip('#')}" for colour in rcParams["axes.prop_cycle"].by_key()["color"])
    assert drawn == LINE_COLOURS
