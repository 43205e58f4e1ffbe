# SPDX-License-Identifier: MIT OR Apache-2.0
"""Reduced bodies against the whole dynamic stiffness of scikit-fem, and against bodies at rest."""

from __future__ import annotations

import pickle
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest
import scipy.sparse.linalg
from numpy.typing import NDArray

import mtb_rs as mtb

Array = NDArray[np.float64]
DENSITY = 7850.0
SIZES, HEIGHT = (0.06, 0.04), 0.03
HELD = {
    "clamped": [mtb.Support("top", x=0, y=0, z=0)],
    "guided": [mtb.Support("top", x=0, y=0, z=mtb.Guide())],
    "free": [mtb.Support("top", x=0, y=0)],
}
pytestmark = pytest.mark.filterwarnings("ignore:.*The contact point")


def block() -> mtb.TetraMesh:
    import skfem

    lines = [np.linspace(-0.5 * s, 0.5 * s, n + 1) for s, n in zip(SIZES, (6, 4), strict=True)]
    made = skfem.MeshTet.init_tensor(*lines, np.linspace(0.0, HEIGHT, 4))
    nodes, cells = np.ascontiguousarray(made.p.T), made.t.T.copy()
    a, b, c = (nodes[cells[:, k]] - nodes[cells[:, 0]] for k in (1, 2, 3))
    left = np.einsum("ij,ij->i", np.cross(a, b), c) < 0.0
    cells[left] = cells[left][:, [0, 2, 1, 3]]
    return mtb.TetraMesh(nodes, cells)


def prepared(supports: Sequence[mtb.Support]) -> mtb.PreparedContact:
    body = mtb.ElasticBody(block(), mtb.steel, "bottom", list(supports))
    scene = mtb.Scene(
        body,
        mtb.Rigid(),
        spacing=0.02,
        force=1e3,
        friction=0.2,
        sliding_direction=(1, 0),
    )
    contact = scene.prepare()
    assert isinstance(contact, mtb.PreparedContact)
    return contact


class Whole:
    """The body of scikit-fem, with hats over the grid of the contact on its underside."""

    def __init__(self, contact: mtb.PreparedContact, held: str) -> None:
        import skfem
        from skfem.helpers import dot
        from skfem.models.elasticity import lame_parameters, linear_elasticity

        mesh = block()
        made = skfem.MeshTet(np.ascontiguousarray(mesh.nodes.T), np.ascontiguousarray(mesh.cells.T))
        element = skfem.ElementVector(skfem.ElementTetP2())
        basis = skfem.Basis(made, element, intorder=4)
        lame = lame_parameters(mtb.steel.young_modulus, mtb.steel.poisson_ratio)
        stiffness = linear_elasticity(*lame).assemble(basis).tocsc()
        mass = skfem.BilinearForm(lambda u, v, w: DENSITY * dot(u, v)).assemble(basis).tocsc()
        source = contact._source
        assert source is not None
        (part,) = source.problem.upper.state
        sampling = part.sampling()
        self.area = sampling.weights
        node = np.array(
            [int(((part.body.mesh.nodes - p) ** 2).sum(axis=1).argmin()) for p in basis.doflocs.T]
        )
        z = basis.doflocs[2]
        component = np.empty(z.size, dtype=int)
        for c in range(3):
            component[basis.split_indices()[c]] = c
        # hats on the face are the contact's own: what they load, stiffness, mass and response are not
        forces = [
            part.body.core.contact_force(sampling, unit.reshape(3, -1))[component, node]
            for unit in np.eye(3 * self.area.size)
        ]
        load = np.array(forces).T
        top = z > HEIGHT - 1e-9
        if held == "free":
            own = np.flatnonzero(~top | (component == 2))
            kept = scipy.sparse.identity(z.size, format="csc")[:, own]
        else:
            own = np.flatnonzero(~top)
            kept = scipy.sparse.csc_matrix(
                (np.ones(own.size), (own, np.arange(own.size))), (z.size, own.size)
            )
            if held == "guided":
                common = scipy.sparse.csc_matrix((top & (component == 2)).astype(float)[:, None])
                kept = scipy.sparse.hstack([kept, common], format="csc")
        self.stiffness, self.mass = kept.T @ stiffness @ kept, kept.T @ mass @ kept
        self.load = (kept.T @ load) / np.tile(self.area, 3)

    def receptance(self, frequency: float) -> Array:
        """Displacement (3 n, 3 n) [m/N] by unit forces."""
        dynamic = self.stiffness - (2.0 * np.pi * frequency) ** 2 * self.mass
        return np.asarray(self.load.T @ scipy.sparse.linalg.splu(dynamic.tocsc()).solve(self.load))


@pytest.mark.parametrize("held", HELD)
def test_the_response_over_the_frequency_is_that_of_the_whole_body_within_the_bound(held: str) -> None:
    contact = prepared(HELD[held])
    found, whole = contact.reduced(DENSITY, 6), Whole(contact, held)
    assert found.area == pytest.approx(whole.area, rel=1e-10)
    assert len(found.rigid) == {"clamped": 0, "guided": 1, "free": 3}[held]
    errors = []
    for frequency in (500.0, 2e3, 0.31 * found.next_frequency, 0.9 * found.next_frequency):
        expected, given = whole.receptance(frequency), found.receptance(frequency)
        left = expected - given
        size = np.abs(expected).max()
        # between nothing and the bound, as quadratic forms; near zero a free body moves far, with rounding
        bound = found.left_out(frequency) * found.residual
        rounding = 1e-9 * size
        assert np.linalg.eigvalsh(0.5 * (left + left.T)).min() > -rounding
        assert np.linalg.eigvalsh(bound - 0.5 * (left + left.T)).min() > -rounding
        errors.append(np.abs(left).max() / np.abs(found.residual).max())
    # it grows with the square of the frequency, from nothing
    assert errors[2] / errors[1] == pytest.approx((0.31 * found.next_frequency / 2e3) ** 2, rel=0.3)
    # and modes are worth it: without them the response is wrong altogether
    assert errors[2] < 0.1


@pytest.mark.parametrize("held", HELD)
def test_at_rest_it_is_the_body_at_rest_however_many_vibrations_are_kept(held: str) -> None:
    """With loads in balance, where it is free: the flexibility of scikit-fem, with rigid motion taken off."""
    contact = prepared(HELD[held])
    few, many = contact.reduced(DENSITY, 2), contact.reduced(DENSITY, 25)
    assert np.abs(few.flexibility - many.flexibility).max() < 1e-10 * np.abs(few.flexibility).max()
    assert np.trace(many.residual) < np.trace(few.residual)
    # forces that the rigid motions do not feel
    rigid = few.rigid.reshape(len(few.rigid), 3 * few.area.size)
    force = np.random.default_rng(3).normal(size=(3 * few.area.size,))
    if len(rigid):
        force -= np.asarray(rigid.T @ np.linalg.solve(rigid @ rigid.T, rigid @ force))
    whole = Whole(contact, held)
    shift = 1e-3 * few.frequency[0]
    # at a frequency so low that nothing swings
    energy = float(force @ few.flexibility @ force)
    assert force @ whole.receptance(shift) @ force == pytest.approx(energy, rel=3e-6)
    assert force @ few.receptance(shift) @ force == pytest.approx(energy, rel=3e-6)


def test_a_clamped_body_gives_way_as_the_contact_says() -> None:
    """The same compliance as that of a solve, to 1e-10."""
    contact = prepared(HELD["clamped"])
    found = contact.reduced(DENSITY, 5)
    near, deep = (contact.step(pose=[0.0, 0.0, z, 0.0, 0.0, 0.0]) for z in (-1e-6, -2e-6))
    assert (near.pressure > 0.0).all()
    more = np.zeros((3, found.area.size))
    # of hats, unknowns times areas are forces; friction holds the upper body back
    more[2] = (deep.state.pressure - near.state.pressure) * found.area
    more[0] = -0.2 * more[2]
    moved = (found.flexibility @ more.ravel()).reshape(more.shape)
    assert moved[2] == pytest.approx(1e-6, rel=1e-10)


def test_two_poles_stand_side_by_side() -> None:
    scene = mtb.scenes.pole_shoe_on_rail(friction=0.2, velocity=5.0, spacing=12e-3)
    contact = scene.prepare("elastic-upper")
    found = contact.reduced(DENSITY, 3)
    n = found.area.size
    assert found.points.shape == (3, n) == contact.points.shape
    assert found.frequency.size == 6
    assert found.frequency[::2] == pytest.approx(found.frequency[1::2], rel=1e-3)
    left = found.points[1] > 0.0
    residual = found.residual.reshape(3, n, 3, n)
    assert not residual[:, left][:, :, :, ~left].any()
    moves = np.abs(found.shapes).max(axis=1)
    # no shape is in both
    assert not (moves[:, left].any(axis=1) & moves[:, ~left].any(axis=1)).any()
    assert len(found.rigid) == 6


def test_files_hold_all_of_it_and_others_are_refused(tmp_path: Path) -> None:
    contact = prepared(HELD["free"])
    found = contact.reduced(DENSITY, 4)
    path = tmp_path / "body.npz"
    found.save(path)
    assert mtb.ReducedBody.load(path) == found
    assert pickle.loads(pickle.dumps(found)) == found
    # as another program reads it
    with np.load(path) as arrays:
        assert str(arrays["format"]) == "mtb_rs reduced body 1"
        flat = arrays["shapes"].reshape(4, -1)
        own = (2.0 * np.pi * arrays["frequency"]) ** 2
        assert arrays["residual"] + (flat.T / own) @ flat == pytest.approx(found.flexibility, rel=1e-12)
        held = dict(arrays)
    for change, said in (
        ({"format": np.array("another")}, "its format is not"),
        ({"residual": np.eye(3)}, "residual has the shape"),
        ({"area": np.full(found.area.size, np.nan)}, "area holds numbers that are not finite"),
        ({"mass": np.zeros(2)}, "mass has the shape"),
        ({"more": np.zeros(2)}, "numbers named points, area"),
    ):
        np.savez(path, **(held | change))
        with pytest.raises(ValueError, match=said):
            mtb.ReducedBody.load(path)
    path.write_bytes(b"nothing")
    with pytest.raises(ValueError, match="no archive of NumPy"):
        mtb.ReducedBody.load(path)
    contact.save(tmp_path / "contact")
    with pytest.raises(ValueError, match="a contact from a file holds no finite elements"):
        mtb.PreparedContact.load(tmp_path / "contact").reduced(DENSITY)
    with pytest.raises(ValueError, match="body is 'lower': a body of finite elements is needed"):
        contact.reduced(DENSITY, body="lower")
    with pytest.raises(ValueError, match=r"density is -1\.0"):
        contact.reduced(-1.0)
    assert found.left_out(0.0) == 0.0
    assert found.left_out(1e-300) == 0.0
    assert found.left_out(found.next_frequency) == np.inf


def test_the_receptance_of_a_body_that_swings_freely_is_infinite() -> None:
    """Along its free motions at rest, and at its own frequencies; elsewhere a number."""
    found = (
        mtb.scenes.pole_shoe_on_rail(friction=0.3, spacing=12e-3).prepare("elastic-upper").reduced(7850.0, 5)
    )
    for frequency, moves in ((0.0, found.rigid), (float(found.frequency[0]), found.shapes[:1])):
        flat = moves.reshape(len(moves), -1)
        ways = flat.T @ flat
        given = found.receptance(frequency)
        assert not np.isnan(given).any()
        np.testing.assert_array_equal(given[ways != 0.0], np.copysign(np.inf, ways[ways != 0.0]))
        assert np.isfinite(given[ways == 0.0]).all()
