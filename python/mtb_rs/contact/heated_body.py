# SPDX-License-Identifier: MIT OR Apache-2.0
"""Bodies of finite elements that conduct, store heat and expand by it, seen from their contact points."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable
from typing import NamedTuple

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


class _Once:
    """What mirror images compute alike, computed once: the last of each kind, by what it was made from."""

    def __init__(self) -> None:
        self._last: dict[str, tuple[tuple[float, ...], tuple[Array, ...], Array]] = {}

    def made(
        self, kind: str, numbers: tuple[float, ...], fields: tuple[Array, ...], make: Callable[[], Array]
    ) -> Array:
        """What `make` returns of these numbers and fields."""
        last = self._last.get(kind)
        if last is not None and last[0] == numbers and all(map(_same, last[1], fields)):
            return last[2]
        found = make()
        self._last[kind] = numbers, fields, found
        return found


def _same(one: Array, other: Array) -> bool:
    return one is other or np.array_equal(one, other)


class HeatedBody(ABC):
    """An upper body that conducts and expands.

    A body that is the mirror image about y = 0 of a `first` one, node by node, shares with it what conducts.
    As long as their temperatures are mirror images too, one of them is computed for both.

    Parameters
    ----------
    part : ElasticPart
    conductor : Conductor
    film : (2,) [W/(m2 K)], [K]
        Coefficient and temperature outside, wherever its surface is no contact face.
    bulk : float [K]
        Temperature at the beginning.
    expands : bool
    first : HeatedBody, optional

    Attributes
    ----------
    points : slice
        Its contact points in the scene.
    warm : (r,)
        What describes its temperature: that of the nodes [K], or amplitudes of modes.
    """

    warm: Array

    def __init__(
        self,
        part: ElasticPart,
        conductor: Conductor,
        film: tuple[float, float],
        bulk: float,
        expands: bool,
        first: HeatedBody | None,
    ) -> None:
        self.part, self.body, self.conductor, self.bulk = part, part.body, conductor, bulk
        self.film = film
        self.sampling = part.sampling()
        self.points = slice(part.first, part.first + self.sampling.n_points)
        self.nothing = np.zeros(self.sampling.n_points)
        self.expands = expands and conductor.expands
        #: What the last thing made of the part depends on.
        self._basis = [id(part.points), id(part.hats)]
        image = None if first is None else _image(first.part, part)
        #: The body whose mirror image this one is, and the contact points there that are those of this one.
        self._first = None if image is None else first
        self._image = image
        self._once: _Once = _Once() if self._first is None else self._first._once
        self._opens_alike = False
        if self._first is not None and self.expands:
            self._opens_alike = alike(self._strained(), self._first._strained()[image])

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

    def _mirrored(self, values: Array) -> Array:
        """Values (n,) of the contact points for what conducts; the mirror is its own inverse."""
        return np.ascontiguousarray(values if self._image is None else values[self._image])

    def held(self, warm: Array) -> float:
        """Heat [J]."""
        return float(self._once.made("held", (), (warm,), lambda: np.array(self._held(warm))))

    def lost(self, warm: Array) -> float:
        """Heat flow [W] out of its film."""
        return float(self._once.made("lost", (), (warm,), lambda: np.array(self._lost(warm))))

    def surface(self, warm: Array) -> Array:
        """Temperatures (n,) [K] of its contact points."""
        return self._mirrored(self._once.made("surface", (), (warm,), lambda: self._surface(warm)))

    def coasted(self, duration: float) -> Array:
        """What describes a step [s] without heat of friction."""
        return self._once.made("coasted", (duration,), (self.warm,), lambda: self._coasted(duration))

    def surface_coasted(self, duration: float, coasted: Array) -> Array:
        """Temperatures (n,) [K] of its contact points at the end of that."""

        def seen() -> Array:
            return self._surface_coasted(duration, coasted)

        return self._mirrored(self._once.made("surface coasted", (duration,), (coasted,), seen))

    def opened_coasted(self, duration: float, coasted: Array) -> Array:
        """Opening (n,) [m] by then, beyond that at the beginning."""
        if self._opens_alike and self._first is not None:
            return self._mirrored(self._first.opened_coasted(duration, coasted))
        if self._first is not None:
            return self._opened_coasted(duration, coasted)
        return self._once.made(
            "opened coasted", (duration,), (coasted,), lambda: self._opened_coasted(duration, coasted)
        )

    def warmed(self, duration: float, coasted: Array, flux: Array) -> Array:
        """Its temperature at the end of the step with a flux (n,) [W/m2] into the contact points."""
        entered = self._mirrored(flux)
        fields = coasted, entered
        return self._once.made(
            "warmed", (duration,), fields, lambda: self._warmed(duration, coasted, entered)
        )

    @abstractmethod
    def uniform(self, temperature: float) -> Array:
        """What describes a uniform temperature [K]."""

    @abstractmethod
    def nodes(self) -> Array:
        """Temperatures (N,) [K] of its nodes."""

    @abstractmethod
    def matrices(self, duration: float) -> tuple[Array, Array | None]:
        """Temperatures [K m2/W] (n, n) by unit fluxes, and what these open at a strain of one a kelvin."""

    @abstractmethod
    def _held(self, warm: Array) -> float: ...

    @abstractmethod
    def _lost(self, warm: Array) -> float: ...

    @abstractmethod
    def _surface(self, warm: Array) -> Array:
        """Temperatures of the contact points as those of the first body are numbered."""

    @abstractmethod
    def _coasted(self, duration: float) -> Array: ...

    @abstractmethod
    def _surface_coasted(self, duration: float, coasted: Array) -> Array:
        """As the contact points of the first body are numbered."""

    @abstractmethod
    def _warmed(self, duration: float, coasted: Array, flux: Array) -> Array:
        """With a flux as the contact points of the first body are numbered."""

    @abstractmethod
    def _opened_coasted(self, duration: float, coasted: Array) -> Array: ...


class _WholeStep(NamedTuple):
    """A step of one duration; of a body that expands, what a strain of its end opens."""

    step: _mtb_rs.ConductionStep
    seen: _mtb_rs.Seen | None


class WholeBody(HeatedBody):
    """A body with the temperatures of its nodes: for steps of one duration, which have one factor."""

    def __init__(
        self,
        part: ElasticPart,
        conductor: Conductor,
        film: tuple[float, float],
        bulk: float,
        expands: bool,
        first: HeatedBody | None,
    ) -> None:
        super().__init__(part, conductor, film, bulk, expands, first)
        self.warm = self.uniform(bulk)
        self._steps: dict[tuple[float, int], _WholeStep] = {}
        self._own_seen: dict[tuple[float, int], _mtb_rs.Seen] = {}
        #: What a strain opens that is the same everywhere.
        self._uniformly = self._strained().sum(axis=1) if self.expands else self.nothing
        self._levels: dict[int, _mtb_rs.ConductingBody]
        if isinstance(self._first, WholeBody):
            self._levels, self._steps = self._first._levels, self._first._steps
        else:
            self._levels = {0: self._conducting(conductor.conductivity)}

    def _step(self, duration: float) -> _WholeStep:
        """A step at the present level, of the first body."""
        key = duration, self.level
        if key[1] not in self._levels:
            self._levels[key[1]] = self._conducting(self.conductor.conductivity * (1.0 + SAME * key[1]))
        if key not in self._steps:
            while len(self._steps) >= KEPT:
                self._steps.pop(next(iter(self._steps)))
            first = self if self._first is None else self._first
            step = self._levels[key[1]].step(duration, first.sampling)
            self._steps[key] = _WholeStep(step, step.seen(first._strained()) if self.expands else None)
        return self._steps[key]

    def _seen(self, duration: float) -> _mtb_rs.Seen | None:
        """What a strain of the end of a step opens at its own contact points."""
        step, seen = self._step(duration)
        if seen is None or self._first is None or self._opens_alike:
            return seen
        key = duration, self.level
        if key not in self._own_seen:
            self._own_seen = {key: step.seen(self._strained())}
        return self._own_seen[key]

    def uniform(self, temperature: float) -> Array:
        return np.full(len(self.body.mesh.nodes), temperature)

    def nodes(self) -> Array:
        return self.warm

    def _held(self, warm: Array) -> float:
        # the same at each conductivity
        return self._levels[0].heat(warm)

    def _lost(self, warm: Array) -> float:
        return self._levels[0].loss(warm)

    def _surface(self, warm: Array) -> Array:
        return next(iter(self._steps.values())).step.observe(warm)

    def _coasted(self, duration: float) -> Array:
        return self._step(duration).step.coast(self.warm)

    def _surface_coasted(self, duration: float, coasted: Array) -> Array:
        return self._step(duration).step.observe_coasted(coasted)

    def _warmed(self, duration: float, coasted: Array, flux: Array) -> Array:
        return self._step(duration).step.end(coasted, flux)

    def matrices(self, duration: float) -> tuple[Array, Array | None]:
        step = self._step(duration).step
        response, seen = step.response, self._seen(duration)
        opening = None if seen is None else step.response_of(seen)
        if self._image is not None:
            response = response[np.ix_(self._image, self._image)]
            if opening is not None:
                rows = self._image if self._opens_alike else np.arange(self._image.size)
                opening = opening[np.ix_(rows, self._image)]
        return response, opening

    def _opened_coasted(self, duration: float, coasted: Array) -> Array:
        conductor = self.conductor
        if conductor.expansion_slope:
            warm = self._step(duration).step.end(coasted, self.nothing)
            return np.asarray(self._strained() @ (conductor.strain(warm) - conductor.strain(self.bulk)))
        seen = self._seen(duration)
        assert seen is not None
        opened = self._step(duration).step.seen_coasted(seen, coasted)
        return np.asarray(conductor.expansion * (opened - self.bulk * self._uniformly))


class ReducedBody(HeatedBody):
    """A body with amplitudes of modes, in which steps of any duration are diagonal."""

    def __init__(
        self,
        part: ElasticPart,
        conductor: Conductor,
        film: tuple[float, float],
        bulk: float,
        expands: bool,
        first: HeatedBody | None,
    ) -> None:
        super().__init__(part, conductor, film, bulk, expands, first)

        def made() -> _mtb_rs.ConductionModes:
            if isinstance(self._first, ReducedBody):
                return self._first._modes[0]
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

    def uniform(self, temperature: float) -> Array:
        return self._modes[0].uniform(temperature)

    def nodes(self) -> Array:
        return self._modes[0].temperature(self.warm)

    def _held(self, warm: Array) -> float:
        return self._modes[0].heat(warm)

    def _lost(self, warm: Array) -> float:
        return self._modes[0].loss(warm)

    def _surface(self, warm: Array) -> Array:
        return self._modes[0].observe(warm)

    def _coasted(self, duration: float) -> Array:
        return self._now().advance(duration, self.warm, self.nothing)

    def _surface_coasted(self, duration: float, coasted: Array) -> Array:
        return self._surface(coasted)

    def _warmed(self, duration: float, coasted: Array, flux: Array) -> Array:
        return self._now().advance(duration, self.warm, flux)

    def matrices(self, duration: float) -> tuple[Array, Array | None]:
        modes = self._now()
        response = modes.response(duration)
        opening = None if self._seen is None else modes.response_of(duration, self._seen)
        if self._image is not None:
            response = response[np.ix_(self._image, self._image)]
            opening = None if opening is None else opening[:, self._image]
        return response, opening

    def _opened_coasted(self, duration: float, coasted: Array) -> Array:
        assert self._seen is not None
        conductor, modes = self.conductor, self._modes[0]
        if conductor.expansion_slope:
            strain = conductor.strain(modes.temperature(coasted)) - conductor.strain(self.bulk)
            return np.asarray(self._strained() @ strain)
        return np.asarray(conductor.expansion * (self._seen @ (coasted - modes.uniform(self.bulk))))


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
