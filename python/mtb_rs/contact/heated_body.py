# SPDX-License-Identifier: MIT OR Apache-2.0
"""Bodies of finite elements that conduct, store heat and expand by it, seen from their contact points."""

from __future__ import annotations

from abc import ABC, abstractmethod

import numpy as np
from numpy.typing import NDArray

from .. import _mtb_rs
from ..bodies.conductor import Conductor
from ..bodies.sides import ElasticPart
from .symmetry import alike

Array = NDArray[np.float64]
Index = NDArray[np.intp]

#: Relative change of a conductivity by its temperature below which it counts as the same.
SAME = 0.01
#: Steps of a whole body that are kept at a time.
KEPT = 12


class HeatedBody(ABC):
    """An upper body that conducts and expands.

    Parameters
    ----------
    part : ElasticPart
    conductor : Conductor
    film : (2,) [W/(m2 K)], [K]
        Coefficient and temperature outside, wherever its surface is no contact face.
    bulk : float [K]
        Temperature at the beginning.
    expands : bool

    Attributes
    ----------
    points : slice
        Its contact points in the scene.
    warm : (r,)
        What describes its temperature: that of the nodes [K], or amplitudes of modes.
    """

    warm: Array

    def __init__(
        self, part: ElasticPart, conductor: Conductor, film: tuple[float, float], bulk: float, expands: bool
    ) -> None:
        self.part, self.body, self.conductor, self.bulk = part, part.body, conductor, bulk
        self.film = film
        self.sampling = part.sampling()
        self.points = slice(part.first, part.first + self.sampling.n_points)
        self.nothing = np.zeros(self.sampling.n_points)
        self.expands = expands and conductor.expands
        #: What the last thing made of the part depends on.
        self._basis = [id(part.points), id(part.hats)]

    def _strained(self) -> Array:
        """Displacement of contact points by a strain of the nodes (n, N) [m]."""
        return self.part.memory.recall(
            "expansion", self._basis, lambda: self.body.core.expansion(self.sampling, 1.0)
        )

    def _conducting(self, conductivity: float) -> _mtb_rs.ConductingBody:
        contact = set(self.body.contact_faces.tolist())
        free = [k for k in range(len(self.body.faces)) if k not in contact]
        films = [(free, *self.film)] if self.film[0] else []
        constants = conductivity, *self.conductor.constants[1:]
        return _mtb_rs.ConductingBody(self.body.core_mesh, constants, films)

    @property
    def level(self) -> int:
        """The conductivity at the mean temperature, in parts of :data:`SAME` beyond that at zero."""
        slope = self.conductor.conductivity_slope
        if not slope:
            return 0
        mean = self.held(self.warm) / self.held(self.uniform(1.0))
        return round(slope * mean / self.conductor.conductivity / SAME)

    @property
    def slope(self) -> float:
        """Strain over temperature about the mean temperature of the contact face [1/K]."""
        conductor = self.conductor
        if not conductor.expansion_slope:
            return conductor.expansion
        weights = self.sampling.weights
        mean = float(weights @ self.surface(self.warm)) / float(weights.sum())
        return conductor.expansion + 2.0 * conductor.expansion_slope * mean

    @abstractmethod
    def uniform(self, temperature: float) -> Array:
        """What describes a uniform temperature [K]."""

    @abstractmethod
    def nodes(self) -> Array:
        """Temperatures (N,) [K] of its nodes."""

    @abstractmethod
    def held(self, warm: Array) -> float:
        """Heat [J]."""

    @abstractmethod
    def lost(self, warm: Array) -> float:
        """Heat flow [W] out of its film."""

    @abstractmethod
    def surface(self, warm: Array) -> Array:
        """Temperatures (n,) [K] of its contact points."""

    @abstractmethod
    def coasted(self, duration: float) -> Array:
        """Its temperature at the end of a step [s] without heat of friction."""

    @abstractmethod
    def warmed(self, duration: float, coasted: Array, flux: Array) -> Array:
        """The same with a flux (n,) [W/m2] into the contact points."""

    @abstractmethod
    def matrices(self, duration: float) -> tuple[Array, Array | None]:
        """Temperatures [K m2/W] (n, n) by unit fluxes, and what these open at a strain of one a kelvin."""

    @abstractmethod
    def opened(self, warm: Array) -> Array:
        """Opening (n,) [m], beyond that at the beginning."""


class WholeBody(HeatedBody):
    """A body with the temperatures of its nodes: for steps of one duration, which have one factor."""

    def __init__(
        self, part: ElasticPart, conductor: Conductor, film: tuple[float, float], bulk: float, expands: bool
    ) -> None:
        super().__init__(part, conductor, film, bulk, expands)
        self.warm = self.uniform(bulk)
        self._levels = {0: self._conducting(conductor.conductivity)}
        self._steps: dict[tuple[float, int], tuple[_mtb_rs.ConductionStep, Array | None]] = {}

    def _step(self, duration: float) -> tuple[_mtb_rs.ConductionStep, Array | None]:
        """A step at the present level, and if the body expands what unit fluxes do to the nodes (n, N)."""
        key = duration, self.level
        if key[1] not in self._levels:
            self._levels[key[1]] = self._conducting(self.conductor.conductivity * (1.0 + SAME * key[1]))
        if key not in self._steps:
            while len(self._steps) >= KEPT:
                self._steps.pop(next(iter(self._steps)))
            step = self._levels[key[1]].step(duration, self.sampling)
            self._steps[key] = step, step.nodes() if self.expands else None
        return self._steps[key]

    def uniform(self, temperature: float) -> Array:
        return np.full(len(self.body.mesh.nodes), temperature)

    def nodes(self) -> Array:
        return self.warm

    def held(self, warm: Array) -> float:
        # the same at each conductivity
        return self._levels[0].heat(warm)

    def lost(self, warm: Array) -> float:
        return self._levels[0].loss(warm)

    def surface(self, warm: Array) -> Array:
        step, _ = next(iter(self._steps.values()))
        return step.observe(warm)

    def coasted(self, duration: float) -> Array:
        return self._step(duration)[0].advance(self.warm, self.nothing)

    def warmed(self, duration: float, coasted: Array, flux: Array) -> Array:
        step, nodes = self._step(duration)
        return step.advance(self.warm, flux) if nodes is None else coasted + flux @ nodes

    def matrices(self, duration: float) -> tuple[Array, Array | None]:
        step, nodes = self._step(duration)
        return step.response, None if nodes is None else self._strained() @ nodes.T

    def opened(self, warm: Array) -> Array:
        strain = self.conductor.strain
        return np.asarray(self._strained() @ (strain(warm) - strain(self.bulk)))


class ReducedBody(HeatedBody):
    """A body with amplitudes of modes, in which steps of any duration are diagonal.

    The modes of `first`, a body like this one, serve for both where this one is its mirror image about y = 0.
    """

    def __init__(
        self,
        part: ElasticPart,
        conductor: Conductor,
        film: tuple[float, float],
        bulk: float,
        expands: bool,
        first: ReducedBody | None,
    ) -> None:
        super().__init__(part, conductor, film, bulk, expands)
        #: Contact points of the modes that are those of this body, where it is a mirror image.
        self._image = None if first is None else _image(first.part, part)

        def made() -> _mtb_rs.ConductionModes:
            if first is not None and self._image is not None:
                return first._modes[0]
            return self._conducting(conductor.conductivity).modes(self.sampling)

        given = [*self._basis, conductor.constants, film]
        modes = part.memory.recall("conduction", given, made)
        self._modes = {0: modes}
        self.warm = self.uniform(bulk)
        #: Displacement of contact points by a strain of the modes.
        self._seen: Array | None = None
        if self.expands:
            self._seen = part.memory.recall("expansion of modes", given, lambda: modes.seen(self._strained()))

    def _now(self) -> _mtb_rs.ConductionModes:
        """The modes at the conductivity of the present level."""
        level = self.level
        if level not in self._modes:
            conductivity = self.conductor.conductivity * (1.0 + SAME * level)
            self._modes[level] = self._modes[0].with_conductivity(conductivity)
        return self._modes[level]

    def _mirrored(self, values: Array) -> Array:
        """Values (n,) of the contact points for the modes; the mirror is its own inverse."""
        return np.ascontiguousarray(values if self._image is None else values[self._image])

    def uniform(self, temperature: float) -> Array:
        return self._modes[0].uniform(temperature)

    def nodes(self) -> Array:
        return self._modes[0].temperature(self.warm)

    def held(self, warm: Array) -> float:
        return self._modes[0].heat(warm)

    def lost(self, warm: Array) -> float:
        return self._modes[0].loss(warm)

    def surface(self, warm: Array) -> Array:
        return self._mirrored(self._modes[0].observe(warm))

    def coasted(self, duration: float) -> Array:
        return self._now().advance(duration, self.warm, self.nothing)

    def warmed(self, duration: float, coasted: Array, flux: Array) -> Array:
        return self._now().advance(duration, self.warm, self._mirrored(flux))

    def matrices(self, duration: float) -> tuple[Array, Array | None]:
        modes = self._now()
        response = modes.response(duration)
        opening = None if self._seen is None else modes.response_of(duration, self._seen)
        if self._image is not None:
            response = response[np.ix_(self._image, self._image)]
            opening = None if opening is None else opening[:, self._image]
        return response, opening

    def opened(self, warm: Array) -> Array:
        assert self._seen is not None
        conductor, modes = self.conductor, self._modes[0]
        if conductor.expansion_slope:
            strain = conductor.strain(modes.temperature(warm)) - conductor.strain(self.bulk)
            return np.asarray(self._strained() @ strain)
        return np.asarray(conductor.expansion * (self._seen @ (warm - modes.uniform(self.bulk))))


def _image(first: ElasticPart, part: ElasticPart) -> Index | None:
    """For each contact point of a part that of a first one of which it is the mirror image about y = 0.

    None where the parts are no mirror images of each other, node by node. Supports may differ.
    """
    mesh, mirrored = part.body.mesh, first.body.mesh.mirrored()
    if mesh.cells.shape != mirrored.cells.shape or not np.array_equal(mesh.cells, mirrored.cells):
        return None
    flip = np.array([[1.0], [-1.0], [1.0]])
    one, other = first.own_points().points * flip, part.own_points().points
    if not alike(mesh.nodes, mirrored.nodes) or one.shape != other.shape:
        return None
    if len(first.body.contact_faces) != len(part.body.contact_faces):
        return None
    order = [_sorted(points) for points in (one, other)]
    image = np.empty(other.shape[1], dtype=np.intp)
    image[order[1]] = order[0]
    weights = first.sampling().weights, part.sampling().weights
    if not (alike(one[:, image], other) and alike(weights[0][image], weights[1])):
        return None
    return image if (image[image] == np.arange(image.size)).all() else None


def _sorted(points: Array) -> Index:
    """Order of points (3, n) along x and y, whatever the rounding."""
    size = max(float(np.ptp(points)), 1e-300)
    grid = np.round(points[:2] / (1e-6 * size)).astype(np.int64)
    return np.lexsort(grid)
