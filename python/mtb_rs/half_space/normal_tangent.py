# SPDX-License-Identifier: MIT OR Apache-2.0
"""Derivatives of frictionless contacts of half-spaces."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from .. import _mtb_rs
from ..bodies.simple import Simple
from ..results.derivatives import Margin

Array = NDArray[np.float64]
Shape = tuple[int, ...]


class NormalTangent:
    """What changes of a solved contact follow from changes of what was given, with the cells in contact held.

    `forward` is one linear solve, `adjoint` is one for each functional. Nothing is kept between them.

    Attributes
    ----------
    fields : dict of str to shape
        What is found: ``pressure`` and ``gap`` (ny, nx), ``approach`` (), ``tilts`` (2,).
    inputs : dict of str to shape
        What is given: ``gap`` (ny, nx), the initial one on the grid of the result; ``force`` () or
        ``approach`` (), ``moments_about_axes`` (2,) if one was given, and ``lower.young_modulus``,
        ``lower.poisson_ratio`` and those of the upper body, for each that is elastic.
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
        bodies: tuple[Simple, Simple],
        margin: Margin,
    ) -> None:
        self._core = core
        self._load = load
        self._moments = moments
        self._moduli = dict(_moduli(*bodies))
        self.fields: dict[str, Shape] = {"pressure": shape, "gap": shape, "approach": (), "tilts": (2,)}
        self.inputs: dict[str, Shape] = {"gap": shape, load: ()}
        if moments != (None, None):
            self.inputs["moments_about_axes"] = (2,)
        self.inputs |= dict.fromkeys(self._moduli, ())
        other = "approach" if load == "force" else "force"
        self.refused = {other: f"the {load} is given, and the {other} follows from it: derive by {load!r}"}
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
        about_x, about_y = given.get("moments_about_axes", np.zeros((count, 2))).T
        first = np.stack([about_y, -about_x], axis=1)
        locked = [moment is None for moment in self._moments]
        if first[:, locked].any():
            raise ValueError(
                "moments_about_axes changes about an axis whose tilt is locked: give a moment there first"
            )
        compliance = np.zeros(count)
        for name, slope in self._moduli.items():
            compliance += slope * given[name]
        pressure, gap, approach, tilts, products = self._core.forward(
            given["gap"], given[self._load], first, compliance
        )
        self.products += products
        return {"pressure": pressure, "gap": gap, "approach": approach, "tilts": tilts}

    def adjoint(self, weights: Mapping[str, Array]) -> dict[str, Array]:
        """Derivatives (k, *shape) of k functionals by each input, from their weights (k, *shape).

        They are 0 by a moment that is not given, as its tilt is locked.
        """
        count = max(len(weight) for weight in weights.values())
        all_weights = [
            np.ascontiguousarray(weights.get(name, np.zeros((count, *shape))), dtype=float)
            for name, shape in self.fields.items()
        ]
        gap, load, first, compliance, products = self._core.adjoint(*all_weights)
        self.products += products
        found = {"gap": gap, self._load: load, "moments_about_axes": np.stack([-first[:, 1], first[:, 0]], 1)}
        found |= {name: slope * compliance for name, slope in self._moduli.items()}
        return {name: found[name] for name in self.inputs}


def _moduli(lower: Simple, upper: Simple) -> list[tuple[str, float]]:
    """Derivatives of the logarithm of the compliance, the sum of 2 (1 - nu^2) / E, by its constants."""
    whole = lower.normal_compliance + upper.normal_compliance
    slopes = []
    for side, material in (("lower", lower.material), ("upper", upper.material)):
        if material is not None:
            modulus, ratio = material.young_modulus, material.poisson_ratio
            slopes += [
                (f"{side}.young_modulus", -2.0 * (1.0 - ratio**2) / (modulus**2 * whole)),
                (f"{side}.poisson_ratio", -4.0 * ratio / (modulus * whole)),
            ]
    return slopes
