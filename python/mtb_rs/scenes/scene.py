# SPDX-License-Identifier: MIT OR Apache-2.0
"""Scenes: two bodies, their gap, their load, their friction."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, Literal, cast

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..base.check import choice, flag, one_or_two, warn
from ..base.errors import ToleranceWarning
from ..base.plain import plain
from ..base.renamed import renamed
from ..base.words import Method, Model, Pressing, Quantity, Wheels
from ..bodies.conductor import Conductor, conducting_steel
from ..contact.problem import ContactProblem, Kept
from ..contact.sliding_heat import SlidingHeat
from ..contact.sliding_start import (
    StartOfSliding,
)
from ..friction.fields import Coefficients, FixedFriction
from ..friction.laws import (
    Friction,
    InterfaceLayer,
    RailFriction,
    coefficient_from_rest,
    law_of,
)
from ..friction.wear_laws import Rubbing, WearLaw
from ..geometry.contact_points import ContactPoints, Patch
from ..geometry.geometries import WheelOnRail
from ..geometry.profiles import Profile
from ..geometry.slices import RailSlices, WheelSlices
from ..results.chart import Chart
from ..results.result import Result
from . import heating, methods
from .auto import TOLERANCE
from .cost import ExpectedCost, expected
from .direct import choose
from .posed import PosedScene

Array = NDArray[np.float64]

if TYPE_CHECKING:
    from ..simulation.stepping import PreparedContact
    from ..simulation.wheel_stepping import PreparedWheels


@renamed(layout="geometry")
@dataclass(frozen=True)
@plain
class Scene(PosedScene):
    """Two bodies pressed together, the upper one sliding over the lower one.

    Exactly one of `force`, `approach` and `magnetic_pressure` presses them together.

    Parameters
    ----------
    upper, lower : Material, HalfSpace, Layered, Rigid, ElasticBody; below also Prism
        A material means a half-space of this material. A Viscoelastic is taken where the scene rolls: by case
        files with ``[rolling]`` and by :func:`mtb_rs.sweep` with a motion. With an elastic body the grid
        covers its contact face.
    gap : (ny, nx) [m] or function
        Undeformed gap on a regular grid, x fastest; > 0 is open. With an elastic body it is given at the
        nodes of the grid, or as a function of arrays x, y (n,) [m] that is infinite where there is no
        opponent. By default it is the distance along z of the body's face from the other body, in the
        position in which the two are given. The other body's face is that of an `ElasticBody`, the surface of
        ``HalfSpace(material, surface)`` or ``Rigid(surface)``, or the plane through the end of the first
        face. Pressure then acts along z, so faces may be curved, but must not be steep where they touch.
    spacing : float or (dx, dy) [m], or None
        Size of the cells. None is for ready scenes: :meth:`solve` then chooses it by the tolerance.
    friction : float, array, function or table [-]
        Friction coefficient: a number; an array (n,) or (ny, nx) over the contact grid, x fastest; a function
        ``f(x, y)`` of arrays (n,) [m] that returns an array (n,) or a number; a :class:`mtb_rs.FieldTable`
        over x and y or a :class:`mtb_rs.VelocityTable` over the velocity, both also `from_file`; of two poles
        also a list ``[left, right]`` of these; or one :class:`mtb_rs.PressureDependentFriction` for all
        points.
    sliding_direction : (x, y) or None
        Motion of the upper body over the lower one. None: nothing slides, and there is no friction.
    force : float [N]
        Force > 0 that presses the bodies together along z, through the middle of the grid. On an elastic
        upper body it is distributed like weight, and supports that hold z take their share.
    approach : float [m]
        Distance > 0 by which the bodies are moved together.
    moments : (mx, my) [N m]
        Moments on the upper body about the x and y axis. Like the force they are those of the whole scene: of
        two poles each takes half of them, about the axes through the middle of its patch. For half-spaces and
        rigid bodies they are the moments of the load; the tilts are then free, and otherwise they are locked.
        For elastic upper bodies they act in addition to the load and are distributed over the body like
        inertia forces; the tilts that the supports do not hold are free.
    magnetic_pressure : float, array, function, table [Pa] or Magnet
        Attraction of the upper body by the lower one along the local normal, as force over nominal area: in
        the forms of `friction`, a :class:`mtb_rs.GaussianPressure`, or a :class:`mtb_rs.Magnet`, whose pull
        follows the gap. Functions, hills and tables are evaluated at the contact points, so narrow cells
        integrate a field that varies better. A number is no Maxwell stress: 3e6 is the force of the whole
        pole over its contact area. Across an open gap it would take 2.75 T (``B**2 / (2 mu_0)``), but iron
        saturates at about 2.16 T, which gives 1.86e6 Pa on the area of the iron.
    attraction : "upper" or "both"
        Which bodies the magnetic pressure acts on.
    velocity : float [m/s]
        Sliding speed, >= 0, the argument of quantities that are tabulated over the velocity. The direction is
        that of `sliding_direction`; only steps of a prepared contact take a negative velocity, for backwards.
    layer : InterfaceLayer or PlasticLayer
        A third body that shears between the two. Its stiffness changes nothing in gross sliding, and it
        softens the start of sliding; see :meth:`start_of_sliding`. The yield stress of a PlasticLayer bounds
        the friction: a point that slides has the traction ``min(mu p, yield_stress)``. Sliding goes on and
        on, so that it takes no PlasticLayer that hardens or softens; a shift and rolling do. The start of
        sliding, wheels in steps, convolutions and the methods of the thesis take an InterfaceLayer only.
    normal_layer : float, array, function, table, ThinLayer or RoughLayer [m/Pa]
        A third body that gives way under the pressure: each point by this flexibility times its own pressure,
        or by the law of a :class:`mtb_rs.RoughLayer`, whose first touch the gap then counts from.
        It belongs to neither body, so displacements are without it, and the approach with it. Wheels in
        steps, Hertz' closed form, convolutions (large grids are then solved by dense matrices or refused) and
        the methods of the thesis do not take it. The start of sliding takes a flexibility, and no RoughLayer.
    hardness : float, array, function or table [Pa]
        Pressure at which the softer body flows, some three times its yield stress. The pressure stays below
        it, the contact grows instead, and friction is that of this pressure. What the flow piles up around
        the contact, and its hardening, are left out. The ways that do not take `normal_layer` do not take it
        either, nor does the start of sliding.
    supports : str or sequence of Support
        Supports of the elastic bodies of block_on_plane and pole_shoe_on_rail. The half-space model has no
        top and ignores them.
    element_size : float [m]
        Size of the finite elements of their upper body at the contact; None: the spacing of the contact grid.
    geometry, name, inputs
        Geometry, name and arguments of a ready scene. Scenes of one's own are made without these; their
        geometry then follows from their gap and bodies: contact points at any spacing, models, surfaces.
    recipe : (function, arguments) or None
        The function of :mod:`mtb_rs.scenes` that made the scene, and all arguments that it was given.
    """

    def solve(
        self,
        model: Model = "auto",
        method: Method = "direct",
        tolerance: float | None = None,
        quantity: Quantity = "pressure",
        **options: Any,
    ) -> Result:
        """Solves the contact.

        Warns with :class:`mtb_rs.ToleranceWarning` if the estimated error exceeds the tolerance, and names
        the cells that would meet it. If no tolerance is given, the warning comes above 1.5 times 0.05.

        Parameters
        ----------
        model : "auto", "half-space", "elastic-upper", "elastic-lower" or "elastic-both"
            Which bodies are modelled as elastic. The bodies of a scene with an ElasticBody determine its
            model; give "auto" or the name of that model. With "auto" a layer, a hardness or a magnet is left
            out where it changes the quantity less than the tolerance; `report.notes` says by how much.
        method : "direct", "incremental" or "staggered"
            The algorithm. The latter two are those of the thesis and take its parameters as `options`.
        tolerance : float or None [-]
            Wanted total relative error of `quantity`; None: 0.05.
        quantity : "pressure", "force" or "displacement"
            The quantity whose error the tolerance bounds.
        **options
            Options of the incremental method: `estimated_steps`, `force_tolerance` [N], `distance_tolerance`
            [m], `max_resolutions`, `max_releases`, `max_increments`. Options of the staggered method:
            `factor` (f_FE), `max_iterations`, `displacement_tolerance` [-], `anderson_depth`.

        Raises
        ------
        ValueError
            If something cannot be as stated.
        ConvergenceError
            If no solution exists or none was found; the last state is its `result`.
        """
        self.ask_of_places()
        result = methods.solve(
            self, model=model, method=method, tolerance=tolerance, quantity=quantity, **options
        )
        if result.report.missed:
            warn(result.report.missed, ToleranceWarning)
        return result

    def expected_cost(
        self,
        model: Model = "auto",
        method: Method = "direct",
        tolerance: float | None = None,
        quantity: Quantity = "pressure",
        **options: Any,
    ) -> ExpectedCost:
        """What :meth:`solve` would take with the same arguments, without solving.

        The contact points and the unknowns of the finite elements are exact, because the grids and meshes of
        the solve are made. Memory and time are estimates: the real ones are mostly within a factor of two.
        With ``model="auto"`` every model that may be chosen is counted, and with ``spacing=None`` the first
        cells. Of ``method="incremental"`` and ``"staggered"`` one pass is counted; the number of passes is
        known only after the solve.

        Raises
        ------
        ValueError
            If :meth:`solve` would refuse the scene or the arguments.
        """
        methods.check_options(model=model, method=method, tolerance=tolerance, quantity=quantity, **options)
        self.ask_of_places()
        return expected(self, methods.model_of(self, model, method), method, tolerance, quantity)

    def start_of_sliding(
        self,
        displacements: ArrayLike,
        model: Model = "auto",
        tolerance: float = 1e-8,
        pressure: Pressing = "follows",
    ) -> StartOfSliding:
        """Follows the contact from rest to full sliding: which points stick and which slip.

        The bodies start at rest without friction. Pressure and friction are then solved together at each
        step, and the final state is the gross sliding of :meth:`solve`. Above the wedging limit there is no
        gross sliding: a body that is held from above jams, and both forces grow with the displacement until
        no state is found. A warning says so.

        Parameters
        ----------
        displacements : (m, 2) [m]
            Displacements of the upper body over the lower one along x and y at the end of each step, counted
            from rest. Friction depends on the way, so each step is followed in parts, twice as many of them
            until the error that the step adds to the tractions is estimated at 0.1 % of the friction or less
            (`path_error` of the result). The states therefore do not depend on the number of steps. The
            method itself is of first order.
        model : "auto", "half-space", "elastic-upper" or "elastic-both"
            "auto" takes the elastic upper body where there is one.
        tolerance : float [-]
            Relative residual of each step.
        pressure : "follows" or "held"
            "held" keeps the pressure of the state at rest and locks every rigid motion. This is cheaper, and
            it is right for like half-spaces only.
        """
        self.ask_of_places()
        return methods.slide_from_rest(self, displacements, model, tolerance, pressure)

    def sliding_heat(
        self,
        duration: float,
        steps: int = 60,
        velocity: float | Callable[[float], float] | None = None,
        *,
        lower: Conductor = conducting_steel,
        upper: Conductor = conducting_steel,
        bulk: tuple[float, float] = (0.0, 0.0),
        film: tuple[float, float] = (0.0, 0.0),
        resistance: float = 0.0,
        share: float = 0.5,
        expansion: bool = False,
        wear: WearLaw | float | Callable[[Rubbing], Any] | None = None,
        lower_wear: WearLaw | float | Callable[[Rubbing], Any] | None = None,
        fading: tuple[ArrayLike, ArrayLike] | None = None,
        tolerance: float | None = None,
        model: Model = "auto",
        progress: Callable[[float], Any] | Literal[True] | None = None,
    ) -> SlidingHeat:
        """Heats the bodies by friction while they slide, and lets them expand and wear.

        The upper body conducts heat on its own finite elements. The lower one is a half-space that passes
        below it and comes back cold, as a rail does. Where both touch they have one temperature, which
        divides the heat of friction between them. Steps are implicit and of first order in the time. With
        `expansion` and `wear` each step is one contact problem: heat opens and closes the gap in the same
        step, and wear is a diagonal compliance in it. Friction that fades is that at the temperature of its
        own step; friction and coefficients of wear follow the pressure of the step before, and material data
        its temperature. What lies below the contact keeps the heat of the steps in which it came there.

        Above the thermal limit (:attr:`SlidingHeat.thermal_margin` above 1), which brakes on rails exceed
        many times, uneven pressure grows by its own heat. What bounds it is the time, a resistance and wear;
        without these, hot spots wander and no length of the steps may converge.

        Parameters
        ----------
        duration : float [s]
        steps : int
            Steps of equal length over it. The temperature just after the beginning needs short ones.
            With a tolerance none is longer.
        velocity : float or function [m/s]
            Speed of sliding, or a function of the time [s] that gives it; None for that of the scene.
        lower, upper : Conductor
        bulk : (float, float) [K]
            Temperatures at the beginning, over any common level: of the lower body wherever it comes from,
            and of the upper one.
        film : (float, float) [W/K/m2, K]
            Heat transfer coefficient of the surface of the upper body outside its contact face, and the
            temperature around it.
        resistance : float [K m^2/W]
            Of the contact to heat.
        share : float [-]
            Share of the heat that arises on the upper side of the resistance.
        expansion : bool
            Whether heat expands the bodies, by the coefficients of their conductors. The upper body does
            on its elements; the lower one swells by the skin of heat that passes.
        wear, lower_wear : WearLaw, float [1/Pa] or function
            Laws of wear of both bodies, as of :func:`mtb_rs.wear`. The wear of the upper body stands in its
            gap. Each place of the lower one is passed once, so that its wear is counted and opens no gap.
        fading : (temperatures, factors) [K], [-]
            Factors on the friction over the mean temperature of both surfaces at the end of the step, linear
            between the entries and constant beyond them.
        tolerance : float or None
            Error of each step (:attr:`SlidingHeat.errors`) by which their lengths are chosen; None: they are
            equal.
        model : "auto", "elastic-upper" or "elastic-both"
            "auto" is "elastic-upper".
        progress : function, True or None
            Called with the share that is done; True shows a bar.

        Raises
        ------
        ValueError
            For bad input, and without an elastic upper body.
        ConvergenceError
            If a step has no solution.
        """
        self.ask_of_places()
        return heating.heat(
            self,
            duration,
            steps,
            velocity,
            lower=lower,
            upper=upper,
            bulk=bulk,
            film=film,
            resistance=resistance,
            share=share,
            expansion=expansion,
            wear=wear,
            lower_wear=lower_wear,
            fading=fading,
            tolerance=tolerance,
            model=model,
            progress=progress,
        )

    def prepare(
        self,
        model: Model = "auto",
        *,
        reference_point: ArrayLike | None = None,
        standstill_speed: float | None = None,
        tolerance: float | None = None,
        quantity: Quantity = "force",
        friction: float | Friction | RailFriction | None = None,
        layer: InterfaceLayer | None = None,
        side: Wheels | None = None,
        rail_stiffness: ArrayLike | None = None,
        rail_force: ArrayLike | None = None,
        conformal: bool | None = None,
        order: int | None = None,
        right_wheel: str | Profile | WheelSlices | None = None,
        right_rail: str | Profile | RailSlices | None = None,
        right_wheel_radius: float | None = None,
        right_friction: float | Friction | RailFriction | None = None,
    ) -> PreparedContact:
        """Prepares the contact for a simulation, so that each step has little left to compute.

        A sliding contact becomes a :class:`mtb_rs.PreparedContact`, whose compliances are condensed. A wheel
        on a rail (:class:`mtb_rs.WheelScene`) becomes :class:`mtb_rs.PreparedWheels`, whose steps place the
        profiles, find the contact and solve rolling.

        Parameters
        ----------
        model : "auto", "half-space", "elastic-upper" or "elastic-both"
            Wheels are half-spaces.
        reference_point : (x, y, z) [m]
            Reference point of the moments and rotations of the steps; None: (0, 0, 0), and for wheels the
            middle of the axle.
        standstill_speed : float [m/s]
            At rest friction has no direction, so a step at rest is an error by default. Below this speed the
            friction coefficients (of wheels: the creepages) fall to zero in proportion to the speed. This is
            a regularisation and not physics: a real brake sticks, as steps with a `shift` do.
        tolerance, quantity
            Tolerance of ``model="auto"``, as in :meth:`solve`. If a tolerance is given, the scene is solved
            once, and a :class:`mtb_rs.ToleranceWarning` comes if its estimated error is larger. (A model that
            is given by name has no estimate, unless bodies of your own provide one.) None: 0.05 for the
            choice of the model, and no estimate is made; `report.error_estimates` of :meth:`solve` gives it.
            Steps make no estimates.
        friction : float, Coulomb, StaticKinetic, FallingFriction, TabulatedFriction or RailFriction
            Friction of wheels; None: the `friction` of the scene. A RailFriction varies over the rail, and a
            TemperatureFriction with the temperature of the contact.
        layer : InterfaceLayer
            Layer between wheel and rail; None: the `layer` of the scene.
        side : "left", "right" or "both"
            Which wheels of the wheelset; None: the left one.
        rail_stiffness : (lateral, vertical) [N/m]
            Springs without mass under each rail, which moves under the forces of its wheel; infinity in a
            direction in which it does not. None: rails stay where they are.
        rail_force : (outwards, upwards) [N]
            What acts on each rail on its springs besides its wheel; None: nothing.
        conformal : bool
            Whether the patches of wheels follow the surface of the rail, each row of cells with a normal of
            its own, in place of a plane (None, False). It is for contacts that no plane holds, such as the
            root of a flange on a worn gauge corner, between like bodies on straight rails without slices.
        order : {1, 2}
            Order of the errors of rolling wheels in the size of the cells, as of :class:`mtb_rs.Rolling`.
            None, 1: as in CONTACT, with which fields agree cell by cell. With 2, forces and heat are as good
            on cells three to eight times as large, and depend much less on where the cells lie.
        right_wheel, right_rail : str, Profile or slices
        right_wheel_radius : float [m]
            Of the right wheel and its rail, where they differ from those of the scene, given like left ones,
            as seen in a mirror: gauge side and flange at y < 0. A switch has slices on one side, and wheels
            of one axle wear apart. None: those of the scene.
        right_friction : as `friction`
            Of the right wheel, where it differs: one rail may be wet, and one flange greased.
        """
        choice("model", model, Model)
        choice("quantity", quantity, Quantity)
        from ..simulation.stepping import at_some_speed, prepare

        of_wheels = {
            "friction": friction, "layer": layer, "side": side,
            "rail_stiffness": rail_stiffness, "rail_force": rail_force, "conformal": conformal,
            "right_wheel": right_wheel, "right_rail": right_rail, "right_wheel_radius": right_wheel_radius,
            "right_friction": right_friction, "order": order,
        }  # fmt: skip
        for name, value in of_wheels.items():
            if value is not None:
                raise ValueError(f"{name} is for wheels on rails: a sliding contact has that of its scene")
        self.check_model(model)
        self.ask_of_places()
        if tolerance is not None:
            _ = self.known_spacing
            model = self._judged(at_some_speed(self), model, tolerance, quantity)
        elif model == "auto":
            model = choose(at_some_speed(self), TOLERANCE, quantity).model
        origin = (0.0, 0.0, 0.0) if reference_point is None else reference_point
        return prepare(self, model, origin, standstill_speed)

    def _judged(self, scene: PosedScene, model: Model, tolerance: float, quantity: Quantity) -> Model:
        """The model that `scene`, this one at some speed, is solved in; warns of a missed tolerance."""
        found = methods.solve(scene, model=model, tolerance=tolerance, quantity=quantity)
        if found.report.missed:
            warn(found.report.missed, ToleranceWarning)
        return cast("Model", found.report.model)

    def chart(
        self,
        quantity: Quantity = "pressure",
        budget: float = 60.0,
        repeats: int = 3,
        progress: Callable[[float, str], None] | Literal[True] | None = None,
    ) -> Chart:
        """Speed against accuracy of every model and method that applies, at several resolutions.

        Errors are measured against a closed form where the scene has one, otherwise against the finest
        solve of the fullest model that 0.4 of the budget affords, whose own error is estimated.

        Parameters
        ----------
        quantity : "pressure", "force" or "displacement"
            Which error is drawn; all are kept.
        budget : float [s]
            Elapsed time to spend: no further solve is begun that is expected to exceed it. The reference
            takes two of its widest cells, and each series one, however long these take.
        repeats : int
            Solves of each point at most; the median of their times counts.
        progress : callable or True
            Called with the share that is done and the name of the current solve. True shows a bar, on the
            terminal or in a notebook (extra ``notebook``).

        Raises
        ------
        ConvergenceError
            If the fullest model has no solution, so that there is no reference for the other ones.
        """
        from ..base.progress import shown
        from ..studies.chart_scene import chart

        choice("quantity", quantity, Quantity)
        with shown(progress, "charting") as told:
            return chart(self, quantity=quantity, budget=budget, repeats=repeats, progress=told)


class WheelScene(Scene):
    """A wheel on a rail, as :func:`mtb_rs.scenes.wheel_on_rail` makes it: :meth:`prepare` gives wheels."""

    geometry: WheelOnRail

    def prepare(  # type: ignore[override]
        self,
        model: Model = "auto",
        *,
        reference_point: ArrayLike | None = None,
        standstill_speed: float | None = None,
        tolerance: float | None = None,
        quantity: Quantity = "force",
        friction: float | Friction | RailFriction | None = None,
        layer: InterfaceLayer | None = None,
        side: Wheels | None = None,
        rail_stiffness: ArrayLike | None = None,
        rail_force: ArrayLike | None = None,
        conformal: bool | None = None,
        order: int | None = None,
        right_wheel: str | Profile | WheelSlices | None = None,
        right_rail: str | Profile | RailSlices | None = None,
        right_wheel_radius: float | None = None,
        right_friction: float | Friction | RailFriction | None = None,
    ) -> PreparedWheels:
        """As :meth:`Scene.prepare`. Wheels have only one model, and the cells of the scene.

        The usual spacing of 0.1 mm is made for one solution. Of 60 kN on the tread, steps on cells of 0.5 mm
        take less than a tenth of the time, with creep forces within 1.2 % of friction coefficient times
        normal force and the peak pressure within 0.2 %. A given tolerance applies to the normal contact in
        the position of the scene.
        """
        from ..simulation.wheel_stepping import prepare_wheels

        choice("model", model, Model)
        choice("quantity", quantity, Quantity)
        self.check_model(model)
        for name in ("hardness", "normal_layer"):
            if getattr(self, name) is not None:
                raise ValueError(
                    f"{name} is given, and prepared wheels have none: solve() and rolling after it take it, "
                    f"or prepare a scene without {name}"
                )
        if tolerance is not None:
            self._judged(self, model, tolerance, quantity)
        return prepare_wheels(
            self,
            self.geometry,
            side or "left",
            law_of(self.friction if friction is None else friction),
            self.layer if layer is None else layer,
            reference_point,
            standstill_speed,
            rail_stiffness,
            rail_force,
            conformal is not None and flag("conformal", conformal),
            order is not None and one_or_two("order", order) == 2,
            (right_wheel, right_rail, right_wheel_radius, law_of(right_friction)),
        )

    def _friction(
        self, points: ContactPoints, patches: tuple[Patch, ...], kept: Kept | None = None
    ) -> Coefficients:
        # pressed and not moved; the law is that of the rolling to come
        if self.sliding_direction is None:
            return FixedFriction(np.zeros(points.gap.size))
        return super()._friction(points, patches, kept)

    def friction_from_rest(self, problem: ContactProblem, pressure: Array) -> Array:
        """As of other scenes, of a law whose coefficient does not depend on slip or place."""
        coefficient = coefficient_from_rest(self.friction)
        sliding = Scene._friction(
            replace(self, friction=coefficient, sliding_direction=(1.0, 0.0)),
            problem.points,
            problem.patches,
            problem.kept,
        )
        return sliding.at(pressure)
