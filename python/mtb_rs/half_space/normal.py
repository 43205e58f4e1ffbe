# SPDX-License-Identifier: MIT OR Apache-2.0
"""Frictionless contact of two half-spaces on a regular grid."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any, ClassVar, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .. import _mtb_rs
from ..base import memory
from ..base.check import choice, flag, number, positive, reals, shortened, warn
from ..base.errors import ConvergenceError, ToleranceWarning
from ..base.owning import solved
from ..base.plain import plain
from ..base.questions import ask
from ..base.stored import stored
from ..base.told import Row, in_words, length
from ..base.units import taking_quantities
from ..base.words import Convolution, Edge
from ..bodies.material import Material, of_material
from ..bodies.prism import Prism
from ..bodies.simple import (
    BESIDE_ROLLING,
    Core,
    FieldBody,
    Simple,
    are_compound,
    are_layered,
    are_prisms,
    do_creep,
    field_body,
    medium_of,
    velocity_over,
)
from ..friction.laws import ThinLayer, normal_flexibility
from ..friction.rough_law import RoughLaw
from ..geometry.contact_points import spacing_pair
from ..geometry.geometries import slip_of_gap
from ..results.derivatives import Differentiable, Functional, Margin
from ..results.fields import Field, fields_of, totals_of
from ..results.plausible import of_layers, of_result, of_width
from ..results.report import Report
from ..results.result import Judged, Pictured
from ..results.stressed import BELOW_INCLINED, Loads, Stressed, loaded_grid
from .compound import Compound, opened_by_terms, opened_by_waves
from .interpenetration import Quick, press
from .motions import Motion
from .normal_tangent import Bodies, NormalTangent, of_constants
from .pressure_field import PressureField, inclination_of
from .prisms import Prisms, prisms_under

Array = NDArray[np.float64]

#: How often a grid is enlarged, by half each time, before the contact counts as endless.
_ENLARGEMENTS = 6

#: Cells along a side from which the gap can be continued beyond it.
_CONTINUABLE = 3

#: Relative error of a prescribed force that rounding may leave.
FORCE_TOLERANCE = 1e-6

_FAILURES = {
    "stagnated": "the residual stopped falling at {0.residual:.1e}, above the tolerance of "
    "{0.tolerance:.1e}: ask for a larger tolerance",
    "iteration limit": "no convergence in {0.iterations} iterations: the residual is {0.residual:.1e}, "
    "the tolerance {0.tolerance:.1e}",
    "unreachable": "no pressure on this grid carries that force with these moments",
}


@stored
@solved
@dataclass(frozen=True, repr=False)
@plain
class NormalResult(Judged, Differentiable, Stressed, Pictured):
    """The solved frictionless contact; arrays (ny, nx), SI units.

    Attributes
    ----------
    points : (3, ny, nx) [m]
        Cell centres; the middle of the grid is (0, 0), z is 0.
    area : (ny, nx) [m2]
    spacing : (float, float) [m]
    pressure : (ny, nx) [Pa]
        Uniform on each cell, >= 0.
    gap, initial_gap : (ny, nx) [m]
        Deformed and undeformed, > 0 open.
    status : (ny, nx) int
        0 open, 1 in contact.
    approach : float [m]
        > 0: the bodies moved together. In a periodic contact it is measured from the mean of the
        displacements.
    tilts : (float, float) [-]
        Closing rotations that were found for prescribed moments: the gap falls by the first per unit of x,
        and by the second per unit of y.
    normal_force : float [N]
    contact_area : float [m2]
    lower, upper : HalfSpace, Layered, Viscoelastic, Prism or Rigid
    periodic : bool
    error_estimate : float or None
        Relative error of the pressure by the size of the cells (L2 over the contact away from its border),
        estimated from coarser grids; None if there is no estimate. It leaves out the border of the
        contact, where the error is largest, so that it can be several times smaller than that of a scene,
        which has the border.
    report : Report
    normal_layer : float or RoughLayer [m/Pa]
        Flexibility of the layer between the bodies; 0 for none.
    hardness : float or None [Pa]
        As given.
    plastic_indentation : (ny, nx) or None [m]
        Depth to which the softer body has flowed, where the pressure is the hardness; None without a
        hardness.
    rolling_velocity : (float, float) or None [m/s]
        Velocity (x, y) of the contact over bodies that creep; None of other bodies.
    inclination : (ny,) or None [rad]
        Of each row of cells, as given or of the surface of a prism; None on a plane, and on a prism in
        results that were stored by an earlier version.
    """

    points: Array
    area: Array
    spacing: tuple[float, float]
    pressure: Array
    gap: Array
    initial_gap: Array
    status: NDArray[np.int8]
    approach: float
    tilts: tuple[float, float]
    normal_force: float
    contact_area: float
    lower: FieldBody
    upper: FieldBody
    periodic: bool
    error_estimate: float | None
    report: Report
    normal_layer: float | RoughLaw = 0.0
    hardness: float | None = None
    plastic_indentation: Array | None = None
    rolling_velocity: tuple[float, float] | None = None
    inclination: Array | None = None
    _drawn: ClassVar[tuple[str, ...]] = ("points", "area", "pressure", "gap", "initial_gap", "status")
    _summed: ClassVar[tuple[str, ...]] = ("normal_force", "approach", "tilts")

    @property
    def rolling_resistance(self) -> float:
        """Force [N] that the creep of the bodies puts up against the rolling.

        It is what the pressure works for each metre rolled: the sum of pressure times area times the slope
        at which the surfaces give way along the way, by differences of fourth order. In the contact this is
        the slope of the undeformed gap less the tilts, so that times the radius of a cylinder on a plane it
        is the moment of the pressure about its axis; beside sharp edges the surfaces are bent, and the gap
        jumps.

        Raises
        ------
        ValueError
            Where no body creeps, and where there is pressure in the outermost cells along the way, beyond
            which it is not known how the surfaces give way.
        """
        return self._known_resistance()

    def _known_resistance(self) -> float:
        if self.rolling_velocity is None:
            raise ValueError("no body is Viscoelastic: elastic bodies put up no resistance to rolling")
        found = self._resistance()
        if found is None:
            raise ValueError(
                "the pressure reaches the edge of the grid, beyond which it is not known how the surfaces "
                "give way: the resistance to rolling needs at least one open cell ahead of the contact and "
                "one behind it; where a body ends, give the gap beyond its edge as a height above the contact"
            )
        return found

    def _resistance(self) -> float | None:
        """The rolling resistance [N]; None where no body creeps or the pressure reaches the edge."""
        if self.rolling_velocity is None:
            return None
        return _resistance(
            self.rolling_velocity,
            _given_way(self.gap, self.initial_gap, self.points, self.tilts),
            self.pressure * self.area,
            self.spacing,
        )

    @property
    def resultant(self) -> Array:
        """Force (3,) [N] of the pressure on the lower body: along x, along y of the row that is level, up; of
        prisms in the frame of their section."""
        if self.inclination is None:
            # of a prism that an earlier version stored they are not known, which this says
            self._prisms()
        angles = np.zeros(self.pressure.shape[0]) if self.inclination is None else self.inclination
        rows = self.pressure.sum(axis=1) * (self.spacing[0] * self.spacing[1])
        return np.array([0.0, float(rows @ np.sin(angles)), -float(rows @ np.cos(angles))])

    #: Its cells go along the surface of prisms, and not over a plane.
    is_in_rows: ClassVar[bool] = True

    def _prisms(self) -> Prisms | None:
        """The prisms under its cells; None without one."""
        ny, nx = self.pressure.shape
        first = float(self.points[1, 0, 0])
        return prisms_under(self.lower, self.upper, first, (ny, nx), self.spacing)

    def facts(self) -> dict[str, Any]:
        """What else its `summary.json` holds: how good it is, the report."""
        return {"error_estimate": self.error_estimate, "report": self.report.as_dict()}

    def told(self) -> list[Row]:
        """What presses, how far in, how well it is solved: what notebooks and the command line show."""
        rows = [
            self._told_outcome(),
            ("normal force", in_words(self.normal_force, "N")),
            ("approach", length(self.approach)),
        ]
        if any(self.tilts):
            rows.append(("tilts", ", ".join(in_words(1e3 * tilt, "mrad") for tilt in self.tilts)))
        if (resistance := self._resistance()) is not None:
            rows.append(("rolling resistance", in_words(resistance, "N")))
        return rows + self._told_of_solve()

    def totals(self) -> dict[str, Field]:
        """Its forces and motions, by name, the rolling resistance where a body creeps."""
        if (resistance := self._resistance()) is None:
            return super().totals()
        return super().totals() | totals_of(rolling_resistance=resistance)

    def fields(self) -> dict[str, Field]:
        """Its fields over the contact points, by name, the indentation where there is a hardness."""
        if self.plastic_indentation is None:
            return super().fields()
        return super().fields() | fields_of(plastic_indentation=self.plastic_indentation)

    def _loads(self) -> Loads:
        if self.inclination is not None and self.lower.is_half_space and self.upper.is_half_space:
            raise ValueError(BELOW_INCLINED)
        grid = loaded_grid(self.points, self.spacing, self.pressure)
        rolled = self.rolling_velocity
        way = None if rolled is None else float(np.arctan2(rolled[1], rolled[0]))
        return Loads((grid,), self.lower, self.upper, is_periodic=self.periodic, way=way)

    def _kept(self) -> NormalResult:
        return replace(self, lower=self.lower.kept(), upper=self.upper.kept())

    def _tangent(self) -> NormalTangent:
        """Its derivatives by all that was given, with the cells in contact held."""
        problem: _Problem | None = vars(self).get("_problem")
        if problem is None and self.report.status == "approximate":
            raise ValueError(
                f"this pressure is an approximation by {self.report.method!r}, of which no derivatives are "
                'known: solve_normal(..., method="auto") has them'
            )
        if problem is None:
            raise ValueError(
                "this result was read from a file or put together, and does not know what was given: "
                "derivatives are those of a result that solve_normal has just returned"
            )
        core = problem.linearised(self)
        shape = (self.pressure.shape[0], self.pressure.shape[1])
        load: Literal["force", "approach"] = "approach" if problem.force is None else "force"
        layer = self.normal_layer
        law = layer.slopes(self.pressure) if isinstance(layer, RoughLaw) else {}
        flexibility = 0.0 if isinstance(layer, RoughLaw) else layer
        moved, made = self._opened_by_moduli(), vars(self)["_made"]
        bodies = Bodies(self.lower, self.upper, flexibility, self._flows(), law, moved, made)
        return NormalTangent(core, shape, load, problem.moments, bodies, self._margin())

    def _opened_by_moduli(self) -> dict[str, Callable[[], Array]]:
        """What a unit of each modulus opens (ny, nx) [m] at these pressures, where a body is no half-space of
        one elastic material; and of the velocity and direction of rolling over what creeps."""
        prisms, bodies = self._prisms(), {"lower": self.lower, "upper": self.upper}
        if prisms is None and not are_compound(*bodies.values()):
            return {}
        load = np.stack([np.zeros_like(self.pressure), np.zeros_like(self.pressure), self.pressure])
        moved: dict[str, Callable[[], Array]] = {}
        for name in [] if prisms is None else prisms.moduli:
            assert prisms is not None
            moved[name] = partial(prisms.opened_by, name, load)
        if self.periodic:
            varied = {f"{side}.{name}": body for side, body in bodies.items() for name in body.constants}
            return {name: partial(self._opened_by_waves, body, name) for name, body in varied.items()}
        for side, body in bodies.items():
            if body.is_half_space and body.material is not None:
                for name, slope in of_constants(body.material).items():
                    moved[f"{side}.{name}"] = partial(_opened_at, slope, load, self.spacing)
        compound = Compound(self.lower, self.upper, self.rolling_velocity, self.spacing)
        motions = {f"rolling.{name}": terms for name, terms in compound.motions.items()}
        for name, terms in (compound.numbers | motions).items():
            moved[name] = lambda terms=terms: opened_by_terms(terms(), load, self.spacing)  # type: ignore[misc]
        return moved

    def _opened_by_waves(self, body: Any, name: str) -> Array:
        """What a unit of a constant, such as ``"lower.thickness"``, opens in a periodic contact."""
        opened = np.zeros_like(self.pressure)
        for weight, changed in body.varied(name.partition(".")[2]):
            opened += weight * opened_by_waves(changed, self.pressure, self.spacing)
        return opened

    def _flows(self) -> NDArray[np.bool_] | None:
        """Whether each cell is at the hardness (ny, nx); None without one."""
        return None if self.hardness is None else np.asarray(self.pressure >= self.hardness)

    def _margin(self) -> Margin:
        loaded, flows = self.status > 0, self._flows()
        if not loaded.any():
            rest = () if flows is None else (None, None, None, np.inf, np.inf)
            return Margin(np.inf, Margin.of_first_touch(self.gap), *rest)
        moved, beside = np.abs(_opened(self)[loaded]).max(), self.gap[~loaded]
        yielding = unloading = None
        if flows is not None:
            assert self.hardness is not None
            assert self.plastic_indentation is not None
            elastic, plastic = self.pressure[loaded & ~flows], self.plastic_indentation[flows]
            yielding = 1.0 - float(elastic.max() / self.hardness) if elastic.size else np.inf
            unloading = float(plastic.min() / moved) if plastic.size else np.inf
        return Margin(
            parting=float(self.pressure[loaded].min() / self.pressure.max()),
            touching=float(beside.min() / moved) if beside.size else np.inf,
            yielding=yielding,
            unloading=unloading,
        )

    def _functionals(self) -> dict[str, Callable[[], Functional]]:
        of_pressure = Functional.of_pressure(lambda: self.pressure, self.area, self.status > 0)
        return {**of_pressure, "rolling_resistance": self._resisting}

    def _resisting(self) -> Functional:
        """The rolling resistance, which is bilinear in the pressure and in what the surfaces give way."""
        try:
            self._known_resistance()
        except ValueError as unknown:
            raise ValueError(f"of is 'rolling_resistance': {unknown}") from None
        assert self.rolling_velocity is not None
        given_way = _given_way(self.gap, self.initial_gap, self.points, self.tilts)
        forces = self.pressure * self.area
        of_pressure, of_way = np.zeros((2, *self.pressure.shape))
        x, y = self.rolling_velocity
        for axis, part in _ways(self.rolling_velocity):
            cell = self.spacing[1 - axis]
            u, f = np.moveaxis(given_way, axis, 0), np.moveaxis(forces, axis, 0)
            np.moveaxis(of_pressure, axis, 0)[1:-1] -= part * _slopes(u, cell)
            matrix = _slopes(np.eye(len(u)), cell)
            np.moveaxis(of_way, axis, 0)[...] -= part * np.tensordot(matrix.T, f[1:-1], 1)
        weights = {
            "pressure": of_pressure * self.area,
            "gap": of_way,
            "tilts": np.array([float((of_way * self.points[k]).sum()) for k in (0, 1)]),
        }
        explicit, refused = {"gap": -of_way[None]}, {}
        # turned by a right angle, the way goes across
        turned = _resistance((-y, x), given_way, forces, self.spacing)
        if turned is None:
            refused["rolling.angle"] = (
                "the pressure reaches the edge of the grid across the way, and what resists there is unknown"
            )
        else:
            explicit["rolling.angle"] = np.array([turned])
        return Functional((), {name: w[None] for name, w in weights.items()}, explicit, refused)

    def __repr__(self) -> str:
        ny, nx = self.pressure.shape
        return (
            f"NormalResult({nx} x {ny} cells, force {self.normal_force:.4g} N, "
            f"approach {self.approach:.4g} m, peak {self.report.peak_pressure:.4g} Pa, "
            f"area {self.contact_area:.4g} m2, {self.report.status})"
        )


@taking_quantities
def solve_normal(
    gap: ArrayLike,
    spacing: float | tuple[float, float],
    *,
    lower: Material | Simple | Prism,
    upper: Material | Simple | Prism,
    force: float | None = None,
    approach: float | None = None,
    moments_about_axes: Sequence[float | None] = (None, None),
    tolerance: float | None = None,
    periodic: bool = False,
    edge: Edge = "auto",
    method: Convolution = "auto",
    moments: Sequence[float | None] | None = None,
    normal_layer: float | ThinLayer | RoughLaw = 0.0,
    hardness: float | None = None,
    rolling: Motion | None = None,
    inclination: ArrayLike | None = None,
) -> NormalResult:
    """Pressure that presses two elastic half-spaces together without friction.

    Parameters
    ----------
    gap : (ny, nx) float [m]
        Undeformed gap at the cell centres of a regular grid, > 0 open; any height field.
    spacing : float or (float, float) [m]
        Cell sides along x and along y.
    lower, upper : Material, HalfSpace, Layered, Viscoelastic, Prism or Rigid
        A material means a half-space of this material; one body may be rigid. With a prism, such as a rail
        whose gauge corner is in the root of a flange, y and `spacing` go along its surface from its `origin`,
        and the gap and the approach along the normals of its rows; the other body is a prism as well, a
        half-space or rigid.
    force : float [N]
        Normal force. Give either this or `approach`.
    approach : float [m]
        Distance by which the bodies moved together. Up to the smallest gap they do not touch.
    moments_about_axes : (mx, my) [N m], None for each that is not given
        Moments of the load on the upper body about the x and the y axis through the middle of the grid, as
        `moments` of :class:`mtb_rs.Scene`: the force F at (x, y) has (-F y, F x). The upper body tilts
        freely about an axis whose moment is given; its other tilts are locked.
    tolerance : float or None [-]
        Relative complementarity residual to reach: the largest gap where there is pressure or penetration
        where there is none, over the root mean square of the elastic displacement where there is pressure,
        which contains the compression of a layer (`normal_layer`).
        With None it follows the estimated discretisation error and stays well below it.
    periodic : bool
        Whether the grid repeats itself periodically. The approach is then measured from the mean of the
        displacements; of layers on rigid bases it contains their mean compression.
    edge : {"auto", "error", "sharp", "grow"}
        Meaning of contact at the edge of the grid. With "error" the bodies go on there, and the grid is too
        small. With "sharp" a body ends there, like a punch. With "grow" the gap is continued smoothly, and
        the grid grows until the contact ends inside. "auto" is "sharp" for a plane gap and otherwise "error".
    method : {"auto", "dense", "fft", "kpec", "analyn"}
        "auto" takes the dense active-set method for up to 300 cells, otherwise convolutions; up to 4000
        cells the dense method solves what these do not, as strips of long cells under an eccentric load.
        "kpec" and "analyn" are quick approximations for one contact of smooth bodies that are round along x,
        as a wheel on a rail: semi-elliptic pressure along x, over the extent at which the undeformed bodies,
        pushed into each other, meet. KPEC cuts them at half the approach and takes one steepness, such that
        the displacement at the point of first contact is the approach [KikPiotrowski1996;
        PiotrowskiKik2008]. ANALYN takes Hertz' contact with the curvatures of each row [Sichani2014]. Both
        are Hertz' where the gap is, and do not take moments, `tolerance`, `periodic`, layers or a hardness.
        ``report.residual`` tells by how much the deformed gap is off.
    moments : (float or None, float or None) [N m]
        Old spelling: first moments of the pressure along x and along y, which are (my, -mx).
    normal_layer : float, ThinLayer or RoughLayer [m/Pa]
        A layer between the bodies in which each cell gives way by this flexibility times its pressure, or by
        the law of a :class:`mtb_rs.RoughLayer`, whose first touch the gap counts from. The approach contains
        its compression, of a periodic contact the mean too.
    hardness : float or None [Pa]
        Pressure at which the softer body flows, some three times its yield stress: the pressure stays below
        it, and the contact grows instead. What the flow piles up around the contact, and its
        hardening, are left out.
    rolling : Rolling or None
        How the contact rolls over bodies that creep (:class:`mtb_rs.Viscoelastic`): steadily, at its velocity
        and in its direction. Its creepages and forces are of no account here. Other bodies need none.
    inclination : (ny,) float or None [rad]
        Of a surface that is curved across the rows of cells, as in the corner of a rail: the angle of the
        lower body's surface at each row, positive where it rises along +y; None for a plane one. y and
        `spacing` go along the surface, the gap and the approach along its normals, and the pressure of a row
        moves another one turned by the difference of their angles [BlancoLorenzo2016, as the first variant
        of CONTACT]. The bodies are half-spaces of the same material. The force is the sum of pressure times
        area; ``result.resultant`` is that of the vectors.

    Returns
    -------
    NormalResult

    Raises
    ------
    ValueError
        For bad input, and for a contact that reaches the side of a grid where the bodies go on.
    ConvergenceError
        If no solution exists, or if none was found.

    Warns
    -----
    UserWarning
        For a result that linear elasticity does not carry, which may be a slip of the unit: deformations that
        are not small against the contact, a pressure beyond the strength of steel. A scene asks the same.
    ToleranceWarning
        For a contact of fewer than three cells across, and for a layer that hardly changes its volume and is
        thinner than a cell.
    DeprecationWarning
        If `moments` is given; the warning names the new spelling.

    Notes
    -----
    The solver is a conjugate gradient with bounds [PolonskyKeer1999; Vollebregt2014], preconditioned by the
    Fourier transform, from coarse grids to fine ones, with the influence of rectangles in closed form
    [Love1929].

    Besides the gap the solve takes some 100 to 160 bytes per cell if the contact is a small part of the grid,
    and up to 216 if it is all of it, with the result included. Each cell of a row takes 550 more and each row
    1800, which counts on grids of few rows or columns. This is at most 0.9 GB for 2048 x 2048 cells and 3.6
    GB for 4096 x 4096. A solve that may take more than half of the free memory gives a warning. A solve that
    may take more than the free memory, or more than 21.6 GB, is refused. All numbers are doubles, because the
    products of a single-precision transform have errors of 1e-7 and more of the largest displacement, and the
    residual could not fall below that.

    Examples
    --------
    >>> import numpy as np
    >>> import mtb_rs as mtb
    >>> x = (np.arange(64) - 31.5) * 0.05e-3
    >>> gap = (x[None, :] ** 2 + x[:, None] ** 2) / (2 * 0.5)
    >>> result = mtb.solve_normal(gap, 0.05e-3, lower=mtb.steel, upper=mtb.steel, force=1e3)
    >>> round(result.pressure.max() / 1e6)
    216
    """
    started = time.perf_counter()
    heights = _gap(gap)
    sides = spacing_pair(spacing)
    bodies = field_body("lower", lower), field_body("upper", upper)
    for side, body in zip(("lower", "upper"), bodies, strict=True):
        ask([] if body.material is None else of_material(side, body.material))
    if are_prisms(*bodies):
        _check_prisms(
            bodies,
            {
                "inclination": inclination is not None,
                "periodic": periodic,
                'edge="grow"': edge == "grow",
                f'method="{method}"': method in ("kpec", "analyn"),
                "moments_about_axes": tuple(moments_about_axes) != (None, None) or moments is not None,
            },
        )
    velocity = _rolling_over(bodies, rolling, periodic, hardness, method)
    if all(body.elastic is None for body in bodies):
        raise ValueError("both bodies are rigid: one of them must be elastic")
    if (force is None) == (approach is None):
        given = (
            "both are None"
            if force is None
            else f"force is {shortened(force)} [N], and approach is {shortened(approach)} [m]"
        )
        raise ValueError(f"{given}: either force or approach is needed, as one follows from the other")
    force = None if force is None else positive("force", force, "N")
    approach = None if approach is None else number("approach", approach, "m")
    if tolerance is not None and not 1e-14 <= positive("tolerance", tolerance) < 1.0:
        raise ValueError(f"tolerance is {tolerance:g}: a number from 1e-14 to below 1 is needed")
    periodic = flag("periodic", periodic)
    given = normal_flexibility(normal_layer)
    rough = given if isinstance(given, RoughLaw) else None
    layer = 0.0 if rough is not None else number("normal_layer", given, "m/Pa")
    if layer < 0.0:
        raise ValueError(f"normal_layer is {layer:g} m/Pa: a flexibility of at least 0 is needed")
    hardness = None if hardness is None else positive("hardness", hardness, "Pa")
    largest = None if hardness is None else hardness * heights.size * sides[0] * sides[1]
    if largest is not None and force is not None and force >= largest * (1.0 - 1e-9):
        raise ValueError(
            f"force is {force:.10g} N: at a hardness of {hardness:g} Pa the whole grid carries "
            f"{largest:.10g} N, and less while a point is open: a larger grid, or a smaller force, is needed"
        )
    if hardness is not None and method == "dense":
        raise ValueError('method is "dense", which does not take a hardness: "auto" or "fft" is needed')
    if rough is not None and method == "dense":
        raise ValueError('method is "dense", which does not take a RoughLayer: "auto" or "fft" is needed')
    has_mean = layer > 0.0 or rough is not None or any(body.mean_compliance > 0.0 for body in bodies)
    if periodic and approach is not None and approach >= heights.mean() and not has_mean:
        raise ValueError(
            f"approach is {approach:g} m: a periodic contact closes at its mean gap, {heights.mean():g} m, "
            "where all points touch; a smaller one, or a force, is needed"
        )
    choice("edge", edge, Edge)
    choice("method", method, Convolution)
    angles = None
    if inclination is not None:
        alike = bodies[0] == bodies[1] and bodies[0].is_half_space
        angles = inclination_of(inclination, heights.shape[0], bodies[0].material if alike else None)
        _check_inclined(periodic, edge, method, (moments_about_axes, moments))
    if method in ("kpec", "analyn"):
        given_in_vain = {
            "moments_about_axes": moments_about_axes if tuple(moments_about_axes) != (None, None) else None,
            "moments": moments,
            "tolerance": tolerance,
            "periodic": periodic or None,
            "edge": edge if edge in ("sharp", "grow") else None,
            "normal_layer": rough if rough is not None else (layer or None),
            "hardness": hardness,
        }
        refused = {name: value for name, value in given_in_vain.items() if value is not None}
        quick = _quick_result(heights, sides, bodies, (force, approach), method, refused)
        ask(of_result(quick, _deformation(quick)))
        ask(of_width(quick.status > 0), kind=ToleranceWarning)
        return quick
    if moments is None:
        first = _first_moments("moments_about_axes", moments_about_axes, heights, sides, force, periodic)
    else:
        first = _old_moments(moments, moments_about_axes, heights, sides, force, periodic)
    problem = _Problem(
        sides, bodies, force, approach, first, periodic, method, layer, hardness, rough, velocity, angles
    )
    solution = problem.solve(heights, tolerance)
    ends_inside = periodic or not reaches_edge(solution.pressure)
    if edge == "auto":
        edge = "sharp" if ends_inside or _is_plane(heights) else "error"
    if not ends_inside and edge in ("error", "grow"):
        shape = _shape_that_would_do(problem, heights)
        if edge == "error" or shape is None:
            raise ValueError(_edge_message(heights, sides, shape))
        heights = _continued(heights, shape)
        solution = problem.solve(heights, tolerance)
        if reaches_edge(solution.pressure):
            raise ValueError(_edge_message(heights, sides, _shape_that_would_do(problem, heights)))
    result = _result(solution, heights, problem, bodies, time.perf_counter() - started)
    if not result.report.converged:
        raise ConvergenceError(result.report.status, result)
    ask(of_layers(bodies, sides), kind=ToleranceWarning)
    if (prisms := result._prisms()) is not None:
        ask(prisms.questions, kind=ToleranceWarning)
    # rough surfaces are for contacts of single points, at pressures that only an elastic idealisation bears
    if not periodic:
        ask(of_result(result, _deformation(result)))
        ask(of_width(result.status > 0), kind=ToleranceWarning)
    return result


def _check_prisms(bodies: tuple[FieldBody, FieldBody], in_vain: dict[str, bool]) -> None:
    """Whether prisms are known beside the other body and what else is asked for."""
    if are_layered(*bodies) or do_creep(*bodies):
        raise ValueError(
            "a body is a Prism, and the other one is Layered or Viscoelastic: a Prism, a half-space or Rigid "
            "is needed"
        )
    for name, is_asked in in_vain.items():
        if is_asked:
            raise ValueError(f"a body is a Prism, and {name} is given: {name} is for half-spaces")


def _check_inclined(periodic: bool, edge: Edge, method: Convolution, moments: tuple[Any, Any]) -> None:
    """Whether a surface that is inclined is known beside what else is asked for."""
    is_tilting = tuple(moments[0]) != (None, None) or moments[1] is not None
    in_vain = {
        "periodic": periodic,
        'edge="grow"': edge == "grow",
        f'method="{method}"': method in ("kpec", "analyn"),
        "moments_about_axes": is_tilting,
    }
    for name, is_asked in in_vain.items():
        if is_asked:
            raise ValueError(f"inclination is given, and {name} as well: {name} is for plane surfaces")


def _rolling_over(
    bodies: tuple[Simple | Prism, Simple | Prism],
    rolling: Any,
    periodic: bool,
    hardness: float | None,
    method: str,
) -> tuple[float, float] | None:
    """Velocity of the contact over bodies that creep; None of other bodies."""
    if not do_creep(*bodies):
        if rolling is not None:
            raise ValueError(
                f"rolling is {rolling!r}, and no body is Viscoelastic: the pressure on elastic bodies does "
                "not depend on the motion, and None is needed"
            )
        return None
    body = next(body for body in bodies if do_creep(body))
    if rolling is None:
        raise ValueError(f"a body is {body!r}, and rolling is None: {BESIDE_ROLLING}")
    if not isinstance(rolling, Motion):
        raise ValueError(f"rolling is {shortened(rolling)}: a Rolling is needed")
    velocity = rolling.steady_velocity
    if periodic or hardness is not None or method in ("kpec", "analyn"):
        what = "periodic" if periodic else "hardness" if hardness is not None else f'method="{method}"'
        raise ValueError(f"a body is {body!r}: {what} is for elastic bodies")
    return velocity


def _given_way(gap: Array, initial_gap: Array, points: Array, tilts: tuple[float, float]) -> Array:
    """By how much the surfaces give way (ny, nx) [m], but for a constant, from the deformed gap, the
    undeformed one, and the tilts that close it."""
    return np.asarray(gap - initial_gap + tilts[0] * points[0] + tilts[1] * points[1])


def _resistance(
    velocity: tuple[float, float], given_way: Array, forces: Array, spacing: tuple[float, float]
) -> float | None:
    """Force [N] against rolling at a velocity (x, y) [m/s]: what the `forces` (ny, nx) [N] on the cells work
    for each metre on surfaces that have given way (ny, nx) [m].

    None where there are forces on the outermost cells along the way. The differences are antisymmetric, so
    that what the bodies do elastically cancels, at sharp edges as well.
    """
    found = 0.0
    for axis, part in _ways(velocity):
        u, f = np.moveaxis(given_way, axis, 0), np.moveaxis(forces, axis, 0)
        if len(u) < 3 or f[0].any() or f[-1].any():
            return None
        found -= part * float((_slopes(u, spacing[1 - axis]) * f[1:-1]).sum())
    return found


def _ways(velocity: tuple[float, float]) -> Iterator[tuple[int, float]]:
    """Axes of a field (ny, nx) along which a velocity (x, y) goes, and its direction cosines."""
    size = float(np.hypot(*velocity))
    for axis, part in zip((1, 0), velocity, strict=True):
        # directions come from sines and cosines: what is left of a zero there is no motion
        if abs(part) > 1e-12 * size:
            yield axis, part / size


def _slopes(u: Array, cell: float) -> Array:
    """Slopes (n - 2, ...) of a field (n, ...) along its first axis, in all but its outermost cells."""
    # these are open, and the surfaces smooth there
    before, after = (3.0 * (v[0] - v[1]) + v[2] for v in (u, u[::-1]))
    u = np.concatenate([before[None], u, after[None]])
    return np.asarray((8.0 * (u[3:-1] - u[1:-3]) - (u[4:] - u[:-4])) / (12.0 * cell))


def resistance_of(
    normal: Any, field: PressureField, rolling: tuple[float, float] | None = None
) -> float | None:
    """Force [N] against rolling on bodies that creep, from what pressed and its pressure; None without such
    bodies, without a gap, or where the pressure reaches the edge of the grid.

    With `rolling`, the way (x, y) of a contact whose tractions open its gap, on any bodies.
    """
    gap = getattr(normal, "initial_gap", None)
    # bodies of a scene know over what they roll
    of_bodies = velocity_over(getattr(normal, "lower", None), getattr(normal, "upper", None))
    velocity = getattr(normal, "rolling_velocity", of_bodies) or rolling
    if gap is None or velocity is None:
        return None
    tilts = getattr(normal, "tilts", None)
    if tilts is None:
        # a scene moves up and, where moments are given, turns about x and y
        turned = normal.motion[1:]
        tilts = (float(turned[1]), -float(turned[0])) if turned.size else (0.0, 0.0)
    given_way = _given_way(normal.gap, gap, normal.points, tilts)
    return _resistance(
        velocity, given_way, field.pressure * (field.spacing[0] * field.spacing[1]), field.spacing
    )


#: What makes a pressure by interpenetration.
_QUICK = {"kpec": "KPEC: interpenetration", "analyn": "ANALYN: interpenetration, Hertz row by row"}


def _quick_result(
    heights: Array,
    sides: tuple[float, float],
    bodies: tuple[Simple | Prism, Simple | Prism],
    load: tuple[float | None, float | None],
    method: Quick,
    refused: dict[str, Any],
) -> NormalResult:
    """The result at a load, a force [N] or an approach [m]; `refused`: arguments given in vain."""
    started = time.perf_counter()
    for name, value in refused.items():
        raise ValueError(
            f'{name} is {value!r}: method="{method}" does not take it; method="auto", "dense" or "fft" does'
        )
    lower, upper = bodies
    for side, body in (("lower", lower), ("upper", upper)):
        if body.plane_strain_compliance > 0.0 and not body.is_half_space:
            name = type(body).__name__
            raise ValueError(f'{side} is a {name}: method="{method}" is for half-spaces; "auto" takes layers')
    found = press(
        heights, sides, 1.0 / (lower.plane_strain_compliance + upper.plane_strain_compliance), *load, method
    )
    touches = found.pressure > 0.0
    gap = heights + found.displacement - found.approach
    area = sides[0] * sides[1]
    wrong = max(
        float(np.abs(gap[touches]).max(initial=0.0)), float(np.maximum(-gap[~touches], 0.0).max(initial=0.0))
    )
    moved = float(np.sqrt(np.mean(found.displacement[touches] ** 2))) if touches.any() else 1.0
    report = Report(
        converged=True,
        status="approximate",
        model="half-space",
        method=method,
        solver=_QUICK[method],
        iterations=0,
        residual=wrong / moved,
        contact_area=float(np.count_nonzero(touches) * area),
        peak_pressure=float(found.pressure.max()),
        time_s={"solve": time.perf_counter() - started},
    )
    return NormalResult(
        points=centres((heights.shape[0], heights.shape[1]), sides),
        area=np.full(heights.shape, area),
        spacing=sides,
        pressure=found.pressure,
        gap=gap,
        initial_gap=heights,
        status=touches.astype(np.int8),
        approach=found.approach,
        tilts=(0.0, 0.0),
        normal_force=float(found.pressure.sum() * area),
        contact_area=report.contact_area,
        lower=lower,
        upper=upper,
        periodic=False,
        error_estimate=None,
        report=report,
    )


def _deformation(result: NormalResult) -> dict[str, Array]:
    """Displacement (1, n) [m] of each body at the points, normal to them."""
    compliance = {side: getattr(result, side).normal_compliance for side in ("upper", "lower")}
    apart = _opened(result).reshape(1, -1)
    return {
        side: apart if own == sum(compliance.values()) else apart * (own / sum(compliance.values()))
        for side, own in compliance.items()
    }


def _opened(result: NormalResult) -> Array:
    """Displacement (ny, nx) [m] by which the bodies give way together, elastically."""
    along, across = result.tilts
    opened: Array = result.gap - result.initial_gap + result.approach
    if (along, across) != (0.0, 0.0):
        x, y, _ = result.points
        opened = opened + (along * x + across * y)
    layer = result.normal_layer
    if isinstance(layer, RoughLaw):
        opened = opened - layer.opening(result.pressure)
    elif layer:
        opened = opened - layer * result.pressure
    return opened if result.plastic_indentation is None else opened - result.plastic_indentation


@dataclass(frozen=True)
class _Problem:
    """Everything but the gap and the tolerance."""

    spacing: tuple[float, float]
    bodies: tuple[Simple | Prism, Simple | Prism]
    force: float | None
    approach: float | None
    moments: tuple[float | None, float | None]
    periodic: bool
    method: str
    layer: float
    hardness: float | None
    rough: RoughLaw | None
    velocity: tuple[float, float] | None = None
    inclination: Array | None = None

    @property
    def elastic(self) -> list[Core]:
        """The bodies that give way, as the core has them."""
        media = [medium_of(body, self.velocity) for body in self.bodies]
        return [medium for medium in media if medium is not None]

    def prisms(self, shape: tuple[int, int]) -> Prisms | None:
        """The prisms under cells (ny, nx) about the middle of the grid; None without one."""
        return prisms_under(*self.bodies, -0.5 * (shape[0] - 1) * self.spacing[1], shape, self.spacing)

    def of_curvature(self) -> dict[str, str]:
        """What is left out of the shape of the bodies."""
        if are_prisms(*self.bodies):
            return {}
        if self.inclination is not None:
            return {"curvature": "bodies below a curved surface are half-spaces, turned from row to row"}
        return {"curvature": "both bodies are half-spaces: the contact must be small against their radii"}

    def solve(
        self, gap: Array, tolerance: float | None, spacing: tuple[float, float] | None = None
    ) -> _mtb_rs.NormalOutcome:
        """What the core finds; its approach is that of the gap above its least value."""
        # a common distance says nothing about the contact, but costs digits
        base = float(gap.min())
        ny, nx = gap.shape
        prisms = self.prisms((ny, nx))
        needed = memory.of_normal_contact((nx, ny), self.method)
        memory.say(needed, f"the contact of {nx} x {ny} cells")
        return _mtb_rs.solve_normal(
            np.ascontiguousarray(gap - base),
            spacing or self.spacing,
            self.elastic,
            self.force,
            None if self.approach is None else self.approach - base,
            self.moments,
            tolerance,
            self.periodic,
            self.method,
            self.layer,
            self.hardness,
            None if self.rough is None else self.rough.core,
            None if self.inclination is None else self.inclination.tolist(),
            None if prisms is None else prisms.normal,
        )

    def linearised(self, result: NormalResult) -> _mtb_rs.NormalTangent:
        """The contact at its solution."""
        base = float(result.initial_gap.min())
        prisms = result._prisms()
        gap = result.gap
        if result.plastic_indentation is not None:
            # what flows is behind the gap
            gap = gap - result.plastic_indentation
        return _mtb_rs.NormalTangent(
            np.ascontiguousarray(result.initial_gap - base),
            self.spacing,
            self.elastic,
            self.force,
            None if self.approach is None else self.approach - base,
            self.moments,
            self.periodic,
            self.layer,
            self.hardness,
            None if self.rough is None else self.rough.core,
            None if self.inclination is None else self.inclination.tolist(),
            None if prisms is None else prisms.normal,
            (result.pressure, gap, result.approach - base, result.tilts),
        )


def _opened_at(compliance: float, load: Array, spacing: tuple[float, float]) -> Array:
    """Gap (ny, nx) [m] that a load (3, ny, nx) [Pa] opens on a half-space of (1 - nu) / G [1/Pa]."""
    ny, nx = load.shape[1:]
    unit = _mtb_rs.half_space((1.0, 0.0), [(0.0, 0.0, nx, ny)], spacing, True)
    return np.asarray(compliance * unit.displacement(load.reshape(3, -1))[2].reshape(ny, nx))


#: What a hardness leaves out.
FLOW = "the bodies harden, and pile up around the contact, not at all"


def centres(shape: tuple[int, int], spacing: tuple[float, float]) -> Array:
    """Cell centres (3, ny, nx) [m] of a grid of `shape` (ny, nx) about (0, 0, 0)."""
    ny, nx = shape
    points = np.zeros((3, ny, nx))
    points[0] = (np.arange(nx) - 0.5 * (nx - 1)) * spacing[0]
    points[1] = ((np.arange(ny) - 0.5 * (ny - 1)) * spacing[1])[:, None]
    return points


def _gap(gap: ArrayLike) -> Array:
    if isinstance(gap, np.ndarray) and gap.ndim == 2:  # before the first copy of it
        memory.refuse(
            memory.of_normal_contact((gap.shape[1], gap.shape[0]), "fft"),
            f"gap has shape {gap.shape}: its contact",
            "take fewer, larger cells",
        )
    heights = reals("gap", gap, "m")
    if heights.ndim != 2 or heights.size == 0:
        raise ValueError(f"gap has shape {heights.shape}: (ny, nx) is needed")
    return heights


def _old_moments(
    moments: Sequence[float | None],
    new: Sequence[float | None],
    gap: Array,
    spacing: tuple[float, float],
    force: float | None,
    periodic: bool,
) -> tuple[float | None, float | None]:
    """First moments from the old spelling, which gave them along x and along y."""
    if tuple(new) != (None, None):
        raise TypeError("solve_normal() got both moments_about_axes and moments, its old spelling")
    warn(
        "The argument moments of solve_normal, first moments along x and y, gives way to "
        "moments_about_axes=(mx, my), moments about the axes as in Scene: moments=(a, b) is "
        "moments_about_axes=(-b, a).",
        DeprecationWarning,
    )
    try:
        along_x, along_y = moments
    except (TypeError, ValueError):
        raise ValueError(f"moments is {moments!r}: two numbers [N m] or None are needed") from None
    about_x = None if along_y is None else -number("moments[1]", along_y, "N m")
    return _first_moments("moments", (about_x, along_x), gap, spacing, force, periodic, (1, 0))


def _first_moments(
    name: str,
    moments: Sequence[float | None],
    gap: Array,
    spacing: tuple[float, float],
    force: float | None,
    periodic: bool,
    numbers: tuple[int, int] = (0, 1),
) -> tuple[float | None, float | None]:
    """First moments [N m] of the pressure along x and along y, from the `moments` about the axes.

    `name` and the `numbers` of its entries are those that messages speak of.
    """
    try:
        about_x, about_y = moments
    except (TypeError, ValueError):
        raise ValueError(f"{name} is {moments!r}: two numbers [N m] or None are needed") from None
    given = [
        None if m is None else number(f"{name}[{k}]", m, "N m")
        for k, m in zip(numbers, (about_x, about_y), strict=True)
    ]
    if periodic and given != [None, None]:
        raise ValueError(f"a periodic contact has no tilt: {name} must be (None, None)")
    # about x it is the place along y that counts, and the other way round
    for k, moment, axis in zip(numbers, given, (0, 1), strict=True):
        if moment is None or force is None:
            continue
        reach = 0.5 * (gap.shape[axis] - 1) * spacing[1 - axis]
        if not abs(moment) < force * reach:
            raise ValueError(
                f"{name}[{k}] is {moment:g} N m: the force of {force:g} N then acts at a distance of "
                f"{abs(moment) / force:g} m from the middle of the grid; it must act less than {reach:g} m "
                "from there, between the outermost cell centres"
            )
    return given[1], None if given[0] is None else -given[0]


def reaches_edge(pressure: Array) -> bool:
    """Whether there is pressure (ny, nx) in the outermost cells."""
    sides = (pressure[0], pressure[-1], pressure[:, 0], pressure[:, -1])
    return any(bool(np.any(side > 0.0)) for side in sides)


def _is_plane(gap: Array) -> bool:
    ny, nx = gap.shape
    rest = gap - gap.mean()
    for axis, n in ((0, ny), (1, nx)):
        along = np.expand_dims(np.arange(n) - 0.5 * (n - 1), 1 - axis)
        square = float((along * along).sum()) * (gap.size // n)
        if square > 0.0:
            rest = rest - float((gap * along).sum()) / square * along
    return bool(np.abs(rest).max() <= 1e-9 * np.abs(gap).max())


def _shape_that_would_do(problem: _Problem, gap: Array) -> tuple[int, int] | None:
    """Shape (ny, nx) of a grid inside which the contact ends, from a coarse copy; None if not found."""
    # how the surface goes on beyond the rows is not known
    if min(gap.shape) < _CONTINUABLE or problem.inclination is not None or are_prisms(*problem.bodies):
        return None
    # a search: the dense method would cost minutes on the larger grids
    problem = replace(problem, method="auto")
    # by sampling, not by averaging: the sides of the grid stay where they are
    steps = [max(1, n // 48) for n in gap.shape]
    coarse = gap[steps[0] // 2 :: steps[0], steps[1] // 2 :: steps[1]]
    spacing = (problem.spacing[0] * steps[1], problem.spacing[1] * steps[0])
    factor = 1.0
    for _ in range(_ENLARGEMENTS):
        factor *= 1.25
        shape = tuple(int(np.ceil(factor * n)) + 2 for n in coarse.shape)
        trial = np.ascontiguousarray(_continued(coarse, (shape[0], shape[1])))
        solution = problem.solve(trial, 1e-4, spacing)
        if solution.status == "solved" and not reaches_edge(solution.pressure):
            return shape[0] * steps[0], shape[1] * steps[1]
    return None


def _continued(gap: Array, shape: tuple[int, int]) -> Array:
    """`gap` on a larger grid around it, continued by the parabola that fits its outer quarter."""
    for axis in (1, 0):
        gap = np.moveaxis(gap, axis, -1)
        n, wanted = gap.shape[-1], shape[axis]
        before = (wanted - n) // 2
        fitted = max(_CONTINUABLE, n // 4)
        parts = [gap]
        for count, inner in (
            (before, gap[..., :fitted][..., ::-1]),
            (wanted - n - before, gap[..., -fitted:]),
        ):
            # counted outwards from the last cell, through which the parabola goes
            k = np.arange(1.0 - fitted, 1.0)
            design = np.stack([k, k * k], axis=-1)[:-1]
            rise = (inner - inner[..., -1:])[..., :-1]
            slope, bend = np.moveaxis(rise @ np.linalg.pinv(design).T, -1, 0)
            out = np.arange(1.0, count + 1.0)
            piece = inner[..., -1:] + slope[..., None] * out + bend[..., None] * out * out
            parts = [piece[..., ::-1], *parts] if len(parts) == 1 else [*parts, piece]
        gap = np.moveaxis(np.concatenate(parts, axis=-1), -1, axis)
    return np.ascontiguousarray(gap)


def _edge_message(gap: Array, spacing: tuple[float, float], shape: tuple[int, int] | None) -> str:
    ny, nx = gap.shape
    size = f"{nx * spacing[0]:.4g} x {ny * spacing[1]:.4g} m"
    if min(ny, nx) < _CONTINUABLE:
        advice = (
            f"{nx} x {ny} cells are too few to continue the gap, which takes {_CONTINUABLE} along each side: "
            "give the gap on a larger grid"
        )
    elif shape is None:
        advice = (
            "even a grid four times as large would not do if the gap is continued by parabolas: give the "
            "gap on a larger grid, or press less"
        )
    else:
        advice = (
            f"about {shape[1] * spacing[0]:.4g} x {shape[0] * spacing[1]:.4g} m "
            f'({shape[1]} x {shape[0]} cells) would do: give the gap on such a grid, or edge="grow", which '
            "continues it by parabolas"
        )
    return (
        f"the contact reaches the edge of the grid of {size}, but the bodies go on beyond it: "
        f"""{slip_of_gap(gap) or advice}; edge="sharp" states that a body ends there"""
    )


def _is_met(solution: _mtb_rs.NormalOutcome, force: float | None, normal_force: float) -> bool:
    """Whether the solution holds to the tolerance asked for, after all rounding."""
    if force is not None and not abs(normal_force - force) <= FORCE_TOLERANCE * force:
        return False
    return bool(solution.residual <= solution.tolerance)


def _solver(is_dense: bool, *, creeps: bool, in_rows: bool) -> str:
    if is_dense:
        return "active set, dense LU"
    if in_rows:
        return "conjugate gradients, FFT along the rows"
    return "active sets, GMRES, FFT" if creeps else "conjugate gradients, FFT"


def _outcome(loaded: NDArray[np.bool_], gap: Array, approach: float) -> str:
    if loaded.any():
        return "converged"
    return f"converged: the bodies do not touch, approach is {approach:g} m, the smallest gap {gap.min():g} m"


def _result(
    solution: _mtb_rs.NormalOutcome,
    gap: Array,
    problem: _Problem,
    bodies: tuple[Simple | Prism, Simple | Prism],
    seconds: float,
) -> NormalResult:
    pressure: Array = solution.pressure
    cell = problem.spacing[0] * problem.spacing[1]
    loaded = pressure > 0.0
    prisms = problem.prisms((gap.shape[0], gap.shape[1]))
    normal_force = float(pressure.sum()) * cell
    approach = solution.approach + float(gap.min())
    outcome = solution.status
    if outcome == "solved" and not _is_met(solution, problem.force, normal_force):
        outcome = "stagnated"
    converged = outcome == "solved"
    balance: dict[str, float] = {"contact": normal_force}
    if problem.force is not None:
        balance |= {
            "prescribed": problem.force,
            "relative_sum": abs(normal_force - problem.force) / problem.force,
            "relative_error": abs(normal_force - problem.force) / problem.force,
        }
    error = solution.discretisation_error
    report = Report(
        converged=converged,
        status=_outcome(loaded, gap, approach) if converged else _FAILURES[outcome].format(solution),
        model="half-space",
        method="direct",
        solver=_solver(solution.is_dense, creeps=problem.velocity is not None, in_rows=prisms is not None),
        iterations=solution.iterations,
        residual=solution.residual,
        contact_area=float(loaded.sum()) * cell,
        peak_pressure=float(pressure.max()),
        convolutions=solution.products,
        preconditionings=solution.preconditionings,
        force_balance=balance,
        error_estimates={} if error is None else {"pressure": error},
        omitted=({} if problem.hardness is None else {"plastic flow": FLOW})
        | {
            "friction": "the pressure does not depend on it where the bodies are of like materials"
            if problem.inclination is None and prisms is None
            else 'traction changes the gap of a curved surface: solve_tangential with coupling="full" has it',
        }
        | problem.of_curvature(),
        notes=() if prisms is None else prisms.notes,
        time_s={"solve": seconds},
        history=tuple(solution.history),
    )
    gap_now: Array = solution.gap
    indentation = None
    if problem.hardness is not None:
        # what flows is behind the gap
        indentation = np.where(pressure >= problem.hardness, np.maximum(-gap_now, 0.0), 0.0)
        gap_now = gap_now + indentation
    result = NormalResult(
        points=centres((gap.shape[0], gap.shape[1]), problem.spacing),
        area=np.full(gap.shape, cell),
        spacing=problem.spacing,
        pressure=pressure,
        gap=gap_now,
        initial_gap=gap,
        status=loaded.astype(np.int8),
        approach=approach,
        tilts=solution.tilts,
        normal_force=normal_force,
        contact_area=report.contact_area,
        lower=bodies[0],
        upper=bodies[1],
        periodic=problem.periodic,
        error_estimate=error,
        report=report,
        normal_layer=problem.layer if problem.rough is None else problem.rough,
        hardness=problem.hardness,
        plastic_indentation=indentation,
        rolling_velocity=problem.velocity,
        inclination=problem.inclination if prisms is None else prisms.angles,
    )
    # what was given is no field of a result, but its derivatives need it
    object.__setattr__(result, "_problem", problem)
    object.__setattr__(result, "_made", {})
    return result
