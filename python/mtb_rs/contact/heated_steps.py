# SPDX-License-Identifier: MIT OR Apache-2.0
"""Implicit steps of bodies that slide, heat each other, expand and wear: one contact problem a step."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from .. import _mtb_rs
from ..bodies.conductor import Conductor
from ..friction.wear_laws import Rubbing, WearLaw, check_worn, coefficients_of
from ..results.plausible import SMALL, height_of
from .heated_body import KEPT, SAME, HeatedBody, ReducedBody, WholeBody
from .problem import ContactProblem, along_surface, mean_tractions, sliding_tractions
from .symmetry import alike, mirror_symmetry

Array = NDArray[np.float64]
Kept = dict[str, list[float]]

#: Change of a factor on the friction that counts as none, turns after which it must have settled, and those
#: through which secants are laid.
FADED, MOST_FADINGS, FADINGS = 1e-10, 60, 8
#: Speeds of a table of the heat of the lower body, to twice the speed.
SPEEDS = 4


@dataclass(frozen=True)
class Heated:
    """What is said of heat and wear, checked: lower body first where there are two numbers.

    `poisson` is Poisson's ratio of the lower body; None where it does not expand.
    """

    lower: Conductor
    upper: Conductor
    bulk: tuple[float, float]
    film: tuple[float, float]
    resistance: float
    share: float
    expands: bool = False
    poisson: float | None = None
    wear: WearLaw | None = None
    lower_wear: WearLaw | None = None
    fading: tuple[Array, Array] | None = None

    def faded(self, temperature: Array) -> Array:
        """Factor (n,) on the friction at temperatures (n,) [K] of the surfaces."""
        if self.fading is None:
            return np.ones(temperature.size)
        return np.interp(temperature, *self.fading)


def _rectangles(problem: ContactProblem) -> tuple[Array, Array]:
    """Centres and sizes (n, 2) [m] of the rectangles that the contact points stand for, along x and y."""
    count = sum(patch.nx * patch.ny for patch in problem.patches)
    lengths, ends = np.empty(count), np.zeros((count, 2))
    for patch in problem.patches:
        length, end = np.full((patch.ny, patch.nx), patch.spacing[0]), np.zeros((patch.ny, patch.nx, 2))
        if problem.averages is not None:
            # hats at the ends of columns and rows reach inwards only
            if patch.nx > 1:
                length[:, [0, -1]] *= 0.5
                end[:, 0, 0], end[:, -1, 0] = 1.0, -1.0
            if patch.ny > 1:
                end[0, :, 1], end[-1, :, 1] = 1.0, -1.0
        lengths[patch.cut], ends[patch.cut] = length.ravel(), end.reshape(-1, 2)
    if problem.kept is not None:
        lengths, ends = lengths[problem.kept.numbers], ends[problem.kept.numbers]
    sizes = np.stack([lengths, problem.area / lengths], axis=1)
    return problem.points.points[:2].T @ _turn(problem) + 0.5 * ends * sizes, sizes


def _turn(problem: ContactProblem) -> Array:
    """Columns are the directions of the rows and columns of the contact points, seen from above (2, 2)."""
    cos, sin = problem.geometry.tangents[0][:2].mean(axis=1)
    length = np.hypot(cos, sin)
    return np.asarray(np.array([[cos, -sin], [sin, cos]]) / length)


def _sliding_way(problem: ContactProblem) -> Array:
    """Unit vector (2,) along which the upper body slides in the track, seen from above.

    A direction in a tangent plane is that of the body less its part along the normal.
    """
    tangents = np.asarray(problem.geometry.tangents)
    slides = np.einsum("kcn,kn->cn", tangents, problem.direction)
    normal = np.cross(tangents[0], tangents[1], axis=0)
    level = slides - (slides[2] / normal[2]) * normal
    way = (level[:2] / np.linalg.norm(level[:2], axis=0)) @ problem.area
    return np.asarray(way / np.linalg.norm(way))


#: Equal steps for each contact point above which modes cost less than substitutions: 17 to 48 for
#: pole shoes of 18 to 186 points a pole.
WORTH = 30


#: Relative change of the speed over a passage of what counts as one.
ALIKE = 0.05
#: Parts of the contact's length, along the way, in which the heat of earlier steps is kept apart: shorter
#: steps are kept as one where together they last no longer than this share of their age.
LAGS, GRADED = 16, 0.5


class Passed(NamedTuple):
    """What passes in a step: its duration [s], its way [m], and the level of the conductivity and the
    expansion [1/K] of the lower body.
    """

    duration: float
    way: float
    level: int
    expansion: float


@dataclass(frozen=True)
class Fold:
    """How fields that are their own mirror image are those of some points alone.

    Attributes
    ----------
    kept, image : (m,) int
        These points, and their images.
    """

    kept: NDArray[np.intp]
    image: NDArray[np.intp]

    def __call__(self, matrix: Array) -> Array:
        """A matrix (n, n) of the whole on such fields (m, m)."""
        rows = matrix[self.kept]
        mirrored = np.where(self.image == self.kept, 0.0, rows[:, self.image])
        return np.ascontiguousarray(rows[:, self.kept] + mirrored)


class Means:
    """What makes means over the contact points of the coefficients of hats.

    A row has few entries, so that products go over these: a dense one would take more time.

    Parameters
    ----------
    matrix : (n, n)
    """

    def __init__(self, matrix: Array) -> None:
        self.matrix = matrix
        self._rows, self._columns = self._entries(matrix), self._entries(matrix.T)

    @staticmethod
    def _entries(matrix: Array) -> list[tuple[NDArray[np.intp], Array]]:
        """Of each row the first entry, then the second, and so on: places and numbers (n,)."""
        most = int((matrix != 0.0).sum(axis=1).max(initial=0))
        places = np.argsort(matrix == 0.0, axis=1, kind="stable")[:, :most]
        numbers = np.take_along_axis(matrix, places, axis=1)
        return [
            (np.ascontiguousarray(p), np.ascontiguousarray(v))
            for p, v in zip(places.T, numbers.T, strict=True)
        ]

    @staticmethod
    def _product(entries: list[tuple[NDArray[np.intp], Array]], rows: Array) -> Array:
        weights = (slice(None), *(None,) * (rows.ndim - 1))
        return np.asarray(sum(number[weights] * rows[place] for place, number in entries))

    def __call__(self, fields: Array) -> Array:
        """Means (n, ...) of fields (n, ...)."""
        return self._product(self._rows, fields)

    def of_matrix(self, matrix: Array) -> Array:
        """A matrix (n, n) that takes coefficients and gives what is seen in their means."""
        seen = np.ascontiguousarray(self(matrix).T)
        return np.ascontiguousarray(self._product(self._columns, seen).T)


@dataclass(frozen=True)
class Ahead:
    """How far ahead the flux into each point is met.

    Attributes
    ----------
    near, far : (s, n) [sqrt(m)]
        Roots of the distances from which and up to which the flux into each point is met at each station, one
        of the places along the way.
    row : (n,) int
        The station of each point.
    """

    near: Array
    far: Array
    row: NDArray[np.intp]

    @staticmethod
    def mean_of(edges: Array, measure: Array, flux: Array, near: Array, far: Array) -> Array:
        """Sums of fluxes (k, n) times a measure (k,) from `near` to `far` (s, n), over `far - near`.

        Each flux lies evenly between an edge (k + 1) and the next, or at both where they are one.
        """
        gains, widths = measure[:, None] * flux, np.diff(edges)[:, None]
        none = np.zeros_like(flux[:1])
        slopes = np.divide(gains, widths, out=np.zeros_like(gains), where=widths > 0.0)
        slopes = np.concatenate([slopes, none])
        before = np.concatenate([none, np.cumsum(gains, axis=0)])
        column = np.arange(flux.shape[1])

        def up_to(end: Array) -> Array:
            part = np.searchsorted(edges[1:], end)
            inner = np.maximum(end - edges[part], 0.0)
            return np.asarray(before[part, column] + inner * slopes[part, column])

        return np.asarray((up_to(far) - up_to(near)) / (far - near))


class Passing:
    """The lower body, which passes below the contact and comes back cold.

    Heat enters it as the mean of the flux over each contact point, whose basis may be hats, and what it does
    is seen in their mean.
    """

    def __init__(self, problem: ContactProblem, heated: Heated) -> None:
        #: Unit vectors (2,) along which the upper body slides: in the track, and along the rows and columns.
        self.along = _sliding_way(problem)
        self.way = self.along @ _turn(problem)
        self.places, self.sizes = _rectangles(problem)
        self.heated = heated
        along, half = self.places @ self.way, 0.5 * (self.sizes @ np.abs(self.way))
        self.length = float((along + half).max() - (along - half).min())
        conductivity, density, specific_heat = self._conducting(0)
        self._diffusivity = conductivity / (density * specific_heat)
        #: Ways [m] and durations [s] of earlier steps and the heat (n,) [W/m2] that entered in them, the last
        #: one first, as far back as what they heated is still below the contact.
        self.heated_before: list[tuple[float, float, Array]] = []
        self._last: tuple[Any, Array] | None = None
        self._table: dict[tuple[int, int, bool], Array] = {}
        self._risen: dict[bool, Array] = {}
        self._ranges: dict[bool, Ahead] = {}
        self._means: Means | None = None
        if problem.averages is not None:
            averages = problem.averages
            rows = np.repeat(np.arange(problem.n), np.diff(averages.start).astype(np.intp))
            # what lies on the rectangle of each point, where the shares are weighted by its own hat: exact
            # along a line, and of a swing in two directions 2 % are missed
            shares = 0.25 * np.eye(problem.n)
            np.add.at(shares, (rows, averages.column.astype(np.intp)), 0.75 * averages.share)
            self._means = Means(shares)
        self._folded_means: Means | None = None

    def share_table(self, other: Passing) -> None:
        """Takes what another passage below the same contact points computes."""
        self._table = other._table

    def _spread(self, time: Any) -> Any:
        """Distance [m] as far as heat spreads without motion in a time [s]."""
        return 2.0 * np.sqrt(self._diffusivity * time)

    def keep(self, way: float, duration: float, flux: Array) -> None:
        """Keeps the heat (n,) [W/m2] that has entered in a step."""
        before, most = self.heated_before, self.length / LAGS
        # what is still below the contact, in parts whose heat is of about one age
        share = min(1.0, self.length / way) if way > 0.0 else 1.0
        # the way over the length: their products, rounded, could make one part more
        parts = max(1, int(np.ceil(LAGS * min(1.0, way / self.length))))
        before[:0] = [(share * way / parts, share * duration / parts, flux)] * parts
        k, start, gone = 0, 0.0, 0.0
        while k < len(before):
            way, duration, flux = before[k]
            end = start + duration
            if k + 1 < len(before):
                earlier, longer, other = before[k + 1]
                both = duration + longer
                is_near = way + earlier <= most and self._spread(end + longer) - self._spread(start) <= most
                if is_near and both <= GRADED * start:
                    before[k : k + 2] = [(way + earlier, both, (duration * flux + longer * other) / both)]
                    continue
            k, start, gone = k + 1, end, gone + way
            if max(gone, self._spread(end)) >= self.length:
                del before[k:]

    def carried(self, passed: Passed, fold: Fold | None = None) -> tuple[Array, Array] | None:
        """Temperatures [K] and openings [m] by heat of earlier steps, where some of it is below the contact.

        At all points, or with a `fold` at those that it keeps. Heat of a particle is as old as it says: of
        what has moved farther than heat spreads in its age the temperature falls with the root of that, and
        all else is what has been there at rest for so long, less what would have been without that heat.
        """
        if not self.heated_before or max(passed.way, self._spread(passed.duration)) >= self.length:
            return None
        ways, durations, fluxes = zip(*self.heated_before, strict=True)
        gone, age = passed.way + np.cumsum([0.0, *ways]), passed.duration + np.cumsum([0.0, *durations])
        reach = np.maximum(gone, self._spread(age))
        flux = np.array(fluxes)[:, slice(None) if fold is None else fold.kept]
        means = self._mean(fold)
        flux = flux if means is None else means(flux.T).T
        ahead = self._range(fold)
        warm = np.zeros(len(ahead.row))
        is_at_rest = gone[1:] < reach[1:]
        rested: dict[int, Array] = {}
        for k in np.flatnonzero(is_at_rest).tolist():
            for end in (k, k + 1):
                if end not in rested:
                    spread = float(self._spread(age[end]))
                    rested[end] = self._within(float(age[end]), spread, passed.level, fold)
            # the next part begins where this one ends
            warm += (rested[k + 1] - rested.pop(k)) @ flux[k]
        speed, measure, roots = reach / age, np.diff(np.sqrt(age)), np.sqrt(reach)
        first, moved = 0, ~is_at_rest
        while first < len(flux):
            # parts of about one speed
            others = np.flatnonzero(np.abs(speed[first + 1 :] / speed[first] - 1.0) > ALIKE)
            last = first + max(int(others[0]), 1) if others.size else len(flux)
            of_these = slice(first, last)
            if moved[of_these].any():
                edges, parts = roots[first : last + 1], measure[of_these] * moved[of_these]
                mean = ahead.mean_of(edges, parts, flux[of_these], ahead.near, ahead.far)
                response = self._whole(float(speed[first]), passed.level, fold)
                warm += np.sqrt(speed[first]) * np.einsum("ij,ij->i", response, mean[ahead.row])
            first = last
        risen, opened = self._swelling(passed, fold), np.zeros(len(warm))
        if risen is not None:
            mean = ahead.mean_of(gone, np.diff(age), flux, ahead.near**2, ahead.far**2)
            opened = np.einsum("ij,ij->i", risen, mean[ahead.row])
        return (warm, opened) if means is None else (means(warm), means(opened))

    def of(self, duration: float, way: float, warmer: float) -> Passed:
        """What :meth:`at` needs to know, where the mean temperature of the surface is `warmer` [K]."""
        lower = self.heated.lower
        level = round(lower.conductivity_slope * warmer / lower.conductivity / SAME)
        # it comes cold: the strain of what is warm, over its temperature
        expansion = lower.expansion + lower.expansion_slope * (warmer + self.heated.bulk[0])
        return Passed(duration, way, level, expansion)

    def at(self, passed: Passed, fold: Fold | None = None) -> tuple[Array, Array | None]:
        """Temperatures [K m2/W] and openings [m3/W] (n, n) by a unit flux into each point over a step.

        With a `fold` as that makes them.
        """
        duration, way = passed.duration, passed.way
        response = self._within(duration, max(way, float(self._spread(duration))), passed.level, fold)
        risen = self._swelling(passed, fold)
        if risen is not None:
            ahead = self._range(fold)
            unit = np.ones((1, len(ahead.row)))
            edges, measure = np.array([0.0, way]), np.array([duration])
            met = ahead.mean_of(edges, measure, unit, ahead.near**2, ahead.far**2)
            risen = risen * met[ahead.row]
        means = self._mean(fold)
        if means is not None:
            response = means.of_matrix(response)
            risen = None if risen is None else means.of_matrix(risen)
        return response, risen

    def _mean(self, fold: Fold | None) -> Means | None:
        """What makes means over the points of coefficients; None where they are these themselves."""
        if fold is None or self._means is None:
            return self._means
        if self._folded_means is None:
            self._folded_means = Means(fold(self._means.matrix))
        return self._folded_means

    def _within(self, time: float, reach: float, level: int, fold: Fold | None) -> Array:
        """Temperatures [K m2/W] (n, n) by a unit flux into each point for a time [s] with a reach [m].

        Of each flux the part that comes from within it, as in fast motion, whose kernel is `1/sqrt(distance)`
        ahead and nothing behind.
        """
        response = self._whole(reach / time, level, fold)
        if reach >= self.length:
            return response
        ahead = self._range(fold)
        met = np.clip(np.sqrt(reach), ahead.near, ahead.far)
        return np.asarray(response * ((met - ahead.near) / (ahead.far - ahead.near))[ahead.row])

    def _whole(self, speed: float, level: int, fold: Fold | None) -> Array:
        """The same by all that lies ahead, at a speed [m/s].

        Between the speeds of a table the temperature times the root of the speed, which hardly changes, is
        quadratic over the logarithm of the speed.
        """
        # times that are added up differ by rounding, which makes no other speed
        key = float(f"{speed:.12g}"), level, fold is not None
        if self._last is None or self._last[0] != key:
            place = SPEEDS * np.log2(speed)
            first = round(place) - 1
            s = place - first - 1.0
            weights = 0.5 * s * (s - 1.0), 1.0 - s * s, 0.5 * s * (s + 1.0)
            factors = weights * np.sqrt(2.0 ** ((first + np.arange(3)) / SPEEDS) / speed)
            parts = (factor * self._at(first + k, level, fold) for k, factor in enumerate(factors))
            self._last = key, np.asarray(sum(parts))
        return self._last[1]

    def _swelling(self, passed: Passed, fold: Fold | None) -> Array | None:
        """Openings [m3/W] (n, n) by a unit flux into each point where all passes at unit speed.

        What heat opens is in proportion to it, and to expansion. None where nothing expands.
        """
        heated = self.heated
        if not heated.expands or not heated.lower.expands or heated.poisson is None:
            return None
        is_folded = fold is not None
        if is_folded not in self._risen:
            given = self._conducting(0), self._velocity(1.0), self.places, self.sizes
            risen = -_mtb_rs.swelling(*given, 1.0, heated.poisson)
            self._risen[is_folded] = risen if fold is None else fold(risen)
        return np.asarray(passed.expansion * self._risen[is_folded])

    def _range(self, fold: Fold | None) -> Ahead:
        """How far the points, or those that a fold keeps, lie ahead of each other."""
        is_folded = fold is not None
        if is_folded not in self._ranges:
            # mirror images lie equally far ahead
            kept = slice(None) if fold is None else fold.kept
            along, half = (self.places @ self.way)[kept], 0.5 * (self.sizes @ np.abs(self.way))[kept]
            stations, row = np.unique(np.round(along / self.length, 12), return_inverse=True)
            ahead = along - self.length * stations[:, None]
            near, far = np.maximum(ahead - half, 0.0), ahead + half
            # what heat does against the motion it does as it moves away as far
            far = np.where(far > 0.0, far, half - ahead)
            self._ranges[is_folded] = Ahead(np.sqrt(near), np.sqrt(far), row)
        return self._ranges[is_folded]

    def _conducting(self, level: int) -> tuple[float, float, float]:
        lower = self.heated.lower
        return lower.conductivity * (1.0 + SAME * level), lower.density, lower.specific_heat

    def _velocity(self, speed: float) -> tuple[float, float]:
        return -speed * float(self.way[0]), -speed * float(self.way[1])

    def _at(self, number: int, level: int, fold: Fold | None) -> Array:
        key = number, level, fold is not None
        if key not in self._table:
            velocity = self._velocity(2.0 ** (number / SPEEDS))
            given = self._conducting(level), velocity, self.places, self.sizes
            found = _mtb_rs.moving_half_space(*given)
            self._table[key] = found if fold is None else fold(found)
        return self._table[key]


@dataclass(frozen=True)
class Trial:
    """A step that was computed, to be taken or not.

    `is_state` tells whether it has a state, and only one. `warm` describes the upper bodies at its end,
    `opening` (n,) [m] is what heat adds to the gap since the beginning, `runs_away` whether this is more
    than small deformations are, `depth` and `volume_lower` are what the step wears, `error` is that of
    the step, `attraction` the pull (n,) [Pa] of a magnet that follows the gap.
    """

    duration: float
    way: float
    is_state: bool
    outcome: Any
    pressure: Array
    friction: Array
    flux: Array
    surface: Array
    warm: list[Array]
    opening: Array
    runs_away: bool
    depth: Array
    volume_lower: float
    force: Array
    error: float
    attraction: Array | None

    def kept(self) -> Kept:
        """What :meth:`HeatedSliding.recalled` makes it of again."""
        names = ("pressure", "friction", "flux", "surface", "opening", "depth", "force")
        return {
            **{name: getattr(self, name).ravel().tolist() for name in names},
            "numbers": [self.duration, self.way, self.volume_lower, self.error],
            "attraction": [] if self.attraction is None else self.attraction.tolist(),
        }


def _opened(opening: Array | None, flux: Array) -> Array:
    """What fluxes (2, n) open (n,) [m]."""
    if opening is None:
        return np.zeros(flux.shape[1])
    return np.asarray(opening[0] @ flux[0] + opening[1] @ flux[1])


class _Fading:
    """Factors on the friction (n,) that are those at the temperatures which this friction makes.

    By Anderson's secants through the last changes: plain turns run away where the friction falls by more than
    the temperature has grown, relatively.
    """

    def __init__(self, factor: Array) -> None:
        self.factor = factor
        self.is_settled = False
        self._tried: list[Array] = []
        self._missed: list[Array] = []

    def turn(self, found: Array) -> bool:
        """Goes on by the factors that were found; whether to solve again."""
        missed = found - self.factor
        self.is_settled = bool(np.abs(missed).max(initial=0.0) <= FADED)
        if self.is_settled or len(self._missed) >= MOST_FADINGS:
            return False
        self._tried.append(self.factor)
        self._missed.append(missed)
        step = missed
        if len(self._missed) > 1:
            of_missed = np.diff(self._missed[-FADINGS:], axis=0).T
            of_tried = np.diff(self._tried[-FADINGS:], axis=0).T
            shares = np.linalg.lstsq(of_missed, missed, rcond=1e-12)[0]
            step = missed - (of_tried + of_missed) @ shares
        self.factor = np.maximum(self.factor + step, 0.0)
        return True


class HeatedSliding:
    """Bodies that slide and heat each other, step by step.

    Parameters
    ----------
    problem : ContactProblem
    posed : function
        Friction (n,) and magnetic pressure (n,) [Pa] at a velocity [m/s] and under the pressure (n,) [Pa] of
        the step before. In place of the pressure of a magnet that follows the gap, a factor on it.
    pressure : (n,) [Pa]
        At the beginning.
    heated : Heated
    steps : int or None
        Their number, if all have one duration.
    """

    def __init__(
        self,
        problem: ContactProblem,
        posed: Callable[[float, Array], tuple[Array, Array | float]],
        pressure: Array,
        heated: Heated,
        steps: int | None,
    ) -> None:
        n = problem.n
        self.problem, self.posed, self.heated = problem, posed, heated
        height = height_of(problem.upper.state)
        assert height is not None
        self.height = height
        self.bodies: list[HeatedBody] = []
        for part in problem.upper.state:
            first = self.bodies[0] if self.bodies else None
            given = part, heated.upper, heated.film, heated.bulk[1], heated.expands, first
            # without expansion a factor for each duration costs less than modes; with one duration it does so
            # in fewer steps than make up for the modes
            is_long = steps is not None and steps > WORTH * part.sampling().n_points
            is_reduced = is_long or (steps is None and heated.expands and heated.upper.expands)
            self.bodies.append((ReducedBody if is_reduced else WholeBody)(*given))
        self._upper: dict[tuple[float | int, ...], tuple[Array, Array | None]] = {}
        #: The core of the problem, and the last loading with the pull that it was made of.
        self._core = problem.core
        self._loaded: tuple[Array, Any] | None = None
        #: The last matrices, and what they were made of.
        self._last: tuple[Any, tuple[Array, Array | None]] | None = None
        self.passing = Passing(problem, heated)
        self.direction = np.ascontiguousarray(problem.direction)
        # of the velocity, what lies along friction: in the mean over each contact point, as in resultants
        frames = problem.geometry.tangents if problem.averages is None else problem.averages.frames[:2]
        along = np.array([*self.passing.along, 0.0])
        self.share_of_speed = np.einsum("kcn,kn,c->n", frames, self.direction, along)
        self.time, self.distance = 0.0, 0.0
        self.pressure, self.active = pressure, pressure > 0.0
        self.surface = np.stack([np.full(n, bulk) for bulk in heated.bulk])
        #: Depth worn off the upper body (n,) [m], heat that has entered it (n,) [J/m2], and their rates.
        self.worn, self.heat = np.zeros(n), np.zeros(n)
        self.flux, self.wearing = np.zeros(n), np.zeros(n)
        self.volume_lower = 0.0
        #: Pull (n,) [Pa] from which that of a magnet is found; None: that at the gap.
        self.attraction = None if problem.attracting is None else problem.attracting.start(n)
        self.symmetry = mirror_symmetry(problem)
        if self.symmetry is not None:
            source = self.symmetry.source
            kept = np.unique(source, return_index=True)[1]
            self._fold = Fold(kept, self.symmetry.image[kept])
            self._half = self.symmetry.half.core

    def held(self) -> float:
        """Heat [J] in the upper bodies."""
        return sum(body.held(body.warm) for body in self.bodies)

    def lost(self, warm: list[Array]) -> float:
        """Heat flow [W] out of the upper bodies through their films."""
        return sum(body.lost(own) for body, own in zip(self.bodies, warm, strict=True))

    def _by_upper(self, duration: float, is_folded: bool) -> tuple[Array, Array | None]:
        """Temperatures, and displacements per strain over temperature, of the upper bodies by unit fluxes."""
        key = duration, is_folded, *(body.level for body in self.bodies)
        if key not in self._upper:
            while len(self._upper) >= KEPT:
                self._upper.pop(next(iter(self._upper)))
            response = np.zeros((self.problem.n, self.problem.n))
            opening = np.zeros_like(response) if any(body.expands for body in self.bodies) else None
            for body in self.bodies:
                response[body.points, body.points], own = body.matrices(duration)
                if opening is not None and own is not None:
                    opening[body.points, body.points] = own
            if is_folded:
                response = self._fold(response)
                opening = None if opening is None else self._fold(opening)
            self._upper[key] = response, opening
        return self._upper[key]

    def _passed(self, duration: float, way: float) -> Passed:
        """What passes in a step."""
        warmer = float(self.surface[0] @ self.problem.area / self.problem.area.sum())
        return self.passing.of(duration, way, warmer)

    def _carried(self, passed: Passed) -> tuple[Array, Array] | None:
        """What heat of earlier steps does that is still below the contact (n,): :meth:`Passing.carried`."""
        fluxes = [flux for _, _, flux in self.passing.heated_before]
        if self.symmetry is None or not self._is_symmetric(fluxes):
            return self.passing.carried(passed)
        half = self.passing.carried(passed, self._fold)
        return None if half is None else (half[0][self.symmetry.source], half[1][self.symmetry.source])

    def _matrices(
        self, duration: float, lower: Passed, is_folded: bool = False
    ) -> tuple[Array, Array | None]:
        """Temperatures and openings (2, n, n) by unit fluxes over a step; of the half if folded."""
        upper = self._by_upper(duration, is_folded)
        slopes = tuple(body.slope for body in self.bodies) if self.heated.expands else ()
        key = lower, slopes, duration, is_folded, tuple(body.level for body in self.bodies)
        if self._last is None or self._last[0] != key:
            self._last = key, self._made(lower, upper, slopes, is_folded)
        return self._last[1]

    def _made(
        self, lower: Passed, upper: tuple[Array, Array | None], slopes: tuple[float, ...], is_folded: bool
    ) -> tuple[Array, Array | None]:
        """What :meth:`_matrices` returns."""
        cold, risen = self.passing.at(lower, self._fold if is_folded else None)
        warm, opened = upper
        response = np.stack([cold, warm])
        if not self.heated.expands:
            return response, None
        opening = np.zeros_like(response)
        if risen is not None:
            opening[0] = risen
        if opened is not None:
            each = np.empty(self.problem.n)
            for body, slope in zip(self.bodies, slopes, strict=True):
                each[body.points] = slope
            np.multiply(opened, each[self._fold.kept] if is_folded else each, out=opening[1])
        return response, opening

    def thermal_margin(self, duration: float, speed: float) -> float | None:
        """Heat of friction over that up to which one step of this duration has a single state.

        None without expansion, or where it is not known.
        """
        if not self.heated.expands or speed == 0.0:
            return None
        friction, _ = self.posed(speed, self.pressure)
        friction = friction * self.heated.faded(self.surface.mean(axis=0))
        response, opening = self._matrices(duration, self._passed(duration, speed * duration))
        before = np.zeros((2, self.problem.n))
        speeds = speed * self.share_of_speed
        numbers = self.heated.resistance, self.heated.share
        heating: Any = response, before, speeds, numbers, opening
        active = self.active.tolist()
        factor = self.problem.core.thermal_factor(
            self.direction, np.ascontiguousarray(friction), heating, active
        )
        if np.isnan(factor):
            return None
        return float("inf") if factor == 0.0 else 1.0 / factor

    def tried(self, duration: float, speed: float, mean: float) -> Trial:
        """A step over a duration [s] at a `mean` speed, with friction and pull at another `speed` [m/s]."""
        problem, heated = self.problem, self.heated
        n, way = problem.n, mean * duration
        friction, pull = self.posed(speed, self.pressure)
        unfaded, factor = friction, heated.faded(self.surface.mean(axis=0))
        friction = np.ascontiguousarray(unfaded * factor)
        before = np.full((2, n), heated.bulk[0])
        worn, coasted = self.worn.copy(), []
        passed = self._passed(duration, way)
        carried = self._carried(passed)
        if carried is not None:
            before[0] += carried[0]
            worn += carried[1]
        for body in self.bodies:
            cooled = body.coasted(duration)
            coasted.append(cooled)
            before[1, body.points] = body.surface_coasted(duration, cooled)
            if body.expands:
                worn[body.points] += body.opened_coasted(duration, cooled)
        rubbed = problem.capped(friction, self.pressure)
        rubbing = Rubbing(self.pressure, rubbed, np.ones(n), mean, problem.points.points)
        coefficient = np.zeros(n) if heated.wear is None else coefficients_of(heated.wear, rubbing)
        diagonal = way * coefficient
        speeds = mean * self.share_of_speed
        numbers = heated.resistance, heated.share
        magnet = None
        if problem.attracting is not None:
            magnet = *problem.attracting.given[:2], float(pull)
            pull = np.zeros(n)
        loading = self._loading(np.asarray(pull))
        given = (duration, passed), (before, speeds, numbers), worn, diagonal, magnet
        outcome, flux, surface, pressure, by_flux = self._solved(loading, friction, *given)
        is_settled = True
        if heated.fading is not None:
            fading = _Fading(factor)
            while outcome.status == "solved" and fading.turn(heated.faded(surface.mean(axis=0))):
                friction = np.ascontiguousarray(unfaded * fading.factor)
                outcome, flux, surface, pressure, by_flux = self._solved(loading, friction, *given)
            is_settled = fading.is_settled
        # where nothing expands, the steps have no part in it
        is_single = not (heated.expands and outcome.unstable)
        settled = outcome.settled
        opened = worn - self.worn + by_flux
        # above the thermal limit linear heat grows without a bound, to numbers that are none
        is_small = bool(np.abs(opened).max(initial=0.0) <= SMALL * self.height)
        is_state = outcome.status == "solved" and is_single and is_settled and is_small
        # where a layer yields, friction has not grown with the pressure
        friction = problem.capped(friction, pressure)
        depth = diagonal * pressure
        volume = 0.0
        if heated.lower_wear is not None:
            rate = coefficients_of(heated.lower_wear, rubbing)
            volume = float(way * rate * pressure @ problem.area)
        unknowns = sliding_tractions(pressure, friction, self.direction)
        force = problem.geometry.loads(unknowns).sum(axis=1)
        area = np.ascontiguousarray(problem.area)
        of_heat = _mtb_rs.step_error(area, self.heat, duration, self.flux, np.ascontiguousarray(flux[1]))
        of_wear = _mtb_rs.step_error(area, self.worn, duration, self.wearing, depth / duration)
        return Trial(
            duration, way, is_state, outcome, pressure, friction, flux, surface,
            self._warmed(duration, coasted, flux), opened, not is_small, depth, volume, force,
            max(of_heat, of_wear) if is_state else float("nan"), None if settled is None else settled.pull,
        )  # fmt: skip

    def _loading(self, pull: Array) -> Any:
        """The loading under a pull (n,) [Pa]; that of the last step again where it is the same."""
        if self._loaded is None or not np.array_equal(self._loaded[0], pull):
            lower = self.problem.lower.pull
            self._loaded = pull, self.problem.loading_by(pull, pull if lower.any() else lower)
        return self._loaded[1]

    def _warmed(self, duration: float, coasted: list[Array], flux: Array) -> list[Array]:
        pairs = zip(self.bodies, coasted, strict=True)
        return [
            body.warmed(duration, cooled, np.ascontiguousarray(flux[1, body.points]))
            for body, cooled in pairs
        ]

    def recalled(self, kept: Kept) -> Trial:
        """A step that was tried from here before, by what is kept of it."""
        fields = {name: np.array(kept[name]).reshape(shape) for name, shape in self._shapes().items()}
        duration, way, volume, error = kept["numbers"]
        flux, attraction = fields["flux"], kept["attraction"]
        coasted = [body.coasted(duration) for body in self.bodies]
        return Trial(
            duration, way, True, None, fields["pressure"], fields["friction"], flux, fields["surface"],
            self._warmed(duration, coasted, flux), fields["opening"], False, fields["depth"], volume,
            fields["force"], error, np.array(attraction) if attraction else None,
        )  # fmt: skip

    def _shapes(self) -> dict[str, tuple[int, ...]]:
        n = self.problem.n
        return {
            **dict.fromkeys(("pressure", "friction", "opening", "depth"), (n,)),
            **dict.fromkeys(("flux", "surface"), (2, n)),
            "force": (3,),
        }

    def _solved(
        self,
        loading: Any,
        friction: Array,
        step: tuple[float, Passed],
        heating: Any,
        worn: Array,
        diagonal: Array,
        magnet: Any,
    ) -> tuple[Any, Array, Array, Array, Array]:
        """Outcome, fluxes, temperatures (2, n), pressure (n,), and what the fluxes open (n,).

        By the half where all is symmetric; `step` is its duration [s] and what passes in it.
        """
        before, speeds, numbers = heating
        symmetry, core = self.symmetry, self._core
        if symmetry is None or not self._is_symmetric([loading.gap, friction, worn, diagonal, *before]):
            response, opening = self._matrices(*step)
            outcome, flux, surface, _ = core.slide_heated(
                loading,
                self.direction,
                friction,
                (response, before, speeds, numbers, opening),
                (worn, diagonal),
                self.active.tolist(),
                magnet,
                self.attraction,
            )
            return outcome, flux, surface, outcome.pressure, _opened(opening, flux)
        kept, source = self._fold.kept, symmetry.source
        response, opening = self._matrices(*step, is_folded=True)
        half = self._half
        work = np.zeros(len(half.motions))
        moving = symmetry.motion_source >= 0
        np.add.at(work, symmetry.motion_source[moving], (symmetry.motion_sign * loading.work)[moving])
        cut = [np.ascontiguousarray(field[..., kept]) for field in (loading.gap, friction, worn, diagonal)]
        folded: Any = (
            response,
            np.ascontiguousarray(before[:, kept]),
            np.ascontiguousarray(speeds[kept]),
            numbers,
            opening,
        )
        direction = np.ascontiguousarray(self.direction[:, kept])
        start = self.active[kept].tolist()
        outcome, flux, surface, _ = half.slide_heated(
            half.loading(cut[0], work), direction, cut[1], folded, (cut[2], cut[3]), start
        )
        by_flux = _opened(opening, flux)
        return outcome, flux[:, source], surface[:, source], outcome.pressure[source], by_flux[source]

    def _status(self, trial: Trial) -> NDArray[np.int8]:
        """0 open, 1 stick, 2 slip, 3 plastic (n,)."""
        moves = np.where(self.problem.yields(trial.friction, trial.pressure), 3, 2)
        touching = moves if trial.friction.any() else 1
        return np.where(trial.pressure > 0.0, touching, 0).astype(np.int8)

    def _is_symmetric(self, fields: list[Array]) -> bool:
        assert self.symmetry is not None
        image = self.symmetry.image
        return all(alike(field, field[image]) for field in fields)

    def take(self, trial: Trial) -> dict[str, Any]:
        """Goes on from the end of a step; what it adds to the histories."""
        problem, duration = self.problem, trial.duration
        before = self.held()
        self.time += duration
        if trial.attraction is not None:
            self.attraction = trial.attraction
        self.passing.keep(trial.way, duration, trial.flux[0])
        self.distance += trial.way
        losses = self.lost(trial.warm)
        for body, warm in zip(self.bodies, trial.warm, strict=True):
            body.warm = warm
        self.pressure, self.active = trial.pressure, trial.pressure > 0.0
        self.surface = trial.surface
        self.worn = self.worn + trial.depth
        if self.heated.wear is not None:
            way = self.distance
            check_worn(self.heated.wear, self.worn, self.height, "the height of the upper body", way)
        self.heat = self.heat + duration * trial.flux[1]
        self.flux, self.wearing = np.ascontiguousarray(trial.flux[1]), trial.depth / duration
        self.volume_lower += trial.volume_lower
        tractions = sliding_tractions(trial.pressure, trial.friction, self.direction)
        mean = mean_tractions(problem, tractions)
        area = np.concatenate([problem.area[body.points] for body in self.bodies])
        face = np.concatenate([trial.surface[1, body.points] for body in self.bodies])
        entered = trial.flux @ problem.area
        flux = mean_tractions(problem, np.concatenate([trial.flux, trial.pressure[None]]))
        return {
            "time": self.time,
            "forces": trial.force,
            "friction_powers": entered.sum(),
            "heats_upper": entered[1],
            "heats_lower": entered[0],
            "losses": losses,
            "gained": self.held() - before,
            "peaks": trial.surface.max(),
            "means": float(face @ area / area.sum()),
            "pressures": mean[2],
            "temperatures": trial.surface[1],
            "depths": self.worn,
            "openings": trial.opening,
            "volumes_upper": float(self.worn @ problem.area),
            "volumes_lower": self.volume_lower,
            "errors": trial.error,
            "fields": {
                "pressure": mean[2],
                "traction": along_surface(problem, mean[:2]),
                "status": self._status(trial),
                "temperature_upper": trial.surface[1],
                "temperature_lower": trial.surface[0],
                "heat_flux_upper": flux[1],
                "heat_flux_lower": flux[0],
                "depth": self.worn,
            },
        }
