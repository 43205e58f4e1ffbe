# SPDX-License-Identifier: MIT OR Apache-2.0
"""Derivatives of the steps of prepared wheels, by pose, velocity, friction, force and layer."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from .. import _mtb_rs
from ..results.derivatives import Gradient, Margin

Array = NDArray[np.float64]
Shape = tuple[int, ...]


class WheelTangent:
    """What changes of a step follow from changes of what was given, with stick, slip and contact held.

    An input costs one linear solve of the pressures and one of the tractions for each of its numbers, and
    each patch. What was solved is kept.

    Attributes
    ----------
    fields : dict of str to shape
        What is found: numbers of the step, numbers of its `p` patches (p, ...), and fields over the `n`
        points of all patches, ``pressure`` (n,), ``traction`` and ``slip_velocity`` (2, n) in the frame of
        each patch.
    inputs : dict of str to shape
        What is given: ``pose`` (6,), ``velocity`` () or (6,), as it was given, ``friction`` or the parameters
        of the law, ``vertical_force`` () of each wheel, ``layer`` (), its thickness over its shear modulus.
    refused : dict of str to str
        What else could be asked for, and why there is no derivative by it.
    """

    def __init__(
        self, core: _mtb_rs.WheelTangent, friction: list[tuple[str, list[int]]], is_speed: bool, size: Shape
    ) -> None:
        self._core = core
        self._known: dict[str, list[dict[str, Array]]] = {}
        wheels, patches, points = size
        self.fields: dict[str, Shape] = {
            "force": (3,),
            "moment": (3,),
            "vertical_force": (wheels,),
            "pose": (6,),
            "friction_power": (),
            "position": (patches, 3),
            "contact_angle": (patches,),
            "rail_position": (patches,),
            "wheel_position": (patches,),
            "approach": (patches,),
            "creepage": (patches, 3),
            "rolling_speed": (patches,),
            "patch_force": (patches, 3),
            "patch_friction_power": (patches,),
            "pressure": (points,),
            "traction": (2, points),
            "slip_velocity": (2, points),
        }
        self.refused = {
            "force": "wheels carry a vertical force: derive by 'vertical_force'",
            "gap": "the gap of wheels follows from their pose and their profiles: derive by 'pose'",
            **{
                f"{body}.{modulus}": "steps of wheels are not derived by elastic moduli"
                for body in ("lower", "upper")
                for modulus in ("young_modulus", "poisson_ratio")
            },
        }
        self._friction = {name: tuple(shape) for name, shape in friction}
        self.inputs: dict[str, Shape] = {
            "pose": (6,),
            "velocity": () if is_speed else (6,),
            **self._friction,
            "vertical_force": (),
            "layer": (),
        }

    @property
    def margin(self) -> Margin:
        """How far the points are from another state."""
        return Margin(*self._core.margin())

    def forward(self, changes: Mapping[str, Array]) -> dict[str, Array]:
        """Changes (k, *shape) of all fields by k changes (k, *shape) of inputs."""
        count = max(len(change) for change in changes.values())
        flat = {by: np.asarray(change).reshape(count, -1) for by, change in changes.items()}
        found = {}
        for of, shape in self.fields.items():
            total = np.zeros((count, math.prod(shape)))
            for by, change in flat.items():
                total += change @ self._rows(of, by)
            found[of] = total.reshape(count, *shape)
        return found

    def adjoint(self, weights: Mapping[str, Array]) -> Mapping[str, Array]:
        """Gradients (k, *shape) by all inputs of k sums of fields with the `weights` (k, *shape)."""
        count = max(len(weight) for weight in weights.values())

        def entry(by: str) -> Array:
            shape = self.inputs[by]
            total = np.zeros((count, math.prod(shape)))
            for of, weight in weights.items():
                flat = np.asarray(weight).reshape(count, math.prod(self.fields[of]))
                total += flat @ self._rows(of, by).T
            return total.reshape(count, *shape)

        return Gradient(self.inputs, entry)

    def _rows(self, of: str, by: str) -> Array:
        """Changes of a field by a unit of each number of an input (numbers, entries)."""
        columns = [column[of] for column in self._columns(by)]
        return np.array(columns).reshape(len(columns), math.prod(self.fields[of]))

    def _columns(self, by: str) -> list[dict[str, Array]]:
        group = "friction" if by in self._friction else {"vertical_force": "force"}.get(by, by)
        if group not in self._known:
            self._known[group] = self._core.derivatives(group)
        columns = self._known[group]
        if group != "friction":
            return columns
        before = list(self._friction)[: list(self._friction).index(by)]
        first = sum(math.prod(self._friction[name]) for name in before)
        return columns[first : first + math.prod(self._friction[by])]
