# SPDX-License-Identifier: MIT OR Apache-2.0
"""Studies of scenes whose ends a sweep keeps: wear, heat, stops, starts of sliding, steps of wheels."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Collection, Mapping
from functools import partial
from typing import Any

from ..base.check import meant
from ..results.result import Curved
from ..results.wheel_result import WheelStep

#: Arguments of a study that are no numbers of a case.
_OWN = {"progress", "checkpoint", "model"}


def word_of(study: Callable[..., Any]) -> str:
    """By what the arguments of a study begin: the name of its function."""
    return str((study.func if isinstance(study, partial) else study).__name__)


def arguments_of(study: Any, options: Mapping[str, Any], varied: Collection[str]) -> set[str]:
    """Arguments of a study that may vary, by names like "brake.speed"; `varied` are those that do.

    Raises
    ------
    ValueError
        If it is no function with a name, has arguments that no case can share, or `options` are given beside
        it that it does not take.
    """
    function = study.func if isinstance(study, partial) else study
    if not inspect.isroutine(function):
        raise ValueError(
            f"study is {study!r}: a function of a scene such as functools.partial(mtb_rs.brake, speed=40.0, "
            "mass=4e3) is needed"
        )
    if isinstance(study, partial):
        if study.args:
            raise ValueError(
                f"study has {study.args!r} without a name: name its arguments, the first is the scene"
            )
        for name in {"progress", "checkpoint"} & study.keywords.keys():
            raise ValueError(f"study has {name}: give it to the sweep, for all cases")
    if others := sorted(set(options) - {"model"}):
        raise ValueError(f"{others[0]} is given beside a study: of the options it takes only model")
    signature = inspect.signature(function)
    known = signature.parameters
    keywords = study.keywords if isinstance(study, partial) else {}
    if not any(p.kind is p.VAR_KEYWORD for p in known.values()):
        for name in keywords.keys() - known.keys():
            near = meant(name, known)
            hint = f"did you mean {near!r}?" if near else f"it has {', '.join(list(known)[1:])}"
            raise ValueError(f"study has {name!r}, which is no argument of {function.__name__}: {hint}")
    start = f"{function.__name__}."
    own = {name.removeprefix(start) for name in varied if name.startswith(start)}
    try:
        signature.bind(None, **{**keywords, **dict.fromkeys(own & known.keys())})
    except TypeError as error:
        raise ValueError(f"study cannot call {function.__name__}: {error}") from None
    named = [p.name for p in list(known.values())[1:] if p.kind not in (p.VAR_KEYWORD, p.VAR_POSITIONAL)]
    given = [*named, *keywords]
    return {f"{function.__name__}.{name}" for name in given if name not in _OWN}


def studied_numbers(found: Any) -> dict[str, float]:
    """The numbers of a study that every sweep keeps: what it has come to at its end.

    Raises
    ------
    ValueError
        If it is nothing whose numbers are known.
    """
    if not isinstance(found, (Curved, WheelStep)):
        raise ValueError(
            f"study returned {type(found).__name__}: a WearResult, a Braking, a SlidingHeat, a "
            "StartOfSliding or a WheelStep is needed, as of mtb_rs.wear, mtb_rs.brake, Scene.sliding_heat, "
            "Scene.start_of_sliding and mtb_rs.step_wheels"
        )
    return {name: float(value) for name, value in found.ends().items()}
