# SPDX-License-Identifier: MIT OR Apache-2.0
"""Natural vibrations of elastic bodies."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from ..base.check import positive, whole
from ..base.owning import owning
from ..base.plain import plain
from ..base.stored import stored
from ..base.told import Row
from ..base.units import taking_quantities
from ..bodies.elastic_body import ElasticBody
from ..results.doors import pictures, png
from ..results.study import Study

Array = NDArray[np.float64]


@stored
@owning
@dataclass(frozen=True)
@plain
class Vibration(Study):
    """The lowest natural vibrations of an elastic body, as :func:`mtb_rs.vibration` finds them.

    A displacement of the body is a sum of its shapes times amplitudes q [m kg^1/2], and each vibration is a
    mass of 1 on a spring: q'' + (2 pi frequency)^2 q is the sum of its shape times the forces on the nodes.

    Attributes
    ----------
    frequency : (k,) [Hz]
        Rising.
    shapes : (k, 3, N) [kg^-1/2]
        Displacement of the nodes, x, y and z, orthonormal in the product of the mass. The largest component
        is positive. Vibrations of one frequency have any shapes that span the same.
    rigid : (r, 3, N) [kg^-1/2]
        The rigid motions that the supports leave free, likewise: orthonormal, and orthogonal to the shapes.
        Their frequency is zero.
    effective_mass : (k, 3) [kg]
        What of the mass each vibration moves along x, y and z, as seen from a support that shakes the body.
        Zero, but for rounding, of a body that is free along it. All vibrations of a body that is held
        together move its mass, less what the held nodes have.
    mass : float [kg]
    density : float [kg/m3]
    points : (3, N) [m]
        The nodes.
    triangles : (m, 3)
        Of the boundary, numbers of nodes, for pictures; those of six nodes in four parts.
    name : str
        Of the body.
    """

    usual_name: ClassVar[str] = "vibration"
    called: ClassVar[str] = "vibration"
    endings: ClassVar[tuple[str, ...]] = ("png", "csv")

    frequency: Array
    shapes: Array
    rigid: Array
    effective_mass: Array
    mass: float
    density: float
    points: Array
    triangles: NDArray[np.int64]
    name: str

    def plot(self, mode: int = 0, ax: Any = None) -> Any:
        """The body in one of its vibrations, much enlarged, over its shape at rest; returns the figure.

        Colours tell how far the nodes move, over the largest.

        Parameters
        ----------
        mode : int
            Which row of `shapes`.
        ax : mpl_toolkits.mplot3d.axes3d.Axes3D, optional
        """
        return pictures().draw_vibration(self, mode, ax)

    def animate(self, path: str | Path, mode: int = 0, frames_per_second: float = 12.0) -> Path:
        """A moving picture (.gif, .webp or .png) of one of the vibrations, much enlarged.

        Parameters
        ----------
        path : str or Path
        mode : int
            Which row of `shapes`.
        frames_per_second : float [1/s]
        """
        return Path(pictures().animate_vibration(self, path, mode, frames_per_second))

    def told(self) -> list[Row]:
        """Its figures in words: what a notebook shows beside the picture."""
        rows: list[Row] = [("body", self.name), ("mass", f"{self.mass:.4g} kg")]
        if len(self.rigid):
            rows.append(("free rigid motions", str(len(self.rigid))))
        for frequency, moved in zip(self.frequency, self.effective_mass, strict=True):
            shares = ", ".join(f"{share:.3f}" for share in moved / self.mass)
            rows.append((f"{frequency:.5g} Hz", f"moves ({shares}) of the mass along x, y, z"))
        return rows

    def exports(self) -> tuple[dict[str, bytes], list[str]]:
        """A picture of the lowest one, and frequencies and effective masses as CSV."""
        lines = ["frequency [Hz]," + ",".join(f"effective mass {c} [kg]" for c in "xyz")]
        rows = np.column_stack([self.frequency, self.effective_mass]).tolist()
        lines += [",".join(f"{value!r}" for value in row) for row in rows]
        with pictures().own_figures():
            return {"png": png(self.plot()), "csv": "".join(f"{line}\n" for line in lines).encode()}, []

    def check(self) -> None:
        """Checks that what was read from files fits together; ValueError if it does not."""
        k, n = self.frequency.size, self.points.shape[-1]
        shapes = {
            "shapes": (self.shapes, (k, 3, n)),
            "rigid": (self.rigid, (len(self.rigid), 3, n)),
            "effective_mass": (self.effective_mass, (k, 3)),
            "points": (self.points, (3, n)),
            "triangles": (self.triangles, (len(self.triangles), 3)),
        }
        for name, (values, shape) in shapes.items():
            if np.shape(values) != shape:
                raise ValueError(f"{name} has the shape {np.shape(values)}: {shape} is needed")

    def _repr_png_(self) -> bytes | None:
        """Its picture, for notebooks."""
        with pictures().own_figures():
            return png(self.plot())


@taking_quantities
def vibration(body: ElasticBody, density: float, modes: int = 12) -> Vibration:
    """The lowest natural vibrations of an elastic body on its supports.

    Supports rest at whatever displacement they are given, and guides are without mass and load. A body that
    its supports do not hold has rigid motions besides, which are known exactly. The contact does not hold it.
    The mass is the consistent one of the finite elements, whose frequencies are never below those of the body
    itself: they come down to them as the elements shrink.

    Parameters
    ----------
    body : ElasticBody
    density : float [kg/m3]
        Of steel, some 7850.
    modes : int
        How many, rigid motions not counted.

    Returns
    -------
    Vibration

    Raises
    ------
    ValueError
        If something cannot be as given, or the mesh is too large.

    Notes
    -----
    The stiffness is factorised once, with what :meth:`mtb_rs.Scene.solve` needs; a block Krylov space of its
    inverse holds the vibrations [GrimesLewisSimon1994].
    """
    if not isinstance(body, ElasticBody):
        raise ValueError(f"body is {body!r}: an ElasticBody is needed, as half-spaces have no vibrations")
    density = positive("density", density, "kg/m3")
    found = body.core.vibration(density, whole("modes", modes))
    inertia = found["inertia"][len(found["rigid"]) :]
    return Vibration(
        frequency=np.sqrt(found["squares"]) / (2.0 * np.pi),
        shapes=found["shapes"],
        rigid=found["rigid"],
        effective_mass=inertia.sum(axis=2) ** 2,
        mass=found["mass"],
        density=density,
        points=np.ascontiguousarray(body.mesh.nodes.T),
        triangles=_triangles(body.faces.astype(np.int64)),
        name=body.name,
    )


def _triangles(faces: NDArray[np.int64]) -> NDArray[np.int64]:
    """Plain triangles (m, 3) of the boundary (f, 3) or (f, 6)."""
    if faces.shape[1] == 3:
        return faces
    parts = [[0, 3, 5], [3, 1, 4], [5, 4, 2], [3, 4, 5]]
    return np.ascontiguousarray(faces[:, parts].reshape(-1, 3))
