# SPDX-License-Identifier: MIT OR Apache-2.0
"""``method="direct"``: which model, which spacing, the solution, and how good it is."""

from __future__ import annotations

import math
import time
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from ..base import memory
from ..base.questions import ask
from ..base.words import Model
from ..bodies.recovery import left_out
from ..bodies.simple import do_creep
from ..bodies.supports import are_at_points
from ..contact.estimate import coarsened
from ..contact.problem import ContactProblem
from ..contact.refined import carrier_spacing
from ..contact.solve import solve_direct
from ..geometry.geometries import Geometry
from ..results.plausible import NARROW, of_peak
from ..results.result import Result, percent
from .auto import (
    AIM,
    EFFECTS,
    FINEST_STEP,
    LEEWAY,
    MODEL_SHARE,
    MOST_OPERATIONS,
    SHARE_OF_FREE_SPACING,
    TOLERANCE,
    Choice,
    Errors,
    Ladder,
    Layers,
    Level,
    estimated,
    finer_by,
    resolved,
)
from .convolved import (
    CONVOLUTION_TOLERANCE,
    by_convolution,
    in_turn,
    is_by_convolution,
    is_coupled,
    is_layered,
)
from .derived import Derived
from .effects import Judged, judge, of_held_magnet, stated
from .posed import PosedScene

Array = NDArray[np.float64]
Spacing = tuple[float, float]

#: Points up to which a dense factorisation is faster than convolutions.
DENSE_POINTS = 2000
#: Points, about, on which it is estimated what lines leave out: few enough for all of them, and with cells
#: narrower than the distance of the lines.
COPY_POINTS = 400
#: Floating-point operations a second that any machine does.
SLOWEST = 5e8


def solve(
    scene: PosedScene,
    model: Model,
    tolerance: float | None,
    quantity: str,
    *,
    keeping: Sequence[str] = (),
    seconds: float = np.inf,
) -> Result:
    """Solves a scene directly; see :meth:`mtb_rs.Scene.solve`.

    The fields `keeping` of the scene are not left out, whatever they change. ValueError where the choice of a
    spacing would take more than so many `seconds`.
    """
    asked, aimed = model, tolerance
    started = time.perf_counter()
    allowed = LEEWAY * TOLERANCE if tolerance is None else tolerance
    tolerance = TOLERANCE if tolerance is None else tolerance
    geometry = scene.geometry
    free = scene.spacing is None
    start = geometry.start if scene.spacing is None else scene.known_spacing
    assert start is not None
    fixed = scene.with_(spacing=start) if free else scene
    chosen = choose(fixed, tolerance, quantity, free=free) if model == "auto" else given(fixed, model)
    posed, judged = fixed, Judged(fixed, chosen)
    if model == "auto":
        judged = effects_needed(fixed, chosen, tolerance, quantity, keeping, free=free)
        fixed, chosen = judged.scene, judged.choice
    besides = chosen.operations
    # the same on wider cells, the least wide first
    copies = [] if chosen.coarse is None else [chosen.coarse]
    failed: list[Level] = []

    def at(spacing: Spacing, before: Sequence[Level]) -> tuple[Level, Errors | None]:
        nonlocal besides, failed
        level = judged.level
        if level is None or level.spacing != spacing or level.problem.model != chosen.model:
            level = level_at(fixed, chosen.model, spacing, coupled=chosen.coupled)
        wider, layers = [*before, *copies], None
        if level.is_solved and (free or chosen.errors):
            if chosen.model != "half-space" and scene.own_model is None:
                layers = layered(fixed, chosen.model, level, copies)
                wider = [] if layers is None else [layers.wider, *before]
                if layers is not None:
                    besides += layers.operations(copies)
            # to end the choice of a spacing at once takes two of them
            while len(wider) < (2 if free else 1):
                last = wider[-1] if wider else level
                by = level.solution.convolutions > 0.0
                # what is cheap on fine grids, by convolutions, is not much cheaper on half as fine ones; but
                # the waves of a given field vanish in means over three of its cells
                times = 3 if by and geometry.can_be_refined else 2
                width = coarsened(last.spacing, geometry.grid(last.spacing).patches, times)
                if width is None:
                    break
                copy = with_wider_elements(fixed, spacing, width)
                try:
                    copies.append(
                        level_at(
                            copy, chosen.model, width, coupled=chosen.coupled, is_rough=True, convolved=by
                        )
                    )
                except ValueError:
                    # such cells do not fit the scene: the contact reaches the edge of their grid
                    break
                wider.append(copies[-1])
                besides += copies[-1].operations
        # what has no solution on wider cells tells nothing
        pair = () if layers is None else layers.pair
        failed = [found for found in (*wider, *pair) if not found.is_solved]
        wider = [] if layers is not None and failed else [found for found in wider if found.is_solved]
        errors = estimated(level, wider, chosen, layers, skip_border=geometry.is_body_edge)
        if errors is not None and scene.own_model is not None:
            errors = errors.with_mesh(*mesh_errors(level), level.undetermined)
        return level, errors

    def affords(operations: float, spent: float) -> bool:
        elapsed = time.perf_counter() - started
        # what small solves take is not their operations
        rate = max((spent + besides) / elapsed, SLOWEST)
        return elapsed + operations / rate <= seconds

    spent, refused = 0.0, ""
    if free:
        level, errors, spent, reason = resolved(at, start, tolerance, quantity, affords)
        if reason:
            refused = f" Finer cells are refused: {reason}."
        fixed, posed = (each.with_(spacing=level.spacing) for each in (fixed, posed))
    else:
        level, errors = at(start, [])
        # a fuller model helps where the tolerance is missed by what is left out, not by cells or supports
        while errors is not None and chosen.fuller is not None and errors.total(quantity) > tolerance:
            if max(errors.cells[quantity], errors.supports.get(quantity, 0.0)) > AIM * tolerance:
                break
            before, chosen = chosen, chosen.fuller()
            copies = [] if chosen.coarse is None else [chosen.coarse]
            operations = level.operations
            try:
                level, errors = at(start, [])
            except ValueError as error:
                # what is solved is an answer: above all the memory may not hold the fuller model
                refused, chosen = (
                    f" The model {chosen.model!r} would be needed, and is refused: {error}.",
                    before,
                )
                break
            besides += operations
    if back := _needed(posed, judged, level):
        left = seconds - (time.perf_counter() - started)
        return solve(scene, asked, aimed, quantity, keeping=[*keeping, *back], seconds=left)
    clock = time.perf_counter()
    problem = level.problem
    if chosen.time_s:
        problem.time_s["choice of the model"] = chosen.time_s
    result = fixed.finished(
        problem,
        level.solution,
        "direct",
        omitted={**chosen.omitted, **_of_flange(geometry)},
        errors=errors.totals() if errors is not None and chosen.errors else None,
        aim=(quantity, tolerance),
        choosing=besides + spent,
        spacing=level.cell,
    )
    ask(of_peak(result, geometry.hardness))
    stages = sum(problem.time_s.values()) + time.perf_counter() - clock
    problem.time_s["fields"] = time.perf_counter() - clock
    problem.time_s["estimate"] = max(time.perf_counter() - started - stages, 0.0)
    report = replace(result.report, time_s=dict(problem.time_s))
    width, along = level.width
    is_known = errors is not None and np.isfinite(errors.total(quantity))
    if errors is not None and is_known and chosen.errors and not errors.total(quantity) <= allowed:
        missed = _missed(scene, errors, level, tolerance, quantity, refused)
        report = replace(report, missed=missed, status=f"{report.status}, above the tolerance")
    elif level.is_solved and chosen.errors and not is_known:
        needed = _narrower(along) if width <= NARROW else _to_compare(scene, level, chosen, bool(failed))
        missed = f"No error can be estimated: it needs {needed}.{refused}"
        report = replace(report, missed=missed, status=f"{report.status}, not resolved")
    result = replace(result, report=replace(report, notes=(*report.notes, *judged.notes)))
    if judged.omitted:
        # what was asked is told as it was, and nowhere has anything flowed
        flowed = (
            np.zeros(result.pressure.shape) if "hardness" in judged.omitted else result.plastic_indentation
        )
        result = replace(result, summary=posed.statement(), plastic_indentation=flowed)
        if "magnetic_pressure" in judged.omitted:
            magnet = of_held_magnet(posed, level)
            result = replace(result, report=replace(result.report, magnet=magnet))
    derived = Derived(fixed, chosen.model, chosen.coupled, level.is_convolved, tuple(judged.omitted))
    object.__setattr__(result, "_derived", derived)
    return result


def _needed(posed: PosedScene, judged: Judged, level: Level) -> list[str]:
    """What was left out and is needed after all.

    All of it where there is no solution without it; the hardness where a pressure of the solution reaches it.
    """
    if not level.is_solved:
        return list(judged.omitted)
    if "hardness" not in judged.omitted:
        return []
    problem = level.problem
    hardness = posed.hardness_at(problem.points, problem.patches, problem.kept)
    return ["hardness"] if hardness is not None and (level.solution.pressure >= hardness).any() else []


def _missed(
    scene: PosedScene, errors: Errors, level: Level, tolerance: float, quantity: str, refused: str
) -> str:
    """What an estimate above the tolerance has reached, and what would meet it.

    The model is then as full as helps, and what it leaves out is within the tolerance, unless finer cells
    or a fuller model were `refused`, which this sentence says ("": they were not).
    """
    remedies, hint, is_bound = [], "", False
    of_mesh = errors.mesh.get(quantity, 0.0)
    rest = max(tolerance - of_mesh, 0.5 * tolerance)
    if errors.narrow and quantity == "pressure":
        remedies.append(_narrower(errors.narrow))
    elif errors.cells[quantity] > AIM * rest:
        factor = finer_by(errors, rest, quantity)
        # the order at which an error falls is not known far ahead
        finest = max(factor, FINEST_STEP)
        is_bound = factor < FINEST_STEP
        name, size = _finer(scene, level, finest, is_bound=is_bound)
        remedies.append(size)
        if scene.element_size is not None:
            remedies.append(f"an element_size of {1e3 * finest * scene.element_size:.3g} mm")
        elif scene.spacing is None and not refused:
            hint = f", more than {MOST_OPERATIONS:.0e} operations, which a search for the {name} ends at"
        elif scene.spacing is not None and scene.geometry.start is not None:
            hint = f'; {name}=None finds what is needed (in a case file {name} = "auto")'
    if of_mesh > 0.5 * tolerance:
        remedies.append("a finer mesh of the elastic body")
    if errors.supports.get(quantity, 0.0) > 0.5 * tolerance:
        remedies.append("supports that are faces (points give way more the narrower the elements are)")
    reached, aimed = percent(errors.total(quantity)), percent(tolerance)
    # from cells so coarse nobody can tell
    more = " That may not be enough: these cells are too coarse to tell." if is_bound else ""
    needs = f": it needs {' and '.join(remedies)}{hint}" if remedies else ""
    error = f"The estimated error of the {quantity} is {reached}, where {aimed} is asked for"
    return f"{error}{needs}.{more}{refused}"


def _narrower(along: str) -> str:
    """What a contact needs that is too narrow to tell how wide it should be."""
    return (
        f"narrower cells (the contact is at most {NARROW} points wide along {along}, which does not tell how "
        "narrow they must be)"
    )


def _to_compare(scene: PosedScene, level: Level, chosen: Choice, failed: bool) -> str:
    """What a result needs that could not be compared with one on wider cells, and why it could not."""
    # cells half as wide have those of the result to be compared with
    _, size = _finer(scene, level, 0.5, is_bound=True)
    if scene.element_size is not None:
        size += f" and an element_size of {0.5e3 * scene.element_size:.3g} mm"
    if not np.isfinite(list(chosen.errors.values())).all():
        why = "a fuller model has no solution on wider cells, so nothing tells what this one leaves out"
    elif failed:
        why = "the contact has no solution on wider cells, with which it would be compared"
    else:
        why = "it cannot be compared with wider cells, because the contact has too few of them"
    return f"{size} ({why})"


def _finer(scene: PosedScene, level: Level, ratio: float, *, is_bound: bool) -> tuple[str, str]:
    """The argument that sets the cells of a scene, and cells finer by a ratio, or by more, in words."""
    about, further = ("", " or finer") if is_bound else ("about ", "")
    if "points" in scene.inputs:
        count = max(max(patch.nx, patch.ny) for patch in level.problem.patches)
        further = " or more" if is_bound else ""
        return "points", f"{about}{int(np.ceil((count - 1) / ratio)) + 1} points a side{further}"
    x, y = (ratio * size for size in level.spacing)
    unit, scale = ("mm", 1e3) if min(x, y) >= 1e-4 else ("\N{MICRO SIGN}m", 1e6)
    both = f"{scale * x:.3g}" if x == y else f"{scale * x:.3g} x {scale * y:.3g}"
    return "spacing", f"cells of {about}{both} {unit}{further}"


def _of_flange(geometry: Geometry) -> dict[str, str]:
    said = geometry.on_flange
    return {} if said is None else {"friction in the vertical balance": said}


def choose(scene: PosedScene, tolerance: float, quantity: str, *, free: bool = False) -> Choice:
    """The cheapest model that leaves out less than the tolerance, by coarse copies of the scene.

    With a `free` spacing a larger share of the tolerance is left to the cells.
    """
    if scene.own_model is not None:
        return given(scene, scene.own_model)
    clock = time.perf_counter()
    models = scene.models
    spacing = scene.known_spacing
    grid = scene.geometry.grid(spacing)
    large = len(models) == 1 and grid.area.size > DENSE_POINTS
    ladder = [(model, True) for model in models]
    if large and not is_layered(scene) and is_coupled(scene, scene.problem(models[0])):
        ladder.insert(0, (models[0], False))
    if len(ladder) == 1:
        return Choice(models[0])
    wider = coarsened(spacing, grid.patches) or spacing
    try:
        copy = with_wider_elements(scene, spacing, wider)
        ratio = float(np.sqrt(np.prod(wider) / np.prod(spacing)))
        carrier = _widened(carrier_spacing(grid.node_patches), ratio)
        solved = [
            # what is cheap on fine grids, by convolutions, is dear on coarse ones by factorisation
            level_at(copy, m, wider, coupled=coupled, is_rough=True, convolved=large, carrier=carrier)
            for m, coupled in ladder
        ]
    except ValueError:
        # bad input is for the fine problem to name
        return Choice(models[-1], time_s=time.perf_counter() - clock)
    skip, used = scene.geometry.is_body_edge, time.perf_counter() - clock
    found = Ladder(ladder, solved, quantity, skip, wider != spacing, used)
    return found.cheapest((SHARE_OF_FREE_SPACING if free else MODEL_SHARE) * tolerance)


def effects_needed(
    scene: PosedScene, chosen: Choice, tolerance: float, quantity: str, keeping: Sequence[str], *, free: bool
) -> Judged:
    """A scene without the effects, beside its bodies, that change less than is left of the tolerance.

    A given gap may have waves that wider cells cannot hold, and a layer acts on these most: it is judged on
    its own cells, and keeps its effects where these are too many.
    """
    names = [name for name in stated(scene) if name not in keeping]
    if not names:
        return Judged(scene, chosen)
    clock = time.perf_counter()
    spacing = scene.known_spacing
    grid = scene.geometry.grid(spacing)
    wider = (None if scene.gap is not None else coarsened(spacing, grid.patches)) or spacing
    is_coarse = wider != spacing
    if not is_coarse and grid.area.size > DENSE_POINTS:
        return Judged(scene, chosen)
    ratio = float(np.sqrt(np.prod(wider) / np.prod(spacing)))
    carrier = _widened(carrier_spacing(grid.node_patches), ratio) if is_coarse else None
    # of a magnet it is asked whether its state stays, and of one's own cells the solution may be kept
    is_rough = is_coarse and "magnetic_pressure" not in names
    operations = 0.0

    def at(changed: PosedScene) -> Level:
        nonlocal operations
        if is_rough and changed is scene and chosen.coarse is not None and chosen.coarse.spacing == wider:
            return chosen.coarse
        copy = with_wider_elements(changed, spacing, wider)
        level = level_at(
            copy, chosen.model, wider, coupled=chosen.coupled, is_rough=is_rough, carrier=carrier
        )
        operations += level.operations
        return level

    share = SHARE_OF_FREE_SPACING if free else MODEL_SHARE
    try:
        found = judge(scene, chosen, share * tolerance, quantity, names, at, is_coarse=is_coarse)
    except ValueError:
        # bad input is for the fine problem to name
        return Judged(scene, chosen)
    choice = found.choice
    choice = replace(
        choice,
        operations=choice.operations + operations,
        time_s=choice.time_s + time.perf_counter() - clock,
    )
    return replace(found, choice=choice)


def given(scene: PosedScene, model: Model) -> Choice:
    """A model the user has chosen: what it leaves out is named, its size would cost more than the solve."""
    if scene.own_model is not None:
        return Choice(scene.own_model)
    fuller = scene.models[scene.models.index(model) + 1 :]
    omitted = {EFFECTS[m]: "not estimated; model='auto' does" for m in fuller}
    return Choice(model, omitted, {}) if omitted else Choice(model)


def level_at(
    scene: PosedScene,
    model: Model,
    spacing: Spacing,
    *,
    coupled: bool = True,
    is_rough: bool = False,
    convolved: bool | None = None,
    thinner: float = 1.0,
    carrier: Spacing | None = None,
) -> Level:
    """A model solved at a spacing.

    Parameters
    ----------
    coupled : bool
        Whether friction opens the gap between half-spaces.
    is_rough : bool
        Only an estimate is made of it.
    convolved : bool or None
        Whether by convolutions where they can be used; None: as the size asks.
    thinner : float
        Layers of the elements of upper bodies are those of cells finer by this factor.
    carrier : (dx, dy) [m] or None
        Spacing of the points that bodies under many points are condensed onto.
    """
    clock = time.perf_counter()
    problem = scene.problem(model, spacing, thinner=thinner, carrier=carrier)
    problem.time_s["geometry and bodies"] = time.perf_counter() - clock - sum(problem.time_s.values())
    if (goes_far(scene, problem) if convolved is None else convolved) and is_by_convolution(scene, problem):
        memory.say(memory.SOLVED_CELL * problem.n, f"the scene of {problem.n} cells")
        # a rough one need not be better than its cells
        tolerance = None if is_rough else CONVOLUTION_TOLERANCE
        by = in_turn if coupled and is_coupled(scene, problem) else by_convolution
        return Level(problem, by(scene, problem, tolerance), spacing, is_convolved=True)
    if not coupled:
        smooth = replace(problem.without_friction(), time_s=problem.time_s)
        solution = solve_direct(smooth, with_margin=False)
        solution = replace(solution, friction=problem.friction_at(solution.pressure))
    else:
        solution = solve_direct(problem, with_margin=not is_rough)
    return Level(problem.settled(solution), solution, spacing)


def goes_far(scene: PosedScene, problem: ContactProblem) -> bool:
    """Whether convolutions are quicker than matrices: for many points, and where bodies creep, as the dense
    method counts on the symmetry that they have lost."""
    return problem.n > DENSE_POINTS or do_creep(*scene.simple)


def mesh_errors(level: Level) -> tuple[float, float]:
    """Shares (whole, at the contact) of its energy that the worse mesh of two bodies leaves out.

    Bodies of one's own cannot be meshed anew; what their meshes leave out shows in their stress.
    """
    coefficients, first = level.solution.coefficients(level.problem), 0
    shares = []
    for side in (level.problem.upper, level.problem.lower):
        for part in side.state:
            motion = level.solution.motion[first : first + len(part.modes)]
            first += len(part.modes)
            shares.append(left_out(part.body, part.moved(coefficients, motion)))
    return max(s[0] for s in shares), max(s[1] for s in shares)


def layered(scene: PosedScene, model: Model, level: Level, known: Sequence[Level]) -> Layers | None:
    """Copies of an elastic level on wider cells.

    One differs from the level by its cells alone, two from each other by the layers of elements of the upper
    body alone, so that one error cannot hide the other. Where bodies are condensed onto fewer points than
    touch, these two differ by that instead. None where there is nothing to widen. `known` ones are not solved
    again.
    """
    width = coarsened(level.spacing, scene.geometry.grid(level.spacing).patches)
    if width is None:
        return None
    ratio = float(np.sqrt(np.prod(width) / np.prod(level.spacing)))
    try:
        copy = with_wider_elements(scene, level.spacing, width)
        carrier = carrier_spacing(level.problem.patches)
        if carrier is None:
            own = level_at(copy, model, width, is_rough=True, thinner=ratio)
            wide = next((k for k in known if k.spacing == width and k.problem.model == model), None)
            return Layers(own, (own, wide or level_at(copy, model, width, is_rough=True)))
        own = level_at(copy, model, width, is_rough=True, carrier=carrier)
        # two of these cells between lines, about
        times = max(2, math.ceil(math.sqrt(level.problem.n / COPY_POINTS)))
        width = coarsened(level.spacing, scene.geometry.grid(level.spacing).patches, times)
        assert width is not None
        copy = with_wider_elements(scene, level.spacing, width)
        # with a size of their own elements are the same on lines and on all points
        on_points = scene.element_size is None and _on_points(level)
        lines, points = (level_at(copy, model, width, is_rough=True, carrier=c) for c in (carrier, None))
        return Layers(own, (points, lines), are_of_lines=True, on_points=on_points)
    except ValueError:  # the contact is too narrow for such cells or elements
        return None


def _on_points(level: Level) -> bool:
    """Whether a body of an elastic level is held at points."""
    sides = (level.problem.upper, level.problem.lower)
    return any(are_at_points(part.body.supports) for side in sides for part in side.state)


def _widened(carrier: Spacing | None, ratio: float) -> Spacing | None:
    return None if carrier is None else (ratio * carrier[0], ratio * carrier[1])


def with_wider_elements(scene: PosedScene, spacing: Spacing, wider: Spacing) -> PosedScene:
    """The scene for cells of `wider` instead of `spacing`, its elements wider by the same ratio.

    Raises
    ------
    ValueError
        If the contact is too narrow for such elements.
    """
    if scene.element_size is None:
        return scene
    return scene.with_(element_size=scene.element_size * max(np.divide(wider, spacing)))
