# SPDX-License-Identifier: MIT OR Apache-2.0
"""Ready scenes, in which every argument has a default.

Arguments that are not described are those of :class:`mtb_rs.Scene`.
"""

from __future__ import annotations

import inspect
from collections.abc import Callable, Mapping, Sequence
from dataclasses import fields
from numbers import Real
from typing import Any, TypeVar

import numpy as np

from ..base.check import in_place, positive
from ..base.owning import owned
from ..base.questions import ask, unusual
from ..base.units import ARGUMENT_UNITS, in_si
from ..base.words import Attraction, Held
from ..bodies.material import Material, steel
from ..bodies.prism import Prism
from ..bodies.simple import Simple, as_body
from ..bodies.supports import Support
from ..friction.laws import Coulomb, InterfaceLayer, PlasticLayer
from ..geometry.contact_points import spacing_pair
from ..geometry.geometries import BlockOnPlane, ParaboloidOnPlane, ShoeOnRail, WheelOnRail
from ..geometry.pole_shoe import PoleShoe
from ..geometry.profiles import Profile
from ..geometry.slices import RailSlices, WheelSlices, nominal_of
from ..geometry.wheel_rail import of_wheel, wheel_on_rail_gap
from .scene import Scene, WheelScene

#: Lengths [m] that shoes and blocks have.
USUAL_SHOE = {
    "height": (1e-3, 0.5),
    "length": (5e-3, 3.0),
    "outer_edge": (0.0, 0.3),
    "lateral": (-0.1, 0.1),
    "rail_length": (5e-3, 100.0),
}
USUAL_BLOCK = dict.fromkeys(("width", "length", "height"), (0.0, 20.0))

#: Thesis Table 3.1: contact radius of its paraboloid [m], for which its grids span 1 m.
_THESIS_RADIUS = float(np.cbrt(0.75 * 5e6 * 1000.0 / (0.5 * steel.plane_strain_modulus)))

F = TypeVar("F", bound=Callable[..., Scene])


def _those_of(made: type, arguments: Mapping[str, Any]) -> dict[str, Any]:
    """The arguments of a ready scene that a dataclass has as fields."""
    return {f.name: arguments[f.name] for f in fields(made) if f.name in arguments}


def _scene(build: F) -> F:
    """Keeps the arguments of a ready scene, for its summary and for scenes that differ in one of them."""
    signature = inspect.signature(build)

    def wrapped(*args: Any, **kwargs: Any) -> Scene:
        known = signature.parameters
        if unknown := [name for name in kwargs if name not in known]:
            raise TypeError(f"{build.__name__} has no {unknown[0]}; {in_place(unknown[0], known)}")
        try:
            bound = signature.bind(*args, **kwargs)
        except TypeError as error:
            raise TypeError(f"{build.__name__}: {error}") from None
        bound.apply_defaults()
        given = {
            name: in_si(name, value, ARGUMENT_UNITS.get(name)) for name, value in bound.arguments.items()
        }
        scene = build(**given)
        arguments = owned(given)
        object.__setattr__(scene, "recipe", (wrapped, arguments))
        stated = {k: v for k, v in arguments.items() if v is not None}
        object.__setattr__(scene, "inputs", owned({**scene.inputs, **stated}))
        return scene

    for name in ("__name__", "__qualname__", "__doc__", "__module__"):
        setattr(wrapped, name, getattr(build, name))
    wrapped.__signature__ = signature  # type: ignore[attr-defined]
    wrapped.__annotations__ = build.__annotations__
    return wrapped  # type: ignore[return-value]


@_scene
def paraboloid_on_plane(
    radius: float = 1000.0,
    force: float = 5e6,
    friction: Any = 0.5,
    points: int | None = 34,
    *,
    width: float | None = None,
    sliding_direction: tuple[float, float] | None = (1.0, 0.0),
    upper: Material | Simple = steel,
    lower: Material | Simple = steel,
    hardness: Any = None,
) -> Scene:
    """A paraboloid pressed on a plane, sliding over it: thesis 3.1.1, Hertz' problem.

    Parameters
    ----------
    radius : float [m]
        Radius of curvature at the tip.
    force : float [N]
        Presses the paraboloid down.
    friction : float, array, callable [-]
        Coefficient of the sliding.
    points : int or None
        Points along each side of the grid; None: :meth:`Scene.solve` chooses them by the tolerance.
    width : float [m]
        Distance between the outermost points; by default 3.12 contact radii, for the default
        arguments the thesis' 1 m.
    sliding_direction : (x, y) or None
        Of the upper body over the lower one; None: it does not slide.
    upper, lower : Material, HalfSpace, Layered or Rigid
        The bodies above and below.
    hardness : float, array, callable or table [Pa]
        Upper bound on the pressure, where the softer body flows; None: there is none. The default `width` is
        that of an elastic contact.
    """
    given = _those_of(Scene, locals())
    radius, force = positive("radius", radius, "m"), positive("force", force, "N")
    whole = isinstance(points, (int, np.integer)) and not isinstance(points, bool)
    if points is not None and (not whole or points < 4):
        raise ValueError(f"points is {points!r}: a whole number from 4 on, or None, is needed")
    if width is None:
        compliance = _compliance(upper, lower)
        width = float(np.cbrt(0.75 * force * radius * compliance)) / _THESIS_RADIUS
    width = positive("width", width, "m")
    return Scene(
        **given,
        spacing=None if points is None else width / (points - 1),
        geometry=ParaboloidOnPlane(radius, width),
        name="paraboloid_on_plane",
    )


@_scene
def block_on_plane(
    width: float = 0.1,
    height: float = 0.1,
    friction: Any = 0.5,
    magnetic_pressure: Any = 3e6,
    spacing: float | Sequence[float] | None = 5e-3,
    *,
    length: float | None = None,
    supports: Held | Sequence[Support] = "clamped-top",
    attraction: Attraction = "upper",
    sliding_direction: tuple[float, float] | None = (1.0, 0.0),
    velocity: float | None = None,
    upper: Material | Simple = steel,
    lower: Material | Simple | Prism = steel,
    layer: InterfaceLayer | PlasticLayer | None = None,
    normal_layer: Any = None,
    hardness: Any = None,
) -> Scene:
    """A block sliding over a plane, its top held in y and z: thesis 3.2.1.

    Parameters
    ----------
    width, height, length : float [m]
        Along x, along z, and along y (by default the width).
    friction : float, array, callable, table [-]
        Coefficient of the sliding.
    magnetic_pressure : float, array, callable, table [Pa] or Magnet
        Attracts the foot of the block.
    spacing : float or (dx, dy) [m], or None
        None: :meth:`Scene.solve` chooses it by the tolerance.
    supports : "driven-top", "clamped-top", "points", "fixed-points" or a list of Support
        How the top of an elastic block is held; a half-space has no top.
    attraction : "upper" or "both"
        Whether the plane is attracted as well.
    velocity : float [m/s]
        For tables over the velocity.
    sliding_direction : (x, y) or None
        Of the upper body over the lower one; None: it does not slide.
    upper, lower : Material, HalfSpace, Layered or Rigid; below also Prism
        The bodies above and below.
    layer : InterfaceLayer or PlasticLayer
        Third body that shears. Its yield stress bounds the friction of the sliding; its stiffness has no
        influence there, and softens the start of sliding.
    normal_layer : float, array, callable, table, ThinLayer or RoughLayer [m/Pa]
        Third body that gives way under the pressure, by this flexibility times the pressure at each point.
    hardness : float, array, callable or table [Pa]
        Pressure at which the softer body flows; the pressure stays below it.
    """
    given = _those_of(Scene, locals())
    width, height = positive("width", width, "m"), positive("height", height, "m")
    length = width if length is None else positive("length", length, "m")
    ask(unusual({"width": width, "length": length, "height": height}, USUAL_BLOCK))
    return Scene(**given, geometry=BlockOnPlane(width, length, height), name="block_on_plane")


@_scene
def pole_shoe_on_rail(
    height: float = 28.2e-3,
    length: float = 90e-3,
    inner_edge: float = 6e-3,
    outer_edge: float = 36e-3,
    conforming_to: float = 21.6e-3,
    relief_slope: float = 0.02,
    poles: int = 2,
    friction: Any = 0.5,
    magnetic_pressure: Any = 3e6,
    velocity: float | None = None,
    spacing: float | Sequence[float] | None = 3e-3,
    supports: Held | Sequence[Support] = "driven-top",
    attraction: Attraction = "upper",
    sliding_direction: tuple[float, float] | None = (1.0, 0.0),
    lateral: float = 0.0,
    yaw: float = 0.0,
    upper: Material | Simple = steel,
    lower: Material | Simple | Prism = steel,
    rail: str | Profile = "60E1",
    rail_length: float = 0.18,
    layer: InterfaceLayer | PlasticLayer | None = None,
    normal_layer: Any = None,
    hardness: Any = None,
) -> Scene:
    """The pole shoe of a magnetic track brake on its rail: thesis 3.1.2, 3.2.2, 4.

    Parameters
    ----------
    height : float [m]
        Flat top above the crown of the rail.
    length : float [m]
        Along the rail.
    inner_edge, outer_edge : float [m]
        ``|y|`` of the edges of each pole.
    conforming_to : float [m]
        The sole follows the rail up to this ``|y|``.
    relief_slope : float [-]
        Slope with which the sole rises beyond `conforming_to`.
    poles : int
        1 (left, y > 0) or 2. The poles are separate bodies: each has its own approach and tilts.
    friction : float, array, callable, table [-]
        Coefficient of the sliding.
    magnetic_pressure : float [Pa], (left, right), array, callable, table, or Magnet
        Magnetic pressure on the conforming strip, along the local normal, per area of this strip. The default
        is the force of a whole pole over its strip: the iron of a pole is wider and saturates at 1.86e6 Pa.
    velocity : float [m/s]
        For tables over the velocity.
    spacing : float or (dx, dy) [m], or None
        None: :meth:`Scene.solve` chooses it by the tolerance.
    supports : "driven-top", "clamped-top", "points", "fixed-points" or a list of Support
        Supports of an elastic shoe. "driven-top" prescribes u_x and u_y of the top and leaves u_z free, and
        "clamped-top" prescribes all three. "points" and "fixed-points" hold the thesis' five points on top,
        which share one free u_z or are fixed, and four points at the back. These are single nodes, which give
        way more the finer the elements are. A half-space has no top.
    attraction : "upper" or "both"
        Whether the rail is attracted as well.
    lateral, yaw : float [m], [rad]
        Offset along y and rotation about z of the shoe.
    rail : str or Profile
        "60E1", or a profile from points or a file.
    rail_length : float [m]
        Length of the rail about the middle of the shoe, at least that of the contact.
    layer : InterfaceLayer or PlasticLayer
        Third body that shears. Its yield stress bounds the friction of the sliding; its stiffness has no
        influence there, and softens the start of sliding.
    normal_layer : float, array, callable, table, ThinLayer or RoughLayer [m/Pa]
        Third body that gives way under the pressure, by this flexibility times the pressure at each point.
    hardness : float, array, callable or table [Pa]
        Pressure at which the softer body flows; the pressure stays below it.
    sliding_direction : (x, y) or None
        Of the upper body over the lower one; None: it does not slide.
    upper, lower : Material, HalfSpace, Layered or Rigid; below also Prism
        The bodies above and below.
    """
    given = locals()
    rail_length = positive("rail_length", rail_length, "m")
    shoe = PoleShoe(**_those_of(PoleShoe, given))
    lengths = {"rail_length": rail_length} | {k: getattr(shoe, k) for k in USUAL_SHOE if k != "rail_length"}
    ask(unusual(lengths, USUAL_SHOE))
    geometry = ShoeOnRail(shoe, rail_length)
    return Scene(**_those_of(Scene, given), geometry=geometry, name="pole_shoe_on_rail")


@_scene
def wheel_on_rail(
    wheel: str | Profile | WheelSlices = "S1002",
    rail: str | Profile | RailSlices = "60E1",
    wheel_radius: float = 0.46,
    gauge: float = 1.435,
    rail_inclination: float = 1 / 40,
    lateral: float = 6.2e-3,
    force: float = 36e3,
    spacing: float | Sequence[float] | None = 1e-4,
    *,
    gauge_depth: float = 14e-3,
    flange_back: float = 1.360,
    tape_circle: float = 70e-3,
    roller_radius: float | None = None,
    friction: Any = 0.3,
    upper: Material | Simple = steel,
    lower: Material | Simple = steel,
    hardness: Any = None,
) -> WheelScene:
    """A wheel on a rail, without yaw: paper Table 1.

    Solved in the frame of the contact plane: x along the rail, y across towards the field side, z normal
    to the plane; its position and rotation in the track are in ``scene.geometry.placement``. The force
    normal to the plane is the vertical force over the cosine of the contact angle.

    Parameters
    ----------
    wheel, rail : str, Profile, WheelSlices or RailSlices
        "S1002" and "60E1", or profiles from points or files. Wheels that vary around them and rails that vary
        along the track (slices) are solved by the steps of :meth:`Scene.prepare` alone.
    wheel_radius : float [m]
        Radius at z = 0 of the wheel profile, which is that of the tape circle of a new wheel.
    gauge, gauge_depth : float [m]
        Track gauge, and the depth below the top of the rail down to which it is measured.
    rail_inclination : float [rad]
        Rotation of the rail towards the middle of the track; 0 for profiles that already contain it.
    lateral : float [m]
        Shift of the wheelset towards flange contact.
    force : float [N]
        Vertical.
    spacing : float or (dx, dy) [m], or None
        None: :meth:`Scene.solve` chooses it by the tolerance.
    flange_back, tape_circle : float [m]
        Distance between the backs of the flanges, and of the tape circle from them.
    roller_radius : float [m], optional
        Of a roller in place of the rail, as in a roller rig: its radius at the top of the rail as this stands
        with its inclination. The axis of the roller lies across the track, below the axle. None: a straight
        rail.
    friction : float, Coulomb, StaticKinetic, FallingFriction, TabulatedFriction or RailFriction [-]
        Friction of rolling in :meth:`Scene.prepare`; a number is a Coulomb coefficient. :meth:`Scene.solve`
        presses the wheel down without rolling and without friction.
    upper, lower : Material, HalfSpace, Layered or Rigid
        Wheel and rail.
    hardness : float, array, callable or table [Pa]
        Upper bound on the pressure, where the softer body flows; None: there is none. It is of
        :meth:`Scene.solve`, of rolling and of sweeps; :meth:`Scene.prepare` refuses it.

    Lengths that no railway has give a warning and are not refused.
    """
    given = locals()
    force = positive("force", force, "N")
    compliance = _compliance(upper, lower)
    radius = positive("wheel_radius", wheel_radius, "m")
    if roller_radius is not None:
        radius = 1.0 / (1.0 / radius + 1.0 / positive("roller_radius", roller_radius, "m"))
    first = _semi_axis(force, radius, compliance) / 8.0 if spacing is None else spacing
    names = inspect.signature(wheel_on_rail_gap).parameters
    geometry = WheelOnRail.placed(
        **{name: value for name, value in given.items() if name in names}
        | {"force": force, "contact_modulus": 1.0 / compliance, "spacing": spacing_pair(first)}
    )
    profiles = {"wheel": nominal_of("wheel", wheel)[0], "rail": nominal_of("rail", rail)[0]}
    ask(of_wheel({**dict(geometry.arguments), **profiles}, geometry.placement))
    return WheelScene(
        upper=upper,
        lower=lower,
        spacing=spacing,
        friction=_of_rolling(friction),
        hardness=hardness,
        sliding_direction=None,
        force=force / float(np.cos(geometry.placement.contact_angle)),
        geometry=geometry,
        name="wheel_on_rail",
    )


def _of_rolling(friction: Any) -> Any:
    """The friction of a wheel: a number is checked here, a law has checked itself."""
    if isinstance(friction, (bool, str)):
        raise ValueError(
            f"friction is {friction!r}: a number or a friction law, such as Coulomb(0.3), is needed"
        )
    if isinstance(friction, Real):
        Coulomb(float(friction))
    return friction


def _semi_axis(force: float, radius: float, compliance: float) -> float:
    """Radius of contact [m] of a sphere on a plane, after Hertz."""
    return float(np.cbrt(0.75 * force * radius * compliance))


def _compliance(upper: Material | Simple, lower: Material | Simple) -> float:
    """Of half-spaces together, the sum of (1 - nu^2) / E [1/Pa]; about that of layered bodies."""
    bodies = as_body("upper", upper), as_body("lower", lower)
    compliance = sum(body.plane_strain_compliance for body in bodies)
    if compliance == 0.0:
        raise ValueError("upper and lower are both Rigid: one of them must deform")
    return compliance


__all__ = ["block_on_plane", "paraboloid_on_plane", "pole_shoe_on_rail", "wheel_on_rail"]
