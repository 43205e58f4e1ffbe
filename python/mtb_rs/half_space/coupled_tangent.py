# SPDX-License-Identifier: MIT OR Apache-2.0
"""Derivatives of shifts and rolling whose pressure follows the traction."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import cached_property, partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .. import _mtb_rs
from ..bodies.material import Material
from ..bodies.simple import Core, Medium, are_compound, medium_of, surface_of
from ..results.derivatives import Gradient
from .compound import Compound, opened_by_terms
from .normal_tangent import NormalTangent
from .prisms import Prisms
from .tangential_tangent import TangentialTangent

Array = NDArray[np.float64]
Shape = tuple[int, ...]

#: Last change, over the sum of all, at which the alternation of the two linear problems ends ...
_SETTLED = 1e-12
#: ... and most rounds of it.
_ROUNDS = 200


@dataclass(frozen=True)
class GapByTraction:
    """How tractions on the surfaces of two half-spaces open the gap.

    The normal displacement of a half-space by a tangential traction goes with (1 - 2 nu) / G. The upper body
    feels the opposite traction and moves the gap the other way: only the difference of the two counts.

    Parameters
    ----------
    shape : (ny, nx)
    spacing : (float, float) [m]
    bodies : dict of "lower", "upper" to Material, Layered or Viscoelastic
        Those that give way.
    velocity : (float, float) or None [m/s]
        At which the contact rolls over bodies that creep.
    inclination : (ny,) or None [rad]
        Of the rows: a traction along y is in part a pressure on rows of other angles.
    prisms : Prisms or None
        Those among the bodies.
    """

    shape: tuple[int, int]
    spacing: tuple[float, float]
    bodies: Mapping[str, Medium]
    velocity: tuple[float, float] | None = None
    inclination: Array | None = None
    prisms: Prisms | None = None

    @property
    def is_compound(self) -> bool:
        """Whether a body is layered or creeps: what opens the gap is no multiple of that of a half-space."""
        return are_compound(*self.bodies.values())

    @property
    def _materials(self) -> dict[str, Material]:
        if self.is_compound:
            return {side: body for side, body in self.bodies.items() if isinstance(body, Material)}
        return {side: surface_of(body) for side, body in self.bodies.items()}

    @property
    def factor(self) -> float:
        """Difference of (1 - 2 nu) / G [1/Pa]; on a curved surface the sum of (1 - nu) / G."""
        if self.inclination is not None:
            bodies = self._materials.values()
            return sum((1.0 - body.poisson_ratio) / body.shear_modulus for body in bodies)
        return sum(_SIGN[side] * _factor(body) for side, body in self._materials.items())

    @property
    def cancels(self) -> bool:
        """Whether the bodies are alike in this, but for rounding."""
        if self.inclination is not None or self.prisms is not None:
            return False
        if self.is_compound:
            return self.bodies.get("lower") == self.bodies.get("upper")
        factors = [_factor(body) for body in self._materials.values()]
        return abs(self.factor) <= 1e-12 * max(factors)

    @property
    def moduli(self) -> dict[str, Callable[[Array], Array]]:
        """What a unit of each constant of the bodies adds (ny, nx) [m] to what tractions (3, ny, nx) open,
        and of the velocity and the direction of rolling over what creeps."""

        def by_factor(slope: float, traction: Array) -> Array:
            return slope * self.of_unit(traction)

        added: dict[str, Callable[[Array], Array]] = {}
        for name, slope in self._slopes.items():
            added[name] = partial(by_factor, slope)
        if self.prisms is not None:
            added |= {name: partial(self._by_prism, self.prisms, name) for name in self.prisms.moduli}
        compound = Compound(self.bodies.get("lower"), self.bodies.get("upper"), self.velocity, self.spacing)
        for name, terms in (compound.numbers | compound.motions).items():
            added[name] = partial(self._by_terms, terms)
        return added

    def _by_terms(self, terms: Callable[[], list[tuple[float, dict[str, Core]]]], traction: Array) -> Array:
        load = np.array(traction, dtype=float)
        load[2] = 0.0
        return opened_by_terms(terms(), load, self.spacing, _SIGN)

    def _by_prism(self, prisms: Prisms, modulus: str, traction: Array) -> Array:
        load = np.array(traction, dtype=float)
        load[2] = 0.0
        return prisms.opened_by(modulus, load)

    @property
    def _slopes(self) -> dict[str, float]:
        """Derivatives of the factor by the constants of half-spaces."""
        slopes = {}
        for side, body in self._materials.items():
            modulus, ratio, sign = body.young_modulus, body.poisson_ratio, _SIGN[side]
            if self.inclination is not None:
                slopes[f"{side}.young_modulus"] = -2.0 * (1.0 - ratio**2) / modulus**2
                slopes[f"{side}.poisson_ratio"] = -4.0 * ratio / modulus
                continue
            slopes[f"{side}.young_modulus"] = -sign * _factor(body) / modulus
            slopes[f"{side}.poisson_ratio"] = -sign * 2.0 * (1.0 + 4.0 * ratio) / modulus
        return slopes

    @cached_property
    def _unit(self) -> _mtb_rs.Compliance:
        """A half-space whose factor is 1, either one."""
        ny, nx = self.shape
        return _mtb_rs.half_space((1.0, 0.0), [(0.0, 0.0, nx, ny)], self.spacing, True)

    def of_unit(self, traction: Array) -> Array:
        """Gap (ny, nx) [m Pa] that tractions (3, ny, nx) open at a factor of 1; without their third part."""
        if self.inclination is not None:
            return self._on_arc(traction[1])
        load = np.reshape(traction, (3, -1)).copy()
        load[2] = 0.0
        return np.asarray(self._unit.displacement(load)[2].reshape(self.shape))

    def of(self, traction: Array) -> Array:
        """Gap (ny, nx) [m] that tractions (3, ny, nx) [Pa] on the lower body open."""
        if self.inclination is None and self.is_compound:
            return np.zeros(self.shape) if self.cancels else self._of_each(traction)
        factor = self.factor
        opened = factor * self.of_unit(traction) if factor != 0.0 else np.zeros(self.shape)
        if self.prisms is None:
            return opened
        load = np.array(traction, dtype=float)
        load[2] = 0.0
        return np.asarray(opened + self.prisms.normal.opening(load))

    def _on_arc(self, traction: Array) -> Array:
        """Gap (ny, nx) [m Pa] that a traction along y opens on a curved surface at a factor of 1."""
        cosine, sine = self._turns
        return sine * self._normal(cosine * traction) - cosine * self._normal(sine * traction)

    @property
    def _turns(self) -> tuple[Array, Array]:
        assert self.inclination is not None
        return np.cos(self.inclination)[:, None], np.sin(self.inclination)[:, None]

    def _normal(self, pressure: Array) -> Array:
        """Displacement (ny, nx) [m Pa] by a pressure on a half-space with (1 - nu) / G = 1."""
        load = np.zeros((3, pressure.size))
        load[2] = pressure.ravel()
        return np.asarray(self._unit.displacement(load)[2]).reshape(self.shape)

    def _of_each(self, traction: Array) -> Array:
        """The same as a sum over the bodies."""
        load = np.reshape(traction, (3, -1)).copy()
        load[2] = 0.0
        opened = np.zeros(self.shape)
        for side, surface in self._surfaces(back=False).items():
            opened += _SIGN[side] * surface.displacement(load)[2].reshape(self.shape)
        return opened

    def _back_of_each(self, weights: Array) -> Array:
        """Its transpose: bodies that creep do so under a contact that rolls the other way."""
        load = np.zeros((3, weights.size))
        load[2] = np.ravel(weights)
        moved = np.zeros((3, *self.shape))
        for side, surface in self._surfaces(back=True).items():
            moved[:2] += _SIGN[side] * surface.displacement(load)[:2].reshape(2, *self.shape)
        return moved

    def _surfaces(self, *, back: bool) -> dict[str, _mtb_rs.Compliance]:
        """The bodies under the cells, under the contact or one that rolls back."""
        if back not in self._made:
            ny, nx = self.shape
            velocity = self.velocity
            if back and velocity is not None:
                velocity = (-velocity[0], -velocity[1])
            media = {side: medium_of(body, velocity) for side, body in self.bodies.items()}
            self._made[back] = {
                side: _mtb_rs.half_space(medium, [(0.0, 0.0, nx, ny)], self.spacing, True)
                for side, medium in media.items()
                if medium is not None
            }
        return self._made[back]

    @cached_property
    def _made(self) -> dict[bool, dict[str, _mtb_rs.Compliance]]:
        return {}

    def back(self, weights: Array) -> Array:
        """Weights (3, ny, nx) of tractions that do what weights (ny, nx) of the gap do: a pressure moves the
        surface along as far as, by Betti, a traction moves it up."""
        if self.inclination is None and self.is_compound:
            return np.zeros((3, *self.shape)) if self.cancels else self._back_of_each(weights)
        factor = self.factor
        if factor == 0.0 and self.prisms is None:
            return np.zeros((3, *self.shape))
        if self.inclination is not None:
            cosine, sine = self._turns
            moved = np.zeros((3, *self.shape))
            moved[1] = cosine * self._normal(sine * weights) - sine * self._normal(cosine * weights)
            return factor * moved
        load = np.zeros((3, weights.size))
        load[2] = np.ravel(weights)
        moved = factor * self._unit.displacement(load).reshape(3, *self.shape)
        moved[2] = 0.0
        if self.prisms is not None:
            moved[:2] += self.prisms.normal.back(np.ascontiguousarray(weights))
        return np.asarray(moved)


_SIGN = {"lower": 1.0, "upper": -1.0}
#: What is between the bodies, and acts on the pressure alone.
_PRESSING = ("normal_layer", "normal_layer_field", "hardness")
#: What the normal contact calls by other names: how it rolls over what creeps.
_ROLLING = {"velocity": "rolling.velocity", "angle": "rolling.angle"}


def _factor(body: Material) -> float:
    return (1.0 - 2.0 * body.poisson_ratio) / body.shear_modulus


class CoupledTangent:
    """What follows from changes of what was given where pressure and traction follow from each other.

    The linearised normal and tangential problems take turns, as the problems themselves do in the solve,
    until what a round adds is nothing any more; a round is a linear solve of each.

    Attributes
    ----------
    fields : dict of str to shape
        As of a tangential problem; the pressure is found.
    inputs : dict of str to shape
        ``gap`` (ny, nx), ``normal_force`` () or ``approach`` (), which was given, ``normal_layer`` (),
        ``normal_layer_field`` (ny, nx) and ``hardness`` () of a contact that has them, and those of a
        tangential problem without the pressure.
    refused : dict of str to str
        What else could be asked for, and why there is no derivative by it.
    margin : Margin
    """

    def __init__(
        self,
        normal: NormalTangent,
        tangential: TangentialTangent,
        opened: GapByTraction,
        traction: Array,
        added: dict[str, Array],
    ) -> None:
        self._normal, self._tangential, self._opened = normal, tangential, opened
        self._traction, self._added = traction, added
        self.fields = dict(tangential.fields)
        #: What presses, by the names of the normal contact and of this one.
        self._load, named = ("force", "normal_force") if "force" in normal.inputs else ("approach",) * 2
        given, other = ("normal force", "approach") if self._load == "force" else ("approach", "normal force")
        found = f"the pressure is found for the gap and the {given}: derive by 'gap' or '{named}'"
        held = f"the {given} is held, and the {other} is found: derive by 'gap' or '{named}'"
        self.refused = {**tangential.refused, "pressure": found, other.replace(" ", "_"): held}
        self.inputs: dict[str, Shape] = {"gap": opened.shape, named: ()}
        self._named = named
        self.inputs |= {name: normal.inputs[name] for name in _PRESSING if name in normal.inputs}
        self.inputs |= {name: shape for name, shape in tangential.inputs.items() if name != "pressure"}
        pressed, sheared = normal.margin, tangential.margin
        self.margin = replace(pressed, slipping=sheared.slipping, sticking=sheared.sticking)

    def _by_modulus(self, name: str) -> Array:
        """Gap (ny, nx) [m] that a unit of a modulus adds to what the tractions open."""
        if name not in self._added:
            self._added[name] = self._opened.moduli[name](self._traction)
        return self._added[name]

    def forward(self, changes: Mapping[str, Array]) -> dict[str, Array]:
        """Changes (k, *shape) of all fields by k changes (k, *shape) of inputs."""
        count = max(len(change) for change in changes.values())
        tangential, normal = self._tangential, self._normal
        given = {name: np.asarray(c, dtype=float) for name, c in changes.items()}
        none = np.zeros((count, *self._opened.shape))
        pressing = {_ROLLING.get(name, name): c for name, c in given.items() if name != "force"}
        pressing = {name: c for name, c in pressing.items() if name in normal.inputs}
        pressing[self._load] = given.get(self._named, np.zeros(count))
        pressing["gap"] = given.get("gap", none)
        for name in self._opened.moduli:
            if name in given:
                pressing["gap"] = pressing["gap"] + np.multiply.outer(given[name], self._by_modulus(name))
        shearing = {name: c for name, c in given.items() if name in tangential.inputs}
        shearing["pressure"] = none
        found: dict[str, Array] = {}
        for _ in range(_ROUNDS):
            added = tangential.forward(shearing)
            found = {name: found.get(name, 0.0) + value for name, value in added.items()}
            opened = np.stack([self._opened.of(traction) for traction in added["traction"]])
            pressing["gap"] = pressing.get("gap", 0.0) + opened
            pressure = normal.forward(pressing)["pressure"]
            if _is_small(pressure, found["pressure"] + pressure):
                found["pressure"] = found["pressure"] + pressure
                return found
            pressing, shearing = {}, {"pressure": pressure}
        raise _unsettled()

    def adjoint(self, weights: Mapping[str, Array]) -> Mapping[str, Array]:
        """Derivatives (k, *shape) of k functionals by each input, from their weights (k, *shape)."""
        sheared: list[Mapping[str, Array]] = []
        pressed: list[Mapping[str, Array]] = []
        whole: Any = 0.0
        asked = weights
        for _ in range(_ROUNDS):
            sheared.append(self._tangential.adjoint(asked))
            pressed.append(self._normal.adjoint({"pressure": sheared[-1]["pressure"]}))
            added = pressed[-1]["gap"]
            whole = whole + added
            if _is_small(added, whole):
                return Gradient(self.inputs, partial(self._by, sheared, pressed))
            asked = {"traction": np.stack([self._opened.back(row) for row in added])}
        raise _unsettled()

    def _by(self, sheared: list[Mapping[str, Array]], pressed: list[Mapping[str, Array]], name: str) -> Array:
        def sum_of(parts: list[Mapping[str, Array]], name: str) -> Array:
            return np.asarray(sum(part[name] for part in parts))

        if name == "gap" or name in _PRESSING:
            return sum_of(pressed, name)
        if name == self._named:
            return sum_of(pressed, self._load)
        by = sum_of(sheared, name)
        if name in self._opened.moduli:
            by = by + sum_of(pressed, _ROLLING.get(name, name))
            by = by + np.tensordot(sum_of(pressed, "gap"), self._by_modulus(name), 2)
        return by


def _is_small(added: Array, whole: Array) -> bool:
    """Whether the last change of each of k fields is nothing beside the whole of it."""
    rows = [np.abs(field).reshape(len(field), -1).max(axis=1) for field in (added, whole)]
    return bool((rows[0] <= _SETTLED * rows[1]).all())


def _unsettled() -> ValueError:
    return ValueError(
        f"the derivatives do not settle in {_ROUNDS} rounds of the linearised normal and tangential problem: "
        "coupling='one-way' has derivatives for the pressure given"
    )
