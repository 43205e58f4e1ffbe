# SPDX-License-Identifier: MIT OR Apache-2.0
"""Prisms under cells in rows: against half-spaces, scenes, an own dense model, mirrors, and CONTACT."""

from __future__ import annotations

import pickle
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import mtb_rs as mtb
from mtb_rs.geometry.geometries import BlockOnPlane

from .test_inclination import dense

Array = NDArray[np.float64]
BODY = mtb.Material.from_shear_modulus(82e9, 0.28)
SOFT = mtb.Material.from_shear_modulus(30e9, 0.35)
FRICTION = mtb.Coulomb(0.3)


def corner(
    radius: float = 10e-3,
    size: float = 0.1,
    *,
    turn: float = 0.5 * np.pi,
    upper: bool = False,
    flipped: bool = False,
    **given: Any,
) -> mtb.Prism:
    """A quarter of the plane with a round corner, which falls towards y < 0, or the three others above it.

    With less of a `turn` [rad] the corner lies between faces that turn less.
    """
    angle = 0.75 * np.pi + np.linspace(0.5, -0.5, 401) * turn
    arc = radius * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    ahead = size * np.stack([np.sin(angle), -np.cos(angle)], axis=1)
    free = np.concatenate([[arc[0] - ahead[0]], arc, [arc[-1] + ahead[-1]]])
    base = np.array([[size, size], [-size, size], [-size, -size]] if upper else [[size, -size]])
    middle = arc[200]
    if flipped:
        free, base, middle = (points * [-1.0, 1.0] for points in (free[::-1], base[::-1], middle))
    return mtb.Prism(free, base=base, origin=tuple(middle), **{"material": BODY} | given)


def gap(nx: int, ny: int, side: float, lean: float = 0.0) -> Array:
    x, s = ((np.arange(n) - 0.5 * (n - 1)) * side for n in (nx, ny))
    return np.asarray(x**2 / (2 * 0.6) + (s**2 * (1.0 / 0.01 - 1.0 / 0.0104) / 2 + lean * s)[:, None])


def pressed(nx: int = 14, ny: int = 11, side: float = 1.2e-3, **given: Any) -> mtb.NormalResult:
    bodies: dict[str, Any] = {"lower": corner(), "upper": corner(upper=True)}
    load = {} if {"force", "approach"} & set(given) else {"approach": 6e-5}
    lean = given.pop("lean", 0.0)
    options = {"edge": "sharp", "tolerance": 1e-10} | bodies | load | given
    return mtb.solve_normal(gap(nx, ny, side, lean), side, **options)


def test_the_body_on_a_prism_has_the_stress_of_its_tractions() -> None:
    """Forces at the cells on a half-space [Boussinesq]: 3 F z^3 / (2 pi r^5), far below single cells."""
    result = pressed(upper=mtb.steel)
    place = np.array([0.4e-3, -0.3e-3, 30e-3])
    place[:2] += result.points.reshape(3, -1)[:2].mean(axis=1)
    away = place[:2, None] - result.points.reshape(3, -1)[:2]
    forces = (result.pressure * result.area).ravel()
    distance = np.sqrt((away**2).sum(axis=0) + place[2] ** 2)
    known = -(3.0 * forces * place[2] ** 3 / (2.0 * np.pi * distance**5)).sum()
    found = result.stress("upper", points=place[:, None]).zz[0]
    assert found == pytest.approx(known, rel=1e-3)
    rolling = mtb.solve_tangential(result, mtb.Rolling((5e-4, 0.0, 0.0)), FRICTION)
    assert rolling.stress("upper", depths=[1e-3]).von_mises.max() > 0.0


def beside(result: mtb.NormalResult, ahead: float = 0.0) -> Array:
    """What the prisms do beside half-spaces, as a matrix (3, 3, n, n)."""
    prisms = result._prisms()
    assert prisms is not None
    ny, nx = result.pressure.shape
    dx = result.spacing[0]
    offsets = np.arange(1 - nx, nx) * dx + ahead
    table = prisms.core.influence(offsets).reshape(2 * nx - 1, 3, 3, ny, ny)
    own = np.arange(nx * ny)
    column, row = own % nx, own // nx
    apart = column[:, None] - column + nx - 1
    pairs = [[table[apart, o, k, row[:, None], row] for k in range(3)] for o in range(3)]
    return np.array(pairs)


def whole(result: mtb.NormalResult, ahead: float = 0.0) -> Array:
    """Influence of squares on two half-spaces of one material and of the prisms beside them, as matrices."""
    ny, nx = result.pressure.shape
    side = result.spacing[0]
    # a grid with one column more on either side has the half-space at whole cells ahead
    shift = round(ahead / side)
    plain = dense(nx + 2, ny, side)
    cells = np.arange(nx * ny)
    seen, loaded = ((cells // nx) * (nx + 2) + cells % nx + 1 + s for s in (shift, 0))
    take = {name: matrix[np.ix_(seen, loaded)] for name, matrix in plain.items()}
    none = np.zeros_like(take["zz"])
    half = [
        [take["xx"], take["xy"], none],
        [take["xy"], take["yy"], none],
        [none, none, take["zz"]],
    ]
    return np.array(half) + beside(result, ahead)


def test_a_large_flat_prism_is_a_half_space() -> None:
    """Within half a percent in the middle of a bar of 0.4 m, but for what it does evenly under a force."""
    x = (np.arange(20) - 9.5) * 0.5e-3
    heights = x**2 / 1.0 + x[:, None] ** 2 / 1.0
    plain = mtb.solve_normal(heights, 0.5e-3, lower=BODY, upper=BODY, force=2e4, tolerance=1e-10)
    bar = mtb.Prism((0.4, 0.4), BODY)
    above = mtb.Prism([(-0.2, 0.4), (-0.2, 0.0), (0.2, 0.0), (0.2, 0.4)], BODY, origin=(0.0, 0.0))
    under: dict[str, Any] = {"lower": BODY, "force": 2e4, "tolerance": 1e-10}
    by_points = mtb.solve_normal(heights, 0.5e-3, upper=above, **under)
    by_sides = mtb.solve_normal(heights, 0.5e-3, upper=bar, **under)
    assert np.array_equal(by_points.pressure, by_sides.pressure)
    for bodies in ({"lower": bar, "upper": BODY}, {"lower": BODY, "upper": bar}):
        found = mtb.solve_normal(heights, 0.5e-3, force=2e4, tolerance=1e-10, **bodies)
        assert np.abs(found.pressure - plain.pressure).max() < 5e-3 * plain.pressure.max()
        # F / (G size) and some
        assert abs(found.approach - plain.approach) < 2e4 / (82e9 * 0.4)
        assert found.report.converged
        assert "unknowns in its section" in found.report.notes[0]


@pytest.mark.parametrize(("thickness", "share"), [(1e-3, 0.995), (5e-5, 0.7)])
def test_a_plate_thinner_than_a_cell_is_asked_about(thickness: float, share: float) -> None:
    """On a held base it is an elastic foundation of its oedometric modulus, or a layer of its material."""
    x = (np.arange(11) - 5.0) * 0.25e-3
    heights = 0.008 * thickness * (x**2 + x[:, None] ** 2) / 1e-6
    free = [(-0.02, -thickness), (-0.02, 0.0), (0.02, 0.0), (0.02, -thickness)]
    plate = mtb.Prism(free, material=BODY, origin=(0.0, 0.0))
    given: dict[str, Any] = {"upper": mtb.Rigid(), "approach": 0.004 * thickness}
    layer = mtb.solve_normal(heights, 0.25e-3, lower=mtb.Layered(BODY, thickness, mtb.Rigid()), **given)
    if share > 0.9:
        found = mtb.solve_normal(heights, 0.25e-3, lower=plate, **given)
        assert found.normal_force == pytest.approx(layer.normal_force, rel=5e-3)
        return
    with pytest.warns(mtb.ToleranceWarning, match="thin beside the cells"):
        found = mtb.solve_normal(heights, 0.25e-3, lower=plate, **given)
    assert share < found.normal_force / layer.normal_force < 0.8


def test_cells_in_rows_are_those_of_scenes() -> None:
    """A bar under the cells of a scene, which divide its section and take its waves in another way."""
    bar, spacing = mtb.Prism((0.06, 0.05), BODY), (1e-3, 1e-3)
    grid = BlockOnPlane(0.02, 0.012, 0.02).grid(spacing)
    theirs = bar.on(grid.cells, grid.patches, hats=False).compliance
    ny, nx = grid.patches[0].ny, grid.patches[0].nx
    found = mtb.solve_normal(
        np.zeros((ny, nx)), 1e-3, lower=bar, upper=mtb.Rigid(), force=2e3, edge="sharp", tolerance=1e-10
    )
    x, y = found.points[:2].reshape(2, -1)
    hill = np.cos(np.pi * x / 0.02) ** 2 * np.cos(np.pi * y / 0.012) ** 2
    # of one half-space, not of two
    matrix = whole(found) - 0.5 * (whole(found) - beside(found))
    for loaded in range(3):
        traction = np.zeros((3, hill.size))
        traction[loaded] = hill
        moved = theirs.displacement(traction)
        own = matrix[loaded, loaded] @ hill
        assert np.abs(own - moved[loaded]).max() < 3e-3 * np.abs(moved[loaded]).max()
        for observed in range(3):
            # half-spaces of one material move each other alike: what couples is of the bar alone
            if {observed, loaded} == {0, 1}:
                across = matrix[observed, loaded] @ hill
                assert np.abs(across - moved[observed]).max() < 3e-3 * np.abs(moved[loaded]).max()


def test_gap_of_an_own_dense_model() -> None:
    found = pressed()
    moved = whole(found)[2, 2] @ found.pressure.ravel()
    opened = found.initial_gap.ravel() - found.approach + moved
    assert np.abs(opened - found.gap.ravel()).max() < 1e-9 * moved.max()
    assert np.abs(opened[found.pressure.ravel() > 0.0]).max() < 1e-6 * moved.max()


@pytest.mark.parametrize("kind", ["steady", "backwards", "shift", "transient"])
def test_slip_of_an_own_dense_model(kind: str) -> None:
    """Displacements by all tractions and pressures, and the rigid slip, make up the slip."""
    normal = pressed()
    side, shape = normal.spacing[0], (2, *normal.pressure.shape)
    motions: dict[str, Any] = {
        "steady": mtb.Rolling((-6e-4, 3e-4, 0.2)),
        "backwards": mtb.Rolling((-6e-4, 3e-4, 0.0), angle=np.pi),
        "shift": mtb.Shift((-6e-6, 2e-6)),
        "transient": mtb.Rolling((-6e-4, 3e-4, 0.0), transient=True),
    }
    found = mtb.solve_tangential(normal, motions[kind], FRICTION, tolerance=1e-10)
    assert np.any(found.status == 1)
    assert np.any(found.status == 2)

    def moved(ahead: float) -> Array:
        matrix = whole(normal, ahead)
        loads = [found.traction[0].ravel(), found.traction[1].ravel(), normal.pressure.ravel()]
        parts = [sum(matrix[o, k] @ loads[k] for k in range(3)) for o in range(2)]
        return np.array(parts).reshape(shape)

    motion = motions[kind]
    way = {"backwards": -side, "shift": 0.0}.get(kind, side)
    x, y = normal.points[:2]
    spin = motion.rigid[2] if kind != "shift" else 0.0
    rigid = np.stack([motion.rigid[0] - spin * y, motion.rigid[1] + spin * (x + way / 6.0)])
    if kind == "shift":
        slip = rigid - moved(0.0)
    elif kind == "transient":
        slip = rigid - moved(0.0) / side
    else:
        slip = rigid - (moved(0.0) - moved(way)) / side
    touches = normal.pressure > 0.0
    assert np.abs((slip - found.slip)[:, touches]).max() < 1e-7 * np.abs(found.slip).max()


def test_friction_works_what_becomes_heat() -> None:
    """Of like and of unlike prisms in a shift from rest: the heat is the work of the traction at the slip."""
    for upper in (corner(upper=True), corner(upper=True, material=SOFT), SOFT, mtb.Rigid()):
        normal = pressed(upper=upper)
        found = mtb.solve_tangential(normal, mtb.Shift((6e-6, -3e-6)), FRICTION, tolerance=1e-10)
        assert np.any(found.status == 2)
        work = 0.5 * np.sum(found.traction[:2] * found.slip, axis=0)
        assert np.all(work >= -1e-9 * np.abs(work).max())
        steady = mtb.solve_tangential(normal, mtb.Rolling((4e-4, -3e-4, 0.1)), FRICTION, tolerance=1e-10)
        # the influence is symmetric: elastic parts cancel, and rigid slip and slip by pressure are left
        x, y = normal.points[:2]
        middle = x + normal.spacing[0] / 6.0
        rigid = np.stack([4e-4 - 0.1 * y, -3e-4 + 0.1 * middle])
        there = rigid - np.array([0.0, 0.1])[:, None, None] * normal.spacing[0]
        matrix = [beside(normal, a)[:2, 2] for a in (0.0, normal.spacing[0], -normal.spacing[0])]
        p = normal.pressure.ravel()
        pushed = [np.array([part @ p for part in m]).reshape(2, *x.shape) for m in matrix]
        by_pressure = -0.5 * (pushed[0] - pushed[1] + pushed[2] - pushed[0]) / normal.spacing[0]
        unlike = mtb.solve_tangential(
            mtb.PressureField(normal.pressure, normal.spacing, BODY, _medium(upper)),
            mtb.Rolling((4e-4, -3e-4, 0.1)),
            FRICTION,
        )
        assert unlike.friction_power > 0.0
        if upper == corner(upper=True):
            mean = 0.5 * (rigid + there) + by_pressure
            power = float((steady.traction[:2] * mean).sum()) * normal.spacing[0] ** 2
            assert steady.friction_power == pytest.approx(power * steady.motion.slip_speed, rel=1e-6)


def _medium(body: Any) -> Any:
    return None if body == mtb.Rigid() else getattr(body, "material", body)


def test_gap_follows_the_traction() -> None:
    """With full coupling the bodies touch where they press, with the tractions that they have."""
    normal = pressed(18, 15, 0.9e-3)
    rolling = mtb.Rolling((0.0, 4e-3, 0.0))
    found = mtb.solve_tangential(normal, rolling, FRICTION, coupling="full")
    matrix = whole(normal)
    loads = [found.traction[0], found.traction[1], found.pressure]
    moved = sum(matrix[2, k] @ load.ravel() for k, load in enumerate(loads))
    opened = normal.initial_gap.ravel() + moved
    touches = found.pressure.ravel() > 0.0
    assert np.ptp(opened[touches]) < 1e-5 * moved.max()
    alone = mtb.solve_tangential(normal, rolling, FRICTION)
    assert alone.report.omitted["gap_change_by_traction_m"] > 0.0
    assert np.abs(found.pressure - alone.pressure).max() > 0.02 * alone.pressure.max()


def test_seen_in_a_mirror_and_upside_down_it_is_the_same() -> None:
    """Within what other triangles of the section change."""
    creepage = np.array([5e-4, -4e-4, 0.3])
    there = pressed(lean=2e-3)
    found = mtb.solve_tangential(there, mtb.Rolling(tuple(creepage)), FRICTION, coupling="full")
    # y turned round
    mirror = pressed(lean=-2e-3, lower=corner(flipped=True), upper=corner(upper=True, flipped=True))
    assert np.abs(mirror.pressure[::-1] - there.pressure).max() < 5e-3 * there.pressure.max()
    turned = creepage * [1.0, -1.0, -1.0]
    seen = mtb.solve_tangential(mirror, mtb.Rolling(tuple(turned)), FRICTION, coupling="full")
    assert np.abs(seen.traction[0][::-1] - found.traction[0]).max() < 5e-3 * there.pressure.max()
    assert np.abs(seen.traction[1][::-1] + found.traction[1]).max() < 5e-3 * there.pressure.max()
    assert seen.friction_power == pytest.approx(found.friction_power, rel=5e-3)
    # turned about x by half a turn: what was below is above, and its slip over the other one is what it was

    def over(body: mtb.Prism) -> mtb.Prism:
        points, base = -np.array(body.profile), -np.array(body.base)
        return mtb.Prism(points, BODY, base=base, origin=(-body.origin[0], -body.origin[1]))

    # the rows run the other way about: y turns round with the bodies
    upside = pressed(lean=-2e-3, lower=over(corner(upper=True)), upper=over(corner()))
    assert np.abs(upside.pressure[::-1] - there.pressure).max() < 5e-3 * there.pressure.max()
    # now the other body is the upper one, and slides the other way over the lower; seen with y and z turned
    about = mtb.Rolling((-creepage[0], creepage[1], creepage[2]))
    seen = mtb.solve_tangential(upside, about, FRICTION, coupling="full")
    assert np.abs(seen.traction[0][::-1] + found.traction[0]).max() < 5e-3 * there.pressure.max()
    assert np.abs(seen.traction[1][::-1] - found.traction[1]).max() < 5e-3 * there.pressure.max()


def test_twice_as_large_it_is_the_same() -> None:
    """All lengths doubled: the same pressures and tractions."""
    one = pressed()
    heights = 2.0 * gap(14, 11, 1.2e-3)
    two = mtb.solve_normal(
        heights,
        2.4e-3,
        lower=corner(20e-3, 0.2),
        upper=corner(20e-3, 0.2, upper=True),
        approach=12e-5,
        edge="sharp",
        tolerance=1e-10,
    )
    assert np.abs(one.pressure - two.pressure).max() < 1e-5 * one.pressure.max()
    found = [
        mtb.solve_tangential(normal, mtb.Rolling((5e-4, 2e-4, spin)), FRICTION)
        for normal, spin in ((one, 0.4), (two, 0.2))
    ]
    assert np.abs(found[0].traction - found[1].traction).max() < 1e-5 * one.pressure.max()


@pytest.mark.parametrize("foundation", [None, (1e8, 5e7)])
def test_a_rail_that_gives_way_sideways_sticks_and_rolls(foundation: tuple[float, float] | None) -> None:
    """It gives way a hundred times as much as the contact; a force and the shift found for it agree."""
    rail = mtb.Prism("60E1", foundation=foundation)
    side = 0.6e-3
    x = side * (np.arange(20) - 9.5)
    normal = mtb.solve_normal((x**2 + x[:, None] ** 2) / 0.6, side, lower=rail, upper=mtb.steel, force=2e4)
    for size in (1e-7, 1e-6, 1e-5, 1e-4):
        given = mtb.solve_tangential(normal, mtb.Shift((0.0, size)), FRICTION)
        assert 0.0 < given.force[1] < 0.3 * 2e4
    forced = mtb.solve_tangential(normal, mtb.Shift((0.0, 0.0), force=(None, 12.0)), FRICTION)
    back = mtb.solve_tangential(normal, mtb.Shift((0.0, float(forced.creepage[1]))), FRICTION)
    assert back.force[1] == pytest.approx(12.0, rel=1e-5)
    state = None
    for _ in range(6):
        rolling = mtb.Rolling((1e-3, -1e-3, 0.0), transient=True)
        state = mtb.solve_tangential(normal, rolling, FRICTION, state=state).state


def test_layers_hardness_and_states() -> None:
    """A layer, a rough one and a hardness press as they do on half-spaces; steps go on from each other."""
    plain = pressed()
    for given in (
        {"normal_layer": 5e-15},
        {"normal_layer": mtb.RoughLayer.exponential(2e9, 2e-7)},
        {"hardness": 0.5 * float(plain.pressure.max())},
    ):
        found = pressed(**given)
        assert found.report.converged
        assert found.pressure.max() < plain.pressure.max()
        assert found.normal_force < plain.normal_force
    field = mtb.PressureField(plain.pressure, plain.spacing, corner(), corner(upper=True))
    one = mtb.solve_tangential(plain, mtb.Shift((4e-6, 0.0)), FRICTION, tolerance=1e-10)
    again = mtb.solve_tangential(field, mtb.Shift((4e-6, 0.0)), FRICTION, tolerance=1e-10)
    assert np.array_equal(one.traction, again.traction)
    back = mtb.solve_tangential(plain, mtb.Shift((-4e-6, 0.0)), FRICTION, state=one.state)
    assert np.abs(back.force[0]) < np.abs(one.force[0])
    long = mtb.solve_tangential(plain, mtb.Rolling((8e-4, 0.0, 0.0)), FRICTION)
    step = None
    for _ in range(60):
        rolling = mtb.Rolling((8e-4, 0.0, 0.0), transient=True)
        step = mtb.solve_tangential(plain, rolling, FRICTION, state=None if step is None else step.state)
    assert step is not None
    # as far as the half-spaces of the same case have come by then, 6e-6
    assert step.force[0] == pytest.approx(long.force[0], rel=5e-5)


def test_a_rail_is_stiffer_in_its_crown_than_at_its_corner() -> None:
    """A ball on 60E1: the same pressure as on a half-space at the crown; softer at 45 degrees, and turned."""
    profile = mtb.Profile.standard("60E1")
    x = (np.arange(16) - 7.5) * 0.25e-3
    heights = x**2 / 0.1 + x[:, None] ** 2 / 0.1
    steel = mtb.steel
    plain = mtb.solve_normal(heights, 0.25e-3, lower=steel, upper=steel, force=2e3)
    crown = mtb.solve_normal(heights, 0.25e-3, lower=mtb.Prism(profile), upper=steel, force=2e3)
    assert np.abs(crown.pressure - plain.pressure).max() < 5e-3 * plain.pressure.max()
    y = np.linspace(*profile.range, 4001)[1:-1]
    side = float(y[np.argmin(np.abs(profile.slope(y) - 1.0))])
    assert side < -0.03
    edge = mtb.solve_normal(heights, 0.25e-3, lower=mtb.Prism(profile, origin=side), upper=steel, force=2e3)
    assert edge.approach > 1.2 * crown.approach
    assert edge.resultant[1] == pytest.approx(2e3 * np.sin(np.pi / 4), rel=0.02)
    assert np.hypot(*edge.resultant[1:]) <= edge.normal_force


#: Cases 3 and 5 of CONTACT's conformal example: normal force, creep forces and moment [N, N m] on the wheel,
#: peak [Pa], and of case 3 how many cells touch in rows 6 to 33 of 39.
PRINTED = {
    "constant": (99_320, 10_860, 25_780, 32.92, 1034e6),
    "varying": (99_830, 12_700, 23_830, 40.39, 1040e6),
}
TOUCHING = "7 17 23 27 31 33 35 37 38 39 39 41 41 41 41 41 39 39 39 37 35 35 33 30 27 24 19 13"


def test_printed_forces_of_a_root_on_a_corner() -> None:
    """Its influences come from finite elements whose outline is not printed: arcs that turn by 45 degrees
    between flat faces have them."""
    corner_radius, root_radius, wheel, side, approach = 10e-3, 10.2e-3, 0.46, 0.4e-3, 0.09089e-3
    x, s = ((np.arange(n) - 0.5 * (n - 1)) * side for n in (51, 39))
    angle, offset = s / corner_radius, root_radius - corner_radius
    across = np.sqrt(root_radius**2 - (offset * np.sin(angle)) ** 2) - offset * np.cos(angle) - corner_radius
    apart = (across + approach * (1.0 - np.cos(angle)))[:, None] + x**2 * np.cos(0.25 * np.pi) / (2.0 * wheel)
    bodies: dict[str, Any] = {
        place: corner(size=1.0, turn=0.25 * np.pi, upper=place == "upper") for place in ("lower", "upper")
    }
    normal = mtb.solve_normal(apart, side, **bodies, approach=approach, edge="sharp")
    bend = 0.5 * (1.0 / corner_radius + 1.0 / root_radius)
    lean = 0.25 * np.pi - bend * s
    along = -4e-3 + (np.cos(lean) - np.cos(0.25 * np.pi)) / (bend * wheel)
    aside = -0.014 * np.cos(lean)[:, None] - np.outer(np.sin(lean), x) / wheel
    motions = {
        "constant": mtb.Rolling((-4e-3, -9.8995e-3, -1.5372)),
        "varying": mtb.Rolling(rigid_slip=np.stack([np.repeat(along[:, None], 51, axis=1), aside])),
    }
    for name, motion in motions.items():
        found = mtb.solve_tangential(normal, motion, FRICTION, coupling="full")
        own = (-found.force[2], *-found.force[:2], -found.spin_moment, found.pressure.max())
        assert own == pytest.approx(PRINTED[name], rel=0.02)
        if name == "constant":
            touching = (found.pressure > 0.0).sum(axis=1)
            printed = np.zeros(39, dtype=int)
            printed[5:33] = np.array(TOUCHING.split(), dtype=int)
            assert np.abs(touching - printed).max() <= 2
            assert np.abs(touching - printed).sum() <= 8


def test_kept_and_read_again(tmp_path: Path) -> None:
    normal = pressed()
    found = mtb.solve_tangential(normal, mtb.Rolling((5e-4, 0.0, 0.1)), FRICTION, coupling="full")
    for result in (normal, found):
        assert pickle.loads(pickle.dumps(result)) == result
        result.save(tmp_path / "kept.npz")
        again = mtb.load(tmp_path / "kept.npz")
        assert np.array_equal(again.pressure, result.pressure)
        assert again.lower.material == BODY
    rolling = mtb.Rolling((5e-4, 0.0, 0.0))
    there = mtb.solve_tangential(pickle.loads(pickle.dumps(normal)), rolling, FRICTION)
    assert np.array_equal(there.traction, mtb.solve_tangential(normal, rolling, FRICTION).traction)
    normal.save(tmp_path / "normal.npz")
    kept = mtb.load(tmp_path / "normal.npz")
    assert isinstance(kept, mtb.NormalResult)
    assert np.array_equal(kept.resultant, normal.resultant)
    # as an earlier version stored it
    with pytest.raises(ValueError, match="does not keep its section"):
        assert replace(kept, inclination=None).resultant is None
    with pytest.raises(ValueError, match="does not keep its section"):
        mtb.solve_tangential(mtb.load(tmp_path / "normal.npz"), mtb.Rolling((5e-4, 0.0, 0.0)), FRICTION)


def turned(y: float, z: float, by: float) -> tuple[float, float]:
    """A point turned about the x-axis."""
    return y * np.cos(by) - z * np.sin(by), y * np.sin(by) + z * np.cos(by)


SQUARE = [(-0.05, -0.1), (-0.05, 0.0), (0.05, 0.0), (0.05, -0.1)]
RAIL = mtb.Prism("60E1")
REFUSED: dict[str, tuple[Any, str]] = {
    "no points": (lambda: mtb.Prism(np.zeros((2, 2))), r"profile has shape \(2, 2\): 3 points"),
    "base alone": (lambda: mtb.Prism("60E1", base=[[0.0, -1.0]]), "base is given: it belongs to an outline"),
    "origin of an outline": (
        lambda: mtb.Prism([[-1.0, -1.0], [-1.0, 0.0], [1.0, 0.0], [1.0, -1.0]], origin=0.1),
        "the origin of an outline is a point",
    ),
    "off the outline": (
        lambda: pressed(lower=mtb.Prism((0.1, 0.1), BODY, origin=(0.0, 0.01))),
        "origin from the outline",
    ),
    "beyond the outline": (
        lambda: pressed(lower=mtb.Prism((0.01, 0.1), BODY)),
        "turn of the outline below the rows of cells is 1.57",
    ),
    "too long": (
        lambda: mtb.solve_normal(
            np.zeros((9, 9)) + 1e-6, 5e-2, lower=corner(), upper=BODY, force=1.0, edge="sharp"
        ),
        "half of the length of all rows",
    ),
    "crossing": (
        lambda: pressed(
            lower=mtb.Prism([[0.0, 0.0], [0.1, 0.1], [0.02, 0.1], [0.1, 0.0]], BODY, origin=(0.05, 0.05))
        ),
        "crosses or touches itself",
    ),
    "closed": (
        lambda: pressed(lower=mtb.Prism([*SQUARE, SQUARE[0]], BODY, origin=(0.0, 0.0))),
        "ends at the point where it begins",
    ),
    "pinched": (
        lambda: pressed(
            lower=mtb.Prism([SQUARE[0], (0.0, -0.05), *SQUARE[1:3], (0.0, -0.05), SQUARE[3]], BODY)
        ),
        "crosses or touches itself",
    ),
    "rail above": (
        lambda: pressed(lower=BODY, upper=RAIL),
        "material of the upper body, a Prism, lies below",
    ),
    "upside down": (
        lambda: pressed(lower=mtb.Prism([(y, -z) for y, z in SQUARE], BODY, origin=(0.0, 0.0))),
        "material of the lower body, a Prism, lies above",
    ),
    "turned": (
        lambda: pressed(
            lower=mtb.Prism(SQUARE, BODY, origin=(0.0, 0.0)),
            upper=mtb.Prism([turned(y, -z, 0.8) for y, z in SQUARE], BODY, origin=(0.0, 0.0)),
        ),
        "turned against each other by 0.8 rad",
    ),
    "inclined": (lambda: pressed(inclination=np.zeros(11)), "a body is a Prism, and inclination is given"),
    "periodic": (lambda: pressed(periodic=True), "and periodic is given"),
    "growing": (lambda: pressed(edge="grow"), 'and edge="grow" is given'),
    "quick": (lambda: pressed(method="kpec"), 'and method="kpec" is given'),
    "tilting": (
        lambda: pressed(force=1e3, moments_about_axes=(0.0, None)),
        "and moments_about_axes is given",
    ),
    "layered": (
        lambda: pressed(upper=mtb.Layered(SOFT, 1e-3, BODY)),
        "the other one is Layered or Viscoelastic",
    ),
    "stress": (
        lambda: pressed().stress(),
        "the lower body is a Prism: the stress inside its section is not known",
    ),
    "tangent": (
        lambda: mtb.solve_tangential(pressed(), mtb.Rolling((5e-4, 0.0, 0.0)), FRICTION).derivative(
            "force", by="angle"
        ),
        "by is 'angle': a body is a Prism, and rolling is known along the rows of cells alone",
    ),
    "across": (
        lambda: mtb.solve_tangential(pressed(), mtb.Rolling((1e-3, 0, 0), angle=1.0), FRICTION),
        r"a Prism along the rows of cells, and angle is 1 rad",
    ),
    "quick creep forces": (
        lambda: mtb.fastsim(pressed(), (1e-3, 0.0, 0.0), FRICTION),
        "solve_tangential takes prisms",
    ),
    "scenes": (
        lambda: mtb.scenes.block_on_plane(lower=corner()).solve("half-space"),
        "solve_normal takes outlines",
    ),
    "of a scene": (
        lambda: mtb.solve_tangential(
            mtb.scenes.pole_shoe_on_rail(lower=RAIL, spacing=9e-3).solve("half-space"),
            mtb.Rolling((1e-3, 0.0, 0.0)),
            FRICTION,
        ),
        "Prism",
    ),
}


@pytest.mark.coarse
@pytest.mark.parametrize("what", sorted(REFUSED))
def test_refused_by_name(what: str) -> None:
    call, message = REFUSED[what]
    with pytest.raises(ValueError, match=message):
        call()
