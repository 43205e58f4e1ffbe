# SPDX-License-Identifier: MIT OR Apache-2.0
"""The pressure on a regular grid: what tangential contact starts from."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..base.check import pair, positive, reals
from ..base.owning import owning
from ..base.plain import plain
from ..base.words import Body
from ..bodies.material import Material
from ..bodies.prism import Prism
from ..bodies.simple import Layered, Medium, Rigid, Simple, Viscoelastic, are_prisms, field_body, prism_of
from .prisms import Prisms, prisms_under

Array = NDArray[np.float64]


@owning
@dataclass(frozen=True)
@plain
class PressureField:
    """A given pressure between two bodies.

    Parameters
    ----------
    pressure : (ny, nx) float [Pa]
        On rectangular cells; contact is where it is positive.
    spacing : (float, float) [m]
        Cell sizes along x and y. In a line contact the second is the length considered (1 m).
    lower, upper : Material, Layered, Viscoelastic, Prism or None
        None for a rigid body; a layer is bonded to its base; a body that creeps rolls steadily; y goes along
        the surface of a prism from its origin.
    origin : (float, float) or None [m]
        Centre of the first cell; None puts the middle of the grid at (0, 0).
    reference : float or None [m]
        For a line contact (one row of cells, plane strain): distance from the load at which the
        displacement vanishes. It does not matter in rolling or at a given force.
    inclination : (ny,) or None [rad]
        Of each row of cells, as of :func:`mtb_rs.solve_normal`; None for a plane surface.
    """

    pressure: Array
    spacing: tuple[float, float]
    lower: Medium | None
    upper: Medium | None
    origin: tuple[float, float] | None = None
    reference: float | None = None
    inclination: Array | None = None

    def __post_init__(self) -> None:
        pressure = reals("pressure", self.pressure, "Pa")
        if pressure.ndim != 2 or pressure.size == 0:
            raise ValueError(f"pressure has shape {pressure.shape}: (ny, nx) is needed")
        if np.any(pressure < 0.0):
            where = np.unravel_index(int(np.argmin(pressure)), pressure.shape)
            at = tuple(int(k) for k in where)
            raise ValueError(f"pressure at {at} is {pressure[where]:g} Pa: it must not be negative")
        dx, dy = pair("spacing", self.spacing, "m")
        if dx <= 0.0 or dy <= 0.0:
            raise ValueError(f"spacing is {self.spacing!r} m: two positive numbers are needed")
        if self.reference is not None:
            positive("reference", self.reference, "m")
            if pressure.shape[0] != 1:
                raise ValueError(f"a line contact has one row of cells, pressure has {pressure.shape[0]}")
        for name in ("lower", "upper"):
            body = getattr(self, name)
            if body is not None and not isinstance(body, (Material, Layered, Viscoelastic, Prism)):
                raise ValueError(
                    f"{name} is {body!r}: a Material, Layered or Prism is needed, or None for a rigid body; "
                    "in steady rolling a Viscoelastic as well"
                )
            if isinstance(body, Layered) and not body.bonded:
                raise ValueError(
                    f"{name} is a Layered that is not bonded: a layer that slides on its base without "
                    "friction would be carried away by the traction: bonded=True is needed"
                )
            if isinstance(body, (Layered, Viscoelastic, Prism)) and self.reference is not None:
                raise ValueError(
                    f"{name} is a {type(body).__name__}: in a line contact a Material is needed, or None; "
                    "one row of cells that are long across takes it without `reference`"
                )
        if self.inclination is not None:
            alike = self.lower == self.upper and self.reference is None
            angles = inclination_of(self.inclination, pressure.shape[0], self.lower if alike else None)
            object.__setattr__(self, "inclination", angles)
        if self.lower is None and self.upper is None:
            raise ValueError("both bodies are rigid: one of them must be elastic")
        ny, nx = pressure.shape
        middle = (-0.5 * (nx - 1) * dx, -0.5 * (ny - 1) * dy)
        origin = middle if self.origin is None else pair("origin", self.origin, "m")
        object.__setattr__(self, "pressure", pressure)
        object.__setattr__(self, "spacing", (dx, dy))
        object.__setattr__(self, "origin", (origin[0], origin[1]))

    def body(self, side: Body) -> Simple | Prism:
        """The lower or the upper body."""
        own: Medium | None = getattr(self, side)
        return Rigid() if own is None else field_body(side, own)

    @property
    def is_in_rows(self) -> bool:
        """Whether a body is a prism."""
        return are_prisms(self.lower, self.upper)

    def prisms(self) -> Prisms | None:
        """The prisms under its cells; None without one."""
        ny, nx = self.pressure.shape
        return prisms_under(self.lower, self.upper, self.start[1], (ny, nx), self.spacing)

    def angles(self) -> Array | None:
        """Inclination (ny,) [rad] of its rows; None on a plane."""
        prisms = self.prisms()
        return self.inclination if prisms is None else prisms.angles

    @property
    def start(self) -> tuple[float, float]:
        """Centre of the first cell [m]."""
        assert self.origin is not None
        return self.origin

    @property
    def normal_force(self) -> float:
        """Sum of pressure times area [N]."""
        return float(self.pressure.sum() * self.spacing[0] * self.spacing[1])

    def coordinates(self) -> tuple[Array, Array]:
        """x (nx,) and y (ny,) of the cell centres [m]."""
        ny, nx = self.pressure.shape
        x0, y0 = self.start
        x: Array = np.asarray(x0 + self.spacing[0] * np.arange(nx))
        y: Array = np.asarray(y0 + self.spacing[1] * np.arange(ny))
        return x, y

    def centre(self) -> tuple[float, float]:
        """Centre of pressure (x, y) [m]."""
        x, y = self.coordinates()
        p = self.pressure / self.pressure.sum()
        return float(x @ p.sum(axis=0)), float(y @ p.sum(axis=1))

    def patches(self) -> list[tuple[tuple[slice, slice], PressureField]]:
        """The separate contacts, each on its smallest rectangle (rows, columns) of the grid.

        Cells that touch, be it at a corner, are one contact.
        """
        found = []
        for label, cut in _labelled(self.pressure > 0.0):
            part = np.where(label, self.pressure[cut], 0.0)
            start = (
                self.start[0] + cut[1].start * self.spacing[0],
                self.start[1] + cut[0].start * self.spacing[1],
            )
            angles = None if self.inclination is None else self.inclination[cut[0]]
            found.append((cut, replace(self, pressure=part, origin=start, inclination=angles)))
        return found

    def semi_axes(self) -> tuple[float, float]:
        """Semi-axes (a along x, b along y) [m] of the Hertzian ellipse with the same second moments.

        Cells count with their own width, so the axes of a Hertzian pressure come out to second order.
        """
        along, across = np.sqrt(5.0 * np.diagonal(self._moments()))
        return float(along), float(across)

    def correlation(self, angle: float) -> float:
        """Of the places of the pressure along and across a direction [rad]: 0 where the axes of its moments
        lie along it, up to 1."""
        c, s = np.cos(angle), np.sin(angle)
        axes = np.array([[c, s], [-s, c]])
        moments = axes @ self._moments() @ axes.T
        return float(moments[0, 1] / np.sqrt(moments[0, 0] * moments[1, 1]))

    def _moments(self) -> Array:
        """Second moments (2, 2) [m2] of the places of the pressure, over the force."""
        places = np.stack([p.ravel() for p in np.meshgrid(*self.coordinates())])
        share = self.pressure.ravel() / self.pressure.sum()
        places = places - (places @ share)[:, None]
        return np.asarray((share * places) @ places.T + np.diag(np.square(self.spacing)) / 12.0)

    def unlikeness(self) -> float:
        """What couples pressure and slip of two half-spaces: 0 of like ones, 1 of one on a rigid body."""
        return unlikeness(
            *(
                (body.shear_modulus, body.poisson_ratio) if isinstance(body, Material) else None
                for body in (self.lower, self.upper)
            )
        )

    def is_unlike(self) -> bool:
        """Whether the pressure of the two bodies makes their surfaces slip by more than a little."""
        # near the load a prism gives way as its material does
        prisms = prism_of(self.lower), prism_of(self.upper)
        lower, upper = (
            body if prism is None else prism.material
            for body, prism in zip((self.lower, self.upper), prisms, strict=True)
        )
        if isinstance(lower, Material) and isinstance(upper, Material):
            own = ((body.shear_modulus, body.poisson_ratio) for body in (lower, upper))
            return unlikeness(*own) > UNLIKE
        return bool(lower != upper)

    def pair_modulus(self) -> tuple[float, float]:
        """Shear modulus [Pa] and Poisson's ratio of two equal bodies that are as flexible as these two.

        Raises
        ------
        ValueError
            Where a body is layered.
        """
        flexibility, ratio = 0.0, 0.0
        for body in (self.lower, self.upper):
            if isinstance(body, Layered):
                raise ValueError(
                    "a body is Layered: the fast approximations of creep forces are those of half-spaces of "
                    "one material, and solve_tangential takes layers"
                )
            if isinstance(body, Prism):
                raise ValueError(
                    "a body is a Prism: the fast approximations of creep forces are those of half-spaces, "
                    "and solve_tangential takes prisms"
                )
            if isinstance(body, Viscoelastic):
                raise ValueError(
                    "a body is Viscoelastic: the fast approximations of creep forces are those of elastic "
                    "half-spaces, and solve_tangential takes such bodies"
                )
            if body is not None:
                flexibility += 0.5 / body.shear_modulus
                ratio += 0.5 * body.poisson_ratio / body.shear_modulus
        return 1.0 / flexibility, ratio / flexibility


def unlikeness(lower: tuple[float, float] | None, upper: tuple[float, float] | None) -> float:
    """What couples pressure and slip of two half-spaces, (shear modulus [Pa], Poisson's ratio) or rigid."""
    first, second = (0.0 if body is None else (1.0 - 2.0 * body[1]) / body[0] for body in (lower, upper))
    return abs(first - second) / (first + second) if first + second > 0.0 else 0.0


def _labelled(mask: NDArray[np.bool_]) -> list[tuple[NDArray[np.bool_], tuple[slice, slice]]]:
    """The connected parts of a mask: each with its smallest rectangle, and the mask of the part on it."""
    padded = np.zeros((mask.shape[0], mask.shape[1] + 2), dtype=np.int8)
    padded[:, 1:-1] = mask
    # runs of cells, row by row: (row, first, end)
    change = np.diff(padded, axis=1)
    rows, first = np.nonzero(change == 1)
    _, end = np.nonzero(change == -1)
    parent = list(range(len(rows)))

    def root(k: int) -> int:
        while parent[k] != k:
            parent[k] = parent[parent[k]]
            k = parent[k]
        return k

    begin = np.searchsorted(rows, np.arange(mask.shape[0] + 1))
    for row in range(1, mask.shape[0]):
        above, here = int(begin[row - 1]), int(begin[row])
        while above < begin[row] and here < begin[row + 1]:
            if first[above] <= end[here] and first[here] <= end[above]:
                parent[root(here)] = root(above)
            # the run that ends first meets no later one
            if end[above] < end[here]:
                above += 1
            else:
                here += 1
    roots = np.array([root(k) for k in range(len(rows))], dtype=int)
    parts = []
    for label in np.unique(roots):
        own = np.flatnonzero(roots == label)
        top, left = int(rows[own].min()), int(first[own].min())
        cut = (slice(top, int(rows[own].max()) + 1), slice(left, int(end[own].max())))
        part = np.zeros((cut[0].stop - top, cut[1].stop - left), dtype=bool)
        for k in own:
            part[rows[k] - top, first[k] - left : end[k] - left] = True
        parts.append((part, cut))
    return parts


def inclination_of(inclination: ArrayLike, rows: int, material: Any) -> Array:
    """Angles (rows,) [rad] of rows of cells, checked; `material`: that of both half-spaces, None where they
    have no common one."""
    angles = reals("inclination", inclination, "rad")
    if angles.shape != (rows,):
        raise ValueError(
            f"inclination has shape {angles.shape}: one angle [rad] for each of the "
            f"{rows} rows of cells is needed"
        )
    if np.ptp(angles) >= np.pi:
        raise ValueError(
            f"inclination goes from {angles.min():g} to {angles.max():g} rad: less than half a turn is needed"
        )
    if not isinstance(material, Material):
        raise ValueError(
            "inclination is given, and the bodies are not two half-spaces of the same material: a curved "
            "surface is known for these only"
        )
    return angles


def creepage_rows(creepages: ArrayLike) -> Array:
    """Creepages (n, 3) [-, -, 1/m], checked; one row alone is (3,)."""
    given = reals("creepages", creepages)
    rows = np.ascontiguousarray(np.atleast_2d(given))
    if rows.ndim != 2 or rows.shape[1] != 3:
        raise ValueError(f"creepages has shape {given.shape}: (3,) or (n, 3) is needed")
    return rows


def pressure_field(normal: Any) -> PressureField:
    """The pressure, grid and bodies of a normal result, a scene's result, or a :class:`PressureField`.

    The closed form of Hertz is put on 50 x 50 cells over its ellipse.

    Raises
    ------
    ValueError
        If it is no pressure on the equal cells of half-spaces, with what to do; above all of elastic bodies,
        whose pressure is known at the nodes of their elements.
    """
    if isinstance(normal, PressureField):
        return normal
    if hasattr(normal, "on_grid"):
        a, b = normal.semi_axes
        normal = normal.on_grid((50, 50), (2.0 * a / 50, 2.0 * b / 50))
    if getattr(normal, "periodic", False):
        raise ValueError("the contact is periodic: tangential contact needs one that ends")
    for name in ("pressure", "points", "lower", "upper"):
        if not hasattr(normal, name):
            raise ValueError(
                f"normal is a {type(normal).__name__}: it has no {name!r}; a PressureField or a result of "
                "a normal contact is needed"
            )
    model = getattr(normal, "model", "half-space")
    if model != "half-space":
        raise ValueError(
            f"normal is a result of the model {model!r}, whose elastic bodies are pressed at the nodes of "
            f"their elements: {HALF_SPACES_MOVE}"
        )
    is_in_rows = getattr(normal, "is_in_rows", False)
    bodies = [_half_space(name, getattr(normal, name), is_in_rows=is_in_rows) for name in ("lower", "upper")]
    pressure = np.asarray(normal.pressure, dtype=float)
    points = np.asarray(normal.points, dtype=float)
    if pressure.ndim != 2:
        raise ValueError(
            f"pressure has shape {pressure.shape}: tangential contact needs one regular patch, (ny, nx)"
        )
    # the patch of a wheel lies in a plane of its own, and its points in the track
    x, y = (np.asarray(getattr(normal, name, ()), dtype=float) for name in "xy")
    if (y.shape, x.shape) != ((pressure.shape[0],), (pressure.shape[1],)):
        x, y = points[0, 0, :], points[1, :, 0]
    spacing = getattr(normal, "spacing", None)
    if spacing is None:
        if min(pressure.shape) < 2:
            raise ValueError("the spacing of a single row of cells cannot be told: give a PressureField")
        spacing = (float(x[1] - x[0]), float(y[1] - y[0]))
    spacing = tuple(float(d) for d in np.broadcast_to(spacing, 2))
    area = np.asarray(getattr(normal, "area", spacing[0] * spacing[1]), dtype=float)
    if not np.allclose(area, spacing[0] * spacing[1], rtol=1e-6, atol=0.0):
        raise ValueError(
            f"normal has points of {area.min():g} to {area.max():g} m2 on a grid of {spacing[0]:g} x "
            f"{spacing[1]:g} m: tangential contact needs equal cells; give a PressureField"
        )
    return PressureField(
        pressure=np.maximum(pressure, 0.0),
        spacing=(spacing[0], spacing[1]),
        lower=bodies[0],
        upper=bodies[1],
        origin=(float(x[0]), float(y[0])),
        inclination=None if are_prisms(*bodies) else getattr(normal, "inclination", None),
    )


#: Unlikeness of two half-spaces from which on rolling of second order asks about it.
UNLIKE = 0.1
#: What it asks.
OF_UNLIKE = (
    "order is 2 and the bodies are unlike: the slip that their pressure causes leaves an error of first "
    "order in the size of the cells, up to four times that of order=1"
)

#: What to do where elastic bodies are to roll or to shift.
HALF_SPACES_MOVE = (
    'only half-spaces roll and shift. Solve the scene with model="half-space"; where a body is an '
    "ElasticBody, give its material in its place"
)


def _half_space(name: str, body: Any, *, is_in_rows: bool) -> Medium | None:
    """The material of a half-space; None of a rigid body; a layered or creeping body is what it is, and so is
    a prism under cells in rows along its surface."""
    if isinstance(body, Rigid):
        return None
    if isinstance(body, (Layered, Viscoelastic)):
        return body.kept()
    if is_in_rows and (prism := prism_of(body)) is not None:
        return prism
    material = body.material if getattr(body, "is_half_space", False) else body
    if material is not None and not isinstance(material, Material):
        raise ValueError(f"{name} is a {type(body).__name__}: {HALF_SPACES_MOVE}")
    return material
