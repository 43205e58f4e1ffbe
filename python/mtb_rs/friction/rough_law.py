# SPDX-License-Identifier: MIT OR Apache-2.0
"""Law by which a rough layer gives way: the distance of its mean planes over the pressure."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..base.check import positive, reals, shortened
from ..base.owning import frozen
from ..base.plain import plain
from .laws import InterfaceLayer

Array = NDArray[np.float64]


@dataclass(frozen=True)
@plain
class RoughLaw:
    """What a contact takes of a rough layer; :class:`mtb_rs.RoughLayer` is made of it.

    Attributes
    ----------
    gap : (k,) [m]
        Distances of the mean planes, falling from that of the first touch.
    pressure : (k,) [Pa]
        Mean pressures there, rising from 0.
    tangential_ratio : float or None [-]
        Tangential over normal stiffness; None: not known.
    is_exponential : bool
        Whether the law is the exponential through the two points of the table, and goes on beyond.
    """

    gap: Any
    pressure: Any
    tangential_ratio: float | None = None
    is_exponential: bool = False

    def __post_init__(self) -> None:
        put = object.__setattr__
        values = {
            name: reals(name, getattr(self, name), unit) for name, unit in (("gap", "m"), ("pressure", "Pa"))
        }
        for name, field in values.items():
            if field.ndim != 1 or field.size < 2:
                raise ValueError(
                    f"{name} is {shortened(getattr(self, name))}: a row of two numbers or more is needed"
                )
        gap, pressure = values["gap"], values["pressure"]
        if gap.size != pressure.size:
            raise ValueError(
                f"gap has {gap.size} entries and pressure {pressure.size}: equally many are needed"
            )
        if np.any(np.diff(gap) >= 0.0):
            raise ValueError(
                f"gap is {shortened(self.gap)}: distances [m] that fall from that of the first touch "
                "are needed"
            )
        if pressure[0] != 0.0 or np.any(np.diff(pressure) <= 0.0):
            raise ValueError(
                f"pressure is {shortened(self.pressure)}: pressures [Pa] that rise from 0, the first touch, "
                "are needed"
            )
        put(self, "gap", frozen(gap))
        put(self, "pressure", frozen(pressure))
        if self.tangential_ratio is not None:
            put(self, "tangential_ratio", positive("tangential_ratio", self.tangential_ratio))

    @property
    def height(self) -> float:
        """Distance of the mean planes at which the tips first touch [m]."""
        return float(self.gap[0])

    @property
    def _floor(self) -> float:
        """Pressure [Pa] above which the law is exponential from point to point."""
        if not self.is_exponential:
            return float(self.pressure[1])
        # p = floor (exp(u / length) - 1), with the length kept as the opening at p = (e - 1) floor
        return float(self.pressure[1] / np.expm1(1.0))

    @property
    def core(self) -> tuple[Any, Any]:
        """The law as the core takes it: length and floor, or openings and pressures."""
        if self.is_exponential:
            return float(self.gap[0] - self.gap[1]), self._floor
        return (self.gap[0] - self.gap).tolist(), self.pressure.tolist()

    def opening(self, pressure: Any) -> Array:
        """How far it gives way under pressures [Pa], from the first touch on [m].

        Raises
        ------
        ValueError
            For pressures below 0 or beyond the table.
        """
        p = reals("pressure", pressure, "Pa")
        last = np.inf if self.is_exponential else self.pressure[-1]
        wrong = (p < 0.0) | (p > last * (1.0 + 1e-9))
        if wrong.any():
            raise ValueError(
                f"pressure is {p[wrong].flat[0]:.6g} Pa: from 0 to {last:.6g} Pa the law is known"
            )
        level = np.log1p(p / self._floor)
        if self.is_exponential:
            return np.asarray((self.gap[0] - self.gap[1]) * level)
        nodes = np.log1p(self.pressure / self._floor)
        return np.asarray(np.interp(level, nodes, self.gap[0] - self.gap))

    def slopes(self, pressure: Any) -> dict[str, Array]:
        """How the opening under held pressures (...) [Pa] follows the numbers of the law.

        Returns
        -------
        dict
            ``normal_layer.gap`` (k, ...) [-] by the distances, ``normal_layer.pressure`` (k, ...) [m/Pa] by
            the pressures of the table. At a pressure of the table they are those of the piece above it.
        """
        p = reals("pressure", pressure, "Pa")
        gap, known, floor = self.gap, self.pressure, self._floor
        nodes = np.array([0.0, 1.0]) if self.is_exponential else np.log1p(known / floor)
        level = np.log1p(p / floor)
        piece = np.clip(np.searchsorted(nodes, level, side="right") - 1, 0, nodes.size - 2)
        width = np.diff(nodes)[piece]
        share, rate = (level - nodes[piece]) / width, -np.diff(gap)[piece] / width
        by_gap, by_node = np.zeros((2, nodes.size, *p.shape))
        by_gap[0] = 1.0
        for at, part in ((piece, 1.0 - share), (piece + 1, share)):
            each = np.arange(nodes.size).reshape(-1, *[1] * p.ndim) == at
            by_gap -= each * part
            by_node -= each * (rate * part)
        by_floor = -rate * p / (floor * (p + floor))
        if self.is_exponential:
            by_pressure = np.zeros_like(by_node)
            by_pressure[1] = by_floor / np.expm1(1.0)
        else:
            column = known.reshape(-1, *[1] * p.ndim)
            by_pressure = by_node / (column + floor)
            by_pressure[1] += by_floor - (by_node * column / (floor * (column + floor))).sum(axis=0)
        # the first pressure is 0, that of the first touch
        by_pressure[0] = 0.0
        return {"normal_layer.gap": by_gap, "normal_layer.pressure": by_pressure}

    def normal_stiffness(self, pressure: Any) -> Array:
        """Pressure by which the planes come nearer by a unit, at pressures [Pa]: [Pa/m].

        Raises
        ------
        ValueError
            As :meth:`opening`.
        """
        p = reals("pressure", pressure, "Pa")
        self.opening(p)
        if self.is_exponential:
            return np.asarray((p + self._floor) / (self.gap[0] - self.gap[1]))
        nodes = np.log1p(self.pressure / self._floor)
        piece = np.clip(np.searchsorted(self.pressure, p, side="right") - 1, 0, nodes.size - 2)
        rate = -np.diff(self.gap)[piece] / np.diff(nodes)[piece]
        return np.asarray((p + self._floor) / rate)

    def tangential_stiffness(self, pressure: Any) -> Array:
        """Traction by which the planes shear by a unit, at pressures [Pa], before points slip: [Pa/m].

        Raises
        ------
        ValueError
            As :meth:`opening`; if `tangential_ratio` is None.
        """
        if self.tangential_ratio is None:
            raise ValueError("tangential_ratio is None: the tangential over the normal stiffness is needed")
        return self.tangential_ratio * self.normal_stiffness(pressure)

    def interface_layer(self, pressure: float) -> InterfaceLayer:
        """The layer as shear springs at one pressure [Pa]: `layer` of scenes, rolling and shifts.

        Raises
        ------
        ValueError
            As :meth:`tangential_stiffness`.
        """
        stiffness = float(self.tangential_stiffness(positive("pressure", pressure, "Pa")))
        return InterfaceLayer(self.height, stiffness * self.height)
