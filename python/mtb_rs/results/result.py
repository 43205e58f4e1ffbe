# SPDX-License-Identifier: MIT OR Apache-2.0
"""What a solved scene returns: plain arrays and a report."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar, NamedTuple, Unpack, overload

import numpy as np
from numpy.typing import NDArray

from ..base.check import warn
from ..base.owning import solved
from ..base.plain import plain
from ..base.stored import input_data, stored
from ..base.told import Row, along, in_words, length
from ..base.words import Field, Flat, FlatOptions, Model, Space, SpaceOptions, Stress, StressOptions
from ..bodies.elastic_body import BodyState
from ..bodies.sides import ElasticPart
from ..geometry.contact_points import Patch
from ..geometry.triangles import Surface
from .derivatives import Differentiable, Functional, Tangent
from .doors import pictures, png
from .fields import Field as ResultField
from .fields import fields_of, normals, totals_of
from .report import Report
from .savable import Savable
from .solid import Solid, solid_of
from .stressed import Loads, Stressed, loaded_patches

if TYPE_CHECKING:
    import pyvista  # noqa: TID251 (only for type checkers)
    import xarray
    from matplotlib.figure import Figure  # noqa: TID251 (only for type checkers)

Array = NDArray[np.float64]


@stored
@plain
class Displacement(NamedTuple):
    """Displacement of both bodies at the contact points, each (3, ...) [m], common frame.

    For finite-element bodies it contains the elastic displacement and the prescribed and rigid motion. For
    half-spaces it is elastic only; their rigid part is the approach.
    """

    upper: Array
    lower: Array


class Drawn(Savable):
    """What draws and saves itself, as the result that :meth:`_picture` returns."""

    def _picture(self) -> Pictured:
        """Its fields over the contact points; ValueError if it has none, with the reason."""
        raise NotImplementedError

    #: The quantity that is drawn where none is asked for.
    _first_drawn: ClassVar[str] = "pressure"
    #: What it draws over its steps, where it has such.
    curves: ClassVar[tuple[str, ...]] = ()

    @property
    def blank(self) -> str:
        """Why it has no picture of its contact points; "" where it has one."""
        return ""

    def facts(self) -> dict[str, Any]:
        """What else its `summary.json` holds: inputs, the model, how good it is, the report."""
        return self._picture().facts()

    def check(self) -> None:
        """Checks that what was read from files fits together; ValueError if it does not."""
        if not self.blank:
            check_fields(self._picture())

    def fields(self) -> dict[str, ResultField]:
        """Its fields over the contact points, by name: values with unit and label."""
        return self._picture().fields()

    def totals(self) -> dict[str, ResultField]:
        """Its forces, moments and motions, by name: values with unit and label."""
        return self._picture().totals()

    @property
    def slip_unit(self) -> str:
        """Unit of the slip, as the first version told it: its field has it now."""
        name = type(self).__name__
        warn(f'{name}.slip_unit is fields()["slip"].unit now.', DeprecationWarning)
        slip = self.fields().get("slip")
        return "1" if slip is None else slip.unit

    def told(self) -> list[Row]:
        """Its forces, moments and motions in words: what a notebook and the command line show."""
        return [(total.label, in_words(total.values, total.unit)) for total in self.totals().values()]

    def _repr_png_(self) -> bytes | None:
        """The map of its first quantity, for notebooks."""
        with pictures().own_figures():
            return png(self.plot())

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

    def plot(self, quantity: Any = None, kind: Any = None, **options: Any) -> Any:
        """Picture of one quantity; see :func:`mtb_rs.pictures.plot`."""
        return self._draw(self._first_drawn if quantity is None else quantity, kind, options)

    def _draw(self, quantity: Any, kind: Any, options: dict[str, Any]) -> Any:
        return pictures().plot(self._picture(), quantity, kind, **options)

    def to_xarray(self) -> xarray.Dataset:
        """The fields as an :class:`xarray.Dataset` (extra ``sweep``), with units and labels as attributes.

        Fields on one regular grid have the dimensions (y, x), those on several patches, or on scattered
        points, have the dimension "point", and the coordinate "patch" names the patch of each. Places are the
        coordinates x, y, z [m]; vectors have the dimension "component" in front. Slip, which
        lies in the plane of contact, has a third component of zero where tractions have three. Totals are the
        attributes.

        Raises
        ------
        ImportError
            Without xarray; it names what to install.
        ValueError
            If the result has no contact points, with the reason.
        """
        labelled: xarray.Dataset = pictures().dataset_of(self._picture())
        return labelled

    def to_pyvista(self) -> pyvista.MultiBlock:
        """The result as datasets of pyvista (extra ``viz``), for its own plots, filters and files.

        The block "contact" has the contact patches with all fields, by the names of :meth:`fields`; the other
        blocks are the bodies by name, elastic ones with `displacement`, `stress` (xx, yy, zz, xy, yz, xz) and
        `von_mises` at their nodes. Lengths are in metres; the units of a block are its
        ``user_dict["units"]``.

        Raises
        ------
        ImportError
            Without pyvista; it names what to install.
        ValueError
            If the result has no contact points, with the reason.
        """
        return pictures().datasets(self._picture())

    def save(self, directory: str | Path) -> list[Path]:
        """Writes summary.json, NPZ, VTK and pictures; see :func:`mtb_rs.pictures.save`."""
        files: list[Path] = pictures().save(self, directory)
        return files


class Curved(Drawn):
    """What draws lines over its steps, its `curves`, besides its last state."""

    #: What the lines are over, in words.
    over: ClassVar[str]

    def _line(self, quantity: str, ax: Any) -> Figure:
        """The line of one of the curves."""
        raise NotImplementedError

    def ends(self) -> dict[str, float]:
        """Numbers that it has come to at its end, by name [SI]: the columns of a sweep."""
        raise NotImplementedError

    def _repr_png_(self) -> bytes | None:
        """Its first curve, for notebooks."""
        with pictures().own_figures():
            return png(self.plot())

    def plot(self, quantity: Any = None, kind: Any = None, **options: Any) -> Any:
        """Picture of one quantity.

        Parameters
        ----------
        quantity : str or None
            One of `curves`, over the steps; the first of them for None. Or a quantity of the last state, as
            :func:`mtb_rs.pictures.plot` draws them.
        kind, **options
            As :func:`mtb_rs.pictures.plot`; what is drawn over the steps takes `ax` only.

        Returns
        -------
        matplotlib.figure.Figure or pyvista.Plotter
        """
        quantity = self.curves[0] if quantity is None else quantity
        if quantity not in self.curves:
            pictures().check_quantity(self._picture(), quantity, self.curves)
            return super().plot(quantity, kind, **options)
        ax = options.pop("ax", None)
        if kind not in (None, "line"):
            raise ValueError(
                f"kind is {kind!r}: it draws the last state, and {quantity!r} is a line over {self.over}; "
                "another quantity is needed, such as 'pressure' (mtb-rs show: --quantity pressure)"
            )
        if options:
            given = ", ".join(options)
            raise ValueError(f"quantity is {quantity!r}: it is a line over {self.over}, and takes no {given}")
        return self._line(quantity, ax)


class Pictured(Drawn):
    """A result that draws and saves itself.

    It has at least ``points`` (2 or 3, ...), ``area``, ``pressure`` and ``status`` (...) on a grid (ny, nx),
    or on patches in rows (n,).
    """

    points: Array
    area: Array
    pressure: Array
    status: NDArray[np.int8]
    #: Regular grids of its points and surfaces of its bodies, where it has such.
    patches: tuple[Patch, ...] = ()
    surfaces: tuple[Surface, ...] = ()
    #: Angles (ny,) [rad] of its rows of cells, where they do not lie in a plane.
    inclination: Array | None = None
    #: Names of its fields over the contact points, and of its forces, moments and motions.
    _drawn: ClassVar[tuple[str, ...]] = ("points", "area", "pressure", "status")
    _summed: ClassVar[tuple[str, ...]] = ()

    def _picture(self) -> Pictured:
        return self

    def fields(self) -> dict[str, ResultField]:
        """Its fields over the contact points, by name: values with unit and label; with their normals where
        rows of cells are inclined."""
        values = {name: getattr(self, name) for name in self._drawn}
        if self.inclination is not None:
            values["normal"] = normals(self.inclination, self.pressure.shape[1])
        return fields_of(self._units(), **values)

    def _units(self) -> dict[str, str]:
        """Units of fields that are not the usual ones."""
        return {}

    def totals(self) -> dict[str, ResultField]:
        """Its forces, moments and motions, by name: values with unit and label."""
        return totals_of(**{name: getattr(self, name) for name in self._summed})

    def facts(self) -> dict[str, Any]:
        """What else its `summary.json` holds: inputs, the model, how good it is, the report."""
        return {}

    def peak_x(self) -> float | None:
        """x [m] of the largest pressure, where cuts along y go through; None where patches have frames of
        their own."""
        points, pressure = self.points, self.pressure.ravel()
        return float(points.reshape(len(points), -1)[0, pressure.argmax()])

    @property
    def has_solids(self) -> bool:
        """Whether it has elastic bodies of finite elements."""
        return False

    def solids(self) -> tuple[Solid, ...]:
        """Its elastic bodies of finite elements, with displacement and stress at their nodes."""
        return ()


def check_fields(result: Pictured) -> None:
    """Raises ValueError unless fields, grids and surfaces of a result fit together."""
    shape = result.pressure.shape
    fields = result.fields()
    if len(shape) not in (1, 2) or not result.pressure.size:
        raise ValueError(f"pressure has the shape {shape}: (n,) or (ny, nx) is needed")
    for name, entry in fields.items():
        values = entry.values
        sizes = (3,) if "vertical" in entry.parts or name == "normal" else (2, 3)
        wanted = [(k, *shape) for k in sizes] if entry.is_vector else [shape]
        if values.dtype.kind not in "fi" or values.shape not in wanted:
            raise ValueError(f"{name} has the shape {values.shape} beside a pressure of {shape}")
    if not np.isin(result.status, (0, 1, 2, 3)).all():
        raise ValueError("status holds other numbers than 0, 1, 2 and 3")
    if not np.all(result.area >= 0.0):
        raise ValueError("area is negative")
    first = 0
    for patch in result.patches:
        if patch.start != first or min(patch.nx, patch.ny) < 1 or not min(patch.spacing) > 0.0:
            raise ValueError(f"the grid {patch.name!r} does not fit the points")
        first += patch.nx * patch.ny
    if result.patches and first != result.pressure.size:
        raise ValueError(f"the grids have {first} points, the pressure {result.pressure.size}")
    for surface in (*result.surfaces, *(solid.surface for solid in result.solids())):
        count = surface.vertices.shape[-1]
        triangles, moved, stress = surface.triangles, surface.displacement, surface.von_mises
        if (
            surface.vertices.shape != (3, count)
            or triangles.ndim != 2
            or triangles.shape[1] != 3
            or (triangles.size and not 0 <= triangles.min() <= triangles.max() < count)
            or (moved is not None and moved.shape != (3, count))
            or (stress is not None and stress.shape != (count,))
            or not np.all(np.isfinite(surface.vertices))
        ):
            raise ValueError(f"the surface {surface.name!r} does not fit together")


class Judged:
    """What has a report on its solve: how good it is, in words."""

    status: NDArray[np.int8]
    report: Report

    def left_out(self) -> list[str]:
        """What the model leaves out, each with its estimated size."""
        quantity = self.report.aim[0] if self.report.aim is not None else "pressure"
        return [
            f"{effect} ({f'about {percent(size)} of the {quantity}' if isinstance(size, float) else size})"
            for effect, size in self.report.omitted.items()
        ]

    def errors_in_words(self) -> str:
        """Estimated errors, that of the quantity aimed at first; "not estimated" where there are none."""
        aim, tolerance = self.report.aim or ("pressure", None)
        errors = self.report.error_estimates
        words = []
        for name in sorted(errors, key=lambda name: name != aim):
            aimed = f" ({percent(tolerance)} aimed at)" if name == aim and tolerance is not None else ""
            words.append(f"{percent(errors[name])} of the {name}{aimed}")
        return ", ".join(words) or "not estimated"

    def _told_outcome(self) -> Row:
        report = self.report
        return "outcome", "converged" if report.converged else f"NOT converged: {report.status}"

    def _told_of_solve(self) -> list[Row]:
        report, closed = self.report, int(np.count_nonzero(self.status))
        rows = [
            ("contact area", f"{report.contact_area * 1e6:.6g} mm2, {closed} of {self.status.size} points"),
            ("peak pressure", f"{report.peak_pressure / 1e6:.5g} MPa"),
            ("iterations", f"{report.iterations}, residual {report.residual:.1e}"),
        ]
        rows += [("left out", words) for words in self.left_out()]
        if report.error_estimates:
            rows.append(("estimated error", self.errors_in_words()))
        if report.missed:
            rows.append(("tolerance", report.missed))
        return rows


class TangentialFields(Pictured):
    """Stick and slip on a grid (ny, nx), by any theory; vectors act on the lower body.

    Adds ``traction`` (3, ny, nx), ``slip`` (2, ny, nx) and ``force`` (3,): friction, minus the normal force.
    """

    traction: Array
    slip: Array
    force: Array
    spin_moment: float
    _drawn: ClassVar[tuple[str, ...]] = ("points", "area", "pressure", "traction", "slip", "status")
    _summed: ClassVar[tuple[str, ...]] = ("force", "spin_moment", "normal_force")

    @property
    def normal_force(self) -> float:
        """Sum of pressure times area [N]."""
        return -float(self.force[2])

    def told(self) -> list[Row]:
        """What acts and how much of the contact sticks: what a notebook and the command line show."""
        closed = float(self.area[self.status > 0].sum())
        stick = float(self.area[self.status == 1].sum()) / closed if closed > 0.0 else 0.0
        # what is rounding beside the forces on the width of the contact is zero
        is_rounding = abs(self.spin_moment) < 1e-12 * float(np.linalg.norm(self.force)) * np.sqrt(closed)
        return [
            ("normal force", in_words(self.normal_force, "N")),
            ("force on the lower body", along(self.force, "N")),
            ("moment of friction", in_words(0.0 if is_rounding else self.spin_moment, "N m")),
            ("sticks", f"{100.0 * stick:.4g} % of the contact area"),
            *self._told_of_yield(closed),
        ]

    def _told_of_yield(self, closed: float) -> list[Row]:
        yielding = float(self.area[self.status == 3].sum())
        return (
            [("layer yields", f"{100.0 * yielding / closed:.4g} % of the contact area")] if yielding else []
        )

    def _repr_png_(self) -> bytes | None:
        """Maps of the traction, and of where the surfaces stick and slip, for notebooks."""
        with pictures().own_figures():
            return png(pictures().plot_beside(self, ("traction", "status")))

    def __repr__(self) -> str:
        ny, nx = self.pressure.shape
        stick, slip, plastic = (np.count_nonzero(self.status == s) for s in (1, 2, 3))
        yielding = f", {plastic} plastic" if plastic else ""
        return (
            f"{type(self).__name__}({nx} x {ny} cells, {stick} stick, {slip} slip{yielding}, "
            f"force ({self.force[0]:.4g}, {self.force[1]:.4g}) N of {self.normal_force:.4g} N)"
        )


@stored
@solved
@dataclass(frozen=True, repr=False)
@plain
class Result(Judged, Differentiable, Stressed, Pictured):
    """The solved contact.

    Arrays have the shape of the contact grid: (ny, nx) for one patch with a height field, and (n,) where the
    arrays of the poles are concatenated, left (y > 0) first. Vectors have a leading axis of 3. Units are SI.
    A pressure >= 0 pushes the bodies apart, traction acts on the lower body, and a gap > 0 is open.

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
        0 open, 1 stick (and frictionless contact), 2 slip, 3 plastic: the yield stress of a
        :class:`PlasticLayer` limits the traction.
    displacement : Displacement
    force, moment : (3,) [N], [N m]
        Contact load (pressure and friction) on the lower body; moment about `reference_point`.
    normal_force : float [N]
        Sum of pressure times area, > 0.
    approach : float or (poles,) [m]
        > 0: the bodies moved together. Of an elastic body that its supports leave free it is the mean motion,
        weighted with the volume.
    error_estimate : float or None
        Relative, L2 of pressure over the contact away from border points.
    patches : tuple of Patch
    surfaces : tuple of Surface
        The bodies, for pictures.
    lower, upper : HalfSpace, Rigid or ElasticBody
        The bodies of the scene. A loaded result has half-spaces and rigid bodies without their surfaces, and
        None in place of an elastic body, which is among its :meth:`solids`.
    parts : tuple of ElasticPart
        The elastic bodies; :meth:`states` recovers their inside. A loaded result has none.
    coefficients : (3, n) [Pa]
        Unknowns of the solution: the traction along both tangents on the lower body, and the pressure.
    motion : (m,)
        Amplitudes of the rigid motions that only contact holds.
    magnetic_pressure : (...) [Pa] or None
        With which the bodies attract each other at each point, if they do: as given, or as a
        :class:`mtb_rs.Magnet` pulls at the gaps of the state.
    plastic_indentation : (...) or None [m]
        Depth to which one body has flowed, where the pressure is the hardness; None without a hardness.
    friction_power : float or None [W]
        Heat of sliding, >= 0: friction times velocity; None where nothing slides, or no velocity is stated.
    summary : Mapping
        Inputs of the scene, which `summary.json` repeats: the arguments of a ready scene, or the fields of a
        scene of your own. Functions are told by their name and digest; in a loaded result large arrays,
        meshes and surfaces as well.
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
    summary: Mapping[str, Any] = field(default_factory=dict, compare=False)
    lower: Any = field(default=None, compare=False)
    upper: Any = field(default=None, compare=False)
    parts: tuple[ElasticPart, ...] = field(default=(), compare=False)
    coefficients: Array | None = None
    motion: Array | None = None
    magnetic_pressure: Array | None = None
    loaded: tuple[Solid, ...] | None = field(default=None, repr=False, compare=False)
    plastic_indentation: Array | None = None
    friction_power: float | None = None
    _drawn: ClassVar[tuple[str, ...]] = (
        "points", "area", "normal", "pressure", "traction", "gap", "initial_gap", "status",
    )  # fmt: skip
    _summed: ClassVar[tuple[str, ...]] = ("force", "moment", "reference_point", "normal_force", "approach")

    def fields(self) -> dict[str, ResultField]:
        """Its fields over the contact points, by name: values with unit and label."""
        upper, lower = self.displacement
        pull = {} if self.magnetic_pressure is None else {"magnetic_pressure": self.magnetic_pressure}
        flowed = {} if self.plastic_indentation is None else {"plastic_indentation": self.plastic_indentation}
        moved = {"displacement_upper": upper, "displacement_lower": lower}
        return super().fields() | fields_of(None, **moved, **pull, **flowed)

    def totals(self) -> dict[str, ResultField]:
        """Its forces, moments and motions, by name: values with unit and label."""
        power = {} if self.friction_power is None else {"friction_power": self.friction_power}
        return super().totals() | totals_of(**power)

    def facts(self) -> dict[str, Any]:
        """What else its `summary.json` holds: inputs, the model, how good it is."""
        report = self.report.as_dict()
        return {
            "inputs": self.summary,
            "model": self.model,
            "error_estimate": self.error_estimate,
            "report": report,
        }

    @property
    def has_solids(self) -> bool:
        """Whether it has elastic bodies of finite elements."""
        return bool(self.parts or self.loaded)

    def solids(self) -> tuple[Solid, ...]:
        """The elastic bodies of finite elements, with displacement, stress and reactions, as plain data.

        The cost is that of :meth:`states`; a loaded result has the data already.
        """
        if self.loaded is not None:
            return self.loaded
        states = self.states().values()
        return tuple(solid_of(part, state) for part, state in zip(self.parts, states, strict=True))

    def _loads(self) -> Loads:
        count = self.pressure.size
        grids = loaded_patches(
            self.patches,
            self.points.reshape(3, -1),
            np.broadcast_to(self.area, self.pressure.shape).reshape(-1),
            self.pressure.reshape(-1),
            self.traction.reshape(3, count),
            self.normal.reshape(3, count),
            self.initial_gap.reshape(-1),
        )
        return Loads(grids, self.lower, self.upper, solids=self.solids if self.has_solids else None)

    def _kept(self) -> Result:
        bodies = {side: getattr(self, side) and getattr(self, side).kept() for side in ("lower", "upper")}
        kept = {"parts": (), "loaded": self.solids(), "summary": input_data(self.summary)}
        return replace(self, **kept, **bodies)

    def _tangent(self) -> Tangent:
        made: Tangent = self._linear().tangent
        return made

    def _functionals(self) -> Mapping[str, Callable[[], Functional]]:
        known: Mapping[str, Callable[[], Functional]] = self._linear().functionals()
        return known

    def _linear(self) -> Any:
        """The contact at this state, made once: its factors serve all derivatives."""
        # no field: what is put together from parts of a result was not solved
        known = vars(self)
        if "_linearised" in known:
            return known["_linearised"]
        if "_derived" in known:
            return known.setdefault("_linearised", known["_derived"].of(self))
        if self.report.method != "direct":
            raise ValueError(
                f"the result is of method={self.report.method!r}: derivatives are those of method='direct'"
            )
        if not self.report.converged:
            raise ValueError("the result is not converged: derivatives are those of a solution")
        raise ValueError(
            "this result was loaded or copied, without the matrices of its solution: derivatives are those "
            "of one that solve has just returned"
        )

    def __getstate__(self) -> dict[str, Any]:
        # without the matrices, and without the scene, whose functions need not be such as can be copied
        return {k: value for k, value in self.__dict__.items() if k not in ("_linearised", "_derived")}

    def states(self) -> dict[str, BodyState]:
        """The whole elastic bodies, by name: displacements, reactions and stresses inside.

        Costs one back-substitution for each body, and its factorisation if that is not in memory.

        Raises
        ------
        ValueError
            If the result was loaded; use its :meth:`solids`.
        """
        if self.loaded:
            raise ValueError(
                "this result was loaded: displacements, stresses and reactions of its bodies are in solids()"
            )
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
        lines += report.notes
        if (report.tipping_margin or 0.0) >= 0.005:
            lines.append(f"the resultant is {report.tipping_margin:.2f} of the way to tipping over")
        if (report.wedging_margin or 0.0) >= max(0.005, 1.001 * (report.tipping_margin or 0.0)):
            lines.append(
                f"friction is {report.wedging_margin:.2f} of the bound below which wedging is excluded"
            )
        return "\n".join(lines)

    @property
    def heading(self) -> str:
        """Nothing that :meth:`told` does not say."""
        return ""

    def told(self) -> list[Row]:
        """What was solved, what carries what, how well: what a notebook and the command line show."""
        report = self.report
        rows = [
            ("model", f"{report.model}, {report.method} ({report.solver})"),
            self._told_outcome(),
            ("normal force", in_words(self.normal_force, "N")),
            ("force on the lower body", along(self.force, "N")),
        ]
        size = float(np.linalg.norm(self.force))
        for name, value in report.force_balance.items():
            if isinstance(value, float):
                name = "force balance, relative" if name == "relative_error" else name
                rows.append((name, f"{value:.3g}"))
            elif name != "contact":
                # a component that is rounding beside the whole is zero
                cleaned = np.where(np.abs(value) < 1e-12 * size, 0.0, value)
                rows.append((name, along(cleaned, "N")))
        rows.append(("approach", ", ".join(length(value) for value in np.atleast_1d(self.approach))))
        return rows + self._told_of_solve()

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
