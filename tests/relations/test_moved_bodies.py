# SPDX-License-Identifier: MIT OR Apache-2.0
"""Bodies of one's own, turned, mirrored, shifted, scaled or exchanged with all that belongs to them."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cache
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, assume, given, settings
from hypothesis import strategies as st

import mtb_rs as mtb
from mtb_rs.bodies.mesh import block_mesh

#: Grids are coarse here; the bodies know it.
pytestmark = pytest.mark.filterwarnings("ignore:the contact is at most")
FEW = settings(max_examples=5, deadline=None, derandomize=True, suppress_health_check=list(HealthCheck))
RUBBER, STONE = (5e9, 0.2), (6e10, 0.3)


@dataclass(frozen=True)
class Map:
    """x becomes size * turn @ x + shift; stresses become `stiff` times as large; bodies may change places."""

    turn: Any = ((1, 0, 0), (0, 1, 0), (0, 0, 1))
    shift: tuple[float, float, float] = (0.0, 0.0, 0.0)
    size: float = 1.0
    stiff: float = 1.0
    swaps: bool = False

    @property
    def matrix(self) -> np.ndarray:
        return np.array(self.turn, dtype=float)

    @property
    def force(self) -> float:
        return self.stiff * self.size**2

    def points(self, x: np.ndarray) -> np.ndarray:
        """Points (3, ...)."""
        away = np.array(self.shift).reshape(3, *[1] * (x.ndim - 1))
        return self.size * np.tensordot(self.matrix, x, axes=1) + away

    def before(self, x: np.ndarray, y: np.ndarray) -> np.ndarray:
        """Where points at x, y of any height come from."""
        at = np.stack([x - self.shift[0], y - self.shift[1], 0.0 * x]) / self.size
        return np.tensordot(self.matrix.T, at, axes=1)[:2]

    def mesh(self, mesh: mtb.TetraMesh) -> mtb.TetraMesh:
        if np.linalg.det(self.matrix) < 0.0:
            flip = np.diag([1.0, -1.0, 1.0])
            mesh, turn = mesh.mirrored(), self.matrix @ flip
        else:
            turn = self.matrix
        sized = mtb.TetraMesh(self.size * mesh.nodes, mesh.cells, mesh.node_sets)
        return sized.moved(turn, self.shift)

    def sides(self, pair: tuple[float, float]) -> tuple[float, float]:
        dx, dy = np.abs(self.matrix[:2, :2]) @ pair * self.size
        return float(dx), float(dy)


TURNS = {
    "left": np.array([[0, -1, 0], [1, 0, 0], [0, 0, 1]]),
    "about": np.diag([-1, -1, 1]),
    "mirror x": np.diag([-1, 1, 1]),
    "mirror y": np.diag([1, -1, 1]),
    "over": np.diag([1, -1, -1]),
}
MAPS = {name: Map(turn.tolist(), swaps=name == "over") for name, turn in TURNS.items()}
MAPS["mirror z"] = Map(np.diag([1, 1, -1]).tolist(), swaps=True)
MAPS["raised"] = Map(shift=(0.0, 0.0, 0.3))
MAPS["shifted"] = Map(shift=(-0.7, 0.4, -0.2))
MAPS["micro"] = Map(size=1e-4, stiff=30.0)
MAPS["large"] = Map(size=70.0, stiff=0.01)
MAPS["all"] = Map((TURNS["left"] @ TURNS["mirror x"]).tolist(), (0.05, -0.4, 0.1), 0.3, 7.0)
MAPS["all, over"] = Map((TURNS["over"] @ TURNS["left"]).tolist(), (0.05, -0.4, 0.1), 0.3, 7.0, True)

ARRANGEMENTS = ("on a plane", "under a plane", "on a profile", "on a mesh", "under a mesh", "two", "gap")
LOADS = ("approach", "force", "force, moments", "guide", "pull", "pull on both")
#: Loads of the upper body: where bodies change places nothing else stands for them.
UPPER_ONLY = ("force", "force, moments", "pull")


def block(m: Map, *, upper: bool, hold: Any, material: tuple[float, float]) -> mtb.ElasticBody:
    """A block whose face is crowned aslant; quadratic, its crown fades towards the far end."""
    size = (np.linspace(-0.03, 0.05, 6), np.linspace(-0.02, 0.02, 4))
    mesh = block_mesh(*size, 0.03)
    x, y, z = mesh.nodes.T
    crown = 3e-3 * x**2 + 8e-3 * y**2 + 2e-5 * x - 1e-5 * y
    nodes = np.stack([x, y, z + crown * (1.0 - z / 0.03)], axis=1)
    mesh = mtb.TetraMesh(nodes, mesh.cells, {k: mesh.node_sets[k] for k in ("contact", "top")})
    if not upper:
        mesh = mesh.moved(np.diag([1.0, -1.0, -1.0]))
    z_held = mtb.Guide(m.force * m.matrix[2, 2] * hold.force) if isinstance(hold, mtb.Guide) else hold
    young, poisson = material
    return mtb.ElasticBody(
        m.mesh(mesh),
        mtb.Material(m.stiff * young, poisson),
        "contact",
        [mtb.Support("top", x=0, y=0, z=z_held)],
        "pad" if upper else "table",
    )


def hill(m: Map, *, upper: bool) -> mtb.BodySurface:
    """A gentle hill of triangles, below at z = 0 or above at its opposite."""
    x, y = np.meshgrid(np.linspace(-0.05, 0.07, 9), np.linspace(-0.05, 0.04, 8))
    z = -4e-3 * (x - 0.01) ** 2 - 5e-3 * (y + 0.004) ** 2
    number = np.arange(x.size).reshape(x.shape)
    a, b, c, d = (
        part.ravel() for part in (number[:-1, :-1], number[:-1, 1:], number[1:, 1:], number[1:, :-1])
    )
    triangles = np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, d], 1)])
    if upper:
        z, triangles = -z, triangles[:, ::-1]
    if np.linalg.det(m.matrix) < 0.0:
        triangles = triangles[:, ::-1]
    points = np.stack([x.ravel(), y.ravel(), z.ravel()])
    return mtb.BodySurface.mesh(m.points(points), triangles, closed=False)


def ridge(m: Map) -> mtb.Profile:
    """A rail's head along x: asymmetric across it."""
    y = np.linspace(-0.05, 0.05, 21)
    at = m.points(np.stack([0.0 * y, y, -5e-3 * (y - 0.003) ** 2 + 2e-2 * y**3]))
    return mtb.Profile.from_points(at[1], at[2])


def placed(arrangement: str, load: str, m: Map, towards: float = 0.3, friction: float = 0.2) -> mtb.Scene:
    sign = -1.0 if m.swaps else 1.0
    free = load.startswith("pull") or load == "guide" or (load.startswith("force"))
    stone = mtb.Material(m.stiff * STONE[0], STONE[1])
    is_upper = not arrangement.startswith("under")
    hold: Any = 0.0
    if free and (is_upper or load in ("guide", "pull on both")):
        hold = None
    if load == "guide":
        hold = mtb.Guide(-4e3 if is_upper else 4e3)
    own = block(m, upper=is_upper, hold=hold, material=RUBBER)
    other: Any = stone
    given: dict[str, Any] = {}
    if arrangement == "on a profile":
        other = mtb.HalfSpace(stone, ridge(m))
    elif arrangement.endswith("mesh"):
        surface = hill(m, upper=not is_upper)
        other = mtb.Rigid(surface) if is_upper else mtb.HalfSpace(stone, surface)
    elif arrangement == "two":
        other = block(m, upper=False, hold=0.0, material=STONE)
    elif arrangement == "gap":

        def gap(x: np.ndarray, y: np.ndarray) -> np.ndarray:
            a, b = m.before(x, y)
            return m.size * (4e-3 * (a - 0.02) ** 2 + 6e-3 * b**2 + 1e-5 * b)

        given["gap"] = gap
    if load == "approach":
        given["approach"] = m.size * 8e-6
    elif load.startswith("force"):
        given["force"] = m.force * 4e3
        if "moments" in load:
            moment = np.linalg.det(m.matrix) * m.matrix @ [3.0, -2.0, 0.0] * m.force * m.size
            given["moments"] = (float(moment[0]), float(moment[1]))
    elif load.startswith("pull"):
        given["attraction"] = "both" if load.endswith("both") else "upper"

        def pull(x: np.ndarray, y: np.ndarray) -> np.ndarray:
            a, b = m.before(x, y)
            return m.stiff * 1e6 * (1.0 + 4.0 * a - 3.0 * b)

        given["magnetic_pressure"] = pull

    def rubbed(x: np.ndarray, y: np.ndarray) -> np.ndarray:
        a, b = m.before(x, y)
        return friction * (1.0 + 5.0 * a + 3.0 * b)

    way = sign * m.matrix @ [np.cos(towards), np.sin(towards), 0.0]
    bodies = {"upper": own, "lower": other} if is_upper != m.swaps else {"upper": other, "lower": own}
    return mtb.Scene(
        **bodies,
        spacing=m.sides((0.08 / 5, 0.04 / 3)),
        friction=rubbed,
        sliding_direction=(float(way[0]), float(way[1])),
        **given,
    )


def fits(arrangement: str, load: str, m: Map) -> bool:
    if arrangement == "on a profile" and abs(m.matrix[0, 0]) != 1:
        return False
    if m.swaps and load in UPPER_ONLY:
        return False
    # a half-space above a body that is free along z is free as well
    return load != "pull on both" or arrangement == "two" or not (arrangement.startswith("under") or m.swaps)


def order(m: Map, here: np.ndarray, there: np.ndarray) -> np.ndarray:
    """For each point (3, ...) of one result the number of its image in the other, seen along z."""
    at, of = m.points(here).reshape(3, -1)[:2], there.reshape(3, -1)[:2]
    apart = np.hypot(*(at[:, :, None] - of[:, None, :]))
    assert apart.min(axis=1).max() < 1e-9 * m.size
    return apart.argmin(axis=1)


def close(found: Any, wanted: Any, size: float, tolerance: float) -> None:
    np.testing.assert_allclose(found, wanted, rtol=0, atol=tolerance * size)


def check(m: Map, own: mtb.Result, image: mtb.Result, tolerance: float) -> None:
    sign = -1.0 if m.swaps else 1.0
    at = order(m, own.points, image.points)
    turned = m.matrix
    size = m.stiff * own.pressure.max()
    close(image.pressure.ravel()[at], m.stiff * own.pressure.ravel(), size, tolerance)
    traction = sign * m.stiff * turned @ own.traction.reshape(3, -1)
    close(image.traction.reshape(3, -1)[:, at], traction, size, tolerance)
    force = sign * m.force * turned @ own.force
    whole = np.abs(force).max()
    close(image.force, force, whole, tolerance)
    moment = sign * m.force * m.size * np.linalg.det(turned) * turned @ own.moment
    far = m.size * 0.1 + np.abs(m.shift).max()
    if m.swaps:
        # tractions act where the lower face was: heights within the gap
        tolerance = max(tolerance, 1e-3)
    close(image.moment, moment + np.cross(m.shift, force), far * whole, tolerance)


def check_motion(m: Map, own: mtb.Result, image: mtb.Result, tolerance: float) -> None:
    at = order(m, own.points, image.points)
    moved = (image.displacement.lower, image.displacement.upper)[:: -1 if m.swaps else 1]
    size = m.size * max(np.abs(part).max() for part in own.displacement)
    for other, part in zip(moved, (own.displacement.lower, own.displacement.upper), strict=True):
        close(other.reshape(3, -1)[:, at], m.size * m.matrix @ part.reshape(3, -1), size, tolerance)


@cache
def solved(arrangement: str, load: str, towards: float) -> mtb.Result:
    return placed(arrangement, load, Map(), towards).solve()


PLACES = st.tuples(st.sampled_from(ARRANGEMENTS), st.sampled_from(LOADS), st.sampled_from([0.3, -2.0]))


@pytest.mark.coarse
@pytest.mark.parametrize("name", MAPS)
@FEW
@given(PLACES)
def test_a_scene_moved_as_a_whole_is_the_same_scene(name: str, place: tuple[str, str, float]) -> None:
    m = MAPS[name]
    arrangement, load, towards = place
    assume(fits(arrangement, load, m) and fits(arrangement, load, Map()))
    own, image = solved(*place), placed(arrangement, load, m, towards).solve()
    check(m, own, image, 1e-7)
    check_motion(m, own, image, 1e-7)


@pytest.mark.parametrize("name", ["left", "mirror y", "over", "raised", "all, over"])
@FEW
@given(st.sampled_from(ARRANGEMENTS))
def test_so_are_its_start_of_sliding_and_its_steps(name: str, arrangement: str) -> None:
    m = MAPS[name]
    load = "guide" if m.swaps else "pull"
    assume(fits(arrangement, load, m))
    scenes = [placed(arrangement, load, each) for each in (Map(), m)]
    way = np.array([[2e-7, 1e-7, 0.0], [3e-7, 4e-7, 0.0]])
    moved = (-1.0 if m.swaps else 1.0) * m.size * way @ m.matrix.T
    own, image = (s.start_of_sliding(w[:, :2].tolist()) for s, w in zip(scenes, (way, moved), strict=True))
    np.testing.assert_allclose(image.normal_force, m.force * own.normal_force, rtol=1e-6)
    force = (-1.0 if m.swaps else 1.0) * m.force * own.force @ m.matrix[:2, :2].T
    close(image.force, force, m.force * own.normal_force.max(), 1e-6)
    if arrangement == "on a mesh" and m.swaps:
        return  # a rigid body that rests has no pose of its own: the other one is the upper body
    one, other = (s.prepare().step() for s in scenes)
    turned = (-1.0 if m.swaps else 1.0) * m.force * m.matrix @ one.force
    close(other.force, turned, np.abs(turned).max(), 1e-8)


@pytest.mark.coarse
@pytest.mark.parametrize("arrangement", ARRANGEMENTS)
def test_a_pose_lower_by_the_approach_is_the_approach(arrangement: str) -> None:
    far, near = (placed(arrangement, "approach", Map()).with_(approach=d) for d in (8e-6, 3e-6))
    whole = far.solve()
    step = near.prepare().step(pose=[0.0, 0.0, -5e-6, 0.0, 0.0, 0.0])
    there = whole.area > 0.0
    close(step.pressure, whole.pressure[there], whole.pressure.max(), 1e-8)
    close(step.force, whole.force, whole.normal_force, 1e-8)
    close(step.moment, whole.moment, 0.1 * whole.normal_force, 1e-8)


@pytest.mark.parametrize("load", ["force", "pull", "guide"])
@pytest.mark.parametrize("arrangement", ARRANGEMENTS)
def test_a_body_held_at_the_height_it_took_stays_as_it_was(arrangement: str, load: str) -> None:
    contact = placed(arrangement, load, Map()).prepare(reference_point=(0.01, 0.0, 0.03))
    free = contact.step()
    heights = [h for n, h in zip(contact.motions, free.state.motion, strict=False) if n.endswith(" z")]
    if not heights:  # below a half-space that rests only the lower body is free
        assert (arrangement.startswith("under"), load) == (True, "guide")
        return
    held = contact.step(pose=[0.0, 0.0, heights[0], np.nan, np.nan, 0.0])
    close(held.pressure, free.pressure, free.pressure.max(), 1e-7)
    close(held.force, free.force, np.abs(free.force).max(), 1e-7)


def test_two_bodies_that_are_both_free_have_no_height() -> None:
    scene = placed("under a plane", "guide", Map()).with_(force=4e3)
    with pytest.raises(ValueError, match="leave table free along z, and what lies above is free as well"):
        scene.solve()
    two = placed("two", "pull", Map())
    free = [mtb.Support("top", x=0, y=0, z=mtb.Guide(10.0))]
    with pytest.raises(ValueError, match="leave table free along z, and pad as well: nothing says how high"):
        two.with_(lower=replace(two.lower, supports=free)).solve()
