# SPDX-License-Identifier: MIT OR Apache-2.0
"""From sticking to full sliding, for bodies of any kind."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from typing import Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .. import _mtb_rs
from ..base.check import reals, warn
from ..base.errors import ConvergenceError, ToleranceWarning
from ..base.memory import of_matrices, refuse
from ..base.owning import solved
from ..base.plain import plain
from ..base.stored import input_data, stored
from ..base.told import Row, in_words
from ..base.units import taking_quantities
from ..bodies.simple import FieldBody
from ..friction.laws import InterfaceLayer
from ..geometry.contact_points import Patch
from ..results.doors import pictures
from ..results.fields import Field, fields_of, totals_of
from ..results.result import Curved, Pictured
from ..results.stressed import Loads, Stressed, loaded_patches
from .problem import ContactProblem

Array = NDArray[np.float64]

#: What is drawn over the way of the upper body.
CURVES = ("force", "slip_share")


def check_room(points: int, matrices: int = 20) -> None:
    """ValueError if the memory does not hold the matrices of the start of sliding, by default coupled."""
    refuse(
        of_matrices(points, matrices), f"the start of sliding of {points} points", "take fewer, larger cells"
    )


@stored
@solved
@dataclass(frozen=True, repr=False)
@plain
class StartOfSliding(Curved, Stressed, Pictured):
    """The way of a contact from rest to full sliding, step by step.

    ``plot()`` draws the force over the way of the upper body, ``plot("slip_share")`` the share that slips,
    and ``plot("traction")`` and the like the last state as maps, lines or in space.

    Attributes
    ----------
    displacement : (m, 2) [m]
        Displacement of the upper body over the lower one, far from the contact.
    force : (m, 2) [N]
        Load of the contact on the lower body along x and y, as :attr:`mtb_rs.Result.force`: friction, and
        what the pressure adds on a surface that is not level.
    normal_force : (m,) [N]
        Sum of pressure times area.
    slip_share : (m,) [-]
        Share of the contact area that slips in the step.
    traction : (2, n) [Pa]
        On the lower body after the last step, along x of the track as seen from above, and across, in its
        surface.
    pressure : (n,) [Pa]
        After the last step.
    status : (n,) int
        0 open, 1 stick, 2 slip, in the last step.
    iterations : (m,) int
        Newton steps.
    path_error : (m,) [-]
        Estimated error by the finite steps of the way, as if the errors of all steps added up: of the
        tangential tractions as a share of the friction that all points can bear, or of the pressures as a
        share of the normal force, whichever is larger. The estimate comes from following each step in more
        and more parts.
    points : (3, n) [m]
        Contact points; none (3, 0) of :func:`mtb_rs.start_of_sliding`, which does not know their places.
    area : (n,) [m2]
    patches : tuple of Patch
    summary : Mapping
        Inputs of the scene.
    lower, upper : HalfSpace, Layered, Rigid or None
        None of those that it does not know, and of bodies of finite elements.
    elastic : tuple of str
        Which bodies, "lower" or "upper", have finite elements.
    """

    # what the user has said
    _unbounded = ("summary",)
    curves: ClassVar[tuple[str, ...]] = CURVES
    over: ClassVar[str] = "the way"

    displacement: Array
    force: Array
    normal_force: Array
    slip_share: Array
    traction: Array
    pressure: Array
    status: NDArray[np.int8]
    iterations: NDArray[np.int64]
    path_error: Array
    points: Array = field(default_factory=lambda: np.empty((3, 0)))
    area: Array = field(default_factory=lambda: np.empty(0))
    patches: tuple[Patch, ...] = ()
    summary: Mapping[str, Any] = field(default_factory=dict, compare=False)
    lower: FieldBody | None = None
    upper: FieldBody | None = None
    elastic: tuple[str, ...] = ()

    def _loads(self) -> Loads:
        if self.blank:
            raise ValueError(self.blank)
        grids = loaded_patches(self.patches, self.points, self.area, self.pressure, self.traction)
        return Loads(grids, self.lower, self.upper, elastic=self.elastic)

    def ends(self) -> dict[str, float]:
        """Numbers that it has come to at its end, by name [SI]: the columns of a sweep."""
        (x, y), (force_x, force_y) = self.displacement[-1], self.force[-1]
        return {
            "displacement_x": x,
            "displacement_y": y,
            "force_x": force_x,
            "force_y": force_y,
            "normal_force": self.normal_force[-1],
            "peak_pressure": self.pressure.max(initial=0.0),
            "slip_share": self.slip_share[-1],
            "path_error": self.path_error.max(),
            "steps": self.force.shape[0],
        }

    @property
    def blank(self) -> str:
        """Why it has no picture of its contact points; "" where it has one."""
        if self.points.size:
            return ""
        return "the places of its points are not known: Scene.start_of_sliding knows them"

    def _picture(self) -> StartOfSliding:
        if self.blank:
            raise ValueError(self.blank)
        return self

    def _kept(self) -> StartOfSliding:
        lower, upper = (own and own.kept() for own in (self.lower, self.upper))
        return replace(self, summary=input_data(self.summary), lower=lower, upper=upper)

    def check(self) -> None:
        """Checks that what was read from files fits together; ValueError if it does not."""
        super().check()
        m, n = len(self.displacement), self.pressure.size
        wanted = {"displacement": (m, 2), "force": (m, 2), "traction": (2, n), "status": (n,)}
        wanted |= dict.fromkeys(("normal_force", "slip_share", "iterations", "path_error"), (m,))
        for name, shape in wanted.items():
            if getattr(self, name).shape != shape:
                raise ValueError(f"{name} has the shape {getattr(self, name).shape}: {shape} is needed")

    def fields(self) -> dict[str, Field]:
        """The last state over the contact points, by name: values with unit and label."""
        state = fields_of(pressure=self.pressure, traction=self.traction, status=self.status)
        return state if self.blank else fields_of(points=self.points, area=self.area) | state

    def totals(self) -> dict[str, Field]:
        """What it has at each step, by name: values with unit and label."""
        return totals_of(
            displacement=self.displacement,
            force=self.force,
            normal_force=self.normal_force,
            slip_share=self.slip_share,
        )

    def facts(self) -> dict[str, Any]:
        """What else its `summary.json` holds: inputs, and the Newton steps."""
        return {"inputs": self.summary, "iterations": self.iterations, "path_error": self.path_error}

    def told(self) -> list[Row]:
        """Its last step in words: what a notebook shows."""
        slips = self.slip_share >= 1.0 - 1e-9
        return [
            ("steps", str(len(self.force))),
            ("displacement", in_words(self.displacement[-1], "m")),
            ("force on the lower body", in_words(self.force[-1], "N")),
            ("normal force", in_words(self.normal_force[-1], "N")),
            ("slips", f"{100.0 * self.slip_share[-1]:.4g} % of the contact area"),
            ("all slips", f"from step {int(slips.argmax()) + 1} on" if slips.any() else "in no step"),
        ]

    def _line(self, quantity: str, ax: Any) -> Any:
        return pictures().draw_start(self, quantity, ax)

    def __repr__(self) -> str:
        stick, slip = (np.count_nonzero(self.status == s) for s in (1, 2))
        fx, fy = self.force[-1]
        return (
            f"StartOfSliding({len(self.force)} steps, {self.status.size} points, last: {stick} stick, "
            f"{slip} slip, force ({fx:.4g}, {fy:.4g}) N of {self.normal_force[-1]:.4g} N)"
        )


@taking_quantities
def start_of_sliding(
    compliance: _mtb_rs.Compliance,
    pressure: ArrayLike,
    area: ArrayLike,
    friction: float | ArrayLike,
    displacements: ArrayLike,
    layer: InterfaceLayer | None = None,
    tolerance: float = 1e-8,
) -> StartOfSliding:
    """Pushes one body over the other in steps, its pressure held, until everything slides.

    Parameters
    ----------
    compliance : Compliance
        Of both bodies together: displacement of the lower one relative to the upper one by a traction on
        the lower one, as `Compliance.relative` gives it.
    pressure, area : (n,) [Pa], [m2]
    friction : float or (n,) [-]
    displacements : (m, 2) [m]
        Of the upper body over the lower one at the end of each step, from rest. Each step is followed in
        parts, so many of them that it adds an error of at most 1e-3 (`path_error`): the states depend on the
        way, and not on the number of steps along it. The method itself is of first order.
    layer : InterfaceLayer or None
        Softens the start of sliding; it has no influence in full sliding.
    tolerance : float [-]

    Raises
    ------
    ConvergenceError
        Naming the step; with the steps before it as ``.result``.

    Warns
    -----
    ToleranceWarning
        If 256 parts of a step do not keep the error that it adds below 1e-3.
    """
    a = np.asarray(area, dtype=float).ravel()
    return start_with_held_pressure(
        compliance, pressure, a, friction, displacements, layer, tolerance, lambda traction: traction[:2] @ a
    )


def start_with_held_pressure(
    compliance: _mtb_rs.Compliance,
    pressure: ArrayLike,
    a: Array,
    friction: float | ArrayLike,
    displacements: ArrayLike,
    layer: InterfaceLayer | None,
    tolerance: float,
    force_of: Callable[[Array], Array],
) -> StartOfSliding:
    """As :func:`start_of_sliding`, with the force (2,) [N] of tractions (3, n) [Pa] by `force_of`."""
    p = np.asarray(pressure, dtype=float).ravel()
    n = compliance.points
    for name, values in (("pressure", p), ("area", a)):
        if values.shape != (n,) or not np.all(np.isfinite(values)) or np.any(values < 0.0):
            raise ValueError(f"{name} must hold {n} finite numbers of at least 0")
    mu = np.broadcast_to(np.asarray(friction, dtype=float), (n,))
    steps = pushes(displacements)
    check_room(n, 16)
    found = _mtb_rs.stick_or_slip_held(
        compliance,
        np.ascontiguousarray(p),
        np.ascontiguousarray(a),
        np.ascontiguousarray(mu),
        0.0 if layer is None else layer.flexibility,
        steps.tolist(),
        tolerance,
    )

    def history() -> StartOfSliding:
        traction, status, iterations, path_error = zip(*found, strict=True)
        done, touching = len(found), float(a[p > 0.0].sum())
        slips = [float(a[points == 2].sum()) for points in status]
        return StartOfSliding(
            displacement=steps[:done],
            force=np.array([force_of(np.concatenate([q, p[None]])) for q in traction]),
            normal_force=np.full(done, float(p @ a)),
            slip_share=np.array([slip / touching if touching > 0.0 else 0.0 for slip in slips]),
            traction=traction[-1],
            pressure=p,
            status=status[-1],
            iterations=np.array(iterations),
            path_error=np.array(path_error),
        )

    k = len(found)
    if k < len(steps):
        raise ConvergenceError(
            f"no state found for the displacement {steps[k].tolist()} m, step {k + 1}",
            history() if k else None,
        )
    return _told(history())


def _told(start: StartOfSliding) -> StartOfSliding:
    """With a warning if its steps are too long for the tolerance."""
    # sums: beyond a first one that is not known no step tells what it adds
    with np.errstate(invalid="ignore"):
        errors = np.diff(start.path_error, prepend=0.0)
    worst = int(np.argmax(errors > _mtb_rs.PATH_TOLERANCE))
    error = float(errors[worst])
    if error > _mtb_rs.PATH_TOLERANCE:
        size = f"{error:.2g} of the friction" if np.isfinite(error) else "not known"
        warn(
            f"The estimated error by the length of step {worst + 1} is {size}, where "
            f"{_mtb_rs.PATH_TOLERANCE:g} is asked for: more and shorter steps are needed.",
            ToleranceWarning,
        )
    return start


def pushes(displacements: ArrayLike) -> Array:
    """Checked displacements (m, 2) [m]."""
    steps = np.atleast_2d(reals("displacements", displacements, "m"))
    if steps.ndim != 2 or steps.shape[1] != 2:
        raise ValueError(f"displacements has shape {steps.shape}: (m, 2) finite numbers are needed")
    return steps


def start_with_pressure(
    problem: ContactProblem,
    friction: Array,
    displacements: ArrayLike,
    layer: InterfaceLayer | None,
    tolerance: float,
) -> StartOfSliding:
    """The same with a pressure that follows: friction presses the bodies together or lifts them.

    Tangential displacements count from the bodies pressed together without friction.

    Parameters
    ----------
    problem : ContactProblem
    friction : (n,) [-]
    displacements : (m, 2) [m]
    layer : InterfaceLayer or None
    tolerance : float [-]
        Residual over the norm of the pressure.

    Raises
    ------
    ConvergenceError
        Naming the step; with the steps before it as ``.result``.

    Warns
    -----
    ToleranceWarning
        If 256 parts of a step do not keep the error that it adds below 1e-3.
    """
    steps = pushes(displacements)
    states = problem.core.stick_or_slip(
        problem.loading,
        np.ascontiguousarray(np.broadcast_to(friction, (problem.n,))),
        0.0 if layer is None else layer.flexibility,
        np.repeat(np.pad(steps, ((0, 0), (0, 1)))[:, :, None], problem.n, axis=2),
        tolerance,
    )
    if states and states[-1].status != "solved":
        k = len(states) - 1
        raise ConvergenceError(
            f"no state found for the displacement {steps[k].tolist()} m, step {k + 1}, not even in small "
            "parts of it: the friction coefficient may be above the wedging limit, the body may tip over, or "
            "smaller displacements before this one may find a way to it",
            _history(steps[:k], states[:k], problem) if k else None,
        )
    return _told(_history(steps, states, problem))


def force_on(problem: ContactProblem, traction: Array) -> Array:
    """Force (2,) [N] on the lower body along x and y by tractions (3, n) [Pa] in the frames of the points."""
    return np.asarray(problem.geometry.loads(np.ascontiguousarray(traction)).sum(axis=1)[:2])


def _history(steps: Array, states: list[_mtb_rs.Outcome], problem: ContactProblem) -> StartOfSliding:
    area = problem.area
    contact = [float(area[state.points > 0].sum()) for state in states]
    return StartOfSliding(
        displacement=steps,
        force=np.array(
            [force_on(problem, np.concatenate([state.traction, state.pressure[None]])) for state in states]
        ),
        normal_force=np.array([float(state.pressure @ area) for state in states]),
        slip_share=np.array(
            [
                float(area[state.points == 2].sum()) / total if total > 0.0 else 0.0
                for state, total in zip(states, contact, strict=True)
            ]
        ),
        traction=states[-1].traction,
        pressure=states[-1].pressure,
        status=states[-1].points,
        iterations=np.array([state.iterations for state in states]),
        path_error=np.array([state.path_error for state in states]),
    )
