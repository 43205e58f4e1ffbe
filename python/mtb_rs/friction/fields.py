# SPDX-License-Identifier: MIT OR Apache-2.0
"""Friction and magnetic pressure: the forms that users may give, and fields over the contact points."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .. import _mtb_rs
from ..base.check import LARGEST, number, pair, path_of, positive, reals, shortened
from ..base.files import read_text
from ..base.owning import owning
from ..base.plain import plain
from ..geometry.contact_points import Patch

Array = NDArray[np.float64]

#: What files call the columns of a table over the velocity, and their units.
_COLUMNS = (["velocity", "speed", "v"], ["value"])
_SPEEDS = {"m/s": 1.0, "mm/s": 1e-3, "mph": 0.44704, "ft/s": 0.3048, "knots": 1852.0 / 3600.0}
_SPEEDS |= dict.fromkeys(("km/h", "kmh", "kph"), 1.0 / 3.6)
_VALUES = {"-": 1.0, "1": 1.0, "%": 1e-2, "Pa": 1.0, "kPa": 1e3, "MPa": 1e6, "GPa": 1e9, "bar": 1e5}
_VALUES |= {"N/m2": 1.0, "N/m²": 1.0, "N/mm2": 1e6, "N/mm²": 1e6}

#: No pair of bodies rubs more than this; what is larger is a slip of the pen.
LARGEST_FRICTION = 1e3


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


class Form(ABC):
    """A form in which users state a field over the contact points; :func:`as_form` finds it.

    A new form is one class that answers this.
    """

    #: Whether it is a list, of values or of forms.
    is_list: ClassVar[bool] = False
    #: Whether its values are known only with the pressure.
    depends_on_pressure: ClassVar[bool] = False

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

    def numbers(self) -> Iterator[float]:
        """The numbers in it: alone, in arrays (the least and the largest), in lists, as peaks, in tables."""
        return iter(())

    def tables(self) -> Iterator[VelocityTable]:
        """The tables in it."""
        return iter(())

    @property
    def has_arrays(self) -> bool:
        """Whether it has values on a grid in it."""
        return False

    @property
    def number(self) -> float | None:
        """The number that it is; None for all other forms."""
        return None

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
    """

    peak: float
    center: tuple[float, float]
    sigma: tuple[float, float]
    floor: float = 0.25

    def __post_init__(self) -> None:
        put = object.__setattr__
        put(self, "peak", number("peak", self.peak, "Pa"))
        put(self, "center", pair("center", self.center, "m"))
        put(self, "sigma", pair("sigma", self.sigma, "m"))
        for k, width in enumerate(self.sigma):
            positive(f"sigma[{k}]", width, "m")
        put(self, "floor", number("floor", self.floor))

    def __call__(self, x: Array, y: Array) -> Array:
        """Pressure [Pa] at x, y [m]."""
        (cx, cy), (sx, sy) = self.center, self.sigma
        hill = np.exp(-((x - cx) ** 2) / (2 * sx**2) - (np.abs(y) - cy) ** 2 / (2 * sy**2))
        return np.asarray(self.peak * (self.floor + (1.0 - self.floor) * hill))

    def values(self, asked: Asked) -> Array:
        """Values (n,) at the contact points."""
        return _Function(self).values(asked)

    def numbers(self) -> Iterator[float]:
        """Its peak."""
        return as_form(self.peak).numbers()


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
        if np.any(np.diff(speeds) <= 0.0):
            raise ValueError(f"velocity is {velocity}: finite numbers [m/s] that rise are needed")
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
        path = path_of("path", path)
        text = read_text(path, "table")
        try:
            velocity, value = _mtb_rs.read_columns(
                text, _COLUMNS, (list(_SPEEDS.items()), list(_VALUES.items()))
            )
        except ValueError as error:
            raise ValueError(f"table {path}, {error}") from None
        return cls(velocity.tolist(), value.tolist())

    def bracket(self, velocity: float) -> tuple[Any, Any, float]:
        """The two values around `velocity` [m/s] and the weight of the second."""
        if not self.velocity[0] <= velocity <= self.velocity[-1]:
            raise ValueError(
                f"velocity is {velocity:g} m/s: the table covers "
                f"{self.velocity[0]:g} to {self.velocity[-1]:g} m/s"
            )
        upper = max(1, int(np.searchsorted(self.velocity, velocity)))
        low, high = self.velocity[upper - 1], self.velocity[upper]
        return self.value[upper - 1], self.value[upper], (velocity - low) / (high - low)

    def values(self, asked: Asked) -> Array:
        """Values (n,) at the velocity, linear between those of the table."""
        if asked.velocity is None:
            raise ValueError(f"{asked.name} is a table over velocity: give velocity=... [m/s]")
        first, second, weight = self.bracket(asked.velocity)
        return (1.0 - weight) * as_form(first).values(asked) + weight * as_form(second).values(asked)

    @property
    def has_arrays(self) -> bool:
        """Whether one of its values has values on a grid in it."""
        return any(as_form(value).has_arrays for value in self.value)

    def carried(self, choices: Sequence[tuple[Grids, Grids]]) -> VelocityTable:
        """The same table on other grids."""
        return VelocityTable(self.velocity, [as_form(value).carried(choices) for value in self.value])

    def numbers(self) -> Iterator[float]:
        """Those in its values."""
        return (number for value in self.value for number in as_form(value).numbers())

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
        return _called("friction", self.function, (pressure,), "pressure (n,) [Pa]", 0.0, LARGEST_FRICTION)

    def values(self, asked: Asked) -> Array:
        """It has none before the pressure is known."""
        return _Values(self).values(asked)

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
            here = replace(
                asked,
                name=f"{asked.name}[{patch.name}]",
                points=asked.points[:, patch.cut],
                patches=(replace(patch, start=0),),
                kept=None,
            )
            out[patch.cut] = as_form(part).values(here)
        return out

    @property
    def has_arrays(self) -> bool:
        return any(form.is_list or form.has_arrays for form in map(as_form, self.parts))

    def carried(self, choices: Sequence[tuple[Grids, Grids]]) -> Any:
        if not self._is_of(choices[0][0]):
            return _Values(self.parts).carried(choices)
        own = [
            [((replace(given[k], start=0),), (replace(to[k], start=0),)) for given, to in choices]
            for k in range(len(self.parts))
        ]
        return [as_form(part).carried(pairs) for part, pairs in zip(self.parts, own, strict=True)]

    def numbers(self) -> Iterator[float]:
        return (number for part in self.parts for number in as_form(part).numbers())

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
        return _called(asked.name, self.function, (x, y), "x and y (n,) [m]", asked.lowest, asked.highest)

    def carried(self, choices: Sequence[tuple[Grids, Grids]]) -> Any:
        return self.function


@dataclass(frozen=True)
class _Values(Form):
    """A number, an array over the grid, or what is none of the forms and is refused."""

    given: Any

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

    def numbers(self) -> Iterator[float]:
        if not isinstance(self.given, (int, float, np.ndarray, np.number)):
            return
        values = np.asarray(self.given)
        values = values[np.isfinite(values)] if values.dtype.kind in "fiu" else np.empty(0)
        if values.size:
            yield from (float(values.min()), float(values.max()))


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
    for value in numbers_in(spec):
        if not 0.0 <= value <= LARGEST_FRICTION:
            raise ValueError(f"friction is {value:.6g}: numbers from 0 to {LARGEST_FRICTION:g} are needed")


def friction_field(
    spec: Any,
    points: Array,
    patches: tuple[Patch, ...],
    velocity: float | None,
    kept: NDArray[np.intp] | None = None,
) -> Array:
    """Friction coefficients (n,) at the contact points, as :func:`field`."""
    return field("friction", spec, points, patches, velocity, 0.0, LARGEST_FRICTION, kept)


_FORMS = "a number, an array, one entry per pole, a callable of x and y, or a table over velocity"


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
    arguments: tuple[Array, ...],
    of: str,
    lowest: float | None,
    highest: float,
) -> Array:
    """What a user's function gives for (n,) arguments, checked."""
    n = arguments[0].size
    try:
        given = function(*arguments)
    except Exception as error:
        raise ValueError(
            f"{name} is a function that fails with {type(error).__name__}: {error}; "
            f"a function of {of} is needed"
        ) from error
    values = reals(f"the result of the function for {name}", given)
    if values.shape not in ((), (1,), (n,)):
        raise ValueError(
            f"the function for {name} gives an array of shape {values.shape}: "
            f"one number or shape ({n},) is needed"
        )
    return _within(name, np.array(np.broadcast_to(values, (n,))), lowest, highest)


def _within(name: str, values: Array, lowest: float | None, highest: float) -> Array:
    bad = values > highest
    if lowest is not None:
        bad |= values < lowest
    if bad.any():
        at = int(np.argmax(bad))
        need = f"at most {highest:g}" if lowest is None else f"from {lowest:g} to {highest:g}"
        raise ValueError(f"{name} is {values[at]:.6g} at point {at}: numbers {need} are needed")
    return values
