# SPDX-License-Identifier: MIT OR Apache-2.0
"""Stick and slip: shifts, transient and steady rolling."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from dataclasses import replace
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .. import _mtb_rs
from ..base.check import choice, number
from ..base.errors import ConvergenceError, ToleranceWarning
from ..base.owning import check_finite
from ..base.progress import shares_shown
from ..base.questions import ask, gathered
from ..base.renamed import renamed
from ..base.units import taking_quantities
from ..base.words import Coupling
from ..bodies.simple import are_prisms, field_body, surface_of
from ..friction.laws import Friction, InterfaceLayer, PlasticLayer, ShearLayer, as_law
from ..geometry.contact_points import window
from ..results.plausible import of_dent, of_way
from ..results.report import Report
from ..results.temperature import flows_along
from .motions import Motion, Rolling, Shift
from .normal import NormalResult, reaches_edge, resistance_of, solve_normal
from .pressure_field import OF_UNLIKE, PressureField, creepage_rows, pressure_field
from .tangential_operators import cut_before, earlier, operators_around, plasticity_of, velocity_of
from .tangential_result import Given, TangentialResult, gap_by_traction
from .tangential_state import TangentialState
from .temperature_friction import of_temperature

Array = NDArray[np.float64]

#: The name that results which were pickled earlier know it by.
_Given = Given

#: Distance over the one before up to which a creep curve is continued by its last two points.
_FARTHEST = 3.0


@taking_quantities
def solve_tangential(
    normal: Any,
    motion: Rolling | Shift,
    friction: Friction,
    layer: InterfaceLayer | PlasticLayer | None = None,
    state: TangentialState | None = None,
    tolerance: float = 1e-8,
    coupling: Coupling = "one-way",
) -> TangentialResult:
    """Traction, stick and slip of a contact that shifts or rolls.

    The bodies are half-spaces under piecewise constant tractions. The solver is a semismooth Newton method
    that starts from coarser grids and computes its products by the Fourier transform. In steady rolling the
    slip is a first-order difference over one step, and in steady and transient rolling the rigid slip is
    taken a sixth of a step ahead. CONTACT does both, so its fields agree cell by cell. The error falls with
    `Rolling.step`, by default one cell. ``Rolling(order=2)`` is of second order in the cells.

    Parameters
    ----------
    normal : NormalResult, Result or PressureField
        Pressure on one regular patch, and the two bodies.
    motion : Rolling or Shift
    friction : Coulomb, StaticKinetic, FallingFriction, TabulatedFriction or TemperatureFriction
    layer : InterfaceLayer, PlasticLayer or None
        Layer that adds its shear compliance; an elastic one has no influence in full sliding. One that yields
        bounds the traction as well; it takes Coulomb's friction.
    state : TangentialState or None
        Earlier state of a shift or a transient step; None for surfaces without traction.
    tolerance : float [-]
        Relative residual of the contact conditions.
    coupling : {"one-way", "full"}
        For unlike bodies. Their pressure always moves the surfaces tangentially. "one-way" leaves out the
        normal displacement by the traction, and reports the size of this change of the gap as
        ``report.omitted["gap_change_by_traction_m"]``. "full" repeats both problems in turn until the
        pressure stays, at the force or the approach that was given for `normal`, and reports the change of
        the pressure over its peak, as ``report.force_balance["pressure_change_by_traction"]``. It needs the
        gap, so `normal` must be a result of `solve_normal` with locked tilts: a scene's result, a
        :class:`PressureField`, a line contact, a periodic contact or free tilts (`moments`) are refused. Like
        bodies settle in one round.

    Raises
    ------
    ValueError
        For bad input, for a force of at least what the coefficient at rest and the layer carry, and for a
        layer that softens so fast that more than one answer may exist.
    ConvergenceError
        If no solution was found. The message names the likely cause, and the last iterate is its ``result``.
    """
    choice("coupling", coupling, Coupling)
    _check_problem(motion, as_law(friction), layer, state)
    number("tolerance", tolerance)
    if coupling == "full":
        # what presses has been asked about where it was solved
        with gathered():
            return _alternate(normal, motion, friction, layer, state, tolerance)
    started = time.perf_counter()
    field = pressure_field(normal)
    _check_velocity(normal, field, motion)
    if not motion.is_steady:
        _ask_about_step(field, motion)
    _ask_about(normal)
    _ask_about_order(field, motion)
    _ask_about_heat(field, motion, friction)
    if motion.is_steady and state is not None:
        raise ValueError("state is given, but steady rolling has no past: use transient=True or leave it out")
    shape = field.pressure.shape
    slip_given = motion.slip_given((shape[0], shape[1]))
    operators, cut, origin = operators_around(field, motion, layer, state)
    prepared = time.perf_counter()
    there = None if state is None else cut_before(state, field, cut)

    found = operators.solve(
        window(field.pressure, cut),
        origin,
        motion.drive(),
        float(motion.rigid[2]),
        float(motion.slip_speed),
        friction.native(shape, cut),
        earlier(state, friction, there),
        float(tolerance),
        around=(shape[::-1], (cut[1].start, cut[0].start)),
        plasticity=plasticity_of(layer, state, there),
        rigid_slip=None if slip_given is None else window(slip_given, cut),
    )
    finished = time.perf_counter()
    result = _result(field, motion, friction, layer, cut, found, (started, prepared, finished))
    result = replace(result, rolling_resistance=resistance_of(normal, field))
    if found.rounds is not None:
        result = _with_rounds(result, *found.rounds)
    # what was given is no field of a result, but its derivatives need it
    object.__setattr__(result, "_given", Given(field, friction, layer, state, {}, {}))
    if not result.report.converged:
        missed = (
            f"stick and slip were not found: residual {result.report.residual:.1e} after "
            f"{result.report.iterations} Newton steps, {tolerance:.0e} asked for"
            if found.rounds is None
            else "traction and temperature do not settle: the coefficients of friction still change by "
            f"{found.rounds[1]:.1e} of the largest after {found.rounds[0]} rounds"
        )
        raise ConvergenceError(missed + _likely_cause(motion, friction), result)
    return result


def _with_rounds(result: TangentialResult, rounds: int, change: float) -> TangentialResult:
    """The result, with the rounds between traction and temperature in its report."""
    report = replace(
        result.report,
        method=f"traction and temperature in turn, {rounds} rounds",
        residual=max(result.report.residual, change),
    )
    return replace(result, report=report)


def _length_along(field: PressureField, step: Array) -> tuple[float, float]:
    """Lengths [m] of the contact along a step, and of a cell."""
    way, touches = float(np.hypot(*step)), field.pressure > 0.0
    x, y = field.coordinates()
    along = (np.add.outer(y * step[1], x * step[0]) / way)[touches]
    cell = float(np.abs(step / way) @ field.spacing)
    return float(np.ptp(along)) + cell, cell


def _ask_about_step(field: PressureField, motion: Motion) -> None:
    """A question about a long step of transient rolling."""
    step = np.array(motion.step_on(field))
    way = float(np.hypot(*step))
    if way > 0.0 and np.any(field.pressure > 0.0):
        ask(of_way(way, *_length_along(field, step)), kind=ToleranceWarning)


def _ask_about_heat(field: PressureField, motion: Motion, friction: Friction) -> None:
    """A question about friction that follows the temperature where heat flows along the surface as well."""
    law = of_temperature(friction)
    if law is not None and np.any(field.pressure > 0.0):
        length, _ = _length_along(field, np.array(motion.step_on(field)))
        slow = flows_along(0.5 * length, float(motion.slip_speed), (law.lower, law.upper))
        ask(f"{left_out}, and friction is that at these" for left_out in slow)


def _check_velocity(normal: Any, field: PressureField, motion: Motion) -> None:
    """Whether the pressure on bodies that creep is that of the same rolling."""
    velocity = velocity_of(field, motion)
    own = normal.rolling_velocity if isinstance(normal, NormalResult) else None
    if velocity is None or own is None:
        return
    if math.dist(own, velocity) > 1e-9 * math.hypot(*velocity):
        raise ValueError(
            f"the motion has a velocity of ({velocity[0]:g}, {velocity[1]:g}) m/s, and the normal contact of "
            f"these bodies that creep was solved for ({own[0]:g}, {own[1]:g}) m/s: "
            "solve_normal(..., rolling=motion) is needed"
        )


def _ask_about(normal: Any) -> None:
    """Questions about a pressure that was given; those about a result came where it was solved."""
    if isinstance(normal, PressureField):
        bodies = normal.lower, normal.upper
        surfaces = [surface_of(body) for body in bodies if body is not None]
        ask(of_dent(float(normal.pressure.max()), surfaces))


def _ask_about_order(field: PressureField, motion: Motion) -> None:
    """A question about slip of second order between unlike bodies."""
    ask([OF_UNLIKE] if motion.order == 2 and field.is_unlike() else [])


def _likely_cause(motion: Rolling | Shift, friction: Friction) -> str:
    """What may stand against a solution, to be put behind a message."""
    if friction.is_constant:
        return ""
    causes = []
    if motion.is_driven:
        causes.append("the force prescribed may be above the largest one that this friction law carries")
    if friction.lacks_memory:
        advice = "friction that depends on the slip may have no state without a memory: give it one"
        causes.append(advice + motion.advice)
    law = of_temperature(friction)
    if law is not None and len(law.temperature) > 1:
        fall, start, end = law.steepest()
        if fall > 0.0:
            causes.append(
                f"the coefficient may fall too steeply for it, by {fall:.3g} from {start:g} to {end:g} K: "
                "give it more kelvin, or a memory"
            )
    return f"; {', or '.join(causes)}" if causes else ""


def _check_problem(motion: Any, friction: Friction, layer: Any, state: Any) -> None:
    if not isinstance(motion, Motion):
        raise ValueError(f"motion is {motion!r}: a Rolling or a Shift is needed")
    if layer is not None and not isinstance(layer, ShearLayer):
        raise ValueError(f"layer is {layer!r}: an InterfaceLayer or a PlasticLayer is needed, or None")
    if layer is not None and layer.plasticity is not None and not friction.is_constant:
        raise ValueError(
            f"friction is a {type(friction).__name__}, and the layer yields: a layer that yields is solved "
            "with Coulomb's friction"
        )
    if motion.order == 2 and layer is not None and layer.plasticity is not None:
        raise ValueError(
            "order is 2 and the layer yields: the traction at the leading edge is bounded by its yield "
            "stress, and not in proportion to the pressure; order=1 is needed"
        )
    if of_temperature(friction) is not None and not motion.is_steady:
        raise ValueError(
            "friction is a TemperatureFriction: it follows the temperature of steady rolling, so "
            "Rolling(..., transient=False) is needed as the motion"
        )
    if state is not None and not isinstance(state, TangentialState):
        raise ValueError(f"state is {state!r}: the TangentialState of an earlier result is needed, or None")


#: Largest change of the pressure, over its peak, at which the alternation of both problems ends, and over
#: the tolerance; the lesser of the two counts.
_SETTLED = 1e-6
_SETTLED_OVER_TOLERANCE = 100.0


def _alternate(
    normal: Any,
    motion: Rolling | Shift,
    friction: Friction,
    layer: InterfaceLayer | PlasticLayer | None,
    state: TangentialState | None,
    tolerance: float,
) -> TangentialResult:
    """Normal and tangential problem in turn [Kalker1990, ch. 4] until the pressure stays."""
    if not isinstance(normal, NormalResult):
        raise ValueError(
            f"normal is a {type(normal).__name__}: coupling='full' needs a result of solve_normal"
        )
    if any(normal.tilts):
        raise ValueError(
            "coupling='full' does not let the bodies tilt, but they were free to tilt in the normal contact: "
            "a result of solve_normal without moments_about_axes is needed"
        )
    first = pressure_field(normal)
    field = first
    if normal.report.status == "approximate":
        raise ValueError(
            f"normal is an approximation by {normal.report.method!r}: coupling='full' solves the normal "
            'problem again, and needs the result of solve_normal(..., method="auto")'
        )
    _check_velocity(normal, field, motion)
    changes: list[float] = []
    opened = gap_by_traction(field, motion)
    # what was given for the normal contact stays
    by_force = "prescribed" in normal.report.force_balance or normal.report.status == "closed form"
    held: dict[str, Any] = {"force": normal.normal_force} if by_force else {"approach": normal.approach}
    settled = min(_SETTLED, _SETTLED_OVER_TOLERANCE * tolerance)
    result = solve_tangential(field, motion, friction, layer, state, tolerance)
    while not changes or changes[-1] > settled:
        again = solve_normal(
            normal.initial_gap + opened.of(result.traction),
            field.spacing,
            lower=field_body("lower", normal.lower),
            upper=field_body("upper", normal.upper),
            **held,
            tolerance=min(tolerance, 1e-8),
            # contact at the edge of the grid may have been legitimate in the normal problem already
            edge="sharp" if reaches_edge(normal.pressure) else "error",
            normal_layer=normal.normal_layer,
            hardness=normal.hardness,
            rolling=None if normal.rolling_velocity is None else motion,
            inclination=None if are_prisms(normal.lower, normal.upper) else normal.inclination,
        )
        pressure = np.maximum(np.asarray(again.pressure, dtype=float), 0.0)
        changes.append(float(np.abs(pressure - field.pressure).max() / pressure.max()))
        field = replace(field, pressure=pressure)
        result = solve_tangential(field, motion, friction, layer, state, tolerance)
        if len(changes) > 3 and changes[-1] > 0.9 * changes[-2] > 10.0 * settled:
            raise ConvergenceError(
                f"normal and tangential problem do not settle: the pressure changes by {changes[-1]:.1e}",
                result,
            )
    whole = float(np.abs(field.pressure - first.pressure).max() / first.pressure.max())
    balance = {**result.report.force_balance, "pressure_change_by_traction": whole}
    report = replace(
        result.report, method=f"alternating, {len(changes)} rounds", omitted={}, force_balance=balance
    )
    # what the pressure works on the whole of what gives way, by traction as well
    pressed = replace(again, initial_gap=normal.initial_gap)
    passage = None if opened.cancels else motion.passage
    way = None if passage is None else (float(np.cos(passage)), float(np.sin(passage)))
    settled_result = replace(result, report=report, rolling_resistance=resistance_of(pressed, field, way))
    object.__setattr__(settled_result, "_given", Given(field, friction, layer, state, {}, {}, again))
    return settled_result


def _balance(motion: Rolling | Shift, force: Array) -> dict[str, float]:
    """The part of prescribed forces that is missing, over the normal force; nothing where none is."""
    pairs = zip(force, motion.force or (), strict=False)
    missing = [abs(own - given) for own, given in pairs if given is not None]
    return {"relative_error": float(max(missing) / abs(force[2]))} if missing else {}


def _left_out(
    field: PressureField, motion: Motion, traction: Array, status: NDArray[Any]
) -> dict[str, float]:
    """Size of the change of the gap by traction, which the pressure given has not felt."""
    opened = gap_by_traction(field, motion)
    if field.reference is not None or opened.cancels:
        return {}
    change = opened.of(traction)[status > 0]
    return {"gap_change_by_traction_m": float(np.abs(change - change.mean()).max())}


def _result(
    field: PressureField,
    motion: Rolling | Shift,
    friction: Friction,
    layer: InterfaceLayer | PlasticLayer | None,
    cut: tuple[slice, slice],
    found: _mtb_rs.TangentialOutcome,
    times: tuple[float, float, float],
) -> TangentialResult:
    shape = field.pressure.shape

    def whole(part: NDArray[Any], fill: float = 0.0) -> NDArray[Any]:
        """`part` of the grid (..., ny, nx) put back into the whole of it."""
        seen = tuple(slice(-c.start, n - c.start) for c, n in zip(cut, shape, strict=True))
        return window(part, seen, fill)

    status = whole(found.status)
    slip = whole(found.slip)
    slip[:, status < 2] = 0.0
    dissipation = np.asarray(found.dissipation)
    plastic_slip = accumulated = plastic_heat = None
    areas = {}
    area = field.spacing[0] * field.spacing[1]
    if found.plastic is not None:
        share, accumulated = (whole(part) for part in found.plastic)
        plastic_slip, plastic_heat = share * slip, share * dissipation
        slip = (1.0 - share) * slip
        areas["plastic_area"] = float(np.count_nonzero(status == 3) * area)
    x, y = field.coordinates()
    coefficient = np.where(status > 0, whole(found.coefficient), friction.of_open(shape))
    tangential = whole(found.traction)
    traction = np.concatenate([tangential, np.zeros((1, *shape))])
    force = np.array([*found.force, -field.normal_force])
    spin = motion.rigid[2]
    report = Report(
        converged=found.converged,
        status="converged" if found.converged else "no convergence",
        model="half-space" if layer is None else "half-space and layer",
        method="direct",
        solver="semismooth Newton on discs, GMRES, FFT, nested grids",
        iterations=found.iterations,
        residual=found.history[-1],
        contact_area=float(np.count_nonzero(status) * area),
        peak_pressure=float(field.pressure.max()),
        convolutions=found.products,
        preconditionings=found.preconditionings,
        force_balance={
            "tangential": float(np.hypot(force[0], force[1])),
            "normal": field.normal_force,
            "stick_area": float(np.count_nonzero(status == 1) * area),
            **areas,
            **_balance(motion, force),
        },
        omitted=_left_out(field, motion, traction, status),
        time_s={"operators": times[1] - times[0], "solve": times[2] - times[1]},
        history=tuple(found.history),
    )
    state = TangentialState(tangential, field.pressure, coefficient, field.start, field.spacing, accumulated)
    return TangentialResult(
        points=np.stack(np.meshgrid(x, y)),
        area=np.full(field.pressure.shape, area),
        pressure=field.pressure,
        traction=traction,
        slip=slip,
        status=status,
        friction_coefficient=coefficient,
        dissipation=dissipation,
        force=force,
        spin_moment=found.spin_moment,
        creepage=np.array([*found.drive, spin]),
        motion=motion,
        state=state,
        report=report,
        plastic_slip=plastic_slip,
        accumulated_plastic_slip=accumulated,
        plastic_dissipation=plastic_heat,
        lower=field.body("lower"),
        upper=field.body("upper"),
        is_line=field.reference is not None,
        is_inclined=field.inclination is not None,
        inclination=field.angles(),
    )


@taking_quantities
@renamed(speed="velocity")
def creep_curve(
    normal: Any,
    creepages: ArrayLike,
    friction: Friction,
    layer: InterfaceLayer | PlasticLayer | None = None,
    velocity: float = 10.0,
    tolerance: float = 1e-6,
    progress: Callable[[float], Any] | Literal[True] | None = None,
    order: int = 1,
) -> Array:
    """Forces of steady rolling over a list of creepages.

    Along a line of creepages each solve starts from the last two, which halves the work if they are close.

    Parameters
    ----------
    normal : NormalResult, Result or PressureField
    creepages : (n, 3)
        (xi, eta, phi) [-, -, 1/m] each. Columns of a table of pandas are taken by their names "xi", "eta" and
        "phi", in whatever order.
    friction, layer
        As in :func:`solve_tangential`.
    velocity : float [m/s]
        Of rolling.
    tolerance : float [-]
    progress : callable or True
        Called with the share done after each creepage; True shows a bar (extra ``notebook``).
    order : {1, 2}
        Of the errors in the size of the cells, as of :class:`mtb_rs.Rolling`.

    Returns
    -------
    (n, 3) float
        Fx, Fy [N] and Mz [N m] on the lower body.

    Raises
    ------
    ConvergenceError
        If creepages did not converge. The message names them, and ``.result`` holds all forces, with NaN for
        these.
    """
    rows = creepage_rows(creepages)
    number("tolerance", tolerance)
    field = pressure_field(normal)
    _ask_about(normal)
    rolling = Rolling(velocity=velocity, order=order)
    _check_problem(rolling, as_law(friction), layer, None)
    _check_velocity(normal, field, rolling)
    _ask_about_order(field, rolling)
    _ask_about_heat(field, rolling, friction)
    operators, cut, origin = operators_around(field, rolling, layer, None)
    shape = field.pressure.shape
    plasticity = plasticity_of(layer, None, None)
    pressure = window(field.pressure, cut)
    forces: Array = np.zeros((len(rows), 3))
    converged = np.zeros(len(rows), dtype=bool)
    # where friction falls with slip or heat there may be several states, and the start would choose one
    is_unique = not friction.depends_on_speed and of_temperature(friction) is None
    around = None if of_temperature(friction) is None else (shape[::-1], (cut[1].start, cut[0].start))
    law = friction.native(shape, cut)
    size = math.sqrt(np.count_nonzero(pressure) * field.spacing[0] * field.spacing[1])
    places = rows * np.array([1.0, 1.0, size])
    last: list[Array] = []
    with shares_shown(progress, "rolling") as told:
        for k, (xi, eta, phi) in enumerate(rows.tolist()):
            start = _along(places[k - 2 : k + 1], last) if is_unique and len(last) == 2 else None
            found = operators.solve(
                pressure,
                origin,
                [(xi, False), (eta, False)],
                phi,
                float(velocity),
                law,
                None,
                float(tolerance),
                start,
                around,
                plasticity,
            )
            forces[k], converged[k] = (*found.force, found.spin_moment), found.converged
            last = [*last[-1:], found.traction] if converged[k] else []
            told((k + 1) / len(rows))
    failed = np.flatnonzero(~converged)
    if failed.size:
        forces[failed] = np.nan
        cause = _likely_cause(rolling, friction)
        raise ConvergenceError(f"no convergence at creepages {rows[failed].tolist()}{cause}", forces)
    check_finite("forces", forces)
    return forces


def _along(places: Array, last: list[Array]) -> Array | None:
    """The traction at the third of three places from those at the two before; None where no line goes on."""
    before, ahead = np.diff(places, axis=0)
    square = float(before @ before)
    share = float(ahead @ before) / square if square > 0.0 else 0.0
    if not 0.0 < share < _FARTHEST or np.linalg.norm(ahead - share * before) > 0.1 * np.linalg.norm(ahead):
        return None
    return np.ascontiguousarray(last[1] + share * (last[1] - last[0]))
