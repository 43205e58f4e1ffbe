# SPDX-License-Identifier: MIT OR Apache-2.0
"""Ways to solve a posed scene: directly, by the thesis' methods, and from rest."""

from __future__ import annotations

import inspect
from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..base.check import choice, positive, shortened, warn
from ..base.errors import ConvergenceError
from ..base.words import Method, Model, Pressing, Quantity
from ..bodies.simple import are_layered
from ..contact.incremental import IncrementalOptions, finish_incremental, solve_incremental
from ..contact.problem import along_surface, mean_tractions
from ..contact.sliding_start import (
    StartOfSliding,
    check_room,
    force_on,
    start_with_held_pressure,
    start_with_pressure,
)
from ..contact.solve import JAMMED, failure, solve_direct
from ..contact.staggered import staggered, with_half_space
from ..contact.standing import hats_of
from ..friction.fields import as_form
from ..results.result import Result
from . import direct
from .posed import PosedScene
from .taken import refuse_beyond

Array = NDArray[np.float64]


def solve(
    scene: PosedScene,
    model: Model = "auto",
    method: Method = "direct",
    tolerance: float | None = None,
    quantity: Quantity = "pressure",
    **options: Any,
) -> Result:
    """As :meth:`mtb_rs.Scene.solve`, for callers that have their own words for a missed tolerance."""
    check_options(model=model, method=method, tolerance=tolerance, quantity=quantity, **options)
    model = model_of(scene, model, method)
    if method == "direct":
        return direct.solve(scene, model, tolerance, quantity)
    if method == "incremental":
        return _incremental(scene, model, options)
    return _staggered(scene, model, options)


def model_of(scene: PosedScene, model: Model, method: Method) -> Model:
    """The model in which a method solves a scene; "auto" where it is chosen while solving.

    Raises
    ------
    ValueError
        If the scene has no such model, or the method does not take the scene.
    """
    if method == "direct":
        scene.check_model(model)
        return model
    if scene.own_model is not None:
        raise ValueError(
            f'method is {method!r}: a scene with an ElasticBody takes "direct"; the methods of the '
            "thesis are for the ready scenes and half-spaces"
        )
    if model == "auto":
        model = "half-space" if method == "incremental" else "elastic-upper"
    scene.check_model(model)
    if method == "staggered" and model != "elastic-upper":
        raise ValueError(f"method is 'staggered': it needs model='elastic-upper', not {model!r}")
    refuse_beyond(scene, "load increments" if method == "incremental" else "the staggered loop")
    if as_form(scene.magnetic_pressure).follows_gap:
        raise ValueError(
            f'method is {method!r}: the pull of a Magnet follows the gap, which takes "direct"; the '
            "methods of the thesis take a magnetic_pressure as a number, a field or a table"
        )
    return model


def slide_from_rest(
    scene: PosedScene,
    displacements: ArrayLike,
    model: Model = "auto",
    tolerance: float = 1e-8,
    pressure: Pressing = "follows",
) -> StartOfSliding:
    """See :meth:`mtb_rs.Scene.start_of_sliding`."""
    choice("model", model, Model)
    choice("pressure", pressure, Pressing)
    scene.check_model(model)
    if model == "auto":
        # a body of elements would be made of the layer's material alone
        is_meshed = "elastic-upper" in scene.geometry.models and not are_layered(*scene.simple)
        model = "elastic-upper" if is_meshed else "half-space"
    if scene.layer is not None and scene.layer.plasticity is not None:
        raise ValueError(
            f"layer is {shortened(scene.layer)}: a start of sliding takes an InterfaceLayer; a Shift takes a "
            "PlasticLayer"
        )
    if pressure == "follows":
        for name in ("hardness", "normal_layer"):
            if getattr(scene, name) is not None and (name == "hardness" or scene.rough is not None):
                raise ValueError(
                    f"{name} is {shortened(getattr(scene, name))}: a start of sliding in which the pressure "
                    'follows cannot take it; pressure="held" takes it'
                )
    problem = scene.problem(model, may_halve=False)
    check_room(problem.n)
    problem = replace(problem, direction=np.zeros((2, problem.n)))
    solution = solve_direct(problem, with_margin=False)
    if solution.status != "solved":
        raise failure(problem, solution)
    # the pull is held while the bodies are displaced along the surface
    problem = problem.settled(solution)
    scene.check_touching(bool((solution.pressure > 0.0).any()), problem.points, problem.loads)
    scene.check_edge(problem.patches, solution.pressure)
    friction = scene.friction_from_rest(problem, solution.pressure)
    if pressure == "follows":
        start = start_with_pressure(problem, friction, displacements, scene.layer, tolerance)
        scene.check_edge(problem.patches, start.pressure)
        pressed = float(solution.pressure @ problem.area)
        if start.normal_force[-1] > JAMMED * pressed:
            warn(
                f"The body jams: its displacement has raised the contact force from {pressed:.3g} N to "
                f"{start.normal_force[-1]:.3g} N. The friction coefficient is about or above the wedging "
                "limit."
            )
    else:
        start = start_with_held_pressure(
            problem.core.pair,
            solution.pressure,
            problem.area,
            friction,
            displacements,
            scene.layer,
            tolerance,
            lambda traction: force_on(problem, traction),
        )
    mean = mean_tractions(problem, np.concatenate([start.traction, start.pressure[None]]))
    nodes = problem.points if problem.kept is None else problem.kept.nodes
    lower, upper, elastic = scene.bodies_of(problem)
    return replace(
        start,
        lower=lower,
        upper=upper,
        elastic=elastic,
        traction=problem.on_grid(along_surface(problem, mean[:2])),
        pressure=problem.on_grid(mean[2]),
        status=problem.on_grid(start.status),
        points=nodes.points,
        area=problem.on_grid(problem.area),
        patches=problem.patches,
        summary={**scene.statement(), "pressure": pressure, "model": model},
    )


def _incremental(scene: PosedScene, model: Model, options: dict[str, Any]) -> Result:
    chosen = IncrementalOptions(**options)
    problem = scene.problem(model)
    solution, accumulated = solve_incremental(problem, scene.sliding_direction, chosen)
    return finish_incremental(accumulated, lambda: scene.finished(problem, solution, "incremental"))


def _staggered(scene: PosedScene, model: Model, options: dict[str, Any]) -> Result:
    problem = scene.problem(model)
    body, _ = scene.simple
    twin = hats_of(body, problem.points, problem.patches, upper=True).side(np.zeros(problem.n), np.zeros(6))
    solution, _ = staggered(problem, twin, **options)
    try:
        result = scene.finished(problem, solution, "staggered")
    except ConvergenceError as error:
        raise type(error)(str(error), with_half_space(error.result, twin, problem.points)) from None
    return with_half_space(result, twin, problem.points)


@cache
def solve_defaults() -> dict[str, Any]:
    """What :meth:`Scene.solve` is asked where nothing is said, in the order of its arguments."""
    arguments = inspect.signature(solve).parameters.values()
    return {a.name: a.default for a in arguments if a.default is not a.empty}


def check_options(**given: Any) -> None:
    """What can be said of the options of :meth:`Scene.solve` without a scene.

    Raises
    ------
    ValueError
        Naming the option that no scene takes.
    """
    options = solve_defaults() | given
    model, method, tolerance, quantity = (options.pop(name) for name in solve_defaults())
    choice("model", model, Model)
    choice("method", method, Method)
    choice("quantity", quantity, Quantity)
    if tolerance is not None and positive("tolerance", tolerance) >= 1.0:
        raise ValueError(f"tolerance is {tolerance!r}: a number between 0 and 1 is needed")
    known = method_options(method)
    for name in options:
        if name not in known:
            has = f": it has {', '.join(known)}" if known else ", which has no options of its own"
            raise ValueError(f"unknown option {name!r} of the {method} method{has}")


#: What has the options of each method as arguments.
OPTIONS: dict[Method, Any] = {"incremental": IncrementalOptions, "staggered": staggered}


def method_options(method: Method) -> list[str]:
    """Options that a method has beside those of all."""
    if method not in OPTIONS:
        return []
    given = inspect.signature(OPTIONS[method]).parameters.values()
    return [p.name for p in given if p.kind is p.KEYWORD_ONLY or p.default is not p.empty]
