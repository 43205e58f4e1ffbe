# SPDX-License-Identifier: MIT OR Apache-2.0
"""Friction laws, and the layer between the bodies."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from numbers import Real
from typing import Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .. import _mtb_rs
from ..base.check import number, reals, shortened
from ..base.owning import owning
from ..base.plain import plain
from ..base.questions import ask
from ..base.renamed import renamed
from ..geometry.contact_points import window

Array = NDArray[np.float64]
#: A coefficient over the rail, as the core takes it: places along the track and across the rail [m], flat
#: coefficients.
RailMap = tuple[list[float], list[float], list[float]]


#: Coefficients of friction above this are mostly percentages, or a slip of the pen: clean metals in vacuum
#: and soft rubber reach it.
HIGH_FRICTION = 2.0


#: Farther from the middle of a rail than its surface reaches [m].
BESIDE_RAIL = 0.2


def of_friction(name: str, largest: float) -> list[str]:
    """A question about a coefficient of friction that hardly any pair of bodies has."""
    if largest <= HIGH_FRICTION:
        return []
    return [
        f"{name} reaches {largest:g}: coefficients of friction are numbers such as 0.3, and above "
        f"{HIGH_FRICTION:g} only soft rubber and clean metals in vacuum have them"
    ]


def _number(name: str, value: float, lowest: float = 0.0, strictly: bool = False) -> float:
    checked = number(name, value)
    if checked < lowest or (strictly and checked == lowest):
        raise ValueError(f"{name} is {value:g}: it must be {'above' if strictly else 'at least'} {lowest:g}")
    return checked


class WheelFriction(ABC):
    """What wheels in steps ask of their friction: a law, or a coefficient over the rail."""

    @abstractmethod
    def native_of_wheels(self) -> _mtb_rs.Friction | RailMap:
        """The law as wheels take it, whose patches move; `ValueError` where it is fixed to a patch."""

    def coefficient_from_rest(self) -> float | Array:
        """Coefficient by which a wheel slides that has not rolled."""
        raise ValueError(
            f"friction is {self!r}: from rest the wheel slides with a coefficient that does not change, "
            "a number or Coulomb, is needed"
        )


class Friction(WheelFriction):
    """A friction law: what solvers of stick and slip ask of it. A new law is one class that answers this."""

    #: Whether the coefficient is the same at rest and in sliding.
    is_constant: ClassVar[bool] = False
    #: Whether the coefficient depends on the slip speed.
    depends_on_speed: ClassVar[bool] = False

    @abstractmethod
    def at_rest(self) -> float:
        """Largest coefficient at rest [-]."""

    @abstractmethod
    def of_sliding(
        self, slip_speed: Array, pressure: Array, shape: tuple[int, int], cut: tuple[slice, slice]
    ) -> Array:
        """Mean coefficients (n,) of continuous sliding at slip speeds (n,) [m/s].

        The mean is that over a pressure [Pa] on the rectangle `cut` of a grid of `shape` (ny, nx).
        """

    @abstractmethod
    def native(self, shape: tuple[int, int], cut: tuple[slice, slice]) -> _mtb_rs.Friction:
        """The law as the solver takes it, on the rectangle `cut` of a grid of `shape` (ny, nx)."""

    def of_open(self, shape: tuple[int, int]) -> Array:
        """Coefficients (ny, nx) that cells out of contact are told with."""
        return np.full(shape, self.at_rest())

    @property
    def lacks_memory(self) -> bool:
        """Whether the coefficient follows the slip speed at once."""
        return False

    @property
    def remembers(self) -> bool:
        """Whether the coefficient follows slip or temperature by a memory."""
        return False

    def slopes(self, slips: NDArray[np.bool_]) -> dict[str, Array | None]:
        """Slopes (ny, nx) of the coefficient at each point by its parameters; none where it follows.

        `slips` (ny, nx) tells the points that slip. None: the parameter is the coefficient at each point.
        """
        return {}

    def followed(self) -> dict[str, Array]:
        """Parameters of a law that follows slip or temperature: slopes (m, *shape) of the core's by each.

        The core has m of them, in its own order, without the speed.
        """
        return {}

    def native_of_wheels(self) -> _mtb_rs.Friction:
        """The law as wheels take it."""
        return self.native((1, 1), (slice(0, 1), slice(0, 1)))


def as_law(friction: Any) -> Friction:
    """A friction law, checked."""
    if not isinstance(friction, Friction):
        raise _no_law("friction", friction)
    return friction


def as_wheel_friction(name: str, friction: Any) -> WheelFriction:
    """The friction of wheels in steps, checked."""
    if not isinstance(friction, WheelFriction):
        raise _no_law(name, friction)
    return friction


def _no_law(name: str, friction: Any) -> ValueError:
    return ValueError(f"{name} is {friction!r}: a friction law, such as Coulomb(0.3), is needed")


def in_a_row(shapes: Mapping[str, tuple[int, ...]]) -> dict[str, Array]:
    """Slopes (m, *shape) of m parameters in a row by each of those that they are, from their shapes."""
    sizes = [math.prod(shape) for shape in shapes.values()]
    parts = np.split(np.eye(sum(sizes)), np.cumsum(sizes)[:-1], axis=1)
    return {
        name: part.reshape(len(part), *shape)
        for (name, shape), part in zip(shapes.items(), parts, strict=True)
    }


def law_of(friction: Any) -> Any:
    """The law of a scene's friction: a number is the coefficient of Coulomb's, all else is as it is."""
    return Coulomb(float(friction)) if isinstance(friction, Real) else friction


def coefficient_from_rest(friction: Any) -> Any:
    """The coefficients by which what rests starts to slide: a law gives its own, all else is them."""
    return friction.coefficient_from_rest() if isinstance(friction, WheelFriction) else friction


@owning
@dataclass(frozen=True)
@plain
class Coulomb(Friction):
    """A coefficient of friction that does not change with slip.

    Parameters
    ----------
    coefficient : float or (ny, nx) float [-]
        One number, or one per cell of the patch.
    """

    coefficient: float | Array
    is_constant: ClassVar[bool] = True

    def __post_init__(self) -> None:
        values = reals("coefficient", self.coefficient)
        if values.size == 0 or np.any(values < 0.0):
            raise ValueError(
                f"coefficient is {shortened(self.coefficient)}: numbers of at least 0 are needed"
            )
        if values.ndim not in (0, 2):
            raise ValueError(f"coefficient has shape {values.shape}: one number or (ny, nx) is needed")
        ask(of_friction("coefficient", float(values.max())))

    def at_rest(self) -> float:
        """Largest coefficient at rest [-]."""
        return float(np.max(self.coefficient))

    def of_sliding(
        self, slip_speed: Array, pressure: Array, shape: tuple[int, int], cut: tuple[slice, slice]
    ) -> Array:
        """Mean coefficients (n,), weighted by the pressure."""
        values = self._on_grid(shape)[cut]
        return np.full(len(slip_speed), float(np.average(values, weights=pressure)))

    def of_open(self, shape: tuple[int, int]) -> Array:
        """Those of the cells."""
        return self._on_grid(shape)

    def native(self, shape: tuple[int, int], cut: tuple[slice, slice]) -> _mtb_rs.Friction:
        """The law as the solver takes it."""
        return _mtb_rs.Friction.coulomb(window(self._on_grid(shape), cut).ravel())

    def slopes(self, slips: NDArray[np.bool_]) -> dict[str, Array | None]:
        """The coefficient, and that at each point."""
        own = np.ones(slips.shape) if np.ndim(self.coefficient) == 0 else None
        return {"friction": own, "friction_field": None}

    def native_of_wheels(self) -> _mtb_rs.Friction:
        """The law as wheels take it, with one coefficient."""
        if np.ndim(self.coefficient):
            raise ValueError(
                "friction varies over the patch: patches move, one coefficient is needed, or a "
                "RailFriction, which varies over the rail"
            )
        return super().native_of_wheels()

    def coefficient_from_rest(self) -> float | Array:
        """The coefficient."""
        return self.coefficient

    def _on_grid(self, shape: tuple[int, ...]) -> Array:
        """The coefficient (ny, nx) on a grid of that shape."""
        values = np.asarray(self.coefficient, dtype=float)
        if values.ndim and values.shape != shape:
            raise ValueError(
                f"coefficient has shape {values.shape}: one number, or the shape of the patch, {shape}, is "
                "needed"
            )
        return np.broadcast_to(values, shape)


@dataclass(frozen=True)
@plain
class StaticKinetic(Friction):
    """One coefficient for points that stick, another for points that slip.

    The jump between the two makes the result depend on the grid: single cells decide where the slip area ends
    and whether several states exist. CONTACT has withdrawn this law for that reason. The total force in full
    slip is sound, and the fields near the edge of the slip area are not. Use :class:`FallingFriction` with a
    memory where they matter. A warning says so.

    Parameters
    ----------
    static, kinetic : float [-]
        `kinetic` must not exceed `static`.
    """

    static: float
    kinetic: float

    def __post_init__(self) -> None:
        _number("kinetic", self.kinetic)
        if _number("static", self.static) < self.kinetic:
            raise ValueError(f"static is {self.static:g}: it must not be below kinetic = {self.kinetic:g}")
        withdrawn = (
            "StaticKinetic depends on the grid: single cells decide where the slip area ends, and CONTACT "
            "has withdrawn this law as an artefact of the grid. The total force in full slip is sound; for "
            "fields near the edge of the slip area take FallingFriction with a memory"
        )
        ask([withdrawn, *of_friction("static", self.static)])

    def at_rest(self) -> float:
        """Coefficient at rest [-]."""
        return self.static

    def of_sliding(
        self, slip_speed: Array, pressure: Array, shape: tuple[int, int], cut: tuple[slice, slice]
    ) -> Array:
        """The kinetic coefficient at each slip speed."""
        return np.full(len(slip_speed), self.kinetic)

    def slopes(self, slips: NDArray[np.bool_]) -> dict[str, Array | None]:
        """The kinetic coefficient acts where points slip; the static one only decides which do."""
        return {"friction.static": (~slips).astype(float), "friction.kinetic": slips.astype(float)}

    def native(self, shape: tuple[int, int], cut: tuple[slice, slice]) -> _mtb_rs.Friction:
        """The law as the solver takes it."""
        return _mtb_rs.Friction.static_kinetic(float(self.static), float(self.kinetic))


#: Names and shapes of the parameters of a memory.
MEMORY_PARAMETERS: dict[str, tuple[int, ...]] = {"friction.memory": (), "friction.memory_min_slip": ()}


class SpeedDependentFriction(Friction):
    """A coefficient that depends on the slip speed, at once or by a memory."""

    depends_on_speed: ClassVar[bool] = True
    memory: float | None
    memory_min_slip: float

    @abstractmethod
    def sliding(self, slip_speed: float | Array) -> Array:
        """Coefficient [-] of continuous sliding at the slip speed [m/s]."""

    def of_sliding(
        self, slip_speed: Array, pressure: Array, shape: tuple[int, int], cut: tuple[slice, slice]
    ) -> Array:
        """Coefficients (n,) at the slip speeds, the same over the whole patch."""
        return self.sliding(slip_speed)

    @property
    def lacks_memory(self) -> bool:
        """Whether the coefficient follows the slip speed at once."""
        return self.memory is None

    @property
    def remembers(self) -> bool:
        """Whether the coefficient follows the slip speed by a memory."""
        return self.memory is not None

    def _check_memory(self) -> None:
        if self.memory is not None:
            _number("memory", self.memory, strictly=True)
        _number("memory_min_slip", self.memory_min_slip, strictly=True)

    def followed(self) -> dict[str, Array]:
        """The parameters of the law, then those of the memory."""
        return in_a_row(self._law_parameters() | (MEMORY_PARAMETERS if self.remembers else {}))

    @abstractmethod
    def _law_parameters(self) -> dict[str, tuple[int, ...]]:
        """Names and shapes of the parameters of the law."""

    def _native_memory(self) -> tuple[float, float] | None:
        return None if self.memory is None else (float(self.memory), float(self.memory_min_slip))


@dataclass(frozen=True)
@plain
class FallingFriction(SpeedDependentFriction):
    """A coefficient that falls exponentially with the slip speed [Vollebregt2012, eq. 3, 4].

    ``mu_s(s) = kinetic + (static - kinetic) exp(-ln 2 s / half_slip)``; with a memory the coefficient of a
    particle follows it by ``dmu/dt = -max(s, memory_min_slip) / memory (mu - mu_s)``. Without one,
    transient rolling is unstable on fine grids.

    Parameters
    ----------
    static, kinetic : float [-]
        Coefficients at rest and at high slip speed.
    half_slip : float [m/s]
        Slip speed at which the coefficient has fallen by half of the difference.
    memory : float [m] or None
        Slip distance over which the coefficient adapts.
    memory_min_slip : float [m/s]
        Slip speed with which the coefficient still adapts where the surfaces stick.
    """

    static: float
    kinetic: float
    half_slip: float
    memory: float | None = None
    memory_min_slip: float = 1e-3

    def __post_init__(self) -> None:
        _number("static", self.static)
        _number("kinetic", self.kinetic)
        _number("half_slip", self.half_slip, strictly=True)
        self._check_memory()
        for name in ("static", "kinetic"):
            ask(of_friction(name, getattr(self, name)))

    def at_rest(self) -> float:
        """Coefficient at rest [-]."""
        return self.static

    @renamed(speed="slip_speed")
    def sliding(self, slip_speed: float | Array) -> Array:
        """Coefficient [-] of continuous sliding at the slip speed [m/s]."""
        fall = np.exp(-math.log(2.0) * np.asarray(slip_speed, dtype=float) / self.half_slip)
        return np.asarray(self.kinetic + (self.static - self.kinetic) * fall)

    def _law_parameters(self) -> dict[str, tuple[int, ...]]:
        return {f"friction.{name}": () for name in ("static", "kinetic", "half_slip")}

    def native(self, shape: tuple[int, int], cut: tuple[slice, slice]) -> _mtb_rs.Friction:
        """The law as the solver takes it."""
        return _mtb_rs.Friction.exponential(
            float(self.static), float(self.kinetic), float(self.half_slip), self._native_memory()
        )


@owning
@dataclass(frozen=True)
@plain
class TabulatedFriction(SpeedDependentFriction):
    """A coefficient given at slip speeds, linear between them and constant beyond the last.

    Parameters
    ----------
    slip_speed : sequence of float [m/s]
        Strictly rising from 0.
    coefficient : sequence of float [-]
    memory : float [m] or None
        As in :class:`FallingFriction`.
    memory_min_slip : float [m/s]
    """

    slip_speed: Sequence[float]
    coefficient: Sequence[float]
    memory: float | None = None
    memory_min_slip: float = 1e-3

    def __post_init__(self) -> None:
        speed = reals("slip_speed", self.slip_speed, "m/s")
        values = reals("coefficient", self.coefficient)
        if speed.ndim != 1 or speed.size < 1 or speed[0] != 0.0 or np.any(np.diff(speed) <= 0.0):
            raise ValueError("slip_speed must rise strictly from 0")
        if values.shape != speed.shape:
            raise ValueError(f"coefficient has {values.size} entries, slip_speed has {speed.size}")
        if np.any(values < 0.0):
            at = int(np.argmin(values))
            raise ValueError(f"coefficient[{at}] is {values[at]:g}: numbers of at least 0 are needed")
        self._check_memory()
        ask(of_friction("coefficient", float(values.max())))

    def at_rest(self) -> float:
        """Coefficient at rest [-]."""
        return float(self.coefficient[0])

    @renamed(speed="slip_speed")
    def sliding(self, slip_speed: float | Array) -> Array:
        """Coefficient [-] of continuous sliding at the slip speed [m/s]."""
        return np.asarray(np.interp(slip_speed, self.slip_speed, self.coefficient))

    def _law_parameters(self) -> dict[str, tuple[int, ...]]:
        points = (len(self.coefficient),)
        return {"friction.coefficient": points, "friction.slip_speed": points}

    def native(self, shape: tuple[int, int], cut: tuple[slice, slice]) -> _mtb_rs.Friction:
        """The law as the solver takes it."""
        speed = np.array(self.slip_speed, dtype=float)
        coefficient = np.array(self.coefficient, dtype=float)
        return _mtb_rs.Friction.table(speed, coefficient, self._native_memory())


@owning
@dataclass(frozen=True)
@plain
class RailFriction(WheelFriction):
    """A coefficient of friction over the rail, for wheels in steps (:meth:`mtb_rs.Scene.prepare`).

    The coefficient is fixed to the rail, and each step evaluates it at the cells of its patches. It is linear
    between the given places and constant beyond the first and the last one; two places close together make a
    step. Both rails have the same coefficient, the right rail as a mirror image (or one of its own, by
    `right_friction`).

    Parameters
    ----------
    rail_position : (n,) float [m]
        Places across the rail, strictly rising: y in the rail profile's own frame, as `rail_position` of a
        patch; the gauge corner of the ready rail is at y < 0.
    coefficient : (n,) or (m, n) float [-]
        At least 0; (m, n) with `x`.
    x : (m,) float [m] or None
        Places along the track, strictly rising; None: friction does not vary along it.

    Examples
    --------
    A gauge corner with grease on it, and a rail that is wet from x = 10 m on:

    >>> corner = RailFriction([-20e-3, -15e-3], [0.1, 0.4])
    >>> wet = RailFriction([0.0], [[0.4], [0.15]], x=[10.0, 10.001])
    """

    rail_position: Array
    coefficient: Array
    x: Array | None = None

    def __post_init__(self) -> None:
        position = _places("rail_position", self.rail_position)
        values = reals("coefficient", self.coefficient)
        along = None if self.x is None else _places("x", self.x)
        shape = position.shape if along is None else (along.size, position.size)
        if values.shape != shape:
            raise ValueError(
                f"coefficient has shape {values.shape}: {shape} is needed, "
                f"{'one for each rail_position' if along is None else 'a row for each x'}"
            )
        if np.any(values < 0.0):
            raise ValueError(f"coefficient is {np.min(values):g}: numbers of at least 0 are needed")
        ask(of_friction("coefficient", float(values.max(initial=0.0))))
        widest = float(position[np.abs(position).argmax()])
        if abs(widest) > BESIDE_RAIL:
            ask(
                [
                    f"rail_position reaches {widest:g} m: rails end within {BESIDE_RAIL:g} m of their "
                    "middle, and lengths are in metres"
                ]
            )
        for name, field in (("rail_position", position), ("coefficient", values), ("x", along)):
            object.__setattr__(self, name, field)

    def native_of_wheels(self) -> RailMap:
        """Places along the track and across the rail, flat coefficients."""
        along = [0.0] if self.x is None else self.x.tolist()
        return along, self.rail_position.tolist(), self.coefficient.ravel().tolist()


def _places(name: str, values: ArrayLike) -> Array:
    places = reals(name, values, "m")
    if places.ndim != 1 or not places.size or np.any(np.diff(places) <= 0.0):
        raise ValueError(f"{name} is {shortened(values)}: places [m] that rise strictly are needed")
    return places


@dataclass(frozen=True)
class ShearLayer:
    """A layer between the bodies that gives way as shear springs."""

    thickness: float
    shear_modulus: float

    def __post_init__(self) -> None:
        _number("thickness", self.thickness)
        _number("shear_modulus", self.shear_modulus, strictly=True)

    @property
    def flexibility(self) -> float:
        """Displacement per traction, thickness over shear modulus [m/Pa]."""
        return self.thickness / self.shear_modulus

    @property
    def plasticity(self) -> tuple[float, float] | None:
        """Yield stress [Pa] and hardening [Pa/m]; None for a layer that does not yield."""
        return None


@dataclass(frozen=True)
@plain
class InterfaceLayer(ShearLayer):
    """A layer of debris or roughness between the bodies, as shear springs [Vollebregt2012, eq. 2].

    Parameters
    ----------
    thickness : float [m]
    shear_modulus : float [Pa]
    """


#: Poisson's ratio above which a thin layer gives way by flowing sideways rather than by compression.
_MOST_COMPRESSIBLE = 0.45


@dataclass(frozen=True)
@plain
class ThinLayer:
    """A thin compressible layer between the bodies, as normal springs: `normal_layer` of contacts.

    Each point gives way by its own pressure times ``h (1 + nu) (1 - 2 nu) / ((1 - nu) E)``, the compression
    of a layer that cannot widen, which holds where the layer is thin against the contact.

    Parameters
    ----------
    thickness : float [m]
    young_modulus : float [Pa]
    poisson_ratio : float [-]
        At most 0.45. A layer nearer to incompressible gives way by flowing sideways, which depends on its
        thickness over the size of the contact: such a layer is a :class:`mtb_rs.Layered` body.
    """

    thickness: float
    young_modulus: float
    poisson_ratio: float

    def __post_init__(self) -> None:
        _number("thickness", self.thickness)
        _number("young_modulus", self.young_modulus, strictly=True)
        if not -1.0 < number("poisson_ratio", self.poisson_ratio) <= _MOST_COMPRESSIBLE:
            raise ValueError(
                f"poisson_ratio is {self.poisson_ratio:g}: above -1 and up to {_MOST_COMPRESSIBLE:g} a thin "
                "layer is springs; one nearer to 0.5 flows sideways: a Layered body is needed"
            )

    @property
    def normal_flexibility(self) -> float:
        """Compression per pressure [m/Pa]."""
        nu = self.poisson_ratio
        return self.thickness * (1.0 + nu) * (1.0 - 2.0 * nu) / ((1.0 - nu) * self.young_modulus)


def normal_flexibility(normal_layer: Any) -> Any:
    """A normal layer by its flexibility [m/Pa]; a number, a field or a rough layer is one already.

    Raises
    ------
    ValueError
        For a layer that shears and does not give way under the pressure.
    """
    if isinstance(normal_layer, ShearLayer):
        raise ValueError(
            f"normal_layer is {normal_layer!r}, which shears and does not give way under the pressure: a "
            "flexibility [m/Pa], a ThinLayer or a RoughLayer is needed"
        )
    return normal_layer.normal_flexibility if isinstance(normal_layer, ThinLayer) else normal_layer


@dataclass(frozen=True)
@plain
class PlasticLayer(ShearLayer):
    """A layer between the bodies that yields in shear, such as oxides, clay or sand (CONTACT, third body).

    It gives way elastically by the traction times thickness over shear modulus, as an
    :class:`InterfaceLayer` does. The traction is bounded by friction and by the yield stress of the layer,
    whichever is smaller: ``|q| <= min(mu p, tau_c0 + k_tau u)``, with the accumulated plastic slip u of each
    particle. Under the yield stress all slip is plastic shear of the layer. Once hardening has brought the
    yield stress up to ``mu p``, the rest is slip of the surfaces. A slope ``k_u`` of the traction
    over the whole displacement of the layer is ``k_tau = s k_u / (s - k_u)`` over its plastic part, with
    ``s = shear_modulus / thickness``.

    In shifts and rolling it goes with a coefficient of friction that does not follow the slip velocity. One
    that falls with it leaves two states to a point whose yield stress lies between the friction at rest and
    the friction of slip: the layer flows and the surfaces stick, or the surfaces slip and the layer, under
    less traction, does not flow. Which of them is met depends on the past, which these laws do not have.

    Parameters
    ----------
    thickness : float [m]
    shear_modulus : float [Pa]
    yield_stress : float [Pa]
        Before any plastic slip, ``tau_c0``.
    hardening : float [Pa/m]
        Growth of the yield stress with the accumulated plastic slip, ``k_tau``. Negative values let the layer
        soften, down to nothing. Where it softens faster than the contact around it is stiff, more than one
        answer may exist, and the solve refuses it.
    """

    yield_stress: float
    hardening: float = 0.0

    def __post_init__(self) -> None:
        super().__post_init__()
        _number("yield_stress", self.yield_stress, strictly=True)
        number("hardening", self.hardening)

    @property
    def plasticity(self) -> tuple[float, float]:
        """Yield stress [Pa] and hardening [Pa/m]."""
        return float(self.yield_stress), float(self.hardening)
