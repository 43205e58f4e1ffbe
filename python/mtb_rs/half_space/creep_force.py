# SPDX-License-Identifier: MIT OR Apache-2.0
"""Fast approximations of creep forces: FASTSIM, Polach, Kalker's linear theory."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .. import _mtb_rs
from ..base.check import choice, number, pair, positive
from ..base.owning import check_finite, solved
from ..base.plain import plain
from ..base.renamed import renamed
from ..base.stored import stored
from ..base.units import taking_quantities
from ..base.words import Bound
from ..friction.laws import Friction, as_law
from ..results.result import TangentialFields
from .pressure_field import PressureField, creepage_rows, pressure_field

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
class FoundationResult(TangentialFields):
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
    """

    points: Array
    area: Array
    pressure: Array
    traction: Array
    slip: Array
    status: NDArray[np.int8]
    force: Array
    spin_moment: float


def _bound(field: PressureField, bound: Bound) -> Array:
    if bound == "elliptic":
        return field.pressure
    # the square of an ellipse is a parabola; scaled to the same force, on any patch
    square = field.pressure**2
    return np.ascontiguousarray(square * (field.pressure.sum() / square.sum()))


class _Ellipse(NamedTuple):
    """One contact as the approximations see it."""

    field: PressureField
    cut: tuple[slice, slice]
    semi_axes: tuple[float, float]
    centre: tuple[float, float]


def _ellipses(field: PressureField, semi_axes: tuple[float, float] | None, method: str) -> list[_Ellipse]:
    """Each separate contact with the ellipse of its own second moments, or the one given."""
    if field.reference is not None:
        raise ValueError(f"pressure is a line contact: {method} needs a patch, solve_tangential takes both")
    if not np.any(field.pressure > 0.0):
        raise ValueError("the pressure is zero everywhere: there is no contact to roll")
    parts = field.patches()
    if semi_axes is None:
        return [_Ellipse(part, cut, part.semi_axes(), part.centre()) for cut, part in parts]
    a, b = pair("semi_axes", semi_axes, "m")
    axes = positive("semi_axes[0]", a, "m"), positive("semi_axes[1]", b, "m")
    if len(parts) > 1:
        raise ValueError(
            f"semi_axes is {semi_axes!r}, one ellipse, and the pressure has {len(parts)} separate contacts: "
            "None is needed, which gives each its own"
        )
    cut, part = parts[0]
    return [_Ellipse(part, cut, axes, part.centre())]


def _local(rows: Array, centre: tuple[float, float]) -> Array:
    """Creepages about `centre`: spin about the origin moves it, by (-phi y, phi x)."""
    x, y = centre
    return np.ascontiguousarray(rows + rows[:, 2:] * np.array([-y, x, 0.0]))


def _fastsim(
    normal: Any,
    creepages: ArrayLike,
    friction: Friction,
    bound: Bound,
    flexibilities: int,
    order: int,
    velocity: float,
    semi_axes: tuple[float, float] | None,
) -> tuple[PressureField, dict[str, Array]]:
    """Forces (n, 3) over the creepages, and the fields at the last one."""
    rows = creepage_rows(creepages)
    choice("bound", bound, Bound)
    if isinstance(flexibilities, bool) or flexibilities not in (1, 3):
        raise ValueError(f"flexibilities is {flexibilities!r}: 1 or 3 is needed")
    if isinstance(order, bool) or order not in (1, 2):
        raise ValueError(f"order is {order!r}: 1 (FASTSIM) or 2 (second order) is needed")
    positive("velocity", velocity, "m/s")
    field = pressure_field(normal)
    shape = field.pressure.shape
    law = as_law(friction)
    modulus, ratio = field.pair_modulus()
    whole = {
        "forces": np.zeros((len(rows), 3)),
        "traction": np.zeros((2, *shape)),
        "slip": np.zeros((2, *shape)),
        "slipping": np.zeros(shape, dtype=bool),
    }
    for part, cut, axes, centre in _ellipses(field, semi_axes, "FASTSIM"):
        x, y = centre
        found = _mtb_rs.fastsim_curve(
            _bound(part, bound),
            part.spacing,
            (part.start[0] - x, part.start[1] - y),
            axes,
            modulus,
            ratio,
            _local(rows, centre),
            float(velocity),
            law.native(shape, cut),
            flexibilities == 1,
            order == 2,
        )
        forces = found.forces
        whole["forces"] += forces
        whole["forces"][:, 2] += x * forces[:, 1] - y * forces[:, 0]
        # rectangles of separate contacts may overlap, their cells do not
        whole["traction"][(..., *cut)] += found.traction
        whole["slip"][(..., *cut)] += found.slip
        whole["slipping"][cut] |= found.slipping
    return field, whole


@taking_quantities
@renamed(speed="velocity")
def fastsim(
    normal: Any,
    creepage: tuple[float, float, float],
    friction: Friction,
    bound: Bound = "parabolic",
    flexibilities: int = 3,
    order: int = 1,
    velocity: float = 10.0,
    semi_axes: tuple[float, float] | None = None,
) -> FoundationResult:
    """FASTSIM: the simplified theory of rolling contact [Kalker1982].

    Each of several separate contacts is solved by itself, with the ellipse of its own second moments and the
    creepages about its own centre of pressure. The elastic displacement of one contact by another is left
    out.

    Parameters
    ----------
    normal : NormalResult, Result or PressureField
        Any patch; rolling towards +x.
    creepage : (xi, eta, phi)
        Phi in [1/m].
    friction : Friction
        Without memory.
    bound : {"parabolic", "elliptic"}
        Traction bound: mu times the pressure ("elliptic"), or mu times the square of the pressure, scaled to
        the same force ("parabolic", Kalker's choice, for its better stick area). The peak of the parabolic
        bound is 4/3 of mu times the pressure: use it for forces, and not for the distribution of the traction
        (wear, heat, fatigue).
    flexibilities : {1, 3}
        One for each creepage, or their weighted mean.
    order : {1, 2}
        Order of the integration along the rolling direction; 2 is that of FASTSIM2. With order 2 the error of
        the forces falls at second order with the elliptic bound only. With the parabolic bound it falls at
        first order, but is several times smaller.
    velocity : float [m/s]
        Of rolling.
    semi_axes : (a, b) or None [m]
        Ellipse whose linear theory determines the flexibilities, for a single contact; None takes the ellipse
        of equal second moments.
    """
    field, found = _fastsim(normal, creepage, friction, bound, flexibilities, order, velocity, semi_axes)
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
    )


@taking_quantities
@renamed(speed="velocity")
def fastsim_curve(
    normal: Any,
    creepages: ArrayLike,
    friction: Friction,
    bound: Bound = "parabolic",
    flexibilities: int = 3,
    order: int = 1,
    velocity: float = 10.0,
    semi_axes: tuple[float, float] | None = None,
) -> Array:
    """Forces (n, 3) of :func:`fastsim` over creepages (n, 3): Fx, Fy [N], Mz [N m] on the lower body."""
    _, found = _fastsim(
        normal, creepage_rows(creepages), friction, bound, flexibilities, order, velocity, semi_axes
    )
    forces: Array = found["forces"]
    check_finite("forces", forces)
    return forces


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
    for part, cut, axes, centre in _ellipses(field, semi_axes, "Polach's formula"):
        local = _local(rows, centre)
        slip_speed = velocity * np.hypot(local[:, 0], local[:, 1])
        mu = law.of_sliding(slip_speed, part.pressure, field.pressure.shape, cut)
        force = _mtb_rs.polach_curve(
            axes, modulus, ratio, part.normal_force, local, np.ascontiguousarray(mu), reductions
        )
        forces[:, :2] += force
        forces[:, 2] += centre[0] * force[:, 1] - centre[1] * force[:, 0]
    check_finite("forces", forces)
    return forces if np.ndim(creepage) == 2 else forces[0]
