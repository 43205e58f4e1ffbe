# SPDX-License-Identifier: MIT OR Apache-2.0
"""Contacts that are refused because no state of them exists, and grids, steps and ways that do not fit."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import mtb_rs as mtb

X = (np.arange(9) - 4) * 1e-3
BOWL = X**2 + X[:, None] ** 2  # a ball of radius 0.5 m


def block(height: float = 0.5, friction: float = 0.5, **given: Any) -> mtb.Scene:
    return mtb.scenes.block_on_plane(
        width=0.1, height=height, friction=friction, magnetic_pressure=3e6, spacing=10e-3, **given
    )


def bowl(**given: Any) -> mtb.Scene:
    words = {"gap": BOWL, "spacing": 1e-3, "friction": 0.3, "force": 1.0}
    return mtb.Scene(mtb.steel, mtb.steel, **words | given)


def test_a_body_that_wedges_is_refused() -> None:
    with pytest.raises(mtb.ConvergenceError, match="the body wedges"):
        block().solve(model="elastic-upper")


def test_a_body_that_jams_is_told() -> None:
    with pytest.warns(UserWarning, match="The body jams: its displacement has raised the contact force"):
        block().start_of_sliding([[4e-3, 0.0]], model="elastic-upper")


@pytest.mark.coarse
@pytest.mark.parametrize(
    "way",
    [
        lambda scene: scene.solve(),
        lambda scene: scene.prepare().step(velocity=1.0),
        lambda scene: scene.start_of_sliding([[1e-5, 0.0]]),
    ],
    ids=["solve", "step", "start_of_sliding"],
)
def test_a_contact_cut_off_by_the_edge_of_the_grid_is_refused(way: Callable[[mtb.Scene], object]) -> None:
    with pytest.raises(ValueError, match="reaches the edge of the grid of"):
        way(bowl(force=26e3))


def test_a_grid_that_could_grow_names_its_size() -> None:
    with pytest.raises(ValueError, match=r"edge of the grid of .* would do: give the gap on such a grid"):
        mtb.solve_normal(BOWL, 1e-3, upper=mtb.steel, lower=mtb.steel, force=26e3)


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ({"method": "staggered", "model": "half-space"}, "it needs model='elastic-upper'"),
        ({"method": "incremental", "increments": 0}, "increments"),
        ({"model": "elastic-upper", "tolerance": -1.0}, "tolerance is -1.0"),
        ({"quantity": "heat"}, "quantity is 'heat'"),
    ],
)
def test_ways_that_do_not_fit_are_refused(words: dict[str, Any], said: str) -> None:
    with pytest.raises((ValueError, TypeError), match=said):
        block(0.1).solve(**words)


@pytest.mark.parametrize(
    ("displacements", "words", "said"),
    [
        ([1e-6, 0.0, 0.0], {}, r"displacements has shape \(1, 3\)"),
        ([[np.nan, 0.0]], {}, r"displacements\[0, 0\] is nan"),
        ([[1e-6, 0.0]], {"pressure": "free"}, "pressure is 'free'"),
        ([[1e-6, 0.0]], {"model": "elastic"}, "model is 'elastic'"),
    ],
)
def test_starts_of_sliding_that_cannot_be_followed(displacements: Any, words: Any, said: str) -> None:
    with pytest.raises(ValueError, match=said):
        block(0.1).start_of_sliding(displacements, **words)
