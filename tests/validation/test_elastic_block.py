# SPDX-License-Identifier: MIT OR Apache-2.0
"""An elastic block sliding on a half-space, against independent finite elements (tests/data/fe).

The block hangs from a top that moves along x only; a magnetic pressure pulls its foot down. The contact
problem is stated here in a few lines of NumPy, so that the bodies are judged and not the scenes.
"""

from __future__ import annotations

from functools import cache
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

import mtb_rs as mtb
from mtb_rs import _mtb_rs
from mtb_rs.bodies.elastic_body import Condensed
from mtb_rs.bodies.mesh import block_mesh
from mtb_rs.geometry.contact_points import ContactGrid
from mtb_rs.geometry.geometries import BlockOnPlane

Array = NDArray[np.float64]
DATA = Path(__file__).parents[1] / "data" / "fe"
WIDTH, CELLS, PULL, STEEL = 0.1, 20, 3e6, mtb.Material.from_shear_modulus(80e9, 0.3)


def half_space_on_hats() -> tuple[Array, Array]:
    """Indentation by pressure and by traction along x, weighted with hats: rectangles half as wide."""
    parts, step = 2, WIDTH / CELLS
    fine = CELLS * parts
    body = _mtb_rs.half_space((80e9, 0.3), [(0.0, 0.0, fine, fine)], (step / parts, step / parts), True)
    place = (np.arange(fine) + 0.5) / parts
    hat = np.maximum(0.0, 1.0 - np.abs(place[:, None] - np.arange(CELLS + 1)))
    hats = np.einsum("ij,kl->ikjl", hat, hat).reshape(fine**2, -1)
    cell = (step / parts) ** 2
    pressed, dragged = (hats.T @ body.influence("n", loaded) @ hats * cell for loaded in ("n", "x"))
    return pressed, dragged


def solve_lcp(matrix: Array, offset: Array) -> Array:
    """p >= 0, matrix p + offset >= 0, one of them zero."""
    active = np.ones(offset.size, dtype=bool)
    for _ in range(50):
        p = np.zeros(offset.size)
        p[active] = np.linalg.solve(matrix[np.ix_(active, active)], -offset[active])
        gap = matrix @ p + offset
        wrong = np.where(active, p < -1e-12 * p.max(), gap < -1e-12 * np.abs(offset).max())
        if not wrong.any():
            return p
        active ^= wrong
    raise AssertionError("no solution")


@pytest.fixture(scope="module")
def plane() -> tuple[Array, Array]:
    return half_space_on_hats()


@cache
def block(height: float) -> tuple[mtb.ElasticBody, ContactGrid, _mtb_rs.Sampling, Condensed]:
    """The block with its driven top, condensed onto the corners of 5 mm cells."""
    grid = BlockOnPlane(WIDTH, WIDTH, height).grid((WIDTH / CELLS, WIDTH / CELLS))
    x = np.linspace(-WIDTH / 2, WIDTH / 2, CELLS + 1)
    body = mtb.ElasticBody(
        block_mesh(x, x, height), STEEL, supports=[mtb.Support("top", x=20e-6, y=0.0, z=0.0)]
    )
    sampling = body.sample(grid.nodes, grid.node_patches, upper=True)
    return body, grid, sampling, body.condense(sampling, keep=False)


@pytest.mark.parametrize(
    ("height", "friction", "name"),
    [(0.05, 0.5, "block_h050_he5"), (0.1, 0.5, "block_h100_he5"), (0.1, 0.0, "block_h100_he5_mu0")],
)
@pytest.mark.slow
def test_block_against_finite_elements(
    plane: tuple[Array, Array], height: float, friction: float, name: str
) -> None:
    body, grid, sampling, condensed = block(height)
    assert condensed.mode_names == ()
    weights, compliance = condensed.weights, condensed.compliance
    pull = np.zeros((3, weights.size))
    pull[2] = -PULL
    free = body.given_displacement(condensed) + compliance.displacement(pull)
    upper = compliance.influence("n", "n") - friction * compliance.influence("n", "x")
    matrix = weights[:, None] * upper + plane[0] + friction * plane[1]
    p = solve_lcp(matrix, weights * free[2])

    contact = np.stack([-friction * p, 0.0 * p, p])
    state = body.recover(sampling, condensed.modes, contact + pull, np.zeros(0))
    force = float(p @ weights)
    top = state.reactions["top"]
    assert top[2] == pytest.approx(PULL * WIDTH**2 - force, abs=1e-8 * force)
    assert top[0] == pytest.approx(friction * force, abs=1e-8 * force)
    assert state.left_over < 1e-8 * force

    table = np.genfromtxt(DATA / f"{name}_contact.csv.gz", delimiter=",", names=True)
    assert force == pytest.approx(2.0 * table["p_lump"] @ table["area"], rel=0.03)
    places = np.stack([table["x"], table["y"], table["z"]])
    nearest = [int(np.argmin(((grid.nodes.points - place[:, None]) ** 2).sum(axis=0))) for place in places.T]
    inner = (np.abs(places[:2]) < WIDTH / 2 - 1e-6).all(axis=0)
    p_ref, u_ref = table["p_lump"][inner], table["uz_s"][inner]
    # what barely touches is counted, not compared
    solid = p_ref > 0.1 * p_ref.mean()
    assert np.count_nonzero(~solid) <= 0.01 * solid.size
    start, column, share = body.core_mesh.averages(sampling)[2]
    p_ours = np.add.reduceat(share * p[column], start[:-1].astype(int))[nearest][inner]
    assert np.mean(np.abs(p_ours - p_ref)[solid] / p_ref[solid]) < 0.05
    u_ours = state.at(places)[2][inner]
    assert np.mean(np.abs(u_ours - u_ref) / np.abs(u_ref)) < 0.02


@pytest.mark.coarse
@pytest.mark.parametrize(
    ("height", "expected", "off"), [(0.05, 0.3671, 0.004), (0.1, 0.554, 0.004), (0.25, 1.395, 0.006)]
)
def test_layers_of_elements_leave_no_error_behind(height: float, expected: float, off: float) -> None:
    """Normal force over pull of bricks of 27 nodes on an exact half-space, an independent code's; its own
    uncertainty for the tall block is 0.4 %."""
    result = mtb.scenes.block_on_plane(height=height, friction=0.5, spacing=10e-3).solve("elastic-upper")
    pull = -result.report.force_balance["magnetic"][2]
    assert result.normal_force / pull == pytest.approx(expected, rel=off)
    truth = abs(result.normal_force / pull / expected - 1.0)
    assert truth < 2.0 * result.report.error_estimates["force"]


def test_each_refinement_of_the_grid_refines_all_layers() -> None:
    line, coarse = np.linspace(-0.05, 0.05, 11), np.linspace(-0.05, 0.05, 6)
    thickest = []
    for stations in (coarse, line):
        z = np.unique(np.round(block_mesh(stations, stations, 0.25).nodes[:, 2], 12))
        thickest.append(np.diff(z[::2]).max())
    assert thickest[1] < 0.35 * 0.1
    assert thickest[1] < 0.8 * thickest[0]
    own, thinner = (block_mesh(coarse, coarse, 0.25, thinner=t).nodes.shape[0] for t in (1.0, 2.0))
    assert own < thinner
