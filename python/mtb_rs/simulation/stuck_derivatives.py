# SPDX-License-Identifier: MIT OR Apache-2.0
"""Derivatives of steps in which points stick or slip, by all that they were given and by the step before."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from .. import _mtb_rs
from ..contact.tangent import Change, Points, in_rows
from ..results.derivatives import PULLS, Functional, Gradient, Margin
from .step_derivatives import MATERIALS, Shared

Array = NDArray[np.float64]
Shape = tuple[int, ...]

#: Places of what a step was given among the inputs of the core.
_POSE, _SHIFT, _VELOCITY, _PULL = slice(0, 6), slice(6, 8), slice(8, 10), slice(10, 11)


@dataclass(frozen=True)
class StuckDerived:
    """Where the derivatives of a step with a shift come from.

    Attributes
    ----------
    shared : Shared
        With all steps of the contact.
    linear : StickSlip
        Of the core: the equations of the step.
    unknowns : (3, n) [Pa]
        Tractions along both tangents and pressures.
    gap : (n,) [m]
    slip : (2, n) [m]
        Along both tangents.
    friction : (n,)
    status : (n,)
    duration : float or None [s]
        Of the step.
    follows_shift : bool
        Whether the velocity is the shift over the duration.
    by_layer : (shape, callable) or None
        As of :class:`StepDerived`.
    flexible : tuple of str
        Inputs by which each point gives way to its own pressure.
    magnet_numbers : Mapping of name to (..., 10), or None
        As of :class:`StepDerived`.
    by_moduli : Mapping of name to callable
        Displacement (3, n) `u_upper - u_lower` [m] by a unit of each modulus of a body under tractions and
        pressures (3, n) [Pa], and under the pull of the step or under none.
    without_moduli : Mapping of name to str, or None
        As of :class:`StepDerived`.
    """

    shared: Shared
    linear: _mtb_rs.StickSlip
    unknowns: Array
    gap: Array
    slip: Array
    friction: Array
    status: NDArray[np.int8]
    duration: float | None
    follows_shift: bool
    by_layer: tuple[Shape, Callable[[Array], Change]] | None
    flexible: tuple[str, ...]
    magnet_numbers: Mapping[str, Array] | None
    by_moduli: Mapping[str, Callable[[Array, bool], Array]]
    without_moduli: Mapping[str, str] | None

    @cached_property
    def tangent(self) -> StuckTangent:
        """The contact, linearised about the step."""
        return StuckTangent(self)

    def started_from(self, unknowns: Array, rigid: Array) -> bool:
        """Whether the step started from these tractions and pressures (3, n) and this displacement (2, n)."""
        before = self.linear.before()
        return np.array_equal(before[0], np.ravel(unknowns)) and np.array_equal(before[1], np.ravel(rigid))

    def functionals(self, area: Array, pressure: Callable[[], Array]) -> dict[str, Callable[[], Functional]]:
        """Numbers of the step that are sums of its fields, by name; `pressure` gives the mean (n,) [Pa]."""
        known = {
            "force": lambda: Functional((3,), {"unknowns": self.shared.resultants[:3]}),
            "moment": lambda: Functional((3,), {"unknowns": self.shared.resultants[3:]}),
            "friction_work": lambda: self._work(area, 1.0),
            **Functional.of_pressure(pressure, area, self.unknowns[2] > 0.0),
        }
        if self.magnet_numbers is not None:
            known["attraction"] = lambda: Functional.of_one(magnetic_pressure=area)
        if self.duration is not None:
            duration = self.duration
            known["friction_power"] = lambda: self._work(area, 1.0 / duration)
        return known

    def _work(self, area: Array, share: float) -> Functional:
        slips = np.where(self.status == 2, share * area, 0.0)
        of_traction = np.concatenate([slips * self.slip, np.zeros((1, area.size))])
        of_slip = np.einsum("acn,an->cn", self.shared.frame, slips * self.unknowns[:2])
        return Functional.of_one(unknowns=of_traction, slip=of_slip)


class StuckTangent:
    """The linearised equations of a step with a shift; see :class:`mtb_rs.results.derivatives.Tangent`."""

    def __init__(self, derived: StuckDerived) -> None:
        self._core = derived.linear
        self._derived = derived
        n, shared = derived.gap.size, derived.shared
        self._points = Points((n,), None, shared.frame, shared.geometry, derived.unknowns[2])
        self._n, self._motions = n, len(self._core.balanced())
        self.fields: dict[str, Shape] = {
            "pressure": (n,), "traction": (3, n), "gap": (n,), "slip": (3, n), "motion": (self._motions,),
            "unknowns": (3, n), "rigid_displacement": (2, n),
        }  # fmt: skip
        self.inputs: dict[str, Shape] = {
            "gap": (n,), "friction": (), "friction_field": (n,), "pose": (6,), "shift": (2,),
            "work": (self._motions,),
        }  # fmt: skip
        if not derived.follows_shift:
            self.inputs["velocity"] = (2,)
        self.inputs |= dict.fromkeys(derived.flexible, (n,))
        if derived.by_layer is not None:
            self.inputs["normal_layer"] = derived.by_layer[0]
        self.refused: dict[str, str] = {
            "magnetic_pressure_field": (
                "of a step with a shift 'magnetic_pressure' is the derivative by a uniform pressure"
            ),
        }
        self._magnet = derived.magnet_numbers or {}
        if derived.magnet_numbers is not None:
            self.fields["magnetic_pressure"] = (n,)
            self.refused |= dict.fromkeys(("magnetic_pressure", "magnetic_pressure_field"), PULLS)
            for name, numbers in self._magnet.items():
                self.inputs[f"magnetic_pressure.{name}"] = numbers.shape[:-1]
        elif any(bool(part[_PULL].any()) for part in self._given):
            self.inputs["magnetic_pressure"] = ()
        else:
            self.refused["magnetic_pressure"] = "nothing is pulled uniformly in this step"
        if derived.follows_shift:
            self.refused["velocity"] = "it is the shift over dt: 'shift' is the derivative by both"
        self.inputs |= dict.fromkeys(derived.by_moduli, ())
        self.refused |= MATERIALS if derived.without_moduli is None else derived.without_moduli
        self._deformed: dict[str, list[Array]] = {}
        self.inputs |= {
            "state.traction": (2, n), "state.pressure": (n,), "state.rigid_displacement": (2, n),
        }  # fmt: skip

    @cached_property
    def _given(self) -> list[Array]:
        """What a unit of each component of pose, shift, velocity and pull changes."""
        return self._core.inputs()

    @cached_property
    def margin(self) -> Margin:
        """How near points are to parting or touching, to slipping or sticking."""
        derived = self._derived
        pressure, sticks, slips = derived.unknowns[2], derived.status == 1, derived.status == 2
        contact = pressure > 0.0
        if not contact.any():
            return Margin(np.inf, Margin.of_first_touch(derived.gap))
        bound, size = derived.friction * pressure, np.hypot(*derived.unknowns[:2])
        slip = np.hypot(*derived.slip)
        moved = np.abs(self._core.displacement(np.ravel(derived.unknowns))[2 * self._n :])[contact].max()
        beside = derived.gap[~contact]
        largest = float(slip[slips].max(initial=0.0))
        return Margin(
            parting=float(pressure[contact].min() / pressure.max()),
            touching=float(beside.min() / moved) if beside.size else np.inf,
            slipping=float((bound - size)[sticks].min() / bound.max()) if sticks.any() else np.inf,
            sticking=float(slip[slips].min() / largest) if largest > 0.0 else np.inf,
        )

    def _by_modulus(self, name: str) -> list[Array]:
        """What a unit of a modulus changes: gap, and where points slide from what the step before left."""
        if name not in self._deformed:
            derived, n = self._derived, self._n
            parted, frame = derived.by_moduli[name], derived.shared.frame
            left = np.ascontiguousarray(np.reshape(self._core.before()[0], (3, n)))
            nothing = np.zeros((3, n))
            # without tractions and pull what is left is by other loads
            loads, pulled = parted(nothing, False), parted(nothing, True)
            now, before = parted(derived.unknowns, True), parted(left, False) - loads
            along = [
                np.einsum("acn,cn->an", frame[:2], moved).reshape(1, -1) for moved in (now - before, pulled)
            ]
            columns = [np.zeros((1, part.shape[1])) for part in self._given]
            normal = np.cross(frame[0].T, frame[1].T).T
            columns[0] = np.einsum("cn,cn->n", now, normal)[None]
            columns[2], columns[3] = along[0], -along[1]
            self._deformed[name] = columns
        return self._deformed[name]

    def _columns(self, name: str) -> list[Array]:
        """What a unit of each number of pose, shift, velocity, uniform pull or of a modulus changes."""
        if name in self._derived.by_moduli:
            return self._by_modulus(name)
        which = {"pose": _POSE, "shift": _SHIFT, "velocity": _VELOCITY, "magnetic_pressure": _PULL}[name]
        columns = [part[which] for part in self._given]
        if name == "shift" and self._derived.follows_shift and self._derived.duration is not None:
            by_speed = self._columns("velocity")
            columns = [a + b / self._derived.duration for a, b in zip(columns, by_speed, strict=True)]
        return columns

    def _by_magnet(self, name: str) -> Array:
        """Pull by the numbers of an input of a magnet (l, n)."""
        fields = self._core.magnet()
        assert fields is not None
        return np.asarray(np.atleast_2d(self._magnet[name.partition(".")[2]]) @ fields)

    def _opened(self) -> Array:
        """Gap that each number of a layer opens at the pressures of the step (l, n)."""
        by_layer = self._derived.by_layer
        assert by_layer is not None
        opened = by_layer[1](self._derived.unknowns[2]).gap
        assert opened is not None
        return opened

    def forward(self, changes: Mapping[str, Array]) -> Mapping[str, Array]:
        """Changes (k, ...) of all fields by those of inputs (k, ...)."""
        n, m, k = self._n, self._motions, len(next(iter(changes.values())))
        given = [np.zeros((k, size)) for size in (n, m, 2 * n, 2 * n, n, self._given[5].shape[1])]
        gap, work, wanted, _, friction, pull = given
        for name, values in changes.items():
            flat = in_rows(values)
            if name == "gap":
                gap += flat
            elif name in self._derived.flexible:
                gap += flat * self._derived.unknowns[2]
            elif name == "normal_layer":
                gap += flat @ self._opened()
            elif name in ("friction", "friction_field"):
                friction += flat
            elif name == "work":
                work += flat
            elif name.startswith("magnetic_pressure."):
                pull += flat @ self._by_magnet(name)
            elif name == "state.rigid_displacement":
                wanted += flat
            elif name.startswith("state."):
                for row, own in zip(wanted, flat, strict=True):
                    left = np.zeros(3 * n)
                    left[slice(2 * n) if name == "state.traction" else slice(2 * n, None)] = own
                    row += self._core.displacement(left)[: 2 * n]
            else:
                for part, column in zip(given, self._columns(name), strict=True):
                    part += flat @ column
        traction, opened, motion, slip, rigid, pulled = self._core.forward(*given)
        points, frame = self._points, self._points.frame
        unknowns = traction.reshape(k, 3, n)
        mean = points.means(unknowns[:, :2].reshape(2 * k, n)).reshape(k, 2, n)
        pulls = {"magnetic_pressure": pulled} if "magnetic_pressure" in self.fields else {}
        return pulls | {
            "pressure": points.means(unknowns[:, 2]),
            "traction": np.einsum("acn,kan->kcn", frame, mean),
            "gap": opened,
            "slip": np.einsum("acn,kan->kcn", frame, slip.reshape(k, 2, n)),
            "motion": motion,
            "unknowns": unknowns,
            "rigid_displacement": rigid.reshape(k, 2, n),
        }

    def adjoint(self, weights: Mapping[str, Array]) -> Mapping[str, Array]:
        """Gradients (k, ...) by the inputs, each made when it is asked for."""
        points, n, k = self._points, self._n, len(next(iter(weights.values())))

        def of(name: str) -> Array:
            shape = self.fields[name]
            return np.array(weights[name]) if name in weights else np.zeros((k, *shape))

        unknowns = of("unknowns")
        if "pressure" in weights:
            unknowns[:, 2] += points.of_means(np.ascontiguousarray(weights["pressure"]))
        if "traction" in weights:
            local = np.einsum("acn,kcn->kan", points.frame, weights["traction"])
            own = points.of_means(np.ascontiguousarray(local.reshape(2 * k, n)))
            unknowns[:, :2] += own.reshape(k, 2, n)
        slip = np.einsum("acn,kcn->kan", points.frame, of("slip"))
        pull = of("magnetic_pressure") if "magnetic_pressure" in self.fields else np.zeros((k, 0))
        parts = unknowns, of("gap"), of("motion"), slip, of("rigid_displacement"), pull
        found = self._core.adjoint(*(np.ascontiguousarray(in_rows(part)) for part in parts))
        return Gradient(self.inputs, lambda name: self._by(name, found))

    def _by(self, name: str, found: list[Array]) -> Array:
        """The gradient (k, ...) by an input."""
        gap, work, wanted, _, friction, pull = found
        k, pressure = len(gap), self._derived.unknowns[2]
        left = 2 * self._n
        if name == "gap":
            values = gap
        elif name in self._derived.flexible:
            values = gap * pressure
        elif name == "normal_layer":
            values = gap @ self._opened().T
        elif name == "friction_field":
            values = friction
        elif name == "friction":
            values = friction.sum(axis=1)
        elif name == "work":
            values = work
        elif name.startswith("magnetic_pressure."):
            values = pull @ self._by_magnet(name).T
        elif name == "state.rigid_displacement":
            values = wanted
        elif name == "state.traction":
            values = self._left(wanted)[:, :left]
        elif name == "state.pressure":
            values = self._left(wanted)[:, left:]
        else:
            parts = zip(found, self._columns(name), strict=True)
            values = np.sum([own @ column.T for own, column in parts], axis=0)
        return np.asarray(values).reshape(k, *self.inputs[name])

    def _left(self, wanted: Array) -> Array:
        """Weights (k, 3n) of what the step before left."""
        left = np.empty((len(wanted), 3 * self._n))
        for own, row in zip(left, wanted, strict=True):
            own[:] = self._core.transposed(np.ascontiguousarray(row))
        return left
