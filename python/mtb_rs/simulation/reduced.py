# SPDX-License-Identifier: MIT OR Apache-2.0
"""Elastic bodies with inertia, reduced to their contact points and their lowest vibrations."""

from __future__ import annotations

import io
import os
from collections.abc import Sequence
from dataclasses import dataclass, fields
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..base.check import not_negative, positive, whole
from ..base.files import made_of, write_bytes
from ..base.owning import owning
from ..base.plain import plain
from ..base.stored import stored
from ..base.words import Body
from ..bodies.elastic_body import Condensed
from ..bodies.sides import ElasticPart, Side

Array = NDArray[np.float64]

#: Blocks of a flexibility, as the condensation gives them.
_BLOCKS = ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))
#: What a file of a reduced body holds besides its arrays.
_FORMAT = "mtb_rs reduced body 1"


@stored
@owning
@dataclass(frozen=True)
@plain
class ReducedBody:
    """Elastic bodies as their contact points see them in motion, by :meth:`mtb_rs.PreparedContact.reduced`.

    Forces F (3 n) [N] on the contact points move amplitudes q [m kg^1/2] of the vibrations, and r of the
    rigid motions, and with them the contact points by u (3 n) [m]:

    q'' + (2 pi frequency)^2 q = shapes F, r'' = rigid F, u = residual F + shapes^T q + rigid^T r.

    Both F and u are components along the axes of the contact points, each over all points, in the order
    (tangent 1 of all points, tangent 2 of all, into the body of all); rows of `shapes` and `rigid` are
    flattened to the same order. A force is a traction times the `area`, and u is the mean over a contact
    point.

    Attributes
    ----------
    points : (3, n) [m]
        Mean places of the contact points.
    area : (n,) [m2]
    frames : (3, 3, n)
        Their axes: which axis, component x, y or z, point. On curved faces they are means, a little shorter
        than one.
    frequency : (k,) [Hz]
        Of the vibrations that are kept, rising.
    shapes : (k, 3, n) [kg^-1/2]
        Mean displacement of the contact points in each.
    rigid : (r, 3, n) [kg^-1/2]
        The same of the rigid motions that the supports leave.
    residual : (3 n, 3 n) [m/N]
        Symmetric flexibility without inertia: of all vibrations that are not kept.
    next_frequency : float [Hz]
        Of the lowest vibration that is not kept; infinite where all are kept.
    participation : (k, 6) [kg^1/2], [m kg^1/2]
        What accelerations of the supports along x, y, z, and turns about these axes through the origin, load
        each vibration with: q'' + ... = -participation a. Zero for motions that the supports leave free.
    mass : float [kg]
    density : float [kg/m3]
    """

    points: Array
    area: Array
    frames: Array
    frequency: Array
    shapes: Array
    rigid: Array
    residual: Array
    participation: Array
    next_frequency: float
    mass: float
    density: float

    @property
    def flexibility(self) -> Array:
        """Displacement of the contact points by unit forces at rest (3 n, 3 n) [m/N], without rigid motion.

        Of a body with free rigid motions, forces are balanced by its inertia.
        """
        flat = self.shapes.reshape(self.frequency.size, -1)
        return np.asarray(self.residual + (flat.T / (2.0 * np.pi * self.frequency) ** 2) @ flat)

    def receptance(self, frequency: float) -> Array:
        """Displacement of the contact points by unit forces that swing at a frequency (3 n, 3 n) [m/N].

        Nothing is damped: at the frequencies of the body it is infinite. What is left out lies between zero
        and :meth:`left_out` times `residual`, as quadratic forms of any forces.

        Parameters
        ----------
        frequency : float [Hz]
        """
        squared = (2.0 * np.pi * not_negative("frequency", frequency, "Hz")) ** 2
        own = np.concatenate([np.zeros(len(self.rigid)), (2.0 * np.pi * self.frequency) ** 2])
        flat = np.concatenate([a.reshape(len(a), self.residual.shape[0]) for a in (self.rigid, self.shapes)])
        swings = own == squared
        found = self.residual + (flat[~swings].T / (own - squared)[~swings]) @ flat[~swings]
        endless = flat[swings].T @ flat[swings]
        return np.asarray(np.where(endless != 0.0, np.copysign(np.inf, endless), found), dtype=np.float64)

    def left_out(self, frequency: float) -> float:
        """The largest part of `residual` by which the receptance at a frequency [Hz] is too small [-].

        That is f^2 / (f_next^2 - f^2), of the lowest vibration that is not kept; infinite from its frequency
        on.

        Parameters
        ----------
        frequency : float [Hz]
        """
        asked = not_negative("frequency", frequency, "Hz")
        if asked >= self.next_frequency:
            return np.inf
        share = asked / self.next_frequency
        return float(share**2 / (1.0 - share**2))

    def save(self, path: str | os.PathLike[str]) -> None:
        """Writes it as arrays by the names of its attributes (.npz of NumPy), for :meth:`load` and others.

        ``format`` is the text "mtb_rs reduced body 1", and what is one number has the shape (). Each array is
        a file NAME.npy in a ZIP archive, of 64-bit floats in C order.

        Raises
        ------
        ValueError
            If the path is a directory.
        OSError
            If nothing can be written there.
        """
        buffer = io.BytesIO()
        arrays = {field.name: getattr(self, field.name) for field in fields(self)}
        np.savez(buffer, allow_pickle=False, format=_FORMAT, **arrays)
        write_bytes(path, buffer.getvalue())

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> ReducedBody:
        """Reads what :meth:`save` wrote.

        Raises
        ------
        ValueError
            If the file cannot be read, or holds no reduced body, or not all of one.
        """
        return made_of(path, "reduced body", cls._from_bytes)

    @classmethod
    def _from_bytes(cls, data: bytes) -> ReducedBody:
        names = [field.name for field in fields(cls)]
        try:
            with np.load(io.BytesIO(data), allow_pickle=False) as archive:
                arrays = {name: archive[name] for name in archive.files}
        except Exception as error:  # archives fail in many ways
            raise ValueError(f"it is no archive of NumPy: {error}") from None
        if str(arrays.pop("format", "")) != _FORMAT:
            raise ValueError(f"its format is not {_FORMAT!r}")
        if set(arrays) != set(names) or any(array.dtype != np.float64 for array in arrays.values()):
            raise ValueError(f"numbers named {', '.join(names)} are needed")
        numbers = ("next_frequency", "mass", "density")
        given: dict[str, Any] = dict(arrays)
        given |= {name: float(arrays[name]) for name in numbers if arrays[name].shape == ()}
        read = cls(**given)
        read.check()
        return read

    def check(self) -> None:
        """Checks that what was read from files fits together; ValueError if it does not."""
        k, n = self.frequency.size, self.area.size
        shapes = {
            "points": (3, n),
            "area": (n,),
            "frames": (3, 3, n),
            "frequency": (k,),
            "shapes": (k, 3, n),
            "rigid": (len(self.rigid) if np.ndim(self.rigid) else 0, 3, n),
            "residual": (3 * n, 3 * n),
            "participation": (k, 6),
            **dict.fromkeys(("next_frequency", "mass", "density"), ()),
        }
        for name, shape in shapes.items():
            if np.shape(getattr(self, name)) != shape:
                raise ValueError(f"{name} has the shape {np.shape(getattr(self, name))}: {shape} is needed")
            if name != "next_frequency" and not np.isfinite(getattr(self, name)).all():
                raise ValueError(f"{name} holds numbers that are not finite")


@dataclass(frozen=True)
@plain
class Inertia:
    """One body with its inertia on its contact points.

    Attributes
    ----------
    squares : (k + 1,) [1/s2]
        Of the angular frequencies that are kept, and of the next one, infinite if there is none.
    shapes, rigid : (k, 3 n), (r, 3 n) [kg^-1/2]
        Mean displacement of the contact points, their own axes.
    residual : (3 n, 3 n) [m/N]
    participation : (k, 6) [kg^1/2], [m kg^1/2]
    """

    squares: Array
    shapes: Array
    rigid: Array
    residual: Array
    participation: Array
    mass: float


def flexibility_of(condensed: Condensed) -> Array:
    """Displacement (3 n, 3 n) [m/N] of contact points by forces, of what was condensed onto them."""
    n = condensed.weights.size
    found = np.empty((3, n, 3, n))
    for (c, d), block in zip(_BLOCKS, condensed.flexibility, strict=True):
        found[c, :, d] = block
        found[d, :, c] = block.T
    found /= condensed.weights[:, None, None]
    found /= condensed.weights
    return found.reshape(3 * n, 3 * n)


def inertia_of(part: ElasticPart, density: float, modes: int) -> Inertia:
    """A body on its contact points, with its lowest vibrations."""
    core, sampling = part.body.core, part.sampling()
    has_next = modes < part.body.unknowns
    found = core.vibration(density, modes + 1 if has_next else modes)
    squares = found["squares"] if has_next else np.append(found["squares"], np.inf)

    def seen(displacements: Array | Sequence[Array]) -> Array:
        rows = [core.observe(sampling, np.ascontiguousarray(u)).ravel() for u in displacements]
        return np.array(rows).reshape(len(rows), 3 * sampling.n_points)

    shapes, rigid = seen(found["shapes"][:modes]), seen(found["rigid"])
    loads = found["inertia"][: len(rigid)]
    nothing = np.zeros(len(core.cases)), np.zeros((0, 9)), np.zeros(0)
    sunk = [core.solve(np.ascontiguousarray(load), *nothing) for load in loads]
    between = np.einsum("rcn,scn->rs", loads, np.array(sunk)) if len(rigid) else np.zeros((0, 0))
    moved = seen(sunk)
    whole = flexibility_of(part.body.condense(sampling))
    # loads are balanced by inertia, and what they do is freed of rigid motion
    whole = whole - moved.T @ rigid - rigid.T @ moved + rigid.T @ between @ rigid
    residual = whole - (shapes.T / squares[:modes]) @ shapes
    inertia = found["inertia"][len(rigid) : len(rigid) + modes]
    turned = np.cross(part.body.mesh.nodes[None], inertia.transpose(0, 2, 1))
    participation = np.concatenate([inertia.sum(axis=2), turned.sum(axis=1)], axis=1)
    return Inertia(squares, shapes, rigid, 0.5 * (residual + residual.T), participation, float(found["mass"]))


def reduced(side: Side, name: Body, density: float, modes: int) -> ReducedBody:
    """See :meth:`mtb_rs.PreparedContact.reduced`."""
    density = positive("density", density, "kg/m3")
    modes = whole("modes", modes)
    if not side.state:
        raise ValueError(
            f"body is {name!r}: a body of finite elements is needed in this model, as half-spaces and rigid "
            "bodies have no vibrations"
        )
    bodies = [inertia_of(part, density, modes) for part in side.state]
    means = [part.body.core_mesh.averages(part.sampling()) for part in side.state]
    counts = [part.sampling().n_points for part in side.state]

    def beside(rows: Sequence[Array]) -> Array:
        """Rows (k, 3 n) of each body over the contact points of all of them (K, 3, N)."""
        out, first, row = np.zeros((sum(map(len, rows)), 3, sum(counts))), 0, 0
        for own, n in zip(rows, counts, strict=True):
            out[row : row + len(own), :, first : first + n] = own.reshape(len(own), 3, n)
            row, first = row + len(own), first + n
        return out

    squares = np.concatenate([one.squares[:modes] for one in bodies])
    order = np.argsort(squares, kind="stable")
    residual = np.zeros((3, sum(counts), 3, sum(counts)))
    for one, n, part in zip(bodies, counts, side.state, strict=True):
        cut = slice(part.first, part.first + n)
        residual[:, cut, :, cut] = one.residual.reshape(3, n, 3, n)
    size = 3 * sum(counts)
    return ReducedBody(
        points=np.concatenate([places for _, places, _ in means], axis=1),
        area=np.concatenate([part.sampling().weights for part in side.state]),
        frames=np.concatenate([frames for frames, _, _ in means], axis=2),
        frequency=np.sqrt(squares[order]) / (2.0 * np.pi),
        shapes=beside([one.shapes for one in bodies])[order],
        rigid=beside([one.rigid for one in bodies]),
        residual=residual.reshape(size, size),
        participation=np.concatenate([one.participation for one in bodies])[order],
        next_frequency=float(np.sqrt(min(one.squares[modes] for one in bodies)) / (2.0 * np.pi)),
        mass=float(sum(one.mass for one in bodies)),
        density=density,
    )
