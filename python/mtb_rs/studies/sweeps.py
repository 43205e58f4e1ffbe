# SPDX-License-Identifier: MIT OR Apache-2.0
"""Many scenes at once: a grid of parameters, any executor, nothing lost."""

from __future__ import annotations

import os
import re
import signal
import time
from collections import deque
from collections.abc import Callable, Generator, Mapping, Sequence
from concurrent.futures import FIRST_COMPLETED, BrokenExecutor, Executor, Future, ProcessPoolExecutor, wait
from contextlib import closing
from dataclasses import fields, is_dataclass, replace
from multiprocessing import get_context, parent_process
from threading import Thread
from typing import Any, Literal, NamedTuple, SupportsFloat

import numpy as np
from numpy.typing import NDArray

from .._mtb_rs import __version__
from ..base.check import meant, shortened, warn
from ..base.errors import ConvergenceError, ToleranceWarning
from ..base.fingerprint import fingerprint
from ..base.progress import shown
from ..base.questions import ask, gathered
from ..base.units import MEASURED_UNITS, taking_quantities
from ..base.words import Model
from ..half_space.motions import Motion, Rolling, Shift
from ..half_space.tangential_result import TangentialResult
from ..results.result import Result
from ..results.sweep_table import SweepTable, check_column
from ..scenes import methods
from ..scenes.auto import TOLERANCE
from ..scenes.direct import choose
from ..scenes.methods import check_options
from ..scenes.moving import Moving
from ..scenes.scene import Scene
from .sweep_cases import Cases, cases_of
from .sweep_checkpoint import Checkpoint, Record
from .sweep_studies import arguments_of, studied_numbers, word_of

Array = NDArray[np.float64]
Values = Mapping[str, Any]
Measure = Callable[[Any], Mapping[str, float]]

#: Numbers in a message.
_NUMBER = re.compile(r"[-+]?\d[\d.]*(e[-+]?\d+)?")

#: Cases given to an executor whose number of workers is unknown, before the first one must come back.
IN_FLIGHT = 32


@taking_quantities
def sweep(
    scene: Scene,
    parameters: Mapping[str, Sequence[Any] | Mapping[str, Any]] | Sequence[Mapping[str, Any]],
    *,
    motion: Rolling | Shift | None = None,
    study: Callable[..., Any] | None = None,
    executor: Executor | int | None = None,
    measure: Measure | None = None,
    checkpoint: str | os.PathLike[str] | None = None,
    progress: Callable[[int, int], None] | Literal[True] | None = None,
    **options: Any,
) -> SweepTable:
    """Solves a scene for all combinations of some of its arguments, or for the cases of a list.

    Parameters
    ----------
    scene : Scene
    parameters : Mapping
        The values of each argument (of :class:`Scene`, or of the ready scene), or a mapping from labels to
        values: ``{"friction": [0.1, 0.3], "magnetic_pressure": {"even": 3e6, "left": [3e6, 1e6]}}``. Labels
        are numbers or text. Values without a label that are neither are labelled by their text, or by their
        kind and place in the list. Or a list of cases, each a mapping from arguments to its values, as a
        table of pandas has them in its rows; the scene's own value stands for an argument that a case leaves
        out. The parameter of the table is then the ``case``, known by its row's index or, in a list, by its
        number from 1; arguments that are numbers are columns.
        What an argument is given as, a :class:`Magnet` or a layer, may vary in its parts, under names like
        "magnetic_pressure.ampere_turns".
    motion : Rolling, Shift or None
        Rolling or shift of the upper body after each pressing, as of a case file, with the friction and the
        layer of the scene; the bodies are then half-spaces. Its own arguments may vary, under names like
        "rolling.velocity" and "shift.displacement". The columns of forces and iterations are those of the
        motion, and `measure` is given its :class:`TangentialResult`. Of a body that creeps
        (:class:`Viscoelastic`) "rolling_resistance" is a further column.
    study : functools.partial or None
        What is done to each scene in place of one solve: :func:`mtb_rs.wear`, :func:`mtb_rs.brake`,
        :meth:`Scene.sliding_heat` or :meth:`Scene.start_of_sliding` with their arguments, as in
        ``functools.partial(mtb.brake, speed=40.0, mass=4e3, wear=1e-15)``. These arguments may vary too,
        under names like "brake.speed". The columns are what its result has come to, its ``ends()``: ways,
        depths, energies, temperatures. `measure` is given that result.
        Of the options it takes `model`.
    executor : concurrent.futures.Executor, int or None
        Executor that solves the cases: threads, processes, or Dask's ``client.get_executor()``; a number of
        processes of our own; or None for this process alone. A process that dies is replaced and its cases
        are solved again; a case that ends its process twice is recorded as such. Processes are spawned,
        because the threads of the compiled core do not survive a fork; a pool that forks is replaced by one
        of the same size. A script must therefore call sweeps under ``if __name__ == "__main__":``.
    measure : callable
        Function that gives further numbers of a result by name, which become columns. With processes it must
        be a function of a module.
    checkpoint : path
        File that keeps the solved cases one by one. A sweep that is called again with the same file continues
        from it. Cases without a solution are not tried again, and cases that failed in another way are. The
        scene, values, options, measure and version of this package must be the same; functions are compared
        by their code and the values they hold, objects by their attributes.
    progress : callable or True
        Called with the cases done and all cases. True shows a bar, on the terminal or in a notebook (extra
        ``notebook``).
    **options
        Options of :meth:`Scene.solve`. ``model="auto"`` is decided once, on the first case, and leaves out
        no layer, hardness or magnet; cases with other bodies, which do not have this model, are decided one
        by one.

    Returns
    -------
    SweepTable
        A case without a solution is a row with its reason, and the other cases go on. One
        :class:`mtb_rs.ToleranceWarning` says how many cases miss the tolerance.

    Raises
    ------
    ValueError
        If an argument or option is unknown, the executor is not one, the checkpoint is damaged or of another
        sweep, or an input hides its content, so that a checkpoint could not distinguish it from another one.
    """
    if not isinstance(scene, Scene):
        raise ValueError(f"scene is {scene!r}: a Scene is needed")
    _check_executor(executor)
    for name, function in (("measure", measure), ("progress", None if progress is True else progress)):
        if function is not None and not callable(function):
            raise ValueError(f"{name} is {function!r}: a function is needed")
    check_options(**options)
    cases = cases_of(parameters, {f.name: getattr(scene, f.name) for f in fields(scene)} | dict(scene.inputs))
    if motion is not None and not isinstance(motion, Motion):
        raise ValueError(f"motion is {motion!r}: a Rolling or a Shift is needed, or None")
    of_motion = {f"{motion.word}.{f.name}" for f in fields(motion)} if motion is not None else set()
    if study is not None:
        if motion is not None:
            raise ValueError("motion and study are given: give one of the two")
        of_motion = arguments_of(study, options, cases.names)
    of_parts = parts_of(scene)
    known = _known(scene) | of_motion | of_parts
    own = known if scene.recipe is None else set(scene.recipe[1]) | of_motion | of_parts
    for name in cases.names:
        if name not in known:
            near = meant(name, known)
            hint = f"did you mean {near!r}?" if near else f"it has {', '.join(sorted(own))}"
            raise ValueError(f"{name!r} is no argument of the scene: {hint}")
    key = "" if checkpoint is None else _key(scene, cases, motion, study, options, measure)
    each = list(cases)
    with shown(progress, "solving") as told, Checkpoint(checkpoint, key, len(cases)) as kept:
        records = dict(kept.records)
        waiting = deque(k for k in range(len(each)) if k not in records)
        done = len(records)
        told(done, len(cases))
        work = _Work(scene, motion, study, options, measure)
        if waiting:
            work.prepare(each[0])
        with closing(_solved(work, each, waiting, executor)) as solved:
            for index, record in solved:
                kept.add(index, record)
                records[index] = record
                done += 1
                told(done, len(cases))
    missed = [records[k]["missed"] for k in sorted(records) if "missed" in records[k]]
    if missed:
        some = f"{len(missed)} of {len(cases)} cases miss the tolerance"
        warn(f"{some}. The first of them: {missed[0]}", ToleranceWarning)
    _ask_once([records[k].get("asked", []) for k in sorted(records)])
    models = {r["model"] for r in records.values() if "model" in r}
    return _table(cases, records, {"scene": scene.name, "model": ", ".join(sorted(models))})


class _Found(NamedTuple):
    """A case that was solved: what `measure` is given, the numbers that are kept, and what else is told."""

    result: Any
    numbers: dict[str, float]
    model: str
    missed: str | None


class _Work:
    """What is done to a case; goes to the workers."""

    def __init__(
        self,
        scene: Scene,
        motion: Rolling | Shift | None,
        study: Callable[..., Any] | None,
        options: Mapping[str, Any],
        measure: Measure | None,
    ) -> None:
        self.scene, self.motion, self.options, self.measure = scene, motion, dict(options), measure
        self.study = study
        self.model: Model | None = None

    def prepare(self, case: Values) -> None:
        """Decides on the model, and condenses the bodies once, so that workers find them in the cache.

        Errors are left to the cases.
        """
        model = self.options.get("model", "auto")
        tolerance, quantity = self.options.get("tolerance"), self.options.get("quantity", "pressure")
        # half-spaces of a motion need no preparation, and a study chooses its model itself
        if self.motion is not None or self.study is not None:
            return
        try:
            with gathered():  # the case itself asks again
                scene = stated(self.scene, case)
            if model == "auto" and self.options.get("method", "direct") == "direct":
                model = choose(scene, TOLERANCE if tolerance is None else tolerance, quantity).model
                self.model = model
            if model != "auto":
                scene.problem(model)
        except (ValueError, ConvergenceError):
            return

    def _chosen(self, scene: Scene) -> dict[str, str]:
        """The model decided on, for scenes that have it: other bodies may make others."""
        if self.model is None or not scene.has_model(self.model):
            return {}
        return {"model": self.model}

    def _posed(self, case: Values, word: str) -> tuple[Scene, dict[str, Any]]:
        """The scene of a case, and what it changes of a motion or study."""
        start = f"{word}."
        changes = {k.removeprefix(start): v for k, v in case.items() if k.startswith(start)}
        return stated(self.scene, {k: v for k, v in case.items() if not k.startswith(start)}), changes

    def _solved(self, case: Values) -> _Found:
        """What is found of a case."""
        if self.study is not None:
            scene, changes = self._posed(case, word_of(self.study))
            scene.ask_of_places()
            studied = self.study(scene, **self.options | changes)
            return _Found(studied, studied_numbers(studied), self.options.get("model", "auto"), None)
        if self.motion is not None:
            scene, changes = self._posed(case, self.motion.word)
            result, moved = Moving(scene, replace(self.motion, **changes)).solve(**self.options)
            return _Found(moved, measured_of(result, moved), result.model, result.report.missed)
        scene = stated(self.scene, case)
        scene.ask_of_places()
        result = methods.solve(scene, **self.options | self._chosen(scene))
        return _Found(result, measured(result), result.model, result.report.missed)

    def __call__(self, case: Values) -> Record:
        with gathered() as asked:
            record = self._record(case)
        return record | ({"asked": list(dict.fromkeys(asked))} if asked else {})

    def _record(self, case: Values) -> Record:
        clock = time.perf_counter()
        try:
            found = self._solved(case)
            # what is given need not be measured
            numbers = {k: v for k, v in found.numbers.items() if k not in case}
            numbers["time"] = time.perf_counter() - clock
            if self.measure is not None:
                numbers |= _further(self.measure(found.result), {"status", *case, *numbers})
            record = {"status": "solved", "model": found.model, "numbers": numbers}
            return record | ({"missed": found.missed} if found.missed else {})
        except ConvergenceError as error:
            return {"status": f"no solution: {error}"}
        except Exception as error:  # one case must not stop the others
            return {"status": f"{type(error).__name__}: {error}"}


def _ask_once(asked: Sequence[Sequence[str]]) -> None:
    """Warns of what cases were asked, once of those that differ in their numbers only."""
    kinds: dict[str, list[str]] = {}
    for questions in asked:
        for kind, question in {_NUMBER.sub("0", q): q for q in questions}.items():
            kinds.setdefault(kind, []).append(question)
    for alike in kinds.values():
        more = f" ({len(alike)} of {len(asked)} cases, with other numbers in each; these are the first's)"
        ask([alike[0] + (more if len(set(alike)) > 1 else "")])


def measured(result: Result) -> dict[str, float]:
    """The numbers of a result that every sweep keeps; absent ones are NaN."""
    report = result.report
    # of the quantity that was asked for
    error = result.error_estimate if report.aim is None else report.error_estimates.get(report.aim[0])
    optional = {"wedging_margin": report.wedging_margin, "error_estimate": error}
    return {
        **{f"force_{c}": float(v) for c, v in zip("xyz", result.force, strict=True)},
        **{f"moment_{c}": float(v) for c, v in zip("xyz", result.moment, strict=True)},
        "normal_force": result.normal_force,
        "peak_pressure": report.peak_pressure,
        "contact_area": report.contact_area,
        "approach": float(np.mean(result.approach)),
        **{k: float("nan") if v is None else v for k, v in optional.items()},
        "residual": report.residual,
        "iterations": float(report.iterations),
    }


def measured_of(pressed: Result, moved: TangentialResult) -> dict[str, float]:
    """The numbers of a motion that every sweep keeps, with those of its pressing that stay."""
    report = moved.report
    stays = ("normal_force", "peak_pressure", "contact_area", "approach", "error_estimate")
    name = moved.motion.rigid_word
    resistance = moved.rolling_resistance
    return {
        **({} if resistance is None else {"rolling_resistance": resistance}),
        **{f"force_{c}": float(v) for c, v in zip("xyz", moved.force, strict=True)},
        **{f"{name}_{c}": float(v) for c, v in zip(("x", "y", "spin"), moved.creepage, strict=True)},
        "spin_moment": moved.spin_moment,
        **{k: v for k, v in measured(pressed).items() if k in stays},
        "stick_area": float(report.force_balance["stick_area"]),
        "residual": report.residual,
        "iterations": float(report.iterations),
    }


def _further(given: Any, taken: set[str]) -> dict[str, float]:
    """What a measure returned, as further columns."""
    if not isinstance(given, Mapping):
        raise ValueError(f"measure returned {given!r}: a mapping from names to numbers is needed")
    for name, value in given.items():
        if check_column(name) in taken:
            raise ValueError(f"measure returned {name!r}: the sweep has such a column already")
        if np.ndim(value) != 0 or not isinstance(value, SupportsFloat):
            raise ValueError(f"measure returned {name} = {value!r}: a number is needed")
    return {name: float(value) for name, value in given.items()}


def _solved(
    work: _Work, cases: list[dict[str, Any]], waiting: deque[int], executor: Executor | int | None
) -> Generator[tuple[int, Record]]:
    """Records of the cases as they come back."""
    if executor is None:
        for index in waiting:
            yield index, work(cases[index])
        return
    # not more than have something to do: all are started at once
    pool, own = _pool(
        executor if isinstance(executor, Executor) else min(int(executor), max(len(waiting), 1))
    )
    workers: int = getattr(pool, "_max_workers", IN_FLIGHT)
    suspects: deque[int] = deque()
    flying: dict[Future[Record], int] = {}
    try:
        while waiting or suspects or flying:
            # a case that may have ended its process flies alone, so that the next time tells
            alone = bool(suspects)
            queue, room = (suspects, 1) if alone else (waiting, 2 * workers)
            broken = False
            while queue and len(flying) < room:
                index = queue.popleft()
                try:
                    flying[pool.submit(work, cases[index])] = index
                except BrokenExecutor:
                    queue.appendleft(index)
                    broken = True
                    break
            finished, _ = wait(flying, return_when=FIRST_COMPLETED) if flying else (set(), set())
            for future in finished:
                index = flying.pop(future)
                try:
                    yield index, future.result()
                except BrokenExecutor:
                    broken = True
                    if alone:
                        yield index, {"status": "lost: its process ended twice while solving it"}
                    else:
                        suspects.append(index)
                except Exception as error:  # what the executor itself reports, a cancelled case included
                    yield index, {"status": f"lost: {type(error).__name__}: {error}"}
            if broken:
                suspects.extend(flying.values())
                flying.clear()
                if not isinstance(pool, ProcessPoolExecutor):
                    raise RuntimeError("the executor broke down; what is solved is in the checkpoint")
                if own:
                    pool.shutdown(wait=False, cancel_futures=True)
                pool, own = _pool(workers)
    except BaseException:
        if own:
            # not after what they are at, which may take long
            _end_processes(pool)
        raise
    finally:
        for future in flying:
            future.cancel()
        if own:
            pool.shutdown(wait=True, cancel_futures=True)


def _pool(executor: Executor | int) -> tuple[Executor, bool]:
    """The executor to work with, and whether it is our own."""
    if isinstance(executor, ProcessPoolExecutor):
        context = getattr(executor, "_mp_context", None)
        if context is None or context.get_start_method() != "fork":
            return executor, False
        executor = int(getattr(executor, "_max_workers", 1))
    if isinstance(executor, Executor):
        return executor, False
    return ProcessPoolExecutor(int(executor), get_context("spawn"), _begin_worker), True


def _begin_worker() -> None:
    """In a worker of our own, before the compiled core starts its threads."""
    # processes share the machine already
    os.environ.setdefault("RAYON_NUM_THREADS", "1")
    # Ctrl-C goes to all processes of a terminal; the sweep ends its workers itself
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    Thread(target=_end_with_sweep, daemon=True).start()


def _end_with_sweep() -> None:
    """Ends this worker when the sweep's process is no more; it would wait for work for ever."""
    sweeping = parent_process()
    if sweeping is not None:
        sweeping.join()
        os._exit(1)


def _end_processes(pool: Executor) -> None:
    for process in list((getattr(pool, "_processes", None) or {}).values()):
        process.terminate()


def most_processes() -> int:
    """Processes that a sweep starts at most: further ones take memory and no work off the others."""
    return max(8, 4 * (os.cpu_count() or 1))


def _check_executor(executor: Any) -> None:
    if executor is None or isinstance(executor, Executor):
        return
    if isinstance(executor, bool) or not isinstance(executor, (int, np.integer)) or executor < 1:
        raise ValueError(
            f"executor is {executor!r}: a concurrent.futures.Executor, a number of processes from 1 on, "
            "or None is needed"
        )
    if executor > most_processes():
        raise ValueError(
            f"executor is {shortened(executor)}: at most {most_processes()} processes, four for each "
            "processor, are started; an Executor of your own may have more"
        )


def _key(
    scene: Scene,
    cases: Cases,
    motion: Rolling | Shift | None,
    study: Callable[..., Any] | None,
    options: Values,
    measure: Measure | None,
) -> str:
    """What a checkpoint is known by."""
    try:
        of_case = [scene, scene.inputs, cases.grid, cases.listed, motion, study]
        return fingerprint([__version__, *of_case, options, measure])
    except ValueError as error:
        raise ValueError(f"no checkpoint is possible: {error}") from error


def _table(cases: Cases, records: Mapping[int, Record], attributes: dict[str, str]) -> SweepTable:
    names: dict[str, None] = {}
    for record in records.values():
        names.update(dict.fromkeys(record.get("numbers", {})))
    columns = {name: np.full(cases.shape, np.nan) for name in names}
    status = np.full(cases.shape, "", dtype=object)
    for index, record in records.items():
        at = np.unravel_index(index, cases.shape)
        # any text may be in a message; not all of it can be written
        status[at] = record["status"].encode("utf-8", "backslashreplace").decode().replace("\0", "\\0")
        for name, value in record.get("numbers", {}).items():
            columns[name][at] = value
    columns = _with_given(cases.columns(), columns)
    parameters = {name: tuple(values) for name, values in cases.grid.items()}
    units = {name: MEASURED_UNITS[name] for name in columns if name in MEASURED_UNITS}
    return SweepTable(parameters, columns, status.astype(str), attributes, {**cases.units(), **units})


def _with_given(given: dict[str, Array], found: dict[str, Array]) -> dict[str, Array]:
    """Columns of arguments first; what was measured stands where an argument has no value."""
    first = {k: np.where(np.isnan(values), found.get(k, np.nan), values) for k, values in given.items()}
    return {**first, **{name: values for name, values in found.items() if name not in first}}


def parts_of(scene: Scene) -> set[str]:
    """Parts of magnets and layers that arguments are, by names like "magnetic_pressure.iron_share"."""
    given = {name: getattr(scene, name) for name in ("magnetic_pressure", "layer")}
    return {
        f"{name}.{entry.name}"
        for name, value in given.items()
        if is_dataclass(value) and not isinstance(value, type)
        for entry in fields(value)
    }


def stated(scene: Scene, case: Values) -> Scene:
    """The scene with other arguments, and other parts of what its arguments are given as."""
    whole = {name: value for name, value in case.items() if "." not in name}
    changed = scene.with_(**whole) if whole else scene
    parts: dict[str, dict[str, Any]] = {}
    for name, value in case.items():
        argument, dot, part = name.partition(".")
        if dot:
            parts.setdefault(argument, {})[part] = value
    for argument, of in parts.items():
        before = getattr(changed, argument)
        for part in of.keys() - {entry.name for entry in fields(before)}:
            raise ValueError(f"{argument} is {before!r}: it has no {part}")
        changed = changed.with_(**{argument: replace(before, **of)})
    return changed


def _known(scene: Scene) -> set[str]:
    """Arguments that may be varied."""
    known = {f.name for f in fields(Scene)} - {"geometry", "inputs", "name", "recipe"}
    return known if scene.recipe is None else known | set(scene.recipe[1])
