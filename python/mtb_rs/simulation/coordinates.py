# SPDX-License-Identifier: MIT OR Apache-2.0
"""What moves on a contact: components of a pose on springs, rigid motions and vibrations of bodies."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..base.check import is_quantity, number, reals
from ..base.plain import plain
from ..base.units import in_si
from ..contact.problem import ContactProblem
from .reduced import ReducedBody

Array = NDArray[np.float64]

#: Components of a pose, in order.
POSE = ("x", "y", "z", "roll", "pitch", "yaw")
#: Bodies, and the sign with which their displacement along both tangents and into the body counts.
SIGNS = {"upper": (-1.0, -1.0, 1.0), "lower": (1.0, 1.0, 1.0)}

#: Units of a matrix between two displacements, a displacement and a rotation, and two rotations.
OF_PAIRS = {
    "mass": ("kg", "kg m", "kg m^2"),
    "stiffness": ("N/m", "N", "N m"),
    "damping": ("N s/m", "N s", "N m s"),
}
#: Units of a displacement, a rotation, and a vibration or rigid motion of a body.
OF_COORDINATES = {
    "rate": ("m/s", "rad/s", "kg^0.5 m/s"),
    "load": ("N", "N m", "kg^0.5 m/s^2"),
}

#: Share of a displacement below which a rest of it is rounding.
SAME = 1e-9


class Places(Protocol):
    """Contact points and the point that a body turns about, as of :class:`mtb_rs.PreparedContact`."""

    @property
    def points(self) -> Array: ...
    @property
    def normal(self) -> Array: ...
    @property
    def reference_point(self) -> Array: ...
    @property
    def tangents(self) -> Array: ...


@dataclass(frozen=True)
@plain
class Coordinates:
    """Linear equations of motion of what moves on a contact, without the contact.

    Attributes
    ----------
    names : tuple of str
        Of the k coordinates.
    mass, damping, stiffness : (k, k)
    shapes : (3 n, k)
        Displacement of the contact points by a unit of each: of the lower body less the upper one along both
        tangents, then the opening.
    """

    names: tuple[str, ...]
    mass: Array
    damping: Array
    stiffness: Array
    shapes: Array


def in_units_of(name: str, given: Any, coordinates: Sequence[str]) -> Any:
    """Numbers over coordinates, (k,) or (k, k), with the quantities among them in the unit of each."""
    if is_quantity(given) and np.ndim(given) > 0:
        given = list(given)
    if is_quantity(given):
        # one number for all is none for displacements and rotations
        numbers = [in_si(name, given, _unit_of(name, c)) for c in coordinates]
        return numbers[0]
    if not isinstance(given, (list, tuple)) or len(given) != len(coordinates):
        return given
    rows = [list(row) if is_quantity(row) and np.ndim(row) == 1 else row for row in given]
    taken: list[Any] = []
    for i, (own, row) in enumerate(zip(coordinates, rows, strict=True)):
        if isinstance(row, (list, tuple)) and len(row) == len(coordinates):
            each = zip(row, coordinates, strict=True)
            entries = (in_si(f"{name}[{i}][{j}]", q, _unit_of(name, own, c)) for j, (q, c) in enumerate(each))
            taken.append(list(entries))
        else:
            taken.append(in_si(f"{name}[{i}]", row, _unit_of(name, own)))
    return taken


def _unit_of(name: str, own: str, other: str | None = None) -> str:
    """The unit of an entry of such numbers: of a coordinate, or of two in a matrix."""
    if name not in OF_PAIRS:
        return OF_COORDINATES[name][0 if own in POSE[:3] else 1 if own in POSE else 2]
    return OF_PAIRS[name][sum(c in POSE[3:] for c in (own, own if other is None else other))]


def matrix_of(name: str, given: ArrayLike, free: Sequence[str], *, least: bool = False) -> Array:
    """A symmetric matrix (m, m) over the free components, from numbers (m,) for its diagonal, or itself.

    `least`: all of its eigenvalues are positive.
    """
    given = in_units_of(name, given, free)
    values, m = reals(name, given), len(free)
    if values.shape == () and (m == 1 or not values.any()):
        values = np.full(m, float(values))
    if values.shape == (m,):
        values = np.diag(values)
    if values.shape != (m, m):
        raise ValueError(
            f"{name} has shape {values.shape}: ({m},) or ({m}, {m}), for {', '.join(free)}, is needed"
        )
    if least:
        if not np.allclose(values, values.T, rtol=1e-9, atol=0.0):
            raise ValueError(f"{name} is not symmetric")
        if least_of(values) <= 0.0:
            raise ValueError(
                f"{name} is {np.asarray(given).tolist()}: a mass > 0 is needed for each free component"
            )
    return values


def least_of(matrix: Array) -> float:
    """The least eigenvalue of a symmetric matrix whose diagonal is scaled to one."""
    size = 1.0 / np.sqrt(np.where(np.diag(matrix) > 0.0, np.diag(matrix), 1.0))
    return float(np.linalg.eigvalsh(size[:, None] * matrix * size).min())


def free_of(given: Sequence[str]) -> list[str]:
    """Names of components of a pose that are free; ValueError if they are others, or none."""
    try:
        names = list(given)
    except TypeError:
        names = []
    if not names or not all(names.count(name) == 1 and name in POSE for name in names):
        raise ValueError(f"free is {given!r}: different components of {', '.join(POSE)} are needed")
    return names


def moved_by_pose(contact: Places, free: Sequence[str]) -> Array:
    """Displacement (3 n, m) of the contact points, as `Coordinates.shapes`, by components of the pose."""
    arms = contact.points - contact.reference_point[:, None]
    columns = []
    for name in free:
        k = POSE.index(name)
        axis = np.eye(3)[k % 3][:, None]
        moved = np.broadcast_to(axis, arms.shape) if k < 3 else np.cross(axis, arms, axis=0)
        along = -np.einsum("kcn,cn->kn", contact.tangents, moved)
        columns.append(np.concatenate([along.ravel(), (contact.normal * moved).sum(axis=0)]))
    return np.array(columns).T.reshape(3 * arms.shape[1], len(free))


def motion_of(contact: Places, shapes: Array, amplitudes: Array, named: Sequence[str]) -> Array:
    """The motion (6,) about the reference point by amplitudes (m,), of several bodies the nearest one.

    Parameters
    ----------
    contact : Places
    shapes : (m, 3, n)
        Displacement of the contact points by a unit of each motion, as `Coordinates.shapes`.
    amplitudes : (m,)
        NaN of motions that do not count.
    named : sequence of str
        Components of the pose that are found; others only move if these alone do not tell the motion.
    """
    counted = ~np.isnan(amplitudes)
    moved = np.tensordot(amplitudes[counted], shapes[counted], 1)
    points = shapes[counted].any(axis=(0, 1))
    wanted, found = moved[:, points].ravel(), np.zeros(len(POSE))
    by_pose = moved_by_pose(contact, POSE).reshape(3, -1, len(POSE))[:, points].reshape(-1, len(POSE))
    own = [k for k, name in enumerate(POSE) if name in named]
    # on a flat contact, or a single row of points, some components do the same
    for columns in (own, list(range(len(POSE)))):
        found[columns] += np.linalg.lstsq(by_pose[:, columns], wanted - by_pose @ found)[0]
        if np.abs(wanted - by_pose @ found).max() <= SAME * np.abs(wanted).max():
            break
    return found


def coordinates_of(
    contact: Places,
    free: Sequence[str],
    mass: ArrayLike,
    stiffness: ArrayLike,
    damping: ArrayLike,
    bodies: Mapping[str, ReducedBody],
) -> Coordinates:
    """Components of the pose with what holds them, and the vibrations of bodies.

    With free components, elastic bodies have no further rigid motions; without any, bodies have those that
    their supports leave.
    """
    names, n = list(free), contact.points.shape[1]
    m = len(names)
    shapes, squares, shares = [moved_by_pose(contact, names)], [], []
    for which, body in bodies.items():
        sign = np.array(SIGNS[which])[:, None]
        kept = body.shapes if m else np.concatenate([body.rigid, body.shapes])
        count = len(kept) - body.frequency.size
        names += [f"{which} rigid {k}" for k in range(count)]
        names += [f"{which} vibration {k}" for k in range(body.frequency.size)]
        shapes.append((sign * kept).reshape(len(kept), 3 * n).T)
        squares.append(np.concatenate([np.zeros(count), (2.0 * np.pi * body.frequency) ** 2]))
        if m:
            # a lower body rests in its supports while the upper one moves
            shares.append(_participation(body, contact, free) * (1.0 if which == "upper" else 0.0))
    if not names:
        raise ValueError(
            "nothing moves: mass with the components that are free, or the density of an elastic body, is "
            "needed"
        )
    own = matrix_of("mass", mass, free, least=True) if m else np.zeros((0, 0))
    if m and "upper" in bodies:
        for k, name in enumerate(names[:m]):
            if name in POSE[:3] and own[k, k] < (1.0 - SAME) * bodies["upper"].mass:
                raise ValueError(
                    f"mass along {name} is {own[k, k]:g} kg, and the body alone has "
                    f"{bodies['upper'].mass:.4g} kg: mass is that of all that moves, the body included"
                )
    whole, held, slowed = (np.zeros((len(names), len(names))) for _ in range(3))
    whole[:m, :m] = own
    whole[m:, m:] = np.eye(len(names) - m)
    if shares:
        whole[:m, m:] = np.concatenate(shares, axis=1)
        whole[m:, :m] = whole[:m, m:].T
        if least_of(whole) <= 0.0:
            raise ValueError(
                f"mass is {np.asarray(mass).tolist()}, but the vibrations of the body alone carry more than "
                "that: mass is that of all that moves, the body included"
            )
    if m:
        held[:m, :m] = matrix_of("stiffness", stiffness, free)
        slowed[:m, :m] = matrix_of("damping", damping, free)
    held[m:, m:] = np.diag(np.concatenate([*squares, np.zeros(0)]))
    return Coordinates(tuple(names), whole, slowed, held, np.concatenate(shapes, axis=1))


def _participation(body: ReducedBody, contact: Places, free: Sequence[str]) -> Array:
    """Inertia (m, k) between components of the pose and vibrations of a body."""
    about = body.participation.copy()
    about[:, 3:] -= np.cross(contact.reference_point, about[:, :3])
    return np.asarray(about[:, [POSE.index(name) for name in free]].T)


def without_inertia(problem: ContactProblem, layer: float, bodies: Mapping[str, ReducedBody]) -> Array:
    """Compliance (3 n, 3 n) [m/Pa] of the pair, less what vibrations of bodies carry.

    Parameters
    ----------
    problem : ContactProblem
    layer : float [m/Pa]
        That softens the tangents.
    bodies : Mapping
        By "upper" and "lower".
    """
    n = problem.n
    found = blocks(problem.core.pair)
    found[np.arange(2 * n), np.arange(2 * n)] += layer
    for which, body in bodies.items():
        side = problem.upper if which == "upper" else problem.lower
        sign = np.repeat(SIGNS[which], n)
        change = body.residual * np.tile(problem.area, 3) - blocks(side.compliance)
        found += sign[:, None] * change * sign
    return found


def blocks(compliance: Any) -> Array:
    """All nine blocks (3 n, 3 n) [m/Pa] of a compliance."""
    return np.block([[compliance.influence(i, j) for j in "xyn"] for i in "xyn"])


def along_x_and_y(name: str, given: Any, unit: str, forwards: Sequence[float]) -> tuple[float, float]:
    """Components along x and y; a number is along the direction `forwards`."""
    if np.ndim(given) == 0:
        size = number(name, given, unit)
        return size * forwards[0], size * forwards[1]
    if np.shape(given) != (2,):
        part = {"shift": "d"}.get(name, name[0])
        raise ValueError(f"{name} is {given!r}: a number or ({part}x, {part}y) [{unit}] is needed")
    x, y = given
    return number(f"{name}[0]", x, unit), number(f"{name}[1]", y, unit)
