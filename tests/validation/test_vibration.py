# SPDX-License-Identifier: MIT OR Apache-2.0
"""Natural vibrations of elastic bodies against scikit-fem, theories of beams and rods, and their own laws."""

from __future__ import annotations

import pickle
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest
import scipy.linalg
import scipy.optimize
import scipy.sparse.linalg
from numpy.typing import NDArray

import mtb_rs as mtb

Array = NDArray[np.float64]
DENSITY = 7850.0
E, NU = mtb.steel.young_modulus, mtb.steel.poisson_ratio
CLAMPED = [mtb.Support("top", x=0, y=0, z=0)]


def uniform(length: float, width: float, height: float, parts: Sequence[int]) -> mtb.TetraMesh:
    """A block of equal cells, cut by scikit-fem."""
    import skfem

    lines = [np.linspace(0.0, size, n + 1) for size, n in zip((length, width, height), parts, strict=True)]
    made = skfem.MeshTet.init_tensor(*lines)
    nodes, cells = np.ascontiguousarray(made.p.T), made.t.T.copy()
    a, b, c = (nodes[cells[:, k]] - nodes[cells[:, 0]] for k in (1, 2, 3))
    # it takes either hand
    left = np.einsum("ij,ij->i", np.cross(a, b), c) < 0.0
    cells[left] = cells[left][:, [0, 2, 1, 3]]
    return mtb.TetraMesh(nodes, cells)


def body(
    mesh: mtb.TetraMesh, supports: Sequence[mtb.Support] = (), *, linear: bool = False
) -> mtb.ElasticBody:
    return mtb.ElasticBody(mesh, mtb.steel, "bottom", list(supports), linear=linear)


def matrices(
    mesh: object, element: object
) -> tuple[object, scipy.sparse.csc_matrix, scipy.sparse.csc_matrix]:
    """Basis, stiffness and mass of scikit-fem."""
    import skfem
    from skfem.helpers import dot
    from skfem.models.elasticity import lame_parameters, linear_elasticity

    # of a degree that integrates products of the shape functions exactly
    basis = skfem.Basis(mesh, skfem.ElementVector(element), intorder=6)
    stiffness = linear_elasticity(*lame_parameters(E, NU)).assemble(basis)
    mass = skfem.BilinearForm(lambda u, v, w: DENSITY * dot(u, v)).assemble(basis)
    return basis, stiffness.tocsc(), mass.tocsc()


def lowest(stiffness: Array, mass: Array, count: int, shift: float = -1e7) -> Array:
    """Frequencies [Hz] by ARPACK about a shift below zero."""
    squares = scipy.sparse.linalg.eigsh(
        stiffness, count, mass, sigma=shift, which="LM", return_eigenvectors=False
    )
    return np.asarray(np.sqrt(np.maximum(np.sort(squares), 0.0)) / (2.0 * np.pi))


@pytest.mark.slow
@pytest.mark.parametrize("is_free", [True, False])
def test_the_block_of_the_thesis_has_the_frequencies_of_quadratic_bricks(is_free: bool) -> None:
    import skfem

    sizes = (0.1, 0.1, 0.1)
    found = mtb.vibration(body(uniform(*sizes, (8, 8, 8)), [] if is_free else CLAMPED), DENSITY, 10)
    lines = [np.linspace(0.0, size, 7) for size in sizes]
    basis, stiffness, mass = matrices(skfem.MeshHex.init_tensor(*lines), skfem.ElementHex2())
    rigid = 6 if is_free else 0
    assert len(found.rigid) == rigid
    if not is_free:
        free = np.flatnonzero(basis.doflocs[2] < sizes[2] - 1e-9)  # type: ignore[attr-defined]
        stiffness, mass = stiffness[free][:, free], mass[free][:, free]
    expected = lowest(stiffness, mass, 10 + rigid)[rigid:]
    assert np.abs(found.frequency / expected - 1.0).max() < 5e-3


@pytest.mark.parametrize("linear", [False, True])
@pytest.mark.filterwarnings("ignore:.*keeps tetrahedra of four nodes")
def test_all_vibrations_of_a_small_body_are_those_of_scikit_fem(linear: bool) -> None:
    """The same elements: frequencies to rounding, double ones included, and all of the mass that is free."""
    import skfem

    mesh = uniform(0.05, 0.05, 0.06, (2, 2, 2))
    held = body(mesh, CLAMPED, linear=linear)
    straight = skfem.MeshTet(np.ascontiguousarray(mesh.nodes.T), np.ascontiguousarray(mesh.cells.T))
    basis, stiffness, mass = matrices(straight, skfem.ElementTetP1() if linear else skfem.ElementTetP2())
    free = np.flatnonzero(basis.doflocs[2] < 0.06 - 1e-9)  # type: ignore[attr-defined]
    k, m = stiffness[free][:, free].toarray(), mass[free][:, free].toarray()
    expected = np.sqrt(scipy.linalg.eigh(k, m, eigvals_only=True)) / (2.0 * np.pi)
    found = mtb.vibration(held, DENSITY, free.size)
    assert np.abs(found.frequency / expected - 1.0).max() < 1e-8
    few = mtb.vibration(held, DENSITY, 20)
    assert np.abs(few.frequency / expected[:20] - 1.0).max() < 1e-9
    # the mass that a shaking support moves: what is left of a shake after what the held nodes take with them
    shake = np.zeros((basis.N, 3))  # type: ignore[attr-defined]
    for c in range(3):
        shake[basis.split_indices()[c], c] = 1.0  # type: ignore[attr-defined]
    load = (mass @ shake)[free]
    moved = np.einsum("ic,ic->c", load, np.linalg.solve(m, load))
    assert found.effective_mass.sum(axis=0) == pytest.approx(moved, rel=1e-8)
    with pytest.raises(
        ValueError, match=f"{free.size + 1} vibrations are asked for: the body has {free.size}"
    ):
        mtb.vibration(held, DENSITY, free.size + 1)


def test_a_guide_moves_as_one() -> None:
    import skfem

    mesh = uniform(0.05, 0.04, 0.06, (2, 2, 3))
    guided = body(mesh, [mtb.Support("top", x=0, y=mtb.Guide(), z=0), mtb.Support("bottom", x=0)])
    found = mtb.vibration(guided, DENSITY, 6)
    basis, stiffness, mass = matrices(
        skfem.MeshTet(np.ascontiguousarray(mesh.nodes.T), np.ascontiguousarray(mesh.cells.T)),
        skfem.ElementTetP2(),
    )
    z = basis.doflocs[2]  # type: ignore[attr-defined]
    component = np.empty(z.size, dtype=int)
    for c in range(3):
        component[basis.split_indices()[c]] = c  # type: ignore[attr-defined]
    top = z > 0.06 - 1e-9
    own = np.flatnonzero(~top & ~((component == 0) & (z < 1e-9)))
    kept = np.zeros((z.size, own.size + 1))
    kept[own, np.arange(own.size)] = 1.0
    kept[top & (component == 1), -1] = 1.0
    expected = scipy.linalg.eigh(kept.T @ (stiffness @ kept), kept.T @ (mass @ kept), eigvals_only=True)
    # it is free along y
    assert len(found.rigid) == 1
    assert found.frequency == pytest.approx(np.sqrt(expected[1:7]) / (2.0 * np.pi), rel=1e-8)


@pytest.mark.parametrize(("linear", "order"), [(False, 4.0), (True, 2.0)])
@pytest.mark.filterwarnings("ignore:.*keeps tetrahedra of four nodes")
def test_frequencies_come_down_by_the_order_of_the_elements(linear: bool, order: float) -> None:
    """Twice the degree of the shape functions, for vibrations of a free body, which are smooth enough."""
    rows = []
    for n in (4, 8, 16) if linear else (2, 4, 8):
        mesh = uniform(0.1, 0.06, 0.04, (n, n, n))
        rows.append(mtb.vibration(body(mesh, linear=linear), DENSITY, 4).frequency)
    first, second = rows[0] - rows[1], rows[1] - rows[2]
    assert (second > 0.0).all()
    # the coarse ones are not yet as smooth as their elements
    assert np.log2(first / second).mean() > 0.8 * order


def test_a_slender_bar_bends_stretches_and_twists_as_theories_say() -> None:
    """Timoshenko's beam, a rod with Love's lateral inertia, and Saint-Venant's torsion, all free."""
    length, width, height = 0.4, 0.024, 0.02
    found = mtb.vibration(body(uniform(length, width, height, (40, 3, 3))), DENSITY, 12)
    shear = E / (2.0 * (1.0 + NU))
    bending = [_free_timoshenko(length, *sides) for sides in ((width, height), (height, width))]
    gyration = (width**2 + height**2) / 12.0
    rod = np.sqrt(E / DENSITY / (1.0 + NU**2 * gyration * (np.pi / length) ** 2)) / (2.0 * length)
    # Saint-Venant's constant of a rectangle by its series
    odd = np.arange(1, 100, 2)
    a, b = width, height
    torsion = (
        a * b**3 / 3.0 * (1 - 192 * b / (np.pi**5 * a) * np.sum(np.tanh(odd * np.pi * a / 2 / b) / odd**5))
    )
    polar = a * b * gyration
    twist = np.sqrt(shear * torsion / (DENSITY * polar)) / (2.0 * length)
    expected = np.sort(np.concatenate([*bending, [rod], twist * np.arange(1, 4)]))
    expected = expected[expected < 1.02 * found.frequency[-1]][: found.frequency.size]
    assert expected.size >= 10
    assert np.abs(found.frequency[: expected.size] / expected - 1.0).max() < 6e-3


def _free_timoshenko(length: float, width: float, height: float) -> Array:
    """Frequencies [Hz] of a free beam, by Cowper's coefficient, from its solution in exponentials."""
    area, second = width * height, width * height**3 / 12.0
    stiff = 10.0 * (1.0 + NU) / (12.0 + 11.0 * NU) * E / (2.0 * (1.0 + NU)) * area

    def determinant(f: float) -> float:
        omega2 = (2.0 * np.pi * f) ** 2
        # w'' - psi' + omega2 rho A w / stiff = 0 and E I psi'' + stiff (w' - psi) + omega2 rho I psi = 0
        a, b = omega2 * DENSITY * area / stiff, omega2 * DENSITY / E
        system = np.array(
            [
                [0.0, 1.0, 0.0, 0.0],
                [-a, 0.0, 0.0, 1.0],
                [0.0, 0.0, 0.0, 1.0],
                [0.0, -stiff / (E * second), stiff / (E * second) - b, 0.0],
            ]
        )
        # neither moment psi' nor shear w' - psi at the ends
        ends = np.array([[0.0, 0.0, 0.0, 1.0], [0.0, 1.0, -1.0, 0.0]])
        across = scipy.linalg.expm(system * length)
        start = scipy.linalg.null_space(ends)
        return float(np.linalg.det(ends @ across @ start))

    tried = np.linspace(50.0, 16e3, 1500)
    values = np.array([determinant(f) for f in tried])
    crossed = np.flatnonzero(values[1:] * values[:-1] < 0.0)
    return np.array([scipy.optimize.brentq(determinant, tried[k], tried[k + 1]) for k in crossed])


def test_rigid_motions_are_exact_and_nothing_of_them_is_in_the_vibrations() -> None:
    free = body(uniform(0.09, 0.05, 0.03, (4, 3, 2)))
    found = mtb.vibration(free, DENSITY, 5)
    raw = free.core.vibration(DENSITY, 5)
    everything = np.concatenate([found.rigid, found.shapes])
    product = np.einsum("icn,jcn->ij", everything, raw["inertia"])
    assert np.abs(product - np.eye(11)).max() < 1e-12
    assert found.mass == pytest.approx(0.09 * 0.05 * 0.03 * DENSITY, rel=1e-12)
    # each is a translation and a rotation: what a fit of these leaves is rounding
    for motion in found.rigid:
        x, y, z = found.points
        none, one = np.zeros_like(x), np.ones_like(x)
        turns = [(none, -z, y), (z, none, -x), (-y, x, none)]
        motions = [
            np.concatenate(m) for m in ((one, none, none), (none, one, none), (none, none, one), *turns)
        ]
        fitted = np.linalg.lstsq(np.array(motions).T, motion.ravel(), rcond=None)[0] @ np.array(motions)
        assert np.abs(fitted - motion.ravel()).max() < 1e-12 * np.abs(motion).max()
    # a free body moves nothing of its mass as it vibrates
    assert found.effective_mass.max() < 1e-20 * found.mass


def test_two_runs_are_the_same_and_more_modes_change_none() -> None:
    held = body(uniform(0.09, 0.05, 0.03, (4, 3, 2)), CLAMPED)
    few, again, many = (mtb.vibration(held, DENSITY, k) for k in (4, 4, 15))
    assert few == again
    assert few.frequency == pytest.approx(many.frequency[:4], rel=1e-12)
    assert np.abs(few.shapes - many.shapes[:4]).max() < 1e-7 * np.abs(few.shapes).max()
    # stiffness and density as they must
    heavy = mtb.vibration(held, 4.0 * DENSITY, 4)
    assert heavy.frequency == pytest.approx(0.5 * few.frequency, rel=1e-12)
    assert heavy.mass == pytest.approx(4.0 * few.mass, rel=1e-12)


def test_it_is_saved_loaded_pickled_and_drawn(tmp_path: Path) -> None:
    found = mtb.vibration(body(uniform(0.09, 0.05, 0.03, (3, 2, 2)), CLAMPED), DENSITY, 3)
    assert pickle.loads(pickle.dumps(found)) == found
    found.save(tmp_path)
    loaded = mtb.load(tmp_path)
    assert isinstance(loaded, mtb.Vibration)
    assert loaded == found
    lines = (tmp_path / "vibration.csv").read_text().splitlines()
    assert lines[0] == "frequency [Hz],effective mass x [kg],effective mass y [kg],effective mass z [kg]"
    assert [float(line.split(",")[0]) for line in lines[1:]] == found.frequency.tolist()
    assert f"{found.frequency[1]:.5g} Hz" in loaded.plot(1).axes[0].get_title()
    moving = loaded.animate(tmp_path / "moving.gif", 2)
    assert moving.stat().st_size > 10_000
    assert dict(found.told())["mass"] == f"{found.mass:.4g} kg"
    for wrong in (3, -1, 1.5, True):
        with pytest.raises(ValueError, match=r"mode is .*: a number from 0 to 2 is needed"):
            found.plot(wrong)  # type: ignore[arg-type]
    with pytest.raises(ValueError, match="axes in space"):
        found.plot(0, ax=found.plot(0).add_subplot())


def test_what_has_no_vibrations_is_refused() -> None:
    held = body(uniform(0.09, 0.05, 0.03, (3, 2, 2)), CLAMPED)
    with pytest.raises(ValueError, match="an ElasticBody is needed, as half-spaces have no vibrations"):
        mtb.vibration(mtb.HalfSpace(mtb.steel), DENSITY)  # type: ignore[arg-type]
    with pytest.raises(ValueError, match=r"density is 0\.0: a positive number"):
        mtb.vibration(held, 0.0)
    with pytest.raises(ValueError, match="modes is 0: a positive whole number"):
        mtb.vibration(held, DENSITY, 0)
