# SPDX-License-Identifier: MIT OR Apache-2.0
"""Friction and magnetic pressure: the forms that users may give, and fields over the contact points."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from dataclasses import field as entry
from functools import partial
from pathlib import Path
from typing import Any, ClassVar, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .. import _mtb_rs
from ..base.check import LARGEST, is_quantity, number, pair, path_of, positive, reals, shortened
from ..base.owning import owning
from ..base.plain import plain
from ..geometry.contact_points import Patch
from .tables import SPEEDS, VALUES, Column, read_table

Array = NDArray[np.float64]

#: A table over the velocity in files.
_COLUMNS = Column(["velocity", "speed", "v"], SPEEDS), Column(["value"], VALUES)

#: No pair of bodies rubs more than this; what is larger is a slip of the pen.
LARGEST_FRICTION = 1e3


#: A hill is off the contact from so many times its width, or the contact's size, on: there 1 % of it is left.
_FAR = 3.0

#: Grids, and others to which what is given on them is carried.
Grids = tuple[Patch, ...]


@dataclass(frozen=True)
class Asked:
    """What a field is asked for: its values at contact points.

    Attributes
    ----------
    name : str
        Of the field, for messages.
    points : (3, n) [m]
    patches : tuple of Patch
        Their grids.
    velocity : float or None [m/s]
        For tables.
    lowest, highest : float
        Smallest and largest value accepted.
    kept : (n,) int or None
        The contact points among those of the patches, where these are not all; arrays have a value for
        each of the latter.
    """

    name: str
    points: Array
    patches: Grids
    velocity: float | None
    lowest: float | None = None
    highest: float = LARGEST
    kept: NDArray[np.intp] | None = None

    def check_range(self, placed: Iterable[tuple[str, float]]) -> None:
        """Refuses numbers, each with its place, that are not between the lowest and the highest value."""
        lowest = -np.inf if self.lowest is None else self.lowest
        for place, value in placed:
            if not lowest <= value <= self.highest:
                need = (
                    f"at most {self.highest:g}"
                    if self.lowest is None
                    else f"from {lowest:g} to {self.highest:g}"
                )
                raise ValueError(f"{place} is {value:.6g}: numbers {need} are needed")

    def on(self, patch: Patch) -> Asked:
        """The same on one of the patches."""
        return replace(
            self,
            name=f"{self.name}[{patch.name}]",
            points=self.points[:, patch.cut],
            patches=(replace(patch, start=0),),
            kept=None,
        )


class Leaf(NamedTuple):
    """A number in a form in which its field is linear.

    Attributes
    ----------
    value : float
    put : callable
        The form with another number in its place.
    """

    value: float
    put: Callable[[float], Any]


class Form(ABC):
    """A form in which users state a field over the contact points; :func:`as_form` finds it.

    A new form is one class that answers this.
    """

    #: Whether it is a list, of values or of forms.
    is_list: ClassVar[bool] = False
    #: Whether it is given by one number, and not by a row of them.
    is_one: ClassVar[bool] = False
    #: Whether its values are known only with the pressure.
    depends_on_pressure: ClassVar[bool] = False
    #: Whether its values are known only with the gap: that of a magnet, which has a :meth:`circuit`.
    follows_gap: ClassVar[bool] = False

    @abstractmethod
    def values(self, asked: Asked) -> Array:
        """Values (n,) at the contact points; see :func:`field`."""

    def carried(self, choices: Sequence[tuple[Grids, Grids]]) -> Any:
        """The same field on other grids: arrays at the nearest points of these, all else as it is.

        Parameters
        ----------
        choices : sequence of (grids, others)
            Arrays are over the first grids that they fit.
        """
        return self

    def placed(self, name: str) -> Iterator[tuple[str, float]]:
        """The numbers in it, each after its place in what has this name.

        They are those alone, in arrays (the least and the largest), in lists, as peaks, in tables.
        """
        return iter(())

    def numbers(self) -> Iterator[float]:
        """The numbers in it."""
        return (value for _, value in self.placed(""))

    def doubts(self, asked: Asked) -> Iterator[str]:
        """What looks like a slip of the unit in where it lies over the contact points."""
        return iter(())

    def tables(self) -> Iterator[VelocityTable]:
        """The tables in it."""
        return iter(())

    def leaves(self) -> list[Leaf] | None:
        """The numbers in it in which the field is linear; None where more than such numbers give it."""
        return None

    @property
    def has_arrays(self) -> bool:
        """Whether it has values on a grid in it."""
        return False

    @property
    def has_places(self) -> bool:
        """Whether it states places in the scene that may lie beside the contact."""
        return False

    @property
    def number(self) -> float | None:
        """The number that it is; None for all other forms."""
        return None

    @property
    def from_touching(self) -> bool:
        """Whether the state of a magnet is looked for from bodies that touch."""
        return False

    def circuit(
        self, area: Array, patches: Grids, kept: NDArray[np.intp] | None
    ) -> _mtb_rs.MagneticCircuit | None:
        """The circuit of a magnet over contact points with areas (n,) [m2]; None of all other forms."""
        return None

    def circuit_over(self, area: Array, poles: list[int]) -> _mtb_rs.MagneticCircuit | None:
        """The same over so many points for each pole."""
        return None

    def factor(self, velocity: float | None) -> float:
        """Factor of a speed [m/s] on the pull of a magnet."""
        return 1.0

    def magnet_numbers(self, velocity: float | None) -> dict[str, Array]:
        """By each number of a magnet, changes (..., 10) of what the core derives its pull by; else none.

        These are ampere-turns, non-magnetic gap, share of iron, length of the poles, leakage, length and
        section of the yoke and of the armature, and the factor of the speed.
        """
        return {}

    def factor_slope(self, speed: float) -> float:
        """Change [s/m] with a speed [m/s] of the factor on the pull of a magnet."""
        return 0.0

    def coefficients(self, values: Callable[[], Array]) -> Coefficients:
        """As friction of a contact problem, with `values` at its points."""
        return FixedFriction(values())


def as_form(spec: Any) -> Form:
    """The form in which a user states a field."""
    if isinstance(spec, Form):
        return spec
    if isinstance(spec, (list, tuple)):
        return _Listed(spec)
    return _Function(spec) if callable(spec) else _Values(spec)


def _leaves_of(parts: Sequence[Any], made: Callable[[list[Any]], Any]) -> list[Leaf] | None:
    """The numbers in all parts of a form, which is `made` of them."""

    def put(k: int, leaf: Leaf, value: float) -> Any:
        return made([*parts[:k], leaf.put(value), *parts[k + 1 :]])

    found: list[Leaf] = []
    for k, part in enumerate(parts):
        inner = as_form(part).leaves()
        if inner is None:
            return None
        found += [Leaf(leaf.value, partial(put, k, leaf)) for leaf in inner]
    return found


class Coefficients(ABC):
    """Friction coefficients at the contact points, as the contact problem asks for them."""

    @abstractmethod
    def at(self, pressure: Array) -> Array:
        """Coefficients (n,) at `pressure` (n,) [Pa]."""

    @property
    def fixed(self) -> Array | None:
        """The coefficients (n,) where the pressure does not change them."""
        return None

    @property
    def may_act(self) -> bool:
        """Whether any coefficient may differ from zero."""
        return True

    def of(self, kept: NDArray[np.intp]) -> Coefficients:
        """Those of some of the points."""
        return self


@dataclass(frozen=True)
class FixedFriction(Coefficients):
    """Coefficients (n,) that the pressure does not change."""

    coefficients: Array

    def at(self, pressure: Array) -> Array:
        """The coefficients, whatever the pressure."""
        return self.coefficients

    @property
    def fixed(self) -> Array:
        """The coefficients."""
        return self.coefficients

    @property
    def may_act(self) -> bool:
        """Whether any differs from zero."""
        return bool(self.coefficients.any())

    def of(self, kept: NDArray[np.intp]) -> FixedFriction:
        """Those of some of the points."""
        return FixedFriction(self.coefficients[kept])


@owning
@dataclass(frozen=True)
@plain
class GaussianPressure(Form):
    """Magnetic pressure with a floor and a Gaussian hill, thesis (4.1).

    ``p(x, y) = peak (floor + (1 - floor) exp(-(x - cx)^2 / 2 sx^2) exp(-(y - cy)^2 / 2 sy^2))``

    Parameters
    ----------
    peak : float [Pa]
    center : (cx, cy) [m]
        On two poles y is the distance ``|y|`` of the hill from the symmetry plane.
    sigma : (sx, sy) [m]
    floor : float [-]
        Share of the peak, from 0 to 1, that acts far from the hill.
    """

    peak: float
    center: tuple[float, float]
    sigma: tuple[float, float]
    floor: float = 0.25
    is_one: ClassVar[bool] = True

    def __post_init__(self) -> None:
        put = object.__setattr__
        put(self, "peak", number("peak", self.peak, "Pa"))
        put(self, "center", pair("center", self.center, "m"))
        put(self, "sigma", pair("sigma", self.sigma, "m"))
        for k, width in enumerate(self.sigma):
            positive(f"sigma[{k}]", width, "m")
        put(self, "floor", number("floor", self.floor))
        if not 0.0 <= self.floor <= 1.0:
            raise ValueError(f"floor is {self.floor:g}: a share of the peak from 0 to 1 is needed")

    def __call__(self, x: Array, y: Array) -> Array:
        """Pressure [Pa] at x, y [m]."""
        (cx, cy), (sx, sy) = self.center, self.sigma
        hill = np.exp(-((x - cx) ** 2) / (2 * sx**2) - (np.abs(y) - cy) ** 2 / (2 * sy**2))
        return np.asarray(self.peak * (self.floor + (1.0 - self.floor) * hill))

    def values(self, asked: Asked) -> Array:
        """Values (n,) at the contact points."""
        return _Function(self).values(asked)

    @property
    def has_places(self) -> bool:
        """Its hill is at one."""
        return True

    def leaves(self) -> list[Leaf]:
        """Its peak."""
        return [Leaf(self.peak, lambda value: replace(self, peak=value))]

    def placed(self, name: str) -> Iterator[tuple[str, float]]:
        """Its peak."""
        return as_form(self.peak).placed(name)

    def doubts(self, asked: Asked) -> Iterator[str]:
        """Whether the hill is so far off that nothing of it is left at the contact."""
        (cx, cy), (sx, sy) = self.center, self.sigma
        x, y = asked.points[0], np.abs(asked.points[1])
        away = float(np.min(((x - cx) / sx) ** 2 + ((y - cy) / sy) ** 2))
        size = float(max(np.ptp(x), np.ptp(y)))
        beside = max(x.min() - cx, cx - x.max(), y.min() - cy, cy - y.max())
        if away > _FAR**2 or beside > _FAR * size > 0.0:
            yield (
                f"the hill of {asked.name} has its center at x = {cx:g} m, y = {cy:g} m and a sigma of "
                f"{sx:g} and {sy:g} m, far outside of the contact, where nothing of its shape is left: "
                "lengths are in metres"
            )


@owning
@dataclass(frozen=True)
@plain
class VelocityTable(Form):
    """A quantity tabulated over the sliding velocity, thesis 2.2.1.

    Parameters
    ----------
    velocity : sequence of float [m/s]
        Rising.
    value : sequence
        One value for each velocity: numbers, or any other form of the quantity (a distribution, an array).
        Between two velocities the fields are interpolated linearly; a velocity outside the table is an error.
    """

    velocity: Sequence[float]
    value: Sequence[Any]
    #: Where each value stands in a file.
    _places: tuple[str, ...] = entry(default=(), init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        speeds = reals("velocity of a table", self.velocity, "m/s")
        if isinstance(self.value, (str, bytes, dict)) or not isinstance(self.value, Iterable):
            raise ValueError(f"value of a table is {self.value!r}: one entry for each velocity is needed")
        value = tuple(self.value)
        if speeds.ndim != 1 or speeds.size < 2 or speeds.size != len(value):
            raise ValueError(
                f"a velocity table has {speeds.size} velocities and {len(value)} values: "
                "at least two velocities, and one value for each of them, are needed"
            )
        velocity = tuple(speeds.tolist())
        if np.any(falls := np.diff(speeds) <= 0.0):
            k = int(np.argmax(falls))
            raise ValueError(
                f"velocity[{k + 1}] of a table is {velocity[k + 1]:.6g} m/s after {velocity[k]:.6g} m/s: "
                "velocities that rise are needed"
            )
        object.__setattr__(self, "velocity", velocity)
        object.__setattr__(self, "value", value)

    @classmethod
    def from_file(cls, path: str | Path) -> VelocityTable:
        """Table from a CSV with two columns, a velocity and a value.

        A heading gives their order and units, for example ``value [MPa],velocity [km/h]``. Without a heading
        the first column is the velocity [m/s] and the second one the value in its SI unit. Further columns
        are ignored if the heading names "velocity" and "value".

        Parameters
        ----------
        path : str or Path
            Its columns are separated by blanks, commas or semicolons; comments begin with #, !, % or //.

        Raises
        ------
        ValueError
            If the file cannot be read. The message names a line that does not hold two numbers or has decimal
            commas, a heading without a velocity, and an unknown unit.
        """
        table = read_table(path_of("path", path), _COLUMNS)
        velocity, value = table.values
        if velocity.size < 2:
            rows = "one row" if velocity.size else "no row"
            raise ValueError(f"table {table.path} has {rows} of numbers: at least two are needed")
        if np.any(falls := np.diff(velocity) <= 0.0):
            k = int(np.argmax(falls))
            raise ValueError(
                f"{table.place(k + 1)}: the velocity is {table.told(0, velocity[k + 1])} after "
                f"{table.told(0, velocity[k])}: velocities that rise from line to line are needed"
            )
        made = cls(velocity.tolist(), value.tolist())
        object.__setattr__(made, "_places", tuple(map(table.place, range(velocity.size))))
        return made

    def bracket(self, velocity: float) -> tuple[Any, Any, float]:
        """The two values around `velocity` [m/s] and the weight of the second."""
        upper, weight = self._around(velocity)
        return self.value[upper - 1], self.value[upper], weight

    def _around(self, velocity: float) -> tuple[int, float]:
        """The place of the first value beyond `velocity` [m/s], and its weight against the one before."""
        if not self.velocity[0] <= velocity <= self.velocity[-1]:
            raise ValueError(
                f"velocity is {velocity:g} m/s: the table covers "
                f"{self.velocity[0]:g} to {self.velocity[-1]:g} m/s{_SPEED if velocity < 0.0 else ''}"
            )
        upper = max(1, int(np.searchsorted(self.velocity, velocity)))
        low, high = self.velocity[upper - 1], self.velocity[upper]
        return upper, (velocity - low) / (high - low)

    def _name(self, name: str, k: int) -> str:
        """What messages call an entry, as part of what has this name."""
        place = f" ({self._places[k]})" if self._places else ""
        return f"{name} at {self.velocity[k]:.6g} m/s{place}"

    def values(self, asked: Asked) -> Array:
        """Values (n,) at the velocity, linear between those of the table."""
        if asked.velocity is None:
            raise ValueError(f"{asked.name} is a table over velocity: give velocity=... [m/s]")
        upper, weight = self._around(asked.velocity)
        first, second = (
            as_form(self.value[k]).values(replace(asked, name=self._name(asked.name, k)))
            for k in (upper - 1, upper)
        )
        return np.asarray((1.0 - weight) * first + weight * second)

    def leaves(self) -> list[Leaf] | None:
        """Those in its values."""
        return _leaves_of(self.value, lambda value: VelocityTable(self.velocity, value))

    @property
    def has_arrays(self) -> bool:
        """Whether one of its values has values on a grid in it."""
        return any(as_form(value).has_arrays for value in self.value)

    @property
    def has_places(self) -> bool:
        """Whether one of its values states places."""
        return any(as_form(value).has_places for value in self.value)

    def carried(self, choices: Sequence[tuple[Grids, Grids]]) -> VelocityTable:
        """The same table on other grids."""
        return VelocityTable(self.velocity, [as_form(value).carried(choices) for value in self.value])

    def placed(self, name: str) -> Iterator[tuple[str, float]]:
        """Those in its values."""
        for k, value in enumerate(self.value):
            yield from as_form(value).placed(self._name(name, k))

    def doubts(self, asked: Asked) -> Iterator[str]:
        """Those about its values."""
        for value in self.value:
            yield from as_form(value).doubts(asked)

    def tables(self) -> Iterator[VelocityTable]:
        """Itself, and those in its values."""
        yield self
        for value in self.value:
            yield from as_form(value).tables()


@dataclass(frozen=True)
@plain
class PressureDependentFriction(Form, Coefficients):
    """A friction coefficient that depends on the local pressure.

    Parameters
    ----------
    function : callable
        Friction coefficients [-] for an array of pressures [Pa], element by element.
    """

    function: Callable[[Array], ArrayLike]
    depends_on_pressure: ClassVar[bool] = True

    def __post_init__(self) -> None:
        if not callable(self.function):
            raise ValueError(f"function is {self.function!r}: a function of pressure (n,) [Pa] is needed")

    def at(self, pressure: Array) -> Array:
        """Friction coefficient (n,) at `pressure` (n,) [Pa], checked."""
        given = {"pressure": pressure}
        return _called("friction", self.function, given, "Pa", 0.0, LARGEST_FRICTION)

    def values(self, asked: Asked) -> Array:
        """It has none before the pressure is known, and so is no part of a list or a table."""
        raise ValueError(
            f"{asked.name} is {shortened(self)}: {_FORMS} is needed. A PressureDependentFriction is one "
            "for all contact points"
        )

    def coefficients(self, values: Callable[[], Array]) -> PressureDependentFriction:
        """Itself."""
        return self


@dataclass(frozen=True)
class _Listed(Form):
    """One entry for each pole, left first, or the values of an array."""

    parts: Sequence[Any]
    is_list: ClassVar[bool] = True

    def values(self, asked: Asked) -> Array:
        if not self._is_of(asked.patches):
            return _Values(self.parts).values(asked)
        out = np.empty(asked.points.shape[1])
        for patch, part in zip(asked.patches, self.parts, strict=True):
            out[patch.cut] = as_form(part).values(asked.on(patch))
        return out

    def leaves(self) -> list[Leaf] | None:
        return _leaves_of(self.parts, list)

    @property
    def has_arrays(self) -> bool:
        return any(form.is_list or form.has_arrays for form in map(as_form, self.parts))

    @property
    def has_places(self) -> bool:
        return any(form.has_places for form in map(as_form, self.parts))

    def carried(self, choices: Sequence[tuple[Grids, Grids]]) -> Any:
        if not self._is_of(choices[0][0]):
            return _Values(self.parts).carried(choices)
        own = [
            [((replace(given[k], start=0),), (replace(to[k], start=0),)) for given, to in choices]
            for k in range(len(self.parts))
        ]
        return [as_form(part).carried(pairs) for part, pairs in zip(self.parts, own, strict=True)]

    def placed(self, name: str) -> Iterator[tuple[str, float]]:
        for k, part in enumerate(self.parts):
            yield from as_form(part).placed(f"{name}[{k}]")

    def doubts(self, asked: Asked) -> Iterator[str]:
        if self._is_of(asked.patches):
            for patch, part in zip(asked.patches, self.parts, strict=True):
                yield from as_form(part).doubts(asked.on(patch))

    def tables(self) -> Iterator[VelocityTable]:
        return (table for part in self.parts for table in as_form(part).tables())

    def _is_of(self, patches: Grids) -> bool:
        return len(self.parts) == len(patches) > 1


@dataclass(frozen=True)
class _Function(Form):
    """A function of x and y [m]."""

    function: Callable[[Array, Array], ArrayLike]

    def values(self, asked: Asked) -> Array:
        x, y = asked.points[:2]
        return _called(asked.name, self.function, {"x": x, "y": y}, "m", asked.lowest, asked.highest)

    def carried(self, choices: Sequence[tuple[Grids, Grids]]) -> Any:
        return self.function


@dataclass(frozen=True)
class _Values(Form):
    """A number, an array over the grid, or what is none of the forms and is refused."""

    given: Any
    is_one: ClassVar[bool] = True

    def values(self, asked: Asked) -> Array:
        name, patches, n = asked.name, asked.patches, asked.points.shape[1]
        other = not np.ndim(self.given) and not isinstance(self.given, (int, float, np.number, np.ndarray))
        if other or isinstance(self.given, bool):
            laws = ". Laws of friction are for wheels, rolling and shifts" if name == "friction" else ""
            raise ValueError(f"{name} is {shortened(self.given)}: {_FORMS} is needed{laws}")
        values = reals(name, self.given)
        if values.ndim == 0:
            values = np.full(n, float(values))
        elif not fits(values, patches):
            listed = (
                f", or a list with {len(patches)} entries, one for each pole," if len(patches) > 1 else ""
            )
            raise ValueError(
                f"{name} has shape {values.shape}: a number or {_shapes(patches)}{listed} is needed"
            )
        else:
            values = values.reshape(-1) if asked.kept is None else values.reshape(-1)[asked.kept]
        return _within(name, values, asked.lowest, asked.highest)

    @property
    def has_arrays(self) -> bool:
        return isinstance(self.given, np.ndarray) and self.given.ndim > 0

    @property
    def number(self) -> float | None:
        return float(self.given) if isinstance(self.given, (int, float)) else None

    def leaves(self) -> list[Leaf] | None:
        return None if self.number is None else [Leaf(self.number, float)]

    def carried(self, choices: Sequence[tuple[Grids, Grids]]) -> Any:
        if not isinstance(self.given, (list, tuple, np.ndarray)):
            return self.given
        try:
            values = reals("values on a grid", self.given)
        except ValueError:  # for the field to name
            return self.given
        found = next(((given, to) for given, to in choices if fits(values, given)), None)
        if values.ndim == 0 or found is None:
            return self.given
        carried = np.empty(sum(patch.nx * patch.ny for patch in found[1]))
        for patch, here in zip(*found, strict=True):
            rows = np.minimum(((np.arange(here.ny) + 0.5) * patch.ny / here.ny).astype(int), patch.ny - 1)
            columns = np.minimum(((np.arange(here.nx) + 0.5) * patch.nx / here.nx).astype(int), patch.nx - 1)
            carried[here.cut] = patch.view(values.reshape(-1))[np.ix_(rows, columns)].ravel()
        return carried

    def placed(self, name: str) -> Iterator[tuple[str, float]]:
        if not isinstance(self.given, (int, float, np.ndarray, np.number)):
            return
        values = np.asarray(self.given)
        values = values[np.isfinite(values)] if values.dtype.kind in "fiu" else np.empty(0)
        if values.size:
            yield from ((name, float(values.min())), (name, float(values.max())))


def field(
    name: str,
    spec: Any,
    points: Array,
    patches: tuple[Patch, ...],
    velocity: float | None,
    lowest: float | None = None,
    highest: float = LARGEST,
    kept: NDArray[np.intp] | None = None,
) -> Array:
    """Values (n,) at the contact points of anything a user may state a field by.

    Parameters
    ----------
    spec
        A number, an array (n,) or of the grid's shape (ny, nx) or (poles, ny, nx), one entry per pole
        (list or tuple, left first), a callable of x and y [m], or a :class:`VelocityTable` of these.
    points : (3, n) [m]
    lowest, highest : float
        Smallest and largest value accepted.
    kept : (n,) int or None
        The contact points among those of the patches, where these are not all; arrays have a value for
        each of the latter.

    Raises
    ------
    ValueError
        Anything else, values that are not finite or out of range, arrays of another shape, functions that
        fail or give another length.
    """
    return as_form(spec).values(Asked(name, points, patches, velocity, lowest, highest, kept))


def numbers_in(spec: Any) -> Iterator[float]:
    """The numbers in a field as users state it; see :meth:`Form.numbers`."""
    return as_form(spec).numbers()


def check_friction(spec: Any) -> None:
    """Refuses numbers that are no coefficients of friction, before there are points."""
    nowhere = Asked("friction", np.empty((3, 0)), (), None, 0.0, LARGEST_FRICTION)
    nowhere.check_range(as_form(spec).placed("friction"))


def friction_field(
    spec: Any,
    points: Array,
    patches: tuple[Patch, ...],
    velocity: float | None,
    kept: NDArray[np.intp] | None = None,
) -> Array:
    """Friction coefficients (n,) at the contact points, as :func:`field`."""
    return field("friction", spec, points, patches, velocity, 0.0, LARGEST_FRICTION, kept)


_FORMS = (
    "a number, an array, one entry per pole, a callable of x and y, a table over x and y (FieldTable), or a "
    "table over velocity (VelocityTable)"
)

#: How to slide backwards, where a velocity is a speed; and what a table says to a negative one.
BACKWARDS = (
    "a scene slides backwards by sliding_direction=(-1, 0), steps of a prepared contact by a negative "
    "velocity"
)
_SPEED = f", and its velocity is a speed: {BACKWARDS}"


def extent(x: Array, y: Array) -> str:
    """The range of coordinates [m], for messages."""
    return f"x from {np.min(x):.6g} to {np.max(x):.6g} m and y from {np.min(y):.6g} to {np.max(y):.6g} m"


def fits(values: NDArray[Any], patches: tuple[Patch, ...]) -> bool:
    """Whether an array has a shape that gives each point of the patches its value."""
    return values.shape in _accepted(patches)


def _accepted(patches: tuple[Patch, ...]) -> list[tuple[int, ...]]:
    grids = {(p.ny, p.nx) for p in patches}
    shapes: list[tuple[int, ...]] = [(sum(p.nx * p.ny for p in patches),)]
    if len(grids) == 1:
        (grid,) = grids
        shapes.append(grid if len(patches) == 1 else (len(patches), *grid))
    return shapes


def _shapes(patches: tuple[Patch, ...]) -> str:
    named = [str(shape) for shape in _accepted(patches)]
    what = (
        "(n,)"
        if len(named) == 1
        else ("(n,) or (ny, nx)" if len(patches) == 1 else "(n,) or (poles, ny, nx)")
    )
    return f"an array {what} = {' or '.join(named)}"


def _called(
    name: str,
    function: Callable[..., ArrayLike],
    arguments: dict[str, Array],
    unit: str,
    lowest: float | None,
    highest: float,
) -> Array:
    """What a user's function gives for (n,) arguments [unit], checked."""
    given = tuple(arguments.values())
    n = given[0].size

    def at(k: int) -> str:
        return ", ".join(f"{word} = {values[k]:.6g} {unit}" for word, values in arguments.items())

    asked = " and ".join(
        f"{word} from {values.min():.6g} to {values.max():.6g} {unit}"
        for word, values in arguments.items()
        if n
    )
    try:
        result = function(*given)
    except Exception as error:
        k = _first_failing(function, given)
        place = "" if k is None else f" at {at(k)}"
        raise ValueError(
            f"{name} is a function that fails with {type(error).__name__}{place}: {error}; "
            f"a function of {' and '.join(arguments)} (n,) [{unit}] is needed"
            + (f", for {asked}" if place else "")
        ) from error
    try:
        values = reals(f"the result of the function for {name}", result)
    except ValueError as error:
        if is_quantity(result):
            raise
        rough = np.asarray(result)
        if rough.shape != (n,) or rough.dtype.kind != "f":
            raise
        k = int(np.argmax(~(np.abs(rough) <= LARGEST)))
        raise ValueError(f"{error}. It is so at {at(k)}; the function is asked for {asked}") from None
    if values.shape not in ((), (1,), (n,)):
        raise ValueError(
            f"the function for {name} gives an array of shape {values.shape}: "
            f"one number or shape ({n},) is needed"
        )
    return _within(name, np.array(np.broadcast_to(values, (n,))), lowest, highest, at)


def _first_failing(function: Callable[..., Any], given: tuple[Array, ...]) -> int | None:
    """A point at which a function of (n,) arguments fails; None if it fails everywhere, or nowhere alone."""

    def fails(start: int, stop: int) -> bool:
        try:
            function(*(values[start:stop] for values in given))
        except Exception:  # users' functions raise what they like
            return True
        return False

    start, stop = 0, given[0].size
    if not stop or all(fails(k, k + 1) for k in {0, stop // 2, stop - 1}):
        return None
    while stop - start > 1:
        middle = (start + stop) // 2
        if fails(start, middle):
            stop = middle
        elif fails(middle, stop):
            start = middle
        else:
            return None
    return start


def _needed(lowest: float | None, highest: float) -> str:
    return f"at most {highest:g}" if lowest is None else f"from {lowest:g} to {highest:g}"


def _within(
    name: str,
    values: Array,
    lowest: float | None,
    highest: float,
    place: Callable[[int], str] = "point {}".format,
) -> Array:
    bad = values > highest
    if lowest is not None:
        bad |= values < lowest
    if bad.any():
        at = int(np.argmax(bad))
        need = _needed(lowest, highest)
        raise ValueError(f"{name} is {values[at]:.6g} at {place(at)}: numbers {need} are needed")
    return values
