# SPDX-License-Identifier: MIT OR Apache-2.0
"""Bodies of any geometry: from meshes and surfaces, against the built-in scenes and closed forms."""

import numpy as np
import pytest
import trimesh

import mtb_rs as mtb
from mtb_rs.bodies.faces import parts
from mtb_rs.bodies.mesh import block_mesh, quadratic

steel = mtb.steel


def clamped(mesh, **options):
    return mtb.ElasticBody.from_mesh(
        mesh, steel, contact="bottom", supports=[mtb.Support("top", x=0, y=0, z=0)], **options
    )


@pytest.mark.coarse
def test_a_block_from_a_mesh_equals_the_built_in_block():
    x = np.linspace(-0.05, 0.05, 11)
    body = clamped(block_mesh(x, x, 0.1, clamped=True))
    scene = mtb.Scene(upper=body, lower=steel, spacing=1e-2, friction=0.5, magnetic_pressure=3e6)
    general = scene.solve()
    built_in = mtb.scenes.block_on_plane(spacing=1e-2).solve(model="elastic-upper")
    assert general.model == "elastic-upper"
    np.testing.assert_allclose(
        general.pressure, built_in.pressure, rtol=0, atol=1e-6 * built_in.pressure.max()
    )
    np.testing.assert_allclose(general.force, built_in.force, rtol=1e-6, atol=1e-3)


@pytest.mark.coarse
def test_a_surface_of_any_shape_in_millimetres():
    pytest.importorskip("gmsh")
    cylinder = trimesh.creation.cylinder(radius=40.0, height=50.0, sections=48)
    body = clamped(cylinder, unit="mm", size=8e-3)
    scene = mtb.Scene(upper=body, lower=steel, spacing=8e-3, friction=0.3, magnetic_pressure=2e6)
    result = scene.solve()
    # the corners of the grid lie beside the round face
    assert result.area[0, 0] == 0.0
    assert result.pressure[0, 0] == 0.0
    assert result.area.sum() == pytest.approx(np.pi * 0.04**2, rel=0.02)
    assert result.force[0] == pytest.approx(0.3 * result.normal_force, rel=1e-9)
    assert result.report.residual < 1e-10
    assert np.all(result.pressure >= 0.0)
    assert np.all((result.pressure == 0.0) | (result.gap == 0.0))
    state = result.states()["body"]
    reaction = sum(state.reactions.values())
    pull = result.report.force_balance["magnetic"]
    assert np.abs(reaction - result.force + pull).max() < 1e-6 * abs(pull[2])


def test_a_punch_on_an_elastic_block_meets_the_stiffness_of_a_deep_column():
    """A rigid plate on all of a block: u = F h / (E A) up to the held foot's constraint."""
    x = np.linspace(-0.01, 0.01, 5)
    mesh = block_mesh(x, x, 0.2).moved(np.diag([1.0, -1.0, -1.0]))
    foot = [
        mtb.Support("bottom", z=0),
        mtb.Support(((0.0, 0.0), (0.0, 0.0), (-0.2, -0.2)), x=0, y=0),
        mtb.Support(((0.01, 0.01), (0.0, 0.0), (-0.2, -0.2)), y=0),
    ]
    column = mtb.ElasticBody.from_mesh(mesh, steel, contact="contact", supports=foot)
    scene = mtb.Scene(upper=mtb.Rigid(), lower=column, spacing=5e-3, friction=0.0, force=1e4)
    result = scene.solve()
    assert result.model == "elastic-lower"
    assert result.approach == pytest.approx(1e4 * 0.2 / (208e9 * 4e-4), rel=2e-3)
    np.testing.assert_allclose(result.pressure, 1e4 / 4e-4, rtol=2e-2)
    moved = mtb.Scene(
        upper=mtb.Rigid(), lower=column, spacing=5e-3, friction=0.0, approach=float(result.approach)
    ).solve()
    assert moved.normal_force == pytest.approx(1e4, rel=1e-6)


def test_bad_input_is_named():
    x = np.linspace(-0.05, 0.05, 5)
    body = clamped(block_mesh(x, x, 0.05))
    with pytest.raises(ValueError, match="moments are given beside approach"):
        mtb.Scene(upper=body, lower=steel, spacing=1e-2, approach=1e-6, moments=(1.0, 0.0))
    with pytest.raises(ValueError, match="gap has shape"):
        mtb.Scene(
            upper=body, lower=steel, spacing=2.5e-2, gap=np.zeros((9, 9)), magnetic_pressure=1e6
        ).solve()
    pulled = mtb.Scene(upper=body, lower=steel, spacing=2.5e-2, magnetic_pressure=1e6)
    with pytest.raises(ValueError, match="has its model in its bodies, 'elastic-upper'"):
        pulled.solve(model="half-space")
    with pytest.raises(ValueError, match='with an ElasticBody takes "direct"'):
        pulled.solve(method="incremental")
    with pytest.raises(ValueError, match="faces down: the contact face of a lower body must face up"):
        mtb.Scene(upper=mtb.Rigid(), lower=body, spacing=2.5e-2, force=1e3).solve()
    with pytest.raises(ValueError, match="never touch"):
        mtb.Scene(upper=body, lower=steel, spacing=2.5e-2, gap=np.ones((5, 5)), magnetic_pressure=1e6).solve()


@pytest.mark.coarse
def test_an_elastic_lower_body_under_all_loads():
    x = np.linspace(-0.05, 0.05, 5)
    mesh = block_mesh(x, x, 0.05).moved(np.diag([1.0, -1.0, -1.0]))
    table = mtb.ElasticBody.from_mesh(
        mesh, steel, contact="contact", supports=[mtb.Support("bottom", x=0, y=0, z=0)]
    )
    pressed = mtb.Scene(steel, table, spacing=2.5e-2, force=3e4, friction=0.3).solve()
    assert pressed.force[2] == pytest.approx(-3e4, rel=1e-9)
    assert pressed.force[0] == pytest.approx(0.3 * 3e4, rel=1e-9)
    assert pressed.approach > 0.0
    pulled = mtb.Scene(steel, table, spacing=2.5e-2, magnetic_pressure=3e6, friction=0.3).solve()
    assert pulled.force[2] == pytest.approx(-3e4, rel=1e-9)
    # faces that pull each other evenly press each other evenly: a half-space is pulled at its face, too
    even = mtb.Scene(steel, table, spacing=2.5e-2, magnetic_pressure=3e6, attraction="both").solve()
    np.testing.assert_allclose(even.pressure, 3e6, rtol=1e-6)


def block(*, upper, **options):
    x, y = np.linspace(-0.04, 0.04, 6), np.linspace(-0.02, 0.02, 4)
    mesh = block_mesh(x, y, 0.04)
    if upper:
        held = [mtb.Support("top", x=0, y=0)]
        return mtb.ElasticBody(mesh, steel, "bottom", held, **options)
    held = [mtb.Support("bottom", x=0, y=0, z=0)]
    return mtb.ElasticBody(mesh.moved(shift=(0.0, 0.0, -0.04)), steel, "top", held, **options)


@pytest.mark.coarse
@pytest.mark.parametrize("lower", ["half-space", "rigid", "elastic"])
def test_a_given_gap_on_any_grid_keeps_raised_regions_free(lower):
    below = {"half-space": steel, "rigid": mtb.Rigid(), "elastic": block(upper=False)}[lower]
    gap = np.zeros((6, 11))
    gap[:, 4:7] = 1e-3  # a groove across the middle
    scene = mtb.Scene(upper=block(upper=True), lower=below, spacing=8e-3, force=5e3, friction=0.1, gap=gap)
    result = scene.solve()
    assert result.pressure.shape == gap.shape
    assert (result.pressure[:, 4:7] == 0.0).all()
    assert (result.pressure[:, :4] > 0.0).any()
    assert (result.pressure[:, 7:] > 0.0).any()
    assert result.normal_force == pytest.approx(5e3, rel=1e-9)
    np.testing.assert_array_equal(result.initial_gap, gap)
    assert len(result.surfaces) == 2
    with pytest.raises(ValueError, match=r"gap has shape \(5, 5\).* \(6, 11\) nodes"):
        mtb.Scene(upper=block(upper=True), lower=below, spacing=8e-3, force=5e3, gap=gap[:5, :5]).solve()


def test_two_bodies_of_one_name_are_told_apart(tmp_path):
    upper, lower = block(upper=True), block(upper=False)
    result = mtb.Scene(upper=upper, lower=lower, spacing=1e-2, force=5e3, friction=0.1).solve()
    states = result.states()
    assert list(states) == ["upper body", "lower body"]
    assert set(result.report.reactions) == {"upper body: top", "lower body: bottom"}
    up, down = (sum(state.reactions.values()) for state in states.values())
    assert down == pytest.approx(-result.force, rel=1e-6, abs=1e-3)
    np.testing.assert_allclose(down[:2], -up[:2], rtol=1e-6, atol=1e-3)
    assert (upper.name, lower.name) == ("body", "body")
    files = {path.name for path in result.save(tmp_path)}
    if "contact.vtp" in files:
        assert {"body_upper_body.vtu", "body_lower_body.vtu"} <= files
    alike = mtb.Scene(
        upper=block(upper=True, name="a b"), lower=block(upper=False, name="A-b"), spacing=1e-2, force=5e3
    ).solve()
    files = {path.name for path in alike.save(tmp_path)}
    if "contact.vtp" in files:
        assert {"body_a_b.vtu", "body_A_b_2.vtu"} <= files
    pair = mtb.Scene(
        upper=block(upper=True, name="pad"), lower=block(upper=False, name="disc"), spacing=1e-2, force=5e3
    )
    assert (pair.upper.name, pair.lower.name) == ("pad", "disc")


def cambered(mesh, radius, level, rise):
    """Curves the face z = `level` of a block 0.04 m high to `rise` x^2 / (2 `radius`)."""
    nodes = mesh.nodes.copy()
    share = 1.0 - np.abs(nodes[:, 2] - level) / 0.04
    nodes[:, 2] += rise * share * nodes[:, 0] ** 2 / (2.0 * radius)
    return mtb.TetraMesh(nodes, mesh.cells, mesh.node_sets)


@pytest.mark.coarse
def test_a_face_at_an_angle_to_the_grid_presses_a_half_space_alike():
    """Hats at its border are cut by the face: what they move is that of the part that is left."""
    x, y = np.linspace(-0.04, 0.04, 13), np.linspace(-0.02, 0.02, 7)
    angle = np.radians(30.0)
    turn = np.array([[np.cos(angle), -np.sin(angle), 0], [np.sin(angle), np.cos(angle), 0], [0, 0, 1]])
    forces = []
    for turned, along in ((np.eye(3), (1.0, 0.5)), (turn, tuple((turn @ [1.0, 0.5, 0.0])[:2]))):
        body = mtb.ElasticBody(
            block_mesh(x, y, 0.03).moved(turned), steel, "bottom", [mtb.Support("top", x=0, y=0, z=0)]
        )
        scene = mtb.Scene(
            body, steel, spacing=1e-2, friction=0.4, sliding_direction=along, magnetic_pressure=3e6
        )
        forces.append(scene.solve().normal_force)
    assert forces[1] == pytest.approx(forces[0], rel=5e-3)


@pytest.mark.coarse
@pytest.mark.filterwarnings("ignore:magnetic_pressure reaches")
def test_faces_of_both_bodies_make_the_gap():
    x, y = np.linspace(-0.04, 0.04, 17), np.linspace(-0.02, 0.02, 5)
    flat = block_mesh(x, y, 0.04)
    upper = [mtb.Support("top", x=0, y=0, z=0)]
    lower = [mtb.Support("bottom", x=0, y=0, z=0)]
    below = flat.moved(np.diag([1.0, -1.0, -1.0]))
    crown, radius, shift = [], 20.0, -1e-6
    for up, down in (
        (cambered(flat, radius, 0.0, 1.0), below),
        (flat, cambered(below, radius, 0.0, -1.0)),
        # half of the crown on each, and both somewhere else
        (cambered(flat, 2 * radius, 0.0, 1.0), cambered(below, 2 * radius, 0.0, -1.0)),
    ):
        pair = [
            mtb.ElasticBody(mesh.moved(shift=(0.3, 0.1, 2.0)), steel, "contact", held, name)
            for mesh, held, name in ((up, upper, "up"), (down, lower, "down"))
        ]
        crown.append(mtb.Scene(*pair, spacing=5e-3, friction=0.2, magnetic_pressure=3e7).solve())
        # lower bodies that lie lower are nearer by no approach
        pair[1] = mtb.ElasticBody(down.moved(shift=(0.3, 0.1, 2.0 + shift)), steel, "contact", lower, "down")
        apart = mtb.Scene(*pair, spacing=5e-3, friction=0.2, magnetic_pressure=3e7).solve()
        np.testing.assert_allclose(apart.initial_gap, crown[-1].initial_gap - shift, atol=1e-12)
        assert apart.normal_force < 0.98 * crown[-1].normal_force
    exact = (x - x.mean()) ** 2 / (2 * radius)
    for result in crown:
        # means over hats 5 mm wide of a parabola
        np.testing.assert_allclose(
            result.initial_gap[:, 1:-1],
            np.broadcast_to(exact[1:-1], (9, 15)) + 5e-3**2 / (12 * radius),
            rtol=2e-3,
        )
        assert (result.pressure[4, [0, -1]] == 0.0).all()
        assert result.normal_force == pytest.approx(crown[0].normal_force, rel=3e-3)
        assert result.report.force_balance["relative_error"] < 1e-9


@pytest.mark.coarse
def test_a_curved_face_keeps_all_of_its_pull():
    x, y = np.linspace(-0.04, 0.04, 17), np.linspace(-0.02, 0.02, 5)
    mesh = cambered(block_mesh(x, y, 0.04), 0.3, 0.0, 1.0)
    body = mtb.ElasticBody(mesh, steel, "contact", [mtb.Support("top", x=0, y=0, z=mtb.Guide())])
    # it touches along one row of points
    with pytest.warns(UserWarning, match=r"where the bodies close by \S+ m: the edge is known to a"):
        result = mtb.Scene(body, mtb.Rigid(), spacing=5e-3, friction=0.0, magnetic_pressure=3e6).solve()
    assert result.area.sum() == pytest.approx(0.08 * 0.04, rel=1e-9)
    assert result.normal_force == pytest.approx(3e6 * 0.08 * 0.04, rel=1e-9)


@pytest.mark.coarse
def test_a_round_face_on_a_wider_body_is_in_balance():
    pytest.importorskip("gmsh")
    punch = trimesh.creation.cylinder(radius=0.02, height=0.03, sections=40).apply_translation((0, 0, 0.015))
    upper = mtb.ElasticBody.from_mesh(
        punch, steel, supports=[mtb.Support("top", x=0, y=0)], size=5e-3, name="punch"
    )
    x = np.linspace(-0.03, 0.03, 13)
    plate = block_mesh(x, x, 0.02).moved(np.diag([1.0, -1.0, -1.0]))
    lower = mtb.ElasticBody(plate, steel, "contact", [mtb.Support("bottom", x=0, y=0, z=0)], "plate")
    result = mtb.Scene(upper, lower, spacing=5e-3, friction=0.3, force=1e4).solve()
    assert result.normal_force == pytest.approx(1e4, rel=1e-9)
    assert result.report.force_balance["relative_error"] < 1e-9
    assert result.area.sum() == pytest.approx(np.pi * 0.02**2, rel=0.01)
    answer = sum(state.reactions["bottom"] for state in [result.states()["plate"]])
    np.testing.assert_allclose(answer, -result.force, atol=1e-2)


def test_a_body_within_another_is_suspected():
    pair = [block(upper=True, name="up"), block(upper=False, name="down")]
    pair[1] = mtb.ElasticBody(
        pair[1].mesh.moved(shift=(0.0, 0.0, 1e-3)), steel, "top", pair[1].supports, "down"
    )
    with pytest.warns(UserWarning, match="up and down overlap by up to 0.001 m before any load"):
        mtb.Scene(*pair, spacing=1e-2, force=5e3).solve()
    pair[1] = mtb.ElasticBody(
        pair[1].mesh.moved(shift=(0.2, 0.0, 0.0)), steel, "top", pair[1].supports, "down"
    )
    with pytest.raises(ValueError, match="up and down have no area in common: seen along z"):
        mtb.Scene(*pair, spacing=1e-2, force=5e3).solve()


@pytest.mark.coarse
def test_meshes_too_coarse_for_their_contact_are_told():
    x = np.linspace(-0.04, 0.04, 9)
    flat = block_mesh(x, x, 0.04)
    held = [mtb.Support("top", x=0, y=0, z=mtb.Guide())]

    def solve(mesh, spacing):
        body = mtb.ElasticBody(mesh, steel, "contact", held)
        return mtb.Scene(body, steel, spacing=spacing, friction=0.0, force=2e5).solve()

    solve(flat, 5e-3)
    with pytest.warns(UserWarning, match=r"nodes of body .* 0\.005 x 0\.005 m apart, the cells .* 0\.0025 x"):
        solve(flat, 2.5e-3)
    # the same crown of flat facets, and of curved elements
    curved = cambered(flat, 2.0, 0.0, 1.0)
    solve(curved, 5e-3)
    straight = quadratic(mtb.TetraMesh(*corners_only(curved)))
    straight = mtb.TetraMesh(straight.nodes, straight.cells, {"contact": low_nodes(straight)})
    with pytest.warns(UserWarning, match=r"flat facets, about \S+e-06 m off the smooth surface"):
        solve(straight, 5e-3)


def test_a_steep_contact_is_told():
    """Two cylinders' halves that fit into each other: their flanks rise by a half."""
    x = np.linspace(-0.04, 0.04, 17)
    flat = block_mesh(x, np.linspace(-0.02, 0.02, 5), 0.04)
    up = mtb.ElasticBody(
        cambered(flat, 0.08, 0.0, -1.0), steel, "contact", [mtb.Support("top", x=0, y=0, z=0)], "up"
    )
    below = cambered(flat.moved(np.diag([1.0, -1.0, -1.0])), 0.08, 0.0, -1.0)
    down = mtb.ElasticBody(below, steel, "contact", [mtb.Support("bottom", x=0, y=0, z=0)], "down")
    with pytest.warns(UserWarning, match=r"contact face of (up|down) has a slope of 0\.29 where it touches"):
        result = mtb.Scene(up, down, spacing=5e-3, friction=0.0, magnetic_pressure=3e6).solve()
    np.testing.assert_allclose(result.initial_gap, 0.0, atol=1e-12)


@pytest.mark.coarse
@pytest.mark.filterwarnings("ignore:the upper body deforms")
def test_linear_tetrahedra_become_quadratic_unless_wanted():
    x = np.linspace(-0.02, 0.02, 9)
    fine = block_mesh(x, x, 0.02)
    coarse = mtb.TetraMesh(*corners_only(fine))
    held = [mtb.Support("top", x=0, y=0, z=mtb.Guide(-5e3))]

    def sinks(mesh, ratio, *, linear=False):
        body = mtb.ElasticBody(mesh, mtb.Material(5e6, ratio), "bottom", held, "pad", linear)
        result = mtb.Scene(body, mtb.Rigid(), spacing=5e-3, friction=0.3).solve()
        return -result.states()["pad"].displacement[2, body.nodes_at("top", "top")].mean()

    for ratio in (0.3, 0.44, 0.4999):
        assert sinks(coarse, ratio) == pytest.approx(sinks(fine, ratio), rel=1e-8)
    with pytest.warns(UserWarning, match=r"pad keeps tetrahedra of four nodes .*without linear=True"):
        assert sinks(coarse, 0.44, linear=True) < 0.98 * sinks(fine, 0.44)
    with pytest.warns(UserWarning, match=r"above poisson_ratio = 0\.45 they lock \(it is 0\.4999\)"):
        locked = sinks(coarse, 0.4999, linear=True)
    assert locked < 0.5 * sinks(fine, 0.4999)


def test_a_bent_arm_of_linear_tetrahedra_bends_as_a_beam(tmp_path):
    """Through every door; sets of nodes get the new nodes between their own."""
    meshio = pytest.importorskip("meshio")
    length, side = 0.1, 0.01
    mesh = block_mesh(np.linspace(0.0, length, 21), np.linspace(0.0, side, 3), side, quadratic=False)
    path = tmp_path / "arm.vtu"
    meshio.Mesh(mesh.nodes, [("tetra", mesh.cells)]).write(path)
    held = [mtb.Support("rear", x=0, y=0, z=0), mtb.Support("front", z=1e-6)]
    bodies = [
        mtb.ElasticBody(mesh, mtb.steel, "bottom", held, "arm"),
        mtb.ElasticBody.from_mesh(mesh, mtb.steel, "m", "bottom", held, name="arm"),
        mtb.ElasticBody.from_mesh(
            path,
            mtb.steel,
            "m",
            "bottom",
            [
                mtb.Support(lambda p: p[0] < 1e-9, x=0, y=0, z=0),
                mtb.Support(lambda p: p[0] > length - 1e-9, z=1e-6),
            ],
        ),
    ]
    beam = 3.0 * mtb.steel.young_modulus * side**4 / 12.0 / length**3 * 1e-6
    for body in bodies:
        assert body.mesh.is_quadratic
        free = np.zeros((3, len(body.mesh.nodes)))
        u = body.core.solve(free, body.case_values, np.zeros((0, 9)), np.zeros(0))
        forces = body.core.reactions(u, free, (0.0, 0.0, 0.0))[0]
        assert forces[1][2] == pytest.approx(beam, rel=0.03)
    with pytest.warns(UserWarning, match="linear=True"):
        stiff = mtb.ElasticBody(mesh, mtb.steel, "bottom", held, "arm", linear=True)
    free = np.zeros((3, len(stiff.mesh.nodes)))
    u = stiff.core.solve(free, stiff.case_values, np.zeros((0, 9)), np.zeros(0))
    assert stiff.core.reactions(u, free, (0.0, 0.0, 0.0))[0][1][2] > 1.2 * beam


@pytest.mark.coarse
def test_a_rounded_edge_within_the_contact_face_is_told():
    """Its edge is inside of cells, and no kink tells where: the flat part would end before it."""
    x = np.linspace(-0.04, 0.04, 17)
    flat = block_mesh(x, np.linspace(-0.02, 0.02, 5), 0.04)
    held = [mtb.Support("top", x=0, y=0, z=mtb.Guide(-2e4))]

    def solve(slope, end=0.04):
        rise = slope * np.maximum(0.0, flat.nodes[:, 0] - 0.02) ** 2 / 0.005
        nodes = flat.nodes + np.outer(rise * (1.0 - flat.nodes[:, 2] / 0.04), [0.0, 0.0, 1.0])
        face = flat.node_sets["contact"]
        mesh = mtb.TetraMesh(nodes, flat.cells, {**flat.node_sets, "contact": face[nodes[face, 0] <= end]})
        body = mtb.ElasticBody(mesh, steel, "contact", held)
        return mtb.Scene(body, steel, spacing=7e-3, friction=0.2).solve()

    with pytest.warns(UserWarning, match=r"gap opens by 0\.00\d+ m within the cells .* near x = 0\.0"):
        early = solve(0.1)
    assert early.points[0][early.status > 0].max() < 0.02
    # a face that ends where the chamfer begins, and one as good as flat, are met
    assert solve(0.1, 0.02 + 1e-9).area.sum() == pytest.approx(0.06 * 0.04, rel=1e-9)
    solve(1e-5)


@pytest.mark.coarse
def test_a_flat_face_at_an_angle_has_no_facets():
    """What rounding makes of a plane is no curve."""
    x = np.linspace(-0.02, 0.02, 9)
    flat = block_mesh(x, x, 0.04)
    turn = trimesh.transformations.rotation_matrix(0.1, [0, 1, 0])[:3, :3]
    mesh = flat.moved(turn)
    mesh = mtb.TetraMesh(
        mesh.nodes, mesh.cells, {**mesh.node_sets, "back": np.flatnonzero(flat.nodes[:, 2] > 0.04 - 1e-9)}
    )
    body = mtb.ElasticBody(mesh, steel, "contact", [mtb.Support("back", x=0, y=0, z=mtb.Guide(-5e3))])
    with pytest.warns(UserWarning, match="the gap opens by") as told:
        mtb.Scene(body, steel, spacing=5e-3, friction=0.2).solve()
    assert [one.category for one in told if one.category is not mtb.ToleranceWarning] == [UserWarning]
    # and one that looks along x is no contact face
    side = mtb.ElasticBody(
        flat.moved(trimesh.transformations.rotation_matrix(np.pi / 2, [0, 1, 0])[:3, :3]), steel, "contact"
    )
    with pytest.raises(ValueError, match="it must face along z"):
        mtb.Scene(side, steel, spacing=5e-3, friction=0.2, force=1e3).solve()


def low_nodes(mesh):
    return np.flatnonzero(mesh.nodes[:, 2] < 1e-3)


def corners_only(mesh):
    used, cells = np.unique(mesh.cells[:, :4], return_inverse=True)
    return mesh.nodes[used], cells.reshape(-1, 4)


def chamfered(slope, end, spacing, *, ends=False):
    """A block pressed down whose face rises from x = `end` on, or ends there."""
    x = np.concatenate([np.linspace(-0.04, end, 17), np.linspace(end, 0.04, 6)[1:]])
    flat = block_mesh(x, np.linspace(-0.02, 0.02, 7), 0.04)
    rise = slope * np.maximum(0.0, flat.nodes[:, 0] - end) * (1.0 - flat.nodes[:, 2] / 0.04)
    nodes = flat.nodes + np.outer(rise, [0.0, 0.0, 1.0])
    face = flat.node_sets["contact"]
    face = face[nodes[face, 0] <= end + 1e-9] if ends else face
    mesh = mtb.TetraMesh(nodes, flat.cells, {"contact": face})
    body = mtb.ElasticBody(mesh, steel, "contact", [mtb.Support("top", x=0, y=0, z=-2e-6)])
    return mtb.Scene(body, steel, spacing=spacing, friction=0.2).solve()


@pytest.mark.coarse
@pytest.mark.slow
def test_a_kink_within_cells_divides_them():
    """A face that ends at the kink, on a finer grid, is the truth: nothing behind the kink touches."""
    truth = chamfered(0.1, 0.0213, 3e-3, ends=True).normal_force
    for spacing in (1e-2, 8e-3, 5e-3):
        found = chamfered(0.1, 0.0213, spacing)
        assert found.normal_force == pytest.approx(truth, rel=0.015)
        assert found.area.sum() == pytest.approx(0.08 * 0.04, rel=1e-9)


def relieved(kink, spacing, ends=False):
    """A block whose face turns away from a flat rectangle on all four sides: its kinks cross."""
    x = np.linspace(-0.04, 0.04, 13)
    flat = block_mesh(x, np.linspace(-0.02, 0.02, 9), 0.03)
    nodes = np.array(flat.nodes)
    # rows of nodes at the kinks, which lie anywhere in the cells of the contact
    for axis, (old, side) in enumerate(((0.02, 0.04), (0.01, 0.02))):
        new = (2.0 * kink, kink)[axis]
        nodes[:, axis] = np.interp(nodes[:, axis], [-side, -old, old, side], [-side, -new, new, side])
    away = np.maximum(np.abs(nodes[:, 0]) - 2.0 * kink, 0.0) + np.maximum(np.abs(nodes[:, 1]) - kink, 0.0)
    nodes[:, 2] += 0.02 * away * (1.0 - flat.nodes[:, 2] / 0.03)
    face = flat.node_sets["contact"]
    face = face[away[face] < 1e-9] if ends else face
    mesh = mtb.TetraMesh(nodes, flat.cells, {"contact": face, "top": flat.node_sets["top"]})
    body = mtb.ElasticBody(mesh, steel, "contact", [mtb.Support("top", x=0, y=0, z=-1e-6)])
    return mtb.Scene(body, steel, spacing=spacing, friction=0.2)


@pytest.mark.coarse
@pytest.mark.filterwarnings("ignore")  # of the spacing, and of facets beside the kinks
@pytest.mark.parametrize("kink", [0.009, 0.0105, 0.012])
def test_kinks_that_cross_divide_the_cells_too(kink):
    truth = relieved(kink, 3e-3, ends=True).solve().normal_force
    scene = relieved(kink, 5e-3)
    assert parts(scene.upper).max() == 8
    assert scene.solve().normal_force == pytest.approx(truth, rel=0.05)


@pytest.mark.coarse
def test_a_roof_presses_with_both_sides_alike():
    """A ridge within cells: as the grid moves over it, its two sides share the force."""
    x = np.linspace(-0.04, 0.04, 25)
    flat = block_mesh(x, np.linspace(-0.02, 0.02, 7), 0.04)
    rise = 1e-4 * np.abs(flat.nodes[:, 0]) * (1.0 - flat.nodes[:, 2] / 0.04)
    mesh = mtb.TetraMesh(flat.nodes + np.outer(rise, [0, 0, 1]), flat.cells, flat.node_sets)
    body = mtb.ElasticBody(mesh, steel, "contact", [mtb.Support("top", x=0, y=0, z=-5e-6)])
    forces = []
    for cells in (12, 13, 20, 21):
        result = mtb.Scene(body, mtb.Rigid(), spacing=(0.08 / cells, 5e-3), friction=0.0).solve()
        np.testing.assert_allclose(result.pressure, result.pressure[:, ::-1], rtol=1e-6, atol=1e2)
        forces.append(result.normal_force)
    np.testing.assert_allclose(forces, forces[-1], rtol=0.02)


@pytest.mark.coarse
def test_no_point_lies_beside_the_face():
    """A face with a round border: the hats of nodes beside it press where the rest of them lies."""
    pytest.importorskip("gmsh")
    disc = trimesh.creation.cylinder(radius=0.02, height=0.02, sections=64).apply_translation((0, 0, 0.01))
    body = mtb.ElasticBody.from_mesh(disc, steel, supports=[mtb.Support("top", x=0, y=0)], size=4e-3)
    result = mtb.Scene(body, steel, spacing=5e-3, friction=0.3, force=1e4).solve()
    loaded = result.pressure > 0.0
    assert np.hypot(*result.points[:2][:, loaded]).max() < 0.0201
    assert result.area.sum() == pytest.approx(np.pi * 0.02**2, rel=0.01)
    assert result.report.force_balance["relative_error"] < 1e-9


def worn_pair(gap=None, lower=None, spacing=2.5e-3, upper=True):
    """A flat block against a surface, or a function of it."""
    x, y = np.linspace(-0.02, 0.02, 13), np.linspace(-0.01, 0.01, 7)
    body = mtb.ElasticBody(block_mesh(x, y, 0.02), steel, "contact", [mtb.Support("top", x=0, y=0)])
    lower = mtb.HalfSpace(steel) if lower is None else lower
    return mtb.Scene(body, lower, gap=gap, spacing=spacing, force=2e4, friction=0.1)


def crowned(radius=8.0):
    y = np.linspace(-0.03, 0.03, 61)
    return mtb.Profile.from_points(y, -(y**2) / (2 * radius))


@pytest.mark.coarse
def test_a_surface_and_a_function_make_the_same_gap():
    radius = 8.0
    x, y = np.meshgrid(np.linspace(-0.04, 0.04, 41), np.linspace(-0.04, 0.04, 41))
    field = mtb.BodySurface.height_field(-(y**2) / (2 * radius), 2e-3)
    pieces = np.arange(40) + 41 * np.arange(40)[:, None]
    quads = np.stack([pieces, pieces + 1, pieces + 42, pieces + 41]).reshape(4, -1)
    triangles = np.concatenate([quads[[0, 1, 2]].T, quads[[0, 2, 3]].T])
    points = np.stack([x.ravel(), y.ravel(), -(y.ravel() ** 2) / (2 * radius)])
    results = [
        worn_pair(gap=lambda x, y: y**2 / (2 * radius)).solve(),
        worn_pair(lower=mtb.HalfSpace(steel, crowned(radius))).solve(),
        worn_pair(lower=mtb.HalfSpace(steel, field)).solve(),
        worn_pair(lower=mtb.HalfSpace(steel, mtb.BodySurface.mesh(points, triangles, closed=False))).solve(),
        worn_pair(lower=mtb.HalfSpace(steel, trimesh.Trimesh(points.T, triangles))).solve(),
    ]
    for result in results[1:]:
        np.testing.assert_allclose(result.initial_gap, results[0].initial_gap, atol=2e-9)
        np.testing.assert_allclose(
            result.pressure, results[0].pressure, atol=5e-3 * results[0].pressure.max()
        )
    with pytest.raises(ValueError, match="gap is given as well"):
        worn_pair(gap=lambda x, y: 0.0 * x, lower=mtb.HalfSpace(steel, "60E1"))
    with pytest.raises(ValueError, match=r"no body is an ElasticBody"):
        mtb.Scene(mtb.Rigid("60E1"), steel, gap=np.zeros((5, 5)), force=1.0)
    with pytest.raises(ValueError, match="gap is a function, which takes an ElasticBody"):
        mtb.Scene(steel, steel, gap=lambda x, y: x, force=1.0)
    with pytest.raises(ValueError, match="a surface alone has no material"):
        worn_pair(lower=crowned())
    with pytest.raises(ValueError, match="the function gap fails with ZeroDivisionError"):
        worn_pair(gap=lambda x, y: 1 / 0).solve()
    with pytest.raises(ValueError, match=r"the function gap returns shape \(2,\)"):
        worn_pair(gap=lambda x, y: np.zeros(2)).solve()


@pytest.mark.coarse
def test_an_upper_surface_presses_as_its_mirror_image_from_below():
    x, y = np.linspace(-0.02, 0.02, 13), np.linspace(-0.01, 0.01, 7)
    mesh = block_mesh(x, y, 0.02).moved(np.diag([1.0, -1.0, -1.0]))
    table = mtb.ElasticBody(mesh, steel, "contact", [mtb.Support("bottom", x=0, y=0, z=0)])
    x, y = (
        field.ravel() for field in np.meshgrid(np.linspace(-0.04, 0.04, 33), np.linspace(-0.03, 0.03, 25))
    )
    pieces = (np.arange(32) + 33 * np.arange(24)[:, None]).ravel()
    quads = np.stack([pieces, pieces + 1, pieces + 34, pieces + 33])
    triangles = np.concatenate([quads[[2, 1, 0]].T, quads[[3, 2, 0]].T])
    shape = mtb.BodySurface.mesh(np.stack([x, y, (x**2 + y**2) / 16.0]), triangles, closed=False)
    load = {"spacing": 1.5e-3, "force": 1e4, "friction": 0.0}
    ball = mtb.Scene(mtb.Rigid(shape), table, **load).solve()
    graph = mtb.Scene(mtb.Rigid(), table, gap=lambda x, y: (x**2 + y**2) / 16.0, **load).solve()
    np.testing.assert_allclose(ball.initial_gap, graph.initial_gap, atol=2e-8)
    np.testing.assert_allclose(ball.pressure, graph.pressure, atol=0.02 * graph.pressure.max())


@pytest.mark.coarse
def test_a_contact_of_two_cells_is_told_with_any_gap():
    radius = 0.5
    at = np.linspace(-0.02, 0.02, 17), np.linspace(-0.01, 0.01, 9)
    field = np.broadcast_to(at[0] ** 2 / (2 * radius), (9, 17))
    for gap in (field, lambda x, y: x**2 / (2 * radius)):
        with pytest.warns(UserWarning, match=r"points wide along x|gap opens by"):
            worn_pair(gap=gap).solve()


@pytest.mark.coarse
def test_beside_an_opponent_there_is_no_contact():
    narrow = worn_pair(lower=mtb.Rigid(mtb.BodySurface.block(0.02, 0.03)), spacing=2e-3).solve()
    assert narrow.area.sum() == pytest.approx(0.02 * 0.02, rel=1e-6)
    assert np.abs(narrow.points[0][narrow.pressure > 0.0]).max() <= 0.01 + 1e-9
    holed = worn_pair(gap=lambda x, y: np.where(np.abs(x) < 0.01, 0.0, np.inf), spacing=2e-3).solve()
    assert holed.area.sum() == pytest.approx(0.02 * 0.02, rel=0.02)
    assert np.abs(holed.points[0][holed.pressure > 0.0]).max() <= 0.01 + 1e-9
