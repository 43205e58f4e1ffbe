# SPDX-License-Identifier: MIT OR Apache-2.0
"""From the tractions of a result to the stress inside its bodies."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from typing import Any, cast

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .. import _mtb_rs
from ..base import memory
from ..base.check import choice, reals, shortened
from ..base.plain import plain
from ..base.words import Body
from ..bodies.material import Material
from ..bodies.simple import FieldBody, HalfSpace, Inside, Simple
from ..geometry.contact_points import Patch, tangents_of
from .solid import Solid
from .stress_field import StressField

Array = NDArray[np.float64]

#: Depths that are taken by default: their number, the first below the surface as a share of the half width of
#: the contact, and the ratio from one step to the next; they end at three half widths.
_NUMBER, _FIRST, _RATIO = 36, 0.03, 1.055
#: By how much default depths shrink until all of them lie inside a body of finite elements, and how often.
_SHRINK, _SHRINKS = 0.8, 20
#: Share of a thickness by which a depth may be beyond the interface, by rounding.
_ON_INTERFACE = 1e-12
#: Width over length of the cells of a line contact, which stand for an endless strip.
_ENDLESS = 1e-12
#: Memory [bytes] of each point at a depth: six components, their place, and what makes a field of them.
_POINT = 200.0


@dataclass(frozen=True)
@plain
class LoadedGrid:
    """Tractions on cells of one size around the points of a grid in a plane.

    Attributes
    ----------
    name : str
    x, y : (nx,), (ny,) [m]
        Cell centres.
    sides : (dx, dy) [m]
    pressure : (ny, nx) [Pa]
    traction : (2, ny, nx) [Pa]
        On the lower body.
    share : (ny, nx) or None
        Share of each cell that is loaded, where the area of a point is not that of its cell.
    surface, normal : (3, ny, nx) or None
        Where the points are in space [m], and normals of the lower body there: of elastic bodies.
    gap : (ny, nx) or None [m]
        Undeformed gap there.
    turn, shift : (2, 2), (2,) [m], or None
        Where the rows do not lie along x: a place in the track is `turn` times that on the grid, and `shift`.
    """

    name: str
    x: Array
    y: Array
    sides: tuple[float, float]
    pressure: Array
    traction: Array
    share: Array | None = None
    surface: Array | None = None
    normal: Array | None = None
    gap: Array | None = None
    turn: Array | None = None
    shift: Array | None = None

    def own(self, places: Array) -> Array:
        """Places (3, ...) of the track on the grid."""
        if self.turn is None or self.shift is None:
            return places
        away = places[:2] - self.shift.reshape(2, *[1] * (places.ndim - 1))
        return np.concatenate([np.tensordot(self.turn.T, away, 1), places[2:]])

    def placed(self, places: Array) -> Array:
        """Places (3, ...) on the grid in the track."""
        if self.turn is None or self.shift is None:
            return places
        turned = np.tensordot(self.turn, places[:2], 1)
        return np.concatenate([turned + self.shift.reshape(2, *[1] * (places.ndim - 1)), places[2:]])

    def turned(self, stress: Array) -> Array:
        """Stress (6, ...) along the axes of the track from that along those of the grid."""
        if self.turn is None:
            return stress
        xx, yy, zz, yz, xz, xy = stress
        plane = np.einsum("ik,jl,kl...->ij...", self.turn, self.turn, np.array([[xx, xy], [xy, yy]]))
        sheared = np.tensordot(self.turn, np.stack([xz, yz]), 1)
        return np.stack([plane[0, 0], plane[1, 1], zz, sheared[1], sheared[0], plane[0, 1]])

    def on(self, sign: float) -> Array:
        """Tractions on the body (3, ny, nx) [Pa], into which z goes times `sign`: x, y, pressure."""
        own = np.concatenate([-sign * self.traction, self.pressure[None]])
        return np.ascontiguousarray(own if self.share is None else own * self.share)

    def cells(self, side: float) -> Array:
        """Centres and sides (ny * nx, 4) [m] of the cells, `side` long across."""
        x, y = np.meshgrid(self.x, self.y)
        return np.stack([x, y, np.full_like(x, self.sides[0]), np.full_like(x, side)], axis=-1).reshape(-1, 4)

    def half_width(self, *, is_line: bool) -> float:
        """Half of the narrow side [m] of Hertz' contact with the second moments of this pressure."""
        p = self.pressure if self.share is None else self.pressure * self.share
        if not p.any():
            return 0.0
        x, y = np.meshgrid(self.x, self.y)
        weight = p / p.sum()
        away = np.stack([x - (x * weight).sum(), y - (y * weight).sum()])
        moments = np.einsum("ijk,ljk,jk->il", away, away, weight) + np.diag(np.square(self.sides)) / 12.0
        if is_line:
            return float(2.0 * np.sqrt(moments[0, 0]))
        return float(np.sqrt(5.0 * np.linalg.eigvalsh(moments)[0]))


#: Why there is no stress below rows of cells that are turned.
BELOW_INCLINED = "the surface is inclined (inclination), and stresses are known below plane surfaces only"


@dataclass(frozen=True)
@plain
class Loads:
    """What presses on the two bodies of a contact.

    Attributes
    ----------
    grids : tuple of LoadedGrid
        All of them on one lower body, and each on an upper body of its own.
    lower, upper : HalfSpace, Layered, Prism, Rigid or None
        None where the result does not know the body, or where it has finite elements.
    is_periodic, is_line : bool
        Whether the grid repeats itself; whether it is a row of endless strips.
    solids : callable or None
        The elastic bodies of finite elements, where the result has such.
    elastic : tuple of str
        Which bodies, "lower" or "upper", have finite elements that the result does not hold.
    are_apart : bool
        Whether each grid is on a lower body of its own as well: patches in planes of their own.
    way : float or None [rad]
        Direction in which the contact passes over the bodies, from +x towards +y; None where not known.
    """

    grids: tuple[LoadedGrid, ...]
    lower: FieldBody | None
    upper: FieldBody | None
    is_periodic: bool = False
    is_line: bool = False
    solids: Callable[[], Sequence[Solid]] | None = None
    elastic: tuple[str, ...] = ()
    are_apart: bool = False
    way: float | None = None

    def on_body(self, grid: LoadedGrid, body: Body) -> tuple[LoadedGrid, ...]:
        """The grids on the same body as one of them."""
        return (grid,) if body == "upper" or self.are_apart else self.grids

    def grid(self, name: str | None) -> LoadedGrid:
        """The grid of a name; None: that with the largest pressure."""
        if name is None:
            return max(self.grids, key=lambda grid: float(grid.pressure.max(initial=0.0)))
        named = {grid.name: grid for grid in self.grids}
        if name not in named:
            raise ValueError(no_patch(name, named))
        return named[name]


class Stressed:
    """What knows the tractions on two bodies, and so the stress inside them."""

    def _loads(self) -> Loads:
        """What presses; ValueError where that is not known, with the reason."""
        raise NotImplementedError

    def stress(
        self,
        body: Body = "lower",
        *,
        depths: ArrayLike | None = None,
        points: ArrayLike | None = None,
        patch: str | None = None,
        material: Material | None = None,
    ) -> StressField:
        """Stress inside one of the bodies.

        A half-space has the stress of uniform tractions on the cells in closed form [Love1929; Johnson1985,
        ch. 3; AhmadiKeerMura1983]: at depths below all cells by one convolution for each component and depth,
        at other points by a sum over the cells. Only Poisson's ratio matters of the material, so that a body
        that creeps has the same stress under the same tractions. A layered body has that of its layer, at the
        interface as well, and below it that of its base [Burmister1945]. A body of finite elements has the
        stress at its nodes, between which the elements interpolate. Stress by heat is none of it.

        Parameters
        ----------
        body : "lower" or "upper"
        depths : (m,) float or None [m]
            Rising depths of at least 0 below the contact points. None: 36 depths from 0 to three half widths
            of the contact, closer to each other near the surface; in a body that is not as deep, of finite
            elements or a layer on a rigid base, to where all of them lie inside.
        points : (3, ...) float or None [m]
            Places x, y and z in place of depths: in the frame of the result's points, unrolled along the
            surface where that is curved (`origin` of its patches; below a turned shoe about the middle of the
            patch); the inside of the lower body has z <= 0, that of the upper one z >= 0. Of a body of finite
            elements they are places in space.
        patch : str or None
            Of a result with several grids, the one below which: the name of one of its `patches`. None: that
            with the largest pressure. Below the lower body the loads of all grids count; upper bodies are
            apart. Of a step of wheels ``"patches[0]"`` and so on, each in its own plane and apart.
        material : Material or None
            Of a half-space that the result does not know: of steps from files, and of results of earlier
            versions.

        Returns
        -------
        StressField

        Raises
        ------
        ValueError
            For a rigid body, for places outside of the body or in a rigid base, and for bad numbers; for a
            point on the surface at the border of a loaded cell, where the stress of uniform tractions may be
            infinite: a traction along x has an infinite xx and yy at the sides of a cell across x, both
            tractions an infinite xy at its other sides, and a pressure an infinite xy at its corners. The
            middles of cells have finite stresses.

        Examples
        --------
        >>> import mtb_rs as mtb
        >>> ball = mtb.hertz(1e3, 0.02, lower=mtb.steel, upper=mtb.steel)
        >>> inside = ball.stress()
        >>> value, place = inside.maximum("largest_shear")
        >>> round(value / ball.peak_pressure, 2), round(-place[2] / ball.semi_axes[0], 1)
        (0.31, 0.5)
        """
        choice("body", body, Body)
        if depths is not None and points is not None:
            raise ValueError("both depths and points are given: one of them is needed")
        loads = self._loads()
        deep = None if depths is None else rising_depths(depths)
        places = None if points is None else _places(points)
        if patch is not None and not isinstance(patch, str):
            raise ValueError(f"patch is {shortened(patch)}: the name of a grid is needed")
        grid = loads.grid(patch)
        width = grid.half_width(is_line=loads.is_line)
        if places is None and deep is None:
            if not width:
                raise ValueError("depths are not given, and nothing presses that they could follow from")
            steps = np.cumsum(_RATIO ** np.arange(_NUMBER - 1))
            deep = np.concatenate([[0.0], _FIRST * width * steps])
        solids = (
            [solid for solid in loads.solids() if solid.upper == (body == "upper")] if loads.solids else []
        )
        about = (body, width, float(grid.pressure.max(initial=0.0)))
        if solids:
            if material is not None:
                raise ValueError(_KNOWN.format(body=body, material=material))
            if places is not None:
                found = _in_elements(solids, places, about)
            else:
                assert deep is not None
                found = _below_elements(solids, grid, deep, about, may_shrink=depths is None)
        else:
            inside, end = _inside(loads, body, material)
            if places is not None:
                check_elastic(body, _sign(body) * places[2], end)
                found = _at_points(loads, grid, inside, places, about)
            else:
                assert deep is not None
                if depths is None and deep[-1] > end:
                    deep = deep * (end / deep[-1])
                check_elastic(body, deep, end)
                found = _below(loads, grid, inside, deep, about)
        return replace(found, way=loads.way)


_KNOWN = "material is {material!r}: the result knows the {body} body; leave it out"


def no_patch(name: str, known: Iterable[str]) -> str:
    """What is said of a name that no patch has."""
    return f"patch is {shortened(name)}: one of {', '.join(map(repr, known))} is needed"


def rising_depths(given: ArrayLike) -> Array:
    """Depths (m,) [m]; ValueError where they do not rise from 0 or more."""
    deep = np.atleast_1d(reals("depths", given, "m"))
    if deep.ndim != 1 or not deep.size:
        raise ValueError(f"depths has shape {deep.shape}: (m,) with at least one depth is needed")
    if deep.min() < 0.0:
        raise ValueError(
            f"depths[{int(deep.argmin())}] is {deep.min():g} m: depths are measured into the body, and "
            "are at least 0"
        )
    if np.any(np.diff(deep) <= 0.0):
        k = int(np.argmax(np.diff(deep) <= 0.0))
        raise ValueError(
            f"depths[{k + 1}] is {deep[k + 1]:g} m after {deep[k]:g} m: rising depths are needed"
        )
    return deep


def _places(given: ArrayLike) -> Array:
    places = reals("points", given, "m")
    if places.ndim < 1 or places.shape[0] != 3 or not places.size:
        raise ValueError(f"points has shape {places.shape}: (3, ...), the places x, y and z, is needed")
    return places


def _inside(loads: Loads, body: Body, given: Material | None) -> tuple[Inside, float]:
    """What a body is made of inside, and the depth [m] to which it is elastic."""
    own: FieldBody | None = getattr(loads, body)
    if body in loads.elastic:
        raise ValueError(
            f"the {body} body has finite elements, whose inside this result does not hold: the result of "
            "Scene.solve has it"
        )
    if given is not None and not isinstance(given, Material):
        raise ValueError(f"material is {shortened(given)}: a Material is needed")
    if given is not None and own is not None:
        raise ValueError(_KNOWN.format(body=body, material=given))
    if own is None and given is None:
        raise ValueError(
            f"this result does not know its {body} body: stress(material=...) tells it, and only "
            "Poisson's ratio matters"
        )
    if own is not None and own.without_stress:
        other = "upper" if body == "lower" else "lower"
        raise ValueError(f"the {body} body {own.without_stress}; body={other!r} is the other one")
    made = HalfSpace(given) if given is not None else cast("Simple", own)
    inside = made.inside
    assert inside is not None
    return inside, made.elastic_depth


def check_elastic(body: Body, depths: Array, end: float) -> None:
    """ValueError for depths [m] below the depth `end` to which a body is elastic."""
    if depths.max() > end * (1.0 + _ON_INTERFACE):
        k = int(depths.argmax())
        raise ValueError(
            f"place {k} is {depths.ravel()[k]:g} m deep in the {body} body, whose layer ends at {end:g} m: "
            "its base is rigid, and has no stress"
        )


def _sign(body: Body) -> float:
    """What z is into the body."""
    return -1.0 if body == "lower" else 1.0


def _common(stress: Array, sign: float) -> Array:
    """A stress (6, ...) from the body's own frame in the common one."""
    flips = np.array([1.0, 1.0, 1.0, sign, sign, 1.0])
    return np.asarray(stress * flips.reshape(6, *[1] * (stress.ndim - 1)))


def _side(loads: Loads, grid: LoadedGrid) -> float:
    """Length [m] of the cells of a grid along y."""
    return grid.sides[0] * grid.x.size / _ENDLESS if loads.is_line else grid.sides[1]


def _below(
    loads: Loads,
    grid: LoadedGrid,
    inside: Inside,
    deep: Array,
    about: tuple[Body, float, float],
) -> StressField:
    sign, (ny, nx) = _sign(about[0]), grid.pressure.shape
    points = deep.size * ny * nx
    memory.refuse(
        _POINT * points, f"the stress at {deep.size} depths below {nx} x {ny} cells", "give fewer depths"
    )
    sides = (grid.sides[0], _side(loads, grid))
    found, convolutions = _mtb_rs.stress_below(inside, sides, grid.on(sign), deep.tolist(), loads.is_periodic)
    stress = np.moveaxis(found, 1, 0)
    z, y, x = np.meshgrid(sign * deep + 0.0, grid.y, grid.x, indexing="ij")
    places, stress = grid.placed(np.stack([x, y, z])), grid.turned(stress)
    for other in [one for one in loads.on_body(grid, about[0]) if one is not grid]:
        stress = stress + _summed(loads, other, inside, places, sign)
    return StressField(about[0], places, _common(stress, sign), *about[1:], deep, grid.pressure, convolutions)


#: Depth over the side of a cell, below which a point is on the surface.
_ROUNDING = 1e-12


def _at_points(
    loads: Loads,
    grid: LoadedGrid,
    inside: Inside,
    places: Array,
    about: tuple[Body, float, float],
) -> StressField:
    sign = _sign(about[0])
    if loads.is_periodic:
        raise ValueError(
            "the contact is periodic: its stress is known below its points, by depths=..., and not at other "
            "places"
        )
    deep = sign * places[2]
    if deep.min() < 0.0:
        k = int(deep.argmin())
        raise ValueError(
            f"point {k} has z = {places[2].ravel()[k]:g} m, outside of the {about[0]} body: its inside has "
            f"{'z <= 0' if sign < 0.0 else 'z >= 0'}"
        )
    # a depth that rounding leaves of a surface is the surface: below it a border would be on either side
    places = places.copy()
    places[2, deep < _ROUNDING * min(min(one.sides) for one in loads.grids)] = 0.0
    summed = (_summed(loads, one, inside, places, sign) for one in loads.on_body(grid, about[0]))
    stress = sum(summed, np.zeros((6, *places.shape[1:])))
    return StressField(about[0], places, _common(stress, sign), *about[1:])


def _summed(loads: Loads, grid: LoadedGrid, inside: Inside, places: Array, sign: float) -> Array:
    """Stress (6, ...) [Pa] at places in the track by one grid, as of a body below or above z = 0."""
    rows = grid.own(places).reshape(3, -1) * np.array([[1.0], [1.0], [sign]])
    found = _mtb_rs.stress_at(
        inside,
        np.ascontiguousarray(grid.cells(_side(loads, grid))),
        np.ascontiguousarray(grid.on(sign).reshape(3, -1)),
        np.ascontiguousarray(rows.T),
    )
    return grid.turned(np.asarray(found).T.reshape(6, *places.shape[1:]))


def _below_elements(
    solids: Sequence[Solid],
    grid: LoadedGrid,
    deep: Array,
    about: tuple[Body, float, float],
    *,
    may_shrink: bool,
) -> StressField:
    """The stress in an elastic body at depths below the points of a grid."""
    assert grid.surface is not None
    assert grid.normal is not None
    base, into = grid.surface, _sign(about[0]) * grid.normal
    if about[0] == "upper" and grid.gap is not None:
        base = base + grid.gap * grid.normal
    for _ in range(_SHRINKS if may_shrink else 0):
        try:
            return _in_elements(solids, _rays(base, into, deep), about, (deep, grid.pressure))
        except ValueError:
            deep = deep * _SHRINK
    try:
        return _in_elements(solids, _rays(base, into, deep), about, (deep, grid.pressure))
    except ValueError as error:
        raise ValueError(
            f"{error}: stress is asked for below all points of the contact grid down to {deep[-1]:.3g} m, "
            "and some of these lie beside the body, whose face does not fill the grid or whose flanks lean "
            "inwards, or below its end. points=... has the stress at places of your own inside of it"
        ) from error


def _rays(base: Array, into: Array, deep: Array) -> Array:
    """Places (3, m, ny, nx) [m] at depths below points."""
    return np.asarray(base[:, None] + into[:, None] * deep[:, None, None])


def _in_elements(
    solids: Sequence[Solid],
    places: Array,
    about: tuple[Body, float, float],
    over: tuple[Array, Array] | tuple[None, None] = (None, None),
) -> StressField:
    """The stress at the nodes of the elastic body that holds some places, between the nodes."""
    refused: ValueError | None = None
    for solid in sorted(solids, key=lambda solid: _away(solid, places)):
        rows, image = _in_half(solid, places)
        mesh = solid.mesh.checked()
        try:
            stress = np.asarray(
                mesh.at_points(np.ascontiguousarray(solid.stress), np.ascontiguousarray(rows.T))
            )
        except ValueError as error:
            # the nearest body is the one that was meant
            refused = refused or ValueError(f"{error}, of the {about[0]} body {solid.name!r}")
            continue
        stress = stress * np.where(image, np.array([1.0, 1.0, 1.0, -1.0, 1.0, -1.0])[:, None], 1.0)
        return StressField(about[0], places, stress.reshape(6, *places.shape[1:]), *about[1:], *over)
    assert refused is not None
    raise refused


def _in_half(solid: Solid, places: Array) -> tuple[Array, Array]:
    """Places (3, n) [m] in the half of a symmetric body that has elements, and which of them are mirrored."""
    rows = places.reshape(3, -1).copy()
    image = (rows[1] < 0.0) & solid.is_half
    rows[1] = np.where(image, -rows[1], rows[1])
    return rows, image


def _away(solid: Solid, places: Array) -> float:
    """How far [m] places lie on average outside of the box around a body."""
    rows, _ = _in_half(solid, places)
    nodes = np.asarray(solid.mesh.nodes)
    low, high = nodes.min(axis=0)[:, None], nodes.max(axis=0)[:, None]
    return float(np.linalg.norm(np.maximum(np.maximum(low - rows, rows - high), 0.0), axis=0).mean())


def loaded_patches(
    patches: Sequence[Patch],
    points: Array,
    area: Array,
    pressure: Array,
    traction: Array,
    normal: Array | None = None,
    gap: Array | None = None,
) -> tuple[LoadedGrid, ...]:
    """The grids of a result from its flat arrays: points (3, n), tractions (3, n) in space or (2, n) along
    the :func:`tangents_of` the surface.

    Raises
    ------
    ValueError
        If the points are scattered.
    """
    if not patches:
        raise ValueError(
            "the contact points are scattered: the stress below them needs the cells of regular grids"
        )
    grids = []
    for patch in patches:
        place = patch.view(points)
        along, across = _tangents(place)
        up = np.cross(along, across, axis=0)
        up = up / np.linalg.norm(up, axis=0) if normal is None else patch.view(normal)
        across = np.cross(up, along, axis=0)
        own = patch.view(traction)
        if len(own) == 2:
            own = np.einsum("k...,kc...->c...", own, tangents_of(up))
        own = np.stack([(own * along).sum(axis=0), (own * across).sum(axis=0)])
        x, y = patch.axes()
        turn = shift = None
        if not patch.is_along_x(points):
            row = along[:2].reshape(2, -1).mean(axis=1)
            cos, sin = row / np.linalg.norm(row)
            turn = np.array([[cos, -sin], [sin, cos]])
            shift = place[:2].reshape(2, -1).mean(axis=1) - turn @ [x.mean(), y.mean()]
        share = patch.view(area) / (patch.spacing[0] * patch.spacing[1])
        is_whole = bool(np.allclose(share, 1.0, rtol=1e-9))
        grids.append(
            LoadedGrid(
                patch.name,
                x,
                y,
                patch.spacing,
                patch.view(pressure),
                own,
                None if is_whole else share,
                place,
                up,
                None if gap is None else patch.view(gap),
                turn,
                shift,
            )
        )
    return tuple(grids)


def _tangents(points: Array) -> tuple[Array, Array]:
    """Unit vectors (3, ny, nx) along the rows and across them, of points (3, ny, nx)."""

    def unit(axis: int, usual: Sequence[float]) -> Array:
        if points.shape[axis] < 2:
            return np.broadcast_to(np.array(usual)[:, None, None], points.shape)
        step = np.gradient(points, axis=axis)
        return np.asarray(step / np.linalg.norm(step, axis=0))

    return unit(2, (1.0, 0.0, 0.0)), unit(1, (0.0, 1.0, 0.0))


def loaded_grid(
    points: Array, sides: tuple[float, float], pressure: Array, traction: Any = None
) -> LoadedGrid:
    """The grid of a result whose points (2 or 3, ny, nx) are centres of cells of one size in a plane."""
    tangential = np.zeros((2, *pressure.shape)) if traction is None else np.asarray(traction)[:2]
    return LoadedGrid("contact", points[0, 0], points[1, :, 0], sides, pressure, tangential)
