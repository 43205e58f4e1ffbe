# SPDX-License-Identifier: MIT OR Apache-2.0
"""What a solved scene returns: plain arrays and a report."""

from __future__ import annotations

import io
import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple, Unpack, overload

import numpy as np
from numpy.typing import NDArray

from .owning import owning, solved
from .plain import plain
from .report import Report
from .words import Field, Flat, FlatOptions, Model, Space, SpaceOptions, Stress, StressOptions

if TYPE_CHECKING:
    import pyvista  # noqa: TID251 (only for type checkers)
    from matplotlib.figure import Figure  # noqa: TID251 (only for type checkers)

    from .elastic import ElasticPart
    from .elastic_body import BodyState

Array = NDArray[np.float64]


@plain
class Displacement(NamedTuple):
    """Displacement of both bodies at the contact points, each (3, ...) [m], common frame.

    Elastic plus prescribed and rigid motion for finite-element bodies; elastic only for
    half-spaces, whose rigid part is the approach.
    """

    upper: Array
    lower: Array


@owning
@dataclass(frozen=True)
@plain
class Patch:
    """A regular grid of contact points inside the flat arrays of a result.

    ``points[:, start:start + nx * ny].reshape(3, ny, nx)`` is the patch's grid, x fastest; its points are
    `spacing` (dx, dy) [m] apart. In the plane into which the lower body is unrolled, x along the rows of the
    grid and y the arc length across them, the first one is at `origin` [m].
    """

    name: str
    start: int
    nx: int
    ny: int
    spacing: tuple[float, float]
    origin: tuple[float, float] = (0.0, 0.0)

    def axes(self) -> tuple[Array, Array]:
        """Coordinates [m] of the columns (nx,) and of the rows (ny,) in that plane."""
        (x0, y0), (dx, dy) = self.origin, self.spacing
        return np.asarray(x0 + dx * np.arange(self.nx)), np.asarray(y0 + dy * np.arange(self.ny))

    def view(self, values: NDArray[Any]) -> NDArray[Any]:
        """`values` (..., n) of a whole result, cut to this patch and shaped (..., ny, nx)."""
        part = values[..., self.start : self.start + self.nx * self.ny]
        return part.reshape(*values.shape[:-1], self.ny, self.nx)


@owning
@dataclass(frozen=True)
@plain
class Surface:
    """A triangulated body for pictures: vertices (3, n) [m], triangles (m, 3), displacement (3, n) [m].

    Elastic bodies of finite elements also have von Mises' equivalent stress (n,) [Pa].
    """

    name: str
    vertices: Array
    triangles: NDArray[np.int64]
    displacement: Array | None = None
    von_mises: Array | None = None


class Drawn:
    """What draws and saves itself, as the result that :meth:`_picture` returns."""

    def _picture(self) -> Pictured:
        raise NotImplementedError

    def _repr_png_(self) -> bytes | None:
        """The pressure map, for notebooks."""
        from .plot import own_figures

        with own_figures():
            return png(self.plot("pressure"))

    @overload
    def plot(
        self, quantity: Field = ..., kind: Flat | None = ..., **options: Unpack[FlatOptions]
    ) -> Figure: ...

    @overload
    def plot(self, quantity: Field, kind: Space, **options: Unpack[SpaceOptions]) -> pyvista.Plotter: ...

    @overload
    def plot(
        self, quantity: Field = ..., *, kind: Space, **options: Unpack[SpaceOptions]
    ) -> pyvista.Plotter: ...

    @overload
    def plot(
        self, quantity: Stress, kind: Space | None = ..., **options: Unpack[StressOptions]
    ) -> pyvista.Plotter: ...

    def plot(self, quantity: Any = "pressure", kind: Any = None, **options: Any) -> Any:
        """Picture of one quantity; see :func:`mtb_rs.plot.plot`."""
        from .plot import plot

        return plot(self._picture(), quantity, kind, **options)

    def save(self, directory: str | Path) -> list[Path]:
        """Writes summary.json, NPZ, VTK and pictures; see :func:`mtb_rs.export.save`."""
        from .export import save

        return save(self._picture(), directory)


class Pictured(Drawn):
    """A result that draws and saves itself.

    It has at least ``points`` (2 or 3, ...), ``area``, ``pressure`` and ``status`` (...) on a grid (ny, nx),
    or on patches in rows (n,).
    """

    points: Array
    area: Array
    pressure: Array
    status: NDArray[np.int8]

    def _picture(self) -> Pictured:
        return self

    @property
    def slip_unit(self) -> str:
        """Unit of the slip, if there is one: relative in rolling."""
        return "-"

    @property
    def dissipation_unit(self) -> str:
        """Unit of the dissipation, if there is one: work per area and distance rolled."""
        return "Pa"


def png(figure: Figure) -> bytes:
    """The figure as a file."""
    buffer = io.BytesIO()
    figure.savefig(buffer, format="png")
    return buffer.getvalue()


class TangentialFields(Pictured):
    """Stick and slip on a grid (ny, nx), by any theory; vectors act on the lower body.

    Adds ``traction`` (3, ny, nx), ``slip`` (2, ny, nx) and ``force`` (3,): friction, minus the normal force.
    """

    force: Array

    @property
    def normal_force(self) -> float:
        """Sum of pressure times area [N]."""
        return -float(self.force[2])

    def __repr__(self) -> str:
        ny, nx = self.pressure.shape
        stick, slip = (np.count_nonzero(self.status == s) for s in (1, 2))
        return (
            f"{type(self).__name__}({nx} x {ny} cells, {stick} stick, {slip} slip, "
            f"force ({self.force[0]:.4g}, {self.force[1]:.4g}) N of {self.normal_force:.4g} N)"
        )


@solved
@dataclass(frozen=True, repr=False)
@plain
class Result(Pictured):
    """The solved contact.

    Arrays have the shape of the contact grid: (ny, nx) for one patch with a height field, (n,) where
    poles are concatenated, left (y > 0) first; vectors have a leading 3. SI units; pressure >= 0
    pushes apart, traction acts on the lower body, gap > 0 is open.

    Attributes
    ----------
    points : (3, ...) [m]
        Undeformed contact points, common frame.
    area : (...) [m2]
        Area that belongs to each point.
    normal : (3, ...) [-]
        Unit normal of the lower body at each point, pointing to the upper one.
    pressure : (...) [Pa]
    traction : (3, ...) [Pa]
        Friction only, on the lower body.
    gap : (...) [m]
        Deformed gap, >= 0.
    initial_gap : (...) [m]
    status : (...) int
        0 open, 1 stick (and frictionless contact), 2 slip.
    displacement : Displacement
    force, moment : (3,) [N], [N m]
        Contact load (pressure and friction) on the lower body; moment about `reference_point`.
    normal_force : float [N]
        Sum of pressure times area, > 0.
    approach : float or (poles,) [m]
        > 0: the bodies moved together.
    error_estimate : float or None
        Relative, L2 of pressure over the contact away from border points.
    patches : tuple of Patch
    surfaces : tuple of Surface
        The bodies, for pictures.
    lower, upper : HalfSpace, Rigid or ElasticBody
        The bodies of the scene.
    parts : tuple of ElasticPart
        The elastic bodies; their insides are recovered by :meth:`states`.
    coefficients : (3, n) [Pa]
        Unknowns of the solution: traction along both tangents on the lower body, and pressure.
    motion : (m,)
        Amplitudes of the rigid motions that only contact holds.
    summary : Mapping
        Inputs of the scene worth repeating in `summary.json`.
    """

    # what the user has said
    _unbounded = ("summary",)

    points: Array
    area: Array
    normal: Array
    pressure: Array
    traction: Array
    gap: Array
    initial_gap: Array
    status: NDArray[np.int8]
    displacement: Displacement
    force: Array
    moment: Array
    reference_point: Array
    normal_force: float
    approach: float | Array
    model: Model
    error_estimate: float | None
    report: Report
    patches: tuple[Patch, ...] = ()
    surfaces: tuple[Surface, ...] = ()
    summary: Mapping[str, Any] = field(default_factory=dict)
    lower: Any = None
    upper: Any = None
    parts: tuple[ElasticPart, ...] = field(default=(), compare=False)
    coefficients: Array | None = None
    motion: Array | None = None

    def states(self) -> dict[str, BodyState]:
        """The whole elastic bodies, by name: displacements, reactions and stresses inside.

        Costs one back-substitution for each body, and its factorisation if that is not in memory.
        """
        assert self.coefficients is not None or not self.parts
        states = {}
        first = 0
        for part in self.parts:
            motion = np.asarray(self.motion)[first : first + len(part.modes)]
            first += len(part.modes)
            states[part.body.name] = part.state(np.asarray(self.coefficients), motion)
        return states

    def __str__(self) -> str:
        """What was modelled, what was left out, how good it is."""
        lines = [repr(self)[1:-1]]
        report = self.report
        cells = "" if report.spacing is None else f" on cells of {_size(report.spacing)}"
        lines.append(f"modelled: {self.model}{cells}; {report.solver}")
        lines += [f"left out: {words}" for words in self.left_out()]
        if report.error_estimates:
            lines.append(f"estimated total error: {self.errors_in_words()}")
        if report.missed:
            lines.append(report.missed)
        if (report.tipping_margin or 0.0) >= 0.005:
            lines.append(f"the resultant is {report.tipping_margin:.2f} of the way to tipping over")
        if (report.wedging_margin or 0.0) >= max(0.005, 1.001 * (report.tipping_margin or 0.0)):
            lines.append(
                f"friction is {report.wedging_margin:.2f} of the bound below which wedging is excluded"
            )
        return "\n".join(lines)

    def left_out(self) -> list[str]:
        """What the model leaves out, each with its estimated size."""
        quantity = self.report.aim[0] if self.report.aim is not None else "pressure"
        return [
            f"{effect} ({f'about {percent(size)} of the {quantity}' if isinstance(size, float) else size})"
            for effect, size in self.report.omitted.items()
        ]

    def errors_in_words(self) -> str:
        """Estimated errors, that of the quantity aimed at first."""
        aim, tolerance = self.report.aim or ("pressure", None)
        errors = dict(self.report.error_estimates)
        # that of the quantity aimed at first
        words = []
        for name in sorted(errors, key=lambda name: name != aim):
            aimed = f" ({percent(tolerance)} aimed at)" if name == aim and tolerance is not None else ""
            words.append(f"{percent(errors[name])} of the {name}{aimed}")
        return ", ".join(words)

    def __repr__(self) -> str:
        closed = int(np.count_nonzero(self.status))
        outcome = "converged" if self.report.converged else "NOT converged"
        return (
            f"<Result: {self.model}, {self.status.size} points, {closed} in contact, normal force "
            f"{self.normal_force:.6g} N, peak pressure {self.report.peak_pressure:.4g} Pa, {outcome}>"
        )


def percent(share: float) -> str:
    """A relative error in words."""
    if not math.isfinite(share):
        return "beyond all bounds"
    if share >= 1.0:
        return f"{100.0 * share:.0f} %"
    return f"{100.0 * share:.2g} %" if share >= 1e-4 else "below 0.01 %"


def _size(spacing: tuple[float, float]) -> str:
    unit, scale = ("mm", 1e3) if min(spacing) >= 1e-4 else ("\N{MICRO SIGN}m", 1e6)
    return f"{scale * spacing[0]:.3g} x {scale * spacing[1]:.3g} {unit}"
