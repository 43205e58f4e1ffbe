# SPDX-License-Identifier: MIT OR Apache-2.0
"""Scenes with elastic bodies: which bodies stand where, how they are held and pulled."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from .. import _mtb_rs
from ..base import cache
from ..base.cache import Memory
from ..base.errors import TooLargeError
from ..base.fingerprint import fingerprint
from ..base.plain import plain
from ..base.words import Side as WheelSide
from ..bodies.elastic_body import Condensed, ElasticBody
from ..bodies.material import Material
from ..bodies.mesh import TetraMesh, block_mesh, check_unknowns, rail_mesh, shoe_mesh
from ..bodies.sides import ElasticPart
from ..bodies.simple import HalfSpace, Rigid, Simple
from ..bodies.supports import Guide, Support, are_at_points
from ..geometry.contact_points import ContactGrid, ContactPoints, Patch
from ..geometry.geometries import Geometry, cells_along
from ..geometry.pole_shoe import PoleShoe
from .refined import THINNER, Lines, NotRefinedError, carrier_spacing, lines_of, spacing_of_lines
from .standing import Contact, ElasticBodies, averages, cells_of, condensed_part, hats_of
from .symmetry import alike

Array = NDArray[np.float64]

Made = TypeVar("Made")

#: Distances of the lines that are tried one after the other, as shares of the first ones.
DENSER = (1.0, 0.7, 0.5)
#: Share of its area by which a patch may miss the face of its elastic body.
COVERAGE = 0.01
#: What there is to say of bodies at points that are condensed onto fewer points than touch.
ON_POINTS = (
    "The upper body is held at points and condensed onto fewer points than touch: its elements are wider "
    "than the cells, and it gives way less at its supports than on elements as wide as these. element_size "
    "sets the width of elements, and supports that are faces do not depend on it."
)
#: What there is to say of a `name` body that would be too large on all of its points.
ON_FEWER = (
    "The {name} body was condensed onto fewer points than touch, because with elements as wide as the cells "
    "it would be too large"
)


@dataclass(frozen=True)
@plain
class Held:
    """How the ready elastic bodies above are held and meshed.

    Attributes
    ----------
    supports : str or sequence of Support
    element_size : float [m] or None
        At the contact; None: that of the contact grid.
    thinner : float
        Their layers are those of a grid finer by this factor.
    carrier : (dx, dy) [m] or None
        Largest distance of the lines that bodies, the rail too, are condensed onto; None: of all lines, or of
        fewer where the contact points are many.
    """

    supports: Any
    element_size: float | None = None
    thinner: float = 1.0
    carrier: tuple[float, float] | None = None


def half_spaces(geometry: Geometry, upper: Simple, lower: Simple, spacing: tuple[float, float]) -> Contact:
    """Half-spaces or rigid bodies on the cells of a geometry."""

    def build() -> Contact:
        below = cells_of(lower, grid.cells, grid.patches, upper=False)
        return Contact(
            points=grid.cells,
            area=grid.area,
            patches=grid.patches,
            is_grid=geometry.is_grid,
            upper=cells_of(upper, grid.cells, grid.patches, upper=True),
            lower=below,
            notes=below.notes,
        )

    grid = geometry.grid(spacing)
    key = {"cells": grid.cells.points, "gap": grid.cells.gap, "bodies": fingerprint((upper, lower))}
    return cache.recalled(cache.content_key(key), build)


def on_rigid(
    geometry: Geometry,
    upper: HalfSpace,
    spacing: tuple[float, float],
    held: Held,
    time_s: dict[str, float],
) -> Contact:
    """The elastic upper bodies of a geometry on a rigid one."""

    def build() -> Contact:
        geometry.check_elastic(spacing)
        grid = geometry.grid(spacing)
        above, area, notes = upper_bodies(geometry, grid, upper.material, held, time_s)
        points, patches = grid.nodes, grid.node_patches
        return Contact(
            points=points,
            area=area,
            patches=patches,
            is_grid=geometry.is_grid,
            upper=above,
            lower=hats_of(Rigid(), points, patches, upper=False),
            averages=averages(above.parts),
            notes=notes,
        )

    return cache.recalled(fingerprint((geometry, spacing, upper, held)), build)


def on_foundation(
    geometry: Geometry,
    bodies: tuple[HalfSpace, Simple],
    spacing: tuple[float, float],
    held: Held,
    time_s: dict[str, float],
) -> Contact:
    """The elastic upper bodies of a geometry on a half-space or a rigid body.

    Parameters
    ----------
    bodies : (upper, lower)
    """
    upper, lower = bodies
    if lower == Rigid():
        return on_rigid(geometry, upper, spacing, held, time_s)

    def build() -> Contact:
        above = on_rigid(geometry, upper, spacing, held, time_s)
        below = hats_of(lower, above.points, above.patches, upper=False)
        return replace(above, lower=below, notes=above.notes + below.notes, memory=Memory())

    return cache.recalled(fingerprint((geometry, spacing, bodies, held, "foundation")), build)


def on_rail(
    geometry: Geometry,
    bodies: tuple[HalfSpace, HalfSpace],
    spacing: tuple[float, float],
    held: Held,
    image: NDArray[np.intp] | None,
    time_s: dict[str, float],
) -> Contact:
    """The elastic upper bodies of a geometry on the elastic rail.

    Parameters
    ----------
    bodies : (upper, lower)
    image : (n,) int or None
        The mirror image of each point where all above the rail is symmetric.
    """
    upper, lower = bodies

    def build() -> Contact:
        above = on_rigid(geometry, upper, spacing, held, time_s)
        below, notes = rail(geometry, geometry.grid(spacing), lower.material, image, held.carrier, time_s)
        return replace(above, lower=below, notes=above.notes + notes, memory=Memory())

    return cache.recalled(fingerprint((geometry, spacing, bodies, held, "rail", image)), build)


def upper_solids(
    geometry: Geometry,
    grid: ContactGrid,
    material: Material,
    held: Held,
    time_s: dict[str, float],
    lines: Lines | None = None,
) -> list[tuple[ElasticBody, bool]]:
    """The upper bodies, one a patch, meshed on some lines or on all; whether each is its image."""
    found: list[tuple[ElasticBody, bool]] = []
    for k, patch in enumerate(grid.node_patches):
        solid = _upper_body(
            geometry, grid, patch, material, held, time_s, None if lines is None else lines[k]
        )
        is_twin = bool(found) and isinstance(held.supports, str)
        found.append(
            (solid, is_twin and _is_twin(found[0][0], grid.node_patches[0], grid.nodes, solid, patch))
        )
    return found


def upper_bodies(
    geometry: Geometry, grid: ContactGrid, material: Material, held: Held, time_s: dict[str, float]
) -> tuple[ElasticBodies, Array, tuple[str, ...]]:
    """The upper bodies, one a patch, the area of each contact point (n,) [m2], and what there is to say."""

    def on(lines: Lines | None) -> tuple[ElasticBodies, Array]:
        return _upper_bodies(geometry, grid, lines, material, held, time_s)

    (bodies, area), notes = _on_lines("upper", on, grid.node_patches, held.carrier)
    is_refined = any(flexible.refined is not None for flexible in bodies.condensed)
    at_points = any(are_at_points(part.body.supports) for part in bodies.parts)
    if is_refined and at_points and held.element_size is None:
        notes += (ON_POINTS,)
    return bodies, area, notes


def _on_lines(
    name: str,
    on: Callable[[Lines | None], Made],
    patches: Sequence[Patch],
    carrier: tuple[float, float] | None,
) -> tuple[Made, tuple[str, ...]]:
    """What is made `on` lines by a carrier, on denser ones where these are refused, or on all of them; and
    what there is to say of it.

    Elements are as wide as the distance of the lines, and on all of them the mesh of a thick body may be too
    large.
    """
    widest = carrier_spacing(patches) if carrier is None else carrier
    too_large: TooLargeError | None = None
    if widest is None:
        try:
            return on(None), ()
        except TooLargeError as error:
            too_large, widest = error, spacing_of_lines(patches)
    refusal = ""
    for share in DENSER:
        try:
            made = on(lines_of(patches, (share * widest[0], share * widest[1])))
        except NotRefinedError as error:
            refusal = str(error)
            continue
        except TooLargeError as error:
            # the first one tells what the cells of the scene would take
            raise (too_large or error) from None
        return made, () if too_large is None else (f"{ON_FEWER.format(name=name)}: {too_large}.",)
    if too_large is not None:
        raise too_large
    note = f"The {name} body was condensed onto all of its contact points, because on fewer ones {refusal}."
    return on(None), (note,)


def _upper_bodies(
    geometry: Geometry,
    grid: ContactGrid,
    lines: Lines | None,
    material: Material,
    held: Held,
    time_s: dict[str, float],
) -> tuple[ElasticBodies, Array]:
    """The upper bodies on the nodes of a grid, condensed onto some lines or onto all."""
    points, patches = grid.nodes, grid.node_patches
    parts: list[ElasticPart] = []
    compliances: list[_mtb_rs.Compliance] = []
    condensed: list[Condensed] = []
    solids = upper_solids(geometry, grid, material, held, time_s, lines)
    for k, (patch, (solid, is_twin)) in enumerate(zip(patches, solids, strict=True)):
        if is_twin:
            part, flexible, compliance = _twin(parts[0], condensed[0], patch, points.at(patch.cut))
        else:
            part = _upper_part(solid, points, patch)
            flexible = condensed_part(part, time_s, None if lines is None else lines[k : k + 1])
            covered = flexible.weights.sum() / (np.prod(patch.spacing) * (patch.nx - 1) * (patch.ny - 1))
            if abs(covered - 1.0) > COVERAGE:
                raise ValueError(
                    f"patch {patch.name!r} meets only {100 * covered:.0f} % of its area on the {solid.name}: "
                    "the sole leaves the surface below too steeply (lateral, yaw)"
                )
            compliance = flexible.compliance
        parts.append(part)
        condensed.append(flexible)
        compliances.append(compliance)
    bodies = ElasticBodies(tuple(parts), tuple(condensed), tuple(compliances), points)
    return bodies, np.concatenate([c.weights for c in condensed])


def _upper_part(solid: ElasticBody, points: ContactPoints, patch: Patch) -> ElasticPart:
    places = points.at(patch.cut)
    # contact points lie on the lower body, the upper one is a gap away from them
    places = replace(places, points=places.points + places.gap * places.normal)
    n = patch.nx * patch.ny
    own = (replace(patch, start=0),)
    return ElasticPart(solid, own, places, patch.start, True, np.zeros(n), np.zeros((0, 9)))


def _is_twin(
    left: ElasticBody, first: Patch, points: ContactPoints, solid: ElasticBody, patch: Patch
) -> bool:
    """Whether a further pole, named supports and all, is the mirror image of the first, rail and gap too."""
    mesh, mirrored = solid.mesh, left.mesh.mirrored()
    if (patch.nx, patch.ny) != (first.nx, first.ny) or mesh.cells.shape != mirrored.cells.shape:
        return False
    if not np.array_equal(mesh.cells, mirrored.cells) or not alike(mesh.nodes, mirrored.nodes):
        return False
    flip = np.array([1.0, -1.0, 1.0])[:, None, None]
    there = {k: (first.view(v), patch.view(v)[..., ::-1, :]) for k, v in vars(points).items()}
    vectors = ("points", "normal", "tangent_x")
    return alike(*there["gap"]) and all(alike(a * flip, b) for a, b in (there[k] for k in vectors))


def _mirrored(where: Any) -> Any:
    """Where the mirror y = 0 puts a side known by name, or points (k, 3)."""
    if isinstance(where, str):
        return {"left": "right", "right": "left"}.get(where, where)
    return np.asarray(where) * [1.0, -1.0, 1.0]


def _sense(mode: Array) -> float:
    """The sign of what a rigid motion (9,) is named by: its largest rotation, else translation."""
    named = mode[3:6] if mode[3:6].any() else mode[:3]
    return float(np.sign(named[np.abs(named).argmax()]))


def _twin(
    left: ElasticPart, flexible: Condensed, patch: Patch, points: ContactPoints
) -> tuple[ElasticPart, Condensed, _mtb_rs.Compliance]:
    """The right pole, known from the left one."""
    # rows are numbered with y rising on both sides, so the mirror turns their order round
    original = np.arange(patch.nx * patch.ny).reshape(patch.ny, patch.nx)[::-1].ravel()
    supports = [replace(s, where=_mirrored(s.where)) for s in left.body.supports]
    body = ElasticBody(left.body.mesh.mirrored(), left.body.material, "contact", supports, "right pole")
    flip = np.array([[1.0], [-1.0], [1.0]])
    # translations and points are vectors, rotations are not: the mirror keeps what it flips in the others
    seen_modes = flexible.modes * np.array([1.0, -1.0, 1.0, -1.0, 1.0, -1.0, 1.0, -1.0, 1.0])
    # motions of both poles are positive along and about the same axes
    sign = np.array([_sense(mode) for mode in seen_modes])
    modes = seen_modes.copy()
    modes[:, :6] *= sign[:, None]

    def seen(field: Array) -> Array:
        return np.ascontiguousarray(field[..., original] * flip)

    # the mirror turns round the force along y and the moments about x and z
    turned = np.array([1.0, -1.0, 1.0, -1.0, 1.0, -1.0])
    # supports are mirrored with all they are given: the same amounts along x and z, the opposite along y
    case = np.array([-1.0 if component == 1 else 1.0 for _, component, _ in left.body.core.cases])
    mirrored = replace(
        flexible,
        weights=flexible.weights[original],
        modes=modes,
        mode_displacement=seen(flexible.mode_displacement) * sign[:, None, None],
        case_displacement=seen(flexible.case_displacement) * case[:, None, None],
        case_work=flexible.case_work * case[:, None] * sign,
        spread_displacement=seen(flexible.spread_displacement) * turned[:, None, None],
        centre=flexible.centre * [1.0, -1.0, 1.0],
        contact_resultant=seen(flexible.contact_resultant) * turned[:, None, None],
        reaction=seen(flexible.reaction) * turned[:, None, None],
        case_reaction=flexible.case_reaction * turned[:, None] * case,
        spread_reaction=flexible.spread_reaction * turned[:, None] * turned,
    )
    part = ElasticPart(
        body, (replace(patch, start=0),), points, patch.start, True, np.zeros(original.size), np.zeros((0, 9))
    )
    return part, mirrored, flexible.compliance.reflected(original.tolist())


def rail(
    geometry: Geometry,
    grid: ContactGrid,
    material: Material,
    image: NDArray[np.intp] | None,
    carrier: tuple[float, float] | None,
    time_s: dict[str, float],
) -> tuple[ElasticBodies, tuple[str, ...]]:
    """The rail under all patches, with `carrier` as in :class:`Held`, and what there is to say of it.

    With the mirror `image` (n,) of each point all above the rail is symmetric; half of a symmetric rail is
    then enough.
    """
    if image is not None and not geometry.rail()[0].is_symmetric:
        image = None

    def on(lines: Lines | None) -> ElasticBodies:
        return _rail(geometry, grid, lines, material, image, time_s)

    return _on_lines("lower", on, grid.node_patches, carrier)


def _rail(
    geometry: Geometry,
    grid: ContactGrid,
    lines: Lines | None,
    material: Material,
    image: NDArray[np.intp] | None,
    time_s: dict[str, float],
) -> ElasticBodies:
    """The rail on the nodes of a grid, condensed onto some lines or onto all."""
    half = image is not None
    solid, carried = rail_solid(geometry, grid, material, half=half, time_s=time_s, lines=lines)
    n = sum(p.nx * p.ny for p in carried)
    own = grid.nodes.at(slice(0, n))
    part = ElasticPart(solid, tuple(carried), own, 0, False, np.zeros(n), np.zeros((0, 9)), is_half=half)
    flexible = condensed_part(part, time_s, None if lines is None else lines[: len(carried)])
    return ElasticBodies((part,), (flexible,), (flexible.compliance,), own, image)


def rail_solid(
    geometry: Geometry,
    grid: ContactGrid,
    material: Material,
    *,
    half: bool,
    time_s: dict[str, float],
    lines: Lines | None = None,
) -> tuple[ElasticBody, tuple[Patch, ...]]:
    """The rail, meshed on some lines or on all, or its `half` y >= 0, and the patches that it carries."""
    patches = grid.node_patches
    profile, length = geometry.rail()
    clock = time.perf_counter()
    places = [_grid_lines(grid, patch) for patch in patches]
    if lines is not None:
        places = [(x[own[0]], y[own[1]]) for (x, y), own in zip(places, lines, strict=True)]
    x, rows = _mtb_rs.rail_lines([x for x, _ in places]), [np.sort(np.abs(y)) for _, y in places]
    mesh = rail_mesh(profile, x, rows[0], length, right=rows[-1], half=half)
    supports = [Support("base", x=0, y=0, z=0)]
    if half:
        supports.append(Support("symmetry", y=0))  # "2 symmetry" in the balance
    carried, where = (patches[:1], "left") if half else (patches, "head")
    solid = ElasticBody(mesh, material, where, supports, "rail")
    time_s["mesh"] = time_s.get("mesh", 0.0) + time.perf_counter() - clock
    return solid, carried


@dataclass(frozen=True)
class Meshed:
    """Meshes of tetrahedra, with the options of the meshes in :mod:`mtb_rs.bodies.mesh`."""

    options: Mapping[str, Any]

    def block(self, x: Array, y: Array, height: float) -> TetraMesh:
        return block_mesh(x, y, height, **self.options)

    def pole(self, shoe: PoleShoe, x: Array, y: Array, side: WheelSide) -> TetraMesh:
        return shoe_mesh(shoe, x, y, side=side, **self.options)


def _upper_body(
    geometry: Geometry,
    grid: ContactGrid,
    patch: Patch,
    material: Material,
    held: Held,
    time_s: dict[str, float],
    lines: tuple[list[int], list[int]] | None,
) -> ElasticBody:
    supports, element_size = held.supports, held.element_size
    clock = time.perf_counter()
    # evenly spaced over the face, though not along y where that is curved
    x, y = (np.linspace(along[0], along[-1], along.size) for along in _grid_lines(grid, patch))
    if lines is not None:
        x, y = x[lines[0]], y[lines[1]]
    nx, ny = x.size, y.size
    if element_size is not None:
        sides = (patch.nx - 1) * patch.spacing[0], (patch.ny - 1) * patch.spacing[1]
        if element_size > min(sides):
            raise ValueError(
                f"element_size is {element_size:g} m: the contact measures {sides[0]:.4g} x {sides[1]:.4g} "
                "m, smaller elements are needed"
            )
        nx, ny = (cells_along(side, element_size) + 1 for side in sides)
        check_unknowns(6.0 * nx * ny)
    # the points at the back must not move with the layers
    built: dict[str, Any] = {
        "halved": isinstance(supports, str) and supports in ("points", "fixed-points"),
        "clamped": not isinstance(supports, str) or supports == "clamped-top",
        "thinner": held.thinner * (1.0 if lines is None else THINNER),
    }
    if element_size is not None:
        x, y = np.linspace(x[0], x[-1], nx), np.linspace(y[0], y[-1], ny)
    part = geometry.upper_body(Meshed(built), grid, patch, (x, y))
    ways = _supports(supports, part.middle, part.size, part.height, part.turn)
    try:
        body = ElasticBody(part.mesh, material, "contact", ways, part.name)
    except ValueError as error:
        if "tetrahedron" not in str(error):
            raise
        raise ValueError(
            f"height is {part.height:g} m: the {part.name} cannot be filled with elements "
            f"{part.element:.3g} m wide at the contact ({error})"
        ) from None
    time_s["mesh"] = time_s.get("mesh", 0.0) + time.perf_counter() - clock
    return body


def _supports(
    supports: Any, middle: Array, size: tuple[float, float], height: float, turn: Array
) -> tuple[Support, ...]:
    """The named ways to hold the top of a block or a pole."""
    if not isinstance(supports, str):
        return tuple(supports)
    if supports == "driven-top":
        return (Support("top", x=0.0, y=0.0),)
    if supports == "clamped-top":
        return (Support("top", x=0.0, y=0.0, z=0.0),)
    top, back = (np.array(points) @ turn.T + middle for points in _mtb_rs.held_points(size, height))
    vertical: float | Guide = Guide(0.0) if supports == "points" else 0.0
    return (
        Support(top, y=0.0, z=vertical, name="top points"),
        Support(back, x=0.0, name="back points"),
    )


def _grid_lines(grid: ContactGrid, patch: Patch) -> tuple[Array, Array]:
    """x of the columns and y of the rows of a patch of nodes [m], of a turned one their means."""
    x, y = patch.view(grid.nodes.points[0]), patch.view(grid.nodes.points[1])
    return x.mean(axis=0), y.mean(axis=1)
