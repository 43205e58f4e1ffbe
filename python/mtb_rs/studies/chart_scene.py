# SPDX-License-Identifier: MIT OR Apache-2.0
"""The chart of a scene: which models and methods apply to it, and what they are judged by."""

from __future__ import annotations

import time
import warnings
from collections.abc import Callable
from dataclasses import dataclass, field
from itertools import islice
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray

from ..base import cache
from ..base.check import positive
from ..base.errors import ConvergenceError
from ..base.plain import plain
from ..base.questions import gathered
from ..base.words import Model, Quantity
from ..bodies.elastic_body import ElasticBody
from ..bodies.simple import HalfSpace, are_unlike, as_body
from ..contact.estimate import GridField, difference, extrapolated
from ..friction.fields import as_form
from ..geometry.contact_points import Patch, spacing_pair
from ..geometry.geometries import centred
from ..results.chart import Chart, ChartPoint
from ..results.report import Report
from ..results.result import Result
from ..scenes import direct, methods
from ..scenes.posed import PosedScene
from ..scenes.taken import beyond
from .measuring import Candidate, Run, halvings, measure, silent

Array = NDArray[np.float64]
Spacing = tuple[float, float]

#: Contact points above which a dense solve is not tried.
LARGEST = 7000
LARGEST_BY_CONVOLUTION = 300_000
#: Elements over the largest extent of a body of one's own, where cells are wide.
LEAST_ACROSS = 5.0
#: Least growth of the time expected from one spacing to the next, twice as many points [-].
GROWTH = 5.0
#: The series that chooses its cells, and what it is asked for [-].
AUTO = "auto, spacing free (tolerance)"
TOLERANCES = (0.3, 0.1, 0.05, 0.02, 0.01)
#: Cells along each side of the grid on which closed forms are averaged.
CLOSED_FORM_CELLS = 1024


Solve = Callable[[Spacing], tuple["Fields", Report]]


@dataclass(frozen=True)
@plain
class Fields:
    """A solution as a chart compares it: fields on grids, and the force.

    Attributes
    ----------
    axes : list of (patch, x, y)
    pressure, displacement : (n,) [Pa], [m]
        The latter of the lower body along z; empty if unknown.
    force : (3,) [N]
    spacing : (dx, dy) [m]
    hats : (n,) [Pa] or None
        Coefficients of the pressure, where it is made of hats.
    known : (n,) bool or None
        Points on the bodies, where not all are.
    """

    axes: list[tuple[Patch, Array, Array]]
    pressure: Array
    displacement: Array
    force: Array
    spacing: Spacing
    hats: Array | None = None
    known: NDArray[np.bool_] | None = None

    def _comparable(self, name: str) -> GridField:
        means = getattr(self, name)
        hats = None if self.hats is None else self.hats if name == "pressure" else means
        return GridField(self.axes, means, hats, self.known if name == "displacement" else None)

    def errors(self, reference: Fields, skip_border: bool) -> dict[str, float]:
        """Relative errors against a finer solution."""
        found: dict[str, float] = {}
        for name in ("pressure", "displacement"):
            fine, own = reference._comparable(name), self._comparable(name)
            if own.means.size and fine.means.size:
                apart = difference(fine, own, skip_border=skip_border)
                if apart is not None:
                    found[name] = apart
        size = float(np.linalg.norm(reference.force))
        found["force"] = float(np.linalg.norm(self.force - reference.force)) / size
        return found


def chart(
    scene: PosedScene,
    *,
    quantity: Quantity,
    budget: float,
    repeats: int,
    progress: Callable[[float, str], None] | None,
) -> Chart:
    """See :meth:`mtb_rs.Scene.chart`."""
    positive("budget", budget, "s")
    if isinstance(repeats, bool) or not isinstance(repeats, int) or repeats < 1:
        raise ValueError(f"repeats is {repeats!r}: a whole number from 1 on is needed")
    scene.check_rolling()
    told = progress or silent
    started = time.perf_counter()
    spacings = _spacings(scene)
    fullest = scene.models[-1]
    exact = closed_form(scene)
    convolved = None
    if _is_convolved(scene):
        convolved = _by_convolution(scene)
    points: list[ChartPoint] = []
    copies = _Copies(scene)
    if exact is None:
        solve, name, ladder = _by_model(scene, fullest, copies), f"{fullest}, direct", spacings
        if fullest == "half-space" and convolved is not None:
            solve, name, ladder = convolved, "half-space, FFT", _spacings(scene, LARGEST_BY_CONVOLUTION)
        reference, error, tried = _fine(scene, name, solve, copies, ladder, 0.4 * budget, told)
        words = f"{name}, {tried.unknowns} points{copies.words}"
        points.append(tried)
    else:
        reference, error, words = exact, 0.0, "closed form"
    skip = scene.geometry.is_body_edge
    finer = 1.001 * reference.spacing[0] * reference.spacing[1]
    allowed = [s for s in spacings if s[0] * s[1] > finer]

    def left() -> float:
        return budget - (time.perf_counter() - started)

    candidates = _candidates(scene, copies, convolved, finer, left)
    rest = max(left(), 1e-3 * budget)
    shift = 1.0 - rest / budget
    measured = measure(
        [_judged(c, reference, copies, skip) for c in candidates],
        allowed,
        budget=rest,
        repeats=repeats,
        progress=lambda share, doing: told(shift + (1.0 - shift) * min(share, 1.0), doing),
    )
    return Chart(
        title=scene.name.replace("_", " "),
        points=(*measured, *points),
        reference=words,
        reference_error=error,
        quantity=quantity,
        remark=copies.remark,
    )


@dataclass(frozen=True)
class _Copies:
    """The bodies of one's own of a scene, meshed again with its cells where they can be.

    Meshing takes no part in the times: a scene comes with its bodies made.
    """

    scene: PosedScene
    made: dict[Spacing, dict[str, ElasticBody]] = field(default_factory=dict)

    @property
    def own(self) -> dict[str, ElasticBody]:
        """Bodies of finite elements by side."""
        return {"upper" if upper else "lower": body for upper, body in self.scene.solids.items()}

    def at(self, spacing: Spacing) -> dict[str, ElasticBody]:
        """Those that can be meshed again, with elements wider or finer as cells of `spacing` are.

        Raises
        ------
        ValueError
            If one of them cannot be filled with such elements.
        """
        if spacing not in self.made:
            found = {}
            for side, body in self.own.items():
                if body.size is None:
                    continue
                assert self.scene.spacing is not None
                own = spacing_pair(self.scene.spacing)
                ratio = float(np.sqrt(spacing[0] * spacing[1] / (own[0] * own[1])))
                # a body is some elements wide, however wide the cells are
                widest = float(np.ptp(body.mesh.nodes, axis=0).max()) / LEAST_ACROSS
                size = min(ratio * body.size, max(widest, body.size))
                found[side] = body if abs(ratio - 1.0) < 1e-9 else body.resized(size)
            self.made[spacing] = found
        return self.made[spacing]

    @property
    def words(self) -> str:
        """What becomes of the meshes, behind the name of the reference."""
        sizes = [body.size for body in self.own.values()]
        if not sizes:
            return ""
        return ", on the meshes as they are" if None in sizes else ", meshed as finely"

    @property
    def remark(self) -> str:
        """What the errors do not hold, one sentence."""
        given = [body.name for body in self.own.values() if body.size is None]
        if not given:
            return ""
        return (
            f"The mesh of {' and that of '.join(given)} was given and stays as it is: its error is in all "
            "points and in the reference alike, and does not show."
        )


def _spacings(scene: PosedScene, largest: int = LARGEST) -> list[Spacing]:
    """Spacings from coarse to fine, each with a grid of its own of at least 4 points a side."""
    own = scene.geometry.start if scene.spacing is None else spacing_pair(scene.spacing)
    assert own is not None
    wanted: list[Spacing]
    if not scene.geometry.can_be_refined:
        wanted = [(own[0] * k, own[1] * k) for k in (16, 12, 8, 6, 4, 3, 2, 1)]
    else:
        wanted = list(islice(halvings(own), 17))
    kept: list[Spacing] = []
    refused: ValueError | None = None
    seen: set[tuple[int, ...]] = set()
    last = (0, 1.0)  # points, and the cell they were counted at
    for spacing in wanted:
        if last[0] * last[1] > 1.1 * largest * spacing[0] * spacing[1]:
            break
        try:
            grid = scene.geometry.grid(spacing)
        except ValueError as error:
            refused = error
            continue
        patches = grid.patches
        if scene.geometry.is_coarser_than(grid.spacing):
            break
        sizes = tuple(n for p in patches for n in (p.nx, p.ny))
        count = sum(p.nx * p.ny for p in patches)
        last = (count, spacing[0] * spacing[1])
        if min(sizes) >= 4 and sizes not in seen and count <= largest:
            seen.add(sizes)
            kept.append(spacing)
    if not kept:
        if refused is not None:
            raise refused
        raise ValueError(f"spacing is {own}: no grid of at least 4 points a side is left to chart")
    return kept


def fields_of(scene: PosedScene, result: Result, spacing: Spacing) -> Fields:
    """What a chart compares of a result of `scene` at a spacing."""
    grid = scene.geometry.grid(spacing)
    points = grid.nodes if result.patches == grid.node_patches else grid.cells
    axes = [(p, *p.axes()) for p in result.patches]
    hats = None
    if points is grid.nodes and result.coefficients is not None:
        hats = np.zeros(result.area.size)
        # beside a body there are no unknowns
        hats[result.area.ravel() > 0.0] = result.coefficients[2]
    return Fields(
        axes,
        result.pressure.ravel(),
        result.displacement.lower[2].ravel(),
        result.force,
        grid.spacing,
        hats,
        result.area.ravel() > 0.0,
    )


def closed_form(scene: PosedScene) -> Fields | None:
    """Hertz' pressure under the ready paraboloid, where friction does not change it."""
    from ..half_space.reference import SlidingParaboloid

    known = scene.geometry.paraboloid
    if known is None or not _uncoupled(scene):
        return None
    if scene.force is None or beyond(scene, "Hertz' closed form"):
        return None
    if not all(body.is_half_space for body in scene.simple):
        return None
    upper, lower = cast(tuple[HalfSpace, HalfSpace], scene.simple)
    mu = as_form(scene.friction).number
    if mu is None or scene.sliding_direction not in (None, (1.0, 0.0)):
        return None
    mu = 0.0 if scene.sliding_direction is None else mu
    radius, width = known
    exact = SlidingParaboloid(radius, scene.force, mu, lower.material, upper.material)
    n = CLOSED_FORM_CELLS
    step = 1.06 * width / n
    x = centred(n, step)
    axes = [(Patch("contact", 0, n, n, (step, step)), x, x)]
    grid_x, grid_y = np.meshgrid(x, x)
    return Fields(
        axes,
        exact.pressure(grid_x, grid_y).ravel(),
        exact.displacement(grid_x, grid_y)[2].ravel(),
        scene.force * np.array([mu, 0.0, -1.0]),
        (step, step),
    )


def _fine(
    scene: PosedScene,
    name: str,
    solve: Solve,
    copies: _Copies,
    spacings: list[Spacing],
    budget: float,
    progress: Callable[[float, str], None],
) -> tuple[Fields, float | None, ChartPoint]:
    """The finest solve that the budget affords, its error by one twice as wide, and its point."""
    started = time.perf_counter()
    solved: list[tuple[Fields, Report, float, float]] = []
    failure: Exception | None = None
    before = last = 0.0
    for spacing in spacings:
        spent = time.perf_counter() - started
        ratio = max(GROWTH, 1.5 * last / before) if before > 0.0 else GROWTH
        if last > 0.0 and spent + ratio * last > budget and (len(solved) > 1 or failure is not None):
            break
        progress(0.4 * min(spent / budget, 1.0), f"reference: {name}, {spacing[0]:.3g} m")
        clock = time.perf_counter()
        try:
            copies.at(spacing)
            begun, used = time.perf_counter(), time.process_time()
            fields, report = solve(spacing)
        except (ConvergenceError, ValueError) as raised:
            failure = raised
        else:
            used, elapsed = time.process_time() - used, time.perf_counter() - begun
            solved.append((fields, report, used, elapsed))
        before, last = last, time.perf_counter() - clock
    if not solved:
        assert failure is not None
        raise failure
    fields, report, used, elapsed = solved[-1]
    error: float | None = None
    if len(solved) > 1:
        # over about twice the spacing: differences between near spacings are mostly noise
        rough = solved[max(len(solved) - 3, 0)][0]
        apart = rough.errors(fields, scene.geometry.is_body_edge).get("pressure")
        error = None if apart is None else extrapolated(apart, fields.spacing, rough.spacing)
    point = ChartPoint(
        name,
        float(np.sqrt(fields.spacing[0] * fields.spacing[1])),
        fields.pressure.size,
        (max(used, 1e-6),),
        (elapsed,),
        {} if error is None else {"pressure": error},
        report.iterations,
        report.convolutions,
        report.solver,
        is_reference=True,
    )
    return fields, error, point


@dataclass(frozen=True)
class _Way:
    """One series before its errors are judged."""

    name: str
    solve: Solve
    fresh: bool = False
    warmed: bool = False
    spacings: list[Spacing] | None = None
    tolerances: tuple[float, ...] | None = None


def _candidates(
    scene: PosedScene,
    copies: _Copies,
    convolved: Solve | None,
    finer: float,
    left: Callable[[], float],
) -> list[_Way]:
    rubs = _rubs(scene)
    smooth = scene.with_(friction=0.0)
    found: list[_Way] = []
    if scene.own_model is None:
        found += _half_spaces(scene, smooth, convolved, finer)
    for model in scene.models:
        if model == "half-space":
            continue
        solve = _by_model(scene, model, copies)
        found.append(_Way(f"{model}, direct", solve, fresh=True))
        found.append(_Way(f"{model}, further loads", solve, warmed=True))
        if rubs and model != "elastic-both":
            found.append(_Way(f"{model}, frictionless", _by_model(smooth, model, copies), fresh=True))
        if model == "elastic-upper" and scene.own_model is None and not beyond(scene, "the staggered loop"):
            loop = _by_model(scene, model, method="staggered", max_iterations=200)
            found.append(_Way(f"{model}, staggered", loop, fresh=True))
    if scene.geometry.start is not None:
        found.append(_Way(AUTO, _by_tolerance(scene, left), fresh=True, tolerances=TOLERANCES))
    return found


def _half_spaces(scene: PosedScene, smooth: PosedScene, convolved: Solve | None, finer: float) -> list[_Way]:
    found = [_Way("half-space, direct", _by_model(scene, "half-space"))]
    if _rubs(scene) and not _uncoupled(scene):
        found.append(_Way("half-space, frictionless", _by_model(smooth, "half-space")))
    if convolved is not None:
        own = [s for s in _spacings(scene, LARGEST_BY_CONVOLUTION) if s[0] * s[1] > finer]
        found.append(_Way("half-space, FFT", convolved, spacings=own))
    if scene.approach is None and scene.moments is None and not beyond(scene, "load increments"):
        found.append(_Way("half-space, incremental", _by_model(scene, "half-space", method="incremental")))
    return found


def _by_tolerance(scene: PosedScene, left: Callable[[], float]) -> Solve:
    """What model="auto" makes of a tolerance in the seconds `left` when it may choose the spacing as well."""

    def solve(asked: Spacing) -> tuple[Fields, Report]:
        # nobody knows beforehand how fine the cells must be
        result = direct.solve(scene.with_(spacing=None), "auto", asked[0], "pressure", seconds=left())
        assert result.report.spacing is not None
        return fields_of(scene, result, result.report.spacing), result.report

    return solve


def _judged(way: _Way, reference: Fields, copies: _Copies, skip_border: bool) -> Candidate:
    def solve(asked: Spacing) -> Callable[[], Run]:
        with cache.memory_only():
            fields, report = way.solve(asked)

        def judge() -> Run:
            # what is finer than the reference cannot be judged by it
            is_finer = fields.spacing[0] * fields.spacing[1] < reference.spacing[0] * reference.spacing[1]
            errors = {} if is_finer else fields.errors(reference, skip_border)
            counts = report.iterations, report.convolutions, report.solver
            if way.tolerances is None:
                return Run(fields.pressure.size, errors, *counts)
            spacing = float(np.sqrt(fields.spacing[0] * fields.spacing[1]))
            note = f"tolerance {100.0 * asked[0]:g} %, {report.model}"
            return Run(fields.pressure.size, errors, *counts, spacing, note)

        return judge

    def prepare(spacing: Spacing) -> None:
        if way.tolerances is None:
            copies.at(spacing)
        if way.fresh:
            cache.forget()
        else:
            solve(spacing)

    prepared = prepare if way.fresh or way.warmed else None
    return Candidate(way.name, solve, prepared, way.spacings, way.tolerances)


def _by_model(scene: PosedScene, model: Model, copies: _Copies | None = None, **options: Any) -> Solve:
    def solve(spacing: Spacing) -> tuple[Fields, Report]:
        with warnings.catch_warnings():
            # cells are too wide on purpose here, and what that makes of the result is what the chart shows
            warnings.simplefilter("ignore", UserWarning)
            bodies = {} if copies is None else copies.at(spacing)
            other = scene.on_cells(spacing).with_(**bodies)
            result = methods.solve(other, model, **options)
        return fields_of(other, result, spacing), result.report

    return solve


def _rubs(scene: PosedScene) -> bool:
    """Whether friction acts at all."""
    return scene.sliding_direction is not None and as_form(scene.friction).number != 0.0


def _uncoupled(scene: PosedScene) -> bool:
    """Whether friction leaves the pressure of two half-spaces as it is: none, or like materials."""
    if not _rubs(scene):
        return True
    if scene.own_model is not None or not all(body.is_half_space for body in scene.simple):
        return False
    return not are_unlike(*scene.simple)


def _is_convolved(scene: PosedScene) -> bool:
    """Whether :func:`_by_convolution` solves the scene as its half-spaces are: one grid, numbers, no more."""
    given = [scene.magnetic_pressure, *([scene.friction] if _rubs(scene) else [])]
    return (
        scene.own_model is None
        and scene.geometry.is_grid
        and _uncoupled(scene)
        and all(value is None or as_form(value).number is not None for value in given)
        and not beyond(scene, "convolutions of a chart")
    )


def _by_convolution(scene: PosedScene) -> Solve:
    """The same half-spaces by :func:`mtb_rs.solve_normal`: friction follows from the pressure."""
    from ..half_space.normal import solve_normal

    geometry = scene.geometry
    mu = float(scene.friction) if _rubs(scene) else 0.0
    along = np.zeros(2) if scene.sliding_direction is None else np.array(scene.sliding_direction)
    along = along / max(float(np.linalg.norm(along)), 1e-300)

    def solve(spacing: Spacing) -> tuple[Fields, Report]:
        grid = geometry.grid(spacing)
        patch = grid.patches[0]
        force = scene.force
        if scene.magnetic_pressure is not None:
            force = float(scene.magnetic_pressure) * float(grid.area.sum())
        with gathered():
            result = solve_normal(
                np.ascontiguousarray(patch.view(grid.cells.gap)),
                grid.spacing,
                lower=as_body("lower", scene.lower),
                upper=as_body("upper", scene.upper),
                force=force,
                approach=scene.approach,
                edge="sharp",
                method="fft",
            )
        scene.check_edge(grid.patches, result.pressure.reshape(-1))
        scene.check_touching(result.normal_force > 0.0, grid.cells, {})
        fields = Fields(
            [(patch, *patch.axes())],
            result.pressure.ravel(),
            np.zeros(0),
            result.normal_force * np.array([mu * along[0], mu * along[1], -1.0]),
            grid.spacing,
        )
        return fields, result.report

    return solve
