# SPDX-License-Identifier: MIT OR Apache-2.0
"""Derivatives of frictionless contacts of half-spaces."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from .. import _mtb_rs
from ..bodies.simple import Simple

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
    """

    def __init__(
        self,
        core: _mtb_rs.NormalTangent,
        shape: Shape,
        load: Literal["force", "approach"],
        moments: tuple[float | None, float | None],
        bodies: tuple[Simple, Simple],
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
        #: Products with the influence matrix so far.
        self.products = 0

    def forward(self, changes: Mapping[str, Array]) -> dict[str, Array]:
        """Changes of all fields by changes of inputs, of their shapes; what is left out does not change."""
        given = {name: np.asarray(changes.get(name, 0.0), dtype=float) for name in self.inputs}
        about_x, about_y = given.get("moments_about_axes", np.zeros(2))
        first = np.array([[about_y, -about_x]])
        if any(m is None and change != 0.0 for m, change in zip(self._moments, first[0], strict=True)):
            raise ValueError(
                "moments_about_axes changes about an axis whose tilt is locked: give a moment there first"
            )
        compliance = sum(float(given[name]) * slope for name, slope in self._moduli.items())
        pressure, gap, approach, tilts, products = self._core.forward(
            _one(given["gap"], self.fields["gap"]),
            np.array([float(given[self._load])]),
            first,
            np.array([compliance]),
        )
        self.products += products
        return {"pressure": pressure[0], "gap": gap[0], "approach": approach[0], "tilts": tilts[0]}

    def adjoint(self, weights: Mapping[str, Array]) -> dict[str, Array]:
        """Derivatives (k, *shape) of k functionals by each input, from their weights (k, *shape)."""
        count = max(np.shape(weight)[0] for weight in weights.values())
        all_weights = [
            np.ascontiguousarray(weights.get(name, np.zeros((count, *shape))), dtype=float)
            for name, shape in self.fields.items()
        ]
        gap, load, first, compliance, products = self._core.adjoint(*all_weights)
        self.products += products
        found = {"gap": gap, self._load: load, "moments_about_axes": np.stack([-first[:, 1], first[:, 0]], 1)}
        found |= {name: slope * compliance for name, slope in self._moduli.items()}
        return {name: found[name] for name in self.inputs}


def _one(change: Array, shape: Shape) -> Array:
    return np.ascontiguousarray(np.broadcast_to(change, shape)[None], dtype=float)


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
