# SPDX-License-Identifier: MIT OR Apache-2.0
"""A sample of studies/fuzz.py: the same random input at every door each time; and what it once found."""

from __future__ import annotations

import sys
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest

import mtb_rs as mtb
from mtb_rs.bodies.mesh import block_mesh

DOORS = (
    *("case_files", "cases", "creep_tables", "ellipses", "forged_checkpoints", "height_fields", "mesh_files"),
    *("prepared_bytes", "profile_files", "profile_points", "rough_surfaces", "scenes", "shifts", "shoes"),
    *("summaries", "surfaces", "sweep_checkpoints", "sweeps", "tetrahedra", "wheels"),
)


@pytest.fixture(scope="module")
def fuzz() -> ModuleType:
    sys.path.insert(0, str(Path(__file__).parents[2] / "studies"))
    try:
        import fuzz
    finally:
        sys.path.pop(0)
    assert tuple(sorted(fuzz.DOORS)) == DOORS
    return fuzz


@pytest.mark.filterwarnings("default")
@pytest.mark.parametrize("door", DOORS)
def test_a_sample_at_every_door(fuzz: ModuleType, door: str) -> None:
    outcomes, findings = fuzz.search(door, 100, start=0)
    assert findings == []
    assert outcomes["refused"] > 0
    assert sum(outcomes.values()) == 100


def test_a_number_too_large_for_a_float_is_refused() -> None:
    with pytest.raises(ValueError, match=r"kinetic is 1000.* of at most 1e.30"):
        mtb.StaticKinetic(0.4, 10**400)


def test_nodes_at_infinity_are_named_before_anything_is_measured() -> None:
    mesh = block_mesh(np.linspace(-0.02, 0.02, 3), np.linspace(-0.01, 0.01, 3), 0.02)
    nodes = mesh.nodes.copy()
    nodes[2, 2] = np.inf
    with pytest.raises(ValueError, match=r"node 2 of the mesh is \[.*inf\]: finite numbers"):
        mtb.ElasticBody(mtb.TetraMesh(nodes, mesh.cells, {}), mtb.steel, "bottom")


@pytest.mark.coarse
def test_an_approach_with_a_moment_is_reachable_by_convolutions() -> None:
    # it started from no pressure at all, which no factor turns into a moment
    gap = 1e-5 * np.random.default_rng(1).random((8, 8))
    pair = {"lower": mtb.steel, "upper": mtb.steel, "edge": "sharp", "approach": 1.9e-6}
    dense, fast = (
        mtb.solve_normal(gap, 1e-3, moments_about_axes=(None, 6e-5), tolerance=1e-10, method=method, **pair)
        for method in ("dense", "fft")
    )
    assert np.abs(dense.pressure - fast.pressure).max() < 1e-7 * dense.pressure.max()


def test_the_size_that_would_do_is_found_quickly_for_the_dense_method() -> None:
    # each larger grid of the search took a dense factorisation: minutes
    gap = 1e-5 * np.random.default_rng(1).random((12, 36))
    with pytest.raises(ValueError, match="even a grid four times as large would not do"):
        mtb.solve_normal(
            gap,
            1.0,
            lower=mtb.steel,
            upper=mtb.steel,
            approach=1e30,
            moments_about_axes=(None, 1e-6),
            method="dense",
        )
