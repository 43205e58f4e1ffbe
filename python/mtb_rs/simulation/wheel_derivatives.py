# SPDX-License-Identifier: MIT OR Apache-2.0
"""Derivatives of steps of prepared wheels by pose, velocity, time, friction, forces, track, layer, moduli."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from .. import _mtb_rs
from ..bodies.constants import refused_constants
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
OF_STATE = (
    "what the step before has left follows from what that was given: derive by this, with gradient_of_steps"
)
#: Numbers of a rail and of a wheel beside its place, with the rates.
BESIDE = {"rails": 6, "wheels": 12}
#: What the core calls an input, and where its numbers begin there.
PLACES: dict[str, tuple[str, int]] = {
    "vertical_force": ("force", 0),
    "longitudinal_force": ("axle_load", 0),
    "axle_moment": ("axle_load", 0),
    "rail_stiffness": ("springs", 0),
    "rail_force": ("springs", 2),
    "dt": ("duration", 0),
    "curvature": ("alignment", 0),
    "rails.left": ("alignment", 1),
    "rails.right": ("alignment", 7),
    "wheels.left": ("alignment", 13),
    "wheels.right": ("alignment", 25),
}
#: Why steps of conformal patches have no derivatives by a modulus.
OF_CONFORMAL = (
    "a modulus of one body makes wheel and rail unlike, and conformal patches are known between like ones"
)


class WheelTangent:
    """What changes of a step follow from changes of what was given, with stick, slip and contact held.

    An input costs one linear solve of the pressures and one of the tractions for each of its numbers, and
    each patch; of the steps after it one more of the tractions. What was solved of the step itself is kept.

    Attributes
    ----------
    fields : dict of str to shape
        What is found: numbers of the step, numbers of its `p` patches (p, ...), and fields over the `n`
        points of all patches, ``pressure`` (n,), ``traction`` and ``slip_velocity`` (2, n) in the frame of
        each patch.
    inputs : dict of str to shape
        What is given: ``pose`` (6,), ``velocity`` () or (6,), as it was given, ``friction`` or the parameters
        of the law (of one that follows the temperature also what the bodies are made of), those of
        ``right_friction`` where the right wheel has its own,
        ``vertical_force`` () of each wheel, ``lateral_force`` () where y was found for it,
        ``longitudinal_force`` or ``axle_moment`` () where the rotation was found for it, ``curvature`` (),
        ``rails.left`` (6,) and ``wheels.left`` (12,) to ``wheels.right``, place and rates,
        ``rail_stiffness`` (2,) and ``rail_force`` (2,) of rails on springs, ``layer`` (), its thickness over
        its shear modulus, ``dt`` () of a transient step, ``lower.young_modulus`` and ``lower.poisson_ratio``
        () of the rail, and those of the wheel (``upper``).
    refused : dict of str to str
        What else could be asked for, and why there is no derivative by it.
    """

    def __init__(
        self,
        core: _mtb_rs.WheelTangent,
        friction: Mapping[str, Array],
        bodies: Sequence[Simple],
        is_speed: bool,
        found_for: Collection[str],
        is_transient: bool,
        has_springs: bool,
        wheels: Sequence[str],
        size: Shape,
        conformal: bool,
    ) -> None:
        self._core = core
        sides = dict(zip(("lower", "upper"), bodies, strict=True))
        self._materials = {side: body.material for side, body in sides.items() if body.material is not None}
        moduli = [f"{side}.{name}" for side in self._materials for name in sides[side].constants]
        self._known: dict[str, list[_mtb_rs.WheelChange]] = {}
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
            **refused_constants(sides),
            **(dict.fromkeys(moduli, OF_CONFORMAL) if conformal else {}),
        }
        self._friction = friction
        self.inputs: dict[str, Shape] = {
            "pose": (6,),
            "velocity": () if is_speed else (6,),
            **{name: slopes.shape[1:] for name, slopes in friction.items()},
            "vertical_force": (),
            **{name: () for name in NOT_FOUND if name in found_for},
            "curvature": (),
            **{f"{body}.{side}": (count,) for body, count in BESIDE.items() for side in wheels},
            **(dict.fromkeys(SPRINGS, (2,)) if has_springs else {}),
            "layer": (),
            **({"dt": ()} if is_transient else {}),
            **({} if conformal else dict.fromkeys(moduli, ())),
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
        return self.along([(self, weights)])

    def along(self, chain: Sequence[tuple[WheelTangent, Mapping[str, Array]]]) -> Mapping[str, Array]:
        """Gradients (k, *shape) by the inputs of this step of k sums over a chain that begins with it: the
        equations of each step, and the weights (k, *shape) of its fields."""
        count = max(len(weight) for _, weights in chain for weight in weights.values())

        def entry(by: str) -> Array:
            shares, changes = self._changes(by)
            total = np.zeros((count, len(changes)))
            before = self
            for tangent, weights in chain:
                if tangent is not before:
                    changes = tangent._core.after(before._core, changes)
                    before = tangent
                for of, weight in weights.items():
                    flat = np.asarray(weight).reshape(count, math.prod(tangent.fields[of]))
                    total += flat @ tangent._rows_of(of, changes).T
            return (total @ shares.T).reshape(count, *self.inputs[by])

        return Gradient(self.inputs, entry)

    def follows(self, earlier: WheelTangent) -> bool:
        """Whether the step rolled on from the state that another one has left, or is steady."""
        return self._core.follows(earlier._core)

    def _rows(self, of: str, by: str) -> Array:
        """Changes of a field by a unit of each number of an input (numbers, entries)."""
        shares, changes = self._changes(by)
        return np.asarray(shares @ self._rows_of(of, changes))

    def _changes(self, by: str) -> tuple[Array, list[_mtb_rs.WheelChange]]:
        """Shares of changes that the core knows in each of an input's numbers (numbers, changes), and these
        changes."""
        group, shares = self._shares(by)
        own = np.flatnonzero(shares.any(axis=0))
        return shares[:, own], [self._group(group)[k] for k in own]

    def _rows_of(self, of: str, changes: Sequence[_mtb_rs.WheelChange]) -> Array:
        rows = [change.field(of) for change in changes]
        return np.array(rows).reshape(len(rows), math.prod(self.fields[of]))

    def _shares(self, by: str) -> tuple[str, Array]:
        """What the core calls an input, and shares of its numbers there in each of the input's (numbers,
        numbers there)."""
        side, _, constant = by.partition(".")
        if side in self._materials:
            return "moduli", self._of_constant(side, constant)
        count = math.prod(self.inputs[by])
        if by in self._friction:
            slopes = self._friction[by]
            return by.partition(".")[0], slopes.reshape(len(slopes), count).T
        group, first = PLACES.get(by, (by, 0))
        return group, np.eye(count, len(self._group(group)), first)

    def _group(self, name: str) -> list[_mtb_rs.WheelChange]:
        if name not in self._known:
            self._known[name] = self._core.derivatives(name)
        return self._known[name]

    def _of_constant(self, side: str, constant: str) -> Array:
        """Shares (1, numbers) of the moduli in Young's modulus or Poisson's ratio: those of the shear modulus
        and of the ratio at that shear modulus."""
        shares = np.zeros((1, len(self._group("moduli"))))
        first = 2 * list(self._materials).index(side)
        material = self._materials[side]
        more = 1.0 + material.poisson_ratio
        if constant == "young_modulus":
            shares[0, first] = 0.5 / more
        else:
            # at a given Young's modulus the shear modulus falls with the ratio
            shares[0, first : first + 2] = -material.shear_modulus / more, 1.0
        return shares
