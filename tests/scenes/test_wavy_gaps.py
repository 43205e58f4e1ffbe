# SPDX-License-Identifier: MIT OR Apache-2.0
"""Given gaps with waves of a few cells: the estimated error is held against cells several times as fine."""

import numpy as np
import pytest

import mtb_rs as mtb

RADIUS, FORCE = 0.4, 10e3
SIDE = 3.0 * mtb.hertz(FORCE, RADIUS).semi_axes[0]
FINEST = 480


def gap(cells: int, height: float, lengths: tuple[float, float]) -> tuple[np.ndarray, float]:
    """A paraboloid with waves [m] along x and y, and its spacing."""
    x = (np.arange(cells) - 0.5 * (cells - 1)) * SIDE / cells
    waves = (
        np.sin(2.0 * np.pi * x / lengths[0] + 0.3)[None, :] * np.cos(2.0 * np.pi * x / lengths[1])[:, None]
    )
    round_ = x[None, :] ** 2 / (2.0 * RADIUS) + x[:, None] ** 2 / (1.6 * RADIUS)
    return round_ + height * waves, SIDE / cells


def pressure(cells: int, *waves: object) -> np.ndarray:
    heights, spacing = gap(cells, *waves)  # type: ignore[arg-type]
    return mtb.solve_normal(heights, spacing, lower=mtb.steel, upper=mtb.steel, force=FORCE).pressure


@pytest.mark.parametrize(
    "waves",
    [(0.5e-6, (0.6e-3, 0.9e-3)), (0.5e-6, (0.6e-3, 1e3)), (0.2e-6, (0.45e-3, 0.45e-3)), (0.0, (1.0, 1.0))],
)
def test_waves_that_wider_cells_do_not_see_are_in_the_estimate(waves: tuple[float, tuple]) -> None:
    finest = pressure(FINEST, *waves)
    # one count that three divides and one that it does not: wider cells fill the same rectangle
    for cells in (60, 80):
        heights, spacing = gap(cells, *waves)
        scene = mtb.Scene(mtb.steel, mtb.steel, gap=heights, spacing=spacing, force=FORCE)
        found = scene.solve(tolerance=0.9)
        times = FINEST // cells
        truth = finest.reshape(cells, times, cells, times).mean(axis=(1, 3))
        error = np.linalg.norm(found.pressure - truth) / np.linalg.norm(truth)
        # the estimate leaves nothing out here that the comparison has; it may be some times too large
        assert error < 1.5 * found.error_estimate < 5.0 * error


@pytest.mark.parametrize("cells", [79, 80, 81])
def test_wider_cells_lie_where_the_field_does(cells: int) -> None:
    x = np.arange(cells) - 0.5 * (cells - 1)
    plane = 3.0 + 0.2 * x[None, :] - 0.1 * x[:, None]
    for width in (2.0, 3.0, cells / 26):
        grid = mtb.Scene(mtb.steel, mtb.steel, gap=plane, spacing=1.0, force=1.0).geometry.grid((width, 2.0))
        # means of a plane are its values, wherever the cells have been put
        np.testing.assert_allclose(
            grid.cells.gap, 3.0 + 0.2 * grid.cells.points[0] - 0.1 * grid.cells.points[1]
        )
        assert grid.cells.points[0].mean() == pytest.approx(0.0, abs=1e-12)
