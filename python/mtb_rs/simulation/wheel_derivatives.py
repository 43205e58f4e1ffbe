# SPDX-License-Identifier: MIT OR Apache-2.0
"""Derivatives of steps of prepared wheels by pose, velocity, time, friction, forces, track, layer, moduli."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from .. import _mtb_rs
from ..bodies.simple import Simple
from ..results.derivatives import Gradient, Margin

Array = NDArray[np.float64]
Shape = tuple[int, ...]

#: What may be found for a force, and why there is no derivative by it otherwise.
NOT_FOUND = {
    "lateral_force": "y was given, and not found for it",
    "longitudinal_force": "the rotation about the axle was not found for it",
    "axle_moment": "the rotation about the axle was not found for it",
}
SPRINGS = ("rail_stiffness", "rail_force")
#: What a transient step rolls on from, and why there is no derivative by it.
STATE = ("state", "state.traction", "state.pressure")
OF_STATE = "what the step before has left is held as it is: derive by what this step was given"
#: Numbers of a rail and of a wheel beside its place, with the rates.
BESIDE = {"rails": 6, "wheels": 12}
#: What the core calls an input, and where its numbers are there: first one, and how many.
PLACES: dict[str, tuple[str, int, int | None]] = {
    "vertical_force": ("force", 0, None),
    "longitudinal_force": ("axle_load", 0, None),
    "axle_moment": ("axle_load", 0, None),
    "rail_stiffness": ("springs", 0, 2),
    "rail_force": ("springs", 2, 2),
    "dt": ("duration", 0, None),
    "curvature": ("alignment", 0, 1),
    "rails.left": ("alignment", 1, 6),
    "rails.right": ("alignment", 7, 6),
    "wheels.left": ("alignment", 13, 12),
    "wheels.right": ("alignment", 25, 12),
}


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
        of the law, ``vertical_force`` () of each wheel, ``lateral_force`` () where y was found for it,
        ``longitudinal_force`` or ``axle_moment`` () where the rotation was found for it, ``curvature`` (),
        ``rails.left`` (6,) and ``wheels.left`` (12,) to ``wheels.right``, place and rates,
        ``rail_stiffness`` (2,) and ``rail_force`` (2,) of rails on springs, ``layer`` (), its thickness over
        its shear modulus, ``dt`` () of a transient step, ``lower.young_modulus`` and ``lower.poisson_ratio``
        () of the rail, and those of the wheel (``upper``). What a transient step rolls on from is held.
    refused : dict of str to str
        What else could be asked for, and why there is no derivative by it.
    """

    def __init__(
        self,
        core: _mtb_rs.WheelTangent,
        friction: list[tuple[str, list[int]]],
        bodies: Sequence[Simple],
        is_speed: bool,
        found_for: Collection[str],
        is_transient: bool,
        has_springs: bool,
        wheels: Sequence[str],
        size: Shape,
    ) -> None:
        self._core = core
        sides = dict(zip(("lower", "upper"), bodies, strict=True))
        self._materials = {side: body.material for side, body in sides.items() if body.material is not None}
        self._known: dict[str, list[dict[str, Array]]] = {}
        patches, points = size
        self.fields: dict[str, Shape] = {
            "force": (3,),
            "moment": (3,),
            "vertical_force": (len(wheels),),
            "pose": (6,),
            "velocity": (6,),
            "rail_displacement": (len(wheels), 2),
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
            **{name: why for name, why in NOT_FOUND.items() if name not in found_for},
            **({} if has_springs else dict.fromkeys(SPRINGS, "the rails have no springs")),
            **({} if is_transient else {"dt": "the step is steady, as if the wheels had rolled so for long"}),
            **dict.fromkeys(STATE, OF_STATE if is_transient else "the step is steady, and has no past"),
            "gap": "the gap of wheels follows from their pose and their profiles: derive by 'pose'",
            **{
                f"{side}.{name}": why
                for side, body in sides.items()
                for name, why in body.without_derivatives.items()
            },
        }
        self._friction = {name: tuple(shape) for name, shape in friction}
        self.inputs: dict[str, Shape] = {
            "pose": (6,),
            "velocity": () if is_speed else (6,),
            **self._friction,
            "vertical_force": (),
            **{name: () for name in NOT_FOUND if name in found_for},
            "curvature": (),
            **{f"{body}.{side}": (count,) for body, count in BESIDE.items() for side in wheels},
            **(dict.fromkeys(SPRINGS, (2,)) if has_springs else {}),
            "layer": (),
            **({"dt": ()} if is_transient else {}),
            **{f"{side}.{name}": () for side in self._materials for name in sides[side].moduli},
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
        side, _, constant = by.partition(".")
        if side in self._materials:
            return [self._by_constant(side, constant)]
        if by in self._friction:
            before = list(self._friction)[: list(self._friction).index(by)]
            first = sum(math.prod(self._friction[name]) for name in before)
            return self._group("friction")[first : first + math.prod(self._friction[by])]
        group, first, count = PLACES.get(by, (by, 0, None))
        columns = self._group(group)
        return columns if count is None else columns[first : first + count]

    def _group(self, name: str) -> list[dict[str, Array]]:
        if name not in self._known:
            self._known[name] = self._core.derivatives(name)
        return self._known[name]

    def _by_constant(self, side: str, constant: str) -> dict[str, Array]:
        """Changes by Young's modulus or Poisson's ratio, from those by the shear modulus and the ratio."""
        columns = self._group("moduli")
        first = 2 * list(self._materials).index(side)
        by_shear, by_ratio = columns[first : first + 2]
        material = self._materials[side]
        more = 1.0 + material.poisson_ratio
        if constant == "young_modulus":
            return {of: change / (2.0 * more) for of, change in by_shear.items()}
        # at a given Young's modulus the shear modulus falls with the ratio
        fall = material.shear_modulus / more
        return {of: change - fall * by_shear[of] for of, change in by_ratio.items()}
