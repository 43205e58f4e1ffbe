# SPDX-License-Identifier: MIT OR Apache-2.0
"""The elastic foundation under a rolling contact: what FASTSIM and FaStrip have in common."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from .. import _mtb_rs
from ..base.check import choice, number, pair, positive
from ..base.errors import ConvergenceError
from ..base.questions import ask
from ..base.words import Bound
from ..friction.laws import Friction, as_law
from .pressure_field import PressureField, pressure_field

#: Correlation of the second moments along and across the rolling direction from which forces are off by more
#: than 2 %.
TURNED = 0.2
#: Unlikeness of bodies from which the slip by the pressure is asked about.
UNLIKE = 0.1
#: Angle [rad] by which a surface turns over a contact from which it is asked about: forces are 1 % off.
INCLINED = 0.2
#: How many times the semi-axes that are given may differ from those of the contact.
FAR = 10.0

Array = NDArray[np.float64]
Forces = tuple[float | None, float | None]

#: Error of a force that was given, over the normal force, at which its creepage counts as found.
_BALANCED = 1e-9
_STEPS = 60
#: Change of a creepage for a difference, over the creepage that linear theory gives to the friction force.
_CHANGE = 1e-6


class Ellipse(NamedTuple):
    """One contact as the approximations see it."""

    field: PressureField
    cut: tuple[slice, slice]
    semi_axes: tuple[float, float]
    centre: tuple[float, float]


def ellipses(
    field: PressureField, semi_axes: tuple[float, float] | None, method: str, angle: float = 0.0
) -> list[Ellipse]:
    """Each separate contact with the ellipse of its own second moments, or the one given; asks where that is
    none of the contact along the direction of rolling."""
    if field.reference is not None:
        raise ValueError(f"pressure is a line contact: {method} needs a patch, solve_tangential takes both")
    if not np.any(field.pressure > 0.0):
        raise ValueError("the pressure is zero everywhere: there is no contact to roll")
    parts = field.patches()
    fields = [part for _, part in parts]
    if semi_axes is None:
        ask(_doubts(field, fields, None, method, angle))
        return [Ellipse(part, cut, part.semi_axes(), part.centre()) for cut, part in parts]
    a, b = pair("semi_axes", semi_axes, "m")
    axes = positive("semi_axes[0]", a, "m"), positive("semi_axes[1]", b, "m")
    if len(parts) > 1:
        raise ValueError(
            f"semi_axes is {semi_axes!r}, one ellipse, and the pressure has {len(parts)} separate contacts: "
            "None is needed, which gives each its own"
        )
    ask(_doubts(field, fields, axes, method, angle))
    cut, part = parts[0]
    return [Ellipse(part, cut, axes, part.centre())]


def _doubts(
    field: PressureField,
    parts: list[PressureField],
    semi_axes: tuple[float, float] | None,
    method: str,
    angle: float,
) -> list[str]:
    """Questions about what an ellipse along the direction of rolling, between like bodies, leaves out."""
    questions = []
    if field.unlikeness() > UNLIKE:
        questions.append(
            f"the bodies are unlike, and {method} takes like ones that are as flexible: what their pressure "
            "slips is left out, by which even the sign of a small force may differ; solve_tangential has it"
        )
    loaded = np.asarray(field.pressure > 0.0).any(axis=1)
    turns = 0.0
    if field.inclination is not None and loaded.any():
        turns = float(np.ptp(field.inclination[loaded]))
    if turns > INCLINED:
        questions.append(
            f"the surface turns by {np.degrees(turns):.3g}\N{DEGREE SIGN} over the contact (inclination), "
            f"and {method} takes a plane: forces are off by tens of per cent on the gauge corner of a rail; "
            "solve_tangential has it"
        )
    turned = [part.correlation(angle) for part in parts] if semi_axes is None else []
    worst = max(turned, key=abs, default=0.0)
    if abs(worst) > TURNED:
        questions.append(
            f"a contact lies oblique to the direction of rolling (its moments across and along correlate by "
            f"{worst:.2g}), and {method} takes an ellipse along it, which is wider: forces are off by "
            f"{'tens of' if abs(worst) > 2.0 * TURNED else 'some'} per cent; solve_tangential takes any shape"
        )
    if semi_axes is not None:
        largest = max(max(part.semi_axes()) for part in parts)
        given = max(semi_axes)
        if not largest / FAR < given < largest * FAR:
            questions.append(
                f"semi_axes is {semi_axes!r} m, and the contact has semi-axes of about {largest:.2g} m: "
                "lengths are in metres"
            )
    return questions


def local(rows: Array, centre: tuple[float, float]) -> Array:
    """Creepages about `centre`: spin about the origin moves it, by (-phi y, phi x)."""
    x, y = centre
    return np.ascontiguousarray(rows + rows[:, 2:] * np.array([-y, x, 0.0]))


def bound_of(field: PressureField, bound: Bound) -> Array:
    """The traction bound (ny, nx) [Pa] for a coefficient of friction of 1."""
    if bound == "elliptic":
        return field.pressure
    # the square of an ellipse is a parabola; scaled to the same force, on any patch
    square = field.pressure**2
    return np.ascontiguousarray(square * (field.pressure.sum() / square.sum()))


def _along(axes: tuple[float, float], angle: float) -> tuple[float, float]:
    """Semi-axes along and across a direction, of the ellipse with the second moments of one along x and y."""
    (a, b), c, s = axes, math.cos(angle), math.sin(angle)
    return math.hypot(a * c, b * s), math.hypot(a * s, b * c)


@dataclass(frozen=True)
class Foundation:
    """What rolls: everything but the creepages."""

    field: PressureField
    law: Friction
    bound: Bound
    flexibilities: str
    method: str
    velocity: float
    semi_axes: tuple[float, float] | None
    slope_reduction: tuple[float, float, float] | None
    angle: float

    @classmethod
    def of(
        cls,
        normal: Any,
        friction: Friction,
        bound: Bound,
        flexibilities: Any,
        method: str,
        velocity: float,
        semi_axes: tuple[float, float] | None,
        slope_reduction: Any,
        angle: float,
    ) -> Foundation:
        """From the arguments of `fastsim` and `fastrip`, checked."""
        choice("bound", bound, Bound)
        words = {3: "three", 1: "one", "blended": "blended"}
        if isinstance(flexibilities, bool) or flexibilities not in words:
            raise ValueError(f"flexibilities is {flexibilities!r}: 3, 1 or 'blended' is needed")
        positive("velocity", velocity, "m/s")
        number("angle", angle, "rad")
        law = as_law(friction)
        if method.startswith("fastrip") and not law.is_constant:
            raise ValueError(
                f"friction is {friction!r}: FaStrip takes Coulomb's friction only; fastsim takes laws that "
                "depend on the slip"
            )
        reduction = None
        if slope_reduction is not None:
            try:
                k0, alpha, beta = slope_reduction
            except (TypeError, ValueError):
                raise ValueError(
                    f"slope_reduction is {slope_reduction!r}: three numbers (k0, alpha, beta) are needed"
                ) from None
            reduction = (
                positive("slope_reduction[0]", k0),
                positive("slope_reduction[1]", alpha),
                number("slope_reduction[2]", beta),
            )
        field = pressure_field(normal)
        return cls(
            field,
            law,
            bound,
            words[flexibilities],
            method,
            float(velocity),
            semi_axes,
            reduction,
            float(angle),
        )

    def at(self, rows: Array) -> dict[str, Array]:
        """Forces (n, 3) over the creepages, and the fields at the last one."""
        field, law = self.field, self.law
        shape = field.pressure.shape
        modulus, ratio = field.pair_modulus()
        whole = {
            "forces": np.zeros((len(rows), 3)),
            "traction": np.zeros((2, *shape)),
            "slip": np.zeros((2, *shape)),
            "slipping": np.zeros(shape, dtype=bool),
        }
        name = "FaStrip" if self.method.startswith("fastrip") else "FASTSIM"
        for part, cut, axes, centre in ellipses(field, self.semi_axes, name, self.angle):
            x, y = centre
            along, across = _along(axes, self.angle)
            mean = float(law.of_sliding(np.zeros(1), part.pressure, shape, cut)[0])
            found = _mtb_rs.fastsim_curve(
                bound_of(part, self.bound),
                part.spacing,
                (part.start[0] - x, part.start[1] - y),
                self.angle,
                (along, across),
                modulus,
                ratio,
                local(rows, centre),
                self.velocity,
                law.native(shape, cut),
                self.flexibilities,
                mean * part.normal_force,
                self.method,
                self._slope(part, along / across),
            )
            forces = found.forces
            whole["forces"] += forces
            whole["forces"][:, 2] += x * forces[:, 1] - y * forces[:, 0]
            # rectangles of separate contacts may overlap, their cells do not
            whole["traction"][(..., *cut)] += found.traction
            whole["slip"][(..., *cut)] += found.slip
            whole["slipping"][cut] |= found.slipping
        return whole

    def _slope(
        self, part: PressureField, ratio: float
    ) -> tuple[tuple[float, float, float], float, float] | None:
        """The reduction of the slope with the peak of the bound and the semi-axis along rolling,
        of the ellipse that has the area of the patch."""
        if self.slope_reduction is None:
            return None
        area = np.count_nonzero(part.pressure) * part.spacing[0] * part.spacing[1]
        peak = (2.0 if self.bound == "parabolic" else 1.5) * part.normal_force / area
        return self.slope_reduction, peak, math.sqrt(area / math.pi * ratio)

    def driven(self, creepage: Array, force: Forces, solved: Callable[[Array], Any]) -> Array:
        """The creepage (1, 3) at which given components of the force are carried.

        `solved` makes a result of a creepage that is the last one of a search in vain.
        """
        if not isinstance(force, (tuple, list, np.ndarray)) or len(force) != 2:
            raise ValueError(f"force is {force!r}: (Fx, Fy) [N] is needed, None for a given component")
        given = [k for k, value in enumerate(force) if value is not None]
        wanted = np.array([number(f"force[{k}]", force[k], "N") for k in given])
        load = self.field.normal_force
        carried = self.law.at_rest() * load
        size = float(np.linalg.norm(wanted))
        if given and size >= carried:
            raise ValueError(
                f"a tangential force of {size:g} N is prescribed, friction carries less than {carried:g} N"
            )
        row = np.array(creepage, dtype=float)
        row[given] = 0.0
        if not given:
            return row[None]
        # the creepage that would take the whole friction force if nothing slipped
        modulus, _ = self.field.pair_modulus()
        unit = carried / (modulus * np.count_nonzero(self.field.pressure) * math.prod(self.field.spacing))

        def forces(rows: Array) -> Array:
            return np.asarray(self.at(rows)["forces"][:, given])

        missing = wanted - forces(row[None])[0]
        for _ in range(_STEPS):
            if np.abs(missing).max() <= _BALANCED * load:
                return row[None]
            moved = np.repeat(row[None], 2 * len(given), axis=0)
            for n, k in enumerate(given):
                moved[2 * n, k] += _CHANGE * unit
                moved[2 * n + 1, k] -= _CHANGE * unit
            found = forces(moved)
            slopes = (found[::2] - found[1::2]).T / (2.0 * _CHANGE * unit)
            # where all slips along one direction, the force does not follow the creepage
            slopes += np.eye(len(given)) * 1e-12 * carried / unit
            change = np.linalg.solve(slopes, missing)
            for share in 0.5 ** np.arange(30):
                ahead = row.copy()
                ahead[given] += share * change
                left = wanted - forces(ahead[None])[0]
                if np.linalg.norm(left) < np.linalg.norm(missing):
                    break
            else:
                break
            row, missing = ahead, left
        if np.abs(missing).max() <= 1e3 * _BALANCED * load:
            return row[None]
        raise ConvergenceError(
            f"no creepage was found at which the force is {tuple(force)!r} N: "
            f"{np.abs(missing).max():.3g} N are missing; with this spin, or this other creepage, friction "
            "may carry less",
            solved(row[None]),
        )
