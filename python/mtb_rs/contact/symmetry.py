# SPDX-License-Identifier: MIT OR Apache-2.0
"""Scenes that are their own mirror image about y = 0 are solved as their half."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from .. import _mtb_rs
from ..base.cache import Memory
from ..base.plain import plain
from ..bodies.sides import Side
from ..geometry.contact_points import ROUNDING
from .problem import ContactProblem

Array = NDArray[np.float64]
Index = NDArray[np.intp]


@dataclass(frozen=True)
@plain
class MirrorSymmetry:
    """A symmetric problem's half and the way back.

    Attributes
    ----------
    half : ContactProblem
        The problem on one point of each pair.
    image : (n,) int
        The mirror image of each point of the whole.
    source : (n,) int
        The point of the half that each point of the whole is, or is the image of.
    motion_source : (m,) int
        The motion of the half with the amplitude of each motion of the whole; -1: it does not move.
    motion_sign : (m,)
        -1 where the mirror turns round the motion of the half, as it does with rolls of two bodies.
    """

    half: ContactProblem
    image: Index
    source: Index
    motion_source: Index
    motion_sign: Array

    @property
    def off_plane(self) -> NDArray[np.bool_]:
        """Which points of the half are off the plane: those of the turned half."""
        kept = np.flatnonzero(np.arange(self.image.size) <= self.image)
        return np.asarray(self.image[kept] != kept)

    def whole_motion(self, motion: Array) -> Array:
        """Amplitudes (m,) of the motions of the whole from those of the half."""
        return np.asarray(self.motion_sign * np.append(motion, 0.0)[self.motion_source])


def _image_of(problem: ContactProblem) -> Index | None:
    """The mirror image of each point, where points, gaps, friction and sliding are symmetric."""
    points = problem.points
    image = problem.memory.recall("images", [points.points], lambda: _images(points.points))
    if image is None or (image == np.arange(image.size)).all():
        return None
    friction = problem.friction
    # both gaps: before the loads that move the faces, and after
    fields: list[Array] = [problem.area, problem.loading.gap, problem.direction[0], points.gap]
    fields += [
        field
        for field in (friction.fixed, problem.layer, problem.hardness, problem.shear)
        if field is not None
    ]
    if not all(alike(f, f[image]) for f in fields) or problem.direction[1].any():
        return None
    if not (_mirrored(points.normal, image) and _mirrored(points.tangent_x, image)):
        return None
    return image


def is_symmetric(problem: ContactProblem) -> bool:
    """Whether all but the compliances of the bodies is symmetric: points, gaps, friction, sliding, loads."""
    image = _image_of(problem)
    sides = zip((problem.upper, problem.lower), problem.work, strict=True)
    return image is not None and all(
        alike(side.pull, side.pull[image]) and _half_side(side, work, image) is not None
        for side, work in sides
    )


def mirror_symmetry(problem: ContactProblem) -> MirrorSymmetry | None:
    """The half of a symmetric problem; None where the problem is not symmetric."""
    if problem.attracting is not None:
        # the poles are in series: a half would have half of the flux
        return None
    image = _image_of(problem)
    if image is None:
        return None
    upper, lower = (
        _half_side(side, work, image)
        for side, work in zip((problem.upper, problem.lower), problem.work, strict=True)
    )
    if upper is None or lower is None:
        return None
    compliances = problem.memory.recall(
        "halves", [problem.upper.compliance, problem.lower.compliance, image], lambda: _halves(problem, image)
    )
    if compliances is None:
        return None
    kept = np.flatnonzero(np.arange(image.size) <= image)
    position = np.empty(image.size, dtype=np.intp)
    position[kept] = np.arange(kept.size)
    source = position[np.minimum(np.arange(image.size), image)]
    weight = np.where(image[kept] == kept, 1.0, 2.0)

    halves, motion_source, motion_sign, offset = [], [], [], 0
    for side, work, compliance, (orbits, source_of, sign_of) in zip(
        (problem.upper, problem.lower), problem.work, compliances, (upper, lower), strict=True
    ):
        signed, worked = sign_of[:, None, None] * side.motions, sign_of * work
        motions = [signed[list(orbit)].sum(axis=0)[:, kept] for orbit in orbits]
        # what moves its face and works on its motions is in the gap and the work of the half
        halves.append(
            _side_of_half(
                *(side, compliance, motions, side.modes[[orbit[0] for orbit in orbits]]),
                np.array([worked[list(orbit)].sum() for orbit in orbits]),
                kept.size,
            )
        )
        motion_source.append(np.where(source_of >= 0, source_of + offset, -1))
        motion_sign.append(sign_of)
        offset += len(orbits)
    half = _of_half(problem, kept, weight, (halves[0], halves[1]), "half", image)
    return MirrorSymmetry(
        half, image, source, np.concatenate(motion_source).astype(np.intp), np.concatenate(motion_sign)
    )


def turned_half(problem: ContactProblem, image: Index) -> ContactProblem | None:
    """The half under states that the mirror turns around, without loads; None where a body does not tell it.

    A body that was itself condensed as its half knows symmetric loads alone.
    """
    return problem.memory.recall(
        "turned half",
        [
            *(side.compliance for side in (problem.upper, problem.lower)),
            *(side.motions for side in (problem.upper, problem.lower)),
            *(image, problem.direction, problem.area, problem.layer, problem.hardness, problem.shear),
            problem.rough,
        ],
        lambda: _turned_half(problem, image),
    )


def _side_of_half(
    side: Side, compliance: _mtb_rs.Compliance | None, motions: list[Array], modes: Array, work: Array, n: int
) -> Side:
    return replace(
        side,
        compliance=compliance,
        displacement=np.zeros((3, n)),
        motions=np.array(motions).reshape(len(motions), 3, n),
        modes=modes,
        work=work,
        pull=np.zeros(n),
        is_pulled=np.ones(len(motions), dtype=bool),
    )


def _of_half(
    problem: ContactProblem, kept: Index, weight: Array, sides: tuple[Side, Side], name: str, image: Index
) -> ContactProblem:
    """A problem on the points `kept`, whose areas count by `weight`."""

    def at(field: Array | None) -> Array | None:
        return None if field is None else field[kept]

    return replace(
        problem,
        points=problem.points.at(kept),
        area=problem.area[kept] * weight,
        friction=problem.friction.of(kept),
        direction=np.ascontiguousarray(problem.direction[:, kept]),
        gap=problem.loading.gap[kept],
        layer=at(problem.layer),
        hardness=at(problem.hardness),
        shear=at(problem.shear),
        upper=sides[0],
        lower=sides[1],
        averages=None,
        patches=(),
        windows=(),
        shape=(kept.size,),
        kept=None,
        memory=problem.memory.recall(name, [image], Memory),
    )


def _turned_half(problem: ContactProblem, image: Index) -> ContactProblem | None:
    off = np.flatnonzero(np.arange(image.size) < image)
    sides: list[Side] = []
    for side in (problem.upper, problem.lower):
        compliance = side.compliance
        if compliance is not None:
            traction = np.random.default_rng(2).standard_normal((3, image.size))
            turned = traction - _mirror(traction, image)
            # no load on the plane, which the mirror would turn around
            turned[:, image == np.arange(image.size)] = 0.0
            moved = compliance.displacement(turned)
            if not alike(moved, -_mirror(moved, image)):
                return None
            compliance = compliance.turned_half(list(map(int, image)))
        motions: list[Array] = []
        for motion in side.motions:
            # a motion without the part of it that is its own image
            odd = 0.5 * (motion - _mirror(motion, image))[:, off]
            size = float(np.abs(motion).max(initial=0.0))
            is_there = np.abs(odd).max(initial=0.0) > ROUNDING * size
            # motions that are images of each other have the same one
            if is_there and not any(alike(odd, sign * m, size) for m in motions for sign in (1.0, -1.0)):
                motions.append(odd)
        modes = side.modes[: len(motions)]
        sides.append(_side_of_half(side, compliance, motions, modes, np.zeros(len(motions)), off.size))
    weight = np.full(off.size, 2.0)
    return _of_half(problem, off, weight, (sides[0], sides[1]), "turned half memory", image)


def _images(points: Array) -> Index | None:
    """The mirror image of each point about y = 0; None where one has none."""
    size = np.abs(points).max()
    grid = np.round(points / (size * 1e-9)).astype(np.int64) if size > 0.0 else points.astype(np.int64)
    there = {tuple(p): i for i, p in enumerate(grid.T.tolist())}
    image = [there.get((x, -y, z)) for x, y, z in grid.T.tolist()]
    if None in image or len(there) != len(image):
        return None
    return np.array(image, dtype=np.intp)


def alike(a: Array, b: Array, size: float | None = None) -> bool:
    size = float(np.abs(a).max(initial=0.0)) if size is None else size
    return bool(np.abs(a - b).max(initial=0.0) <= ROUNDING * size)


def _mirror(vectors: Array, image: Index) -> Array:
    """Vectors (..., 3, n) seen in the mirror."""
    return np.ascontiguousarray(vectors[..., image] * np.array([[1.0], [-1.0], [1.0]]))


def _mirrored(vectors: Array, image: Index) -> bool:
    return alike(vectors, _mirror(vectors, image))


def _responds_alike(side: Side, image: Index) -> bool:
    """Whether tractions that are their own mirror image move the body's points so, tried on random ones.

    A body held on one side only, or an uneven mesh, does not pass.
    """
    if side.compliance is None:
        return True
    traction = np.random.default_rng(1).standard_normal((3, image.size))
    return _mirrored(side.compliance.displacement(traction + _mirror(traction, image)), image)


def _halves(problem: ContactProblem, image: Index) -> tuple[_mtb_rs.Compliance | None, ...] | None:
    """Upper and lower body under loads that are their own mirror images; None where one is not symmetric."""
    sides = (problem.upper, problem.lower)
    if not all(_responds_alike(side, image) for side in sides):
        return None
    pairing = list(map(int, image))
    return tuple(
        None if side.compliance is None else side.compliance.symmetric_half(pairing) for side in sides
    )


def _half_side(side: Side, work: Array, image: Index) -> tuple[list[tuple[int, ...]], Index, Array] | None:
    """Orbits of a body's rigid motions under the mirror, the orbit and the sign in it of each.

    None where motions or loads are not symmetric.
    """
    motions = side.motions
    seen: set[int] = set()
    orbits: list[tuple[int, ...]] = []
    source_of, sign_of = np.full(work.size, -1), np.ones(work.size)
    largest = float(np.abs(work).max(initial=0.0))
    for k in range(work.size):
        if k in seen:
            continue
        reflected = _mirror(motions[k], image)
        size = float(np.abs(motions[k]).max(initial=0.0))
        if alike(motions[k], -reflected, size):
            if abs(work[k]) > ROUNDING * largest:
                return None
            seen.add(k)
            continue
        partner, sign = next(
            (
                (j, sign)
                for j in range(work.size)
                for sign in (1.0, -1.0)
                if j not in seen and alike(motions[j], sign * reflected, size)
            ),
            (None, 1.0),
        )
        if partner is None or abs(work[k] - sign * work[partner]) > ROUNDING * largest:
            return None
        sign_of[partner] = sign
        orbit = (k,) if partner == k else (k, partner)
        seen.update(orbit)
        source_of[list(orbit)] = len(orbits)
        orbits.append(orbit)
    return orbits, source_of, sign_of
