# SPDX-License-Identifier: MIT OR Apache-2.0
"""Where two bodies may touch: each geometry has contact points at any spacing."""

from __future__ import annotations

import inspect
from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, ClassVar, NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from ..base import memory
from ..base.owning import owning
from ..base.plain import plain
from ..base.words import Model, Side
from .contact_points import ContactGrid, ContactPoints, Patch
from .pole_shoe import PoleShoe
from .profiles import Profile
from .slices import nominal_of
from .triangles import Surface, height_surface, prism_surface
from .wheel_rail import WheelRailGap, place_wheel, wheel_on_rail_gap

Array = NDArray[np.float64]
Spacing = tuple[float, float]


#: Cells along the side of a grid that is some three times as wide as the contact, to start with.
START_CELLS = 16


class Meshers(Protocol):
    """Makes meshes of the bodies that geometries have."""

    def block(self, x: Array, y: Array, height: float) -> Any:
        """Of a block on the plane z = 0, with elements between the lines x and y [m] at its foot."""

    def pole(self, shoe: PoleShoe, x: Array, y: Array, side: Side) -> Any:
        """Of one pole of a shoe in its own frame, with elements between lines x and |y| [m] on its sole."""


class UpperBody(NamedTuple):
    """An upper body as its geometry has it.

    Attributes
    ----------
    mesh
        In place; as the meshers made it.
    name : str
    middle : (3,) [m]
        Below the middle of its top.
    size : (x, y) [m]
        Of its top.
    height : float [m]
    turn : (3, 3)
        Rotation from its own frame.
    element : float [m]
        Least width of the elements at the contact.
    """

    mesh: Any
    name: str
    middle: Array
    size: tuple[float, float]
    height: float
    turn: Array
    element: float


class Geometry(ABC):
    """Geometry of a scene, as far as its contact points, its bodies and its pictures need it."""

    #: The models that it has bodies for, cheapest first.
    models: ClassVar[tuple[Model, ...]] = ("half-space",)
    #: Whether its lengths are metres for certain; fields may be in normalised units.
    is_metric: ClassVar[bool] = True
    #: Whether it has finer grids than its own.
    can_be_refined: ClassVar[bool] = True

    @property
    @abstractmethod
    def is_body_edge(self) -> bool:
        """Whether the border of the grid is the edge of a body, so that contact may reach it."""

    @property
    def body_height(self) -> float | None:
        """Height [m] of the upper body above the contact; None where it is not known."""
        return None

    @property
    @abstractmethod
    def is_grid(self) -> bool:
        """Whether results have the shape (ny, nx) of one grid."""

    @property
    @abstractmethod
    def start(self) -> Spacing | None:
        """Where the choice of a spacing starts [m]; None if there is nothing to choose."""

    @abstractmethod
    def grid(self, spacing: Spacing) -> ContactGrid:
        """The potential contact at `spacing` (dx, dy) [m]."""

    @abstractmethod
    def surfaces(self) -> tuple[Surface, ...]:
        """The undeformed bodies, for pictures."""

    def wider(self, patch: Patch) -> str:
        """What would do where a contact reaches the edge of `patch`, but the bodies go on beyond it."""
        return "a larger grid would do"

    @property
    def looks_like(self) -> str:
        """What a given field looks like that is no gap, or one upside down; "" where it looks right."""
        return ""

    @property
    def on_flange(self) -> str | None:
        """What is to be said where a wheel runs on its flange."""
        return None

    @property
    def hardness(self) -> float | None:
        """Of the steel that such bodies are made of, as a pressure [Pa]; None where they may be of any."""
        return None

    @property
    def paraboloid(self) -> tuple[float, float] | None:
        """Radius and width of the grid [m] of a paraboloid on a plane, for which there is a closed form."""
        return None

    def check_elastic(self, spacing: Spacing) -> None:  # noqa: B027 (most are checked where they are laid)
        """Refuses, before it is laid, a contact too large for elastic bodies."""

    def is_coarser_than(self, spacing: Spacing) -> bool:
        """Whether a mesh that was given is too coarse for cells of `spacing` (dx, dy) [m]."""
        return False

    def upper_body(
        self, meshers: Meshers, grid: ContactGrid, patch: Patch, lines: tuple[Array, Array]
    ) -> UpperBody:
        """The elastic upper body on a grid of nodes, with elements about as `lines` (x, y) [m] lie."""
        raise ValueError("this geometry has no elastic upper body")

    def rail(self) -> tuple[Profile, float]:
        """Profile and length [m] of the elastic rail."""
        raise ValueError("this geometry has no rail")


def flat_grid(cells: ContactPoints, nodes: ContactPoints, nx: int, ny: int, spacing: Spacing) -> ContactGrid:
    """The potential contact of one flat grid of nx by ny cells."""
    return ContactGrid(
        cells=cells,
        nodes=nodes,
        area=np.full(nx * ny, spacing[0] * spacing[1]),
        patches=(Patch("contact", 0, nx, ny, spacing, _first(cells)),),
        node_patches=(Patch("contact", 0, nx + 1, ny + 1, spacing, _first(nodes)),),
    )


#: Relative difference of steps that count as even.
EVEN = 1e-9


def _spread(first: float, last: float, lines: Array) -> Array:
    """Places from `first` to `last`, spaced as `lines` are."""
    steps = np.diff(lines)
    if np.ptp(steps) <= EVEN * steps.max():
        return np.linspace(first, last, lines.size)
    return np.asarray(first + (last - first) * (lines - lines[0]) / (lines[-1] - lines[0]))


def _first(points: ContactPoints) -> tuple[float, float]:
    return float(points.points[0, 0]), float(points.points[1, 0])


def flat_points(x: Array, y: Array, gap: Array) -> ContactPoints:
    """Points of the plane z = 0 on the grid of `x` and `y`, with `gap` (ny, nx) above them."""
    grid_x, grid_y = (a.ravel() for a in np.meshgrid(x, y))
    zero, one = np.zeros(grid_x.size), np.ones(grid_x.size)
    return ContactPoints(
        points=np.array([grid_x, grid_y, zero]),
        normal=np.array([zero, zero, one]),
        tangent_x=np.array([one, zero, zero]),
        tangent_y=np.array([zero, one, zero]),
        arc_length=grid_y.copy(),
        gap=np.ascontiguousarray(gap, dtype=float).ravel(),
    )


#: Columns and rows of what is rather a table of points than a height field.
_FEW_COLUMNS, _MANY_ROWS = 4, 100


def slip_of_gap(gap: Array) -> str:
    """What a gap looks like that is no height field, or one upside down; "" where it looks right."""
    ny, nx = gap.shape
    if nx <= _FEW_COLUMNS < _MANY_ROWS <= ny:
        return (
            f"gap has the shape ({ny}, {nx}). If these are columns, such as x, y and gap of one point a row, "
            "put them on the grid first (of pandas, frame.pivot(index='y', columns='x', values='gap'))"
        )
    steps = np.diff(gap[:, 0])
    if min(ny, nx) > 2 and steps.mean() != 0.0 and np.ptp(steps) <= 1e-6 * abs(steps.mean()):
        rest = np.diff(gap[:, 1:], axis=0)
        if np.ptp(rest) > 1e-3 * abs(steps.mean()) or not np.allclose(rest.mean(), steps.mean()):
            return (
                f"the first column of gap goes evenly from {gap[0, 0]:.4g} to {gap[-1, 0]:.4g} m. If these "
                "are coordinates, leave them out (of pandas, read_csv(..., index_col=0))"
            )
    if min(ny, nx) > 2:
        inner, rim = gap[1:-1, 1:-1], np.concatenate([gap[0], gap[-1], gap[:, 0], gap[:, -1]])
        if rim.max() < inner.mean() and inner.min() > rim.min():
            return (
                f"the gap is largest inside ({inner.max():.4g} m) and smallest at the edge ({rim.min():.4g} "
                "m). If it is upside down, give its negative: a gap is > 0 where the bodies are apart"
            )
    return ""


def _averaged(field: Array, count: int) -> Array:
    """Means (count, k) of a field (n, k) of cell means over `count` <= n equal cells in place of the n.

    Within a cell the field is a line through its mean with the slope of its neighbours, so that cells that
    are not a whole number of times wider show no pattern of their own.
    """
    n = len(field)
    if count == n:
        return field
    borders = np.linspace(0.0, n, count + 1)
    cell = np.minimum(borders.astype(np.intp), n - 1)
    share = (borders - cell)[:, None]
    before = np.concatenate([np.zeros((1, field.shape[1])), field.cumsum(axis=0)])
    bend = 0.5 * share * (share - 1.0) * np.gradient(field, axis=0)[cell]
    return np.asarray(np.diff(before[cell] + share * field[cell] + bend, axis=0) * (count / n))


def centred(n: int, step: float) -> Array:
    """`n` numbers `step` apart, symmetric about zero."""
    return np.asarray((np.arange(n) - 0.5 * (n - 1)) * step, dtype=float)


def cells_along(length: float, step: float) -> int:
    """Cells of about `step` that fill `length` exactly."""
    return max(1, round(length / step))


#: Contact angle [rad] from which on a wheel is said to run on its flange.
FLANGE = np.radians(30.0)
#: Brinell hardness [Pa] of the usual rail steel, R260: 260 to 300 HB (EN 13674-1), 1 HB being 9.807 MPa.
RAIL_HARDNESS = 300 * 9.807e6
#: More cells than this are a slip of the pen.
MOST_CELLS = 1e8


def cells_over(size: tuple[float, float], spacing: Spacing) -> tuple[int, int]:
    """Cells (nx, ny) of about `spacing` that fill a contact of `size` [m] exactly.

    Raises
    ------
    ValueError
        If the cells are wider than the contact, or beyond count.
    """
    for name, length, step in zip(("dx", "dy"), size, spacing, strict=True):
        if step > length * (1.0 + 1e-9):
            raise ValueError(f"spacing {name} is {step:g} m: the contact measures only {length:.6g} m there")
    if size[0] / spacing[0] * (size[1] / spacing[1]) > MOST_CELLS:
        raise ValueError(f"spacing is {spacing} m: it would take more than {MOST_CELLS:g} cells")
    return cells_along(size[0], spacing[0]), cells_along(size[1], spacing[1])


def check_room(sides: Sequence[tuple[int, int]], spacing: Spacing, *, dense: float = 0.0) -> None:
    """ValueError if the memory does not hold a scene with grids of so many cells along their sides (nx, ny).

    Asked before any of them is made. The matrices of a share `dense` of the cells are dense.
    """
    _check_room(sides, f"spacing is {spacing[0]:g} x {spacing[1]:g} m", dense)


def _check_room(sides: Sequence[tuple[int, int]], given: str, dense: float = 0.0) -> None:
    cells = sum(nx * ny for nx, ny in sides)
    memory.refuse(
        max(memory.of_scene(sides), memory.of_least_matrix(dense * cells)),
        f"{given}: a contact of {cells} cells",
        "take fewer, larger cells",
    )


@owning
@dataclass(frozen=True)
@plain
class GapField(Geometry):
    """A gap given as a height field (ny, nx) [m] on a grid of `step` (dx, dy) [m], centred at the origin."""

    gap: Array
    step: Spacing
    is_metric: ClassVar[bool] = False
    #: A given field can be thinned, not refined.
    can_be_refined: ClassVar[bool] = False
    is_body_edge: bool = False
    is_grid: bool = True
    start: None = None

    @property
    def looks_like(self) -> str:
        """What the field looks like that is no gap, or one upside down; "" where it looks right."""
        return slip_of_gap(self.gap)

    def grid(self, spacing: Spacing) -> ContactGrid:
        """The field's own grid, or wider cells over the same rectangle, as near to `spacing` as they fit."""
        counts = self.gap.shape[::-1]
        nx, ny = (min(n, round(n * d / s)) for n, d, s in zip(counts, self.step, spacing, strict=True))
        if min(nx, ny) < 1:
            raise ValueError(f"spacing is {spacing} m: wider than the whole field")
        check_room([(nx, ny)], spacing)
        gap = _averaged(_averaged(self.gap, ny).T, nx).T
        dx, dy = (d * n / own for d, n, own in zip(self.step, counts, (nx, ny), strict=True))
        cells = flat_points(centred(nx, dx), centred(ny, dy), gap)
        corner = np.pad(gap, 1, mode="edge")
        corner = 0.25 * (corner[1:, 1:] + corner[:-1, 1:] + corner[1:, :-1] + corner[:-1, :-1])
        nodes = flat_points(centred(nx + 1, dx), centred(ny + 1, dy), corner)
        return flat_grid(cells, nodes, nx, ny, (dx, dy))

    def wider(self, patch: Patch) -> str:
        """The field is the user's."""
        return (
            f"give the gap on a larger grid (about {2 * patch.nx} x {2 * patch.ny} points at this spacing "
            "would do)"
        )

    def surfaces(self) -> tuple[Surface, ...]:
        """The plane z = 0 and the field above it."""
        ny, nx = self.gap.shape
        x, y = centred(nx, self.step[0]), centred(ny, self.step[1])
        return (height_surface("lower", x, y, np.zeros((ny, nx))), height_surface("upper", x, y, self.gap))


@dataclass(frozen=True)
@plain
class ParaboloidOnPlane(Geometry):
    """A paraboloid of `radius` [m] above a plane; its square grid spans `width` [m] between outer points."""

    radius: float
    width: float
    is_body_edge: bool = False
    is_grid: bool = True

    @property
    def paraboloid(self) -> tuple[float, float]:
        """Its radius, and the width of its grid [m]."""
        return self.radius, self.width

    @property
    def start(self) -> Spacing:
        """Some five cells over the radius of contact that fills a third of the width."""
        return self.width / START_CELLS, self.width / START_CELLS

    def grid(self, spacing: Spacing) -> ContactGrid:
        """Points `spacing` apart; each is the centre of a cell."""
        count = [cells_along(self.width, step) + 1 for step in spacing]
        # either may have been given
        sizes = " x ".join(f"{step:g}" for step in dict.fromkeys(spacing))
        _check_room([(count[0], count[1])], f"spacing is {sizes} m, points is {max(count)} a side")
        dx, dy = (self.width / (n - 1) for n in count)
        fields = []
        for extra in (0, 1):
            x, y = centred(count[0] + extra, dx), centred(count[1] + extra, dy)
            fields.append(flat_points(x, y, self._height(x[None, :], y[:, None])))
        return flat_grid(fields[0], fields[1], count[0], count[1], (dx, dy))

    def wider(self, patch: Patch) -> str:
        """The width is an argument, or follows from the force."""
        return f"a width of about {2.0 * self.width:.4g} m would do"

    def _height(self, x: Array, y: Array) -> Array:
        return np.asarray((x**2 + y**2) / (2.0 * self.radius))

    def surfaces(self) -> tuple[Surface, ...]:
        """The plane and the paraboloid."""
        x = centred(41, self.width / 40)
        height = self._height(x[None, :], x[:, None])
        return (height_surface("lower", x, x, 0.0 * height), height_surface("upper", x, x, height))


@dataclass(frozen=True)
@plain
class BlockOnPlane(Geometry):
    """A block of `width` (x) by `length` (y) by `height` [m] standing on a plane."""

    width: float
    length: float
    height: float
    models: ClassVar[tuple[Model, ...]] = ("half-space", "elastic-upper")
    is_body_edge: bool = True
    is_grid: bool = True

    @property
    def body_height(self) -> float:
        """That of the block."""
        return self.height

    @property
    def start(self) -> Spacing:
        """Eight cells along the shorter side."""
        return min(self.width, self.length) / 8.0, min(self.width, self.length) / 8.0

    def check_elastic(self, spacing: Spacing) -> None:
        """Finite elements are condensed to dense matrices, where half-spaces may go by convolutions."""
        check_room([cells_over((self.width, self.length), spacing)], spacing, dense=1.0)

    def grid(self, spacing: Spacing) -> ContactGrid:
        """Equal cells that fill the foot of the block."""
        nx, ny = cells_over((self.width, self.length), spacing)
        check_room([(nx, ny)], spacing)
        dx, dy = self.width / nx, self.length / ny
        cells = flat_points(centred(nx, dx), centred(ny, dy), np.zeros((ny, nx)))
        nodes = flat_points(centred(nx + 1, dx), centred(ny + 1, dy), np.zeros((ny + 1, nx + 1)))
        return flat_grid(cells, nodes, nx, ny, (dx, dy))

    def upper_body(
        self, meshers: Meshers, grid: ContactGrid, patch: Patch, lines: tuple[Array, Array]
    ) -> UpperBody:
        """The block."""
        x, y = (_spread(along[0], along[-1], along) for along in lines)
        mesh = meshers.block(x, y, self.height)
        size, element = (self.width, self.length), float(np.diff(x).min())
        return UpperBody(mesh, "block", np.zeros(3), size, self.height, np.eye(3), element)

    def surfaces(self) -> tuple[Surface, ...]:
        """The plane around the block, and the block."""
        x = np.linspace(-self.width, self.width, 11)
        y = np.linspace(-self.length, self.length, 11)
        section = np.array([[-0.5, 0.5, 0.5, -0.5], [0.0, 0.0, 1.0, 1.0]])
        section = section * np.array([[self.length], [self.height]])
        return (
            height_surface("lower", x, y, np.zeros((11, 11))),
            prism_surface("upper", section, np.linspace(-0.5, 0.5, 2) * self.width),
        )


@dataclass(frozen=True)
@plain
class ShoeOnRail(Geometry):
    """A pole shoe on the head of a rail of `rail_length` [m]."""

    shoe: PoleShoe
    rail_length: float
    models: ClassVar[tuple[Model, ...]] = ("half-space", "elastic-upper", "elastic-both")
    is_body_edge: bool = True
    is_grid: bool = False

    def __post_init__(self) -> None:
        shoe = self.shoe
        reach = 0.5 * shoe.length * np.cos(shoe.yaw) + shoe.conforming_to * abs(np.sin(shoe.yaw))
        if reach > 0.5 * self.rail_length * (1.0 + 1e-9):
            raise ValueError(
                f"rail_length is {self.rail_length:g} m: the shoe presses on {2.0 * reach:.6g} m of it, "
                "so a longer rail is needed"
            )

    @property
    def body_height(self) -> float:
        """That of the shoe."""
        return self.shoe.height

    @property
    def start(self) -> Spacing:
        """Four cells across the conforming strip."""
        step = (self.shoe.conforming_to - self.shoe.inner_edge) / 4.0
        return step, step

    def grid(self, spacing: Spacing) -> ContactGrid:
        """One grid per pole over the conforming strip."""
        shoe, grids = self.shoe, []
        for side in shoe.sides:
            ends = shoe.profile.arc_length([side * shoe.inner_edge, side * shoe.conforming_to])
            grids.append(cells_over((shoe.length, float(abs(ends[1] - ends[0]))), spacing))
        check_room(grids, spacing, dense=1.0)
        return self.shoe.grid(spacing)

    def upper_body(
        self, meshers: Meshers, grid: ContactGrid, patch: Patch, lines: tuple[Array, Array]
    ) -> UpperBody:
        """The pole above one of the grids."""
        shoe = self.shoe
        side: Side = "left" if patch.name == "left" else "right"
        toward = 1.0 if side == "left" else -1.0
        # the strip in the shoe's own frame: as the lines are spaced, along the arc of its sole
        first, last = shoe.profile.arc_length([toward * shoe.inner_edge, toward * shoe.conforming_to])
        # from the inside outwards; the lines rise with y
        outwards = lines[1] if toward > 0.0 else -lines[1][::-1]
        y = np.abs(shoe.profile.position(_spread(first, last, outwards)))
        y[[0, -1]] = shoe.inner_edge, shoe.conforming_to
        mesh = meshers.pole(shoe, _spread(-0.5, 0.5, lines[0]) * shoe.length, y, side)
        middle = np.array([0.0, 0.5 * (shoe.inner_edge + shoe.outer_edge) * toward, 0.0])
        cos, sin = np.cos(shoe.yaw), np.sin(shoe.yaw)
        turn = np.array([[cos, -sin, 0.0], [sin, cos, 0.0], [0.0, 0.0, 1.0]])
        aside = np.array([0.0, shoe.lateral, 0.0])
        aside[2] = self._lift(grid, patch, turn, aside)
        size = (shoe.length, shoe.outer_edge - shoe.inner_edge)
        element = float(np.diff(lines[0]).min())
        place = turn @ middle + aside
        return UpperBody(mesh.moved(turn, aside), f"{side} pole", place, size, shoe.height, turn, element)

    def _lift(self, grid: ContactGrid, patch: Patch, turn: Array, aside: Array) -> float:
        """How far a pole off its place was raised [m] until it just touches, by the gaps below it."""
        shoe = self.shoe
        if shoe.lateral == 0.0 and shoe.yaw == 0.0:
            return 0.0
        nodes = grid.nodes.at(patch.cut)
        own = turn.T @ (nodes.points + nodes.gap * nodes.normal - aside[:, None])
        return float(np.mean(own[2] - shoe.sole(own[1])))

    def rail(self) -> tuple[Profile, float]:
        """The profile that the shoe stands on."""
        return self.shoe.profile, self.rail_length

    def surfaces(self) -> tuple[Surface, ...]:
        """The head of the rail and the poles."""
        profile = self.shoe.profile
        y = np.linspace(*profile.range, 81)
        x = np.linspace(-0.5, 0.5, 25) * self.rail_length
        head = height_surface("lower rail", x, y, np.repeat(profile.height(y)[:, None], x.size, axis=1))
        shoe = self.shoe
        stations = np.linspace(shoe.inner_edge, shoe.outer_edge, 41)
        cos, sin = np.cos(shoe.yaw), np.sin(shoe.yaw)
        turn = np.array([[cos, -sin, 0.0], [sin, cos, 0.0], [0.0, 0.0, 1.0]])
        out = [head]
        for name, side in zip(("left", "right"), shoe.sides, strict=False):
            worn = [*shoe.sole(side * stations), shoe.height, shoe.height]
            pole = prism_surface(
                f"upper {name} pole",
                np.array([side * np.append(stations, stations[[-1, 0]]), worn]),
                np.linspace(-0.5, 0.5, 25) * shoe.length,
            )
            vertices = turn @ pole.vertices + np.array([[0.0], [shoe.lateral], [0.0]])
            out.append(Surface(pole.name, vertices, pole.triangles))
        return tuple(out)


@owning
@dataclass(frozen=True)
@plain
class WheelOnRail(Geometry):
    """A wheel on a rail, in the frame of the contact plane: x along the rail, y to the field side, z normal.

    Attributes
    ----------
    placement : WheelRailGap
        Gap at the scene's own spacing, contact angle and position.
    arguments : tuple of (name, value)
        All arguments of :func:`mtb_rs.wheel_on_rail_gap`, of which it is.
    """

    placement: WheelRailGap
    arguments: tuple[tuple[str, Any], ...]
    is_body_edge: bool = False
    is_grid: bool = True

    @classmethod
    def placed(cls, **arguments: Any) -> WheelOnRail:
        """The geometry of the arguments of :func:`mtb_rs.wheel_on_rail_gap`."""
        bound = inspect.signature(wheel_on_rail_gap).bind(**arguments)
        bound.apply_defaults()
        return cls(place_wheel(bound.arguments), tuple(bound.arguments.items()))

    @property
    def on_flange(self) -> str | None:
        """What is to be said where the flange, or the root of it, carries the wheel."""
        angle = self.placement.contact_angle
        if angle <= FLANGE:
            return None
        force = dict(self.arguments)["force"]
        return (
            f"the flange is in contact: the contact plane is inclined by {np.degrees(angle):.0f}°, the "
            f"normal force is {force / np.cos(angle) / 1e3:.4g} kN where the vertical one is "
            f"{force / 1e3:.4g} kN, and friction, which carries a part of it there, is not in that balance"
        )

    @property
    def hardness(self) -> float:
        """Of rails."""
        return RAIL_HARDNESS

    @property
    def start(self) -> Spacing:
        """As for the paraboloid, along the shorter side."""
        place = self.placement
        shorter = min(n * d for n, d in zip(place.gap.shape[::-1], place.spacing, strict=True))
        return shorter / START_CELLS, shorter / START_CELLS

    def grid(self, spacing: Spacing) -> ContactGrid:
        """The contact plane's grid at `spacing`."""
        given = dict(self.arguments)
        for name in ("wheel", "rail"):
            if nominal_of(name, given[name])[1] is not None:
                raise ValueError(
                    f"{name} is {given[name]!r}: wheels and rails with slices are solved in steps, so "
                    "scene.prepare().step(pose, velocity) is needed in place of a solution of the scene"
                )
        place = self.placement
        if spacing != place.spacing:
            place = place_wheel({**dict(self.arguments), "spacing": spacing})
        ny, nx = place.gap.shape
        check_room([(nx, ny)], spacing)
        dx, dy = place.spacing
        cells = flat_points(place.x, place.y, place.gap)
        # corners by averages; a half-space scene has no use for more
        around = np.pad(place.gap, 1, mode="edge")
        corner = 0.25 * (around[1:, 1:] + around[:-1, 1:] + around[1:, :-1] + around[:-1, :-1])
        x = np.append(place.x - 0.5 * dx, place.x[-1] + 0.5 * dx)
        y = np.append(place.y - 0.5 * dy, place.y[-1] + 0.5 * dy)
        return flat_grid(cells, flat_points(x, y, corner), nx, ny, place.spacing)

    def wider(self, patch: Patch) -> str:
        """The grid holds the overlap of the undeformed bodies at an estimated approach."""
        return (
            "they are closer together than the estimate that made the grid; a smaller load, or "
            "wheel_on_rail_gap with a larger approach or scale, and solve_normal on its gap, would do"
        )

    def surfaces(self) -> tuple[Surface, ...]:
        """The surfaces of rail and wheel around the contact, as layers, just touching, without slices."""
        given, place = dict(self.arguments), self.placement
        (rail, _), (wheel, _) = (nominal_of(name, given[name]) for name in ("rail", "wheel"))
        reach = 1.3 * max(float(np.abs(place.x).max()), float(np.abs(place.y).max()))
        along = np.linspace(-reach, reach, 41)

        across = _around(rail, place.rail_position, reach)
        head = np.array([across, rail.height(across)])
        cos, sin = np.cos(given["rail_inclination"]), np.sin(given["rail_inclination"])
        turned = np.array([[cos, -sin], [sin, cos]]) @ head
        at = np.array([[cos, -sin], [sin, cos]]) @ [
            place.rail_position,
            float(rail.height(place.rail_position)),
        ]
        head = turned + (place.position[1:] - at)[:, None]
        foot = head - np.array([[0.0], [0.3 * reach]])
        outline, roller = np.concatenate([head, foot[:, ::-1]], axis=1), given["roller_radius"]
        lower = prism_surface("lower", outline, along)
        if roller is not None:
            ahead, aside, up = lower.vertices
            turned = np.stack(
                [
                    (roller + up) * np.sin(ahead / roller),
                    aside,
                    (roller + up) * np.cos(ahead / roller) - roller,
                ]
            )
            lower = Surface(lower.name, turned, lower.triangles)

        across = _around(wheel, place.wheel_position, 0.8 * reach)
        tape = 0.5 * given["flange_back"] + given["tape_circle"] + given["lateral"]
        radius = given["wheel_radius"] - wheel.height(across)
        ring = np.array(
            [np.append(across, across[::-1]) + tape, np.append(radius, radius[::-1] - 0.3 * reach)]
        )
        tyre = prism_surface("upper", ring, along / given["wheel_radius"])
        angle, station, size = tyre.vertices
        axle = given["wheel_radius"] + place.undeformed_height
        upper = np.stack([size * np.sin(angle), station, axle - size * np.cos(angle)])

        def seen(vertices: Array) -> Array:
            return np.asarray(place.rotation.T @ (vertices - place.position[:, None]))

        return (
            Surface("lower rail", seen(lower.vertices), lower.triangles),
            Surface("upper wheel", seen(upper), tyre.triangles),
        )


def _around(profile: Profile, position: float, reach: float) -> Array:
    """Places on a profile within `reach` of a position."""
    start, end = profile.range
    return np.linspace(max(start, position - reach), min(end, position + reach), 81)
