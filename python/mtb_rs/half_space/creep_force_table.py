# SPDX-License-Identifier: MIT OR Apache-2.0
"""Creep forces by interpolation in a table of full solutions, for vehicle dynamics."""

from __future__ import annotations

import io
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import product
from pathlib import Path
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..base.check import number, pair, positive, reals, whole
from ..base.errors import MissingFileError
from ..base.files import TEXT, read_arrays, read_bytes, write_bytes
from ..base.owning import check_finite, owning
from ..base.plain import plain
from ..base.progress import shares_shown
from ..bodies.material import Material
from ..friction.laws import Coulomb, as_law
from .foundation import ellipses, local
from .pressure_field import creepage_rows, pressure_field
from .reference import elliptic_pressure
from .tangential import creep_curve

Array = NDArray[np.float64]

#: Normalised creepage at the middle of the table's scale, about where friction takes over.
_MIDDLE = 0.6
#: Difference of Poisson's ratio at which the creep coefficients differ by some 2 %.
_NEAR = 0.025
#: End of the table's scale t = c / (c + _MIDDLE); beyond, creepages are shortened along their direction.
_END = 0.95


@owning
@dataclass(frozen=True)
@plain
class CreepForceTable:
    """Forces of full steady rolling on ellipses, for any load, size, shear modulus and Coulomb friction.

    By similarity the forces over ``mu F_n`` depend on the ratio of the semi-axes, Poisson's ratio and the
    creepages times ``a b G / (mu F_n)`` alone (spin times another ``sqrt(a b)``). Each axis of the table is
    uniform in ``t = c / (c + 0.6)``, so small creepages are resolved as well as saturation. Interpolation is
    cubic.

    Attributes
    ----------
    poisson_ratio : float [-]
    ratios : (k,) [-]
        Semi-axis along the rolling direction over the one across it.
    scale : (m,) [-]
        t of longitudinal creepage and spin; lateral creepage takes both signs.
    forces : (k, m, 2 m - 1, m, 3) [-]
        Fx, Fy over mu F_n and Mz over mu F_n sqrt(a b), by ratio, xi >= 0, eta, phi >= 0.
    cells : int
        Over each axis of the ellipse in the solutions.
    """

    poisson_ratio: float
    ratios: Array
    scale: Array
    forces: Array
    cells: int

    def __post_init__(self) -> None:
        if not 0.0 <= number("poisson_ratio", self.poisson_ratio) <= 0.5:
            raise ValueError(f"poisson_ratio is {self.poisson_ratio!r}: a number from 0 to 0.5 is needed")
        whole("cells", self.cells)
        ratios = _rising(self.ratios)
        scale = reals("scale", self.scale)
        forces = reals("forces", self.forces)
        m = scale.size
        if scale.ndim != 1 or m < 4 or scale[0] != 0.0 or not np.allclose(np.diff(scale), scale[1]):
            raise ValueError(f"scale is {self.scale!r}: at least 4 even steps from 0 are needed")
        if forces.shape != (ratios.size, m, 2 * m - 1, m, 3):
            wanted = (ratios.size, m, 2 * m - 1, m, 3)
            raise ValueError(f"forces has shape {forces.shape}: {wanted} is needed")
        for name, values in (("ratios", ratios), ("scale", scale), ("forces", forces)):
            object.__setattr__(self, name, values)

    @classmethod
    def build(
        cls,
        ratios: Sequence[float] = (0.5, 0.7, 1.0, 1.4, 2.0),
        poisson_ratio: float = 0.28,
        nodes: int = 15,
        cells: int = 24,
        progress: Callable[[float], Any] | Literal[True] | None = None,
    ) -> CreepForceTable:
        """Solves for all entries: a few seconds to a minute for each ratio.

        Parameters
        ----------
        ratios : sequence of float [-]
            Rising.
        poisson_ratio : float [-]
            Of both bodies.
        nodes : int
            Per axis, at least 4.
        cells : int
            Over each axis of the ellipse; the error falls with the square of their size.
        progress : callable or True
            Called with the share done; True shows a bar (extra ``notebook``).
        """
        rising = _rising(ratios)
        whole("cells", cells)
        if whole("nodes", nodes) < 4:
            raise ValueError(f"nodes is {nodes}: at least 4 are needed")
        scale = np.linspace(0.0, _END, nodes)
        signed = np.concatenate([-scale[:0:-1], scale])
        modulus, friction, force = 80e9, 0.3, 1e4
        body = Material.from_shear_modulus(modulus, poisson_ratio)
        forces = np.zeros((rising.size, nodes, 2 * nodes - 1, nodes, 3))
        with shares_shown(progress, "tabulating") as told:
            for k, ratio in enumerate(rising):
                a, b = 4e-3 * np.sqrt(ratio), 4e-3 / np.sqrt(ratio)
                patch = elliptic_pressure(force, (a, b), (cells, cells), body, body)
                unit = friction * force / (a * b * modulus)
                for i, xi in enumerate(_creepage(scale)):
                    rows = [
                        (unit * xi, unit * eta, unit * phi / np.sqrt(a * b))
                        for eta, phi in product(_creepage(signed), _creepage(scale))
                    ]
                    found = creep_curve(patch, rows, Coulomb(friction), tolerance=1e-5, order=2)
                    found /= friction * force * np.array([1.0, 1.0, np.sqrt(a * b)])
                    forces[k, i] = found.reshape(2 * nodes - 1, nodes, 3)
                    told((k + (i + 1) / nodes) / rising.size)
        return cls(poisson_ratio, rising, scale, forces, cells)

    def interpolate(
        self,
        semi_axes: tuple[float, float],
        normal_force: float,
        shear_modulus: float,
        friction: float,
        creepages: ArrayLike,
    ) -> Array:
        """Forces on the lower body.

        Parameters
        ----------
        semi_axes : (a, b) [m]
            Along and across the rolling direction; the ratio must lie in the table.
        normal_force : float [N]
        shear_modulus : float [Pa]
            Of both bodies.
        friction : float [-]
        creepages : (n, 3)
            (xi, eta, phi) [-, -, 1/m]. Beyond the end of the table, in full sliding, they are scaled down to
            it along their direction: the lateral force of pure spin, which goes to zero there, stays at that
            of the end (9 % of `friction` times `normal_force` on a circle).

        Returns
        -------
        (n, 3) float
            Fx, Fy [N], together at most `friction` times `normal_force`, and Mz [N m]. Near full sliding the
            cubic swings: with rising creepage Fx falls by up to 0.05 % of that with 15 nodes, by 2 % with 5.
        """
        a, b = pair("semi_axes", semi_axes, "m")
        ratio = positive("semi_axes[0]", a, "m") / positive("semi_axes[1]", b, "m")
        positive("normal_force", normal_force, "N")
        positive("shear_modulus", shear_modulus, "Pa")
        if number("friction", friction) < 0.0:
            raise ValueError(f"friction is {friction!r}: a number of at least 0 is needed")
        low, high = self.ratios[0], self.ratios[-1]
        if not low * (1 - 1e-9) <= ratio <= high * (1 + 1e-9):
            raise ValueError(
                f"semi_axes have the ratio {ratio:g}: ratios from {low:g} to {high:g} are in the table"
            )
        limit = friction * normal_force
        rows = creepage_rows(creepages)
        if limit == 0.0:
            return np.zeros((len(rows), 3))
        c = rows * (a * b * shear_modulus / limit) * np.array([1.0, 1.0, np.sqrt(a * b)])
        # mirror images: xi -> -xi turns Fx only; (eta, phi) -> -(eta, phi) turns Fy and Mz
        turn_x = np.where(c[:, 0] < 0.0, -1.0, 1.0)
        turn_y = np.where(c[:, 2] < 0.0, -1.0, 1.0)
        c = c * np.stack([turn_x, turn_y, turn_y], axis=1)
        largest = _creepage(np.array([_END]))[0]
        c = c * np.minimum(1.0, largest / np.maximum(np.abs(c).max(axis=1), 1e-300))[:, None]
        t = c / (np.abs(c) + _MIDDLE)
        step = self.scale[1]
        weights = [
            _cubic((t[:, 0] / step), self.scale.size),
            _cubic(t[:, 1] / step + self.scale.size - 1, 2 * self.scale.size - 1),
            _cubic(t[:, 2] / step, self.scale.size),
        ]
        logs = np.log(self.ratios)
        lower = int(np.clip(np.searchsorted(logs, np.log(ratio)) - 1, 0, max(logs.size - 2, 0)))
        upper = min(lower + 1, logs.size - 1)
        share = 0.0 if upper == lower else (np.log(ratio) - logs[lower]) / (logs[upper] - logs[lower])
        table = (1.0 - share) * self.forces[lower] + share * self.forces[upper]
        found = np.zeros((len(rows), 3))
        for (i, wi), (j, wj), (k, wk) in product(*weights):
            found += (wi * wj * wk)[:, None] * table[i, j, k]
        # a cubic swings about full sliding, and Coulomb's friction is no larger
        found[:, :2] /= np.maximum(np.hypot(found[:, 0], found[:, 1]), 1.0)[:, None]
        found *= np.stack([turn_x, turn_y, turn_y], axis=1)
        forces = np.asarray(found * limit * np.array([1.0, 1.0, np.sqrt(a * b)]))
        check_finite("forces", forces)
        return forces

    def creep_forces(
        self,
        normal: Any,
        creepages: ArrayLike,
        friction: Coulomb,
        semi_axes: tuple[float, float] | None = None,
    ) -> Array:
        """Forces of a patch of any shape, by the ellipse of the same second moments.

        The forces of separate contacts are added, each with its own ellipse and the creepages about its own
        centre of pressure, as :func:`mtb_rs.fastsim` and :func:`mtb_rs.polach` do.

        Parameters
        ----------
        normal : NormalResult, Result or PressureField
            Rolling towards +x; between bodies whose Poisson's ratio is within 0.025 of that of the table.
        creepages : (n, 3)
            (xi, eta, phi) [-, -, 1/m].
        friction : Coulomb
            The mean over the patch counts, weighted by the pressure.
        semi_axes : (a, b) or None [m]
            Along and across the rolling direction, for a single contact; None takes the ellipse.

        Returns
        -------
        (n, 3) float
            Fx, Fy [N], and Mz [N m] about the origin.
        """
        field = pressure_field(normal)
        law = as_law(friction)
        if not law.is_constant:
            raise ValueError(
                f"friction is {friction!r}: a table of creep forces takes Coulomb's friction only"
            )
        rows = creepage_rows(creepages)
        modulus, ratio = field.pair_modulus()
        if abs(ratio - self.poisson_ratio) > _NEAR:
            raise ValueError(
                f"the bodies have the Poisson's ratio {ratio:.4g} and the table {self.poisson_ratio:.4g}: "
                f"it is good to within {_NEAR:g} of its own; build one with poisson_ratio={ratio:.4g}"
            )
        forces = np.zeros((len(rows), 3))
        for part, cut, axes, (x, y) in ellipses(field, semi_axes, "a table of creep forces"):
            mean = float(law.of_sliding(np.zeros(1), part.pressure, field.pressure.shape, cut)[0])
            own = self.interpolate(axes, part.normal_force, modulus, mean, local(rows, (x, y)))
            forces += own
            forces[:, 2] += x * own[:, 1] - y * own[:, 0]
        return forces

    def save(self, path: str | Path) -> None:
        """Writes the table as NPZ; the ending .npz is added where it is missing.

        Raises
        ------
        OSError
            If nothing can be written there.
        """
        stream = io.BytesIO()
        np.savez_compressed(
            stream,
            allow_pickle=False,
            poisson_ratio=self.poisson_ratio,
            ratios=self.ratios,
            scale=self.scale,
            forces=self.forces,
            cells=self.cells,
        )
        write_bytes(_npz(path), stream.getbuffer())

    @classmethod
    def load(cls, path: str | Path) -> CreepForceTable:
        """Reads a table written by :meth:`save`, at the same path.

        Raises
        ------
        ValueError
            For a file that holds no such table.
        """
        try:
            data = read_arrays(read_bytes(_npz(path), "creep-force table"), most=TEXT)
            missing = {"poisson_ratio", "ratios", "scale", "forces", "cells"} - set(data)
            if missing:
                raise ValueError(f"{sorted(missing)} missing")
            return cls(
                poisson_ratio=data["poisson_ratio"].item(),
                ratios=data["ratios"],
                scale=data["scale"],
                forces=data["forces"],
                cells=data["cells"].item(),
            )
        except MissingFileError:
            raise
        except ValueError as error:
            raise ValueError(f"{path} is no creep-force table: {error}") from None


def _npz(path: str | Path) -> Path:
    path = Path(path)
    return path if path.suffix == ".npz" else path.with_name(path.name + ".npz")


def _rising(ratios: ArrayLike) -> Array:
    rising = reals("ratios", ratios)
    if rising.ndim != 1 or rising.size < 1 or np.any(rising <= 0.0) or np.any(np.diff(rising) <= 0.0):
        raise ValueError(f"ratios is {ratios!r}: rising positive numbers are needed")
    return rising


def _creepage(t: Array) -> Array:
    """Normalised creepage at the table's scale."""
    return np.asarray(_MIDDLE * t / (1.0 - np.abs(t)))


def _cubic(position: Array, count: int) -> list[tuple[NDArray[np.intp], Array]]:
    """Indices and weights of four-point interpolation at `position` in units of nodes."""
    first = np.clip(np.floor(position).astype(np.intp) - 1, 0, count - 4)
    s = position - first
    result = []
    for k in range(4):
        weight = np.ones_like(s)
        for other in range(4):
            if other != k:
                weight = weight * (s - other) / (k - other)
        result.append((first + k, weight))
    return result
