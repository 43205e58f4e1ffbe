# SPDX-License-Identifier: MIT OR Apache-2.0
"""Fast approximations of creep forces: FASTSIM, FaStrip, Polach, Kalker's linear theory."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .. import _mtb_rs
from ..base.check import choice, number, pair, positive, reals
from ..base.owning import check_finite, solved
from ..base.plain import plain
from ..base.renamed import renamed
from ..base.stored import stored
from ..base.units import taking_quantities
from ..base.words import Bound, Flexible, StickDirection
from ..bodies.simple import Simple, not_prism
from ..friction.laws import Friction, as_law
from ..results.damage import Damaged, Rolled
from ..results.result import TangentialFields
from ..results.stressed import BELOW_INCLINED, Loads, Stressed, loaded_grid
from .foundation import Forces, Foundation, ellipses, local
from .pressure_field import creepage_rows, pressure_field

Array = NDArray[np.float64]


class KalkerCoefficients(NamedTuple):
    """Linear creep coefficients; see :func:`kalker_coefficients`."""

    C11: float
    C22: float
    C23: float
    C33: float


@taking_quantities
def kalker_coefficients(ratio: float, poisson_ratio: float) -> KalkerCoefficients:
    """Kalker's linear creep coefficients of an ellipse, interpolated in the published table [Kalker1990].

    ``Fx = a b G C11 xi``, ``Fy = a b G (C22 eta + sqrt(a b) C23 phi)``,
    ``Mz = a b G (-sqrt(a b) C23 eta + a b C33 phi)`` on the lower body, both bodies alike.

    Parameters
    ----------
    ratio : float [-]
        Semi-axis along the rolling direction over the one across it, 0.1 to 10.
    poisson_ratio : float [-]
        0 to 0.5.
    """
    axes, nu = positive("ratio", ratio), number("poisson_ratio", poisson_ratio)
    return KalkerCoefficients(*_mtb_rs.kalker_coefficients(axes, nu))


@stored
@solved
@dataclass(frozen=True, repr=False)
@plain
class FoundationResult(Stressed, Damaged, TangentialFields):
    """Fields of the simplified theory; vectors act on the lower body.

    Attributes
    ----------
    points : (2, ny, nx) [m]
        Cell centres.
    area : (ny, nx) [m2]
    pressure : (ny, nx) [Pa]
    traction : (3, ny, nx) [Pa]
    slip : (2, ny, nx) [-]
    status : (ny, nx) int
        0 open, 1 stick, 2 slip.
    force : (3,) [N]
        Friction (x, y) and minus the normal force (z).
    spin_moment : float [N m]
    creepage : (3,) or None [-, -, 1/m]
        Given, or found for a force; None of results that were stored by an earlier version.
    lower, upper : HalfSpace, Rigid or None
        None likewise.
    is_line : bool
        Whether it is a line contact.
    is_inclined : bool
        Whether the surface turns from row to row.
    inclination : (ny,) or None [rad]
        Of each row of cells; None on a plane, and of results that were stored by an earlier version.
    angle : float or None [rad]
        Direction of rolling, from +x towards +y; None of results that were stored by an earlier version.
    """

    points: Array
    area: Array
    pressure: Array
    traction: Array
    slip: Array
    status: NDArray[np.int8]
    force: Array
    spin_moment: float
    creepage: Array | None = None
    lower: Simple | None = None
    upper: Simple | None = None
    is_line: bool = False
    is_inclined: bool = False
    inclination: Array | None = None
    angle: float | None = None

    def _rolled(self) -> Rolled:
        if self.creepage is None:
            raise ValueError("this result was saved by an earlier version, which kept no creepage")
        return Rolled(self.force[:2], self.spin_moment, -float(self.force[2]), self.creepage, self.pressure)

    def _loads(self) -> Loads:
        if self.is_inclined:
            raise ValueError(BELOW_INCLINED)
        nx, (x, y) = self.pressure.shape[1], self.points
        # a single row or column has its width by the area, and a single cell is a square
        cell = float(self.area[0, 0])
        dx = float(x[0, 1] - x[0, 0]) if nx > 1 else cell**0.5
        dx = cell / float(y[1, 0] - y[0, 0]) if nx == 1 and len(y) > 1 else dx
        sides = (dx, cell / dx)
        grid = loaded_grid(self.points, sides, self.pressure, self.traction)
        return Loads((grid,), self.lower, self.upper, is_line=self.is_line, way=self.angle)


def _order(order: int) -> str:
    if isinstance(order, bool) or order not in (1, 2):
        raise ValueError(f"order is {order!r}: 1 (FASTSIM) or 2 (second order) is needed")
    return "fastsim" if order == 1 else "fastsim2"


def _strips(
    normal: Any,
    friction: Friction,
    flexibilities: Flexible,
    semi_axes: tuple[float, float] | None,
    slope_reduction: tuple[float, float, float] | None,
    stick_direction: StickDirection,
    angle: float,
) -> Foundation:
    """The foundation of FaStrip, whose friction knows no velocity."""
    choice("stick_direction", stick_direction, StickDirection)
    method = "fastrip" if stick_direction == "strip theory" else "fastrip of contact"
    return Foundation.of(
        normal, friction, "elliptic", flexibilities, method, 10.0, semi_axes, slope_reduction, angle
    )


def _result(foundation: Foundation, creepage: Any, force: Forces | None) -> FoundationResult:
    """The fields at a creepage, of which the components of given forces are found."""
    row = np.atleast_2d(reals("creepage", creepage))
    if row.shape != (1, 3):
        raise ValueError(f"creepage has shape {np.shape(creepage)}: (3,) is needed")
    if force is not None:
        row = foundation.driven(row[0], force, lambda rolled: _fields(foundation, rolled))
    return _fields(foundation, row)


def _fields(foundation: Foundation, row: Array) -> FoundationResult:
    field = foundation.field
    found = foundation.at(row)
    status = np.where(field.pressure > 0.0, np.where(found["slipping"], 2, 1), 0).astype(np.int8)
    fx, fy, moment = found["forces"][0]
    return FoundationResult(
        points=np.stack(np.meshgrid(*field.coordinates())),
        area=np.full(field.pressure.shape, field.spacing[0] * field.spacing[1]),
        pressure=field.pressure,
        traction=np.concatenate([found["traction"], np.zeros((1, *field.pressure.shape))]),
        slip=found["slip"],
        status=status,
        force=np.array([fx, fy, -field.normal_force]),
        spin_moment=float(moment),
        creepage=row[0].copy(),
        lower=not_prism(field.body("lower"), "a fast approximation"),
        upper=not_prism(field.body("upper"), "a fast approximation"),
        is_line=field.reference is not None,
        is_inclined=field.inclination is not None,
        inclination=field.inclination,
        angle=foundation.angle,
    )


def _curve(foundation: Foundation, creepages: ArrayLike) -> Array:
    forces: Array = foundation.at(creepage_rows(creepages))["forces"]
    check_finite("forces", forces)
    return forces


@taking_quantities
@renamed(speed="velocity")
def fastsim(
    normal: Any,
    creepage: tuple[float, float, float],
    friction: Friction,
    bound: Bound = "parabolic",
    flexibilities: Flexible = 3,
    order: int = 1,
    velocity: float = 10.0,
    semi_axes: tuple[float, float] | None = None,
    *,
    slope_reduction: tuple[float, float, float] | None = None,
    angle: float = 0.0,
    force: Forces | None = None,
) -> FoundationResult:
    """FASTSIM: the simplified theory of rolling contact [Kalker1982].

    Each of several separate contacts is solved by itself, with the ellipse of its own second moments and the
    creepages about its own centre of pressure. The elastic displacement of one contact by another is left
    out.

    Parameters
    ----------
    normal : NormalResult, Result or PressureField
        Any patch.
    creepage : (xi, eta, phi)
        Along x and along y, for any `angle`; phi in [1/m].
    friction : Friction
        Without memory.
    bound : {"parabolic", "elliptic"}
        Traction bound: mu times the pressure ("elliptic"), or mu times the square of the pressure, scaled to
        the same force ("parabolic", Kalker's choice, for its better stick area). The peak of the parabolic
        bound is 4/3 of mu times the pressure: use it for forces, and not for the distribution of the traction
        (wear, heat, fatigue).
    flexibilities : {3, 1, "blended"}
        One for each creepage, their weighted mean, or three that become one as the creepage grows. Of these
        the one is the reciprocal of the mean stiffness, weighted by the squares of the creepages (of
        3 pi a / 32 times the spin), and slip has the direction of the traction, as in CONTACT.
    order : {1, 2}
        Order of the integration along the rolling direction; 2 is that of FASTSIM2. With order 2 the error of
        the forces falls at second order with the elliptic bound only. With the parabolic bound it falls at
        first order, but is several times smaller. With order 1 the rigid slip is taken a sixth of a cell
        ahead, as in :func:`solve_tangential` and in CONTACT.
    velocity : float [m/s]
        Of rolling.
    semi_axes : (a, b) or None [m]
        Ellipse, along x and along y, whose linear theory determines the flexibilities, for a single contact;
        None takes the ellipse of equal second moments.
    slope_reduction : (k0, alpha, beta) or None [-]
        Makes the foundation softer by k = k0 (alpha + (1 - alpha) / (1 + beta e)), for wet and contaminated
        surfaces: the modified FASTSIM [SpiryaginPolachCole2013]. The gradient e is Polach's at a coefficient
        of friction of 1: half the shear modulus times C11 times the creepage, (xi, eta + phi a) or (xi, eta),
        the larger, over the peak of the bound.
    angle : float [rad]
        Direction of rolling from +x towards +y. Across the rows of cells each cell is the end of a strip of
        its own, and the pressure is interpolated along it.
    force : (Fx, Fy) or None [N]
        Total tangential force on the lower body. The creepage of a component with a given force is found;
        None is for a component whose creepage is given.

    Raises
    ------
    ValueError
        For bad input, and for a force of at least what the coefficient at rest carries.
    ConvergenceError
        If no creepage was found for the force; the last one is its ``result``.
    """
    foundation = Foundation.of(
        normal, friction, bound, flexibilities, _order(order), velocity, semi_axes, slope_reduction, angle
    )
    return _result(foundation, creepage, force)


@taking_quantities
@renamed(speed="velocity")
def fastsim_curve(
    normal: Any,
    creepages: ArrayLike,
    friction: Friction,
    bound: Bound = "parabolic",
    flexibilities: Flexible = 3,
    order: int = 1,
    velocity: float = 10.0,
    semi_axes: tuple[float, float] | None = None,
    *,
    slope_reduction: tuple[float, float, float] | None = None,
    angle: float = 0.0,
) -> Array:
    """Forces (n, 3) of :func:`fastsim` over creepages (n, 3): Fx, Fy [N], Mz [N m] on the lower body."""
    foundation = Foundation.of(
        normal, friction, bound, flexibilities, _order(order), velocity, semi_axes, slope_reduction, angle
    )
    return _curve(foundation, creepages)


@taking_quantities
def fastrip(
    normal: Any,
    creepage: tuple[float, float, float],
    friction: Friction,
    flexibilities: Flexible = "blended",
    semi_axes: tuple[float, float] | None = None,
    *,
    slope_reduction: tuple[float, float, float] | None = None,
    stick_direction: StickDirection = "strip theory",
    angle: float = 0.0,
    force: Forces | None = None,
) -> FoundationResult:
    """FaStrip: strip theory where the surfaces stick, the direction of FASTSIM where they slip.

    The traction is bounded by mu times the pressure [SichaniEnblomBerg2016]. Where the surfaces stick it is
    that of strip theory [Kalker1967], whose creepages are multiplied such that Kalker's linear forces come
    out. Spin beyond what strip theory can hold makes the whole contact slip.

    Parameters
    ----------
    normal : NormalResult, Result or PressureField
        Any patch; a strip is as long as its cells. The steepness of the pressure is that of the ellipse that
        has the area and the force of the patch.
    creepage : (xi, eta, phi)
        Along x and along y, for any `angle`; phi in [1/m].
    friction : Coulomb
        Its mean over each strip counts for what sticks.
    flexibilities : {"blended", 3, 1}
        Of FASTSIM, see :func:`fastsim`.
    semi_axes, slope_reduction, angle, force
        As in :func:`fastsim`. The slope is reduced where the surfaces slip only.
    stick_direction : {"strip theory", "CONTACT"}
        Direction of the traction at the edge of adhesion. "strip theory" makes all that sticks free of slip,
        and the traction is cut back to the bound. CONTACT (revision 2707) gives to the spin there
        1 / (1 - nu) of its weight, and lets the traction exceed the bound near the leading edge; without spin
        both have the same direction.

    Raises
    ------
    ValueError
        For bad input, for friction that depends on the slip, and for a force of at least what friction
        carries.
    ConvergenceError
        If no creepage was found for the force; the last one is its ``result``.
    """
    strips = _strips(normal, friction, flexibilities, semi_axes, slope_reduction, stick_direction, angle)
    return _result(strips, creepage, force)


@taking_quantities
def fastrip_curve(
    normal: Any,
    creepages: ArrayLike,
    friction: Friction,
    flexibilities: Flexible = "blended",
    semi_axes: tuple[float, float] | None = None,
    *,
    slope_reduction: tuple[float, float, float] | None = None,
    stick_direction: StickDirection = "strip theory",
    angle: float = 0.0,
) -> Array:
    """Forces (n, 3) of :func:`fastrip` over creepages (n, 3): Fx, Fy [N], Mz [N m] on the lower body."""
    strips = _strips(normal, friction, flexibilities, semi_axes, slope_reduction, stick_direction, angle)
    return _curve(strips, creepages)


@taking_quantities
@renamed(speed="velocity")
def polach(
    normal: Any,
    creepage: ArrayLike,
    friction: Friction,
    reduction: tuple[float, float] = (1.0, 1.0),
    velocity: float = 10.0,
    semi_axes: tuple[float, float] | None = None,
) -> Array:
    """Polach's closed-form creep force [Polach1999], with reduction factors [Polach2005].

    The forces of separate contacts are added, each with its own ellipse and the creepages about its own
    centre.

    Parameters
    ----------
    normal : NormalResult, Result or PressureField
    creepage : (3,) or (n, 3)
        (xi, eta, phi) [-, -, 1/m].
    friction : Friction
        Friction law, evaluated at the slip speed of the rigid bodies, `velocity` times the magnitude of (xi,
        eta) at the centre. Of a coefficient that varies over the patch the mean is taken, weighted by the
        pressure.
    reduction : (k_A, k_S)
        Reduction factors of the stiffness where the surfaces stick and where they slip.
    velocity : float [m/s]
        Of rolling.
    semi_axes : (a, b) or None [m]
        None takes the ellipse with the second moments of the pressure, one for each contact.

    Returns
    -------
    (3,) or (n, 3) float [N], [N m]
        Fx, Fy and Mz on the lower body, the moment about the origin. The formula has no moment of spin:
        forces act at the centre of their ellipse, so that Mz is zero for one contact about its own centre.
    """
    field = pressure_field(normal)
    rows = creepage_rows(creepage)
    positive("velocity", velocity, "m/s")
    reductions = pair("reduction", reduction)
    law = as_law(friction)
    modulus, ratio = field.pair_modulus()
    forces = np.zeros((len(rows), 3))
    for part, cut, axes, centre in ellipses(field, semi_axes, "Polach's formula"):
        rows_there = local(rows, centre)
        slip_speed = velocity * np.hypot(rows_there[:, 0], rows_there[:, 1])
        mu = law.of_sliding(slip_speed, part.pressure, field.pressure.shape, cut)
        force = _mtb_rs.polach_curve(
            axes, modulus, ratio, part.normal_force, rows_there, np.ascontiguousarray(mu), reductions
        )
        forces[:, :2] += force
        forces[:, 2] += centre[0] * force[:, 1] - centre[1] * force[:, 0]
    check_finite("forces", forces)
    return forces if np.ndim(creepage) == 2 else forces[0]
