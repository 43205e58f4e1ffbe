# SPDX-License-Identifier: MIT OR Apache-2.0
"""Derivatives of frictionless contacts of half-spaces."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from functools import partial
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from .. import _mtb_rs
from ..bodies.constants import refused_constants
from ..bodies.material import Material
from ..bodies.simple import FieldBody, are_compound, are_prisms
from ..results.derivatives import ROUGH, Gradient, Margin

Array = NDArray[np.float64]
Shape = tuple[int, ...]


@dataclass(frozen=True)
class Bodies:
    """What gives way in a contact.

    Attributes
    ----------
    lower, upper : HalfSpace, Layered, Viscoelastic, Prism or Rigid
    layer : float [m/Pa]
        Flexibility of the layer between them; 0 for none.
    flows : (ny, nx) bool or None
        Whether each cell is at the hardness; None where none was given.
    law : Mapping of name to (k, ny, nx)
        What each number of the law of a rough layer opens at the pressures of the state; empty without one.
    moved : Mapping of name to callable
        What a unit of each modulus opens (ny, nx) [m] at the pressures of the state, where a body is no
        half-space of one elastic material.
    made : dict of name to (ny, nx) [m]
        What of these has been asked for.
    """

    lower: FieldBody
    upper: FieldBody
    layer: float
    flows: NDArray[np.bool_] | None
    law: Mapping[str, Array] = field(default_factory=dict)
    moved: Mapping[str, Callable[[], Array]] = field(default_factory=dict)
    made: dict[str, Array] = field(default_factory=dict)


class NormalTangent:
    """What changes of a solved contact follow from changes of what was given, with the cells in contact held.

    `forward` is one linear solve, `adjoint` is one for each functional. Nothing is kept between them.

    Attributes
    ----------
    fields : dict of str to shape
        What is found: ``pressure`` and ``gap`` (ny, nx), ``approach`` (), ``tilts`` (2,), and with a hardness
        ``plastic_indentation`` (ny, nx).
    inputs : dict of str to shape
        What is given: ``gap`` (ny, nx), the initial one on the grid of the result; ``force`` () or
        ``approach`` (), ``moments_about_axes`` (2,) if one was given, ``normal_layer`` () and
        ``normal_layer_field`` (ny, nx) of a layer or the numbers of the law of a rough one, ``hardness`` ()
        if it was given, and ``lower.young_modulus``, ``lower.poisson_ratio`` and those of the upper body, for
        each that is elastic, with ``lower.creep`` and ``lower.creep_time`` of one that creeps, and
        ``rolling.velocity`` and ``rolling.angle`` of the contact over it.
    refused : dict of str to str
        What else could be asked for, and why there is no derivative by it.
    margin : Margin
    """

    def __init__(
        self,
        core: _mtb_rs.NormalTangent,
        shape: Shape,
        load: Literal["force", "approach"],
        moments: tuple[float | None, float | None],
        bodies: Bodies,
        margin: Margin,
    ) -> None:
        self._core = core
        self._load = load
        self._moments = moments
        self._shape = shape
        self._layer, self._flows, self._law = bodies.layer, bodies.flows, bodies.law
        self._moduli = dict(_moduli(bodies.lower, bodies.upper))
        self._moved, self._made = bodies.moved, bodies.made
        self.fields: dict[str, Shape] = {"pressure": shape, "gap": shape, "approach": (), "tilts": (2,)}
        self.inputs: dict[str, Shape] = {"gap": shape, load: ()}
        if moments != (None, None):
            self.inputs["moments_about_axes"] = (2,)
        if bodies.layer > 0.0:
            self.inputs |= {"normal_layer": (), "normal_layer_field": shape}
        self.inputs |= {name: (len(opened),) for name, opened in bodies.law.items()}
        if bodies.flows is not None:
            self.fields["plastic_indentation"] = shape
            self.inputs["hardness"] = ()
        self.inputs |= dict.fromkeys([*self._moduli, *self._moved], ())
        other = "approach" if load == "force" else "force"
        self.refused = {
            **refused_constants({"lower": bodies.lower, "upper": bodies.upper}),
            other: f"the {load} is given, and the {other} follows from it: derive by {load!r}",
        }
        if bodies.law:
            self.refused["normal_layer"] = ROUGH
        self.margin = margin
        #: Products with the influence matrix so far.
        self.products = 0

    def forward(self, changes: Mapping[str, Array]) -> dict[str, Array]:
        """Changes (k, *shape) of all fields by k changes (k, *shape) of inputs."""
        count = max(len(change) for change in changes.values())
        given = {
            name: np.ascontiguousarray(changes.get(name, np.zeros((count, *shape))), dtype=float)
            for name, shape in self.inputs.items()
        }
        none = np.zeros(count)
        about_x, about_y = given.get("moments_about_axes", np.zeros((count, 2))).T
        first = np.stack([about_y, -about_x], axis=1)
        # a locked tilt takes whatever moment there is
        first[:, [moment is None for moment in self._moments]] = 0.0
        compliance = np.zeros(count)
        for name, slope in self._moduli.items():
            compliance += slope * given[name]
        # the compliance of the core is that of bodies and layer: moduli leave the layer as it is
        own = given.get("normal_layer", none) - self._layer * compliance
        flexibility = np.zeros((count, *self._shape)) + own[:, None, None]
        if "normal_layer_field" in given:
            flexibility += given["normal_layer_field"]
        moved = given["gap"]
        for name, opened in self._law.items():
            moved = moved + np.tensordot(given[name], opened, 1)
        for name in self._moved:
            if given[name].any():
                moved = moved + np.multiply.outer(given[name], self._opened(name))
        pressure, gap, approach, tilts, products = self._core.forward(
            moved, given[self._load], first, compliance, flexibility, given.get("hardness", none)
        )
        self.products += products
        found = {"pressure": pressure, "gap": gap, "approach": approach, "tilts": tilts}
        if self._flows is not None:
            # what flows is behind the gap
            found["plastic_indentation"] = np.where(self._flows, -gap, 0.0)
            found["gap"] = np.where(self._flows, 0.0, gap)
        return found

    def _opened(self, name: str) -> Array:
        """Gap (ny, nx) [m] that a unit of a modulus opens at the pressures of the state."""
        if name not in self._made:
            self._made[name] = self._moved[name]()
        return self._made[name]

    def adjoint(self, weights: Mapping[str, Array]) -> Mapping[str, Array]:
        """Derivatives (k, *shape) of k functionals by each input, from their weights (k, *shape).

        They are 0 by a moment that is not given, as its tilt is locked.
        """
        count = max(len(weight) for weight in weights.values())
        of = {
            name: np.ascontiguousarray(weights.get(name, np.zeros((count, *shape))), dtype=float)
            for name, shape in self.fields.items()
        }
        if self._flows is not None:
            of["gap"] = np.where(self._flows, -of["plastic_indentation"], of["gap"])
        gap, load, first, compliance, flexibility, hardness, products = self._core.adjoint(
            of["pressure"], of["gap"], of["approach"], of["tilts"]
        )
        self.products += products
        own = flexibility.sum(axis=(1, 2))
        of_bodies = compliance - self._layer * own
        found = {"gap": gap, self._load: load, "moments_about_axes": np.stack([-first[:, 1], first[:, 0]], 1)}
        found |= {"normal_layer": own, "normal_layer_field": flexibility, "hardness": hardness}
        found |= {name: slope * of_bodies for name, slope in self._moduli.items()}
        for name, opened in self._law.items():
            found[name] = np.tensordot(gap, opened, ((1, 2), (1, 2)))
        return Gradient(self.inputs, partial(self._by, found))

    def _by(self, found: Mapping[str, Array], name: str) -> Array:
        if name in self._moved:
            return np.asarray(np.tensordot(found["gap"], self._opened(name), 2))
        return found[name]


def _moduli(lower: FieldBody, upper: FieldBody) -> Iterator[tuple[str, float]]:
    """Derivatives of the logarithm of the compliance, the sum of 2 (1 - nu^2) / E, by its constants."""
    if are_compound(lower, upper) or are_prisms(lower, upper):
        # moduli do not scale the whole compliance
        return
    whole = lower.normal_compliance + upper.normal_compliance
    for side, material in (("lower", lower.material), ("upper", upper.material)):
        if material is not None:
            for name, slope in of_constants(material).items():
                yield f"{side}.{name}", slope / whole


def of_constants(material: Material) -> dict[str, float]:
    """Derivatives of the compliance 2 (1 - nu^2) / E of a half-space by the constants of its material."""
    modulus, ratio = material.young_modulus, material.poisson_ratio
    return {
        "young_modulus": -2.0 * (1.0 - ratio**2) / modulus**2,
        "poisson_ratio": -4.0 * ratio / modulus,
    }
