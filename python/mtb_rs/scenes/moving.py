# SPDX-License-Identifier: MIT OR Apache-2.0
"""A scene whose upper body rolls or shifts once it is pressed down."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

from ..base.check import shortened
from ..base.plain import plain
from ..bodies.material import steel
from ..bodies.simple import do_creep
from ..friction.laws import Friction, law_of
from ..half_space.motions import Rolling, Shift
from ..half_space.pressure_field import HALF_SPACES_MOVE, PressureField
from ..half_space.tangential import solve_tangential
from ..half_space.tangential_result import TangentialResult
from ..results.result import Result
from . import methods
from .scene import Scene


@dataclass(frozen=True)
@plain
class Moving:
    """A scene and the motion that follows its pressing, with the friction and the layer of the scene.

    The bodies are half-spaces on one regular grid: what ``model="auto"`` means here.
    """

    scene: Scene
    motion: Rolling | Shift

    def solve(self, **options: Any) -> tuple[Result, TangentialResult]:
        """The pressed scene, by the options of :meth:`mtb_rs.Scene.solve`, and the motion after it.

        Raises
        ------
        ValueError, ConvergenceError
            As :meth:`mtb_rs.Scene.solve` and :func:`mtb_rs.solve_tangential`.
        """
        words, scene, law = self.options(**options), self.pressed(), self.law()
        self.check_motion()
        found = methods.solve(scene, **words)
        return found, solve_tangential(found, self.motion, law, scene.layer)

    def wrong(self, **options: Any) -> list[str]:
        """All that can be said against it before anything is solved."""
        found = [_why_not(partial(self.options, **options)), _why_not(self.law), _why_not(self.pressed)]
        if not any(found):
            found = [_why_not(self.check_motion)]
        return [reason for reason in found if reason]

    def options(self, **options: Any) -> dict[str, Any]:
        """The options of the pressing: half-spaces, where nothing else is asked for."""
        methods.check_options(**options)
        model, method = options.get("model", "auto"), options.get("method", "direct")
        if model == "auto" and method == "direct" and self.scene.own_model is None:
            model = "half-space"
        model = methods.model_of(self.scene, model, method)
        if model == "auto":
            model = self.scene.own_model or "half-space"
        if model != "half-space":
            asked = f"method is {method!r}" if method != "direct" else f"model is {model!r}"
            raise ValueError(f"{asked}: after it nothing can roll or shift; {HALF_SPACES_MOVE}")
        return options | {"model": model}

    def pressed(self) -> Scene:
        """The scene before the motion, without sliding: the friction is that of the motion."""
        if not self.scene.geometry.is_grid:
            raise ValueError(
                f"{self.scene.name} has several patches: to roll or to shift, one regular patch is needed, "
                "as paraboloid_on_plane, block_on_plane and wheel_on_rail have it"
            )
        # a law is one of the motion: nothing rubs before
        friction = 0.0 if isinstance(self.scene.friction, Friction) else self.scene.friction
        still = self.scene.with_(sliding_direction=None, friction=friction)
        creeping = [side for side in ("upper", "lower") if do_creep(getattr(still, side))]
        if not creeping:
            return still
        velocity = self.motion.steady_velocity
        return still.with_(**{side: getattr(still, side).rolled_over(velocity) for side in creeping})

    def law(self) -> Friction:
        """The friction of the motion: a number is Coulomb's."""
        law = law_of(self.scene.friction)
        if isinstance(law, Friction):
            return law
        raise ValueError(
            f"friction is {shortened(self.scene.friction)}: one number, or a law of friction, is needed "
            "to roll or to shift (in case files a number, or a table of temperature and coefficient)"
        )

    def check_motion(self) -> None:
        """Whether the motion suits the cells, and friction carries its force where it is known how much."""
        scene = self.pressed()
        if scene.spacing is None:
            scene = scene.with_(spacing=scene.geometry.start)
        problem = scene.problem("half-space")
        (patch,) = problem.patches
        self.motion.step_on(PressureField(np.zeros((1, 1)), patch.spacing, steel, steel))
        given = [value for value in self.motion.force or () if value is not None]
        carried = self.law().at_rest() * float(np.linalg.norm(problem.pressing))
        # within rounding the solve decides
        if given and 0.0 < carried < (1.0 - 1e-9) * float(np.linalg.norm(given)):
            words = ", ".join("free" if f is None else f"{f:g}" for f in self.motion.force or ())
            raise ValueError(
                f"force is ({words}) N: friction carries less than {carried:g} N, the coefficient at rest "
                "times the normal force"
            )


def _why_not(check: Callable[[], Any]) -> str:
    """What a check says against what it checks; "" if nothing."""
    try:
        check()
    except ValueError as error:
        return str(error)
    return ""
