# SPDX-License-Identifier: MIT OR Apache-2.0
"""A contact as it is posed: two bodies, their gap, their load, their friction."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, fields, replace
from typing import Any, Self, cast, get_args

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..base.check import LARGEST, choice, in_place, number, pair, positive, reals, shortened, warn
from ..base.errors import ToleranceWarning
from ..base.owning import frozen, own
from ..base.plain import plain, same
from ..base.questions import ask, gathered
from ..base.renamed import renamed
from ..base.stored import without_functions
from ..base.told import Row, Told, stated
from ..base.units import unit_of_argument
from ..base.words import Attraction, Method, Model
from ..bodies.elastic_body import ElasticBody
from ..bodies.material import Material
from ..bodies.prism import BELOW, Prism
from ..bodies.sides import Side
from ..bodies.simple import (
    BESIDE_ELASTIC,
    BESIDE_ROLLING,
    HalfSpace,
    Layered,
    Rigid,
    Simple,
    as_body,
    do_creep,
)
from ..bodies.supports import held_by
from ..bodies.surfaces import BodySurface
from ..contact.elastic import Held, half_spaces, on_foundation, on_rail, on_rigid
from ..contact.problem import Attracting, ContactProblem, Kept, Solution, sliding_direction
from ..contact.solids import Bodies, OwnBodies, body_contact, check_faces
from ..contact.solve import finish, magnetic_field
from ..contact.standing import Contact
from ..contact.symmetry import mirror_symmetry
from ..friction.fields import (
    BACKWARDS,
    LARGEST_FRICTION,
    Asked,
    Coefficients,
    as_form,
    friction_field,
    numbers_in,
)
from ..friction.fields import field as field_at
from ..friction.laws import InterfaceLayer, PlasticLayer, ShearLayer, normal_flexibility, of_friction
from ..friction.rough_law import RoughLaw
from ..geometry.contact_points import ContactPoints, Patch, spacing_pair
from ..geometry.geometries import GapField, Geometry
from ..geometry.profiles import Profile
from ..results.doors import png
from ..results.plausible import of_layers, of_scene
from ..results.result import Result, percent

Array = NDArray[np.float64]

#: Least hardness [Pa]: softer bodies bear no load that numbers tell from nothing.
LEAST_HARDNESS = 1e-9


@dataclass(frozen=True)
@plain
class PosedScene(Told):
    """What :class:`mtb_rs.Scene` states, and the contact problem it poses."""

    upper: Material | Simple | ElasticBody
    lower: Material | Simple | ElasticBody | Prism
    gap: ArrayLike | Callable[[Array, Array], Any] | None = None
    spacing: float | Sequence[float] | None = 1e-3
    friction: Any = 0.0
    sliding_direction: tuple[float, float] | None = (1.0, 0.0)
    force: float | None = None
    approach: float | None = None
    moments: tuple[float, float] | None = None
    magnetic_pressure: Any = None
    attraction: Attraction = "upper"
    velocity: float | None = None
    layer: InterfaceLayer | PlasticLayer | None = None
    normal_layer: Any = None
    hardness: Any = None
    supports: Any = None
    element_size: float | None = None
    # none is given where it follows from the gap and the bodies
    geometry: Geometry = None  # type: ignore[assignment]
    name: str = "scene"
    inputs: dict[str, Any] = field(default_factory=dict, compare=False)
    recipe: tuple[Callable[..., Any], Mapping[str, Any]] | None = field(
        default=None, repr=False, compare=False
    )

    def __post_init__(self) -> None:
        put = object.__setattr__
        own(self)
        given: Geometry | None = self.geometry
        for side in ("upper", "lower"):
            body = getattr(self, side)
            put(self, side, body if isinstance(body, (ElasticBody, Prism)) else as_body(side, body))
        names = [body.name for body in self.solids.values()]
        if len(names) == 2 and names[0] == names[1]:
            for upper, body in self.solids.items():
                side = "upper" if upper else "lower"
                put(self, side, body.named(f"{side} {body.name}"))
        if self.spacing is not None:
            put(self, "spacing", spacing_pair(self.spacing))
        elif given is None or given.start is None:
            raise ValueError("spacing is None: a gap on a grid and elastic bodies need their spacing [m]")
        if isinstance(self.upper, Rigid) and isinstance(self.lower, Rigid):
            raise ValueError("upper and lower are both Rigid: one of them must deform")
        solid = next(iter(self.solids.values()), None)
        self._check_layers(solid)
        gap: Any = self.gap
        is_made = given is not None and not isinstance(given, (OwnBodies, GapField))
        if is_made and (gap is not None or solid is not None):
            what = "a gap" if gap is not None else "an ElasticBody"
            raise ValueError(f"{what} is given, but {self.name} has a geometry of its own")
        gap = gap if gap is None or callable(gap) else gap_field(gap)
        surface = self._surface(solid, gap)
        if solid is not None:
            # of these bodies and this gap, which may be others than those of a scene this is a copy of
            lower = self.lower
            opponent = self.solids.get(False) if solid is not lower else None
            step = self.known_spacing
            before = given.gap if isinstance(given, OwnBodies) else None
            if isinstance(given, OwnBodies) and before is not None and gap is not None:
                # what was given before is thinned
                step = given.step or step if same(gap, before) else step
            put(self, "geometry", OwnBodies(solid, solid is self.upper, gap, opponent, step, surface))
        elif not is_made and (
            not isinstance(given, GapField) or gap is None or not np.array_equal(gap, given.gap)
        ):
            put(self, "geometry", GapField(gap_field(gap), self.known_spacing))
        elif (
            isinstance(given, GapField)
            and min(s / d for s, d in zip(self.known_spacing, given.step, strict=True)) < 0.999
        ):
            raise ValueError(
                f"spacing is {self.spacing} m, the gap is given on cells of {given.step} m: give it on the "
                "finer ones as well"
            )
        pressing = [k for k in ("force", "approach", "magnetic_pressure") if getattr(self, k) is not None]
        if len(pressing) != 1 and (pressing or solid is None):
            what = f"{' and '.join(pressing)} press" if pressing else "nothing presses"
            raise ValueError(
                f"{what} the bodies together: give exactly one of force [N], approach [m] and "
                "magnetic_pressure [Pa]"
            )
        for name in ("force", "approach"):
            value = getattr(self, name)
            if value is not None:
                put(self, name, positive(name, value, "N" if name == "force" else "m"))
        has_bodies = "elastic-upper" in self.geometry.models
        if not has_bodies:
            for name in ("supports", "element_size"):
                if getattr(self, name) is not None:
                    raise ValueError(
                        f"{name} is {getattr(self, name)!r}: it is for the elastic bodies of "
                        "block_on_plane and pole_shoe_on_rail; an ElasticBody has its own"
                    )
        if has_bodies:
            put(self, "supports", held_by(self.supports))
        if self.layer is not None and not isinstance(self.layer, ShearLayer):
            raise ValueError(f"layer is {self.layer!r}: an InterfaceLayer or a PlasticLayer is needed")
        if self.normal_layer is not None:
            put(self, "normal_layer", normal_flexibility(self.normal_layer))
            if self.rough is None:
                nowhere = Asked("normal_layer", np.empty((3, 0)), (), None, 0.0)
                nowhere.check_range(as_form(self.normal_layer).placed("normal_layer"))
        if self.hardness is not None:
            nowhere = Asked("hardness", np.empty((3, 0)), (), None, LEAST_HARDNESS)
            nowhere.check_range(as_form(self.hardness).placed("hardness"))
        choice("attraction", self.attraction, Attraction)
        if self.sliding_direction is not None:
            put(self, "sliding_direction", pair("sliding_direction", self.sliding_direction))
        if self.moments is not None:
            put(self, "moments", pair("moments", self.moments, "N m"))
            if self.approach is not None:
                raise ValueError("moments are given beside approach: only a load can have them")
        if self.element_size is not None:
            put(self, "element_size", positive("element_size", self.element_size, "m"))
        if self.velocity is not None:
            put(self, "velocity", number("velocity", self.velocity, "m/s"))
            if self.velocity < 0.0:
                raise ValueError(
                    f"velocity is {self.velocity:g} m/s: a speed of at least 0 is needed; {BACKWARDS}"
                )
        # fields may be in normalised units
        if self.geometry.is_metric:
            ask(of_scene(self.upper, self.lower, self.magnetic_pressure, self.force))
        largest = max(numbers_in(self.friction), default=0.0)
        # what is larger is refused where the field is made
        ask(of_friction("friction", largest) if largest <= LARGEST_FRICTION else [])

    def ask_of_places(self) -> None:
        """Warns of fields whose places in the scene look like a slip of the unit."""
        fields = {name: as_form(getattr(self, name)) for name in ("friction", "magnetic_pressure")}
        fields = {name: form for name, form in fields.items() if form.has_places}
        spacing = self.geometry.start if self.spacing is None else self.known_spacing
        if fields and spacing is not None and self.geometry.is_metric:
            grid = self.geometry.grid(spacing)
            for name, form in fields.items():
                ask(form.doubts(Asked(name, grid.points, grid.patches, self.velocity)))

    @property
    def rough(self) -> RoughLaw | None:
        """The law of the layer between the bodies, where it is a rough one."""
        return self.normal_layer if isinstance(self.normal_layer, RoughLaw) else None

    @property
    def simple(self) -> tuple[Simple, Simple]:
        """Upper and lower body of a scene without an ElasticBody."""
        return cast(tuple[Simple, Simple], (self.upper, self.lower))

    def bodies_of(self, problem: ContactProblem) -> tuple[Simple | None, Simple | None, tuple[str, ...]]:
        """Lower and upper body, None of those that have finite elements in a problem, and which these are."""
        elastic = tuple(
            side
            for side in ("lower", "upper")
            if any(part.upper == (side == "upper") for part in problem.parts)
        )
        lower, upper = (
            None if side in elastic else cast(Simple, getattr(self, side)).kept()
            for side in ("lower", "upper")
        )
        return lower, upper, elastic

    @property
    def known_spacing(self) -> tuple[float, float]:
        """The spacing, where it must be known."""
        if self.spacing is None:
            raise ValueError(
                'spacing is None: only solve() with method="direct" chooses it; elsewhere a spacing [m] is '
                "needed, for paraboloid_on_plane a number of points"
            )
        return spacing_pair(self.spacing)

    def _check_layers(self, solid: ElasticBody | None) -> None:
        """Whether layered bodies are where they are known."""
        for side in ("upper", "lower"):
            body = getattr(self, side)
            if isinstance(body, Prism) and (side == "upper" or solid is not None):
                beside = "" if solid is None else " beside an ElasticBody"
                raise ValueError(f"{side} is {body!r}{beside}: {BELOW}")
            if do_creep(body) and solid is not None:
                raise ValueError(f"{side} is {body!r} beside an ElasticBody: {BESIDE_ROLLING}")
            if not isinstance(body, Layered):
                continue
            if solid is not None:
                raise ValueError(f"{side} is a Layered beside an ElasticBody: {BESIDE_ELASTIC}")
            rubs = self.sliding_direction is not None and as_form(self.friction).number != 0.0
            if rubs and not body.bonded:
                raise ValueError(
                    f"{side} is a Layered that is not bonded, and friction is {shortened(self.friction)}: a "
                    "layer that slides on its base without friction would be carried away: friction=0, "
                    "sliding_direction=None or bonded=True is needed"
                )

    def _surface(self, solid: ElasticBody | None, gap: Any) -> Profile | BodySurface | None:
        """The surface given for the half-space or rigid body beside an elastic one."""
        if solid is None and callable(gap):
            raise ValueError("gap is a function, which takes an ElasticBody: give a field (ny, nx) [m]")
        found: Profile | BodySurface | None = None
        for body in (self.upper, self.lower):
            if not isinstance(body, (HalfSpace, Rigid)) or body.surface is None:
                continue
            if solid is None or gap is not None:
                why = "no body is an ElasticBody" if solid is None else "gap is given as well"
                raise ValueError(
                    f"a half-space or rigid body has the surface {body.surface!r}, but {why} "
                    "(mtb_rs.surface_gap makes a gap of two surfaces)"
                )
            found = body.surface
        return found

    @property
    def solids(self) -> dict[bool, ElasticBody]:
        """The elastic bodies of one's own, by whether each is the upper one, which comes first."""
        sides = ((True, self.upper), (False, self.lower))
        return {upper: body for upper, body in sides if isinstance(body, ElasticBody)}

    @property
    def sliding_velocity(self) -> Array | None:
        """Velocity (2,) [m/s] of the upper body over the lower one; None where it is not stated."""
        if self.velocity is None or self.sliding_direction is None:
            return None
        way = np.array(self.sliding_direction) / np.hypot(*self.sliding_direction)
        return np.asarray(self.velocity * way)

    @property
    def own_model(self) -> Model | None:
        """The model of a scene with an ElasticBody, which its bodies are; None for other scenes."""
        own: dict[tuple[bool, ...], Model] = {
            (True, False): "elastic-both",
            (True,): "elastic-upper",
            (False,): "elastic-lower",
        }
        return own.get(tuple(self.solids))

    def _why_apart(self, points: ContactPoints, loads: Mapping[str, Any]) -> str:
        """Why bodies of any geometry do not touch, in words."""
        pull = -float(np.asarray(loads.get("magnetic", np.zeros(3)))[2])
        if self.magnetic_pressure is not None and pull <= 0.0:
            return (
                f"the bodies never touch: the attraction by magnetic_pressure is {pull:.6g} N, it must be "
                "positive to press them together"
            )
        least = float(points.gap.min())
        if least <= 0.0:
            return (
                "the bodies never touch: without load they lie on each other, but their supports lift "
                "them apart or carry the whole load; leave z free, or move a support towards the contact"
            )
        hint = ""
        if self.gap is None and np.ptp(points.gap) > 0.0:
            hint = f"; a contact narrower than the cells of {self.known_spacing} m needs finer ones"
        return (
            "the bodies never touch: nothing brings them together over their least gap of "
            f"{least:.4g} m{hint}"
        )

    def _check_pressed(self, problem: ContactProblem) -> None:
        """A body free along z gives way to an approach."""
        loose = problem.core.unpressed(problem.loading)
        names = [part.body.name for part in problem.parts for _ in part.modes]
        if loose is not None:
            raise ValueError(
                f"approach is {self.approach:g} m, but the supports leave {names[loose]} free along z and "
                "nothing presses it: hold z by a support, or give force [N] or magnetic_pressure [Pa] instead"
            )
        free = np.flatnonzero(problem.upper.lifts)
        if free.size:
            raise ValueError(
                f"approach is {self.approach:g} m, but the supports leave {names[int(free[0])]} free along "
                "z, where a guide presses it: it gives way to an approach as far as it goes. Leave approach "
                "out, or hold z by a support"
            )

    def _wrench(self, arm: Array) -> Array:
        """Force and moment (6,) on all elastic upper bodies, pressed at `arm` (3,) [m] from their centres."""
        force = np.array([0.0, 0.0, -(self.force or 0.0)])
        moment = np.array([*(self.moments or (0.0, 0.0)), 0.0])
        return np.concatenate([force, moment + np.cross(arm, force)])

    def finished(
        self,
        problem: ContactProblem,
        solution: Solution,
        method: Method,
        **known: Any,
    ) -> Result:
        """The result of a solution.

        Raises
        ------
        ConvergenceError, ResultantError
            If `solution` is none; the state is attached.
        ValueError
            If the bodies do not touch, or touch up to the edge of a grid beyond which they go on.
        """
        result = finish(
            problem,
            solution,
            method=method,
            surfaces=self.geometry.surfaces(),
            summary=self.statement(),
            bodies=(self.lower, self.upper),
            velocity=self.sliding_velocity if problem.direction.any() else None,
            **known,
        )
        is_touching = result.report.contact_area > 0.0
        self.check_touching(is_touching, problem.points, problem.loads)
        if self.own_model is not None and is_touching:
            check_faces(self.solids.values(), problem, result)
        self.check_edge(problem.patches, result.pressure.reshape(-1))
        return result

    def has_model(self, model: Model) -> bool:
        """Whether the scene has the geometry and the bodies of a model."""
        try:
            self.check_model(model)
        except ValueError:
            return False
        return True

    @property
    def models(self) -> list[Model]:
        """The models that the scene has, the fullest last."""
        return [model for model in get_args(Model) if model != "auto" and self.has_model(model)]

    def check_model(self, model: Model) -> None:
        """Whether the scene has the geometry and the bodies of a model."""
        own = self.own_model
        if model == "auto" or model == (own or "half-space"):
            return
        if own is not None:
            raise ValueError(
                f"model is {model!r}: a scene with an ElasticBody has its model in its bodies, {own!r}"
            )
        if model not in self.geometry.models:
            raise ValueError(f"model is {model!r}: this scene has no geometry for its elastic bodies")
        bodies = list(zip(("upper", "lower"), self.simple, strict=True))
        for name, body in bodies:
            if isinstance(body, Layered):
                raise ValueError(f"model is {model!r}, and {name} is Layered: {BESIDE_ELASTIC}")
            if isinstance(body, Prism) and model == "elastic-both":
                raise ValueError(
                    f"model is {model!r}, and {name} is a Prism, which is elastic in every model: "
                    'model="elastic-upper" makes the body above it elastic as well'
                )
            if do_creep(body):
                raise ValueError(f"model is {model!r}, and {name} is Viscoelastic: {BESIDE_ROLLING}")
        for name, body in bodies[: 2 if model == "elastic-both" else 1]:
            if not body.is_half_space:
                raise ValueError(f"model is {model!r}: {name} is Rigid")
        if self.magnetic_pressure is None:
            raise ValueError(f"model is {model!r}: the scene needs a magnetic_pressure")

    def check_rolling(self) -> None:
        """Whether it is known how the contact rolls over bodies that creep."""
        for side in ("upper", "lower"):
            body = getattr(self, side)
            if do_creep(body) and not body.is_rolled:
                raise ValueError(f"{side} is {body!r}: {BESIDE_ROLLING}")

    def problem(
        self,
        model: Model,
        spacing: tuple[float, float] | None = None,
        *,
        thinner: float = 1.0,
        carrier: tuple[float, float] | None = None,
        may_halve: bool = True,
    ) -> ContactProblem:
        """The contact problem of a model, on cells of `spacing` (its own by default).

        Elastic upper bodies have the layers of elements of a grid finer by the factor `thinner`. Bodies under
        many points are condensed onto fewer ones; with a `carrier`, onto points of this spacing. The rail of
        a scene that is its own mirror image is known by its half only, if it `may_halve`. The half does not
        answer loads, poses and displacements that come later and are not symmetric.
        """
        self.check_rolling()
        spacing = self.known_spacing if spacing is None else spacing
        time_s: dict[str, float] = {}
        contact = self._contact(model, spacing, (thinner, carrier), may_halve, time_s)
        problem = self._under_load(contact, self.own_model or model, time_s)
        if spacing == self.known_spacing:
            for doubt in contact.doubts:
                warn(doubt)
            ask(of_layers((self.upper, self.lower), spacing), kind=ToleranceWarning)
            if self.magnetic_pressure is not None and contact.beyond is not None:
                name, share = contact.beyond
                warn(
                    f"{percent(share)} of the contact face of {name} has nothing opposite, because the "
                    "surface of the other body ends before: magnetic_pressure acts only where the bodies "
                    "face one another, here on the rest of the face"
                )
        return problem

    def _contact(
        self,
        model: Model,
        spacing: tuple[float, float],
        elements: tuple[float, tuple[float, float] | None],
        may_halve: bool,
        time_s: dict[str, float],
    ) -> Contact:
        """The bodies of a model where they stand."""
        geometry = self.geometry
        if self.own_model is not None:
            return body_contact(
                cast(OwnBodies, geometry), cast(Bodies, (self.upper, self.lower)), spacing, time_s
            )
        upper, lower = self.simple
        if model == "half-space":
            return half_spaces(geometry, upper, lower, spacing)
        # that these are half-spaces is checked with the model
        upper = cast(HalfSpace, upper)
        held = Held(self.supports, self.element_size, *elements)
        if model == "elastic-upper":
            return on_foundation(geometry, (upper, lower), spacing, held, time_s)
        lower = cast(HalfSpace, lower)
        above = on_rigid(geometry, upper, spacing, held, time_s)
        symmetry = mirror_symmetry(self._under_load(above, model, {})) if may_halve else None
        image = None if symmetry is None else symmetry.image
        return on_rail(geometry, (upper, lower), spacing, held, image, time_s)

    def _under_load(self, contact: Contact, model: Model, time_s: dict[str, float]) -> ContactProblem:
        """The bodies of a contact under the loads of the scene."""
        if not self.geometry.is_body_edge:
            contact = replace(contact, windows=contact.patches)
        points, patches, kept, n = contact.points, contact.patches, contact.kept, contact.area.size
        magnet = as_form(self.magnetic_pressure)
        circuit = magnet.circuit(contact.area, patches, None if kept is None else kept.numbers)
        if circuit is None:
            pull = np.zeros(n)
            if self.magnetic_pressure is not None:
                pull = self.pull_at(points, patches, kept)
            return self._under_pull(contact, model, time_s, pull)

        def under(pull: Array) -> ContactProblem:
            return self._under_pull(contact, model, time_s, pull)

        factor = magnet.factor(self.velocity)
        problem = under(circuit.attract(np.ascontiguousarray(points.gap), factor)[0])
        bodies = [(True, problem.upper.is_pulled_at_face)]
        if self.attraction == "both":
            bodies.append((False, problem.lower.is_pulled_at_face))
        attracting = Attracting(circuit, factor, bodies, magnet.from_touching, under)
        return replace(problem, attracting=attracting)

    def _under_pull(
        self, contact: Contact, model: Model, time_s: dict[str, float], pull: Array
    ) -> ContactProblem:
        """The bodies of a contact under the loads of the scene and a magnetic pressure (n,) [Pa]."""
        points, patches, kept, n = contact.points, contact.patches, contact.kept, contact.area.size
        load = contact.load_of(pull)
        loads: dict[str, Any] = {}
        centre = contact.upper.centre
        if centre is None:
            upper = contact.upper.side(pull, np.zeros(6))
            if self.approach is None:
                upper = self._pressed(upper, contact, load, loads)
        else:
            if kept is None:
                self._check_pull(pull, patches)
            middle = contact.middle(patches[0])
            upper = contact.upper.side(pull, self._wrench(middle - centre) / len(patches))
            if self.magnetic_pressure is not None:
                loads["magnetic"] = load.sum(axis=1)
        lower_pull = pull if self.attraction == "both" else np.zeros(n)
        problem = ContactProblem(
            points=points,
            area=contact.area,
            patches=patches,
            friction=self._friction(points, patches, kept),
            direction=sliding_direction(self.sliding_direction, contact.geometry, n),
            gap=points.gap - (self.approach or 0.0) * contact.normals[2],
            upper=upper,
            lower=contact.lower.side(lower_pull, np.zeros(6)),
            model=model,
            approach=self.approach,
            loads=loads,
            shape=contact.shape,
            averages=contact.averages,
            notes=contact.notes,
            time_s=time_s,
            kept=kept,
            memory=contact.memory,
            windows=contact.windows,
            layer=self.normal_layer_at(points, patches, kept),
            hardness=self.hardness_at(points, patches, kept),
            rough=self.rough,
            shear=self.shear(n),
            moments=(0.0, 0.0) if self.moments is None or centre is not None else self.moments,
        )
        if self.approach is not None:
            self._check_pressed(problem)
        return problem

    def _check_pull(self, pull: Array, patches: tuple[Patch, ...]) -> None:
        """ValueError where the magnetic pressure does not press a ready elastic body."""
        for patch in patches:
            total = float(pull[patch.cut].sum())
            if total < 1.0 / LARGEST:
                raise ValueError(
                    f"magnetic_pressure on patch {patch.name!r} is {total / (patch.nx * patch.ny):.6g} Pa "
                    "on average: it does not press the bodies together (it must be positive)"
                )

    def _friction(
        self, points: ContactPoints, patches: tuple[Patch, ...], kept: Kept | None = None
    ) -> Coefficients:
        return as_form(self.friction).coefficients(
            lambda: self.friction_at(points, patches, kept, self.velocity)
        )

    def normal_layer_at(
        self, points: ContactPoints, patches: tuple[Patch, ...], kept: Kept | None
    ) -> Array | None:
        """Flexibilities (n,) [m/Pa] of the layer between the bodies at contact points."""
        if self.normal_layer is None or self.rough is not None:
            return None
        numbers = None if kept is None else kept.numbers
        spec = self._on(patches, self.normal_layer)
        return field_at("normal_layer", spec, points.points, patches, None, 0.0, kept=numbers)

    def shear(self, n: int, *, is_still: bool | None = None) -> Array | None:
        """Yield stress (n,) [Pa] of the layer that the bodies slide on; None without such a layer.

        ValueError for one that hardens or softens, unless nothing slides.
        """
        if self.layer is None or self.layer.plasticity is None:
            return None
        strength, hardening = self.layer.plasticity
        if hardening == 0.0:
            return np.full(n, strength)
        if self.sliding_direction is None if is_still is None else is_still:
            return None
        limit = "friction alone would limit the traction" if hardening > 0.0 else "no strength would be left"
        raise ValueError(
            f"layer has a hardening of {hardening:g} Pa/m: bodies that slide shear it on and on, until "
            f"{limit}; sliding takes a PlasticLayer without hardening, shifts and rolling take one with it"
        )

    def hardness_at(
        self, points: ContactPoints, patches: tuple[Patch, ...], kept: Kept | None
    ) -> Array | None:
        """Pressures (n,) [Pa] at which one body flows at contact points."""
        if self.hardness is None:
            return None
        numbers = None if kept is None else kept.numbers
        spec = self._on(patches, self.hardness)
        return field_at("hardness", spec, points.points, patches, None, LEAST_HARDNESS, kept=numbers)

    def friction_from_rest(self, problem: ContactProblem, pressure: Array) -> Array:
        """Friction coefficients (n,) of bodies that rest and start to slide under a pressure (n,) [Pa]."""
        return problem.friction_at(pressure)

    def friction_at(
        self, points: ContactPoints, patches: tuple[Patch, ...], kept: Kept | None, velocity: float | None
    ) -> Array:
        """Friction coefficients (n,) at contact points, which are those `kept` of the points of `patches`."""
        numbers = None if kept is None else kept.numbers
        return friction_field(self._on(patches, self.friction), points.points, patches, velocity, numbers)

    def pull_at(
        self, points: ContactPoints, patches: tuple[Patch, ...], kept: Kept | None = None, **given: Any
    ) -> Array:
        """Magnetic pressure (n,) [Pa] at contact points, as :meth:`friction_at`.

        With `magnetic_pressure` or `velocity` in place of the scene's.
        """
        spec = given.get("magnetic_pressure", self.magnetic_pressure)
        velocity = given.get("velocity", self.velocity)
        return magnetic_field(self._on(patches, spec), points, patches, velocity, kept)

    def _on(self, patches: tuple[Patch, ...], spec: Any) -> Any:
        """Values given at the cells or nodes of the scene's own grid, carried to the nearest of `patches`."""
        form = as_form(spec)
        if not form.has_arrays:
            return spec
        own = self.geometry.grid(self.known_spacing)
        return form.carried([(given, patches) for given in (patches, own.patches, own.node_patches)])

    def on_cells(self, spacing: tuple[float, float]) -> Self:
        """The same scene on other cells, to which fields given on its own grid are carried."""
        changes: dict[str, Any] = {"spacing": spacing}
        given = ["friction", "magnetic_pressure", "hardness"]
        given += ["normal_layer"] if self.rough is None else []
        fields = {name: as_form(getattr(self, name)) for name in given}
        if any(form.has_arrays for form in fields.values()):
            own, other = self.geometry.grid(self.known_spacing), self.geometry.grid(spacing)
            choices = [(own.patches, other.patches), (own.node_patches, other.node_patches)]
            changes |= {name: form.carried(choices) for name, form in fields.items() if form.has_arrays}
        return self.with_(**changes)

    def _pressed(self, upper: Side, contact: Contact, load: Array, loads: dict[str, Any]) -> Side:
        """A body above that nothing holds: each patch is free to approach on its own, under its share of the
        load and of its moments. Without a load it rests, as one below does."""
        patches, n = contact.patches, contact.area.size
        motions, modes, work, is_pulled, shares = [], [], [], [], []
        for patch in patches:
            here = np.ones(n)
            if len(patches) > 1:
                here[:] = 0.0
                here[patch.cut] = 1.0
            middle = contact.middle(patch)
            if self.force is not None or self.magnetic_pressure is not None:
                share = float(load[2] @ here) if self.force is None else -self.force / len(patches)
                if contact.kept is None and -share < 1.0 / LARGEST:
                    what = "force" if self.force is not None else "magnetic_pressure"
                    raise ValueError(
                        f"{what} loads patch {patch.name!r} with {share:.6g} N along z: it does not press "
                        f"the bodies together ({what} must be positive)"
                    )
                zero = np.zeros(n)
                motions.append(np.stack([zero, zero, here]))
                modes.append([0.0, 0.0, 1.0, 0.0, 0.0, 0.0, *middle])
                # what the pull works is added where it is applied
                work.append(0.0 if self.force is None else share)
                is_pulled.append(True)
                shares.append(share)
            if self.moments is not None:
                motions.extend(tilts(contact.places - middle[:, None]) * here)
                modes.extend([[0.0, 0.0, 0.0, *turn, 0.0, *middle] for turn in ((1.0, 0.0), (0.0, 1.0))])
                work.extend(float(m) / len(patches) for m in self.moments)
                is_pulled.extend([False, False])
        if shares:
            loads["pull"] = np.array([0.0, 0.0, float(sum(shares))])
        return replace(
            upper,
            motions=np.array(motions).reshape(-1, 3, n),
            modes=np.array(modes).reshape(-1, 9),
            work=np.array(work),
            is_pulled=np.array(is_pulled, dtype=bool),
        )

    def check_touching(self, is_touching: bool, points: ContactPoints, loads: Mapping[str, Any]) -> None:
        """ValueError where the bodies do not touch under the load of the scene."""
        if is_touching or as_form(self.magnetic_pressure).follows_gap:
            # that a magnet does not bring the bodies together is an answer
            return
        if self.own_model is not None:
            raise ValueError(self._why_apart(points, loads))
        raise ValueError(
            f"the bodies never touch: approach is {self.approach!r} m, the smallest gap is "
            f"{float(points.gap.min()):.6g} m"
        )

    def check_edge(self, patches: tuple[Patch, ...], pressure: Array) -> None:
        """ValueError where the edge of a grid cuts the contact off; `pressure` (n,) at all of its points."""
        if self.geometry.is_body_edge:
            return
        for patch in patches:
            p = patch.view(pressure) > 0.0
            if p[0].any() or p[-1].any() or p[:, 0].any() or p[:, -1].any():
                raise ValueError(
                    f"the contact reaches the edge of the grid of {patch.nx} x {patch.ny} points, but the "
                    f"bodies go on beyond it: {self.geometry.looks_like or self.geometry.wider(patch)}"
                )

    def told(self) -> list[Row]:
        """What it states, in words: what a notebook shows."""
        said = self.statement()
        return stated(said, {name: unit_of_argument(name) for name in said})

    def _repr_png_(self) -> bytes:
        """Its bodies cut across, for notebooks."""
        from ..pictures import draw_section, own_figures  # brings matplotlib

        with own_figures():
            return png(draw_section(self.geometry.surfaces()))

    def statement(self) -> dict[str, Any]:
        """What is stated: the arguments of a ready scene and what was changed besides, or all fields of a
        scene of one's own. Functions are told by name and digest."""
        is_ready = self.recipe is not None
        untold = _MADE | _IN_ARGUMENTS if is_ready else _MADE
        said = {
            f.name: getattr(self, f.name)
            for f in fields(self)
            if f.compare and f.name not in untold and f.name not in self.inputs
        }
        default = {f.name: f.default for f in fields(self)}
        said = {
            name: value
            for name, value in said.items()
            if not (value is None or (is_ready and same(value, default[name])))
        }
        given = {**self.inputs, **said}
        return {"scene": self.name, **{name: without_functions(value) for name, value in given.items()}}

    @renamed(layout="geometry")
    def with_(self, **changes: Any) -> Self:
        """The same scene with some arguments changed: of :class:`Scene`, or of the ready scene that it is.

        A ready scene is made anew, so that everything that depends on an argument is updated. For example the
        grid of a paraboloid depends on its force, and the contact plane of a wheel on its vertical force.
        """
        words = [*self.inputs, *(f.name for f in fields(self) if f.name not in ("inputs", "recipe"))]
        words += [] if self.recipe is None else inspect.signature(self.recipe[0]).parameters
        for name in changes:
            if name not in words:
                hint = in_place(name, words)
                raise TypeError(f"with_({name}=...): a {self.name or 'scene'} has no {name}; {hint}")
        asked = of_scene(self.upper, self.lower, self.magnetic_pressure)
        with gathered() as found:
            made = self._changed(changes, asked)
        ask(found, asked)
        return made

    def _changed(self, changes: dict[str, Any], asked: list[str]) -> Self:
        """What :meth:`with_` returns; questions that its scene has been asked come to `asked`."""
        if self.recipe is None:
            return replace(self, **changes)
        build, given = self.recipe
        known = inspect.signature(build).parameters
        # nothing in place of what the ready scene must have, as force=None beside an approach
        nothing = {k for k, v in changes.items() if v is None and k in known and known[k].default is not None}
        optional = nothing & _OPTIONAL
        anew = {k: v for k, v in changes.items() if k in known and k not in nothing - optional}
        with gathered() as found:
            before = build(**given)
        asked += found
        made: Self = build(**{**given, **anew})
        followed = {_FOLLOWS[k] for k in anew if k in _FOLLOWS}
        kept = {
            f.name: getattr(self, f.name)
            for f in fields(self)
            if f.name not in _MADE | followed | set(changes)
            and not same(getattr(self, f.name), getattr(before, f.name))
        }
        others = {k: v for k, v in changes.items() if k not in anew}
        inputs = {k: v for k, v in made.inputs.items() if k not in others}
        return replace(made, **{**kept, **others, "inputs": inputs})


#: Fields of a ready scene that follow from its arguments, whatever these are.
_IN_ARGUMENTS = {"gap", "spacing", "upper", "lower"}


#: Fields of a ready scene that follow from its arguments; arguments of ready scenes that give another field;
#: and those that may be None though they are something by default.
_MADE = {"geometry", "inputs", "name", "recipe"}


_FOLLOWS = {"points": "spacing", "width": "spacing"}


_OPTIONAL = {"points", "spacing", "sliding_direction"}


def gap_field(gap: ArrayLike | None) -> Array:
    """A gap (ny, nx) [m] as floats, checked."""
    if gap is None:
        raise ValueError("gap is missing: a height field (ny, nx) [m] is needed")
    values = frozen(reals("gap", gap, "m"))
    if values.ndim != 2 or min(values.shape) < 3:
        raise ValueError(f"gap has shape {values.shape}: (ny, nx) with at least 3 points a side is needed")
    return values


def tilts(arm: Array) -> Array:
    """Displacement (2, 3, n) by unit rotations about x and y, of points at `arm` (3, n) from the axes."""
    zero = np.zeros(arm.shape[1])
    return np.array([[zero, -arm[2], arm[1]], [arm[2], zero, -arm[0]]])
