# SPDX-License-Identifier: MIT OR Apache-2.0
"""Whatever solvers return, no result holds a number that is NaN or infinite."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from functools import cache
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

import mtb_rs as mtb
from mtb_rs.contact import solve
from mtb_rs.half_space import normal
from mtb_rs.scenes import direct

LINE = np.linspace(-1.0, 1.0, 9)
BOWL = 1e-5 * np.add.outer(LINE**2, LINE**2)
WORDS = r"the solution has lost its numbers: .* is NaN or infinite. The input may be"
STEEL = {"lower": mtb.steel, "upper": mtb.steel}


def pressed() -> mtb.NormalResult:
    return mtb.solve_normal(BOWL, 1e-4, force=50.0, **STEEL)


def block() -> mtb.Scene:
    return mtb.scenes.block_on_plane(spacing=0.025, friction=0.1)


def rolled() -> mtb.TangentialResult:
    return mtb.solve_tangential(pressed(), mtb.Rolling((1e-3, 0.0, 0.0)), mtb.Coulomb(0.3))


def wheels() -> mtb.WheelStep:
    return mtb.scenes.wheel_on_rail(spacing=1e-3, lateral=0.0).prepare().step(velocity=20.0)


MADE: dict[str, Callable[[], Any]] = {
    "NormalResult": pressed,
    "Report": lambda: pressed().report,
    "TangentialResult": rolled,
    "SlidingHeat": lambda: block().sliding_heat(1.0, 1, 1.0),
    "Braking": lambda: mtb.brake(block(), 0.2, 1e4),
    "RollingTemperature": lambda: rolled().temperature(),
    "FoundationResult": lambda: mtb.fastsim(pressed(), creepage=(1e-3, 0.0, 0.0), friction=mtb.Coulomb(0.3)),
    "Hertz": lambda: mtb.hertz(50.0, 1.0),
    "Result": lambda: block().solve("half-space"),
    "BodyState": lambda: block().solve("elastic-upper").states().popitem()[1],
    "StartOfSliding": lambda: block().start_of_sliding([[1e-7, 0.0]], model="half-space"),
    "StepResult": lambda: block().prepare("half-space").step(velocity=(1.0, 0.0)),
    "StepReport": lambda: block().prepare("half-space").step(velocity=(1.0, 0.0)).report,
    "WheelStep": wheels,
    "WheelPatch": lambda: wheels().patches[0],
}


@cache
def made(name: str) -> Any:
    return MADE[name]()


@pytest.mark.parametrize("name", MADE)
@pytest.mark.parametrize("lost", [np.nan, np.inf])
def test_no_result_is_made_with_numbers_that_are_lost(name: str, lost: float) -> None:
    result = made(name)
    assert type(result).__name__ == name
    unbounded = getattr(type(result), "_unbounded", ())
    held = 0
    for entry in dataclasses.fields(result):
        value = getattr(result, entry.name)
        bad: Any = None
        if isinstance(value, np.ndarray) and value.dtype.kind == "f" and value.size:
            bad = value.copy()
            bad.flat[-1] = lost
        elif isinstance(value, float):
            bad = lost
        if bad is None or not entry.init or entry.name in unbounded:
            continue
        held += 1
        with pytest.raises(mtb.ConvergenceError, match=f"lost its numbers: {entry.name} of the {name}"):
            dataclasses.replace(result, **{entry.name: bad})
    assert held


def lost(found: Any) -> Any:
    """A failed solve of the core with a NaN in its state."""
    return dataclasses.replace(found, pressure=np.full_like(found.pressure, np.nan), status="stagnated")


@pytest.mark.parametrize("status", ["not converged", "no solution", "unreachable", "solved"])
def test_a_scene_that_fails_with_nan_fails_in_words(status: str, monkeypatch: pytest.MonkeyPatch) -> None:
    found = solve.solve_direct

    def failing(*args: Any, **options: Any) -> solve.Solution:  # type: ignore[name-defined]
        solution = found(*args, **options)
        return dataclasses.replace(
            solution, pressure=np.full_like(solution.pressure, np.nan), status=status, wedging_margin=None
        )

    monkeypatch.setattr(direct, "solve_direct", failing)
    with pytest.raises(mtb.ConvergenceError, match=WORDS):
        block().solve("half-space")


def test_a_normal_contact_that_fails_with_nan_fails_in_words(monkeypatch: pytest.MonkeyPatch) -> None:
    found = normal._Problem.solve

    def losing(*args: Any) -> Any:
        out = found(*args)
        known = {name: getattr(out, name) for name in dir(out) if not name.startswith("_")}
        return SimpleNamespace(
            **known | {"pressure": np.full_like(out.pressure, np.nan), "status": "stagnated"}
        )

    monkeypatch.setattr(normal._Problem, "solve", losing)
    with pytest.raises(mtb.ConvergenceError, match=WORDS):
        pressed()


@pytest.mark.parametrize("status", ["not converged", "no solution", "unreachable", "solved"])
def test_a_step_that_fails_with_nan_fails_in_words(status: str) -> None:
    contact = block().prepare("half-space")
    core = contact._core

    class Failing:
        """The core, whose steps lose their numbers."""

        def __getattr__(self, name: str) -> Any:
            return getattr(core, name)

        def step(self, *args: Any) -> Any:
            out, tangent, linear = core.step(*args)
            known = {name: getattr(out, name) for name in dir(out) if not name.startswith("_")}
            pressure = np.full_like(out.pressure, np.nan)
            return SimpleNamespace(**known | {"pressure": pressure, "status": status}), tangent, linear

    contact._core = Failing()  # type: ignore[assignment]
    with pytest.raises(mtb.ConvergenceError, match=WORDS):
        contact.step(velocity=(1.0, 0.0))
