# SPDX-License-Identifier: MIT OR Apache-2.0
"""Case files: TOML with the words of the ready scenes' arguments, checked at the door.

The keys of a case are the arguments of the scene it names, with the same defaults; they are read off
the scene's signature, so that nothing is said twice. ``[upper]`` and ``[lower]`` are the materials,
``[solve]`` holds the arguments of :meth:`mtb_rs.Scene.solve`, ``[rolling]`` or ``[shift]`` those of
:class:`mtb_rs.Rolling` or :class:`mtb_rs.Shift`.
"""

from __future__ import annotations

import json
import re
import tomllib
import typing
from collections.abc import Callable, Collection, Iterator, Mapping
from dataclasses import fields, is_dataclass
from functools import cache, partial
from pathlib import Path
from typing import Any, TypeVar

from pydantic import BaseModel, ConfigDict, Field, PrivateAttr, StrictStr, ValidationError, create_model
from pydantic_core import ErrorDetails

from ..base.check import meant, shortened, warn
from ..base.errors import CaseError, ToleranceWarning
from ..base.files import read_bytes, text_of
from ..base.questions import gathered
from ..base.words import Method, Model
from ..friction.fields import check_friction
from ..half_space.motions import Rolling, Shift
from ..half_space.tangential_result import TangentialResult
from ..half_space.temperature_friction import of_temperature
from ..results.result import Result
from ..results.stress_field import StressField
from ..results.stressed import Stressed, check_elastic, no_patch
from ..results.temperature import RollingTemperature
from ..results.wear_result import WearResult
from ..results.wheel_result import BELOW_CONFORMAL, WheelStep
from ..scenes import ready as scenes
from ..scenes.cost import ExpectedCost
from ..scenes.methods import OPTIONS, check_options, method_options, solve_defaults
from ..scenes.moving import Moving
from ..scenes.scene import Scene
from ..studies.brake import brake, posed_shoe
from ..studies.braking import Braking
from ..studies.wear import Passages, changed_by, checked_wear, wear
from ..studies.wheel_step import prepared_step, step_wheels
from .brake_words import BrakeWords, brake_of
from .damage_words import LOOK as DAMAGE_LOOK
from .damage_words import damage_found, damage_numbers, damage_of, why_not_damage
from .stress_words import LOOK as STRESS_LOOK
from .stress_words import stress_of
from .values import (
    MOTIONS,
    LayeredWords,
    MaterialWords,
    PrismWords,
    ViscoelasticWords,
    motion_words,
    read_by,
    words_of,
)
from .wear_words import LOOK, wear_of
from .wheel_words import LOOK as WHEELS_LOOK
from .wheel_words import wheels_of

T = TypeVar("T")

#: Fields of a case that are no arguments of its scene.
_BESIDES = (
    "scene_name",
    "solve_options",
    "wear_words",
    "brake_words",
    "stress_words",
    "damage_words",
    "step_wheels_words",
    *(f"{name}_words" for name in MOTIONS),
)
SCENES: tuple[str, ...] = tuple(scenes.__all__)
#: Tables beside the arguments of the scene.
_TABLES = {"solve", "wear", "brake", "stress", "damage", "step_wheels", *MOTIONS}
#: Most bytes of a case file; a long table goes into a file of its own.
MOST_BYTES = 1_000_000
#: Most lines of a message: what else is wrong is counted.
MOST_TOLD = 20
#: Most levels of tables and lists in a case file.
MOST_DEEP = 16
#: Most dots between two signs that end a key, before the file is parsed.
MOST_DOTS = 200
#: What else helps against text that a console has written in another encoding.
WRITTEN = ", or let the program write the file itself (mtb-rs init shoe -o case.toml)"


class Case(BaseModel):
    """A scene, its arguments and its solve options, as a case file states them. It never changes.

    The arguments of the scene are attributes under their own names.
    """

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False, arbitrary_types_allowed=True)

    scene_name: StrictStr = Field(alias="scene")
    _words: dict[str, Any] = PrivateAttr(default_factory=dict)
    _source: str = PrivateAttr(default="case")
    _directory: Path | None = PrivateAttr(default=None)

    def arguments(self) -> list[str]:
        """Names of the scene's arguments."""
        return [name for name in type(self).model_fields if name not in _BESIDES]

    def variables(self) -> list[str]:
        """What a sweep may vary: the scene's arguments, and words of its tables.

        Those of the motion are named as "rolling.velocity", those that are given of ``[wear]``, ``[brake]``
        and ``[step_wheels]`` as "brake.speed", those of a magnet or a layer as
        "magnetic_pressure.ampere_turns".
        """
        motion = self.motion
        own = [] if motion is None else [f"{motion.word}.{entry.name}" for entry in fields(motion)]
        studies = ("wear", "brake", "step_wheels")
        own += [f"{word}.{name}" for word in studies for name in getattr(self, word) or ()]
        parts = {n: getattr(self, n) for n in ("magnetic_pressure", "layer") if n in self.arguments()}
        made = [(name, part) for name, part in parts.items() if is_dataclass(part)]
        return (
            self.arguments() + own + [f"{name}.{entry.name}" for name, part in made for entry in fields(part)]
        )

    def argument(self, name: str, word: Any) -> Any:
        """What `word`, in place of the case's own, means as the argument `name` of the scene.

        An argument of the motion, or a word of a magnet or layer, is named with its table:
        ``"rolling.velocity"``, ``"magnetic_pressure.ampere_turns"``.

        Raises
        ------
        CaseError
            If the word cannot be meant.
        """
        table, dot, key = name.rpartition(".")
        words = self._words | {name: word}
        if dot:
            words = self._words | {table: {**self._words.get(table, {}), key: word}}
        case = case_from_words(words, source=self._source, directory=self._directory)
        is_of_motion = self.motion is not None and table == self.motion.word
        holder = case.motion if is_of_motion else getattr(case, table) if dot else case
        return holder[key] if isinstance(holder, dict) else getattr(holder, key)

    def scene(self) -> Scene:
        """The scene.

        Raises
        ------
        CaseError
            If arguments are wrong; the message names all of them.
        """
        wrong = self._wrong_arguments()
        if wrong:
            raise CaseError("\n".join(f"{self._source}: {line}" for line in wrong))
        return self._built(self.arguments())

    def _built(self, names: Collection[str]) -> Scene:
        """The scene with the arguments of these names, and defaults for the others."""
        scene: Scene = getattr(scenes, self.scene_name)(**{name: getattr(self, name) for name in names})
        if of_temperature(scene.friction) is None:
            check_friction(scene.friction)
        return scene

    def _why_not(self, names: Collection[str]) -> str | None:
        """What is wrong with the arguments of these names."""
        with gathered():
            try:
                self._built(names)
            except ValueError as error:
                return str(error)
        return None

    def _wrong_arguments(self) -> list[str]:
        """What is wrong with the arguments, one after another put back to its default.

        After the first one only what is wrong by itself counts: it might not suit a default.
        """
        names = self.arguments()
        given = [name for name in names if name in self._words]
        wrong: dict[str, None] = {}
        while (reason := self._why_not(names)) is not None:
            left = [name for name in given if name in names]
            alone = next((k for k in left if self._why_not([k]) == reason), None)
            named = re.split(r"\W", reason, maxsplit=1)[0]
            # what it says of another argument may be said of a default
            if not wrong or (alone is not None and (named == alone or named not in self.arguments())):
                wrong[reason] = None
            # what is wrong by itself comes first: without another one the defaults may not fit together
            blamed = alone or next(
                (k for k in left if self._why_not([n for n in names if n != k]) != reason), None
            )
            if blamed is None:
                break
            names = [name for name in names if name != blamed]
        return list(wrong)

    @property
    def motion(self) -> Rolling | Shift | None:
        """What the upper body does once it is pressed down: ``[rolling]`` or ``[shift]``."""
        given = (getattr(self, f"{name}_words") for name in MOTIONS)
        return next((motion for motion in given if motion is not None), None)

    def _options_of(self, word: str) -> dict[str, Any]:
        """What ``[solve]`` says to a study."""
        given = self._words.get("solve", {})
        if set(given) - {"model"}:
            more = ", ".join(sorted(set(given) - {"model"}))
            raise CaseError(f"{self._source}: solve.{more}: beside [{word}] only solve.model has a meaning")
        return {"model": self.solving["model"]}

    @property
    def swept(self) -> dict[str, Any]:
        """How :func:`mtb_rs.sweep` solves the scene as this case does: motion, study and options.

        Raises
        ------
        CaseError
            For ``[stress]``, which a table of a sweep has no place for, and for words of ``[solve]`` beside
            ``[wear]`` or ``[brake]`` that have no meaning there.
        """
        if self.stress is not None:
            raise CaseError(
                f"{self._source}: [stress] is given, and a sweep tables single numbers: take the table out, "
                "or run the cases one by one"
            )
        studies: tuple[tuple[str, Callable[..., Any], dict[str, Any] | None], ...] = (
            ("wear", wear, self.wear),
            ("brake", brake, self.brake),
            ("step_wheels", step_wheels, self.step_wheels),
        )
        for word, study, asked in studies:
            if asked is not None:
                return {"study": partial(study, **asked), **self._options_of(word)}
        measure = {} if self.damage is None else {"measure": partial(damage_numbers, **self._heating())}
        return {"motion": self.motion, **measure, **self.solving}

    @property
    def wear(self) -> dict[str, Any] | None:
        """The arguments of :func:`mtb_rs.wear` in ``[wear]``; None without this table."""
        found: dict[str, Any] | None = getattr(self, "wear_words")  # noqa: B009 (a field made below)
        return found

    def worn(self, **options: Any) -> WearResult:
        """Wears the scene as ``[wear]`` says; `checkpoint` and `progress` as :func:`mtb_rs.wear`.

        Errors as :func:`mtb_rs.wear`.
        """
        return self._studied(wear, "wear", self.wear, options)

    @property
    def brake(self) -> dict[str, Any] | None:
        """The arguments of :func:`mtb_rs.brake` in ``[brake]``; None without this table."""
        words: BaseModel | None = getattr(self, "brake_words")  # noqa: B009 (a field made below)
        return None if words is None else brake_of(words)

    def braked(self, **options: Any) -> Braking:
        """Brakes by the scene as ``[brake]`` says; `checkpoint` and `progress` as :func:`mtb_rs.brake`.

        Errors as :func:`mtb_rs.brake`.
        """
        return self._studied(brake, "brake", self.brake, options)

    @property
    def step_wheels(self) -> dict[str, Any] | None:
        """The arguments of :func:`mtb_rs.step_wheels` in ``[step_wheels]``; None without this table."""
        found: dict[str, Any] | None = getattr(self, "step_wheels_words")  # noqa: B009 (a field made below)
        return found

    def stepped(self) -> WheelStep:
        """Makes the step that ``[step_wheels]`` says.

        Errors as :func:`mtb_rs.step_wheels`.
        """
        return self._studied(step_wheels, "step_wheels", self.step_wheels, {})

    @property
    def stress(self) -> dict[str, Any] | None:
        """The arguments of ``stress()`` of the result in ``[stress]``; None without this table."""
        found: dict[str, Any] | None = getattr(self, "stress_words")  # noqa: B009 (a field made below)
        return found

    def stressed(self, result: Stressed) -> StressField:
        """The stress inside the bodies of what :meth:`solve` or :meth:`worn` found, by ``[stress]``.

        Raises
        ------
        CaseError
            For a body or a patch that has none.
        """
        if self.stress is None:
            raise CaseError(f"{self._source}: has no table [stress]")
        try:
            return result.stress(**self.stress)
        except ValueError as error:
            raise CaseError(f"{self._source}: stress: {error}") from error

    @property
    def damage(self) -> dict[str, Any] | None:
        """What ``[damage]`` says of the rolling: ``shear_yield`` and the arguments of
        :meth:`TangentialResult.temperature`; None without this table."""
        found: dict[str, Any] | None = getattr(self, "damage_words")  # noqa: B009 (a field made below)
        return found

    def _heating(self) -> dict[str, Any]:
        """The table ``[damage]``; what it does not say of the surfaces is that of the friction law."""
        given = {name: getattr(self, name) for name in self.arguments()}
        law = of_temperature(given.get("friction"))
        is_steady = self.motion is not None and self.motion.is_steady
        return {**(law.surfaces if law is not None and is_steady else {}), **(self.damage or {})}

    def damaged(self, result: TangentialResult) -> tuple[dict[str, float], RollingTemperature | None]:
        """T gamma and what else ``[damage]`` asks for, by name, of what :meth:`solve` found, and the
        temperatures of the surfaces, which transient rolling does not have.

        Raises
        ------
        CaseError
            Without such a table, and where the surfaces have no such temperature.
        """
        if self.damage is None:
            raise CaseError(f"{self._source}: has no table [damage]")
        try:
            return damage_found(result, **self._heating())
        except ValueError as error:
            raise CaseError(f"{self._source}: damage: {error}") from error

    def _without_stress(self, scene: Scene) -> str | None:
        """Why ``[stress]`` names a body or a patch that has none, before anything is solved. The patches are
        not known where the solve chooses the spacing.
        """
        if self.stress is None:
            return None
        side = self.stress.get("body", "lower")
        upper, lower = scene.simple
        body = lower if side == "lower" else upper
        if body.without_stress:
            return f"stress: the {side} body {body.without_stress}"
        if self.step_wheels is not None and self.step_wheels.get("conformal"):
            return f"stress: {BELOW_CONFORMAL}"
        if "depths" in self.stress:
            try:
                check_elastic(side, self.stress["depths"], body.elastic_depth)
            except ValueError as error:
                return f"stress: {error}"
        patch = self.stress.get("patch")
        if patch is None or self.step_wheels is not None or (scene.spacing is None and not self.motion):
            return None
        # what rolls or shifts is on one grid
        known = (
            ["contact"]
            if self.motion
            else [grid.name for grid in scene.geometry.grid(scene.known_spacing).patches]
        )
        return None if patch in known else f"stress: {no_patch(patch, known)}"

    def _studied(
        self,
        study: Callable[..., T],
        word: str,
        asked: dict[str, Any] | None,
        options: dict[str, Any],
    ) -> T:
        """What a study of the scene finds that its table asks for."""
        scene = self.scene()
        if asked is None:
            raise CaseError(f"{self._source}: has no table [{word}]")
        if why := self._without_stress(scene):
            raise CaseError(f"{self._source}: {why}")
        try:
            return study(scene, **asked, **self._options_of(word), **options)
        except ValueError as error:
            if isinstance(error, RuntimeError):
                raise
            raise CaseError(f"{self._source}: {error}") from error

    def solve(self) -> Result | TangentialResult | WearResult | Braking | WheelStep:
        """Solves the scene with the options of ``[solve]``, then its rolling or shift; or wears, brakes, or
        steps its wheels.

        Errors as :meth:`mtb_rs.Scene.solve`, :func:`mtb_rs.solve_tangential`, :func:`mtb_rs.wear`,
        :func:`mtb_rs.brake` and :func:`mtb_rs.step_wheels`.
        """
        if self.step_wheels is not None:
            return self.stepped()
        if self.wear is not None:
            return self.worn()
        if self.brake is not None:
            return self.braked()
        scene, motion = self.scene(), self.motion
        if why := self._without_stress(scene):
            raise CaseError(f"{self._source}: {why}")
        try:
            if motion is None:
                return scene.solve(**self.solving)
            pressed, moved = Moving(scene, motion).solve(**self.solving)
            if pressed.report.missed:
                warn(pressed.report.missed, ToleranceWarning)
            return moved
        except ValueError as error:
            if isinstance(error, RuntimeError):
                raise
            raise CaseError(f"{self._source}: {error}") from error

    def expected_cost(self) -> ExpectedCost:
        """What :meth:`solve` would take, without solving; see :meth:`mtb_rs.Scene.expected_cost`.

        Of wear, of a stop and of a step of wheels it is what one contact takes.

        Raises
        ------
        CaseError
            If the case cannot be solved as it is stated; the message names all that is wrong.
        """
        scene, motion, options = self.scene(), self.motion, self.solving
        if why := self._without_stress(scene):
            raise CaseError(f"{self._source}: {why}")
        if self.wear is not None:
            return self._studied(_cost_of_a_worn_contact, "wear", self.wear, {})
        if self.brake is not None:
            return self._studied(_cost_of_a_contact, "brake", self.brake, {})
        if self.step_wheels is not None:
            return self._studied(_cost_of_a_wheel, "step_wheels", self.step_wheels, {})
        try:
            if motion is None:
                return scene.expected_cost(**options)
            moving = Moving(scene, motion)
            wrong = moving.wrong(**options)
            if not wrong:
                cost = moving.pressed().expected_cost(**moving.options(**options))
                return cost.with_motion(motion.kind)
        except ValueError as error:
            wrong = [str(error)]
        raise CaseError("\n".join(f"{self._source}: {line}" for line in wrong))

    @property
    def solving(self) -> dict[str, Any]:
        """The words of ``[solve]``."""
        options: BaseModel = getattr(self, "solve_options")  # noqa: B009 (a field of the model made below)
        basic = solve_defaults()
        return {k: v for k, v in options if k in basic or k in options.model_fields_set}

    def to_toml(self) -> str:
        """The case as TOML: what was given, in its own words."""
        return _toml(self._words)


def _cost_of_a_contact(scene: Scene, *, model: Model, other_force: Any = None, **asked: Any) -> ExpectedCost:
    """What one contact of a stop takes; ValueError for what :func:`mtb_rs.brake` refuses before it solves."""
    shoe, _, _ = posed_shoe(scene, model=model, **asked)
    return shoe.expected_cost(model="elastic-upper" if model == "auto" else model)


def _cost_of_a_wheel(scene: Scene, *, model: Model = "auto", **asked: Any) -> ExpectedCost:
    """What one contact of a step takes; ValueError for what :func:`mtb_rs.step_wheels` refuses beforehand."""
    prepared_step(scene, model=model, **asked)
    return scene.expected_cost(model="half-space")


def _cost_of_a_worn_contact(scene: Scene, *, model: Model = "auto", **asked: Any) -> ExpectedCost:
    """What one contact takes that wears; ValueError for what :func:`mtb_rs.wear` refuses before it solves."""
    duty, *_ = checked_wear(scene, model=model, **asked)
    parts = [changed_by(scene, part.changes) if isinstance(part, Passages) else scene for part in duty]
    costs = [part.expected_cost(model=model) for part in parts]
    return costs[0]


def load_case(path: str | Path) -> Case:
    """Reads a case file.

    Raises
    ------
    CaseError
        Names the file, and every wrong key with its value and what would be accepted.
    """
    path = Path(path)
    try:
        content = read_bytes(path, "", MOST_BYTES)
    except ValueError as error:
        raise CaseError(str(error)) from error
    try:
        text = text_of(content)
        # a dotted key takes time and memory by the square of its parts
        if any(part.count(".") > MOST_DOTS for part in re.split(r"[=,{\n]", text)):
            raise RecursionError
        words = tomllib.loads(text)
    except UnicodeError as error:
        own = WRITTEN if "UTF-16" in str(error) else ""
        raise CaseError(f"{path}: is {error}{own}") from error
    except RecursionError:
        raise CaseError(f"{path}: is nested too deeply: at most {MOST_DEEP} levels are read") from None
    except ValueError as error:  # TOMLDecodeError is one; whole numbers of thousands of digits raise another
        raise CaseError(f"{path}: is not TOML: {error}") from error
    return case_from_words(words, source=str(path), directory=path.parent)


def case_from_words(words: Mapping[str, Any], *, source: str = "case", directory: Path | None = None) -> Case:
    """A case from the mapping that a case file holds; files it names are sought in `directory`.

    Raises
    ------
    CaseError
        As :func:`load_case`.
    """
    _check_words(source, words)
    name = words.get("scene")
    if name not in SCENES:
        given = "is missing" if name is None else f"is {shortened(name)}"
        raise CaseError(f"{source}: scene {given}: one of {', '.join(map(repr, SCENES))} is needed")
    model = case_model(str(name))
    wrong: dict[str, None] = {}
    untold = 0
    try:
        case = model.model_validate(words, context={"directory": directory or Path()})
    except ValidationError as error:
        items = error.errors()
        wrong = dict.fromkeys(_sentence(item, model) for item in items[:MOST_TOLD])
        untold = len(items) - len(items[:MOST_TOLD])
    told = {line.partition(" = ")[0] for line in wrong}
    for key, line in _wrong_options(words.get("solve")):
        if key not in told and len(wrong) < MOST_TOLD:
            wrong[line()] = None
        elif key not in told:
            untold += 1
    if "brake" in words and (others := [name for name in ("wear", *MOTIONS) if name in words]):
        wrong[f"brake and {others[0]} are given: give one of the two"] = None
    if "wear" in words and set(MOTIONS) & set(words):
        wrong["wear and a rolling or shift are given: give one of the two"] = None
    if "step_wheels" in words and (others := [name for name in ("wear", "brake", *MOTIONS) if name in words]):
        wrong[f"step_wheels and {others[0]} are given: give one of the two"] = None
    if "stress" in words and "brake" in words:
        wrong[
            "stress and brake are given: a stop has several shoes, and in Python shoes[0].stress() is that "
            "below one of them; give one of the two"
        ] = None
    if set(MOTIONS) <= set(words):
        wrong["rolling and shift are given: a body rolls or shifts, so give one of the two"] = None
    if not wrong and case.damage is not None and (why := why_not_damage(case.damage, case.motion)):
        wrong[why] = None
    if wrong:
        if not untold:
            wrong.update((line, None) for line in _wrong_besides(words, wrong, source, directory))
        more = [f"and {untold} more"] if untold else []
        raise CaseError("\n".join(f"{source}: {line}" for line in [*wrong, *more]))
    case._words = dict(words)
    case._source = source
    case._directory = directory
    return case


def _wrong_besides(
    words: Mapping[str, Any], wrong: Collection[str], source: str, directory: Path | None
) -> list[str]:
    """Values that no scene takes, beside keys and values of which that is known."""
    keys = {re.split(r"[.:= ]", line, maxsplit=1)[0] for line in wrong} | _TABLES
    rest = {key: value for key, value in words.items() if key not in keys}
    if len(rest) == len(words):  # keys that hold signs of their own
        return []
    try:
        return case_from_words(rest, source=source, directory=directory)._wrong_arguments()
    except CaseError:
        return []


def _check_words(source: str, words: Mapping[str, Any]) -> None:
    """What no scene can take, before anything is called with it: deep tables, numbers beyond 64 bits."""
    waiting: list[tuple[tuple[str, ...], Any]] = [((), words)]
    while waiting:
        place, value = waiting.pop()
        key = ".".join(place[:4])
        if len(place) > MOST_DEEP:
            raise CaseError(f"{source}: {key}...: is nested too deeply: at most {MOST_DEEP} levels are read")
        if isinstance(value, int) and not -(2**63) <= value < 2**63:
            raise CaseError(
                f"{source}: {key}: is a whole number of {value.bit_length()} bits: at most 64 are read"
            )
        if isinstance(value, Mapping):
            waiting += [((*place, str(name)), part) for name, part in value.items()]
        elif isinstance(value, (list, tuple)):
            waiting += [((*place, str(k)), part) for k, part in enumerate(value)]


@cache
def case_model(scene: str) -> type[Case]:
    own = {method: words_of(made, method_options(method)) for method, made in OPTIONS.items()}
    options = {name: word for words in own.values() for name, word in words.items()}
    solve = create_model(
        "SolveWords",
        # what is no option at all is told with the options of the method
        __config__=ConfigDict(
            extra="allow",
            frozen=True,
            allow_inf_nan=False,
            protected_namespaces=(),
            json_schema_extra={
                "additionalProperties": False,
                "dependentSchemas": {
                    name: {
                        "required": ["method"],
                        "properties": {"method": {"enum": [method for method in own if name in own[method]]}},
                    }
                    for name in options
                },
            },
        ),
        **words_of(Scene.solve),
        **options,
    )
    fields = words_of(getattr(scenes, scene))
    fields["solve_options"] = (solve, Field(default_factory=solve, alias="solve"))
    fields["wear_words"] = (read_by(wear_of, LOOK), Field(default=None, alias="wear"))
    fields["stress_words"] = (read_by(stress_of, STRESS_LOOK), Field(default=None, alias="stress"))
    fields["damage_words"] = (read_by(damage_of, DAMAGE_LOOK), Field(default=None, alias="damage"))
    fields["step_wheels_words"] = (read_by(wheels_of, WHEELS_LOOK), Field(default=None, alias="step_wheels"))
    fields["brake_words"] = (BrakeWords | None, Field(default=None, alias="brake"))
    for name, motion in MOTIONS.items():
        fields[f"{name}_words"] = (motion_words(motion), Field(default=None, alias=name))
    return create_model(f"{scene}_case", __base__=Case, **fields)


# --- what is wrong, in one line ----------------------------------------------------------------------


def _sentence(item: ErrorDetails, model: type[Case]) -> str:
    place = [str(part) for part in item["loc"]]
    key = ".".join(place)
    given = item["input"]
    if item["type"] == "missing":
        return f"{key}: is missing"
    if item["type"] == "extra_forbidden":
        tables: dict[str, list[type[BaseModel]]] = {"brake": [BrakeWords]}
        bodies: list[type[BaseModel]] = [MaterialWords, LayeredWords, PrismWords, ViscoelasticWords]
        inner = tables.get(place[0], bodies) if len(place) > 1 else [model]
        known = [field.alias or name for one in inner for name, field in one.model_fields.items()]
        if place == ["sweep"]:
            return (
                "sweep: is no table of a case file: mtb-rs sweep CASE.toml --vary friction=0.1,0.2, or "
                "mtb.sweep, solves a case for each of several values"
            )
        # a key of other bodies is none of this one
        known = [name for name in known if name != place[-1]]
        return _with_hint(f"{key} = {_short(given)}: unknown key", place[-1], known)
    if item["type"] == "model_type":
        return f"{key} = {_short(given)}: a table is needed"
    message = item["msg"].removeprefix("Value error, ")
    message = re.sub(r"^Input should be (.*)$", r"\1 is needed", message)
    return f"{key} = {_short(given)}: {message}"


def _wrong_options(given: Any) -> Iterator[tuple[str, Callable[[], str]]]:
    """What of ``[solve]`` no scene takes: the keys with what makes their sentences."""
    if not isinstance(given, Mapping):
        return
    basic = [name for name in words_of(Scene.solve)]
    for name in basic:
        if name in given:
            try:
                check_options(**{name: given[name]})
            except ValueError as error:
                yield f"solve.{name}", partial("solve: {}".format, error)
    method = given.get("method", "direct")
    if method not in typing.get_args(Method):
        return
    known = [*basic, *method_options(method)]
    for name, value in given.items():
        if name not in known:
            key = f"solve.{name}"
            what = f"{key} = {_short(value)}: unknown option of the {method} method"
            yield key, partial(_with_hint, what, str(name), known)


def _with_hint(what: str, name: str, known: Collection[str]) -> str:
    near = meant(name, known)
    return f"{what}; did you mean {near!r}?" if near else f"{what}; known are {', '.join(known)}"


def _short(value: Any) -> str:
    text = json.dumps(value, default=str)
    return text if len(text) <= 60 else text[:57] + "..."


# --- back to TOML --------------------------------------------------------------------------------------


def _toml(words: Mapping[str, Any], table: str = "") -> str:
    lines = []
    for key, value in words.items():
        if not isinstance(value, Mapping):
            lines.append(f"{key} = {_toml_value(value)}")
    for key, value in words.items():
        if isinstance(value, Mapping):
            name = f"{table}.{key}" if table else key
            lines += ["", f"[{name}]", _toml(value, name).rstrip("\n")]
    return "\n".join(lines) + "\n"


def _toml_value(value: Any) -> str:
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, (list, tuple)):
        return "[" + ", ".join(_toml_value(part) for part in value) + "]"
    if isinstance(value, Mapping):
        return "{" + ", ".join(f"{key} = {_toml_value(part)}" for key, part in value.items()) + "}"
    if isinstance(value, str):
        return json.dumps(value)
    return repr(value)
