# SPDX-License-Identifier: MIT OR Apache-2.0
"""A body on its contact points: how they give way, how it may move, what works on it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from .. import _mtb_rs
from ..base.cache import Memory
from ..base.plain import plain
from ..geometry.contact_points import ContactPoints, Patch
from .elastic_body import Balance, BodyState, Condensed, ElasticBody
from .faces import Hats, thinned

Array = NDArray[np.float64]

#: Relative size of other components below which a rigid motion is along or about one axis.
ALIGNED = 1e-9


@dataclass(frozen=True)
@plain
class Side:
    """One body of a contact problem.

    Attributes
    ----------
    compliance : Compliance or None
        None for a rigid body.
    displacement : (3, n) [m]
        Of the contact points by what its supports prescribe and by the loads on its inside, common frame.
    motions : (m, 3, n)
        Of the contact points by a unit of each rigid motion the supports leave free, common frame. Under
        overlapping basis functions these are means over each point, so they tell no kind of motion.
    modes : (m, 9)
        The same motions in space: translation, rotation vector, and the point that is translated [m].
    work : (m,) [J]
        Generalised load on each motion: of all loads but the contact's and the attraction, on a unit of it.
    pull : (n,) [Pa]
        Magnetic attraction: the pressure on it.
    includes_motion : bool
        Whether the reported displacement contains the rigid part.
    is_pulled_at_face : bool
        Whether the attraction moves its contact points; otherwise only its resultant counts.
    is_pulled : (m,) bool
        Whether the attraction loads each motion; where not, the generalised load is given as a whole.
    state : tuple of ElasticPart
        The elastic bodies, with what recovers their inside from a solution; none of half-spaces and rigid
        bodies.
    operations : float
        Floating-point operations of its condensation, whether done now or found in the cache.
    """

    compliance: _mtb_rs.Compliance | None
    displacement: Array
    motions: Array
    modes: Array
    work: Array
    pull: Array
    is_pulled: NDArray[np.bool_]
    includes_motion: bool = False
    is_pulled_at_face: bool = True
    state: tuple[ElasticPart, ...] = ()
    operations: float = 0.0

    @property
    def lifts(self) -> Array:
        """Rise (m,) of the motions that are translations along z; 0 for all others."""
        return lifts_of(self.modes)


def lifts_of(modes: Array) -> Array:
    """Rise (m,) of the rigid motions (m, 9) that are translations along z; 0 for all others."""
    others = np.abs(modes[:, [0, 1, 3, 4, 5]]).max(axis=1, initial=0.0)
    return np.where(others <= ALIGNED * np.abs(modes[:, 2]), modes[:, 2], 0.0)


@dataclass(frozen=True)
@plain
class ElasticPart:
    """One elastic body of a side and the contact points it carries.

    Attributes
    ----------
    patches : tuple of Patch
        Its grids, counted from its own first point.
    points : ContactPoints
        Its contact points.
    first : int
        Number of its first point in the scene.
    upper : bool
    pull : (n,) [Pa]
        Magnetic attraction: the pressure on it.
    modes : (m, 9)
        Rigid motions its supports leave free.
    hats : Hats or None
        Its contact points, where not all nodes of the grids lie on the body.
    spread : (6,)
        Force [N] and moment about the centre of volume [N m] spread over the body.
    balance : Balance or None
        Once condensed.
    covered : (q,) or None
        Share of the area of each quadrature point that the opponent's face covers as well, where not all.
    is_half : bool
        Whether it is the half y >= 0 of a body, the other half being its mirror image.
    memory : Memory
        Its basis, which all its loads share.
    """

    body: ElasticBody
    patches: tuple[Patch, ...]
    points: ContactPoints
    first: int
    upper: bool
    pull: Array
    modes: Array
    hats: Hats | None = None
    spread: Array = field(default_factory=lambda: np.zeros(6))
    balance: Balance | None = None
    covered: Array | None = None
    is_half: bool = False
    memory: Memory = field(default_factory=Memory, compare=False, repr=False)

    def on(self, flexible: Condensed) -> ElasticPart:
        """The same part with what its condensation tells about it."""
        return replace(self, modes=flexible.modes, balance=self.body.balance(flexible, self.spread))

    def forces(self, coefficients: Array) -> Forces:
        """All that acts on the body under the unknowns (3, n) [Pa] of a solution."""
        assert self.balance is not None
        contact, pull = self._tractions(coefficients)
        touched, supports = self.balance.of(contact + pull)
        pulled = np.einsum("kcn,cn->k", self.balance.contact, pull)
        forces = Forces(touched - pulled, pulled, self.balance.spread, supports, self._size)
        return forces.mirrored() if self.is_half else forces

    @property
    def _size(self) -> float:
        """Longest edge [m] of the box round the body."""
        return float(np.ptp(self.body.mesh.nodes, axis=0).max())

    @property
    def lifts(self) -> Array:
        """Rise (m,) of the free motions that are translations along z; 0 for all others."""
        return lifts_of(self.modes)

    def loads_in_words(self) -> list[str]:
        """The given loads on the body, besides its magnetic attraction."""
        words = []
        if self.spread[2]:
            words.append(f"force {self.spread[2]:.6g} N along z on {self.body.name}")
        moment = np.where(
            np.abs(self.spread[3:]) > 1e-9 * self._size * np.abs(self.spread[:3]).max(), self.spread[3:], 0.0
        )
        if moment.any():
            given = ", ".join(f"{m:.4g}" for m in moment)
            words.append(f"moment ({given}) N m about the centre of {self.body.name}")
        for name, support in zip(self.body.support_names, self.body.supports, strict=True):
            for component, guide in support.guides.items():
                if guide.force:
                    along = "xyz"[component]
                    words.append(f"guide {name!r} of {self.body.name} {guide.force:.6g} N along {along}")
        return words

    def _tractions(self, coefficients: Array) -> tuple[Array, Array]:
        """Tractions (3, n) [Pa] of the contact and of the attraction, in the body's own frame."""
        n = self.pull.size
        own = coefficients[:, self.first : self.first + n]
        sign = -1.0 if self.upper else 1.0
        none = np.zeros(n)
        return np.concatenate([sign * own[:2], own[2:]]), np.stack([none, none, -self.pull])

    def state(self, coefficients: Array, motion: Array) -> BodyState:
        """The whole body under the unknowns (3, n) [Pa] of a solution and its own rigid motions (m,)."""
        return self.body.recover(*self._loaded(coefficients, motion))

    def moved(self, coefficients: Array, motion: Array) -> Array:
        """Displacement (3, N) [m] of its nodes, as :meth:`state` has it."""
        return self.body.moved(*self._loaded(coefficients, motion))[0]

    def _loaded(
        self, coefficients: Array, motion: Array
    ) -> tuple[_mtb_rs.Sampling, Array, Array, Array, Array | None]:
        contact, pull = self._tractions(coefficients)
        force = self.body.core.spread_force(tuple(self.spread)) if self.spread.any() else None
        return self.sampling(), self.modes, contact + pull, motion, force

    def own_points(self) -> ContactPoints:
        """Its contact points."""
        return self.points if self.hats is None else self.points.at(self.hats.kept)

    def sampling(self) -> _mtb_rs.Sampling:
        """Its basis on the contact face."""
        return self.memory.recall("basis", [id(self.points), id(self.hats)], self._sampled)

    def _sampled(self) -> _mtb_rs.Sampling:
        whole = self.body.sample(self.points, self.patches, upper=self.upper)
        if self.covered is not None:
            whole = thinned(whole, self.covered)
        return whole if self.hats is None else self.hats.of(whole)


@dataclass(frozen=True)
@plain
class Forces:
    """All that acts on one body: (fx, fy, fz, mx, my, mz) each, [N] and [N m], moments about the origin.

    `length` [m] is the size of the body: a moment counts as the force that makes it on this lever.
    """

    contact: Array
    magnetic: Array
    spread: Array
    supports: Mapping[str, Array]
    length: float

    def mirrored(self) -> Forces:
        """Of the whole body, from those of its half y >= 0; what holds its plane of symmetry cancels out."""
        whole = {name: value * _WHOLE for name, value in self.supports.items() if name != _SYMMETRY}
        return Forces(self.contact * _WHOLE, self.magnetic * _WHOLE, self.spread * _WHOLE, whole, self.length)

    @property
    def relative_error(self) -> float:
        """What is left of the sum of all forces and moments, relative to the sizes of both together.

        Each alone is no scale: where a body is loaded by forces through one point, its moments are rounding.
        """
        parts = np.array([self.contact, self.magnetic, self.spread, *self.supports.values()])
        lever = np.array([1.0, 1.0 / self.length])
        size = float((np.linalg.norm(parts.reshape(-1, 2, 3), axis=2) @ lever).sum())
        rest = np.linalg.norm(parts.sum(axis=0).reshape(2, 3), axis=1) * lever
        return float(rest.max()) / size if size > 0.0 else 0.0


#: A body and its mirror image together: twice what the mirror keeps, none of what it turns round.
_WHOLE = np.array([2.0, 0.0, 2.0, 0.0, 2.0, 0.0])
_SYMMETRY = "2 symmetry"
