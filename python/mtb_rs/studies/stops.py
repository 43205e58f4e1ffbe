# SPDX-License-Identifier: MIT OR Apache-2.0
"""Wear over many stops: some are computed, and the shape of the soles is carried over those between them."""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from .. import _mtb_rs
from ..base.check import whole
from ..base.errors import ConvergenceError
from ..base.progress import shares_shown
from ..base.stored import input_data, without_functions
from ..base.units import taking_quantities
from ..base.words import Model
from ..contact.problem import mean_tractions, sliding_tractions
from ..friction.wear_laws import check_worn
from ..results.plausible import height_of
from ..results.wear_result import WearResult
from ..scenes.heating import HeatedScene, check_tolerance
from ..scenes.scene import Scene
from .brake import Ride, Step, posed_shoe
from .sweep_checkpoint import Record, StepCheckpoint
from .wear import place_of, worn_contact

Array = NDArray[np.float64]

#: Error of the steps of an extrapolation, in parts of what the extrapolation may have.
INSIDE = 0.1


@taking_quantities
def wear_of_stops(
    scene: Scene,
    speed: float,
    mass: float,
    count: int,
    other_force: float | Callable[[float], float] = 0.0,
    *,
    shares: Sequence[float] = (1.0,),
    tolerance: float = 0.05,
    stop_tolerance: float = 0.1,
    model: Model = "auto",
    checkpoint: str | os.PathLike[str] | None = None,
    progress: Callable[[float], Any] | Literal[True] | None = None,
    **heat: Any,
) -> tuple[WearResult, ...]:
    """Wears the shoes of a vehicle over many equal stops.

    Some stops are computed in full, as :func:`mtb_rs.brake` does, each from cold shoes that are worn by all
    stops before it. Between two of them the soles wear by the contact that has the mean pressure of the last
    stop, in implicit steps, so that any number of stops is stable. The next stop tells how far the rate of
    wear is off by then; the number of stops between follows from that.

    Parameters
    ----------
    scene, speed, mass, other_force, shares, model
        As of :func:`mtb_rs.brake`. The pull of a ``Magnet`` follows the gap in each stop that is computed;
        between them it is that of the last one.
    count : int
        Number of stops.
    tolerance : float [-]
        Error of the depths by what is not computed in full, relative (root mean square over the area).
    stop_tolerance : float [-]
        Of the steps of each stop, the `tolerance` of :func:`mtb_rs.brake`.
    checkpoint : path
        File that keeps the stops which were computed. The same wear that is called again with it goes on
        where it was stopped.
    progress : callable or True
        Called with the share of the stops. True shows a bar (extra ``notebook``).
    **heat
        As of :func:`mtb_rs.brake`; `wear`, the law of the soles, is needed. The rail is met at another place
        in each stop, so that `lower_wear` is refused: wear a rail by :class:`Passages`.

    Returns
    -------
    tuple of WearResult
        One for each shoe. Each of their steps ends with a stop that was computed: `steps` is its way with
        those before it that were not, `errors` that of the latter, `solves` the number of stops computed for
        it, `pressures` and `unknowns` the means over the way.

    Raises
    ------
    ValueError
        For bad input, and where a shoe is worn through.
    ConvergenceError
        As :func:`mtb_rs.brake`.
    """
    check_tolerance("tolerance", tolerance)
    check_tolerance("stop_tolerance", stop_tolerance)
    posed, stated, pulls = posed_shoe(
        scene, speed, mass, shares=shares, tolerance=stop_tolerance, model=model, **heat
    )
    whole("count", count)
    if stated[1].wear is None:
        raise ValueError("wear is None: a law of wear of the soles is needed")
    if stated[1].lower_wear is not None:
        raise ValueError(
            "lower_wear is given: each stop meets the rail at another place; mtb.wear with Passages wears "
            "a rail"
        )
    shoe = HeatedScene.of(posed, *stated)
    shoe.check_speed("speed", speed)

    def stopped(worn: list[Array]) -> _Stopped:
        nothing = StepCheckpoint(None, [], "stop", "")
        stop = _Stop(shoe, float(speed), float(mass), other_force, pulls, stop_tolerance, nothing, worn)
        stop.run(lambda _: None)
        return stop.stopped()

    said = {
        **{"speed": speed, "mass": mass, "count": count, "other_force": without_functions(other_force)},
        **{"shares": pulls.tolist(), "tolerance": tolerance, "stop_tolerance": stop_tolerance},
    }
    given = [posed, posed.inputs, *stated[:2], float(speed), float(mass), int(count), other_force, pulls]
    with (
        shares_shown(progress, "stops") as told,
        StepCheckpoint(
            checkpoint,
            [*given, float(tolerance), float(stop_tolerance)],
            "wear of stops",
            "scene, vehicle, count, shares, heat, wear, model, tolerances",
        ) as kept,
    ):
        duty = _Duty(shoe, np.unique(pulls), stopped, tolerance, count, kept)
        duty.run(told)
    results = [duty.result(k, said) for k in range(duty.shares.size)]
    return tuple(results[k] for k in np.unique(pulls, return_inverse=True)[1])


class _Stop(Ride):
    """A stop that keeps sums over its way of pressure (n,) and of friction times pressure, for each share."""

    def __init__(self, *given: Any) -> None:
        self.sums: dict[int, Array] = {}
        super().__init__(*given)

    def _take(self, step: Step) -> None:
        super()._take(step)
        for k, trial in enumerate(step.trials):
            both = trial.way * np.stack([trial.pressure, trial.friction * trial.pressure])
            self.sums[k] = both + self.sums.get(k, 0.0)

    def stopped(self) -> _Stopped:
        """What is left of it."""
        sums = [self.sums[k] for k in range(self.shares.size)]
        return _Stopped(self.way[-1], sums, [sliding.worn for sliding in self.sliding])


@dataclass(frozen=True)
class _Stopped:
    """A stop that was computed: its way [m], and for each share the sums (2, n) over the way, and the depths
    (n,) [m] worn off in it."""

    way: float
    sums: list[Array]
    depths: list[Array]


@dataclass(frozen=True)
class _Row:
    """Stops that were left out, and the one after them.

    `ahead` is the number of those left out, `next` that which may be left out after them; `carried` are for
    each share what they wear off, the wear of one more stop at their end (n,) [m], and the sum of their
    pressures [Pa]; `tried` counts the stops that were computed for it.
    """

    ahead: int
    tried: int
    next: float
    errors: list[float]
    carried: list[Array]
    after: _Stopped

    def kept(self) -> dict[str, Any]:
        """What :meth:`recalled` makes it of again."""
        numbers = [self.ahead, self.tried, self.next, self.after.way]
        fields = {"carried": self.carried, "sums": self.after.sums, "depths": self.after.depths}
        return {
            **{"status": "solved", "numbers": numbers, "errors": self.errors},
            **{
                f"{name}.{k}": field.ravel().tolist()
                for name, of in fields.items()
                for k, field in enumerate(of)
            },
        }

    @classmethod
    def recalled(cls, record: Record, n: int) -> _Row:
        """A row of the checkpoint, of fields over n points."""
        ahead, tried, following, way = record["numbers"]
        errors = record["errors"]

        def fields(name: str, rows: int) -> list[Array]:
            return [np.array(record[f"{name}.{k}"]).reshape(rows, n) for k in range(len(errors))]

        depths = [depth[0] for depth in fields("depths", 1)]
        after = _Stopped(way, fields("sums", 2), depths)
        return cls(ahead, tried, following, errors, fields("carried", 3), after)


class _Duty:
    """Many stops on their way; lists have an entry for each different share of the pull."""

    def __init__(
        self,
        shoe: HeatedScene,
        shares: Array,
        stopped: Callable[[list[Array]], _Stopped],
        tolerance: float,
        count: int,
        kept: StepCheckpoint,
    ) -> None:
        self.shoe, self.shares, self.stopped, self.tolerance, self.count, self.kept = (
            shoe, shares, stopped, tolerance, count, kept,
        )  # fmt: skip
        n = shoe.problem.n
        self.pulled = [shoe.of_shoe(float(share)) for share in shares]
        self.worn = [np.zeros(n) for _ in shares]
        self.distance = 0.0
        self.rows: list[list[dict[str, Any]]] = [[] for _ in shares]

    def run(self, told: Callable[[float], Any]) -> None:
        """All stops, one after the other or some of them."""
        n = self.shoe.problem.n
        nothing = {"distance": 0.0, "step": 0.0, "error": 0.0, "solves": 0, "upper": np.zeros(n)}
        for rows, own in zip(self.rows, self.pulled, strict=True):
            first = own.first
            rows.append({**nothing, "unknowns": self._tractions(first.pressure, first.friction)})
        last, done, following = None, 0, 1.0
        for record in self.kept.in_order():
            row = _Row.recalled(record, n)
            self._add(last, row)
            last, done, following = row.after, done + row.ahead + 1, row.next
        control = _mtb_rs.StepControl(self.tolerance, following)
        told(done / self.count)
        while done < self.count:
            row, control = self._row(last, control, self.count - done)
            self.kept.add(len(self.rows[0]) - 1, row.kept())
            self._add(last, row)
            last, done = row.after, done + row.ahead + 1
            told(done / self.count)

    def _row(
        self, last: _Stopped | None, control: _mtb_rs.StepControl, left: int
    ) -> tuple[_Row, _mtb_rs.StepControl]:
        """The next row after a stop, of as many as are left; None: the first stop."""
        if last is None:
            nothing = [np.zeros((3, self.shoe.problem.n)) for _ in self.shares]
            after = self.stopped(self.worn)
            return _Row(0, 1, 1.0, [0.0] * self.shares.size, nothing, after), control
        # a stop that is computed ends the row
        most = float(left - 1)
        ahead, tried = math.floor(control.length(most)) if most else 0, 1
        while True:
            carried = [self._carried(last, k, ahead) for k in range(self.shares.size)]
            after = self.stopped([w + found[0] for w, found in zip(self.worn, carried, strict=True)])
            errors = [self._error(after, k, ahead, carried[k]) for k in range(self.shares.size)]
            # one that leaves none out tells how well it would have been foretold
            length = float(max(ahead, 1))
            shorter = control.judge(length, max(most, 1.0), max(errors))
            if shorter is None or not ahead:
                break
            ahead, tried = math.floor(shorter), tried + 1
        if shorter is not None:
            control = _mtb_rs.StepControl(self.tolerance, 1.0)
        following = 1.0 if control.next is None else control.next
        errors = errors if ahead else [0.0] * len(errors)
        return _Row(ahead, tried, following, errors, carried, after), control

    def _tractions(self, pressure: Array, friction: Array) -> Array:
        return sliding_tractions(pressure, friction, self.shoe.problem.direction)

    def _mean(self, stop: _Stopped, k: int) -> tuple[Array, Array, Array]:
        """Mean pressure of a stop, friction of the mean drag, and depth of wear [m] over the pressure."""
        pressure, drag = stop.sums[k] / stop.way
        over = np.where(pressure > 0.0, pressure, 1.0)
        return pressure, drag / over, stop.depths[k] / over

    def _carried(self, stop: _Stopped, k: int, ahead: int) -> Array:
        """(3, n): what stops ahead wear off [m] by the contact that has the mean pressure of a stop; the wear
        of one more stop [m] at their end, and the sum of their pressures [Pa]."""
        problem, n = self.shoe.problem, self.shoe.problem.n
        pressure, friction, rate = self._mean(stop, k)
        if not ahead:
            return np.array([np.zeros(n), rate * pressure, np.zeros(n)])
        tractions = self._tractions(pressure, friction)
        core, none = problem.core, np.zeros(n)
        tangent = core.tangent(
            pressure, friction, none, problem.direction, bool(friction.any()), core.is_by_products
        )
        # the contact that this pressure closes, under the loads that it balances
        gap = -tangent.opening() - self.worn[k]
        work = -np.einsum("cn,mcn->m", tractions * problem.area, problem.relative_motions)
        last: list[_mtb_rs.WearStep] = []
        total = np.zeros(n)

        def told(step: _mtb_rs.WearStep) -> bool:
            if step.outcome.status != "solved":
                raise ConvergenceError(f"between stops there is no state of contact: {step.outcome.status}")
            last[:] = [step]
            total[:] += step.length * step.outcome.pressure
            return False

        _mtb_rs.wear_problem(
            core, core.loading(gap, work), np.ascontiguousarray(problem.direction), friction,
            lambda *_: (rate, none), None, INSIDE * self.tolerance, (0.0, self.worn[k], none, None),
            float(ahead), told,
        )  # fmt: skip
        self._check(last[0].upper, self.distance + ahead * stop.way)
        return np.array([last[0].upper - self.worn[k], rate * last[0].outcome.pressure, total])

    def _check(self, worn: Array, distance: float) -> None:
        """ValueError where a shoe is worn through."""
        height = height_of(self.shoe.problem.upper.state)
        law = self.shoe.heated.wear
        assert height is not None
        assert law is not None
        check_worn(law, worn, height, "the height of the upper body", distance)

    def _error(self, after: _Stopped, k: int, ahead: int, carried: Array) -> float:
        """Half of the stops left out times what the rate of wear is off at their end, relative."""
        depth, rate, _ = carried
        area = np.ascontiguousarray(self.shoe.problem.area)

        def size(field: Array) -> float:
            return float(np.sqrt(area @ field**2))

        length = max(ahead, 1)
        step = depth if ahead else after.depths[k]
        off = 0.5 * length * size(after.depths[k] - rate)
        worn = size(step) + 0.1 * size(self.worn[k] + step)
        # where a law wears nothing, nothing is off
        return off / worn if worn > 0.0 else 0.0

    def _add(self, last: _Stopped | None, row: _Row) -> None:
        """Goes on from the end of a row, after another stop."""
        after = row.after
        before = (0.0 if last is None else last.way) * row.ahead
        step = before + after.way
        self.distance += step
        for k, rows in enumerate(self.rows):
            depth, _, pressures = row.carried[k]
            self.worn[k] = self.worn[k] + depth + after.depths[k]
            self._check(self.worn[k], self.distance)
            pressure, friction, _ = self._mean(after, k)
            sums = after.way * pressure + (0.0 if last is None else last.way * pressures)
            rows.append(
                {
                    **{"distance": self.distance, "step": step, "error": row.errors[k], "solves": row.tried},
                    **{"upper": self.worn[k], "unknowns": self._tractions(sums / step, friction)},
                }
            )

    def result(self, k: int, said: dict[str, Any]) -> WearResult:
        """The wear of a shoe."""
        shoe, problem, rows = self.shoe, self.pulled[k].problem, self.rows[k]
        scene = shoe.scene
        assert isinstance(scene, Scene)
        place = place_of(scene, problem)
        depths = problem.on_grid(np.array([row["upper"] for row in rows]))
        unknowns = [row["unknowns"] for row in rows]
        last = {"upper": rows[-1]["upper"], "lower": np.zeros(problem.n)}

        def column(name: str) -> Array:
            return np.array([row[name] for row in rows])

        return WearResult(
            distance=column("distance"),
            depths=np.stack([depths, np.zeros_like(depths)]),
            pressures=problem.on_grid(np.array([mean_tractions(problem, each)[2] for each in unknowns])),
            unknowns=problem.on_grid(np.array([each[2] for each in unknowns])),
            forces=np.array([problem.geometry.loads(each).sum(axis=1) for each in unknowns]),
            steps=column("step"),
            errors=column("error"),
            solves=column("solves").astype(np.int64),
            points=place.points,
            normal=place.normal,
            area=place.area,
            initial_gap=place.gap,
            patches=place.patches,
            rail=place.rail,
            final=worn_contact(scene, problem, last),
            summary=input_data(
                {**scene.statement(), **said, "heat": shoe.said, "share_of_pull": float(self.shares[k])}
            ),
        )
